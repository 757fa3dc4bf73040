//! One atlas on the mesh, between cuts that are given: every region finds its chart and places, what is in the way yields, and the result is measured
//! and written where it has fewer faults than one before it.

use super::carried_map::CarriedMap;
use super::clear::clear;
use super::give_back::give_back;
use super::mesh_and_atlas::MeshAndAtlas;
use super::report::{TransferOutput, TransferReport};
use super::sheets::{Sheets, area};
use super::source::Walking;
use super::targets::Targets;
use super::untangle::Shapes;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::sort;
use crate::base::union_find::UnionFind;
use crate::base::workers::Workers;
use crate::mesh::view::NONE;
use crate::plane::grid::{GRID_BITS, GridPoint};
use crate::solve::energy::{MOLLIFY, Rest};
use glam::DVec2;

/// Share of the mesh's area below which a piece is small: it gives way to what it lies on. A flap of a decimated animal has a millionth.
const SMALL: f64 = 1e-4;
/// Texels that count as near, in the report.
const NEAR: f64 = 2.0;

impl MeshAndAtlas<'_> {
    /// Lays the atlas out between `cut`; returns how many faults it has. It is written, and told in `report`, where these are fewer than `below`.
    #[allow(clippy::too_many_arguments)]
    pub fn lay(
        &self,
        cut: &[u8],
        below: usize,
        report: &mut TransferReport,
        output: &mut TransferOutput,
        walking: &mut Walking,
        mut scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<usize, ScratchTooSmall> {
        let Self { atlas, onto, surface, hits, .. } = *self;
        let (mesh, faces) = (surface.mesh, hits.len());
        let sheets = Sheets::new(surface, cut, hits, atlas, walking, &mut scratch)?;
        let node = scratch.take::<[u32; 3]>(faces)?;
        let nodes = surface.wedges(cut, node.as_flattened_mut());
        let rest = scratch.take::<Rest>(faces)?;
        for (r, f) in rest.iter_mut().zip(mesh.faces) {
            *r = Rest::new(f.map(|v| mesh.positions[v as usize]), MOLLIFY);
        }
        let targets = Targets::new(nodes, node, mesh, &sheets, atlas, walking, &mut scratch)?;
        let x = scratch.take::<DVec2>(nodes)?;
        let grid = scratch.take::<GridPoint>(nodes)?;
        let chart = |f: usize| sheets.chart[sheets.region[f] as usize];
        let scale = |f: usize| atlas.scale[chart(f) as usize];
        let shapes = Shapes { node, rest, scale: &scale };
        let of_component = scratch.take::<f64>(onto.component_count)?;
        (0..faces).for_each(|f| of_component[onto.component[f] as usize] += area(mesh, f));
        let all: f64 = of_component.iter().sum();
        let small = |f: usize| of_component[onto.component[f] as usize] < SMALL * all;
        let in_square = atlas.is_in_square();
        let whole = CarriedMap { shapes, chart: &chart, source: atlas, in_square, small: &small };
        clear(x, grid, &targets, &whole, scratch.frame(), workers)?;
        let faults = give_back(grid, targets.fitted, &whole, scratch.frame(), workers)?;
        if faults.count() >= below {
            return Ok(faults.count());
        }
        (report.flipped, report.overlapping, report.small) = (faults.flipped, faults.overlapping, faults.small);
        x.iter_mut().zip(grid.iter()).for_each(|(x, g)| *x = g.uv(GRID_BITS));
        let texels = NEAR / f64::from(self.size.max(1));
        let far = |n: u32| x[n as usize].distance_squared(targets.fitted[n as usize]) > texels * texels;
        report.moved = node.iter().filter(|nodes| nodes.iter().any(|n| far(*n))).count();
        report.within_two_texels = targets.share_within(x, node, mesh, texels);
        let place = |f: usize, i: usize| onto.vertex_source[mesh.faces[f][i] as usize];
        let uv_at = |f: usize, i: usize| grid[node[f][i] as usize];
        report.regions = pieces_in_uv(&sheets, place, uv_at, scratch.frame())?;
        let has = scratch.take::<u8>(atlas.charts)?;
        sheets.chart.iter().for_each(|k| has[*k as usize] = 1);
        report.charts = has.iter().filter(|h| **h != 0).count();
        output.polygon_chart.fill(NONE);
        for (f, nodes) in node.iter().enumerate() {
            output.polygon_chart[onto.polygon[f] as usize] = chart(f);
            for (i, n) in nodes.iter().enumerate() {
                output.corner_uv[onto.corner_source[3 * f + i] as usize] =
                    whole.written(grid[*n as usize], f).uv(GRID_BITS);
            }
        }
        Ok(faults.count())
    }
}

/// Regions that hang together in UV: those of one chart that share a place and its UV are one.
fn pieces_in_uv(
    sheets: &Sheets,
    place: impl Fn(usize, usize) -> u32,
    uv: impl Fn(usize, usize) -> GridPoint,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let faces = sheets.region.len();
    let corners = scratch.take::<[i64; 4]>(3 * faces)?;
    for (c, corner) in corners.iter_mut().enumerate() {
        let (p, region) = (uv(c / 3, c % 3), sheets.region[c / 3]);
        *corner = [place(c / 3, c % 3).into(), p.x().into(), p.y().into(), region.into()];
    }
    sort::ascending(corners);
    let mut sets = UnionFind::new(scratch.take::<u32>(sheets.chart.len())?);
    for pair in corners.windows(2).filter(|pair| pair[0][..3] == pair[1][..3]) {
        let (a, b) = (pair[0][3] as u32, pair[1][3] as u32);
        if sheets.chart[a as usize] == sheets.chart[b as usize] {
            sets.union(a, b);
        }
    }
    Ok((0..sheets.chart.len() as u32).filter(|r| sets.find(*r) == *r).count())
}
