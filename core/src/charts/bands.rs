//! Strips of a surface between sharp edges: the side of a cylinder, a belt, a bent sheet.
//!
//! Sharp edges part a surface into regions. A region that is bent, unrolls without distortion and has straight sides then is a strip: a
//! ring between two borders that do not turn, or a disk whose border turns at four corners. How a border turns once it is unrolled
//! is known before it is: by the angles of the faces there.
//! Guarantee: no edge is marked that must not be cut. O(f). Limit: a strip that runs smoothly into something else is none.

use super::strip::CORNER;
use super::surface::Surface;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::mesh::normals::angle;
use crate::mesh::view::{NONE, next, prev};
use bytemuck::{Pod, Zeroable};
use core::f64::consts::PI;
use glam::DVec3;

/// Turn from which on an edge is sharp, in degrees.
const SHARP: f64 = 35.0;
/// Length of the sum of all area vectors, over that of their lengths, from which on a region is one flat face.
const FLAT: f64 = 0.9994;
/// How far, in radians, a region may be from unrolling, and a side from straight, over all of its vertices: what a file's digits leave.
const STRAIGHT: f64 = 0.05;

/// What is known of a region.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Region {
    normal: DVec3, // sum of area vectors
    defect: f64,   // sum of what angles at inner vertices lack of a full turn, whichever sign
    area: f64,     // sum of their lengths
    loops: u32,
    corners: u32,
    is_crooked: u32,
    unused: u32,
}

impl Region {
    fn is_strip(&self) -> bool {
        let sides = matches!((self.loops, self.corners), (1, 4) | (2, 0));
        sides && self.is_crooked == 0 && self.defect <= STRAIGHT && self.normal.length() < FLAT * self.area
    }
}

/// Scratch bytes that [`part_bands`] uses.
pub const fn part_bands_need(faces: usize) -> usize {
    let corners = 3 * faces;
    2 * bytes_for::<u8>(corners)
        + bytes_for::<u32>(corners)
        + 2 * bytes_for::<u32>(faces)
        + bytes_for::<f64>(corners)
        + bytes_for::<u8>(corners)
        + bytes_for::<Region>(faces)
}

/// Marks the borders of strips in `forced`; returns how many there are.
pub fn part_bands(forced: &mut [u8], surface: &Surface, mut scratch: Scratch) -> Result<usize, ScratchTooSmall> {
    let faces = surface.mesh.faces.len();
    let cut = scratch.take::<u8>(3 * faces)?;
    for c in 0..3 * faces as u32 {
        cut[c as usize] = u8::from(surface.cost[c as usize].is_finite() && is_sharp(surface, c));
    }
    let (region, queue) = (scratch.take::<u32>(faces)?, scratch.take::<u32>(faces)?);
    let count = surface.charts(cut, region, queue);
    let node = scratch.take::<u32>(3 * faces)?;
    let nodes = surface.wedges(cut, node);
    let regions = scratch.take::<Region>(count)?;
    let angles = scratch.take::<f64>(nodes)?;
    (0..3 * faces as u32).for_each(|c| angles[node[c as usize] as usize] += corner_angle(surface, c));
    let on_border = scratch.take::<u8>(nodes)?;
    let passed = scratch.take::<u8>(3 * faces)?;
    for c in (0..3 * faces as u32).filter(|c| surface.is_open(cut, *c)) {
        on_border[node[c as usize] as usize] = 1;
        if passed[c as usize] == 0 {
            follow(&mut regions[region[c as usize / 3] as usize], passed, surface, cut, c, |c| {
                PI - angles[node[c as usize] as usize]
            });
        }
    }
    for (c, n) in node.iter().enumerate() {
        // An inner vertex counts once.
        if core::mem::replace(&mut on_border[*n as usize], 1) == 0 {
            regions[region[c / 3] as usize].defect += (2.0 * PI - angles[*n as usize]).abs();
        }
    }
    for (f, r) in region.iter().enumerate() {
        let normal = surface.mesh.area_vector(f);
        regions[*r as usize].normal += normal;
        regions[*r as usize].area += normal.length();
    }
    for c in (0..3 * faces).filter(|c| cut[*c] != 0 && surface.twin[*c] != NONE) {
        let sides = [c / 3, surface.twin[c] as usize / 3].map(|f| region[f] as usize);
        if sides[0] != sides[1] && sides.iter().any(|r| regions[*r].is_strip()) {
            forced[c] = 1;
        }
    }
    Ok(regions.iter().filter(|r| r.is_strip()).count())
}

/// Goes once round a border from half-edge `first`, which `turn`s at the start of each half-edge.
fn follow(
    region: &mut Region,
    passed: &mut [u8],
    surface: &Surface,
    cut: &[u8],
    first: u32,
    turn: impl Fn(u32) -> f64,
) {
    region.loops += 1;
    let mut sum = 0.0;
    for c in surface.border(cut, first) {
        passed[c as usize] = 1;
        let turn = turn(c);
        let degrees = turn.to_degrees();
        if degrees >= CORNER[0] {
            region.corners += 1;
            region.is_crooked |= u32::from(degrees > CORNER[1]);
        } else {
            sum += turn.abs();
        }
    }
    region.is_crooked |= u32::from(sum > STRAIGHT);
}

/// Whether the surface turns sharply at the half-edge of `c`.
fn is_sharp(surface: &Surface, c: u32) -> bool {
    let t = surface.twin[c as usize];
    if t == NONE {
        return false;
    }
    let [m, n] = [c, t].map(|c| surface.mesh.area_vector(c as usize / 3));
    angle(m, n) > SHARP.to_radians()
}

/// Angle of a face at corner `c`.
fn corner_angle(surface: &Surface, c: u32) -> f64 {
    let p = surface.mesh.position(c);
    let [a, b] = [next(c), prev(c)].map(|d| surface.mesh.position(d) - p);
    angle(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charts::pieces::{Pieces, pieces_need};
    use crate::mesh::topology::{twins, twins_need};
    use crate::mesh::view::MeshView;
    use std::{vec, vec::Vec};

    /// Strips and edges that are marked.
    fn marked(positions: &[DVec3], faces: &[[u32; 3]]) -> (usize, usize) {
        let mesh = MeshView { positions, faces };
        let mut twin = vec![0; mesh.corner_count()];
        let mut bytes = vec![0; twins_need(faces.len())];
        twins(&mut twin, mesh, Scratch::new(&mut bytes)).unwrap();
        let (mut forced, cost) = (vec![0; twin.len()], vec![1.0; twin.len()]);
        let mut bytes = vec![0; pieces_need(faces.len())];
        let pieces = Pieces::new(mesh, &twin, &forced, &cost, &mut Scratch::new(&mut bytes)).unwrap();
        let mut bytes = vec![0; part_bands_need(faces.len())];
        let count = part_bands(&mut forced, &pieces.bare_surface(0), Scratch::new(&mut bytes)).unwrap();
        (count, forced.iter().filter(|f| **f != 0).count() / 2)
    }

    /// A closed drum of `n` sides between two rings of these radii, a unit apart, with a fan at each end.
    fn drum(n: u32, radii: [f64; 2]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let at = |r: f64, z: f64, i: u32| {
            let a = f64::from(i) * 2.0 * PI / f64::from(n);
            DVec3::new(r * crate::base::real::cos(a), r * crate::base::real::sin(a), z)
        };
        let mut positions: Vec<DVec3> = (0..2).flat_map(|k| (0..n).map(move |i| at(radii[k], k as f64, i))).collect();
        positions.extend([DVec3::ZERO, DVec3::Z]);
        let sides = |i: u32| {
            let j = (i + 1) % n;
            [[i, j, n + j], [i, n + j, n + i], [2 * n, j, i], [2 * n + 1, n + i, n + j]]
        };
        (positions, (0..n).flat_map(sides).collect())
    }

    #[test]
    fn the_side_of_a_cylinder_is_a_strip_and_that_of_a_cone_is_none() {
        let (positions, faces) = drum(24, [1.0, 1.0]);
        assert_eq!(marked(&positions, &faces), (1, 48));
        let (positions, faces) = drum(24, [1.0, 0.8]);
        assert_eq!(marked(&positions, &faces), (0, 0));
        // The sides of a prism are flat faces.
        let (positions, faces) = drum(6, [1.0, 1.0]);
        assert_eq!(marked(&positions, &faces), (0, 0));
    }
}
