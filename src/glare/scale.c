#include "glare/scale.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "glare/bound/bound.h"
#include "glare/direct/direct.h"
#include "glare/fft/place.h"

#include <math.h>
#include <string.h>

/* Values whose largest are from 2^SMALL on have products far from the least
 * normal float, 2^-126; smaller ones are brought there. No kernel of sum 1 is
 * under it. Products of scaled light are under 2^LARGE: 2^28 have a sum. */
enum { SMALL = -16, LARGE = 96 };

struct gp_scale {
    struct gp_kernel kernel; // scaled
    unsigned long of;        // serial of what it was; 0 none that is known
    struct gp_fft_quarters quarters; // for frames of w x h
    unsigned long quarters_of;       // serial; 0 none that is known
    int w, h;
    struct gp_bound_cache least;
};

void gp_scale_free(struct gp_scale **keep)
{
    if (!*keep)
        return;
    gp_kernel_free(&(*keep)->kernel);
    gp_bound_cache_free(&(*keep)->least);
    GP_FREE(*keep);
}

static gp_status open_scale(const struct gp_log *log, struct gp_scale **keep)
{
    void *block = *keep;
    gp_status st = GP_OK;
    if (!block)
        st = gp_alloc_zero(log, "scale", 1, sizeof **keep, &block);
    *keep = block;
    return st;
}

// -- scaling ------------------------------------------------------------------

/* One rounding, even to a denormal. */
static void scale_floats(float *to, const float *from, size_t n, int exponent)
{
    const double factor = ldexp(1.0, exponent);
    for (size_t i = 0; i < n; i++)
        to[i] = (float) ((double) from[i] * factor);
}

static double largest(const double v[3])
{
    return fmax(v[0], fmax(v[1], v[2]));
}

static int up_to(int least, int exponent)
{
    return exponent < least ? least - exponent : 0;
}

static gp_status scale_planes(const struct gp_log *log, struct gp_planes *to,
                              const struct gp_planes *from, size_t n,
                              int exponent)
{
    const gp_status st = gp_planes_make(log, "kernel", n, to);
    for (int c = 0; !st && c < 3; c++)
        scale_floats(to->c[c], from->c[c], n, exponent);
    return st;
}

static gp_status scale_kernel(const struct gp_log *log,
                              const struct gp_kernel *in, int exponent,
                              struct gp_kernel *out)
{
    gp_status st;
    void *block;
    const double factor = ldexp(1.0, exponent);
    struct gp_kernel k = *in;
    k.k = (struct gp_planes) {0};
    k.unturned = NULL;
    k.serial = in->serial ? gp_serial_next() : 0;
    for (int c = 0; c < 3; c++) {
        k.sum[c] *= factor;
        k.norm1[c] *= factor;
        k.norm2[c] *= factor;
    }
    GP_TRY(scale_planes(log, &k.k, &in->k, (size_t) k.w * (size_t) k.h,
                        exponent));
    if (in->unturned) {
        const struct gp_unturned *const u = in->unturned;
        GP_TRY(gp_alloc(log, "kernel", 1, sizeof *u, &block));
        k.unturned = block;
        *k.unturned = *u;
        k.unturned->k = (struct gp_planes) {0};
        GP_TRY(scale_planes(log, &k.unturned->k, &u->k,
                            (size_t) u->w * (size_t) u->h, exponent));
    }
    *out = k;
    k = (struct gp_kernel) {0};
out:
    gp_kernel_free(&k);
    return st;
}

static gp_status keep_kernel(const struct gp_log *log,
                             const struct gp_kernel *k, int exponent,
                             struct gp_scale *s)
{
    if (s->of && s->of == k->serial)
        return GP_OK;
    gp_kernel_free(&s->kernel);
    s->of = 0;
    const gp_status st = scale_kernel(log, k, exponent, &s->kernel);
    if (!st)
        s->of = k->serial;
    return st;
}

/* Sources in the same places. */
static gp_status scale_light(const struct gp_log *log,
                             const struct gp_sources *in, int exponent,
                             struct gp_sources *out)
{
    gp_status st;
    void *v;
    const double factor = ldexp(1.0, exponent);
    *out = *in;
    memset(out->rgb, 0, sizeof out->rgb);
    memset(out->count, 0, sizeof out->count);
    for (int c = 0; c < 3; c++) {
        GP_TRY(gp_alloc(log, "sources", in->n, sizeof(float), &v));
        out->rgb[c] = v;
        scale_floats(out->rgb[c], in->rgb[c], in->n, exponent);
        out->flux[c] *= factor;
        out->energy[c] *= factor * factor;
    }
    out->brightest = (float) ((double) in->brightest * factor);
    for (size_t i = 0; i < in->n; i++)
        out->count[gp_source_bin(fmaxf(
            out->rgb[0][i], fmaxf(out->rgb[1][i], out->rgb[2][i])))]++;
    return GP_OK;
out:
    gp_scale_light_free(out);
    return st;
}

void gp_scale_light_free(struct gp_sources *light)
{
    for (int c = 0; c < 3; c++)
        gp_free(light->rgb[c]);
    *light = (struct gp_sources) {0};
}

gp_status gp_scale_job(struct gp_glare_job *job, struct gp_scale **keep,
                       struct gp_sources *light)
{
    const struct gp_kernel *const k = job->kernel;
    const double norm = largest(k->norm2);
    const int of_kernel = norm > 0.0 ? ilogb(norm) : 0;
    const int of_light = job->src->n && job->src->brightest > 0.0f
                             ? ilogbf(job->src->brightest) : 0;
    if (of_kernel >= SMALL && of_light >= SMALL)
        return GP_OK;
    // (the kernel's for itself: what is kept of it serves every frame)
    const int up_kernel = up_to(SMALL, of_kernel);
    const int room = LARGE - of_kernel;
    const int up_light = up_to(room < SMALL ? room : SMALL, of_light);
    gp_status st = GP_OK;
    if (up_kernel)
        st = open_scale(job->log, keep);
    if (!st && up_kernel)
        st = keep_kernel(job->log, k, up_kernel, *keep);
    if (!st)
        st = scale_light(job->log, job->src, up_light, light);
    if (st)
        return st;
    job->exponent = up_kernel + up_light;
    light->darkest = ldexp(light->darkest, job->exponent); // as the layer
    job->src = light;
    if (up_kernel)
        job->kernel = &(*keep)->kernel;
    return GP_OK;
}

static void back_row(void *ctx, int y, int thread)
{
    const struct gp_glare_job *const job = ctx;
    const size_t w = (size_t) job->src->w;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        float *const row = job->layer->c[c] + (size_t) y * w;
        scale_floats(row, row, w, -job->exponent);
    }
}

void gp_scale_back(const struct gp_glare_job *job)
{
    if (job->exponent)
        gp_parallel_do(job->src->h, back_row, (void *) job);
}

// -- what is lost below -------------------------------------------------------

/* The norm of what each source leaves in its own pixel. */
static double own_pixels(const struct gp_sources *src,
                         const struct gp_kernel *k)
{
    double square = 0.0;
    if (k->cx < 0 || k->cx >= k->w || k->cy < 0 || k->cy >= k->h)
        return 0.0;
    const size_t at = (size_t) k->cy * (size_t) k->w + (size_t) k->cx;
    for (int c = 0; c < 3; c++)
        square += src->energy[c] * (double) k->k.c[c][at] *
                  (double) k->k.c[c][at];
    return sqrt(square);
}

/* The norm of what sources anywhere leave. */
static double anywhere(const struct gp_sources *src, const struct gp_kernel *k,
                       struct gp_scale *s)
{
    if (!s->quarters_of || s->quarters_of != k->serial || s->w != src->w ||
        s->h != src->h) {
        gp_fft_find_quarters(k, src->w, src->h, &s->quarters);
        s->quarters_of = k->serial;
        s->w = src->w;
        s->h = src->h;
    }
    return gp_fft_least(src, &s->quarters);
}

/* A value under 2^-126 is lost: of the kernel it costs a pixel up to that much
 * of all light, of the light that much of the kernel's sum, of the products and
 * sums that much each. 2^6 of them: engines have more steps than one. What the
 * division leaves is rounded to a multiple of 2^-149. */
gp_status gp_scale_floor(const struct gp_glare_job *job,
                         struct gp_scale **keep, double *floor)
{
    static const double NEGLIGIBLE = 1e-12;
    const struct gp_sources *const src = job->src;
    const struct gp_kernel *const k = job->kernel;
    gp_status st = GP_OK;
    const double pixel =
        0x1p-120 * (largest(src->flux) + largest(k->norm1) +
                    2.0 * (double) src->n) +
        (job->exponent ? ldexp(1.0, job->exponent - 150) : 0.0);
    const double lost = pixel * sqrt(3.0 * src->w * src->h);
    const double enough = lost / NEGLIGIBLE;
    double least = own_pixels(src, k);
    *floor = 0.0;
    if (gp_direct_lobes(k)) // no engine guarantees anything
        return GP_OK;
    if (least < enough)
        st = open_scale(job->log, keep);
    if (!st && least < enough)
        least = anywhere(src, k, *keep);
    if (!st && least < enough)
        st = gp_layer_least(job->log, src, k, &(*keep)->least, &least);
    if (!st)
        *floor = least > 0.0 ? lost / least : INFINITY;
    return st;
}
