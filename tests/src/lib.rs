//! Shared helpers of the test suites.

pub mod learned;
pub mod plain_obj;
pub mod shapes;

use glam::DVec3;

/// Positions and fan triangles of an OBJ, equal positions joined, centred and scaled to a largest coordinate of 1. For
/// benches alone: no groups, no checks beyond the format's.
pub fn load_obj(path: &str) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let (mut positions, mut faces, mut joined) = (Vec::new(), Vec::new(), Vec::new());
    let mut known = std::collections::HashMap::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let p: Vec<f64> = words.take(3).map(|w| w.parse().expect("a coordinate")).collect();
                let key = [p[0], p[1], p[2]].map(|x| (x + 0.0).to_bits());
                let next = positions.len() as u32;
                joined.push(*known.entry(key).or_insert(next));
                if known.len() > positions.len() {
                    positions.push(DVec3::new(p[0], p[1], p[2]));
                }
            }
            Some("f") => {
                let corners: Vec<u32> = words
                    .map(|w| {
                        let index: i64 = w.split('/').next().and_then(|v| v.parse().ok()).expect("a vertex index");
                        joined[if index < 0 { joined.len() as i64 + index } else { index - 1 } as usize]
                    })
                    .collect();
                faces.extend((1..corners.len().saturating_sub(1)).map(|i| [corners[0], corners[i], corners[i + 1]]));
            }
            _ => {}
        }
    }
    let low = positions.iter().fold(DVec3::INFINITY, |m, p| m.min(*p));
    let high = positions.iter().fold(DVec3::NEG_INFINITY, |m, p| m.max(*p));
    let scale = 2.0 / (high - low).max_element();
    positions.iter_mut().for_each(|p| *p = (*p - (low + high) * 0.5) * scale);
    (positions, faces)
}
pub mod fixtures;
