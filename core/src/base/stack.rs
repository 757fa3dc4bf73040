//! What waits to be looked at: a stack on the machine's own, of a height that its user knows.
//!
//! One item beyond that height is an index outside of the items.

/// At most `N` items. Memory is not cleared for them: short walks make a stack each.
pub struct Stack<T, const N: usize> {
    items: heapless::Vec<T, N>,
}

impl<T: Copy, const N: usize> Stack<T, N> {
    /// Without items.
    #[inline]
    pub fn new() -> Self {
        Self { items: heapless::Vec::new() }
    }

    /// Puts `item` on top.
    #[inline]
    pub fn push(&mut self, item: T) {
        if let Err(item) = self.items.push(item) {
            self.items[N] = item;
        }
    }

    /// Takes the top off.
    #[inline]
    pub fn pop(&mut self) -> Option<T> {
        self.items.pop()
    }
}

impl<T: Copy, const N: usize> Default for Stack<T, N> {
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
