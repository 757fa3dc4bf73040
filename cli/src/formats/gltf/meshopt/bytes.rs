//! The codec of attributes: each byte of an item is a sum of differences, stored in as few bits as 16 of them need.
//!
//! Items come in blocks of at most 8192 bytes and 256 items. In a block the differences of byte k of all items stand
//! together, in groups of 16: a two-bit code a group says how many bits each takes; one with all bits set is an escape, its
//! byte follows behind the group. Version 1 has, for every four bytes, a control byte (raw, zero, or one of two sets of
//! codes) in each block, and a channel in the stream's tail that says whether differences are of bytes, of 16-bit words, or
//! rotated exclusive ors of 32-bit words. The tail begins with the first item's predecessor.

const GROUP: usize = 16;

/// The items of a stream; `stride` is a multiple of 4, 256 at the most.
pub(super) fn attributes(stream: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    let version = match stream.first()? {
        0xa0 => 0,
        0xa1 => 1,
        _ => return None,
    };
    let tail = if version == 0 { stride } else { stride + stride / 4 };
    let padded = tail.max(if version == 0 { 32 } else { 24 });
    let end = stream.len().checked_sub(padded).filter(|end| *end >= 1)?;
    let mut last = stream[stream.len() - tail..][..stride].to_vec();
    let channels = &stream[stream.len() - tail + stride..];
    let mut data = &stream[1..end];
    let mut out = vec![0; count * stride];
    let block = ((8192 / stride) & !(GROUP - 1)).min(256);
    for items in out.chunks_mut(block * stride) {
        let mut block = Block { data, count: items.len() / stride, version };
        let controls = if version == 0 { &[][..] } else { block.take(stride / 4)? };
        for k in (0..stride).step_by(4) {
            let control = controls.get(k / 4).copied().unwrap_or(0);
            let mut planes = [const { [0; 256] }; 4];
            for (j, plane) in planes.iter_mut().enumerate() {
                block.plane(plane, control >> (2 * j) & 3)?;
            }
            let channel = channels.get(k / 4).copied().unwrap_or(0);
            sum(items, k, stride, &planes, &mut last[k..k + 4], channel)?;
        }
        data = block.data;
    }
    data.is_empty().then_some(out)
}

/// The bytes of a block that are not read yet.
struct Block<'a> {
    data: &'a [u8],
    count: usize,
    version: u8,
}

impl<'a> Block<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.data.split_at_checked(n)?;
        self.data = rest;
        Some(head)
    }

    /// The differences of one byte of all items.
    fn plane(&mut self, plane: &mut [u8; 256], control: u8) -> Option<()> {
        let widths: &[u8] = match (self.version, control) {
            (0, _) => &[0, 2, 4, 8],
            (_, 0) => &[0, 1, 2, 4],
            (_, 1) => &[1, 2, 4, 8],
            (_, 2) => return Some(()),
            _ => return self.take(self.count).map(|raw| plane[..raw.len()].copy_from_slice(raw)),
        };
        let groups = self.count.div_ceil(GROUP);
        let head = self.take(groups.div_ceil(4))?;
        for (i, group) in plane.chunks_exact_mut(GROUP).take(groups).enumerate() {
            self.group(group, widths[usize::from(head[i / 4] >> (i % 4 * 2) & 3)])?;
        }
        Some(())
    }

    fn group(&mut self, group: &mut [u8], bits: u8) -> Option<()> {
        match bits {
            0 => group.fill(0),
            8 => group.copy_from_slice(self.take(GROUP)?),
            _ => {
                let packed = self.take(GROUP * usize::from(bits) / 8)?;
                let (a_byte, escape) = (usize::from(8 / bits), (1u8 << bits) - 1);
                for (i, value) in group.iter_mut().enumerate() {
                    let within = (i % a_byte) as u8;
                    // From the high bits down, but for single bits.
                    let shift = if bits == 1 { within } else { 8 - bits * (within + 1) };
                    let code = packed[i / a_byte] >> shift & escape;
                    *value = if code == escape { self.take(1)?[0] } else { code };
                }
            }
        }
        Some(())
    }
}

/// Adds the differences of bytes k to k + 3 up, beginning with `last`, where the last item's stay.
fn sum(items: &mut [u8], k: usize, stride: usize, planes: &[[u8; 256]; 4], last: &mut [u8], channel: u8) -> Option<()> {
    let unzigzag = |v: u32, bits: u32| (v >> 1 ^ (v & 1).wrapping_neg()) & (u32::MAX >> (32 - bits));
    let before = |last: &[u8], from: usize, n: usize| (0..n).fold(0, |w, j| w | u32::from(last[from + j]) << (8 * j));
    for (i, item) in items.chunks_exact_mut(stride).enumerate() {
        let word = |from: usize, n: usize| (0..n).fold(0, |w, j| w | u32::from(planes[from + j][i]) << (8 * j));
        let four: [u8; 4] = match channel & 3 {
            0 => core::array::from_fn(|j| last[j].wrapping_add(unzigzag(word(j, 1), 8) as u8)),
            1 => {
                let half = |j: usize| (unzigzag(word(j, 2), 16).wrapping_add(before(last, j, 2)) as u16).to_le_bytes();
                let [[a, b], [c, d]] = [half(0), half(2)];
                [a, b, c, d]
            }
            2 => (word(0, 4).rotate_right(u32::from(channel >> 4)) ^ before(last, 0, 4)).to_le_bytes(),
            _ => return None,
        };
        last.copy_from_slice(&four);
        item[k..k + 4].copy_from_slice(&four);
    }
    Some(())
}
