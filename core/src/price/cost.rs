//! The cost of a cut along each edge: its length, times what is seen of it.
//!
//! cost = length (OPEN + exposure^SHARPNESS), so that an occluded crease costs next to nothing.

use crate::base::real;
use crate::mesh::repair::DIAGONAL;
use crate::mesh::view::{MeshView, next};

/// Weight of places that nobody sees: cost = length (OPEN + exposure^SHARPNESS).
const OPEN: f64 = 0.05;
/// See [`OPEN`].
const SHARPNESS: f64 = 4.0;

/// Fills `cost` (one entry a half-edge, equal for twins). `fixed` holds marks as in `mesh::repair`: diagonals of polygons
/// cost infinity, they are never cut. Without `exposure` (one value a vertex) a cut costs as if all were open. O(f).
pub fn prices(cost: &mut [f64], mesh: MeshView, fixed: &[u8], exposure: Option<&[f32]>) {
    for c in 0..mesh.corner_count() as u32 {
        let (a, b) = (mesh.vertex(c), mesh.vertex(next(c)));
        let d = mesh.positions[b as usize] - mesh.positions[a as usize];
        let e = exposure.map_or(1.0, |open| 0.5 * (f64::from(open[a as usize]) + f64::from(open[b as usize])));
        let seen = real::sqrt(d.dot(d)) * (OPEN + real::pow(e, SHARPNESS));
        cost[c as usize] = if fixed[c as usize] == DIAGONAL { f64::INFINITY } else { real::for_cost(seen) };
    }
}
