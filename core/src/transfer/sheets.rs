//! Which chart of the atlas each face belongs to, and a face of the atlas on the right side of every slit to start from.
//!
//! A connected region between the new cuts is the chart that most of its area is closest to. Where neighbouring faces of a region are
//! closest to places that hang together on the atlas, they trust each other; the largest trusting set of a region is right,
//! and from it the others find theirs by walking, face by face, over an atlas whose borders cannot be crossed. So both sides of a slit
//! stay apart though they are the same place in space. Cost: O(f log f).

use super::closest::Closest;
use super::source::{SourceAtlas, Walking};
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::base::union_find::UnionFind;
use crate::base::workers::{Workers, for_each_chunk};
use crate::charts::surface::Surface;
use crate::mesh::view::{MeshView, NONE};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Faces that one task asks for.
const CHUNK: usize = 256;
/// Least cosine of two normals that are the same side of a surface.
const SAME_SIDE: f64 = 0.2;
/// Distance, over the extent of the source, up to which a face that looks the same way is preferred to a closer one that does not.
const FAR: f64 = 0.05;
/// Rings of faces along the new cuts that are not trusted.
const RINGS: u32 = 2;

/// The closest place of the source to the middle of a face.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct NearestFace {
    /// Face of the source.
    pub face: u32,
    spare: u32,
    /// Squared distance.
    pub squared: f64,
}

/// Finds the closest place of the source to the middle of every face, on a side that looks the same way.
pub fn find_hits(hits: &mut [NearestFace], mesh: MeshView, source: &SourceAtlas, workers: &dyn Workers) {
    for_each_chunk(workers, hits, CHUNK, &|chunk, hits| {
        for (f, hit) in (chunk * CHUNK..).zip(hits) {
            let (p, normal) = (middle(mesh, f), mesh.area_vector(f));
            let looks_so = |g: u32| {
                let other = source.surface.mesh.area_vector(g as usize);
                let cosine = normal.dot(other);
                let sizes = normal.dot(normal) * other.dot(other);
                sizes <= 0.0 || cosine > 0.0 && cosine * cosine >= SAME_SIDE * SAME_SIDE * sizes
            };
            let found = source.tree.find_within(p, FAR * FAR, looks_so).or_else(|| source.tree.find(p, |_| true));
            if let Some(Closest { face, squared, .. }) = found {
                *hit = NearestFace { face, spare: 0, squared };
            }
        }
    });
}

/// Middle of a face.
pub fn middle(mesh: MeshView, f: usize) -> DVec3 {
    mesh.faces[f].iter().map(|v| mesh.positions[*v as usize]).sum::<DVec3>() / 3.0
}

/// Area of a face.
pub fn area(mesh: MeshView, f: usize) -> f64 {
    let normal = mesh.area_vector(f);
    0.5 * sqrt(normal.dot(normal))
}

/// Writes to `best` (one entry a key) the label that has the most area among the faces of each key; labels and keys are below
/// the number of faces of their meshes.
pub fn majority(
    best: &mut [u32],
    mesh: MeshView,
    key: impl Fn(usize) -> u32,
    label: impl Fn(usize) -> u32,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let faces = mesh.faces.len();
    let order = scratch.take::<u32>(faces)?;
    order.iter_mut().enumerate().for_each(|(i, f)| *f = i as u32);
    sort::by_key(order, |f| (key(*f as usize), label(*f as usize), *f));
    let most = scratch.take_filled::<f64>(best.len(), -1.0)?;
    let mut at = 0;
    while at < faces {
        let (k, l) = (key(order[at] as usize), label(order[at] as usize));
        let run = order[at..].iter().take_while(|f| (key(**f as usize), label(**f as usize)) == (k, l));
        let (count, sum) = run.fold((0, 0.0), |(n, sum), f| (n + 1, sum + area(mesh, *f as usize)));
        if sum > most[k as usize] {
            (most[k as usize], best[k as usize]) = (sum, l);
        }
        at += count;
    }
    Ok(())
}

/// The charts of the mesh.
pub struct Sheets<'a> {
    /// Region of each face between the cuts.
    pub region: &'a [u32], // (f)
    /// Chart of the source that each region is.
    pub chart: &'a [u32], // (regions)
    /// Face of the source, of that chart, near each face.
    pub anchor: &'a [u32], // (f)
}

/// Bytes that [`Sheets::new`] takes.
pub const fn sheets_need(faces: usize) -> usize {
    bytes_for::<u32>(faces).saturating_mul(8).saturating_add(bytes_for::<f64>(faces).saturating_mul(2))
}

impl<'a> Sheets<'a> {
    /// The charts that `cut` leaves of a mesh in the frame of the source.
    pub fn new(
        surface: &Surface,
        cut: &[u8],
        hits: &[NearestFace],
        source: &SourceAtlas,
        walking: &mut Walking,
        keep: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let faces = hits.len();
        let region = keep.take::<u32>(faces)?;
        let anchor = keep.take_filled::<u32>(faces, NONE)?;
        let regions = surface.charts(cut, region, keep.frame().take(faces)?);
        let chart = keep.take::<u32>(regions)?;
        let hit_chart = |f: usize| source.chart[hits[f].face as usize];
        majority(chart, surface.mesh, |f| region[f], hit_chart, keep.frame())?;
        let mut frame = keep.frame();
        let queue = frame.take::<u32>(faces)?;
        trust(
            anchor,
            queue,
            surface,
            cut,
            hits,
            &|f| hit_chart(f) == chart[region[f] as usize],
            region,
            source,
            walking,
            frame.frame(),
        )?;
        // A region without a face that is closest to its chart starts from the closest place of the chart.
        let has_start = frame.take::<u8>(regions)?;
        (0..faces).filter(|f| anchor[*f] != NONE).for_each(|f| has_start[region[f] as usize] = 1);
        for f in 0..faces {
            let r = region[f] as usize;
            if has_start[r] == 0 {
                let found = source.tree.find(middle(surface.mesh, f), |g| source.chart[g as usize] == chart[r]);
                anchor[f] = found.map_or(hits[f].face, |at| at.face);
                has_start[r] = 1;
            }
        }
        spread(anchor, queue, surface, cut, source, walking);
        Ok(Self { region, chart, anchor })
    }
}

/// Sets the anchors of the faces that are right.
#[allow(clippy::too_many_arguments)]
fn trust(
    anchor: &mut [u32],
    queue: &mut [u32],
    surface: &Surface,
    cut: &[u8],
    hits: &[NearestFace],
    fits: &dyn Fn(usize) -> bool,
    region: &[u32],
    source: &SourceAtlas,
    walking: &mut Walking,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let faces = hits.len();
    let depth = scratch.take::<u32>(faces)?;
    depths(depth, queue, surface, cut, scratch.frame())?;
    // Of each region the deepest ring that has a face which fits, up to RINGS.
    let deepest = scratch.take::<u32>(faces)?;
    for f in (0..faces).filter(|f| fits(*f)) {
        let own = &mut deepest[region[f] as usize];
        *own = (*own).max(depth[f].min(RINGS) + 1);
    }
    let is_candidate = |f: usize| fits(f) && depth[f].min(RINGS) + 1 >= deepest[region[f] as usize];
    let mut sets = UnionFind::new(scratch.take(faces)?);
    for f in (0..faces).filter(|f| is_candidate(*f)) {
        for t in (3 * f as u32..3 * f as u32 + 3).filter_map(|c| surface.across(cut, c)).map(|t| t / 3) {
            let is_new = (t as usize) > f && is_candidate(t as usize) && sets.find(t) != sets.find(f as u32);
            if is_new && trusts(f, t as usize, surface.mesh, hits, source, walking) {
                sets.union(f as u32, t);
            }
        }
    }
    let weight = scratch.take::<f64>(faces)?; // of each set, at its root
    for f in (0..faces).filter(|f| is_candidate(*f)) {
        weight[sets.find(f as u32) as usize] += area(surface.mesh, f);
    }
    let best = scratch.take_filled::<u32>(faces, NONE)?; // root of each region's heaviest set
    for f in (0..faces).filter(|f| is_candidate(*f)) {
        let (root, own) = (sets.find(f as u32), &mut best[region[f] as usize]);
        if *own == NONE || weight[root as usize] > weight[*own as usize] {
            *own = root;
        }
    }
    for f in (0..faces).filter(|f| is_candidate(*f)) {
        if sets.find(f as u32) == best[region[f] as usize] {
            anchor[f] = hits[f].face;
        }
    }
    Ok(())
}

/// Whether from the place that face `f` is closest to a walk reaches one as near to face `t` as what that is closest to.
pub fn trusts(
    f: usize,
    t: usize,
    mesh: MeshView,
    hits: &[NearestFace],
    source: &SourceAtlas,
    walking: &mut Walking,
) -> bool {
    is_as_near(source.walk(hits[f].face, middle(mesh, t), walking).squared, hits[t].squared)
}

/// Whether a squared distance is another or less, but for rounding.
pub fn is_as_near(squared: f64, other: f64) -> bool {
    squared <= other * 1.0001 + 1e-14
}

/// Rings of faces between each face and the nearest cut.
fn depths(
    depth: &mut [u32],
    queue: &mut [u32],
    surface: &Surface,
    cut: &[u8],
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let on_cut = scratch.take::<u8>(surface.mesh.positions.len())?;
    for c in (0..cut.len() as u32).filter(|c| cut[*c as usize] != 0) {
        on_cut[surface.mesh.vertex(c) as usize] = 1;
    }
    depth.fill(NONE);
    let (mut head, mut tail) = (0, 0);
    for (f, depth) in depth.iter_mut().enumerate() {
        if surface.mesh.faces[f].iter().any(|v| on_cut[*v as usize] != 0) {
            (*depth, queue[tail]) = (0, f as u32);
            tail += 1;
        }
    }
    while head < tail {
        let f = queue[head];
        head += 1;
        for t in (3 * f..3 * f + 3).filter_map(|c| surface.across(cut, c)) {
            if depth[(t / 3) as usize] == NONE {
                depth[(t / 3) as usize] = depth[f as usize] + 1;
                queue[tail] = t / 3;
                tail += 1;
            }
        }
    }
    Ok(())
}

/// From the faces that have an anchor to all others of their regions.
fn spread(
    anchor: &mut [u32],
    queue: &mut [u32],
    surface: &Surface,
    cut: &[u8],
    source: &SourceAtlas,
    walking: &mut Walking,
) {
    let (mut head, mut tail) = (0, 0);
    for f in (0..anchor.len()).filter(|f| anchor[*f] != NONE) {
        queue[tail] = f as u32;
        tail += 1;
    }
    while head < tail {
        let f = queue[head];
        head += 1;
        for t in (3 * f..3 * f + 3).filter_map(|c| surface.across(cut, c)).map(|t| t / 3) {
            if anchor[t as usize] == NONE {
                anchor[t as usize] = source.walk(anchor[f as usize], middle(surface.mesh, t as usize), walking).face;
                queue[tail] = t;
                tail += 1;
            }
        }
    }
}
