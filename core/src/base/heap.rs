//! Binary min-heap of (cost, item) over caller's memory, with decrease-key by item.
//!
//! Ties go to the lower item, so the order of pops does not depend on the order of pushes.

const ABSENT: u32 = u32::MAX;

/// A heap over items 0..n; `slot[item]` is where the item stands.
pub struct Heap<'a> {
    cost: &'a mut [f64], // (n) by item
    slot: &'a mut [u32], // (n) by item
    item: &'a mut [u32], // (n) by slot
    len: usize,
}

impl<'a> Heap<'a> {
    /// An empty heap; the three slices have one entry an item.
    pub fn new(cost: &'a mut [f64], slot: &'a mut [u32], item: &'a mut [u32]) -> Self {
        slot.fill(ABSENT);
        Self { cost, slot, item, len: 0 }
    }

    /// Puts `item` in, or lowers its cost; a cost that is not lower changes nothing.
    pub fn push(&mut self, item: u32, cost: f64) {
        let at = self.slot[item as usize];
        if at == ABSENT {
            self.cost[item as usize] = cost;
            self.item[self.len] = item;
            self.slot[item as usize] = self.len as u32;
            self.len += 1;
            self.up(self.len - 1);
        } else if cost < self.cost[item as usize] {
            self.cost[item as usize] = cost;
            self.up(at as usize);
        }
    }

    /// Takes the cheapest item out.
    pub fn pop(&mut self) -> Option<(u32, f64)> {
        if self.len == 0 {
            return None;
        }
        let top = self.item[0];
        self.len -= 1;
        self.slot[top as usize] = ABSENT;
        if self.len > 0 {
            self.item[0] = self.item[self.len];
            self.slot[self.item[0] as usize] = 0;
            self.down(0);
        }
        Some((top, self.cost[top as usize]))
    }

    fn before(&self, a: u32, b: u32) -> bool {
        self.cost[a as usize].total_cmp(&self.cost[b as usize]).then(a.cmp(&b)).is_lt()
    }

    fn swap(&mut self, i: usize, j: usize) {
        self.item.swap(i, j);
        self.slot[self.item[i] as usize] = i as u32;
        self.slot[self.item[j] as usize] = j as u32;
    }

    fn up(&mut self, mut i: usize) {
        while i > 0 && self.before(self.item[i], self.item[(i - 1) / 2]) {
            self.swap(i, (i - 1) / 2);
            i = (i - 1) / 2;
        }
    }

    fn down(&mut self, mut i: usize) {
        loop {
            let (left, right) = (2 * i + 1, 2 * i + 2);
            let mut least = i;
            if left < self.len && self.before(self.item[left], self.item[least]) {
                least = left;
            }
            if right < self.len && self.before(self.item[right], self.item[least]) {
                least = right;
            }
            if least == i {
                return;
            }
            self.swap(i, least);
            i = least;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_leave_in_order_of_cost_then_index() {
        let (mut cost, mut slot, mut item) = ([0.0; 6], [0; 6], [0; 6]);
        let mut heap = Heap::new(&mut cost, &mut slot, &mut item);
        for (i, c) in [(5, 1.0), (3, 2.0), (0, 4.0), (2, 1.0), (4, 9.0)] {
            heap.push(i, c);
        }
        heap.push(4, 0.5);
        heap.push(3, 3.0);
        let order: std::vec::Vec<_> = core::iter::from_fn(|| heap.pop()).collect();
        assert_eq!(order, [(4, 0.5), (2, 1.0), (5, 1.0), (3, 2.0), (0, 4.0)]);
    }
}
