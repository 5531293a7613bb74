// SPDX-License-Identifier: Apache-2.0
/* Writes one EXR file: its parts, their channels and samples, by header.c and
 * encode.c. */
#include "io/exr/exr_priv.h"

#include "core/bytes.h"
#include "core/cpu.h"
#include "core/half.h"
#include "core/memory.h"
#include "io/channels.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* -- the channels of a part ----------------------------------------------- */

/* Colours over the largest value that the file can hold: of a half, or of DWA,
 * which holds nothing over DWA_MAX. With GP_OUT_AUTO a frame of halfs is
 * then float. Else such a pixel is scaled, which keeps its hue. */
struct fit {
    long long values, pixels;  // over it
    double light[3], lost[3];  // sums of all pixels, and of what was lost
};

/* DWA stores halfs, floats too, and its loss moves values near the end of
 * their range up to Inf: a sun of 65504 came back as Inf. An eighth below the
 * end nothing did. */
#define DWA_MAX 57344.0f

/* A part of the file. Names and samples of its channels belong to the frame and
 * the planes. Free with free_part(). */
struct part {
    const struct gp_frame *f; // its windows; NULL: the input's part as it is
    const struct gp_exr_part *own; // of the input, or NULL
    struct gp_exr_image img;  // owned: its list
    void **owned;             // names, alpha and planes that were made for it
    int n_owned;
    struct fit *fit;          // borrowed; added to
};

static int by_name(const void *a, const void *b)
{
    const struct gp_exr_source *p = a, *q = b;
    return strcmp(p->name, q->name);
}

/* Makes room for `most` channels, of the colours of `frames` frames. */
static gp_status make_room(const struct gp_log *log, int most, int frames,
                           struct part *out)
{
    // of a frame three names, alpha and the planes
    const gp_status st = gp_alloc_zero(log, "colours", 5 * (size_t) frames,
                                       sizeof *out->owned, &out->owned);
    return st ? st : gp_alloc(log, "channels", (size_t) most,
                              sizeof *out->img.source, &out->img.source);
}

static void free_part(struct part *part)
{
    for (int i = 0; i < part->n_owned; i++)
        gp_free(part->owned[i]);
    gp_free(part->owned);
    gp_free(part->img.source);
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
                       struct fit *sum)
{
    const float limit = dwa ? DWA_MAX : 65504.0f;
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

/* Finds the colours' type, and copies *planes where they do not fit it. */
static gp_status fit_colour(const struct gp_log *log,
    const struct gp_write_params *p, const struct gp_frame *f,
    struct gp_planes *planes, enum gp_pixel_type *type, struct part *out)
{
    const bool dwa = p->compression >= GP_COMPRESSION_DWAA;
    // the largest value that rounds to the largest half
    const float most = dwa ? DWA_MAX : nextafterf(65520.0f, 0.0f);
    const size_t n = gp_frame_pixels(f);
    bool beyond = false;
    *type = p->type == GP_OUT_AUTO   ? f->colour_type
            : p->type == GP_OUT_HALF ? GP_HALF : GP_FLOAT;
    for (int c = 0; c < 3 && (*type == GP_HALF || dwa); c++)
        beyond |= any_beyond(planes->c[c], n, most,
                             dwa ? INFINITY : FLT_MAX);
    if (beyond && !dwa && p->type == GP_OUT_AUTO) {
        *type = GP_FLOAT;
    } else if (beyond) {
        struct gp_planes to;
        const gp_status st = gp_planes_make(log, "colours", n, &to);
        if (st)
            return st;
        out->owned[out->n_owned++] = to.c[0]; // one block
        fit_pixels(planes, n, dwa, most, &to, out->fit);
        *planes = to;
    }
    return GP_OK;
}

/* -- pictures ------------------------------------------------------------- */

static void add_plane(struct part *s, enum gp_pixel_type type,
    const char *name, const struct gp_frame *f, const float *plane, bool linear)
{
    s->img.source[s->img.sources++] = (struct gp_exr_source) {
        .name = name, .xs = 1, .ys = 1, .linear = linear,
        .columns = gp_frame_w(f), .plane = plane, .type = type,
    };
}

/* -- --hdr ---------------------------------------------------------------- */

/* The frames of one part, among `n`. */
struct group {
    const struct gp_log *log;
    const struct gp_write_params *p;
    const struct gp_hdr_colour *set;
    int n, part;
    const struct gp_frame *complete; // the one that has all channels of it
};

/* Returns of how many frames channel `i` of the complete one is the colour. */
static int count_owners(const struct group *g, int i)
{
    const char *const name = g->complete->channel[i].name;
    int n = 0;
    for (int k = 0; k < g->n; k++) {
        const struct gp_frame *const f = g->set[k].f;
        for (int c = 0; c < f->channels; c++)
            n += f->part == g->part && f->channel[c].colour >= 0 &&
                 strcmp(f->channel[c].name, name) == 0;
    }
    return n;
}

/* Adds the channels that are the colour of no frame. */
static gp_status add_carried(const struct group *g, struct part *out)
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
        out->img.source[out->img.sources++] = (struct gp_exr_source) {
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
    const struct gp_hdr_colour *from, struct part *out)
{
    const struct gp_frame *f = from->f;
    struct gp_planes planes = from->planes;
    enum gp_pixel_type type;
    gp_status st = fit_colour(g->log, g->p, f, &planes, &type, out);
    if (st)
        return st;
    float *const *const plane = planes.c;
    const size_t n = gp_frame_pixels(f), bytes = n * sizeof(float);
    const struct gp_channel *like = f->channel; // a colour of the input
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
        out->owned[out->n_owned++] = name;
        if (is_taken(g, f, name))
            return gp_fail(g->log, GP_ERR_DATA,
                           "%s: the coloured glare needs a new channel %s, and "
                           "the file has another one of that name; rename "
                           "that", f->path, name);
        add_plane(out, type, name, f, plane[c], like->linear);
    }
    return GP_OK;
}

/* The channels of the part of out->f, with the colours of the frames of it, of
 * which one was read whole, as gp_write_hdr() says. */
static gp_status hdr_sources(const struct gp_log *log,
    const struct gp_write_params *p, const struct gp_hdr_colour *set, int n,
    struct part *out)
{
    gp_status st;
    struct group g = {log, p, set, n, out->f->part, out->f};
    for (int i = 0; i < n; i++) {
        if (set[i].f->part == g.part &&
            set[i].f->channels > g.complete->channels)
            g.complete = set[i].f;
    }
    GP_TRY(make_room(log, g.complete->channels + 3 * n, n, out));
    GP_TRY(add_carried(&g, out));
    for (int i = 0; i < n; i++) {
        if (set[i].f->part == g.part)
            GP_TRY(add_frame(&g, &set[i], out));
    }
    qsort(out->img.source, (size_t) out->img.sources,
          sizeof *out->img.source, by_name);
    // names from other formats may not fit EXR
    for (int i = 0; i < out->img.sources; i++) {
        const char *name = out->img.source[i].name;
        if (name[0] == '\0' || strlen(name) > 255 ||
            (i > 0 && strcmp(out->img.source[i - 1].name, name) == 0))
            GP_TRY(gp_fail(log, GP_ERR_DATA,
                           "%s: EXR cannot hold its channels (name \"%.40s\" "
                           "is empty, too long, or used twice); rename them",
                           out->f->path, name));
    }
out:
    return st;
}

/* -- compressions --------------------------------------------------------- */

/* True when samples of that channel may be read back with other bits; never for
 * AUTO. EXR's lossy compressions:
 *
 *   PXR24      32-bit floats lose the low 8 bits of their mantissa; half and
 *              uint keep all bits
 *   B44, B44A  half loses (blocks of 4x4 to 6 bits); float and uint keep all
 *   DWAA/B     channels called R, G, B, Y, RY or BY after their last dot lose,
 *              in any layer, half and float, and become half; others keep
 *              their bits, depth too
 *
 * Sources: OpenEXR 3.1.5, ImfPxr24Compressor.cpp, ImfB44Compressor.cpp,
 * DwaCompressor::initializeDefaultChannelRules() of ImfDwaCompressor.cpp. */
static bool loses(enum gp_compression compression, enum gp_pixel_type type,
                  const char *name)
{
    static const char *const dwa[] = {"R", "G", "B", "Y", "RY", "BY"};
    const char *last = name + gp_layer_length(name);
    bool colour = false;
    switch (compression) {
    case GP_COMPRESSION_PXR24:
        return type == GP_FLOAT;
    case GP_COMPRESSION_B44:
    case GP_COMPRESSION_B44A:
        return type == GP_HALF;
    case GP_COMPRESSION_DWAA:
    case GP_COMPRESSION_DWAB:
        for (size_t i = 0; i < sizeof dwa / sizeof *dwa; i++)
            colour = colour || strcmp(last, dwa[i]) == 0;
        return type != GP_UINT && colour;
    default:
        return false;
    }
}

/* -- a file on its way ---------------------------------------------------- */

/* All that is open at once, closed in one place. */
struct writing {
    const struct gp_log *log;
    const struct gp_write_params *p;
    const char *path;
    const struct gp_input *in; // NULL: not of an EXR
    enum gp_exr_kept kept;
    struct part *part; // those of the input, or one
    int parts;
    int *chunks;       // of each part
    struct gp_exr_out out;
    struct gp_file *file;
    long long clamped; // values, in the chunks
    struct fit fit;
};

/* Finds the compression of a new part, and how many chunks it has. */
static void plan_part(struct writing *w, struct part *part, int *chunks)
{
    enum gp_compression c = w->p->compression;
    part->own = w->in ? &w->in->each[part->f->part] : NULL;
    if (c == GP_COMPRESSION_AUTO) { // the input's, when that loses nothing
        const struct gp_exr_attr *const a =
            gp_exr_attr_find(part->own, "compression", "compression");
        c = a && a->size == 1 && a->data[0] <= GP_COMPRESSION_PIZ
                ? (enum gp_compression) a->data[0] : GP_COMPRESSION_ZIP;
    }
    // OpenImageIO writes a single channel as zip instead of DWA: the header
    // must match
    if (c >= GP_COMPRESSION_DWAA && part->img.sources == 1) {
        gp_say(w->log, GP_LEVEL_WARN,
               "%s: a single channel (%s) cannot be DWA; it is written as "
               "zip", w->path, part->img.source[0].name);
        c = GP_COMPRESSION_ZIP;
    }
    // DWA's quality is the input's, or OpenEXR's default
    float quality = 45.0f;
    const struct gp_exr_attr *const a =
        gp_exr_attr_find(part->own, "dwaCompressionLevel", "float");
    if (a && a->size == sizeof quality)
        memcpy(&quality, a->data, sizeof quality);
    part->img.data = part->f->data;
    part->img.compression = c;
    part->img.quality = quality >= 0.0f && quality <= 1e6f ? quality : 45.0f;
    *chunks = gp_exr_chunk_count(&part->img);
}

/* The header of a part of the input as it is. Parts may not differ in their
 * chromaticities (OpenEXR: "non-conforming shared attributes"): beside a part
 * that was converted to others, those of one that was not are left out. */
static void put_other_part(struct writing *w, int number)
{
    const uint8_t *const bytes = w->in->index->bytes;
    const struct gp_exr_part *const part = &w->in->each[number];
    const float *const converted = w->kept == GP_EXR_KEEP_CONVERTED
                                  ? w->p->primaries : NULL;
    const struct gp_exr_attr *const own =
        gp_exr_attr_find(part, "chromaticities", "chromaticities");
    const uint8_t *from = bytes + part->from;
    if (converted && own && memcmp(own->data, converted, own->size) != 0) {
        gp_say(w->log, GP_LEVEL_WARN, "%s: part %d is not converted, and loses "
               "its chromaticities, in which the parts of a file may not "
               "differ; write it to a file of its own", w->path, number);
        gp_exr_put_raw(&w->out, from,
                       (size_t) ((const uint8_t *) own->name - from));
        from = own->data + own->size;
    }
    gp_exr_put_raw(&w->out, from, (size_t) (bytes + part->to - from));
}

/* Counts the light that the file cannot hold, and says so where it is much. */
static void count_fits(const struct writing *w, struct gp_write_stats *stats)
{
    static const char *const name[3] = {"red", "green", "blue"};
    const struct fit *const fit = &w->fit;
    double share = 0.01;
    int worst = -1;
    stats->clamped += w->clamped + fit->values;
    for (int c = 0; c < 3; c++) {
        stats->flux_clamped[c] += fit->lost[c];
        if (fit->lost[c] > share * fit->light[c]) {
            share = fit->lost[c] / fit->light[c];
            worst = c;
        }
    }
    if (worst < 0)
        return;
    const bool dwa = w->p->compression >= GP_COMPRESSION_DWAA;
    gp_say(w->log, GP_LEVEL_WARN, "%s: %s loses %.3g %% of the %s light (%lld "
           "pixels over %g); use %s", w->path, dwa ? "DWA" : "--type half",
           100.0 * share, name[worst], fit->pixels,
           dwa ? (double) DWA_MAX : 65504.0,
           dwa ? "--compression zip" : "--type float or auto");
}

/* Writes the file, and frees what `w` has but its parts. */
static gp_status write_file(struct writing *w, struct gp_write_stats *stats)
{
    gp_status st;
    const struct gp_input *const in = w->in;
    const bool multi = w->parts > 1; // which only an input has
    uint32_t flags = multi ? GP_EXR_MULTIPART |
        (gp_le32(in->index->bytes + 4) & GP_EXR_LONG_NAMES) : 0;
    GP_TRY(gp_alloc_zero(w->log, "parts", (size_t) w->parts,
                         sizeof *w->chunks, &w->chunks));
    for (int i = 0; i < w->parts; i++) {
        if (w->part[i].f) {
            plan_part(w, &w->part[i], &w->chunks[i]);
            continue;
        }
        w->chunks[i] = in->each[i].chunks;
        flags |= in->each[i].deep ? GP_EXR_DEEP : 0;
    }
    GP_TRY(
        gp_file_open(w->log, w->path, w->p->create_dir, w->p->fsync, &w->file));
    gp_exr_out_begin(&w->out, w->log, w->file, flags);
    for (int i = 0; i < w->parts; i++) {
        const struct part *const part = &w->part[i];
        if (part->f)
            gp_exr_put_part(&w->out, part->f, &part->img, part->own, w->kept,
                            w->p, multi ? w->chunks[i] : 0);
        else
            put_other_part(w, i);
    }
    if (multi)
        gp_exr_put_raw(&w->out, "", 1);
    GP_TRY(gp_exr_out_tables(&w->out, w->chunks, w->parts));
    for (int i = 0; i < w->parts; i++)
        GP_TRY(w->part[i].f
                   ? gp_exr_encode(&w->out, i, &w->part[i].img, &w->clamped)
                   : gp_exr_out_copy(&w->out, i, in, i));
    GP_TRY(gp_exr_out_end(&w->out));
    GP_TRY(gp_file_commit(&w->file));
    count_fits(w, stats);
out:
    gp_file_discard(&w->file);
    gp_exr_out_free(&w->out);
    gp_free(w->chunks);
    return st;
}

/* -- pictures ------------------------------------------------------------- */

/* Adds R, G and B of `planes`, as LAYER.R where `layer` is not NULL; else, with
 * GP_ALPHA_KEEP, the A of the frame's colour too. */
static gp_status add_layer(const struct writing *w, const char *layer,
                           struct gp_planes planes, struct part *out)
{
    const struct gp_write_params *const p = w->p;
    const struct gp_frame *const f = out->f;
    const int alpha =
        !layer && p->alpha != GP_ALPHA_BLACK ? gp_find_alpha(f) : -1;
    const size_t room = layer ? strlen(layer) + 3 : 2;
    enum gp_pixel_type type;
    gp_status st;
    GP_TRY(fit_colour(w->log, p, f, &planes, &type, out));
    for (int c = 0; c < 3; c++) {
        char *name;
        GP_TRY(gp_alloc(w->log, "channels", room, 1, &name));
        out->owned[out->n_owned++] = name;
        snprintf(name, room, "%s%s%c", layer ? layer : "", layer ? "." : "",
                 "RGB"[c]);
        add_plane(out, type, name, f, planes.c[c], false);
    }
    if (alpha >= 0) {
        const enum gp_pixel_type own =
            f->channel[alpha].type == GP_HALF ? GP_HALF : GP_FLOAT;
        float *a;
        GP_TRY(gp_alloc(w->log, "alpha", gp_frame_pixels(f), sizeof *a, &a));
        out->owned[out->n_owned++] = a;
        gp_channel_floats(f, alpha, a);
        add_plane(out,
                  p->type == GP_OUT_AUTO   ? own
                  : p->type == GP_OUT_HALF ? GP_HALF
                                           : GP_FLOAT,
                  "A", f, a, true);
    }
out:
    return st;
}

/* Writes a file of one part, whose attributes w.kept says: n layers of those
 * names, or (NULL) one picture. */
static gp_status write_layers(struct writing w, const struct gp_frame *f,
                              const char *const *name,
                              const struct gp_planes *planes, int n,
                              struct gp_write_stats *stats)
{
    struct part part = {.f = f, .fit = &w.fit};
    gp_status st;
    w.in = gp_input_of(f);
    w.part = &part;
    w.parts = 1;
    GP_TRY(make_room(w.log, 4 * n, n, &part));
    for (int i = 0; i < n; i++)
        GP_TRY(add_layer(&w, name ? name[i] : NULL, planes[i], &part));
    qsort(part.img.source, (size_t) part.img.sources, sizeof *part.img.source,
          by_name);
    st = write_file(&w, stats);
out:
    free_part(&part);
    return st;
}

gp_status gp_exr_write_picture(const struct gp_picture_job *j)
{
    struct writing w = {
        .log = j->log,
        .p = j->p,
        .path = j->path,
        .kept =
            j->kind == GP_PICTURE_SCENE ? GP_EXR_KEEP_SCENE : GP_EXR_KEEP_SHOWN,
    };
    return write_layers(w, j->f, NULL, j->planes, 1, j->stats);
}

gp_status gp_write_parts(const struct gp_log *log,
                         const struct gp_write_params *p, const char *path,
                         const struct gp_frame *f, const char *const *name,
                         const struct gp_planes *part, int n,
                         struct gp_write_stats *stats)
{
    struct writing w = {
        .log = log,
        .p = p,
        .path = path,
        .kept = GP_EXR_KEEP_SCENE,
    };
    return write_layers(w, f, name, part, n, stats);
}

/* -- --hdr: the frame as it came in, with glare --------------------------- */

gp_status gp_write_hdr(const struct gp_log *log,
                       const struct gp_write_params *p, const char *path,
                       const struct gp_hdr_colour *set, int n,
                       struct gp_write_stats *stats)
{
    const struct gp_input *const in = gp_input_of(set[0].f);
    struct writing w = {
        .log = log,
        .p = p,
        .path = path,
        .in = in,
        .kept = p->converted ? GP_EXR_KEEP_CONVERTED : GP_EXR_KEEP_ALL,
    };
    gp_status st;
    const int parts = in ? in->parts : 1;
    GP_TRY(gp_alloc_zero(log, "parts", (size_t) parts, sizeof *w.part,
                         &w.part));
    w.parts = parts;
    // ids with one bit less are other ids. A compression that would do that was
    // asked for: AUTO loses nothing
    for (int i = 0; i < n; i++) {
        const int number = set[i].f->part;
        struct part *const to = &w.part[in ? number : 0];
        if (to->f)
            continue;
        to->f = set[i].f;
        to->fit = &w.fit;
        GP_TRY(hdr_sources(log, p, set, n, to));
        for (int k = 0; k < to->img.sources; k++) {
            const struct gp_exr_source *s = &to->img.source[k];
            if (s->data && loses(p->compression, s->type, s->name) &&
                gp_exr_crypto_channel(in, number, s->name) == GP_CRYPTO_IDS)
                GP_TRY(gp_fail(
                    log, GP_ERR_USAGE,
                    "%s: this compression would change the Cryptomatte ids "
                    "of %s (channel %s); use --compression zip",
                    path, set[0].f->path, s->name));
        }
    }
    st = write_file(&w, stats);
out:
    for (int i = 0; i < w.parts; i++)
        free_part(&w.part[i]);
    gp_free(w.part);
    return st;
}

/* -- --output-space -------------------------------------------------------- */

gp_status gp_convert_layers(const struct gp_log *log, gp_convert *convert,
    void *user, struct gp_frame *f, struct gp_write_stats *stats)
{
    const struct gp_input *const in = gp_input_of(f);
    const size_t n = gp_frame_pixels(f);
    struct gp_planes from = {0}, to = {0};
    char left[GP_CHANNEL_LIST] = "", converted[GP_CHANNEL_LIST] = "";
    const char **name = NULL; // of carried channels, "" of others
    gp_status st;
    GP_TRY(gp_alloc(log, "channels", (size_t) f->channels, sizeof *name,
                    &name));
    for (int i = 0; i < f->channels; i++)
        name[i] = f->channel[i].data ? f->channel[i].name : "";
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
            gp_exr_crypto_channel(in, f->part, red->name) != GP_CRYPTO_NONE ||
            !gp_find_layer_colour(name, f->channels, layer, false, &colour) ||
            colour.index[0] != i || colour.model == GP_COLOUR_GREY)
            continue;
        const int *const index = colour.index;
        bool whole = colour.model == GP_COLOUR_RGB, all = true;
        for (int c = 0; c < 3 && all && whole; c++) {
            all = index[c] >= 0;
            const struct gp_channel *const own =
                &f->channel[all ? index[c] : i];
            whole = own->type != GP_UINT && own->xs == 1 && own->ys == 1;
        }
        if (!all)
            continue;
        if (!whole) {
            gp_channel_list_add(left, NULL, red->name);
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
        gp_channel_list_add(converted, NULL, red->name);
    }
    if (converted[0])
        gp_say(log, GP_LEVEL_INFO, "%s: converts the layers of %s too", f->path,
               converted);
    if (left[0])
        gp_say(log, GP_LEVEL_WARN, "%s: layers that are subsampled or "
               "luminance and chroma are not converted (%s); write them to a "
               "file of their own", f->path, left);
out:
    gp_free(name);
    gp_planes_free(&from);
    gp_planes_free(&to);
    return st;
}
