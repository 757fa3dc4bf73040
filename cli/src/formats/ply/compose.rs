//! A PLY from scratch, for meshes that came in another format: binary, little-endian.
//!
//! Coordinates are floats where floats hold them all, else doubles. Colours are of vertices; so are normals, where every
//! vertex has one at all of its corners. UVs are the list `texcoord` of each face.

use crate::formats::model::Model;
use crate::formats::ply::names::texcoord;
use crate::mesh::polygons::Mesh;
use glam::{DVec2, Vec3};
use std::io::{self, Write};

/// Writes `model` with one UV a corner as set `set`, or without any.
pub fn compose(out: &mut dyn Write, model: &Model, corner_uv: Option<&[DVec2]>, set: u32) -> io::Result<()> {
    let mesh = &model.mesh;
    let singles = mesh.positions.iter().all(|p| p.as_vec3().as_dvec3() == *p);
    let normals = vertex_normals(mesh);
    let most = mesh.polygons().map(|p| p.len()).max().unwrap_or(0);
    let length = if 2 * most <= usize::from(u8::MAX) { "uchar" } else { "int" };
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment made by seamwright\nelement vertex {}\n",
        mesh.positions.len()
    )?;
    let kind = if singles { "float" } else { "double" };
    ["x", "y", "z"].iter().try_for_each(|name| writeln!(out, "property {kind} {name}"))?;
    if normals.is_some() {
        ["nx", "ny", "nz"].iter().try_for_each(|name| writeln!(out, "property float {name}"))?;
    }
    if model.colours.is_some() {
        ["red", "green", "blue", "alpha"].iter().try_for_each(|name| writeln!(out, "property uchar {name}"))?;
    }
    write!(out, "element face {}\nproperty list {length} int vertex_indices\n", mesh.polygon_count())?;
    if corner_uv.is_some() {
        writeln!(out, "property list {length} float {}", texcoord(set))?;
    }
    out.write_all(b"end_header\n")?;

    for (v, p) in mesh.positions.iter().enumerate() {
        for x in p.to_array() {
            if singles { out.write_all(&(x as f32).to_le_bytes())? } else { out.write_all(&x.to_le_bytes())? }
        }
        if let Some(normals) = &normals {
            normals[v].to_array().iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
        }
        if let Some(colours) = &model.colours {
            out.write_all(&colours[v].map(|c| (c * 255.0 + 0.5) as u8))?;
        }
    }
    let count = |out: &mut dyn Write, n: usize| match length {
        "uchar" => out.write_all(&[n as u8]),
        _ => out.write_all(&(n as u32).to_le_bytes()),
    };
    for p in mesh.polygons() {
        count(out, p.len())?;
        mesh.corners[p.clone()].iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
        if let Some(uv) = corner_uv.map(|uv| &uv[p]) {
            count(out, 2 * uv.len())?;
            let numbers =
                uv.iter().map(|uv| if uv.is_finite() { *uv } else { DVec2::ZERO }).flat_map(|uv| uv.to_array());
            numbers.into_iter().try_for_each(|x| out.write_all(&(x as f32 + 0.0).to_le_bytes()))?;
        }
    }
    Ok(())
}

/// The normal of each vertex, where no vertex has two and every corner has one.
pub(super) fn vertex_normals(mesh: &Mesh) -> Option<Vec<Vec3>> {
    let all = mesh.corner_normals.as_ref()?;
    let mut normals = vec![Vec3::ZERO; mesh.positions.len()];
    for (vertex, normal) in mesh.corners.iter().zip(all) {
        let own = &mut normals[*vertex as usize];
        if *own == Vec3::ZERO {
            *own = *normal;
        }
        if *own != *normal || *normal == Vec3::ZERO {
            return None;
        }
    }
    Some(normals)
}

/// What of `model` a PLY does not hold, in words.
pub fn losses(model: &Model) -> Vec<String> {
    let mut losses = Vec::new();
    if model.mesh.corner_normals.is_some() && vertex_normals(&model.mesh).is_none() {
        losses.push("normals, of which some vertices have several".into());
    }
    if model.pieces.iter().any(|piece| !piece.name.is_empty()) {
        losses.push("names of objects".into());
    }
    if model.pieces.iter().any(|piece| piece.material.is_some()) {
        losses.push("materials".into());
    }
    losses
}

#[cfg(test)]
mod tests {
    use super::super::read::read;
    use super::*;
    use crate::formats::reading::Reading;
    use glam::DVec3;

    #[test]
    fn what_is_composed_reads_back() {
        let mesh = Mesh {
            positions: vec![DVec3::new(0.1, 0.0, 0.0), DVec3::X, DVec3::Y, DVec3::ONE],
            corners: vec![0, 1, 3, 2],
            polygon_start: vec![0, 4],
            corner_normals: Some(vec![Vec3::Z, Vec3::X, Vec3::Y, Vec3::Z]),
            ..Mesh::default()
        };
        let colours = Some(vec![[1.0, 0.0, 0.2, 1.0]; 4]);
        let uv = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let mut out = Vec::new();
        compose(&mut out, &Model { colours, ..Model::of(mesh.clone()) }, Some(&uv), 0).unwrap();
        let back = read(out, Reading::default()).unwrap().model;
        assert_eq!((&back.mesh.positions, &back.mesh.corners), (&mesh.positions, &mesh.corners));
        assert_eq!((back.mesh.corner_normals, back.mesh.corner_uv), (mesh.corner_normals, Some(uv.to_vec())));
        assert_eq!(back.colours.unwrap()[2], [1.0, 0.0, 51.0 / 255.0, 1.0]);
    }
}
