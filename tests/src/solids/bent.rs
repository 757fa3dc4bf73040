//! Rings and tori, pipes bent by a quarter turn, belts: what goes round a second centre.

use super::body::{Body, Lid, Sides, circle, on_circle};
use super::{Solid, Topology};
use glam::{DVec2, DVec3};
use seamwright::mesh::polygons::Mesh;
use seamwright_core::base::real;
use std::f64::consts::PI;

/// Adds all of them.
pub fn family(out: &mut Vec<Solid>) {
    for sides in [Sides::Quad, Sides::Tri] {
        for (n, m) in [3, 4, 6, 12, 32].into_iter().flat_map(|n| [3, 4, 8, 16].map(|m| (n, m))) {
            for thick in [0.02, 0.2, 0.6, 0.95] {
                let name = format!("torus_n{n}_m{m}_t{thick}_{sides}");
                out.push(Solid::new(name, Topology::torus(), move || torus(n, m, thick, sides)));
            }
        }
        for (n, m) in [3, 4, 6, 8, 16, 32].into_iter().flat_map(|n| [1, 2, 4, 8, 16].map(|m| (n, m))) {
            for (bend, leg) in [(0.6, 0.0), (0.6, 2.0), (2.0, 0.0), (2.0, 10.0), (10.0, 3.0)] {
                for lid in [None, Some(Lid::Ngon), Some(Lid::Fan)] {
                    let end = lid.map_or("open".into(), |lid| format!("{lid}_closed"));
                    let name = format!("pipe_n{n}_m{m}_b{bend}_l{leg}_{sides}_{end}");
                    let loops = if lid.is_none() { 2 } else { 0 };
                    out.push(Solid::new(name, Topology::sphere_with(loops), move || pipe(n, m, bend, leg, lid, sides)));
                }
            }
        }
        for (toothed, wide) in [false, true].into_iter().flat_map(|t| [0.05, 0.3, 2.0].map(|wide| (t, wide))) {
            for (arc, straight, rows) in [(4, 1, 1), (8, 3, 1), (32, 10, 1), (8, 3, 4)] {
                let teeth = if toothed { "toothed" } else { "plain" };
                let name = format!("belt_{teeth}_w{wide}_n{arc}_s{straight}_r{rows}_{sides}");
                let make = move || belt(toothed, wide, arc, straight, rows, sides);
                out.push(Solid::new(name, Topology::sphere_with(2), make));
            }
        }
    }
}

/// `n` segments around the axis, `m` around the tube of `thick` times the radius.
fn torus(n: u32, m: u32, thick: f64, sides: Sides) -> Mesh {
    let mut body = Body::default();
    let profile = circle(m, 0.5 * thick);
    let rings: Vec<Vec<u32>> = (0..n)
        .map(|i| {
            let out = on_circle(i, n, 1.0);
            profile.iter().map(|p| body.point((out * (0.5 + p.x)).extend(p.y))).collect()
        })
        .collect();
    for i in 0..n as usize {
        body.band(&rings[(i + 1) % n as usize], &rings[i], sides);
    }
    body.mesh()
}

/// A pipe of radius .5 whose axis turns by a quarter with radius `bend` in `m` steps, between two straight legs of length
/// `leg` (none where that is 0).
fn pipe(n: u32, m: u32, bend: f64, leg: f64, lid: Option<Lid>, sides: Sides) -> Mesh {
    let mut body = Body::default();
    let profile = circle(n, 0.5);
    let mut rings: Vec<Vec<u32>> = vec![];
    let mut ring = |turn: f64, along: f64| {
        // The axis runs up, then turns towards +x.
        let (sin, cos) = (real::sin(turn), real::cos(turn));
        let out = DVec3::new(-cos, 0.0, sin); // from the centre of the turn
        let middle = DVec3::X * bend + out * bend + DVec3::new(sin, 0.0, cos) * along;
        rings.push(profile.iter().map(|p| body.point(middle - out * p.x + DVec3::Y * p.y)).collect());
    };
    if leg > 0.0 {
        ring(0.0, -leg);
    }
    (0..=m).for_each(|i| ring(f64::from(i) / f64::from(m) * PI / 2.0, 0.0));
    if leg > 0.0 {
        ring(PI / 2.0, leg);
    }
    body.bands(&rings, sides);
    if let Some(lid) = lid {
        body.floor(&rings[0], lid);
        body.lid(&rings[rings.len() - 1], lid);
    }
    body.mesh()
}

/// A strip of width `wide` closed around two wheels, each half turn in `arc` steps, each straight run in `straight`; where
/// it is toothed, every other point of the outline goes in or out by turns.
fn belt(toothed: bool, wide: f64, arc: u32, straight: u32, rows: u32, sides: Sides) -> Mesh {
    let mut outline: Vec<DVec2> = vec![];
    for (end, x) in [(0, 1.0), (1, -1.0)] {
        for i in 0..=arc {
            let p = on_circle(i + end * arc, 2 * arc, 0.5);
            outline.push(DVec2::new(p.y, -p.x) + DVec2::X * x);
        }
        for i in 1..straight {
            let t = f64::from(i) / f64::from(straight);
            outline.push(DVec2::new(x * (1.0 - 2.0 * t), 0.5 * x));
        }
    }
    if toothed {
        outline.iter_mut().skip(1).step_by(4).for_each(|p| *p *= 0.9);
        outline.iter_mut().skip(3).step_by(4).for_each(|p| *p *= 1.1);
    }
    let mut body = Body::default();
    let rings: Vec<Vec<u32>> =
        (0..=rows).map(|row| body.ring(&outline, wide * f64::from(row) / f64::from(rows))).collect();
    body.bands(&rings, sides);
    body.mesh()
}
