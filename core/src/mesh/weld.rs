//! Vertices at the same place become one, in the working copy.
//!
//! Bit-equal positions, with -0.0 equal to 0.0: nothing near is merged, so no tolerance and no chain of merges.
//! By sorting: O(n log n). Vertices that no corner names are left alone.

use super::view::NONE;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use core::cmp::Ordering;
use glam::DVec3;

/// Scratch bytes for [`weld`] with `n` vertices.
pub const fn weld_need(n: usize) -> usize {
    bytes_for::<u32>(n)
}

/// Lowers each entry of `same` to the lowest vertex at the same position; entries that are [`NONE`] stay so and their
/// vertices do not count. Returns how many vertices were merged into another.
///
/// `same` is v itself or [`NONE`] on entry.
pub fn weld(same: &mut [u32], positions: &[DVec3], mut scratch: Scratch) -> Result<usize, ScratchTooSmall> {
    scratch.require(weld_need(same.len()))?;
    let order = scratch.take::<u32>(same.len())?;
    let mut count = 0;
    for &v in same.iter().filter(|v| **v != NONE) {
        order[count] = v;
        count += 1;
    }
    let order = &mut order[..count];
    let compare = |a: u32, b: u32| compare(positions[a as usize], positions[b as usize]);
    sort::by(order, |&a, &b| compare(a, b).then(a.cmp(&b)));
    let mut merged = 0;
    for group in order.runs(|&a, &b| compare(a, b).is_eq()) {
        group.iter().for_each(|v| same[*v as usize] = group[0]);
        merged += group.len() - 1;
    }
    Ok(merged)
}

/// By x, then y, then z. Adding 0.0 turns -0.0 into 0.0 and changes nothing else.
fn compare(a: DVec3, b: DVec3) -> Ordering {
    let (a, b) = (a + 0.0, b + 0.0);
    a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random;
    use std::vec;
    use std::vec::Vec;

    fn welded(positions: &[DVec3]) -> (Vec<u32>, usize) {
        let mut same: Vec<u32> = (0..positions.len() as u32).collect();
        let mut bytes = vec![0u8; weld_need(positions.len())];
        let merged = weld(&mut same, positions, Scratch::new(&mut bytes)).unwrap();
        (same, merged)
    }

    #[test]
    fn negative_zero_is_zero_and_near_is_not_equal() {
        let x = DVec3::new(0.0, 1.0, 2.0);
        let (same, merged) = welded(&[x, DVec3::new(-0.0, 1.0, 2.0), x + DVec3::new(1e-300, 0.0, 0.0), x]);
        assert_eq!((same, merged), (vec![0, 0, 2, 0], 2));
    }

    #[test]
    fn vertices_that_do_not_count_are_left_alone() {
        let mut same = [NONE, 1, 2];
        let mut bytes = vec![0u8; weld_need(3)];
        assert_eq!(weld(&mut same, &[DVec3::ONE; 3], Scratch::new(&mut bytes)), Ok(1));
        assert_eq!(same, [NONE, 1, 1]);
    }

    #[test]
    fn each_vertex_gets_the_first_one_that_a_plain_search_finds() {
        let at = |i: u64, axis| (random::hash(1, axis, i) % 4) as f64 - 2.0;
        let positions: Vec<_> = (0..300).map(|i| DVec3::new(at(i, 0), at(i, 1), at(i, 2) * 0.0)).collect();
        let plain: Vec<_> = positions.iter().map(|p| positions.iter().position(|q| q == p).unwrap() as u32).collect();
        assert_eq!(welded(&positions).0, plain);
    }

    #[test]
    fn one_byte_less_is_refused_with_nothing_written() {
        let mut bytes = vec![0u8; weld_need(2) - 1];
        let mut same = [0, 1];
        assert!(weld(&mut same, &[DVec3::ONE; 2], Scratch::new(&mut bytes)).is_err());
        assert_eq!(same, [0, 1]);
    }
}
