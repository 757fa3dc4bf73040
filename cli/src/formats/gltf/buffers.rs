//! The bytes of a glTF: buffers from the container, data URIs and files, and buffer views of them, decompressed where they
//! are compressed.

use super::beside;
use super::document::{BufferView, Document};
use super::meshopt::decode::decode;
use super::uri::{data, decode_percent};
use crate::formats::error::FormatError;
use std::path::Path;

/// All buffers of a document, each as long as it says.
pub struct Buffers {
    /// The bytes of each; none of a fallback that only stands for decompressed ones.
    pub bytes: Vec<Vec<u8>>,
    /// The bytes of each view that is compressed.
    decoded: Vec<Option<Vec<u8>>>,
}

impl Buffers {
    /// Loads them; `chunk` is the container's, `folder` where files lie.
    pub fn load(document: &Document, mut chunk: Option<Vec<u8>>, folder: &Path) -> Result<Self, FormatError> {
        let mut all = Self { bytes: Vec::new(), decoded: Vec::new() };
        for (i, buffer) in document.buffers.iter().enumerate() {
            let mut bytes = match &buffer.uri {
                _ if buffer.is_fallback() => Vec::new(),
                None => chunk.take().filter(|_| i == 0).unwrap_or_default(),
                Some(uri) => resolve(uri, folder)?,
            };
            if bytes.len() < buffer.byte_length && !buffer.is_fallback() {
                let (given, need) = (bytes.len(), buffer.byte_length);
                return Err(FormatError::whole(format!(
                    "buffer {i} holds {given} of its {need} bytes; export it again"
                )));
            }
            // What lies behind is not the buffer's and is not written: a chunk is filled up to four bytes.
            bytes.truncate(buffer.byte_length);
            all.bytes.push(bytes);
        }
        for (i, view) in document.buffer_views.iter().enumerate() {
            let decoded = view.extensions.meshopt.as_ref().map(|compressed| {
                let end = compressed.byte_offset.checked_add(compressed.byte_length);
                let bytes = all.bytes.get(compressed.buffer).zip(end);
                let bytes = bytes.and_then(|(bytes, end)| bytes.get(compressed.byte_offset..end));
                bytes.and_then(|bytes| decode(bytes, compressed)).ok_or_else(|| {
                    FormatError::whole(format!(
                        "buffer view {i} is compressed (EXT_meshopt_compression) and cannot be decompressed; export it again"
                    ))
                })
            });
            all.decoded.push(decoded.transpose()?);
        }
        Ok(all)
    }

    /// Those of a document that was just made, none of whose views are compressed.
    pub fn of(bytes: Vec<u8>, document: &Document) -> Self {
        Self { bytes: vec![bytes], decoded: document.buffer_views.iter().map(|_| None).collect() }
    }

    /// The bytes of view `index`.
    pub fn view(&self, document: &Document, index: usize) -> Option<&[u8]> {
        let view = document.buffer_views.get(index)?;
        match self.decoded.get(index)? {
            Some(bytes) => Some(bytes),
            None => self.bytes.get(view.buffer)?.get(range(view)?),
        }
    }
}

fn range(view: &BufferView) -> Option<core::ops::Range<usize>> {
    Some(view.byte_offset..view.byte_offset.checked_add(view.byte_length)?)
}

/// The bytes of a data URI or of a file.
fn resolve(uri: &str, folder: &Path) -> Result<Vec<u8>, FormatError> {
    if uri.starts_with("data:") {
        return data(uri).ok_or_else(|| FormatError::whole("a buffer's data URI is not base64; export it again"));
    }
    let path = folder.join(decode_percent(uri));
    beside::read(&path)
        .map_err(|e| FormatError::whole(format!("its buffer {} cannot be read: {e}; put it there", path.display())))
}
