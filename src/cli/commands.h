// SPDX-License-Identifier: Apache-2.0
/* The main job, a run over frames, and the commands that are more than that.
 * Their errors are those of reading, of the library and of writing. */
#ifndef GP_CLI_COMMANDS_H
#define GP_CLI_COMMANDS_H

#include "cli/progress.h"

/* Runs frames through the stages, several in flight at once. A stage runs only
 * when a later one, or an output, needs its result. Computing, reports, messages
 * and streams keep the order of the jobs, so that no result depends on how many
 * are in flight.
 *
 * Makes all frames but those for which gp_job_complete() is true; ends at the
 * first that fails. With --skip-bad-frames it skips frames that have bad data
 * or cannot be read or written, reports each, and lists them at the end.
 * Errors: GP_ERR_FRAMES some frames were skipped as bad. */
GP_MUST_CHECK gp_status gp_pipeline_run(
    const struct gp_log *log, struct glarepp *gp, const struct gp_settings *s,
    const struct gp_jobs *jobs, struct gp_progress *progress);

/* A command. *status, 0 before, becomes the exit status: 1 where kernel --check
 * finds a fault, lens --check finds a lens that does not make what its file
 * claims, or a row of sets draws another picture than the first. */
typedef gp_status gp_command_run(const struct gp_log *log, struct glarepp *gp,
                                 const struct gp_settings *s, int *status);
gp_command_run gp_bench_command;  // measures every technique on one frame
gp_command_run gp_kernel_command; // writes, lists and checks kernels
gp_command_run gp_lens_command;   // lists, checks and draws lenses
gp_command_run gp_sets_command;   // draws each row of O'Rorke's Table 15-1
gp_command_run gp_styles_command; // lists the styles, or draws a sheet of them

/* Exit statuses: first those of glarepp_compare_facts.result; a wrong command
 * line has that of sysexits.h, which no difference has. */
enum {
    GP_COMPARE_MATCH = 0,
    GP_COMPARE_WARNING = 1,
    GP_COMPARE_FAILURE = 2,
    GP_COMPARE_DIFFERENT = 3, // cannot be compared
    GP_COMPARE_FILE = 4,      // a file could not be read or written
    GP_COMPARE_USAGE = 64,
};

/* glarepp compare: compares the two inputs, part by part with --all, and frame
 * by frame where one of them is a pattern. Prints idiff's lines and more to
 * stdout, or JSON in their place, and writes the pictures. With --quiet it
 * prints only FAILURE, to stderr as idiff -q does. Returns GP_OK; *status is the
 * worst of all pairs (a frame that cannot be read is a file error, and the next
 * frame is compared); GP_COMPARE_USAGE; GP_ERR_BUG: memory is full. */
gp_command_run gp_compare_command;

#endif
