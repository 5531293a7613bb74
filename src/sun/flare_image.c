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

/* Columns `from`, ... of a row, counted from the rect's corner. */
struct run {
    int from, n;
    float x, y;   // pixel's place: x + column, y
    float amount;
    float *out;
};

static struct run cut(const struct run *r, int first, int end)
{
    struct run clipped = *r;
    clipped.from += first;
    clipped.n = end - first;
    clipped.out += first;
    return clipped;
}

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

static void add_image(const struct run *r, const struct gp_flare_quad *q, int c)
{
    const struct gp_flare_image *const m = q->image;
    const float cosine = q->turn[0] * q->radius;
    const float sine = q->turn[1] * q->radius;
    for (int i = 0; i < r->n; i++) {
        const float x = r->x + (float) (r->from + i);
        r->out[i] += r->amount *
            gp_flare_sample(m, c, x * cosine - r->y * sine + q->inner[0],
                            x * sine + r->y * cosine + q->inner[1]);
    }
}

GP_CLONES static void add_taps(const struct run *r, const float *upper,
                               const float *lower, float s, float t)
{
    float *const out = r->out;
    const float amount = r->amount;
    for (int i = 0; i < r->n; i++) {
        const float a = upper[i] * (1.0f - s) + upper[i + 1] * s;
        const float b = lower[i] * (1.0f - s) + lower[i + 1] * s;
        out[i] += amount * (a * (1.0f - t) + b * t);
    }
}

/* At its own pixels: all of a run have the same weights. */
static void add_plain(const struct run *r, const struct gp_flare_quad *q,
                      int c, int row)
{
    const struct gp_flare_image *const m = q->image;
    const float s = q->fraction[0], t = q->fraction[1];
    const int ty = q->corner[1] + row;
    const int tx = q->corner[0] + r->from; // texel of weight 1 - s
    const bool inside = ty >= 0 && ty + 1 < m->h;
    const int first = tx < 0 ? -tx : 0;
    const int end = m->w - 1 - tx < r->n ? m->w - 1 - tx : r->n;
    for (int i = 0; i < r->n; i++) {
        if (inside && i >= first && i < end) {
            const struct run clipped = cut(r, i, end);
            const float *const at = m->rgb.c[c] + (size_t) ty * (size_t) m->w +
                (size_t) (tx + i);
            add_taps(&clipped, at, at + m->w, s, t);
            i = end - 1;
            continue;
        }
        const float a = blend(texel(m, c, tx + i, ty),
                              texel(m, c, tx + i + 1, ty), s);
        const float b = blend(texel(m, c, tx + i, ty + 1),
                              texel(m, c, tx + i + 1, ty + 1), s);
        r->out[i] += r->amount * blend(a, b, t);
    }
}

void gp_flare_add_row(const struct gp_flare_quad *q, int c, int y, int x0,
                      int x1, float amount, float *out)
{
    const int row = y - q->rect.y0;
    const struct run r = {
        .from = x0 - q->rect.x0, .n = x1 - x0, .x = q->base[0],
        .y = q->base[1] + (float) row, .amount = amount, .out = out,
    };
    if (q->plain)
        add_plain(&r, q, c, row);
    else
        add_image(&r, q, c);
}
