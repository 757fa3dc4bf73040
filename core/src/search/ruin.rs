//! Where cuts are closed again: balls around cuts that cost much, each of which holds other cuts than those before.

use crate::base::random::{hash, unit_f64};
use crate::base::real::sqrt;
use crate::base::room::Room;
use crate::charts::surface::Surface;
use crate::mesh::view::{NONE, next};
use crate::price::cost::FORBIDDEN;
use glam::{DVec2, DVec3};

/// Radius of a ball over the root of the area, on the mean; each has half to one and a half of it. With 0.4 and 0.5 the same is found
/// in 1.05 and 1.2 times the time.
const RADIUS: f64 = 0.3;
/// Draws of a ball that holds other cuts than those before, after which there are no more trials.
const DRAWS: u32 = 8;
/// Balls that are remembered.
const REMEMBERED: usize = 64;

/// A place whose cuts are closed.
#[derive(Clone, Copy)]
pub struct Ball {
    number: u32, // of the draw
    centre: DVec3,
    radius: f64,
}

impl Ball {
    /// Around the middle of a cut that is drawn by its cost; nothing where there are none to draw.
    fn draw(number: u32, uv: &[DVec2], cut: &[u8], surface: &Surface, seed: u64) -> Option<Self> {
        let key = hash(seed, 0xd4a4, u64::from(number));
        let centre = dearest(cut, uv, surface, unit_f64(key, 0, 0))?;
        let area: f64 = surface.rest.iter().map(|r| r.area).sum();
        Some(Self { number, centre, radius: RADIUS * sqrt(area) * (0.5 + unit_f64(key, 1, 0)) })
    }

    /// The cuts that it holds.
    pub fn cuts<'b>(&self, cut: &'b [u8], surface: &'b Surface) -> impl Iterator<Item = u32> + 'b {
        let Self { centre, radius, .. } = *self;
        let is_in = move |c: &u32| {
            let away = middle(*c, surface) - centre;
            away.dot(away) < radius * radius
        };
        (0..cut.len() as u32).filter(|c| may_close(*c, cut, surface)).filter(is_in)
    }
}

/// Balls that hold other cuts than those before.
#[derive(Default)]
pub struct Draws {
    number: u32,                          // of the next
    held: heapless::Vec<u64, REMEMBERED>, // hashes of the cuts in those before
}

impl Draws {
    /// Those after `ball`, of other cuts.
    pub fn after(ball: Ball) -> Self {
        Self { number: ball.number + 1, ..Self::default() }
    }

    /// The next ball that holds something new, if one of a few does.
    pub fn next(&mut self, uv: &[DVec2], cut: &[u8], surface: &Surface, seed: u64) -> Option<Ball> {
        for _ in 0..DRAWS {
            let ball = Ball::draw(self.number, uv, cut, surface, seed)?;
            self.number += 1;
            let held = ball.cuts(cut, surface).fold(0, |sum, c| hash(sum, u64::from(c), 0));
            if !self.held.contains(&held) {
                if self.held.is_full() {
                    self.held.clear();
                }
                self.held.put(held);
                return Some(ball);
            }
        }
        None
    }
}

/// Whether the edge of `c` is a cut that may be closed.
fn may_close(c: u32, cut: &[u8], surface: &Surface) -> bool {
    cut[c as usize] != 0 && surface.twin[c as usize] != NONE && surface.cost[c as usize] < FORBIDDEN
}

/// The middle of the cut up to which `share` of the cost of all goes.
fn dearest(cut: &[u8], uv: &[DVec2], surface: &Surface, share: f64) -> Option<DVec3> {
    let all = || (0..cut.len() as u32).filter(|c| may_close(*c, cut, surface) && surface.is_seen(uv, cut, *c));
    let cost = |c: &u32| surface.cost[*c as usize];
    let mut left = share * all().map(|c| cost(&c)).sum::<f64>();
    let found = all().find(|c| {
        left -= cost(c);
        left <= 0.0
    });
    found.or_else(|| all().next_back()).map(|c| middle(c, surface))
}

/// Middle of the edge of `c`.
fn middle(c: u32, surface: &Surface) -> DVec3 {
    (surface.mesh.position(c) + surface.mesh.position(next(c))) * 0.5
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::base::scratch::Scratch;
    use crate::mesh::topology::twins;
    use crate::mesh::view::MeshView;
    use crate::solve::energy::{MOLLIFY, Rest};
    use std::vec;
    use std::vec::Vec;

    /// A ball of 8 x 4^`splits` faces, with `costs` of its half-edges given their length.
    pub fn on_ball<T>(splits: u32, cost: impl Fn(u32, f64) -> f64, then: impl FnOnce(&Surface, Scratch) -> T) -> T {
        let axes = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
        let mut triangles: Vec<[DVec3; 3]> = (0..4)
            .flat_map(|i| [[axes[i], axes[(i + 1) % 4], DVec3::Z], [axes[(i + 1) % 4], axes[i], DVec3::NEG_Z]])
            .collect();
        for _ in 0..splits {
            let split = |t: &[DVec3; 3]| {
                let m = [0, 1, 2].map(|i| (t[i] + t[(i + 1) % 3]).normalize());
                [[t[0], m[0], m[2]], [t[1], m[1], m[0]], [t[2], m[2], m[1]], m]
            };
            triangles = triangles.iter().flat_map(split).collect();
        }
        let mut positions: Vec<DVec3> = Vec::new();
        let mut number = |p: DVec3| match positions.iter().position(|q| q.distance(p) < 1e-9) {
            Some(v) => v as u32,
            None => {
                positions.push(p);
                positions.len() as u32 - 1
            }
        };
        let faces: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(&mut number)).collect();
        let mesh = MeshView { positions: &positions, faces: &faces };
        let (mut memory, mut twin) = (vec![0; 1 << 26], vec![0; 3 * faces.len()]);
        let mut keep = Scratch::new(&mut memory);
        twins(&mut twin, mesh, keep.frame()).unwrap();
        let rest: Vec<Rest> = faces.iter().map(|f| Rest::new(f.map(|v| positions[v as usize]), MOLLIFY)).collect();
        let length = |c: u32| mesh.position(c).distance(mesh.position(next(c)));
        let costs: Vec<f64> = (0..twin.len() as u32).map(|c| cost(c.min(twin[c as usize]), length(c))).collect();
        let surface = Surface::new(mesh, &twin, &rest, &costs, &mut keep).unwrap();
        then(&surface, keep)
    }

    #[test]
    fn a_ball_holds_what_is_near_a_cut_that_costs_and_nothing_that_is_forbidden() {
        let of = |c: u32, length: f64| if c.is_multiple_of(7) { f64::INFINITY } else { length };
        on_ball(3, of, |surface, _| {
            let count = surface.twin.len();
            let uv: Vec<DVec2> = (0..count).map(|c| DVec2::new(c as f64, 0.0)).collect();
            let cut = vec![1; count];
            for seed in 0..8 {
                let ball = Ball::draw(1, &uv, &cut, surface, seed).unwrap();
                let held: Vec<u32> = ball.cuts(&cut, surface).collect();
                assert!(!held.is_empty() && held.len() < count);
                for c in &held {
                    assert!(surface.cost[*c as usize].is_finite() && held.contains(&surface.twin[*c as usize]));
                    assert!(middle(*c, surface).distance(ball.centre) < ball.radius);
                }
            }
            assert!(Ball::draw(1, &uv, &vec![0; count], surface, 1).is_none());
        });
    }

    #[test]
    fn balls_hold_something_new_until_there_is_nothing_new() {
        on_ball(
            1,
            |_, length| length,
            |surface, _| {
                let mut cut = vec![0; surface.twin.len()];
                [0, 9].iter().for_each(|c| surface.set_cut(&mut cut, *c, true));
                let uv: Vec<DVec2> = (0..cut.len()).map(|c| DVec2::new(c as f64, 0.0)).collect();
                let mut draws = Draws::default();
                let mut held: Vec<Vec<u32>> = Vec::new();
                while let Some(ball) = draws.next(&uv, &cut, surface, 3) {
                    held.push(ball.cuts(&cut, surface).collect());
                }
                // Of two cuts a ball holds one, the other or both.
                assert!((2..=3).contains(&held.len()), "{held:?}");
                held.sort();
                held.dedup();
                assert!((2..=3).contains(&held.len()), "{held:?}");
            },
        );
    }
}
