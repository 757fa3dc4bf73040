//! The C interface called as C calls it: the same atlas as core's own, and an error code for every kind of bad input.

use core::ffi::{CStr, c_char, c_void};
use glam::{DVec2, DVec3};
use seamwright_core::base::{progress::Silent, scratch::Scratch, workers::Serial};
use seamwright_core::pipeline::{Input, Output, Settings, unwrap, unwrap_need};
use seamwright_core::rays::binned::BinnedBuilder;
use seamwright_ffi::*;
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// A mesh with everything that a call needs.
struct Call {
    positions: Vec<f64>,
    corners: Vec<u32>,
    polygon_start: Vec<u32>,
    uv: Vec<f64>,
    chart: Vec<u32>,
    exposure: Vec<f32>,
    mesh: SeamwrightMesh,
    options: SeamwrightOptions,
    host: SeamwrightHost,
    report: SeamwrightReport,
    scratch: Vec<u8>,
}

impl Call {
    /// A cube of quads.
    fn cube() -> Self {
        let positions = (0..8u32).flat_map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
        let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
        Self::new(positions, corners, Some((0..=6).map(|p| 4 * p).collect()))
    }

    /// A tetrahedron, told as triangles.
    fn tetrahedron() -> Self {
        let positions = vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        Self::new(positions, vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3], None)
    }

    fn new(positions: Vec<f64>, corners: Vec<u32>, starts: Option<Vec<u32>>) -> Self {
        let polygon_start = starts.unwrap_or_default();
        let polygon_count = if polygon_start.is_empty() { corners.len() / 3 } else { polygon_start.len() - 1 };
        let mesh = SeamwrightMesh {
            positions: positions.as_ptr(),
            vertex_count: positions.len() / 3,
            corners: corners.as_ptr(),
            corner_count: corners.len(),
            polygon_start: if polygon_start.is_empty() { null() } else { polygon_start.as_ptr() },
            polygon_count,
            kept_uv: null(),
            parts: null(),
        };
        let mut options = SeamwrightOptions {
            distortion: 0.0,
            seed: 0,
            size: 0,
            padding: 0,
            rays: 0,
            charts: 0,
            packing: 0,
            effort: 0,
        };
        let mut bytes = 0;
        unsafe {
            assert_eq!(seamwright_defaults(&mut options), SEAMWRIGHT_OK);
            assert_eq!(seamwright_unwrap_scratch(&mut bytes, &mesh, &options), SEAMWRIGHT_OK);
        }
        Self {
            uv: vec![f64::NAN; 2 * corners.len()],
            chart: vec![9; polygon_count],
            exposure: vec![f32::NAN; positions.len() / 3],
            positions,
            corners,
            polygon_start,
            mesh,
            options,
            host: SeamwrightHost { user: null_mut(), progress: None, run: None },
            report: SeamwrightReport::default(),
            scratch: vec![0xa5; bytes],
        }
    }

    fn atlas(&mut self) -> SeamwrightAtlas {
        SeamwrightAtlas {
            corner_uv: self.uv.as_mut_ptr(),
            polygon_chart: self.chart.as_mut_ptr(),
            exposure: self.exposure.as_mut_ptr(),
        }
    }

    fn run(&mut self) -> i32 {
        let atlas = self.atlas();
        self.run_into(&atlas)
    }

    fn run_into(&mut self, atlas: &SeamwrightAtlas) -> i32 {
        let (scratch, bytes) = (self.scratch.as_mut_ptr(), self.scratch.len());
        unsafe { seamwright_unwrap(atlas, &mut self.report, &self.mesh, &self.options, &self.host, scratch, bytes) }
    }
}

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

fn bits(call: &Call) -> (Vec<u64>, Vec<u32>, Vec<u32>) {
    let uv = call.uv.iter().map(|x| x.to_bits()).collect();
    (uv, call.chart.clone(), call.exposure.iter().map(|e| e.to_bits()).collect())
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
    let (mut call, count) = (Call::cube(), AtomicUsize::new(0));
    let user = (&raw const count).cast_mut().cast();
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    let serial = bits(&call);
    call.host = SeamwrightHost { user, progress: None, run: Some(on_threads) };
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    assert_eq!(bits(&call), serial);
    assert!(count.swap(0, Ordering::Relaxed) > 0);
    call.host = SeamwrightHost { user, progress: Some(stop_at_packing), run: None };
    assert_eq!(call.run(), SEAMWRIGHT_CANCELLED);
    assert!(count.into_inner() > 2);
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

#[test]
fn bad_input_has_a_code_and_a_place() {
    type Check = (&'static str, fn(&mut Call), i32, usize);
    let checks: [Check; 18] = [
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
    ];
    for (name, spoil, code, detail) in checks {
        let mut call = Call::cube();
        spoil(&mut call);
        assert_eq!((call.run(), call.report.detail), (code, detail), "{name}");
    }
    let mut call = Call::cube();
    let atlas = SeamwrightAtlas { exposure: null_mut(), ..call.atlas() };
    assert_eq!(call.run_into(&atlas), SEAMWRIGHT_NULL);
    unsafe {
        assert_eq!(seamwright_defaults(null_mut()), SEAMWRIGHT_NULL);
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
    let (mut bytes, mut figures) = (0, SeamwrightFigures::default());
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
