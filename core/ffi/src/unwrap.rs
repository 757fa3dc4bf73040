//! `seamwright_unwrap`: a mesh from memory, its atlas into memory.

use crate::code::{Fault, *};
use crate::host::{Host, Listener};
use crate::slices::{Buffers, check};
use crate::structs::{Room, read};
use crate::surface::{Starts, Surface};
use crate::types::*;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::mesh::cracks::Weld;
use seamwright_core::pipeline::{self, Charts, Input, Output, Packing, Settings, Snap, Stacking, Straighten};
use seamwright_core::price::cost::Prefer;
use seamwright_core::price::given::HardEdges;
use seamwright_core::rays::binned::BinnedBuilder;

/// Sides of the texture.
const SIZES: core::ops::RangeInclusive<u32> = 16..=65536;
/// Most search work, in hundredths.
const MOST_EFFORT: u32 = 1000;
/// Most further searches.
const MOST_SEARCH: u32 = 100;
/// Widest crack that is closed.
const MOST_WELD: f64 = 0.01;
/// Rays a vertex.
const RAYS: core::ops::RangeInclusive<u32> = 1..=65536;

/// Fills `options` with the command's defaults, whatever stands there. `struct_size`: sizeof *options.
///
/// # Safety
/// `options` points to so many bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seamwright_defaults(options: *mut SeamwrightOptions, struct_size: usize) -> i32 {
    let Settings { distortion, size, padding, rays, seed, effort, .. } = Settings::default();
    let effort = (100.0 * effort) as u32;
    // Choices are those that have the number 0.
    let defaults = SeamwrightOptions { distortion, seed, size, padding, rays, effort, ..SeamwrightOptions::INIT };
    // SAFETY: the caller's promise.
    match unsafe { Room::cleared(options, struct_size).map(|room| room.write(defaults)) } {
        Ok(()) => SEAMWRIGHT_OK,
        Err(fault) => fault.code,
    }
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
    // SAFETY: the caller's promise.
    let room = match unsafe { Room::new(report) } {
        Ok(room) => room,
        Err(fault) => return fault.code,
    };
    // SAFETY: the caller's promise.
    let result = unsafe {
        let host = if host.is_null() { Ok(Host::none()) } else { read(host).map(Host::new) };
        host.and_then(|host| run(read(atlas)?, read(mesh)?, read(options)?, &host, scratch, scratch_bytes))
    };
    let (code, written) = match result {
        Ok(done) => (SEAMWRIGHT_OK, done),
        Err(Fault { code, detail }) => (code, SeamwrightReport { detail, ..SeamwrightReport::INIT }),
    };
    // SAFETY: no reference is left.
    unsafe { room.write(written) };
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
    let Surface { positions, corners, kept_uv, parts, edges, tolerance } = mesh;
    let input = Input { positions, corners, polygon_start, kept_uv, parts, edges, tolerance };
    let mut listener = Listener { host, may_finish: settings.ends_early };
    let done = pipeline::unwrap(output, &input, &settings, &BinnedBuilder, scratch, host, &mut listener)
        .map_err(|e| Fault::of_unwrap(e, given))?;
    Ok(SeamwrightReport {
        struct_size: SeamwrightReport::INIT.struct_size,
        distortion: done.distortion,
        utilisation: done.utilisation,
        chart_count: done.chart_count,
        piece_count: done.repaired.components,
        welded_vertices: done.repaired.welded_vertices,
        dropped_polygons: done.repaired.dropped_polygons,
        split_edges: done.repaired.split_edges,
        detail: 0,
        closed_edges: done.repaired.closed_edges,
        ended_early: usize::from(done.ended_early.is_some()),
    })
}

/// Core's settings, where the options are in range.
fn settings(options: &SeamwrightOptions) -> Result<Settings, Fault> {
    let SeamwrightOptions { distortion, seed, size, padding, rays, effort, search, .. } = *options;
    let none_of_them = Err(Fault::new(SEAMWRIGHT_BAD_CHOICE));
    let charts = match options.charts {
        SEAMWRIGHT_CHARTS_FEW => Charts::Few,
        SEAMWRIGHT_CHARTS_ONE => Charts::One,
        _ => return none_of_them,
    };
    let packing = match options.packing {
        SEAMWRIGHT_PACKING_TIGHT => Packing::Tight,
        SEAMWRIGHT_PACKING_GRID => Packing::Grid,
        _ => return none_of_them,
    };
    let hard_edges = match options.hard_edges {
        SEAMWRIGHT_HARD_EDGES_PREFER => HardEdges::Prefer,
        SEAMWRIGHT_HARD_EDGES_REQUIRE => HardEdges::Require,
        SEAMWRIGHT_HARD_EDGES_OFF => HardEdges::Off,
        _ => return none_of_them,
    };
    let prefer = match options.prefer {
        SEAMWRIGHT_PREFER_BALANCE => Prefer::Balance,
        SEAMWRIGHT_PREFER_SEAMS => Prefer::Seams,
        SEAMWRIGHT_PREFER_FILL => Prefer::Fill,
        _ => return none_of_them,
    };
    let straighten = match options.straighten {
        SEAMWRIGHT_STRAIGHTEN_AUTO => Straighten::Auto,
        SEAMWRIGHT_STRAIGHTEN_OFF => Straighten::Off,
        SEAMWRIGHT_STRAIGHTEN_STRIPS => Straighten::Strips,
        _ => return none_of_them,
    };
    let weld = match options.weld {
        SEAMWRIGHT_WELD_AUTO => Weld::Auto,
        0.0 => Weld::Equal,
        share if share > 0.0 && share <= MOST_WELD => Weld::Within(share),
        _ => return none_of_them,
    };
    let stack = match options.stack {
        SEAMWRIGHT_STACK_OFF => Stacking::Off,
        SEAMWRIGHT_STACK_SAME => Stacking::Same,
        SEAMWRIGHT_STACK_MIRRORED => Stacking::Mirrored,
        _ => return none_of_them,
    };
    let snap = match options.snap {
        SEAMWRIGHT_SNAP_OFF => Snap::Off,
        SEAMWRIGHT_SNAP_TEXEL => Snap::Texel,
        _ => return none_of_them,
    };
    if options.stack_offset > 1 || options.may_finish > 1 {
        return none_of_them;
    }
    let settings = Settings {
        distortion,
        charts,
        packing,
        size,
        padding,
        effort: f64::from(effort) / 100.0,
        rays,
        straighten,
        weld,
        stack,
        stack_offset: options.stack_offset,
        snap,
        ends_early: options.may_finish == 1,
        hard_edges,
        prefer,
        search,
        seed,
        ..Settings::default()
    };
    let checks = [
        (distortion > 1.0 && distortion.is_finite(), SEAMWRIGHT_BAD_DISTORTION),
        (SIZES.contains(&size) && padding <= size / 4, SEAMWRIGHT_BAD_SIZE),
        (RAYS.contains(&rays), SEAMWRIGHT_BAD_RAYS),
        (effort <= MOST_EFFORT && search <= MOST_SEARCH, SEAMWRIGHT_BAD_EFFORT),
    ];
    checks.iter().find(|(holds, _)| !holds).map_or(Ok(settings), |(_, code)| Err(Fault::new(*code)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_cores_and_every_choice_has_a_number() {
        let mut options = SeamwrightOptions::INIT;
        // SAFETY: it is one.
        assert_eq!(unsafe { seamwright_defaults(&mut options, size_of_val(&options)) }, SEAMWRIGHT_OK);
        let text = |settings: Result<Settings, Fault>| std::format!("{settings:?}");
        assert_eq!(text(settings(&options)), text(Ok(Settings::default())));
        let chosen = |choose: fn(&mut SeamwrightOptions)| {
            let mut options = options;
            choose(&mut options);
            settings(&options)
        };
        type Case = (fn(&mut SeamwrightOptions), fn(&mut Settings));
        let cases: [Case; 16] = [
            (|o| o.charts = SEAMWRIGHT_CHARTS_ONE, |s| s.charts = Charts::One),
            (|o| o.packing = SEAMWRIGHT_PACKING_GRID, |s| s.packing = Packing::Grid),
            (|o| o.hard_edges = SEAMWRIGHT_HARD_EDGES_REQUIRE, |s| s.hard_edges = HardEdges::Require),
            (|o| o.hard_edges = SEAMWRIGHT_HARD_EDGES_OFF, |s| s.hard_edges = HardEdges::Off),
            (|o| o.prefer = SEAMWRIGHT_PREFER_SEAMS, |s| s.prefer = Prefer::Seams),
            (|o| o.prefer = SEAMWRIGHT_PREFER_FILL, |s| s.prefer = Prefer::Fill),
            (|o| o.straighten = SEAMWRIGHT_STRAIGHTEN_OFF, |s| s.straighten = Straighten::Off),
            (|o| o.straighten = SEAMWRIGHT_STRAIGHTEN_STRIPS, |s| s.straighten = Straighten::Strips),
            (|o| o.search = 7, |s| s.search = 7),
            (|o| o.weld = 1e-4, |s| s.weld = Weld::Within(1e-4)),
            (|o| o.weld = SEAMWRIGHT_WELD_AUTO, |s| s.weld = Weld::Auto),
            (|o| o.stack = SEAMWRIGHT_STACK_SAME, |s| s.stack = Stacking::Same),
            (|o| o.stack = SEAMWRIGHT_STACK_MIRRORED, |s| s.stack = Stacking::Mirrored),
            (|o| o.stack_offset = 1, |s| s.stack_offset = 1),
            (|o| o.snap = SEAMWRIGHT_SNAP_TEXEL, |s| s.snap = Snap::Texel),
            (|o| o.may_finish = 1, |s| s.ends_early = true),
        ];
        for (choose, same) in cases {
            let mut expected = Settings::default();
            same(&mut expected);
            assert_eq!(text(chosen(choose)), text(Ok(expected)));
        }
        let beyond: [fn(&mut SeamwrightOptions); 11] = [
            |o| o.charts = 2,
            |o| o.packing = 2,
            |o| o.hard_edges = 3,
            |o| o.prefer = 3,
            |o| o.straighten = 3,
            |o| o.weld = 0.1,
            |o| o.weld = f64::NAN,
            |o| o.stack = 3,
            |o| o.stack_offset = 2,
            |o| o.snap = 2,
            |o| o.may_finish = 2,
        ];
        for choose in beyond {
            assert_eq!(chosen(choose).err(), Some(Fault::new(SEAMWRIGHT_BAD_CHOICE)));
        }
    }
}
