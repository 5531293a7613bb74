/* HDR-FLIP: LDR-FLIP at many exposures, the largest of which counts. */
#include "tone/flip.h"

#include "core/colour.h"
#include "core/memory.h"
#include "core/parallel.h"

#include <math.h>
#include <string.h>

/* Narkowicz, ACES Filmic Tone Mapping Curve (2016): (x (a x + b)) /
 * (x (c x + d) + e), with x times 0.6 as Andersson et al. 2021 take it. */
static const float ACES_A = 0.6f * 0.6f * 2.51f, ACES_B = 0.6f * 0.03f;
static const float ACES_C = 0.6f * 0.6f * 2.43f, ACES_D = 0.6f * 0.59f;
static const float ACES_E = 0.14f;

#define TARGET 0.85     // what the largest and the median luminance become
#define LIGHT_MAX 1e15f // beyond, all is white; its square is finite

static float light(float v)
{
    return v > 0.0f ? (v < LIGHT_MAX ? v : LIGHT_MAX) : 0.0f; // NaN is 0
}

// -- exposures -----------------------------------------------------------------

/* The x for which the curve gives TARGET: its quadratic's positive root. */
static double light_of_target(void)
{
    const double a = (double) ACES_A - TARGET * (double) ACES_C;
    const double b = (double) ACES_B - TARGET * (double) ACES_D;
    const double c = -TARGET * (double) ACES_E;
    return (-b + sqrt(b * b - 4.0 * a * c)) / (2.0 * a);
}

/* The k-th smallest of v[0, n), which is reordered (Hoare 1961). */
static float kth(float *v, size_t n, size_t k)
{
    size_t low = 0, high = n - 1;
    while (low < high) {
        const float pivot = v[low + (high - low) / 2];
        size_t i = low, j = high;
        for (;;) {
            while (v[i] < pivot)
                i++;
            while (v[j] > pivot)
                j--;
            if (i >= j)
                break;
            const float swap = v[i];
            v[i++] = v[j];
            v[j--] = swap;
        }
        // [low, j] <= pivot <= [j + 1, high]
        if (k <= j)
            high = j;
        else
            low = j + 1;
    }
    return v[k];
}

/* Of an even number, the mean of the two in the middle. */
static double median(float *v, size_t n)
{
    const double upper = (double) kth(v, n, n / 2);
    return n % 2 ? upper : 0.5 * (upper + (double) kth(v, n, n / 2 - 1));
}

/* Luminances into y; returns the largest. */
static float luminances(const struct gp_planes *p, size_t n, float *y)
{
    const float *const k = gp_rec709_luminance;
    float most = 0.0f;
    for (size_t i = 0; i < n; i++) {
        y[i] = k[0] * light(p->c[0][i]) + k[1] * light(p->c[1][i]) +
               k[2] * light(p->c[2][i]);
        most = y[i] > most ? y[i] : most;
    }
    return most;
}

static double lit_median(float *y, size_t n)
{
    const double all = median(y, n);
    if (all > 0.0)
        return all;
    size_t lit = 0;
    for (size_t i = 0; i < n; i++) {
        if (y[i] > 0.0f)
            y[lit++] = y[i];
    }
    return median(y, lit);
}

gp_status gp_flip_exposures_find(const struct gp_log *log, size_t pixels,
                                 const struct gp_planes *reference,
                                 struct gp_flip_exposures *out)
{
    void *block;
    if (pixels == 0)
        return gp_fail(log, GP_ERR_USAGE, "flip: no pixels; give pictures");
    gp_status st = gp_alloc(log, "flip", pixels, sizeof(float), &block);
    if (st)
        return st;
    float *const y = block;
    const float most = luminances(reference, pixels, y);
    *out = (struct gp_flip_exposures) {.count = 1};
    if (most > 0.0f) {
        const double target = light_of_target();
        const double start = log2(target / (double) most);
        const double stop = log2(target / lit_median(y, pixels));
        const double steps = ceil(stop - start);
        *out = (struct gp_flip_exposures) {
            (float) start, (float) stop,
            steps < 2.0 ? 2
            : steps < GP_FLIP_EXPOSURES_MAX ? (int) steps
                                            : GP_FLIP_EXPOSURES_MAX,
        };
    }
    gp_free(block);
    return GP_OK;
}

// -- the metric -----------------------------------------------------------------

struct toning {
    const struct gp_planes *in;
    float scale;
    size_t n;
    struct gp_planes *out;
};

enum { BLOCK = 1 << 14 };

static void tone_block(void *ctx, int block, int thread)
{
    const struct toning *t = ctx;
    const size_t from = (size_t) block * BLOCK;
    const size_t to = t->n - from < BLOCK ? t->n : from + BLOCK;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        for (size_t i = from; i < to; i++) {
            const float x = light(light(t->in->c[c][i]) * t->scale);
            const float y = x * (ACES_A * x + ACES_B) /
                            (x * (ACES_C * x + ACES_D) + ACES_E);
            t->out->c[c][i] = y < 1.0f ? y : 1.0f;
        }
    }
}

static void tone(const struct gp_planes *in, double exposure, size_t n,
                 struct gp_planes *out)
{
    // factors that move any float in or out of sight, so the power is finite
    const double bounded = exposure < -120.0 ? -120.0
                           : exposure > 120.0 ? 120.0 : exposure;
    struct toning t = {in, (float) exp2(bounded), n, out};
    gp_parallel_do((int) ((n + BLOCK - 1) / BLOCK), tone_block, &t);
}

static gp_status check(const struct gp_log *log,
                       const struct gp_flip_exposures *e)
{
    if (e->count < 1 || e->count > GP_FLIP_EXPOSURES_MAX ||
        !isfinite(e->start) || !isfinite(e->stop))
        return gp_fail(log, GP_ERR_USAGE,
                       "flip: exposures out of range (found %d from %g to %g); "
                       "give 1 to %d of finite EV", e->count, (double) e->start,
                       (double) e->stop, GP_FLIP_EXPOSURES_MAX);
    return GP_OK;
}

static double exposure_at(const struct gp_flip_exposures *e, int i)
{
    const double start = (double) e->start, stop = (double) e->stop;
    return e->count > 1 ? start + (stop - start) * i / (e->count - 1) : start;
}

struct hdr_planes {
    struct gp_planes shown[2];
    float *one, *most;  // of one exposure, of all so far
};

static gp_status make_planes(const struct gp_log *log, size_t n,
                             struct hdr_planes *p)
{
    gp_status st;
    void *block;
    for (int i = 0; i < 2; i++)
        GP_TRY(gp_planes_make(log, "flip", n, &p->shown[i]));
    GP_TRY(gp_alloc(log, "flip", n, sizeof(float), &block));
    p->one = block;
    GP_TRY(gp_alloc_zero(log, "flip", n, sizeof(float), &block));
    p->most = block;
out:
    return st;
}

static void free_planes(struct hdr_planes *p)
{
    for (int i = 0; i < 2; i++)
        gp_planes_free(&p->shown[i]);
    GP_FREE(p->one);
    GP_FREE(p->most);
}

gp_status gp_flip_hdr(const struct gp_log *log, int w, int h,
                      const struct gp_planes *reference,
                      const struct gp_planes *test, float ppd,
                      const struct gp_flip_exposures *e, float *map,
                      double *mean)
{
    gp_status st;
    const size_t n = w > 0 && h > 0 ? (size_t) w * (size_t) h : 0;
    const struct gp_planes *const in[2] = {reference, test};
    struct hdr_planes p = {0};
    struct gp_flip_exposures found;
    double sum = 0.0;
    if (e)
        GP_TRY(check(log, e));
    else
        GP_TRY(gp_flip_exposures_find(log, n, reference, &found));
    e = e ? e : &found;
    GP_TRY(make_planes(log, n, &p));
    for (int i = 0; i < e->count; i++) {
        for (int k = 0; k < 2; k++)
            tone(in[k], exposure_at(e, i), n, &p.shown[k]);
        GP_TRY(gp_flip_ldr(log, w, h, &p.shown[0], &p.shown[1], ppd, p.one,
                           NULL));
        for (size_t j = 0; j < n; j++)
            p.most[j] = p.one[j] > p.most[j] ? p.one[j] : p.most[j];
    }
    for (size_t j = 0; j < n; j++)
        sum += (double) p.most[j];
    if (map)
        memcpy(map, p.most, n * sizeof *map);
    if (mean)
        *mean = sum / (double) n;
out:
    free_planes(&p);
    return st;
}
