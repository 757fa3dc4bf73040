//! A program without std, heap and unwinding that unwraps a cube with core, in static memory.
//!
//! That it links is the proof that core needs neither: an `extern crate alloc` anywhere below would ask for an allocator,
//! an `extern crate std` would bring a second panic handler. `.ci/run` looks at its symbols too, and builds it once
//! with the feature `heap`, which allocates, to see the check fail. Exit code 0: an atlas with at least one chart.
//! The C library is linked for the process' start only. `unsafe` is here for C's `main` and `exit`.
#![no_std]
#![no_main]

#[cfg(feature = "heap")]
mod heap;

use core::cell::UnsafeCell;
use core::hint::black_box;
use core::panic::PanicInfo;
use glam::{DVec2, DVec3};
use seamwright_core::base::{progress::Silent, scratch::Scratch, workers::Serial};
use seamwright_core::pipeline::{Input, Output, Settings, unwrap};
use seamwright_core::rays::binned::BinnedBuilder;

#[link(name = "c")]
unsafe extern "C" {
    fn exit(code: i32) -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    // SAFETY: ends the process; nothing runs after it.
    unsafe { exit(70) }
}

/// What the toolchain's ready-made core names for unwinding. With panic = "abort" nothing ever calls it.
// SAFETY: no other symbol of the program has this name.
#[unsafe(no_mangle)]
pub extern "C" fn rust_eh_personality() {}

/// See [`rust_eh_personality`].
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn _Unwind_Resume() {}

/// Core's working memory: 16 MB that cost nothing in the file.
struct Memory(UnsafeCell<[u8; 1 << 24]>);
// SAFETY: the program has one thread.
unsafe impl Sync for Memory {}
static MEMORY: Memory = Memory(UnsafeCell::new([0; 1 << 24]));

const CORNERS: [u32; 24] = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
const POLYGONS: [u32; 7] = [0, 4, 8, 12, 16, 20, 24];

fn unwrap_cube() -> i32 {
    let mut positions = [DVec3::ZERO; 8];
    for (i, p) in positions.iter_mut().enumerate() {
        *p = DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
    }
    let input =
        Input { positions: &positions, corners: &CORNERS, polygon_start: &POLYGONS, kept_uv: None, parts: None };
    let (mut corner_uv, mut polygon_chart, mut exposure) = ([DVec2::ZERO; 24], [0; 6], [0.0; 8]);
    let output = Output { corner_uv: &mut corner_uv, polygon_chart: &mut polygon_chart, exposure: &mut exposure };
    // SAFETY: the only reference to the memory, taken once.
    let memory = unsafe { &mut *MEMORY.0.get() };
    let settings = black_box(Settings { rays: 64, ..Settings::default() });
    match unwrap(output, black_box(&input), &settings, &BinnedBuilder, Scratch::new(memory), &Serial, &mut Silent) {
        Ok(report) if report.chart_count > 0 => 0,
        Ok(_) => 1,
        Err(_) => 2,
    }
}

/// The process' start.
// SAFETY: `main` is C's name for it, and no other symbol has it.
#[unsafe(no_mangle)]
pub extern "C" fn main(_: i32, _: *const *const u8) -> i32 {
    #[cfg(feature = "heap")]
    heap::allocate();
    unwrap_cube()
}
