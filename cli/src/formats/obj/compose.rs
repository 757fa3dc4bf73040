//! An OBJ from scratch, for meshes that were not read from one.
//!
//! Coordinates that came as floats are written as floats: the shortest decimal that reads back the same.

use super::write::{UvTable, write_corner};
use crate::formats::groups::Groups;
use crate::formats::model::Model;
use glam::DVec2;
use std::io::{self, Write};

/// Writes vertices, UVs and polygons, with the object and material of each piece before it and `groups` after these. A UV
/// that is not finite is left out of its corner.
///
/// Panics unless `corner_uv` has one entry for each corner.
pub fn compose(out: &mut dyn Write, model: &Model, corner_uv: &[DVec2], groups: Option<&Groups>) -> io::Result<()> {
    let mesh = &model.mesh;
    assert_eq!(corner_uv.len(), mesh.corners.len(), "one UV a corner");
    for p in &mesh.positions {
        out.write_all(b"v")?;
        p.to_array().iter().try_for_each(|x| write_coordinate(out, *x))?;
        out.write_all(b"\n")?;
    }
    let table = UvTable::new(corner_uv);
    table.write_lines(out, b"\n")?;
    let mut pieces = model.pieces.iter().peekable();
    for (p, polygon) in mesh.polygons().enumerate() {
        let mut changed = false;
        while let Some(piece) = pieces.next_if(|piece| piece.first <= p) {
            writeln!(out, "o {}", piece.name)?;
            let material = piece.material.map(|m| &model.materials[m as usize].name);
            if let Some(name) = material.filter(|name| !name.is_empty()) {
                writeln!(out, "usemtl {name}")?;
            }
            changed = true;
        }
        if let Some(name) = groups.and_then(|groups| groups.name(p, changed)) {
            writeln!(out, "g {name}")?;
        }
        out.write_all(b"f")?;
        for c in polygon {
            out.write_all(b" ")?;
            write_corner(out, mesh.corners[c], table.corner_texture[c], 0)?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

fn write_coordinate(out: &mut dyn Write, x: f64) -> io::Result<()> {
    let float = x as f32;
    if f64::from(float) == x { write!(out, " {float}") } else { write!(out, " {x}") }
}

#[cfg(test)]
mod tests {
    use super::super::read::read;
    use super::*;
    use crate::formats::model::Piece;
    use crate::mesh::polygons::Mesh;
    use glam::DVec3;

    #[test]
    fn what_is_composed_reads_back() {
        let mesh = Mesh {
            positions: vec![DVec3::new(0.1f32.into(), 0.1, -1e-30), DVec3::X, DVec3::Y, DVec3::ONE],
            corners: vec![0, 1, 3, 2],
            polygon_start: vec![0, 4],
            corner_uv: Some(vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y]),
            ..Mesh::default()
        };
        let mut out = Vec::new();
        let uv = mesh.corner_uv.clone().unwrap();
        let pieces = vec![Piece { name: "a".into(), ..Piece::default() }];
        compose(&mut out, &Model { pieces, ..Model::of(mesh.clone()) }, &uv, None).unwrap();
        let back = read(out).unwrap().model.mesh;
        assert_eq!(back.positions[0].x as f32, 0.1);
        assert_eq!(back.positions[0].y, 0.1);
        assert_eq!(
            (back.corners, back.polygon_start, back.corner_uv),
            (mesh.corners, mesh.polygon_start, mesh.corner_uv)
        );
    }
}
