//! The exact check: how close do different charts come?
//!
//! Every pair of border segments of different charts that could be closer than the bound is measured; a chart inside
//! another's faces is found by its winding number. Boxes of charts, then of runs of 16 segments, leave few pairs.
//! Distances are rounded as f64 are: 1e-15 of the square.

use super::outline::{self, BorderEdge, Outlines};
use super::placement::Pose;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::plane::segment::segments_apart;
use glam::DVec2;

/// Segments under one box.
const RUN: usize = 16;

type Extent = [DVec2; 2];

/// Bytes that [`check`] takes.
pub(super) fn need(edge_count: usize, chart_count: usize) -> usize {
    bytes_for::<BorderEdge>(edge_count)
        + bytes_for::<Extent>(edge_count / RUN + chart_count + 1)
        + bytes_for::<u32>(chart_count + 1)
        + bytes_for::<Extent>(chart_count)
        + bytes_for::<u32>(chart_count)
}

/// Calls `report` with every two charts that are closer than `bound`, and their distance: 0 where they overlap.
/// True if there are none.
pub(super) fn check(
    poses: &[Pose],
    outlines: &Outlines,
    bound: f64,
    scratch: &mut Scratch,
    report: &mut dyn FnMut(usize, usize, f64),
) -> Result<bool, ScratchTooSmall> {
    let count = poses.len();
    let mut frame = scratch.frame();
    let edges = frame.take::<BorderEdge>(outlines.edges.len())?;
    let runs = frame.take::<Extent>(edges.len() / RUN + count + 1)?;
    let run_start = frame.take::<u32>(count + 1)?;
    let boxes = frame.take::<Extent>(count)?;
    let order = frame.take::<u32>(count)?;
    place(edges, runs, run_start, boxes, poses, outlines);
    order.iter_mut().enumerate().for_each(|(i, o)| *o = i as u32);
    sort::by(order, |&a, &b| boxes[a as usize][0].x.total_cmp(&boxes[b as usize][0].x).then(a.cmp(&b)));
    let placed = Placed { outlines, edges, runs, run_start };

    let mut clear = true;
    for (rank, &a) in order.iter().enumerate() {
        for &b in &order[rank + 1..] {
            let (box_a, box_b) = (boxes[a as usize], boxes[b as usize]);
            if box_b[0].x > box_a[1].x + bound {
                break;
            }
            // Boxes of charts without faces are infinitely far from everything.
            if apart(box_a, box_b) < bound {
                let distance = placed.distance(a as usize, b as usize, bound);
                if distance < bound {
                    clear = false;
                    report(a.min(b) as usize, a.max(b) as usize, distance);
                }
            }
        }
    }
    Ok(clear)
}

/// Moves borders to their poses and boxes them.
fn place(
    edges: &mut [BorderEdge],
    runs: &mut [Extent],
    run_start: &mut [u32],
    boxes: &mut [Extent],
    poses: &[Pose],
    outlines: &Outlines,
) {
    let mut count = 0;
    for (chart, pose) in poses.iter().enumerate() {
        run_start[chart] = count as u32;
        let turn = outline::turn(pose.angle);
        let first = outlines.edge_start[chart] as usize;
        boxes[chart] = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        for (i, edge) in outlines.edges_of(chart).iter().enumerate() {
            let moved = edge.map(|p| turn.rotate(p) + pose.at);
            edges[first + i] = moved;
            if i % RUN == 0 {
                runs[count] = [moved[0], moved[0]];
                count += 1;
            }
            for p in moved {
                runs[count - 1] = [runs[count - 1][0].min(p), runs[count - 1][1].max(p)];
                boxes[chart] = [boxes[chart][0].min(p), boxes[chart][1].max(p)];
            }
        }
    }
    run_start[poses.len()] = count as u32;
}

/// Distance of two boxes.
fn apart(a: Extent, b: Extent) -> f64 {
    (a[0] - b[1]).max(b[0] - a[1]).max(DVec2::ZERO).length()
}

struct Placed<'a> {
    outlines: &'a Outlines<'a>,
    edges: &'a [BorderEdge],
    runs: &'a [Extent],
    run_start: &'a [u32],
}

impl Placed<'_> {
    /// Distance of two charts if below `bound`, else `bound` or more.
    fn distance(&self, a: usize, b: usize, bound: f64) -> f64 {
        if self.inside(a, b) || self.inside(b, a) {
            return 0.0;
        }
        let mut least = bound;
        for run_a in self.run_start[a] as usize..self.run_start[a + 1] as usize {
            for run_b in self.run_start[b] as usize..self.run_start[b + 1] as usize {
                if apart(self.runs[run_a], self.runs[run_b]) >= least {
                    continue;
                }
                for &p in self.run(a, run_a) {
                    for &q in self.run(b, run_b) {
                        least = least.min(segments_apart(p, q));
                    }
                }
            }
        }
        least
    }

    fn border(&self, chart: usize) -> &[BorderEdge] {
        &self.edges[self.outlines.edge_start[chart] as usize..self.outlines.edge_start[chart + 1] as usize]
    }

    fn run(&self, chart: usize, run: usize) -> &[BorderEdge] {
        let border = self.border(chart);
        let first = (run - self.run_start[chart] as usize) * RUN;
        &border[first..(first + RUN).min(border.len())]
    }

    /// Does the start of any loop of `a` lie in `b`'s faces?
    fn inside(&self, a: usize, b: usize) -> bool {
        let border = self.border(a);
        (0..border.len()).any(|i| (i == 0 || border[i][0] != border[i - 1][1]) && self.covers(b, border[i][0]))
    }

    /// Winding number not 0; runs that the horizontal line through `p` misses are skipped.
    fn covers(&self, chart: usize, p: DVec2) -> bool {
        let mut winding = 0;
        for run in self.run_start[chart] as usize..self.run_start[chart + 1] as usize {
            let bounds = self.runs[run];
            if bounds[1].y < p.y || bounds[0].y > p.y || bounds[1].x < p.x {
                continue;
            }
            for [q, r] in self.run(chart, run) {
                if (q.y <= p.y) != (r.y <= p.y) {
                    let side = (*r - *q).perp_dot(p - *q);
                    if q.y <= p.y && side > 0.0 {
                        winding += 1;
                    } else if q.y > p.y && side < 0.0 {
                        winding -= 1;
                    }
                }
            }
        }
        winding != 0
    }
}
