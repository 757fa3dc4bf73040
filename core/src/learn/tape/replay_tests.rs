//! Replays: pruned branches, groups, repeated use of a value, exact small values, memory that is too small.
#![cfg(test)]

use super::distortion;
use super::operation::Replay;
use super::ops::Tape;
use super::var::Var;
use crate::base::scratch::Scratch;
use crate::base::workers::Serial;
use crate::learn::kernels::path::Path;
use std::{vec, vec::Vec};

struct Memory {
    values: Vec<f64>,
    gradients: Vec<f64>,
    indices: Vec<u32>,
    bytes: Vec<u8>,
}

impl Memory {
    fn of(tape: &Tape) -> Self {
        let gradients = vec![f64::NAN; tape.value_count()];
        let bytes = vec![0; tape.scratch_need::<f64>()];
        Self { values: vec![0.0; gradients.len()], gradients, indices: vec![0; tape.index_count()], bytes }
    }

    fn set(&mut self, var: Var, values: &[f64]) {
        var.of_mut(&mut self.values).copy_from_slice(values);
    }

    fn run(&mut self) -> Replay<'_, '_, f64> {
        Replay {
            values: &mut self.values,
            gradients: &mut self.gradients,
            indices: &mut self.indices,
            scratch: Scratch::new(&mut self.bytes),
            path: Path::Plain,
            workers: &Serial,
        }
    }
}

#[test]
fn gradients_of_a_value_that_is_used_twice_add_up() {
    let mut tape = Tape::new();
    let x = tape.parameter(1, 2);
    let twice = tape.add(x, x);
    let zero = tape.input(1, 2);
    let y = tape.mean_abs(twice, zero);
    let z = tape.mean_abs(x, zero);
    let mut memory = Memory::of(&tape);
    memory.set(x, &[3.0, -4.0]);
    let mut run = memory.run();
    tape.forward(&mut run, 1).unwrap();
    tape.backward(&mut run, &[(y, 1.0), (z, 10.0)], 1, &[x]).unwrap();
    assert_eq!((y.of(run.values), z.of(run.values), x.of(run.gradients)), (&[7.0][..], &[3.5][..], &[6.0, -6.0][..]));
}

#[test]
fn what_no_seed_depends_on_is_left_alone_and_parameters_there_get_zero() {
    let mut tape = Tape::new();
    let (a, b) = (tape.parameter(1, 1), tape.parameter(1, 1));
    let zero = tape.input(1, 1);
    let y = tape.mean_abs(a, zero);
    tape.set_group(2);
    let other = tape.mean_abs(b, zero);
    let mut memory = Memory::of(&tape);
    memory.set(a, &[2.0]);
    memory.set(b, &[5.0]);
    let mut run = memory.run();
    tape.forward(&mut run, 1).unwrap();
    assert_eq!(other.of(run.values), [0.0], "its group did not take part");
    tape.backward(&mut run, &[(y, 3.0), (other, 1.0)], 1, &[a, b]).unwrap();
    assert_eq!((a.of(run.gradients), b.of(run.gradients)), (&[3.0][..], &[0.0][..]));
    tape.forward(&mut run, 3).unwrap();
    tape.backward(&mut run, &[(other, 1.0)], 3, &[a, b]).unwrap();
    assert_eq!((a.of(run.gradients), b.of(run.gradients)), (&[0.0][..], &[1.0][..]));
}

#[test]
fn the_scale_is_signed_and_passes_no_gradient_and_an_isometry_costs_nothing() {
    let mut tape = Tape::new();
    let (x, faces, rest) = (tape.parameter(3, 2), tape.table(3), tape.input(1, distortion::REST));
    let scale = tape.scale(x, faces, rest);
    let (hinge, barrier) = (tape.hinge(x, faces, rest, scale, 0.5), tape.barrier(x, faces, rest, scale));
    let mut memory = Memory::of(&tape);
    memory.indices.copy_from_slice(&[0, 1, 2]);
    let mut inverse = distortion::rest_of([[0.0; 3], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]]);
    assert_eq!(inverse, [0.5, 0.0, 0.0, 0.5, 2.0]);
    inverse[4] = 1.0; // the only face has all of the area
    memory.set(rest, &inverse);
    memory.set(x, &[0.0, 0.0, 0.0, 1.0, 1.0, 0.0]); // half the size, turned over
    let mut run = memory.run();
    tape.forward(&mut run, 1).unwrap();
    let value = |var: Var, run: &Replay<f64>| var.of(run.values)[0];
    assert_eq!([scale, hinge, barrier].map(|var| value(var, &run)), [-0.25, 0.0, 0.0]);
    tape.backward(&mut run, &[(scale, 1.0)], 1, &[x]).unwrap();
    assert_eq!(x.of(run.gradients), [0.0; 6]);
}

#[test]
fn maps_without_extent_give_finite_values_and_gradients() {
    let mut tape = Tape::new();
    let x = tape.parameter(4, 2);
    let (ring, faces) = (tape.table(20), tape.table(3));
    let (rest, target, exposure) = (tape.input(1, distortion::REST), tape.input(1, 3), tape.input(4, 1));
    let q = tape.normalise(x);
    let reach = tape.reach(q, ring);
    let seam = tape.seam(reach, q);
    let scale = tape.scale(x, faces, rest);
    let ends = [
        tape.repel(q, 0.5),
        tape.angles(q, faces, target),
        tape.weighted_mean(seam, exposure),
        tape.hinge(x, faces, rest, scale, 0.5),
        tape.barrier(x, faces, rest, scale),
    ];
    let mut memory = Memory::of(&tape);
    memory.set(x, &[0.3; 8]);
    let mut run = memory.run();
    tape.forward(&mut run, 1).unwrap();
    tape.backward(&mut run, &ends.map(|end| (end, 1.0)), 1, &[x]).unwrap();
    assert!(ends.iter().all(|end| end.of(run.values)[0].is_finite()));
    assert_eq!(x.of(run.gradients), [0.0; 8]);
}

#[test]
fn one_byte_of_scratch_less_is_refused() {
    let mut tape = Tape::new();
    let x = tape.parameter(40, 2);
    tape.repel(x, 0.5);
    let mut memory = Memory::of(&tape);
    assert!(tape.forward(&mut memory.run(), 1).is_ok());
    memory.bytes.pop();
    assert!(tape.forward(&mut memory.run(), 1).is_err());
}
