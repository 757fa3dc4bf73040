//! Cut and Unwrap on a cut surface: UVs of nodes, of which both sides of a seam have one each.
//!
//! A network of position cannot tear at a seam: what is near in space is near in UV. Here a point is a node of the cut mesh, and
//! its features say on which side it is. q = Unwrap(x + Cut(x)), x the features, Cut and Unwrap as published
//! ([`super::backbone`]) but for the width of what goes in.

use super::backbone::{Widths, parameter_count};
use super::kernels::path::Path;
use super::tape::affine::Activation;
use super::tape::operation::Replay;
use super::tape::ops::Tape;
use super::tape::var::Var;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;

/// Layers of both networks.
pub const LAYERS: usize = 9;
/// Nodes that are evaluated at a time.
const CHUNK: usize = 512;

/// Sizes of the networks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChartNet {
    /// Widths of hidden layers and of the code.
    pub widths: Widths,
    /// Features of a node.
    pub features: usize,
}

impl ChartNet {
    /// (inputs, outputs) of each layer: three that encode and three that decode the cut, three that unwrap.
    pub fn layers(self) -> [(usize, usize); LAYERS] {
        let (Widths { hidden: h, code: c }, d) = (self.widths, self.features);
        [(d, h), (h, h), (h, c), (c + d, h), (h, h), (h, d), (d, h), (h, h), (h, 2)]
    }

    /// Number of all weights and biases.
    pub fn parameter_count(self) -> usize {
        parameter_count(&self.layers())
    }

    /// Records the parameters, for each layer its weight (outputs, inputs) and then its bias; on an empty tape they are the first
    /// values.
    pub fn record(self, tape: &mut Tape) -> [[Var; 2]; LAYERS] {
        self.layers().map(|(inputs, outputs)| [tape.parameter(outputs, inputs), tape.parameter(1, outputs)])
    }

    /// Writes UVs `q` (nodes, 2) of `features` (nodes, features) by trained `weights`. Each node's UV depends on its features
    /// alone, to the bit.
    pub fn evaluate(
        self,
        q: &mut [f32],
        weights: &[f32],
        features: &[f32],
        path: Path,
        workers: &dyn Workers,
        scratch: &mut Scratch,
    ) -> Result<(), ScratchTooSmall> {
        let (tape, x, result) = self.chunk();
        let mut inner = scratch.frame();
        let values = inner.take::<f32>(tape.value_count())?;
        values[..weights.len()].copy_from(weights);
        let nodes = q.len() / 2;
        let mut first = 0;
        while first < nodes {
            let end = (first + CHUNK).min(nodes);
            let features = &features[first * self.features..end * self.features];
            x.of_mut(values)[..features.len()].copy_from(features);
            let scratch = inner.frame();
            tape.forward(&mut Replay { values, gradients: &mut [], indices: &mut [], scratch, path, workers }, 1)?;
            q[2 * first..2 * end].copy_from(&result.of(values)[..2 * (end - first)]);
            first = end;
        }
        Ok(())
    }

    /// Bytes that [`ChartNet::evaluate`] takes, for any number of nodes.
    pub fn evaluate_need(self) -> usize {
        let (tape, ..) = self.chunk();
        bytes_for::<f32>(tape.value_count()).saturating_add(tape.scratch_need::<f32>())
    }

    fn chunk(self) -> (Tape, Var, Var) {
        let mut tape = Tape::new();
        let layers = self.record(&mut tape);
        let x = tape.input(CHUNK, self.features);
        let q = map(&mut tape, &layers, x);
        (tape, x, q)
    }
}

/// UVs (n, 2) of features x (n, features).
pub fn map(tape: &mut Tape, layers: &[[Var; 2]; LAYERS], x: Var) -> Var {
    let [encode, decode, unwrap] = [0, 3, 6].map(|first| [layers[first], layers[first + 1], layers[first + 2]]);
    let code = mlp(tape, encode, x);
    let joined = tape.concat(x, code);
    let step = mlp(tape, decode, joined);
    let cut = tape.add(x, step);
    mlp(tape, unwrap, cut)
}

fn mlp(tape: &mut Tape, layers: [[Var; 2]; 3], x: Var) -> Var {
    let last = layers.len() - 1;
    layers.into_iter().enumerate().fold(x, |x, (k, [w, b])| {
        tape.affine(x, w, Some(b), if k == last { Activation::Linear } else { Activation::Leaky })
    })
}
