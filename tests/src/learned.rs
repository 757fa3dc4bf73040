//! A batch of all vertices on the learned map's tape, for references and benches.

use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Workers;
use seamwright_core::learn::backbone::Widths;
use seamwright_core::learn::kernels::float::Float;
use seamwright_core::learn::kernels::path::Path;
use seamwright_core::learn::losses::{LossGraph, LossWeights, PerLoss, Sizes, lattice_side};
use seamwright_core::learn::tape::angles::cosines;
use seamwright_core::learn::tape::distortion::{REST, rest_of};
use seamwright_core::learn::tape::operation::Replay;
use seamwright_core::learn::tape::seam::NEIGHBOURS as SEAM_NEIGHBOURS;
use seamwright_core::learn::tape::var::{NONE, Var};
use std::collections::BTreeSet;

/// A mesh in flat arrays.
pub struct Surface {
    /// (vertices, 3)
    pub positions: Vec<f64>,
    /// (vertices, 3)
    pub normals: Vec<f64>,
    /// (vertices)
    pub exposure: Vec<f64>,
    /// (faces, 3)
    pub faces: Vec<u32>,
}

/// A recorded graph with its memory.
pub struct Learned<T> {
    /// The losses.
    pub graph: LossGraph,
    /// Values of the tape.
    pub values: Vec<T>,
    /// Gradients of the tape.
    pub gradients: Vec<T>,
    indices: Vec<u32>,
    bytes: Vec<u8>,
    path: Path,
}

/// The five nearest of each vertex's ring by distance and then index, by sorting.
pub fn rings(positions: &[f64], faces: &[u32]) -> Vec<u32> {
    let mut ring = vec![BTreeSet::new(); positions.len() / 3];
    for face in faces.chunks_exact(3) {
        for c in 0..3 {
            ring[face[c] as usize].extend([face[(c + 1) % 3], face[(c + 2) % 3]]);
        }
    }
    let mut out = Vec::new();
    for (i, ring) in ring.iter().enumerate() {
        let gap =
            |j: &u32| -> f64 { (0..3).map(|c| (positions[3 * i + c] - positions[3 * *j as usize + c]).powi(2)).sum() };
        let mut near: Vec<u32> = ring.iter().copied().collect();
        near.sort_by(|a, b| gap(a).total_cmp(&gap(b)).then(a.cmp(b)));
        near.resize(SEAM_NEIGHBOURS, NONE);
        out.extend(near);
    }
    out
}

impl<T: Float> Learned<T> {
    /// All losses over all vertices; `spread` is the radius of repulsion in lattice steps.
    pub fn new(surface: &Surface, widths: Widths, spread: f64, path: Path) -> Self {
        let Surface { positions, normals, exposure, faces } = surface;
        let (points, face_count) = (exposure.len(), faces.len() / 3);
        let sizes = Sizes { points, further: 0, side: lattice_side(points), scored: points, faces: face_count };
        let graph = LossGraph::record(widths, sizes, spread, 0.1);
        let values = vec![T::ZERO; graph.tape.value_count()];
        let indices = vec![0; graph.tape.index_count()];
        let bytes = vec![0; graph.tape.scratch_need::<T>()];
        let mut learned = Self { gradients: values.clone(), graph, values, indices, bytes, path };
        learned.graph.fill_constants(&mut learned.values);
        let corner = |i: u32| core::array::from_fn(|c| positions[3 * i as usize + c]);
        let triangles = faces.chunks_exact(3).map(|f| [f[0], f[1], f[2]]);
        let angles: Vec<f64> = triangles.clone().flat_map(|face| cosines(positions, face)).collect();
        let mut rest: Vec<f64> = triangles.flat_map(|face| rest_of(face.map(corner))).collect();
        let area: f64 = rest.chunks_exact(REST).map(|rest| rest[4]).sum();
        rest.chunks_exact_mut(REST).for_each(|rest| rest[4] /= area);
        let graph = &learned.graph;
        let fills = [
            (graph.positions, positions),
            (graph.normals, normals),
            (graph.exposure, exposure),
            (graph.cosines, &angles),
            (graph.rest, &rest),
        ];
        let (ring, table) = (graph.ring, graph.faces);
        fills.into_iter().for_each(|(var, from)| learned.set(var, from));
        ring.of_mut(&mut learned.indices).copy_from_slice(&rings(positions, faces));
        table.of_mut(&mut learned.indices).copy_from_slice(faces);
        learned
    }

    /// Writes a value of the tape.
    pub fn set(&mut self, var: Var, from: &[f64]) {
        assert_eq!(var.count(), from.len());
        var.of_mut(&mut self.values).iter_mut().zip(from).for_each(|(to, from)| *to = T::of(*from));
    }

    fn replay(&mut self, workers: &dyn Workers, work: impl FnOnce(&LossGraph, &mut Replay<T>)) {
        let mut run = Replay {
            values: &mut self.values,
            gradients: &mut self.gradients,
            indices: &mut self.indices,
            scratch: Scratch::new(&mut self.bytes),
            path: self.path,
            workers,
        };
        work(&self.graph, &mut run);
    }

    /// The losses of the set `active`.
    pub fn forward(&mut self, active: u32, workers: &dyn Workers) -> PerLoss<f64> {
        self.replay(workers, |graph, run| graph.tape.forward(run, active).expect("enough scratch"));
        self.graph.values(&self.values)
    }

    /// Gradients of the weighted losses of the set `active`.
    pub fn backward(&mut self, weights: &LossWeights, active: u32, workers: &dyn Workers) {
        self.replay(workers, |graph, run| {
            let parameters = graph.backbone.parameters();
            graph
                .tape
                .backward(run, &graph.seeds(weights, active), active, parameters.as_flattened())
                .expect("enough scratch");
        });
    }
}
