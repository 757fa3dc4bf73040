//! What hangs together in UV: faces that share a vertex and its UV.

use crate::mesh::polygons::Mesh;
use std::collections::{HashMap, HashSet};

/// A corner without its face: vertices at one place with one UV have one number.
pub(super) fn wedges(mesh: &Mesh, uv: &[glam::DVec2], place: &[u32]) -> Vec<u32> {
    let mut numbers = HashMap::with_capacity(mesh.positions.len());
    let corners = place.iter().zip(uv);
    corners
        .map(|(place, uv)| {
            let next = numbers.len() as u32;
            *numbers.entry((*place, (*uv + 0.0).to_array().map(f64::to_bits))).or_insert(next)
        })
        .collect()
}

/// Pairs of wedges on the two sides of closed cracks: sides of rings whose ends have the same UVs, and lie within `widest` of one
/// another in space.
pub(super) fn across_cracks(
    mesh: &Mesh,
    uv: &[glam::DVec2],
    wedge: &[u32],
    rings: &[Vec<u32>],
    widest: f64,
) -> Vec<[u32; 2]> {
    let at = |c: u32| mesh.positions[mesh.corners[c as usize] as usize];
    let named = |side: [u32; 2]| side.map(|c| (uv[c as usize] + 0.0).to_array().map(f64::to_bits));
    let sides = border(wedge, rings);
    let mut of: HashMap<_, Vec<[u32; 2]>> = HashMap::new();
    sides.iter().for_each(|(side, _)| of.entry(named(*side)).or_default().push(*side));
    let mut pairs = Vec::new();
    for ([a, b], _) in &sides {
        for [c, d] in of.get(&named([*b, *a])).into_iter().flatten() {
            let ends = [[*a, *d], [*b, *c]];
            if ends.iter().all(|[p, q]| at(*p).distance(at(*q)) <= widest) {
                pairs.extend(ends.map(|end| end.map(|c| wedge[c as usize])));
            }
        }
    }
    pairs
}

/// The chart of each ring, numbered from 0 as they come, and how many there are. `rings` are corners, `joined` pairs of wedges that
/// are of one chart.
pub(super) fn charts(wedge: &[u32], rings: &[Vec<u32>], joined: &[[u32; 2]]) -> (Vec<u32>, usize) {
    let mut parent: Vec<u32> = (0..wedge.iter().max().map_or(0, |most| most + 1)).collect();
    fn root(parent: &mut [u32], mut w: u32) -> u32 {
        while parent[w as usize] != w {
            parent[w as usize] = parent[parent[w as usize] as usize];
            w = parent[w as usize];
        }
        w
    }
    for pair in joined {
        let [a, b] = pair.map(|w| root(&mut parent, w));
        parent[b as usize] = a;
    }
    for ring in rings {
        let first = root(&mut parent, wedge[ring[0] as usize]);
        for corner in &ring[1..] {
            let other = root(&mut parent, wedge[*corner as usize]);
            parent[other as usize] = first;
        }
    }
    let mut numbers = HashMap::new();
    let of = |ring: &Vec<u32>| {
        let next = numbers.len() as u32;
        *numbers.entry(root(&mut parent, wedge[ring[0] as usize])).or_insert(next)
    };
    let charts = rings.iter().map(of).collect();
    (charts, numbers.len())
}

/// Sides of rings, as two corners and the ring, on whose other side no ring lies.
pub(super) fn border(wedge: &[u32], rings: &[Vec<u32>]) -> Vec<([u32; 2], usize)> {
    let sides = || {
        rings.iter().enumerate().flat_map(|(r, ring)| {
            let next = ring.iter().cycle().skip(1);
            ring.iter().zip(next).map(move |(a, b)| ([*a, *b], r))
        })
    };
    let named = |side: [u32; 2]| side.map(|c| wedge[c as usize]);
    let all: HashSet<[u32; 2]> = sides().map(|(side, _)| named(side)).collect();
    sides().filter(|([a, b], _)| !all.contains(&named([*b, *a]))).collect()
}
