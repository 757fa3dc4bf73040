//! Whether a piece is another one moved: how its corners lie on the other's.
//!
//! Surfaces that hang together are mapped onto one another by where a single half-edge goes: the rest follows from face to face.
//! The half-edge begins at a vertex of which there are few, by its distance to the centre, and is tried on each half-edge of the
//! other surface that may be its image; a try ends at the first edge that has another length. What comes through is compared
//! point by point in frames that far corners span, and face by face, for what no map may be laid on.
//! Guarantee: faces go to faces one to one, and neighbours to neighbours. Cost: O(n log n), and at the most [`EFFORT`] walks over all
//! faces. Limit: a shape where nearly every vertex might be another may need more, and counts as different then.

use super::surface::Surface;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::mesh::view::{MeshView, NONE, next, prev};
use crate::solve::bound::flat_area;
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};

/// Walks over all faces, in sum, that a comparison may take.
const EFFORT: usize = 64;
/// How far places may be apart that are the same, over what each may be off: two ends, the centre and two corners of a frame.
const SLACK: f64 = 10.0;
/// The same over a piece's size, where that is less: digits too few for a small piece would make all small pieces alike.
const COARSEST: f64 = 1e-3;
/// And where one piece takes the other's place in the texture anyway: the mirrored halves of figures from games, whose coordinates are
/// 1/64 apart, differ by 2.5e-3 of their size, and their edges by more.
const NEAR: f64 = 4e-3;
/// Mean energy over 4, less 1, of the map from one piece to the other, up to which charts are as true to both.
const STRAIN: f64 = 1e-6;
/// The same where one piece takes the other's place.
const NEAR_STRAIN: f64 = 1e-3;

/// What counts as alike.
#[derive(Clone, Copy, Debug)]
pub struct Likeness {
    /// How far each coordinate may be off, of a mesh of about size 1.
    pub tolerance: f64,
    /// How far places may be apart over a piece's size, where that is less.
    pub coarsest: f64,
    /// Mean energy over 4, less 1, of the map from one piece to the other.
    pub strain: f64,
    /// Whether what is mirrored is.
    pub mirrored: bool,
}

impl Likeness {
    /// What is one shape to the last digit.
    pub fn exact(tolerance: f64) -> Self {
        Self { tolerance, coarsest: COARSEST, strain: STRAIN, mirrored: false }
    }

    /// What was meant to be one shape, but for a trifle.
    pub fn near(mirrored: bool) -> Self {
        Self { tolerance: f64::INFINITY, coarsest: NEAR, strain: NEAR_STRAIN, mirrored }
    }
}

/// What stays as it is where a piece is moved.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Invariants {
    /// Faces, vertices, half-edges of the border, and those that may not be cut.
    pub counts: [u32; 4],
    /// Area.
    pub area: f64,
    /// Length of all half-edges.
    pub length: f64,
    /// Mean of the surface.
    pub centre: DVec3,
    /// Distance from there to the farthest vertex.
    pub reach: f64,
}

impl Invariants {
    /// Those of `surface`. O(f).
    pub fn of(surface: &Surface) -> Self {
        let mesh = surface.mesh;
        let (mut area, mut length, mut centre) = (0.0, 0.0, DVec3::ZERO);
        for f in 0..mesh.faces.len() {
            let corners = [0, 1, 2].map(|i| mesh.position((3 * f + i) as u32));
            let own = mesh.area_vector(f).length();
            area += own;
            centre += (corners[0] + corners[1] + corners[2]) * own;
            length += (0..3).map(|i| corners[i].distance(corners[(i + 1) % 3])).sum::<f64>();
        }
        let centre =
            if area > 0.0 { centre / (3.0 * area) } else { mesh.positions.first().copied().unwrap_or_default() };
        let border = surface.twin.iter().filter(|t| **t == NONE).count();
        let held = surface.cost.iter().filter(|c| c.is_infinite()).count();
        Self {
            counts: [mesh.faces.len(), mesh.positions.len(), border, held].map(|n| n as u32),
            area: 0.5 * area,
            length,
            centre,
            reach: mesh.positions.iter().map(|p| p.distance(centre)).fold(0.0, f64::max),
        }
    }

    /// How far two places may be apart that are the same.
    pub fn slack(&self, likeness: Likeness) -> f64 {
        (SLACK * likeness.tolerance).min(likeness.coarsest * self.reach)
    }

    /// Whether the piece may be `other` moved, by figures alone.
    pub fn is_like(&self, other: &Self, slack: f64) -> bool {
        self.counts == other.counts
            && (self.area - other.area).abs() <= slack * self.length
            && (self.reach - other.reach).abs() <= slack
    }
}

/// Scratch bytes that [`lay_onto`] uses.
pub const fn lay_onto_need(faces: usize, vertices: usize) -> usize {
    bytes_for::<f64>(vertices) + bytes_for::<u32>(vertices) + bytes_for::<u32>(faces)
}

/// Two pieces, the first of which may be the second moved.
#[derive(Clone, Copy)]
pub struct Comparison<'p> {
    /// What is laid.
    pub from: &'p Surface<'p>,
    /// Where it is laid.
    pub onto: &'p Surface<'p>,
    /// The figures of both.
    pub figures: [&'p Invariants; 2],
    /// Whether it is mirrored, not only moved.
    pub mirrored: bool,
    /// How far places may be apart.
    pub slack: f64,
    /// See [`Likeness::strain`].
    pub strain: f64,
}

/// Fills `image` with the corner of `onto` on which each corner of `from` comes to lie; whether there is such a motion. Without,
/// `image` is unspecified.
pub fn lay_onto(image: &mut [u32], pair: Comparison, mut scratch: Scratch) -> Result<bool, ScratchTooSmall> {
    let [own, other] = pair.figures;
    if !own.is_like(other, pair.slack) {
        return Ok(false);
    }
    let faces = pair.from.mesh.faces.len();
    let Some(seed) = pair.seed(scratch.frame())? else { return Ok(false) };
    let queue = scratch.take::<u32>(faces)?;
    image.fill(NONE);
    let away = pair.away(0, seed);
    let mut effort = 0;
    for c in 0..pair.onto.twin.len() as u32 {
        if (pair.away(1, c) - away).abs() > pair.slack {
            continue;
        }
        let (reached, fits) = pair.walk(image, queue, [seed, c]);
        if fits && pair.is_moved(image) && pair.is_true(image) {
            return Ok(true);
        }
        queue[..reached].iter().for_each(|f| image[3 * *f as usize..3 * *f as usize + 3].fill(NONE));
        effort += reached;
        if effort > EFFORT * faces {
            break;
        }
    }
    Ok(false)
}

impl Comparison<'_> {
    fn mesh(&self, side: usize) -> MeshView<'_> {
        if side == 0 { self.from.mesh } else { self.onto.mesh }
    }

    /// A corner from the centre of its piece.
    fn arm(&self, side: usize, c: u32) -> DVec3 {
        self.mesh(side).position(c) - self.figures[side].centre
    }

    /// Its length.
    fn away(&self, side: usize, c: u32) -> f64 {
        self.arm(side, c).length()
    }

    /// The image of the next corner of the face of a corner whose image is `c`.
    fn next(&self, c: u32) -> u32 {
        if self.mirrored { prev(c) } else { next(c) }
    }

    /// The half-edge that is the image of that of a corner whose image is `c`.
    fn half_edge(&self, c: u32) -> u32 {
        if self.mirrored { prev(c) } else { c }
    }

    /// A corner at a vertex of `from` that has few like it: distances to the centre are put in heaps that lie apart, the smallest
    /// heap counts, and of equal ones the farthest.
    fn seed(&self, mut scratch: Scratch) -> Result<Option<u32>, ScratchTooSmall> {
        let positions = self.from.mesh.positions;
        let away = scratch.take::<f64>(positions.len())?;
        away.iter_mut().zip(positions).for_each(|(a, p)| *a = p.distance(self.figures[0].centre));
        let order = scratch.take::<u32>(positions.len())?;
        order.iter_mut().zip(0..).for_each(|(o, v)| *o = v);
        sort::by(order, |a, b| away[*b as usize].total_cmp(&away[*a as usize]).then(a.cmp(b)));
        let (mut best, mut least, mut first) = (None, usize::MAX, 0);
        for i in 1..=order.len() {
            let gap = order.get(i).map_or(f64::INFINITY, |v| away[order[i - 1] as usize] - away[*v as usize]);
            if gap > self.slack {
                if i - first < least {
                    (best, least) = (order[first..i].iter().min().copied(), i - first);
                }
                first = i;
            }
        }
        Ok(best.and_then(|v| (0..self.from.twin.len() as u32).find(|c| self.from.mesh.vertex(*c) == v)))
    }

    /// Maps face after face, from where the first of two corners lies on the second. Returns how many faces it reached, those in
    /// `queue`, and whether they are all and fit.
    fn walk(&self, image: &mut [u32], queue: &mut [u32], [seed, onto]: [u32; 2]) -> (usize, bool) {
        if !self.lay_face(image, seed, onto) {
            return (0, false);
        }
        queue[0] = seed / 3;
        let (mut head, mut tail) = (0, 1);
        while head < tail {
            let f = queue[head];
            head += 1;
            for c in 3 * f..3 * f + 3 {
                let there = self.half_edge(image[c as usize]);
                let (t, across) = (self.from.twin[c as usize], self.onto.twin[there as usize]);
                if t == NONE && across == NONE {
                    continue;
                }
                if t == NONE || across == NONE {
                    return (tail, false);
                }
                let across = if self.mirrored { next(across) } else { across };
                if image[t as usize] == NONE && self.lay_face(image, t, across) {
                    queue[tail] = t / 3;
                    tail += 1;
                }
                if image[t as usize] != across {
                    return (tail, false);
                }
            }
        }
        (tail, tail == queue.len())
    }

    /// Lays the face of corner `c` so that `c` lies on `onto`, if their edges are as long and as far from the centre, and may be cut
    /// or not alike.
    fn lay_face(&self, image: &mut [u32], c: u32, onto: u32) -> bool {
        let from = [c, next(c), prev(c)];
        let to = [onto, self.next(onto), self.next(self.next(onto))];
        let fits = from.iter().zip(&to).all(|(c, d)| {
            let side = self.half_edge(*d);
            let lengths = [(0, *c), (1, side)].map(|(s, c)| self.arm(s, c).distance(self.arm(s, next(c))));
            let held = [self.from.cost[*c as usize], self.onto.cost[side as usize]].map(f64::is_infinite);
            held[0] == held[1]
                && (lengths[0] - lengths[1]).abs() <= self.slack
                && (self.away(0, *c) - self.away(1, *d)).abs() <= self.slack
        });
        if fits {
            from.iter().zip(to).for_each(|(c, d)| image[*c as usize] = d);
        }
        fits
    }

    /// Whether every corner lies where its image does, in frames that the farthest corner and the one farthest from that axis span.
    fn is_moved(&self, image: &[u32]) -> bool {
        let corners = || 0..image.len() as u32;
        let farthest = |away: &dyn Fn(DVec3) -> f64| {
            let far = |best: (f64, u32), c: u32| {
                let d = away(self.arm(0, c));
                if d > best.0 { (d, c) } else { best }
            };
            corners().fold((0.0, 0), far).1
        };
        let first = farthest(&|p| p.length());
        let axis = self.arm(0, first).normalize_or_zero();
        let second = farthest(&|p| (p - axis * axis.dot(p)).length());
        let frame = |side: usize, of: &dyn Fn(u32) -> u32| {
            let [p, q] = [first, second].map(|c| self.arm(side, of(c)));
            let x = p.normalize_or_zero();
            let y = (q - x * x.dot(q)).normalize_or_zero();
            [x, y, x.cross(y) * if side == 1 && self.mirrored { -1.0 } else { 1.0 }]
        };
        let (own, other) = (frame(0, &|c| c), frame(1, &|c| image[c as usize]));
        corners().all(|c| {
            let (p, q) = (self.arm(0, c), self.arm(1, image[c as usize]));
            let gap = DVec3::from([0, 1, 2].map(|i| own[i].dot(p) - other[i].dot(q)));
            gap.length() <= self.slack
        })
    }

    /// Whether a chart of `onto` is as true to `from`, but for a trifle.
    fn is_true(&self, image: &[u32]) -> bool {
        strain(image, self.from, self.onto) <= self.strain
    }
}

/// Mean energy over 4, less 1, of the map that lays each corner of `from` where its `image` on `onto` is.
pub fn strain(image: &[u32], from: &Surface, onto: &Surface) -> f64 {
    let flat = flat_area(from.rest);
    let (mut energy, mut area) = (0.0, 0.0);
    for (rest, on) in from.rest.iter().zip(image.as_chunks::<3>().0).filter(|(rest, _)| rest.area > flat) {
        let [p, q, r] = on.map(|c| onto.mesh.position(c));
        let (side, arm) = (q - p, r - p);
        let length = side.length();
        let tip = DVec2::new(arm.dot(side), arm.cross(side).length()) / length;
        energy += rest.area * rest.energy([DVec2::ZERO, DVec2::new(length, 0.0), tip]) * 0.25;
        area += rest.area;
    }
    if area > 0.0 { energy / area - 1.0 } else { 0.0 }
}
