//! Scratch bytes of every stage by mesh size, as the table of docs/EMBEDDED.md:
//! `cargo run --release --manifest-path tests/nostd/Cargo.toml --example needs`

use glam::DVec3;
use seamwright_core::judge::measure::measure_need;
use seamwright_core::learn::backbone::Widths;
use seamwright_core::learn::fit::FitSettings;
use seamwright_core::mesh::polygons::Polygons;
use seamwright_core::mesh::repair::repair_need;
use seamwright_core::pipeline::neural::neural_need;
use seamwright_core::pipeline::polygons::parts_of_polygons_need;
use seamwright_core::pipeline::{Input, Packing, Settings, unwrap_need};
use seamwright_core::rays::binned::BinnedBuilder;
use seamwright_core::rays::cast::Scene;
use seamwright_core::rays::exposure::exposure_need;

fn main() {
    println!(
        "| faces | repair | rays | parts | unwrap, grid | unwrap, tight | training 8/4 | training draft | metrics |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for faces in [100, 300, 500, 1_000, 3_000, 10_000, 100_000] {
        let vertices = faces / 2 + 2;
        let positions = vec![DVec3::ZERO; vertices];
        let corners = vec![0; 3 * faces];
        let polygon_start: Vec<u32> = (0..=faces as u32).map(|f| 3 * f).collect();
        let (positions, corners, polygon_start) = (&positions[..], &corners[..], &polygon_start[..]);
        let polygons = Polygons { positions, corners, polygon_start, kept_uv: None };
        let input = Input::new(positions, corners, polygon_start);
        let unwrap = |packing| unwrap_need(&input, &Settings { packing, ..Settings::default() }, &BinnedBuilder);
        let tiny = FitSettings { widths: Widths { hidden: 8, code: 4 }, ..FitSettings::DRAFT };
        let needs = [
            repair_need(&polygons.counts()),
            Scene::need(faces, &BinnedBuilder) + exposure_need(64),
            parts_of_polygons_need(&input, &BinnedBuilder),
            unwrap(Packing::Grid),
            unwrap(Packing::Tight),
            neural_need(faces, &tiny),
            neural_need(faces, &FitSettings::DRAFT),
            measure_need(vertices, faces, 128),
        ];
        println!("| {faces} | {} |", needs.map(|n| n.div_ceil(1024).to_string()).join(" | "));
    }
}
