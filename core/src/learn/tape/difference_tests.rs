//! Every operation's backward against central differences of its forward, in f64.
//!
//! An output of several values is made one number by fixed weights. With h = 1e-6 a central difference errs by about
//! h^2 f'''/6 (1e-12 times the third derivative, up to 1e4 where smooth maxima and barriers bend) and eps f/h = 1e-10.
#![cfg(test)]

use super::case_tests::{Case, cases};
use super::operation::Replay;
use super::ops::{OPERATIONS, Op};
use crate::base::random::unit_f64;
use crate::base::scratch::Scratch;
use crate::base::workers::Serial;
use crate::learn::kernels::path::Path;
use std::{collections::BTreeSet, vec, vec::Vec};

const STEP: f64 = 1e-6;

struct Evaluated {
    sum: f64,
    gradients: Vec<f64>,
}

/// The weighted sum of `case`'s output and its gradient, with `values` in the parameters.
fn evaluate(case: &Case, values: &mut [f64]) -> Evaluated {
    let mut indices = vec![0; case.tape.index_count()];
    (case.fill)(values, &mut indices);
    let mut gradients = vec![f64::NAN; values.len()];
    let mut bytes = vec![0; case.tape.scratch_need::<f64>()];
    let scratch = Scratch::new(&mut bytes);
    let mut run = Replay {
        values,
        gradients: &mut gradients,
        indices: &mut indices,
        scratch,
        path: Path::Plain,
        workers: &Serial,
    };
    case.tape.forward(&mut run, 1).unwrap();
    let weight = |i: usize| 1.0 + 0.3 * (i * 7 % 5) as f64;
    let sum = case.y.of(run.values).iter().enumerate().map(|(i, y)| y * weight(i)).sum();
    // Seeds are single values; here the output's gradient is set whole, then backward runs from the last operation.
    let count = case.y.count();
    (0..count).for_each(|i| case.y.of_mut(run.gradients)[i] = weight(i));
    let first = case.y.of(run.gradients)[0];
    case.tape.backward(&mut run, &[(case.y, first)], 1, &case.parameters).unwrap();
    Evaluated { sum, gradients }
}

#[test]
fn backward_of_every_operation_agrees_with_central_differences() {
    for (number, case) in cases().iter().enumerate() {
        let mut values = vec![0.0; case.tape.value_count()];
        for (k, p) in case.parameters.iter().enumerate() {
            let stream = (number * 10 + k) as u64;
            p.of_mut(&mut values)
                .iter_mut()
                .enumerate()
                .for_each(|(i, x)| *x = unit_f64(5, stream, i as u64) * 2.0 - 0.9);
        }
        let at = evaluate(case, &mut values.clone());
        let mut moved = false;
        for i in case.parameters.iter().flat_map(|p| p.range()) {
            let beside = |by: f64| {
                let mut values = values.clone();
                values[i] += by;
                evaluate(case, &mut values).sum
            };
            let numeric = (beside(STEP) - beside(-STEP)) / (2.0 * STEP);
            let gap = (numeric - at.gradients[i]).abs();
            moved |= numeric != 0.0;
            assert!(gap < 2e-7 * (1.0 + numeric.abs()), "{} {i}: {} {numeric}", case.operation, at.gradients[i]);
        }
        assert!(moved, "{}: the case moves nothing", case.operation);
    }
}

#[test]
fn the_table_has_every_operation_that_passes_gradients() {
    let named: BTreeSet<&str> = cases().iter().map(|case| case.operation).collect();
    let recorded: BTreeSet<&str> =
        cases().iter().flat_map(|case| case.tape.operations().map(Op::name).collect::<Vec<_>>()).collect();
    assert_eq!(named, recorded, "a case contains the operation that it names and no other");
    // Scale is a measure: it passes no gradient, which its own test shows.
    let missing: Vec<&&str> = OPERATIONS.iter().filter(|name| !named.contains(**name) && **name != "Scale").collect();
    assert!(missing.is_empty(), "no finite differences for {missing:?}");
}
