/* Makes kernels: checks, converts, rotates, normalises, and cuts off zero
 * borders. */
#include "glare/kernel.h"

#include "core/colour.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/glare_priv.h"
#include "glare/kernel_rows.h"
#include "glare/far_field/far_field.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MAX_CENTER = 1 << 20 }; // pixels; a centre farther away meets no frame

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

/* Sums of one row. The rows' sums are added up in order, so that the total is
 * the same for any number of threads. */
struct row_sums {
    double sum[3];
    float peak;                  // largest magnitude
    int x0, x1;                  // columns that are not zero, half-open
    int bad_x, bad_c;            // a sample that is NaN or Inf; x -1: none
    bool coloured;               // the channels differ
};

struct raw_sums {
    const struct raw_kernel *raw;
    struct row_sums *row;
};

static void sum_raw_row(void *ctx, int y, int thread)
{
    const struct raw_sums *const s = ctx;
    const int w = s->raw->w;
    const size_t at = (size_t) y * (size_t) w;
    struct row_sums r = {.x0 = w, .x1 = 0, .bad_x = -1};
    (void) thread;
    for (int c = 0; c < 3; c++) {
        const float *const v = s->raw->in.c[c] + at;
        int last = w;
        r.coloured |= memcmp(v, s->raw->in.c[0] + at, (size_t) w * sizeof *v);
        for (int x = 0; x < w; x++) {
            r.sum[c] += (double) v[x];
            r.peak = gp_maxf(fabsf(v[x]), r.peak);
            if (!isfinite(v[x])) {
                r.bad_x = x;
                r.bad_c = c;
            }
        }
        while (last > r.x1 && v[last - 1] == 0.0f)
            last--;
        r.x1 = last;
        for (last = 0; last < r.x0 && v[last] == 0.0f;)
            last++;
        r.x0 = last;
    }
    s->row[y] = r;
}

/* Adds all rows up into *all, whose x0, x1 are not used; *box gets the
 * smallest rectangle that holds all samples that are not zero.
 * Errors: GP_ERR_DATA a sample is not finite. */
static gp_status sum_raw(const struct gp_log *log, const struct raw_kernel *raw,
                         struct row_sums *all, struct gp_rect *box)
{
    struct raw_sums s = {raw, NULL};
    gp_status st =
        gp_alloc(log, raw->name, (size_t) raw->h, sizeof *s.row, &s.row);
    if (st)
        return st;
    gp_parallel_do(raw->h, sum_raw_row, &s);
    *all = (struct row_sums) {0};
    *box = (struct gp_rect) {raw->w, raw->h, 0, 0};
    for (int y = 0; y < raw->h && !st; y++) {
        const struct row_sums *const r = &s.row[y];
        if (r->bad_x >= 0) {
            const size_t at = (size_t) y * (size_t) raw->w + (size_t) r->bad_x;
            st = gp_fail(log, GP_ERR_DATA,
                         "%s: the kernel has a non-finite value (%g in channel "
                         "%c, column %d, row %d); replace it by a finite one",
                         raw->name, (double) raw->in.c[r->bad_c][at],
                         "RGB"[r->bad_c], r->bad_x, y);
        }
        for (int c = 0; c < 3; c++)
            all->sum[c] += r->sum[c];
        all->peak = r->peak > all->peak ? r->peak : all->peak;
        all->coloured |= r->coloured;
        if (r->x0 < r->x1) {
            box->x0 = r->x0 < box->x0 ? r->x0 : box->x0;
            box->x1 = r->x1 > box->x1 ? r->x1 : box->x1;
            box->y0 = y < box->y0 ? y : box->y0;
            box->y1 = y + 1;
        }
    }
    gp_free(s.row);
    return st;
}

static gp_status find_factor(const struct gp_log *log,
    const struct raw_kernel *raw, enum gp_normalize normalize,
    const struct row_sums *all, double *factor)
{
    *factor = 1.0;
    if (!(all->peak > 0.0f))
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the kernel is zero everywhere (%dx%d); use an "
                       "image that has light", raw->name, raw->w, raw->h);
    if (normalize == GP_NORMALIZE_NONE) {
        if (all->peak >= FLT_MIN)
            return GP_OK;
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the kernel is too faint (its largest value is %g, "
                       "those under %.2g count as 0); scale it up", raw->name,
                       (double) all->peak, (double) FLT_MIN);
    }
    double sum = 0.0;
    for (int c = 0; c < 3; c++)
        sum += (double) raw->luminance[c] * all->sum[c];
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

struct cutting {
    const struct raw_kernel *raw;
    struct gp_rect box;
    double factor;
    struct gp_kernel *k;
    struct gp_cut_row (*row)[3];
};

/* Scales a row, in place where the planes are the raw kernel's own. */
static void cut_row(void *ctx, int y, int thread)
{
    const struct cutting *const m = ctx;
    const size_t from = (size_t) (m->box.y0 + y) * (size_t) m->raw->w +
                        (size_t) m->box.x0;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        m->row[y][c] = gp_row_cut(m->raw->in.c[c] + from, m->k->w, m->k->cx,
                                  m->factor, m->k->k.c[c] +
                                      (size_t) y * (size_t) m->k->w);
        m->k->lit[(size_t) c * (size_t) m->k->h + (size_t) y] =
            m->row[y][c].lit;
    }
}

/* Adds up the sums of the rows of channel c. */
static void add_rows(const struct cutting *m, int c, struct gp_kernel *k)
{
    struct gp_quarter_sums q = {0};
    double square = 0.0;
    for (int y = 0; y < k->h; y++) {
        const struct gp_cut_row *const r = &m->row[y][c];
        k->sum[c] += r->sum;
        square += r->square;
        k->norm1[c] += r->magnitude;
        k->faint[c] += r->faint;
        k->negative |= r->negative;
        gp_quarter_add(&q, r->side, y <= k->cy, y >= k->cy);
    }
    k->norm2[c] = sqrt(square);
    k->quarter_square[c] = gp_quarter_least(q.square);
    k->quarter_sum[c] = gp_quarter_least(q.sum);
}

/* Takes raw->in when it is owned, also on failure. */
static gp_status make_kernel(const struct gp_log *log,
    enum gp_normalize normalize, struct raw_kernel *raw, struct gp_kernel *out)
{
    gp_status st;
    struct gp_kernel k = {0};
    struct cutting m = {.raw = raw, .k = &k};
    struct row_sums all;

    GP_TRY(sum_raw(log, raw, &all, &m.box));
    GP_TRY(find_factor(log, raw, normalize, &all, &m.factor));
    k.w = gp_rect_w(m.box);
    k.h = gp_rect_h(m.box);
    k.cx = raw->cx - m.box.x0;
    k.cy = raw->cy - m.box.y0;
    k.grey = !all.coloured;
    k.serial = gp_serial_next();
    GP_TRY(gp_alloc(log, raw->name, (size_t) k.h, sizeof *m.row, &m.row));
    if (raw->owned && k.w == raw->w && k.h == raw->h) {
        k.k = raw->in;
        raw->owned = false; // they are the kernel's
    } else {
        GP_TRY(gp_planes_make(log, raw->name, (size_t) k.w * (size_t) k.h,
                              &k.k));
    }
    GP_TRY(gp_alloc(log, raw->name, 3 * (size_t) k.h, sizeof *k.lit, &k.lit));
    gp_parallel_do(k.h, cut_row, &m);
    for (int c = 0; c < 3; c++)
        add_rows(&m, c, &k);
    for (int c = 0; c < 3 && k.negative; c++)
        k.quarter_square[c] = k.quarter_sum[c] = 0.0;
    *out = k;
    k = (struct gp_kernel) {0};
out:
    gp_free(m.row);
    gp_kernel_free(&k);
    if (raw->owned)
        gp_planes_free(&raw->in);
    return st;
}

// -- rotated ------------------------------------------------------------------

/* Makes the kernel, rotated when p->rotate says so. Takes raw->in when it is
 * owned, also on failure. */
static gp_status make_rotated(const struct gp_log *log,
                              const struct gp_kernel_params *p,
                              struct raw_kernel *raw, struct gp_kernel *out)
{
    gp_status st;
    struct gp_kernel flat = {0};
    struct gp_rotated rotated = {0};
    struct raw_kernel t = {.name = raw->name, .owned = true,
                           .luminance = raw->luminance};
    struct gp_unturned u, *kept = NULL;
    const bool right = gp_rotate_angle(p->rotate, &u);
    const double down = p->scale > 0.0 ? p->scale : 1.0;
    const double across = p->aspect > 0.0 ? down / p->aspect : down;
    const bool sized = down != 1.0 || across != 1.0;
    if (right && u.cos == 1.0 && !sized)
        return make_kernel(log, p->normalize, raw, out);
    GP_TRY(make_kernel(log, GP_NORMALIZE_NONE, raw, &flat));
    u.w = flat.w, u.h = flat.h, u.cx = flat.cx, u.cy = flat.cy, u.k = flat.k;
    GP_TRY(gp_rotate(log, raw->name, &u, flat.grey, &rotated));
    t.in = rotated.k;
    if (sized)
        GP_TRY(gp_resample(log, raw->name, across, down, flat.grey, &rotated));
    t.w = rotated.w, t.h = rotated.h, t.cx = rotated.cx, t.cy = rotated.cy;
    t.in = rotated.k;
    if (right || sized) {
        st = make_kernel(log, p->normalize, &t, out);
        goto out;
    }
    GP_TRY(gp_alloc(log, raw->name, 1, sizeof u, &kept));
    if (p->normalize == GP_NORMALIZE_LUMINANCE) {
        // u is scaled so that its rotated form is normalised: both stay samples
        // of the same float values
        struct row_sums all;
        struct gp_rect box;
        double factor;
        GP_TRY(sum_raw(log, &t, &all, &box));
        GP_TRY(find_factor(log, &t, GP_NORMALIZE_LUMINANCE, &all, &factor));
        const size_t n = (size_t) u.w * (size_t) u.h;
        for (int c = 0; c < 3; c++) {
            for (size_t i = 0; i < n; i++)
                u.k.c[c][i] = (float) ((double) u.k.c[c][i] * factor);
        }
        gp_planes_free(&t.in);
        GP_TRY(gp_rotate(log, t.name, &u, flat.grey, &rotated));
        t.in = rotated.k;
    }
    GP_TRY(make_kernel(log, GP_NORMALIZE_NONE, &t, out));
    *kept = u;
    out->unturned = kept;
    kept = NULL;
    flat.k = (struct gp_planes) {0}; // they are the kernel's
out:
    if (t.owned)
        gp_planes_free(&t.in);
    gp_kernel_free(&flat);
    gp_free(kept);
    return st;
}

// -- primaries ----------------------------------------------------------------

struct converting {
    const struct gp_planes *in;
    struct gp_planes out;
    int w;
    double m[9];
    float luminance[3];          // weights of the primaries of `out`
};

static void convert_row(void *ctx, int y, int thread)
{
    const struct converting *const t = ctx;
    const double *const m = t->m;
    (void) thread;
    for (int x = 0; x < t->w; x++) {
        const size_t i = (size_t) y * (size_t) t->w + (size_t) x;
        const double r = (double) t->in->c[0][i], g = (double) t->in->c[1][i],
                     b = (double) t->in->c[2][i];
        double v[3] = {r, g, b};
        if (isfinite(r) && isfinite(g) && isfinite(b)) { // else an error later
            for (int c = 0; c < 3; c++)
                v[c] = m[3 * c] * r + m[3 * c + 1] * g + m[3 * c + 2] * b;
            if (r >= 0.0 && g >= 0.0 && b >= 0.0) // lobes stay
                gp_gamut_fold(t->luminance, v);
        }
        for (int c = 0; c < 3; c++)
            t->out.c[c][i] = (float) v[c];
    }
}

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
    struct converting t = {.in = &raw->in, .w = raw->w};
    if (memcmp(from, to, 8 * sizeof *from) == 0)
        return GP_OK;
    gp_luminance_weights(to, luminance);
    raw->luminance = luminance;
    if (is_grey(raw))
        return GP_OK;
    if (!gp_spectrum_to_spectrum(from, to, t.m))
        return gp_fail(log, GP_ERR_DATA, "%s: the kernel's primaries (%g,%g "
                       "%g,%g %g,%g, white %g,%g) cannot become the frame's "
                       "(%g,%g %g,%g %g,%g, white %g,%g); repair chromaticities",
                       raw->name, (double) from[0], (double) from[1],
                       (double) from[2], (double) from[3], (double) from[4],
                       (double) from[5], (double) from[6], (double) from[7],
                       (double) to[0], (double) to[1], (double) to[2],
                       (double) to[3], (double) to[4], (double) to[5],
                       (double) to[6], (double) to[7]);
    memcpy(t.luminance, luminance, sizeof t.luminance);
    gp_status st = gp_planes_make(log, raw->name,
                                  (size_t) raw->w * (size_t) raw->h, &t.out);
    if (st)
        return st;
    gp_parallel_do(raw->h, convert_row, &t);
    raw->in = t.out;
    raw->owned = true;
    return GP_OK;
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

void gp_kernel_free(struct gp_kernel *k)
{
    gp_free(k->origin);
    if (k->unturned)
        gp_planes_free(&k->unturned->k);
    gp_free(k->unturned);
    gp_far_free(k->tail);
    gp_free(k->lit);
    gp_planes_free(&k->k);
    *k = (struct gp_kernel) {0};
}
