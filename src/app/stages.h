/* The stages of a frame, and what they share. */
#ifndef GP_APP_STAGES_H
#define GP_APP_STAGES_H

#include "app/flight.h"
#include "app/jobs.h"
#include "app/report.h"
#include "app/settings.h"
#include "app/sun.h"
#include "app/work.h"
#include "core/frame.h"
#include "core/status.h"

#include <stdbool.h>

/* What is made once for all frames. Stages of the COMPUTE phase alone change
 * it, which run on one thread, frame after frame. */
struct gp_run {
    const struct gp_settings *s;
    const struct gp_jobs *jobs;

    struct gp_glare_params glare;  // s->glare with the place of its wisdom
    char *wisdom;                  // owned
    struct gp_kernel kernel;
    bool has_kernel;
    struct gp_glare engines, group_engines;
    struct gp_suns suns;
    struct gp_ocio *ocio;          // NULL: tone maps
    struct gp_report report;
    bool ordered;                  // frames are written one after the other,
                                   // as a stream of them must be
    struct gp_raw_size raw;        // of the frames that went to stdout raw
};

/* A step of a frame. `time` is an enum gp_time, -1 for steps that are no part
 * of the picture; steps of one time add up. What the last stage needs is what
 * the targets need. `asked`, where there is one, says whether the command line
 * gives the step anything to do; what it gives counts as there without it. */
struct gp_stage {
    const char *name;
    enum gp_phase phase;
    int time;
    unsigned needs, gives;
    gp_status (*run)(struct gp_run *r, struct gp_work *w);
    bool (*asked)(const struct gp_settings *s);
};
enum { GP_STAGES = 12 };
extern const struct gp_stage gp_stages[GP_STAGES];

/* Writes the targets of a frame, and the facts about them; in
 * stages_write.c. */
GP_MUST_CHECK gp_status gp_stage_write(struct gp_run *r, struct gp_work *w);

/* What must exist for a target to be written. */
unsigned gp_target_needs(const struct gp_settings *s,
                         enum gp_target_kind kind);

/* Reads the kernel when it is a file, before the first frame, so that a bad
 * one is an error whatever the frames hold; checks nothing else. */
GP_MUST_CHECK gp_status gp_run_read_kernel(const struct gp_log *log,
                                           struct gp_run *r);

#endif
