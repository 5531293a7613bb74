/* Frames larger than a target are drawn tile by tile, and the sensors that
 * reach a tile block by block. */
#include "glare/splat/draw.h"

#include "glare/splat/group_gl.h"

#include <math.h>

enum {
    TILE_MAX = 4096,   // 256 MiB a target; Mesa stops at 2 GiB a texture
    TURNED_MAX = 8192, // pixels, times 1/1024, that float holds exactly
};

/* -- tiles ----------------------------------------------------------------- */

static int least(int a, int b)
{
    return a < b ? a : b;
}

static void read_tile(const struct gp_splat_work *k)
{
    const struct gp_splat *const s = k->s;
    const int w = gp_rect_w(k->tile), h = gp_rect_h(k->tile);
    if (w < 1)
        return;
    const int rows = GP_SPLAT_BAND_TEXELS / w;
    for (int y0 = 0; y0 < h; y0 += rows) {
        const struct gp_rect band = {0, y0, w, least(y0 + rows, h)};
        gp_target_read(s->gl, &s->total, 0, band, s->band);
        for (int y = band.y0; y < band.y1; y++) {
            const size_t to = (size_t) (k->tile.y0 + y) *
                                  (size_t) k->job->src->w +
                              (size_t) k->tile.x0;
            const float *const from = s->band +
                                      4 * (size_t) (y - y0) * (size_t) w;
            for (int c = 0; c < 3; c++) {
                for (int x = 0; x < w; x++)
                    k->job->layer->c[c][to + (size_t) x] = from[4 * x + c];
            }
        }
    }
}

/* The pixels whose polygons meet the tile. */
static struct gp_rect pixels_near(const struct gp_splat_work *k)
{
    const struct gp_rect t = k->tile, m = k->meets;
    const struct gp_rect near = {t.x0 - m.x1 - 1, t.y0 - m.y1 - 1,
                                 t.x1 - m.x0 + 1, t.y1 - m.y0 + 1};
    return gp_rect_meet(near, k->job->src->box);
}

static gp_status draw_tile(struct gp_splat_work *k)
{
    const struct gp_rect near = pixels_near(k);
    const struct gp_rect whole = {0, 0, k->tile_side, k->tile_side};
    gp_target_clear(k->s->gl, &k->s->total, whole);
    if (k->plan->polygons.n > k->chunk)
        gp_target_clear(k->s->gl, &k->s->chunk, whole);
    gp_status st = GP_OK;
    if (!gp_rect_empty(near)) {
        const struct gp_cells all = gp_cells_over(k->job->src, near, k->span);
        const int most = k->side / k->span; // cells of a block's side
        for (int y = 0; !st && y < all.h; y += most) {
            for (int x = 0; !st && x < all.w; x += most) {
                const struct gp_cells coarse = {
                    k->span, all.x + x * k->span, all.y + y * k->span,
                    least(most, all.w - x), least(most, all.h - y),
                };
                st = gp_splat_block(k, &coarse);
            }
        }
    }
    if (!st && k->held)
        st = gp_splat_flush(k);
    k->held = 0;
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
static gp_status draw_tiles(struct gp_splat_work *k)
{
    const int w = k->job->src->w, h = k->job->src->h;
    const int tile_w = parts(w, parts(w, k->tile_side));
    const int tile_h = parts(h, parts(h, k->tile_side));
    gp_status st = gp_splat_fit_targets(k->job->log, k->s, tile_w, tile_h,
                                        k->plan->polygons.n > k->chunk);
    for (int y = 0; !st && y < h; y += tile_h) {
        for (int x = 0; !st && x < w; x += tile_w) {
            k->tile = (struct gp_rect) {x, y, least(x + tile_w, w),
                                        least(y + tile_h, h)};
            st = draw_tile(k);
        }
    }
    return st;
}

/* -- the whole ------------------------------------------------------------- */

/* Offsets from a polygon's P0 to pixels that it may touch. */
static struct gp_rect meets_of(const struct gp_kernel *k,
                               const struct gp_splat_plan *p, int span)
{
    const int more = p->single ? 0 : span / 2 + 1; // half a box, and bilinear
    return (struct gp_rect) {
        p->crop.x0 - k->cx - more, p->crop.y0 - k->cy - more,
        p->crop.x1 - k->cx + more, p->crop.y1 - k->cy + more,
    };
}

static unsigned blurs_of(const struct gp_polygon *at, size_t n)
{
    unsigned used = 0;
    for (size_t i = 0; i < n; i++)
        used |= 1u << at[i].blur;
    return used;
}

/* Pixels of the largest sprite: the kernel's longer side, blurred and off
 * whole pixels, or what is left of it by shrinking. */
static int largest_sprite(const struct gp_splat_work *k)
{
    const struct gp_splat_plan *const p = k->plan;
    int largest = p->core ? 2 * GP_CORE_RADIUS + 1 : 1;
    for (size_t i = 0; p->tail && i < p->polygons.n; i++) {
        const struct gp_polygon *const q = &p->polygons.at[i];
        const int w = gp_rect_w(p->crop), h = gp_rect_h(p->crop);
        const int whole = (w > h ? w : h) + gp_blur_box[q->blur] - 1 +
                          !p->single;
        const int sprite = least(whole, 2 * gp_splat_reach(p, q->light) + 1);
        largest = sprite > largest ? sprite : largest;
    }
    return largest;
}

/* Pixels from a source to the farthest corner of its turned quad. */
static int turned_radius(const struct gp_unturned *u)
{
    const double x = fmax(u->cx, u->w - u->cx), y = fmax(u->cy, u->h - u->cy);
    return (int) fmin(hypot(x + 2.0, y + 2.0), 1 << 20) + 1;
}

/* How far the view reaches beyond a tile, so that no polygon that meets the
 * tile is clipped. Quads on whole pixels are cut by the vertex shader; turned
 * ones, whose kernel would need too large a view, are not turned there. */
static void place_view(struct gp_splat_work *k)
{
    const int most = gp_gl_info(k->s->gl)->max_size;
    const int radius = k->plan->turned && !k->points
                           ? turned_radius(k->job->kernel->unturned) : 0;
    k->turned = radius > 0 && radius <= TURNED_MAX &&
                most - 2 * radius >= k->side / 2;
    k->margin = k->points ? k->sprite : k->turned ? radius : 0;
    k->tile_side = least(k->side, most - 2 * k->margin);
}

static gp_status check_limits(const struct gp_splat_work *k)
{
    const float most = gp_gl_info(k->s->gl)->max_point;
    if ((float) k->sprite > most)
        return gp_fail_bare(k->job->log, GP_ERR_GL,
                            "%s: point sprites of %d pixels are needed (%.0f "
                            "is the limit); use --primitive quad or tile, a "
                            "smaller kernel, or more --shrink",
                            gp_gl_info(k->s->gl)->name, k->sprite,
                            (double) most);
    if (k->side / k->span < 1 || k->tile_side < 1)
        return gp_fail_bare(k->job->log, GP_ERR_GL,
                            "%s: polygons of %d pixels, groups of %d, do not "
                            "go into one texture (%d pixels are the limit); "
                            "use --engine fft or direct",
                            gp_gl_info(k->s->gl)->name, k->sprite, k->span,
                            k->side);
    return GP_OK;
}

static gp_status upload_reaches(const struct gp_splat_work *k)
{
    struct gp_splat *const s = k->s;
    float reach[GP_SOURCE_BINS];
    gp_status st = GP_OK;
    if (!s->reaches.id)
        st = gp_uniform_block_make(k->job->log, s->gl, "reaches", sizeof reach,
                           &s->reaches);
    if (st)
        return st;
    for (int i = 0; i < GP_SOURCE_BINS; i++)
        reach[i] = (float) gp_splat_reach(k->plan, gp_source_bin_start(i));
    gp_uniform_block_write(s->gl, &s->reaches, reach, sizeof reach);
    return GP_OK;
}

gp_status gp_splat_draw(const struct gp_glare_job *job, struct gp_splat *s,
                        bool points)
{
    const struct gp_splat_plan *const p = &s->plan;
    struct gp_splat_work k = {
        .job = job, .s = s, .plan = p, .points = points,
        .span = p->params.cluster > p->params.group ? p->params.cluster
                                                    : p->params.group,
        .side = least(gp_gl_info(s->gl)->max_size, TILE_MAX),
        .group_blurs = blurs_of(p->polygons.at + p->polygons.clusters,
                                p->polygons.groups),
        .cluster_blurs = blurs_of(p->polygons.at, p->polygons.clusters),
        .chunk = gp_splat_chunk(p->polygons.n),
    };
    k.meets = meets_of(job->kernel, p, k.span);
    k.sprite = points ? largest_sprite(&k) : 0;
    place_view(&k);
    gp_status st = check_limits(&k);
    if (!st)
        st = upload_reaches(&k);
    if (st)
        return st;
    gp_splat_set_kernel(s, job->kernel, p->crop, p->core, points);
    return draw_tiles(&k);
}
