//! A few hundred patches that the dense steps of the partition work on, however large the mesh is.
//!
//! Seeds are spread by farthest points; each face goes to the nearest seed over the dual graph, where a step across a
//! concave edge is long: borders of patches come to lie in creases, so hardly any border between parts is lost
//! (0.02 of Rand error on the meshes of docs/RESULTS.md, where people among themselves have 0.1).
//! Each component with some area has patches of its own; a speck is one part and takes no patch.
//! Eldar, Lindenbaum, Porat, Zeevi 1997 (farthest points); the rest is Dijkstra 1959.

use super::dual::Dual;
use crate::base::heap::Heap;
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::mesh::view::{MeshView, NONE};
use glam::DVec3;

/// Patches at the most. 200 lose thin parts, 800 cost eight times as much in the dense steps and gain nothing.
pub const MAX_PATCHES: usize = 400;
/// Faces a patch at the least, on coarse meshes.
const MIN_FACES: usize = 4;
/// How much longer a step is for each radian that its edge turns inwards.
const CREASE: f64 = 5.0;
/// Share of the whole area that a component needs to have patches.
const SPECK: f64 = 0.005;

/// Patches of a mesh.
pub struct Patches<'a> {
    /// Patch of each face; [`NONE`] in specks.
    pub of: &'a mut [u32], // (f)
    /// A face in the middle of each patch.
    pub middle: &'a mut [u32], // (m)
    /// Share of the whole area.
    pub area: &'a mut [f64], // (m)
    /// Area-weighted mean of the faces' centroids.
    pub centroid: &'a mut [DVec3], // (m)
}

/// How many patches a mesh of so many faces has at the most.
pub const fn patch_count(faces: usize) -> usize {
    let wanted = faces.div_ceil(MIN_FACES);
    if wanted < MAX_PATCHES { wanted } else { MAX_PATCHES }
}

/// Bytes that [`Patches::new`] takes.
pub const fn patches_need(faces: usize) -> usize {
    let m = patch_count(faces);
    bytes_for::<u32>(faces) + bytes_for::<u32>(m) + bytes_for::<f64>(m) + bytes_for::<DVec3>(m) + walk_need(faces)
}

/// Bytes that [`Walk::new`] takes.
pub const fn walk_need(faces: usize) -> usize {
    2 * bytes_for::<f64>(faces) + 2 * bytes_for::<u32>(faces)
}

/// Shortest ways over the dual graph from many faces at once.
pub struct Walk<'a> {
    /// Length of the way to each face so far; infinite where none has come.
    pub distance: &'a mut [f64], // (f)
    heap: Heap<'a>,
}

impl<'a> Walk<'a> {
    /// No face reached.
    pub fn new(faces: usize, scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        let distance = scratch.take_filled(faces, f64::INFINITY)?;
        Ok(Self { distance, heap: Heap::new(scratch.take(faces)?, scratch.take(faces)?, scratch.take(faces)?) })
    }

    /// Starts at `face` with distance 0.
    pub fn start(&mut self, face: u32) {
        self.distance[face as usize] = 0.0;
        self.heap.push(face, 0.0);
    }

    /// Goes on to every face that is nearer by the new starts, and tells `reach(face, the face before it)` of each.
    /// `step` holds the length of the step over each half-edge.
    pub fn run(&mut self, twin: &[u32], step: &[f64], mut reach: impl FnMut(u32, u32)) {
        while let Some((face, distance)) = self.heap.pop() {
            for c in 3 * face as usize..3 * face as usize + 3 {
                if twin[c] == NONE {
                    continue;
                }
                let (other, length) = (twin[c] / 3, distance + step[c]);
                if length < self.distance[other as usize] {
                    self.distance[other as usize] = length;
                    self.heap.push(other, length);
                    reach(other, face);
                }
            }
        }
    }
}

/// Distance between the centroids of two neighbours, by way of the middle of their edge.
pub fn step_length(mesh: MeshView, c: u32, twin: u32) -> f64 {
    let next = crate::mesh::view::next;
    let middle = (mesh.position(c) + mesh.position(next(c))) * 0.5;
    let to = |f: u32| real::sqrt((centroid(mesh, f) - middle).length_squared());
    to(c / 3) + to(twin / 3)
}

/// Mean of the corners of a face.
pub fn centroid(mesh: MeshView, face: u32) -> DVec3 {
    let [a, b, c] = mesh.faces[face as usize].map(|v| mesh.positions[v as usize]);
    (a + b + c) / 3.0
}

impl<'a> Patches<'a> {
    /// Cuts the mesh into patches. `component` numbers the connected components of its faces, `components` of them;
    /// `length` and `inward` hold the step and the inward turn of each half-edge. O(f log f log m).
    #[allow(clippy::too_many_arguments)]
    pub fn new(
        mesh: MeshView,
        twin: &[u32],
        dual: &Dual,
        component: &[u32],
        components: usize,
        length: &[f64], // (3 f)
        inward: &[f64], // (3 f)
        scratch: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let faces = mesh.faces.len();
        let most = patch_count(faces);
        let of = scratch.take_filled::<u32>(faces, NONE)?;
        let middle = scratch.take::<u32>(most)?;
        let area = scratch.take::<f64>(most)?;
        let centroids = scratch.take::<DVec3>(most)?;
        let mut frame = scratch.frame();
        let whole = dual.area.iter().sum::<f64>();
        let share = frame.take::<f64>(components)?;
        let first = frame.take_filled::<u32>(components, NONE)?;
        for (f, k) in component.iter().enumerate().rev() {
            share[*k as usize] += dual.area[f] / whole;
            first[*k as usize] = f as u32;
        }
        let step = frame.take::<f64>(3 * faces)?;
        (step.iter_mut().zip(length).zip(inward)).for_each(|((s, l), t)| *s = l * (1.0 + CREASE * t));

        let mut walk = Walk::new(faces, &mut frame)?;
        let mut starts = (0..components).filter(|k| share[*k] >= SPECK).map(|k| first[k]);
        let mut count = 0;
        while count < most {
            let seed = match starts.next() {
                Some(seed) => seed,
                None => match farthest(walk.distance) {
                    Some(seed) => seed,
                    None => break,
                },
            };
            walk.start(seed);
            of[seed as usize] = count as u32;
            walk.run(twin, step, |face, _| of[face as usize] = count as u32);
            count += 1;
        }
        let mut patches =
            Self { of, middle: &mut middle[..count], area: &mut area[..count], centroid: &mut centroids[..count] };
        patches.measure(mesh, dual, whole, walk.distance);
        Ok(patches)
    }

    /// Areas, centroids and middle faces. `distance` is written over.
    fn measure(&mut self, mesh: MeshView, dual: &Dual, whole: f64, distance: &mut [f64]) {
        let placed = |of: &[u32], f: usize| Some(of[f]).filter(|p| *p != NONE).map(|p| p as usize);
        for f in 0..self.of.len() {
            if let Some(p) = placed(self.of, f) {
                // Faces without area count a little, so that a patch of nothing else has a middle.
                let weight = (dual.area[f] / whole).max(1e-15);
                self.area[p] += weight;
                self.centroid[p] += centroid(mesh, f as u32) * weight;
            }
        }
        self.centroid.iter_mut().zip(self.area.iter()).for_each(|(c, a)| *c /= *a);
        self.middle.fill(NONE);
        for f in 0..self.of.len() {
            if let Some(p) = placed(self.of, f) {
                distance[f] = (centroid(mesh, f as u32) - self.centroid[p]).length_squared();
                let middle = &mut self.middle[p];
                if *middle == NONE || distance[f] < distance[*middle as usize] {
                    *middle = f as u32;
                }
            }
        }
    }
}

/// The face of the largest finite distance above 0, the first of equals.
fn farthest(distance: &[f64]) -> Option<u32> {
    let mut best: Option<(f64, usize)> = None;
    for (f, d) in distance.iter().enumerate() {
        if d.is_finite() && *d > best.map_or(0.0, |b| b.0) {
            best = Some((*d, f));
        }
    }
    best.map(|b| b.1 as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parts::dual::dual_need;
    use crate::parts::turned_tests::{Turned, dumbbell};
    use approx::assert_abs_diff_eq;
    use std::vec;

    fn run(shape: &Turned, short: usize, check: impl FnOnce(&Patches)) -> Result<(), ScratchTooSmall> {
        let faces = shape.faces.len();
        let mesh = MeshView { positions: &shape.positions, faces: &shape.faces };
        let mut bytes = vec![0; dual_need(faces)];
        let dual = Dual::new(mesh, &shape.twin, &mut Scratch::new(&mut bytes)).unwrap();
        let component = vec![0; faces];
        let (length, inward) = (vec![1.0; 3 * faces], vec![0.0; 3 * faces]);
        let more = bytes_for::<f64>(3 * faces) + 2 * bytes_for::<f64>(1);
        let mut bytes = vec![0; (patches_need(faces) + more) / short];
        let mut scratch = Scratch::new(&mut bytes);
        Patches::new(mesh, &shape.twin, &dual, &component, 1, &length, &inward, &mut scratch).map(|p| check(&p))
    }

    #[test]
    fn every_face_has_a_patch_and_every_patch_its_middle() {
        let shape = dumbbell();
        run(&shape, 1, |patches| {
            assert_eq!(patches.area.len(), patch_count(shape.faces.len()));
            assert!(patches.of.iter().all(|p| (*p as usize) < patches.area.len()));
            for (p, middle) in patches.middle.iter().enumerate() {
                assert_eq!(patches.of[*middle as usize] as usize, p);
            }
            // A few hundred sums of shares.
            assert_abs_diff_eq!(patches.area.iter().sum::<f64>(), 1.0, epsilon = 1e-12);
        })
        .unwrap();
    }

    #[test]
    fn seeds_lie_apart() {
        // Steps of length 1: with m seeds on f faces no face is farther from its seed than a ball of f/m faces needs.
        let shape = dumbbell();
        run(&shape, 1, |patches| {
            let mut count = vec![0; patches.area.len()];
            patches.of.iter().for_each(|p| count[*p as usize] += 1);
            assert!(count.iter().all(|n| (1..=40).contains(n)), "{count:?}");
        })
        .unwrap();
    }

    #[test]
    fn a_mesh_without_area_has_no_patches_and_too_little_memory_is_refused() {
        let mut shape = dumbbell();
        assert!(run(&shape, 20, |_| ()).is_err());
        shape.positions.fill(DVec3::ZERO);
        run(&shape, 1, |patches| assert!(patches.area.is_empty() && patches.of.iter().all(|p| *p == NONE))).unwrap();
    }
}
