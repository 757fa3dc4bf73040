//! Disjoint sets over caller's memory: union by index, path halving.

/// Sets over 0..parent.len().
pub struct UnionFind<'a> {
    parent: &'a mut [u32],
}

impl<'a> UnionFind<'a> {
    /// Every element alone.
    pub fn new(parent: &'a mut [u32]) -> Self {
        parent.iter_mut().enumerate().for_each(|(i, p)| *p = i as u32);
        Self { parent }
    }

    /// The smallest element of the set that holds `x`.
    pub fn find(&mut self, x: u32) -> u32 {
        let mut x = x as usize;
        while self.parent[x] as usize != x {
            self.parent[x] = self.parent[self.parent[x] as usize];
            x = self.parent[x] as usize;
        }
        x as u32
    }

    /// Joins two sets; false when they were one already. The smaller root stays root.
    pub fn union(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
        a != b
    }

    /// Replaces each entry of the memory by the number of its set, in order of smallest members; returns how many.
    pub fn number(mut self) -> usize {
        for x in 0..self.parent.len() {
            self.parent[x] = self.find(x as u32);
        }
        let mut count = 0;
        for x in 0..self.parent.len() {
            let root = self.parent[x] as usize;
            // A root comes before its members and already holds its number when they are seen.
            self.parent[x] = if root == x { count } else { self.parent[root] };
            count += u32::from(root == x);
        }
        count as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_elements_share_their_smallest_member() {
        let mut parent = [0; 6];
        let mut sets = UnionFind::new(&mut parent);
        assert!(sets.union(4, 2) && sets.union(2, 5) && !sets.union(5, 4));
        assert_eq!([0, 1, 2, 3, 4, 5].map(|x| sets.find(x)), [0, 1, 2, 3, 2, 2]);
        assert_eq!(sets.number(), 4);
        assert_eq!(parent, [0, 1, 2, 3, 2, 2]);
    }
}
