//! Triangles without area that nothing hangs on: flaps on edges that other faces have between them.
//!
//! Exporters leave them where they weld or cut; as faces they would be charts of no area, or take a neighbour from a face that
//! needs it. One is idle if each of its edges has no other face, or two faces with area at the least; what is idle is taken
//! away, until none is left. Those that fill a T-junction are not: the faces at their sides hang together by them.
//! Only polygons of three corners, and none where all are without area. O(c log c) in corners where a triangle has no area, else one pass.

use super::polygons::{Counts, Polygons};
use super::unit_box::UnitBox;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;

/// Bytes that [`idle`] takes, its own temporary ones included.
pub(super) const fn idle_need(counts: &Counts) -> usize {
    bytes_for::<u8>(counts.polygons).saturating_add(bytes_for::<[u32; 3]>(counts.corners))
}

/// A face whose height over its longest side is below this share of that side counts as one of zero area. It is
/// counted, and idle where nothing hangs on it: 1e-12 would leave out caps that one rounding moves, 1e-6 would count slivers that flatten well.
const FLAT: f64 = 1e-9;

const SOLID: u8 = 0;
const IDLE: u8 = 1;
const THIN: u8 = 2;

/// One mark a polygon, 1 where it is idle; nothing where no triangle is without area. `same` is the lowest vertex at the place
/// of each vertex.
pub(super) fn idle<'a>(
    input: &Polygons,
    same: &[u32],
    unit: &UnitBox,
    out: &mut Scratch<'a>,
) -> Result<&'a [u8], ScratchTooSmall> {
    let mark = out.take::<u8>(input.counts().polygons)?;
    let corner = |c: u32| same[input.corners[c as usize] as usize];
    let (mut thin, mut solid) = (0, 0);
    for (mark, polygon) in mark.iter_mut().zip(input.polygons()) {
        if polygon.len() == 3 {
            let [a, b, c] = [0, 1, 2].map(|i| corner(polygon.start + i));
            let flat =
                a != b && b != c && c != a && is_flat([a, b, c].map(|v| unit.place(input.positions[v as usize])));
            *mark = if flat { THIN } else { SOLID };
            thin += usize::from(flat);
            solid += usize::from(!flat);
        } else {
            solid += usize::from(polygon.len() > 3);
        }
    }
    if thin == 0 || solid == 0 {
        return Ok(&[]);
    }
    let mut frame = out.frame();
    let sides = frame.take::<[u32; 3]>(input.corners.len())?; // (low vertex, high vertex, polygon)
    let mut count = 0;
    for (p, polygon) in input.polygons().enumerate() {
        for c in polygon.clone() {
            let after = if c + 1 == polygon.end { polygon.start } else { c + 1 };
            let [a, b] = [corner(c), corner(after)];
            sides[count] = [a.min(b), a.max(b), p as u32];
            count += usize::from(a != b);
        }
    }
    let sides = &mut sides[..count];
    sort::ascending(sides);
    let mut found = usize::MAX;
    while found > 0 {
        found = take_away(mark, sides);
    }
    mark.iter_mut().for_each(|m| *m = u8::from(*m == IDLE));
    Ok(mark)
}

/// Turns thin polygons that are idle now from THIN to IDLE; returns how many.
fn take_away(mark: &mut [u8], sides: &[[u32; 3]]) -> usize {
    const NEEDED: u8 = 4; // beside THIN
    for group in sides.runs(|a, b| a[..2] == b[..2]) {
        let of = |kind: u8| group.iter().filter(|s| mark[s[2] as usize] & !NEEDED == kind).count();
        let (solid, thin) = (of(SOLID), of(THIN));
        if solid < 2 && solid + thin > 1 {
            group.iter().for_each(|s| {
                let mark = &mut mark[s[2] as usize];
                *mark |= if *mark & THIN != 0 { NEEDED } else { 0 };
            });
        }
    }
    let mut found = 0;
    for mark in mark.iter_mut() {
        found += usize::from(*mark == THIN);
        *mark = match *mark {
            THIN => IDLE,
            other => other & !NEEDED,
        };
    }
    found
}

/// Whether a triangle has (nearly) no area, see [`FLAT`].
pub(super) fn is_flat([a, b, c]: [glam::DVec3; 3]) -> bool {
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    let height = FLAT * longest; // times the longest side
    (b - a).cross(c - a).length_squared() <= height * height
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::{vec, vec::Vec};

    /// Of a row of squares over points (x, y); those of the first two triangles are one square.
    fn found(triangles: &[[u32; 3]]) -> Vec<u8> {
        let points = [(0., 0.), (2., 0.), (2., 2.), (0., 2.), (1., 0.), (1., -1.), (1., 1.)];
        let positions = points.map(|(x, y)| DVec3::new(x, y, 0.0));
        let polygon_start: Vec<u32> = (0..=triangles.len() as u32).map(|p| 3 * p).collect();
        let corners = triangles.as_flattened();
        let input = Polygons { positions: &positions, corners, polygon_start: &polygon_start, kept_uv: None };
        let mut bytes = vec![0; idle_need(&input.counts())];
        let same: Vec<u32> = (0..points.len() as u32).collect();
        let unit = UnitBox::new(positions.into_iter());
        idle(&input, &same, &unit, &mut Scratch::new(&mut bytes)).unwrap().to_vec()
    }

    #[test]
    fn a_flap_is_idle_on_an_edge_of_two_faces_and_alone() {
        let square = [[0, 1, 2], [0, 2, 3]];
        assert!(found(&square).is_empty());
        assert_eq!(found(&[square[0], square[1], [0, 6, 2]]), [0, 0, 1]);
        assert_eq!(found(&[square[0], [4, 5, 4], [3, 6, 1]]), [0, 0, 1]);
        assert!(found(&[[0, 4, 1]]).is_empty(), "nothing else is there");
        // On a border nobody hangs on the flap's two other sides; but it and the face are neighbours.
        assert_eq!(found(&[square[0], [0, 4, 1]]), [0, 0]);
    }

    #[test]
    fn what_fills_a_t_junction_is_needed() {
        assert_eq!(found(&[[0, 1, 2], [1, 0, 4], [0, 5, 4], [4, 5, 1]]), [0; 4]);
    }

    #[test]
    fn a_flap_on_a_flap_is_idle_after_it() {
        assert_eq!(found(&[[0, 1, 2], [0, 2, 3], [0, 6, 2], [0, 6, 2]]), [0, 0, 0, 0], "a pair closes on itself");
    }
}
