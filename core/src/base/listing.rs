//! Lists of numbers that each hold a number once.

/// Puts `item` at place `count` of the list unless it is there; `is_listed` has a flag for each number. Returns how many were put.
#[inline]
pub fn list_once(item: u32, is_listed: &mut [u8], list: &mut [u32], count: usize) -> usize {
    if core::mem::replace(&mut is_listed[item as usize], 1) != 0 {
        return 0;
    }
    list[count] = item;
    1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_listed_is_not_listed_again() {
        let (mut is_listed, mut list) = ([0; 4], [9; 3]);
        let mut count = 0;
        for item in [3, 1, 3, 3, 0, 1] {
            count += list_once(item, &mut is_listed, &mut list, count);
        }
        assert_eq!((count, list, is_listed), (3, [3, 1, 0], [1, 1, 0, 1]));
    }
}
