//! Zipping on squares of cells.

use super::goal::{Goal, Which};
use super::zip::zip;
use crate::base::pace::StageError;
use crate::base::scratch::Scratch;
use crate::base::workers::tests::Backwards;
use crate::base::workers::{Serial, Workers};
use crate::charts::surface::Surface;
use crate::first::halving::flatten_all;
use crate::mesh::topology::twins;
use crate::mesh::view::{MeshView, next};
use crate::solve::energy::Rest;
use glam::{DVec2, DVec3};
use std::vec;
use std::vec::Vec;

/// A square of cells whose middle vertex is lifted, cut along the middle line up to column `to` and flattened.
#[derive(Clone, Copy)]
struct Square {
    side: u32,
    lift: f64,
    to: u32,
    ring: bool,  // whether the cell above the middle line that begins at `to` is cut out
    notch: bool, // whether the cells beyond the middle on both axes are missing
    hole: bool,  // whether the four cells around the middle are missing
    cost: f64,   // of a cut, over its length
}

const PLANE: Square = Square { side: 4, lift: 0.0, to: 2, ring: false, notch: false, hole: false, cost: 1.0 };
const LOOSE: Goal = Goal { distortion: 1.5, worst: f64::INFINITY, bulky: false, which: Which::All };

/// What [`zip`] answers, and the cut edges before and after.
fn zip_square(square: Square, goal: Goal, bytes: &mut [u8]) -> (Result<usize, StageError>, usize, usize) {
    let (done, maps) = zipped(square, goal, bytes, &Serial);
    let [before, after] = maps.map(|(_, cut)| cut.iter().filter(|c| **c != 0).count() / 2);
    (done, before, after)
}

/// What [`zip`] answers, and the maps before and after.
#[allow(clippy::type_complexity)]
fn zipped(
    square: Square,
    goal: Goal,
    bytes: &mut [u8],
    workers: &dyn Workers,
) -> (Result<usize, StageError>, [(Vec<DVec2>, Vec<u8>); 2]) {
    let (n, half) = (square.side + 1, square.side / 2);
    let at = |v: u32| {
        let z = if v == n * n / 2 { square.lift } else { 0.0 };
        DVec3::new(f64::from(v % n), f64::from(v / n), z)
    };
    let positions: Vec<DVec3> = (0..n * n).map(at).collect();
    let cells = (0..square.side * square.side)
        .filter(|i| !square.notch || i / square.side < half || i % square.side < half)
        .filter(|i| !square.hole || [i / square.side, i % square.side].iter().any(|x| *x + 1 < half || *x > half));
    let corners = cells.map(|i| i / square.side * n + i % square.side);
    let faces: Vec<[u32; 3]> = corners.flat_map(|v| [[v, v + 1, v + n + 1], [v, v + n + 1, v + n]]).collect();
    let mesh = MeshView { positions: &positions, faces: &faces };
    let mut memory = vec![0; 1 << 22];
    let mut keep = Scratch::new(&mut memory);
    let mut twin = vec![0; 3 * faces.len()];
    twins(&mut twin, mesh, keep.frame()).unwrap();
    let rest: Vec<Rest> = faces.iter().map(|f| Rest::new(f.map(|v| positions[v as usize]), 0.0)).collect();
    let cost = vec![square.cost; 3 * faces.len()];
    let surface = Surface::new(mesh, &twin, &rest, &cost, &mut keep).unwrap();
    let mut uv: Vec<DVec2> = (0..3 * faces.len() as u32).map(|c| mesh.position(c).truncate()).collect();
    let mut cut = vec![0; 3 * faces.len()];
    for c in 0..cut.len() as u32 {
        let (p, q) = (mesh.position(c), mesh.position(next(c)));
        let (low, at) = (f64::from(half), f64::from(square.to));
        let on_line = p.y == low && q.y == low && p.x.max(q.x) <= at;
        let side = p.x.min(q.x) >= at && p.x.max(q.x) <= at + 1.0 && p.y.min(q.y) >= low && p.y.max(q.y) <= low + 1.0;
        if on_line || square.ring && side && (p.x == q.x || p.y == q.y) {
            surface.set_cut(&mut cut, c, true);
        }
    }
    flatten_all(&mut uv, &mut cut, &surface, keep.frame(), &Serial).unwrap();
    let before = (uv.clone(), cut.clone());
    let done = zip(&mut uv, &mut cut, &surface, goal, Scratch::new(bytes), workers, &mut |_, _| Ok(()));
    (done, [before, (uv, cut)])
}

#[test]
fn trials_side_by_side_find_what_trials_one_by_one_find() {
    // The paths around the ring are tried until one of them may go.
    let goal = Goal { distortion: 1.02, ..LOOSE };
    for square in [PLANE, Square { ring: true, side: 8, lift: 0.5, ..PLANE }, Square { lift: 1.0, to: 4, ..PLANE }] {
        let outcome = |bytes: usize, workers: &dyn Workers| zipped(square, goal, &mut vec![0; bytes], workers);
        let expected = outcome(1 << 24, &Serial);
        assert!(expected.0.is_ok());
        assert!(expected == outcome(1 << 24, &Backwards));
        // Down to where there is memory for one.
        let mut bytes = 1 << 24;
        while bytes > 1 << 15 {
            bytes -= bytes / 8;
            let found = outcome(bytes, &Backwards);
            assert!(found == expected || found.0.is_err(), "{bytes}");
        }
    }
}

#[test]
fn a_slit_and_a_path_between_two_charts_of_a_plane_close() {
    let mut bytes = vec![0; 1 << 22];
    assert_eq!(zip_square(PLANE, LOOSE, &mut bytes), (Ok(1), 2, 0));
    assert_eq!(zip_square(Square { to: 4, ..PLANE }, LOOSE, &mut bytes), (Ok(1), 4, 0));
}

#[test]
fn a_tip_closes_only_where_the_mean_and_the_worst_face_allow_it() {
    // A pyramid whose top is as high as its base is wide from the middle.
    let tip = Square { lift: 1.0, ..PLANE };
    let mut bytes = vec![0; 1 << 22];
    assert_eq!(zip_square(tip, LOOSE, &mut bytes), (Ok(1), 2, 0));
    let (mean, worst) = (Goal { distortion: 1.0005, ..LOOSE }, Goal { worst: 4.02, ..LOOSE });
    assert_eq!(zip_square(tip, mean, &mut bytes), (Ok(0), 2, 2));
    assert_eq!(zip_square(tip, worst, &mut bytes), (Ok(0), 2, 2));
}

#[test]
fn two_charts_stay_apart_where_their_common_hull_costs_more_than_the_path() {
    // Two arms of a corner: the hull of both is 14, the hulls of each 4 and 8.
    let arms = Square { notch: true, cost: 0.1, ..PLANE };
    let mut bytes = vec![0; 1 << 22];
    assert_eq!(zip_square(arms, LOOSE, &mut bytes), (Ok(0), 2, 2));
    assert_eq!(zip_square(arms, Goal { bulky: true, ..LOOSE }, &mut bytes), (Ok(1), 2, 0));
    assert_eq!(zip_square(Square { cost: 100.0, ..arms }, LOOSE, &mut bytes), (Ok(1), 2, 0));
}

#[test]
fn a_sliver_at_the_end_of_a_slit_is_joined_and_the_slit_stays() {
    let (slivers, mut bytes) = (Goal { which: Which::Slivers, bulky: true, ..LOOSE }, vec![0; 1 << 25]);
    let square = Square { side: 34, to: 3, ring: true, ..PLANE };
    assert_eq!(zip_square(square, slivers, &mut bytes), (Ok(1), 7, 3));
    // A cell of 64 is none.
    assert_eq!(zip_square(Square { side: 8, ..square }, slivers, &mut bytes), (Ok(0), 7, 7));
    assert_eq!(zip_square(Square { ring: false, ..square }, slivers, &mut bytes), (Ok(0), 3, 3));
}

#[test]
fn a_slit_from_a_hole_to_the_border_closes_and_leaves_the_hole() {
    let square = Square { side: 6, hole: true, ..PLANE };
    let (slits, mut bytes) = (Goal { which: Which::Slits, ..LOOSE }, vec![0; 1 << 22]);
    assert_eq!(zip_square(square, slits, &mut bytes), (Ok(1), 2, 0));
    // A path between two charts is no slit.
    assert_eq!(zip_square(Square { to: 4, ..PLANE }, slits, &mut bytes), (Ok(0), 4, 4));
}

#[test]
fn without_cuts_nothing_is_done_and_too_little_memory_is_an_error() {
    assert_eq!(zip_square(Square { to: 0, ..PLANE }, LOOSE, &mut vec![0; 1 << 22]), (Ok(0), 0, 0));
    let (done, before, after) = zip_square(PLANE, LOOSE, &mut [0; 64]);
    assert!(done.is_err());
    assert_eq!(before, after);
}

#[test]
fn where_a_slit_may_not_close_its_end_does_as_far_as_the_bound_allows() {
    let tip = Square { side: 8, lift: 1.5, to: 4, ..PLANE };
    let mut bytes = vec![0; 1 << 24];
    let mut cuts_left = |which: Which, distortion: f64| {
        let (done, before, after) = zip_square(tip, Goal { which, distortion, ..LOOSE }, &mut bytes);
        assert_eq!((before, done.is_ok()), (4, true));
        after
    };
    assert_eq!([Which::Slits, Which::Ends].map(|which| cuts_left(which, 1.04)), [4, 1]);
    assert_eq!(cuts_left(Which::Ends, 1.01), 4);
}
