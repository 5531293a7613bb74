// SPDX-License-Identifier: Apache-2.0
/* The parts of bench: its table, the paper's frames, the plot, the sun's, the whole
 * run. */
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
    bool follows;    // true angles, where the frame's kernel does; else a plane
    float tolerance; // 0: the option's
};
extern const struct gp_bench_technique gp_bench_techniques[];  // NULL name ends
enum {
    GP_BENCH_ROWS = 13,                // of gp_bench_techniques
    GP_BENCH_MOST = GP_BENCH_ROWS + 3, // with flare, and a lens in two ways
};

/* Writes the main command's options for that technique; `plane`: with one, where it
 * does not follow angles. */
void gp_bench_options(const struct gp_bench_technique *t, float tolerance,
                      bool plane, char *line, size_t size);

/* Measures of an error, of which FLIP is a mean of LDR-FLIP, and limits that a user
 * may have for it. */
enum { GP_REL_L2, GP_MAX_REL, GP_FLIP, GP_BENCH_BY, GP_BENCH_WITHIN = 4 };
extern const char *const gp_bench_by[GP_BENCH_BY];
extern const double gp_bench_within[GP_BENCH_WITHIN];

/* Times of runs, in milliseconds: median and range of `runs` with state kept,
 * and the first, which makes it. NaN: not known. */
struct gp_bench_took {
    double ms, least, most, first;
    int runs;
};

/* One technique on one frame. */
struct gp_bench_row {
    const char *name;          // of the technique
    char options[128];
    char why[GP_BENCH_WHY];    // reason that it could not run; "": it ran

    // numbers are NaN where they are not known
    struct gp_bench_took took;
    double share; // of the sources, of which it is extrapolated

    struct glarepp_layer_facts facts;
    char gl[128]; // facts.gl, which goes with its context, or ""
    double polygons, polygon_pixels; // of facts, extrapolated too
    double bound;                    // INFINITY: no guarantee
    double error[GP_BENCH_BY];       // never when extrapolated
    double max_abs;
    const char *layer;         // "flare", "lens"; NULL: the kernel's
    const char *same;          // auto: the row that computes the same, whose
                               // figures it has; or NULL
    const char *twin;          // the row of which this one is `same`; or NULL
    bool pareto; // no row of the layer is nearer and surely faster
};

enum { GP_BENCH_OUTPUTS = 11 + GP_PNG_LEVELS + 1 }; // of EXR, of PNG

/* A way to write the frame. */
struct gp_bench_output {
    const char *format; // "EXR", "EXR, lossy", "PNG"
    char options[40];
    enum gp_compression compression; // of EXR
    int png_level;
    struct gp_bench_took took; // fewer runs than asked for where they are long
    long long bytes;
    bool usual;             // the job does so without options
    bool pareto;            // none of the format is smaller and surely faster
    char why[GP_BENCH_WHY]; // reason that it cannot; "": it can
};

/* A frame's way from file to file, in milliseconds, and its ends. */
struct gp_bench_whole {
    // a read, NaN of a pipe; bright pass to layer; compose and tone map
    struct gp_bench_took read, glare, tone;
    struct gp_bench_output output[GP_BENCH_OUTPUTS];
    int outputs; // 0: not measured
};

/* All techniques on one frame; borrows its names. */
struct gp_bench_frame {
    const char *input; // name or path
    int width, height;
    long long sources;
    bool angles; // its kernel follows true angles
    int kernel_w, kernel_h;
    const char *kernel;        // name or path
    double kernel_left_out;    // as in glarepp_kernel_facts; NaN: no model's
    const struct gp_paper_rate *paper; // or NULL
    struct gp_bench_row row[GP_BENCH_MOST];
    int rows;
    int choice[GP_BENCH_BY][GP_BENCH_WITHIN]; // the fastest row; -1: none
    struct gp_bench_whole whole;
};

struct gp_bench_table {
    struct gp_bench_frame frame[GP_PAPER_KINDS];
    int frames;
    int runs;                  // as --runs
};

/* A frame, and the exact layer that its rows are compared with. */
struct gp_bench {
    const struct gp_log *log;
    struct gp_log errors; // the same, without advice about the frame
    const struct gp_bench_request *req;
    struct glarepp_kernel *kernel;
    struct gp_frame *f;
    struct glarepp_frame_params params; // of f, with its image
    bool angles;                 // the truth is by true angles, not a plane's
    struct glarepp_plan *plan;   // of the truth
    struct glarepp_frame *truth; // after VERIFY: keeps the sum in double
    struct glarepp_sense_facts sense;
    struct gp_planes shown; // exact composite, tone mapped; empty: no FLIP
};

/* Adds a row, which says so where the frame is dark.
 *   layer  as in struct gp_bench_row */
struct gp_bench_row *gp_bench_row_add(const struct gp_bench *b,
                                      const char *name, const char *layer,
                                      struct gp_bench_frame *out);

/* Sets `pareto` of each row: those that are measured, and than which none is
 * both at most as slow and at most as wrong, and better in one. As times differ
 * from run to run, a row is slower than another only when its fastest run is
 * slower than the other's median. Finds the choices, too. */
void gp_bench_mark_pareto(struct gp_bench_frame *f);

/* Times of runs in milliseconds. Zeroed is none. */
struct gp_bench_times {
    double ms[GP_BENCH_RUNS], total;
    int n;
};
void gp_bench_time(struct gp_bench_times *t, double ms);

/* Sorts at least one time, and sets all of *out but `first`. */
void gp_bench_spread(struct gp_bench_times *t, struct gp_bench_took *out);

/* A number of a row: NULL, which "so*" leaves out, of NaN, and null of infinity;
 * and one of milliseconds, to the microsecond. */
json_t *gp_bench_number(double v);
json_t *gp_bench_ms(double ms);

/* Writes the files of `p` but its plot: `all`, whose reference it takes, as JSON, and
 * the "rows" of its "frames", or its own, as CSV (RFC 4180): of each `columns`, names
 * with commas between, a row's value, or its frame's. */
GP_MUST_CHECK gp_status gp_bench_save(const struct gp_log *log,
                                      const struct gp_bench_params *p,
                                      json_t *all, const char *columns);

/* Makes an object of a frame and its rows, as in the JSON of the table. */
json_t *gp_bench_json_frame(const struct gp_bench_frame *f);

/* Prints the table, up to 141 columns, and its legend, and writes it to the files
 * of `p`, as gp_bench_run() says. */
GP_MUST_CHECK gp_status gp_bench_write(const struct gp_log *log,
    const struct gp_bench_params *p, const struct gp_bench_table *t);

// -- bench.c -----------------------------------------------------------------

/* For extrapolating: makes *out a frame with the same light in one of `nth` of
 * its 32x32 pixel blocks, evenly spread, and no light at all elsewhere.
 *   out  only rgb; free with gp_frame_free()
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_bench_thin(const struct gp_log *log,
    const struct gp_frame *f, int nth, struct gp_frame *out);

/* Milliseconds of all sources, where shares of them, rising, took ms: what a run
 * takes without any, and as much more as the parts differ by. */
double gp_bench_whole_ms(const double share[2], const double ms[2]);

// -- extra.c -------------------------------------------------------------------

/* Compares a picture with the exact one, by FLIP (`shown`), whose map *map becomes
 * where that is not NULL, or as light. */
GP_MUST_CHECK gp_status gp_bench_compare(struct glarepp *gp,
                                         const struct glarepp_image *exact,
                                         const struct glarepp_image *picture,
                                         bool shown,
                                         struct glarepp_compare_facts *out,
                                         struct glarepp_image *map);

/* Adds the rows of flare and lens that the job has to out->row; dark frames' say
 * so. */
GP_MUST_CHECK gp_status gp_bench_extras(const struct gp_bench *b,
                                        struct gp_bench_frame *out);

// -- whole.c -------------------------------------------------------------------

/* Measures a frame from file to file: `runs` times, each output in turn, written
 * to a folder in $TMPDIR, else /tmp. Without lights, lens and scene.
 * Errors: those of reading and computing; GP_ERR_IO no such folder. An output that
 * cannot be written says why. */
GP_MUST_CHECK gp_status gp_bench_whole_run(const struct gp_bench *b,
                                           struct gp_bench_whole *out);

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
