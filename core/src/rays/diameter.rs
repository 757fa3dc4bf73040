//! Shape diameter: how thick the object is under each face.
//!
//! Rays go inwards from the face's centroid, spread evenly over a cone of 120 degrees about the inward normal; one
//! counts where it leaves through a face whose normal points along it, and the median of the counted lengths is the
//! diameter (Shapira, Shamir, Cohen-Or, *Consistent mesh partitioning and skeletonisation using the shape diameter
//! function*, The Visual Computer 24, 2008; there a mean weighted by angle after outliers are removed).
//! A value depends on (seed, face) and the scene, not on threads. A face without any counted ray, as on an open sheet,
//! gets the mean of its neighbours that have one, ring by ring; a component without any ray gets 0.

use super::cast::Scene;
use super::directions::{Spread, hemisphere, hemisphere_need, turned_frame};
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::base::workers::{Workers, for_each_chunk};
use crate::mesh::view::{MeshView, NONE};
use glam::Vec3;

/// Cosine of half the cone's angle, 120 degrees. Narrower cones miss the far side of bent limbs, wider ones measure
/// along the limb; 90 to 120 is what the literature uses.
const COS_HALF_ANGLE: f32 = 0.5;
/// Rays start this share of the scene's largest coordinate below the surface, as in `exposure`.
const OFFSET: f32 = 1e-4;
/// Faces a task.
const CHUNK: usize = 64;
/// Rays a face at the most; their lengths stand on the stack.
pub const MAX_RAYS: usize = 128;

/// What to cast.
#[derive(Clone, Copy, Debug)]
pub struct DiameterSettings {
    /// Rays a face, 1 to [`MAX_RAYS`]; more count as that.
    pub rays: usize,
    /// Seed of the cone's turn about the normal.
    pub seed: u64,
}

impl Default for DiameterSettings {
    fn default() -> Self {
        Self { rays: 60, seed: 0 }
    }
}

/// Scratch bytes for [`diameter`].
pub const fn diameter_need(faces: usize) -> usize {
    bytes_for::<Vec3>(MAX_RAYS) + hemisphere_need(MAX_RAYS) + bytes_for::<Vec3>(faces) + 2 * bytes_for::<u32>(faces)
}

/// Shape diameter of each face, in the scene's units, at least 0. `scene` holds `mesh`, face by face; `twin` is the
/// mesh's. O(f rays log f).
#[allow(clippy::too_many_arguments)]
pub fn diameter(
    out: &mut [f32], // (f)
    mesh: MeshView,
    twin: &[u32], // (3 f)
    scene: &Scene,
    settings: &DiameterSettings,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let face_count = mesh.faces.len();
    scratch.require(diameter_need(face_count))?;
    let cone = scratch.take::<Vec3>(settings.rays.clamp(1, MAX_RAYS))?;
    hemisphere(cone, Spread::Uniform, scratch.frame())?;
    cone.iter_mut().for_each(|d| *d = onto_cap(*d));
    let normals = scratch.take::<Vec3>(face_count)?;
    for (f, normal) in normals.iter_mut().enumerate() {
        let n = mesh.area_vector(f);
        let length = real::sqrt(n.length_squared());
        *normal = if length > 0.0 { (n / length).as_vec3() } else { Vec3::ZERO };
    }
    let (cone, normals) = (&*cone, &*normals);
    for_each_chunk(workers, out, CHUNK, &|chunk, out| {
        for (i, out) in out.iter_mut().enumerate() {
            let face = chunk * CHUNK + i;
            let [a, b, c] = mesh.faces[face].map(|v| mesh.positions[v as usize]);
            let middle = ((a + b + c) / 3.0).as_vec3();
            *out = at_face(middle, face, normals, cone, scene, settings.seed);
        }
    });
    fill_gaps(out, twin, scratch)
}

/// The hemisphere squeezed onto the cone's cap: even densities stay even, since heights scale.
fn onto_cap(d: Vec3) -> Vec3 {
    let z = 1.0 - (1.0 - d.z) * (1.0 - COS_HALF_ANGLE);
    let (flat, wanted) = (real::sqrt(1.0 - d.z * d.z), real::sqrt(1.0 - z * z));
    let scale = if flat > 0.0 { wanted / flat } else { 0.0 };
    Vec3::new(d.x * scale, d.y * scale, z)
}

/// The median length, or -1 where no ray counts.
fn at_face(middle: Vec3, face: usize, normals: &[Vec3], cone: &[Vec3], scene: &Scene, seed: u64) -> f32 {
    let inward = -normals[face];
    if inward == Vec3::ZERO {
        return -1.0;
    }
    let [t, b] = turned_frame(inward, seed, face as u64);
    let origin = middle + inward * (OFFSET * scene.reach());
    let mut world = [Vec3::ZERO; MAX_RAYS];
    for (w, local) in world.iter_mut().zip(cone) {
        *w = t * local.x + b * local.y + inward * local.z;
    }
    let world = &world[..cone.len()];
    let (mut lengths, mut count) = ([0.0f32; MAX_RAYS], 0);
    scene.closest_each(origin, world, |i, hit| {
        if normals[hit.face as usize].dot(world[i]) > 0.0 {
            lengths[count] = hit.distance;
            count += 1;
        }
    });
    if count == 0 {
        return -1.0;
    }
    sort::select_by(&mut lengths[..count], count / 2, f32::total_cmp);
    lengths[count / 2]
}

/// Gives every value below 0 the mean of its neighbours' values, ring by ring, and 0 where a component has none.
fn fill_gaps(values: &mut [f32], twin: &[u32], mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let ring = scratch.take::<u32>(values.len())?;
    let next_ring = scratch.take::<f32>(values.len())?;
    let mut gaps = 0;
    for (f, _) in values.iter().enumerate().filter(|(_, x)| **x < 0.0) {
        ring[gaps] = f as u32;
        gaps += 1;
    }
    while gaps > 0 {
        let mut left = 0;
        for i in 0..gaps {
            let face = ring[i] as usize;
            let (mut sum, mut count) = (0.0, 0);
            for &t in twin[3 * face..3 * face + 3].iter().filter(|t| **t != NONE) {
                let value = values[(t / 3) as usize];
                if value >= 0.0 {
                    (sum, count) = (sum + value, count + 1);
                }
            }
            next_ring[i] = if count > 0 { sum / count as f32 } else { -1.0 };
        }
        for i in 0..gaps {
            let face = ring[i];
            values[face as usize] = next_ring[i];
            if next_ring[i] < 0.0 {
                ring[left] = face;
                left += 1;
            }
        }
        if left == gaps {
            ring[..left].iter().for_each(|f| values[*f as usize] = 0.0);
            break;
        }
        gaps = left;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::workers::Serial;
    use crate::mesh::topology::{twins, twins_need};
    use crate::rays::cast::tests::{scene, terrain};
    use glam::DVec3;
    use std::{thread, vec, vec::Vec};

    struct Crowd;
    impl Workers for Crowd {
        fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
            thread::scope(|s| (0..count).rev().for_each(|i| drop(s.spawn(move || task(i)))));
        }
    }

    fn run(positions: &[DVec3], faces: &[[u32; 3]], workers: &dyn Workers) -> Vec<f32> {
        let mesh = MeshView { positions, faces };
        let mut twin = vec![0; 3 * faces.len()];
        let mut bytes = vec![0u8; diameter_need(faces.len()).max(twins_need(faces.len()))];
        twins(&mut twin, mesh, Scratch::new(&mut bytes)).unwrap();
        let single: Vec<Vec3> = positions.iter().map(|p| p.as_vec3()).collect();
        let scene = scene(&single, faces);
        let mut out = vec![f32::NAN; faces.len()];
        let (settings, scratch) = (DiameterSettings::default(), Scratch::new(&mut bytes));
        diameter(&mut out, mesh, &twin, &scene, &settings, scratch, workers).unwrap();
        out
    }

    /// A box from the origin to `size`, outward faces, the last two at z = 0 and before them at the top.
    fn block(size: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let corner = |i: u32| size * DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
        let quads = [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [4, 5, 7, 6], [0, 2, 3, 1]];
        let faces = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        ((0..8).map(corner).collect(), faces)
    }

    #[test]
    fn a_plate_is_as_thick_as_the_median_slanted_way_through_it() {
        // Heights on the cap are even between cos 60 degrees and 1; their median 0.75 makes the way 1/0.75. With 60 rays
        // the median's height is off by less than 1/60 of the range: 0.02 of the way.
        let (positions, faces) = block(DVec3::new(20.0, 20.0, 1.0));
        let out = run(&positions, &faces, &Serial);
        out[8..].iter().for_each(|d| assert!((d - 4.0 / 3.0).abs() < 0.03, "{d}"));
        assert!(out[..8].iter().all(|d| *d < 4.0), "{out:?}");
    }

    #[test]
    fn an_open_sheet_and_faces_without_area_have_none() {
        let (positions, faces) = terrain(4);
        let positions: Vec<DVec3> = positions.iter().map(|p| p.as_dvec3() * DVec3::new(1.0, 1.0, 0.0)).collect();
        assert!(run(&positions, &faces, &Serial).iter().all(|d| *d == 0.0));
        assert!(run(&[], &[], &Serial).is_empty());
    }

    #[test]
    fn gaps_take_the_mean_of_their_neighbours_ring_by_ring() {
        // A chain of four faces: 0 - 1 - 2 - 3.
        let mut twin = [NONE; 12];
        for f in 0..3 {
            (twin[3 * f + 1], twin[3 * f + 3]) = (3 * f as u32 + 3, 3 * f as u32 + 1);
        }
        let mut values = [2.0, -1.0, -1.0, -1.0];
        let mut bytes = vec![0u8; diameter_need(4)];
        fill_gaps(&mut values, &twin, Scratch::new(&mut bytes)).unwrap();
        assert_eq!(values, [2.0; 4]);
        let mut values = [2.0, -1.0, 4.0, -1.0];
        fill_gaps(&mut values, &twin, Scratch::new(&mut bytes)).unwrap();
        assert_eq!(values, [2.0, 3.0, 4.0, 4.0]);
    }

    #[test]
    fn threads_change_no_bit() {
        let (positions, faces) = block(DVec3::new(3.0, 2.0, 1.0));
        assert_eq!(run(&positions, &faces, &Serial), run(&positions, &faces, &Crowd));
    }

    #[test]
    fn one_byte_less_is_refused_and_nothing_written() {
        let (scene, mut out) = (scene(&[], &[]), [7.0]);
        let mesh = MeshView { positions: &[DVec3::ZERO; 3], faces: &[[0, 1, 2]] };
        let mut bytes = vec![0u8; diameter_need(1) - 1];
        let (settings, scratch) = (DiameterSettings::default(), Scratch::new(&mut bytes));
        assert!(diameter(&mut out, mesh, &[NONE; 3], &scene, &settings, scratch, &Serial).is_err());
        assert_eq!(out, [7.0]);
    }
}
