//! What the user should know of a mesh that was unwrapped as it is, but may not be meant so.

use crate::mesh::polygons::Mesh;
use crate::run::atlas::Atlas;
use glam::DVec3;

/// Mean exposure below which a mesh that is turned inside out is told of: seen from outside, its faces show their backs.
const HARDLY_OPEN: f64 = 0.15;
/// Area, over the square of the mesh's size, below which a polygon has none to speak of.
const EMPTY: f64 = 1e-14;
/// Pieces of surface, and share of their sides that are borders, from which on they may have been parted by cracks.
const PARTED: (usize, f64) = (16, 0.5);

/// What to look at, and what to do about it. `closes` says whether cracks were closed where there are some.
pub fn hints(mesh: &Mesh, atlas: &Atlas, closes: bool) -> Vec<String> {
    let repaired = &atlas.report.repaired;
    let sides = mesh.corners.len().max(1) as f64;
    let mean = atlas.exposure.iter().map(|e| f64::from(*e)).sum::<f64>() / atlas.exposure.len().max(1) as f64;
    let mut told = Vec::new();
    if mean < HARDLY_OPEN && is_inside_out(mesh) {
        told.push(format!(
            "faces that turn inwards: from outside their backs are seen (mean exposure {mean:.2}), so that seams cannot be hidden; turn them over, \
             unless the inside is what is looked at"
        ));
    }
    let (pieces, share) = PARTED;
    if !closes && repaired.components >= pieces && repaired.border_edges as f64 >= share * sides {
        told.push(format!(
            "{} pieces whose edges are mostly borders: if they should hang together, --weld auto closes the cracks between them",
            repaired.components
        ));
    }
    if atlas.report.utilisation < f64::EPSILON || !has_area(mesh) {
        told.push("no polygon has an area to speak of, so the atlas is empty; look at the mesh's positions".into());
    }
    told
}

/// Whether the volume that the faces enclose is negative.
fn is_inside_out(mesh: &Mesh) -> bool {
    let (middle, extent) = frame(mesh);
    let at = |c: u32| (mesh.positions[c as usize] - middle) / extent;
    let volume = |corners: &[u32]| -> f64 {
        (2..corners.len()).map(|i| at(corners[0]).dot(at(corners[i - 1]).cross(at(corners[i])))).sum()
    };
    mesh.polygons().map(|range| volume(&mesh.corners[range])).sum::<f64>() < 0.0
}

/// Whether a polygon has area to speak of.
fn has_area(mesh: &Mesh) -> bool {
    let (middle, extent) = frame(mesh);
    let at = |c: u32| (mesh.positions[c as usize] - middle) / extent;
    let area = |corners: &[u32]| -> DVec3 {
        (2..corners.len()).map(|i| (at(corners[i - 1]) - at(corners[0])).cross(at(corners[i]) - at(corners[0]))).sum()
    };
    mesh.polygons().any(|range| area(&mesh.corners[range]).length() > EMPTY)
}

/// Middle of the vertices, and the distance of the farthest along an axis.
fn frame(mesh: &Mesh) -> (DVec3, f64) {
    let count = mesh.positions.len().max(1) as f64;
    // Divided before they are added: sums of huge positions would overflow.
    let middle: DVec3 = mesh.positions.iter().map(|p| *p / count).sum();
    let extent = mesh.positions.iter().map(|p| (*p - middle).abs().max_element()).fold(f64::MIN_POSITIVE, f64::max);
    (middle, extent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use seamwright_core::pipeline::Report;

    /// A tetrahedron, its faces outwards or inwards.
    fn tetrahedron(inwards: bool) -> Mesh {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| p * 1e200).to_vec();
        let corners = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let corners = corners.iter().flat_map(|f| if inwards { [f[2], f[1], f[0]] } else { *f }).collect();
        Mesh { positions, corners, polygon_start: vec![0, 3, 6, 9, 12], ..Mesh::default() }
    }

    fn atlas(exposure: f32, utilisation: f64) -> Atlas {
        let report = Report { utilisation, ..Report::default() };
        Atlas { corner_uv: Vec::new(), polygon_chart: Vec::new(), exposure: vec![exposure; 4], report }
    }

    #[test]
    fn a_mesh_that_is_turned_inside_out_and_hardly_open_is_told_of() {
        let told = |inwards, exposure| hints(&tetrahedron(inwards), &atlas(exposure, 0.5), false).len();
        assert_eq!([told(true, 0.0), told(true, 0.9), told(false, 0.0)], [1, 0, 0]);
    }

    #[test]
    fn many_pieces_with_borders_all_over_are_told_of_unless_cracks_were_closed() {
        let mut atlas = atlas(1.0, 0.5);
        (atlas.report.repaired.components, atlas.report.repaired.border_edges) = (20, 8);
        assert_eq!([false, true].map(|closes| hints(&tetrahedron(false), &atlas, closes).len()), [1, 0]);
        atlas.report.repaired.border_edges = 2;
        assert_eq!(hints(&tetrahedron(false), &atlas, false).len(), 0);
    }

    #[test]
    fn an_atlas_of_nothing_is_told_of() {
        assert!(hints(&tetrahedron(false), &atlas(1.0, 0.0), false)[0].contains("no polygon has an area"));
    }
}
