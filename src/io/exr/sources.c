/* Lists the channels of an EXR part that is written, and their samples. */
#include "io/exr/exr_priv.h"

#include "core/cpu.h"
#include "core/memory.h"
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

GP_CLONES static int any_beyond(const float *v, size_t n, float most,
                                float largest)
{
    int any = 0;
    for (size_t i = 0; i < n; i++)
        any |= (fabsf(v[i]) > most) & (fabsf(v[i]) <= largest);
    return any;
}

/* Copies n pixels, and scales those with a value over `most` to `limit`. */
static void fit_pixels(const struct gp_planes *from, size_t n, bool dwa,
                       float most, struct gp_planes *out,
                       struct gp_exr_fit *sum)
{
    const float limit = dwa ? GP_EXR_DWA_MAX : 65504.0f;
    for (size_t i = 0; i < n; i++) {
        float largest = 0.0f;
        bool over = false;
        for (int c = 0; c < 3; c++) {
            const float v = from->c[c][i];
            const bool finite = v <= FLT_MAX;
            largest = finite && v > largest ? v : largest;
            sum->values += finite && v > most;
            sum->light[c] += finite && v > 0.0f ? (double) v : 0.0;
            over |= finite && v > most;
        }
        sum->pixels += over;
        for (int c = 0; c < 3; c++) {
            const float v = from->c[c][i];
            const bool scaled = over && fabsf(v) <= FLT_MAX;
            float to = scaled ? fminf(v * (limit / largest), limit) : v;
            sum->lost[c] += scaled && v > 0.0f ? (double) v - (double) to : 0.0;
            if (dwa && fabsf(to) > limit) { // it has no Inf, and no less
                to = copysignf(limit, to);
                sum->values++;
            }
            out->c[c][i] = to;
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
    // the largest value that rounds to the largest half
    const float most = dwa ? GP_EXR_DWA_MAX : nextafterf(65520.0f, 0.0f);
    const size_t n = gp_frame_pixels(f);
    bool beyond = false;
    *type = p->type == GP_OUT_AUTO   ? f->colour_type
            : p->type == GP_OUT_HALF ? GP_HALF : GP_FLOAT;
    for (int c = 0; c < 3 && (*type == GP_HALF || dwa); c++)
        beyond |= any_beyond((*planes)->c[c], n, most,
                             dwa ? INFINITY : FLT_MAX);
    if (beyond && !dwa && p->type == GP_OUT_AUTO) {
        *type = GP_FLOAT;
    } else if (beyond) {
        struct gp_planes *const to = &out->fitted[out->fits];
        const gp_status st = gp_planes_make(log, "colours", n, to);
        if (st)
            return st;
        out->fits++;
        fit_pixels(*planes, n, dwa, most, to, out->fit);
        *planes = to;
    }
    return GP_OK;
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

/* Returns of how many frames channel `i` of the complete one is the colour. */
static int count_owners(const struct group *g, int i)
{
    const char *const name = g->complete->channel[i].name;
    int n = 0;
    for (int k = 0; k < g->n; k++) {
        const struct gp_frame *const f = g->set[k].f;
        // a frame with all channels has them in this order
        const bool all = f->channels == g->complete->channels;
        for (int c = all ? i : 0; c < (all ? i + 1 : f->channels); c++)
            n += f->channel[c].colour >= 0 &&
                 strcmp(f->channel[c].name, name) == 0;
    }
    return n;
}

/* Adds the channels that are the colour of no frame. */
static gp_status add_carried(const struct group *g, struct gp_exr_sources *out)
{
    for (int i = 0; i < g->complete->channels; i++) {
        const struct gp_channel *c = &g->complete->channel[i];
        const int owners = count_owners(g, i);
        if (owners > 1)
            return gp_fail(g->log, GP_ERR_USAGE,
                   "%s: channel %s is the colour of %d layers; name "
                   "each layer once", g->complete->path, c->name, owners);
        if (owners == 1)
            continue;
        if (!c->data)
            return gp_fail(g->log, GP_ERR_BUG, "%s: channel %s has no samples",
                   g->complete->path, c->name);
        out->source[out->sources++] = (struct gp_exr_source) {
            .name = c->name, .type = c->type, .xs = c->xs, .ys = c->ys,
            .linear = c->linear, .columns = c->w, .data = c->data,
        };
    }
    return GP_OK;
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
