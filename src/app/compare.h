/* glarepp compare: how far two images, or two sequences, are apart. */
#ifndef GP_APP_COMPARE_H
#define GP_APP_COMPARE_H

#include "app/settings.h"
#include "core/status.h"

/* Compares the two inputs, part by part, and frame by frame where one of them
 * is a pattern: those of --frames, else all that either has on disk. Prints
 * to stdout, or JSON in its place, and writes the heatmap.
 *
 * Returns the program's exit status: the worst of all pairs as in enum
 * gp_compare_result, a frame that cannot be read being a file error and not
 * the end; GP_ERR_BUG when memory is full.
 */
int gp_compare_run(const struct gp_log *log, const struct gp_settings *s);

/* Checks what the option table cannot.
 * Errors: GP_ERR_USAGE with one line. */
GP_MUST_CHECK gp_status gp_compare_check(const struct gp_log *log,
                                         const struct gp_settings *s);

#endif
