//! Charts that lie on others as a whole: borders and corners of the one have the same places as those of the other.
//!
//! Where that is allowed, the first of them that faces up is judged. Of the others each face must be simple and face the way of its
//! chart: then it covers what its border encloses, each place once, by whichever faces. Faces hang together where they lie on both sides of
//! an edge in UV: mirrored halves of one piece have the same UVs along their plane, and lie on one side of it. Places are the same where
//! floats have one number for them a square to the right: a chart may lie there.

use super::charts::Sets;
use super::planar::doubled_area;
use super::tiles::tiles;
use glam::DVec2;
use std::collections::{HashMap, HashSet};

/// For each ring, whether its chart lies on another that is judged. `wedge` numbers places with their UVs, `vertex` the file's own
/// vertices, both a corner; what `is_flat` on the mesh needs no area in UV.
pub fn stacked(
    rings: &[Vec<u32>],
    uv: &[DVec2],
    wedge: &[u32],
    vertex: &[u32],
    is_flat: impl Fn(&[u32]) -> bool,
) -> Vec<bool> {
    let up = faces_up(rings, uv, wedge);
    let (chart, count) = charts(rings, &up, wedge, vertex);
    let (mut broken, mut chart_up) = (vec![false; count], vec![true; count]);
    let mut outline = vec![vec![]; count];
    // As a float holds it a square to the right.
    let place = |c: u32| uv[c as usize].to_array().map(|x| ((x + 1.0) as f32).to_bits());
    for ((ring, up), k) in rings.iter().zip(&up).zip(chart.iter().map(|k| *k as usize)) {
        let mut points: Vec<DVec2> = ring.iter().map(|c| uv[*c as usize]).collect();
        if !up {
            points.reverse();
        }
        chart_up[k] &= up;
        broken[k] |= tiles(&points).is_none() && !is_flat(ring);
        outline[k].extend(sides(ring, *up).map(|side| (side.map(place), 1)));
    }
    let mut sets = HashMap::<_, Vec<usize>>::new();
    for (k, outline) in outline.into_iter().enumerate().filter(|(k, _)| !broken[*k]) {
        sets.entry(border_and_corners(outline)).or_default().push(k);
    }
    let mut lies_on = vec![false; count];
    for set in sets.values().filter(|set| set.len() > 1) {
        let judged = set.iter().find(|k| chart_up[**k]).unwrap_or(&set[0]);
        set.iter().filter(|k| *k != judged).for_each(|k| lies_on[*k] = true);
    }
    chart.iter().map(|k| lies_on[*k as usize]).collect()
}

/// Whether each ring is counter-clockwise in UV. What has no area faces as what is around it.
fn faces_up(rings: &[Vec<u32>], uv: &[DVec2], wedge: &[u32]) -> Vec<bool> {
    let sizes: Vec<f64> = rings.iter().map(|ring| doubled_area(ring.iter().map(|c| uv[*c as usize]))).collect();
    let at = |is: &dyn Fn(f64) -> bool| {
        let some = rings.iter().zip(&sizes).filter(|(_, size)| is(**size)).flat_map(|(ring, _)| ring);
        some.map(|c| wedge[*c as usize]).collect::<HashSet<u32>>()
    };
    let (up, down) = (at(&|size| size > 0.0), at(&|size| size < 0.0));
    let is_down = |c: &u32| down.contains(&wedge[*c as usize]) && !up.contains(&wedge[*c as usize]);
    rings
        .iter()
        .zip(sizes)
        .map(|(ring, size)| if size == 0.0 { !ring.iter().any(is_down) } else { size > 0.0 })
        .collect()
}

/// Sides of a ring as it is seen from above, so that it lies to their left.
fn sides(ring: &[u32], up: bool) -> impl Iterator<Item = [u32; 2]> {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(move |(a, b)| if up { [*a, *b] } else { [*b, *a] })
}

/// Chart of each ring, and how many there are: rings hang together where one lies to the left of a side and the other to its right;
/// where more than two do, those that share the file's own vertices.
fn charts(rings: &[Vec<u32>], up: &[bool], wedge: &[u32], vertex: &[u32]) -> (Vec<u32>, usize) {
    let named = |side: [u32; 2], names: &[u32]| side.map(|c| names[c as usize]);
    let mut left = HashMap::<[u32; 2], Vec<([u32; 2], usize)>>::new();
    let all = || (0..rings.len()).flat_map(|r| sides(&rings[r], up[r]).map(move |side| (side, r)));
    all().for_each(|(side, r)| left.entry(named(side, wedge)).or_default().push((named(side, vertex), r)));
    let mut sets = Sets::new(rings.len());
    for ([a, b], r) in all() {
        let [p, q] = named([a, b], wedge);
        let Some(right) = left.get(&[q, p]) else { continue };
        let is_alone = right.len() == 1 && left[&[p, q]].len() == 1;
        for (_, other) in right.iter().filter(|(own, _)| is_alone || *own == named([b, a], vertex)) {
            sets.join(r, *other);
        }
    }
    sets.numbered(0..rings.len())
}

/// Places of a chart's corners, and the sides that have it on their left alone.
fn border_and_corners(mut sides: Vec<([[u32; 2]; 2], i32)>) -> Vec<([[u32; 2]; 2], i32)> {
    let corners: Vec<_> = sides.iter().map(|([a, _], _)| ([*a; 2], 0)).collect();
    for ([a, b], times) in sides.iter_mut().filter(|([a, b], _)| a > b) {
        core::mem::swap(a, b);
        *times = -*times;
    }
    sides.sort_unstable();
    let mut out: Vec<([[u32; 2]; 2], i32)> = Vec::new();
    for (ends, times) in sides {
        match out.last_mut().filter(|last| last.0 == ends) {
            Some(last) => last.1 += times,
            None => out.push((ends, times)),
        }
    }
    out.retain(|(ends, times)| *times != 0 && ends[0] != ends[1]);
    out.extend(corners);
    out.sort_unstable();
    out.dedup();
    out
}

/// UVs with what lies in the square to the right moved back.
pub fn moved_back(uv: &[DVec2]) -> Vec<DVec2> {
    uv.iter().map(|p| if p.x > 1.0 { *p - DVec2::X } else { *p }).collect()
}
