//! glTF 2.0: `.glb`, and `.gltf` with buffers in data URIs or files beside it.
//!
//! Read: every mesh of the default scene (or the first; or all nodes where there is none), placed by its nodes, triangle
//! lists, strips and fans, positions, the first sets of UVs and colours, base colours of materials. Objects and materials keep their names in the OBJ.
//! Own reader over serde: the mesh needs little of the format, and no file may make it panic.
//! Limits: skins and morph targets are left at rest; compressed meshes (Draco, meshopt) and sparse accessors are
//! refused; points and lines are left out.

use super::buffers::Buffers;
use super::document::{self, Document, GltfNode};
use crate::formats::error::FormatError;
use crate::formats::mark::Mark;
use crate::formats::model::{self, Model, Piece};
use crate::mesh::polygons::{Mesh, NO_UV};
use glam::{DMat3, DMat4, DQuat, DVec2, DVec3, Vec3};
use std::path::Path;

/// Reads a glTF from its bytes; `folder` is where its buffers lie. O(bytes).
pub fn read(bytes: &[u8], folder: &Path) -> Result<Model, FormatError> {
    let (document, binary) = document::read(bytes)?;
    let buffers = Buffers::load(&document, binary, folder)?;
    let model = Model { materials: materials(&document), ..Model::of(Mesh::new()) };
    let mut build = GltfBuild { document: &document, buffers, model, marks: Vec::new(), left_out: 0 };
    for (node, place) in placed_nodes(&document) {
        build.node(node, place)?;
    }
    build.finish()
}

/// The materials that pieces name by their numbers.
fn materials(document: &Document) -> Vec<model::Material> {
    let material = |material: &document::Material| model::Material {
        name: material.name.as_deref().map(plain).unwrap_or_default(),
        colour: material.pbr_metallic_roughness.as_ref().and_then(|look| look.base_color_factor),
        texture: None,
    };
    document.materials.iter().map(material).collect()
}

/// A name without line ends.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Each node of the scene once, parents first, with its place in the world. A node that is its own ancestor ends there.
fn placed_nodes(document: &Document) -> Vec<(&GltfNode, DMat4)> {
    let scene = document.scene.and_then(|s| document.scenes.get(s)).or(document.scenes.first());
    let roots = match scene {
        Some(scene) => scene.nodes.clone(),
        None => roots(document),
    };
    let mut seen = vec![false; document.nodes.len()];
    let mut stack: Vec<(usize, DMat4)> = roots.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
    let mut placed = Vec::new();
    while let Some((index, parent)) = stack.pop() {
        let Some(node) = document.nodes.get(index) else { continue };
        if core::mem::replace(&mut seen[index], true) {
            continue;
        }
        let place = parent * transform(node);
        stack.extend(node.children.iter().rev().map(|child| (*child, place)));
        placed.push((node, place));
    }
    placed
}

/// The nodes that are nobody's child.
fn roots(document: &Document) -> Vec<usize> {
    let mut is_child = vec![false; document.nodes.len()];
    for child in document.nodes.iter().flat_map(|node| &node.children) {
        if let Some(mark) = is_child.get_mut(*child) {
            *mark = true;
        }
    }
    (0..is_child.len()).filter(|i| !is_child[*i]).collect()
}

fn transform(node: &GltfNode) -> DMat4 {
    match node.matrix {
        Some(columns) => DMat4::from_cols_array(&columns),
        None => {
            // Not normalised by glam: a quaternion of length 0 is no rotation.
            let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
            let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
            DMat4::from_scale_rotation_translation(
                node.scale.map_or(DVec3::ONE, DVec3::from),
                rotation,
                node.translation.map_or(DVec3::ZERO, DVec3::from),
            )
        }
    }
}

/// How far a coordinate moves at the most where those before `place` each move by 1. 0 for what is beyond numbers.
fn stretch(place: DMat4) -> f64 {
    let DMat3 { x_axis, y_axis, z_axis } = DMat3::from_mat4(place);
    let most = (x_axis.abs() + y_axis.abs() + z_axis.abs()).max_element();
    if most.is_finite() { most } else { 0.0 }
}

struct GltfBuild<'a> {
    document: &'a Document,
    buffers: Buffers<'a>,
    model: Model,
    marks: Vec<Mark>, // of polygons; fewer where some primitive has no colour
    left_out: usize,
}

impl GltfBuild<'_> {
    fn node(&mut self, node: &GltfNode, place: DMat4) -> Result<(), FormatError> {
        let Some(mesh) = node.mesh.and_then(|mesh| self.document.meshes.get(mesh)) else { return Ok(()) };
        for primitive in &mesh.primitives {
            let Some(accessor) = primitive.attributes.position else { continue };
            let positions = self.buffers.values(accessor, 3)?;
            let normals = primitive.attributes.normal.map(|normals| self.buffers.values(normals, 3)).transpose()?;
            let uv = primitive.attributes.texture.map(|uv| self.buffers.values(uv, 2)).transpose()?;
            let indices: Vec<u32> = match primitive.indices {
                Some(indices) => self.buffers.values(indices, 1)?.into_iter().map(|i| i as u32).collect(),
                None => (0..(positions.len() / 3) as u32).collect(),
            };
            let Some(triangles) = triangles(primitive.mode.unwrap_or(TRIANGLES), &indices) else {
                self.left_out += 1;
                continue;
            };
            let material = primitive.material.filter(|m| *m < self.model.materials.len());
            self.model.pieces.push(Piece {
                first: self.model.mesh.polygon_count(),
                name: plain(node.name.as_deref().or(mesh.name.as_deref()).unwrap_or("mesh")),
                mesh: node.mesh.unwrap_or(0) as u32,
                primitive: self.model.pieces.len() as u32,
                material: material.map(|m| m as u32),
            });
            self.add(&positions, uv.as_deref(), normals.as_deref(), &triangles, place)?;
            let largest = positions.iter().fold(0.0, |largest, x| f64::max(largest, x.abs()));
            self.model.mesh.tolerance =
                self.model.mesh.tolerance.max(stretch(place) * self.buffers.precision(accessor, largest));
            match primitive.attributes.colour {
                Some(colour) => self.mark(colour, &triangles)?,
                None => {
                    let colour = material.and_then(|m| self.model.materials[m].colour);
                    let colour = colour.map(|[r, g, b, _]| Mark::colour([r, g, b]));
                    self.marks.extend(colour.into_iter().flat_map(|mark| triangles.iter().map(move |_| mark)));
                }
            }
        }
        Ok(())
    }

    /// The colour that most corners of each triangle have.
    fn mark(&mut self, accessor: usize, triangles: &[[u32; 3]]) -> Result<(), FormatError> {
        let width = self.document.accessors.get(accessor).map_or(4, |a| if a.shape == "VEC3" { 3 } else { 4 });
        let values = self.buffers.values(accessor, width)?;
        let corner = |v: &u32| values.get(width * *v as usize..).filter(|c| c.len() >= width);
        for triangle in triangles {
            let colours = triangle.iter().filter_map(corner).map(|c| Mark::colour([c[0], c[1], c[2]]));
            self.marks.extend(Mark::of_most(colours));
        }
        Ok(())
    }

    fn add(
        &mut self,
        positions: &[f64],       // (n, 3)
        uv: Option<&[f64]>,      // (n, 2)
        normals: Option<&[f64]>, // (n, 3)
        triangles: &[[u32; 3]],
        place: DMat4,
    ) -> Result<(), FormatError> {
        let mesh = &mut self.model.mesh;
        let (first, count) = (mesh.positions.len(), positions.len() / 3);
        if first + count >= u32::MAX as usize || mesh.corners.len() + 3 * triangles.len() >= u32::MAX as usize {
            return Err(FormatError::whole("more vertices or corners than 32-bit indices can name; split the mesh"));
        }
        mesh.positions.extend(positions.chunks_exact(3).map(|p| place.transform_point3(DVec3::new(p[0], p[1], p[2]))));
        let all_uv = mesh.corner_uv.get_or_insert_default();
        let all_normals = mesh.corner_normals.get_or_insert_default();
        // Cofactors, so that a node that flattens is no reason to divide by zero.
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = DMat3::from_mat4(place);
        let turned = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * place.determinant().signum();
        let mirrored = place.determinant() < 0.0;
        for [a, b, c] in triangles {
            for vertex in if mirrored { [a, c, b] } else { [a, b, c] } {
                // An index beyond its own primitive must not reach into the next one.
                let inside = (*vertex as usize) < count;
                mesh.corners.push(if inside { first as u32 + vertex } else { u32::MAX });
                let at = 3 * *vertex as usize;
                let normal = normals.and_then(|n| n.get(at..at + 3)).map(|n| turned * DVec3::new(n[0], n[1], n[2]));
                all_normals.push(normal.map_or(Vec3::ZERO, |n| n.normalize_or_zero().as_vec3()));
                let at = 2 * *vertex as usize;
                // The origin is at the top left in glTF, at the bottom left in OBJ.
                all_uv.push(uv.and_then(|uv| uv.get(at..at + 2)).map_or(NO_UV, |uv| DVec2::new(uv[0], 1.0 - uv[1])));
            }
            mesh.polygon_start.push(mesh.corners.len() as u32);
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Model, FormatError> {
        self.model = self.model.checked()?;
        if self.model.mesh.corner_uv.as_ref().is_some_and(|uv| uv.iter().all(|uv| !uv.is_finite())) {
            self.model.mesh.corner_uv = None;
        }
        if self.model.mesh.corner_normals.as_ref().is_some_and(|normals| normals.iter().all(|n| *n == Vec3::ZERO)) {
            self.model.mesh.corner_normals = None;
        }
        if self.left_out > 0 {
            self.model.warnings.push(format!("{} primitives of points or lines are left out", self.left_out));
        }
        let count = self.model.mesh.polygon_count();
        self.model.marks = Some(self.marks).filter(|marks| count > 0 && marks.len() == count);
        Ok(self.model)
    }
}

/// glTF's code for a list of triangles, the mode where none is given; strips and fans follow it.
const TRIANGLES: u32 = 4;

/// Triangles of a primitive, counter-clockwise; `None` for points and lines.
fn triangles(mode: u32, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    Some(match mode {
        TRIANGLES => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        5 => {
            let turn = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            indices.windows(3).enumerate().map(turn).collect()
        }
        6 => {
            let first = indices.first().copied().unwrap_or(0);
            indices.get(1..).unwrap_or_default().windows(2).map(|t| [first, t[0], t[1]]).collect()
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use quickcheck::quickcheck;

    /// A quad as a strip under a mirrored node, as `.glb`.
    fn glb() -> Vec<u8> {
        let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"children":[1],"scale":[-2,1,1]},
            {"mesh":0,"name":"quad","translation":[1,0,0]}],"meshes":[{"primitives":[{"mode":5,"material":0,"indices":1,
            "attributes":{"POSITION":0,"TEXCOORD_0":2}}]}],"materials":[{"name":"red\nhot"}],"buffers":[{"byteLength":64}],
            "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":8},
            {"buffer":0,"byteOffset":56,"byteLength":8}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,
            "type":"VEC3","min":[0,0,0],"max":[1,1,0]},{"bufferView":1,"componentType":5123,"count":4,"type":"SCALAR"},
            {"bufferView":2,"componentType":5121,"normalized":true,"count":4,"type":"VEC2"}]}"#;
        let mut json = json.as_bytes().to_vec();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut data: Vec<u8> =
            [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.].iter().flat_map(|x: &f32| x.to_le_bytes()).collect();
        data.extend([0u16, 1, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
        data.extend([0, 0, 255, 0, 0, 255, 255, 255]);
        let word = |n: usize| (n as u32).to_le_bytes();
        let mut out = [b"glTF".to_vec(), word(2).to_vec(), word(28 + json.len() + data.len()).to_vec()].concat();
        out.extend([&word(json.len())[..], b"JSON", &json, &word(data.len()), b"BIN\0", &data].concat());
        out
    }

    #[test]
    fn a_strip_under_a_mirrored_node_keeps_its_outside() {
        let model = read(&glb(), Path::new("")).unwrap();
        assert_eq!(model.mesh.positions[1], DVec3::new(-4.0, 0.0, 0.0));
        assert_eq!(model.mesh.corners, [0, 2, 1, 2, 3, 1]);
        assert_eq!(model.mesh.corner_uv.unwrap()[..2], [DVec2::new(0.0, 1.0), DVec2::new(0.0, 0.0)]);
        assert_eq!((&model.pieces[0].name[..], &model.materials[0].name[..]), ("quad", "red hot"));
        assert_eq!(model.mesh.corner_normals, None);
        // Half a last bit of 1, twice as large by the node's scale.
        assert_eq!(model.mesh.tolerance, 0.5f64.powi(23));
    }

    #[test]
    fn compressed_meshes_are_refused_by_name() {
        let json = r#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"]}"#;
        let problem = read(json.as_bytes(), Path::new("")).unwrap_err().problem;
        assert!(problem.contains("KHR_draco"), "{problem}");
    }

    #[test]
    fn a_file_that_is_no_gltf_is_an_error() {
        assert!(read(b"", Path::new("")).is_err());
        assert!(read(b"{}", Path::new("")).is_err());
        let bytes = glb();
        assert!(read(&bytes[..bytes.len() - 10], Path::new("")).is_err());
    }

    quickcheck! {
        fn damaged_files_never_panic(at: usize, byte: u8, digit: u8) -> bool {
            let mut bytes = glb();
            let length = bytes.len();
            bytes[at % length] = byte;
            let _ = read(&bytes, Path::new(""));
            let mut bytes = glb();
            let digits: Vec<usize> = (0..length).filter(|i| bytes[*i].is_ascii_digit()).collect();
            bytes[digits[at % digits.len()]] = b'0' + digit % 10;
            let _ = read(&bytes, Path::new(""));
            true
        }
    }
}
