#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/bound/spectrum.h"

#include <math.h>
#include <string.h>

enum { BAND = 64 }; // rows a task takes

struct filling {
    const struct gp_sources *src;
    const struct gp_polygons *polygons;
    struct gp_residue *out;
    int width, height; // of the planes
    bool *lit;         // rows that are not 0
    double (*square)[3]; // of each band
};

/* Where a polygon's light stands on one axis: box + 1 pixels from `first`, the
 * ones between the ends all with weight 1 / box. */
struct footprint {
    int first, n;
    double head, body, tail; // weights
};

static struct footprint make_footprint(float at, int box)
{
    const double start = (double) at - (box - 1) / 2.0;
    const double part = start - floor(start), body = 1.0 / box;
    return (struct footprint) {
        .first = (int) floor(start), .n = box + 1,
        .head = (1.0 - part) * body, .body = body, .tail = part * body,
    };
}

static double weight(const struct footprint *f, int i)
{
    return i == 0 ? f->head : i < f->n - 1 ? f->body : f->tail;
}

static void take_polygon(const struct filling *f, const struct gp_polygon *p,
                         int y0, int y1)
{
    const int box = gp_blur_box[p->blur], pad = f->out->pad;
    // the usual case first: the band is far away
    if ((double) p->y + pad + box / 2 + 2 < y0 ||
        (double) p->y + pad - box / 2 - 2 > y1)
        return;
    const struct footprint v = make_footprint(p->y, box);
    const struct footprint u = make_footprint(p->x, box);
    for (int j = 0; j < v.n; j++) {
        const int y = v.first + pad + j;
        const double down = weight(&v, j);
        if (y < y0 || y >= y1 || down == 0.0)
            continue;
        for (int c = 0; c < 3; c++) {
            float *const to = f->out->d.c[c] +
                              (size_t) y * (size_t) f->width + pad + u.first;
            const double light = (double) p->rgb[c] * down;
            const float body = (float) (light * u.body);
            to[0] -= (float) (light * u.head);
            for (int i = 1; i < box; i++)
                to[i] -= body;
            to[box] -= (float) (light * u.tail);
        }
    }
}

static void set_sources(const struct filling *f, int y)
{
    const int pad = f->out->pad, sy = y - pad;
    if (sy < 0 || sy >= f->src->h)
        return;
    for (int c = 0; c < 3; c++) {
        float *const to =
            f->out->d.c[c] + (size_t) y * (size_t) f->width + pad;
        for (uint32_t i = f->src->row[sy]; i < f->src->row[sy + 1]; i++)
            to[f->src->x[i]] = f->src->rgb[c][i];
    }
}

/* Sum of squares in eight parts, so that it becomes vector code. */
GP_CLONES static double sum_squares(const float *v, int n)
{
    enum { PARTS = 8 };
    double part[PARTS] = {0}, sum = 0.0;
    int x = 0;
    for (; x + PARTS <= n; x += PARTS) {
        for (int i = 0; i < PARTS; i++)
            part[i] += (double) v[x + i] * (double) v[x + i];
    }
    for (; x < n; x++)
        sum += (double) v[x] * (double) v[x];
    for (int i = 0; i < PARTS; i++)
        sum += part[i];
    return sum;
}

static void survey_row(const struct filling *f, int y, double square[3])
{
    bool lit = false;
    for (int c = 0; c < 3; c++) {
        const double sum = sum_squares(
            f->out->d.c[c] + (size_t) y * (size_t) f->width, f->width);
        square[c] += sum;
        lit |= sum > 0.0;
    }
    f->lit[y] = lit;
}

static void fill_band(void *ctx, int i, int thread)
{
    const struct filling *const f = ctx;
    const int y0 = i * BAND;
    const int y1 = y0 + BAND < f->height ? y0 + BAND : f->height;
    (void) thread;
    for (int c = 0; c < 3; c++)
        memset(f->out->d.c[c] + (size_t) y0 * (size_t) f->width, 0,
               (size_t) (y1 - y0) * (size_t) f->width * sizeof(float));
    for (int y = y0; y < y1; y++)
        set_sources(f, y);
    for (size_t k = 0; k < f->polygons->n; k++)
        take_polygon(f, &f->polygons->at[k], y0, y1);
    for (int y = y0; y < y1; y++)
        survey_row(f, y, f->square[i]);
}

/* Sums and the list of rows, in their order. */
static void finish(struct filling *f, int bands, struct gp_residue *r)
{
    for (int y = 0; y < f->height; y++) {
        if (f->lit[y])
            r->row[r->rows++] = y;
    }
    for (int c = 0; c < 3; c++) {
        double sum = 0.0, light = 0.0;
        for (int i = 0; i < bands; i++)
            sum += f->square[i][c];
        r->norm2[c] = sqrt(sum);
        // a single source and its polygon cancel to the bit; where more meet,
        // each pixel takes a few roundings of at most the block's light
        for (size_t k = 0; k < f->polygons->n; k++) {
            const double v = (double) f->polygons->at[k].rgb[c];
            light += v * v;
        }
        r->rounding[c] = sum > 0.0 ? 0x1p-21 * sqrt(light) : 0.0;
    }
}

gp_status gp_residue_make(const struct gp_log *log,
                          const struct gp_sources *src,
                          const struct gp_polygons *polygons, int pad,
                          struct gp_residue *out)
{
    gp_status st;
    void *v;
    struct gp_residue r = {.w = src->w, .h = src->h, .pad = pad};
    struct filling f = {
        .src = src, .polygons = polygons, .out = &r,
        .width = src->w + 2 * pad, .height = src->h + 2 * pad,
    };
    const int bands = (f.height + BAND - 1) / BAND;
    GP_TRY(gp_planes_make(log, "bound",
                          (size_t) f.width * (size_t) f.height, &r.d));
    GP_TRY(gp_alloc(log, "bound", (size_t) f.height, sizeof *r.row, &v));
    r.row = v;
    GP_TRY(gp_alloc(log, "bound", (size_t) f.height, sizeof *f.lit, &v));
    f.lit = v;
    GP_TRY(gp_alloc_zero(log, "bound", (size_t) bands, sizeof *f.square, &v));
    f.square = v;
    gp_parallel_do(bands, fill_band, &f);
    finish(&f, bands, &r);
    *out = r;
    r = (struct gp_residue) {0};
out:
    gp_residue_free(&r);
    gp_free(f.lit);
    gp_free(f.square);
    return st;
}

void gp_residue_free(struct gp_residue *r)
{
    gp_planes_free(&r->d);
    gp_free(r->row);
    *r = (struct gp_residue) {0};
}
