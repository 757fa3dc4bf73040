//! Charts that lie on others on purpose: every face of the one has the same place in UV as a face of the other.
//!
//! Copies and mirror images are laid over one another so that they share their texels; then whole charts coincide, corner by corner,
//! whichever way they face. A chart that coincides with another in part overlaps it: that is a fault. O(f log f).

use super::input::UvMesh;
use super::wedges::UvTopology;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::mesh::view::NONE;
use crate::plane::grid::{GridPoint, GridTriangle, doubled_area};
use core::cmp::Ordering;
use glam::DVec2;

/// What lies on others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stacked {
    /// Charts.
    pub charts: usize,
    /// Their faces.
    pub faces: usize,
}

/// Bytes that [`find_stacked`] needs.
pub const fn find_stacked_need(faces: usize) -> usize {
    bytes_for::<GridTriangle>(faces) + 3 * bytes_for::<u32>(faces + 1)
}

/// Marks in `stacked` the faces of all charts but the first of those that coincide on a grid of 2^-`bits`.
pub fn find_stacked(
    stacked: &mut [u8], // (f)
    mesh: UvMesh,
    topology: &UvTopology,
    bits: i32,
    mut scratch: Scratch,
) -> Result<Stacked, ScratchTooSmall> {
    scratch.require(find_stacked_need(stacked.len()))?;
    stacked.fill(0);
    let keys = scratch.take::<GridTriangle>(stacked.len())?;
    let key = |p: &GridPoint| (p.x(), p.y());
    for f in mesh.mapped_faces() {
        keys[f] = mesh.corner_uv[f].map(|uv: DVec2| GridPoint::snap(uv, bits));
        sort::by_key(&mut keys[f], key);
    }
    let of = |f: u32| keys[f as usize].each_ref().map(key);
    // Faces chart by chart, in an order that charts that coincide share.
    let faces = scratch.take::<u32>(stacked.len())?;
    faces.iter_mut().zip(0..).for_each(|(to, f)| *to = f);
    let chart = |f: u32| topology.chart[f as usize];
    sort::by(faces, |a, b| chart(*a).cmp(&chart(*b)).then_with(|| of(*a).cmp(&of(*b))).then(a.cmp(b)));
    let start = scratch.take::<u32>(topology.chart_count + 1)?;
    let mapped = faces.iter().filter(|f| chart(**f) != NONE);
    mapped.for_each(|f| start[chart(*f) as usize + 1] += 1);
    for k in 0..topology.chart_count {
        start[k + 1] += start[k];
    }
    let members = |k: u32| &faces[start[k as usize] as usize..start[k as usize + 1] as usize];
    let order = scratch.take::<u32>(topology.chart_count)?;
    order.iter_mut().zip(0..).for_each(|(to, k)| *to = k);
    let compare = |a: u32, b: u32| -> Ordering {
        let (a, b) = (members(a), members(b));
        a.len().cmp(&b.len()).then_with(|| a.iter().map(|f| of(*f)).cmp(b.iter().map(|f| of(*f))))
    };
    sort::by(order, |a, b| compare(*a, *b).then(a.cmp(b)));
    let mut out = Stacked::default();
    for alike in order.runs(|a, b| compare(*a, *b).is_eq()) {
        for k in alike.iter().skip(1).filter(|k| members(**k).iter().any(|f| doubled_area(&keys[*f as usize]) != 0)) {
            out.charts += 1;
            out.faces += members(*k).len();
            members(*k).iter().for_each(|f| stacked[*f as usize] = 1);
        }
    }
    Ok(out)
}
