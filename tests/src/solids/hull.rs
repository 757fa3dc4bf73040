//! Convex hull of a few points on an integer lattice, decided exactly.
//!
//! Incremental: each point outside of the hull so far takes the place of the faces that it sees, with triangles over the
//! edge of what it sees. A face whose plane holds the point is not seen, so that no triangle is without area; a flat side
//! of more corners comes out as triangles in one plane. Determinants are integers: coordinates up to 2^19 keep them within
//! 64 bits. Cost: O(n^2).

use glam::I64Vec3;

/// Six times the signed volume of the tetrahedron; above zero where `d` is behind `abc`, seen counter-clockwise.
fn volume(a: I64Vec3, b: I64Vec3, c: I64Vec3, d: I64Vec3) -> i64 {
    (b - a).cross(c - a).dot(a - d)
}

/// Triangles of the hull, counter-clockwise from outside, or `None` where all points lie in one plane.
pub fn hull(points: &[I64Vec3]) -> Option<Vec<[u32; 3]>> {
    let at = |v: u32| points[v as usize];
    let all = || 0..points.len() as u32;
    let mut faces = first(points)?;
    for v in all() {
        let sees = |f: &[u32; 3]| volume(at(f[0]), at(f[1]), at(f[2]), at(v)) < 0;
        let (seen, kept): (Vec<_>, Vec<_>) = faces.iter().partition(|f| sees(f));
        let sides = |f: &[u32; 3]| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]];
        let inner: Vec<[u32; 2]> = seen.iter().flat_map(sides).collect();
        let rim = inner.iter().filter(|[a, b]| !inner.contains(&[*b, *a]));
        faces = kept.into_iter().chain(rim.map(|[a, b]| [*a, *b, v])).collect();
    }
    Some(faces)
}

/// The tetrahedron of the first four points that are not in one plane.
fn first(points: &[I64Vec3]) -> Option<Vec<[u32; 3]>> {
    let find = |wanted: &dyn Fn(I64Vec3) -> bool| points.iter().position(|p| wanted(*p)).map(|v| v as u32);
    let a = *points.first()?;
    let second = find(&|p| p != a)?;
    let b = points[second as usize];
    let third = find(&|p| (b - a).cross(p - a) != I64Vec3::ZERO)?;
    let c = points[third as usize];
    let fourth = find(&|p| volume(a, b, c, p) != 0)?;
    let [a, b, c, d] = if volume(a, b, c, points[fourth as usize]) > 0 {
        [0, second, third, fourth]
    } else {
        [0, third, second, fourth]
    };
    Some(vec![[a, b, c], [b, a, d], [c, b, d], [a, c, d]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use seamwright_core::base::random::hash;

    fn points(count: u64, side: u64, seed: u64) -> Vec<I64Vec3> {
        let draw = |i: u64, k: u64| (hash(seed, k, i) % side) as i64;
        (0..count).map(|i| I64Vec3::new(draw(i, 0), draw(i, 1), draw(i, 2))).collect()
    }

    #[test]
    fn a_cube_with_points_inside_and_on_its_sides_has_twelve_triangles() {
        let mut cube: Vec<I64Vec3> = (0..8).map(|k| I64Vec3::new(k & 1, k >> 1 & 1, k >> 2) * 4).collect();
        cube.extend([I64Vec3::splat(2), I64Vec3::new(1, 2, 3)]);
        assert_eq!(hull(&cube).expect("a solid").len(), 12);
    }

    #[test]
    fn points_in_a_plane_have_no_hull() {
        let flat: Vec<I64Vec3> = (0..9).map(|k| I64Vec3::new(k % 3, k / 3, k % 3 + k / 3)).collect();
        assert_eq!(hull(&flat), None);
        assert_eq!(hull(&[I64Vec3::ONE; 5]), None);
        assert_eq!(hull(&[]), None);
    }

    /// Small lattices, so that points fall together, in lines and in planes.
    #[test]
    fn no_point_lies_outside_of_its_hull_and_every_edge_has_two_sides() {
        for seed in 0..400 {
            let points = points(4 + seed % 12, [3, 5, 1 << 12, 1 << 19][seed as usize % 4], seed);
            let Some(faces) = hull(&points) else { continue };
            let at = |v: u32| points[v as usize];
            for [a, b, c] in &faces {
                let [p, q, r] = [*a, *b, *c].map(at);
                assert_ne!((q - p).cross(r - p), I64Vec3::ZERO, "seed {seed}: a triangle without area");
                assert!(points.iter().all(|d| volume(p, q, r, *d) >= 0), "seed {seed}: a point outside");
            }
            let sides: Vec<[u32; 2]> = faces.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]).collect();
            for [a, b] in &sides {
                let count = |side: [u32; 2]| sides.iter().filter(|s| **s == side).count();
                assert_eq!((count([*a, *b]), count([*b, *a])), (1, 1), "seed {seed}");
            }
        }
    }
}
