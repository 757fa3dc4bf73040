//! Labels of faces from files and to files: which part each polygon of a mesh belongs to.
//!
//! - `text`: `.seg` and `.json`, which go by the order of faces
//! - `places`: coloured `.ply` and `.glb`, whose faces are found by where their vertices are
//! - [`mod@write`], `glb`: the same four, written
//!
//! A file that does not fit the mesh is refused with the counts of both.

use super::{places, text};
use crate::base::failure::Failure;
use crate::formats::bare::{Bare, FormatError, Mark};
use crate::formats::{gltf, ply};
use crate::mesh::polygons::Mesh;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// A label of each polygon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Labels {
    /// Each polygon's label, as an index of `names`.
    pub label: Vec<u32>, // (p)
    /// What the file calls each label: its number, word or colour. Numbers rise, others stand as they come.
    pub names: Vec<String>,
}

/// What kind of file of labels an ending stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One integer a face.
    Seg,
    /// A list, or a map from face to label.
    Json,
    /// A mesh with labels or colours.
    Ply,
    /// A mesh with colours.
    Glb,
}

impl Kind {
    /// By the ending of `path`.
    pub fn of(path: &Path) -> Option<Self> {
        Some(match path.extension()?.to_string_lossy().to_lowercase().as_str() {
            "seg" => Kind::Seg,
            "json" => Kind::Json,
            "ply" => Kind::Ply,
            "glb" => Kind::Glb,
            _ => return None,
        })
    }
}

/// Reads the labels in `path` for `mesh`, which came from `mesh_path`. `flag` is what messages name.
pub fn read(flag: &str, path: &Path, mesh: &Mesh, mesh_path: &Path) -> Result<Labels, Failure> {
    let refuse = |problem: String| Failure::Input(format!("{flag} {}: {problem}", path.display()));
    let Some(kind) = Kind::of(path) else {
        return Err(refuse("labels are read from .seg, .json, .ply and .glb; convert them first".into()));
    };
    let bytes = std::fs::read(path).map_err(|e| Failure::input(path, &e))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let found = match kind {
        Kind::Seg => text::seg(&bytes, mesh.polygon_count()).map(Labels::of_numbers),
        Kind::Json => text::json(&bytes, mesh.polygon_count()).map(Labels::of_names),
        Kind::Ply => coloured(ply::read::read(&bytes), mesh),
        Kind::Glb => coloured(gltf::read::read(&bytes, folder), mesh),
    };
    found.map_err(|problem| refuse(problem.replace("THE MESH", &mesh_path.display().to_string())))
}

/// Labels of a segmented mesh, carried over to `mesh`. Problems call the mesh THE MESH.
fn coloured(bare: Result<Bare, FormatError>, mesh: &Mesh) -> Result<Labels, String> {
    let bare = bare.map_err(|e| e.to_string())?;
    let marks = bare.marks.ok_or("no labels or colours of faces or vertices; export it with them")?;
    let source = places::matching(mesh, &bare.mesh).map_err(|unmatched| {
        format!(
            "{unmatched} of the {} faces of THE MESH have no face at their place among the {} here; use labels of this very mesh",
            mesh.polygon_count(),
            bare.mesh.polygon_count()
        )
    })?;
    Ok(Labels::of_marks(source.into_iter().map(|face| marks[face as usize])))
}

impl Labels {
    fn of_numbers(numbers: Vec<i64>) -> Self {
        Self::of_marks(numbers.into_iter().map(Mark::Label))
    }

    fn of_marks(marks: impl Iterator<Item = Mark>) -> Self {
        let marks: Vec<Mark> = marks.collect();
        let mut number: BTreeMap<Mark, u32> = marks.iter().map(|m| (*m, 0)).collect();
        number.values_mut().enumerate().for_each(|(i, n)| *n = i as u32);
        let names = number.keys().map(|mark| match mark {
            Mark::Label(label) => label.to_string(),
            Mark::Colour(rgb) => {
                let [r, g, b] = rgb.map(|c| c as f64 / 257.0);
                format!("#{:02x}{:02x}{:02x}", r.round() as u8, g.round() as u8, b.round() as u8)
            }
        });
        Self { names: names.collect(), label: marks.iter().map(|m| number[m]).collect() }
    }

    /// Whole numbers in their order; where some label is a word, all are words, as they come.
    fn of_names(all: Vec<String>) -> Self {
        if let Some(numbers) = all.iter().map(|name| name.parse().ok()).collect::<Option<Vec<i64>>>() {
            return Self::of_numbers(numbers);
        }
        let mut known = HashMap::new();
        let mut names = Vec::new();
        let label = all.into_iter().map(|name| {
            *known.entry(name).or_insert_with_key(|name| {
                names.push(name.clone());
                names.len() as u32 - 1
            })
        });
        let label = label.collect();
        Self { label, names }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_rise_and_words_stand_as_they_come() {
        assert_eq!(
            Labels::of_numbers(vec![7, -1, 7]),
            Labels { label: vec![1, 0, 1], names: vec!["-1".into(), "7".into()] }
        );
        let words = ["leg", "3", "leg"].map(String::from).to_vec();
        assert_eq!(Labels::of_names(words), Labels { label: vec![0, 1, 0], names: vec!["leg".into(), "3".into()] });
        let colours = Labels::of_marks([Mark::Colour([65535, 0, 257 * 16])].into_iter());
        assert_eq!(colours.names, ["#ff0010"]);
        assert_eq!(Labels::of_numbers(vec![]), Labels { label: vec![], names: vec![] });
    }
}
