/* Images of flare elements: smaller levels of them, and rows of them. */
#include "sun/flare_priv.h"

#include "core/colour.h"
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"

#include <math.h>

// -- levels ------------------------------------------------------------------

/* Each texel is the mean of four; those outside are 0. The picture keeps its
 * corner, so a place u in texels is u / 2. */
static gp_status halve(const struct gp_log *log,
    const struct gp_flare_image *in, struct gp_flare_image *out)
{
    const int w = (in->w + 1) / 2, h = (in->h + 1) / 2;
    *out = (struct gp_flare_image) {.w = w, .h = h, .cx = in->cx / 2.0,
                                    .cy = in->cy / 2.0};
    const gp_status st = gp_planes_make(log, "a flare image at half size",
                                        (size_t) w * (size_t) h, &out->rgb);
    for (int c = 0; !st && c < 3; c++) {
        float *to = out->rgb.c[c];
        for (int y = 0; y < h; y++) {
            for (int x = 0; x < w; x++) {
                float sum = 0.0f;
                for (int j = 2 * y; j < in->h && j < 2 * y + 2; j++) {
                    for (int i = 2 * x; i < in->w && i < 2 * x + 2; i++)
                        sum += in->rgb.c[c][(size_t) j * (size_t) in->w +
                                            (size_t) i];
                }
                *to++ = 0.25f * sum;
            }
        }
    }
    return st;
}

gp_status gp_flare_level_make(const struct gp_log *log,
    const struct gp_flare_image *image, double size, struct gp_flare_level *out)
{
    const size_t n = (size_t) image->w * (size_t) image->h;
    double longer = image->w > image->h ? image->w : image->h;
    struct gp_flare_level l = {.image = *image};
    gp_status st = GP_OK;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++)
            l.sum[c] += (double) image->rgb.c[c][i];
        l.luminance += l.sum[c] * (double) gp_rec709_luminance[c];
    }
    if (!(l.luminance > 0.0) || !isfinite(l.luminance))
        l.luminance = 0.0;
    while (!st && l.luminance > 0.0 && longer > size &&
           (l.image.w > 1 || l.image.h > 1)) {
        struct gp_flare_image half = {0};
        st = halve(log, &l.image, &half);
        if (l.level > 0)
            gp_planes_free(&l.image.rgb);
        l.image = half;
        l.level++;
        longer /= 2.0;
    }
    *out = l;
    return st;
}

// -- rows --------------------------------------------------------------------

static float texel(const struct gp_flare_image *m, int c, int x, int y)
{
    return x < 0 || y < 0 || x >= m->w || y >= m->h
               ? 0.0f
               : m->rgb.c[c][(size_t) y * (size_t) m->w + (size_t) x];
}

static float blend(float a, float b, float t)
{
    return a * (1.0f - t) + b * t;
}

/* Far outside, where this texel and the next are none. */
static int clamp_texel(float v, int size)
{
    return (int) gp_maxf(-2.0f, gp_minf(v, (float) size));
}

float gp_flare_sample(const struct gp_flare_image *m, int c, float x, float y)
{
    const float u = x - 0.5f, v = y - 0.5f;
    const float left = floorf(u), top = floorf(v);
    const int tx = clamp_texel(left, m->w), ty = clamp_texel(top, m->h);
    const float upper = blend(texel(m, c, tx, ty), texel(m, c, tx + 1, ty),
                              u - left);
    const float lower = blend(texel(m, c, tx, ty + 1),
                              texel(m, c, tx + 1, ty + 1), u - left);
    return blend(upper, lower, v - top);
}

GP_CLONES static void add_taps(const float *upper, const float *lower, int n,
                               const float fraction[2], float amount,
                               float *out)
{
    const float s = fraction[0], t = fraction[1];
    for (int i = 0; i < n; i++) {
        const float a = upper[i] * (1.0f - s) + upper[i + 1] * s;
        const float b = lower[i] * (1.0f - s) + lower[i + 1] * s;
        out[i] += amount * (a * (1.0f - t) + b * t);
    }
}

/* At its own pixels, n of texel row ty: all have the same weights. */
static void add_plain(const struct gp_flare_quad *q, int c, int ty, int n,
                      float amount, float *out)
{
    const struct gp_flare_image *const m = q->image;
    const int tx = q->corner[0];
    const bool inside = ty >= 0 && ty + 1 < m->h;
    // columns whose four texels are there
    const int first = inside ? gp_clamp(-tx, 0, n) : n;
    const int end = inside ? gp_clamp(m->w - 1 - tx, first, n) : n;
    if (first < end) {
        const float *const at = m->rgb.c[c] + (size_t) ty * (size_t) m->w +
                                (size_t) (tx + first);
        add_taps(at, at + m->w, end - first, q->fraction, amount, out + first);
    }
    for (int i = 0; i < n; i++) {
        if (i >= first && i < end)
            continue;
        const float a = blend(texel(m, c, tx + i, ty),
                              texel(m, c, tx + i + 1, ty), q->fraction[0]);
        const float b = blend(texel(m, c, tx + i, ty + 1),
                              texel(m, c, tx + i + 1, ty + 1), q->fraction[0]);
        out[i] += amount * blend(a, b, q->fraction[1]);
    }
}

void gp_flare_image_row(const struct gp_flare_quad *q, int y,
                        const float amount[3], float *const out[3])
{
    const int row = y - q->rect.y0, n = gp_rect_w(q->rect);
    const float py = q->base[1] + (float) row;
    for (int c = 0; c < 3; c++) {
        const float cosine = q->turn[0] * q->radius[c];
        const float sine = q->turn[1] * q->radius[c];
        if (q->plain)
            add_plain(q, c, q->corner[1] + row, n, amount[c], out[c]);
        for (int i = 0; i < n && !q->plain; i++) {
            const float px = q->base[0] + (float) i;
            out[c][i] += amount[c] *
                gp_flare_sample(q->image, c,
                                px * cosine - py * sine + q->inner[0],
                                px * sine + py * cosine + q->inner[1]);
        }
    }
}
