//! Cuts found on decimated meshes and carried over.
//!
//! A search on a few thousand faces takes a tenth of a second whatever the mesh, and its outcome goes by chance: seeds move the cost of
//! one mesh by a tenth, the mean by 2 %. So two searches run side by side, on a coarse mesh and on one decimated further, and the better is
//! kept by what its cuts cost and how full its charts are expected to pack.
//! Creases are lines that the coarse meshes keep, since cuts follow them.
//! Cost: O(n log n) for the decimation and what is carried over.

use super::budget::{Budget, Draws};
use super::direct::{Trials, direct_need};
use super::draws::{draw, draws_need, search_best};
use crate::base::pace::{Marks, NoMarks, StageError};
use crate::base::random::hash;
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::{Workers, for_each_chunk};
use crate::carry::detour::go_round;
use crate::carry::proxy::{proxy_costs, proxy_costs_need};
use crate::carry::slide::Slides;
use crate::carry::transfer::{transfer, transfer_need};
use crate::charts::surface::Surface;
use crate::first::disks::disks_again;
use crate::mesh::collapse::Collapse;
use crate::mesh::decimate::{decimate, decimate_need};
use crate::mesh::topology::twins;
use crate::mesh::view::MeshView;
use crate::price::turn::turns;
use crate::solve::energy::{MOLLIFY, Rest, even_out};
use glam::{DVec2, DVec3};

/// Faces of the coarse meshes, the finer first.
const PROXY_FACES: [usize; PROXIES] = [3000, 2200];
/// Rounds over its faces that a search is counted as.
const SEARCH_ROUNDS: usize = 64;
/// Coarse meshes.
const PROXIES: usize = 2;
/// Pieces of more faces are cut by way of them.
pub const PROXY_FROM: usize = 4500;
/// How far paths may slide while they are carried over.
const SLIDES: Slides = Slides { reach: 2.0, rounds: 3 };
/// An edge that turns by more degrees is a crease.
const CREASE: f64 = 35.0;
/// Where more than this share of all edges are creases they say nothing, and would stop the decimation.
const MOST_CREASES: f64 = 0.5;
/// What the coarse meshes may be distorted over what the mesh may: the same cuts distort a fine mesh less.
const SLACK: f64 = 1.2;
/// A coarse mesh has at most twice the faces that are wanted, or one of so many of the mesh's: handles and holes keep a scan's from
/// being reached.
const SHARE: usize = 64;
/// A coarse mesh that creases hold above its target by more than one part in so many is decimated without them.
const MORE: usize = 5;

/// Faces of a coarse mesh of one of so many `faces` at the most.
fn most_of(faces: usize) -> usize {
    (2 * PROXY_FACES[0]).max(faces / SHARE)
}

/// Scratch bytes that [`cut_by_proxies`] asks for.
pub fn proxies_need(faces: usize, vertices: usize) -> usize {
    let coarse = most_of(faces);
    let kept = 2 * bytes_for::<Collapse>(vertices) + 2 * 800 * coarse;
    let flags = bytes_for::<u8>(3 * faces) + bytes_for::<f64>(3 * faces);
    let full = bytes_for::<[u32; 3]>(faces) + bytes_for::<u32>(vertices) + decimate_need(vertices, faces) + flags;
    let search = 2 * (direct_need(coarse, coarse, Trials::All) + draws_need(coarse));
    let carry = transfer_need(vertices, faces).max(proxy_costs_need(vertices, coarse));
    kept + full.max(search).max(carry)
}

/// A coarse mesh with the cuts that were found on it.
struct Proxy<'p> {
    surface: Surface<'p>,
    history: &'p [Collapse],
    uv: &'p mut [DVec2],
    cut: &'p mut [u8],
}

impl<'p> Proxy<'p> {
    /// Decimates `fine` to `target` faces; nothing where it ends with more than `most`.
    fn new(
        fine: &Surface,
        target: usize,
        most: usize,
        keep: &mut Scratch<'p>,
    ) -> Result<Option<Self>, ScratchTooSmall> {
        let (n, count) = (fine.mesh.positions.len(), fine.mesh.faces.len());
        let history = keep.take::<Collapse>(n)?;
        // The coarse mesh is copied out of full-size memory, which is then free again.
        let faces = keep.take::<[u32; 3]>(most)?;
        let vertex = keep.take::<u32>(most)?;
        let done = {
            let mut frame = keep.frame();
            let hard = frame.take::<u8>(3 * count)?;
            mark_creases(hard, fine, frame.frame())?;
            let (full_faces, full_vertex) = (frame.take::<[u32; 3]>(count)?, frame.take::<u32>(n)?);
            let mut to = |hard: &[u8]| {
                decimate(full_faces, full_vertex, history, fine.mesh, fine.twin, hard, target, frame.frame())
            };
            let mut done = to(hard)?;
            if done.faces > target + target / MORE {
                // The creases of a scan are many and say little.
                hard.fill(0);
                done = to(hard)?;
            }
            if done.faces > most || done.vertices > most {
                return Ok(None);
            }
            faces[..done.faces].copy_from(&full_faces[..done.faces]);
            vertex[..done.vertices].copy_from(&full_vertex[..done.vertices]);
            done
        };
        let (faces, vertex) = (&faces[..done.faces], &vertex[..done.vertices]);
        let positions = keep.take::<DVec3>(vertex.len())?;
        positions.iter_mut().zip(vertex).for_each(|(p, v)| *p = fine.mesh.positions[*v as usize]);
        let mesh = MeshView { positions, faces };
        let twin = keep.take::<u32>(mesh.corner_count())?;
        twins(twin, mesh, keep.frame())?;
        let cost = keep.take::<f64>(mesh.corner_count())?;
        proxy_costs(cost, mesh, twin, vertex, fine, keep.frame())?;
        let rest = keep.take::<Rest>(faces.len())?;
        for (r, f) in rest.iter_mut().zip(faces) {
            *r = Rest::new(f.map(|v| mesh.positions[v as usize]), MOLLIFY);
        }
        even_out(rest);
        let surface = Surface::new(mesh, twin, rest, cost, keep)?;
        let uv = keep.take::<DVec2>(mesh.corner_count())?;
        let cut = keep.take::<u8>(mesh.corner_count())?;
        Ok(Some(Self { surface, history: &history[..done.collapses], uv, cut }))
    }
}

/// Flags the half-edges that turn sharply, unless most do.
fn mark_creases(hard: &mut [u8], surface: &Surface, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let turn = scratch.take::<f64>(hard.len())?;
    turns(turn, surface.mesh, surface.twin, 0.0);
    hard.iter_mut().zip(turn.iter()).for_each(|(h, t)| *h = u8::from(*t > CREASE));
    let creases = hard.iter().filter(|h| **h != 0).count();
    if creases as f64 > MOST_CREASES * hard.len() as f64 {
        hard.fill(0);
    }
    Ok(())
}

/// One search at work.
struct ProxyJob<'j, 'p> {
    proxy: &'j mut Proxy<'p>,
    scratch: Option<Scratch<'j>>,
    budget: Budget,
    price: Result<[f64; 2], StageError>,
}

/// Searches on all meshes side by side: at the true costs, or the draw of that number. `prices` are those of what stands.
fn search_all(
    proxies: &mut [Proxy],
    prices: &mut [[f64; 2]],
    budget: Budget,
    number: Option<u32>,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), StageError> {
    let mut jobs = heapless::Vec::<ProxyJob, PROXIES>::new();
    let count = proxies.len();
    for (i, (proxy, price)) in proxies.iter_mut().zip(prices.iter()).enumerate() {
        let part = scratch.split(scratch.remaining() / (count - i))?;
        let draws = Draws { count: 0, seed: hash(budget.draws.seed, 0xa1, i as u64) };
        jobs.put(ProxyJob {
            proxy,
            scratch: Some(part),
            budget: Budget { draws, ends_early: false, ..budget },
            price: Ok(*price),
        });
    }
    for_each_chunk(workers, &mut jobs, 1, &|_, job| {
        let ProxyJob { proxy: Proxy { surface, uv, cut, .. }, scratch, budget, price } = &mut job[0];
        if let (Some(scratch), Ok(best)) = (scratch.take(), *price) {
            *price = match number {
                None => search_best(uv, cut, surface, *budget, scratch, workers, &mut NoMarks),
                Some(number) => draw(uv, cut, surface, *budget, number, best, scratch, workers, &mut NoMarks),
            };
        }
    });
    for (price, job) in prices.iter_mut().zip(jobs) {
        *price = job.price?;
    }
    Ok(())
}

/// Writes the cuts of the better of two searches on coarse meshes; false where there are none, or where to carry them over would cut
/// a diagonal or change the charts, so that the search has to begin on the mesh itself.
pub fn cut_by_proxies(
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<bool, StageError> {
    marks.mark(surface.mesh.faces.len())?;
    let most = most_of(surface.mesh.faces.len());
    let Some(one) = Proxy::new(surface, PROXY_FACES[0], most, &mut scratch)? else { return Ok(false) };
    let other = Proxy::new(&one.surface, PROXY_FACES[1], 2 * PROXY_FACES[1], &mut scratch)?;
    let mut proxies = heapless::Vec::<Proxy, PROXIES>::new();
    proxies.put(one);
    other.into_iter().for_each(|other| proxies.put(other));
    let budget = Budget { distortion: 1.0 + SLACK * (budget.distortion - 1.0), ..budget };
    let mut prices = [[f64::INFINITY; 2]; PROXIES];
    let rounds = if proxies.is_full() { budget.draws.count.div_ceil(PROXIES as u32) } else { budget.draws.count };
    for number in core::iter::once(None).chain((0..rounds).map(Some)) {
        search_all(&mut proxies, &mut prices, budget, number, scratch.frame(), workers)?;
        marks.mark(proxies.iter().map(|p| SEARCH_ROUNDS * p.surface.mesh.faces.len()).sum())?;
    }
    let Some((one, others)) = proxies.split_first() else { return Ok(false) };
    let between = scratch.take::<u8>(one.cut.len())?;
    let mut coarse_cut = &*one.cut;
    if let Some(other) = others.first()
        && prices[1] < prices[0]
        && transfer(between, &one.surface, &other.surface, other.cut, other.history, SLIDES, scratch.frame())?
            .is_faithful()
    {
        coarse_cut = between;
    }
    let carried = transfer(cut, surface, &one.surface, coarse_cut, one.history, SLIDES, scratch.frame())?;
    if !carried.is_faithful() {
        return Ok(false);
    }
    if carried.forbidden > 0 {
        if !go_round(cut, surface) {
            return Ok(false);
        }
        disks_again(cut, surface, scratch)?;
    }
    Ok(true)
}
