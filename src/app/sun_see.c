#include "app/sun.h"

#include "core/memory.h"
#include "glare/engine.h"
#include "sun/occluder.h"

#include <string.h>

// -- how much shows -----------------------------------------------------------

static gp_status open_gl(const struct gp_log *log, enum gp_gl_api api,
                         struct gp_suns *suns)
{
    return suns->gl ? gp_gl_use(log, suns->gl)
                    : gp_gl_open(log, api, &suns->gl);
}

/* Whether the shares are read right after they are found. A software context
 * shares its memory and its cores with us: nothing stalls, and engines and CPU
 * take a quarter of the time of blended sprites and elements there. */
static bool read_early(const struct gp_sun_params *p, const struct gp_gl *gl)
{
    return p->draw == GP_DRAW_CPU ||
           (p->draw == GP_DRAW_AUTO && gp_gl_info(gl)->software);
}

gp_status gp_suns_see(const struct gp_log *log, const struct gp_settings *s,
                      struct gp_suns *suns)
{
    const struct gp_sun_params *const p = &s->sun.params;
    if (!suns->n)
        return GP_OK;
    if (p->method == GP_SUN_EXACT) {
        gp_sun_exact(&suns->occluders, p->outside, suns->light, suns->n);
        return GP_OK;
    }
    gp_status st = open_gl(log, s->glare.gl, suns);
    if (st)
        return st;
    if (p->method == GP_SUN_READBACK)
        return gp_sun_readback(log, suns->gl, &suns->occluders, p,
                               suns->light, suns->n, &suns->map);
    st = gp_sun_map_draw(log, suns->gl, &suns->occluders, p, suns->light,
                         suns->n, &suns->map);
    suns->early = read_early(p, suns->gl);
    return st || !suns->early ? st
                              : gp_sun_map_read(log, suns->gl, suns->map,
                                                suns->light, suns->n);
}

const char *gp_suns_way(const struct gp_settings *s,
                        const struct gp_suns *suns)
{
    switch (s->sun.params.method) {
    case GP_SUN_EXACT:
        return "exact";
    case GP_SUN_READBACK:
        return "readback";
    case GP_SUN_MASK:
        return suns->early ? "mask, drawn on the CPU" : "mask, drawn on GL";
    }
    return "";
}

// -- pictures -----------------------------------------------------------------

/* One light's map on the CPU into its place of the row of maps. */
static void paint_map(const struct gp_sun_params *p, const float *map, int at,
                      int w, float *out)
{
    for (int y = 0; y < p->map; y++) {
        for (int x = 0; x < p->map; x++) {
            const float *const t = map + 2 * (y * p->map + x);
            out[(size_t) y * (size_t) w + (size_t) (at * p->map + x)] =
                t[1] > 0.0f ? t[0] / t[1] : 0.0f;
        }
    }
}

/* Without GL: what the maps would be, or are known to be. */
static gp_status paint(const struct gp_log *log, const struct gp_settings *s,
                       const struct gp_suns *suns, bool intensity, int *w,
                       int *h, float **out)
{
    const struct gp_sun_params *const p = &s->sun.params;
    void *map = NULL, *v;
    gp_status st = GP_OK;
    *w = intensity ? suns->n : suns->n * p->map;
    *h = intensity ? 1 : p->map;
    GP_TRY(gp_alloc(log, "map", (size_t) p->map * (size_t) p->map,
                    2 * sizeof(float), &map));
    GP_TRY(gp_alloc(log, "picture", (size_t) *w * (size_t) *h, sizeof(float),
                    &v));
    *out = v;
    for (int i = 0; i < suns->n; i++) {
        if (intensity) {
            (*out)[i] = (float) suns->light[i].visibility;
            continue;
        }
        gp_sun_map_reference(&suns->occluders, p, &suns->light[i], map);
        paint_map(p, map, i, *w, *out);
    }
out:
    gp_free(map);
    return st;
}

gp_status gp_suns_picture(const struct gp_log *log,
                          const struct gp_settings *s,
                          const struct gp_suns *suns, bool intensity, int *w,
                          int *h, struct gp_planes *out)
{
    gp_status st;
    float *grey = NULL;
    if (s->sun.params.method == GP_SUN_MASK) {
        GP_TRY(gp_gl_use(log, suns->gl));
        GP_TRY(gp_sun_map_picture(log, suns->gl, suns->map, intensity, w, h,
                                  &grey));
    } else {
        GP_TRY(paint(log, s, suns, intensity, w, h, &grey));
    }
    const size_t n = (size_t) *w * (size_t) *h;
    GP_TRY(gp_planes_make(log, "picture", n, out));
    for (int c = 0; c < 3; c++)
        memcpy(out->c[c], grey, n * sizeof *grey);
out:
    gp_free(grey);
    return st;
}
