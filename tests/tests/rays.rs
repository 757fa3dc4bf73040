//! Hits do not depend on who built the hierarchy.

use glam::Vec3;
use seamwright::run::hierarchy::ObvhsBuilder;
use seamwright_core::base::random::unit_f32;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Serial;
use seamwright_core::rays::binned::BinnedBuilder;
use seamwright_core::rays::bvh::BuildBvh;
use seamwright_core::rays::cast::{Hit, Ray, Scene};
use seamwright_core::rays::exposure::{ExposureSettings, exposure, exposure_need};

/// A ball of n x 2n quads with hashed bumps, a copy of its first face, and faces without area.
fn bumpy_ball(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions = vec![];
    for i in 0..=n {
        for j in 0..2 * n {
            let (a, b) = ((i as f32 / n as f32) * std::f32::consts::PI, (j as f32 / n as f32) * std::f32::consts::PI);
            let r = 0.4 + 0.1 * unit_f32(1, 2, (i * 2 * n + j) as u64);
            positions.push(Vec3::new(a.sin() * b.cos(), a.sin() * b.sin(), a.cos()) * r);
        }
    }
    let at = |i: u32, j: u32| i * 2 * n + j % (2 * n);
    let mut faces = vec![];
    for i in 0..n {
        for j in 0..2 * n {
            faces.extend([[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]);
        }
    }
    faces.extend([faces[0], [0, 0, 1], [3, 3, 3]]);
    (positions, faces)
}

fn with_scene<T>(
    mesh: &(Vec<Vec3>, Vec<[u32; 3]>),
    builder: &dyn BuildBvh,
    run: impl FnOnce(&Scene, Scratch) -> T,
) -> T {
    let mut bytes = vec![0; Scene::need(mesh.1.len(), builder) + exposure_need(64)];
    let mut scratch = Scratch::new(&mut bytes);
    let scene = Scene::new(&mesh.0, &mesh.1, builder, &mut scratch).expect("a valid mesh");
    run(&scene, scratch.frame())
}

#[test]
fn both_builders_give_the_same_hits_to_the_bit() {
    let mesh = bumpy_ball(24);
    let rays: Vec<_> = (0..8000u64)
        .map(|i| {
            let random = |stream: u64| Vec3::from_array([0, 1, 2].map(|k| unit_f32(stream, k, i) - 0.5));
            let vertex = |k: u64| mesh.0[(7 * i + k) as usize % mesh.0.len()];
            // At random, through vertices, through the middles between vertices, out of the inside.
            let (origin, target) = match i % 4 {
                0 => (random(1) * 3.0, random(2)),
                1 => (random(1) * 3.0, vertex(0)),
                2 => (random(1) * 3.0, (vertex(0) + vertex(1)) * 0.5),
                _ => (Vec3::ZERO, vertex(0)),
            };
            Ray { origin, direction: target - origin }
        })
        .collect();
    let hits = |builder: &dyn BuildBvh| -> Vec<Option<Hit>> {
        with_scene(&mesh, builder, |scene, _| rays.iter().map(|r| scene.closest(r)).collect())
    };
    let (ours, theirs) = (hits(&BinnedBuilder), hits(&ObvhsBuilder));
    assert!(ours.iter().flatten().count() > 4000);
    assert_eq!(ours, theirs);
}

#[test]
fn both_builders_give_the_same_exposure_to_the_bit() {
    let mesh = bumpy_ball(16);
    let normals: Vec<_> = mesh.0.iter().map(|p| p.normalize()).collect();
    let run = |builder: &dyn BuildBvh| {
        with_scene(&mesh, builder, |scene, scratch| {
            let mut out = vec![0.0; mesh.0.len()];
            let settings = ExposureSettings { rays: 64, ..Default::default() };
            exposure(&mut out, &mesh.0, &normals, scene, &settings, scratch, &Serial).expect("enough scratch");
            out
        })
    };
    assert_eq!(run(&BinnedBuilder), run(&ObvhsBuilder));
}

#[test]
fn the_library_is_given_no_mesh_that_it_cannot_take() {
    for mesh in [
        (vec![], vec![]),
        (vec![Vec3::ZERO; 3], vec![[0, 1, 2]]),
        (vec![Vec3::ZERO; 3], vec![[0, 1, 2]; 100]),
        (vec![Vec3::NAN, Vec3::X, Vec3::INFINITY], vec![[0, 1, 2]; 9]),
    ] {
        with_scene(&mesh, &ObvhsBuilder, |scene, _| {
            let ray = Ray { origin: Vec3::ONE, direction: -Vec3::ONE };
            assert_eq!(scene.closest(&ray), None);
        });
    }
}
