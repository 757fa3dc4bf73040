//! `repair` on meshes by the thousand: random polygons, shuffled faces, files of real meshes.

use super::soup::{Soup, assert_promises, noise, surface};
use crate::base::random;
use crate::base::real;
use crate::base::scratch::Scratch;
use crate::mesh::repair::{Facing, RepairError, repair, repair_need};
use core::f64::consts::TAU;
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::string::String;
use std::vec::Vec;
use std::{assert, assert_eq, eprintln, format, fs, vec};

#[test]
fn one_byte_less_is_refused_and_the_stated_need_is_enough_at_any_alignment() {
    for seed in 0..20 {
        let soup = noise(seed, 12, 30);
        let need = repair_need(&soup.view().counts());
        let mut bytes = vec![0u8; need + 16];
        for shift in 0..16 {
            let mut scratch = Scratch::new(&mut bytes[shift..shift + need]);
            assert!(repair(&soup.view(), Facing::Turned, &mut scratch).is_ok());
        }
        let mut scratch = Scratch::new(&mut bytes[..need - 1]);
        assert!(matches!(repair(&soup.view(), Facing::Turned, &mut scratch), Err(RepairError::Scratch(_))));
        assert_eq!(scratch.remaining(), need - 1);
    }
}

#[test]
fn random_polygons_become_manifolds() {
    for seed in 0..3000 {
        let (vertices, polygons) = (4 + seed % 40, 1 + random::hash(seed, 8, 0) % 60);
        let soup = noise(seed, vertices, polygons);
        let mut bytes = vec![0u8; repair_need(&soup.view().counts())];
        let facing = if seed % 4 == 3 { Facing::AsGiven } else { Facing::Turned };
        match repair(&soup.view(), facing, &mut Scratch::new(&mut bytes)) {
            Ok((working, summary)) => assert_promises(&soup, &working, &summary),
            Err(e) => assert_eq!(e, RepairError::NoTriangle, "{seed}"),
        }
    }
}

#[test]
fn shuffled_and_turned_faces_give_back_the_surface() {
    // Genus and loops of a torus with a window do not depend on order or direction of its faces.
    let at = |i: u32, j: u32| {
        let (u, v) = (TAU * f64::from(i % 12) / 12.0, TAU * f64::from(j % 8) / 8.0);
        let r = 3.0 + real::cos(v);
        [r * real::cos(u), r * real::sin(u), real::sin(v)]
    };
    let torus = surface(12, 8, at);
    for seed in 0..50 {
        let mut order: Vec<usize> = (1..96).collect();
        order.sort_by_key(|i| random::hash(seed, 0, *i as u64));
        let mut soup = Soup { positions: torus.positions.clone(), ..Soup::default() };
        let mut turned = 0;
        for i in order {
            let mut quad = torus.corners[4 * i..4 * i + 4].to_vec();
            quad.rotate_left((random::hash(seed, 1, i as u64) % 4) as usize);
            if random::hash(seed, 2, i as u64) % 10 < 3 {
                quad.reverse();
                turned += 2;
            }
            soup.push(&quad);
        }
        let summary = soup.summary();
        assert_eq!((summary.euler, summary.genus, summary.boundary_loops, summary.components), (-1, 1, 1, 1));
        assert_eq!(summary.flipped_faces, turned, "{seed}");
    }
}

fn read_obj(path: &Path) -> Soup {
    let mut soup = Soup { polygon_start: vec![0], ..Soup::default() };
    let text = String::from_utf8_lossy(&fs::read(path).unwrap()).replace("\\\r\n", " ").replace("\\\n", " ");
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let xyz: Vec<f64> = words.take(3).filter_map(|w| w.parse().ok()).collect();
                if let [x, y, z] = xyz[..] {
                    soup.positions.push(DVec3::new(x, y, z));
                }
            }
            Some("f") => {
                let count = soup.positions.len() as i64;
                let index = |w: &str| w.split('/').next()?.parse::<i64>().ok();
                let corners = words.filter_map(index).map(|i| (if i < 0 { count + i } else { i - 1 }) as u32);
                soup.push(&corners.collect::<Vec<_>>());
            }
            _ => {}
        }
    }
    soup
}

#[test]
fn every_shared_mesh_becomes_manifold() {
    let shared = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/meshes");
    let mut meshes: Vec<PathBuf> = ["bench", "hard", "psb"]
        .iter()
        .filter_map(|folder| fs::read_dir(shared.join(folder)).ok())
        .flat_map(|entries| entries.map(|e| e.unwrap().path()))
        .filter(|path| path.extension().is_some_and(|e| e == "obj"))
        .collect();
    meshes.sort();
    if meshes.is_empty() {
        eprintln!("skipped: no meshes at {}", shared.display());
    }
    for path in meshes {
        let soup = read_obj(&path);
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let mut bytes = vec![0u8; repair_need(&soup.view().counts())];
        let per_face = bytes.len() / (soup.corners.len() / 3).max(1);
        let start = std::time::Instant::now();
        let result = repair(&soup.view(), Facing::Turned, &mut Scratch::new(&mut bytes));
        let time = start.elapsed();
        match result {
            Ok((working, summary)) => {
                eprintln!("{name} {time:?} {per_face} B/face {}", format!("{summary:?}").replace("RepairSummary ", ""));
                assert_promises(&soup, &working, &summary);
            }
            Err(e) => {
                assert!(path.to_string_lossy().contains("hard"), "{name}: {e}");
                eprintln!("{name}: {e}");
            }
        }
    }
}
