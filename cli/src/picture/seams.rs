//! Seam edges in a grid of cells, to ask whether a surface point is near one.
//!
//! Distance is measured in space, so a stripe is as if painted on the surface: what lies behind is never touched, and
//! triangles far smaller than a pixel carry a line as clean as large ones do.

use super::surface::PictureSurface;
use glam::{IVec3, Vec3};
use std::collections::HashMap;

/// Half the width of a line in pixels: thinner lines break up at two samples a pixel, wider ones hide small charts.
const HALF_WIDTH: f32 = 1.2;

/// The seams of a surface, for one width of pixels.
pub struct Lines {
    cells: HashMap<[i32; 3], Vec<[Vec3; 2]>>,
    cell: f32,
}

impl Lines {
    pub fn new(surface: &PictureSurface, pixel: f32) -> Self {
        let radius = HALF_WIDTH * pixel;
        let cell = 4.0 * radius;
        let mut cells = HashMap::<_, Vec<_>>::new();
        for (edge, _) in surface.edges.iter().zip(&surface.is_seam).filter(|(_, seam)| **seam) {
            let [a, b] = edge.map(|v| surface.points[v as usize]);
            // In steps, so that a long slanted edge does not fill its whole box.
            let steps = (a.distance(b) / cell).ceil().clamp(1.0, 4096.0) as usize;
            let at = |i: usize| a.lerp(b, i as f32 / steps as f32);
            for i in 0..steps {
                let (p, q) = (at(i), at(i + 1));
                let low = Self::place(p.min(q) - radius, cell);
                let high = Self::place(p.max(q) + radius, cell);
                for x in low.x..=high.x {
                    for y in low.y..=high.y {
                        (low.z..=high.z).for_each(|z| cells.entry([x, y, z]).or_default().push([p, q]));
                    }
                }
            }
        }
        Self { cells, cell }
    }

    fn place(p: Vec3, cell: f32) -> IVec3 {
        (p / cell).floor().as_ivec3()
    }

    /// Whether `point` is within a line's half width of a seam.
    pub fn near(&self, point: Vec3, pixel: f32) -> bool {
        let radius = HALF_WIDTH * pixel;
        let near = |[a, b]: &[Vec3; 2]| {
            let along = *b - *a;
            let t = ((point - *a).dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            (*a + along * t).distance_squared(point) <= radius * radius
        };
        self.cells.get(&Self::place(point, self.cell).to_array()).is_some_and(|lines| lines.iter().any(near))
    }
}
