//! Charts on the move: f32 poses, and how deep one lies in another.

use super::field::{FieldMotion, FieldShape, Fields};
use super::outline;
use super::placement::Pose;
use crate::base::eight::{Eight, EightTask};
use glam::Vec2;

/// A chart's pose while it moves.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Body {
    /// Where the chart's centre is.
    pub at: Vec2,
    /// Cosine and sine of the angle.
    pub turn: Vec2,
    /// Angle.
    pub angle: f64,
}

impl Body {
    pub fn new(pose: &Pose) -> Self {
        Self { at: pose.at.as_vec2(), turn: outline::turn(pose.angle).as_vec2(), angle: pose.angle }
    }

    pub fn pose(&self) -> Pose {
        Pose { angle: self.angle, at: self.at.as_dvec2() }
    }
}

/// Two charts, how close they may come, and the depth from which nobody asks for more.
pub(super) struct Encounter<'a> {
    pub fields: &'a Fields<'a>,
    pub shapes: [&'a FieldShape; 2],
    pub bodies: [&'a Body; 2],
    pub gap: f32,
    pub limit: f32,
}

/// How deep the border points of both lie in the other one grown by the gap, or something above the limit; and the look-ups it took.
impl EightTask<(f32, u32)> for Encounter<'_> {
    #[inline(always)]
    fn run<E: Eight>(self) -> (f32, u32) {
        let (first, work_first) = self.one_way::<E>(0, 1, self.limit);
        let (second, work_second) = self.one_way::<E>(1, 0, self.limit - first);
        (first + second, work_first + work_second)
    }
}

impl Encounter<'_> {
    /// The same for the points of chart `a` in chart `b`.
    #[inline(always)]
    fn one_way<E: Eight>(&self, a: usize, b: usize, limit: f32) -> (f32, u32) {
        let Self { fields, shapes, bodies, gap, .. } = *self;
        let (a, b, body_a, body_b) = (shapes[a], shapes[b], bodies[a], bodies[b]);
        let back = Vec2::new(body_b.turn.x, -body_b.turn.y);
        let motion = FieldMotion { turn: back.rotate(body_a.turn), shift: back.rotate(body_a.at - body_b.at) };
        let (mut sum, mut work) = (0.0, 4);
        for top in fields.tops_of(a) {
            let mut near = fields.near::<E>(b, top, &motion, gap);
            while near != 0 {
                let i = near.trailing_zeros();
                near &= near - 1;
                let group = &fields.groups[(top.first + i) as usize];
                work += group.count;
                let mut left = fields.near::<E>(b, group, &motion, gap);
                while left != 0 {
                    let run = &fields.runs[(group.first + left.trailing_zeros()) as usize];
                    sum += fields.depth::<E>(b, run, &motion, gap);
                    work += run.count;
                    left &= left - 1;
                }
                if sum > limit {
                    return (sum, work + i + 1);
                }
            }
            work += top.count;
        }
        (sum, work)
    }
}
