/* Unwraps a mesh that stands in memory, with buffers of its own, and writes the UVs.
     unwrap MESH.obj OUT.uv
   MESH.obj: lines `v x y z` and `f a b c ...` only; it stands in for whatever your program makes or loads. OUT.uv: a line
   `u v` for each corner, with every digit. Prints figures and a hash of the UVs. Exit code 0, or 1 with a message. */
#include "../include/seamwright.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE 65536

static void fail(const char *what, const char *why) {
    fprintf(stderr, "unwrap: %s: %s\n", what, why);
    exit(1);
}

static void *buffer(size_t count, size_t size) {
    void *bytes = calloc(count ? count : 1, size);
    if (!bytes) fail("memory", "not to be had");
    return bytes;
}

/* Counts on the first pass, when the mesh's pointers are null; fills on the second. */
static void read_obj(FILE *file, SeamwrightMesh *mesh, double *positions, uint32_t *corners, uint32_t *starts) {
    static char line[LINE];
    ptrdiff_t decimals = 0;
    mesh->vertex_count = mesh->corner_count = mesh->polygon_count = 0;
    while (fgets(line, sizeof line, file)) {
        char *at = line + 1, *end;
        if (line[0] == 'v' && line[1] == ' ') {
            for (int k = 0; k < 3; k++, at = end) {
                double x = strtod(at, &end);
                if (positions) positions[3 * mesh->vertex_count + k] = x;
                const char *point = memchr(at, '.', (size_t)(end - at));
                if (point && end - point - 1 > decimals) decimals = end - point - 1;
            }
            mesh->vertex_count++;
        } else if (line[0] == 'f' && line[1] == ' ') {
            if (starts) starts[mesh->polygon_count] = (uint32_t)mesh->corner_count;
            for (;;) {
                unsigned long vertex = strtoul(at, &end, 10);
                if (end == at) break;
                at = end + strcspn(end, " \r\n"); /* over what stands behind a slash */
                if (corners) corners[mesh->corner_count] = (uint32_t)vertex - 1;
                mesh->corner_count++;
            }
            mesh->polygon_count++;
        }
    }
    if (starts) starts[mesh->polygon_count] = (uint32_t)mesh->corner_count;
    /* A text is exact to half of its last digit. */
    double last = 1.0;
    for (ptrdiff_t k = 0; k < decimals; k++) last *= 10.0;
    mesh->tolerance = decimals ? 0.5 * (1.0 / last) : 0.0;
}

/* A line for each stage. Any answer but 0 would stop the run. */
static int32_t progress(void *user, const char *stage, size_t done, size_t total) {
    const char **last = user;
    if (*last != stage) printf("stage %s\n", stage);
    *last = stage;
    (void)done, (void)total;
    return 0;
}

/* FNV-1a over the bytes of the UVs, lowest byte first. */
static uint64_t hash(const double *values, size_t count) {
    uint64_t sum = 0xcbf29ce484222325u;
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, values + i, sizeof bits);
        for (int k = 0; k < 8; k++) sum = (sum ^ (bits >> 8 * k & 0xff)) * 0x100000001b3u;
    }
    return sum;
}

int main(int argc, char **argv) {
    if (argc != 3) fail("usage", "unwrap MESH.obj OUT.uv");
    if (seamwright_interface() != SEAMWRIGHT_INTERFACE) fail("seamwright", "the library is not the header's");
    FILE *in = fopen(argv[1], "rb");
    if (!in) fail(argv[1], "cannot be opened");

    SeamwrightMesh mesh = SEAMWRIGHT_MESH_INIT;
    read_obj(in, &mesh, NULL, NULL, NULL);
    rewind(in);
    double *positions = buffer(mesh.vertex_count, 3 * sizeof *positions);
    uint32_t *corners = buffer(mesh.corner_count, sizeof *corners);
    uint32_t *starts = buffer(mesh.polygon_count + 1, sizeof *starts);
    read_obj(in, &mesh, positions, corners, starts);
    fclose(in);
    mesh.positions = positions;
    mesh.corners = corners;
    mesh.polygon_start = starts;

    SeamwrightAtlas atlas = SEAMWRIGHT_ATLAS_INIT;
    atlas.corner_uv = buffer(mesh.corner_count, 2 * sizeof(double));
    atlas.polygon_chart = buffer(mesh.polygon_count, sizeof(uint32_t));
    atlas.exposure = buffer(mesh.vertex_count, sizeof(float));
    const char *stage = NULL;
    SeamwrightHost host = SEAMWRIGHT_HOST_INIT;
    host.user = &stage;
    host.progress = progress;
    SeamwrightReport report = SEAMWRIGHT_REPORT_INIT;
    SeamwrightOptions options;
    seamwright_defaults(&options, sizeof options);
    size_t bytes;
    int32_t code = seamwright_unwrap_scratch(&bytes, &mesh, &options);
    if (code) fail(argv[1], seamwright_message(code));
    do {
        uint8_t *scratch = buffer(bytes, 1);
        code = seamwright_unwrap(&atlas, &report, &mesh, &options, &host, scratch, bytes);
        free(scratch);
        bytes = report.detail; /* where it was not enough */
    } while (code == SEAMWRIGHT_SCRATCH && bytes);
    if (code) {
        fprintf(stderr, "unwrap: at %zu:\n", report.detail);
        fail(argv[1], seamwright_message(code));
    }

    SeamwrightFigures figures = SEAMWRIGHT_FIGURES_INIT;
    code = seamwright_measure_scratch(&bytes, &mesh, 1024);
    if (code) fail(argv[1], seamwright_message(code));
    uint8_t *scratch = buffer(bytes, 1);
    code = seamwright_measure(&figures, &mesh, atlas.corner_uv, atlas.exposure, 1024, scratch, bytes);
    free(scratch);
    if (code) fail(argv[1], seamwright_message(code));

    FILE *out = fopen(argv[2], "wb");
    if (!out) fail(argv[2], "cannot be opened");
    for (size_t c = 0; c < mesh.corner_count; c++)
        fprintf(out, "%.17g %.17g\n", atlas.corner_uv[2 * c], atlas.corner_uv[2 * c + 1]);
    if (fclose(out)) fail(argv[2], "cannot be written");
    printf("seamwright %s: %zu charts, distortion %.4f, seams %.3f, %zu flips, %zu overlaps\n", seamwright_version(),
           report.chart_count, report.distortion, figures.seam_length, figures.flipped_faces,
           figures.overlapping_faces);
    printf("uv %016" PRIx64 "\n", hash(atlas.corner_uv, 2 * mesh.corner_count));
    free(positions), free(corners), free(starts);
    free(atlas.corner_uv), free(atlas.polygon_chart), free(atlas.exposure);
    return 0;
}
