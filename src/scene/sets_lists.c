/* The first way of 15.4.3: sets as sorted lists of objects, joined by merging.
 *
 * It looks at one object at a time, keeps nothing between lights, and asks every
 * pixel of the depth: the plain twin of sets.c. */
#include "scene/scene_priv.h"

#include "core/depth.h"
#include "core/memory.h"

static void append(struct gp_set *set, int object)
{
    set->object[set->n++] = object;
}

/* Writes the objects of both sorted lists, in their order. */
static void intersect(const struct gp_set *a, const struct gp_set *b,
                      struct gp_set *out)
{
    int i = 0, k = 0;
    out->n = 0;
    while (i < a->n && k < b->n) {
        if (a->object[i] == b->object[k]) {
            append(out, a->object[i]);
            i++;
            k++;
        } else if (a->object[i] < b->object[k]) {
            i++;
        } else {
            k++;
        }
    }
}

static struct gp_v3 centre(const struct gp_object *o)
{
    return gp_box_middle(&o->box);
}

static struct gp_v3 half(const struct gp_object *o)
{
    return gp_box_half(&o->box);
}

/* True where no pixel of the bounds has a depth at or behind the nearest of the
 * object. */
static bool hidden(const struct gp_sets_view *v, const struct gp_screen_box *b)
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

/* L: in reach, in the cone, in no umbra. */
static void list_seen(const struct gp_scene *s, const struct gp_bodies *bodies,
                      const struct gp_sets_view *v, const struct gp_reach *r,
                      unsigned use, struct gp_umbras *umbras, struct gp_set *l)
{
    struct gp_darkest most = {0};
    l->n = umbras->n = 0;
    for (int i = 0; i < s->objects; i++) {
        const struct gp_object *const o = &s->object[i];
        if (gp_box_empty(o->box) ||
            gp_reach_too_far(r, centre(o), half(o)) ||
            gp_reach_beside(r, centre(o), gp_object_radius(o, centre(o))))
            continue;
        append(l, i);
        const double size = gp_darkest_size(bodies, o);
        if (size > 0.0)
            gp_darkest_try(&most, r, centre(o), size, i);
    }
    if (!(use & GP_SETS_LIGHTS))
        return;
    gp_umbras_make(&most, s, bodies, r, umbras);
    int n = 0;
    for (int k = 0; k < l->n; k++) {
        const struct gp_object *const o = &s->object[l->object[k]];
        const struct gp_v3 e =
            gp_texel_widen(r, v->texel, centre(o), half(o),
                           gp_object_radius(o, centre(o)));
        bool dark = false;
        for (int u = 0; u < umbras->n; u++)
            dark |= gp_umbra_holds(&umbras->umbra[u], centre(o), e);
        l->object[n] = l->object[k];
        n += !dark;
    }
    l->n = n;
}

/* S of L. */
static void list_casters(const struct gp_scene *s, const struct gp_sets_view *v,
                         const struct gp_reach *r, const struct gp_scissor *lit,
                         struct gp_lists *out)
{
    const struct gp_volume hull = gp_sets_hull(v, lit, r);
    for (int k = 0; k < out->l.n; k++) {
        const struct gp_object *const o = &s->object[out->l.object[k]];
        const struct gp_v3 e =
            gp_texel_widen(r, v->texel, centre(o), half(o),
                           gp_object_radius(o, centre(o)));
        if (!gp_volume_misses(&hull, centre(o), e))
            append(&out->s, out->l.object[k]);
    }
}

gp_status gp_lists_make(const struct gp_log *log, const struct gp_scene *s,
                        const struct gp_bodies *bodies,
                        const struct gp_sets_view *v, unsigned use, int light,
                        struct gp_lists *out)
{
    gp_status st;
    struct gp_lists a = {0};
    struct gp_hidden depths = {.window = v->window};
    struct gp_lit_tiles tiles = {0};
    struct gp_screen_box *box = NULL;
    struct gp_umbras *umbras = NULL;
    const size_t n = (size_t) s->objects + 1;
    struct gp_set *const set[] = {&a.f, &a.v, &a.l, &a.i, &a.s};
    for (int k = 0; k < 5; k++)
        GP_TRY(gp_alloc(log, "lists of the scene", n, sizeof(int),
                        &set[k]->object));
    GP_TRY(gp_alloc(log, "lists of the scene", n, sizeof *box, &box));
    if (v->depth && (use & (GP_SETS_OCCLUSION | GP_SETS_SCISSOR)))
        GP_TRY(gp_hidden_make(log, v->window, v->depth, &depths));

    GP_TRY(gp_lit_tiles_make(log, &depths, &v->camera, v->display, &tiles));
    GP_TRY(gp_alloc_zero(log, "umbras of the scene", 1, sizeof *umbras,
                         &umbras));

    const double far = gp_sets_far(s, v);
    const struct gp_volume frustum = gp_sets_frustum(v, far);
    for (int i = 0; i < s->objects; i++) {
        const struct gp_object *const o = &s->object[i];
        if (gp_box_empty(o->box) ||
            gp_volume_misses(&frustum, centre(o), half(o)))
            continue;
        append(&a.f, i);
        box[i] = gp_bounds_project(&v->camera, v->display, &o->box, v->near);
        if (!(use & GP_SETS_OCCLUSION) || !v->depth || !hidden(v, &box[i]))
            append(&a.v, i);
        box[i] = gp_scissor_visible(&depths, &box[i]);
    }
    const struct gp_reach r = gp_light_reach(&s->light[light]);
    if (gp_reach_meets(&r, &frustum)) {
        list_seen(s, bodies, v, &r, use, umbras, &a.l);
        intersect(&a.v, &a.l, &a.i);
    }
    const struct gp_screen_box bounds =
        gp_reach_project(&r, &v->camera, v->display, v->near, INFINITY);
    const struct gp_scissor touched =
        gp_scissor_make(&depths, box, a.i.object, a.i.n, &bounds);
    struct gp_scissor lit = touched;
    const bool cut = use & (GP_SETS_SHADOWS | GP_SETS_SCISSOR);
    if (depths.levels > 0 && cut)
        lit = gp_lit_tiles_light(&tiles, &depths, &touched, &r, umbras,
                                 v->texel);
    if (cut && gp_rect_empty(lit.rect))
        a.i.n = 0;
    const struct gp_scissor all = gp_lit_tiles_list(
        &tiles, &depths, use & GP_SETS_SCISSOR ? &lit : &touched);
    if (a.i.n > 0 && (use & GP_SETS_SHADOWS))
        list_casters(s, v, &r, &all, &a);
    else if (a.i.n > 0)
        intersect(&a.l, &a.l, &a.s);
    if (depths.levels > 0 && (use & GP_SETS_SCISSOR)) { // shows nothing in it
        int left = 0;
        for (int k = 0; k < a.i.n; k++) {
            a.i.object[left] = a.i.object[k];
            left += gp_lit_tiles_show(&tiles, &depths, &lit,
                                      &box[a.i.object[k]]);
        }
        a.i.n = left;
    }
out:
    gp_free(box);
    gp_free(umbras);
    gp_lit_tiles_free(&tiles);
    gp_hidden_free(&depths);
    if (st)
        gp_lists_free(&a);
    *out = a;
    return st;
}

void gp_lists_free(struct gp_lists *a)
{
    GP_FREE(a->f.object);
    GP_FREE(a->v.object);
    GP_FREE(a->l.object);
    GP_FREE(a->i.object);
    GP_FREE(a->s.object);
}
