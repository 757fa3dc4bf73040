//! What is made of decompressed numbers: unit vectors, rotations, floats with few bits, colours.
//!
//! Rounding is half away from zero, as the extension's text wants it; results are within one unit of any decoder's.

/// Numbers of a filter, one or two bytes each.
fn each_four(bytes: &mut [u8], size: usize, turn: impl Fn([i32; 4]) -> [i32; 4]) {
    for item in bytes.chunks_exact_mut(4 * size) {
        let word = |i: usize| match size {
            1 => i32::from(item[i] as i8),
            _ => i32::from(i16::from_le_bytes([item[2 * i], item[2 * i + 1]])),
        };
        let four = turn([0, 1, 2, 3].map(word));
        for (place, x) in item.chunks_exact_mut(size).zip(four) {
            place.copy_from_slice(&x.to_le_bytes()[..size]);
        }
    }
}

fn rounded(x: f32) -> i32 {
    (x + if x >= 0.0 { 0.5 } else { -0.5 }) as i32
}

/// Unit vectors from two coordinates of an octahedron; the third number is what 1 is stored as, the fourth stays.
pub(super) fn octahedral(bytes: &mut [u8], stride: usize) {
    let size = stride / 4;
    let most = if size == 1 { 127.0 } else { 32767.0 };
    each_four(bytes, size, |[x, y, one, rest]| {
        let (x, y) = (x as f32, y as f32);
        let z = one as f32 - x.abs() - y.abs();
        let fold = z.min(0.0); // the lower half is folded over the edges
        let (x, y) = (x + if x >= 0.0 { fold } else { -fold }, y + if y >= 0.0 { fold } else { -fold });
        let scale = most / (x * x + y * y + z * z).sqrt();
        [rounded(x * scale), rounded(y * scale), rounded(z * scale), rest]
    });
}

/// Rotations from their three smallest parts; the last number's low bits say which is missing, the others what 1 is.
pub(super) fn quaternion(bytes: &mut [u8]) {
    each_four(bytes, 2, |[x, y, z, last]| {
        let one = (last | 3) as f32;
        let scale = 32767.0 / core::f32::consts::SQRT_2 / one;
        let (x, y, z) = (x as f32, y as f32, z as f32);
        let w = (one * one * 2.0 - x * x - y * y - z * z).max(0.0).sqrt();
        let parts = [rounded(w * scale), rounded(x * scale), rounded(y * scale), rounded(z * scale)];
        let missing = (last & 3) as usize;
        core::array::from_fn(|i| parts[(i + 4 - missing) & 3])
    });
}

/// Floats from an 8-bit exponent and a 24-bit mantissa.
pub(super) fn exponential(bytes: &mut [u8]) {
    for word in bytes.chunks_exact_mut(4) {
        let v = i32::from_le_bytes([word[0], word[1], word[2], word[3]]);
        let scale = f32::from_bits((((v >> 24) + 127) as u32) << 23);
        word.copy_from_slice(&(scale * (v << 8 >> 8) as f32).to_le_bytes());
    }
}

/// Colours from brightness and two differences; the highest bit of opacity says how many bits all have.
pub(super) fn colour(bytes: &mut [u8], stride: usize) {
    let size = stride / 4;
    let (most, mask) = if size == 1 { (255.0, 0xff) } else { (65535.0, 0xffff) };
    each_four(bytes, size, |[y, orange, green, a]| {
        let (y, a) = (y & mask, a & mask);
        let full = (0..4).fold(a, |bits, i| bits | bits >> (1 << i));
        let scale = most / full as f32;
        let a = a << 1 & full | a & 1;
        [y + orange - green, y + green, y - orange - green, a].map(|c| (c as f32 * scale + 0.5) as i32)
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_vectors_come_back_from_an_octahedron() {
        let mut bytes = [64, 0, 127, 9, 0, 127, 127, 9, 100, 100, 127, 9].map(|x: i8| x as u8);
        octahedral(&mut bytes, 4);
        let back = bytes.map(|x| x as i8);
        assert_eq!(back[4..8], [0, 127, 0, 9]);
        // (64, 0) is 64 : 63, (100, 100) is folded to (27, 27, -73).
        let length = |v: &[i8]| v.iter().map(|x| f32::from(*x).powi(2)).sum::<f32>().sqrt();
        assert!((length(&back[..3]) - 127.0).abs() < 1.0 && back[0] == 91, "{back:?}");
        assert!((length(&back[8..11]) - 127.0).abs() < 1.0 && back[10] < -100, "{back:?}");
    }

    #[test]
    fn a_rotation_by_nothing_has_all_in_the_part_that_is_missing() {
        let mut bytes: Vec<u8> = [0i16, 0, 0, 0x7ffc | 3].into_iter().flat_map(i16::to_le_bytes).collect();
        quaternion(&mut bytes);
        assert_eq!(bytes, [0i16, 0, 0, 32767].into_iter().flat_map(i16::to_le_bytes).collect::<Vec<_>>());
    }

    #[test]
    fn floats_and_colours_come_back() {
        let mut bytes = (((-3i32) << 24) | 12).to_le_bytes();
        exponential(&mut bytes);
        assert_eq!(f32::from_le_bytes(bytes), 1.5);
        let mut grey = [100, 0, 0, 0x7f];
        colour(&mut grey, 4);
        assert_eq!(grey, [201, 201, 201, 255]);
    }
}
