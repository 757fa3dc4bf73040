//! What a glTF's URIs stand for: base64 in place, or a file beside.

/// The bytes of a data URI; `None` where it is no base64.
pub(super) fn data(uri: &str) -> Option<Vec<u8>> {
    decode_base64(uri.strip_prefix("data:")?.split_once(";base64,")?.1.as_bytes())
}

/// Bytes as a data URI of the same media type as `like`.
pub(super) fn data_like(like: &str, bytes: &[u8]) -> String {
    let head = like.split_once(";base64,").map_or("data:application/octet-stream", |(head, _)| head);
    format!("{head};base64,{}", encode_base64(bytes))
}

/// Whether a URI has a scheme of its own, data among them, so that no file beside is meant.
pub(super) fn has_scheme(uri: &str) -> bool {
    let scheme = uri.split_once(':').map_or("", |(scheme, _)| scheme);
    // A drive's letter is no scheme.
    scheme.len() > 1 && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'+' | b'-' | b'.'))
}

/// A file's name as a URI.
pub(super) fn of_file(name: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || b >= 0x80 || b"-._~!$&'()*+,;=@/".contains(&b);
    let mut out = Vec::new();
    for b in name.bytes() {
        if plain(b) { out.push(b) } else { out.extend(format!("%{b:02X}").bytes()) }
    }
    String::from_utf8(out).unwrap_or_default() // bytes from 0x80 stand as they stood
}

const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Standard base64, padded or not; `None` for any other character.
fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut held) = (0u32, 0);
    for byte in text.iter().take_while(|b| **b != b'=') {
        let value = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        held += 6;
        if held >= 8 {
            held -= 8;
            out.push((bits >> held) as u8);
        }
    }
    Some(out)
}

fn encode_base64(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let at = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i)) as usize % 64];
            out.push(if i <= three.len() { char::from(digit) } else { '=' });
        }
    }
    out
}

/// `%20` and the like.
pub(super) fn decode_percent(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let hex = tail.get(..2).and_then(|hex| core::str::from_utf8(hex).ok());
        match hex.filter(|_| *first == b'%').and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use quickcheck::quickcheck;

    #[test]
    fn base64_and_percent_signs_are_decoded() {
        assert_eq!(decode_base64(b"aGVsbG8="), Some(b"hello".to_vec()));
        assert_eq!(decode_base64(b"a b"), None);
        assert_eq!(data_like("data:image/png;base64,AA", b"hello"), "data:image/png;base64,aGVsbG8=");
        assert_eq!(decode_percent("a%20b%zz%4"), "a b%zz%4");
        assert_eq!(of_file("a b/ö%.bin"), "a%20b/ö%25.bin");
    }

    #[test]
    fn schemes_are_told_from_drives_and_files() {
        let found = ["http://x/a.png", "data:x", "C:\\a.bin", "a/b:c.bin", "a.bin"].map(has_scheme);
        assert_eq!(found, [true, true, false, false, false]);
    }

    quickcheck! {
        fn base64_comes_back(bytes: Vec<u8>) -> bool {
            decode_base64(encode_base64(&bytes).as_bytes()) == Some(bytes)
        }
        fn names_come_back(name: String) -> bool {
            decode_percent(&of_file(&name)) == name
        }
    }
}
