//! How likely two patches belong to different parts: one number in [0, 1] for each pair.
//!
//! Four measures, each of which finds what the others miss:
//! - **resistance**: the square root of the effective resistance between the patches, where the surface conducts and concave
//!   edges are resistors (conductance exp(-turn/0.3)): narrow necks and long creases part, whatever way around them is
//!   taken (commute times: Fouss et al. 2007; concavity in the Laplacian: Au et al. 2012, Zhang et al. 2012);
//! - **turn**: the sum of inward turns along the easiest way between them, in radians: a crease all around parts however
//!   short it is, and the figure does not depend on the tessellation (the minima rule: Hoffman, Richards 1984);
//! - **diameter**: the difference of the logarithms of their shape diameters (Shapira et al. 2008);
//! - **sight**: whether they see each other through the inside (van Kaick et al. 2014, after Asafi et al. 2013).
//!
//! x = resistance + 0.3 turn + 0.3 diameter + 0.2 (1 - sight); the pair is apart with 1/(1 + exp(-4 (x - 1.25))).
//! All are without unit, so scale changes nothing. The numbers are round and their brackets flat: docs/RESULTS.md.

use super::dual::Dual;
use super::patches::{Patches, Walk, walk_need};
use super::surface::PartSurface;
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::{Slices, take_first};
use crate::base::workers::{Workers, for_each_chunk};
use crate::mesh::view::NONE;
use glam::Vec3;

/// Radians of inward turn that cost a factor of e in conductance. 0.15 and 0.6 are each 0.01 worse.
const GIVE: f64 = 0.3;
/// Least share of conductance that a crease leaves.
const LEAK: f64 = 1e-3;
/// What a flat way as long as the root of the area counts, in radians.
const FLAT_WAY: f64 = 0.08;
/// Weights of turn, diameter and sight beside resistance.
const TURN: f64 = 0.3;
const DIAMETER: f64 = 0.3;
const SIGHT: f64 = 0.2;
/// Measures count up to here.
const RESISTANCE_MOST: f64 = 5.0;
const TURN_MOST: f64 = 6.0;
const DIAMETER_MOST: f64 = 1.5;
/// Where a pair is as likely apart as not, and how fast that changes.
const EVEN: f64 = 1.25;
const STEEP: f64 = 4.0;
/// Eyes are this share of the shape diameter below the surface.
const DEPTH: f64 = 0.05;
/// Keeps the Laplacian of each component regular.
const GROUND: f64 = 1e-7;

/// Bytes that [`affinity`] takes beside its output.
pub const fn affinity_need(faces: usize, patches: usize) -> usize {
    let pairs = patches * patches;
    let walk = bytes_for::<f64>(3 * faces) + walk_need(faces) + bytes_for::<u32>(faces);
    2 * bytes_for::<f64>(pairs)
        + bytes_for::<u8>(pairs)
        + walk
        + 3 * bytes_for::<f64>(patches)
        + bytes_for::<Vec3>(patches)
}

/// Fills `apart` and `adjacent` (1 where two patches share an edge). Pairs of different components are as far apart as can
/// be. O(f log f + m^3), and m^2/2 calls of sight.
#[allow(clippy::too_many_arguments)]
pub fn affinity(
    apart: &mut [f64],   // (m, m)
    adjacent: &mut [u8], // (m, m)
    surface: &PartSurface,
    dual: &Dual,
    patches: &Patches,
    length: &[f64], // (3 f) steps over half-edges
    inward: &[f64], // (3 f) their inward turns
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let m = patches.area.len();
    let inverse = scratch.take::<f64>(m * m)?;
    let turn = scratch.take_filled::<f64>(m * m, f64::INFINITY)?;
    let seen = scratch.take::<u8>(m * m)?;
    laplacian(inverse, adjacent, dual, patches);
    invert(inverse, m);
    turns(turn, surface, dual, patches, length, inward, scratch.frame())?;
    let width = scratch.take::<f64>(m)?;
    widths(width, surface, dual, patches);
    let eyes = scratch.take::<Vec3>(m)?;
    for (i, eye) in eyes.iter_mut().enumerate() {
        *eye = eye_of(surface, patches.middle[i], real::exp(width[i]));
    }
    let eyes = &*eyes;
    for_each_chunk(workers, seen, m.max(1), &|i, row| {
        for (j, seen) in row.iter_mut().enumerate().take(i) {
            *seen = u8::from((surface.sees)(eyes[i], eyes[j]));
        }
    });
    for i in 0..m {
        for j in 0..i {
            let squared = inverse[i * m + i] + inverse[j * m + j] - 2.0 * inverse[i * m + j];
            let resistance = real::sqrt(squared.max(0.0)).min(RESISTANCE_MOST);
            let difference = (width[i] - width[j]).abs().min(DIAMETER_MOST);
            let hidden = f64::from(1 - seen[i * m + j]);
            let x = resistance + TURN * turn[i * m + j].min(TURN_MOST) + DIAMETER * difference + SIGHT * hidden;
            let p = 1.0 / (1.0 + real::exp(-STEEP * (x - EVEN)));
            (apart[i * m + j], apart[j * m + i]) = (p, p);
        }
        apart[i * m + i] = 0.0;
    }
    Ok(())
}

/// The Laplacian of the patches' graph, grounded a little.
fn laplacian(matrix: &mut [f64], adjacent: &mut [u8], dual: &Dual, patches: &Patches) {
    let m = patches.area.len();
    matrix.fill(0.0);
    adjacent.fill(0);
    for (e, sides) in dual.sides.iter().enumerate() {
        let [a, b] = sides.map(|f| patches.of[f as usize]);
        if a == b || a == NONE {
            continue;
        }
        let (a, b) = (a as usize, b as usize);
        let way = real::sqrt((patches.centroid[a] - patches.centroid[b]).length_squared());
        let give = real::exp(dual.turn[e].min(0.0) / GIVE).max(LEAK);
        if way > 0.0 {
            let conductance = dual.length[e] / way * give;
            for (i, j, sign) in [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)] {
                matrix[i * m + j] += sign * conductance;
            }
        }
        (adjacent[a * m + b], adjacent[b * m + a]) = (1, 1);
    }
    (0..m).for_each(|i| matrix[i * m + i] += GROUND);
}

/// Turns a symmetric positive definite matrix into its inverse, in place: sweeps of one pivot after the other.
fn invert(matrix: &mut [f64], m: usize) {
    for k in 0..m {
        let (above, mut below) = matrix.parted_mut(k * m);
        let pivot_row = take_first(&mut below, m);
        let scale = 1.0 / pivot_row[k];
        pivot_row.iter_mut().for_each(|x| *x *= scale);
        pivot_row[k] = scale;
        for row in above.rows_mut(m).chain(below.rows_mut(m)) {
            let factor = core::mem::take(&mut row[k]);
            if factor != 0.0 {
                row.iter_mut().zip(&*pivot_row).for_each(|(x, p)| *x -= factor * p);
            }
        }
    }
}

/// The least sum of inward turns between the middles of any two patches: ways from all middles meet at edges between
/// their regions, and chains of such ways are searched over the patches (Floyd 1962).
fn turns(
    turn: &mut [f64],
    surface: &PartSurface,
    dual: &Dual,
    patches: &Patches,
    length: &[f64],
    inward: &[f64],
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let (faces, m) = (patches.of.len(), patches.area.len());
    let scale = FLAT_WAY / real::sqrt(dual.area.iter().sum::<f64>());
    let step = scratch.take::<f64>(3 * faces)?;
    (step.iter_mut().zip(length).zip(inward)).for_each(|((s, l), t)| *s = l * scale + t);
    let nearest = scratch.take_filled::<u32>(faces, NONE)?;
    let mut walk = Walk::new(faces, &mut scratch)?;
    for (i, face) in patches.middle.iter().enumerate() {
        walk.start(*face);
        nearest[*face as usize] = i as u32;
        turn[i * m + i] = 0.0;
    }
    walk.run(surface.twin, step, |face, before| nearest[face as usize] = nearest[before as usize]);
    for (c, twin) in surface.twin.iter().enumerate().filter(|(_, t)| **t != NONE) {
        let sides = [c / 3, (*twin / 3) as usize];
        let [a, b] = sides.map(|f| nearest[f]);
        if a != b && a != NONE && b != NONE {
            let sum = walk.distance[sides[0]] + step[c] + walk.distance[sides[1]];
            for (i, j) in [(a as usize, b as usize), (b as usize, a as usize)] {
                turn[i * m + j] = turn[i * m + j].min(sum);
            }
        }
    }
    for k in 0..m {
        for i in 0..m {
            let first = turn[i * m + k];
            if first < f64::INFINITY && i != k {
                let (through, row) = pair_of_rows(turn, m, k, i);
                row.iter_mut().zip(through).for_each(|(x, y)| *x = if first + *y < *x { first + *y } else { *x });
            }
        }
    }
    Ok(())
}

/// Row `k` to read and row `i` to write, different ones.
fn pair_of_rows(matrix: &mut [f64], m: usize, k: usize, i: usize) -> (&[f64], &mut [f64]) {
    let (low, high) = matrix.parted_mut(k.max(i) * m);
    if k < i { (&low[k * m..k * m + m], &mut high[..m]) } else { (&high[..m], &mut low[i * m..i * m + m]) }
}

/// Area-weighted mean logarithm of the shape diameter of each patch, relative to the whole mesh.
fn widths(width: &mut [f64], surface: &PartSurface, dual: &Dual, patches: &Patches) {
    let floor = 1e-4 * real::sqrt(dual.area.iter().sum::<f64>());
    let whole = dual.area.iter().sum::<f64>();
    for (f, p) in patches.of.iter().enumerate().filter(|(_, p)| **p != NONE) {
        let weight = (dual.area[f] / whole).max(1e-15) / patches.area[*p as usize];
        width[*p as usize] += weight * real::ln((surface.diameter[f] as f64).max(floor));
    }
}

/// A point a little below the middle of a face.
fn eye_of(surface: &PartSurface, face: u32, width: f64) -> Vec3 {
    let normal = surface.mesh.area_vector(face as usize);
    let length = real::sqrt(normal.length_squared());
    let depth = DEPTH * width.min(surface.diameter[face as usize] as f64);
    let middle = crate::parts::patches::centroid(surface.mesh, face);
    (if length > 0.0 { middle - normal * (depth / length) } else { middle }).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f64;
    use approx::assert_abs_diff_eq;
    use std::vec::Vec;

    #[test]
    fn a_matrix_times_its_inverse_is_one() {
        let m = 17;
        let root: Vec<f64> = (0..m * m).map(|k| unit_f64(1, 2, k as u64) - 0.5).collect();
        let product = |a: &[f64], b: &[f64], transposed: bool| -> Vec<f64> {
            let entry = |i: usize, j: usize| {
                (0..m).map(|k| a[i * m + k] * if transposed { b[j * m + k] } else { b[k * m + j] }).sum()
            };
            (0..m * m).map(|k| entry(k / m, k % m)).collect()
        };
        let mut matrix = product(&root, &root, true);
        (0..m).for_each(|i| matrix[i * m + i] += 0.1);
        let mut inverse = matrix.clone();
        invert(&mut inverse, m);
        for (k, x) in product(&matrix, &inverse, false).iter().enumerate() {
            // Condition below 1e3, some twenty roundings an entry.
            assert!((x - f64::from(u8::from(k / m == k % m))).abs() < 1e-11, "{k} {x}");
        }
    }

    #[test]
    fn resistances_in_a_row_add_up() {
        // Three nodes, conductances 2 and 0.5: resistances 0.5, 2, together 2.5, but for the little that is grounded.
        let mut matrix = [2.0, -2.0, 0.0, -2.0, 2.5, -0.5, 0.0, -0.5, 0.5];
        (0..3).for_each(|i| matrix[4 * i] += GROUND);
        invert(&mut matrix, 3);
        let resistance = |i: usize, j: usize| matrix[4 * i] + matrix[4 * j] - 2.0 * matrix[3 * i + j];
        for (i, j, expected) in [(0, 1, 0.5), (1, 2, 2.0), (0, 2, 2.5)] {
            assert_abs_diff_eq!(resistance(i, j), expected, epsilon = 1e-6);
        }
    }
}
