//! `seamwright_measure`: figures of any UV map, the library's own or somebody else's.

use crate::code::{Fault, *};
use crate::slices::{Buffers, check};
use crate::structs::{Room, read};
use crate::surface::{Starts, Surface};
use crate::types::{SeamwrightFigures, SeamwrightMesh};
use glam::DVec2;
use seamwright_core::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use seamwright_core::judge::input::{UvMesh, fan};
use seamwright_core::judge::measure::{Metrics, measure, measure_need};
use seamwright_core::mesh::polygons::Polygons;
use seamwright_core::mesh::triangles::{triangles_need, triangles_of};

/// Most texels a side.
const RESOLUTION: u32 = 16384;

/// Writes how many bytes of scratch `seamwright_measure` asks for. Of the mesh it reads the counts and `polygon_start`.
///
/// # Safety
/// The pointers are what the header says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seamwright_measure_scratch(
    bytes: *mut usize,
    mesh: *const SeamwrightMesh,
    resolution: u32,
) -> i32 {
    // SAFETY: the caller's promise.
    match check(bytes).and_then(|()| unsafe { need(read(mesh)?, resolution) }) {
        Ok(need) => {
            // SAFETY: checked.
            unsafe { bytes.write(need) };
            SEAMWRIGHT_OK
        }
        Err(fault) => fault.code,
    }
}

/// Measures a map of `mesh`: `corner_uv` is (corner_count, 2), NaN where a corner has no UV; `exposure` is (vertex_count)
/// or NULL. `resolution`: texels a side at which overlap and utilisation are sampled, 16384 at the most, 0 for none.
/// Polygons are judged by the triangles that `seamwright_unwrap` makes of them. `figures` is written after an error too.
///
/// # Safety
/// The pointers are what the header says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seamwright_measure(
    figures: *mut SeamwrightFigures,
    mesh: *const SeamwrightMesh,
    corner_uv: *const f64,
    exposure: *const f32,
    resolution: u32,
    scratch: *mut u8,
    scratch_bytes: usize,
) -> i32 {
    // SAFETY: the caller's promise.
    let room = match unsafe { Room::new(figures) } {
        Ok(room) => room,
        Err(fault) => return fault.code,
    };
    // SAFETY: the caller's promise.
    let result =
        unsafe { read(mesh).and_then(|mesh| run(mesh, corner_uv, exposure, resolution, scratch, scratch_bytes)) };
    let (code, written) = match result {
        Ok(found) => (SEAMWRIGHT_OK, found),
        Err(Fault { code, detail }) => (code, SeamwrightFigures { detail, ..SeamwrightFigures::INIT }),
    };
    // SAFETY: no reference is left.
    unsafe { room.write(written) };
    code
}

/// # Safety
/// The header's contract.
unsafe fn need(mesh: SeamwrightMesh, resolution: u32) -> Result<usize, Fault> {
    if resolution > RESOLUTION {
        return Err(Fault::new(SEAMWRIGHT_BAD_SIZE));
    }
    // SAFETY: the caller's promise.
    let starts = unsafe { Starts::read(&mesh, &mut Buffers::default())? };
    let counts = starts.counts(mesh.vertex_count);
    let faces = counts.triangles;
    let soup = bytes_for::<[u32; 3]>(faces).saturating_add(bytes_for::<[DVec2; 3]>(faces));
    Ok(measure_need(mesh.vertex_count, faces, resolution)
        .saturating_add(soup)
        .saturating_add(starts.need())
        .saturating_add(triangles_need(&counts)))
}

/// # Safety
/// The header's contract.
unsafe fn run(
    mesh: SeamwrightMesh,
    corner_uv: *const f64,
    exposure: *const f32,
    resolution: u32,
    scratch: *mut u8,
    bytes: usize,
) -> Result<SeamwrightFigures, Fault> {
    // SAFETY: the caller's promise.
    let (surface, starts, corner_uv, exposure, bytes, need) = unsafe {
        let mut buffers = Buffers::default();
        let (surface, starts) = Surface::read(&mesh, &mut buffers)?;
        let uv: &[DVec2] = buffers.read(corner_uv.cast(), mesh.corner_count)?;
        let exposure = buffers.read_given(exposure, mesh.vertex_count)?;
        (surface, starts, uv, exposure, buffers.write(scratch, bytes)?, need(mesh, resolution)?)
    };
    if let Some(corner) = surface.corners.iter().position(|v| *v as usize >= surface.positions.len()) {
        return Err(Fault::at(SEAMWRIGHT_BAD_INDEX, corner));
    }
    let given = bytes.len();
    if given < need {
        return Err(Fault::at(SEAMWRIGHT_SCRATCH, need));
    }
    let mut scratch = Scratch::new(bytes);
    let short = |e: ScratchTooSmall| Fault::scratch(e.need, e.given, given);
    let list = starts.list(&mut scratch).map_err(short)?;
    let faces = starts.counts(0).triangles;
    let polygons =
        Polygons { positions: surface.positions, corners: surface.corners, polygon_start: list, kept_uv: None };
    let triangles = scratch.take::<[u32; 3]>(faces).map_err(short)?;
    let wedges = scratch.take::<[DVec2; 3]>(faces).map_err(short)?;
    let mut count = 0;
    let mut put = |triangle: [u32; 3]| {
        triangles[count] = triangle.map(|c| surface.corners[c as usize]);
        wedges[count] = triangle.map(|c| corner_uv[c as usize]);
        count += 1;
    };
    // Where a coordinate is no number there is no plane to triangulate in.
    match triangles_of(&polygons, &mut scratch.frame()) {
        Ok(found) => found.corners.iter().for_each(|t| put(*t)),
        Err(_) => list.windows(2).flat_map(|ends| fan(ends[0], ends[1])).for_each(put),
    }
    let view = UvMesh { positions: surface.positions, triangles: &triangles[..count], corner_uv: &wedges[..count] };
    measure(view, exposure, resolution, scratch).map(|m| figures(&m)).map_err(|e| Fault::of_measure(e, given))
}

fn figures(m: &Metrics) -> SeamwrightFigures {
    let (distortion, seen) = (&m.distortion, m.seams.exposure);
    SeamwrightFigures {
        struct_size: SeamwrightFigures::INIT.struct_size,
        conformality: distortion.conformality(),
        equiareality: distortion.equiareality(),
        symmetric_dirichlet: distortion.symmetric_dirichlet,
        stretch_l2: distortion.stretch_l2,
        stretch_linf: distortion.stretch_linf,
        seam_length: m.seams.length_norm,
        visible_seam_length: seen.map_or(f64::NAN, |x| x.visible_length_norm),
        seam_exposure_ratio: seen.map_or(f64::NAN, |x| x.ratio),
        overlap: m.coverage.overlap_fraction(),
        utilisation: m.coverage.utilisation(),
        chart_count: m.charts.count,
        non_disk_charts: m.charts.non_disks,
        faces_without_uv: m.faces_without_uv,
        flipped_faces: m.exact.flipped_faces,
        overlapping_faces: m.exact.overlapping_faces,
        detail: 0,
        closed_or_handled_charts: m.charts.closed_or_handled,
        noticed_seam_length: seen.map_or(f64::NAN, |x| x.noticed_length_norm),
        flat_seam_share: m.seams.flat_share,
        sharp_seam_share: m.seams.sharp_share,
        sharp_seam_cover: m.seams.sharp_cover,
    }
}
