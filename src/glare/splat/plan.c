#include "glare/splat/plan.h"

#include "glare/direct/direct.h"
#include "glare/splat/tile.h"

#include <math.h>
#include <string.h>

enum {
    CHUNK_MIN = 64,     // polygons; adding up costs as much as two
    FAR = 1 << 20,      // pixels, beyond every frame
    CORE_SIDE = 2 * GP_CORE_RADIUS + 1,
    SMOOTH_ROUNDINGS = 9, // of a bilinear sample
};

/* -- the kernel ------------------------------------------------------------ */

static int clamp_int(long long v, int low, int high)
{
    return v < low ? low : v > high ? high : (int) v;
}

struct gp_rect gp_splat_crop(const struct gp_kernel *k, int w, int h, int side)
{
    const long long cx = k->cx, cy = k->cy;
    const int more = side > 1 ? side / 2 + 1 : 0; // half a box, and bilinear
    return (struct gp_rect) {
        clamp_int(cx - w - more + 1, 0, k->w),
        clamp_int(cy - h - more + 1, 0, k->h),
        clamp_int(cx + w + more, 0, k->w), clamp_int(cy + h + more, 0, k->h),
    };
}

/* True when no sample of the crop is outside of the core. */
static bool within_core(const struct gp_kernel *k, struct gp_rect crop)
{
    const long long r = GP_CORE_RADIUS;
    return crop.x0 >= k->cx - r && crop.x1 - 1 <= k->cx + r &&
           crop.y0 >= k->cy - r && crop.y1 - 1 <= k->cy + r;
}

static bool has_lobes(const struct gp_kernel *k, struct gp_rect crop)
{
    bool negative = false;
    for (int c = 0; c < 3; c++) {
        for (int y = crop.y0; y < crop.y1; y++) {
            const float *const row = k->k.c[c] + (size_t) y * (size_t) k->w;
            for (int x = crop.x0; x < crop.x1; x++)
                negative |= row[x] < 0.0f;
        }
    }
    return negative;
}

/* -- what it was made from --------------------------------------------------*/

static uint64_t mix_word(uint64_t hash, uint64_t word)
{
    hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
    return hash ^ hash >> 29;
}

static uint64_t mix(uint64_t hash, const void *data, size_t bytes)
{
    const unsigned char *const at = data;
    size_t i = 0;
    for (; i + 8 <= bytes; i += 8) {
        uint64_t word;
        memcpy(&word, at + i, 8);
        hash = mix_word(hash, word);
    }
    for (; i < bytes; i++)
        hash = mix_word(hash, at[i]);
    return hash;
}

/* Of all that a plan depends on but the kernel's samples, whose serial is
 * unique; 0 is never the key of a plan. */
static uint64_t key_of(const struct gp_glare_job *job)
{
    const struct gp_sources *const s = job->src;
    const struct gp_splat_params *const p = &job->params->splat;
    const long long whole[] = {
        s->w, s->h, s->x0, s->y0, (long long) s->n, p->group, p->cluster,
        p->method, p->primitive, job->params->gl, (long long) job->kernel->serial,
    };
    const float real[] = {p->cluster_fill, p->shrink, s->luminance[0],
                          s->luminance[1], s->luminance[2]};
    uint64_t key = mix(1, whole, sizeof whole);
    key = mix(key, real, sizeof real);
    key = mix(key, s->row, ((size_t) s->h + 1) * sizeof *s->row);
    key = mix(key, s->x, s->n * sizeof *s->x);
    for (int c = 0; c < 3; c++)
        key = mix(key, s->rgb[c], s->n * sizeof(float));
    return key ? key : 1;
}

/* -- rounding -------------------------------------------------------------- */

size_t gp_splat_chunk(size_t polygons)
{
    const size_t root = (size_t) sqrt((double) polygons) + 1;
    return root > CHUNK_MIN ? root : CHUNK_MIN;
}

/* Float roundings that a pixel of a blended layer may take, each up to 2^-23
 * of what is summed so far, as GL leaves the direction to the driver: so two
 * of 2^-24. One product, the sums in a chunk, and one for each chunk. */
static double blended_roundings(const struct gp_splat_plan *p)
{
    const double n = (double) p->polygons.n;
    const double chunk = (double) gp_splat_chunk(p->polygons.n);
    double sums = n <= chunk ? n : chunk + n / chunk + 1.0;
    if (p->turned)
        sums += SMOOTH_ROUNDINGS;
    if (!p->single) {
        const int side = p->params.cluster > p->params.group
                             ? p->params.cluster : p->params.group;
        sums += SMOOTH_ROUNDINGS + 2.0 * side; // a cell's light, row by row
    }
    if (p->core)
        sums += CORE_SIDE * CORE_SIDE;
    return 2.0 * (1.0 + sums);
}

static double tile_roundings(const struct gp_splat_plan *p)
{
    // a core goes by direct, in groups of 32, and is added to the rest
    return gp_tiles_roundings(&p->polygons) + (p->core ? 36.0 : 0.0);
}

/* The form is known only with a context, so AUTO takes the worse of both. */
static double roundings(const struct gp_splat_plan *p)
{
    const double blended = blended_roundings(p), tiled = tile_roundings(p);
    switch (p->params.primitive) {
    case GP_PRIMITIVE_TILE:
        return tiled;
    case GP_PRIMITIVE_QUAD:
    case GP_PRIMITIVE_POINT:
        return blended;
    case GP_PRIMITIVE_AUTO:
        break;
    }
    return fmax(blended, tiled);
}

/* Of a layer that is exact but for rounding. Negative samples may cancel while
 * the roundings stay: nothing is guaranteed then. (Light under 1e-38 counts
 * as none.) */
static double exact_bound(const struct gp_glare_job *job,
                          const struct gp_splat_plan *p)
{
    const double e = roundings(p) * 0x1p-24;
    return has_lobes(job->kernel, p->crop) || e >= 1.0 ? INFINITY
                                                       : e / (1.0 - e);
}

static double norm_of(const struct gp_unturned *u, int c)
{
    double sum = 0.0;
    for (size_t i = 0; i < (size_t) u->w * (size_t) u->h; i++)
        sum += (double) u->k.c[c][i] * (double) u->k.c[c][i];
    return sqrt(sum);
}

/* What a turned quad adds: where it samples, rounding is `place` pixels at
 * most (splat_turn.frag). Each sample is then wrong by at most 2 * place of its
 * four taps' sum, no more than four samples share their taps, and flux times
 * that error's norm is the most that all sources can make of it (Young's
 * inequality). */
static gp_status add_turning(const struct gp_glare_job *job,
                             struct gp_bound_cache *cache,
                             struct gp_splat_plan *p)
{
    const struct gp_unturned *const u = job->kernel->unturned;
    const double radius = hypot(fabs((double) u->cx) + u->w,
                                fabs((double) u->cy) + u->h);
    const double place = 0x1p-23 + 0x1p-31 * radius;
    double least = 0.0, wrong = 0.0;
    gp_status st = gp_layer_least(job->log, job->src, job->kernel, cache,
                                  &least);
    for (int c = 0; c < 3; c++) {
        const double e = job->src->flux[c] * 2.0 * place * 4.0 * 2.0 *
                         norm_of(u, c);
        wrong += e * e;
    }
    p->bound += least > 0.0 ? sqrt(wrong) / least : INFINITY;
    return st;
}

static gp_status find_bound(const struct gp_glare_job *job,
                            struct gp_bound_cache *cache,
                            struct gp_splat_plan *p)
{
    if (p->single && p->params.shrink <= 0.0f) {
        p->bound = exact_bound(job, p);
        return p->turned ? add_turning(job, cache, p) : GP_OK;
    }
    return gp_group_bound(job->log, job->src, job->kernel, &p->params,
                          &p->polygons, &p->shrink, roundings(p), cache,
                          &p->bound);
}

/* -- counting -------------------------------------------------------------- */

int gp_splat_reach(const struct gp_splat_plan *p, float light)
{
    const int reach = p->shrink.reach[gp_source_bin(light)];
    return reach < FAR ? reach : FAR;
}

/* Pixels from low to high, ends included, that lie in [0, limit). */
static double overlap(double low, double high, int limit)
{
    const double n = fmin(high, limit - 1) - fmax(low, 0.0) + 1.0;
    return n > 0.0 ? n : 0.0;
}

static double polygon_area(const struct gp_glare_job *job,
                           const struct gp_splat_plan *p,
                           const struct gp_polygon *q)
{
    const struct gp_kernel *const k = job->kernel;
    const double reach = gp_splat_reach(p, q->light);
    const double half = 0.5 * (gp_blur_box[q->blur] - 1);
    const double left = fmin(k->cx - p->crop.x0 + half, reach);
    const double right = fmin(p->crop.x1 - 1 - k->cx + half, reach);
    const double up = fmin(k->cy - p->crop.y0 + half, reach);
    const double down = fmin(p->crop.y1 - 1 - k->cy + half, reach);
    const double x = (double) q->x, y = (double) q->y;
    return overlap(floor(x - left), ceil(x + right), job->src->w) *
           overlap(floor(y - up), ceil(y + down), job->src->h);
}

static double core_area(const struct gp_sources *s)
{
    double pixels = 0.0;
    for (int y = s->box.y0; y < s->box.y1; y++) {
        double columns = 0.0;
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++)
            columns += overlap(s->x[i] - GP_CORE_RADIUS,
                               s->x[i] + GP_CORE_RADIUS, s->w);
        pixels += columns * overlap(y - GP_CORE_RADIUS, y + GP_CORE_RADIUS,
                                    s->h);
    }
    return pixels;
}

static double all_pixels(const struct gp_glare_job *job,
                         const struct gp_splat_plan *p)
{
    double pixels = p->core ? core_area(job->src) : 0.0;
    for (size_t i = 0; p->tail && i < p->polygons.n; i++)
        pixels += polygon_area(job, p, &p->polygons.at[i]);
    return pixels;
}

/* -- making ---------------------------------------------------------------- */

void gp_splat_plan_free(struct gp_splat_plan *p)
{
    gp_polygons_free(&p->polygons);
    *p = (struct gp_splat_plan) {0};
}

gp_status gp_splat_plan_make(const struct gp_glare_job *job,
                             struct gp_bound_cache *cache,
                             struct gp_splat_plan *p)
{
    gp_status st;
    const uint64_t key = key_of(job);
    if (p->made && p->key == key && job->kernel->serial)
        return GP_OK;
    gp_splat_plan_free(p);
    struct gp_splat_plan o = {.made = true, .key = key,
                              .params = job->params->splat};
    o.single = o.params.group == 1 && !o.params.cluster;
    if (o.single)
        o.params.method = GP_GROUP_CENTROID; // core and tail are one
    const int side = o.params.cluster > o.params.group ? o.params.cluster
                                                       : o.params.group;
    o.turned = o.single && job->kernel->unturned &&
               (o.params.primitive == GP_PRIMITIVE_QUAD ||
                (o.params.primitive == GP_PRIMITIVE_AUTO &&
                 job->params->gl == GP_GL_EGL)); // a GPU may be there
    o.core = o.params.method == GP_GROUP_CORE;
    o.crop = gp_splat_crop(job->kernel, job->src->w, job->src->h, side);
    o.tail = !o.core || !within_core(job->kernel, o.crop);
    GP_TRY(gp_group(job->log, job->src, &o.params, &o.polygons));
    GP_TRY(gp_shrink_make(job->log, job->kernel, &o.params, &o.polygons,
                          &o.shrink));
    GP_TRY(find_bound(job, cache, &o));
    o.polygon_pixels = all_pixels(job, &o);
    *p = o;
    return GP_OK;
out:
    gp_splat_plan_free(&o);
    return st;
}
