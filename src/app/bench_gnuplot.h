/* A gnuplot script becomes a picture. */
#ifndef GP_APP_BENCH_GNUPLOT_H
#define GP_APP_BENCH_GNUPLOT_H

#include "core/status.h"

#include <stddef.h>

/* Runs gnuplot as a child, without any shell and without the user's start-up
 * file, with `script` as its standard input.
 *
 *   out   what it wrote to its standard output; owned, free(); one more byte,
 *         0, stands behind `size`. Written only on GP_OK.
 *
 * Errors: GP_ERR_IO no gnuplot (names the package), or it failed (its first
 * line); GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_gnuplot(const struct gp_log *log, const char *script,
                                   char **out, size_t *size);

#endif
