//! Core's pipeline with the memory, threads and library that a desktop has.
//!
//! Core says beforehand how much memory it wants, an estimate from above for meshes as they occur. Where a mesh needs
//! more, the run starts again with twice as much, until that does not help or the machine has no more to give.

use crate::args;
use crate::base::failure::Failure;
use crate::formats::loaded::Loaded;
use crate::mesh::polygons::Mesh;
use crate::run::hierarchy::ObvhsBuilder;
use crate::run::progress::{Reporter, stop_requested};
use crate::training::trainer::Trainer;
use glam::DVec2;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Workers;
use seamwright_core::pipeline::learned::{MOST, learned_need};
use seamwright_core::pipeline::{Input, Method, Output, Report, Settings, UnwrapError, unwrap_by, unwrap_need};

/// A UV atlas of a mesh.
pub struct Atlas {
    /// UV of each corner, on a grid of 2^-24.
    pub corner_uv: Vec<DVec2>, // (c)
    /// Chart of each polygon.
    pub polygon_chart: Vec<u32>, // (p)
    /// Exposure of each vertex, 1 open.
    pub exposure: Vec<f32>, // (n)
    /// What was done.
    pub report: Report,
}

/// Makes the atlas of `loaded` with the exact method; see [`make_by`].
pub fn make(
    loaded: &Loaded,
    parts: Option<&[u32]>,
    keep_seams: bool,
    settings: &Settings,
    workers: &dyn Workers,
    progress: &mut Reporter,
) -> Result<Atlas, Failure> {
    make_by(args::line::Method::Exact, None, loaded, parts, keep_seams, settings, workers, progress)
}

/// Makes the atlas of `loaded`, with the borders of `parts` (one a polygon) as cuts where there are any. With `keep_seams` the borders of its own UVs stay cuts.
#[allow(clippy::too_many_arguments)]
pub fn make_by(
    method: args::line::Method,
    mut trainer: Option<&mut Trainer>,
    loaded: &Loaded,
    parts: Option<&[u32]>,
    keep_seams: bool,
    settings: &Settings,
    workers: &dyn Workers,
    progress: &mut Reporter,
) -> Result<Atlas, Failure> {
    let mesh = if keep_seams { loaded.mapped()?.0 } else { loaded.polygons()? };
    let input = Input {
        positions: &mesh.positions,
        corners: &mesh.corners,
        polygon_start: &mesh.polygon_start,
        kept_uv: mesh.corner_uv.as_deref().filter(|_| keep_seams),
        parts,
    };
    let mut atlas = empty(mesh);
    let triangles = mesh.corners.len().saturating_sub(2 * mesh.polygon_count());
    let learned = trainer.as_ref().map_or(0, |t| learned_need(triangles, mesh.positions.len(), &t.settings, MOST));
    let need = unwrap_need(&input, settings, &ObvhsBuilder).saturating_add(learned);
    let result = with_enough(need, |bytes| {
        let output = Output {
            corner_uv: &mut atlas.corner_uv,
            polygon_chart: &mut atlas.polygon_chart,
            exposure: &mut atlas.exposure,
        };
        let Some(trainer) = &mut trainer else {
            return unwrap_by(
                Method::Exact,
                output,
                &input,
                settings,
                &ObvhsBuilder,
                Scratch::new(bytes),
                workers,
                progress,
            );
        };
        let mut learning = trainer.learning();
        let by = match method {
            args::line::Method::Exact => Method::Exact,
            args::line::Method::Neural => Method::Neural(&mut learning),
            args::line::Method::Hybrid => Method::Hybrid(&mut learning),
        };
        let report = unwrap_by(by, output, &input, settings, &ObvhsBuilder, Scratch::new(bytes), workers, progress);
        trainer.summary = learning.summary;
        report
    })?;
    atlas.report = result.map_err(|e| failure(loaded, e))?;
    if stop_requested() { Err(Failure::Stopped) } else { Ok(atlas) }
}

/// Runs `work` with `need` bytes, and with twice as many as often as it asks for more. The error is that there are no
/// more; what else `work` says is handed on, as is a request that more memory does not change.
pub(crate) fn with_enough<T>(
    mut need: usize,
    mut work: impl FnMut(&mut [u8]) -> Result<T, UnwrapError>,
) -> Result<Result<T, UnwrapError>, Failure> {
    let mut last = None;
    loop {
        match work(&mut memory(need)?) {
            Err(UnwrapError::Scratch(e)) if e.need > e.given && last != Some(e) => {
                last = Some(e);
                // The request is one slice of many, so it says the least that is missing, not all of it.
                need = need.saturating_mul(2).max(need.saturating_add(e.need - e.given));
            }
            result => return Ok(result),
        }
    }
}

fn empty(mesh: &Mesh) -> Atlas {
    Atlas {
        corner_uv: vec![DVec2::ZERO; mesh.corners.len()],
        polygon_chart: vec![0; mesh.polygon_count()],
        exposure: vec![0.0; mesh.positions.len()],
        report: Report::default(),
    }
}

/// Zeroed bytes. Pages that are never touched cost nothing.
fn memory(need: usize) -> Result<Box<[u8]>, Failure> {
    bytemuck::allocation::try_zeroed_slice_box(need).map_err(|()| {
        let gigabytes = need as f64 / f64::from(1u32 << 30);
        Failure::Unreached(format!("{gigabytes:.1} GiB of memory are not to be had; free some or simplify the mesh"))
    })
}

pub(crate) fn failure(loaded: &Loaded, error: UnwrapError) -> Failure {
    match error {
        UnwrapError::Cancelled => Failure::Stopped,
        UnwrapError::Overlap { .. } => Failure::Unreached(format!(
            "{}: {error}; nothing is written; please report the mesh",
            loaded.path.display()
        )),
        UnwrapError::Scratch(e) => Failure::Unreached(format!("{}: {e}; please report this", loaded.path.display())),
        other => Failure::Input(format!("{}: {other}; repair the mesh", loaded.path.display())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seamwright_core::base::scratch::ScratchTooSmall;

    #[test]
    fn memory_that_nobody_has_is_an_error() {
        assert_eq!(memory(usize::MAX).map(|_| ()).map_err(|e| e.code()), Err(5));
        assert!(memory(1000).is_ok_and(|m| m.iter().all(|b| *b == 0)));
    }

    #[test]
    fn memory_grows_until_it_is_enough_or_does_not_help_or_there_is_none() {
        fn short<T>(need: usize, given: usize) -> Result<T, UnwrapError> {
            Err(UnwrapError::Scratch(ScratchTooSmall { need, given }))
        }
        let mut tries = vec![];
        let done = with_enough(100, |bytes| {
            tries.push(bytes.len());
            if bytes.len() < 350 { short(40, bytes.len() / 10) } else { Ok(bytes.len()) }
        });
        assert_eq!((done, tries), (Ok(Ok(400)), vec![100, 200, 400]));
        assert_eq!(with_enough(100, |b| if b.len() == 100 { short(950, 50) } else { Ok(b.len()) }), Ok(Ok(1000)));
        assert_eq!(with_enough(100, |_| short::<()>(2, 1)), Ok(short(2, 1)));
        assert_eq!(with_enough(100, |_| short::<()>(usize::MAX, 1)).map_err(|e| e.code()), Err(5));
        assert_eq!(with_enough(1, |_| Err::<(), _>(UnwrapError::Cancelled)), Ok(Err(UnwrapError::Cancelled)));
    }
}
