//! A mesh that came in another file than an OBJ; its atlas is written to an OBJ made from scratch.

use super::error::FormatError;
use super::mark::Mark;
use crate::mesh::polygons::Mesh;

/// A mesh that came without an OBJ around it.
#[derive(Debug, Default)]
pub struct Bare {
    /// The mesh.
    pub mesh: Mesh,
    /// Lines of the OBJ that stand before a polygon: objects and materials. In order of polygons.
    pub labels: Vec<(usize, String)>,
    /// What tells the parts of a segmented mesh apart: a label or a colour of each polygon, where the file has any.
    pub marks: Option<Vec<Mark>>, // (p)
    /// What was odd, in words for the user.
    pub warnings: Vec<String>,
}

/// Refuses what no stage can take: coordinates that are not finite, corners without a vertex.
pub(super) fn check(mesh: &Mesh) -> Result<(), FormatError> {
    if let Some(v) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(FormatError::whole(format!("vertex {v} (from 0) has a coordinate that is not finite; correct it")));
    }
    let count = mesh.positions.len();
    if let Some(c) = mesh.corners.iter().position(|v| *v as usize >= count) {
        let polygon = mesh.polygon_start.partition_point(|start| *start as usize <= c) - 1;
        let vertex = mesh.corners[c];
        let text =
            format!("face {polygon} names vertex {vertex} (both from 0), but there are {count}; correct the face");
        return Err(FormatError::whole(text));
    }
    Ok(())
}
