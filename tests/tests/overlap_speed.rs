//! How long exact overlaps take. `cargo test --release -p seamwright-tests --test overlap_speed -- --ignored --nocapture`

use glam::DVec2;
use seamwright_core::base::random::unit_f64;
use seamwright_core::base::real::{cos, sin};
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Serial;
use seamwright_core::plane::grid::{GRID_BITS, GridPoint, GridTriangle};
use seamwright_core::plane::overlap::{flips, overlaps, overlaps_need};
use std::time::Instant;

/// Two faces a cell of a jittered lattice in the unit square, its cells `aspect` times as high as wide, turned by `angle`.
fn lattice(faces: usize, aspect: f64, angle: f64) -> Vec<GridTriangle> {
    let columns = (faces as f64 / 2.0 * aspect).sqrt() as usize;
    let rows = faces / 2 / columns;
    let point = |x: usize, y: usize| {
        let jitter = |k: u64| 0.4 * unit_f64(1, k, (x * (rows + 1) + y) as u64);
        let p = DVec2::new((x as f64 + jitter(0)) / columns as f64, (y as f64 + jitter(1)) / rows as f64);
        GridPoint::snap(DVec2::new(cos(angle), sin(angle)).rotate(p) * 0.7, GRID_BITS)
    };
    let cells = (0..columns * rows).map(|i| (i % columns, i / columns));
    cells
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| point(x + i, y + j));
            // Of the two diagonals at least one leaves both faces counter-clockwise.
            let (one, other) = ([[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]);
            if flips(&one) == (0, 0) { one } else { other }
        })
        .collect()
}

#[test]
#[ignore = "measures time"]
fn time_and_memory_by_number_of_faces() {
    let pile = |n: usize| vec![lattice(2, 1.0, 0.0)[0]; n];
    let soup = |n: usize| -> Vec<GridTriangle> {
        let size = 3.0 / (n as f64).sqrt();
        let point = |i: usize, k: u64| DVec2::new(unit_f64(2, k, i as u64), unit_f64(3, k, i as u64));
        let corner = |i: usize, k: u64| GridPoint::snap(point(i, 0) + size * point(i, k), GRID_BITS);
        (0..n).map(|i| [corner(i, 1), corner(i, 2), corner(i, 3)]).collect()
    };
    let mut cases: Vec<(String, Vec<GridTriangle>)> = vec![];
    for n in [10_000, 100_000, 1_000_000] {
        cases.push((format!("lattice {n}"), lattice(n, 1.0, 0.3)));
        cases.push((format!("overlapping soup {n}"), soup(n)));
        cases.push((format!("pile of equals {n}"), pile(n)));
    }
    for angle in [0.0, 0.39, 0.785] {
        cases.push((format!("slivers 1:100 at {angle} rad, 100000"), lattice(100_000, 100.0, angle)));
    }
    for (name, faces) in cases {
        let mut bytes = vec![0; overlaps_need(faces.len())];
        let mut partner = vec![0; faces.len()];
        let (mut best, mut count) = (f64::INFINITY, 0);
        for _ in 0..5 {
            let start = Instant::now();
            count = overlaps(&mut partner, &faces, Scratch::new(&mut bytes), &Serial).unwrap();
            best = best.min(start.elapsed().as_secs_f64());
        }
        let each = bytes.len() as f64 / faces.len() as f64;
        println!("{name:36} {best:.3} s (best of 5)  {count} overlapping  {each:.1} bytes a face");
    }
}
