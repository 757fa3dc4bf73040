//! Walls: what keeps the border of a chart from running over itself while the chart is relaxed.
//!
//! Each border node pushes on border edges nearer than a tenth of the edge lengths there, with energy (r / d - 1)^2, and no
//! step is longer than up to the first contact (Smith, Schaefer 2015). Pairs are found by a sweep over boxes.
//! The Hessian is bounded by its blocks on the diagonal, so walls add nothing to the fill of the factor.
//! Guarantee: a border that does not touch itself never does. Cost: O(b log b + pairs) an evaluation for b border edges.

use super::piece::Piece;
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use glam::DVec2;

/// Distance at which pushing begins, over the shorter of the edge lengths: short enough to bend nothing.
const REACH: f64 = 0.1;
/// Weight of a pair, over the mean weight of a triangle.
const WEIGHT: f64 = 0.1;
/// Share of the reach to which a border that touches itself is opened.
const OPEN: f64 = 0.1;
/// How far a node of such a border moves towards the middle of its triangles at a time.
const STEP: f64 = 0.02;
/// Times that it may move.
const STEPS: usize = 8;

/// The border edges of a piece.
pub struct Walls<'w> {
    edges: &'w [[u32; 2]],       // (b) in order round the border
    length: &'w mut [[f64; 2]],  // (b) rest length of the edge; the shorter one of those at its first node
    boxes: &'w mut [[DVec2; 2]], // (b)
    order: &'w mut [u32],        // (b)
    weight: f64,
}

/// A border node close to a border edge.
struct Pair {
    node: u32,
    edge: [u32; 2],
    reach: f64,
}

impl Pair {
    /// Vector from the nearest point of the edge to the node, and the place of that point on the edge.
    fn gap(&self, x: &[DVec2]) -> (DVec2, f64) {
        let [a, b] = self.edge.map(|i| x[i as usize]);
        let (side, from) = (b - a, x[self.node as usize] - a);
        let t = (from.dot(side) / side.dot(side).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (from - side * t, t)
    }

    /// Largest step along `p` up to which the node does not meet the edge, at most `limit`.
    fn limit(&self, x: &[DVec2], p: &[DVec2], limit: f64) -> f64 {
        let [v, a, b] = [self.node, self.edge[0], self.edge[1]].map(|i| (x[i as usize], p[i as usize]));
        let (side, from) = ((b.0 - a.0, b.1 - a.1), (v.0 - a.0, v.1 - a.1));
        // Twice the area of the triangle: c + b t + a t^2.
        let c2 = side.1.perp_dot(from.1);
        let c1 = side.0.perp_dot(from.1) + side.1.perp_dot(from.0);
        let c0 = side.0.perp_dot(from.0);
        let disc = c1 * c1 - 4.0 * c2 * c0;
        if disc < 0.0 {
            return limit;
        }
        let q = -0.5 * (c1 + if c1 < 0.0 { -sqrt(disc) } else { sqrt(disc) });
        let mut least = limit;
        for t in [q / c2, c0 / q] {
            if t >= 0.0 && t < least {
                let (side, from) = (side.0 + side.1 * t, from.0 + from.1 * t);
                let place = from.dot(side) / side.dot(side);
                if (-1e-9..=1.0 + 1e-9).contains(&place) {
                    least = t;
                }
            }
        }
        least
    }
}

/// Scratch bytes for walls of this many border edges.
pub const fn walls_need(edges: usize) -> usize {
    bytes_for::<[u32; 2]>(edges) + 3 * bytes_for::<[DVec2; 2]>(edges) + bytes_for::<u32>(edges)
}

impl<'w> Walls<'w> {
    /// Walls on the border edges of a piece, from node to node round the border.
    pub fn new<'k: 'w>(edges: &'w [[u32; 2]], piece: &Piece, keep: &mut Scratch<'k>) -> Result<Self, ScratchTooSmall> {
        let count = edges.len();
        let length = keep.take::<[f64; 2]>(count)?;
        for (l, [a, b]) in length.iter_mut().zip(edges) {
            let d = piece.at[*a as usize] - piece.at[*b as usize];
            l[0] = sqrt(d.dot(d));
        }
        for i in 0..count {
            length[i][1] = length[i][0].min(length[(i + count - 1) % count][0]);
        }
        let weight = WEIGHT * piece.rest.iter().map(|r| r.weight).sum::<f64>() / piece.rest.len().max(1) as f64;
        Ok(Self { edges, length, boxes: keep.take(count)?, order: keep.take(count)?, weight })
    }

    /// Calls `visit` with the pairs that may come within their reach while nodes move from `x` by `step(node)`.
    fn pairs(&mut self, x: &[DVec2], step: impl Fn(u32) -> DVec2, mut visit: impl FnMut(Pair)) {
        let Self { edges, length, boxes, order, .. } = self;
        for (i, e) in edges.iter().enumerate() {
            let margin = DVec2::splat(0.5 * REACH * length[i][0]);
            let ends = e.map(|n| (x[n as usize], x[n as usize] + step(n)));
            let low = ends[0].0.min(ends[0].1).min(ends[1].0.min(ends[1].1));
            let high = ends[0].0.max(ends[0].1).max(ends[1].0.max(ends[1].1));
            boxes[i] = [low - margin, high + margin];
            order[i] = i as u32;
        }
        sort::by(order, |i, j| boxes[*i as usize][0].x.total_cmp(&boxes[*j as usize][0].x).then(i.cmp(j)));
        for (k, i) in order.iter().enumerate() {
            let i = *i as usize;
            for j in &order[k + 1..] {
                let j = *j as usize;
                if boxes[j][0].x > boxes[i][1].x {
                    break;
                }
                if boxes[j][0].y > boxes[i][1].y || boxes[i][0].y > boxes[j][1].y {
                    continue;
                }
                for (v, e) in [(i, j), (j, i)] {
                    let (node, edge) = (edges[v][0], edges[e]);
                    if !edge.contains(&node) {
                        visit(Pair { node, edge, reach: REACH * length[v][1].min(length[e][0]) });
                    }
                }
            }
        }
    }

    /// Energy of all pairs; infinite where the border touches itself.
    pub fn energy(&mut self, x: &[DVec2]) -> f64 {
        let (mut sum, weight) = (0.0, self.weight);
        self.pairs(
            x,
            |_| DVec2::ZERO,
            |pair| {
                let d = pair.gap(x).0;
                let d = sqrt(d.dot(d));
                if d < pair.reach {
                    let over = pair.reach / d - 1.0;
                    sum += weight * over * over;
                }
            },
        );
        sum
    }

    /// Writes each node's gradient, then the xx, xy, yy of its block of a matrix that is no less than the Hessian's positive
    /// part.
    pub fn derivatives(&mut self, x: &[DVec2], sums: &mut [[f64; 5]]) {
        sums.fill([0.0; 5]);
        let weight = self.weight;
        self.pairs(
            x,
            |_| DVec2::ZERO,
            |pair| {
                let (gap, t) = pair.gap(x);
                let d = sqrt(gap.dot(gap));
                if d >= pair.reach || d <= 0.0 {
                    return;
                }
                let (n, ratio) = (gap / d, pair.reach / d);
                let slope = -2.0 * weight * (ratio - 1.0) * ratio / d;
                let bend = 2.0 * weight * (3.0 * ratio - 2.0) * ratio / (d * d);
                // (n . sum c_i x_i)^2 <= (sum |c_i|) sum |c_i| (n . x_i)^2, and the |c_i| sum to 2.
                for (node, c) in [(pair.node, 1.0), (pair.edge[0], t - 1.0), (pair.edge[1], -t)] {
                    let sum = &mut sums[node as usize];
                    sum[0] += slope * c * n.x;
                    sum[1] += slope * c * n.y;
                    let size = 2.0 * bend * f64::abs(c);
                    sum[2] += size * n.x * n.x;
                    sum[3] += size * n.x * n.y;
                    sum[4] += size * n.y * n.y;
                }
            },
        );
    }

    /// Largest step along `p` up to which the border does not touch itself, at most `limit`.
    pub fn limit(&mut self, x: &[DVec2], p: &[DVec2], limit: f64) -> f64 {
        let mut least = limit;
        self.pairs(x, |n| p[n as usize] * limit, |pair| least = pair.limit(x, p, least));
        least
    }

    /// Opens a border that touches itself, as new slits do, by moving its nodes a bit into their triangles; puts `x` back
    /// where that would turn one.
    pub fn open(&mut self, x: &mut [DVec2], piece: &Piece, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
        if self.edges.is_empty() {
            return Ok(());
        }
        let middle = scratch.take::<[f64; 3]>(x.len())?;
        let close = scratch.take::<u8>(x.len())?;
        let flipped = |x: &[DVec2]| {
            piece.triangles.iter().zip(piece.rest).any(|(t, r)| !r.energy(t.map(|i| x[i as usize])).is_finite())
        };
        let mut share = STEP;
        for _ in 0..STEPS {
            close.fill(0);
            let mut any = false;
            {
                let here = &*x;
                self.pairs(
                    here,
                    |_| DVec2::ZERO,
                    |pair| {
                        let d = pair.gap(here).0;
                        if d.dot(d) < OPEN * OPEN * pair.reach * pair.reach {
                            any = true;
                            for n in [pair.node, pair.edge[0], pair.edge[1]] {
                                close[n as usize] = 1;
                            }
                        }
                    },
                );
            }
            if !any {
                return Ok(());
            }
            middle.fill([0.0; 3]);
            for t in piece.triangles {
                let centre = t.iter().map(|i| x[*i as usize]).sum::<DVec2>() / 3.0;
                for i in t {
                    let m = &mut middle[*i as usize];
                    *m = [m[0] + centre.x, m[1] + centre.y, m[2] + 1.0];
                }
            }
            let by = |i: usize| {
                let m = middle[i];
                if close[i] == 0 { DVec2::ZERO } else { (DVec2::new(m[0], m[1]) / m[2]) * share }
            };
            let old = |i: usize| if close[i] == 0 { 1.0 } else { 1.0 - share };
            x.iter_mut().enumerate().for_each(|(i, x)| *x = *x * old(i) + by(i));
            if flipped(x) {
                x.iter_mut().enumerate().for_each(|(i, x)| *x = (*x - by(i)) / old(i));
                share *= 0.5;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::energy::Rest;
    use approx::assert_abs_diff_eq;
    use glam::DVec3;
    use std::vec;
    use std::vec::Vec;

    /// Two triangles, and the border round them.
    const EDGES: [[u32; 2]; 4] = [[0, 1], [1, 2], [2, 3], [3, 0]];
    const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    /// The walls of a unit square whose corners stand at `x`.
    fn with_walls<T>(answer: impl FnOnce(&mut Walls, &Piece) -> T) -> T {
        let at = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let rest = TRIANGLES.map(|t| Rest::new(t.map(|i| at[i as usize]), 0.0));
        let piece = Piece { triangles: &TRIANGLES, rest: &rest, free: 4, at: &at, springs: &[], walls: &EDGES };
        let mut memory = [0; 2048];
        let mut keep = Scratch::new(&mut memory);
        let mut walls = Walls::new(&EDGES, &piece, &mut keep).expect("enough memory");
        answer(&mut walls, &piece)
    }

    fn points(height: f64) -> [DVec2; 4] {
        [DVec2::ZERO, DVec2::X, DVec2::new(1.2, height), DVec2::new(0.3, height)]
    }

    #[test]
    fn only_what_is_within_reach_is_pushed() {
        with_walls(|walls, _| {
            assert_eq!(walls.energy(&points(REACH * 1.01)), 0.0);
            assert!(walls.energy(&points(REACH * 0.9)) > 0.0);
            assert_eq!(walls.energy(&points(0.0)), f64::INFINITY);
        });
    }

    #[test]
    fn the_gradient_matches_central_differences_and_the_blocks_bound_the_bend() {
        with_walls(|walls, _| {
            let x = points(REACH * 0.5);
            let mut sums = vec![[0.0; 5]; 4];
            walls.derivatives(&x, &mut sums);
            let h = 1e-7;
            let ends = |walls: &mut Walls, i: usize| {
                [h, -h].map(|h| {
                    let mut y = x;
                    y[i / 2][i % 2] += h;
                    walls.energy(&y)
                })
            };
            let here = walls.energy(&x);
            for i in 0..8 {
                let [up, down] = ends(walls, i);
                let slope = (up - down) / (2.0 * h);
                // The third derivative is below 1e5 of the energy here: h^2 of it, and rounding over h.
                assert!((slope - sums[i / 2][i % 2]).abs() < 1e-6 * (1.0 + slope.abs()), "{i}");
                let bend = (up + down - 2.0 * here) / (h * h);
                assert!(bend <= sums[i / 2][2 + 2 * (i % 2)] * (1.0 + 1e-3) + 1.0, "{i}: {bend}");
            }
        });
    }

    #[test]
    fn a_step_ends_where_a_node_meets_an_edge() {
        with_walls(|walls, _| {
            let x = points(0.5);
            let fall = [DVec2::ZERO, DVec2::ZERO, DVec2::ZERO, DVec2::new(0.1, -1.0)];
            assert_abs_diff_eq!(walls.limit(&x, &fall, 2.0), 0.5, epsilon = 1e-12);
            assert_eq!(walls.limit(&x, &fall, 0.4), 0.4);
            // Past the end of the edge from 0 to 1 the node goes free, but the edge from 2 to 3 sweeps over node 0.
            let past = [DVec2::ZERO, DVec2::ZERO, DVec2::ZERO, DVec2::new(-1.0, -1.0)];
            let pair = Pair { node: 3, edge: [0, 1], reach: REACH };
            assert_eq!(pair.limit(&x, &past, 0.9), 0.9);
            assert!(walls.limit(&x, &past, 0.9) < 0.9);
        });
    }

    #[test]
    fn a_new_slit_is_opened_without_turning_a_triangle() {
        // A hexagon of six triangles whose slit from node 1 to the middle has its two sides, 1 and 7, at one place.
        let ring = |k: u32| {
            let angle = f64::from(k) * core::f64::consts::FRAC_PI_3;
            DVec2::new(crate::base::real::cos(angle), crate::base::real::sin(angle))
        };
        let mut x: Vec<DVec2> = [DVec2::ZERO].into_iter().chain((0..7).map(ring)).collect();
        x[7] = x[1];
        let at: Vec<DVec3> = x.iter().map(|p| p.extend(0.0)).collect();
        let triangles: Vec<[u32; 3]> = (1..7).map(|k| [0, k, k + 1]).collect();
        let rest: Vec<Rest> = triangles.iter().map(|t| Rest::new(t.map(|i| at[i as usize]), 0.0)).collect();
        let edges: Vec<[u32; 2]> = (0..8).map(|k| [k, (k + 1) % 8]).collect();
        let piece = Piece { triangles: &triangles, rest: &rest, free: 8, at: &at, springs: &[], walls: &edges };
        let mut memory = vec![0; 1 << 14];
        let mut keep = Scratch::new(&mut memory);
        let mut walls = Walls::new(&edges, &piece, &mut keep).expect("enough memory");
        assert_eq!(walls.energy(&x), f64::INFINITY);
        walls.open(&mut x, &piece, keep.frame()).expect("enough memory");
        assert!(walls.energy(&x).is_finite());
        assert!((x[1] - x[7]).length() > OPEN * REACH);
        let upright = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| x[i as usize]);
            (b - a).perp_dot(c - a) > 0.0
        };
        assert!(triangles.iter().all(upright));
        assert!(walls.open(&mut x, &piece, Scratch::new(&mut [0; 16])).is_err());
    }
}
