//! All figures of one UV-mapped mesh in one call.
//!
//! The outline of the judge: check the indices, areas, connectivity, then one floor of figures after another. Figures
//! that would be means over nothing are NaN, energies of collapsed maps infinite; counts are always right.

use super::atlas::{Atlas, atlas, atlas_need};
use super::charts::{ChartFigures, charts, charts_need};
use super::coverage::{Coverage, coverage_need, fitted_coverage};
use super::distortion::{Distortion, Sound, distortion, distortion_need};
use super::facing::{find_turned, find_turned_need};
use super::input::{UvBox, UvMesh, areas, areas_need};
use super::seams::{Seams, seams, seams_need};
use super::stacks::{Stacked, find_stacked, find_stacked_need};
use super::wedges::{UvTopology, uv_topology, uv_topology_need};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::workers::Serial;
use crate::mesh::view::NONE;
use crate::plane::grid::{GRID_BITS, GridPoint, GridTriangle, doubled_area};
use crate::plane::overlap::{overlaps, overlaps_need};
use glam::DVec2;

/// Texels a side at which coverage is sampled unless the caller says otherwise.
pub const RESOLUTION: u32 = 2048;
/// Examples of overlapping pairs that [`Exact`] keeps.
pub const EXAMPLES: usize = 4;

/// Figures of a UV-mapped mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metrics {
    /// Different vertex positions.
    pub vertices: usize,
    /// Triangles.
    pub faces: usize,
    /// Triangles with a corner that has no UV.
    pub faces_without_uv: usize,
    /// Area in space of all triangles.
    pub area: f64,
    /// Share of it that has no UV.
    pub area_without_uv: f64,
    /// Box of the UVs, or `None` where no triangle has any.
    pub uv_box: Option<UvBox>,
    /// Angles, areas, energies.
    pub distortion: Distortion,
    /// Charts, disks, flips.
    pub charts: ChartFigures,
    /// Seams and their exposure.
    pub seams: Seams,
    /// Overlap and utilisation in texels of the UVs' own box.
    pub coverage: Coverage,
    /// Overlaps and flips decided exactly.
    pub exact: Exact,
    /// Charts that coincide with another: they count as no overlap, and texels under them once.
    pub stacked: Stacked,
    /// Chart areas and texel density.
    pub atlas: Atlas,
}

/// Flips and overlaps of the UVs snapped to a grid, without rounding or sampling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exact {
    /// Grid steps a UV unit, as a power of two: 24, less where UVs reach beyond 63.
    pub grid_bits: i32,
    /// Faces whose interior meets another face's.
    pub overlapping_faces: usize,
    /// Charts that have such a face.
    pub overlapping_charts: usize,
    /// Some of these pairs; the first `min(overlapping_faces, EXAMPLES)` count.
    pub examples: [[u32; 2]; EXAMPLES],
    /// Faces whose orientation is not that of their chart (by its UV area), after those that neighbours outvote are turned.
    pub flipped_faces: usize,
    /// Faces that have UV and no UV area on the grid.
    pub zero_faces: usize,
}

/// Why there are no figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasureError {
    /// More memory is needed.
    Scratch(ScratchTooSmall),
    /// A triangle names a vertex that is not there.
    BadIndex {
        /// The triangle.
        triangle: usize,
    },
    /// UVs are not one a corner, or exposure is not one a vertex.
    BadLength {
        /// Entries that would fit.
        expected: usize,
        /// Entries that were there.
        given: usize,
    },
    /// More triangles than 32-bit corner numbers reach.
    TooLarge,
}

impl From<ScratchTooSmall> for MeasureError {
    fn from(e: ScratchTooSmall) -> Self {
        MeasureError::Scratch(e)
    }
}

impl core::fmt::Display for MeasureError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            MeasureError::Scratch(e) => e.fmt(f),
            MeasureError::BadIndex { triangle } => write!(f, "triangle {triangle} names a vertex that does not exist"),
            MeasureError::BadLength { expected, given } => write!(f, "{expected} entries expected, {given} given"),
            MeasureError::TooLarge => write!(f, "the mesh has more than {} triangles", u32::MAX / 3),
        }
    }
}

impl core::error::Error for MeasureError {}

/// Scratch bytes for [`measure`] with these counts: about 240 a triangle, or four a texel on top of 150.
pub const fn measure_need(vertices: usize, faces: usize, resolution: u32) -> usize {
    let kept = areas_need(faces) + uv_topology_need(vertices, faces) + 2 * bytes_for::<u8>(faces);
    let covered = coverage_need(resolution).saturating_add(bytes_for::<[DVec2; 3]>(faces));
    let steps = [
        find_turned_need(faces),
        distortion_need(faces),
        charts_need(faces),
        seams_need(vertices),
        find_stacked_need(faces),
        covered,
        exact_need(faces),
        atlas_need(faces),
    ];
    let (mut most, mut i) = (0, 0);
    while i < steps.len() {
        most = if steps[i] > most { steps[i] } else { most };
        i += 1;
    }
    kept.saturating_add(most)
}

/// Measures `mesh` (see [`UvMesh`] for what it may be: anything). `exposure` has one value a vertex, 1 open, 0
/// occluded; without it the figures of seams' exposure are left out. `resolution` is in texels a side ([`RESOLUTION`]),
/// 0 for none. Near-linear in triangles plus texels.
pub fn measure(
    mesh: UvMesh,
    exposure: Option<&[f32]>,
    resolution: u32,
    mut scratch: Scratch,
) -> Result<Metrics, MeasureError> {
    check(mesh, exposure)?;
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    scratch.require(measure_need(vertices, faces, resolution))?;
    let areas = areas(mesh, &mut scratch)?;
    let topology = uv_topology(mesh, &mut scratch)?;
    let turned = scratch.take::<u8>(faces)?;
    find_turned(turned, mesh, &topology, areas.solid, scratch.frame())?;
    let uv_box = mesh.uv_box();
    let sound = Sound::of(mesh, areas, uv_box.map_or(1.0, |b| b.extent()));
    let sum_where = |of: &dyn Fn(usize) -> bool| {
        areas.solid.iter().enumerate().filter(|(f, _)| of(*f)).fold(0.0, |sum, (_, a)| sum + a)
    };
    let area = sum_where(&|_| true);
    let stacked = scratch.take::<u8>(faces)?;
    let bits = uv_box.map_or(GRID_BITS, |b| b.grid_bits());
    let stacks = find_stacked(stacked, mesh.corner_uv, topology.chart, topology.chart_count, bits, scratch.frame())?;
    Ok(Metrics {
        vertices: topology.vertex_count,
        faces,
        faces_without_uv: faces - mesh.mapped_faces().count(),
        area,
        area_without_uv: sum_where(&|f| !mesh.has_uv(f)) / area,
        uv_box,
        distortion: distortion(mesh, areas, sound, scratch.frame())?,
        charts: charts(&topology, areas, turned, sound, scratch.frame())?,
        seams: seams(mesh, &topology, area, exposure, scratch.frame())?,
        coverage: match uv_box {
            Some(uv_box) => fitted_coverage(mesh, uv_box, resolution, scratch.frame())?,
            None => Coverage { resolution, ..Coverage::default() },
        },
        exact: exact(mesh, &topology, [turned, stacked], bits, scratch.frame())?,
        stacked: stacks,
        atlas: atlas(&topology, areas, scratch.frame())?,
    })
}

fn check(mesh: UvMesh, exposure: Option<&[f32]>) -> Result<(), MeasureError> {
    let fits = |expected: usize, given: usize| {
        if expected == given { Ok(()) } else { Err(MeasureError::BadLength { expected, given }) }
    };
    fits(mesh.triangles.len(), mesh.corner_uv.len())?;
    exposure.map_or(Ok(()), |e| fits(mesh.positions.len(), e.len()))?;
    if mesh.triangles.len() > (u32::MAX / 3) as usize || mesh.positions.len() >= NONE as usize {
        return Err(MeasureError::TooLarge);
    }
    let bad = |t: &[u32; 3]| t.iter().any(|v| *v as usize >= mesh.positions.len());
    mesh.triangles.iter().position(bad).map_or(Ok(()), |triangle| Err(MeasureError::BadIndex { triangle }))
}

const fn exact_need(faces: usize) -> usize {
    bytes_for::<GridTriangle>(faces)
        + bytes_for::<u32>(faces)
        + bytes_for::<i128>(faces)
        + bytes_for::<u8>(faces)
        + overlaps_need(faces)
}

fn exact(
    mesh: UvMesh,
    topology: &UvTopology,
    [turned, stacked]: [&[u8]; 2], // (f)
    bits: i32,
    mut scratch: Scratch,
) -> Result<Exact, ScratchTooSmall> {
    let mut out = Exact { grid_bits: bits, ..Exact::default() };
    let triangles = scratch.take::<GridTriangle>(mesh.triangles.len())?;
    mesh.mapped_faces().for_each(|f| triangles[f] = mesh.corner_uv[f].map(|uv: DVec2| GridPoint::snap(uv, bits)));

    let doubled = scratch.take::<i128>(topology.chart_count)?;
    let signed = |f: usize| doubled_area(&triangles[f]) as i128 * if turned[f] != 0 { -1 } else { 1 };
    let mapped =
        || topology.chart.iter().enumerate().filter(|(_, c)| **c != NONE).map(|(f, c)| (signed(f), *c as usize));
    mapped().for_each(|(area, c)| doubled[c] += area);
    for (area, c) in mapped() {
        let chart = doubled[c];
        out.zero_faces += (area == 0) as usize;
        out.flipped_faces += (area != 0 && area.signum() != chart.signum()) as usize;
    }

    // What lies on another chart as a whole takes no part: nothing overlaps a triangle without area.
    let hidden = triangles.iter_mut().zip(stacked).filter(|(_, stacked)| **stacked != 0);
    hidden.for_each(|(t, _)| *t = GridTriangle::default());
    let partner = scratch.take::<u32>(triangles.len())?;
    out.overlapping_faces = overlaps(partner, triangles, scratch.frame(), &Serial)?;
    let pairs = partner.iter().enumerate().filter(|(_, p)| **p != NONE).map(|(f, p)| [f as u32, *p]);
    out.examples.iter_mut().zip(pairs).for_each(|(example, pair)| *example = pair);
    let marks = scratch.take::<u8>(topology.chart_count)?;
    for (c, _) in topology.chart.iter().zip(partner).filter(|(_, p)| **p != NONE) {
        marks[*c as usize] = 1;
    }
    out.overlapping_charts = marks.iter().filter(|m| **m != 0).count();
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{hash, unit_f64};
    use glam::DVec3;
    use std::{vec, vec::Vec};

    fn judge(mesh: UvMesh, resolution: u32) -> Metrics {
        let exposure = vec![0.5; mesh.positions.len()];
        let mut bytes = vec![0; measure_need(mesh.positions.len(), mesh.triangles.len(), resolution)];
        let short = bytes.len() - 1;
        let refused = measure(mesh, Some(&exposure), resolution, Scratch::new(&mut bytes[..short]));
        assert_eq!(refused, Err(MeasureError::Scratch(ScratchTooSmall { need: short + 1, given: short })));
        measure(mesh, Some(&exposure), resolution, Scratch::new(&mut bytes)).unwrap()
    }

    #[test]
    fn a_flat_square_has_nothing_wrong_with_it() {
        let uv = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let positions = uv.map(|p| p.extend(3.0));
        let triangles = [[0, 1, 2], [0, 2, 3]];
        let corner_uv = triangles.map(|t: [u32; 3]| t.map(|v| uv[v as usize]));
        let m = judge(UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv }, 64);
        assert_eq!((m.vertices, m.faces, m.faces_without_uv, m.area), (4, 2, 0, 1.0));
        assert_eq!((m.distortion.angle, m.distortion.area_ln, m.distortion.symmetric_dirichlet), (0.0, 0.0, 4.0));
        assert_eq!((m.charts.count, m.charts.non_disks, m.charts.flipped_faces, m.seams.edges), (1, 0, 0, 0));
        assert_eq!((m.coverage.utilisation(), m.coverage.overlapped), (1.0, 0));
        assert_eq!(m.exact, Exact { grid_bits: 24, ..Exact::default() });
        assert_eq!(m.atlas.uv_area, 1.0);
    }

    #[test]
    fn a_folded_pair_overlaps_and_is_flipped() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)];
        let triangles = [[0, 1, 2], [1, 3, 2]];
        let (o, x, y) = (DVec2::ZERO, DVec2::X, DVec2::Y);
        let corner_uv = [[o, x, y], [x, DVec2::splat(0.25), y]];
        let m = judge(UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv }, 64);
        assert_eq!((m.exact.overlapping_faces, m.exact.overlapping_charts, m.exact.flipped_faces), (2, 1, 1));
        assert_eq!(m.exact.examples[..2], [[0, 1], [1, 0]]);
        assert_eq!((m.charts.flipped_faces, m.coverage.max_depth), (1, 2));
    }

    #[test]
    fn a_mesh_without_uv_or_without_faces_has_counts_only() {
        let missing = [[DVec2::NAN; 3]];
        let mesh =
            UvMesh { positions: &[DVec3::ZERO, DVec3::X, DVec3::Y], triangles: &[[0, 1, 2]], corner_uv: &missing };
        let m = judge(mesh, 16);
        assert_eq!((m.faces, m.faces_without_uv, m.area_without_uv, m.charts.count), (1, 1, 1.0, 0));
        assert!(m.distortion.angle.is_nan() && m.uv_box.is_none());
        assert_eq!(judge(UvMesh { positions: &[], triangles: &[], corner_uv: &[] }, 0).faces, 0);
    }

    #[test]
    fn bad_indices_and_lengths_are_named() {
        let mesh = UvMesh {
            positions: &[DVec3::ZERO; 3],
            triangles: &[[0, 1, 2], [0, 1, 3]],
            corner_uv: &[[DVec2::ZERO; 3]; 2],
        };
        let judge = |mesh, exposure| measure(mesh, exposure, 0, Scratch::new(&mut []));
        assert_eq!(judge(mesh, None), Err(MeasureError::BadIndex { triangle: 1 }));
        assert_eq!(judge(mesh, Some(&[0.0])), Err(MeasureError::BadLength { expected: 3, given: 1 }));
        let short = UvMesh { corner_uv: &[], ..mesh };
        assert_eq!(judge(short, None), Err(MeasureError::BadLength { expected: 2, given: 0 }));
    }

    #[test]
    fn nothing_panics_on_hostile_numbers() {
        let hostile = [0.0, -0.0, 1.0, f64::NAN, f64::INFINITY, f64::MAX, -f64::MAX, 1e-310, 1e300, 0.5];
        for seed in 0..300 {
            let pick = |i: u64| match hash(seed, 1, i) % 3 {
                0 => hostile[(hash(seed, 2, i) % 10) as usize],
                _ => unit_f64(seed, 3, i),
            };
            let positions: Vec<DVec3> = (0..9).map(|i| DVec3::new(pick(i), pick(i + 50), pick(i + 100))).collect();
            let triangles: Vec<[u32; 3]> =
                (0..12).map(|i| [0, 1, 2].map(|k| (hash(seed, 4, 3 * i + k) % 9) as u32)).collect();
            let uv = |c: u64| DVec2::new(pick(200 + c), pick(300 + c));
            let corner_uv: Vec<[DVec2; 3]> = (0..12).map(|i| [0, 1, 2].map(|k| uv(3 * i + k))).collect();
            judge(UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv }, 8);
        }
    }

    #[test]
    fn moving_and_scaling_uv_by_powers_of_two_changes_no_count() {
        let positions: Vec<DVec3> = (0..200).map(|i| DVec3::new(unit_f64(5, 0, i), unit_f64(5, 1, i), 0.0)).collect();
        let triangles: Vec<[u32; 3]> = (0..300).map(|i| [0, 1, 2].map(|k| (hash(6, k, i) % 200) as u32)).collect();
        // On the grid of 2^-20, so that moving is exact.
        let place = |v: u32| (positions[v as usize].truncate() * 1_048_576.0).as_uvec2().as_dvec2() / 1_048_576.0;
        let judge_at = |scale: f64, offset: f64| {
            let map = |t: &[u32; 3]| t.map(|v| place(v) * scale + DVec2::splat(offset));
            let corner_uv: Vec<[DVec2; 3]> = triangles.iter().map(map).collect();
            let m = judge(UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv }, 256);
            (m.exact.overlapping_faces, m.exact.flipped_faces, m.charts, m.seams.edges, m.coverage)
        };
        assert_eq!(judge_at(1.0, 0.0), judge_at(4.0, 0.0));
        let (overlapping, flipped, charts, edges, _) = judge_at(1.0, 8.0);
        let still = judge_at(1.0, 0.0);
        assert_eq!((overlapping, flipped, charts.count, edges), (still.0, still.1, still.2.count, still.3));
    }
}
