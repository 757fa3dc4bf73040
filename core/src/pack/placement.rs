//! Where charts go, as callers and as the steps of packing see it, and how far they stay apart.

use glam::DVec2;

/// Where a chart goes: `scale * turn(p) + translation`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Placement {
    /// Cosine and sine of the rotation.
    pub turn: DVec2,
    /// Where the origin goes.
    pub translation: DVec2,
    /// Scale; the same for all charts in `Tight`.
    pub scale: f64,
}

impl Placement {
    /// Leaves a chart where it is.
    pub const IDENTITY: Placement = Placement { turn: DVec2::X, translation: DVec2::ZERO, scale: 1.0 };

    /// The place of a UV point of the chart.
    #[inline]
    pub fn apply(&self, p: DVec2) -> DVec2 {
        (self.turn.rotate(p) * self.scale + self.translation).clamp(DVec2::ZERO, DVec2::ONE)
    }
}

/// A chart's pose in the square [0, side]^2 of local units: angle, and where its centre is.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Pose {
    pub angle: f64,
    pub at: DVec2,
}

/// The distance that charts keep: texels of a texture.
#[derive(Clone, Copy)]
pub(super) struct Gap {
    pub texels: f64,
    pub size: f64,
}

impl Gap {
    /// The distance in a square of this side.
    pub fn within(&self, side: f64) -> f64 {
        self.texels / self.size * side
    }
}
