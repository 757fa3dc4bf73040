//! Sides of polygons on whose other side no polygon lies.

use super::polygons::Polygons;
use crate::base::slices::Slices;
use crate::base::sort;

/// The vertices that stand for the two ends, and the polygon.
pub(super) type OpenSide = [u32; 3];

/// Fills `edges` with the sides of polygons that no other side lies upon; returns how many.
pub(super) fn border(edges: &mut [OpenSide], sides: &mut [[u32; 3]], same: &[u32], input: &Polygons) -> usize {
    let vertex = |c: u32| same[input.corners[c as usize] as usize];
    let mut count = 0;
    for polygon in input.polygons() {
        for c in polygon.clone() {
            let after = if c + 1 == polygon.end { polygon.start } else { c + 1 };
            let [a, b] = [vertex(c), vertex(after)];
            sides[count] = [a.min(b), a.max(b), c];
            count += usize::from(a != b);
        }
    }
    let sides = &mut sides[..count];
    sort::ascending(sides);
    let mut count = 0;
    let polygon = |c: u32| input.polygon_start.partition_point(|start| *start <= c).saturating_sub(1) as u32;
    for group in sides.runs(|a, b| a[..2] == b[..2]) {
        let Some([low, high, c]) = alone(group, polygon) else { continue };
        let from = vertex(c);
        edges[count] = [from, if from == low { high } else { low }, polygon(c)];
        count += 1;
    }
    count
}

/// The one side of an edge's that is a border: a polygon that runs along an edge there and back lies on neither side of it.
fn alone(group: &[[u32; 3]], polygon: impl Fn(u32) -> u32) -> Option<[u32; 3]> {
    match *group {
        [side] => return Some(side),
        [_, _] => return None,
        _ => {}
    }
    let mut odd = group.runs(|a, b| polygon(a[2]) == polygon(b[2])).filter(|own| own.len() % 2 == 1);
    match (odd.next(), odd.next()) {
        (Some(own), None) => own.first().copied(),
        _ => None,
    }
}
