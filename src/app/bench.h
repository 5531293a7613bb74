/* `glarepp bench`: speed against error, technique by technique. */
#ifndef GP_APP_BENCH_H
#define GP_APP_BENCH_H

#include "app/settings.h"
#include "core/status.h"

/* Measures every technique on s->inputs' one frame, or on the paper's three
 * with s->bench.paper; prints the table on stdout and writes it to the files
 * that s->bench names. What a technique takes is the time from cleaned frame
 * to layer: bright pass and glare stage. With `-` as a file, that file alone
 * goes to stdout.
 *
 * A technique that cannot run here (no GL) is a row that says so.
 * Errors: as reading, writing and gp_glare_reference(); GP_ERR_IO also when
 * gnuplot, which --plot needs, is not installed or fails.
 */
GP_MUST_CHECK gp_status gp_bench_run(const struct gp_log *log,
                                     const struct gp_settings *s);

#endif
