//! An OBJ from scratch, for meshes that were not read from one.
//!
//! Coordinates that came as floats are written as floats: the shortest decimal that reads back the same. Colours stand behind
//! the coordinates of their vertices, as most readers know them.

use super::material;
use super::write::{UvTable, write_corner};
use crate::formats::groups::Groups;
use crate::formats::model::Model;
use glam::{DVec2, Vec3};
use std::collections::HashMap;
use std::io::{self, Write};

/// Writes vertices, UVs, normals and polygons, with the object and material of each piece before it and `groups` after
/// these. `library` is the file of materials. A UV that is not finite, and a normal that is none, is left out of its corner.
///
/// Panics unless `corner_uv` has one entry for each corner.
pub fn compose(
    out: &mut dyn Write,
    model: &Model,
    library: Option<&str>,
    corner_uv: &[DVec2],
    groups: Option<&Groups>,
) -> io::Result<()> {
    let mesh = &model.mesh;
    assert_eq!(corner_uv.len(), mesh.corners.len(), "one UV a corner");
    if let Some(library) = library {
        writeln!(out, "mtllib {library}")?;
    }
    for (v, p) in mesh.positions.iter().enumerate() {
        out.write_all(b"v")?;
        p.to_array().iter().try_for_each(|x| write_coordinate(out, *x))?;
        if let Some([r, g, b, _]) = model.colours.as_ref().map(|colours| colours[v].map(material::digits)) {
            write!(out, " {r} {g} {b}")?;
        }
        out.write_all(b"\n")?;
    }
    let table = UvTable::new(corner_uv);
    table.write_lines(out, b"\n")?;
    let normals = NormalTable::new(mesh.corner_normals.as_deref().unwrap_or_default());
    normals.lines.iter().try_for_each(|n| writeln!(out, "vn {} {} {}", n.x, n.y, n.z))?;
    let mut pieces = model.pieces.iter().peekable();
    let mut object = None;
    for (p, polygon) in mesh.polygons().enumerate() {
        let mut changed = false;
        while let Some(piece) = pieces.next_if(|piece| piece.first <= p) {
            if object.replace((piece.mesh, &piece.name)) != Some((piece.mesh, &piece.name)) {
                writeln!(out, "o {}", piece.name)?;
            }
            if let Some(material) = piece.material {
                writeln!(out, "usemtl {}", material::name(model, material))?;
            }
            changed = true;
        }
        if let Some(name) = groups.and_then(|groups| groups.name(p, changed)) {
            writeln!(out, "g {name}")?;
        }
        out.write_all(b"f")?;
        for c in polygon {
            out.write_all(b" ")?;
            let normal = normals.corner_normal.get(c).copied().unwrap_or(0);
            write_corner(out, mesh.corners[c], table.corner_texture[c], normal)?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

fn write_coordinate(out: &mut dyn Write, x: f64) -> io::Result<()> {
    let float = x as f32;
    if f64::from(float) == x { write!(out, " {float}") } else { write!(out, " {x}") }
}

/// The distinct normals of corners, in the order in which they come first.
struct NormalTable {
    lines: Vec<Vec3>,
    corner_normal: Vec<u32>, // (c), from 1; 0: none
}

impl NormalTable {
    fn new(corner_normals: &[Vec3]) -> Self {
        let mut lines = Vec::new();
        let mut line_of: HashMap<[u32; 3], u32> = HashMap::new();
        let corner_normal = corner_normals.iter().map(|n| {
            if *n == Vec3::ZERO || !n.is_finite() {
                return 0;
            }
            *line_of.entry(n.to_array().map(f32::to_bits)).or_insert_with(|| {
                lines.push(*n);
                lines.len() as u32
            })
        });
        let corner_normal = corner_normal.collect();
        Self { lines, corner_normal }
    }
}

#[cfg(test)]
mod tests {
    use super::super::read::read;
    use super::*;
    use crate::formats::model::{Material, Piece};
    use crate::mesh::polygons::Mesh;
    use glam::DVec3;

    #[test]
    fn what_is_composed_reads_back() {
        let mesh = Mesh {
            positions: vec![DVec3::new(0.1f32.into(), 0.1, -1e-30), DVec3::X, DVec3::Y, DVec3::ONE],
            corners: vec![0, 1, 3, 2],
            polygon_start: vec![0, 4],
            corner_uv: Some(vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y]),
            corner_normals: Some(vec![Vec3::Z, Vec3::ZERO, Vec3::X, Vec3::Z]),
            ..Mesh::default()
        };
        let uv = mesh.corner_uv.clone().unwrap();
        let pieces = vec![Piece { name: "a".into(), material: Some(0), ..Piece::default() }];
        let materials = vec![Material { name: "m".into(), ..Material::default() }];
        let colours = Some(vec![[0.5, 0.0, 1.0, 1.0]; 4]);
        let mut out = Vec::new();
        let model = Model { pieces, materials, colours, ..Model::of(mesh.clone()) };
        compose(&mut out, &model, Some("a.mtl"), &uv, None).unwrap();
        let text = String::from_utf8_lossy(&out).into_owned();
        assert!(text.starts_with("mtllib a.mtl\nv 0.1 0.1 -0.") && text.contains(" 0.5 0 1\n"), "{text}");
        assert!(text.contains("\no a\nusemtl m\nf 1/1/1 2/2 4/3/2 3/4/1\n"), "{text}");
        let back = read(out).unwrap().model.mesh;
        assert_eq!(back.positions[0].x as f32, 0.1);
        assert_eq!(back.positions[0].y, 0.1);
        assert_eq!(
            (back.corners, back.polygon_start, back.corner_uv),
            (mesh.corners, mesh.polygon_start, mesh.corner_uv)
        );
    }
}
