//! The plane in which a piece is its own mirror image.
//!
//! A plane is tried for each way in which two vertices that few are like, by their distances to the centre, may lie mirrored: each on
//! another one, or both in the plane. From there the images of vertices follow from neighbour to neighbour; the plane is fitted anew to
//! all of them, and each must lie where its image does. Faces go to faces; where two go to two that are parted by the other diagonal of
//! their quad, as triangles that were made of quads do, corners go to corners all the same.
//! Guarantee: images of images are where one began, and neighbours across the edges of faces and such quads stay neighbours. Cost:
//! O(n log n) and at the most [`EFFORT`] walks over all vertices.

use super::congruence::{Invariants, Likeness, strain};
use super::surface::Surface;
use crate::base::real::for_decision;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::mesh::view::{NONE, prev};
use core::ops::Range;
use glam::DVec3;

/// Walks over all vertices, in sum, that the planes of a piece may take.
const EFFORT: usize = 64;
/// Share of an edge's length by which the image of its end may be off where the plane is not well known yet.
const ASTRAY: f64 = 0.25;

/// A plane.
#[derive(Clone, Copy, Debug)]
pub struct MirrorPlane {
    /// The unit vector it is perpendicular to.
    pub normal: DVec3,
    /// Its distance from the origin along that.
    pub offset: f64,
}

impl MirrorPlane {
    /// How far `p` lies above it.
    pub fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }

    /// Mirror image of `p`.
    fn image(&self, p: DVec3) -> DVec3 {
        p - self.normal * (2.0 * self.height(p))
    }
}

/// Where two vertices may lie mirrored.
#[derive(Clone, Copy)]
struct Guess {
    plane: MirrorPlane,
    start: [u32; 2], // a vertex and its image
    doubt: f64,      // how far an image may be off, over its distance from the start
}

/// Scratch bytes that [`Mirror::find`] keeps or uses for a piece.
pub const fn mirror_need(faces: usize) -> usize {
    let corners = 3 * faces;
    7 * bytes_for::<u32>(corners) + bytes_for::<f64>(corners)
}

/// How a piece lies on itself mirrored.
pub struct Mirror<'a> {
    /// Where.
    pub plane: MirrorPlane,
    /// Corner on which each corner lies. That of a half-edge's start lies at the end of the half-edge's image.
    pub image: &'a [u32], // (3 f)
}

impl<'a> Mirror<'a> {
    /// Finds the plane whose edges part the piece, the longest of them in sum where there are several planes. With `over_diagonals`,
    /// diagonals of quads may differ.
    pub fn find(
        surface: &Surface,
        likeness: Likeness,
        over_diagonals: bool,
        keep: &mut Scratch<'a>,
    ) -> Result<Option<Self>, ScratchTooSmall> {
        let image = keep.take::<u32>(surface.twin.len())?;
        let mut scratch = keep.frame();
        let vertices = surface.mesh.positions.len();
        let figures = Invariants::of(surface);
        let (centre, slack) = (figures.centre, figures.slack(likeness));
        let of = scratch.take::<u32>(vertices)?;
        let queue = scratch.take::<u32>(vertices)?;
        let tried = scratch.take::<u32>(image.len())?;
        let mut search = MirrorSearch { surface, centre, slack, of, queue, effort: 0 };
        let (mut best, mut longest) = (None, 0.0);
        search.each_guess(scratch, |search, guess| {
            let Some(plane) = search.confirm(guess) else { return };
            if search.lay_corners(tried, over_diagonals) && search.leaves_faces_whole(&plane) {
                let length = search.length(&plane);
                if length > longest && strain(tried, surface, surface) <= likeness.strain {
                    (best, longest) = (Some(plane), length);
                    image.iter_mut().zip(tried.iter()).for_each(|(to, from)| *to = *from);
                }
            }
        })?;
        Ok(best.map(|plane| Self { plane, image }))
    }
}

impl Surface<'_> {
    /// Whether the faces at the half-edge of `c` are on different sides of `plane`.
    pub fn is_parted(&self, c: u32, plane: &MirrorPlane) -> bool {
        let t = self.twin[c as usize];
        let is_below = |c: u32| {
            let heights = self.heights(c / 3, plane);
            -heights.start > heights.end
        };
        t != NONE && is_below(c) != is_below(t)
    }

    /// From the lowest to the highest vertex of face `f`.
    fn heights(&self, f: u32, plane: &MirrorPlane) -> Range<f64> {
        let [a, b, c] = [0, 1, 2].map(|i| plane.height(self.mesh.position(3 * f + i)));
        a.min(b).min(c)..a.max(b).max(c)
    }
}

struct MirrorSearch<'s> {
    surface: &'s Surface<'s>,
    centre: DVec3,
    slack: f64,
    of: &'s mut [u32], // (n) image of each vertex
    queue: &'s mut [u32],
    effort: usize,
}

impl MirrorSearch<'_> {
    fn at(&self, v: u32) -> DVec3 {
        self.surface.mesh.positions[v as usize]
    }

    /// Calls `visit` for the ways in which a piece may lie on itself.
    fn each_guess(
        &mut self,
        mut scratch: Scratch,
        mut visit: impl FnMut(&mut Self, Guess),
    ) -> Result<(), ScratchTooSmall> {
        let (centre, vertices) = (self.centre, self.of.len());
        let away = scratch.take::<f64>(vertices)?;
        away.iter_mut().zip(self.surface.mesh.positions).for_each(|(a, p)| *a = p.distance(centre));
        let order = scratch.take::<u32>(vertices)?;
        order.iter_mut().zip(0..).for_each(|(o, v)| *o = v);
        sort::by(order, |a, b| away[*b as usize].total_cmp(&away[*a as usize]).then(a.cmp(b)));
        let like = |i: usize| {
            let near = |v: &u32| (away[*v as usize] - away[order[i] as usize]).abs() <= self.slack;
            let before = order[..i].iter().rev().take_while(|v| near(v)).take(EFFORT).count();
            let after = order[i..].iter().take_while(|v| near(v)).take(EFFORT).count();
            i - before..i + after
        };
        let rarest = |may_be: &dyn Fn(u32) -> bool| {
            let all = (0..vertices).filter(|i| may_be(order[*i]));
            all.min_by_key(|i| like(*i).len()).map(|i| (order[i], like(i)))
        };
        let Some((first, like_first)) = rarest(&|v| away[v as usize] > self.slack) else { return Ok(()) };
        let arm = |v: u32| self.surface.mesh.positions[v as usize] - centre;
        let beside = |v: u32| arm(first).cross(arm(v)).length() / away[first as usize];
        let Some((second, like_second)) = rarest(&|v| beside(v) > self.slack.max(0.1 * away[v as usize])) else {
            return Ok(());
        };
        for (v, alike) in [(first, like_first), (second, like_second)] {
            for w in order[alike].iter().filter(|w| **w != v) {
                let gap = self.at(*w) - self.at(v);
                if gap.length() > self.slack {
                    let doubt = 2.0 * self.slack / gap.length();
                    visit(self, Guess { plane: through(gap, centre), start: [v, *w], doubt });
                }
            }
        }
        let doubt = 2.0 * self.slack / beside(second);
        visit(self, Guess { plane: through(arm(first).cross(arm(second)), centre), start: [first; 2], doubt });
        Ok(())
    }

    /// Follows the images of vertices from a guess; the plane that fits them all, if they lie in it mirrored.
    fn confirm(&mut self, guess: Guess) -> Option<MirrorPlane> {
        if self.effort > EFFORT * self.of.len() {
            return None;
        }
        let reached = self.spread(guess);
        self.effort += reached;
        if reached < self.of.len() {
            return None;
        }
        let pairs = || self.of.iter().zip(0u32..).map(|(w, v)| [self.at(v), self.at(*w)]);
        let normal = guess.plane.normal;
        let sum: DVec3 = pairs().map(|[p, q]| if normal.dot(q - p) < 0.0 { p - q } else { q - p }).sum();
        let normal = sum.normalize_or_zero();
        let offset = pairs().map(|[p, q]| 0.5 * normal.dot(p + q)).sum::<f64>() / self.of.len() as f64;
        let plane = MirrorPlane { normal, offset };
        let is_there = |[p, q]: [DVec3; 2]| plane.image(p).distance(q) <= self.slack;
        let comes_back = |(w, v): (&u32, u32)| self.of[*w as usize] == v;
        (normal != DVec3::ZERO && pairs().all(is_there) && self.of.iter().zip(0..).all(comes_back)).then_some(plane)
    }

    /// Images of vertices, from neighbour to neighbour; returns how many have one.
    fn spread(&mut self, Guess { plane, start, doubt }: Guess) -> usize {
        self.of.fill(NONE);
        self.of[start[0] as usize] = start[1];
        self.queue[0] = start[0];
        let (mut head, mut tail) = (0, 1);
        while head < tail {
            let v = self.queue[head];
            head += 1;
            let there = self.of[v as usize];
            for (_, u) in self.surface.edges_at(v) {
                if self.of[u as usize] != NONE {
                    continue;
                }
                let place = plane.image(self.at(u));
                let off = |(_, w): (u32, u32)| (self.at(w).distance(place), w);
                let may_be = |(_, w): &(u32, u32)| {
                    let lengths = |of: DVec3, to: u32| self.at(to).distance(of);
                    (lengths(self.at(v), u) - lengths(self.at(there), *w)).abs() <= 2.0 * self.slack
                        && (lengths(self.centre, u) - lengths(self.centre, *w)).abs() <= 2.0 * self.slack
                };
                let beside = self.surface.edges_at(there).filter(may_be);
                let nearest = beside.map(off).min_by(|a, b| a.0.total_cmp(&b.0));
                let astray = self.slack + doubt * self.at(u).distance(self.at(start[0]));
                let most = self.slack.max(astray.min(ASTRAY * self.at(u).distance(self.at(v))));
                if let Some((_, w)) = nearest.filter(|(off, _)| *off <= most) {
                    self.of[u as usize] = w;
                    self.queue[tail] = u;
                    tail += 1;
                }
            }
        }
        tail
    }

    /// Lays corners on corners where vertices lie on vertices; whether faces come to lie on faces, or two of a quad on two of one.
    fn lay_corners(&self, image: &mut [u32], over_diagonals: bool) -> bool {
        (0..self.surface.mesh.faces.len() as u32).all(|f| {
            let corners = [3 * f, 3 * f + 1, 3 * f + 2];
            let along = corners.map(|c| self.along_edge(c));
            let missing = along.iter().filter(|on| on.is_none()).count();
            let both = [0, 1, 2].map(|i| along[i].or_else(|| self.across_diagonal(corners[i])));
            let [Some(a), Some(b), Some(c)] = both else { return false };
            corners.iter().zip([a, b, c]).for_each(|(c, on)| image[*c as usize] = on);
            missing == 0 && a / 3 == b / 3 && b / 3 == c / 3 || missing == 1 && over_diagonals
        })
    }

    /// The corner on which `c` lies where its half-edge lies on one that may be cut or not alike.
    fn along_edge(&self, c: u32) -> Option<u32> {
        let surface = self.surface;
        let [from, to] = [surface.mesh.vertex(c), surface.far_end(c)].map(|v| self.of[v as usize]);
        let on = *surface.corners_at(from).iter().find(|x| surface.mesh.vertex(prev(**x)) == to)?;
        let [own, other] =
            [c, prev(on)].map(|c| (surface.twin[c as usize] == NONE, surface.cost[c as usize].is_finite()));
        (own == other).then_some(on)
    }

    /// The corner on which `c` lies where its half-edge is a diagonal of a quad, and the other diagonal is there on the other side.
    fn across_diagonal(&self, c: u32) -> Option<u32> {
        let surface = self.surface;
        let t = surface.twin[c as usize];
        if t == NONE {
            return None;
        }
        let [p, q, r, s] = [c, t, prev(c), prev(t)].map(|c| self.of[surface.mesh.vertex(c) as usize]);
        let diagonal = *surface.corners_at(r).iter().find(|x| surface.far_end(**x) == s)?;
        let back = surface.twin[diagonal as usize];
        let is_quad = back != NONE && surface.mesh.vertex(prev(diagonal)) == p && surface.mesh.vertex(prev(back)) == q;
        is_quad.then(|| prev(diagonal))
    }

    /// Whether each face lies on one side of the plane, and no cut is where none may be.
    fn leaves_faces_whole(&self, plane: &MirrorPlane) -> bool {
        let surface = self.surface;
        let is_on_one_side = |f: u32| {
            let heights = surface.heights(f, plane);
            (heights.start >= -self.slack) != (heights.end <= self.slack)
        };
        let may_be_cut = |c: u32| surface.cost[c as usize].is_finite() || !surface.is_parted(c, plane);
        (0..surface.mesh.faces.len() as u32).all(is_on_one_side) && (0..surface.twin.len() as u32).all(may_be_cut)
    }

    /// Length of the edges that part the piece, rounded so that like planes count the same.
    fn length(&self, plane: &MirrorPlane) -> f64 {
        let parting = (0..self.surface.twin.len() as u32).filter(|c| self.surface.is_parted(*c, plane));
        for_decision(parting.map(|c| self.surface.length(c)).sum())
    }
}

/// The plane through `centre` that is perpendicular to `along`.
fn through(along: DVec3, centre: DVec3) -> MirrorPlane {
    let normal = along.normalize_or_zero();
    MirrorPlane { normal, offset: normal.dot(centre) }
}
