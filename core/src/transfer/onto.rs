//! From a mesh with an atlas to the same atlas on another mesh of the same shape, the same place and any tessellation.
//!
//! Both are repaired as for unwrapping; the borders of the atlas become paths on the other mesh (`routes`), the regions between
//! them its charts (`sheets`); nodes go where the atlas has them (`targets`) and yield where faces would turn over or overlap
//! (`clear`). The packing is that of the source, to the texel: nothing is packed, turned or scaled.
//! A mesh whose polygons are all polygons of the source, in whatever order, has their UVs copied. Refused are meshes that lie elsewhere or face the other way,
//! and atlases whose charts lie upon one another.
//! Guaranteed: UVs on a grid of 2^-24; what is left of flips and overlaps is counted exactly. The report's share is measured on
//! the final UVs. Cost: O(n log n), and what the walks visit.

use super::arcs::{Arcs, arcs_need};
use super::clear::clear_need;
use super::closest::{ClosestTree, closest_tree_need};
use super::give_back::give_back_need;
use super::mesh_and_atlas::MeshAndAtlas;
use super::report::{TransferError, TransferOutput, TransferReport};
use super::routes::{Ground, route, routes_need};
use super::sheets::{NearestFace, area, find_hits, majority, middle};
use super::source::{SourceAtlas, Walking, source_need};
use super::strays::{part_strays, strays_need};
use super::targets::targets_need;
use super::twin_mesh::{copy_uvs, find_twins, twins_need};
use crate::base::progress::{Progress, Stage, tell};
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::charts::surface::{Surface, surface_need};
use crate::finish::fill::{fill_dropped, fill_dropped_need};
use crate::mesh::polygons::{Counts, Polygons};
use crate::mesh::repair::{Facing, RepairError, repair, repair_need};
use crate::mesh::view::{MeshView, NONE};
use crate::mesh::working::Working;
use crate::plane::grid::{GRID_BITS, GridPoint, GridTriangle};
use crate::plane::overlap::{overlaps, overlaps_need};
use crate::solve::energy::Rest;
use glam::{DVec2, DVec3};

/// Mean distance of two surfaces, over the source's extent, from which they are not the same shape in the same place.
/// A quarter of the faces are .001 to .003, a twentieth up to .008; at .01 a texture of 1024 texels is off by ten.
const APART: f64 = 0.01;
/// Share of a mesh's area that looks the other way than the source, from which on it is wound the other way.
const REVERSED: f64 = 0.5;
/// Faces that are looked at for that.
const LOOKS: usize = 4096;
/// Share of the source's faces that lie upon others from which on they do so on purpose: no place is theirs alone.
const STACKED: f64 = 0.02;
/// Share of the mesh's area below which what is cut out is a flake: the rest of its chart is elsewhere, and an island of its own serves nobody.
const FLAKE: f64 = 1e-3;
/// Rounds in which strays are brought to where they belong: each shows what the ones before it hid.
const STRAY_ROUNDS: usize = 4;

/// Scratch bytes that [`transfer_atlas`] asks for: an estimate from above for meshes as they occur.
pub fn transfer_atlas_need(source: &Counts, mesh: &Counts) -> usize {
    let (a, b) = (source.triangles, mesh.triangles);
    let of_source = repair_need(source)
        .saturating_add(source_need(3 * a, a))
        .saturating_add(bytes_for::<u32>(a).saturating_mul(3))
        .saturating_add(arcs_need(3 * a, a))
        .saturating_add(overlaps_need(a) + bytes_for::<GridTriangle>(a));
    let nodes = (b + 64).max(mesh.vertices).min(3 * b) + b;
    let state = bytes_for::<DVec2>(nodes).saturating_mul(2).saturating_add(bytes_for::<[u32; 3]>(b));
    let joined = bytes_for::<[i64; 4]>(3 * b).saturating_add(bytes_for::<u32>(b));
    let clearing = targets_need(b) + clear_need(nodes, b).max(give_back_need(nodes, b)).max(joined) + state;
    let work = routes_need(3 * b, 3 * a).max(strays_need(b, a)).max(clearing);
    let of_mesh = repair_need(mesh)
        .saturating_add(surface_need(b, 3 * b))
        .saturating_add(closest_tree_need(b))
        .saturating_add(
            bytes_for::<Rest>(b) + bytes_for::<NearestFace>(b) + bytes_for::<DVec3>(3 * b) + bytes_for::<f64>(b),
        )
        .saturating_add(bytes_for::<u32>(b).saturating_mul(4))
        .saturating_add(bytes_for::<u8>(9 * b)) // cuts that were tried
        .saturating_add(work);
    let twins = twins_need(source.polygons, mesh.polygons)
        .saturating_add(bytes_for::<u32>(mesh.polygons.saturating_add(source.polygons)));
    of_source
        .saturating_add(of_mesh)
        .saturating_add(fill_dropped_need(mesh))
        .saturating_add(twins)
        .saturating_add(1 << 14)
}

/// Writes the atlas of `source`, whose `kept_uv` it is, to the corners of `mesh`. `size` is the texture's side in texels, for the
/// report.
pub fn transfer_atlas(
    mut output: TransferOutput,
    source: &Polygons,
    mesh: &Polygons,
    size: u32,
    mut scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<TransferReport, TransferError> {
    let counts = mesh.counts();
    for (expected, given) in [(counts.corners, output.corner_uv.len()), (counts.polygons, output.polygon_chart.len())] {
        if expected != given {
            return Err(TransferError::Length { expected, given });
        }
    }
    tell(progress, Stage::Repair, 0, 2)?;
    let facing = Facing::Turned;
    let (from, _) = repair(source, facing, &mut scratch).map_err(in_source)?;
    let uv = source.kept_uv.unwrap_or(&[]);
    let uv_of = |c: u32| uv.get(c as usize).copied().unwrap_or(DVec2::NAN);
    if let Some(c) = from.corner_source.iter().position(|c| !uv_of(*c).is_finite()) {
        return Err(TransferError::NoUv { polygon: from.polygon[c / 3] as usize });
    }
    let atlas = SourceAtlas::new(&from, uv_of, &mut scratch)?;
    tell(progress, Stage::Repair, 1, 2)?;
    let (mut onto, _) = repair(mesh, facing, &mut scratch).map_err(in_mesh)?;
    let positions = scratch.take::<DVec3>(onto.positions.len())?;
    for (p, q) in positions.iter_mut().zip(onto.positions) {
        *p = (*q * onto.extent + onto.centre - from.centre) / from.extent;
    }
    onto.positions = positions;
    let mut report = TransferReport { source_charts: atlas.charts, extent: from.extent, ..TransferReport::default() };
    report.source_flipped = atlas.flipped;
    report.source_overlapping = overlapping(&atlas, scratch.frame(), workers)?;
    let twin = scratch.take::<u32>(counts.polygons)?;
    if find_twins(twin, source, mesh, scratch.frame())? {
        copy_uvs(output.corner_uv, source, uv, mesh, twin);
        let chart = scratch.take_filled::<u32>(source.counts().polygons, NONE)?;
        from.polygon.iter().zip(atlas.chart).for_each(|(p, k)| chart[*p as usize] = *k);
        output.polygon_chart.iter_mut().zip(twin.iter()).for_each(|(to, p)| *to = chart[*p as usize]);
        let has = scratch.take::<u8>(atlas.charts)?;
        output.polygon_chart.iter().filter(|k| **k != NONE).for_each(|k| has[*k as usize] = 1);
        tell(progress, Stage::Check, 1, 1)?;
        let charts = has.iter().filter(|h| **h != 0).count();
        return Ok(TransferReport {
            charts,
            regions: charts,
            overlapping: report.source_overlapping,
            within_two_texels: 1.0,
            copied: true,
            ..report
        });
    }
    if report.source_overlapping as f64 > STACKED * from.faces.len() as f64 {
        return Err(TransferError::Stacked { faces: report.source_overlapping, of: from.faces.len() });
    }
    let carried = Carried { from: &from, atlas: &atlas, onto: &onto, size };
    carried.run(&mut report, &mut output, scratch.frame(), workers, progress)?;
    fill_dropped(output.corner_uv, mesh, &onto, scratch)?;
    tell(progress, Stage::Check, 1, 1)?;
    Ok(report)
}

fn in_source(e: RepairError) -> TransferError {
    match e {
        RepairError::Scratch(e) => TransferError::Scratch(e),
        e => TransferError::Source(e),
    }
}

fn in_mesh(e: RepairError) -> TransferError {
    match e {
        RepairError::Scratch(e) => TransferError::Scratch(e),
        e => TransferError::Mesh(e),
    }
}

/// Faces of the source that overlap another.
fn overlapping(atlas: &SourceAtlas, mut scratch: Scratch, workers: &dyn Workers) -> Result<usize, ScratchTooSmall> {
    let faces = atlas.chart.len();
    let triangles = scratch.take::<GridTriangle>(faces)?;
    for (f, t) in triangles.iter_mut().enumerate() {
        *t = [0, 1, 2].map(|i| GridPoint::snap(atlas.seen(atlas.chart[f], atlas.uv[3 * f + i]), GRID_BITS));
    }
    overlaps(scratch.take::<u32>(faces)?, triangles, scratch, workers)
}

/// The two meshes.
struct Carried<'c> {
    from: &'c Working<'c>,
    atlas: &'c SourceAtlas<'c>,
    onto: &'c Working<'c>,
    size: u32,
}

impl Carried<'_> {
    /// Writes UVs and charts of the working mesh's corners and polygons.
    fn run(
        &self,
        report: &mut TransferReport,
        output: &mut TransferOutput,
        mut scratch: Scratch,
        workers: &dyn Workers,
        progress: &mut dyn Progress,
    ) -> Result<(), TransferError> {
        let Self { atlas, onto, .. } = *self;
        let (mesh, faces) = (onto.mesh(), onto.faces.len());
        tell(progress, Stage::Cut, 0, 1)?;
        let reversed = reversed_share(mesh, atlas);
        if reversed > REVERSED {
            return Err(TransferError::Reversed { share: reversed });
        }
        let hits = scratch.take::<NearestFace>(faces)?;
        find_hits(hits, mesh, atlas, workers);
        report.distance = mean_distance(mesh, hits) * self.from.extent;
        if report.distance.is_nan() || report.distance > APART * self.from.extent {
            return Err(TransferError::Apart { distance: report.distance, extent: self.from.extent });
        }
        let surface = Surface::new(mesh, onto.twin, &[], &[], &mut scratch)?;
        let cut = scratch.take::<u8>(onto.twin.len())?;
        self.cut(cut, &surface, hits, scratch.frame())?;
        tell(progress, Stage::Flatten, 0, 1)?;
        let mut walking = Walking::new(atlas.chart.len(), &mut scratch)?;
        let both = MeshAndAtlas { onto, atlas, surface: &surface, hits, size: self.size };
        let mut fewest = usize::MAX;
        // Where the atlas has faults without islands of flakes they are kept, and at last only what would else be lost.
        let flakes = [FLAKE, 0.0, 1.0];
        let tried = scratch.take::<u8>(flakes.len() * cut.len())?;
        for (k, flake) in flakes.into_iter().enumerate() {
            let (earlier, rest) = tried.parted_mut(k * cut.len());
            let own = &mut rest[..cut.len()];
            own.copy_from(cut);
            for _ in 0..STRAY_ROUNDS {
                if !part_strays(own, &both, flake, &mut walking, scratch.frame())? {
                    break;
                }
            }
            if earlier.rows(cut.len()).any(|cut| *cut == *own) {
                continue;
            }
            tell(progress, Stage::Check, 0, 1)?;
            fewest = fewest.min(both.lay(own, fewest, report, output, &mut walking, scratch.frame(), workers)?);
            if fewest == 0 {
                break;
            }
        }
        Ok(())
    }

    /// Cuts the borders of the atlas into the mesh.
    fn cut(
        &self,
        cut: &mut [u8],
        surface: &Surface,
        hits: &[NearestFace],
        mut scratch: Scratch,
    ) -> Result<(), ScratchTooSmall> {
        let Self { from, atlas, onto, .. } = *self;
        let of_component = scratch.take::<u32>(onto.component_count)?;
        let hit_component = |f: usize| from.component[hits[f].face as usize];
        majority(of_component, surface.mesh, |f| onto.component[f], hit_component, scratch.frame())?;
        let component = scratch.take::<u32>(hits.len())?;
        component.iter_mut().zip(onto.component).for_each(|(c, own)| *c = of_component[*own as usize]);
        let tree = ClosestTree::new(surface.mesh, &mut scratch)?;
        let arcs = Arcs::new(atlas, &mut scratch)?;
        let ground = Ground { surface, fixed: onto.fixed, tree: &tree, component };
        route(cut, &ground, atlas, from.component, &arcs, scratch)
    }
}

/// Share of the area whose faces look the other way than the nearest of the source, of a sample.
fn reversed_share(mesh: MeshView, source: &SourceAtlas) -> f64 {
    let step = mesh.faces.len().div_ceil(LOOKS).max(1);
    let (mut against, mut all) = (0.0, 0.0);
    for f in (0..mesh.faces.len()).step_by(step) {
        let Some(hit) = source.tree.find(middle(mesh, f), |_| true) else { continue };
        let own = area(mesh, f);
        let looks = mesh.area_vector(f).dot(source.surface.mesh.area_vector(hit.face as usize));
        against += if looks < 0.0 { own } else { 0.0 };
        all += own;
    }
    if all > 0.0 { against / all } else { 0.0 }
}

/// Mean distance of the faces' middles, by area.
fn mean_distance(mesh: MeshView, hits: &[NearestFace]) -> f64 {
    let (mut sum, mut all) = (0.0, 0.0);
    for (f, hit) in hits.iter().enumerate() {
        let own = area(mesh, f);
        sum += own * sqrt(hit.squared);
        all += own;
    }
    if all > 0.0 { sum / all } else { f64::INFINITY }
}
