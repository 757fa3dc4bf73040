//! What a glTF holds that no other format takes from here, in words for a warning.

use super::document::{Document, GltfMaterial, texcoord};
use std::collections::BTreeSet;

/// What else than triangles, one set of UVs, normals, colours and base colours there is.
pub(super) fn rest(document: &Document, uv_set: u32) -> Vec<String> {
    let primitives = || document.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let targets = document.meshes.iter().map(|m| m.primitives.iter().map(|p| p.targets.len()).max().unwrap_or(0)).sum();
    let lights =
        document.extensions.get("KHR_lights_punctual").and_then(|e| e["lights"].as_array()).map_or(0, Vec::len);
    let counted: [(usize, &str); 5] = [
        (document.skins.len(), "skin"),
        (targets, "morph target"),
        (document.animations.len(), "animation"),
        (document.cameras.len(), "camera"),
        (lights, "light"),
    ];
    let counted = counted.into_iter().filter(|(count, _)| *count > 0);
    let mut all: Vec<String> =
        counted.map(|(count, what)| format!("{count} {what}{}", if count == 1 { "" } else { "s" })).collect();
    let (own, names): (_, BTreeSet<&str>) =
        (texcoord(uv_set), primitives().flat_map(|p| p.attributes.keys().map(String::as_str)).collect());
    let taken = |name: &str| ["POSITION", "NORMAL", "COLOR_0"].contains(&name) || name == own;
    let skinned = |name: &str| name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_");
    all.extend(names.into_iter().filter(|name| !taken(name) && !skinned(name)).map(String::from));
    let base = |look: &GltfMaterial| {
        look.pbr_metallic_roughness.as_ref().and_then(|look| look.base_color_texture.as_ref()).is_some()
    };
    let others = document.textures.len().saturating_sub(document.materials.iter().filter(|m| base(m)).count());
    if others > 0 {
        all.push("textures of more than base colours".into());
    }
    // What was read or told above.
    let known = ["KHR_lights_punctual", "KHR_mesh_quantization", "EXT_meshopt_compression", "KHR_meshopt_compression"];
    let extensions = document.extensions_used.iter().filter(|name| !known.contains(&name.as_str()));
    all.extend(extensions.cloned());
    all
}
