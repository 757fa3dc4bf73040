//! Cheapest paths from all cuts and borders to all other vertices, side by side.
//!
//! A path that begins on a cut passes no other, so what lies between cuts is reached from its own rim alone: groups of such regions are
//! searched by tasks of their own. The outcome is that of one search ([`Paths::grow`]) from all vertices on cuts, bit by bit: cheaper vertices
//! are settled first, and of those that cost the same, the lower.
//! Cost: O(n log n).

use super::paths::Paths;
use super::surface::Surface;
use crate::base::heap::Heap;
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::take_first;
use crate::base::workers::{Workers, for_each_chunk};
use crate::mesh::view::NONE;

/// Groups of regions at the most.
const GROUPS: usize = 16;

/// The vertices of each group, and where they stand there.
struct Groups<'g> {
    list: &'g [u32], // (vertices off cuts) group after group, each ascending
    start: [usize; GROUPS + 1],
    place: &'g [u32], // (n) in the group
}

/// A group that is searched.
struct GroupJob<'j> {
    list: &'j [u32],
    cost: &'j mut [f64],
    via: &'j mut [u32],
    heap: Heap<'j>,
    order: &'j mut [u32],
    reached: usize,
    is_free: bool, // whether an edge from a cut costs nothing
}

/// Writes to `paths` what a search from all vertices that are `on_cut` finds, and lists the others that it reaches in an order in which each
/// stands behind those that its path comes through; returns how many there are. None where an edge at a cut costs nothing: then the order of
/// vertices on cuts matters.
pub fn grow_inland(
    paths: &mut Paths,
    order: &mut [u32],
    on_cut: &[u8],
    surface: &Surface,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<Option<usize>, ScratchTooSmall> {
    let groups = Groups::new(on_cut, surface, &mut scratch)?;
    let count = groups.list.len();
    let mut cost = scratch.take_filled::<f64>(count, f64::INFINITY)?;
    let mut via = scratch.take_filled::<u32>(count, NONE)?;
    let mut heaps = (scratch.take::<f64>(count)?, scratch.take::<u32>(count)?, scratch.take::<u32>(count)?);
    let mut jobs = heapless::Vec::<GroupJob, GROUPS>::new();
    let mut left = &mut *order;
    for range in groups.start.windows(2).map(|w| w[0]..w[1]).filter(|range| !range.is_empty()) {
        let len = range.len();
        let (costs, slots, items) = &mut heaps;
        jobs.put(GroupJob {
            list: &groups.list[range],
            cost: take_first(&mut cost, len),
            via: take_first(&mut via, len),
            heap: Heap::new(take_first(costs, len), take_first(slots, len), take_first(items, len)),
            order: take_first(&mut left, len),
            reached: 0,
            is_free: false,
        });
    }
    for_each_chunk(workers, &mut jobs, 1, &|_, jobs| {
        jobs.iter_mut().for_each(|job| job.grow(&groups, on_cut, surface))
    });
    if jobs.iter().any(|job| job.is_free) {
        return Ok(None);
    }
    for ((cost, via), on_cut) in paths.cost.iter_mut().zip(paths.via.iter_mut()).zip(on_cut) {
        (*cost, *via) = (if *on_cut != 0 { 0.0 } else { f64::INFINITY }, NONE);
    }
    let mut reached = heapless::Vec::<usize, GROUPS>::new();
    for job in jobs {
        for (v, (cost, via)) in job.list.iter().zip(job.cost.iter().zip(job.via.iter())) {
            (paths.cost[*v as usize], paths.via[*v as usize]) = (*cost, *via);
        }
        reached.put(job.reached);
    }
    let (mut from, mut to) = (0, 0);
    let lengths = groups.start.windows(2).map(|w| w[1] - w[0]).filter(|len| *len > 0);
    for (len, reached) in lengths.zip(reached) {
        (0..reached).for_each(|i| order[to + i] = order[from + i]);
        (from, to) = (from + len, to + reached);
    }
    Ok(Some(to))
}

impl<'g> Groups<'g> {
    /// Regions one after the other, each into the first group that is not full.
    fn new(on_cut: &[u8], surface: &Surface, keep: &mut Scratch<'g>) -> Result<Self, ScratchTooSmall> {
        let n = on_cut.len();
        let count = on_cut.iter().filter(|on_cut| **on_cut == 0).count();
        let (list, place) = (keep.take::<u32>(count)?, keep.take::<u32>(n)?);
        let mut start = [0; GROUPS + 1];
        let mut frame = keep.frame();
        let group = frame.take_filled::<u8>(n, u8::MAX)?;
        let (mut own, mut tail) = (0, 0);
        for seed in 0..n as u32 {
            if on_cut[seed as usize] != 0 || group[seed as usize] != u8::MAX {
                continue;
            }
            let mut head = tail;
            (list[tail], group[seed as usize]) = (seed, own as u8);
            tail += 1;
            while head < tail {
                for (_, w) in surface.edges_at(list[head]) {
                    if on_cut[w as usize] == 0 && group[w as usize] == u8::MAX {
                        (list[tail], group[w as usize]) = (w, own as u8);
                        tail += 1;
                    }
                }
                head += 1;
            }
            start[own + 1] = tail;
            // Each but the last holds more than its share.
            own += usize::from((tail - start[own]) * (GROUPS - 1) > count);
        }
        for k in 0..GROUPS {
            start[k + 1] = start[k + 1].max(start[k]);
        }
        let mut at = start;
        for (v, group) in (0..).zip(group.iter()).filter(|(_, group)| **group != u8::MAX) {
            let (at, start) = (&mut at[*group as usize], start[*group as usize]);
            list[*at] = v;
            place[v as usize] = (*at - start) as u32;
            *at += 1;
        }
        Ok(Self { list, start, place })
    }
}

impl GroupJob<'_> {
    fn grow(&mut self, groups: &Groups, on_cut: &[u8], surface: &Surface) {
        let Self { list, cost, via, heap, order, reached, is_free } = self;
        for (i, v) in list.iter().enumerate() {
            // Vertices on cuts are settled before all others, the lower first, and their edges in the order of their corners.
            let mut from = (NONE, NONE);
            for (c, w) in surface.edges_at(*v).filter(|(_, w)| on_cut[*w as usize] != 0) {
                let c = surface.twin[c as usize];
                let sum = surface.cost[c as usize];
                if sum < cost[i] || sum == cost[i] && (w, c) < from {
                    (cost[i], from) = (sum, (w, c));
                }
            }
            if cost[i] < f64::INFINITY {
                via[i] = from.1;
                heap.push(i as u32, cost[i]);
                *is_free |= cost[i] <= 0.0;
            }
        }
        while let Some((i, at)) = heap.pop() {
            let v = list[i as usize];
            order[*reached] = v;
            *reached += 1;
            for (c, w) in surface.edges_at(v).filter(|(_, w)| on_cut[*w as usize] == 0) {
                let (sum, j) = (at + surface.cost[c as usize], groups.place[w as usize]);
                if sum < cost[j as usize] {
                    cost[j as usize] = sum;
                    via[j as usize] = c;
                    heap.push(j, sum);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::surface_tests::on_surface;
    use super::*;
    use crate::base::random::unit_f64;
    use crate::base::workers::Serial;
    use crate::base::workers::tests::Backwards;
    use crate::mesh::view::{MeshView, next};
    use glam::DVec3;
    use std::{vec, vec::Vec};

    const SIDE: u32 = 24;

    /// Calls `then` with a sheet of squares whose costs are few, and with its vertices on the border and on some lines.
    fn on_sheet(least: f64, then: impl Fn(&Surface, &[u8], Scratch)) {
        let positions: Vec<DVec3> =
            (0..=SIDE).flat_map(|y| (0..=SIDE).map(move |x| DVec3::new(x.into(), y.into(), 0.0))).collect();
        let square = |v: u32| [[v, v + 1, v + SIDE + 2], [v, v + SIDE + 2, v + SIDE + 1]];
        let faces: Vec<[u32; 3]> =
            (0..SIDE).flat_map(|y| (0..SIDE).flat_map(move |x| square(y * (SIDE + 1) + x))).collect();
        // The same in both directions.
        let price = |mesh: MeshView, c: u32| {
            let middle = (mesh.position(c) + mesh.position(next(c))) * 24.0;
            least + (unit_f64(3, middle.x as u64, middle.y as u64) * 3.0).trunc()
        };
        on_surface(&positions, &faces, price, |surface, scratch| {
            let is_on_line = |p: &DVec3| p.x == 7.0 || p.y == 13.0 && p.x > 7.0 || p.x == 20.0 && p.y < 4.0;
            let on_cut: Vec<u8> = (0..positions.len())
                .map(|v| u8::from(surface.is_on_border(v as u32) || is_on_line(&positions[v])))
                .collect();
            then(surface, &on_cut, scratch);
        });
    }

    #[test]
    fn regions_side_by_side_are_reached_as_by_one_search() {
        on_sheet(1.0, |surface, on_cut, mut scratch| {
            let n = on_cut.len();
            let mut frame = scratch.frame();
            let mut one = Paths::new(n, &mut frame).unwrap();
            let sources = (0..n as u32).filter(|v| on_cut[*v as usize] != 0);
            one.grow(surface, sources, |c| surface.cost[c as usize], |_, _| {});
            for workers in [&Serial as &dyn Workers, &Backwards] {
                let mut frame = frame.frame();
                let mut paths = Paths::new(n, &mut frame).unwrap();
                let mut order = vec![0; n];
                let reached = grow_inland(&mut paths, &mut order, on_cut, surface, frame, workers).unwrap();
                assert_eq!(reached, Some(on_cut.iter().filter(|on_cut| **on_cut == 0).count()));
                assert_eq!(paths.cost, one.cost);
                assert_eq!(paths.via, one.via);
                let mut seen = on_cut.to_vec();
                for v in &order[..reached.unwrap()] {
                    assert!(paths.trace(surface, *v).all(|(_, w)| seen[w as usize] != 0));
                    seen[*v as usize] = 1;
                }
            }
        });
    }

    #[test]
    fn where_edges_at_cuts_are_free_or_memory_is_short_nothing_is_said() {
        on_sheet(0.0, |surface, on_cut, mut scratch| {
            let n = on_cut.len();
            let mut frame = scratch.frame();
            let (mut paths, mut order) = (Paths::new(n, &mut frame).unwrap(), vec![0; n]);
            assert_eq!(grow_inland(&mut paths, &mut order, on_cut, surface, frame.frame(), &Serial), Ok(None));
            let mut bytes = [0; 64];
            let short = Scratch::new(&mut bytes);
            assert!(grow_inland(&mut paths, &mut order, on_cut, surface, short, &Serial).is_err());
        });
    }
}
