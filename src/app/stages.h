/* The stages of a frame, what they share, and the frame on its way through
 * them. */
#ifndef GP_APP_STAGES_H
#define GP_APP_STAGES_H

#include "app/flight.h"
#include "app/jobs.h"
#include "app/report.h"
#include "app/settings.h"
#include "core/frame.h"
#include "core/status.h"
#include "glare/engine.h"
#include "glare/kernel.h"
#include "glare/sensors.h"
#include "sun/stage.h"

#include <stdatomic.h>
#include <stdbool.h>

/* Data that stages need and give, as bits. */
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

/* A picture of --debug with a size of its own: sun maps, intensity map. */
struct gp_map_picture {
    struct gp_planes planes; // w * h samples each; empty: not asked for
    int w, h;
};

/* A layer of the frame's file that holds the light of some lamps only
 * (--light-group). Its frame borrows from the frame that it was read beside.
 * With light groups the glare is that of these layers, each compared with the
 * threshold by itself, and the frame gets their sum. */
struct gp_light_group {
    struct gp_frame frame;
    struct gp_sources sources;
};

/* A kernel, and the frames it was made for: those of this pixel aspect and,
 * where `tinted`, of these primaries. Frames are written while the next ones
 * have another: whoever holds it ends with gp_run_kernel_free(). */
struct gp_run_kernel {
    struct gp_kernel k;
    float chromaticities[8], aspect;
    bool tinted;
    atomic_int holders;
};
void gp_run_kernel_free(struct gp_run_kernel **k);

/* One frame on its way, and what is known of it. Zeroed is none. Planes and
 * lists belong to it. */
struct gp_frame_state {
    const struct gp_log *log;      // for messages about this frame; borrowed
    const struct gp_job *job;      // borrowed
    int view;                      // its place among the views of its input,
                                   // which follow each other
    struct gp_frame frame;
    struct gp_light_group *group;  // `groups` of them
    int groups;
    struct gp_sources sources;     // of the frame, or of the groups together
    struct gp_sources joined;      // sources and lights; empty: no lights
    struct gp_run_kernel *kernel;  // held; NULL: none was needed
    struct gp_map_picture sunmap, intensity;
    double engine_ms;              // of engines within the stage that runs:
                                   // counts as glare
    char **names;                  // files written: facts.n_outputs, then
                                   // the one being written, then NULL
    int targets;
    struct gp_light *light;        // what facts.light points to
    char *depth, *mask;            // ... and facts.depth, facts.mask
    struct gp_facts facts;
};

/* Starts with the facts that jobs->job[index] gives. End with
 * gp_frame_state_end(), also after a failure. Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_frame_state_begin(const struct gp_log *log,
    const struct gp_jobs *jobs, int index, struct gp_frame_state *out);
void gp_frame_state_end(struct gp_frame_state *fs);

/* Frees what the frame no longer needs; bits as above. */
void gp_frame_state_release(struct gp_frame_state *fs, unsigned dead);

/* Data that is made once for all frames. Stages of the COMPUTE phase change it,
 * which run on one thread, frame after frame. The write stage changes `raw`
 * only, and only when `ordered`: then frames are written one after the other.
 */
struct gp_run {
    const struct gp_settings *s;
    const struct gp_jobs *jobs;

    struct gp_frame kernel_image;  // of a kernel file; empty: builtin
    struct gp_run_kernel *kernel;  // held, of the frame before; NULL: none
    struct gp_rect reach;          // of the first kernel: pixels to its left,
                                   // up, right and down
    struct gp_glare engines;
    struct gp_glare group_engines; // of light groups: what engines keep
                                   // depends on the frames before
    struct gp_suns suns;
    struct gp_ocio *ocio;          // NULL: tone maps
    struct gp_report report;
    bool ordered;                  // frames are written one after the other,
                                   // as a stream of them must be
    struct gp_raw_size raw;        // of the frames that went to stdout raw
};

/* Reads the kernel's file, as a bad one is an error whatever the frames hold,
 * and makes the first kernel and r->reach of it; also of a builtin by whose
 * reach frames grow. Errors: those of reading and making it. */
GP_MUST_CHECK gp_status gp_run_kernel_begin(const struct gp_log *log,
                                            struct gp_run *r);

/* The stage: the frame gets the kernel, which a dark one does not have made;
 * the kernel of a file was looked at before. And that kernel, empty where a
 * dark frame needed none. */
GP_MUST_CHECK gp_status gp_run_kernel_hold(struct gp_run *r,
                                           struct gp_frame_state *fs);
const struct gp_kernel *gp_run_kernel_of(const struct gp_frame_state *fs);

/* Files for the sun's stage: planes of depth and coverage, pictures of flare
 * elements, and what a frame's file says of its camera. `files` must stay as
 * long as what is returned; in sun_files.c. */
struct gp_sun_files {
    const struct gp_settings *s;
    const struct gp_job *job; // whose frame it is; NULL: pictures only
};
struct gp_sun_reader gp_sun_reader_of(struct gp_sun_files *files);

/* A step of a frame. `time` is an enum gp_time, -1 for steps that are no part
 * of the picture; steps of one time add up. What the last stage needs is what
 * the targets need. `asked`, where there is one, says whether the command line
 * gives the step anything to do; what it gives counts as there without it. */
struct gp_stage {
    const char *name;
    enum gp_phase phase;
    int time;
    unsigned needs, gives;
    gp_status (*run)(struct gp_run *r, struct gp_frame_state *fs);
    bool (*asked)(const struct gp_settings *s);
};
enum { GP_STAGES = 12 };
extern const struct gp_stage gp_stages[GP_STAGES];

/* Says that no pixel of `frames` frames is over the threshold: the pictures are
 * what the frames were. `f` is of the brightest. */
void gp_say_dark(const struct gp_log *log, const struct gp_facts *f,
                 int frames);

/* Returns what must exist for a target to be written. */
unsigned gp_target_needs(const struct gp_settings *s, enum gp_target_kind kind);

#endif
