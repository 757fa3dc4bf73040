//! What a training step looks at: all vertices, or a batch of them with what local losses need beside it.
//!
//! Vertices are drawn without replacement, by a new hash shuffle each time all have been seen (Fisher, Yates; Durstenfeld
//! 1964); faces by hash. For a quarter of the batch the ring neighbours are drawn along, and as many faces with their corners,
//! so a batch of B points has 3 B rows in the cheap networks and B in the dear ones.
//! Ring neighbours are found once: the 5 nearest in space among a vertex's neighbours along edges, ties by index.

use super::losses::{LossGraph, Sizes, lattice_side};
use super::tape::angles::cosines;
use super::tape::distortion::{REST, rest_of};
use super::tape::seam::NEIGHBOURS as SEAM_NEIGHBOURS;
use super::tape::var::NONE;
use crate::base::buckets::{Buckets, buckets_need};
use crate::base::random::hash;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;

/// One in this many points of a batch has a seam score, and as many faces are looked at. 2 costs a third more a step, 8
/// makes the seam loss of 1,000 points jump by its own size.
const LOCAL: usize = 4;
/// Streams of random values.
const SHUFFLE: u64 = 1 << 32;
const FACES: u64 = 2 << 32;

/// The mesh, in the frame of the networks.
#[derive(Clone, Copy)]
pub(super) struct Mesh<'a> {
    pub positions: &'a [f32], // (vertices, 3), in the unit box
    pub normals: &'a [f32],   // (vertices, 3)
    pub exposure: &'a [f32],  // (vertices)
    pub faces: &'a [u32],     // (faces, 3)
    pub ring: &'a [u32],      // (vertices, 5)
}

/// How batches of at most `batch` points (0: all) of a mesh are made up.
pub(super) fn sizes(vertices: usize, faces: usize, batch: usize) -> Sizes {
    if batch == 0 || batch >= vertices {
        return Sizes { points: vertices, further: 0, side: lattice_side(vertices), scored: vertices, faces };
    }
    let local = batch.div_ceil(LOCAL);
    let faces = if faces == 0 { 0 } else { local };
    let further = local * SEAM_NEIGHBOURS + 3 * faces;
    Sizes { points: batch, further, side: lattice_side(batch), scored: local, faces }
}

/// Bytes that [`rings`] takes.
pub(super) const fn rings_need(vertices: usize, faces: usize) -> usize {
    buckets_need(vertices, faces.saturating_mul(3))
}

/// Writes the 5 nearest ring neighbours of each vertex, nearest first, then `NONE`.
pub(super) fn rings(
    out: &mut [u32], // (vertices, 5)
    positions: &[f32],
    faces: &[u32],
    scratch: &mut Scratch,
) -> Result<(), ScratchTooSmall> {
    let vertices = out.len() / SEAM_NEIGHBOURS;
    let mut frame = scratch.frame();
    let corners = Buckets::new(vertices, faces.len(), |corner| Some(faces[corner as usize]), &mut frame)?;
    for (i, out) in out.as_chunks_mut::<SEAM_NEIGHBOURS>().0.iter_mut().enumerate() {
        let mut near = [(f32::INFINITY, NONE); SEAM_NEIGHBOURS];
        for &corner in corners.get(i) {
            let face = corner as usize / 3 * 3;
            for j in (face..face + 3).map(|k| faces[k]).filter(|j| *j as usize != i) {
                let gap = |c: usize| positions[3 * i + c] - positions[3 * j as usize + c];
                let candidate = (gap(0) * gap(0) + gap(1) * gap(1) + gap(2) * gap(2), j);
                let is_before = |a: (f32, u32), b: (f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).is_lt();
                if near.contains(&candidate) || !is_before(candidate, near[SEAM_NEIGHBOURS - 1]) {
                    continue;
                }
                near[SEAM_NEIGHBOURS - 1] = candidate;
                (1..SEAM_NEIGHBOURS).rev().for_each(|k| {
                    if is_before(near[k], near[k - 1]) {
                        near.swap(k, k - 1);
                    }
                });
            }
        }
        out.iter_mut().zip(near).for_each(|(out, (_, j))| *out = j);
    }
    Ok(())
}

/// Draws batches.
pub(super) struct Sampler<'a> {
    order: &'a mut [u32], // (vertices)
    next: usize,
    epoch: u64,
    seed: u64,
}

/// Bytes that [`Sampler::new`] takes.
pub(super) const fn sampler_need(vertices: usize) -> usize {
    bytes_for::<u32>(vertices)
}

impl<'a> Sampler<'a> {
    pub fn new(vertices: usize, seed: u64, scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        let order = scratch.take_unset::<u32>(vertices)?;
        order.iter_mut().enumerate().for_each(|(i, o)| *o = i as u32);
        Ok(Self { order, next: usize::MAX, epoch: 0, seed })
    }

    /// Fills the inputs and tables of `graph` for `step`. With all vertices in the batch that is done at step 0 alone.
    pub fn fill(&mut self, graph: &LossGraph, mesh: &Mesh, step: usize, values: &mut [f32], indices: &mut [u32]) {
        let sizes = graph.sizes;
        if sizes.points == self.order.len() {
            if step == 0 {
                graph.positions.of_mut(values).copy_from(mesh.positions);
                graph.normals.of_mut(values).copy_from(mesh.normals);
                graph.exposure.of_mut(values).copy_from(mesh.exposure);
                graph.ring.of_mut(indices).copy_from(mesh.ring);
                graph.faces.of_mut(indices).copy_from(mesh.faces);
                fill_faces(graph, values, indices);
            }
            return;
        }
        if self.next.saturating_add(sizes.points) > self.order.len() {
            self.shuffle();
        }
        let drawn = &self.order[self.next..self.next + sizes.points];
        self.next += sizes.points;
        copy_rows(graph.positions.of_mut(values), mesh.positions, drawn);
        copy_rows(graph.normals.of_mut(values), mesh.normals, drawn);
        let exposed = graph.exposure.of_mut(values).iter_mut().zip(drawn);
        exposed.for_each(|(to, &i)| *to = mesh.exposure[i as usize]);
        // Behind the points: the neighbours of the scored ones, then the corners of the faces.
        let mut row = sizes.points;
        let ring = graph.ring.of_mut(indices);
        for (k, &i) in drawn[..sizes.scored].iter().enumerate() {
            for (slot, &j) in mesh.ring[i as usize * SEAM_NEIGHBOURS..][..SEAM_NEIGHBOURS].iter().enumerate() {
                let place = &mut ring[k * SEAM_NEIGHBOURS + slot];
                *place = if j == NONE { NONE } else { row as u32 };
                let from = if j == NONE { i } else { j };
                copy_rows(&mut graph.positions.of_mut(values)[3 * row..], mesh.positions, &[from]);
                row += 1;
            }
        }
        let face_count = (mesh.faces.len() / 3).max(1) as u64;
        for (k, corners) in graph.faces.of_mut(indices).as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let face = (hash(self.seed, FACES + step as u64, k as u64) % face_count) as usize;
            copy_rows(&mut graph.positions.of_mut(values)[3 * row..], mesh.positions, &mesh.faces[3 * face..][..3]);
            corners.iter_mut().enumerate().for_each(|(c, corner)| *corner = (row + c) as u32);
            row += 3;
        }
        fill_faces(graph, values, indices);
    }

    fn shuffle(&mut self) {
        for i in (1..self.order.len()).rev() {
            let j = hash(self.seed, SHUFFLE + self.epoch, i as u64) % (i as u64 + 1);
            self.order.swap(i, j as usize);
        }
        self.epoch += 1;
        self.next = 0;
    }
}

fn copy_rows(to: &mut [f32], from: &[f32], rows: &[u32]) {
    to.as_chunks_mut::<3>().0.iter_mut().zip(rows).for_each(|(to, &i)| to.copy_from(&from[3 * i as usize..][..3]));
}

/// Cosines and rest shapes of the batch's faces, areas as shares of their sum.
fn fill_faces(graph: &LossGraph, values: &mut [f32], indices: &[u32]) {
    let faces = graph.faces.of(indices);
    let count = faces.len() / 3;
    let mut area = 0.0;
    for k in 0..count {
        let face = [faces[3 * k], faces[3 * k + 1], faces[3 * k + 2]];
        let positions = graph.positions.of(values);
        let corner = |i: u32| core::array::from_fn(|c| positions[3 * i as usize + c] as f64);
        let rest = rest_of(face.map(corner));
        let angles = cosines(positions, face);
        area += rest[4];
        graph.rest.of_mut(values)[REST * k..][..REST].iter_mut().zip(rest).for_each(|(to, x)| *to = x as f32);
        graph.cosines.of_mut(values)[3 * k..][..3].copy_from(&angles);
    }
    let share = if area > 0.0 { (1.0 / area) as f32 } else { 0.0 };
    graph.rest.of_mut(values).as_chunks_mut::<REST>().0.iter_mut().for_each(|rest| rest[4] *= share);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{vec, vec::Vec};

    #[test]
    fn ring_neighbours_are_the_nearest_along_edges_with_ties_by_index() {
        // A fan about vertex 0 whose spokes have the lengths 6, 1, 2, 2, 3, 4, 5: the five shortest stay.
        let lengths = [6.0f32, 1.0, 2.0, 2.0, 3.0, 4.0, 5.0];
        let mut positions = vec![0.0; 3];
        lengths.iter().enumerate().for_each(|(k, l)| positions.extend([[*l, 0.0, 0.0], [0.0, *l, 0.0]][k % 2]));
        let faces: Vec<u32> = (1..7).flat_map(|k| [0, k, k + 1]).collect();
        let mut bytes = vec![0; rings_need(9, faces.len() / 3)];
        let mut ring = vec![0; 9 * SEAM_NEIGHBOURS];
        positions.extend([9.0; 3]); // a vertex without faces
        rings(&mut ring, &positions, &faces, &mut Scratch::new(&mut bytes)).unwrap();
        assert_eq!(ring[..5], [2, 3, 4, 5, 6]);
        assert_eq!(ring[8 * 5..], [NONE; 5]);
        assert_eq!(ring[5 + 2..10], [NONE; 3], "the first rim vertex has two neighbours");
    }

    #[test]
    fn an_epoch_sees_every_vertex_once_and_the_next_in_another_order() {
        let mut bytes = vec![0; sampler_need(50)];
        let mut sampler = Sampler::new(50, 4, &mut Scratch::new(&mut bytes)).unwrap();
        sampler.shuffle();
        let first = sampler.order.to_vec();
        sampler.shuffle();
        assert_ne!(first, sampler.order);
        let mut seen = sampler.order.to_vec();
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..50));
    }
}
