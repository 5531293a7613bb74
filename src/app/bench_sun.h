/* bench with a sun: how fast each way finds what shows of the lights, and how
 * wrong. The paper's table of two rows (masking, locking), grown. */
#ifndef GP_APP_BENCH_SUN_H
#define GP_APP_BENCH_SUN_H

#include "app/settings.h"
#include "core/status.h"
#include "sun/stage.h"

/* Measures s->inputs.at[0] with the lights that the command line names, and
 * writes the table: to --csv or --json where they are given, else to stdout.
 * Rows are exact, readback, and masks of 4 to 64 texels a side, disc and
 * square, summed in float, in 8 bits and by bilinear quarters. Times are
 * medians of s->bench.runs, after a first run that makes contexts. The error is
 * the difference to exact over all lights.
 * Errors: GP_ERR_USAGE a plot is asked for; those of reading and writing. A
 * method that cannot run is a row that says why. */
GP_MUST_CHECK gp_status gp_bench_sun(const struct gp_log *log,
                                     const struct gp_settings *s,
                                     const struct gp_sun_reader *reader);

#endif
