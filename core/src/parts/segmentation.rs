//! Parts of an object: a label a face, by the method and for the number of parts that the caller asks for.
//!
//! [`Count::Auto`] and [`Count::Exactly`] cut along concave borders between regions that see each other badly through
//! the object's inside (see `merging`); [`Count::Published`] is the mixture of shape diameters with graph cuts (see
//! `published`), kept for comparison.
//! Rays belong to another stage, so what they find comes in: the shape diameter of each face and a function that says
//! whether two points see each other. `pipeline::partition` puts both together.
//! Every label is one connected region of faces; labels are 0..count, in the order of their lowest faces. Components of
//! the mesh never share a label.

use super::by_sight::{by_sight, by_sight_need};
use super::dual::{Dual, dual_need};
use super::published::{published, published_need};
use super::settings::{Count, PartSettings, PartSummary};
use super::surface::PartSurface;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;

/// Scratch bytes that [`parts`] asks for.
pub const fn parts_need(faces: usize, vertices: usize) -> usize {
    let _ = vertices;
    let (a, b) = (by_sight_need(faces), published_need(faces));
    dual_need(faces) + if a > b { a } else { b }
}

/// Fills `labels`. Near-linear in the number of faces.
pub fn parts(
    labels: &mut [u32], // (f)
    surface: &PartSurface,
    settings: &PartSettings,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<PartSummary, ScratchTooSmall> {
    scratch.require(parts_need(surface.mesh.faces.len(), surface.mesh.positions.len()))?;
    if labels.is_empty() {
        return Ok(PartSummary::default());
    }
    let dual = Dual::new(surface.mesh, surface.twin, &mut scratch)?;
    match settings.count {
        Count::Published { clusters, lambda } => published(labels, surface, &dual, clusters, lambda, scratch),
        Count::Auto => by_sight(labels, surface, &dual, None, scratch, workers),
        Count::Exactly(n) => by_sight(labels, surface, &dual, Some(n as usize), scratch, workers),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::real;
    use crate::base::workers::Serial;
    use crate::mesh::view::MeshView;
    use crate::parts::turned_tests::{Turned, dumbbell, turned};
    use glam::{DVec3, Vec3};
    use std::{vec, vec::Vec};

    fn run(shape: &Turned, count: Count) -> (Vec<u32>, usize) {
        let mesh = MeshView { positions: &shape.positions, faces: &shape.faces };
        let sees = |p: Vec3, q: Vec3| (p.z < 1.2) == (q.z < 1.2);
        let surface = PartSurface { mesh, twin: &shape.twin, diameter: &shape.diameter, sees: &sees };
        let mut bytes = vec![0; parts_need(shape.faces.len(), shape.positions.len())];
        let mut labels = vec![9; shape.faces.len()];
        let settings = PartSettings { count, seed: 0 };
        let summary = parts(&mut labels, &surface, &settings, Scratch::new(&mut bytes), &Serial).unwrap();
        (labels, summary.parts)
    }

    fn height(shape: &Turned, face: usize) -> f64 {
        shape.faces[face].iter().map(|v| shape.positions[*v as usize].z).sum::<f64>() / 3.0
    }

    #[test]
    fn a_dumbbell_of_two_parts_is_two_balls() {
        let shape = dumbbell();
        let (labels, count) = run(&shape, Count::Exactly(2));
        assert_eq!(count, 2);
        let side = |low: f64, high: f64| -> Vec<u32> {
            let inside = (0..labels.len()).filter(|f| (low..high).contains(&height(&shape, *f)));
            let mut found: Vec<u32> = inside.map(|f| labels[f]).collect();
            found.dedup();
            found
        };
        let (lower, upper) = (side(0.0, 0.9), side(1.5, 3.0));
        assert!(lower.len() == 1 && upper.len() == 1 && lower != upper, "{lower:?} {upper:?}");
    }

    #[test]
    fn left_to_itself_it_parts_the_balls_and_leaves_one_ball_whole() {
        let (labels, count) = run(&dumbbell(), Count::Auto);
        assert!((2..=3).contains(&count), "{count}"); // the neck may be a part
        assert_ne!(labels[0], labels[1], "bottom and top");
        let ball: Vec<f64> = (-5..=5).map(|k: i32| real::sqrt(0.26 - 0.01 * (k * k) as f64)).collect();
        assert_eq!(run(&turned(&ball), Count::Auto).1, 1);
    }

    #[test]
    fn every_part_is_connected_and_numbered_by_its_lowest_face() {
        let shape = dumbbell();
        for count in [Count::Auto, Count::Exactly(1), Count::Exactly(7), Count::PUBLISHED] {
            let (labels, parts) = run(&shape, count);
            let mut seen = 0;
            for label in &labels {
                assert!(*label <= seen);
                seen = seen.max(*label + 1);
            }
            assert_eq!(seen as usize, parts);
            let mut regions = vec![0; labels.len()];
            regions.copy_from_slice(&labels);
            let mut bytes = vec![0; parts_need(labels.len(), 0)];
            let mut scratch = Scratch::new(&mut bytes);
            let mesh = MeshView { positions: &shape.positions, faces: &shape.faces };
            let dual = Dual::new(mesh, &shape.twin, &mut scratch).unwrap();
            assert_eq!(crate::parts::tidy::connected(&mut regions, &dual, scratch), Ok(parts));
            if let Count::Exactly(n) = count {
                assert_eq!(parts, n as usize);
            }
        }
    }

    #[test]
    fn the_published_method_parts_thick_from_thin() {
        let shape = turned(&[&[0.5; 8][..], &[0.1; 8], &[0.5; 8]].concat());
        let (labels, count) = run(&shape, Count::Published { clusters: Some(2), lambda: 0.1 });
        assert_eq!(count, 3, "two thick ends and what is thin between them");
        let at = |z: f64| (0..labels.len()).find(|f| (height(&shape, *f) - z).abs() < 0.05).map(|f| labels[f]);
        assert!(at(0.3) != at(1.2) && at(1.2) != at(2.0) && at(0.3) != at(2.0));
    }

    #[test]
    fn nothing_one_face_and_flat_faces_have_their_parts() {
        let flat = |n: usize| Turned {
            positions: vec![DVec3::ZERO; 3],
            faces: vec![[0, 1, 2]; n],
            twin: vec![crate::mesh::view::NONE; 3 * n],
            diameter: vec![0.0; n],
        };
        for count in [Count::Auto, Count::Exactly(3), Count::PUBLISHED] {
            assert_eq!(run(&flat(0), count).1, 0);
            assert_eq!(run(&flat(1), count).1, 1);
            assert_eq!(run(&flat(5), count).1, 5, "faces without neighbours");
        }
    }

    #[test]
    fn one_byte_less_is_refused_and_nothing_written() {
        let shape = dumbbell();
        let mesh = MeshView { positions: &shape.positions, faces: &shape.faces };
        let surface = PartSurface { mesh, twin: &shape.twin, diameter: &shape.diameter, sees: &|_, _| true };
        let mut labels = vec![9; shape.faces.len()];
        let mut bytes = vec![0; parts_need(shape.faces.len(), shape.positions.len()) - 1];
        assert!(parts(&mut labels, &surface, &PartSettings::default(), Scratch::new(&mut bytes), &Serial).is_err());
        assert!(labels.iter().all(|l| *l == 9));
    }
}
