//! Copies among small bodies.

use super::congruence::Likeness;
use super::copies::{Copies, Who, copies_need};
use super::pieces::{Pieces, pieces_need};
use crate::base::scratch::Scratch;
use crate::mesh::topology::{twins, twins_need};
use crate::mesh::view::MeshView;
use glam::{DQuat, DVec2, DVec3};
use std::{vec, vec::Vec};

/// A body of no symmetry: a tetrahedron with a tip on one side.
fn body() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let points = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.2, 0.8, 0.0), (0.3, 0.3, 0.7), (1.0, 0.6, 0.6)];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 4], [2, 3, 4], [3, 1, 4]];
    (points.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec(), faces.to_vec())
}

/// Bodies one after the other, each moved by its own map; those that are mirrored are turned inside out.
fn scene(motions: &[&dyn Fn(DVec3) -> DVec3], mirrored: &[bool]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for (motion, mirrored) in motions.iter().zip(mirrored) {
        let (points, triangles) = body();
        let first = positions.len() as u32;
        positions.extend(points.iter().map(|p| motion(*p)));
        // Each body names its faces from another corner and in another order.
        let turn = faces.len() % 3;
        let face = |f: [u32; 3]| {
            let f = [0, 1, 2].map(|i| f[(i + turn) % 3] + first);
            if *mirrored { [f[0], f[2], f[1]] } else { f }
        };
        faces.extend(triangles.into_iter().rev().map(face));
    }
    (positions, faces)
}

fn moved(k: u32) -> impl Fn(DVec3) -> DVec3 {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), f64::from(k));
    move |p| turn * p + DVec3::X * 5.0 * f64::from(k)
}

fn mirror(p: DVec3) -> DVec3 {
    DVec3::new(p.x, -p.y, p.z)
}

/// Finds copies and hands them over.
fn with<T>(
    (positions, faces): (Vec<DVec3>, Vec<[u32; 3]>),
    kept: &[u8],
    mirrored: bool,
    then: impl FnOnce(&Pieces, &Copies) -> T,
) -> T {
    let mesh = MeshView { positions: &positions, faces: &faces };
    let corners = mesh.corner_count();
    let mut twin = vec![0; corners];
    let mut bytes = vec![0; twins_need(faces.len())];
    twins(&mut twin, mesh, Scratch::new(&mut bytes)).unwrap();
    let cost: Vec<f64> = (0..corners).map(|c| (c.min(twin[c] as usize)) as f64).collect();
    let mut bytes = vec![0; pieces_need(faces.len())];
    let pieces = Pieces::new(mesh, &twin, &vec![0; corners], &cost, &mut Scratch::new(&mut bytes)).unwrap();
    let mut bytes = vec![0; copies_need(faces.len())];
    let copies = Copies::find(
        &pieces,
        Who { kept, stacked: None },
        Likeness { mirrored, ..Likeness::exact(1e-9) },
        &[],
        &mut Scratch::new(&mut bytes),
    )
    .unwrap();
    then(&pieces, &copies)
}

#[test]
fn what_is_moved_is_a_copy_and_what_is_mirrored_is_one_where_that_is_asked_for() {
    let (a, b, c) = (moved(1), moved(2), moved(3));
    let flip = |p| c(mirror(p));
    let bodies = || scene(&[&a, &flip, &b, &flip], &[false, true, false, true]);
    let originals = |kept: &[u8], mirrored| with(bodies(), kept, mirrored, |_, c| [0, 1, 2, 3].map(|p| c.original(p)));
    assert_eq!(originals(&[], false), [0, 1, 0, 1]);
    assert_eq!(originals(&[], true), [0, 0, 0, 0]);
    assert_eq!(originals(&[1, 0, 0, 0], true), [0, 1, 1, 1], "what is kept stands for itself");
    with(bodies(), &[], true, |_, c| assert_eq!([0, 1, 2, 3].map(|p| c.is_mirrored(p)), [false, true, false, true]));
    with(bodies(), &[1, 0, 0, 0], true, |_, c| assert_eq!([1, 2, 3].map(|p| c.is_mirrored(p)), [false, true, false]));
}

#[test]
fn what_is_bent_scaled_or_dented_is_no_copy() {
    let a = moved(1);
    let dent = |p: DVec3| if p == DVec3::new(0.3, 0.3, 0.7) { p - DVec3::Z * 1e-4 } else { p };
    for other in [&(|p| p * 1.0001) as &dyn Fn(DVec3) -> DVec3, &|p| p * DVec3::new(1.0, 1.0, 0.9999), &dent] {
        with(scene(&[&a, other], &[false; 2]), &[], true, |_, c| assert!(!c.are_any()));
    }
    with(scene(&[&a], &[false]), &[], true, |_, c| assert!(!c.are_any()));
}

#[test]
fn corners_lie_on_those_of_the_same_place_and_half_edges_on_theirs() {
    let (a, b) = (moved(1), moved(2));
    let flip = |p| b(mirror(p));
    let bodies = scene(&[&a, &b, &flip], &[false, false, true]);
    with(bodies, &[], true, |pieces, copies| {
        for p in 0..3 {
            let (own, first) = (pieces.bare_surface(p), pieces.bare_surface(0));
            let at = |s: usize, first: usize| (s - first) as u32;
            for slot in pieces.corners(p) {
                let (c, d) = (at(slot, pieces.corners(p).start), copies.image(p, slot, pieces) as u32);
                let place = |p: DVec3, k: usize| [a(p), b(p), flip(p)][k];
                let near = |points: &[DVec3], p: DVec3| points.iter().position(|q| place(*q, 0).distance(p) < 1e-9);
                let source = near(&body().0, first.mesh.position(d)).unwrap();
                assert!(place(body().0[source], p).distance(own.mesh.position(c)) < 1e-9);
                let side = copies.half_edge(p, slot, pieces) as u32;
                assert!((first.length(side) - own.length(c)).abs() < 1e-9);
            }
        }
    });
}

#[test]
fn costs_are_means_and_maps_those_of_the_original() {
    let (a, b) = (moved(1), moved(2));
    let flip = |p| b(mirror(p));
    with(scene(&[&a, &b, &flip], &[false, false, true]), &[], true, |pieces, copies| {
        let corners = pieces.source.len();
        let mut cost = pieces.cost().to_vec();
        let mut bytes = vec![0; 1 << 10];
        copies.share_cost(&mut cost, pieces, Scratch::new(&mut bytes), |sum, n| sum / n).unwrap();
        let total = |cost: &[f64]| cost.iter().sum::<f64>();
        assert!((total(&cost) - total(pieces.cost())).abs() < 1e-9);
        for p in 0..3 {
            let surface = pieces.bare_surface(p);
            let first = pieces.corners(p).start;
            for slot in pieces.corners(p) {
                assert_eq!(cost[slot], cost[copies.half_edge(p, slot, pieces)]);
                assert_eq!(cost[slot], cost[first + surface.twin[slot - first] as usize], "equal for twins");
            }
        }
        let mut uv: Vec<DVec2> = (0..corners).map(|c| DVec2::new(c as f64, 1.0)).collect();
        let mut cut: Vec<u8> = (0..corners).map(|c| u8::from(c % 5 == 0)).collect();
        copies.spread(&mut uv, &mut cut, pieces);
        for p in 1..3 {
            for slot in pieces.corners(p) {
                let side = if p == 2 { -1.0 } else { 1.0 };
                assert_eq!(uv[slot], DVec2::new(side * copies.image(p, slot, pieces) as f64, 1.0));
            }
        }
        assert_eq!(copies.counts(3, &mut Scratch::new(&mut bytes)).unwrap(), [3, 0, 0]);
    });
}

#[test]
fn short_memory_is_an_error() {
    let (a, b) = (moved(1), moved(2));
    with(scene(&[&a, &b], &[false; 2]), &[], false, |pieces, _| {
        for bytes in [0, 16, 100, 250] {
            let found = Copies::find(
                pieces,
                Who { kept: &[], stacked: None },
                Likeness::exact(0.0),
                &[],
                &mut Scratch::new(&mut vec![0; bytes]),
            )
            .map(|_| ());
            assert!(found.is_err(), "{bytes}");
        }
    });
}
