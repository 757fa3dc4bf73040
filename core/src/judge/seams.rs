//! Seams: how long, how exposed, and across what turns of the surface.
//!
//! Lengths are in space, divided by the square root of the mesh's area where they say so. Exposure (1 open, 0 occluded)
//! comes from the caller, one value a vertex; along an edge it is the mean of its ends. Vertices at one place count once,
//! with the mean exposure of those that a face uses. The turn at an edge is the angle between the normals of its two faces,
//! whichever way they are wound; an edge with another number of faces has none, counts as noticed and is neither flat nor
//! sharp. A mean over no seam is NaN, a share of no seam 0.

use super::edges::Edge;
use super::input::UvMesh;
use super::wedges::UvTopology;
use crate::base::real::{atan2, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use glam::DVec3;

/// Degrees of turn below which an edge is flat: a seam there runs across one face of the object.
pub const FLAT: f64 = 1.0;
/// Degrees of turn above which an edge is sharp.
pub const SHARP: f64 = 35.0;

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
    /// Share of the length (at edges of two faces) where the turn is below [`FLAT`].
    pub flat_share: f64,
    /// Share of it where the turn is above [`SHARP`].
    pub sharp_share: f64,
    /// Share of the length of all sharp edges that is seam; NaN where nothing is sharp.
    pub sharp_cover: f64,
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
    /// Sum over seams of length x exposure x [`notice`] of the turn, / sqrt(area of the mesh).
    pub noticed_length_norm: f64,
}

/// The angle between two normals in degrees, 0 where one has no length. Exact to rounding at every angle, as an arc cosine
/// near 0 and 180 is not.
pub fn turn(normals: [DVec3; 2]) -> f64 {
    // Lengths below the floor are those of triangles whose area is no number to speak of.
    let [a, b] = normals.map(|n| n / sqrt(n.length_squared()).max(1e-300));
    atan2(sqrt(a.cross(b).length_squared()), a.dot(b)).to_degrees()
}

/// How much a seam is noticed where the surface turns by `turn` degrees: 1 up to 10, falling linearly to 0.1 at 40 and above.
/// A break in the shading hides a seam; one across a smooth or flat face is seen.
pub fn notice(turn: f64) -> f64 {
    1.0 - 0.9 * ((turn - 10.0) / 30.0).clamp(0.0, 1.0)
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
    let turned = turned(mesh, topology);
    let share = |part: f64| if turned.seam > 0.0 { part / turned.seam } else { 0.0 };
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
        flat_share: share(turned.flat_seam),
        sharp_share: share(turned.sharp_seam),
        sharp_cover: turned.sharp_seam / turned.sharp,
        exposure,
    })
}

fn edge_length(mesh: UvMesh, edge: &Edge) -> f64 {
    sqrt((mesh.positions[edge.low as usize] - mesh.positions[edge.high as usize]).length_squared())
}

/// The turn between the two faces of `edge`, whichever ways they face; 0 where it has one or more than two.
fn edge_turn(mesh: UvMesh, topology: &UvTopology, edge: &Edge) -> f64 {
    if edge.face_count != 2 {
        return 0.0;
    }
    let [m, n] = edge.faces.map(|f| mesh.normal(f as usize));
    let [a, b] = edge.faces.map(|f| topology.rises(mesh.triangles, f, edge));
    turn([m, if a == b { -n } else { n }])
}

/// Lengths of edges between two faces.
#[derive(Default)]
struct Turned {
    seam: f64,
    flat_seam: f64,
    sharp_seam: f64,
    sharp: f64,
}

fn turned(mesh: UvMesh, topology: &UvTopology) -> Turned {
    let mut sum = Turned::default();
    for edge in topology.edges.iter().filter(|e| e.face_count == 2) {
        let (length, turn) = (edge_length(mesh, edge), edge_turn(mesh, topology, edge));
        if turn > SHARP {
            sum.sharp += length;
        }
        if edge.is_seam() {
            sum.seam += length;
            sum.flat_seam += if turn < FLAT { length } else { 0.0 };
            sum.sharp_seam += if turn > SHARP { length } else { 0.0 };
        }
    }
    sum
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
    let visible = |e: &Edge| edge_length(mesh, e) * 0.5 * (at[e.low as usize] + at[e.high as usize]);
    // (length, length x exposure)
    let along = |of: &dyn Fn(&Edge) -> bool| {
        let edges = topology.edges.iter().filter(|e| of(e));
        edges.fold((0.0, 0.0), |(length, seen), e| (length + edge_length(mesh, e), seen + visible(e)))
    };
    let (all, seam) = (along(&|_| true), along(&Edge::is_seam));
    let seams = topology.edges.iter().filter(|e| e.is_seam());
    let noticed = seams.fold(0.0, |sum, e| sum + visible(e) * notice(edge_turn(mesh, topology, e)));
    let (all_length, seam_length) = (all.1 / all.0, seam.1 / seam.0);
    Ok(SeamExposure {
        all_mean: mean(&|_| true),
        all_length,
        seam_mean: mean(&|v| on_seam[v] != 0),
        seam_length,
        ratio: seam_length / all_length,
        visible_length_norm: seam.1 / sqrt(area),
        noticed_length_norm: noticed / sqrt(area),
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
    use crate::base::real::{cos, sin};
    use approx::assert_abs_diff_eq;
    use glam::{DVec2, DVec3};
    use std::vec;

    fn judge_mesh(mesh: UvMesh, area: f64, exposure: Option<&[f32]>) -> Seams {
        let vertices = mesh.positions.len();
        let mut bytes = vec![0; uv_topology_need(vertices, mesh.triangles.len()) + seams_need(vertices)];
        let mut scratch = Scratch::new(&mut bytes);
        let topology = uv_topology(mesh, &mut scratch).unwrap();
        let mut short = vec![0; seams_need(vertices) - 1];
        let refused = seams(mesh, &topology, area, exposure, Scratch::new(&mut short));
        assert_eq!(refused, Err(ScratchTooSmall { need: short.len() + 1, given: short.len() }));
        seams(mesh, &topology, area, exposure, scratch).unwrap()
    }

    /// A row of two unit squares, cut between them by `shift`; vertex 6 is at the place of vertex 1, and no face uses 7. The
    /// second square leans up by `lean` degrees.
    fn judge_leaning(shift: f64, lean: f64, exposure: Option<[f32; 8]>) -> Seams {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let mut positions = [p(0., 0.), p(1., 0.), p(2., 0.), p(0., 1.), p(1., 1.), p(2., 1.), p(1., 0.), p(1., 0.)];
        let triangles = [[0, 1, 4], [0, 4, 3], [6, 2, 5], [6, 5, 4]];
        let mut corner_uv = triangles.map(|t: [u32; 3]| t.map(|v| positions[v as usize].truncate()));
        corner_uv[2..].iter_mut().flatten().for_each(|uv| *uv += DVec2::X * shift);
        let (x, z) = (1.0 + cos(lean.to_radians()), sin(lean.to_radians()));
        [2, 5].iter().for_each(|v| positions[*v] = DVec3::new(x, positions[*v].y, z));
        let mesh = UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv };
        judge_mesh(mesh, 2.0, exposure.as_ref().map(|e| &e[..]))
    }

    fn judge(shift: f64, exposure: Option<[f32; 8]>) -> Seams {
        judge_leaning(shift, 0.0, exposure)
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
        assert_abs_diff_eq!(e.all_length, all, epsilon = 1e-12);
        assert_abs_diff_eq!(e.ratio, 0.5 / all, epsilon = 1e-12);
    }

    #[test]
    fn figures_over_no_seam_are_nan() {
        let s = judge(0.0, Some([1.0; 8]));
        let e = s.exposure.unwrap();
        assert_eq!((s.edges, s.vertices, s.length), (0, 0, 0.0));
        assert!(e.seam_mean.is_nan() && e.seam_length.is_nan() && e.ratio.is_nan());
        assert_eq!((e.all_mean, e.visible_length_norm, e.noticed_length_norm), (1.0, 0.0, 0.0));
        assert_eq!((s.flat_share, s.sharp_share), (0.0, 0.0));
        assert!(s.sharp_cover.is_nan());
    }

    #[test]
    fn a_cut_across_a_flat_sheet_is_flat_and_noticed_as_far_as_it_is_seen() {
        let s = judge(1.0, Some([0.5; 8]));
        assert_eq!((s.flat_share, s.sharp_share), (1.0, 0.0));
        assert!(s.sharp_cover.is_nan());
        let e = s.exposure.unwrap();
        assert_eq!(e.noticed_length_norm, e.visible_length_norm);
    }

    #[test]
    fn notice_and_shares_follow_the_turn() {
        // (degrees, flat, sharp, notice); the sine and cosine of the fold leave the turn exact to a few of its last digits.
        let cases = [
            (0.99, 1., 0., 1.0),
            (1.01, 0., 0., 1.0),
            (10.0, 0., 0., 1.0),
            (25.0, 0., 0., 0.55),
            (34.9, 0., 0., 0.253),
            (35.1, 0., 1., 0.247),
            (40.0, 0., 1., 0.1),
            (179.0, 0., 1., 0.1),
            (-60.0, 0., 1., 0.1),
        ];
        for (degrees, flat, sharp, share) in cases {
            let s = judge_leaning(1.0, degrees, Some([1.0; 8]));
            assert_eq!((s.flat_share, s.sharp_share), (flat, sharp), "{degrees}");
            assert!(if sharp > 0.0 { s.sharp_cover == 1.0 } else { s.sharp_cover.is_nan() }, "{degrees}");
            let e = s.exposure.unwrap();
            assert!((e.noticed_length_norm / e.visible_length_norm - share).abs() < 1e-12, "{degrees}");
        }
        // An edge that is sharp and not cut is one to cover.
        assert_eq!(judge_leaning(0.0, 90.0, None).sharp_cover, 0.0);
    }

    #[test]
    fn all_seams_of_a_cubes_net_are_sharp() {
        let positions: [DVec3; 8] = core::array::from_fn(|v| {
            DVec3::new((v & 1) as f64, (v >> 1 & 1) as f64, (v >> 2) as f64) // x, y, z from the low bit up
        });
        let net = [
            ([4, 5, 7, 6], (1., 1.)), // the front; right, back and left of it in a row
            ([5, 1, 3, 7], (2., 1.)),
            ([1, 0, 2, 3], (3., 1.)),
            ([0, 4, 6, 2], (0., 1.)),
            ([6, 7, 3, 2], (1., 2.)), // above and below it
            ([0, 1, 5, 4], (1., 0.)),
        ];
        let square = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let fans = || net.iter().flat_map(|side| [[0, 1, 2], [0, 2, 3]].map(|t: [usize; 3]| (side, t)));
        let triangles: vec::Vec<[u32; 3]> = fans().map(|((side, _), t)| t.map(|i| side[i])).collect();
        let corner_uv: vec::Vec<[DVec2; 3]> =
            fans().map(|((_, (u, v)), t)| t.map(|i| square[i] + DVec2::new(*u, *v))).collect();
        let mesh = UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv };
        let s = judge_mesh(mesh, 6.0, Some(&[0.5; 8]));
        assert_eq!((s.edges, s.length, s.flat_share, s.sharp_share, s.sharp_cover), (7, 7.0, 0.0, 1.0, 7.0 / 12.0));
        let e = s.exposure.unwrap();
        assert_eq!(e.visible_length_norm, 3.5 / sqrt(6.0));
        assert_abs_diff_eq!(e.noticed_length_norm, 0.35 / sqrt(6.0), epsilon = 1e-12);
    }

    #[test]
    fn edges_of_three_faces_and_faces_without_area_have_no_turn() {
        // Three faces upright on the edge from 0 to 1, each with UVs of its own: one seam of length 1.
        let [o, x] = [DVec3::ZERO, DVec3::X];
        let positions = [o, x, DVec3::Y, DVec3::Z, -DVec3::Y, x * 0.5];
        let apart = |k: usize| [DVec2::ZERO, DVec2::X, DVec2::Y].map(|uv| uv + DVec2::splat(3.0 * k as f64));
        let corner_uv = [apart(0), apart(1), apart(2)];
        let fin =
            UvMesh { positions: &positions, triangles: &[[0, 1, 2], [0, 1, 3], [0, 1, 4]], corner_uv: &corner_uv };
        let s = judge_mesh(fin, 1.0, Some(&[1.0; 6]));
        assert_eq!((s.edges, s.nonmanifold_edges, s.flat_share, s.sharp_share), (1, 1, 0.0, 0.0));
        assert!(s.sharp_cover.is_nan());
        assert_eq!(s.exposure.unwrap().noticed_length_norm, 1.0);
        // A triangle on one line beside one that stands: the turn is 0.
        let line = UvMesh { positions: &positions, triangles: &[[0, 1, 3], [0, 1, 5]], corner_uv: &corner_uv[..2] };
        let s = judge_mesh(line, 1.0, Some(&[1.0; 6]));
        assert_eq!((s.edges, s.flat_share, s.exposure.unwrap().noticed_length_norm), (1, 1.0, 1.0));
    }

    #[test]
    fn turns_have_no_scale_and_hostile_normals_no_panic() {
        for scale in [1e-290, 1e-100, 1.0, 1e150] {
            let turn = turn([DVec3::X * scale, DVec3::new(-1.0, 1e-9, 0.0) * scale]);
            assert!((turn - (180.0 - 1e-9f64.to_degrees())).abs() < 1e-12, "{scale}: {turn}");
        }
        assert_eq!(turn([DVec3::ZERO, DVec3::X]), 0.0);
        assert!(turn([DVec3::INFINITY, DVec3::X]).is_nan() && notice(f64::NAN).is_nan());
    }
}
