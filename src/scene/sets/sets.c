// SPDX-License-Identifier: Apache-2.0
/* The sets of a frame and of its lights, by flags on objects, and what they are
 * found by: convex volumes (15.4.4), and the frame's depth by tiles (15.5). */
#include "scene/sets/sets_priv.h"

#include "core/depth.h"
#include "core/maths.h"
#include "core/memory.h"

// -- convex volumes: what a camera sees, and its hull with a light ------------

/* Rounding of a plane's distance, in parts of the largest coordinate. */
static const double SLACK = 1e-9;

/* The intersection of half-spaces, and a box around it; a frustum has 6, a hull
 * with a point at most 6 and one for each edge. */
struct volume {
    int planes;
    struct gp_half plane[18];
    struct gp_box box; // infinite towards a directional light
    double slack;      // rounding: what misses by less still meets
};

/* True where a box of centre c and half sides e cannot meet the volume: it is
 * outside a plane, or of the volume's box. A box that misses all of the volume
 * beside an edge may count as one that meets it, never the other way round. */
static bool misses(const struct volume *v, struct gp_v3 c, struct gp_v3 e)
{
    if (c.x - e.x > v->box.hi.x + v->slack ||
        c.x + e.x < v->box.lo.x - v->slack ||
        c.y - e.y > v->box.hi.y + v->slack ||
        c.y + e.y < v->box.lo.y - v->slack ||
        c.z - e.z > v->box.hi.z + v->slack ||
        c.z + e.z < v->box.lo.z - v->slack)
        return true;
    for (int i = 0; i < v->planes; i++) {
        if (gp_half_at(v->plane[i], c) - gp_half_reach(v->plane[i], e) >
            v->slack)
            return true;
    }
    return false;
}

/* Returns the box that holds b and a light; one at infinity is reached along
 * its direction. */
static struct gp_box box_with(struct gp_box b, struct gp_from light)
{
    if (light.w != 0.0)
        return gp_box_with(b, light.p);
    const struct gp_v3 to = light.p;
    b.lo.x = to.x < 0.0 ? -INFINITY : b.lo.x;
    b.lo.y = to.y < 0.0 ? -INFINITY : b.lo.y;
    b.lo.z = to.z < 0.0 ? -INFINITY : b.lo.z;
    b.hi.x = to.x > 0.0 ? INFINITY : b.hi.x;
    b.hi.y = to.y > 0.0 ? INFINITY : b.hi.y;
    b.hi.z = to.z > 0.0 ? INFINITY : b.hi.z;
    return b;
}

/* Returns the frustum of a part of the picture that is not empty, or its convex
 * hull with a light: the planes that have the light inside and one through the
 * light for each edge of the silhouette (Everitt and Kilgard 2003).
 *
 * Corners of the frustum have bit 0 right, 1 low, 2 far. Plane 2 k + side is
 * that of the corners whose bit k is `side`. */
static struct volume hull_of(const struct gp_sets_view *view,
                             const struct gp_scissor *part,
                             const struct gp_from *light)
{
    const struct gp_rect d = view->display, r = part->rect;
    const double w = gp_rect_w(d), h = gp_rect_h(d);
    struct volume v = {.box = GP_BOX_EMPTY};
    struct gp_v3 corner[8], middle = {0.0, 0.0, 0.0};
    struct gp_half plane;
    bool out[6]; // planes that the light is outside of
    for (int i = 0; i < 8; i++) {
        corner[i] = gp_camera_point(
            &view->camera, ((i & 1 ? r.x1 : r.x0) - d.x0) / w,
            ((i & 2 ? r.y1 : r.y0) - d.y0) / h, i & 4 ? part->far : part->near);
        middle = gp_v3_add(middle, gp_v3_scale(corner[i], 0.125));
        v.box = gp_box_with(v.box, corner[i]);
        v.slack = fmax(v.slack, SLACK * gp_v3_length(corner[i]));
    }
    for (int i = 0; i < 6; i++) {
        const int k = i / 2, a = 1 << (k + 1) % 3, b = 1 << (k + 2) % 3;
        const int at = (i % 2) << k | (k < 2 ? 4 : 0); // far, if it may be
        gp_half_span(corner[at], gp_v3_sub(corner[at ^ a], corner[at]),
                     gp_v3_sub(corner[at ^ b], corner[at]), middle, &plane);
        out[i] = light && gp_half_before(plane, *light) > 0.0;
        if (!out[i])
            v.plane[v.planes++] = plane;
    }
    if (v.planes == 6) // the light is in the frustum: this is it
        return v;
    v.box = box_with(v.box, *light);
    v.slack = fmax(v.slack, light->w * SLACK * gp_v3_length(light->p));

    // an edge with a count of one is on the silhouette
    for (int i = 0; i < 12; i++) {
        const int k = i / 4, a = (k + 1) % 3, b = (k + 2) % 3;
        const int at = (i & 1) << a | (i >> 1 & 1) << b;
        if (out[2 * a + (i & 1)] == out[2 * b + (i >> 1 & 1)])
            continue;
        // (a light on the edge's line makes no plane: the hull is larger)
        if (gp_half_span(corner[at], gp_v3_sub(corner[at | 1 << k], corner[at]),
                         gp_from_to(*light, corner[at]), middle, &plane))
            v.plane[v.planes++] = plane;
    }
    return v;
}

// -- what a light reaches -----------------------------------------------------

/* A light made ready: a ball of its range, a spot's cut by its cone; of a
 * directional one all of space. */
struct light_range {
    struct gp_from from;   // place, or direction to it
    double range;          // INFINITY: none
    struct gp_v3 along;    // of a spot
    double cos, sin;       // of a spot's outer half angle; sin 0: no cone
    struct gp_box box;     // around the volume; may be infinite
};

/* Returns how far a light reaches along an axis whose cosine with its cone's is
 * `at`. */
static double range_along(const struct light_range *r, double at)
{
    double cosine = 1.0; // of the cone's nearest direction
    if (r->sin != 0.0 && at < r->cos)
        // 0 where it points away: the apex
        cosine =
            fmax(0.0, at * r->cos + sqrt(fmax(0.0, 1.0 - at * at)) * r->sin);
    return cosine > 0.0 ? cosine * r->range : 0.0;
}

static struct light_range range_of(const struct gp_scene_light *light)
{
    const bool sun = light->kind == GP_LIGHT_DIRECTIONAL;
    const struct gp_v3 a = light->along;
    struct light_range r = {
        .from = {sun ? gp_v3_scale(a, -1.0) : light->at, sun ? 0.0 : 1.0},
        .range = sun ? INFINITY : light->range, .along = a,
    };
    if (light->kind == GP_LIGHT_SPOT && light->outer < 1.5707963) {
        r.cos = gp_cos(light->outer);
        r.sin = gp_sin(light->outer);
    }
    r.box.lo = gp_v3_sub(r.from.p, (struct gp_v3) {range_along(&r, -a.x),
                                                   range_along(&r, -a.y),
                                                   range_along(&r, -a.z)});
    r.box.hi = gp_v3_add(r.from.p, (struct gp_v3) {range_along(&r, a.x),
                                                   range_along(&r, a.y),
                                                   range_along(&r, a.z)});
    return r;
}

/* True where an object's box is beyond the range, or its sphere is outside the
 * cone. */
static bool range_misses(const struct light_range *r, const struct gp_object *o)
{
    const struct gp_v3 e = gp_box_half(&o->box);
    const struct gp_v3 v = gp_v3_sub(gp_box_middle(&o->box), r->from.p);
    const double x = gp_maxd(fabs(v.x) - e.x, 0.0),
                 y = gp_maxd(fabs(v.y) - e.y, 0.0),
                 z = gp_maxd(fabs(v.z) - e.z, 0.0);
    if (r->from.w * (x * x + y * y + z * z) > r->range * r->range)
        return true;
    const double along = gp_v3_dot(v, r->along);
    const double aside = sqrt(fmax(0.0, gp_v3_dot(v, v) - along * along));
    // distance before the cone's side; never over the distance from the cone
    return r->sin != 0.0 && r->cos * aside - r->sin * along >
                                o->radius + 1e-9 * (fabs(along) + aside);
}

/* False where the light's volume cannot meet a frustum. */
static bool range_meets(const struct light_range *r, const struct volume *v)
{
    for (int i = 0; i < v->planes && r->from.w != 0.0; i++) {
        const struct gp_half h = v->plane[i];
        // the farthest point of ball, or cone, inwards
        if (gp_half_at(h, r->from.p) -
                range_along(r, -gp_v3_dot(h.n, r->along)) > v->slack)
            return false;
    }
    return true;
}

// -- bounds on the screen -----------------------------------------------------

/* Returns bounds that hold a place before the division by z: x and y in units of the
 * display window, z along the view axis. */
static struct gp_box seen_with(struct gp_box b, struct gp_v3 p)
{
    return gp_box_with(b, (struct gp_v3) {p.x / p.z, p.y / p.z, p.z});
}

/* Returns the pixels of the window whose centres may show the part of a box at
 * v->near or beyond, and its depths. The box is not empty. */
static struct gp_scissor box_project(const struct gp_sets_view *v,
                                     const struct gp_box *box)
{
    const double *const m = v->camera.to_ndc;
    const struct gp_rect d = v->display;
    const double w = gp_rect_w(d), h = gp_rect_h(d);
    struct gp_box b = GP_BOX_EMPTY;
    struct gp_v3 at[8];
    for (int i = 0; i < 8; i++) {
        const struct gp_v3 p = gp_box_corner(box, i);
        at[i] =
            (struct gp_v3) {gp_move_column(m, p, 0), gp_move_column(m, p, 1),
                            gp_move_column(m, p, 3)};
        if (at[i].z >= v->near)
            b = seen_with(b, at[i]);
    }
    // where an edge meets the plane at `near`, from corner i to i with bit k
    for (int e = 0; e < 24; e++) {
        const int i = e % 8, k = 1 << e / 8;
        const struct gp_v3 p = at[i], q = at[i | k];
        if (i & k || (p.z < v->near) == (q.z < v->near))
            continue;
        const double t = (v->near - p.z) / (q.z - p.z);
        b = seen_with(b, (struct gp_v3) {p.x + t * (q.x - p.x),
                                         p.y + t * (q.y - p.y), v->near});
    }
    if (gp_box_empty(b))
        return (struct gp_scissor) {0};
    const struct gp_rect in = v->window;
    const struct gp_rect seen = {
        gp_clamp_whole(floor(d.x0 + b.lo.x * w), in.x0, in.x1),
        gp_clamp_whole(floor(d.y0 + b.lo.y * h), in.y0, in.y1),
        gp_clamp_whole(ceil(d.x0 + b.hi.x * w), in.x0, in.x1),
        gp_clamp_whole(ceil(d.y0 + b.hi.y * h), in.y0, in.y1)};
    return (struct gp_scissor) {seen, b.lo.z, b.hi.z};
}

// -- depths by tiles ----------------------------------------------------------

/* Parts by which depths may be wrong: 2^-10 holds those stored as half. */
#define DEPTH_SLACK 0x1p-10

enum { TILE = 16 }; // pixels a side

/* Depths of the frame by tiles; INFINITY where there is no surface. */
struct depths {
    struct gp_rect window;
    int across, down;     // tiles; 0: no depth is known, nothing is hidden
    const float *pixel;   // as of gp_sets_view; borrowed
    struct tile {
        float least;       // of all pixels
        float deepest;     // of surfaces; 0: there is none
    } *tile;              // owned
};

/* True where bounds are behind the surfaces of all of their pixels, or have
 * none: no pixel's centre can show a part of what is in them. */
static bool depths_hide(const struct depths *d, const struct gp_scissor *b)
{
    const double near = b->near * (1.0 - DEPTH_SLACK);
    const struct gp_rect r = b->rect, w = d->window;
    for (int y = r.y0; y < r.y1; y++) {
        const float *const row =
            d->pixel + (size_t) (y - w.y0) * (size_t) gp_rect_w(w);
        for (int x = r.x0; x < r.x1; x++) {
            const float z = row[x - w.x0];
            if (!(z > 0.0f && z < GP_DEPTH_HUGE && near > (double) z))
                return false;
        }
    }
    return true;
}

// -- scissors -----------------------------------------------------------------

static struct gp_scissor widened(struct gp_scissor s)
{
    s.near *= 1.0 - DEPTH_SLACK;
    s.far *= 1.0 + DEPTH_SLACK;
    return s;
}

/* Returns the part of bounds in the tiles that have depths in them, from the
 * least to the greatest of these. Without depths all of it. */
static struct gp_scissor depths_cut(const struct depths *d,
                                    const struct gp_scissor *of)
{
    const struct gp_scissor s = widened(*of);
    float least = INFINITY, most = -INFINITY;
    struct gp_rect pixels = {0};
    if (gp_rect_empty(s.rect))
        return (struct gp_scissor) {0};
    if (d->across == 0)
        return s;
    const struct gp_rect w = d->window, r = s.rect;
    for (int y = (r.y0 - w.y0) / TILE; w.y0 + y * TILE < r.y1; y++) {
        for (int x = (r.x0 - w.x0) / TILE; w.x0 + x * TILE < r.x1; x++) {
            const struct tile *const t = &d->tile[y * d->across + x];
            if (!((double) t->least <= s.far && (double) t->deepest >= s.near))
                continue;
            const struct gp_rect own = gp_rect_meet(
                r, (struct gp_rect) {w.x0 + x * TILE, w.y0 + y * TILE,
                                     w.x0 + (x + 1) * TILE,
                                     w.y0 + (y + 1) * TILE});
            pixels = gp_rect_empty(pixels) ? own : gp_rect_join(pixels, own);
            least = gp_minf(t->least, least);
            most = gp_maxf(t->deepest, most);
        }
    }
    if (gp_rect_empty(pixels))
        return (struct gp_scissor) {0};
    return (struct gp_scissor) {pixels, fmax((double) least, s.near),
                                fmin((double) most, s.far)};
}

/* Returns the bounds of the n objects that are in I, within a light's (O'Rorke,
 * GPU Gems 15.5). */
static struct gp_scissor scissor_join(const struct gp_scissor *box,
                                      const uint8_t *flag, int n,
                                      const struct gp_scissor *light)
{
    const struct gp_scissor l = widened(*light);
    struct gp_scissor all = {0};
    for (int i = 0; i < n; i++) {
        const struct gp_scissor *const b = &box[i];
        const struct gp_scissor both = {gp_rect_meet(b->rect, l.rect),
                                        fmax(b->near, l.near),
                                        fmin(b->far, l.far)};
        if (!(flag[i] & GP_SET_I) || gp_rect_empty(both.rect) ||
            both.near > both.far)
            continue;
        all = gp_rect_empty(all.rect)
                  ? both
                  : (struct gp_scissor) {gp_rect_join(all.rect, both.rect),
                                         fmin(all.near, both.near),
                                         fmax(all.far, both.far)};
    }
    return all;
}

// -- the frame's sets --------------------------------------------------------

struct gp_sets {
    const struct gp_scene *scene;
    struct gp_sets_view view; // without its depth
    unsigned use;
    struct depths depths;   // across 0: none
    struct volume frustum;
    double far;                // along the view axis, over every box
    // of each object
    uint8_t *flag;
    struct gp_scissor *box;    // of its visible points
    struct gp_scissor scissor; // of the light
    struct gp_umbras *umbras;
};

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
        if (misses(&s->frustum, gp_box_middle(of), gp_box_half(of)))
            continue;
        s->flag[i] = GP_SET_F;
        *box = box_project(&s->view, of);
        if (by_depth && depths_hide(&s->depths, box))
            continue;
        s->flag[i] |= GP_SET_V;
        *box = depths_cut(&s->depths, box);
    }
}

gp_status gp_sets_look(const struct gp_log *log, struct gp_sets *s,
                       const float *depth)
{
    const double *const m = s->view.camera.to_ndc;
    const struct gp_rect window = s->view.window;
    const int w = gp_rect_w(window), h = gp_rect_h(window);
    const int across = (w + TILE - 1) / TILE, down = (h + TILE - 1) / TILE;
    const size_t tiles = (size_t) across * (size_t) down;
    struct tile *tile = NULL;
    gp_free(s->depths.tile);
    s->depths = (struct depths) {0};
    if (depth && (s->use & (GP_SETS_OCCLUSION | GP_SETS_SCISSOR))) {
        const gp_status st =
            gp_alloc(log, "depths of the scene", tiles, sizeof *tile, &tile);
        if (st)
            return st;
        s->depths = (struct depths) {window, across, down, depth, tile};
    }
    for (size_t i = 0; tile && i < tiles; i++)
        tile[i] = (struct tile) {.least = INFINITY};
    for (int y = 0; tile && y < h; y++) {
        for (int x = 0; x < w; x++) {
            const float z = depth[(size_t) y * (size_t) w + (size_t) x];
            struct tile *const t = &tile[y / TILE * across + x / TILE];
            const bool surface = z > 0.0f && z < GP_DEPTH_HUGE;
            t->least = gp_minf(surface ? z : INFINITY, t->least);
            t->deepest = gp_maxf(surface ? z : 0.0f, t->deepest);
        }
    }
    s->far = 2.0 * s->view.near;
    for (int i = 0; i < s->scene->objects; i++) {
        const struct gp_object *const o = &s->scene->object[i];
        const struct gp_v3 c = gp_box_middle(&o->box);
        s->far = fmax(s->far, gp_move_column(m, c, 3) + 1.001 * o->radius);
    }
    for (int i = 0; shows_depths(s) && i < s->depths.across * s->depths.down;
         i++)
        s->far = fmax(s->far, (double) s->depths.tile[i].deepest *
                                  (1.0 + DEPTH_SLACK));
    const struct gp_scissor all = {s->view.window, s->view.near, s->far};
    s->frustum = hull_of(&s->view, &all, NULL);
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
        gp_umbras_close(&s->umbras);
        gp_free(s->depths.tile);
    }
    GP_FREE(*sets);
}

// -- a light's sets ----------------------------------------------------------

/* Returns half the sides of an object's box, wider by what lookups in a map of
 * shadows may be off. */
static struct gp_v3 wide_half(const struct gp_sets *s,
    const struct light_range *r, const struct gp_object *o)
{
    const struct gp_v3 e = gp_box_half(&o->box);
    const struct gp_v3 to = gp_v3_sub(gp_box_middle(&o->box), r->from.p);
    const double more = s->view.texel * (r->from.w > 0.0
        ? gp_v3_length(to) + o->radius : 1.0);
    return (struct gp_v3) {e.x + more, e.y + more, e.z + more};
}

/* Takes objects in an umbra out of L, and flags I; false: it is empty. */
static bool find_lit(struct gp_sets *s, const struct light_range *r)
{
    unsigned all = 0;
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
            s->flag[i] |= GP_SET_I;
        all |= s->flag[i];
    }
    return all & GP_SET_I;
}

/* Flags S: of L, what meets the hull of the light and of what it lights. */
static void flag_light(struct gp_sets *s, const struct light_range *r,
                       const struct gp_scissor *lit)
{
    struct gp_scissor wide = *lit;
    wide.near *= 1.0 - 1e-6;
    wide.far *= 1.0 + 1e-6;
    const struct volume hull = hull_of(&s->view, &wide, &r->from);
    for (int i = 0; i < s->scene->objects; i++) {
        const struct gp_object *const o = &s->scene->object[i];
        const struct gp_v3 c = gp_box_middle(&o->box);
        if ((s->flag[i] & GP_SET_L) &&
            (!(s->use & GP_SETS_SHADOWS) ||
             !misses(&hull, c, wide_half(s, r, o))))
            s->flag[i] |= GP_SET_S;
    }
}

struct gp_scissor gp_sets_light(struct gp_sets *s, int light)
{
    const struct gp_sets_view *const v = &s->view;
    const struct light_range r = range_of(&s->scene->light[light]);
    const bool any = shows_depths(s), meets = range_meets(&r, &s->frustum);
    bool reached = any; // any of V
    for (int i = 0; i < s->scene->objects; i++) {
        const struct gp_object *const o = &s->scene->object[i];
        s->flag[i] &= GP_SET_F | GP_SET_V;
        if (!meets || range_misses(&r, o))
            continue;
        reached |= (s->flag[i] & GP_SET_V) != 0;
        s->flag[i] |= GP_SET_L;
    }
    s->scissor = (struct gp_scissor) {0};
    if (!meets || !reached)
        return s->scissor;
    const bool some = find_lit(s, &r);
    const struct gp_scissor bounds =
        isfinite(r.range) ? box_project(v, &r.box)
                          : (struct gp_scissor) {v->window, v->near, INFINITY};
    struct gp_scissor lit =
        any ? bounds
            : scissor_join(s->box, s->flag, s->scene->objects, &bounds);
    lit = depths_cut(&s->depths, &lit);
    const bool cut = s->use & (GP_SETS_SHADOWS | GP_SETS_SCISSOR);
    if ((!some && !any) || (cut && gp_rect_empty(lit.rect))) {
        for (int i = 0; i < s->scene->objects; i++)
            s->flag[i] &= (uint8_t) ~GP_SET_I;
        return s->scissor;
    }
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
