//! Where the nodes of the mesh go on the atlas: their closest places, then the best fit of the whole surface.
//!
//! Every face asks the atlas about its corners and about [`SAMPLES`] points inside. Nodes then move to the least squares of
//!     sum over samples of area |x(sample) - uv(sample)|^2 + HOLD sum over nodes of area |x - uv(node)|^2,
//! by sweeps that divide by lumped masses: the matrix is well-conditioned. Samples beyond the chart's border do not count, so
//! that a face which crosses the border is carried on straight. Where the mesh's vertices lie on the atlas and its edges cross
//! none of the atlas' edges, nothing moves. Cost: O(f) and the walks.

use super::sheets::{Sheets, area};
use super::source::{SourceAtlas, Target, Walking};
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::mesh::view::MeshView;
use bytemuck::{Pod, Zeroable};
use glam::DVec2;

/// Points inside a face.
const SAMPLES: usize = 6;
/// Their weights: two rings of three.
const INSIDE: [[f64; 3]; SAMPLES] =
    [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8], [0.45, 0.45, 0.1], [0.45, 0.1, 0.45], [0.1, 0.45, 0.45]];
/// Weight of a node's own place over that of its samples.
const HOLD: f64 = 0.05;
/// Sweeps, and how far each goes: below 2 they converge, since a row of the matrix sums to what it is divided by.
const SWEEPS: usize = 30;
const STEP: f64 = 1.2;
/// Distance of a sample from where its corners say it is, over the longest side of its face in UV, beyond which one of the two is wrong.
const WILD: f64 = 0.25;

/// What the atlas says of a point inside a face.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct SurfaceSample {
    /// UV of the closest point of the chart.
    pub uv: DVec2,
    /// Area that it stands for where it counts, else 0.
    pub weight: f64,
}

/// Places of the nodes.
pub struct Targets<'a> {
    /// On the chart.
    pub inner: &'a mut [DVec2], // (nodes)
    /// The best fit, which may lie beyond the border.
    pub fitted: &'a mut [DVec2], // (nodes)
    /// Samples of each face.
    pub samples: &'a mut [[SurfaceSample; SAMPLES]], // (f)
}

/// Bytes that [`Targets::new`] takes.
pub const fn targets_need(faces: usize) -> usize {
    bytes_for::<DVec2>(3 * faces)
        .saturating_mul(4)
        .saturating_add(bytes_for::<[SurfaceSample; SAMPLES]>(faces))
        .saturating_add(bytes_for::<f64>(3 * faces).saturating_mul(2))
}

impl<'a> Targets<'a> {
    /// Of the nodes that `node` names.
    pub fn new(
        nodes: usize,
        node: &[[u32; 3]],
        mesh: MeshView,
        sheets: &Sheets,
        source: &SourceAtlas,
        walking: &mut Walking,
        keep: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let inner = keep.take::<DVec2>(nodes)?;
        let fitted = keep.take::<DVec2>(nodes)?;
        let samples = keep.take::<[SurfaceSample; SAMPLES]>(node.len())?;
        let mut frame = keep.frame();
        let near = frame.take_filled::<f64>(nodes, f64::INFINITY)?;
        for (f, own) in node.iter().enumerate() {
            let corners = mesh.faces[f].map(|v| mesh.positions[v as usize]);
            let mut ask = |weights: [f64; 3]| -> Target {
                let p = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
                source.target(p, &source.walk(sheets.anchor[f], p, walking))
            };
            for i in 0..3 {
                let mut weights = [0.0; 3];
                weights[i] = 1.0;
                let target = ask(weights);
                let n = own[i] as usize;
                if target.squared < near[n] {
                    (near[n], inner[n], fitted[n]) = (target.squared, target.inner, target.outer);
                }
            }
            let share = area(mesh, f) / SAMPLES as f64;
            for (sample, weights) in samples[f].iter_mut().zip(INSIDE) {
                let target = ask(weights);
                let counts = target.inner.distance_squared(target.outer) < 1e-18;
                *sample = SurfaceSample { uv: target.inner, weight: if counts { share } else { 0.0 } };
            }
        }
        let mut targets = Self { inner, fitted, samples };
        targets.fit(node, frame)?;
        Ok(targets)
    }

    fn fit(&mut self, node: &[[u32; 3]], mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
        let nodes = self.inner.len();
        let own = scratch.take::<DVec2>(nodes)?;
        own.copy_from_slice(self.fitted);
        let force = scratch.take::<DVec2>(nodes)?;
        let mass = scratch.take::<f64>(nodes)?;
        for (samples, face) in self.samples.iter_mut().zip(node) {
            let x = face.map(|n| own[n as usize]);
            let longest = [x[0] - x[1], x[1] - x[2], x[2] - x[0]].map(|d| d.dot(d)).into_iter().fold(0.0, f64::max);
            for (sample, weights) in samples.iter_mut().zip(INSIDE) {
                if sample.uv.distance_squared(mixed(x, weights)) > WILD * WILD * longest {
                    sample.weight = 0.0;
                }
                (0..3).for_each(|i| mass[face[i] as usize] += sample.weight * weights[i]);
            }
        }
        let hold = scratch.take::<f64>(nodes)?;
        let mean = mass.iter().sum::<f64>() / nodes.max(1) as f64;
        hold.iter_mut().zip(mass.iter()).for_each(|(h, m)| *h = HOLD * m.max(1e-6 * mean).max(f64::MIN_POSITIVE));
        for _ in 0..SWEEPS {
            for (n, force) in force.iter_mut().enumerate() {
                *force = (own[n] - self.fitted[n]) * hold[n];
            }
            for (samples, face) in self.samples.iter().zip(node) {
                let x = face.map(|n| self.fitted[n as usize]);
                for (sample, weights) in samples.iter().zip(INSIDE).filter(|(s, _)| s.weight > 0.0) {
                    let gap = (sample.uv - mixed(x, weights)) * sample.weight;
                    (0..3).for_each(|i| force[face[i] as usize] += gap * weights[i]);
                }
            }
            for (n, x) in self.fitted.iter_mut().enumerate() {
                *x += force[n] * (STEP / (mass[n] + hold[n]));
            }
        }
        Ok(())
    }

    /// Share of the area whose place on the map `x` is within `gap` of what the atlas says.
    pub fn share_within(&self, x: &[DVec2], node: &[[u32; 3]], mesh: MeshView, gap: f64) -> f64 {
        let (mut all, mut near) = (0.0, 0.0);
        for (f, (samples, face)) in self.samples.iter().zip(node).enumerate() {
            let (x, share) = (face.map(|n| x[n as usize]), area(mesh, f));
            for (sample, weights) in samples.iter().zip(INSIDE) {
                let d = mixed(x, weights) - sample.uv;
                all += share;
                near += if sqrt(d.dot(d)) <= gap { share } else { 0.0 };
            }
        }
        if all > 0.0 { near / all } else { 0.0 }
    }
}

fn mixed(x: [DVec2; 3], weights: [f64; 3]) -> DVec2 {
    x[0] * weights[0] + x[1] * weights[1] + x[2] * weights[2]
}
