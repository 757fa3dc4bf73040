//! One compressed buffer view.
//!
//! The streams are those that the extension's text defines, of version 0 and, for attributes and triangles, 1. Decoded in
//! safe code of our own: the library that writes them is C++, its Rust bindings are unsafe where filters are concerned, and
//! reading takes a few hundred lines. Any bytes give a view or `None`; memory is bounded by what the stream can hold.

use super::super::document::Compressed;
use super::bytes::attributes;
use super::filters;
use super::indices::{sequence, triangles};

/// A byte of a stream stands for at most this many of the view: 16 zeros take two bits, in blocks of 256 items.
const MOST: usize = 64;

/// The bytes of a view, `count` items of `byteStride` bytes; `None` where the stream is damaged or of another kind.
pub fn decode(stream: &[u8], view: &Compressed) -> Option<Vec<u8>> {
    let Compressed { byte_stride: stride, count, .. } = *view;
    let plausible = stream.len().checked_mul(MOST)?.checked_add(4096 * 256)?;
    if count.checked_mul(stride)? > plausible {
        return None;
    }
    let mut out = match view.mode.as_str() {
        "ATTRIBUTES" if stride > 0 && stride <= 256 && stride % 4 == 0 => attributes(stream, count, stride)?,
        "TRIANGLES" if matches!(stride, 2 | 4) && count % 3 == 0 => words(triangles(stream, count)?, stride),
        "INDICES" if matches!(stride, 2 | 4) => words(sequence(stream, count)?, stride),
        _ => return None,
    };
    match (view.filter.as_deref(), stride) {
        (None | Some("NONE"), _) => {}
        (Some("OCTAHEDRAL"), 4 | 8) => filters::octahedral(&mut out, stride),
        (Some("QUATERNION"), 8) => filters::quaternion(&mut out),
        (Some("EXPONENTIAL"), _) => filters::exponential(&mut out),
        (Some("COLOR"), 4 | 8) => filters::colour(&mut out, stride),
        _ => return None,
    }
    Some(out)
}

/// Indices of two or four bytes.
fn words(indices: Vec<u32>, size: usize) -> Vec<u8> {
    indices.into_iter().flat_map(|i| i.to_le_bytes().into_iter().take(size)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use quickcheck::quickcheck;

    fn view(mode: &str, count: usize, byte_stride: usize, filter: Option<&str>) -> Compressed {
        let filter = filter.map(String::from);
        Compressed { buffer: 0, byte_offset: 0, byte_length: 0, byte_stride, count, mode: mode.into(), filter }
    }

    #[test]
    fn attributes_are_sums_of_their_differences() {
        // Three items of four bytes: the first byte rises by 1, the second falls by 1 from 9, the third is 200 apart, the last
        // stays 7. Bits of a difference and 16 of them a group: two bits, two bits, all eight, none.
        let two =
            |first: u8, three: [u8; 3]| [1, first << 6 | three[0] << 4 | three[1] << 2 | three[2], 0, 0, 0].to_vec();
        let mut stream = vec![0xa0];
        stream.extend(two(0, [2, 2, 0])); // 0, then +1, +1 (zigzag 2)
        stream.extend(two(0, [1, 1, 0])); // -1, -1
        stream.push(3);
        let mut raw = [0; 16];
        raw[1] = 111; // -56 in zigzag, which takes 0 to 200
        stream.extend(raw);
        stream.push(0);
        stream.extend([0; 28]); // the tail is 32 bytes, the first item at its end
        stream.extend([5, 9, 0, 7]);
        let out = decode(&stream, &view("ATTRIBUTES", 3, 4, None)).unwrap();
        assert_eq!(out, [5, 9, 0, 7, 6, 8, 200, 7, 7, 7, 200, 7]);
        assert_eq!(decode(&stream[..stream.len() - 1], &view("ATTRIBUTES", 3, 4, None)), None);
        assert_eq!(decode(&stream, &view("ATTRIBUTES", 300, 4, None)), None);
    }

    #[test]
    fn triangles_and_sequences_come_back() {
        // A quad: the first triangle by the table (code 0xf0, three new vertices), the second over its last edge.
        let stream = [[0xe1, 0xf0, 0x10].as_slice(), &[0; 16]].concat();
        let out = decode(&stream, &view("TRIANGLES", 6, 2, None)).unwrap();
        let indices: Vec<u16> = out.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
        assert_eq!(indices, [0, 1, 2, 2, 1, 3]);
        // Differences from one of two baselines: +3, +1 of the first, +500 of the second, -2 of the first.
        let stream = [0xd1, 12, 4, 0xd1, 0x0f, 6, 0, 0, 0, 0];
        let out = decode(&stream, &view("INDICES", 4, 4, None)).unwrap();
        let indices: Vec<u32> = out.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        assert_eq!(indices, [3, 4, 500, 2]);
    }

    #[test]
    fn what_is_of_another_kind_is_none() {
        assert_eq!(decode(&[0xa0; 64], &view("ATTRIBUTES", 1, 3, None)), None);
        assert_eq!(decode(&[0xa0; 64], &view("SOMETHING", 1, 4, None)), None);
        assert_eq!(decode(&[], &view("INDICES", usize::MAX, 4, None)), None);
    }

    quickcheck! {
        fn random_streams_never_panic(stream: Vec<u8>, head: u8, mode: u8, count: u16, stride: u8, filter: u8) -> bool {
            let mode = ["ATTRIBUTES", "TRIANGLES", "INDICES"][usize::from(mode) % 3];
            let filter = [None, Some("OCTAHEDRAL"), Some("QUATERNION"), Some("EXPONENTIAL"), Some("COLOR")][usize::from(filter) % 5];
            let head = [0xa0, 0xa1, 0xe0, 0xe1, 0xd0, 0xd1][usize::from(head) % 6];
            let stride = [2, 4, 8, 12, 16, 256][usize::from(stride) % 6];
            let count = usize::from(count) % 700;
            let stream = [vec![head], stream, vec![0; usize::from(head) % 64]].concat();
            let out = decode(&stream, &view(mode, count, stride, filter));
            out.is_none_or(|out| out.len() == count * stride)
        }
    }
}
