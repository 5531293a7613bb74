/* One frame on its way through the stages, and what becomes known of it. */
#ifndef GP_APP_WORK_H
#define GP_APP_WORK_H

#include "app/jobs.h"
#include "app/light_group.h"
#include "app/report.h"
#include "core/frame.h"
#include "core/status.h"
#include "glare/sensors.h"

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
    GP_HAS_SHARES = 1 << 11,   // facts.light, and maps of --debug
};

/* A picture of --debug that is no picture of the frame: sun maps, intensity
 * map. */
struct gp_map_picture {
    struct gp_planes planes; // w * h samples each; empty: not asked for
    int w, h;
};

/* Zeroed is none. Planes and lists belong to it. */
struct gp_work {
    const struct gp_log *log;      // for messages about this frame; borrowed
    const struct gp_job *job;      // borrowed
    int view;                      // its place among the views of its input,
                                   // which stand one behind the other
    struct gp_frame frame;
    struct gp_light_groups groups;
    struct gp_sources sources;     // of the frame, or of the groups together
    struct gp_sources joined;      // sources and lights; empty: no lights
    struct gp_map_picture sunmap, intensity;
    char **names;                  // files written: facts.n_outputs, then
                                   // the one under way, then NULL
    int targets;
    struct gp_light *light;        // what facts.light points to
    char *depth, *mask;            // ... and facts.depth, facts.mask
    struct gp_facts facts;
};

/* Starts with the facts that jobs->job[index] gives. End with gp_work_end(), also after
 * a failure. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_work_begin(const struct gp_log *log,
                                      const struct gp_jobs *jobs, int index,
                                      struct gp_work *out);
void gp_work_end(struct gp_work *w);

/* Makes frame.layer all 0, for frames without light. Errors: GP_ERR_BUG out of
 * memory. */
GP_MUST_CHECK gp_status gp_work_dark_layer(struct gp_work *w);

/* Frees what the frame no longer needs; bits as above. */
void gp_work_release(struct gp_work *w, unsigned dead);

#endif
