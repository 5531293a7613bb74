/* Rotates kernels about their centre's pixel, and resamples them by areas: to
 * another size, and for pixels that are not square. */
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/glare_priv.h"

#include <math.h>
#include <string.h>

bool gp_rotate_angle(float degrees, struct gp_unturned *u)
{
    static const double exact[] = {1.0, 0.0, -1.0, 0.0};
    const double turns = fmod((double) degrees, 360.0) / 90.0; // exact
    const int quarters = ((int) turns + 4) % 4;
    if (turns == (int) turns) {
        u->cos = exact[quarters];
        u->sin = exact[(quarters + 3) % 4];
        return true;
    }
    const double angle = fmod((double) degrees, 360.0) * M_PI / 180.0;
    u->cos = cos(angle);
    u->sin = sin(angle);
    return false;
}

// -- rotation: one sample -----------------------------------------------------

/* The place in the unturned kernel of a sample of the rotated one. */
struct spot {
    int x, y;       // of the upper left of four samples; may lie outside
    double fx, fy;  // from there, in [0, 1)
};

static struct spot find_spot(const struct gp_unturned *u, int dx, int dy)
{
    const double x = u->cx + (u->cos * dx - u->sin * dy);
    const double y = u->cy + (u->sin * dx + u->cos * dy);
    const double x0 = floor(x), y0 = floor(y);
    return (struct spot) {(int) x0, (int) y0, x - x0, y - y0};
}

static bool is_outside(const struct gp_unturned *u, const struct spot *s)
{
    return s->x < -1 || s->x >= u->w || s->y < -1 || s->y >= u->h;
}

static double tap(const struct gp_unturned *u, int c, int x, int y)
{
    return x >= 0 && x < u->w && y >= 0 && y < u->h
               ? (double) u->k.c[c][(size_t) y * (size_t) u->w + (size_t) x]
               : 0.0;
}

static double sample(const struct gp_unturned *u, int c, const struct spot *s)
{
    const double top = (1.0 - s->fx) * tap(u, c, s->x, s->y) +
                       s->fx * tap(u, c, s->x + 1, s->y);
    const double bottom = (1.0 - s->fx) * tap(u, c, s->x, s->y + 1) +
                          s->fx * tap(u, c, s->x + 1, s->y + 1);
    return (1.0 - s->fy) * top + s->fy * bottom;
}

// -- rotation: the whole kernel -----------------------------------------------

struct rotating {
    const struct gp_unturned *u;
    const struct gp_rotated *to;
    bool grey;
};

static void rotate_row(void *ctx, int y, int thread)
{
    const struct rotating *const t = ctx;
    const size_t at = (size_t) y * (size_t) t->to->w;
    const size_t bytes = (size_t) t->to->w * sizeof(float);
    (void) thread;
    for (int c = 0; c < 3; c++)
        memset(t->to->k.c[c] + at, 0, bytes);
    for (int x = 0; x < t->to->w; x++) {
        const struct spot s = find_spot(t->u, x - t->to->cx, y - t->to->cy);
        if (is_outside(t->u, &s))
            continue;
        for (int c = 0; c < (t->grey ? 1 : 3); c++)
            t->to->k.c[c][at + (size_t) x] = (float) sample(t->u, c, &s);
    }
    for (int c = 1; c < 3 && t->grey; c++)
        memcpy(t->to->k.c[c] + at, t->to->k.c[0] + at, bytes);
}

gp_status gp_rotate(const struct gp_log *log, const char *name,
    const struct gp_unturned *u, bool grey, struct gp_rotated *out)
{
    // whole offsets within the rotated corners of what bilinear sampling
    // reaches, one pixel around the samples; it is 0 on that line
    const double xs[] = {-1.0 - u->cx, (double) u->w - u->cx};
    const double ys[] = {-1.0 - u->cy, (double) u->h - u->cy};
    double box[4] = {INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < 4; i++) {
        const double x = xs[i & 1], y = ys[i >> 1];
        const double dx = u->cos * x + u->sin * y;
        const double dy = u->cos * y - u->sin * x;
        box[0] = fmin(box[0], ceil(dx));
        box[1] = fmin(box[1], ceil(dy));
        box[2] = fmax(box[2], floor(dx));
        box[3] = fmax(box[3], floor(dy));
    }
    const double w = box[2] - box[0] + 1.0, h = box[3] - box[1] + 1.0;
    if (w * h > GP_ROTATED_PIXELS)
        return gp_fail_at(log, GP_ERR_USAGE, "plan.rotate",
                          "%s: the rotated kernel is too large (%.0fx%.0f); "
                          "use a smaller kernel", name, w, h);
    struct gp_rotated t = {
        .w = (int) w, .h = (int) h, .cx = -(int) box[0], .cy = -(int) box[1],
    };
    gp_status st = gp_planes_make(log, name, (size_t) t.w * (size_t) t.h, &t.k);
    if (st)
        return st;
    struct rotating rotating = {u, &t, grey};
    gp_parallel_do(t.h, rotate_row, &rotating);
    *out = t;
    return GP_OK;
}

// -- resampling ---------------------------------------------------------------

float gp_kernel_aspect(const struct gp_image *frame)
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

// -- resampling: the centroid -------------------------------------------------

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

// -- resampling: planes -------------------------------------------------------

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
