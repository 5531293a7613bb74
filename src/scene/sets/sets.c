/* The sets of a frame and of its lights, by flags on objects. */
#include "scene/sets/sets_priv.h"

#include "core/memory.h"

struct gp_sets {
    const struct gp_scene *scene;
    struct gp_sets_view view; // without its depth
    unsigned use;
    struct gp_depths depths;   // across 0: none
    struct gp_volume frustum;
    double far;                // along the view axis, over every box
    // of each object
    uint8_t *flag;
    struct gp_scissor *box;    // of its visible points
    // of the light
    int *lit;                  // I
    int lits;
    struct gp_scissor scissor;
    struct gp_umbras *umbras;
};

// -- the frame's sets --------------------------------------------------------

/* Returns a distance along the view axis over that of every object. */
static double far_of(const struct gp_scene *s, const struct gp_sets_view *v)
{
    const double *const m = v->camera.to_ndc;
    double far = 2.0 * v->near;
    for (int i = 0; i < s->objects; i++) {
        const struct gp_object *const o = &s->object[i];
        const struct gp_v3 c = gp_box_middle(&o->box);
        far = fmax(far, c.x * m[3] + c.y * m[7] + c.z * m[11] + m[15] +
                            1.001 * o->radius);
    }
    return far;
}

/* True where the depths decide what a light changes. */
static bool shows_depths(const struct gp_sets *s)
{
    return (s->use & GP_SETS_DEPTHS) && s->depths.across > 0;
}

/* Flags F and V of all objects. */
static void flag_frame(struct gp_sets *s)
{
    const bool by_depth = (s->use & GP_SETS_OCCLUSION) && s->depths.across > 0;
    for (int i = 0; i < s->scene->objects; i++) {
        const struct gp_box *const of = &s->scene->object[i].box;
        struct gp_scissor *const box = &s->box[i];
        s->flag[i] = 0;
        *box = (struct gp_scissor) {0};
        if (gp_box_empty(*of) || gp_volume_misses(&s->frustum,
                                                  gp_box_middle(of),
                                                  gp_box_half(of)))
            continue;
        s->flag[i] = GP_SET_F;
        *box = gp_box_project(&s->view, of);
        if (by_depth && gp_depths_hide(&s->depths, box))
            continue;
        s->flag[i] |= GP_SET_V;
        *box = gp_depths_cut(&s->depths, box);
    }
}

gp_status gp_sets_look(const struct gp_log *log, struct gp_sets *s,
                       const float *depth)
{
    gp_status st = GP_OK;
    gp_depths_free(&s->depths);
    s->depths.window = s->view.window;
    if (depth && (s->use & (GP_SETS_OCCLUSION | GP_SETS_SCISSOR)))
        st = gp_depths_make(log, s->view.window, depth, &s->depths);
    if (st)
        return st;
    s->far = far_of(s->scene, &s->view);
    if (shows_depths(s))
        s->far = fmax(s->far, gp_depths_deepest(&s->depths));
    const struct gp_scissor all = {s->view.window, s->view.near, s->far};
    s->frustum = gp_hull(&s->view, &all, NULL);
    flag_frame(s);
    return GP_OK;
}

gp_status gp_sets_open(const struct gp_log *log, const struct gp_scene *scene,
                       const struct gp_sets_view *view, unsigned use,
                       struct gp_sets **out)
{
    static const char what[] = "sets of the scene";
    const size_t n = (size_t) scene->objects + 1;
    struct gp_sets *s = NULL;
    gp_status st;
    *out = NULL;
    GP_TRY(gp_alloc_zero(log, what, 1, sizeof *s, &s));
    s->scene = scene;
    s->view = *view;
    s->use = use;
    GP_TRY(gp_alloc(log, what, n, sizeof *s->flag, &s->flag));
    GP_TRY(gp_alloc(log, what, n, sizeof *s->box, &s->box));
    GP_TRY(gp_alloc(log, what, n, sizeof *s->lit, &s->lit));
    GP_TRY(gp_umbras_open(log, scene, &s->umbras));
    GP_TRY(gp_sets_look(log, s, view->depth));
    *out = s;
    s = NULL;
out:
    gp_sets_close(&s);
    return st;
}

void gp_sets_close(struct gp_sets **sets)
{
    struct gp_sets *const s = *sets;
    if (s) {
        gp_free(s->flag);
        gp_free(s->box);
        gp_free(s->lit);
        gp_umbras_close(&s->umbras);
        gp_depths_free(&s->depths);
    }
    GP_FREE(*sets);
}

// -- a light's sets ----------------------------------------------------------

/* Returns half the sides of an object's box, wider by what lookups in a map of
 * shadows may be off. */
static struct gp_v3 wide_half(const struct gp_sets *s, const struct gp_reach *r,
                              const struct gp_object *o)
{
    const struct gp_v3 e = gp_box_half(&o->box);
    const struct gp_v3 to = gp_v3_sub(gp_box_middle(&o->box), r->from.p);
    const double more = s->view.texel * (r->from.w > 0.0
        ? gp_v3_length(to) + o->radius : 1.0);
    return (struct gp_v3) {e.x + more, e.y + more, e.z + more};
}

/* Flags the objects in reach as L. False: nothing of V is. */
static bool flag_reached(struct gp_sets *s, const struct gp_reach *r)
{
    bool any = false;
    for (int i = 0; i < s->scene->objects; i++) {
        const struct gp_object *const o = &s->scene->object[i];
        if (gp_box_empty(o->box) || gp_reach_misses(r, o))
            continue;
        s->flag[i] |= GP_SET_L;
        any |= (s->flag[i] & GP_SET_V) != 0;
    }
    return any;
}

/* Takes objects in an umbra out of L, and lists I. */
static void find_lit(struct gp_sets *s, const struct gp_reach *r)
{
    gp_umbras_light(s->umbras, s->use & GP_SETS_LIGHTS ? s->flag : NULL,
                    r->from);
    for (int i = 0; i < s->scene->objects; i++) {
        const struct gp_object *const o = &s->scene->object[i];
        const struct gp_v3 c = gp_box_middle(&o->box);
        if (!(s->flag[i] & GP_SET_L))
            continue;
        if (gp_umbras_hold(s->umbras, c, wide_half(s, r, o)))
            s->flag[i] &= (uint8_t) ~GP_SET_L;
        else if (s->flag[i] & GP_SET_V)
            s->lit[s->lits++] = i;
    }
}

/* Flags I, and S: of L, what meets the hull of the light and of what it
 * lights. */
static void flag_light(struct gp_sets *s, const struct gp_reach *r,
                       const struct gp_scissor *lit)
{
    struct gp_scissor wide = *lit;
    wide.near *= 1.0 - 1e-6;
    wide.far *= 1.0 + 1e-6;
    const struct gp_volume hull = gp_hull(&s->view, &wide, &r->from);
    for (int i = 0; i < s->scene->objects; i++) {
        const struct gp_object *const o = &s->scene->object[i];
        const struct gp_v3 c = gp_box_middle(&o->box);
        if ((s->flag[i] & GP_SET_L) &&
            (!(s->use & GP_SETS_SHADOWS) ||
             !gp_volume_misses(&hull, c, wide_half(s, r, o))))
            s->flag[i] |= GP_SET_S;
    }
    for (int k = 0; k < s->lits; k++)
        s->flag[s->lit[k]] |= GP_SET_I;
}

struct gp_scissor gp_sets_light(struct gp_sets *s, int light)
{
    const struct gp_sets_view *const v = &s->view;
    const struct gp_reach r = gp_light_reach(&s->scene->light[light]);
    const bool any = shows_depths(s);
    for (int i = 0; i < s->scene->objects; i++)
        s->flag[i] &= GP_SET_F | GP_SET_V;
    s->scissor = (struct gp_scissor) {0};
    s->lits = 0;
    if (!gp_reach_meets(&r, &s->frustum) || (!flag_reached(s, &r) && !any))
        return s->scissor;
    find_lit(s, &r);
    const struct gp_scissor bounds =
        isfinite(r.range) ? gp_box_project(v, &r.box)
                          : (struct gp_scissor) {v->window, v->near, INFINITY};
    struct gp_scissor lit =
        any ? bounds : gp_scissor_join(s->box, s->lit, s->lits, &bounds);
    lit = gp_depths_cut(&s->depths, &lit);
    const bool cut = s->use & (GP_SETS_SHADOWS | GP_SETS_SCISSOR);
    if ((s->lits == 0 && !any) || (cut && gp_rect_empty(lit.rect)))
        return s->scissor;
    s->scissor = (s->use & GP_SETS_SCISSOR)
                     ? lit : (struct gp_scissor) {v->window, v->near, s->far};
    flag_light(s, &r, &lit);
    return s->scissor;
}

// -- asking ------------------------------------------------------------------

const uint8_t *gp_sets_flags(const struct gp_sets *sets)
{
    return sets->flag;
}

struct gp_rect gp_sets_scissor_of(const struct gp_sets *s, int object)
{
    return gp_rect_meet(s->box[object].rect, s->scissor.rect);
}

int gp_sets_batches(const struct gp_sets *sets, unsigned set)
{
    const struct gp_scene *const s = sets->scene;
    int n = 0;
    for (int i = 0; i < s->objects; i++) {
        if (sets->flag[i] & set)
            n += s->mesh[s->object[i].mesh].submeshes;
    }
    return n;
}
