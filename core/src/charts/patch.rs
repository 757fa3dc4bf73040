//! Relaxing the surroundings of some faces, as far as a number of faces reaches, with everything beyond them held.
//!
//! A few bad faces of a large chart are mended by a few thousand nodes around them; a Newton step of the whole chart would
//! cost a hundred times as much. Where a chart is no larger than the patch, all of it moves.
//! Guarantee: no face flips. Cost: a pass over the corners, and the relaxation of the patch.

use super::quads::{diagonal, quads_of};
use super::surface::Surface;
use crate::base::listing::list_once;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::base::workers::Workers;
use crate::mesh::view::NONE;
use crate::solve::energy::Rest;
use crate::solve::piece::{Piece, Stop};
use crate::solve::quad::Quad;
use crate::solve::quads::{quads_need, relax_quads};
use crate::solve::relax::relax_need;
use glam::{DVec2, DVec3};

/// Faces of a patch at the most: some 100 rings around one face.
const FACES: usize = 20_000;
/// Faces that a patch may be grown from.
pub const SEEDS: usize = FACES / 4;

/// Scratch bytes for [`relax_patch`].
pub fn patch_need(faces: usize) -> usize {
    // The faces of the last ring have their quads' other halves with them.
    let patch = faces.min(2 * FACES + 4);
    // In one chart a patch has about half as many nodes as faces; of slivers it has up to three times as many.
    let own = bytes_for::<[u32; 3]>(patch) + bytes_for::<Rest>(patch) + 2 * bytes_for::<DVec2>(3 * patch);
    let quads = bytes_for::<Quad>(patch / 2) + quads_need(patch);
    bytes_for::<u32>(faces) + bytes_for::<u32>(3 * faces) + own + quads + relax_need(patch + 2, 2 * patch, 0)
}

/// Relaxes the faces around those marked in `seeds` ([`SEEDS`] at the most); marks all faces of the patch.
pub fn relax_patch(
    uv: &mut [DVec2],
    cut: &[u8],
    seeds: &mut [u8], // (f)
    surface: &Surface,
    stop: Stop,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let faces = grow(cut, seeds, surface, &mut scratch)?;
    let local = scratch.take_filled::<u32>(3 * seeds.len(), NONE)?; // node of a wedge, at its first corner
    let triangles = scratch.take::<[u32; 3]>(faces.len())?;
    let mut count = 0;
    let mut free = 0;
    for held in [false, true] {
        for c in faces.iter().flat_map(|f| 3 * f..3 * f + 3) {
            let start = surface.wedge_start(cut, c);
            let is_held = || surface.wedge(cut, start).any(|d| seeds[(d / 3) as usize] == 0);
            if local[start as usize] == NONE && (held || !is_held()) {
                local[start as usize] = count;
                count += 1;
            }
        }
        if !held {
            free = count as usize;
        }
    }
    let x = scratch.take::<DVec2>(count as usize)?;
    let rest = scratch.take::<Rest>(faces.len())?;
    for ((t, r), f) in triangles.iter_mut().zip(rest.iter_mut()).zip(faces) {
        *r = surface.rest[*f as usize];
        *t = [0, 1, 2].map(|i| local[surface.wedge_start(cut, 3 * f + i) as usize]);
        (0..3).for_each(|i| x[t[i] as usize] = uv[3 * *f as usize + i]);
    }
    let at: &[DVec3] = &[];
    let quads = quads_of(faces, triangles, surface, cut, &mut scratch)?;
    relax_quads(x, &Piece { triangles, rest, free, at, springs: &[], walls: &[] }, quads, stop, scratch, workers)?;
    for (t, f) in triangles.iter().zip(faces) {
        (0..3).for_each(|i| uv[3 * *f as usize + i] = x[t[i] as usize]);
    }
    Ok(())
}

/// Adds rings of faces to the marked ones until there are [`FACES`], and the other halves of quads; lists them in order.
fn grow<'a>(
    cut: &[u8],
    seeds: &mut [u8],
    surface: &Surface,
    keep: &mut Scratch<'a>,
) -> Result<&'a [u32], ScratchTooSmall> {
    let queue = keep.take::<u32>(seeds.len())?;
    let mut tail = 0;
    for f in (0..seeds.len()).filter(|f| seeds[*f] != 0) {
        queue[tail] = f as u32;
        tail += 1;
    }
    let mut head = 0;
    while head < tail && tail < FACES {
        let f = queue[head];
        head += 1;
        for t in (3 * f..3 * f + 3).filter_map(|c| surface.across(cut, c)) {
            tail += list_once(t / 3, seeds, queue, tail);
        }
    }
    // Quads as a whole.
    let grown = tail;
    for k in 0..grown {
        if let Some(t) = diagonal(queue[k], surface).and_then(|c| surface.across(cut, c)) {
            tail += list_once(t / 3, seeds, queue, tail);
        }
    }
    let faces = &mut queue[..tail];
    sort::ascending(faces);
    Ok(faces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::workers::Serial;
    use crate::mesh::topology::twins;
    use crate::mesh::view::MeshView;
    use std::vec;
    use std::vec::Vec;

    const STOP: Stop = Stop { steps: 20, tolerance: 1e-12 };

    /// Squares of two triangles in `rows` of `columns`, flat, with the inner node in the middle pulled aside. Returns its
    /// distance from where it belongs after relaxing around the faces from `seed` on, and how many faces have moved.
    fn relaxed(columns: u32, rows: u32, seed: usize, bytes: &mut [u8]) -> Result<(f64, usize), ScratchTooSmall> {
        let n = columns + 1;
        let positions: Vec<DVec3> =
            (0..n * (rows + 1)).map(|v| DVec3::new(f64::from(v % n), f64::from(v / n), 0.0)).collect();
        let cells = (0..columns * rows).map(|i| i / columns * n + i % columns);
        let faces: Vec<[u32; 3]> = cells.flat_map(|v| [[v, v + 1, v + n + 1], [v, v + n + 1, v + n]]).collect();
        let mesh = MeshView { positions: &positions, faces: &faces };
        let mut memory = vec![0u8; 1 << 24];
        let mut keep = Scratch::new(&mut memory);
        let mut twin = vec![NONE; 3 * faces.len()];
        twins(&mut twin, mesh, keep.frame()).unwrap();
        let rest: Vec<Rest> = faces.iter().map(|f| Rest::new(f.map(|v| positions[v as usize]), 0.0)).collect();
        let cost = vec![1.0; 3 * faces.len()];
        let surface = Surface::new(mesh, &twin, &rest, &cost, &mut keep).unwrap();
        let moved = rows / 2 * n + columns / 2;
        let aside = |v: u32| if v == moved { DVec2::new(0.3, 0.2) } else { DVec2::ZERO };
        let mut uv: Vec<DVec2> =
            (0..3 * faces.len() as u32).map(|c| mesh.position(c).truncate() + aside(mesh.vertex(c))).collect();
        let before = uv.clone();
        let mut seeds = vec![0; faces.len()];
        seeds[seed] = 1;
        let cut = vec![0; 3 * faces.len()];
        relax_patch(&mut uv, &cut, &mut seeds, &surface, STOP, Scratch::new(bytes), &Serial)?;
        let at = mesh.faces.as_flattened().iter().position(|v| *v == moved).unwrap();
        let gap = uv[at] - positions[moved as usize].truncate();
        let moved = (0..faces.len()).filter(|f| uv[3 * f..3 * f + 3] != before[3 * f..3 * f + 3]).count();
        Ok((gap.length(), moved))
    }

    #[test]
    fn what_is_near_comes_to_rest_and_what_is_far_stays() {
        // 80,000 faces, more than a patch has.
        let mut bytes = vec![0; patch_need(80_000)];
        let (gap, moved) = relaxed(200, 200, 2 * (100 * 200 + 100), &mut bytes).unwrap();
        assert!(gap < 1e-5 && moved > 100 && moved <= FACES, "{gap} {moved}");
        let (gap, moved) = relaxed(200, 200, 0, &mut bytes).unwrap();
        assert!(gap > 0.36, "the corner's patch does not reach the middle: {gap}");
        assert!(moved <= FACES);
    }

    #[test]
    fn a_chart_that_is_no_larger_than_a_patch_comes_to_rest_as_a_whole() {
        let mut bytes = vec![0; patch_need(72)];
        let (gap, moved) = relaxed(6, 6, 0, &mut bytes).unwrap();
        // Free of all walls it may turn and shift by the little that rounding leaves.
        assert!(gap < 0.05 && moved == 72, "{gap} {moved}");
        assert!(relaxed(6, 6, 0, &mut [0; 1000]).is_err());
    }
}
