//! Charts as pieces of the plane: how many, which are disks, which no plane can hold, which faces are flipped, which charts
//! are mirrored.
//!
//! A chart with holes lies in the plane as well as a disk does. One without a border, or with a handle, cannot: a surface of
//! genus 0 with b loops of border has Euler number 2 - b, each handle takes 2. Loops that touch in a point count as one, so a
//! chart whose border meets itself there is taken for one with a handle.
//!
//! A chart's orientation is the sign of its UV area; a face is flipped when it has the other sign, after faces that
//! neighbours outvote are [`turned`](super::facing). A chart mirrored as a whole has no flipped face: it is counted apart,
//! against the orientation of the whole map. Faces that are degenerate or have no UV area are never flipped.

use super::distortion::Sound;
use super::input::Areas;
use super::wedges::UvTopology;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::mesh::view::NONE;

/// Counts over charts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChartFigures {
    /// Charts.
    pub count: usize,
    /// Charts whose Euler characteristic is not 1.
    pub non_disks: usize,
    /// Charts that no plane can hold: without a border, or with a handle.
    pub closed_or_handled: usize,
    /// Charts whose UV area has the other sign than the whole map's.
    pub mirrored: usize,
    /// Faces whose UV area has the other sign than their chart's.
    pub flipped_faces: usize,
    /// Share of the area (of faces with UV) that is flipped.
    pub flipped_area: f64,
}

/// Bytes that [`charts`] needs.
pub const fn charts_need(chart_count: usize) -> usize {
    bytes_for::<f64>(chart_count)
}

/// Counts disks, charts that no plane can hold, mirrored charts and flipped faces.
pub fn charts(
    topology: &UvTopology,
    areas: Areas,
    turned: &[u8], // (f), as of `find_turned`
    sound: Sound,
    mut scratch: Scratch,
) -> Result<ChartFigures, ScratchTooSmall> {
    scratch.require(charts_need(topology.chart_count))?;
    let signed = scratch.take::<f64>(topology.chart_count)?;
    let mapped = || topology.chart.iter().enumerate().filter(|(_, c)| **c != NONE).map(|(f, c)| (f, *c as usize));
    let uv_area = |f: usize| if turned[f] != 0 { -areas.uv[f] } else { areas.uv[f] };
    mapped().for_each(|(f, c)| signed[c] += uv_area(f));
    let flipped = |&(f, c): &(usize, usize)| {
        let uv = uv_area(f);
        areas.solid[f] > sound.solid_floor && uv.abs() > sound.uv_floor && sign(uv) != sign(signed[c])
    };
    let area = mapped().fold(0.0, |sum, (f, _)| sum + areas.solid[f]);
    let (flipped_faces, flipped_sum) =
        mapped().filter(flipped).fold((0, 0.0), |(n, a), (f, _)| (n + 1, a + areas.solid[f]));
    let majority = if signed.iter().sum::<f64>() < 0.0 { -1 } else { 1 };
    Ok(ChartFigures {
        count: topology.chart_count,
        non_disks: topology.euler.iter().filter(|x| **x != 1).count(),
        closed_or_handled: topology
            .euler
            .iter()
            .zip(topology.loops)
            .filter(|(x, loops)| **loops == 0 || **x != 2 - **loops)
            .count(),
        mirrored: signed.iter().filter(|s| sign(**s) == -majority).count(),
        flipped_faces,
        flipped_area: flipped_sum / area,
    })
}

/// -1, 0 or 1.
fn sign(x: f64) -> i32 {
    (x > 0.0) as i32 - (x < 0.0) as i32
}

#[cfg(test)]
mod tests {
    use super::super::facing::{find_turned, find_turned_need};
    use super::super::input::{UvMesh, areas, areas_need};
    use super::super::wedges::{uv_topology, uv_topology_need};
    use super::*;
    use approx::assert_abs_diff_eq;
    use glam::{DVec2, DVec3};
    use std::{vec, vec::Vec};

    /// A row of squares in space, two faces each, with UVs as given by `uv` of (square, corner's place).
    fn judge(squares: usize, uv: impl Fn(usize, DVec2) -> DVec2) -> ChartFigures {
        let place = |s: usize, i: usize| DVec2::new((s + i % 2) as f64, (i / 2) as f64);
        let (mut positions, mut triangles, mut corner_uv) = (vec![], vec![], vec![]);
        for s in 0..squares {
            positions.extend((0..4).map(|i| place(s, i).extend(0.0)));
            for t in [[0, 1, 3], [0, 3, 2]] {
                triangles.push(t.map(|i| (4 * s + i) as u32));
                corner_uv.push(t.map(|i| uv(s, place(s, i))));
            }
        }
        judge_mesh(&positions, &triangles, &corner_uv)
    }

    fn judge_mesh(positions: &[DVec3], triangles: &[[u32; 3]], corner_uv: &[[DVec2; 3]]) -> ChartFigures {
        let mesh = UvMesh { positions, triangles, corner_uv };
        let faces = triangles.len();
        let work = charts_need(faces).max(find_turned_need(faces));
        let mut bytes = vec![0; areas_need(faces) + uv_topology_need(positions.len(), faces) + work];
        let mut scratch = Scratch::new(&mut bytes);
        let areas = areas(mesh, &mut scratch).unwrap();
        let topology = uv_topology(mesh, &mut scratch).unwrap();
        let mut turned = vec![0; faces];
        find_turned(&mut turned, mesh, &topology, areas.solid, scratch.frame()).unwrap();
        charts(&topology, areas, &turned, Sound::of(mesh, areas, 1.0), scratch).unwrap()
    }

    #[test]
    fn a_strip_is_one_disk_without_flips() {
        assert_eq!(judge(4, |_, p| p), ChartFigures { count: 1, ..ChartFigures::default() });
    }

    #[test]
    fn a_chart_mirrored_as_a_whole_has_no_flips() {
        let charts = judge(3, |s, p| if s == 1 { DVec2::new(9.0 - p.x, p.y) } else { p });
        assert_eq!((charts.count, charts.mirrored, charts.flipped_faces), (3, 1, 0));
        // Where all is mirrored, nothing is mirrored against the rest.
        assert_eq!(judge(3, |_, p| DVec2::new(-p.x, p.y)).mirrored, 0);
    }

    #[test]
    fn a_folded_square_is_flipped_in_its_chart() {
        // x folds back after 2: the third square runs the other way under the second.
        let charts = judge(3, |_, p| DVec2::new(if p.x > 2.0 { 4.0 - p.x } else { p.x }, p.y));
        assert_eq!((charts.count, charts.flipped_faces, charts.mirrored), (1, 2, 0));
        assert_abs_diff_eq!(charts.flipped_area, 1.0 / 3.0, epsilon = 1e-12);
    }

    /// A grid of 5 x 5 squares without those of `holes`, each vertex at one UV; `vertex` says which it is at (x, y).
    fn judge_grid(holes: &[usize], vertex: impl Fn(u32, u32) -> u32) -> ChartFigures {
        let positions: Vec<DVec3> = (0..36).map(|v| DVec3::new((v % 6) as f64, (v / 6) as f64, 0.0)).collect();
        let square = |s: usize| {
            let (x, y) = (s as u32 % 5, s as u32 / 5);
            let [a, b, c, d] = [vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)];
            [[a, b, c], [a, c, d]]
        };
        let triangles: Vec<[u32; 3]> = (0..25).filter(|s| !holes.contains(s)).flat_map(square).collect();
        let uv: Vec<[DVec2; 3]> = triangles.iter().map(|t| t.map(|v| positions[v as usize].truncate())).collect();
        judge_mesh(&positions, &triangles, &uv)
    }

    #[test]
    fn a_plane_holds_charts_with_holes_but_none_that_is_closed_or_has_a_handle() {
        let faults = |charts: ChartFigures| (charts.count, charts.non_disks, charts.closed_or_handled);
        let flat = |x, y| 6 * y + x;
        let tube = |x, y| 6 * y + x % 5;
        let torus = |x, y| 6 * (y % 5) + x % 5;
        assert_eq!(faults(judge_grid(&[], flat)), (1, 0, 0));
        assert_eq!(faults(judge_grid(&[6], flat)), (1, 1, 0));
        assert_eq!(faults(judge_grid(&[6, 8, 18], flat)), (1, 1, 0));
        assert_eq!(faults(judge_grid(&[], tube)), (1, 1, 0));
        assert_eq!(faults(judge_grid(&[6, 18], tube)), (1, 1, 0));
        assert_eq!(faults(judge_grid(&[], torus)), (1, 1, 1));
        assert_eq!(faults(judge_grid(&[6], torus)), (1, 1, 1));
    }

    #[test]
    fn loops_that_touch_in_a_point_are_one() {
        let faults = |holes: &[usize]| {
            let charts = judge_grid(holes, |x, y| 6 * y + x);
            (charts.count, charts.non_disks, charts.closed_or_handled)
        };
        // Two holes with one corner, then a hole and a corner that is left out.
        assert_eq!(faults(&[6, 12]), (1, 1, 1));
        assert_eq!(faults(&[0, 6]), (1, 1, 1));
    }

    #[test]
    fn a_tetrahedron_of_one_chart_is_closed() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let flattened = |top: f64| {
            let place = |v: u32| corners[v as usize].truncate() + corners[v as usize].z * top * DVec2::ONE;
            let charts = judge_mesh(&corners, &faces, &faces.map(|t: [u32; 3]| t.map(place)));
            (charts.count, charts.non_disks, charts.closed_or_handled)
        };
        assert_eq!(flattened(0.3), (1, 1, 1));
        // As a convex quad it is two that coincide, folded along their border.
        assert_eq!(flattened(1.0), (2, 0, 0));
    }
}
