//! A coloured GLB: a primitive and a material of each part over shared vertices.
//!
//! Polygons are fans from their first corner. Lit from one side by any viewer; normals are left to it, as the format allows.

use crate::base::colour::linear;
use crate::mesh::polygons::Mesh;
use seamwright_core::judge::input::fan;
use serde_json::json;
use std::io::{self, Write};

/// Writes `mesh` with `colours[l]` (sRGB) on each polygon of label l; an error, before any byte, where a coordinate is beyond floats.
pub fn write(out: &mut dyn Write, mesh: &Mesh, labels: &[u32], colours: &[[u8; 3]]) -> io::Result<()> {
    if let Some(v) = mesh.positions.iter().position(|p| !p.as_vec3().is_finite()) {
        let text = format!("vertex {v} (from 0) is beyond the single precision of a GLB; write a .ply, .seg or .json");
        return Err(io::Error::other(text));
    }
    let mut data: Vec<u8> = Vec::new();
    let single = |p: &glam::DVec3| p.as_vec3().to_array();
    data.extend(mesh.positions.iter().flat_map(single).flat_map(f32::to_le_bytes));
    let mut triangles: Vec<Vec<u32>> = vec![Vec::new(); colours.len()];
    for (ends, label) in mesh.polygon_start.windows(2).zip(labels) {
        let corners = fan(ends[0], ends[1]).flatten();
        triangles[*label as usize].extend(corners.map(|c| mesh.corners[c as usize]));
    }
    let bound = |pick: fn(f32, f32) -> f32, start: f32| {
        mesh.positions.iter().map(single).fold([start; 3], |a, p| [0, 1, 2].map(|i| pick(a[i], p[i])))
    };
    let mut accessors = vec![json!({
        "bufferView": 0, "componentType": 5126, "count": mesh.positions.len(), "type": "VEC3",
        "min": bound(f32::min, f32::INFINITY), "max": bound(f32::max, f32::NEG_INFINITY),
    })];
    let mut views = vec![json!({ "buffer": 0, "byteOffset": 0, "byteLength": data.len(), "target": 34962 })];
    let (mut primitives, mut materials) = (vec![], vec![]);
    for (label, corners) in triangles.iter().enumerate().filter(|(_, corners)| !corners.is_empty()) {
        primitives.push(json!({
            "attributes": { "POSITION": 0 }, "indices": accessors.len(), "material": materials.len(),
        }));
        let light = linear(colours[label]).to_array();
        materials.push(json!({
            "name": format!("part{label}"), "doubleSided": true,
            "pbrMetallicRoughness": {
                "baseColorFactor": [light[0], light[1], light[2], 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9,
            },
        }));
        accessors.push(
            json!({ "bufferView": views.len(), "componentType": 5125, "count": corners.len(), "type": "SCALAR" }),
        );
        let length = 4 * corners.len();
        views.push(json!({ "buffer": 0, "byteOffset": data.len(), "byteLength": length, "target": 34963 }));
        data.extend(corners.iter().flat_map(|v| v.to_le_bytes()));
    }
    let document = json!({
        "asset": { "version": "2.0", "generator": "seamwright" },
        "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": primitives }], "materials": materials,
        "accessors": accessors, "bufferViews": views, "buffers": [{ "byteLength": data.len() }],
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    // The container counts in 32 bits.
    let word = |n: usize| u32::try_from(n).map(u32::to_le_bytes).map_err(|_| io::Error::other("more than 4 GiB"));
    out.write_all(b"glTF")?;
    out.write_all(&2u32.to_le_bytes())?;
    out.write_all(&word(28 + text.len() + data.len())?)?;
    out.write_all(&word(text.len())?)?;
    out.write_all(b"JSON")?;
    out.write_all(&text)?;
    out.write_all(&word(data.len())?)?;
    out.write_all(b"BIN\0")?;
    out.write_all(&data)
}
