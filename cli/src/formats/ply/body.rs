//! The values behind a PLY's header, one after another.

use super::header::{Element, Encoding, PlyHeader, Property, ScalarType};
use crate::mesh::precision::Decimals;

/// Reads values one after another.
pub(super) struct Body<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    encoding: Encoding,
    decimals: Decimals,
}

/// Why there is no value.
pub(super) enum Short {
    /// The file ends.
    End,
    /// A word that is no number, and its line.
    Word(usize, String),
}

impl<'a> Body<'a> {
    /// A cursor on what follows `header` in the file's bytes.
    pub fn new(bytes: &'a [u8], header: &PlyHeader) -> Self {
        let (at, line) = header.end;
        Self { bytes, at, line, encoding: header.encoding, decimals: Decimals::default() }
    }

    /// The most decimals of the coordinates that were read; `None` where they are no text.
    pub fn decimals(&self) -> Option<Decimals> {
        (self.encoding == Encoding::Text).then_some(self.decimals)
    }

    /// Reads the next value, or list of values, of an item of `element` into `into`.
    pub fn property(&mut self, element: &Element, property: &Property, into: &mut Vec<f64>) -> Result<(), Short> {
        into.clear();
        let start = self.at;
        let count = property.list.map_or(Ok(1.0), |kind| self.number(kind))?;
        for _ in 0..count.max(0.0) as u64 {
            into.push(self.number(property.kind)?);
        }
        if self.encoding == Encoding::Text && element.name == "vertex" && matches!(&property.name[..], "x" | "y" | "z")
        {
            self.decimals.see(self.bytes[start..self.at].trim_ascii());
        }
        Ok(())
    }

    fn number(&mut self, kind: ScalarType) -> Result<f64, Short> {
        if self.encoding == Encoding::Text {
            return self.word();
        }
        let bytes = self.bytes.get(self.at..self.at + kind.size()).ok_or(Short::End)?;
        self.at += kind.size();
        let mut all = [0; 8]; // little endian, zero-extended
        all[..bytes.len()].copy_from_slice(bytes);
        if self.encoding == Encoding::Big {
            all[..bytes.len()].reverse();
        }
        let bits = u64::from_le_bytes(all);
        Ok(match kind {
            ScalarType::I8 => f64::from(bits as i8),
            ScalarType::I16 => f64::from(bits as i16),
            ScalarType::I32 => f64::from(bits as i32),
            ScalarType::U8 | ScalarType::U16 | ScalarType::U32 => f64::from(bits as u32),
            ScalarType::F32 => f64::from(f32::from_bits(bits as u32)),
            ScalarType::F64 => f64::from_bits(bits),
        })
    }

    fn word(&mut self) -> Result<f64, Short> {
        while let Some(b) = self.bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            self.line += usize::from(*b == b'\n');
            self.at += 1;
        }
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += end;
        match core::str::from_utf8(&rest[..end]).ok().and_then(|word| word.parse().ok()) {
            Some(value) => Ok(value),
            None if end == 0 => Err(Short::End),
            None => Err(Short::Word(self.line, String::from_utf8_lossy(&rest[..end.min(40)]).into_owned())),
        }
    }
}
