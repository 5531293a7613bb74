/* LDR-FLIP, tile after tile: each picture is filtered in a tile with its
 * surroundings, its colours and features are kept, and compared with those of
 * the other. */
#include "tone/flip.h"

#include "core/colour.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "tone/flip_filter.h"

#include <math.h>
#include <string.h>

enum { TILE_W = 128, TILE_H = 64, TILE = TILE_W * TILE_H };

/* Lines of a tile that are filtered along x: colours, then features. */
enum { LINES = GP_FLIP_COLOURS + GP_FLIP_FEATURES };

/* What an eye has of a picture: Hunt-adjusted L*a*b*, and the magnitudes of
 * edges and points. */
enum { L, A, B, EDGE, POINT, SEEN };

struct metric {
    int w, h, across;              // the picture; tiles in a row
    const struct gp_planes *picture[2];
    struct gp_flip_filters filter;
    float to_xyz[9], to_rgb[9];    // BT.709 and XYZ over that of white
    float most;                    // largest colour difference, to the COLOUR_POWER
    size_t scratch;                // floats a thread
    float *scratches;
    float *map;                    // or NULL
    double *sum;                   // one a tile
};

/* A tile under way. */
struct tile {
    int x0, y0, w, h;
    float *row[3];     // opponent colours of a row, padded on both sides
    float *line[LINES]; // h + 2 * radius rows of TILE_W
    float *seen[2][SEEN]; // h rows of TILE_W, of each picture
};

// Section 4.1.3 of the paper: q_c, p_c and p_t
static const float COLOUR_POWER = 0.7f, KNEE_AT = 0.4f, KNEE_TO = 0.95f;

// -- colour ------------------------------------------------------------------

static void multiply(const float m[9], const float in[3], float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[3 * i] * in[0] + m[3 * i + 1] * in[1] + m[3 * i + 2] * in[2];
}

/* The matrices between linear BT.709 and XYZ over white's. */
static void make_matrices(struct metric *m)
{
    double xyz[9];
    (void) gp_rgb_to_xyz(gp_rec709_chromaticities, xyz); // cannot fail
    for (int i = 0; i < 3; i++) {
        const double white = xyz[3 * i] + xyz[3 * i + 1] + xyz[3 * i + 2];
        for (int j = 0; j < 3; j++)
            xyz[3 * i + j] /= white;
    }
    // the inverse's columns are the rows' cross products over the determinant
    double cross[9], det = 0.0;
    for (int i = 0; i < 9; i++) {
        const double *const u = xyz + (i / 3 + 1) % 3 * 3;
        const double *const v = xyz + (i / 3 + 2) % 3 * 3;
        const int k1 = (i % 3 + 1) % 3, k2 = (i % 3 + 2) % 3;
        cross[i] = u[k1] * v[k2] - u[k2] * v[k1];
        det += i < 3 ? xyz[i] * cross[i] : 0.0;
    }
    for (int i = 0; i < 9; i++) {
        m->to_xyz[i] = (float) xyz[i];
        m->to_rgb[i] = (float) (cross[i % 3 * 3 + i / 3] / det);
    }
}

/* CIE 1976, with 6/29 as the border of the linear part. */
static float lab_curve(float t)
{
    const float border = 6.0f / 29.0f;
    return t > border * border * border
               ? cbrtf(t)
               : t / (3.0f * border * border) + 4.0f / 29.0f;
}

/* Linear BT.709 to L*a*b* whose a* and b* grow with L* (section 4.1.2). */
static void to_hunt_lab(const struct metric *m, const float rgb[3],
                        float lab[3])
{
    float xyz[3];
    multiply(m->to_xyz, rgb, xyz);
    const float x = lab_curve(xyz[0]), y = lab_curve(xyz[1]);
    const float z = lab_curve(xyz[2]);
    lab[0] = 116.0f * y - 16.0f;
    lab[1] = 0.01f * lab[0] * 500.0f * (x - y);
    lab[2] = 0.01f * lab[0] * 200.0f * (y - z);
}

/* HyAB distance, section 4.1.3. */
static float distance(const float a[3], const float b[3])
{
    const float da = a[1] - b[1], db = a[2] - b[2];
    return fabsf(a[0] - b[0]) + sqrtf(da * da + db * db);
}

/* No two colours are further apart than green and blue. */
static float largest_difference(const struct metric *m)
{
    static const float green[3] = {0.0f, 1.0f, 0.0f}, blue[3] = {0.0f, 0.0f, 1.0f};
    float a[3], b[3];
    to_hunt_lab(m, green, a);
    to_hunt_lab(m, blue, b);
    return powf(distance(a, b), COLOUR_POWER);
}

static float unit(float v)
{
    return v > 0.0f ? (v < 1.0f ? v : 1.0f) : 0.0f; // NaN is 0
}

// -- one picture in a tile ----------------------------------------------------

static int clamp_int(int v, int most)
{
    return v < 0 ? 0 : v > most ? most : v;
}

/* The opponent colours YCxCz of row y, without their factors, which the way
 * back would take away again: Y, X - Y, Y - Z over white's. */
static void load_row(const struct metric *m, const struct tile *t,
                     const struct gp_planes *p, int y)
{
    const int r = m->filter.radius;
    const size_t at = (size_t) clamp_int(y, m->h - 1) * (size_t) m->w;
    for (int i = 0; i < t->w + 2 * r; i++) {
        const size_t from =
            at + (size_t) clamp_int(t->x0 - r + i, m->w - 1);
        const float rgb[3] = {unit(p->c[0][from]), unit(p->c[1][from]),
                              unit(p->c[2][from])};
        float xyz[3];
        multiply(m->to_xyz, rgb, xyz);
        t->row[0][i] = xyz[1];
        t->row[1][i] = xyz[0] - xyz[1];
        t->row[2][i] = xyz[1] - xyz[2];
    }
}

static void filter_rows(const struct metric *m, const struct tile *t,
                        const struct gp_planes *p)
{
    static const int from[GP_FLIP_COLOURS] = {
        [GP_FLIP_ACHROMATIC] = 0, [GP_FLIP_RED_GREEN] = 1,
        [GP_FLIP_BLUE_YELLOW] = 2, [GP_FLIP_BLUE_YELLOW_2] = 2,
    };
    const struct gp_flip_filters *f = &m->filter;
    const int inset = f->radius - f->feature_radius;
    for (int j = 0; j < t->h + 2 * f->radius; j++) {
        load_row(m, t, p, t->y0 - f->radius + j);
        for (int c = 0; c < GP_FLIP_COLOURS; c++)
            gp_flip_filter_row(t->row[from[c]], f->colour[c].at,
                               2 * f->radius + 1, t->w,
                               t->line[c] + j * TILE_W);
        for (int k = 0; k < GP_FLIP_FEATURES; k++)
            gp_flip_filter_row(t->row[0] + inset, f->feature[k].at,
                               2 * f->feature_radius + 1, t->w,
                               t->line[GP_FLIP_COLOURS + k] + j * TILE_W);
    }
}

/* Colours of row j of the tile as the eye resolves them. */
static void see_colour(const struct metric *m, const struct tile *t, int j,
                       float *const seen[SEEN])
{
    const struct gp_flip_filters *f = &m->filter;
    const float weight[GP_FLIP_COLOURS] = {1.0f, 1.0f, f->share[0],
                                           f->share[1]};
    static const int to[GP_FLIP_COLOURS] = {0, 1, 2, 2};
    float sum[3][TILE_W] = {0};
    for (int c = 0; c < GP_FLIP_COLOURS; c++)
        gp_flip_filter_column(t->line[c] + j * TILE_W, TILE_W,
                              f->colour[c].at, 2 * f->radius + 1, weight[c],
                              t->w, sum[to[c]]);
    for (int i = 0; i < t->w; i++) {
        const float y = sum[0][i];
        const float xyz[3] = {y + sum[1][i], y, y - sum[2][i]};
        float rgb[3], lab[3];
        multiply(m->to_rgb, xyz, rgb);
        for (int c = 0; c < 3; c++)
            rgb[c] = unit(rgb[c]);
        to_hunt_lab(m, rgb, lab);
        for (int c = 0; c < 3; c++)
            seen[L + c][j * TILE_W + i] = lab[c];
    }
}

/* Magnitudes of a detector along x and along y, row j of the tile. */
static void see_feature(const struct metric *m, const struct tile *t, int j,
                        enum gp_flip_feature feature, float *out)
{
    const struct gp_flip_filters *f = &m->filter;
    const int top = (j + f->radius - f->feature_radius) * TILE_W;
    const int taps = 2 * f->feature_radius + 1;
    const float *const blurred = t->line[GP_FLIP_COLOURS + GP_FLIP_BLUR];
    const float *const derived = t->line[GP_FLIP_COLOURS + (int) feature];
    float x[TILE_W] = {0}, y[TILE_W] = {0};
    gp_flip_filter_column(derived + top, TILE_W, f->feature[GP_FLIP_BLUR].at,
                          taps, 1.0f, t->w, x);
    gp_flip_filter_column(blurred + top, TILE_W, f->feature[feature].at, taps,
                          1.0f, t->w, y);
    for (int i = 0; i < t->w; i++)
        out[j * TILE_W + i] = sqrtf(x[i] * x[i] + y[i] * y[i]);
}

static void see(const struct metric *m, const struct tile *t, int picture)
{
    float *const *seen = t->seen[picture];
    filter_rows(m, t, m->picture[picture]);
    for (int j = 0; j < t->h; j++) {
        see_colour(m, t, j, seen);
        see_feature(m, t, j, GP_FLIP_EDGE, seen[EDGE]);
        see_feature(m, t, j, GP_FLIP_POINT, seen[POINT]);
    }
}

// -- both ---------------------------------------------------------------------

/* Sections 4.1.3 (colour), 4.2 (features) and 4.3 (both). */
static float difference(const struct metric *m, const struct tile *t, int at)
{
    float *const *a = t->seen[0], *const *b = t->seen[1];
    const float lab_a[3] = {a[L][at], a[A][at], a[B][at]};
    const float lab_b[3] = {b[L][at], b[A][at], b[B][at]};
    const float e = powf(distance(lab_a, lab_b), COLOUR_POWER);
    const float knee = KNEE_AT * m->most;
    const float colour =
        e < knee ? KNEE_TO / knee * e
                 : KNEE_TO + (e - knee) / (m->most - knee) * (1.0f - KNEE_TO);
    const float edge = fabsf(a[EDGE][at] - b[EDGE][at]);
    const float point = fabsf(a[POINT][at] - b[POINT][at]);
    const float feature =
        sqrtf((edge > point ? edge : point) * (float) M_SQRT1_2); // q_f = 0.5
    return unit(powf(unit(colour), 1.0f - unit(feature)));
}

static struct tile place(const struct metric *m, int i, float *scratch)
{
    const int r = m->filter.radius;
    struct tile t = {.x0 = i % m->across * TILE_W, .y0 = i / m->across * TILE_H};
    t.w = m->w - t.x0 < TILE_W ? m->w - t.x0 : TILE_W;
    t.h = m->h - t.y0 < TILE_H ? m->h - t.y0 : TILE_H;
    for (int c = 0; c < 3; c++, scratch += TILE_W + 2 * r)
        t.row[c] = scratch;
    for (int k = 0; k < LINES; k++, scratch += (TILE_H + 2 * r) * TILE_W)
        t.line[k] = scratch;
    for (int k = 0; k < 2 * SEEN; k++, scratch += TILE)
        t.seen[k / SEEN][k % SEEN] = scratch;
    return t;
}

static void compare_tile(void *ctx, int i, int thread)
{
    const struct metric *m = ctx;
    const struct tile t =
        place(m, i, m->scratches + (size_t) thread * m->scratch);
    double sum = 0.0;
    see(m, &t, 0);
    see(m, &t, 1);
    for (int y = 0; y < t.h; y++) {
        float *const to = m->map ? m->map + (size_t) (t.y0 + y) * (size_t) m->w +
                                       (size_t) t.x0 : NULL;
        for (int x = 0; x < t.w; x++) {
            const float d = difference(m, &t, y * TILE_W + x);
            sum += (double) d;
            if (to)
                to[x] = d;
        }
    }
    m->sum[i] = sum;
}

gp_status gp_flip_ldr(const struct gp_log *log, int w, int h,
                      const struct gp_planes *a, const struct gp_planes *b,
                      float ppd, float *map, double *mean)
{
    if (w < 1 || h < 1)
        return gp_fail(log, GP_ERR_USAGE,
                       "flip: no pixels (found %d x %d); give pictures", w, h);
    if (!(ppd >= GP_FLIP_PPD_MIN && ppd <= GP_FLIP_PPD_MAX))
        return gp_fail(log, GP_ERR_USAGE,
                       "flip: pixels per degree out of range (found %g); give "
                       "%g to %g", (double) ppd, (double) GP_FLIP_PPD_MIN,
                       (double) GP_FLIP_PPD_MAX);
    struct metric m = {.w = w, .h = h, .across = (w + TILE_W - 1) / TILE_W,
                       .picture = {a, b}, .map = map};
    const int tiles = m.across * ((h + TILE_H - 1) / TILE_H);
    void *scratches = NULL, *sums = NULL;
    make_matrices(&m);
    m.most = largest_difference(&m);
    gp_flip_filters_make(ppd, &m.filter);
    const size_t r = (size_t) m.filter.radius;
    m.scratch = 3 * (TILE_W + 2 * r) + LINES * (TILE_H + 2 * r) * TILE_W +
                2 * SEEN * TILE;
    gp_status st = gp_alloc(log, "flip", (size_t) gp_threads() * m.scratch,
                            sizeof(float), &scratches);
    if (!st)
        st = gp_alloc(log, "flip", (size_t) tiles, sizeof(double), &sums);
    if (!st) {
        m.scratches = scratches;
        m.sum = sums;
        gp_parallel_do(tiles, compare_tile, &m);
        double sum = 0.0;
        for (int i = 0; i < tiles; i++)
            sum += m.sum[i];
        if (mean)
            *mean = sum / ((double) w * (double) h);
    }
    gp_free(scratches);
    gp_free(sums);
    return st;
}
