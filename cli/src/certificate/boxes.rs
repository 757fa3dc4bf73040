//! Boxes in a tree, to find those that meet. O(n log n) for the tree; a question costs about as many steps as it has answers.

use glam::DVec2;

/// Boxes below one node that is not split further.
const FEW: usize = 4;

/// An axis-aligned box: its least and its greatest corner.
pub(super) type Bounds = [DVec2; 2];

/// The box of some points.
pub(super) fn around(points: &[DVec2]) -> Bounds {
    let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    points.iter().fold(none, |[low, high], p| [low.min(*p), high.max(*p)])
}

fn both(a: Bounds, b: Bounds) -> Bounds {
    [a[0].min(b[0]), a[1].max(b[1])]
}

fn meet(a: Bounds, b: Bounds) -> bool {
    a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all()
}

struct BoxNode {
    bounds: Bounds,
    /// Boxes below it: a run of the order.
    run: core::ops::Range<usize>,
    /// The second of two nodes below it; the first is the next one. 0: none.
    second: usize,
}

/// Boxes, halved again and again along the longer side.
pub(super) struct BoxTree<'a> {
    boxes: &'a [Bounds],
    order: Vec<u32>,
    nodes: Vec<BoxNode>,
}

impl<'a> BoxTree<'a> {
    /// A tree over `boxes`.
    pub fn new(boxes: &'a [Bounds]) -> Self {
        let mut tree = Self { boxes, order: (0..boxes.len() as u32).collect(), nodes: Vec::new() };
        if boxes.is_empty() {
            return tree;
        }
        // Runs to split, and the node whose second half they are.
        let mut left = vec![(0..boxes.len(), usize::MAX)];
        while let Some((run, parent)) = left.pop() {
            let here = tree.nodes.len();
            if let Some(parent) = tree.nodes.get_mut(parent) {
                parent.second = here;
            }
            let of = |i: &u32| boxes[*i as usize];
            let bounds = tree.order[run.clone()].iter().map(of).reduce(both).unwrap_or([DVec2::ZERO; 2]);
            tree.nodes.push(BoxNode { bounds, run: run.clone(), second: 0 });
            if run.len() <= FEW {
                continue;
            }
            let sides = bounds[1] - bounds[0];
            let middle = |i: &u32| {
                let [low, high] = of(i);
                if sides.x >= sides.y { low.x + high.x } else { low.y + high.y }
            };
            let half = run.len() / 2;
            tree.order[run.clone()].select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)).then(a.cmp(b)));
            left.push((run.start + half..run.end, here));
            left.push((run.start..run.start + half, usize::MAX));
        }
        tree
    }

    /// Calls `found` with every box that meets `bounds`, touching ones too, until it says that this is enough.
    pub fn each(&self, bounds: Bounds, mut found: impl FnMut(usize) -> bool) {
        let mut stack = vec![0];
        while let Some(at) = stack.pop() {
            let Some(node) = self.nodes.get(at).filter(|node| meet(node.bounds, bounds)) else { continue };
            if node.second > 0 {
                stack.extend([node.second, at + 1]);
                continue;
            }
            for i in &self.order[node.run.clone()] {
                if meet(self.boxes[*i as usize], bounds) && found(*i as usize) {
                    return;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_boxes_that_meet_are_found_and_no_others() {
        let at = |i: usize| DVec2::new((i * 37 % 101) as f64, (i * 53 % 97) as f64);
        let boxes: Vec<Bounds> = (0..200).map(|i| [at(i), at(i) + DVec2::splat((i % 7) as f64)]).collect();
        let tree = BoxTree::new(&boxes);
        for a in &boxes {
            let mut found = Vec::new();
            tree.each(*a, |i| {
                found.push(i);
                false
            });
            found.sort_unstable();
            let expected: Vec<usize> = (0..200).filter(|i| meet(boxes[*i], *a)).collect();
            assert_eq!(found, expected);
        }
        BoxTree::new(&[]).each([DVec2::ZERO; 2], |_| unreachable!());
    }
}
