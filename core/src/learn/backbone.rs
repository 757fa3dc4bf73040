//! The four networks: Deform, Wrap, Cut and Unwrap, as layers on a tape.
//!
//! Two cycles share the weights. 2D-3D-2D: a lattice G of the square -> Deform -> Qhat -> Wrap -> Phat, Nhat -> Cut, Unwrap
//! -> Qhat_cycle. 3D-2D-3D: points P -> Cut, Unwrap -> Q -> Wrap -> P_cycle, N_cycle. Q is the parameterization.
//! LeakyReLU follows every layer but an MLP's last; a code is put behind what it encodes, [input; code].
//! Source: Zhang, Hou, *FlexPara: Flexible neural surface parameterization*, 2025 and *Flatten Anything*, NeurIPS 2024.

use super::kernels::float::Float;
use super::tape::affine::Activation;
use super::tape::ops::Tape;
use super::tape::var::Var;
use crate::base::random::unit_f64;
use crate::base::real::sqrt;
use crate::base::slices::take_first;

/// Layers of all four networks.
pub const LAYERS: usize = 25;

/// Each MLP's first layer and number of layers, in the order of the parameters.
const DEFORM: [(usize, usize); 2] = [(0, 4), (4, 4)];
const WRAP: [(usize, usize); 2] = [(8, 4), (12, 4)];
const CUT: [(usize, usize); 2] = [(16, 3), (19, 3)];
const UNWRAP: (usize, usize) = (22, 3);

/// Names of the layers; their parameters are `NAME.weight` and `NAME.bias`.
#[rustfmt::skip]
pub const NAMES: [&str; LAYERS] = [
    "deform.encode.0", "deform.encode.1", "deform.encode.2", "deform.encode.3",
    "deform.decode.0", "deform.decode.1", "deform.decode.2", "deform.decode.3",
    "wrap.encode.0", "wrap.encode.1", "wrap.encode.2", "wrap.encode.3",
    "wrap.decode.0", "wrap.decode.1", "wrap.decode.2", "wrap.decode.3",
    "cut.encode.0", "cut.encode.1", "cut.encode.2", "cut.decode.0", "cut.decode.1", "cut.decode.2",
    "unwrap.0", "unwrap.1", "unwrap.2",
];

/// Widths of the networks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Widths {
    /// Of a hidden layer.
    pub hidden: usize,
    /// Of a code.
    pub code: usize,
}

impl Widths {
    /// (inputs, outputs) of each layer.
    pub fn layers(self) -> [(usize, usize); LAYERS] {
        let Widths { hidden: h, code: c } = self;
        #[rustfmt::skip]
        let layers = [
            (2, h), (h, h), (h, h), (h, c), (c + 2, h), (h, h), (h, h), (h, 2), // Deform
            (2, h), (h, h), (h, h), (h, c), (c + 2, h), (h, h), (h, h), (h, 6), // Wrap
            (3, h), (h, h), (h, c), (c + 3, h), (h, h), (h, 3), // Cut
            (3, h), (h, h), (h, 2), // Unwrap
        ];
        layers
    }

    /// Number of all weights and biases: the length of a trained map.
    pub fn parameter_count(self) -> usize {
        parameter_count(&self.layers())
    }
}

/// Number of weights and biases of `layers` (inputs, outputs).
pub fn parameter_count(layers: &[(usize, usize)]) -> usize {
    let sizes = layers.iter().map(|(inputs, outputs)| (inputs.saturating_add(1)).saturating_mul(*outputs));
    sizes.fold(0, usize::saturating_add)
}

/// Fills weights and biases of `layers` (inputs, outputs) uniformly in +-1/sqrt(inputs), from the seed.
pub fn initialise<T: Float>(weights: &mut [T], layers: &[(usize, usize)], seed: u64) {
    let mut rest = weights;
    for (layer, (inputs, outputs)) in layers.iter().copied().enumerate() {
        let count = ((inputs + 1) * outputs).min(rest.len());
        let now = take_first(&mut rest, count);
        let bound = 1.0 / sqrt(inputs.max(1) as f64);
        for (i, w) in now.iter_mut().enumerate() {
            *w = T::of((unit_f64(seed, layer as u64, i as u64) * 2.0 - 1.0) * bound);
        }
    }
}

/// The parameters on a tape: for each layer its weight (outputs, inputs) and then its bias.
pub struct Backbone {
    layers: [(Var, Var); LAYERS],
}

/// What Wrap gives.
#[derive(Clone, Copy)]
pub struct Wrapped {
    /// Point and normal (n, 6).
    pub output: Var,
    hidden: [Var; 6],
}

impl Backbone {
    /// Records the parameters; on an empty tape they are the first values.
    pub fn record(tape: &mut Tape, widths: Widths) -> Self {
        let layers = widths.layers();
        Self { layers: layers.map(|(inputs, outputs)| (tape.parameter(outputs, inputs), tape.parameter(1, outputs))) }
    }

    /// Weight and bias of every layer, in the order of [`NAMES`].
    pub fn parameters(&self) -> [[Var; 2]; LAYERS] {
        self.layers.map(|(w, b)| [w, b])
    }

    /// An MLP; `hidden` gets the outputs of all layers but the last.
    fn mlp(&self, tape: &mut Tape, (first, count): (usize, usize), x: Var, hidden: &mut [Var]) -> Var {
        let mut x = x;
        for k in 0..count {
            let (w, b) = self.layers[first + k];
            let is_last = k + 1 == count;
            x = tape.affine(x, w, Some(b), if is_last { Activation::Linear } else { Activation::Leaky });
            if let Some(slot) = hidden.get_mut(k).filter(|_| !is_last) {
                *slot = x;
            }
        }
        x
    }

    /// decode([x; encode(x)]).
    fn coded(&self, tape: &mut Tape, [encode, decode]: [(usize, usize); 2], x: Var, hidden: &mut [Var]) -> Var {
        let middle = hidden.len() / 2;
        let code = self.mlp(tape, encode, x, &mut hidden[..middle]);
        let joined = tape.concat(x, code);
        self.mlp(tape, decode, joined, &mut hidden[middle..])
    }

    /// Qhat (n, 2) of lattice points (n, 2).
    pub fn deform(&self, tape: &mut Tape, grid: Var) -> Var {
        let step = self.coded(tape, DEFORM, grid, &mut []);
        tape.add(grid, step)
    }

    /// Point and normal of UVs (n, 2).
    pub fn wrap(&self, tape: &mut Tape, q: Var) -> Wrapped {
        let mut hidden = [q; 6];
        let output = self.coded(tape, WRAP, q, &mut hidden);
        Wrapped { output, hidden }
    }

    /// The two columns of d point / d q where Wrap was taken, one under the other (2n, 3); `units` (2n, 2) holds n times
    /// (1, 0), then n times (0, 1). Forward tangents, recorded like any other layer, so gradients flow back through them.
    pub fn wrap_tangents(&self, tape: &mut Tape, wrapped: Wrapped, units: Var) -> Var {
        let mut x = units;
        for (half, (first, count)) in WRAP.into_iter().enumerate() {
            if half == 1 {
                x = tape.concat(units, x);
            }
            for k in 0..count {
                let slope = wrapped.hidden.get(half * 3 + k).filter(|_| k + 1 < count);
                let activation = slope.map_or(Activation::Linear, |primal| Activation::SlopeOf(*primal));
                x = tape.affine(x, self.layers[first + k].0, None, activation);
            }
        }
        tape.slice(x, (0, 0), (x.rows, 3))
    }

    /// UVs (n, 2) of points (n, 3): Cut, then Unwrap.
    pub fn unwrap(&self, tape: &mut Tape, points: Var) -> Var {
        let step = self.coded(tape, CUT, points, &mut []);
        let cut = tape.add(points, step);
        self.mlp(tape, UNWRAP, cut, &mut [])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    #[test]
    fn the_paper_width_has_the_published_layers() {
        let layers = Widths { hidden: 512, code: 64 }.layers();
        assert_eq!((layers[0], layers[3], layers[4], layers[7]), ((2, 512), (512, 64), (66, 512), (512, 2)));
        assert_eq!((layers[15], layers[16], layers[19], layers[24]), ((512, 6), (3, 512), (67, 512), (512, 2)));
    }

    #[test]
    fn weights_depend_on_the_seed_and_stay_inside_the_bound_of_their_layer() {
        let widths = Widths { hidden: 16, code: 4 };
        let fill = |seed| {
            let mut weights = vec![0.0f32; widths.parameter_count()];
            initialise(&mut weights, &widths.layers(), seed);
            weights
        };
        let (a, b) = (fill(1), fill(2));
        assert!(a != b && a == fill(1) && a.iter().all(|w| *w != 0.0));
        let first = &a[..3 * 16];
        assert!(first.iter().all(|w| w * w <= 0.500001) && first.iter().any(|w| w.abs() > 0.5), "1/sqrt(2)");
        assert!(a[3 * 16..3 * 16 + 17 * 16].iter().all(|w| w.abs() <= 0.25), "1/sqrt(16)");
    }
}
