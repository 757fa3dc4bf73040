//! What waits to be looked at: a stack on the machine's own, of a height that its user knows.
//!
//! One item beyond that height is an index outside of the items.

/// At most `N` items.
pub struct Stack<T, const N: usize> {
    items: [T; N],
    len: usize,
}

impl<T: Copy + Default, const N: usize> Stack<T, N> {
    /// Without items.
    #[inline]
    pub fn new() -> Self {
        Self { items: [T::default(); N], len: 0 }
    }

    /// Puts `item` on top.
    #[inline]
    pub fn push(&mut self, item: T) {
        self.items[self.len] = item;
        self.len += 1;
    }

    /// Takes the top off.
    #[inline]
    pub fn pop(&mut self) -> Option<T> {
        let below = self.len.checked_sub(1)?;
        self.len = below;
        Some(self.items[below])
    }
}

impl<T: Copy + Default, const N: usize> Default for Stack<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_in_is_the_first_out() {
        let mut stack = Stack::<u8, 2>::new();
        stack.push(1);
        stack.push(2);
        assert_eq!((stack.pop(), stack.pop(), stack.pop()), (Some(2), Some(1), None));
    }

    #[test]
    #[should_panic(expected = "index out of bounds")]
    fn one_too_many_is_out_of_bounds() {
        let mut stack = Stack::<u8, 1>::new();
        stack.push(1);
        stack.push(2);
    }
}
