//! The C interface called as C may call it: null, misaligned and shared buffers, counts that lie, options of any bits, too
//! little scratch, a host that stops or runs tasks backwards: a code, or a valid atlas whose bits no memory changes.
#![no_main]

use glam::DVec2;
use libfuzzer_sys::fuzz_target;
use seamwright_core::mesh::cracks::Weld;
use seamwright_core::pipeline::Report;
use seamwright_ffi::*;
use seamwright_fuzz::bytes::Bytes;
use seamwright_fuzz::case::{Case, HOSTILE};
use seamwright_fuzz::check::{Made, valid};
use std::ffi::{c_char, c_void};
use std::ptr::{null, null_mut};

/// Bytes of scratch beyond which a run is given up.
const MOST: usize = 1 << 28;

extern "C" fn backwards(_: *mut c_void, count: usize, task: SeamwrightTask, context: *mut c_void) {
    (0..count).rev().for_each(|i| task(context, i));
}

/// Repeats a task, invents one and leaves out the rest: against the contract, and harmless all the same.
extern "C" fn careless(_: *mut c_void, count: usize, task: SeamwrightTask, context: *mut c_void) {
    [count / 2, count / 2, usize::MAX].into_iter().for_each(|i| task(context, i));
}

/// Stops after as many reports as `user` points to.
extern "C" fn impatient(user: *mut c_void, _: *const c_char, _: usize, _: usize) -> i32 {
    // SAFETY: `user` is the byte of this call.
    let left = unsafe { &mut *user.cast::<u8>() };
    *left = left.saturating_sub(1);
    i32::from(*left == 0)
}

fn options(bytes: &mut Bytes, is_wild: bool) -> SeamwrightOptions {
    if is_wild {
        let word = |bytes: &mut Bytes| bytes.pick(&[1, 0, 16, 64, 0xffff, 0x10000, u32::MAX, 4]);
        return SeamwrightOptions {
            distortion: HOSTILE[usize::from(bytes.byte()) & 15] * 2.0,
            seed: u64::from_le_bytes(bytes.array()),
            size: word(bytes),
            padding: word(bytes),
            rays: word(bytes) & 0x1001f,
            charts: u32::from(bytes.byte() % 3),
            packing: u32::from(bytes.byte() % 3),
            effort: word(bytes) & 0xf003,
            hard_edges: u32::from(bytes.byte() % 4),
            prefer: u32::from(bytes.byte() % 4),
            straighten: u32::from(bytes.byte() % 3),
            search: bytes.pick(&[0, 2, 101]),
            ..SeamwrightOptions::INIT
        };
    }
    SeamwrightOptions {
        distortion: bytes.pick(&[1.025, 1.0001, 1.5, 1e9]),
        seed: bytes.byte().into(),
        size: bytes.pick(&[1024, 16, 64, 65536]),
        padding: bytes.pick(&[2, 0, 1, 4]),
        rays: bytes.pick(&[8, 1, 3, 16]),
        charts: u32::from(bytes.byte() & 1),
        packing: u32::from(bytes.byte() != 255),
        effort: bytes.pick(&[0, 1, 5]),
        ..SeamwrightOptions::INIT
    }
}

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = Bytes(bytes);
    let (flags, mut patience) = (bytes.byte(), bytes.byte());
    let options = options(&mut bytes, flags & 3 == 3);
    let broken = if flags & 0x1c == 0x1c { bytes.byte() } else { 0 };
    let case = Case::read(&mut bytes, 0);
    let mut made = Made::room(&case);
    let mut mesh = mesh(&case);
    let mut atlas = SeamwrightAtlas {
        corner_uv: made.corner_uv.as_mut_ptr().cast(),
        polygon_chart: made.polygon_chart.as_mut_ptr(),
        exposure: made.exposure.as_mut_ptr(),
        ..SeamwrightAtlas::INIT
    };
    lie(broken, &mut mesh, &mut atlas);
    let progress: Option<extern "C" fn(_, _, _, _) -> _> = if flags & 0x20 == 0 { None } else { Some(impatient) };
    let run: Option<extern "C" fn(_, _, _, _)> =
        if flags & 0x40 == 0 { None } else { Some(if patience & 1 == 0 { backwards } else { careless }) };
    let host = SeamwrightHost { user: (&raw mut patience).cast(), progress, run, ..SeamwrightHost::INIT };
    let mut report = SeamwrightReport::INIT;
    let mut need = 0;
    // SAFETY: all pointers are those of living buffers, or wrong in a way that the interface promises to see.
    let code = unsafe { seamwright_unwrap_scratch(&mut need, &mesh, &options) };
    if code != SEAMWRIGHT_OK {
        need = 1000;
    }
    let mut short = if flags & 0x80 == 0 { 0 } else { 1 + need / 2 };
    while need < MOST {
        let mut scratch = vec![0xa5; need + 1 - short];
        let (start, length) = (scratch.as_mut_ptr().wrapping_add(1), need - short);
        // SAFETY: as above; any alignment will do for scratch.
        let code = unsafe { seamwright_unwrap(&atlas, &mut report, &mesh, &options, &host, start, length) };
        assert!(code != SEAMWRIGHT_INTERNAL && code != SEAMWRIGHT_OVERLAP, "code {code}");
        if code == SEAMWRIGHT_SCRATCH && report.detail != 0 {
            assert!(report.detail > length, "{} bytes are asked for, {length} given", report.detail);
            (need, short) = (report.detail, 0);
            continue;
        }
        if code == SEAMWRIGHT_OK && broken == 0 {
            let (distortion, chart_count) = (report.distortion, report.chart_count);
            valid(&case, &made, &Report { distortion, chart_count, ..Report::default() }, Weld::Equal);
            again(&case, &made, &options, 2 * need);
        }
        break;
    }
    measured(&case, &mut made, flags);
});

fn mesh(case: &Case) -> SeamwrightMesh {
    SeamwrightMesh {
        positions: case.positions.as_ptr().cast(),
        vertex_count: case.positions.len(),
        corners: case.corners.as_ptr(),
        corner_count: case.corners.len(),
        polygon_start: case.polygon_start.as_ptr(),
        polygon_count: case.polygon_start.len() - 1,
        kept_uv: case.kept_uv.as_ref().map_or(null(), |uv| uv.as_ptr().cast()),
        parts: case.parts.as_ref().map_or(null(), Vec::as_ptr),
        ..SeamwrightMesh::INIT
    }
}

/// Breaks one thing that the interface can see.
fn lie(how: u8, mesh: &mut SeamwrightMesh, atlas: &mut SeamwrightAtlas) {
    match how % 24 {
        1 => mesh.positions = null(),
        2 => mesh.corners = null(),
        3 => mesh.polygon_start = null(),
        4 => atlas.corner_uv = null_mut(),
        5 => atlas.polygon_chart = null_mut(),
        6 => atlas.exposure = null_mut(),
        7 => mesh.positions = mesh.positions.cast::<u8>().wrapping_add(1).cast(),
        8 => mesh.corners = mesh.corners.cast::<u8>().wrapping_add(2).cast(),
        9 => atlas.corner_uv = atlas.corner_uv.cast::<u8>().wrapping_add(4).cast(),
        10 => atlas.corner_uv = mesh.positions.cast_mut(),
        11 => atlas.polygon_chart = mesh.corners.cast_mut(),
        12 => atlas.exposure = atlas.polygon_chart.cast(),
        13 => mesh.vertex_count = usize::MAX,
        14 => mesh.corner_count = usize::MAX / 4,
        15 => mesh.polygon_count = usize::MAX,
        16 => mesh.polygon_count = usize::MAX / 3,
        // Fewer are read than there are.
        17 => mesh.vertex_count = mesh.vertex_count.saturating_sub(1),
        18 => mesh.corner_count = mesh.corner_count.saturating_sub(1),
        19 => mesh.polygon_count = mesh.polygon_count.saturating_sub(1),
        20 => (mesh.vertex_count, mesh.positions) = (0, null()),
        21 => (mesh.corner_count, mesh.polygon_count) = (0, 0),
        22 => (mesh.polygon_start, mesh.polygon_count) = (null(), mesh.polygon_count.min(mesh.corner_count / 3)),
        23 => mesh.vertex_count = u32::MAX as usize,
        _ => {}
    }
}

/// More memory, full of something else, without host: the same bits.
fn again(case: &Case, made: &Made, options: &SeamwrightOptions, need: usize) {
    let mut other = Made::room(case);
    let atlas = SeamwrightAtlas {
        corner_uv: other.corner_uv.as_mut_ptr().cast(),
        polygon_chart: other.polygon_chart.as_mut_ptr(),
        exposure: other.exposure.as_mut_ptr(),
        ..SeamwrightAtlas::INIT
    };
    let mut scratch = vec![0; need];
    let mut report = SeamwrightReport::INIT;
    let (start, length) = (scratch.as_mut_ptr(), scratch.len());
    // SAFETY: living buffers of the right lengths.
    let code = unsafe { seamwright_unwrap(&atlas, &mut report, &mesh(case), options, null(), start, length) };
    assert_eq!(code, SEAMWRIGHT_OK, "with more memory");
    assert_eq!(made.bits(), other.bits(), "memory or host change the bits");
}

/// Figures of whatever stands in the atlas, or of the kept UVs.
fn measured(case: &Case, made: &mut Made, flags: u8) {
    let uv: &[DVec2] = if flags & 1 == 0 { &made.corner_uv } else { case.kept_uv.as_ref().unwrap_or(&made.corner_uv) };
    let (mesh, resolution) = (mesh(case), [0, 1, 16, 33][usize::from(flags >> 1 & 3)]);
    let (mut need, mut figures) = (0, SeamwrightFigures::INIT);
    // SAFETY: living buffers of the right lengths.
    unsafe {
        if seamwright_measure_scratch(&mut need, &mesh, resolution) == SEAMWRIGHT_OK {
            let mut scratch = vec![0xa5; need];
            let (uv, exposure, start) = (uv.as_ptr().cast(), made.exposure.as_ptr(), scratch.as_mut_ptr());
            let code = seamwright_measure(&mut figures, &mesh, uv, exposure, resolution, start, need);
            assert!([SEAMWRIGHT_OK, SEAMWRIGHT_BAD_INDEX].contains(&code), "code {code}");
        }
    }
}
