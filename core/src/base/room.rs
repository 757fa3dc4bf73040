//! Lists of a room that their user knows: they are large enough by themselves.
//!
//! An item for which there is no room is a mistake of our own code: debug builds stop there, others leave it out.

/// Puts items where there is room.
pub trait Room<T> {
    /// Puts `item` behind the others.
    fn put(&mut self, item: T);
}

impl<T, const N: usize> Room<T> for heapless::Vec<T, N> {
    #[inline]
    fn put(&mut self, item: T) {
        let is_in = self.push(item).is_ok();
        debug_assert!(is_in, "a list of {N} items has room for no more");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_stand_in_the_order_in_which_they_came() {
        let mut list = heapless::Vec::<u8, 2>::new();
        list.put(3);
        list.put(1);
        assert_eq!(list, [3, 1]);
    }

    #[test]
    #[cfg(debug_assertions)]
    #[should_panic(expected = "room for no more")]
    fn one_too_many_is_a_mistake() {
        heapless::Vec::<u8, 0>::new().put(1);
    }
}
