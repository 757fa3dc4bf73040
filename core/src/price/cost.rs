//! The cost of a cut along each edge: its length, times what is seen of it, times how much it is noticed there.
//! ```text
//! cost = length (OPEN + SEEN exposure) notice weight
//! ```
//! notice falls from 1 where the surface runs on to LEAST_NOTICE where it turns sharply or the file's shading breaks. Artists
//! cut where the surface turns and hardly ask for exposure: over sixty of their atlases .006 of all edges that turn below a
//! degree are seams, .03 from 10 to 20, .13 from 40 to 60, .5 above 90; .11 of what is half hidden and .08 of what is open.
//! docs/METHODS.md says how the constants were found.

use super::given::{HardEdges, OnMesh};
use super::turn::turns;
use crate::base::real::{for_cost, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::mesh::view::next;
use crate::mesh::working::{DIAGONAL, Working};

/// Cost of a unit of length that nobody sees, and what being seen adds. Exposure to the power of 1.5, 2 and 4 was tried beside
/// 1: at the same fill more is noticed.
const OPEN: f64 = 0.17;
/// See [`OPEN`].
const SEEN: f64 = 2.55;
/// Turn, in degrees, up to which a seam is noticed as on a flat face.
pub const SMOOTH: f64 = 10.0;
/// Turn from which on it is noticed the least. 40, where the eye's judge says so, leaves nothing to prefer among edges of 50
/// and 90 degrees.
const SHARP: f64 = 80.0;
/// What is noticed of a seam on a sharp edge.
const LEAST_NOTICE: f64 = 0.05;
/// Cost of a cut through a flat face, over one where the surface bends a little: artists cut a third as often there, and a
/// flat face has no need to be cut.
const FLAT: f64 = 2.0;
/// Turn, in degrees, up to which two faces lie in one plane.
pub const IN_PLANE: f64 = 0.02;
/// What a cut costs under [`Prefer::Seams`] and [`Prefer::Fill`] over [`Prefer::Balance`].
const DEARER: f64 = 2.0;
/// See [`DEARER`].
const CHEAPER: f64 = 0.4;
/// What filling all of the square is worth, in what cuts cost over the square root of all area: 25 fills .719 of it on 13 meshes, 40
/// .723, without such cuts .67.
pub const FILL_WORTH: f64 = 40.0;
/// What a unit of distortion (sd/4 - 1) costs, in the same: on smooth meshes the last cut before the bound costs ten times as much for what it
/// relieves, while on flat ones a sharp edge that nobody notices would bend whole faces.
pub const DISTORTION_WORTH: f64 = 8.0;
/// Cost of an edge that is forbidden: no distortion pays for it, but what must be cut to become flat at all is cut.
pub const FORBIDDEN: f64 = 1e30;

/// What is given up for the other, where one has to be: seams that are noticed, or a square that is filled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Prefer {
    /// The fewest seams that are noticed: charts may be of any shape.
    Seams,
    /// Both in their measure.
    #[default]
    Balance,
    /// Charts that pack well.
    Fill,
}

impl Prefer {
    /// What a cut costs over [`Prefer::Balance`]; what an empty part of the square costs stays.
    pub fn scale(self) -> f64 {
        match self {
            Prefer::Seams => DEARER,
            Prefer::Balance => 1.0,
            Prefer::Fill => CHEAPER,
        }
    }
}

/// What a price depends on beside the mesh.
#[derive(Clone, Copy)]
pub struct Rates {
    /// What breaks count for.
    pub hard_edges: HardEdges,
    /// What is given up for what.
    pub prefer: Prefer,
    /// How far positions may be from what they stand for, in units of the working mesh.
    pub tolerance: f64,
}

/// What a cut counts for where the surface turns by `turn` degrees: 1 where it bends a little.
pub fn notice(turn: f64) -> f64 {
    if turn <= IN_PLANE {
        return FLAT;
    }
    1.0 - (1.0 - LEAST_NOTICE) * ((turn - SMOOTH) / (SHARP - SMOOTH)).clamp(0.0, 1.0)
}

/// Scratch bytes for [`prices`].
pub const fn prices_need(faces: usize) -> usize {
    bytes_for::<f64>(3 * faces)
}

/// Fills `cost` (one entry a half-edge of `working`, equal for twins). Diagonals of polygons cost infinity: they are never
/// cut. Without `exposure` (one value a vertex) a cut costs as if all were open. Returns whether breaks of the shading count. O(f).
pub fn prices(
    cost: &mut [f64],
    working: &Working,
    given: &OnMesh,
    rates: Rates,
    exposure: Option<&[f32]>,
    mut scratch: Scratch,
) -> Result<bool, ScratchTooSmall> {
    let mesh = working.mesh();
    scratch.require(prices_need(mesh.faces.len()))?;
    let turn = scratch.take::<f64>(cost.len())?;
    turns(turn, mesh, working.twin, rates.tolerance);
    let breaks = rates.hard_edges != HardEdges::Off && given.has_breaks(turn);
    let scale = rates.prefer.scale();
    for c in 0..cost.len() as u32 {
        if working.fixed[c as usize] == DIAGONAL {
            cost[c as usize] = f64::INFINITY;
            continue;
        }
        let (a, b) = (mesh.vertex(c), mesh.vertex(next(c)));
        let d = mesh.positions[b as usize] - mesh.positions[a as usize];
        let seen = exposure.map_or(1.0, |open| 0.5 * (f64::from(open[a as usize]) + f64::from(open[b as usize])));
        let broken = if breaks { given.broken(c) } else { 0.0 };
        let noticed = broken * LEAST_NOTICE + (1.0 - broken) * notice(turn[c as usize]);
        let sum = sqrt(d.dot(d)) * (OPEN + SEEN * seen) * noticed * given.weight(c) * scale;
        cost[c as usize] = if sum < FORBIDDEN { for_cost(sum) } else { FORBIDDEN };
    }
    Ok(breaks)
}

#[cfg(test)]
mod tests {
    use super::super::given::{BREAK, EdgeData};
    use super::*;
    use crate::mesh::polygons::Polygons;
    use crate::mesh::repair::{Facing, repair, repair_need};
    use crate::mesh::view::NONE;
    use glam::DVec3;
    use std::vec;
    use std::vec::Vec;

    /// Costs of the edges of two quads that meet along x = 1 at an angle of `turn` degrees, by their input corners.
    fn costs(turn: f64, data: EdgeData, hard_edges: HardEdges, open: f32) -> Vec<(u32, f64)> {
        let (c, s) = (crate::base::real::cos(turn.to_radians()), crate::base::real::sin(turn.to_radians()));
        let positions = [
            DVec3::ZERO,
            DVec3::X,
            DVec3::new(1.0, 1.0, 0.0),
            DVec3::Y,
            DVec3::new(1.0 + c, 0.0, s),
            DVec3::new(1.0 + c, 1.0, s),
        ];
        let polygons = Polygons {
            positions: &positions,
            corners: &[0, 1, 2, 3, 1, 4, 5, 2],
            polygon_start: &[0, 4, 8],
            kept_uv: None,
        };
        let mut bytes = vec![0; repair_need(&polygons.counts())];
        let mut out = Scratch::new(&mut bytes);
        let (working, _) = repair(&polygons, Facing::Turned, &mut out).expect("a mesh");
        let given = OnMesh::new(data, &polygons, &working);
        let mut cost = vec![0.0; working.twin.len()];
        let mut bytes = vec![0; prices_need(working.faces.len())];
        let rates = Rates { hard_edges, prefer: Prefer::Balance, tolerance: 0.0 };
        let exposure = vec![open; working.positions.len()];
        prices(&mut cost, &working, &given, rates, Some(&exposure), Scratch::new(&mut bytes)).expect("enough");
        let short = bytes.len() - 1;
        let refused = prices(&mut cost.clone(), &working, &given, rates, None, Scratch::new(&mut bytes[..short]));
        assert!(refused.is_err());
        let shared = (0..cost.len()).filter(|c| working.twin[*c] != NONE && working.fixed[*c] != DIAGONAL);
        assert!((0..cost.len()).all(|c| (working.fixed[c] == DIAGONAL) == cost[c].is_infinite()));
        // The shared edge is 1 long, of 2 in the box.
        shared.map(|c| (working.corner_source[c], cost[c] * working.extent)).collect()
    }

    fn shared(turn: f64, data: EdgeData, hard_edges: HardEdges, open: f32) -> f64 {
        let both = costs(turn, data, hard_edges, open);
        assert_eq!((both.len(), both[0].1), (2, both[1].1));
        both[0].1
    }

    /// Costs have 10 bits.
    fn near(a: f64, b: f64) -> bool {
        (a / b - 1.0).abs() < 1e-3
    }

    #[test]
    fn what_is_seen_costs_more_and_what_turns_costs_less() {
        let plain = |turn, open| shared(turn, EdgeData::default(), HardEdges::Prefer, open);
        assert!(
            near(plain(1.0, 1.0), OPEN + SEEN) && near(plain(1.0, 0.0), OPEN) && near(plain(5.0, 1.0), OPEN + SEEN)
        );
        assert!(near(plain(0.0, 1.0), FLAT * (OPEN + SEEN)), "both faces lie in one plane");
        assert!(near(plain(90.0, 1.0), (OPEN + SEEN) * LEAST_NOTICE));
        assert!(near(plain(45.0, 1.0), (OPEN + SEEN) * notice(45.0)));
    }

    #[test]
    fn a_shading_break_is_as_good_as_a_sharp_edge_unless_it_is_off() {
        let mut marks = [0; 8];
        marks[1] = BREAK; // from vertex 1 to 2, in the first polygon
        let data = EdgeData { marks: Some(&marks), ..EdgeData::default() };
        assert!(near(shared(1.0, data, HardEdges::Prefer, 1.0), (OPEN + SEEN) * LEAST_NOTICE));
        assert!(near(shared(1.0, data, HardEdges::Off, 1.0), OPEN + SEEN));
        let (up, aside) = (glam::Vec3::Z, glam::Vec3::X);
        let normals = [up, up, up, up, aside, up, up, aside];
        let data = EdgeData { normals: Some(&normals), ..EdgeData::default() };
        assert!(near(shared(1.0, data, HardEdges::Prefer, 1.0), (OPEN + SEEN) * LEAST_NOTICE));
        let one_end = [up, up, up, up, up, up, up, aside];
        let data = EdgeData { normals: Some(&one_end), ..EdgeData::default() };
        assert!(near(shared(1.0, data, HardEdges::Prefer, 1.0), (OPEN + SEEN) * (1.0 + LEAST_NOTICE) / 2.0));
    }

    #[test]
    fn a_file_that_is_shaded_flat_says_nothing_by_its_normals() {
        let normals = [[glam::Vec3::Z; 4], [glam::Vec3::new(-0.34, 0.0, 0.94); 4]].concat();
        let data = EdgeData { normals: Some(&normals), ..EdgeData::default() };
        let bare = shared(20.0, EdgeData::default(), HardEdges::Prefer, 1.0);
        assert!(near(shared(20.0, data, HardEdges::Prefer, 1.0), bare), "its only gentle edge is a break");
        // At 60 degrees it is no gentle edge, and the break counts.
        assert!(near(shared(60.0, data, HardEdges::Prefer, 1.0), (OPEN + SEEN) * LEAST_NOTICE));
    }

    #[test]
    fn weights_multiply_and_the_larger_of_two_names_counts() {
        let cost = |own: f32, other: f32| {
            let mut weights = [f32::NAN; 8];
            (weights[1], weights[7]) = (own, other);
            shared(1.0, EdgeData { weights: Some(&weights), ..EdgeData::default() }, HardEdges::Prefer, 1.0)
        };
        assert!(near(cost(2.0, f32::NAN), 2.0 * (OPEN + SEEN)) && near(cost(2.0, 3.0), 3.0 * (OPEN + SEEN)));
        assert_eq!(cost(0.0, f32::NAN), 0.0);
        assert_eq!(cost(-1.0, 0.0), 0.0);
        assert!(cost(f32::INFINITY, 0.0) >= FORBIDDEN);
        // A list that ends before the edge says nothing.
        let short = EdgeData { weights: Some(&[5.0]), ..EdgeData::default() };
        assert!(near(shared(1.0, short, HardEdges::Prefer, 1.0), OPEN + SEEN));
    }
}
