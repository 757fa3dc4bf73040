//! Whether a mesh is another with other UVs.
//!
//! Faces are compared in their order, corner by corner, by place. A format may hold positions as floats of 32 bits, a text
//! as decimals that read back as these floats alone, and cut polygons into triangles, which then take the polygon's place.

use super::fault::Fault;
use crate::mesh::polygons::Mesh;
use glam::DVec3;
use std::collections::HashMap;

fn is_at(input: DVec3, output: DVec3) -> bool {
    let [a, b] = [input, output].map(DVec3::as_vec3);
    input == output || a == b && a.is_finite()
}

fn is_face(input: &Mesh, i: usize, output: &Mesh, o: usize) -> bool {
    if i >= input.polygon_count() || o >= output.polygon_count() {
        return false;
    }
    let at = |mesh: &Mesh, c: usize| mesh.positions[mesh.corners[c] as usize];
    let (a, b) = (input.polygon(i), output.polygon(o));
    a.len() == b.len() && a.zip(b).all(|(a, b)| is_at(at(input, a), at(output, b)))
}

/// Whether the triangles of `output` from `o` on are face `i` of `input`: their sides, less those that cancel, are its sides.
fn is_cut(input: &Mesh, i: usize, output: &Mesh, o: usize) -> bool {
    let outline = input.polygon(i);
    let count = outline.len().saturating_sub(2);
    if count < 2 || o + count > output.polygon_count() {
        return false;
    }
    let key = |p: DVec3| (p.as_vec3() + 0.0).to_array().map(f32::to_bits);
    let mut sides: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
    let mut add = |mesh: &Mesh, face: core::ops::Range<usize>, sign: i32| {
        let at = |c: usize| key(mesh.positions[mesh.corners[c] as usize]);
        for c in face.clone() {
            let next = if c + 1 == face.end { face.start } else { c + 1 };
            let (a, b) = (at(c), at(next));
            let (side, sign) = if a <= b { ([a, b], sign) } else { ([b, a], -sign) };
            *sides.entry(side).or_default() += sign;
        }
    };
    add(input, outline, -1);
    for t in o..o + count {
        if output.polygon(t).len() != 3 {
            return false;
        }
        add(output, output.polygon(t), 1);
    }
    sides.into_iter().all(|([a, b], sum)| sum == 0 || a == b)
}

/// Adds a fault for each face, up to `most` in all, by which `output` is not `input`.
pub(super) fn check(input: &Mesh, output: &Mesh, most: usize, faults: &mut Vec<Fault>) {
    let (mut i, mut o) = (0, 0);
    while (i < input.polygon_count() || o < output.polygon_count()) && faults.len() < most {
        if is_face(input, i, output, o) {
            (i, o) = (i + 1, o + 1);
        } else if i < input.polygon_count() && is_cut(input, i, output, o) {
            (i, o) = (i + 1, o + input.polygon(i).len() - 2);
        } else if o >= output.polygon_count() || is_face(input, i + 1, output, o) {
            faults.push(Fault::Missing(i as u32));
            i += 1;
        } else if i >= input.polygon_count() || is_face(input, i, output, o + 1) {
            faults.push(Fault::Added(o as u32));
            o += 1;
        } else {
            faults.push(Fault::Changed(o as u32));
            (i, o) = (i + 1, o + 1);
        }
    }
}
