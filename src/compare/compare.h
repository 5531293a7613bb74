/* glarepp compare: differences of two images, or of two sequences. */
#ifndef GP_COMPARE_COMPARE_H
#define GP_COMPARE_COMPARE_H

#include "core/frame.h"
#include "core/status.h"
#include "io/read.h"
#include "io/sequence.h"
#include "io/write.h"

#include <math.h>
#include <stdbool.h>

/* Limits, idiff's and our own, and pictures to write. A value counts when it is
 * over an absolute limit and the relative one; errors are of stored values. */
struct gp_compare_params {
    float fail, warn;                   // absolute
    float fail_relative, warn_relative; // of the mean of both magnitudes
    float fail_percent, warn_percent;   // of pixels that may be over it
    float hard_fail, hard_warn;         // that no pixel may exceed, where more
                                        // pixels fail than may
    int allow_failures;                 // pixels that may fail by any amount;
                                        // < 0: all
    float fail_flip, fail_rel;          // mean FLIP, rel_l2; +Inf: no limit
    bool perceptual;                    // failing: what an eye sees (Yee)
    bool all_parts;                     // else the first
    struct gp_numbers flip_exposures;   // start, stop, count; n 0: automatic
    bool no_flip;
    const char *heatmap;                // picture of FLIP; NULL: not wanted
    const char *difference;             // picture of a - b; NULL: not wanted
    bool only_different, absolute;      // only of pairs that differ; |a - b|
    float scale;                        // times this
};
#define GP_COMPARE_DEFAULTS                                                   \
    { .fail = 1e-6f, .warn = 1e-6f, .hard_fail = INFINITY,                    \
      .hard_warn = INFINITY, .fail_flip = INFINITY, .fail_rel = INFINITY,     \
      .scale = 1.0f }

/* The exit status of a wrong command line (EX_USAGE of sysexits.h): no
 * difference has it. */
enum { GP_COMPARE_USAGE = 64 };

/* Results; the numbers are exit statuses, worse is larger. */
enum gp_compare_result {
    GP_COMPARE_MATCH = 0,
    GP_COMPARE_WARNING = 1,
    GP_COMPARE_FAILURE = 2,
    GP_COMPARE_DIFFERENT = 3, // cannot be compared
    GP_COMPARE_FILE = 4,      // a file could not be read or written
};

/* The files of a run. */
struct gp_compare_names {
    struct gp_pattern in[2];   // .len 0: a plain file
    struct gp_pattern heatmap, difference; // only those of params
    struct gp_frames frames;   // n 0: one pair of plain files
};

/* A run; all is borrowed. */
struct gp_compare_request {
    const struct gp_compare_params *params;
    const char *input[2];
    const char *frames;  // list as written; NULL: the frames on disk
    const char *json;    // file or "-"; NULL: not wanted
    const struct gp_read_params *read;
    const struct gp_write_params *write; // of pictures
    /* Called before any file is read: fails where a picture or the JSON would
     * replace an input or another output. NULL: not asked. */
    gp_status (*check_names)(const struct gp_log *log, const void *user,
                             const struct gp_compare_names *names);
    const void *user;
};

/* Compares the two inputs, part by part with all_parts, and frame by frame
 * where one of them is a pattern: those of --frames, else all that either has
 * on disk. Prints idiff's lines and more to stdout, the last of them PASS,
 * WARNING or FAILURE, or JSON in its place, and writes the pictures.
 *
 *   log  at GP_LEVEL_ERROR only FAILURE is printed, to stderr as idiff -q does;
 *        at GP_LEVEL_INFO the figures of a sequence's frames in full
 *
 * Returns the program's exit status: the worst enum gp_compare_result of all
 * pairs (a frame that cannot be read is a file error, and the next frame is
 * compared); GP_COMPARE_USAGE; GP_ERR_BUG when memory is full. */
int gp_compare_run(const struct gp_log *log,
                   const struct gp_compare_request *req);

/* Checks what the option table cannot.
 * Errors: GP_ERR_USAGE with one line. */
GP_MUST_CHECK gp_status gp_compare_check(const struct gp_log *log,
    const char *const *inputs, int n, const struct gp_compare_params *p);

#endif
