// SPDX-License-Identifier: Apache-2.0
/* Makes kernels: checks, converts, rotates about the centre's pixel, resamples
 * by areas, normalises, and cuts off zero borders. */
#include "glare/kernel.h"

#include "core/colour.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/far_field/far_field.h"
#include "glare/sky/sky.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    MAX_CENTER = 1 << 20,  // pixels; a centre farther away meets no frame
    MOST_PIXELS = 1 << 28, // of a kernel that is rotated or resampled
};

/* A kernel before it is cut and normalised. */
struct raw_kernel {
    const char *name;            // for messages
    int w, h;
    struct gp_planes in;
    bool owned;                  // `in` may be taken instead of copied
    const float *luminance;      // weights of the channels
    int cx, cy;                  // the centre's pixel
};

// -- sums of the samples ------------------------------------------------------

struct raw_sums {
    double sum[3];
    float peak;         // largest magnitude
    bool coloured;      // the channels differ
    struct gp_rect box; // the smallest that holds all samples that are not zero
};

/* Fails with the last sample of row y that is NaN or Inf. */
static gp_status refuse_row(const struct gp_log *log,
                            const struct raw_kernel *raw, int y)
{
    const size_t at = (size_t) y * (size_t) raw->w;
    int i = 3 * raw->w - 1;
    while (isfinite(raw->in.c[i / raw->w][at + (size_t) (i % raw->w)]))
        i--;
    return gp_fail(log, GP_ERR_DATA,
                   "%s: the kernel has a non-finite value (%g in channel "
                   "%c, column %d, row %d); replace it by a finite one",
                   raw->name,
                   (double) raw->in.c[i / raw->w][at + (size_t) (i % raw->w)],
                   "RGB"[i / raw->w], i % raw->w, y);
}

/* Errors: GP_ERR_DATA a sample is not finite. */
static gp_status sum_raw(const struct gp_log *log, const struct raw_kernel *raw,
                         struct raw_sums *out)
{
    const size_t w = (size_t) raw->w;
    struct raw_sums o = {.box = {raw->w, raw->h, 0, 0}};
    for (int y = 0; y < raw->h; y++) {
        const size_t at = (size_t) y * w;
        struct gp_rect lit = {raw->w, y, 0, y + 1};
        double all = 0.0;
        for (int c = 0; c < 3; c++) {
            const float *const v = raw->in.c[c] + at;
            double sum = 0.0;
            int first = 0, end = raw->w;
            o.coloured |= memcmp(v, raw->in.c[0] + at, w * sizeof *v) != 0;
            for (size_t x = 0; x < w; x++) {
                sum += (double) v[x];
                o.peak = gp_maxf(fabsf(v[x]), o.peak);
            }
            while (end > lit.x1 && v[end - 1] == 0.0f)
                end--;
            while (first < lit.x0 && v[first] == 0.0f)
                first++;
            lit.x0 = first;
            lit.x1 = end;
            o.sum[c] += sum;
            all += sum;
        }
        if (!isfinite(all))
            return refuse_row(log, raw, y);
        if (!gp_rect_empty(lit))
            o.box = gp_rect_join(o.box, lit);
    }
    *out = o;
    return GP_OK;
}

static gp_status find_factor(const struct gp_log *log,
                             const struct raw_kernel *raw,
                             enum gp_normalize normalize,
                             const struct raw_sums *all, double *factor)
{
    *factor = 1.0;
    const bool as_it_is = normalize == GP_NORMALIZE_NONE;
    if (!(all->peak > 0.0f) || (as_it_is && all->peak < FLT_MIN))
        return gp_fail(log, GP_ERR_DATA, "%s: the kernel is zero everywhere "
                       "(its largest value is %g, those under %.2g count as "
                       "0); use an image that has light", raw->name,
                       (double) all->peak, (double) FLT_MIN);
    if (as_it_is)
        return GP_OK;
    const double sum = gp_luminance_of(raw->luminance, all->sum);
    // (a tiny sum of large lobes would leave the range of float)
    if (!(sum > 0.0) || !((double) all->peak / sum <= (double) FLT_MAX))
        return gp_fail_at(log, GP_ERR_DATA, "kernel.as_it_is",
                          "%s: the kernel cannot be normalised (its luminance "
                          "sums to %g, its peak is %g)", raw->name, sum,
                          (double) all->peak);
    *factor = 1.0 / sum;
    return GP_OK;
}

// -- cut and scaled -----------------------------------------------------------

/* Writes w samples times `factor` to `out`, which may be `in`, and adds their sums to
 * those of channel c. Returns the sum of squares. */
static double scale_row(const float *in, int w, double factor, int c,
                        struct gp_kernel *k, float *out)
{
    double sum = 0.0, square = 0.0, magnitude = 0.0, faint = 0.0;
    for (int x = 0; x < w; x++) {
        float scaled = (float) ((double) in[x] * factor);
        const double size = fabs((double) scaled);
        if (size < (double) FLT_MIN) {
            faint += size;
            scaled = 0.0f;
        }
        out[x] = scaled;
        sum += (double) scaled;
        square += (double) scaled * (double) scaled;
        magnitude += fabs((double) scaled);
        k->negative |= scaled < 0.0f;
    }
    k->sum[c] += sum;
    k->norm1[c] += magnitude;
    k->faint[c] += faint;
    return square;
}

/* Takes raw->in when it is owned, also on failure. */
static gp_status make_kernel(const struct gp_log *log,
    enum gp_normalize normalize, struct raw_kernel *raw, struct gp_kernel *out)
{
    gp_status st;
    struct gp_kernel k = {0};
    struct raw_sums all;
    double factor;
    GP_TRY(sum_raw(log, raw, &all));
    GP_TRY(find_factor(log, raw, normalize, &all, &factor));
    k.w = gp_rect_w(all.box);
    k.h = gp_rect_h(all.box);
    k.cx = raw->cx - all.box.x0;
    k.cy = raw->cy - all.box.y0;
    k.grey = !all.coloured;
    k.serial = gp_serial_next();
    if (raw->owned && k.w == raw->w && k.h == raw->h) {
        k.k = raw->in;
        raw->owned = false; // they are the kernel's
    } else {
        GP_TRY(gp_planes_make(log, raw->name, (size_t) k.w * (size_t) k.h,
                              &k.k));
    }
    for (int c = 0; c < 3; c++) {
        double square = 0.0;
        for (int y = 0; y < k.h; y++)
            square += scale_row(gp_row(raw->in.c[c], raw->w, all.box.y0 + y) +
                                    all.box.x0,
                                k.w, factor, c, &k, gp_row(k.k.c[c], k.w, y));
        k.norm2[c] = sqrt(square);
    }
    k.over = k.negative ? (double) INFINITY : 1.0;
    *out = k;
    k = (struct gp_kernel) {0};
out:
    gp_kernel_free(&k);
    if (raw->owned)
        gp_planes_free(&raw->in);
    return st;
}

// -- rotation -----------------------------------------------------------------

/* A kernel, and the angle that it is rotated by to another:
 *   to(dx, dy) = bilinear(from, (cos * dx - sin * dy, sin * dx + cos * dy))
 * for whole offsets dx, dy from the centre, with zero outside. */
struct rotating {
    struct gp_kernel from;
    double cos, sin;
    const struct raw_kernel *to;
};

/* Sets u->cos and u->sin. True for a whole number of right angles, for which
 * they are exact. */
static bool set_angle(float degrees, struct rotating *u)
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
    u->cos = gp_cos(angle);
    u->sin = gp_sin(angle);
    return false;
}

static double tap(const struct rotating *u, int c, int x, int y)
{
    return (double) gp_planes_at(&u->from.k, c, u->from.w, u->from.h, x, y);
}

static void rotate_row(void *ctx, int row, GP_UNUSED int thread)
{
    const struct rotating *const u = ctx;
    const struct raw_kernel *const to = u->to;
    for (int i = 0; i < to->w; i++) {
        const int dx = i - to->cx, dy = row - to->cy;
        const double x = u->from.cx + (u->cos * dx - u->sin * dy);
        const double y = u->from.cy + (u->sin * dx + u->cos * dy);
        const int x0 = (int) floor(x), y0 = (int) floor(y);
        const double fx = x - x0, fy = y - y0;
        for (int c = 0; c < 3; c++) {
            const double top = (1.0 - fx) * tap(u, c, x0, y0) +
                               fx * tap(u, c, x0 + 1, y0);
            const double bottom = (1.0 - fx) * tap(u, c, x0, y0 + 1) +
                                  fx * tap(u, c, x0 + 1, y0 + 1);
            gp_row(to->in.c[c], to->w, row)[i] =
                (float) ((1.0 - fy) * top + fy * bottom);
        }
    }
}

/* Makes the rotated kernel: every whole offset at which it can be other than 0.
 * By right angles the samples only move. out->name and luminance stay. */
static gp_status rotate(const struct gp_log *log, struct rotating *u,
                        struct raw_kernel *out)
{
    // whole offsets within the rotated corners of what bilinear sampling
    // reaches, one pixel around the samples; it is 0 on that line
    const struct gp_kernel *const k = &u->from;
    const double xs[] = {-1.0 - k->cx, (double) k->w - k->cx};
    const double ys[] = {-1.0 - k->cy, (double) k->h - k->cy};
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
    if (w * h > MOST_PIXELS)
        return gp_fail_at(log, GP_ERR_USAGE, "plan.rotate",
                          "%s: the rotated kernel is too large (%.0fx%.0f); "
                          "use a smaller kernel", out->name, w, h);
    out->w = (int) w;
    out->h = (int) h;
    out->cx = -(int) box[0];
    out->cy = -(int) box[1];
    gp_status st = gp_planes_make(log, out->name,
                                  (size_t) out->w * (size_t) out->h, &out->in);
    u->to = out;
    if (!st)
        gp_parallel_do(out->h, rotate_row, u);
    return st;
}

// -- resampling ---------------------------------------------------------------

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
    const double most = MOST_PIXELS; // more than that is refused
    struct axis s = {.n = n, .c = c, .step = step};
    s.to_n = (int) fmin(to - from + 1.0, most);
    s.to_c = (int) fmin(-from, most);
    return s;
}

struct resampling {
    struct axis x, y;
    const float *in;  // x.n * y.n
    float *across;    // x.to_n * y.n
    float *out;       // x.to_n * y.to_n
};

static void resample_row(void *ctx, int y, GP_UNUSED int thread)
{
    const struct resampling *const r = ctx;
    const float *const in = r->in + (size_t) y * (size_t) r->x.n;
    float *const out = r->across + (size_t) y * (size_t) r->x.to_n;
    double a, b;
    for (int i = 0; i < r->x.to_n; i++) {
        double sum = 0.0;
        for (int j = covered_span(&r->x, i, &a, &b); j < b; j++)
            sum += covered_share(j, a, b) * (double) in[j];
        out[i] = (float) sum;
    }
}

static void resample_columns(void *ctx, int i, GP_UNUSED int thread)
{
    enum { STRIP = 256 };
    const struct resampling *const r = ctx;
    const int w = r->x.to_n;
    float *const out = r->out + (size_t) i * (size_t) w;
    double sum[STRIP], a, b;
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

/* Resamples a kernel to `across` and `down` new pixels for an old one, > 0: new
 * samples are the areas of old ones that they cover, so sums stay. The centre
 * stays the centre of its pixel; each channel's centroid is kept within 1e-3
 * pixel by a shift of all its samples. */
static gp_status resample(const struct gp_log *log, double across, double down,
                          struct raw_kernel *k)
{
    gp_status st;
    struct resampling r = {
        .x = make_axis(k->w, k->cx, 1.0 / across),
        .y = make_axis(k->h, k->cy, 1.0 / down),
    };
    const int w = r.x.to_n, h = r.y.to_n;
    struct gp_planes to = {0};
    double *lines = NULL;
    if ((double) w * gp_max(h, k->h) > MOST_PIXELS)
        return gp_fail(log, GP_ERR_USAGE, "%s: the kernel is too large in this "
                       "size (%dx%d); use a smaller one", k->name, w, h);
    GP_TRY(gp_alloc(log, k->name, (size_t) k->w + (size_t) k->h, sizeof *lines,
                    &lines));
    GP_TRY(gp_alloc(log, k->name, (size_t) w * (size_t) k->h, sizeof *r.across,
                    &r.across));
    GP_TRY(gp_planes_make(log, k->name, (size_t) w * (size_t) h, &to));
    for (int c = 0; c < 3; c++) {
        r.in = k->in.c[c];
        r.out = to.c[c];
        sum_lines(r.in, k->w, k->h, lines, lines + k->w);
        r.x.shift = find_shift(r.x, lines);
        r.y.shift = find_shift(r.y, lines + k->w);
        gp_parallel_do(k->h, resample_row, &r);
        gp_parallel_do(h, resample_columns, &r);
    }
    gp_planes_free(&k->in);
    k->in = to;
    k->w = w, k->h = h, k->cx = r.x.to_c, k->cy = r.y.to_c;
out:
    gp_free(r.across);
    gp_free(lines);
    return st;
}

// -- turned and resized -------------------------------------------------------

/* Makes the kernel, rotated when p->rotate says so. Takes raw->in when it is
 * owned, also on failure. */
static gp_status make_rotated(const struct gp_log *log,
                              const struct gp_kernel_params *p,
                              struct raw_kernel *raw, struct gp_kernel *out)
{
    gp_status st;
    struct raw_kernel t = {.name = raw->name, .owned = true,
                           .luminance = raw->luminance};
    struct rotating u = {0};
    enum gp_normalize normalize = p->normalize;
    const bool right = set_angle(p->rotate, &u);
    const double down = p->scale > 0.0 ? p->scale : 1.0;
    const double across = p->aspect > 0.0 ? down / p->aspect : down;
    const bool sized = down != 1.0 || across != 1.0;
    if (right && u.cos == 1.0 && !sized)
        return make_kernel(log, normalize, raw, out);
    GP_TRY(make_kernel(log, GP_NORMALIZE_NONE, raw, &u.from));
    GP_TRY(rotate(log, &u, &t));
    if (sized) {
        GP_TRY(resample(log, across, down, &t));
    } else if (!right && normalize == GP_NORMALIZE_LUMINANCE) {
        // scaled before, so that what is rotated is normalised
        struct raw_sums all;
        double factor;
        GP_TRY(sum_raw(log, &t, &all));
        GP_TRY(find_factor(log, &t, normalize, &all, &factor));
        const size_t n = (size_t) u.from.w * (size_t) u.from.h;
        for (size_t i = 0; i < 3 * n; i++) {
            float *const v = &u.from.k.c[i / n][i % n];
            *v = (float) ((double) *v * factor);
        }
        gp_planes_free(&t.in);
        GP_TRY(rotate(log, &u, &t));
        normalize = GP_NORMALIZE_NONE;
    }
    GP_TRY(make_kernel(log, normalize, &t, out));
    out->resampled = sized || !right;
out:
    if (t.owned)
        gp_planes_free(&t.in);
    gp_kernel_free(&u.from);
    return st;
}

// -- primaries ----------------------------------------------------------------

static bool is_grey(const struct raw_kernel *raw)
{
    const size_t bytes = (size_t) raw->w * (size_t) raw->h * sizeof(float);
    return memcmp(raw->in.c[0], raw->in.c[1], bytes) == 0 &&
           memcmp(raw->in.c[0], raw->in.c[2], bytes) == 0;
}

/* Converts raw->in from primaries to others, unless it is grey, which has no
 * primaries; it is owned then. Sets raw->luminance to `luminance`, the weights
 * of the others. */
static gp_status convert(const struct gp_log *log, const float from[8],
    const float to[8], float luminance[3], struct raw_kernel *raw)
{
    const size_t n = (size_t) raw->w * (size_t) raw->h;
    struct gp_planes out;
    double m[9];
    if (memcmp(from, to, 8 * sizeof *from) == 0)
        return GP_OK;
    gp_luminance_weights(to, luminance);
    raw->luminance = luminance;
    if (is_grey(raw))
        return GP_OK;
    if (!gp_spectrum_to_spectrum(from, to, m))
        return gp_fail(log, GP_ERR_DATA, "%s: the kernel's primaries cannot "
                       "become the frame's; repair chromaticities", raw->name);
    gp_status st = gp_planes_make(log, raw->name, n, &out);
    for (size_t i = 0; i < n && !st; i++) {
        const double r = (double) raw->in.c[0][i], g = (double) raw->in.c[1][i],
                     b = (double) raw->in.c[2][i];
        double v[3] = {r, g, b};
        if (isfinite(r) && isfinite(g) && isfinite(b)) { // else an error later
            for (int c = 0; c < 3; c++)
                v[c] = m[3 * c] * r + m[3 * c + 1] * g + m[3 * c + 2] * b;
            if (r >= 0.0 && g >= 0.0 && b >= 0.0) // lobes stay
                gp_gamut_fold(luminance, v);
        }
        for (int c = 0; c < 3; c++)
            out.c[c][i] = (float) v[c];
    }
    if (!st) {
        raw->in = out;
        raw->owned = true;
    }
    return st;
}

// -- from a frame, from planes ------------------------------------------------

/* Finds the pixel of the centre, counted from a window that starts at x0, y0,
 * and checks the angle. */
static gp_status find_center(const struct gp_log *log,
                             const struct gp_kernel_params *p,
                             struct gp_rect window, struct raw_kernel *raw)
{
    if (!isfinite(p->rotate))
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: the kernel cannot be rotated by %g degrees; give a "
                       "finite angle", raw->name, (double) p->rotate);
    raw->cx = raw->w / 2;
    raw->cy = raw->h / 2;
    if (!p->centered)
        return GP_OK;
    for (int i = 0; i < 2; i++) {
        if (!(fabs(p->center[i]) <= MAX_CENTER))
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: the kernel's centre is too far away (%g,%g); "
                           "give pixels within %d of 0,0", raw->name,
                           p->center[0], p->center[1], MAX_CENTER);
    }
    raw->cx = (int) floor(p->center[0]) - window.x0;
    raw->cy = (int) floor(p->center[1]) - window.y0;
    return GP_OK;
}

gp_status gp_kernel_from_frame(const struct gp_log *log,
    const struct gp_kernel_params *p, const struct gp_image *image,
    struct gp_kernel *out)
{
    struct raw_kernel raw = {
        .name = image->path ? image->path : "kernel",
        .w = gp_image_w(image), .h = gp_image_h(image),
        .in = image->rgb, .luminance = image->luminance,
    };
    if (raw.w < 1 || raw.h < 1)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the kernel has no pixels (%dx%d); use another "
                       "image", raw.name, raw.w, raw.h);
    float luminance[3];
    gp_status st = find_center(log, p, image->data, &raw);
    if (!st && p->chromaticities && image->names_chromaticities)
        st = convert(log, image->chromaticities, p->chromaticities, luminance,
                     &raw);
    if (!st)
        st = make_rotated(log, p, &raw, out);
    if (!st)
        out->left_out = p->left_out;
    return st;
}

gp_status gp_kernel_of_planes(const struct gp_log *log, const char *name,
    int w, int h, struct gp_planes *planes, struct gp_kernel *out)
{
    struct raw_kernel raw = {
        .name = name, .w = w, .h = h, .in = *planes, .owned = true,
        .luminance = gp_rec709_luminance, .cx = w / 2, .cy = h / 2,
    };
    *planes = (struct gp_planes) {0};
    return make_kernel(log, GP_NORMALIZE_NONE, &raw, out);
}

void gp_kernel_sums(const struct gp_kernel *k, int c, bool squares, double *to)
{
    const size_t pitch = (size_t) k->w + 1;
    memset(to, 0, pitch * sizeof *to);
    for (int y = 0; y < k->h; y++) {
        const float *const from = gp_row(k->k.c[c], k->w, y);
        const double *const above = to;
        double sum = 0.0;
        to += pitch;
        to[0] = 0.0;
        for (int x = 0; x < k->w; x++) {
            const double v = (double) from[x];
            sum += squares ? v * v : v;
            to[x + 1] = above[x + 1] + sum;
        }
    }
}

void gp_kernel_free(struct gp_kernel *k)
{
    gp_free(k->origin);
    gp_far_free(k->far);
    gp_sky_free(&k->sky);
    gp_planes_free(&k->k);
    *k = (struct gp_kernel) {0};
}
