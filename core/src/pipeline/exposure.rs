//! Exposure of the working mesh, and of the user's vertices.

use super::report::UnwrapError;
use super::settings::Settings;
use crate::base::progress::{Progress, Stage, tell};
use crate::base::real;
use crate::base::scratch::Scratch;
use crate::base::workers::Workers;
use crate::mesh::normals::{NormalWeight, vertex_normals};
use crate::mesh::view::NONE;
use crate::mesh::working::Working;
use crate::rays::bvh::{BuildBvh, BvhError};
use crate::rays::cast::Scene;
use crate::rays::exposure::{ExposureSettings, exposure};
use glam::{DVec3, Vec3};

/// Rays see vertices on a grid of so many steps a unit of the mesh's own frame, that one or another rounding of the input
/// casts the same rays: 2^24 is f32 as it is, and every hundredth coordinate of a file of 9 digits rounds otherwise; 2^16
/// bends the small faces of a million.
const POSITION_STEPS: f64 = (1 << 20) as f64;
/// The same for normals, which only aim the rays: a step is a 70th of a degree.
const NORMAL_STEPS: f64 = (1 << 12) as f64;
/// Vertices whose exposure is found between two progress reports.
const EXPOSURE_SLICE: usize = 4096;

/// Exposure of each working vertex.
pub(super) fn expose(
    open: &mut [f32],
    working: &Working,
    settings: &Settings,
    bvh: &dyn BuildBvh,
    mut scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<(), UnwrapError> {
    let mesh = working.mesh();
    let n = mesh.positions.len();
    let exact = scratch.take::<DVec3>(n)?;
    vertex_normals(exact, mesh, NormalWeight::Angle);
    let normals = scratch.take::<Vec3>(n)?;
    normals.iter_mut().zip(exact.iter()).for_each(|(to, from)| *to = on_grid(*from, NORMAL_STEPS));
    let points = scratch.take::<Vec3>(n)?;
    points.iter_mut().zip(mesh.positions).for_each(|(to, from)| *to = on_grid(*from, POSITION_STEPS));
    let scene = Scene::new(points, mesh.faces, bvh, &mut scratch).map_err(|e| match e {
        BvhError::Scratch(e) => UnwrapError::Scratch(e),
        _ => UnwrapError::BadTree,
    })?;
    for first in (0..n).step_by(EXPOSURE_SLICE) {
        tell(progress, Stage::Exposure, first, n)?;
        let end = (first + EXPOSURE_SLICE).min(n);
        let rays = ExposureSettings { rays: settings.rays as usize, seed: settings.seed, first, ..Default::default() };
        let (points, normals) = (&points[first..end], &normals[first..end]);
        exposure(&mut open[first..end], points, normals, &scene, &rays, scratch.frame(), workers)?;
    }
    Ok(tell(progress, Stage::Exposure, n, n)?)
}

/// Exposure of each input vertex: those at one place share the value of the last working vertex there.
pub(super) fn share_exposure(exposure_out: &mut [f32], open: &[f32], working: &Working) {
    exposure_out.fill(1.0);
    for (v, source) in working.vertex_source.iter().enumerate() {
        exposure_out[*source as usize] = open[v];
    }
    for v in 0..exposure_out.len() {
        let place = working.welded[v];
        if place != NONE {
            exposure_out[v] = exposure_out[place as usize];
        }
    }
}

/// Nearest point of a grid.
fn on_grid(p: DVec3, steps: f64) -> Vec3 {
    ((p * steps).to_array().map(|x| (real::round(x) / steps) as f32)).into()
}
