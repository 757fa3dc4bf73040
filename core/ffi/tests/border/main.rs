//! The C interface called as C calls it: the same atlas as core's own, and an error code for every kind of bad input.

mod call;
mod edges;
mod structs;

use call::{Call, bits};
use core::ffi::{CStr, c_char, c_void};
use glam::{DVec2, DVec3};
use seamwright_core::base::{progress::Silent, scratch::Scratch, workers::Serial};
use seamwright_core::pipeline::{Input, Output, Settings, unwrap, unwrap_need};
use seamwright_core::rays::binned::BinnedBuilder;
use seamwright_ffi::*;
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// What core says of the same mesh, as bits.
fn by_core(call: &Call) -> (Vec<u64>, Vec<u32>, Vec<u32>) {
    let positions: Vec<_> = call.positions.chunks(3).map(DVec3::from_slice).collect();
    let triangles: Vec<_> = (0..=call.chart.len() as u32).map(|p| 3 * p).collect();
    let polygon_start = if call.polygon_start.is_empty() { &triangles } else { &call.polygon_start };
    let corners = &call.corners;
    let input = Input::new(&positions, corners, polygon_start);
    let settings = Settings::default();
    let mut uv = vec![DVec2::ZERO; corners.len()];
    let (mut chart, mut exposure) = (vec![0; call.chart.len()], vec![0.0; positions.len()]);
    let output = Output { corner_uv: &mut uv, polygon_chart: &mut chart, exposure: &mut exposure };
    let mut bytes = vec![0; unwrap_need(&input, &settings, &BinnedBuilder)];
    unwrap(output, &input, &settings, &BinnedBuilder, Scratch::new(&mut bytes), &Serial, &mut Silent).unwrap();
    let uv = uv.iter().flat_map(|uv| [uv.x.to_bits(), uv.y.to_bits()]).collect();
    (uv, chart, exposure.iter().map(|e: &f32| e.to_bits()).collect())
}

#[test]
fn polygons_and_triangles_get_the_atlas_that_core_makes() {
    for mut call in [Call::cube(), Call::tetrahedron()] {
        assert_eq!(call.run(), SEAMWRIGHT_OK);
        assert_eq!(bits(&call), by_core(&call));
        assert!(call.report.chart_count >= 1 && call.report.piece_count == 1 && call.report.detail == 0);
    }
}

/// Three threads, each with every third task, the last one first.
extern "C" fn on_threads(user: *mut c_void, count: usize, task: SeamwrightTask, context: *mut c_void) {
    unsafe { &*user.cast::<AtomicUsize>() }.fetch_add(count, Ordering::Relaxed);
    let context = context as usize;
    thread::scope(|scope| {
        for first in 0..3 {
            scope.spawn(move || (first..count).step_by(3).rev().for_each(|i| task(context as *mut c_void, i)));
        }
    });
}

extern "C" fn stop_at_packing(user: *mut c_void, stage: *const c_char, _: usize, _: usize) -> i32 {
    unsafe { &*user.cast::<AtomicUsize>() }.fetch_add(1, Ordering::Relaxed);
    i32::from(unsafe { CStr::from_ptr(stage) } == c"pack")
}

#[test]
fn tasks_may_run_on_any_thread_and_progress_may_stop_the_run() {
    let (mut call, count) = (Call::cubes(), AtomicUsize::new(0));
    let user = (&raw const count).cast_mut().cast();
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    let serial = bits(&call);
    call.host = SeamwrightHost { user, run: Some(on_threads), ..SeamwrightHost::INIT };
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    assert_eq!(bits(&call), serial);
    assert!(count.swap(0, Ordering::Relaxed) > 0);
    call.host = SeamwrightHost { user, progress: Some(stop_at_packing), ..SeamwrightHost::INIT };
    assert_eq!(call.run(), SEAMWRIGHT_CANCELLED);
    assert!(count.into_inner() > 2);
}

extern "C" fn finish_seams(_: *mut c_void, stage: *const c_char, _: usize, _: usize) -> i32 {
    if unsafe { CStr::from_ptr(stage) } == c"seams" { SEAMWRIGHT_FINISH } else { SEAMWRIGHT_GO_ON }
}

#[test]
fn progress_may_end_stages_early_where_the_options_allow_it() {
    let mut call = Call::cubes();
    call.host = SeamwrightHost { progress: Some(finish_seams), ..SeamwrightHost::INIT };
    assert_eq!(call.run(), SEAMWRIGHT_CANCELLED);
    call.options.may_finish = 1;
    let mut bytes = 0;
    assert_eq!(unsafe { seamwright_unwrap_scratch(&mut bytes, &call.mesh, &call.options) }, SEAMWRIGHT_OK);
    call.scratch.resize(bytes, 0);
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    assert!(call.report.ended_early == 1 && call.report.chart_count > 1);
    assert!(call.uv.iter().all(|x| (0.0..=1.0).contains(x)));
    let ended = bits(&call);
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    assert_eq!(bits(&call), ended);
    call.host = SeamwrightHost::INIT;
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    assert_eq!((call.report.ended_early, bits(&call)), (0, by_core(&call)));
}

#[test]
fn scratch_that_is_too_small_says_what_to_try() {
    let mut call = Call::tetrahedron();
    let enough = call.scratch.len();
    call.scratch.truncate(enough - 1);
    assert_eq!(call.run(), SEAMWRIGHT_SCRATCH);
    assert_eq!(call.report.detail, enough);
    call.scratch.clear();
    assert_eq!(call.run(), SEAMWRIGHT_SCRATCH);
    assert_eq!(call.report.detail, enough);
    call.scratch.resize(enough, 0);
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    assert_eq!(bits(&call), by_core(&call));
}

/// A pointer that is aligned for nothing but bytes.
fn odd<T>() -> *const T {
    std::ptr::without_provenance(4095)
}

#[test]
fn bad_input_has_a_code_and_a_place() {
    type Check = (&'static str, fn(&mut Call), i32, usize);
    let checks: [Check; 25] = [
        ("no positions", |c| c.mesh.positions = null(), SEAMWRIGHT_NULL, 0),
        ("no corners", |c| c.mesh.corners = null(), SEAMWRIGHT_NULL, 0),
        ("odd positions", |c| c.mesh.positions = c.mesh.positions.wrapping_byte_add(4), SEAMWRIGHT_MISALIGNED, 0),
        ("shared with outputs", |c| c.mesh.kept_uv = c.uv.as_ptr(), SEAMWRIGHT_SHARED, 0),
        ("many vertices", |c| c.mesh.vertex_count = usize::MAX, SEAMWRIGHT_TOO_LARGE, 0),
        ("many corners", |c| c.mesh.corner_count = usize::MAX, SEAMWRIGHT_TOO_LARGE, 0),
        ("many polygons", |c| c.mesh.polygon_count = usize::MAX, SEAMWRIGHT_TOO_LARGE, 0),
        ("not triangles", |c| c.mesh.polygon_start = null(), SEAMWRIGHT_BAD_POLYGONS, 8),
        ("a late start", |c| c.polygon_start[0] = 1, SEAMWRIGHT_BAD_POLYGONS, 0),
        ("a falling start", |c| c.polygon_start[3] = 30, SEAMWRIGHT_BAD_POLYGONS, 3),
        ("an early end", |c| c.mesh.polygon_count = 5, SEAMWRIGHT_BAD_POLYGONS, 5),
        ("a vertex beyond", |c| c.corners[5] = 8, SEAMWRIGHT_BAD_INDEX, 5),
        ("not a number", |c| c.positions[7] = f64::NAN, SEAMWRIGHT_NOT_FINITE, 2),
        ("no triangle", |c| c.corners.fill(3), SEAMWRIGHT_NO_TRIANGLE, 0),
        ("a bound", |c| c.options.distortion = f64::NAN, SEAMWRIGHT_BAD_DISTORTION, 0),
        ("padding", |c| c.options.padding = 257, SEAMWRIGHT_BAD_SIZE, 0),
        ("effort", |c| c.options.effort = 1001, SEAMWRIGHT_BAD_EFFORT, 0),
        ("a choice", |c| c.options.packing = 2, SEAMWRIGHT_BAD_CHOICE, 0),
        ("odd normals", |c| c.mesh.corner_normals = odd(), SEAMWRIGHT_MISALIGNED, 0),
        ("odd weights", |c| c.mesh.edge_weights = odd(), SEAMWRIGHT_MISALIGNED, 0),
        ("normals in outputs", |c| c.mesh.corner_normals = c.uv.as_ptr().cast(), SEAMWRIGHT_SHARED, 0),
        ("marks in outputs", |c| c.mesh.edge_marks = c.scratch.as_ptr(), SEAMWRIGHT_SHARED, 0),
        ("a mesh without size", |c| c.mesh.struct_size = 0, SEAMWRIGHT_BAD_STRUCT, size_of::<SeamwrightMesh>()),
        ("options without", |c| c.options.struct_size = 0, SEAMWRIGHT_BAD_STRUCT, size_of::<SeamwrightOptions>()),
        ("a host without", |c| c.host.struct_size = 0, SEAMWRIGHT_BAD_STRUCT, size_of::<SeamwrightHost>()),
    ];
    for (name, spoil, code, detail) in checks {
        let mut call = Call::cube();
        spoil(&mut call);
        assert_eq!((call.run(), call.report.detail), (code, detail), "{name}");
    }
    let mut call = Call::cube();
    let atlas = SeamwrightAtlas { exposure: null_mut(), ..call.atlas() };
    assert_eq!(call.run_into(&atlas), SEAMWRIGHT_NULL);
    let atlas = SeamwrightAtlas { struct_size: 0, ..call.atlas() };
    assert_eq!(call.run_into(&atlas), SEAMWRIGHT_BAD_STRUCT);
    let atlas = call.atlas();
    call.report = SeamwrightReport { struct_size: 0, detail: 77, ..SeamwrightReport::INIT };
    assert_eq!((call.run(), call.report.detail), (SEAMWRIGHT_BAD_STRUCT, 77));
    call.report.struct_size = size_of::<SeamwrightReport>();
    unsafe {
        let size = size_of::<SeamwrightOptions>();
        assert_eq!(seamwright_defaults(null_mut(), size), SEAMWRIGHT_NULL);
        assert_eq!(seamwright_defaults(&mut call.options, 0), SEAMWRIGHT_BAD_STRUCT);
        assert_eq!(seamwright_unwrap_scratch(null_mut(), &call.mesh, &call.options), SEAMWRIGHT_NULL);
        let (mesh, options) = (&raw const call.mesh, &raw const call.options);
        assert_eq!(seamwright_unwrap(&atlas, null_mut(), mesh, options, null(), null_mut(), 0), SEAMWRIGHT_NULL);
        assert_eq!(seamwright_unwrap(null(), &mut call.report, mesh, options, null(), null_mut(), 0), SEAMWRIGHT_NULL);
    }
}

#[test]
fn an_atlas_is_measured() {
    let mut call = Call::cube();
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    let (mut bytes, mut figures) = (0, SeamwrightFigures::INIT);
    let (uv, exposure) = (call.uv.as_ptr(), call.exposure.as_ptr());
    let mut measure = |mesh: &SeamwrightMesh, less: usize| unsafe {
        assert_eq!(seamwright_measure_scratch(&mut bytes, mesh, 256), SEAMWRIGHT_OK);
        let mut scratch = vec![0u8; bytes - less];
        let code = seamwright_measure(&mut figures, mesh, uv, exposure, 256, scratch.as_mut_ptr(), scratch.len());
        (code, figures)
    };
    let (code, found) = measure(&call.mesh, 0);
    assert_eq!(code, SEAMWRIGHT_OK);
    assert_eq!((found.chart_count, found.flipped_faces, found.overlapping_faces), (call.report.chart_count, 0, 0));
    assert!((found.symmetric_dirichlet / 4.0 - call.report.distortion).abs() < 1e-6, "{}", found.symmetric_dirichlet);
    // The seams of a cube are some of its 12 edges, where it turns by 90 degrees.
    assert_eq!((found.flat_seam_share, found.sharp_seam_share, found.closed_or_handled_charts), (0.0, 1.0, 0));
    assert!((found.sharp_seam_cover - found.seam_length * 6f64.sqrt() / 12.0).abs() < 1e-12);
    assert!((found.noticed_seam_length - 0.1 * found.visible_seam_length).abs() < 1e-12);
    assert_eq!(measure(&call.mesh, 1).0, SEAMWRIGHT_SCRATCH);
    call.corners[7] = 99;
    let (code, found) = measure(&call.mesh, 0);
    assert_eq!((code, found.detail), (SEAMWRIGHT_BAD_INDEX, 7));
}

#[test]
fn the_library_names_itself() {
    assert_eq!(seamwright_interface(), SEAMWRIGHT_INTERFACE);
    let version = unsafe { CStr::from_ptr(seamwright_version()) };
    assert_eq!(version.to_str(), Ok(env!("CARGO_PKG_VERSION")));
    let message = unsafe { CStr::from_ptr(seamwright_message(SEAMWRIGHT_NULL)) };
    assert!(!message.is_empty());
}
