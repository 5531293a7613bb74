// SPDX-License-Identifier: Apache-2.0
/* Maughan's texture masking (Game Programming Gems 3, 5.5), from a frame's
 * depth and coverage instead of its geometry; and the way that it was measured
 * against, reading the region under a light back.
 *
 * Sun map (step 3): for each light side x side texels, those of all lights side
 * by side in one atlas, drawn at once. A texel is a sample of the pattern,
 * scaled by the radius, and reads the pixel it falls in. It holds
 *   r  the share shown, times g: grey where its cell is larger than a pixel,
 *      as the mean of k x k samples of it, k = clamp(ceil(2 R / side), 1, 16)
 *   g  the share of it that counts: 0 outside the frame with
 *      GLAREPP_IGNORE, else 1
 *
 * Intensity map (step 4): a pixel for each light, in rows as the atlas has
 * maps. The map's texels are drawn into it and add up: visibility = r / g, 0
 * where g is 0. It is read at once: a software context, the usual one, has no
 * pipeline to stall.
 *
 * Only the pixels under lights are uploaded. With p->bytes the intensity map adds up
 * in 8 bits, 1 / 255 a point, saturating, as in the paper; else in float, exactly. A
 * point is a texel; of maps of over 16x16, whose steps would round to 0, the mean of
 * four, as of a bilinear fetch at their common corner, and of over 32x32 the mean of
 * such fetches, in a regular selection of 16x16: the paper's two ways out. Greys are
 * dithered.
 */
#ifndef GP_SUN_MASK_MASK_H
#define GP_SUN_MASK_MASK_H

#include "core/status.h"
#include "gl/gl.h"
#include "sun/occluder.h"

/* Programs, textures and targets on a context, kept from frame to frame. */
struct gp_sun_map {
    struct gp_program draws_maps, draws_pixels, adds_up[2]; // by p->bytes
    struct gp_texture pixels, lights;   // see sun_map.frag
    struct gp_target atlas, region;     // sun maps; the region read back
    struct gp_target sums[2];           // intensity map, by p->bytes
};

/* Sets light[].visibility by sun maps, or by reading back where p->method asks
 * for that: the region under each light is drawn at the frame's own pixels (r shown,
 * g counts), read, and counted on the CPU: every pixel whose centre is in the disc;
 * the nearest one when there is none.
 *   n  1 to GP_LIGHTS_MAX; lights behind the camera come out 0
 *   s  zero at the first call; gp_sun_map_close()
 * Errors: GP_ERR_GL sizes over the context's, GL's own; GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_sun_by_gl(const struct gp_log *log,
                                     const struct gp_gl *gl,
                                     const struct gp_occluders *o,
                                     const struct glarepp_light_params *p,
                                     struct gp_light *light, int n,
                                     struct gp_sun_map *s);
void gp_sun_map_close(const struct gp_gl *gl, struct gp_sun_map *s);

/* Makes the pictures of --debug by the plain form, whatever the method: of each
 * light its sun map or, where p is NULL, its visibility, and beside it the frame's
 * pixels in the square around it, 32 lights in a row. Both are repeated to 256 pixels
 * a side or more, of over 64 lights not. *out has planes of size[0] x size[1]. */
GP_MUST_CHECK gp_status gp_sun_map_picture(const struct gp_log *log,
                                           const struct gp_occluders *o,
                                           const struct glarepp_light_params *p,
                                           const struct gp_image *f,
                                           const struct gp_light *light, int n,
                                           int size[2], struct gp_planes *out);

#endif
