//! How far a UV map is from an isometry, a conformal map, an equal-area map.
//!
//! Per face: J is the 2 x 2 Jacobian from an orthonormal frame of the triangle to UV, s1 >= s2 >= 0 its singular values.
//! Angle and area errors, symmetric Dirichlet (Smith, Schaefer 2015) after the best global scale, L2 and Linf stretch
//! (Sander et al. 2001), quasi-conformal ratio s2 / s1. `_aw` is a mean weighted by area in space, plain a mean over
//! faces. Faces with next to no area in space are left out and counted; faces without UV area stay in the errors (the
//! logarithm is floored), make the energies infinite and only leave the `_finite` ones. Means over nothing are NaN.

use super::input::{Areas, UvMesh};
use crate::base::real::{atan2, exp, ln, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use glam::{DVec2, DVec3};

/// A face is degenerate when its area is at most this share of the mean face's.
pub const DEGENERATE: f64 = 1e-9;
/// A face has no UV area when it is at most this share of the squared UV extent.
pub const ZERO_UV: f64 = 1e-14;
/// A face is collapsed when s2 is at most this share of the root mean square singular value.
pub const COLLAPSED: f64 = 1e-6;
/// Floor of an area ratio under the logarithm.
pub const AREA_FLOOR: f64 = 1e-12;

/// A figure and the face that has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// The largest value; NaN where there is no face.
    pub value: f64,
    /// The lowest face that has it; `NONE` where there is no face.
    pub face: u32,
}

/// Distortion of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)] // `_aw` twins are weighted by area in space
pub struct Distortion {
    /// Faces with UV whose area in space is at most [`DEGENERATE`] of the mean.
    pub degenerate_faces: usize,
    /// Other faces whose UV area is at most [`ZERO_UV`] of the extent squared.
    pub zero_uv_faces: usize,
    /// Faces (not degenerate) that the `_finite` figures leave out, see [`COLLAPSED`].
    pub collapsed_faces: usize,
    /// Mean over faces of the mean over corners of |angle in space - angle in UV|, radians.
    pub angle: f64,
    pub angle_aw: f64,
    /// 95th percentile over faces.
    pub angle_p95: f64,
    /// |ln of (share of the UV area / share of the area)|.
    pub area_ln: f64,
    pub area_ln_aw: f64,
    /// 95th percentile over faces.
    pub area_ln_p95: f64,
    /// min(r, 1 / r) of the same ratio; 1 is equal area.
    pub area_ratio: f64,
    pub area_ratio_aw: f64,
    /// s2 / s1; 1 is conformal, 0 collapsed.
    pub qc_ratio: f64,
    pub qc_ratio_aw: f64,
    /// Area-weighted mean of s1^2 + s2^2 + 1/s1^2 + 1/s2^2 after the best global scale; 4 is an isometry.
    pub symmetric_dirichlet: f64,
    pub symmetric_dirichlet_finite: f64,
    /// Root mean square stretch, 1 is an isometry.
    pub stretch_l2: f64,
    pub stretch_l2_finite: f64,
    /// Largest stretch.
    pub stretch_linf: f64,
    pub stretch_linf_finite: f64,
    /// Largest angle error.
    pub worst_angle: Worst,
    /// Largest area error.
    pub worst_area_ln: Worst,
    /// Largest symmetric Dirichlet energy of one face under the scale that is best for all that are not collapsed.
    pub worst_dirichlet: Worst,
}

impl Distortion {
    /// 1 - mean angle error.
    pub fn conformality(&self) -> f64 {
        1.0 - self.angle
    }

    /// 1 - mean area error.
    pub fn equiareality(&self) -> f64 {
        1.0 - self.area_ln
    }
}

/// Faces that count in per-face figures.
#[derive(Clone, Copy)]
pub struct Sound {
    /// Area in space above which a face is not degenerate.
    pub solid_floor: f64,
    /// UV area above which a face has UV area.
    pub uv_floor: f64,
}

impl Sound {
    /// The floors of `mesh`, whose UV box has side `extent`.
    pub fn of(mesh: UvMesh, areas: Areas, extent: f64) -> Self {
        let (mut sum, mut count) = (0.0, 0usize);
        mesh.mapped_faces().for_each(|f| {
            sum += areas.solid[f];
            count += 1;
        });
        Self { solid_floor: DEGENERATE * (sum / count.max(1) as f64), uv_floor: ZERO_UV * extent * extent }
    }
}

/// Bytes that [`distortion`] needs.
pub const fn distortion_need(faces: usize) -> usize {
    2 * bytes_for::<f64>(faces) + bytes_for::<FaceTerms>(faces)
}

/// Measures all faces of `mesh` that have UV.
pub fn distortion(
    mesh: UvMesh,
    areas: Areas,
    sound: Sound,
    mut scratch: Scratch,
) -> Result<Distortion, ScratchTooSmall> {
    scratch.require(distortion_need(mesh.triangles.len()))?;
    let terms = scratch.take::<FaceTerms>(mesh.triangles.len())?;
    let (terms, degenerate_faces) = collect_terms(terms, mesh, areas, sound);
    let angle = scratch.take::<f64>(terms.len())?;
    let area_ln = scratch.take::<f64>(terms.len())?;
    let total = Totals::of(terms);
    for (t, (angle, ln_ratio)) in terms.iter().zip(angle.iter_mut().zip(area_ln.iter_mut())) {
        *angle = t.angle;
        let ratio = (t.uv / total.uv) / t.weight(total);
        // A total of 0 makes the ratio NaN: all is collapsed, and `max` takes the floor.
        *ln_ratio = ln(ratio.max(AREA_FLOOR)).abs();
    }

    let means = |of: &dyn Fn(usize) -> f64| weighted_means(terms, total, of);
    let (angle_mean, angle_aw) = means(&|i| angle[i]);
    let (area_ln_mean, area_ln_aw) = means(&|i| area_ln[i]);
    let (area_ratio, area_ratio_aw) = means(&|i| exp(-area_ln[i]));
    let (qc_ratio, qc_ratio_aw) = means(&|i| terms[i].qc_ratio());
    let rms = rms_singular_value(terms, total);
    let finite = |t: &FaceTerms| t.s2 > COLLAPSED * rms;
    let all = Energies::of(terms, total, &|_| true);
    let some = Energies::of(terms, total, &finite);
    Ok(Distortion {
        degenerate_faces,
        zero_uv_faces: terms.iter().filter(|t| t.uv <= sound.uv_floor).count(),
        collapsed_faces: terms.iter().filter(|t| !finite(t)).count(),
        angle: angle_mean,
        angle_aw,
        area_ln: area_ln_mean,
        area_ln_aw,
        area_ratio,
        area_ratio_aw,
        qc_ratio,
        qc_ratio_aw,
        symmetric_dirichlet: all.dirichlet,
        symmetric_dirichlet_finite: some.dirichlet,
        stretch_l2: all.l2,
        stretch_l2_finite: some.l2,
        stretch_linf: all.linf,
        stretch_linf_finite: some.linf,
        worst_angle: worst(terms, &|i| angle[i]),
        worst_area_ln: worst(terms, &|i| area_ln[i]),
        worst_dirichlet: worst(terms, &|i| terms[i].dirichlet(some.scale)),
        // Last: percentiles reorder.
        angle_p95: percentile(angle, 0.95),
        area_ln_p95: percentile(area_ln, 0.95),
    })
}

/// What the second pass needs of a face.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct FaceTerms {
    solid: f64,
    uv: f64,
    angle: f64,
    s1: f64,
    s2: f64,
    face: u64,
}

impl FaceTerms {
    fn weight(&self, total: Totals) -> f64 {
        self.solid / total.solid
    }

    fn qc_ratio(&self) -> f64 {
        if self.s1 > 0.0 { self.s2 / self.s1 } else { 0.0 }
    }

    /// (s1^2 + s2^2, 1/s1^2 + 1/s2^2).
    fn forward_and_back(&self) -> (f64, f64) {
        let (a, b) = (self.s1 * self.s1, self.s2 * self.s2);
        (a + b, 1.0 / a + 1.0 / b)
    }

    /// Energy with UVs scaled by the square root of `scale`.
    fn dirichlet(&self, scale: f64) -> f64 {
        let (forward, back) = self.forward_and_back();
        forward * scale + back / scale
    }
}

#[derive(Clone, Copy)]
struct Totals {
    solid: f64,
    uv: f64,
}

impl Totals {
    fn of(terms: &[FaceTerms]) -> Self {
        let zero = Self { solid: 0.0, uv: 0.0 };
        terms.iter().fold(zero, |sum, t| Self { solid: sum.solid + t.solid, uv: sum.uv + t.uv })
    }
}

/// Fills the terms of faces that have UV and are not degenerate; returns them and the number of degenerate ones.
fn collect_terms<'a>(terms: &'a mut [FaceTerms], mesh: UvMesh, areas: Areas, sound: Sound) -> (&'a [FaceTerms], usize) {
    let (mut count, mut degenerate) = (0, 0);
    for f in mesh.mapped_faces() {
        if areas.solid[f] > sound.solid_floor {
            let (points, uv) = (mesh.points(f), mesh.corner_uv[f]);
            let (s1, s2) = singular_values(points, uv);
            let angle = angle_error(points, uv);
            terms[count] = FaceTerms { solid: areas.solid[f], uv: areas.uv[f].abs(), angle, s1, s2, face: f as u64 };
            count += 1;
        } else {
            degenerate += 1;
        }
    }
    (&terms[..count], degenerate)
}

/// Mean over the corners of |angle in space - angle in UV|. An empty side makes an angle of 0:
/// adding 0 keeps a product of -0 from turning it into pi.
fn angle_error(p: [DVec3; 3], q: [DVec2; 3]) -> f64 {
    let corner = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (a, b) = (p[j] - p[i], p[k] - p[i]);
        let (u, v) = (q[j] - q[i], q[k] - q[i]);
        let solid = atan2(sqrt(a.cross(b).length_squared()), a.dot(b) + 0.0);
        (solid - atan2(u.perp_dot(v).abs(), u.dot(v) + 0.0)).abs()
    };
    (corner(0) + corner(1) + corner(2)) / 3.0
}

/// The singular values s1 >= s2 of the map from the plane of `p` to UV; s2 from the determinant, which is stable.
pub fn singular_values(p: [DVec3; 3], q: [DVec2; 3]) -> (f64, f64) {
    let at_least = |x: f64| x.max(1e-300);
    let (e1, e2) = (p[1] - p[0], p[2] - p[0]);
    let normal = e1.cross(e2);
    let length = sqrt(e1.length_squared());
    let x = e1 / at_least(length);
    let y = (normal / at_least(sqrt(normal.length_squared()))).cross(x);
    // In the frame (x, y) the corners are (0, 0), (length, 0), (b, d).
    let (b, d) = (e2.dot(x), e2.dot(y));
    let (u1, u2) = (q[1] - q[0], q[2] - q[0]);
    let c0 = u1 / at_least(length);
    let c1 = (u2 - c0 * b) / at_least(d);
    let (e, f, g) = (c0.length_squared(), c0.dot(c1), c1.length_squared());
    let root = sqrt((e - g) * (e - g) + 4.0 * f * f);
    let s1 = sqrt((0.5 * (e + g + root)).max(0.0));
    (s1, c0.perp_dot(c1).abs() / at_least(s1))
}

/// (mean over faces, mean by area).
fn weighted_means(terms: &[FaceTerms], total: Totals, of: &dyn Fn(usize) -> f64) -> (f64, f64) {
    let (mut plain, mut weighted) = (0.0, 0.0);
    for (i, t) in terms.iter().enumerate() {
        plain += of(i);
        weighted += of(i) * t.weight(total);
    }
    if terms.is_empty() { (f64::NAN, f64::NAN) } else { (plain / terms.len() as f64, weighted) }
}

fn rms_singular_value(terms: &[FaceTerms], total: Totals) -> f64 {
    let sum = terms.iter().fold(0.0, |sum, t| sum + t.weight(total) * t.forward_and_back().0);
    sqrt(sum / 2.0)
}

/// Energies over a choice of faces.
struct Energies {
    dirichlet: f64,
    l2: f64,
    linf: f64,
    /// Square of the UV scale with the least energy.
    scale: f64,
}

impl Energies {
    /// A chosen face with s2 = 0 makes all of them infinite; no face makes them NaN.
    fn of(terms: &[FaceTerms], total: Totals, chosen: &dyn Fn(&FaceTerms) -> bool) -> Self {
        let (mut weight, mut forward, mut back, mut largest) = (0.0, 0.0, 0.0, f64::NAN);
        for t in terms.iter().filter(|t| chosen(t)) {
            let (w, (f, b)) = (t.weight(total), t.forward_and_back());
            weight += w;
            forward += w * f;
            back += w * b;
            largest = largest.max(1.0 / t.s2);
        }
        let (forward, back) = (forward / weight, back / weight);
        let normal = sqrt(total.uv / total.solid);
        let dirichlet = if back.is_infinite() { back } else { 2.0 * sqrt(forward * back) };
        let stretch = |x: f64| if x.is_infinite() { x } else { x * normal };
        Self { dirichlet, l2: stretch(sqrt(0.5 * back)), linf: stretch(largest), scale: sqrt(back / forward) }
    }
}

fn worst(terms: &[FaceTerms], of: &dyn Fn(usize) -> f64) -> Worst {
    let none = Worst { value: f64::NAN, face: u32::MAX };
    terms.iter().enumerate().fold(none, |worst, (i, t)| {
        let value = of(i);
        if worst.value >= value || value.is_nan() { worst } else { Worst { value, face: t.face as u32 } }
    })
}

/// The `share` quantile with linear interpolation between order statistics; reorders `values`; NaN where empty.
fn percentile(values: &mut [f64], share: f64) -> f64 {
    let Some(last) = values.len().checked_sub(1) else { return f64::NAN };
    let place = share * last as f64;
    let below = place as usize;
    let rest = place - below as f64;
    sort::select_by(values, below, f64::total_cmp);
    let low = values[below];
    let high = values[below + 1..].iter().copied().fold(f64::INFINITY, f64::min);
    if rest > 0.0 { low + (high - low) * rest } else { low }
}

#[cfg(test)]
mod tests {
    use super::super::input::{areas, areas_need};
    use super::*;
    use approx::assert_abs_diff_eq;
    use std::{vec, vec::Vec};

    fn judge(mesh: UvMesh) -> Distortion {
        let n = mesh.triangles.len();
        let mut bytes = vec![0; areas_need(n) + distortion_need(n)];
        let mut scratch = Scratch::new(&mut bytes);
        let areas = areas(mesh, &mut scratch).unwrap();
        let sound = Sound::of(mesh, areas, mesh.uv_box().map_or(1.0, |b| b.extent()));
        distortion(mesh, areas, sound, scratch).unwrap()
    }

    /// A 4 x 4 sheet in a tilted plane with UVs = `map` of its plane coordinates.
    fn sheet(map: impl Fn(DVec2) -> DVec2) -> Distortion {
        let (x, y) = (DVec3::new(0.6, 0.0, 0.8), DVec3::Y);
        let plane: Vec<DVec2> = (0..25).map(|i| DVec2::new((i % 5) as f64, (i / 5) as f64)).collect();
        let positions: Vec<DVec3> = plane.iter().map(|p| x * p.x + y * p.y).collect();
        let cells = (0..16u32).map(|i| i % 4 + 5 * (i / 4));
        let triangles: Vec<[u32; 3]> = cells.flat_map(|a| [[a, a + 1, a + 6], [a, a + 6, a + 5]]).collect();
        let corner_uv: Vec<[DVec2; 3]> = triangles.iter().map(|t| t.map(|v| map(plane[v as usize]))).collect();
        judge(UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv })
    }

    /// Each figure is some tens of operations on values near 1: 1e-12 leaves room for a few thousand roundings. The
    /// root of a difference of squares takes half of the digits, so s1 of an isometry is good to about 1e-8.
    fn near(a: f64, b: f64) {
        assert_abs_diff_eq!(a, b, epsilon = 1e-7 * (1.0 + b.abs()));
    }

    #[test]
    fn a_flat_square_has_no_distortion() {
        // Turned, scaled and mirrored: still no distortion.
        for map in [|p: DVec2| p, |p: DVec2| DVec2::new(-p.y, p.x) * 0.01, |p: DVec2| DVec2::new(-p.x, p.y)] {
            let d = sheet(map);
            [d.angle, d.area_ln, d.angle_p95, d.area_ln_aw, d.worst_angle.value].iter().for_each(|x| near(*x, 0.0));
            [d.qc_ratio, d.area_ratio, d.stretch_l2, d.stretch_linf, d.conformality()]
                .iter()
                .for_each(|x| near(*x, 1.0));
            [d.symmetric_dirichlet, d.symmetric_dirichlet_finite, d.worst_dirichlet.value]
                .iter()
                .for_each(|x| near(*x, 4.0));
            assert_eq!((d.degenerate_faces, d.zero_uv_faces, d.collapsed_faces), (0, 0, 0));
        }
    }

    #[test]
    fn a_shear_by_one_has_the_singular_values_of_the_golden_ratio() {
        // [[1, 1], [0, 1]]: s1 = phi, s2 = 1 / phi; areas are kept.
        let phi = (1.0 + sqrt(5.0)) / 2.0;
        let d = sheet(|p| DVec2::new(p.x + p.y, p.y));
        near(d.qc_ratio, 1.0 / (phi * phi));
        near(d.area_ln, 0.0);
        near(d.symmetric_dirichlet, 2.0 * (phi * phi + 1.0 / (phi * phi)));
        near(d.stretch_l2, sqrt(1.5));
        near(d.stretch_linf, phi);
        // The face (0, 0), (1, 0), (1, 1) has angles 45, 90, 45 and becomes (0, 0), (1, 0), (2, 1): 26.565, 135, 18.435.
        // The face (0, 0), (1, 1), (0, 1) becomes (0, 0), (2, 1), (1, 1), with the same errors.
        near(d.angle, (45.0 + 18.434_948_822_922 + 26.565_051_177_078) / 3.0 / 180.0 * core::f64::consts::PI);
    }

    #[test]
    fn a_stretch_by_four_along_x_is_scaled_to_half_and_two() {
        let d = sheet(|p| DVec2::new(4.0 * p.x, p.y));
        near(d.qc_ratio, 0.25);
        near(d.symmetric_dirichlet, 2.0 * (4.0 + 0.25));
        near(d.stretch_linf, 2.0);
    }

    #[test]
    fn a_collapsed_map_is_infinite_and_nothing_panics() {
        let d = sheet(|p| DVec2::new(p.x, 0.0));
        assert_eq!((d.collapsed_faces, d.zero_uv_faces), (32, 32));
        assert!(d.symmetric_dirichlet.is_infinite() && d.stretch_l2.is_infinite() && d.stretch_linf.is_infinite());
        assert!(d.symmetric_dirichlet_finite.is_nan() && d.worst_dirichlet.face == u32::MAX);
        near(d.area_ln, -ln(AREA_FLOOR));
    }

    #[test]
    fn one_collapsed_face_leaves_the_finite_figures() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE.with_z(0.0)];
        let (o, x, y) = (DVec2::ZERO, DVec2::X, DVec2::Y);
        let mesh = UvMesh {
            positions: &positions,
            triangles: &[[0, 1, 2], [1, 3, 2], [0, 0, 1]],
            corner_uv: &[[o, x, y], [x, x, y], [o, o, x]],
        };
        let d = judge(mesh);
        assert_eq!((d.degenerate_faces, d.zero_uv_faces, d.collapsed_faces), (1, 1, 1));
        assert!(d.symmetric_dirichlet.is_infinite());
        near(d.symmetric_dirichlet_finite, 4.0);
        assert_eq!((d.worst_area_ln.face, d.worst_dirichlet.face), (1, 1));
    }

    #[test]
    fn a_face_with_two_uv_corners_at_one_point_has_no_angles_in_uv() {
        // Found on a scanned model: 0 * -1 is -0, whose arc tangent is pi.
        let (o, down) = (DVec2::ZERO, DVec2::splat(-1.0));
        let mesh = UvMesh {
            positions: &[DVec3::ZERO, DVec3::X, DVec3::Y],
            triangles: &[[0, 1, 2]],
            corner_uv: &[[o, o, down]],
        };
        near(judge(mesh).angle, core::f64::consts::FRAC_PI_3);
    }

    #[test]
    fn percentiles_interpolate_between_order_statistics() {
        assert_eq!(percentile(&mut [3.0, 1.0, 2.0], 0.5), 2.0);
        assert_eq!(percentile(&mut [4.0, 0.0], 0.75), 3.0);
        assert_eq!(percentile(&mut [4.0], 0.95), 4.0);
        assert!(percentile(&mut [], 0.95).is_nan());
    }
}
