/* The stages of a frame, their shared data, and the state of a frame between
 * them. */
#ifndef GP_APP_STAGES_H
#define GP_APP_STAGES_H

#include "app/flight.h"
#include "app/jobs.h"
#include "app/kernel_label.h"
#include "app/report.h"
#include "app/settings.h"
#include "core/frame.h"
#include "core/status.h"
#include "glare/engine.h"
#include "glare/kernel.h"
#include "glare/kernel_check.h"
#include "glare/model/model.h"
#include "glare/sensors.h"
#include "scene/eye.h"
#include "scene/gltf/gltf.h"
#include "sun/ghosts.h"
#include "sun/lens.h"
#include "sun/stage.h"

#include <stdatomic.h>
#include <stdbool.h>

/* Data that stages need and give, as bits. */
enum {
    GP_HAS_RGB = 1 << 0,       // frame.rgb
    GP_HAS_SOURCES = 1 << 1,   // sources
    GP_HAS_KERNEL = 1 << 2,    // kernel; stays for the next frame
    GP_HAS_LAYER = 1 << 3,     // frame.layer; empty when there is no source
    GP_HAS_FLUX = 1 << 4,      // facts.layer.flux, bound
    GP_HAS_MEASURED = 1 << 5,  // facts.layer.error
    GP_HAS_LIT = 1 << 6,       // frame.lit
    GP_HAS_SHOWN = 1 << 7,     // frame.shown
    GP_HAS_FILES = 1 << 8,     // the outputs
    GP_HAS_SUNS = 1 << 9,      // suns placed, and measured or being measured
    GP_HAS_FLARE = 1 << 10,    // frame.layer with lens flare and all lights
    GP_HAS_SHARES = 1 << 11,   // facts.sun.light, and maps of --debug
    GP_HAS_LENS = 1 << 12,     // frame.layer with ghosts of --lens
    GP_HAS_SCENE = 1 << 13,    // run.scene, posed; suns.more
    GP_HAS_RELIT = 1 << 14,    // frame.rgb with the light of --relight
};

/* A picture of --debug with a size of its own: sun maps, intensity map. */
struct gp_map_picture {
    struct gp_planes planes; // w * h samples each; empty: not asked for
    int w, h;
};

/* A layer of the frame's file that holds the light of some lamps
 * (--light-group). Its frame borrows from the frame of the same file. With
 * light groups only these layers glare, each compared with the threshold by
 * itself, and the frame gets their sum. */
struct gp_light_group {
    struct gp_frame frame;
    struct gp_sources sources;
};

/* The recipes, or the one image, that --kernel asks for. */
struct gp_wanted_kernel {
    struct gp_recipe recipe[GP_RECIPES];
    struct gp_frame image[GP_RECIPES]; // of the recipe's file, or of the kernel
    struct gp_kernel_label label[GP_RECIPES]; // of image[i] as a kernel
    int recipes;                       // 0: image[0] is the kernel
};

/* Reads recipes and images, as a bad one is an error whatever the frames hold.
 * Errors: those of reading them. End with gp_wanted_kernel_free(). */
GP_MUST_CHECK gp_status gp_wanted_kernel_read(const struct gp_log *log,
    const struct gp_settings *s, struct gp_wanted_kernel *out);
void gp_wanted_kernel_free(struct gp_wanted_kernel *k);

/* Settings by which image[0] becomes a kernel, without recipes: those of
 * --kernel-..., but a file of glarepp kernel as it is, unless
 * --kernel-normalize is given. */
struct gp_kernel_params gp_wanted_params(const struct gp_settings *s,
                                         const struct gp_wanted_kernel *k);

/* Returns the share of a pixel's light that the kernel takes and spreads. */
double gp_wanted_share(const struct gp_wanted_kernel *k);

/* A kernel, and the frames it was made for: those of this field and these
 * primaries, or of this pixel aspect where it is an image's. Frames are written
 * while the next ones have another: whoever holds it ends with
 * gp_run_kernel_free(). */
struct gp_run_kernel {
    struct gp_kernel k;
    struct gp_recipe recipe[GP_RECIPES]; // its own, with --lens the frame's;
                                   // files and images are the run's
    struct gp_kernel_figures figures;
    struct gp_field field;         // chromaticities point to the copy
    float chromaticities[8];
    atomic_int holders;
};
void gp_run_kernel_free(struct gp_run_kernel **k);

/* The kernels of a run: that of the frame before, then older ones for frames
 * that change size or angle and change back, the last used first. */
enum { GP_MADE_KERNELS = 5 };
struct gp_run_kernels {
    struct gp_wanted_kernel wanted;
    struct gp_run_kernel *made[GP_MADE_KERNELS]; // held; NULL: none
    struct gp_model_kept *kept;    // of made[0]; NULL: none
    unsigned faults_said;          // bits of faults of kernels
    struct gp_rect reach;          // of the first kernel, as
                                   // gp_run_kernel_reach() has it
};

/* One frame in flight and the facts about it. Zeroed is none. It owns its
 * planes, its lists and what the facts own. */
struct gp_frame_state {
    const struct gp_log *log;      // for messages about this frame; borrowed
    const struct gp_job *job;      // borrowed
    int view;                      // index among the views of its input
    struct gp_frame frame;
    struct gp_light_group *group;  // `groups` of them
    int groups;
    struct gp_sources sources;     // of the frame, or of the groups together
    struct gp_sources joined;      // sources and lights; empty: no lights
    double mean, white;            // luminance of the display window, and of
                                   // scene value 1 in cd/m2, for eyes
    struct gp_run_kernel *kernel;  // held; NULL: none was needed
    struct gp_map_picture sunmap, intensity;
    bool converted;                // its layers are in --output-space
    double engine_ms, engine_cpu_ms; // of engines within the stage that
                                   // runs: count as glare
    struct gp_facts facts;
};

/* Starts with the facts that job `index` gives. End with gp_frame_state_end(),
 * also after a failure. Errors: GP_ERR_BUG memory. */
struct gp_run;
GP_MUST_CHECK gp_status gp_frame_state_begin(const struct gp_log *log,
    const struct gp_run *r, int index, struct gp_frame_state *out);
void gp_frame_state_end(struct gp_frame_state *fs);

/* Frees data that no later stage needs; bits GP_HAS_*. */
void gp_frame_state_release(struct gp_frame_state *fs, unsigned dead);

/* Elements of --flare that are drawn for bright pixels, and their engines. */
struct gp_run_ghosts {
    struct gp_ghosts set;
    struct gp_glare *engine; // owned; one a run: auto's choice, and what an
    int engines;             // engine keeps of a kernel
};

/* The engines of a run, which keep what frames share. */
struct gp_run_glare {
    struct gp_glare engines;
    struct gp_run_ghosts ghosts;
};

/* Adds them for `src`, the sources of f, to f->layer, which is made where there
 * is a run to do. Adds to *facts. Errors: those of gp_ghosts_make() and
 * gp_glare_run(). */
GP_MUST_CHECK gp_status gp_run_ghosts_add(const struct gp_log *log,
    const struct gp_run *r, const struct gp_sources *src,
    struct gp_run_ghosts *ghosts, struct gp_frame *f,
    struct gp_flare_facts *facts);
void gp_run_ghosts_free(struct gp_run_ghosts *ghosts);

/* The scene of --scene, and the camera and lights of the frame that it is posed
 * for. */
struct gp_run_scene {
    struct gp_scene scene;
    struct gp_meshes meshes;       // that rays have met
    int camera;                    // of the scene; -1: none is chosen
    bool settled;                  // the axis that points up is
    bool warned_time, warned_camera;
    // of the frame
    bool has_camera;
    struct gp_camera frame_camera; // its own, else the scene's
    struct gp_light_spec *spec;    // owned; of scene.light[]
};

/* Data that is made once for all frames. Stages of the COMPUTE phase, which run
 * on one thread, frame after frame, may change it; the write stage changes only
 * `raw`, and only when `ordered`. */
struct gp_run {
    const struct gp_settings *s;
    const struct gp_jobs *jobs;

    struct gp_run_kernels kernel;
    struct gp_run_glare glare;
    struct gp_run_glare groups;    // of light groups: auto's choice depends on
                                   // the frames before
    struct gp_suns suns;
    struct gp_run_scene scene;     // zero without --scene
    struct gp_lens lens;           // of --lens, not focused
    struct gp_ocio *ocio;          // NULL: tone maps
    struct gp_report report;
    bool ordered;                  // frames are written in order: some output
                                   // is a stream
    bool layer_ends;               // no stage after compose reads frame.layer
    bool says;                     // words need facts.sensor.spread
    struct gp_raw_size raw;        // of raw frames on stdout
};

/* Frees all of them, and what they are made from. */
void gp_run_kernels_free(struct gp_run_kernels *k);

/* Reads what --kernel asks for; of an image makes the first kernel. Sets
 * r->kernel.reach. Errors: those of reading and making it. */
GP_MUST_CHECK gp_status gp_run_kernel_begin(const struct gp_log *log,
                                            struct gp_run *r);

/* Pixels that the kernel of this frame reaches left, up, right and down. */
struct gp_rect gp_run_kernel_reach(const struct gp_run *r,
                                   struct gp_frame_state *fs);

/* Measures what eyes adapt to, where the kernel has such: fs->mean, fs->white. */
void gp_run_kernel_adapt(const struct gp_run *r, struct gp_frame_state *fs);

/* The stage: makes the kernel for a frame with light, if need be, and holds it.
 * gp_run_kernel_of() returns the frame's kernel, empty for a dark frame. */
GP_MUST_CHECK gp_status gp_run_kernel_hold(struct gp_run *r,
                                           struct gp_frame_state *fs);
const struct gp_kernel *gp_run_kernel_of(const struct gp_frame_state *fs);

/* The vertical angle of view of a frame by --fov or its camera; 0: by
 * neither. */
double gp_run_fov(const struct gp_run *r, const struct gp_frame_state *fs);

/* Makes frame.layer all 0. Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_run_dark_layer(struct gp_frame_state *fs);

/* The stages of suns and lamps: places them and measures their visible shares;
 * adds lens flare, and the glare of lights that are not among the sources;
 * copies the facts about them, whose state the next frame reuses, and makes
 * their pictures. Errors: those of sun/stage.h and gp_run_ghosts_add(). */
GP_MUST_CHECK gp_status gp_run_suns(struct gp_run *r,
                                    struct gp_frame_state *fs);
GP_MUST_CHECK gp_status gp_run_flare(struct gp_run *r,
                                     struct gp_frame_state *fs);
GP_MUST_CHECK gp_status gp_run_shares(struct gp_run *r,
                                      struct gp_frame_state *fs);

/* Reads a scene's pictures by the limits of `s`, which must outlive it. */
struct gp_scene_images gp_scene_images_of(const struct gp_settings *s);

/* Reads --scene. Errors: those of gp_scene_read(); GP_ERR_USAGE it has no such
 * camera. */
GP_MUST_CHECK gp_status gp_run_scene_begin(const struct gp_log *log,
                                           struct gp_run *r);

/* The stage: poses the scene for the frame, finds the frame's camera, and sets
 * r->suns.more. Errors: those of gp_suns_camera(); GP_ERR_USAGE no camera is
 * chosen. */
GP_MUST_CHECK gp_status gp_run_scene(struct gp_run *r,
                                     struct gp_frame_state *fs);
void gp_run_scene_free(struct gp_run_scene *s);

/* The stage: adds the light of the scene's lights that --relight names to the
 * frame's colour. Warns of those that are named and light no pixel, and where
 * all do. Errors: GP_ERR_USAGE no such light, or no camera, depth,
 * normals or albedo; those of reading them. */
GP_MUST_CHECK gp_status gp_run_relight(struct gp_run *r,
                                       struct gp_frame_state *fs);

/* Reads --lens and checks what options ask of it. Errors: those of
 * gp_lens_read() and gp_lens_focus(). */
GP_MUST_CHECK gp_status gp_run_lens_begin(const struct gp_log *log,
                                          struct gp_run *r);

/* The stop of the lens as it is focused and closed for a frame. */
struct gp_lens_stop {
    double focal, f_number; // mm
    double fov;             // degrees, of the display window's height
    int blades;
    double turn;            // degrees, counter-clockwise
};

/* Finds the stop; false: no lens, or it cannot be focused so, an error that
 * gp_run_lens() will report. */
bool gp_run_lens_stop(const struct gp_run *r, struct gp_frame_state *fs,
                      struct gp_lens_stop *out);

/* Adds the lens's ghosts to the layer, which is made, of the lights that have
 * flux, or without lights of the 100 brightest blocks of 16x16 pixels with
 * sources. The finest detail leaves no ghost out. Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_run_lens(struct gp_run *r,
    struct gp_frame_state *fs, enum gp_lens_detail detail);

/* Reads for the sun's stage: planes of depth and coverage, pictures of flare
 * elements, the camera of a frame's file. `files` must outlive the reader; in
 * sun_files.c. */
struct gp_sun_files {
    const struct gp_settings *s;
    const struct gp_job *job; // of the frame; NULL: pictures only
};
struct gp_sun_reader gp_sun_reader_of(struct gp_sun_files *files);

/* Rows of bench for layers of --flare and --lens. Zeroed is none. */
struct gp_bench_layers {
    struct gp_run run;
    struct gp_job job;
    struct gp_sun_files files;
    struct gp_bench_layer row[GP_BENCH_LAYERS];
    int rows;
};

/* Makes the rows that s asks for. End with gp_bench_layers_end(). Errors: those
 * of reading flare and lens. */
GP_MUST_CHECK gp_status gp_bench_layers_begin(const struct gp_log *log,
    const struct gp_settings *s, char *input, struct gp_bench_layers *out);
void gp_bench_layers_end(struct gp_bench_layers *b);

/* Describes a job's frame for the sun's stage: its number, its camera. */
struct gp_sun_about gp_job_about(const struct gp_job *job,
                                 const struct gp_frame *f);

/* Finds the number of a frame: the job's, else the one in its file's name.
 * Returns false where there is none. */
bool gp_job_number(const struct gp_job *job, int *number);

/* A step of a frame. `time` is an enum gp_time under which its milliseconds are
 * added up, or -1 for steps that are not part of making the picture. The last
 * stage also needs what the targets need. `asked`, if not NULL, is true when
 * the command line gives the step anything to do; otherwise its data counts as
 * present. */
struct gp_stage {
    const char *name;
    enum gp_phase phase;
    int time;
    unsigned needs, gives;
    gp_status (*run)(struct gp_run *r, struct gp_frame_state *fs);
    bool (*asked)(const struct gp_settings *s);
};
enum { GP_STAGES = 15 };
extern const struct gp_stage gp_stages[GP_STAGES];

/* Returns the data that a target needs, as bits GP_HAS_*. */
unsigned gp_target_needs(const struct gp_settings *s, enum gp_target_kind kind);

#endif
