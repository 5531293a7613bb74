/* Checks that no output of a run replaces an input or another output, before
 * the first file is opened.
 *
 * Files are compared as files and not by their names: those that exist by
 * device and inode, those that are still to be made by their folder's and the
 * name in it. So links, ./ and folders with two names hide nothing. What is
 * no regular file (pipes, devices) loses nothing by being written and may be
 * given any number of times. So may descriptors (stdout, /dev/fd/N), whatever
 * they stand for, but not for a file that is read; of `-` there is one.
 *
 * All outputs come first, then gp_clobber_settle(), then what is read. An
 * output costs one lstat() (and its folder one stat()), an input one stat(),
 * and none at all where no output exists yet. */
#ifndef GP_APP_CLOBBER_H
#define GP_APP_CLOBBER_H

#include "app/settings.h"
#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

/* A file that is written, and whose it is. */
struct gp_clobber_file {
    dev_t device;
    ino_t node;      // the file's, or its folder's
    uint64_t tail;   // of the name in the folder; 0: the file exists
    int role, item;  // the owner's, role >= 0; role < 0: a file of an option
    bool open;       // by a descriptor that was given: others may have it too
};

/* The output that writes a file, for messages. */
struct gp_clobber_owner {
    char *name;        // as written; from malloc, NULL: memory is full
    const char *what;  // "--hdr"
    const char *as;    // its value, which may be a pattern
    const char *of;    // input that it is made of; NULL: goes without saying
    const char *view;  // of that input, or NULL
};

struct gp_clobber {
    const struct gp_log *log;
    const struct gp_settings *s;
    struct gp_clobber_owner (*owner)(const void *user,
                                     const struct gp_clobber_file *file);
    const void *user;
    struct gp_clobber_file *file; // owned
    size_t n, room;
    bool exists;                  // some output does, and could be an input
    struct {                      // folder of the last output
        char *path;               // owned
        dev_t device;
        ino_t node;
        uint64_t tail;            // of folders that are still to be made
    } folder;
};

/* Starts with the files that options with plain names write.
 *
 *   s      borrowed until the end
 *   owner  returns whose a file of gp_clobber_output() is; NULL: there is none
 *   out    ends with gp_clobber_end(), also after a failure
 *
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_clobber_begin(
    const struct gp_log *log, const struct gp_settings *s,
    struct gp_clobber_owner (*owner)(const void *user,
                                     const struct gp_clobber_file *file),
    const void *user, struct gp_clobber *out);

/* Adds an output. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_clobber_output(struct gp_clobber *c,
                                          const char *path, int role, int item);

/* Compares the outputs, which are all there, with each other, and with the
 * files that options with plain names read.
 * Errors: GP_ERR_USAGE names the first that comes twice, or is read. */
GP_MUST_CHECK gp_status gp_clobber_settle(struct gp_clobber *c);

/* Compares the outputs with a file that is read; one that does not exist loses
 * nothing. `-` is stdin.
 *   what  it is: "input"
 * Errors: GP_ERR_USAGE it would be replaced. */
GP_MUST_CHECK gp_status gp_clobber_input(const struct gp_clobber *c,
                                         const char *what, const char *path);

void gp_clobber_end(struct gp_clobber *c);

#endif
