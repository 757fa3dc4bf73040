//! What a program says of edges: weights, cuts, breaks of the shading, each by the corner that the edge leaves.

use crate::call::Call;
use seamwright_ffi::*;

/// Two quads in a plane. Their edge leaves corner 1 in the first and corner 7 in the second.
fn sheet() -> Call {
    let positions = [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]];
    let positions = positions.iter().flat_map(|[x, y]| [*x, *y, 0].map(f64::from)).collect();
    Call::new(positions, vec![0, 1, 4, 3, 1, 2, 5, 4], Some(vec![0, 4, 8]))
}

/// Charts that `say` ends in.
fn charts(say: impl FnOnce(&mut Call)) -> usize {
    let mut call = sheet();
    say(&mut call);
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    call.report.chart_count
}

#[test]
fn a_marked_edge_is_cut() {
    assert_eq!(charts(|_| ()), 1);
    for corner in [1, 7] {
        let mut marks = [0u8; 8];
        marks[corner] = SEAMWRIGHT_EDGE_CUT;
        assert_eq!(charts(|call| call.mesh.edge_marks = marks.as_ptr()), 2, "by corner {corner}");
    }
    let border = [SEAMWRIGHT_EDGE_CUT, 0, 0, 0, 0, 0, 0, 0];
    assert_eq!(charts(|call| call.mesh.edge_marks = border.as_ptr()), 1);
}

#[test]
fn a_break_of_the_shading_is_a_cut_where_that_is_required() {
    let marks = [0, SEAMWRIGHT_EDGE_BREAK, 0, 0, 0, 0, 0, 0];
    let [up, aside] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0f32]];
    let split = [[up; 4], [aside; 4]].concat();
    let (whole, split) = ([up; 8], split.as_flattened());
    for (choice, count) in
        [(SEAMWRIGHT_HARD_EDGES_PREFER, 1), (SEAMWRIGHT_HARD_EDGES_REQUIRE, 2), (SEAMWRIGHT_HARD_EDGES_OFF, 1)]
    {
        let run = |say: &dyn Fn(&mut SeamwrightMesh)| {
            charts(|call| {
                call.options.hard_edges = choice;
                say(&mut call.mesh);
            })
        };
        assert_eq!(run(&|mesh| mesh.edge_marks = marks.as_ptr()), count, "marks, {choice}");
        assert_eq!(run(&|mesh| mesh.corner_normals = split.as_ptr()), count, "normals, {choice}");
        assert_eq!(run(&|mesh| mesh.corner_normals = whole.as_flattened().as_ptr()), 1, "one normal, {choice}");
    }
}

/// The sides of a square tube, each a quad of corners 4 i to 4 i + 3. Unrolled it is a square, so one cut along it is enough.
/// Side i meets the one before it at vertices i and i + 4, an edge that leaves corner 4 i + 3.
fn tube() -> Call {
    let rings = [0, 4].map(|z| [[0, 0, z], [1, 0, z], [1, 1, z], [0, 1, z]]);
    let positions = rings.as_flattened().as_flattened().iter().map(|x| f64::from(*x)).collect();
    let corners = (0..4).flat_map(|i| [i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4]).collect();
    Call::new(positions, corners, Some((0..=4).map(|side| 4 * side).collect()))
}

/// Sides of a tube that are cut off the one before them.
fn cuts(call: &mut Call) -> Vec<usize> {
    assert_eq!(call.run(), SEAMWRIGHT_OK);
    let uv = |corner: usize| [call.uv[2 * corner], call.uv[2 * corner + 1]];
    let meets = |i: usize, before: usize| uv(4 * i) == uv(4 * before + 1) && uv(4 * i + 3) == uv(4 * before + 2);
    (0..4).filter(|i| !meets(*i, (i + 3) % 4)).collect()
}

#[test]
fn a_free_edge_is_cut_and_forbidden_ones_are_not() {
    let weighted = |corner: fn(usize) -> usize, is_it: &dyn Fn(usize) -> bool, weight: f32| {
        let (mut call, mut weights) = (tube(), [f32::NAN; 16]);
        (0..4).filter(|side| is_it(*side)).for_each(|side| weights[corner(side)] = weight);
        call.mesh.edge_weights = weights.as_ptr();
        cuts(&mut call)
    };
    let (own, others) = (|side| 4 * side + 3, |side| 4 * ((side + 3) % 4) + 1);
    assert_eq!(cuts(&mut tube()).len(), 1);
    for chosen in 0..4 {
        assert_eq!(weighted(own, &|side| side == chosen, 0.0), [chosen]);
        assert_eq!(weighted(others, &|side| side == chosen, 0.0), [chosen]);
        assert_eq!(weighted(own, &|side| side != chosen, f32::INFINITY), [chosen]);
    }
}

#[test]
fn a_turn_that_the_tolerance_may_have_made_is_none() {
    // A kite that turns by 150 degrees at its last vertex, by 70 at the others.
    let kite = [[0.966, -0.259], [1.147, 0.0], [0.966, 0.259], [0.0, 0.0]];
    let told = |tolerance: f64| {
        let mut call = tube();
        for (i, [x, y]) in kite.into_iter().chain(kite).enumerate() {
            (call.positions[3 * i], call.positions[3 * i + 1]) = (x, y);
        }
        call.mesh.tolerance = tolerance;
        cuts(&mut call)
    };
    for exact in [0.0, 1e-6, -9.0, f64::NAN] {
        assert_eq!(told(exact), [3], "{exact}");
    }
    assert_ne!(told(9.0), [3]);
}
