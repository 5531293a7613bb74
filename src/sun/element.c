// SPDX-License-Identifier: Apache-2.0
/* Closed forms of flare elements, measured in pixels: tables of their profiles,
 * rays, areas, and rows of them and of images.
 *
 * With (x, y) a pixel's centre less the element's place, turned into the
 * element's axes and y divided by its aspect's factor, R the radius:
 *
 *   round shapes   T(t) * g(direction)      t = norm(x, y) / R
 *   rays           sum of T(a / (L R)) * section(b)   a along, b across a ray
 *
 * A hard edge is a ramp of m pixels, m the larger of |x| and |y| of a unit vector
 * across it, so that a straight one of any direction covers, summed over pixels, its
 * exact area. In a table all ramps are a pixel wide, and t is moved to fit.
 *
 * The norm is the distance, or a polygon's, or between the two. T is the
 * profile with its edges, which are at least a pixel wide, integrated over
 * wavelengths where it is dispersed: light of size s is f(t / s) / s^2, or / s
 * along rays. */
#include "core/colour.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/murmur.h"
#include "sun/flare_priv.h"

#include <math.h>
#include <string.h>

enum { BANDS = 40, ANGLES = 5040 }; // ANGLES: a multiple of most sides

double gp_flare_random(int seed, int i)
{
    const uint32_t h =
        0x85ebca6bu * (uint32_t) seed + 0x9e3779b9u * (uint32_t) (i + 1);
    return (double) gp_murmur3("", 0, h) / 4294967296.0; // of no bytes
}

static bool has_rays(const struct gp_flare_element *e)
{
    return e->shape == GP_FLARE_STREAK || e->shape == GP_FLARE_SPIKES;
}

// -- profiles ----------------------------------------------------------------

/* Brightness at q in [0, 1] from middle to rim, without edges. */
static double body(const struct gp_flare_element *e, double q)
{
    const double p = gp_maxd(gp_mind(q, 1.0), 0.0);
    double v = 1.0;
    if (e->profiles) {
        const double at = p * (e->profiles - 1);
        const int i = gp_min((int) at, e->profiles - 2);
        v = (double) e->profile[i] +
            (at - i) * ((double) e->profile[i + 1] - (double) e->profile[i]);
    } else if (has_rays(e)) {
        v = (1.0 - p) * (1.0 - p);
    } else if (e->shape == GP_FLARE_GLOW || e->shape == GP_FLARE_DIRT) {
        const double end = gp_exp(-e->falloff);
        v = (gp_exp(-e->falloff * p) - end) / (1.0 - end);
    } else if (e->shape == GP_FLARE_CAUSTIC) {
        v = 1.0 / sqrt(1.0 - p + 0.02); // a fold: 1 / sqrt of the distance
    }
    return v + e->rim * gp_exp(-20.0 * (1.0 - p));
}

/* Coverage inside an edge at distance d (over 0: inside), of a ramp a pixel or
 * more wide around it, or of one `soft` wide inside it where that is more. */
static double edge(double d, double pixel, double soft)
{
    return soft > pixel ? gp_smoothstep(d / soft)
                        : gp_maxd(gp_mind(0.5 + d / pixel, 1.0), 0.0);
}

/* Radius of a ring's hole at radius r pixels, in q; under 0: none. */
static double hole_of(const struct gp_flare_element *e, double r)
{
    return fmin(1.0 - e->width, 1.0 - 1.0 / r); // the band is a pixel or more
}

/* The profile at q of a shape of radius r pixels; `wide` is the least width of
 * its edges in q. */
static double profile_at(const struct gp_flare_element *e, double q, double r,
                         double wide)
{
    const bool rays = has_rays(e);
    if (e->shape != GP_FLARE_RING)
        return body(e, q) * edge(1.0 - q, wide, rays ? 0.0 : e->softness);
    const double inner = hole_of(e, r);
    const double soft = 0.5 * e->softness * (1.0 - inner);
    const double hole = inner > 0.0 ? edge(q - inner, wide, soft) : 1.0;
    return body(e, (q - inner) / (1.0 - inner)) *
           fmax(edge(1.0 - q, wide, soft) + hole - 1.0, 0.0);
}

/* From the middle to a corner, over to a side. */
static double corner_of(const struct gp_flare_element *e)
{
    return e->shape == GP_FLARE_POLYGON ? 1.0 / gp_cos(M_PI / e->sides) : 1.0;
}

/* The gradient of the norm, times R: that of a polygon is larger. */
static double steepness(const struct gp_flare_element *e)
{
    const double poly = corner_of(e);
    return poly + e->round * (1.0 - poly);
}

static double least_radius(const struct gp_flare_element *e)
{
    return has_rays(e) ? 1.5 : 0.5 * corner_of(e);
}

/* The radius of a channel, over that of the element, in pixels. */
static double size_of(const struct gp_flare_element *e, double radius, int c)
{
    return fmax(radius * (double) e->scale[c], least_radius(e)) / radius;
}

/* That of the light which reaches furthest. */
static double largest_size(const struct gp_flare_element *e, double radius)
{
    const double far = e->dispersion > 0.0 ? GP_NM_TO : GP_NM_FROM;
    const double most =
        fmax(size_of(e, radius, 0),
             fmax(size_of(e, radius, 1), size_of(e, radius, 2)));
    return most * (1.0 + e->dispersion * (far - 550.0) / 300.0);
}

/* Notes the hard edges of round shapes in t. */
static void find_edges(struct gp_flare_look *l)
{
    const struct gp_flare_element *const e = &l->e;
    const bool ring = e->shape == GP_FLARE_RING;
    if (e->softness > 0.0 || e->dispersion != 0.0 || l->aspect != 1.0 ||
        has_rays(e) || e->shape == GP_FLARE_GLOW || e->shape == GP_FLARE_DIRT)
        return;
    for (int c = 0; c < 3; c++) {
        const double size = size_of(e, l->radius, c);
        const double hole = ring ? hole_of(e, size * l->radius) : 0.0;
        if (c > 0 && e->scale[c] == e->scale[c - 1])
            continue;
        l->edge[l->edges++] = (float) size;
        if (hole > 0.0)
            l->edge[l->edges++] = (float) (hole * size);
    }
}

/* Fills the tables of all channels. Errors: GP_ERR_BUG memory. */
static gp_status make_table(const struct gp_log *log, struct gp_flare_look *l)
{
    const struct gp_flare_element *const e = &l->e;
    const bool spread = e->dispersion != 0.0 && e->shape != GP_FLARE_DIRT;
    const int bands = spread ? BANDS : 1;
    const double thin = fmin(1.0, e->aspect);
    double nm[BANDS] = {550.0}, rgb[BANDS][3] = {{1.0, 1.0, 1.0}};
    double size[3], value = 0.0;
    if (spread)
        gp_spectrum_weights(gp_rec709_chromaticities, BANDS, nm, rgb);
    for (int c = 0; c < 3; c++)
        size[c] = size_of(e, l->radius, c);
    // edges reach half a pixel beyond
    l->extent = largest_size(e, l->radius) + steepness(e) / (l->radius * thin);
    l->n = gp_max(2048, (int) fmin(4.0 * l->extent * l->radius, 65536.0));
    l->per_t = l->n / l->extent;
    gp_status st = gp_alloc_zero(log, "a flare element's profile",
                                 3 * ((size_t) l->n + 2), sizeof *l->table,
                                 &l->table);
    for (int b = 0; b < bands && !st; b++) {
        if (rgb[b][0] + rgb[b][1] + rgb[b][2] < 1e-4)
            continue;
        for (int i = 0; i < 3 * l->n; i++) { // 0 from n on
            const int c = i % 3;
            const double t = i / 3 / l->per_t;
            const double s = size[c] *
                             (1.0 + e->dispersion * (nm[b] - 550.0) / 300.0);
            const double r = fmax(s * l->radius, least_radius(e));
            const double pixel = steepness(e) / (r * thin);
            // as wide as the step to the next band: none shows
            const double step = fabs(e->dispersion) * 1.5 * t / s *
                                (GP_NM_TO - GP_NM_FROM) / (300.0 * BANDS);
            const double wide = fmax(pixel, spread ? step : 0.0);
            if (c == 0 || size[c] != size[c - 1])
                value = profile_at(e, t * l->radius / r, r, wide) /
                        (has_rays(e) ? s : s * s);
            l->table[i] += (float) (rgb[b][c] * value);
        }
    }
    return st;
}

// -- rays --------------------------------------------------------------------

/* Angle (counter-clockwise from the element's), length and half width of ray i,
 * the last two as fractions of the radius. */
static void make_rays(struct gp_flare_look *l)
{
    const struct gp_flare_element *const e = &l->e;
    const bool spikes = e->shape == GP_FLARE_SPIKES;
    for (int i = 0; i < l->rays; i++) {
        struct gp_flare_ray *const r = &l->ray[i];
        const double less[3] = {gp_flare_random(e->seed, 3 * i),
                                gp_flare_random(e->seed, 3 * i + 1),
                                gp_flare_random(e->seed, 3 * i + 2) - 0.5};
        const double turn = spikes
            ? (i + e->random * less[2]) * 2.0 * M_PI / l->rays
            : l->rays == 1 ? 0.0
            : (i / (l->rays - 1.0) - 0.5 + e->random * less[2] / l->rays) *
                  e->spread * M_PI / 180.0;
        const double length = 1.0 - 0.9 * e->random * less[0];
        const double half = fmax(l->radius * e->width, spikes ? 0.1 : 0.5) *
                            (1.0 - 0.9 * e->random * less[1]);
        *r = (struct gp_flare_ray) {
            .c = (float) gp_cos(turn),
            .s = (float) -gp_sin(turn), // y is down
            .per_t = (float) (l->per_t / (l->radius * length)),
            .half = (float) (spikes ? half : fmax(half, 0.5)),
            .length = length,
        };
    }
}

/* Section of a spike: a Gaussian that thins towards its end, wide as a pixel or
 * more, of the same sum across. */
static float spike_section(float b, float half, float left)
{
    const float own = 0.6f * half * left, var = own * own + 0.3f;
    const float z = b * b / var;
    return z > 24.0f ? 0.0f
                     : own / sqrtf(var) * (float) gp_exp(-0.5 * (double) z);
}

/* Section of a streak: a band with edges of that steepness, or softer. */
static float streak_section(float b, float half, float steep, float soft)
{
    const float most = gp_minf(steep, 1.0f / gp_maxf(soft * half, 1e-6f));
    const float v = fabsf(b);
    return gp_clamp01(0.5f + (half - v) * most) -
           gp_clamp01(0.5f - (half + v) * most);
}

// -- areas -------------------------------------------------------------------

/* Norm over R. Of a polygon, *side is the side that counts. */
static float norm_of(const struct gp_flare_look *l, float x, float y, int *side)
{
    const float rho = sqrtf(x * x + y * y);
    if (l->e.shape != GP_FLARE_POLYGON)
        return rho * l->pixel;
    float most = 0.0f;
    for (int i = 0; i < l->e.sides; i++) {
        const float v = l->side[i][0] * x + l->side[i][1] * y;
        *side = v > most ? i : *side;
        most = gp_maxf(most, v);
    }
    const float round = (float) l->e.round;
    return (most + round * (rho - most)) * l->pixel;
}

/* Factor of the direction. */
static float direction_of(const struct gp_flare_look *l, float x, float y)
{
    const struct gp_flare_element *const e = &l->e;
    if (e->shape == GP_FLARE_CAUSTIC) { // brightest along the rotation
        const float rho = gp_maxf(sqrtf(x * x + y * y), 1e-20f);
        const float v = 0.5f + 0.5f * x / rho;
        return v * v;
    }
    if (e->shape == GP_FLARE_RING && e->completion < 1.0) {
        const float at = (float) (fabs(gp_atan2((double) y, (double) x)) /
                                  (M_PI * e->completion));
        const float ends = gp_maxf((float) e->feather, l->pixel);
        const float v = gp_clamp01((1.0f - at) / ends);
        return v * v * (3.0f - 2.0f * v);
    }
    return 1.0f;
}

/* Sums over an unbounded plane, in square pixels. */
static void find_areas(struct gp_flare_look *l)
{
    const bool rays = has_rays(&l->e);
    double plane = 0.0, across = 0.0; // of all directions at t = 1; of sections
    for (int i = 0; i < ANGLES && !rays; i++) {
        const double a = 2.0 * M_PI * (i + 0.5) / ANGLES;
        const float x = (float) gp_cos(a), y = (float) gp_sin(a);
        int side = 0;
        const double t = (double) norm_of(l, x, y, &side); // r = 1 / t
        plane += (double) direction_of(l, x, y) / (t * t) * 2.0 * M_PI / ANGLES;
    }
    for (int c = 0; c < 3; c++) {
        double sum = 0.0, thin = 0.0;
        for (int i = 0; i < l->n; i++) { // trapezia: linear between
            const double t = i / l->per_t, v = (double) l->table[3 * i + c];
            const double weight = (i ? 1.0 : 0.5) / l->per_t;
            sum += (rays ? v : v * t) * weight;
            thin += v * fmax(1.0 - t / l->extent, 0.0) * weight;
        }
        across = 0.0;
        for (int i = 0; i < l->rays; i++)
            across += l->ray[i].length * (double) l->ray[i].half *
                (l->e.shape == GP_FLARE_SPIKES
                     ? 0.6 * sqrt(2.0 * M_PI) * thin
                     : 4.0 * sum); // both ways
        l->area[c] = rays ? across * l->radius * l->aspect
                          : plane * sum * l->aspect;
    }
}

// -- a look ------------------------------------------------------------------

gp_status gp_flare_look_make(const struct gp_log *log,
    const struct gp_flare_element *e, double diameter,
    struct gp_flare_look *out)
{
    struct gp_flare_look l = {.e = *e};
    gp_status st;
    l.diameter = diameter;
    l.radius = fmax(0.5 * diameter, least_radius(e));
    l.pixel = (float) (1.0 / l.radius);
    l.across = (float) (l.radius / steepness(e));
    l.aspect = has_rays(e) || e->shape == GP_FLARE_DIRT ? 1.0
                                                                 : e->aspect;
    for (int i = 0; e->shape == GP_FLARE_POLYGON && i < e->sides; i++) {
        const double a = (i + 0.5) * 2.0 * M_PI / e->sides;
        l.side[i][0] = (float) (gp_cos(a) * corner_of(e));
        l.side[i][1] = (float) (-gp_sin(a) * corner_of(e));
    }
    GP_TRY(make_table(log, &l));
    if (has_rays(e)) {
        l.rays = e->count;
        GP_TRY(gp_alloc(log, "rays of a flare element", (size_t) l.rays,
                        sizeof *l.ray, &l.ray));
        make_rays(&l);
    }
    find_edges(&l);
    find_areas(&l);
    *out = l;
    l = (struct gp_flare_look) {0};
out:
    gp_flare_look_free(&l);
    return st;
}

void gp_flare_look_free(struct gp_flare_look *l)
{
    gp_free(l->table);
    gp_free(l->ray);
    *l = (struct gp_flare_look) {0};
}

double gp_flare_look_reach(const struct gp_flare_element *e, double diameter)
{
    const double r = fmax(0.5 * diameter, least_radius(e));
    const bool rays = has_rays(e);
    const double along =
        r * largest_size(e, r) * (rays ? 1.0 : fmax(e->aspect, 1.0));
    return along + 1.0 + steepness(e) / fmin(1.0, e->aspect) +
           (rays ? 3.0 * fmax(r * e->width, 0.5) + 3.0 : 0.0);
}

// -- rows of images -----------------------------------------------------------

static float blend(float a, float b, float t)
{
    return a * (1.0f - t) + b * t;
}

/* Far outside, where this texel and the next are none. */
static int clamp_texel(float v, int size)
{
    return (int) gp_maxf(-2.0f, gp_minf(v, (float) size));
}

/* Bilinear sample: of texel (x, y) and the next ones, by the shares of these. */
static float mix(const struct gp_flare_image *m, int c, int x, int y,
                 float right, float below)
{
    float v[4];
    for (int k = 0; k < 4; k++)
        v[k] = gp_planes_at(&m->rgb, c, m->w, m->h, x + k % 2, y + k / 2);
    return blend(blend(v[0], v[1], right), blend(v[2], v[3], right), below);
}

/* The same at a place in texels; 0 outside. */
static float sample(const struct gp_flare_image *m, int c, float x, float y)
{
    const float u = x - 0.5f, v = y - 0.5f;
    const float left = floorf(u), top = floorf(v);
    return mix(m, c, clamp_texel(left, m->w), clamp_texel(top, m->h), u - left,
               v - top);
}

static void add_image(const struct gp_flare_quad *q, int y,
                      const float amount[3], float *const out[3])
{
    const int row = y - q->rect.y0, n = gp_rect_w(q->rect);
    const float py = q->base[1] + (float) row;
    for (int c = 0; c < 3; c++) {
        const float cosine = q->turn[0] * q->radius[c];
        const float sine = q->turn[1] * q->radius[c];
        for (int i = 0; i < n && q->plain; i++)
            out[c][i] += amount[c] * mix(q->image, c, q->corner[0] + i,
                                         q->corner[1] + row, q->fraction[0],
                                         q->fraction[1]);
        for (int i = 0; i < n && !q->plain; i++) {
            const float px = q->base[0] + (float) i;
            const float u = px * cosine - py * sine + q->inner[0];
            const float v = px * sine + py * cosine + q->inner[1];
            out[c][i] += amount[c] * sample(q->image, c, u, v);
        }
    }
}

// -- rows of looks ------------------------------------------------------------

/* Moves t where it is within half a pixel of a hard edge across (x, y). */
static float fit_edges(const struct gp_flare_look *l, float t, float x, float y)
{
    const float m = gp_maxf(fabsf(x), fabsf(y)) /
                    gp_maxf(sqrtf(x * x + y * y), 1e-20f);
    for (int i = 0; i < l->edges; i++) {
        const float d = (t - l->edge[i]) * l->across;
        if (fabsf(d) < 0.5f) {
            const float more = fabsf(d) < 0.5f * m ? fabsf(d) / m
                                                   : fabsf(d) + 0.5f - 0.5f * m;
            return l->edge[i] + copysignf(more, d) / l->across;
        }
    }
    return t;
}

/* Adds the table at `at` entries, times v. */
static void look_up(const struct gp_flare_look *l, float at, float v,
                    float out[3])
{
    if (!(at < (float) l->n) || !(v > 0.0f))
        return;
    const int i = (int) at;
    const float rest = at - (float) i;
    const float *const k = l->table + 3 * i;
    for (int c = 0; c < 3; c++)
        out[c] += v * (k[c] + rest * (k[c + 3] - k[c]));
}

/* Value of the element at a pixel of its own axes. */
static void value_at(const struct gp_flare_look *l,
    const struct gp_flare_quad *q, float x, float y, float out[3])
{
    const struct gp_flare_element *const e = &l->e;
    const float per_t = (float) l->per_t;
    if (!l->rays) {
        const float u = x / (float) l->aspect, c = q->turn[0], s = q->turn[1];
        int k = 0;
        float t = norm_of(l, u, y, &k);
        if (l->edges && e->shape == GP_FLARE_POLYGON) { // in the pixels' axes
            x = l->side[k][0];
            y = l->side[k][1];
        }
        if (l->edges)
            t = fit_edges(l, t, x * c + y * s, y * c - x * s);
        look_up(l, t * per_t, direction_of(l, u, y), out);
    }
    for (int i = 0; i < l->rays; i++) {
        const struct gp_flare_ray r = l->ray[i];
        const float a = x * r.c + y * r.s, b = y * r.c - x * r.s;
        if (e->shape == GP_FLARE_SPIKES) {
            const float at = fabsf(a) * r.per_t;
            if (a > -0.5f && at < (float) l->n)
                look_up(l, at, gp_minf(0.5f + a, 1.0f) *
                                   spike_section(b, r.half,
                                                 1.0f - at / (float) l->n),
                        out);
            continue;
        }
        // the ray as the pixels see it
        const float c = r.c * q->turn[0] + r.s * q->turn[1];
        const float s = r.s * q->turn[0] - r.c * q->turn[1];
        look_up(l, fabsf(a) * r.per_t,
                streak_section(b, r.half, 1.0f / gp_maxf(fabsf(c), fabsf(s)),
                               (float) e->softness), out);
    }
}

/* The share of a pixel that the pupil's rim leaves: a disc of the element's
 * radius, moved by q->cut radii. */
static float left_of(const struct gp_flare_look *l,
                     const struct gp_flare_quad *q, float x, float y)
{
    const float r = (float) l->radius;
    const float dx = x - q->cut[0] * r, dy = y - q->cut[1] * r;
    const float soft = gp_maxf(1.0f, (float) l->e.softness * r);
    return gp_clamp01(0.5f + (r - sqrtf(dx * dx + dy * dy)) / soft);
}

static void add_look(const struct gp_flare_quad *q, int y,
                     const float amount[3], float *const out[3])
{
    const struct gp_flare_look *const l = q->look;
    const float py = q->base[1] + (float) (y - q->rect.y0);
    const float c = q->turn[0], s = q->turn[1];
    const bool cut = q->cut[0] != 0.0f || q->cut[1] != 0.0f;
    for (int i = 0; i < gp_rect_w(q->rect); i++) {
        const float px = q->base[0] + (float) i;
        float v[3] = {0};
        value_at(l, q, px * c - py * s, px * s + py * c, v);
        const float left = cut ? left_of(l, q, px, py) : 1.0f;
        for (int k = 0; k < 3; k++) {
            const float dirt = l->e.shape == GP_FLARE_DIRT
                ? sample(q->image, k, px * q->dirt[0] + q->dirt[2],
                                  py * q->dirt[1] + q->dirt[3]) : 1.0f;
            out[k][i] += amount[k] * left * dirt * v[k];
        }
    }
}

void gp_flare_add_row(const struct gp_flare_quad *q, int y,
                      const float amount[3], float *const out[3])
{
    (q->look ? add_look : add_image)(q, y, amount, out);
}
