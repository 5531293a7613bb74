// SPDX-License-Identifier: Apache-2.0
/* Finds the frames of a run and the names of its files, before the first frame
 * is read, so that a wrong name costs no work. */
#ifndef GP_CLI_JOBS_H
#define GP_CLI_JOBS_H

#include "cli/options.h"
#include "io/sequence.h"

/* Contents of a file that is written; those of --debug in its order. */
enum gp_target_kind {
    GP_TARGET_HDR,
    GP_TARGET_LAYER,
    GP_TARGET_PARTS,
    GP_TARGET_PICTURE,
    GP_TARGET_SENSORS,
    GP_TARGET_POLYGONS,
    GP_TARGET_SUNMAP,
    GP_TARGET_INTENSITY,
    GP_TARGET_SCISSOR,
    GP_TARGET_SETS,
};
struct gp_target_row {
    const char *option, *text; // the text for notes
    enum glarepp_view view;
};
extern const struct gp_target_row gp_targets[];

/* The i-th file that --hdr, --layer, --parts, -o and --debug name, in writing
 * order, and its kind; NULL after the last. */
const char *gp_output_at(const struct gp_settings *s, int i,
                         enum gp_target_kind *kind);

/* A file, or one for each frame or view when its name is a pattern. */
struct gp_output {
    enum gp_target_kind kind;
    struct gp_pattern name;
    bool whole;  // holds all views of a frame: one file for gp_jobs.views jobs
    bool hero;   // holds only the first view of a frame
};

/* One frame to make, or one view of it. */
struct gp_job {
    char *input;       // owned by the first of gp_jobs.views consecutive ones
    bool numbered;     // has a number: by an input or output pattern, or stdin
    int frame;         // when numbered
    const char *view;  // of gp_jobs.view; NULL without views
    bool failed;       // and was skipped
};

/* Takes tone-mapped pictures in place of the files of a run: `picture` has the
 * samples of f's data window, display-linear, or with --tonemap none
 * scene-linear. Both end with the call. */
struct gp_report;
struct gp_taker {
    gp_status (*take)(void *user, const struct gp_log *log,
                      const struct gp_frame *f,
                      const struct gp_planes *picture);
    void *user;
    struct gp_report *report; // of several runs; open where one is wanted
};

/* The views of a frame follow each other, in the order of the list. */
struct gp_jobs {
    struct gp_job *job;        // owned; at least one
    int n;
    struct gp_output *target;  // owned; in writing order
    int targets;
    struct gp_views view;      // owned; n is 0 without views
    int views;                 // consecutive jobs that share one input, >= 1
    bool views_inside;         // the views are parts or channels of the inputs
    bool views_found;          // and were found in the first input: no frame
                               // may have others
    char *views_line;          // owned; the warning that says so, or NULL
    const struct gp_taker *taker; // borrowed; NULL: files are written
    struct gp_members members; // frames of stdin, one for `views` jobs; n is 0
                               // without stdin
};

/* Expands the inputs and checks every name that the command line gives, as
 * man/sequences.md says. %V and %v in inputs are a file for
 * each view; without them the views of --views, or of the first file, are parts
 * or channels of each file: `views` jobs for it. Outputs without a place for a
 * view are `whole` or `hero` then. After all other checks, stdin is read to its
 * end: each image in it is a frame.
 *
 *   s    borrowed by *out
 *   out  written only on GP_OK; free with gp_jobs_free()
 * Errors: GP_ERR_USAGE; GP_ERR_IO frames that are missing, and as
 * gp_write_check(); GP_ERR_DATA a view that cannot be part of a file name. */
GP_MUST_CHECK gp_status gp_jobs_make(
    const struct gp_log *log, const struct gp_settings *s, struct gp_jobs *out);
void gp_jobs_free(struct gp_jobs *j);

/* Checks that a frame has no views but those of j->view, for runs with
 * j->views_found. Errors: GP_ERR_USAGE it has others; GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_jobs_check_views(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_jobs *j,
    const struct gp_frame *f);

/* Jobs of one frame: one a view, 1 without views. */
int gp_jobs_of_frame(const struct gp_jobs *j);

/* The name of one target for one job, from malloc; NULL when memory is full. */
char *gp_job_name(const struct gp_job *job, const struct gp_output *target);

/* Finds the number of a frame: the job's, else the one in its file's name. */
bool gp_job_number(const struct gp_job *job, int *number);

/* Finds the file beside a job's frame, from malloc; the path may be a pattern.
 * Errors: GP_ERR_USAGE it needs views or numbers. */
GP_MUST_CHECK gp_status gp_job_beside(const struct gp_log *log,
    const struct gp_job *job, const char *path, char **name);

/* True when there are outputs and all of the job's are kept (gp_write_kept());
 * with an output that holds all views, those of every view of the frame. */
bool gp_job_complete(const struct gp_log *log, const struct gp_write_params *p,
                     const struct gp_jobs *j, const struct gp_job *job);

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

/* Checks that the run writes no file twice, and none that it reads, as the `n`
 * of `also`, which another file names. Errors: GP_ERR_USAGE. */
GP_MUST_CHECK gp_status gp_jobs_check_names(
    const struct gp_log *log, const struct gp_settings *s,
    const struct gp_jobs *j, const char *const *also, int n);

#endif
