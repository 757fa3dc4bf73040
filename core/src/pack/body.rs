//! Charts on the move: f32 poses, and how deep one lies in another.

use super::field::{FieldShape, Fields};
use super::outline;
use super::placement::Pose;
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

/// How deep the border points of `a` lie in `b` grown by `gap`; and the look-ups it took.
#[inline(always)]
pub(super) fn one_way(
    fields: &Fields,
    a: &FieldShape,
    body_a: &Body,
    b: &FieldShape,
    body_b: &Body,
    gap: f32,
    limit: f32,
) -> (f32, u32) {
    let back = Vec2::new(body_b.turn.x, -body_b.turn.y);
    let turn = back.rotate(body_a.turn);
    let shift = back.rotate(body_a.at - body_b.at);
    let (mut sum, mut work) = (0.0, 4);
    for group in fields.groups_of(a) {
        work += 1;
        if fields.distance_at_least(b, turn.rotate(group.centre) + shift) >= gap + group.radius {
            continue;
        }
        for run in &fields.runs[group.first as usize..][..group.count as usize] {
            work += 1;
            if fields.distance_at_least(b, turn.rotate(run.centre) + shift) >= gap + run.radius {
                continue;
            }
            let points = &fields.points[run.first as usize..][..run.count as usize];
            sum += fields.depth(b, points, turn, shift, gap);
            work += run.count;
        }
        if sum > limit {
            break;
        }
    }
    (sum, work)
}
