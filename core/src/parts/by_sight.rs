//! Parts by what separates patches: patches, how far they are apart, clusters, smooth borders.

use super::affinity::{affinity, affinity_need};
use super::border::{smooth_border, smooth_border_need};
use super::dual::Dual;
use super::merging::{merge, merge_need};
use super::patches::{Patches, patch_count, patches_need, step_length};
use super::settings::PartSummary;
use super::surface::PartSurface;
use super::tidy::{absorb, connected, tidy_need};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::mesh::view::NONE;

/// Crumbs that the borders' smoothing leaves are below this share of the area.
const CRUMB: f64 = 1e-3;

/// Bytes that [`by_sight`] takes.
pub const fn by_sight_need(faces: usize) -> usize {
    let m = patch_count(faces);
    let steps = 2 * bytes_for::<f64>(3 * faces) + bytes_for::<u32>(faces);
    let pairs = bytes_for::<f64>(m * m) + bytes_for::<u8>(m * m) + bytes_for::<u32>(m);
    let patches = patches_need(faces) + 2 * bytes_for::<f64>(faces) + bytes_for::<f64>(3 * faces);
    let clustering = steps + pairs + patches + affinity_need(faces, m) + merge_need(m);
    let borders = smooth_border_need(faces) + tidy_need(faces);
    bytes_for::<u32>(faces) + (if clustering > borders { clustering } else { borders })
}

/// Labels of `surface`, as many as it has or `wanted`.
pub fn by_sight(
    labels: &mut [u32],
    surface: &PartSurface,
    dual: &Dual,
    wanted: Option<usize>,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<PartSummary, ScratchTooSmall> {
    cluster(labels, surface, dual, wanted, scratch.frame(), workers)?;
    let parts = connected(labels, dual, scratch.frame())?;
    let rough = scratch.take::<u32>(labels.len())?;
    rough.copy_from(labels);
    smooth_border(labels, parts, surface, dual, scratch.frame())?;
    let count = connected(labels, dual, scratch.frame())?;
    let crumb = CRUMB * dual.area.iter().sum::<f64>();
    // A part below a crumb's size is not taken for one: only what smoothing has cut off goes.
    let count = if count > parts { absorb(labels, count, dual, &|a, _| a < crumb, scratch)? } else { count };
    if wanted.is_some() && count != parts {
        // Smoothing has swallowed a part or cut one in two. Left to itself that is welcome, but not where N are asked for.
        labels.copy_from(rough);
        return Ok(PartSummary { parts, clusters: 0 });
    }
    Ok(PartSummary { parts: count, clusters: 0 })
}

/// Gives each face the number of its patch's cluster, and each speck one of its own.
fn cluster(
    labels: &mut [u32],
    surface: &PartSurface,
    dual: &Dual,
    wanted: Option<usize>,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let faces = labels.len();
    let (mesh, twin) = (surface.mesh, surface.twin);
    let length = scratch.take::<f64>(3 * faces)?;
    let inward = scratch.take::<f64>(3 * faces)?;
    for (e, c) in (0..twin.len() as u32).filter(|c| twin[*c as usize] != NONE && *c < twin[*c as usize]).enumerate() {
        for half in [c, twin[c as usize]] {
            length[half as usize] = step_length(mesh, c, twin[c as usize]);
            inward[half as usize] = (-dual.turn[e]).max(0.0);
        }
    }
    labels.fill(0);
    let components = connected(labels, dual, scratch.frame())?;
    let patches = Patches::new(mesh, twin, dual, labels, components, length, inward, &mut scratch)?;
    let m = patches.area.len();
    let apart = scratch.take::<f64>(m * m)?;
    let adjacent = scratch.take::<u8>(m * m)?;
    affinity(apart, adjacent, surface, dual, &patches, length, inward, scratch.frame(), workers)?;
    let cluster = scratch.take::<u32>(m)?;
    let specks = components - components_with_patches(labels, &patches);
    let wanted = wanted.map(|n| n.saturating_sub(specks));
    merge(cluster, apart, adjacent, patches.area, wanted, scratch.frame())?;
    for (label, patch) in labels.iter_mut().zip(patches.of.iter()) {
        *label = if *patch == NONE { m as u32 + *label } else { cluster[*patch as usize] };
    }
    Ok(())
}

/// How many components have patches. The first patches are the components' first.
fn components_with_patches(component: &[u32], patches: &Patches) -> usize {
    let of = |p: usize| component[patches.middle[p] as usize];
    (0..patches.middle.len()).filter(|p| (0..*p).all(|q| of(q) != of(*p))).count()
}
