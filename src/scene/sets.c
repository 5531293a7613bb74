/* The sets of a frame and of its lights, by flags on objects. */
#include "scene/sets.h"

#include "core/memory.h"
#include "scene/groups.h"
#include "scene/reach.h"
#include "scene/scene_priv.h"

// -- frusta and hulls of a frame ---------------------------------------------

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

/* Objects of a group, as bits. */
struct reached {
    int group;
    unsigned in, seen, casting; // in the light's reach; of L and S
};

struct gp_sets {
    const struct gp_scene *scene;
    const struct gp_bodies *bodies;
    struct gp_sets_view view;
    unsigned use;
    struct gp_hidden hidden; // levels 0: no depth
    struct gp_lit_tiles tiles;
    struct gp_volume frustum;
    double far;              // of all boxes
    struct gp_groups groups;
    uint16_t *visible;         // V, objects of each group as bits
    struct gp_screen_box *box; // of places of the groups
    // of each object
    int *place;    // in the groups; -1: it has no box
    uint8_t *flag;
    // of the light
    struct reached *reached; // groups with an object in its reach
    int *lit;                // I, as places
    int reaches, lits;
    struct gp_scissor scissor;
    struct gp_umbras umbras;
};

static gp_status make_arrays(const struct gp_log *log, struct gp_sets *s)
{
    static const char what[] = "sets of the scene";
    gp_status st;
    const size_t n = (size_t) s->scene->objects + 1;
    const size_t groups = (size_t) s->groups.n + 1;
    GP_TRY(gp_alloc(log, what, groups, sizeof *s->reached, &s->reached));
    GP_TRY(gp_alloc_zero(log, what, groups, sizeof *s->visible, &s->visible));
    GP_TRY(gp_alloc_zero(log, what, groups * GP_PACK, sizeof *s->box,
                         &s->box));
    GP_TRY(gp_alloc(log, what, n, sizeof *s->place, &s->place));
    GP_TRY(gp_alloc_zero(log, what, n, sizeof *s->flag, &s->flag));
    GP_TRY(gp_alloc(log, what, n, sizeof *s->lit, &s->lit));
out:
    return st;
}

/* Flags the object at a place as one of F; of V where no depth hides it. */
static void flag_seen(struct gp_sets *s, int place)
{
    const int object = s->groups.object[place];
    struct gp_screen_box *const box = &s->box[place];
    s->flag[object] = GP_SET_F;
    *box = gp_bounds_project(&s->view.camera, s->view.display,
                             &s->scene->object[object].box, s->view.near);
    if (!(s->use & GP_SETS_OCCLUSION) || s->hidden.levels == 0 ||
        !gp_hidden_box(&s->hidden, box)) {
        s->flag[object] |= GP_SET_V;
        s->visible[place / GP_PACK] |= (uint16_t) (1u << place % GP_PACK);
        *box = gp_scissor_visible(&s->hidden, box);
    }
}

/* Flags F and V of all objects. */
static void flag_frame(struct gp_sets *s)
{
    for (int i = 0; i < s->scene->objects; i++)
        s->place[i] = -1;
    for (int g = 0; g < s->groups.n; g++) {
        const struct gp_pack *const p = &s->groups.pack[g];
        const unsigned missed = gp_pack_missed(p, &s->frustum, p->used);
        for (int k = 0; p->used >> k; k++) {
            const int place = GP_PACK * g + k;
            s->place[s->groups.object[place]] = place;
            if (!(missed >> k & 1))
                flag_seen(s, place);
        }
    }
}

/* True where the depths decide what a light changes. */
static bool shows_depths(const struct gp_sets *s)
{
    return (s->use & GP_SETS_DEPTHS) && s->hidden.levels > 0;
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
    GP_TRY(gp_groups_make(log, scene, bodies, &s->groups));
    GP_TRY(make_arrays(log, s));
    s->hidden.window = view->window;
    if (view->depth && (use & (GP_SETS_OCCLUSION | GP_SETS_SCISSOR)))
        GP_TRY(gp_hidden_make(log, view->window, view->depth, &s->hidden));
    GP_TRY(gp_lit_tiles_make(log, &s->hidden, &view->camera, view->display,
                         &s->tiles));
    s->view.depth = NULL;
    s->far = gp_sets_far(scene, view);
    if (shows_depths(s))
        s->far = fmax(s->far, gp_hidden_deepest(&s->hidden));
    s->frustum = gp_sets_frustum(view, s->far);
    flag_frame(s);
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
        gp_groups_free(&s->groups);
        gp_free(s->reached);
        gp_free(s->visible);
        gp_free(s->box);
        gp_free(s->place);
        gp_free(s->flag);
        gp_free(s->lit);
        gp_lit_tiles_free(&s->tiles);
        gp_hidden_free(&s->hidden);
    }
    GP_FREE(*sets);
}

// -- a light's sets ----------------------------------------------------------

/* Lists the groups in reach. False: nothing of V is. */
static bool list_reached(struct gp_sets *s, const struct gp_reach *r)
{
    bool any = false;
    gp_groups_near(&s->groups, r);
    for (int g = 0; g < s->groups.n; g++) {
        const unsigned in =
            s->groups.near[g] ? gp_groups_reached(&s->groups, g, r) : 0;
        if (!in)
            continue;
        s->reached[s->reaches++] = (struct reached) {.group = g, .in = in};
        any |= (in & s->visible[g]) != 0;
    }
    return any;
}

/* Finds L, and I of V: those in reach that are not in an umbra. */
static void find_lit(struct gp_sets *s, const struct gp_reach *r)
{
    struct gp_darkest most = {0};
    s->umbras.n = 0;
    if (s->use & GP_SETS_LIGHTS) {
        for (int i = 0; i < s->reaches; i++)
            gp_groups_darkest(&s->groups, s->reached[i].group,
                              s->reached[i].in, r, &most);
        gp_umbras_make(&most, s->scene, s->bodies, r, &s->umbras);
    }
    struct gp_pack_hint hint = {0};
    s->lits = 0;
    for (int i = 0; i < s->reaches; i++) {
        struct reached *const at = &s->reached[i];
        const struct gp_pack p =
            gp_groups_widen(&s->groups, at->group, r, s->view.texel);
        at->seen = at->in & ~gp_pack_held(&p, &s->umbras, at->in, &hint);
        const unsigned lit = at->seen & s->visible[at->group];
        for (int k = 0; lit >> k; k++) {
            s->lit[s->lits] = GP_PACK * at->group + k;
            s->lits += (int) (lit >> k & 1);
        }
    }
}

/* Finds S: of L, what meets the hull of the light and of what it lights. */
static void find_casters(struct gp_sets *s, const struct gp_reach *r,
                         const struct gp_scissor *lit)
{
    const struct gp_volume hull = gp_sets_hull(&s->view, lit, r);
    for (int i = 0; i < s->reaches; i++) {
        struct reached *const at = &s->reached[i];
        const struct gp_pack p =
            gp_groups_widen(&s->groups, at->group, r, s->view.texel);
        at->casting = at->seen & ~gp_pack_missed(&p, &hull, at->seen);
    }
}

/* Takes objects out of I that show nothing in the scissor. */
static void leave_out(struct gp_sets *s)
{
    int n = 0;
    for (int k = 0; k < s->lits && s->hidden.levels > 0; k++) {
        const int i = s->lit[k];
        s->lit[n] = i;
        n += gp_lit_tiles_show(&s->tiles, &s->hidden, &s->scissor, &s->box[i]);
    }
    s->lits = s->hidden.levels > 0 ? n : s->lits;
}

/* Finds L, I, S and the scissor of a light. False: I is empty. */
static bool find_sets(struct gp_sets *s, const struct gp_reach *r)
{
    const struct gp_sets_view *const v = &s->view;
    const bool cut = s->use & (GP_SETS_SHADOWS | GP_SETS_SCISSOR);
    const bool any = shows_depths(s);
    if (!gp_reach_meets(r, &s->frustum) || (!list_reached(s, r) && !any))
        return false;
    find_lit(s, r);
    const struct gp_screen_box bounds = gp_reach_project(
        r, &v->camera, v->display, v->near, INFINITY);
    static const int only[1] = {0};
    const struct gp_scissor touched =
        any ? gp_scissor_make(&s->hidden, &bounds, only, 1, &bounds)
            : gp_scissor_make(&s->hidden, s->box, s->lit, s->lits, &bounds);
    struct gp_scissor lit = touched;
    if (s->hidden.levels > 0 && cut)
        lit = gp_lit_tiles_light(&s->tiles, &s->hidden, &touched, r,
                                 &s->umbras, v->texel);
    if ((s->lits == 0 && !any) || (cut && gp_rect_empty(lit.rect))) {
        s->lits = 0; // the light is left out
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
        find_casters(s, r, &all);
        return true;
    }
    for (int i = 0; i < s->reaches; i++)
        s->reached[i].casting = s->reached[i].seen;
    return true;
}

bool gp_sets_light(struct gp_sets *s, int light)
{
    for (int i = 0; i < s->reaches; i++) {
        const int *const object =
            s->groups.object + GP_PACK * s->reached[i].group;
        for (int k = 0; k < GP_PACK; k++)
            s->flag[object[k]] &= GP_SET_F | GP_SET_V;
    }
    s->reaches = s->lits = 0;
    s->scissor = (struct gp_scissor) {0};
    s->tiles.seens = 0;
    const struct gp_reach r = gp_light_reach(&s->scene->light[light]);
    const bool on = find_sets(s, &r);
    for (int i = 0; i < s->reaches; i++) {
        const struct reached at = s->reached[i];
        const int *const object = s->groups.object + GP_PACK * at.group;
        for (int k = 0; at.seen >> k; k++)
            s->flag[object[k]] |= (uint8_t) ((at.seen >> k & 1) * GP_SET_L |
                                             (at.casting >> k & 1) * GP_SET_S);
    }
    for (int k = 0; k < s->lits; k++)
        s->flag[s->groups.object[s->lit[k]]] |= GP_SET_I;
    return on;
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
    static const struct gp_screen_box none = {0};
    const int place = s->place[object];
    return gp_screen_pixels(place < 0 ? &none : &s->box[place],
                            s->scissor.rect);
}

struct gp_scissor gp_sets_scissor(const struct gp_sets *sets)
{
    return sets->scissor;
}

/* Returns the batches of a mesh; merged, its opaque submeshes are one. */
static int batches_of(const struct gp_scene *s, const struct gp_mesh *m,
                      bool merged)
{
    int n = 0, opaque = 0;
    for (int k = m->first; k < m->first + m->submeshes; k++) {
        const bool is_opaque = gp_submesh_opaque(s, &s->submesh[k]);
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
