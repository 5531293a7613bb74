// SPDX-License-Identifier: Apache-2.0
/* OpenImageIO by its helper program, for tests. */
#ifndef OIIO_HERE_H
#define OIIO_HERE_H

#include "io/io_priv.h"
#include "io/oiio/oiio.h"
#include "bridge_here.h"
#include "kept_log.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

/* Returns whether there is an OpenImageIO; after open_oiio(). */
static bool has_oiio;

static inline int open_oiio(void **state)
{
    if (find_bridges(state))
        return -1;
    has_oiio = gp_oiio_check(NULL, "-") == GP_OK;
    return 0;
}

/* Part 0 with its pixels; what is wrong goes to kept_line. */
static inline gp_status read_stream(const char *path, const struct gp_stream *s,
    long long max_pixels, struct gp_decoded *out)
{
    kept_clear();
    *out = (struct gp_decoded) {0};
    const struct gp_read_params p = {.max_pixels = max_pixels};
    return gp_read_image(&kept_log, &p, path, s, 0, out);
}

static inline gp_status read_bytes(const void *bytes, size_t n,
                                   long long max_pixels, struct gp_decoded *out)
{
    const struct gp_stream s = gp_stream_of(bytes, n);
    return read_stream("-", &s, max_pixels, out);
}

static inline gp_status read_image(const char *path, long long max_pixels,
                                   struct gp_decoded *out)
{
    struct gp_stream s;
    assert_ok(gp_stream_open(NULL, path, 1, &s));
    const gp_status st = read_stream(path, &s, max_pixels, out);
    gp_stream_close(&s);
    return st;
}

/* One line, and no image. */
static inline void refused(const char *name, const void *bytes, size_t n)
{
    struct gp_decoded image;
    if (read_bytes(bytes, n, 1 << 20, &image) != GP_ERR_DATA || image.own)
        fail_msg("%s was read: %s", name, kept_line);
    assert_int_equal(kept_errors, 1);
}

/* image->pixels as a file of `format` at `path`. */
static inline gp_status write_image(const char *path, const char *format,
    const struct gp_decoded *image, const char *type, const char *compression)
{
    struct gp_shared pixels = {0};
    struct gp_stream s = GP_STREAM_EMPTY;
    const size_t n = sizeof(float) * (size_t) gp_rect_w(image->data) *
                     (size_t) gp_rect_h(image->data) *
                     (size_t) image->channels;
    kept_clear();
    gp_status st = gp_shared_make(&kept_log, path, n, &pixels);
    if (!st) {
        memcpy(pixels.at, image->pixels, n);
        st = gp_oiio_write(&kept_log, image, NULL, &pixels, format, type,
                           compression, &s);
    }
    gp_shared_free(&pixels);
    if (st)
        return st;
    void *const bytes = malloc(s.size);
    FILE *const file = fopen(path, "wb");
    assert_true(bytes && file);
    assert_int_equal(gp_stream_read(&s, bytes, s.size, 0), s.size);
    assert_int_equal(fwrite(bytes, 1, s.size, file), s.size);
    assert_int_equal(fclose(file), 0);
    free(bytes);
    gp_stream_close(&s);
    return GP_OK;
}

/* A picture of w x h for write_image(). */
static inline struct gp_decoded image_of(float *pixels, int w, int h,
    const char *const *names, int channels, const char *space)
{
    return (struct gp_decoded) {
        .path = "image", .data = {0, 0, w, h}, .display = {0, 0, w, h},
        .channels = channels, .channel_name = names, .pixels = pixels,
        .colour_space = space,
    };
}

#endif
