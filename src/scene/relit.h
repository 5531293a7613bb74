/* A frame lit by the lights of its scene that are named: surfaces from its planes,
 * passes from the visibility sets. */
#ifndef GP_SCENE_RELIT_H
#define GP_SCENE_RELIT_H

#include "scene/relight.h"

/* A frame that is lit. Planes are borrowed; normals may be turned in place. */
struct gp_relit_frame {
    const char *path;              // for messages
    struct gp_camera camera;
    struct gp_rect display, data;  // data: of rgb
    const struct gp_plane *depth;  // along the view axis
    struct gp_plane *normal;       // three
    const struct gp_plane *albedo; // three
    bool normal_of_camera;         // axes of the picture, else of the world
    bool up_unknown;               // nothing but the normals says which axis of
                                   // the world points up
    double light_scale;            // the frame's units a cd or lux; 0: as Blender
};

/* A light that was asked for. */
struct gp_relit_light {
    const char *name;              // borrowed from the scene
    long long pixels, rays;        // that got light; cast for it
    int casters;                   // objects that may cast its shadows
};

/* Finds the lights that are named, of which "all" is every one.
 *   asked  set where a light is; zero before; NULL: not wanted
 * Errors: GP_ERR_USAGE no such light. */
GP_MUST_CHECK gp_status gp_relit_find(const struct gp_log *log,
    const struct gp_scene *s, const char *const *name, int names,
    unsigned char *asked);

/* Adds the light of scene lights named in `name` (or "all") to rgb.
 *   s, meshes  posed; meshes are kept from call to call
 *   out        owned by the caller, gp_free(); *lit of them, in the scene's
 *              order
 * Warns of lights that are named and light no pixel, and where all do. Errors:
 * GP_ERR_USAGE no such light; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_relit_add(const struct gp_log *log,
    const struct gp_scene *s, struct gp_meshes *meshes,
    const struct gp_relit_frame *f, const char *const *name, int names,
    const struct gp_planes *rgb, struct gp_relit_light **out, int *lit);

#endif
