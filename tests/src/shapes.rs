//! Small polygon meshes made by formula, each with something that an atlas must cope with.

use glam::DVec3;
use seamwright::mesh::polygons::Mesh;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// A mesh of `positions` and polygons, without UV.
pub fn mesh(positions: Vec<DVec3>, polygons: &[Vec<u32>]) -> Mesh {
    let mut out = Mesh { positions, ..Mesh::new() };
    for polygon in polygons {
        out.corners.extend(polygon);
        out.polygon_start.push(out.corners.len() as u32);
    }
    out
}

/// A unit cube of six quads.
pub fn cube() -> Mesh {
    let positions = (0..8).map(|v| DVec3::new((v & 1) as f64, (v >> 1 & 1) as f64, (v >> 2) as f64)).collect();
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    mesh(positions, &sides.map(|s| s.to_vec()))
}

/// Quads over a lattice of `columns` x `rows` cells; `vertex` names the vertex at a lattice point.
fn lattice(columns: u32, rows: u32, vertex: impl Fn(u32, u32) -> u32) -> Vec<Vec<u32>> {
    let cells = (0..rows).flat_map(|r| (0..columns).map(move |c| (c, r)));
    cells.map(|(c, r)| vec![vertex(c, r), vertex(c + 1, r), vertex(c + 1, r + 1), vertex(c, r + 1)]).collect()
}

/// A lump of 96 quads, coarse and far from flat as control meshes are; each `phase` has dents elsewhere.
pub fn lump(phase: f64) -> Mesh {
    const CELLS: u32 = 4;
    let point = |p: [u32; 3]| {
        let d = DVec3::from(p.map(|i| f64::from(2 * i) / f64::from(CELLS) - 1.0)).normalize();
        let waves = (3.0 * d.x + phase).sin() * (2.5 * d.y - phase).cos() + (4.0 * d.z + 2.0 * phase).sin();
        d * (1.0 + 0.35 * waves) * DVec3::new(1.0, 0.7, 1.4)
    };
    let (mut positions, mut seen) = (vec![], HashMap::new());
    let mut polygons = vec![];
    for (axis, level) in (0..3).flat_map(|a| [(a, 0), (a, CELLS)]) {
        let mut vertex = |a: u32, b: u32| {
            let mut p = [level; 3];
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (a, b);
            *seen.entry(p).or_insert_with(|| {
                positions.push(point(p));
                positions.len() as u32 - 1
            })
        };
        for (a, b) in (0..CELLS).flat_map(|a| (0..CELLS).map(move |b| (a, b))) {
            let mut quad = vec![vertex(a, b), vertex(a + 1, b), vertex(a + 1, b + 1), vertex(a, b + 1)];
            if level == 0 {
                quad.reverse();
            }
            polygons.push(quad);
        }
    }
    mesh(positions, &polygons)
}

/// A sphere of quads with triangles at its poles.
pub fn sphere() -> Mesh {
    let (columns, rows) = (24, 14);
    let point = |c: u32, r: u32| {
        let (a, b) = (f64::from(c) * TAU / f64::from(columns), f64::from(r + 1) * PI / f64::from(rows + 2));
        DVec3::new(b.sin() * a.cos(), b.sin() * a.sin(), -b.cos())
    };
    let mut positions: Vec<DVec3> = (0..=rows).flat_map(|r| (0..columns).map(move |c| point(c, r))).collect();
    let mut polygons = lattice(columns, rows, |c, r| r * columns + c % columns);
    let (south, north) = (positions.len() as u32, positions.len() as u32 + 1);
    positions.extend([-DVec3::Z, DVec3::Z]);
    for c in 0..columns {
        let next = (c + 1) % columns;
        polygons.push(vec![south, next, c]);
        polygons.push(vec![north, rows * columns + c, rows * columns + next]);
    }
    mesh(positions, &polygons)
}

/// A pear that is its own mirror image in the plane y = 0, along its edges, and in no other; and for each corner its mirror image.
pub fn pear() -> (Mesh, Vec<usize>) {
    let (columns, rows) = (24, 12);
    let half = columns / 2;
    let point = |c: u32, r: u32| {
        let (a, b) = (f64::from(c) * PI / f64::from(half), f64::from(r + 1) * PI / f64::from(rows + 2));
        let p = DVec3::new(b.sin() * a.cos(), b.sin() * a.sin(), -b.cos());
        p * (1.0 + 0.3 * p.z + 0.3 * p.x * p.z + 0.25 * p.x * p.y * p.y)
    };
    // One half, and behind it the other: polygon after polygon, corner after corner from the same first one round the other way.
    let side = (half + 1) * (rows + 1);
    let mut positions: Vec<DVec3> = (0..=rows).flat_map(|r| (0..=half).map(move |c| point(c, r))).collect();
    let (south, north) = (2 * side, 2 * side + 1);
    let mut polygons = lattice(half, rows, |c, r| r * (half + 1) + c);
    for c in 0..half {
        polygons.push(vec![south, c + 1, c]);
        polygons.push(vec![north, rows * (half + 1) + c, rows * (half + 1) + c + 1]);
    }
    positions.extend(positions.clone().iter().map(|p| DVec3::new(p.x, -p.y, p.z)));
    positions.extend([DVec3::Z * -0.7, DVec3::Z * 1.3]);
    let is_in_plane = |v: u32| v < side && [0, half].contains(&(v % (half + 1)));
    let image = |v: u32| if v >= side || is_in_plane(v) { v } else { v + side };
    let behind = polygons.iter().map(|p| [0].into_iter().chain((1..p.len()).rev()).map(|i| image(p[i])).collect());
    let behind: Vec<Vec<u32>> = behind.collect();
    let first: usize = polygons.iter().map(Vec::len).sum();
    let mut mirror = Vec::new();
    for p in polygons.iter().chain(&behind) {
        let at = mirror.len();
        let there = if at < first { at + first } else { at - first };
        mirror.extend((0..p.len()).map(|i| there + (p.len() - i) % p.len()));
    }
    (mesh(positions, &[polygons, behind].concat()), mirror)
}

/// A torus: one handle.
pub fn torus() -> Mesh {
    let (columns, rows) = (30, 16);
    let point = |c: u32, r: u32| {
        let (a, b) = (f64::from(c) * TAU / f64::from(columns), f64::from(r) * TAU / f64::from(rows));
        let ring = 2.0 + 0.8 * b.cos();
        DVec3::new(ring * a.cos(), ring * a.sin(), 0.8 * b.sin())
    };
    let positions = (0..rows).flat_map(|r| (0..columns).map(move |c| point(c, r))).collect();
    mesh(positions, &lattice(columns, rows, |c, r| r % rows * columns + c % columns))
}

/// A tube without caps: two border loops.
pub fn open_cylinder() -> Mesh {
    let (columns, rows) = (20, 6);
    let point = |c: u32, r: u32| {
        let a = f64::from(c) * TAU / f64::from(columns);
        DVec3::new(a.cos(), a.sin(), f64::from(r) * 0.4)
    };
    let positions = (0..=rows).flat_map(|r| (0..columns).map(move |c| point(c, r))).collect();
    mesh(positions, &lattice(columns, rows, |c, r| r * columns + c % columns))
}

/// A closed cylinder as design programs write them: each lid is fans of triangles from one corner of its rim.
pub fn cylinder_with_fans(sides: u32) -> Mesh {
    let point = |c: u32, z: f64| {
        let a = f64::from(c) * TAU / f64::from(sides);
        DVec3::new(a.cos(), a.sin(), z)
    };
    let positions = [0.0, 1.0].into_iter().flat_map(|z| (0..sides).map(move |c| point(c, z))).collect();
    let mut polygons = vec![];
    for a in 0..sides {
        let b = (a + 1) % sides;
        polygons.extend([vec![a, b, sides + b], vec![a, sides + b, sides + a]]);
    }
    for c in 1..sides - 1 {
        polygons.extend([vec![sides, sides + c, sides + c + 1], vec![0, c + 1, c]]);
    }
    mesh(positions, &polygons)
}

/// A strip with half a twist: one side, one border loop.
pub fn moebius() -> Mesh {
    let (columns, rows) = (40, 4);
    let point = |c: u32, r: u32| {
        let (a, w) = (f64::from(c) * TAU / f64::from(columns), f64::from(r) / f64::from(rows) - 0.5);
        let ring = 1.0 + w * (a / 2.0).cos();
        DVec3::new(ring * a.cos(), ring * a.sin(), w * (a / 2.0).sin())
    };
    let positions = (0..columns).flat_map(|c| (0..=rows).map(move |r| point(c, r))).collect();
    let vertex = |c: u32, r: u32| if c == columns { rows - r } else { c * (rows + 1) + r };
    mesh(positions, &lattice(columns, rows, vertex))
}

/// A Klein bottle as a figure of eight that turns by half: closed, one side, passing through itself.
pub fn klein_bottle() -> Mesh {
    let (columns, rows) = (36, 18);
    let point = |c: u32, r: u32| {
        let (a, b) = (f64::from(c) * TAU / f64::from(columns), f64::from(r) * TAU / f64::from(rows));
        let (s, t) = (b.sin(), (2.0 * b).sin());
        let ring = 2.0 + (a / 2.0).cos() * s - (a / 2.0).sin() * t;
        DVec3::new(ring * a.cos(), ring * a.sin(), (a / 2.0).sin() * s + (a / 2.0).cos() * t)
    };
    let positions = (0..columns).flat_map(|c| (0..rows).map(move |r| point(c, r))).collect();
    let vertex = |c: u32, r: u32| if c == columns { (rows - r) % rows } else { c * rows + r % rows };
    mesh(positions, &lattice(columns, rows, vertex))
}

/// Five pages of two quads around one spine: its edges have five faces.
pub fn book() -> Mesh {
    let mut positions = vec![DVec3::ZERO, DVec3::Z, DVec3::Z * 2.0];
    let mut polygons = vec![];
    for page in 0..5 {
        let a = f64::from(page) * TAU / 5.0;
        let (out, first) = (DVec3::new(a.cos(), a.sin(), 0.0), positions.len() as u32);
        positions.extend([0.0, 1.0, 2.0].map(|z| out + DVec3::Z * z));
        polygons.extend([vec![0, first, first + 1, 1], vec![1, first + 1, first + 2, 2]]);
    }
    mesh(positions, &polygons)
}

/// One flat polygon of `corners` corners.
pub fn disc(corners: u32) -> Mesh {
    let turn = |c: u32| f64::from(c) * TAU / f64::from(corners);
    let positions = (0..corners).map(|c| DVec3::new(turn(c).cos(), turn(c).sin(), 0.0)).collect();
    mesh(positions, &[(0..corners).collect()])
}

/// A cube and a torus away from each other.
pub fn two_components() -> Mesh {
    let (mut all, other) = (torus(), cube());
    let first = all.positions.len() as u32;
    all.positions.extend(other.positions.iter().map(|p| *p + DVec3::X * 5.0));
    let start = all.corners.len() as u32;
    all.corners.extend(other.corners.iter().map(|v| v + first));
    all.polygon_start.extend(other.polygon_start[1..].iter().map(|s| s + start));
    all
}

/// A prism over an L: its caps are concave hexagons whose first corner sees only part of them, its sides quads.
pub fn concave_prism() -> Mesh {
    let outline = [(3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0), (0.0, 0.0)];
    let level = |z: f64| outline.map(|(x, y)| DVec3::new(x, y, z));
    let mut polygons = vec![vec![5, 4, 3, 2, 1, 0], vec![6, 7, 8, 9, 10, 11]];
    polygons.extend((0..6).map(|c| vec![c, (c + 1) % 6, (c + 1) % 6 + 6, c + 6]));
    mesh([level(0.0), level(1.0)].concat(), &polygons)
}

/// A floor of 4 x 4 squares with two pits that touch along an edge: that edge has four faces, and the floor two holes that meet in a point.
pub fn pits_that_touch() -> Mesh {
    let at = |x: u32, y: u32, z: u32| z * 25 + y * 5 + x;
    let positions = (0..50).map(|v| DVec3::new(f64::from(v % 5), f64::from(v / 5 % 5), -2.0 * f64::from(v / 25)));
    let mut polygons = vec![];
    for (x, y) in (0..16).map(|s| (s % 4, s / 4)) {
        let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
        let is_pit = x == y && (x == 1 || x == 2);
        polygons.push(corners.map(|(x, y)| at(x, y, u32::from(is_pit))).to_vec());
        if is_pit {
            let sides = (0..4).map(|k| (corners[k], corners[(k + 1) % 4]));
            polygons
                .extend(sides.map(|(a, b)| vec![at(a.0, a.1, 0), at(b.0, b.1, 0), at(b.0, b.1, 1), at(a.0, a.1, 1)]));
        }
    }
    mesh(positions.collect(), &polygons)
}
