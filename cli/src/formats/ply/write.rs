//! The user's PLY with a new set of UVs: its own bytes, and the list `texcoord` of each face.
//!
//! Every element, property and comment, the order of bytes and the line ends stay. The old UVs of the set are taken out,
//! those of vertices among them, or get the number of a free set where they are to stay. Values beyond those that the header
//! names are left out, since a reader would take them for UVs. Triangle strips hold no UVs a corner and become faces.

use super::file::PlyFile;
use super::header::{Element, Encoding};
use super::names::{set_of, texcoord, uv_set};
use glam::DVec2;
use std::io::{self, Write};

/// Writes `file` with one UV a corner as set `set`; one that is not finite is 0, 0. With `keep`, the set's old UVs stay.
pub fn write(out: &mut dyn Write, file: &PlyFile, corner_uv: &[DVec2], set: u32, keep: bool) -> io::Result<()> {
    let plan = Plan { file, set, keep };
    plan.header(out)?;
    plan.body(out, corner_uv)
}

/// What the user should know of the file that [`write`] gives.
pub fn warnings(file: &PlyFile) -> Vec<String> {
    let is_strips = Plan { file, set: 0, keep: false }.strips().is_some();
    is_strips.then(|| "triangle strips hold no UVs; they become faces".into()).into_iter().collect()
}

struct Plan<'a> {
    file: &'a PlyFile,
    set: u32,
    keep: bool,
}

impl Plan<'_> {
    fn faces(&self) -> Option<&Element> {
        self.file.faces.map(|e| &self.file.header.elements[e])
    }

    fn strips(&self) -> Option<&Element> {
        self.faces().filter(|element| element.name == "tristrips")
    }

    /// Whether a property goes with the old UVs.
    fn goes(&self, element: &Element, property: usize) -> bool {
        !self.keep && uv_set(element, property) == Some(self.set)
    }

    /// The lowest set that no face has a list for.
    fn free_set(&self) -> u32 {
        let has =
            |set: &u32| self.faces().is_some_and(|faces| faces.find(&[&texcoord(*set)]).is_some()) || *set == self.set;
        (0..).find(|set| !has(set)).unwrap_or(0)
    }

    fn header(&self, out: &mut dyn Write) -> io::Result<()> {
        let header = &self.file.header;
        let source = &self.file.source;
        let newline = self.newline();
        let property = |line: usize| {
            let all =
                header.elements.iter().flat_map(|e| e.properties.iter().enumerate().map(move |(p, own)| (e, p, own)));
            all.into_iter().find(|(_, _, own)| own.line == line).map(|(element, p, _)| (element, p))
        };
        let last = self.faces().map(|faces| faces.properties.last().map_or(faces.line, |property| property.line));
        for (line, (start, end)) in header.lines.iter().enumerate() {
            let text = &source[*start..*end];
            let of = property(line);
            let in_strips = |element: &Element| self.strips().is_some_and(|strips| strips.line == element.line);
            match of {
                _ if self.strips().is_some_and(|strips| strips.line == line) => {
                    write!(out, "element face {}", self.file.model.mesh.polygon_count())?;
                    out.write_all(newline)?;
                    out.write_all(b"property list uchar int vertex_indices")?;
                    out.write_all(newline)?;
                }
                Some((element, _)) if in_strips(element) => {}
                Some((element, p)) if self.goes(element, p) => {}
                Some((element, p))
                    if element.name == "face" && set_of(&element.properties[p].name) == Some(self.set) =>
                {
                    let renamed = String::from_utf8_lossy(text);
                    let name = renamed.trim_end().rsplit_once(char::is_whitespace).map_or("", |(head, _)| head);
                    write!(out, "{name} {}", texcoord(self.free_set()))?;
                    out.write_all(newline)?;
                }
                _ => out.write_all(text)?,
            }
            if last == Some(line) {
                write!(out, "property list {} float {}", self.length_type(), texcoord(self.set))?;
                out.write_all(newline)?;
            }
        }
        Ok(())
    }

    /// The line end of the header.
    fn newline(&self) -> &[u8] {
        let (_, end) = self.file.header.lines[0];
        let text = &self.file.source[..end];
        let start = text.iter().rposition(|b| !matches!(b, b'\r' | b'\n')).map_or(0, |i| i + 1);
        if start < end { &text[start..] } else { b"\n" }
    }

    /// The type of a list's length.
    fn length_type(&self) -> &'static str {
        let most = self.file.model.mesh.polygons().map(|p| p.len()).max().unwrap_or(0);
        if 2 * most <= usize::from(u8::MAX) { "uchar" } else { "int" }
    }

    fn body(&self, out: &mut dyn Write, corner_uv: &[DVec2]) -> io::Result<()> {
        let PlyFile { source, header, face_ends, .. } = self.file;
        let uv_goes = self.file.uv_values.iter().filter(|(e, p, ..)| self.goes(&header.elements[*e], *p));
        let mut cuts: Vec<(usize, usize)> = uv_goes.map(|(_, _, start, end)| (*start, *end)).collect();
        cuts.extend(&self.file.beyond);
        if let Some((start, end)) = self.strip_bytes() {
            cuts.push((start, end));
        }
        cuts.sort_unstable();
        let mut cuts = cuts.into_iter().peekable();
        let mut at = header.end();
        // What lies before `end` and is not cut.
        let mut copy = |out: &mut dyn Write, end: usize| -> io::Result<()> {
            while let Some((from, to)) = cuts.next_if(|cut| cut.0 < end) {
                out.write_all(&source[at.min(from)..from])?;
                at = at.max(to.min(end));
            }
            out.write_all(&source[at.min(end)..end])?;
            at = at.max(end);
            Ok(())
        };
        if self.strips().is_some() {
            if let Some((start, _)) = self.strip_bytes() {
                copy(out, start)?;
            }
            for p in 0..self.file.model.mesh.polygon_count() {
                self.corners(out, p)?;
                self.uvs(out, Some(p), corner_uv)?;
                if header.encoding == Encoding::Text {
                    out.write_all(self.newline())?;
                }
            }
        } else {
            let mut polygon = 0;
            for (end, is_polygon) in face_ends {
                copy(out, *end)?;
                self.uvs(out, is_polygon.then_some(polygon), corner_uv)?;
                polygon += usize::from(*is_polygon);
            }
        }
        copy(out, source.len())
    }

    /// The bytes of all strips, with the line end behind them.
    fn strip_bytes(&self) -> Option<(usize, usize)> {
        let strips = self.strips()?;
        let PlyFile { source, header, face_ends, .. } = self.file;
        let (start, mut end) = (self.file.strips_start, face_ends.last().map_or(header.end(), |last| last.0));
        if header.encoding == Encoding::Text && strips.count > 0 {
            end += source[end..].iter().position(|b| *b == b'\n').map_or(source.len() - end, |i| i + 1);
        }
        Some((start, end.max(start)))
    }

    fn corners(&self, out: &mut dyn Write, p: usize) -> io::Result<()> {
        let mesh = &self.file.model.mesh;
        let corners = &mesh.corners[mesh.polygon(p)];
        match self.file.header.encoding {
            Encoding::Text => {
                write!(out, "{}", corners.len())?;
                corners.iter().try_for_each(|v| write!(out, " {v}"))
            }
            order => {
                out.write_all(&[corners.len() as u8])?;
                corners.iter().try_for_each(|v| word(out, v.to_le_bytes(), order))
            }
        }
    }

    /// The list of a face; empty for one that is no polygon.
    fn uvs(&self, out: &mut dyn Write, polygon: Option<usize>, corner_uv: &[DVec2]) -> io::Result<()> {
        let uv = polygon.map_or(&[][..], |p| &corner_uv[self.file.model.mesh.polygon(p)]);
        let length = 2 * uv.len();
        let numbers = uv.iter().map(|uv| if uv.is_finite() { *uv } else { DVec2::ZERO }).flat_map(|uv| uv.to_array());
        match self.file.header.encoding {
            Encoding::Text => {
                write!(out, " {length}")?;
                // The shortest decimal that reads back the same; adding 0 makes -0 one.
                numbers.into_iter().try_for_each(|x| write!(out, " {}", x + 0.0))
            }
            order => {
                match self.length_type() {
                    "uchar" => out.write_all(&[length as u8])?,
                    _ => word(out, (length as u32).to_le_bytes(), order)?,
                }
                numbers.into_iter().try_for_each(|x| word(out, (x as f32 + 0.0).to_le_bytes(), order))
            }
        }
    }
}

/// Four bytes in the file's order.
fn word(out: &mut dyn Write, mut bytes: [u8; 4], order: Encoding) -> io::Result<()> {
    if order == Encoding::Big {
        bytes.reverse();
    }
    out.write_all(&bytes)
}

#[cfg(test)]
mod tests {
    use super::super::read::read;
    use super::*;
    use crate::formats::reading::Reading;

    fn rewritten(source: &[u8], set: u32, keep: bool) -> Vec<u8> {
        let file = read(source.to_vec(), Reading::default()).unwrap();
        let uv: Vec<DVec2> = (0..file.model.mesh.corners.len()).map(|c| DVec2::new(c as f64 / 8.0, 0.5)).collect();
        let mut out = Vec::new();
        write(&mut out, &file, &uv, set, keep).unwrap();
        let reading = Reading { uv_set: set, ..Reading::default() };
        let back = read(out.clone(), reading).unwrap().model.mesh;
        assert_eq!((back.corners, back.corner_uv), (file.model.mesh.corners, Some(uv)));
        out
    }

    fn text(source: &str, set: u32, keep: bool) -> String {
        String::from_utf8(rewritten(source.as_bytes(), set, keep)).unwrap()
    }

    const HEAD: &str = "ply\r\nformat ascii 1.0\r\ncomment mine\r\nelement vertex 3\r\nproperty float x\r\nproperty float y\r\n\
        property float z\r\nproperty float s\r\nproperty float t\r\nproperty uchar red\r\nelement face 2\r\n\
        property uchar a\r\nproperty list uchar float texcoord\r\nproperty list uchar int vertex_indices\r\n\
        element mine 1\r\nproperty list int short b\r\nend_header\r\n";
    const BODY: &str =
        "0 0 0 .1 .2 9\r\n1 0 0  .1 .2 9\r\n0 1 0 .1 .2 9\r\n7 6 0 0 1 0 0 1 3 0 1 2\r\n8 0 2 0 1\r\n2 -5 6\r\n";

    #[test]
    fn everything_but_the_old_uvs_stays() {
        let expected = "ply\r\nformat ascii 1.0\r\ncomment mine\r\nelement vertex 3\r\nproperty float x\r\nproperty float y\r\n\
            property float z\r\nproperty uchar red\r\nelement face 2\r\nproperty uchar a\r\n\
            property list uchar int vertex_indices\r\nproperty list uchar float texcoord\r\n\
            element mine 1\r\nproperty list int short b\r\nend_header\r\n\
            0 0 0 9\r\n1 0 0 9\r\n0 1 0 9\r\n7 3 0 1 2 6 0 0.5 0.125 0.5 0.25 0.5\r\n8 2 0 1 0\r\n2 -5 6\r\n";
        assert_eq!(text(&format!("{HEAD}{BODY}"), 0, false), expected);
    }

    #[test]
    fn old_uvs_that_are_kept_are_another_set() {
        let made = text(&format!("{HEAD}{BODY}"), 0, true);
        let lists = "property list uchar float texcoord1\r\nproperty list uchar int vertex_indices\r\nproperty list uchar float texcoord\r\n";
        assert!(made.contains("property float s\r\n") && made.contains(lists), "{made}");
        assert!(made.contains("\r\n7 6 0 0 1 0 0 1 3 0 1 2 6 0 0.5"), "{made}");
    }

    #[test]
    fn another_set_leaves_the_first_alone() {
        let made = text(&format!("{HEAD}{BODY}"), 1, false);
        assert!(
            made.contains("texcoord\r\nproperty list uchar int vertex_indices\r\nproperty list uchar float texcoord1")
        );
        assert!(made.contains("\r\n8 0 2 0 1 0\r\n"), "{made}");
    }

    #[test]
    fn binary_files_keep_their_order_of_bytes() {
        for big in [false, true] {
            let order = if big { "big" } else { "little" };
            let head = |uv: &str| {
                format!(
                    "ply\nformat binary_{order}_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                     property float z\nelement face 1\nproperty list uchar int vertex_indices\n{uv}property short end\nend_header\n"
                )
            };
            let float = |x: f32| if big { x.to_be_bytes() } else { x.to_le_bytes() };
            let int = |x: i32| if big { x.to_be_bytes() } else { x.to_le_bytes() };
            let points: Vec<u8> = [0., 0., 0., 1., 0., 0., 0., 1., 0.].into_iter().flat_map(float).collect();
            let face: Vec<u8> = [vec![3], [0, 1, 2].into_iter().flat_map(int).collect(), vec![4, 5]].concat();
            let source = [head("").into_bytes(), points.clone(), face.clone()].concat();
            let uv: Vec<u8> = [0.0, 0.5, 0.125, 0.5, 0.25, 0.5].into_iter().flat_map(float).collect();
            let list = "property short end\nproperty list uchar float texcoord\n";
            let expected = head("").replace("property short end\n", list).into_bytes();
            let made = rewritten(&source, 0, false);
            assert_eq!(made, [expected, points, face, vec![6], uv].concat());
            assert_eq!(rewritten(&made, 0, false), made);
        }
    }

    #[test]
    fn strips_become_faces_and_values_beyond_the_header_go() {
        let source = "ply\nformat ascii 1.0\nelement vertex 4\nproperty int x\nproperty int y\nproperty int z\nelement tristrips 1\n\
            property list int int vertex_indices\nelement mine 1\nproperty int a\nend_header\n0 0 0 8\n1 0 0\n0 1 0\n1 1 0\n\
            4 0 1 2 3\n5\n";
        let expected = "ply\nformat ascii 1.0\nelement vertex 4\nproperty int x\nproperty int y\nproperty int z\nelement face 2\n\
            property list uchar int vertex_indices\nproperty list uchar float texcoord\nelement mine 1\nproperty int a\nend_header\n\
            0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 6 0 0.5 0.125 0.5 0.25 0.5\n3 2 1 3 6 0.375 0.5 0.5 0.5 0.625 0.5\n5\n";
        assert_eq!(text(source, 0, false), expected);
    }
}
