//! Surfaces for tests, made of a list of faces; borders and slits of one with a hole.

use super::surface::Surface;
use crate::base::real::{cos, sin};
use crate::base::scratch::Scratch;
use crate::mesh::topology::twins;
use crate::mesh::view::{MeshView, NONE, next};
use crate::solve::energy::Rest;
use core::f64::consts::FRAC_PI_3;
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

#[test]
fn places_on_a_border_are_where_cuts_inwards_begin_the_cheapest() {
    // Six triangles around the middle, whose spokes have length 1 or 2 and these costs.
    let costs = [1.0, 0.1, 2.0, 1.5, 1.0, 1.0];
    let spokes = [1.0, 1.0, 2.0, 1.0, 1.0, 1.0].iter().enumerate();
    let rim = spokes.map(|(i, length)| length * DVec3::new(cos(FRAC_PI_3 * i as f64), sin(FRAC_PI_3 * i as f64), 0.0));
    let positions: Vec<DVec3> = rim.chain([DVec3::ZERO]).collect();
    let faces: Vec<[u32; 3]> = (0..6).map(|i| [i, (i + 1) % 6, 6]).collect();
    let cost = |mesh: MeshView, c: u32| {
        let ends = [mesh.vertex(c), mesh.vertex(next(c))];
        costs.get(ends[0].min(ends[1]) as usize).copied().filter(|_| ends.contains(&6)).unwrap_or(0.0)
    };
    on_surface(&positions, &faces, cost, |surface, _| {
        let cut = vec![0; surface.twin.len()];
        let border: Vec<u32> = surface.border(&cut, 0).collect();
        let from = |places: &mut [u32]| {
            surface.places_on(&cut, &border, places);
            places.iter().map(|c| surface.mesh.vertex(*c)).collect::<Vec<u32>>()
        };
        assert_eq!(from(&mut [NONE; 6]), [0, 1, 2, 3, 4, 5]);
        // By unit of length vertex 2 is cheaper than 3; of two that cost the same the first stays.
        assert_eq!(from(&mut [NONE; 3]), [1, 2, 4]);
        assert_eq!(from(&mut [NONE; 1]), [1]);
    });
}
