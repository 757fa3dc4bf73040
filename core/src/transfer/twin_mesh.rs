//! Two meshes that are one but for their numbering and winding: the atlas is copied, whatever it is like.
//!
//! Polygons correspond in their order, corners by their places, from any corner on and in either direction.

use crate::mesh::polygons::Polygons;
use core::ops::Range;
use glam::DVec2;

/// Corner of `source` that each corner of a polygon of `mesh` is: `None` where the polygon is another.
#[derive(Clone, Copy)]
struct Turn {
    first: u32,
    backwards: bool,
}

/// Whether every polygon of `mesh` is that of `source`.
pub fn is_twin(source: &Polygons, mesh: &Polygons) -> bool {
    source.polygon_start.len() == mesh.polygon_start.len()
        && source.polygons().zip(mesh.polygons()).all(|(a, b)| turn(source, a, mesh, b).is_some())
}

/// Writes the UVs of `source` to the corners of its twin.
pub fn copy_uvs(corner_uv: &mut [DVec2], source: &Polygons, uv: &[DVec2], mesh: &Polygons) {
    for (a, b) in source.polygons().zip(mesh.polygons()) {
        let Some(turn) = turn(source, a.clone(), mesh, b.clone()) else { continue };
        for (k, c) in b.enumerate() {
            corner_uv[c as usize] = uv.get(turn.corner(&a, k as u32) as usize).copied().unwrap_or(DVec2::NAN);
        }
    }
}

impl Turn {
    /// Corner of the polygon `a` that stands `k` corners behind the first.
    fn corner(self, a: &Range<u32>, k: u32) -> u32 {
        let n = (a.end - a.start).max(1);
        let back = if self.backwards { n - k % n } else { k };
        a.start + (self.first + back) % n
    }
}

fn turn(source: &Polygons, a: Range<u32>, mesh: &Polygons, b: Range<u32>) -> Option<Turn> {
    let at = |mesh: &Polygons, c: u32| {
        let vertex = mesh.corners.get(c as usize)?;
        mesh.positions.get(*vertex as usize).copied()
    };
    let n = a.end.checked_sub(a.start)?;
    if b.end.checked_sub(b.start) != Some(n) {
        return None;
    }
    let same = |turn: &Turn| {
        b.clone().enumerate().all(|(k, c)| {
            let place = at(mesh, c);
            place.is_some() && place == at(source, turn.corner(&a, k as u32))
        })
    };
    // The first corner alone rules most turns out.
    let turns = (0..n).flat_map(|first| [false, true].map(|backwards| Turn { first, backwards }));
    turns.into_iter().find(same)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn turned_and_wound_backwards_a_polygon_is_the_same_and_moved_it_is_not() {
        let mut points = [(0., 0.), (1., 0.), (1., 1.), (0., 2.)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let uv: [DVec2; 4] = core::array::from_fn(|i| DVec2::splat(i as f64));
        let start = [0, 4];
        fn of<'a>(positions: &'a [DVec3], corners: &'a [u32], polygon_start: &'a [u32]) -> Polygons<'a> {
            Polygons { positions, corners, polygon_start, kept_uv: None }
        }
        let own = points;
        let source = of(&own, &[0, 1, 2, 3], &start);
        for order in [[0, 1, 2, 3], [2, 3, 0, 1], [3, 2, 1, 0], [1, 0, 3, 2]] {
            let twin = of(&own, &order, &start);
            let mut out = [DVec2::NAN; 4];
            assert!(is_twin(&source, &twin));
            copy_uvs(&mut out, &source, &uv, &twin);
            assert_eq!(out, order.map(|v| DVec2::splat(f64::from(v))));
        }
        assert!(!is_twin(&source, &of(&own, &[0, 2, 1, 3], &start)));
        points[1].x = 1.5;
        assert!(!is_twin(&source, &of(&points, &[0, 1, 2, 3], &start)));
    }
}
