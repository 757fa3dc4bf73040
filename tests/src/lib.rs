//! Shared helpers of the test suites.

pub mod fixtures;
pub mod header;
pub mod learned;
pub mod plain_obj;
pub mod road;
pub mod scenes;
pub mod shapes;
pub mod solids;

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

/// Rand error: the share of pairs of faces that one labelling joins and the other parts; 0 for fewer than two faces.
pub fn rand_error(a: &[u32], b: &[u32]) -> f64 {
    use std::collections::HashMap;
    assert_eq!(a.len(), b.len(), "one label a face");
    let (mut both, mut first, mut second) = (HashMap::new(), HashMap::new(), HashMap::new());
    for pair in a.iter().copied().zip(b.iter().copied()) {
        *both.entry(pair).or_insert(0u64) += 1;
        *first.entry(pair.0).or_insert(0u64) += 1;
        *second.entry(pair.1).or_insert(0u64) += 1;
    }
    let joined = |counts: &mut dyn Iterator<Item = &u64>| counts.map(|n| n * (n - 1) / 2).sum::<u64>();
    let (ab, a_only, b_only) = (joined(&mut both.values()), joined(&mut first.values()), joined(&mut second.values()));
    let pairs = a.len() as f64 * (a.len() as f64 - 1.0) / 2.0;
    if pairs > 0.0 { (a_only + b_only - 2 * ab) as f64 / pairs } else { 0.0 }
}

/// This thread's time on a processor where Linux says it, else time passed.
pub fn seconds() -> f64 {
    use std::sync::LazyLock;
    static START: LazyLock<std::time::Instant> = LazyLock::new(std::time::Instant::now);
    let on_processor = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    match on_processor.and_then(|s| s.split_whitespace().next().and_then(|n| n.parse::<f64>().ok())) {
        Some(nanoseconds) => nanoseconds * 1e-9,
        None => START.elapsed().as_secs_f64(),
    }
}

#[cfg(test)]
mod tests {
    use super::rand_error;

    #[test]
    fn the_rand_error_counts_pairs() {
        assert_eq!(rand_error(&[0, 0, 1, 1], &[5, 5, 7, 7]), 0.0);
        // Of six pairs (0,1), (2,3) are joined by the first only.
        assert_eq!(rand_error(&[0, 0, 1, 1], &[0, 1, 2, 3]), 2.0 / 6.0);
        assert_eq!(rand_error(&[3], &[9]), 0.0);
    }
}
