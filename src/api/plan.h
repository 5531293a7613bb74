/* The library's plan: parameters of the rooms, and what frames share. */
#ifndef GP_API_PLAN_H
#define GP_API_PLAN_H

#include "api/kernel.h"
#include "glare/edges.h"
#include "glare/engine.h"
#include "glare/sensors.h"
#include "scene/eye.h"
#include "scene/gltf/gltf.h"
#include "sun/ghosts.h"
#include "sun/lens.h"
#include "sun/stage.h"
#include "tone/ocio.h"

#include <pthread.h>
#include <stdatomic.h>

/* Elements of a flare that are drawn for bright pixels, and their engines. */
struct gp_api_ghosts {
    struct gp_ghosts set;
    struct gp_glare *engine; // `engines` of them, owned
    int engines;
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
    struct gp_light_spec *spec;    // owned; of scene.light[]
};

/* What a plan lends to a frame while it computes. */
struct gp_api_work {
    struct gp_glare engines, group_engines;
    struct gp_suns suns;
    struct gp_api_scene scene;
    struct gp_api_ghosts ghosts, group_ghosts;
    struct gp_api_work *next;      // that is not lent
};

/* Warnings that a plan gives once, as bits; those of kernels come first. */
enum {
    GP_SAID_ANGLE = 1 << GP_KERNEL_RULES,
    GP_SAID_IMAGES = 2 << GP_KERNEL_RULES,
    GP_SAID_TIME = 4 << GP_KERNEL_RULES,
    GP_SAID_CAMERA = 8 << GP_KERNEL_RULES,
};

struct glarepp_plan {
    struct glarepp *gp;
    struct gp_log log;             // the context's
    // parameters
    double fov, rotate;            // degrees; fov 0: by the frame
    struct gp_sensor_params sense;
    struct gp_glare_params glare;
    struct gp_compose_params compose;
    enum gp_surround_how edges;
    bool lit;                      // a frame may have lights
    struct gp_sun_params sun;
    struct gp_light_spec camera_sun; // sun.sun
    struct glarepp_lens_params lens_params; // lens NULL: none
    struct glarepp_scene_params scene;      // path NULL: none
    struct glarepp_tone_params tone; // curve and exposure
    bool converts;                 // the tone's output space is given
    char **text;                   // owned copies of the parameters' strings,
    int texts;                     // and lists of them
    // shared by frames
    struct glarepp_kernel *own;    // where the caller gave none
    const struct gp_kernel_request *request;
    struct gp_kernels *kernels;
    struct gp_rect reach;          // of a kernel for one pixel
    struct gp_lens lens;           // not focused
    struct gp_ocio *ocio;          // NULL: tone maps
    pthread_mutex_t lock;          // of the next two
    struct gp_api_work *work;      // not lent
    bool ocio_noted;
    atomic_uint said;              // GP_SAID_*
    struct glarepp_plan_facts facts;
    const char **file;             // of facts; owned
    bool more_frames;              // execute() may come again
};

/* Lends work to a frame; end with gp_api_give_back(). Errors: those of reading
 * flares and the scene. */
GP_MUST_CHECK gp_status gp_api_lend(struct glarepp_plan *plan,
                                    struct gp_api_work **out);
void gp_api_give_back(struct glarepp_plan *plan, struct gp_api_work **work);

/* Returns true, once a plan, for a warning. */
static inline bool gp_api_says(struct glarepp_plan *plan, unsigned bit)
{
    return !(atomic_fetch_or(&plan->said, bit) & bit);
}

/* Reads the scene of a plan; light.c and scene.c. */
GP_MUST_CHECK gp_status gp_api_scene_begin(const struct glarepp_plan *plan,
                                           struct gp_api_work *work);
void gp_api_scene_end(struct gp_api_scene *scene);

#endif
