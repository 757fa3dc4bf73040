//! The charts that cuts leave, as lists of faces.

use super::surface::Surface;
use crate::base::scratch::{Scratch, ScratchTooSmall};

/// The faces of each chart.
pub struct ChartList<'a> {
    /// Chart of each face.
    pub of_face: &'a [u32], // (f)
    /// First face of each chart in `faces`.
    pub start: &'a [u32], // (charts + 1)
    /// Faces, chart after chart.
    pub faces: &'a [u32], // (f)
}

impl<'a> ChartList<'a> {
    /// Lists the charts that `cut` leaves.
    pub fn new(surface: &Surface, cut: &[u8], keep: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        let count = surface.mesh.faces.len();
        let of_face = keep.take::<u32>(count)?;
        let faces = keep.take::<u32>(count)?;
        let charts = surface.charts(cut, of_face, faces);
        let start = keep.take::<u32>(charts + 2)?;
        for k in of_face.iter() {
            start[*k as usize + 2] += 1;
        }
        for k in 2..charts + 2 {
            start[k] += start[k - 1];
        }
        for (f, k) in of_face.iter().enumerate() {
            let at = &mut start[*k as usize + 1];
            faces[*at as usize] = f as u32;
            *at += 1;
        }
        Ok(Self { of_face, start: &start[..charts + 1], faces })
    }

    /// Number of charts.
    pub fn count(&self) -> usize {
        self.start.len() - 1
    }

    /// Faces of chart `k`.
    pub fn faces_of(&self, k: usize) -> &'a [u32] {
        &self.faces[self.start[k] as usize..self.start[k + 1] as usize]
    }
}
