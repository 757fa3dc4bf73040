//! Meshes from other files than OBJ; their atlas is written to an OBJ made from scratch.

use crate::mesh::polygons::Mesh;
use core::fmt;

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

/// What a file says of the part that a polygon belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Mark {
    /// An integer.
    Label(i64),
    /// Red, green and blue, 65535 the brightest.
    Colour([u16; 3]),
}

impl Mark {
    /// Of a colour whose parts are in [0, 1]; what is beyond is cut.
    pub(super) fn colour(rgb: [f64; 3]) -> Self {
        Mark::Colour(rgb.map(|c| (c.clamp(0.0, 1.0) * 65535.0).round() as u16))
    }

    /// The mark that most corners have; the first of those that are as many.
    pub(super) fn of_most(corners: impl Iterator<Item = Mark> + Clone) -> Option<Self> {
        let count = |mark: &Mark| corners.clone().filter(|m| m == mark).count();
        // max_by_key gives the last of equals, so the order is turned.
        let all: Vec<Mark> = corners.clone().collect();
        all.into_iter().rev().max_by_key(count)
    }
}

/// Why a file is no mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FormatError {
    /// Line from 1; 0 where the whole file is meant.
    pub line: usize,
    /// What is wrong, and what to do.
    pub problem: String,
}

impl FormatError {
    /// About no line in particular.
    pub fn whole(problem: impl Into<String>) -> Self {
        Self { line: 0, problem: problem.into() }
    }
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => f.write_str(&self.problem),
            line => write!(f, "line {line}: {}", self.problem),
        }
    }
}

impl std::error::Error for FormatError {}

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
