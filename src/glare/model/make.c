// SPDX-License-Identifier: Apache-2.0
/* Kernels of recipes: shapes added up over a field. */
#include "core/luminance.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/model/model_priv.h"
#include "glare/far_field/far_field.h"
#include "glare/sky/sky.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

/* Keeps each channel's light where shapes have a tint. */
struct tint {
    bool known;
    double faded;    // share of it that is taken away
    double stays[3]; // light that stays in its pixel, by channel: what shapes take
                     // less of than of the luminance
};

/* Light of openings that is finer than a pixel, at offsets up to NEAR. */
enum { NEAR = 2, NEARS = 2 * NEAR + 1, OWN = NEARS * NEARS / 2 };
struct near {
    bool any;
    double light[3][NEARS * NEARS];
};

/* The recipes and the field of a kernel, for gp_kernel_whole(). */
struct gp_kernel_origin {
    struct gp_recipe recipe[GP_RECIPES]; // files and images are the caller's
    int n;
    struct gp_field field;
    struct tint tint; // as struct mixture's ...
    struct near near;
};

// -- the sum of shapes --------------------------------------------------------

struct mixture {
    struct gp_shape shape[GP_RECIPES];
    double share[GP_RECIPES];
    double stays;        // light that stays in its pixel: delta's
    struct near near;    // of openings whose rest goes by cosines
    struct tint tint;
    bool image;          // a shape is of an image, whose tint is its own
    int n;
    bool grey, even, negative;
    double over;                // as struct gp_kernel's
    struct gp_cosines *cosines; // of which samples are the nodes; NULL: pixels
    int reach;           // of the widest shape
    // shapes that go on smoothly over the whole field: how many; whether their
    // far parts are the whole mixture; both as struct gp_shape's
    int smooth_n;
    bool only_far, far_grey, far_even;
    double smooth, stretch;
    int sharp;           // offsets beyond which there are only far parts
};

static bool is_smooth(const struct gp_shape *s)
{
    return s->smooth < INFINITY && s->reach == INT_MAX;
}

static void close_mixture(struct mixture *m)
{
    for (int i = 0; i < m->n; i++)
        m->shape[i].free(m->shape[i].state);
    m->n = 0;
}

static void add_facts(struct mixture *m, const struct gp_shape *s)
{
    m->grey &= s->grey;
    m->even &= s->even;
    m->negative |= s->negative;
    if (s->negative)
        m->over = s->over > 0.0 ? fmax(m->over, s->over) : INFINITY;
    m->reach = gp_max(m->reach, s->reach);
    m->only_far &= is_smooth(s) && !s->far;
    if (!is_smooth(s)) {
        m->sharp = gp_max(m->sharp, s->reach);
        return;
    }
    m->smooth_n++;
    m->far_grey &= s->far ? s->far_grey : s->grey;
    m->far_even &= s->far ? s->far_even : s->even;
    m->smooth = fmax(m->smooth, s->smooth);
    if (s->far)
        m->sharp = gp_max(m->sharp, s->sharp);
}

static gp_status open_shape(const struct gp_log *log,
    const struct gp_recipe *r, const struct gp_field *field,
    struct gp_shape *out)
{
    const char *const file = gp_recipe_file(r);
    if (file && !r->image)
        return gp_fail(log, GP_ERR_USAGE, "%s: the image of a kernel was not "
                       "read; give an image file", file);
    if (gp_recipe_adapts(r))
        return gp_fail(log, GP_ERR_USAGE, "%s: adaptation=0 takes a frame's "
                       "luminance, and there is none here; give it in cd/m2",
                       r->model->name);
    return r->model->open(log, r, field, out);
}

/* An opening that diffracts. */
static bool is_opening(const struct gp_recipe *r)
{
    return r->model == &gp_model_aperture && gp_recipe_value(r, "share") > 0.0;
}

/* Opens shapes, but of models of the angle where `sky` is to have these, and openings
 * where it has cosines. */
static gp_status open_mixture(const struct gp_log *log,
                              const struct gp_recipe *r, int n,
                              const struct gp_field *field,
                              struct gp_sky_params *sky, struct mixture *m)
{
    double sum = 0.0;
    *m = (struct mixture) {
        .grey = true,
        .even = true,
        .only_far = true,
        .far_grey = true,
        .far_even = true,
        .over = 1.0,
        .stretch = fmax(field->aspect, 1.0 / field->aspect),
    };
    for (int i = 0; i < n; i++) {
        const double share = gp_recipe_value(&r[i], "share");
        struct gp_shape *const shape = &m->shape[m->n];
        gp_status st = GP_OK;
        sum += share;
        *shape = (struct gp_shape) {0};
        if (sky && sky->cosines && is_opening(&r[i]))
            continue;
        if (sky && r[i].model->angular && !gp_recipe_adapts(&r[i]) &&
            r[i].model->angular(&r[i], field, &sky->part[sky->n])) {
            sky->share[sky->n++] = share;
            if (r[i].model->rest)
                st = r[i].model->rest(log, &r[i], field, shape);
        } else {
            st = open_shape(log, &r[i], field, shape);
        }
        if (st) {
            close_mixture(m);
            return st;
        }
        if (!shape->row)
            continue;
        m->share[m->n] = share;
        m->image |= r[i].model == &gp_model_image;
        add_facts(m, shape);
        m->n++;
    }
    for (int i = 0; i < GP_RECIPES && sum > 1.0; i++) {
        m->share[i] /= sum;
        if (sky)
            sky->share[i] /= sum;
    }
    m->stays = fmax(0.0, 1.0 - sum);
    return GP_OK;
}

/* Adds up the shapes for the pixels (x, y) .. (x + n - 1, y), or their far parts:
 * sum[0] only where these are grey. Beyond m->sharp both sums have equal bits. */
static void mix_row(const struct mixture *m, bool far, int x, int y, int n,
                    double sum[3][GP_SHAPE_STRIP])
{
    double strip[3][GP_SHAPE_STRIP];
    double *const out[3] = {strip[0], strip[1], strip[2]};
    for (int c = 0; c < 3; c++)
        memset(sum[c], 0, (size_t) n * sizeof **sum);
    for (int i = 0; i < m->n; i++) {
        const struct gp_shape *const s = &m->shape[i];
        const bool part = far && s->far;
        const int from = gp_max(x, s->reach < INT_MAX ? -s->reach : x);
        const int to = s->reach < INT_MAX ? gp_min(x + n, s->reach + 1) : x + n;
        if (abs(y) > s->reach || from >= to || (far && !is_smooth(s)))
            continue;
        (part ? s->far : s->row)(s->state, from, y, to - from, out);
        if (!part && y == 0 && x <= 0 && x + n > 0) {
            for (int c = 0; c < (s->grey ? 1 : 3); c++)
                strip[c][-from] += s->own[c];
        }
        for (int c = 0; c < ((far ? m->far_grey : m->grey) ? 1 : 3); c++) {
            const double *const v =
                strip[(part ? s->far_grey : s->grey) ? 0 : c];
            for (int k = from; k < to; k++)
                sum[c][k - x] += m->share[i] * v[k - from];
        }
    }
    for (int c = 0; c < 3 && !far && y == 0 && x <= 0 && x + n > 0; c++)
        sum[c][-x] += m->stays;
}

// -- planes -------------------------------------------------------------------

/* Samples of offsets -rx .. rx, -ry .. ry, less the far field's shares. */
struct filling {
    const struct mixture *m;
    const struct gp_far_split *split; // step 0: no far field
    int rx, ry;
    struct gp_planes k;
};

/* Takes the far field's share of n samples from (x, y) on from them. */
static void take_far(const struct mixture *m, const struct gp_far_split *split,
                     int x, int y, int n, double sum[3][GP_SHAPE_STRIP])
{
    double share[GP_SHAPE_STRIP], far[3][GP_SHAPE_STRIP], most = 0.0;
    for (int k = 0; k < n; k++) {
        share[k] = gp_far_share(split, x + k, y);
        most = fmax(most, share[k]);
    }
    if (!(most > 0.0))
        return;
    if (!m->only_far)
        mix_row(m, true, x, y, n, far);
    for (int c = 0; c < (m->grey ? 1 : 3); c++) {
        const double *const v = m->only_far ? sum[c] : far[m->far_grey ? 0 : c];
        // the far field is no more than the whole but for rounding
        for (int k = 0; k < n; k++)
            sum[c][k] = fmax(sum[c][k] - share[k] * v[k], 0.0);
    }
}

/* Row y - ry, or the two of that distance from the centre where shapes are
 * even; then only the right half is evaluated. */
static void make_row(void *ctx, int i, GP_UNUSED int thread)
{
    const struct filling *const f = ctx;
    const struct mixture *const m = f->m;
    const int w = 2 * f->rx + 1;
    const int y = m->even ? i : i - f->ry;
    const size_t at = (size_t) (f->ry + y) * (size_t) w;
    double sum[3][GP_SHAPE_STRIP];
    for (int x = m->even ? 0 : -f->rx; x <= f->rx; x += GP_SHAPE_STRIP) {
        const int n = gp_min(f->rx + 1 - x, GP_SHAPE_STRIP);
        mix_row(m, false, x, y, n, sum);
        if (f->split->step)
            take_far(m, f->split, x, y, n, sum);
        for (int c = 0; c < (m->grey ? 1 : 3); c++) {
            float *const row = f->k.c[c] + at + f->rx;
            for (int k = 0; k < n; k++) {
                row[x + k] = (float) sum[c][k];
                if (m->even)
                    row[-x - k] = (float) sum[c][k];
            }
        }
    }
    for (int c = 1; c < 3 && m->grey; c++)
        memcpy(f->k.c[c] + at, f->k.c[0] + at, (size_t) w * sizeof(float));
    const size_t mirror = (size_t) (f->ry - y) * (size_t) w;
    for (int c = 0; c < 3 && m->even && y > 0; c++)
        memcpy(f->k.c[c] + mirror, f->k.c[c] + at, (size_t) w * sizeof(float));
}

/* Finds m->tint: what a shape takes less of than of other channels stays in its
 * pixel; light that is left out counts as white. No channel has more to give than
 * all of its pixel: where the tint needs that, it is faded until it does not.
 * Errors: GP_ERR_USAGE the far field has that tint. */
static gp_status find_tint(const struct gp_log *log, struct mixture *m,
    const struct gp_planes *k, size_t n, size_t centre,
    const struct gp_far_field *far, const float weight[3])
{
    double sum[3], squares, all = 0.0, middle = 0.0, least = 0.0;
    m->tint = (struct tint) {.known = true};
    if (m->grey || m->image)
        return GP_OK;
    gp_planes_sum(k, n, sum, &squares);
    for (int c = 0; c < 3; c++) {
        sum[c] += far ? far->sum[c] : 0.0;
        all += (double) weight[c] * sum[c];
        middle += (double) weight[c] * (double) k->c[c][centre];
    }
    for (int c = 0; c < 3; c++)
        least = fmin(least, (double) k->c[c][centre] + all - sum[c]);
    if (least < 0.0 && far && !far->grey) // what is left falls with the share
        return gp_fail(log, GP_ERR_USAGE, "kernel: a channel would spread more "
                       "than all of its light; multiply share= by %.2g or less",
                       0.99 * all / (all - least));
    if (least < 0.0) // of a grey kernel `middle` is left
        m->tint.faded = least / (least - middle);
    for (int c = 0; c < 3; c++)
        m->tint.stays[c] = (1.0 - m->tint.faded) * (all - sum[c]);
    return GP_OK;
}

/* Fades the planes of a kernel towards their luminance, and adds what stays. */
static void use_tint(const struct tint *t, const float weight[3], size_t n,
                     size_t centre, struct gp_planes *k)
{
    const float faded = (float) t->faded;
    for (size_t i = 0; i < n && faded > 0.0f; i++) {
        float y = 0.0f;
        for (int c = 0; c < 3; c++)
            y += weight[c] * k->c[c][i];
        for (int c = 0; c < 3; c++)
            k->c[c][i] += faded * (y - k->c[c][i]);
    }
    for (int c = 0; c < 3; c++)
        k->c[c][centre] =
            (float) fmax((double) k->c[c][centre] + t->stays[c], 0.0);
}

/* The far parts' sample at one offset. */
static void mix_pixel(const void *ctx, int x, int y, double out[3])
{
    const struct mixture *const m = ctx;
    double sum[3][GP_SHAPE_STRIP];
    mix_row(m, true, x, y, 1, sum);
    for (int c = 0; c < (m->far_grey ? 1 : 3); c++)
        out[c] = sum[c][0];
}

/* True where no shape has less light at a place than its far field takes. */
static bool is_within(const struct mixture *m, const struct gp_far_split *s)
{
    for (int i = 0; i < m->n; i++) {
        const struct gp_shape *const one = &m->shape[i];
        if (!is_smooth(one) || !one->far)
            continue;
        for (int r = (int) s->from; r <= s->to; r++) {
            // neither falls with the distance
            if (gp_far_share(s, r + 1, 0) > one->least(one->state, r))
                return false;
        }
    }
    return true;
}

/* Chooses the split of a mixture; step 0: no far field. */
static struct gp_far_split choose_split(const struct mixture *m, int w, int h)
{
    struct gp_far_split s = {0};
    if (!m->smooth_n || m->negative)
        return s;
    double smooth = m->smooth;
    do {
        s = gp_far_choose(smooth, m->stretch, m->sharp, w, h);
        smooth = s.from + 1.0;
    } while (s.step && !is_within(m, &s));
    return s;
}

static void add_near(const struct near *near, int rx, int ry,
                     struct gp_planes *k)
{
    const size_t w = 2 * (size_t) rx + 1;
    for (int i = 0; i < NEARS * NEARS; i++) {
        const int x = i % NEARS - NEAR, y = i / NEARS - NEAR;
        const size_t at = (size_t) (y + ry) * w + (size_t) (x + rx);
        for (int c = 0; c < 3 && abs(x) <= rx && abs(y) <= ry; c++)
            k->c[c][at] += (float) near->light[c][i];
    }
}

/* Makes K of D's samples, and fills what else of it is. */
static gp_status divide_nodes(const struct gp_log *log, int w, int h,
                              struct gp_planes *k, struct gp_cosines *out)
{
    const size_t n = (size_t) h * ((size_t) w + 1);
    gp_status st = gp_alloc(log, "kernel", n, sizeof *out->sums, &out->sums);
    double *to = out->sums;
    for (int y = 0; y < h && !st; y++) {
        double sum = *to++ = 0.0;
        for (int x = 0; x < w; x++) {
            for (int c = 0; c < 3; c++)
                sum +=
                    (double) out->weight[c] * (double) gp_row(k->c[c], w, y)[x];
            *to++ = sum;
        }
    }
    out->w = w;
    out->h = h;
    return st ? st
              : gp_nodes_divide(log, w, h, out->grid.nodes, k, &out->wrong);
}

/* Makes the core of a mixture for frames of w x h pixels, less what `split`
 * gives to the far field, if its step is not 0; `weight` is of luminance. */
static gp_status make_core(const struct gp_log *log, struct mixture *m,
    const struct gp_far_split *split, const struct gp_far_field *far,
    const float *weight, int w, int h, struct gp_kernel *out)
{
    const int least = m->near.any ? NEAR : 0;
    const int last = gp_max(
        split->step ? gp_max((int) ceil(split->to) - 1, m->sharp) : m->reach,
        least);
    struct filling f = {.m = m, .split = split, .rx = gp_min(w - 1, last),
                        .ry = gp_min(h - 1, last)};
    const int columns = 2 * f.rx + 1, rows = 2 * f.ry + 1;
    const size_t n = (size_t) columns * (size_t) rows, centre = n / 2;
    gp_status st;
    GP_TRY(gp_planes_make(log, "kernel", n, &f.k));
    gp_parallel_do(m->even ? f.ry + 1 : rows, make_row, &f);
    if (!m->tint.known)
        GP_TRY(find_tint(log, m, &f.k, n, centre, far, weight));
    use_tint(&m->tint, weight, n, centre, &f.k);
    if (m->near.any)
        add_near(&m->near, f.rx, f.ry, &f.k);
    if (m->cosines)
        GP_TRY(divide_nodes(log, columns, rows, &f.k, m->cosines));
    st = gp_kernel_of_planes(log, "kernel", columns, rows, &f.k, out);
    out->over = fmin(out->over, m->over);
out:
    gp_planes_free(&f.k);
    return st;
}

/* Joins a far field, which the kernel then owns, to its core; NULL: there is
 * none. Finds the light that is left out. */
static void join_far(struct gp_far_field *t, const struct gp_field *field,
                     struct gp_kernel *k)
{
    k->far = t;
    k->left_out = 1.0;
    for (int c = 0; c < 3; c++) {
        if (t) {
            k->sum[c] += t->sum[c];
            k->norm1[c] += t->norm1[c];
            k->norm2[c] += t->norm2[c];
        }
        k->left_out -= (double) field->luminance[c] * k->sum[c];
    }
}

struct gp_field gp_field_of(const struct gp_image *f, double fov)
{
    const double aspect = (double) f->pixel_aspect;
    struct gp_field field = {
        .w = gp_image_w(f), .h = gp_image_h(f),
        .degrees = fov / gp_max(gp_rect_h(f->display), 1),
        // 1 where the file says what cannot be true
        .aspect = aspect >= 1.0 / 16.0 && aspect <= 16.0 ? aspect : 1.0,
        .fps = 24.0,
    };
    memcpy(field.chromaticities, f->chromaticities,
           sizeof field.chromaticities);
    memcpy(field.luminance, f->luminance, sizeof field.luminance);
    return field;
}

/* Makes the kernel of a mixture, split into a core and a far field. */
static gp_status make_split(const struct gp_log *log,
                            const struct gp_field *field, struct mixture *m,
                            struct gp_kernel *out)
{
    struct gp_far_field *far = NULL;
    struct gp_far_split split = choose_split(m, field->w, field->h);
    gp_status st;
    // a coarser grid: measured rel_l2 1e-7 at the usual step, up to 5e-5 at four
    // times that (engines.t)
    split.step *= field->tolerance > 0.05    ? 4
                  : field->tolerance > 0.005 ? 2
                                             : 1;
    if (split.step)
        GP_TRY(gp_far_make(
            log, &split, field->w, field->h,
            &(struct gp_far_kernel) {mix_pixel, m, m->far_grey, m->far_even},
            &far));
    GP_TRY(make_core(log, m, &split, far, field->luminance, field->w, field->h,
                     out));
    join_far(far, field, out);
    far = NULL;
out:
    gp_far_free(far);
    return st;
}

/* Opens openings with their shares among all of a kernel, which have that sum. */
static gp_status open_openings(const struct gp_log *log,
                               const struct gp_recipe *r, int n, double sum,
                               const struct gp_field *field, struct mixture *m)
{
    const gp_status st = open_mixture(log, r, n, field, NULL, m);
    for (int i = 0; i < n && !st; i++)
        m->share[i] = gp_recipe_value(&r[i], "share") / fmax(sum, 1.0);
    m->stays = 0.0;
    m->tint.known = true;
    return st;
}

/* Finds `near`: of means over both pixels, as a plane in the middle has them, what k's
 * nodes lack. The rest of `own`, of all that is left, stays in its pixel. */
static void find_near(const struct mixture *pixels, const struct gp_kernel *k,
                      double nodes, const double own[3], struct near *near)
{
    *near = (struct near) {.any = true};
    for (int y = -NEAR; y <= NEAR; y++) {
        double sum[3][GP_SHAPE_STRIP];
        mix_row(pixels, false, -NEAR, y, NEARS, sum);
        for (int i = 0; i < NEARS; i++) {
            double of_nodes[3];
            gp_cosines_at(k, (i - NEAR) * nodes, y * nodes, of_nodes);
            for (int c = 0; c < 3; c++)
                near->light[c][(y + NEAR) * NEARS + i] = fmax(
                    sum[pixels->grey ? 0 : c][i] - nodes * nodes * of_nodes[c],
                    0.0);
        }
    }
    for (int c = 0; c < 3; c++) {
        double *const light = near->light[c], all = -light[OWN];
        for (int i = 0; i < NEARS * NEARS; i++)
            all += light[i];
        for (int i = 0; i < NEARS * NEARS; i++)
            light[i] *= all > own[c] ? own[c] / all : 1.0;
        light[OWN] = fmax(own[c] - all, 0.0);
    }
}

/* Makes the cosines of openings, r, whose kernel's shares have that sum, and finds what of
 * their light does not go by them. */
static gp_status make_cosines(const struct gp_log *log,
                              const struct gp_recipe *r, int n, double sum,
                              const struct gp_field *field,
                              const struct gp_cosine_grid *grid,
                              struct near *near, struct gp_cosines **out)
{
    struct gp_cosines *k = NULL;
    struct gp_field f = *field, middle = *field;
    struct mixture m = {0}, pixels = {0};
    gp_status st;
    double own[3] = {0}, all = 0.0, share = 0.0;
    // as much more as the frame's, for lights beside it
    f.w = gp_max(grid->size[0] * field->w / field->seen_w, 1);
    f.h = gp_max(grid->size[1] * field->h / field->seen_h, 1);
    f.degrees = grid->step[1] * (180.0 / M_PI);
    f.aspect = grid->step[0] / grid->step[1];
    f.nodes = grid->nodes;
    middle.w = middle.h = NEAR + 1;
    GP_TRY(open_openings(log, r, n, sum, &middle, &pixels));
    GP_TRY(open_openings(log, r, n, sum, &f, &m));
    for (int i = 0; i < m.n; i++) {
        share += m.share[i];
        for (int c = 0; c < 3; c++)
            own[c] += m.share[i] * m.shape[i].own[m.shape[i].grey ? 0 : c];
        memset(m.shape[i].own, 0, sizeof m.shape[i].own);
    }
    GP_TRY(gp_alloc_zero(log, "kernel", 1, sizeof *k, &k));
    k->grid = *grid;
    memcpy(k->weight, field->luminance, sizeof k->weight);
    m.cosines = k;
    GP_TRY(make_split(log, &f, &m, &k->nodes));
    // each channel keeps its light
    for (int c = 0; c < 3; c++)
        all += (double) field->luminance[c] * (own[c] + k->nodes.sum[c]);
    for (int c = 0; c < 3; c++)
        own[c] = fmax(all - k->nodes.sum[c], 0.0);
    find_near(&pixels, &k->nodes, grid->nodes, own, near);
    for (int c = 0; c < 3; c++) // and what no node has is outside
        k->light[c] = share - own[c];
    k->all = gp_luminance_of(k->weight, k->light);
    *out = k;
    k = NULL;
out:
    gp_cosines_free(&k);
    close_mixture(&m);
    close_mixture(&pixels);
    return st;
}

/* Makes what of recipes goes by cosines, where a camera shows the frame. */
static gp_status make_openings(const struct gp_log *log,
                               const struct gp_recipe *r, int n,
                               const struct gp_field *field, struct near *near,
                               struct gp_cosines **out)
{
    static const double LEAST_NM = 450.0; // shorter waves are dim
    struct gp_recipe opening[GP_RECIPES];
    struct gp_cosine_grid grid;
    double finest = 0.0, sum = 0.0; // of cycles a radian; of shares
    int openings = 0;
    for (int i = 0; i < n; i++) {
        const double nm = gp_recipe_key(&r[i], "wavelength", 0.0);
        sum += gp_recipe_value(&r[i], "share");
        if (!is_opening(&r[i]))
            continue;
        opening[openings++] = r[i];
        finest = fmax(finest, gp_recipe_pupil(&r[i], field) * 1e6 /
                                  (nm > 0.0 ? nm : LEAST_NM));
    }
    return openings && gp_cosine_grid_lay(&field->projection, field->seen_w,
                                          field->seen_h, finest, &grid)
               ? make_cosines(log, opening, openings, sum, field, &grid, near,
                              out)
               : GP_OK;
}

/* Opens a mixture, and what of it goes by true angles; *sky stays NULL where nothing
 * does. */
static gp_status open_parts(const struct gp_log *log, const struct gp_recipe *r,
                            int n, const struct gp_field *field,
                            struct mixture *m, struct gp_sky **sky)
{
    struct gp_sky_params p = {
        .projection = field->projection,
        .w = field->seen_w,
        .h = field->seen_h,
        .tolerance = field->tolerance,
    };
    memcpy(p.luminance, field->luminance, sizeof p.luminance);
    const bool any = p.projection.kind != GP_PLANE;
    struct near near = {0};
    gp_status st = make_openings(log, r, n, field, &near, &p.cosines);
    if (!st)
        st = open_mixture(log, r, n, field, any ? &p : NULL, m);
    if (st || (!p.n && !p.cosines)) {
        gp_cosines_free(&p.cosines);
        return st;
    }
    p.stays = m->stays;
    st = gp_sky_make(log, &p, sky);
    if (!st && *sky) {
        m->stays += gp_sky_give(*sky);
        m->near = near;
        return GP_OK;
    }
    close_mixture(m);
    return st ? st : open_mixture(log, r, n, field, NULL, m);
}

gp_status gp_model_kernel(const struct gp_log *log, const struct gp_recipe *r,
    int n, const struct gp_field *field, struct gp_kernel *out)
{
    struct mixture m;
    struct gp_kernel k = {0};
    struct gp_sky *sky = NULL;
    if (!isfinite(field->rotate) || !(field->degrees > 0.0) ||
        !(field->degrees <= 180.0))
        return gp_fail_at(log, GP_ERR_USAGE, "field.degrees",
                          "%s: no kernel has this angle (a pixel of %g degrees, "
                          "turned by %g)", r->model->name, field->degrees,
                          field->rotate);
    gp_status st = open_parts(log, r, n, field, &m, &sky);
    if (st)
        return st;
    GP_TRY(make_split(log, field, &m, &k));
    if (sky) // of a light in the middle
        k.left_out += gp_sky_left_out(sky, 0.5 * (field->seen_w - 1),
                                      0.5 * (field->seen_h - 1)) -
                      gp_sky_facts(sky)->light + gp_sky_facts(sky)->given;
    k.sky = sky;
    sky = NULL;
    GP_TRY(gp_alloc_zero(log, "kernel", 1, sizeof *k.origin, &k.origin));
    k.origin->n = n;
    k.origin->field = *field;
    k.origin->tint = m.tint;
    k.origin->near = m.near;
    memcpy(k.origin->recipe, r, (size_t) n * sizeof *r);
    *out = k;
    k = (struct gp_kernel) {0};
out:
    close_mixture(&m);
    gp_sky_free(&sky);
    gp_kernel_free(&k);
    return st;
}

gp_status gp_kernel_whole(const struct gp_log *log, const struct gp_kernel *k,
                          int w, int h, struct gp_kernel *out)
{
    static const struct gp_far_split whole = {0};
    const struct gp_kernel_origin *const o = k->origin;
    struct mixture m;
    struct gp_sky_params rest = {0}; // k's sky has these
    rest.cosines = k->sky ? gp_sky_facts(k->sky)->cosines : NULL;
    gp_status st = open_mixture(log, o->recipe, o->n, &o->field,
                                k->sky ? &rest : NULL, &m);
    if (st)
        return st;
    m.stays += k->sky ? gp_sky_facts(k->sky)->given : 0.0;
    m.tint = o->tint;
    m.near = o->near;
    st = make_core(log, &m, &whole, NULL, o->field.luminance, w, h, out);
    if (!st)
        join_far(NULL, &o->field, out);
    close_mixture(&m);
    return st;
}
