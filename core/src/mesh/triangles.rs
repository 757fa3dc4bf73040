//! The triangles that repair makes of polygons, by the corners of the file: for whoever looks at a file and has to see what
//! an unwrap of it saw.
//!
//! The same steps with the same result: vertices welded, repeats and spikes left out, ears clipped, pinched polygons in rings.
//! A polygon of which nothing comes is a fan from its first corner, so that it is seen and counted.
//! Memory: about 100 bytes a triangle.

use super::draft::Draft;
use super::facets::{facets, facets_need};
use super::polygons::{Counts, Polygons};
use super::repair::{RepairError, check};
use super::unit_box::UnitBox;
use super::view::NONE;
use super::weld::{weld, weld_need};
use crate::base::scratch::{Scratch, bytes_for};

/// Triangles of polygons.
#[derive(Clone, Copy, Debug)]
pub struct Triangles<'a> {
    /// Input corners of each triangle; the triangles of one polygon stand together.
    pub corners: &'a [[u32; 3]], // (t)
    /// Polygon of each triangle.
    pub polygon: &'a [u32], // (t)
}

/// Bytes that must be free for [`triangles_of`].
pub fn triangles_need(counts: &Counts) -> usize {
    let Counts { vertices, triangles, longest, polygons, .. } = *counts;
    if counts.are_too_many() {
        return usize::MAX;
    }
    let kept = bytes_for::<[u32; 3]>(triangles).saturating_add(bytes_for::<u32>(triangles));
    let steps = weld_need(vertices).max(facets_need(vertices, longest));
    kept.saturating_add(bytes_for::<u32>(vertices))
        .saturating_add(Draft::need(triangles))
        .saturating_add(bytes_for::<u64>(polygons.saturating_add(1)))
        .saturating_add(steps)
}

/// Lists the triangles of all polygons, none turned round; of a mesh without any, none. O(n log n) in vertices and corners,
/// plus what [`polygon`](super::polygon) says for long concave polygons.
pub fn triangles_of<'a>(input: &Polygons, out: &mut Scratch<'a>) -> Result<Triangles<'a>, RepairError> {
    out.require(triangles_need(&input.counts()))?;
    check(input)?;
    let (most, longest) = input.size();
    let corners = out.take::<[u32; 3]>(most)?;
    let polygon = out.take::<u32>(most)?;
    let mut frame = out.frame();
    let welded = frame.take_filled::<u32>(input.positions.len(), NONE)?;
    for &v in input.polygons().flat_map(|p| &input.corners[p.start as usize..p.end as usize]) {
        welded[v as usize] = v;
    }
    weld(welded, input.positions, frame.frame())?;
    let whole = UnitBox::new(welded.iter().filter(|v| **v != NONE).map(|v| input.positions[*v as usize]));
    let mut draft = Draft::take(&mut frame, most)?;
    let signature = frame.take::<u64>(input.polygon_start.len())?;
    let found = facets(&mut draft, signature, input, welded, &[], &whole, longest, frame.frame())?;
    let sources = draft.corner_source.as_chunks::<3>().0;
    let (mut count, mut next) = (0, 0);
    let mut put = |triangle: [u32; 3], p: usize| {
        (corners[count], polygon[count]) = (triangle, p as u32);
        count += 1;
    };
    for (p, range) in input.polygons().enumerate() {
        let own = draft.polygon[next..found.triangles].iter().take_while(|q| **q as usize == p).count();
        sources[next..next + own].iter().for_each(|t| put(*t, p));
        next += own;
        if own == 0 {
            (range.start.saturating_add(2)..range.end).for_each(|c| put([range.start, c - 1, c], p));
        }
    }
    Ok(Triangles { corners: &corners[..count], polygon: &polygon[..count] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::{vec, vec::Vec};

    fn found(points: &[(f64, f64)], polygons: &[&[u32]]) -> (Vec<[u32; 3]>, Vec<u32>) {
        let positions: Vec<DVec3> = points.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect();
        let corners = polygons.concat();
        let mut polygon_start = vec![0];
        polygons.iter().for_each(|p| polygon_start.push(polygon_start[polygon_start.len() - 1] + p.len() as u32));
        let input = Polygons { positions: &positions, corners: &corners, polygon_start: &polygon_start, kept_uv: None };
        let mut bytes = vec![0; triangles_need(&input.counts())];
        let short = bytes.len() - 1;
        assert!(triangles_of(&input, &mut Scratch::new(&mut bytes[..short])).is_err());
        let triangles = triangles_of(&input, &mut Scratch::new(&mut bytes)).unwrap();
        (triangles.corners.to_vec(), triangles.polygon.to_vec())
    }

    #[test]
    fn a_concave_quad_has_its_inner_diagonal_and_what_repair_drops_is_a_fan() {
        let points = [(0., 0.), (2., 0.), (0.5, 0.5), (0., 2.)];
        let (corners, polygon) = found(&points, &[&[1, 2, 3, 0], &[0, 1, 0, 1], &[0, 1, 2]]);
        assert_eq!(polygon, [0, 0, 1, 1, 2]);
        assert!(corners[..2].iter().all(|t| t.contains(&1) && t.contains(&3)), "{corners:?}");
        assert_eq!(corners[2..], [[4, 5, 6], [4, 6, 7], [8, 9, 10]]);
        assert_eq!(found(&points, &[]), (vec![], vec![]));
        assert_eq!(found(&points, &[&[0, 1]]), (vec![], vec![]));
    }
}
