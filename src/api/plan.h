// SPDX-License-Identifier: Apache-2.0
/* The library's kernels, plans (parameters of the rooms, and what frames share)
 * and frames. */
#ifndef GP_API_PLAN_H
#define GP_API_PLAN_H

#include "api/api.h"
#include "glare/edges.h"
#include "glare/engine.h"
#include "glare/kernel_kept.h"
#include "glare/sources.h"
#include "scene/eye.h"
#include "scene/gltf/gltf.h"
#include "sun/found.h"
#include "sun/ghosts.h"
#include "sun/lens.h"
#include "sun/stage.h"
#include "tone/ocio.h"

#include <pthread.h>
#include <stdatomic.h>

struct glarepp_kernel {
    struct glarepp *gp;
    struct gp_kernel_request request;
    char *text[GP_RECIPES];  // of each recipe; owned
};

// -- plans --------------------------------------------------------------------

/* Elements of a flare that are drawn for bright pixels, and their engines. */
struct gp_api_ghosts {
    struct gp_ghosts set;
    struct gp_glare *engine; // `engines` of them, owned
    int engines;
};

/* Lights and flares. */
struct gp_api_lights {
    struct gp_suns suns;
    struct gp_api_ghosts ghosts, group_ghosts;
};

/* A scene, and the camera and lights of the frame that it is posed for. */
struct gp_api_scene {
    struct gp_scene scene;
    struct gp_meshes meshes;       // that rays have met
    int camera;                    // of the scene; -1: none is chosen
    bool settled;                  // the axis that points up is
    // of the frame
    bool has_camera;
    struct gp_camera frame_camera; // its own, else the scene's
    struct glarepp_light *light;   // owned; of scene.light[]
};

/* The state that a plan lends to a frame while it computes. */
struct gp_api_work {
    struct gp_api_lights *lights;  // NULL: none, no flare and no scene is asked
                                   // for
    struct gp_api_scene *scene;    // NULL: none
    struct gp_api_work *next;      // that is not lent
    struct gp_glare group_engines; // of the plan's own kernel, for groups
    struct gp_glare engines[];     // of each kernel of the plan
};

/* Warnings that a plan gives once, as bits of `said`; those of each kernel come first. */
enum {
    GP_SAID_ANGLE = GP_KERNEL_RULES,
    GP_SAID_IMAGES,
    GP_SAID_TIME,
    GP_SAID_CAMERA,
    GP_SAID_HIDDEN,
    GP_SAID_BRIGHT,
    GP_SAID_WIDE,
    GP_SAID_SHARE,
    GP_SAID_PLANE,
    GP_SAID_LACKS,
    GP_SAID_SPHERE,
    GP_SAID_MATRIX
};

/* A kernel of a plan. */
struct gp_api_plan_kernel {
    const struct gp_kernel_request *request;
    struct gp_kernels *kept;
    struct gp_rect reach; // for one pixel
    atomic_uint said;     // GP_SAID_*
};

struct glarepp_plan {
    struct glarepp *gp;
    struct gp_log log;             // the context's
    // parameters
    double fov, rotate;            // degrees; fov 0: by the frame
    int projection;
    struct glarepp_sense_params sense;
    struct gp_glare_params glare;
    struct gp_compose_params compose;
    struct gp_tint_params tint;
    bool tints; // it changes a layer
    enum glarepp_edges edges;
    bool lights; // a frame may have lights, its own or a scene's
    struct glarepp_light_params sun;
    struct glarepp_lens_params lens_params; // lens NULL: none
    struct glarepp_scene_params scene;      // path NULL: none
    struct glarepp_tone_params tone; // curve and exposure
    bool converts;                 // the tone's output space is given
    void *text[16];                // owned copies of the parameters' strings,
    int texts;                     // and lists of them
    // shared by frames
    struct glarepp_kernel *own;    // where the caller gave none
    struct glarepp_plan
        *names; // whose `known` names lights; this one or another
    struct gp_lens lens;           // not focused
    struct gp_ocio *ocio;          // NULL: tone maps
    pthread_mutex_t lock;          // of the next three, and of notes of `ocio`
    struct gp_api_work *work;      // not lent
    struct glarepp_light known[GP_FOUND_MOST]; // lights of the first frame that
    int knowns;                    // showed some, which name those of others
    atomic_uint said;              // GP_SAID_*
    struct glarepp_plan_facts facts;
    const char **file;             // of facts; owned
    int kernels;
    struct gp_api_plan_kernel kernel[]; // the plan's own, then those of groups
};

/* Lends work to a frame; end with gp_api_give_back(). Errors: those of reading
 * flares and the scene. */
GP_MUST_CHECK gp_status gp_api_lend(struct glarepp_plan *plan,
                                    struct gp_api_work **out);
void gp_api_give_back(struct glarepp_plan *plan, struct gp_api_work **work);

/* Returns true where SENSE finds lights. */
static inline bool gp_api_spots(const struct glarepp_plan *plan,
                                const struct gp_suns *suns)
{
    return plan->sun.found || suns->knowns ||
           (!plan->lights && (plan->lens_params.lens ||
                              gp_flare_has(&suns->flare, GP_FLARE_LIGHTS)));
}

/* Returns true, once a plan, for a warning. */
static inline bool gp_api_says(atomic_uint *said, int bit)
{
    return !(atomic_fetch_or(said, 1u << bit) >> bit & 1);
}

/* Read the files of a plan, of light.c and scene.c. */
GP_MUST_CHECK gp_status gp_api_lights_begin(struct glarepp_plan *plan,
                                            struct gp_api_work *work);
void gp_api_lights_end(struct gp_api_lights **lights);
GP_MUST_CHECK gp_status gp_api_scene_begin(const struct glarepp_plan *plan,
                                           struct gp_api_work *work);
void gp_api_scene_end(struct gp_api_scene **scene);

/* Returns the degrees that a sun is wide: the scene's own where no option says any. */
double gp_api_sun_size(const struct glarepp_plan *plan,
                       const struct gp_scene_light *l, const char **from);

// -- frames -------------------------------------------------------------------

/* A layer of a frame's light. With groups only these glare, each compared with
 * the threshold by itself. */
struct gp_api_group {
    struct gp_image image;
    bool borrowed;                 // image.rgb is the caller's
    struct glarepp_group how;
    struct gp_sources sources;  // without the gain
    struct gp_planes part;      // its glare and flare, times the gain, where
                                // p.parts_of_groups
    struct gp_planes converted; // lit, in the output space
};

/* A kernel of the plan, and the light that it spreads. */
struct gp_api_run {
    struct gp_sources sources; // of groups, times their gains; row NULL: none
                               // are split, all are of the plan's own kernel
    struct gp_made_kernel *kernel; // held; NULL: none was needed
};

/* A picture to look at, of a size of its own. */
struct gp_api_picture {
    struct gp_planes planes;
    int size[2];
};

enum { GP_PARTS = 4 };

struct glarepp_frame {
    struct glarepp_plan *plan;
    struct gp_api_sink sink;
    struct gp_log log;
    struct glarepp_frame_params p; // image and group are in:
    struct gp_image image;
    bool borrowed;                 // image.rgb is the caller's
    struct gp_api_group *group;    // owned
    int groups;
    struct gp_plane depth, mask, normal[3], albedo[3], source_mask;
    struct gp_deep deep;           // first NULL: none
    struct gp_api_work *work;      // lent, from the first step that needs it
    struct gp_sources sources;     // of the frame, or of the groups together,
                                   // times their gains
    struct gp_sources whole;       // ... before the mask; row NULL: no mask
    struct gp_sources taken;       // light that SCATTER takes from the frame;
                                   // row NULL: sources
    struct gp_sources joined; // those of the plan's own kernel, and lights;
                              // empty: no lights
    double mean, white;       // luminance of the picture, and of scene
                              // value 1 in cd/m2, for eyes
    unsigned ran;                  // bits of steps since those before them
    bool flat; // its glare is a plane's, where models would follow true angles
    bool tinted;                   // image.layer has its colour
    bool composed;                 // image.lit was made
    struct gp_planes converted;    // lit, in the output space
    struct gp_planes sources_shown, polygons, truth;
    struct gp_planes part[GP_PARTS]; // from GLAREPP_PART_VEIL on; p.parts
    double *exact;                 // the layer in double, where it is kept; owned
    struct gp_glare_sample sample; // ... of its pixels
    bool hidden;                   // work.lights knows depth and mask
    struct gp_api_picture sunmap, intensity;
    struct glarepp_share *share;   // facts.light
    struct glarepp_relit *relit;   // facts.relit
    struct glarepp_facts facts;
    struct gp_api_run run[]; // of each kernel of the plan
};

/* Refuses what a caller asks of a frame, whose name the message begins with: a
 * parameter, a format and its values. Returns GP_ERR_USAGE. */
#define gp_api_refuse(f, ...) \
    gp_fail_bare_at(&(f)->log, GP_ERR_USAGE, __VA_ARGS__)

/* Kernel i of a frame, 0 the plan's own; empty where none was needed. */
static inline const struct gp_kernel *
gp_api_kernel(const struct glarepp_frame *f, int i)
{
    static const struct gp_kernel none;
    return f->run[i].kernel ? &f->run[i].kernel->k : &none;
}

/* The sources of kernel i: bright pixels, without lights; and with those whose share
 * is known. */
static inline const struct gp_sources *
gp_api_bright(const struct glarepp_frame *f, int i)
{
    return i || f->run->sources.row ? &f->run[i].sources : &f->sources;
}
static inline const struct gp_sources *
gp_api_light(const struct glarepp_frame *f, int i)
{
    return i == 0 && f->joined.n ? &f->joined : gp_api_bright(f, i);
}

/* The light that mix takes from the frame; NULL: none. */
static inline const struct gp_sources *
gp_api_taken(const struct glarepp_frame *f)
{
    return f->plan->compose.mix == GLAREPP_ADD ? NULL
           : f->taken.row                      ? &f->taken
                                               : &f->sources;
}

/* Finds the frame's camera, whose place is not needed; false: it has none, or one that
 * is wrong, which is said where a light needs it. */
bool gp_api_find_camera(const struct glarepp_frame *f, struct gp_camera *out);

/* The vertical angle of view by the plan or the frame's or scene's camera; 0:
 * by none. */
double gp_api_camera_fov(const struct glarepp_frame *f);

/* How a frame goes on beyond its border: a whole sphere, or a fisheye whose rim is in the
 * frame, does not, and one whose rim is in its mirror image is extended. */
enum glarepp_edges gp_api_edges(const struct glarepp_frame *f);

/* Errors: USAGE a frame that no lens has drawn, for ghosts and flares. */
GP_MUST_CHECK gp_status gp_api_has_axis(const struct glarepp_frame *f);

/* The projection of a LATLONG or fisheye, in EXR pixel space; PLANE: the frame is none. */
struct gp_projection gp_api_wide(const struct glarepp_frame *f);

/* Finds the field of a frame, and the facts of its angle. */
struct gp_field gp_api_field(struct glarepp_frame *f,
                             struct glarepp_kernel_facts *facts);

/* Finds facts.veil, of a frame that wants it. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_api_veil(struct glarepp_frame *f);

/* Steps of field.c, and of light.c, lens.c and scene.c for plans that ask for them. */
gp_status gp_api_make_kernel(struct glarepp_frame *f);
gp_status gp_api_pose(struct glarepp_frame *f);
gp_status gp_api_relight(struct glarepp_frame *f);
gp_status gp_api_place(struct glarepp_frame *f);
gp_status gp_api_shares(struct glarepp_frame *f);
gp_status gp_api_spot(struct glarepp_frame *f);
void gp_api_warn_of_lights(struct glarepp_frame *f);
gp_status gp_api_flare(struct glarepp_frame *f);
gp_status gp_api_lens(struct glarepp_frame *f);

// -- parts of the layer: part.c ------------------------------------------------

/* Takes the layer of an image away, to `before`, and gives it a dark one to draw a
 * part in. Errors: GP_ERR_BUG out of memory; the layer is as it was. */
GP_MUST_CHECK gp_status gp_api_part_open(struct glarepp_frame *f,
                                         struct gp_image *image,
                                         struct gp_planes *before);

/* The factor of a part: `gain`, or where that is 0 the one that makes its
 * brightest pixel over a dark one of the frame a quarter of white. */
double gp_api_part_level(const struct glarepp_frame *f,
                         const struct gp_image *image, float gain);

/* Adds the part times `level` to the layer of before. It is kept in *kept, which
 * may be NULL, where parts are wanted. */
void gp_api_part_close(struct glarepp_frame *f, struct gp_image *image,
                       double level, struct gp_planes *before,
                       struct gp_planes *kept);

/* Moves what a kernel leaves in the pixels of sources, times `gain`, from the veil
 * to the core. */
GP_MUST_CHECK gp_status gp_api_part_core(struct glarepp_frame *f,
                                         const struct gp_sources *s,
                                         const struct gp_kernel *k, float gain);

/* Makes a part that is looked at, where no step did: without flare and ghosts, or
 * dark. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_api_part_find(struct glarepp_frame *f,
                                         enum glarepp_view view);

/* Groups, of groups.c. Finds their sources, in place of the frame's own. */
GP_MUST_CHECK gp_status gp_api_sense_groups(struct glarepp_frame *f);

/* Makes the frame's layer, by all of its kernels. */
GP_MUST_CHECK gp_status gp_api_layers(struct glarepp_frame *f);

/* The same in double: 3 w h numbers, to be freed with gp_free(). */
GP_MUST_CHECK gp_status gp_api_exact(struct glarepp_frame *f, double **out);

/* Gives groups their parts, in place of the frame's veil, core and flare. */
GP_MUST_CHECK gp_status gp_api_part_groups(struct glarepp_frame *f);

/* Adds glare to a group, so that groups which add up to the frame still do. */
GP_MUST_CHECK gp_status gp_api_compose_group(struct glarepp_frame *f,
                                             struct gp_api_group *g,
                                             const struct gp_compose_params *p);

/* Adds a layer, maybe of another window, to the image's, and to norm2 its squared
 * norm and that of its part in the image. */
GP_MUST_CHECK gp_status gp_api_add_layer(const struct gp_log *log,
                                         const struct gp_image *from,
                                         struct gp_image *image,
                                         double norm2[2]);

/* Bounds the norm of a layer's error by its bound and squared norm. */
double gp_api_error_of(double bound, double norm2);

/* Bounds rel_l2 of a layer by norms of its error and of itself, as it was made. */
double gp_api_bound_of(double error, double norm);

/* Adds flare of bright pixels for `src` to an image's layer. */
GP_MUST_CHECK gp_status gp_api_ghosts_add(struct glarepp_frame *f,
    const struct gp_sources *src, struct gp_api_ghosts *ghosts,
    struct gp_image *image, struct glarepp_flare_facts *facts);

/* The stop of the lens as it is focused and closed for a frame. */
struct gp_api_stop {
    double focal, f_number; // mm
    double fov;             // degrees, of the display window's height
    int blades;
    double turn;            // degrees, counter-clockwise
};
/* Finds it; false: it cannot be focused so, an error of the step. */
bool gp_api_lens_stop(struct glarepp_frame *f, struct gp_api_stop *out);

#endif
