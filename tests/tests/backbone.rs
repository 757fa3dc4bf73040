//! The four networks, their losses, gradients and two AdamW steps against reference values in float64.
//!
//! `fixtures/backbone/*.json` hold 12 significant digits of inputs and results, made by automatic differentiation elsewhere.
//! A value of size 1 is therefore known to 5e-13, and what a few layers make of rounded inputs to some 1e-11.

use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Serial;
use seamwright_core::learn::adamw;
use seamwright_core::learn::backbone::{NAMES, Widths};
use seamwright_core::learn::kernels::{Float, Path};
use seamwright_core::learn::losses::{Graph, Loss, LossWeights, PerLoss, Sizes};
use seamwright_core::learn::tape::{NONE, REST, Replay, SEAM_NEIGHBOURS, cosines, rest_of};
use serde_json::Value;
use std::collections::BTreeSet;

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

/// The five nearest of each vertex's ring, by distance and then index.
fn rings(positions: &[f64], faces: &[u32]) -> Vec<u32> {
    let count = positions.len() / 3;
    let mut ring = vec![BTreeSet::new(); count];
    for face in faces.chunks_exact(3) {
        for c in 0..3 {
            ring[face[c] as usize].extend([face[(c + 1) % 3], face[(c + 2) % 3]]);
        }
    }
    let mut out = Vec::new();
    for (i, ring) in ring.iter().enumerate() {
        let gap = |j: &u32| -> f64 { (0..3).map(|c| (positions[3 * i + c] - positions[3 * *j as usize + c]).powi(2)).sum() };
        let mut near: Vec<u32> = ring.iter().copied().collect();
        near.sort_by(|a, b| gap(a).total_cmp(&gap(b)).then(a.cmp(b)));
        near.resize(SEAM_NEIGHBOURS, NONE);
        out.extend(near);
    }
    out
}

struct Trained<T> {
    graph: Graph,
    values: Vec<T>,
    gradients: Vec<T>,
    indices: Vec<u32>,
    bytes: Vec<u8>,
    path: Path,
}

impl<T: Float> Trained<T> {
    fn new(data: &Value, path: Path) -> Self {
        let number = |name: &str| data[name].as_u64().expect("a count") as usize;
        let numbers = |name: &str| flat(&data[name]);
        let (positions, grid) = (numbers("positions"), numbers("grid"));
        let faces: Vec<u32> = numbers("faces").iter().map(|i| *i as u32).collect();
        let (points, side) = (positions.len() / 3, (grid.len() / 2).isqrt());
        let sizes = Sizes { points, further: 0, side, scored: points, faces: faces.len() / 3 };
        let widths = Widths { hidden: number("hidden"), code: number("code") };
        let radius = data["repel_radius"].as_f64().expect("a radius");
        let graph = Graph::record(widths, sizes, radius * (side - 1) as f64 / 2.0, 0.1);
        let mut values = vec![T::ZERO; graph.tape.value_count()];
        let mut indices = vec![0; graph.tape.index_count()];
        graph.fill_constants(&mut values);
        let mut set = |var: seamwright_core::learn::tape::Var, from: &[f64]| {
            var.of_mut(&mut values).iter_mut().zip(from).for_each(|(to, from)| *to = T::of(*from));
        };
        for (var, from) in graph.backbone.parameters().zip(parameters(&data["params"])) {
            set(var, &from);
        }
        set(graph.positions, &positions);
        set(graph.normals, &numbers("normals"));
        set(graph.exposure, &numbers("exposure"));
        let corner = |i: u32| core::array::from_fn(|c| positions[3 * i as usize + c]);
        let all = faces.chunks_exact(3);
        set(graph.cosines, &all.clone().flat_map(|f| cosines(&positions, [f[0], f[1], f[2]])).collect::<Vec<_>>());
        let rest: Vec<f64> = all.flat_map(|f| rest_of([corner(f[0]), corner(f[1]), corner(f[2])])).collect();
        assert_eq!(rest.len(), REST * faces.len() / 3);
        set(graph.rest, &rest);
        graph.ring.of_mut(&mut indices).copy_from_slice(&rings(&positions, &faces));
        graph.faces.of_mut(&mut indices).copy_from_slice(&faces);
        let bytes = vec![0; graph.tape.scratch_need::<T>()];
        Self { gradients: values.clone(), graph, values, indices, bytes, path }
    }

    fn replay(&mut self, work: impl FnOnce(&Graph, &mut Replay<T>)) {
        let mut run = Replay {
            values: &mut self.values,
            gradients: &mut self.gradients,
            indices: &mut self.indices,
            scratch: Scratch::new(&mut self.bytes),
            path: self.path,
            workers: &Serial,
        };
        work(&self.graph, &mut run);
    }

    fn forward(&mut self) -> PerLoss<f64> {
        self.replay(|graph, run| graph.tape.forward(run, u32::MAX).expect("enough scratch"));
        self.graph.values(&self.values)
    }

    /// The gradient of each parameter for the weighted losses.
    fn backward(&mut self, weights: &LossWeights) -> Vec<Vec<f64>> {
        let active = weights.active(0);
        self.replay(|graph, run| {
            let parameters: Vec<_> = graph.backbone.parameters().collect();
            graph.tape.backward(run, &graph.seeds(weights, active), active, &parameters).expect("enough scratch");
        });
        let of = |p: seamwright_core::learn::tape::Var| p.of(&self.gradients).iter().map(|g| g.wide()).collect();
        self.graph.backbone.parameters().map(of).collect()
    }
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
    NAMED.iter().fold(none, |weights, (name, loss)| weights.with(*loss, data["weights"][name].as_f64().expect("a weight")))
}

fn largest_gap(a: impl IntoIterator<Item = f64>, b: &[f64]) -> f64 {
    let a: Vec<f64> = a.into_iter().collect();
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Every forward value with the name of its reference, f64 for comparison.
fn forwards<T: Float>(run: &Trained<T>) -> Vec<(&'static str, Vec<f64>)> {
    let (g, v) = (&run.graph, &run.values);
    let wide = |x: &[T]| x.iter().map(|x| x.wide()).collect::<Vec<f64>>();
    let columns = |x: &[f64], from: usize| x.chunks_exact(6).flat_map(|r| r[from..from + 3].to_vec()).collect::<Vec<f64>>();
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
        let mut run = Trained::<f64>::new(&data, Path::Plain);
        let losses = run.forward();
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
        let mut run = Trained::<f64>::new(&data, Path::Plain);
        run.forward();
        let cases = NAMED.iter().map(|(name, loss)| (*name, only(*loss))).chain([("total", weighted(&data))]);
        for (name, weights) in cases {
            let own = run.backward(&weights);
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
