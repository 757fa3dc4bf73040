//! An order of parts that similar shapes share.
//!
//! Parts are sorted by size, then diameter, then place, each rounded so that what is alike counts as equal: a grid then
//! gives the same part of similar shapes the same cell. Sizes and diameters fall into steps of a factor of 2, places into
//! eighths of the mesh's box. Guarantee: the order does not depend on the numbers that labels had, nor on the mesh's scale
//! or origin. Limits: two values that are close may still lie on either side of a step.

use crate::base::real::{ln, round};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::mesh::view::NONE;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Steps of the box's longest side that places are rounded to.
const PLACES: f64 = 8.0;

/// Sums over the faces of one part.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Part {
    area: f64,
    diameter: f64, // times area
    place: DVec3,  // times area
}

/// Scratch bytes that [`order_parts`] needs for labels below `labels`.
pub const fn order_parts_need(labels: usize) -> usize {
    bytes_for::<Part>(labels).saturating_add(bytes_for::<u32>(labels).saturating_mul(2))
}

/// One face as [`order_parts`] sees it, in units of the mesh's longest side.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    /// Its part, below the number of labels.
    pub part: u32,
    /// Its area.
    pub area: f64,
    /// The object's thickness there.
    pub diameter: f64,
    /// Its centroid.
    pub place: DVec3,
}

/// Rewrites `labels`, whose values are below `count` or [`NONE`], so that they number the parts of `faces` in their order,
/// the largest first; returns how many parts have a face. Labels without any become [`NONE`].
pub fn order_parts(
    labels: &mut [u32],
    count: usize,
    faces: impl Iterator<Item = Face>,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    scratch.require(order_parts_need(count))?;
    let parts = scratch.take::<Part>(count)?;
    let order = scratch.take::<u32>(count)?;
    let rank = scratch.take_filled::<u32>(count, NONE)?;
    let mut used = 0;
    for face in faces {
        if rank[face.part as usize] == NONE {
            rank[face.part as usize] = 0;
            order[used] = face.part;
            used += 1;
        }
        let part = &mut parts[face.part as usize];
        part.area += face.area;
        part.diameter += face.diameter * face.area;
        part.place += face.place * face.area;
    }
    let total = parts.iter().fold(0.0, |sum, p| sum + p.area);
    let order = &mut order[..used];
    let key = |l: u32| {
        let Part { area, diameter, place } = parts[l as usize];
        let place = place / area.max(f64::MIN_POSITIVE);
        let steps = |x: f64| round(-ln(x.max(1e-300)) / core::f64::consts::LN_2);
        let rounded = (place * PLACES).to_array().map(round);
        ([steps(area / total), steps(diameter / area)], rounded, place.to_array(), area)
    };
    sort::by(order, |&a, &b| {
        let (p, q) = (key(a), key(b));
        let reals = |x: &[f64], y: &[f64]| {
            x.iter()
                .zip(y)
                .map(|(x, y)| (x + 0.0).total_cmp(&(y + 0.0)))
                .find(|o| o.is_ne())
                .unwrap_or(core::cmp::Ordering::Equal)
        };
        reals(&p.0, &q.0)
            .then_with(|| reals(&p.1, &q.1))
            .then_with(|| reals(&p.2, &q.2))
            .then_with(|| q.3.total_cmp(&p.3))
            .then(a.cmp(&b))
    });
    order.iter().enumerate().for_each(|(i, l)| rank[*l as usize] = i as u32);
    labels.iter_mut().for_each(|l| *l = rank.get(*l as usize).copied().unwrap_or(NONE));
    Ok(used)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{vec, vec::Vec};

    fn ordered(labels: &[u32], count: usize, of: impl Fn(u32) -> (f64, f64, DVec3)) -> (Vec<u32>, usize) {
        let mut out = labels.to_vec();
        let mut bytes = vec![0; order_parts_need(count)];
        let faces = labels.iter().map(|l| {
            let (area, diameter, place) = of(*l);
            Face { part: *l, area, diameter, place }
        });
        let used = order_parts(&mut out, count, faces, Scratch::new(&mut bytes)).unwrap();
        (out, used)
    }

    #[test]
    fn size_comes_before_diameter_and_diameter_before_place() {
        let of = |l: u32| match l {
            0 => (1.0, 0.1, DVec3::X),   // thin, on the right
            1 => (1.02, 0.1, -DVec3::X), // thin, on the left, a little larger: the same size
            2 => (0.98, 0.4, DVec3::X),  // thick
            _ => (9.0, 0.1, DVec3::X),   // large
        };
        assert_eq!(ordered(&[0, 1, 2, 3], 4, of), (vec![3, 2, 1, 0], 4));
        assert_eq!(ordered(&[3, 0], 4, of), (vec![0, 1], 2));
    }

    #[test]
    fn other_numbers_of_the_labels_change_no_order() {
        let of = |l: u32| (1.0 + f64::from(l * l), 0.2, DVec3::new(f64::from(l), 0.0, 0.0));
        let (straight, _) = ordered(&[0, 1, 2, 3, 2], 4, of);
        let turn = |l: u32| [2, 0, 3, 1][l as usize];
        let back = |l: u32| [1, 3, 0, 2][l as usize];
        let (turned, _) = ordered(&[0, 1, 2, 3, 2].map(turn), 4, |l| of(back(l)));
        assert_eq!(straight, turned);
    }

    #[test]
    fn parts_without_area_and_meshes_without_parts_are_no_trouble() {
        assert_eq!(ordered(&[], 0, |_| (1.0, 1.0, DVec3::ZERO)), (vec![], 0));
        assert_eq!(ordered(&[1, 0], 2, |_| (0.0, 0.0, DVec3::ZERO)), (vec![1, 0], 2));
    }

    #[test]
    fn too_little_memory_is_an_error() {
        let need = order_parts_need(1);
        let mut bytes = vec![0; need - 1];
        let faces = core::iter::empty();
        let result = order_parts(&mut [0], 1, faces, Scratch::new(&mut bytes));
        assert_eq!(result, Err(ScratchTooSmall { need, given: need - 1 }));
    }
}
