//! FBX, text and binary, by the ufbx library; without the feature `fbx` it is refused.
//!
//! Read: the polygons of every node that has a mesh, placed by its nodes with y up and in metres, their normals, hard edges,
//! one set of UVs, colours, and materials with base colours and textures. Skins and shapes are left at rest. An FBX leaves as
//! another format, so what that does not take along is told.

use super::error::FormatError;
use super::model::Model;
use super::reading::Reading;

/// Reads an FBX. O(bytes).
#[cfg(not(feature = "fbx"))]
pub fn read(_: &[u8], _: Reading) -> Result<Model, FormatError> {
    Err(FormatError::whole("FBX is not read by this build (feature `fbx`); convert it to GLB first"))
}

#[cfg(feature = "fbx")]
pub use with_ufbx::read;

#[cfg(feature = "fbx")]
mod with_ufbx {
    use super::*;
    use crate::formats::model::{Material, Piece};
    use crate::mesh::polygons::{Mesh, NO_UV};
    use crate::mesh::precision::of_doubles;
    use glam::{DMat3, DMat4, DVec2, DVec3, DVec4, Vec3};
    use seamwright_core::price::given::BREAK;

    /// Reads an FBX. O(bytes).
    pub fn read(bytes: &[u8], reading: Reading) -> Result<Model, FormatError> {
        let options = ufbx::LoadOpts {
            target_axes: ufbx::CoordinateAxes::right_handed_y_up(),
            target_unit_meters: 1.0,
            file_format: ufbx::FileFormat::Fbx,
            ..Default::default()
        };
        let scene = ufbx::load_memory(bytes, options).map_err(|e| {
            FormatError::whole(format!("not an FBX that can be read: {}; export it again", &*e.description))
        })?;
        let mut build = FbxBuild { reading, model: Model::of(Mesh::new()), colours: Vec::new(), has_colours: false };
        build.model.materials = scene.materials.iter().map(|m| material(m)).collect();
        build.model.rest = rest(&scene, reading.uv_set);
        for (n, node) in scene.nodes.iter().enumerate() {
            if let Some(mesh) = &node.mesh {
                build.node(n, node, mesh, &scene)?;
            }
        }
        build.finish()
    }

    fn material(material: &ufbx::Material) -> Material {
        let colour = |map: &ufbx::MaterialMap| {
            let v = map.value_vec4;
            map.has_value.then(|| [v.x, v.y, v.z].map(|c| c.clamp(0.0, 1.0)))
        };
        let (base, old) = (&material.pbr.base_color, &material.fbx.diffuse_color);
        let opacity = material.pbr.opacity.value_vec4.x;
        let opacity = if material.pbr.opacity.has_value { opacity.clamp(0.0, 1.0) } else { 1.0 };
        let file = |map: &ufbx::MaterialMap| {
            let texture = map.texture.as_ref()?;
            let name =
                if texture.relative_filename.is_empty() { &texture.filename } else { &texture.relative_filename };
            Some(name.replace('\\', "/")).filter(|name| !name.is_empty())
        };
        Material {
            name: material.element.name.to_string(),
            colour: colour(base).or_else(|| colour(old)).map(|[r, g, b]| [r, g, b, opacity]),
            texture: file(base).or_else(|| file(old)),
        }
    }

    fn rest(scene: &ufbx::Scene, uv_set: u32) -> Vec<String> {
        let sets = scene.meshes.iter().map(|mesh| mesh.uv_sets.len()).max().unwrap_or(0);
        let others = sets.saturating_sub(usize::from(sets > uv_set as usize));
        let counted = [
            (scene.skin_deformers.len(), "skin"),
            (scene.blend_channels.len(), "shape"),
            (if scene.anim_curves.is_empty() { 0 } else { scene.anim_stacks.len() }, "animation"),
            (scene.cameras.len(), "camera"),
            (scene.lights.len(), "light"),
            (others, "other set of UVs"),
        ];
        let plural = |what: &str| {
            if let Some(rest) = what.strip_prefix("other set") {
                format!("other sets{rest}")
            } else {
                format!("{what}s")
            }
        };
        let mut all: Vec<String> = counted
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {}", if *count == 1 { what.to_string() } else { plural(what) }))
            .collect();
        if scene.nodes.iter().any(|node| node.node_depth > 1) {
            all.push("the hierarchy of nodes".into());
        }
        all
    }

    struct FbxBuild {
        reading: Reading,
        model: Model,
        colours: Vec<Option<[f32; 4]>>, // (n)
        has_colours: bool,
    }

    fn point(v: ufbx::Vec3) -> DVec3 {
        DVec3::new(v.x, v.y, v.z)
    }

    impl FbxBuild {
        fn node(
            &mut self,
            n: usize,
            node: &ufbx::Node,
            mesh: &ufbx::Mesh,
            scene: &ufbx::Scene,
        ) -> Result<(), FormatError> {
            let m = &node.geometry_to_world;
            let place = DMat4::from_cols(
                DVec4::new(m.m00, m.m10, m.m20, 0.0),
                DVec4::new(m.m01, m.m11, m.m21, 0.0),
                DVec4::new(m.m02, m.m12, m.m22, 0.0),
                DVec4::new(m.m03, m.m13, m.m23, 1.0),
            );
            let all = &mut self.model.mesh;
            let first = all.positions.len();
            if first + mesh.vertices.len() >= u32::MAX as usize
                || all.corners.len() + mesh.num_indices >= u32::MAX as usize
            {
                return Err(FormatError::whole(
                    "more vertices or corners than 32-bit indices can name; split the mesh",
                ));
            }
            all.positions.extend(mesh.vertices.iter().map(|v| place.transform_point3(point(*v))));
            self.colours.resize(all.positions.len(), None);
            let DMat3 { x_axis: x, y_axis: y, z_axis: z } = DMat3::from_mat4(place);
            let is_mirrored = place.determinant() < 0.0;
            let turned = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * place.determinant().signum();
            let largest = (x.abs() + y.abs() + z.abs()).max_element();
            let own = of_doubles(mesh.vertices.iter().flat_map(|v| [v.x, v.y, v.z]));
            all.tolerance = all.tolerance.max(if largest.is_finite() { largest * own } else { 0.0 });

            let mut hard = vec![false; mesh.num_indices];
            for (edge, _) in mesh.edges.iter().zip(mesh.edge_smoothing.iter()).filter(|(_, smooth)| !**smooth) {
                for c in [edge.a, edge.b] {
                    hard.get_mut(c as usize).into_iter().for_each(|mark| *mark = true);
                }
            }
            let uv = mesh.uv_sets.get(self.reading.uv_set as usize).map(|set| &set.vertex_uv).filter(|uv| uv.exists);
            let mut material = None;
            for (f, face) in mesh.faces.iter().enumerate().filter(|(_, face)| face.num_indices >= 3) {
                let own = mesh.face_material.get(f).and_then(|own| mesh.materials.get(*own as usize));
                let number =
                    own.and_then(|own| scene.materials.iter().position(|m| m.element.typed_id == own.element.typed_id));
                if material != Some(number) {
                    material = Some(number);
                    let all = &self.model;
                    let same = |piece: &&Piece| piece.mesh == n as u32 && piece.material == number.map(|m| m as u32);
                    let known = all.pieces.iter().find(same).map(|piece| piece.primitive);
                    let next = all.pieces.iter().map(|piece| piece.primitive + 1).max().unwrap_or(0);
                    self.model.pieces.push(Piece {
                        first: self.model.mesh.polygon_count(),
                        name: node.element.name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect(),
                        mesh: n as u32,
                        primitive: known.unwrap_or(next),
                        material: number.map(|m| m as u32),
                    });
                }
                let (start, count) = (face.index_begin as usize, face.num_indices as usize);
                for k in 0..count {
                    // Turned round, a face's edges leave the other corner.
                    let c = start + if is_mirrored { (count - k) % count } else { k };
                    let leaves = start + if is_mirrored { count - 1 - k } else { k };
                    self.corner(mesh, c, first, turned, uv);
                    let marks = self.model.mesh.edge_marks.get_or_insert_default();
                    marks.push(if hard[leaves] { BREAK } else { 0 });
                }
                let end = self.model.mesh.corners.len() as u32;
                self.model.mesh.polygon_start.push(end);
            }
            Ok(())
        }

        fn corner(&mut self, mesh: &ufbx::Mesh, c: usize, first: usize, turned: DMat3, uv: Option<&ufbx::VertexVec2>) {
            let vertex = first + mesh.vertex_indices[c] as usize;
            if mesh.vertex_color.exists {
                let v = mesh.vertex_color[c];
                self.has_colours = true;
                self.colours[vertex].get_or_insert([v.x, v.y, v.z, v.w].map(|c| c.clamp(0.0, 1.0) as f32));
            }
            let all = &mut self.model.mesh;
            all.corners.push(vertex as u32);
            let normal = mesh.vertex_normal.exists.then(|| turned * point(mesh.vertex_normal[c]));
            all.corner_normals
                .get_or_insert_default()
                .push(normal.map_or(Vec3::ZERO, |n| n.normalize_or_zero().as_vec3()));
            let uv = uv.map_or(NO_UV, |uv| DVec2::new(uv[c].x, uv[c].y));
            all.corner_uv.get_or_insert_default().push(uv);
        }

        fn finish(mut self) -> Result<Model, FormatError> {
            let mesh = &mut self.model.mesh;
            mesh.corner_uv.take_if(|uv| uv.iter().all(|uv| !uv.is_finite()));
            mesh.corner_normals.take_if(|normals| normals.iter().all(|n| *n == Vec3::ZERO));
            mesh.edge_marks.take_if(|marks| marks.iter().all(|mark| *mark == 0));
            if self.has_colours {
                self.model.colours = Some(self.colours.iter().map(|c| c.unwrap_or([1.0; 4])).collect());
            }
            self.model.checked()
        }
    }
}
