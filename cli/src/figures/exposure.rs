//! Exposure of the vertices of any file's mesh, for [`measure`](crate::figures::measure).
//!
//! Nothing is repaired: polygons are fans, positions that are equal to the bit are one point, normals are weighted by area,
//! the mesh is centred and its largest coordinate is 1. These are libigl's conventions, so that figures over exposure
//! compare with those of evaluators that are built on it. `unwrap` has its own exposure, of the repaired mesh.

use super::sampled::Weighting;
use crate::mesh::polygons::Mesh;
use crate::mesh::triangles::of_mesh;
use crate::run::hierarchy::ObvhsBuilder;
use glam::{DVec3, Vec3};
use seamwright_core::base::progress::Wish;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Workers;
use seamwright_core::mesh::normals::{NormalWeight, vertex_normals};
use seamwright_core::mesh::view::MeshView;
use seamwright_core::mesh::weld::{weld, weld_need};
use seamwright_core::rays::bvh::BvhError;
use seamwright_core::rays::cast::Scene;
use seamwright_core::rays::exposure::{ExposureSettings, exposure, exposure_need};

/// Points between two reports.
const SLICE: usize = 4096;

/// Why there is no exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExposureError {
    /// The report asked to stop.
    Stopped,
    /// The hierarchy over the faces cannot be built.
    Tree(BvhError),
}

/// Exposure of each vertex of `mesh`, 1 open; `report` hears of points done and of all, and can stop the run. Equal for
/// vertices at one place. Takes about 250 bytes a triangle.
pub fn vertex_exposure(
    mesh: &Mesh,
    weighting: Weighting,
    rays: usize,
    workers: &dyn Workers,
    report: &mut dyn FnMut(usize, usize) -> Wish,
) -> Result<Vec<f32>, ExposureError> {
    let (place, points) = points(&mesh.positions)?;
    let corners: Vec<u32> = mesh.corners.iter().map(|v| place[*v as usize]).collect();
    let faces: Vec<[u32; 3]> = of_mesh(mesh).into_iter().map(|(_, t)| t.map(|c| corners[c as usize])).collect();
    let mut normals = vec![DVec3::ZERO; points.len()];
    vertex_normals(&mut normals, MeshView { positions: &points, faces: &faces }, NormalWeight::Area);
    let points: Vec<Vec3> = points.iter().map(|p| p.as_vec3()).collect();
    let normals: Vec<Vec3> = normals.iter().map(|n| n.as_vec3()).collect();

    let mut bytes = vec![0; Scene::need(faces.len(), &ObvhsBuilder) + exposure_need(rays)];
    let mut scratch = Scratch::new(&mut bytes);
    let scene = Scene::new(&points, &faces, &ObvhsBuilder, &mut scratch).map_err(ExposureError::Tree)?;
    let mut open = vec![0.0; points.len()];
    for first in (0..points.len()).step_by(SLICE) {
        if report(first, points.len()) == Wish::Stop {
            return Err(ExposureError::Stopped);
        }
        let slice = first..(first + SLICE).min(points.len());
        let settings = ExposureSettings { rays, spread: weighting.spread(), first, ..Default::default() };
        let (points, normals) = (&points[slice.clone()], &normals[slice.clone()]);
        exposure(&mut open[slice], points, normals, &scene, &settings, scratch.frame(), workers)
            .map_err(|e| ExposureError::Tree(e.into()))?;
    }
    Ok(place.iter().map(|p| open[*p as usize]).collect())
}

/// The different positions, centred, the largest coordinate 1; and which of them each vertex is at.
fn points(positions: &[DVec3]) -> Result<(Vec<u32>, Vec<DVec3>), ExposureError> {
    let mut place: Vec<u32> = (0..positions.len() as u32).collect();
    let mut bytes = vec![0; weld_need(positions.len())];
    weld(&mut place, positions, Scratch::new(&mut bytes)).map_err(|e| ExposureError::Tree(e.into()))?;
    let low = positions.iter().fold(DVec3::INFINITY, |m, p| m.min(*p));
    let high = positions.iter().fold(DVec3::NEG_INFINITY, |m, p| m.max(*p));
    // Halves first: the sum of two finite numbers may not be one.
    let centre = low * 0.5 + high * 0.5;
    let reach = (high * 0.5 - low * 0.5).max_element();
    let scale = |p: DVec3| if reach > 0.0 { (p - centre) / reach } else { DVec3::ZERO };
    let mut points = Vec::new();
    for v in 0..positions.len() {
        // The lowest vertex at a place comes first.
        if place[v] as usize == v {
            place[v] = points.len() as u32;
            points.push(scale(positions[v]));
        } else {
            place[v] = place[place[v] as usize];
        }
    }
    Ok((place, points))
}

#[cfg(test)]
mod tests {
    use super::*;
    use seamwright_core::base::workers::Serial;

    fn exposed(mesh: &Mesh, weighting: Weighting) -> Vec<f32> {
        vertex_exposure(mesh, weighting, 4096, &Serial, &mut |_, _| Wish::GoOn).unwrap()
    }

    /// Two squares that meet along the y axis at an angle of `degrees`, their inside up, and vertex 8 on the floor near
    /// the middle of the crease.
    fn valley(degrees: f64) -> Mesh {
        let a = degrees.to_radians();
        let far = DVec3::new(a.cos(), 0.0, a.sin());
        // Long, so that the ends of the trough do not count in its middle.
        let y = DVec3::Y * 1000.0;
        let floor = [DVec3::ZERO, DVec3::X * 1000.0, DVec3::X * 1000.0 + y, y];
        let wall = [DVec3::ZERO, y, y + far * 1000.0, far * 1000.0];
        let middle = [DVec3::X, DVec3::X * 2.0, DVec3::X + DVec3::Y].map(|p| y * 0.5 + p * 10.0);
        let positions = [&floor[..], &wall, &middle].concat();
        let corners = (0..11).collect();
        Mesh { positions, corners, polygon_start: vec![0, 4, 8, 11], ..Mesh::default() }
    }

    #[test]
    fn a_wall_hides_its_share_of_the_sky() {
        // A point next to a wall at 90 degrees sees half of the hemisphere, and half of the cosine-weighted one.
        let mesh = valley(90.0);
        for weighting in [Weighting::Uniform, Weighting::Cosine] {
            let open = exposed(&mesh, weighting);
            assert!((open[8] - 0.5).abs() < 0.02, "{weighting:?}: {}", open[8]);
        }
        // At 30 degrees between floor and wall the wedge that is left is 1/6 of the hemisphere, and (1 - cos 30)/2 of
        // the weighted one.
        let mesh = valley(30.0);
        assert!((exposed(&mesh, Weighting::Uniform)[8] - 1.0 / 6.0).abs() < 0.02);
        assert!((exposed(&mesh, Weighting::Cosine)[8] - 0.067).abs() < 0.02);
    }

    #[test]
    fn vertices_at_one_place_have_one_value_wherever_the_mesh_stands() {
        let mesh = valley(60.0);
        let open = exposed(&mesh, Weighting::Uniform);
        assert_eq!((open[0], open[3]), (open[4], open[5]));
        let moved = Mesh { positions: mesh.positions.iter().map(|p| *p * 4.0 + 8192.0).collect(), ..mesh };
        let there = exposed(&moved, Weighting::Uniform);
        assert!(open.iter().zip(&there).all(|(a, b)| (a - b).abs() < 0.02), "{open:?} {there:?}");
    }

    #[test]
    fn a_mesh_that_is_one_point_is_no_reason_to_fail() {
        let positions = vec![DVec3::ONE; 3];
        let mesh = Mesh { positions, corners: vec![0, 1, 2], polygon_start: vec![0, 3], ..Mesh::default() };
        assert_eq!(exposed(&mesh, Weighting::Uniform), [1.0; 3]);
    }

    #[test]
    fn the_report_can_stop_the_run() {
        let result = vertex_exposure(&valley(90.0), Weighting::Cosine, 8, &Serial, &mut |_, _| Wish::Stop);
        assert_eq!(result, Err(ExposureError::Stopped));
    }
}
