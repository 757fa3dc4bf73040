//! Copies and mirror images laid over one another on purpose: fewer texels, no fault, and partial overlap stays one.

use core::sync::atomic::AtomicBool;
use glam::{DVec2, DVec3};
use seamwright::certificate::verdict::{Rules, verdict};
use seamwright::formats::loaded::load;
use seamwright::mesh::polygons::Mesh;
use seamwright::run::threads::Pool;
use seamwright_core::base::progress::Silent;
use seamwright_core::base::workers::{Serial, Workers};
use seamwright_core::pipeline::{Input, Packing, Report, Settings, Stacking};
use seamwright_tests::road::{Atlas, input, judge, run_told};
use seamwright_tests::scenes::{Placed, Scene, scattered};
use seamwright_tests::shapes::{book, mesh, pear};
use std::path::Path;

/// An animal of 500 faces that no symmetry of its mesh maps to itself.
fn body() -> Mesh {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/golden/quadruped.obj");
    load(&file).expect("a fixture").mesh().clone()
}

fn scene(body: &Mesh, mirrored: &[bool]) -> Scene {
    let bodies: Vec<Placed> = mirrored.iter().map(|m| Placed { mesh: body, mirrored: *m }).collect();
    scattered(&bodies, 4, Some(6))
}

fn unwrapped(scene: &Scene, stack: Stacking, stack_offset: u32, workers: &dyn Workers) -> (Atlas, Report) {
    let input = Input { tolerance: scene.mesh.tolerance, ..input(&scene.mesh) };
    let settings = Settings { rays: 64, effort: 0.1, stack, stack_offset, ..Settings::default() };
    run_told(&input, &settings, workers, 0, &mut Silent, &AtomicBool::new(false)).expect("an atlas")
}

/// Unwrapped again with the seams of `atlas` kept.
fn kept(scene: &mut Scene, atlas: &Atlas, stack: Stacking) -> (Atlas, Report) {
    scene.mesh.corner_uv = Some(atlas.corner_uv.clone());
    let told =
        Input { kept_uv: scene.mesh.corner_uv.as_deref(), tolerance: scene.mesh.tolerance, ..input(&scene.mesh) };
    let settings = Settings { rays: 64, effort: 0.1, stack, ..Settings::default() };
    run_told(&told, &settings, &Serial, 0, &mut Silent, &AtomicBool::new(false)).expect("an atlas")
}

/// UV of each corner of body `k`.
fn uv_of(scene: &Scene, atlas: &Atlas, k: usize) -> Vec<DVec2> {
    scene.corner_of[k].iter().map(|c| atlas.corner_uv[*c]).collect()
}

/// Texels that are used, over those of one body: how often its area fits into what charts cover.
fn bodies_worth(body: &Mesh, scene: &Scene, atlas: &Atlas, report: &Report) -> f64 {
    let uv = uv_of(scene, atlas, 0);
    let doubled = |at: core::ops::Range<usize>| {
        let points = &uv[at];
        (0..points.len()).map(|i| points[i].perp_dot(points[(i + 1) % points.len()])).sum::<f64>().abs()
    };
    report.utilisation / (0.5 * body.polygons().map(doubled).sum::<f64>())
}

#[test]
fn four_copies_take_the_texels_of_one_and_lie_upon_it_corner_by_corner() {
    let body = body();
    let scene = scene(&body, &[false; 4]);
    let (apart, stacked) =
        (unwrapped(&scene, Stacking::Off, 0, &Serial), unwrapped(&scene, Stacking::Same, 0, &Serial));
    let worth = |(atlas, report): &(Atlas, Report)| bodies_worth(&body, &scene, atlas, report);
    let share = worth(&stacked) / worth(&apart);
    assert!((share - 0.25).abs() <= 0.05 * 0.25, "{share}");
    let (atlas, report) = &stacked;
    for k in 1..4 {
        assert_eq!(uv_of(&scene, atlas, k), uv_of(&scene, atlas, 0), "copy {k}");
    }
    let m = judge(&scene.mesh, atlas);
    assert_eq!((m.exact.overlapping_faces, m.exact.flipped_faces, m.charts.mirrored), (0, 0, 0));
    assert_eq!((report.chart_count, report.stacked), (m.charts.count, m.stacked.charts));
    assert_eq!(4 * m.stacked.charts, 3 * m.charts.count);
    assert!(report.distortion <= Settings::default().distortion, "{}", report.distortion);
    for threads in [2, 7] {
        let pool = Pool::new(Some(threads)).expect("threads");
        assert_eq!(unwrapped(&scene, Stacking::Same, 0, &pool).0, *atlas, "{threads} threads");
    }
}

#[test]
fn mirror_images_share_texels_where_that_is_asked_for_and_not_before() {
    let body = body();
    let scene = scene(&body, &[false, true]);
    let apart = unwrapped(&scene, Stacking::Same, 0, &Serial);
    assert_eq!(apart.1.stacked, 0, "mirror images are told apart");
    let (atlas, report) = unwrapped(&scene, Stacking::Mirrored, 0, &Serial);
    let share = bodies_worth(&body, &scene, &atlas, &report) / bodies_worth(&body, &scene, &apart.0, &apart.1);
    assert!((share - 0.5).abs() <= 0.05 * 0.5, "{share}");
    assert_eq!(uv_of(&scene, &atlas, 0), uv_of(&scene, &atlas, 1));
    let m = judge(&scene.mesh, &atlas);
    assert_eq!((m.exact.overlapping_faces, m.exact.flipped_faces, m.charts.flipped_faces), (0, 0, 0));
    assert_eq!((2 * m.charts.mirrored, 2 * m.stacked.charts), (m.charts.count, m.charts.count));
    assert!(report.distortion <= Settings::default().distortion, "{}", report.distortion);
}

#[test]
fn an_offset_moves_all_but_the_first_one_square_to_the_right() {
    let body = body();
    let scene = scene(&body, &[false; 3]);
    let (atlas, _) = unwrapped(&scene, Stacking::Same, 1, &Serial);
    for k in 1..3 {
        let back: Vec<DVec2> = uv_of(&scene, &atlas, k).iter().map(|p| *p - DVec2::X).collect();
        assert_eq!(back, uv_of(&scene, &atlas, 0));
    }
    // As a file of floats has them.
    let floats = atlas.corner_uv.iter().map(|p| p.as_vec2().as_dvec2()).collect();
    let mesh = Mesh { corner_uv: Some(floats), ..scene.mesh };
    assert_eq!(verdict(&mesh, Rules { stacks: true, ..Rules::default() }).faults, []);
}

#[test]
fn judges_know_a_stack_from_a_fault() {
    let body = body();
    for mirrored in [[false, false], [false, true]] {
        let scene = scene(&body, &mirrored);
        let (mut atlas, _) = unwrapped(&scene, Stacking::Mirrored, 0, &Serial);
        let faults = |atlas: &Atlas, stacks: bool| {
            let mesh = Mesh { corner_uv: Some(atlas.corner_uv.clone()), ..scene.mesh.clone() };
            verdict(&mesh, Rules { stacks, ..Rules::default() }).faults.len()
        };
        assert_eq!(faults(&atlas, true), 0);
        assert!(faults(&atlas, false) > 0, "where nobody asked for it, it is one");
        // All of the second body a little to the side: its charts overlap those of the first in part.
        scene.corner_of[1].iter().for_each(|c| atlas.corner_uv[*c] *= 0.99);
        let m = judge(&scene.mesh, &atlas);
        assert!(m.exact.overlapping_faces > 100 && m.stacked.charts == 0, "{:?}", m.exact);
        assert!(faults(&atlas, true) > 0);
    }
}

#[test]
fn a_piece_that_is_its_own_mirror_image_lies_folded_in_its_plane() {
    let (pear, mirror) = pear();
    let one = Placed { mesh: &pear, mirrored: false };
    let scene = scattered(&[one], 5, Some(6));
    let (atlas, report) = unwrapped(&scene, Stacking::Mirrored, 0, &Serial);
    let uv = uv_of(&scene, &atlas, 0);
    assert_eq!(mirror.iter().map(|c| uv[*c]).collect::<Vec<_>>(), uv);
    let m = judge(&scene.mesh, &atlas);
    assert_eq!((m.exact.overlapping_faces, m.exact.flipped_faces, m.charts.flipped_faces), (0, 0, 0));
    assert_eq!((report.chart_count, report.stacked), (m.charts.count, m.stacked.charts));
    assert_eq!((2 * m.stacked.charts, 2 * m.stacked.faces), (m.charts.count, m.faces));
    assert!(report.distortion <= Settings::default().distortion, "{}", report.distortion);
    // Charts have scales of their own in a grid.
    let settings = Settings { stack: Stacking::Mirrored, packing: Packing::Grid, rays: 64, ..Settings::default() };
    let told = Input { tolerance: scene.mesh.tolerance, ..input(&scene.mesh) };
    let (_, grid) = run_told(&told, &settings, &Serial, 0, &mut Silent, &AtomicBool::new(false)).expect("an atlas");
    assert!((grid.distortion - report.distortion).abs() < 1e-4, "{} {}", grid.distortion, report.distortion);
    // Half of the texels, and no seam in the plane.
    let apart = unwrapped(&scene, Stacking::Same, 0, &Serial);
    let share = bodies_worth(&pear, &scene, &atlas, &report) / bodies_worth(&pear, &scene, &apart.0, &apart.1);
    assert!((share - 0.5).abs() <= 0.05 * 0.5, "{share}");
    let whole = judge(&scene.mesh, &apart.0);
    assert!(whole.seams.length > 1.3 * m.seams.length, "{} {}", whole.seams.length, m.seams.length);
    let mesh = Mesh { corner_uv: Some(atlas.corner_uv.clone()), ..scene.mesh.clone() };
    let faults = |stacks| verdict(&mesh, Rules { stacks, ..Rules::default() }).faults.len();
    assert!(faults(true) == 0 && faults(false) > 0);
}

#[test]
fn folded_copies_lie_on_one_half_of_the_first() {
    let (pear, mirror) = pear();
    let scene = scattered(&[false, true, false].map(|mirrored| Placed { mesh: &pear, mirrored }), 7, Some(6));
    let (atlas, report) = unwrapped(&scene, Stacking::Mirrored, 0, &Serial);
    let first = uv_of(&scene, &atlas, 0);
    for k in 1..3 {
        let uv = uv_of(&scene, &atlas, k);
        assert!(uv == first || mirror.iter().map(|c| uv[*c]).eq(first.iter().copied()), "copy {k}");
    }
    assert_eq!(6 * (report.chart_count - report.stacked), report.chart_count);
    assert_eq!(judge(&scene.mesh, &atlas).exact.overlapping_faces, 0);
}

#[test]
fn halves_that_differ_and_kept_uvs_are_left_whole() {
    let (mut pear, _) = pear();
    let whole = Placed { mesh: &pear, mirrored: false };
    let mut scene = scattered(&[whole], 5, Some(6));
    let (atlas, _) = unwrapped(&scene, Stacking::Off, 0, &Serial);
    assert_eq!(kept(&mut scene, &atlas, Stacking::Mirrored).1.stacked, 0);
    // A dent of a tenth on one side.
    pear.positions[40] *= 0.9;
    let scene = scattered(&[Placed { mesh: &pear, mirrored: false }], 5, Some(6));
    assert_eq!(unwrapped(&scene, Stacking::Mirrored, 0, &Serial).1.stacked, 0);
}

#[test]
fn quads_that_are_parted_the_other_way_fold_all_the_same() {
    let (pear, _) = pear();
    // Triangles, from the first corner of a polygon in front and from the second of one behind.
    let half = pear.polygon_count() / 2;
    let triangles: Vec<Vec<u32>> = (0..pear.polygon_count())
        .flat_map(|p| {
            let mut corners = pear.corners[pear.polygon(p)].to_vec();
            corners.rotate_left(usize::from(p >= half));
            (1..corners.len() - 1).map(|i| vec![corners[0], corners[i], corners[i + 1]]).collect::<Vec<_>>()
        })
        .collect();
    let pear = mesh(pear.positions, &triangles);
    let scene = scattered(&[Placed { mesh: &pear, mirrored: false }], 5, Some(6));
    let (atlas, report) = unwrapped(&scene, Stacking::Mirrored, 0, &Serial);
    let m = judge(&scene.mesh, &atlas);
    assert_eq!((m.exact.overlapping_faces, m.exact.flipped_faces, m.charts.flipped_faces), (0, 0, 0));
    assert_eq!((report.chart_count, report.stacked), (m.charts.count, m.stacked.charts));
    assert_eq!((2 * m.stacked.charts, 2 * m.stacked.faces), (m.charts.count, m.faces));
    assert!(report.distortion <= Settings::default().distortion, "{}", report.distortion);
    let mesh = Mesh { corner_uv: Some(atlas.corner_uv), ..scene.mesh };
    assert_eq!(verdict(&mesh, Rules { stacks: true, ..Rules::default() }).faults, []);
}

#[test]
fn a_piece_with_a_quad_that_does_not_fold_over_its_other_diagonal_stays_whole() {
    // A quad p s q r whose angle at p is above 180 degrees, and its mirror image in the upright plane through q and r.
    let at = DVec3::new;
    let [p, s, q, r] = [at(0.0, 0.1, 0.05), at(1.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(-1.0, 0.0, 0.0)];
    let behind = |v: DVec3| at(v.y - 1.0, v.x + 1.0, v.z);
    let folded = |behind_faces: [Vec<u32>; 2]| {
        let faces = [vec![vec![0, 1, 2], vec![0, 2, 3]], behind_faces.to_vec()].concat();
        let kite = mesh(vec![p, s, q, r, behind(p), behind(s)], &faces);
        let scene = scattered(&[Placed { mesh: &kite, mirrored: false }], 5, Some(9));
        let (atlas, report) = unwrapped(&scene, Stacking::Mirrored, 0, &Serial);
        let m = judge(&scene.mesh, &atlas);
        assert_eq!((m.exact.overlapping_faces, m.exact.flipped_faces, report.flipped), (0, 0, 0));
        report.stacked
    };
    assert_eq!(folded([vec![4, 2, 5], vec![4, 3, 2]]), 1);
    assert_eq!(folded([vec![4, 3, 5], vec![5, 3, 2]]), 0);
}

#[test]
fn pages_that_share_an_edge_lie_on_one_another() {
    let book = book();
    let scene = scattered(&[Placed { mesh: &book, mirrored: false }], 5, Some(6));
    let (atlas, report) = unwrapped(&scene, Stacking::Mirrored, 0, &Serial);
    assert_eq!(report.chart_count, report.stacked + 1);
    let mesh = Mesh { corner_uv: Some(atlas.corner_uv), ..scene.mesh };
    assert_eq!(verdict(&mesh, Rules { stacks: true, ..Rules::default() }).faults, []);
}

#[test]
fn kept_charts_that_are_alike_lie_on_one_another() {
    let body = body();
    let mut scene = scene(&body, &[false; 4]);
    let (apart, first) = unwrapped(&scene, Stacking::Off, 0, &Serial);
    let (atlas, report) = kept(&mut scene, &apart, Stacking::Same);
    assert_eq!((report.chart_count, 4 * report.stacked), (first.chart_count, 3 * first.chart_count));
    assert!((report.distortion - first.distortion).abs() < 1e-6, "{} {}", report.distortion, first.distortion);
    let m = judge(&scene.mesh, &atlas);
    assert_eq!((m.exact.overlapping_faces, m.exact.flipped_faces, m.stacked.charts), (0, 0, report.stacked));
}

#[test]
fn where_kept_uvs_are_folded_over_both_halves_are_kept() {
    let (pear, _) = pear();
    let mut scene = scattered(&[Placed { mesh: &pear, mirrored: false }], 5, Some(6));
    let (folded, first) = unwrapped(&scene, Stacking::Mirrored, 0, &Serial);
    for stack in [Stacking::Off, Stacking::Mirrored] {
        let (atlas, report) = kept(&mut scene, &folded, stack);
        let stacked = if stack == Stacking::Off { 0 } else { first.stacked };
        assert_eq!((report.chart_count, report.stacked), (first.chart_count, stacked), "{stack:?}");
        assert!((report.distortion - first.distortion).abs() < 1e-6, "{} {}", report.distortion, first.distortion);
        let m = judge(&scene.mesh, &atlas);
        assert_eq!((m.exact.overlapping_faces, m.exact.flipped_faces), (0, 0));
    }
}

#[test]
fn faces_that_a_file_has_twice_are_laid_apart() {
    let (pear, _) = pear();
    let twice: Vec<Vec<u32>> = (0..2).flat_map(|_| pear.polygons()).map(|at| pear.corners[at].to_vec()).collect();
    let twice = mesh(pear.positions, &twice);
    let scene = scattered(&[Placed { mesh: &twice, mirrored: false }], 5, Some(6));
    let (atlas, report) = unwrapped(&scene, Stacking::Same, 0, &Serial);
    let m = judge(&scene.mesh, &atlas);
    assert_eq!((report.stacked, m.exact.overlapping_faces, m.exact.flipped_faces), (0, 0, 0));
    let mesh = Mesh { corner_uv: Some(atlas.corner_uv), ..scene.mesh };
    assert_eq!(verdict(&mesh, Rules { stacks: true, ..Rules::default() }).faults, []);
}
