//! Borders between parts, drawn again as the cheapest ones nearby: along creases, short elsewhere.
//!
//! Faces within a band about the borders choose their label anew, by alpha-expansion of
//!     E = sum over faces in the band of PULL (depth/width) (area/width) [label changed]
//!       + sum over edges between labels of length max(exp(-inward turn/GIVE), LEAST).
//! depth is the way from the old border, width the band's. The measure is Katz, Tal 2003 (fuzzy region and minimum cut),
//! the cost of an edge that of the minima rule. Faces outside keep their labels; they are left out of the graph.

use super::dual::Dual;
use super::expansion::{Energy, FORBIDDEN, expand, expand_need, fixed};
use super::patches::{Walk, step_length, walk_need};
use super::surface::PartSurface;
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::mesh::view::NONE;

/// Width of the band as a share of the root of the area. 0.03 leaves pieces of flat wall that 0.06 swallows: a part no
/// wider than the band and without a crease about it costs more than it holds (cups: Rand error 0.26 and 0.14).
const WIDTH: f64 = 0.06;
/// What staying near the old border is worth.
const PULL: f64 = 0.5;
/// Radians of inward turn that make an edge cheaper by e.
const GIVE: f64 = 0.3;
/// Least cost of an edge, as a share of its length.
const LEAST: f64 = 0.05;
/// Rounds of expansion at the most; more cost as much again and move little.
const ROUNDS: usize = 1;

/// Bytes that [`smooth_border`] takes.
pub const fn smooth_border_need(faces: usize) -> usize {
    let edges = faces + faces / 2 + 1;
    let graph = 3 * bytes_for::<u32>(faces) + bytes_for::<[u32; 2]>(edges) + bytes_for::<i64>(edges);
    let walk = bytes_for::<f64>(3 * faces) + walk_need(faces);
    graph + walk + bytes_for::<i64>(faces) + expand_need(faces, edges)
}

/// Moves the borders between the labels 0..count.
pub fn smooth_border(
    labels: &mut [u32],
    count: usize,
    surface: &PartSurface,
    dual: &Dual,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let faces = labels.len();
    let width = WIDTH * real::sqrt(dual.area.iter().sum::<f64>());
    if count < 2 || width.is_nan() || width <= 0.0 {
        return Ok(());
    }
    let depth = depths(labels, surface, dual, &mut scratch)?;
    // Faces of the band, and the ring around it that holds its outer labels.
    let place = scratch.take_filled::<u32>(faces, NONE)?;
    let face = scratch.take::<u32>(faces)?;
    let in_band = |f: u32| depth[f as usize] < width;
    let mut used = 0;
    for &[a, b] in dual.sides {
        for f in [a, b] {
            if (in_band(a) || in_band(b)) && place[f as usize] == NONE {
                (place[f as usize], face[used]) = (used as u32, f);
                used += 1;
            }
        }
    }
    let face = &face[..used];
    let is_near = |s: &[u32; 2]| in_band(s[0]) || in_band(s[1]);
    let near = dual.sides.iter().filter(|s| is_near(s)).count();
    let edges = scratch.take::<[u32; 2]>(near)?;
    let weight = scratch.take::<i64>(near)?;
    let band_edges = dual.sides.iter().enumerate().filter(|(_, s)| is_near(s));
    for ((edge, weight), (e, sides)) in edges.iter_mut().zip(weight.iter_mut()).zip(band_edges) {
        *edge = sides.map(|f| place[f as usize]);
        let cost = real::exp(dual.turn[e].min(0.0) / GIVE).max(LEAST);
        *weight = fixed(dual.length[e] / width * cost);
    }
    let old = scratch.take::<u32>(used)?;
    let new = scratch.take::<u32>(used)?;
    old.iter_mut().zip(face).for_each(|(l, f)| *l = labels[*f as usize]);
    new.copy_from(old);
    let change = scratch.take::<i64>(used)?;
    for (change, f) in change.iter_mut().zip(face) {
        let f = *f as usize;
        *change = if depth[f] < width {
            fixed(PULL * (depth[f] / width) * (dual.area[f] / (width * width)))
        } else {
            FORBIDDEN
        };
    }
    let data = |i: u32, l: u32| if l == old[i as usize] { 0 } else { change[i as usize] };
    expand(new, &Energy { edges, weight, data: &data }, count as u32, ROUNDS, scratch.frame())?;
    face.iter().zip(new.iter()).for_each(|(f, l)| labels[*f as usize] = *l);
    Ok(())
}

/// The way from each face to the nearest border between labels.
fn depths<'a>(
    labels: &[u32],
    surface: &PartSurface,
    dual: &Dual,
    scratch: &mut Scratch<'a>,
) -> Result<&'a mut [f64], ScratchTooSmall> {
    let out = scratch.take::<f64>(labels.len())?;
    let mut frame = scratch.frame();
    let step = frame.take::<f64>(surface.twin.len())?;
    for (c, twin) in surface.twin.iter().enumerate().filter(|(_, t)| **t != NONE) {
        step[c] = step_length(surface.mesh, c as u32, *twin);
    }
    let mut walk = Walk::new(labels.len(), &mut frame)?;
    for &[a, b] in dual.sides {
        if labels[a as usize] != labels[b as usize] {
            walk.start(a);
            walk.start(b);
        }
    }
    walk.run(surface.twin, step, |_, _| {});
    out.copy_from(walk.distance);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::view::MeshView;
    use crate::parts::dual::dual_need;
    use crate::parts::turned_tests::{Turned, turned};
    use std::{vec, vec::Vec};

    /// Two drums with a shallow groove between them at height 0.6.
    fn grooved() -> Turned {
        turned(&[&[0.5; 6][..], &[0.45], &[0.5; 6]].concat())
    }

    /// Label 1 for faces above `height`.
    fn above(shape: &Turned, height: f64) -> Vec<u32> {
        let z = |f: &[u32; 3]| f.iter().map(|v| shape.positions[*v as usize].z).sum::<f64>() / 3.0;
        shape.faces.iter().map(|f| u32::from(z(f) > height)).collect()
    }

    fn run(labels: &mut [u32], shape: &Turned, short: usize) -> Result<(), ScratchTooSmall> {
        let mesh = MeshView { positions: &shape.positions, faces: &shape.faces };
        let surface = PartSurface { mesh, twin: &shape.twin, diameter: &shape.diameter, sees: &|_, _| true };
        let mut bytes = vec![0; dual_need(labels.len())];
        let dual = Dual::new(mesh, &shape.twin, &mut Scratch::new(&mut bytes)).unwrap();
        let mut bytes = vec![0; smooth_border_need(labels.len()) / short];
        smooth_border(labels, 2, &surface, &dual, Scratch::new(&mut bytes))
    }

    #[test]
    fn a_border_beside_a_groove_slides_into_it() {
        let shape = grooved();
        let mut labels = above(&shape, 0.7);
        run(&mut labels, &shape, 1).unwrap();
        assert_eq!(labels, above(&shape, 0.6));
    }

    #[test]
    fn a_border_in_the_groove_stays_and_one_label_has_none() {
        let shape = grooved();
        for height in [0.6, 9.0] {
            let mut labels = above(&shape, height);
            run(&mut labels, &shape, 1).unwrap();
            assert_eq!(labels, above(&shape, height));
        }
    }

    #[test]
    fn too_little_memory_is_refused() {
        let shape = grooved();
        assert!(run(&mut above(&shape, 0.6), &shape, 10).is_err());
    }
}
