//! The map that is carried over, as it stands on the grid, and what is wrong with it.

use super::source::SourceAtlas;
use super::untangle::Shapes;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;
use crate::mesh::view::NONE;
use crate::plane::grid::{GRID_BITS, GridPoint, GridTriangle, doubled_area};
use crate::plane::overlap::overlaps;

/// What the map is of.
#[derive(Clone, Copy)]
pub struct CarriedMap<'s> {
    /// The faces.
    pub shapes: Shapes<'s>,
    /// Chart of the source that each face belongs to.
    pub chart: &'s dyn Fn(usize) -> u32,
    /// The source.
    pub source: &'s SourceAtlas<'s>,
    /// Whether the map stays in the unit square.
    pub in_square: bool,
    /// Whether each face belongs to a small piece of the mesh, which yields alone to a larger one: a flap of no thickness has no place of its own, and
    /// all that it lies on would give way.
    pub small: &'s dyn Fn(usize) -> bool,
}

/// What is wrong with a map on the grid.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    /// Faces that are turned over or without area on the grid.
    pub flipped: usize,
    /// Faces that overlap another on the grid.
    pub overlapping: usize,
    /// Those of them that belong to small pieces.
    pub small: usize,
    /// Corners outside of the unit square, where the source has none.
    pub outside: usize,
}

impl Faults {
    /// All of it.
    pub fn count(&self) -> usize {
        self.flipped.saturating_add(self.overlapping).saturating_add(self.outside)
    }
}

impl CarriedMap<'_> {
    /// A point of face `f` as it is written.
    pub fn written(&self, p: GridPoint, f: usize) -> GridPoint {
        match self.source.mirrored[(self.chart)(f) as usize] {
            0 => p,
            _ => GridPoint::new((1 << GRID_BITS) - p.x(), p.y()),
        }
    }

    /// Whether face `f` has no positive area on the grid, as seen.
    pub fn is_turned(&self, f: usize, grid: &[GridPoint]) -> bool {
        doubled_area(&self.shapes.node[f].map(|n| grid[n as usize])) <= 0
    }

    /// Whether a point, as it is written, may not lie where it does.
    pub fn is_outside(&self, p: GridPoint) -> bool {
        let room = 0..=1 << GRID_BITS;
        self.in_square && !(room.contains(&p.x()) && room.contains(&p.y()))
    }

    /// Writes the faces as they are written, and beside each the first that it overlaps, or `NONE`; counts what is wrong.
    pub fn look(
        &self,
        triangles: &mut [GridTriangle],
        partner: &mut [u32],
        grid: &[GridPoint],
        scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<Faults, ScratchTooSmall> {
        for (f, t) in triangles.iter_mut().enumerate() {
            *t = self.shapes.node[f].map(|n| self.written(grid[n as usize], f));
        }
        let overlapping = overlaps(partner, triangles, scratch, workers)?;
        Ok(Faults {
            flipped: (0..triangles.len()).filter(|f| self.is_turned(*f, grid)).count(),
            overlapping,
            small: partner.iter().enumerate().filter(|(f, p)| **p != NONE && (self.small)(*f)).count(),
            outside: triangles.as_flattened().iter().filter(|p| self.is_outside(**p)).count(),
        })
    }
}
