//! The header of a PLY: its elements, their properties, and how the values behind it are written.

use crate::formats::error::FormatError;

/// What one number is in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ScalarType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl ScalarType {
    pub fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => ScalarType::I8,
            "uchar" | "uint8" => ScalarType::U8,
            "short" | "int16" => ScalarType::I16,
            "ushort" | "uint16" => ScalarType::U16,
            "int" | "int32" => ScalarType::I32,
            "uint" | "uint32" => ScalarType::U32,
            "float" | "float32" => ScalarType::F32,
            "double" | "float64" => ScalarType::F64,
            _ => return None,
        })
    }

    pub fn size(self) -> usize {
        match self {
            ScalarType::I8 | ScalarType::U8 => 1,
            ScalarType::I16 | ScalarType::U16 => 2,
            ScalarType::I32 | ScalarType::U32 | ScalarType::F32 => 4,
            ScalarType::F64 => 8,
        }
    }
}

/// A number, or a list of them, of each item of an element.
pub(super) struct Property {
    pub name: String,
    pub kind: ScalarType,
    /// Type of the length, for a list.
    pub list: Option<ScalarType>,
}

/// Items of one kind, such as vertices.
pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

/// What the header says.
pub(super) struct PlyHeader {
    pub elements: Vec<Element>,
    pub encoding: Encoding,
    /// First byte of the values, and its line from 1.
    pub end: (usize, usize),
}

/// How values are written.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

impl PlyHeader {
    /// Reads it from the file's bytes.
    pub fn read(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut elements: Vec<Element> = Vec::new();
        let mut encoding = None;
        let (mut at, mut line) = (0, 0);
        loop {
            let rest = bytes.get(at..).filter(|rest| !rest.is_empty());
            let rest = rest.ok_or_else(|| FormatError::whole("no end_header; is this a PLY file?"))?;
            let end = memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
            at += (end + if rest[end..].starts_with(b"\r\n") { 2 } else { 1 }).min(rest.len());
            line += 1;
            let text = String::from_utf8_lossy(&rest[..end]);
            let words: Vec<&str> = text.split_whitespace().collect();
            let wrong = |problem: &str| FormatError { line, problem: format!("{problem}: '{}'", text.trim()) };
            match words[..] {
                _ if line == 1 => {
                    if words != ["ply"] {
                        return Err(FormatError::whole("does not begin with 'ply'; is this a PLY file?"));
                    }
                }
                ["format", name, _] => {
                    encoding = Some(match name {
                        "ascii" => Encoding::Text,
                        "binary_little_endian" => Encoding::Little,
                        "binary_big_endian" => Encoding::Big,
                        _ => return Err(wrong("unknown format")),
                    });
                }
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| wrong("not a count"))?;
                    elements.push(Element { name: name.to_string(), count, properties: Vec::new() });
                }
                ["property", ref rest @ ..] => {
                    let kind = |name| ScalarType::of(name).ok_or_else(|| wrong("unknown type"));
                    let property = match *rest {
                        ["list", length, item, name] => {
                            Property { name: name.to_string(), kind: kind(item)?, list: Some(kind(length)?) }
                        }
                        [item, name] => Property { name: name.to_string(), kind: kind(item)?, list: None },
                        _ => return Err(wrong("not a property")),
                    };
                    elements
                        .last_mut()
                        .ok_or_else(|| wrong("a property before any element"))?
                        .properties
                        .push(property);
                }
                ["end_header"] => break,
                [] | ["comment" | "obj_info", ..] => {}
                _ => return Err(wrong("unknown header line")),
            }
        }
        let encoding = encoding.ok_or_else(|| FormatError::whole("the header names no format; export it again"))?;
        Ok(Self { elements, encoding, end: (at, line + 1) })
    }
}
