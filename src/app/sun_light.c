#include "app/sun.h"

#include "core/memory.h"
#include "sun/occluder.h"

#include <math.h>

/* Pixels from a disc's centre pixel to its last one. */
static int reach(double radius)
{
    return radius > 0.5 ? (int) ceil(radius - 0.5) : 0;
}

size_t gp_disc_room(double radius)
{
    const size_t side = 2 * (size_t) reach(radius) + 2; // bilinear: one more
    return side * side;
}

gp_status gp_disc_pixels_make(const struct gp_log *log, double radius,
                              struct gp_disc_pixels *out)
{
    const int m = reach(radius);
    const size_t side = 2 * (size_t) m + 1;
    void *v;
    gp_status st = gp_alloc(log, "disc of a light", side * side,
                            sizeof(float), &v);
    if (st)
        return st;
    float *const weight = v;
    if (m == 0) {
        weight[0] = 1.0f;
    } else {
        const double all = acos(-1.0) * radius * radius;
        for (int y = -m; y <= m; y++) {
            for (int x = -m; x <= m; x++)
                weight[(size_t) (y + m) * side + (size_t) (x + m)] = (float)
                    (gp_disc_pixel_area(0.5, 0.5, radius, x, y) / all);
        }
    }
    *out = (struct gp_disc_pixels) {m, weight};
    return GP_OK;
}

/* Weight of pixel (x, y) from the centre pixel; 0 outside. */
static double weight_at(const struct gp_disc_pixels *d, int x, int y)
{
    const int m = d->m;
    const size_t side = 2 * (size_t) m + 1;
    if (x < -m || x > m || y < -m || y > m)
        return 0.0;
    return (double) d->weight[(size_t) (y + m) * side + (size_t) (x + m)];
}

void gp_disc_light(const struct gp_disc_pixels *d, const struct gp_light *l,
                   struct gp_rect frame, struct gp_source *list, size_t *n)
{
    const double left = floor(l->x - 0.5), top = floor(l->y - 0.5);
    const double fx = l->x - 0.5 - left, fy = l->y - 0.5 - top;
    const int m = d->m;
    if (!(fabs(left) < 1e8 && fabs(top) < 1e8))
        return;
    for (int y = -m; y <= m + 1; y++) {
        for (int x = -m; x <= m + 1; x++) {
            const int px = (int) left + x, py = (int) top + y;
            if (px < frame.x0 || px >= frame.x1 || py < frame.y0 ||
                py >= frame.y1)
                continue;
            const double w =
                (1.0 - fy) * ((1.0 - fx) * weight_at(d, x, y) +
                              fx * weight_at(d, x - 1, y)) +
                fy * ((1.0 - fx) * weight_at(d, x, y - 1) +
                      fx * weight_at(d, x - 1, y - 1));
            if (!(w > 0.0))
                continue;
            struct gp_source *const e = &list[(*n)++];
            *e = (struct gp_source) {.x = px - frame.x0, .y = py - frame.y0};
            for (int c = 0; c < 3; c++)
                e->rgb[c] = (float) (w * l->visibility * (double) l->flux[c]);
        }
    }
}
