//! Which vertices a seam splits: one vertex has one UV in a glTF, so corners with another one get a copy of it.
//!
//! A vertex keeps its number for the first UV that its corners have, in the order of triangles; every other UV makes a copy
//! at the end. So nothing is renumbered that has no seam. O(c).

use super::file::Surface;
use glam::DVec2;
use std::collections::HashMap;

/// Vertices after the split.
#[derive(Debug, PartialEq)]
pub(super) struct Split {
    /// The vertex that each added one is a copy of.
    pub copies: Vec<u32>, // (k)
    /// UV of each vertex, the added ones last, origin at the top left; 0 where no triangle has it.
    pub uv: Vec<[f32; 2]>, // (n + k)
    /// The triangles of each surface, where they differ from the file's.
    pub triangles: Vec<Option<Vec<[u32; 3]>>>,
}

/// Splits `vertices` vertices that `surfaces` have in common. `corner_uv` are the mesh's; one that is no number counts as
/// any other of its vertex.
pub(super) fn split(vertices: usize, surfaces: &[&Surface], corner_uv: &[DVec2]) -> Split {
    let mut first: Vec<Option<[f32; 2]>> = vec![None; vertices];
    let mut copy_of: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
    let mut made = Split { copies: Vec::new(), uv: Vec::new(), triangles: Vec::new() };
    let mut added = Vec::new();
    for surface in surfaces {
        let mut triangles = Vec::with_capacity(surface.triangles.len());
        for (t, triangle) in surface.triangles.iter().enumerate() {
            triangles.push(core::array::from_fn(|k| {
                let vertex = triangle[k];
                let uv = corner_uv[surface.corner(t, k)];
                if !uv.is_finite() {
                    return vertex;
                }
                let uv = [uv.x as f32, (1.0 - uv.y) as f32].map(|x| x + 0.0); // -0 becomes 0
                let own = first[vertex as usize].get_or_insert(uv);
                if *own == uv {
                    return vertex;
                }
                *copy_of.entry((vertex, uv.map(f32::to_bits))).or_insert_with(|| {
                    made.copies.push(vertex);
                    added.push(uv);
                    (vertices + added.len()) as u32 - 1
                })
            }));
        }
        made.triangles.push(Some(triangles).filter(|triangles| *triangles != surface.triangles));
    }
    made.uv = first.into_iter().map(Option::unwrap_or_default).chain(added).collect();
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(triangles: &[[u32; 3]], first: usize, is_mirrored: bool) -> Surface {
        Surface { users: vec![[0, 0]], triangles: triangles.to_vec(), first, is_mirrored }
    }

    #[test]
    fn only_vertices_at_a_seam_are_copied_and_copies_are_shared() {
        // Three triangles around vertex 0; the first has other UVs than the others, which agree.
        let fan = surface(&[[0, 1, 2], [0, 2, 3], [0, 3, 1]], 0, false);
        let at = |x: f64| DVec2::new(x, 1.0);
        let uv = [at(0.1), at(0.2), at(0.3), at(0.5), at(0.6), at(0.7), at(0.5), at(0.7), at(0.2)];
        let made = split(4, &[&fan], &uv);
        assert_eq!(made.copies, [0, 2]);
        assert_eq!(made.triangles, [Some(vec![[0, 1, 2], [4, 5, 3], [4, 3, 1]])]);
        assert_eq!(made.uv.iter().map(|uv| uv[0]).collect::<Vec<_>>(), [0.1, 0.2, 0.3, 0.7, 0.5, 0.6]);
        assert!(made.uv.iter().all(|uv| uv[1] == 0.0));
    }

    #[test]
    fn mirrored_surfaces_find_their_corners_and_without_seams_nothing_changes() {
        let uv = [DVec2::ZERO, DVec2::Y, DVec2::X, DVec2::NAN];
        let made = split(4, &[&surface(&[[2, 0, 1]], 0, true)], &uv);
        assert_eq!((made.copies.len(), &made.triangles[..]), (0, &[None][..]));
        assert_eq!(made.uv, [[1.0, 1.0], [0.0, 0.0], [0.0, 1.0], [0.0, 0.0]]);
    }
}
