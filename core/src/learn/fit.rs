//! Training of a map on a cut surface, step by step, all nodes in every step.
//!
//! First the map comes to a given one, valid and of low distortion, in Jacobians and places ([`super::tape::gap`]): with either alone it
//! ends far off. Then it lowers its own distortion, the symmetric Dirichlet energy that goes on past folds
//! ([`super::tape::distortion`]), and is held near.
//! Guarantee: the same input and settings give the same bits for any [`Workers`], [`Path`] and machine.
//! Limits: memory is some 5 KB a node at width 64 (values and gradients of all layers).

use super::adamw;
use super::backbone::{Widths, initialise};
use super::chart_net::{ChartNet, LAYERS, map};
use super::kernels::path::Path;
use super::tape::distortion::REST;
use super::tape::gap::JACOBIAN;
use super::tape::operation::Replay;
use super::tape::ops::Tape;
use super::tape::var::{Table, Var};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;

/// Weight of the distance in places while the map comes to the given one, and while it lowers its distortion. Of Jacobians it is 1.
const PLACES: [f64; 2] = [10.0, 1.0];
/// Weight of the energy, whose least value is 4.
const ENERGY: f64 = 0.25;
/// Rate of the second stage over that of the first, and of each stage's last step over that of its first.
const SECOND: f64 = 0.05;
const LAST: f64 = 0.02;
/// Share of the steps that the second stage has.
const SHARE: usize = 5;
/// Steps between two copies of the weights, which are what is left where numbers stop being finite.
const KEEP: usize = 20;

/// The operations of the first stage alone, and of the second.
const TO_GIVEN: u32 = 1;
const TO_LOW: u32 = 2;

/// Number of terms of a [`FitSample`].
pub const TERMS: usize = 3;
/// Names of the terms, in their order.
pub const TERM_NAMES: [&str; TERMS] = ["jacobians", "places", "distortion"];

/// What is learned: a cut mesh with a map of it. Areas are shares of the whole.
#[derive(Clone, Copy)]
pub struct FitInput<'a> {
    /// Features of the nodes (nodes, features).
    pub features: &'a [f32],
    /// Nodes of the faces (faces, 3).
    pub faces: &'a [u32],
    /// Rest shapes (faces, 5), see [`super::tape::distortion::rest_of`]; zeros take a face out.
    pub rest: &'a [f32],
    /// Jacobians of the given map (faces, 4), row by row.
    pub jacobians: &'a [f32],
    /// UVs of the given map (nodes, 2).
    pub target: &'a [f32],
}

/// How it is learned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitSettings {
    /// Widths of the networks.
    pub widths: Widths,
    /// Steps for a small mesh; a fifth of them lowers the distortion.
    pub steps: usize,
    /// Rate of the first step.
    pub rate: f64,
    /// Seed of the weights.
    pub seed: u64,
}

impl FitSettings {
    /// Width 64.
    pub const STANDARD: Self = Self { widths: Widths { hidden: 64, code: 16 }, steps: 1600, rate: 4e-3, seed: 0 };
    /// A look at what a map would be: width 32.
    pub const DRAFT: Self = Self { widths: Widths { hidden: 32, code: 8 }, steps: 400, ..Self::STANDARD };

    /// The preset of that name: `draft` or `standard`.
    pub fn preset(name: &str) -> Option<Self> {
        match name {
            "draft" => Some(Self::DRAFT),
            "standard" => Some(Self::STANDARD),
            _ => None,
        }
    }
}

/// The terms of the objective at one step, unweighted; one that was not looked at has the value of its last look.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FitSample {
    /// Number of the step, from 0.
    pub step: usize,
    /// The terms, see [`TERM_NAMES`].
    pub terms: [f32; TERMS],
}

/// The networks with their objective on a tape.
struct FitGraph {
    tape: Tape,
    parameters: [[Var; 2]; LAYERS],
    features: Var,
    faces: Table,
    rest: Var,
    wanted: Var,
    target: Var,
    scale: Var,
    terms: [Var; TERMS],
}

impl FitGraph {
    fn record(net: ChartNet, nodes: usize, faces: usize) -> Self {
        let mut tape = Tape::new();
        let t = &mut tape;
        let parameters = net.record(t);
        let (features, faces_table) = (t.input(nodes, net.features), t.table(3 * faces));
        let (rest, wanted) = (t.input(faces, REST), t.input(faces, JACOBIAN));
        let (target, scale) = (t.input(nodes, 2), t.input(1, 1));
        t.set_group(TO_GIVEN | TO_LOW);
        let q = map(t, &parameters, features);
        let places = t.mean_square(q, target);
        t.set_group(TO_GIVEN);
        let jacobians = t.jacobian_gap(q, faces_table, rest, wanted);
        t.set_group(TO_LOW);
        let distortion = t.barrier(q, faces_table, rest, scale);
        let terms = [jacobians, places, distortion];
        Self { tape, parameters, features, faces: faces_table, rest, wanted, target, scale, terms }
    }
}

/// Bytes of scratch memory that a [`Fit`] takes.
pub fn fit_need(net: ChartNet, nodes: usize, faces: usize) -> usize {
    let graph = FitGraph::record(net, nodes, faces);
    bytes_for::<f32>(graph.tape.value_count())
        .saturating_mul(2)
        .saturating_add(bytes_for::<u32>(graph.tape.index_count()))
        .saturating_add(bytes_for::<f32>(net.parameter_count()).saturating_mul(3))
        .saturating_add(graph.tape.scratch_need::<f32>())
}

/// A training under way.
pub struct Fit<'a> {
    graph: FitGraph,
    settings: FitSettings,
    values: &'a mut [f32],
    gradients: &'a mut [f32],
    indices: &'a mut [u32],
    moments: &'a mut [f32], // (weights, 2)
    kept: &'a mut [f32],    // weights
    memory: Scratch<'a>,
    last: FitSample,
    steps: usize,
    is_over: bool,
}

impl<'a> Fit<'a> {
    /// Before the first step.
    pub fn new(
        net: ChartNet,
        input: &FitInput,
        settings: FitSettings,
        mut memory: Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let (nodes, faces) = (input.target.len() / 2, input.faces.len() / 3);
        memory.require(fit_need(net, nodes, faces))?;
        let graph = FitGraph::record(net, nodes, faces);
        let values = memory.take::<f32>(graph.tape.value_count())?;
        let gradients = memory.take::<f32>(graph.tape.value_count())?;
        let indices = memory.take::<u32>(graph.tape.index_count())?;
        let moments = memory.take::<f32>(2 * net.parameter_count())?;
        let kept = memory.take::<f32>(net.parameter_count())?;
        graph.scale.of_mut(values).fill(1.0);
        initialise(&mut values[..kept.len()], &net.layers(), settings.seed);
        kept.copy_from(&values[..kept.len()]);
        let last = FitSample::default();
        let is_over = settings.steps == 0 || nodes == 0;
        let mut run =
            Self { graph, settings, values, gradients, indices, moments, kept, memory, last, steps: 0, is_over };
        run.look_at(input);
        Ok(run)
    }

    /// From now on looks at other nodes and faces, as many as before.
    pub fn look_at(&mut self, input: &FitInput) {
        let (graph, values) = (&self.graph, &mut *self.values);
        for (var, from) in [
            (graph.features, input.features),
            (graph.rest, input.rest),
            (graph.wanted, input.jacobians),
            (graph.target, input.target),
        ] {
            var.of_mut(values).copy_from(from);
        }
        graph.faces.of_mut(self.indices).copy_from(input.faces);
    }

    /// The terms of the last step.
    pub fn last(&self) -> &FitSample {
        &self.last
    }

    /// Steps that were made.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// The weights as they are now.
    pub fn weights(&self) -> &[f32] {
        self.kept
    }

    /// Makes a step; false, with nothing done, once the run is over.
    pub fn step(&mut self, path: Path, workers: &dyn Workers) -> Result<bool, ScratchTooSmall> {
        if self.is_over {
            return Ok(false);
        }
        let (total, step) = (self.settings.steps, self.steps);
        let first = total - total / SHARE;
        let (group, seeds, rate) = if step < first {
            let [jacobians, places, _] = self.graph.terms;
            let rate = adamw::cosine_rate(1.0, LAST, step, first);
            (TO_GIVEN, [(jacobians, 1.0), (places, PLACES[0])], rate)
        } else {
            let [_, places, distortion] = self.graph.terms;
            let rate = adamw::cosine_rate(SECOND, SECOND * LAST, step - first, total - first);
            (TO_LOW, [(distortion, ENERGY), (places, PLACES[1])], rate)
        };
        let (values, gradients, indices) = (&mut *self.values, &mut *self.gradients, &mut *self.indices);
        let mut replay = Replay { values, gradients, indices, scratch: self.memory.frame(), path, workers };
        self.graph.tape.forward(&mut replay, group)?;
        self.graph.tape.backward(&mut replay, &seeds, group, self.graph.parameters.as_flattened())?;
        let value = |term: Var| term.of(&*self.values)[0];
        if !seeds.iter().all(|(term, _)| value(*term).is_finite()) {
            self.is_over = true;
            return Ok(false);
        }
        let looked_at = |term: &Var| seeds.iter().any(|(seed, _)| seed == term);
        for (to, term) in self.last.terms.iter_mut().zip(&self.graph.terms).filter(|(_, term)| looked_at(term)) {
            *to = term.of(&*self.values)[0];
        }
        self.last.step = step;
        let count = self.kept.len();
        let weights = &mut self.values[..count];
        // A gradient belongs to the weights before the step, so these are known to be sound.
        if step.is_multiple_of(KEEP) {
            self.kept.copy_from(weights);
        }
        // Gradients of the second stage have sizes of their own.
        let since = if step < first { step } else { step - first };
        if since == 0 {
            self.moments.fill(0.0);
        }
        let gradients = &self.gradients[..count];
        adamw::update(weights, self.moments, gradients, self.settings.rate * rate, since + 1, workers);
        self.steps = step + 1;
        if self.steps == total {
            self.is_over = true;
            if weights.iter().all(|w| w.is_finite()) {
                self.kept.copy_from(weights);
            }
        }
        Ok(true)
    }
}
