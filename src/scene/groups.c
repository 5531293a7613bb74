/* Groups of objects, and tests of 16 boxes at once. */
#include "scene/groups.h"

#include "core/cpu.h"
#include "core/memory.h"
#include "scene/scene_priv.h"

#include <string.h>

/* Rounding of sums of a few products, in parts of the largest. */
static const double ROUND = 1e-14;

// -- packs -------------------------------------------------------------------

/* Sets the bounds of a pack from its boxes; one at least counts. */
static void set_bounds(struct gp_pack *p)
{
    double middle[3], reach[3], centre[3], apart[3], least[3];
    for (int c = 0; c < 3; c++) {
        double lo = INFINITY, hi = -INFINITY, lo_at = lo, hi_at = hi;
        least[c] = INFINITY;
        for (int k = 0; k < GP_PACK; k++) {
            const double at = p->at[c][k], e = p->half[c][k];
            if (!(p->used >> k & 1))
                continue;
            lo = gp_mind(at - e, lo);
            hi = gp_maxd(at + e, hi);
            lo_at = gp_mind(at, lo_at);
            hi_at = gp_maxd(at, hi_at);
            least[c] = gp_mind(e, least[c]);
        }
        middle[c] = 0.5 * (lo + hi);
        reach[c] = 0.5 * (hi - lo);
        centre[c] = 0.5 * (lo_at + hi_at);
        apart[c] = 0.5 * (hi_at - lo_at);
    }
    p->middle = (struct gp_v3) {middle[0], middle[1], middle[2]};
    p->reach = (struct gp_v3) {reach[0], reach[1], reach[2]};
    p->centre = (struct gp_v3) {centre[0], centre[1], centre[2]};
    p->inner = (struct gp_v3) {apart[0] - least[0], apart[1] - least[1],
                               apart[2] - least[2]};
    p->apart = gp_v3_length((struct gp_v3) {apart[0], apart[1], apart[2]});
    p->round = ROUND * (fabs(middle[0]) + fabs(middle[1]) + fabs(middle[2]) +
                        reach[0] + reach[1] + reach[2]);
}

/* Returns how far a box reaches along a plane's normal, to one side. */
static inline double along(struct gp_half h, struct gp_v3 e)
{
    return fabs(h.n.x) * e.x + fabs(h.n.y) * e.y + fabs(h.n.z) * e.z;
}

/* Returns bits of the values that are at most `limit`. */
static unsigned at_most(const double v[GP_PACK], double limit)
{
    static const uint64_t bit[GP_PACK] = {
        1, 2, 4, 8, 0x10, 0x20, 0x40, 0x80,
        0x100, 0x200, 0x400, 0x800, 0x1000, 0x2000, 0x4000, 0x8000};
    uint64_t bits = 0;
    for (int k = 0; k < GP_PACK; k++)
        bits |= v[k] <= limit ? bit[k] : 0;
    return (unsigned) bits;
}

// four boxes at once; masks are all ones where true
typedef double four __attribute__((vector_size(32)));
typedef double four_loose __attribute__((vector_size(32), aligned(8)));
typedef int64_t four_bits __attribute__((vector_size(32)));

static inline four four_from(const double *p)
{
    return *(const four_loose *) p;
}

static inline four all_of(double v)
{
    return (four) {v, v, v, v};
}

static inline unsigned bits_of(four_bits mask)
{
    const four_bits b = mask & (four_bits) {1, 2, 4, 8};
    return (unsigned) (b[0] | b[1] | b[2] | b[3]);
}

/* Returns bits of the boxes of `in` that are before one of the planes `pick` by
 * more than `limit`, with their farthest points, side 1, or their nearest, -1;
 * bits of other boxes are set. */
static GP_CLONES unsigned beyond(const struct gp_pack *p, unsigned in,
                                 const struct gp_half *plane,
                                 const unsigned char *pick, int n, double side,
                                 double limit)
{
    enum { FOURS = GP_PACK / 4 };
    static const four_bits lane = {1, 2, 4, 8};
    four_bits out[FOURS], every = {0};
    unsigned bits = 0;
    for (int k = 0; k < FOURS; k++) {
        const int64_t rest = ~(int64_t) (in >> 4 * k);
        out[k] = ((four_bits) {rest, rest, rest, rest} & lane) == lane;
    }
    for (int i = 0; i < n && !(every[0] & every[1] & every[2] & every[3]);
         i++) {
        const struct gp_half h = plane[pick[i]];
        const four x = all_of(h.n.x), y = all_of(h.n.y), z = all_of(h.n.z);
        const four u = all_of(side * fabs(h.n.x)),
                   v = all_of(side * fabs(h.n.y)),
                   w = all_of(side * fabs(h.n.z));
        every = ~(four_bits) {0};
        for (int k = 0; k < FOURS; k++) {
            const four at = x * four_from(p->at[0] + 4 * k) +
                            y * four_from(p->at[1] + 4 * k) +
                            z * four_from(p->at[2] + 4 * k) + all_of(h.d);
            const four reach = u * four_from(p->half[0] + 4 * k) +
                               v * four_from(p->half[1] + 4 * k) +
                               w * four_from(p->half[2] + 4 * k);
            out[k] |= at + reach > all_of(limit);
            every &= out[k];
        }
    }
    for (int k = 0; k < FOURS; k++)
        bits |= bits_of(out[k]) << 4 * k;
    return bits;
}

/* Returns bits of boxes that are beside another box by more than `slack`. */
static GP_CLONES unsigned beside(const struct gp_pack *p,
                                 const struct gp_box *box, double slack)
{
    const double lo[3] = {box->lo.x - slack, box->lo.y - slack,
                          box->lo.z - slack};
    const double hi[3] = {box->hi.x + slack, box->hi.y + slack,
                          box->hi.z + slack};
    unsigned bits = 0;
    for (int k = 0; k < GP_PACK; k += 4) {
        four_bits out = {0, 0, 0, 0};
        for (int c = 0; c < 3; c++) {
            const four at = four_from(p->at[c] + k);
            const four e = four_from(p->half[c] + k);
            out |= at - e > all_of(hi[c]);
            out |= at + e < all_of(lo[c]);
        }
        bits |= bits_of(out) << k;
    }
    return bits;
}

/* Planes of an umbra that boxes of a pack may cross. */
struct crossed {
    int n;
    unsigned char plane[GP_BODY_EDGES + GP_BODY_FACES];
};

/* True where each box of a pack has a point outside a plane of an umbra. */
static bool all_outside(const struct gp_pack *p, const struct gp_umbra *u,
                        struct gp_half h, double slack)
{
    return gp_half_at(h, p->centre) - along(h, p->inner) > slack - u->margin;
}

/* Finds them, by the bounds of a pack; none: the umbra holds all boxes. False:
 * it holds no box, by plane *out_by, which is asked first. */
static bool find_crossed(const struct gp_pack *p, const struct gp_umbra *u,
                         unsigned char *out_by, struct crossed *out)
{
    // (a margin is 1e-6 of the largest distance of a plane)
    const double slack = p->round + 1e6 * ROUND * u->margin;
    int n = 0;
    if (*out_by < u->planes && all_outside(p, u, u->plane[*out_by], slack))
        return false;
    for (int i = 0; i < u->planes; i++) {
        const struct gp_half h = u->plane[i];
        if (all_outside(p, u, h, slack)) {
            *out_by = (unsigned char) i;
            return false;
        }
        out->plane[n] = (unsigned char) i;
        n += !(gp_half_at(h, p->middle) + along(h, p->reach) <=
               -slack - u->margin);
    }
    out->n = n;
    return true;
}

unsigned gp_pack_held(const struct gp_pack *p, const struct gp_umbras *u,
                      unsigned in, struct gp_pack_hint *hint)
{
    struct crossed crossed[GP_OCCLUDERS];
    unsigned some = 0, held = 0;
    const int last = hint->held;
    if (last < u->n && find_crossed(p, &u->umbra[last], &hint->out_by[last],
                                    &crossed[last]) && crossed[last].n == 0)
        return in;
    unsigned near = gp_umbras_near(u, p->centre, p->apart);
    for (int i = 0; near; i++, near >>= 1) {
        if (!(near & 1) || !find_crossed(p, &u->umbra[i], &hint->out_by[i],
                                         &crossed[i]))
            continue;
        if (crossed[i].n == 0) {
            hint->held = i;
            return in;
        }
        some |= 1u << i;
    }
    for (int i = 0; some && held != in; i++, some >>= 1) {
        const struct gp_umbra *const of = &u->umbra[i];
        const unsigned left = in & ~held;
        if (some & 1)
            held |= left & ~beyond(p, left, of->plane, crossed[i].plane,
                                   crossed[i].n, 1.0, -of->margin);
    }
    return held;
}

unsigned gp_pack_missed(const struct gp_pack *p, const struct gp_volume *v,
                        unsigned in)
{
    // (a slack is 1e-9 of the largest distance of a plane)
    const double slack = p->round + 1e9 * ROUND * v->slack;
    unsigned char pick[sizeof v->plane / sizeof *v->plane];
    int n = 0;
    for (int i = 0; i < v->planes; i++) {
        const struct gp_half h = v->plane[i];
        if (gp_half_at(h, p->middle) - along(h, p->reach) > v->slack + slack)
            return in; // all are outside
        pick[n] = (unsigned char) i;
        n += !(gp_half_at(h, p->centre) + along(h, p->inner) <=
               v->slack - slack);
    }
    return in & (beside(p, &v->box, v->slack) |
                 beyond(p, in, v->plane, pick, n, -1.0, v->slack));
}

// -- groups ------------------------------------------------------------------

enum { CURVE = 10 }; // bits of the curve an axis

/* An object and its place on the curve. */
struct on_curve {
    uint32_t at;
    int object;
};

/* Spreads 10 bits to every third. */
static uint32_t spread(uint32_t v)
{
    v = (v | v << 16) & 0x030000ffu;
    v = (v | v << 8) & 0x0300f00fu;
    v = (v | v << 4) & 0x030c30c3u;
    return (v | v << 2) & 0x09249249u;
}

static uint32_t cell_of(double v, double lo, double hi)
{
    const double cells = (double) (1 << CURVE);
    const double at = hi > lo ? (v - lo) / (hi - lo) * cells : 0.0;
    return (uint32_t) (at < cells - 1.0 ? at : cells - 1.0);
}

/* Sorts along the curve, by 10 bits after another from the lowest. */
static void sort_curve(struct on_curve *list, struct on_curve *other, int n)
{
    for (int pass = 0; pass < 3; pass++) {
        int first[(1 << CURVE) + 1] = {0};
        const int shift = CURVE * pass, mask = (1 << CURVE) - 1;
        for (int i = 0; i < n; i++)
            first[(list[i].at >> shift & (unsigned) mask) + 1]++;
        for (int i = 0; i < mask; i++)
            first[i + 1] += first[i];
        for (int i = 0; i < n; i++)
            other[first[list[i].at >> shift & (unsigned) mask]++] = list[i];
        memcpy(list, other, (size_t) n * sizeof *list);
    }
}

/* Lists the objects that have a box, in the order of the curve. */
static int list_curve(const struct gp_scene *s, struct on_curve *list,
                      struct on_curve *other)
{
    struct gp_box all = GP_BOX_EMPTY;
    int n = 0;
    for (int i = 0; i < s->objects; i++) {
        if (gp_box_empty(s->object[i].box))
            continue;
        all = gp_box_with(all, gp_box_middle(&s->object[i].box));
        list[n++].object = i;
    }
    for (int i = 0; i < n; i++) {
        const struct gp_v3 c = gp_box_middle(&s->object[list[i].object].box);
        list[i].at = spread(cell_of(c.x, all.lo.x, all.hi.x)) |
                     spread(cell_of(c.y, all.lo.y, all.hi.y)) << 1 |
                     spread(cell_of(c.z, all.lo.z, all.hi.z)) << 2;
    }
    sort_curve(list, other, n);
    return n;
}

static gp_status make_arrays(const struct gp_log *log, int n,
                             struct gp_groups *g)
{
    static const char what[] = "groups of objects";
    const size_t groups = ((size_t) n + GP_PACK - 1) / GP_PACK;
    const size_t all = groups * GP_PACK;
    gp_status st;
    g->n = (int) groups;
    GP_TRY(gp_alloc_zero(log, what, groups, sizeof *g->pack, &g->pack));
    GP_TRY(gp_alloc(log, what, all, sizeof *g->object, &g->object));
    for (int c = 0; c < 3; c++) {
        GP_TRY(gp_alloc(log, what, all, sizeof(double), &g->at[c]));
        GP_TRY(gp_alloc(log, what, all, sizeof(double), &g->half[c]));
        GP_TRY(gp_alloc(log, what, all, sizeof(double), &g->wide[c]));
    }
    GP_TRY(gp_alloc(log, what, all, sizeof *g->radius, &g->radius));
    GP_TRY(gp_alloc(log, what, all, sizeof *g->size, &g->size));
    GP_TRY(gp_alloc_zero(log, what, groups, sizeof *g->largest, &g->largest));
    GP_TRY(gp_alloc(log, what, groups, sizeof *g->near, &g->near));
out:
    return st;
}

/* Writes place k of the groups; those after the last object repeat it, and do
 * not count. */
static void set_place(const struct gp_scene *s, const struct gp_bodies *bodies,
                      struct gp_groups *g, int k, int object, bool counts)
{
    const struct gp_object *const o = &s->object[object];
    const struct gp_v3 c = gp_box_middle(&o->box), e = gp_box_half(&o->box);
    const int group = k / GP_PACK;
    const double at[3] = {c.x, c.y, c.z}, half[3] = {e.x, e.y, e.z};
    for (int i = 0; i < 3; i++) {
        g->at[i][k] = at[i];
        g->half[i][k] = half[i];
    }
    g->object[k] = object;
    g->radius[k] = gp_object_radius(o, c);
    g->size[k] = counts ? gp_darkest_size(bodies, o) : 0.0;
    g->largest[group] = gp_maxd(g->size[k], g->largest[group]);
    g->pack[group].used |= (unsigned) counts << k % GP_PACK;
}

gp_status gp_groups_make(const struct gp_log *log, const struct gp_scene *s,
                         const struct gp_bodies *bodies, struct gp_groups *out)
{
    struct on_curve *list = NULL, *other = NULL;
    const size_t most = (size_t) s->objects + 1;
    struct gp_groups g = {0};
    gp_status st;
    *out = g;
    GP_TRY(gp_alloc(log, "groups of objects", most, sizeof *list, &list));
    GP_TRY(gp_alloc(log, "groups of objects", most, sizeof *other, &other));
    const int n = list_curve(s, list, other);
    if (n == 0)
        goto out;
    GP_TRY(make_arrays(log, n, &g));
    for (int k = 0; k < g.n * GP_PACK; k++)
        set_place(s, bodies, &g, k, list[k < n ? k : n - 1].object, k < n);
    for (int i = 0; i < g.n; i++) {
        for (int c = 0; c < 3; c++) {
            g.pack[i].at[c] = g.at[c] + GP_PACK * i;
            g.pack[i].half[c] = g.half[c] + GP_PACK * i;
        }
        set_bounds(&g.pack[i]);
    }
    *out = g;
    g = (struct gp_groups) {0};
out:
    gp_groups_free(&g);
    gp_free(other);
    gp_free(list);
    return st;
}

void gp_groups_free(struct gp_groups *g)
{
    for (int c = 0; c < 3; c++) {
        gp_free(g->at[c]);
        gp_free(g->half[c]);
        gp_free(g->wide[c]);
    }
    gp_free(g->pack);
    gp_free(g->object);
    gp_free(g->radius);
    gp_free(g->size);
    gp_free(g->largest);
    gp_free(g->near);
    *g = (struct gp_groups) {0};
}

// -- before a light ----------------------------------------------------------

static struct gp_v3 plus(struct gp_v3 v, double more)
{
    return (struct gp_v3) {v.x + more, v.y + more, v.z + more};
}

void gp_groups_near(struct gp_groups *g, const struct gp_reach *light)
{
    for (int i = 0; i < g->n; i++) {
        const struct gp_pack *const p = &g->pack[i];
        g->near[i] = !gp_reach_too_far(light, p->middle,
                                       plus(p->reach, p->round));
    }
}

GP_CLONES unsigned gp_groups_reached(const struct gp_groups *g, int group,
                                     const struct gp_reach *light)
{
    const struct gp_pack *const p = &g->pack[group];
    const double *const radius = g->radius + GP_PACK * group;
    const double *const x = p->at[0], *const y = p->at[1], *const z = p->at[2];
    const double *const u = p->half[0], *const v = p->half[1],
                        *const w = p->half[2];
    const double px = light->from.p.x, py = light->from.p.y,
                 pz = light->from.p.z, ax = light->along.x,
                 ay = light->along.y, az = light->along.z;
    const double range = light->range * light->range, weight = light->from.w;
    const double cos_outer = light->cos, sin_outer = light->sin;
    double away[GP_PACK], beside[GP_PACK]; // under or at 0: in
    for (int k = 0; k < GP_PACK; k++) {
        const double dx = x[k] - px, dy = y[k] - py, dz = z[k] - pz;
        const double a = fabs(dx) - u[k], b = fabs(dy) - v[k],
                     c = fabs(dz) - w[k];
        const double s = a > 0.0 ? a : 0.0, t = b > 0.0 ? b : 0.0,
                     q = c > 0.0 ? c : 0.0;
        away[k] = weight * (s * s + t * t + q * q);
    }
    const unsigned in = p->used & at_most(away, range);
    if (light->sin == 0.0)
        return in;
    for (int k = 0; k < GP_PACK; k++) { // gp_reach_beside()
        const double dx = x[k] - px, dy = y[k] - py, dz = z[k] - pz;
        const double front = dx * ax + dy * ay + dz * az;
        const double rest = dx * dx + dy * dy + dz * dz - front * front;
        const double aside = sqrt(rest > 0.0 ? rest : 0.0);
        beside[k] = cos_outer * aside - sin_outer * front -
                    (radius[k] + 1e-9 * (fabs(front) + aside));
    }
    return in & at_most(beside, 0.0);
}

/* Sets angle[k], the measure of gp_darkest_try(), of a group's objects. */
static GP_CLONES void set_angles(const struct gp_groups *g, int group,
                                 const struct gp_reach *light,
                                 double angle[GP_PACK])
{
    const struct gp_pack *const p = &g->pack[group];
    const double *const x = p->at[0], *const y = p->at[1], *const z = p->at[2];
    const double *const size = g->size + GP_PACK * group;
    const double px = light->from.p.x, py = light->from.p.y,
                 pz = light->from.p.z;
    for (int k = 0; k < GP_PACK; k++) {
        const double dx = x[k] - px, dy = y[k] - py, dz = z[k] - pz;
        // (of a size of 0 at the light 0 / 0, which is never chosen)
        angle[k] = size[k] / (dx * dx + dy * dy + dz * dz + 1e-6 * size[k]);
    }
}

void gp_groups_darkest(const struct gp_groups *g, int group, unsigned in,
                       const struct gp_reach *light, struct gp_darkest *most)
{
    const struct gp_pack *const p = &g->pack[group];
    const double *const size = g->size + GP_PACK * group;
    double angle[GP_PACK];
    if (!(g->largest[group] > 0.0))
        return;
    if (light->from.w > 0.0)
        set_angles(g, group, light, angle);
    else
        memcpy(angle, size, sizeof angle);
    // (those as large as the least may be of an earlier object)
    const double least = most->n < GP_OCCLUDERS
                             ? 0.0 : most->size[most->n - 1] * (1.0 - ROUND);
    unsigned some = in & ~at_most(angle, least);
    for (int k = 0; some; k++, some >>= 1) {
        if ((some & 1) && size[k] > 0.0)
            gp_darkest_try(most, light,
                           (struct gp_v3) {p->at[0][k], p->at[1][k],
                                           p->at[2][k]},
                           size[k], g->object[GP_PACK * group + k]);
    }
}

/* Widens the sides of a group's boxes; returns the least and the largest of
 * what they grow by. */
static GP_CLONES void widen(struct gp_groups *g, int group,
                            const struct gp_reach *light, double texel,
                            double grown[2])
{
    const int first = GP_PACK * group;
    const double *const x = g->at[0] + first, *const y = g->at[1] + first,
                        *const z = g->at[2] + first;
    const double *const radius = g->radius + first;
    const double px = light->from.p.x, py = light->from.p.y,
                 pz = light->from.p.z;
    const bool lamp = light->from.w > 0.0;
    double more[GP_PACK];
    for (int k = 0; k < GP_PACK; k++) {
        const double dx = x[k] - px, dy = y[k] - py, dz = z[k] - pz;
        more[k] = texel * (lamp ? sqrt(dx * dx + dy * dy + dz * dz) + radius[k]
                                : 1.0);
    }
    for (int c = 0; c < 3; c++) {
        const double *const from = g->half[c] + first;
        double *const to = g->wide[c] + first;
        for (int k = 0; k < GP_PACK; k++)
            to[k] = from[k] + more[k];
    }
    grown[0] = grown[1] = more[0];
    for (int k = 1; k < GP_PACK; k++) {
        grown[0] = more[k] < grown[0] ? more[k] : grown[0];
        grown[1] = more[k] > grown[1] ? more[k] : grown[1];
    }
}

struct gp_pack gp_groups_widen(struct gp_groups *g, int group,
                               const struct gp_reach *light, double texel)
{
    struct gp_pack p = g->pack[group];
    double grown[2];
    if (texel == 0.0)
        return p;
    widen(g, group, light, texel, grown);
    for (int c = 0; c < 3; c++)
        p.half[c] = g->wide[c] + GP_PACK * group;
    p.reach = plus(p.reach, grown[1]);
    p.inner = plus(p.inner, -grown[0]);
    p.round += 3.0 * ROUND * grown[1];
    return p;
}
