//! PLY, text and binary of both byte orders, from its bytes.
//!
//! Read: `vertex` (x, y, z; nx, ny, nz; colours; u and v under their usual names), `face` (`vertex_indices` or `vertex_index`;
//! `texcoord`, two numbers a corner, `texcoord1` and so on for further sets), labels (`label`, `part` or `segment` of a face)
//! or colours of faces or vertices, and `tristrips`. Every other element and property is read past. Faces of fewer than three
//! corners stay in the file and get no UV. Guarantee: no panic, and no more memory than the file's size calls for.

use super::body::{Body, Short};
use super::file::PlyFile;
use super::header::{CORNERS, Element, PlyHeader, ScalarType};
use super::names::{U, V, texcoord, uv_set};
use crate::formats::error::FormatError;
use crate::formats::mark::Mark;
use crate::formats::model::Model;
use crate::formats::reading::Reading;
use crate::mesh::polygons::{Mesh, NO_UV};
use crate::mesh::precision;
use glam::{DVec2, DVec3, Vec3};

/// Reads a PLY. O(bytes).
pub fn read(source: Vec<u8>, reading: Reading) -> Result<PlyFile, FormatError> {
    let header = PlyHeader::read(&source)?;
    let with = |by_lines: bool| {
        let build = PlyBuild { mesh: Mesh::new(), uv_name: texcoord(reading.uv_set), ..PlyBuild::default() };
        build.read(Body::new(&source, &header, by_lines), &header, reading)
    };
    // A text that has not a line for each item is one stream of words.
    let build = match with(true) {
        Err(Wrong::Layout) => with(false),
        other => other,
    };
    let build = build.map_err(|e| match e {
        Wrong::Layout => FormatError::whole("the file ends too soon; export it again"),
        Wrong::Format(e) => e,
    })?;
    build.finish(source, header)
}

/// Why there is no mesh.
enum Wrong {
    /// Items do not stand in lines.
    Layout,
    Format(FormatError),
}

impl From<FormatError> for Wrong {
    fn from(e: FormatError) -> Self {
        Wrong::Format(e)
    }
}

#[derive(Default)]
struct PlyBuild {
    mesh: Mesh,
    uv_name: String,
    vertex_uv: Vec<DVec2>,
    vertex_normal: Vec<Vec3>, // (n) or (0)
    colours: Vec<[f32; 4]>,   // (n) or fewer
    corner_uv: Vec<DVec2>,
    vertex_marks: Vec<Mark>, // (n) or fewer
    face_marks: Vec<Mark>,   // (p) or fewer
    small_faces: usize,
    bad_vertex: Option<(usize, f64)>, // a face and what it names, which no vertex can be
    faces: Option<usize>,
    face_ends: Vec<(usize, bool)>,
    strips_start: usize,
    uv_values: Vec<(usize, usize, usize, usize)>,
    beyond: Vec<(usize, usize)>,
    beyond_line: usize,
}

impl PlyBuild {
    fn read(mut self, mut body: Body, header: &PlyHeader, reading: Reading) -> Result<Self, Wrong> {
        let by_lines = body.by_lines();
        for (e, element) in header.elements.iter().enumerate().filter(|(_, element)| !element.properties.is_empty()) {
            let uvs: Vec<usize> = (0..element.properties.len()).filter(|p| uv_set(element, *p).is_some()).collect();
            let mut values = vec![Vec::new(); element.properties.len()];
            for i in 0..element.count {
                body.begin();
                if i == 0 && element.name == "tristrips" {
                    self.strips_start = body.at;
                }
                for (p, (property, into)) in element.properties.iter().zip(&mut values).enumerate() {
                    let start = body.at;
                    body.property(element, property, into).map_err(|error| match error {
                        Short::Line | Short::End if by_lines => Wrong::Layout,
                        Short::Word(line, word) => {
                            let problem = format!("'{word}' is not a number; correct the {}", element.name);
                            Wrong::Format(FormatError { line, problem })
                        }
                        _ => Wrong::Format(FormatError::whole(format!(
                            "the file ends in {} {i} of {} (from 0); export it again",
                            element.name, element.count
                        ))),
                    })?;
                    if uvs.contains(&p) {
                        self.uv_values.push((e, p, start, body.at));
                    }
                }
                let end = body.at;
                if let Some((start, end, line)) = body.end() {
                    if self.beyond.is_empty() {
                        self.beyond_line = line;
                    }
                    self.beyond.push((start, end));
                }
                self.item(e, element, &values, end, reading)?;
            }
        }
        self.mesh.tolerance = match body.decimals() {
            Some(decimals) => decimals.tolerance(self.mesh.largest_coordinate()),
            None => precision::of_doubles(self.mesh.positions.iter().flat_map(|p| p.to_array())),
        };
        Ok(self)
    }

    /// Takes an item that ends at byte `end`.
    fn item(
        &mut self,
        e: usize,
        element: &Element,
        values: &[Vec<f64>],
        end: usize,
        reading: Reading,
    ) -> Result<(), FormatError> {
        let find = |names: &[&str]| element.find(names).map(|i| values[i].as_slice());
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
                let (u, v) = (scalar(&U), scalar(&V));
                let uv = u.zip(v).filter(|_| reading.uv_set == 0).map_or(NO_UV, |(u, v)| DVec2::new(u, v));
                self.vertex_uv.push(uv);
                let colour = colour(element, values);
                self.vertex_marks.extend(colour.map(|[r, g, b, _]| Mark::colour([r, g, b])));
                self.colours.extend(colour.map(|c| c.map(|c| c as f32)));
            }
            "face" => {
                self.faces = Some(e);
                let polygons = self.mesh.polygon_count();
                if let Some(list) = find(&CORNERS) {
                    let uv = element.find(&[self.uv_name.as_str()]).map(|i| values[i].as_slice());
                    self.face(list, uv.unwrap_or_default());
                }
                let is_polygon = self.mesh.polygon_count() > polygons;
                if is_polygon {
                    let label = scalar(&["label", "part", "segment"]).map(|l| Mark::Label(l as i64));
                    let colour = || colour(element, values).map(|[r, g, b, _]| Mark::colour([r, g, b]));
                    self.face_marks.extend(label.or_else(colour));
                }
                self.face_ends.push((end, is_polygon));
            }
            "tristrips" => {
                self.faces = Some(e);
                if let Some(list) = find(&CORNERS) {
                    self.strips(list);
                }
                self.face_ends.push((end, false));
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
            let whole = *vertex >= 0.0 && vertex.fract() == 0.0 && *vertex < f64::from(u32::MAX);
            if !whole {
                self.bad_vertex.get_or_insert((self.mesh.polygon_count(), *vertex));
            }
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

    fn finish(mut self, source: Vec<u8>, header: PlyHeader) -> Result<PlyFile, FormatError> {
        let n = self.mesh.positions.len();
        if self.mesh.corners.len() >= u32::MAX as usize || n >= u32::MAX as usize {
            return Err(FormatError::whole("more vertices or corners than 32-bit indices can name; split the mesh"));
        }
        if let Some((face, vertex)) = self.bad_vertex {
            let text = format!("face {face} names vertex {vertex} (both from 0), but there are {n}; correct the face");
            return Err(FormatError::whole(text));
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
        if self.vertex_normal.len() == n && n > 0 {
            let normals = self.mesh.corners.iter().map(|v| self.vertex_normal[*v as usize]);
            self.mesh.corner_normals = Some(normals.collect());
        }
        let mut warnings = header.warnings.clone();
        let (small, beyond) = (self.small_faces, self.beyond.len());
        if small > 0 {
            warnings.push(format!("{small} faces have fewer than three corners and get no UVs"));
        }
        if beyond > 0 {
            let line = self.beyond_line;
            warnings.push(format!(
                "{beyond} lines hold more values than the header names (first: line {line}); these are left out"
            ));
        }
        let colours = Some(self.colours).filter(|colours| n > 0 && colours.len() == n);
        let model = Model { marks, colours, rest: rest(&header), warnings, ..Model::of(self.mesh) };
        Ok(PlyFile {
            source,
            header,
            faces: self.faces,
            face_ends: self.face_ends,
            strips_start: self.strips_start,
            uv_values: self.uv_values,
            beyond: self.beyond,
            model,
        })
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
fn colour(element: &Element, values: &[Vec<f64>]) -> Option<[f64; 4]> {
    let channel = |names: [&str; 2]| {
        let at = element.find(&names)?;
        let largest = match element.properties[at].kind {
            ScalarType::F32 | ScalarType::F64 => 1.0,
            ScalarType::U16 | ScalarType::I16 => 65535.0,
            _ => 255.0,
        };
        values[at].first().map(|c| c / largest)
    };
    let [r, g, b, a] = [["red", "r"], ["green", "g"], ["blue", "b"], ["alpha", "a"]].map(channel);
    Some([r?, g?, b?, a.unwrap_or(1.0)])
}

/// What other formats do not take along: properties and elements, in words.
fn rest(header: &PlyHeader) -> Vec<String> {
    const VERTEX: [&str; 14] = ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "alpha", "r", "g", "b", "a"];
    let mut rest = Vec::new();
    for element in &header.elements {
        let known = |p: &usize| {
            let name = element.properties[*p].name.as_str();
            let own = match element.name.as_str() {
                "vertex" => VERTEX.contains(&name),
                "face" | "tristrips" => CORNERS.contains(&name),
                _ => false,
            };
            own || uv_set(element, *p) == Some(0)
        };
        let names = (0..element.properties.len()).filter(|p| !known(p)).map(|p| element.properties[p].name.as_str());
        let names: Vec<&str> = names.collect();
        match element.name.as_str() {
            _ if names.is_empty() => {}
            "vertex" | "face" | "tristrips" => rest.push(format!("{} of {}", names.join(", "), element.name)),
            name => rest.push(format!("{} items '{name}'", element.count)),
        }
    }
    rest
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

    fn model(bytes: Vec<u8>) -> Model {
        read(bytes, Reading::default()).unwrap().model
    }

    fn mesh(text: &str) -> Mesh {
        model(text.as_bytes().to_vec()).mesh
    }

    #[test]
    fn labels_come_before_colours_of_faces_and_those_before_colours_of_vertices() {
        let file = |vertex: &str, face: &str, values: &str| {
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{vertex}\
                 element face 1\nproperty list uchar int vertex_indices\n{face}end_header\n{values}"
            );
            model(text.as_bytes().to_vec()).marks
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
        let text = model(text.into_bytes());
        assert_eq!(text.mesh.positions[3], DVec3::new(0.0, 1.0, -2.0));
        assert_eq!((&text.mesh.corners[..], text.warnings.len()), (&[0, 1, 2, 3][..], 1));
        assert_eq!(model(binary(false)).mesh, text.mesh);
        assert_eq!(model(binary(true)).mesh, text.mesh);
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
            mesh(&text)
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
        let of_vertices = mesh(&format!("{head}{vertices}"));
        assert_eq!(of_vertices.corner_uv.unwrap()[1], DVec2::new(0.3, 0.4));
        let corners = format!("{head}property list uchar float texcoord\n{vertices} 6 0 0 1 0 0 1");
        assert_eq!(mesh(&corners).corner_uv.unwrap()[1], DVec2::new(1.0, 0.0));
    }

    #[test]
    fn strips_become_triangles_of_one_orientation() {
        let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty int x\nproperty int y\nproperty int z\n\
            element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0 1 1 0\n6 0 1 2 3 -1 0";
        assert_eq!(mesh(text).corners, [0, 1, 2, 2, 1, 3]);
    }

    #[test]
    fn values_beyond_those_of_the_header_and_strange_lines_of_it_are_warnings() {
        let head = "ply\nformat ascii 1.0\nMade by an exporter\nelement vertex 3\nproperty int x\nproperty int y\nproperty int z\n\
            element face 2\nproperty list uchar int vertex_indices\nend_header\n";
        let made = model(format!("{head}0 0 0\n1 0 0\n\n0 1 0 7\n3 0 1 2 3 0 1\n3 2 1 0 9 \n").into_bytes());
        assert_eq!((&made.mesh.corners[..], made.warnings.len()), (&[0, 1, 2, 2, 1, 0][..], 2));
        assert!(made.warnings[0].contains("line 3") && made.warnings[1].contains("3 lines"), "{:?}", made.warnings);
        assert!(made.warnings[1].contains("line 14"), "{:?}", made.warnings);
        // Items that do not stand in lines are a stream.
        let made = model(format!("{head}0 0 0 1 0 0\n0 1\n0 3 0 1\n2 3 2 1 0").into_bytes());
        assert_eq!((&made.mesh.corners[..], made.warnings.len()), (&[0, 1, 2, 2, 1, 0][..], 1));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let error = |text: &str| read(text.as_bytes().to_vec(), Reading::default()).err().unwrap();
        let body = |body: &str| error(&format!("ply\nformat ascii 1.0\n{HEAD}{body}"));
        assert_eq!(body("0 0 0 1\n1 x 0 1").line, 14);
        assert!(body("0 0 0 1\n1 0 0 1").problem.contains("vertex 2 of 4"));
        assert!(body("0 0 0 1 1 0 0 1 1 1 0 1 0 1 0 1\n3 0 1 9 3 0 1 2").problem.contains("names vertex 9"));
        assert!(
            body("0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n3 0 1 2\n3 0 -1 2").problem.contains("face 1 names vertex -1")
        );
        assert!(body("0 0 0 1 1 0 0 1 1 nan 0 1 0 1 0 1\n3 0 1 2 3 0 1 2").problem.contains("vertex 2"));
        assert!(error("solid").problem.contains("PLY"));
        assert!(error("ply\nformat ascii 1.0\nelement vertex -1\n").line == 3);
        for [first, second] in [["face", "face"], ["tristrips", "face"], ["face", "tristrips"], ["vertex", "vertex"]] {
            let twice = error(&format!("ply\nelement {first} 0\nelement a 1\nelement a 1\nelement {second} 1\n"));
            assert!(twice.line == 5 && twice.problem.contains("a second list"), "{twice}");
        }
    }

    quickcheck! {
        fn damaged_files_never_panic(at: usize, byte: u8, cut: usize, big: bool) -> bool {
            let mut bytes = binary(big);
            let length = bytes.len();
            bytes[at % length] = byte;
            let _ = (read(bytes[..cut % length].to_vec(), Reading::default()), read(bytes, Reading::default()));
            true
        }
    }
}
