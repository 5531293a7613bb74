// SPDX-License-Identifier: Apache-2.0
/* The parts of bench: its table, the paper's frames, the plot, the sun's. */
#ifndef GP_BENCH_BENCH_PRIV_H
#define GP_BENCH_BENCH_PRIV_H

#include "bench/bench.h"
#include "io/frame.h"
#include "core/json.h"

#include <stddef.h>

// -- paper.c: three frames and a kernel after Ando et al. 2007, section 5 ----

enum gp_paper_kind {
    GP_PAPER_POINTS,   // 32 points between pixels, luminance 10 to 5000
    GP_PAPER_WINDOWS,  // 16 x 12 windows, a third lit at 5 to 50; lamps
    GP_PAPER_SKY,      // clouds of 2 to 20 over an uneven horizon
    GP_PAPER_KINDS,
};

enum { GP_BENCH_WHY = 512 }; // bytes of a line

/* The paper's size of glare images. Its frames were 1024 x 786, as printed. */
enum { GP_PAPER_W = 1024, GP_PAPER_H = 768, GP_PAPER_KERNEL = 512 };

/* The paper's figures of its approximate method on a GeForce 7800 GTX: frames
 * a second of the whole picture, scene and all. */
struct gp_paper_rate {
    const char *name;  // of the frame here
    const char *rate;  // the paper's figure printed beside it
    int fps;
};
extern const struct gp_paper_rate gp_paper_rates[GP_PAPER_KINDS];

/* Makes a frame, float, BT.709, everything but its light dim (0.05 to 0.8). The
 * same bytes on any machine. */
GP_MUST_CHECK gp_status gp_paper_frame(const struct gp_log *log,
    enum gp_paper_kind kind, struct gp_frame *out);

/* Makes a square kernel image with its centre in the middle: a halo and coloured
 * streaks, 0 on its border. */
GP_MUST_CHECK gp_status gp_paper_kernel(const struct gp_log *log,
                                        struct gp_frame *out);

// -- table.c: techniques, and their measurements -----------------------------

/* A technique: an engine and, of "splat", its settings as in
 * glarepp_layer_params. */
struct gp_bench_technique {
    const char *name;
    const char *engine;
    int group, cluster;
    float shrink;
    bool plane; // where the truth is by true angles
};
extern const struct gp_bench_technique gp_bench_techniques[];  // NULL name ends
enum {
    GP_BENCH_ROWS = 10, // of gp_bench_techniques
    GP_BENCH_MOST =
        GP_BENCH_ROWS + 5, // with angles, flare, and a lens in two ways
};

/* Writes the main command's options for that technique. */
void gp_bench_options(const struct gp_bench_technique *t, float tolerance,
                      char *line, size_t size);

/* One technique on one frame. */
struct gp_bench_row {
    const char *name;          // of the technique
    char options[128];
    char why[GP_BENCH_WHY];    // reason that it could not run; "": it ran

    double ms, ms_min, ms_max; // median and range of `runs` with state kept
    double ms_first;           // of the first run, which makes the state
    int runs;
    bool extrapolated;         // from `share` of the sources; ms_min = ms_max
    double share;

    struct glarepp_layer_facts facts; // its gl is `gl`
    char gl[128];              // renderer; "": no GL
    double polygons, polygon_pixels; // of facts, extrapolated too
    double bound;              // NaN: not known; INFINITY: no guarantee
    bool measured;             // `error` is known; never when extrapolated
    struct glarepp_errors error;
    double flip;               // mean LDR-FLIP; NaN: not defined
    const char *layer;         // "angles", "flare", "lens"; NULL: the kernel's
    bool pareto;               // no row of the layer is both faster and nearer
};

/* All techniques on one frame. */
struct gp_bench_frame {
    char *input;               // name or path, owned
    int width, height;
    long long sources;
    int kernel_w, kernel_h;
    char *kernel;              // name or path, owned
    double kernel_left_out;    // as in glarepp_kernel_facts; NaN: no model's
    const struct gp_paper_rate *paper; // or NULL
    struct gp_bench_row row[GP_BENCH_MOST];
    int rows;
};

struct gp_bench_table {
    struct gp_bench_frame frame[GP_PAPER_KINDS];
    int frames;
    int runs;                  // as --runs
};
void gp_bench_table_free(struct gp_bench_table *t);

/* Sets `pareto` of each row: those that are measured, and than which none is
 * both at most as slow and at most as wrong, and better in one. */
void gp_bench_mark_pareto(struct gp_bench_frame *f);

/* The median of n values, which are sorted; n >= 1. */
double gp_bench_median(double *v, int n);

/* A cell of a table: text, a number, or nothing. CSV and JSON have the same. */
struct gp_bench_cell {
    const char *name;  // of its column
    const char *text;  // or NULL
    double number;     // NaN: nothing
    enum { GP_CELL_REAL, GP_CELL_WHOLE, GP_CELL_TRUTH } kind; // of the number
};

/* Writes rows of cells as CSV, RFC 4180: a header line, then one line a row,
 * unknown cells empty. */
GP_MUST_CHECK gp_status gp_bench_save_csv(const struct gp_log *log,
    const char *path, const struct gp_bench_cell *c, int rows, int cells);

/* Makes an object of a row, unknown cells left out. */
json_t *gp_bench_json_row(const struct gp_bench_cell *c, int cells);

/* Makes an object of a frame and its rows, as in the JSON of the table. */
json_t *gp_bench_json_frame(const struct gp_bench_frame *f);

/* Prints the table on stdout, up to 141 columns, and its legend, and writes it
 * to the files of `p`. With `-` as a file, only that file goes to stdout.
 * Errors: GP_ERR_IO; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_bench_write(const struct gp_log *log,
    const struct gp_bench_params *p, const struct gp_bench_table *t);

// -- bench.c -----------------------------------------------------------------

/* For extrapolating: makes *out a frame with the same light in one of `nth` of
 * its 32x32 pixel blocks, evenly spread, and no light at all elsewhere.
 *   out  only rgb; free with gp_frame_free()
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_bench_thin(const struct gp_log *log,
    const struct gp_frame *f, int nth, struct gp_frame *out);

// -- sun.c -------------------------------------------------------------------

/* bench with a light: the paper's table of two rows (masking, locking), grown.
 * *lit is false, and nothing is printed, where the job has a camera alone.
 * Errors: GP_ERR_USAGE a plot or page is asked for; those of reading and writing. A
 * method that cannot run is a row that says why. */
GP_MUST_CHECK gp_status gp_bench_sun(const struct gp_log *log,
                                     const struct gp_bench_request *req,
                                     bool *lit);

/* Sink of a log: keeps errors in `why`, char[GP_BENCH_WHY]. */
void gp_bench_keep_why(void *why, const struct gp_line *line);

#endif
