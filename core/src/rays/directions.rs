//! Low-discrepancy directions over a hemisphere, and frames to turn them towards a normal.
//!
//! The set is a Fibonacci lattice on the unit disk (equal areas, golden-angle turns), lifted to the hemisphere: by
//! z = sqrt(1 - r^2) for cosine weights (Malley), by z = 1 - r^2 for uniform ones. It is stored along a Hilbert curve of
//! the disk, so that neighbours in the list are neighbours on the sphere. Each point turns it about its normal by
//! a hashed angle, which makes the errors of neighbouring points independent.
//! Frames: Duff et al. 2017; they jump where n.z changes sign, which the hashed turn makes invisible.

use crate::base::random;
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use core::f32::consts::TAU;
use glam::{Vec2, Vec3};

/// Keeps these hashes apart from those of other users of the seed.
const TURN_STREAM: u64 = 0x7475_726e;
/// 2 pi (1 - 1/golden ratio).
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
/// Side of the grid of the Hilbert curve, as a power of two.
const CURVE_LEVELS: u32 = 10;

/// How directions are spread over the hemisphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spread {
    /// Density cos(angle to the normal) / pi: a plain mean of visibility is ambient occlusion.
    #[default]
    Cosine,
    /// The same density everywhere, as libigl samples.
    Uniform,
}

/// Scratch bytes for [`hemisphere`].
pub const fn hemisphere_need(count: usize) -> usize {
    bytes_for::<[u32; 2]>(count)
}

/// Fills `directions` with unit vectors of z > 0. O(n log n).
pub fn hemisphere(directions: &mut [Vec3], spread: Spread, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let count = directions.len();
    let keys = scratch.take::<[u32; 2]>(count)?; // (place on the curve, lattice index)
    for (i, key) in keys.iter_mut().enumerate() {
        *key = [place_on_curve(lattice(i, count)), i as u32];
    }
    sort::ascending(keys);
    for (direction, key) in directions.iter_mut().zip(keys) {
        let disk = lattice(key[1] as usize, count);
        let r2 = disk.length_squared();
        *direction = match spread {
            Spread::Cosine => disk.extend(real::sqrt(1.0 - r2)),
            Spread::Uniform => (disk * real::sqrt(2.0 - r2)).extend(1.0 - r2),
        };
    }
    Ok(())
}

/// Point `i` of `count` in the unit disk, never on its rim.
fn lattice(i: usize, count: usize) -> Vec2 {
    let r = real::sqrt((i as f64 + 0.5) / count as f64);
    let turn = GOLDEN_ANGLE * i as f64;
    Vec2::new((r * real::cos(turn)) as f32, (r * real::sin(turn)) as f32)
}

/// Where the Hilbert curve of the square [-1, 1]^2 meets the cell of `p`.
fn place_on_curve(p: Vec2) -> u32 {
    let side = 1u32 << CURVE_LEVELS;
    let cell = |x: f32| (((x + 1.0) * 0.5 * side as f32) as u32).min(side - 1);
    let (mut x, mut y) = (cell(p.x), cell(p.y));
    let mut place = 0;
    for level in (0..CURVE_LEVELS).rev() {
        let (right, up) = (x >> level & 1, y >> level & 1);
        place += ((3 * right) ^ up) << (2 * level);
        if up == 0 {
            if right == 1 {
                (x, y) = (!x, !y);
            }
            (x, y) = (y, x);
        }
    }
    place
}

/// Two unit vectors that make a right-handed frame with the unit vector `n`.
pub fn frame(n: Vec3) -> [Vec3; 2] {
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    [Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y)]
}

/// The frame of `n` turned about it by an angle that is a hash of (seed, index).
pub fn turned_frame(n: Vec3, seed: u64, index: u64) -> [Vec3; 2] {
    let angle = TAU * random::unit_f32(seed, TURN_STREAM, index);
    let (sin, cos) = (real::sin(angle), real::cos(angle));
    let [t, b] = frame(n);
    [t * cos + b * sin, b * cos - t * sin]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use std::vec;

    fn set(count: usize, spread: Spread) -> vec::Vec<Vec3> {
        let mut directions = vec![Vec3::ZERO; count];
        let mut bytes = vec![0u8; hemisphere_need(count)];
        hemisphere(&mut directions, spread, Scratch::new(&mut bytes)).unwrap();
        directions
    }

    #[test]
    fn moments_are_those_of_the_density() {
        // Cosine: E z = 2/3, E z^2 = 1/2. Uniform: E z = 1/2, E z^2 = 1/3. The lattice is a midpoint rule in r^2, of
        // error below 1/n for these monotone functions; x and y vanish up to the lattice's discrepancy, about 2/n.
        for (spread, z, zz) in [(Spread::Cosine, 2.0 / 3.0, 0.5), (Spread::Uniform, 0.5, 1.0 / 3.0)] {
            let directions = set(512, spread);
            let mean = |f: &dyn Fn(&Vec3) -> f32| directions.iter().map(f).sum::<f32>() / 512.0;
            assert!(directions.iter().all(|d| d.z > 0.0 && (d.length() - 1.0).abs() < 1e-6));
            assert!((mean(&|d| d.z) - z).abs() < 2e-3 && (mean(&|d| d.z * d.z) - zz).abs() < 2e-3);
            assert!(mean(&|d| d.x).abs() < 4e-3 && mean(&|d| d.y).abs() < 4e-3);
        }
    }

    #[test]
    fn neighbours_in_the_list_are_neighbours_on_the_sphere() {
        // The area a direction stands for has side sqrt(pi/512) = 0.08 on the disk; random pairs are 0.9 apart.
        let directions = set(512, Spread::Cosine);
        let steps = directions.windows(2).map(|w| w[0].truncate().distance(w[1].truncate()));
        assert!(steps.sum::<f32>() / 511.0 < 0.12);
    }

    #[test]
    fn frames_are_orthonormal_right_handed_and_turned() {
        for i in 0..200 {
            let v = Vec3::from_array([0, 1, 2].map(|k| random::unit_f32(3, k, i) - 0.5));
            let n = [v / v.length(), Vec3::Z, -Vec3::Z, Vec3::X][if i < 4 { i as usize } else { 0 }];
            let [t, b] = turned_frame(n, 1, i);
            // Some ten roundings of numbers up to 1 each.
            assert!((t.cross(b) - n).length() < 2e-6);
            assert!(t.dot(b).abs() < 1e-6);
            assert_abs_diff_eq!(t.length(), 1.0, epsilon = 1e-6);
        }
        assert!(turned_frame(Vec3::Z, 1, 0)[0].distance(turned_frame(Vec3::Z, 1, 1)[0]) > 1e-3);
    }

    #[test]
    fn no_direction_is_asked_for_and_none_is_given() {
        assert!(set(0, Spread::Cosine).is_empty());
        assert!(hemisphere(&mut [Vec3::ZERO], Spread::Cosine, Scratch::new(&mut [])).is_err());
    }
}
