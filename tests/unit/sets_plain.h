/* The plain twin of scene/sets.c: one object after another, by the tests of a
 * single box; it keeps nothing between lights and asks every pixel of the
 * depth. */
#ifndef GP_TESTS_SETS_PLAIN_H
#define GP_TESTS_SETS_PLAIN_H

#include "core/depth.h"
#include "core/memory.h"
#include "scene/scene_priv.h"

/* True where no pixel of the bounds has a depth at or behind the nearest of the
 * object. */
static inline bool plain_hidden(const struct gp_sets_view *v,
                                const struct gp_screen_box *b)
{
    const struct gp_rect r = gp_screen_pixels(b, v->window);
    const size_t w = (size_t) gp_rect_w(v->window);
    for (int y = r.y0; y < r.y1; y++) {
        for (int x = r.x0; x < r.x1; x++) {
            const float z = v->depth[(size_t) (y - v->window.y0) * w +
                                     (size_t) (x - v->window.x0)];
            const bool surface = z > 0.0f && z < GP_DEPTH_HUGE;
            if (!surface || b->near * (1.0 - GP_DEPTH_SLACK) <= (double) z)
                return false;
        }
    }
    return true;
}

static inline struct gp_v3 plain_wide(const struct gp_sets_view *v,
                                      const struct gp_reach *r,
                                      const struct gp_object *o)
{
    const struct gp_v3 c = gp_box_middle(&o->box);
    return gp_texel_widen(r, v->texel, c, gp_box_half(&o->box),
                          gp_object_radius(o, c));
}

/* Sets GP_SET_* of each object for a light. Arguments as of gp_sets_open() and
 * gp_sets_light(); L is whole, whatever is visible. */
static inline gp_status plain_sets(const struct gp_scene *s,
                                   const struct gp_bodies *bodies,
                                   const struct gp_sets_view *v, unsigned use,
                                   int light, uint8_t *flag)
{
    static struct gp_umbras umbras;
    const size_t n = (size_t) s->objects + 1;
    const bool scissor = use & GP_SETS_SCISSOR, shadows = use & GP_SETS_SHADOWS;
    struct gp_hidden depths = {.window = v->window};
    struct gp_lit_tiles tiles = {0};
    struct gp_darkest most = {0};
    struct gp_screen_box *box = NULL;
    int *lit = NULL, lits = 0;
    gp_status st;
    GP_TRY(gp_alloc_zero(NULL, "plain sets", n, sizeof *box, &box));
    GP_TRY(gp_alloc(NULL, "plain sets", n, sizeof *lit, &lit));
    if (v->depth && (use & (GP_SETS_OCCLUSION | GP_SETS_SCISSOR)))
        GP_TRY(gp_hidden_make(NULL, v->window, v->depth, &depths));
    GP_TRY(gp_lit_tiles_make(NULL, &depths, &v->camera, v->display, &tiles));
    const struct gp_volume frustum = gp_sets_frustum(v, gp_sets_far(s, v));
    const struct gp_reach r = gp_light_reach(&s->light[light]);
    const bool meets = gp_reach_meets(&r, &frustum);
    for (int i = 0; i < s->objects; i++) {
        const struct gp_object *const o = &s->object[i];
        const struct gp_v3 c = gp_box_middle(&o->box), e = gp_box_half(&o->box);
        flag[i] = 0;
        if (gp_box_empty(o->box))
            continue;
        if (!gp_volume_misses(&frustum, c, e)) {
            box[i] = gp_bounds_project(&v->camera, v->display, &o->box,
                                       v->near);
            flag[i] = GP_SET_F;
            if (!(use & GP_SETS_OCCLUSION) || !v->depth ||
                !plain_hidden(v, &box[i]))
                flag[i] |= GP_SET_V;
            box[i] = gp_scissor_visible(&depths, &box[i]);
        }
        if (!meets || gp_reach_too_far(&r, c, e) ||
            gp_reach_beside(&r, c, gp_object_radius(o, c)))
            continue;
        flag[i] |= GP_SET_L;
        const double size = gp_darkest_size(bodies, o);
        if (size > 0.0)
            gp_darkest_try(&most, &r, c, size, i);
    }
    umbras.n = 0;
    if (use & GP_SETS_LIGHTS)
        gp_umbras_make(&most, s, bodies, &r, &umbras);
    for (int i = 0; i < s->objects; i++) {
        const struct gp_object *const o = &s->object[i];
        for (int u = 0; u < umbras.n && (flag[i] & GP_SET_L); u++) {
            if (gp_umbra_holds(&umbras.umbra[u], gp_box_middle(&o->box),
                               plain_wide(v, &r, o)))
                flag[i] &= (uint8_t) ~GP_SET_L;
        }
        if ((flag[i] & GP_SET_V) && (flag[i] & GP_SET_L))
            lit[lits++] = i;
    }
    const struct gp_screen_box bounds =
        gp_reach_project(&r, &v->camera, v->display, v->near, INFINITY);
    const struct gp_scissor touched =
        gp_scissor_make(&depths, box, lit, lits, &bounds);
    struct gp_scissor cut = touched;
    if (depths.levels > 0 && (shadows || scissor))
        cut = gp_lit_tiles_light(&tiles, &depths, &touched, &r, &umbras,
                                 v->texel);
    if ((shadows || scissor) && gp_rect_empty(cut.rect))
        lits = 0;
    if (lits == 0)
        goto out;
    const struct gp_scissor all =
        gp_lit_tiles_list(&tiles, &depths, scissor ? &cut : &touched);
    const struct gp_volume hull = gp_sets_hull(v, &all, &r);
    for (int i = 0; i < s->objects; i++) {
        const struct gp_object *const o = &s->object[i];
        if ((flag[i] & GP_SET_L) &&
            (!shadows || !gp_volume_misses(&hull, gp_box_middle(&o->box),
                                           plain_wide(v, &r, o))))
            flag[i] |= GP_SET_S;
    }
    for (int k = 0; k < lits; k++) {
        if (depths.levels == 0 || !scissor ||
            gp_lit_tiles_show(&tiles, &depths, &cut, &box[lit[k]]))
            flag[lit[k]] |= GP_SET_I;
    }
out:
    gp_free(box);
    gp_free(lit);
    gp_lit_tiles_free(&tiles);
    gp_hidden_free(&depths);
    return st;
}

/* Counts the objects whose sets, of those of `mask`, are not the same. */
static inline int plain_differ(const struct gp_scene *s, const uint8_t *flag,
                               const uint8_t *plain, unsigned mask)
{
    int n = 0;
    for (int i = 0; i < s->objects; i++)
        n += ((flag[i] ^ plain[i]) & mask) != 0;
    return n;
}

#endif
