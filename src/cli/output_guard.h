/* Checks that no output of a run replaces an input or another output, before
 * the first file is opened.
 *
 * Files are compared by identity: files that exist by device and inode, files
 * to be made by those of their folder and their name in it. Pipes and devices
 * lose nothing by being written and may be given any number of times. So may
 * descriptors (stdout, /dev/fd/N), unless they are of a file that is read; `-`
 * may be given once.
 *
 * It starts as {.log, .s}, and is ended after a failure too. All outputs are added first, then gp_output_guard_settle(), then inputs. */
#ifndef GP_CLI_OUTPUT_GUARD_H
#define GP_CLI_OUTPUT_GUARD_H

#include "cli/options.h"

struct gp_output_guard {
    const struct gp_log *log;
    const struct gp_settings *s;
    struct output *file;          // owned
    size_t n;
    bool exists;                  // some output exists: it may be an input
};

/* Adds an output: the option `what` with its value `as`, which may be a
 * pattern, made of the input `of` (NULL: the only one); `as` and `of` are
 * borrowed. */
GP_MUST_CHECK gp_status gp_output_guard_add(struct gp_output_guard *c,
    const char *path, const char *what, const char *as, const char *of);

/* Adds the files that options with plain names write. Compares all outputs with
 * each other, and with the files that options with plain names read.
 * Errors: GP_ERR_USAGE names the first that is given twice, or is read. */
GP_MUST_CHECK gp_status gp_output_guard_settle(struct gp_output_guard *c);

/* Compares the outputs with a file that is read, of the option `what`; `-` is
 * stdin. Errors: GP_ERR_USAGE an output would replace it. */
GP_MUST_CHECK gp_status gp_output_guard_input(const struct gp_output_guard *c,
                                         const char *what, const char *path);

void gp_output_guard_end(struct gp_output_guard *c);

/* All of it, for a command whose outputs have plain names.
 *   path  of its input, NULL: none */
GP_MUST_CHECK gp_status gp_output_guard_check(const struct gp_log *log,
    const struct gp_settings *s, const char *what, const char *path);

#endif
