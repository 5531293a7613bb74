#include "sun/sun_priv.h"

#include "core/memory.h"

#include <math.h>

struct counted {
    double shown, weight;
};

/* Columns [*from, *to) of [0, w) whose centres are in the light at row y. */
static void row_span(const struct gp_map_light *s, enum gp_sun_pattern pattern,
                     double y, int w, int *from, int *to)
{
    const double down = y + 0.5 - s->y;
    double half = s->radius;
    *from = *to = 0;
    if (fabs(down) > half)
        return;
    if (pattern == GP_PATTERN_DISC)
        half = sqrt(half * half - down * down);
    const double first = ceil(s->x - half - 0.5);
    const double end = floor(s->x + half - 0.5) + 1.0;
    *from = first < 0.0 ? 0 : first > w ? w : (int) first;
    *to = end < 0.0 ? 0 : end > w ? w : (int) end;
}

/* How many pixel centres are in the light, on an unbounded plane. */
static double centres(const struct gp_map_light *s, enum gp_sun_pattern pattern)
{
    enum { BY_ROWS = 2048 }; // radius; the area is then right to 1e-5
    const double r = s->radius;
    if (r > BY_ROWS)
        return pattern == GP_PATTERN_DISC ? M_PI * r * r : 4.0 * r * r;
    double n = 0.0;
    for (double y = floor(s->y - r); y <= s->y + r; y += 1.0) {
        const double down = y + 0.5 - s->y;
        if (fabs(down) > r)
            continue;
        const double half = pattern == GP_PATTERN_DISC
                                ? sqrt(r * r - down * down) : r;
        n += floor(s->x + half - 0.5) + 1.0 - ceil(s->x - half - 0.5);
    }
    return n;
}

/* Pixels of the frame, from the region of s->box that was read. */
static struct counted count_inside(const struct gp_map_light *s,
                                   enum gp_sun_pattern pattern,
                                   const float *rgba)
{
    const int w = gp_rect_w(s->box);
    struct counted c = {0};
    for (int y = s->box.y0; y < s->box.y1; y++) {
        const float *const row = rgba + 4 * (size_t) (y - s->box.y0) *
                                            (size_t) w;
        int from, to;
        row_span(s, pattern, y, s->box.x1, &from, &to);
        for (int x = from > s->box.x0 ? from : s->box.x0; x < to; x++) {
            c.shown += (double) row[4 * (x - s->box.x0)];
            c.weight += (double) row[4 * (x - s->box.x0) + 1];
        }
    }
    return c;
}

/* The pixel that the centre falls in, for a light between all centres. */
static struct counted count_nearest(const struct gp_map_light *s, int w, int h,
                                    const float outside[2], const float *rgba)
{
    const int x = gp_map_pixel_at(s->x, w), y = gp_map_pixel_at(s->y, h);
    if (!rgba || x < 0 || x >= w || y < 0 || y >= h)
        return (struct counted) {(double) outside[0], (double) outside[1]};
    const size_t at = (size_t) (y - s->box.y0) * (size_t) gp_rect_w(s->box) +
                      (size_t) (x - s->box.x0);
    return (struct counted) {(double) rgba[4 * at], (double) rgba[4 * at + 1]};
}

static double count(const struct gp_map_light *s, const struct gp_occluders *o,
                    const struct gp_sun_params *p, const float *rgba)
{
    float outside[2];
    gp_map_outside(p->outside, outside);
    const double all = centres(s, p->pattern);
    struct counted c = {0};
    if (rgba) // some of the region is in the frame
        c = count_inside(s, p->pattern, rgba);
    const double beyond = all > c.weight ? all - c.weight : 0.0;
    c.shown += beyond * (double) outside[0];
    c.weight += beyond * (double) outside[1];
    if (!(all > 0.0))
        c = count_nearest(s, gp_rect_w(o->frame), gp_rect_h(o->frame), outside,
                          rgba);
    return c.weight > 0.0 ? c.shown / c.weight : 0.0;
}

/* -- drawing ----------------------------------------------------------------*/

static gp_status fit_region(const struct gp_log *log, const struct gp_gl *gl,
                            struct gp_sun_map *s, int w, int h)
{
    struct gp_target *const t = &s->region;
    if (t->colour.w >= w && t->colour.h >= h)
        return GP_OK;
    gp_target_free(gl, t);
    return gp_target_make(log, gl, "region under a light", GP_TEXEL_FLOAT, 1, w,
                          h, t);
}

static gp_status draw_region(const struct gp_log *log, const struct gp_gl *gl,
                             struct gp_sun_map *s, int i)
{
    const struct gp_rect box = s->spot[i].box;
    const int w = gp_rect_w(box), h = gp_rect_h(box);
    const struct gp_uniform uniform[] = {
        {.name = "pixels", .texture = &s->pixels},
        {.name = "lights", .texture = &s->lights},
        {.name = "first", .v = {box.x0, box.y0}},
        {.name = "size", .v = {w, h}},
        {.name = "light", .v = {i, 0}},
        {0},
    };
    const struct gp_draw draw = {
        .program = &s->program[GP_SUN_PIXELS], .target = &s->region,
        .cut = {0, 0, w, h}, .view = {0, 0, w, h}, .uniform = uniform,
        .vertices = 6, .instances = 1, .replace = true,
    };
    gp_status st = fit_region(log, gl, s, w, h);
    return st ? st : gp_draw_run(log, gl, &draw);
}

/* Draws the region under light i, waits for it, and counts. */
static gp_status look_at(const struct gp_log *log, const struct gp_gl *gl,
                         const struct gp_occluders *o,
                         const struct gp_sun_params *p, struct gp_sun_map *s,
                         int i, double *visibility)
{
    const struct gp_map_light *const spot = &s->spot[i];
    const int w = gp_rect_w(spot->box), h = gp_rect_h(spot->box);
    float *rgba = NULL;
    gp_status st = GP_OK;
    *visibility = 0.0;
    if (!spot->k)
        return GP_OK;
    if (w && h) {
        GP_TRY(draw_region(log, gl, s, i));
        GP_TRY(gp_alloc(log, "region under a light", (size_t) w * (size_t) h,
                        4 * sizeof(float), (void **) &rgba));
        gp_target_read(gl, &s->region, 0, (struct gp_rect) {0, 0, w, h}, rgba);
    }
    *visibility = count(spot, o, p, rgba);
out:
    gp_free(rgba);
    return st;
}

gp_status gp_sun_readback(const struct gp_log *log, const struct gp_gl *gl,
                          const struct gp_occluders *o,
                          const struct gp_sun_params *p,
                          struct gp_light *light, int n,
                          struct gp_sun_map **state)
{
    float intensity[4 * GP_LIGHTS_MAX] = {0};
    gp_status st;
    GP_TRY(gp_map_begin(log, gl, o, p, light, n, state));
    struct gp_sun_map *const s = *state;
    GP_TRY(gp_map_use(log, gl, s, GP_SUN_PIXELS));
    for (int i = 0; i < n; i++) {
        GP_TRY(look_at(log, gl, o, p, s, i, &light[i].visibility));
        intensity[4 * i] = (float) light[i].visibility;
        intensity[4 * i + 1] = 1.0f;
    }
    gp_texture_write(gl, &s->intensity.colour, (struct gp_rect) {0, 0, n, 1},
                     intensity);
    GP_TRY(gp_gl_check(log, gl, "sun readback"));
    s->n = n;
    s->map = 0;
out:
    return st;
}

/* What one sample adds to r and g. */
static void add_sample(const struct gp_occluders *o,
                       const struct gp_light *light,
                       const struct gp_map_light *s, double x, double y,
                       const float outside[2], double sum[2])
{
    const int w = gp_rect_w(o->frame), h = gp_rect_h(o->frame);
    const int px = gp_map_pixel_at(s->x + s->radius * x, w);
    const int py = gp_map_pixel_at(s->y + s->radius * y, h);
    if (px < 0 || px >= w || py < 0 || py >= h) {
        sum[0] += (double) outside[0];
        sum[1] += (double) outside[1];
        return;
    }
    sum[0] += gp_occluders_show(o, light, px + o->frame.x0, py + o->frame.y0);
    sum[1] += 1.0;
}

static void add_texel(const struct gp_occluders *o,
                      const struct gp_sun_params *p,
                      const struct gp_light *light,
                      const struct gp_map_light *s, int i, int j,
                      double texel[2])
{
    float outside[2];
    gp_map_outside(p->outside, outside);
    texel[0] = texel[1] = 0.0;
    for (int n = 0; n < s->k * s->k; n++) {
        const int side = p->map * s->k;
        const double u = (i * s->k + n % s->k + 0.5) / side;
        const double v = (j * s->k + n / s->k + 0.5) / side;
        double x, y;
        gp_pattern_place(p->pattern, u, v, &x, &y);
        add_sample(o, light, s, x, y, outside, texel);
    }
    texel[0] /= s->k ? s->k * s->k : 1;
    texel[1] /= s->k ? s->k * s->k : 1;
}

double gp_sun_map_reference(const struct gp_occluders *o,
                            const struct gp_sun_params *p,
                            const struct gp_light *light, float *map)
{
    const struct gp_map_light s = gp_map_light_of(o, p->map, light);
    double shown = 0.0, weight = 0.0;
    for (int j = 0; j < p->map; j++) {
        for (int i = 0; i < p->map; i++) {
            double texel[2];
            add_texel(o, p, light, &s, i, j, texel);
            shown += texel[0];
            weight += texel[1];
            if (!map)
                continue;
            map[2 * (j * p->map + i)] = (float) texel[0];
            map[2 * (j * p->map + i) + 1] = (float) texel[1];
        }
    }
    return weight > 0.0 ? shown / weight : 0.0;
}
