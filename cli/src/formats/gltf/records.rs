//! Vertex data of a pool with some vertices copied: what was interleaved stays interleaved.

use super::numbers::Layout;

/// Bytes that become a buffer view.
#[derive(Debug, Default, PartialEq)]
pub(super) struct NewView {
    pub bytes: Vec<u8>,
    /// From one item to the next, where it must be said.
    pub stride: Option<usize>,
    /// What it is for, in the codes of the format: vertices or indices; 0 for neither.
    pub target: u32,
}

/// The code of a view of vertices.
pub(super) const VERTICES: u32 = 34962;
/// The code of a view of indices.
pub(super) const INDICES: u32 = 34963;

/// An accessor that is written again.
pub(super) struct Member<'a> {
    /// The accessor of the file, and its number in the new one.
    pub accessor: usize,
    /// See `accessor`.
    pub becomes: usize,
    /// The view of the file.
    pub view: usize,
    pub layout: Layout<'a>,
}

/// Accessors that lie in one another's gaps, or one alone.
pub(super) struct Record<'a> {
    pub members: Vec<Member<'a>>,
    base: usize,
    stride: usize,
}

/// Sorts accessors into records.
pub(super) fn records(mut members: Vec<Member>) -> Vec<Record> {
    members.sort_by_key(|m| (m.view, m.layout.stride, m.layout.start, m.accessor));
    let mut records: Vec<Record> = Vec::new();
    for member in members {
        let (view, layout) = (member.view, &member.layout);
        let joins = records.last_mut().filter(|record| {
            let first = &record.members[0];
            let fits = layout.start + layout.size <= record.base + record.stride;
            first.view == view && record.stride == layout.stride && fits
        });
        match joins {
            Some(record) => record.members.push(member),
            None => {
                let (base, stride) = (layout.start, layout.stride);
                records.push(Record { members: vec![member], base, stride });
            }
        }
    }
    records
}

impl Record<'_> {
    /// Bytes from one item to the next once it is written: alone an accessor needs no gaps.
    fn new_stride(&self) -> usize {
        match &self.members[..] {
            [alone] => alone.layout.size.next_multiple_of(4),
            _ => self.stride.next_multiple_of(4),
        }
    }

    /// Where a member's item begins in the new record.
    pub fn offset(&self, member: &Member) -> usize {
        member.layout.start - self.base
    }

    /// The record of each of `count` vertices, then of those that `copies` name.
    pub fn view(&self, count: usize, copies: &[u32]) -> NewView {
        let stride = self.new_stride();
        let bytes = self.members[0].layout.bytes.unwrap_or_default();
        let used = if self.members.len() == 1 { self.members[0].layout.size } else { self.stride };
        let mut out = Vec::with_capacity((count + copies.len()) * stride);
        let vertices = (0..count).chain(copies.iter().map(|v| *v as usize));
        for start in vertices.map(|v| self.base + v * self.stride) {
            // The last record may lack what stands behind its last member.
            let end = (start + used).min(bytes.len());
            out.extend(&bytes[start..end]);
            out.resize(out.len().next_multiple_of(stride), 0);
        }
        let is_tight = self.members.len() == 1 && stride == self.members[0].layout.size;
        NewView { bytes: out, stride: (!is_tight).then_some(stride), target: VERTICES }
    }
}

#[cfg(test)]
mod tests {
    use super::super::numbers::ComponentType;
    use super::*;

    fn member(accessor: usize, bytes: &[u8], start: usize, size: usize, stride: usize) -> Member<'_> {
        let layout = Layout { kind: ComponentType::U8, width: size, size, stride, start, bytes: Some(bytes) };
        Member { accessor, becomes: accessor, view: 0, layout }
    }

    #[test]
    fn interleaved_items_stay_so_and_a_lone_one_is_packed() {
        // Records of 8 bytes: 3, then 4; the last one ends early. Behind the two accessors another lies alone.
        let bytes: Vec<u8> = (0..23).collect();
        let made = records(vec![member(1, &bytes, 4, 4, 8), member(0, &bytes, 0, 3, 8)]);
        assert_eq!(made.len(), 1);
        assert_eq!(made[0].members.iter().map(|m| made[0].offset(m)).collect::<Vec<_>>(), [0, 4]);
        let view = made[0].view(2, &[0]);
        assert_eq!(view.stride, Some(8));
        assert_eq!(view.bytes, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(made[0].view(3, &[]).bytes[16..], [16, 17, 18, 19, 20, 21, 22, 0]);
        let alone = &records(vec![member(0, &bytes, 0, 3, 8)])[0];
        let view = alone.view(2, &[1]);
        assert_eq!((view.stride, &view.bytes[..]), (Some(4), &[0, 1, 2, 0, 8, 9, 10, 0, 8, 9, 10, 0][..]));
        assert_eq!(records(vec![member(0, &bytes, 0, 4, 4)])[0].view(2, &[]).stride, None);
    }
}
