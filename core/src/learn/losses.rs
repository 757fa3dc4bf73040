//! All losses of the learned map on one tape (their formulas: docs/METHODS.md), for a batch of points.
//!
//! A batch has `points` rows that every loss looks at and, behind them, further rows that only local losses need: ring
//! neighbours of the first `scored` points, and corners of `faces`. With all vertices in the batch there are none of these.
//! Each operation is recorded for the set of losses that need it, so a loss that is off costs nothing.
//! To add a loss: a variant of [`Loss`], its weight in [`LossWeights`], its operations in [`LossGraph::record`].
//! The radius of repulsion is `spread` x 2/(side - 1): 0.25 in the published training, 1 in the reference values.

use super::backbone::{Backbone, Widths};
use super::kernels::float::Float;
use super::tape::distortion::REST;
use super::tape::ops::Tape;
use super::tape::seam::NEIGHBOURS as SEAM_NEIGHBOURS;
use super::tape::var::{Table, Var};

/// One term of the objective.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// Phat and P cover each other.
    Wrap,
    /// Nhat agrees with the normal at the nearest point.
    WrapNormals,
    /// Points of the map keep apart.
    Repel,
    /// Both cycles come back.
    CyclePoints,
    /// Normals come back.
    CycleNormals,
    /// The map is conformal where Wrap is differentiated.
    Differential,
    /// Angles of faces.
    Triangle,
    /// Seams lie where exposure is low.
    Visibility,
    /// No face folds or loses its area. Ours, not published.
    Fold,
    /// Symmetric Dirichlet energy. Ours, not published.
    Distortion,
}

impl Loss {
    /// Every loss, in the order of all arrays of losses.
    pub const ALL: [Loss; 10] = [
        Loss::Wrap,
        Loss::WrapNormals,
        Loss::Repel,
        Loss::CyclePoints,
        Loss::CycleNormals,
        Loss::Differential,
        Loss::Triangle,
        Loss::Visibility,
        Loss::Fold,
        Loss::Distortion,
    ];

    /// A short name for reports and settings files.
    pub fn name(self) -> &'static str {
        match self {
            Loss::Wrap => "wrap",
            Loss::WrapNormals => "wrap_normals",
            Loss::Repel => "repel",
            Loss::CyclePoints => "cycle_points",
            Loss::CycleNormals => "cycle_normals",
            Loss::Differential => "differential",
            Loss::Triangle => "triangle",
            Loss::Visibility => "visibility",
            Loss::Fold => "fold",
            Loss::Distortion => "distortion",
        }
    }

    /// Its bit in a set of losses.
    pub const fn bit(self) -> u32 {
        1 << self as u32
    }

    /// Whether it is looked at every fifth step only.
    pub fn is_rare(self) -> bool {
        matches!(self, Loss::Differential | Loss::Triangle)
    }
}

/// A value for each loss, in the order of [`Loss::ALL`].
pub type PerLoss<T> = [T; Loss::ALL.len()];

/// Weight of each loss; 0 turns it off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LossWeights(pub PerLoss<f64>);

impl LossWeights {
    /// The published weights.
    pub const PUBLISHED: Self = Self([1.0, 0.0, 0.01, 0.01, 0.005, 0.01, 1e-5, 0.004, 0.0, 0.0]);

    /// The same with another weight of `loss`.
    pub fn with(mut self, loss: Loss, weight: f64) -> Self {
        self.0[loss as usize] = weight;
        self
    }

    /// Whether a loss is on that needs the corners of faces.
    pub fn look_at_faces(&self) -> bool {
        [Loss::Triangle, Loss::Fold, Loss::Distortion].into_iter().any(|loss| self.0[loss as usize] != 0.0)
    }

    /// The losses that take part in step number `step`.
    pub fn active(&self, step: usize) -> u32 {
        let is_on = |loss: &&Loss| self.0[**loss as usize] != 0.0 && (!loss.is_rare() || step.is_multiple_of(RARE));
        Loss::ALL.iter().filter(is_on).fold(0, |set, loss| set | loss.bit())
    }
}

/// Steps between two looks at a rare loss, as published.
pub const RARE: usize = 5;

/// How a batch is made up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Points that every loss looks at.
    pub points: usize,
    /// Further rows behind them.
    pub further: usize,
    /// Side of the lattice.
    pub side: usize,
    /// Points with seam scores: the first ones.
    pub scored: usize,
    /// Faces whose corners are rows of the batch.
    pub faces: usize,
}

/// The least square lattice of at least `points` points.
pub fn lattice_side(points: usize) -> usize {
    let root = points.isqrt();
    if root * root < points { root + 1 } else { root }
}

/// The recorded losses of a batch.
pub struct LossGraph {
    /// Everything that is replayed.
    pub tape: Tape,
    /// The weights.
    pub backbone: Backbone,
    /// How the batch is made up.
    pub sizes: Sizes,
    /// Positions (points + further, 3), to be filled.
    pub positions: Var,
    /// Normals (points, 3), to be filled.
    pub normals: Var,
    /// Exposure (scored, 1), to be filled.
    pub exposure: Var,
    /// Ring neighbours (scored, 5): rows or `NONE`, to be filled.
    pub ring: Table,
    /// Faces (faces, 3): rows, to be filled.
    pub faces: Table,
    /// Corner cosines in space (faces, 3), to be filled.
    pub cosines: Var,
    /// Rest shape of faces (faces, 5), areas summing to 1, to be filled.
    pub rest: Var,
    /// The lattice (side^2, 2); [`LossGraph::fill_constants`].
    pub grid: Var,
    /// Unit tangents (2 points, 2); [`LossGraph::fill_constants`].
    pub units: Var,
    /// Q (points + further, 2).
    pub q: Var,
    /// norm(Q).
    pub q_normalised: Var,
    /// Point and normal of the cycle (points, 6).
    pub cycle: Var,
    /// Qhat (side^2, 2).
    pub q_hat: Var,
    /// Phat, Nhat (side^2, 6).
    pub wrapped: Var,
    /// Qhat_cycle (side^2, 2).
    pub q_hat_cycle: Var,
    /// Columns of the Jacobians (2 points, 3).
    pub tangents: Var,
    /// Reach (scored, 1).
    pub reach: Var,
    /// Seam scores (scored, 1).
    pub scores: Var,
    /// Each loss. Repulsion is the sum of three values, the cycle of points of two.
    pub losses: PerLoss<[Option<Var>; 3]>,
}

const REPELLED: u32 = Loss::Repel.bit();
const LATTICE: u32 = Loss::Wrap.bit() | Loss::WrapNormals.bit() | REPELLED | Loss::CyclePoints.bit();
const CYCLE: u32 = Loss::CyclePoints.bit() | Loss::CycleNormals.bit() | Loss::Differential.bit();
const SCALED: u32 = Loss::Fold.bit() | Loss::Distortion.bit();
const MAP: u32 = CYCLE | REPELLED | Loss::Triangle.bit() | Loss::Visibility.bit() | SCALED;

/// The losses that look at faces and at neighbours in a ring.
struct LocalLosses {
    triangle: Var,
    reach: Var,
    scores: Var,
    visibility: Var,
    fold: Var,
    distortion: Var,
}

impl LocalLosses {
    /// Of the map q and its normalised form, with the tables and inputs of [`LossGraph`].
    fn record(
        t: &mut Tape,
        [q, q_normalised]: [Var; 2],
        [faces, ring]: [Table; 2],
        [cosines, rest, exposure]: [Var; 3],
        margin: f64,
    ) -> Self {
        t.set_group(Loss::Triangle.bit());
        let triangle = t.angles(q, faces, cosines);
        t.set_group(Loss::Visibility.bit());
        let reach = t.reach(q_normalised, ring);
        let scores = t.seam(reach, q_normalised);
        let visibility = t.weighted_mean(scores, exposure);
        t.set_group(SCALED);
        let scale = t.scale(q, faces, rest);
        t.set_group(Loss::Fold.bit());
        let fold = t.hinge(q, faces, rest, scale, margin);
        t.set_group(Loss::Distortion.bit());
        let distortion = t.barrier(q, faces, rest, scale);
        Self { triangle, reach, scores, visibility, fold, distortion }
    }
}

impl LossGraph {
    /// Records networks of `widths` and all losses over a batch; `spread` is the radius of repulsion in lattice steps,
    /// `margin` the share of the mean area ratio that a face should keep.
    pub fn record(widths: Widths, sizes: Sizes, spread: f64, margin: f64) -> Self {
        let Sizes { points: n, further, side, scored, faces: face_count } = sizes;
        let mut tape = Tape::new();
        let t = &mut tape;
        let backbone = Backbone::record(t, widths);
        let (positions, normals) = (t.input(n + further, 3), t.input(n, 3));
        let (grid, units) = (t.input(side * side, 2), t.input(2 * n, 2));
        let (exposure, ring) = (t.input(scored, 1), t.table(scored * SEAM_NEIGHBOURS));
        let (faces, cosines, rest) = (t.table(face_count * 3), t.input(face_count, 3), t.input(face_count, REST));

        t.set_group(MAP | LATTICE);
        let p = if further == 0 { positions } else { t.slice(positions, (0, 0), (n, 3)) };
        t.set_group(MAP);
        let q = backbone.unwrap(t, positions);
        let q_points = if further == 0 { q } else { t.slice(q, (0, 0), (n, 2)) };
        t.set_group(REPELLED | Loss::Visibility.bit());
        let q_normalised = t.normalise(q);

        t.set_group(CYCLE);
        let wrapped_q = backbone.wrap(t, q_points);
        let cycle = wrapped_q.output;
        t.set_group(Loss::CyclePoints.bit());
        let p_cycle = t.slice(cycle, (0, 0), (n, 3));
        let cycle_3d = t.mean_abs(p_cycle, p);
        t.set_group(Loss::CycleNormals.bit());
        let n_cycle = t.slice(cycle, (0, 3), (n, 3));
        let cycle_normals = t.cosine(n_cycle, normals, None);
        t.set_group(Loss::Differential.bit());
        let tangents = backbone.wrap_tangents(t, wrapped_q, units);
        let differential = t.eigenvalues(tangents);

        t.set_group(LATTICE);
        let q_hat = backbone.deform(t, grid);
        let wrapped = backbone.wrap(t, q_hat).output;
        let p_hat = t.slice(wrapped, (0, 0), (side * side, 3));
        t.set_group(Loss::Wrap.bit() | Loss::WrapNormals.bit());
        let (wrap, nearest) = t.nearest(p_hat, p);
        t.set_group(Loss::WrapNormals.bit());
        let n_hat = t.slice(wrapped, (0, 3), (side * side, 3));
        let wrap_normals = t.cosine(n_hat, normals, Some(nearest));
        t.set_group(REPELLED | Loss::CyclePoints.bit());
        let q_hat_cycle = backbone.unwrap(t, p_hat);
        t.set_group(Loss::CyclePoints.bit());
        let cycle_2d = t.mean_abs(q_hat_cycle, q_hat);

        t.set_group(REPELLED);
        let radius = spread * 2.0 / side.saturating_sub(1).max(1) as f64;
        let apart = if further == 0 { q_normalised } else { t.slice(q_normalised, (0, 0), (n, 2)) };
        let lattices = [q_hat, q_hat_cycle].map(|q| t.normalise(q));
        let repel = [apart, lattices[0], lattices[1]].map(|q| Some(t.repel(q, radius)));

        let local = LocalLosses::record(t, [q, q_normalised], [faces, ring], [cosines, rest, exposure], margin);
        let LocalLosses { reach, scores, .. } = local;

        let alone = |y| [Some(y), None, None];
        let losses = [
            alone(wrap),
            alone(wrap_normals),
            repel,
            [Some(cycle_3d), Some(cycle_2d), None],
            alone(cycle_normals),
            alone(differential),
            alone(local.triangle),
            alone(local.visibility),
            alone(local.fold),
            alone(local.distortion),
        ];
        #[rustfmt::skip]
        let graph = Self {
            tape, backbone, sizes, positions, normals, exposure, ring, faces, cosines, rest, grid, units, q, q_normalised,
            cycle, q_hat, wrapped, q_hat_cycle, tangents, reach, scores, losses,
        };
        graph
    }

    /// Writes the lattice on [-1, 1]^2, first coordinate slowest, and the unit tangents.
    pub fn fill_constants<T: Float>(&self, values: &mut [T]) {
        let side = self.sizes.side;
        let at = |i: usize| T::of(if side > 1 { 2.0 * i as f64 / (side - 1) as f64 - 1.0 } else { 0.0 });
        let lattice = (0..side).flat_map(|i| (0..side).map(move |j| (i, j)));
        for (row, (i, j)) in self.grid.of_mut(values).as_chunks_mut::<2>().0.iter_mut().zip(lattice) {
            *row = [at(i), at(j)];
        }
        for (i, row) in self.units.of_mut(values).as_chunks_mut::<2>().0.iter_mut().enumerate() {
            let is_first = i < self.sizes.points;
            (row[0], row[1]) = if is_first { (T::ONE, T::ZERO) } else { (T::ZERO, T::ONE) };
        }
    }

    /// The value of each loss after a forward replay; those that took no part are stale.
    pub fn values<T: Float>(&self, values: &[T]) -> PerLoss<f64> {
        self.losses.map(|parts| parts.into_iter().flatten().map(|part| part.of(values)[0].wide()).sum())
    }

    /// What backward begins with: each active loss's parts with its weight.
    pub fn seeds(&self, weights: &LossWeights, active: u32) -> heapless::Vec<(Var, f64), { 3 * Loss::ALL.len() }> {
        let on = Loss::ALL.into_iter().filter(|loss| loss.bit() & active != 0);
        let parts = on.flat_map(|loss| {
            self.losses[loss as usize].into_iter().flatten().map(move |part| (part, weights.0[loss as usize]))
        });
        let mut seeds = heapless::Vec::new();
        parts.for_each(|seed| _ = seeds.push(seed));
        seeds
    }
}
