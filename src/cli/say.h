/* Words about a run for the person who started it: the notes of --verbose about
 * a frame, and the line on a terminal about the run. */
#ifndef GP_CLI_SAY_H
#define GP_CLI_SAY_H

#include "cli/jobs.h"
#include "cli/report.h"
#include "core/status.h"

#include <stdio.h>

/* Prints notes about a frame: what was read, the light that glares, the kernel
 * and its angle of view, lights, ghosts, measured errors, what was written; and
 * why, where an option or the frame decided. f->settings is set. */
void gp_say_frame(const struct gp_log *log, const struct gp_frame_report *f);

/* The frames of a run together. Zeroed is none. */
struct gp_tally {
    int made;                    // jobs
    char name[1024];             // of the first one's picture, else output
    long long fewest, most;      // sources
    struct glarepp_sense_facts light; // sums of light, bright, lamps
    double narrow, wide;         // angles of view, degrees; 0: no kernel has any
    const char *fov_from;        // of the last
    const struct glarepp_plan_facts *ocio; // borrowed; NULL: tone curves
};

void gp_tally_add(struct gp_tally *t, const struct gp_frame_report *f);

/* Prints what happened, without a newline: the picture, sources, light, angle of
 * view, tones, wall time. There are targets, and at least one job was made. */
void gp_tally_print(FILE *f, const struct gp_tally *t,
                    const struct gp_settings *s, const struct gp_jobs *jobs,
                    double seconds);

#endif
