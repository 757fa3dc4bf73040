//! Labels from a file, for the faces of a mesh.
//!
//! A file that does not fit the mesh is refused with the counts of both.

use super::kind::LabelKind;
use super::of_faces::Labels;
use super::{places, text};
use crate::base::failure::Failure;
use crate::formats::error::FormatError;
use crate::formats::gltf::read as gltf;
use crate::formats::model::Model;
use crate::formats::ply::read as ply;
use crate::formats::reading::Reading;
use crate::mesh::polygons::Mesh;
use std::path::Path;

/// Reads the labels in `path` for `mesh`, which came from `mesh_path`. `flag` is what messages name.
pub fn read(flag: &str, path: &Path, mesh: &Mesh, mesh_path: &Path) -> Result<Labels, Failure> {
    let refuse = |problem: String| Failure::Input(format!("{flag} {}: {problem}", path.display()));
    let Some(kind) = LabelKind::of(path) else {
        return Err(refuse("labels are read from .seg, .json, .ply and .glb; convert them first".into()));
    };
    let bytes = std::fs::read(path).map_err(|e| Failure::input(path, &e))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let found = match kind {
        LabelKind::Seg => text::seg(&bytes, mesh.polygon_count()).map(Labels::of_numbers),
        LabelKind::Json => text::json(&bytes, mesh.polygon_count()).map(Labels::of_names),
        LabelKind::Ply => coloured(ply::read(bytes, Reading::default()).map(|file| file.model), mesh),
        LabelKind::Glb => coloured(gltf::read(&bytes, folder, Reading::default()).map(|file| file.model), mesh),
    };
    found.map_err(|problem| refuse(problem.replace("THE MESH", &mesh_path.display().to_string())))
}

/// Labels of a segmented mesh, carried over to `mesh`. Problems call the mesh THE MESH.
fn coloured(model: Result<Model, FormatError>, mesh: &Mesh) -> Result<Labels, String> {
    let model = model.map_err(|e| e.to_string())?;
    let marks = model.marks.ok_or("no labels or colours of faces or vertices; export it with them")?;
    let source = places::matching(mesh, &model.mesh).map_err(|unmatched| {
        format!(
            "{unmatched} of the {} faces of THE MESH have no face at their place among the {} here; use labels of this very mesh",
            mesh.polygon_count(),
            model.mesh.polygon_count()
        )
    })?;
    Ok(Labels::of_marks(source.into_iter().map(|face| marks[face as usize])))
}
