//! `repair` on exact small cases and on hostile ones; `many` has random polygons and real meshes.

mod many;
mod soup;

use crate::base::real;
use crate::base::scratch::Scratch;
use crate::mesh::repair::{Facing, RepairError, repair, repair_need};
use crate::mesh::working::{DIAGONAL, FORCED};
use core::f64::consts::TAU;
use glam::{DVec2, DVec3};
use soup::{Soup, assert_promises, cube, noise, surface, together};
use std::vec::Vec;
use std::{assert, assert_eq, vec};

#[test]
fn a_cube_of_quads_is_a_sphere_of_twelve_triangles() {
    let cube = cube([0.0; 3], 1.0);
    cube.repaired(|working, summary| {
        let euler = (summary.euler, summary.genus, summary.components, summary.boundary_loops);
        assert_eq!((working.faces.len(), working.positions.len(), euler), (12, 8, (2, 0, 1, 0)));
        assert_eq!((summary.flipped_faces, summary.split_edges, summary.split_vertices), (0, 0, 0));
        assert_eq!(working.corner_source[..6], [0, 1, 2, 0, 2, 3], "the fan of the first quad");
        assert_eq!(working.fixed.iter().filter(|f| **f == DIAGONAL).count(), 12);
        assert_eq!((working.centre, working.extent), (DVec3::splat(0.5), 1.0));
    });
}

#[test]
fn a_moebius_strip_is_cut_into_an_orientable_strip() {
    let strip = surface(24, 3, |i, j| {
        // Twice round the strip is the identity; the seam is welded because its points are computed alike.
        let (i, j) = if i == 24 { (0, 3 - j) } else { (i, j) };
        let (t, w) = (TAU * f64::from(i) / 24.0, f64::from(j) / 3.0 - 0.5);
        let r = 2.0 + w * real::cos(t / 2.0);
        [r * real::cos(t), r * real::sin(t), w * real::sin(t / 2.0)]
    });
    let summary = strip.summary();
    assert_eq!((summary.components, summary.euler, summary.boundary_loops), (1, 1, 1));
    assert_eq!((summary.split_edges, summary.flipped_faces), (3, 0), "cut where the input's faces disagree");
}

#[test]
fn a_klein_bottle_becomes_orientable() {
    let (n, m) = (20, 12);
    let bottle = surface(n, m, |i, j| {
        let (i, j) = if i == n { (0, (m - j) % m) } else { (i, j % m) };
        let (u, v) = (TAU * f64::from(i) / f64::from(n), TAU * f64::from(j) / f64::from(m));
        let r = 3.0 + real::cos(u / 2.0) * real::sin(v) - real::sin(u / 2.0) * real::sin(2.0 * v);
        let z = real::sin(u / 2.0) * real::sin(v) + real::cos(u / 2.0) * real::sin(2.0 * v);
        [r * real::cos(u), r * real::sin(u), z]
    });
    let summary = bottle.summary();
    assert_eq!((summary.components, summary.euler, summary.boundary_loops, summary.genus), (1, 0, 2, 0));
}

#[test]
fn of_a_book_of_five_pages_the_flattest_two_stay_together() {
    let mut positions = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    // Pages at these degrees around the spine; the first and the fourth lie flat and run in opposite directions.
    for degrees in [0.0, 40.0, 90.0, 181.0, 300.0] {
        let t = TAU * degrees / 360.0;
        positions.push([real::cos(t), real::sin(t), 0.5]);
    }
    let book = Soup::new(&positions, &[&[0, 1, 2], &[0, 1, 3], &[0, 1, 4], &[1, 0, 5], &[0, 1, 6]]);
    book.repaired(|working, summary| {
        assert_eq!((summary.components, summary.split_edges, summary.flipped_faces), (4, 1, 0));
        assert_eq!(working.component, [0, 1, 2, 0, 3]);
        assert_eq!(summary.split_vertices, 2 * 3);
    });
}

#[test]
fn two_boxes_that_touch_along_an_edge_stay_two_boxes() {
    let boxes = together(&[cube([0.0; 3], 1.0), cube([1.0, 1.0, 0.0], 1.0)]);
    let summary = boxes.summary();
    assert_eq!((summary.welded_vertices, summary.components, summary.euler), (2, 2, 4));
    assert_eq!((summary.split_edges, summary.split_vertices, summary.boundary_loops), (0, 2, 0));
}

#[test]
fn crossing_sheets_stay_whole_sheets() {
    let positions = [[0., 0., 0.], [0., 0., 1.], [1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.]];
    let cross = Soup::new(&positions, &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4], &[1, 0, 5]]);
    cross.repaired(|working, summary| {
        assert_eq!((working.component, summary.split_edges), (&[0, 0, 1, 1][..], 0));
    });
}

#[test]
fn an_hourglass_vertex_becomes_two() {
    let positions = [[0., 0., 0.], [1., 0., 1.], [0., 1., 1.], [-1., -1., 1.], [1., 0., -1.], [-1., 1., -1.]];
    let glass = Soup::new(&positions, &[&[0, 1, 2], &[0, 2, 3], &[0, 3, 1], &[0, 5, 4]]);
    glass.repaired(|working, summary| {
        assert_eq!((summary.components, summary.split_vertices, summary.split_edges), (2, 1, 0));
        assert_eq!(working.vertex_source.iter().filter(|v| **v == 0).count(), 2);
    });
}

#[test]
fn copies_of_a_face_are_sheets_of_their_own() {
    let mut copied = cube([0.0; 3], 1.0);
    copied.push(&[2, 3, 1, 0]); // the first side again, from another corner
    copied.push(&[0, 1, 3, 2]); // and from behind
    copied.repaired(|working, summary| {
        assert_eq!((summary.components, summary.flipped_faces), (3, 0));
        assert_eq!(working.component[..12], [0; 12]);
        assert_eq!(summary.split_edges, 4);
    });
    let pair = Soup::new(&[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], &[&[0, 1, 2], &[0, 2, 1], &[1, 2, 0]]);
    assert_eq!(pair.summary().components, 3);
}

#[test]
fn a_double_sided_sheet_is_two_sheets() {
    let at = |i: u32, j: u32| [f64::from(i), f64::from(j), 0.0];
    let front = surface(4, 3, at);
    let mut back = front.clone();
    back.corners.reverse();
    let summary = together(&[front, back]).summary();
    assert_eq!((summary.components, summary.boundary_loops, summary.flipped_faces), (2, 2, 0));
}

#[test]
fn thirty_two_copies_are_as_many_sheets_and_beyond_that_polygons_stand_alone() {
    let sheet = surface(10, 10, |i, j| [f64::from(i), f64::from(j), f64::from(i * j)]);
    let copies = |count| together(&vec![sheet.clone(); count]);
    assert_eq!(copies(32).summary().components, 32);
    let crowd = copies(33).summary();
    assert_eq!((crowd.components, crowd.flipped_faces), (3300, 0));
}

#[test]
fn a_t_junction_stays_open() {
    let positions = [[0., 0., 0.], [2., 0., 0.], [1., 1., 0.], [1., 0., 0.], [1., -1., 0.]];
    let junction = Soup::new(&positions, &[&[0, 1, 2], &[3, 0, 4], &[1, 3, 4]]);
    let summary = junction.summary();
    assert_eq!((summary.components, summary.boundary_loops, summary.split_edges), (2, 2, 0));
}

#[test]
fn the_lesser_part_is_turned_round() {
    let mut grid = surface(6, 6, |i, j| [f64::from(i), f64::from(j), 0.0]);
    for turned in [3, 7, 8, 20, 35] {
        grid.corners[4 * turned..4 * turned + 4].reverse();
    }
    grid.repaired(|working, summary| {
        assert_eq!((summary.flipped_faces, summary.components, summary.boundary_loops), (10, 1, 1));
        let up = (0..working.faces.len()).all(|f| working.mesh().area_vector(f).z > 0.0);
        assert!(up);
        // The corners of a turned face still name the corners of the file.
        for (c, &source) in working.corner_source.iter().enumerate() {
            let p = working.mesh().position(c as u32) * working.extent + working.centre;
            assert!(p.distance(grid.positions[grid.corners[source as usize] as usize]) < 1e-14);
        }
    });
    let mut bytes = vec![0u8; repair_need(&grid.view().counts())];
    let (working, summary) = repair(&grid.view(), Facing::AsGiven, &mut Scratch::new(&mut bytes)).unwrap();
    assert_promises(&grid, &working, &summary);
    assert_eq!((summary.flipped_faces, summary.components), (0, 5), "7 and 8 are neighbours");
    grid.corners.reverse();
    assert_eq!(grid.summary().flipped_faces, 10);
}

#[test]
fn concave_polygons_are_triangulated_and_their_diagonals_hold() {
    let l = [[0., 0., 0.], [2., 0., 0.], [2., 1., 0.], [1., 1., 0.], [1., 2., 0.], [0., 2., 0.]];
    Soup::new(&l, &[&[2, 3, 4, 5, 0, 1]]).repaired(|working, summary| {
        assert_eq!((working.faces.len(), summary.components, summary.euler), (4, 1, 1));
        assert!((0..4).all(|f| working.mesh().area_vector(f).z > 0.0));
        assert_eq!(working.fixed.iter().filter(|f| **f == DIAGONAL).count(), 6);
    });
}

#[test]
fn repeats_spikes_and_pinches_leave_simple_rings() {
    let positions = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [2., 2., 0.], [3., 2., 0.], [2., 3., 0.]];
    let square = |polygon: &[u32]| {
        Soup::new(&positions, &[polygon]).repaired(|w, s| (w.faces.len(), s.dropped_triangles, s.components))
    };
    assert_eq!(square(&[0, 1, 2, 3]), (2, 0, 1));
    assert_eq!(square(&[0, 0, 1, 2, 2, 3, 3, 0]), (2, 4, 1));
    assert_eq!(square(&[0, 1, 4, 1, 2, 3]), (2, 2, 1));
    assert_eq!(square(&[4, 1, 2, 3, 0, 1]), (2, 2, 1), "a spike at the beginning");
    assert_eq!(square(&[1, 2, 3, 0, 1, 4]), (2, 2, 1), "a spike at the end");
    assert_eq!(square(&[0, 1, 2, 4, 5, 6, 4, 2, 3]), (3, 4, 2), "two rings and a bridge");
    assert_eq!(square(&[0, 1, 2, 5, 6, 2, 3]), (3, 2, 2), "two rings that touch");
}

#[test]
fn a_hole_joined_by_a_slit_is_a_ring_around_it() {
    let mut frame = Soup::default();
    for r in [2.0, 1.0] {
        frame.positions.extend([(-r, -r), (r, -r), (r, r), (-r, r)].map(|(x, y)| DVec3::new(x, y, 0.0)));
    }
    frame.push(&[0, 1, 2, 3, 0, 4, 7, 6, 5, 4]);
    let summary = frame.summary();
    assert_eq!((summary.components, summary.boundary_loops, summary.euler), (1, 2, 0));
}

#[test]
fn flat_faces_stay_and_faces_with_a_vertex_twice_go() {
    let positions = [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [1., 1., 0.], [0., 0., -0.0]];
    let soup = Soup::new(&positions, &[&[0, 1, 2], &[0, 2, 3], &[0, 4, 1], &[1, 2], &[]]);
    let summary = soup.summary();
    assert_eq!((summary.flat_faces, summary.dropped_triangles, summary.dropped_polygons), (1, 1, 3));
    assert_eq!((summary.welded_vertices, summary.components), (1, 1));
}

#[test]
fn borders_of_kept_uvs_are_forced_where_both_sides_have_uvs_that_differ() {
    let mut grid = surface(3, 1, |i, j| [f64::from(i), f64::from(j), 0.0]);
    let mut uv: Vec<_> = grid.corners.iter().map(|v| grid.positions[*v as usize].truncate()).collect();
    uv[5] += 0.5; // the second quad's corner away from the first
    uv[8] = DVec2::NAN;
    grid.uv = Some(uv.clone());
    let forced = |grid: &Soup| {
        grid.repaired(|working, _| {
            let forced = (0..working.twin.len()).filter(|h| working.fixed[*h] == FORCED);
            forced.map(|h| working.polygon[h / 3]).collect::<Vec<_>>()
        })
    };
    assert_eq!(forced(&grid), [], "no UV in the third");
    uv[8] = uv[5] - 0.5;
    grid.uv = Some(uv);
    assert_eq!(forced(&grid), [1, 2]);
}

#[test]
fn scaling_by_a_power_of_two_changes_no_bit() {
    let soup = noise(5, 60, 40);
    let look = |soup: &Soup| {
        soup.repaired(|w, s| (w.positions.to_vec(), w.faces.to_vec(), w.twin.to_vec(), w.corner_source.to_vec(), *s))
    };
    for scale in [0.125, 1024.0, real::pow(2.0, -300.0), real::pow(2.0, 1020.0)] {
        let mut scaled = soup.clone();
        scaled.positions.iter_mut().for_each(|p| *p *= scale);
        assert_eq!(look(&soup), look(&scaled), "{scale}");
    }
}

#[test]
fn the_whole_range_of_f64_is_taken() {
    let m = f64::MAX;
    let positions = [[-m, -m, 0.], [m, -m, 0.], [m, m, 0.], [-m, m, 0.]];
    let mut bytes = vec![0u8; 4096];
    let soup = Soup::new(&positions, &[&[0, 1, 2, 3]]);
    let (working, summary) = repair(&soup.view(), Facing::Turned, &mut Scratch::new(&mut bytes)).unwrap();
    assert_eq!((working.positions[0], summary.flat_faces), (DVec3::new(-0.5, -0.5, 0.0), 0));
    let tiny = f64::from_bits(1);
    let soup = Soup::new(&[[0.; 3], [tiny, 0., 0.], [0., tiny, 0.]], &[&[0, 1, 2]]);
    let (working, _) = repair(&soup.view(), Facing::Turned, &mut Scratch::new(&mut bytes)).unwrap();
    assert!(working.positions.iter().all(|p| p.is_finite()));
}

#[test]
fn what_is_not_a_mesh_is_refused_with_the_reason() {
    let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [f64::NAN, 0., 0.]];
    assert_eq!(Soup::default().error(), RepairError::NoTriangle);
    assert_eq!(Soup::new(&corners, &[&[0, 1], &[0, 1, 0], &[2, 2, 2, 2]]).error(), RepairError::NoTriangle);
    assert_eq!(Soup::new(&corners, &[&[0, 1, 2], &[0, 1, 4]]).error(), RepairError::BadIndex { corner: 5 });
    assert_eq!(Soup::new(&corners, &[&[0, 1, 2], &[0, 1, 3]]).error(), RepairError::NotFinite { vertex: 3 });
    assert_eq!(Soup::new(&corners, &[&[0, 1, 2]]).summary().components, 1, "nobody names the bad vertex");
    for starts in [vec![0, 9], vec![3, 0], vec![0, 3, 2], vec![7, 7]] {
        let mut soup = Soup::new(&corners, &[&[0, 1, 2]]);
        soup.polygon_start = starts;
        assert!(matches!(soup.error(), RepairError::BadIndex { .. } | RepairError::NoTriangle));
    }
}
