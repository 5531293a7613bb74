/* The measuring of bench. */
#ifndef GP_APP_BENCH_MEASURE_H
#define GP_APP_BENCH_MEASURE_H

#include "app/bench_table.h"
#include "app/settings.h"
#include "core/frame.h"
#include "core/status.h"
#include "glare/kernel.h"

/* What a frame is measured with; borrowed. */
struct gp_bench_job {
    const struct gp_log *log;
    const struct gp_settings *s;
    const struct gp_kernel *kernel;
};

/* Fills out->row, all techniques in the order of gp_bench_techniques, and
 * out->width, height, sources. A run that would take over 6 s is made with a
 * part of the sources (a tenth, or a hundredth where that takes too long as
 * well) and extrapolated; no row takes much over a quarter of a minute.
 *
 *   f  rgb is cleaned; layer, lit and shown are made and written over
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_bench_measure(const struct gp_bench_job *job,
                                         struct gp_frame *f,
                                         struct gp_bench_frame *out);

/* For extrapolating: makes *out a frame with the same light in one of `parts`
 * of its 32x32 pixel blocks, evenly spread, and no light at all elsewhere; with
 * the first source alone when `parts` is 0.
 *
 *   src  the sources of f
 *   out  rgb alone; free with gp_frame_free()
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_bench_part(const struct gp_log *log,
                                      const struct gp_frame *f,
                                      const struct gp_sources *src, int parts,
                                      struct gp_frame *out);

#endif
