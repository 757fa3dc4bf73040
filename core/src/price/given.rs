//! What a file or a caller says of edges: normals that break, weights, cuts that must be.
//!
//! An edge is named by the polygon corner that it leaves, on its way to the next corner of that polygon, so an edge between
//! two polygons has two names. Entries beyond a list say nothing.
//! A shading break hides a seam whatever the turn: normals that differ across the edge at one of its ends or both, or a mark.
//! A file that is shaded flat, face by face, has breaks everywhere and says nothing by them; it is known by its gentle edges.

use crate::base::real::{cos, sqrt};
use crate::mesh::polygons::Polygons;
use crate::mesh::view::{NONE, next};
use crate::mesh::working::{DIAGONAL, Working};
use glam::Vec3;

/// Mark of an edge that is a cut whatever it costs.
pub const CUT: u8 = 1;
/// Mark of an edge at which the shading breaks (a border of smoothing groups, a sharp edge).
pub const BREAK: u8 = 2;

/// Normals that differ by more are two, in degrees: four decimals of a file are 0.01.
const DIFFERENT: f64 = 1.0;
/// Edges that turn by less, in degrees, and by more than [`DIFFERENT`] are gentle.
const GENTLE: f64 = 30.0;
/// A file whose breaks are more than this share of its gentle edges' length is shaded flat.
const FLAT_SHADED: f64 = 0.5;

/// What a mesh comes with. One entry a polygon corner.
#[derive(Clone, Copy, Debug, Default)]
pub struct EdgeData<'a> {
    /// Normal of each corner, of any length; NaN or zero: none.
    pub normals: Option<&'a [Vec3]>, // (c)
    /// What a cut along the edge costs more or less: 0 is free, infinite forbidden, NaN says nothing. Of an edge's two names
    /// the larger weight counts.
    pub weights: Option<&'a [f32]>, // (c)
    /// [`CUT`] and [`BREAK`], under either name.
    pub marks: Option<&'a [u8]>, // (c)
}

/// What is made of shading breaks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HardEdges {
    /// A cut is hardly noticed there.
    #[default]
    Prefer,
    /// Every break is a cut, as baking of normal maps wants it.
    Require,
    /// Normals and marks of breaks count for nothing; the turn of the surface alone does.
    Off,
}

/// The data on a working mesh.
#[derive(Clone, Copy)]
pub struct OnMesh<'a> {
    data: EdgeData<'a>,
    polygons: &'a Polygons<'a>,
    working: &'a Working<'a>,
    same: f32, // least cosine of normals that are one
}

impl<'a> OnMesh<'a> {
    /// `working` is what repair has made of `polygons`, whose corners `data` names.
    pub fn new(data: EdgeData<'a>, polygons: &'a Polygons<'a>, working: &'a Working<'a>) -> Self {
        Self { data, polygons, working, same: cos(DIFFERENT.to_radians()) as f32 }
    }

    /// Whether a cut is asked for along the half-edge of `c`.
    pub fn is_cut(&self, c: u32) -> bool {
        self.marked(c, CUT)
    }

    /// How much of the half-edge of `c` is a break: 0, 1, or 1/2 where only one end has two normals.
    pub fn broken(&self, c: u32) -> f64 {
        let t = self.working.twin[c as usize];
        if t == NONE || self.working.fixed[c as usize] == DIAGONAL {
            return 0.0;
        }
        if self.marked(c, BREAK) {
            return 1.0;
        }
        0.5 * f64::from(u8::from(self.differ(c, next(t))) + u8::from(self.differ(next(c), t)))
    }

    /// Weight of the half-edge of `c`, 1 where nothing is said.
    pub fn weight(&self, c: u32) -> f64 {
        let Some(weights) = self.data.weights else { return 1.0 };
        let said = self.names(c).into_iter().flatten().filter_map(|corner| weights.get(corner as usize));
        let most = said.copied().filter(|w| !w.is_nan()).map(|w| w.max(0.0)).reduce(f32::max);
        f64::from(most.unwrap_or(1.0))
    }

    /// Whether breaks say anything: there are some, and the file is not shaded flat. `turn` is that of each half-edge in degrees.
    pub fn has_breaks(&self, turn: &[f64]) -> bool {
        if self.data.normals.is_none() && self.data.marks.is_none() {
            return false;
        }
        let (mut gentle, mut broken) = (0.0, 0.0);
        for c in 0..turn.len() as u32 {
            if (DIFFERENT..GENTLE).contains(&turn[c as usize]) && self.working.fixed[c as usize] != DIAGONAL {
                let d = self.working.mesh().position(next(c)) - self.working.mesh().position(c);
                let length = sqrt(d.dot(d));
                gentle += length;
                broken += length * self.broken(c);
            }
        }
        broken <= FLAT_SHADED * gentle
    }

    fn marked(&self, c: u32, mark: u8) -> bool {
        let Some(marks) = self.data.marks else { return false };
        let mut said = self.names(c).into_iter().flatten().filter_map(|corner| marks.get(corner as usize));
        said.any(|m| m & mark != 0)
    }

    /// The names of the edge of `c` and of its twin. Diagonals have none.
    fn names(&self, c: u32) -> [Option<u32>; 2] {
        let t = self.working.twin[c as usize];
        [self.name(c), if t == NONE { None } else { self.name(t) }]
    }

    fn name(&self, c: u32) -> Option<u32> {
        let Working { corner_source, polygon, fixed, .. } = self.working;
        if fixed[c as usize] == DIAGONAL {
            return None;
        }
        let p = polygon[c as usize / 3] as usize;
        let [first, end] = [self.polygons.polygon_start[p], self.polygons.polygon_start[p + 1]];
        let follows = |a: u32, b: u32| b == if a + 1 < end { a + 1 } else { first };
        let (a, b) = (corner_source[c as usize], corner_source[next(c) as usize]);
        // A face that is turned round has its edges the other way.
        if follows(a, b) {
            Some(a)
        } else if follows(b, a) {
            Some(b)
        } else {
            None
        }
    }

    /// Whether two working corners have two normals.
    fn differ(&self, a: u32, b: u32) -> bool {
        let Some(normals) = self.data.normals else { return false };
        let normal = |c: u32| normals.get(self.working.corner_source[c as usize] as usize).copied();
        let (Some(p), Some(q)) = (normal(a), normal(b)) else { return false };
        let size = sqrt(p.dot(p)) * sqrt(q.dot(q));
        size > 0.0 && size < f32::INFINITY && p.dot(q) < self.same * size
    }
}
