#include "io/read.h"

#include "io/exr/exr.h"
#include "io/format.h"
#include "io/image.h"
#include "io/oiio/oiio.h"
#include "io/png.h"
#include "io/read_open.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

static const uint8_t exr_magic[4] = {0x76, 0x2f, 0x31, 0x01};

static bool ends_with_exr(const char *path)
{
    size_t n = strlen(path);
    return n > 4 && strcasecmp(path + n - 4, ".exr") == 0;
}

/* The first bytes of an input. */
struct start {
    uint8_t byte[GP_FORMAT_BYTES];
    size_t n;
};

/* "PATH: is ... (found PNG); do ..." */
static gp_status refuse(const struct gp_log *log, const char *path,
                        const struct start *s, const char *is,
                        const char *instead)
{
    char found[64];
    const char *const name = gp_format_name(s->byte, s->n);
    if (name)
        snprintf(found, sizeof found, "%s", name);
    else
        snprintf(found, sizeof found, "unknown data, %02x %02x %02x %02x ...",
                 s->byte[0], s->byte[1], s->byte[2], s->byte[3]);
    return gp_fail(log, GP_ERR_DATA, "%s: %s (found %s); %s", path, is, found,
                   instead);
}

/* Bytes that a frame of max_pixels may have in a pipe: four float channels
 * for each, and a header. */
static uint64_t pipe_limit(const struct gp_read_params *p)
{
    const uint64_t most = UINT64_MAX / 32;
    uint64_t pixels = (uint64_t) p->max_pixels;
    return (pixels < most ? pixels : most) * 16 + (1 << 26);
}

/* Looks at the first bytes of an open stream, and closes it on failure. Of a
 * pipe that has more to give, they must be those of an image. */
static gp_status look(const struct gp_log *log, const char *path,
                      struct gp_stream *stream, bool *exr)
{
    gp_status st = GP_OK;
    struct start s = {0};
    const int64_t n = gp_stream_read(stream, s.byte, sizeof s.byte, 0);
    s.n = n < 0 ? 0 : (size_t) n;
    if (n < 0)
        st = gp_fail(log, GP_ERR_IO, "%s: cannot read (%m); check the file",
                     path);
    *exr = memcmp(s.byte, exr_magic, sizeof exr_magic) == 0;
    if (!st && !*exr && ends_with_exr(path))
        st = refuse(log, path, &s, "is not an EXR", "rename it to its real "
                    "ending, or give the EXR");
    if (!st && stream->more && !gp_format_reads(s.byte, s.n))
        st = refuse(log, path, &s, "no image format that can be read",
                    "give an EXR or convert it");
    if (st)
        gp_stream_close(stream);
    return st;
}

gp_status gp_read_open(const struct gp_log *log,
                       const struct gp_read_params *p, const char *path,
                       struct gp_stream *stream, bool *exr)
{
    gp_status st = gp_stream_open(log, path, GP_FORMAT_BYTES, stream);
    if (!st)
        st = look(log, path, stream, exr);
    return st ? st : gp_stream_fill(log, path, pipe_limit(p), stream);
}

gp_status gp_read_image(const struct gp_log *log,
                        const struct gp_read_params *p, const char *path,
                        const struct gp_stream *stream, int part,
                        struct gp_image *out)
{
    uint8_t first[4] = {0};
    if (gp_stream_read(stream, first, sizeof first, 0) == sizeof first &&
        memcmp(first, "\x89PNG", sizeof first) == 0)
        return gp_png_open(log, path, stream, part, p->max_pixels, out);
    return gp_oiio_open(log, path, stream, part, p->max_pixels, out);
}

/* What formats other than EXR have of parts and views. */
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

static gp_status read_other(const struct gp_log *log,
                            const struct gp_read_params *p, const char *path,
                            const struct gp_stream *stream,
                            struct gp_frame *out)
{
    gp_status st;
    struct gp_image image = {0};
    int part;
    GP_TRY(choose_part(log, p, path, &part));
    GP_TRY(gp_read_image(log, p, path, stream, part, &image));
    const struct gp_rect show = image.display;
    if (!gp_rect_empty(show)) // else it is the data window
        GP_TRY(gp_window_check(log, path, "display", gp_rect_w(show),
                               gp_rect_h(show), p->max_pixels));
    GP_TRY(gp_image_frame(log, p->layer, &image, out));
out:
    gp_image_close(&image);
    return st;
}

gp_status gp_read_stream(const struct gp_log *log,
                         const struct gp_read_params *p, const char *path,
                         struct gp_stream *stream, struct gp_frame *out)
{
    bool exr;
    gp_status st = look(log, path, stream, &exr);
    if (st)
        return st;
    if (exr)
        return gp_read_exr(log, p, path, stream, out);
    st = read_other(log, p, path, stream, out);
    gp_stream_close(stream);
    return st;
}

gp_status gp_read_frame(const struct gp_log *log,
                        const struct gp_read_params *p, const char *path,
                        struct gp_frame *out)
{
    struct gp_stream stream;
    bool exr;
    gp_status st = gp_read_open(log, p, path, &stream, &exr);
    return st ? st : gp_read_stream(log, p, path, &stream, out);
}
