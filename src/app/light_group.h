/* Light groups: layers of the frame's file that hold the light of some lamps
 * alone, and whose sum is the frame's colour. With --light-group the glare is
 * that of these layers, each held against the threshold by itself, and the
 * frame gets their sum. */
#ifndef GP_APP_LIGHT_GROUP_H
#define GP_APP_LIGHT_GROUP_H

#include "core/frame.h"
#include "core/status.h"
#include "glare/compose.h"
#include "glare/engine.h"
#include "glare/kernel.h"
#include "glare/sensors.h"
#include "io/read.h"

/* One layer. Its frame borrows from the frame that it was read beside. */
struct gp_light_group {
    struct gp_frame frame;
    struct gp_sources sources;
};

/* Those of a frame; zeroed is none. */
struct gp_light_groups {
    struct gp_light_group *at; // owned
    int n;
};

/* Reads the layers `name[0..n)` of the file of `f`, as gp_read_layer() does.
 *   out  freed by gp_light_groups_free(), before `f`, in any case
 * Errors: those of gp_read_layer(). */
GP_MUST_CHECK gp_status gp_light_groups_read(const struct gp_log *log,
                                             const struct gp_read_params *p,
                                             const struct gp_frame *f,
                                             const char *const *name, int n,
                                             struct gp_light_groups *out);
void gp_light_groups_free(struct gp_light_groups *g);

/* Finds the light of each layer, and puts that of all in place of the frame's
 * own into *src, which gp_sense() made.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_light_groups_sense(const struct gp_log *log,
                                              const struct gp_sensor_params *p,
                                              struct gp_light_groups *g,
                                              struct gp_sources *src);

/* Makes the layers with their own glare, frame.lit: then they still sum up to
 * the lit frame, where they summed up to the frame.
 *   engines  for these alone: what they keep tells of the frames before
 * Errors: those of gp_glare_run() and gp_compose(). */
GP_MUST_CHECK gp_status gp_light_groups_light(
    const struct gp_log *log, const struct gp_glare_params *glare,
    const struct gp_compose_params *compose, const struct gp_kernel *kernel,
    struct gp_glare *engines, struct gp_light_groups *g);

#endif
