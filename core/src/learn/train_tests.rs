//! Training as a whole: it learns, repeats itself to the bit, stops when asked, and refuses what it cannot learn.
#![cfg(test)]

use super::backbone::Widths;
use super::evaluate::{Frame, evaluate, evaluate_need};
use super::kernels::path::Path;
use super::losses::{Loss, LossWeights};
use super::run::train_need;
use super::train::train;
use super::training::{Sample, TrainError, TrainInput, TrainOutput, TrainSettings, TrainSummary, Unwatched, Watch};
use crate::base::scratch::Scratch;
use crate::base::workers::{Serial, Workers};
use core::ops::ControlFlow;
use std::{thread, vec, vec::Vec};

/// A bent square sheet of side x side vertices.
struct Sheet {
    positions: Vec<f32>,
    normals: Vec<f32>,
    faces: Vec<u32>,
    exposure: Vec<f32>,
}

fn sheet(side: usize) -> Sheet {
    let (mut positions, mut normals, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..side {
        for j in 0..side {
            let (x, y) = (i as f32 / (side - 1) as f32, j as f32 / (side - 1) as f32);
            positions.extend([3.0 * x, 3.0 * y, 0.6 * x * x]);
            let length = libm::sqrtf(1.0 + 0.16 * x * x);
            normals.extend([-0.4 * x / length, 0.0, 1.0 / length]);
            if i + 1 < side && j + 1 < side {
                let a = (i * side + j) as u32;
                let (b, c) = (a + 1, a + side as u32);
                faces.extend([a, c, c + 1, a, c + 1, b]);
            }
        }
    }
    let exposure = (0..side * side).map(|i| (i % 7) as f32 / 7.0).collect();
    Sheet { positions, normals, faces, exposure }
}

const SMALL: TrainSettings =
    TrainSettings { widths: Widths { hidden: 16, code: 4 }, steps: 300, batch: 0, ..TrainSettings::PAPER };

struct Result {
    q: Vec<f32>,
    scores: Vec<f32>,
    weights: Vec<f32>,
    curve: Vec<Sample>,
    summary: core::result::Result<TrainSummary, TrainError>,
}

fn run(
    sheet: &Sheet,
    settings: &TrainSettings,
    path: Path,
    workers: &dyn Workers,
    watch: &mut dyn Watch,
    less: usize,
) -> Result {
    let n = sheet.exposure.len();
    let mut bytes = vec![0; train_need(n, sheet.faces.len() / 3, settings) - less];
    let (mut q, mut scores) = (vec![-7.0; 2 * n], vec![-7.0; n]);
    let (mut weights, mut curve) = (vec![-7.0; settings.widths.parameter_count()], vec![Sample::default(); 10]);
    let output = TrainOutput { q: &mut q, scores: &mut scores, weights: &mut weights, curve: &mut curve };
    let input = TrainInput {
        positions: &sheet.positions,
        normals: &sheet.normals,
        faces: &sheet.faces,
        exposure: &sheet.exposure,
    };
    let summary = train(output, input, settings, path, workers, watch, &mut Scratch::new(&mut bytes));
    Result { q, scores, weights, curve, summary }
}

struct Threads;
impl Workers for Threads {
    fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        thread::scope(|scope| {
            for t in 0..3 {
                scope.spawn(move || (t..count).step_by(3).for_each(task));
            }
        });
    }
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|x| x.to_bits()).collect()
}

#[test]
fn losses_fall_and_the_curve_is_sampled_to_the_end() {
    let result = run(&sheet(12), &SMALL, Path::best(), &Serial, &mut Unwatched, 0);
    let summary = result.summary.unwrap();
    assert_eq!((summary.steps, summary.samples, summary.was_stopped), (300, 10, false));
    assert!(summary.best_step > 200, "{summary:?}");
    let loss = |i: usize, loss: Loss| result.curve[i].losses[loss as usize];
    // Wrap has 100 times the cycles' weight: it falls at once, the cycles follow.
    for (which, share) in [(Loss::Wrap, 0.3), (Loss::CyclePoints, 0.9), (Loss::CycleNormals, 0.9)] {
        assert!(loss(9, which) < share * loss(0, which), "{which:?}: {} {}", loss(0, which), loss(9, which));
    }
    assert!(result.q.iter().all(|x| x.is_finite()) && result.scores.iter().all(|s| (0.0..=1.0).contains(s)));
}

#[test]
fn paths_threads_and_repetition_do_not_change_a_bit_and_the_seed_does() {
    for batch in [0, 40] {
        let settings = TrainSettings { steps: 12, batch, weights: SMALL.weights.with(Loss::Fold, 0.01), ..SMALL };
        let sheet = sheet(9);
        let first = run(&sheet, &settings, Path::best(), &Serial, &mut Unwatched, 0);
        first.summary.unwrap();
        for (path, workers) in [(Path::Plain, &Serial as &dyn Workers), (Path::best(), &Threads)] {
            let again = run(&sheet, &settings, path, workers, &mut Unwatched, 0);
            assert_eq!(bits(&first.weights), bits(&again.weights), "batch {batch} {path:?}");
            assert_eq!((bits(&first.q), bits(&first.scores)), (bits(&again.q), bits(&again.scores)));
        }
        let other = run(&sheet, &TrainSettings { seed: 1, ..settings }, Path::best(), &Serial, &mut Unwatched, 0);
        assert_ne!(bits(&first.weights), bits(&other.weights));
    }
}

#[test]
fn a_watcher_that_breaks_gets_the_best_map_so_far() {
    struct Stop(usize);
    impl Watch for Stop {
        fn step(&mut self, sample: &Sample, _: usize) -> ControlFlow<()> {
            if sample.step == self.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    }
    let result = run(&sheet(9), &SMALL, Path::best(), &Serial, &mut Stop(45), 0);
    let summary = result.summary.unwrap();
    assert!(summary.was_stopped && summary.steps == 46 && summary.best_step == 40, "{summary:?}");
    assert!(result.q.iter().all(|x| x.is_finite() && *x != -7.0));
}

#[test]
fn evaluation_at_one_vertex_gives_the_bits_of_training_at_all() {
    let sheet = sheet(30); // more than one chunk
    let settings = TrainSettings { steps: 3, batch: 64, ..SMALL };
    let result = run(&sheet, &settings, Path::best(), &Serial, &mut Unwatched, 0);
    let frame = Frame::of(&sheet.positions);
    assert_eq!(result.summary.unwrap().frame, frame);
    let mut bytes = vec![0; evaluate_need(settings.widths)];
    for v in [0, 511, 512, 899] {
        let mut q = [0.0; 2];
        let at = &sheet.positions[3 * v..3 * v + 3];
        let scratch = &mut Scratch::new(&mut bytes);
        evaluate(&mut q, &result.weights, settings.widths, &frame, at, Path::Plain, &Serial, scratch).unwrap();
        assert_eq!(q, result.q[2 * v..2 * v + 2]);
    }
    bytes.pop();
    let scratch = &mut Scratch::new(&mut bytes);
    assert!(
        evaluate(&mut [0.0; 2], &result.weights, settings.widths, &frame, &[0.0; 3], Path::Plain, &Serial, scratch)
            .is_err()
    );
}

#[test]
fn one_byte_less_is_refused_and_no_output_touched() {
    let result = run(&sheet(9), &SMALL, Path::best(), &Serial, &mut Unwatched, 1);
    assert!(matches!(result.summary, Err(TrainError::Scratch(_))));
    assert!(result.q.iter().chain(&result.weights).chain(&result.scores).all(|x| *x == -7.0));
}

#[test]
fn what_cannot_be_learned_is_an_error_and_odd_meshes_are_not() {
    let fails = |change: &dyn Fn(&mut Sheet)| {
        let mut sheet = sheet(4);
        change(&mut sheet);
        run(&sheet, &TrainSettings { steps: 2, ..SMALL }, Path::Plain, &Serial, &mut Unwatched, 0).summary
    };
    assert_eq!(fails(&|s| s.faces[4] = 16), Err(TrainError::Corner { face: 1 }));
    assert_eq!(fails(&|s| s.positions[5] = f32::NAN), Err(TrainError::NotFinite { vertex: 1 }));
    assert!(matches!(fails(&|s| s.normals.truncate(9)), Err(TrainError::Length { what: "normals", .. })));
    assert_eq!(
        fails(&|s| *s = Sheet { positions: vec![], normals: vec![], faces: vec![], exposure: vec![] }),
        Err(TrainError::Empty)
    );
    assert!(fails(&|s| s.faces.clear()).is_ok(), "points without faces");
    assert!(fails(&|s| s.positions.fill(0.25)).is_ok(), "one place for all");
    assert!(fails(&|s| s.faces.copy_from_slice(&[3; 54])).is_ok(), "faces without area");
    assert!(
        fails(&|s| *s =
            Sheet { positions: vec![1.0; 3], normals: vec![0.0; 3], faces: vec![0, 0, 0], exposure: vec![1.0] })
        .is_ok()
    );
}

#[test]
fn a_loss_of_weight_zero_does_not_move_the_map() {
    let none = LossWeights([0.0; Loss::ALL.len()]);
    let settings = TrainSettings { steps: 5, weights: none.with(Loss::Wrap, 1.0), ..SMALL };
    let wrap = run(&sheet(6), &settings, Path::best(), &Serial, &mut Unwatched, 0);
    let mut still = sheet(6);
    still.exposure.fill(0.3); // looked at by the visibility loss alone
    let same = run(&still, &settings, Path::best(), &Serial, &mut Unwatched, 0);
    assert_eq!(bits(&wrap.weights), bits(&same.weights));
}
