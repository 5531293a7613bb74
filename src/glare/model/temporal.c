/* An eye's pupil that shimmers, and particles in the eye: the model `temporal`,
 * after Ritschel, Ihrke, Frisvad, Coppens, Myszkowski, Seidel: Temporal Glare:
 * Real-Time Dynamic Simulation of the Scattering in the Human Eye, Eurographics
 * 2009. */
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/model/model_priv.h"

#include <math.h>

#define PUPIL_MOST 9.0 // mm

double gp_pupil_moon_spencer(double nits)
{
    return 4.9 - 3.0 * tanh(0.4 * log10(nits) - 0.00114);
}

double gp_pupil_watson(double nits, double area, double age)
{
    const double flux = pow(nits * area / 846.0, 0.41);
    const double young = 7.75 - 5.75 * flux / (flux + 2.0);
    return young + (age - 28.58) * (0.02132 - 0.009562 * young);
}

/* Three octaves of even steps between numbers of a seed, in (-1, 1). */
static double noise(double t, uint64_t seed)
{
    double sum = 0.0;
    for (int i = 0; i < 3; i++) {
        const double at = fabs(t) * (1 << i), whole = floor(at);
        const double x = at - whole, s = x * x * (3.0 - 2.0 * x);
        const uint64_t key = 3 * (uint64_t) whole + (uint64_t) i;
        const double a = gp_model_random(seed, key);
        const double b = gp_model_random(seed, key + 3);
        sum += (2.0 * (a + s * (b - a)) - 1.0) / (1 << i);
    }
    return sum / 1.75;
}

double gp_pupil_hippus(double p, double t, double strength, uint64_t seed)
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
    struct gp_stain stain[PARTICLES + EYE_LASHES * GP_LASH_STAINS];
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
    return fmin(fmax((edge * e->radius - r) / cell + 0.5, 0.0), 1.0);
}

static void draw_eye(const void *ctx, const struct gp_pupil *p, int y)
{
    static const double FIBRES = 1.5; // mm: the lens' cortex shows where the
                                      // pupil is over 3 mm wide: Simpson 1953
    const struct eye *const e = ctx;
    const double middle = 0.5 * p->n, end = e->radius + p->cell;
    const double v = (y + 0.5 - middle) * p->cell;
    const double half = sqrt(fmax(end * end - v * v, 0.0)) / p->cell;
    const int from = (int) fmax(floor(middle - half), 0.0);
    const int to = (int) fmin(ceil(middle + half), p->n);
    float *const row = p->t + (size_t) y * (size_t) p->n;
    const double shut = e->shut * e->radius - p->cell;
    if (e->grating > 0.0 && end > FIBRES) {
        const double hole = sqrt(gp_maxd(FIBRES * FIBRES - v * v, 0.0));
        const int left = gp_clamp_whole(middle - hole / p->cell + 1, from, to);
        const int right = gp_clamp_whole(middle + hole / p->cell - 1, left, to);
        gp_grating_row(p->n, y, from, left, e->turn, e->fibres, row);
        gp_grating_row(p->n, y, right, to, e->turn, e->fibres, row);
    }
    for (int x = from; x < to; x++) {
        const double u = (x + 0.5 - middle) * p->cell;
        const double r = sqrt(u * u + v * v);
        double t = r > end ? 0.0 : 1.0;
        if (r > shut && r <= end)
            t = edge_share(e, u, v, r, p->cell);
        if (e->grating > 0.0 && r > FIBRES)
            t *= 1.0 - e->grating * gp_mind(r - FIBRES, 1.0) * (double) row[x];
        row[x] = (float) t;
    }
    gp_stain_row(e->stain, e->stains, p, y);
}

/* Particles in the lens, before it and behind it, which drift as the eye
 * moves. */
static void add_particles(struct eye *e, int n, double t, uint64_t seed)
{
    for (int k = 0; k < n; k++) {
        struct gp_stain *const one = &e->stain[e->stains++];
        const uint64_t key = 4 * (uint64_t) k;
        const bool floats = k % 4 == 0;
        const double r = 0.5 * PUPIL_MOST * sqrt(gp_model_random(seed, key));
        const double a = 2.0 * M_PI * gp_model_random(seed, key + 1) + e->turn +
                         (floats ? 0.3 * noise(0.4 * t, seed + 1) : 0.0);
        const double size = 0.012 * pow(4.0, gp_model_random(seed, key + 2));
        const double shift = 0.05 * noise(t, seed + 2 + (floats ? 1 : 0));
        for (int i = 0; i < 2; i++) {
            one->x[i] = r * cos(a) + shift;
            one->y[i] = -r * sin(a) + 0.5 * shift;
            one->radius[i] = size;
        }
        one->hides = 0.3 + 0.7 * gp_model_random(seed, key + 3);
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
    return gp_pupil_hippus(fmax(p, 1.0), f->frame / f->fps,
                           gp_recipe_value(r, "hippus"),
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
    e->right[0] = cos(e->turn);
    e->right[1] = sin(e->turn);
    for (int i = 0; i < 2 * WAVES; i++)
        e->edge[i / 2][i % 2] =
            0.012 * (gp_model_random(seed + 7, (uint64_t) i) - 0.5);
    e->shut = EDGE;
    for (int i = 0; i < WAVES; i++)
        e->shut -= hypot(e->edge[i][0], e->edge[i][1]);
    e->grating = gp_recipe_value(r, "grating");
    e->fibres = floor(gp_recipe_value(r, "fibres"));
    add_particles(e, (int) (PARTICLES * gp_recipe_value(r, "particles")), t,
                  seed + 8);
    const int lashes = (int) (EYE_LASHES * gp_recipe_value(r, "lashes"));
    gp_stain_lashes(lashes, e->radius, e->turn, seed + 16,
                    e->stain + e->stains);
    e->stains += lashes * GP_LASH_STAINS;
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
