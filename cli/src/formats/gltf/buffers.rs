//! Bytes and numbers of a glTF: buffers from the container, data URIs and files; accessors with every bound checked.

use super::document::{Accessor, Document};
use crate::formats::error::FormatError;
use crate::mesh::precision::of_floats;
use std::borrow::Cow;
use std::fs;
use std::path::Path;

/// All buffers of a document, each at least as long as it says.
pub struct Buffers<'a> {
    document: &'a Document,
    bytes: Vec<Cow<'a, [u8]>>,
}

impl<'a> Buffers<'a> {
    /// Loads them; `binary` is the container's chunk, `folder` where files lie.
    pub fn load(document: &'a Document, binary: Option<&'a [u8]>, folder: &Path) -> Result<Self, FormatError> {
        let load = |(i, buffer): (usize, &super::document::Buffer)| {
            let bytes = match &buffer.uri {
                None => Cow::Borrowed(binary.filter(|_| i == 0).unwrap_or_default()),
                Some(uri) => Cow::Owned(resolve(uri, folder)?),
            };
            if bytes.len() < buffer.byte_length {
                let (given, need) = (bytes.len(), buffer.byte_length);
                return Err(FormatError::whole(format!(
                    "buffer {i} holds {given} of its {need} bytes; export it again"
                )));
            }
            Ok(bytes)
        };
        let bytes = document.buffers.iter().enumerate().map(load).collect::<Result<_, _>>()?;
        Ok(Self { document, bytes })
    }

    /// All numbers of accessor `index`, `width` an item, normalised where it says so.
    pub fn values(&self, index: usize, width: usize) -> Result<Vec<f64>, FormatError> {
        let accessor = self.document.accessors.get(index);
        accessor.and_then(|a| self.items(a, width)).ok_or_else(|| {
            let text = "is missing, sparse, of another type, or does not fit its buffer; export it again";
            FormatError::whole(format!("accessor {index} {text}"))
        })
    }

    /// How far numbers of accessor `index` may be from what they stand for, the largest of which is `largest`: half a step of
    /// whole numbers, half a last bit of floats.
    pub fn precision(&self, index: usize, largest: f64) -> f64 {
        let accessor = self.document.accessors.get(index);
        match accessor.and_then(|a| Some((ComponentType::of(a.component_type)?, a.normalized))) {
            None | Some((ComponentType::F32, _)) => of_floats(largest),
            Some((kind, true)) => 0.5 / kind.largest(),
            Some((_, false)) => 0.5,
        }
    }

    fn items(&self, accessor: &Accessor, width: usize) -> Option<Vec<f64>> {
        let Accessor { byte_offset, count, .. } = *accessor;
        let kind = ComponentType::of(accessor.component_type)?;
        let shape = ["SCALAR", "VEC2", "VEC3", "VEC4"].get(width.checked_sub(1)?)?;
        if accessor.sparse.is_some() || accessor.shape != *shape {
            return None;
        }
        let view = self.document.buffer_views.get(accessor.buffer_view?)?;
        let end = view.byte_offset.checked_add(view.byte_length)?;
        let bytes = self.bytes.get(view.buffer)?.get(view.byte_offset..end)?.get(byte_offset..)?;
        let size = width * kind.size();
        let stride = view.byte_stride.unwrap_or(size);
        let used = count.checked_sub(1).map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(size))?;
        if used > bytes.len() || stride < size {
            return None;
        }
        let scale = if accessor.normalized { kind.largest() } else { 1.0 };
        let item = |i: usize| bytes[i * stride..i * stride + size].chunks_exact(kind.size());
        Some((0..count).flat_map(item).map(|word| kind.number(word) / scale).collect())
    }
}

/// Type of a number.
#[derive(Clone, Copy)]
enum ComponentType {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl ComponentType {
    fn of(code: u32) -> Option<Self> {
        Some(match code {
            5120 => ComponentType::I8,
            5121 => ComponentType::U8,
            5122 => ComponentType::I16,
            5123 => ComponentType::U16,
            5125 => ComponentType::U32,
            5126 => ComponentType::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            ComponentType::I8 | ComponentType::U8 => 1,
            ComponentType::I16 | ComponentType::U16 => 2,
            ComponentType::U32 | ComponentType::F32 => 4,
        }
    }

    /// What a normalised 1 is stored as.
    fn largest(self) -> f64 {
        match self {
            ComponentType::I8 => f64::from(i8::MAX),
            ComponentType::U8 => f64::from(u8::MAX),
            ComponentType::I16 => f64::from(i16::MAX),
            ComponentType::U16 => f64::from(u16::MAX),
            ComponentType::U32 => f64::from(u32::MAX),
            ComponentType::F32 => 1.0,
        }
    }

    fn number(self, word: &[u8]) -> f64 {
        let mut all = [0; 4]; // little endian, zero-extended
        all[..word.len()].copy_from_slice(word);
        let bits = u32::from_le_bytes(all);
        match self {
            ComponentType::I8 => f64::from(bits as i8),
            ComponentType::I16 => f64::from(bits as i16),
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => f64::from(bits),
            ComponentType::F32 => f64::from(f32::from_bits(bits)),
        }
    }
}

/// The bytes of a data URI or of a file.
fn resolve(uri: &str, folder: &Path) -> Result<Vec<u8>, FormatError> {
    match uri.strip_prefix("data:") {
        Some(data) => data
            .split_once(";base64,")
            .and_then(|(_, text)| decode_base64(text.as_bytes()))
            .ok_or_else(|| FormatError::whole("a buffer's data URI is not base64; export it again")),
        None => {
            let path = folder.join(decode_percent(uri));
            fs::read(&path).map_err(|e| {
                FormatError::whole(format!("its buffer {} cannot be read: {e}; put it there", path.display()))
            })
        }
    }
}

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

/// `%20` and the like.
fn decode_percent(uri: &str) -> String {
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

    #[test]
    fn base64_and_percent_signs_are_decoded() {
        assert_eq!(decode_base64(b"aGVsbG8="), Some(b"hello".to_vec()));
        assert_eq!(decode_base64(b"a b"), None);
        assert_eq!(decode_percent("a%20b%zz%4"), "a b%zz%4");
    }
}
