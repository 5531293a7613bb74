/* How the frames of a run ended: which failed, how many were there already. */
#ifndef GP_APP_TALLY_H
#define GP_APP_TALLY_H

#include "app/jobs.h"
#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>

/* Zeroed is empty. */
struct gp_tally {
    const struct gp_jobs *jobs;  // borrowed
    bool *failed;                // one a job, owned
    int bad;                     // frames with a job that failed
    int kept;                    // jobs left alone, by --no-clobber
};

/* Starts with no frame failed. Free with gp_tally_free().
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_tally_make(const struct gp_log *log,
                                      const struct gp_jobs *jobs,
                                      struct gp_tally *out);
void gp_tally_free(struct gp_tally *t);

/* Counts jobs->job[index] as failed; a frame once, whatever its views. */
void gp_tally_fail(struct gp_tally *t, int index);

/* The failed frames in the order of the jobs: a list that --frames takes back
 * (2-4,9,20-40x10) when all have numbers, else the names of the inputs that
 * failed with ", " between. What does not fit into `size` (at least 64) bytes
 * is counted: "and 17 more". Returns true when the text is a whole list of
 * numbers. */
bool gp_tally_list(const struct gp_tally *t, char *text, size_t size);

/* Says how many frames were left alone (a warning), and how many failed and
 * which, each in one line and only when there are any.
 * Errors: GP_ERR_FRAMES some failed. */
GP_MUST_CHECK gp_status gp_tally_end(const struct gp_log *log,
                                     const struct gp_tally *t);

#endif
