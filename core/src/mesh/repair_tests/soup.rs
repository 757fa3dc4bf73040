//! Polygons to repair: exact small ones and noise, and what `repair` promises of them.

use crate::base::random;
use crate::base::scratch::Scratch;
use crate::mesh::loops::{ComponentShape, shapes, shapes_need};
use crate::mesh::polygons::Polygons;
use crate::mesh::repair::{Facing, RepairError, RepairSummary, repair, repair_need};
use crate::mesh::topology::{fan, twins, twins_need, vertex_corners};
use crate::mesh::view::NONE;
use crate::mesh::working::{DIAGONAL, Working};
use approx::assert_abs_diff_eq;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::vec::Vec;
use std::{assert, assert_eq, vec};

/// Polygons that own their memory.
#[derive(Clone, Default)]
pub struct Soup {
    pub positions: Vec<DVec3>,
    pub corners: Vec<u32>,
    pub polygon_start: Vec<u32>,
    pub uv: Option<Vec<DVec2>>,
}

impl Soup {
    pub fn new(positions: &[[f64; 3]], polygons: &[&[u32]]) -> Self {
        let mut soup = Self { positions: positions.iter().map(|p| DVec3::from_array(*p)).collect(), ..Self::default() };
        polygons.iter().for_each(|p| soup.push(p));
        soup
    }

    pub fn push(&mut self, polygon: &[u32]) {
        if self.polygon_start.is_empty() {
            self.polygon_start.push(0);
        }
        self.corners.extend_from_slice(polygon);
        self.polygon_start.push(self.corners.len() as u32);
    }

    pub fn view(&self) -> Polygons<'_> {
        Polygons {
            positions: &self.positions,
            corners: &self.corners,
            polygon_start: &self.polygon_start,
            kept_uv: self.uv.as_deref(),
        }
    }

    /// Repairs, checks everything that `repair` promises, and lets `look` see the result.
    pub fn repaired<T>(&self, look: impl FnOnce(&Working, &RepairSummary) -> T) -> T {
        let mut bytes = vec![0xa5u8; repair_need(&self.view().counts())];
        let mut scratch = Scratch::new(&mut bytes);
        let (working, summary) = repair(&self.view(), Facing::Turned, &mut scratch).unwrap();
        assert_promises(self, &working, &summary);
        look(&working, &summary)
    }

    pub fn summary(&self) -> RepairSummary {
        self.repaired(|_, summary| *summary)
    }

    pub fn error(&self) -> RepairError {
        let mut bytes = vec![0u8; repair_need(&self.view().counts())];
        repair(&self.view(), Facing::Turned, &mut Scratch::new(&mut bytes)).map(|_| ()).unwrap_err()
    }
}

pub fn assert_promises(soup: &Soup, working: &Working, summary: &RepairSummary) {
    let mesh = working.mesh();
    let vertex_count = mesh.positions.len();
    assert!(mesh.faces.iter().all(|&[a, b, c]| a != b && b != c && c != a));

    let mut twin = vec![0; mesh.corner_count()];
    let mut bytes = vec![0u8; twins_need(mesh.faces.len())];
    assert_eq!(twins(&mut twin, mesh, Scratch::new(&mut bytes)), Ok(0), "crowded edges");
    assert_eq!(twin, working.twin);

    let mut lowest = vec![0; vertex_count];
    vertex_corners(&mut lowest, mesh.faces);
    let in_fans: usize = lowest.iter().map(|c| fan(working.twin, *c).count()).sum();
    assert_eq!(in_fans, mesh.corner_count(), "a vertex of two fans, or of none");

    let mut vertex_of = BTreeMap::new();
    for (c, &source) in working.corner_source.iter().enumerate() {
        let (vertex, polygon) = (mesh.vertex(c as u32), working.polygon[c / 3] as usize);
        assert_eq!(*vertex_of.entry(source).or_insert(vertex), vertex, "an input corner would need two UVs");
        assert!((soup.polygon_start[polygon]..soup.polygon_start[polygon + 1]).contains(&source));
        let input = soup.corners[source as usize] as usize;
        assert_eq!(working.vertex_source[vertex as usize], working.welded[input]);
        let back = mesh.position(c as u32) * working.extent + working.centre;
        let rounding = 4.0 * f64::EPSILON * (working.extent + working.centre.length());
        assert!(back.distance(soup.positions[input]) <= rounding);
        let twin = working.twin[c];
        let inner = twin != NONE && working.polygon[twin as usize / 3] as usize == polygon;
        assert!(working.fixed[c] != DIAGONAL || inner);
        assert!(twin == NONE || working.fixed[c] == working.fixed[twin as usize]);
    }
    assert!(working.polygon.is_sorted(), "the faces of a polygon stand together");
    let low = mesh.positions.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = mesh.positions.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    // Centre and sides are each rounded once, to the size of the largest coordinate.
    let rounding = 4.0 * f64::EPSILON * (1.0 + working.centre.length() / working.extent);
    assert_abs_diff_eq!((high - low).max_element(), 1.0, epsilon = rounding);
    assert!((low + high).abs().max_element() < rounding);

    assert_components(working, summary);
    assert_eq!(summary.split_vertices, {
        let mut places = working.vertex_source.to_vec();
        places.sort_unstable();
        places.dedup();
        vertex_count - places.len()
    });
}

/// Components, loops and Euler numbers against a flood over twins.
fn assert_components(working: &Working, summary: &RepairSummary) {
    let mut flooded = vec![NONE; working.faces.len()];
    let mut count = 0;
    for seed in 0..working.faces.len() {
        let mut stack = vec![seed];
        if flooded[seed] != NONE {
            continue;
        }
        flooded[seed] = count;
        while let Some(f) = stack.pop() {
            for t in &working.twin[3 * f..3 * f + 3] {
                let g = (*t / 3) as usize;
                if *t != NONE && flooded[g] == NONE {
                    flooded[g] = count;
                    stack.push(g);
                }
            }
        }
        count += 1;
    }
    assert_eq!((flooded, count as usize), (working.component.to_vec(), working.component_count));

    let mut shape = vec![ComponentShape::default(); working.component_count];
    let mut bytes = vec![0u8; shapes_need(working.faces.len(), working.positions.len())];
    let scratch = Scratch::new(&mut bytes);
    shapes(&mut shape, working.faces, working.twin, working.component, working.positions.len(), scratch).unwrap();
    assert!(shape.iter().all(|s| s.genus() >= 0 && (2 - i64::from(s.loops) - s.euler()) % 2 == 0));
    let sums = shape.iter().fold((0, 0, 0), |sum, s| (sum.0 + s.euler(), sum.1 + s.genus(), sum.2 + s.loops as usize));
    assert_eq!((summary.euler, summary.genus, summary.boundary_loops), sums);
    assert_eq!(summary.components, working.component_count);
}

/// A grid of n x m quads over the parameter square [0,1]^2, with all vertices separate: closing it is welding's work.
pub fn surface(n: u32, m: u32, at: impl Fn(u32, u32) -> [f64; 3]) -> Soup {
    let mut soup = Soup::default();
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let first = soup.positions.len() as u32;
        for (i, j) in [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)] {
            soup.positions.push(DVec3::from_array(at(i, j)));
        }
        soup.push(&[first, first + 1, first + 2, first + 3]);
    }
    soup
}

pub fn cube(origin: [f64; 3], side: f64) -> Soup {
    let at = |i: u32, axis: u32| origin[axis as usize] + f64::from(i >> axis & 1) * side;
    let positions: Vec<_> = (0..8).map(|i| [at(i, 0), at(i, 1), at(i, 2)]).collect();
    let sides: [&[u32]; 6] = [&[0, 2, 3, 1], &[4, 5, 7, 6], &[0, 1, 5, 4], &[2, 6, 7, 3], &[0, 4, 6, 2], &[1, 3, 7, 5]];
    Soup::new(&positions, &sides)
}

pub fn together(parts: &[Soup]) -> Soup {
    let mut all = Soup::default();
    for part in parts {
        let first = all.positions.len() as u32;
        all.positions.extend_from_slice(&part.positions);
        for polygon in part.view().polygons() {
            let corners = &part.corners[polygon.start as usize..polygon.end as usize];
            all.push(&corners.iter().map(|v| v + first).collect::<Vec<_>>());
        }
    }
    all
}

/// Random polygons over few vertices at few places: nearly every edge is crowded.
pub fn noise(seed: u64, vertices: u64, polygons: u64) -> Soup {
    let draw = |stream, index, below| random::hash(seed, stream, index) % below;
    let mut soup = Soup::default();
    for v in 0..vertices {
        let at = |axis| draw(axis, v, 5) as f64 + if draw(9, v, 3) == 0 { 0.25 } else { 0.0 };
        soup.positions.push(DVec3::new(at(0), at(1), at(2)));
    }
    soup.push(&[0, 1, 2]);
    for p in 0..polygons {
        let n = [3, 3, 4, 4, 5, 7, 9][draw(3, p, 7) as usize];
        let near = draw(4, p, vertices);
        let corners: Vec<_> = (0..n).map(|i| ((near + draw(5, p * 16 + i, 6)) % vertices) as u32).collect();
        soup.push(&corners);
    }
    soup
}
