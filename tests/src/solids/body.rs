//! A solid under construction: rings of vertices, the bands between them, the lids over them.
//!
//! A ring is listed counter-clockwise as its lid is seen from outside; a band runs from a lower ring to an upper one and
//! faces outwards where both are counter-clockwise seen from above. Vertices are shared, never doubled.

use glam::{DVec2, DVec3};
use seamwright::mesh::polygons::Mesh;
use seamwright_core::base::real;
use std::f64::consts::TAU;
use std::fmt;

/// What walls are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Quads.
    Quad,
    /// Two triangles a quad.
    Tri,
}

/// What a flat lid is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lid {
    /// One polygon.
    Ngon,
    /// Triangles around a vertex in the middle.
    Fan,
    /// Triangles from the first corner of the rim: for convex rims.
    Corner,
    /// Triangles by clipping ears: for any rim in a plane of constant z.
    Ears,
}

impl fmt::Display for Sides {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Sides::Quad => "quad",
            Sides::Tri => "tri",
        })
    }
}

impl fmt::Display for Lid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Lid::Ngon => "ngon",
            Lid::Fan => "fan",
            Lid::Corner => "corner",
            Lid::Ears => "ears",
        })
    }
}

/// Vertices and polygons so far.
#[derive(Default)]
pub struct Body {
    positions: Vec<DVec3>,
    polygons: Vec<Vec<u32>>,
}

/// Point `i` of `n` on a circle around the origin.
pub fn on_circle(i: u32, n: u32, radius: f64) -> DVec2 {
    let angle = f64::from(i) * TAU / f64::from(n);
    DVec2::new(real::cos(angle), real::sin(angle)) * radius
}

/// A regular polygon around the origin.
pub fn circle(n: u32, radius: f64) -> Vec<DVec2> {
    (0..n).map(|i| on_circle(i, n, radius)).collect()
}

impl Body {
    /// Adds a vertex.
    pub fn point(&mut self, p: DVec3) -> u32 {
        self.positions.push(p);
        self.positions.len() as u32 - 1
    }

    /// Adds a vertex for each point of `outline` at height `z`.
    pub fn ring(&mut self, outline: &[DVec2], z: f64) -> Vec<u32> {
        outline.iter().map(|p| self.point(p.extend(z))).collect()
    }

    /// Adds a polygon.
    pub fn face(&mut self, corners: &[u32]) {
        self.polygons.push(corners.to_vec());
    }

    /// Adds a polygon of four corners, or two triangles.
    pub fn quad(&mut self, [a, b, c, d]: [u32; 4], sides: Sides) {
        match sides {
            Sides::Quad => self.face(&[a, b, c, d]),
            Sides::Tri => {
                self.face(&[a, b, c]);
                self.face(&[a, c, d]);
            }
        }
    }

    /// Adds the wall between two closed rings of as many vertices.
    pub fn band(&mut self, low: &[u32], high: &[u32], sides: Sides) {
        for i in 0..low.len() {
            let j = (i + 1) % low.len();
            self.quad([low[i], low[j], high[j], high[i]], sides);
        }
    }

    /// Adds the walls through all of `rings`, from the lowest up.
    pub fn bands(&mut self, rings: &[Vec<u32>], sides: Sides) {
        rings.windows(2).for_each(|pair| self.band(&pair[0], &pair[1], sides));
    }

    /// Adds triangles from a ring up to an apex.
    pub fn tip(&mut self, rim: &[u32], apex: u32) {
        (0..rim.len()).for_each(|i| self.face(&[rim[i], rim[(i + 1) % rim.len()], apex]));
    }

    /// Adds a lid over `rim`.
    pub fn lid(&mut self, rim: &[u32], lid: Lid) {
        match lid {
            Lid::Ngon => self.face(rim),
            Lid::Corner => (1..rim.len() - 1).for_each(|i| self.face(&[rim[0], rim[i], rim[i + 1]])),
            Lid::Fan => {
                let sum: DVec3 = rim.iter().map(|v| self.positions[*v as usize]).sum();
                let middle = self.point(sum / rim.len() as f64);
                self.tip(rim, middle);
            }
            Lid::Ears => self.ears(rim),
        }
    }

    /// Adds a lid over `rim` turned round: one that is counter-clockwise from the other side.
    pub fn floor(&mut self, rim: &[u32], lid: Lid) {
        let turned: Vec<u32> = rim.iter().rev().copied().collect();
        self.lid(&turned, lid);
    }

    /// Adds triangles between two rings in one plane that lie in one another, whatever their numbers of vertices: both
    /// counter-clockwise as the triangles are seen from outside, beginning at about the same angle.
    pub fn stitch(&mut self, outer: &[u32], inner: &[u32]) {
        let (mut i, mut j) = (0, 0);
        while i < outer.len() || j < inner.len() {
            let (a, b) = (outer[i % outer.len()], inner[j % inner.len()]);
            // The ring goes on whose next side has its middle first, so that no triangle reaches over the inner ring.
            if j == inner.len() || (i < outer.len() && (2 * i + 1) * inner.len() <= (2 * j + 1) * outer.len()) {
                i += 1;
                self.face(&[a, outer[i % outer.len()], b]);
            } else {
                j += 1;
                self.face(&[a, inner[j % inner.len()], b]);
            }
        }
    }

    /// The same, seen from the other side.
    pub fn stitch_below(&mut self, outer: &[u32], inner: &[u32]) {
        let turned = |ring: &[u32]| ring[..1].iter().chain(ring[1..].iter().rev()).copied().collect::<Vec<u32>>();
        self.stitch(&turned(outer), &turned(inner));
    }

    /// Ears of a rim without crossings, the widest first, so that few are thin (Meisters 1975).
    fn ears(&mut self, rim: &[u32]) {
        let at = |v: u32| self.positions[v as usize].truncate();
        let area: f64 = (0..rim.len()).map(|i| at(rim[i]).perp_dot(at(rim[(i + 1) % rim.len()]))).sum();
        let side = |a: u32, b: u32, c: u32| (at(b) - at(a)).perp_dot(at(c) - at(a)) * area.signum();
        let mut left = rim.to_vec();
        let mut found = vec![];
        while left.len() > 3 {
            let n = left.len();
            let corner = |i: usize| [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
            let is_ear = |[a, b, c]: [u32; 3]| {
                let holds = |v: &u32| {
                    ![a, b, c].contains(v) && side(a, b, *v) >= 0.0 && side(b, c, *v) >= 0.0 && side(c, a, *v) >= 0.0
                };
                side(a, b, c) > 0.0 && !left.iter().any(holds)
            };
            // Height over the new edge against its length.
            let shape = |[a, b, c]: [u32; 3]| side(a, b, c) / (at(c) - at(a)).length_squared();
            let ears = (0..n).filter(|i| is_ear(corner(*i)));
            let best = ears.max_by(|i, j| shape(corner(*i)).total_cmp(&shape(corner(*j))).then(j.cmp(i)));
            let best = best.expect("a polygon without crossings has an ear");
            found.push(corner(best));
            left.remove(best);
        }
        found.push([left[0], left[1], left[2]]);
        found.iter().for_each(|ear| self.face(ear));
    }

    /// Turns polygons round that look towards the origin: for solids that are convex around it.
    pub fn facing_out(mut self) -> Self {
        for polygon in &mut self.polygons {
            let [a, b, c] = [0, 1, 2].map(|i| self.positions[polygon[i] as usize]);
            if (b - a).cross(c - a).dot(a) < 0.0 {
                polygon.reverse();
            }
        }
        self
    }

    /// The mesh.
    pub fn mesh(self) -> Mesh {
        crate::shapes::mesh(self.positions, &self.polygons)
    }
}
