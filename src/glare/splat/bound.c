// SPDX-License-Identifier: Apache-2.0
/* Bounds the error of a splat layer before anything is drawn. Its parts:
 *
 *   grouping   the kernel, spread over sources less polygons, by a transform in
 *              double: the error itself
 *   places     samples that GL takes up to a float's step aside
 *   shrinking  the light that is left out, by Young's inequality
 *   rounding   of each sum
 *
 * over the least that the exact layer can be. */
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/splat/splat_priv.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Roundings of the factors of the sum, the polygon's light and the blurred
 * kernel's sample, and of light and samples where the residue is spread, doubled
 * for safety. */
static const double OWN_ROUNDINGS = 8.0;

/* A polygon's light is within a square of twice its cell's side, on the lattice
 * of cells. So at most four of one size share a pixel, and the norm of their
 * sum is at most twice the root of their squares' sum. */
static const double SHARED = 2.0;

/* -- the error of groups --------------------------------------------------- */

/* Sources less polygons, before either is spread. A polygon's light is set down
 * bilinearly at P0 - (M - 1) / 2 and blurred by its box of side M. */
struct residue {
    int w, h, pad;      // of the frame; the planes have pad pixels around it
    struct gp_planes d; // (w + 2 pad) * (h + 2 pad)
};

/* Pixels of a polygon's light on one axis: box + 1 from `start`, the
 * ones between the ends all with weight 1 / box. */
struct footprint {
    int start;
    double first, middle, last; // weights
};

static struct footprint make_footprint(float at, int box)
{
    const double start = (double) at - (box - 1) / 2.0;
    const double part = start - floor(start), each = 1.0 / box;
    return (struct footprint) {
        .start = (int) floor(start),
        .first = (1.0 - part) * each, .middle = each, .last = part * each,
    };
}

static void subtract(const struct residue *r, const struct gp_polygon *p)
{
    const int box = gp_blur_box[p->blur];
    const struct footprint v = make_footprint(p->y, box);
    const struct footprint u = make_footprint(p->x, box);
    const size_t width = (size_t) r->w + 2 * (size_t) r->pad;
    for (int j = 0; j <= box; j++) {
        const double down = j == 0 ? v.first : j < box ? v.middle : v.last;
        for (int c = 0; c < 3 && down > 0.0; c++) {
            float *const to = r->d.c[c] +
                              (size_t) (v.start + r->pad + j) * width +
                              (size_t) (u.start + r->pad);
            const double light = (double) p->rgb[c] * down;
            for (int i = 0; i <= box; i++) {
                const double along = i == 0    ? u.first
                                     : i < box ? u.middle : u.last;
                if (along > 0.0)
                    to[i] -= (float) (light * along);
            }
        }
    }
}

static gp_status make_residue(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_polygons *polygons, int pad,
    struct residue *out)
{
    struct residue r = {.w = src->w, .h = src->h, .pad = pad};
    const size_t width = (size_t) r.w + 2 * (size_t) pad;
    const size_t n = width * ((size_t) r.h + 2 * (size_t) pad);
    gp_status st = gp_planes_make(log, "bound", n, &r.d);
    if (st)
        return st;
    gp_planes_clear(&r.d, 0, n);
    for (int y = 0; y < src->h; y++) {
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
            for (int c = 0; c < 3; c++)
                r.d.c[c][(size_t) (y + pad) * width +
                         (size_t) (src->x[i] + pad)] = src->rgb[c][i];
        }
    }
    for (size_t i = 0; i < polygons->n; i++)
        subtract(&r, &polygons->at[i]);
    *out = r;
    return GP_OK;
}

/* Spreads the residue, light less light; `layer` is of its planes' size. */
static gp_status spread(const struct gp_log *log, const struct residue *r,
                        const struct gp_sources *like,
                        const struct gp_kernel *kernel, struct gp_planes *layer)
{
    gp_status st;
    void *state = NULL;
    const int w = r->w + 2 * r->pad, h = r->h + 2 * r->pad;
    const size_t n = (size_t) w * (size_t) h;
    const struct gp_glare_params p = {.gain = 1.0f, .in_double = true,
                                      .last = true};
    struct glarepp_layer_facts stats = {0};
    struct gp_sources frame = {.w = w, .h = h}, light = {0};
    const struct gp_glare_request req = {
        .log = log, .params = &p, .src = &light, .kernel = kernel,
        .layer = layer, .stats = &stats,
    };
    memcpy(frame.luminance, like->luminance, sizeof frame.luminance);
    GP_TRY(gp_planes_make(log, "bound", n, layer));
    GP_TRY(gp_sources_make(log, &frame, n, &light));
    for (size_t i = 0; i < n; i++) {
        const float rgb[3] = {fabsf(r->d.c[0][i]), fabsf(r->d.c[1][i]),
                              fabsf(r->d.c[2][i])};
        if (!(gp_maxf(gp_maxf(rgb[0], rgb[1]), rgb[2]) >= FLT_MIN))
            continue;
        gp_sources_add(&light, (int) (i % (size_t) w), (int) (i / (size_t) w),
                       rgb);
        for (int c = 0; c < 3; c++)
            light.rgb[c][light.n - 1] = r->d.c[c][i];
    }
    gp_sources_finish(&light);
    if (light.n)
        GP_TRY(gp_engine_fft.run(&req, &state));
    else
        gp_planes_clear(layer, 0, n);
out:
    gp_engine_fft.close(&state);
    gp_sources_free(&light);
    return st;
}

/* Bounds the norm of the kernel spread over the residue, in the frame. */
static gp_status find_grouping(const struct gp_log *log,
                               const struct residue *r,
                               const struct gp_sources *src,
                               const struct gp_kernel *kernel,
                               const struct gp_blur *drawn, double norm[3])
{
    gp_status st = GP_OK;
    struct gp_kernel k = *kernel;
    struct gp_planes layer = {0};
    const size_t w = (size_t) r->w + 2 * (size_t) r->pad;
    k.k = drawn->k;
    k.far = NULL;
    k.serial = 0; // no engine keeps what it makes of it
    k.negative = true; // as its light is: nothing is made black
    GP_TRY(spread(log, r, src, &k, &layer));
    for (int c = 0; c < 3; c++) {
        double sum = 0.0;
        for (int y = r->pad; y < r->h + r->pad; y++) {
            for (size_t i = (size_t) y * w + (size_t) r->pad;
                 i < (size_t) (y + 1) * w - (size_t) r->pad; i++)
                sum += (double) layer.c[c][i] * (double) layer.c[c][i];
        }
        norm[c] = sqrt(sum);
    }
out:
    gp_planes_free(&layer);
    return st;
}

/* -- all that is left out -------------------------------------------------- */

/* Sum of squares of a polygon's weights on one axis. */
static double spread_square(const struct gp_polygon *p, float at)
{
    const int box = gp_blur_box[p->blur];
    const struct footprint f = make_footprint(at, box);
    return f.first * f.first + (box - 1) * f.middle * f.middle +
           f.last * f.last;
}

static gp_status find_left_out(const struct gp_log *log,
    const struct gp_rings *r, const struct gp_polygons *polygons,
    const struct gp_shrink *shrink, double norm[3])
{
    const size_t n = (size_t) r->n;
    double *left; // by the first ring that polygons leave out: n of their
                  // light, n of the squares of its norm
    gp_status st = gp_alloc(log, "bound", 2 * n, sizeof *left, &left);
    if (st)
        return st;
    for (int c = 0; c < 3; c++) {
        norm[c] = 0.0;
        for (int size = 0; size < 2; size++) { // clusters, groups
            memset(left, 0, 2 * n * sizeof *left);
            const size_t end = size ? polygons->n : polygons->clusters;
            for (size_t i = size ? polygons->clusters : 0; i < end; i++) {
                const struct gp_polygon *const p = &polygons->at[i];
                const int reach = shrink->reach[gp_source_bin(p->light)];
                // half a box and a pixel between pixels carry light that far
                const int ring = gp_max(reach - gp_blur_box[p->blur] / 2, 0);
                const double light = (double) p->rgb[c];
                if (ring >= r->n)
                    continue;
                left[ring] += light;
                left[n + (size_t) ring] += light * light *
                                           spread_square(p, p->x) *
                                           spread_square(p, p->y);
            }
            double square = 0.0;
            for (size_t i = 0; i < n; i++) {
                square += left[n + i]; // all that leave ring i out
                norm[c] += (r->beyond[c][i] - r->beyond[c][i + 1]) * SHARED *
                           sqrt(square);
            }
        }
    }
    gp_free(left);
    return GP_OK;
}

/* Sum of |dk/dx| + |dk/dy|, differences to the next sample. */
static double find_slope(const struct gp_blur *k, struct gp_rect crop, int c)
{
    double sum = 0.0;
    for (int y = crop.y0 - 1; !gp_rect_empty(crop) && y < crop.y1; y++) {
        for (int x = crop.x0 - 1; x < crop.x1; x++) {
            const float s = gp_planes_at(&k->k, c, k->w, k->h, x, y);
            const float right = gp_planes_at(&k->k, c, k->w, k->h, x + 1, y);
            const float below = gp_planes_at(&k->k, c, k->w, k->h, x, y + 1);
            sum += fabs((double) right - (double) s) +
                   fabs((double) below - (double) s);
        }
    }
    return sum;
}

static void find_sampled(const struct gp_blur *k, struct gp_rect crop,
    const struct gp_polygons *polygons, double place, double norm[3])
{
    double slope = 0.0;
    for (int c = 0; c < 3; c++) {
        double square[2][2] = {{0}}; // clusters, groups; blurred ones
        for (size_t i = 0; i < polygons->n; i++) {
            const struct gp_polygon *const p = &polygons->at[i];
            const int m = gp_blur_box[p->blur];
            if (m == 1 && p->x == floorf(p->x) && p->y == floorf(p->y))
                continue; // fetched, not sampled
            // a slope is the box's of whole pixels on its axis
            const double v = (double) p->rgb[c] / m;
            square[i >= polygons->clusters][m > 1] += v * v;
        }
        // one that is not blurred is within its own cell
        slope = c > 0 && k->grey ? slope : find_slope(k, crop, c);
        norm[c] = place * slope *
                  (sqrt(square[0][0]) + sqrt(square[1][0]) +
                   SHARED * (sqrt(square[0][1]) + sqrt(square[1][1])));
    }
}

/* -- the sum of all parts -------------------------------------------------- */

gp_status gp_group_bound(const struct gp_log *log, const struct gp_sources *src,
    const struct gp_kernel *kernel, const struct gp_splat_params *p,
    const struct gp_polygons *polygons, const struct gp_shrink *shrink,
    double roundings, double *out)
{
    gp_status st;
    struct residue residue = {0};
    struct gp_rings rings = {0};
    struct gp_blur drawn = {0};
    double wrong[3] = {0}, norm[3], least;
    const bool hollow = !gp_splat_single(p);
    int side = 1;
    *out = INFINITY;
    if (kernel->negative)
        return GP_OK;
    for (size_t i = 0; i < polygons->n; i++)
        side = gp_max(side, polygons->at[i].side);
    const struct gp_rect crop =
        gp_kernel_around(kernel, src->w + side, src->h + side);
    GP_TRY(gp_layer_least(log, src, kernel, &least));
    if (side > 1) {
        GP_TRY(gp_blur_make(log, kernel,
                            (struct gp_rect) {0, 0, kernel->w, kernel->h},
                            hollow, 1, &drawn));
        GP_TRY(make_residue(log, src, polygons, side + 1, &residue));
        GP_TRY(find_grouping(log, &residue, src, kernel, &drawn, norm));
        for (int c = 0; c < 3; c++)
            wrong[c] += norm[c];
        // float coordinates of the frame are 2^(exponent - 24) pixels apart,
        // and a sample may be taken so far from its place
        int exponent;
        frexp((double) gp_max(src->w, src->h), &exponent);
        find_sampled(&drawn, crop, polygons, ldexp(1.0, exponent - 24), norm);
        for (int c = 0; c < 3; c++)
            wrong[c] += norm[c];
    }
    if (shrink->left_out > 0.0) {
        GP_TRY(gp_rings_make(log, kernel, crop, hollow, &rings));
        GP_TRY(find_left_out(log, &rings, polygons, shrink, norm));
        for (int c = 0; c < 3; c++)
            wrong[c] += norm[c];
    }
    const double all = sqrt(wrong[0] * wrong[0] + wrong[1] * wrong[1] +
                            wrong[2] * wrong[2]);
    // each rounding is relative to the drawn layer: the exact one and its error
    const double share = (roundings + OWN_ROUNDINGS) * 0x1p-24;
    if (all == 0.0)
        *out = share;
    else if (least > 0.0)
        *out = all / least * (1.0 + share) + share;
out:
    gp_planes_free(&residue.d);
    gp_planes_free(&drawn.k);
    gp_free(rings.beyond[0]);
    return st;
}
