//! Labels of a mesh to files: `.seg`, `.json`, coloured `.ply` and `.glb`.
//!
//! Every colour stands for one label. The PLY has the mesh's vertices and polygons in their order and the label beside the
//! colour; the GLB has a primitive and a material of each part, of triangles, over vertices in single precision.

use super::glb;
use super::kind::LabelKind;
use crate::base::colour::part as part_colour;
use crate::mesh::polygons::Mesh;
use std::collections::HashSet;
use std::io::{self, Write};

/// Writes the label of each polygon, 0 and up, in the form that `kind` says. The same bytes for the same labels.
pub fn write(out: &mut dyn Write, kind: LabelKind, mesh: &Mesh, labels: &[u32]) -> io::Result<()> {
    match kind {
        LabelKind::Seg => labels.iter().try_for_each(|l| writeln!(out, "{l}")),
        LabelKind::Json => {
            writeln!(out, "{{")?;
            for (face, label) in labels.iter().enumerate() {
                let end = if face + 1 < labels.len() { "," } else { "" };
                writeln!(out, "  \"{face}\": {label}{end}")?;
            }
            writeln!(out, "}}")
        }
        LabelKind::Ply => ply(out, mesh, labels),
        LabelKind::Glb => glb::write(out, mesh, labels, &colours(labels)),
    }
}

/// A colour of each label up to the highest, all different.
fn colours(labels: &[u32]) -> Vec<[u8; 3]> {
    let count = labels.iter().max().map_or(0, |l| *l as usize + 1);
    let mut used = HashSet::new();
    let distinct = |label| {
        let mut colour = part_colour(label);
        while !used.insert(colour) {
            let [r, g, b] = colour;
            let next = (u32::from(r) << 16 | u32::from(g) << 8 | u32::from(b)) + 1;
            colour = [(next >> 16) as u8, (next >> 8) as u8, next as u8];
        }
        colour
    };
    (0..count as u32).map(distinct).collect()
}

fn ply(out: &mut dyn Write, mesh: &Mesh, labels: &[u32]) -> io::Result<()> {
    let (vertices, faces) = (mesh.positions.len(), mesh.polygon_count());
    write!(
        out,
        "ply\nformat ascii 1.0\ncomment parts by seamwright\nelement vertex {vertices}\nproperty double x\nproperty double y\n\
         property double z\nelement face {faces}\nproperty list int int vertex_indices\nproperty uchar red\n\
         property uchar green\nproperty uchar blue\nproperty int label\nend_header\n"
    )?;
    for p in &mesh.positions {
        writeln!(out, "{} {} {}", p.x, p.y, p.z)?;
    }
    let colours = colours(labels);
    for (corners, label) in mesh.polygons().zip(labels) {
        write!(out, "{}", corners.len())?;
        mesh.corners[corners].iter().try_for_each(|v| write!(out, " {v}"))?;
        let [r, g, b] = colours[*label as usize];
        writeln!(out, " {r} {g} {b} {label}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn colours_of_many_labels_are_all_different() {
        let all = colours(&[99_999]);
        assert_eq!((all.len(), all.iter().collect::<HashSet<_>>().len()), (100_000, 100_000));
        assert!(colours(&[]).is_empty());
    }

    #[test]
    fn what_is_written_reads_back() {
        let positions = (0..6).map(|i| DVec3::new((i % 3) as f64 / 3.0, (i / 3) as f64, 0.1)).collect();
        let mesh =
            Mesh { positions, corners: vec![0, 1, 4, 3, 1, 2, 5, 4], polygon_start: vec![0, 4, 8], ..Mesh::default() };
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.seg", "a.json", "a.ply", "a.glb"] {
            let path = folder.path().join(name);
            let mut out = Vec::new();
            write(&mut out, LabelKind::of(&path).unwrap(), &mesh, &[1, 0]).unwrap();
            std::fs::write(&path, &out).unwrap();
            let back = super::super::read::read("--labels", &path, &mesh, &path).unwrap();
            let swapped = name == "a.glb"; // colours in their own order
            assert!(back.label == [1, 0] || swapped && back.label == [0, 1], "{name}: {back:?}");
            assert_eq!(back.names.len(), 2, "{name}");
        }
    }
}
