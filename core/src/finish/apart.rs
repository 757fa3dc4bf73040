//! Polygons that no map holds on the grid, each set apart as a chart of its own with equal sides.
//!
//! A needle whose height is below a step of the grid has no area there, and the triangles of a polygon, which are never
//! cut from one another, may lie on each other after rounding. Cutting elsewhere does not help: what helps is another
//! shape. A regular polygon has none of this whatever its corners are, so this is the last resort that ends every run
//! with a valid atlas. Its distortion is what it is, and is reported.
//! Guarantee: disks stay disks; a polygon that is set apart has no flip and no overlap unless it is beyond the grid's
//! room. Cost: O(n log n) for the charts that lose a polygon.

use crate::base::real::{cos, sin, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::charts::surface::Surface;
use crate::first::disks::disks_again;
use crate::mesh::view::NONE;
use crate::plane::grid::{GridTriangle, doubled_area};
use core::f64::consts::TAU;
use glam::DVec2;

/// Least radius, over the square root of all area: 128 steps of a grid of 2^24 in a full square. Less than 16 steps would
/// leave a polygon of 40 corners flat sides; 1e-3 would show.
const LEAST: f64 = 1.0 / (1 << 17) as f64;

/// Marks the faces that are not counter-clockwise on the grid, however small they are in space; returns how many.
pub fn mark_turned(failing: &mut [u8], triangles: &[GridTriangle]) -> usize {
    let mut count = 0;
    for (mark, t) in failing.iter_mut().zip(triangles) {
        *mark = u8::from(doubled_area(t) <= 0);
        count += usize::from(*mark);
    }
    count
}

/// Cuts the polygons that hold a face with `failing` set out of their charts and makes them regular. Edges of infinite cost
/// hold the faces of a polygon together.
pub fn set_apart(
    uv: &mut [DVec2],
    cut: &mut [u8],
    failing: &mut [u8], // (f): spreads to the faces of the same polygon
    surface: &Surface,
    area: f64, // of all charts in UV, for the least size
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    spread(failing, surface);
    for f in (0..failing.len() as u32).filter(|f| failing[*f as usize] != 0) {
        for c in 3 * f..3 * f + 3 {
            if surface.cost[c as usize].is_finite() {
                surface.set_cut(cut, c, true);
            }
        }
    }
    disks_again(cut, surface, scratch.frame())?;
    let done = scratch.take::<u8>(failing.len())?;
    for first in 0..3 * failing.len() as u32 {
        let face = (first / 3) as usize;
        if failing[face] == 0 || done[face] != 0 || !surface.is_open(cut, first) {
            continue;
        }
        let (mut corners, mut length) = (0, 0.0);
        for c in surface.border(cut, first) {
            corners += 1;
            length += surface.length(c);
        }
        let radius = (length / TAU).max(LEAST * sqrt(area));
        for (i, c) in surface.border(cut, first).enumerate() {
            let angle = TAU * i as f64 / f64::from(corners);
            let place = DVec2::new(cos(angle), sin(angle)) * radius;
            for d in surface.wedge(cut, surface.wedge_start(cut, c)) {
                uv[d as usize] = place;
                done[(d / 3) as usize] = 1;
            }
        }
    }
    Ok(())
}

/// Sets the flag of every face whose polygon has it set for one.
fn spread(failing: &mut [u8], surface: &Surface) {
    loop {
        let mut more = false;
        for c in 0..3 * failing.len() as u32 {
            let t = surface.twin[c as usize];
            if t != NONE
                && surface.cost[c as usize].is_infinite()
                && failing[(t / 3) as usize] > failing[(c / 3) as usize]
            {
                failing[(c / 3) as usize] = 1;
                more = true;
            }
        }
        if !more {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::topology::twins;
    use crate::mesh::view::MeshView;
    use crate::solve::energy::Rest;
    use approx::assert_abs_diff_eq;
    use glam::DVec3;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn what_is_turned_over_or_flat_on_the_grid_is_marked() {
        let at = |x, y| crate::plane::grid::GridPoint::new(x, y);
        let [a, b, c] = [at(0, 0), at(4, 0), at(0, 4)];
        let mut failing = [9; 3];
        assert_eq!(mark_turned(&mut failing, &[[a, b, c], [a, c, b], [a, b, b]]), 2);
        assert_eq!(failing, [0, 1, 1]);
    }

    /// A strip of three squares, the middle one a polygon of two triangles of which one fails.
    #[test]
    fn a_failing_polygon_becomes_a_regular_chart_and_its_neighbours_stay() {
        let positions: Vec<DVec3> = (0..8).map(|i| DVec3::new(f64::from(i / 2), f64::from(i % 2), 0.0)).collect();
        let faces: Vec<[u32; 3]> =
            (0..3).flat_map(|k| [[2 * k, 2 * k + 2, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 1]]).collect();
        let mesh = MeshView { positions: &positions, faces: &faces };
        let mut bytes = vec![0u8; 1 << 16];
        let mut scratch = Scratch::new(&mut bytes);
        let mut twin = vec![NONE; 18];
        twins(&mut twin, mesh, scratch.frame()).unwrap();
        let cost: Vec<f64> = (0..18).map(|c| if [8, 9].contains(&c) { f64::INFINITY } else { 1.0 }).collect();
        assert_eq!((twin[8], twin[9]), (9, 8));
        let rest: Vec<Rest> = faces.iter().map(|f| Rest::new(f.map(|v| positions[v as usize]), 0.0)).collect();
        let surface = Surface::new(mesh, &twin, &rest, &cost, &mut scratch).unwrap();
        let mut uv: Vec<DVec2> = (0..18).map(|c| mesh.position(c).truncate()).collect();
        let before = uv.clone();
        let (mut cut, mut failing) = (vec![0; 18], vec![0, 0, 1, 0, 0, 0]);
        set_apart(&mut uv, &mut cut, &mut failing, &surface, 3.0, scratch).unwrap();
        assert_eq!(failing, [0, 0, 1, 1, 0, 0]);
        assert_eq!((&uv[..6], &uv[12..]), (&before[..6], &before[12..]));
        let (mut chart, mut queue) = ([0; 6], [0; 6]);
        assert_eq!(surface.charts(&cut, &mut chart, &mut queue), 3);
        // A square of the same girth: sides of the square root of 2 times 4 / TAU.
        let radius = 4.0 / TAU;
        assert!(uv[6..12].iter().all(|p| (p.length() - radius).abs() < 1e-12), "{uv:?}");
        let area = |f: usize| (uv[3 * f + 1] - uv[3 * f]).perp_dot(uv[3 * f + 2] - uv[3 * f]);
        assert_abs_diff_eq!(area(2), 2.0 * radius * radius, epsilon = 1e-12);
        assert_abs_diff_eq!(area(3), area(2), epsilon = 1e-12);
        assert_eq!((uv[6], uv[8]), (uv[9], uv[10])); // the diagonal holds
    }
}
