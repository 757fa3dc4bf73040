//! The working mesh while it is being made.

use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};

/// The working mesh while it is being made; vertices are welded input vertices until they are split.
pub(super) struct Draft<'a> {
    pub faces: &'a mut [[u32; 3]],    // (f)
    pub corner_source: &'a mut [u32], // (3 f)
    pub polygon: &'a mut [u32],       // (f)
    pub twin: &'a mut [u32],          // (3 f)
    pub fixed: &'a mut [u8],          // (3 f)
}

impl<'a> Draft<'a> {
    pub const fn need(faces: usize) -> usize {
        bytes_for::<[u32; 3]>(faces)
            .saturating_add(bytes_for::<u32>(faces))
            .saturating_add(bytes_for::<u32>(faces.saturating_mul(3)).saturating_mul(2))
            .saturating_add(bytes_for::<u8>(faces.saturating_mul(3)))
    }

    pub fn take(out: &mut Scratch<'a>, faces: usize) -> Result<Self, ScratchTooSmall> {
        Ok(Self {
            faces: out.take(faces)?,
            corner_source: out.take(3 * faces)?,
            polygon: out.take(faces)?,
            twin: out.take(3 * faces)?,
            fixed: out.take(3 * faces)?,
        })
    }

    /// The first `faces` of it.
    pub fn shorten(self, faces: usize) -> Self {
        Self {
            faces: &mut self.faces[..faces],
            corner_source: &mut self.corner_source[..3 * faces],
            polygon: &mut self.polygon[..faces],
            twin: &mut self.twin[..3 * faces],
            fixed: &mut self.fixed[..3 * faces],
        }
    }

    pub fn vertex(&self, h: u32) -> u32 {
        self.faces[(h / 3) as usize][(h % 3) as usize]
    }

    /// The faces of the polygon that `face` belongs to.
    pub fn polygon_faces(&self, face: usize) -> core::ops::Range<usize> {
        let same = |f: &usize| self.polygon[*f] == self.polygon[face];
        let first = (0..face).rev().take_while(same).last().unwrap_or(face);
        let last = (face..self.faces.len()).take_while(same).last().unwrap_or(face);
        first..last + 1
    }
}
