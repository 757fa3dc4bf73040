//! First cuts: every component becomes disks, through its handles, border loops and far extremities.
//!
//! Handles are cut along the loops of a tree-cotree decomposition (`handles`), tips of limbs are found (`tips`), and both are
//! joined with the border loops by cheapest paths (`joining`). Charts that later cuts leave with holes are made disks in the same
//! way, each as a mesh of its own.
//! Guarantee: afterwards every component is one disk. Cost: O(n log n).

use super::handles::cut_handles;
use super::joining::join;
use super::tips::find_tips;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::union_find::UnionFind;
use crate::charts::list::ChartList;
use crate::charts::surface::Surface;
use crate::mesh::loops::next_on_border;
use crate::mesh::view::{MeshView, NONE, next};
use glam::DVec3;

/// Marks cuts so that every component becomes one disk whose border passes all tips.
pub fn cut_to_disks(cut: &mut [u8], surface: &Surface, scratch: Scratch) -> Result<(), ScratchTooSmall> {
    cut_where_not_disks(cut, surface, true, scratch)
}

/// As [`cut_to_disks`]; without `tips` only what the topology asks for.
fn cut_where_not_disks(
    cut: &mut [u8],
    surface: &Surface,
    tips: bool,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = surface.mesh.positions.len();
    let component = scratch.take::<u32>(n)?;
    let count = components(component, surface);
    let loops = scratch.take_filled::<u32>(n, NONE)?; // border loop of each vertex
    let loop_count = border_loops(loops, surface);
    let tip = scratch.take::<u8>(n)?;
    if tips || loop_count < count {
        find_tips(tip, component, count, surface, scratch.frame())?;
    }
    let joined = scratch.take::<u8>(n)?; // vertices on the cut graph so far
    cut_handles(cut, joined, loops, loop_count, component, surface, scratch.frame())?;
    join(cut, joined, tip, loops, component, count, surface, scratch)?;
    lengthen_single_edges(cut, surface);
    Ok(())
}

/// Lengthens slits of one edge in closed components. Such a disk has a border of two corners, which no circle holds apart: a
/// map needs three that are not on one line.
fn lengthen_single_edges(cut: &mut [u8], surface: &Surface) {
    for c in 0..cut.len() as u32 {
        let t = surface.twin[c as usize];
        let is_single =
            cut[c as usize] != 0 && c < t && surface.following(cut, c) == t && surface.following(cut, t) == c;
        if !is_single {
            continue;
        }
        let ends = [surface.mesh.vertex(c), surface.mesh.vertex(next(c))];
        let beside = ends.into_iter().flat_map(|v| surface.edges_at(v)).filter(|(_, w)| !ends.contains(w));
        let cheapest = beside.min_by(|a, b| surface.cost[a.0 as usize].total_cmp(&surface.cost[b.0 as usize]));
        if let Some((edge, _)) = cheapest {
            surface.set_cut(cut, edge, true);
        }
    }
}

/// Cuts from the holes of charts to their outer borders, where there are charts with holes.
pub fn slit_holes(cut: &mut [u8], surface: &Surface, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let has_holes = {
        let mut frame = scratch.frame();
        let charts = ChartList::new(surface, cut, &mut frame)?;
        let borders = frame.take::<u8>(charts.count())?;
        let seen = frame.take::<u8>(cut.len())?;
        for first in 0..cut.len() as u32 {
            if surface.is_open(cut, first) && seen[first as usize] == 0 {
                surface.border(cut, first).for_each(|c| seen[c as usize] = 1);
                let borders = &mut borders[charts.of_face[first as usize / 3] as usize];
                *borders = borders.saturating_add(1);
            }
        }
        borders.iter().any(|b| *b > 1)
    };
    if has_holes { disks_again(cut, surface, scratch) } else { Ok(()) }
}

/// Cuts on where cuts have left charts that are not disks: each chart by itself, as a mesh whose border the cuts are.
pub fn disks_again(cut: &mut [u8], surface: &Surface, scratch: Scratch) -> Result<(), ScratchTooSmall> {
    cut_each(cut, surface, false, scratch)
}

/// The same where no map has been yet: the borders of the disks pass all tips.
pub fn disks_with_tips(cut: &mut [u8], surface: &Surface, scratch: Scratch) -> Result<(), ScratchTooSmall> {
    cut_each(cut, surface, true, scratch)
}

fn cut_each(cut: &mut [u8], surface: &Surface, tips: bool, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let corners = surface.mesh.corner_count();
    let node = scratch.take::<[u32; 3]>(surface.mesh.faces.len())?;
    let count = surface.wedges(cut, node.as_flattened_mut());
    let positions = scratch.take::<DVec3>(count)?;
    let twin = scratch.take::<u32>(corners)?;
    for c in 0..corners {
        positions[node.as_flattened()[c] as usize] = surface.mesh.position(c as u32);
        twin[c] = surface.across(cut, c as u32).unwrap_or(NONE);
    }
    let mesh = MeshView { positions, faces: node };
    let parted = Surface::new(mesh, twin, surface.rest, surface.cost, &mut scratch)?;
    let more = scratch.take::<u8>(corners)?;
    cut_where_not_disks(more, &parted, tips, scratch)?;
    for c in 0..corners as u32 {
        if more[c as usize] != 0 {
            surface.set_cut(cut, c, true);
        }
    }
    Ok(())
}

/// Component of each vertex; returns their count. Vertices without faces are components of their own.
fn components(component: &mut [u32], surface: &Surface) -> usize {
    let mut sets = UnionFind::new(component);
    for f in surface.mesh.faces {
        sets.union(f[0], f[1]);
        sets.union(f[1], f[2]);
    }
    sets.number()
}

/// Border loop of each vertex on the border; returns their count.
fn border_loops(loops: &mut [u32], surface: &Surface) -> usize {
    let mut count = 0;
    for c in 0..surface.mesh.corner_count() as u32 {
        if surface.twin[c as usize] != NONE || loops[surface.mesh.vertex(c) as usize] != NONE {
            continue;
        }
        let mut at = c;
        loop {
            loops[surface.mesh.vertex(at) as usize] = count;
            at = next_on_border(surface.twin, at);
            if at == c || loops[surface.mesh.vertex(at) as usize] == count {
                break;
            }
        }
        count += 1;
    }
    count as usize
}
