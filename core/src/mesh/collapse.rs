//! Half-edge collapse on a corner table, and its exact inverse.
//!
//! A collapse moves one vertex onto a neighbour: the one or two faces at their edge die, the other faces of the removed
//! vertex are renamed. Dead faces keep their vertices and twins untouched, so one number a collapse is enough to undo it;
//! collapses have to be undone in the opposite order.
//! Guarantee: `undo` restores faces and twins bit for bit. Limit: the caller sees to the link condition, and no vertex is
//! the tip of two fans. Cost: the valence of the removed vertex.

use super::view::{NONE, next, prev};
use bytemuck::{Pod, Zeroable};

/// The corner of the collapsed edge's half-edge, times two, plus one where the removed vertex is its far end.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Collapse(u32);

/// One of the faces that a collapse removes, by its corners and (as ever) the edges that begin there.
#[derive(Clone, Copy)]
pub struct Side {
    /// Corner at the removed vertex.
    pub removed: u32,
    /// Corner at the kept vertex.
    pub kept: u32,
    /// Edge between the removed vertex and the third one.
    pub removed_edge: u32,
    /// Edge between the kept vertex and the third one.
    pub kept_edge: u32,
    /// Corner at the third vertex.
    pub apex: u32,
}

impl Collapse {
    /// Removes the vertex at the start of the half-edge of `corner`, or, with `far`, the one at its end.
    pub fn new(corner: u32, far: bool) -> Self {
        Self(2 * corner + u32::from(far))
    }

    /// The corner of the collapsed edge.
    pub fn edge(self) -> u32 {
        self.0 / 2
    }

    /// The face that always dies.
    pub fn side(self) -> Side {
        let e = self.edge();
        let (n, p) = (next(e), prev(e));
        if self.0.is_multiple_of(2) {
            Side { removed: e, kept: n, removed_edge: p, kept_edge: n, apex: p }
        } else {
            Side { removed: n, kept: e, removed_edge: n, kept_edge: p, apex: p }
        }
    }

    /// The faces that die: two, or one where the edge is on the border.
    pub fn sides(self, twin: &[u32]) -> impl DoubleEndedIterator<Item = Side> + Clone + use<> {
        let t = twin[self.edge() as usize];
        let far = self.0.is_multiple_of(2);
        [Some(self.side()), (t != NONE).then(|| Self::new(t, far).side())].into_iter().flatten()
    }
}

/// Faces and twins that collapses change.
pub struct CornerTable<'a> {
    /// Vertices of each face.
    pub faces: &'a mut [[u32; 3]], // (f)
    /// Twin of each half-edge.
    pub twin: &'a mut [u32], // (3 f)
}

impl CornerTable<'_> {
    /// Vertex at corner `c`.
    #[inline]
    pub fn vertex(&self, c: u32) -> u32 {
        self.faces[(c / 3) as usize][(c % 3) as usize]
    }

    /// Removed and kept vertex of a collapse.
    pub fn ends(&self, collapse: Collapse) -> [u32; 2] {
        let side = collapse.side();
        [self.vertex(side.removed), self.vertex(side.kept)]
    }

    /// Collapses.
    pub fn apply(&mut self, collapse: Collapse) {
        let [_, kept] = self.ends(collapse);
        self.rename(collapse, kept);
        for side in collapse.sides(self.twin) {
            let (a, b) = (self.twin[side.kept_edge as usize], self.twin[side.removed_edge as usize]);
            for (from, to) in [(a, b), (b, a)] {
                if from != NONE {
                    self.twin[from as usize] = to;
                }
            }
        }
    }

    /// Takes the latest collapse back.
    pub fn undo(&mut self, collapse: Collapse) {
        for side in collapse.sides(self.twin).rev() {
            for edge in [side.kept_edge, side.removed_edge] {
                let t = self.twin[edge as usize];
                if t != NONE {
                    self.twin[t as usize] = edge;
                }
            }
        }
        let [removed, _] = self.ends(collapse);
        self.rename(collapse, removed);
    }

    /// Gives the fan of the removed vertex the name `to`, but for the faces that die.
    fn rename(&mut self, collapse: Collapse, to: u32) {
        let dies = |f: u32| collapse.sides(self.twin).any(|side| side.apex / 3 == f);
        for c in fan(self.twin, collapse.side().removed) {
            if !dies(c / 3) {
                self.faces[(c / 3) as usize][(c % 3) as usize] = to;
            }
        }
    }
}

/// The corners around the vertex of corner `start`: counter-clockwise from it, then, on the border, clockwise.
pub fn fan(twin: &[u32], start: u32) -> impl Iterator<Item = u32> + '_ {
    let (mut at, mut clockwise) = (start, false);
    core::iter::from_fn(move || {
        if at == NONE {
            return None;
        }
        let c = at;
        if !clockwise {
            at = twin[prev(c) as usize];
            if at == start {
                at = NONE;
                return Some(c);
            }
            clockwise = at == NONE;
            if clockwise {
                at = step_clockwise(twin, start);
            }
        } else {
            at = step_clockwise(twin, c);
        }
        Some(c)
    })
}

fn step_clockwise(twin: &[u32], c: u32) -> u32 {
    let t = twin[c as usize];
    if t == NONE { NONE } else { next(t) }
}

#[cfg(test)]
mod tests {
    use super::super::topology::{twins, twins_need};
    use super::super::view::MeshView;
    use super::*;
    use crate::base::scratch::Scratch;
    use glam::DVec3;
    use std::{vec, vec::Vec};

    /// A 3 x 3 grid of vertices, two faces a cell.
    fn grid() -> (Vec<[u32; 3]>, Vec<u32>) {
        let mut faces = vec![];
        for a in [0, 1, 3, 4] {
            faces.push([a, a + 1, a + 4]);
            faces.push([a, a + 4, a + 3]);
        }
        let mesh = MeshView { positions: &[DVec3::ZERO; 9], faces: &faces };
        let mut twin = vec![0; 3 * faces.len()];
        let mut bytes = vec![0; twins_need(faces.len())];
        assert_eq!(twins(&mut twin, mesh, Scratch::new(&mut bytes)), Ok(0));
        (faces, twin)
    }

    #[test]
    fn undoing_collapses_restores_every_face_and_twin() {
        let (mut faces, mut twin) = grid();
        let (faces0, twin0) = grid();
        let mut table = CornerTable { faces: &mut faces, twin: &mut twin };
        // The middle onto a border vertex, then a border vertex along the border.
        let middle = (0..24).find(|c| table.vertex(*c) == 4).unwrap();
        table.apply(Collapse::new(middle, false));
        assert!((0..24).filter(|c| table.vertex(*c) == 4).count() == 2);
        let border = (0..24).find(|c| twin0[*c as usize] == NONE && table.vertex(*c) == 1).unwrap();
        table.apply(Collapse::new(border, true));
        table.undo(Collapse::new(border, true));
        table.undo(Collapse::new(middle, false));
        assert!(faces == faces0 && twin == twin0);
    }

    #[test]
    fn a_fan_has_every_corner_of_its_vertex_once() {
        let (faces, twin) = grid();
        for start in 0..24u32 {
            let v = faces[(start / 3) as usize][(start % 3) as usize];
            let mut found: Vec<u32> = fan(&twin, start).collect();
            found.sort_unstable();
            let wanted: Vec<u32> = (0..24).filter(|c: &u32| faces[(c / 3) as usize][(c % 3) as usize] == v).collect();
            assert_eq!(found, wanted);
        }
    }
}
