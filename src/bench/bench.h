// SPDX-License-Identifier: Apache-2.0
/* glarepp bench: speed against error, technique by technique. */
#ifndef GP_BENCH_BENCH_H
#define GP_BENCH_BENCH_H

#include "core/status.h"
#include "glarepp.h"
#include "io/read.h"
#include "io/write.h"

#include <jansson.h>
#include <stdbool.h>

/* Options of the table; files are NULL when not wanted. */
struct gp_bench_params {
    const char *csv, *json, *plot;
    const char *page; // that the caller writes of what it is given
    bool paper;  // the paper's three frames instead of an input
    int runs;    // timed ones of each row, 1 to GP_BENCH_RUNS
};
enum { GP_BENCH_RUNS = 1000 };
#define GP_BENCH_DEFAULTS { .runs = 9 }

/* A run; all is borrowed. */
struct gp_bench_request {
    const struct gp_bench_params *params;
    struct glarepp *gp;
    const char *input;         // not with params->paper
    const char *kernel_name;   // NULL: the paper's own
    const struct gp_read_params *read;
    const struct gp_write_params *write;
    const struct glarepp_kernel_params *kernel;
    const struct glarepp_plan_params *plan; // of the main job, but for its
                               // kernel; sense, layer, lights and tone are there
    /* Returns what the file of a frame says of it; gives a frame with lights
     * its planes. */
    void *user;
    struct glarepp_frame_params (*describe)(void *user,
                                            const struct gp_frame *f);
    gp_status (*planes)(void *user, const struct gp_log *log,
                        const struct gp_frame *f, struct glarepp_frame *to);
    /* With params->page: takes the tone-mapped picture of a row, the exact one, and
     * in plane[0] FLIP between them; then the frame's table, as the JSON has it, whose
     * reference is taken. */
    gp_status (*picture)(void *user, const struct gp_log *log, const char *row,
                         const char *options,
                         const struct glarepp_image *picture,
                         const struct glarepp_image *exact,
                         const struct glarepp_image *flip);
    gp_status (*table)(void *user, const struct gp_log *log, json_t *frame);
};

/* Measures every technique on the input's one frame, or on the paper's three;
 * prints the table on stdout and writes it to the files that params names. A
 * technique's time goes from cleaned frame to layer: bright pass and glare
 * stage. Rows take turns, so that what else the machine does slows all of them.
 * With `-` as a file, only that file goes to stdout. A frame of a file has a
 * table of the whole run, too: read, glare, and each way to write it.
 *
 * With lights the table compares methods of measuring their visibility: exact,
 * readback, masks of 4 to 64 texels a side, disc and square, summed in float and
 * in 8 bits; the error is the difference to exact over all lights. Without a
 * plot.
 *
 * The truth is the picture's: by true angles where its kernel follows them, else a
 * plane's. Techniques that draw one kernel everywhere have a plane's error in theirs.
 *
 * Flare of bright pixels and ghosts of a lens are rows after the techniques, each
 * against its own truth.
 *
 * A technique that cannot run here (no GL) is a row that says so.
 * Errors: as reading, writing and the library's. */
GP_MUST_CHECK gp_status gp_bench_run(const struct gp_log *log,
                                     const struct gp_bench_request *req);

/* Writes `o`, whose reference it takes, as a file; "-" is stdout.
 * Errors: GP_ERR_IO; GP_ERR_BUG out of memory, also for a NULL `o`. */
GP_MUST_CHECK gp_status gp_bench_save_json(const struct gp_log *log, json_t *o,
                                           const char *path);

#endif
