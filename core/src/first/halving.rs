//! First maps of all charts: flattened, and halved where rounding flips a face.
//!
//! Tutte's embedding has no flips in exact arithmetic; in f64 a long thin limb can shrink below what can be told apart.
//! A chart that flips is parted into two of about equal numbers of faces, from its two ends, until none does.
//! The same ends a search whose charts have faces beyond a limit that no more cutting has mended.
//! Guarantee: disks without flips, or charts of one polygon.

use super::disks::disks_again;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;
use crate::charts::list::ChartList;
use crate::charts::surface::Surface;
use crate::charts::work::{Work, work_on};
use crate::solve::bound::flat_area;
use crate::solve::piece::Stop;
use glam::DVec2;

/// Times that charts which rounding has flipped are halved: 2^24 faces end as single polygons.
const HALVINGS: usize = 26;
/// Newton steps of the first flattening, after which charts are relaxed again wherever they matter: with 60 to 1e-3 searches take a ninth
/// longer, and 63 meshes are noticed 1.6 % more.
const FIRST_STOP: Stop = Stop { steps: 20, tolerance: 1e-2 };

/// Flattens every chart; a chart in which rounding flips a triangle is halved until none does.
pub fn flatten_all(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let changed = scratch.take_filled::<u8>(surface.mesh.faces.len(), 1)?;
    flatten_below(uv, cut, changed, f64::INFINITY, surface, scratch, workers)
}

/// Flattens the charts that hold a face marked in `changed`; those with a face whose energy is not below `most` then are
/// halved until there is none.
pub fn flatten_below(
    uv: &mut [DVec2],
    cut: &mut [u8],
    changed: &mut [u8], // (f)
    most: f64,
    surface: &Surface,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let flat = flat_area(surface.rest);
    for _ in 0..HALVINGS {
        {
            let mut frame = scratch.frame();
            let charts = ChartList::new(surface, cut, &mut frame)?;
            let touched = |k: usize| charts.faces_of(k).iter().any(|f| changed[*f as usize] != 0);
            work_on(uv, surface, cut, &charts, touched, Work::Flatten(FIRST_STOP), frame, workers)?;
        }
        let here = &*uv;
        let is_bad = |f: usize| {
            let energy = surface.rest[f].energy([here[3 * f], here[3 * f + 1], here[3 * f + 2]]);
            // What has no area to speak of counts where it is turned over, not where it is out of shape.
            !energy.is_finite() || energy >= most && surface.rest[f].area > flat
        };
        changed.fill(0);
        if halve(cut, changed, surface, is_bad, scratch.frame())? == 0 {
            break;
        }
        disks_again(cut, surface, scratch.frame())?;
    }
    Ok(())
}

/// Parts each chart that has a bad face into two of about equal numbers of faces; marks the faces of those charts and
/// returns how many charts it parted. A chart of one polygon stays whole.
pub fn halve(
    cut: &mut [u8],
    changed: &mut [u8],
    surface: &Surface,
    bad: impl Fn(usize) -> bool,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let charts = ChartList::new(surface, cut, &mut scratch)?;
    let side = scratch.take::<u8>(changed.len())?;
    let queue = scratch.take::<u32>(changed.len())?;
    let mut parted = 0;
    for k in 0..charts.count() {
        let faces = charts.faces_of(k);
        if !faces.iter().any(|f| bad(*f as usize)) {
            continue;
        }
        let mut spread = |seeds: &[u32], side: &mut [u8]| {
            faces.iter().for_each(|f| side[*f as usize] = 0);
            let (mut head, mut tail) = (0, 0);
            for (i, seed) in seeds.iter().enumerate() {
                side[*seed as usize] = 1 + i as u8;
                queue[tail] = *seed;
                tail += 1;
            }
            while head < tail {
                let f = queue[head];
                head += 1;
                for c in 3 * f..3 * f + 3 {
                    let Some(t) = surface.across(cut, c) else { continue };
                    if side[(t / 3) as usize] == 0 {
                        side[(t / 3) as usize] = side[f as usize];
                        queue[tail] = t / 3;
                        tail += 1;
                    }
                }
            }
            queue[tail - 1] // the farthest face
        };
        let a = spread(&faces[..1], side);
        let b = spread(&[a], side);
        if a != b {
            spread(&[a, b], side);
        }
        let mut any = false;
        for c in faces.iter().flat_map(|f| 3 * f..3 * f + 3) {
            if let Some(t) = surface.across(cut, c)
                && side[(c / 3) as usize] != side[(t / 3) as usize]
                && surface.cost[c as usize].is_finite()
            {
                surface.set_cut(cut, c, true);
                any = true;
            }
        }
        if any {
            faces.iter().for_each(|f| changed[*f as usize] = 1);
            parted += 1;
        }
    }
    Ok(parted)
}
