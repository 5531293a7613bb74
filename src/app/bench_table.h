/* What bench found out, and the ways to show it. */
#ifndef GP_APP_BENCH_TABLE_H
#define GP_APP_BENCH_TABLE_H

#include "app/paper.h"
#include "core/status.h"
#include "glare/engine.h"

#include <stdbool.h>
#include <stdio.h>

/* A technique: an engine and its settings. */
struct gp_bench_technique {
    const char *name;
    const char *engine;
    struct gp_splat_params splat;  // for engine "splat"
};
extern const struct gp_bench_technique gp_bench_techniques[];  // NULL name ends
enum { GP_BENCH_ROWS = 15 };  // of gp_bench_techniques

/* The options that ask the main command for that technique. */
void gp_bench_options(const struct gp_bench_technique *t, float tolerance,
                      char *line, size_t size);

/* One technique on one frame. */
struct gp_bench_row {
    const char *name;          // of the technique
    char options[128];
    char why[512];             // why it could not run; "" when it ran

    double ms, ms_min, ms_max; // median and range of `runs` with state kept
    double ms_first;           // of the first run, which makes the state
    int runs;
    bool extrapolated;         // from `share` of the sources; ms_min = ms_max
    double share;

    struct gp_glare_stats stats; // its gl is `gl`
    char gl[128];              // renderer; "": no GL
    double polygons, polygon_pixels; // of stats, extrapolated too
    double bound;              // NaN: not known; INFINITY: none is guaranteed
    bool measured;             // `error` is known; never when extrapolated
    struct gp_glare_error error;
    double flip;               // mean LDR-FLIP; NaN: not defined
    bool pareto;               // no row is both faster and nearer
};

/* All techniques on one frame. */
struct gp_bench_frame {
    char *input;               // name or path, owned
    int width, height;
    long long sources;
    int kernel_w, kernel_h;
    char *kernel;              // name or path, owned
    const struct gp_paper_rate *paper; // or NULL
    struct gp_bench_row row[GP_BENCH_ROWS];
    int rows;
};

struct gp_bench_table {
    struct gp_bench_frame frame[GP_PAPER_KINDS];
    int frames;
    int runs;                  // asked for
};
void gp_bench_table_free(struct gp_bench_table *t);

/* Sets `pareto` of each row: those that are measured, and than which none is
 * both at most as slow and at most as wrong, and better in one. */
void gp_bench_mark_pareto(struct gp_bench_frame *f);

/* The table for readers, up to 141 columns, and its legend. */
void gp_bench_print(const struct gp_bench_table *t, FILE *to);

/* The same rows, RFC 4180: a header line, then one line a row; what is not
 * known is empty. `path` may be "-". Errors: GP_ERR_IO; GP_ERR_BUG. */
GP_MUST_CHECK gp_status gp_bench_csv(const struct gp_log *log,
                                     const struct gp_bench_table *t,
                                     const char *path);

/* The same rows as one JSON object; what is not known is left out. */
GP_MUST_CHECK gp_status gp_bench_json(const struct gp_log *log,
                                      const struct gp_bench_table *t,
                                      const char *path);

/* Finds out before any work whether there is a gnuplot.
 * Errors: GP_ERR_IO, with the name of the package to install. */
GP_MUST_CHECK gp_status gp_bench_plot_check(const struct gp_log *log);

/* Milliseconds against rel_l2, both logarithmic, a picture below the other
 * for each frame: SVG. Rows without an error are not in it.
 * Errors: GP_ERR_IO cannot write, gnuplot missing or failed (its first line). */
GP_MUST_CHECK gp_status gp_bench_plot(const struct gp_log *log,
                                      const struct gp_bench_table *t,
                                      const char *path);

#endif
