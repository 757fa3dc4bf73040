//! The four networks, their losses, gradients and two AdamW steps against reference values in float64.
//!
//! `fixtures/backbone/*.json` hold 12 significant digits of inputs and results, made by automatic differentiation elsewhere.
//! A value of size 1 is therefore known to 5e-13, and what a few layers make of rounded inputs to some 1e-11.

use seamwright_core::base::workers::Serial;
use seamwright_core::learn::adamw;
use seamwright_core::learn::backbone::{NAMES, Widths};
use seamwright_core::learn::kernels::float::Float;
use seamwright_core::learn::kernels::path::Path;
use seamwright_core::learn::losses::{Loss, LossWeights, lattice_side};
use seamwright_core::learn::tape::var::Var;
use seamwright_tests::learned::{Learned, Surface};
use serde_json::Value;

const SIZES: [&str; 3] = ["tiny", "small", "medium"];

/// Names of the losses in the files.
const NAMED: [(&str, Loss); 7] = [
    ("wrap_chamfer", Loss::Wrap),
    ("repel", Loss::Repel),
    ("cycle_points", Loss::CyclePoints),
    ("cycle_normals", Loss::CycleNormals),
    ("differential", Loss::Differential),
    ("triangle", Loss::Triangle),
    ("visibility", Loss::Visibility),
];

/// All numbers of nested lists, in order.
fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(flat).collect(),
        Value::Null => Vec::new(),
        other => vec![other.as_f64().expect("a number")],
    }
}

fn reference(size: &str) -> Value {
    let path = format!("{}/../fixtures/backbone/{size}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).expect("a fixture")).expect("JSON")
}

/// The graph of a file with the file's weights and lattice.
fn learned<T: Float>(data: &Value, path: Path) -> Learned<T> {
    let number = |name: &str| data[name].as_u64().expect("a count") as usize;
    let numbers = |name: &str| flat(&data[name]);
    let surface = Surface {
        positions: numbers("positions"),
        normals: numbers("normals"),
        exposure: numbers("exposure"),
        faces: numbers("faces").iter().map(|i| *i as u32).collect(),
    };
    let widths = Widths { hidden: number("hidden"), code: number("code") };
    let side = lattice_side(surface.exposure.len());
    let radius = data["repel_radius"].as_f64().expect("a radius");
    let mut learned = Learned::new(&surface, widths, radius * (side - 1) as f64 / 2.0, path);
    let vars = learned.graph.backbone.parameters();
    let pairs = vars.as_flattened().iter().zip(parameters(&data["params"]));
    pairs.for_each(|(var, from)| learned.set(*var, &from));
    learned.set(learned.graph.grid, &numbers("grid"));
    learned
}

/// The gradient of each parameter for the weighted losses, after a forward run.
fn gradients<T: Float>(run: &mut Learned<T>, weights: &LossWeights) -> Vec<Vec<f64>> {
    run.backward(weights, weights.active(0), &Serial);
    let of = |p: &Var| p.of(&run.gradients).iter().map(|g| g.wide()).collect();
    run.graph.backbone.parameters().as_flattened().iter().map(of).collect()
}

/// Weights and biases by name, in our order.
fn parameters(by_name: &Value) -> Vec<Vec<f64>> {
    let names = NAMES.iter().flat_map(|name| [format!("{name}.weight"), format!("{name}.bias")]);
    names.map(|name| flat(by_name.get(&name).expect("every parameter"))).collect()
}

fn only(loss: Loss) -> LossWeights {
    LossWeights([0.0; Loss::ALL.len()]).with(loss, 1.0)
}

/// Weights of the files.
fn weighted(data: &Value) -> LossWeights {
    let none = LossWeights([0.0; Loss::ALL.len()]);
    NAMED
        .iter()
        .fold(none, |weights, (name, loss)| weights.with(*loss, data["weights"][name].as_f64().expect("a weight")))
}

fn largest_gap(a: impl IntoIterator<Item = f64>, b: &[f64]) -> f64 {
    let a: Vec<f64> = a.into_iter().collect();
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Every forward value with the name of its reference, f64 for comparison.
fn forwards<T: Float>(run: &Learned<T>) -> Vec<(&'static str, Vec<f64>)> {
    let (g, v) = (&run.graph, &run.values);
    let wide = |x: &[T]| x.iter().map(|x| x.wide()).collect::<Vec<f64>>();
    let columns =
        |x: &[f64], from: usize| x.chunks_exact(6).flat_map(|r| r[from..from + 3].to_vec()).collect::<Vec<f64>>();
    let (cycle, wrapped, tangents) = (wide(g.cycle.of(v)), wide(g.wrapped.of(v)), wide(g.tangents.of(v)));
    let (first, second) = tangents.split_at(tangents.len() / 2);
    vec![
        ("q", wide(g.q.of(v))),
        ("p_cycle", columns(&cycle, 0)),
        ("n_cycle", columns(&cycle, 3)),
        ("q_hat", wide(g.q_hat.of(v))),
        ("p_hat", columns(&wrapped, 0)),
        ("q_hat_cycle", wide(g.q_hat_cycle.of(v))),
        ("q_normalised", wide(g.q_normalised.of(v))),
        ("jacobian", first.iter().zip(second).flat_map(|(a, b)| [*a, *b]).collect()),
        ("eta", wide(g.reach.of(v))),
        ("seam", wide(g.scores.of(v))),
    ]
}

#[test]
fn every_forward_value_and_loss_agrees_to_1e_10() {
    for size in SIZES {
        let data = reference(size);
        let mut run = learned::<f64>(&data, Path::Plain);
        let losses = run.forward(u32::MAX, &Serial);
        for (name, values) in forwards(&run) {
            let gap = largest_gap(values, &flat(&data["forward"][name]));
            assert!(gap < 1e-10, "{size} {name}: {gap:e}");
        }
        for (name, loss) in NAMED {
            let expected = data["losses"][name].as_f64().expect("a loss");
            assert!((losses[loss as usize] - expected).abs() < 1e-10, "{size} {name}: {}", losses[loss as usize]);
        }
        let weights = weighted(&data);
        let total: f64 = losses.iter().zip(weights.0).map(|(loss, weight)| loss * weight).sum();
        assert!((total - data["losses"]["total"].as_f64().expect("a total")).abs() < 1e-10, "{size}");
    }
}

#[test]
fn the_gradient_of_every_loss_agrees_to_1e_8_relative_for_every_parameter() {
    for size in SIZES {
        let data = reference(size);
        let mut run = learned::<f64>(&data, Path::Plain);
        run.forward(u32::MAX, &Serial);
        let cases = NAMED.iter().map(|(name, loss)| (*name, only(*loss))).chain([("total", weighted(&data))]);
        for (name, weights) in cases {
            let own = gradients(&mut run, &weights);
            let expected = parameters(&data["gradients"][name]);
            // Relative to the parameter's largest entry, with a floor at 1e-4 of the loss's largest: entries that cancel
            // to nothing (a bias that the normalisation removes) have no relative accuracy in the reference either.
            let all = expected.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
            for (p, (own, expected)) in own.into_iter().zip(&expected).enumerate() {
                let zeros = vec![0.0; own.len()];
                let expected = if expected.is_empty() { &zeros } else { expected };
                let scale = expected.iter().fold(1e-4 * all, |m, x| m.max(x.abs()));
                let gap = largest_gap(own, expected) / scale;
                assert!(gap < 1e-8, "{size} {name} {} {}: {gap:e}", NAMES[p / 2], ["weight", "bias"][p % 2]);
            }
        }
    }
}

#[test]
fn two_adamw_steps_agree_to_1e_10() {
    for size in SIZES {
        let data = reference(size);
        let mut weights: Vec<f64> = parameters(&data["params"]).concat();
        let gradients = parameters(&data["gradients"]["total"]).concat();
        let mut moments = vec![0.0; 2 * weights.len()];
        for step in 1..=2 {
            adamw::update(&mut weights, &mut moments, &gradients, 1e-3, step, &Serial);
        }
        let gap = largest_gap(weights, &parameters(&data["after_two_adamw_steps_with_that_gradient"]).concat());
        assert!(gap < 1e-10, "{size}: {gap:e}");
    }
}

#[test]
fn single_precision_stays_within_its_rounding_on_every_path() {
    // A sum of k products errs by at most about k eps of the sum of their sizes (Higham); over a chain of 13 layers with
    // sums of at most 13 terms and gains near 1 that is 13 x 13 eps = 1e-5 of the largest value in the forward values.
    // Reach goes through differences of normalised points and a logarithm times 1/50: the same size. A score multiplies
    // the reach's error by beta/4 = 12.5, the Jacobian by products of 8 layers' gains. Gradients go through the chain twice
    // and carry scores' and hinges' slopes: 10 times as much, relative to the largest entry of the parameter's kind.
    for size in SIZES {
        let data = reference(size);
        let expected = parameters(&data["gradients"]["total"]);
        let all = expected.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        let mut bits: Option<Vec<u64>> = None;
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let mut run = learned::<f32>(&data, path);
            run.forward(u32::MAX, &Serial);
            for (name, values) in forwards(&run) {
                let bound = if name == "seam" { 1.3e-4 } else { 1e-5 };
                let gap = largest_gap(values, &flat(&data["forward"][name]));
                assert!(gap < bound, "{size} {name}: {gap:e}");
            }
            let own = gradients(&mut run, &weighted(&data)).concat();
            let gap = largest_gap(own.iter().copied(), &expected.concat()) / all;
            assert!(gap < 1e-4, "{size} {path:?}: {gap:e}");
            let own: Vec<u64> = own.iter().map(|x| x.to_bits()).collect();
            assert!(bits.as_ref().is_none_or(|bits| *bits == own), "{size} {path:?}: other bits");
            bits = Some(own);
        }
    }
}
