//! The connected pieces of a mesh, laid out one after the other.
//!
//! Forced cuts are borders here: a piece is what hangs together without crossing one, and its vertices are the wedges
//! that they leave. Pieces share nothing.

use super::surface::Surface;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::mesh::view::{MeshView, NONE, next};
use crate::solve::energy::{MOLLIFY, Rest, even_out};
use glam::DVec3;

/// All pieces; indices are local to a piece.
#[derive(Clone, Copy)]
pub struct Pieces<'a> {
    face_start: &'a [u32],   // (pieces + 1)
    vertex_start: &'a [u32], // (pieces + 1)
    faces: &'a [[u32; 3]],   // (f)
    positions: &'a [DVec3],  // (n)
    twin: &'a [u32],         // (3 f)
    rest: &'a [Rest],        // (f)
    cost: &'a [f64],         // (3 f)
    /// Corner of the given mesh that each corner here stands for.
    pub source: &'a [u32], // (3 f)
}

/// Scratch bytes that [`Pieces::new`] keeps or uses.
pub const fn pieces_need(faces: usize) -> usize {
    let corners = 3 * faces;
    // Kept: faces, twin, source, cost, rest, positions, two starts; used: wedge of each corner, chart, queue, two maps.
    bytes_for::<[u32; 3]>(faces)
        + 2 * bytes_for::<u32>(corners)
        + bytes_for::<f64>(corners)
        + bytes_for::<Rest>(faces)
        + bytes_for::<DVec3>(corners)
        + 2 * bytes_for::<u32>(faces + 2)
        + 4 * bytes_for::<u32>(corners)
        + 4 * bytes_for::<u32>(faces + 2)
}

impl<'a> Pieces<'a> {
    /// Lays out the pieces of an oriented manifold. `forced` flags half-edges (both twins) that are cuts from the start;
    /// `cost` is what cutting a half-edge costs.
    pub fn new(
        mesh: MeshView,
        twin: &[u32],
        forced: &[u8],
        cost: &[f64],
        keep: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let (count, corners) = (mesh.faces.len(), mesh.corner_count());
        let faces = keep.take::<[u32; 3]>(count)?;
        let local_twin = keep.take_filled::<u32>(corners, NONE)?;
        let source = keep.take::<u32>(corners)?;
        let local_cost = keep.take::<f64>(corners)?;
        let rest = keep.take::<Rest>(count)?;
        let bare = Surface { mesh, twin, rest: &[], cost, start: &[], corners: &[], stays_whole: false };
        // Starts are as long as there are pieces: find those first, in a frame.
        let pieces = {
            let mut frame = keep.frame();
            let (piece, queue) = (frame.take::<u32>(count)?, frame.take::<u32>(count)?);
            bare.charts(forced, piece, queue)
        };
        let face_start = keep.take::<u32>(pieces + 1)?;
        let vertex_start = keep.take::<u32>(pieces + 1)?;
        let nodes = {
            let mut frame = keep.frame();
            bare.wedges(forced, frame.take::<u32>(corners)?)
        };
        let positions = keep.take::<DVec3>(nodes)?;
        let mut frame = keep.frame();
        let piece = frame.take::<u32>(count)?;
        let place = frame.take::<u32>(count)?; // of each face in its new order; a queue before that
        bare.charts(forced, piece, place);
        let node = frame.take::<u32>(corners)?;
        bare.wedges(forced, node);
        for p in piece.iter() {
            face_start[*p as usize + 1] += 1;
        }
        for p in 0..pieces {
            face_start[p + 1] += face_start[p];
        }
        let next_face = frame.take::<u32>(pieces)?;
        next_face.copy_from(&face_start[..pieces]);
        for (f, p) in piece.iter().enumerate() {
            let at = &mut next_face[*p as usize];
            place[f] = *at;
            for i in 0..3 {
                source[3 * *at as usize + i] = (3 * f + i) as u32;
            }
            *at += 1;
        }
        let local = frame.take_filled::<u32>(nodes, NONE)?;
        let mut total = 0;
        for p in 0..pieces {
            vertex_start[p] = total;
            for slot in 3 * face_start[p] as usize..3 * face_start[p + 1] as usize {
                let c = source[slot];
                let id = &mut local[node[c as usize] as usize];
                if *id == NONE {
                    *id = total - vertex_start[p];
                    positions[total as usize] = mesh.position(c);
                    total += 1;
                }
                faces[slot / 3][slot % 3] = *id;
                local_cost[slot] = cost[c as usize];
                if let Some(t) = bare.across(forced, c) {
                    local_twin[slot] = 3 * (place[(t / 3) as usize] - face_start[p]) + t % 3;
                }
            }
        }
        vertex_start[pieces] = total;
        for (r, corner) in rest.iter_mut().zip(source.as_chunks::<3>().0.iter()) {
            *r = Rest::new([0, 1, 2].map(|i| mesh.position(corner[i])), MOLLIFY);
        }
        for p in 0..pieces {
            even_out(&mut rest[face_start[p] as usize..face_start[p + 1] as usize]);
        }
        Ok(Self { face_start, vertex_start, faces, positions, twin: local_twin, rest, cost: local_cost, source })
    }

    /// Number of pieces.
    pub fn count(&self) -> usize {
        self.face_start.len() - 1
    }

    /// Number of vertices of piece `p`.
    pub fn vertex_count(&self, p: usize) -> usize {
        (self.vertex_start[p + 1] - self.vertex_start[p]) as usize
    }

    /// Places of the corners of piece `p` in arrays over all corners.
    pub fn corners(&self, p: usize) -> core::ops::Range<usize> {
        3 * self.face_start[p] as usize..3 * self.face_start[p + 1] as usize
    }

    /// Rest shapes of all faces.
    pub fn rest(&self) -> &'a [Rest] {
        self.rest
    }

    /// What cutting each half-edge costs.
    pub fn cost(&self) -> &'a [f64] {
        self.cost
    }

    /// The same pieces, where cutting a half-edge costs `cost`.
    pub fn priced<'c>(&self, cost: &'c [f64]) -> Pieces<'c>
    where
        'a: 'c,
    {
        Pieces { cost, ..*self }
    }

    /// Those of the pieces that are `wanted`, in their order.
    pub fn only<'k>(
        &self,
        wanted: impl Fn(usize) -> bool,
        keep: &mut Scratch<'k>,
    ) -> Result<Pieces<'k>, ScratchTooSmall> {
        let chosen = || (0..self.count()).filter(|p| wanted(*p));
        let count: usize = chosen().map(|p| self.corners(p).len() / 3).sum();
        let (starts, vertices) = (chosen().count() + 1, chosen().map(|p| self.vertex_count(p)).sum());
        let (face_start, vertex_start) = (keep.take::<u32>(starts)?, keep.take::<u32>(starts)?);
        let (faces, positions) = (keep.take::<[u32; 3]>(count)?, keep.take::<DVec3>(vertices)?);
        let (twin, source) = (keep.take::<u32>(3 * count)?, keep.take::<u32>(3 * count)?);
        let (rest, cost) = (keep.take::<Rest>(count)?, keep.take::<f64>(3 * count)?);
        let (mut face, mut vertex) = (0, 0);
        for (i, p) in chosen().enumerate() {
            let corners = self.corners(p);
            let (f, n) = (corners.len() / 3, self.vertex_count(p));
            let surface = self.bare_surface(p);
            faces[face..face + f].copy_from(surface.mesh.faces);
            rest[face..face + f].copy_from(surface.rest);
            positions[vertex..vertex + n].copy_from(surface.mesh.positions);
            twin[3 * face..3 * (face + f)].copy_from(surface.twin);
            cost[3 * face..3 * (face + f)].copy_from(surface.cost);
            source[3 * face..3 * (face + f)].copy_from(&self.source[corners]);
            (face, vertex) = (face + f, vertex + n);
            (face_start[i + 1], vertex_start[i + 1]) = (face as u32, vertex as u32);
        }
        Ok(Pieces { face_start, vertex_start, faces, positions, twin, rest, cost, source })
    }

    /// Piece `p` as a surface without the list of its vertices' corners: enough for wedges and charts.
    pub fn bare_surface(&self, p: usize) -> Surface<'_> {
        let corners = self.corners(p);
        let faces = corners.start / 3..corners.end / 3;
        let vertices = self.vertex_start[p] as usize..self.vertex_start[p + 1] as usize;
        let mesh = MeshView { positions: &self.positions[vertices], faces: &self.faces[faces.clone()] };
        let (twin, rest, cost) = (&self.twin[corners.clone()], &self.rest[faces], &self.cost[corners]);
        Surface { mesh, twin, rest, cost, start: &[], corners: &[], stays_whole: false }
    }

    /// Edges with two faces in a piece that are cut and whose cost is `wanted`.
    pub fn cut_count(&self, cut: &[u8], wanted: impl Fn(f64) -> bool) -> usize {
        let edges = (0..cut.len()).filter(|c| self.twin[*c] != NONE && cut[*c] != 0 && wanted(self.cost[*c]));
        edges.count() / 2
    }

    /// The two pairs of nodes that stand across from each other at each edge that is cut in piece `p`; `cut` and `node` have
    /// one entry a corner of all pieces.
    pub fn slits<'s>(&'s self, p: usize, cut: &'s [u8], node: &'s [u32]) -> impl Iterator<Item = [(u32, u32); 2]> + 's {
        let first = self.corners(p).start as u32;
        let is_slit = move |slot: &usize| {
            cut[*slot] != 0 && self.twin[*slot] != NONE && (*slot as u32) < self.twin[*slot] + first
        };
        self.corners(p).filter(is_slit).map(move |slot| {
            let (c, t) = (slot as u32, self.twin[slot] + first);
            [(node[c as usize], node[next(t) as usize]), (node[next(c) as usize], node[t as usize])]
        })
    }

    /// Whether the edge of a corner of all pieces is a cut or a border.
    pub fn is_open(&self, cut: &[u8], slot: usize) -> bool {
        self.twin[slot] == NONE || cut[slot] != 0
    }

    /// Piece `p` as a surface; lists its vertices' corners in `keep`.
    pub fn surface<'s>(&'s self, p: usize, keep: &mut Scratch<'s>) -> Result<Surface<'s>, ScratchTooSmall> {
        let Surface { mesh, twin, rest, cost, .. } = self.bare_surface(p);
        Surface::new(mesh, twin, rest, cost, keep)
    }
}
