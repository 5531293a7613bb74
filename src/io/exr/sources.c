/* Lists the channels of an EXR part that is written, and their samples. */
#include "io/exr/exr_priv.h"

#include "core/cpu.h"
#include "core/luminance.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "io/channels.h"
#include "core/half.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int by_name(const void *a, const void *b)
{
    const struct gp_exr_source *p = a, *q = b;
    return strcmp(p->name, q->name);
}

/* Makes room for `most` channels, and the colours of `frames` frames. */
static gp_status make_room(const struct gp_log *log, int most, int frames,
                           struct gp_exr_sources *out)
{
    *out = (struct gp_exr_sources) {0};
    gp_status st = gp_alloc_zero(log, "colours", (size_t) frames,
                                 sizeof *out->fitted, &out->fitted);
    return st ? st : gp_alloc(log, "channels", (size_t) most,
                              sizeof *out->source, &out->source);
}

void gp_exr_sources_free(struct gp_exr_sources *s)
{
    for (int i = 0; i < s->new_names; i++)
        free(s->new_name[i]);
    gp_free(s->new_name);
    for (int i = 0; i < s->fits; i++)
        gp_planes_free(&s->fitted[i]);
    gp_free(s->fitted);
    gp_free(s->source);
    gp_free(s->alpha);
    *s = (struct gp_exr_sources) {0};
}

/* -- light that a half cannot hold ---------------------------------------- */

struct fitting {
    const struct gp_planes *from;
    struct gp_planes to;
    size_t pixels;
    float limit, most; // largest value, and the largest that rounds to it
    bool dwa;          // has no Inf, and no less than -limit
    bool beyond[GP_FRAME_BANDS];
    struct gp_exr_fit band[GP_FRAME_BANDS];
};

GP_CLONES static int any_beyond(const float *v, size_t n, float most,
                                float largest)
{
    int any = 0;
    for (size_t i = 0; i < n; i++)
        any |= (fabsf(v[i]) > most) & (fabsf(v[i]) <= largest);
    return any;
}

static void find_beyond(void *ctx, int band, int thread)
{
    struct fitting *const f = ctx;
    const size_t from = gp_band_start(f->pixels, band);
    const size_t n = gp_band_start(f->pixels, band + 1) - from;
    (void) thread;
    for (int c = 0; c < 3; c++)
        f->beyond[band] |= any_beyond(f->from->c[c] + from, n, f->most,
                                      f->dwa ? INFINITY : FLT_MAX);
}

static void fit_band(void *ctx, int band, int thread)
{
    struct fitting *const f = ctx;
    struct gp_exr_fit *const sum = &f->band[band];
    const size_t end = gp_band_start(f->pixels, band + 1);
    (void) thread;
    for (size_t i = gp_band_start(f->pixels, band); i < end; i++) {
        float largest = 0.0f;
        bool over = false;
        for (int c = 0; c < 3; c++) {
            const float v = f->from->c[c][i];
            const bool finite = v <= FLT_MAX;
            largest = finite && v > largest ? v : largest;
            sum->values += finite && v > f->most;
            sum->light[c] += finite && v > 0.0f ? (double) v : 0.0;
            over |= finite && v > f->most;
        }
        sum->pixels += over;
        for (int c = 0; c < 3; c++) {
            const float v = f->from->c[c][i];
            const bool scaled = over && fabsf(v) <= FLT_MAX;
            float to = scaled ? fminf(v * (f->limit / largest), f->limit) : v;
            sum->lost[c] += scaled && v > 0.0f ? (double) v - (double) to : 0.0;
            if (f->dwa && fabsf(to) > f->limit) {
                to = copysignf(f->limit, to);
                sum->values++;
            }
            f->to.c[c][i] = to;
        }
    }
}

/* Finds the type of a frame's colours, and replaces *planes by a copy whose
 * pixels fit into it. Errors: GP_ERR_BUG out of memory. */
static gp_status fit_colour(const struct gp_log *log,
    const struct gp_write_params *p, const struct gp_frame *f,
    const struct gp_planes **planes, enum gp_pixel_type *type,
    struct gp_exr_sources *out)
{
    const bool dwa = p->compression >= GP_COMPRESSION_DWAA;
    struct fitting *w;
    bool beyond = false;
    *type = p->type == GP_OUT_AUTO   ? f->colour_type
            : p->type == GP_OUT_HALF ? GP_HALF : GP_FLOAT;
    if (*type != GP_HALF && !dwa)
        return GP_OK;
    gp_status st = gp_alloc_zero(log, "colours", 1, sizeof *w, &w);
    if (st)
        return st;
    w->from = *planes;
    w->pixels = gp_frame_pixels(f);
    w->dwa = dwa;
    w->limit = dwa ? GP_EXR_DWA_MAX : 65504.0f;
    w->most = dwa ? GP_EXR_DWA_MAX : nextafterf(65520.0f, 0.0f);
    gp_parallel_do(GP_FRAME_BANDS, find_beyond, w);
    for (int i = 0; i < GP_FRAME_BANDS; i++)
        beyond |= w->beyond[i];
    if (beyond && !dwa && p->type == GP_OUT_AUTO)
        *type = GP_FLOAT;
    else if (beyond)
        st = gp_planes_make(log, "colours", w->pixels, &w->to);
    if (!st && w->to.c[0]) {
        gp_parallel_do(GP_FRAME_BANDS, fit_band, w);
        for (int i = 0; i < GP_FRAME_BANDS; i++) {
            out->fit.values += w->band[i].values;
            out->fit.pixels += w->band[i].pixels;
            for (int c = 0; c < 3; c++) {
                out->fit.light[c] += w->band[i].light[c];
                out->fit.lost[c] += w->band[i].lost[c];
            }
        }
        *planes = &out->fitted[out->fits];
        out->fitted[out->fits++] = w->to;
    }
    gp_free(w);
    return st;
}

/* -- pictures ------------------------------------------------------------- */

static void add_plane(struct gp_exr_sources *s, enum gp_pixel_type type,
    const char *name, const struct gp_frame *f, const float *plane, bool linear)
{
    s->source[s->sources++] = (struct gp_exr_source) {
        .name = name, .xs = 1, .ys = 1, .linear = linear,
        .columns = gp_frame_w(f), .plane = plane, .type = type,
    };
}

gp_status gp_exr_sources_picture(const struct gp_log *log,
    const struct gp_write_params *p, const struct gp_frame *f,
    const struct gp_planes *planes, struct gp_exr_sources *out)
{
    static const char *const name[3] = {"B", "G", "R"}; // sorted, after A
    const int alpha = p->alpha != GP_ALPHA_BLACK ? gp_find_alpha(f) : -1;
    enum gp_pixel_type type, of_alpha;
    gp_status st = make_room(log, 4, 1, out);
    if (!st)
        st = fit_colour(log, p, f, &planes, &type, out);
    if (!st && alpha >= 0)
        st = gp_alloc(log, "alpha", gp_frame_pixels(f), sizeof(float),
                      &out->alpha);
    if (st)
        return st;
    if (alpha >= 0) {
        gp_channel_floats(f, alpha, out->alpha);
        of_alpha = p->type == GP_OUT_HALF    ? GP_HALF
                   : p->type == GP_OUT_FLOAT ? GP_FLOAT
                   : f->channel[alpha].type == GP_HALF ? GP_HALF : GP_FLOAT;
        add_plane(out, of_alpha, "A", f, out->alpha, true);
    }
    for (int c = 0; c < 3; c++)
        add_plane(out, type, name[c], f, planes->c[2 - c], false);
    return st;
}

/* -- --hdr ---------------------------------------------------------------- */

/* The frames of one part. */
struct group {
    const struct gp_log *log;
    const struct gp_write_params *p;
    const struct gp_hdr_colour *set;
    int n;
    const struct gp_frame *complete; // the one that has all channels of it
};

/* Adds the channels that are the colour of no frame. */
static gp_status add_carried(const struct group *g, struct gp_exr_sources *out)
{
    // the names of all colours: a file may have very many other channels, and
    // each is looked up once
    const char **colour;
    int colours = 0;
    gp_status st = gp_alloc(g->log, "colours", 3 * (size_t) g->n,
                            sizeof *colour, &colour);
    if (st)
        return st;
    for (int i = 0; i < g->n; i++) {
        const struct gp_frame *f = g->set[i].f;
        for (int k = 0, had = 0; k < f->channels && had < 3; k++) {
            if (f->channel[k].colour < 0)
                continue;
            colour[colours++] = f->channel[k].name;
            had++;
        }
    }
    for (int i = 0; i < g->complete->channels; i++) {
        const struct gp_channel *c = &g->complete->channel[i];
        int owners = 0;
        for (int k = 0; k < colours; k++)
            owners += strcmp(colour[k], c->name) == 0;
        if (owners > 1)
            GP_TRY(gp_fail(g->log, GP_ERR_USAGE,
                   "%s: channel %s is the colour of %d layers; name "
                   "each layer once", g->complete->path, c->name, owners));
        if (owners == 1)
            continue;
        if (!c->data)
            GP_TRY(gp_fail(g->log, GP_ERR_BUG, "%s: channel %s has no samples",
                   g->complete->path, c->name));
        out->source[out->sources++] = (struct gp_exr_source) {
            .name = c->name, .type = c->type, .xs = c->xs, .ys = c->ys,
            .linear = c->linear, .columns = c->w, .data = c->data,
        };
    }
out:
    gp_free(colour);
    return st;
}

/* True when a channel of that name will be there that f does not replace. */
static bool is_taken(const struct group *g, const struct gp_frame *f,
                     const char *name)
{
    const struct gp_channel *own = gp_frame_channel(f, name);
    return gp_frame_channel(g->complete, name) && !(own && own->colour >= 0);
}

/* The colour of one frame. */
static gp_status add_frame(const struct group *g,
    const struct gp_hdr_colour *from, struct gp_exr_sources *out)
{
    const struct gp_frame *f = from->f;
    const struct gp_planes *planes = from->planes;
    enum gp_pixel_type type;
    gp_status st = fit_colour(g->log, g->p, f, &planes, &type, out);
    if (st)
        return st;
    float *const *const plane = planes->c;
    const size_t n = gp_frame_pixels(f), bytes = n * sizeof(float);
    const struct gp_channel *like = NULL; // a colour channel of the input
    bool there[3] = {false, false, false};
    // grey stays grey where the planes are the same, bit by bit
    const bool own_names = f->model == GP_COLOUR_RGB ||
                           (f->model == GP_COLOUR_GREY &&
                            memcmp(plane[0], plane[1], bytes) == 0 &&
                            memcmp(plane[0], plane[2], bytes) == 0);
    for (int k = 0; k < f->channels; k++) {
        const struct gp_channel *c = &f->channel[k];
        if (c->colour < 0)
            continue;
        like = c;
        if (!own_names)
            continue;
        add_plane(out, type, c->name, f, plane[c->colour], c->linear);
        there[c->colour] = true;
    }
    if (!like)
        return gp_fail(g->log, GP_ERR_BUG, "%s: no colour channel", f->path);

    // colours under names that the part does not have. Names beside a grey
    // channel that is called after what it shows, and has no layer, may need
    // one: its own name. Y is luminance and no layer's name.
    static const char *const letter[3] = {"R", "G", "B"};
    bool layered = false;
    for (int c = 0; c < 3; c++)
        layered |= is_taken(g, f, letter[c]);
    layered = layered && f->model == GP_COLOUR_GREY &&
              gp_layer_length(like->name) == 0 && strcmp(like->name, "Y") != 0;
    for (int c = 0; c < 3; c++) {
        bool wanted = !own_names;
        for (size_t i = 0; f->model == GP_COLOUR_RGB && !wanted && i < n; i++)
            wanted = plane[c][i] != 0.0f;
        if (there[c] || !wanted)
            continue;
        char layer[GP_CHANNEL_NAME + 4];
        snprintf(layer, sizeof layer, "%s.%s", like->name, letter[c]);
        char *const name = layered ? gp_strdup(layer)
                                   : gp_colour_name(like->name, c);
        if (!name)
            return gp_no_memory_bare(g->log, "channels");
        out->new_name[out->new_names++] = name;
        if (is_taken(g, f, name))
            return gp_fail(g->log, GP_ERR_DATA,
                           "%s: the coloured glare needs a new channel %s, and "
                           "the file has another one of that name; rename "
                           "that", f->path, name);
        add_plane(out, type, name, f, plane[c], like->linear);
    }
    return GP_OK;
}

gp_status gp_exr_sources_hdr(const struct gp_log *log,
    const struct gp_write_params *p, const struct gp_hdr_colour *set, int n,
    struct gp_exr_sources *out)
{
    gp_status st;
    struct group g = {log, p, set, n, set[0].f};
    for (int i = 1; i < n; i++) {
        if (set[i].f->channels > g.complete->channels)
            g.complete = set[i].f;
    }
    GP_TRY(make_room(log, g.complete->channels + 3 * n, n, out));
    GP_TRY(gp_alloc_zero(log, "channels", 3 * (size_t) n,
                         sizeof *out->new_name, &out->new_name));
    GP_TRY(add_carried(&g, out));
    for (int i = 0; i < n; i++)
        GP_TRY(add_frame(&g, &set[i], out));
    qsort(out->source, (size_t) out->sources, sizeof *out->source, by_name);
    // names from other formats may not fit EXR
    for (int i = 0; i < out->sources; i++) {
        const char *name = out->source[i].name;
        if (name[0] == '\0' || strlen(name) > 255 ||
            (i > 0 && strcmp(out->source[i - 1].name, name) == 0))
            GP_TRY(gp_fail(log, GP_ERR_DATA,
                           "%s: EXR cannot hold its channels (name \"%.40s\" "
                           "is empty, too long, or used twice); rename them",
                           set[0].f->path, name));
    }
out:
    if (st)
        gp_exr_sources_free(out);
    return st;
}

/* -- --output-space -------------------------------------------------------- */

gp_status gp_convert_layers(const struct gp_log *log, gp_convert *convert,
    void *user, struct gp_frame *f, struct gp_write_stats *stats)
{
    const struct gp_input *const in = gp_input_of(f);
    const size_t n = gp_frame_pixels(f);
    struct gp_planes from = {0}, to = {0};
    struct gp_crypto crypto;
    char left[GP_CHANNEL_LIST] = "", converted[GP_CHANNEL_LIST] = "";
    bool lists[2] = {true, true};
    const char **name = NULL; // of carried channels, "" of others
    gp_status st;
    GP_TRY(gp_alloc(log, "channels", (size_t) f->channels, sizeof *name,
                    &name));
    for (int i = 0; i < f->channels; i++)
        name[i] = f->channel[i].data ? f->channel[i].name : "";
    gp_exr_crypto(in, &crypto);
    for (int i = 0; i < f->channels; i++) {
        const struct gp_channel *const red = &f->channel[i];
        const size_t len = gp_layer_length(red->name);
        struct gp_colour_choice colour;
        char layer[GP_CHANNEL_NAME + 1];
        snprintf(layer, sizeof layer, "%.*s", len ? (int) len - 1 : 0,
                 red->name);
        // a layer is converted when its first channel comes: R, or RY
        if (!name[i][0] || red->type == GP_UINT ||
            (len && !gp_is_light(red->name, len - 1)) ||
            gp_exr_crypto_channel(&crypto, in, f->part, red->name) !=
                GP_CRYPTO_NONE ||
            !gp_find_layer_colour(name, f->channels, layer, false, &colour) ||
            colour.index[0] != i || colour.model == GP_COLOUR_GREY)
            continue;
        const int *const index = colour.index;
        bool whole = colour.model == GP_COLOUR_RGB, all = true;
        for (int c = 0; c < 3 && all && whole; c++) {
            all = index[c] >= 0;
            const struct gp_channel *const own = &f->channel[all ? index[c] : i];
            whole = own->type != GP_UINT && own->xs == 1 && own->ys == 1;
        }
        if (!all)
            continue;
        if (!whole) {
            lists[0] = lists[0] && gp_channel_list_add(left, NULL, red->name);
            continue;
        }
        if (!from.c[0])
            GP_TRY(gp_planes_make(log, "layer", n, &from));
        for (int c = 0; c < 3; c++)
            gp_channel_floats(f, index[c], from.c[c]);
        GP_TRY(convert(log, user, f, n, &from, &to));
        for (int c = 0; c < 3; c++) {
            void *const data = f->channel[index[c]].data;
            if (f->channel[index[c]].type == GP_HALF)
                stats->clamped +=
                    (long long) gp_float_to_half(to.c[c], data, n);
            else
                memcpy(data, to.c[c], n * sizeof(float));
        }
        lists[1] = lists[1] && gp_channel_list_add(converted, NULL, red->name);
    }
    if (converted[0])
        gp_say(log, GP_LEVEL_INFO, "%s: converts the layers of %s too", f->path,
               converted);
    if (left[0])
        gp_say(log, GP_LEVEL_WARN, "%s: layers that are subsampled or luminance "
               "and chroma are not converted (%s); write them to a file of "
               "their own", f->path, left);
out:
    gp_free(name);
    gp_planes_free(&from);
    gp_planes_free(&to);
    return st;
}
