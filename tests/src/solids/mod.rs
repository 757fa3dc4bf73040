//! A family of simple solids, thousands by their parameters and a thousand by chance, each with its exact shape.
//!
//! `body` puts polygons together; `round`, `bent`, `outline`, `boxes` and `chance` are the recipes, each with the lists of
//! its parameters; `hull` is what `chance` needs. A name says the kind and then each parameter, so that
//! `cylinder_n64_a0.1_fan_tri_closed` can be made again from its name alone.

pub mod bent;
pub mod body;
pub mod boxes;
pub mod chance;
pub mod hull;
pub mod outline;
pub mod round;

use seamwright::mesh::polygons::Mesh;
use seamwright_core::base::random::hash;
use std::collections::HashSet;
use std::fmt::Write;

/// Those that are kept as files in `fixtures/solids`, for a look at what the family is: lids of thin triangles, a plate with
/// bolt holes, a tetrahedron whose tips are joined by one edge, so that the border of its first map has two corners.
pub const KEPT: [&str; 3] =
    ["cylinder_n32_a0.3_corner_tri_closed", "plate_x4_y3_b8_r0.2_d0.2_quad", "tetrahedron_0045"];

/// What a solid's surface is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Topology {
    /// Connected pieces.
    pub pieces: usize,
    /// Handles of all pieces.
    pub handles: usize,
    /// Border loops of all pieces.
    pub loops: usize,
}

impl Topology {
    /// A sphere with so many holes.
    pub const fn sphere_with(loops: usize) -> Self {
        Self { pieces: 1, handles: 0, loops }
    }

    /// One handle, no border.
    pub const fn torus() -> Self {
        Self { pieces: 1, handles: 1, loops: 0 }
    }
}

/// One of the family, made when asked for.
pub struct Solid {
    /// Kind and parameters.
    pub name: String,
    /// What its surface is.
    pub topology: Topology,
    /// Charts that suffice, where that is promised.
    pub most_charts: Option<usize>,
    make: Box<dyn Fn() -> Mesh + Send + Sync>,
}

impl Solid {
    fn new(name: String, topology: Topology, make: impl Fn() -> Mesh + Send + Sync + 'static) -> Self {
        Self { name, topology, most_charts: None, make: Box::new(make) }
    }

    /// Its mesh.
    pub fn mesh(&self) -> Mesh {
        (self.make)()
    }

    /// The text of an OBJ file that reads as the same mesh, digit for digit.
    pub fn obj(&self) -> String {
        let mesh = self.mesh();
        let mut text = format!("# seamwright solid {}\n", self.name);
        for p in &mesh.positions {
            writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z).expect("writing to a string");
        }
        mesh.polygons().for_each(|at| crate::fixtures::obj::face_line(&mut text, &mesh.corners[at]));
        text
    }
}

/// Every solid that has parameters.
pub fn family() -> Vec<Solid> {
    let mut out = vec![];
    round::family(&mut out);
    bent::family(&mut out);
    outline::family(&mut out);
    boxes::family(&mut out);
    out
}

/// The thousand random ones.
pub fn random() -> Vec<Solid> {
    let mut out = vec![];
    chance::family(&mut out);
    out
}

/// The solid of that name.
pub fn named(name: &str) -> Option<Solid> {
    family().into_iter().chain(random()).find(|solid| solid.name == name)
}

/// Whether `name` is `pattern`, in which a `*` stands for anything.
pub fn matches(name: &str, pattern: &str) -> bool {
    let Some((head, rest)) = pattern.split_once('*') else { return name == pattern };
    name.strip_prefix(head)
        .is_some_and(|tail| (0..=tail.len()).any(|i| tail.is_char_boundary(i) && matches(&tail[i..], rest)))
}

/// A part of `solids` in which any two values that parameters of one kind have together are together somewhere.
pub fn covering(mut solids: Vec<Solid>) -> Vec<Solid> {
    let order = |solid: &Solid| solid.name.bytes().fold(0, |h, b| hash(h, 0, u64::from(b)));
    solids.sort_by_cached_key(order);
    let mut seen = HashSet::new();
    solids.retain(|solid| {
        let words: Vec<&str> = solid.name.split('_').collect();
        let Some((kind, values)) = words.split_first() else { return false };
        let mut is_new = false;
        for (i, value) in values.iter().enumerate() {
            // Each value with each before it, and by itself.
            for other in values[..i].iter().chain([&""]) {
                is_new |= seen.insert([*kind, *other, *value].map(String::from));
            }
        }
        is_new
    });
    solids
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_different_and_find_their_solid() {
        let all: Vec<Solid> = family().into_iter().chain(random()).collect();
        let names: HashSet<&str> = all.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names.len(), all.len());
        assert_eq!(random().len(), 1000);
        KEPT.iter().for_each(|name| assert!(named(name).is_some(), "{name}"));
    }

    #[test]
    fn a_star_in_a_pattern_stands_for_anything() {
        for (pattern, found) in
            [("a_b_c", true), ("*", true), ("a*", true), ("*c", true), ("a*b*c", true), ("a_b_c*", true)]
        {
            assert_eq!(matches("a_b_c", pattern), found, "{pattern}");
        }
        for pattern in ["a_b", "b*", "*b", "a*c*b", "", "a_b_c_*"] {
            assert!(!matches("a_b_c", pattern), "{pattern}");
        }
    }

    #[test]
    fn a_covering_part_is_small_and_has_every_value() {
        let values = |solids: &[Solid]| -> HashSet<(String, String)> {
            let of = |s: &Solid| {
                let kind = s.name.split('_').next().unwrap_or("").to_string();
                s.name.split('_').map(|v| (kind.clone(), v.to_string())).collect::<Vec<_>>()
            };
            solids.iter().flat_map(of).collect()
        };
        let (all, part) = (family(), covering(family()));
        assert_eq!(values(&all), values(&part));
        assert!(4 * part.len() < all.len(), "{} of {}", part.len(), all.len());
    }
}
