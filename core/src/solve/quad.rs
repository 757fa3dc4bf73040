//! A quad of a piece: two of its triangles that are convex together in space, and the two on the other diagonal.

use super::energy::{MOLLIFY, Rest};
use crate::base::real::sqrt;
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};

/// Sine of the turn from which on a corner of a quad is convex.
const CONVEX: f64 = 0.05;

/// Two triangles of a piece that are a convex quad in space.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Quad {
    /// The triangles.
    pub halves: [u32; 2],
    /// Their four nodes, counter-clockwise; the first and third are the ends of the diagonal.
    pub nodes: [u32; 4],
    /// Rest shapes of the triangles on the other diagonal, as [`across`](Self::across) names them.
    pub rest: [Rest; 2],
}

impl Quad {
    /// The quad with these nodes at `points`; none where a corner is not convex or the quad is far from flat.
    pub fn new(halves: [u32; 2], nodes: [u32; 4], points: [DVec3; 4]) -> Option<Self> {
        let side = |i: usize| points[(i + 1) % 4] - points[i % 4];
        let normal = (points[2] - points[0]).cross(points[3] - points[1]);
        let size = |v: DVec3| sqrt(v.dot(v));
        let is_convex = (0..4).all(|i| {
            let (before, after) = (side(i + 3), side(i));
            before.cross(after).dot(normal) > CONVEX * size(before) * size(after) * size(normal)
        });
        let rest = [[0, 1, 3], [1, 2, 3]].map(|t| Rest::new(t.map(|i: usize| points[i]), MOLLIFY));
        is_convex.then_some(Self { halves, nodes, rest })
    }

    /// Nodes of the triangles on the other diagonal.
    pub fn across(&self) -> [[u32; 3]; 2] {
        let [a, b, c, d] = self.nodes;
        [[a, b, d], [b, c, d]]
    }

    /// Whether it is convex at `x`.
    pub fn is_convex(&self, x: &[DVec2]) -> bool {
        self.failing(x) == [None; 2]
    }

    /// Those of the triangles on the other diagonal that are turned over at `x`, with their areas in space.
    pub fn failing(&self, x: &[DVec2]) -> [Option<([u32; 3], f64)>; 2] {
        let [first, second] = self.across();
        [(first, self.rest[0]), (second, self.rest[1])]
            .map(|(t, r)| (!r.energy(t.map(|i| x[i as usize])).is_finite()).then_some((t, r.area)))
    }
}
