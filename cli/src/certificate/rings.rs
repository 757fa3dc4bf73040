//! Polygons without what has no place in the plane: corners that repeat the one before, spikes; and the rings that a polygon
//! falls into where it meets a vertex twice.

use crate::mesh::polygons::Mesh;
use std::collections::HashMap;

/// A number for the place of each corner: the same for bit-equal positions, 0 and -0 being one.
pub(super) fn places(mesh: &Mesh) -> Vec<u32> {
    let mut numbers = HashMap::with_capacity(mesh.positions.len());
    let of_vertex: Vec<u32> = mesh
        .positions
        .iter()
        .map(|p| {
            let next = numbers.len() as u32;
            *numbers.entry((*p + 0.0).to_array().map(f64::to_bits)).or_insert(next)
        })
        .collect();
    mesh.corners.iter().map(|v| of_vertex[*v as usize]).collect()
}

/// The corners of a ring of corners that are left without repeats and spikes; fewer than three: it has no face.
pub(super) fn reduced(place: &[u32], corners: impl Iterator<Item = u32>) -> Vec<u32> {
    let at = |c: &u32| place[*c as usize];
    let mut ring: Vec<u32> = Vec::new();
    for corner in corners {
        let n = ring.len();
        if n >= 1 && at(&ring[n - 1]) == at(&corner) {
            continue;
        }
        if n >= 2 && at(&ring[n - 2]) == at(&corner) {
            ring.pop();
            continue;
        }
        ring.push(corner);
    }
    // The same where the end meets the beginning.
    loop {
        match &ring[..] {
            [a, .., z] if at(a) == at(z) => drop(ring.pop()),
            [a, .., y, _] if at(a) == at(y) => ring.truncate(ring.len() - 2),
            [_, b, .., z] if at(b) == at(z) => {
                ring.pop();
                ring.remove(0);
            }
            _ => return ring,
        }
    }
}

/// The rings of a ring that meets places twice, each of which meets each of its places once.
pub(super) fn unpinched(place: &[u32], ring: Vec<u32>) -> Vec<Vec<u32>> {
    let (mut left, mut rings) = (vec![ring], Vec::new());
    while let Some(ring) = left.pop() {
        let mut seen = HashMap::new();
        let twice = ring.iter().enumerate().find_map(|(i, c)| Some((seen.insert(place[*c as usize], i)?, i)));
        match twice {
            Some((first, second)) => {
                let outer = ring[..first].iter().chain(&ring[second..]).copied();
                left.push(reduced(place, outer));
                left.push(reduced(place, ring[first..second].iter().copied()));
            }
            None if ring.len() >= 3 => rings.push(ring),
            None => {}
        }
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_and_spikes_go_and_pinched_polygons_fall_apart() {
        let of = |place: &[u32]| reduced(place, 0..place.len() as u32);
        assert_eq!(of(&[1, 1, 2, 3]), [0, 2, 3]);
        assert_eq!(of(&[1, 2, 3, 1]), [0, 1, 2]);
        assert_eq!(of(&[1, 2, 3, 4, 3]), [0, 1, 2]);
        assert_eq!(of(&[9, 1, 2, 3, 1]), [1, 2, 3]);
        assert!(of(&[1, 2, 1, 2]).len() < 3 && of(&[]).is_empty());
        let place = [1, 2, 3, 1, 4, 5];
        assert_eq!(unpinched(&place, of(&place)), [vec![0, 1, 2], vec![3, 4, 5]]);
    }
}
