/* Albedo of a scene's materials as a frame shows it: that of a material's own
 * factors may be scaled, tinted or textured in the frame. */
#ifndef GP_SCENE_COLOURS_H
#define GP_SCENE_COLOURS_H

#include "scene/scene.h"

/* Albedo of a pixel that shows one surface. */
struct gp_shade {
    int material;    // -1: of none of the scene
    float albedo[3]; // >= 0, finite
};

/* Albedo of each material. All of it is proportional to that of the pixels. */
struct gp_colours {
    double (*of)[3];     // owned; median of its pixels; of fewer than 8, its
                         // base colour in units
    unsigned char *many; // owned; 1: its pixels differ, as by a texture
    double unit;         // > 0; albedo of the pixels over that of base colours
};

/* Makes *out, empty on failure; free with gp_colours_free().
 *   shade  n pixels; are sorted
 * Errors: GP_ERR_BUG memory is full. */
GP_MUST_CHECK gp_status gp_colours_make(const struct gp_log *log,
                                        const struct gp_scene *s,
                                        struct gp_shade *shade, size_t n,
                                        struct gp_colours *out);
void gp_colours_free(struct gp_colours *c);

#endif
