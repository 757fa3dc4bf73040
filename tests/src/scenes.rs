//! Scenes of several bodies, each under a rigid motion of its own, written as a converter would: vertices and polygons in any
//! order, coordinates with so many digits.

use crate::fixtures::obj::{face_line, vertex_line};
use glam::{DMat3, DQuat, DVec3};
use seamwright::mesh::polygons::Mesh;
use seamwright_core::base::random::{hash, unit_f64};
use seamwright_core::base::real::{cos, ln, sin, sqrt};
use std::f64::consts::TAU;

/// A body of a scene.
#[derive(Clone, Copy)]
pub struct Placed<'m> {
    /// Its shape.
    pub mesh: &'m Mesh,
    /// Whether it is the mirror image of that.
    pub mirrored: bool,
}

/// Bodies side by side.
pub struct Scene {
    /// All of them.
    pub mesh: Mesh,
    /// Corner of the scene that each corner of each body has become.
    pub corner_of: Vec<Vec<usize>>, // (bodies) (corners of the body)
    /// Polygon of the scene that each polygon of each body has become.
    pub polygon_of: Vec<Vec<usize>>,
}

impl Scene {
    /// The text of an OBJ file, with six digits.
    pub fn obj(&self) -> String {
        let mut text = String::from("# seamwright scene\n");
        self.mesh.positions.iter().for_each(|p| vertex_line(&mut text, *p, 6));
        self.mesh.polygons().for_each(|at| face_line(&mut text, &self.mesh.corners[at]));
        text
    }
}

/// Puts the bodies on a lattice wide enough for all, turned by chance; `decimals` digits are kept behind the point, if given.
pub fn scattered(bodies: &[Placed], seed: u64, decimals: Option<i32>) -> Scene {
    let mut scene = Scene { mesh: Mesh::new(), corner_of: vec![], polygon_of: vec![] };
    let reach = |mesh: &Mesh| mesh.positions.iter().map(|p| p.length()).fold(0.0, f64::max);
    let room = bodies.iter().map(|b| reach(b.mesh)).fold(0.0, f64::max) * 2.5;
    let columns = (bodies.len() as f64).sqrt().ceil() as usize;
    let digit = decimals.map(|n| 10f64.powi(n));
    scene.mesh.tolerance = digit.map_or(0.0, |d| 0.5 / d);
    for (k, Placed { mesh, mirrored }) in bodies.iter().enumerate() {
        let turn = turn(seed, k as u64);
        let side = if *mirrored { DVec3::new(-1.0, 1.0, 1.0) } else { DVec3::ONE };
        let at = DVec3::new((k % columns) as f64, (k / columns) as f64, unit_f64(seed, 90, k as u64)) * room;
        let first = scene.mesh.positions.len() as u32;
        let order = shuffled(mesh.positions.len(), hash(seed, 91, k as u64));
        let mut place = vec![0; order.len()];
        for (i, v) in order.iter().enumerate() {
            place[*v] = first + i as u32;
            let p = turn * (mesh.positions[*v] * side) + at;
            scene.mesh.positions.push(digit.map_or(p, |d| (p * d).round() / d));
        }
        let (mut corner_of, mut polygon_of) = (vec![0; mesh.corners.len()], vec![0; mesh.polygon_count()]);
        for p in shuffled(mesh.polygon_count(), hash(seed, 92, k as u64)) {
            polygon_of[p] = scene.mesh.polygon_count();
            let mut corners: Vec<usize> = mesh.polygon(p).collect();
            if *mirrored {
                corners[1..].reverse(); // the diagonals of a fan stay
            }
            for c in corners {
                corner_of[c] = scene.mesh.corners.len();
                scene.mesh.corners.push(place[mesh.corners[c] as usize]);
            }
            scene.mesh.polygon_start.push(scene.mesh.corners.len() as u32);
        }
        scene.corner_of.push(corner_of);
        scene.polygon_of.push(polygon_of);
    }
    scene
}

/// A rotation by chance.
fn turn(seed: u64, k: u64) -> DMat3 {
    let normal = |i: u64| {
        let (u, v) = (unit_f64(seed, 2 * i, k), unit_f64(seed, 2 * i + 1, k));
        sqrt(-2.0 * ln(1.0 - u)) * cos(TAU * v) + 1e-9 * sin(v)
    };
    DMat3::from_quat(DQuat::from_xyzw(normal(1), normal(2), normal(3), normal(4)).normalize())
}

/// 0..count in an order by chance.
fn shuffled(count: usize, key: u64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|i| (hash(key, 93, *i as u64), *i));
    order
}
