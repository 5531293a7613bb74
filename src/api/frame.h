/* The library's frame: one picture on its way through a plan. */
#ifndef GP_API_FRAME_H
#define GP_API_FRAME_H

#include "api/plan.h"

/* A layer of a frame's light. With groups only these glare, each compared with
 * the threshold by itself. */
struct gp_api_group {
    struct gp_image image;
    bool borrowed;                 // image.rgb is the caller's
    struct gp_sources sources;
};

/* A picture to look at, of a size of its own. */
struct gp_api_picture {
    struct gp_planes planes;
    int w, h;
};

struct glarepp_frame {
    struct glarepp_plan *plan;
    struct gp_api_sink sink;
    struct gp_log log;
    struct glarepp_frame_params p; // image, group and matrices are in:
    struct gp_sun_about about;
    struct gp_image image;
    bool borrowed;                 // image.rgb is the caller's
    struct gp_api_group *group;    // owned
    int groups;
    struct gp_plane depth, mask, normal[3], albedo[3];
    struct gp_api_work *work;      // lent, from the first step that needs it
    struct gp_sources sources;     // of the frame, or of the groups together
    struct gp_sources joined;      // sources and lights; empty: no lights
    double mean, white;            // luminance of the picture, and of scene
                                   // value 1 in cd/m2, for eyes
    struct gp_made_kernel *kernel; // held; NULL: none was needed
    bool composed;                 // image.lit was made
    struct gp_planes *converted;   // lit, in the output space, of the frame and
                                   // of its groups; owned
    struct gp_planes sources_shown, polygons, truth;
    double *exact;                 // the layer in double, where it is kept; owned
    bool hidden;                   // work.suns knows depth and mask
    struct gp_api_picture sunmap, intensity;
    struct glarepp_share *share;   // facts.light
    struct glarepp_relit *relit;   // facts.relit
    struct glarepp_facts facts;
};

/* The kernel of a frame; empty where none was needed. */
const struct gp_kernel *gp_api_kernel(const struct glarepp_frame *f);

/* Makes image.layer, all 0, unless it is there. */
GP_MUST_CHECK gp_status gp_api_dark_layer(struct glarepp_frame *f);

/* The vertical angle of view by the plan or the frame's or scene's camera; 0:
 * by none. */
double gp_api_camera_fov(const struct glarepp_frame *f);

/* Steps, of light.c, lens.c and scene.c. */
gp_status gp_api_pose(struct glarepp_frame *f);
gp_status gp_api_relight(struct glarepp_frame *f);
gp_status gp_api_place(struct glarepp_frame *f);
gp_status gp_api_shares(struct glarepp_frame *f);
gp_status gp_api_join(struct glarepp_frame *f);
gp_status gp_api_flare(struct glarepp_frame *f);
gp_status gp_api_lens(struct glarepp_frame *f);

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
/* Finds it; false: no lens, or it cannot be focused so, an error of the step. */
bool gp_api_lens_stop(struct glarepp_frame *f, struct gp_api_stop *out);

#endif
