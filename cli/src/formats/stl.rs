//! STL, text and binary, from their bytes.
//!
//! An STL has no shared vertices, so corners at bit-equal positions become one vertex, in the order of their first use.
//! A binary file whose header begins with `solid` is known by its length. A text is a stream of words, whatever its line ends
//! are, and may begin with a byte order mark.

use super::error::FormatError;
use super::model::Model;
use crate::mesh::polygons::Mesh;
use crate::mesh::precision::{Decimals, of_floats};
use glam::DVec3;
use std::collections::HashMap;

const HEADER: usize = 84; // 80 bytes of anything, then the number of triangles
const TRIANGLE: usize = 50; // normal, three points, two bytes of anything

/// Reads an STL. O(bytes).
pub fn read(bytes: &[u8]) -> Result<Model, FormatError> {
    let mut soup = Soup::default();
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let declared = bytes.get(80..HEADER).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let whole = declared.is_some_and(|n| n.checked_mul(TRIANGLE).is_some_and(|n| n == bytes.len() - HEADER));
    if !whole && text.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) {
        let decimals = soup.read_text(text)?;
        soup.mesh.tolerance = decimals.tolerance(soup.mesh.largest_coordinate());
    } else {
        soup.read_binary(bytes, declared)?;
        soup.mesh.tolerance = of_floats(soup.mesh.largest_coordinate());
    }
    Model::of(soup.mesh).checked()
}

/// Words of a text with their lines, which end in LF, CRLF or CR.
struct TextWords<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Iterator for TextWords<'a> {
    type Item = (&'a [u8], usize);

    fn next(&mut self) -> Option<Self::Item> {
        while let Some(b) = self.bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            let ends = *b == b'\n' || *b == b'\r' && self.bytes.get(self.at + 1) != Some(&b'\n');
            self.line += usize::from(ends);
            self.at += 1;
        }
        let rest = self.bytes.get(self.at..)?;
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += end;
        (end > 0).then_some((&rest[..end], self.line))
    }
}

/// Polygons by their points.
struct Soup {
    mesh: Mesh,
    vertex_of: HashMap<[u64; 3], u32>,
}

impl Default for Soup {
    fn default() -> Self {
        Self { mesh: Mesh::new(), vertex_of: HashMap::new() }
    }
}

impl Soup {
    fn read_binary(&mut self, bytes: &[u8], declared: Option<usize>) -> Result<(), FormatError> {
        let cut = |given: usize| {
            FormatError::whole(format!(
                "a binary STL of {} triangles, but only {given} are there; export it again",
                declared.unwrap_or(0)
            ))
        };
        let count = declared.ok_or_else(|| FormatError::whole("too short for an STL file; export it again"))?;
        let mut triangles = bytes[HEADER..].chunks_exact(TRIANGLE);
        for t in 0..count {
            let triangle = triangles.next().ok_or_else(|| cut(t))?;
            let mut floats = triangle[12..48].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            let mut next = || f64::from(floats.next().unwrap_or(f32::NAN));
            for _ in 0..3 {
                let (x, y, z) = (next(), next(), next());
                self.corner(DVec3::new(x, y, z));
            }
            self.end_polygon();
        }
        Ok(())
    }

    fn read_text(&mut self, bytes: &[u8]) -> Result<Decimals, FormatError> {
        let mut decimals = Decimals::default();
        let mut words = TextWords { bytes, at: 0, line: 1 };
        let mut named = 0; // the line whose words are a solid's name, up to its first facet
        while let Some((word, line)) = words.next() {
            let is = |keyword: &[u8]| word.eq_ignore_ascii_case(keyword);
            if is(b"facet") {
                named = 0;
            } else if line == named {
            } else if is(b"solid") || is(b"endsolid") {
                named = line;
            } else if is(b"vertex") {
                let mut next = || {
                    let (word, line) = words.next().unwrap_or((b"", line));
                    decimals.see(word);
                    let number = core::str::from_utf8(word).ok().and_then(|word| word.parse::<f64>().ok());
                    number.filter(|x| x.is_finite()).ok_or_else(|| {
                        let word = String::from_utf8_lossy(word).into_owned();
                        FormatError { line, problem: format!("'{word}' is not a finite number; correct the vertex") }
                    })
                };
                let point = DVec3::new(next()?, next()?, next()?);
                self.corner(point);
            } else if is(b"endloop") {
                self.end_polygon();
            }
        }
        match self.mesh.polygon_start.last() {
            Some(end) if (*end as usize) < self.mesh.corners.len() => {
                Err(FormatError::whole("ends inside of a loop; export it again"))
            }
            _ => Ok(decimals),
        }
    }

    fn corner(&mut self, point: DVec3) {
        let point = point + DVec3::ZERO; // -0 becomes 0
        let positions = &mut self.mesh.positions;
        let vertex = *self.vertex_of.entry(point.to_array().map(f64::to_bits)).or_insert_with(|| {
            positions.push(point);
            positions.len() as u32 - 1
        });
        self.mesh.corners.push(vertex);
    }

    /// A loop of fewer than three points is dropped.
    fn end_polygon(&mut self) {
        let start = self.mesh.polygon_start.last().map_or(0, |s| *s as usize);
        if self.mesh.corners.len() < start + 3 {
            self.mesh.corners.truncate(start);
        } else {
            self.mesh.polygon_start.push(self.mesh.corners.len() as u32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quickcheck::quickcheck;

    const TEXT: &str = "solid a\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1e0 0\n  \
        endloop\n endfacet\n FACET NORMAL 0 0 0\n OUTER LOOP\n VERTEX -0 0 0\r\n VERTEX 0 1 0\n VERTEX 0 0 1\n ENDLOOP\n\
        ENDFACET\nendsolid a\n";

    fn binary(header: &[u8], triangles: &[[f32; 9]]) -> Vec<u8> {
        let mut bytes = vec![0; 80];
        bytes[..header.len()].copy_from_slice(header);
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for t in triangles {
            bytes.extend([0; 12]);
            bytes.extend(t.iter().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn text_and_binary_give_the_same_mesh() {
        let triangles = [[0., 0., 0., 1., 0., 0., 0., 1., 0.], [-0., 0., 0., 0., 1., 0., 0., 0., 1.]];
        let text = read(TEXT.as_bytes()).unwrap().mesh;
        assert_eq!((&text.corners[..], text.tolerance), (&[0, 1, 2, 0, 2, 3][..], 0.5f64.powi(24)));
        assert_eq!(read(&binary(b"solid by name", &triangles)).unwrap().mesh, text);
    }

    #[test]
    fn a_cut_file_and_a_bad_number_are_errors() {
        let bytes = binary(b"", &[[0.; 9], [1.; 9]]);
        assert!(read(&bytes[..bytes.len() - 1]).unwrap_err().problem.contains("only 1 are there"));
        assert!(read(&bytes[..60]).is_err());
        assert_eq!(read(b"solid\nvertex 0 nan 0").unwrap_err().line, 2);
        assert!(read(&binary(b"", &[[f32::NAN; 9]])).is_err());
    }

    #[test]
    fn a_text_has_any_line_ends_or_none_and_names_of_any_words() {
        let text = read(TEXT.as_bytes()).unwrap().mesh;
        let lines = TEXT.replace("\r\n", "\n");
        for other in [lines.replace('\n', "\r"), lines.replace('\n', " "), format!("\u{feff}{TEXT}")] {
            assert_eq!(read(other.as_bytes()).unwrap().mesh, text, "{other}");
        }
        let named =
            TEXT.replace("solid a", "solid vertex endloop 1").replace("endsolid a", "endsolid vertex endloop 1");
        assert_eq!(read(named.as_bytes()).unwrap().mesh, text);
        assert_eq!(read(b"solid a\rfacet\rvertex 0 x 0").unwrap_err().line, 3);
    }

    #[test]
    fn a_text_that_ends_inside_of_a_loop_is_refused() {
        let whole = "solid s\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
        assert_eq!(read(whole.as_bytes()).map(|bare| bare.mesh.polygon_count()), Ok(1));
        let cut = format!("{whole}facet\nouter loop\nvertex 1 0 0\n");
        assert!(read(cut.as_bytes()).is_err_and(|e| e.problem.contains("inside of a loop")));
    }

    quickcheck! {
        fn random_bytes_never_panic(bytes: Vec<u8>, count: u8) -> bool {
            let mut cut = binary(b"x", &vec![[0.5; 9]; usize::from(count % 4)]);
            cut.truncate(cut.len().saturating_sub(bytes.len() % 90));
            let _ = (read(&bytes), read(&cut), read(&[b"solid ", &bytes[..]].concat()));
            true
        }
    }
}
