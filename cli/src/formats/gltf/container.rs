//! What a glTF is written in: the chunks of a `.glb`, or the text of a `.gltf`.
//!
//! The JSON is a tree whose keys keep their order and whose numbers read back the same. A text keeps its indentation. Chunks
//! after the binary one, which the format allows, are kept as they are.

use crate::formats::error::FormatError;
use serde::Serialize;
use serde_json::Value;
use serde_json::ser::PrettyFormatter;
use std::io;

/// A file taken apart.
#[derive(Default)]
pub struct Container {
    /// The JSON.
    pub tree: Value,
    /// Whether it was a `.glb`.
    pub is_binary: bool,
    /// The binary chunk of a `.glb`, with the bytes that fill it up.
    pub chunk: Option<Vec<u8>>,
    /// The chunks behind it.
    pub others: Vec<u8>,
    /// What a level of the text is indented by; `None`: no line ends.
    pub indent: Option<String>,
}

const JSON: &[u8] = b"JSON";
const BINARY: &[u8] = b"BIN\0";

impl Container {
    /// Takes the bytes of a file apart. O(bytes).
    pub fn open(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut made = Self { is_binary: bytes.starts_with(b"glTF"), ..Self::default() };
        let json = if made.is_binary { made.chunks(bytes)? } else { bytes };
        let json = json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json);
        made.tree = serde_json::from_slice(json)
            .map_err(|e| FormatError::whole(format!("not glTF 2.0: {e}; export it again")))?;
        made.indent = indent(json);
        Ok(made)
    }

    /// Takes the binary chunk and those behind it; gives the JSON.
    fn chunks<'a>(&mut self, bytes: &'a [u8]) -> Result<&'a [u8], FormatError> {
        let broken = || FormatError::whole("a .glb that is cut short or damaged; export it again");
        let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
        let chunk = |at: usize| {
            let end = (at + 8).checked_add(word(at)? as usize)?;
            Some((bytes.get(at + 4..at + 8)?, bytes.get(at + 8..end)?))
        };
        if word(4) != Some(2) {
            return Err(broken());
        }
        let (_, json) = chunk(12).filter(|(kind, _)| *kind == JSON).ok_or_else(broken)?;
        let mut at = 20 + json.len();
        if at < bytes.len() {
            let (kind, data) = chunk(at).ok_or_else(broken)?;
            if kind == BINARY {
                self.chunk = Some(data.to_vec());
                at += 8 + data.len();
            }
        }
        self.others = bytes.get(at..).unwrap_or_default().to_vec();
        Ok(json)
    }

    /// The bytes of a `.glb`. The container counts in 32 bits: more is an error.
    pub fn glb(&self) -> io::Result<Vec<u8>> {
        let mut json = serde_json::to_vec(&self.tree)?;
        json.resize(json.len().next_multiple_of(4), b' ');
        let word = |n: usize| u32::try_from(n).map(u32::to_le_bytes).map_err(|_| io::Error::other("more than 4 GiB"));
        let binary = self.chunk.as_deref();
        let fill = binary.map_or(0, |data| data.len().next_multiple_of(4) - data.len());
        let length = 20 + json.len() + binary.map_or(0, |data| 8 + data.len() + fill) + self.others.len();
        let mut out = Vec::with_capacity(length);
        out.extend(b"glTF");
        out.extend(2u32.to_le_bytes());
        out.extend(word(length)?);
        out.extend(word(json.len())?);
        out.extend(JSON);
        out.extend(json);
        if let Some(data) = binary {
            out.extend(word(data.len() + fill)?);
            out.extend(BINARY);
            out.extend(data);
            out.extend(vec![0; fill]);
        }
        out.extend(&self.others);
        Ok(out)
    }

    /// The text of a `.gltf`.
    pub fn text(&self) -> io::Result<Vec<u8>> {
        let mut out = Vec::new();
        match &self.indent {
            None => serde_json::to_writer(&mut out, &self.tree)?,
            Some(indent) => {
                let formatter = PrettyFormatter::with_indent(indent.as_bytes());
                self.tree.serialize(&mut serde_json::Serializer::with_formatter(&mut out, formatter))?;
                out.push(b'\n');
            }
        }
        Ok(out)
    }
}

/// What the first key of a text is indented by, where it stands on a line of its own.
fn indent(json: &[u8]) -> Option<String> {
    let inside = json.trim_ascii_start().strip_prefix(b"{")?;
    let blank = &inside[..inside.iter().position(|b| !b.is_ascii_whitespace())?];
    let line = blank.iter().rposition(|b| *b == b'\n')?;
    String::from_utf8(blank[line + 1..].to_vec()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn chunks_come_back_as_they_were() {
        let tree = json!({"z": 1, "a": [0.1, 1e-7, 0.100_000_001_490_116_12, "é\n"]});
        let made =
            Container { tree, chunk: Some(vec![7; 5]), others: vec![0, 0, 0, 0, 1, 2, 3, 4], ..Container::default() };
        let bytes = made.glb().unwrap();
        assert_eq!((bytes.len() % 4, u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize), (0, bytes.len()));
        let back = Container::open(&bytes).unwrap();
        assert_eq!((&back.tree, &back.others), (&made.tree, &made.others));
        assert_eq!(back.chunk, Some(vec![7, 7, 7, 7, 7, 0, 0, 0]));
        assert_eq!(back.glb().unwrap(), bytes);
        let alone = Container { tree: json!({}), ..Container::default() }.glb().unwrap();
        assert_eq!(Container::open(&alone).unwrap().chunk, None);
    }

    #[test]
    fn a_text_keeps_its_indentation_and_the_order_of_its_keys() {
        for text in
            ["{\n\t\"b\": 1,\n\t\"a\": {\n\t\t\"x\": [\n\t\t\t1.5\n\t\t]\n\t}\n}\n", "{\"b\":1,\"a\":[1.0,-0.0]}"]
        {
            let back = Container::open(text.as_bytes()).unwrap().text().unwrap();
            assert_eq!(String::from_utf8(back).unwrap(), text);
        }
    }

    #[test]
    fn what_is_cut_short_is_an_error() {
        let made = Container { tree: json!({"a": 1}), chunk: Some(vec![1; 8]), ..Container::default() };
        let bytes = made.glb().unwrap();
        for end in [4, 11, 15, 22, bytes.len() - 1] {
            assert!(Container::open(&bytes[..end]).is_err(), "{end}");
        }
    }
}
