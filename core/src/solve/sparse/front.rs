//! A front of the elimination: which nodes it eliminates, which it updates, and how many values that takes.

use bytemuck::{Pod, Zeroable};

/// One front: `count` nodes are eliminated, `border_len` later nodes are updated.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct Front {
    /// First value of its columns in the factor, or in that of its bough where those are not kept.
    pub(super) factor: u64,
    pub(super) first: u32, // first position in elimination order
    pub(super) count: u32,
    pub(super) border: u32, // first entry in the list of border positions
    pub(super) border_len: u32,
    pub(super) children: u32,
    pub(super) leftmost: u32, // first front of the subtree that this one is the root of
}

impl Front {
    /// Unknowns of the front.
    pub(super) fn size(&self) -> usize {
        2 * (self.count + self.border_len) as usize
    }

    /// Unknowns that it eliminates.
    pub(super) fn own(&self) -> usize {
        2 * self.count as usize
    }

    /// Values of its columns, each from the diagonal down.
    pub(super) fn column_len(&self) -> usize {
        let (m, own) = (self.size(), self.own());
        own * m - own * own.saturating_sub(1) / 2
    }

    /// Values of its update: the lower triangle by columns, and the right-hand side.
    pub(super) fn update_len(&self) -> usize {
        let side = 2 * self.border_len as usize;
        side * (side + 3) / 2
    }

    /// Places of its border in the list of all.
    pub(super) fn border_range(&self) -> core::ops::Range<usize> {
        self.border as usize..(self.border + self.border_len) as usize
    }
}
