//! The whole: an atlas and the rules that it must keep.
//!
//! Decided by the numbers as they are written, without rounding: every face with an area has one in UV, counter-clockwise; no
//! two have an inner point in common; charts keep their distance; the mesh is the input's. Faces that neighbours outvote are
//! judged as these face. Faces without an area in space (a
//! height below 1e-9 of their longest side) need none in UV; those that meet fewer than three places need only UVs.
//! O(n log n) for atlases as they occur.

use super::boxes::{BoxTree, around};
use super::charts::{across_cracks, border, charts, wedges};
use super::distance::Texels;
use super::facing::turned;
use super::fault::Fault;
use super::gutters::{self, Side};
use super::planar::{doubled_area, interiors_meet};
use super::rings::{places, reduced, unpinched};
use super::same;
use super::stacks::{moved_back, stacked};
use super::tiles::tiles;
use crate::mesh::polygons::Mesh;
use glam::{DVec2, DVec3};

/// Height over the longest side below which a face counts as one without area.
const FLAT: f64 = 1e-9;

/// More faults than these are not looked for.
pub const MOST: usize = 100;

/// What an atlas must keep to.
#[derive(Clone, Copy, Default)]
pub struct Rules<'a> {
    /// What shares a unit square: a number a polygon. `None`: all.
    pub squares: Option<&'a [u32]>,
    /// How far charts are apart; with it, all UVs lie in the unit square.
    pub gap: Option<Texels>,
    /// Cracks up to this share of the mesh's diagonal were closed: what has one UV on both sides of them hangs together.
    pub weld: Option<f64>,
    /// The mesh that was unwrapped.
    pub input: Option<&'a Mesh>,
    /// Whether charts may lie on others as a whole, mirrored too, and one square to the right: one of them is judged, the others have to
    /// coincide with it.
    pub stacks: bool,
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// What is wrong; at most about [`MOST`]. Empty: the atlas keeps every rule.
    pub faults: Vec<Fault>,
    /// Faces.
    pub faces: usize,
    /// Those without an area on the mesh, which need none in UV.
    pub flat: usize,
    /// Those that face the other way than their neighbours, and are judged as these face.
    pub turned: usize,
    /// Sets of faces that hang together in UV, but for those that lie on others.
    pub charts: usize,
    /// Faces of charts that lie on others.
    pub stacked: usize,
}

/// Decides whether the UVs of `mesh` keep the rules.
pub fn verdict(mesh: &Mesh, rules: Rules) -> Verdict {
    let mut verdict = Verdict { faces: mesh.polygon_count(), ..Verdict::default() };
    if let Some(input) = rules.input {
        same::check(input, mesh, MOST, &mut verdict.faults);
    }
    let back = mesh.corner_uv.as_deref().filter(|_| rules.stacks).map(moved_back);
    let Some(uv) = back.as_ref().or(mesh.corner_uv.as_ref()) else {
        verdict.faults.extend((0..mesh.polygon_count().min(MOST)).map(|p| Fault::Unmapped(p as u32)));
        return verdict;
    };
    let place = places(mesh);
    let wedge = wedges(mesh, uv, &place);
    let (mut faces, mut rings) = (Vec::new(), Vec::new());
    for (p, corners) in mesh.polygons().enumerate() {
        let ring = reduced(&place, corners.clone().map(|c| c as u32));
        if let Some(fault) = of_numbers(p as u32, &uv[corners], rules.gap.is_some()) {
            verdict.faults.push(fault);
        } else if ring.len() < 3 {
            verdict.flat += 1;
        } else {
            faces.push(p as u32);
            rings.push(ring);
        }
        if verdict.faults.len() >= MOST {
            return verdict;
        }
    }
    if rules.stacks {
        verdict.stacked = leave_out(&mut faces, &mut rings, mesh, uv, &wedge);
    }
    let areas: Vec<f64> = rings.iter().map(|ring| area(mesh, ring).0).collect();
    let uv_areas: Vec<f64> = rings.iter().map(|ring| doubled_area(ring.iter().map(|c| uv[*c as usize]))).collect();
    let turned = turned(&rings, &place, &wedge, &areas, &uv_areas);
    let mut plane = Plane { mesh, uv, place: &place, rings: Vec::new(), faces: Vec::new(), tiles: Vec::new() };
    for ((p, mut ring), is_turned) in faces.into_iter().zip(rings).zip(turned) {
        if verdict.faults.len() >= MOST {
            return verdict;
        }
        if is_turned {
            ring.reverse();
        }
        verdict.turned += usize::from(is_turned);
        verdict.faults.extend(plane.face(p, ring, &mut verdict.flat));
    }
    plane.overlaps(rules.squares, &mut verdict.faults);
    let cracks = |share| across_cracks(mesh, uv, &wedge, &plane.rings, share * diagonal(mesh));
    let (chart, count) = charts(&wedge, &plane.rings, &rules.weld.map(cracks).unwrap_or_default());
    verdict.charts = count;
    if let Some(gap) = rules.gap.filter(|gap| gap.padding > 0) {
        let side = |([a, b], ring): ([u32; 2], usize)| Side {
            ends: [a, b].map(|c| uv[c as usize]),
            face: plane.faces[ring],
            chart: chart[ring],
            square: rules.squares.map_or(0, |squares| squares[plane.faces[ring] as usize]),
        };
        let sides: Vec<Side> = border(&wedge, &plane.rings).into_iter().map(side).collect();
        gutters::check(&sides, gap, MOST, &mut verdict.faults);
    }
    verdict
}

/// Takes out the faces whose charts lie on others; how many.
fn leave_out(faces: &mut Vec<u32>, rings: &mut Vec<Vec<u32>>, mesh: &Mesh, uv: &[DVec2], wedge: &[u32]) -> usize {
    let lies_on = stacked(rings, uv, wedge, &mesh.corners, |ring| has_no_area(mesh, ring));
    let mut marks = lies_on.iter();
    faces.retain(|_| marks.next() == Some(&false));
    let mut marks = lies_on.iter();
    rings.retain(|_| marks.next() == Some(&false));
    lies_on.iter().filter(|on| **on).count()
}

/// Whether a face has no area on the mesh.
fn has_no_area(mesh: &Mesh, ring: &[u32]) -> bool {
    let (area, longest) = area(mesh, ring);
    area <= FLAT * longest
}

struct Plane<'a> {
    mesh: &'a Mesh,
    uv: &'a [DVec2],
    place: &'a [u32],
    /// Corners of what faces are without repeats and spikes, and the face of each.
    rings: Vec<Vec<u32>>,
    faces: Vec<u32>,
    /// Triangles in UV, and the face of each.
    tiles: Vec<([DVec2; 3], u32)>,
}

impl Plane<'_> {
    /// Takes a face in; says what is wrong with it by itself. `ring` are its corners, as its neighbours face.
    fn face(&mut self, p: u32, ring: Vec<u32>, flat: &mut usize) -> Option<Fault> {
        if self.tile(p, &ring) {
            return None;
        }
        let rings = unpinched(self.place, ring.clone());
        let mut is_flat = false;
        for ring in &rings {
            // A pinched polygon's rings each lie where they like.
            if rings.len() > 1 && self.tile(p, ring) {
                continue;
            }
            if !has_no_area(self.mesh, ring) {
                let is_empty = ring.iter().all(|c| self.uv[*c as usize] == self.uv[ring[0] as usize])
                    || doubled_area(ring.iter().map(|c| self.uv[*c as usize])) == 0.0;
                return Some(if is_empty { Fault::Empty(p) } else { Fault::Flipped(p) });
            }
            is_flat = true;
            self.rings.push(ring.clone());
            self.faces.push(p);
        }
        *flat += usize::from(is_flat);
        None
    }

    /// Takes a ring in where triangles tile it.
    fn tile(&mut self, p: u32, ring: &[u32]) -> bool {
        let points: Vec<DVec2> = ring.iter().map(|c| self.uv[*c as usize]).collect();
        let Some(found) = tiles(&points) else { return false };
        self.tiles.extend(found.into_iter().map(|tile| (tile.map(|i| points[i]), p)));
        self.rings.push(ring.to_vec());
        self.faces.push(p);
        true
    }

    /// Adds a fault for each triangle, up to [`MOST`] in all, that overlaps another.
    fn overlaps(&self, squares: Option<&[u32]>, faults: &mut Vec<Fault>) {
        let boxes: Vec<_> = self.tiles.iter().map(|(tile, _)| around(tile)).collect();
        let tree = BoxTree::new(&boxes);
        let square = |face: u32| squares.map_or(0, |squares| squares[face as usize]);
        for (i, (tile, face)) in self.tiles.iter().enumerate() {
            if faults.len() >= MOST {
                return;
            }
            tree.each(boxes[i], |j| {
                let (other, its) = &self.tiles[j];
                let is_fault = i < j && square(*face) == square(*its) && interiors_meet(tile, other);
                if is_fault {
                    faults.push(if face == its { Fault::Flipped(*face) } else { Fault::Overlap(*face, *its) });
                }
                is_fault
            });
        }
    }
}

/// Of the box of the places that corners name.
fn diagonal(mesh: &Mesh) -> f64 {
    let named = mesh.corners.iter().map(|v| mesh.positions[*v as usize]);
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = named.fold(start, |(low, high), p| (low.min(p), high.max(p)));
    low.distance(high)
}

/// Twice the area of a ring in space, and the square of its longest side, rounded.
fn area(mesh: &Mesh, ring: &[u32]) -> (f64, f64) {
    let at = |c: &u32| mesh.positions[mesh.corners[*c as usize] as usize];
    let origin = at(&ring[0]);
    let pairs = || ring.iter().zip(ring.iter().cycle().skip(1));
    let area: DVec3 = pairs().map(|(a, b)| (at(a) - origin).cross(at(b) - origin)).sum();
    (area.length(), pairs().map(|(a, b)| at(a).distance_squared(at(b))).fold(0.0, f64::max))
}

/// What is wrong with the numbers of a face.
fn of_numbers(p: u32, own: &[DVec2], in_square: bool) -> Option<Fault> {
    if own.iter().any(|uv| uv.is_nan()) {
        return Some(Fault::Unmapped(p));
    }
    if own.iter().any(|uv| !uv.is_finite()) {
        return Some(Fault::NotFinite(p));
    }
    let is_outside = in_square && own.iter().any(|uv| uv.clamp(DVec2::ZERO, DVec2::ONE) != *uv);
    is_outside.then_some(Fault::Outside(p))
}
