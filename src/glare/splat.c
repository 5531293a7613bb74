/* Splat, the glare stage on GL: Ando et al., "Real-time rendering of high
 * quality glare images using vertex texture fetch on GPU" (2007), section 3.
 *
 * Each pixel of the sources' box is a sensor, a degenerate quad. The vertex
 * shader fetches the sensor's light; a bright one opens to the kernel's size
 * and is blended into a float target. Quads lie on whole pixels, so the layer
 * is the exact sum up to float rounding.
 *
 * Frames larger than a target are drawn tile by tile, and the sensors that
 * reach a tile block by block.
 *
 * Blending adds in float, one source after another, and a sum of n equal
 * terms may drift by n / 2 roundings. So sqrt(n) sources at a time are summed
 * in a target of their own, which is then added to the total: about
 * 2 * sqrt(n) roundings in place of n.
 */
#include "glare/splat_state.h"

#include <math.h>
#include <string.h>

enum {
    QUADS = 64,       // of one instance, which costs llvmpipe 0.2 us
    QUAD_VERTICES = 6,
    TILE_MAX = 4096,  // 256 MiB a target; Mesa stops at 2 GiB a texture
    CHUNK_MIN = 64,   // sources; adding up costs as much as 2 polygons
};

/* Milliseconds, measured with `test_splat --time` on two cores of a 2.5 GHz
 * Xeon, Mesa 22.3 llvmpipe. They do not ask how many threads there are: then
 * `auto` would choose by it, and the bytes would differ. On a GPU all but the
 * first are far smaller, but which GPU there is shows only in a context. */
static const double START_MS = 90.0;     // libraries, context, link, JIT
static const double SENSOR_MS = 1.35e-4; // a quad that stays shut
static const double POLYGON_MS = 2e-3;   // a quad that opens, whatever size
static const double PIXEL_MS = 6.5e-6;   // a blended pixel
static const double TRANSFER_MS = 7e-6;  // a pixel up, cleared and back

/* The part of the kernel that can touch the frame: its samples are crop, and
 * its centre is (cx, cy) from crop's corner. */
struct reach {
    struct gp_rect crop;
    int cx, cy;
};

struct work {
    const struct gp_glare_job *job;
    struct gp_splat *s;
    struct reach reach;
    size_t chunk_size;    // sources summed at a time
    int side;             // of the largest tile and block
    struct gp_rect tile;  // of the frame
    struct gp_rect block; // of sensors, in frame pixels
};

/* -- counting -------------------------------------------------------------- */

static int clamp_int(long long v, int low, int high)
{
    return v < low ? low : v > high ? high : (int) v;
}

/* Samples further than a frame's width from the centre reach no pixel. */
static struct reach find_reach(const struct gp_kernel *k, int w, int h)
{
    long long cx = k->cx, cy = k->cy; // --kernel-center may be far away
    struct gp_rect crop = {
        clamp_int(cx - w + 1, 0, k->w), clamp_int(cy - h + 1, 0, k->h),
        clamp_int(cx + w, 0, k->w), clamp_int(cy + h, 0, k->h),
    };
    struct reach r = {.crop = crop};
    if (!gp_rect_empty(crop)) {
        r.cx = (int) (cx - crop.x0);
        r.cy = (int) (cy - crop.y0);
    }
    return r;
}

/* Pixels of [at, at + size) that lie in [0, limit). */
static int overlap(int at, int size, int limit)
{
    int low = at > 0 ? at : 0;
    int high = at + size < limit ? at + size : limit;
    return high > low ? high - low : 0;
}

static double polygon_pixels(const struct gp_sources *src, struct reach r)
{
    double pixels = 0.0;
    for (int y = src->box.y0; y < src->box.y1; y++) {
        long long columns = 0;
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
            columns += overlap(src->x[i] - r.cx, gp_rect_w(r.crop), src->w);
        pixels += (double) columns *
                  overlap(y - r.cy, gp_rect_h(r.crop), src->h);
    }
    return pixels;
}

static size_t chunk_size(size_t sources)
{
    size_t root = (size_t) sqrt((double) sources) + 1;
    return root > CHUNK_MIN ? root : CHUNK_MIN;
}

/* Roundings a pixel may take, each at most 2^-23 of what is summed so far, as
 * GL leaves the direction to the driver: one product, the sums in a chunk,
 * and one for each chunk, which every block may leave unfilled. With negative
 * samples the sum may cancel while the roundings stay: nothing is guaranteed
 * then. (Light under 1e-38 counts as none.) */
static double error_bound(size_t sources, double blocks, bool negative)
{
    double n = (double) sources, chunk = (double) chunk_size(sources);
    double sums = n <= chunk ? n : chunk + n / chunk + blocks;
    double e = (1.0 + sums) * 0x1p-23;
    return negative || e >= 1.0 ? INFINITY : e / (1.0 - e);
}

static double predict_ms(const struct gp_glare_job *job)
{
    const struct gp_sources *src = job->src;
    struct reach r = find_reach(job->kernel, src->w, src->h);
    if (src->n == 0 || gp_rect_empty(r.crop))
        return 0.0;
    double sensors = (double) gp_rect_w(src->box) * gp_rect_h(src->box);
    return START_MS + SENSOR_MS * sensors + POLYGON_MS * (double) src->n +
           PIXEL_MS * polygon_pixels(src, r) +
           TRANSFER_MS * src->w * src->h;
}

/* -- sensors --------------------------------------------------------------- */

/* The sources of frame row y that lie in the block: [*from, return). */
static uint32_t block_row(const struct work *k, int y, uint32_t *from)
{
    const struct gp_sources *src = k->job->src;
    uint32_t i = src->row[y], end = src->row[y + 1];
    while (i < end && src->x[i] < k->block.x0)
        i++;
    while (end > i && src->x[end - 1] >= k->block.x1)
        end--;
    *from = i;
    return end;
}

static void fill_band(const struct work *k, int y0, int y1)
{
    const struct gp_sources *src = k->job->src;
    size_t w = (size_t) gp_rect_w(k->block);
    memset(k->s->band, 0, (size_t) (y1 - y0) * w * 4 * sizeof(float));
    for (int y = y0; y < y1; y++) {
        uint32_t i, end = block_row(k, y, &i);
        for (; i < end; i++) {
            float *texel = k->s->band +
                           4 * ((size_t) (y - y0) * w +
                                (size_t) (src->x[i] - k->block.x0));
            for (int c = 0; c < 3; c++)
                texel[c] = src->rgb[c][i];
            texel[3] = fmaxf(texel[0], fmaxf(texel[1], texel[2]));
        }
    }
}

static gp_status upload_block(const struct work *k)
{
    struct gp_splat *s = k->s;
    int w = gp_rect_w(k->block), h = gp_rect_h(k->block);
    gp_status st = gp_splat_fit_sources(k->job->log, s, w, h);
    int rows = GP_SPLAT_BAND_TEXELS / w;
    for (int y0 = 0; !st && y0 < h; y0 += rows) {
        struct gp_rect band = {0, y0, w, y0 + overlap(y0, rows, h)};
        fill_band(k, k->block.y0 + band.y0, k->block.y0 + band.y1);
        gp_texture_write(s->gl, &s->sources, band, s->band);
    }
    return st;
}

/* -- drawing --------------------------------------------------------------- */

/* Draws sensors [first, end) of the block, counted in row order. */
static gp_status draw_sensors(const struct work *k,
                              const struct gp_target *to, int first, int end)
{
    const struct gp_splat *s = k->s;
    const struct gp_uniform uniform[] = {
        {.name = "sources", .texture = &s->sources},
        {.name = "kernel", .texture = &s->kernel},
        {.name = "offset", .v = {k->block.x0 - k->reach.cx - k->tile.x0,
                                 k->block.y0 - k->reach.cy - k->tile.y0}},
        {.name = "block", .v = {gp_rect_w(k->block), gp_rect_h(k->block)}},
        {.name = "range", .v = {first, end}},
        {.name = "target", .v = {to->colour.w, to->colour.h}},
        {0},
    };
    const struct gp_draw draw = {
        .program = &s->splat,
        .target = to,
        .cut = {0, 0, gp_rect_w(k->tile), gp_rect_h(k->tile)},
        .uniform = uniform,
        .vertices = QUADS * QUAD_VERTICES,
        .instances = (end - first + QUADS - 1) / QUADS,
    };
    return gp_draw_add(k->job->log, s->gl, &draw);
}

/* Adds what the chunk target holds on rows [y0, y1) of sources, with the
 * kernel's reach, to the total. */
static gp_status draw_chunk(const struct work *k, int first, int end, int y0,
                            int y1)
{
    struct gp_splat *s = k->s;
    int top = y0 - k->reach.cy - k->tile.y0;
    struct gp_rect rows = {
        0, top, gp_rect_w(k->tile),
        top + y1 - 1 - y0 + gp_rect_h(k->reach.crop),
    };
    const struct gp_uniform uniform[] = {
        {.name = "addend", .texture = &s->chunk.colour}, {0},
    };
    const struct gp_draw draw = {
        .program = &s->add, .target = &s->total, .cut = rows,
        .uniform = uniform, .vertices = 3, .instances = 1,
    };
    gp_target_clear(s->gl, &s->chunk, rows);
    gp_status st = draw_sensors(k, &s->chunk, first, end);
    return st ? st : gp_draw_add(k->job->log, s->gl, &draw);
}

/* Draws the block's sensors, chunk_size() bright ones at a time. */
static gp_status draw_block(const struct work *k)
{
    int w = gp_rect_w(k->block), first = 0, first_row = k->block.y0;
    size_t bright = 0;
    gp_status st = upload_block(k);
    if (!st && k->job->src->n <= k->chunk_size)
        return draw_sensors(k, &k->s->total, 0, w * gp_rect_h(k->block));
    for (int y = k->block.y0; !st && y < k->block.y1; y++) {
        uint32_t i, end = block_row(k, y, &i);
        for (; !st && i < end; i++) {
            if (++bright % k->chunk_size != 0)
                continue;
            int next = (y - k->block.y0) * w + k->job->src->x[i] -
                       k->block.x0 + 1;
            st = draw_chunk(k, first, next, first_row, y + 1);
            first = next;
            first_row = y;
        }
    }
    if (!st && bright % k->chunk_size != 0)
        st = draw_chunk(k, first, w * gp_rect_h(k->block), first_row,
                        k->block.y1);
    return st;
}

/* -- tiles ----------------------------------------------------------------- */

static void read_tile(const struct work *k)
{
    const struct gp_splat *s = k->s;
    int w = gp_rect_w(k->tile), h = gp_rect_h(k->tile);
    int rows = GP_SPLAT_BAND_TEXELS / w;
    for (int y0 = 0; y0 < h; y0 += rows) {
        struct gp_rect band = {0, y0, w, y0 + overlap(y0, rows, h)};
        gp_target_read(s->gl, &s->total, band, s->band);
        for (int y = band.y0; y < band.y1; y++) {
            size_t to = (size_t) (k->tile.y0 + y) * (size_t) k->job->src->w +
                        (size_t) k->tile.x0;
            const float *from = s->band +
                                4 * (size_t) (y - y0) * (size_t) w;
            for (int c = 0; c < 3; c++) {
                for (int x = 0; x < w; x++)
                    k->job->layer->c[c][to + (size_t) x] = from[4 * x + c];
            }
        }
    }
}

/* The sensors whose open quads meet the tile. */
static struct gp_rect sensors_near(const struct work *k)
{
    struct gp_rect t = k->tile;
    struct gp_rect near = {
        t.x0 + k->reach.cx - gp_rect_w(k->reach.crop) + 1,
        t.y0 + k->reach.cy - gp_rect_h(k->reach.crop) + 1,
        t.x1 + k->reach.cx, t.y1 + k->reach.cy,
    };
    return gp_rect_meet(near, k->job->src->box);
}

static gp_status draw_tile(struct work *k)
{
    struct gp_rect near = sensors_near(k);
    gp_status st = GP_OK;
    gp_target_clear(k->s->gl, &k->s->total,
                    (struct gp_rect) {0, 0, k->side, k->side});
    for (int y = near.y0; !st && y < near.y1; y += k->side) {
        for (int x = near.x0; !st && x < near.x1; x += k->side) {
            k->block = gp_rect_meet(near, (struct gp_rect) {
                x, y, x + k->side, y + k->side});
            st = draw_block(k);
        }
    }
    if (st)
        return st;
    read_tile(k);
    return gp_gl_check(k->job->log, k->s->gl, "drawing glare polygons");
}

static int parts(int size, int side)
{
    return (size + side - 1) / side;
}

/* Tiles of nearly one size, so that the last is not mostly empty. */
static gp_status draw_tiles(struct work *k)
{
    int w = k->job->src->w, h = k->job->src->h;
    int tile_w = parts(w, parts(w, k->side));
    int tile_h = parts(h, parts(h, k->side));
    gp_status st = gp_splat_fit_targets(k->job->log, k->s, tile_w, tile_h,
                                        k->job->src->n > k->chunk_size);
    for (int y = 0; !st && y < h; y += tile_h) {
        for (int x = 0; !st && x < w; x += tile_w) {
            k->tile = (struct gp_rect) {x, y, x + overlap(x, tile_w, w),
                                        y + overlap(y, tile_h, h)};
            st = draw_tile(k);
        }
    }
    return st;
}

/* -- the engine ------------------------------------------------------------ */

static void publish(const struct work *k, struct gp_glare_stats *stats)
{
    const struct gp_sources *src = k->job->src;
    double blocks =
        (1.0 + parts(gp_rect_w(k->reach.crop), k->side)) *
        (1.0 + parts(gp_rect_h(k->reach.crop), k->side));
    stats->polygons = src->n;
    stats->polygon_pixels = polygon_pixels(src, k->reach);
    stats->bound = error_bound(src->n, blocks, k->s->negative);
    stats->gl = gp_gl_name(k->s->gl);
}

static gp_status run(const struct gp_glare_job *job, void **state)
{
    const struct gp_sources *src = job->src;
    struct work k = {
        .job = job,
        .reach = find_reach(job->kernel, src->w, src->h),
        .chunk_size = chunk_size(src->n),
    };
    if (src->n == 0 || gp_rect_empty(k.reach.crop)) {
        for (int c = 0; c < 3; c++)
            memset(job->layer->c[c], 0,
                   (size_t) src->w * (size_t) src->h * sizeof(float));
        return GP_OK;
    }
    gp_status st = gp_splat_open(job->log, job->params->gl, state);
    if (st)
        return st;
    k.s = *state;
    k.side = gp_gl_max_size(k.s->gl);
    if (k.side > TILE_MAX)
        k.side = TILE_MAX;
    st = gp_splat_set_kernel(job->log, k.s, job->kernel, k.reach.crop);
    if (!st)
        st = draw_tiles(&k);
    if (!st)
        publish(&k, job->stats);
    return st;
}

const struct gp_engine gp_engine_splat = {
    .name = "splat",
    .text = "one blended quad for each bright pixel, on GL",
    .predict_ms = predict_ms,
    .run = run,
    .close = gp_splat_close,
};
