#include "app/light_group.h"

#include "core/memory.h"
#include "glare/extra.h"

#include <string.h>

gp_status gp_light_groups_read(const struct gp_log *log,
                               const struct gp_read_params *p,
                               const struct gp_frame *f,
                               const char *const *name, int n,
                               struct gp_light_groups *out)
{
    void *block;
    *out = (struct gp_light_groups) {0};
    gp_status st = gp_alloc_zero(log, "light groups", (size_t) n,
                                 sizeof *out->at, &block);
    out->at = block;
    while (!st && out->n < n) {
        st = gp_read_layer(log, p, f, name[out->n], &out->at[out->n].frame);
        out->n += !st;
    }
    return st;
}

void gp_light_groups_free(struct gp_light_groups *g)
{
    for (int i = 0; i < g->n; i++) {
        gp_sources_free(&g->at[i].sources);
        gp_frame_free(&g->at[i].frame);
    }
    gp_free(g->at);
    *g = (struct gp_light_groups) {0};
}

// -- sources --------------------------------------------------------------------

static size_t append(const struct gp_sources *s, struct gp_extra *to)
{
    size_t n = 0;
    for (int y = 0; y < s->h; y++) {
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
            to[n++] = (struct gp_extra) {
                s->x[i], y, {s->rgb[0][i], s->rgb[1][i], s->rgb[2][i]},
            };
        }
    }
    return n;
}

/* What the frame is, without its light. */
static void empty(struct gp_sources *s)
{
    s->n = 0;
    memset(s->row, 0, ((size_t) s->h + 1) * sizeof *s->row);
    memset(s->flux, 0, sizeof s->flux);
    memset(s->energy, 0, sizeof s->energy);
    memset(s->count, 0, sizeof s->count);
    s->brightest = 0.0f;
    s->box = (struct gp_rect) {0};
}

static gp_status sum_up(const struct gp_log *log,
                        const struct gp_light_groups *g,
                        struct gp_sources *src)
{
    struct gp_sources all = {0};
    size_t n = 0;
    void *block;
    for (int i = 0; i < g->n; i++)
        n += g->at[i].sources.n;
    gp_status st = gp_alloc(log, "light of the groups", n,
                            sizeof(struct gp_extra), &block);
    struct gp_extra *const list = block;
    if (st)
        return st;
    n = 0;
    for (int i = 0; i < g->n; i++)
        n += append(&g->at[i].sources, list + n);
    empty(src);
    st = gp_sources_with(log, src, list, n, &all);
    gp_free(list);
    if (st)
        return st;
    gp_sources_free(src);
    *src = all;
    return GP_OK;
}

gp_status gp_light_groups_sense(const struct gp_log *log,
                                const struct gp_sensor_params *p,
                                struct gp_light_groups *g,
                                struct gp_sources *src)
{
    for (int i = 0; i < g->n; i++) {
        struct gp_sources *const own = &g->at[i].sources;
        gp_status st = gp_sense(log, p, &g->at[i].frame, own);
        if (st)
            return st;
        src->nonfinite += own->nonfinite;
        src->clamped += own->clamped;
    }
    return sum_up(log, g, src);
}

// -- light ----------------------------------------------------------------------

gp_status gp_light_groups_light(const struct gp_log *log,
                                const struct gp_glare_params *glare,
                                const struct gp_compose_params *compose,
                                const struct gp_kernel *kernel,
                                struct gp_glare *engines,
                                struct gp_light_groups *g)
{
    for (int i = 0; i < g->n; i++) {
        struct gp_light_group *const group = &g->at[i];
        struct gp_glare_stats stats = {0};
        gp_status st = GP_OK;
        if (group->sources.n > 0)
            st = gp_glare_run(log, glare, engines, &group->sources, kernel,
                              &group->frame, &stats);
        if (!st)
            st = gp_compose(log, compose, &group->sources, &group->frame);
        if (st)
            return st;
        gp_planes_free(&group->frame.layer);
    }
    return GP_OK;
}
