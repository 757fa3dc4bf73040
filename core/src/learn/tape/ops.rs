//! All operations, and the tape that records them.
//!
//! To add one: a struct with [`Operation`] in a file here, a line in `operations!`, an entry in the table of finite differences.

use super::affine::Affine;
use super::angles::Angles;
use super::cosine::Cosine;
use super::distortion::{Barrier, Hinge, Scale};
use super::eigenvalues::Eigenvalues;
use super::gap::{JacobianGap, MeanSquare};
use super::means::{MeanAbs, WeightedMean};
use super::nearest::Nearest;
use super::normalise::Normalise;
use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::repel::Repel;
use super::seam::{Reach, Seam};
use super::shape::{Add, Concat, Slice};
use super::var::Var;
use crate::base::scratch::ScratchTooSmall;
use crate::learn::kernels::float::Float;

/// A recorded graph of any operations.
pub type Tape = Recording<Op>;

macro_rules! operations {
    ($($name:ident),*) => {
        /// Any operation.
        #[derive(Clone, Copy, Debug)]
        #[allow(missing_docs)]
        pub enum Op {
            $($name($name)),*
        }

        $(impl From<$name> for Op {
            fn from(operation: $name) -> Op {
                Op::$name(operation)
            }
        })*

        /// The name of every operation, for the completeness of the table of finite differences.
        pub const OPERATIONS: &[&str] = &[$(stringify!($name)),*];

        impl Op {
            /// Its name in [`OPERATIONS`].
            pub fn name(&self) -> &'static str {
                match self { $(Op::$name(_) => stringify!($name)),* }
            }

        }

        impl Operation for Op {
            fn output(&self) -> Var {
                match self { $(Op::$name(o) => o.output()),* }
            }

            fn inputs(&self) -> [Option<Var>; 3] {
                match self { $(Op::$name(o) => o.inputs()),* }
            }

            fn sets_fresh(&self) -> bool {
                match self { $(Op::$name(o) => o.sets_fresh()),* }
            }

            fn scratch<T: Float>(&self) -> usize {
                match self { $(Op::$name(o) => o.scratch::<T>()),* }
            }

            fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
                match self { $(Op::$name(o) => o.forward(run)),* }
            }

            fn backward<T: Float>(&self, run: &mut Replay<T>, fresh: [bool; 3]) -> Result<(), ScratchTooSmall> {
                match self { $(Op::$name(o) => o.backward(run, fresh)),* }
            }
        }
    };
}

operations!(
    Affine,
    Concat,
    Add,
    Slice,
    Normalise,
    Nearest,
    Cosine,
    Repel,
    MeanAbs,
    Eigenvalues,
    Angles,
    Reach,
    Seam,
    WeightedMean,
    Scale,
    Hinge,
    Barrier,
    JacobianGap,
    MeanSquare
);
