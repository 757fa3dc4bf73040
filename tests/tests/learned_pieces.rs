//! Training several pieces: less memory trains fewer at a time, and changes no bit.

use glam::{DVec2, DVec3};
use seamwright::run::hierarchy::ObvhsBuilder;
use seamwright::run::threads::Pool;
use seamwright_core::base::progress::{Progress, Stage, Wish};
use seamwright_core::base::scratch::Scratch;
use seamwright_core::learn::backbone::Widths;
use seamwright_core::learn::training::{Sample, TrainSettings};
use seamwright_core::pipeline::learning::{LearnedSummary, Learning, MOST};
use seamwright_core::pipeline::published::published_need;
use seamwright_core::pipeline::{Input, Method, Output, Settings, unwrap_by, unwrap_need};

/// Vertices along a side of a sheet: 256 in all, more than the 200 from which on a piece is trained.
const SIDE: u32 = 16;
const SHEETS: u32 = 3;
const STEPS: usize = 8;

/// Counts reports of training: one after a step of all that go on at a time.
#[derive(Default)]
struct Rounds(usize);

impl Progress for Rounds {
    fn report(&mut self, stage: Stage, _: usize, _: usize) -> Wish {
        self.0 += usize::from(stage == Stage::Learn);
        Wish::GoOn
    }
}

/// UVs, weights and rounds of a run with memory for `lanes` pieces at a time.
fn run(lanes: usize, threads: usize) -> (Vec<DVec2>, Vec<f32>, usize) {
    let (mut positions, mut corners) = (Vec::new(), Vec::new());
    for sheet in 0..SHEETS {
        let first = positions.len() as u32;
        for i in 0..SIDE * SIDE {
            let (x, y) = (f64::from(i % SIDE), f64::from(i / SIDE));
            positions.push(DVec3::new(x, y, 0.05 * f64::from(sheet + 1) * x * y / 4.0 + 40.0 * f64::from(sheet)));
        }
        for i in (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE + 1 < SIDE) {
            corners.extend([i, i + 1, i + SIDE + 1, i + SIDE].map(|v| first + v));
        }
    }
    let polygon_start: Vec<u32> = (0..=corners.len() as u32 / 4).map(|k| 4 * k).collect();
    let input = Input::new(&positions, &corners, &polygon_start);
    let settings = Settings { rays: 16, ..Settings::default() };
    // Wide, so that a piece in training takes more than all the exact stages leave free.
    let trained = TrainSettings {
        widths: Widths { hidden: 256, code: 8 },
        steps: SHEETS as usize * STEPS,
        batch: 200,
        ..TrainSettings::PAPER
    };
    let (triangles, parameters) = (corners.len() / 2, trained.widths.parameter_count());
    let need =
        unwrap_need(&input, &settings, &ObvhsBuilder) + published_need(triangles, positions.len(), &trained, lanes);
    let (mut bytes, mut uv) = (vec![0; need], vec![DVec2::NAN; corners.len()]);
    let (mut chart, mut exposure) = (vec![0; corners.len() / 4], vec![0.0; positions.len()]);
    let mut weights = vec![0.0; MOST * parameters];
    let mut learning = Learning {
        settings: trained,
        weights: &mut weights,
        curve: &mut [Sample::default(); 4],
        summary: LearnedSummary::default(),
    };
    let output = Output { corner_uv: &mut uv, polygon_chart: &mut chart, exposure: &mut exposure };
    let mut rounds = Rounds::default();
    let pool = Pool::new(Some(threads)).expect("threads");
    let method = Method::Published(&mut learning);
    unwrap_by(method, output, &input, &settings, &ObvhsBuilder, Scratch::new(&mut bytes), &pool, &mut rounds)
        .expect("a need that is enough");
    assert_eq!((learning.summary.maps, learning.summary.steps), (SHEETS as usize, SHEETS as usize * STEPS));
    (uv, weights, rounds.0)
}

#[test]
fn less_memory_trains_fewer_at_a_time_with_the_same_bits() {
    let together = run(SHEETS as usize, 2);
    let alone = run(1, 2);
    assert!(together.0 == alone.0 && together.1 == alone.1);
    // Steps of a piece, and a last round that finds it over.
    assert_eq!((together.2, alone.2), (STEPS + 1, SHEETS as usize * (STEPS + 1)));
    let serial = run(SHEETS as usize, 1);
    assert!(together.0 == serial.0 && together.1 == serial.1);
}
