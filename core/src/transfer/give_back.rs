//! What gave way without need goes back to where it fits best.
//!
//! Nodes go all the way first, then by ever smaller shares of it: those of faces that would be turned over, overlap or leave the square stay, until
//! no face would that does not already. On a coarse mesh a step of [`super::clear`] is many texels, of which most can be taken back.
//! Cost: a few searches for overlaps a share, until no node is left that may move.

use super::carried_map::{CarriedMap, Faults};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::mesh::view::NONE;
use crate::plane::grid::{GRID_BITS, GridPoint, GridTriangle};
use crate::plane::overlap::overlaps_need;
use glam::DVec2;

/// Shares of the way: 1, 1/2, and so on.
const SHARES: usize = 6;
/// Rounds of each.
const ROUNDS: usize = 24;

/// Bytes that [`give_back`] takes.
pub const fn give_back_need(nodes: usize, faces: usize) -> usize {
    bytes_for::<GridPoint>(nodes)
        .saturating_add(bytes_for::<f64>(nodes))
        .saturating_add(bytes_for::<u8>(nodes))
        .saturating_add(bytes_for::<u8>(faces))
        .saturating_add(bytes_for::<u32>(faces))
        .saturating_add(bytes_for::<GridTriangle>(faces))
        .saturating_add(overlaps_need(faces))
}

/// Moves `grid` towards `fitted`; returns what is wrong with it in the end. Guaranteed: no face has a fault afterwards that it had not before.
pub fn give_back(
    grid: &mut [GridPoint],
    fitted: &[DVec2],
    atlas: &CarriedMap,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<Faults, ScratchTooSmall> {
    let (nodes, faces) = (grid.len(), atlas.shapes.node.len());
    let before = scratch.take::<GridPoint>(nodes)?;
    before.copy_from(grid);
    let done = scratch.take::<f64>(nodes)?; // share of the way
    let stays = scratch.take::<u8>(nodes)?;
    let partner = scratch.take::<u32>(faces)?;
    let triangles = scratch.take::<GridTriangle>(faces)?;
    // A bit for each fault of a face.
    let faults = |f: usize, grid: &[GridPoint], partner: &[u32], triangles: &[GridTriangle]| {
        let is_outside = triangles[f].iter().any(|p| atlas.is_outside(*p));
        u8::from(atlas.is_turned(f, grid)) | u8::from(partner[f] != NONE) << 1 | u8::from(is_outside) << 2
    };
    let known = scratch.take::<u8>(faces)?; // faults before
    let of_before = atlas.look(triangles, partner, grid, scratch.frame(), workers)?;
    known.iter_mut().enumerate().for_each(|(f, known)| *known = faults(f, grid, partner, triangles));
    let goal = |n: usize| GridPoint::snap(fitted[n], GRID_BITS);
    for k in 0..SHARES {
        let step = 1.0 / f64::from(1u32 << k);
        for (n, stays) in stays.iter_mut().enumerate() {
            *stays = u8::from(done[n] + step > 1.0 || before[n] == goal(n));
        }
        for _ in 0..ROUNDS {
            if !stays.contains(&0) {
                break;
            }
            for (n, g) in grid.iter_mut().enumerate().filter(|(n, _)| before[*n] != goal(*n)) {
                let share = done[n] + if stays[n] == 0 { step } else { 0.0 };
                *g = part_way(before[n], fitted[n], share);
            }
            atlas.look(triangles, partner, grid, scratch.frame(), workers)?;
            let mut is_free = true;
            for f in (0..faces).filter(|f| faults(*f, grid, partner, triangles) & !known[*f] != 0) {
                is_free = false;
                let other = atlas.shapes.node.get(partner[f] as usize).into_iter().flatten();
                atlas.shapes.node[f].iter().chain(other).for_each(|n| stays[*n as usize] = 1);
            }
            if is_free {
                done.iter_mut().zip(stays.iter()).filter(|(_, stays)| **stays == 0).for_each(|(d, _)| *d += step);
                break;
            }
        }
    }
    grid.iter_mut().enumerate().for_each(|(n, g)| *g = part_way(before[n], fitted[n], done[n]));
    if *grid == *before { Ok(of_before) } else { atlas.look(triangles, partner, grid, scratch, workers) }
}

/// A share of the way between two places.
fn part_way(from: GridPoint, to: DVec2, share: f64) -> GridPoint {
    if share == 0.0 { from } else { GridPoint::snap(from.uv(GRID_BITS).lerp(to, share), GRID_BITS) }
}
