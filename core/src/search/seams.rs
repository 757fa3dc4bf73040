//! Seam optimisation: one budget of distortion, spent where it hides most.
//!
//! A piece is cut on the mesh itself, or, where it has more than [`PROXY_FROM`] faces, by way of a decimated one. Guarantee: no flips;
//! no overlap inside a chart but of one polygon.

use super::budget::{Budget, SeamError};
use super::by_proxy::{cut_by_proxy, proxy_need};
use super::direct::{direct_need, search_from};
use crate::base::scratch::Scratch;
use crate::base::workers::Workers;
use crate::charts::surface::Surface;
use crate::first::disks::cut_to_disks;
use glam::DVec2;

/// Pieces of more faces are cut by way of a decimated mesh. Nefertiti (100k faces): 10k finds shorter seams than the full
/// mesh in a twentieth of the time; 5k to 20k differ by less than two neighbouring seeds of the search.
const PROXY_FROM: usize = 30_000;

/// Scratch bytes that [`make_charts`] asks for.
pub fn make_charts_need(faces: usize, vertices: usize) -> usize {
    let large = faces > PROXY_FROM;
    let direct = direct_need(faces, vertices, !large);
    if large { direct.max(proxy_need(faces, vertices)) } else { direct }
}

/// Cuts and flattens the surface: writes `cut` (one flag a half-edge) and `uv` (one point a corner).
pub fn make_charts(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    mut scratch: Scratch,
    workers: &dyn Workers,
    proceed: &mut dyn FnMut() -> bool,
) -> Result<(), SeamError> {
    let large = surface.mesh.faces.len() > PROXY_FROM;
    // On 100k faces one tight contact holds all nodes back in every step: minutes instead of seconds.
    let budget = Budget { whole: budget.whole && !large, ..budget };
    if !large || !cut_by_proxy(cut, surface, budget, scratch.frame(), workers, proceed)? {
        cut.fill(0);
        let surface = &Surface { stays_whole: budget.whole, ..*surface };
        cut_to_disks(cut, surface, scratch.frame())?;
    }
    search_from(uv, cut, surface, budget, !large, scratch, workers, proceed)
}
