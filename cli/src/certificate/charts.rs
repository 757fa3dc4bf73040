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
    let mut sets = Sets::new(wedge.iter().max().map_or(0, |most| *most as usize + 1));
    joined.iter().for_each(|[a, b]| sets.join(*a as usize, *b as usize));
    for ring in rings {
        ring[1..].iter().for_each(|c| sets.join(wedge[ring[0] as usize] as usize, wedge[*c as usize] as usize));
    }
    sets.numbered(rings.iter().map(|ring| wedge[ring[0] as usize] as usize))
}

/// Sets of numbers that are joined.
pub(super) struct Sets(Vec<usize>);

impl Sets {
    /// Each number below `count` by itself.
    pub fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    pub fn join(&mut self, a: usize, b: usize) {
        let [a, b] = [a, b].map(|member| self.root(member));
        self.0[b] = a;
    }

    fn root(&mut self, mut member: usize) -> usize {
        while self.0[member] != member {
            self.0[member] = self.0[self.0[member]];
            member = self.0[member];
        }
        member
    }

    /// The set of each of `members`, numbered from 0 as they come, and how many there are.
    pub fn numbered(mut self, members: impl Iterator<Item = usize>) -> (Vec<u32>, usize) {
        let mut numbers = HashMap::new();
        let of = |member: usize| {
            let next = numbers.len() as u32;
            *numbers.entry(self.root(member)).or_insert(next)
        };
        let sets = members.map(of).collect();
        (sets, numbers.len())
    }
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
