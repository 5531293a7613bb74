#include "glare/splat/group_gl.h"

#include <string.h>

/* -- cells ----------------------------------------------------------------- */

static long long floor_to(long long v, int step)
{
    const long long part = v % step;
    return part < 0 ? v - part - step : v - part;
}

/* In EXR pixel space a cell starts at each multiple of its side. */
static int first_corner(int at, int origin, int side)
{
    return (int) (floor_to((long long) at + origin, side) - origin);
}

struct gp_cells gp_cells_over(const struct gp_sources *src, struct gp_rect rect,
                              int side)
{
    struct gp_cells c = {
        .side = side,
        .x = first_corner(rect.x0, src->x0, side),
        .y = first_corner(rect.y0, src->y0, side),
    };
    c.w = (rect.x1 - c.x + side - 1) / side;
    c.h = (rect.y1 - c.y + side - 1) / side;
    return c;
}

struct gp_rect gp_cells_rect(const struct gp_cells *c)
{
    return (struct gp_rect) {c->x, c->y, c->x + c->w * c->side,
                             c->y + c->h * c->side};
}

/* -- light ----------------------------------------------------------------- */

/* The sources of frame row y that lie in the rect: [*from, return). */
static uint32_t rect_row(const struct gp_sources *src, struct gp_rect rect,
                         int y, uint32_t *from)
{
    uint32_t i = src->row[y], end = src->row[y + 1];
    while (i < end && src->x[i] < rect.x0)
        i++;
    while (end > i && src->x[end - 1] >= rect.x1)
        end--;
    *from = i;
    return end;
}

static void fill_band(const struct gp_sources *src, struct gp_rect rect,
                      float *band)
{
    const size_t w = (size_t) gp_rect_w(rect);
    memset(band, 0, w * (size_t) gp_rect_h(rect) * 4 * sizeof(float));
    for (int y = rect.y0; y < rect.y1; y++) {
        float *const row = band + 4 * (size_t) (y - rect.y0) * w;
        uint32_t i;
        const uint32_t end = rect_row(src, rect, y, &i);
        for (; i < end; i++) {
            float *const texel = row + 4 * (src->x[i] - rect.x0);
            double light = 0.0;
            for (int c = 0; c < 3; c++) {
                texel[c] = src->rgb[c][i];
                light += (double) src->luminance[c] * (double) texel[c];
            }
            // weights of unreal primaries may be negative
            texel[3] = light > 0.0 ? (float) light : 0.0f;
        }
    }
}

gp_status gp_splat_upload(const struct gp_log *log, struct gp_splat *s,
                          const struct gp_sources *src, struct gp_rect rect)
{
    const int w = gp_rect_w(rect), h = gp_rect_h(rect);
    if (w < 1)
        return GP_OK;
    const int rows = GP_SPLAT_BAND_TEXELS / w;
    gp_status st = gp_splat_fit_sources(log, s, w, h);
    for (int y0 = 0; !st && y0 < h; y0 += rows) {
        const struct gp_rect band = {0, y0, w, h - y0 > rows ? y0 + rows : h};
        const struct gp_rect from = {rect.x0, rect.y0 + band.y0, rect.x1,
                                     rect.y0 + band.y1};
        fill_band(src, from, s->band);
        gp_texture_write(s->gl, &s->sources, band, s->band);
    }
    return st;
}

/* -- groups ---------------------------------------------------------------- */

static gp_status fit_cells(const struct gp_log *log, struct gp_splat *s, int w,
                           int h, struct gp_target *t)
{
    if (t->framebuffer && t->colour.w >= w && t->colour.h >= h)
        return GP_OK;
    w = t->colour.w > w ? t->colour.w : w;
    h = t->colour.h > h ? t->colour.h : h;
    gp_target_free(s->gl, t);
    return gp_target_make(log, s->gl, "groups", GP_TEXEL_FLOAT, 2, w, h, t);
}

gp_status gp_splat_group(const struct gp_log *log, struct gp_splat *s,
                         struct gp_rect rect, const struct gp_cells *c,
                         unsigned boxes, float fill,
                         const struct gp_target *parents, int parent_side,
                         struct gp_target *out)
{
    gp_status st = gp_splat_use(log, s, GP_SPLAT_GROUP);
    if (!st)
        st = fit_cells(log, s, c->w, c->h, out);
    if (st)
        return st;
    const struct gp_uniform uniform[] = {
        {.name = "sources", .texture = &s->sources},
        {.name = "parents", .texture = parents ? &parents->colour
                                               : &s->sources},
        {.name = "origin", .v = {c->x - rect.x0, c->y - rect.y0}},
        {.name = "size", .v = {gp_rect_w(rect), gp_rect_h(rect)}},
        {.name = "side", .v = {c->side, parents ? parent_side / c->side : 0}},
        {.name = "boxes", .v = {(int) boxes, 0}},
        {.name = "fill", .floats = 1, .f = {fill}},
        {0},
    };
    const struct gp_draw draw = {
        .program = &s->program[GP_SPLAT_GROUP], .target = out,
        .cut = {0, 0, c->w, c->h}, .uniform = uniform, .vertices = 3,
        .instances = 1, .replace = true,
    };
    return gp_draw_run(log, s->gl, &draw);
}
