//! Reverse-mode tape: a static graph, recorded once, replayed forward and backward without allocation or recursion.
//!
//! Values and gradients lie in two slices of the caller, laid out while recording; parameters come first where they are
//! recorded first. Every operation is a struct with its forward and backward side by side ([`Operation`]) and an entry in
//! the finite-difference table of `difference_tests.rs`, whose completeness a test asserts.
//! An operation's output lies behind its inputs, so one split of the slice separates what is read from what is written.
//! Backward begins at seeds (output, weight). A gradient that nothing has reached is neither read nor cleared: whole
//! branches cost nothing when their seed is missing. Generic over [`Float`]: f32 trains, f64 checks.
//!
//! To add an operation: a struct with [`Operation`] in a file here, a line in `operations!`, an entry in the table.
//! Limits: [`MAX_OPERATIONS`] and [`MAX_VARS`]; recording beyond them is a mistake of our own code, an index out of bounds.
//! Shapes that do not agree are one too: which there are depends on settings alone, so debug builds check them.

mod affine;
mod angles;
mod cosine;

mod case_tests;
mod difference_tests;
mod distortion;
mod eigenvalues;
mod means;
mod nearest;
mod normalise;
mod repel;
mod replay_tests;
mod seam;
mod shape;

use super::kernels::{Float, Path};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;
pub use affine::{Activation, Affine};
pub use angles::{Angles, cosines};
pub use cosine::Cosine;
pub use distortion::{Barrier, Hinge, REST, Scale, rest_of};
pub use eigenvalues::Eigenvalues;
pub use means::{MeanAbs, WeightedMean};
pub use nearest::Nearest;
pub use normalise::Normalise;
pub use repel::Repel;
pub use seam::{NEIGHBOURS as SEAM_NEIGHBOURS, Reach, Seam};
pub use shape::{Add, Concat, Slice};

/// Operations of a tape at the most; the whole backbone takes about 100.
pub const MAX_OPERATIONS: usize = 192;
/// Values of a tape at the most.
pub const MAX_VARS: usize = 320;

/// Entry of a table that names no row: a missing neighbour.
pub const NONE: u32 = u32::MAX;

/// A matrix of values, row after row, and its gradient at the same place of the other slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Var {
    id: u16,
    has_gradient: bool,
    at: usize,
    /// Rows, one a point.
    pub rows: usize,
    /// Values of a row.
    pub columns: usize,
}

impl Var {
    /// Number of values.
    pub fn count(self) -> usize {
        self.rows * self.columns
    }

    /// Where its values lie in the slice of values or gradients.
    pub fn range(self) -> core::ops::Range<usize> {
        self.at..self.at + self.count()
    }

    /// Its part of `slice`.
    pub fn of<T>(self, slice: &[T]) -> &[T] {
        &slice[self.range()]
    }

    /// Its part of `slice`, to be written.
    pub fn of_mut<T>(self, slice: &mut [T]) -> &mut [T] {
        &mut slice[self.range()]
    }

    /// All that lies before it, and its own part, to be written.
    fn split<T>(self, slice: &mut [T]) -> (&mut [T], &mut [T]) {
        let (before, rest) = slice.split_at_mut_checked(self.at).unwrap_or_default();
        (before, &mut rest[..self.count()])
    }
}

/// A stretch of the slice of indices: faces, neighbours, or what forward found out for backward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Table {
    at: usize,
    len: usize,
}

impl Table {
    /// Its part of the indices.
    pub fn of(self, indices: &[u32]) -> &[u32] {
        &indices[self.at..self.at + self.len]
    }

    /// Its part of the indices, to be written.
    pub fn of_mut(self, indices: &mut [u32]) -> &mut [u32] {
        &mut indices[self.at..self.at + self.len]
    }
}

/// What a replay works on.
pub struct Replay<'a, 's, T> {
    /// Values of every Var ([`Tape::value_count`]).
    pub values: &'a mut [T],
    /// Gradients, laid out alike.
    pub gradients: &'a mut [T],
    /// Every table ([`Tape::index_count`]).
    pub indices: &'a mut [u32],
    /// Memory for one operation at a time ([`Tape::scratch_need`]).
    pub scratch: Scratch<'s>,
    /// How products are computed; no influence on the result.
    pub path: Path,
    /// Who runs independent tasks.
    pub workers: &'a dyn Workers,
}

/// One kind of node of the graph.
pub trait Operation {
    /// Whether backward itself says what a fresh gradient begins with, instead of finding zeros there.
    const SETS_FRESH: bool = false;

    /// The value that it makes.
    fn output(&self) -> Var;

    /// The values that gradients flow back to.
    fn inputs(&self) -> [Option<Var>; 3];

    /// Bytes of scratch memory that it takes.
    fn scratch<T: Float>(&self) -> usize {
        0
    }

    /// Fills the output's values.
    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall>;

    /// Adds to the inputs' gradients what the output's gradient sends them. `fresh` tells of each input whether nothing
    /// has been added to it yet.
    fn backward<T: Float>(&self, run: &mut Replay<T>, fresh: [bool; 3]) -> Result<(), ScratchTooSmall>;
}

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

            fn output(&self) -> Var {
                match self { $(Op::$name(o) => o.output()),* }
            }

            fn inputs(&self) -> [Option<Var>; 3] {
                match self { $(Op::$name(o) => o.inputs()),* }
            }

            fn sets_fresh(&self) -> bool {
                match self { $(Op::$name(_) => $name::SETS_FRESH),* }
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
    Barrier
);

/// A recorded graph.
pub struct Tape {
    steps: [Option<(Op, u32)>; MAX_OPERATIONS],
    step_count: usize,
    vars: u16,
    values: usize,
    indices: usize,
    group: u32,
}

impl Default for Tape {
    fn default() -> Self {
        Self { steps: [None; MAX_OPERATIONS], step_count: 0, vars: 0, values: 0, indices: 0, group: 1 }
    }
}

impl Tape {
    /// An empty graph.
    pub fn new() -> Self {
        Self::default()
    }

    /// Operations recorded from now on belong to `group` (one bit): replays name the groups that take part.
    pub fn set_group(&mut self, group: u32) {
        self.group = group;
    }

    fn var(&mut self, rows: usize, columns: usize, has_gradient: bool) -> Var {
        debug_assert!((self.vars as usize) < MAX_VARS, "a tape holds {MAX_VARS} values at the most");
        let var = Var { id: self.vars, has_gradient, at: self.values, rows, columns };
        self.vars += 1;
        self.values = self.values.saturating_add(rows.saturating_mul(columns));
        var
    }

    /// A value that is learned: gradients flow to it.
    pub fn parameter(&mut self, rows: usize, columns: usize) -> Var {
        self.var(rows, columns, true)
    }

    /// A value that the caller fills: no gradient.
    pub fn input(&mut self, rows: usize, columns: usize) -> Var {
        self.var(rows, columns, false)
    }

    /// A table of `len` indices.
    pub fn table(&mut self, len: usize) -> Table {
        let table = Table { at: self.indices, len };
        self.indices += len;
        table
    }

    fn output(&mut self, rows: usize, columns: usize, inputs: &[Var]) -> Var {
        self.var(rows, columns, inputs.iter().any(|x| x.has_gradient))
    }

    fn push(&mut self, op: impl Into<Op>) -> Var {
        let op = op.into();
        let output = op.output();
        self.steps[self.step_count] = Some((op, self.group));
        self.step_count += 1;
        output
    }

    /// Length of the slices of values and gradients.
    pub fn value_count(&self) -> usize {
        self.values
    }

    /// Length of the slice of indices.
    pub fn index_count(&self) -> usize {
        self.indices
    }

    /// Bytes of scratch memory of a replay.
    pub fn scratch_need<T: Float>(&self) -> usize {
        self.operations().map(|op| op.scratch::<T>()).max().unwrap_or(0)
    }

    fn steps(&self) -> impl DoubleEndedIterator<Item = &(Op, u32)> {
        self.steps[..self.step_count].iter().flatten()
    }

    /// The operations, in the order of recording.
    pub fn operations(&self) -> impl Iterator<Item = &Op> {
        self.steps().map(|(op, _)| op)
    }

    /// Computes the values of all operations whose group is in `groups`.
    pub fn forward<T: Float>(&self, run: &mut Replay<T>, groups: u32) -> Result<(), ScratchTooSmall> {
        self.steps().filter(|(_, group)| group & groups != 0).try_for_each(|(op, _)| op.forward(run))
    }

    /// Gradients of the sum of weight x output over `seeds` (outputs of one value each), for all parameters and every
    /// value on the way. Operations outside `groups` and those that no seed depends on are left out; the gradient of a
    /// value that nothing reached keeps what stood there, unless it is in `parameters`: those become zero.
    pub fn backward<T: Float>(
        &self,
        run: &mut Replay<T>,
        seeds: &[(Var, f64)],
        groups: u32,
        parameters: &[Var],
    ) -> Result<(), ScratchTooSmall> {
        let mut reached = Reached::default();
        for (var, weight) in seeds.iter().filter(|(var, _)| var.has_gradient) {
            let was_fresh = reached.add(*var);
            let gradient = var.of_mut(run.gradients);
            let begin = if was_fresh { T::ZERO } else { gradient[0] };
            gradient[0] = begin + T::of(*weight);
        }
        for (op, group) in self.steps().rev() {
            if group & groups == 0 || !reached.has(op.output()) {
                continue;
            }
            let inputs = op.inputs().map(|x| x.filter(|x| x.has_gradient));
            let fresh = inputs.map(|x| x.is_some_and(|x| reached.add(x)));
            if !op.sets_fresh() {
                for (x, _) in inputs.iter().zip(fresh).filter(|(_, is_fresh)| *is_fresh) {
                    x.iter().for_each(|x| x.of_mut(run.gradients).fill(T::ZERO));
                }
            }
            op.backward(run, fresh)?;
        }
        parameters.iter().filter(|p| !reached.has(**p)).for_each(|p| p.of_mut(run.gradients).fill(T::ZERO));
        Ok(())
    }
}

/// Vars whose gradient holds something.
#[derive(Default)]
struct Reached([u64; MAX_VARS / 64]);

impl Reached {
    fn has(&self, var: Var) -> bool {
        self.0[var.id as usize / 64] >> (var.id % 64) & 1 != 0
    }

    /// Marks `var`; true where it was not marked before.
    fn add(&mut self, var: Var) -> bool {
        let is_fresh = !self.has(var);
        self.0[var.id as usize / 64] |= 1 << (var.id % 64);
        is_fresh
    }
}
