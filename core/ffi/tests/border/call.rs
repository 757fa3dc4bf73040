//! A mesh with everything that a call needs, and what the call has made of it.

use seamwright_ffi::*;
use std::ptr::null;

/// A mesh with everything that a call needs.
pub struct Call {
    pub positions: Vec<f64>,
    pub corners: Vec<u32>,
    pub polygon_start: Vec<u32>,
    pub uv: Vec<f64>,
    pub chart: Vec<u32>,
    pub exposure: Vec<f32>,
    pub mesh: SeamwrightMesh,
    pub options: SeamwrightOptions,
    pub host: SeamwrightHost,
    pub report: SeamwrightReport,
    pub scratch: Vec<u8>,
}

impl Call {
    /// A cube of quads.
    pub fn cube() -> Self {
        let positions = (0..8u32).flat_map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
        let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
        Self::new(positions, corners, Some((0..=6).map(|p| 4 * p).collect()))
    }

    /// Two cubes side by side: more than one chart, so that packing has work for other threads.
    pub fn cubes() -> Self {
        let one = Self::cube();
        let beside = one.positions.chunks_exact(3).flat_map(|p| [p[0] + 3.0, p[1], p[2]]);
        let positions = one.positions.iter().copied().chain(beside).collect();
        let corners = one.corners.iter().copied().chain(one.corners.iter().map(|v| v + 8)).collect();
        Self::new(positions, corners, Some((0..=12).map(|p| 4 * p).collect()))
    }

    /// A tetrahedron, told as triangles.
    pub fn tetrahedron() -> Self {
        let positions = vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        Self::new(positions, vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3], None)
    }

    pub fn new(positions: Vec<f64>, corners: Vec<u32>, starts: Option<Vec<u32>>) -> Self {
        let polygon_start = starts.unwrap_or_default();
        let polygon_count = if polygon_start.is_empty() { corners.len() / 3 } else { polygon_start.len() - 1 };
        let mesh = SeamwrightMesh {
            positions: positions.as_ptr(),
            vertex_count: positions.len() / 3,
            corners: corners.as_ptr(),
            corner_count: corners.len(),
            polygon_start: if polygon_start.is_empty() { null() } else { polygon_start.as_ptr() },
            polygon_count,
            ..SeamwrightMesh::INIT
        };
        let (mut options, mut bytes) = (SeamwrightOptions::INIT, 0);
        unsafe {
            assert_eq!(seamwright_defaults(&mut options, size_of::<SeamwrightOptions>()), SEAMWRIGHT_OK);
            assert_eq!(seamwright_unwrap_scratch(&mut bytes, &mesh, &options), SEAMWRIGHT_OK);
        }
        Self {
            uv: vec![f64::NAN; 2 * corners.len()],
            chart: vec![9; polygon_count],
            exposure: vec![f32::NAN; positions.len() / 3],
            positions,
            corners,
            polygon_start,
            mesh,
            options,
            host: SeamwrightHost::INIT,
            report: SeamwrightReport::INIT,
            scratch: vec![0xa5; bytes],
        }
    }

    pub fn atlas(&mut self) -> SeamwrightAtlas {
        SeamwrightAtlas {
            corner_uv: self.uv.as_mut_ptr(),
            polygon_chart: self.chart.as_mut_ptr(),
            exposure: self.exposure.as_mut_ptr(),
            ..SeamwrightAtlas::INIT
        }
    }

    pub fn run(&mut self) -> i32 {
        let atlas = self.atlas();
        self.run_into(&atlas)
    }

    pub fn run_into(&mut self, atlas: &SeamwrightAtlas) -> i32 {
        let (scratch, bytes) = (self.scratch.as_mut_ptr(), self.scratch.len());
        unsafe { seamwright_unwrap(atlas, &mut self.report, &self.mesh, &self.options, &self.host, scratch, bytes) }
    }
}

/// The atlas, as bits.
pub fn bits(call: &Call) -> (Vec<u64>, Vec<u32>, Vec<u32>) {
    let uv = call.uv.iter().map(|x| x.to_bits()).collect();
    (uv, call.chart.clone(), call.exposure.iter().map(|e| e.to_bits()).collect())
}
