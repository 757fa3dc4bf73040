//! Rays a second of the exposure stage on one thread: `rays MESH.obj [RAYS]`.
//!
//! The mesh is centred and scaled so that its largest coordinate is 1, as `bench/embree_rays.py` does for libigl.

use seamwright::run::hierarchy::ObvhsBuilder;
use seamwright_core::base::{scratch::Scratch, workers::Serial};
use seamwright_core::mesh::normals::{NormalWeight, vertex_normals};
use seamwright_core::mesh::view::MeshView;
use seamwright_core::rays::binned::BinnedBuilder;
use seamwright_core::rays::bvh::BuildBvh;
use seamwright_core::rays::cast::Scene;
use seamwright_core::rays::directions::Spread;
use seamwright_core::rays::exposure::{ExposureSettings, exposure, exposure_need};
use seamwright_tests::{load_obj, seconds};

fn main() {
    let mut args = std::env::args().skip(1);
    let path = args.next().expect("usage: rays MESH.obj [RAYS]");
    let rays = args.next().map_or(512, |r| r.parse().expect("RAYS is a number"));
    let (points, faces) = load_obj(&path);
    let mesh = MeshView { positions: &points, faces: &faces };
    let mut normals = vec![glam::DVec3::ZERO; points.len()];
    vertex_normals(&mut normals, mesh, NormalWeight::Area);
    let positions: Vec<_> = points.iter().map(|p| p.as_vec3()).collect();
    let normals: Vec<_> = normals.iter().map(|n| n.as_vec3()).collect();
    for (name, builder) in [("core", &BinnedBuilder as &dyn BuildBvh), ("obvhs", &ObvhsBuilder)] {
        report(&path, name, builder, &positions, &normals, &faces, rays);
    }
}

#[allow(clippy::too_many_arguments)]
fn report(
    path: &str,
    name: &str,
    builder: &dyn BuildBvh,
    positions: &[glam::Vec3],
    normals: &[glam::Vec3],
    faces: &[[u32; 3]],
    rays: usize,
) {
    let mut bytes = vec![0u8; Scene::need(faces.len(), builder) + exposure_need(rays)];
    let mut scratch = Scratch::new(&mut bytes);
    let start = seconds();
    let scene = Scene::new(positions, faces, builder, &mut scratch).expect("a valid mesh");
    let build = seconds() - start;
    for spread in [Spread::Uniform, Spread::Cosine] {
        let settings = ExposureSettings { rays, spread, ..Default::default() };
        let mut out = vec![0.0; positions.len()];
        let start = seconds();
        exposure(&mut out, positions, normals, &scene, &settings, scratch.frame(), &Serial).expect("enough scratch");
        let cast = seconds() - start;
        let mean = out.iter().map(|x| *x as f64).sum::<f64>() / out.len() as f64;
        let rate = (positions.len() * rays) as f64 / (build + cast) / 1e6;
        println!(
            "{path} {name} {spread:?}: {rate:.2} Mrays/s (build {build:.4} s, cast {cast:.4} s), mean exposure {mean:.4}"
        );
    }
}
