#include "io/oiio/frame.h"

#include "core/colour.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "io/channels.h"
#include "io/colour.h"
#include "io/exr/exr.h"
#include "io/half.h"
#include "io/whole.h"
#include "io/window.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* -- transfer curves ------------------------------------------------------ */

/* ITU-R BT.709-6, item 1.2, turned round. */
static float decode_rec709(float v)
{
    return v < 0.081f ? v / 4.5f : powf((v + 0.099f) / 1.099f, 1.0f / 0.45f);
}

/* Kodak, "Grayscale Transformations of Cineon Digital Film Data", 1993:
 * white at code 685 of 1023, black at 95, 0.002 density a code, gamma 0.6. */
static float decode_cineon(float v)
{
    const float step = 0.002f / 0.6f;
    float black = powf(10.0f, (95.0f - 685.0f) * step);
    float light = powf(10.0f, (v * 1023.0f - 685.0f) * step);
    return (light - black) / (1.0f - black);
}

/* What the bridge calls a colour space, as far as integers come in it. */
enum curve { LINEAR, SRGB, REC709, CINEON, GAMMA };

static enum curve curve_of(const struct gp_oiio_image *image, float *gamma)
{
    const char *space = image->colour_space;
    *gamma = 1.0f;
    if (image->bits == 0) // floats are light, whatever the file calls them
        return LINEAR;
    // nobody keeps light in 8 bits without a curve
    if (strcasecmp(space, "sRGB") == 0 || (!space[0] && image->bits == 8))
        return SRGB;
    if (strcasecmp(space, "Rec709") == 0)
        return REC709;
    if (strcasecmp(space, "KodakLog") == 0 || strcasecmp(space, "Cineon") == 0)
        return CINEON;
    if (strncasecmp(space, "Gamma", 5) == 0) {
        for (const char *c = space + 5; *c; c++) { // "Gamma2.2", no locale
            if (*c < '0' || *c > '9')
                continue;
            *gamma = (float) (*c - '0');
            float unit = 0.1f;
            for (const char *d = c + 2; c[1] == '.' && *d >= '0' && *d <= '9';
                 d++, unit *= 0.1f)
                *gamma += unit * (float) (*d - '0');
            return GAMMA;
        }
    }
    return LINEAR;
}

static float decode(enum curve curve, float gamma, float v)
{
    switch (curve) {
    case SRGB:
        return gp_srgb_decode(v);
    case REC709:
        return decode_rec709(v);
    case CINEON:
        return decode_cineon(v);
    case GAMMA:
        return powf(v, gamma);
    case LINEAR:
        break;
    }
    return v;
}

enum { CODES = 65536 };

/* Codes of 8 and 16 bits are multiples of 1/65535: their curve is a table. */
static gp_status make_table(const struct gp_log *log, enum curve curve,
                            float gamma, float **table)
{
    void *p;
    gp_status st = gp_alloc(log, "curve", CODES, sizeof **table, &p);
    if (st)
        return st;
    *table = p;
    for (int i = 0; i < CODES; i++)
        (*table)[i] = decode(curve, gamma, (float) i / 65535.0f);
    return GP_OK;
}

/* -- planes --------------------------------------------------------------- */

struct split {
    const struct gp_oiio_image *image;
    const float *pixels; // rows from y0 on
    int y0;
    struct gp_frame *f;
    const float *table;  // NULL when linear
    enum curve curve;
    float gamma;
    float *row;          // w floats a thread
};

static void linear_row(const struct split *s, float *row, int w)
{
    for (int x = 0; s->table && x < w; x++) {
        float code = row[x] * 65535.0f, whole = nearbyintf(code);
        bool tabled = whole >= 0.0f && whole < (float) CODES &&
                      fabsf(code - whole) < 0.02f;
        row[x] = tabled ? s->table[(int) whole]
                        : decode(s->curve, s->gamma, row[x]);
    }
}

static void split_row(void *ctx, int y, int thread)
{
    const struct split *s = ctx;
    const int w = s->image->w, n = s->image->channels;
    const size_t at = (size_t) (s->y0 + y) * (size_t) w;
    const float *const pixels =
        s->pixels + (size_t) y * (size_t) w * (size_t) n;
    float *row = s->row + (size_t) thread * (size_t) w;
    for (int i = 0; i < n; i++) {
        const struct gp_channel *c = &s->f->channel[i];
        const float *from = pixels + i;
        for (int x = 0; x < w; x++)
            row[x] = from[(size_t) x * (size_t) n];
        if (c->colour >= 0) {
            linear_row(s, row, w);
            memcpy(s->f->rgb.c[c->colour] + at, row, (size_t) w * sizeof *row);
        } else if (c->type == GP_HALF) {
            (void) gp_float_to_half(row, (uint16_t *) c->data + at,
                                    (size_t) w);
        } else {
            memcpy((float *) c->data + at, row, (size_t) w * sizeof *row);
        }
    }
}

static gp_status bridge_failed(const struct gp_log *log, const char *path,
                               int result, const char *which, const char *why)
{
    if (result == GP_OIIO_MEMORY)
        return gp_oiio_no_memory(log, path, why);
    return gp_fail(log, GP_ERR_DATA,
                   "%s: no image format%s that can be read (%s); give an EXR "
                   "or convert it", path, which,
                   why[0] ? why : "cut off or damaged");
}

/* Splits an image that is still in its file, a block at a time. */
static gp_status split_blocks(const struct gp_log *log, struct split *s)
{
    struct gp_oiio_image image = *s->image;
    char why[512] = "";
    void *block = NULL;
    const struct gp_oiio_api *api = gp_oiio_open(why, sizeof why);
    gp_status st = gp_alloc(log, "rows",
                            (size_t) image.block * (size_t) image.w,
                            (size_t) image.channels * sizeof(float), &block);
    s->pixels = block;
    for (; !st && s->y0 < image.h; s->y0 += image.block) {
        const int left = image.h - s->y0;
        const int got = api->rows(&image, s->y0, block, why, sizeof why);
        if (got)
            st = bridge_failed(log, s->f->path, got, "", why);
        else
            gp_parallel_do(left < image.block ? left : image.block, split_row,
                           s);
    }
    gp_free(block);
    return st;
}

static gp_status fill_planes(const struct gp_log *log,
                             const struct gp_oiio_image *image,
                             struct gp_frame *f)
{
    gp_status st;
    struct split s = {.image = image, .f = f, .pixels = image->pixels};
    float *table = NULL;
    void *row = NULL;
    s.curve = curve_of(image, &s.gamma);
    if (s.curve != LINEAR)
        GP_TRY(make_table(log, s.curve, s.gamma, &table));
    s.table = table;
    GP_TRY(gp_alloc(log, "row", (size_t) gp_threads() * (size_t) image->w,
                    sizeof(float), &row));
    s.row = row;
    if (image->pixels)
        gp_parallel_do(image->h, split_row, &s);
    else
        GP_TRY(split_blocks(log, &s));
out:
    gp_free(row);
    gp_free(table);
    return st;
}

/* -- the frame ------------------------------------------------------------ */

/* The colour of a layer by its name. */
static gp_status choose_layer(const struct gp_log *log, const char *path,
                              const char *layer,
                              const struct gp_oiio_image *image,
                              struct gp_colour_choice *out)
{
    const char *const *name = image->channel_name;
    char list[GP_CHANNEL_LIST] = "";
    for (int lone = 0; lone < 2; lone++) {
        if (gp_find_layer_colour(name, image->channels, layer, lone, out) &&
            out->model != GP_COLOUR_YC)
            return GP_OK;
    }
    for (int i = 0; i < image->channels; i++) {
        if (!gp_channel_list_add(list, NULL, name[i]))
            break;
    }
    return gp_fail(log, GP_ERR_USAGE,
                   "%s: has no layer %.200s (channels: %s); give one of its "
                   "layers", path, layer, list);
}

/* Names decide; without a name that means colour, the first three channels
 * are RGB, or the first one is grey. */
static struct gp_colour_choice choose(const struct gp_oiio_image *image)
{
    struct gp_colour_choice c;
    if (gp_find_colour(image->channel_name, image->channels, true, &c) &&
        c.model != GP_COLOUR_YC)
        return c;
    if (image->channels >= 3)
        return (struct gp_colour_choice) {GP_COLOUR_RGB, {0, 1, 2}};
    return (struct gp_colour_choice) {GP_COLOUR_GREY, {0, -1, -1}};
}

static gp_status make_channels(const struct gp_log *log,
                               const struct gp_oiio_image *image,
                               const struct gp_colour_choice *colour,
                               struct gp_frame *f)
{
    void *list;
    gp_status st = gp_alloc_zero(log, "channels", (size_t) image->channels,
                                 sizeof *f->channel, &list);
    f->channel = list;
    for (int i = 0; !st && i < image->channels; i++) {
        struct gp_channel *c = &f->channel[i];
        *c = (struct gp_channel) {
            .type = f->colour_type, .xs = 1, .ys = 1, .w = image->w,
            .h = image->h, .colour = -1,
            .name = gp_strdup(image->channel_name[i]),
        };
        f->channels = i + 1;
        for (int k = 0; k < 3; k++) {
            if (colour->index[k] == i)
                c->colour = k;
        }
        if (!c->name)
            return gp_fail(log, GP_ERR_BUG, "%s: out of memory; close other "
                           "programs", f->path);
        if (c->colour < 0)
            st = gp_alloc(log, c->name, gp_frame_pixels(f),
                          gp_type_size(c->type), &c->data);
    }
    return st;
}

static void fill_header(const struct gp_oiio_image *image, struct gp_frame *f)
{
    f->data = (struct gp_rect) {image->x, image->y, image->x + image->w,
                                image->y + image->h};
    f->display = (struct gp_rect) {image->full_x, image->full_y,
                                   image->full_x + image->full_w,
                                   image->full_y + image->full_h};
    if (gp_rect_empty(f->display))
        f->display = f->data;
    f->pixel_aspect = 1.0f;
    for (int i = 0; i < image->attributes; i++) {
        const struct gp_oiio_attribute *a = &image->attribute[i];
        if (a->kind == 2 && strcmp(a->name, "PixelAspectRatio") == 0 &&
            a->real > 1e-6f && a->real < 1e6f)
            f->pixel_aspect = a->real;
    }
    memcpy(f->chromaticities,
           image->has_chromaticities ? image->chromaticities
                                     : gp_rec709_chromaticities,
           sizeof f->chromaticities);
    gp_luminance_weights(f->chromaticities, f->luminance);
    f->parts = 1;
    f->colour_type = image->half ? GP_HALF : GP_FLOAT;
}

gp_status gp_frame_of_image(const struct gp_log *log, const char *path,
                            const char *layer,
                            const struct gp_oiio_image *image,
                            struct gp_frame *out)
{
    gp_status st;
    struct gp_colour_choice colour;
    struct gp_input *input;
    if (layer) {
        st = choose_layer(log, path, layer, image, &colour);
        if (st)
            return st;
    } else {
        colour = choose(image);
    }
    struct gp_frame f = {.path = gp_strdup(path)};
    if (!f.path)
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory; close other "
                       "programs", path);
    fill_header(image, &f);
    f.model = colour.model;
    GP_TRY(make_channels(log, image, &colour, &f));
    GP_TRY(gp_planes_make(log, "frame", gp_frame_pixels(&f), &f.rgb));
    GP_TRY(fill_planes(log, image, &f));
    for (int k = 1; k < 3 && f.model == GP_COLOUR_GREY; k++)
        memcpy(f.rgb.c[k], f.rgb.c[0], gp_frame_pixels(&f) * sizeof(float));
    for (int k = 0; k < 3 && f.model == GP_COLOUR_RGB; k++) {
        if (colour.index[k] < 0)
            memset(f.rgb.c[k], 0, gp_frame_pixels(&f) * sizeof(float));
    }
    GP_TRY(gp_input_keep(log, image, &input));
    f.input = input;
    f.input_free = gp_input_free;
out:
    if (st)
        gp_frame_free(&f);
    else
        *out = f;
    return st;
}

/* With `pixels`, or open for their rows. */
static gp_status read_subimage(const struct gp_log *log,
                               const struct gp_read_params *p,
                               const char *path,
                               const struct gp_stream *stream, int part,
                               bool pixels, struct gp_oiio_image *out)
{
    char why[512] = "", which[40] = "";
    const struct gp_oiio_api *api = gp_oiio_open(why, sizeof why);
    if (!api)
        return gp_fail(log, GP_ERR_IO,
                       "%s: formats other than EXR need the OpenImageIO "
                       "bridge (%s); install it, or give an EXR", path, why);
    const gp_status st = gp_whole_check(log, path, stream, part,
                                        p->max_pixels);
    if (st)
        return st;
    if (part > 0)
        snprintf(which, sizeof which, " and part %d of it", part);
    const int got = (pixels ? api->read : api->open)(
        path, stream->data, stream->size, part, p->max_pixels, out, why,
        sizeof why);
    return got ? bridge_failed(log, path, got, which, why) : GP_OK;
}

gp_status gp_read_image(const struct gp_log *log,
                        const struct gp_read_params *p, const char *path,
                        const struct gp_stream *stream,
                        struct gp_oiio_image *out)
{
    return read_subimage(log, p, path, stream, 0, true, out);
}

void gp_image_free(struct gp_oiio_image *image)
{
    char why[512];
    const struct gp_oiio_api *api = gp_oiio_open(why, sizeof why);
    if (api && image->own)
        api->image_free(image);
}

/* What these formats have of parts and views. */
static gp_status choose_part(const struct gp_log *log,
                             const struct gp_read_params *p, const char *path,
                             int *part)
{
    *part = 0;
    if (p->view)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: has no view %.200s: only EXR has views; give the "
                       "file of that view", path, p->view);
    for (const char *c = p->part; c && (*c || c == p->part); c++) {
        if (*c < '0' || *c > '9' || *part > 99999)
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: has no part %.200s: parts of formats other "
                           "than EXR have numbers alone; give one from 0",
                           path, p->part);
        *part = 10 * *part + (*c - '0');
    }
    return GP_OK;
}

gp_status gp_read_other(const struct gp_log *log,
                        const struct gp_read_params *p, const char *path,
                        const struct gp_stream *stream, struct gp_frame *out)
{
    struct gp_oiio_image image;
    int part;
    gp_status st = choose_part(log, p, path, &part);
    if (!st)
        st = read_subimage(log, p, path, stream, part, false, &image);
    if (st)
        return st;
    if (image.full_w > 0 && image.full_h > 0) // else it is the data window
        st = gp_window_check(log, path, "display", image.full_w, image.full_h,
                             p->max_pixels);
    if (!st)
        st = gp_frame_of_image(log, path, p->layer, &image, out);
    gp_image_free(&image);
    return st;
}
