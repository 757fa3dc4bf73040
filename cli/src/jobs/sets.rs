//! Polygons that share an atlas, and the atlases of several sets as one.

use crate::args::group::GroupArg;
use crate::formats::model::Model;
use crate::mesh::polygons::Mesh;
use crate::run::atlas::Atlas;
use glam::DVec2;
use seamwright_core::mesh::repair::RepairSummary;
use seamwright_core::mesh::view::NONE;
use seamwright_core::pipeline::Report;
use std::collections::HashMap;

/// Polygons that share an atlas.
pub(super) struct Set {
    /// The object's name, as far as it has one.
    pub name: String,
    /// Its polygons, rising.
    pub polygons: Vec<u32>,
}

/// The sets that `group` makes of a model, in the order in which they come first. Polygons of no piece are a set of their
/// own. Never empty for a model that has polygons.
pub(super) fn sets(model: &Model, group: GroupArg) -> Vec<Set> {
    let count = model.mesh.polygon_count() as u32;
    if group == GroupArg::Scene {
        return vec![Set { name: String::new(), polygons: (0..count).collect() }];
    }
    let mut place_of = HashMap::new();
    let mut sets: Vec<Set> = Vec::new();
    let mut add = |key: Option<u32>, name: &str, polygons: core::ops::Range<u32>| {
        if polygons.is_empty() {
            return;
        }
        let place = *place_of.entry(key).or_insert(sets.len());
        if place == sets.len() {
            sets.push(Set { name: name.into(), polygons: Vec::new() });
        }
        sets[place].polygons.extend(polygons);
    };
    add(None, "", 0..model.pieces.first().map_or(count, |piece| piece.first as u32));
    for (piece, polygons) in model.runs() {
        let key = if group == GroupArg::Mesh { piece.mesh } else { piece.primitive };
        add(Some(key), &piece.name, polygons.start as u32..polygons.end as u32);
    }
    sets
}

/// The mesh of some polygons, and the vertex of `mesh` that each of its vertices is.
pub(super) fn part(mesh: &Mesh, polygons: &[u32]) -> (Mesh, Vec<u32>) {
    let mut part = Mesh { tolerance: mesh.tolerance, ..Mesh::new() };
    let mut number = vec![NONE; mesh.positions.len()];
    let mut vertices = Vec::new();
    let corners = || polygons.iter().flat_map(|p| mesh.polygon(*p as usize));
    for p in polygons {
        for c in mesh.polygon(*p as usize) {
            let vertex = mesh.corners[c];
            let own = &mut number[vertex as usize];
            if *own == NONE {
                *own = vertices.len() as u32;
                vertices.push(vertex);
                part.positions.push(mesh.positions[vertex as usize]);
            }
            part.corners.push(*own);
        }
        part.polygon_start.push(part.corners.len() as u32);
    }
    part.corner_uv = mesh.corner_uv.as_ref().map(|all| corners().map(|c| all[c]).collect());
    part.corner_normals = mesh.corner_normals.as_ref().map(|all| corners().map(|c| all[c]).collect());
    part.edge_marks = mesh.edge_marks.as_ref().map(|all| corners().map(|c| all[c]).collect());
    (part, vertices)
}

/// Whether some polygon has three different places, so that there is something to unwrap.
pub(super) fn has_triangle(mesh: &Mesh) -> bool {
    mesh.polygons().any(|p| {
        let at = |c: usize| mesh.positions[mesh.corners[c] as usize];
        let first = at(p.start);
        let second = p.clone().map(at).find(|place| *place != first);
        second.is_some_and(|second| p.clone().map(at).any(|place| place != first && place != second))
    })
}

/// The atlases of all sets as one of the whole mesh: charts are numbered on, figures are those of all sets together.
pub(super) struct Joined<'a> {
    mesh: &'a Mesh,
    atlas: Atlas,
    area: f64,
    sets: usize,
}

impl<'a> Joined<'a> {
    /// No set yet: every corner at 0, 0.
    pub fn new(mesh: &'a Mesh) -> Self {
        let atlas = Atlas {
            corner_uv: vec![DVec2::ZERO; mesh.corners.len()],
            polygon_chart: vec![NONE; mesh.polygon_count()],
            exposure: vec![0.0; mesh.positions.len()],
            report: Report { overlapping: 0, ..Report::default() },
        };
        Self { mesh, atlas, area: 0.0, sets: 0 }
    }

    /// Adds the atlas of `set`, whose mesh has these `vertices` of the whole.
    pub fn add(&mut self, set: &Set, vertices: &[u32], atlas: &Atlas) {
        let mut from = atlas.corner_uv.iter();
        let first_chart = self.atlas.report.chart_count as u32;
        for (p, chart) in set.polygons.iter().zip(&atlas.polygon_chart) {
            let corners = self.mesh.polygon(*p as usize);
            self.atlas.corner_uv[corners].iter_mut().zip(&mut from).for_each(|(to, uv)| *to = *uv);
            self.atlas.polygon_chart[*p as usize] = if *chart == NONE { NONE } else { first_chart + chart };
        }
        for (v, open) in vertices.iter().zip(&atlas.exposure) {
            let own = &mut self.atlas.exposure[*v as usize];
            *own = own.max(*open); // of a vertex that several sets have, the side that is seen
        }
        let area: f64 = set.polygons.iter().map(|p| area(self.mesh, *p as usize)).sum();
        let (all, own) = (&mut self.atlas.report, &atlas.report);
        all.distortion = mean(all.distortion, self.area, own.distortion, area);
        all.utilisation = mean(all.utilisation, self.sets as f64, own.utilisation, 1.0);
        all.padding = if self.sets == 0 { own.padding } else { all.padding.min(own.padding) };
        all.chart_count += own.chart_count;
        all.flipped += own.flipped;
        all.overlapping += own.overlapping;
        all.closed_breaks += own.closed_breaks;
        all.stacked += own.stacked;
        all.repaired = sum(&all.repaired, &own.repaired);
        self.area += area;
        self.sets += 1;
    }

    /// The whole.
    pub fn finish(self) -> Atlas {
        self.atlas
    }
}

fn mean(a: f64, weight_a: f64, b: f64, weight_b: f64) -> f64 {
    let weight = weight_a + weight_b;
    if weight > 0.0 { (a * weight_a + b * weight_b) / weight } else { b }
}

/// Area of a polygon, by Newell's sum.
fn area(mesh: &Mesh, p: usize) -> f64 {
    let corners = mesh.polygon(p);
    let at = |c: usize| mesh.positions[mesh.corners[c] as usize];
    let origin = at(corners.start);
    let sides = corners.clone().zip(corners.clone().skip(1));
    let sum: glam::DVec3 = sides.map(|(a, b)| (at(a) - origin).cross(at(b) - origin)).sum();
    0.5 * sum.length()
}

fn sum(a: &RepairSummary, b: &RepairSummary) -> RepairSummary {
    RepairSummary {
        welded_vertices: a.welded_vertices + b.welded_vertices,
        dropped_triangles: a.dropped_triangles + b.dropped_triangles,
        dropped_polygons: a.dropped_polygons + b.dropped_polygons,
        damaged_polygons: a.damaged_polygons + b.damaged_polygons,
        flat_faces: a.flat_faces + b.flat_faces,
        flipped_faces: a.flipped_faces + b.flipped_faces,
        split_edges: a.split_edges + b.split_edges,
        copied_edges: a.copied_edges + b.copied_edges,
        one_sided_edges: a.one_sided_edges + b.one_sided_edges,
        split_vertices: a.split_vertices + b.split_vertices,
        components: a.components + b.components,
        boundary_loops: a.boundary_loops + b.boundary_loops,
        euler: a.euler + b.euler,
        genus: a.genus + b.genus,
        border_edges: a.border_edges + b.border_edges,
        closed_edges: a.closed_edges + b.closed_edges,
        weld_tolerance: a.weld_tolerance.max(b.weld_tolerance),
        crack_width: a.crack_width.max(b.crack_width),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::model::Piece;
    use glam::DVec3;

    fn model() -> Model {
        let positions = (0..8).map(|i| DVec3::new((i / 2) as f64, (i % 2) as f64, 0.0)).collect();
        let corners = vec![0, 2, 3, 1, 2, 4, 5, 3, 4, 6, 7, 5];
        let mesh = Mesh { positions, corners, polygon_start: vec![0, 4, 8, 12], ..Mesh::default() };
        let piece = |first, mesh, primitive| Piece { first, mesh, primitive, ..Piece::default() };
        Model { pieces: vec![piece(0, 7, 0), piece(1, 8, 1), piece(2, 7, 2)], ..Model::of(mesh) }
    }

    #[test]
    fn sets_are_what_was_asked_for() {
        let of = |group| sets(&model(), group).into_iter().map(|set| set.polygons).collect::<Vec<_>>();
        assert_eq!(of(GroupArg::Scene), [[0, 1, 2]]);
        assert_eq!(of(GroupArg::Mesh), [vec![0, 2], vec![1]]);
        assert_eq!(of(GroupArg::Primitive), [[0], [1], [2]]);
    }

    #[test]
    fn atlases_of_sets_come_together_where_their_polygons_are() {
        let model = model();
        let mut joined = Joined::new(&model.mesh);
        for (k, set) in sets(&model, GroupArg::Mesh).iter().enumerate() {
            let (mesh, vertices) = part(&model.mesh, &set.polygons);
            assert!(has_triangle(&mesh));
            let uv = (0..mesh.corners.len()).map(|c| DVec2::new(c as f64, k as f64)).collect();
            let report = Report { chart_count: 2, distortion: 1.0 + k as f64, utilisation: 0.5, ..Report::default() };
            let polygon_chart = (0..mesh.polygon_count() as u32).collect();
            let atlas = Atlas { corner_uv: uv, polygon_chart, exposure: vec![0.5; mesh.positions.len()], report };
            joined.add(set, &vertices, &atlas);
        }
        let atlas = joined.finish();
        let u: Vec<f64> = atlas.corner_uv.iter().map(|uv| uv.x + 100.0 * uv.y).collect();
        assert_eq!(u, [0.0, 1.0, 2.0, 3.0, 100.0, 101.0, 102.0, 103.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!((&atlas.polygon_chart[..], atlas.report.chart_count), (&[0, 2, 1][..], 4));
        assert!((atlas.report.distortion - 4.0 / 3.0).abs() < 1e-12 && atlas.report.utilisation == 0.5);
        assert!(atlas.exposure.iter().all(|e| *e == 0.5));
    }

    #[test]
    fn what_has_no_triangle_is_known() {
        let mesh = Mesh { positions: vec![DVec3::X, DVec3::X, DVec3::Y], ..Mesh::default() };
        assert!(!has_triangle(&Mesh { corners: vec![0, 1, 2], polygon_start: vec![0, 3], ..mesh }));
    }
}
