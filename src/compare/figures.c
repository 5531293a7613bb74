#include "compare/compare_priv.h"

#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <math.h>
#include <string.h>

// -- pairs of channels -------------------------------------------------------

static const struct gp_stored_channel *find_channel(
    const struct gp_stored_image *image, const char *name)
{
    for (int i = 0; i < image->channels; i++) {
        if (strcmp(image->channel[i].name, name) == 0)
            return &image->channel[i];
    }
    return NULL;
}

gp_status gp_compare_match_make(
    const struct gp_log *log, const struct gp_stored_image *a,
    const struct gp_stored_image *b, struct gp_compare_match *m)
{
    static const char *const first[] = {"R", "G", "B", "A"};
    *m = (struct gp_compare_match) {
        .a = a, .b = b, .lit = a->light[0] && b->light[0],
        .window = {gp_min(a->data.x0, b->data.x0),
                   gp_min(a->data.y0, b->data.y0),
                   gp_max(a->data.x1, b->data.x1),
                   gp_max(a->data.y1, b->data.y1)},
    };
    gp_status st = gp_alloc(log, "channels",
                            (size_t) a->channels + (size_t) b->channels + 1,
                            sizeof *m->pair, &m->pair);
    if (st)
        return st;
    for (int i = -4; i < a->channels + b->channels; i++) {
        const char *const name = i < 0 ? first[i + 4]
                                 : i < a->channels
                                     ? a->channel[i].name
                                     : b->channel[i - a->channels].name;
        const struct gp_compare_pair p = {find_channel(a, name),
                                          find_channel(b, name)};
        bool known = !p.a && !p.b; // as idiff has them: the first of equals
        for (int k = 0; k < m->pairs && !known; k++)
            known = strcmp(gp_compare_name(m, k), name) == 0;
        if (known)
            continue;
        m->pair[m->pairs++] = p;
    }
    // by number where no name fits; what gave its channel away goes
    int kept = 0;
    for (int i = 0, k = 0; i < m->pairs; i++) {
        struct gp_compare_pair *const p = &m->pair[i];
        while (!p->b && k < m->pairs && m->pair[k].a)
            k++;
        if (!p->b && k < m->pairs) {
            p->b = m->pair[k].b;
            m->pair[k++].b = NULL;
        }
    }
    for (int i = 0; i < m->pairs; i++) {
        if (m->pair[i].a || m->pair[i].b)
            m->pair[kept++] = m->pair[i];
    }
    m->pairs = kept;
    return GP_OK;
}

void gp_compare_match_free(struct gp_compare_match *m)
{
    GP_FREE(m->pair);
    m->pairs = 0;
}

const char *gp_compare_name(const struct gp_compare_match *m, int pair)
{
    const struct gp_compare_pair *const p = &m->pair[pair];
    return p->a ? p->a->name : p->b->name;
}

// -- values ------------------------------------------------------------------

/* The index of a pixel of the window in an image, or -1 outside it. */
static int64_t index_at(const struct gp_stored_image *image, int x, int y)
{
    const struct gp_rect r = image->data;
    if (x < r.x0 || x >= r.x1 || y < r.y0 || y >= r.y1)
        return -1;
    return (int64_t) (y - r.y0) * gp_rect_w(r) + (x - r.x0);
}

/* The samples of a pixel: `n` from *from on; of a flat one 1, outside 0. */
static int64_t samples_at(const struct gp_stored_image *image, int64_t at,
                          int64_t *from)
{
    *from = at;
    if (at < 0 || !image->first)
        return at >= 0;
    *from = image->first[at];
    return image->first[at + 1] - image->first[at];
}

static double value_at(const struct gp_stored_channel *c, int64_t at)
{
    if (!c || at < 0)
        return 0.0;
    return c->is_uint ? (double) ((const uint32_t *) c->v)[at]
                    : (double) ((const float *) c->v)[at];
}

double gp_compare_value(const struct gp_compare_match *m, bool of_b, int pair,
                        int x, int y)
{
    const struct gp_compare_pair *const p = &m->pair[pair];
    return of_b ? value_at(p->b, index_at(m->b, x, y))
                : value_at(p->a, index_at(m->a, x, y));
}

static bool same_nonfinite(double a, double b)
{
    return (isnan(a) && isnan(b)) || (isinf(a) && a == b);
}

/* Luminance of a pixel, by the weights of the first image. */
static double luminance(const struct gp_compare_match *m,
                        const struct gp_stored_image *image, int64_t at)
{
    double y = 0.0;
    for (int c = 0; c < 3 && at >= 0; c++)
        y += (double) m->a->luminance[c] * (double) image->light[c][at];
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
    const struct gp_compare_params *limits;
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
    const struct gp_compare_params *const l = t->limits;
    for (int x = m->window.x0; x < m->window.x1; x++) {
        int64_t at_a, at_b;
        const int64_t in_a = samples_at(m->a, index_at(m->a, x, y), &at_a);
        const int64_t in_b = samples_at(m->b, index_at(m->b, x, y), &at_b);
        bool failed = m->a->first && in_a != in_b, warned = failed;
        if (failed && !s->uneven++)
            s->uneven_x = x;
        const int64_t most = in_a > in_b ? in_a : in_b;
        for (int64_t k = 0; k < most; k++) for (int c = 0; c < m->pairs; c++) {
            const struct gp_compare_pair *const p = &m->pair[c];
            const double a = value_at(p->a, k < in_a ? at_a + k : -1);
            const double b = value_at(p->b, k < in_b ? at_b + k : -1);
            if (!isfinite(a) || !isfinite(b)) {
                if (same_nonfinite(a, b))
                    continue;
                s->nonfinite++;
                failed = warned = true;
                note_worst(s, (double) INFINITY, x, c, a, b);
                continue;
            }
            const bool uints = (p->a && p->a->is_uint) ||
                               (p->b && p->b->is_uint);
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
    const struct gp_log *log, const struct gp_compare_params *limits,
    const struct gp_compare_match *m, struct gp_compare_figures *out)
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
    *out = (struct gp_compare_figures) {
        .pixels = (long long) gp_rect_w(m->a->data) * gp_rect_h(m->a->data),
        .x = m->window.x0, .y = m->window.y0, .seen = -1,
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

enum gp_compare_result gp_compare_judge(const struct gp_compare_params *limits,
    const struct gp_compare_figures *f, const struct gp_compare_flip *flip)
{
    const double hundredth = (double) f->pixels / 100.0;
    const bool eye = f->seen >= 0;
    const long long failed = eye ? f->seen : f->failed;
    if (f->rel_l2 > (double) limits->fail_rel ||
        (flip->known && flip->mean > (double) limits->fail_flip))
        return GP_COMPARE_FAILURE;
    if (limits->allow_failures < 0 || failed <= limits->allow_failures)
        return GP_COMPARE_MATCH;
    if ((double) failed > (double) limits->fail_percent * hundredth ||
        (!eye && f->max > (double) limits->hard_fail))
        return GP_COMPARE_FAILURE;
    return !eye && ((double) f->warned >
                        (double) limits->warn_percent * hundredth ||
                    f->max > (double) limits->hard_warn)
               ? GP_COMPARE_WARNING : GP_COMPARE_MATCH;
}

// -- FLIP --------------------------------------------------------------------

gp_status gp_compare_light(
    const struct gp_log *log, const struct gp_compare_match *m,
    const struct gp_stored_image *image, bool hdr, struct gp_planes *out)
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
    const struct gp_log *log, const struct gp_compare_params *p,
    const struct gp_compare_match *m, struct gp_compare_flip *out)
{
    const int w = gp_rect_w(m->window), h = gp_rect_h(m->window);
    const size_t pixels = (size_t) w * (size_t) h;
    const double *const e = p->flip_exposures.v;
    struct gp_planes a = {0}, b = {0};
    gp_status st;
    *out = (struct gp_compare_flip) {
        .hdr = !(m->a->integers && m->b->integers),
    };
    if (p->no_flip || !m->lit)
        return GP_OK;
    GP_TRY(gp_compare_light(log, m, m->a, out->hdr, &a));
    GP_TRY(gp_compare_light(log, m, m->b, out->hdr, &b));
    GP_TRY(gp_alloc(log, "FLIP map", pixels, sizeof *out->map, &out->map));
    if (out->hdr && p->flip_exposures.n)
        out->exposures = (struct gp_flip_exposures) {(float) e[0],
                                                     (float) e[1], (int) e[2]};
    else if (out->hdr)
        GP_TRY(gp_flip_exposures_find(log, pixels, &a, &out->exposures));
    GP_TRY(out->hdr ? gp_flip_hdr(log, w, h, &a, &b, GP_FLIP_PPD,
                                  &out->exposures, out->map, &out->mean)
                    : gp_flip_ldr(log, w, h, &a, &b, GP_FLIP_PPD, out->map,
                                  &out->mean));
    out->known = true;
out:
    gp_planes_free(&a);
    gp_planes_free(&b);
    return st;
}

void gp_compare_flip_free(struct gp_compare_flip *f)
{
    GP_FREE(f->map);
    f->known = false;
}

/* Luminance at full resolution, blurred once more from level to level by a
 * kernel of 5x5; the levels are octaves of spatial frequency. A tile is
 * made with the surroundings that its last level needs. */
// -- visible pixels ----------------------------------------------------------
//
// Yee, A Perceptual Metric for Production Testing, journal of graphics tools
// 9(4), 2004, as idiff -p counts them. A difference of luminance is seen over a
// threshold, which light around and details that mask it raise; then one of
// colour. Both pictures are seen with 1.0 shown as 100 cd/m2, over a field of
// view of 45 degrees.

enum { LEVELS = 8, BANDS = LEVELS - 2, REACH = 2, TILE = 64 };
enum { MARGIN = REACH * (LEVELS - 1), SIDE = TILE + 2 * MARGIN };
struct tile {
    float level[2][LEVELS][SIDE][SIDE]; // of a and b, cd/m2
    float rows[SIDE][SIDE];             // a level blurred along x
};

static const double DISPLAY_WHITE = 100.0; // cd/m2
static const double FIELD = 45.0;          // degrees
static const double PI = 3.14159265358979323846;

struct view {
    int w, h;
    const struct gp_planes *image[2];
    struct tile *tile;        // of each thread
    long long *seen;          // of each tile
    double frequency[BANDS];  // cycles a degree
    double sharpness[BANDS];  // of the eye there, to that at its best
    int adaptation;           // level that is a degree wide
};

// -- the eye -----------------------------------------------------------------

/* Contrast sensitivity at `cycles` a degree (Barten, SPIE 1989). */
static double sensitivity(double cycles, double luminance)
{
    const double a = 440.0 * pow(1.0 + 0.7 / luminance, -0.2);
    const double b = 0.3 * pow(1.0 + 100.0 / luminance, 0.15);
    return a * cycles * exp(-b * cycles) * sqrt(1.0 + 0.06 * exp(b * cycles));
}

/* The share by which a pattern hides another (Daly 1993). */
static double masking(double contrast)
{
    const double a = pow(392.498 * contrast, 0.7);
    return pow(1.0 + pow(0.0153 * a, 4.0), 0.25);
}

/* The least difference that is seen, in cd/m2, at an adaptation luminance in
 * cd/m2 (Ward Larson et al. 1997). */
static double threshold(double adaptation)
{
    const double x = log10(adaptation);
    return pow(10.0, x < -3.94     ? -2.86
                     : x < -1.44   ? pow(0.405 * x + 1.6, 2.18) - 2.86
                     : x < -0.0184 ? x - 0.395
                     : x < 1.9     ? pow(0.249 * x + 0.65, 2.7) - 0.72
                                   : x - 1.255);
}

/* CIE a* and b* of linear BT.709. */
static void opponents(const float rgb[3], double ab[2])
{
    // IEC 61966-2-1
    static const double xyz[3][3] = {
        {0.4124, 0.3576, 0.1805},
        {0.2126, 0.7152, 0.0722},
        {0.0193, 0.1192, 0.9505},
    };
    double f[3];
    for (int i = 0; i < 3; i++) {
        double sum = 0.0, white = 0.0;
        for (int c = 0; c < 3; c++) {
            sum += xyz[i][c] * (double) rgb[c];
            white += xyz[i][c];
        }
        const double t = sum / white;
        f[i] = t > 216.0 / 24389.0 ? cbrt(t)
                                   : (24389.0 / 27.0 * t + 16.0) / 116.0;
    }
    ab[0] = 500.0 * (f[0] - f[1]);
    ab[1] = 200.0 * (f[1] - f[2]);
}

// -- tiles -------------------------------------------------------------------

/* Fills the levels; beyond the border the outermost pixels are repeated. */
static void make_levels(const struct view *v, int x0, int y0, struct tile *t)
{
    static const float kernel[] = {0.05f, 0.25f, 0.4f, 0.25f, 0.05f};
    for (int k = 0; k < 2; k++) {
        float (*const level)[SIDE][SIDE] = t->level[k];
        float *const *const light = v->image[k]->c;
        for (int y = 0; y < SIDE; y++) {
            const int from = gp_min(gp_max(y0 - MARGIN + y, 0), v->h - 1);
            for (int x = 0; x < SIDE; x++) {
                const int at = gp_min(gp_max(x0 - MARGIN + x, 0), v->w - 1);
                const size_t i = (size_t) from * (size_t) v->w + (size_t) at;
                const float lum = 0.2126f * light[0][i] +
                                  0.7152f * light[1][i] + 0.0722f * light[2][i];
                level[0][y][x] =
                    lum > 0.0f ? (float) DISPLAY_WHITE * lum : 0.0f;
            }
        }
        for (int n = 1; n < LEVELS; n++) {
            const int edge = REACH * n;
            for (int y = edge - REACH; y < SIDE - edge + REACH; y++) {
                for (int x = edge; x < SIDE - edge; x++) {
                    float sum = 0.0f;
                    for (int i = -REACH; i <= REACH; i++)
                        sum += kernel[i + REACH] * level[n - 1][y][x + i];
                    t->rows[y][x] = sum;
                }
            }
            for (int y = edge; y < SIDE - edge; y++) {
                for (int x = edge; x < SIDE - edge; x++) {
                    float sum = 0.0f;
                    for (int i = -REACH; i <= REACH; i++)
                        sum += kernel[i + REACH] * t->rows[y + i][x];
                    level[n][y][x] = sum;
                }
            }
        }
    }
}

/* True when the pixel at x, y of the tile is seen to differ: its colours are a
 * and b, one of which has other bits. */
static bool is_seen(const struct view *v, const struct tile *t, int x, int y,
                    const float a[3], const float b[3])
{
    double lum[2][LEVELS], contrast[BANDS], sum = 0.0, factor = 0.0;
    double of_a[2], of_b[2];
    for (int n = 0; n < LEVELS; n++) {
        for (int k = 0; k < 2; k++)
            lum[k][n] = (double) t->level[k][n][y][x];
    }
    for (int n = 0; n < BANDS; n++) {
        const double step = fmax(fabs(lum[0][n] - lum[0][n + 1]),
                                 fabs(lum[1][n] - lum[1][n + 1]));
        contrast[n] = step / fmax(fmax(lum[0][n + 2], lum[1][n + 2]), 1e-5);
        sum += contrast[n];
    }
    const double adapt = fmax(0.5 * (lum[0][v->adaptation] +
                                     lum[1][v->adaptation]), 1e-5);
    for (int n = 0; n < BANDS; n++)
        factor += contrast[n] / fmax(sum, 1e-5) / v->sharpness[n] *
                  masking(contrast[n] * sensitivity(v->frequency[n], adapt));
    factor = fmin(fmax(factor, 1.0), 10.0);
    if (fabs(lum[0][0] - lum[1][0]) > factor * threshold(adapt))
        return true;
    // colour, of which the eye sees less in the dark
    opponents(a, of_a);
    opponents(b, of_b);
    const double da = of_a[0] - of_b[0], db = of_a[1] - of_b[1];
    const double dim = adapt < 10.0 ? 0.1 * 0.1 : 1.0;
    return (da * da + db * db) * dim > factor;
}

static void count_tile(void *ctx, int index, int thread)
{
    struct view *const v = ctx;
    struct tile *const t = &v->tile[thread];
    const int across = (v->w + TILE - 1) / TILE;
    const int x0 = index % across * TILE, y0 = index / across * TILE;
    bool levels = false; // most tiles of two pictures are equal
    for (int y = y0; y < gp_min(y0 + TILE, v->h); y++) {
        for (int x = x0; x < gp_min(x0 + TILE, v->w); x++) {
            const size_t i = (size_t) y * (size_t) v->w + (size_t) x;
            float rgb[2][3];
            bool nan[2] = {false, false};
            for (int k = 0; k < 2; k++) {
                for (int c = 0; c < 3; c++) {
                    rgb[k][c] = v->image[k]->c[c][i];
                    nan[k] = nan[k] || isnan(rgb[k][c]);
                }
            }
            if (nan[0] || nan[1] || memcmp(rgb[0], rgb[1], sizeof *rgb) == 0) {
                v->seen[index] += nan[0] != nan[1];
                continue;
            }
            if (!levels)
                make_levels(v, x0, y0, t);
            levels = true;
            v->seen[index] += is_seen(v, t, x - x0 + MARGIN, y - y0 + MARGIN,
                                      rgb[0], rgb[1]);
        }
    }
}

gp_status gp_compare_see(const struct gp_log *log,
                         const struct gp_compare_match *m, long long *seen)
{
    struct gp_planes a = {0}, b = {0};
    struct view v = {
        .w = gp_rect_w(m->window), .h = gp_rect_h(m->window),
        .image = {&a, &b},
    };
    const int tiles = ((v.w + TILE - 1) / TILE) * ((v.h + TILE - 1) / TILE);
    gp_status st;
    GP_TRY(gp_compare_light(log, m, m->a, true, &a));
    GP_TRY(gp_compare_light(log, m, m->b, true, &b));
    GP_TRY(gp_alloc(log, "tiles", (size_t) gp_threads(), sizeof *v.tile,
                    &v.tile));
    GP_TRY(gp_alloc_zero(log, "tiles", (size_t) tiles, sizeof *v.seen,
                         &v.seen));
    // pixels of a display, one unit away, that is as wide as the field
    const double degrees = 2.0 * tan(0.5 * FIELD * PI / 180.0) * 180.0 / PI;
    for (int n = 0; n < BANDS; n++) {
        v.frequency[n] = 0.5 * v.w / degrees / (double) (1 << n);
        v.sharpness[n] = sensitivity(v.frequency[n], 100.0) /
                         sensitivity(3.248, 100.0);
    }
    while (v.adaptation < LEVELS - 1 && 2 << v.adaptation <= degrees)
        v.adaptation++;
    gp_parallel_do(tiles, count_tile, &v);
    *seen = 0;
    for (int i = 0; i < tiles; i++)
        *seen += v.seen[i];
out:
    gp_free(v.seen);
    gp_free(v.tile);
    gp_planes_free(&a);
    gp_planes_free(&b);
    return st;
}
