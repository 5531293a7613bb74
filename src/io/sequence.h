/* Frame sequences: file names with a frame number in them, and lists of
 * frames.
 *
 * A name is a pattern when its last component holds one of
 *   %d, %04d   printf's decimal, zero-padded to the width
 *   ####       zero-padded to as many digits as there are signs
 *   @@@@       the same
 * looked for in this order; only the first kind that is there counts, so
 * render@2x.####.png has its number at ####. Folders are taken as they are.
 */
#ifndef GP_IO_SEQUENCE_H
#define GP_IO_SEQUENCE_H

#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>

enum {
    GP_FRAME_DIGITS = 9,            // of a frame number; all fit an int
    GP_FRAME_LIST_MAX = 1000000,    // frames of one list
};

/* Where the number stands in a name. `len` is 0 when it has no place. */
struct gp_pattern {
    const char *path;  // borrowed
    size_t at, len;    // the signs that the number replaces
    int digits;        // least number of digits, 1..GP_FRAME_DIGITS
};

/* Frame numbers in the order in which they are made; none twice. */
struct gp_frames {
    int *number;  // owned
    int n;
};

/* Finds the number's place in `path`. A path without one is no error:
 * out->len is 0.
 * Errors: GP_ERR_USAGE two places of one kind, or more than GP_FRAME_DIGITS
 * digits.
 */
GP_MUST_CHECK gp_status gp_pattern_find(const struct gp_log *log,
                                        const char *path,
                                        struct gp_pattern *out);

/* The name of one frame, owned by the caller (free()); a pattern without a
 * place gives its path. NULL when memory is full. */
char *gp_pattern_name(const struct gp_pattern *p, int frame);

/* The frames of `p` that exist on disk, ascending. A file counts when it is
 * exactly what gp_pattern_name() gives for some number >= 0: shot.7.exr is no
 * frame of shot.####.exr. `p` has a place.
 * Errors: GP_ERR_IO the folder cannot be read, or holds no such frame.
 */
GP_MUST_CHECK gp_status gp_frames_on_disk(const struct gp_log *log,
                                          const struct gp_pattern *p,
                                          struct gp_frames *out);

/* Reads a list: items with commas between, an item is N, A-B or A-BxSTEP.
 * A-B counts down when B < A. Numbers may be negative. A frame that comes
 * again is dropped.
 * Errors: GP_ERR_USAGE says which item is wrong; more than GP_FRAME_LIST_MAX.
 */
GP_MUST_CHECK gp_status gp_frames_parse(const struct gp_log *log,
                                        const char *text,
                                        struct gp_frames *out);
void gp_frames_free(struct gp_frames *f);

/* The frame number in a file's own name: the last run of up to
 * GP_FRAME_DIGITS digits before the ending, 1001 in shot_v2.1001.exr. False
 * when there is none. */
bool gp_frame_number(const char *path, int *out);

#endif
