/* Resamples kernels by areas: to another size, and for pixels that are not
 * square. */
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/glare_priv.h"

#include <math.h>
#include <string.h>

float gp_kernel_aspect(const struct gp_frame *frame)
{
    const float a = frame ? frame->pixel_aspect : 1.0f;
    return a >= 1.0f / 16.0f && a <= 16.0f ? a : 1.0f;
}

/* One axis: new sample i is the area of the old ones within step / 2 of
 * (i - to_c - shift) * step from the old centre. */
struct axis {
    int n, c;        // old samples, and the centre's
    int to_n, to_c;  // new ones
    double step;     // old samples a new one
    double shift;    // of the grid, in new samples
};

/* Returns the first old sample that a new one covers, and the line from *a to
 * *b, in samples from the edge of the first. */
static int covered_span(const struct axis *s, int i, double *a, double *b)
{
    const double mid = (i - s->to_c - s->shift) * s->step + s->c + 0.5;
    *a = fmin(fmax(mid - 0.5 * s->step, 0.0), s->n);
    *b = fmin(fmax(mid + 0.5 * s->step, 0.0), s->n);
    return (int) *a;
}

/* The part of old sample j that lies on the line. */
static double covered_share(int j, double a, double b)
{
    return fmin(j + 1.0, b) - fmax(j, a);
}

// -- the centroid -------------------------------------------------------------

/* Distance of the new samples' centroid from the old one's place, in new
 * samples; `line` has the old sums across the axis. */
static double drift(const struct axis *s, const double *line)
{
    double sum = 0.0, moment = 0.0, wanted = 0.0, a, b;
    for (int j = 0; j < s->n; j++) {
        sum += line[j];
        wanted += line[j] * (j - s->c);
    }
    for (int i = 0; i < s->to_n; i++) {
        for (int j = covered_span(s, i, &a, &b); j < b; j++)
            moment += covered_share(j, a, b) * line[j] * (i - s->to_c);
    }
    return (moment - wanted / s->step) / sum;
}

/* Areas of samples that lie unevenly in new ones move the centroid; a shift of
 * the grid by less than half a sample brings it back. None is needed where the
 * kernel is symmetric. */
static double find_shift(struct axis s, const double *line)
{
    double low = -0.5, high = 0.5;
    s.shift = 0.0;
    if (!(fabs(drift(&s, line)) > 1e-7))
        return 0.0; // (no light in it: NaN)
    for (int i = 0; i < 30; i++) {
        s.shift = 0.5 * (low + high);
        if (drift(&s, line) < 0.0)
            low = s.shift;
        else
            high = s.shift;
    }
    return fabs(drift(&s, line)) < 1e-3 ? s.shift : 0.0;
}

static struct axis make_axis(int n, int c, double step)
{
    // one more on each side, for the shift
    const double from = floor((-0.5 - c) / step + 0.5) - 1.0;
    const double to = ceil((n - 0.5 - c) / step - 0.5) + 1.0;
    const double most = GP_ROTATED_PIXELS; // more than that is refused
    struct axis s = {.n = n, .c = c, .step = step};
    s.to_n = (int) fmin(to - from + 1.0, most);
    s.to_c = (int) fmin(-from, most);
    return s;
}

// -- planes -------------------------------------------------------------------

struct resampling {
    struct axis x, y;
    const float *in;  // x.n * y.n
    float *across;    // x.to_n * y.n
    float *out;       // x.to_n * y.to_n
};

static void resample_row(void *ctx, int y, int thread)
{
    const struct resampling *const r = ctx;
    const float *const in = r->in + (size_t) y * (size_t) r->x.n;
    float *const out = r->across + (size_t) y * (size_t) r->x.to_n;
    double a, b;
    (void) thread;
    for (int i = 0; i < r->x.to_n; i++) {
        double sum = 0.0;
        for (int j = covered_span(&r->x, i, &a, &b); j < b; j++)
            sum += covered_share(j, a, b) * (double) in[j];
        out[i] = (float) sum;
    }
}

static void resample_columns(void *ctx, int i, int thread)
{
    enum { STRIP = 256 };
    const struct resampling *const r = ctx;
    const int w = r->x.to_n;
    float *const out = r->out + (size_t) i * (size_t) w;
    double sum[STRIP], a, b;
    (void) thread;
    const int first = covered_span(&r->y, i, &a, &b);
    for (int x = 0; x < w; x += STRIP) {
        const int n = gp_min(w - x, STRIP);
        memset(sum, 0, sizeof sum);
        for (int j = first; j < b; j++) {
            const float *const in = r->across + (size_t) j * (size_t) w + x;
            const double share = covered_share(j, a, b);
            for (int k = 0; k < n; k++)
                sum[k] += share * (double) in[k];
        }
        for (int k = 0; k < n; k++)
            out[x + k] = (float) sum[k];
    }
}

/* Sums of a plane's columns, and of its rows. */
static void sum_lines(const float *in, int w, int h, double *column,
                      double *row)
{
    memset(column, 0, (size_t) w * sizeof *column);
    for (int y = 0; y < h; y++) {
        row[y] = 0.0;
        for (int x = 0; x < w; x++) {
            const double v = (double) in[(size_t) y * (size_t) w + (size_t) x];
            row[y] += v;
            column[x] += v;
        }
    }
}

gp_status gp_resample(const struct gp_log *log, const char *name, double across,
                      double down, bool grey, struct gp_rotated *k)
{
    gp_status st;
    struct resampling r = {
        .x = make_axis(k->w, k->cx, 1.0 / across),
        .y = make_axis(k->h, k->cy, 1.0 / down),
    };
    struct gp_rotated t = {.w = r.x.to_n, .h = r.y.to_n, .cx = r.x.to_c,
                           .cy = r.y.to_c};
    double *lines = NULL;
    const double most = (double) t.w * gp_max(t.h, k->h);
    if (most > GP_ROTATED_PIXELS)
        return gp_fail(log, GP_ERR_USAGE, "%s: the kernel is too large in this "
                       "size (%dx%d); use a smaller one", name, t.w, t.h);
    GP_TRY(gp_alloc(log, name, (size_t) k->w + (size_t) k->h, sizeof *lines,
                    &lines));
    GP_TRY(gp_alloc(log, name, (size_t) t.w * (size_t) k->h, sizeof *r.across,
                    &r.across));
    GP_TRY(gp_planes_make(log, name, (size_t) t.w * (size_t) t.h, &t.k));
    for (int c = 0; c < 3; c++) {
        if (c > 0 && grey) {
            memcpy(t.k.c[c], t.k.c[0],
                   (size_t) t.w * (size_t) t.h * sizeof(float));
            continue;
        }
        r.in = k->k.c[c];
        r.out = t.k.c[c];
        sum_lines(r.in, k->w, k->h, lines, lines + k->w);
        r.x.shift = find_shift(r.x, lines);
        r.y.shift = find_shift(r.y, lines + k->w);
        gp_parallel_do(k->h, resample_row, &r);
        gp_parallel_do(t.h, resample_columns, &r);
    }
    gp_planes_free(&k->k);
    *k = t;
    t = (struct gp_rotated) {0};
out:
    gp_planes_free(&t.k);
    gp_free(r.across);
    gp_free(lines);
    return st;
}
