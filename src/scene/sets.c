/* The sets of a frame and of its lights, by flags on objects. */
#include "scene/sets.h"

#include "core/cpu.h"
#include "core/memory.h"
#include "scene/reach.h"
#include "scene/scene_priv.h"

// -- shared with the sorted lists --------------------------------------------

double gp_object_radius(const struct gp_object *o, struct gp_v3 c)
{
    const double corner = gp_v3_length(gp_v3_sub(o->box.hi, c));
    return fmin(corner, o->radius + gp_v3_length(gp_v3_sub(o->centre, c)));
}

double gp_sets_far(const struct gp_scene *s, const struct gp_sets_view *v)
{
    const double *const m = v->camera.to_ndc;
    double far = 2.0 * v->near;
    for (int i = 0; i < s->objects; i++) {
        const struct gp_object *const o = &s->object[i];
        const struct gp_v3 c = o->centre;
        far = fmax(far, c.x * m[3] + c.y * m[7] + c.z * m[11] + m[15] +
                            1.001 * o->radius);
    }
    return far;
}

struct gp_volume gp_sets_frustum(const struct gp_sets_view *v, double far)
{
    const double x[2] = {v->window.x0, v->window.x1};
    const double y[2] = {v->window.y0, v->window.y1};
    const struct gp_frustum f =
        gp_frustum_make(&v->camera, v->display, x, y, v->near, far);
    return gp_frustum_volume(&f);
}

struct gp_volume gp_sets_hull(const struct gp_sets_view *v,
                              const struct gp_scissor *lit,
                              const struct gp_reach *light)
{
    const double x[2] = {lit->rect.x0, lit->rect.x1};
    const double y[2] = {lit->rect.y0, lit->rect.y1};
    const struct gp_frustum f =
        gp_frustum_make(&v->camera, v->display, x, y, lit->near * (1.0 - 1e-6),
                        lit->far * (1.0 + 1e-6));
    return gp_hull(&f, light->from);
}

// -- the frame's sets --------------------------------------------------------

struct gp_sets {
    const struct gp_scene *scene;
    const struct gp_bodies *bodies;
    struct gp_sets_view view;
    unsigned use;
    struct gp_hidden hidden; // levels 0: no depth
    struct gp_lit_tiles tiles;
    struct gp_volume frustum;
    double far;              // of all boxes
    // of each object
    double *at[3], *half[3]; // centres and half sides of boxes
    double *radius;          // < 0: empty
    double *size;            // of an occluder: area; 0: none
    struct gp_screen_box *box;
    uint8_t *flag;
    uint8_t *near;           // in a light's reach
    // of the light
    int *lit, *list;         // I; in its reach
    int lits, listed;
    struct gp_scissor scissor;
    struct gp_umbras umbras;
};

static struct gp_v3 centre_of(const struct gp_sets *s, int i)
{
    return (struct gp_v3) {s->at[0][i], s->at[1][i], s->at[2][i]};
}

static struct gp_v3 half_of(const struct gp_sets *s, int i)
{
    return (struct gp_v3) {s->half[0][i], s->half[1][i], s->half[2][i]};
}

static gp_status make_arrays(const struct gp_log *log, struct gp_sets *s)
{
    static const char what[] = "sets of the scene";
    gp_status st;
    const size_t n = (size_t) s->scene->objects + 1;
    for (int c = 0; c < 3; c++) {
        GP_TRY(gp_alloc(log, what, n, sizeof(double), &s->at[c]));
        GP_TRY(gp_alloc(log, what, n, sizeof(double), &s->half[c]));
    }
    GP_TRY(gp_alloc(log, what, n, sizeof *s->radius, &s->radius));
    GP_TRY(gp_alloc(log, what, n, sizeof *s->size, &s->size));
    GP_TRY(gp_alloc_zero(log, what, n, sizeof *s->box, &s->box));
    GP_TRY(gp_alloc_zero(log, what, n, sizeof *s->flag, &s->flag));
    GP_TRY(gp_alloc_zero(log, what, n, sizeof *s->near, &s->near));
    GP_TRY(gp_alloc(log, what, n, sizeof *s->lit, &s->lit));
    GP_TRY(gp_alloc(log, what, n, sizeof *s->list, &s->list));
out:
    return st;
}

/* Copies boxes. */
static void fill_arrays(struct gp_sets *s)
{
    for (int i = 0; i < s->scene->objects; i++) {
        const struct gp_object *const o = &s->scene->object[i];
        const bool empty = gp_box_empty(o->box);
        const struct gp_v3 none = {0.0, 0.0, 0.0};
        const struct gp_v3 c = empty ? none : gp_box_middle(&o->box);
        const struct gp_v3 e = empty ? none : gp_box_half(&o->box);
        s->at[0][i] = c.x;
        s->at[1][i] = c.y;
        s->at[2][i] = c.z;
        s->half[0][i] = e.x;
        s->half[1][i] = e.y;
        s->half[2][i] = e.z;
        s->radius[i] = empty ? -1.0 : gp_object_radius(o, c);
        s->size[i] = gp_darkest_size(s->bodies, o);
    }
}

gp_status gp_sets_open(const struct gp_log *log, const struct gp_scene *scene,
                       const struct gp_bodies *bodies,
                       const struct gp_sets_view *view, unsigned use,
                       struct gp_sets **out)
{
    gp_status st;
    struct gp_sets *s = NULL;
    *out = NULL;
    GP_TRY(gp_alloc_zero(log, "sets of the scene", 1, sizeof *s, &s));
    s->scene = scene;
    s->bodies = bodies;
    s->view = *view;
    s->use = use;
    GP_TRY(make_arrays(log, s));
    s->hidden.window = view->window;
    if (view->depth && (use & (GP_SETS_OCCLUSION | GP_SETS_SCISSOR)))
        GP_TRY(gp_hidden_make(log, view->window, view->depth, &s->hidden));
    GP_TRY(gp_lit_tiles_make(log, &s->hidden, &view->camera, view->display,
                         &s->tiles));
    s->view.depth = NULL;
    fill_arrays(s);
    s->far = gp_sets_far(scene, view);
    s->frustum = gp_sets_frustum(view, s->far);
    for (int i = 0; i < scene->objects; i++) {
        if (s->radius[i] < 0.0 ||
            gp_volume_misses(&s->frustum, centre_of(s, i), half_of(s, i)))
            continue;
        s->flag[i] = GP_SET_F;
        s->box[i] = gp_bounds_project(&view->camera, view->display,
                                      &scene->object[i].box, view->near);
        if (!(use & GP_SETS_OCCLUSION) || s->hidden.levels == 0 ||
            !gp_hidden_box(&s->hidden, &s->box[i])) {
            s->flag[i] |= GP_SET_V;
            s->box[i] = gp_scissor_visible(&s->hidden, &s->box[i]);
        }
    }
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
        for (int c = 0; c < 3; c++) {
            gp_free(s->at[c]);
            gp_free(s->half[c]);
        }
        gp_free(s->radius);
        gp_free(s->size);
        gp_free(s->box);
        gp_free(s->flag);
        gp_free(s->near);
        gp_free(s->lit);
        gp_free(s->list);
        gp_lit_tiles_free(&s->tiles);
        gp_hidden_free(&s->hidden);
    }
    GP_FREE(*sets);
}

// -- a light's sets ----------------------------------------------------------

/* Sets near[i] where box i is in a light's range: gp_reach_too_far(), for all
 * at once. */
static GP_CLONES void find_near(const struct gp_sets *s,
                                const struct gp_reach *r)
{
    const double *const x = s->at[0], *const y = s->at[1], *const z = s->at[2];
    const double *const u = s->half[0], *const v = s->half[1],
                        *const w = s->half[2];
    const double *const radius = s->radius;
    const double px = r->from.p.x, py = r->from.p.y, pz = r->from.p.z;
    const double weight = r->from.w, most = r->range * r->range;
    uint8_t *const near = s->near;
    const int n = s->scene->objects;
    for (int i = 0; i < n; i++) {
        const double a = fabs(x[i] - px) - u[i], b = fabs(y[i] - py) - v[i],
                     c = fabs(z[i] - pz) - w[i];
        const double dx = a > 0.0 ? a : 0.0, dy = b > 0.0 ? b : 0.0,
                     dz = c > 0.0 ? c : 0.0;
        near[i] = (weight * (dx * dx + dy * dy + dz * dz) <= most) &
                  (radius[i] >= 0.0);
    }
}

/* Lists what is in reach, and what of V is. */
static void list_near(struct gp_sets *s, const struct gp_reach *r)
{
    int n = 0, lits = 0;
    find_near(s, r);
    for (int i = 0; i < s->scene->objects; i++) {
        s->list[n] = i;
        n += s->near[i];
    }
    s->listed = 0;
    for (int k = 0; k < n; k++) {
        const int i = s->list[k];
        if (gp_reach_beside(r, centre_of(s, i), s->radius[i]))
            continue;
        s->list[s->listed++] = i;
        s->lit[lits] = i;
        lits += (s->flag[i] & GP_SET_V) != 0;
    }
    s->lits = lits;
}

/* Flags L, and I of V: those listed that are not in an umbra. */
static void flag_lit(struct gp_sets *s, const struct gp_reach *r)
{
    struct gp_darkest most = {0};
    s->umbras.n = 0;
    if (s->use & GP_SETS_LIGHTS) {
        for (int k = 0; k < s->listed; k++) {
            const int i = s->list[k];
            if (s->size[i] > 0.0)
                gp_darkest_try(&most, r, centre_of(s, i), s->size[i], i);
        }
        gp_umbras_make(&most, s->scene, s->bodies, r, &s->umbras);
    }
    s->lits = 0;
    for (int k = 0; k < s->listed; k++) {
        const int i = s->list[k];
        const struct gp_v3 c = centre_of(s, i), e = half_of(s, i);
        const struct gp_v3 wide =
            gp_texel_widen(r, s->view.texel, c, e, s->radius[i]);
        if (s->umbras.n > 0 && gp_umbras_hold(&s->umbras, c, wide))
            continue;
        s->flag[i] |= GP_SET_L;
        if (s->flag[i] & GP_SET_V) {
            s->flag[i] |= GP_SET_I;
            s->lit[s->lits++] = i;
        }
    }
}

/* Flags S: of L, what meets the hull of the light and of what it lights. */
static void flag_casters(struct gp_sets *s, const struct gp_reach *r,
                         const struct gp_scissor *lit)
{
    const struct gp_volume hull = gp_sets_hull(&s->view, lit, r);
    for (int k = 0; k < s->listed; k++) {
        const int i = s->list[k];
        const struct gp_v3 c = centre_of(s, i);
        const struct gp_v3 e = gp_texel_widen(r, s->view.texel, c,
                                             half_of(s, i), s->radius[i]);
        if ((s->flag[i] & GP_SET_L) && !gp_volume_misses(&hull, c, e))
            s->flag[i] |= GP_SET_S;
    }
}

/* Takes objects out of I that show nothing in the scissor. */
static void leave_out(struct gp_sets *s)
{
    int n = 0;
    for (int k = 0; k < s->lits; k++) {
        const int i = s->lit[k];
        if (s->hidden.levels > 0 &&
            !gp_lit_tiles_show(&s->tiles, &s->hidden, &s->scissor, &s->box[i]))
            s->flag[i] &= (uint8_t) ~GP_SET_I;
        else
            s->lit[n++] = i;
    }
    s->lits = n;
}

bool gp_sets_light(struct gp_sets *s, int light)
{
    const struct gp_sets_view *const v = &s->view;
    for (int k = 0; k < s->listed; k++)
        s->flag[s->list[k]] &= GP_SET_F | GP_SET_V;
    s->listed = s->lits = 0;
    s->scissor = (struct gp_scissor) {0};
    s->tiles.seens = 0;
    const struct gp_reach r = gp_light_reach(&s->scene->light[light]);
    if (!gp_reach_meets(&r, &s->frustum))
        return false;
    list_near(s, &r);
    if (s->lits == 0)
        return false;
    flag_lit(s, &r);
    const struct gp_screen_box bounds = gp_reach_project(
        &r, &v->camera, v->display, v->near, INFINITY);
    const struct gp_scissor touched =
        gp_scissor_make(&s->hidden, s->box, s->lit, s->lits, &bounds);
    struct gp_scissor lit = touched;
    if (s->hidden.levels > 0 && (s->use & (GP_SETS_SHADOWS | GP_SETS_SCISSOR)))
        lit = gp_lit_tiles_light(&s->tiles, &s->hidden, &touched, &r,
                                 &s->umbras, v->texel);
    const bool bright = s->lits > 0 &&
                        (!(s->use & (GP_SETS_SHADOWS | GP_SETS_SCISSOR)) ||
                         !gp_rect_empty(lit.rect));
    if (!bright) { // the light is left out
        for (int k = 0; k < s->lits; k++)
            s->flag[s->lit[k]] &= (uint8_t) ~GP_SET_I;
        s->lits = 0;
        return false;
    }
    s->scissor = (struct gp_scissor) {v->window, v->near, s->far};
    if (s->use & GP_SETS_SCISSOR) {
        s->scissor = lit;
        leave_out(s);
    }
    if (s->use & GP_SETS_SHADOWS) {
        // what is drawn must have its shadows, lit or not
        const struct gp_scissor all = gp_lit_tiles_list(
            &s->tiles, &s->hidden, s->use & GP_SETS_SCISSOR ? &lit : &touched);
        flag_casters(s, &r, &all);
        return true;
    }
    for (int k = 0; k < s->listed; k++) {
        uint8_t *const flag = &s->flag[s->list[k]];
        *flag |= *flag & GP_SET_L ? GP_SET_S : 0;
    }
    return true;
}

// -- asking ------------------------------------------------------------------

const uint8_t *gp_sets_flags(const struct gp_sets *sets)
{
    return sets->flag;
}

const struct gp_box *gp_sets_seen(const struct gp_sets *sets, int *n)
{
    *n = sets->tiles.seens;
    return sets->tiles.seen;
}

struct gp_rect gp_sets_scissor_of(const struct gp_sets *s, int object)
{
    return gp_screen_pixels(&s->box[object], s->scissor.rect);
}

struct gp_scissor gp_sets_scissor(const struct gp_sets *sets)
{
    return sets->scissor;
}

int gp_sets_list(const struct gp_sets *sets, unsigned set, int *object)
{
    int n = 0;
    for (int i = 0; i < sets->scene->objects; i++) {
        if (!(sets->flag[i] & set))
            continue;
        if (object)
            object[n] = i;
        n++;
    }
    return n;
}

/* Returns the batches of a mesh; merged, its opaque parts are one. */
static int batches_of(const struct gp_scene *s, const struct gp_mesh *m,
                      bool merged)
{
    int n = 0, opaque = 0;
    for (int k = m->first; k < m->first + m->parts; k++) {
        const bool is_opaque = gp_part_opaque(s, &s->part[k]);
        opaque += is_opaque;
        n += !is_opaque;
    }
    return n + (merged && opaque > 1 ? 1 : opaque);
}

int gp_sets_batches(const struct gp_sets *sets, unsigned set, bool merged)
{
    const struct gp_scene *const s = sets->scene;
    int n = 0;
    for (int i = 0; i < s->objects; i++) {
        if (sets->flag[i] & set)
            n += batches_of(s, &s->mesh[s->object[i].mesh], merged);
    }
    return n;
}
