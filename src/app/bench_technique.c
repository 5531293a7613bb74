#include "app/bench_table.h"

#include "core/memory.h"

#include <string.h>

#define PLAIN .cluster_fill = 0.9f, .method = GP_GROUP_CORE
#define FULL(...)                                                             \
    { .group = 4, .cluster = 8, .cluster_fill = 0.9f, .shrink = 1e-3f,        \
      __VA_ARGS__ }

/* From the exact ones over one step of Ando et al. after the other to all of
 * them together, by method and by primitive. */
const struct gp_bench_technique gp_bench_techniques[] = {
    {"direct", "direct", GP_SPLAT_EXACT},
    {"fft", "fft", GP_SPLAT_EXACT},
    {"splat", "splat", GP_SPLAT_EXACT},
    {"splat group 2", "splat", {.group = 2, PLAIN}},
    {"splat group 4", "splat", {.group = 4, PLAIN}},
    {"splat group 8", "splat", {.group = 8, PLAIN}},
    {"splat group 4, cluster 8", "splat", {.group = 4, .cluster = 8, PLAIN}},
    {"splat group 4, shrink 1e-3", "splat",
     {.group = 4, .shrink = 1e-3f, PLAIN}},
    {"splat 4/8/1e-3 centroid", "splat", FULL(.method = GP_GROUP_CENTROID)},
    {"splat 4/8/1e-3 moments", "splat", FULL(.method = GP_GROUP_MOMENTS)},
    {"splat 4/8/1e-3 core", "splat", FULL(.method = GP_GROUP_CORE)},
    {"splat 4/8/1e-3 tiles", "splat",
     FULL(.method = GP_GROUP_CORE, .primitive = GP_PRIMITIVE_TILE)},
    {"splat 4/8/1e-3 quads", "splat",
     FULL(.method = GP_GROUP_CORE, .primitive = GP_PRIMITIVE_QUAD)},
    {"splat 4/8/1e-3 points", "splat",
     FULL(.method = GP_GROUP_CORE, .primitive = GP_PRIMITIVE_POINT)},
    {"auto", "auto", GP_SPLAT_DEFAULTS},
    {0},
};
_Static_assert(sizeof gp_bench_techniques / sizeof *gp_bench_techniques ==
                   GP_BENCH_ROWS + 1, "a row for each technique");

void gp_bench_options(const struct gp_bench_technique *t, float tolerance,
                      char *line, size_t size)
{
    static const char *const methods[] = {
        [GP_GROUP_CENTROID] = "centroid", [GP_GROUP_MOMENTS] = "moments",
        [GP_GROUP_CORE] = "core",
    };
    static const char *const primitives[] = {
        [GP_PRIMITIVE_AUTO] = "auto", [GP_PRIMITIVE_QUAD] = "quad",
        [GP_PRIMITIVE_POINT] = "point", [GP_PRIMITIVE_TILE] = "tile",
    };
    const struct gp_splat_params *p = &t->splat;
    if (strcmp(t->engine, "auto") == 0)
        snprintf(line, size, "-e auto --tolerance %g", (double) tolerance);
    else if (strcmp(t->engine, "splat") != 0)
        snprintf(line, size, "-e %s", t->engine);
    else
        snprintf(line, size, "-e splat --group %d --group-method %s --cluster "
                 "%d --shrink %g --primitive %s", p->group,
                 methods[p->method], p->cluster, (double) p->shrink,
                 primitives[p->primitive]);
}

static bool dominates(const struct gp_bench_row *a,
                      const struct gp_bench_row *b)
{
    const double ea = a->error.rel_l2, eb = b->error.rel_l2;
    return a->measured && a->ms <= b->ms && ea <= eb &&
           (a->ms < b->ms || ea < eb);
}

void gp_bench_mark_pareto(struct gp_bench_frame *f)
{
    for (int i = 0; i < f->rows; i++) {
        f->row[i].pareto = f->row[i].measured;
        for (int k = 0; k < f->rows; k++) {
            if (dominates(&f->row[k], &f->row[i]))
                f->row[i].pareto = false;
        }
    }
}

void gp_bench_table_free(struct gp_bench_table *t)
{
    for (int i = 0; i < t->frames; i++) {
        GP_FREE(t->frame[i].input);
        GP_FREE(t->frame[i].kernel);
    }
    t->frames = 0;
}
