//! Times one training step of the learned map on an OBJ: every vertex, every published loss, AdamW.
//!
//! `learn_step [--width N] [--code N] [--threads N] [--steps N] [--path plain|avx2|avx512|neon] [--products] [--train PRESET] FILE.obj`
//! prints seconds a step, the best and the median of N after two that do not count, and the mean processor time of all
//! threads, which other programs on the machine disturb less. `--products` times matrix products and, as their bound, fused
//! multiply-adds that stay in registers (by `unsafe`: instructions found at run time)
//! instead, `--train` a whole training by a preset, with its losses. See tests/bench/learn_step.py for PyTorch.

use seamwright::threads::Pool;
use seamwright_core::base::random::unit_f32;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Serial;
use seamwright_core::learn::adamw;
use seamwright_core::learn::backbone::{Widths, initialise};
use seamwright_core::learn::kernels::{Finish, Matrix, Path, Shape, Start, product};
use seamwright_core::learn::losses::{Loss, LossWeights};
use seamwright_core::learn::train::{Input, Output, Sample, Settings, Unwatched, train, train_need};
use seamwright_tests::learned::{Learned, Surface};
use seamwright_tests::load_obj;
use std::{env, error::Error, time::Instant};

fn main() -> Result<(), Box<dyn Error>> {
    let (mut width, mut code, mut threads, mut steps) = (512, 64, 2, 5);
    let (mut path, mut file, mut products, mut preset) = (Path::best(), None, false, None);
    let mut args = env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or(format!("{arg} needs a value"));
        match arg.as_str() {
            "--width" => width = value()?.parse()?,
            "--code" => code = value()?.parse()?,
            "--threads" => threads = value()?.parse()?,
            "--steps" => steps = value()?.parse()?,
            "--path" => {
                path = match value()?.as_str() {
                    "plain" => Path::Plain,
                    "avx2" => Path::Avx2,
                    "avx512" => Path::Avx512,
                    "neon" => Path::Neon,
                    other => return Err(format!("--path {other}: plain, avx2, avx512 or neon").into()),
                }
            }
            "--products" => products = true,
            "--train" => preset = Some(value()?),
            _ => file = Some(arg),
        }
    }
    if products {
        time_products(path);
        return Ok(());
    }
    let surface = surface(&file.ok_or("a mesh to train on is missing")?);
    let pool = Pool::new(Some(threads))?;
    if let Some(name) = preset {
        return time_training(&surface, &name, path, &pool);
    }
    let widths = Widths { hidden: width, code };
    let mut run = Learned::<f32>::new(&surface, widths, 0.25, path);
    let count = widths.parameter_count();
    initialise(&mut run.values[..count], widths, 1);
    let mut moments = vec![0.0; 2 * count];
    let weights = LossWeights::PUBLISHED;
    let active = weights.active(0);
    let (mut times, mut cpu) = (Vec::new(), 0.0);
    for step in 1..=steps + 2 {
        if step == 3 {
            cpu = cpu_seconds();
        }
        let start = Instant::now();
        let losses = run.forward(active, &pool);
        let forward = start.elapsed().as_secs_f64();
        run.backward(&weights, active, &pool);
        let backward = start.elapsed().as_secs_f64() - forward;
        adamw::update(&mut run.values[..count], &mut moments, &run.gradients[..count], 1e-3, step, &pool);
        let total = start.elapsed().as_secs_f64();
        if env::var_os("VERBOSE").is_some() {
            let wrap = losses[Loss::Wrap as usize];
            eprintln!("wrap {wrap:.4} forward {forward:.4} backward {backward:.4} all {total:.4}");
        }
        times.push(total);
    }
    let mut times = times.split_off(2);
    times.sort_by(f64::total_cmp);
    println!("{:.4} {:.4} {:.4}", times[0], times[times.len() / 2], (cpu_seconds() - cpu) / times.len() as f64);
    Ok(())
}

/// Processor time of all threads so far, where the system tells it: in steps of 10 ms.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let ticks = stat.rsplit(')').next().unwrap_or("").split_whitespace().skip(11).take(2);
    ticks.filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn surface(file: &str) -> Surface {
    let (positions, faces) = load_obj(file);
    let mut normals = vec![glam::DVec3::ZERO; positions.len()];
    for f in &faces {
        let [a, b, c] = f.map(|i| positions[i as usize]);
        f.iter().for_each(|i| normals[*i as usize] += (b - a).cross(c - a));
    }
    // Half the loader's size: the unit box. Exposure does not matter to the time.
    Surface {
        exposure: (0..positions.len()).map(|i| (i % 10) as f64 / 10.0).collect(),
        positions: positions.iter().flat_map(|p| (*p * 0.5).to_array()).collect(),
        normals: normals.iter().flat_map(|n| n.normalize_or_zero().to_array()).collect(),
        faces: faces.concat(),
    }
}

/// GFLOP/s on one thread, best of several runs.
fn time_products(path: Path) {
    for (rows, columns, depth) in [(2048, 512, 512), (2048, 128, 128), (2048, 64, 64), (64, 64, 64), (512, 512, 2930)] {
        let shape = Shape { rows, columns, depth };
        let values = |n: usize, s| (0..n as u64).map(|i| unit_f32(1, s, i) - 0.5).collect::<Vec<f32>>();
        let (a, b) = (values(rows * depth, 1), values(depth * columns, 2));
        let (mut c, mut packed) = (vec![0.0; rows * columns], vec![0.0; shape.packed()]);
        let flops = 2.0 * (rows * columns * depth) as f64;
        let repeats = (2e9 / flops).clamp(3.0, 2000.0) as usize;
        let mut speed = [0.0f64; 3];
        for _ in 0..5 {
            let (x, y) = (Matrix::new(&a, depth), Matrix::new(&b, columns));
            let (xt, yt) = (Matrix::new(&a, rows).transposed(), Matrix::new(&b, depth).transposed());
            for (speed, (x, y)) in speed.iter_mut().zip([(x, yt), (x, y), (xt, y)]) {
                let start = Instant::now();
                for _ in 0..repeats {
                    product(&mut c, shape, x, y, Start::Zero, Finish::Nothing, &mut packed, path, &Serial);
                }
                *speed = speed.max(flops * repeats as f64 / start.elapsed().as_secs_f64() / 1e9);
            }
        }
        let [forward, inputs, weights] = speed;
        println!("{rows}x{columns}x{depth}: X W^T {forward:.1}, dY W {inputs:.1}, dY^T X {weights:.1} GFLOP/s");
    }
    #[cfg(target_arch = "x86_64")]
    if Path::Avx2.is_available() {
        println!(
            "fused multiply-adds of registers, AVX2: {:.1} GFLOP/s",
            (0..5).map(|_| registers()).fold(0.0, f64::max)
        );
    }
}

/// GFLOP/s of 12 independent sums of 8 lanes that never leave their registers: the bound of every product by AVX2.
#[cfg(target_arch = "x86_64")]
fn registers() -> f64 {
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
    let steps = 4_000_000;
    let start = Instant::now();
    // SAFETY: the caller has found the instructions.
    unsafe { sums(black_box(steps)) };
    (steps * SUMS * 16) as f64 / start.elapsed().as_secs_f64() / 1e9
}

/// Trains by a preset; prints the losses on the way, wall and processor seconds, and the share of seam vertices.
fn time_training(surface: &Surface, preset: &str, path: Path, pool: &Pool) -> Result<(), Box<dyn Error>> {
    let settings = Settings::preset(preset).ok_or("--train: draft, standard or paper")?;
    let narrow = |x: &[f64]| x.iter().map(|x| *x as f32).collect::<Vec<f32>>();
    let (positions, normals) = (narrow(&surface.positions), narrow(&surface.normals));
    let exposure = narrow(&surface.exposure);
    let count = exposure.len();
    let mut bytes = vec![0; train_need(count, surface.faces.len() / 3, &settings)];
    let (mut q, mut scores) = (vec![0.0; 2 * count], vec![0.0; count]);
    let (mut weights, mut curve) = (vec![0.0; settings.widths.parameter_count()], vec![Sample::default(); 5]);
    let output = Output { q: &mut q, scores: &mut scores, weights: &mut weights, curve: &mut curve };
    let input = Input {
        positions: &positions,
        normals: &normals,
        faces: &surface.faces,
        smooth: &surface.faces,
        target: &[],
        exposure: &exposure,
    };
    let start = (Instant::now(), cpu_seconds());
    let summary = train(output, input, &settings, path, pool, &mut Unwatched, &mut Scratch::new(&mut bytes))?;
    for sample in &curve {
        let losses = Loss::ALL.iter().map(|loss| format!("{} {:.4}", loss.name(), sample.losses[*loss as usize]));
        println!("step {}: {}", sample.step, losses.collect::<Vec<_>>().join(", "));
    }
    let seams = scores.iter().filter(|s| **s > 0.5).count();
    println!(
        "{preset}: {:.1} s, processor {:.1} s, best after {} of {} steps, {seams} of {count} vertices on seams, {} MB",
        start.0.elapsed().as_secs_f64(),
        cpu_seconds() - start.1,
        summary.best_step,
        summary.steps,
        bytes.len() >> 20
    );
    Ok(())
}
