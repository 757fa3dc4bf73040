//! Matrix products of every path on one thread, beside the `gemm` crate and fused multiply-adds that stay in registers.
//!
//! `cargo run --release --manifest-path tests/bench/products/Cargo.toml [PATH]` prints GFLOP/s of the thread's
//! time on the processor, the best of [`ROUNDS`] in which all take turns: what else runs on the machine falls on all alike. Shapes are those of the networks' layers:
//! X W^T forward, dY W to inputs, dY^T X to weights. By `unsafe`: the crate's pointers, instructions
//! found at run time, the C library's clock (Linux, 64 bits).

use seamwright_core::base::random::unit_f32;
use seamwright_core::base::workers::Serial;
use seamwright_core::learn::kernels::path::Path;
use seamwright_core::learn::kernels::product::{Finish, Shape, Start, product};
use seamwright_core::learn::kernels::task::Matrix;

#[repr(C)]
struct Time {
    seconds: i64,
    nanoseconds: i64,
}

unsafe extern "C" {
    fn clock_gettime(clock: i32, time: *mut Time) -> i32;
}

/// Seconds that this thread has had a processor.
fn seconds() -> f64 {
    const THREAD: i32 = 3;
    let mut time = Time { seconds: 0, nanoseconds: 0 };
    // SAFETY: the time is there to be written.
    assert_eq!(unsafe { clock_gettime(THREAD, &mut time) }, 0);
    time.seconds as f64 + 1e-9 * time.nanoseconds as f64
}

const SHAPES: [(usize, usize, usize); 5] =
    [(2048, 512, 512), (2048, 128, 128), (2048, 64, 64), (64, 64, 64), (512, 512, 2048)];
const ROUNDS: usize = 40;
/// Operations of one measurement.
const WORK: f64 = 1e8;

/// GFLOP/s of `work`, which does `flops` operations.
fn speed(flops: f64, repeats: usize, mut work: impl FnMut()) -> f64 {
    let start = seconds();
    (0..repeats).for_each(|_| work());
    flops * repeats as f64 / (seconds() - start) / 1e9
}

fn main() {
    let wanted = std::env::args().nth(1);
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        if wanted.as_ref().is_none_or(|name| format!("{path:?}").eq_ignore_ascii_case(name)) {
            SHAPES.iter().for_each(|shape| compare(path, *shape));
        }
    }
}

fn compare(path: Path, (rows, columns, depth): (usize, usize, usize)) {
    let shape = Shape { rows, columns, depth };
    let values = |n: usize, s| (0..n as u64).map(|i| unit_f32(1, s, i) - 0.5).collect::<Vec<f32>>();
    let (a, b) = (values(rows * depth, 1), values(depth * columns, 2));
    let (mut c, mut packed) = (vec![0.0f32; rows * columns], vec![0.0; shape.packed()]);
    let flops = 2.0 * (rows * columns * depth) as f64;
    let repeats = (WORK / flops).ceil() as usize;
    let (mut ours, mut theirs, mut peak) = ([0.0f64; 3], [0.0f64; 3], 0.0f64);
    for _ in 0..ROUNDS {
        // Whether A and B lie transposed.
        for (i, (at, bt)) in [(false, true), (false, false), (true, false)].into_iter().enumerate() {
            let x = if at { Matrix::new(&a, rows).transposed() } else { Matrix::new(&a, depth) };
            let y = if bt { Matrix::new(&b, depth).transposed() } else { Matrix::new(&b, columns) };
            ours[i] = ours[i].max(speed(flops, repeats, || {
                product(&mut c, shape, x, y, Start::Zero, Finish::Nothing, &mut packed, path, &Serial);
            }));
            let (a_row, a_column) = if at { (1, rows as isize) } else { (depth as isize, 1) };
            let (b_row, b_column) = if bt { (1, depth as isize) } else { (columns as isize, 1) };
            theirs[i] = theirs[i].max(speed(flops, repeats, || {
                // SAFETY: the strides are those of the slices.
                unsafe {
                    gemm::gemm(
                        rows,
                        columns,
                        depth,
                        c.as_mut_ptr(),
                        1,
                        columns as isize,
                        false,
                        a.as_ptr(),
                        a_column,
                        a_row,
                        b.as_ptr(),
                        b_column,
                        b_row,
                        0.0,
                        1.0,
                        false,
                        false,
                        false,
                        gemm::Parallelism::None,
                    );
                }
            }));
        }
        peak = peak.max(registers());
    }
    let row = |speeds: [f64; 3]| speeds.map(|s| format!("{s:6.1}")).join(" ");
    let share = |over: f64, of: [f64; 3]| of.map(|s| format!("{:.2}", s / over)).join(" ");
    let beside: Vec<String> = ours.iter().zip(theirs).map(|(a, b)| format!("{:.2}", a / b)).collect();
    println!(
        "{path:?} {rows}x{columns}x{depth}: ours {} | gemm {} | ours / gemm {} | ours / peak {} (peak {peak:.1})",
        row(ours),
        row(theirs),
        beside.join(" "),
        share(peak, ours)
    );
}

/// GFLOP/s of independent fused multiply-adds by AVX2 that never leave their registers, or 0 without.
fn registers() -> f64 {
    #[cfg(target_arch = "x86_64")]
    if Path::Avx2.is_available() {
        use std::arch::x86_64::{_mm256_fmadd_ps, _mm256_set1_ps};
        use std::hint::black_box;

        const SUMS: usize = 12;
        #[target_feature(enable = "avx2,fma")]
        fn sums(steps: usize) {
            let (x, y) = (_mm256_set1_ps(black_box(0.999)), _mm256_set1_ps(black_box(1e-3)));
            let mut sums = [_mm256_set1_ps(black_box(1.0)); SUMS];
            for _ in 0..steps {
                sums.iter_mut().for_each(|sum| *sum = _mm256_fmadd_ps(*sum, x, y));
            }
            black_box(sums);
        }
        let steps = 250_000;
        // SAFETY: the instructions are there, as just found.
        return speed((steps * SUMS * 16) as f64, 1, || unsafe { sums(black_box(steps)) });
    }
    0.0
}
