//! Quads bear both ways to part them into triangles: no map is good on the diagonals that unwrapping chose and bad on the others.

use glam::DVec2;
use seamwright::mesh::polygons::Mesh;
use seamwright_core::base::workers::Serial;
use seamwright_core::pipeline::Settings;
use seamwright_core::solve::bound::distortion;
use seamwright_core::solve::energy::Rest;
use seamwright_tests::road::{Atlas, run};
use seamwright_tests::shapes::{lump, torus};

/// Distortion of an atlas of quads that are parted from corner `first` on.
fn parted_at(first: usize, mesh: &Mesh, atlas: &Atlas) -> f64 {
    let (mut uv, mut rest) = (Vec::<DVec2>::new(), vec![]);
    for quad in mesh.polygons() {
        for t in [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| quad.start + (first + i) % 4)) {
            rest.push(Rest::new(t.map(|c| mesh.positions[mesh.corners[c] as usize]), 0.0));
            uv.extend(t.map(|c| atlas.corner_uv[c]));
        }
    }
    distortion(&uv, &rest)
}

#[test]
fn a_quad_is_as_little_distorted_on_either_diagonal() {
    // An energy of one diagonal alone leaves the lumps with 1.02 to 1.07 on the other.
    let lumps = (0..8).map(|phase| lump(f64::from(phase)));
    for (k, mesh) in lumps.chain([torus()]).enumerate() {
        let settings = Settings { effort: 0.1, rays: 64, ..Settings::default() };
        let (atlas, _) = run(&mesh, &settings, &Serial, 0).unwrap();
        let [own, other] = [0, 1].map(|first| parted_at(first, &mesh, &atlas));
        assert!(own <= settings.distortion && other - 1.0 <= 1.3 * (own - 1.0), "{k}: {own} and {other}");
    }
}
