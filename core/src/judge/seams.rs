//! Seams: how long, and how exposed.
//!
//! Lengths are in space, divided by the square root of the mesh's area where they say so. Exposure (1 open, 0 occluded)
//! comes from the caller, one value a vertex; along an edge it is the mean of its ends. Vertices at one place count once,
//! with the mean exposure of those that a face uses. A figure over no seam is NaN.

use super::input::UvMesh;
use super::wedges::{Edge, UvTopology};
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};

/// Seams of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seams {
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Edges with more than two faces.
    pub nonmanifold_edges: usize,
    /// Edges along which the map is cut.
    pub edges: usize,
    /// Different vertices on them.
    pub vertices: usize,
    /// Their length.
    pub length: f64,
    /// Length / sqrt(area of the mesh).
    pub length_norm: f64,
    /// What exposure says about them, where it was given.
    pub exposure: Option<SeamExposure>,
}

/// Exposure of seams against that of the whole mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeamExposure {
    /// Mean over all vertices that a face uses.
    pub all_mean: f64,
    /// Mean along all edges by length.
    pub all_length: f64,
    /// Mean over the vertices on seams.
    pub seam_mean: f64,
    /// Mean along seams by length.
    pub seam_length: f64,
    /// `seam_length` / `all_length`; below 1 the seams hide.
    pub ratio: f64,
    /// Sum over seams of length x exposure, / sqrt(area of the mesh).
    pub visible_length_norm: f64,
}

/// Bytes that [`seams`] needs.
pub const fn seams_need(vertices: usize) -> usize {
    bytes_for::<u8>(vertices) + bytes_for::<f64>(vertices) + bytes_for::<u32>(vertices)
}

/// Measures seams; `area` is that of the whole mesh, `exposure` has one value a vertex of `mesh`.
pub fn seams(
    mesh: UvMesh,
    topology: &UvTopology,
    area: f64,
    exposure: Option<&[f32]>,
    mut scratch: Scratch,
) -> Result<Seams, ScratchTooSmall> {
    scratch.require(seams_need(mesh.positions.len()))?;
    let on_seam = scratch.take::<u8>(mesh.positions.len())?;
    let cut = || topology.edges.iter().filter(|e| e.is_seam());
    cut().for_each(|e| [e.low, e.high].iter().for_each(|v| on_seam[*v as usize] = 1));
    let length = cut().fold(0.0, |sum, e| sum + edge_length(mesh, e));
    let exposure = match exposure {
        Some(values) => Some(seam_exposure(mesh, topology, area, values, on_seam, scratch)?),
        None => None,
    };
    Ok(Seams {
        boundary_edges: topology.edges.iter().filter(|e| e.face_count == 1).count(),
        nonmanifold_edges: topology.edges.iter().filter(|e| e.face_count > 2).count(),
        edges: cut().count(),
        vertices: on_seam.iter().filter(|s| **s != 0).count(),
        length,
        length_norm: length / sqrt(area),
        exposure,
    })
}

fn edge_length(mesh: UvMesh, edge: &Edge) -> f64 {
    sqrt((mesh.positions[edge.low as usize] - mesh.positions[edge.high as usize]).length_squared())
}

fn seam_exposure(
    mesh: UvMesh,
    topology: &UvTopology,
    area: f64,
    exposure: &[f32],
    on_seam: &[u8],
    mut scratch: Scratch,
) -> Result<SeamExposure, ScratchTooSmall> {
    let at = weld_exposure(mesh, topology.welded, exposure, &mut scratch)?;
    let mean = |of: &dyn Fn(usize) -> bool| {
        let chosen = || (0..at.len()).filter(|v| at[*v].is_finite() && of(*v));
        chosen().fold(0.0, |sum, v| sum + at[v]) / chosen().count() as f64
    };
    // (length, length x exposure)
    let along = |of: &dyn Fn(&Edge) -> bool| {
        topology.edges.iter().filter(|e| of(e)).fold((0.0, 0.0), |(length, visible), e| {
            let l = edge_length(mesh, e);
            (length + l, visible + l * 0.5 * (at[e.low as usize] + at[e.high as usize]))
        })
    };
    let (all, seam) = (along(&|_| true), along(&Edge::is_seam));
    let (all_length, seam_length) = (all.1 / all.0, seam.1 / seam.0);
    Ok(SeamExposure {
        all_mean: mean(&|_| true),
        all_length,
        seam_mean: mean(&|v| on_seam[v] != 0),
        seam_length,
        ratio: seam_length / all_length,
        visible_length_norm: seam.1 / sqrt(area),
    })
}

/// Exposure of each place, at its lowest vertex; NaN at the others and where no face comes by.
fn weld_exposure<'a>(
    mesh: UvMesh,
    welded: &[u32],
    exposure: &[f32],
    scratch: &mut Scratch<'a>,
) -> Result<&'a [f64], ScratchTooSmall> {
    const USED: u32 = 1 << 31;
    let sum = scratch.take::<f64>(welded.len())?;
    let count = scratch.take::<u32>(welded.len())?; // of vertices at a place; USED: this vertex is in a face
    mesh.triangles.iter().flatten().for_each(|v| count[*v as usize] |= USED);
    for v in 0..welded.len() {
        if count[v] & USED != 0 {
            sum[welded[v] as usize] += exposure[v] as f64;
            count[welded[v] as usize] += 1;
        }
    }
    sum.iter_mut()
        .zip(count)
        .for_each(|(sum, n)| *sum = if *n & !USED > 0 { *sum / (*n & !USED) as f64 } else { f64::NAN });
    Ok(sum)
}

#[cfg(test)]
mod tests {
    use super::super::wedges::{uv_topology, uv_topology_need};
    use super::*;
    use glam::{DVec2, DVec3};
    use std::vec;

    /// A row of two unit squares, cut between them by `shift`; vertex 6 is at the place of vertex 1, and no face uses 7.
    fn judge(shift: f64, exposure: Option<[f32; 8]>) -> Seams {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let positions = [p(0., 0.), p(1., 0.), p(2., 0.), p(0., 1.), p(1., 1.), p(2., 1.), p(1., 0.), p(1., 0.)];
        let triangles = [[0, 1, 4], [0, 4, 3], [6, 2, 5], [6, 5, 4]];
        let mut corner_uv = triangles.map(|t: [u32; 3]| t.map(|v| positions[v as usize].truncate()));
        corner_uv[2..].iter_mut().flatten().for_each(|uv| *uv += DVec2::X * shift);
        let mesh = UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv };
        let mut bytes = vec![0; uv_topology_need(8, 4) + seams_need(8)];
        let mut scratch = Scratch::new(&mut bytes);
        let topology = uv_topology(mesh, &mut scratch).unwrap();
        seams(mesh, &topology, 2.0, exposure.as_ref().map(|e| &e[..]), scratch).unwrap()
    }

    #[test]
    fn a_cut_between_two_squares_is_a_seam_of_their_side() {
        let s = judge(1.0, None);
        assert_eq!((s.edges, s.vertices, s.boundary_edges, s.nonmanifold_edges), (1, 2, 6, 0));
        assert_eq!((s.length, s.length_norm), (1.0, 1.0 / sqrt(2.0)));
        assert!(s.exposure.is_none());
    }

    #[test]
    fn exposure_is_averaged_at_places_that_faces_use() {
        let s = judge(1.0, Some([1.0, 0.25, 1.0, 1.0, 0.5, 1.0, 0.75, 0.0]));
        let e = s.exposure.unwrap();
        // Vertices 1 and 6 are one with 0.5; vertex 7 does not count. Six places: four at 1, two at 0.5.
        assert_eq!((e.seam_mean, e.seam_length, e.all_mean), (0.5, 0.5, 5.0 / 6.0));
        assert_eq!(e.visible_length_norm, 0.5 / sqrt(2.0));
        // Edges: the seam 1 at .5; left and right side 2 at 1; four half rows at .75; two diagonals at .75.
        let all = (0.5 + 2.0 + 4.0 * 0.75 + 2.0 * sqrt(2.0) * 0.75) / (7.0 + 2.0 * sqrt(2.0));
        assert!((e.all_length - all).abs() < 1e-12 && (e.ratio - 0.5 / all).abs() < 1e-12);
    }

    #[test]
    fn figures_over_no_seam_are_nan() {
        let s = judge(0.0, Some([1.0; 8]));
        let e = s.exposure.unwrap();
        assert_eq!((s.edges, s.vertices, s.length), (0, 0, 0.0));
        assert!(e.seam_mean.is_nan() && e.seam_length.is_nan() && e.ratio.is_nan());
        assert_eq!((e.all_mean, e.visible_length_norm), (1.0, 0.0));
    }
}
