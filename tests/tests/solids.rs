//! Simple solids unwrap: valid atlases within the bound, and few charts where few suffice.
//!
//! Each run takes the random thousand and a part of the family in which any two parameters meet. What fails today stands in
//! [`KNOWN`]: the suite fails where anything else does, and where something listed does no more, so that the list can
//! only shrink.
//!
//! SOLIDS=PATTERN takes every solid of the family and of chance whose name matches (`*` for anything), as the command packs
//! them, and prints and counts all that fail, whatever the list says. All of them take ten minutes on two cores:
//!
//!     SOLIDS='*' cargo test --release -p seamwright-tests --test solids -- --nocapture simple

use glam::DVec3;
use seamwright::mesh::polygons::Mesh;
use seamwright_core::base::workers::Serial;
use seamwright_core::pipeline::{Packing, Settings};
use seamwright_tests::fixtures::{check, nets};
use seamwright_tests::road::{judge, run, unsound};
use seamwright_tests::solids::{Solid, covering, family, matches, random};
use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{env, thread};

/// UVs on a grid of 2^-24 move the mean distortion by about 1e-7.
const BOUND_SLACK: f64 = 1e-6;

/// What fails, by what goes wrong.
const KNOWN: &[(&str, &[&str])] = &[
    (
        "a pole a hundred times as long as wide is cut into more than four charts, since one strip would leave the square empty",
        &["cylinder_n12_a100_ngon_tri_r5_closed"],
    ),
    (
        "the outer side of a ring is cut once more along a sharp edge, since as one strip it would set how wide the square is",
        &["tube_n5_a0.1_w0.5_tri_closed", "tube_n8_a0.1_w0.5_quad_closed"],
    ),
    (
        "flat rings that are still joined to a side, and so distorted, are split for their empty hull",
        &[
            "tube_n128_a0.1_w0.1_tri_half",
            "tube_n24_a0.01_w0.1_tri_half",
            "tube_n32_a0.01_w0.1_tri_half",
            "tube_n6_a0.03_w0.1_tri_half",
            "tube_n6_a0.1_w0.1_quad_half",
            "tube_n7_a0.03_w0.1_tri_closed",
        ],
    ),
];

/// What is wrong with the atlas of `solid`; nothing where it is as promised.
fn faults(solid: &Solid, packing: Packing) -> Vec<String> {
    // Validity and the number of charts hang neither on how finely exposure is sampled nor on how tightly charts are packed.
    let settings = Settings { rays: 16, effort: 0.0, packing, ..Settings::default() };
    let mesh = solid.mesh();
    let (atlas, report) = match run(&mesh, &settings, &Serial, 0) {
        Ok(made) => made,
        Err(e) => return vec![e.to_string()],
    };
    let judged = judge(&mesh, &atlas);
    let mut out = unsound(&judged, &atlas, &report);
    // In cells of a grid each chart has a scale of its own, so there the distortion is core's own figure.
    let by_judge = judged.distortion.symmetric_dirichlet / 4.0;
    let held = |distortion: f64| (1.0 - 1e-9..=settings.distortion * (1.0 + BOUND_SLACK)).contains(&distortion);
    if !held(report.distortion) || packing == Packing::Tight && !held(by_judge) {
        out.push(format!("distortion: {}, by the judge {by_judge}", report.distortion));
    }
    if solid.most_charts.is_some_and(|most| report.chart_count > most) {
        out.push(format!("charts: {}", report.chart_count));
    }
    out
}

/// Each solid that fails, with what is wrong, in the order of names.
fn failing(solids: &[(Solid, Packing)]) -> Vec<(String, String)> {
    let (next, found) = (AtomicUsize::new(0), Mutex::new(vec![]));
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, |n| n.get()) {
            scope.spawn(|| {
                while let Some((solid, packing)) = solids.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let faults = faults(solid, *packing);
                    if !faults.is_empty() {
                        found.lock().expect("no panic").push((solid.name.clone(), faults.join("; ")));
                    }
                }
            });
        }
    });
    let mut found = found.into_inner().expect("no panic");
    found.sort();
    found
}

#[test]
fn simple_solids_have_sound_atlases() {
    let tight = |solid| (solid, Packing::Tight);
    if let Ok(pattern) = env::var("SOLIDS") {
        let all = family().into_iter().chain(random());
        let wanted: Vec<_> = all.filter(|solid| matches(&solid.name, &pattern)).map(tight).collect();
        let found = failing(&wanted);
        found.iter().for_each(|(name, what)| println!("{name}: {what}"));
        assert!(found.is_empty(), "{} of {} fail", found.len(), wanted.len());
        return;
    }
    // Packing four triangles tightly takes fifty times as long as all else.
    let by_chance = random().into_iter().map(|solid| (solid, Packing::Grid));
    let solids: Vec<_> = covering(family()).into_iter().map(tight).chain(by_chance).collect();
    let found = failing(&solids);
    let known: Vec<&str> = KNOWN.iter().flat_map(|(_, names)| names.iter().copied()).collect();
    let new: Vec<_> = found.iter().filter(|(name, _)| !known.contains(&name.as_str())).collect();
    assert!(new.is_empty(), "of {} solids these fail and are not in the list: {new:#?}", solids.len());
    let fails = |name: &str| found.iter().any(|(other, _)| other == name);
    let mended: Vec<_> = known.into_iter().filter(|name| !fails(name)).collect();
    assert!(mended.is_empty(), "these fail no more: take them off the list: {mended:#?}");
}

/// The polygons' fans, as the fixtures' checks take a mesh.
fn fans(mesh: &Mesh) -> nets::Mesh {
    let corner = |c: usize| mesh.corners[c];
    let faces = mesh
        .polygons()
        .flat_map(|at| (at.start + 1..at.end - 1).map(move |c| [at.start, c, c + 1].map(corner)).collect::<Vec<_>>());
    nets::Mesh { positions: mesh.positions.clone(), faces: faces.collect() }
}

/// Edges of a fan triangulation whose two triangles lie on each other: none but where a polygon is concave.
fn folds(mesh: &nets::Mesh) -> usize {
    let normal = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| mesh.positions[v as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let sides = |f: &[u32; 3]| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]];
    let normals: HashMap<[u32; 2], DVec3> = mesh.faces.iter().flat_map(|f| sides(f).map(|s| (s, normal(f)))).collect();
    normals.iter().filter(|([a, b], n)| normals.get(&[*b, *a]).is_some_and(|m| m.dot(**n) < -1.0 + 1e-12)).count() / 2
}

#[test]
fn solids_are_the_surfaces_that_they_claim() {
    for solid in family().iter().chain(&random()) {
        let (name, claim) = (&solid.name, solid.topology);
        let mesh = fans(&solid.mesh());
        let facts = check::facts(&mesh, &vec![0; mesh.faces.len()]);
        assert_eq!((facts.components, facts.loops), (claim.pieces, claim.loops), "{name}");
        assert_eq!(facts.euler, 2 * (claim.pieces - claim.handles) as i64 - claim.loops as i64, "{name}");
        assert!(claim.loops > 0 || facts.volume > 0.0, "{name} is inside out");
        assert!(check::vertices_are_fans(&mesh), "{name}");
        if !name.contains("ngon") {
            assert_eq!(folds(&mesh), 0, "{name}");
            assert!(facts.least_angle > 0.0, "{name}: a triangle without area");
        }
    }
}
