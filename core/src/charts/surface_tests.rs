//! Surfaces for tests, made of a list of faces; borders and slits of one with a hole.

use super::surface::Surface;
use crate::base::scratch::Scratch;
use crate::mesh::topology::twins;
use crate::mesh::view::{MeshView, NONE};
use crate::solve::energy::Rest;
use glam::{DVec2, DVec3};
use std::{assert, assert_eq, vec, vec::Vec};

/// Calls `then` with the surface of these faces, whose half-edges cost what `cost` says, and a megabyte of memory.
pub fn on_surface<T>(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    cost: impl Fn(MeshView, u32) -> f64,
    then: impl FnOnce(&Surface, Scratch) -> T,
) -> T {
    let mesh = MeshView { positions, faces };
    let (mut memory, mut twin) = (vec![0; 1 << 20], vec![0; mesh.corner_count()]);
    let mut keep = Scratch::new(&mut memory);
    twins(&mut twin, mesh, keep.frame()).expect("enough memory");
    let rest: Vec<Rest> = faces.iter().map(|f| Rest::new(f.map(|v| positions[v as usize]), 0.0)).collect();
    let cost: Vec<f64> = (0..twin.len() as u32).map(|c| cost(mesh, c)).collect();
    let surface = Surface::new(mesh, &twin, &rest, &cost, &mut keep).expect("enough memory");
    then(&surface, keep)
}

/// A flat square ring of eight faces, laid down as it is; the inner square is half as wide.
fn on_ring<T>(then: impl Fn(&Surface, Vec<DVec2>) -> T) -> T {
    let square = |r: f64| [(r, r), (-r, r), (-r, -r), (r, -r)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let positions = [square(2.0), square(1.0)].concat();
    let cells = (0..4).map(|i| (i, (i + 1) % 4));
    // The inner border has the first corner of all.
    let faces: Vec<[u32; 3]> = cells.flat_map(|(i, j)| [[j + 4, i + 4, i], [j + 4, i, j]]).collect();
    on_surface(
        &positions,
        &faces,
        |_, _| 1.0,
        |surface, _| {
            let uv = (0..surface.twin.len() as u32).map(|c| surface.mesh.position(c).truncate()).collect();
            then(surface, uv)
        },
    )
}

#[test]
fn the_outer_border_is_the_one_that_holds_the_hole() {
    on_ring(|surface, uv| {
        let cut = vec![0; uv.len()];
        let faces: Vec<u32> = (0..8).collect();
        let width = |c: u32| surface.border(&cut, c).map(|c| uv[c as usize].x).fold(0.0, f64::max);
        assert_eq!(width(surface.outer_open(&cut, &faces, &uv).unwrap()), 2.0);
        // The first that is met is on the hole's.
        assert_eq!(width(surface.first_open(&cut, &faces).unwrap()), 1.0);
        assert_eq!(surface.outer_open(&cut, &[], &uv), None);
    });
}

#[test]
fn a_slit_is_closed_where_both_of_its_ends_are() {
    on_ring(|surface, mut uv| {
        let inner = (0..uv.len() as u32).find(|c| surface.twin[*c as usize] != NONE).unwrap();
        let border = surface.first_open(&vec![0; uv.len()], &[0]).unwrap();
        assert!(surface.is_closed(&uv, inner) && !surface.is_closed(&uv, border));
        uv[inner as usize].x += 1e-12;
        assert!(!surface.is_closed(&uv, inner) && !surface.is_closed(&uv, surface.twin[inner as usize]));
    });
}
