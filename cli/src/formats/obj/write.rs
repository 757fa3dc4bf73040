//! The user's OBJ with a new atlas: its own bytes, other `vt` lines, other face corners.
//!
//! Positions, colours, normals, groups, objects, materials, smoothing, comments and whatever else stand byte for byte
//! where they stood. The new `vt` lines stand where the first old one stood, or before the first face. Corners become
//! `v/vt` or `v/vt/vn` with indices from 1; the blanks and comments of a face's line stay. A face that a backslash continues
//! on the next line is written on one: few readers know the backslash, and its line is another one now anyway.
//! Each `vt` is the shortest decimal that reads back as the same double; values k / 2^24 read back exactly as floats too.

use super::field::names_texture;
use super::file::{EditKind, ObjFile};
use super::statement::{Statements, Words, newline};
use crate::formats::groups::Groups;
use glam::DVec2;
use std::collections::HashMap;
use std::io::{self, Write};

/// Writes `file` with one UV a corner. A UV that is not finite is left out of its corner. With `groups`, a `g` line stands
/// before each polygon whose group is another than that of the one before it, and overrules the file's own groups.
///
/// Panics unless `corner_uv` has one entry for each corner of the file's mesh.
pub fn write(out: &mut dyn Write, file: &ObjFile, corner_uv: &[DVec2], groups: Option<&Groups>) -> io::Result<()> {
    assert_eq!(corner_uv.len(), file.model.mesh.corners.len(), "one UV a corner");
    let (source, table) = (&file.source, UvTable::new(corner_uv));
    let mut written = 0; // bytes of the source that are dealt with
    let mut polygon = 0;
    let mut before = 0; // end of the polygon before
    let mut placed = false;
    for edit in &file.edits {
        out.write_all(&source[written..edit.start])?;
        written = edit.end;
        if !placed && edit.kind != EditKind::Detach {
            table.write_lines(out, newline(source))?;
            placed = true;
        }
        let text = &source[edit.start..edit.end];
        match edit.kind {
            EditKind::Texture => {}
            EditKind::Face => {
                let between = &source[before..edit.start];
                let changed =
                    groups.is_some() && Statements::new(between).any(|s| names_group(&between[s.start..s.end]));
                if let Some(name) = groups.and_then(|groups| groups.name(polygon, changed)) {
                    write!(out, "g {name}")?;
                    out.write_all(newline(source))?;
                }
                before = edit.end;
                write_face(out, text, file, &table, polygon)?;
                polygon += 1;
            }
            EditKind::Detach => write_detached(out, text)?,
        }
    }
    out.write_all(&source[written..])
}

/// Whether a statement begins a group or an object, which readers take for one.
fn names_group(text: &[u8]) -> bool {
    matches!(Words::new(text).next(), Some(b"g" | b"o"))
}

/// Replaces each corner in the statement's text.
fn write_face(out: &mut dyn Write, text: &[u8], file: &ObjFile, table: &UvTable, polygon: usize) -> io::Result<()> {
    let mut words = Words::new(text);
    let (keyword, mut written) = words.next_span().unwrap_or((0, 0));
    write_gap(out, &text[..keyword])?;
    out.write_all(&text[keyword..written])?;
    for c in file.model.mesh.polygon(polygon) {
        let Some((start, end)) = words.next_span() else { break };
        write_gap(out, &text[written..start])?;
        let normal = file.corner_normal.get(c).copied().unwrap_or(0);
        write_corner(out, file.model.mesh.corners[c], table.corner_texture[c], normal)?;
        written = end;
    }
    write_gap(out, &text[written..])
}

/// What stands beside the corners of a face; a joined line end and all before it become one blank.
fn write_gap(out: &mut dyn Write, gap: &[u8]) -> io::Result<()> {
    match gap.iter().rposition(|b| matches!(b, b'\n' | b'\r')) {
        Some(end) => out.write_all(b" ").and_then(|()| out.write_all(gap[end + 1..].trim_ascii_start())),
        None => out.write_all(gap),
    }
}

/// One corner: the vertex from 0, texture and normal from 1, 0 for none.
pub(super) fn write_corner(out: &mut dyn Write, vertex: u32, texture: u32, normal: u32) -> io::Result<()> {
    let vertex = u64::from(vertex) + 1;
    match (texture, normal) {
        (0, 0) => write!(out, "{vertex}"),
        (0, n) => write!(out, "{vertex}//{n}"),
        (t, 0) => write!(out, "{vertex}/{t}"),
        (t, n) => write!(out, "{vertex}/{t}/{n}"),
    }
}

/// Takes the `vt` field out of each `v/vt` and `v/vt/vn`.
fn write_detached(out: &mut dyn Write, text: &[u8]) -> io::Result<()> {
    let mut words = Words::new(text);
    let mut written = 0;
    while let Some((start, end)) = words.next_span() {
        if names_texture(&text[start..end]) {
            let mut fields = text[start..end].split(|b| *b == b'/');
            out.write_all(&text[written..start])?;
            out.write_all(fields.next().unwrap_or_default())?;
            if let Some(normal) = fields.nth(1).filter(|n| !n.is_empty()) {
                out.write_all(b"//")?;
                out.write_all(normal)?;
            }
            written = end;
        }
    }
    out.write_all(&text[written..])
}

/// The distinct UVs of an atlas, in the order of their first corners.
pub(super) struct UvTable {
    lines: Vec<DVec2>,
    /// `vt` of each corner, from 1; 0: none.
    pub corner_texture: Vec<u32>, // (c)
}

impl UvTable {
    pub fn new(corner_uv: &[DVec2]) -> Self {
        let mut lines = Vec::new();
        let mut line_of: HashMap<[u64; 2], u32> = HashMap::with_capacity(corner_uv.len() / 4);
        let corner_texture = corner_uv.iter().map(|uv| {
            if !uv.is_finite() {
                return 0;
            }
            let uv = *uv + DVec2::ZERO; // -0 becomes 0
            *line_of.entry([uv.x.to_bits(), uv.y.to_bits()]).or_insert_with(|| {
                lines.push(uv);
                lines.len() as u32
            })
        });
        let corner_texture = corner_texture.collect();
        Self { lines, corner_texture }
    }

    pub fn write_lines(&self, out: &mut dyn Write, newline: &[u8]) -> io::Result<()> {
        for uv in &self.lines {
            // Display of f64 is the shortest decimal that reads back the same, and never has an exponent.
            write!(out, "vt {} {}", uv.x, uv.y)?;
            out.write_all(newline)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::read::read;
    use super::*;
    use quickcheck::quickcheck;

    fn rewritten(source: &[u8], uv: impl Fn(usize) -> DVec2) -> String {
        let file = read(source.to_vec()).unwrap();
        let uv: Vec<_> = (0..file.model.mesh.corners.len()).map(uv).collect();
        let mut out = Vec::new();
        write(&mut out, &file, &uv, None).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn only_vt_lines_and_face_corners_change() {
        let source = b"# c\r\nmtllib a b.mtl\r\nv  0 0 0 1 .5 0\r\nv 1 0 0\r\nv 0 1 0\r\nvt 9 9\r\nvn 0 0 1\r\ng x\r\n\
            usemtl m\r\n\tf  1/1/1   -2//1 \\\r\n 3/1 # t\r\ns off\r\nl 1/1 2/1/1\r\np 1";
        let expected = "# c\r\nmtllib a b.mtl\r\nv  0 0 0 1 .5 0\r\nv 1 0 0\r\nv 0 1 0\r\nvt 0 0.25\r\nvt 1 0.25\r\n\
            vt 2 0.25\r\nvn 0 0 1\r\ng x\r\nusemtl m\r\n\tf  1/1/1   2/2/1 3/3 # t\r\ns off\r\nl 1 2//1\r\np 1";
        assert_eq!(rewritten(source, |c| DVec2::new(c as f64, 0.25)), expected);
    }

    #[test]
    fn a_backslash_after_the_keyword_does_not_take_it_along() {
        let source = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf \\\n1 \\\n2 3 \\\n";
        let expected = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1 \\\n";
        assert_eq!(rewritten(source, |_| DVec2::ZERO), expected);
        assert_eq!(
            rewritten(b"v 0 0 0\nv 1 0 0\nv 0 1 0\n\\\n f 1 2 3", |_| DVec2::ZERO),
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n f 1/1 2/1 3/1"
        );
    }

    #[test]
    fn groups_stand_before_the_first_polygon_of_each_and_overrule_the_files_own() {
        let source = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3\ng own\nf 1 2 3\n  f 1 3 2\nf 3 2 1\n";
        let file = read(source.to_vec()).unwrap();
        let groups = Groups { of: &[0, 0, 0, 1, 7], names: vec!["a".into(), "b".into()] };
        let mut out = Vec::new();
        write(&mut out, &file, &[DVec2::NAN; 15], Some(&groups)).unwrap();
        let expected =
            "v 0 0 0\nv 1 0 0\nv 0 1 0\ng a\nf 1 2 3\nf 1 2 3\ng own\ng a\nf 1 2 3\ng b\n  f 1 3 2\nf 3 2 1\n";
        assert_eq!(String::from_utf8(out).unwrap(), expected);
    }

    #[test]
    fn equal_uvs_share_one_line_and_missing_ones_have_none() {
        let source = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1";
        let uv = |c: usize| if c == 5 { DVec2::NAN } else { DVec2::new(-0.0 * c as f64, 0.5) };
        let expected = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.5\nf 1/1 2/1 3/1\nf 3/1 2/1 1";
        assert_eq!(rewritten(source, uv), expected);
    }

    #[test]
    fn a_file_without_faces_comes_back_as_it_was() {
        assert_eq!(rewritten(b"v 0 0 0\nf 1 1\nl 1 1\nfoo\\", |_| DVec2::ZERO), "v 0 0 0\nf 1 1\nl 1 1\nfoo\\");
    }

    quickcheck! {
        fn grid_values_read_back_exactly_as_floats_and_doubles(k: u32) -> bool {
            let value = f64::from(k % ((1 << 24) + 1)) / f64::from(1u32 << 24);
            let text = format!("{value}");
            !text.contains(['e', 'E']) && text.parse() == Ok(value) && text.parse() == Ok(value as f32)
        }
    }
}
