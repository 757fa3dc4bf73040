//! Outlines drawn out to a thickness: stairs, brackets, wedges, gears, nuts, plates with bolt holes.

use super::body::{Body, Lid, Sides, circle, on_circle};
use super::{Solid, Topology};
use glam::DVec2;
use seamwright::mesh::polygons::Mesh;

const SIDES: [Sides; 2] = [Sides::Quad, Sides::Tri];
/// Lids of outlines that need not be convex.
const LIDS: [Lid; 2] = [Lid::Ngon, Lid::Ears];

/// Adds all of them.
pub fn family(out: &mut Vec<Solid>) {
    for (sides, lid) in SIDES.into_iter().flat_map(|s| LIDS.map(|l| (s, l))) {
        let mut add = |name: String, outline: Vec<DVec2>, deep: f64| {
            let name = format!("{name}_d{deep}_{lid}_{sides}");
            out.push(Solid::new(name, Topology::sphere_with(0), move || drawn_out(&outline, deep, lid, sides)));
        };
        for (steps, deep) in [1, 2, 3, 5, 10, 20, 50].into_iter().flat_map(|n| [0.05, 1.0, 10.0].map(|d| (n, d))) {
            add(format!("stairs_n{steps}"), stairs(steps), deep);
        }
        for (thick, deep) in [0.02, 0.1, 0.4].into_iter().flat_map(|t| [0.02, 0.3, 1.0, 10.0].map(|d| (t, d))) {
            add(format!("bracket_l_t{thick}"), bracket(thick, 1), deep);
            add(format!("bracket_u_t{thick}"), bracket(thick, 2), deep);
        }
        for (high, deep) in [0.01, 0.1, 1.0, 10.0].into_iter().flat_map(|h| [0.01, 0.3, 1.0, 30.0].map(|d| (h, d))) {
            add(format!("wedge_h{high}"), vec![DVec2::ZERO, DVec2::X, DVec2::Y * high], deep);
        }
        for (teeth, deep) in [3, 5, 8, 12, 20, 30, 40, 50].into_iter().flat_map(|n| [0.02, 0.2, 2.0].map(|d| (n, d))) {
            add(format!("gear_n{teeth}"), gear(teeth), deep);
        }
    }
    for sides in SIDES {
        let mut bored = |name: String, outline: Vec<DVec2>, bore: u32, radius: f64, deep: f64| {
            let name = format!("{name}_b{bore}_r{radius}_d{deep}_{sides}");
            let make = move || drawn_with_bore(&outline, &circle(bore, radius), deep, sides);
            out.push(Solid::new(name, Topology::torus(), make));
        };
        for (teeth, bore) in [(3, 8), (5, 20), (8, 32), (12, 12), (20, 24), (50, 200)] {
            for deep in [0.02, 0.2, 2.0] {
                bored(format!("gear_n{teeth}_bored"), gear(teeth), bore, 0.2, deep);
            }
        }
        for (bore, radius) in [6, 12, 30, 100].into_iter().flat_map(|n| [0.1, 0.25, 0.42].map(|r| (n, r))) {
            for deep in [0.05, 0.3, 2.0] {
                bored("nut".into(), circle(6, 0.5), bore, radius, deep);
            }
        }
        for (x, y, bore) in
            [(1, 1, 4), (1, 1, 16), (1, 1, 64), (2, 1, 12), (2, 2, 16), (3, 3, 4), (4, 3, 8), (5, 5, 12), (6, 4, 16)]
        {
            for (radius, deep) in [0.02, 0.2, 0.45].into_iter().flat_map(|r| [0.02, 0.2, 2.0].map(|d| (r, d))) {
                let name = format!("plate_x{x}_y{y}_b{bore}_r{radius}_d{deep}_{sides}");
                let topology = Topology { pieces: 1, handles: (x * y) as usize, loops: 0 };
                out.push(Solid::new(name, topology, move || plate([x, y], bore, radius, deep, sides)));
            }
        }
    }
}

/// Between `outline` at heights 0 and `deep`.
fn drawn_out(outline: &[DVec2], deep: f64, lid: Lid, sides: Sides) -> Mesh {
    let mut body = Body::default();
    let [low, high] = [0.0, deep].map(|z| body.ring(outline, z));
    body.band(&low, &high, sides);
    body.floor(&low, lid);
    body.lid(&high, lid);
    body.mesh()
}

/// The same around a bore; both begin at about the same angle.
fn drawn_with_bore(outline: &[DVec2], bore: &[DVec2], deep: f64, sides: Sides) -> Mesh {
    let mut body = Body::default();
    let [low, high] = [0.0, deep].map(|z| [body.ring(outline, z), body.ring(bore, z)]);
    body.band(&low[0], &high[0], sides);
    body.band(&high[1], &low[1], sides);
    body.stitch(&high[0], &high[1]);
    body.stitch_below(&low[0], &low[1]);
    body.mesh()
}

/// `steps` steps of one unit in all, seen from the side.
fn stairs(steps: u32) -> Vec<DVec2> {
    let at = |x: u32, y: u32| DVec2::new(f64::from(x), f64::from(y)) / f64::from(steps);
    let mut outline = vec![at(0, 0), at(steps, 0)];
    for i in (0..steps).rev() {
        outline.extend([at(i + 1, steps - i), at(i, steps - i)]);
    }
    outline
}

/// An angle of two legs, or with two `bends` a channel.
fn bracket(thick: f64, bends: u32) -> Vec<DVec2> {
    let of = |list: &[(f64, f64)]| list.iter().map(|(x, y)| DVec2::new(*x, *y)).collect();
    let t = thick;
    match bends {
        1 => of(&[(0.0, 0.0), (1.0, 0.0), (1.0, t), (t, t), (t, 1.0), (0.0, 1.0)]),
        _ => of(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (1.0 - t, 1.0), (1.0 - t, t), (t, t), (t, 1.0), (0.0, 1.0)]),
    }
}

/// Four corners a tooth, on two circles.
fn gear(teeth: u32) -> Vec<DVec2> {
    let n = 8 * teeth;
    let tooth = |i: u32| [(0, 0.5), (1, 0.5), (3, 0.4), (6, 0.4)].map(|(j, r)| on_circle(8 * i + j, n, r));
    (0..teeth).flat_map(tooth).collect()
}

/// `cells` unit squares, each with a hole of radius `radius` through it, in a plate of thickness `deep`.
fn plate(cells: [u32; 2], bore: u32, radius: f64, deep: f64, sides: Sides) -> Mesh {
    let mut body = Body::default();
    let [columns, rows] = cells;
    let corner = |x: u32, y: u32| DVec2::new(f64::from(x), f64::from(y));
    let lattice: Vec<DVec2> = (0..=rows).flat_map(|y| (0..=columns).map(move |x| corner(x, y))).collect();
    let [low, high] = [0.0, deep].map(|z| body.ring(&lattice, z));
    let place = |x: u32, y: u32| (y * (columns + 1) + x) as usize;
    for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
        let middle = corner(x, y) + DVec2::splat(0.5);
        // The hole begins at the angle of the square's first corner.
        let turn = DVec2::splat(-radius / 2.0f64.sqrt());
        let hole: Vec<DVec2> = circle(bore, 1.0).iter().map(|p| middle + turn.rotate(*p)).collect();
        let [low_hole, high_hole] = [0.0, deep].map(|z| body.ring(&hole, z));
        body.band(&high_hole, &low_hole, sides);
        let square = [place(x, y), place(x + 1, y), place(x + 1, y + 1), place(x, y + 1)];
        body.stitch(&square.map(|i| high[i]), &high_hole);
        body.stitch_below(&square.map(|i| low[i]), &low_hole);
    }
    let around = (0..columns).map(|x| place(x, 0)).chain((0..rows).map(|y| place(columns, y)));
    let back = (1..=columns).rev().map(|x| place(x, rows)).chain((1..=rows).rev().map(|y| place(0, y)));
    let rim: Vec<usize> = around.chain(back).collect();
    let [low, high] = [&low, &high].map(|level| rim.iter().map(|i| level[*i]).collect::<Vec<u32>>());
    body.band(&low, &high, sides);
    body.mesh()
}
