//! Random closed solids of few faces: tetrahedra, bipyramids, hulls of up to twelve points; every third drawn out to slivers.
//!
//! Coordinates are integers, drawn by the project's hash from the solid's number, so that hulls are exact; slivers have
//! two axes scaled by powers of ten.

use super::hull::hull;
use super::{Solid, Topology};
use glam::{DVec3, I64Vec3};
use seamwright::mesh::polygons::Mesh;
use seamwright_core::base::random::hash;
use seamwright_core::base::real;
use std::f64::consts::TAU;

/// Solids of each kind: a thousand in all.
const COUNTS: [(&str, u64); 3] = [("tetrahedron", 400), ("bipyramid", 250), ("hull", 350)];
/// Steps along each axis of the lattice.
const SIDE: i64 = 1 << 12;
/// Scales of a sliver's second and third axis.
const SLIVERS: [[f64; 2]; 6] = [[1.0, 0.1], [1.0, 0.01], [1.0, 0.001], [0.1, 0.1], [0.01, 0.01], [0.1, 0.001]];

/// Draws of one solid.
struct Draw {
    stream: u64,
    drawn: u64,
}

impl Draw {
    fn below(&mut self, n: i64) -> i64 {
        self.drawn += 1;
        (hash(1_018, self.stream, self.drawn) % n as u64) as i64
    }

    fn point(&mut self) -> I64Vec3 {
        let [x, y, z] = [0; 3].map(|_| self.below(SIDE));
        I64Vec3::new(x, y, z)
    }
}

/// Adds all of them.
pub fn family(out: &mut Vec<Solid>) {
    for (kind, (what, count)) in COUNTS.into_iter().enumerate() {
        for i in 0..count {
            let sliver = (i % 3 == 2).then(|| SLIVERS[(i / 3) as usize % SLIVERS.len()]);
            let ending = sliver.map_or(String::new(), |[y, z]| format!("_sliver_{y}_{z}"));
            let stream = kind as u64 * 100_000 + i;
            let make = move || {
                let mut draw = Draw { stream, drawn: 0 };
                let mut mesh = if kind == 1 { bipyramid(&mut draw) } else { drawn_hull(&mut draw, kind == 0) };
                let [y, z] = sliver.unwrap_or([1.0; 2]);
                mesh.positions.iter_mut().for_each(|p| *p *= DVec3::new(1.0, y, z));
                mesh
            };
            out.push(Solid::new(format!("{what}_{i:04}{ending}"), Topology::sphere_with(0), make));
        }
    }
}

/// The hull of four points or of 5 to 12, drawn again until it has a volume.
fn drawn_hull(draw: &mut Draw, is_tetrahedron: bool) -> Mesh {
    loop {
        let count = if is_tetrahedron { 4 } else { 5 + draw.below(8) };
        let points: Vec<I64Vec3> = (0..count).map(|_| draw.point()).collect();
        if let Some(faces) = hull(&points) {
            return of_used(&points, &faces);
        }
    }
}

/// A mesh of the points that a face names.
fn of_used(points: &[I64Vec3], faces: &[[u32; 3]]) -> Mesh {
    let mut used: Vec<u32> = faces.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let place = |v: &u32| used.binary_search(v).expect("a vertex of a face") as u32;
    let polygons: Vec<Vec<u32>> = faces.iter().map(|f| f.iter().map(place).collect()).collect();
    crate::shapes::mesh(used.iter().map(|v| points[*v as usize].as_dvec3()).collect(), &polygons)
}

/// Two apexes over a ring of 3 to 12 vertices of any distance from the axis; not always convex.
fn bipyramid(draw: &mut Draw) -> Mesh {
    let n = 3 + draw.below(10);
    let apexes = [draw.below(SIDE) + 1, -draw.below(SIDE) - 1];
    let mut positions: Vec<DVec3> = (0..n)
        .map(|i| {
            let radius = (SIDE / 4 + draw.below(SIDE)) as f64;
            let angle = i as f64 / n as f64 * TAU;
            DVec3::new(real::round(real::cos(angle) * radius), real::round(real::sin(angle) * radius), 0.0)
        })
        .collect();
    positions.extend(apexes.map(|z| DVec3::Z * z as f64));
    let n = n as u32;
    let polygons: Vec<Vec<u32>> =
        (0..n).map(|i| (i, (i + 1) % n)).flat_map(|(i, j)| [vec![i, j, n], vec![j, i, n + 1]]).collect();
    crate::shapes::mesh(positions, &polygons)
}
