#include "scene/relight_priv.h"

#include "core/memory.h"

#include <math.h>
#include <stdlib.h>

/* Albedo of a pixel in units where no material is known. */
static const double GREY = 0.25;

/* Parts of a median by which half of a material's pixels may differ. */
static const float ALIKE = 0.1f;

enum { FEW = 8 }; // pixels of a material that are too few to know it

static int by_channel(const struct gp_shade *a, const struct gp_shade *b, int c)
{
    if (a->material != b->material)
        return a->material < b->material ? -1 : 1;
    return (a->albedo[c] > b->albedo[c]) - (a->albedo[c] < b->albedo[c]);
}

static int by_red(const void *a, const void *b)
{
    return by_channel(a, b, 0);
}

static int by_green(const void *a, const void *b)
{
    return by_channel(a, b, 1);
}

static int by_blue(const void *a, const void *b)
{
    return by_channel(a, b, 2);
}

/* Sets a channel of each material from its sorted pixels; adds to sums of the
 * pixels' albedo and of base colours. */
static void set_channel(const struct gp_scene *s, const struct gp_shade *shade,
                        size_t n, int c, struct gp_colours *out, double sum[2])
{
    for (size_t i = 0, end; i < n; i = end) {
        const int m = shade[i].material;
        for (end = i + 1; end < n && shade[end].material == m;)
            end++;
        const size_t k = end - i;
        if (m < 0 || k < FEW)
            continue;
        const float median = shade[i + k / 2].albedo[c];
        const float spread =
            shade[i + k * 3 / 4].albedo[c] - shade[i + k / 4].albedo[c];
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
    static int (*const order[])(const void *, const void *) = {by_red, by_green,
                                                               by_blue};
    struct gp_colours made = {.unit = 1.0};
    const size_t materials = (size_t) s->materials + 1;
    const double mean = mean_of(shade, n);
    double sum[2] = {0};
    gp_status st;
    *out = made;
    GP_TRY(gp_alloc(log, "materials", materials, sizeof *made.of, &made.of));
    GP_TRY(gp_alloc_zero(log, "materials", materials, 1, &made.many));
    for (int m = 0; m < s->materials; m++)
        made.of[m][0] = made.of[m][1] = made.of[m][2] = -1.0;
    for (int c = 0; c < 3; c++) {
        qsort(shade, n, sizeof *shade, order[c]);
        set_channel(s, shade, n, c, &made, sum);
    }
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
    gp_colours_free(&made);
    return st;
}

void gp_colours_free(struct gp_colours *c)
{
    gp_free(c->of);
    gp_free(c->many);
    *c = (struct gp_colours){0};
}
