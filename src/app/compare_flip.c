#include "app/compare_flip.h"

#include "core/colour.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>

static const float BRIGHTEST = 65504.0f; // what infinite light counts as

static void limit(struct gp_planes *p, size_t pixels)
{
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < pixels; i++) {
            if (isinf(p->c[c][i]) && p->c[c][i] > 0.0f)
                p->c[c][i] = BRIGHTEST;
        }
    }
}

static gp_status hdr(const struct gp_log *log,
                     const struct gp_compare_settings *s, int w, int h,
                     struct gp_planes *a, struct gp_planes *b,
                     struct gp_compare_flip *out)
{
    const size_t pixels = (size_t) w * (size_t) h;
    const double *const e = s->flip_exposures.v;
    gp_status st = GP_OK;
    limit(a, pixels);
    limit(b, pixels);
    if (s->flip_exposures.n)
        out->exposures = (struct gp_flip_exposures) {(float) e[0],
                                                     (float) e[1], (int) e[2]};
    else
        st = gp_flip_exposures_find(log, pixels, a, &out->exposures);
    if (!st)
        st = gp_flip_hdr(log, w, h, a, b, GP_FLIP_PPD, &out->exposures,
                         out->map, &out->mean);
    return st;
}

gp_status gp_compare_flip(const struct gp_log *log,
                          const struct gp_compare_settings *s,
                          const struct gp_compare_match *m,
                          struct gp_compare_flip *out)
{
    const int w = gp_rect_w(m->window), h = gp_rect_h(m->window);
    struct gp_planes a = {0}, b = {0};
    gp_status st;
    void *map;
    *out = (struct gp_compare_flip) {
        .hdr = !(m->a->integers && m->b->integers),
    };
    if (s->no_flip)
        return GP_OK;
    GP_TRY(gp_compare_light(log, m, &a, &b));
    if (!a.c[0])
        return GP_OK;
    GP_TRY(gp_alloc(log, "FLIP map", (size_t) w * (size_t) h, sizeof(float),
                    &map));
    out->map = map;
    GP_TRY(out->hdr ? hdr(log, s, w, h, &a, &b, out)
                    : gp_flip_ldr(log, w, h, &a, &b, GP_FLIP_PPD, out->map,
                                  &out->mean));
    out->known = true;
out:
    gp_planes_free(&a);
    gp_planes_free(&b);
    return st;
}

void gp_compare_flip_free(struct gp_compare_flip *f)
{
    GP_FREE(f->map);
    f->known = false;
}

// -- the picture -------------------------------------------------------------

void gp_compare_magma(float v, float rgb[3])
{
    // least squares of degree 6, a row for each power
    static const float power[7][3] = {
        {-0.002136485f, -0.000749655f, -0.005386128f},
        {0.251660541f, 0.677523244f, 2.494026599f},
        {8.353717279f, -3.577719515f, 0.314467903f},
        {-27.66873309f, 14.26473078f, -13.64921319f},
        {52.17613981f, -27.94360607f, 12.94416944f},
        {-50.76852536f, 29.04658282f, 4.23415299f},
        {18.65570507f, -11.48977352f, -5.60196151f},
    };
    const float t = v > 0.0f ? fminf(v, 1.0f) : 0.0f;
    for (int c = 0; c < 3; c++) {
        float sum = power[6][c];
        for (int i = 5; i >= 0; i--)
            sum = sum * t + power[i][c];
        rgb[c] = fminf(fmaxf(sum, 0.0f), 1.0f);
    }
}

gp_status gp_compare_heatmap(const struct gp_log *log,
                             const struct gp_write_params *p, const char *path,
                             const struct gp_compare_match *m,
                             const struct gp_compare_flip *f)
{
    struct gp_frame frame = {
        .path = gp_strdup(path), .data = m->window, .display = m->window,
        .pixel_aspect = 1.0f, .colour_type = GP_FLOAT, .parts = 1,
    };
    struct gp_write_stats stats = {0};
    const size_t pixels = gp_frame_pixels(&frame);
    gp_status st;
    memcpy(frame.chromaticities, gp_rec709_chromaticities,
           sizeof frame.chromaticities);
    memcpy(frame.luminance, gp_rec709_luminance, sizeof frame.luminance);
    if (!frame.path)
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory", path);
    GP_TRY(gp_planes_make(log, "heatmap", pixels, &frame.shown));
    for (size_t i = 0; i < pixels; i++) {
        float rgb[3];
        gp_compare_magma(f->map[i], rgb);
        for (int c = 0; c < 3; c++)
            frame.shown.c[c][i] = gp_srgb_decode(rgb[c]);
    }
    GP_TRY(gp_write_picture(log, p, path, &frame, &frame.shown,
                            GP_PICTURE_SHOWN, &stats));
out:
    gp_frame_free(&frame);
    return st;
}
