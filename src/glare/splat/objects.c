#include "core/minmax.h"
#include "glare/splat/splat_priv.h"

#include <math.h>
#include <string.h>

gp_status gp_splat_use(const struct gp_log *log, struct gp_splat *s,
                       enum gp_splat_program which)
{
#define FILES(name, vert, frag) {vert, frag},
    static const char *const files[][2] = {GP_SPLAT_PROGRAMS(FILES)};
#undef FILES
    if (s->program[which].id)
        return GP_OK;
    return gp_program_make(log, s->gl, "", files[which][0], files[which][1],
                           &s->program[which]);
}

gp_status gp_splat_fit_target(const struct gp_log *log, const struct gp_gl *gl,
    const char *what, int n, int w, int h, struct gp_target *t)
{
    if (t->framebuffer && t->colour.w >= w && t->colour.h >= h)
        return GP_OK;
    w = gp_max(t->colour.w, w);
    h = gp_max(t->colour.h, h);
    gp_target_free(gl, t);
    return gp_target_make(log, gl, what, GP_TEXEL_FLOAT, n, w, h, t);
}

/* -- kernels --------------------------------------------------------------- */

void gp_splat_drop_kernels(struct gp_splat *s)
{
    for (int i = 0; i < GP_SPLAT_KERNELS; i++) {
        gp_texture_free(s->gl, &s->kernel[i].texture);
        s->kernel[i] = (struct gp_splat_kernel) {0};
    }
}

void gp_splat_set_kernel(struct gp_splat *s, const struct gp_kernel *k,
                         struct gp_rect crop, bool tail, bool bordered)
{
    const bool same = k->serial && k->serial == s->serial &&
                      memcmp(&crop, &s->crop, sizeof crop) == 0 &&
                      tail == s->tail && bordered == s->bordered;
    if (same)
        return;
    gp_splat_drop_kernels(s);
    s->serial = k->serial;
    s->crop = crop;
    s->tail = tail;
    s->bordered = bordered;
}

/* Uploads the planes with their border, band after band; what was made so far
 * stays in *o when it fails. */
static gp_status upload_kernel(const struct gp_log *log, struct gp_splat *s,
    const struct gp_planes *k, struct gp_splat_kernel *o)
{
    const int b = o->border, w = o->w + 2 * b, h = o->h + 2 * b;
    const int rows = GP_SPLAT_BAND_TEXELS / w;
    gp_status st = gp_texture_make(log, s->gl, "kernel", GP_TEXEL_FLOAT, w, h,
                                   &o->texture);
    for (int y0 = 0; !st && y0 < h; y0 += rows) {
        const struct gp_rect band = {0, y0, w, gp_min(h - y0, rows) + y0};
        memset(s->band, 0,
               (size_t) gp_rect_h(band) * (size_t) w * 4 * sizeof(float));
        for (int y = gp_max(y0, b); y < gp_min(band.y1, o->h + b); y++) {
            const size_t from = (size_t) (y - b) * (size_t) o->w;
            float *const to =
                s->band + 4 * ((size_t) (y - y0) * (size_t) w + (size_t) b);
            for (size_t x = 0; x < (size_t) o->w; x++) {
                for (size_t c = 0; c < 3; c++)
                    to[4 * x + c] = k->c[c][from + x];
            }
        }
        gp_texture_write(s->gl, &o->texture, band, s->band);
    }
    return st;
}

gp_status gp_splat_need_kernel(const struct gp_log *log, struct gp_splat *s,
                               const struct gp_kernel *k, int which)
{
    if (s->kernel[which].texture.id)
        return GP_OK;
    const struct gp_unturned *const u = k->unturned;
    if (which == GP_SPLAT_TURNED) {
        struct gp_splat_kernel o = {.border = 1, .w = u->w, .h = u->h,
                                    .cx = u->cx, .cy = u->cy};
        gp_status st = upload_kernel(log, s, &u->k, &o);
        if (!st)
            s->kernel[which] = o;
        return st;
    }
    const bool core = which == GP_SPLAT_CORE, smooth = which < GP_BLURS;
    const struct gp_rect around = {
        k->cx - GP_CORE_RADIUS, k->cy - GP_CORE_RADIUS,
        k->cx + GP_CORE_RADIUS + 1, k->cy + GP_CORE_RADIUS + 1,
    };
    const struct gp_rect crop = core ? gp_rect_meet(around, s->crop) : s->crop;
    if (gp_rect_empty(crop))
        return GP_OK;
    struct gp_blur b = {0};
    gp_status st = gp_blur_make(log, k, crop, s->tail && !core,
                                smooth ? gp_blur_box[which] : 1, &b);
    if (st)
        return st;
    struct gp_splat_kernel o = {
        .border = smooth || s->bordered, .w = b.w, .h = b.h,
        .cx = (int) floorf(b.cx), .cy = (int) floorf(b.cy),
    };
    o.rest[0] = b.cx - (float) o.cx;
    o.rest[1] = b.cy - (float) o.cy;
    st = upload_kernel(log, s, &b.k, &o);
    if (!st)
        s->kernel[which] = o;
    gp_blur_free(&b);
    return st;
}

/* -- sensors --------------------------------------------------------------- */

/* In EXR pixel space a cell starts at each multiple of its side. */
static int first_corner(int at, int origin, int side)
{
    const long long v = (long long) at + origin, part = v % side;
    return (int) (v - part - (part < 0 ? side : 0) - origin);
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

gp_status gp_splat_upload(const struct gp_log *log, struct gp_splat *s,
                          const struct gp_sources *src, struct gp_rect rect)
{
    const int w = gp_rect_w(rect), h = gp_rect_h(rect);
    struct gp_texture *const t = &s->sources;
    gp_status st = GP_OK;
    if (w < 1)
        return GP_OK;
    if (t->w < w || t->h < h) { // the box of a moving light changes each frame
        const int wide = gp_max(t->w, w), high = gp_max(t->h, h);
        gp_texture_free(s->gl, t);
        st = gp_texture_make(log, s->gl, "sensors", GP_TEXEL_FLOAT, wide, high,
                             t);
    }
    const int rows = GP_SPLAT_BAND_TEXELS / w;
    for (int y0 = 0; !st && y0 < h; y0 += rows) {
        const struct gp_rect band = {0, y0, w, gp_min(h - y0, rows) + y0};
        memset(s->band, 0,
               (size_t) w * (size_t) gp_rect_h(band) * 4 * sizeof(float));
        for (int y = y0; y < band.y1; y++) {
            float *const row = s->band + 4 * (size_t) (y - y0) * (size_t) w;
            const uint32_t end = src->row[rect.y0 + y + 1];
            for (uint32_t i = src->row[rect.y0 + y]; i < end; i++) {
                if (src->x[i] < rect.x0 || src->x[i] >= rect.x1)
                    continue;
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
        gp_texture_write(s->gl, t, band, s->band);
    }
    return st;
}

/* -- groups ---------------------------------------------------------------- */

gp_status gp_splat_group(const struct gp_log *log, struct gp_splat *s,
    struct gp_rect rect, const struct gp_cells *c, unsigned boxes, float fill,
    const struct gp_target *parents, int parent_side, struct gp_target *out)
{
    gp_status st = gp_splat_use(log, s, GP_SPLAT_GROUP);
    if (!st)
        st = gp_splat_fit_target(log, s->gl, "groups", 2, c->w, c->h, out);
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
