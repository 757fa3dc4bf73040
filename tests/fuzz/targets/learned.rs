//! Parts by shape and by labels, training and the methods that learn, with tiny networks: an error, or labels and maps that
//! are whole and, of the hybrid method, a valid atlas.
#![no_main]

use glam::DVec2;
use libfuzzer_sys::fuzz_target;
use seamwright_core::base::progress::Silent;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Serial;
use seamwright_core::learn::backbone::Widths;
use seamwright_core::learn::fit::{FitSample, FitSettings};
use seamwright_core::learn::kernels::path::Path;
use seamwright_core::learn::losses::{Loss, LossWeights};
use seamwright_core::learn::run::train_need;
use seamwright_core::learn::train::train;
use seamwright_core::learn::training::{Sample, TrainError, TrainInput, TrainOutput, TrainSettings, Unwatched};
use seamwright_core::parts::settings::{Count, PartSettings};
use seamwright_core::pipeline::fitting::{FitSummary, Fitting, LearnedMap, MOST_CHARTS, net_of};
use seamwright_core::pipeline::learning::{LearnedSummary, Learning, MOST};
use seamwright_core::pipeline::neural::neural_need;
use seamwright_core::pipeline::polygons::{Parts, Source, parts_of_polygons, parts_of_polygons_need};
use seamwright_core::pipeline::published::published_need;
use seamwright_core::pipeline::{Method, Output, Packing, Settings, UnwrapError, unwrap_by, unwrap_need};
use seamwright_core::rays::binned::BinnedBuilder;
use seamwright_fuzz::bytes::Bytes;
use seamwright_fuzz::case::{Case, HOSTILE};
use seamwright_fuzz::check::{Made, valid};

/// Bytes of scratch beyond which a run is given up.
const MOST_BYTES: usize = 1 << 28;

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = Bytes(bytes);
    let what = bytes.byte();
    let settings = training(&mut bytes);
    let count = match bytes.byte() {
        n if n < 64 => Count::Auto,
        n if n < 128 => Count::Exactly(bytes.pick(&[1, 0, 2, 5, 100, u32::MAX])),
        n => Count::Published {
            clusters: bytes.pick(&[None, Some(3), Some(0), Some(16), Some(u32::MAX)]),
            lambda: if n < 240 { f64::from(n - 128) } else { HOSTILE[usize::from(n - 240)] },
        },
    };
    match what % 4 {
        0 => segmented(&Case::read(&mut bytes, usize::from(what & 0xf0 == 0xf0)), Some(count)),
        1 => segmented(&Case::read(&mut bytes, 0), None),
        2 => trained(&mut bytes, &settings),
        // Pieces are trained from 200 vertices on.
        _ => unwrapped(&Case::read(&mut bytes, 2), settings, what),
    }
});

fn training(bytes: &mut Bytes) -> TrainSettings {
    let preset = TrainSettings::PAPER;
    let is_wild = bytes.byte() >= 0xf0;
    let number = |bytes: &mut Bytes, sound: f64| if is_wild { HOSTILE[usize::from(bytes.byte()) & 15] } else { sound };
    let mut weights = preset.weights;
    let chosen = u16::from_le_bytes(bytes.array());
    for loss in Loss::ALL {
        if chosen >> loss as u32 & 1 == 1 {
            weights = LossWeights(weights.0).with(loss, number(bytes, 0.01));
        }
    }
    TrainSettings {
        widths: Widths { hidden: bytes.pick(&[2, 1, 3, 0, 9]), code: 1 + usize::from(is_wild) },
        steps: bytes.pick(&[2, 1, 6, 0, 22]),
        batch: bytes.pick(&[7, 0, 1, 2, 64]),
        weights,
        side: number(bytes, preset.side),
        spread: number(bytes, preset.spread),
        margin: number(bytes, preset.margin),
        rate: preset.rate.map(|rate| number(bytes, rate)),
        seed: 1,
    }
}

/// Parts by shape with `count`, or from the case's labels.
fn segmented(case: &Case, count: Option<Count>) {
    let polygons = case.polygon_start.len() - 1;
    let (mut part, mut diameter) = (vec![0x7777; polygons], vec![f32::NAN; polygons]);
    let input = seamwright_core::pipeline::Input { kept_uv: None, parts: None, ..case.input() };
    let source = match count {
        Some(count) => Source::Shape(PartSettings { count, seed: 7 }),
        None => Source::Labels(case.parts.as_deref().unwrap_or(&[])),
    };
    let mut memory = vec![0xa5; parts_of_polygons_need(&input, &BinnedBuilder).min(MOST_BYTES)];
    let out = Parts { part: &mut part, diameter: &mut diameter };
    let scratch = Scratch::new(&mut memory);
    match parts_of_polygons(out, &input, source, &BinnedBuilder, scratch, &Serial, &mut Silent) {
        Ok(count) => {
            assert!(part.iter().all(|p| (*p as usize) < count), "a part that is none of {count}");
            assert!(
                diameter.iter().all(|d| *d >= 0.0 && d.is_finite()),
                "a diameter that is none: {diameter:?}\n{}",
                case.obj()
            );
        }
        Err(UnwrapError::BadTree | UnwrapError::Scratch(_)) => panic!("refused"),
        Err(_) => {}
    }
}

/// A training on arrays of any numbers, some of them with wrong lengths.
fn trained(bytes: &mut Bytes, settings: &TrainSettings) {
    let (misfit, is_wild) = (bytes.byte(), bytes.byte() >= 0xc0);
    let case = Case::read(bytes, 0);
    let n = case.positions.len();
    let mut positions: Vec<f32> = case.positions.iter().flat_map(|p| p.as_vec3().to_array()).collect();
    if !is_wild {
        positions.iter_mut().for_each(|x| *x = if x.is_finite() { x.clamp(-1e30, 1e30) } else { 0.0 });
    }
    let mut normals: Vec<f32> = positions.iter().map(|x| if is_wild { *x } else { x.clamp(-1.0, 1.0) }).collect();
    let mut faces: Vec<u32> = case.corners[..case.corners.len() / 3 * 3].to_vec();
    let mut exposure = vec![0.5f32; n];
    let (mut q, mut scores) = (vec![f32::NAN; 2 * n], vec![f32::NAN; n]);
    let mut weights = vec![f32::NAN; settings.widths.parameter_count()];
    let mut curve = vec![Sample { step: 0, losses: [0.0; Loss::ALL.len()] }; usize::from(misfit >> 6)];
    match misfit & 0x3f {
        1 => drop(positions.pop()),
        2 => drop(normals.pop()),
        3 => drop(faces.pop()),
        6 => drop(exposure.pop()),
        7 => drop(q.pop()),
        8 => drop(scores.pop()),
        9 => drop(weights.pop()),
        11 => faces.extend([0, 1, u32::MAX]),
        _ => {}
    }
    let (positions, normals, faces) = (&positions, &normals, &faces);
    let input = TrainInput { positions, normals, faces, exposure: &exposure };
    let output = TrainOutput { q: &mut q, scores: &mut scores, weights: &mut weights, curve: &mut curve };
    let need = train_need(exposure.len(), faces.len() / 3, settings);
    if need < MOST_BYTES {
        let mut memory = vec![0xa5; need];
        let result =
            train(output, input, settings, Path::best(), &Serial, &mut Unwatched, &mut Scratch::new(&mut memory));
        assert!(!matches!(result, Err(TrainError::Scratch(_))), "train_need is too little");
    }
}

/// The methods that learn, on a mesh of some hundred faces.
fn unwrapped(case: &Case, settings: TrainSettings, what: u8) {
    let mut made = Made::room(case);
    let is_published = what & 4 != 0;
    let fit =
        FitSettings { widths: Widths { hidden: 3, code: 2 }, steps: usize::from(what >> 5), ..FitSettings::DRAFT };
    let how = Settings { rays: 2, packing: Packing::Grid, ..Settings::default() };
    let triangles = case.corners.len() / 3;
    let learned = match is_published {
        true => published_need(triangles, case.positions.len(), &settings, 1),
        false => neural_need(triangles, &fit),
    };
    let need = unwrap_need(&case.input(), &how, &BinnedBuilder).saturating_add(learned);
    if need >= MOST_BYTES {
        return;
    }
    let mut memory = vec![0xa5; need];
    let output =
        Output { corner_uv: &mut made.corner_uv, polygon_chart: &mut made.polygon_chart, exposure: &mut made.exposure };
    let scratch = Scratch::new(&mut memory);
    let go = |by: Method| unwrap_by(by, output, &case.input(), &how, &BinnedBuilder, scratch, &Serial, &mut Silent);
    let result = if is_published {
        let mut weights = vec![0.25; MOST * settings.widths.parameter_count()];
        let mut curve = vec![Sample { step: 0, losses: [0.0; Loss::ALL.len()] }; 3];
        let summary = LearnedSummary::default();
        go(Method::Published(&mut Learning { settings, weights: &mut weights, curve: &mut curve, summary }))
    } else {
        let mut weights = vec![0.25; net_of(&fit, MOST_CHARTS).parameter_count()];
        let (mut cut, mut corrected) = (vec![what & 1; 3 * triangles], vec![DVec2::NAN; 3 * triangles]);
        let map = LearnedMap { weights: &mut weights, cut: &mut cut, corrected: &mut corrected };
        let mut curve = vec![FitSample::default(); 3];
        let (is_given, summary) = (what & 8 != 0, FitSummary::default());
        go(Method::Neural(&mut Fitting { settings: fit, map, is_given, curve: &mut curve, summary }))
    };
    match result {
        Ok(report) if !is_published && what & 8 == 0 => valid(case, &made, &report, how.weld),
        Err(UnwrapError::BadTree) => panic!("no atlas"),
        Err(UnwrapError::Overlap { .. }) if what & 12 == 0 => panic!("no atlas"),
        _ => {}
    }
}
