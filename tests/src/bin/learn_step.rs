//! Times one training step of the learned map on an OBJ: every vertex, every published loss, AdamW.
//!
//! `learn_step [--width N] [--code N] [--threads N] [--steps N] [--path plain|avx2|avx512|neon] [--train PRESET] FILE.obj`
//! prints seconds a step, the best and the median of N after two that do not count, and the mean processor time of all
//! threads, which other programs on the machine disturb less. `--train` times a whole training by a preset instead, with its
//! losses. See tests/bench/learn_step.py for PyTorch, tests/bench/products for matrix products alone.

use seamwright::run::threads::Pool;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::learn::adamw;
use seamwright_core::learn::backbone::{Widths, initialise};
use seamwright_core::learn::kernels::path::Path;
use seamwright_core::learn::losses::{Loss, LossWeights};
use seamwright_core::learn::run::train_need;
use seamwright_core::learn::train::train;
use seamwright_core::learn::training::{Sample, TrainInput, TrainOutput, TrainSettings, Unwatched};
use seamwright_tests::learned::{Learned, Surface};
use seamwright_tests::load_obj;
use std::{env, error::Error, time::Instant};

fn main() -> Result<(), Box<dyn Error>> {
    let (mut width, mut code, mut threads, mut steps) = (512, 64, 2, 5);
    let (mut path, mut file, mut preset) = (Path::best(), None, None);
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
            "--train" => preset = Some(value()?),
            _ => file = Some(arg),
        }
    }
    let surface = surface(&file.ok_or("a mesh to train on is missing")?);
    let pool = Pool::new(Some(threads))?;
    if let Some(name) = preset {
        return time_training(&surface, &name, path, &pool);
    }
    let widths = Widths { hidden: width, code };
    let mut run = Learned::<f32>::new(&surface, widths, 0.25, path);
    let count = widths.parameter_count();
    initialise(&mut run.values[..count], &widths.layers(), 1);
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

/// Trains by a preset; prints the losses on the way, wall and processor seconds, and the share of seam vertices.
fn time_training(surface: &Surface, preset: &str, path: Path, pool: &Pool) -> Result<(), Box<dyn Error>> {
    let settings = (preset == "paper").then_some(TrainSettings::PAPER).ok_or("--train: paper")?;
    let narrow = |x: &[f64]| x.iter().map(|x| *x as f32).collect::<Vec<f32>>();
    let (positions, normals) = (narrow(&surface.positions), narrow(&surface.normals));
    let exposure = narrow(&surface.exposure);
    let count = exposure.len();
    let mut bytes = vec![0; train_need(count, surface.faces.len() / 3, &settings)];
    let (mut q, mut scores) = (vec![0.0; 2 * count], vec![0.0; count]);
    let (mut weights, mut curve) = (vec![0.0; settings.widths.parameter_count()], vec![Sample::default(); 5]);
    let output = TrainOutput { q: &mut q, scores: &mut scores, weights: &mut weights, curve: &mut curve };
    let input = TrainInput { positions: &positions, normals: &normals, faces: &surface.faces, exposure: &exposure };
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
