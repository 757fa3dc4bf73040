//! Parts of the user's polygons: found by the shape, or given by labels from elsewhere, and put in a shared order.
//!
//! Works on a repaired copy whose faces turn outwards, so that rays start inside. A polygon of several triangles has the
//! part that covers most of it; one that repair drops has that of a polygon at one of its vertices. Parts come out numbered
//! by size, diameter and place, see [`order`](super::order).

use super::input::{Input, fits};
use super::order::{Face, order_parts, order_parts_need};
use super::partition::{partition, partition_need};
use super::report::UnwrapError;
use crate::base::progress::{Progress, Stage, tell};
use crate::base::real;
use crate::base::scratch::{Scratch, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::base::workers::Workers;
use crate::mesh::repair::{Facing, repair, repair_need};
use crate::mesh::view::NONE;
use crate::mesh::working::Working;
use crate::parts::settings::PartSettings;
use crate::rays::bvh::{BuildBvh, BvhError};
use crate::rays::cast::Scene;
use crate::rays::diameter::{DiameterSettings, diameter};
use glam::Vec3;

/// Where the parts come from.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// The shape alone.
    Shape(PartSettings),
    /// One label a polygon; equal labels are one part. Polygons beyond the list have one label.
    Labels(&'a [u32]), // (p)
}

/// Where parts are written.
pub struct Parts<'a> {
    /// Part of each polygon, below the number of parts.
    pub part: &'a mut [u32], // (p)
    /// Shape diameter at each polygon, in the user's units; 0 where it has none.
    pub diameter: &'a mut [f32], // (p)
}

/// Scratch bytes that [`parts_of_polygons`] asks for.
pub fn parts_of_polygons_need(input: &Input, bvh: &dyn BuildBvh) -> usize {
    let sizes = input.polygon_start.windows(2).map(|p| p[1].saturating_sub(p[0]) as usize);
    let triangles: usize = sizes.map(|n| n.saturating_sub(2)).sum();
    let polygons = input.polygon_start.len();
    let work = partition_need(triangles, 3 * triangles, bvh).max(order_parts_need(polygons.max(triangles)));
    let labels = bytes_for::<u32>(triangles).saturating_mul(2).saturating_add(bytes_for::<u32>(polygons));
    repair_need(&input.polygons().counts())
        .saturating_add(labels)
        .saturating_add(bytes_for::<u32>(input.positions.len()))
        .saturating_add(work)
}

/// Writes part and diameter of every polygon; returns how many parts there are. Outputs have one entry a polygon; they are
/// unspecified where the result is an error.
pub fn parts_of_polygons(
    out: Parts,
    input: &Input,
    source: Source,
    bvh: &dyn BuildBvh,
    mut scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<usize, UnwrapError> {
    let polygons = input.polygon_start.len().saturating_sub(1);
    fits(polygons, out.part.len())?;
    fits(polygons, out.diameter.len())?;
    scratch.require(parts_of_polygons_need(input, bvh))?;
    tell(progress, Stage::Parts, 0, 1)?;
    let (working, _) = repair(&input.polygons(), Facing::Turned, &mut scratch)?;
    let faces = working.faces.len();
    let label = scratch.take::<u32>(faces)?;
    let thickness = scratch.take::<f32>(faces)?;
    let tree = |e| match e {
        BvhError::Scratch(e) => e.into(),
        _ => UnwrapError::BadTree,
    };
    match source {
        Source::Shape(settings) => {
            let (mesh, twin) = (working.mesh(), working.twin);
            partition(label, thickness, mesh, twin, &settings, bvh, scratch.frame(), workers).map_err(tree)?;
        }
        Source::Labels(_) => cast(thickness, &working, bvh, scratch.frame(), workers).map_err(tree)?,
    }
    let Parts { part, diameter: polygon_diameter } = out;
    let count = match source {
        Source::Shape(_) => {
            vote(part, label, &working);
            faces
        }
        Source::Labels(given) => rank(part, given, scratch.frame())?,
    };
    of_polygons(polygon_diameter, thickness, &working);
    let found = (0..faces).filter(|f| part[working.polygon[*f] as usize] != NONE);
    let mesh = working.mesh();
    let seen = scratch.take::<u32>(faces)?; // the labels before they are renumbered
    found.clone().for_each(|f| seen[f] = part[working.polygon[f] as usize]);
    let face = |f: usize| {
        let area = mesh.area_vector(f);
        let [a, b, c] = working.faces[f].map(|v| working.positions[v as usize]);
        let place = (a + b + c) / 3.0;
        Face { part: seen[f], area: 0.5 * real::sqrt(area.dot(area)), diameter: f64::from(thickness[f]), place }
    };
    let listed = (0..faces).filter(|f| seen[*f] as usize <= count).map(face);
    let parts = order_parts(part, count, listed, scratch.frame())?;
    // Last, since a label that only dropped polygons have is no part.
    fill_dropped(part, input, &working, scratch)?;
    tell(progress, Stage::Parts, 1, 1)?;
    Ok(parts)
}

/// The shape diameter alone, as [`partition`] finds it.
fn cast(
    out: &mut [f32], // (f)
    working: &Working,
    bvh: &dyn BuildBvh,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), BvhError> {
    let positions = scratch.take::<Vec3>(working.positions.len())?;
    positions.iter_mut().zip(working.positions).for_each(|(p, q)| *p = q.as_vec3());
    let scene = Scene::new(positions, working.faces, bvh, &mut scratch)?;
    diameter(out, working.mesh(), working.twin, &scene, &DiameterSettings::default(), scratch, workers)?;
    Ok(())
}

/// The label that covers most of each polygon; [`NONE`] for those without a face.
fn vote(part: &mut [u32], label: &[u32], working: &Working) {
    part.fill(NONE);
    let area = |f: usize| {
        let a = working.mesh().area_vector(f);
        a.dot(a)
    };
    let mut first = 0;
    for group in working.polygon.runs(|a, b| a == b) {
        let faces = first..first + group.len();
        first = faces.end;
        // Few faces a polygon: the square is no matter, and long polygons take the label of their first face.
        let weight =
            |l: u32| faces.clone().filter(|f| label[*f] == l).map(|f| real::sqrt(area(f))).fold(0.0, |s, a| s + a);
        let best = match faces.len() {
            1 => label[faces.start],
            n if n > LONG => label[faces.start],
            _ => faces
                .clone()
                .map(|f| label[f])
                .max_by(|a, b| weight(*a).total_cmp(&weight(*b)).then(b.cmp(a)))
                .unwrap_or(NONE),
        };
        part[group[0] as usize] = best;
    }
}

/// Polygons of more triangles are not put to the vote.
const LONG: usize = 64;

/// Numbers of labels of any value, by value; returns how many there are.
fn rank(part: &mut [u32], given: &[u32], mut scratch: Scratch) -> Result<usize, UnwrapError> {
    let order = scratch.take::<u32>(part.len())?;
    order.iter_mut().enumerate().for_each(|(i, p)| *p = i as u32);
    let label = |p: u32| given.get(p as usize).copied().unwrap_or(NONE);
    sort::by_key(order, |p| (label(*p), *p));
    let mut count = 0;
    for group in order.runs(|a, b| label(*a) == label(*b)) {
        group.iter().for_each(|p| part[*p as usize] = count);
        count += 1;
    }
    Ok(count as usize)
}

/// The mean diameter over each polygon's triangles, in the user's units; the largest float where that is beyond all floats.
fn of_polygons(out: &mut [f32], diameter: &[f32], working: &Working) {
    out.fill(0.0);
    let mut first = 0;
    for group in working.polygon.runs(|a, b| a == b) {
        let sum = diameter[first..first + group.len()].iter().fold(0.0, |sum, d| sum + f64::from(*d));
        // Nothing is nothing, however large the mesh: its extent may be infinite.
        let size = if sum > 0.0 { sum / group.len() as f64 * working.extent } else { 0.0 };
        out[group[0] as usize] = size.min(f32::MAX.into()) as f32;
        first += group.len();
    }
}

/// Gives polygons without a face the part of a polygon that shares a place with them, else part 0.
fn fill_dropped(part: &mut [u32], input: &Input, working: &Working, mut scratch: Scratch) -> Result<(), UnwrapError> {
    if !part.contains(&NONE) {
        return Ok(());
    }
    let at = scratch.take_filled::<u32>(input.positions.len(), NONE)?;
    let corners = |p: usize| &input.corners[input.polygon_start[p] as usize..input.polygon_start[p + 1] as usize];
    let place = |v: &u32| working.welded[*v as usize] as usize;
    for p in (0..part.len()).rev().filter(|p| part[*p] != NONE) {
        corners(p).iter().for_each(|v| at[place(v)] = part[p]);
    }
    for (p, part) in part.iter_mut().enumerate().filter(|(_, part)| **part == NONE) {
        *part = corners(p).iter().map(|v| at[place(v)]).find(|l| *l != NONE).unwrap_or(0);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::progress::Silent;
    use crate::base::workers::Serial;
    use crate::rays::binned::BinnedBuilder;
    use glam::DVec3;
    use std::{vec, vec::Vec};

    /// A box of quads with a polygon of one repeated corner at the end.
    fn cube() -> (Vec<DVec3>, Vec<u32>, Vec<u32>) {
        let positions = (0..8).map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64)).collect();
        let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5, 3, 3, 3];
        (positions, corners, vec![0, 4, 8, 12, 16, 20, 24, 27])
    }

    fn run(source: Source, less: usize) -> Result<(usize, Vec<u32>, Vec<f32>), UnwrapError> {
        let (positions, corners, polygon_start) = cube();
        let input = Input::new(&positions, &corners, &polygon_start);
        let (mut part, mut diameter) = (vec![9; 7], vec![9.0; 7]);
        let mut bytes = vec![0; parts_of_polygons_need(&input, &BinnedBuilder) - less];
        let out = Parts { part: &mut part, diameter: &mut diameter };
        let count =
            parts_of_polygons(out, &input, source, &BinnedBuilder, Scratch::new(&mut bytes), &Serial, &mut Silent)?;
        Ok((count, part, diameter))
    }

    #[test]
    fn labels_of_any_value_become_parts_by_size() {
        let (count, part, diameter) = run(Source::Labels(&[77, 5, 5, 5, 5, 5, 5]), 0).unwrap();
        assert_eq!((count, part), (2, vec![1, 0, 0, 0, 0, 0, 0]));
        // A ray from a centroid, 1/3 from the nearest side, within 60 degrees of the normal: 1/3 / sin 60 to the diagonal.
        // The last polygon has no face to start from.
        assert!(diameter[..6].iter().all(|d| (0.384..1.74).contains(d)) && diameter[6] == 0.0, "{diameter:?}");
    }

    #[test]
    fn a_label_that_only_dropped_polygons_have_is_no_part() {
        let (count, part, _) = run(Source::Labels(&[4, 4, 4, 6, 6, 6, 5]), 0).unwrap();
        assert!(count == 2 && part[..6] == [0, 0, 0, 1, 1, 1] && part[6] < 2, "{count} {part:?}");
    }

    #[test]
    fn a_polygon_that_repair_drops_gets_a_part_all_the_same() {
        let (count, part, _) = run(Source::Shape(PartSettings::default()), 0).unwrap();
        assert!(count >= 1 && part.iter().all(|p| (*p as usize) < count), "{part:?}");
    }

    #[test]
    fn a_mesh_wider_than_any_float_has_diameters_all_the_same() {
        let (mut positions, corners, polygon_start) = cube();
        positions.iter_mut().for_each(|p| *p = (*p - 0.5) * f64::MAX * 2.0);
        let (positions, corners, polygon_start) = (&positions, &corners, &polygon_start);
        let input = Input::new(positions, corners, polygon_start);
        let (mut part, mut diameter) = ([0; 7], [f32::NAN; 7]);
        let mut bytes = vec![0; parts_of_polygons_need(&input, &BinnedBuilder)];
        let (out, scratch) = (Parts { part: &mut part, diameter: &mut diameter }, Scratch::new(&mut bytes));
        parts_of_polygons(out, &input, Source::Labels(&[]), &BinnedBuilder, scratch, &Serial, &mut Silent).unwrap();
        assert_eq!(diameter, [f32::MAX, f32::MAX, f32::MAX, f32::MAX, f32::MAX, f32::MAX, 0.0]);
    }

    #[test]
    fn outputs_of_another_length_are_an_error() {
        let (positions, corners, polygon_start) = cube();
        let (positions, corners, polygon_start) = (&positions, &corners, &polygon_start);
        let input = Input::new(positions, corners, polygon_start);
        for (parts, diameters, given) in [(6, 7, 6), (7, 8, 8)] {
            let out = Parts { part: &mut vec![0; parts], diameter: &mut vec![0.0; diameters] };
            let (bvh, scratch) = (&BinnedBuilder, Scratch::new(&mut []));
            let result = parts_of_polygons(out, &input, Source::Labels(&[]), bvh, scratch, &Serial, &mut Silent);
            assert_eq!(result, Err(UnwrapError::BadLength { expected: 7, given }));
        }
    }

    #[test]
    fn too_little_memory_is_an_error() {
        assert!(matches!(run(Source::Labels(&[0; 7]), 1), Err(UnwrapError::Scratch(_))));
    }
}
