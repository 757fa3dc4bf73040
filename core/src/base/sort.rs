//! Sorting and selection in place, without a panic path.
//!
//! The standard library's sorts check at run time that the comparison is an order, and stop the program where it is not;
//! its small sorts and its selection may also change from one version to the next. Here a comparison that is no order
//! gives some permutation, and a selection leaves the same permutation on every machine and with every compiler.
//! Quicksort with a branch-free partition (Edelkamp and Weiss 2016), insertion sort below [`SMALL`], heapsort where the
//! pivots are unlucky: O(n log n), not stable. Equal items must be alike or told apart by their index.

use core::cmp::Ordering;

/// Items that insertion sort takes.
const SMALL: usize = 20;

/// Sorts by the items' own order.
pub fn ascending<T: Copy + Ord>(items: &mut [T]) {
    by(items, T::cmp);
}

/// Sorts by `key`.
pub fn by_key<T: Copy, K: Ord>(items: &mut [T], mut key: impl FnMut(&T) -> K) {
    quicksort(items, &mut |a, b| key(a) < key(b));
}

/// Sorts by `order`.
pub fn by<T: Copy>(items: &mut [T], mut order: impl FnMut(&T, &T) -> Ordering) {
    quicksort(items, &mut |a, b| order(a, b).is_lt());
}

/// Puts the item that belongs at `place` there, what goes before it below and the rest above; O(n) expected, O(n log n) at
/// the worst. A place that is not there: some permutation.
pub fn select_by<T: Copy>(mut items: &mut [T], mut place: usize, mut order: impl FnMut(&T, &T) -> Ordering) {
    let before = &mut |a: &T, b: &T| order(a, b).is_lt();
    let mut luck = luck_of(items.len());
    while items.len() > SMALL && luck > 0 {
        luck -= 1;
        let (low, high) = partition(items, before);
        if place < low {
            items = &mut items[..low];
        } else if place < high {
            return;
        } else {
            place -= high;
            items = &mut items[high..];
        }
    }
    if items.len() > SMALL { heapsort(items, before) } else { insertion(items, before) }
}

/// Partitions before quicksort gives way: twice the depth of even halves.
fn luck_of(count: usize) -> u32 {
    2 * (usize::BITS - count.leading_zeros())
}

fn quicksort<T: Copy>(items: &mut [T], before: &mut impl FnMut(&T, &T) -> bool) {
    quicksort_with(items, luck_of(items.len()), before);
}

/// Recursion into the shorter side keeps the depth below 64.
fn quicksort_with<T: Copy>(mut items: &mut [T], mut luck: u32, before: &mut impl FnMut(&T, &T) -> bool) {
    while items.len() > SMALL {
        if luck == 0 {
            return heapsort(items, before);
        }
        luck -= 1;
        let (low, high) = partition(items, before);
        if low < items.len() - high {
            quicksort_with(&mut items[..low], luck, before);
            items = &mut items[high..];
        } else {
            quicksort_with(&mut items[high..], luck, before);
            items = &mut items[..low];
        }
    }
    insertion(items, before);
}

/// Splits into what goes before a pivot, up to the first answer, and what does not, from the second answer on; between
/// them stand items equal to the pivot, at least one.
fn partition<T: Copy>(items: &mut [T], before: &mut impl FnMut(&T, &T) -> bool) -> (usize, usize) {
    let last = items.len() - 1;
    items.swap(last, pivot(items, before));
    let pivot = items[last];
    let low = gather(&mut items[..last], |item| before(item, &pivot));
    items.swap(low, last);
    // Where nothing goes before it, it may have many equals.
    let equal = if low == 0 { gather(&mut items[1..], |item| !before(&pivot, item)) } else { 0 };
    (low, low + 1 + equal)
}

/// Moves what `goes_first` to the front; how many do.
fn gather<T: Copy>(items: &mut [T], mut goes_first: impl FnMut(&T) -> bool) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        let is_first = goes_first(&items[i]);
        items.swap(i, count);
        count += usize::from(is_first);
    }
    count
}

/// Where the middle of three stands, each the middle of three where there are many.
fn pivot<T: Copy>(items: &[T], before: &mut impl FnMut(&T, &T) -> bool) -> usize {
    let mut middle = |[a, b, c]: [usize; 3]| -> usize {
        let [ab, bc, ac] = [[a, b], [b, c], [a, c]].map(|[i, j]| before(&items[i], &items[j]));
        match (ab == bc, ab == ac) {
            (true, _) => b,
            (_, true) => c,
            _ => a,
        }
    };
    let step = items.len() / 8;
    let ends = [0, 4 * step, 7 * step];
    if step < SMALL {
        return middle(ends);
    }
    let middles = ends.map(|at| middle([at, at + step / 3, at + 2 * step / 3]));
    middle(middles)
}

fn insertion<T: Copy>(items: &mut [T], before: &mut impl FnMut(&T, &T) -> bool) {
    for i in 1..items.len() {
        let item = items[i];
        let mut hole = i;
        while hole > 0 && before(&item, &items[hole - 1]) {
            items[hole] = items[hole - 1];
            hole -= 1;
        }
        items[hole] = item;
    }
}

#[cold]
fn heapsort<T: Copy>(items: &mut [T], before: &mut impl FnMut(&T, &T) -> bool) {
    for i in (0..items.len() / 2).rev() {
        sift(items, i, before);
    }
    for end in (1..items.len()).rev() {
        items.swap(0, end);
        sift(&mut items[..end], 0, before);
    }
}

fn sift<T: Copy>(items: &mut [T], mut at: usize, before: &mut impl FnMut(&T, &T) -> bool) {
    loop {
        let (left, right) = (2 * at + 1, 2 * at + 2);
        if left >= items.len() {
            return;
        }
        let child = if right < items.len() && before(&items[left], &items[right]) { right } else { left };
        if !before(&items[at], &items[child]) {
            return;
        }
        items.swap(at, child);
        at = child;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random;
    use std::{vec, vec::Vec};

    /// Lists that sorts get wrong or slow: random, few values, up, down, alternating, equal, organ pipe.
    fn lists() -> Vec<Vec<u32>> {
        let mut out = vec![];
        for n in (0..70).chain([100, 127, 128, 129, 500, 1000, 5000]) {
            let n = n as u32;
            out.push((0..n).map(|i| random::hash(1, 0, u64::from(i)) as u32).collect());
            out.push((0..n).map(|i| random::hash(2, 0, u64::from(i)) as u32 % 4).collect());
            out.push((0..n).collect());
            out.push((0..n).rev().collect());
            out.push((0..n).map(|i| i % 2 * n + i).collect());
            out.push(vec![7; n as usize]);
            out.push((0..n).map(|i| i.min(n - i)).collect());
        }
        out
    }

    #[test]
    fn every_list_is_sorted_as_the_standard_library_sorts_it() {
        for list in lists() {
            let mut expected = list.clone();
            expected.sort();
            let mut sorted = list.clone();
            ascending(&mut sorted);
            assert_eq!(sorted, expected);
            sorted.copy_from_slice(&list);
            heapsort(&mut sorted, &mut |a, b| a < b);
            assert_eq!(sorted, expected);
            let mut order: Vec<u32> = (0..list.len() as u32).collect();
            by_key(&mut order, |i| (list[*i as usize], *i));
            let mut stable: Vec<u32> = (0..list.len() as u32).collect();
            stable.sort_by_key(|i| list[*i as usize]);
            assert_eq!(order, stable);
        }
    }

    #[test]
    fn the_selected_place_separates_the_list() {
        for list in lists() {
            let mut expected = list.clone();
            expected.sort();
            for place in [0, list.len() / 3, list.len() / 2, list.len().wrapping_sub(1)] {
                let mut items = list.clone();
                select_by(&mut items, place, u32::cmp);
                if place < items.len() {
                    assert_eq!(items[place], expected[place]);
                    assert!(items[..place].iter().all(|x| *x <= items[place]));
                    assert!(items[place..].iter().all(|x| *x >= items[place]));
                }
                ascending(&mut items);
                assert_eq!(items, expected);
            }
        }
    }

    #[test]
    fn a_comparison_that_is_no_order_still_gives_a_permutation() {
        for list in lists() {
            let mut calls = 0;
            let mut lie = |_: &u32, _: &u32| {
                calls += 1;
                if random::hash(3, 0, calls).is_multiple_of(2) { Ordering::Less } else { Ordering::Greater }
            };
            let (mut sorted, mut selected) = (list.clone(), list.clone());
            by(&mut sorted, &mut lie);
            select_by(&mut selected, list.len() / 2, &mut lie);
            let mut expected = list;
            expected.sort();
            for mut items in [sorted, selected] {
                items.sort();
                assert_eq!(items, expected);
            }
        }
    }
}
