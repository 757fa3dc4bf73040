//! The mesh as pictures need it: equal positions joined, charts and seams found, scaled to a largest coordinate of 1.
//!
//! Triangles with a missing vertex or a coordinate that is not finite are left out; a triangle with a UV that is not
//! finite has none. Charts join faces across edges whose two sides have bit-equal UVs at both ends; a seam is an edge of
//! two or more faces whose UVs differ at an end.

use glam::{DVec2, DVec3, Vec3};
use seamwright_core::base::{real, union_find::UnionFind};
use seamwright_core::judge::seams::turn;
use seamwright_core::mesh::normals::{NormalWeight, vertex_normals};
use seamwright_core::mesh::view::{MeshView, NONE};
use std::collections::HashMap;

/// Corners turn sharp where the face leans this far (its cosine) from the vertex normal: 40 degrees.
const CREASE: f64 = 0.766;

/// What a picture shows. Lengths need not agree: what is missing is left out of the picture.
#[derive(Clone, Copy)]
pub struct PictureMesh<'a> {
    /// Points.
    pub positions: &'a [DVec3], // (n)
    /// Vertices of each triangle.
    pub triangles: &'a [[u32; 3]], // (f)
    /// UV of each triangle's corners; not finite where there is none.
    pub corner_uv: Option<&'a [[DVec2; 3]]>, // (f)
    /// Chart of each triangle; found from the UVs where absent.
    pub chart: Option<&'a [u32]>, // (f)
    /// Exposure of each position in [0, 1]; computed where absent.
    pub exposure: Option<&'a [f32]>, // (n)
}

/// The prepared mesh. Faces are the input's without those left out.
pub struct PictureSurface {
    pub points: Vec<Vec3>,              // (n), joined and scaled
    pub normals: Vec<Vec3>,             // (n)
    pub exposure: Option<Vec<f32>>,     // (n)
    pub faces: Vec<[u32; 3]>,           // (f)
    pub corner_normals: Vec<[Vec3; 3]>, // (f)
    pub uv: Option<Vec<[DVec2; 3]>>,    // (f), NaN where there is none
    pub chart: Vec<u32>,                // (f), by falling area, NONE without UV
    pub chart_count: usize,
    pub edges: Vec<[u32; 2]>,     // (e), each edge once
    pub is_seam: Vec<bool>,       // (e)
    pub turn: Vec<Option<f64>>,   // (e), in degrees, where two faces meet
    pub outline: Vec<[DVec2; 2]>, // borders of charts, in UV
    pub area: f64,
}

impl PictureSurface {
    pub fn new(mesh: &PictureMesh) -> Self {
        let (points, joined) = join(mesh.positions);
        let finite = |v: &u32| mesh.positions.get(*v as usize).is_some_and(|p| p.is_finite());
        let kept: Vec<usize> = (0..mesh.triangles.len()).filter(|f| mesh.triangles[*f].iter().all(finite)).collect();
        let faces: Vec<_> = kept.iter().map(|f| mesh.triangles[*f].map(|v| joined[v as usize])).collect();
        let points = scale(points, &faces);
        let uv = mesh.corner_uv.map(|uv| {
            let get = |f: &usize| uv.get(*f).copied().filter(|c| c.iter().all(|t| t.is_finite()));
            kept.iter().map(|f| get(f).unwrap_or([DVec2::NAN; 3])).collect::<Vec<_>>()
        });
        let view = MeshView { positions: &points, faces: &faces };
        let area_vectors: Vec<DVec3> = (0..faces.len()).map(|f| view.area_vector(f)).collect();
        let areas: Vec<f64> = area_vectors.iter().map(|n| n.length() * 0.5).collect();
        let borders = Borders::new(&faces, uv.as_deref(), &area_vectors);
        let given = mesh.chart.map(|c| kept.iter().map(|f| c.get(*f).copied().unwrap_or(NONE)).collect::<Vec<_>>());
        let (chart, chart_count) = rank(given.unwrap_or(borders.chart), &areas);
        let mut normals = vec![DVec3::ZERO; points.len()];
        vertex_normals(&mut normals, view, NormalWeight::Angle);
        let exposure = mesh.exposure.filter(|e| e.len() == mesh.positions.len()).map(|e| {
            let mut out = vec![0.0; points.len()];
            joined.iter().zip(e).for_each(|(v, e)| out[*v as usize] = *e);
            out
        });
        Self {
            corner_normals: corner_normals(view, &normals),
            points: points.iter().map(|p| p.as_vec3()).collect(),
            normals: normals.iter().map(|n| n.as_vec3()).collect(),
            exposure,
            faces,
            uv,
            chart,
            chart_count,
            edges: borders.edges,
            is_seam: borders.is_seam,
            turn: borders.turn,
            outline: borders.outline,
            area: areas.iter().sum(),
        }
    }
}

/// Joins bit-equal positions (0 and -0 count as equal): the points, and each position's place among them.
fn join(positions: &[DVec3]) -> (Vec<DVec3>, Vec<u32>) {
    let mut known = HashMap::new();
    let mut points = Vec::new();
    let joined = positions.iter().map(|p| {
        *known.entry((*p + 0.0).to_array().map(f64::to_bits)).or_insert_with(|| {
            points.push(*p);
            points.len() as u32 - 1
        })
    });
    let joined = joined.collect();
    (points, joined)
}

/// Centres and scales so that the largest coordinate of a face is 1.
fn scale(mut points: Vec<DVec3>, faces: &[[u32; 3]]) -> Vec<DVec3> {
    let used = || faces.iter().flatten().map(|v| points[*v as usize]);
    let low = used().fold(DVec3::INFINITY, DVec3::min);
    let high = used().fold(DVec3::NEG_INFINITY, DVec3::max);
    let half = ((high - low) * 0.5).max_element();
    let scale = if half > 0.0 { 1.0 / half } else { 1.0 };
    let centre = if faces.is_empty() { DVec3::ZERO } else { low * 0.5 + high * 0.5 };
    points.iter_mut().for_each(|p| *p = (*p - centre) * scale);
    points
}

/// What the two sides of each edge say about each other.
struct Borders {
    edges: Vec<[u32; 2]>,
    is_seam: Vec<bool>,
    turn: Vec<Option<f64>>,
    outline: Vec<[DVec2; 2]>,
    chart: Vec<u32>,
}

impl Borders {
    fn new(faces: &[[u32; 3]], uv: Option<&[[DVec2; 3]]>, normals: &[DVec3]) -> Self {
        // (low vertex, high vertex, face, first corner), sorted: the sides of an edge stand together.
        let mut sides: Vec<[u32; 4]> = (0..faces.len() as u32)
            .flat_map(|f| (0..3).map(move |i| (f, i)))
            .map(|(f, i)| {
                let (a, b) = (faces[f as usize][i as usize], faces[f as usize][(i as usize + 1) % 3]);
                [a.min(b), a.max(b), f, i]
            })
            .collect();
        sides.sort_unstable();
        let mut parent = vec![0; faces.len()];
        let mut sets = UnionFind::new(&mut parent);
        let (mut edges, mut is_seam, mut turns, mut outline) = (vec![], vec![], vec![], vec![]);
        for group in sides.chunk_by(|a, b| a[..2] == b[..2]) {
            edges.push([group[0][0], group[0][1]]);
            turns.push(match group {
                [a, b] => Some(turn([a[2], b[2]].map(|f| normals[f as usize]))),
                _ => None,
            });
            let ends = |side: &[u32; 4]| {
                let (f, i) = (side[2] as usize, side[3] as usize);
                let [a, b] = uv.map_or([DVec2::ZERO; 2], |uv| [uv[f][i], uv[f][(i + 1) % 3]]);
                if faces[f][i] == side[0] { [a, b] } else { [b, a] }
            };
            let mut seam = false;
            for (k, side) in group.iter().enumerate() {
                let mut alone = true;
                for (j, other) in group.iter().enumerate().filter(|(j, _)| *j != k) {
                    if ends(side) == ends(other) {
                        alone = false;
                        if j < k {
                            sets.union(side[2], other[2]);
                        }
                    } else {
                        seam = true;
                    }
                }
                if uv.is_some() && alone {
                    outline.push(ends(side));
                }
            }
            is_seam.push(seam && uv.is_some());
        }
        let has_uv = |f: usize| uv.is_some_and(|uv| uv[f][0].is_finite());
        let chart = (0..faces.len()).map(|f| if has_uv(f) { sets.find(f as u32) } else { NONE }).collect();
        Self { edges, is_seam, turn: turns, outline, chart }
    }
}

/// Renames charts by falling area, so that colours do not depend on face order where areas differ.
fn rank(mut chart: Vec<u32>, areas: &[f64]) -> (Vec<u32>, usize) {
    let mut total = HashMap::new();
    for (c, area) in chart.iter().zip(areas).filter(|(c, _)| **c != NONE) {
        *total.entry(*c).or_insert(0.0) += area;
    }
    let mut order: Vec<(u32, f64)> = total.into_iter().collect();
    order.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let place: HashMap<u32, u32> = order.iter().enumerate().map(|(i, o)| (o.0, i as u32)).collect();
    chart.iter_mut().for_each(|c| *c = place.get(c).copied().unwrap_or(NONE));
    (chart, order.len())
}

/// The vertex normal at each corner, or the face's own where the two are far apart.
fn corner_normals(mesh: MeshView, normals: &[DVec3]) -> Vec<[Vec3; 3]> {
    let of_face = |(f, face): (usize, &[u32; 3])| {
        let area = mesh.area_vector(f);
        let own = area / real::sqrt(area.dot(area)).max(f64::MIN_POSITIVE);
        face.map(|v| normals[v as usize]).map(|n| if n.dot(own) < CREASE { own.as_vec3() } else { n.as_vec3() })
    };
    mesh.faces.iter().enumerate().map(of_face).collect()
}
