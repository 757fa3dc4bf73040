//! The values behind a PLY's header, one after another, and where they stand.
//!
//! A text has a line for each item, as every writer makes it, so values beyond those that the header names are seen. A text
//! that is laid out otherwise is read as one stream of words.

use super::header::{Element, Encoding, PlyHeader, Property, ScalarType};
use crate::mesh::precision::Decimals;

/// Reads values one after another.
pub(super) struct Body<'a> {
    bytes: &'a [u8],
    /// The next byte.
    pub at: usize,
    line: usize,
    encoding: Encoding,
    /// Whether each item has a line of its own, and where that ends.
    by_lines: bool,
    line_end: usize,
    decimals: Decimals,
}

/// Why there is no value.
pub(super) enum Short {
    /// The file ends.
    End,
    /// The item's line ends.
    Line,
    /// A word that is no number, and its line.
    Word(usize, String),
}

impl<'a> Body<'a> {
    /// A cursor on what follows `header` in the file's bytes.
    pub fn new(bytes: &'a [u8], header: &PlyHeader, by_lines: bool) -> Self {
        let (at, line, encoding) = (header.end(), header.lines.len() + 1, header.encoding);
        let by_lines = by_lines && encoding == Encoding::Text;
        Self { bytes, at, line, encoding, by_lines, line_end: bytes.len(), decimals: Decimals::default() }
    }

    /// Whether items are read by lines.
    pub fn by_lines(&self) -> bool {
        self.by_lines
    }

    /// The most decimals of the coordinates that were read; `None` where they are no text.
    pub fn decimals(&self) -> Option<Decimals> {
        (self.encoding == Encoding::Text).then_some(self.decimals)
    }

    /// Begins an item.
    pub fn begin(&mut self) {
        if self.by_lines {
            self.line_end = self.bytes.len();
            self.skip_blanks();
            let rest = &self.bytes[self.at..];
            self.line_end = self.at + memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
        }
    }

    /// Ends an item. Gives what its line holds beyond it, and the number of the line.
    pub fn end(&mut self) -> Option<(usize, usize, usize)> {
        let rest = if self.by_lines { &self.bytes[self.at..self.line_end] } else { &[][..] };
        let start = self.at;
        (!rest.trim_ascii().is_empty()).then(|| {
            self.at = self.line_end;
            (start, self.line_end, self.line)
        })
    }

    /// Reads the next value, or list of values, of an item of `element` into `into`.
    pub fn property(&mut self, element: &Element, property: &Property, into: &mut Vec<f64>) -> Result<(), Short> {
        into.clear();
        let start = self.at;
        let count = property.list.map_or(Ok(1.0), |kind| self.number(kind))?;
        for _ in 0..count.max(0.0) as u64 {
            into.push(self.number(property.kind)?);
        }
        let is_text = self.encoding == Encoding::Text;
        if is_text && element.name == "vertex" && matches!(&property.name[..], "x" | "y" | "z") {
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
        self.skip_blanks();
        let rest = &self.bytes[self.at..self.line_end];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += end;
        match core::str::from_utf8(&rest[..end]).ok().and_then(|word| word.parse().ok()) {
            Some(value) => Ok(value),
            None if end == 0 && self.at < self.bytes.len() => Err(Short::Line),
            None if end == 0 => Err(Short::End),
            None => Err(Short::Word(self.line, String::from_utf8_lossy(&rest[..end.min(40)]).into_owned())),
        }
    }

    fn skip_blanks(&mut self) {
        while self.at < self.line_end && self.bytes[self.at].is_ascii_whitespace() {
            let is_end = match self.bytes[self.at] {
                b'\n' => true,
                b'\r' => self.bytes.get(self.at + 1) != Some(&b'\n'),
                _ => false,
            };
            self.line += usize::from(is_end);
            self.at += 1;
        }
    }
}
