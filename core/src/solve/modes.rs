//! The slowest waves of a sheet whose border is free: the lowest Neumann eigenfunctions of its Laplacian, without the constant.
//!
//! L x = lambda M x with springs along the edges whose stiffness is the mean of the cotangents across (Pinkall, Polthier 1993), angles
//! kept from being extreme, and a third of each triangle's area at its nodes. Block inverse iteration with a last Rayleigh-Ritz
//! step (Bathe, *The subspace iteration method*, 1971; Golub, Van Loan): the lowest converge first, the last of a block are mixtures of
//! their neighbours, smooth as well.
//! Cost: [`ROUNDS`] x [`BLOCK`] / 2 solves with one factor. The bits are the same for any [`Workers`].

use super::flatten::{cotangent, edge_springs};
use super::piece::{Piece, Spring};
use super::sparse::front_matrix::FrontMatrix;
use super::symmetric::diagonalise;
use super::system::{System, add_spring, graph_need};
use crate::base::random::unit_f64;
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use glam::DVec2;

/// Modes of a sheet.
pub const MODES: usize = 32;
/// Vectors that are iterated: the last of them converge slowly.
const BLOCK: usize = MODES + 8;
/// Rounds of inverse iteration.
const ROUNDS: usize = 6;
/// Added to the Laplacian in units of mass over the sheet's area: the lowest eigenvalue of a round sheet is some ten times that.
const SHIFT: f64 = 1.0;
/// Least and most cotangent of an angle: obtuse ones are taken for right, so that no stiffness is negative.
const COTANGENT: [f64; 2] = [1e-3, 20.0];
/// Length of a vector, over what it had before others were taken out of it, below which nothing is left of it.
const DEPENDENT: f64 = 1e-9;

/// Bytes of scratch memory that [`modes`] takes for a sheet as it occurs.
pub fn modes_need(nodes: usize, triangles: usize, relax_need: usize) -> usize {
    bytes_for::<f64>(nodes)
        .saturating_mul(2 * BLOCK + 4)
        .saturating_add(bytes_for::<Spring>(3 * triangles))
        .saturating_add(bytes_for::<f64>(2 * BLOCK * BLOCK))
        .saturating_add(relax_need)
}

/// Writes the modes of `piece`, whose nodes are all free, in the order of their eigenvalues: (nodes, [`MODES`]), each column with a
/// largest absolute value of 1, or zeros where the sheet has no more.
pub fn modes(
    out: &mut [f32],
    piece: &Piece,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let n = piece.free;
    out.fill(0.0);
    let mass = scratch.take::<f64>(n)?;
    for (t, rest) in piece.triangles.iter().zip(piece.rest) {
        t.iter().for_each(|i| mass[*i as usize] += rest.area / 3.0);
    }
    let area: f64 = mass.iter().sum();
    if n < 2 || !(area > 0.0 && area.is_finite()) {
        return Ok(());
    }
    // Nodes of faces without area weigh next to nothing, but not nothing.
    mass.iter_mut().for_each(|m| *m = m.max(1e-12 * area));
    let at = |i: u32| piece.at[i as usize];
    // Half a cotangent a side of the edge, and a spring's energy counts twice.
    let weight =
        |t: [u32; 3], [i, j, k]: [usize; 3]| 0.25 * cotangent(at(t[i]) - at(t[k]), at(t[j]) - at(t[k]), COTANGENT);
    let springs = edge_springs(piece, &mut scratch, weight)?;
    let count = BLOCK.min(n - 1);
    let block = scratch.take::<f64>(count * n)?; // a vector after the other
    for (k, x) in block.rows_mut(n).enumerate() {
        x.iter_mut().enumerate().for_each(|(i, x)| *x = unit_f64(1, k as u64, i as u64) - 0.5);
    }
    let sheet = Sheet { piece, springs, mass, shift: SHIFT / area, area };
    sheet.iterate(block, count, scratch.frame(), workers)?;
    sheet.separate(out, block, count, scratch)
}

/// A sheet with its matrices.
struct Sheet<'s> {
    piece: &'s Piece<'s>,
    springs: &'s [Spring],
    mass: &'s [f64], // (n)
    shift: f64,
    area: f64,
}

impl Sheet<'_> {
    /// Brings `block` to the space of the lowest modes.
    fn iterate(
        &self,
        block: &mut [f64],
        count: usize,
        mut scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<(), ScratchTooSmall> {
        let Self { piece, springs, mass, shift, .. } = *self;
        let n = mass.len();
        let held = Piece { triangles: &[], rest: &[], springs, walls: &[], ..*piece };
        let temporary = scratch.split(graph_need(&held))?;
        let mut system = System::new(&held, &mut scratch, temporary)?;
        let (x, right) = (scratch.take::<DVec2>(n)?, scratch.take::<DVec2>(n)?);
        self.orthonormalise(block, count);
        let mut is_factored = false;
        for _ in 0..ROUNDS {
            for k in (0..count).filter(|k| k % 2 == 0) {
                let pair = &mut block[k * n..(k + 2).min(count) * n];
                let (first, second) = pair.parted_mut(n);
                for (i, right) in right.iter_mut().enumerate() {
                    *right = DVec2::new(first[i], second.get(i).copied().unwrap_or(0.0)) * mass[i];
                }
                let again = if is_factored { system.solve_again(x, right, scratch.frame(), workers)? } else { None };
                if again.is_none() {
                    let spring = |s: usize, matrix: &mut FrontMatrix| add_spring(matrix, springs[s], n);
                    let node = |i: u32, matrix: &mut FrontMatrix| {
                        let held = shift * mass[i as usize];
                        matrix.add(i, i, [held, 0.0, 0.0, held]);
                        matrix.add_vector(i, right[i as usize]);
                    };
                    system.solve(x, |_, _| {}, spring, node, scratch.frame(), workers)?;
                    is_factored = true;
                }
                first.iter_mut().zip(x.iter()).for_each(|(to, x)| *to = x.x);
                second.iter_mut().zip(x.iter()).for_each(|(to, x)| *to = x.y);
            }
            self.orthonormalise(block, count);
        }
        Ok(())
    }

    /// Makes the vectors orthonormal in the mass, and orthogonal to the constant; what depends on others becomes zero.
    fn orthonormalise(&self, block: &mut [f64], count: usize) {
        let n = self.mass.len();
        for k in 0..count {
            let (before, rest) = block.parted_mut(k * n);
            let x = &mut rest[..n];
            let length = sqrt(self.dot(x, x));
            let mean = x.iter().zip(self.mass).map(|(x, m)| x * m).sum::<f64>() / self.area;
            x.iter_mut().for_each(|x| *x -= mean);
            for y in before.rows(n) {
                let share = self.dot(x, y);
                x.iter_mut().zip(y).for_each(|(x, y)| *x -= share * y);
            }
            let left = sqrt(self.dot(x, x));
            let scale = if left > DEPENDENT * length { 1.0 / left } else { 0.0 };
            x.iter_mut().for_each(|x| *x *= scale);
        }
    }

    fn dot(&self, x: &[f64], y: &[f64]) -> f64 {
        x.iter().zip(y).zip(self.mass).map(|((x, y), m)| x * y * m).sum()
    }

    /// Writes the modes that the space of `block` holds.
    fn separate(
        &self,
        out: &mut [f32],
        block: &[f64],
        count: usize,
        mut scratch: Scratch,
    ) -> Result<(), ScratchTooSmall> {
        let n = self.mass.len();
        let image = scratch.take::<f64>(n)?;
        let matrix = scratch.take::<f64>(count * count)?;
        let vectors = scratch.take::<f64>(count * count)?;
        for (k, x) in block.rows(n).enumerate() {
            image.fill(0.0);
            for Spring { a, b, weight } in self.springs {
                let (a, b) = (*a as usize, *b as usize);
                let pull = 2.0 * weight * (x[a] - x[b]);
                image[a] += pull;
                image[b] -= pull;
            }
            for (l, y) in block.rows(n).enumerate().take(k + 1) {
                let entry: f64 = image.iter().zip(y).map(|(x, y)| x * y).sum();
                (matrix[k * count + l], matrix[l * count + k]) = (entry, entry);
            }
        }
        // Where there is no vector there is no mode: behind all others.
        let top = (0..count).map(|k| matrix[k * count + k]).fold(0.0, f64::max);
        for (k, x) in block.rows(n).enumerate() {
            if x.iter().all(|x| *x == 0.0) {
                matrix[k * count + k] = 2.0 * top;
            }
        }
        diagonalise(matrix, vectors, count);
        let value = |k: usize| matrix[k * count + k];
        let mut last = (f64::NEG_INFINITY, 0);
        for mode in 0..MODES.min(count) {
            // The next in the order of eigenvalues, ties by place.
            let behind = |k: &usize| (value(*k), *k) > last || mode == 0;
            let Some(k) = (0..count).filter(behind).min_by(|a, b| value(*a).total_cmp(&value(*b))) else { break };
            last = (value(k), k);
            let row = &vectors[k * count..(k + 1) * count];
            image.fill(0.0);
            for (share, x) in row.iter().zip(block.rows(n)) {
                image.iter_mut().zip(x).for_each(|(sum, x)| *sum += share * x);
            }
            let most = image.iter().fold(0.0f64, |most, x| most.max(x.abs()));
            let scale = if most > 0.0 && most.is_finite() { 1.0 / most } else { 0.0 };
            let rows = out.as_chunks_mut::<MODES>().0.iter_mut();
            rows.zip(image.iter()).for_each(|(row, x)| row[mode] = (x * scale) as f32);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::workers::Serial;
    use crate::solve::energy::{MOLLIFY, Rest};
    use glam::DVec3;
    use std::{vec, vec::Vec};

    /// Modes of a flat rectangle of `sides` squares, each cut in two, whose longer side is 1.
    fn of_rectangle(sides: [usize; 2]) -> (Vec<DVec3>, Vec<f32>) {
        let row = sides[0] + 1;
        let scale = 1.0 / sides[0] as f64;
        let at: Vec<DVec3> = (0..row * (sides[1] + 1))
            .map(|i| DVec3::new((i % row) as f64 * scale, (i / row) as f64 * scale, 0.0))
            .collect();
        let mut triangles = Vec::new();
        for i in (0..row * sides[1]).filter(|i| i % row < sides[0]) {
            let [a, b, c, d] = [i, i + 1, i + row + 1, i + row].map(|i| i as u32);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let rest: Vec<Rest> = triangles.iter().map(|t| Rest::new(t.map(|i| at[i as usize]), MOLLIFY)).collect();
        let piece = Piece { triangles: &triangles, rest: &rest, free: at.len(), at: &at, springs: &[], walls: &[] };
        let mut out = vec![f32::NAN; at.len() * MODES];
        let mut bytes = vec![0; 1 << 26];
        modes(&mut out, &piece, Scratch::new(&mut bytes), &Serial).unwrap();
        (at, out)
    }

    #[test]
    fn those_of_a_rectangle_are_cosines() {
        // Of sides 1 and 1/2: eigenvalues pi^2 (i^2 + 4 j^2). Linear elements of side h = 1/24 err by (pi i h)^2/12 of the mode.
        let (at, out) = of_rectangle([24, 12]);
        let wave = |i: f64, j: f64, p: DVec3| {
            (core::f64::consts::PI * i * p.x).cos() * (core::f64::consts::PI * 2.0 * j * p.y).cos()
        };
        for (mode, (i, j)) in [(0, (1.0, 0.0)), (3, (1.0, 1.0))] {
            let sign = f64::from(out[mode]).signum() * wave(i, j, at[0]);
            for (p, row) in at.iter().zip(out.chunks_exact(MODES)) {
                let gap = f64::from(row[mode]) - sign * wave(i, j, *p);
                assert!(gap.abs() < 0.02, "mode {mode} at {p}: {}", row[mode]);
            }
        }
        let largest = |mode: usize| out.chunks_exact(MODES).fold(0.0f32, |most, row| most.max(row[mode].abs()));
        assert!((0..MODES).all(|mode| (largest(mode) - 1.0).abs() < 1e-6));
    }

    #[test]
    fn a_sheet_of_few_nodes_has_few_modes_and_the_rest_is_zero() {
        let (at, out) = of_rectangle([2, 1]);
        let is_zero = |mode: usize| out.chunks_exact(MODES).all(|row| row[mode] == 0.0);
        assert!((0..at.len() - 1).all(|mode| !is_zero(mode)) && (at.len() - 1..MODES).all(is_zero));
        assert!(out.iter().all(|x| x.is_finite()));
    }
}
