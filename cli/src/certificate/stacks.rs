//! Charts that lie on others as a whole: every face of the one has the corners of a face of the other, in whichever order.
//!
//! Where that is allowed, the first of them that faces up is judged, and the others need nothing but to coincide with it. Places are the
//! same to half a step of 2^-24: a chart may lie a square to the right, and a text rounds u and u + 1 apart.

use super::charts::charts;
use glam::DVec2;
use std::collections::HashMap;

/// Places in steps of the grid.
const STEPS: f64 = (1 << 24) as f64;

/// For each ring, whether its chart lies on another that is judged.
pub fn stacked(rings: &[Vec<u32>], uv: &[DVec2], wedge: &[u32]) -> Vec<bool> {
    let (chart, count) = charts(wedge, rings, &[]);
    let mut faces = vec![vec![]; count];
    let mut area = vec![0.0; count];
    for (ring, chart) in rings.iter().zip(&chart) {
        let points = || ring.iter().map(|c| uv[*c as usize]);
        let mut key: Vec<[i64; 2]> = points().map(|p| p.to_array().map(|x| (x * STEPS).round() as i64)).collect();
        key.sort_unstable();
        faces[*chart as usize].push(key);
        area[*chart as usize] += points().zip(points().cycle().skip(1)).map(|(a, b)| a.perp_dot(b)).sum::<f64>();
    }
    let mut sets = HashMap::<Vec<Vec<[i64; 2]>>, Vec<usize>>::new();
    for (k, mut faces) in faces.into_iter().enumerate() {
        faces.sort_unstable();
        sets.entry(faces).or_default().push(k);
    }
    let mut lies_on = vec![false; count];
    for set in sets.values() {
        let judged = set.iter().find(|k| area[**k] > 0.0).unwrap_or(&set[0]);
        set.iter().filter(|k| *k != judged).for_each(|k| lies_on[*k] = true);
    }
    chart.iter().map(|k| lies_on[*k as usize]).collect()
}

/// UVs with what lies in the square to the right moved back.
pub fn moved_back(uv: &[DVec2]) -> Vec<DVec2> {
    uv.iter().map(|p| if p.x > 1.0 { *p - DVec2::X } else { *p }).collect()
}
