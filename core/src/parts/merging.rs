//! Clusters of patches: the two neighbours that are least apart become one, again and again.
//!
//! How far two clusters are apart is the area-weighted mean over all pairs of their patches (average linkage: Sokal,
//! Michener 1958), so a cluster is judged by all of it and a chain of like neighbours does not make one part. With numbers
//! that are probabilities to be apart, merging while the mean is below one half lowers the expected Rand distance to
//! the partitions that the probabilities describe (correlation clustering: Bansal, Blum, Chawla 2004); the end stands a
//! little above, at [`APART`]. Clusters below [`SMALL`] of the area merge earlier.
//! Equal distances go to the lower pair. O(m^2) a merge at worst, O(m) as a rule.

use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::mesh::view::NONE;

/// Clusters this far apart stay apart: 0.55 to 0.65 are equally good.
pub const APART: f64 = 0.6;
/// Share of the area below which a cluster's distances shrink with the root of its size.
const SMALL: f64 = 0.02;

/// Bytes that [`merge`] takes.
pub const fn merge_need(patches: usize) -> usize {
    bytes_for::<f64>(patches) + bytes_for::<f64>(patches) + bytes_for::<u32>(patches)
}

/// The state of the clustering.
struct Clusters<'a> {
    sum: &'a mut [f64],     // (m, m) of apart, weighted by both areas
    adjacent: &'a mut [u8], // (m, m)
    area: &'a mut [f64],    // (m); 0: gone
    near: &'a mut [f64],    // (m) distance to the nearest neighbour
    nearest: &'a mut [u32], // (m)
}

/// Fills `cluster` with a number for each patch, the lowest patch of its cluster. Goes on while two neighbours are less
/// than [`APART`], or with `wanted` until so many clusters are left; no further than neighbours reach. `sum` holds the
/// pairs' distances and `adjacent` who are neighbours; both are written over.
pub fn merge(
    cluster: &mut [u32], // (m)
    sum: &mut [f64],     // (m, m)
    adjacent: &mut [u8], // (m, m)
    share: &[f64],       // (m) areas
    wanted: Option<usize>,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    scratch.require(merge_need(share.len()))?;
    let m = share.len();
    let area = scratch.take::<f64>(m)?;
    area.copy_from(share);
    let near = scratch.take_filled::<f64>(m, f64::INFINITY)?;
    let nearest = scratch.take_filled::<u32>(m, NONE)?;
    for (i, row) in sum.rows_mut(m).enumerate() {
        row.iter_mut().zip(share).for_each(|(x, a)| *x *= a * share[i]);
    }
    let mut clusters = Clusters { sum, adjacent, area, near, nearest };
    (0..m).for_each(|i| clusters.look(i));
    cluster.iter_mut().enumerate().for_each(|(i, c)| *c = i as u32);
    let mut count = m;
    while count > wanted.unwrap_or(1) {
        let Some((a, b, distance)) = clusters.closest() else { break };
        if wanted.is_none() && distance >= APART {
            break;
        }
        clusters.join(a, b);
        cluster.iter_mut().filter(|c| **c == b as u32).for_each(|c| *c = a as u32);
        count -= 1;
    }
    Ok(count)
}

impl Clusters<'_> {
    fn distance(&self, i: usize, j: usize) -> f64 {
        let least = self.area[i].min(self.area[j]);
        let shrink = if least < SMALL { crate::base::real::sqrt(least / SMALL) } else { 1.0 };
        self.sum[i * self.area.len() + j] / (self.area[i] * self.area[j]) * shrink
    }

    /// Finds the nearest neighbour of `i` anew.
    fn look(&mut self, i: usize) {
        let m = self.area.len();
        (self.near[i], self.nearest[i]) = (f64::INFINITY, NONE);
        for j in (0..m).filter(|j| self.adjacent[i * m + j] == 1) {
            let distance = self.distance(i, j);
            if distance < self.near[i] {
                (self.near[i], self.nearest[i]) = (distance, j as u32);
            }
        }
    }

    fn closest(&self) -> Option<(usize, usize, f64)> {
        let alive = (0..self.area.len()).filter(|i| self.nearest[*i] != NONE);
        let i = alive.min_by(|a, b| self.near[*a].total_cmp(&self.near[*b]))?;
        let j = self.nearest[i] as usize;
        Some((i.min(j), i.max(j), self.near[i]))
    }

    /// Takes cluster `b` into `a`.
    fn join(&mut self, a: usize, b: usize) {
        let m = self.area.len();
        for k in 0..m {
            let (sum, touch) = (self.sum[b * m + k], self.adjacent[b * m + k]);
            self.sum[a * m + k] += sum;
            self.adjacent[a * m + k] |= touch;
            self.adjacent[b * m + k] = 0;
            self.adjacent[k * m + b] = 0;
        }
        for k in 0..m {
            self.sum[k * m + a] = self.sum[a * m + k];
            self.adjacent[k * m + a] = self.adjacent[a * m + k];
        }
        self.adjacent[a * m + a] = 0;
        self.area[a] += self.area[b];
        (self.near[b], self.nearest[b]) = (f64::INFINITY, NONE);
        for k in 0..m {
            if k == a || self.adjacent[a * m + k] == 1 || [a as u32, b as u32].contains(&self.nearest[k]) {
                self.look(k);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{vec, vec::Vec};

    /// Patches in a row, each a neighbour of the next, at places on a line; the pairs' distance is that of their places.
    fn run(place: &[f64], wanted: Option<usize>) -> Vec<u32> {
        let m = place.len();
        let mut sum: Vec<f64> = (0..m * m).map(|k| (place[k / m] - place[k % m]).abs()).collect();
        let mut adjacent: Vec<u8> = (0..m * m).map(|k| u8::from((k / m).abs_diff(k % m) == 1)).collect();
        let (mut cluster, share) = (vec![0; m], vec![1.0 / m as f64; m]);
        let mut bytes = vec![0; merge_need(m)];
        let count = merge(&mut cluster, &mut sum, &mut adjacent, &share, wanted, Scratch::new(&mut bytes)).unwrap();
        let mut seen = cluster.clone();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), count);
        cluster
    }

    #[test]
    fn near_neighbours_join_and_far_ones_stay_apart() {
        assert_eq!(run(&[0.0, 0.1, 0.9, 1.0, 1.1], None), [0, 0, 2, 2, 2]);
        assert_eq!(run(&[0.0, 0.1, 0.9, 1.0, 1.1], Some(1)), [0; 5]);
        assert_eq!(run(&[0.0, 0.1, 0.9, 1.0, 1.1], Some(9)), [0, 1, 2, 3, 4]);
    }

    #[test]
    fn those_who_are_no_neighbours_do_not_join_however_near() {
        // The first and the last are at one place, what lies between is far from both.
        assert_eq!(run(&[0.0, 5.0, 0.0], None), [0, 1, 2]);
    }

    #[test]
    fn it_joins_what_a_search_over_all_pairs_joins() {
        use crate::base::random::unit_f64;
        for case in 0..20 {
            let place: Vec<f64> = (0..12).map(|i| 2.0 * unit_f64(1, case, i)).collect();
            // The plain way: clusters are runs of the row, the pair of runs with the least mean joins.
            let mut runs: Vec<Vec<usize>> = (0..12).map(|i| vec![i]).collect();
            let mean = |a: &[usize], b: &[usize]| {
                let sum = a.iter().flat_map(|i| b.iter().map(move |j| (i, j)));
                sum.map(|(i, j)| (place[*i] - place[*j]).abs()).sum::<f64>() / (a.len() * b.len()) as f64
            };
            while let Some(k) =
                (1..runs.len()).min_by(|a, b| mean(&runs[a - 1], &runs[*a]).total_cmp(&mean(&runs[b - 1], &runs[*b])))
            {
                if mean(&runs[k - 1], &runs[k]) >= APART {
                    break;
                }
                let joined = runs.remove(k);
                runs[k - 1].extend(joined);
            }
            let expected: Vec<u32> = runs.iter().flat_map(|r| r.iter().map(|_| r[0] as u32)).collect();
            assert_eq!(run(&place, None), expected, "{place:?}");
        }
    }

    #[test]
    fn no_patches_are_fine_and_one_byte_less_is_refused() {
        assert!(run(&[], None).is_empty());
        let mut bytes = vec![0; merge_need(1) - 1];
        assert!(merge(&mut [0], &mut [0.0], &mut [0], &[1.0], None, Scratch::new(&mut bytes)).is_err());
    }
}
