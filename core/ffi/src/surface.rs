//! The caller's mesh as core's slices.

use crate::code::{Fault, SEAMWRIGHT_BAD_POLYGONS, SEAMWRIGHT_TOO_LARGE};
use crate::slices::Buffers;
use crate::types::{SEAMWRIGHT_EDGE_BREAK, SEAMWRIGHT_EDGE_CUT, SeamwrightMesh};
use glam::{DVec2, DVec3};
use seamwright_core::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use seamwright_core::mesh::polygons::Counts;
use seamwright_core::price::given::{BREAK, CUT, EdgeData};

const _: () = assert!(SEAMWRIGHT_EDGE_CUT == CUT && SEAMWRIGHT_EDGE_BREAK == BREAK);

/// Vertices, corners and polygons that a mesh may have, each: what core numbers with 32 bits, and on 32-bit machines so
/// many that the bytes for them can be added up (a test does).
const MOST: usize = if usize::BITS > 32 { u32::MAX as usize / 3 - 1 } else { 3 * MOST_TRIANGLES_32 };
/// Triangles for which they can.
const MOST_TRIANGLES_32: usize = 500_000;

/// All of the mesh but where its polygons begin.
pub struct Surface<'a> {
    pub positions: &'a [DVec3],       // (n)
    pub corners: &'a [u32],           // (c)
    pub kept_uv: Option<&'a [DVec2]>, // (c)
    pub parts: Option<&'a [u32]>,     // (p)
    pub edges: EdgeData<'a>,
    pub tolerance: f64,
}

impl<'a> Surface<'a> {
    /// # Safety
    /// The header's contract for `mesh`.
    pub unsafe fn read(mesh: &SeamwrightMesh, buffers: &mut Buffers) -> Result<(Self, Starts<'a>), Fault> {
        let SeamwrightMesh { vertex_count, corner_count, polygon_count, .. } = *mesh;
        // SAFETY: the caller's promise; triples and pairs of floats are glam's scalar vectors (`repr(C)`).
        unsafe {
            let starts = Starts::read(mesh, buffers)?;
            let surface = Self {
                positions: buffers.read(mesh.positions.cast(), vertex_count)?,
                corners: buffers.read(mesh.corners, corner_count)?,
                kept_uv: buffers.read_given(mesh.kept_uv.cast(), corner_count)?,
                parts: buffers.read_given(mesh.parts, polygon_count)?,
                edges: EdgeData {
                    normals: buffers.read_given(mesh.corner_normals.cast(), corner_count)?,
                    weights: buffers.read_given(mesh.edge_weights, corner_count)?,
                    marks: buffers.read_given(mesh.edge_marks, corner_count)?,
                },
                // Of a number that is none, 0.
                tolerance: mesh.tolerance.max(0.0),
            };
            Ok((surface, starts))
        }
    }
}

/// Where polygons begin.
#[derive(Clone, Copy)]
pub enum Starts<'a> {
    /// As given: from 0 up to the number of corners.
    Given(&'a [u32]), // (p + 1)
    /// So many triangles.
    Triangles(usize),
}

impl<'a> Starts<'a> {
    /// Checks the counts and the list.
    ///
    /// # Safety
    /// The header's contract for `mesh`.
    pub unsafe fn read(mesh: &SeamwrightMesh, buffers: &mut Buffers) -> Result<Self, Fault> {
        let SeamwrightMesh { vertex_count, corner_count, polygon_start, polygon_count, .. } = *mesh;
        if [vertex_count, corner_count, polygon_count].iter().any(|count| *count > MOST) {
            return Err(Fault::new(SEAMWRIGHT_TOO_LARGE));
        }
        let starts = if polygon_start.is_null() {
            if corner_count != 3 * polygon_count {
                return Err(Fault::at(SEAMWRIGHT_BAD_POLYGONS, corner_count / 3));
            }
            Self::Triangles(polygon_count)
        } else {
            // SAFETY: the caller's promise.
            let list: &[u32] = unsafe { buffers.read(polygon_start, polygon_count + 1)? };
            let last = list[polygon_count] as usize;
            let fault = match list.windows(2).position(|ends| ends[0] > ends[1]) {
                _ if list[0] != 0 => Some(0),
                None if last != corner_count => Some(polygon_count),
                falls => falls,
            };
            fault.map_or(Ok(Self::Given(list)), |p| Err(Fault::at(SEAMWRIGHT_BAD_POLYGONS, p)))?
        };
        let is_small = usize::BITS > 32 || starts.counts(vertex_count).triangles <= MOST_TRIANGLES_32;
        if is_small { Ok(starts) } else { Err(Fault::new(SEAMWRIGHT_TOO_LARGE)) }
    }

    /// What needs of memory depend on.
    pub fn counts(self, vertices: usize) -> Counts {
        match self {
            Self::Triangles(count) => Counts::of_triangles(vertices, count),
            Self::Given(list) => {
                let sizes = || list.windows(2).map(|ends| (ends[1] - ends[0]) as usize);
                Counts {
                    vertices,
                    corners: list.last().map_or(0, |end| *end as usize),
                    polygons: list.len() - 1,
                    triangles: sizes().map(|n| n.saturating_sub(2)).sum(),
                    longest: sizes().max().unwrap_or(0),
                }
            }
        }
    }

    /// Scratch bytes for [`list`](Self::list).
    pub fn need(self) -> usize {
        match self {
            Self::Given(_) => 0,
            Self::Triangles(count) => bytes_for::<u32>(count + 1),
        }
    }

    /// The list itself.
    pub fn list(self, scratch: &mut Scratch<'a>) -> Result<&'a [u32], ScratchTooSmall> {
        match self {
            Self::Given(list) => Ok(list),
            Self::Triangles(count) => {
                let list = scratch.take::<u32>(count + 1)?;
                (0..).step_by(3).zip(&mut *list).for_each(|(c, start)| *start = c);
                Ok(list)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seamwright_core::judge::measure::measure_need;
    use seamwright_core::pipeline::{Packing, Settings, need_for};
    use seamwright_core::rays::binned::BinnedBuilder;

    #[test]
    fn needs_of_the_largest_mesh_can_be_added_up() {
        let largest =
            |corners, triangles| Counts { vertices: corners, corners, polygons: corners, triangles, longest: corners };
        // On a 32-bit machine, added up in 64 bits: the largest that the options allow.
        let small = largest(3 * MOST_TRIANGLES_32, MOST_TRIANGLES_32);
        for packing in [Packing::Tight, Packing::Grid] {
            let settings = Settings { size: 65536, padding: 1, rays: 65536, packing, ..Settings::default() };
            let need = need_for(&small, &settings, &BinnedBuilder);
            assert!(need < u32::MAX as usize, "{need} bytes, {} a triangle", need / MOST_TRIANGLES_32);
        }
        assert!(measure_need(small.vertices, small.triangles, 16384) < u32::MAX as usize);
        assert!(need_for(&largest(MOST, MOST - 2), &Settings::default(), &BinnedBuilder) < usize::MAX >> 8);
    }
}
