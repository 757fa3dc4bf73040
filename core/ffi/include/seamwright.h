/* seamwright: a UV atlas of a mesh, in the caller's memory. Generated from core/ffi/src by
   `cargo run -p seamwright-tests --bin header`; do not edit.

   Every function that answers int32_t answers SEAMWRIGHT_OK or another of the codes below. Nothing is allocated, nothing
   is kept between calls, and no thread is started; different threads may call at the same time with different buffers.
   Pointers point to as much as is said beside them, and nobody else writes there during a call; what can be checked is.
   Shapes stand in brackets: (n, 3) is n times 3 values, row after row.

   Every struct begins with its sizeof, so that it can grow at its end. `SeamwrightMesh mesh = SEAMWRIGHT_MESH_INIT;` says it
   and leaves the rest 0 and NULL, which say nothing; all structs have such a macro but the options, which
   `seamwright_defaults` fills. A program that was compiled with an older header may so use a newer library: what its structs
   lack counts as 0, or is not written. So may one with a newer header use an older library, where it says nothing that
   library does not know (SEAMWRIGHT_NEWER_STRUCT); figures that it does not know stay as they were. */

#ifndef SEAMWRIGHT_H
#define SEAMWRIGHT_H

#include <stddef.h>
#include <stdint.h>

// Number of this interface. It changes when a struct, a function or a code does, but not when one is added, or a field at
// a struct's end.
#define SEAMWRIGHT_INTERFACE 2

// Done.
#define SEAMWRIGHT_OK 0

// A pointer is null where something is needed.
#define SEAMWRIGHT_NULL 1

// A pointer is not aligned for what it points to.
#define SEAMWRIGHT_MISALIGNED 2

// A buffer that is written shares bytes with another one.
#define SEAMWRIGHT_SHARED 3

// A count is larger than 32-bit corner numbers or the address space reach.
#define SEAMWRIGHT_TOO_LARGE 4

// Triangles were promised, but `corner_count` is not 3 `polygon_count`; or `polygon_start` does not begin with 0, falls,
// or does not end with `corner_count`. `detail`: the polygon.
#define SEAMWRIGHT_BAD_POLYGONS 5

// A corner names a vertex that is not there. `detail`: the corner.
#define SEAMWRIGHT_BAD_INDEX 6

// A coordinate of a vertex is NaN or infinite. `detail`: the vertex.
#define SEAMWRIGHT_NOT_FINITE 7

// No polygon has three different corners.
#define SEAMWRIGHT_NO_TRIANGLE 8

// `distortion` is not a number above 1.
#define SEAMWRIGHT_BAD_DISTORTION 9

// `size` is not from 16 to 65536, or `padding` is more than a quarter of it.
#define SEAMWRIGHT_BAD_SIZE 10

// `rays` is not from 1 to 65536.
#define SEAMWRIGHT_BAD_RAYS 11

// `charts`, `packing`, `hard_edges`, `prefer`, `straighten` or `stack` is none of their constants, `stack_offset` above 1, or `weld` neither its
// own nor 0 to 0.01.
#define SEAMWRIGHT_BAD_CHOICE 12

// More scratch memory is needed. `detail`: bytes to try next, which changes no bit of the result; 0: no amount would do.
#define SEAMWRIGHT_SCRATCH 13

// The progress callback asked to stop.
#define SEAMWRIGHT_CANCELLED 14

// Faces of the atlas still overlap after all attempts; please report the mesh. `detail`: how many.
#define SEAMWRIGHT_OVERLAP 15

// `effort` is more than 1000, or `search` more than 100.
#define SEAMWRIGHT_BAD_EFFORT 16

// A fault of this library; please report it.
#define SEAMWRIGHT_INTERNAL 17

// `struct_size` is no sizeof of that struct: 0, less than its first version had, not a multiple of sizeof(size_t), or more
// than 4096. `detail`: its sizeof in this library.
#define SEAMWRIGHT_BAD_STRUCT 18

// A struct of a newer header says something that this library does not know: bytes behind its last known field are not 0.
// `detail`: how many bytes are known.
#define SEAMWRIGHT_NEWER_STRUCT 19

// As many charts as hide the seams best.
#define SEAMWRIGHT_CHARTS_FEW 0

// One chart a connected piece, where the bound allows it.
#define SEAMWRIGHT_CHARTS_ONE 1

// Equal texel density, rotations, shapes in one another's gaps.
#define SEAMWRIGHT_PACKING_TIGHT 0

// One cell of a square grid a chart.
#define SEAMWRIGHT_PACKING_GRID 1

// A seam is hardly noticed where the shading breaks.
#define SEAMWRIGHT_HARD_EDGES_PREFER 0

// Every break of the shading is a cut, as baking of normal maps wants it.
#define SEAMWRIGHT_HARD_EDGES_REQUIRE 1

// Breaks count for nothing; the turn of the surface alone does.
#define SEAMWRIGHT_HARD_EDGES_OFF 2

// Few noticed seams and a full square, both in their measure.
#define SEAMWRIGHT_PREFER_BALANCE 0

// The fewest seams that are noticed: charts may be of any shape.
#define SEAMWRIGHT_PREFER_SEAMS 1

// Charts that pack well.
#define SEAMWRIGHT_PREFER_FILL 2

// Charts that are strips become rectangles where the bound allows.
#define SEAMWRIGHT_STRAIGHTEN_AUTO 0

// Every chart lies as it has least distortion.
#define SEAMWRIGHT_STRAIGHTEN_OFF 1

// Strips between sharp edges are cut out to become rectangles too, though more seams may be noticed.
#define SEAMWRIGHT_STRAIGHTEN_STRIPS 2

// For `weld`: cracks of the width that is found in the mesh are closed.
#define SEAMWRIGHT_WELD_AUTO -1.0

// Every piece has texels of its own.
#define SEAMWRIGHT_STACK_OFF 0

// Pieces that are the same shape moved lie over one another.
#define SEAMWRIGHT_STACK_SAME 1

// Mirror images do too, and the halves of what is its own mirror image; their UVs are mirrored.
#define SEAMWRIGHT_STACK_MIRRORED 2

// Charts lie where packing puts them.
#define SEAMWRIGHT_SNAP_OFF 0

// Borders that run along an axis lie on the edges of texels, where the bound allows.
#define SEAMWRIGHT_SNAP_TEXEL 1

// Answer of `progress`: the run goes on.
#define SEAMWRIGHT_GO_ON 0

// Answer of `progress`: the run ends without a result.
#define SEAMWRIGHT_STOP 1

// Answer of `progress`: exposure, seams or pack ends with what there is by now, and what comes after is as short; the atlas is valid.
#define SEAMWRIGHT_FINISH 2

// The edge is a cut whatever it costs.
#define SEAMWRIGHT_EDGE_CUT 1

// The shading breaks at the edge: a border of smoothing groups, a sharp edge.
#define SEAMWRIGHT_EDGE_BREAK 2

// A mesh: polygons over positions. Only read.
typedef struct SeamwrightMesh {
    // sizeof(SeamwrightMesh).
    size_t struct_size;
    // (vertex_count, 3), finite.
    const double *positions;
    // Vertices.
    size_t vertex_count;
    // (corner_count): the vertex of each polygon corner, polygon after polygon.
    const uint32_t *corners;
    // Corners of all polygons together.
    size_t corner_count;
    // (polygon_count + 1): the first corner of each polygon, and corner_count. NULL: all are triangles.
    const uint32_t *polygon_start;
    // Polygons.
    size_t polygon_count;
    // (corner_count, 2): UVs whose borders stay cuts; NaN: none. NULL: no such UVs.
    const double *kept_uv;
    // (polygon_count): a part each, whose borders become cuts. NULL: no parts.
    const uint32_t *parts;
    // (corner_count, 3): the normal of each corner, of any length; NaN or zero: none. Where those of two polygons differ at
    // their edge, the shading breaks. NULL: no normals.
    const float *corner_normals;
    // (corner_count): how much more or less a cut costs along the edge from this corner to the next one of its polygon, as a
    // factor: 0 is free, infinite forbidden, NaN says nothing. Of an edge's two corners the larger weight counts. NULL: none.
    const float *edge_weights;
    // (corner_count): SEAMWRIGHT_EDGE_..., added up, of the same edges, by either corner. NULL: no marks.
    const uint8_t *edge_marks;
    // How far positions may be from what they stand for: half the last digit of a file. 0: exact, or unknown.
    double tolerance;
} SeamwrightMesh;
#define SEAMWRIGHT_MESH_INIT {sizeof(SeamwrightMesh), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

// Figures of any UV map. Those over nothing are NaN, energies of collapsed maps infinite.
typedef struct SeamwrightFigures {
    // sizeof(SeamwrightFigures), by the caller.
    size_t struct_size;
    // 1 - mean angle error in radians.
    double conformality;
    // 1 - mean |ln| of the area error.
    double equiareality;
    // Area-weighted mean symmetric Dirichlet energy after the best global scale; 4 is an isometry.
    double symmetric_dirichlet;
    // Root mean square stretch; 1 is an isometry.
    double stretch_l2;
    // Largest stretch.
    double stretch_linf;
    // Length of the seams / sqrt(area).
    double seam_length;
    // Sum over seams of length x exposure, / sqrt(area); NaN without exposure.
    double visible_seam_length;
    // Mean exposure along seams / along all edges; NaN without exposure.
    double seam_exposure_ratio;
    // Overlapped texels / covered ones.
    double overlap;
    // Covered texels / those of the UVs' own square.
    double utilisation;
    // Charts.
    size_t chart_count;
    // Charts that are no disks.
    size_t non_disk_charts;
    // Triangles with a corner whose UV is not finite.
    size_t faces_without_uv;
    // Triangles turned against their chart, exactly.
    size_t flipped_faces;
    // Triangles whose interior meets another one's, exactly.
    size_t overlapping_faces;
    // After an error: see its code. Otherwise 0.
    size_t detail;
    // Charts that no plane can hold: without a border, or with a handle. Those with holes are none of them.
    size_t closed_or_handled_charts;
    // As `visible_seam_length`, times what is noticed: 1 where the surface turns by up to 10 degrees, 0.1 from 40; NaN
    // without exposure.
    double noticed_seam_length;
    // Share of the seams' length where the surface turns by less than 1 degree.
    double flat_seam_share;
    // Share of it where the surface turns by more than 35 degrees.
    double sharp_seam_share;
    // Share of the length of such sharp edges that is seam; NaN where there is none.
    double sharp_seam_cover;
} SeamwrightFigures;
#define SEAMWRIGHT_FIGURES_INIT {sizeof(SeamwrightFigures), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

// What can be asked for; `seamwright_defaults` fills it, its size too.
typedef struct SeamwrightOptions {
    // sizeof(SeamwrightOptions).
    size_t struct_size;
    // Bound on the mean symmetric Dirichlet energy over 4; above 1, which is an isometry.
    double distortion;
    // Seed of every random value.
    uint64_t seed;
    // Side of the texture in texels, 16 to 65536.
    uint32_t size;
    // Empty texels between charts, a quarter of the size at the most.
    uint32_t padding;
    // Exposure rays a vertex, 1 to 65536.
    uint32_t rays;
    // SEAMWRIGHT_CHARTS_...
    uint32_t charts;
    // SEAMWRIGHT_PACKING_...
    uint32_t packing;
    // Search work of tight packing in hundredths, 1000 at the most: 0 only fills, 100 takes up to a second of a desktop's core.
    uint32_t effort;
    // SEAMWRIGHT_HARD_EDGES_...: what is made of breaks of the shading.
    uint32_t hard_edges;
    // SEAMWRIGHT_PREFER_...: what is given up where seams and fill are at odds.
    uint32_t prefer;
    // SEAMWRIGHT_STRAIGHTEN_...: what is made of strips.
    uint32_t straighten;
    // Further searches for seams, 100 at the most, of which the best is kept.
    uint32_t search;
    // Cracks up to this share of the mesh's diagonal are closed in the working copy; SEAMWRIGHT_WELD_AUTO: of the width that is
    // found in the mesh. 0: none.
    double weld;
    // SEAMWRIGHT_STACK_...: whether pieces that are alike share texels.
    uint32_t stack;
    // 1: all but the first of a stack lie one square to the right; 0: upon one another.
    uint32_t stack_offset;
    // SEAMWRIGHT_SNAP_...: whether charts are fitted to texels.
    uint32_t snap;
    // 1: `progress` may answer SEAMWRIGHT_FINISH, which takes some memory; 0: it stops the run then.
    uint32_t may_finish;
} SeamwrightOptions;

// Where the atlas is written. After an error its contents are unspecified.
typedef struct SeamwrightAtlas {
    // sizeof(SeamwrightAtlas).
    size_t struct_size;
    // (corner_count, 2): the UV of each corner, in [0, 1], multiples of 2^-24.
    double *corner_uv;
    // (polygon_count): the chart of each polygon from 0; 0xffffffff for a polygon without area.
    uint32_t *polygon_chart;
    // (vertex_count): 1 is open sky, 0 is never seen.
    float *exposure;
} SeamwrightAtlas;
#define SEAMWRIGHT_ATLAS_INIT {sizeof(SeamwrightAtlas), 0, 0, 0}

// What was done.
typedef struct SeamwrightReport {
    // sizeof(SeamwrightReport), by the caller.
    size_t struct_size;
    // Mean symmetric Dirichlet energy over 4, after the best global scale.
    double distortion;
    // Share of the unit square that charts cover.
    double utilisation;
    // Charts in the atlas.
    size_t chart_count;
    // Connected pieces of surface.
    size_t piece_count;
    // Vertices that stand where another one does.
    size_t welded_vertices;
    // Polygons without a triangle; they have UVs all the same.
    size_t dropped_polygons;
    // Edges that were cut since more than two faces meet there, or two that disagree about the outside.
    size_t split_edges;
    // After an error: see its code. Otherwise 0.
    size_t detail;
    // Edges where a crack was closed.
    size_t closed_edges;
    // 1 where a stage ended early since `progress` answered SEAMWRIGHT_FINISH; 0 where all was done.
    size_t ended_early;
} SeamwrightReport;
#define SEAMWRIGHT_REPORT_INIT {sizeof(SeamwrightReport), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

// One of n tasks.
typedef void (*SeamwrightTask)(void *context, size_t index);

// What the caller offers. A null pointer to it, or a null function in it, is no offer.
typedef struct SeamwrightHost {
    // sizeof(SeamwrightHost).
    size_t struct_size;
    // Handed to both functions as it is.
    void *user;
    // `done` of `total` steps of a stage ("repair", "exposure", "seams", "pack", "check") are finished. Called on the
    // calling thread. Answers SEAMWRIGHT_GO_ON, SEAMWRIGHT_STOP or, where the options allow it, SEAMWRIGHT_FINISH; any other stops the run.
    int32_t (*progress)(void *user, const char *stage, size_t done, size_t total);
    // Calls `task(context, i)` exactly once for each i below count, on any threads in any order, and returns when all
    // are done. It may be called again from within a task. The result does not depend on it.
    void (*run)(void *user, size_t count, SeamwrightTask task, void *context);
} SeamwrightHost;
#define SEAMWRIGHT_HOST_INIT {sizeof(SeamwrightHost), 0, 0, 0}

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The interface that the library was built with; compare it with `SEAMWRIGHT_INTERFACE`.
uint32_t seamwright_interface(void);

// The library's version, like "0.1.0".
const char *seamwright_version(void);

// A sentence for people about a code.
const char *seamwright_message(int32_t code);

// Writes how many bytes of scratch `seamwright_measure` asks for. Of the mesh it reads the counts and `polygon_start`.
int32_t seamwright_measure_scratch(size_t *bytes,
                                   const struct SeamwrightMesh *mesh,
                                   uint32_t resolution);

// Measures a map of `mesh`: `corner_uv` is (corner_count, 2), NaN where a corner has no UV; `exposure` is (vertex_count)
// or NULL. `resolution`: texels a side at which overlap and utilisation are sampled, 16384 at the most, 0 for none.
// Polygons are judged by the triangles that `seamwright_unwrap` makes of them. `figures` is written after an error too.
int32_t seamwright_measure(struct SeamwrightFigures *figures,
                           const struct SeamwrightMesh *mesh,
                           const double *corner_uv,
                           const float *exposure,
                           uint32_t resolution,
                           uint8_t *scratch,
                           size_t scratch_bytes);

// Fills `options` with the command's defaults, whatever stands there. `struct_size`: sizeof *options.
int32_t seamwright_defaults(struct SeamwrightOptions *options,
                            size_t struct_size);

// Writes how many bytes of scratch `seamwright_unwrap` asks for. Of the mesh it reads the counts and `polygon_start`, so
// the other pointers may be null. Some mesh may need more than this estimate: see SEAMWRIGHT_SCRATCH.
int32_t seamwright_unwrap_scratch(size_t *bytes,
                                  const struct SeamwrightMesh *mesh,
                                  const struct SeamwrightOptions *options);

// Makes the atlas of `mesh`: few charts, no flips, no overlaps, the bound of `options` on distortion, seams in hidden
// places. The same mesh and options give the same bytes on every machine. `report` is written after an error too. `host`
// may be NULL. `scratch` has any alignment and any contents. Buffers that are written share no byte with others.
int32_t seamwright_unwrap(const struct SeamwrightAtlas *atlas,
                          struct SeamwrightReport *report,
                          const struct SeamwrightMesh *mesh,
                          const struct SeamwrightOptions *options,
                          const struct SeamwrightHost *host,
                          uint8_t *scratch,
                          size_t scratch_bytes);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SEAMWRIGHT_H */
