// SPDX-License-Identifier: Apache-2.0
/* Splat, the glare stage on GL: Ando et al., "Real-time rendering of high
 * quality glare images using vertex texture fetch on GPU" (2007).
 *
 * Each pixel of the frame is a sensor. Bright ones are grouped and
 * clustered into polygons that carry the kernel (polygons.h), blurred by as
 * much as the group is wide, cut to where it counts.
 *
 * One polygon a source, on whole pixels and not cut, is the exact sum up to
 * float rounding. */
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/direct/direct.h"
#include "glare/splat/splat_priv.h"

#include <math.h>
#include <string.h>

enum {
    CHUNK_MIN = 64, // polygons; adding up costs as much as two
    MIDDLE_SIDE = 2 * GP_MIDDLE_RADIUS + 1,
    SMOOTH_ROUNDINGS = 9,  // of a bilinear sample
    QUAD_PIXELS = 1 << 25, // of a target that quads are blended in: 512 MiB
};

/* Returns the part of the kernel, in its pixels, that can reach one pixel of a
 * w x h frame from another when blurred by boxes of sides up to `side`. Empty
 * where --kernel-center is far away. */
static struct gp_rect crop_of(const struct gp_kernel *k, int w, int h, int side)
{
    const int more = side > 1 ? side / 2 + 1 : 0; // half a box, and bilinear
    return gp_kernel_around(k, w + more - 1, h + more - 1);
}

/* -- the layout's bound ---------------------------------------------------- */

/* Float roundings that a pixel may take, each 2^-24 of what is summed so far.
 * In a blended layer each may be up to 2^-23, as GL leaves the direction to
 * the driver: so two of 2^-24. One product, the sums in a chunk, whose first is
 * exact, and one for each chunk, of which two may be short. The form is known
 * only with a context, so this is the worse of both. */
static double roundings(const struct gp_splat_layout *p)
{
    const double n = (double) p->polygons.n, chunk = (double) p->chunk;
    double sums = n <= chunk ? n : chunk + n / chunk + 1.0;
    if (!p->single) // a cell's light, row by row
        sums += SMOOTH_ROUNDINGS +
                2.0 * gp_max(p->params.cluster, p->params.group);
    if (!p->single)
        sums += MIDDLE_SIDE * MIDDLE_SIDE;
    // by tiles, direct sums a middle in groups of 32 and adds it to the layer
    const double tiled =
        gp_tiles_roundings(&p->polygons) + (!p->single ? 36.0 : 0.0);
    return fmax(2.0 * (1.0 + sums), tiled);
}

/* -- the layout's area ----------------------------------------------------- */

/* Pixels from low to high, ends included, that lie in [0, limit). */
static double overlap(double low, double high, int limit)
{
    const double n = fmin(high, limit - 1) - fmax(low, 0.0) + 1.0;
    return n > 0.0 ? n : 0.0;
}

static double count_pixels(const struct gp_glare_request *req,
                           const struct gp_splat_layout *p)
{
    const struct gp_sources *const s = req->src;
    const struct gp_kernel *const k = req->kernel;
    double pixels = !p->single ? gp_direct_work(s, MIDDLE_SIDE, MIDDLE_SIDE,
                                                GP_MIDDLE_RADIUS,
                                                GP_MIDDLE_RADIUS, INFINITY)
                               : 0.0;
    for (size_t i = 0; p->outer && i < p->polygons.n; i++) {
        const struct gp_polygon *const q = &p->polygons.at[i];
        const double reach = p->shrink.reach[gp_source_bin(q->light)];
        const double half = 0.5 * (gp_blur_box[q->blur] - 1);
        const double left = fmin(k->cx - p->crop.x0 + half, reach);
        const double right = fmin(p->crop.x1 - 1 - k->cx + half, reach);
        const double up = fmin(k->cy - p->crop.y0 + half, reach);
        const double down = fmin(p->crop.y1 - 1 - k->cy + half, reach);
        const double x = (double) q->x, y = (double) q->y;
        pixels += overlap(floor(x - left), ceil(x + right), s->w) *
                  overlap(floor(y - up), ceil(y + down), s->h);
    }
    return pixels;
}

/* -- the layout ------------------------------------------------------------ */

/* Makes the layout of a request; src->n is over 0. The caller frees its polygons, on failure
 * too. Errors: GP_ERR_BUG out of memory. */
static gp_status make_layout(const struct gp_glare_request *req,
                             struct gp_splat_layout *out)
{
    gp_status st;
    const struct gp_kernel *const k = req->kernel;
    struct gp_splat_layout o = {.params = req->params->splat};
    o.single = gp_splat_single(&o.params);
    o.crop = crop_of(k, req->src->w, req->src->h,
                     gp_max(o.params.cluster, o.params.group));
    const long long cx = k->cx, cy = k->cy, r = GP_MIDDLE_RADIUS;
    o.outer = o.single || o.crop.x0 < cx - r || o.crop.x1 - 1 > cx + r ||
              o.crop.y0 < cy - r || o.crop.y1 - 1 > cy + r;
    GP_TRY(gp_polygons_make(req->log, req->src, &o.params, &o.polygons));
    const size_t root = (size_t) sqrt((double) o.polygons.n) + 1;
    o.chunk = root > CHUNK_MIN ? root : CHUNK_MIN;
    GP_TRY(gp_shrink_make(req->log, k, &o.params, &o.polygons, &o.shrink));
    if (!o.single || o.params.shrink > 0.0f) {
        GP_TRY(gp_group_bound(req->log, req->src, k, &o.params, &o.polygons,
                              &o.shrink, roundings(&o), &o.bound));
    } else {
        // exact but for rounding. Negative samples may cancel while the
        // roundings stay: nothing is guaranteed then. (Light under 1e-38
        // counts as none.)
        const double e = roundings(&o) * 0x1p-24;
        o.bound = k->negative || e >= 1.0 ? INFINITY : e / (1.0 - e);
    }
    o.polygon_pixels = count_pixels(req, &o);
out:
    *out = o;
    return st;
}

/* -- the state ------------------------------------------------------------- */

static void close_context(struct gp_splat *s)
{
    struct gp_program *const programs[] = {
        &s->quad[0], &s->quad[1], &s->tile[0], &s->tile[1], &s->tile[2],
        &s->tile[3], &s->group, &s->add,
    };
    struct gp_target *const targets[] = {&s->total, &s->chunk, &s->groups,
                                         &s->clusters, &s->field};
    if (!s->gl)
        return;
    for (size_t i = 0; i < sizeof programs / sizeof *programs; i++)
        gp_program_free(s->gl, programs[i]);
    for (size_t i = 0; i < sizeof targets / sizeof *targets; i++)
        gp_target_free(s->gl, targets[i]);
    gp_texture_free(s->gl, &s->sources);
    gp_buffer_free(s->gl, &s->reaches);
    gp_buffer_free(s->gl, &s->entries);
    gp_splat_drop_kernels(s);
    gp_gl_close(&s->gl);
}

static void close_splat(void **state)
{
    close_context(*state);
    GP_FREE(*state);
}

gp_status gp_splat_open(const struct gp_log *log, void **state,
                        enum gp_gl_api api)
{
    gp_status st = GP_OK;
    if (!*state)
        GP_TRY(gp_alloc_zero(log, "splat", 1, sizeof(struct gp_splat), state));
    struct gp_splat *const s = *state;
    if (s->api != api)
        close_context(s);
    s->api = api;
    st = s->gl ? gp_gl_use(log, s->gl) : gp_gl_open(log, api, &s->gl);
out:
    return st;
}

/* -- the engine ------------------------------------------------------------ */

static gp_status run_splat(const struct gp_glare_request *req, void **state)
{
    static const char *const forms[] = {
        [GP_PRIMITIVE_QUAD] = "blended quads",
        [GP_PRIMITIVE_TILE] = "tiles, groups from the CPU",
    };
    const size_t pixels = (size_t) req->src->w * (size_t) req->src->h;
    if (gp_rect_empty(crop_of(req->kernel, req->src->w, req->src->h, 1))) {
        gp_planes_clear(req->layer, 0, pixels);
        return GP_OK;
    }
    gp_status st;
    const struct gp_kernel *const k = req->kernel;
    struct gp_taps taps = {0};
    struct gp_splat_layout layout = {0};
    const struct gp_splat_layout *const p = &layout;
    GP_TRY(gp_splat_open(req->log, state, req->params->gl));
    struct gp_splat *const s = *state;
    GP_TRY(make_layout(req, &layout));
    if (!k->serial || k->serial != s->serial || s->hollow == p->single ||
        memcmp(&s->crop, &p->crop, sizeof s->crop) != 0)
        gp_splat_drop_kernels(s);
    s->serial = k->serial;
    s->crop = p->crop;
    s->hollow = !p->single;
    const struct gp_gl_info *const gl = gp_gl_info(s->gl);
    enum gp_primitive form = p->params.primitive;
    if (form == GP_PRIMITIVE_AUTO)
        form = gl->software ? GP_PRIMITIVE_TILE : GP_PRIMITIVE_QUAD;
    if (pixels > QUAD_PIXELS || gp_max(req->src->w, req->src->h) > gl->max_size)
        form = GP_PRIMITIVE_TILE; // no target holds the layer
    if (form == GP_PRIMITIVE_QUAD)
        GP_TRY(gp_splat_draw(req, s, p));
    else if (p->outer)
        GP_TRY(gp_tiles_draw(req, s, p));
    else
        gp_planes_clear(req->layer, 0, pixels);
    if (form == GP_PRIMITIVE_TILE && !p->single) {
        // the middle of each single source goes by direct: a software context
        // has no faster place, and blending squares of 17 pixels is what it
        // does worst
        GP_TRY(gp_taps_cut(req->log, k, GP_MIDDLE_RADIUS, GP_MIDDLE_RADIUS,
                           &taps));
        GP_TRY(gp_direct_sum(req->log, req->src, &taps, true, req->layer));
    }
    struct glarepp_layer_facts *const stats = req->stats;
    if (p->outer) {
        stats->groups = (long long) p->polygons.groups;
        stats->clusters = (long long) p->polygons.clusters;
        stats->polygons = (long long) p->polygons.n;
    }
    stats->cores = !p->single ? (long long) req->src->n : 0;
    stats->polygon_pixels = p->polygon_pixels;
    stats->form = forms[form];
    stats->bound = p->bound;
    stats->gl = gl->name;
out:
    gp_free(layout.polygons.at);
    gp_free(taps.k[0]);
    return st;
}

const struct gp_engine gp_engine_splat = {
    .name = "splat",
    .text = "glare polygons for bright pixels and groups of them, on GL",
    .run = run_splat,
    .close = close_splat,
};
