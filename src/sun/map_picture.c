#include "sun/map_state.h"

#include "core/memory.h"

/* Cells of the atlas after the last light's hold what was there before. */
static bool is_drawn(const struct gp_sun_map *s, bool intensity, size_t texel,
                     int w)
{
    const int x = (int) (texel % (size_t) w), y = (int) (texel / (size_t) w);
    return intensity || y / s->map * s->columns + x / s->map < s->n;
}

gp_status gp_sun_map_picture(const struct gp_log *log, const struct gp_gl *gl,
                             const struct gp_sun_map *s, bool intensity,
                             int *w, int *h, float **out)
{
    if (!s || !s->n || (!intensity && !s->map))
        return gp_fail(log, GP_ERR_USAGE,
                       "--debug %s: no such map was drawn; use --sun or "
                       "--lights, and --sun-method mask",
                       intensity ? "intensity" : "sunmap");
    const struct gp_target *const from = intensity ? &s->intensity : &s->atlas;
    struct gp_rect r = {0, 0, s->n, 1};
    if (!intensity) {
        r.x1 = s->columns * s->map;
        r.y1 = (s->n + s->columns - 1) / s->columns * s->map;
    }
    const size_t n = (size_t) gp_rect_w(r) * (size_t) gp_rect_h(r);
    float *rgba = NULL, *grey = NULL;
    gp_status st;
    GP_TRY(gp_alloc(log, "picture of the sun map", n, 4 * sizeof(float),
                    (void **) &rgba));
    GP_TRY(gp_alloc(log, "picture of the sun map", n, sizeof(float),
                    (void **) &grey));
    gp_target_read(gl, from, r, rgba);
    GP_TRY(gp_gl_check(log, gl, "picture of the sun map"));
    for (size_t i = 0; i < n; i++)
        grey[i] = is_drawn(s, intensity, i, gp_rect_w(r)) &&
                          rgba[4 * i + 1] > 0.0f
                      ? rgba[4 * i] / rgba[4 * i + 1] : 0.0f;
    *w = gp_rect_w(r);
    *h = gp_rect_h(r);
    *out = grey;
    grey = NULL;
out:
    gp_free(rgba);
    gp_free(grey);
    return st;
}
