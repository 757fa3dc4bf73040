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
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;
use crate::mesh::view::MeshView;
use glam::Vec3;

/// How many parts, and by which method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Count {
    /// As many as the shape has.
    #[default]
    Auto,
    /// This many over the whole mesh, but never fewer than its components, and from these on no more than patches (see
    /// `patches`): 400 and a quarter of the faces.
    Exactly(u32),
    /// The published method. Its parts are the connected regions of clusters, so there are at least as many.
    Published {
        /// Clusters of shape diameters, 1 to 16; None: as many as the Bayesian information criterion wants.
        clusters: Option<u32>,
        /// Weight of smoothness, at least 0.
        lambda: f64,
    },
}

impl Count {
    /// The published method with its published numbers.
    pub const PUBLISHED: Count = Count::Published { clusters: Some(3), lambda: 15.0 };
}

/// What can be asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// Number of parts and method.
    pub count: Count,
    /// Seed of every random value.
    pub seed: u64,
}

/// What is cut into parts.
#[derive(Clone, Copy)]
pub struct Surface<'a> {
    /// Oriented manifold triangles, as from `repair`.
    pub mesh: MeshView<'a>,
    /// Their twins.
    pub twin: &'a [u32], // (3 f)
    /// Shape diameter of each face, in the mesh's units.
    pub diameter: &'a [f32], // (f)
    /// Whether the straight way from the first to the second point meets no face.
    pub sees: &'a (dyn Fn(Vec3, Vec3) -> bool + Sync),
}

/// What was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Parts; labels are 0..parts.
    pub parts: usize,
    /// Clusters of the published method, else 0.
    pub clusters: usize,
}

/// Scratch bytes that [`parts`] asks for.
pub const fn parts_need(faces: usize, vertices: usize) -> usize {
    let _ = vertices;
    let (a, b) = (by_sight_need(faces), published_need(faces));
    dual_need(faces) + if a > b { a } else { b }
}

/// Fills `labels`. Near-linear in the number of faces.
pub fn parts(
    labels: &mut [u32], // (f)
    surface: &Surface,
    settings: &Settings,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<Summary, ScratchTooSmall> {
    scratch.require(parts_need(surface.mesh.faces.len(), surface.mesh.positions.len()))?;
    if labels.is_empty() {
        return Ok(Summary::default());
    }
    let dual = Dual::new(surface.mesh, surface.twin, &mut scratch)?;
    match settings.count {
        Count::Published { clusters, lambda } => published(labels, surface, &dual, clusters, lambda, scratch),
        Count::Auto => by_sight(labels, surface, &dual, None, scratch, workers),
        Count::Exactly(n) => by_sight(labels, surface, &dual, Some(n as usize), scratch, workers),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::base::real;
    use crate::base::workers::Serial;
    use crate::mesh::topology::{twins, twins_need};
    use core::f64::consts::TAU;
    use glam::DVec3;
    use std::{vec, vec::Vec};

    /// Sides of a turned shape.
    const SIDES: usize = 24;

    /// A closed surface around the z axis with the given radii at heights 0, 0.1, 0.2 ...; its diameters are the radii's.
    pub struct Turned {
        pub positions: Vec<DVec3>,
        pub faces: Vec<[u32; 3]>,
        pub twin: Vec<u32>,
        pub diameter: Vec<f32>,
    }

    pub fn turned(radii: &[f64]) -> Turned {
        let mut positions = vec![];
        for (k, r) in radii.iter().enumerate() {
            for i in 0..SIDES {
                let angle = TAU * i as f64 / SIDES as f64;
                positions.push(DVec3::new(r * real::cos(angle), r * real::sin(angle), 0.1 * k as f64));
            }
        }
        let rings = radii.len();
        let [bottom, top] = [rings * SIDES, rings * SIDES + 1].map(|v| v as u32);
        positions.extend([DVec3::ZERO, DVec3::Z * (0.1 * (rings - 1) as f64)]);
        let (mut faces, mut diameter) = (vec![], vec![]);
        for i in 0..SIDES {
            let next = (i + 1) % SIDES;
            let at = |ring: usize, side: usize| (ring * SIDES + side) as u32;
            faces.extend([[bottom, at(0, next), at(0, i)], [top, at(rings - 1, i), at(rings - 1, next)]]);
            diameter.extend([2.0 * radii[0] as f32, 2.0 * radii[rings - 1] as f32]);
            for k in 1..rings {
                faces.extend([[at(k - 1, i), at(k - 1, next), at(k, next)], [at(k - 1, i), at(k, next), at(k, i)]]);
                diameter.extend([(radii[k - 1] + radii[k]) as f32; 2]);
            }
        }
        let mut twin = vec![0; 3 * faces.len()];
        let mut bytes = vec![0; twins_need(faces.len())];
        let mesh = MeshView { positions: &positions, faces: &faces };
        assert_eq!(twins(&mut twin, mesh, Scratch::new(&mut bytes)), Ok(0));
        Turned { positions, faces, twin, diameter }
    }

    /// Two balls of radius 0.5 with a neck of 0.08 between them.
    pub fn dumbbell() -> Turned {
        let ball = |k: i32| real::sqrt(0.25 - 0.01 * (k * k) as f64).max(0.08);
        let one: Vec<f64> = (-5..=5).map(ball).collect();
        turned(&[&one[..], &[0.08; 4], &one[..]].concat())
    }

    fn run(shape: &Turned, count: Count) -> (Vec<u32>, usize) {
        let mesh = MeshView { positions: &shape.positions, faces: &shape.faces };
        let sees = |p: Vec3, q: Vec3| (p.z < 1.2) == (q.z < 1.2);
        let surface = Surface { mesh, twin: &shape.twin, diameter: &shape.diameter, sees: &sees };
        let mut bytes = vec![0; parts_need(shape.faces.len(), shape.positions.len())];
        let mut labels = vec![9; shape.faces.len()];
        let settings = Settings { count, seed: 0 };
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
        let surface = Surface { mesh, twin: &shape.twin, diameter: &shape.diameter, sees: &|_, _| true };
        let mut labels = vec![9; shape.faces.len()];
        let mut bytes = vec![0; parts_need(shape.faces.len(), shape.positions.len()) - 1];
        assert!(parts(&mut labels, &surface, &Settings::default(), Scratch::new(&mut bytes), &Serial).is_err());
        assert!(labels.iter().all(|l| *l == 9));
    }
}
