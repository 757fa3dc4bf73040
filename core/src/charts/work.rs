//! Charts as pieces of their own: taken out, worked on side by side, put back.
//!
//! A chart's nodes are its wedges, inner ones first, so that the first flattening holds a tail of the list and the
//! relaxation frees all of it. Charts share nothing, so they are worked on in parallel and each gives the same bits
//! alone.

use super::list::ChartList;
use super::quads::quads_of;
use super::strip::lay;
use super::surface::Surface;
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::workers::{Workers, for_each_chunk};
use crate::mesh::view::{NONE, next};
use crate::solve::energy::Rest;
use crate::solve::flatten::{tutte, unfold, weld};
use crate::solve::levels::{LEVELS_FROM, flatten_by_levels};
use crate::solve::piece::{Piece, Stop};
use crate::solve::quad::Quad;
use crate::solve::quads::{quads_need, relax_quads};
use crate::solve::relax::{Relaxation, relax, relax_need};
use glam::{DVec2, DVec3};

/// Charts that are worked on at the same time.
const LANES: usize = 8;
/// Of larger meshes charts with up to a quarter of all faces are worked on at the same time, since each holds its memory to
/// the end.
const AT_ONCE: usize = 20_000;

/// Newton steps of a flattening between walls, which hold each step back: far from rest, cuts would follow distortion that is not there.
const WALLED_STOP: Stop = Stop { steps: 200, tolerance: 1e-3 };

/// What to do with a chart.
#[derive(Clone, Copy)]
pub enum Work {
    /// Flatten anew, then relax.
    Flatten(Stop),
    /// Relax from where it is.
    Relax(Stop),
    /// Lay down as near as can be to how each face lies, where faces that hang together may lie apart; then relax, unless that
    /// turns a face over.
    Weld(Stop),
    /// Lay on a rectangle a chart whose border turns at four corners; others stay.
    Rectangle(Stop),
}

/// One chart on its own.
struct ChartJob<'j> {
    faces: &'j [u32],
    triangles: &'j mut [[u32; 3]],
    rest: &'j mut [Rest],
    x: &'j mut [DVec2],
    at: &'j mut [DVec3],
    inner: usize,
    border: &'j [[u32; 2]],  // border edges from node to node, in order
    walls: &'j [[u32; 2]],   // those that are kept apart: all or none
    beside: &'j [[u32; 3]],  // neighbours of each triangle, where there are no inner nodes
    sides: &'j [[DVec2; 3]], // how each triangle lies, where its neighbours may lie apart
    quads: &'j [Quad],       // those that are convex in space
    scratch: Option<Scratch<'j>>,
    result: Result<Relaxation, ScratchTooSmall>,
}

/// Does `work` on each chart for which `wanted` answers true; `uv` stands at corners. Returns whether every such chart
/// is free of flips.
#[allow(clippy::too_many_arguments)]
pub fn work_on(
    uv: &mut [DVec2],
    surface: &Surface,
    cut: &[u8],
    charts: &ChartList,
    wanted: impl Fn(usize) -> bool,
    work: Work,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<bool, ScratchTooSmall> {
    let corners = surface.mesh.corner_count();
    let node = scratch.take::<u32>(corners)?;
    let count = surface.wedges(cut, node);
    let local = scratch.take::<u32>(count)?; // place of a node in its chart
    let on_border = scratch.take::<u8>(count)?;
    for c in 0..corners as u32 {
        if surface.is_open(cut, c) {
            on_border[node[c as usize] as usize] = 1;
            on_border[node[next(c) as usize] as usize] = 1;
        }
    }
    let most = AT_ONCE.max(surface.mesh.faces.len() / 4);
    let mut sound = true;
    let mut k = 0;
    while k < charts.count() {
        let mut short = heapless::Vec::<usize, LANES>::new();
        {
            let mut wave = scratch.frame();
            let mut jobs = heapless::Vec::<ChartJob, LANES>::new();
            let mut members = heapless::Vec::<usize, LANES>::new();
            let mut taken = 0;
            while k < charts.count() && !jobs.is_full() {
                if wanted(k) {
                    let faces = charts.faces_of(k);
                    let need = job_need(faces.len());
                    taken += faces.len();
                    if (wave.remaining() < need || taken > most) && !jobs.is_empty() {
                        break;
                    }
                    let bytes = need.min(wave.remaining());
                    let mut part = wave.split(bytes)?;
                    let mut job = take_out(faces, node, local, on_border, uv, surface, cut, work, &mut part)?;
                    job.scratch = Some(part);
                    jobs.put(job);
                    members.put(k);
                }
                k += 1;
            }
            for_each_chunk(workers, &mut jobs, 1, &|_, job| job[0].run(work, workers));
            for (job, k) in jobs.iter().zip(&members) {
                match job.put_back(uv) {
                    Ok(flawless) => sound &= flawless,
                    Err(_) => short.put(*k),
                }
            }
        }
        // What a chart needs is an estimate that nodes of many neighbours can break: those have all memory to themselves.
        for k in short {
            let mut part = scratch.frame();
            let mut job = take_out(charts.faces_of(k), node, local, on_border, uv, surface, cut, work, &mut part)?;
            job.scratch = Some(part);
            job.run(work, workers);
            sound &= job.put_back(uv)?;
        }
    }
    Ok(sound)
}

/// Bytes for a chart of `faces` triangles as they occur.
pub fn job_need(faces: usize) -> usize {
    // A disk of t triangles has at most t + 2 nodes.
    let nodes = faces + 2;
    bytes_for::<[u32; 3]>(faces)
        + bytes_for::<Rest>(faces)
        + bytes_for::<DVec2>(nodes)
        + bytes_for::<DVec3>(nodes)
        + bytes_for::<[u32; 3]>(faces)
        + bytes_for::<[u32; 2]>(nodes)
        + bytes_for::<[DVec2; 3]>(faces)
        + bytes_for::<Quad>(faces / 2)
        + quads_need(faces)
        + relax_need(nodes, 2 * faces, 3 * faces)
}

#[allow(clippy::too_many_arguments)]
fn take_out<'j>(
    faces: &'j [u32],
    node: &[u32],
    local: &mut [u32],
    on_border: &[u8],
    uv: &[DVec2],
    surface: &Surface,
    cut: &[u8],
    work: Work,
    scratch: &mut Scratch<'j>,
) -> Result<ChartJob<'j>, ScratchTooSmall> {
    let corners = || faces.iter().flat_map(|f| 3 * f..3 * f + 3);
    let mut count = 0;
    let mut inner = 0;
    corners().for_each(|c| local[node[c as usize] as usize] = NONE);
    for border in [0, 1] {
        for c in corners() {
            let n = node[c as usize] as usize;
            if local[n] == NONE && on_border[n] == border {
                local[n] = count;
                count += 1;
            }
        }
        if border == 0 {
            inner = count as usize;
        }
    }
    let triangles = scratch.take::<[u32; 3]>(faces.len())?;
    let rest = scratch.take::<Rest>(faces.len())?;
    let x = scratch.take::<DVec2>(count as usize)?;
    let at = scratch.take::<DVec3>(count as usize)?;
    for (k, f) in faces.iter().enumerate() {
        rest[k] = surface.rest[*f as usize];
        for (i, corner) in triangles[k].iter_mut().enumerate() {
            let c = 3 * *f as usize + i;
            let n = local[node[c] as usize];
            *corner = n;
            x[n as usize] = uv[c];
            at[n as usize] = surface.mesh.position(c as u32);
        }
    }
    let border = scratch.take::<[u32; 2]>(count as usize - inner)?;
    let mut sides = 0;
    if let Some(first) = corners().find(|c| surface.is_open(cut, *c)) {
        for (edge, c) in border.iter_mut().zip(surface.border(cut, first)) {
            *edge = [c, next(c)].map(|c| local[node[c as usize] as usize]);
            sides += 1;
        }
    }
    let border = &border[..sides];
    let walls = if surface.stays_whole { border } else { &[] };
    let beside = scratch.take_filled::<[u32; 3]>(if inner == 0 { faces.len() } else { 0 }, [NONE; 3])?;
    for (b, f) in beside.iter_mut().zip(faces) {
        for i in 0..3 {
            if let Some(t) = surface.across(cut, 3 * f + i) {
                b[i as usize] = local_face(faces, t / 3);
            }
        }
    }
    let sides = scratch.take::<[DVec2; 3]>(if matches!(work, Work::Weld(_)) { faces.len() } else { 0 })?;
    for (s, f) in sides.iter_mut().zip(faces) {
        *s = [0, 1, 2].map(|i| uv[3 * *f as usize + i]);
    }
    let quads = quads_of(faces, triangles, surface, cut, scratch)?;
    Ok(ChartJob {
        faces,
        triangles,
        rest,
        x,
        at,
        inner,
        border,
        walls,
        beside,
        sides,
        quads,
        scratch: None,
        result: Ok(Relaxation::default()),
    })
}

/// Place of a face in the ascending list of its chart's faces.
fn local_face(faces: &[u32], face: u32) -> u32 {
    faces.partition_point(|f| *f < face) as u32
}

impl ChartJob<'_> {
    fn run(&mut self, work: Work, workers: &dyn Workers) {
        let Some(scratch) = self.scratch.take() else { return };
        self.result = self.done(work, scratch, workers);
    }

    /// Writes the chart's UVs; whether they are free of flips.
    fn put_back(&self, uv: &mut [DVec2]) -> Result<bool, ScratchTooSmall> {
        let done = self.result?;
        for (f, t) in self.faces.iter().zip(self.triangles.iter()) {
            for i in 0..3 {
                uv[3 * *f as usize + i] = self.x[t[i] as usize];
            }
        }
        Ok(done.after.is_finite())
    }

    fn done(&mut self, work: Work, mut scratch: Scratch, workers: &dyn Workers) -> Result<Relaxation, ScratchTooSmall> {
        let Self { triangles, rest, at, walls, quads, .. } = self;
        let piece = Piece { triangles, rest, free: self.x.len(), at, springs: &[], walls };
        match work {
            Work::Relax(stop) => relax_quads(self.x, &piece, quads, stop, scratch, workers),
            Work::Rectangle(stop) => {
                lay(self.x, &piece, self.inner, self.border, stop, scratch.frame(), workers)?;
                relax(self.x, &piece, Stop { steps: 0, tolerance: 0.0 }, scratch, workers)
            }
            Work::Weld(stop) => {
                weld(self.x, &piece, self.sides, scratch.frame(), workers)?;
                relax_quads(self.x, &piece, quads, stop, scratch, workers)
            }
            Work::Flatten(_) if self.inner == 0 => {
                unfold(self.x, &piece, self.beside, scratch.frame())?;
                relax(self.x, &piece, Stop { steps: 0, tolerance: 0.0 }, scratch, workers)
            }
            Work::Flatten(stop)
                if triangles.len() > LEVELS_FROM
                    && walls.is_empty()
                    && flatten_by_levels(self.x, &piece, self.inner, scratch.frame(), workers)? =>
            {
                relax_quads(self.x, &piece, quads, stop, scratch, workers)
            }
            Work::Flatten(stop) => {
                let stop = if walls.is_empty() { stop } else { WALLED_STOP };
                tutte(self.x, &piece, self.inner, self.border, scratch.frame(), workers)?;
                relax_quads(self.x, &piece, quads, stop, scratch, workers)
            }
        }
    }
}
