//! Nearest points by a k-d tree over caller's memory, in the plane or in space.
//!
//! Ranges are halved by their median point along their widest side, so the tree is balanced for any distribution, outliers and
//! clusters included (Friedman, Bentley, Finkel, *An algorithm for finding best matches in logarithmic expected time*,
//! ACM TOMS 3(3), 1977). Each range has its box: planes alone say little to a query far away from a cluster, which is what
//! an untrained map looks like. Equal distances go to the lower index, so results do not depend on the tree.
//! A box's distance is summed as a point's is, and rounding keeps order, so no nearer point is ever passed over.
//! Build O(n log^2 n), a query O(log n) for spread points. Points with NaN are never found.

use super::kernels::float::Float;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::base::stack::Stack;

/// Points of a leaf. 4 and 16 were slower on Spot.
const LEAF: usize = 8;
/// Halvings of 2^32 points, and one for each that waits.
const DEPTH: usize = 34;

/// A tree over points of `D` coordinates.
pub struct Tree<'a, T, const D: usize> {
    points: &'a [T],  // (n, D) in the order of the tree
    order: &'a [u32], // (n) index of each
    boxes: &'a [T],   // (n, 2, D) lowest and highest corner of the range whose middle this is
}

/// The `K` nearest found so far, nearest first.
#[derive(Clone, Copy)]
pub struct Found<T, const K: usize> {
    /// Squared distances.
    pub distance: [T; K],
    /// Indices.
    pub index: [u32; K],
    /// How many there are.
    pub len: usize,
}

/// Bytes that [`Tree::new`] takes.
pub const fn tree_need<T>(count: usize, dimensions: usize) -> usize {
    let points = bytes_for::<T>(count.saturating_mul(dimensions));
    points.saturating_add(bytes_for::<u32>(count)).saturating_add(bytes_for::<T>(count.saturating_mul(2 * dimensions)))
}

impl<'a, T: Float, const D: usize> Tree<'a, T, D> {
    /// A tree over `points` (n, D).
    pub fn new(points: &[T], scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        let count = points.len() / D;
        scratch.require(tree_need::<T>(count, D))?;
        let sorted = scratch.take_unset::<T>(count * D)?;
        let order = scratch.take_unset::<u32>(count)?;
        let boxes = scratch.take_unset::<T>(count * 2 * D)?;
        order.iter_mut().enumerate().for_each(|(i, o)| *o = i as u32);
        let mut waiting = Stack::<(usize, usize), DEPTH>::new();
        let mut range: (usize, usize) = (0, count);
        loop {
            let (low, high) = range;
            let middle = low.midpoint(high);
            let widest = match boxes.get_mut(middle * 2 * D..) {
                Some(corners) if low < high => surround::<T, D>(corners, points, &order[low..high]),
                _ => 0,
            };
            if high - low > LEAF {
                let key = |i: &u32| points[*i as usize * D + widest];
                sort::select_by(&mut order[low..high], middle - low, |a, b| key(a).order(key(b)).then(a.cmp(b)));
                waiting.push((middle + 1, high));
                range = (low, middle);
            } else if let Some(next) = waiting.pop() {
                range = next;
            } else {
                break;
            }
        }
        for (to, &i) in sorted.as_chunks_mut::<D>().0.iter_mut().zip(&*order) {
            to.copy_from(&points[i as usize * D..][..D]);
        }
        Ok(Self { points: sorted, order, boxes })
    }

    /// The up to `K` points nearest to `at` whose squared distance is at most `within`, without the point `except`.
    pub fn nearest<const K: usize>(&self, at: &[T], within: T, except: Option<u32>) -> Found<T, K> {
        let mut found = Found { distance: [within; K], index: [u32::MAX; K], len: 0 };
        // Ranges to look at, each with the least squared distance that its points can have.
        let mut waiting = Stack::<(usize, usize, T), DEPTH>::new();
        let mut next = Some((0, self.order.len(), T::ZERO));
        while let Some((low, high, least)) = next.take().or_else(|| waiting.pop()) {
            if least > found.distance[K - 1] {
                continue;
            }
            if high - low <= LEAF {
                (low..high)
                    .for_each(|i| found.offer(self.order[i], distance::<T, D>(&self.points[i * D..], at), except));
                continue;
            }
            let middle = low.midpoint(high);
            found.offer(self.order[middle], distance::<T, D>(&self.points[middle * D..], at), except);
            let left = (low, middle, self.gap(at, low, middle));
            let right = (middle + 1, high, self.gap(at, middle + 1, high));
            let (near, far) = if left.2 <= right.2 { (left, right) } else { (right, left) };
            waiting.push(far);
            next = Some(near);
        }
        found
    }

    /// Squared distance from `at` to the box of a range; 0 where that is not known.
    #[inline(always)]
    fn gap(&self, at: &[T], low: usize, high: usize) -> T {
        let corners = &self.boxes[low.midpoint(high) * 2 * D..][..2 * D];
        let mut sum = T::ZERO;
        for c in 0..D {
            let (below, above) = (corners[c] - at[c], at[c] - corners[D + c]);
            let outside = if below > above { below } else { above };
            let outside = if outside > T::ZERO { outside } else { T::ZERO };
            sum += outside * outside;
        }
        sum
    }
}

impl<T: Float, const K: usize> Found<T, K> {
    fn offer(&mut self, index: u32, distance: T, except: Option<u32>) {
        let last = K - 1;
        let is_before =
            |i: usize, of: &Self| distance < of.distance[i] || distance <= of.distance[i] && index < of.index[i];
        if !is_before(last, self) || except == Some(index) {
            return;
        }
        let mut place = last;
        while place > 0 && is_before(place - 1, self) {
            (self.distance[place], self.index[place]) = (self.distance[place - 1], self.index[place - 1]);
            place -= 1;
        }
        (self.distance[place], self.index[place]) = (distance, index);
        self.len = (self.len + 1).min(K);
    }
}

/// Squared distance of two points.
#[inline(always)]
pub fn distance<T: Float, const D: usize>(a: &[T], b: &[T]) -> T {
    let mut sum = T::ZERO;
    for (a, b) in a[..D].iter().zip(&b[..D]) {
        sum += (*a - *b) * (*a - *b);
    }
    sum
}

/// Writes the lowest and the highest corner of the listed points; the axis along which they spread widest.
fn surround<T: Float, const D: usize>(corners: &mut [T], points: &[T], listed: &[u32]) -> usize {
    let first: [T; D] = core::array::from_fn(|c| points[listed[0] as usize * D + c]);
    let (mut low, mut high) = (first, first);
    for &i in listed {
        for c in 0..D {
            let x = points[i as usize * D + c];
            if x < low[c] {
                low[c] = x;
            }
            if x > high[c] {
                high[c] = x;
            }
        }
    }
    corners[..D].copy_from(&low);
    corners[D..2 * D].copy_from(&high);
    (1..D).fold(0, |best, c| if high[c] - low[c] > high[best] - low[best] { c } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f32;
    use std::{vec, vec::Vec};

    fn sorted<const D: usize>(points: &[f32], at: &[f32], within: f32, except: u32) -> Vec<(f32, u32)> {
        let mut all: Vec<(f32, u32)> =
            points.chunks_exact(D).enumerate().map(|(i, p)| (distance::<f32, D>(p, at), i as u32)).collect();
        all.retain(|(d, i)| *d <= within && *i != except);
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        all
    }

    fn check<const D: usize>(points: &[f32], within: f32) {
        let count = points.len() / D;
        let mut bytes = vec![0; tree_need::<f32>(count, D)];
        let tree = Tree::<f32, D>::new(points, &mut Scratch::new(&mut bytes)).unwrap();
        for i in 0..count {
            let at = &points[i * D..][..D];
            let found = tree.nearest::<8>(at, within, Some(i as u32));
            let expected = sorted::<D>(points, at, within, i as u32);
            assert_eq!(found.len, expected.len().min(8));
            let pairs = found.distance.into_iter().zip(found.index).take(found.len);
            assert!(pairs.eq(expected.into_iter().take(8)), "point {i}");
        }
    }

    #[test]
    fn the_tree_finds_what_sorting_all_distances_finds() {
        let spread: Vec<f32> = (0..1500).map(|i| unit_f32(1, 1, i)).collect();
        check::<3>(&spread, f32::INFINITY);
        check::<2>(&spread, f32::INFINITY);
        check::<2>(&spread, 1e-3);
        // A lattice has many equal distances; a cluster with an outlier defeats grids.
        let lattice: Vec<f32> =
            (0..600).map(|i| if i % 2 == 0 { (i / 2 % 20) as f32 } else { (i / 40) as f32 }).collect();
        check::<2>(&lattice, f32::INFINITY);
        let mut cluster: Vec<f32> = spread.iter().map(|x| x * 1e-6).collect();
        cluster[7] = 1e6;
        check::<3>(&cluster, f32::INFINITY);
    }

    #[test]
    fn equal_points_no_point_and_nan_are_fine() {
        check::<2>(&[0.5; 60], f32::INFINITY);
        check::<2>(&[], 1.0);
        let mut points = [0.25; 40];
        points[9] = f32::NAN;
        let mut bytes = vec![0; tree_need::<f32>(20, 2)];
        let tree = Tree::<f32, 2>::new(&points, &mut Scratch::new(&mut bytes)).unwrap();
        let found = tree.nearest::<1>(&[0.0, 0.0], f32::INFINITY, None);
        assert_eq!((found.index, found.len), ([0], 1));
    }

    #[test]
    fn one_byte_less_is_refused() {
        let mut bytes = vec![0; tree_need::<f32>(30, 2) - 1];
        assert!(Tree::<f32, 2>::new(&[0.0; 60], &mut Scratch::new(&mut bytes)).is_err());
    }
}
