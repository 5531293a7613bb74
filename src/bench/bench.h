/* glarepp bench: speed against error, technique by technique. */
#ifndef GP_BENCH_BENCH_H
#define GP_BENCH_BENCH_H

#include "core/status.h"
#include "glare/engine.h"
#include "glare/kernel.h"
#include "glare/model/model.h"
#include "glare/sensors.h"
#include "io/read.h"
#include "sun/stage.h"
#include "tone/tone.h"

#include <jansson.h>
#include <stdbool.h>

/* Options of the table; files are NULL when not wanted. */
struct gp_bench_params {
    const char *csv, *json, *plot;
    bool paper;  // the paper's three frames instead of an input
    int runs;    // timed ones of each row, >= 1
};
#define GP_BENCH_DEFAULTS { .runs = 9 }

/* A layer that is no engine's of the kernel: its row, and its truth. */
struct gp_bench_layer {
    const char *name, *options;
    const char *layer;     // rows of the same one are compared, and share exact
    void *user;
    /* Adds the layer of the sources to f->layer, which is dark. Sets *bound of
     * rel_l2. */
    gp_status (*draw)(void *user, const struct gp_log *log,
        const struct gp_sources *src, struct gp_frame *f, double *bound);
    /* Adds the exact one to `out`, 3 * w * h. */
    gp_status (*exact)(void *user, const struct gp_log *log,
        const struct gp_sources *src, const struct gp_frame *f, double *out);
};
enum { GP_BENCH_LAYERS = 3 };

/* A run; all is borrowed. */
struct gp_bench_request {
    const struct gp_bench_params *params;
    const char *input;         // not with params->paper
    bool default_kernel;       // no --kernel: --paper brings its own
    const struct gp_read_params *read;
    const struct gp_sensor_params *sensor;
    const struct gp_kernel_params *kernel; // of an image
    const char *kernel_name;
    const struct gp_frame *kernel_image;   // used without recipes
    const struct gp_recipe *recipe;
    int recipes;
    double fov;                            // 0: the camera's, or the usual
    const struct gp_glare_params *glare;
    const struct gp_compose_params *compose;
    const struct gp_tone_params *tone;
    const struct gp_sun_params *sun;
    const struct gp_sun_reader *reader;  // for the sun and the camera
    const struct gp_bench_layer *layer;  // up to GP_BENCH_LAYERS
    int layers;
};

/* Measures every technique on the input's one frame, or on the paper's three;
 * prints the table on stdout and writes it to the files that params names. A
 * technique's time goes from cleaned frame to layer: bright pass and glare
 * stage. With `-` as a file, only that file goes to stdout.
 *
 * With a light in the sun's params the table compares methods of measuring its
 * visibility: exact, readback, masks of 4 to 64 texels a side, disc and square,
 * summed in float and in 8 bits, and one mask on the CPU;
 * the error is the difference to exact over all lights. Without a plot.
 *
 * Extra layers are rows after the techniques, each against its own truth.
 *
 * A technique that cannot run here (no GL) is a row that says so.
 * Errors: as reading, writing and gp_glare_reference(); GP_ERR_IO also when
 * gnuplot, which --plot needs, is not installed or fails. */
GP_MUST_CHECK gp_status gp_bench_run(const struct gp_log *log,
                                     const struct gp_bench_request *req);

/* Writes `o`, whose reference it takes, as a file; "-" is stdout.
 * Errors: GP_ERR_IO; GP_ERR_BUG out of memory, also for a NULL `o`. */
GP_MUST_CHECK gp_status gp_bench_save_json(const struct gp_log *log, json_t *o,
                                           const char *path);

#endif
