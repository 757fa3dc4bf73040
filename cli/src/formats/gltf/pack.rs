//! The buffers of an edited glTF: new views behind what was there, and no bytes that nobody names any more.
//!
//! A view whose last accessor went elsewhere gives its number to a new one, and its bytes are cut out, so that a file does not
//! grow each time that it is unwrapped. Cuts are multiples of 16 bytes, so everything behind them stays aligned; what lies
//! between views is kept. Where a file uses an extension that may name views in ways not known here, nothing is cut.

use super::document::Document;
use super::edit::Edited;
use super::file::GltfFile;
use super::overwrite::home;
use super::records::NewView;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

const ALIGNMENT: usize = 16;
const DRACO: &str = "KHR_draco_mesh_compression";
const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The tree and the bytes of each buffer.
pub(super) struct Packed {
    pub tree: Value,
    pub buffers: Vec<Vec<u8>>,
    /// The buffer that is another one now.
    pub changed: usize,
}

/// Puts the views of `edited` into the buffer that holds the file's vertices.
pub(super) fn pack(file: &GltfFile, edited: Edited) -> Packed {
    let Edited { mut tree, views, over, .. } = edited;
    let document = &file.document;
    drop_draco(&mut tree);
    let free = free_views(document, &file.container.tree, &tree);
    let numbers = number(&mut tree, document.buffer_views.len(), &free, views.len());
    let mut buffers = file.buffers.bytes.clone();
    over.iter().for_each(|over| over.write(&mut buffers[over.buffer]));
    cut(&mut tree, &mut buffers, document, &free);
    let home = home_or_new(file, &mut tree, &mut buffers);
    append(&mut tree, &mut buffers[home], home, views, &numbers);
    buffers.iter().enumerate().filter(|(_, bytes)| !bytes.is_empty()).for_each(|(b, bytes)| {
        tree["buffers"][b]["byteLength"] = json!(bytes.len());
    });
    drop_meshopt(&mut tree);
    Packed { tree, buffers, changed: home }
}

/// Views of the file that something named and nothing names any more.
fn free_views(document: &Document, before: &Value, after: &Value) -> Vec<usize> {
    // Extensions whose references to views have keys of their own, or may have.
    let known = |name: &String| {
        let named = ["KHR_", "EXT_", "MSFT_", "VRM", "ADOBE_", "GOOGLE_", "CESIUM_", "AGI_"];
        let keyed = ["EXT_structural_metadata", "EXT_feature_metadata"];
        named.iter().any(|prefix| name.starts_with(prefix)) && !keyed.contains(&name.as_str())
    };
    if !document.extensions_used.iter().all(known) {
        return Vec::new();
    }
    let count = document.buffer_views.len();
    let (before, after) = (named_views(before, count), named_views(after, count));
    (0..count).filter(|view| before[*view] && !after[*view]).collect()
}

/// Which of the first `count` views some `bufferView` names, wherever it stands.
fn named_views(tree: &Value, count: usize) -> Vec<bool> {
    let mut named = vec![false; count];
    let mut stack = vec![tree];
    while let Some(value) = stack.pop() {
        match value {
            Value::Array(items) => stack.extend(items),
            Value::Object(items) => {
                let view = items.get("bufferView").and_then(Value::as_u64).and_then(|view| usize::try_from(view).ok());
                if let Some(mark) = view.and_then(|view| named.get_mut(view)) {
                    *mark = true;
                }
                stack.extend(items.values());
            }
            _ => {}
        }
    }
    named
}

/// Gives `wanted` new views the numbers of free ones, then new ones, also where accessors name them.
fn number(tree: &mut Value, count: usize, free: &[usize], wanted: usize) -> Vec<usize> {
    let numbers: Vec<usize> = free.iter().copied().chain(count..).take(wanted).collect();
    let rename = |place: Option<&mut Value>| {
        let Some(view) = place else { return };
        let new = view.as_u64().and_then(|view| usize::try_from(view).ok()?.checked_sub(count));
        if let Some(new) = new.and_then(|new| numbers.get(new)) {
            *view = json!(new);
        }
    };
    for accessor in tree.get_mut("accessors").and_then(Value::as_array_mut).into_iter().flatten() {
        rename(accessor.get_mut("bufferView"));
        for part in ["indices", "values"] {
            rename(accessor.get_mut("sparse").and_then(|sparse| sparse.get_mut(part)?.get_mut("bufferView")));
        }
    }
    numbers
}

/// Takes the bytes of free views out of the buffers, but for those that another view has too.
fn cut(tree: &mut Value, buffers: &mut [Vec<u8>], document: &Document, free: &[usize]) {
    let mut spans: BTreeMap<usize, Vec<(usize, usize, bool)>> = BTreeMap::new(); // start, end, whether it is free
    for (v, view) in document.buffer_views.iter().enumerate() {
        let (buffer, start, length) = match &view.extensions.meshopt {
            Some(packed) => (packed.buffer, packed.byte_offset, packed.byte_length),
            None => (view.buffer, view.byte_offset, view.byte_length),
        };
        spans.entry(buffer).or_default().push((start, start.saturating_add(length), free.contains(&v)));
    }
    let mut cuts: BTreeMap<usize, Vec<(usize, usize)>> = BTreeMap::new();
    for (buffer, mut spans) in spans {
        spans.sort_unstable();
        let mut live = 0; // end of what is in use
        for i in 0..spans.len() {
            let (start, end, is_free) = spans[i];
            if !is_free {
                live = live.max(end);
                continue;
            }
            let next = spans[i..].iter().find(|span| !span.2).map_or(usize::MAX, |span| span.0);
            let (start, end) = (start.max(live), end.min(next));
            let length = end.saturating_sub(start) / ALIGNMENT * ALIGNMENT;
            if length > 0 && end <= buffers.get(buffer).map_or(0, Vec::len) {
                cuts.entry(buffer).or_default().push((start, start + length));
                live = start + length;
            }
        }
    }
    for (buffer, cuts) in &cuts {
        for (start, end) in cuts.iter().rev() {
            buffers[*buffer].drain(start..end);
        }
    }
    let moved = |place: &mut Map<String, Value>| {
        let number = |key: &str| place.get(key).and_then(Value::as_u64).and_then(|n| usize::try_from(n).ok());
        let (buffer, offset) = (number("buffer").unwrap_or(0), number("byteOffset").unwrap_or(0));
        let before = cuts.get(&buffer).into_iter().flatten().filter(|cut| cut.1 <= offset);
        let shift: usize = before.map(|(start, end)| end - start).sum();
        if shift > 0 {
            place.insert("byteOffset".into(), json!(offset - shift));
        }
    };
    for view in tree.get_mut("bufferViews").and_then(Value::as_array_mut).into_iter().flatten() {
        // Of a compressed view the place where its bytes would lie is in a buffer that has none, which is not cut.
        view.as_object_mut().into_iter().for_each(moved);
        for name in MESHOPT {
            let packed = view.get_mut("extensions").and_then(|e| e.get_mut(name)?.as_object_mut());
            packed.into_iter().for_each(moved);
        }
    }
}

/// The buffer for new bytes: see [`home`], else a new one.
fn home_or_new(file: &GltfFile, tree: &mut Value, buffers: &mut Vec<Vec<u8>>) -> usize {
    home(file).unwrap_or_else(|| {
        let all = tree.as_object_mut().map(|tree| tree.entry("buffers").or_insert_with(|| json!([])));
        all.and_then(Value::as_array_mut).into_iter().for_each(|all| all.push(json!({ "byteLength": 0 })));
        buffers.push(Vec::new());
        buffers.len() - 1
    })
}

fn append(tree: &mut Value, buffer: &mut Vec<u8>, home: usize, views: Vec<NewView>, numbers: &[usize]) {
    if tree.get("bufferViews").is_none() {
        tree["bufferViews"] = json!([]);
    }
    let Some(all) = tree["bufferViews"].as_array_mut() else { return };
    for (view, number) in views.into_iter().zip(numbers) {
        buffer.resize(buffer.len().next_multiple_of(4), 0);
        let mut made = json!({ "buffer": home, "byteOffset": buffer.len(), "byteLength": view.bytes.len() });
        if let Some(stride) = view.stride {
            made["byteStride"] = json!(stride);
        }
        if view.target != 0 {
            made["target"] = json!(view.target);
        }
        buffer.extend(view.bytes);
        match all.get_mut(*number) {
            Some(place) => *place = made,
            None => all.push(made),
        }
    }
}

/// Takes Draco's bytes out of primitives: they say what the mesh was.
fn drop_draco(tree: &mut Value) {
    let meshes = tree.get_mut("meshes").and_then(Value::as_array_mut).into_iter().flatten();
    let primitives = meshes.filter_map(|mesh| mesh.get_mut("primitives")?.as_array_mut()).flatten();
    for primitive in primitives.filter_map(Value::as_object_mut) {
        let Some(extensions) = primitive.get_mut("extensions").and_then(Value::as_object_mut) else { continue };
        extensions.shift_remove(DRACO);
        if extensions.is_empty() {
            primitive.shift_remove("extensions");
        }
    }
    unlist(tree, DRACO);
}

/// Takes the extension's name off the lists where no view and no buffer needs it any more.
fn drop_meshopt(tree: &mut Value) {
    for name in MESHOPT {
        let has = |list: &str| {
            let all = tree.get(list).and_then(Value::as_array);
            all.is_some_and(|all| all.iter().any(|item| item.get("extensions").is_some_and(|e| e.get(name).is_some())))
        };
        if !has("bufferViews") && !has("buffers") {
            unlist(tree, name);
        }
    }
}

/// Takes an extension's name off the lists of those that are used and required.
fn unlist(tree: &mut Value, name: &str) {
    for list in ["extensionsUsed", "extensionsRequired"] {
        let Some(names) = tree.get_mut(list).and_then(Value::as_array_mut) else { continue };
        names.retain(|other| other != name);
        if names.is_empty() {
            tree.as_object_mut().map(|tree| tree.shift_remove(list));
        }
    }
}
