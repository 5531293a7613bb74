#include "io/read.h"

#include "io/exr_read.h"
#include "io/oiio_frame.h"
#include "io/read_open.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

enum { MAGIC_BYTES = 16 };

static const uint8_t exr_magic[4] = {0x76, 0x2f, 0x31, 0x01};

/* First bytes of what is likely to be found under a wrong name. */
static const struct {
    const char *name;
    const char *bytes;
    size_t n;
} magic[] = {
    {"PNG", "\x89PNG", 4},         {"JPEG", "\xff\xd8\xff", 3},
    {"TIFF", "II*\0", 4},          {"TIFF", "MM\0*", 4},
    {"Radiance HDR", "#?", 2},     {"DPX", "SDPX", 4},
    {"DPX", "XPDS", 4},            {"PFM", "PF\n", 3},
    {"PFM", "Pf\n", 3},            {"gzip", "\x1f\x8b", 2},
    {"zip", "PK\x03\x04", 4},      {"WebP or AVI", "RIFF", 4},
    {"GIF", "GIF8", 4},            {"BMP", "BM", 2},
    {"a web page", "<!DOC", 5},    {"a web page", "<html", 5},
    {"a git-lfs pointer", "version https://", 16},
};

static bool ends_with_exr(const char *path)
{
    size_t n = strlen(path);
    return n > 4 && strcasecmp(path + n - 4, ".exr") == 0;
}

static gp_status not_exr(const struct gp_log *log, const char *path,
                         const uint8_t first[MAGIC_BYTES])
{
    char unknown[64];
    snprintf(unknown, sizeof unknown, "unknown data, %02x %02x %02x %02x ...",
             first[0], first[1], first[2], first[3]);
    const char *found = unknown;
    for (size_t i = 0; i < sizeof magic / sizeof *magic; i++) {
        if (memcmp(first, magic[i].bytes, magic[i].n) == 0) {
            found = magic[i].name;
            break;
        }
    }
    return gp_fail(log, GP_ERR_DATA,
                   "%s: is not an EXR (found %s); rename it to its real "
                   "ending, or give the EXR", path, found);
}

/* Bytes that a frame of max_pixels may have in a pipe: four float channels
 * for each, and a header. */
static uint64_t pipe_limit(const struct gp_read_params *p)
{
    const uint64_t most = UINT64_MAX / 32;
    uint64_t pixels = (uint64_t) p->max_pixels;
    return (pixels < most ? pixels : most) * 16 + (1 << 26);
}

/* Looks at the first bytes of an open stream, and closes it on failure. */
static gp_status look(const struct gp_log *log, const char *path,
                      struct gp_stream *stream, bool *exr)
{
    gp_status st = GP_OK;
    uint8_t first[MAGIC_BYTES] = {0};
    if (gp_stream_read(stream, first, sizeof first, 0) < 0)
        st = gp_fail(log, GP_ERR_IO, "%s: cannot read (%m); check the file",
                     path);
    *exr = memcmp(first, exr_magic, sizeof exr_magic) == 0;
    if (!st && !*exr && ends_with_exr(path))
        st = not_exr(log, path, first);
    if (st)
        gp_stream_close(stream);
    return st;
}

gp_status gp_read_open(const struct gp_log *log,
                       const struct gp_read_params *p, const char *path,
                       struct gp_stream *stream, bool *exr)
{
    gp_status st = gp_stream_open(log, path, pipe_limit(p), stream);
    return st ? st : look(log, path, stream, exr);
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
    st = gp_read_other(log, p, path, stream, out);
    gp_stream_close(stream);
    return st;
}

gp_status gp_read_frame(const struct gp_log *log,
                        const struct gp_read_params *p, const char *path,
                        struct gp_frame *out)
{
    struct gp_stream stream;
    gp_status st = gp_stream_open(log, path, pipe_limit(p), &stream);
    return st ? st : gp_read_stream(log, p, path, &stream, out);
}
