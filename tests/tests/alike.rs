//! Copies of a piece get the same cuts and the same charts, made once.

use core::sync::atomic::AtomicBool;
use glam::DVec2;
use seamwright::formats::loaded::load;
use seamwright::mesh::polygons::Mesh;
use seamwright::run::threads::Pool;
use seamwright_core::base::progress::{Progress, Stage, Wish};
use seamwright_core::base::workers::{Serial, Workers};
use seamwright_core::pipeline::{Input, Packing, Report, Settings};
use seamwright_tests::road::{Atlas, input, judge, run_told, unsound};
use seamwright_tests::scenes::{Placed, Scene, scattered};
use seamwright_tests::seconds;
use seamwright_tests::solids::named;
use std::collections::BTreeMap;
use std::path::Path;

/// Two steps of the grid: what rounding to it moves a distance by, at the most.
const GRID: f64 = 2.0 / (1 << 24) as f64;

fn settings() -> Settings {
    Settings { rays: 64, effort: 0.1, ..Settings::default() }
}

/// Bodies of few and many faces, with handles, borders, sharp edges; a cow-like one whose charts no symmetry makes alike.
fn bodies() -> Vec<(&'static str, Mesh)> {
    let solids = ["pipe_n16_m8_b2_l10_quad_open", "belt_toothed_w2_n8_s3_r1_tri", "torus_n12_m8_t0.6_quad"];
    let fixtures = ["golden/quadruped", "golden/mug"];
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures");
    let of = |name: &str| load(&root.join(name).with_extension("obj")).expect("a fixture").mesh().clone();
    let solids = solids.map(|name| (name, named(name).expect("one of the family").mesh()));
    solids.into_iter().chain(fixtures.map(|name| (name, of(name)))).collect()
}

/// Hears how long the search took.
#[derive(Default)]
struct Search {
    began: Option<f64>,
    took: f64,
}

impl Progress for Search {
    fn report(&mut self, stage: Stage, _: usize, _: usize) -> Wish {
        match stage {
            Stage::Seams if self.began.is_none() => self.began = Some(seconds()),
            Stage::Pack => self.took = self.took.max(self.began.take().map_or(0.0, |began| seconds() - began)),
            _ => {}
        }
        Wish::GoOn
    }
}

fn unwrapped(scene: &Scene, settings: &Settings, workers: &dyn Workers) -> (Atlas, Report, f64) {
    let input = Input { tolerance: scene.mesh.tolerance, ..input(&scene.mesh) };
    let mut search = Search::default();
    let (atlas, report) =
        run_told(&input, settings, workers, 0, &mut search, &AtomicBool::new(false)).expect("an atlas");
    assert_eq!(unsound(&judge(&scene.mesh, &atlas), &atlas, &report), Vec::<String>::new());
    (atlas, report, search.took)
}

/// The charts of each body: polygons of the body, and the corners' UVs.
fn charts(body: &Mesh, scene: &Scene, atlas: &Atlas, k: usize) -> BTreeMap<Vec<usize>, Vec<DVec2>> {
    let mut members = BTreeMap::<u32, Vec<usize>>::new();
    for (p, at) in scene.polygon_of[k].iter().enumerate() {
        members.entry(atlas.polygon_chart[*at]).or_default().push(p);
    }
    let uv = |p: usize| body.polygon(p).map(|c| atlas.corner_uv[scene.corner_of[k][c]]);
    members.into_values().map(|members| (members.clone(), members.iter().flat_map(|p| uv(*p)).collect())).collect()
}

/// How far the points of `b` are from those of `a` after the best rotation, and the size of `a`.
fn gap(a: &[DVec2], b: &[DVec2]) -> (f64, f64) {
    let mean = |p: &[DVec2]| p.iter().sum::<DVec2>() / p.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let (mut dot, mut cross) = (0.0, 0.0);
    for (p, q) in a.iter().zip(b) {
        dot += (*q - mb).dot(*p - ma);
        cross += (*q - mb).perp_dot(*p - ma);
    }
    let turn = DVec2::new(dot, cross).normalize();
    let far = a.iter().zip(b).map(|(p, q)| (turn.rotate(*q - mb) - (*p - ma)).length()).fold(0.0, f64::max);
    (far, a.iter().map(|p| (*p - ma).length()).fold(0.0, f64::max))
}

/// The shapes of a body's charts, whichever polygons they are of: distances of the corners from the chart's middle, ascending.
/// What is its own image in a symmetry may be laid on its original in several ways.
fn shapes(charts: &BTreeMap<Vec<usize>, Vec<DVec2>>) -> Vec<Vec<f64>> {
    let shape = |uv: &Vec<DVec2>| {
        let middle = uv.iter().sum::<DVec2>() / uv.len() as f64;
        let mut away: Vec<f64> = uv.iter().map(|p| p.distance(middle)).collect();
        away.sort_by(f64::total_cmp);
        away
    };
    let mut out: Vec<Vec<f64>> = charts.values().map(shape).collect();
    // By corners, then size; what is nearer than that has the same shape.
    let size = |away: &Vec<f64>| (away.iter().sum::<f64>() * 1e4).round() as i64;
    out.sort_by_key(|away| (away.len(), size(away)));
    out
}

/// Whether charts have the same shapes, to 1e-6 of their size and the grid.
fn are_alike(a: &[Vec<f64>], b: &[Vec<f64>]) -> bool {
    let far = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let same = |(a, b): (&Vec<f64>, &Vec<f64>)| a.len() == b.len() && far(a, b) <= 1e-6 * a[a.len() - 1] + GRID;
    a.len() == b.len() && a.iter().zip(b).all(same)
}

#[test]
fn eight_copies_under_rigid_motions_have_the_same_chart_shapes() {
    for (name, body) in bodies() {
        for decimals in [None, Some(6)] {
            let scene = scattered(&[Placed { mesh: &body, mirrored: false }; 8], 1, decimals);
            let (atlas, report, _) = unwrapped(&scene, &settings(), &Serial);
            let of = |k: usize| charts(&body, &scene, &atlas, k);
            assert_eq!(report.chart_count, 8 * of(0).len(), "{name}");
            for k in 1..8 {
                assert!(are_alike(&shapes(&of(0)), &shapes(&of(k))), "{name}: copy {k}");
            }
        }
    }
}

#[test]
fn copies_without_symmetry_are_cut_at_the_same_edges_and_laid_out_corner_by_corner() {
    for (name, body) in bodies().split_off(3) {
        let scene = scattered(&[Placed { mesh: &body, mirrored: false }; 4], 5, Some(6));
        let (atlas, _, _) = unwrapped(&scene, &settings(), &Serial);
        let first = charts(&body, &scene, &atlas, 0);
        for k in 1..4 {
            let copy = charts(&body, &scene, &atlas, k);
            assert!(copy.keys().eq(first.keys()), "{name}: copy {k} is cut elsewhere");
            for (a, b) in first.values().zip(copy.values()) {
                let (gap, size) = gap(a, b);
                assert!(gap <= 1e-6 * size + GRID, "{name}: copy {k} differs by {gap} of {size}");
            }
        }
    }
}

#[test]
fn no_number_of_threads_changes_what_copies_become() {
    let (_, body) = bodies().remove(3);
    let scene = scattered(&[Placed { mesh: &body, mirrored: false }; 5], 2, None);
    let (atlas, _, _) = unwrapped(&scene, &settings(), &Serial);
    for threads in [2, 7] {
        let pool = Pool::new(Some(threads)).expect("threads");
        assert_eq!(unwrapped(&scene, &settings(), &pool).0, atlas, "{threads} threads");
    }
}

#[test]
fn eight_copies_are_searched_in_at_most_twice_the_time_of_one() {
    let (_, body) = bodies().remove(3);
    let took = |count: usize| {
        let scene = scattered(&vec![Placed { mesh: &body, mirrored: false }; count], 1, None);
        (0..3).map(|_| unwrapped(&scene, &settings(), &Serial).2).fold(f64::INFINITY, f64::min)
    };
    let (one, eight) = (took(1), took(8));
    println!("one {one:.3} s, eight {eight:.3} s");
    assert!(eight <= 2.0 * one, "{eight} s for eight, {one} s for one");
}

#[test]
fn crates_and_tyres_get_two_layouts() {
    let boxes = named("box_a1_r0_b0.2_quad").expect("a box").mesh();
    let tori = named("torus_n12_m8_t0.6_quad").expect("a torus").mesh();
    let bodies = [&boxes, &tori, &boxes, &tori, &tori, &boxes, &tori, &boxes];
    let scene = scattered(&bodies.map(|mesh| Placed { mesh, mirrored: false }), 3, Some(5));
    let (atlas, _, _) = unwrapped(&scene, &settings(), &Serial);
    let mut layouts: Vec<Vec<Vec<f64>>> = vec![];
    for (k, body) in bodies.iter().enumerate() {
        let own = shapes(&charts(body, &scene, &atlas, k));
        if !layouts.iter().any(|known| are_alike(known, &own)) {
            layouts.push(own);
        }
    }
    assert_eq!(layouts.len(), 2);
}

#[test]
fn what_differs_by_more_than_the_digits_is_no_copy() {
    let (_, body) = bodies().remove(3);
    let bent = Mesh {
        positions: body.positions.iter().map(|p| *p * glam::DVec3::new(1.0, 1.01, 1.0)).collect(),
        ..body.clone()
    };
    let scene = scattered(&[Placed { mesh: &body, mirrored: false }, Placed { mesh: &bent, mirrored: false }], 1, None);
    let on_grid = Settings { packing: Packing::Grid, ..settings() };
    let (atlas, _, _) = unwrapped(&scene, &on_grid, &Serial);
    let (a, b) = (charts(&body, &scene, &atlas, 0), charts(&body, &scene, &atlas, 1));
    let same = a.len() == b.len() && a.values().zip(b.values()).all(|(a, b)| a.len() == b.len() && gap(a, b).0 < 1e-5);
    assert!(!same);
}
