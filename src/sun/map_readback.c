/* Counts visible shares on the CPU: of a region that is drawn and waited for,
 * the paper's other method ("lens flare occlusion"); and the plain form of the
 * sun map. */
#include "sun/sun_priv.h"

#include "core/memory.h"

#include <math.h>

// -- the region under a light ------------------------------------------------

/* Half of the light's width at `down` from its centre; under 0: outside. */
static double half_width(const struct gp_map_light *l,
                         enum gp_sun_pattern pattern, double down)
{
    const double r = l->radius;
    if (fabs(down) > r)
        return -1.0;
    return pattern == GP_PATTERN_DISC ? sqrt(r * r - down * down) : r;
}

/* Returns the visible share of a light: over the pixels whose centres are in
 * it, or in the pixel under its centre when it holds none.
 *   rgba  the region of l->box; NULL when none of it is in the frame */
static double count_region(const struct gp_map_light *l,
                           const struct gp_occluders *o,
                           const struct gp_map_params *p, const float *rgba)
{
    enum { BY_ROWS = 2048 }; // radius; over it the area is right to 1e-5
    const int w = gp_rect_w(o->frame), h = gp_rect_h(o->frame);
    const struct gp_rect box = l->box;
    const double r = l->radius;
    double all = 0.0; // pixel centres in the light, on an unbounded plane
    if (r > BY_ROWS)
        all = (p->pattern == GP_PATTERN_DISC ? M_PI : 4.0) * r * r;
    else
        for (double y = floor(l->y - r); y <= l->y + r; y += 1.0) {
            const double half = half_width(l, p->pattern, y + 0.5 - l->y);
            if (half >= 0.0)
                all += floor(l->x + half - 0.5) + 1.0 - ceil(l->x - half - 0.5);
        }
    double shown = 0.0, weight = 0.0;
    float outside[2];
    gp_map_outside(p->outside, outside);
    if (!(all > 0.0)) {
        const int x = gp_map_pixel_at(l->x, w), y = gp_map_pixel_at(l->y, h);
        const bool inside = rgba && x >= 0 && x < w && y >= 0 && y < h;
        const float *const at =
            inside ? rgba + 4 * ((size_t) (y - box.y0) *
                                     (size_t) gp_rect_w(box) +
                                 (size_t) (x - box.x0))
                   : outside;
        return at[1] > 0.0f ? (double) at[0] / (double) at[1] : 0.0;
    }
    for (int y = box.y0; rgba && y < box.y1; y++) {
        const float *const row = rgba + 4 * (size_t) (y - box.y0) *
                                            (size_t) gp_rect_w(box);
        const double half = half_width(l, p->pattern, y + 0.5 - l->y);
        const double first = ceil(l->x - half - 0.5);
        const double end = floor(l->x + half - 0.5) + 1.0;
        if (half < 0.0)
            continue;
        const int to = end < box.x0   ? box.x0
                       : end > box.x1 ? box.x1
                                      : (int) end;
        for (int x = first > box.x0 ? (int) fmin(first, to) : box.x0; x < to;
             x++) {
            shown += (double) row[4 * (x - box.x0)];
            weight += (double) row[4 * (x - box.x0) + 1];
        }
    }
    const double beyond = all > weight ? all - weight : 0.0;
    shown += beyond * (double) outside[0];
    weight += beyond * (double) outside[1];
    return weight > 0.0 ? shown / weight : 0.0;
}

gp_status gp_sun_readback(const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_occluders *o, const struct gp_map_params *p,
    struct gp_light *light, int n, struct gp_sun_map **state)
{
    float intensity[4 * GP_LIGHTS_MAX] = {0}, *rgba = NULL;
    gp_status st;
    GP_TRY(gp_map_begin(log, gl, o, p, light, n, state));
    struct gp_sun_map *const s = *state;
    GP_TRY(gp_map_use(log, gl, s, GP_SUN_PIXELS));
    for (int i = 0; i < n; i++) {
        const struct gp_map_light *const l = &s->light[i];
        const int w = gp_rect_w(l->box), h = gp_rect_h(l->box);
        const bool drawn = l->k && w && h;
        const struct gp_uniform uniform[] = {
            {.name = "pixels", .texture = &s->pixels},
            {.name = "lights", .texture = &s->lights},
            {.name = "first", .v = {l->box.x0, l->box.y0}},
            {.name = "size", .v = {w, h}},
            {.name = "light", .v = {i, 0}},
            {0},
        };
        const struct gp_draw draw = {
            .program = &s->program[GP_SUN_PIXELS], .target = &s->region,
            .cut = {0, 0, w, h}, .view = {0, 0, w, h}, .uniform = uniform,
            .vertices = 6, .instances = 1, .replace = true,
        };
        if (drawn && (s->region.colour.w < w || s->region.colour.h < h)) {
            gp_target_free(gl, &s->region);
            GP_TRY(gp_target_make(log, gl, "region under a light",
                                  GP_TEXEL_FLOAT, 1, w, h, &s->region));
        }
        if (drawn) { // and waited for
            GP_TRY(gp_draw_run(log, gl, &draw));
            GP_TRY(gp_alloc(log, "region under a light",
                            (size_t) w * (size_t) h, 4 * sizeof(float), &rgba));
            gp_target_read(gl, &s->region, 0, (struct gp_rect) {0, 0, w, h},
                           rgba);
        }
        light[i].visibility = l->k ? count_region(l, o, p, rgba) : 0.0;
        GP_FREE(rgba);
        intensity[4 * i] = (float) light[i].visibility;
        intensity[4 * i + 1] = 1.0f;
    }
    gp_texture_write(gl, &s->intensity.colour, (struct gp_rect) {0, 0, n, 1},
                     intensity);
    GP_TRY(gp_gl_check(log, gl, "sun readback"));
    s->n = n;
    s->map = 0;
out:
    gp_free(rgba);
    return st;
}

double gp_sun_map_reference(const struct gp_occluders *o,
    const struct gp_map_params *p, const struct gp_light *light, float *map)
{
    const struct gp_map_light l = gp_map_light_of(o, p->side, light);
    const int w = gp_rect_w(o->frame), h = gp_rect_h(o->frame);
    const int side = p->side * l.k, count = l.k * l.k;
    double shown = 0.0, weight = 0.0;
    float outside[2];
    gp_map_outside(p->outside, outside);
    for (int texel = 0; texel < p->side * p->side; texel++) {
        const int i = texel % p->side, j = texel / p->side;
        double r = 0.0, g = 0.0;
        for (int n = 0; n < count; n++) {
            double x, y;
            gp_pattern_place(p->pattern, (i * l.k + n % l.k + 0.5) / side,
                             (j * l.k + n / l.k + 0.5) / side, &x, &y);
            const int px = gp_map_pixel_at(l.x + l.radius * x, w);
            const int py = gp_map_pixel_at(l.y + l.radius * y, h);
            const bool inside = px >= 0 && px < w && py >= 0 && py < h;
            r += inside ? gp_occluders_show(o, light, px + o->frame.x0,
                                            py + o->frame.y0)
                        : (double) outside[0];
            g += inside ? 1.0 : (double) outside[1];
        }
        r /= count ? count : 1;
        g /= count ? count : 1;
        shown += r;
        weight += g;
        if (map) {
            map[2 * texel] = (float) r;
            map[2 * texel + 1] = (float) g;
        }
    }
    return weight > 0.0 ? shown / weight : 0.0;
}
