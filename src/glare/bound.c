#include "glare/bound.h"

#include "core/memory.h"
#include "glare/bound_state.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// -- what is kept -------------------------------------------------------------

static void free_state(struct gp_bound_state *s)
{
    for (int c = 0; c < 3; c++) {
        gp_free(s->square[c]);
        gp_free(s->near[c]);
        gp_free(s->far[c]);
        for (int tail = 0; tail < 2; tail++)
            gp_free(s->power[tail].power[c]);
    }
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

// -- grouping -----------------------------------------------------------------

/* The light less what the polygons make of it, with a border. */
struct rest {
    struct gp_planes d;
    uint8_t *cover; // how many polygons' boxes lie on a pixel, 255 or more
    int w, h, border;
};

static void add_sources(const struct gp_sources *src, const struct rest *r)
{
    for (int y = 0; y < src->h; y++) {
        const size_t at = (size_t) (y + r->border) * (size_t) r->w +
                          (size_t) r->border;
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
            for (int c = 0; c < 3; c++)
                r->d.c[c][at + (size_t) src->x[i]] = src->rgb[c][i];
        }
    }
}

/* Weights of a box of side m at a fraction f, bilinear: m + 1 of them. */
static void weigh(int m, float f, float *weight)
{
    for (int i = 0; i <= m; i++)
        weight[i] = ((i < m ? 1.0f - f : 0.0f) + (i > 0 ? f : 0.0f)) /
                    (float) m;
}

static void take_polygon(const struct gp_polygon *p, const struct rest *r)
{
    enum { MOST = 65 };
    float across[MOST], down[MOST];
    const int m = gp_blur_box[p->blur];
    const float x = p->x - (float) (m - 1) / 2.0f;
    const float y = p->y - (float) (m - 1) / 2.0f;
    const int x0 = (int) floorf(x), y0 = (int) floorf(y);
    weigh(m, x - floorf(x), across);
    weigh(m, y - floorf(y), down);
    for (int j = 0; j <= m; j++) {
        const size_t at = (size_t) (y0 + j + r->border) * (size_t) r->w +
                          (size_t) (x0 + r->border);
        for (int i = 0; i <= m; i++) {
            const float share = down[j] * across[i];
            uint8_t *const cover = &r->cover[at + (size_t) i];
            *cover = (uint8_t) (*cover + (share > 0.0f && *cover < 255));
            for (int c = 0; c < 3; c++)
                r->d.c[c][at + (size_t) i] -= p->rgb[c] * share;
        }
    }
}

static gp_status make_rest(const struct gp_log *log,
                           const struct gp_sources *src,
                           const struct gp_polygons *polygons, struct rest *r)
{
    int side = 1;
    for (size_t i = 0; i < polygons->n; i++)
        side = polygons->at[i].side > side ? polygons->at[i].side : side;
    r->border = side / 2 + 2;
    r->w = src->w + 2 * r->border;
    r->h = src->h + 2 * r->border;
    const size_t n = (size_t) r->w * (size_t) r->h;
    void *v;
    gp_status st = gp_planes_make(log, "bound", n, &r->d);
    if (!st)
        st = gp_alloc_zero(log, "bound", n, 1, &v);
    if (st)
        return st;
    r->cover = v;
    for (int c = 0; c < 3; c++)
        memset(r->d.c[c], 0, n * sizeof(float));
    add_sources(src, r);
    for (size_t i = 0; i < polygons->n; i++)
        take_polygon(&polygons->at[i], r);
    return GP_OK;
}

/* The splat layer is the kernel (its tail, for CORE) over a light of its own:
 * polygons, blurred by their boxes, between pixels as bilinear sampling puts
 * them. So grouping is wrong by the kernel over the difference of the two. */
static gp_status group_error(const struct gp_log *log,
                             const struct gp_sources *src,
                             const struct gp_kernel *k, bool tail,
                             const struct gp_polygons *polygons,
                             struct gp_bound_state *s, int *cover, double *out)
{
    struct rest r = {0};
    double norm[3] = {0}, sum = 0.0;
    gp_status st = make_rest(log, src, polygons, &r);
    if (!st)
        st = gp_bound_convolved(log, k, tail, &r.d, r.w, r.h, s, norm);
    for (int c = 0; c < 3; c++) {
        // what rounding of both transforms may have hidden
        double all = 0.0;
        for (size_t i = 0; !st && i < (size_t) r.w * (size_t) r.h; i++)
            all += (double) r.d.c[c][i] * (double) r.d.c[c][i];
        norm[c] += 0x1p-20 * sqrt(all) * k->norm1[c];
        sum += norm[c] * norm[c];
    }
    for (size_t i = 0; !st && i < (size_t) r.w * (size_t) r.h; i++)
        *cover = r.cover[i] > *cover ? r.cover[i] : *cover;
    if (*cover == 255)
        *cover = (int) fmin((double) polygons->n, INT_MAX);
    *out = sqrt(sum);
    gp_free(r.cover);
    gp_planes_free(&r.d);
    return st;
}

// -- shrinking ----------------------------------------------------------------

/* Sum of magnitudes of a channel beyond each square ring; n + 1 numbers. */
static gp_status ring_tails(const struct gp_log *log, const struct gp_kernel *k,
                            int c, bool tail, int n, double **out)
{
    void *v;
    gp_status st = gp_alloc_zero(log, "bound", (size_t) n + 2, sizeof **out,
                                 &v);
    if (st)
        return st;
    double *const left = v;
    for (int y = 0; y < k->h; y++) {
        for (int x = 0; x < k->w; x++) {
            const int dx = abs(x - k->cx), dy = abs(y - k->cy);
            const int ring = dx > dy ? dx : dy;
            if (ring <= n && !(tail && ring <= GP_CORE_RADIUS))
                left[ring] += fabs((double) k->k.c[c][(size_t) y *
                                                      (size_t) k->w +
                                                      (size_t) x]);
        }
    }
    for (int i = n - 1; i >= 0; i--)
        left[i] += left[i + 1];
    *out = left; // left[i]: ring i and beyond
    return GP_OK;
}

/* Sum of squares of a polygon's weights on one axis. */
static double axis_square(const struct gp_polygon *p, float at)
{
    const int m = gp_blur_box[p->blur];
    const double x = (double) at - (m - 1) / 2.0, f = x - floor(x);
    return ((1.0 - f) * (1.0 - f) + f * f + (m - 1)) / ((double) m * m);
}

/* What one channel's polygons leave out, by rings of the kernel. */
struct left_out {
    int n;        // rings
    double *beyond; // sum of the kernel on each ring and beyond
    double *square; // of the light that leaves this ring out, not the one before
    double sum, peak;
};

static void leave_out(const struct gp_polygons *polygons,
                      const struct gp_shrink *shrink, int c,
                      struct left_out *l)
{
    for (size_t i = 0; i < polygons->n; i++) {
        const struct gp_polygon *const p = &polygons->at[i];
        const int reach = shrink->reach[gp_source_bin(p->light)];
        const int carry = gp_blur_box[p->blur] / 2 + 1;
        // (samples left out come from rings after this one)
        const int from = reach - carry > 0 ? reach - carry + 1 : 0;
        if (from >= l->n || !(l->beyond[from] > 0.0))
            continue;
        const double light = (double) p->rgb[c];
        const double most = (double) p->light > 0.0
                                ? light / (double) p->light : INFINITY;
        l->square[from] += light * light * axis_square(p, p->x) *
                           axis_square(p, p->y);
        l->sum += light * l->beyond[from];
        l->peak += fmin(most * (double) shrink->least,
                        light * l->beyond[from]);
    }
}

/* The least of two bounds of what is left out, e >= 0:
 *   ||e||_2^2 <= max e * sum e, where a polygon leaves out `least` at most in
 *             any pixel;
 *   ||e||_2   <= sum over rings of ||ring||_1 ||light that leaves it out||_2
 *             (Young's inequality), where at most `cover` polygons share a
 *             pixel of that light. */
static double norm_of(const struct left_out *l, int cover)
{
    double light = 0.0, young = 0.0;
    for (int i = 0; i < l->n; i++) {
        light += l->square[i];
        young += (l->beyond[i] - l->beyond[i + 1]) * sqrt(cover * light);
    }
    return fmin(sqrt(l->peak * l->sum), young);
}

static gp_status shrink_error(const struct gp_log *log,
                              const struct gp_kernel *k, bool tail,
                              const struct gp_polygons *polygons,
                              const struct gp_shrink *shrink, int cover,
                              double *out)
{
    double square = 0.0;
    gp_status st = GP_OK;
    *out = 0.0;
    if (!(shrink->least > 0.0f))
        return GP_OK;
    const int far_x = abs(k->cx) + k->w, far_y = abs(k->cy) + k->h;
    for (int c = 0; c < 3 && !st; c++) {
        void *v = NULL;
        struct left_out l = {.n = far_x > far_y ? far_x : far_y};
        st = ring_tails(log, k, c, tail, l.n, &l.beyond);
        if (!st)
            st = gp_alloc_zero(log, "bound", (size_t) l.n, sizeof(double), &v);
        l.square = v;
        if (!st) {
            leave_out(polygons, shrink, c, &l);
            const double norm = norm_of(&l, cover);
            square += norm * norm;
        }
        gp_free(l.beyond);
        gp_free(l.square);
    }
    *out = sqrt(square);
    return st;
}

// -- all of it ----------------------------------------------------------------

static bool is_single(const struct gp_splat_params *p)
{
    return p->group == 1 && !p->cluster;
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
    const bool tail = p->method == GP_GROUP_CORE && !is_single(p);
    double least = 0.0, grouped = 0.0, shrunk = 0.0;
    int cover = 1;
    *out = INFINITY;
    GP_TRY(gp_bound_state(log, kernel, cache, &s));
    if (s->lobes)
        return GP_OK;
    GP_TRY(gp_bound_least(log, src, kernel, s, &least));
    if (!(least > 0.0))
        return GP_OK;
    if (!is_single(p))
        GP_TRY(group_error(log, src, kernel, tail, polygons, s, &cover,
                           &grouped));
    GP_TRY(shrink_error(log, kernel, tail, polygons, shrink, cover,
                        &shrunk));
    const double wrong = (grouped + shrunk) / least;
    // the rest is in proportion to what is drawn: the layer and its error
    const double rounding = roundings * 0x1p-24;
    *out = wrong + rounding * (1.0 + wrong);
out:
    return st;
}
