/* The stages of a frame, and what they share. */
#ifndef GP_APP_STAGES_H
#define GP_APP_STAGES_H

#include "app/jobs.h"
#include "app/report.h"
#include "app/settings.h"
#include "app/sun.h"
#include "core/frame.h"
#include "core/status.h"

#include <stdbool.h>

/* What stages need and give, as bits. */
enum {
    GP_HAS_RGB = 1 << 0,       // frame.rgb
    GP_HAS_SOURCES = 1 << 1,   // sources
    GP_HAS_KERNEL = 1 << 2,    // kernel; stays for the next frame
    GP_HAS_LAYER = 1 << 3,     // frame.layer; empty when there is no source
    GP_HAS_FLUX = 1 << 4,      // facts.flux_out
    GP_HAS_MEASURED = 1 << 5,  // facts.error
    GP_HAS_LIT = 1 << 6,       // frame.lit
    GP_HAS_SHOWN = 1 << 7,     // frame.shown
    GP_HAS_FILES = 1 << 8,     // all that is written
    GP_HAS_SUNS = 1 << 9,      // suns placed, and seen or being seen
    GP_HAS_FLARE = 1 << 10,    // frame.layer with lens flare and all lights
};

/* A run, and the frame it is at. */
struct gp_run {
    const struct gp_log *log;
    const struct gp_settings *s;
    const struct gp_jobs *jobs;

    struct gp_glare_params glare;  // s->glare with the place of its wisdom
    char *wisdom;                  // owned
    struct gp_kernel kernel;
    bool has_kernel;
    struct gp_glare engines;
    struct gp_suns suns;
    struct gp_ocio *ocio;          // NULL: tone maps
    struct gp_report report;
    struct gp_raw_size raw;        // of the frames that went to stdout raw

    const struct gp_job *job;
    struct gp_frame frame;
    struct gp_sources sources;
    struct gp_sources joined;      // sources and lights; empty: no lights
    char **names;                  // one a target: files written, owned
    struct gp_facts facts;
};

/* A step of a frame. `time` is an enum gp_time, -1 for steps that are no part
 * of the picture; steps of one time add up. What the last stage needs is what
 * the targets need. `asked`, where there is one, says whether the command line
 * gives the step anything to do; what it gives counts as there without it. */
struct gp_stage {
    const char *name;
    int time;
    unsigned needs, gives;
    gp_status (*run)(struct gp_run *r);
    bool (*asked)(const struct gp_settings *s);
};
enum { GP_STAGES = 11 };
extern const struct gp_stage gp_stages[GP_STAGES];

/* What must exist for a target to be written. */
unsigned gp_target_needs(const struct gp_settings *s,
                         enum gp_target_kind kind);

/* Frees what the frame no longer needs; bits as above. */
void gp_run_release(struct gp_run *r, unsigned dead);

/* Reads the kernel when it is a file, before the first frame, so that a bad
 * one is an error whatever the frames hold; checks nothing else. */
GP_MUST_CHECK gp_status gp_run_read_kernel(struct gp_run *r);

#endif
