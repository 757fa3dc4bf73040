//! Which faces face the other way than their neighbours.
//!
//! A file keeps its order of corners where a face is turned against its neighbours, and the UVs of such a face are mirrored in the
//! eyes of whoever goes by that order. So faces are joined over their sides, first those that the map does not cut, then
//! over its seams, as long as they do not contradict one another; of each piece the lesser part by area is turned.
//! Sides of one face, of more than two, or of a face and its copy, join nothing. A surface that has no outside (a Moebius strip, a Klein bottle) contradicts
//! itself over its seams whatever is turned: there each chart alone decides, by the side that its UVs show.

use std::collections::{HashMap, HashSet};

/// What a face is joined to.
#[derive(Clone, Copy)]
struct Link {
    parent: u32,
    /// Whether it faces the other way than its parent.
    is_turned: bool,
}

/// Whether each face is turned. `rings` are the corners of each, `place` and `wedge` the numbers of corners by place, and by place
/// and UV; `area` is that of each face, and `uv_area` that in UV, positive counter-clockwise.
pub(super) fn turned(rings: &[Vec<u32>], place: &[u32], wedge: &[u32], area: &[f64], uv_area: &[f64]) -> Vec<bool> {
    let mut links: Vec<Link> = (0..rings.len() as u32).map(|parent| Link { parent, is_turned: false }).collect();
    let mut charts = Vec::new();
    let mut contradicting = Vec::new();
    for number in [wedge, place] {
        let mut faces: HashMap<[u32; 2], Vec<(u32, bool)>> = HashMap::new();
        for (face, ring) in rings.iter().enumerate() {
            let next = ring.iter().cycle().skip(1);
            for (a, b) in ring.iter().zip(next) {
                let (ends, way) = side(number[*a as usize], number[*b as usize]);
                faces.entry(ends).or_default().push((face as u32, way));
            }
        }
        // In the order of the file, so that what contradicts is the same each time.
        let mut pairs: Vec<[(u32, bool); 2]> = faces.into_values().filter_map(|all| all.try_into().ok()).collect();
        pairs.sort_unstable();
        let corners = |face: u32| {
            let mut corners: Vec<u32> = rings[face as usize].iter().map(|c| place[*c as usize]).collect();
            corners.sort_unstable();
            corners
        };
        pairs.retain(|[(a, a_way), (b, b_way)]| a_way != b_way || corners(*a) != corners(*b));
        contradicting.clear();
        for [(a, a_way), (b, b_way)] in pairs {
            if !join(&mut links, a, b, a_way == b_way) {
                contradicting.push(a);
            }
        }
        if charts.is_empty() {
            charts.clone_from(&links);
        }
    }
    let without_outside: HashSet<u32> = contradicting.iter().map(|face| root(&mut links, *face).parent).collect();
    let of_chart: Vec<Link> = (0..rings.len()).map(|face| root(&mut charts, face as u32)).collect();
    let mut shown: HashMap<u32, f64> = HashMap::new();
    for (link, area) in of_chart.iter().zip(uv_area) {
        *shown.entry(link.parent).or_default() += if link.is_turned { -area } else { *area };
    }
    let mut sums: HashMap<u32, [f64; 2]> = HashMap::new();
    let roots: Vec<Link> = (0..rings.len()).map(|face| root(&mut links, face as u32)).collect();
    for (link, area) in roots.iter().zip(area) {
        sums.entry(link.parent).or_default()[usize::from(link.is_turned)] += area;
    }
    let lesser = |link: &Link| link.is_turned == (sums[&link.parent][0] >= sums[&link.parent][1]);
    let hidden = |link: &Link| link.is_turned == (shown[&link.parent] >= 0.0);
    let both = roots.iter().zip(&of_chart);
    both.map(|(whole, chart)| if without_outside.contains(&whole.parent) { hidden(chart) } else { lesser(whole) })
        .collect()
}

/// A side's ends, in order of their numbers, and whether it runs from the greater to the less.
fn side(a: u32, b: u32) -> ([u32; 2], bool) {
    if a <= b { ([a, b], false) } else { ([b, a], true) }
}

/// The face at the root, and whether `face` is turned against it.
fn root(links: &mut [Link], face: u32) -> Link {
    let mut way = vec![face];
    while links[way[way.len() - 1] as usize].parent != way[way.len() - 1] {
        way.push(links[way[way.len() - 1] as usize].parent);
    }
    let parent = way[way.len() - 1];
    let mut is_turned = false;
    for face in way.into_iter().rev().skip(1) {
        is_turned ^= links[face as usize].is_turned;
        links[face as usize] = Link { parent, is_turned };
    }
    Link { parent, is_turned }
}

/// Joins two faces that run along their side the same way, or not; false where they hang together already and face otherwise.
fn join(links: &mut [Link], a: u32, b: u32, is_same_way: bool) -> bool {
    let (a, b) = (root(links, a), root(links, b));
    let is_turned = a.is_turned ^ b.is_turned ^ is_same_way;
    if a.parent != b.parent {
        links[b.parent as usize] = Link { parent: a.parent, is_turned };
        return true;
    }
    !is_turned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lesser_part_of_a_piece_is_turned() {
        // A strip of four triangles, the third of which faces the other way; and one that hangs on nothing.
        let place = [0, 1, 2, 2, 1, 3, 2, 4, 3, 3, 5, 4, 7, 8, 9];
        let rings: Vec<Vec<u32>> = (0..5).map(|f| vec![3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let wedge: Vec<u32> = (0..15).collect();
        let of = |area: [f64; 5], wedge: &[u32]| turned(&rings, &place, wedge, &area, &[1.0; 5]);
        assert_eq!(of([1.0; 5], &place), [false, false, true, false, false]);
        assert_eq!(of([1.0; 5], &wedge), [false, false, true, false, false], "over seams alike");
        assert_eq!(of([1.0, 1.0, 9.0, 1.0, 1.0], &place), [true, true, false, true, false]);
    }

    #[test]
    fn a_copy_of_a_face_is_not_turned() {
        let place = [0, 1, 2, 0, 1, 2, 2, 1, 3];
        let rings: Vec<Vec<u32>> = (0..3).map(|f| vec![3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let wedge: Vec<u32> = (0..9).collect();
        assert_eq!(turned(&rings[..2], &place[..6], &wedge[..6], &[1.0; 2], &[1.0; 2]), [false; 2]);
        assert_eq!(turned(&rings, &place, &wedge, &[1.0; 3], &[1.0; 3]), [false; 3]);
    }

    #[test]
    fn what_has_no_outside_is_turned_chart_by_chart() {
        // A Moebius strip of five triangles, each of which runs along the next one the same way.
        let place: Vec<u32> = (0..5).flat_map(|f| [f, f + 1, f + 2].map(|v| v % 5)).collect();
        let rings: Vec<Vec<u32>> = (0..5).map(|f| vec![3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let seams: Vec<u32> = (0..15).collect();
        let of = |uv_area: [f64; 5]| turned(&rings, &place, &seams, &[1.0; 5], &uv_area);
        assert_eq!(of([1.0; 5]), [false; 5]);
        assert_eq!(of([1.0, -1.0, 1.0, 1.0, -1.0]), [false, true, false, false, true]);
        // Where one of three can be turned, the map has no say.
        let place = [0, 1, 2, 0, 2, 3, 0, 1, 3];
        assert_eq!(turned(&rings[..3], &place, &seams[..9], &[1.0; 3], &[-1.0; 3]), [false, false, true]);
    }
}
