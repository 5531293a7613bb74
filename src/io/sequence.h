// SPDX-License-Identifier: Apache-2.0
/* Frame sequences: file names with a frame number or a view in them, and lists
 * of frames and views.
 *
 * A name is a pattern when its last component holds one of
 *   %d, %04d   printf's decimal, zero-padded to the width
 *   ####       zero-padded to as many digits as there are signs
 *   @@@@       the same
 * searched in this order; only the first kind found counts, so
 * render@2x.####.png has its number at ####. Folders have no number.
 *
 * As in OpenImageIO's tools, %V anywhere in a path is the name of a view
 * ("left"), %v its first letter ("l"), both any number of times. */
#ifndef GP_IO_SEQUENCE_H
#define GP_IO_SEQUENCE_H

#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>

enum {
    GP_FRAME_DIGITS = 9,            // of a frame number; all fit an int
    GP_FRAME_LIST_MAX = 1000000,    // frames of one list
    GP_VIEWS_MAX = 64,              // views of one list
};

/* The place of the number in a name. `len` is 0 when there is none. */
struct gp_pattern {
    const char *path;  // borrowed
    size_t at, len;    // the signs that the number replaces
    int digits;        // least number of digits, 1..GP_FRAME_DIGITS
    int views;         // places of %V and %v
};

/* Frame numbers, each once, in the order of processing. */
struct gp_frames {
    int *number;  // owned
    int n;
};

/* Names of views, in the order of the list. All zero is empty. */
struct gp_views {
    char *name[GP_VIEWS_MAX]; // owned
    int n;
};

/* Finds the places of number and views in `path`, if any.
 * Errors: GP_ERR_USAGE two frame numbers, or over GP_FRAME_DIGITS digits. */
GP_MUST_CHECK gp_status gp_pattern_find(const struct gp_log *log,
    const char *path, struct gp_pattern *out);

/* The same for an input: where a file of exactly that name exists, with #, @ or
 * % in it, that is the input, and the pattern has no places. */
GP_MUST_CHECK gp_status gp_pattern_of_input(const struct gp_log *log,
    const char *path, struct gp_pattern *out);

/* The name of one frame, owned by the caller (free()); a pattern without a
 * place gives its path. NULL when memory is full.
 *
 *   view  of one view; NULL leaves %V and %v as they are */
char *gp_pattern_name(const struct gp_pattern *p, int frame, const char *view);

/* The frames of `p` that exist on disk, ascending. A file counts when it is
 * exactly what gp_pattern_name() gives for some number >= 0: shot.7.exr is no
 * frame of shot.####.exr. `p` has a place for it; `view` as there.
 * Errors: GP_ERR_IO the folder cannot be read, or holds no such frame. */
GP_MUST_CHECK gp_status gp_frames_on_disk(const struct gp_log *log,
    const struct gp_pattern *p, const char *view, struct gp_frames *out);

/* Reads a list of items separated by commas: N, A-B, A-BxSTEP, or
 * A-B:STEP as Open Job Description writes it (template schemas of 2023-09,
 * section 3.4.1.1.1), where a STEP < 0 counts down as well, and so does B < A.
 * Spaces and tabs may stand around each number, numbers may be negative. A
 * frame that comes again is dropped.
 * Errors: GP_ERR_USAGE a wrong item, or more than GP_FRAME_LIST_MAX frames. */
GP_MUST_CHECK gp_status gp_frames_parse(const struct gp_log *log,
    const char *text, struct gp_frames *out);
void gp_frames_free(struct gp_frames *f);

/* Adds the frames of `more` that *all lacks, and sorts *all ascending.
 * False when memory is full. */
bool gp_frames_join(struct gp_frames *all, const struct gp_frames *more);

/* Reads a list of views: names, separated by commas.
 *   out  written only on GP_OK; free with gp_views_free()
 * Errors: GP_ERR_USAGE a name that is empty, comes twice or has a slash; more
 * than GP_VIEWS_MAX. */
GP_MUST_CHECK gp_status gp_views_parse(const struct gp_log *log,
                                       const char *text, struct gp_views *out);

void gp_views_free(struct gp_views *v);

/* Checks a pattern for these views.
 * Errors: GP_ERR_USAGE it has %v and no %V, and two views the same letter. */
GP_MUST_CHECK gp_status gp_views_check(const struct gp_log *log,
    const struct gp_pattern *p, const struct gp_views *v);

/* The frame number in a file's own name: the last run of up to
 * GP_FRAME_DIGITS digits before the ending, 1001 in shot_v2.1001.exr. False
 * when there is none. */
bool gp_frame_number(const char *path, int *out);

#endif
