#include "glare/splat_state.h"

#include "core/memory.h"

#include <string.h>

/* -- opening and closing -------------------------------------------------- */

void gp_splat_close(void **state)
{
    struct gp_splat *s = *state;
    if (!s)
        return;
    if (s->gl && gp_gl_use(NULL, s->gl) == GP_OK) {
        gp_program_free(s->gl, &s->splat);
        gp_program_free(s->gl, &s->add);
        gp_target_free(s->gl, &s->total);
        gp_target_free(s->gl, &s->chunk);
        gp_texture_free(s->gl, &s->sources);
        gp_texture_free(s->gl, &s->kernel);
    }
    gp_gl_close(&s->gl);
    gp_planes_free(&s->held);
    gp_free(s->band);
    GP_FREE(*state);
}

static enum gp_gl_api api_of(enum gp_gl_choice choice)
{
    switch (choice) {
    case GP_GL_OSMESA:
        return GP_GL_API_OSMESA;
    case GP_GL_EGL:
        return GP_GL_API_EGL;
    case GP_GL_AUTO:
        break;
    }
    return GP_GL_API_AUTO;
}

static gp_status make_splat(const struct gp_log *log,
                            enum gp_gl_choice choice, void **state)
{
    void *block, *band;
    gp_status st = gp_alloc_zero(log, "splat", 1, sizeof(struct gp_splat),
                                 &block);
    if (st)
        return st;
    struct gp_splat *s = *state = block;
    s->choice = choice;
    GP_TRY(gp_alloc(log, "splat", GP_SPLAT_BAND_TEXELS, 4 * sizeof(float),
                    &band));
    s->band = band;
    GP_TRY(gp_gl_open(log, api_of(choice), &s->gl));
    GP_TRY(gp_program_make(log, s->gl, "splat.vert", "splat.frag", &s->splat));
    GP_TRY(gp_program_make(log, s->gl, "add.vert", "add.frag", &s->add));
    return GP_OK;
out:
    gp_splat_close(state);
    return st;
}

gp_status gp_splat_open(const struct gp_log *log, enum gp_gl_choice choice,
                        void **state)
{
    const struct gp_splat *s = *state;
    if (s && s->choice != choice)
        gp_splat_close(state);
    s = *state;
    return s ? gp_gl_use(log, s->gl) : make_splat(log, choice, state);
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
    return gp_texture_make(log, s->gl, "sensors", w, h, t);
}

static gp_status fit_target(const struct gp_log *log, struct gp_splat *s,
                            int w, int h, struct gp_target *t)
{
    if (t->colour.w == w && t->colour.h == h)
        return GP_OK;
    gp_target_free(s->gl, t);
    return gp_target_make(log, s->gl, "layer", w, h, t);
}

gp_status gp_splat_fit_targets(const struct gp_log *log, struct gp_splat *s,
                               int w, int h, bool chunks)
{
    gp_status st = fit_target(log, s, w, h, &s->total);
    if (!st && chunks)
        st = fit_target(log, s, w, h, &s->chunk);
    return st;
}

/* -- kernel ---------------------------------------------------------------- */

static const float *kernel_row(const struct gp_kernel *k, struct gp_rect crop,
                               int c, int y)
{
    return k->k.c[c] + (size_t) (crop.y0 + y) * (size_t) k->w + crop.x0;
}

static bool holds(const struct gp_splat *s, const struct gp_kernel *k,
                  struct gp_rect crop)
{
    size_t w = (size_t) gp_rect_w(crop);
    if (!s->kernel.id || s->held_w != gp_rect_w(crop) ||
        s->held_h != gp_rect_h(crop))
        return false;
    for (int c = 0; c < 3; c++) {
        for (int y = 0; y < s->held_h; y++) {
            if (memcmp(s->held.c[c] + (size_t) y * w,
                       kernel_row(k, crop, c, y), w * sizeof(float)) != 0)
                return false;
        }
    }
    return true;
}

static gp_status hold(const struct gp_log *log, struct gp_splat *s,
                      const struct gp_kernel *k, struct gp_rect crop)
{
    size_t w = (size_t) gp_rect_w(crop), h = (size_t) gp_rect_h(crop);
    if (s->held_samples != w * h) {
        s->held_samples = 0;
        gp_planes_free(&s->held);
        gp_status st = gp_planes_make(log, "kernel", w * h, &s->held);
        if (st)
            return st;
        s->held_samples = w * h;
    }
    s->held_w = (int) w;
    s->held_h = (int) h;
    s->negative = false;
    for (int c = 0; c < 3; c++) {
        for (size_t y = 0; y < h; y++)
            memcpy(s->held.c[c] + y * w, kernel_row(k, crop, c, (int) y),
                   w * sizeof(float));
        for (size_t i = 0; i < w * h; i++)
            s->negative |= s->held.c[c][i] < 0.0f;
    }
    return GP_OK;
}

static void upload_kernel(struct gp_splat *s)
{
    int rows = GP_SPLAT_BAND_TEXELS / s->held_w;
    for (int y0 = 0; y0 < s->held_h; y0 += rows) {
        struct gp_rect band = {0, y0, s->held_w,
                               s->held_h - y0 > rows ? y0 + rows : s->held_h};
        size_t first = (size_t) y0 * (size_t) s->held_w;
        size_t n = (size_t) gp_rect_h(band) * (size_t) s->held_w;
        for (size_t i = 0; i < n; i++) {
            for (int c = 0; c < 3; c++)
                s->band[4 * i + (size_t) c] = s->held.c[c][first + i];
            s->band[4 * i + 3] = 0.0f;
        }
        gp_texture_write(s->gl, &s->kernel, band, s->band);
    }
}

gp_status gp_splat_set_kernel(const struct gp_log *log, struct gp_splat *s,
                              const struct gp_kernel *k, struct gp_rect crop)
{
    if (holds(s, k, crop))
        return GP_OK;
    gp_texture_free(s->gl, &s->kernel); // a failure leaves no old kernel
    gp_status st = gp_texture_make(log, s->gl, "kernel", gp_rect_w(crop),
                                   gp_rect_h(crop), &s->kernel);
    if (!st)
        st = hold(log, s, k, crop);
    if (st)
        gp_texture_free(s->gl, &s->kernel);
    else
        upload_kernel(s);
    return st;
}
