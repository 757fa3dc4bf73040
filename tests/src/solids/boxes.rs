//! Boxes: with bevelled edges, with a square hole, and pyramids over a rectangle.

use super::body::{Body, Lid, Sides};
use super::{Solid, Topology};
use glam::{DVec2, DVec3};
use seamwright::mesh::polygons::Mesh;

/// Adds all of them.
pub fn family(out: &mut Vec<Solid>) {
    for sides in [Sides::Quad, Sides::Tri] {
        for rows in 0..=3 {
            for (flat, bevel) in
                [0.01, 0.1, 1.0, 10.0, 100.0].into_iter().flat_map(|f| [0.02, 0.2, 0.45].map(|b| (f, b)))
            {
                if rows > 0 || bevel == 0.2 {
                    let name = format!("box_a{flat}_r{rows}_b{bevel}_{sides}");
                    out.push(Solid::new(name, Topology::sphere_with(0), move || bevelled(flat, rows, bevel, sides)));
                }
            }
        }
        for (hole, high) in [0.1, 0.5, 0.9].into_iter().flat_map(|r| [0.05, 1.0, 10.0].map(|h| (r, h))) {
            let name = format!("drilled_s{hole}_a{high}_{sides}");
            out.push(Solid::new(format!("{name}_through"), Topology::torus(), move || drilled(hole, high, 1.0, sides)));
            for deep in [0.1, 0.9] {
                let make = move || drilled(hole, high, deep, sides);
                out.push(Solid::new(format!("{name}_blind{deep}"), Topology::sphere_with(0), make));
            }
        }
    }
    for (wide, high) in [0.01, 0.1, 1.0].into_iter().flat_map(|w| [0.01, 0.1, 1.0, 10.0, 100.0].map(|h| (w, h))) {
        for lid in [None, Some(Lid::Ngon), Some(Lid::Fan), Some(Lid::Corner)] {
            let end = lid.map_or("open".into(), |lid| format!("{lid}_closed"));
            let topology = Topology::sphere_with(usize::from(lid.is_none()));
            out.push(Solid::new(format!("pyramid_w{wide}_a{high}_{end}"), topology, move || pyramid(wide, high, lid)));
        }
    }
}

/// A box of 1 x 1 x `high` whose edges are rounded with `rows` rows of faces, with a radius of `bevel` times half its least
/// side; each corner is an eighth of a ball in as many rows of triangles. Without rows, a box of six sides.
fn bevelled(high: f64, rows: u32, bevel: f64, sides: Sides) -> Mesh {
    let mut body = Body::default();
    let half = DVec3::new(0.5, 0.5, 0.5 * high);
    let radius = if rows == 0 { 0.0 } else { bevel * half.min_element() };
    let rows = rows.max(1);
    let signs = |k: usize| DVec3::from_array([0, 1, 2].map(|axis| if k >> axis & 1 == 0 { -1.0 } else { 1.0 }));
    // Points of corner k by shares of the three axes that sum to `rows`; one point where nothing is rounded.
    let place = |i: u32, j: u32| (i * (rows + 1) + j) as usize;
    let corners: Vec<Vec<u32>> = (0..8)
        .map(|k| {
            let mut points = vec![u32::MAX; place(rows, rows) + 1];
            let one = (radius == 0.0).then(|| body.point(signs(k) * half));
            for (i, j) in (0..=rows).flat_map(|i| (0..=rows - i).map(move |j| (i, j))) {
                let out = DVec3::new(f64::from(i), f64::from(j), f64::from(rows - i - j)).normalize();
                let p = signs(k) * (half - DVec3::splat(radius) + out * radius);
                points[place(i, j)] = one.unwrap_or_else(|| body.point(p));
            }
            points
        })
        .collect();
    let at = |k: usize, shares: [u32; 3]| corners[k][place(shares[0], shares[1])];
    if radius > 0.0 {
        for k in 0..8 {
            for (i, j) in (0..rows).flat_map(|i| (0..rows - i).map(move |j| (i, j))) {
                let l = rows - 1 - i - j;
                body.face(&[at(k, [i + 1, j, l]), at(k, [i, j + 1, l]), at(k, [i, j, l + 1])]);
                if l > 0 {
                    let l = l - 1;
                    body.face(&[at(k, [i + 1, j + 1, l]), at(k, [i, j + 1, l + 1]), at(k, [i + 1, j, l + 1])]);
                }
            }
        }
    }
    for axis in 0..3 {
        let (u, w) = ((axis + 1) % 3, (axis + 2) % 3);
        for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let (low, high) = (a << u | b << w, 1 << axis | a << u | b << w);
            if radius > 0.0 {
                // The edge along `axis`: rows from the side of u to the side of w.
                for i in 0..rows {
                    let [here, there] = [i, i + 1].map(|i| {
                        let mut shares = [0; 3];
                        (shares[u], shares[w]) = (rows - i, i);
                        shares
                    });
                    body.quad([at(low, here), at(high, here), at(high, there), at(low, there)], sides);
                }
            }
        }
        for high in 0..2 {
            let mut shares = [0; 3];
            shares[axis] = rows;
            let corner = |a: usize, b: usize| at(high << axis | a << u | b << w, shares);
            body.quad([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)], sides);
        }
    }
    body.facing_out().mesh()
}

/// A square around the origin.
fn square(half: f64) -> [DVec2; 4] {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec2::new(x, y) * half)
}

/// A box of 1 x 1 x `high` with a square hole of side `hole` from above, `deep` of its height; 1 goes through.
fn drilled(hole: f64, high: f64, deep: f64, sides: Sides) -> Mesh {
    let mut body = Body::default();
    let [low, top] = [0.0, high].map(|z| body.ring(&square(0.5), z));
    let [end, mouth] = [high * (1.0 - deep), high].map(|z| body.ring(&square(0.5 * hole), z));
    body.band(&low, &top, sides);
    body.band(&top, &mouth, sides);
    body.band(&mouth, &end, sides);
    if deep == 1.0 {
        body.band(&end, &low, sides);
    } else {
        body.quad([end[0], end[1], end[2], end[3]], sides);
        body.quad([low[3], low[2], low[1], low[0]], sides);
    }
    body.mesh()
}

/// Over a rectangle of 1 x `wide`.
fn pyramid(wide: f64, high: f64, lid: Option<Lid>) -> Mesh {
    let mut body = Body::default();
    let base = body.ring(&square(0.5).map(|p| DVec2::new(p.x, p.y * wide)), 0.0);
    let apex = body.point(DVec3::Z * high);
    body.tip(&base, apex);
    if let Some(lid) = lid {
        body.floor(&base, lid);
    }
    body.mesh()
}
