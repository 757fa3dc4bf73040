//! A `.gltf` with everything that lies beside it taken into one chunk.

use super::beside;
use super::uri::{data, decode_percent, has_scheme};
use serde_json::{Map, Value, json};
use std::path::Path;

/// All buffers as one and all images as views of it; `folder` is where images lie. Gives the tree, the chunk, and a warning
/// for each image that cannot be read, which stays where it is. Buffers without bytes, which only stand for decompressed
/// ones, stay behind the chunk.
pub(super) fn take_in(mut tree: Value, buffers: Vec<Vec<u8>>, folder: &Path) -> (Value, Vec<u8>, Vec<String>) {
    let (mut chunk, mut places, mut rest) = (Vec::new(), Vec::new(), Vec::new());
    let old = tree.get_mut("buffers").map(Value::take).and_then(|all| all.as_array().cloned()).unwrap_or_default();
    let mut first = Map::new();
    for (buffer, bytes) in old.into_iter().zip(buffers) {
        if bytes.is_empty() {
            rest.push(buffer);
            places.push((rest.len(), 0));
            continue;
        }
        if chunk.is_empty() {
            first = buffer.as_object().cloned().unwrap_or_default();
            first.shift_remove("uri");
        }
        chunk.resize(chunk.len().next_multiple_of(16), 0);
        places.push((0, chunk.len()));
        chunk.extend(bytes);
    }
    for view in tree.get_mut("bufferViews").and_then(Value::as_array_mut).into_iter().flatten() {
        view.as_object_mut().into_iter().for_each(|view| place(view, &places));
        for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
            let packed = view.get_mut("extensions").and_then(|e| e.get_mut(name)?.as_object_mut());
            packed.into_iter().for_each(|packed| place(packed, &places));
        }
    }
    let missing = images(&mut tree, &mut chunk, folder);
    first.insert("byteLength".into(), json!(chunk.len()));
    tree["buffers"] = [Value::Object(first)].into_iter().chain(rest).collect();
    (tree, chunk, missing)
}

/// Makes a view lie where its buffer went.
fn place(view: &mut Map<String, Value>, places: &[(usize, usize)]) {
    let number = |key: &str| view.get(key).and_then(Value::as_u64).and_then(|n| usize::try_from(n).ok());
    let (buffer, offset) = (number("buffer").unwrap_or(0), number("byteOffset").unwrap_or(0));
    if let Some((buffer, before)) = places.get(buffer) {
        view.insert("buffer".into(), json!(buffer));
        if before + offset > 0 {
            view.insert("byteOffset".into(), json!(before + offset));
        }
    }
}

fn images(tree: &mut Value, chunk: &mut Vec<u8>, folder: &Path) -> Vec<String> {
    let mut missing = Vec::new();
    let mut taken = Vec::new();
    for (i, image) in tree.get("images").and_then(Value::as_array).into_iter().flatten().enumerate() {
        let Some(uri) = image.get("uri").and_then(Value::as_str) else { continue };
        let bytes = match data(uri) {
            Some(bytes) => Ok(bytes),
            None if has_scheme(uri) => continue,
            None => beside::read(&folder.join(decode_percent(uri))),
        };
        match bytes {
            Ok(bytes) => taken.push((i, kind(uri, &bytes), bytes)),
            Err(e) => missing.push(format!("image {uri} cannot be read ({e}) and stays outside")),
        }
    }
    for (i, kind, bytes) in taken {
        chunk.resize(chunk.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": chunk.len(), "byteLength": bytes.len() });
        chunk.extend(bytes);
        if tree.get("bufferViews").is_none() {
            tree["bufferViews"] = json!([]);
        }
        let Some(views) = tree["bufferViews"].as_array_mut() else { continue };
        views.push(view);
        let number = views.len() - 1;
        let Some(image) = tree["images"][i].as_object_mut() else { continue };
        image.shift_remove("uri");
        image.insert("bufferView".into(), json!(number));
        image.entry("mimeType").or_insert_with(|| json!(kind));
    }
    missing
}

/// The media type of an image: what its URI says, else what its first bytes say.
fn kind(uri: &str, bytes: &[u8]) -> String {
    let said = uri.strip_prefix("data:").and_then(|rest| rest.split([';', ',']).next()).filter(|kind| !kind.is_empty());
    said.map(String::from).unwrap_or_else(|| {
        let known: [(&[u8], &str); 4] = [
            (b"\x89PNG", "image/png"),
            (b"\xFF\xD8\xFF", "image/jpeg"),
            (b"RIFF", "image/webp"),
            (b"\xABKTX 20", "image/ktx2"),
        ];
        known.iter().find(|(head, _)| bytes.starts_with(head)).map_or("image/png", |(_, kind)| kind).into()
    })
}
