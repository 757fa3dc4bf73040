//! Cylinders and prisms, cones and frusta, tubes: everything that four charts are enough for.
//!
//! The diameter is 1; the aspect is the height over it.

use super::body::{Body, Lid, Sides, circle};
use super::{Solid, Topology};
use seamwright::mesh::polygons::Mesh;

/// Segments around.
pub const SEGMENTS: [u32; 17] = [3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 24, 32, 48, 64, 100, 128, 200];
/// Heights over the diameter.
pub const ASPECTS: [f64; 9] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0];
/// Rows of faces along the height.
const ROWS: [u32; 2] = [1, 5];
/// Lids that a convex rim can have, or none.
const LIDS: [Option<Lid>; 4] = [Some(Lid::Ngon), Some(Lid::Fan), Some(Lid::Corner), None];
const SIDES: [Sides; 2] = [Sides::Quad, Sides::Tri];
/// Radius of a frustum's upper end over that of its lower one.
const TAPER: f64 = 0.5;
/// Thickness of a tube's wall over its radius.
const WALLS: [f64; 2] = [0.1, 0.5];
/// Most charts that a round solid may have: a tube has two walls and two rings.
const MOST_CHARTS: usize = 4;

/// Which ends of a cylinder are closed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ends {
    Closed(Lid),
    Can(Lid),
    Open,
}

/// Which ends of a tube have a ring between its walls.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rings {
    Both,
    One,
    None,
}

/// Adds all of them.
pub fn family(out: &mut Vec<Solid>) {
    for (n, aspect) in SEGMENTS.into_iter().flat_map(|n| ASPECTS.map(|a| (n, a))) {
        for sides in SIDES {
            cylinders(out, n, aspect, sides);
            tubes(out, n, aspect, sides);
        }
        for (lid, rows) in LIDS.into_iter().flat_map(|lid| ROWS.map(|rows| (lid, rows))) {
            let all: &[Sides] = if rows == 1 { &[Sides::Tri] } else { &SIDES };
            all.iter().for_each(|sides| cones(out, n, aspect, lid, rows, *sides));
        }
    }
}

fn push(out: &mut Vec<Solid>, name: String, topology: Topology, make: impl Fn() -> Mesh + Send + Sync + 'static) {
    out.push(Solid { most_charts: Some(MOST_CHARTS), ..Solid::new(name, topology, make) });
}

/// The part of a name that says how many rows there are, where it is not one.
fn rows_name(rows: u32) -> String {
    if rows == 1 { String::new() } else { format!("_r{rows}") }
}

fn cylinders(out: &mut Vec<Solid>, n: u32, aspect: f64, sides: Sides) {
    for rows in ROWS {
        let name = |lid: &str, end: &str| format!("cylinder_n{n}_a{aspect}{lid}_{sides}{}_{end}", rows_name(rows));
        let mut add = |name, loops, ends| {
            push(out, name, Topology::sphere_with(loops), move || frustum(n, aspect, 1.0, ends, rows, sides));
        };
        for lid in LIDS.into_iter().flatten() {
            add(name(&format!("_{lid}"), "closed"), 0, Ends::Closed(lid));
        }
        add(name("_ngon", "can"), 1, Ends::Can(Lid::Ngon));
        add(name("", "open"), 2, Ends::Open);
        if rows == 1 {
            for (ends, lid) in LIDS.map(|lid| (lid.map_or(Ends::Open, Ends::Closed), lid)) {
                let lid = lid.map_or("open".into(), |lid| format!("{lid}_closed"));
                let name = format!("frustum_n{n}_a{aspect}_{sides}_{lid}");
                let loops = if ends == Ends::Open { 2 } else { 0 };
                push(out, name, Topology::sphere_with(loops), move || frustum(n, aspect, TAPER, ends, rows, sides));
            }
        }
    }
}

fn cones(out: &mut Vec<Solid>, n: u32, aspect: f64, lid: Option<Lid>, rows: u32, sides: Sides) {
    let wall = if rows == 1 { String::new() } else { format!("_{sides}{}", rows_name(rows)) };
    let end = lid.map_or("open".into(), |lid| format!("{lid}_closed"));
    let topology = Topology::sphere_with(usize::from(lid.is_none()));
    push(out, format!("cone_n{n}_a{aspect}{wall}_{end}"), topology, move || cone(n, aspect, lid, rows, sides));
}

fn tubes(out: &mut Vec<Solid>, n: u32, aspect: f64, sides: Sides) {
    for wall in WALLS {
        for (rings, end, topology) in [
            (Rings::Both, "closed", Topology { pieces: 1, handles: 1, loops: 0 }),
            (Rings::One, "half", Topology { pieces: 1, handles: 0, loops: 2 }),
            (Rings::None, "open", Topology { pieces: 2, handles: 0, loops: 4 }),
        ] {
            let name = format!("tube_n{n}_a{aspect}_w{wall}_{sides}_{end}");
            push(out, name, topology, move || tube(n, aspect, wall, rings, sides));
        }
    }
}

/// Rings from the floor at 0 up to the height, the radius going from one half to `taper` of it.
fn frustum(n: u32, height: f64, taper: f64, ends: Ends, rows: u32, sides: Sides) -> Mesh {
    let mut body = Body::default();
    let rings = rings(&mut body, n, height, rows, |t| 0.5 * (1.0 + (taper - 1.0) * t));
    body.bands(&rings, sides);
    if let Ends::Closed(lid) | Ends::Can(lid) = ends {
        body.floor(&rings[0], lid);
    }
    if let Ends::Closed(lid) = ends {
        body.lid(&rings[rows as usize], lid);
    }
    body.mesh()
}

fn rings(body: &mut Body, n: u32, height: f64, rows: u32, radius: impl Fn(f64) -> f64) -> Vec<Vec<u32>> {
    let share = |row: u32| f64::from(row) / f64::from(rows);
    (0..=rows).map(|row| body.ring(&circle(n, radius(share(row))), share(row) * height)).collect()
}

fn cone(n: u32, height: f64, lid: Option<Lid>, rows: u32, sides: Sides) -> Mesh {
    let mut body = Body::default();
    // The last row is the triangles at the apex.
    let share = |row: u32| f64::from(row) / f64::from(rows);
    let rings: Vec<Vec<u32>> =
        (0..rows).map(|row| body.ring(&circle(n, 0.5 * (1.0 - share(row))), share(row) * height)).collect();
    body.bands(&rings, sides);
    let apex = body.point(glam::DVec3::Z * height);
    body.tip(&rings[rows as usize - 1], apex);
    if let Some(lid) = lid {
        body.floor(&rings[0], lid);
    }
    body.mesh()
}

fn tube(n: u32, height: f64, wall: f64, ends: Rings, sides: Sides) -> Mesh {
    let mut body = Body::default();
    let [outer, inner] = [0.5, 0.5 * (1.0 - wall)].map(|radius| rings(&mut body, n, height, 1, |_| radius));
    body.band(&outer[0], &outer[1], sides);
    body.band(&inner[1], &inner[0], sides);
    if ends != Rings::None {
        body.band(&inner[0], &outer[0], sides);
    }
    if ends == Rings::Both {
        body.band(&outer[1], &inner[1], sides);
    }
    body.mesh()
}
