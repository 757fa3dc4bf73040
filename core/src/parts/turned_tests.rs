//! Turned shapes for the tests of this room.
#![cfg(test)]

use crate::base::real;
use crate::base::scratch::Scratch;
use crate::mesh::topology::{twins, twins_need};
use crate::mesh::view::MeshView;
use core::f64::consts::TAU;
use glam::DVec3;
use std::vec::Vec;
use std::{assert_eq, vec};

/// Sides of a turned shape.
const SIDES: usize = 24;

/// A closed surface around the z axis with the given radii at heights 0, 0.1, 0.2 ...; its diameters are the radii's.
pub struct Turned {
    pub positions: Vec<DVec3>,
    pub faces: Vec<[u32; 3]>,
    pub twin: Vec<u32>,
    pub diameter: Vec<f32>,
}

pub fn turned(radii: &[f64]) -> Turned {
    let mut positions = vec![];
    for (k, r) in radii.iter().enumerate() {
        for i in 0..SIDES {
            let angle = TAU * i as f64 / SIDES as f64;
            positions.push(DVec3::new(r * real::cos(angle), r * real::sin(angle), 0.1 * k as f64));
        }
    }
    let rings = radii.len();
    let [bottom, top] = [rings * SIDES, rings * SIDES + 1].map(|v| v as u32);
    positions.extend([DVec3::ZERO, DVec3::Z * (0.1 * (rings - 1) as f64)]);
    let (mut faces, mut diameter) = (vec![], vec![]);
    for i in 0..SIDES {
        let next = (i + 1) % SIDES;
        let at = |ring: usize, side: usize| (ring * SIDES + side) as u32;
        faces.extend([[bottom, at(0, next), at(0, i)], [top, at(rings - 1, i), at(rings - 1, next)]]);
        diameter.extend([2.0 * radii[0] as f32, 2.0 * radii[rings - 1] as f32]);
        for k in 1..rings {
            faces.extend([[at(k - 1, i), at(k - 1, next), at(k, next)], [at(k - 1, i), at(k, next), at(k, i)]]);
            diameter.extend([(radii[k - 1] + radii[k]) as f32; 2]);
        }
    }
    let mut twin = vec![0; 3 * faces.len()];
    let mut bytes = vec![0; twins_need(faces.len())];
    let mesh = MeshView { positions: &positions, faces: &faces };
    assert_eq!(twins(&mut twin, mesh, Scratch::new(&mut bytes)), Ok(0));
    Turned { positions, faces, twin, diameter }
}

/// Two balls of radius 0.5 with a neck of 0.08 between them.
pub fn dumbbell() -> Turned {
    let ball = |k: i32| real::sqrt(0.25 - 0.01 * (k * k) as f64).max(0.08);
    let one: Vec<f64> = (-5..=5).map(ball).collect();
    turned(&[&one[..], &[0.08; 4], &one[..]].concat())
}
