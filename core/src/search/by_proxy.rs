//! Cuts found on a decimated mesh and carried over.
//!
//! A search on a few thousand faces takes a tenth of a second whatever the mesh, so there cuts are ruined and recreated until little is
//! gained by it. One coarse mesh with all trials does as well as the better of two meshes with as many each.
//! Creases are lines that the coarse mesh keeps, since cuts follow them.
//! Cost: O(n log n) for the decimation and what is carried over.

use super::budget::Budget;
use super::renewal::{Renewals, renewals_need, search_best};
use crate::base::pace::{Marks, StageError, unless_ended};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::carry::detour::go_round;
use crate::carry::proxy::{proxy_costs, proxy_costs_need};
use crate::carry::slide::Slides;
use crate::carry::transfer::{transfer, transfer_need};
use crate::charts::surface::Surface;
use crate::first::disks::{disks_again, slit_holes};
use crate::mesh::collapse::Collapse;
use crate::mesh::decimate::{decimate, decimate_need};
use crate::mesh::topology::twins;
use crate::mesh::view::MeshView;
use crate::price::turn::turns;
use crate::solve::energy::{MOLLIFY, Rest, even_out};
use glam::{DVec2, DVec3};

/// Faces of the coarse mesh.
const PROXY_FACES: usize = 2000;
/// Pieces of more faces are cut by way of a coarse mesh.
pub const PROXY_FROM: usize = 4500;
/// How far paths may slide while they are carried over.
const SLIDES: Slides = Slides { reach: 2.0, rounds: 3 };
/// An edge that turns by more degrees is a crease.
const CREASE: f64 = 35.0;
/// Where more than this share of all edges are creases they say nothing, and would stop the decimation.
const MOST_CREASES: f64 = 0.5;
/// What a coarse mesh may be distorted over what the mesh may: the same cuts distort a fine mesh less.
const SLACK: f64 = 1.2;
/// A coarse mesh has at most so many faces, or one of [`SHARE`] of the mesh's: handles and holes keep a scan's target from being reached.
const MOST: usize = 6000;
/// See [`MOST`].
const SHARE: usize = 64;
/// A coarse mesh that creases hold above its target by more than one part in so many is decimated without them.
const MORE: usize = 5;

/// Faces of a coarse mesh of one of so many `faces` at the most.
fn most_of(faces: usize) -> usize {
    MOST.max(faces / SHARE)
}

/// Scratch bytes that [`cut_by_proxy`] asks for.
pub fn proxy_need(faces: usize, vertices: usize) -> usize {
    let coarse = most_of(faces);
    let kept = bytes_for::<Collapse>(vertices) + 800 * coarse;
    let flags = bytes_for::<u8>(3 * faces) + bytes_for::<f64>(3 * faces);
    let full = bytes_for::<[u32; 3]>(faces) + bytes_for::<u32>(vertices) + decimate_need(vertices, faces) + flags;
    let search = renewals_need(coarse, coarse, 2);
    let carry = transfer_need(vertices, faces).max(proxy_costs_need(vertices, coarse));
    kept + full.max(search).max(carry)
}

/// A coarse mesh with the cuts that were found on it.
struct Proxy<'p> {
    surface: Surface<'p>,
    history: &'p [Collapse],
    uv: &'p mut [DVec2],
    cut: &'p mut [u8],
}

impl<'p> Proxy<'p> {
    /// Decimates `fine` to `target` faces; nothing where it ends with more than `most`.
    fn new(
        fine: &Surface,
        target: usize,
        most: usize,
        keep: &mut Scratch<'p>,
    ) -> Result<Option<Self>, ScratchTooSmall> {
        let (n, count) = (fine.mesh.positions.len(), fine.mesh.faces.len());
        let history = keep.take::<Collapse>(n)?;
        // The coarse mesh is copied out of full-size memory, which is then free again.
        let faces = keep.take::<[u32; 3]>(most)?;
        let vertex = keep.take::<u32>(most)?;
        let done = {
            let mut frame = keep.frame();
            let hard = frame.take::<u8>(3 * count)?;
            mark_creases(hard, fine, frame.frame())?;
            let (full_faces, full_vertex) = (frame.take::<[u32; 3]>(count)?, frame.take::<u32>(n)?);
            let mut to = |hard: &[u8]| {
                decimate(full_faces, full_vertex, history, fine.mesh, fine.twin, hard, target, frame.frame())
            };
            let mut done = to(hard)?;
            if done.faces > target + target / MORE {
                // The creases of a scan are many and say little.
                hard.fill(0);
                done = to(hard)?;
            }
            if done.faces > most || done.vertices > most {
                return Ok(None);
            }
            faces[..done.faces].copy_from(&full_faces[..done.faces]);
            vertex[..done.vertices].copy_from(&full_vertex[..done.vertices]);
            done
        };
        let (faces, vertex) = (&faces[..done.faces], &vertex[..done.vertices]);
        let positions = keep.take::<DVec3>(vertex.len())?;
        positions.iter_mut().zip(vertex).for_each(|(p, v)| *p = fine.mesh.positions[*v as usize]);
        let mesh = MeshView { positions, faces };
        let twin = keep.take::<u32>(mesh.corner_count())?;
        twins(twin, mesh, keep.frame())?;
        let cost = keep.take::<f64>(mesh.corner_count())?;
        proxy_costs(cost, mesh, twin, vertex, fine, keep.frame())?;
        let rest = keep.take::<Rest>(faces.len())?;
        for (r, f) in rest.iter_mut().zip(faces) {
            *r = Rest::new(f.map(|v| mesh.positions[v as usize]), MOLLIFY);
        }
        even_out(rest);
        let surface = Surface::new(mesh, twin, rest, cost, keep)?;
        let uv = keep.take::<DVec2>(mesh.corner_count())?;
        let cut = keep.take::<u8>(mesh.corner_count())?;
        Ok(Some(Self { surface, history: &history[..done.collapses], uv, cut }))
    }
}

/// Flags the half-edges that turn sharply, unless most do.
fn mark_creases(hard: &mut [u8], surface: &Surface, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let turn = scratch.take::<f64>(hard.len())?;
    turns(turn, surface.mesh, surface.twin, 0.0);
    hard.iter_mut().zip(turn.iter()).for_each(|(h, t)| *h = u8::from(*t > CREASE));
    let creases = hard.iter().filter(|h| **h != 0).count();
    if creases as f64 > MOST_CREASES * hard.len() as f64 {
        hard.fill(0);
    }
    Ok(())
}

/// Writes the cuts of the best of a search on a coarse mesh and of so many `renewals` there. Told to end, at any time after the coarse mesh is
/// there, it carries over what there is. False where there is no coarse mesh, or to carry its cuts over would cut a diagonal or change the
/// charts: the search has to begin on the mesh.
#[allow(clippy::too_many_arguments)]
pub fn cut_by_proxy(
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    renewals: Renewals,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<bool, StageError> {
    marks.mark(surface.mesh.faces.len())?;
    let most = most_of(surface.mesh.faces.len());
    let Some(proxy) = Proxy::new(surface, PROXY_FACES, most, &mut scratch)? else { return Ok(false) };
    let Proxy { surface: coarse, history, uv: coarse_uv, cut: coarse_cut } = proxy;
    let slack = Budget { distortion: 1.0 + SLACK * (budget.distortion - 1.0), ..budget };
    let mut is_done = search_best(coarse_uv, coarse_cut, &coarse, slack, renewals, scratch.frame(), workers, marks)?;
    if is_done {
        let mark = marks.mark(coarse.mesh.faces.len()).map_err(StageError::from);
        is_done = unless_ended(mark, marks)?.is_some();
    }
    slit_holes(coarse_cut, &coarse, scratch.frame().quiet())?;
    let carry = |cut: &mut [u8], mut scratch: Scratch| -> Result<bool, StageError> {
        let carried = transfer(cut, surface, &coarse, coarse_cut, history, SLIDES, scratch.frame())?;
        if carried.is_faithful() && carried.forbidden > 0 {
            let is_round = go_round(cut, surface);
            disks_again(cut, surface, scratch)?;
            return Ok(is_round);
        }
        Ok(carried.is_faithful())
    };
    let in_time = if is_done { unless_ended(carry(cut, scratch.frame()), marks)? } else { None };
    match in_time {
        Some(is_carried) => Ok(is_carried),
        None => carry(cut, scratch.quiet()),
    }
}
