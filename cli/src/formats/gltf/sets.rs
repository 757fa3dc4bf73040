//! Sets of UVs: which are free, and what in a file belongs to the UVs that go.

use super::document::{Document, texcoord};
use super::file::GltfFile;
use super::pools::primitives;
use serde_json::{Value, json};

/// The lowest set that no primitive has.
pub(super) fn free_set(document: &Document) -> u32 {
    let has = |set: u32| primitives(document).any(|(_, primitive)| primitive.attributes.contains_key(&texcoord(set)));
    (0..).find(|set| !has(*set)).unwrap_or(0)
}

/// Makes the textures of materials that had set `set` take `moved`.
pub(super) fn follow(tree: &mut Value, set: u32, moved: u32) {
    let mut stack: Vec<&mut Value> = tree.get_mut("materials").into_iter().collect();
    while let Some(value) = stack.pop() {
        match value {
            Value::Array(items) => stack.extend(items),
            Value::Object(items) => {
                for (key, item) in items.iter_mut() {
                    if key.ends_with("Texture") && item.get("index").is_some_and(Value::is_u64) {
                        turn(item, set, moved);
                    }
                    stack.push(item);
                }
            }
            _ => {}
        }
    }
}

/// Makes one use of a texture take `moved`; what its transform says of the set goes first.
fn turn(used: &mut Value, set: u32, moved: u32) {
    let is_set = |place: &Value| place.get("texCoord").map_or(set == 0, |number| *number == json!(set));
    if is_set(used) {
        used["texCoord"] = json!(moved);
    }
    if let Some(transform) = used.get_mut("extensions").and_then(|e| e.get_mut("KHR_texture_transform"))
        && transform.get("texCoord").is_some()
        && is_set(transform)
    {
        transform["texCoord"] = json!(moved);
    }
}

/// What stays as it was though it belongs to the UVs that are replaced: a warning each.
pub(super) fn other_uses(file: &GltfFile, set: u32, moved: Option<u32>) -> Vec<String> {
    let document = &file.document;
    let mut warnings = Vec::new();
    let has_old = |attributes: &std::collections::BTreeMap<String, usize>| attributes.contains_key(&texcoord(set));
    if moved.is_none() {
        let tangents = primitives(document).filter(|(_, primitive)| {
            let of_set = |m: usize| {
                let used = document.materials.get(m).and_then(|material| material.normal_texture.as_ref());
                used.is_some_and(|used| used.tex_coord == set)
            };
            primitive.attributes.contains_key("TANGENT") && primitive.material.is_some_and(of_set)
        });
        let count = tangents.count();
        if count > 0 {
            warnings.push(format!("{count} primitives keep the tangents of their old UVs; compute them again"));
        }
        let placed = file.container.tree.get("materials").is_some_and(|m| names(m, "KHR_texture_transform"));
        if placed && primitives(document).any(|(_, primitive)| has_old(&primitive.attributes)) {
            warnings.push("materials place their textures by KHR_texture_transform, which stays".into());
        }
    }
    let lacking = |attributes: &std::collections::BTreeMap<String, usize>| {
        (0..set).any(|lower| !attributes.contains_key(&texcoord(lower)))
    };
    let count = file.surfaces.iter().flat_map(|surface| &surface.users);
    let count = count.filter(|[m, p]| lacking(&document.meshes[*m].primitives[*p].attributes)).count();
    if count > 0 {
        warnings.push(format!("{count} primitives have no UVs below {}; they get the same there", texcoord(set)));
    }
    warnings
}

/// Whether some key below `tree` has this name.
fn names(tree: &Value, name: &str) -> bool {
    match tree {
        Value::Array(items) => items.iter().any(|item| names(item, name)),
        Value::Object(items) => items.iter().any(|(key, item)| key == name || names(item, name)),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_follow_the_uvs_that_they_had() {
        let mut tree = json!({"materials": [{
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
            "normalTexture": {"index": 1, "texCoord": 1, "extensions": {"KHR_texture_transform": {"texCoord": 0}}},
            "extensions": {"KHR_materials_clearcoat": {"clearcoatTexture": {"index": 0, "texCoord": 0}}},
        }]});
        follow(&mut tree, 0, 2);
        let material = &tree["materials"][0];
        assert_eq!(material["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"], 2);
        assert_eq!(material["normalTexture"]["texCoord"], 1);
        assert_eq!(material["normalTexture"]["extensions"]["KHR_texture_transform"]["texCoord"], 2);
        assert_eq!(material["extensions"]["KHR_materials_clearcoat"]["clearcoatTexture"]["texCoord"], 2);
    }
}
