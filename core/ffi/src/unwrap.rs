//! `seamwright_unwrap`: a mesh from memory, its atlas into memory.

use crate::code::{Fault, *};
use crate::host::{Host, Listener};
use crate::slices::{Buffers, check, read};
use crate::surface::{Starts, Surface};
use crate::types::*;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::pipeline::{self, Charts, Input, Output, Packing, Settings};
use seamwright_core::rays::binned::BinnedBuilder;

/// Sides of the texture.
const SIZES: core::ops::RangeInclusive<u32> = 16..=65536;
/// Most search work, in hundredths.
const MOST_EFFORT: u32 = 1000;
/// Rays a vertex.
const RAYS: core::ops::RangeInclusive<u32> = 1..=65536;

/// Fills `options` with the command's defaults.
///
/// # Safety
/// `options` points to one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seamwright_defaults(options: *mut SeamwrightOptions) -> i32 {
    let Settings { distortion, size, padding, rays, seed, effort, .. } = Settings::default();
    let (charts, packing) = (SEAMWRIGHT_CHARTS_FEW, SEAMWRIGHT_PACKING_TIGHT);
    let defaults =
        SeamwrightOptions { distortion, seed, size, padding, rays, charts, packing, effort: (100.0 * effort) as u32 };
    if let Err(fault) = check(options) {
        return fault.code;
    }
    // SAFETY: checked.
    unsafe { options.write(defaults) };
    SEAMWRIGHT_OK
}

/// Writes how many bytes of scratch `seamwright_unwrap` asks for. Of the mesh it reads the counts and `polygon_start`, so
/// the other pointers may be null. Some mesh may need more than this estimate: see SEAMWRIGHT_SCRATCH.
///
/// # Safety
/// The pointers are what the header says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seamwright_unwrap_scratch(
    bytes: *mut usize,
    mesh: *const SeamwrightMesh,
    options: *const SeamwrightOptions,
) -> i32 {
    // SAFETY: the caller's promise.
    let need = check(bytes).and_then(|()| unsafe {
        let (mesh, settings) = (read(mesh)?, settings(&read(options)?)?);
        Ok(need(&Starts::read(&mesh, &mut Buffers::default())?, mesh.vertex_count, &settings))
    });
    match need {
        Ok(need) => {
            // SAFETY: checked.
            unsafe { bytes.write(need) };
            SEAMWRIGHT_OK
        }
        Err(fault) => fault.code,
    }
}

/// Makes the atlas of `mesh`: few charts, no flips, no overlaps, the bound of `options` on distortion, seams in hidden
/// places. The same mesh and options give the same bytes on every machine. `report` is written after an error too. `host`
/// may be NULL. `scratch` has any alignment and any contents. Buffers that are written share no byte with others.
///
/// # Safety
/// The pointers are what the header says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seamwright_unwrap(
    atlas: *const SeamwrightAtlas,
    report: *mut SeamwrightReport,
    mesh: *const SeamwrightMesh,
    options: *const SeamwrightOptions,
    host: *const SeamwrightHost,
    scratch: *mut u8,
    scratch_bytes: usize,
) -> i32 {
    if let Err(fault) = check(report) {
        return fault.code;
    }
    // SAFETY: the caller's promise.
    let result = unsafe {
        let host = if host.is_null() { Ok(Host::NONE) } else { read(host).map(Host::new) };
        host.and_then(|host| run(read(atlas)?, read(mesh)?, read(options)?, &host, scratch, scratch_bytes))
    };
    let (code, written) = match result {
        Ok(done) => (SEAMWRIGHT_OK, done),
        Err(Fault { code, detail }) => (code, SeamwrightReport { detail, ..Default::default() }),
    };
    // SAFETY: checked, and no reference is left.
    unsafe { report.write(written) };
    code
}

fn need(starts: &Starts, vertices: usize, settings: &Settings) -> usize {
    let need = pipeline::need_for(&starts.counts(vertices), settings, &BinnedBuilder);
    need.saturating_add(starts.need())
}

/// # Safety
/// The header's contract.
unsafe fn run(
    atlas: SeamwrightAtlas,
    mesh: SeamwrightMesh,
    options: SeamwrightOptions,
    host: &Host,
    scratch: *mut u8,
    bytes: usize,
) -> Result<SeamwrightReport, Fault> {
    let settings = settings(&options)?;
    let mut buffers = Buffers::default();
    // SAFETY: the caller's promise.
    let (mesh, starts, output, bytes) = unsafe {
        let (surface, starts) = Surface::read(&mesh, &mut buffers)?;
        let output = Output {
            corner_uv: buffers.write(atlas.corner_uv.cast(), mesh.corner_count)?,
            polygon_chart: buffers.write(atlas.polygon_chart, mesh.polygon_count)?,
            exposure: buffers.write(atlas.exposure, mesh.vertex_count)?,
        };
        (surface, starts, output, buffers.write(scratch, bytes)?)
    };
    let given = bytes.len();
    let need = need(&starts, mesh.positions.len(), &settings);
    if given < need {
        return Err(Fault::at(SEAMWRIGHT_SCRATCH, need));
    }
    let mut scratch = Scratch::new(bytes);
    let polygon_start = starts.list(&mut scratch).map_err(|e| Fault::scratch(e.need, e.given, given))?;
    let Surface { positions, corners, kept_uv, parts } = mesh;
    let input = Input { kept_uv, parts, ..Input::new(positions, corners, polygon_start) };
    let done = pipeline::unwrap(output, &input, &settings, &BinnedBuilder, scratch, host, &mut Listener(host))
        .map_err(|e| Fault::of_unwrap(e, given))?;
    Ok(SeamwrightReport {
        distortion: done.distortion,
        utilisation: done.utilisation,
        chart_count: done.chart_count,
        piece_count: done.repaired.components,
        welded_vertices: done.repaired.welded_vertices,
        dropped_polygons: done.repaired.dropped_polygons,
        split_edges: done.repaired.split_edges,
        detail: 0,
    })
}

/// Core's settings, where the options are in range.
fn settings(options: &SeamwrightOptions) -> Result<Settings, Fault> {
    let SeamwrightOptions { distortion, seed, size, padding, rays, charts, packing, effort } = *options;
    let mut settings =
        Settings { distortion, seed, size, padding, rays, effort: f64::from(effort) / 100.0, ..Settings::default() };
    match charts {
        SEAMWRIGHT_CHARTS_FEW => settings.charts = Charts::Few,
        SEAMWRIGHT_CHARTS_ONE => settings.charts = Charts::One,
        _ => return Err(Fault::new(SEAMWRIGHT_BAD_CHOICE)),
    }
    match packing {
        SEAMWRIGHT_PACKING_TIGHT => settings.packing = Packing::Tight,
        SEAMWRIGHT_PACKING_GRID => settings.packing = Packing::Grid,
        _ => return Err(Fault::new(SEAMWRIGHT_BAD_CHOICE)),
    }
    let checks = [
        (distortion > 1.0 && distortion.is_finite(), SEAMWRIGHT_BAD_DISTORTION),
        (SIZES.contains(&size) && padding <= size / 4, SEAMWRIGHT_BAD_SIZE),
        (RAYS.contains(&rays), SEAMWRIGHT_BAD_RAYS),
        (effort <= MOST_EFFORT, SEAMWRIGHT_BAD_EFFORT),
    ];
    checks.iter().find(|(holds, _)| !holds).map_or(Ok(settings), |(_, code)| Err(Fault::new(*code)))
}
