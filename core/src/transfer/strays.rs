//! Faces whose region has no place for them, cut out and brought to where they belong.
//!
//! Where a border of the atlas finds no way on the other mesh, as across a flat without edges, what it parts hangs together: from the region's anchors
//! no walk reaches the places that the faces beyond are closest to. Such faces go wrong together, and all that they lie on would give way. A set of them that
//! trust each other, one of which is far from what its region reaches, is cut out along its edges, and joined to its neighbours of the same chart
//! over edges where each side reaches the other's places: the border moves. Cost: O(f log f) and the walks.

use super::mesh_and_atlas::MeshAndAtlas;
use super::sheets::{self, Sheets, area, middle, sheets_need};
use super::source::{SourceAtlas, Walking};
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::union_find::UnionFind;
use crate::charts::surface::Surface;
use crate::mesh::view::NONE;
use crate::mesh::working::DIAGONAL;

/// Distance beyond that of the closest place, over the root of the face's area, from which a face is a stray, and from which it is far off: a face of
/// good shape that lies beyond the border by its whole height is a third of that away in its middle.
const STRAY: f64 = 0.1;
const FAR: f64 = 0.35;

/// Bytes that [`part_strays`] takes, for a mesh of `faces` and a source of `charts`.
pub const fn strays_need(faces: usize, charts: usize) -> usize {
    let parting = bytes_for::<u32>(faces).saturating_add(bytes_for::<u8>(faces).saturating_mul(2));
    let flakes = bytes_for::<u32>(faces).saturating_mul(2).saturating_add(bytes_for::<f64>(faces));
    bytes_for::<u8>(3 * faces)
        .saturating_add(sheets_need(faces))
        .saturating_add(parting)
        .saturating_add(flakes)
        .saturating_add(bytes_for::<f64>(charts))
}

/// Cuts strays out of their regions and joins them to what they belong to; returns whether that changed anything. What has less than `flake` of the mesh's
/// area, and belongs to a chart that has a larger region, is left where it was.
pub fn part_strays(
    cut: &mut [u8],
    both: &MeshAndAtlas,
    flake: f64,
    walking: &mut Walking,
    mut scratch: Scratch,
) -> Result<bool, ScratchTooSmall> {
    let MeshAndAtlas { surface, hits, atlas: source, .. } = *both;
    let before = scratch.take::<u8>(cut.len())?;
    before.copy_from(cut);
    {
        let mut frame = scratch.frame();
        let sheets = Sheets::new(surface, cut, hits, source, walking, &mut frame)?;
        cut_out(cut, both, &sheets, walking, frame)?;
    }
    if *cut != *before {
        let sheets = Sheets::new(surface, cut, hits, source, walking, &mut scratch)?;
        join(cut, surface, &sheets, source, walking);
        drop_flakes(cut, before, surface, &sheets, flake, source.charts, scratch)?;
    }
    Ok(*cut != *before)
}

/// Cuts the sets of strays that trust each other out of their regions.
fn cut_out(
    cut: &mut [u8],
    both: &MeshAndAtlas,
    sheets: &Sheets,
    walking: &mut Walking,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let MeshAndAtlas { surface, hits, atlas: source, .. } = *both;
    let faces = hits.len();
    // How far off each face is: 0, 1 for a stray, 2 for one that is far.
    let off = scratch.take::<u8>(faces)?;
    for (f, off) in off.iter_mut().enumerate() {
        let there = source.walk(sheets.anchor[f], middle(surface.mesh, f), walking);
        let beyond = (sqrt(there.squared) - sqrt(hits[f].squared)) / sqrt(area(surface.mesh, f).max(f64::MIN_POSITIVE));
        *off = u8::from(beyond > STRAY) + u8::from(beyond > FAR);
    }
    let mut sets = UnionFind::new(scratch.take(faces)?);
    for f in (0..faces).filter(|f| off[*f] != 0) {
        for t in (3 * f as u32..3 * f as u32 + 3).filter_map(|c| surface.across(cut, c)) {
            let (t, is_one) = (t / 3, both.onto.fixed[t as usize] == DIAGONAL);
            if is_one || off[t as usize] != 0 && sheets::trusts(f, t as usize, surface.mesh, hits, source, walking) {
                sets.union(f as u32, t);
            }
        }
    }
    let is_far = scratch.take::<u8>(faces)?; // of each set, at its root
    (0..faces).filter(|f| off[*f] == 2).for_each(|f| is_far[sets.find(f as u32) as usize] = 1);
    let mut own = |f: u32| Some(sets.find(f)).filter(|r| is_far[*r as usize] != 0);
    for c in 0..cut.len() as u32 {
        if surface.across(cut, c).is_some_and(|t| own(c / 3) != own(t / 3)) {
            surface.set_cut(cut, c, true);
        }
    }
    Ok(())
}

/// Closes cuts between regions of one chart over which each side reaches the other's places.
fn join(cut: &mut [u8], surface: &Surface, sheets: &Sheets, source: &SourceAtlas, walking: &mut Walking) {
    let mesh = surface.mesh;
    let mut reaches = |f: u32, t: u32| {
        let (from, own) = (sheets.anchor[f as usize], sheets.anchor[t as usize]);
        let goal = middle(mesh, t as usize);
        sheets::is_as_near(source.walk(from, goal, walking).squared, source.walk(own, goal, walking).squared)
    };
    for c in 0..cut.len() as u32 {
        let (f, twin) = (c / 3, surface.twin[c as usize]);
        if twin == NONE || cut[c as usize] == 0 {
            continue;
        }
        let (t, [a, b]) = (twin / 3, [f, twin / 3].map(|f| sheets.region[f as usize] as usize));
        if a != b && sheets.chart[a] == sheets.chart[b] && reaches(f, t) && reaches(t, f) {
            surface.set_cut(cut, c, false);
        }
    }
}

/// Takes back what was cut since `before` around what is smaller than `flake`.
fn drop_flakes(
    cut: &mut [u8],
    before: &[u8],
    surface: &Surface,
    sheets: &Sheets,
    flake: f64,
    charts: usize,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let faces = sheets.region.len();
    let region = scratch.take::<u32>(faces)?;
    let regions = surface.charts(cut, region, scratch.frame().take(faces)?);
    let size = scratch.take::<f64>(regions)?;
    let largest = scratch.take::<f64>(charts)?;
    let chart = |f: usize| sheets.chart[sheets.region[f] as usize] as usize;
    (0..faces).for_each(|f| size[region[f] as usize] += area(surface.mesh, f));
    (0..faces).for_each(|f| largest[chart(f)] = largest[chart(f)].max(size[region[f] as usize]));
    let least = flake * size.iter().sum::<f64>();
    let is_flake = |f: usize| size[region[f] as usize] < least && size[region[f] as usize] < largest[chart(f)];
    for c in (0..before.len()).filter(|c| before[*c] == 0) {
        if cut[c] != 0 && (is_flake(c / 3) || is_flake(surface.twin[c] as usize / 3)) {
            surface.set_cut(cut, c as u32, false);
        }
    }
    Ok(())
}
