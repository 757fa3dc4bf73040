//! Cuts found on a decimated mesh and carried over.

use super::budget::{Budget, SeamError};
use super::direct::{direct_need, search_from};
use crate::base::scratch::{Scratch, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::carry::proxy::{proxy_costs, proxy_costs_need};
use crate::carry::slide::Slides;
use crate::carry::transfer::{transfer, transfer_need};
use crate::charts::surface::Surface;
use crate::first::disks::cut_to_disks;
use crate::mesh::collapse::Collapse;
use crate::mesh::decimate::{decimate, decimate_need};
use crate::mesh::topology::twins;
use crate::mesh::view::MeshView;
use crate::solve::energy::{MOLLIFY, Rest, even_out};
use glam::{DVec2, DVec3};

/// Faces of the decimated mesh.
const PROXY_FACES: usize = 10_000;
/// How far paths may slide while they are carried over.
const SLIDES: Slides = Slides { reach: 2.0, rounds: 3 };

/// Scratch bytes that [`cut_by_proxy`] asks for.
pub fn proxy_need(faces: usize, vertices: usize) -> usize {
    let coarse = 2 * PROXY_FACES;
    let kept = bytes_for::<Collapse>(vertices) + 600 * coarse;
    let full = bytes_for::<[u32; 3]>(faces) + bytes_for::<u32>(vertices) + decimate_need(vertices, faces);
    let search = direct_need(coarse, coarse, true);
    let carry = transfer_need(vertices, faces).max(proxy_costs_need(vertices, coarse));
    kept + full.max(search).max(carry)
}

/// Finds the cuts on a decimated mesh and carries them over; false where that would cut a forbidden edge or change the
/// number of charts, so that the search has to begin on the mesh itself.
pub fn cut_by_proxy(
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    mut scratch: Scratch,
    workers: &dyn Workers,
    proceed: &mut dyn FnMut() -> bool,
) -> Result<bool, SeamError> {
    let (n, count) = (surface.mesh.positions.len(), surface.mesh.faces.len());
    let history = scratch.take::<Collapse>(n)?;
    // The coarse mesh is copied out of full-size memory, which is then free again.
    let coarse_faces = scratch.take::<[u32; 3]>(2 * PROXY_FACES)?;
    let vertex = scratch.take::<u32>(2 * PROXY_FACES)?;
    let done = {
        let mut frame = scratch.frame();
        let (full_faces, full_vertex) = (frame.take::<[u32; 3]>(count)?, frame.take::<u32>(n)?);
        let done = decimate(full_faces, full_vertex, history, surface.mesh, surface.twin, PROXY_FACES, frame)?;
        if done.faces > coarse_faces.len() || done.vertices > vertex.len() {
            return Ok(false);
        }
        coarse_faces[..done.faces].copy_from(&full_faces[..done.faces]);
        vertex[..done.vertices].copy_from(&full_vertex[..done.vertices]);
        done
    };
    let (coarse_faces, vertex) = (&coarse_faces[..done.faces], &vertex[..done.vertices]);
    let positions = scratch.take::<DVec3>(vertex.len())?;
    positions.iter_mut().zip(vertex).for_each(|(p, v)| *p = surface.mesh.positions[*v as usize]);
    let mesh = MeshView { positions, faces: coarse_faces };
    let twin = scratch.take::<u32>(mesh.corner_count())?;
    twins(twin, mesh, scratch.frame())?;
    let cost = scratch.take::<f64>(mesh.corner_count())?;
    proxy_costs(cost, mesh, twin, vertex, surface, scratch.frame())?;
    let rest = scratch.take::<Rest>(coarse_faces.len())?;
    for (r, f) in rest.iter_mut().zip(coarse_faces) {
        *r = Rest::new(f.map(|v| mesh.positions[v as usize]), MOLLIFY);
    }
    even_out(rest);
    let coarse = Surface::new(mesh, twin, rest, cost, &mut scratch)?;
    let coarse_cut = scratch.take::<u8>(mesh.corner_count())?;
    let coarse_uv = scratch.take::<DVec2>(mesh.corner_count())?;
    let whole = &Surface { stays_whole: budget.whole, ..coarse };
    cut_to_disks(coarse_cut, whole, scratch.frame())?;
    search_from(coarse_uv, coarse_cut, &coarse, budget, true, scratch.frame(), workers, proceed)?;
    let moved = transfer(cut, surface, &coarse, coarse_cut, &history[..done.collapses], SLIDES, scratch)?;
    Ok(moved.is_faithful() && moved.forbidden == 0)
}
