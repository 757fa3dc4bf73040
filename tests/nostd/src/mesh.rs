//! A triangle mesh out of the text of an OBJ file, in scratch memory: `v` and `f` lines, nothing else is looked at.

use crate::stages::Failure;
use glam::DVec3;
use seamwright_core::base::scratch::Scratch;

/// Positions and triangles.
#[derive(Clone, Copy)]
pub struct Mesh<'a> {
    /// One a vertex.
    pub positions: &'a [DVec3], // (n)
    /// Vertices of each triangle.
    pub faces: &'a [[u32; 3]], // (f)
}

/// Three numbers of a line that begins with `kind`.
fn numbers<T: core::str::FromStr + Default + Copy>(line: &str, kind: &str) -> Option<Result<[T; 3], Failure>> {
    let mut words = line.strip_prefix(kind)?.split_ascii_whitespace().map(|word| word.parse().ok());
    let row = [(); 3].map(|()| words.next().flatten());
    Some(match row {
        [Some(a), Some(b), Some(c)] => Ok([a, b, c]),
        _ => Err(Failure::Mesh),
    })
}

/// Reads `text`.
pub fn read<'a>(text: &str, scratch: &mut Scratch<'a>) -> Result<Mesh<'a>, Failure> {
    let positions = scratch.take::<DVec3>(text.lines().filter(|line| line.starts_with("v ")).count())?;
    let rows = text.lines().filter_map(|line| numbers::<f64>(line, "v "));
    for (to, row) in positions.iter_mut().zip(rows) {
        *to = DVec3::from_array(row?);
    }
    let faces = scratch.take::<[u32; 3]>(text.lines().filter(|line| line.starts_with("f ")).count())?;
    let rows = text.lines().filter_map(|line| numbers::<u32>(line, "f "));
    for (to, row) in faces.iter_mut().zip(rows) {
        let row = row?;
        if row.iter().any(|v| !(1..=positions.len()).contains(&(*v as usize))) {
            return Err(Failure::Mesh);
        }
        *to = row.map(|v| v - 1);
    }
    Ok(Mesh { positions, faces })
}
