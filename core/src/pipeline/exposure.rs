//! Exposure of the working mesh, and of the user's vertices.

use super::report::UnwrapError;
use super::settings::Settings;
use crate::base::pace::{Marks, Pace, StageError};
use crate::base::progress::{Progress, Stage, tell};
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall};
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
/// Vertices whose exposure is found between two marks.
const EXPOSURE_SLICE: usize = 1024;
/// Passes over the faces in which known exposure spreads: each carries it over many rings of neighbours.
const SPREADING: usize = 16;

/// Exposure of each working vertex; the vertices that were cast, where that ended early.
pub(super) fn expose(
    open: &mut [f32],
    working: &Working,
    settings: &Settings,
    bvh: &dyn BuildBvh,
    mut scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<Option<u64>, UnwrapError> {
    let mesh = working.mesh();
    let n = mesh.positions.len();
    let exact = scratch.take::<DVec3>(n)?;
    vertex_normals(exact, mesh, NormalWeight::Angle);
    let normals = scratch.take::<Vec3>(n)?;
    normals.iter_mut().zip(exact.iter()).for_each(|(to, from)| *to = on_grid(*from, NORMAL_STEPS));
    let points = scratch.take::<Vec3>(n)?;
    points.iter_mut().zip(mesh.positions).for_each(|(to, from)| *to = on_grid(*from, POSITION_STEPS));
    let scene = Scene::new(points, mesh.faces, bvh, &mut scratch).map_err(|e| match e {
        BvhError::Scratch(e) => e.into(),
        _ => UnwrapError::BadTree,
    })?;
    let slices = n.div_ceil(EXPOSURE_SLICE);
    let mut pace = Pace::new(progress, Stage::Exposure, settings.work.exposure);
    let known = scratch.take::<u8>(slices)?;
    let mut last = 0;
    let ended = (|| {
        for (done, slice) in scattered(slices).enumerate() {
            pace.at(done, slices);
            pace.mark(last)?;
            let first = slice * EXPOSURE_SLICE;
            let end = (first + EXPOSURE_SLICE).min(n);
            last = end - first;
            let rays =
                ExposureSettings { rays: settings.rays as usize, seed: settings.seed, first, ..Default::default() };
            let (points, normals) = (&points[first..end], &normals[first..end]);
            exposure(&mut open[first..end], points, normals, &scene, &rays, scratch.frame(), workers)?;
            known[slice] = 1;
        }
        Ok(())
    })();
    if let Err(e) = ended {
        StageError::end(e, &mut pace)?;
    }
    let work = pace.work();
    if pace.has_ended() {
        spread_known(open, known, working, scratch)?;
        return Ok(Some(work));
    }
    tell(progress, Stage::Exposure, slices, slices)?;
    Ok(None)
}

/// The numbers below `count` in an order (van der Corput's) whose beginnings lie all over.
fn scattered(count: usize) -> impl Iterator<Item = usize> {
    let bits = usize::BITS - count.saturating_sub(1).leading_zeros();
    let turned = move |i: usize| i.reverse_bits().checked_shr(usize::BITS - bits).unwrap_or(0);
    (0..1usize << bits).map(turned).filter(move |i| *i < count)
}

/// Gives vertices of unknown slices the exposure of the nearest known one, by edges; open where there is none.
fn spread_known(
    open: &mut [f32],
    known: &[u8],
    working: &Working,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let seen = scratch.take::<u8>(open.len())?;
    for (v, seen) in seen.iter_mut().enumerate() {
        *seen = known[v / EXPOSURE_SLICE];
        if *seen == 0 {
            open[v] = 1.0;
        }
    }
    for _ in 0..SPREADING {
        for f in working.mesh().faces {
            let Some(from) = f.iter().find(|v| seen[**v as usize] != 0) else { continue };
            let value = open[*from as usize];
            for v in f.map(|v| v as usize) {
                if seen[v] == 0 {
                    (seen[v], open[v]) = (1, value);
                }
            }
        }
    }
    Ok(())
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
