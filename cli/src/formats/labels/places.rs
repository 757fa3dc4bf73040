//! Which face of a segmented mesh lies where each face of the user's mesh lies.
//!
//! Tools merge, split and reorder vertices and faces, and cut polygons into triangles. Vertices within a tolerance are one
//! place; a face is the set of its places. Where the indices of both meshes are the same, faces go by their order, wherever
//! the vertices are. A polygon that the other mesh holds as triangles is found by one of its ears: any triangulation has two.
//! Limit: a mesh that was moved or scaled is matched by order alone.

use crate::mesh::polygons::Mesh;
use glam::DVec3;
use std::collections::HashMap;

/// Vertices are one place within this share of the box's diagonal: files of six digits are off by up to 5e-7 of the largest
/// coordinate; 1e-5 would join the vertices of meshes of some million faces.
const TOLERANCE: f64 = 2e-6;

/// The face of `other` for each polygon of `mesh`, or how many polygons have none.
pub fn matching(mesh: &Mesh, other: &Mesh) -> Result<Vec<u32>, usize> {
    if mesh.polygon_start == other.polygon_start && mesh.corners == other.corners {
        return Ok((0..mesh.polygon_count() as u32).collect());
    }
    let mut places = Places::new(&mesh.positions);
    let ours: Vec<u32> = mesh.positions.iter().map(|p| places.of(*p)).collect();
    let theirs: Vec<u32> = other.positions.iter().map(|p| places.of(*p)).collect();
    let mut faces: HashMap<Vec<u32>, u32> = HashMap::with_capacity(other.polygon_count());
    for (f, corners) in other.polygons().enumerate() {
        faces.entry(set(other.corners[corners].iter().map(|v| theirs[*v as usize]))).or_insert(f as u32);
    }
    let find = |p: usize| {
        let corners: Vec<u32> = mesh.corners[mesh.polygon(p)].iter().map(|v| ours[*v as usize]).collect();
        let n = corners.len();
        // Faces in one order are taken so: of faces on top of each other, each keeps its own.
        let own = p < other.polygon_count() && {
            set(other.corners[other.polygon(p)].iter().map(|v| theirs[*v as usize])) == set(corners.iter().copied())
        };
        if own {
            return Some(p as u32);
        }
        let ear = |i: usize| set([corners[(i + n - 1) % n], corners[i], corners[(i + 1) % n]].into_iter());
        let whole = faces.get(&set(corners.iter().copied()));
        whole.or_else(|| (0..n).filter(|_| n > 3).find_map(|i| faces.get(&ear(i)))).copied()
    };
    let found: Vec<Option<u32>> = (0..mesh.polygon_count()).map(find).collect();
    match found.iter().filter(|f| f.is_none()).count() {
        0 => Ok(found.into_iter().flatten().collect()),
        missing => Err(missing),
    }
}

fn set(places: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut all: Vec<u32> = places.collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Points that are one within a tolerance; each place is its first point.
struct Places {
    tolerance: f64,
    cells: HashMap<[i64; 3], Vec<(DVec3, u32)>>,
    count: u32,
}

impl Places {
    fn new(positions: &[DVec3]) -> Self {
        let low = positions.iter().fold(DVec3::INFINITY, |a, p| a.min(*p));
        let high = positions.iter().fold(DVec3::NEG_INFINITY, |a, p| a.max(*p));
        let far = positions.iter().fold(0.0, |far, p| f64::max(far, p.abs().max_element()));
        // Floats far from the origin are coarser than the tolerance.
        let tolerance = (TOLERANCE * (high - low).length()).max(4.0 * f64::from(f32::EPSILON) * far);
        Self { tolerance: if tolerance > 0.0 { tolerance } else { 1.0 }, cells: HashMap::new(), count: 0 }
    }

    fn of(&mut self, p: DVec3) -> u32 {
        let cell = |p: DVec3| (p / (8.0 * self.tolerance)).floor().to_array().map(|x| x as i64);
        let (low, high) = (cell(p - self.tolerance), cell(p + self.tolerance));
        let mut near: Option<(f64, u32)> = None;
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    for (q, place) in self.cells.get(&[x, y, z]).into_iter().flatten() {
                        let distance = p.distance(*q);
                        if distance <= self.tolerance && near.is_none_or(|(d, n)| (distance, *place) < (d, n)) {
                            near = Some((distance, *place));
                        }
                    }
                }
            }
        }
        if let Some((_, place)) = near {
            return place;
        }
        let own = cell(p);
        self.cells.entry(own).or_default().push((p, self.count));
        self.count += 1;
        self.count - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two quads side by side.
    fn quads() -> Mesh {
        let positions = (0..6).map(|i| DVec3::new((i % 3) as f64, (i / 3) as f64, 0.0)).collect();
        Mesh { positions, corners: vec![0, 1, 4, 3, 1, 2, 5, 4], polygon_start: vec![0, 4, 8], ..Mesh::default() }
    }

    fn soup(faces: &[&[[f64; 2]]]) -> Mesh {
        let mut mesh = Mesh::new();
        for face in faces {
            for [x, y] in *face {
                mesh.corners.push(mesh.positions.len() as u32);
                mesh.positions.push(DVec3::new(*x, *y, 0.0));
            }
            mesh.polygon_start.push(mesh.corners.len() as u32);
        }
        mesh
    }

    #[test]
    fn the_same_indices_go_by_order_wherever_the_vertices_are() {
        let mut moved = quads();
        moved.positions.iter_mut().for_each(|p| *p = *p * 0.01 + 7.0);
        assert_eq!(matching(&quads(), &moved), Ok(vec![0, 1]));
    }

    #[test]
    fn reordered_and_split_faces_are_found_by_place() {
        let (a, b) =
            ([[1.0, 1.0 + 1e-6], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]]);
        assert_eq!(matching(&quads(), &soup(&[&b, &a])), Ok(vec![1, 0]));
    }

    #[test]
    fn polygons_cut_into_triangles_are_found_by_an_ear() {
        let other = soup(&[
            &[[1.0, 0.0], [2.0, 0.0], [1.0, 1.0]],
            &[[2.0, 0.0], [2.0, 1.0], [1.0, 1.0]],
            &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            &[[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        ]);
        let found = matching(&quads(), &other).unwrap();
        assert!([2, 3].contains(&found[0]) && [0, 1].contains(&found[1]), "{found:?}");
    }

    #[test]
    fn faces_without_a_face_at_their_place_are_counted() {
        let far = [[9.0, 0.0], [8.0, 0.0], [8.0, 1.0], [9.0, 1.0]];
        let near = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];
        assert_eq!(matching(&quads(), &soup(&[&far, &near])), Err(1));
        assert_eq!(matching(&quads(), &Mesh::new()), Err(2));
        assert_eq!(matching(&Mesh::new(), &Mesh::new()), Ok(vec![]));
    }
}
