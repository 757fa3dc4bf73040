//! Where the smoothing groups of an OBJ break the shading.
//!
//! Faces of one group are shaded as one surface; a face of group 0, or `off`, is flat. So the shading breaks at an edge whose
//! faces have different groups or one of which has none. Faces before the first `s` line say nothing. Vertices at bit-equal
//! positions are one, since files repeat them along borders. O(c log c) where there is more than one group, else O(p).

use glam::DVec3;
use seamwright_core::price::given::BREAK;
use std::collections::HashMap;

/// Group of a face before the first `s` line.
pub(super) const UNSAID: u32 = u32::MAX;

/// The group that an `s` line begins; `None` where its word is none.
pub(super) fn group(word: &[u8]) -> Option<u32> {
    match word {
        b"off" | b"OFF" | b"Off" => Some(0),
        _ => core::str::from_utf8(word).ok()?.parse().ok().filter(|group| *group != UNSAID),
    }
}

/// A mark of each corner: [`BREAK`] where the shading breaks along the edge that leaves it. `None` where the groups
/// break nothing. `polygon_start` as of a mesh, `groups` one a polygon.
pub(super) fn breaks(positions: &[DVec3], corners: &[u32], polygon_start: &[u32], groups: &[u32]) -> Option<Vec<u8>> {
    let first = *groups.first()?;
    if first != 0 && groups.iter().all(|group| *group == first) {
        return None;
    }
    let mut place_of = HashMap::with_capacity(positions.len());
    let places = positions.iter().enumerate().map(|(v, p)| {
        let bits = (*p + DVec3::ZERO).to_array().map(f64::to_bits); // -0 becomes 0
        *place_of.entry(bits).or_insert(v as u32)
    });
    let places: Vec<u32> = places.collect();
    let mut edges: Vec<([u32; 2], u32, u32)> = Vec::with_capacity(corners.len()); // places, corner, group
    for (ends, group) in polygon_start.windows(2).zip(groups) {
        for c in ends[0]..ends[1] {
            let next = if c + 1 < ends[1] { c + 1 } else { ends[0] };
            let [a, b] = [c, next].map(|c| places[corners[c as usize] as usize]);
            edges.push(([a.min(b), a.max(b)], c, *group));
        }
    }
    edges.sort_unstable();
    let mut marks = vec![0; corners.len()];
    let mut some = false;
    for faces in edges.chunk_by(|a, b| a.0 == b.0).filter(|faces| faces.len() > 1) {
        let group = faces[0].2;
        let is_said = faces.iter().all(|face| face.2 != UNSAID);
        if is_said && (group == 0 || faces.iter().any(|face| face.2 != group)) {
            faces.iter().for_each(|face| marks[face.1 as usize] |= BREAK);
            some = true;
        }
    }
    some.then_some(marks)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three squares in a row; the last one has vertices of its own at its border with the second.
    fn row(groups: [u32; 3]) -> Option<Vec<u8>> {
        let at = |x: usize, y: usize| DVec3::new(x as f64, y as f64, 0.0);
        let column = |x: usize| [at(x, 0), at(x, 1)];
        let positions = [column(0), column(1), column(2), column(2), column(3)].concat();
        let corners = [0, 2, 3, 1, 2, 4, 5, 3, 6, 8, 9, 7];
        breaks(&positions, &corners, &[0, 4, 8, 12], &groups)
    }

    #[test]
    fn the_shading_breaks_where_two_groups_meet_even_at_repeated_vertices() {
        assert_eq!(row([1, 1, 2]), Some(vec![0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 2]));
        assert_eq!(row([3, 3, 3]), None);
    }

    #[test]
    fn faces_without_a_group_are_flat_and_those_before_any_statement_say_nothing() {
        assert_eq!(row([0, 0, 0]), Some(vec![0, 2, 0, 0, 0, 2, 0, 2, 0, 0, 0, 2]));
        assert_eq!(row([UNSAID, 1, 0]), Some(vec![0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 2]));
        assert_eq!(row([UNSAID; 3]), None);
    }

    #[test]
    fn a_group_is_a_number_or_off() {
        assert_eq!(
            [group(b"off"), group(b"0"), group(b"12"), group(b"x"), group(b"-1")],
            [Some(0), Some(0), Some(12), None, None]
        );
    }
}
