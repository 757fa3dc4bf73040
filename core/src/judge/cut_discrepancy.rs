//! How far the cuts of one partition lie from those of another, along the surface.
//!
//! Chen, Golovinskiy, Funkhouser 2009: the mean geodesic distance from the points of one partition's cuts to the nearest
//! point of the other's, there and back, over the mean distance of the surface from its centre. Geodesics run along edges,
//! from all cuts at once (Dijkstra 1959), so they are too long by a few percent where the mesh is even; points are the
//! ends of cut edges, weighted by length. Vertices at one place are one. Cost: O(f log f).

use crate::base::heap::Heap;
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::mesh::view::NONE;
use crate::mesh::weld::{weld, weld_need};
use glam::DVec3;

/// A mesh as its file has it.
#[derive(Clone, Copy)]
pub struct FileMesh<'a> {
    /// Vertex positions, finite.
    pub positions: &'a [DVec3], // (n)
    /// Vertices of each triangle, below n.
    pub triangles: &'a [[u32; 3]], // (f)
}

/// Scratch bytes that [`cut_discrepancy`] needs.
pub const fn cut_discrepancy_need(vertices: usize, triangles: usize) -> usize {
    let sides = triangles.saturating_mul(3);
    let of_vertices =
        bytes_for::<u32>(vertices).saturating_mul(4).saturating_add(bytes_for::<f64>(vertices).saturating_mul(2));
    let of_sides = bytes_for::<[u32; 3]>(sides).saturating_add(bytes_for::<[u32; 2]>(sides).saturating_mul(2));
    of_vertices
        .saturating_add(of_sides)
        .saturating_add(bytes_for::<u8>(sides))
        .saturating_add(weld_need(vertices))
        .saturating_add(64)
}

/// The cut discrepancy of two labelings of the triangles: 0 where neither has a cut, NaN where only one has, infinite where
/// some cut has no way to any cut of the other. A face without a label ([`NONE`]) cuts nothing.
///
/// Panics unless there is one label of each a triangle.
pub fn cut_discrepancy(
    mesh: FileMesh,
    ours: &[u32],
    reference: &[u32],
    mut scratch: Scratch,
) -> Result<f64, ScratchTooSmall> {
    let (n, f) = (mesh.positions.len(), mesh.triangles.len());
    assert!(ours.len() == f && reference.len() == f, "one label of each a triangle");
    scratch.require(cut_discrepancy_need(n, f))?;
    let graph = PlaceGraph::new(mesh, ours, reference, &mut scratch)?;
    let there = graph.mean_distance(OURS, REFERENCE, &mut scratch)?;
    let back = graph.mean_distance(REFERENCE, OURS, &mut scratch)?;
    Ok((there + back) / radius(mesh))
}

/// Flags of an edge.
const OURS: u8 = 1;
const REFERENCE: u8 = 2;

/// Places and the edges between them.
struct PlaceGraph<'m, 'g> {
    mesh: FileMesh<'m>,
    edges: &'g [[u32; 2]], // (e), low place first
    cut: &'g [u8],         // (e)
    start: &'g [u32],      // (n + 1), into `beside`
    beside: &'g [u32],     // (2 e), places
}

impl<'m, 'g> PlaceGraph<'m, 'g> {
    fn new(
        mesh: FileMesh<'m>,
        ours: &[u32],
        reference: &[u32],
        keep: &mut Scratch<'g>,
    ) -> Result<Self, ScratchTooSmall> {
        let (n, sides_count) = (mesh.positions.len(), 3 * mesh.triangles.len());
        let edges = keep.take::<[u32; 2]>(sides_count)?;
        let cut = keep.take::<u8>(sides_count)?;
        let start = keep.take::<u32>(n + 1)?;
        let beside = keep.take::<u32>(2 * sides_count)?;
        let mut frame = keep.frame();
        let same = frame.take::<u32>(n)?;
        same.iter_mut().enumerate().for_each(|(v, s)| *s = v as u32);
        weld(same, mesh.positions, frame.frame())?;
        let sides = frame.take::<[u32; 3]>(sides_count)?; // low, high, triangle
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let place = corners.map(|v| same[v as usize]);
            for i in 0..3 {
                let (a, b) = (place[i], place[(i + 1) % 3]);
                sides[3 * t + i] = [a.min(b), a.max(b), t as u32];
            }
        }
        sort::ascending(sides);
        let mut count = 0;
        for group in sides.runs(|a, b| a[..2] == b[..2]).filter(|g| g[0][0] != g[0][1]) {
            edges[count] = [group[0][0], group[0][1]];
            let differs = |labels: &[u32]| {
                let mut known = group.iter().map(|s| labels[s[2] as usize]).filter(|l| *l != NONE);
                let first = known.next();
                known.any(|l| Some(l) != first)
            };
            cut[count] = if differs(ours) { OURS } else { 0 } | if differs(reference) { REFERENCE } else { 0 };
            start[group[0][0] as usize] += 1;
            start[group[0][1] as usize] += 1;
            count += 1;
        }
        // Counts become ends, and filling from behind turns ends into starts.
        let mut end = 0;
        for s in start.iter_mut() {
            end += *s;
            *s = end;
        }
        for edge in edges[..count].iter().rev() {
            for (at, other) in [(edge[0], edge[1]), (edge[1], edge[0])] {
                start[at as usize] -= 1;
                beside[start[at as usize] as usize] = other;
            }
        }
        Ok(Self { mesh, edges: &edges[..count], cut: &cut[..count], start, beside })
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        let d = self.mesh.positions[a as usize] - self.mesh.positions[b as usize];
        sqrt(d.dot(d))
    }

    /// Mean distance of the points of cuts `from` to the nearest of cuts `to`: 0 where there is neither, NaN where one of
    /// them is missing.
    fn mean_distance(&self, from: u8, to: u8, scratch: &mut Scratch) -> Result<f64, ScratchTooSmall> {
        let cuts = |flag: u8| self.edges.iter().zip(self.cut).filter(move |(_, c)| **c & flag != 0).map(|(e, _)| *e);
        match [from, to].map(|flag| cuts(flag).next().is_some()) {
            [false, false] => return Ok(0.0),
            [true, true] => {}
            _ => return Ok(f64::NAN),
        }
        let n = self.mesh.positions.len();
        let mut frame = scratch.frame();
        let distance = frame.take_filled::<f64>(n, f64::INFINITY)?;
        let (cost, slot, item) = (frame.take::<f64>(n)?, frame.take::<u32>(n)?, frame.take::<u32>(n)?);
        let mut heap = Heap::new(cost, slot, item);
        cuts(to).flatten().for_each(|v| heap.push(v, 0.0));
        while let Some((v, d)) = heap.pop() {
            // A place that comes back is no nearer than it was.
            if d >= distance[v as usize] {
                continue;
            }
            distance[v as usize] = d;
            for &w in &self.beside[self.start[v as usize] as usize..self.start[v as usize + 1] as usize] {
                let further = d + self.length(v, w);
                if further < distance[w as usize] {
                    heap.push(w, further);
                }
            }
        }
        let (sum, length) = cuts(from).fold((0.0, 0.0), |(sum, length), [a, b]| {
            let l = self.length(a, b);
            (sum + 0.5 * l * (distance[a as usize] + distance[b as usize]), length + l)
        });
        Ok(if length > 0.0 { sum / length } else { 0.0 })
    }
}

/// Mean distance of the surface from its centre, by the centroids of triangles weighted by area; 1 where that is nothing.
fn radius(mesh: FileMesh) -> f64 {
    let face = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let normal = (b - a).cross(c - a);
        ((a + b + c) / 3.0, 0.5 * sqrt(normal.dot(normal)))
    };
    let (sum, area) = mesh.triangles.iter().map(face).fold((DVec3::ZERO, 0.0), |(s, t), (p, a)| (s + p * a, t + a));
    let centre = sum / area;
    let far = mesh.triangles.iter().map(face).fold(0.0, |sum, (p, a)| {
        let d = p - centre;
        sum + a * sqrt(d.dot(d))
    });
    let mean = far / area;
    if mean > 0.0 { mean } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use std::{vec, vec::Vec};

    /// A strip of squares of side 1, two triangles each, every triangle with vertices of its own.
    fn strip(squares: usize) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let (mut positions, mut triangles) = (vec![], vec![]);
        for s in 0..squares {
            let at = |x: usize, y: usize| DVec3::new((s + x) as f64, y as f64, 0.0);
            for t in [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]] {
                let first = positions.len() as u32;
                positions.extend(t);
                triangles.push([first, first + 1, first + 2]);
            }
        }
        (positions, triangles)
    }

    fn judge(squares: usize, ours: impl Fn(usize) -> u32, reference: impl Fn(usize) -> u32) -> f64 {
        let (positions, triangles) = strip(squares);
        let labels = |of: &dyn Fn(usize) -> u32| (0..2 * squares).map(|t| of(t / 2)).collect::<Vec<_>>();
        let mut bytes = vec![0; cut_discrepancy_need(positions.len(), triangles.len())];
        let mesh = FileMesh { positions: &positions, triangles: &triangles };
        cut_discrepancy(mesh, &labels(&ours), &labels(&reference), Scratch::new(&mut bytes)).unwrap()
    }

    #[test]
    fn cuts_three_squares_apart_are_three_there_and_three_back() {
        let (positions, triangles) = strip(10);
        let radius = radius(FileMesh { positions: &positions, triangles: &triangles });
        let found = judge(10, |s| u32::from(s < 3), |s| u32::from(s < 6));
        // Sums of three ones are exact; one quotient is rounded.
        assert_abs_diff_eq!(found, 6.0 / radius, epsilon = 1e-14);
        // The centre is that of the strip: five to either side, two and a half on the mean, but for the height.
        assert!((2.5..2.7).contains(&radius), "{radius}");
    }

    #[test]
    fn the_same_cuts_have_no_distance_and_other_names_change_nothing() {
        assert_eq!(judge(6, |s| u32::from(s < 3), |s| 7 - u32::from(s < 3)), 0.0);
        assert_eq!(judge(6, |_| 1, |_| 0), 0.0);
    }

    #[test]
    fn a_partition_without_cuts_has_no_distance_to_one_with_cuts() {
        assert!(judge(6, |_| 1, |s| u32::from(s < 3)).is_nan());
        assert!(judge(6, |s| u32::from(s < 3), |_| 1).is_nan());
        assert!(judge(6, |s| if s < 3 { NONE } else { 4 }, |s| u32::from(s < 3)).is_nan());
    }

    #[test]
    fn a_mesh_of_nothing_is_no_error() {
        let mut bytes = vec![0; cut_discrepancy_need(0, 0)];
        let mesh = FileMesh { positions: &[], triangles: &[] };
        assert_eq!(cut_discrepancy(mesh, &[], &[], Scratch::new(&mut bytes)), Ok(0.0));
        let need = cut_discrepancy_need(3, 1);
        let mut bytes = vec![0; need - 1];
        let mesh = FileMesh { positions: &[DVec3::ZERO; 3], triangles: &[[0, 1, 2]] };
        let result = cut_discrepancy(mesh, &[0], &[0], Scratch::new(&mut bytes));
        assert_eq!(result, Err(ScratchTooSmall { need, given: need - 1 }));
    }
}
