//! OFF, text: read, and written without UVs where that is asked for.
//!
//! Read: `OFF` with the prefixes `ST`, `C` and `N`; vertices and polygons, each on a line, with comments from `#` on; colours of
//! vertices of a `COFF`. Limits: `4OFF`, `nOFF` and `BINARY` are refused; normals, UVs of vertices and colours of faces are
//! read past.

use super::error::FormatError;
use super::model::Model;
use crate::mesh::polygons::Mesh;
use crate::mesh::precision::Decimals;
use glam::DVec3;
use std::io::{self, Write};

/// Reads an OFF. O(bytes).
pub fn read(bytes: &[u8]) -> Result<Model, FormatError> {
    let mut lines = WordLines { rest: bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes), line: 0 };
    let first = lines.words().unwrap_or_default();
    let prefix = first.first().and_then(|word| word.strip_suffix("OFF"));
    let prefix = prefix.ok_or_else(|| FormatError::whole("does not begin with 'OFF'; is this an OFF file?"))?;
    if !["", "ST", "C", "N", "STC", "STN", "CN", "STCN"].contains(&prefix) || first.get(1) == Some(&"BINARY") {
        let text = format!("'{}' is not read, only text in three dimensions; convert it first", first.join(" "));
        return Err(FormatError { line: lines.line, problem: text });
    }
    let counts = if first.len() > 1 { first[1..].to_vec() } else { lines.words().unwrap_or_default() };
    let count = |i: usize| counts.get(i).and_then(|word| word.parse::<usize>().ok());
    let (Some(vertices), Some(faces)) = (count(0), count(1)) else {
        return Err(FormatError {
            line: lines.line,
            problem: "no counts of vertices and faces; export it again".into(),
        });
    };
    let mut build = OffBuild { mesh: Mesh::new(), ..OffBuild::default() };
    for i in 0..vertices {
        build.vertex(&lines.item("vertex", i, vertices)?, prefix, lines.line)?;
    }
    for i in 0..faces {
        build.face(&lines.item("face", i, faces)?, lines.line)?;
    }
    build.finish()
}

/// Lines with their words, comments left out.
struct WordLines<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> WordLines<'a> {
    /// Words of the next line that has any.
    fn words(&mut self) -> Option<Vec<&'a str>> {
        while !self.rest.is_empty() {
            let end = memchr::memchr2(b'\n', b'\r', self.rest).unwrap_or(self.rest.len());
            let text = &self.rest[..end];
            let next = end + if self.rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
            self.rest = self.rest.get(next..).unwrap_or_default();
            self.line += 1;
            let text = &text[..memchr::memchr(b'#', text).unwrap_or(text.len())];
            // What is no text is no number, and is refused as such.
            let words: Vec<&str> = core::str::from_utf8(text).unwrap_or("?").split_ascii_whitespace().collect();
            if !words.is_empty() {
                return Some(words);
            }
        }
        None
    }

    fn item(&mut self, what: &str, i: usize, count: usize) -> Result<Vec<&'a str>, FormatError> {
        let text = || FormatError::whole(format!("the file ends in {what} {i} of {count} (from 0); export it again"));
        self.words().ok_or_else(text)
    }
}

#[derive(Default)]
struct OffBuild {
    mesh: Mesh,
    decimals: Decimals,
    colours: Vec<[f32; 4]>,
    small_faces: usize,
    coloured_faces: bool,
}

impl OffBuild {
    fn vertex(&mut self, words: &[&str], prefix: &str, line: usize) -> Result<(), FormatError> {
        let wrong = |problem: String| FormatError { line, problem };
        if words.len() < 3 {
            return Err(wrong(format!("this vertex has {} of its 3 coordinates; complete the line", words.len())));
        }
        let mut xyz = [0.0; 3];
        for (value, word) in xyz.iter_mut().zip(words) {
            let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
            *value = number.ok_or_else(|| wrong(format!("'{word}' is not a finite number; correct the vertex")))?;
            self.decimals.see(word.as_bytes());
        }
        self.mesh.positions.push(DVec3::from(xyz));
        if prefix.contains('C') {
            let first = if prefix.contains('N') { 6 } else { 3 };
            let parts = [0, 1, 2, 3].map(|i| words.get(first + i).copied());
            let whole = parts.iter().flatten().all(|word| word.bytes().all(|b| b.is_ascii_digit()));
            let part = |word: Option<&str>| {
                word.and_then(|w| w.parse::<f32>().ok()).map(|c| if whole { c / 255.0 } else { c })
            };
            let [r, g, b, a] = parts.map(part);
            if let (Some(r), Some(g), Some(b)) = (r, g, b) {
                self.colours.push([r, g, b, a.unwrap_or(1.0)].map(|c| c.clamp(0.0, 1.0)));
            }
        }
        Ok(())
    }

    fn face(&mut self, words: &[&str], line: usize) -> Result<(), FormatError> {
        let wrong = |problem: String| FormatError { line, problem };
        let count =
            words[0].parse::<usize>().map_err(|_| wrong(format!("'{}' is not a number of corners", words[0])))?;
        let corners = words[1..].get(..count).ok_or_else(|| {
            wrong(format!("this face has {} of its {count} corners; complete the line", words.len() - 1))
        })?;
        self.coloured_faces |= words.len() > count + 1;
        if count < 3 {
            self.small_faces += 1;
            return Ok(());
        }
        for word in corners {
            let vertices = self.mesh.positions.len();
            let vertex = word.parse::<u32>().ok().filter(|v| (*v as usize) < vertices);
            self.mesh.corners.push(vertex.ok_or_else(|| {
                wrong(format!("this face names vertex '{word}' (from 0), but there are {vertices}; correct the face"))
            })?);
        }
        if self.mesh.corners.len() >= u32::MAX as usize {
            return Err(FormatError::whole("more corners than 32-bit indices can name; split the mesh"));
        }
        self.mesh.polygon_start.push(self.mesh.corners.len() as u32);
        Ok(())
    }

    fn finish(mut self) -> Result<Model, FormatError> {
        self.mesh.tolerance = self.decimals.tolerance(self.mesh.largest_coordinate());
        let n = self.mesh.positions.len();
        let small = self.small_faces;
        let warning = (small > 0).then(|| format!("{small} faces have fewer than three corners and are left out"));
        let rest = self.coloured_faces.then(|| "colours of faces".into()).into_iter().collect();
        let colours = Some(self.colours).filter(|colours| n > 0 && colours.len() == n);
        Model { colours, rest, warnings: warning.into_iter().collect(), ..Model::of(self.mesh) }.checked()
    }
}

/// Writes vertices and polygons, nothing else.
pub fn compose(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    write!(out, "OFF\n{} {} 0\n", mesh.positions.len(), mesh.polygon_count())?;
    for p in &mesh.positions {
        let [x, y, z] = p.to_array().map(shortest);
        writeln!(out, "{x} {y} {z}")?;
    }
    for p in mesh.polygons() {
        write!(out, "{}", p.len())?;
        mesh.corners[p].iter().try_for_each(|v| write!(out, " {v}"))?;
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// The shortest decimal that reads back the same, as a float where it is one.
pub(super) fn shortest(x: f64) -> String {
    let float = x as f32;
    if f64::from(float) == x { float.to_string() } else { x.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quickcheck::quickcheck;

    const QUAD: &str = "OFF # a quad\n\n4 2 0\n0 0 0\r\n1.5 0 0 # x\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n2 0 1\n";

    #[test]
    fn polygons_are_read_and_written() {
        let model = read(QUAD.as_bytes()).unwrap();
        assert_eq!((&model.mesh.corners[..], model.mesh.tolerance), (&[0, 1, 2, 3][..], 0.05));
        assert_eq!((model.warnings.len(), &model.rest[0][..]), (1, "colours of faces"));
        let mut out = Vec::new();
        compose(&mut out, &model.mesh).unwrap();
        assert_eq!(String::from_utf8_lossy(&out), "OFF\n4 1 0\n0 0 0\n1.5 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n");
        assert_eq!(read(&out).unwrap().mesh, model.mesh);
    }

    #[test]
    fn counts_beside_the_keyword_and_colours_of_vertices_are_read() {
        let model = read(b"CNOFF 3 1 0\n0 0 0 0 0 1 255 0 51\n1 0 0 0 0 1 255 0 51\n0 1 0 0 0 1 255 0 51 255\n3 0 1 2")
            .unwrap();
        assert_eq!(model.colours.unwrap()[0], [1.0, 0.0, 0.2, 1.0]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let error = |text: &str| read(text.as_bytes()).err().unwrap();
        assert!(error("ply").problem.contains("OFF"));
        assert!(error("4OFF\n1 0 0").problem.contains("4OFF"));
        assert_eq!(error("OFF\n2 0 0\n0 0 0\n1 x 0").line, 4);
        assert_eq!(error("OFF\n1 1 0\n0 0 0\n3 0 0 1").line, 4);
        assert!(error("OFF\n2 0 0\n0 0 0\n").problem.contains("vertex 1 of 2"));
        assert!(error("OFF\nx").problem.contains("counts"));
    }

    quickcheck! {
        fn damaged_files_never_panic(at: usize, byte: u8, cut: usize) -> bool {
            let mut bytes = QUAD.as_bytes().to_vec();
            let length = bytes.len();
            bytes[at % length] = byte;
            let _ = (read(&bytes), read(&bytes[..cut % length]));
            true
        }
    }
}
