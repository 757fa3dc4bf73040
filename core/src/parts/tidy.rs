//! From labels to parts: majority among neighbours, connected regions, small ones absorbed, like ones merged.
//!
//! Regions are numbered by their lowest faces. All sums run over edges in order; equal claims go to the lower region.

use super::dual::Dual;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::base::union_find::UnionFind;
use crate::mesh::view::NONE;

/// Bytes that each function of this file takes at the most.
pub const fn tidy_need(faces: usize) -> usize {
    let edges = faces + faces / 2 + 1;
    3 * bytes_for::<u32>(faces) + 2 * bytes_for::<f64>(faces) + bytes_for::<Border>(edges)
}

/// A face whose neighbours all agree on another label takes it, one with two such neighbours as well where it has three;
/// all at once, `rounds` times.
pub fn majority(
    labels: &mut [u32],
    twin: &[u32], // (3 f)
    rounds: usize,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let before = scratch.take::<u32>(labels.len())?;
    for _ in 0..rounds {
        before.copy_from(labels);
        for (f, label) in labels.iter_mut().enumerate() {
            let of = |i: usize| Some(twin[3 * f + i]).filter(|t| *t != NONE).map(|t| before[(t / 3) as usize]);
            let around = [of(0), of(1), of(2)];
            let count = |wanted: u32| around.iter().flatten().filter(|l| **l == wanted).count();
            let sides = around.iter().flatten().count();
            if let Some(other) = around.into_iter().flatten().find(|l| 2 * count(*l) > sides)
                && count(*label) < count(other)
            {
                *label = other;
            }
        }
        if before == labels {
            break;
        }
    }
    Ok(())
}

/// Gives each connected region of equal labels a label of its own; returns how many there are.
pub fn connected(labels: &mut [u32], dual: &Dual, mut scratch: Scratch) -> Result<usize, ScratchTooSmall> {
    let parent = scratch.take::<u32>(labels.len())?;
    let mut sets = UnionFind::new(parent);
    for [a, b] in dual.sides {
        if labels[*a as usize] == labels[*b as usize] {
            sets.union(*a, *b);
        }
    }
    let count = sets.number();
    labels.copy_from(parent);
    Ok(count)
}

/// Length of the border between two regions, lower first.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Border {
    regions: [u32; 2],
    length: f64,
}

/// Joins every region for which `small(area, faces)` holds to the neighbour with the longest common border, all at once
/// and again until none is left that has a neighbour. Returns the number of regions. O(e log e) a round, few rounds.
pub fn absorb(
    labels: &mut [u32],
    count: usize,
    dual: &Dual,
    small: &dyn Fn(f64, usize) -> bool,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let mut count = count;
    loop {
        let mut frame = scratch.frame();
        let parent = frame.take::<u32>(count)?;
        let faces = frame.take::<u32>(count)?;
        let area = frame.take::<f64>(count)?;
        for (f, label) in labels.iter().enumerate() {
            area[*label as usize] += dual.area[f];
            faces[*label as usize] += 1;
        }
        let longest = frame.take::<f64>(count)?;
        let neighbour = frame.take_filled::<u32>(count, NONE)?;
        for border in &*borders(labels, dual, &mut frame)? {
            let [a, b] = border.regions;
            for (region, other) in [(a as usize, b), (b as usize, a)] {
                // Borders come in order of their regions, so the first of equals is the lower neighbour.
                if neighbour[region] == NONE || border.length > longest[region] {
                    (longest[region], neighbour[region]) = (border.length, other);
                }
            }
        }
        let mut sets = UnionFind::new(parent);
        for region in (0..count).filter(|r| small(area[*r], faces[*r] as usize) && neighbour[*r] != NONE) {
            sets.union(region as u32, neighbour[region]);
        }
        let left = sets.number();
        labels.iter_mut().for_each(|l| *l = parent[*l as usize]);
        if left == count {
            return Ok(count);
        }
        count = left;
    }
}

/// Joins neighbours whose mean `value` (area-weighted) differs by less than `apart`, the most alike first.
pub fn merge_alike(
    labels: &mut [u32],
    count: usize,
    dual: &Dual,
    value: &[f32], // (f)
    apart: f64,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let parent = scratch.take::<u32>(count)?;
    let area = scratch.take::<f64>(count)?;
    let sum = scratch.take::<f64>(count)?;
    for (f, label) in labels.iter().enumerate() {
        area[*label as usize] += dual.area[f];
        sum[*label as usize] += dual.area[f] * value[f] as f64;
    }
    let borders = borders(labels, dual, &mut scratch)?;
    let mut sets = UnionFind::new(parent);
    loop {
        let mut best: Option<(f64, [usize; 2])> = None;
        for border in &*borders {
            let [a, b] = border.regions.map(|r| sets.find(r) as usize);
            let apart = (sum[a] * area[b] - sum[b] * area[a]).abs() / (area[a] * area[b]);
            if a != b && best.is_none_or(|b| apart < b.0) {
                best = Some((apart, [a.min(b), a.max(b)]));
            }
        }
        let Some((difference, [kept, gone])) = best else { break };
        if difference.is_nan() || difference >= apart {
            break;
        }
        sets.union(kept as u32, gone as u32);
        area[kept] += area[gone];
        sum[kept] += sum[gone];
    }
    let count = sets.number();
    labels.iter_mut().for_each(|l| *l = parent[*l as usize]);
    Ok(count)
}

/// The borders between regions, one an edge of the dual graph sorted and summed by pair.
fn borders<'a>(labels: &[u32], dual: &Dual, scratch: &mut Scratch<'a>) -> Result<&'a mut [Border], ScratchTooSmall> {
    let crossing = |[a, b]: &[u32; 2]| labels[*a as usize] != labels[*b as usize];
    let count = dual.sides.iter().filter(|s| crossing(s)).count();
    let all = scratch.take::<Border>(count)?;
    let edges = dual.sides.iter().zip(dual.length).filter(|(s, _)| crossing(s));
    for (border, (sides, length)) in all.iter_mut().zip(edges) {
        let [a, b] = sides.map(|f| labels[f as usize]);
        *border = Border { regions: [a.min(b), a.max(b)], length: *length };
    }
    // Sums of lengths depend on their order: that of the lengths themselves, which no order of edges changes.
    sort::by(all, |a, b| a.regions.cmp(&b.regions).then(a.length.total_cmp(&b.length)));
    let mut kept = 0;
    for i in 0..count {
        if kept > 0 && all[kept - 1].regions == all[i].regions {
            all[kept - 1].length += all[i].length;
        } else {
            all[kept] = all[i];
            kept += 1;
        }
    }
    Ok(&mut all[..kept])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{vec, vec::Vec};

    /// A chain of faces, edge i between faces i and i + 1.
    fn chain<T>(faces: usize, run: impl FnOnce(&Dual, &mut Vec<u8>) -> T) -> T {
        let sides: Vec<[u32; 2]> = (1..faces as u32).map(|b| [b - 1, b]).collect();
        let (length, turn, area) = (vec![1.0; sides.len()], vec![0.0; sides.len()], vec![1.0; faces]);
        let mut bytes = vec![0; tidy_need(faces)];
        run(&Dual { sides: &sides, length: &length, turn: &turn, area: &area }, &mut bytes)
    }

    #[test]
    fn a_label_in_two_places_becomes_two() {
        let mut labels = [7, 7, 2, 7, 2];
        let count = chain(5, |dual, bytes| connected(&mut labels, dual, Scratch::new(bytes)).unwrap());
        assert_eq!((count, labels), (4, [0, 0, 1, 2, 3]));
    }

    #[test]
    fn small_regions_go_to_the_longest_border_and_one_alone_stays() {
        let mut labels = [0, 0, 0, 1, 2, 2];
        let count = chain(6, |dual, bytes| absorb(&mut labels, 3, dual, &|a, _| a < 3.0, Scratch::new(bytes)).unwrap());
        assert_eq!((count, labels), (1, [0; 6]));
        let mut labels = [0, 0];
        let count = chain(2, |dual, bytes| absorb(&mut labels, 1, dual, &|_, _| true, Scratch::new(bytes)).unwrap());
        assert_eq!((count, labels), (1, [0, 0]));
    }

    #[test]
    fn alike_neighbours_merge_and_unlike_ones_do_not() {
        let (mut labels, value) = ([0, 1, 1, 2], [0.1, 0.15, 0.15, 0.9]);
        let count =
            chain(4, |dual, bytes| merge_alike(&mut labels, 3, dual, &value, 0.1, Scratch::new(bytes)).unwrap());
        assert_eq!((count, labels), (2, [0, 0, 0, 1]));
    }

    #[test]
    fn a_face_among_others_follows_them() {
        // Face 0 has three neighbours 1, 2, 3.
        let mut twin = [NONE; 12];
        for i in 0..3 {
            (twin[i], twin[3 * (i + 1)]) = (3 * (i as u32 + 1), i as u32);
        }
        let mut bytes = vec![0; tidy_need(4)];
        let mut labels = [5, 1, 1, 5];
        majority(&mut labels, &twin, 1, Scratch::new(&mut bytes)).unwrap();
        assert_eq!(labels[0], 1);
    }

    #[test]
    fn too_little_memory_is_refused() {
        chain(4, |dual, _| {
            let mut bytes = [0; 8];
            assert!(connected(&mut [0; 4], dual, Scratch::new(&mut bytes)).is_err());
            assert!(absorb(&mut [0; 4], 1, dual, &|_, _| true, Scratch::new(&mut bytes)).is_err());
            assert!(merge_alike(&mut [0; 4], 1, dual, &[0.0; 4], 1.0, Scratch::new(&mut bytes)).is_err());
            assert!(majority(&mut [0; 4], &[NONE; 12], 1, Scratch::new(&mut bytes)).is_err());
        });
    }
}
