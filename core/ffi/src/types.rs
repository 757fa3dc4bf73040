//! The structs that cross the border. Their fields' order is the interface; new ones come last, see `structs`.

use core::ffi::{c_char, c_void};

/// As many charts as hide the seams best.
pub const SEAMWRIGHT_CHARTS_FEW: u32 = 0;
/// One chart a connected piece, where the bound allows it.
pub const SEAMWRIGHT_CHARTS_ONE: u32 = 1;
/// Equal texel density, rotations, shapes in one another's gaps.
pub const SEAMWRIGHT_PACKING_TIGHT: u32 = 0;
/// One cell of a square grid a chart.
pub const SEAMWRIGHT_PACKING_GRID: u32 = 1;
/// A seam is hardly noticed where the shading breaks.
pub const SEAMWRIGHT_HARD_EDGES_PREFER: u32 = 0;
/// Every break of the shading is a cut, as baking of normal maps wants it.
pub const SEAMWRIGHT_HARD_EDGES_REQUIRE: u32 = 1;
/// Breaks count for nothing; the turn of the surface alone does.
pub const SEAMWRIGHT_HARD_EDGES_OFF: u32 = 2;
/// Few noticed seams and a full square, both in their measure.
pub const SEAMWRIGHT_PREFER_BALANCE: u32 = 0;
/// The fewest seams that are noticed: charts may be of any shape.
pub const SEAMWRIGHT_PREFER_SEAMS: u32 = 1;
/// Charts that pack well.
pub const SEAMWRIGHT_PREFER_FILL: u32 = 2;
/// Charts that are strips become rectangles where the bound allows.
pub const SEAMWRIGHT_STRAIGHTEN_AUTO: u32 = 0;
/// Every chart lies as it has least distortion.
pub const SEAMWRIGHT_STRAIGHTEN_OFF: u32 = 1;
/// Strips between sharp edges are cut out to become rectangles too, though more seams may be noticed.
pub const SEAMWRIGHT_STRAIGHTEN_STRIPS: u32 = 2;
/// For `weld`: cracks of the width that is found in the mesh are closed.
pub const SEAMWRIGHT_WELD_AUTO: f64 = -1.0;
/// Every piece has texels of its own.
pub const SEAMWRIGHT_STACK_OFF: u32 = 0;
/// Pieces that are the same shape moved lie over one another.
pub const SEAMWRIGHT_STACK_SAME: u32 = 1;
/// Mirror images do too, and the halves of what is its own mirror image; their UVs are mirrored.
pub const SEAMWRIGHT_STACK_MIRRORED: u32 = 2;
/// Charts lie where packing puts them.
pub const SEAMWRIGHT_SNAP_OFF: u32 = 0;
/// Borders that run along an axis lie on the edges of texels, where the bound allows.
pub const SEAMWRIGHT_SNAP_TEXEL: u32 = 1;
/// Answer of `progress`: the run goes on.
pub const SEAMWRIGHT_GO_ON: i32 = 0;
/// Answer of `progress`: the run ends without a result.
pub const SEAMWRIGHT_STOP: i32 = 1;
/// Answer of `progress`: exposure, seams or pack ends with what there is by now, and what comes after is as short; the atlas is valid.
pub const SEAMWRIGHT_FINISH: i32 = 2;
/// The edge is a cut whatever it costs.
pub const SEAMWRIGHT_EDGE_CUT: u8 = 1;
/// The shading breaks at the edge: a border of smoothing groups, a sharp edge.
pub const SEAMWRIGHT_EDGE_BREAK: u8 = 2;

/// A mesh: polygons over positions. Only read.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SeamwrightMesh {
    /// sizeof(SeamwrightMesh).
    pub struct_size: usize,
    /// (vertex_count, 3), finite.
    pub positions: *const f64,
    /// Vertices.
    pub vertex_count: usize,
    /// (corner_count): the vertex of each polygon corner, polygon after polygon.
    pub corners: *const u32,
    /// Corners of all polygons together.
    pub corner_count: usize,
    /// (polygon_count + 1): the first corner of each polygon, and corner_count. NULL: all are triangles.
    pub polygon_start: *const u32,
    /// Polygons.
    pub polygon_count: usize,
    /// (corner_count, 2): UVs whose borders stay cuts; NaN: none. NULL: no such UVs.
    pub kept_uv: *const f64,
    /// (polygon_count): a part each, whose borders become cuts. NULL: no parts.
    pub parts: *const u32,
    /// (corner_count, 3): the normal of each corner, of any length; NaN or zero: none. Where those of two polygons differ at
    /// their edge, the shading breaks. NULL: no normals.
    pub corner_normals: *const f32,
    /// (corner_count): how much more or less a cut costs along the edge from this corner to the next one of its polygon, as a
    /// factor: 0 is free, infinite forbidden, NaN says nothing. Of an edge's two corners the larger weight counts. NULL: none.
    pub edge_weights: *const f32,
    /// (corner_count): SEAMWRIGHT_EDGE_..., added up, of the same edges, by either corner. NULL: no marks.
    pub edge_marks: *const u8,
    /// How far positions may be from what they stand for: half the last digit of a file. 0: exact, or unknown.
    pub tolerance: f64,
}

/// What can be asked for; `seamwright_defaults` fills it, its size too.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SeamwrightOptions {
    /// sizeof(SeamwrightOptions).
    pub struct_size: usize,
    /// Bound on the mean symmetric Dirichlet energy over 4; above 1, which is an isometry.
    pub distortion: f64,
    /// Seed of every random value.
    pub seed: u64,
    /// Side of the texture in texels, 16 to 65536.
    pub size: u32,
    /// Empty texels between charts, a quarter of the size at the most.
    pub padding: u32,
    /// Exposure rays a vertex, 1 to 65536.
    pub rays: u32,
    /// SEAMWRIGHT_CHARTS_...
    pub charts: u32,
    /// SEAMWRIGHT_PACKING_...
    pub packing: u32,
    /// Search work of tight packing in hundredths, 1000 at the most: 0 only fills, 100 takes up to a second of a desktop's core.
    pub effort: u32,
    /// SEAMWRIGHT_HARD_EDGES_...: what is made of breaks of the shading.
    pub hard_edges: u32,
    /// SEAMWRIGHT_PREFER_...: what is given up where seams and fill are at odds.
    pub prefer: u32,
    /// SEAMWRIGHT_STRAIGHTEN_...: what is made of strips.
    pub straighten: u32,
    /// Further searches for seams, 100 at the most, of which the best is kept.
    pub search: u32,
    /// Cracks up to this share of the mesh's diagonal are closed in the working copy; SEAMWRIGHT_WELD_AUTO: of the width that is
    /// found in the mesh. 0: none.
    pub weld: f64,
    /// SEAMWRIGHT_STACK_...: whether pieces that are alike share texels.
    pub stack: u32,
    /// 1: all but the first of a stack lie one square to the right; 0: upon one another.
    pub stack_offset: u32,
    /// SEAMWRIGHT_SNAP_...: whether charts are fitted to texels.
    pub snap: u32,
    /// 1: `progress` may answer SEAMWRIGHT_FINISH, which takes some memory; 0: it stops the run then.
    pub may_finish: u32,
}

/// Where the atlas is written. After an error its contents are unspecified.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SeamwrightAtlas {
    /// sizeof(SeamwrightAtlas).
    pub struct_size: usize,
    /// (corner_count, 2): the UV of each corner, in [0, 1], multiples of 2^-24.
    pub corner_uv: *mut f64,
    /// (polygon_count): the chart of each polygon from 0; 0xffffffff for a polygon without area.
    pub polygon_chart: *mut u32,
    /// (vertex_count): 1 is open sky, 0 is never seen.
    pub exposure: *mut f32,
}

/// What was done.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SeamwrightReport {
    /// sizeof(SeamwrightReport), by the caller.
    pub struct_size: usize,
    /// Mean symmetric Dirichlet energy over 4, after the best global scale.
    pub distortion: f64,
    /// Share of the unit square that charts cover.
    pub utilisation: f64,
    /// Charts in the atlas.
    pub chart_count: usize,
    /// Connected pieces of surface.
    pub piece_count: usize,
    /// Vertices that stand where another one does.
    pub welded_vertices: usize,
    /// Polygons without a triangle; they have UVs all the same.
    pub dropped_polygons: usize,
    /// Edges that were cut since more than two faces meet there, or two that disagree about the outside.
    pub split_edges: usize,
    /// After an error: see its code. Otherwise 0.
    pub detail: usize,
    /// Edges where a crack was closed.
    pub closed_edges: usize,
    /// 1 where a stage ended early since `progress` answered SEAMWRIGHT_FINISH; 0 where all was done.
    pub ended_early: usize,
}

/// Figures of any UV map. Those over nothing are NaN, energies of collapsed maps infinite.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SeamwrightFigures {
    /// sizeof(SeamwrightFigures), by the caller.
    pub struct_size: usize,
    /// 1 - mean angle error in radians.
    pub conformality: f64,
    /// 1 - mean |ln| of the area error.
    pub equiareality: f64,
    /// Area-weighted mean symmetric Dirichlet energy after the best global scale; 4 is an isometry.
    pub symmetric_dirichlet: f64,
    /// Root mean square stretch; 1 is an isometry.
    pub stretch_l2: f64,
    /// Largest stretch.
    pub stretch_linf: f64,
    /// Length of the seams / sqrt(area).
    pub seam_length: f64,
    /// Sum over seams of length x exposure, / sqrt(area); NaN without exposure.
    pub visible_seam_length: f64,
    /// Mean exposure along seams / along all edges; NaN without exposure.
    pub seam_exposure_ratio: f64,
    /// Overlapped texels / covered ones.
    pub overlap: f64,
    /// Covered texels / those of the UVs' own square.
    pub utilisation: f64,
    /// Charts.
    pub chart_count: usize,
    /// Charts that are no disks.
    pub non_disk_charts: usize,
    /// Triangles with a corner whose UV is not finite.
    pub faces_without_uv: usize,
    /// Triangles turned against their chart, exactly.
    pub flipped_faces: usize,
    /// Triangles whose interior meets another one's, exactly.
    pub overlapping_faces: usize,
    /// After an error: see its code. Otherwise 0.
    pub detail: usize,
    /// Charts that no plane can hold: without a border, or with a handle. Those with holes are none of them.
    pub closed_or_handled_charts: usize,
    /// As `visible_seam_length`, times what is noticed: 1 where the surface turns by up to 10 degrees, 0.1 from 40; NaN
    /// without exposure.
    pub noticed_seam_length: f64,
    /// Share of the seams' length where the surface turns by less than 1 degree.
    pub flat_seam_share: f64,
    /// Share of it where the surface turns by more than 35 degrees.
    pub sharp_seam_share: f64,
    /// Share of the length of such sharp edges that is seam; NaN where there is none.
    pub sharp_seam_cover: f64,
}

/// One of n tasks.
pub type SeamwrightTask = extern "C" fn(context: *mut c_void, index: usize);

/// What the caller offers. A null pointer to it, or a null function in it, is no offer.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SeamwrightHost {
    /// sizeof(SeamwrightHost).
    pub struct_size: usize,
    /// Handed to both functions as it is.
    pub user: *mut c_void,
    /// `done` of `total` steps of a stage ("repair", "exposure", "seams", "pack", "check") are finished. Called on the
    /// calling thread. Answers SEAMWRIGHT_GO_ON, SEAMWRIGHT_STOP or, where the options allow it, SEAMWRIGHT_FINISH; any other stops the run.
    pub progress: Option<extern "C" fn(user: *mut c_void, stage: *const c_char, done: usize, total: usize) -> i32>,
    /// Calls `task(context, i)` exactly once for each i below count, on any threads in any order, and returns when all
    /// are done. It may be called again from within a task. The result does not depend on it.
    pub run: Option<extern "C" fn(user: *mut c_void, count: usize, task: SeamwrightTask, context: *mut c_void)>,
}
