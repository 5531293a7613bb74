#include "sun/lens_lights.h"

#include "core/colour.h"
#include "core/luminance.h"
#include "core/memory.h"
#include "core/minmax.h"

#include <math.h>
#include <stdlib.h>

/* Groups of sources: blocks of the frame, of which the brightest are lights. */
enum { BLOCK = 16, GROUPS = 100 };

struct group {
    struct gp_lens_light light; // place: sum of places by luminance
    double luminance;
    int index;
};

static int by_light(const void *a, const void *b)
{
    const struct group *const x = a, *const y = b;
    return x->luminance != y->luminance ? (x->luminance > y->luminance ? -1 : 1)
                                        : x->index - y->index;
}

/* Makes lights of the brightest blocks of sources. */
static gp_status group_sources(const struct gp_log *log,
    const struct gp_sources *s, struct gp_lens_light *out, int *n, double *rest,
    double dark[3])
{
    const int across = (s->w + BLOCK - 1) / BLOCK;
    const int down = (s->h + BLOCK - 1) / BLOCK;
    struct group *group;
    double all = 0.0, taken = 0.0;
    const gp_status st = gp_alloc_zero(log, "groups of sources",
        (size_t) across * (size_t) down, sizeof *group, &group);
    if (st)
        return st;
    for (int y = 0; y < s->h; y++) {
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
            const int at = y / BLOCK * across + s->x[i] / BLOCK;
            struct group *const g = &group[at];
            const double rgb[3] = {(double) s->rgb[0][i],
                                   (double) s->rgb[1][i],
                                   (double) s->rgb[2][i]};
            const double light = gp_luminance_of(s->luminance, rgb);
            for (int c = 0; c < 3; c++)
                g->light.flux[c] += rgb[c];
            g->light.x += light * (s->x0 + s->x[i] + 0.5);
            g->light.y += light * (s->y0 + y + 0.5);
            g->luminance += light;
            g->index = at;
            all += light;
        }
    }
    qsort(group, (size_t) across * (size_t) down, sizeof *group, by_light);
    *n = 0;
    for (int i = 0; i < across * down; i++) {
        if (!(group[i].luminance > 0.0))
            break;
        if (*n == GROUPS) {
            for (int c = 0; c < 3; c++)
                dark[c] += group[i].light.flux[c];
            continue;
        }
        out[*n] = group[i].light;
        out[*n].x /= group[i].luminance;
        out[*n].y /= group[i].luminance;
        taken += group[i].luminance;
        ++*n;
    }
    *rest = all > 0.0 ? fmax(1.0 - taken / all, 0.0) : 0.0;
    gp_free(group);
    return GP_OK;
}

gp_status gp_lens_lights(const struct gp_log *log,
    const struct gp_light *light, int lights, const struct gp_sources *src,
    struct gp_lens_light **out, int *n, double *rest, double dark[3])
{
    struct gp_lens_light *list;
    const gp_status st = gp_alloc_zero(
        log, "lights", (size_t) gp_max(lights, GROUPS), sizeof *list, &list);
    *n = 0;
    *out = st ? NULL : list;
    if (st)
        return st;
    for (int i = 0; i < lights; i++) {
        const struct gp_light *const l = &light[i];
        if (!gp_light_has_flux(l) || !(l->visibility > 0.0))
            continue;
        list[*n] = (struct gp_lens_light) {.x = l->x, .y = l->y};
        for (int c = 0; c < 3; c++)
            list[*n].flux[c] = l->visibility * (double) l->flux[c];
        ++*n;
    }
    return lights == 0 && src->n
               ? group_sources(log, src, list, n, rest, dark) : GP_OK;
}
