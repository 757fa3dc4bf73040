//! From polygons to a UV atlas: the one place that joins the stages.

pub mod learned;
pub mod order;
pub mod partition;
pub mod pieces;
mod place;
pub mod polygons;
mod tears;
mod training;

use crate::base::progress::{Progress, Stage};
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::workers::Workers;
use crate::charts::pieces::{Pieces, pieces_need};
use crate::finish::fill::{fill_dropped, fill_dropped_need};
use crate::mesh::frame::to_own_frame;
use crate::mesh::normals::{NormalWeight, vertex_normals};
use crate::mesh::repair::{self, Counts, FORCED, Facing, Polygons, RepairError, Working, repair, repair_need};
use crate::mesh::view::NONE;
use crate::pack::{self, pack_need};
use crate::plane::overlap::overlaps_need;
use crate::price::cost::{FORBIDDEN, Prefer, Rates, prices, prices_need};
use crate::price::given::{EdgeData, HardEdges, OnMesh};
use crate::rays::bvh::{BuildBvh, BvhError};
use crate::rays::cast::Scene;
use crate::rays::exposure::{ExposureSettings, exposure, exposure_need};
use crate::search::seams::{Budget, SeamError, make_charts_need};
use glam::{DVec2, DVec3, Vec3};
use learned::{Learning, Scene as Learner, hybrid, neural};
use pieces::unwrap_pieces;
use place::place;

/// The user's mesh: polygons over positions, nothing merged. [`Input::new`] fills what a caller has nothing to say about.
#[derive(Clone, Copy)]
pub struct Input<'a> {
    /// Vertex positions in the user's units; finite.
    pub positions: &'a [DVec3], // (n)
    /// Vertex index of each polygon corner, polygon after polygon.
    pub corners: &'a [u32], // (c)
    /// First corner of each polygon, and the number of corners at the end.
    pub polygon_start: &'a [u32], // (p + 1)
    /// UVs that the file came with, one a corner, whose borders stay cuts (`--keep-seams`). NaN, or beyond the list: no UV.
    pub kept_uv: Option<&'a [DVec2]>, // (c)
    /// Part of each polygon, whose borders become cuts: no chart has faces of two parts, and a piece of a part is one
    /// chart where that can be. Charts are numbered by part, see [`order::order_charts`]. Polygons beyond the list are one
    /// part of their own.
    pub parts: Option<&'a [u32]>, // (p)
    /// What the file or the caller says of edges: normals, weights, cuts.
    pub edges: EdgeData<'a>,
    /// How far positions may be from what they stand for, in the user's units: half the last digit of a file. 0: exact, or
    /// unknown.
    pub tolerance: f64,
}

impl<'a> Input<'a> {
    /// Polygons with nothing said about them.
    pub fn new(positions: &'a [DVec3], corners: &'a [u32], polygon_start: &'a [u32]) -> Self {
        let edges = EdgeData::default();
        Self { positions, corners, polygon_start, kept_uv: None, parts: None, edges, tolerance: 0.0 }
    }

    fn polygons(&self) -> Polygons<'a> {
        let Input { positions, corners, polygon_start, kept_uv, .. } = *self;
        Polygons { positions, corners, polygon_start, kept_uv }
    }
}

/// What makes the map.
pub enum Method<'m, 'a> {
    /// Cuts by exposure and distortion, then flattening; no training.
    Exact,
    /// Trained maps, cut where they tear. They may overlap: the report counts it.
    Neural(&'m mut Learning<'a>),
    /// Trained maps say where the exact stages cut.
    Hybrid(&'m mut Learning<'a>),
}

/// How many charts a connected component may have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Charts {
    /// As many as hide the seams best.
    #[default]
    Few,
    /// One, where overlap-free flattening and the bound allow it.
    One,
}

/// How charts are placed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Packing {
    /// Equal texel density, rotations, shapes in one another's gaps.
    #[default]
    Tight,
    /// One cell of a square grid a chart, each normalised to its cell (DESIGN 4.10).
    Grid,
}

/// What the user can ask for.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Bound on the mean symmetric Dirichlet energy over 4 (1 is an isometry); above 1.
    pub distortion: f64,
    /// Charts a component.
    pub charts: Charts,
    /// Placement.
    pub packing: Packing,
    /// Texture side in texels, for the padding.
    pub size: u32,
    /// Empty texels between charts.
    pub padding: u32,
    /// Search work of tight packing: 0 only fills, 1 takes up to a second of a desktop's core, a microcontroller wants
    /// 0.05. Charts of 13 atlases fill .7285 with 0.8 in 0.59 s of user time.
    pub effort: f64,
    /// Exposure rays a vertex.
    pub rays: u32,
    /// What is made of shading breaks in [`Input::edges`].
    pub hard_edges: HardEdges,
    /// What is given up where seams and fill are at odds.
    pub prefer: Prefer,
    /// Seed of every random value.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            distortion: 1.025,
            charts: Charts::Few,
            packing: Packing::Tight,
            size: 1024,
            padding: 2,
            effort: 1.0,
            rays: 512,
            hard_edges: HardEdges::Prefer,
            prefer: Prefer::Balance,
            seed: 0,
        }
    }
}

impl Settings {
    fn pack(&self) -> pack::Settings {
        let mode = match self.packing {
            Packing::Tight => pack::Mode::Tight,
            Packing::Grid => pack::Mode::Grid,
        };
        pack::Settings { size: self.size, padding: self.padding, mode, seed: self.seed, effort: self.effort }
    }
}

/// Where the atlas is written.
pub struct Output<'a> {
    /// UV of each input corner, in [0, 1]^2, on a grid of 2^-24.
    pub corner_uv: &'a mut [DVec2], // (c)
    /// Chart of each input polygon, 0..chart_count; parts of nothing are `NONE`.
    pub polygon_chart: &'a mut [u32], // (p)
    /// Exposure of each input vertex in [0, 1]; 1 is open.
    pub exposure: &'a mut [f32], // (n)
}

/// What was done.
#[derive(Clone, Copy, Debug, Default)]
pub struct Report {
    /// Charts in the atlas.
    pub chart_count: usize,
    /// Mean symmetric Dirichlet energy over 4, after the best global scale.
    pub distortion: f64,
    /// Share of the unit square that charts cover.
    pub utilisation: f64,
    /// Faces that are not counter-clockwise on the grid; 0 unless they have no area to speak of.
    pub flipped: usize,
    /// Faces that overlap another on the grid: 0, or there is no atlas but one of [`Method::Neural`].
    pub overlapping: usize,
    /// Edges that are cut though a weight forbids them: without, a piece could not be laid flat.
    pub forbidden_cuts: usize,
    /// What was repaired.
    pub repaired: repair::Summary,
}

/// Why there is no atlas. Outputs are unspecified.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnwrapError {
    /// More memory is needed.
    Scratch(ScratchTooSmall),
    /// The progress callback asked to stop.
    Cancelled,
    /// No polygon has three different corners.
    NoTriangle,
    /// A coordinate of this vertex is NaN or infinite.
    NotFinite {
        /// Input vertex.
        vertex: usize,
    },
    /// A corner names a vertex that is not there.
    BadIndex {
        /// Input corner.
        corner: usize,
    },
    /// An output, or a list of learned maps, has not one entry for each that is written to it.
    BadLength {
        /// Entries that would fit.
        expected: usize,
        /// Entries that were there.
        given: usize,
    },
    /// The hierarchy that the caller built does not hold every face once.
    BadTree,
    /// Splitting and packing again and again left faces that overlap: there is no valid atlas to hand over.
    Overlap {
        /// Faces that overlap another.
        faces: usize,
    },
}

impl From<SeamError> for UnwrapError {
    fn from(e: SeamError) -> Self {
        match e {
            SeamError::Scratch(e) => UnwrapError::Scratch(e),
            SeamError::Stopped => UnwrapError::Cancelled,
        }
    }
}

impl From<RepairError> for UnwrapError {
    fn from(e: RepairError) -> Self {
        match e {
            RepairError::Scratch(e) => UnwrapError::Scratch(e),
            RepairError::NotFinite { vertex } => UnwrapError::NotFinite { vertex },
            RepairError::BadIndex { corner } => UnwrapError::BadIndex { corner },
            RepairError::NoTriangle => UnwrapError::NoTriangle,
        }
    }
}

impl From<ScratchTooSmall> for UnwrapError {
    fn from(e: ScratchTooSmall) -> Self {
        UnwrapError::Scratch(e)
    }
}

impl core::fmt::Display for UnwrapError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            UnwrapError::Scratch(e) => e.fmt(f),
            UnwrapError::Cancelled => write!(f, "stopped on request"),
            UnwrapError::NoTriangle => write!(f, "the mesh holds no triangle with three different corners"),
            UnwrapError::NotFinite { vertex } => write!(f, "vertex {vertex} has a coordinate that is not a number"),
            UnwrapError::BadIndex { corner } => write!(f, "corner {corner} names a vertex that does not exist"),
            UnwrapError::Overlap { faces } => write!(f, "{faces} faces of the atlas still overlap after all attempts"),
            UnwrapError::BadLength { expected, given } => write!(f, "{expected} entries expected, {given} given"),
            UnwrapError::BadTree => write!(f, "the ray hierarchy that was handed in is damaged"),
        }
    }
}

impl core::error::Error for UnwrapError {}

/// Rays see vertices on a grid of so many steps a unit of the mesh's own frame, that one or another rounding of the input
/// casts the same rays: 2^24 is f32 as it is, and every hundredth coordinate of a file of 9 digits rounds otherwise; 2^16
/// bends the small faces of a million.
const POSITION_STEPS: f64 = (1 << 20) as f64;
/// The same for normals, which only aim the rays: a step is a 70th of a degree.
const NORMAL_STEPS: f64 = (1 << 12) as f64;
/// Vertices whose exposure is found between two progress reports.
const EXPOSURE_SLICE: usize = 4096;
/// Scratch bytes that [`unwrap`] asks for: an estimate from above for meshes as they occur. Some mesh may need more (more
/// charts than are foreseen, say): [`unwrap`] then stops with [`UnwrapError::Scratch`], whose figures are those of the
/// slice that was missing, not of the whole. A caller that can find more memory tries again with twice as much, which
/// changes no bit of the result. The same figures again, or a `need` of `usize::MAX`, say that no memory would do.
pub fn unwrap_need(input: &Input, settings: &Settings, bvh: &dyn BuildBvh) -> usize {
    need_for(&input.polygons().counts(), settings, bvh)
}

/// [`unwrap_need`] of a mesh that is not there yet.
pub fn need_for(counts: &Counts, settings: &Settings, bvh: &dyn BuildBvh) -> usize {
    let triangles = counts.triangles;
    let vertices = (counts.vertices.max(triangles) + 64).min(3 * triangles);
    let prices = prices_need(triangles);
    let rays = 3 * bytes_for::<DVec3>(vertices) + Scene::need(triangles, bvh) + exposure_need(settings.rays as usize);
    let pieces = pieces_need(triangles) + make_charts_need(triangles, vertices) + 64 * triangles;
    let packing = pack_need(triangles, triangles.min(CHARTS_FORESEEN), &settings.pack()) + overlaps_need(triangles);
    let atlas = pieces_need(triangles) + 17 * 3 * triangles + 4096 + pieces.max(packing + 60 * 3 * triangles);
    repair_need(counts)
        .saturating_add(bytes_for::<DVec3>(vertices) + bytes_for::<f64>(3 * triangles) + bytes_for::<f32>(vertices))
        .saturating_add(rays.max(prices).max(atlas).max(fill_dropped_need(counts)))
}

/// Charts for which [`unwrap_need`] holds packing memory.
const CHARTS_FORESEEN: usize = 4096;

/// Makes the atlas with the exact method.
pub fn unwrap(
    output: Output,
    input: &Input,
    settings: &Settings,
    bvh: &dyn BuildBvh,
    scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<Report, UnwrapError> {
    unwrap_by(Method::Exact, output, input, settings, bvh, scratch, workers, progress)
}

/// Makes the atlas by `method`; those that learn take [`learned::learned_need`] more bytes.
#[allow(clippy::too_many_arguments)]
pub fn unwrap_by(
    method: Method,
    output: Output,
    input: &Input,
    settings: &Settings,
    bvh: &dyn BuildBvh,
    mut scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<Report, UnwrapError> {
    fits(input.corners.len(), output.corner_uv.len())?;
    fits(input.polygon_start.len().saturating_sub(1), output.polygon_chart.len())?;
    fits(input.positions.len(), output.exposure.len())?;
    if let Method::Neural(learning) | Method::Hybrid(learning) = &method {
        learning.check()?;
    }
    scratch.require(unwrap_need(input, settings, bvh))?;
    let polygons = input.polygons();
    report(progress, Stage::Repair, 0, 1)?;
    let (mut working, repaired) = repair(&polygons, Facing::AsGiven, &mut scratch)?;
    let own = scratch.take::<DVec3>(working.positions.len())?;
    let placed = to_own_frame(own, working.positions);
    working.positions = own;
    report(progress, Stage::Repair, 1, 1)?;
    let cost = scratch.take::<f64>(3 * working.faces.len())?;
    let open = scratch.take::<f32>(working.positions.len())?;
    expose(open, &working, settings, bvh, scratch.frame(), workers, progress)?;
    share_exposure(output.exposure, open, &working);
    let is_blind = matches!(&method, Method::Neural(l) if l.is_blind());
    let given = OnMesh::new(input.edges, &polygons, &working);
    let seen = if is_blind { None } else { Some(&*open) };
    let Settings { hard_edges, prefer, .. } = *settings;
    let rates = Rates { hard_edges, prefer, tolerance: input.tolerance / working.extent * placed.scale() };
    prices(cost, &working, &given, rates, seen, scratch.frame())?;
    let mut done = Report { repaired, ..Report::default() };
    let mut frame = scratch.frame();
    let forced = frame.take::<u8>(working.twin.len())?;
    let requires = settings.hard_edges == HardEdges::Require;
    let part = |face: u32| input.parts.map(|p| p.get(working.polygon[face as usize] as usize).copied().unwrap_or(NONE));
    for (h, (out, mark)) in forced.iter_mut().zip(working.fixed).enumerate() {
        let twin = working.twin[h];
        let wanted = || given.is_cut(h as u32) || requires && given.broken(h as u32) > 0.0;
        *out = u8::from(*mark == FORCED || twin != NONE && (part(h as u32 / 3) != part(twin / 3) || wanted()));
    }
    let pieces = Pieces::new(working.mesh(), working.twin, forced, cost, &mut frame)?;
    let uv = frame.take::<DVec2>(working.twin.len())?; // in the order of the pieces
    let cut = frame.take::<u8>(working.twin.len())?;
    let whole = settings.charts == Charts::One;
    let budget = Budget { distortion: settings.distortion, bulky: whole || input.parts.is_some(), whole };
    let total = pieces.count();
    let open = |c: u32| output.exposure[working.vertex_source[working.mesh().vertex(c) as usize] as usize];
    let place_of = |p: DVec3| placed.place((p - working.centre) / working.extent);
    let input_of = |p: DVec3| placed.back(p) * working.extent + working.centre;
    let scene = Learner { pieces: &pieces, open: &open, place_of: &place_of, input_of: &input_of, budget, workers };
    let mends = !matches!(method, Method::Neural(_));
    match method {
        Method::Exact => unwrap_pieces(uv, cut, &pieces, budget, frame.frame(), workers, &mut |p| {
            progress.report(Stage::Seams, p, total).is_continue()
        })?,
        Method::Neural(learning) => neural(uv, cut, &scene, learning, frame.frame(), progress)?,
        Method::Hybrid(learning) => hybrid(uv, cut, &scene, learning, frame.frame(), progress)?,
    }
    done.forbidden_cuts = pieces.cut_count(cut, |cost| cost >= FORBIDDEN);
    report(progress, Stage::Seams, total, total)?;
    place(
        output.corner_uv,
        output.polygon_chart,
        uv,
        cut,
        &pieces,
        &working,
        input.parts,
        settings,
        mends,
        &mut done,
        frame,
        workers,
        progress,
    )?;
    fill_dropped(output.corner_uv, &polygons, &working, scratch)?;
    Ok(done)
}

/// Exposure of each working vertex.
fn expose(
    open: &mut [f32],
    working: &Working,
    settings: &Settings,
    bvh: &dyn BuildBvh,
    mut scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<(), UnwrapError> {
    let mesh = working.mesh();
    let n = mesh.positions.len();
    let exact = scratch.take::<DVec3>(n)?;
    vertex_normals(exact, mesh, NormalWeight::Angle);
    let normals = scratch.take::<Vec3>(n)?;
    normals.iter_mut().zip(exact.iter()).for_each(|(to, from)| *to = on_grid(*from, NORMAL_STEPS));
    let points = scratch.take::<Vec3>(n)?;
    points.iter_mut().zip(mesh.positions).for_each(|(to, from)| *to = on_grid(*from, POSITION_STEPS));
    let scene = Scene::new(points, mesh.faces, bvh, &mut scratch).map_err(|e| match e {
        BvhError::Scratch(e) => UnwrapError::Scratch(e),
        _ => UnwrapError::BadTree,
    })?;
    for first in (0..n).step_by(EXPOSURE_SLICE) {
        report(progress, Stage::Exposure, first, n)?;
        let end = (first + EXPOSURE_SLICE).min(n);
        let rays = ExposureSettings { rays: settings.rays as usize, seed: settings.seed, first, ..Default::default() };
        let (points, normals) = (&points[first..end], &normals[first..end]);
        exposure(&mut open[first..end], points, normals, &scene, &rays, scratch.frame(), workers)?;
    }
    report(progress, Stage::Exposure, n, n)
}

/// Exposure of each input vertex: those at one place share the value of the last working vertex there.
fn share_exposure(exposure_out: &mut [f32], open: &[f32], working: &Working) {
    exposure_out.fill(1.0);
    for (v, source) in working.vertex_source.iter().enumerate() {
        exposure_out[*source as usize] = open[v];
    }
    for v in 0..exposure_out.len() {
        let place = working.welded[v];
        if place != NONE {
            exposure_out[v] = exposure_out[place as usize];
        }
    }
}

/// Nearest point of a grid.
fn on_grid(p: DVec3, steps: f64) -> Vec3 {
    ((p * steps).to_array().map(|x| (real::round(x) / steps) as f32)).into()
}

fn fits(expected: usize, given: usize) -> Result<(), UnwrapError> {
    if expected == given { Ok(()) } else { Err(UnwrapError::BadLength { expected, given }) }
}

fn report(progress: &mut dyn Progress, stage: Stage, done: usize, total: usize) -> Result<(), UnwrapError> {
    if progress.report(stage, done, total).is_break() { Err(UnwrapError::Cancelled) } else { Ok(()) }
}
