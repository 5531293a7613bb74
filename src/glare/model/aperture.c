/* The model `aperture`: diffraction by a lens' iris and stains on the lens. */
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/model/model_priv.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846

/* An opening of radius 1, hidden in part.
 *
 * Blades are arcs that meet in the corners of a regular polygon; `roundness` is
 * the radius of the opening over that of the arcs, so 0 has straight edges and
 * 1 is a circle. The first corner points to the angle `rotation`, counter-
 * clockwise from the right.
 *
 * Aberrations are Zernike's polynomials as Noll 1976 numbers them, waves of 550
 * nm, rms, with the angle a from that of `rotation`:
 *   Z4 = sqrt(3) (2 r^2 - 1)           Z6 = sqrt(6) r^2 cos 2a
 *   Z8 = sqrt(8) (3 r^3 - 2 r) cos a   Z11 = sqrt(5) (6 r^4 - 6 r^2 + 1) */
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
    double z4, z6, z8, z11;  // nm
    const struct gp_frame *mask;
    int stains;
    struct gp_stain stain[DUST + SCRATCHES + LASHES * GP_LASH_PARTS];
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
    const double r = hypot(x, y);
    if (r < s->inner - cell)
        return 1.0;
    if (r > 1.0 + cell)
        return 0.0;
    double best = (1.0 - r) / cell, normal[2] = {x / r, y / r};
    for (int i = 0; i < s->blades; i++) {
        const double dx = x - s->centre[i][0], dy = y - s->centre[i][1];
        const double away = hypot(dx, dy), inside = (s->bend - away) / cell;
        if (inside < best) {
            best = inside;
            normal[0] = dx / away;
            normal[1] = dy / away;
        }
    }
    return square_share(best, normal[0], normal[1]);
}

/* Luminance of the mask's pixel nearest to (x, y). */
static double mask_pixel(const struct gp_frame *m, int x, int y)
{
    const int w = gp_frame_w(m), h = gp_frame_h(m);
    const size_t at = (size_t) gp_clamp(y, 0, h - 1) * (size_t) w +
                      (size_t) gp_clamp(x, 0, w - 1);
    double sum = 0.0;
    for (int c = 0; c < 3; c++)
        sum += (double) m->luminance[c] * (double) m->rgb.c[c][at];
    return fmin(fmax(sum, 0.0), 1.0);
}

/* The mean of the mask over a cell around (x, y); its longer side is the
 * opening's diameter. */
static double mask_share(const struct gp_frame *m, double x, double y,
                         double cell)
{
    const double w = gp_frame_w(m), h = gp_frame_h(m);
    const double scale = 0.5 * fmax(w, h);
    const int parts = (int) fmin(ceil(2.0 * cell * scale), 8.0);
    const double inside =
        fmin(fmax(0.5 + (0.5 * w / scale - fabs(x)) / cell, 0.0), 1.0) *
        fmin(fmax(0.5 + (0.5 * h / scale - fabs(y)) / cell, 0.0), 1.0);
    double sum = 0.0;
    if (!(inside > 0.0))
        return 0.0;
    for (int i = 0; i < parts * parts; i++) {
        const double u = (x + cell * ((i % parts + 0.5) / parts - 0.5)) *
                         scale + 0.5 * w - 0.5;
        const double v = (y + cell * ((i / parts + 0.5) / parts - 0.5)) *
                         scale + 0.5 * h - 0.5;
        const int ix = (int) floor(u), iy = (int) floor(v);
        const double a = u - ix, b = v - iy;
        sum += (1.0 - b) * ((1.0 - a) * mask_pixel(m, ix, iy) +
                            a * mask_pixel(m, ix + 1, iy)) +
               b * ((1.0 - a) * mask_pixel(m, ix, iy + 1) +
                    a * mask_pixel(m, ix + 1, iy + 1));
    }
    return inside * sum / (parts * parts);
}

static void draw_iris(const void *ctx, const struct gp_pupil *p, int y)
{
    const struct iris *const s = ctx;
    const double cell = p->cell / s->radius, middle = 0.5 * p->n;
    const double cosine = cos(s->turn), sine = sin(s->turn);
    const size_t row = (size_t) y * (size_t) p->n;
    for (int x = 0; x < p->n; x++) {
        const double px = (x + 0.5 - middle) * cell;
        const double py = (y + 0.5 - middle) * cell;
        // turned back, y down
        const double u = cosine * px - sine * py, v = sine * px + cosine * py;
        double t = s->mask ? mask_share(s->mask, u, v, cell)
                           : opening(s, px, py, cell);
        const double r = hypot(px, py);
        if (t > 0.0 && s->obstruction > 0.0 && r < s->obstruction + cell &&
            fabs(atan2(-v, u)) <= s->arc)
            t *= square_share((r - s->obstruction) / cell, px / r, py / r);
        if (t > 0.0 && s->grating > 0.0 && r > 0.6) {
            const double from = fmin((r - 0.6) / 0.2, 1.0);
            t *= 1.0 - s->grating * from *
                           (0.5 + 0.5 * cos(s->fibres * atan2(-v, u)));
        }
        p->t[row + (size_t) x] = (float) t;
        if (!p->path || t <= 0.0)
            continue;
        const double r2 = r * r;
        p->path[row + (size_t) x] = (float) (
            s->z4 * sqrt(3.0) * (2.0 * r2 - 1.0) +
            s->z6 * sqrt(6.0) * (u * u - v * v) +
            s->z8 * sqrt(8.0) * (3.0 * r2 - 2.0) * u +
            s->z11 * sqrt(5.0) * (6.0 * r2 * r2 - 6.0 * r2 + 1.0));
    }
    gp_stain_row(s->stain, s->stains, p, y);
}

static void add_dust(struct iris *s, int n, uint64_t seed)
{
    for (int k = 0; k < n; k++) {
        struct gp_stain *const one = &s->stain[s->stains++];
        const uint64_t key = 4 * (uint64_t) k;
        const double r = s->radius * sqrt(gp_model_random(seed, key));
        const double a = 2.0 * PI * gp_model_random(seed, key + 1) + s->turn;
        // most grains are small
        const double size = 0.004 * pow(8.0, gp_model_random(seed, key + 2));
        for (int e = 0; e < 2; e++) {
            one->x[e] = r * cos(a);
            one->y[e] = -r * sin(a);
            one->radius[e] = s->radius * size;
        }
        one->hides = 0.5 + 0.5 * gp_model_random(seed, key + 3);
    }
}

static void add_scratches(struct iris *s, int n, uint64_t seed)
{
    for (int k = 0; k < n; k++) {
        struct gp_stain *const one = &s->stain[s->stains++];
        const uint64_t key = 6 * (uint64_t) k;
        const double r = sqrt(gp_model_random(seed, key));
        const double a = 2.0 * PI * gp_model_random(seed, key + 1) + s->turn;
        const double b = 2.0 * PI * gp_model_random(seed, key + 2) + s->turn;
        const double length = 0.1 + 0.9 * gp_model_random(seed, key + 3);
        const double thick = 0.001 + 0.002 * gp_model_random(seed, key + 4);
        for (int e = 0; e < 2; e++) {
            const double at = (e - 0.5) * length;
            one->x[e] = s->radius * (r * cos(a) + at * cos(b));
            one->y[e] = -s->radius * (r * sin(a) + at * sin(b));
            one->radius[e] = s->radius * thick;
        }
        one->hides = 0.3 + 0.7 * gp_model_random(seed, key + 5);
    }
}

static const struct gp_model_key aperture_keys[] = {
    GP_MODEL_SHARE(0.5),
    {"blades", "blades of the iris, 3 to 32; 0 makes a circle", 6, 0, 32, NULL,
     false},
    {"roundness", "shape of the blades, 0 straight to 1 a circle", 0.1, 0, 1,
     NULL, false},
    {"rotation", "turns the iris and all that is on it, degrees "
     "counter-clockwise", 0, -360, 360, NULL, false},
    {"obstruction", "diameter of a disc that hides the middle, as in a mirror "
     "lens, share of the opening", 0, 0, 0.95, NULL, false},
    {"arc", "part of that disc, degrees around the direction of rotation", 360,
     0, 360, NULL, false},
    {"grating", "strength of radial fibres near the opening's edge", 0, 0, 1,
     NULL, false},
    {"fibres", "number of these fibres", 200, 2, 1000, NULL, false},
    {"dust", "dust on the lens, 0 none to 1 much", 0.1, 0, 1, NULL, false},
    {"scratches", "scratches on the lens, 0 none to 1 many", 0.05, 0, 1, NULL,
     false},
    {"lashes", "lashes or hairs before the lens, 0 none to 1 many", 0, 0, 1,
     NULL, false},
    {"seed", "number that chooses dust, scratches and lashes", 1, 0, 1e9, NULL,
     false},
    {"mask", "image in place of the iris: white passes light, black hides it; "
     "its longer side is the diameter", 0, 0, 0, NULL, true},
    {"fnumber", "f-number of the lens: focal length over diameter", 22, 0.5,
     256, NULL, false},
    {"focal", "focal length of the lens, mm", 24, 1, 2000, NULL, false},
    {"pupil", "diameter of the opening, mm; 0 takes focal / fnumber", 0, 0,
     1000, NULL, false},
    {"defocus", "Zernike's Z4, waves of 550 nm rms", 0, -10, 10, NULL, false},
    {"astigmatism", "Zernike's Z6, waves of 550 nm rms", 0, -10, 10, NULL,
     false},
    {"coma", "Zernike's Z8, waves of 550 nm rms", 0, -5, 5, NULL, false},
    {"spherical", "Zernike's Z11, waves of 550 nm rms", 0, -5, 5, NULL, false},
    {"wavelengths", "number of wavelengths of daylight, 380 to 780 nm", 32, 1,
     256, NULL, false},
    {"wavelength", "a single wavelength, nm, shown white; 0 takes daylight", 0,
     0, 2000, NULL, false},
    {"reach", "distance at which the light has faded out, degrees", 12, 0.01,
     90, NULL, false},
    {0},
};

static void make_blades(struct iris *s, double roundness)
{
    const double half = PI / s->blades;
    // nearly straight where roundness is 0
    s->bend = 1.0 / fmax(roundness, 1e-6);
    const double off = sqrt(s->bend * s->bend - sin(half) * sin(half)) -
                       cos(half);
    for (int i = 0; i < s->blades; i++) {
        const double a = s->turn + (2 * i + 1) * half;
        s->centre[i][0] = -off * cos(a);
        s->centre[i][1] = off * sin(a);
    }
    s->inner = cos(half);
}

static gp_status open_aperture(const struct gp_log *log,
    const struct gp_recipe *r, const struct gp_field *f, struct gp_shape *out)
{
    struct iris *s;
    const uint64_t seed = (uint64_t) gp_recipe_value(r, "seed");
    const double pupil = gp_recipe_value(r, "pupil");
    const int blades = (int) gp_recipe_value(r, "blades");
    const struct gp_frame *const mask = r->image;
    if (blades == 1 || blades == 2)
        return gp_fail(log, GP_ERR_USAGE, "aperture: %d blades make no "
                       "opening; give 0 or 3 to 32", blades);
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *s, &s);
    if (st)
        return st;
    s->radius = 0.5 * (pupil > 0.0 ? pupil : gp_recipe_value(r, "focal") /
                                             gp_recipe_value(r, "fnumber"));
    s->turn = (gp_recipe_value(r, "rotation") + f->rotate) * PI / 180.0;
    s->blades = blades;
    s->inner = 1.0;
    if (blades)
        make_blades(s, gp_recipe_value(r, "roundness"));
    s->obstruction = gp_recipe_value(r, "obstruction");
    s->arc = gp_recipe_value(r, "arc") * PI / 360.0;
    s->grating = gp_recipe_value(r, "grating");
    s->fibres = floor(gp_recipe_value(r, "fibres"));
    s->mask = mask;
    add_dust(s, (int) (DUST * gp_recipe_value(r, "dust")), seed);
    add_scratches(s, (int) (SCRATCHES * gp_recipe_value(r, "scratches")),
                  seed + 1);
    const int lashes = (int) (LASHES * gp_recipe_value(r, "lashes"));
    gp_stain_lashes(lashes, s->radius, s->turn, seed + 2,
                    s->stain + s->stains);
    s->stains += lashes * GP_LASH_PARTS;
    s->z4 = 550.0 * gp_recipe_value(r, "defocus");
    s->z6 = 550.0 * gp_recipe_value(r, "astigmatism");
    s->z8 = 550.0 * gp_recipe_value(r, "coma");
    s->z11 = 550.0 * gp_recipe_value(r, "spherical");
    // slopes at the rim
    const double steep = 4.0 * sqrt(3.0) * fabs(s->z4) +
                         2.0 * sqrt(6.0) * fabs(s->z6) +
                         7.0 * sqrt(8.0) * fabs(s->z8) +
                         12.0 * sqrt(5.0) * fabs(s->z11);
    // a mask's corners, turned
    const double wide = mask ? fabs(cos(s->turn)) + fabs(sin(s->turn)) : 1.0;
    const struct gp_diffraction d = {
        .name = mask && mask->path ? mask->path : "aperture",
        .diameter = 2.0 * s->radius * wide, .reach = gp_recipe_value(r, "reach"),
        .nm = gp_recipe_value(r, "wavelength"),
        .bands = (int) gp_recipe_value(r, "wavelengths"),
        .steep = steep / s->radius, .draw = draw_iris, .ctx = s,
    };
    st = gp_diffract(log, &d, f, out);
    gp_free(s);
    return st;
}

const struct gp_model gp_model_aperture = {
    .name = "aperture", .text = "spikes and speckle of a lens' iris",
    .source = "Fraunhofer diffraction: Goodman, Fourier Optics, eq. 4-25",
    .keys = aperture_keys, .open = open_aperture,
};
