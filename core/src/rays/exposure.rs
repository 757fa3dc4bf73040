//! Exposure: the share of the sky that a surface point sees (ambient occlusion, 1 open, 0 occluded).
//!
//! AO(p) = (1/pi) * integral over the hemisphere of V(p,w) (n.w) dw, a plain mean of V over cosine-weighted directions;
//! [`Spread::Uniform`] leaves the weight out, as libigl does. Rays start a little off the surface along the normal.
//! The value of a point depends on (seed, its index) and the scene, not on the thread or the chunk that computes it.
//! Limits: no far bound (a closed room is dark); back faces occlude, so an open surface has two sides, of which the
//! normal chooses one; a point deeper than the offset inside another part is dark.

use super::cast::Scene;
use super::directions::{Spread, hemisphere, hemisphere_need, turned_frame};
use super::fan::BLOCK;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::workers::{Workers, for_each_chunk};
use glam::Vec3;

/// Rays start this share of the scene's largest coordinate off the surface: libigl's near limit is the same 1e-4 where
/// that coordinate is 1. 1e-5 darkens creases by what f32 rounds; 1e-3 lifts points out of shallow grooves.
const OFFSET: f32 = 1e-4;
/// Points a task. 16 and 256 cost the same; a task should outlast its start by far, and threads should end together.
const CHUNK: usize = 64;

/// What to cast.
#[derive(Clone, Copy, Debug)]
pub struct ExposureSettings {
    /// Rays a point; the standard error of an exposure e is below sqrt(e (1 - e) / rays). 0 gives 1.
    pub rays: usize,
    /// Density of the rays.
    pub spread: Spread,
    /// Seed of the turns.
    pub seed: u64,
    /// Index of the first point, so that a caller may go through a mesh in slices.
    pub first: usize,
}

impl Default for ExposureSettings {
    fn default() -> Self {
        Self { rays: 512, spread: Spread::Cosine, seed: 0, first: 0 }
    }
}

/// Scratch bytes for [`exposure`] and [`edge_exposure`].
pub const fn exposure_need(rays: usize) -> usize {
    bytes_for::<Vec3>(rays) + hemisphere_need(rays)
}

/// Exposure of each of `points` under its unit `normals`. A normal that is zero or not finite counts as +z.
/// O(n rays log f).
pub fn exposure(
    out: &mut [f32],  // (n)
    points: &[Vec3],  // (n)
    normals: &[Vec3], // (n)
    scene: &Scene,
    settings: &ExposureSettings,
    scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    run(out, &|i| (points[i], normals[i]), scene, settings, scratch, workers)
}

/// Exposure at the middle of each edge (a, b), under the mean of its ends' normals.
#[allow(clippy::too_many_arguments)]
pub fn edge_exposure(
    out: &mut [f32],    // (e)
    edges: &[[u32; 2]], // (e)
    positions: &[Vec3], // (n)
    normals: &[Vec3],   // (n)
    scene: &Scene,
    settings: &ExposureSettings,
    scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let middle = |i: usize| {
        let [a, b] = edges[i].map(|v| v as usize);
        ((positions[a] + positions[b]) * 0.5, normals[a] + normals[b])
    };
    run(out, &middle, scene, settings, scratch, workers)
}

fn run(
    out: &mut [f32],
    point: &(dyn Fn(usize) -> (Vec3, Vec3) + Sync),
    scene: &Scene,
    settings: &ExposureSettings,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    scratch.require(exposure_need(settings.rays))?;
    let local = scratch.take::<Vec3>(settings.rays)?;
    hemisphere(local, settings.spread, scratch)?;
    let local = &*local;
    for_each_chunk(workers, out, CHUNK, &|chunk, out| {
        for (i, out) in out.iter_mut().enumerate() {
            let i = chunk * CHUNK + i;
            let (p, n) = point(i);
            let index = (settings.first + i) as u64;
            *out = at_point(p, unit_or_up(n), local, scene, settings.seed, index);
        }
    });
    Ok(())
}

fn at_point(p: Vec3, n: Vec3, local: &[Vec3], scene: &Scene, seed: u64, index: u64) -> f32 {
    if local.is_empty() {
        return 1.0;
    }
    let [t, b] = turned_frame(n, seed, index);
    let origin = p + n * (OFFSET * scene.reach());
    let mut world = [Vec3::ZERO; BLOCK];
    let mut occluded = 0;
    for block in local.chunks(BLOCK) {
        for (w, l) in world.iter_mut().zip(block) {
            *w = t * l.x + b * l.y + n * l.z;
        }
        occluded += scene.occluded_count(origin, &world[..block.len()]);
    }
    1.0 - occluded as f32 / local.len() as f32
}

fn unit_or_up(n: Vec3) -> Vec3 {
    let length = crate::base::real::sqrt(n.length_squared());
    if length > 0.0 && length < f32::INFINITY { n / length } else { Vec3::Z }
}
