// SPDX-License-Identifier: Apache-2.0
/* Openings that diffract, and what stains them: the model `aperture`, a lens'
 * iris, and `temporal`, an eye's pupil that shimmers. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/model/model_priv.h"

#include <stdlib.h>

// -- stains: dust, scratches, lashes ------------------------------------------

/* A cover of a part of a pupil: a capsule around a line from one point to the
 * other, mm, that tapers; points alike: a disc. */
struct stain {
    double x[2], y[2], radius[2];
    double hides; // share of the amplitude
};
enum { LASH_STAINS = 8 };

static inline double clamped(double v)
{
    return gp_mind(gp_maxd(v, 0.0), 1.0);
}

/* The share of a cell within `radius` of a line `away` from its middle, all in
 * cells. */
static double cell_share(double radius, double away)
{
    return clamped(0.5 + radius - away) - clamped(0.5 - radius - away);
}

static void stain_row(const struct stain *s, int n, const struct gp_pupil *p,
                      int y)
{
    const double middle = 0.5 * p->n, cell = p->cell;
    const double v = (y + 0.5 - middle) * cell;
    float *const row = p->t + (size_t) y * (size_t) p->n;
    for (int k = 0; k < n; k++) {
        const struct stain *const one = &s[k];
        const int wide = one->radius[1] > one->radius[0];
        const int lower = one->y[1] > one->y[0];
        const double side = one->radius[wide] + cell;
        if (v < one->y[!lower] - side || v > one->y[lower] + side)
            continue;
        const double low = fmin(one->x[0], one->x[1]) - side;
        const double high = fmax(one->x[0], one->x[1]) + side;
        const int from = (int) fmax(floor(low / cell + middle), 0.0);
        const int to = (int) fmin(ceil(high / cell + middle), p->n);
        const double dx = one->x[1] - one->x[0], dy = one->y[1] - one->y[0];
        const double square = dx * dx + dy * dy;
        for (int x = from; x < to; x++) {
            const double a = (x + 0.5 - middle) * cell - one->x[0];
            const double b = v - one->y[0];
            const double at =
                clamped(square > 0.0 ? (a * dx + b * dy) / square : 0.0);
            const double u = a - at * dx, w = b - at * dy;
            const double away = sqrt(u * u + w * w);
            const double radius = one->radius[0] +
                                  at * (one->radius[1] - one->radius[0]);
            const double covered = cell_share(radius / cell, away / cell);
            row[x] *= (float) (1.0 - one->hides * covered);
        }
    }
}

/* Hairs from above, as lids' lashes, over a pupil of `radius` mm; n hairs. Returns
 * the number of their stains. */
static int stain_lashes(int n, double radius, double turn, uint64_t seed,
                        struct stain *out)
{
    const double cosine = gp_cos(turn), sine = gp_sin(turn);
    for (int k = 0; k < n; k++) {
        const uint64_t key = 8 * (uint64_t) k;
        // from the lid's edge, an arc above, downwards and outwards
        const double from = 2.0 * ((k + gp_model_random(seed, key)) / n) - 1.0;
        const double length = 0.7 + 0.7 * gp_model_random(seed, key + 1);
        const double lean = 0.5 * from +
                            0.3 * (gp_model_random(seed, key + 2) - 0.5);
        const double curl = 0.9 * (gp_model_random(seed, key + 3) - 0.5);
        const double thick = 0.012 + 0.012 * gp_model_random(seed, key + 4);
        double x = 1.05 * from, y = -1.1 + 0.25 * from * from;
        for (int i = 0; i < LASH_STAINS; i++) {
            struct stain *const s = &out[k * LASH_STAINS + i];
            const double at = (double) i / LASH_STAINS;
            const double angle = lean + curl * at;
            const double end[2] = {x + length / LASH_STAINS * gp_sin(angle),
                                   y + length / LASH_STAINS * gp_cos(angle)};
            const double px[2] = {x, end[0]}, py[2] = {y, end[1]};
            for (int e = 0; e < 2; e++) {
                s->x[e] = radius * (cosine * px[e] + sine * py[e]);
                s->y[e] = radius * (cosine * py[e] - sine * px[e]);
                s->radius[e] = radius * thick *
                               (1.0 - (at + (double) e / LASH_STAINS));
            }
            s->hides = 1.0;
            x = end[0];
            y = end[1];
        }
    }
    return n * LASH_STAINS;
}

// -- gratings -----------------------------------------------------------------

/* Writes 0.5 + 0.5 cos(fibres (a - turn)) of the cells of row y in a pupil of
 * n x n, n even. Angles a are counter-clockwise as seen. */
GP_CLONES static void grating_row(int n, int y, double turn, double fibres,
                                  float *row)
{
    const double middle = 0.5 * n - 0.5;
    for (int x = 0; x < n; x++) {
        const double a = gp_atan2(middle - y, x - middle);
        row[x] = (float) (0.5 + 0.5 * gp_cos(fibres * (a - turn)));
    }
}

// -- Zernike's polynomials ----------------------------------------------------

/* Z2 to Z15 over the unit disc, as Noll numbers them: Zernike polynomials and
 * atmospheric turbulence, JOSA 66 (1976), table I.
 *
 *   Z(r, a) = N R(r) cos(m a), or sin(m a),
 *   N = sqrt(n + 1) where m is 0, else sqrt(2 n + 2)
 *
 * so that each has a mean square of 1 over the disc, and no two have a mean
 * product. R(r) = r^m (c0 + c1 r^2 + c2 r^4). */
enum { ZERNIKE_FIRST = 2, ZERNIKE_LAST = 15 };
struct term {
    int n, m;       // degree; turns, negative: a sine
    double c[3];
};

static const struct term terms[ZERNIKE_LAST + 1] = {
    [2] = {1, 1, {1}},         [3] = {1, -1, {1}},
    [4] = {2, 0, {-1, 2}},
    [5] = {2, -2, {1}},        [6] = {2, 2, {1}},
    [7] = {3, -1, {-2, 3}},    [8] = {3, 1, {-2, 3}},
    [9] = {3, -3, {1}},        [10] = {3, 3, {1}},
    [11] = {4, 0, {1, -6, 6}},
    [12] = {4, 2, {-3, 4}},    [13] = {4, -2, {-3, 4}},
    [14] = {4, 4, {1}},        [15] = {4, -4, {1}},
};

static double norm(const struct term *t)
{
    return sqrt((t->m ? 2.0 : 1.0) * (t->n + 1));
}

/* Zj; x right, y up, x = r cos a. */
static double zernike(int j, double x, double y)
{
    const struct term *const t = &terms[j];
    const double r2 = x * x + y * y;
    double cosine = 1.0, sine = 0.0; // of m a, times r^m
    for (int i = 0; i < abs(t->m); i++) {
        const double next = cosine * x - sine * y;
        sine = cosine * y + sine * x;
        cosine = next;
    }
    return norm(t) * (t->c[0] + r2 * (t->c[1] + r2 * t->c[2])) *
           (t->m < 0 ? sine : cosine);
}

/* Over the disc, which is at the rim. */
static double steepest_slope(int j)
{
    const struct term *const t = &terms[j];
    return norm(t) * 0.5 * (t->n * (t->n + 2) - t->m * t->m);
}

// -- aperture -----------------------------------------------------------------

/* An opening of radius 1, hidden in part.
 *
 * Blades are arcs that meet in the corners of a regular polygon; `roundness` is
 * the radius of the opening over that of the arcs, so 0 has straight edges and
 * 1 is a circle. The first corner points to the angle `rotation`, counter-
 * clockwise from the right.
 *
 * Aberrations are Zernike's polynomials with the angle from that of
 * `rotation`. */
enum { DUST = 600, SCRATCHES = 60, LASHES = 40 }; // at keys of 1
struct iris {
    double radius;      // mm
    int blades;         // 0: a circle
    double bend;        // radius of the arcs; their centres
    double centre[32][2];
    double inner;       // all within is open
    double obstruction, arc; // of the radius; radians to each side
    double turn;        // radians counter-clockwise as seen
    double grating, fibres;
    double path[ZERNIKE_LAST + 1]; // nm rms, by Noll's number
    const struct gp_image *mask;
    int stains;
    struct stain stain[DUST + SCRATCHES + LASHES * LASH_STAINS];
};

/* The share of a square of side 1 beyond a straight edge: `inside` is how far
 * its middle lies inside, (a, b) the edge's normal. */
static double square_share(double inside, double a, double b)
{
    const double m = 0.5 * fmax(fabs(a), fabs(b));
    const double k = 0.5 * fmin(fabs(a), fabs(b));
    const double d = fabs(inside);
    // the square seen along the edge is a trapezium, 2 (m + k) wide, with a
    // top of 2 (m - k) and a height of 1 / 2m
    double share = 1.0;
    if (d <= m - k)
        share = 0.5 + d / (2.0 * m);
    else if (d < m + k)
        share = 1.0 - (m + k - d) * (m + k - d) / (8.0 * m * k);
    return inside < 0.0 ? 1.0 - share : share;
}

/* The open share of a cell around (x, y), by the nearest blade. */
static double opening(const struct iris *s, double x, double y, double cell)
{
    const double r = gp_hypot(x, y);
    if (r < s->inner - cell)
        return 1.0;
    if (r > 1.0 + cell)
        return 0.0;
    double best = (1.0 - r) / cell, normal[2] = {x / r, y / r};
    for (int i = 0; i < s->blades; i++) {
        const double dx = x - s->centre[i][0], dy = y - s->centre[i][1];
        const double away = gp_hypot(dx, dy), inside = (s->bend - away) / cell;
        if (inside < best) {
            best = inside;
            normal[0] = dx / away;
            normal[1] = dy / away;
        }
    }
    return square_share(best, normal[0], normal[1]);
}

/* Luminance of the mask's pixel nearest to (x, y). */
static double mask_pixel(const struct gp_image *m, int x, int y)
{
    const int w = gp_image_w(m), h = gp_image_h(m);
    const size_t at = (size_t) gp_clamp(y, 0, h - 1) * (size_t) w +
                      (size_t) gp_clamp(x, 0, w - 1);
    double sum = 0.0;
    for (int c = 0; c < 3; c++)
        sum += (double) m->luminance[c] * (double) m->rgb.c[c][at];
    return clamped(sum);
}

/* The mean of the mask over a cell around (x, y); its longer side is the
 * opening's diameter. */
static double mask_share(const struct gp_image *m, double x, double y,
                         double cell)
{
    const double w = gp_image_w(m), h = gp_image_h(m);
    const double scale = 0.5 * fmax(w, h);
    const int points = (int) fmin(ceil(2.0 * cell * scale), 8.0);
    const double inside = clamped(0.5 + (0.5 * w / scale - fabs(x)) / cell) *
                          clamped(0.5 + (0.5 * h / scale - fabs(y)) / cell);
    double sum = 0.0;
    if (!(inside > 0.0))
        return 0.0;
    for (int i = 0; i < points * points; i++) {
        const double u = (x + cell * ((i % points + 0.5) / points - 0.5)) *
                         scale + 0.5 * w - 0.5;
        const double v = (y + cell * ((i / points + 0.5) / points - 0.5)) *
                         scale + 0.5 * h - 0.5;
        const int ix = (int) floor(u), iy = (int) floor(v);
        const double a = u - ix, b = v - iy;
        sum += (1.0 - b) * ((1.0 - a) * mask_pixel(m, ix, iy) +
                            a * mask_pixel(m, ix + 1, iy)) +
               b * ((1.0 - a) * mask_pixel(m, ix, iy + 1) +
                    a * mask_pixel(m, ix + 1, iy + 1));
    }
    return inside * sum / (points * points);
}

static void draw_iris(const void *ctx, const struct gp_pupil *p, int y)
{
    const struct iris *const s = ctx;
    const double cell = p->cell / s->radius, middle = 0.5 * p->n;
    const double cosine = gp_cos(s->turn), sine = gp_sin(s->turn);
    const size_t row = (size_t) y * (size_t) p->n;
    if (s->grating > 0.0)
        grating_row(p->n, y, s->turn, s->fibres, p->t + row);
    for (int x = 0; x < p->n; x++) {
        const double px = (x + 0.5 - middle) * cell;
        const double py = (y + 0.5 - middle) * cell;
        // turned back, y down
        const double u = cosine * px - sine * py, v = sine * px + cosine * py;
        double t = s->mask ? mask_share(s->mask, u, v, cell)
                           : opening(s, px, py, cell);
        const double r = gp_hypot(px, py);
        if (t > 0.0 && s->obstruction > 0.0 && r < s->obstruction + cell &&
            fabs(gp_atan2(-v, u)) <= s->arc)
            t *= square_share((r - s->obstruction) / cell, px / r, py / r);
        if (t > 0.0 && s->grating > 0.0 && r > 0.6) {
            const double from = fmin((r - 0.6) / 0.2, 1.0);
            t *= 1.0 - s->grating * from * (double) p->t[row + (size_t) x];
        }
        p->t[row + (size_t) x] = (float) t;
        if (!p->path || t <= 0.0)
            continue;
        double path = 0.0;
        for (int j = ZERNIKE_FIRST; j <= ZERNIKE_LAST; j++)
            path += s->path[j] != 0.0 ? s->path[j] * zernike(j, u, -v) : 0.0;
        p->path[row + (size_t) x] = (float) path;
    }
    stain_row(s->stain, s->stains, p, y);
}

static void add_dust(struct iris *s, int n, uint64_t seed)
{
    for (int k = 0; k < n; k++) {
        const uint64_t key = 4 * (uint64_t) k;
        const double r = s->radius * sqrt(gp_model_random(seed, key));
        const double a = 2.0 * M_PI * gp_model_random(seed, key + 1) + s->turn;
        // most grains are small
        const double size = 0.004 * gp_pow(8.0, gp_model_random(seed, key + 2));
        const double x = r * gp_cos(a), y = -r * gp_sin(a);
        const double wide = s->radius * size;
        s->stain[s->stains++] = (struct stain) {
            {x, x}, {y, y}, {wide, wide},
            0.5 + 0.5 * gp_model_random(seed, key + 3)};
    }
}

static void add_scratches(struct iris *s, int n, uint64_t seed)
{
    for (int k = 0; k < n; k++) {
        struct stain *const one = &s->stain[s->stains++];
        const uint64_t key = 6 * (uint64_t) k;
        const double r = sqrt(gp_model_random(seed, key));
        const double a = 2.0 * M_PI * gp_model_random(seed, key + 1) + s->turn;
        const double b = 2.0 * M_PI * gp_model_random(seed, key + 2) + s->turn;
        const double length = 0.1 + 0.9 * gp_model_random(seed, key + 3);
        const double thick = 0.001 + 0.002 * gp_model_random(seed, key + 4);
        for (int e = 0; e < 2; e++) {
            const double at = (e - 0.5) * length;
            one->x[e] = s->radius * (r * gp_cos(a) + at * gp_cos(b));
            one->y[e] = -s->radius * (r * gp_sin(a) + at * gp_sin(b));
            one->radius[e] = s->radius * thick;
        }
        one->hides = 0.3 + 0.7 * gp_model_random(seed, key + 5);
    }
}

/* Zernike's polynomials: number, key, most of it, and what it does. */
#define ABERRATIONS(X)                                                        \
    X(2, "tilt", 10, ", moves the light to the rotation's side")              \
    X(3, "vertical-tilt", 10, ", moves it across")                            \
    X(4, "defocus", 10, "")                                                   \
    X(5, "oblique-astigmatism", 10, "")                                       \
    X(6, "astigmatism", 10, "")                                               \
    X(7, "vertical-coma", 5, "")                                              \
    X(8, "coma", 5, "")                                                       \
    X(9, "vertical-trefoil", 5, "")                                           \
    X(10, "oblique-trefoil", 5, "")                                           \
    X(11, "spherical", 5, "")                                                 \
    X(12, "secondary-astigmatism", 5, "")                                     \
    X(13, "oblique-secondary", 5, ", secondary astigmatism")                  \
    X(14, "quadrafoil", 5, "")                                                \
    X(15, "oblique-quadrafoil", 5, "")
#define ABERRATION_KEY(j, name, most, does)                                   \
    {name, "Zernike's Z" #j does ", waves of 550 nm rms", 0, -(most),         \
     (most), NULL},
#define ABERRATION_NAME(j, name, most, does) [j] = (name),
static const char *const aberrations[ZERNIKE_LAST + 1] = {
    ABERRATIONS(ABERRATION_NAME)
};

static const struct gp_model_key aperture_keys[] = {
    GP_MODEL_SHARE(0.5),
    {"blades", "blades of the iris, 3 to 32; 0 makes a circle", 6, 0, 32, NULL},
    {"roundness", "shape of the blades, 0 straight, with spikes as needles, to 1 "
     "a circle; between them spikes are fans", 0, 0, 1, NULL},
    {"rotation", "turns the iris and all that is on it, degrees "
     "counter-clockwise", 0, -360, 360, NULL},
    {"obstruction", "diameter of a disc that hides the middle, as in a mirror "
     "lens, share of the opening", 0, 0, 0.95, NULL},
    {"arc", "part of that disc, degrees around the direction of rotation", 360,
     0, 360, NULL},
    {"grating", "strength of radial fibres near the opening's edge", 0, 0, 1,
     NULL},
    {"fibres", "number of these fibres", 200, 2, 1000, NULL},
    {"dust", "dust on the lens, 0 none to 1 much", 0.1, 0, 1, NULL},
    {"scratches", "scratches on the lens, 0 none to 1 many", 0.05, 0, 1, NULL},
    {"lashes", "lashes or hairs before the lens, 0 none to 1 many", 0, 0, 1,
     NULL},
    {"seed", "number that chooses dust, scratches and lashes", 1, 0, 1e9, NULL},
    {"mask", "image in place of the iris: white passes light, black hides it; "
     "its longer side is the diameter", 0, 0, 0, gp_model_file},
    {"fnumber", "f-number of the lens: focal length over diameter", 22, 0.5,
     256, NULL},
    {"focal", "focal length of the lens, mm", 24, 1, 2000, NULL},
    {"pupil", "diameter of the opening, mm; 0 takes focal / fnumber", 0, 0,
     1000, NULL},
    ABERRATIONS(ABERRATION_KEY)
    {"wavelengths", "number of wavelengths of daylight, 380 to 780 nm", 32, 1,
     256, NULL},
    {"wavelength", "a single wavelength, nm, shown white; 0 takes daylight", 0,
     0, 2000, NULL},
    {"reach", "distance beyond which only the light's smooth mean goes on, "
     "degrees; spikes fade from a quarter of it on", 12, 0.01, 90, NULL},
    {0},
};

static void make_blades(struct iris *s, double roundness)
{
    const double half = M_PI / s->blades;
    // nearly straight where roundness is 0
    s->bend = 1.0 / fmax(roundness, 1e-6);
    const double off =
        sqrt(s->bend * s->bend - gp_sin(half) * gp_sin(half)) - gp_cos(half);
    for (int i = 0; i < s->blades; i++) {
        const double a = s->turn + (2 * i + 1) * half;
        s->centre[i][0] = -off * gp_cos(a);
        s->centre[i][1] = off * gp_sin(a);
    }
    s->inner = gp_cos(half);
}

static double aperture_pupil(const struct gp_recipe *r,
                             GP_UNUSED const struct gp_field *f)
{
    const double pupil = gp_recipe_value(r, "pupil");
    return pupil > 0.0 ? pupil : gp_recipe_value(r, "focal") /
                                     gp_recipe_value(r, "fnumber");
}

static gp_status open_aperture(const struct gp_log *log,
    const struct gp_recipe *r, const struct gp_field *f, struct gp_shape *out)
{
    struct iris *s;
    const uint64_t seed = (uint64_t) gp_recipe_value(r, "seed");
    const int blades = (int) gp_recipe_value(r, "blades");
    const struct gp_image *const mask = r->image;
    if (blades == 1 || blades == 2)
        return gp_fail(log, GP_ERR_USAGE, "aperture: %d blades make no "
                       "opening; give 0 or 3 to 32", blades);
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *s, &s);
    if (st)
        return st;
    s->radius = 0.5 * aperture_pupil(r, f);
    s->turn = (gp_recipe_value(r, "rotation") + f->rotate) * M_PI / 180.0;
    s->blades = blades;
    s->inner = 1.0;
    if (blades)
        make_blades(s, gp_recipe_value(r, "roundness"));
    s->obstruction = gp_recipe_value(r, "obstruction");
    s->arc = gp_recipe_value(r, "arc") * M_PI / 360.0;
    s->grating = gp_recipe_value(r, "grating");
    s->fibres = floor(gp_recipe_value(r, "fibres"));
    s->mask = mask;
    add_dust(s, (int) (DUST * gp_recipe_value(r, "dust")), seed);
    add_scratches(s, (int) (SCRATCHES * gp_recipe_value(r, "scratches")),
                  seed + 1);
    s->stains +=
        stain_lashes((int) (LASHES * gp_recipe_value(r, "lashes")), s->radius,
                     s->turn, seed + 2, s->stain + s->stains);
    double steep = 0.0;
    for (int j = ZERNIKE_FIRST; j <= ZERNIKE_LAST; j++) {
        s->path[j] = 550.0 * gp_recipe_value(r, aberrations[j]);
        steep += fabs(s->path[j]) * steepest_slope(j);
    }
    // a mask's corners, turned
    const double wide =
        mask ? fabs(gp_cos(s->turn)) + fabs(gp_sin(s->turn)) : 1.0;
    const struct gp_diffraction d = {
        .name = mask && mask->path ? mask->path : "aperture",
        .diameter = 2.0 * s->radius * wide,
        .corners = mask != NULL,
        .reach = gp_recipe_value(r, "reach"),
        .sampled = 0.25, // a spike is some 100 times as bright as its sides
        .nm = gp_recipe_value(r, "wavelength"),
        .bands = (int) gp_recipe_value(r, "wavelengths"),
        .steep = steep / s->radius,
        .draw = draw_iris,
        .ctx = s,
        .blades =
            {
                .n = mask ? 0 : blades,
                .turn = s->turn + (blades ? M_PI / blades : 0.0),
                .length =
                    2.0 * s->radius * (blades ? gp_sin(M_PI / blades) : 0.0),
                .bend = s->radius * s->bend,
            },
    };
    st = gp_diffract(log, &d, f, out);
    gp_free(s);
    return st;
}

const struct gp_model gp_model_aperture = {
    .name = "aperture", .text = "spikes and speckle of a lens' iris",
    .source = "Fraunhofer diffraction: Goodman, Fourier Optics, eq. 4-25",
    .pupil = aperture_pupil, .keys = aperture_keys, .open = open_aperture,
};

// -- an eye -------------------------------------------------------------------

/* After Ritschel et al.: Temporal Glare: Real-Time Dynamic Simulation of the
 * Scattering in the Human Eye, Eurographics 2009. */
#define PUPIL_MOST 9.0 // mm

double gp_pupil_moon_spencer(double nits)
{
    // 1 - 2 / (1 + exp(2 x)) is the hyperbolic tangent
    const double x = 0.4 / M_LN10 * gp_log(nits) - 0.00114;
    return 1.9 + 6.0 / (1.0 + gp_exp(2.0 * x));
}

double gp_pupil_watson(double nits, double area, double age)
{
    const double flux = gp_pow(nits * area / 846.0, 0.41);
    const double young = 7.75 - 5.75 * flux / (flux + 2.0);
    return young + (age - 28.58) * (0.02132 - 0.009562 * young);
}

/* Three octaves of even steps between numbers of a seed, in (-1, 1). */
static double noise(double t, uint64_t seed)
{
    double sum = 0.0;
    for (int i = 0; i < 3; i++) {
        const double at = fabs(t) * (1 << i), whole = floor(at);
        const double s = gp_smoothstep(at - whole);
        const uint64_t key = 3 * (uint64_t) whole + (uint64_t) i;
        const double a = gp_model_random(seed, key);
        const double b = gp_model_random(seed, key + 3);
        sum += (2.0 * (a + s * (b - a)) - 1.0) / (1 << i);
    }
    return sum / 1.75;
}

/* Hippus: Ritschel et al. 2009, eq. 2, of a pupil of p mm at t seconds;
 * `strength` scales its noise. */
static double hippus(double p, double t, double strength, uint64_t seed)
{
    const double by = PUPIL_MOST / p * sqrt(fmax(1.0 - p / PUPIL_MOST, 0.0));
    return fmin(fmax(p + strength * noise(t / p, seed) * by, 1.0), PUPIL_MOST);
}

/* All in mm, where it is in the eye: a narrow pupil shows less of it. */
enum { PARTICLES = 1500, EYE_LASHES = 24, WAVES = 4 };
static const double EDGE = 0.97; // mean of the iris, of its radius
struct eye {
    double radius, shut;     // within `shut` of the radius all is open
    double edge[WAVES][2];   // of the iris: cosines and sines of 2, 3, ...
    double grating, fibres;
    double turn, right[2];   // radians; its cosine and sine
    int stains;
    struct stain stain[PARTICLES + EYE_LASHES * LASH_STAINS];
};

/* The open share of a cell at the edge of the iris, (u, v) and r = |(u, v)| mm
 * from the middle. */
static double edge_share(const struct eye *e, double u, double v, double r,
                         double cell)
{
    const double cosine = (u * e->right[0] - v * e->right[1]) / r;
    const double sine = (-v * e->right[0] - u * e->right[1]) / r;
    double c = cosine, s = sine, edge = EDGE; // of 1, 2, 3, ... times the angle
    for (int i = 0; i < WAVES; i++) {
        const double next = c * cosine - s * sine;
        s = s * cosine + c * sine;
        c = next;
        edge += e->edge[i][0] * c + e->edge[i][1] * s;
    }
    return clamped((edge * e->radius - r) / cell + 0.5);
}

static void draw_eye(const void *ctx, const struct gp_pupil *p, int y)
{
    static const double FIBRES = 1.5; // mm: the lens' cortex shows where the
                                      // pupil is over 3 mm wide: Simpson 1953
    const struct eye *const e = ctx;
    const double middle = 0.5 * p->n, end = e->radius + p->cell;
    const double v = (y + 0.5 - middle) * p->cell;
    float *const row = p->t + (size_t) y * (size_t) p->n;
    const double shut = e->shut * e->radius - p->cell;
    const bool fibres = e->grating > 0.0 && end > FIBRES;
    if (fibres)
        grating_row(p->n, y, e->turn, e->fibres, row);
    for (int x = 0; x < p->n; x++) {
        const double u = (x + 0.5 - middle) * p->cell;
        const double r = sqrt(u * u + v * v);
        double t = r > end ? 0.0 : 1.0;
        if (r > shut && r <= end)
            t = edge_share(e, u, v, r, p->cell);
        if (fibres && r > FIBRES)
            t *= 1.0 - e->grating * gp_mind(r - FIBRES, 1.0) * (double) row[x];
        row[x] = (float) t;
    }
    stain_row(e->stain, e->stains, p, y);
}

/* Particles in the lens, before it and behind it, which drift as the eye
 * moves. */
static void add_particles(struct eye *e, int n, double t, uint64_t seed)
{
    for (int k = 0; k < n; k++) {
        const uint64_t key = 4 * (uint64_t) k;
        const bool floats = k % 4 == 0;
        const double r = 0.5 * PUPIL_MOST * sqrt(gp_model_random(seed, key));
        const double a = 2.0 * M_PI * gp_model_random(seed, key + 1) + e->turn +
                         (floats ? 0.3 * noise(0.4 * t, seed + 1) : 0.0);
        const double size = 0.012 * gp_pow(4.0, gp_model_random(seed, key + 2));
        const double shift = 0.05 * noise(t, seed + 2 + (floats ? 1 : 0));
        const double x = r * gp_cos(a) + shift;
        const double y = -r * gp_sin(a) + 0.5 * shift;
        e->stain[e->stains++] = (struct stain) {
            {x, x}, {y, y}, {size, size},
            0.3 + 0.7 * gp_model_random(seed, key + 3)};
    }
}

enum { MOON_SPENCER, WATSON };
static const char *const formulas[] = {"moon-spencer", "watson", NULL};

static const struct gp_model_key temporal_keys[] = {
    GP_MODEL_SHARE(1.0),
    GP_MODEL_ADAPTATION(1),
    {"pupil", "mean diameter of the pupil, mm; 0 takes that of adaptation", 0,
     0, PUPIL_MOST, NULL},
    {"formula", "pupil of an adaptation, by Moon and Spencer or by Watson and "
     "Yellott", MOON_SPENCER, MOON_SPENCER, WATSON, formulas},
    {"age", "years, used by watson", 30, 18, 90, NULL},
    {"hippus", "strength with which the pupil shimmers in time", 0.15, 0, 1,
     NULL},
    {"particles", "particles in the eye, 0 none to 1 many", 0.5, 0, 1, NULL},
    {"grating", "strength of the lens' fibres: the lenticular halo", 0.1, 0, 1,
     NULL},
    {"fibres", "number of these fibres", 1100, 2, 3000, NULL},
    {"lashes", "lashes before the eye, 0 none to 1 many", 0.2, 0, 1, NULL},
    {"seed", "number that chooses the eye", 1, 0, 1e9, NULL},
    {"wavelengths", "number of wavelengths of daylight, 380 to 780 nm", 32, 1,
     256, NULL},
    {"reach", "distance beyond which only the light's smooth mean goes on, "
     "degrees; needles fade from 0.4 of it on", 6, 0.01, 90, NULL},
    {0},
};

static bool temporal_adapts(const struct gp_recipe *r)
{
    return !(gp_recipe_value(r, "pupil") > 0.0);
}

static double temporal_pupil(const struct gp_recipe *r,
                             const struct gp_field *f)
{
    const double nits = gp_recipe_value(r, "adaptation");
    const double area = f->degrees * f->degrees * f->aspect * f->w * f->h;
    double p = gp_recipe_value(r, "pupil");
    if (!(p > 0.0))
        p = gp_recipe_value(r, "formula") == WATSON
                ? gp_pupil_watson(nits, area, gp_recipe_value(r, "age"))
                : gp_pupil_moon_spencer(nits);
    return hippus(fmax(p, 1.0), f->frame / f->fps, gp_recipe_value(r, "hippus"),
                  (uint64_t) gp_recipe_value(r, "seed"));
}

static gp_status open_temporal(const struct gp_log *log,
    const struct gp_recipe *r, const struct gp_field *f, struct gp_shape *out)
{
    struct eye *e;
    const uint64_t seed = (uint64_t) gp_recipe_value(r, "seed");
    const double t = f->frame / f->fps;
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *e, &e);
    if (st)
        return st;
    e->radius = 0.5 * temporal_pupil(r, f);
    e->turn = f->rotate * M_PI / 180.0;
    e->right[0] = gp_cos(e->turn);
    e->right[1] = gp_sin(e->turn);
    for (int i = 0; i < 2 * WAVES; i++)
        e->edge[i / 2][i % 2] =
            0.012 * (gp_model_random(seed + 7, (uint64_t) i) - 0.5);
    e->shut = EDGE;
    for (int i = 0; i < WAVES; i++)
        e->shut -= gp_hypot(e->edge[i][0], e->edge[i][1]);
    e->grating = gp_recipe_value(r, "grating");
    e->fibres = floor(gp_recipe_value(r, "fibres"));
    add_particles(e, (int) (PARTICLES * gp_recipe_value(r, "particles")), t,
                  seed + 8);
    e->stains +=
        stain_lashes((int) (EYE_LASHES * gp_recipe_value(r, "lashes")),
                     e->radius, e->turn, seed + 16, e->stain + e->stains);
    const struct gp_diffraction d = {
        .name = "temporal", .diameter = 2.0 * e->radius,
        .reach = gp_recipe_value(r, "reach"),
        .sampled = 0.4, // a needle some 10 times; before it is the halo
        .bands = (int) gp_recipe_value(r, "wavelengths"), .draw = draw_eye,
        .ctx = e,
    };
    st = gp_diffract(log, &d, f, out);
    gp_free(e);
    return st;
}

const struct gp_model gp_model_temporal = {
    .name = "temporal", .text = "an eye whose pupil shimmers with each frame",
    .source = "Ritschel et al. 2009, eqs. 1 and 2", .moves = true,
    .pupil = temporal_pupil, .adapts = temporal_adapts,
    .keys = temporal_keys, .open = open_temporal,
};
