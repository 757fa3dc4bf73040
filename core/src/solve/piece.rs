//! A piece of surface as the solvers see it: triangles over nodes, springs, walls; and when to stop.

use super::energy::Rest;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Pulls two nodes together with energy weight * |x_a - x_b|^2.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Spring {
    /// One end.
    pub a: u32,
    /// The other end.
    pub b: u32,
    /// Stiffness.
    pub weight: f64,
}

/// A piece of surface: nodes `0..free` move, the others are held.
#[derive(Clone, Copy)]
pub struct Piece<'p> {
    /// Nodes of each triangle.
    pub triangles: &'p [[u32; 3]], // (t)
    /// Rest shape of each triangle.
    pub rest: &'p [Rest], // (t)
    /// Nodes that move: 0..free.
    pub free: usize,
    /// A point of each node that is near those of its neighbours: guides the elimination order only.
    pub at: &'p [DVec3], // (n)
    /// Springs.
    pub springs: &'p [Spring],
    /// Border edges that are kept apart, in order round the border.
    pub walls: &'p [[u32; 2]],
}

/// When to stop.
#[derive(Clone, Copy)]
pub struct Stop {
    /// Most Newton steps.
    pub steps: usize,
    /// Stops when a step's predicted decrease is below this share of the piece's area.
    pub tolerance: f64,
}
