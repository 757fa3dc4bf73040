//! Every path against a plain triple loop, bit for bit, on whole and ragged shapes.
#![cfg(test)]

use super::path::Path;
use super::product::*;
use super::task::Matrix;
use crate::base::random::unit_f32;
use crate::base::workers::{Serial, Workers};
use std::{eprintln, thread, vec, vec::Vec};

const SHAPES: [(usize, usize, usize); 12] = [
    (1, 1, 1),
    (6, 16, 8),
    (7, 17, 3),
    (5, 2, 300),
    (13, 64, 2),
    (24, 65, 257),
    (49, 33, 512),
    (97, 130, 66),
    (3, 200, 0),
    (150, 6, 64),
    (512, 66, 530),
    (401, 128, 128),
];

fn values(stream: u64, count: usize) -> Vec<f32> {
    (0..count as u64).map(|i| unit_f32(3, stream, i) * 2.0 - 1.0).collect()
}

struct Threads;
impl Workers for Threads {
    fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        thread::scope(|scope| {
            for t in 0..3 {
                scope.spawn(move || (t..count).step_by(3).for_each(task));
            }
        });
    }
}

/// start + A B by three loops, with libm's fused multiply-add.
fn naive(c: &[f32], shape: Shape, a: Matrix<f32>, b: Matrix<f32>) -> Vec<u32> {
    let mut out = Vec::new();
    for i in 0..shape.rows {
        for j in 0..shape.columns {
            let term = |k: usize| (a.data[i * a.row + k * a.column], b.data[k * b.row + j * b.column]);
            let begin = c[i * shape.columns + j];
            out.push((0..shape.depth).map(term).fold(begin, |sum, (x, y)| libm::fmaf(x, y, sum)).to_bits());
        }
    }
    out
}

#[test]
fn every_path_gives_the_bits_of_three_loops_on_any_shape_and_layout() {
    for path in Path::ALL {
        if !path.is_available() {
            eprintln!("skipped: this machine has no {path:?}");
            continue;
        }
        for (rows, columns, depth) in SHAPES {
            let shape = Shape { rows, columns, depth };
            let (x, y) = (values(1, rows * depth), values(2, depth * columns));
            let begin = values(4, rows * columns);
            let (a, at) = (Matrix::new(&x, depth), Matrix::new(&x, rows).transposed());
            let (b, bt) = (Matrix::new(&y, columns), Matrix::new(&y, depth).transposed());
            // Forward, backward to inputs, backward to weights.
            for (a, b) in [(a, bt), (a, b), (at, b)] {
                for workers in [&Serial as &dyn Workers, &Threads] {
                    let (mut c, mut packed) = (begin.clone(), vec![f32::NAN; shape.packed()]);
                    product(&mut c, shape, a, b, Start::Sum, Finish::Nothing, &mut packed, path, workers);
                    let bits: Vec<u32> = c.iter().map(|x| x.to_bits()).collect();
                    assert_eq!(bits, naive(&begin, shape, a, b), "{path:?} {shape:?}");
                }
            }
        }
    }
}

#[test]
fn the_plain_path_is_always_there_and_the_best_one_is_available() {
    assert!(Path::Plain.is_available() && Path::best().is_available());
}

#[test]
fn bias_and_leaky_relu_are_applied_to_every_element() {
    let (rows, columns, depth) = (31, 19, 5);
    let shape = Shape { rows, columns, depth };
    let (x, w, bias) = (values(1, rows * depth), values(2, columns * depth), values(5, columns));
    let (a, b) = (Matrix::new(&x, depth), Matrix::new(&w, depth).transposed());
    let (mut c, mut packed) = (vec![9.0; rows * columns], vec![0.0; shape.packed()]);
    product(&mut c, shape, a, b, Start::Bias(&bias), Finish::Leaky, &mut packed, Path::best(), &Serial);
    let begin: Vec<f32> = (0..rows).flat_map(|_| bias.clone()).collect();
    let sums = naive(&begin, shape, a, b).into_iter().map(f32::from_bits);
    let expected: Vec<f32> = sums.map(|y| if y > 0.0 { y } else { 0.01 * y }).collect();
    assert_eq!(c, expected);
}

#[test]
fn a_mask_with_fewer_rows_is_repeated() {
    let shape = Shape { rows: 4, columns: 2, depth: 1 };
    let (mut c, mut packed) = ([0.0; 8], [0.0; 64]);
    let mask = [1.0, -1.0, 0.0, 2.0];
    let (a, b) = (Matrix::new(&[1.0, 2.0, 3.0, 4.0], 1), Matrix::new(&[10.0, 100.0], 2));
    product(&mut c, shape, a, b, Start::Zero, Finish::Masked(&mask), &mut packed, Path::Plain, &Serial);
    assert_eq!(c, [10.0, 1.0, 0.2, 200.0, 30.0, 3.0, 0.4, 400.0]);
}
