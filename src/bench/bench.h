/* glarepp bench: speed against error, technique by technique. */
#ifndef GP_BENCH_BENCH_H
#define GP_BENCH_BENCH_H

#include "core/status.h"
#include "glarepp.h"
#include "io/read.h"

#include <jansson.h>
#include <stdbool.h>

/* Options of the table; files are NULL when not wanted. */
struct gp_bench_params {
    const char *csv, *json, *plot;
    bool paper;  // the paper's three frames instead of an input
    int runs;    // timed ones of each row, >= 1
};
#define GP_BENCH_DEFAULTS { .runs = 9 }

/* A run; all is borrowed. */
struct gp_bench_request {
    const struct gp_bench_params *params;
    struct glarepp *gp;
    const char *input;         // not with params->paper
    bool default_kernel;       // no --kernel: --paper brings its own
    const char *kernel_name;
    const struct gp_read_params *read;
    const struct glarepp_kernel_params *kernel;
    const struct glarepp_plan_params *plan; // of the main job, but for its
                               // kernel; sense, layer, lights and tone are there
    /* Fills in what the file of a frame says of it, and gives a frame with lights
     * its planes. */
    void *user;
    gp_status (*describe)(void *user, const struct gp_log *log,
                          const struct gp_frame *f,
                          struct glarepp_frame_params *out);
    gp_status (*planes)(void *user, const struct gp_log *log,
                        const struct gp_frame *f, struct glarepp_frame *to);
};

/* Measures every technique on the input's one frame, or on the paper's three;
 * prints the table on stdout and writes it to the files that params names. A
 * technique's time goes from cleaned frame to layer: bright pass and glare
 * stage. With `-` as a file, only that file goes to stdout.
 *
 * With lights the table compares methods of measuring their visibility: exact,
 * readback, masks of 4 to 64 texels a side, disc and square, summed in float and
 * in 8 bits; the error is the difference to exact over all lights. Without a
 * plot.
 *
 * Flare of bright pixels and ghosts of a lens are rows after the techniques, each
 * against its own truth.
 *
 * A technique that cannot run here (no GL) is a row that says so.
 * Errors: as reading, writing and the library's; GP_ERR_IO also when
 * gnuplot, which --plot needs, is not installed or fails. */
GP_MUST_CHECK gp_status gp_bench_run(const struct gp_log *log,
                                     const struct gp_bench_request *req);

/* The main job with several numbers of threads; all is borrowed. */
struct gp_scaling_request {
    const char *input;         // a file
    struct gp_counts threads;  // each >= 1
    int runs;                  // >= 1
    const char *json;          // file, "-" is stdout; NULL: none
    const char *const *word;   // `words` of the main job's command line, none
    int words;                 // of outputs, threads or report
};

/* Runs the main job in processes of its own, from cold, into a PNG that nothing
 * stores, with each number of threads in turn; prints a table, and writes it to
 * req->json. A row is a stage of times_ms, `outside` of all stages (start,
 * plans, the end), or the whole `process`, each with the least wall time of its
 * runs:
 *   cores         CPU time of all threads over wall time
 *   serial share  a / (a + b) of the line a + b / threads through the wall
 *                 times with least squares, neither under 0 (Amdahl 1967), and
 *                 the times that it predicts with 8, 16 and 64 threads; only by
 *                 numbers of threads up to that of the processors that the
 *                 process may use (`processors` in req->json), if two differ
 * and a line where other programs kept over 10 % of these processors busy
 * meanwhile, by /proc/stat and in half a second at least; other_cores in
 * req->json.
 * Errors: GP_ERR_IO no process can be started, or the file cannot be written;
 * the status of a run that fails, which has said why. */
GP_MUST_CHECK gp_status gp_scaling_run(const struct gp_log *log,
                                       const struct gp_scaling_request *req);

/* Writes `o`, whose reference it takes, as a file; "-" is stdout.
 * Errors: GP_ERR_IO; GP_ERR_BUG out of memory, also for a NULL `o`. */
GP_MUST_CHECK gp_status gp_bench_save_json(const struct gp_log *log, json_t *o,
                                           const char *path);

#endif
