//! The parts of a repaired mesh: casts for shape diameter and inner sight, and hands both to the stage that cuts.

use crate::base::scratch::{Scratch, bytes_for};
use crate::base::workers::Workers;
use crate::mesh::view::MeshView;
use crate::parts::segmentation::{parts, parts_need};
use crate::parts::settings::{Count, PartSettings, PartSummary};
use crate::parts::surface::PartSurface;
use crate::rays::bvh::{BuildBvh, BvhError};
use crate::rays::cast::{Ray, Scene};
use crate::rays::diameter::{DiameterSettings, diameter, diameter_need};
use glam::Vec3;

/// Rays for the shape diameter over the whole mesh: 60 a face, as published (Shapira et al. 2008), up to 5,000 faces, then fewer a face. Where
/// faces are many, neighbours measure the same place, and patches take means.
const RAYS_IN_ALL: usize = 300_000;
/// The same for the published method, whose clusters are of faces: 60 up to 20,000.
const RAYS_PUBLISHED: usize = 1_200_000;
/// Rays a face at the most, and the least for each method.
const RAYS_MOST: usize = 60;
const RAYS_LEAST: usize = 16;
const RAYS_LEAST_PUBLISHED: usize = 25;

/// Scratch bytes for [`partition`].
pub fn partition_need(faces: usize, vertices: usize, bvh: &dyn BuildBvh) -> usize {
    bytes_for::<Vec3>(vertices) + Scene::need(faces, bvh) + diameter_need(faces).max(parts_need(faces, vertices))
}

/// Label and shape diameter of each face of `mesh`, whose positions are of magnitude 1 (as from `repair`) and whose
/// faces turn outwards. A mesh without faces has no parts. Nothing is written on an error of memory.
/// Near-linear in the number of faces.
#[allow(clippy::too_many_arguments)]
pub fn partition(
    labels: &mut [u32],       // (f)
    diameter_out: &mut [f32], // (f)
    mesh: MeshView,
    twin: &[u32], // (3 f)
    settings: &PartSettings,
    bvh: &dyn BuildBvh,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<PartSummary, BvhError> {
    scratch.require(partition_need(mesh.faces.len(), mesh.positions.len(), bvh))?;
    let positions = scratch.take::<Vec3>(mesh.positions.len())?;
    positions.iter_mut().zip(mesh.positions).for_each(|(p, q)| *p = q.as_vec3());
    let scene = Scene::new(positions, mesh.faces, bvh, &mut scratch)?;
    let (in_all, least) = match settings.count {
        Count::Published { .. } => (RAYS_PUBLISHED, RAYS_LEAST_PUBLISHED),
        Count::Auto | Count::Exactly(_) => (RAYS_IN_ALL, RAYS_LEAST),
    };
    let rays = (in_all / mesh.faces.len().max(1)).clamp(least, RAYS_MOST);
    let cone = DiameterSettings { seed: settings.seed, rays };
    diameter(diameter_out, mesh, twin, &scene, &cone, scratch.frame(), workers)?;
    let sees = |from: Vec3, to: Vec3| {
        scene.closest(&Ray { origin: from, direction: to - from }).is_none_or(|hit| hit.distance > 1.0)
    };
    let surface = PartSurface { mesh, twin, diameter: diameter_out, sees: &sees };
    Ok(parts(labels, &surface, settings, scratch, workers)?)
}
