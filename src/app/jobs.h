/* The frames that a run makes, and their names. Settled before the first frame
 * is read, so that a wrong name costs no work. */
#ifndef GP_APP_JOBS_H
#define GP_APP_JOBS_H

#include "app/settings.h"
#include "core/status.h"
#include "io/read.h"
#include "io/sequence.h"

#include <stdbool.h>

/* Contents of a file that is written. */
enum gp_target_kind {
    GP_TARGET_HDR,
    GP_TARGET_LAYER,
    GP_TARGET_PICTURE,
    GP_TARGET_SENSORS,
    GP_TARGET_POLYGONS,
    GP_TARGET_SUNMAP,
    GP_TARGET_INTENSITY,
};

/* A file, or one a frame or view when its name is a pattern. */
struct gp_output {
    enum gp_target_kind kind;
    struct gp_pattern name;
    bool whole;  // holds all views of a frame: one for gp_jobs.views jobs
    bool hero;   // made of the first view of a frame only
};

/* One frame to make, or one view of it. */
struct gp_job {
    char *input;       // owned
    bool numbered;     // by a pattern, for an output that is one, or in stdin
    int frame;         // when numbered
    const char *view;  // of gp_jobs.view; NULL without views
};

/* The views of a frame follow each other, in the order of the list. */
struct gp_jobs {
    struct gp_job *job;        // owned; at least one
    int n;
    struct gp_output *target;  // owned; in the order they are written
    int targets;
    struct gp_views view;      // owned; n is 0 without views
    int views;                 // consecutive jobs that share one input, >= 1
    bool views_inside;         // the views are parts or channels of the inputs
    bool views_found;          // and are all that a frame names: no other frame
                               // may name others
    struct gp_members members; // frames of stdin, one for `views` jobs; n is 0
                               // without
};

/* Expands the inputs and checks every name that the command line gives:
 *
 *   - a pattern means the frames of --frames, or those on disk; a file
 *     that really has the pattern's name is that file
 *   - %V and %v in inputs are the views of --views, or left,right: a
 *     file for each, and `views` is 1. Without them, --views are parts or
 *     channels of each file: `views` jobs for it. Not both in one run
 *   - without --views, or with --views all, they are those that the first input
 *     names which can be looked at (a file, or the first image of stdin), where
 *     an output has a place for several; a line says which were taken. Outputs
 *     without %V or %v then hold the first: `hero`
 *   - several views of --views need %V or %v in all outputs but `-`
 *   - of several views --hdr without %V or %v holds all: it is `whole`
 *   - several frames need patterns or `-` for all their outputs, and for
 *     patterns a number each, no two the same: the pattern's, or the last one
 *     in a plain file's name
 *   - when all else is right, stdin is read to its end: each image in it is a
 *     frame, numbered by --frames or from 1
 *   - no file twice among all that are written, and none that is read; `-` at
 *     most once among outputs and never a terminal
 *   - gp_write_check() holds for the first frame's outputs
 *   - every frame of --frames is there, and every view of a frame, unless
 *     --skip-bad-frames is given, or gp_job_made() is true for it
 *
 *   s    borrowed by *out
 *   out  written only on GP_OK; free with gp_jobs_free()
 * Errors: GP_ERR_USAGE; GP_ERR_IO a pattern without frames, frames that are
 * missing, and as gp_write_check(). */
GP_MUST_CHECK gp_status gp_jobs_make(
    const struct gp_log *log, const struct gp_settings *s, struct gp_jobs *out);
void gp_jobs_free(struct gp_jobs *j);

/* True for --views all, and where it says nothing. */
bool gp_views_all(const struct gp_settings *s);

/* Takes all views that the first input names which can be looked at, where an
 * output has a place for several, and says in one line which were taken; j has
 * one job for each frame, and gets one for each view.
 * Errors: GP_ERR_DATA a view is no name of a file, and outputs have %V;
 * GP_ERR_USAGE too many frames; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_jobs_find_views(const struct gp_log *log,
    const struct gp_settings *s, struct gp_jobs *j);

/* Checks that a frame names no views but those of j->view, for runs whose
 * views were found.
 * Errors: GP_ERR_USAGE it has others; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_jobs_check_views(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_jobs *j,
    const struct gp_frame *f);

/* Jobs of one frame: one a view, 1 without views. */
int gp_jobs_of_frame(const struct gp_jobs *j);

/* The name of one target for one job; the caller owns it (free()). NULL when
 * memory is full. */
char *gp_job_name(const struct gp_job *job, const struct gp_output *target);

/* True when p->no_clobber is set, there are outputs and all of the job's
 * exist: nothing is left to make. A file that holds all views is made from
 * all of them: with one, those of every view of the frame must be there.
 *
 *   job  one of j->job */
bool gp_job_made(const struct gp_write_params *p, const struct gp_jobs *j,
                 const struct gp_job *job);

/* Checks that every file that the run writes is written once, and is none that
 * it reads (clobber.h).
 *
 *   also  files that it reads because another names them; NULL: none yet
 *
 * Errors: GP_ERR_USAGE */
GP_MUST_CHECK gp_status gp_jobs_check_names(
    const struct gp_log *log, const struct gp_settings *s,
    const struct gp_jobs *j, const struct gp_texts *also);

#endif
