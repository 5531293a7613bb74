/* The alpha of a picture, without its colour. */
#include "io/plane.h"

#include "core/memory.h"
#include "io/image.h"
#include "io/io_priv.h"

#include <limits.h>
#include <string.h>

/* Returns the code of a coverage; NaN is 0. */
static uint16_t code_of(float v)
{
    const float covered = v > 0.0f ? v < 1.0f ? v : 1.0f : 0.0f;
    return (uint16_t) (covered * (float) GP_COVERED + 0.5f);
}

/* Returns the channel A of a picture, or -1. */
static int find_alpha(const struct gp_image *image)
{
    for (int i = 0; i < image->channels; i++) {
        if (strcmp(image->channel_name[i], "A") == 0)
            return i;
    }
    return -1;
}

/* Reads the codes of a channel, a block of rows at a time. */
static gp_status read_codes(const struct gp_log *log, struct gp_image *image,
                            int channel, uint16_t *code)
{
    const int h = gp_rect_h(image->data);
    const int step = image->pixels ? h : image->block;
    const size_t w = (size_t) gp_rect_w(image->data),
                 n = (size_t) image->channels;
    float *block = NULL;
    gp_status st = GP_OK;
    if (!image->pixels)
        GP_TRY(gp_alloc(log, "rows", (size_t) step * w, n * sizeof *block,
                        &block));
    for (int y = 0; y < h; y += step) {
        const size_t rows = (size_t) (h - y < step ? h - y : step);
        const float *const from =
            (image->pixels ? image->pixels : block) + channel;
        if (!image->pixels)
            GP_TRY(image->rows(log, image, y, block));
        for (size_t i = 0; i < rows * w; i++)
            code[(size_t) y * w + i] = code_of(from[i * n]);
    }
out:
    gp_free(block);
    return st;
}

/* Reads an open picture. */
static gp_status read_image(const struct gp_log *log, struct gp_image *image,
                            long long most, struct gp_coverage *out)
{
    const int channel = find_alpha(image);
    struct gp_coverage a = {1, 1, NULL};
    gp_status st;
    if (channel >= 0) {
        a.w = gp_rect_w(image->data);
        a.h = gp_rect_h(image->data);
    }
    const long long texels = (long long) a.w * a.h;
    if (texels > most)
        return gp_fail(log, GP_ERR_DATA, "%s: too large for a cut-out (%d x %d "
                       "texels, at most %lld); make the texture smaller",
                       image->path, a.w, a.h, most);
    GP_TRY(gp_alloc(log, image->path, (size_t) texels, sizeof *a.code,
                    &a.code));
    a.code[0] = GP_COVERED;
    if (channel >= 0)
        GP_TRY(read_codes(log, image, channel, a.code));
    *out = a;
    a.code = NULL;
out:
    gp_free(a.code);
    return st;
}

gp_status gp_read_coverage(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, const void *bytes,
    size_t n, long long most, struct gp_coverage *out)
{
    struct gp_read_params limits = gp_read_limits(p);
    struct gp_stream stream = gp_stream_of(bytes, n);
    struct gp_image image = {0};
    gp_status st;
    if (!bytes)
        GP_TRY(gp_stream_open_regular(log, path, &stream));
    // a larger picture than `most` has a line of its own, which does not
    // advise --max-pixels
    if (limits.max_pixels >= most)
        limits.max_pixels = LLONG_MAX / 64;
    GP_TRY(gp_read_image(log, &limits, path, &stream, 0, &image));
    st = read_image(log, &image, most, out);
out:
    gp_image_close(&image);
    gp_stream_close(&stream);
    return st;
}
