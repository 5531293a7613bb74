// SPDX-License-Identifier: Apache-2.0
#include "scene/relight_priv.h"

#include "core/memory.h"

#include <stdlib.h>

/* Albedo of a pixel in units where no material is known. */
static const double GREY = 0.25;

/* Parts of a median by which half of a material's pixels may differ. */
static const float ALIKE = 0.1f;

enum { FEW = 8 }; // pixels of a material that are too few to know it

static int by_material(const void *a, const void *b)
{
    const struct gp_shade *const x = a, *const y = b;
    return (x->material > y->material) - (x->material < y->material);
}

static int by_value(const void *a, const void *b)
{
    const float x = *(const float *) a, y = *(const float *) b;
    return (x > y) - (x < y);
}

/* Sets a channel of each material from its pixels, sorted by material; adds to
 * sums of the pixels' albedo and of base colours. `v` has room for all. */
static void set_channel(const struct gp_scene *s, const struct gp_shade *shade,
                        size_t n, int c, float *v, struct gp_colours *out,
                        double sum[2])
{
    for (size_t i = 0, end; i < n; i = end) {
        const int m = shade[i].material;
        for (end = i; end < n && shade[end].material == m; end++)
            v[end - i] = shade[end].albedo[c];
        const size_t k = end - i;
        if (m < 0 || k < FEW)
            continue;
        qsort(v, k, sizeof *v, by_value);
        const float median = v[k / 2], spread = v[k * 3 / 4] - v[k / 4];
        out->of[m][c] = (double) median;
        out->many[m] |= spread > ALIKE * median;
        sum[0] += (double) k * (double) median;
        sum[1] += (double) k * (double) s->material[m].base[c];
    }
}

/* Returns the mean albedo of pixels that have any; 0: none has. */
static double mean_of(const struct gp_shade *shade, size_t n)
{
    double sum = 0.0;
    size_t any = 0;
    for (size_t i = 0; i < n; i++) {
        const float *const a = shade[i].albedo;
        const double more = ((double) a[0] + (double) a[1] + (double) a[2]) / 3;
        sum += more;
        any += more > 0.0;
    }
    return any > 0 ? sum / (double) any : 0.0;
}

gp_status gp_colours_make(const struct gp_log *log, const struct gp_scene *s,
                          struct gp_shade *shade, size_t n,
                          struct gp_colours *out)
{
    struct gp_colours made = {.unit = 1.0};
    const size_t materials = (size_t) s->materials + 1;
    const double mean = mean_of(shade, n);
    double sum[2] = {0};
    float *v = NULL;
    gp_status st;
    *out = made;
    GP_TRY(gp_alloc(log, "shades", n, sizeof *v, &v));
    GP_TRY(gp_alloc(log, "materials", materials, sizeof *made.of, &made.of));
    GP_TRY(gp_alloc_zero(log, "materials", materials, 1, &made.many));
    for (int m = 0; m < s->materials; m++)
        made.of[m][0] = made.of[m][1] = made.of[m][2] = -1.0;
    qsort(shade, n, sizeof *shade, by_material);
    for (int c = 0; c < 3; c++)
        set_channel(s, shade, n, c, v, &made, sum);
    if (sum[0] > 0.0 && sum[1] > 0.0)
        made.unit = sum[0] / sum[1];
    else if (mean > 0.0)
        made.unit = mean / GREY;
    for (int m = 0; m < s->materials; m++) {
        for (int c = 0; c < 3; c++) {
            if (made.of[m][c] < 0.0)
                made.of[m][c] = made.unit * (double) s->material[m].base[c];
        }
    }
    *out = made;
    made = (struct gp_colours){0};
out:
    gp_free(v);
    gp_colours_free(&made);
    return st;
}

void gp_colours_free(struct gp_colours *c)
{
    gp_free(c->of);
    gp_free(c->many);
    *c = (struct gp_colours){0};
}
