//! Charts that lie on others as a whole: borders and corners of the one have the same places as those of the other.
//!
//! Where that is allowed, the first of them that faces up is judged. Of the others each face must be simple and face the way of its
//! chart: then it covers what its border encloses, each place once, by whichever faces. Faces that face opposite ways in UV are of
//! different charts: mirrored halves of one piece have the same UVs along their plane. Places are the same to half a step of 2^-24: a
//! chart may lie a square to the right, and a text rounds u and u + 1 apart.

use super::charts::{border, charts};
use super::tiles::tiles;
use glam::DVec2;
use std::collections::{HashMap, HashSet};

/// Places in steps of the grid.
const STEPS: f64 = (1 << 24) as f64;

/// For each ring, whether its chart lies on another that is judged. What `is_flat` on the mesh needs no area in UV.
pub fn stacked(rings: &[Vec<u32>], uv: &[DVec2], wedge: &[u32], is_flat: impl Fn(&[u32]) -> bool) -> Vec<bool> {
    let points = |ring: &[u32]| ring.iter().map(|c| uv[*c as usize]).collect::<Vec<_>>();
    let size = |ring: &[u32]| {
        let points = points(ring);
        points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| a.perp_dot(*b)).sum::<f64>()
    };
    let mut sided: Vec<u32> = wedge.iter().map(|w| 2 * w).collect();
    let all_of = |is: &dyn Fn(f64) -> bool| {
        let some = rings.iter().filter(|ring| is(size(ring)));
        some.flatten().map(|c| wedge[*c as usize]).collect::<HashSet<_>>()
    };
    let (up, down) = (all_of(&|size| size > 0.0), all_of(&|size| size < 0.0));
    // What has no area faces as what is around it.
    let is_down = |c: u32| down.contains(&wedge[c as usize]) && !up.contains(&wedge[c as usize]);
    let faces_up = |ring: &[u32]| match size(ring) {
        0.0 => !ring.iter().any(|c| is_down(*c)),
        size => size > 0.0,
    };
    for ring in rings.iter().filter(|ring| !faces_up(ring)) {
        ring.iter().for_each(|c| sided[*c as usize] |= 1);
    }
    let (chart, count) = charts(&sided, rings, &[]);
    let mut faces_up_all = vec![true; count];
    let mut broken = HashSet::new();
    for (ring, k) in rings.iter().zip(&chart) {
        let mut points = points(ring);
        if !faces_up(ring) {
            faces_up_all[*k as usize] = false;
            points.reverse();
        }
        if tiles(&points).is_none() && !is_flat(ring) {
            broken.insert(*k);
        }
    }
    let mut sides = vec![vec![]; count];
    let place = |c: u32| uv[c as usize].to_array().map(|x| (x * STEPS).round() as i64);
    for ([a, b], ring) in border(&sided, rings) {
        let mut ends = [a, b].map(place);
        ends.sort_unstable();
        sides[chart[ring] as usize].push(ends);
    }
    for (ring, k) in rings.iter().zip(&chart) {
        sides[*k as usize].extend(ring.iter().map(|c| [place(*c); 2]));
    }
    let mut sets = HashMap::<Vec<[[i64; 2]; 2]>, Vec<usize>>::new();
    for (k, mut sides) in sides.into_iter().enumerate().filter(|(k, _)| !broken.contains(&(*k as u32))) {
        sides.sort_unstable();
        sides.dedup();
        sets.entry(sides).or_default().push(k);
    }
    let mut lies_on = vec![false; count];
    for set in sets.values() {
        let judged = set.iter().find(|k| faces_up_all[**k]).unwrap_or(&set[0]);
        set.iter().filter(|k| *k != judged).for_each(|k| lies_on[*k] = true);
    }
    chart.iter().map(|k| lies_on[*k as usize]).collect()
}

/// UVs with what lies in the square to the right moved back.
pub fn moved_back(uv: &[DVec2]) -> Vec<DVec2> {
    uv.iter().map(|p| if p.x > 1.0 { *p - DVec2::X } else { *p }).collect()
}
