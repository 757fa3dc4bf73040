//! One small graph an operation, with values at which it is smooth: the table of finite differences.
#![cfg(test)]

use super::affine::Activation;
use super::distortion::{self, REST};
use super::ops::Tape;
use super::var::{NONE, Table, Var};
use std::boxed::Box;

/// Writes inputs and tables of a case.
pub(super) type Fill = Box<dyn Fn(&mut [f64], &mut [u32])>;

/// A graph that ends in `y`, the parameters to move, and how its inputs and tables are filled.
pub(super) struct Case {
    pub operation: &'static str,
    pub tape: Tape,
    pub parameters: std::vec::Vec<Var>,
    pub y: Var,
    pub fill: Fill,
}

fn case(
    operation: &'static str,
    shapes: &[(usize, usize)],
    record: impl FnOnce(&mut Tape, &[Var]) -> (Var, Fill),
) -> Case {
    let mut tape = Tape::new();
    let parameters: std::vec::Vec<Var> = shapes.iter().map(|(r, c)| tape.parameter(*r, *c)).collect();
    let (y, fill) = record(&mut tape, &parameters);
    Case { operation, tape, parameters, y, fill }
}

fn nothing() -> Fill {
    Box::new(|_, _| {})
}

fn indices(table: Table, values: &'static [u32]) -> Fill {
    Box::new(move |_, indices| table.of_mut(indices).copy_from_slice(values))
}

const FACES: [u32; 9] = [0, 1, 2, 2, 1, 3, 4, 0, 2];

/// Rest of three faces, and the faces.
fn rest(rest: Var, faces: Table) -> Fill {
    Box::new(move |values, indices| {
        faces.of_mut(indices).copy_from_slice(&FACES);
        let p = [[0.1, 0.2, 0.3], [1.0, 0.1, 0.2], [0.3, 0.9, 0.1], [1.2, 1.1, 0.6], [-0.5, 0.4, 0.9]];
        for (face, out) in FACES.chunks_exact(3).zip(rest.of_mut(values).chunks_exact_mut(REST)) {
            out.copy_from_slice(&distortion::rest_of([p[face[0] as usize], p[face[1] as usize], p[face[2] as usize]]));
        }
    })
}

/// The table: every operation at least once, every branch that has a derivative of its own.
pub(super) fn cases() -> std::vec::Vec<Case> {
    std::vec![
        case("Affine", &[(5, 3), (4, 3), (1, 4)], |t, p| {
            (t.affine(p[0], p[1], Some(p[2]), Activation::Linear), nothing())
        }),
        case("Affine", &[(5, 3), (4, 3), (1, 4)], |t, p| {
            (t.affine(p[0], p[1], Some(p[2]), Activation::Leaky), nothing())
        }),
        case("Affine", &[(6, 3), (4, 3)], |t, p| {
            // Two tangent columns of a layer on three points; the primal is an input, so its mask stands still.
            let primal = t.input(3, 4);
            let y = t.affine(p[0], p[1], None, Activation::SlopeOf(primal));
            (y, Box::new(move |values, _| (0..12).for_each(|i| primal.of_mut(values)[i] = (i % 3) as f64 - 1.0)))
        }),
        case("Affine", &[(4, 4), (4, 4)], |t, p| {
            // One weight in two layers: gradients of both uses add up.
            let hidden = t.affine(p[0], p[1], None, Activation::Leaky);
            (t.affine(hidden, p[1], None, Activation::Linear), nothing())
        }),
        case("Concat", &[(4, 2), (4, 3)], |t, p| (t.concat(p[0], p[1]), nothing())),
        case("Add", &[(4, 2), (4, 2)], |t, p| (t.add(p[0], p[1]), nothing())),
        case("Slice", &[(5, 4)], |t, p| (t.slice(p[0], (1, 2), (3, 2)), nothing())),
        case("Normalise", &[(7, 2)], |t, p| (t.normalise(p[0]), nothing())),
        case("Nearest", &[(9, 3)], |t, p| {
            let b = t.input(4, 3); // fewer than rows: the first mean is the larger
            let (y, _) = t.nearest(p[0], b);
            (y, Box::new(move |values, _| (0..12).for_each(|i| b.of_mut(values)[i] = (i * 5 % 7) as f64 * 0.1)))
        }),
        case("Nearest", &[(3, 3)], |t, p| {
            let b = t.input(9, 3); // far away on one side: the second mean is the larger
            let (y, _) = t.nearest(p[0], b);
            (y, Box::new(move |values, _| (0..27).for_each(|i| b.of_mut(values)[i] = (i * 5 % 13) as f64 * 0.3)))
        }),
        case("Cosine", &[(4, 3)], |t, p| {
            let (b, map) = (t.input(3, 3), t.table(4));
            let y = t.cosine(p[0], b, Some(map));
            let fill = move |values: &mut [f64], indices: &mut [u32]| {
                (0..9).for_each(|i| b.of_mut(values)[i] = (i * 5 % 7) as f64 - 2.5);
                map.of_mut(indices).copy_from_slice(&[2, 0, NONE, 0]);
            };
            (y, Box::new(fill))
        }),
        case("Repel", &[(14, 2)], |t, p| (t.repel(p[0], 1.1), nothing())),
        case("Repel", &[(3, 2)], |t, p| (t.repel(p[0], 5.0), nothing())),
        case("MeanAbs", &[(3, 2), (3, 2)], |t, p| (t.mean_abs(p[0], p[1]), nothing())),
        case("Eigenvalues", &[(6, 3)], |t, p| (t.eigenvalues(p[0]), nothing())),
        case("Angles", &[(5, 2)], |t, p| {
            let (faces, target) = (t.table(9), t.input(3, 3));
            (t.angles(p[0], faces, target), indices(faces, &FACES))
        }),
        case("Reach", &[(6, 2)], |t, p| {
            let ring = t.table(10);
            (t.reach(p[0], ring), indices(ring, &[1, 2, 3, 4, 5, 0, 2, NONE, NONE, NONE]))
        }),
        case("Seam", &[(5, 1)], |t, p| {
            let x = t.input(4, 2); // box of 9: threshold 0.9, among the values of the parameter
            (t.seam(p[0], x), Box::new(move |values, _| x.of_mut(values)[3] = 9.0))
        }),
        case("WeightedMean", &[(5, 1)], |t, p| {
            let w = t.input(5, 1);
            let y = t.weighted_mean(p[0], w);
            (y, Box::new(move |values, _| (0..5).for_each(|i| w.of_mut(values)[i] = i as f64)))
        }),
        case("Hinge", &[(5, 2)], |t, p| {
            let (faces, area, scale) = (t.table(9), t.input(3, REST), t.input(1, 1));
            let (y, fill) = (t.hinge(p[0], faces, area, scale, 0.7), rest(area, faces));
            let all = move |values: &mut [f64], indices: &mut [u32]| {
                fill(values, indices);
                scale.of_mut(values)[0] = -1.3;
            };
            (y, Box::new(all))
        }),
        case("Barrier", &[(5, 2)], |t, p| {
            let (faces, area, scale) = (t.table(9), t.input(3, REST), t.input(1, 1));
            let (y, fill) = (t.barrier(p[0], faces, area, scale), rest(area, faces));
            let all = move |values: &mut [f64], indices: &mut [u32]| {
                fill(values, indices);
                scale.of_mut(values)[0] = -1.3;
            };
            (y, Box::new(all))
        }),
        case("JacobianGap", &[(5, 2)], |t, p| {
            let (faces, area, wanted) = (t.table(9), t.input(3, REST), t.input(3, 4));
            let (y, fill) = (t.jacobian_gap(p[0], faces, area, wanted), rest(area, faces));
            let all = move |values: &mut [f64], indices: &mut [u32]| {
                fill(values, indices);
                (0..12).for_each(|i| wanted.of_mut(values)[i] = (i * 5 % 7) as f64 * 0.3 - 0.8);
            };
            (y, Box::new(all))
        }),
        case("MeanSquare", &[(3, 2)], |t, p| {
            let b = t.input(3, 2);
            let y = t.mean_square(p[0], b);
            (y, Box::new(move |values, _| (0..6).for_each(|i| b.of_mut(values)[i] = (i * 5 % 7) as f64 - 2.5)))
        }),
    ]
}
