//! Items grouped by an integer key, by counting sort: O(keys + items), stable, no comparison.
//!
//! Inside a bucket items stand in increasing order until the caller sorts them otherwise.

use super::scratch::{Scratch, ScratchTooSmall, bytes_for};
use core::ops::Range;

/// Bytes that [`Buckets::new`] takes.
pub const fn buckets_need(keys: usize, items: usize) -> usize {
    bytes_for::<u32>(keys + 2).saturating_add(bytes_for::<u32>(items))
}

/// Items 0..n grouped by key.
pub struct Buckets<'a> {
    start: &'a mut [u32], // (keys + 2); bucket k is item[start[k]..start[k + 1]], the last entry is spare
    item: &'a mut [u32],  // (items)
}

impl<'a> Buckets<'a> {
    /// Groups items `0..items` by `key(item)`, below `keys`; an item whose key is `None` is left out.
    pub fn new(
        keys: usize,
        items: usize,
        key: impl Fn(u32) -> Option<u32>,
        scratch: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        scratch.require(buckets_need(keys, items))?;
        let start = scratch.take::<u32>(keys + 2)?;
        let item = scratch.take::<u32>(items)?;
        // Counts stand two places up, so that filling moves each bucket's end to where the next one starts.
        (0..items as u32).filter_map(&key).for_each(|k| start[k as usize + 2] += 1);
        for k in 2..start.len() {
            start[k] += start[k - 1];
        }
        for i in 0..items as u32 {
            if let Some(k) = key(i) {
                let end = &mut start[k as usize + 1];
                item[*end as usize] = i;
                *end += 1;
            }
        }
        Ok(Self { start, item })
    }

    /// Number of keys.
    pub fn key_count(&self) -> usize {
        self.start.len() - 2
    }

    fn range(&self, key: usize) -> Range<usize> {
        self.start[key] as usize..self.start[key + 1] as usize
    }

    /// The items of `key`.
    pub fn get(&self, key: usize) -> &[u32] {
        &self.item[self.range(key)]
    }

    /// The items of `key`, to be put in another order.
    pub fn get_mut(&mut self, key: usize) -> &mut [u32] {
        let range = self.range(key);
        &mut self.item[range]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    #[test]
    fn items_stand_under_their_key_in_order() {
        let keys = [2, 0, 9, 2, 0, 2]; // 9: left out
        let mut bytes = vec![0; buckets_need(3, 6)];
        let mut scratch = Scratch::new(&mut bytes);
        let buckets = Buckets::new(3, 6, |i| Some(keys[i as usize]).filter(|k| *k < 3), &mut scratch).unwrap();
        assert_eq!([0, 1, 2].map(|k| buckets.get(k)), [&[1, 4][..], &[], &[0, 3, 5]]);
        assert_eq!(buckets.key_count(), 3);
    }

    #[test]
    fn no_key_and_no_item_is_fine_and_one_byte_less_is_refused() {
        let mut bytes = vec![0; buckets_need(0, 0)];
        assert_eq!(Buckets::new(0, 0, Some, &mut Scratch::new(&mut bytes)).unwrap().key_count(), 0);
        let short = bytes.len() - 1;
        assert!(Buckets::new(0, 0, Some, &mut Scratch::new(&mut bytes[..short])).is_err());
    }
}
