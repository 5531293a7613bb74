// SPDX-License-Identifier: Apache-2.0
/* Weights of all levels at all places. */
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/far_field/far_field.h"
#include "glare/sky/sphere.h"

#include <math.h>
#include <string.h>

// -- places ------------------------------------------------------------------

struct making {
    struct gp_sky *s;
    double *scratch; // `room` of each thread
    size_t room;
};

/* Finds which weights of a row are not 0. */
static void find_span(const float *row, int n, short span[2])
{
    int from = 0, to = n;
    while (from < to && row[from] == 0.0f)
        from++;
    while (to > from && row[to - 1] == 0.0f)
        to--;
    span[0] = (short) from;
    span[1] = (short) to;
}

/* The place of which another one is the mirror image. */
static int mirror_of(const struct gp_sky *s, int i, bool turned[2])
{
    const int n[2] = {s->places.n[0], s->places.n[1]};
    int at[2] = {i % n[0], i / n[0]};
    for (int k = 0; k < 2; k++) {
        turned[k] = s->even[k] && at[k] < n[k] - 1 - at[k];
        at[k] = turned[k] ? n[k] - 1 - at[k] : at[k];
    }
    return at[1] * n[0] + at[0];
}

/* Takes a place's weights from its mirror image. */
static void turn_place(void *ctx, int i, GP_UNUSED int thread)
{
    const struct making *const m = ctx;
    struct gp_sky *const s = m->s;
    bool turned[2];
    const int from = mirror_of(s, i, turned);
    if (from == i)
        return;
    s->own[i] = s->own[from];
    for (int l = 0; l < s->levels - 1; l++) {
        struct gp_sky_level *const g = &s->level[l];
        const size_t w = 2 * (size_t) g->rx + 1, h = 2 * (size_t) g->ry + 1;
        const float *const of = g->weight + (size_t) from * g->size;
        float *const to = g->weight + (size_t) i * g->size;
        const short *const span = g->span + 2 * h * (size_t) from;
        short *const mine = g->span + 2 * h * (size_t) i;
        g->sum[i] = g->sum[from];
        for (size_t y = 0; y < h; y++) {
            const size_t row = turned[1] ? h - 1 - y : y;
            for (size_t x = 0; x < w; x++)
                to[y * g->pitch + x] =
                    of[row * g->pitch + (turned[0] ? w - 1 - x : x)];
            memcpy(mine + 2 * y, span + 2 * row, 2 * sizeof *span);
            if (turned[0] && span[2 * row] < span[2 * row + 1]) {
                mine[2 * y] = (short) ((int) w - span[2 * row + 1]);
                mine[2 * y + 1] = (short) ((int) w - span[2 * row]);
            }
        }
    }
}

static void make_place(void *ctx, int i, int thread)
{
    const struct making *const m = ctx;
    struct gp_sky *const s = m->s;
    bool turned[2];
    if (mirror_of(s, i, turned) != i)
        return;
    double *const v = m->scratch + (size_t) thread * m->room;
    double at[2];
    gp_sky_place_at(s, i, at);
    const double side = gp_sky_ellipse_at(&s->p.projection, at[0], at[1]).side;
    double weight[GP_SKY_LEVELS];
    if (s->single)
        gp_sky_single_fit(s, at, side, weight);
    for (int l = 0; l < s->levels - 1; l++) {
        struct gp_sky_level *const g = &s->level[l];
        const int rows = 2 * g->ry + 1;
        float *const out = g->weight + (size_t) i * g->size;
        short *const span = g->span + 2 * (size_t) i * (size_t) rows;
        if (s->single && l)
            out[0] = (float) weight[l];
        else if (s->single)
            s->own[i] = gp_sky_single_pixels(s, at, weight, side, v, out);
        else if (l)
            gp_sky_weigh_level(s, l, at, side, v, out);
        else
            s->own[i] = gp_sky_weigh_pixels(s, at, side, v, out);
        g->sum[i] = 0.0;
        for (size_t k = 0; k < g->size; k++)
            g->sum[i] += (double) out[k];
        for (int j = 0; j < rows; j++)
            find_span(out + (size_t) j * g->pitch, 2 * g->rx + 1, span + 2 * j);
    }
}

// -- the last level ------------------------------------------------------------

enum { MARGIN = 8 }; // nodes beyond the frame, as its term goes on

/* The weights of a node of the last level by those that light it. */
static void make_pairs(void *ctx, int i, int thread)
{
    const struct making *const m = ctx;
    struct gp_sky *const s = m->s;
    const int l = s->levels - 1;
    const struct gp_sky_level *const g = &s->level[l];
    const int w = g->w + 2 * MARGIN, h = g->h + 2 * MARGIN;
    double *const v = m->scratch + (size_t) thread * m->room;
    float *const out = s->pairs + (size_t) i * (size_t) g->w * (size_t) g->h;
    const double at[2] = {(i % g->w - 1) * g->step, (i / g->w - 1) * g->step};
    const double side = gp_sky_ellipse_at(&s->p.projection, at[0], at[1]).side;
    for (int k = 0; k < w * h; k++) {
        const double from[2] = {(k % w - MARGIN - 1) * g->step,
                                (k / w - MARGIN - 1) * g->step};
        v[k] = gp_sky_term(s, l, true, at, from, side);
    }
    gp_far_divide(v, w, h, 1);
    for (int k = 0; k < g->w * g->h; k++)
        out[k] = (float) v[(k / g->w + MARGIN) * w + k % g->w + MARGIN];
}

// -- all of it ----------------------------------------------------------------

/* Counts the levels: until the last one has few nodes; of those with one weight a node
 * fewer, as its error is not theirs. */
static void count_levels(struct gp_sky *s, bool single)
{
    const int few = single ? 250 : 1000, most = single ? 700 : 2000;
    const double far =
        single ? 0.2 : 0.1; // radians, too far apart for the term
    const double wide = fmax(s->p.projection.dx, s->p.projection.dy);
    for (int l = 1; l < GP_SKY_LEVELS; l++) {
        const int n =
            gp_far_nodes(s->p.w, 1 << l) * gp_far_nodes(s->p.h, 1 << l);
        s->levels = l + 1;
        if (n <= few || (n <= most && ldexp(wide, l + 1) > far))
            return;
    }
}

static void size_levels(struct gp_sky *s)
{
    double x = 0.0, y = 0.0; // how far a step of the steepest pixel reaches
    for (int i = 0; i < s->places.n[0] * s->places.n[1]; i++) {
        double at[2];
        gp_sky_place_at(s, i, at);
        const struct gp_sky_ellipse e =
            gp_sky_ellipse_at(&s->p.projection, at[0], at[1]);
        x = fmax(x, e.side * e.x);
        y = fmax(y, e.side * e.y);
    }
    for (int l = 0; l < s->levels; l++) {
        struct gp_sky_level *const g = &s->level[l];
        const int step = 1 << l;
        *g = (struct gp_sky_level) {
            .step = step,
            .w = l ? gp_far_nodes(s->p.w, step) : s->p.w,
            .h = l ? gp_far_nodes(s->p.h, step) : s->p.h,
            .rx = (int) ceil(2.0 * s->ratio * x) + 1,
            .ry = (int) ceil(2.0 * s->ratio * y) + 1,
        };
        if (s->single)
            g->rx = g->ry = l ? 0 : GP_SKY_SINGLE_NEAR;
        g->pitch = ((size_t) (2 * g->rx + 1) + GP_SKY_BLOCK - 1) /
                   GP_SKY_BLOCK * GP_SKY_BLOCK; // whole vectors
        g->size = g->pitch * (size_t) (2 * g->ry + 1);
    }
}

/* Tests whether levels can serve. */
static bool is_served(const struct gp_sky *s)
{
    static const double MOST = 8.0 * M_PI / 180.0, LONG = 16.0;
    const struct gp_projection *const p = &s->p.projection;
    // beyond these 230 degrees a fisheye's corners have no direction
    if (p->kind == GP_PLANE ||
        p->rim > (p->kind == GP_EQUISOLID ? 1.687 : 2.008))
        return false;
    for (int i = 0; i < 9; i++) {
        double at[2] = {(i % 3) * 0.5 * (s->p.w - 1),
                        (i / 3) * 0.5 * (s->p.h - 1)};
        gp_projection_pull(p, 0.0, at);
        const struct gp_sky_ellipse e = gp_sky_ellipse_at(p, at[0], at[1]);
        const bool round = p->kind == GP_LATLONG; // pixels of any length
        if (!(e.most <= MOST && (round || e.most <= LONG * e.least)))
            return false;
        for (int k = 0; k < s->p.n; k++) {
            if (2.0 * s->ratio * e.side * (180.0 / M_PI) < s->p.part[k].bends)
                return false;
        }
    }
    return true;
}

/* Chooses the blocks and groups of a level, and places them. Over d radians a line
 * misses weights by some d^2 / 3 of them, and rows that are the same over +-d, with the
 * sum set right, by d / 2: those within 4 pixels make most of the error, so pixels are
 * held closer. */
static gp_status place_level(const struct gp_log *log, const struct gp_sky *s,
                             int l, struct gp_sky_level *g)
{
    static const double ALIKE = 0.006;
    const double straight = l ? 0.06 : 0.03; // radians
    const struct gp_projection *const p = &s->p.projection;
    g->block = s->single && l ? 1 : GP_SKY_BLOCK;
    while (g->block > 1 && g->block * g->step * p->dx > straight)
        g->block = g->block == GP_SKY_BLOCK ? GP_SKY_BLOCK / 2 : 1;
    g->rows = 2 * GP_SKY_ROWS;
    g->tilts = g->block > 1 && g->rows * g->step * p->dy > ALIKE;
    if (g->tilts) {
        g->rows = GP_SKY_BAND;
        while (g->rows > GP_SKY_ROWS && g->rows * g->step * p->dy > straight)
            g->rows /= 2;
    }
    return gp_sky_columns(log, s, (g->w + g->block - 1) / g->block + 1,
                          l ? -g->step : 0.0, g->block * g->step, &g->column);
}

static gp_status alloc_levels(const struct gp_log *log, struct gp_sky *s,
                              struct making *m)
{
    gp_status st = GP_OK;
    const size_t places = (size_t) s->places.n[0] * (size_t) s->places.n[1];
    for (int l = 0; l < s->levels - 1; l++) {
        struct gp_sky_level *const g = &s->level[l];
        const size_t rows = 2 * (size_t) g->ry + 1;
        GP_TRY(gp_alloc_zero(log, "kernel", places * g->size, sizeof(float),
                             &g->weight));
        GP_TRY(gp_alloc(log, "kernel", 2 * places * rows, sizeof(short),
                        &g->span));
        GP_TRY(gp_alloc(log, "kernel", places, sizeof *g->sum, &g->sum));
        GP_TRY(place_level(log, s, l, g));
        if (s->single && l)
            GP_TRY(gp_alloc(log, "kernel",
                            (size_t) s->places.n[1] * (size_t) g->w,
                            sizeof(float), &g->line));
        const size_t room = (2 * (size_t) g->rx + 1) * rows;
        m->room = m->room > room ? m->room : room;
    }
    const struct gp_sky_level *const last = &s->level[s->levels - 1];
    const size_t nodes = (size_t) last->w * (size_t) last->h;
    const size_t wide =
        (size_t) (last->w + 2 * MARGIN) * (size_t) (last->h + 2 * MARGIN);
    m->room = m->room > wide ? m->room : wide;
    GP_TRY(gp_sky_columns(log, s, s->p.w, 0.0, 1.0, &s->column));
    GP_TRY(gp_alloc(log, "kernel", nodes * nodes, sizeof(float), &s->pairs));
    GP_TRY(gp_alloc(log, "kernel", places, sizeof *s->own, &s->own));
    st = gp_alloc(log, "kernel", m->room * (size_t) gp_threads(),
                  sizeof *m->scratch, &m->scratch);
out:
    return st;
}

static void free_levels(struct gp_sky *s)
{
    for (int l = 0; l < GP_SKY_LEVELS; l++) {
        gp_free(s->level[l].weight);
        gp_free(s->level[l].span);
        gp_free(s->level[l].sum);
        gp_free(s->level[l].column);
        gp_free(s->level[l].line);
        s->level[l] = (struct gp_sky_level) {0};
    }
    GP_FREE(s->single);
    GP_FREE(s->pairs);
    GP_FREE(s->own);
    GP_FREE(s->column);
}

/* Fills the weights of a single level's nodes between the places of a row. */
static void make_line(void *ctx, int i, GP_UNUSED int thread)
{
    const struct making *const m = ctx;
    const int rows = m->s->places.n[1], columns = m->s->places.n[0];
    struct gp_sky_level *const g = &m->s->level[1 + i / rows];
    const double *const sum = g->sum + (size_t) (i % rows) * (size_t) columns;
    float *const line = g->line + (size_t) (i % rows) * (size_t) g->w;
    for (int x = 0; x < g->w; x++) {
        const struct gp_sky_column *const b = &g->column[x];
        double v = 0.0;
        for (int k = 0; k < 4; k++)
            v += (double) b->at[k] * sum[b->place + k];
        line[x] = (float) v;
    }
}

/* Makes the levels whose first scale is so many steps, and bounds their error. */
static gp_status make_levels(const struct gp_log *log, double ratio,
                             bool single, struct gp_sky *s)
{
    struct making m = {.s = s};
    gp_status st;
    free_levels(s);
    s->facts.relative = 0.0;
    s->ratio = ratio;
    count_levels(s, single);
    gp_sky_lay_places(s);
    s->negligible = ratio > 6.0 ? 1e-5 : 4e-3;
    if (single)
        GP_TRY(gp_sky_single_make(log, s));
    size_levels(s);
    GP_TRY(alloc_levels(log, s, &m));
    const int places = s->places.n[0] * s->places.n[1];
    const struct gp_sky_level *const last = &s->level[s->levels - 1];
    gp_parallel_do(places, make_place, &m);
    gp_parallel_do(places, turn_place, &m);
    if (single)
        gp_parallel_do((s->levels - 2) * s->places.n[1], make_line, &m);
    gp_parallel_do(last->w * last->h, make_pairs, &m);
    st = gp_sky_error_find(log, s);
out:
    gp_free(m.scratch);
    return st;
}

/* Makes the sphere of a LATLONG frame, and bounds its error. */
static gp_status make_sphere(const struct gp_log *log, struct gp_sky *s)
{
    gp_status st;
    GP_TRY(gp_sky_outside_make(log, s));
    GP_TRY(gp_sky_sphere_make(log, s));
    if (s->sphere)
        gp_sky_error_of_sphere(s);
out:
    return st;
}

/* Fills facts.kept, of cosines: light in the frame of a source in a corner, where a pixel
 * is no smaller than the smallest, and another no larger than that in the middle. */
static void find_kept(struct gp_sky *s)
{
    const struct gp_projection *const p = &s->p.projection;
    double least = 1.0, most = 0.0;
    for (int i = 0; i < 4; i++) {
        const double x = (i & 1) * (s->p.w - 1), y = (i >> 1) * (s->p.h - 1);
        least = fmin(least, gp_projection_direction(p, x, y).z);
        most = fmax(most, gp_cosines_outside(s->p.cosines, x, y));
    }
    s->facts.kept =
        fmax(s->p.cosines->all - most, 0.0) * least * least * least * least;
}

/* gp_sky_make() of the channels [from, to), or of all. */
static gp_status make_channels(const struct gp_log *log,
                               const struct gp_sky_params *p, int from, int to,
                               struct gp_sky **out)
{
    // pixels that are summed one by one grow with its square, errors fall with its
    // fourth power
    static const double RATIOS[] = {3.7, 4.5, 5.2, 8.0};
    static const double MIDDLE = 1e-3; // pixels that weights do not notice
    // a tolerance that one weight a node may keep; the ratio by which the last level
    // goes on where those before it end
    static const double SINGLE = 5e-3, MEETS = 1.1;
    enum { TINT = 2, LAST = 3 }; // (halos bend on less than their angle)
    const double tolerance = p->tolerance > 0.0 ? p->tolerance : 1e-3;
    int i = tolerance < 1e-4 ? LAST : to - from < 3 ? TINT : 0;
    gp_status st;
    struct gp_sky *s = NULL;
    struct gp_cosines *taken = p->cosines;
    GP_TRY(gp_alloc_zero(log, "kernel", 1, sizeof *s, &s));
    s->p = *p;
    taken = NULL;
    s->from = from;
    s->to = to;
    s->ratio = RATIOS[i];
    s->facts.cosines = p->cosines;
    s->facts.splines = p->cosines ? p->cosines->wrong : 0.0;
    s->facts.light = p->cosines ? p->cosines->all : 0.0;
    s->facts.way = p->n ? "levels" : "fft";
    if (!p->n) {
        find_kept(s);
        *out = s;
        s = NULL;
        goto out;
    }
    if (!is_served(s))
        goto out;
    GP_TRY(gp_sky_light_make(log, p, from, &s->light));
    if (p->projection.kind == GP_LATLONG) {
        GP_TRY(make_sphere(log, s));
        if (s->sphere) {
            *out = s;
            s = NULL;
        }
        goto out;
    }
    count_levels(s, true);
    s->even[0] = fabs(p->projection.x0 - 0.5 * (p->w - 1)) < MIDDLE;
    s->even[1] = fabs(p->projection.y0 - 0.5 * (p->h - 1)) < MIDDLE;
    GP_TRY(gp_sky_outside_make(log, s));
    GP_TRY(gp_sky_outside_table(log, s));
    // (a halo is no sum of pyramids)
    if (tolerance >= SINGLE && s->levels > 2 && to - from == 3)
        GP_TRY(make_levels(log, MEETS, true, s));
    while (!s->level[0].weight ||
           (s->facts.relative > 0.99 * tolerance && i <= LAST))
        GP_TRY(make_levels(log, RATIOS[i++], false, s));
    *out = s;
    s = NULL;
out:
    gp_cosines_free(&taken);
    gp_sky_free(&s);
    return st;
}

gp_status gp_sky_make(const struct gp_log *log, const struct gp_sky_params *p,
                      struct gp_sky **out)
{
    struct gp_sky_params own = *p;
    struct gp_sky *s = NULL, **last = &s;
    bool tint = false;
    gp_status st = GP_OK;
    for (int i = 0; i < p->n; i++)
        tint |= p->part[i].tint;
    for (int c = 0; c < (tint ? 3 : 1); c++) {
        GP_TRY(make_channels(log, &own, tint ? c : 0, tint ? c + 1 : 3, last));
        if (!*last)
            goto out;
        struct gp_sky_facts *const e = &s->facts, *const more = &(*last)->facts;
        e->relative = fmax(e->relative, more->relative);
        e->outside = fmax(e->outside, more->outside);
        e->kept = fmin(e->kept, more->kept);
        own.cosines = NULL; // the first has them
        last = &(*last)->next;
    }
    *out = s;
    s = NULL;
out:
    gp_sky_free(&s);
    return st;
}

void gp_cosines_free(struct gp_cosines **c)
{
    if (*c) {
        gp_far_free(
            (*c)->nodes.far); // it has no more: of samples, not of a model
        gp_planes_free(&(*c)->nodes.k);
        gp_free((*c)->sums);
    }
    GP_FREE(*c);
}

void gp_sky_free(struct gp_sky **sky)
{
    for (struct gp_sky *s = *sky, *next; s; s = next) {
        next = s->next;
        free_levels(s);
        gp_sky_sphere_free(&s->sphere);
        gp_free(s->light.curve.value);
        gp_free(s->within.value);
        gp_free(s->outer_at[0]);
        gp_free(s->outside);
        gp_cosines_free(&s->p.cosines);
        gp_free(s);
    }
    *sky = NULL;
}

const struct gp_sky *gp_sky_channel(const struct gp_sky *s, int c)
{
    while (c >= s->to)
        s = s->next;
    return s;
}

/* What stays in pixels of so many places, or of a sphere's rows. */
static double *own_of(const struct gp_sky *s, int *n)
{
    *n = s->sphere ? s->sphere->h
         : s->own  ? s->places.n[0] * s->places.n[1]
                   : 0;
    return s->sphere ? s->sphere->own : s->own;
}

double gp_sky_give(struct gp_sky *s)
{
    static const double LEAST = 1e-20; // not 0, which would be no kernel
    double least = s->p.n ? INFINITY : 0.0;
    int n;
    for (const struct gp_sky *one = s; one; one = one->next) {
        const double *const own = own_of(one, &n);
        for (int i = 0; i < n; i++)
            least = fmin(least, own[i]);
    }
    // cubics between places may be lower
    const double given = (double) (float) fmax(0.9 * least, LEAST);
    for (; s; s = s->next) {
        double *const own = own_of(s, &n);
        for (int i = 0; i < n; i++)
            own[i] -= given;
        s->facts.given = given;
    }
    return given;
}

double gp_sky_left_out(const struct gp_sky *s, double x, double y)
{
    double sum = s->p.cosines ? gp_cosines_outside(s->p.cosines, x, y) : 0.0;
    for (int c = 0; c < (s->next ? 3 : 1); c++)
        sum += (s->next ? (double) s->p.luminance[c] : 1.0) *
               gp_sky_outside(gp_sky_channel(s, c), x, y);
    return sum;
}

const struct gp_sky_facts *gp_sky_facts(const struct gp_sky *sky)
{
    return &sky->facts;
}
