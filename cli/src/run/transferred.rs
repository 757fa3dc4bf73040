//! The atlas of one loaded mesh on another, by core.

use super::memory::with_enough;
use super::progress::Reporter;
use super::stop::stop_requested;
use crate::base::failure::Failure;
use crate::formats::loaded::Loaded;
use crate::mesh::polygons::Mesh;
use glam::DVec2;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Workers;
use seamwright_core::mesh::polygons::Polygons;
use seamwright_core::transfer::onto::{transfer_atlas, transfer_atlas_need};
use seamwright_core::transfer::report::{TransferError, TransferOutput, TransferReport};

/// An atlas that came from another mesh.
pub struct CarriedAtlas {
    /// UV of each corner, on a grid of 2^-24.
    pub corner_uv: Vec<DVec2>, // (c)
    /// Chart of the source that each polygon belongs to.
    pub polygon_chart: Vec<u32>, // (p)
    /// What was done.
    pub report: TransferReport,
}

/// Puts the atlas of `source` on `mesh`.
pub fn make(
    source: &Loaded,
    mesh: &Loaded,
    size: u32,
    workers: &dyn Workers,
    progress: &mut Reporter,
) -> Result<CarriedAtlas, Failure> {
    let (from, uv) = source.mapped()?;
    let onto = mesh.polygons()?;
    let (from, onto) = (polygons(from, Some(uv)), polygons(onto, None));
    let mut corner_uv = vec![DVec2::ZERO; onto.corners.len()];
    let mut polygon_chart = vec![0; onto.polygon_start.len() - 1];
    let need = transfer_atlas_need(&from.counts(), &onto.counts());
    let result = with_enough(need, |bytes| {
        let output = TransferOutput { corner_uv: &mut corner_uv, polygon_chart: &mut polygon_chart };
        transfer_atlas(output, &from, &onto, size, Scratch::new(bytes), workers, progress)
    })?;
    let report = result.map_err(|e| refusal(source, mesh, e))?;
    if stop_requested() { Err(Failure::Stopped) } else { Ok(CarriedAtlas { corner_uv, polygon_chart, report }) }
}

fn polygons<'a>(mesh: &'a Mesh, kept_uv: Option<&'a [DVec2]>) -> Polygons<'a> {
    let Mesh { positions, corners, polygon_start, .. } = mesh;
    Polygons { positions, corners, polygon_start, kept_uv }
}

fn refusal(source: &Loaded, mesh: &Loaded, error: TransferError) -> Failure {
    let (from, onto) = (source.path.display(), mesh.path.display());
    match error {
        TransferError::Stopped => Failure::Stopped,
        TransferError::Scratch(e) => Failure::Unreached(format!("{onto}: {e}; please report this")),
        TransferError::Source(e) => Failure::Input(format!("{from}: {e}; repair the mesh")),
        TransferError::NoUv { polygon } => Failure::Input(format!(
            "{from}: face {} has no texture coordinates; unwrap the mesh first: seamwright unwrap",
            polygon + 1
        )),
        TransferError::Apart { distance, extent } => Failure::Input(format!(
            "{onto}: its surface lies {distance:.4} from that of {from} on the mean, {:.1} % of its size; both must be one shape in \
             one place: move and scale the mesh as {from} is",
            100.0 * distance / extent
        )),
        TransferError::Reversed { share } => Failure::Input(format!(
            "{onto}: {:.0} % of its surface faces the other way than that of {from}: turn its faces round",
            100.0 * share
        )),
        TransferError::Stacked { faces, of } => Failure::Input(format!(
            "{from}: {faces} of {of} triangles of its atlas lie upon others, so that no place belongs to one of them alone; lay its charts side by side, \
             for example by seamwright unwrap --keep-seams"
        )),
        other => Failure::Input(format!("{onto}: {other}; repair the mesh")),
    }
}
