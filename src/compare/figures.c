// SPDX-License-Identifier: Apache-2.0
#include "compare/compare.h"

#include "core/colour.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <math.h>
#include <string.h>

// -- pairs of channels -------------------------------------------------------

/* Returns the first channel of that name; -1: none. */
static int find_channel(const struct glarepp_stored *image, const char *name)
{
    for (int i = 0; i < image->channels; i++) {
        if (strcmp(image->channel[i].name, name) == 0)
            return i;
    }
    return -1;
}

static bool is_lit(const struct glarepp_stored *image)
{
    return image->light[0] && image->light[1] && image->light[2];
}

gp_status gp_compare_match_make(
    const struct gp_log *log, const struct glarepp_stored *a,
    const struct glarepp_stored *b, struct gp_compare_match *m)
{
    static const char *const first[] = {"R", "G", "B", "A"};
    *m = (struct gp_compare_match) {
        .a = a,
        .b = b,
        .lit = is_lit(a) && is_lit(b),
        .window = gp_rect_join(a->data, b->data),
    };
    gp_luminance_weights(a->primaries ? a->primaries : gp_rec709_chromaticities,
                         m->luminance);
    const size_t n = (size_t) a->channels + (size_t) b->channels + 1;
    gp_status st;
    GP_TRY(gp_alloc(log, "channels", n, sizeof *m->name, &m->name));
    GP_TRY(gp_alloc(log, "channels", n, 2 * sizeof(int), &m->in[0]));
    int *const in_a = m->in[0], *const in_b = m->in[1] = m->in[0] + n;
    for (int i = -4; i < a->channels + b->channels; i++) {
        const char *const name = i < 0 ? first[i + 4]
                                 : i < a->channels
                                     ? a->channel[i].name
                                     : b->channel[i - a->channels].name;
        const int at[] = {find_channel(a, name), find_channel(b, name)};
        // as idiff has them: the first of equals
        bool known = at[0] < 0 && at[1] < 0;
        for (int k = 0; k < m->pairs && !known; k++)
            known = strcmp(m->name[k], name) == 0;
        if (known)
            continue;
        m->name[m->pairs] = name;
        in_a[m->pairs] = at[0];
        in_b[m->pairs++] = at[1];
    }
    // by number where no name fits; what gave its channel away goes
    int kept = 0;
    for (int i = 0, k = 0; i < m->pairs; i++) {
        while (in_b[i] < 0 && k < m->pairs && in_a[k] >= 0)
            k++;
        if (in_b[i] < 0 && k < m->pairs) {
            in_b[i] = in_b[k];
            in_b[k++] = -1;
        }
    }
    for (int i = 0; i < m->pairs; i++) {
        if (in_a[i] < 0 && in_b[i] < 0)
            continue;
        m->name[kept] = in_a[i] < 0 ? b->channel[in_b[i]].name : m->name[i];
        in_a[kept] = in_a[i];
        in_b[kept++] = in_b[i];
    }
    m->pairs = kept;
out:
    return st;
}

void gp_compare_match_free(struct gp_compare_match *m)
{
    gp_free(m->name);
    gp_free(m->in[0]);
    *m = (struct gp_compare_match) {0};
}

// -- values ------------------------------------------------------------------

/* The index of a pixel of the window in an image, or -1 outside it. */
static int64_t index_at(const struct glarepp_stored *image, int x, int y)
{
    const struct gp_rect r = image->data;
    if (x < r.x0 || x >= r.x1 || y < r.y0 || y >= r.y1)
        return -1;
    return (int64_t) (y - r.y0) * gp_rect_w(r) + (x - r.x0);
}

/* The samples of a pixel: `n` from *from on; of a flat one 1, outside 0. */
static int64_t samples_at(const struct glarepp_stored *image, int64_t at,
                          int64_t *from)
{
    *from = at;
    if (at < 0 || !image->first)
        return at >= 0;
    *from = image->first[at];
    return image->first[at + 1] - image->first[at];
}

static double value_at(const struct glarepp_stored *image, int channel,
                       int64_t at)
{
    if (channel < 0 || at < 0)
        return 0.0;
    const struct glarepp_channel *const c = &image->channel[channel];
    return c->is_uint ? (double) ((const uint32_t *) c->v)[at]
                    : (double) ((const float *) c->v)[at];
}

static bool same_nonfinite(double a, double b)
{
    return (isnan(a) && isnan(b)) || (isinf(a) && a == b);
}

/* Luminance of a pixel, by the weights of the first image. */
static double luminance(const struct gp_compare_match *m,
                        const struct glarepp_stored *image, int64_t at)
{
    double y = 0.0;
    for (int c = 0; c < 3 && at >= 0; c++)
        y += (double) m->luminance[c] * (double) image->light[c][at];
    return y;
}

// -- sums --------------------------------------------------------------------

/* Of a row. */
struct sums {
    double error, square, reference; // of |a-b|, (a-b)^2, a^2
    double peak;                     // largest |value|
    double max;
    int x, channel;                  // of max
    double worst_a, worst_b;
    long long nonfinite, warned, failed;
    long long uneven;
    int uneven_x;                    // of the first
    double bright, relative;         // largest Y of a; max_rel
};

struct measure {
    const struct glarepp_compare_params *limits;
    const struct gp_compare_match *m;
    struct sums *row;
    double bright;                   // of all rows
};

static void note_worst(struct sums *s, double error, int x, int channel,
                       double a, double b)
{
    if (!(error > s->max))
        return;
    s->max = error;
    s->x = x;
    s->channel = channel;
    s->worst_a = a;
    s->worst_b = b;
}

static void sum_row(void *ctx, int row, int thread)
{
    (void) thread;
    const struct measure *const t = ctx;
    const struct gp_compare_match *const m = t->m;
    struct sums *const s = &t->row[row];
    const int y = m->window.y0 + row;
    const struct glarepp_compare_params *const l = t->limits;
    for (int x = m->window.x0; x < m->window.x1; x++) {
        int64_t at_a, at_b;
        const int64_t in_a = samples_at(m->a, index_at(m->a, x, y), &at_a);
        const int64_t in_b = samples_at(m->b, index_at(m->b, x, y), &at_b);
        bool failed = m->a->first && in_a != in_b, warned = failed;
        if (failed && !s->uneven++)
            s->uneven_x = x;
        const int64_t most = in_a > in_b ? in_a : in_b;
        for (int64_t k = 0; k < most; k++) for (int c = 0; c < m->pairs; c++) {
            const int ca = m->in[0][c], cb = m->in[1][c];
            const double a = value_at(m->a, ca, k < in_a ? at_a + k : -1);
            const double b = value_at(m->b, cb, k < in_b ? at_b + k : -1);
            if (!isfinite(a) || !isfinite(b)) {
                if (same_nonfinite(a, b))
                    continue;
                s->nonfinite++;
                failed = warned = true;
                note_worst(s, (double) INFINITY, x, c, a, b);
                continue;
            }
            const bool uints = (ca >= 0 && m->a->channel[ca].is_uint) ||
                               (cb >= 0 && m->b->channel[cb].is_uint);
            // floats are subtracted as floats: idiff's figures to the last
            // digit
            const double f = uints ? fabs(a - b)
                                   : (double) fabsf((float) a - (float) b);
            const double mean = 0.5 * (fabs(a) + fabs(b));
            const double rel = mean > 0.0 ? f / mean : 0.0;
            s->error += f;
            s->square += f * f;
            s->reference += a * a;
            s->peak = fmax(s->peak, fmax(fabs(a), fabs(b)));
            note_worst(s, f, x, c, a, b);
            warned = warned || (f > (double) l->warn &&
                                rel > (double) l->warn_relative);
            failed = failed || (f > (double) l->fail &&
                                rel > (double) l->fail_relative);
        }
        s->failed += failed;
        s->warned += warned;
        const double bright =
            m->lit ? luminance(m, m->a, index_at(m->a, x, y)) : 0.0;
        if (isfinite(bright))
            s->bright = fmax(s->bright, bright);
    }
}

static void relative_row(void *ctx, int row, int thread)
{
    (void) thread;
    const struct measure *const t = ctx;
    const struct gp_compare_match *const m = t->m;
    const int y = m->window.y0 + row;
    for (int x = m->window.x0; x < m->window.x1; x++) {
        const double a = luminance(m, m->a, index_at(m->a, x, y));
        const double b = luminance(m, m->b, index_at(m->b, x, y));
        double rel = 0.0;
        if (isfinite(a) && isfinite(b))
            rel = a == b ? 0.0 : fabs(a - b) / (fmax(a, 0.0) +
                                                1e-6 * t->bright);
        else if (!same_nonfinite(a, b))
            rel = (double) INFINITY;
        t->row[row].relative = fmax(t->row[row].relative, rel);
    }
}

// -- figures -----------------------------------------------------------------

gp_status gp_compare_measure(
    const struct gp_log *log, const struct glarepp_compare_params *limits,
    const struct gp_compare_match *m, struct glarepp_compare_facts *out)
{
    const int rows = gp_rect_h(m->window);
    struct measure t = {.limits = limits, .m = m};
    gp_status st = gp_alloc_zero(log, "sums", (size_t) rows, sizeof *t.row,
                                 &t.row);
    if (st)
        return st;
    gp_parallel_do(rows, sum_row, &t);
    for (int y = 0; y < rows; y++)
        t.bright = fmax(t.bright, t.row[y].bright);
    if (m->lit)
        gp_parallel_do(rows, relative_row, &t);
    // rows added up, and the first of the largest errors
    const double values = (double) gp_rect_w(m->window) * (double) rows *
                          (double) m->pairs;
    double error = 0.0, square = 0.0, reference = 0.0, peak = 1.0;
    *out = (struct glarepp_compare_facts) {
        .window = m->window,
        .pairs = m->pairs,
        .pair = m->name,
        .in_a = m->in[0],
        .in_b = m->in[1],
        .lit = m->lit,
        .pixels = (long long) gp_rect_w(m->a->data) * gp_rect_h(m->a->data),
        .x = m->window.x0,
        .y = m->window.y0,
        .seen = -1,
        .max_rel = m->lit ? 0.0 : (double) NAN,
    };
    for (int y = 0; y < rows; y++) {
        const struct sums *const s = &t.row[y];
        error += s->error;
        square += s->square;
        reference += s->reference;
        peak = fmax(peak, s->peak);
        out->nonfinite += s->nonfinite;
        out->failed += s->failed;
        out->warned += s->warned;
        if (s->uneven && !out->uneven) {
            out->uneven_x = s->uneven_x;
            out->uneven_y = m->window.y0 + y;
        }
        out->uneven += s->uneven;
        if (m->lit)
            out->max_rel = fmax(out->max_rel, s->relative);
        if (!(s->max > out->max))
            continue;
        out->max = s->max;
        out->x = s->x;
        out->y = m->window.y0 + y;
        out->channel = s->channel;
        out->worst_a = s->worst_a;
        out->worst_b = s->worst_b;
    }
    gp_free(t.row);
    out->mean = error / values;
    out->rms = sqrt(square / values);
    out->psnr = 20.0 * log10(peak / out->rms);
    out->rel_l2 = reference > 0.0 ? sqrt(square / reference) : sqrt(square);
    return GP_OK;
}

void gp_compare_judge(const struct glarepp_compare_params *limits,
                      struct glarepp_compare_facts *f)
{
    const double hundredth = (double) f->pixels / 100.0;
    const bool eye = f->seen >= 0;
    const double none = (double) NAN;
    const double failed = (double) (eye ? f->seen : f->failed);
    const double may =
        limits->allow_failures < 0 ? (double) INFINITY : limits->allow_failures;
    const bool more = failed > may;
    const struct {
        bool judges;
        double found, limit;
        int over;
    } gate[] = {
        {more, failed, fmax(may, (double) limits->fail_percent * hundredth),
         GP_COMPARE_FAILURE},
        {more, f->max, eye ? none : (double) limits->hard_fail,
         GP_COMPARE_FAILURE},
        {true, f->rel_l2, (double) limits->fail_rel, GP_COMPARE_FAILURE},
        {true, f->has_flip ? f->flip : none, (double) limits->fail_flip,
         GP_COMPARE_FAILURE},
        {more, (double) f->warned,
         eye ? none : (double) limits->warn_percent * hundredth,
         GP_COMPARE_WARNING},
        {more, f->max, eye ? none : (double) limits->hard_warn,
         GP_COMPARE_WARNING},
    };
    f->result = GP_COMPARE_MATCH;
    for (size_t i = 0; i < sizeof gate / sizeof *gate; i++) {
        const bool over = gate[i].judges && gate[i].found > gate[i].limit;
        f->gate[i].found = gate[i].found;
        f->gate[i].limit = gate[i].limit;
        f->gate[i].result = over ? gate[i].over : GP_COMPARE_MATCH;
        f->result = gp_max(f->result, f->gate[i].result);
    }
}

// -- FLIP --------------------------------------------------------------------

gp_status gp_compare_light(
    const struct gp_log *log, const struct gp_compare_match *m,
    const struct glarepp_stored *image, bool hdr, struct gp_planes *out)
{
    static const float BRIGHTEST = 65504.0f;
    const size_t w = (size_t) gp_rect_w(m->window);
    const size_t pixels = w * (size_t) gp_rect_h(m->window);
    gp_status st = gp_planes_make(log, "light", pixels, out);
    for (int c = 0; c < 3 && !st; c++) {
        float *to = out->c[c];
        for (int y = m->window.y0; y < m->window.y1; y++, to += w) {
            const int64_t at = index_at(image, image->data.x0, y);
            memset(to, 0, w * sizeof *to);
            if (at >= 0)
                memcpy(to + (image->data.x0 - m->window.x0),
                       image->light[c] + at,
                       (size_t) gp_rect_w(image->data) * sizeof *to);
        }
        for (size_t i = 0; i < pixels && hdr; i++) {
            if (isinf(out->c[c][i]) && out->c[c][i] > 0.0f)
                out->c[c][i] = BRIGHTEST;
        }
    }
    return st;
}

gp_status gp_compare_flip(
    const struct gp_log *log, const struct glarepp_compare_params *p,
    const struct gp_compare_match *m, struct glarepp_compare_facts *out,
    float **map)
{
    const int w = gp_rect_w(m->window), h = gp_rect_h(m->window);
    const size_t pixels = (size_t) w * (size_t) h;
    const bool hdr = !(m->a->integers && m->b->integers);
    struct gp_flip_exposures e = {p->start, p->stop, p->exposures};
    struct gp_planes a = {0}, b = {0};
    gp_status st;
    GP_TRY(gp_compare_light(log, m, m->a, hdr, &a));
    GP_TRY(gp_compare_light(log, m, m->b, hdr, &b));
    GP_TRY(gp_alloc(log, "FLIP map", pixels, sizeof **map, map));
    if (hdr && !e.count)
        GP_TRY(gp_flip_exposures_find(log, pixels, &a, &e));
    GP_TRY(gp_flip(log, w, h, &a, &b, hdr ? &e : NULL, *map, &out->flip));
    out->has_flip = true;
    out->hdr = hdr;
    if (hdr) {
        out->start = e.start;
        out->stop = e.stop;
        out->exposures = e.count;
    }
out:
    gp_planes_free(&a);
    gp_planes_free(&b);
    return st;
}

// -- pictures ----------------------------------------------------------------

void gp_compare_heatmap(const float *map, size_t n, const struct gp_planes *to)
{
    // sRGB-encoded, least squares of degree 6, a row for each power
    static const float power[7][3] = {
        {-0.002136485f, -0.000749655f, -0.005386128f},
        {0.251660541f, 0.677523244f, 2.494026599f},
        {8.353717279f, -3.577719515f, 0.314467903f},
        {-27.66873309f, 14.26473078f, -13.64921319f},
        {52.17613981f, -27.94360607f, 12.94416944f},
        {-50.76852536f, 29.04658282f, 4.23415299f},
        {18.65570507f, -11.48977352f, -5.60196151f},
    };
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++) {
            const float t = gp_clamp01(map[i]);
            float sum = power[6][c];
            for (int k = 5; k >= 0; k--)
                sum = sum * t + power[k][c];
            to->c[c][i] = gp_srgb_decode(gp_clamp01(sum));
        }
    }
}

void gp_compare_subtract(const struct gp_compare_match *m, int pair,
                         bool absolute, float scale, float *to)
{
    for (int y = m->window.y0; y < m->window.y1; y++) {
        for (int x = m->window.x0; x < m->window.x1; x++) {
            const float d =
                (float) (value_at(m->a, m->in[0][pair], index_at(m->a, x, y)) -
                         value_at(m->b, m->in[1][pair], index_at(m->b, x, y)));
            *to++ = (absolute ? fabsf(d) : d) * scale;
        }
    }
}
