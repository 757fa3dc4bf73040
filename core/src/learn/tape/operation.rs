//! One kind of node of the graph, and what a replay of it works on.

use super::var::Var;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;
use crate::learn::kernels::float::Float;
use crate::learn::kernels::path::Path;

/// What a replay works on.
pub struct Replay<'a, 's, T> {
    /// Values of every Var ([`super::recording::Recording::value_count`]).
    pub values: &'a mut [T],
    /// Gradients, laid out alike.
    pub gradients: &'a mut [T],
    /// Every table ([`super::recording::Recording::index_count`]).
    pub indices: &'a mut [u32],
    /// Memory for one operation at a time ([`super::recording::Recording::scratch_need`]).
    pub scratch: Scratch<'s>,
    /// How products are computed; no influence on the result.
    pub path: Path,
    /// Who runs independent tasks.
    pub workers: &'a dyn Workers,
}

/// One kind of node of the graph.
pub trait Operation {
    /// Whether backward itself says what a fresh gradient begins with, instead of finding zeros there.
    fn sets_fresh(&self) -> bool {
        false
    }

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
