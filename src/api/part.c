// SPDX-License-Identifier: Apache-2.0
/* The parts of a layer, and the levels of those that are drawn into it. */
#include "api/plan.h"

#include "core/luminance.h"
#include "core/maths.h"
#include "core/memory.h"
#include "glare/sky/sky.h"

#include <math.h>
#include <string.h>

// -- veil and core ------------------------------------------------------------

gp_status gp_api_part_core(struct glarepp_frame *f, const struct gp_sources *s,
                           const struct gp_kernel *k, float gain)
{
    gp_status st = GP_OK;
    const bool inside =
        k->cx >= 0 && k->cx < k->w && k->cy >= 0 && k->cy < k->h;
    const size_t middle = (size_t) k->cy * (size_t) k->w + (size_t) k->cx;
    // by true angles what stays differs from pixel to pixel
    float *own = NULL;
    if (k->sky)
        GP_TRY(gp_alloc(&f->log, "parts", (size_t) s->w, sizeof *own, &own));
    for (int row = 0; row < 3 * s->h && s->n && inside; row++) {
        const int c = row / s->h, y = row % s->h;
        const uint32_t first = s->row[y], end = s->row[y + 1];
        if (own)
            gp_sky_own(gp_sky_channel(k->sky, c), s->w, s->h, y, s->x + first,
                       end - first, own);
        for (uint32_t i = first; i < end; i++) {
            const size_t p = (size_t) y * (size_t) s->w + (size_t) s->x[i];
            const float centre =
                gain * (k->k.c[c][middle] + (own ? own[i - first] : 0.0f));
            f->part[1].c[c][p] += s->rgb[c][i] * centre;
            f->part[0].c[c][p] -= s->rgb[c][i] * centre;
        }
        for (int i = 0; own && i < 2; i++)
            gp_sky_cut_row(k->sky, y, s->w,
                           f->part[i].c[c] + (size_t) y * (size_t) s->w);
    }
out:
    gp_free(own);
    return st;
}

/* Keeps veil and core of a layer without flare and ghosts. */
static gp_status keep_glare(struct glarepp_frame *f)
{
    const size_t n = gp_image_pixels(&f->image);
    gp_status st = GP_OK;
    for (int i = 0; i < 2 && !st; i++) {
        gp_planes_free(&f->part[i]);
        st = gp_planes_make(&f->log, "parts", n, &f->part[i]);
    }
    if (st)
        return st;
    for (int c = 0; c < 3; c++)
        memcpy(f->part[0].c[c], f->image.layer.c[c], n * sizeof(float));
    gp_planes_clear(&f->part[1], 0, n);
    for (int i = 0; i < f->plan->kernels && !st; i++)
        st = gp_api_part_core(f, gp_api_light(f, i), gp_api_kernel(f, i), 1.0f);
    return st;
}

// -- flare and ghosts ---------------------------------------------------------

gp_status gp_api_part_open(struct glarepp_frame *f, struct gp_image *image,
                           struct gp_planes *before)
{
    const bool first = f->p.parts && !f->part[0].c[0] && image == &f->image;
    gp_status st = gp_api_dark_layer(&f->log, image);
    if (!st && first)
        st = keep_glare(f);
    if (st)
        return st;
    *before = image->layer;
    image->layer = (struct gp_planes) {0};
    st = gp_api_dark_layer(&f->log, image);
    if (st) {
        image->layer = *before;
        *before = (struct gp_planes) {0};
    }
    return st;
}

/* A part in bands: its brightest pixels, or its sum with the layer. */
struct bands {
    const struct gp_image *image;
    const struct gp_planes *part, *to;
    float gain, dark; // luminance of the picture that counts as dark
    float peak[GP_FRAME_BANDS][2]; // in dark pixels, in all
};

static void find_peak(void *ctx, int band, int thread)
{
    struct bands *const b = ctx;
    const float *const weight = b->image->luminance;
    float *const peak = b->peak[band];
    const size_t pixels = gp_image_pixels(b->image);
    (void) thread;
    for (size_t i = gp_band_start(pixels, band);
         i < gp_band_start(pixels, band + 1); i++) {
        float own = 0.0f, v = 0.0f;
        for (int c = 0; c < 3; c++) {
            own += weight[c] * b->image->rgb.c[c][i];
            v += weight[c] * b->part->c[c][i];
        }
        peak[0] = own < b->dark ? fmaxf(peak[0], v) : peak[0];
        peak[1] = fmaxf(peak[1], v);
    }
}

static void add_part(void *ctx, int band, int thread)
{
    const struct bands *const b = ctx;
    const size_t pixels = gp_image_pixels(b->image);
    const size_t end = gp_band_start(pixels, band + 1);
    (void) thread;
    for (int c = 0; c < 3; c++) {
        float *restrict const part = b->part->c[c], *restrict to = b->to->c[c];
        for (size_t i = gp_band_start(pixels, band); i < end; i++) {
            part[i] *= b->gain;
            to[i] += part[i];
        }
    }
}

double gp_api_part_level(const struct glarepp_frame *f,
                         const struct gp_image *image, float gain)
{
    static const double WHITE = 0.25; // share of it that is the brightest
    const struct glarepp_plan *const plan = f->plan;
    float peak[2] = {0.0f, 0.0f};
    if (gain > 0.0f)
        return (double) gain;
    const double white = gp_exp2(-(double) plan->tone.exposure);
    struct bands b = {
        .image = image, .part = &image->layer, .dark = (float) (WHITE * white)};
    gp_parallel_do(GP_FRAME_BANDS, find_peak, &b);
    for (int k = 0; k < 2 * GP_FRAME_BANDS; k++)
        peak[k % 2] = fmaxf(peak[k % 2], b.peak[k / 2][k % 2]);
    const double most = (double) (peak[0] > 0.0f ? peak[0] : peak[1]);
    const double shown =
        plan->compose.gain > 0.0f ? (double) plan->compose.gain : 1.0;
    return most > 0.0 ? fmin(WHITE * white / (shown * most), 1e30) : 1.0;
}

void gp_api_part_close(struct glarepp_frame *f, struct gp_image *image,
                       double level, struct gp_planes *before,
                       struct gp_planes *kept)
{
    struct gp_planes part = image->layer;
    struct bands b = {
        .image = image, .part = &part, .to = before, .gain = (float) level};
    gp_parallel_do(GP_FRAME_BANDS, add_part, &b);
    image->layer = *before;
    *before = (struct gp_planes) {0};
    if (f->p.parts && kept) {
        gp_planes_free(kept);
        *kept = part;
    } else {
        gp_planes_free(&part);
    }
}

gp_status gp_api_part_find(struct glarepp_frame *f, enum glarepp_view view)
{
    struct gp_planes *const part = &f->part[view - GLAREPP_PART_VEIL];
    const size_t n = gp_image_pixels(&f->image);
    if (part->c[0] || !f->p.parts || !(f->ran & 1u << GLAREPP_SENSE))
        return GP_OK;
    if (view == GLAREPP_PART_VEIL || view == GLAREPP_PART_CORE) {
        const gp_status st = gp_api_dark_layer(&f->log, &f->image);
        return st ? st : keep_glare(f);
    }
    const gp_status st = gp_planes_make(&f->log, "parts", n, part);
    if (!st)
        gp_planes_clear(part, 0, n);
    return st;
}
