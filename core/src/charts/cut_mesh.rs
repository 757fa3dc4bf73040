//! A cut surface as a mesh of its own: nodes are wedges, so that both sides of a cut have nodes of their own.
//!
//! Charts are numbered by their lowest face, nodes and faces chart after chart by their lowest corner: the numbers depend on the
//! faces and their cuts alone.

use super::surface::Surface;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::mesh::view::NONE;

/// Charts as lists of faces and nodes.
#[derive(Clone, Copy)]
pub struct CutMesh<'a> {
    /// Node of each corner of the surface, or `NONE` where its face is left out.
    pub node: &'a [u32], // (3 f)
    /// Faces, chart after chart.
    pub faces: &'a [u32],
    /// First of each chart in `faces`.
    pub face_start: &'a [u32], // (charts + 1)
    /// First node of each chart.
    pub node_start: &'a [u32], // (charts + 1)
    /// A corner of each node.
    pub corner: &'a [u32], // (nodes)
}

/// Scratch bytes that [`CutMesh::new`] keeps or uses.
pub const fn cut_mesh_need(faces: usize) -> usize {
    2 * bytes_for::<u32>(3 * faces) + 5 * bytes_for::<u32>(faces + 1)
}

impl<'a> CutMesh<'a> {
    /// Of the faces that are `wanted`: no other may lie across an edge that is not cut.
    pub fn new(
        surface: &Surface,
        cut: &[u8],
        wanted: impl Fn(usize) -> bool,
        keep: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let all = surface.mesh.faces.len();
        let node = keep.take_filled::<u32>(3 * all, NONE)?;
        let chart = keep.take::<u32>(all)?;
        let queue = keep.take::<u32>(all)?;
        surface.charts(cut, chart, queue);
        let faces = queue; // its order is that of the charts no more
        let mut count = 0;
        for f in (0..all).filter(|f| wanted(*f)) {
            faces[count] = f as u32;
            count += 1;
        }
        // Charts are numbered by their lowest face, so the order of numbers is theirs.
        sort::by_key(&mut faces[..count], |f| (chart[*f as usize], *f));
        let faces = &faces[..count];
        let is_first = |i: usize| i == 0 || chart[faces[i] as usize] != chart[faces[i - 1] as usize];
        let charts = (0..count).filter(|i| is_first(*i)).count();
        let (face_start, node_start) = (keep.take::<u32>(charts + 1)?, keep.take::<u32>(charts + 1)?);
        let corner = keep.take::<u32>(3 * count)?;
        let (mut nodes, mut k) = (0, 0);
        for (i, &f) in faces.iter().enumerate() {
            if is_first(i) {
                (face_start[k], node_start[k]) = (i as u32, nodes);
                k += 1;
            }
            for c in 3 * f..3 * f + 3 {
                if node[c as usize] != NONE {
                    continue;
                }
                corner[nodes as usize] = c;
                for d in surface.wedge(cut, surface.wedge_start(cut, c)) {
                    node[d as usize] = nodes;
                }
                nodes += 1;
            }
        }
        (face_start[charts], node_start[charts]) = (count as u32, nodes);
        Ok(Self { node, faces, face_start, node_start, corner: &corner[..nodes as usize] })
    }

    /// Number of charts.
    pub fn count(&self) -> usize {
        self.face_start.len() - 1
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.corner.len()
    }

    /// Faces of chart `k`.
    pub fn faces_of(&self, k: usize) -> &'a [u32] {
        &self.faces[self.face_start[k] as usize..self.face_start[k + 1] as usize]
    }

    /// Nodes of chart `k`.
    pub fn nodes_of(&self, k: usize) -> core::ops::Range<usize> {
        self.node_start[k] as usize..self.node_start[k + 1] as usize
    }

    /// Nodes of the corners of face `f`.
    pub fn nodes_at(&self, f: u32) -> [u32; 3] {
        [0, 1, 2].map(|i| self.node[3 * f as usize + i])
    }
}
