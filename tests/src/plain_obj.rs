//! A plain OBJ reader for the judge's tests: `v`, `vt` and `f` lines, negative indices, nothing else.
//!
//! Written apart from the command's loader on purpose, so that the judge is tested on what a file says even where the
//! loader changes. It panics on what it does not understand.

use glam::{DVec2, DVec3};
use seamwright::mesh::view::PolygonView;

/// An OBJ in memory.
#[derive(Default)]
pub struct PlainObj {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Vertex of each corner.
    pub corners: Vec<u32>,
    /// First corner of each polygon, and the number of corners.
    pub polygon_start: Vec<u32>,
    /// UV of each corner; NaN where it has none.
    pub corner_uv: Vec<DVec2>,
}

impl PlainObj {
    /// Reads `text`.
    pub fn parse(text: &str) -> Self {
        let mut out = Self { polygon_start: vec![0], ..Self::default() };
        let mut uv = vec![];
        for line in text.lines() {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    let [x, y, z] = numbers(words);
                    out.positions.push(DVec3::new(x, y, z));
                }
                Some("vt") => {
                    let [u, v] = numbers(words);
                    uv.push(DVec2::new(u, v));
                }
                Some("f") => {
                    for word in words {
                        let mut parts = word.split('/');
                        let vertex = index(parts.next(), out.positions.len()).expect("a corner names a vertex");
                        out.corners.push(vertex as u32);
                        out.corner_uv.push(index(parts.next(), uv.len()).map_or(DVec2::NAN, |i| uv[i]));
                    }
                    out.polygon_start.push(out.corners.len() as u32);
                }
                _ => {}
            }
        }
        out
    }

    /// What `measure` takes.
    pub fn polygons(&self) -> PolygonView<'_> {
        PolygonView {
            positions: &self.positions,
            corners: &self.corners,
            polygon_start: &self.polygon_start,
            corner_uv: Some(&self.corner_uv),
        }
    }
}

fn numbers<const N: usize>(words: core::str::SplitWhitespace) -> [f64; N] {
    let values: Vec<f64> = words.take(N).map(|w| w.parse().expect("a number")).collect();
    values.try_into().expect("enough numbers")
}

/// An OBJ index counts from 1, or back from the end where it is negative; 0 or nothing is no index.
fn index(word: Option<&str>, count: usize) -> Option<usize> {
    match word.filter(|w| !w.is_empty()).map_or(0, |w| w.parse::<i64>().expect("an index")) {
        0 => None,
        i if i > 0 => Some(i as usize - 1),
        i => Some((count as i64 + i) as usize),
    }
}
