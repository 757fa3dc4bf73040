//! Minimum cut of a graph with a source and a sink: two search trees that grow towards each other.
//!
//! Boykov, Kolmogorov, *An experimental comparison of min-cut/max-flow algorithms for energy minimization in vision*, PAMI
//! 26, 2004, with time stamps on distances to keep paths short. Capacities are integers, so the flow is exact and the
//! end certain. On graphs of mesh faces time is near-linear; the proven worst case is not.
//! Limits: the sum of all capacities stays below 2^63.

use crate::base::buckets::{Buckets, buckets_need};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};

/// Parent of a node that hangs on its terminal.
const TERMINAL: u32 = u32::MAX;
/// Parent of a node that has lost its way to the terminal.
const ORPHAN: u32 = u32::MAX - 1;
/// No node in a list.
const END: u32 = u32::MAX;
/// Not in a list.
const OUTSIDE: u32 = u32::MAX - 1;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
enum FlowSide {
    Free = 0,
    Source = 1,
    Sink = 2,
}

/// A graph and the flow in it. Arc 2 e runs along edge e, arc 2 e + 1 back.
pub struct MaxFlow<'a> {
    edges: &'a [[u32; 2]],   // (m)
    out: Buckets<'a>,        // arcs by tail
    residual: &'a mut [i64], // (2 m) by arc
    terminal: &'a mut [i64], // (n) above 0: left from the source; below 0: left to the sink
    side: &'a mut [u8],      // (n)
    parent: &'a mut [u32],   // (n) arc to the parent, or TERMINAL, ORPHAN
    stamp: &'a mut [u32],    // (n) when `distance` was right
    distance: &'a mut [u32], // (n) to the terminal
    active: NodeQueue<'a>,
    orphans: NodeQueue<'a>,
    time: u32,
}

/// First in, first out, each node at most once.
struct NodeQueue<'a> {
    next: &'a mut [u32], // (n)
    first: u32,
    last: u32,
}

impl<'a> NodeQueue<'a> {
    fn new(nodes: usize, scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        Ok(Self { next: scratch.take_filled(nodes, OUTSIDE)?, first: END, last: END })
    }

    fn push(&mut self, node: u32) {
        if self.next[node as usize] == OUTSIDE {
            self.next[node as usize] = END;
            if self.first == END {
                self.first = node;
            } else {
                self.next[self.last as usize] = node;
            }
            self.last = node;
        }
    }

    fn pop(&mut self) -> Option<u32> {
        let node = self.first;
        (node != END).then(|| {
            self.first = core::mem::replace(&mut self.next[node as usize], OUTSIDE);
            node
        })
    }
}

/// Bytes that [`MaxFlow::new`] takes.
pub const fn max_flow_need(nodes: usize, edges: usize) -> usize {
    buckets_need(nodes, 2 * edges)
        + bytes_for::<i64>(2 * edges)
        + bytes_for::<i64>(nodes)
        + bytes_for::<u8>(nodes)
        + 5 * bytes_for::<u32>(nodes)
}

impl<'a> MaxFlow<'a> {
    /// A graph without capacities. `edges` name nodes below `nodes`; a loop carries nothing.
    pub fn new(nodes: usize, edges: &'a [[u32; 2]], scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        scratch.require(max_flow_need(nodes, edges.len()))?;
        let tail = |arc: u32| Some(edges[arc as usize / 2][arc as usize % 2]);
        Ok(Self {
            edges,
            out: Buckets::new(nodes, 2 * edges.len(), tail, scratch)?,
            residual: scratch.take(2 * edges.len())?,
            terminal: scratch.take(nodes)?,
            side: scratch.take(nodes)?,
            parent: scratch.take(nodes)?,
            stamp: scratch.take(nodes)?,
            distance: scratch.take(nodes)?,
            active: NodeQueue::new(nodes, scratch)?,
            orphans: NodeQueue::new(nodes, scratch)?,
            time: 0,
        })
    }

    /// Takes all capacities and flow away.
    pub fn clear(&mut self) {
        self.residual.fill(0);
        self.terminal.fill(0);
    }

    /// Adds to what the cut pays where `node` is on the sink's side; below 0: where it is on the source's.
    pub fn add_terminal(&mut self, node: u32, capacity: i64) {
        self.terminal[node as usize] += capacity;
    }

    /// Adds capacity, at least 0, along edge `edge` and back.
    pub fn add_edge(&mut self, edge: usize, along: i64, back: i64) {
        self.residual[2 * edge] += along;
        self.residual[2 * edge + 1] += back;
    }

    /// Whether the last cut left `node` on the source's side: the smallest such side of all minimum cuts.
    pub fn on_source_side(&self, node: u32) -> bool {
        self.side[node as usize] == FlowSide::Source as u8
    }

    fn head(&self, arc: u32) -> u32 {
        self.edges[arc as usize / 2][1 - arc as usize % 2]
    }

    /// What can still flow from the terminal's side to the other along `arc`, seen from a node of `side` at its tail.
    fn outward(&self, arc: u32, side: u8) -> i64 {
        self.residual[if side == FlowSide::Source as u8 { arc } else { arc ^ 1 } as usize]
    }

    /// Pushes as much flow as goes through; [`on_source_side`](Self::on_source_side) then tells the cut.
    pub fn solve(&mut self) {
        self.plant();
        let mut current = None;
        while let Some(node) = current.take().or_else(|| self.active.pop()) {
            if self.side[node as usize] == FlowSide::Free as u8 {
                continue;
            }
            if let Some(bridge) = self.grow(node) {
                self.time += 1;
                self.augment(bridge);
                while let Some(orphan) = self.orphans.pop() {
                    self.adopt(orphan);
                }
                current = Some(node);
            }
        }
    }

    /// Every node with a terminal's capacity becomes a root.
    fn plant(&mut self) {
        self.time = 0;
        self.stamp.fill(0);
        self.distance.fill(1);
        for node in 0..self.terminal.len() {
            let left = self.terminal[node];
            self.side[node] = match left {
                0 => FlowSide::Free,
                1.. => FlowSide::Source,
                _ => FlowSide::Sink,
            } as u8;
            self.parent[node] = TERMINAL;
            if left != 0 {
                self.active.push(node as u32);
            }
        }
    }

    /// Takes free neighbours into the node's tree; returns an arc from the source's tree to the sink's, if there is one.
    fn grow(&mut self, node: u32) -> Option<u32> {
        let side = self.side[node as usize];
        for i in 0..self.out.get(node as usize).len() {
            let arc = self.out.get(node as usize)[i];
            let other = self.head(arc) as usize;
            if self.outward(arc, side) == 0 {
                continue;
            }
            if self.side[other] == FlowSide::Free as u8 {
                self.side[other] = side;
                self.hang(other as u32, arc ^ 1, node);
                self.active.push(other as u32);
            } else if self.side[other] != side {
                return Some(if side == FlowSide::Source as u8 { arc } else { arc ^ 1 });
            } else if self.stamp[other] <= self.stamp[node as usize]
                && self.distance[other] > self.distance[node as usize] + 1
                && self.parent[other] < ORPHAN
            {
                self.hang(other as u32, arc ^ 1, node);
            }
        }
        None
    }

    fn hang(&mut self, node: u32, arc: u32, parent: u32) {
        self.parent[node as usize] = arc;
        self.stamp[node as usize] = self.stamp[parent as usize];
        self.distance[node as usize] = self.distance[parent as usize] + 1;
    }

    /// Saturates the path over `bridge`; nodes that lose their parent arc become orphans.
    fn augment(&mut self, bridge: u32) {
        let [from, to] = [self.head(bridge ^ 1), self.head(bridge)];
        let mut flow = self.residual[bridge as usize];
        for start in [from, to] {
            let mut node = start as usize;
            while self.parent[node] < ORPHAN {
                flow = flow.min(self.inward(node));
                node = self.head(self.parent[node]) as usize;
            }
            flow = flow.min(self.terminal[node].abs());
        }
        self.push_flow(bridge, flow);
        for start in [from, to] {
            let mut node = start as usize;
            while self.parent[node] < ORPHAN {
                let arc = self.parent[node];
                let above = self.head(arc) as usize;
                self.push_flow(if self.side[node] == FlowSide::Source as u8 { arc ^ 1 } else { arc }, flow);
                if self.inward(node) == 0 {
                    self.make_orphan(node as u32);
                }
                node = above;
            }
            self.terminal[node] -= flow * self.terminal[node].signum();
            if self.terminal[node] == 0 {
                self.make_orphan(node as u32);
            }
        }
    }

    fn push_flow(&mut self, arc: u32, flow: i64) {
        self.residual[arc as usize] -= flow;
        self.residual[arc as usize ^ 1] += flow;
    }

    /// What the arc between a node and its parent can still carry on the way from the source to the sink.
    fn inward(&self, node: usize) -> i64 {
        self.outward(self.parent[node] ^ 1, self.side[node])
    }

    fn make_orphan(&mut self, node: u32) {
        self.parent[node as usize] = ORPHAN;
        self.orphans.push(node);
    }

    /// Finds the orphan a new parent that hangs on the terminal, or sets it free and makes its children orphans.
    fn adopt(&mut self, orphan: u32) {
        let side = self.side[orphan as usize];
        let mut best: Option<(u32, u32)> = None; // (distance, arc)
        for i in 0..self.out.get(orphan as usize).len() {
            let arc = self.out.get(orphan as usize)[i];
            let other = self.head(arc);
            if self.side[other as usize] == side
                && self.outward(arc ^ 1, side) > 0
                && let Some(distance) = self.distance_to_terminal(other)
                && best.is_none_or(|b| distance < b.0)
            {
                best = Some((distance, arc));
            }
        }
        if let Some((distance, arc)) = best {
            self.parent[orphan as usize] = arc;
            self.stamp[orphan as usize] = self.time;
            self.distance[orphan as usize] = distance + 1;
            return;
        }
        for i in 0..self.out.get(orphan as usize).len() {
            let arc = self.out.get(orphan as usize)[i];
            let other = self.head(arc);
            if self.side[other as usize] == side {
                if self.outward(arc ^ 1, side) > 0 {
                    self.active.push(other);
                }
                if self.parent[other as usize] == arc ^ 1 {
                    self.make_orphan(other);
                }
            }
        }
        self.side[orphan as usize] = FlowSide::Free as u8;
    }

    /// Steps from `node` up to its terminal, or None where an orphan is on the way. Stamps the way, so that the next
    /// question ends early.
    fn distance_to_terminal(&mut self, node: u32) -> Option<u32> {
        let (mut at, mut steps) = (node as usize, 0);
        let top = loop {
            if self.stamp[at] == self.time {
                break self.distance[at];
            }
            match self.parent[at] {
                TERMINAL => {
                    self.stamp[at] = self.time;
                    self.distance[at] = 1;
                    break 1;
                }
                ORPHAN => return None,
                arc => at = self.head(arc) as usize,
            }
            steps += 1;
        };
        let mut left = top + steps;
        let total = left;
        at = node as usize;
        while self.stamp[at] != self.time {
            self.stamp[at] = self.time;
            self.distance[at] = left;
            left -= 1;
            at = self.head(self.parent[at]) as usize;
        }
        Some(total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quickcheck::quickcheck;
    use std::{vec, vec::Vec};

    /// What the cut that puts the nodes of `source` (bits) on the source's side costs.
    fn cost(source: u32, edges: &[[u32; 2]], capacity: &[(i64, i64)], terminal: &[i64]) -> i64 {
        let inside = |v: u32| source >> v & 1 == 1;
        let arcs = edges.iter().zip(capacity).map(|([a, b], (along, back))| match (inside(*a), inside(*b)) {
            (true, false) => *along,
            (false, true) => *back,
            _ => 0,
        });
        let ends = (0u32..).zip(terminal).map(|(v, t)| if inside(v) { (-t).max(0) } else { (*t).max(0) });
        arcs.sum::<i64>() + ends.sum::<i64>()
    }

    fn cut(edges: &[[u32; 2]], capacity: &[(i64, i64)], terminal: &[i64]) -> u32 {
        let mut bytes = vec![0; max_flow_need(terminal.len(), edges.len())];
        let mut scratch = Scratch::new(&mut bytes);
        let mut flow = MaxFlow::new(terminal.len(), edges, &mut scratch).unwrap();
        let mut found = [0; 2];
        for found in &mut found {
            flow.clear();
            (0..).zip(capacity).for_each(|(e, c)| flow.add_edge(e, c.0, c.1));
            (0..).zip(terminal).for_each(|(v, t)| flow.add_terminal(v, *t));
            flow.solve();
            *found = (0..terminal.len() as u32).map(|v| (flow.on_source_side(v) as u32) << v).sum();
        }
        assert_eq!(found[0], found[1], "a graph that is used again");
        found[0]
    }

    quickcheck! {
        fn the_cut_costs_as_little_as_any(terminal: Vec<i8>, list: Vec<(u8, u8, u8, u8)>) -> bool {
            let terminal: Vec<i64> = terminal.iter().take(9).map(|t| *t as i64).collect();
            if terminal.is_empty() {
                return true;
            }
            let n = terminal.len() as u8;
            let edges: Vec<[u32; 2]> = list.iter().map(|l| [(l.0 % n) as u32, (l.1 % n) as u32]).collect();
            let capacity: Vec<(i64, i64)> = list.iter().map(|l| (l.2 as i64 / 2, l.3 as i64 / 3)).collect();
            let least = (0..1 << n).map(|s| cost(s, &edges, &capacity, &terminal)).min();
            Some(cost(cut(&edges, &capacity, &terminal), &edges, &capacity, &terminal)) == least
        }
    }

    #[test]
    fn a_chain_is_cut_at_its_weakest_link() {
        let edges = [[0, 1], [1, 2], [3, 2]];
        assert_eq!(cut(&edges, &[(5, 5), (2, 9), (7, 7)], &[10, 0, 0, -10]), 0b0011);
        assert_eq!(cut(&edges, &[(5, 5), (9, 9), (7, 1)], &[10, 0, 0, -10]), 0b0111);
    }

    #[test]
    fn a_graph_without_edges_or_nodes_is_cut_at_its_terminals() {
        assert_eq!(cut(&[], &[], &[3, -3, 0]), 0b001);
        assert_eq!(cut(&[], &[], &[]), 0);
        assert_eq!(cut(&[[0, 0]], &[(5, 5)], &[1]), 1);
    }

    #[test]
    fn one_byte_less_is_refused() {
        let mut bytes = vec![0; max_flow_need(2, 1) - 1];
        assert!(MaxFlow::new(2, &[[0, 1]], &mut Scratch::new(&mut bytes)).is_err());
    }
}
