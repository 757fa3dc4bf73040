//! Why an atlas misses its bound, in words: where most of the distortion is, and what to do about it.

use crate::figures::measure::measure;
use crate::mesh::polygons::Mesh;
use crate::mesh::view::PolygonView;
use glam::{DVec2, DVec3};

/// Height over longest side below which a face is thin: a large face of that shape is a step of the UV grid high.
const THIN: f64 = 1e-6;

/// The cause, as the end of a sentence on the distortion.
pub fn cause(mesh: &Mesh, corner_uv: &[DVec2]) -> String {
    let Mesh { positions, corners, polygon_start, .. } = mesh;
    let view = PolygonView { positions, corners, polygon_start, corner_uv: Some(corner_uv) };
    let worst = measure("", view, None, 0).ok().and_then(|figures| figures.worst_dirichlet.polygon);
    let Some(worst) = worst else { return "and no face can be named".into() };
    let points: Vec<DVec3> = mesh.polygon(worst as usize).map(|c| positions[corners[c] as usize]).collect();
    let face = format!("face {worst} (the first is 0)");
    match points.len() {
        _ if is_thin(&points) => {
            format!("most of it in {face}, which is thinner than a step of the UV grid: remove it")
        }
        3 => format!("most of it in {face}: allow more charts, or more distortion"),
        n => format!("most of it in {face}, a polygon of {n} corners that no plane holds: triangulate it"),
    }
}

/// Whether twice the area of a polygon is next to nothing beside the square of its longest side or diagonal from its first corner.
fn is_thin(points: &[DVec3]) -> bool {
    let Some((first, rest)) = points.split_first() else { return false };
    let area: DVec3 = rest.windows(2).map(|w| (w[0] - *first).cross(w[1] - *first)).sum();
    let sides = rest.windows(2).map(|w| w[0].distance(w[1])).chain(rest.iter().map(|p| p.distance(*first)));
    let longest = sides.fold(0.0, f64::max);
    area.length() <= THIN * longest * longest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(points: &[[f64; 3]], polygon_start: &[u32]) -> String {
        let mesh = Mesh {
            positions: points.iter().map(|p| DVec3::from(*p)).collect(),
            corners: (0..points.len() as u32).collect(),
            polygon_start: polygon_start.to_vec(),
            ..Mesh::default()
        };
        // The first face keeps its shape, the second is stretched.
        let uv: Vec<DVec2> =
            mesh.positions.iter().map(|p| DVec2::new(p.x, p.y * if p.x > 5.0 { 30.0 } else { 1.0 })).collect();
        cause(&mesh, &uv)
    }

    #[test]
    fn the_worst_face_is_named_by_its_place_in_the_file() {
        let first = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
        let second = |y: f64| [[6., 0., 0.], [8., 0., 0.], [7., y, 0.]];
        assert!(told(&[first, second(1.0)].concat(), &[0, 3, 6]).contains("face 1 (the first is 0): allow"));
        assert!(
            told(&[first, second(1e-7)].concat(), &[0, 3, 6]).contains("face 1 (the first is 0), which is thinner")
        );
        let quad = [[6., 0., 0.], [8., 0., 0.], [8., 1., 0.], [6., 1., 0.]];
        assert!(
            told(&[&first[..], &quad].concat(), &[0, 3, 7]).contains("face 1 (the first is 0), a polygon of 4 corners")
        );
        assert_eq!(told(&[], &[0]), "and no face can be named");
    }
}
