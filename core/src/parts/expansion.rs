//! Labels of least energy by alpha-expansion: every move lets all faces choose between their label and one other, at once
//! and exactly.
//!
//! E = sum over f of data(f, l_f) + sum over edges of weight_e [l differs], all integers (fixed point, [`UNIT`] to one).
//! A move is a minimum cut: source's side keeps, sink's side takes the label (Boykov, Veksler, Zabih, *Fast approximate
//! energy minimization via graph cuts*, PAMI 23, 2001; the edge's four costs as one arc and two terminals after
//! Kolmogorov, Zabih, *What energy functions can be minimized via graph cuts?*, PAMI 26, 2004). The energy never rises,
//! and at the end no expansion lowers it; it is then within a factor of two of the least. With two labels the first
//! round from one label is exact.

use super::max_flow::{MaxFlow, max_flow_need};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;

/// Fixed-point units to one. Costs go up to 1e4 for each of 1e7 faces: 2^57 in all.
pub const UNIT: f64 = 1_048_576.0;
/// A cost that no minimum pays unless it must, low enough for the sum over all faces to fit 63 bits.
pub const FORBIDDEN: i64 = 1 << 38;

/// A cost in fixed point, from 0 to [`FORBIDDEN`]; NaN gives 0.
pub fn fixed(cost: f64) -> i64 {
    ((cost * UNIT) as i64).clamp(0, FORBIDDEN)
}

/// What a labelling costs.
pub struct Energy<'a> {
    /// Pairs of faces.
    pub edges: &'a [[u32; 2]], // (m)
    /// Paid where the two labels differ; at least 0.
    pub weight: &'a [i64], // (m)
    /// Paid by a face for a label, 0 to [`FORBIDDEN`].
    pub data: &'a dyn Fn(u32, u32) -> i64,
}

impl Energy<'_> {
    /// The energy of `labels`.
    pub fn of(&self, labels: &[u32]) -> i64 {
        let data = labels.iter().enumerate().map(|(f, l)| (self.data)(f as u32, *l));
        let cut = self.edges.iter().zip(self.weight).map(|(e, w)| {
            let [a, b] = e.map(|f| labels[f as usize]);
            if a == b { 0 } else { *w }
        });
        data.sum::<i64>() + cut.sum::<i64>()
    }
}

/// Bytes that [`expand`] takes.
pub const fn expand_need(faces: usize, edges: usize) -> usize {
    max_flow_need(faces, edges) + bytes_for::<u32>(faces)
}

/// Lowers the energy of `labels` by expansions of the labels 0..count in turn, until a whole round changes nothing or
/// `rounds` are done. Returns the energy.
pub fn expand<'a>(
    labels: &mut [u32], // (f)
    energy: &Energy<'a>,
    count: u32,
    rounds: usize,
    mut scratch: Scratch<'a>,
) -> Result<i64, ScratchTooSmall> {
    scratch.require(expand_need(labels.len(), energy.edges.len()))?;
    let moved = scratch.take::<u32>(labels.len())?;
    let mut flow = MaxFlow::new(labels.len(), energy.edges, &mut scratch)?;
    let mut least = energy.of(labels);
    let mut idle = 0; // labels in a row that changed nothing
    for label in (0..rounds).flat_map(|_| 0..count) {
        build(&mut flow, labels, energy, label);
        flow.solve();
        for (f, moved) in moved.iter_mut().enumerate() {
            *moved = if flow.on_source_side(f as u32) { labels[f] } else { label };
        }
        let reached = energy.of(moved);
        idle += 1;
        if reached < least {
            labels.copy_from(moved);
            (least, idle) = (reached, 0);
        }
        if idle >= count {
            break;
        }
    }
    Ok(least)
}

/// The graph whose cut costs what the move costs, but for a constant.
fn build(flow: &mut MaxFlow, labels: &[u32], energy: &Energy, label: u32) {
    flow.clear();
    for (f, own) in labels.iter().enumerate() {
        let f = f as u32;
        // Paid on the sink's side: `label`; on the source's: the own label.
        flow.add_terminal(f, (energy.data)(f, label) - (energy.data)(f, *own));
    }
    for (e, (&[p, q], &weight)) in energy.edges.iter().zip(energy.weight).enumerate() {
        let [a, b] = [labels[p as usize], labels[q as usize]];
        let cost = |differ: bool| if differ { weight } else { 0 };
        let (stay, q_takes, p_takes) = (cost(a != b), cost(a != label), cost(b != label));
        flow.add_terminal(p, p_takes - stay);
        flow.add_terminal(q, -p_takes);
        flow.add_edge(e, q_takes + p_takes - stay, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quickcheck::quickcheck;
    use std::{vec, vec::Vec};

    fn run(labels: &mut [u32], energy: &Energy, count: u32, rounds: usize) -> i64 {
        let mut bytes = vec![0; expand_need(labels.len(), energy.edges.len())];
        expand(labels, energy, count, rounds, Scratch::new(&mut bytes)).unwrap()
    }

    /// Data costs and a graph out of whatever quickcheck gives.
    fn case(data: &[u8], list: &[(u8, u8, u8)], count: usize) -> (usize, Vec<[u32; 2]>, Vec<i64>) {
        let faces = (data.len() / count).min(6);
        let n = faces.max(1) as u8;
        let edges = list.iter().map(|l| [(l.0 % n) as u32, (l.1 % n) as u32]).collect();
        (faces, edges, list.iter().map(|l| l.2 as i64).collect())
    }

    quickcheck! {
        fn the_energy_never_rises_and_ends_within_twice_the_least(data: Vec<u8>, list: Vec<(u8, u8, u8)>) -> bool {
            let (faces, edges, weight) = case(&data, &list, 3);
            if faces == 0 {
                return true;
            }
            let cost = |f: u32, l: u32| data[(3 * f + l) as usize] as i64;
            let energy = Energy { edges: &edges, weight: &weight, data: &cost };
            let all = (0..3u32.pow(faces as u32)).map(|code| {
                let labels: Vec<u32> = (0..faces as u32).map(|f| code / 3u32.pow(f) % 3).collect();
                energy.of(&labels)
            });
            let least = all.min().unwrap();
            let mut labels = vec![0; faces];
            let mut last = energy.of(&labels);
            for _ in 0..9 {
                let now = run(&mut labels, &energy, 3, 1);
                if now > last || now != energy.of(&labels) {
                    return false;
                }
                last = now;
            }
            last <= 2 * least
        }

        fn with_two_labels_the_first_round_is_exact(data: Vec<u8>, list: Vec<(u8, u8, u8)>) -> bool {
            let (faces, edges, weight) = case(&data, &list, 2);
            let cost = |f: u32, l: u32| data[(2 * f + l) as usize] as i64;
            let energy = Energy { edges: &edges, weight: &weight, data: &cost };
            if faces == 0 {
                return true;
            }
            let all = (0..1u32 << faces).map(|code| {
                energy.of(&(0..faces).map(|f| code >> f & 1).collect::<Vec<u32>>())
            });
            run(&mut vec![0; faces], &energy, 2, 1) == all.min().unwrap()
        }
    }

    #[test]
    fn a_strong_edge_carries_a_label_to_a_face_without_opinion() {
        let cost = |f: u32, l: u32| [[0, 9], [0, 0], [9, 0]][f as usize][l as usize];
        let energy = Energy { edges: &[[0, 1], [1, 2]], weight: &[1, 2], data: &cost };
        let mut labels = [0, 0, 0];
        assert_eq!(run(&mut labels, &energy, 2, 4), 1);
        assert_eq!(labels, [0, 1, 1]);
    }

    #[test]
    fn no_faces_and_no_labels_cost_nothing_and_one_byte_less_is_refused() {
        let energy = Energy { edges: &[], weight: &[], data: &|_, _| 5 };
        assert_eq!(run(&mut [], &energy, 3, 2), 0);
        assert_eq!(run(&mut [0], &energy, 0, 2), 5);
        let mut bytes = vec![0; expand_need(1, 0) - 1];
        assert!(expand(&mut [0], &energy, 1, 1, Scratch::new(&mut bytes)).is_err());
    }

    #[test]
    fn fixed_point_is_clamped_and_nan_costs_nothing() {
        assert_eq!([fixed(1.0), fixed(-1.0), fixed(f64::NAN)], [UNIT as i64, 0, 0]);
        assert_eq!(fixed(f64::INFINITY), FORBIDDEN);
    }
}
