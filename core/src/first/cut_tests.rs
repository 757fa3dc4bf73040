//! First cuts on small closed surfaces.

use super::disks::cut_to_disks;
use crate::base::real::{cos, sin};
use crate::base::scratch::Scratch;
use crate::charts::surface::Surface;
use crate::mesh::topology::twins;
use crate::mesh::view::MeshView;
use crate::solve::energy::Rest;
use core::f64::consts::TAU;
use glam::DVec3;
use std::{assert, format, vec, vec::Vec};

/// Two apexes over a ring of `sides` vertices.
fn bipyramid(sides: u32, apex: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let turn = |i: u32| f64::from(i) * TAU / f64::from(sides);
    let mut positions: Vec<DVec3> = (0..sides).map(|i| DVec3::new(cos(turn(i)), sin(turn(i)), 0.0)).collect();
    positions.extend([DVec3::Z * apex, DVec3::Z * -apex]);
    let beside = |i: u32| (i + 1) % sides;
    let faces = (0..sides).flat_map(|i| [[i, beside(i), sides], [beside(i), i, sides + 1]]).collect();
    (positions, faces)
}

/// A prism whose lids are fans from one corner.
fn prism(sides: u32, height: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let turn = |i: u32| f64::from(i) * TAU / f64::from(sides);
    let rim = |z: f64| (0..sides).map(move |i| DVec3::new(cos(turn(i)), sin(turn(i)), z));
    let mut faces = Vec::new();
    for a in 0..sides {
        let b = (a + 1) % sides;
        faces.extend([[a, b, sides + b], [a, sides + b, sides + a]]);
    }
    faces.extend((1..sides - 1).flat_map(|i| [[sides, sides + i, sides + i + 1], [0, i + 1, i]]));
    (rim(0.0).chain(rim(height)).collect(), faces)
}

/// Edges that [`cut_to_disks`] cuts, all at a cost of their length.
fn cuts(positions: &[DVec3], faces: &[[u32; 3]]) -> usize {
    let mesh = MeshView { positions, faces };
    let mut bytes = vec![0; 1 << 20];
    let mut scratch = Scratch::new(&mut bytes);
    let mut twin = vec![0; mesh.corner_count()];
    twins(&mut twin, mesh, scratch.frame()).expect("enough memory");
    let rest: Vec<Rest> = faces.iter().map(|f| Rest::new(f.map(|v| positions[v as usize]), 0.0)).collect();
    let bare = Surface { mesh, twin: &twin, rest: &rest, cost: &[], start: &[], corners: &[], stays_whole: false };
    let cost: Vec<f64> = (0..mesh.corner_count() as u32).map(|c| bare.length(c)).collect();
    let surface = Surface::new(mesh, &twin, &rest, &cost, &mut scratch).expect("enough memory");
    let mut cut = vec![0; mesh.corner_count()];
    cut_to_disks(&mut cut, &surface, scratch).expect("enough memory");
    cut.iter().filter(|c| **c != 0).count() / 2
}

/// With one tip there is no path between tips, no cut, and so no border to lay on a circle.
#[test]
fn a_closed_surface_has_two_tips_at_least() {
    let mut uncut = vec![];
    for sides in [3, 4, 5, 6, 8, 12, 20, 33, 64, 200] {
        for size in [0.01, 0.1, 0.5, 1.0, 2.0, 10.0, 100.0] {
            for (name, (positions, faces)) in [("bipyramid", bipyramid(sides, size)), ("prism", prism(sides, size))] {
                if cuts(&positions, &faces) == 0 {
                    uncut.push(format!("{name} of {sides} sides, {size} high"));
                }
            }
        }
    }
    assert!(uncut.is_empty(), "not cut: {uncut:?}");
}
