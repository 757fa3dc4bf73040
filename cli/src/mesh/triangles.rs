//! Polygons as triangles, the same that core's repair makes of them: what is measured and drawn is what was unwrapped.

use super::polygons::Mesh;
use super::view::PolygonView;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::judge::input::fan;
use seamwright_core::mesh::polygons::Polygons;
use seamwright_core::mesh::triangles::{triangles_need, triangles_of};

/// The triangles of every polygon, as its number and three corners. Polygons that repair cannot read (a vertex that is not
/// there, or that is no number) make all of them fans. 100 bytes a triangle where a polygon has more than three corners.
pub fn triangles(mesh: PolygonView) -> Vec<(usize, [u32; 3])> {
    let PolygonView { positions, corners, polygon_start, .. } = mesh;
    let fans = || {
        let ends = polygon_start.windows(2).enumerate();
        ends.flat_map(|(p, ends)| fan(ends[0], ends[1]).map(move |triangle| (p, triangle))).collect()
    };
    if polygon_start.windows(2).all(|ends| ends[1].saturating_sub(ends[0]) <= 3) {
        return fans();
    }
    let input = Polygons { positions, corners, polygon_start, kept_uv: None };
    let need = triangles_need(&input.counts());
    let mut bytes = vec![0; if need < usize::MAX { need } else { 0 }];
    match triangles_of(&input, &mut Scratch::new(&mut bytes)) {
        Ok(found) => found.polygon.iter().map(|p| *p as usize).zip(found.corners.iter().copied()).collect(),
        Err(_) => fans(),
    }
}

/// The triangles of a mesh as its file has it.
pub fn of_mesh(mesh: &Mesh) -> Vec<(usize, [u32; 3])> {
    let Mesh { positions, corners, polygon_start, .. } = mesh;
    triangles(PolygonView { positions, corners, polygon_start, corner_uv: None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_convex_pentagon_is_a_fan_a_concave_quad_is_not_and_what_is_no_number_is() {
        let points = [(0., 0.), (2., 0.), (3., 1.), (2., 2.), (0., 2.), (2.5, 1.)];
        let mut mesh = Mesh {
            positions: points.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec(),
            corners: vec![0, 1, 5, 0, 1, 2, 3, 4, 1, 2, 3, 5],
            polygon_start: vec![0, 3, 8, 12],
            ..Mesh::default()
        };
        let fan = [(0, [0, 1, 2]), (1, [3, 4, 5]), (1, [3, 5, 6]), (1, [3, 6, 7])];
        let found = of_mesh(&mesh);
        assert_eq!(found[..4], fan);
        assert!(found[4..].iter().all(|(p, t)| *p == 2 && t.contains(&9) && t.contains(&11)), "{found:?}");
        mesh.positions[0].x = f64::NAN;
        assert_eq!(of_mesh(&mesh)[4..], [(2, [8, 9, 10]), (2, [8, 10, 11])]);
    }
}
