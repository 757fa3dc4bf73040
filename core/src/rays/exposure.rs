//! Exposure: the share of the sky that a surface point sees (ambient occlusion, 1 open, 0 occluded).
//!
//! AO(p) = (1/pi) * integral over the hemisphere of V(p,w) (n.w) dw, a plain mean of V over cosine-weighted directions;
//! [`Spread::Uniform`] leaves the weight out, as libigl does. Rays start a little off the surface along the normal.
//! The value of a point depends on (seed, its index) and the scene, not on the thread or the chunk that computes it.
//! Against libigl's ambient_occlusion (rays from the surface, near limit 1e-4, random directions) the mean over vertices
//! agrees to 0.7 % on thirteen meshes in uniform mode; suzanne, all creases, differs most.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::workers::Serial;
    use crate::rays::cast::tests::{scene, terrain};
    use approx::assert_abs_diff_eq;
    use core::f32::consts::{FRAC_1_SQRT_2, PI};
    use std::{thread, vec, vec::Vec};

    /// Quads as two triangles each.
    fn quads(quads: &[[Vec3; 4]]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let faces =
            (0..quads.len() as u32).flat_map(|q| [[4 * q, 4 * q + 1, 4 * q + 2], [4 * q, 4 * q + 2, 4 * q + 3]]);
        (quads.concat(), faces.collect())
    }

    fn expose(mesh: &(Vec<Vec3>, Vec<[u32; 3]>), points: &[Vec3], normals: &[Vec3], spread: Spread) -> Vec<f32> {
        let scene = scene(&mesh.0, &mesh.1);
        let settings = ExposureSettings { rays: 2048, spread, ..Default::default() };
        let mut out = vec![f32::NAN; points.len()];
        let mut bytes = vec![0u8; exposure_need(settings.rays)];
        exposure(&mut out, points, normals, &scene, &settings, Scratch::new(&mut bytes), &Serial).unwrap();
        out
    }

    /// A floor and a wall at x = 0 that stands on it; both reach far beyond the points of the tests.
    fn corner() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let p = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        quads(&[
            [p(0.0, -1.0, 0.0), p(1.0, -1.0, 0.0), p(1.0, 1.0, 0.0), p(0.0, 1.0, 0.0)],
            [p(0.0, -1.0, 0.0), p(0.0, 1.0, 0.0), p(0.0, 1.0, 1.0), p(0.0, -1.0, 1.0)],
        ])
    }

    #[test]
    fn a_wall_hides_its_part_of_the_sky() {
        // At distance d from a long wall of height h the sky's cosine-weighted part is (1 + d/sqrt(d^2 + h^2)) / 2. At
        // 0.05 the wall's ends and top cut less than 0.004 off; the lattice has an error of about 1/rays per border.
        let e = expose(&corner(), &[Vec3::new(0.05, 0.0, 0.0)], &[Vec3::Z], Spread::Cosine)[0];
        assert_abs_diff_eq!(e, (1.0 + 0.05 / 1.00125) / 2.0, epsilon = 0.006);
        // Uniform: half the directions point at the wall, of them the share atan-like above its top is small.
        let u = expose(&corner(), &[Vec3::new(0.005, 0.0, 0.0)], &[Vec3::Z], Spread::Uniform)[0];
        assert_abs_diff_eq!(u, 0.5, epsilon = 0.01);
    }

    #[test]
    fn the_crease_sees_the_wedge_between_its_sides() {
        // Under the bisecting normal the open quarter of directions is symmetric about it: cosine-weighted, the wedge of
        // half angle 45 degrees holds sin(45) of the weight.
        let n = Vec3::new(FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2);
        let e = expose(&corner(), &[Vec3::ZERO], &[n], Spread::Cosine)[0];
        assert_abs_diff_eq!(e, FRAC_1_SQRT_2, epsilon = 0.01);
    }

    #[test]
    fn a_ball_is_open_outside_and_dark_inside() {
        let at = |i: i32, j: i32| {
            let (a, b) = (i as f32 * PI / 16.0, (j % 32) as f32 * PI / 16.0);
            Vec3::new(a.sin() * b.cos(), a.sin() * b.sin(), a.cos())
        };
        let mut patches = vec![];
        for i in 0..16 {
            for j in 0..32 {
                patches.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        let ball = quads(&patches);
        let normals = ball.0.clone();
        let inward: Vec<_> = normals.iter().map(|n| -*n).collect();
        // A polyhedron of 16 rings is convex: nothing is above a vertex's plane. Inside, every ray ends on it.
        assert!(expose(&ball, &ball.0, &normals, Spread::Cosine).iter().all(|e| *e == 1.0));
        assert!(expose(&ball, &ball.0, &inward, Spread::Uniform).iter().all(|e| *e < 0.01));
        assert_eq!(expose(&ball, &[Vec3::ZERO], &[Vec3::X], Spread::Cosine), [0.0]);
    }

    #[test]
    fn an_empty_scene_no_rays_and_no_normal_are_open() {
        let none = (vec![], vec![]);
        assert_eq!(expose(&none, &[Vec3::ZERO; 2], &[Vec3::ZERO, Vec3::NAN], Spread::Cosine), [1.0, 1.0]);
        let degenerate = (vec![Vec3::ZERO, Vec3::X], vec![[0, 1, 1]; 5]);
        assert_eq!(expose(&degenerate, &[Vec3::ZERO], &[Vec3::X], Spread::Uniform), [1.0]);
    }

    #[test]
    fn threads_and_slices_change_nothing() {
        struct Crowd;
        impl Workers for Crowd {
            fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
                thread::scope(|s| (0..count).rev().for_each(|i| drop(s.spawn(move || task(i)))));
            }
        }
        let (positions, faces) = terrain(16);
        let (scene, normals) = (scene(&positions, &faces), vec![Vec3::Z; positions.len()]);
        let run = |range: core::ops::Range<usize>, workers: &dyn Workers| {
            let settings = ExposureSettings { rays: 100, first: range.start, ..Default::default() };
            let mut out = vec![0.0; range.len()];
            let mut bytes = vec![0u8; exposure_need(100)];
            let (points, normals) = (&positions[range.clone()], &normals[range]);
            exposure(&mut out, points, normals, &scene, &settings, Scratch::new(&mut bytes), workers).unwrap();
            out
        };
        let whole = run(0..positions.len(), &Serial);
        assert!(whole.iter().any(|e| *e < 0.9));
        assert_eq!(whole, run(0..positions.len(), &Crowd));
        assert_eq!(whole[37..90], run(37..90, &Crowd));
    }

    #[test]
    fn an_edge_is_measured_at_its_middle() {
        let (mesh, points) = (corner(), [Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.1, 0.0, 0.0)]);
        let scene = scene(&mesh.0, &mesh.1);
        let settings = ExposureSettings::default();
        let mut bytes = vec![0u8; exposure_need(settings.rays)];
        let mut edge = [0.0];
        let scratch = Scratch::new(&mut bytes);
        edge_exposure(&mut edge, &[[0, 1]], &points, &[Vec3::Z; 2], &scene, &settings, scratch, &Serial).unwrap();
        let mut middle = [0.0];
        let (p, scratch) = ([Vec3::new(0.05, 0.0, 0.0)], Scratch::new(&mut bytes));
        exposure(&mut middle, &p, &[Vec3::Z], &scene, &settings, scratch, &Serial).unwrap();
        assert_eq!(edge, middle);
    }

    #[test]
    fn one_byte_less_is_refused_and_nothing_written() {
        let scene = scene(&[], &[]);
        let mut out = [7.0];
        let mut bytes = vec![0u8; exposure_need(512) - 1];
        let scratch = Scratch::new(&mut bytes);
        let settings = ExposureSettings::default();
        assert!(exposure(&mut out, &[Vec3::ZERO], &[Vec3::Z], &scene, &settings, scratch, &Serial).is_err());
        assert_eq!(out, [7.0]);
    }
}
