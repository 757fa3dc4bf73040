//! A mesh from a file, and what else of the file a writer of another format can take along.

use super::error::FormatError;
use super::mark::Mark;
use crate::mesh::polygons::Mesh;

/// A mesh and what its file says of it.
#[derive(Debug, Default)]
pub struct Model {
    /// The mesh.
    pub mesh: Mesh,
    /// What polygons belong to, in their order; those before the first piece, and all where there is none, to nothing that
    /// has a name.
    pub pieces: Vec<Piece>,
    /// The materials that pieces name.
    pub materials: Vec<Material>,
    /// Colour of each vertex: red, green, blue and opacity, as a screen takes them (sRGB), 1 the most.
    pub colours: Option<Vec<[f32; 4]>>, // (n)
    /// What tells the parts of a segmented mesh apart: a label or a colour of each polygon, where the file has any.
    pub marks: Option<Vec<Mark>>, // (p)
    /// What else the file holds that no other format takes from here, in words such as `2 skins`.
    pub rest: Vec<String>,
    /// Files that it names, seen from its folder: materials, buffers, images.
    pub named: Vec<String>,
    /// What was odd, in words for the user.
    pub warnings: Vec<String>,
}

/// A run of polygons that are one object of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// Its first polygon.
    pub first: usize,
    /// The object's name, empty where it has none.
    pub name: String,
    /// Number of the mesh that it belongs to, and of its part that is drawn at once: what `--group` tells apart.
    pub mesh: u32,
    /// See `mesh`.
    pub primitive: u32,
    /// Its material.
    pub material: Option<u32>,
}

/// A material, as far as formats have it in common.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    /// Its name, empty where it has none.
    pub name: String,
    /// Red, green, blue and opacity, linear light.
    pub colour: Option<[f64; 4]>,
    /// Where the texture of its colour lies, seen from the model's file, or what it is called inside of it.
    pub texture: Option<String>,
}

impl Model {
    /// A mesh alone.
    pub fn of(mesh: Mesh) -> Self {
        Self { mesh, ..Self::default() }
    }

    /// The pieces with the polygons of each.
    pub fn runs(&self) -> impl Iterator<Item = (&Piece, core::ops::Range<usize>)> {
        let ends = self.pieces.iter().skip(1).map(|next| next.first).chain([self.mesh.polygon_count()]);
        self.pieces.iter().zip(ends).map(|(piece, end)| (piece, piece.first..end))
    }

    /// Refuses what no stage can take: coordinates that are not finite, corners without a vertex.
    pub(super) fn checked(self) -> Result<Self, FormatError> {
        let mesh = &self.mesh;
        if let Some(v) = mesh.positions.iter().position(|p| !p.is_finite()) {
            let text = format!("vertex {v} (from 0) has a coordinate that is not finite; correct it");
            return Err(FormatError::whole(text));
        }
        let count = mesh.positions.len();
        if let Some(c) = mesh.corners.iter().position(|v| *v as usize >= count) {
            let polygon = mesh.polygon_start.partition_point(|start| *start as usize <= c) - 1;
            let vertex = mesh.corners[c];
            let text =
                format!("face {polygon} names vertex {vertex} (both from 0), but there are {count}; correct the face");
            return Err(FormatError::whole(text));
        }
        Ok(self)
    }
}
