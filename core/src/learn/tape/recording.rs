//! A graph of operations, recorded once and replayed forward and backward; it knows of operations only what [`Operation`] says.

use super::operation::{Operation, Replay};
use super::var::{Table, Var};
use crate::base::scratch::ScratchTooSmall;
use crate::learn::kernels::float::Float;

/// Operations of a tape at the most; the whole backbone takes about 100.
pub const MAX_OPERATIONS: usize = 192;
/// Values of a tape at the most.
pub const MAX_VARS: usize = 320;

/// A recorded graph.
pub struct Recording<O> {
    steps: [Option<(O, u32)>; MAX_OPERATIONS],
    step_count: usize,
    vars: u16,
    values: usize,
    indices: usize,
    group: u32,
}

impl<O: Operation + Copy> Default for Recording<O> {
    fn default() -> Self {
        Self { steps: [None; MAX_OPERATIONS], step_count: 0, vars: 0, values: 0, indices: 0, group: 1 }
    }
}

impl<O: Operation + Copy> Recording<O> {
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

    pub(super) fn output(&mut self, rows: usize, columns: usize, inputs: &[Var]) -> Var {
        self.var(rows, columns, inputs.iter().any(|x| x.has_gradient))
    }

    pub(super) fn push(&mut self, op: impl Into<O>) -> Var {
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

    fn steps(&self) -> impl DoubleEndedIterator<Item = &(O, u32)> {
        self.steps[..self.step_count].iter().flatten()
    }

    /// The operations, in the order of recording.
    pub fn operations(&self) -> impl Iterator<Item = &O> {
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
        let mut reached = ReachedVars::default();
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
struct ReachedVars([u64; MAX_VARS / 64]);

impl ReachedVars {
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
