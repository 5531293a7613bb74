#include "glare/splat/state.h"

#include "core/memory.h"

#include <math.h>
#include <string.h>

/* -- opening and closing -------------------------------------------------- */

static void drop_kernels(struct gp_splat *s)
{
    for (int i = 0; i < GP_SPLAT_KERNELS; i++) {
        gp_texture_free(s->gl, &s->kernel[i].texture);
        s->kernel[i] = (struct gp_splat_kernel) {0};
    }
}

static void close_context(struct gp_splat *s)
{
    if (s->gl) {
        for (int i = 0; i < GP_SPLAT_PROGRAM_COUNT; i++)
            gp_program_free(s->gl, &s->program[i]);
        struct gp_target *const targets[] = {&s->total, &s->chunk, &s->groups,
                                             &s->clusters};
        for (size_t i = 0; i < sizeof targets / sizeof *targets; i++)
            gp_target_free(s->gl, targets[i]);
        gp_texture_free(s->gl, &s->sources);
        gp_uniform_block_free(s->gl, &s->reaches);
        drop_kernels(s);
        gp_tiles_free(s->gl, &s->tiles);
    }
    gp_gl_close(&s->gl);
}

void gp_splat_close(void **state)
{
    struct gp_splat *s = *state;
    if (!s)
        return;
    close_context(s);
    gp_splat_plan_free(&s->plan);
    gp_bound_cache_free(&s->bounds);
    gp_free(s->band);
    GP_FREE(*state);
}

gp_status gp_splat_make(const struct gp_log *log, void **state)
{
    if (*state)
        return GP_OK;
    void *block, *band;
    gp_status st = gp_alloc_zero(log, "splat", 1, sizeof(struct gp_splat),
                                 &block);
    if (st)
        return st;
    struct gp_splat *s = *state = block;
    st = gp_alloc(log, "splat", GP_SPLAT_BAND_TEXELS, 4 * sizeof(float),
                  &band);
    if (st)
        gp_splat_close(state);
    else
        s->band = band;
    return st;
}

gp_status gp_splat_open(const struct gp_log *log, struct gp_splat *s,
                        enum gp_gl_api choice)
{
    if (s->gl && s->choice != choice)
        close_context(s);
    if (s->gl)
        return gp_gl_use(log, s->gl);
    s->choice = choice;
    return gp_gl_open(log, choice, &s->gl);
}

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

/* -- sizes ----------------------------------------------------------------- */

gp_status gp_splat_fit_sources(const struct gp_log *log, struct gp_splat *s,
                               int w, int h)
{
    struct gp_texture *t = &s->sources;
    if (t->w >= w && t->h >= h)
        return GP_OK;
    w = t->w > w ? t->w : w; // the box of a moving light changes each frame
    h = t->h > h ? t->h : h;
    gp_texture_free(s->gl, t);
    return gp_texture_make(log, s->gl, "sensors", GP_TEXEL_FLOAT, w, h, t);
}

static gp_status fit_target(const struct gp_log *log, struct gp_splat *s,
                            int w, int h, struct gp_target *t)
{
    if (t->colour.w == w && t->colour.h == h)
        return GP_OK;
    gp_target_free(s->gl, t);
    return gp_target_make(log, s->gl, "layer", GP_TEXEL_FLOAT, 1, w, h, t);
}

gp_status gp_splat_fit_targets(const struct gp_log *log, struct gp_splat *s,
                               int w, int h, bool chunks)
{
    gp_status st = fit_target(log, s, w, h, &s->total);
    if (!st && chunks)
        st = fit_target(log, s, w, h, &s->chunk);
    return st;
}

/* -- kernels --------------------------------------------------------------- */

void gp_splat_set_kernel(struct gp_splat *s, const struct gp_kernel *k,
                         struct gp_rect crop, bool tail, bool bordered)
{
    const bool same = k->serial && k->serial == s->serial &&
                      memcmp(&crop, &s->crop, sizeof crop) == 0 &&
                      tail == s->tail && bordered == s->bordered;
    if (same)
        return;
    drop_kernels(s);
    s->serial = k->serial;
    s->crop = crop;
    s->tail = tail;
    s->bordered = bordered;
}

/* Rows [y0, y1) of the texture, border included, into the band. */
static void fill_band(const struct gp_planes *k,
                      const struct gp_splat_kernel *o, float *band, int y0,
                      int y1)
{
    const int b = o->border;
    const size_t width = (size_t) o->w + 2 * (size_t) b;
    memset(band, 0, (size_t) (y1 - y0) * width * 4 * sizeof(float));
    for (int y = y0; y < y1; y++) {
        if (y < b || y >= o->h + b)
            continue;
        const size_t from = (size_t) (y - b) * (size_t) o->w;
        float *const to = band + 4 * ((size_t) (y - y0) * width + (size_t) b);
        for (size_t x = 0; x < (size_t) o->w; x++) {
            for (size_t c = 0; c < 3; c++)
                to[4 * x + c] = k->c[c][from + x];
        }
    }
}

static gp_status upload(const struct gp_log *log, struct gp_splat *s,
                        const struct gp_planes *k, struct gp_splat_kernel *o)
{
    const int w = o->w + 2 * o->border, h = o->h + 2 * o->border;
    const int rows = GP_SPLAT_BAND_TEXELS / w;
    gp_status st = gp_texture_make(log, s->gl, "kernel", GP_TEXEL_FLOAT, w, h,
                                   &o->texture);
    for (int y0 = 0; !st && y0 < h; y0 += rows) {
        const struct gp_rect band = {0, y0, w, h - y0 > rows ? y0 + rows : h};
        fill_band(k, o, s->band, band.y0, band.y1);
        gp_texture_write(s->gl, &o->texture, band, s->band);
    }
    return st;
}

static gp_status make_turned(const struct gp_log *log, struct gp_splat *s,
                             const struct gp_unturned *u)
{
    struct gp_splat_kernel o = {.border = 1, .w = u->w, .h = u->h,
                                .cx = u->cx, .cy = u->cy};
    gp_status st = upload(log, s, &u->k, &o);
    if (!st)
        s->kernel[GP_SPLAT_TURNED] = o;
    return st;
}

static struct gp_rect core_of(const struct gp_kernel *k, struct gp_rect crop)
{
    const struct gp_rect core = {
        k->cx - GP_CORE_RADIUS, k->cy - GP_CORE_RADIUS,
        k->cx + GP_CORE_RADIUS + 1, k->cy + GP_CORE_RADIUS + 1,
    };
    return gp_rect_meet(core, crop);
}

gp_status gp_splat_need_kernel(const struct gp_log *log, struct gp_splat *s,
                               const struct gp_kernel *k, int which)
{
    if (s->kernel[which].texture.id)
        return GP_OK;
    if (which == GP_SPLAT_TURNED)
        return make_turned(log, s, k->unturned);
    const bool core = which == GP_SPLAT_CORE, smooth = which < GP_BLURS;
    const struct gp_rect crop = core ? core_of(k, s->crop) : s->crop;
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
    st = upload(log, s, &b.k, &o);
    if (!st)
        s->kernel[which] = o;
    gp_blur_free(&b);
    return st;
}
