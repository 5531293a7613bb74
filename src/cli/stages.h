// SPDX-License-Identifier: Apache-2.0
/* The stages of a frame, their shared data, and the state of a frame between
 * them. */
#ifndef GP_CLI_STAGES_H
#define GP_CLI_STAGES_H

#include "cli/report.h"
#include "io/plane.h"

/* The first stage reads, the last writes: on any thread, frames in any order.
 * COMPUTE runs on one thread, frame after frame. */
enum gp_phase { GP_PHASE_READ, GP_PHASE_COMPUTE, GP_PHASE_WRITE };

/* Data that stages need and give, as bits: planes of the library's frame, then
 * its other state. */
enum {
    GP_HAS_RGB = 1 << GLAREPP_CLEAN,     // as it is read, then without NaN
    GP_HAS_SOURCES = 1 << GLAREPP_SOURCES,
    GP_HAS_LAYER = 1 << GLAREPP_GLARE,   // dark where there is no source
    GP_HAS_LIT = 1 << GLAREPP_LIT,
    GP_HAS_SHOWN = 1 << GLAREPP_SHOWN,
    GP_HAS_SCENE = 1 << GLAREPP_VIEWS,   // posed
    GP_HAS_RELIT = 2 << GLAREPP_VIEWS,   // RGB with the light of --relight
    GP_HAS_SUNS = 4 << GLAREPP_VIEWS,    // placed, and their shares measured
    GP_HAS_KERNEL = 8 << GLAREPP_VIEWS,
    GP_HAS_MEASURED = 16 << GLAREPP_VIEWS, // errors of the layer
    GP_HAS_FLARE = 32 << GLAREPP_VIEWS,  // LAYER with flare and all lights
    GP_HAS_LENS = 64 << GLAREPP_VIEWS,   // LAYER with ghosts of --lens
    GP_HAS_SHARES = 128 << GLAREPP_VIEWS, // facts about lights, maps of --debug
    GP_HAS_END = 256 << GLAREPP_VIEWS,   // facts; the plan has its state back
    GP_HAS_FILES = 512 << GLAREPP_VIEWS, // the outputs
};

/* One frame in flight and the facts about it. Zeroed is none. It owns its
 * planes and what the facts own. */
struct gp_frame_state {
    const struct gp_log *log;      // of messages about this frame; borrowed
    const struct gp_job *job;      // borrowed
    int view;                      // index among the views of its input
    struct gp_frame file;          // as it was read
    struct gp_frame *group; // `groups` frames whose light glares: layers of
    int groups;             // --light-group, which borrow from the file, or
                            // --source
    struct gp_plane depth, mask, normal[3], albedo[3], source_mask;
    struct gp_stored_image deep;
    char *deep_name; // its file, if that is not the frame's; owned
    struct glarepp_frame *frame;   // borrows the planes of all of these
    bool sphere;                   // a lat-long, by its file or --projection
    bool converted;                // its layers are in --output-space
    struct glarepp_plan *plan;     // of its numbers; borrowed
    struct gp_own_plan *own;       // of a run with keys, else NULL; the caller
                                   // ends it after the frame
    struct gp_frame_report facts;
};

/* The settings of a frame with keys, and what is made of them. */
struct gp_own_plan {
    struct gp_settings s;          // borrows from the run's
    struct glarepp_kernel *kernel; // where it differs; else NULL
    struct glarepp_plan *plan;
    struct gp_own_plan *next;
};
/* Ends a list of them, on the thread that computes: GL is of one thread. */
void gp_own_plans_end(struct gp_own_plan **list);

/* Starts with the facts that job `index` gives, and a plan of its own where
 * options have keys. End it also after a failure. */
struct gp_run;
GP_MUST_CHECK gp_status gp_frame_state_begin(const struct gp_log *log,
    const struct gp_run *r, int index, struct gp_frame_state *out);
void gp_frame_state_end(struct gp_frame_state *fs);

/* Frees planes that no later stage needs; bits GP_HAS_*. */
void gp_frame_state_release(struct gp_frame_state *fs, unsigned dead);

/* Data that is made once for all frames. The write stage changes only `raw`,
 * and only when `ordered`, and those that compute `warned_axis`. */
struct gp_run {
    const struct gp_settings *s; // numbers with keys are in a frame's own
    const struct gp_jobs *jobs;
    struct glarepp *gp;
    struct glarepp_kernel *kernel;
    struct glarepp_kernel **more; // of light groups; owned
    struct glarepp_plan *plan;
    struct gp_report *report;
    bool ordered;                  // frames are written in order: some output
                                   // is a stream
    bool layer_ends;               // no stage after compose reads the layer
    bool details;                  // of facts are wanted
    bool warned_axis;              // that a style is without its flare or lens
    struct gp_raw_size raw;        // of raw frames on stdout
};

/* Reads depth and coverage, where --depth, --mask and their files say so or a
 * channel is depth by its name; gives them to the library and names them in the
 * facts. */
GP_MUST_CHECK gp_status gp_run_occluders(const struct gp_run *r,
                                         struct gp_frame_state *fs);

/* Reads --source as a group. Errors: GP_ERR_DATA its data window or primaries are not those
 * of the frame as it was read. */
GP_MUST_CHECK gp_status gp_read_source(const struct gp_run *r,
                                       struct gp_frame_state *fs);

/* Names the depth for the report, which nothing reads without lights: only one
 * that --depth asked for may not be missing. */
GP_MUST_CHECK gp_status gp_name_own_depth(const struct gp_run *r,
                                          struct gp_frame_state *fs);

/* Reads --deep, or a deep part of the frame's file, where there is one, and gives it
 * to the library. */
GP_MUST_CHECK gp_status gp_read_samples(const struct gp_run *r,
                                        struct gp_frame_state *fs);

/* Reads --source-mask and gives it to the library. */
GP_MUST_CHECK gp_status gp_read_source_mask(const struct gp_run *r,
                                            struct gp_frame_state *fs);

/* A stage of a frame, a step of the library or a function. `time` is an enum
 * gp_time, or -1 for stages that are not part of making the picture. The last
 * stage also needs what the targets need. */
struct gp_stage {
    const char *name;
    int time;
    unsigned needs, gives;
    enum glarepp_step step;
    gp_status (*run)(struct gp_run *r, struct gp_frame_state *fs); // NULL: step
};
enum { GP_STAGES = 15 };
extern const struct gp_stage gp_stages[GP_STAGES];

/* Returns the data that a target needs, as bits GP_HAS_*. */
unsigned gp_target_needs(const struct gp_settings *s, enum gp_target_kind kind);

#endif
