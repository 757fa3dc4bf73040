//! glTF 2.0: `.glb`, and `.gltf` with buffers in data URIs or files beside it.
//!
//! Read: triangle lists, strips and fans, positions, normals, one set of UVs, the first colours, base colours of materials.
//! Every mesh stands once, where the default scene draws it largest; those that it does not draw stand aside of it, so that
//! nothing hides behind them. Or, for formats without instances, all copies that the default scene draws.
//! Limits: skins and morph targets are left at rest; Draco is refused by name; points and lines are left out.

use super::beside;
use super::buffers::Buffers;
use super::container::Container;
use super::document::{Document, Primitive, texcoord};
use super::file::{GltfFile, Surface};
use super::numbers::Numbers;
use super::rest::rest;
use super::scene::{Draw, draws, size, stretch};
use super::surface::{TRIANGLES, is_surface, triangles};
use crate::base::colour::encoded;
use crate::formats::error::FormatError;
use crate::formats::mark::Mark;
use crate::formats::model::{Material, Model, Piece};
use crate::formats::reading::Reading;
use crate::mesh::polygons::{Mesh, NO_UV};
use glam::{DMat3, DMat4, DVec2, DVec3, Vec3};
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// Reads a glTF from its bytes; `folder` is where its buffers lie. O(bytes).
pub fn read(bytes: &[u8], folder: &Path, reading: Reading) -> Result<GltfFile, FormatError> {
    let mut container = Container::open(bytes)?;
    let document = Document::of(&container.tree)?;
    let buffers = Buffers::load(&document, container.chunk.take(), folder)?;
    let numbers = Numbers { document: &document, buffers: &buffers };
    let model = Model {
        materials: materials(&document),
        rest: rest(&document, reading.uv_set),
        named: beside::files_of(&container.tree),
        ..Model::of(Mesh::new())
    };
    let mut build = GltfBuild { numbers, reading, model, marks: Vec::new(), surfaces: Vec::new(), left_out: 0 };
    let draws = draws(numbers)?;
    if reading.copies {
        for draw in draws.iter().filter(|draw| draw.is_seen) {
            for p in 0..document.meshes[draw.mesh].primitives.len() {
                build.add(*draw, &[[draw.mesh, p]])?;
            }
        }
    } else {
        build.each_once(&draws)?;
    }
    let (model, surfaces) = build.finish(unknown(&document))?;
    Ok(GltfFile { container, document, buffers, surfaces, folder: folder.to_path_buf(), model })
}

/// The materials that pieces name by their numbers.
fn materials(document: &Document) -> Vec<Material> {
    let all = document.materials.iter().map(|material| {
        let look = material.pbr_metallic_roughness.as_ref();
        let texture = look.and_then(|look| look.base_color_texture.as_ref());
        let image = texture.and_then(|used| document.textures.get(used.index)?.source);
        Material {
            name: material.name.as_deref().map(plain).unwrap_or_default(),
            colour: look.and_then(|look| look.base_color_factor),
            texture: image.and_then(|image| Some(plain(&document.images.get(image)?.file_name(image)))),
        }
    });
    all.collect()
}

/// A name without line ends.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// What a file requires and this reader knows nothing of: a warning each. What is missing to find the geometry is found
/// missing by whoever looks for it.
fn unknown(document: &Document) -> Vec<String> {
    const NAMED: [&str; 6] = ["KHR_", "EXT_", "MSFT_", "VRM", "ADOBE_", "GOOGLE_"];
    let strange = document.extensions_required.iter().filter(|name| !NAMED.iter().any(|known| name.starts_with(known)));
    strange.map(|name| format!("it requires {name}, which is not known here and stays as it is")).collect()
}

struct GltfBuild<'a> {
    numbers: Numbers<'a>,
    reading: Reading,
    model: Model,
    marks: Vec<Mark>, // of polygons; fewer where some primitive has no colour
    surfaces: Vec<Surface>,
    left_out: usize,
}

impl GltfBuild<'_> {
    /// Every surface once, where it is largest of the places where the default scene draws it.
    fn each_once(&mut self, draws: &[Draw]) -> Result<(), FormatError> {
        let document = self.numbers.document;
        let mut place_of = HashMap::new();
        let mut found: Vec<(Draw, Vec<[usize; 2]>)> = Vec::new();
        for draw in draws {
            for (p, primitive) in document.meshes[draw.mesh].primitives.iter().enumerate() {
                let same = (primitive.attributes.get("POSITION"), primitive.indices, primitive.mode);
                let at = *place_of.entry(same).or_insert(found.len());
                if at == found.len() {
                    found.push((*draw, Vec::new()));
                }
                let (best, users) = &mut found[at];
                // Not by the last bit, which a rotation changes.
                if draw.is_seen && size(draw.place) > size(best.place) * (1.0 + 1e-9) {
                    *best = *draw;
                }
                if !users.contains(&[draw.mesh, p]) {
                    users.push([draw.mesh, p]);
                }
            }
        }
        let mut aside = None; // mesh and first vertex of what stands aside
        for (draw, users) in found {
            let first = self.model.mesh.positions.len();
            if aside.is_some_and(|(mesh, _)| draw.is_seen || mesh != draw.mesh) {
                self.move_aside(aside.take());
            }
            if !draw.is_seen {
                aside.get_or_insert((draw.mesh, first));
            }
            self.add(draw, &users)?;
        }
        self.move_aside(aside);
        Ok(())
    }

    /// Moves the last vertices along x, away from all before them.
    fn move_aside(&mut self, aside: Option<(usize, usize)>) {
        let Some((_, first)) = aside else { return };
        let (before, moved) = self.model.mesh.positions.split_at_mut(first);
        let end = before.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
        let start = moved.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
        let width = moved.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max) - start;
        let shift = end - start + 0.5 * width;
        if shift.is_finite() {
            moved.iter_mut().for_each(|p| p.x += shift);
        }
    }

    /// Adds the primitive of `users`, which all have the same triangles, at the place of `draw`.
    fn add(&mut self, draw: Draw, users: &[[usize; 2]]) -> Result<(), FormatError> {
        let document = self.numbers.document;
        let [m, p] = users[0];
        let primitive = &document.meshes[m].primitives[p];
        let Some(positions) = primitive.attributes.get("POSITION").copied() else { return Ok(()) };
        let mode = primitive.mode.unwrap_or(TRIANGLES);
        if !is_surface(mode) {
            self.left_out += 1;
            return Ok(());
        }
        if document.accessors.get(positions).is_some_and(|a| a.buffer_view.is_none() && a.sparse.is_none()) {
            let text = format!("the positions of mesh {m} have no bytes; export it again, without compression");
            return Err(draco(document, [m, p]).unwrap_or(FormatError::whole(text)));
        }
        let read = |index, width| self.numbers.values(index, width);
        let points = read(positions, 3)?;
        let indices: Vec<u32> = match primitive.indices {
            Some(indices) => read(indices, 1)?.into_iter().map(|i| i as u32).collect(),
            None => (0..(points.len() / 3) as u32).collect(),
        };
        let attribute = |name: &str, width| primitive.attributes.get(name).map(|index| read(*index, width)).transpose();
        let (uv, normals) = (attribute(&texcoord(self.reading.uv_set), 2)?, attribute("NORMAL", 3)?);
        let colours = attribute("COLOR_0", self.colour_width(primitive))?;
        let triangles = triangles(mode, &indices);
        let count = points.len() / 3;
        if let Some(vertex) = triangles.as_flattened().iter().find(|vertex| **vertex as usize >= count) {
            let text = format!("primitive {p} of mesh {m} names vertex {vertex} (all from 0), but there are {count}");
            return Err(FormatError::whole(text + "; correct its indices"));
        }

        let (mesh, node) = (&document.meshes[m], draw.node.map(|node| &document.nodes[node]));
        let material = primitive.material.filter(|m| *m < self.model.materials.len());
        self.model.pieces.push(Piece {
            first: self.model.mesh.polygon_count(),
            name: plain(node.and_then(|node| node.name.as_deref()).or(mesh.name.as_deref()).unwrap_or("mesh")),
            mesh: m as u32,
            primitive: self.model.pieces.len() as u32,
            material: material.map(|m| m as u32),
        });
        self.surfaces.push(Surface {
            users: users.to_vec(),
            triangles,
            first: self.model.mesh.corners.len(),
            is_mirrored: draw.place.determinant() < 0.0,
        });
        self.colour(colours.as_deref(), self.colour_width(primitive), material, points.len() / 3);
        self.append(&points, uv.as_deref(), normals.as_deref(), draw.place)?;
        let largest = points.iter().fold(0.0, |largest, x| f64::max(largest, x.abs()));
        let tolerance = stretch(draw.place) * self.numbers.precision(positions, largest);
        self.model.mesh.tolerance = self.model.mesh.tolerance.max(tolerance);
        Ok(())
    }

    fn colour_width(&self, primitive: &Primitive) -> usize {
        let accessor =
            primitive.attributes.get("COLOR_0").and_then(|index| self.numbers.document.accessors.get(*index));
        accessor.map_or(4, |a| if a.shape == "VEC3" { 3 } else { 4 })
    }

    /// Colours of the vertices that the last surface adds, and what they, or its material, say of its triangles.
    fn colour(&mut self, colours: Option<&[f64]>, width: usize, material: Option<usize>, vertices: usize) {
        let (Some(surface), before) = (self.surfaces.last(), self.model.mesh.positions.len()) else { return };
        let Some(colours) = colours else {
            let colour = material.and_then(|m| self.model.materials[m].colour);
            let mark = colour.map(|[r, g, b, _]| Mark::colour([r, g, b]));
            self.marks.extend(mark.into_iter().flat_map(|mark| surface.triangles.iter().map(move |_| mark)));
            if let Some(all) = &mut self.model.colours {
                all.resize(before + vertices, [1.0; 4]);
            }
            return;
        };
        let corner = |v: &u32| colours.get(width * *v as usize..).filter(|c| c.len() >= width);
        for triangle in &surface.triangles {
            let most = triangle.iter().filter_map(corner).map(|c| Mark::colour([c[0], c[1], c[2]]));
            self.marks.extend(Mark::of_most(most));
        }
        let all = self.model.colours.get_or_insert_default();
        all.resize(before, [1.0; 4]);
        // sRGB, as a screen takes them; the file has linear light.
        let own = colours.chunks_exact(width).map(|c| [c[0], c[1], c[2], c.get(3).copied().unwrap_or(1.0)]);
        all.extend(own.take(vertices).map(encoded));
        all.resize(before + vertices, [1.0; 4]);
    }

    /// Appends the triangles of the last surface.
    fn append(
        &mut self,
        points: &[f64],          // (n, 3)
        uv: Option<&[f64]>,      // (n, 2)
        normals: Option<&[f64]>, // (n, 3)
        place: DMat4,
    ) -> Result<(), FormatError> {
        let (mesh, Some(surface)) = (&mut self.model.mesh, self.surfaces.last()) else { return Ok(()) };
        let (first, count) = (mesh.positions.len(), points.len() / 3);
        if first + count >= u32::MAX as usize || mesh.corners.len() + 3 * surface.triangles.len() >= u32::MAX as usize {
            return Err(FormatError::whole("more vertices or corners than 32-bit indices can name; split the mesh"));
        }
        mesh.positions.extend(points.chunks_exact(3).map(|p| place.transform_point3(DVec3::new(p[0], p[1], p[2]))));
        let all_uv = mesh.corner_uv.get_or_insert_default();
        let all_normals = mesh.corner_normals.get_or_insert_default();
        // Cofactors, so that a node that flattens is no reason to divide by zero.
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = DMat3::from_mat4(place);
        let turned = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * place.determinant().signum();
        for [a, b, c] in &surface.triangles {
            for vertex in if surface.is_mirrored { [a, c, b] } else { [a, b, c] } {
                mesh.corners.push(first as u32 + vertex);
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

    fn finish(self, mut warnings: Vec<String>) -> Result<(Model, Vec<Surface>), FormatError> {
        let mut model = self.model.checked()?;
        let Mesh { corner_uv, corner_normals, .. } = &mut model.mesh;
        corner_uv.take_if(|uv| uv.iter().all(|uv| !uv.is_finite()));
        corner_normals.take_if(|normals| normals.iter().all(|n| *n == Vec3::ZERO));
        if self.left_out > 0 {
            warnings.push(format!("{} primitives of points or lines get no UVs", self.left_out));
        }
        let count = model.mesh.polygon_count();
        model.marks = Some(self.marks).filter(|marks| count > 0 && marks.len() == count);
        model.warnings = warnings;
        Ok((model, self.surfaces))
    }
}

/// Why a primitive has no numbers, where Draco is why.
fn draco(document: &Document, [m, p]: [usize; 2]) -> Option<FormatError> {
    const DRACO: &str = "KHR_draco_mesh_compression";
    let extensions: &BTreeMap<_, _> = &document.meshes[m].primitives[p].extensions;
    extensions.contains_key(DRACO).then(|| {
        FormatError::whole(format!(
            "mesh {m} is compressed by Draco ({DRACO}), which is not read; decompress it first, for example with \
             gltf-transform copy IN.glb OUT.glb"
        ))
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
        let model = read(&glb(), Path::new(""), Reading::default()).unwrap().model;
        assert_eq!(model.mesh.positions[1], DVec3::new(-4.0, 0.0, 0.0));
        assert_eq!(model.mesh.corners, [0, 2, 1, 2, 3, 1]);
        assert_eq!(model.mesh.corner_uv.unwrap()[..2], [DVec2::new(0.0, 1.0), DVec2::new(0.0, 0.0)]);
        assert_eq!((&model.pieces[0].name[..], &model.materials[0].name[..]), ("quad", "red hot"));
        assert_eq!(model.mesh.corner_normals, None);
        // Half a last bit of 1, twice as large by the node's scale.
        assert_eq!(model.mesh.tolerance, 0.5f64.powi(23));
    }

    #[test]
    fn a_file_that_is_no_gltf_is_an_error() {
        assert!(read(b"", Path::new(""), Reading::default()).is_err());
        assert!(read(b"{}", Path::new(""), Reading::default()).is_err());
        let bytes = glb();
        assert!(read(&bytes[..bytes.len() - 10], Path::new(""), Reading::default()).is_err());
        // A buffer that says less than its views need, whatever lies behind.
        let text = String::from_utf8_lossy(&bytes).replace(r#"{"byteLength":64}"#, r#"{"byteLength":40}"#);
        let error = read(text.as_bytes(), Path::new(""), Reading::default()).err().expect("a view beyond its buffer");
        assert!(error.problem.contains("beyond its buffer"), "{}", error.problem);
    }

    quickcheck! {
        fn damaged_files_never_panic(at: usize, byte: u8, digit: u8) -> bool {
            let mut bytes = glb();
            let length = bytes.len();
            bytes[at % length] = byte;
            let _ = read(&bytes, Path::new(""), Reading::default());
            let mut bytes = glb();
            let digits: Vec<usize> = (0..length).filter(|i| bytes[*i].is_ascii_digit()).collect();
            bytes[digits[at % digits.len()]] = b'0' + digit % 10;
            let _ = read(&bytes, Path::new(""), Reading::default());
            true
        }
    }
}
