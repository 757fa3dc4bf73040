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
#[derive(Debug)]
pub(super) struct Property {
    pub name: String,
    pub kind: ScalarType,
    /// Type of the length, for a list.
    pub list: Option<ScalarType>,
    /// Its line among those of the header.
    pub line: usize,
}

/// Items of one kind, such as vertices.
#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
    /// Its line among those of the header.
    pub line: usize,
}

/// What the header says.
#[derive(Debug)]
pub(super) struct PlyHeader {
    pub elements: Vec<Element>,
    pub encoding: Encoding,
    /// First byte and end of each line, its line end included; the last one is `end_header`.
    pub lines: Vec<(usize, usize)>,
    /// What was odd.
    pub warnings: Vec<String>,
}

/// How values are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

impl Element {
    /// The place of the first of its properties that has one of these names.
    pub fn find(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|property| names.contains(&property.name.as_str()))
    }
}

/// Names of the list of a face's vertices.
pub(super) const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Elements that the mesh is made of: one of each line at the most.
const SINGLE: [&[&str]; 2] = [&["vertex"], &["face", "tristrips"]];

/// Longest line of a header that is shown.
const SHOWN: usize = 60;

impl PlyHeader {
    /// Reads it from the file's bytes.
    pub fn read(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut header =
            Self { elements: Vec::new(), encoding: Encoding::Text, lines: Vec::new(), warnings: Vec::new() };
        let mut encoding = None;
        let mut at = 0;
        loop {
            let rest = bytes.get(at..).filter(|rest| !rest.is_empty());
            let rest = rest.ok_or_else(|| FormatError::whole("no end_header; is this a PLY file?"))?;
            let end = memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
            let start = at;
            at += (end + if rest[end..].starts_with(b"\r\n") { 2 } else { 1 }).min(rest.len());
            header.lines.push((start, at));
            let line = header.lines.len();
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
                    let own = SINGLE.iter().find(|names| names.contains(&name)).copied().unwrap_or_default();
                    if header.elements.iter().any(|element| own.contains(&element.name.as_str())) {
                        return Err(wrong("a second list of vertices or of faces; export it with one"));
                    }
                    let (name, line) = (name.to_string(), line - 1);
                    header.elements.push(Element { name, count, properties: Vec::new(), line });
                }
                ["property", ref rest @ ..] => {
                    let kind = |name| ScalarType::of(name).ok_or_else(|| wrong("unknown type"));
                    let (name, kind, list) = match *rest {
                        ["list", length, item, name] => (name, kind(item)?, Some(kind(length)?)),
                        [item, name] => (name, kind(item)?, None),
                        _ => return Err(wrong("not a property")),
                    };
                    let element = header.elements.last_mut().ok_or_else(|| wrong("a property before any element"))?;
                    element.properties.push(Property { name: name.to_string(), kind, list, line: line - 1 });
                }
                ["end_header"] => break,
                [] | ["comment" | "obj_info", ..] => {}
                ["format" | "element", ..] => return Err(wrong("not a line of a header")),
                // What old exporters say of themselves. It stays, and so may what follows.
                _ => {
                    let shown: String = text.trim().chars().take(SHOWN).collect();
                    header.warnings.push(format!("line {line} of the header is not known and stays: '{shown}'"));
                }
            }
        }
        header.encoding = encoding.ok_or_else(|| FormatError::whole("the header names no format; export it again"))?;
        Ok(header)
    }

    /// First byte of the values.
    pub fn end(&self) -> usize {
        self.lines.last().map_or(0, |line| line.1)
    }
}
