// SPDX-License-Identifier: Apache-2.0
/* The hard cases as scenes. In a sunny row the light of the sun joins the
 * sources: for engines by the share that src/sun finds in the row's depth, for
 * the exact layer by the plain share (sky.h). */
#ifndef GP_TESTS_HARD_SCENES_H
#define GP_TESTS_HARD_SCENES_H

#include "glare/sources.h"
#include "sky.h"

/* Summed over the sun's disc when nothing hides it; about what all other light
 * of a sunny row adds up to. */
static const double hard_flux[3] = {3e5, 2e5, 1e5};

/* The share of the sun that shows in the frame, by the row's depth. */
static inline double hard_share(const struct hard_case *h, bool plain)
{
    struct hard_sky s = hard_sky_make(h);
    struct gp_light l = hard_light_of(h);
    struct gp_occluders o = {
        .depth = &s.plane[0], .type = s.type, .frame = hard_frame_of(h, s.data),
    };
    gp_occluders_count(&o);
    gp_sun_exact(&o, GLAREPP_IGNORE, &l, 1);
    if (plain)
        l.visibility = hard_plain_share(&s, WITH_DEPTH, o.frame,
                                        GLAREPP_IGNORE, &l);
    hard_sky_free(&s);
    return l.visibility;
}

/* The light of `share` of the sun on each pixel under its disc joins s->src. */
static inline void hard_add_sun(const struct hard_case *h, double share,
                                struct scene *s)
{
    const struct gp_light l = hard_light_of(h);
    const double r = fmax(l.radius, 1e-3);
    const struct gp_rect d = s->f.data, box = hard_box_of(d, &l);
    struct gp_source *const list = scene_alloc(gp_image_pixels(&s->f),
                                              sizeof *list);
    struct gp_sources all;
    size_t n = 0;
    for (int y = box.y0; y < box.y1; y++) {
        for (int x = box.x0; x < box.x1; x++) {
            const double part =
                share * gp_light_pixel_area(&l, r, x, y) / (M_PI * r * r);
            struct gp_source *const e = &list[n++];
            *e = (struct gp_source) {.x = x - d.x0, .y = y - d.y0};
            for (int c = 0; c < 3; c++)
                e->rgb[c] = (float) (part * hard_flux[c]);
        }
    }
    if (gp_sources_join(NULL, &s->src, list, n, &all))
        abort();
    gp_sources_free(&s->src);
    s->src = all;
    free(list);
}

/* The row's kernel: normalised, times the row's gain, or that of its recipe. */
static inline struct gp_kernel hard_kernel(const struct hard_case *h,
                                           const struct gp_image *f)
{
    struct gp_kernel k;
    if (h->recipe) {
        const struct gp_field field =
            gp_field_of(f, h->fov > 0.0 ? h->fov : GP_USUAL_FOV);
        struct gp_recipe r;
        if (gp_recipe_parse(NULL, h->recipe, &r) ||
            gp_model_kernel(NULL, &r, 1, &field, &k))
            abort();
        gp_recipe_free(&r);
        return k;
    }
    k = scene_kernel(h->kw, h->kh, h->cx, h->cy, h->shape);
    return h->kernel_gain > 0.0 ? scene_kernel_times(k, h->kernel_gain, 0.0f)
                                : k;
}

/* The case's sources, without a kernel. */
static inline struct scene hard_light(const struct hard_case *h, bool plain)
{
    const struct gp_kernel none = {0};
    struct glarepp_sense_params p = GLAREPP_SENSE_PARAMS;
    p.threshold = h->all_light ? 0.0f : 1.0f;
    p.knee = h->knee;
    p.whole = true; // as the frames were made for
    if (h->max_value > 0.0f)
        p.max_value = h->max_value;
    struct scene s = scene_sense(hard_frame(h), none, &p);
    if (hard_is_sunny(h))
        hard_add_sun(h, hard_share(h, plain), &s);
    return s;
}

/* The case without its exact layer. */
static inline struct scene hard_sense(const struct hard_case *h)
{
    struct scene s = hard_light(h, false);
    s.k = hard_kernel(h, &s.f);
    double faint = 0.0;
    for (int c = 0; c < 3; c++)
        faint += s.src.faint[c] + s.k.faint[c];
    if (h->faint != (faint > 0.0)) {
        fprintf(stderr, "%s: %g counts as 0\n", h->name, faint);
        abort();
    }
    return s;
}

static inline struct scene hard_scene(const struct hard_case *h)
{
    struct scene s = hard_sense(h), plain = hard_light(h, true);
    plain.k = s.k;
    scene_find_exact(&plain);
    plain.k = (struct gp_kernel) {0};
    s.exact = plain.exact;
    plain.exact = NULL;
    scene_free(&plain);
    return s;
}

#endif
