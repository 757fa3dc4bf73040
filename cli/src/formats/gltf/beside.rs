//! The files that a `.gltf` names.

use super::uri::{decode_percent, has_scheme};
use serde_json::Value;

/// Buffers and images in files of their own, as paths seen from the file's folder. Nothing where the text is no JSON.
pub fn files(text: &[u8]) -> Vec<String> {
    let tree: Value = serde_json::from_slice(text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text)).unwrap_or_default();
    let of = |list: &str| tree[list].as_array().cloned().unwrap_or_default();
    let uris =
        ["buffers", "images"].into_iter().flat_map(of).filter_map(|item| Some(item["uri"].as_str()?.to_string()));
    uris.filter(|uri| !has_scheme(uri)).map(|uri| decode_percent(&uri)).collect()
}
