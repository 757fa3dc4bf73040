//! A continuous map of a whole piece, made into charts: cut where it tears.
//!
//! A closed surface cannot go to the plane without a tear, and a map that is a function on space, as a trained one is, tears by
//! stretching some faces far. A face is sound if its area in UV has the sign of most and neither it nor its longest
//! stretch is far from the usual. Sound faces keep the map's own UVs. From their border the others are laid down one by one as
//! extrapolations: each beside the face that reached it, at the usual scale, its third corner where another face has it already
//! if it stays sound so. Where two fronts meet that disagree, there is the cut: in the middle of the tear, or where in the tear
//! a cut costs least, because fronts are the faster the more a cut costs (a watershed, as of Beucher and Lantuejoul 1979).
//! Guarantee: every face has a UV and none is flipped. Limits: charts may overlap and need not be disks; who needs that
//! looks at them afterwards. Cost: O(n log n).

use crate::base::heap::Heap;
use crate::base::real::{for_cost, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::charts::surface::Surface;
use crate::mesh::view::{NONE, next, prev};
use crate::solve::bound::flat_area;
use crate::solve::energy::Rest;
use glam::DVec2;

/// Longest stretch of a sound face over the usual: 2 takes faces that are only distorted for torn, 5 lets tears through whose
/// band is three faces wide.
const STRETCH: f64 = 3.0;
/// Least area in UV over that in space, in the usual unit.
const SHRINK: f64 = 0.05;
/// Sound regions below this share of the area are part of the tear around them.
const ISLAND: f64 = 0.005;

/// What was torn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Torn {
    /// Faces that were laid down anew.
    pub faces: usize,
    /// Of these, faces whose area had the other sign.
    pub folded: usize,
}

/// Scratch bytes for [`tear`].
pub const fn tear_need(faces: usize) -> usize {
    bytes_for::<f64>(3 * faces)
        .saturating_add(2 * bytes_for::<u32>(3 * faces))
        .saturating_add(bytes_for::<u32>(faces))
        .saturating_add(bytes_for::<u8>(faces))
}

/// The usual length in UV of a length in space, the median over faces, and the sign that most of the surface has. The map's own
/// signed area would not do: of a closed surface it is 0 whatever the map, and its sign that of a rounding.
struct Usual {
    scale: f64,
    sign: f64,
}

impl Usual {
    fn is_sound(&self, rest: &Rest, x: [DVec2; 3]) -> bool {
        let [c0, c1] = rest.jacobian(x).map(|c| c / self.scale);
        let (det, norm) = (c0.perp_dot(c1), c0.dot(c0) + c1.dot(c1));
        let longest = 0.5 * (norm + sqrt((norm * norm - 4.0 * det * det).max(0.0)));
        det >= SHRINK && longest <= STRETCH * STRETCH
    }
}

/// Cuts the map `q` (one point a vertex of `surface`) where it tears: writes `uv` and `cut` (one entry a corner) and `torn`
/// (one a face). The usual face has in UV the area that it has in space, so that maps of several pieces agree in scale.
pub fn tear(
    uv: &mut [DVec2],
    cut: &mut [u8],
    torn: &mut [u8],
    q: &[DVec2],
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<Torn, ScratchTooSmall> {
    let count = surface.mesh.faces.len();
    scratch.require(tear_need(count))?;
    let usual = usual(q, surface, &mut scratch.frame())?;
    // A map that shows the surface from inside is turned over.
    let point = |v: u32| DVec2::new(q[v as usize].x * usual.sign, q[v as usize].y);
    for (c, uv) in uv.iter_mut().enumerate() {
        *uv = point(surface.mesh.vertex(c as u32));
    }
    let flat = flat_area(surface.rest);
    let corners = |f: usize| [3 * f, 3 * f + 1, 3 * f + 2];
    let mut done = Torn::default();
    for (f, rest) in surface.rest.iter().enumerate() {
        let x = corners(f).map(|c| uv[c]);
        torn[f] = u8::from(rest.area <= flat || !usual.is_sound(rest, x));
        done.folded += usize::from((x[1] - x[0]).perp_dot(x[2] - x[0]) <= 0.0);
    }
    whole_polygons(torn, surface);
    drop_islands(torn, cut, surface, scratch.frame())?;
    whole_polygons(torn, surface);
    done.faces = torn.iter().filter(|t| **t != 0).count();
    grow(uv, torn, &usual, surface, scratch)?;
    uv.iter_mut().for_each(|x| *x /= usual.scale);
    for c in 0..surface.mesh.corner_count() as u32 {
        let t = surface.twin[c as usize];
        let same = |a: u32, b: u32| uv[a as usize] == uv[b as usize];
        cut[c as usize] = u8::from(t != NONE && !(same(c, next(t)) && same(next(c), t)));
    }
    Ok(done)
}

fn usual(q: &[DVec2], surface: &Surface, scratch: &mut Scratch) -> Result<Usual, ScratchTooSmall> {
    let areas = scratch.take::<f64>(surface.mesh.faces.len())?;
    let mut sum = 0.0;
    for ((a, f), rest) in areas.iter_mut().zip(surface.mesh.faces).zip(surface.rest) {
        let [c0, c1] = rest.jacobian(f.map(|v| q[v as usize]));
        let det = c0.perp_dot(c1);
        sum += if det < 0.0 { -rest.area } else { rest.area };
        *a = det.abs();
    }
    sort::by(areas, f64::total_cmp);
    let scale = sqrt(areas.get(areas.len() / 2).copied().unwrap_or(1.0));
    let scale = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
    Ok(Usual { scale, sign: if sum < 0.0 { -1.0 } else { 1.0 } })
}

/// A polygon is torn or sound as a whole: edges of infinite cost are inside one.
fn whole_polygons(torn: &mut [u8], surface: &Surface) {
    let mut again = true;
    while again {
        again = false;
        for c in (0..surface.mesh.corner_count()).filter(|c| surface.cost[*c].is_infinite()) {
            let (f, t) = (c / 3, surface.twin[c]);
            if t != NONE && torn[f] != 0 && torn[(t / 3) as usize] == 0 {
                torn[(t / 3) as usize] = 1;
                again = true;
            }
        }
    }
}

/// Marks small sound regions as torn; the largest stays.
fn drop_islands(
    torn: &mut [u8],
    border: &mut [u8], // (3 f), overwritten
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    for (c, out) in border.iter_mut().enumerate() {
        let t = surface.twin[c];
        *out = u8::from(t != NONE && torn[c / 3] != torn[(t / 3) as usize]);
    }
    let (region, queue) = (scratch.take::<u32>(torn.len())?, scratch.take::<u32>(torn.len())?);
    let count = surface.charts(border, region, queue);
    let area = scratch.take::<f64>(count)?;
    let mut total = 0.0;
    for (f, rest) in surface.rest.iter().enumerate() {
        total += rest.area;
        area[region[f] as usize] += if torn[f] == 0 { rest.area } else { 0.0 };
    }
    let largest = (0..count).fold(0, |best, k| if area[k] > area[best] { k } else { best });
    for f in 0..torn.len() {
        let k = region[f] as usize;
        torn[f] |= u8::from(k != largest && area[k] < ISLAND * total);
    }
    Ok(())
}

/// Lays down the torn faces from the sound ones outwards.
fn grow(
    uv: &mut [DVec2],
    torn: &[u8],
    usual: &Usual,
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let count = torn.len();
    let mut heap = Heap::new(scratch.take(3 * count)?, scratch.take(3 * count)?, scratch.take(3 * count)?);
    let stack = scratch.take::<u32>(count)?;
    let placed = scratch.take::<u8>(count)?;
    placed.iter_mut().zip(torn).for_each(|(p, t)| *p = u8::from(*t == 0));
    if let Some(rest) = surface.rest.first().filter(|_| placed.iter().all(|p| *p == 0)) {
        let base = DVec2::new(rest.base() * usual.scale, 0.0);
        (uv[0], uv[1], uv[2]) = (DVec2::ZERO, base, rest.unfold(DVec2::ZERO, base));
        placed[0] = 1;
    }
    let reach = |f: u32, time: f64, heap: &mut Heap, placed: &[u8]| {
        for c in 3 * f..3 * f + 3 {
            let t = surface.twin[c as usize];
            if t != NONE && placed[(t / 3) as usize] == 0 {
                heap.push(t, time + crossing(c, surface));
            }
        }
    };
    (0..count as u32).filter(|f| placed[*f as usize] != 0).for_each(|f| reach(f, 0.0, &mut heap, placed));
    while let Some((first, time)) = heap.pop() {
        // The face beyond, and with it the rest of its polygon.
        let mut put = |t: u32, stack: &mut [u32], depth: &mut usize| {
            if t == NONE || placed[(t / 3) as usize] != 0 {
                return;
            }
            lay(uv, t, surface.twin[t as usize], placed, usual, surface);
            placed[(t / 3) as usize] = 1;
            stack[*depth] = t / 3;
            *depth += 1;
            reach(t / 3, time, &mut heap, placed);
        };
        let mut depth = 0;
        put(first, stack, &mut depth);
        while depth > 0 {
            depth -= 1;
            let f = stack[depth];
            for c in (3 * f..3 * f + 3).filter(|c| surface.cost[*c as usize].is_infinite()) {
                put(surface.twin[c as usize], stack, &mut depth);
            }
        }
    }
    Ok(())
}

/// Time a front takes across half-edge `c`: its length over what a cut costs there a unit of length. Fronts hurry through the
/// open and meet where nobody looks; where cost is length alone they meet in the middle.
fn crossing(c: u32, surface: &Surface) -> f64 {
    let d = surface.mesh.position(next(c)) - surface.mesh.position(c);
    for_cost(d.dot(d) / surface.cost[c as usize])
}

/// Lays the face of half-edge `t` beside that of its twin `c`.
fn lay(uv: &mut [DVec2], t: u32, c: u32, placed: &[u8], usual: &Usual, surface: &Surface) {
    let (from, to, third) = (t as usize, next(t) as usize, prev(t));
    (uv[from], uv[to]) = (uv[next(c) as usize], uv[c as usize]);
    let mut rest = surface.rest[(t / 3) as usize];
    (0..t % 3).for_each(|_| rest = rest.turned());
    let expected = rest.unfold_at_scale(uv[from], uv[to], usual.scale);
    let known = surface.corners_at(surface.mesh.vertex(third)).iter();
    let known = known.filter(|d| placed[(**d / 3) as usize] != 0).map(|d| uv[*d as usize]);
    let gap = |p: DVec2| (p - expected).dot(p - expected);
    let sound = known.filter(|p| usual.is_sound(&rest, [uv[from], uv[to], *p]));
    let best =
        sound.fold(None, |best: Option<DVec2>, p| if best.is_none_or(|b| gap(p) < gap(b)) { Some(p) } else { best });
    uv[third as usize] = best.unwrap_or(expected);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::topology::twins;
    use crate::mesh::view::MeshView;
    use crate::solve::energy::MOLLIFY;
    use glam::DVec3;
    use std::vec;
    use std::vec::Vec;

    const SIDE: usize = 12;

    struct Cut {
        uv: Vec<DVec2>,
        cut: Vec<u8>,
        torn: Vec<u8>,
        done: Torn,
        charts: usize,
        flips: usize,
        twin: Vec<u32>,
    }

    /// A flat square sheet of SIDE x SIDE vertices, mapped by `map`; `less` bytes too few.
    fn cut(map: impl Fn(DVec2) -> DVec2, less: usize) -> Result<Cut, ScratchTooSmall> {
        let (positions, faces) = sheet();
        let q: Vec<DVec2> = positions.iter().map(|p| map(p.truncate())).collect();
        cut_mesh(&positions, &faces, &q, less)
    }

    fn sheet() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let at = |i: usize| DVec2::new((i % SIDE) as f64, (i / SIDE) as f64) / (SIDE - 1) as f64;
        let mut faces = Vec::new();
        for i in (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE + 1 < SIDE) {
            let [a, b, c, d] = [i, i + 1, i + SIDE, i + SIDE + 1].map(|v| v as u32);
            faces.extend([[a, b, d], [a, d, c]]);
        }
        ((0..SIDE * SIDE).map(|i| at(i).extend(0.0)).collect(), faces)
    }

    fn cut_mesh(positions: &[DVec3], faces: &[[u32; 3]], q: &[DVec2], less: usize) -> Result<Cut, ScratchTooSmall> {
        let mesh = MeshView { positions, faces };
        let mut twin = vec![0; 3 * faces.len()];
        let mut memory = vec![0u8; 1 << 20];
        twins(&mut twin, mesh, Scratch::new(&mut memory)).unwrap();
        let rest: Vec<Rest> = faces.iter().map(|f| Rest::new(f.map(|v| positions[v as usize]), MOLLIFY)).collect();
        let cost = vec![1.0; twin.len()];
        let mut kept = Scratch::new(&mut memory);
        let surface = Surface::new(mesh, &twin, &rest, &cost, &mut kept).unwrap();
        let (mut uv, mut cut, mut torn) = (vec![DVec2::NAN; twin.len()], vec![9; twin.len()], vec![9; faces.len()]);
        let mut bytes = vec![0; tear_need(faces.len()) - less];
        let done = tear(&mut uv, &mut cut, &mut torn, q, &surface, Scratch::new(&mut bytes))?;
        let (mut chart, mut queue) = (vec![0; faces.len()], vec![0; faces.len()]);
        let charts = surface.charts(&cut, &mut chart, &mut queue);
        let flips = uv.chunks_exact(3).filter(|x| (x[1] - x[0]).perp_dot(x[2] - x[0]) <= 0.0).count();
        Ok(Cut { uv, cut, torn, done, charts, flips, twin })
    }

    /// Equal UVs across every edge without a cut: what makes cuts and UVs one description.
    fn agree(cut: &Cut) -> bool {
        (0..cut.twin.len() as u32).filter(|c| cut.twin[*c as usize] != NONE && cut.cut[*c as usize] == 0).all(|c| {
            let t = cut.twin[c as usize];
            cut.uv[c as usize] == cut.uv[next(t) as usize] && cut.uv[next(c) as usize] == cut.uv[t as usize]
        })
    }

    #[test]
    fn a_map_that_does_not_tear_stays_as_it_is() {
        let whole = cut(|p| p * 3.0, 0).unwrap();
        // Rest edges are MOLLIFY, 1e-8 of their length, too long; an area counts that up to four times.
        assert!((whole.uv[1].x * (SIDE - 1) as f64 - 1.0).abs() < 1e-7, "at the size of the surface");
        assert_eq!((whole.done, whole.charts, whole.flips), (Torn::default(), 1, 0));
        assert!(whole.cut.iter().all(|c| *c == 0) && whole.uv[1].x > 0.0 && agree(&whole));
        // Seen from inside, it is turned over.
        let mirrored = cut(|p| DVec2::new(-p.x, p.y), 0).unwrap();
        assert_eq!((mirrored.done.faces, mirrored.charts, mirrored.flips), (0, 1, 0));
    }

    #[test]
    fn a_tear_becomes_a_cut_through_its_middle_and_no_face_is_flipped() {
        // Everything right of the sixth column is moved away: the 22 faces between are stretched.
        let two = cut(|p| if p.x > 0.5 { p + DVec2::X * 5.0 } else { p }, 0).unwrap();
        assert_eq!((two.done.faces, two.done.folded, two.charts, two.flips), (22, 0, 2, 0));
        assert!(agree(&two));
        let width: f64 =
            two.uv.chunks_exact(3).map(|x| x[0].distance(x[1]).max(x[1].distance(x[2]))).fold(0.0, f64::max);
        assert!(width < 1.5 / (SIDE - 1) as f64 * 2f64.sqrt(), "torn faces have their usual size: {width}");
    }

    #[test]
    fn a_fold_is_opened_and_its_faces_are_counted() {
        // The right third is folded back over the middle: 3 columns of 22 faces have the other sign.
        let folded = cut(|p| DVec2::new(if p.x > 0.7 { 1.45 - p.x } else { p.x }, p.y), 0).unwrap();
        assert!(folded.done.folded >= 3 * 22 && folded.done.faces >= folded.done.folded, "{:?}", folded.done);
        assert!(folded.flips == 0 && agree(&folded));
        assert_eq!(folded.torn.iter().filter(|t| **t != 0).count(), folded.done.faces);
    }

    #[test]
    fn a_closed_surface_is_seen_from_the_side_that_most_of_it_shows() {
        // A dome, closed below by a flat fan: pressed flat, both cover the square, and the signed areas cancel.
        let (mut positions, mut faces) = sheet();
        let arch = |x: f64| 4.0 * x * (1.0 - x);
        positions.iter_mut().for_each(|p| p.z = arch(p.x) * arch(p.y));
        let rim = faces.iter().flat_map(|f| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]]);
        let inner = |e: &[u32; 2]| faces.iter().any(|f| (0..3).any(|i| [f[(i + 1) % 3], f[i]] == *e));
        let apex = positions.len() as u32;
        let fan: Vec<[u32; 3]> = rim.filter(|e| !inner(e)).map(|[a, b]| [b, a, apex]).collect();
        assert_eq!(fan.len(), 4 * (SIDE - 1));
        positions.push(DVec3::new(0.5, 0.5, -0.01));
        faces.extend(fan);
        // Sixteen views: what is left of the signed area is a rounding, and its sign is right in some of them.
        for (view, mirror) in (0..8).flat_map(|k| [(k, 1.0), (k, -1.0)]) {
            let turn = DVec2::from_angle(0.7 * f64::from(view));
            let q: Vec<DVec2> = positions.iter().map(|p| turn.rotate(DVec2::new(mirror * p.x, p.y))).collect();
            let closed = cut_mesh(&positions, &faces, &q, 0).unwrap();
            assert_eq!((closed.done.folded, closed.flips), (4 * (SIDE - 1), 0));
            assert!(agree(&closed));
        }
    }

    #[test]
    fn a_map_without_area_still_gives_every_face_a_uv() {
        for map in [|_: DVec2| DVec2::ZERO, |p: DVec2| DVec2::new(p.x, 0.0)] {
            let flat = cut(map, 0).unwrap();
            assert!(flat.flips == 0 && agree(&flat) && flat.uv.iter().all(|x| x.is_finite()));
        }
    }

    #[test]
    fn a_byte_too_few_is_refused() {
        assert!(cut(|p| p, 1).is_err());
    }
}
