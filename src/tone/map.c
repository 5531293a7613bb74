// SPDX-License-Identifier: Apache-2.0
/* The tone stage: exposure and primaries, then the operator, a block of pixels
 * at a time so that both work in the cache. */
#include "tone/tone.h"

#include "core/colour.h"
#include "core/cpu.h"
#include "core/luminance.h"
#include "core/maths.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <string.h>

enum {
    BLOCK = 4096,     // pixels mapped at a time: 96 KiB in and out
    SCRATCH = 512,    // pixels measured at a time, on the stack
};

#define SCALE_MIN 0x1p-140f  // FLT_MAX times it is under 1
#define SCALE_MAX 0x1p60f    // GP_LIGHT_MAX times it stays finite

struct mapping {
    const struct gp_image *f;
    const struct gp_tone_curve *curve;
    float scale, white;
    bool mixed;              // the primaries are not those of BT.709
    float matrix[9];         // primaries to BT.709, row-major
    float peak[GP_FRAME_BANDS]; // largest luminance of each band
};

static inline float bounded(float x)
{
    x = x > -GP_LIGHT_MAX ? x : -GP_LIGHT_MAX;
    return x < GP_LIGHT_MAX ? x : GP_LIGHT_MAX;
}

GP_CLONES static void make_light(const struct mapping *m, size_t at, size_t n,
                                 float *const out[3])
{
    float *const restrict r = out[0], *const restrict g = out[1];
    float *const restrict b = out[2];
    const float *const mix = m->matrix, scale = m->scale;
    for (int c = 0; c < 3; c++) {
        const float *const in = m->f->lit.c[c] + at;
        float *const restrict to = out[c];
        for (size_t i = 0; i < n; i++)
            to[i] = in[i] * scale;
    }
    for (size_t i = 0; m->mixed && i < n; i++) {
        const float r0 = bounded(r[i]), g0 = bounded(g[i]), b0 = bounded(b[i]);
        r[i] = mix[0] * r0 + mix[1] * g0 + mix[2] * b0;
        g[i] = mix[3] * r0 + mix[4] * g0 + mix[5] * b0;
        b[i] = mix[6] * r0 + mix[7] * g0 + mix[8] * b0;
    }
}

// -- measuring ---------------------------------------------------------------

static void measure_peak(void *ctx, int band, int thread)
{
    struct mapping *m = ctx;
    const size_t pixels = gp_image_pixels(m->f);
    const size_t end = gp_band_start(pixels, band + 1);
    float scratch[3][SCRATCH];
    double peak = 0.0; // in double: it must map to white exactly
    float *const out[3] = {scratch[0], scratch[1], scratch[2]};
    (void) thread;
    for (size_t at = gp_band_start(pixels, band); at < end; at += SCRATCH) {
        const size_t n = end - at < SCRATCH ? end - at : SCRATCH;
        make_light(m, at, n, out);
        for (size_t i = 0; i < n; i++) {
            double y = 0.0; // negative channels are no light, as in the curves
            for (int c = 0; c < 3; c++)
                y += (double) gp_rec709_luminance[c] *
                     (double) (out[c][i] > 0.0f ? out[c][i] : 0.0f);
            peak = y > peak ? y : peak;
        }
    }
    m->peak[band] = peak < (double) GP_LIGHT_MAX ? (float) peak
                                                 : GP_LIGHT_MAX;
}

float gp_tone_scale(const struct glarepp_tone_params *p,
                    const struct gp_image *f)
{
    double scale = gp_exp2((double) p->exposure);
    if (p->auto_exposure) {
        double average = gp_log_average(f, &f->lit);
        scale *= average > 0.0 ? (double) p->key / average : 1.0;
    }
    scale = scale > (double) SCALE_MIN ? scale : (double) SCALE_MIN;
    return scale < (double) SCALE_MAX ? (float) scale : SCALE_MAX;
}

static void map_block(void *ctx, int block, int thread)
{
    const struct mapping *m = ctx;
    const struct gp_image *f = m->f;
    const size_t at = (size_t) block * BLOCK, left = gp_image_pixels(f) - at;
    const size_t n = left < BLOCK ? left : BLOCK;
    float *const out[3] = {
        f->shown.c[0] + at, f->shown.c[1] + at, f->shown.c[2] + at,
    };
    (void) thread;
    if (!m->curve->map) {
        for (int c = 0; c < 3; c++)
            memcpy(out[c], f->lit.c[c] + at, n * sizeof(float));
        return;
    }
    make_light(m, at, n, out);
    m->curve->map(out[0], out[1], out[2], n, m->white);
}

gp_status gp_tone_map(const struct gp_log *log,
    const struct glarepp_tone_params *p, struct gp_image *f)
{
    struct mapping m = {
        .f = f, .curve = gp_tone_find(p->curve), .scale = 1.0f, .white = 1.0f,
    };
    const size_t pixels = gp_image_pixels(f);
    if (!f->shown.c[0]) {
        gp_status st = gp_planes_make(log, "shown frame", pixels, &f->shown);
        if (st)
            return st;
    }
    if (m.curve->map) {
        double matrix[9];
        m.scale = gp_tone_scale(p, f);
        m.mixed = memcmp(f->chromaticities, gp_rec709_chromaticities,
                         sizeof f->chromaticities) != 0 &&
                  gp_rgb_to_rgb(f->chromaticities, gp_rec709_chromaticities,
                                matrix);
        for (int i = 0; m.mixed && i < 9; i++)
            m.matrix[i] = (float) matrix[i];
    }
    if (m.curve->reads_white && p->white > 0.0f) {
        m.white = p->white;
    } else if (m.curve->reads_white) { // the largest; 1 for a black frame
        float peak = 0.0f;
        gp_parallel_do(GP_FRAME_BANDS, measure_peak, &m);
        for (int i = 0; i < GP_FRAME_BANDS; i++)
            peak = gp_maxf(m.peak[i], peak);
        m.white = peak > 0.0f ? peak : 1.0f;
    }
    gp_parallel_do((int) ((pixels + BLOCK - 1) / BLOCK), map_block, &m);
    return GP_OK;
}
