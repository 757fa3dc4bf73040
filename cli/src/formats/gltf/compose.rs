//! A glTF from scratch, for meshes that came in another format.
//!
//! A node and a mesh for each object, a primitive for each of its materials. Polygons become triangles, since a glTF has no
//! others; positions become floats; a vertex stands once for each normal (and old UV) that its corners have. Normals are
//! made for corners without one where others have some. Colours become linear light.

use super::buffers::Buffers;
use super::container::Container;
use super::document::Document;
use super::file::{GltfFile, Surface};
use super::uri::of_file;
use super::write::{self, WriteError};
use crate::base::colour::decoded;
use crate::formats::error::FormatError;
use crate::formats::model::{Material, Model, Piece};
use crate::formats::target::{Files, Mapping, Target};
use crate::mesh::polygons::Mesh;
use glam::{DVec2, DVec3, Vec3};
use seamwright_core::base::scratch::Scratch;
use seamwright_core::mesh::polygon::{triangulate, triangulate_need};
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;

/// Refuses, before any work, what [`write`] could not write: coordinates that no float holds.
pub fn writable(model: &Model) -> Result<(), FormatError> {
    let mesh = &model.mesh;
    let beyond = mesh.corners.iter().find(|v| !mesh.positions[**v as usize].as_vec3().is_finite());
    beyond.map_or(Ok(()), |v| {
        let text = format!("vertex {v} (from 0) has a coordinate beyond the single precision of a glTF");
        Err(FormatError::whole(text + "; scale the mesh down, or write OBJ or PLY"))
    })
}

/// The files of `model` as a glTF with the UVs of `mapping`.
pub fn write(model: &Model, target: &Target, mapping: Mapping) -> Result<Files<'static>, WriteError> {
    let with_old_uv = (target.keep || target.uv_set > 0) && model.mesh.corner_uv.is_some();
    let (file, corner_of) = compose(model, with_old_uv).map_err(WriteError::Format)?;
    let corner_uv: Vec<DVec2> = corner_of.iter().map(|c| mapping.corner_uv[*c as usize]).collect();
    write::write(&file, target, Mapping { corner_uv: &corner_uv, groups: None })
}

/// A glTF of `model` without UVs, or with those that it has as set 0, and the corner of the model for each of its triangles'.
pub(super) fn compose(model: &Model, with_old_uv: bool) -> Result<(GltfFile, Vec<u32>), FormatError> {
    let mut scene =
        NewScene { model, with_old_uv, tree: head(&model.materials), data: Vec::new(), corner_of: Vec::new() };
    let mut surfaces = Vec::new();
    for (name, parts) in objects(model) {
        scene.object(&name, parts, &mut surfaces);
    }
    let NewScene { mut tree, data, corner_of, .. } = scene;
    tree["buffers"] = json!([{ "byteLength": data.len() }]);
    let document = Document::of(&tree)?;
    let buffers = Buffers::of(data, &document);
    let container = Container { tree, is_binary: true, ..Container::default() };
    let file = GltfFile { container, document, buffers, surfaces, folder: PathBuf::new(), model: Model::default() };
    Ok((file, corner_of))
}

fn head(materials: &[Material]) -> Value {
    let mut tree = json!({
        "asset": { "version": "2.0", "generator": "seamwright" },
        "scene": 0, "scenes": [{ "nodes": [] }], "nodes": [], "meshes": [],
        "accessors": [], "bufferViews": [],
    });
    let (mut images, mut textures) = (Vec::new(), Vec::new());
    let all = materials.iter().map(|material| {
        let mut look = Map::new();
        if let Some(colour) = material.colour {
            look.insert("baseColorFactor".into(), json!(colour));
        }
        if let Some(texture) = &material.texture {
            look.insert("baseColorTexture".into(), json!({ "index": textures.len() }));
            textures.push(json!({ "source": images.len() }));
            images.push(json!({ "uri": of_file(&texture.replace('\\', "/")) }));
        }
        look.insert("metallicFactor".into(), json!(0.0));
        let mut made = json!({ "name": material.name, "pbrMetallicRoughness": look });
        if material.colour.is_some_and(|[.., opacity]| opacity < 1.0) {
            made["alphaMode"] = json!("BLEND");
        }
        made
    });
    let all: Vec<Value> = all.collect();
    for (key, list) in [("materials", all), ("textures", textures), ("images", images)] {
        if !list.is_empty() {
            tree[key] = json!(list);
        }
    }
    tree
}

/// Polygons of one material.
type Part = (Option<u32>, Vec<usize>);

/// Each object with its parts, in the order in which they come first.
fn objects(model: &Model) -> Vec<(String, Vec<Part>)> {
    let all = Piece { name: "mesh".into(), ..Piece::default() };
    let first = model.pieces.first().map_or(model.mesh.polygon_count(), |piece| piece.first);
    let runs = [(&all, 0..first)].into_iter().chain(model.runs());
    let mut place_of = HashMap::new();
    let mut objects: Vec<(String, Vec<Part>)> = Vec::new();
    for (piece, polygons) in runs.filter(|(_, polygons)| !polygons.is_empty()) {
        let place = *place_of.entry((piece.mesh, &piece.name)).or_insert(objects.len());
        if place == objects.len() {
            objects.push((piece.name.clone(), Vec::new()));
        }
        let parts = &mut objects[place].1;
        match parts.iter_mut().find(|part| part.0 == piece.material) {
            Some(part) => part.1.extend(polygons),
            None => parts.push((piece.material, polygons.collect())),
        }
    }
    objects
}

struct NewScene<'a> {
    model: &'a Model,
    with_old_uv: bool,
    tree: Value,
    data: Vec<u8>,
    corner_of: Vec<u32>,
}

/// What makes two corners one vertex: vertex, normal, old UV.
type Key = (u32, [u32; 3], [u64; 2]);

impl NewScene<'_> {
    fn object(&mut self, name: &str, parts: Vec<Part>, surfaces: &mut Vec<Surface>) {
        let mesh = &self.model.mesh;
        let number = |tree: &Value, list: &str| tree[list].as_array().map_or(0, Vec::len);
        let mut vertex_of: HashMap<Key, u32> = HashMap::new();
        let mut vertices: Vec<u32> = Vec::new(); // a corner of each
        let mut normals: Vec<Vec3> = Vec::new();
        let mut primitives = Vec::new();
        for (material, polygons) in parts {
            let first = self.corner_of.len();
            let mut triangles = Vec::new();
            for p in polygons {
                let corners = mesh.polygon(p);
                let normal = flat_normal(mesh, corners.clone());
                for triangle in cut(mesh, corners) {
                    triangles.push(triangle.map(|c| {
                        self.corner_of.push(c);
                        let own = mesh.corner_normals.as_ref().map(|all| all[c as usize].normalize_or_zero());
                        let own = own.map_or(Vec3::ZERO, |own| if own == Vec3::ZERO { normal } else { own });
                        let uv = mesh.corner_uv.as_ref().filter(|_| self.with_old_uv).map(|uv| uv[c as usize]);
                        let uv = uv.map_or([0; 2], |uv| uv.to_array().map(f64::to_bits));
                        let key = (mesh.corners[c as usize], own.to_array().map(f32::to_bits), uv);
                        *vertex_of.entry(key).or_insert_with(|| {
                            vertices.push(c);
                            normals.push(own);
                            vertices.len() as u32 - 1
                        })
                    }));
                }
            }
            surfaces.push(Surface {
                users: vec![[number(&self.tree, "meshes"), primitives.len()]],
                triangles,
                first,
                is_mirrored: false,
            });
            primitives.push(material);
        }
        let attributes = self.attributes(&vertices, &normals);
        let added = surfaces.len() - primitives.len();
        let made = primitives.iter().zip(&surfaces[added..]).map(|(material, surface)| {
            let mut made =
                json!({ "attributes": attributes, "indices": self.indices(&surface.triangles, vertices.len()) });
            if let Some(material) = material {
                made["material"] = json!(material);
            }
            made
        });
        let primitives: Vec<Value> = made.collect();
        let place = number(&self.tree, "meshes");
        push(&mut self.tree["meshes"], json!({ "name": name, "primitives": primitives }));
        push(&mut self.tree["nodes"], json!({ "name": name, "mesh": place }));
        push(&mut self.tree["scenes"][0]["nodes"], json!(place));
    }

    /// Accessors of the vertices that these corners stand for.
    fn attributes(&mut self, vertices: &[u32], normals: &[Vec3]) -> Value {
        let mesh = &self.model.mesh;
        let place = |c: &u32| mesh.positions[mesh.corners[*c as usize] as usize].as_vec3() + Vec3::ZERO; // -0 becomes 0
        let positions: Vec<Vec3> = vertices.iter().map(place).collect();
        let low = positions.iter().copied().reduce(Vec3::min).unwrap_or_default();
        let high = positions.iter().copied().reduce(Vec3::max).unwrap_or_default();
        let mut attributes = BTreeMap::new();
        let flat = positions.iter().flat_map(|p| p.to_array());
        let bounds = json!({ "min": low.to_array(), "max": high.to_array() });
        attributes.insert("POSITION", self.accessor(flat.collect(), "VEC3", vertices.len(), bounds));
        if mesh.corner_normals.is_some() {
            let flat = normals.iter().flat_map(|n| n.to_array());
            attributes.insert("NORMAL", self.accessor(flat.collect(), "VEC3", vertices.len(), json!({})));
        }
        if let Some(colours) = &self.model.colours {
            let light = |c: &u32| decoded(colours[mesh.corners[*c as usize] as usize]);
            let flat = vertices.iter().flat_map(light);
            attributes.insert("COLOR_0", self.accessor(flat.collect(), "VEC4", vertices.len(), json!({})));
        }
        if let Some(uv) = mesh.corner_uv.as_ref().filter(|_| self.with_old_uv) {
            let flip = |c: &u32| {
                let DVec2 { x, y } = uv[*c as usize];
                let uv = [x as f32, (1.0 - y) as f32];
                if uv.iter().all(|x| x.is_finite()) { uv } else { [0.0; 2] }
            };
            let flat = vertices.iter().flat_map(flip);
            attributes.insert("TEXCOORD_0", self.accessor(flat.collect(), "VEC2", vertices.len(), json!({})));
        }
        json!(attributes)
    }

    fn accessor(&mut self, numbers: Vec<f32>, shape: &str, count: usize, rest: Value) -> usize {
        let bytes: Vec<u8> = numbers.into_iter().flat_map(f32::to_le_bytes).collect();
        let mut made =
            json!({ "bufferView": self.view(&bytes, 34962), "componentType": 5126, "count": count, "type": shape });
        for (key, value) in rest.as_object().into_iter().flatten() {
            made[key] = value.clone();
        }
        push(&mut self.tree["accessors"], made)
    }

    fn indices(&mut self, triangles: &[[u32; 3]], vertices: usize) -> usize {
        let (code, width) = if vertices < usize::from(u16::MAX) { (5123, 2) } else { (5125, 4) };
        let flat = triangles.as_flattened();
        let bytes: Vec<u8> = flat.iter().flat_map(|i| i.to_le_bytes().into_iter().take(width)).collect();
        let view = self.view(&bytes, 34963);
        push(
            &mut self.tree["accessors"],
            json!({ "bufferView": view, "componentType": code, "count": flat.len(), "type": "SCALAR" }),
        )
    }

    fn view(&mut self, bytes: &[u8], target: u32) -> usize {
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        let start = self.data.len();
        self.data.extend(bytes);
        push(
            &mut self.tree["bufferViews"],
            json!({ "buffer": 0, "byteOffset": start, "byteLength": bytes.len(), "target": target }),
        )
    }
}

/// Appends to a list of the tree; gives the place.
fn push(list: &mut Value, item: Value) -> usize {
    let Some(list) = list.as_array_mut() else { return 0 };
    list.push(item);
    list.len() - 1
}

/// The triangles of a polygon, as corners of the mesh.
fn cut(mesh: &Mesh, corners: core::ops::Range<usize>) -> Vec<[u32; 3]> {
    let (first, n) = (corners.start as u32, corners.len());
    if n == 3 {
        return vec![[first, first + 1, first + 2]];
    }
    let points: Vec<DVec3> = corners.map(|c| mesh.positions[mesh.corners[c] as usize]).collect();
    let mut triangles = vec![[0; 3]; n - 2];
    let mut bytes = vec![0; triangulate_need(n)];
    // Whether the polygon is simple decides nothing here: there are as many triangles in any case.
    let _ = triangulate(&mut triangles, &points, Scratch::new(&mut bytes));
    triangles.iter().map(|t| t.map(|i| first + i)).collect()
}

/// The direction of a polygon's area, by Newell's sum.
fn flat_normal(mesh: &Mesh, corners: core::ops::Range<usize>) -> Vec3 {
    let at = |c: usize| mesh.positions[mesh.corners[c] as usize];
    let origin = at(corners.start);
    let ends = corners.clone().zip(corners.clone().skip(1));
    let sum: DVec3 = ends.map(|(a, b)| (at(a) - origin).cross(at(b) - origin)).sum();
    let normal = sum.normalize_or_zero().as_vec3();
    if normal == Vec3::ZERO { Vec3::Z } else { normal } // what has no area may face anywhere
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_beyond_floats_are_refused_before_any_work() {
        let of = |far: f64, corners: &[u32]| {
            let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z * far];
            Model::of(Mesh { positions, corners: corners.to_vec(), polygon_start: vec![0, 3], ..Mesh::default() })
        };
        assert!(writable(&of(3e38, &[0, 1, 3])).is_ok());
        assert!(writable(&of(1e39, &[0, 1, 2])).is_ok(), "no polygon has it");
        let error = writable(&of(-1e39, &[0, 1, 3])).unwrap_err();
        assert!(error.problem.contains("vertex 3"), "{}", error.problem);
    }
}
