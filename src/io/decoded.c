// SPDX-License-Identifier: Apache-2.0
#include "io/decoded.h"

#include "core/colour.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "io/channels.h"
#include "core/half.h"
#include "core/maths.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* -- transfer curves ------------------------------------------------------ */

enum curve { LINEAR, SRGB, REC709, CINEON, GAMMA };

static enum curve curve_of(const struct gp_decoded *image, float *gamma)
{
    const char *space = image->colour_space;
    *gamma = 1.0f;
    if (image->bits == 0) // floats are linear, whatever the file says
        return LINEAR;
    // 8 bits without a name are sRGB: linear ones would band
    if (strcasecmp(space, "sRGB") == 0 || (!space[0] && image->bits == 8))
        return SRGB;
    if (strcasecmp(space, "Rec709") == 0)
        return REC709;
    if (strcasecmp(space, "KodakLog") == 0 || strcasecmp(space, "Cineon") == 0)
        return CINEON;
    if (strncasecmp(space, "Gamma", 5) == 0) {
        *gamma = strtof(space + strcspn(space, "0123456789"), NULL);
        return *gamma > 0.0f ? GAMMA : LINEAR; // "Gamma2.2"
    }
    return LINEAR;
}

static float decode(enum curve curve, float gamma, float v)
{
    // Kodak, "Grayscale Transformations of Cineon Digital Film Data", 1993:
    // white at code 685 of 1023, black at 95, 0.002 density a code, gamma 0.6
    const double step = 0.002 / 0.6, black = gp_pow(10.0, (95 - 685) * step);
    const double x = (double) v;
    switch (curve) {
    case SRGB:
        return gp_srgb_decode(v);
    case REC709: // ITU-R BT.709-6, item 1.2, turned round
        return v < 0.081f ? v / 4.5f
                          : (float) gp_pow((x + 0.099) / 1.099, 1.0 / 0.45);
    case CINEON:
        return (float) ((gp_pow(10.0, (x * 1023.0 - 685.0) * step) - black) /
                        (1.0 - black));
    case GAMMA:
        return (float) gp_pow(x, (double) gamma);
    case LINEAR:
        break;
    }
    return v;
}

/* -- planes --------------------------------------------------------------- */

/* Codes of 8 and 16 bits are multiples of 1/65535: their curve is a table. */
enum { CODES = 65536 };

struct split {
    const struct gp_decoded *image;
    struct gp_frame *f;
    float *table; // NULL when linear
    enum curve curve;
    float gamma;
};

static float linear(const struct split *s, float v)
{
    const float code = v * 65535.0f, whole = nearbyintf(code);
    const bool tabled =
        whole >= 0.0f && whole < (float) CODES && fabsf(code - whole) < 0.02f;
    return tabled ? s->table[(int) whole] : decode(s->curve, s->gamma, v);
}

static void split_row(void *ctx, int y, int thread)
{
    const struct split *const s = ctx;
    const size_t w = (size_t) gp_rect_w(s->image->data);
    const size_t n = (size_t) s->image->channels, at = (size_t) y * w;
    (void) thread;
    for (size_t i = 0; i < n; i++) {
        const struct gp_channel *const c = &s->f->channel[i];
        const bool colour = c->colour >= 0;
        const float *from = s->image->pixels + at * n + i;
        void *const data = colour ? s->f->rgb.c[c->colour] : c->data;
        for (size_t x = at; x < at + w; x++, from += n) {
            if (!colour && c->type == GP_HALF)
                (void) gp_float_to_half(from, (uint16_t *) data + x, 1);
            else
                ((float *) data)[x] =
                    colour && s->table ? linear(s, *from) : *from;
        }
    }
}

void gp_decoded_channel(const struct gp_decoded *image, int channel, float *to)
{
    const size_t n = gp_rect_pixels(image->data);
    for (size_t i = 0; i < n; i++)
        to[i] = image->pixels[i * (size_t) image->channels + (size_t) channel];
}

void gp_decoded_close(struct gp_decoded *image)
{
    if (image->close)
        image->close(image);
    else
        gp_free(image->pixels);
    *image = (struct gp_decoded) {0};
}

/* -- the frame ------------------------------------------------------------ */

/* Chooses the layer's colour; without a layer by names, else the first. */
static gp_status choose_colour(const struct gp_log *log, const char *layer,
    const struct gp_decoded *image, struct gp_colour_choice *out)
{
    const char *const *name = image->channel_name;
    char list[GP_CHANNEL_LIST] = "";
    if (!layer) {
        if (!gp_find_colour(name, image->channels, true, out) ||
            out->model == GP_COLOUR_YC)
            *out = image->channels >= 3
                       ? (struct gp_colour_choice) {GP_COLOUR_RGB, {0, 1, 2}}
                       : (struct gp_colour_choice) {GP_COLOUR_GREY,
                                                    {0, -1, -1}};
        return GP_OK;
    }
    for (int lone = 0; lone < 2; lone++) {
        if (gp_find_layer_colour(name, image->channels, layer, lone, out) &&
            out->model != GP_COLOUR_YC)
            return GP_OK;
    }
    for (int i = 0; i < image->channels; i++)
        gp_channel_list_add(list, NULL, name[i]);
    return gp_fail(log, GP_ERR_USAGE,
                   "%s: has no layer %.200s (channels: %s); give one of its "
                   "layers", image->path, layer, list);
}

gp_status gp_decoded_frame(const struct gp_log *log, const char *layer,
                         const struct gp_decoded *image, struct gp_frame *out)
{
    gp_status st;
    struct gp_frame f = {0};
    struct gp_colour_choice colour;
    struct split s = {.image = image, .f = &f};
    GP_TRY(choose_colour(log, layer, image, &colour));
    f = (struct gp_frame) {
        .data = image->data,
        .display = gp_rect_empty(image->display) ? image->data : image->display,
        .pixel_aspect =
            image->pixel_aspect > 1e-6f && image->pixel_aspect < 1e6f
                ? image->pixel_aspect
                : 1.0f,
        .model = colour.model,
        .parts = 1,
        .colour_type = image->half ? GP_HALF : GP_FLOAT,
    };
    memcpy(f.chromaticities, image->chromaticities ? image->chromaticities
                                                   : gp_rec709_chromaticities,
           sizeof f.chromaticities);
    f.names_chromaticities = image->chromaticities != NULL;
    gp_luminance_weights(f.chromaticities, f.luminance);
    GP_TRY(gp_frame_make(log, image->path, image->channels, &f));
    for (int i = 0; i < image->channels; i++) {
        const struct gp_channel like = {
            .type = f.colour_type,
            .xs = 1,
            .ys = 1,
            .w = gp_frame_w(&f),
            .h = gp_frame_h(&f),
            .colour = gp_colour_of(&colour, i),
            .name = (char *) (uintptr_t) image->channel_name[i],
        };
        GP_TRY(gp_frame_add(log, &f, &like));
    }
    GP_TRY(gp_alloc_zero(log, "attributes", (size_t) image->attributes,
                         sizeof *f.attribute, &f.attribute));
    for (int i = 0; i < image->attributes; i++) {
        const struct gp_attribute *const from = &image->attribute[i];
        struct gp_attribute *const to = &f.attribute[f.attributes++];
        *to = *from;
        to->name = gp_strdup(from->name);
        to->text = from->text ? gp_strdup(from->text) : NULL;
        if (!to->name || (from->text && !to->text))
            GP_TRY(gp_no_memory_bare(log, "attributes"));
    }
    s.curve = curve_of(image, &s.gamma);
    if (s.curve != LINEAR)
        GP_TRY(gp_alloc(log, "curve", CODES, sizeof *s.table, &s.table));
    for (int i = 0; s.table && i < CODES; i++)
        s.table[i] = decode(s.curve, s.gamma, (float) i / 65535.0f);
    gp_parallel_do(gp_frame_h(&f), split_row, &s);
    gp_frame_fill(&f, colour.index);
out:
    gp_free(s.table);
    if (st)
        gp_frame_free(&f);
    else
        *out = f;
    return st;
}

gp_status gp_window_check(const struct gp_log *log, const char *path,
    const char *which, int64_t w, int64_t h, long long max_pixels)
{
    if (w >= 1 && h >= 1 && w <= INT_MAX / 4 && h <= INT_MAX / 4 &&
        w * h <= max_pixels)
        return GP_OK;
    const bool empty = w < 1 || h < 1;
    return gp_fail(log, GP_ERR_DATA,
                   "%s: the %s window is %s (%lld x %lld pixels, at most "
                   "%lld); %s", path, which, empty ? "empty" : "too large",
                   (long long) w, (long long) h, max_pixels,
                   empty ? "render the file again"
                         : "crop it, or raise --max-pixels");
}
