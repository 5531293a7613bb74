#include "sun/map_state.h"

#include "sun/disc.h"

/* What one sample adds to r and g. */
static void add_sample(const struct gp_occluders *o,
                       const struct gp_light *light,
                       const struct gp_sun_spot *s, double x, double y,
                       const float outside[2], double sum[2])
{
    const int w = gp_rect_w(o->frame), h = gp_rect_h(o->frame);
    const int px = gp_sun_pixel(s->x + s->radius * x, w);
    const int py = gp_sun_pixel(s->y + s->radius * y, h);
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
                      const struct gp_sun_spot *s, int i, int j,
                      double texel[2])
{
    float outside[2];
    gp_sun_outside_counts(p->outside, outside);
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
    const struct gp_sun_spot s = gp_sun_spot_of(o, p->map, light);
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
