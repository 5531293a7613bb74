// SPDX-License-Identifier: Apache-2.0
/* Light groups of a frame: their sources, what each kernel spreads of them, and
 * the glare of each by itself. */
#include "api/plan.h"

#include "core/clock.h"
#include "core/luminance.h"
#include "core/memory.h"
#include "core/minmax.h"

#include <float.h>
#include <math.h>
#include <string.h>

// -- sources ------------------------------------------------------------------

/* The share of a group's light that SCATTER takes from the frame, over the share
 * min(gain, 1) that compose takes of what it is given. */
static float taken_of(const struct glarepp_frame *f,
                      const struct gp_api_group *g)
{
    const float gain = f->plan->compose.gain;
    return gain > 0.0f ? gp_minf(gain * g->how.gain, 1.0f) / gp_minf(gain, 1.0f)
                       : 0.0f;
}

/* Joins the light of groups of that kernel (-1: of any), each times its gain, or
 * what is taken of it. `like` has the geometry and counts of all. */
static gp_status join_groups(struct glarepp_frame *f, int kernel, bool taken,
                             const struct gp_sources *like,
                             struct gp_sources *out)
{
    struct gp_source *list = NULL;
    size_t n = 0;
    gp_status st;
    for (int i = 0; i < f->groups; i++)
        n += f->group[i].sources.n;
    GP_TRY(gp_alloc(&f->log, "light of the groups", n, sizeof *list, &list));
    n = 0;
    for (int g = 0; g < f->groups; g++) {
        const struct gp_sources *const s = &f->group[g].sources;
        const struct glarepp_group *const how = &f->group[g].how;
        const float gain = taken ? taken_of(f, &f->group[g]) : how->gain;
        if (kernel >= 0 && how->kernel != kernel)
            continue;
        for (int y = 0; y < s->h; y++) {
            for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++, n++) {
                list[n] = (struct gp_source) {.x = s->x[i], .y = y};
                for (int c = 0; c < 3; c++)
                    list[n].rgb[c] = gp_minf(gain * s->rgb[c][i], FLT_MAX);
            }
        }
    }
    st = gp_sources_join(&f->log, like, list, n, out);
out:
    gp_free(list);
    return st;
}

/* Splits the sources where groups have several kernels, or gains. */
static gp_status split(struct glarepp_frame *f, const struct gp_sources *like)
{
    bool gains = false, kernels = false;
    gp_status st = GP_OK;
    for (int i = 0; i < f->groups; i++) {
        gains = gains || f->group[i].how.gain != 1.0f;
        kernels = kernels || f->group[i].how.kernel > 0;
    }
    if (gains && f->plan->compose.mix == GLAREPP_SCATTER)
        GP_TRY(join_groups(f, -1, true, like, &f->taken));
    if (!kernels)
        return GP_OK;
    for (int i = 0; i < f->plan->kernels; i++)
        GP_TRY(join_groups(f, i, false, like, &f->run[i].sources));
out:
    return st;
}

gp_status gp_api_sense_groups(struct glarepp_frame *f)
{
    struct gp_sources *const src = &f->sources;
    struct gp_sources none = {0}, all = {0};
    struct glarepp_sense_params sense = f->plan->sense;
    gp_status st;
    sense.threshold = src->threshold; // the frame's, for all of them
    sense.unit = GLAREPP_LUMINANCE;
    memset(src->faint, 0, sizeof src->faint);
    for (int i = 0; i < f->groups; i++) {
        struct gp_sources *const own = &f->group[i].sources;
        gp_sources_free(own); // of a step that ran before
        GP_TRY(gp_sense(&f->log, &sense, false, &f->group[i].image, own));
        src->nonfinite += own->nonfinite;
        src->clamped += own->clamped;
        for (int c = 0; c < 3; c++) {
            src->faint[c] += own->faint[c];
            src->flux_clamped[c] += own->flux_clamped[c];
        }
    }
    // keep the frame's geometry and counts, replace its light
    GP_TRY(gp_sources_make(&f->log, src, 0, &none));
    gp_sources_finish(&none);
    GP_TRY(join_groups(f, -1, false, &none, &all));
    gp_sources_free(src);
    *src = all;
    st = split(f, &none);
out:
    gp_sources_free(&none);
    return st;
}

// -- layers -------------------------------------------------------------------

/* Returns the way the picture goes on for `own`, a part of its sources. */
static struct gp_surround edges_of(const struct glarepp_frame *f,
                                   const struct gp_sources *own)
{
    return (struct gp_surround) {
        .how = gp_api_edges(f),
        .picture = f->whole.row ? &f->whole : &f->sources,
        .own = own,
        .turn =
            gp_api_wide(f).kind == GP_LATLONG ? gp_rect_w(f->image.display) : 0,
    };
}

/* Parts, each of one kernel, on their way to one layer. */
struct sum {
    struct gp_glare_params p;
    int parts, drawn;
    double error;  // of those drawn, norm
    bool negative; // one may take light away
};

/* Draws part i: the first as the frame's layer, others are added to it. */
static gp_status draw_part(struct glarepp_frame *f, int i, struct sum *sum)
{
    const struct gp_kernel *const kernel = gp_api_kernel(f, i);
    struct glarepp_layer_facts *const facts = &f->facts.layer;
    struct glarepp_layer_facts stats = {0};
    struct gp_image apart = f->image; // (its other planes are borrowed)
    struct gp_image *const to = sum->drawn ? &apart : &f->image;
    double norm2[2] = {0}, total[3];
    apart.layer = (struct gp_planes) {0};
    sum->p.edges = edges_of(f, gp_api_bright(f, i));
    gp_status st = gp_glare_run(&f->log, &sum->p, &f->work->engines[i],
                                gp_api_light(f, i), kernel, to, &stats);
    if (!st && sum->drawn)
        st = gp_api_add_layer(&f->log, to, &f->image, norm2);
    else if (!st && sum->parts > 1)
        gp_planes_sum(&to->layer, gp_image_pixels(to), total, norm2);
    gp_planes_free(&apart.layer);
    if (st)
        return st;
    sum->error += gp_api_error_of(stats.bound, norm2[0]);
    sum->negative = sum->negative || kernel->negative;
    if (sum->drawn++ == 0) {
        *facts = stats;
    } else {
        facts->engine =
            facts->engine == stats.engine ? stats.engine : "several";
        facts->bound_pixel += stats.bound_pixel;
    }
    return GP_OK;
}

/* Bounds the errors of the sum of several parts, each addition's rounding among
 * them. */
static void bound_sum(struct glarepp_frame *f, const struct sum *sum)
{
    struct glarepp_layer_facts *const facts = &f->facts.layer;
    const float *const weight = f->image.luminance;
    const double rounding = 0x1p-22 * (sum->drawn - 1);
    double total[3], norm2;
    gp_planes_sum(&f->image.layer, gp_image_pixels(&f->image), total, &norm2);
    facts->bound =
        gp_api_bound_of(sum->error + rounding * sqrt(norm2), sqrt(norm2));
    // a part's is of the picture with that part alone: others make it no darker
    if (sum->negative ||
        gp_minf(weight[0], gp_minf(weight[1], weight[2])) < 0.0f)
        facts->bound_pixel *= INFINITY;
    else if (facts->bound_pixel > 0.0)
        facts->bound_pixel += rounding;
}

gp_status gp_api_layers(struct glarepp_frame *f)
{
    struct sum sum = {.p = f->plan->glare};
    gp_status st = GP_OK;
    for (int i = 0; i < f->plan->kernels; i++)
        sum.parts += gp_api_light(f, i)->n > 0;
    sum.p.taken = gp_api_taken(f);
    sum.p.last = f->p.last;
    sum.p.seen = f->p.noise;
    // n layers of norms |l| have sum of |l| <= sqrt(n) |sum of l|, none negative
    sum.p.tolerance /= (float) gp_max(sum.parts, 1);
    sum.p.tolerance_pixel /= (float) gp_max(sum.parts, 1);
    for (int i = 0; i < f->plan->kernels; i++) {
        if (gp_api_light(f, i)->n > 0)
            GP_TRY(draw_part(f, i, &sum));
    }
    if (sum.parts > 1)
        bound_sum(f, &sum);
    if (!sum.parts)
        f->facts.layer = (struct glarepp_layer_facts) {
            .engine = "none",
            .why = "no pixel is over the threshold",
        };
out:
    return st;
}

gp_status gp_api_exact(struct glarepp_frame *f, double **out)
{
    const size_t n = 3 * gp_image_pixels(&f->image);
    double *sum = NULL, *more = NULL, sources = 0.0;
    unsigned char *only = NULL;
    gp_status st = GP_OK;
    *out = NULL;
    f->sample = (struct gp_glare_sample) {0};
    for (int i = 0; i < f->plan->kernels; i++) {
        if (gp_api_kernel(f, i)->sky)
            sources += (double) gp_api_light(f, i)->n;
    }
    if (sources > 0.0) {
        GP_TRY(gp_alloc(&f->log, "exact layer", n / 3, 1, &only));
        f->sample = gp_glare_sample(&f->image, &f->image.layer, sources, only);
    }
    for (int i = 0; i < f->plan->kernels; i++) {
        const struct gp_surround edges = edges_of(f, gp_api_bright(f, i));
        double **const to = sum ? &more : &sum;
        if (!gp_api_light(f, i)->n)
            continue;
        if (!*to)
            GP_TRY(gp_alloc(&f->log, "exact layer", n, sizeof **to, to));
        GP_TRY(gp_glare_reference(&f->log, &edges, gp_api_light(f, i),
                                  gp_api_kernel(f, i), only, *to));
        for (size_t k = 0; more && k < n; k++)
            sum[k] += more[k];
    }
    *out = sum;
    sum = NULL;
out:
    gp_free(sum);
    gp_free(more);
    gp_free(only);
    return st;
}

// -- the glare of a group -----------------------------------------------------

/* Adds the flare of a group's bright pixels, at the frame's level. */
static gp_status add_flare(struct glarepp_frame *f, struct gp_api_group *g,
                           struct glarepp_flare_facts *facts)
{
    const double gain = f->facts.flare.gain;
    struct gp_planes before = {0};
    gp_status st = GP_OK;
    if (gain > 0.0 && gain != 1.0)
        st = gp_api_part_open(f, &g->image, &before);
    if (!st)
        st = gp_api_ghosts_add(f, &g->sources, &f->work->lights->group_ghosts,
                               &g->image, facts);
    if (before.c[0])
        gp_api_part_close(f, &g->image, gain, &before, NULL);
    return st;
}

/* Makes the layer of a group without its gain; there is none where it has no
 * light. */
static gp_status draw_group(struct glarepp_frame *f, struct gp_api_group *g)
{
    const int i = g->how.kernel;
    struct glarepp_layer_facts stats = {0};
    struct gp_glare_params glare = f->plan->glare;
    glare.gain = f->plan->compose.gain * g->how.gain;
    glare.edges = edges_of(f, &g->sources);
    return g->sources.n && f->run[i].kernel && g->how.gain > 0.0f
               ? gp_glare_run(
                     &f->log, &glare,
                     i ? &f->work->engines[i] : &f->work->group_engines,
                     &g->sources, gp_api_kernel(f, i), &g->image, &stats)
               : GP_OK;
}

/* Moves the layer of a group, times its gain, from a part of the frame to the
 * group's. */
static void take_part(struct glarepp_frame *f, struct gp_api_group *g,
                      struct gp_planes *from)
{
    const size_t n = gp_image_pixels(&f->image);
    for (int c = 0; c < 3 && g->image.layer.c[0]; c++) {
        for (size_t i = 0; i < n; i++) {
            const float own = g->how.gain * g->image.layer.c[c][i];
            g->part.c[c][i] += own;
            from->c[c][i] -= own;
        }
    }
    gp_planes_free(&g->image.layer);
}

gp_status gp_api_part_groups(struct glarepp_frame *f)
{
    const size_t n = gp_image_pixels(&f->image);
    gp_status st;
    GP_TRY(gp_api_part_find(f, GLAREPP_PART_VEIL));
    GP_TRY(gp_api_part_find(f, GLAREPP_PART_FLARE));
    for (int i = 0; i < f->groups; i++) {
        struct gp_api_group *const g = &f->group[i];
        struct glarepp_flare_facts facts = {0};
        gp_planes_free(&g->part);
        GP_TRY(gp_planes_make(&f->log, "parts", n, &g->part));
        gp_planes_clear(&g->part, 0, n);
        GP_TRY(gp_api_part_core(f, &g->sources, gp_api_kernel(f, g->how.kernel),
                                -g->how.gain));
        GP_TRY(draw_group(f, g));
        take_part(f, g, &f->part[0]);
        if (f->work->lights)
            GP_TRY(add_flare(f, g, &facts));
        take_part(f, g, &f->part[GLAREPP_PART_FLARE - GLAREPP_PART_VEIL]);
    }
out:
    return st;
}

gp_status gp_api_compose_group(struct glarepp_frame *f, struct gp_api_group *g,
                               const struct gp_compose_params *frame)
{
    struct glarepp_flare_facts flare = {0};
    struct gp_compose_params p = *frame;
    const double start = gp_now_ms(), cpu = gp_cpu_ms();
    gp_status st;
    p.gain *= g->how.gain;
    st = draw_group(f, g);
    if (!st && f->work->lights)
        st = add_flare(f, g, &flare);
    if (g->sources.n > 0) {
        f->facts.engines_ms += gp_now_ms() - start;
        f->facts.engines_cpu_ms += gp_cpu_ms() - cpu;
    }
    if (!st && f->plan->tints)
        gp_layer_tint(&f->plan->tint, false, &g->image);
    if (!st)
        st = gp_compose(&f->log, &p, &g->sources, &g->image);
    gp_planes_free(&g->image.layer);
    return st;
}
