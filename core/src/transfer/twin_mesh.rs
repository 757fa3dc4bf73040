//! A mesh whose polygons are all polygons of another, in any order and with any numbering and winding, as after faces were deleted or
//! sorted: the atlas is copied, whatever it is like.
//!
//! Polygons correspond by the places of their corners, from any corner on and in either direction; of several that lie on one another the
//! first to the first. Cost: O(n log n).

use crate::base::random::hash;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::mesh::polygons::Polygons;
use core::ops::Range;
use glam::{DVec2, DVec3};

/// Corner of `source` that each corner of a polygon of `mesh` is: `None` where the polygon is another.
#[derive(Clone, Copy)]
struct Turn {
    first: u32,
    backwards: bool,
}

/// Scratch bytes that [`find_twins`] asks for, by the numbers of polygons.
pub const fn twins_need(source: usize, mesh: usize) -> usize {
    bytes_for::<[u64; 2]>(source).saturating_add(bytes_for::<[u64; 2]>(mesh))
}

/// Writes the polygon of `source` that each of `mesh` is; whether every one is.
pub fn find_twins(
    twin: &mut [u32], // (polygons of the mesh)
    source: &Polygons,
    mesh: &Polygons,
    mut scratch: Scratch,
) -> Result<bool, ScratchTooSmall> {
    let (all, own) = (by_places(source, &mut scratch)?, by_places(mesh, &mut scratch)?);
    let mut rest = all;
    let (mut last, mut rank) = (None, 0);
    for [key, polygon] in own.iter().copied() {
        rank = if last == Some(key) { rank + 1 } else { 0 };
        last = Some(key);
        rest = &rest[rest.partition_point(|other| other[0] < key)..];
        let like = &rest[..rest.partition_point(|other| other[0] == key)];
        // Those of its rank first: of copies each has its own.
        let mut candidates = like.iter().skip(rank).chain(like).map(|other| other[1] as u32);
        let is_same =
            |other: &u32| turn(source, polygon_of(source, *other), mesh, polygon_of(mesh, polygon as u32)).is_some();
        let Some(found) = candidates.find(is_same) else { return Ok(false) };
        twin[polygon as usize] = found;
    }
    Ok(true)
}

/// Hash of the places of each polygon's corners, in any order, and its number; ascending.
fn by_places<'k>(mesh: &Polygons, keep: &mut Scratch<'k>) -> Result<&'k [[u64; 2]], ScratchTooSmall> {
    let keys = keep.take::<[u64; 2]>(mesh.polygon_start.len().saturating_sub(1))?;
    for (i, (key, polygon)) in keys.iter_mut().zip(mesh.polygons()).enumerate() {
        let place = |c: u32| {
            // Zeros of both signs are one place.
            let [x, y, z] = (at(mesh, c).unwrap_or(DVec3::ZERO) + DVec3::ZERO).to_array().map(f64::to_bits);
            hash(x, y, z)
        };
        *key = [polygon.map(place).fold(0, u64::wrapping_add), i as u64];
    }
    sort::ascending(keys);
    Ok(keys)
}

/// Corners of a polygon.
fn polygon_of(mesh: &Polygons, polygon: u32) -> Range<u32> {
    let p = polygon as usize;
    mesh.polygon_start.get(p..p + 2).map_or(0..0, |ends| ends[0]..ends[1])
}

/// Place of a corner.
fn at(mesh: &Polygons, c: u32) -> Option<DVec3> {
    let vertex = mesh.corners.get(c as usize)?;
    mesh.positions.get(*vertex as usize).copied()
}

/// Writes the UVs of `source` to the corners of a mesh whose polygons are the `twin`s of its.
pub fn copy_uvs(corner_uv: &mut [DVec2], source: &Polygons, uv: &[DVec2], mesh: &Polygons, twin: &[u32]) {
    for (b, twin) in mesh.polygons().zip(twin) {
        let a = polygon_of(source, *twin);
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
    use std::vec;

    fn of<'a>(positions: &'a [DVec3], corners: &'a [u32], polygon_start: &'a [u32]) -> Polygons<'a> {
        Polygons { positions, corners, polygon_start, kept_uv: None }
    }

    /// UVs of the corners of `mesh`, where each corner of `source` has its number; nothing where it has other polygons.
    fn copied(source: &Polygons, mesh: &Polygons) -> Option<vec::Vec<f64>> {
        let mut memory = vec![0; 1 << 12];
        let mut twin = vec![0; mesh.polygon_start.len() - 1];
        let is_all = find_twins(&mut twin, source, mesh, Scratch::new(&mut memory)).unwrap();
        let uv: vec::Vec<DVec2> = (0..source.corners.len()).map(|i| DVec2::splat(i as f64)).collect();
        let mut out = vec![DVec2::NAN; mesh.corners.len()];
        copy_uvs(&mut out, source, &uv, mesh, &twin);
        is_all.then(|| out.iter().map(|uv| uv.x).collect())
    }

    #[test]
    fn turned_and_wound_backwards_a_polygon_is_the_same_and_moved_it_is_not() {
        let mut points = [(0., 0.), (1., 0.), (1., 1.), (0., 2.)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let own = points;
        let source = of(&own, &[0, 1, 2, 3], &[0, 4]);
        for order in [[0, 1, 2, 3], [2, 3, 0, 1], [3, 2, 1, 0], [1, 0, 3, 2]] {
            assert_eq!(copied(&source, &of(&own, &order, &[0, 4])).unwrap(), order.map(f64::from));
        }
        assert_eq!(copied(&source, &of(&own, &[0, 2, 1, 3], &[0, 4])), None);
        points[1].x = 1.5;
        assert_eq!(copied(&source, &of(&points, &[0, 1, 2, 3], &[0, 4])), None);
    }

    #[test]
    fn what_is_left_of_a_mesh_in_any_order_keeps_its_uvs_and_copies_have_their_own() {
        let points = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| DVec3::new(x, -y, 0.0));
        // Two triangles, the first of them twice.
        let source = of(&points, &[0, 1, 2, 0, 2, 3, 0, 1, 2], &[0, 3, 6, 9]);
        assert_eq!(copied(&source, &of(&points, &[3, 0, 2], &[0, 3])).unwrap(), [5.0, 3.0, 4.0]);
        let both = of(&points, &[1, 2, 0, 2, 3, 0, 2, 0, 1], &[0, 3, 6, 9]);
        assert_eq!(copied(&source, &both).unwrap(), [1.0, 2.0, 0.0, 4.0, 5.0, 3.0, 8.0, 6.0, 7.0]);
        // More copies than there are: the last are those of the first.
        let three = of(&points, &[0, 1, 2, 0, 1, 2, 0, 1, 2], &[0, 3, 6, 9]);
        assert_eq!(copied(&source, &three).unwrap(), [0.0, 1.0, 2.0, 6.0, 7.0, 8.0, 0.0, 1.0, 2.0]);
        assert_eq!(copied(&source, &of(&points, &[0, 1, 3], &[0, 3])), None);
    }
}
