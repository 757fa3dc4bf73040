//! PLY, text and binary of both byte orders, from its bytes.
//!
//! Read: `vertex` (x, y, z; nx, ny, nz; u and v under their usual names), `face` (`vertex_indices` or `vertex_index`; `texcoord`, two
//! numbers a corner), labels (`label`, `part` or `segment` of a face) or colours of faces or vertices, and `tristrips`.
//! Every other element and property is read past. Faces of fewer than three corners are dropped with a warning. Guarantee: no panic, and no more memory than the file's size calls for.

use super::body::{Body, Short};
use super::header::{Element, PlyHeader, ScalarType};
use crate::formats::error::FormatError;
use crate::formats::mark::Mark;
use crate::formats::model::Model;
use crate::mesh::polygons::{Mesh, NO_UV};
use crate::mesh::precision;
use glam::{DVec2, DVec3, Vec3};

/// Reads a PLY. O(bytes).
pub fn read(bytes: &[u8]) -> Result<Model, FormatError> {
    let header = PlyHeader::read(bytes)?;
    let mut body = Body::new(bytes, &header);
    let mut build = PlyBuild { mesh: Mesh::new(), ..PlyBuild::default() };
    for element in &header.elements {
        if element.properties.is_empty() {
            continue;
        }
        let mut values = vec![Vec::new(); element.properties.len()];
        for i in 0..element.count {
            for (property, into) in element.properties.iter().zip(&mut values) {
                body.property(element, property, into).map_err(|error| match error {
                    Short::Word(line, word) => {
                        FormatError { line, problem: format!("'{word}' is not a number; correct the {}", element.name) }
                    }
                    Short::End => FormatError::whole(format!(
                        "the file ends in {} {i} of {} (from 0); export it again",
                        element.name, element.count
                    )),
                })?;
            }
            build.element(element, &values)?;
        }
    }
    build.finish(&body)
}

#[derive(Default)]
struct PlyBuild {
    mesh: Mesh,
    vertex_uv: Vec<DVec2>,
    vertex_normal: Vec<Vec3>, // (n) or (0)
    corner_uv: Vec<DVec2>,
    small_faces: usize,
    vertex_marks: Vec<Mark>, // (n) or fewer
    face_marks: Vec<Mark>,   // (p) or fewer
}

impl PlyBuild {
    fn element(&mut self, element: &Element, values: &[Vec<f64>]) -> Result<(), FormatError> {
        let find = |names: &[&str]| {
            let at = element.properties.iter().position(|p| names.contains(&p.name.as_str()));
            at.map(|i| values[i].as_slice())
        };
        let scalar = |names: &[&str]| find(names).and_then(|list| list.first().copied());
        match element.name.as_str() {
            "vertex" => {
                let [x, y, z] = ["x", "y", "z"].map(|name| scalar(&[name]));
                let (Some(x), Some(y), Some(z)) = (x, y, z) else {
                    return Err(FormatError::whole("the vertices lack x, y or z; export the mesh again"));
                };
                self.mesh.positions.push(DVec3::new(x, y, z));
                if let [Some(x), Some(y), Some(z)] = ["nx", "ny", "nz"].map(|name| scalar(&[name])) {
                    self.vertex_normal.push(Vec3::new(x as f32, y as f32, z as f32));
                }
                let u = scalar(&["u", "s", "texture_u"]);
                let v = scalar(&["v", "t", "texture_v"]);
                self.vertex_uv.push(u.zip(v).map_or(NO_UV, |(u, v)| DVec2::new(u, v)));
                self.vertex_marks.extend(colour(element, values));
            }
            "face" => {
                if let Some(list) = find(&["vertex_indices", "vertex_index"]) {
                    let faces = self.mesh.polygon_count();
                    self.face(list, find(&["texcoord"]).unwrap_or_default());
                    if self.mesh.polygon_count() > faces {
                        let label = scalar(&["label", "part", "segment"]).map(|l| Mark::Label(l as i64));
                        self.face_marks.extend(label.or_else(|| colour(element, values)));
                    }
                }
            }
            "tristrips" => {
                if let Some(list) = find(&["vertex_indices", "vertex_index"]) {
                    self.strips(list);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn face(&mut self, list: &[f64], uv: &[f64]) {
        if list.len() < 3 {
            self.small_faces += 1;
            return;
        }
        for (i, vertex) in list.iter().enumerate() {
            // What is negative, broken or too large names no vertex, which the check at the end reports.
            let whole = *vertex >= 0.0 && vertex.fract() == 0.0;
            self.mesh.corners.push(if whole { *vertex as u32 } else { u32::MAX });
            self.corner_uv.push(uv.get(2 * i..2 * i + 2).map_or(NO_UV, |uv| DVec2::new(uv[0], uv[1])));
        }
        self.mesh.polygon_start.push(self.mesh.corners.len() as u32);
    }

    /// Triangle strips, one after another, with -1 between them.
    fn strips(&mut self, list: &[f64]) {
        for strip in list.split(|v| *v < 0.0) {
            for (i, t) in strip.windows(3).enumerate() {
                let [a, b, c] = if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
                if a != b && b != c && c != a {
                    self.face(&[a, b, c], &[]);
                }
            }
        }
    }

    fn finish(mut self, body: &Body) -> Result<Model, FormatError> {
        if self.mesh.corners.len() >= u32::MAX as usize || self.mesh.positions.len() >= u32::MAX as usize {
            return Err(FormatError::whole("more vertices or corners than 32-bit indices can name; split the mesh"));
        }
        self.mesh = Model::of(self.mesh).checked()?.mesh;
        let marks = self.marks();
        for (uv, vertex) in self.corner_uv.iter_mut().zip(&self.mesh.corners) {
            if !uv.is_finite() {
                *uv = self.vertex_uv[*vertex as usize];
            }
        }
        if self.corner_uv.iter().any(|uv| uv.is_finite()) {
            self.mesh.corner_uv = Some(self.corner_uv);
        }
        if self.vertex_normal.len() == self.mesh.positions.len() && !self.vertex_normal.is_empty() {
            let normals = self.mesh.corners.iter().map(|v| self.vertex_normal[*v as usize]);
            self.mesh.corner_normals = Some(normals.collect());
        }
        self.mesh.tolerance = match body.decimals() {
            Some(decimals) => decimals.tolerance(self.mesh.largest_coordinate()),
            None => precision::of_doubles(self.mesh.positions.iter().flat_map(|p| p.to_array())),
        };
        let small = self.small_faces;
        let warning = (small > 0).then(|| format!("{small} faces have fewer than three corners and are left out"));
        Ok(Model { marks, warnings: warning.into_iter().collect(), ..Model::of(self.mesh) })
    }

    /// A mark of each polygon: its own, or that of most of its corners.
    fn marks(&self) -> Option<Vec<Mark>> {
        let mesh = &self.mesh;
        if mesh.polygon_count() == 0 {
            return None;
        }
        if self.face_marks.len() == mesh.polygon_count() {
            return Some(self.face_marks.clone());
        }
        if self.vertex_marks.len() != mesh.positions.len() {
            return None;
        }
        let corner = |c: &u32| self.vertex_marks[*c as usize];
        mesh.polygons().map(|p| Mark::of_most(mesh.corners[p].iter().map(corner))).collect()
    }
}

/// The colour of an element: integers count to the largest of their type, floats to 1.
fn colour(element: &Element, values: &[Vec<f64>]) -> Option<Mark> {
    let channel = |names: [&str; 2]| {
        let at = element.properties.iter().position(|p| names.contains(&p.name.as_str()))?;
        let largest = match element.properties[at].kind {
            ScalarType::F32 | ScalarType::F64 => 1.0,
            ScalarType::U16 | ScalarType::I16 => 65535.0,
            _ => 255.0,
        };
        values[at].first().map(|c| c / largest)
    };
    let rgb = [["red", "r"], ["green", "g"], ["blue", "b"]].map(channel);
    Some(Mark::colour([rgb[0]?, rgb[1]?, rgb[2]?]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quickcheck::quickcheck;

    const HEAD: &str = "comment c\nelement vertex 4\nproperty float x\nproperty double y\nproperty short z\nproperty uchar red\n\
        element nothing 99999999999999\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";

    fn binary(big: bool) -> Vec<u8> {
        let order = if big { "big" } else { "little" };
        let mut out = format!("ply\nformat binary_{order}_endian 1.0\n{HEAD}").into_bytes();
        let mut put = |bytes: &[u8]| {
            let mut bytes = bytes.to_vec();
            if big {
                bytes.reverse();
            }
            out.extend(bytes);
        };
        for [x, y, z] in [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, -2]] {
            put(&(x as f32).to_le_bytes());
            put(&f64::from(y).to_le_bytes());
            put(&(z as i16).to_le_bytes());
            put(&[200]);
        }
        for face in [&[0i32, 1, 2, 3][..], &[0, 1]] {
            put(&[face.len() as u8]);
            face.iter().for_each(|v| put(&v.to_le_bytes()));
        }
        out
    }

    #[test]
    fn labels_come_before_colours_of_faces_and_those_before_colours_of_vertices() {
        let file = |vertex: &str, face: &str, values: &str| {
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{vertex}\
                 element face 1\nproperty list uchar int vertex_indices\n{face}end_header\n{values}"
            );
            read(text.as_bytes()).unwrap().marks
        };
        let of_vertices = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
        let of_faces = "property float red\nproperty float green\nproperty float blue\n";
        let vertices = "0 0 0 0 0 255\n1 0 0 255 0 0\n0 1 0 255 0 0\n";
        let red = Some(vec![Mark::Colour([65535, 0, 0])]);
        assert_eq!(file(of_vertices, "", &format!("{vertices}3 0 1 2")), red);
        let green = Some(vec![Mark::Colour([0, 65535, 0])]);
        assert_eq!(file(of_vertices, of_faces, &format!("{vertices}3 0 1 2 0 1 0")), green);
        let both = format!("{of_faces}property int label\n");
        assert_eq!(file(of_vertices, &both, &format!("{vertices}3 0 1 2 0 1 0 -7")), Some(vec![Mark::Label(-7)]));
        assert_eq!(file("", "", "0 0 0\n1 0 0\n0 1 0\n3 0 1 2"), None);
    }

    #[test]
    fn text_and_both_byte_orders_give_the_same_mesh() {
        let text = format!("ply\r\nformat ascii 1.0\n{HEAD}0 0 0 1\n1 0 0 1\n1 1 0 1\r\n0 1 -2 1\n4 0 1 2 3\n2 0 1");
        let text = read(text.as_bytes()).unwrap();
        assert_eq!(text.mesh.positions[3], DVec3::new(0.0, 1.0, -2.0));
        assert_eq!((&text.mesh.corners[..], text.warnings.len()), (&[0, 1, 2, 3][..], 1));
        assert_eq!(read(&binary(false)).unwrap().mesh, text.mesh);
        assert_eq!(read(&binary(true)).unwrap().mesh, text.mesh);
    }

    #[test]
    fn normals_and_the_last_digit_of_coordinates_are_read() {
        let file = |x: &str| {
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                 property float nx\nproperty float ny\nproperty float nz\nproperty float quality\nelement face 1\n\
                 property list uchar int vertex_indices\nend_header\n{x} 0 0 1 0 0 .12345\n1 0 0 0 1 0 9\n0 1 0 0 0 1 9\n\
                 3 2 0 1"
            );
            read(text.as_bytes()).unwrap().mesh
        };
        assert_eq!(file("0.25").corner_normals.unwrap(), [Vec3::Z, Vec3::X, Vec3::Y]);
        assert_eq!(file("0.25").tolerance, 0.005);
        assert_eq!(file("0").tolerance, 0.5f64.powi(24));
    }

    #[test]
    fn uvs_come_from_vertices_or_from_corners() {
        let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            property float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_index\n";
        let vertices = "end_header\n0 0 0 .1 .2\n1 0 0 .3 .4\n0 1 0 .5 .6\n3 0 1 2";
        let mesh = read(format!("{head}{vertices}").as_bytes()).unwrap().mesh;
        assert_eq!(mesh.corner_uv.unwrap()[1], DVec2::new(0.3, 0.4));
        let corners = format!("{head}property list uchar float texcoord\n{vertices} 6 0 0 1 0 0 1");
        assert_eq!(read(corners.as_bytes()).unwrap().mesh.corner_uv.unwrap()[1], DVec2::new(1.0, 0.0));
    }

    #[test]
    fn strips_become_triangles_of_one_orientation() {
        let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty int x\nproperty int y\nproperty int z\n\
            element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0 1 1 0\n6 0 1 2 3 -1 0";
        assert_eq!(read(text.as_bytes()).unwrap().mesh.corners, [0, 1, 2, 2, 1, 3]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let body = |body: &str| read(format!("ply\nformat ascii 1.0\n{HEAD}{body}").as_bytes()).unwrap_err();
        assert_eq!(body("0 0 0 1\n1 x 0 1").line, 14);
        assert!(body("0 0 0 1\n1 0 0 1").problem.contains("vertex 2 of 4"));
        assert!(body("0 0 0 1 1 0 0 1 1 1 0 1 0 1 0 1\n3 0 1 9 3 0 1 2").problem.contains("names vertex 9"));
        assert!(body("0 0 0 1 1 0 0 1 1 nan 0 1 0 1 0 1\n3 0 1 2 3 0 1 2").problem.contains("vertex 2"));
        assert!(read(b"solid").unwrap_err().problem.contains("PLY"));
        assert!(read(b"ply\nformat ascii 1.0\nelement vertex -1\n").is_err_and(|e| e.line == 3));
    }

    quickcheck! {
        fn damaged_files_never_panic(at: usize, byte: u8, cut: usize, big: bool) -> bool {
            let mut bytes = binary(big);
            let length = bytes.len();
            bytes[at % length] = byte;
            let _ = (read(&bytes), read(&bytes[..cut % length]));
            true
        }
    }
}
