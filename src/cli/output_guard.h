/* Checks that no output of a run replaces an input or another output, before
 * the first file is opened.
 *
 * Files are compared by identity: files that exist by device and inode, files
 * to be made by those of their folder and their name in it. So links, ./ and
 * folders with two names hide nothing. Pipes and devices lose nothing by being
 * written and may be given any number of times. So may descriptors (stdout,
 * /dev/fd/N), unless they are of a file that is read; `-` may be given once.
 *
 * All outputs are added first, then gp_output_guard_settle(), then inputs. An output
 * costs one lstat() (and its folder one stat()), an input one stat(), or none
 * where no output exists yet. */
#ifndef GP_CLI_OUTPUT_GUARD_H
#define GP_CLI_OUTPUT_GUARD_H

#include "cli/settings.h"
#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

/* An output. Its texts, but for the name, are borrowed. */
struct gp_output_guard_output {
    const char *name;  // of the file, as written
    const char *what;  // "--hdr"
    const char *as;    // its value, which may be a pattern
    const char *of;    // input that it is made of; NULL: the only one
    const char *view;  // of that input, or NULL
    long long order;   // >= 0; of two faults the one of lower order is reported
};

/* A file that is written, by an output with a name of its own. */
struct gp_output_guard_file {
    dev_t device;
    ino_t node;      // the file's, or its folder's
    uint64_t tail;   // hash of the name in the folder; 0: the file exists
    bool open;       // a descriptor, which may be given several times
    struct gp_output_guard_output by;
};

struct gp_output_guard {
    const struct gp_log *log;
    const struct gp_settings *s;
    struct gp_output_guard_file *file; // owned
    size_t n, room;
    bool exists;                  // some output exists: it may be an input
};

/* Starts with the files that options with plain names write.
 *   s    borrowed until gp_output_guard_end()
 *   out  end with gp_output_guard_end(), also after a failure
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_output_guard_begin(const struct gp_log *log,
    const struct gp_settings *s, struct gp_output_guard *out);

/* Adds an output. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_output_guard_add(struct gp_output_guard *c,
                                       const struct gp_output_guard_output *output);

/* Compares all outputs with each other, and with the files that options with
 * plain names read. Call it after the last gp_output_guard_output().
 * Errors: GP_ERR_USAGE names the first that is given twice, or is read. */
GP_MUST_CHECK gp_status gp_output_guard_settle(struct gp_output_guard *c);

/* Compares the outputs with a file that is read; `-` is stdin. A file that does
 * not exist is fine.
 *   what  option of the file, or "input", for the message
 * Errors: GP_ERR_USAGE an output would replace it. */
GP_MUST_CHECK gp_status gp_output_guard_input(const struct gp_output_guard *c,
                                         const char *what, const char *path);

void gp_output_guard_end(struct gp_output_guard *c);

/* All of it, for a command whose only outputs are those of plain options.
 *   path  of its input, NULL: none */
GP_MUST_CHECK gp_status gp_output_guard_check(const struct gp_log *log,
    const struct gp_settings *s, const char *what, const char *path);

#endif
