// SPDX-License-Identifier: Apache-2.0
/* The splat engine's parts, from the bottom up:
 *   draw.c   programs, kernels, sensors and groups on GL; polygons as blended
 *            quads
 *   tile.c   polygons gathered per tile
 *   splat.c  the layout of what is drawn, and the engine */
#ifndef GP_GLARE_SPLAT_SPLAT_PRIV_H
#define GP_GLARE_SPLAT_SPLAT_PRIV_H

#include "gl/gl.h"
#include "glare/bound/bound.h"
#include "glare/splat/polygons.h"

/* -- the layout ------------------------------------------------------------ */

/* The drawing, and the bound of its error: made on the CPU before any
 * drawing. */
struct gp_splat_layout {
    struct gp_splat_params params;
    bool single;                   // each source is a polygon on whole pixels;
                                   // else they draw the kernel's middle
    bool outer;                    // the kernel is more than its middle
    struct gp_rect crop;           // of the kernel, that can reach the frame
    struct gp_polygons polygons;
    size_t chunk;                  // polygons summed separately before their
                                   // sum is added to the layer: about
                                   // the square root of all, as a sum of n
                                   // equal terms in float may drift by n / 2
                                   // roundings
    struct gp_shrink shrink;
    double polygon_pixels;         // of polygons and middles, on the layer
    double bound;                  // of rel_l2, for any way to draw
};

/* -- the engine's state ---------------------------------------------------- */

enum { GP_SPLAT_TEXELS = 1 << 19 }; // of a list of tiles, and of scratch

/* Kernels on GL: one for each blur, and GP_MIDDLE_RADIUS pixels around the
 * centre. */
enum { GP_SPLAT_MIDDLE = GP_BLURS, GP_SPLAT_KERNELS };
struct gp_splat_kernel {
    struct gp_texture texture; // four samples a texel where it is grey, the
                               // last one's rest 0; else one of each plane
    bool grey;
    int w, h;                  // samples; 0: none
    int cx, cy;                // the centre's whole part; may lie outside
    float rest[2];             // rest of the centre: 0 or 1/2 each
};

/* Kept from frame to frame; all but `texel` is on `gl`. */
struct gp_splat {
    struct gp_gl *gl;       // NULL before the first drawing
    enum gp_gl_api api;     // the API wanted when gl was opened
    struct gp_program quad[2], tile[4], group, add;
    struct gp_target total, chunk, groups, clusters, field;
    struct gp_texture sources;
    struct gp_buffer reaches; // of polygons, by gp_source_bin()
    struct gp_buffer entries; // of tiles

    // kernels of one serial and crop; where `hollow`, blurs lack the middle
    struct gp_splat_kernel kernel[GP_SPLAT_KERNELS];
    size_t bytes; // of all of them, about
    unsigned long serial;
    struct gp_rect crop;
    bool hollow;
    float texel[4 * GP_SPLAT_TEXELS]; // on their way in or out
};

/* Makes *state, unless it is there, and its context, which is current
 * afterwards. Errors: GP_ERR_GL, no context is open then; GP_ERR_BUG out of
 * memory. */
GP_MUST_CHECK gp_status gp_splat_open(const struct gp_log *log, void **state,
                                      enum gp_gl_api api);

/* Bounds rel_l2 of a splat layer: grouping and clustering, light left out by
 * shrinking, samples' positions, and `roundings` float roundings, each 2^-24 of
 * a pixel's sum. INFINITY for kernels with lobes. */
GP_MUST_CHECK gp_status gp_group_bound(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *kernel,
    const struct gp_splat_params *p, const struct gp_polygons *polygons,
    const struct gp_shrink *shrink, double roundings, double *out);

/* -- objects on GL, made unless they are there: draw.c ----------------------
 *
 * Errors: GP_ERR_GL. */

/* A target with n attachments of at least w x h, all 0. */
GP_MUST_CHECK gp_status gp_splat_need_target(const struct gp_log *log,
    struct gp_splat *s, const char *what, int n, int w, int h,
    struct gp_target *t);

/* s->kernel[which]; without samples it has no texture. s->texel is
 * overwritten. */
GP_MUST_CHECK gp_status gp_splat_need_kernel(const struct gp_log *log,
    struct gp_splat *s, const struct gp_kernel *k, int which);

void gp_splat_drop_kernels(struct gp_splat *s);

/* -- drawing --------------------------------------------------------------- */

/* Draws the layer of a layout, which fits into a target, by blended quads. The
 * context is open and current. Nothing is read back before the layer is done.
 * Errors: GP_ERR_GL. */
GP_MUST_CHECK gp_status gp_splat_draw(const struct gp_glare_request *req,
    struct gp_splat *s, const struct gp_splat_layout *layout);

/* Writes the polygons' light, without middles, to the layer, gathered per tile:
 * one fragment pass over a tile sums over the polygons that reach it, so that
 * nothing is blended.
 *
 * Polygons at whole pixels with blur 0 are fetched exactly; others are
 * sampled bilinearly, with weights in float and not the driver's. Fractions
 * of positions are rounded to 2^-25 of a pixel. The sum's order depends on
 * nothing but the arguments (within a blur the polygons' own).
 * Errors: GP_ERR_GL no context can draw it, or a blurred kernel over the
 * texture limit. */
GP_MUST_CHECK gp_status gp_tiles_draw(const struct gp_glare_request *req,
    struct gp_splat *s, const struct gp_splat_layout *layout);

/* Bounds the float roundings of a pixel's sum in gp_tiles_draw(), each 2^-24 of
 * it where GL rounds to nearest. */
double gp_tiles_roundings(const struct gp_polygons *polygons);

#endif
