#include "glare/bound/bound.h"

#include "core/memory.h"
#include "glare/bound/state.h"

#include <math.h>

/* Roundings of what is drawn, besides those of the sum: the polygon's light
 * and the blurred kernel's sample, with as much to spare. */
static const double OWN_ROUNDINGS = 4.0;

/* Pixels around the frame that polygons may spread to; two widths, so that
 * what is kept serves many settings. */
enum { BORDER = 16, WIDE_BORDER = 64 };

// -- what is kept -------------------------------------------------------------

static void free_drawn(struct gp_bound_state *s)
{
    for (int i = 0; i < 4; i++) {
        struct gp_bound_drawn *const d = &s->drawn[i / 2][i % 2];
        gp_power_free(&d->power);
        gp_cell_table_free(&d->most);
        gp_bound_rings_free(&d->rings);
        *d = (struct gp_bound_drawn) {0};
    }
}

static void free_state(struct gp_bound_state *s)
{
    for (int c = 0; c < 3; c++) {
        gp_free(s->square[c]);
        gp_free(s->near[c]);
        gp_free(s->far[c]);
    }
    free_drawn(s);
}

void gp_bound_cache_free(struct gp_bound_cache *c)
{
    if (c->data)
        free_state(c->data);
    GP_FREE(c->data);
    c->kernel = 0;
}

static bool has_lobes(const struct gp_kernel *k)
{
    const size_t n = (size_t) k->w * (size_t) k->h;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++) {
            if (k->k.c[c][i] < 0.0f)
                return true;
        }
    }
    return false;
}

gp_status gp_bound_state(const struct gp_log *log, const struct gp_kernel *k,
                         struct gp_bound_cache *cache,
                         struct gp_bound_state **out)
{
    gp_status st = GP_OK;
    if (!cache->data || !k->serial || cache->kernel != k->serial) {
        gp_bound_cache_free(cache);
        st = gp_alloc_zero(log, "bound", 1, sizeof(struct gp_bound_state),
                           &cache->data);
        if (st)
            return st;
        cache->kernel = k->serial;
        struct gp_bound_state *const s = cache->data;
        s->lobes = has_lobes(k);
    }
    *out = cache->data;
    return st;
}

/* Makes what is kept fit frames of this size. */
static void fit(struct gp_bound_state *s, const struct gp_kernel *k, int w,
                int h)
{
    if (s->w == w && s->h == h)
        return;
    free_drawn(s);
    s->w = w;
    s->h = h;
    s->cells = gp_cells_choose(w, h, k);
}

// -- what the polygons are wrong by -------------------------------------------

struct work {
    const struct gp_log *log;
    const struct gp_sources *src;
    const struct gp_kernel *kernel;
    const struct gp_polygons *polygons;
    const struct gp_shrink *shrink;
    struct gp_bound_state *state;
    struct gp_bound_drawn *drawn;
    bool tail;
    int border;
};

/* wrong[c] += what grouping and clustering cost. */
static gp_status add_grouping(const struct work *w, double wrong[3])
{
    struct gp_bound_drawn *const d = w->drawn;
    struct gp_residue r = {0};
    double norm[3];
    gp_status st;
    GP_TRY(gp_residue_make(w->log, w->src, w->polygons, w->border, &r));
    if (!r.rows)
        goto out;
    if (!d->has_power)
        GP_TRY(gp_power_make(w->log, w->kernel, w->tail, w->src->w, w->src->h,
                             w->border, &d->power));
    d->has_power = true;
    GP_TRY(gp_power_bound(w->log, &d->power, &r, norm));
    for (int c = 0; c < 3; c++)
        wrong[c] += norm[c];
out:
    gp_residue_free(&r);
    return st;
}

static gp_status need_rings(const struct work *w)
{
    struct gp_bound_drawn *const d = w->drawn;
    if (d->has_rings)
        return GP_OK;
    const gp_status st =
        gp_bound_rings_make(w->log, w->kernel, w->tail, w->src->w + w->border,
                            w->src->h + w->border, &d->rings);
    d->has_rings = !st;
    return st;
}

/* The light e that shrinking leaves out: Young's inequality where lights stand
 * side by side, |e|^2 <= max e * sum e where they stand alone. */
static gp_status add_shrinking(const struct work *w, double wrong[3])
{
    struct gp_bound_drawn *const d = w->drawn;
    double most[3], sum[3], norm[3];
    gp_status st;
    GP_TRY(need_rings(w));
    if (!d->has_most) // blurs carry light half a box and a pixel away
        GP_TRY(gp_cell_most(w->log, &w->state->cells, w->kernel, w->tail,
                            w->border / 2 + 1, &d->most));
    d->has_most = true;
    GP_TRY(gp_cells_left(w->log, &w->state->cells, w->polygons, w->shrink,
                         &d->most, most));
    GP_TRY(gp_bound_rings_left(w->log, &d->rings, w->polygons, w->shrink, sum,
                               norm));
    for (int c = 0; c < 3; c++)
        wrong[c] += fmin(norm[c], sqrt(most[c] * sum[c]));
out:
    return st;
}

/* Float coordinates of the frame stand that far apart, and a sample may be
 * taken so far from its place. */
static double sample_place(const struct gp_sources *src)
{
    int exponent;
    frexp((double) (src->w > src->h ? src->w : src->h), &exponent);
    return ldexp(1.0, exponent - 24);
}

static gp_status add_sampling(const struct work *w, double wrong[3])
{
    double norm[3];
    const gp_status st = need_rings(w);
    if (st)
        return st;
    gp_bound_rings_sampled(&w->drawn->rings, w->polygons,
                           sample_place(w->src), norm);
    for (int c = 0; c < 3; c++)
        wrong[c] += norm[c];
    return GP_OK;
}

static int largest_side(const struct gp_polygons *p)
{
    int side = 1;
    for (size_t i = 0; i < p->n; i++)
        side = p->at[i].side > side ? p->at[i].side : side;
    return side;
}

gp_status gp_group_bound(const struct gp_log *log,
                         const struct gp_sources *src,
                         const struct gp_kernel *kernel,
                         const struct gp_splat_params *p,
                         const struct gp_polygons *polygons,
                         const struct gp_shrink *shrink, double roundings,
                         struct gp_bound_cache *cache, double *out)
{
    gp_status st;
    struct gp_bound_state *s;
    double wrong[3] = {0}, least;
    *out = INFINITY;
    GP_TRY(gp_bound_state(log, kernel, cache, &s));
    if (s->lobes)
        goto out;
    fit(s, kernel, src->w, src->h);
    const int side = largest_side(polygons);
    const bool tail = p->method == GP_GROUP_CORE, wide = side > BORDER;
    const struct work w = {
        .log = log, .src = src, .kernel = kernel, .polygons = polygons,
        .shrink = shrink, .state = s, .drawn = &s->drawn[tail][wide],
        .tail = tail, .border = wide ? WIDE_BORDER : BORDER,
    };
    GP_TRY(gp_bound_least(log, src, kernel, s, &least));
    if (side > 1) {
        GP_TRY(add_grouping(&w, wrong));
        GP_TRY(add_sampling(&w, wrong));
    }
    if (shrink->left_out > 0.0)
        GP_TRY(add_shrinking(&w, wrong));
    const double all = sqrt(wrong[0] * wrong[0] + wrong[1] * wrong[1] +
                            wrong[2] * wrong[2]);
    // each rounding is relative to what is drawn: the layer and its error
    const double share = (roundings + OWN_ROUNDINGS) * 0x1p-24;
    if (all == 0.0)
        *out = share;
    else if (least > 0.0)
        *out = all / least * (1.0 + share) + share;
out:
    return st;
}
