//! The objects and materials of an OBJ: which run of polygons belongs to which.
//!
//! An object is what stands between two `o` lines; in a file without them, between two `g` lines. The same name later in the
//! file is the same object. Names are the rest of their line; bytes that are no UTF-8 are replaced in them.

use crate::formats::model::{Material, Piece};
use std::collections::HashMap;

/// The statements so far that begin a piece.
#[derive(Default)]
pub(super) struct Pieces {
    begun: Vec<(Begins, String, usize)>, // what, its name, the first polygon behind it
}

#[derive(Clone, Copy, PartialEq)]
enum Begins {
    Object,
    Group,
    Material,
}

impl Pieces {
    /// Notes `o`, `g` or `usemtl` with what follows it, before polygon `first`.
    pub fn statement(&mut self, keyword: &[u8], name: &[u8], first: usize) {
        let what = match keyword {
            b"o" => Begins::Object,
            b"g" => Begins::Group,
            _ => Begins::Material,
        };
        self.begun.push((what, String::from_utf8_lossy(name).into_owned(), first));
    }

    /// The pieces of a file of so many polygons, and materials that have nothing but their names.
    pub fn finish(self, polygons: usize) -> (Vec<Piece>, Vec<Material>) {
        let has_objects = self.begun.iter().any(|(what, ..)| *what == Begins::Object);
        let unheard = if has_objects { Begins::Group } else { Begins::Object };
        let begun = self.begun.into_iter().filter(|(what, _, first)| *what != unheard && *first < polygons);
        let (mut meshes, mut looks, mut primitives) = (HashMap::new(), HashMap::new(), HashMap::new());
        let (mut pieces, mut materials) = (Vec::new(), Vec::new());
        let mut now = Piece::default(); // what stands before the first statement
        for (what, name, first) in begun {
            if now.first < first {
                pieces.push(now.clone());
                now.first = first;
            }
            if what == Begins::Material {
                let next = materials.len() as u32;
                let material = *looks.entry(name.clone()).or_insert(next);
                if material == next {
                    materials.push(Material { name, ..Material::default() });
                }
                now.material = Some(material);
            } else {
                let next = meshes.len() as u32 + 1;
                now.mesh = *meshes.entry(name.clone()).or_insert(next);
                now.name = name;
            }
        }
        if now != Piece::default() {
            pieces.push(now);
        }
        for piece in &mut pieces {
            let next = primitives.len() as u32;
            piece.primitive = *primitives.entry((piece.mesh, piece.material)).or_insert(next);
        }
        (pieces, materials)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(statements: &[(&str, &str, usize)]) -> Vec<(usize, String, u32, u32, Option<u32>)> {
        let mut pieces = Pieces::default();
        statements.iter().for_each(|(what, name, first)| pieces.statement(what.as_bytes(), name.as_bytes(), *first));
        pieces.finish(9).0.into_iter().map(|p| (p.first, p.name, p.mesh, p.primitive, p.material)).collect()
    }

    #[test]
    fn an_object_and_a_material_are_one_piece() {
        let found = pieces(&[("o", "a", 0), ("usemtl", "red", 0), ("g", "x", 1), ("usemtl", "blue", 2), ("o", "b", 5)]);
        let expected = [(0, "a", 1, 0, Some(0)), (2, "a", 1, 1, Some(1)), (5, "b", 2, 2, Some(1))];
        assert_eq!(found, expected.map(|(first, name, mesh, primitive, m)| (first, name.into(), mesh, primitive, m)));
    }

    #[test]
    fn the_same_name_later_is_the_same_object_and_polygons_may_stand_before_all() {
        let found = pieces(&[("g", "a", 2), ("g", "b", 3), ("g", "a", 4), ("usemtl", "none", 9)]);
        let expected = [(0, "", 0, 0, None), (2, "a", 1, 1, None), (3, "b", 2, 2, None), (4, "a", 1, 1, None)];
        assert_eq!(found, expected.map(|(first, name, mesh, primitive, m)| (first, name.into(), mesh, primitive, m)));
        assert_eq!(pieces(&[]), []);
    }
}
