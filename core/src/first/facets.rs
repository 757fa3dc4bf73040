//! Openings of flat faces: where a bore, a boss or a pocket begins, its surface turns out of the plane all around.
//!
//! A chart that goes from a flat face into a bore has a saddle around the opening, and no map of it is flat: a search that may only cut
//! from border to border slashes the face. So another start of the search has cuts all around the openings: the inner loops of each
//! facet, a largest set of faces in one plane.
//! Cost: O(n log n).

use super::disks::disks_with_tips;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::sort;
use crate::charts::surface::Surface;
use crate::mesh::view::NONE;
use glam::DVec3;

/// Cosine of the angle up to which a face lies in the plane of a facet: half a degree.
const IN_PLANE: f64 = 0.99996;
/// Least area of a facet over that of the piece.
const SHARE: f64 = 0.005;

/// Cuts around the openings of facets and from there to disks; answers whether there are openings.
pub fn cut_around_openings(cut: &mut [u8], surface: &Surface, mut scratch: Scratch) -> Result<bool, ScratchTooSmall> {
    cut.fill(0);
    let found = open_loops(cut, surface, scratch.frame())?;
    if found {
        disks_with_tips(cut, surface, scratch)?;
    }
    Ok(found)
}

/// Cuts the inner loops of all facets; answers whether there are some.
fn open_loops(cut: &mut [u8], surface: &Surface, mut scratch: Scratch) -> Result<bool, ScratchTooSmall> {
    let facet = scratch.take_filled::<u32>(surface.rest.len(), NONE)?;
    grow_facets(facet, surface, scratch.frame())?;
    let edge = scratch.take::<u8>(cut.len())?; // borders of facets
    let seen = scratch.take::<u8>(cut.len())?;
    for c in 0..cut.len() {
        let across = surface.twin[c];
        edge[c] = u8::from(across == NONE || facet[c / 3] != facet[across as usize / 3]);
    }
    let mut found = false;
    for first in 0..cut.len() as u32 {
        let own = facet[first as usize / 3];
        if edge[first as usize] == 0 || seen[first as usize] != 0 || own == NONE {
            continue;
        }
        let normal = normal(own, surface);
        let (mut turned, mut may) = (0.0, true);
        for c in surface.border(edge, first) {
            seen[c as usize] = 1;
            let (p, q) = (surface.mesh.position(c), surface.mesh.positions[surface.far_end(c) as usize]);
            turned += p.cross(q).dot(normal);
            may &= surface.twin[c as usize] != NONE && surface.cost[c as usize].is_finite();
        }
        if turned < 0.0 && may {
            surface.border(edge, first).for_each(|c| surface.set_cut(cut, c, true));
            found = true;
        }
    }
    Ok(found)
}

/// Writes the facet of each face, named by its largest face; `NONE` where it is small.
fn grow_facets(facet: &mut [u32], surface: &Surface, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let order = scratch.take::<u32>(facet.len())?;
    order.iter_mut().enumerate().for_each(|(f, o)| *o = f as u32);
    let area = |f: u32| surface.rest[f as usize].area;
    sort::by(order, |a, b| area(*b).total_cmp(&area(*a)).then(a.cmp(b)));
    let queue = scratch.take::<u32>(facet.len())?;
    let least = SHARE * surface.rest.iter().map(|r| r.area).sum::<f64>();
    let taken = scratch.take::<u8>(facet.len())?;
    for seed in order.iter().copied() {
        if taken[seed as usize] != 0 {
            continue;
        }
        let plane = normal(seed, surface);
        taken[seed as usize] = 1;
        queue[0] = seed;
        let (mut head, mut tail) = (0, 1);
        while head < tail {
            let f = queue[head];
            head += 1;
            for t in (3 * f..3 * f + 3).map(|c| surface.twin[c as usize]).filter(|t| *t != NONE) {
                let g = (t / 3) as usize;
                if taken[g] == 0 && normal(t / 3, surface).dot(plane) >= IN_PLANE {
                    taken[g] = 1;
                    queue[tail] = t / 3;
                    tail += 1;
                }
            }
        }
        let faces = &queue[..tail];
        if faces.iter().map(|f| area(*f)).sum::<f64>() >= least {
            faces.iter().for_each(|f| facet[*f as usize] = seed);
        }
    }
    Ok(())
}

/// Unit normal of a face; zero where it has no area.
fn normal(f: u32, surface: &Surface) -> DVec3 {
    let [a, b, c] = [3 * f, 3 * f + 1, 3 * f + 2].map(|c| surface.mesh.position(c));
    (b - a).cross(c - a).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::super::disks::slit_holes;
    use super::*;
    use crate::charts::list::ChartList;
    use crate::charts::surface_tests::on_surface;
    use crate::mesh::view::{MeshView, next};
    use std::vec;
    use std::vec::Vec;

    /// A slab with a square bore through its middle, `half` as wide as it is from there to the rim; calls `then` with the surface and the
    /// vertices of the bore. Edges of which `dear` says so may not be cut.
    fn on_slab<T>(half: f64, dear: impl Fn(DVec3, DVec3) -> bool, then: impl Fn(&Surface, Scratch) -> T) -> T {
        let ring = |r: f64, z: f64| [(r, r), (-r, r), (-r, -r), (r, -r)].map(|(x, y)| DVec3::new(x, y, z));
        let positions = [ring(2.0, 1.0), ring(half, 1.0), ring(2.0, 0.0), ring(half, 0.0)].concat();
        let side = |a: u32, b: u32| {
            (0..4).flat_map(move |i| {
                let j = (i + 1) % 4;
                [[a + i, a + j, b + j], [a + i, b + j, b + i]]
            })
        };
        // Top, bottom, rim, bore.
        let faces: Vec<[u32; 3]> = side(0, 4).chain(side(12, 8)).chain(side(8, 0)).chain(side(4, 12)).collect();
        let price = |mesh: MeshView, c: u32| {
            let (p, q) = (mesh.position(c), mesh.position(next(c)));
            if dear(p, q) || dear(q, p) { f64::INFINITY } else { p.distance(q) }
        };
        on_surface(&positions, &faces, price, then)
    }

    /// Edges that are cut, and whether all charts are disks.
    fn judged(cut: &[u8], surface: &Surface, mut scratch: Scratch) -> (usize, bool) {
        let charts = ChartList::new(surface, cut, &mut scratch).unwrap();
        let node = scratch.take::<u32>(cut.len()).unwrap();
        let nodes = surface.wedges(cut, node);
        let cuts = cut.iter().filter(|c| **c != 0).count() / 2;
        let edges = cut.len() / 2 + cuts;
        let is_disk = |k: usize| {
            let faces = charts.faces_of(k);
            let first = surface.first_open(cut, faces).expect("a border");
            let open = faces.iter().flat_map(|f| 3 * f..3 * f + 3).filter(|c| surface.is_open(cut, *c)).count();
            surface.border(cut, first).count() == open
        };
        let euler = nodes + surface.rest.len() - edges;
        (cuts, euler == charts.count() && (0..charts.count()).all(is_disk))
    }

    #[test]
    fn a_slab_is_cut_around_both_ends_of_its_bore() {
        let free = |_, _| false;
        on_slab(1.0, free, |surface, mut scratch| {
            let mut cut = vec![0; surface.twin.len()];
            assert!(open_loops(&mut cut, surface, scratch.frame()).unwrap());
            let at = |c: u32| [surface.mesh.position(c), surface.mesh.positions[surface.far_end(c) as usize]];
            let around = |[p, q]: [DVec3; 2]| p.z == q.z && [p, q].iter().all(|p| p.x.abs() == 1.0);
            // Edges of the bore's ends that are no diagonals.
            let wanted = |c: u32| around(at(c)) && at(c)[0].distance(at(c)[1]) < 2.1;
            assert!((0..cut.len() as u32).all(|c| (cut[c as usize] != 0) == wanted(c)));
            assert_eq!(judged(&cut, surface, scratch.frame()), (8, false));
            // The bore and the rest with its two holes become disks, and then stay as they are.
            slit_holes(&mut cut, surface, scratch.frame()).unwrap();
            let (count, are_disks) = judged(&cut, surface, scratch.frame());
            assert!(are_disks && count > 8);
            let before = cut.clone();
            slit_holes(&mut cut, surface, scratch.frame()).unwrap();
            assert_eq!(cut, before);
            assert!(cut_around_openings(&mut cut, surface, scratch.frame()).unwrap());
            assert!(judged(&cut, surface, scratch).1);
            assert!(open_loops(&mut cut, surface, Scratch::new(&mut [0; 100])).is_err());
        });
    }

    #[test]
    fn loops_that_may_not_be_cut_and_facets_that_are_small_stay() {
        let count = |half: f64, dear: fn(DVec3, DVec3) -> bool| {
            on_slab(half, dear, |surface, mut scratch| {
                let mut cut = vec![0; surface.twin.len()];
                let found = open_loops(&mut cut, surface, scratch.frame()).unwrap();
                (found, judged(&cut, surface, scratch).0)
            })
        };
        let above = |p: DVec3, q: DVec3| p.z == 1.0 && q.z == 1.0 && p.x.abs() == 1.0 && q.x.abs() == 1.0;
        assert_eq!(count(1.0, above), (true, 4), "the one below alone");
        // What is left of top and bottom is a rim of a four-hundredth of the area.
        assert_eq!(count(1.995, |_, _| false), (false, 0));
    }
}
