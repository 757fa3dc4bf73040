//! From an OBJ file's bytes to a mesh, remembering where a new atlas changes them.
//!
//! Read: `v` (three coordinates; a weight and colours are left to the text), `vt`, `vn`, `s`, `o`, `g`, `usemtl` and `f` (or
//! its old name `fo`). Everything else stays text. Indices may be negative and may name what comes later in the file.
//! Guarantee: no panic for any bytes; memory is the file plus about 40 bytes a corner, 90 with normals and smoothing groups.
//! Limits: `call` is not followed, free-form surfaces are kept but get no UV, and UTF-16 is refused.

use super::field::{coordinate, corner, names_texture, normal, shown, texture};
use super::file::{Edit, EditKind, ObjFile};
use super::pieces::Pieces;
use super::problem::{ObjError, Problem};
use super::smoothing::{UNSAID, breaks, group};
use super::statement::{Statement, Statements, Words};
use crate::formats::model::Model;
use crate::mesh::polygons::{Mesh, NO_UV};
use crate::mesh::precision::Decimals;
use glam::{DVec2, DVec3, Vec3};

/// Reads the bytes of an OBJ file. A file without polygons gives a mesh without polygons. O(bytes).
pub fn read(source: Vec<u8>) -> Result<ObjFile, ObjError> {
    if source.starts_with(b"\xFF\xFE") || source.starts_with(b"\xFE\xFF") {
        return Err(ObjError { line: 0, problem: Problem::Utf16 });
    }
    let mut reader = Reader::default();
    for statement in Statements::new(&source) {
        reader
            .statement(&source[statement.start..statement.end], statement)
            .map_err(|problem| ObjError { line: statement.line, problem })?;
    }
    reader.check_vertices(&source)?;
    Ok(reader.finish(source))
}

/// What has been read so far.
#[derive(Default)]
struct Reader {
    positions: Vec<DVec3>,
    textures: Vec<DVec2>,
    normals: Vec<Vec3>,
    corners: Vec<u32>,
    corner_texture: Vec<u32>, // from 1; 0: none
    corner_normal: Vec<u32>,  // from 1; 0: none
    polygon_end: Vec<u32>,
    polygon_group: Vec<u32>, // of smoothing; shorter where the file has no `s` before its end
    group: Option<u32>,      // that the last `s` line began
    pieces: Pieces,
    edits: Vec<Edit>,
    decimals: Decimals,
    libraries: Vec<String>, // of materials
    odd: Oddities,
}

impl Reader {
    fn statement(&mut self, text: &[u8], at: Statement) -> Result<(), Problem> {
        let mut words = Words::new(text);
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword {
            b"v" => self.vertex(words),
            b"vn" => {
                self.normals.push(normal(words));
                Ok(())
            }
            b"s" => {
                self.group = words.next().and_then(group).or(self.group);
                Ok(())
            }
            b"vt" => {
                self.edits.push(Edit { start: at.start, end: at.next, kind: EditKind::Texture });
                self.textures.push(texture(words));
                Ok(())
            }
            b"o" | b"g" | b"usemtl" => {
                self.pieces.statement(keyword, words.rest(), self.polygon_end.len());
                Ok(())
            }
            b"mtllib" => {
                self.libraries.push(String::from_utf8_lossy(words.rest()).trim().into());
                Ok(())
            }
            b"f" | b"fo" if words_left(text) > 3 => self.face(words, at),
            b"f" | b"fo" => {
                self.odd.short_faces.see(at.line);
                self.detach(words, at);
                Ok(())
            }
            b"l" | b"surf" => {
                self.detach(words, at);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn vertex(&mut self, words: Words) -> Result<(), Problem> {
        let mut xyz = [0.0; 3];
        let mut given = 0;
        for (value, word) in xyz.iter_mut().zip(words) {
            *value = coordinate(word)?;
            self.decimals.see(word);
            given += 1;
        }
        if given < 3 {
            return Err(Problem::FewCoordinates { given });
        }
        if self.positions.len() >= (u32::MAX - 1) as usize {
            return Err(Problem::TooLarge);
        }
        self.positions.push(DVec3::from(xyz));
        Ok(())
    }

    fn face(&mut self, words: Words, at: Statement) -> Result<(), Problem> {
        for word in words {
            let corner = corner(word).ok_or_else(|| Problem::NotACorner { word: shown(word) })?;
            self.corners.push(self.vertex_index(corner[0])?);
            let texture = self.reference(corner[1], self.textures.len());
            let normal = self.reference(corner[2], self.normals.len());
            self.corner_texture.push(texture);
            self.corner_normal.push(normal);
        }
        if self.corners.len() >= u32::MAX as usize {
            return Err(Problem::TooLarge);
        }
        if let Some(group) = self.group {
            self.polygon_group.resize(self.polygon_end.len(), UNSAID);
            self.polygon_group.push(group);
        }
        self.polygon_end.push(self.corners.len() as u32);
        self.edits.push(Edit { start: at.start, end: at.end, kind: EditKind::Face });
        Ok(())
    }

    /// Vertex from 0. Whether a positive index is in range shows at the end of the file.
    fn vertex_index(&self, index: Option<i64>) -> Result<u32, Problem> {
        let count = self.positions.len();
        match index {
            None | Some(0) => Err(Problem::ZeroIndex),
            Some(i) if i > 0 => u32::try_from(i - 1).map_err(|_| Problem::OutOfRange { index: i, count }),
            Some(i) => {
                let back = usize::try_from(i.unsigned_abs()).unwrap_or(usize::MAX);
                count.checked_sub(back).map(|v| v as u32).ok_or(Problem::OutOfRange { index: i, count })
            }
        }
    }

    /// `vt` or `vn` from 1. 0 and what reaches back too far become `u32::MAX`, which [`Reader::finish`] finds dangling.
    fn reference(&self, index: Option<i64>, count: usize) -> u32 {
        match index {
            None => 0,
            Some(i) if i > 0 => u32::try_from(i).unwrap_or(u32::MAX),
            Some(i) => {
                let back = usize::try_from(i.unsigned_abs()).unwrap_or(usize::MAX);
                count.checked_sub(back).filter(|_| i != 0).map_or(u32::MAX, |t| t as u32 + 1)
            }
        }
    }

    fn detach(&mut self, words: Words, at: Statement) {
        if words.into_iter().any(names_texture) {
            self.odd.detached.see(at.line);
            self.edits.push(Edit { start: at.start, end: at.end, kind: EditKind::Detach });
        }
    }

    /// The first corner that names a vertex that the file never gives is an error at its line.
    fn check_vertices(&self, source: &[u8]) -> Result<(), ObjError> {
        let count = self.positions.len();
        let Some(corner) = self.corners.iter().position(|v| *v as usize >= count) else { return Ok(()) };
        let polygon = self.polygon_end.partition_point(|end| *end as usize <= corner);
        let edit = self.edits.iter().filter(|e| e.kind == EditKind::Face).nth(polygon);
        let line =
            edit.map_or(0, |e| Statements::new(source).take_while(|s| s.start <= e.start).last().map_or(0, |s| s.line));
        let index = i64::from(self.corners[corner]) + 1;
        Err(ObjError { line, problem: Problem::OutOfRange { index, count } })
    }

    fn finish(mut self, source: Vec<u8>) -> ObjFile {
        let corner_uv = self.corner_uv();
        let normal_count = self.normals.len();
        for normal in self.corner_normal.iter_mut().filter(|n| **n as usize > normal_count) {
            *normal = 0;
            self.odd.lost_normals += 1;
        }
        if self.corner_normal.iter().all(|n| *n == 0) {
            self.corner_normal = Vec::new();
        }
        let mut polygon_start = self.polygon_end;
        polygon_start.insert(0, 0);
        let warnings = self.odd.warnings();
        let corner_normals = (!self.corner_normal.is_empty()).then(|| {
            let of = |n: &u32| n.checked_sub(1).map_or(Vec3::ZERO, |n| self.normals[n as usize]);
            self.corner_normal.iter().map(of).collect()
        });
        let edge_marks = breaks(&self.positions, &self.corners, &polygon_start, &self.polygon_group);
        let (positions, corners) = (self.positions, self.corners);
        let mut mesh =
            Mesh { positions, corners, polygon_start, corner_uv, corner_normals, edge_marks, tolerance: 0.0 };
        mesh.tolerance = self.decimals.tolerance(mesh.largest_coordinate());
        let (pieces, materials) = self.pieces.finish(mesh.polygon_count());
        let rest = self.libraries.iter().map(|name| format!("what {name} says of materials")).collect();
        let model = Model { pieces, materials, rest, named: self.libraries, warnings, ..Model::of(mesh) };
        ObjFile { source, model, corner_normal: self.corner_normal, edits: self.edits }
    }

    /// The file's own UVs, or `None` where no corner has one.
    fn corner_uv(&mut self) -> Option<Vec<DVec2>> {
        let corner_texture = core::mem::take(&mut self.corner_texture);
        if self.textures.is_empty() {
            self.odd.lost_textures = corner_texture.iter().filter(|t| **t != 0).count();
            return None;
        }
        let mut lost = 0;
        let mut some = false;
        let uv = corner_texture.iter().map(|texture| match (*texture as usize).checked_sub(1) {
            None => NO_UV,
            Some(i) => match self.textures.get(i) {
                Some(uv) => {
                    some |= uv.is_finite();
                    *uv
                }
                None => {
                    lost += 1;
                    NO_UV
                }
            },
        });
        let uv: Vec<DVec2> = uv.collect();
        self.odd.lost_textures = lost;
        some.then_some(uv)
    }
}

/// Words of a statement, its keyword included; counting stops at 4.
fn words_left(text: &[u8]) -> usize {
    Words::new(text).take(4).count()
}

/// Counts of what the user should know.
#[derive(Default)]
struct Oddities {
    short_faces: Tally,
    detached: Tally,
    lost_textures: usize,
    lost_normals: usize,
}

/// How often, and where first.
#[derive(Default)]
struct Tally {
    count: usize,
    line: usize,
}

impl Tally {
    fn see(&mut self, line: usize) {
        if self.count == 0 {
            self.line = line;
        }
        self.count += 1;
    }
}

impl Oddities {
    fn warnings(&self) -> Vec<String> {
        let mut out = Vec::new();
        let Tally { count, line } = self.short_faces;
        if count > 0 {
            out.push(format!("{count} faces have fewer than three corners and stay as they are (first: line {line})"));
        }
        let Tally { count, line } = self.detached;
        if count > 0 {
            out.push(format!("{count} lines or surfaces lose their references to the old UVs (first: line {line})"));
        }
        if self.lost_textures > 0 {
            out.push(format!("{} corners name a vt that is not there", self.lost_textures));
        }
        if self.lost_normals > 0 {
            out.push(format!("{} corners name a vn that is not there; their normals are left out", self.lost_normals));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(text: &str) -> Mesh {
        read(text.as_bytes().to_vec()).unwrap().model.mesh
    }

    fn error(text: &str) -> (usize, Problem) {
        let e = read(text.as_bytes().to_vec()).err().unwrap();
        (e.line, e.problem)
    }

    #[test]
    fn negative_indices_count_from_their_own_line() {
        let m = mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf -1 1 2\n");
        assert_eq!(m.corners, [0, 1, 2, 3, 0, 1]);
        assert_eq!(m.polygon_start, [0, 3, 6]);
    }

    #[test]
    fn faces_may_come_before_their_vertices() {
        assert_eq!(mesh("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0").corners, [0, 1, 2]);
    }

    #[test]
    fn weights_colours_exponents_and_signs_are_read_past() {
        let m = mesh("v +1e1 -.5 2. 1\nv 0 0 0 .1 .2 .3\nv 1 0 0 nan\nf 1 2 3");
        assert_eq!(m.positions[0], DVec3::new(10.0, -0.5, 2.0));
    }

    #[test]
    fn every_shape_of_corner_is_read() {
        let f =
            read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt .5\nvt .25 .75 0\nvn 0 0 1\nf 1/1/1 2/-1 3//-1\nf 1/ 2// 3".to_vec());
        let f = f.unwrap();
        let uv = f.model.mesh.corner_uv.unwrap();
        assert_eq!(uv[..2], [DVec2::new(0.5, 0.0), DVec2::new(0.25, 0.75)]);
        assert!(uv[2..].iter().all(|uv| uv.is_nan()));
        assert_eq!(f.corner_normal, [1, 0, 1, 0, 0, 0]);
    }

    #[test]
    fn an_error_names_its_line() {
        let three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        assert_eq!(error("v 0 0 0\nv 1 2"), (2, Problem::FewCoordinates { given: 2 }));
        assert_eq!(error("v 0 0 nan"), (1, Problem::NotFinite { word: "nan".into() }));
        assert_eq!(error("\nv 0 1e999 0"), (2, Problem::NotFinite { word: "1e999".into() }));
        assert_eq!(error("v 0 1.#INF 0"), (1, Problem::NotANumber { word: "1.#INF".into() }));
        assert_eq!(error("v 0 0,5 0"), (1, Problem::NotANumber { word: "0,5".into() }));
        assert_eq!(error(&format!("{three}f 1 2 0")), (4, Problem::ZeroIndex));
        assert_eq!(
            error(&format!("{three}f 1 2 3\n#\\\nf 1 \\\n2 9")),
            (6, Problem::OutOfRange { index: 9, count: 3 })
        );
        assert_eq!(error(&format!("{three}f 1 2 -4")), (4, Problem::OutOfRange { index: -4, count: 3 }));
        assert_eq!(error(&format!("{three}f 1 2 3/x")), (4, Problem::NotACorner { word: "3/x".into() }));
        assert_eq!(error(&format!("{three}f 1 2 3/1/1/1")).1, Problem::NotACorner { word: "3/1/1/1".into() });
        let huge = format!("{three}f 1 2 -99999999999999999999");
        assert_eq!(error(&huge).1, Problem::OutOfRange { index: -i64::MAX, count: 3 });
    }

    #[test]
    fn dangling_vt_and_vn_are_warnings_not_errors() {
        let f = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1 2/0/2 3/-7/0".to_vec()).unwrap();
        assert_eq!(f.model.mesh.corner_uv, None);
        assert!(f.corner_normal.is_empty());
        assert_eq!(f.model.warnings.len(), 2);
    }

    #[test]
    fn normals_smoothing_groups_and_digits_are_read() {
        let m = mesh(
            "v 0 0 0\nv 1.50 0 0\nv 0 1 0\nv 1 1 0\nvn 0 0 1\nvn 0 x 1\nf 1//1 2//2 3\ns 1\nf 3 2 4\ns off\nf 4 2 1",
        );
        let normals = m.corner_normals.unwrap();
        assert_eq!((normals[0], normals[2]), (Vec3::Z, Vec3::ZERO));
        assert!(normals[1].is_nan());
        assert_eq!(m.edge_marks.unwrap(), [0, 0, 0, 0, 2, 0, 2, 0, 0]);
        assert_eq!(m.tolerance, 0.005);
        let m = mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\ns 1\nf 1 2 3");
        assert_eq!((m.corner_normals, m.edge_marks, m.tolerance), (None, None, 0.5f64.powi(24)));
    }

    #[test]
    fn faces_of_two_corners_and_lines_are_no_polygons() {
        let f = read(b"v 0 0 0\nv 1 0 0\nf 1 2\nf\nl 1 2\nl 1/1 2/1\np 1".to_vec()).unwrap();
        assert_eq!(f.model.mesh.polygon_count(), 0);
        assert_eq!(f.edits.len(), 1);
        assert_eq!(f.model.warnings.len(), 2);
    }
}
