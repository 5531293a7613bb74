// SPDX-License-Identifier: Apache-2.0
#include "io/read.h"

#include "core/bytes.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "io/exr/exr.h"
#include "io/io_priv.h"
#include "io/oiio/oiio.h"

#include <libdeflate.h>
#include <limits.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

// -- formats by their first bytes ---------------------------------------------

/* Magic bytes: of the formats that are read, and of others, which messages
 * name. The first that fits counts. */
static const struct {
    const char *name;
    const char *bytes;
    size_t n, at;
} magics[] = {
    {"EXR", "\x76\x2f\x31\x01", 4, 0},
    {"PNG", "\x89PNG", 4, 0},
    {"JPEG", "\xff\xd8\xff", 3, 0},
    {"TIFF", "II*\0", 4, 0}, // and most cameras' raw files
    {"TIFF", "MM\0*", 4, 0},
    {"TIFF", "II+\0", 4, 0}, // over 4 GiB
    {"TIFF", "MM\0+", 4, 0},
    {"Radiance HDR", "#?", 2, 0},
    {"DPX", "SDPX", 4, 0},
    {"DPX", "XPDS", 4, 0},
    {"WebP", "WEBP", 4, 8},
    {"BMP", "BM", 2, 0},
    {"SGI", "\x01\xda", 2, 0},
    // not read
    {"Cineon", "\x80\x2a\x5f\xd7", 4, 0},
    {"Cineon", "\xd7\x5f\x2a\x80", 4, 0},
    {"GIF", "GIF8", 4, 0},
    {"JPEG 2000", "\0\0\0\x0cjP", 6, 0},
    {"JPEG XL", "\0\0\0\x0cJXL", 7, 0},
    {"JPEG XL", "\xff\x0a", 2, 0},
    {"Photoshop", "8BPS", 4, 0},
    {"Softimage PIC", "\x53\x80\xf6\x34", 4, 0},
    {"HEIF", "ftyphe", 6, 4},
    {"AVIF", "ftypavi", 7, 4},
    {"QuickTime or MP4 movie", "ftyp", 4, 4},
    {"Matroska or WebM movie", "\x1a\x45\xdf\xa3", 4, 0},
    {"gzip", "\x1f\x8b", 2, 0},
    {"zip", "PK\x03\x04", 4, 0},
    {"web page", "<!DOC", 5, 0},
    {"git-lfs pointer", "version https://", 16, 0},
};

/* Targa has no magic: all fields of its header of 18 bytes must agree
 * (Truevision TGA File Format Specification 2.0, 1991, fields 1 to 5). */
static bool is_targa(const uint8_t *b, size_t n)
{
    if (n < 18 || b[1] > 1)
        return false;
    const int kind = b[2] & ~8, bits = b[16];  // + 8: runs
    const int entries = b[5] | b[6] << 8, entry = b[7];
    const bool palette = entries > 0 && (entry == 15 || entry == 16 ||
                                         entry == 24 || entry == 32);
    return b[2] < 16 && (b[12] | b[13]) && (b[14] | b[15]) &&
           (b[17] & 0xc0) == 0 && (b[17] & 0x0f) <= 8 && // alpha bits
           (b[1] ? palette : kind != 1) &&
           (kind == 1   ? bits == 8 || bits == 16
            : kind == 2 ? bits == 15 || bits == 16 || bits == 24 || bits == 32
                        : kind == 3 && (bits == 8 || bits == 16));
}

const char *gp_format_name(const uint8_t *b, size_t n)
{
    // PBM, PGM, PPM and PFM: "P", a letter, white space or a comment
    if (n >= 3 && b[0] == 'P' && b[2] && strchr(" \t\n\v\f\r#", b[2])) {
        if (b[1] == 'F' || b[1] == 'f')
            return "PFM";
        if (b[1] >= '1' && b[1] <= '6')
            return "PNM";
    }
    for (size_t i = 0; i < sizeof magics / sizeof *magics; i++) {
        if (n >= magics[i].at + magics[i].n &&
            memcmp(b + magics[i].at, magics[i].bytes, magics[i].n) == 0)
            return magics[i].name;
    }
    return is_targa(b, n) ? "Targa" : NULL;
}

// -- lengths of images in a stream --------------------------------------------

static gp_status exr_length(struct gp_stream *stream, uint64_t *length)
{
    struct gp_input *in;
    const gp_status st = gp_exr_open(NULL, "-", stream, &in);
    if (st)
        return st == GP_ERR_BUG ? st : GP_OK;
    *length = in->end;
    gp_input_free(in);
    return GP_OK;
}

static gp_status png_length(struct gp_stream *stream, uint64_t *length)
{
    uint8_t head[8]; // length and type of a chunk; a checksum follows its data
    uint64_t at = 8; // after the signature
    while (gp_stream_read(stream, head, sizeof head, at) == sizeof head) {
        at += 12 + (uint64_t) gp_be32(head);
        if (memcmp(head + 4, "IEND", 4) == 0 && at <= stream->size) {
            *length = at;
            break;
        }
    }
    return GP_OK;
}

// -- readers ------------------------------------------------------------------

/* All formats that are read: the helper refuses every other name. OpenImageIO's
 * readers of other formats crash, invent pictures, open other files and
 * addresses, or read values wrong. */
const struct gp_reader gp_readers[] = {
    {.format = "EXR", .oiio = "openexr", .length = exr_length},
    {.format = "PNG", .open = gp_png_open, .length = png_length},
    {.format = "PFM", .open = gp_pfm_open, .length = gp_pfm_length},
    {.format = "PNM", .oiio = "pnm"},
    {.format = "TIFF", .oiio = "tiff"},
    {.format = "JPEG", .oiio = "jpeg"},
    {.format = "Radiance HDR", .oiio = "hdr"},
    {.format = "DPX", .oiio = "dpx"},
    {.format = "BMP", .oiio = "bmp"},
    {.format = "SGI", .oiio = "sgi"},
    {.format = "Targa", .oiio = "targa"},
    {.format = "WebP", .oiio = "webp"},
    {0},
};

/* Returns NULL for formats that are not read. */
static const struct gp_reader *reader_of(const uint8_t *first, size_t n)
{
    const char *const name = gp_format_name(first, n);
    const struct gp_reader *r = gp_readers;
    while (r->format && !(name && strcmp(name, r->format) == 0))
        r++;
    return r->format ? r : NULL;
}

/* Finds the reader by a stream's first bytes. */
static gp_status find_reader(const struct gp_log *log, const char *path,
    const struct gp_stream *stream, const struct gp_reader **out)
{
    uint8_t first[GP_FIRST_BYTES] = {0};
    const int64_t got = gp_stream_read(stream, first, sizeof first, 0);
    if (got < 0)
        return gp_stream_failed(log, path);
    const size_t n = (size_t) got, length = strlen(path);
    const bool named_exr =
        length > 4 && strcasecmp(path + length - 4, ".exr") == 0;
    const char *found = gp_format_name(first, n);
    char text[64];
    snprintf(text, sizeof text, "unknown data, %02x %02x %02x %02x ...",
             first[0], first[1], first[2], first[3]);
    found = found ? found : text;
    *out = reader_of(first, n);
    if (*out != gp_readers && named_exr)
        return gp_fail(log, GP_ERR_DATA, "%s: is not an EXR (found %s); rename "
                       "it to its real ending, or give the EXR", path, found);
    return *out ? GP_OK
                : gp_fail(log, GP_ERR_DATA, "%s: not a format that glarepp "
                          "reads (%s); convert it, e.g. with oiiotool", path,
                          found);
}

gp_status gp_read_open(const struct gp_log *log, const struct gp_read_params *p,
                       const char *path, struct gp_stream *stream, bool *exr)
{
    // four float channels for each pixel, and a header
    const uint64_t most = UINT64_MAX / 32, pixels = (uint64_t) p->max_pixels;
    const uint64_t limit = (pixels < most ? pixels : most) * 16 + (1 << 26);
    const struct gp_reader *r = NULL;
    gp_status st = gp_stream_open(log, path, GP_FIRST_BYTES, stream);
    if (!st)
        st = find_reader(log, path, stream, &r);
    *exr = r == gp_readers;
    if (!st)
        return gp_stream_fill(log, path, limit, stream);
    gp_stream_close(stream);
    return st;
}

gp_status gp_read_image(const struct gp_log *log,
    const struct gp_read_params *p, const char *path,
    const struct gp_stream *stream, int part, struct gp_decoded *out)
{
    const struct gp_reader *r;
    const gp_status st = find_reader(log, path, stream, &r);
    if (st)
        return st;
    if (r->open && part > 0)
        return gp_fail(log, GP_ERR_DATA, "%s: has no part %d: a %s is one "
                       "picture; give part 0", path, part, r->format);
    return r->open ? r->open(log, path, stream, p->max_pixels, out)
                   : gp_oiio_open(log, path, stream, r->oiio, part,
                                  p->max_pixels, out);
}

gp_status gp_read_stream(const struct gp_log *log,
                         const struct gp_read_params *p, const char *path,
                         struct gp_stream *stream, struct gp_frame *out)
{
    gp_status st;
    struct gp_decoded image = {0};
    const struct gp_reader *r;
    const char *const part = p->part ? p->part : "0";
    GP_TRY(find_reader(log, path, stream, &r));
    if (r == gp_readers)
        return gp_read_exr(log, p, path, stream, out);
    if (p->view)
        GP_TRY(gp_fail(log, GP_ERR_USAGE,
                       "%s: has no view %.200s: only EXR has views; give the "
                       "file of that view", path, p->view));
    if (!*part || strlen(part) > 6 || part[strspn(part, "0123456789")])
        GP_TRY(gp_fail(log, GP_ERR_USAGE, "%s: has no part %.200s: parts of "
                       "formats other than EXR have only numbers; give one "
                       "from 0", path, part));
    GP_TRY(gp_read_image(log, p, path, stream, (int) strtol(part, NULL, 10),
                         &image));
    if (!gp_rect_empty(image.display)) // else it is the data window
        GP_TRY(gp_window_check(log, path, "display", gp_rect_w(image.display),
               gp_rect_h(image.display), p->max_pixels));
    GP_TRY(gp_decoded_frame(log, p->layer, &image, out));
out:
    gp_decoded_close(&image);
    gp_stream_close(stream);
    return st;
}

gp_status gp_read_frame(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, struct gp_frame *out)
{
    struct gp_stream stream;
    bool exr;
    gp_status st = gp_read_open(log, p, path, &stream, &exr);
    return st ? st : gp_read_stream(log, p, path, &stream, out);
}

bool gp_read_has_end(const char *path)
{
    struct gp_stream stream;
    const struct gp_reader *r;
    uint64_t length = 0;
    gp_status st = gp_stream_open_regular(NULL, path, &stream);
    if (st)
        return st == GP_ERR_IO;
    st = find_reader(NULL, path, &stream, &r);
    if (!st && r->length)
        st = r->length(&stream, &length);
    gp_stream_close(&stream);
    return !st && (!r->length || length > 0);
}

// -- views of a file ----------------------------------------------------------

gp_status gp_read_views(const struct gp_log *log,
                        const struct gp_read_params *p, const char *path,
                        const struct gp_members *m, struct gp_views *out)
{
    struct gp_stream stream;
    struct gp_input *in = NULL;
    const struct gp_reader *r;
    bool exr;
    gp_status st = GP_OK;
    if (m->n)
        stream = gp_stream_of(m->stream.data, m->member[0].size);
    else
        st = gp_read_open(log, p, path, &stream, &exr);
    if (!st)
        st = find_reader(log, path, &stream, &r);
    if (!st && r == gp_readers)
        st = gp_exr_open(log, path, &stream, &in);
    if (!st)
        st = gp_frame_views(log, p, &(struct gp_frame) {.input = in}, out);
    gp_stream_close(&stream);
    gp_input_free(in);
    return st;
}

// -- several images in one stream ---------------------------------------------

/* Splits the stream; an image whose end is unknown takes the rest. */
static gp_status find_members(const struct gp_log *log, const char *path,
                              struct gp_members *m)
{
    const uint64_t end = m->stream.size;
    for (uint64_t at = 0; at < end;) {
        const uint8_t *const data = m->stream.data + at;
        const uint64_t left = end - at;
        const size_t n = left < GP_FIRST_BYTES ? (size_t) left : GP_FIRST_BYTES;
        const struct gp_reader *const r = reader_of(data, n);
        struct gp_stream view = gp_stream_of(data, left);
        uint64_t size = 0;
        if (r && r->length && r->length(&view, &size))
            return gp_no_memory(log, path);
        if ((!r || !r->length) && m->n > 0)
            return gp_fail(log, GP_ERR_DATA,
                           "%s: no EXR, PNG or PFM follows frame %d (found "
                           "%02x at byte %llu); give whole files, one after "
                           "the other", path, m->n, data[0],
                           (unsigned long long) at);
        if (size == 0 || size > left)
            size = left;
        if ((m->n & (m->n - 1)) == 0) { // doubles at powers of two
            const size_t room = m->n ? 2 * (size_t) m->n : 1;
            void *list = m->member;
            gp_status st = gp_resize(log, "frame list",
                                     room * sizeof *m->member, &list);
            if (st)
                return st;
            m->member = list;
        }
        m->member[m->n++] = (struct gp_member) {at, size};
        for (at += size; at < end && m->stream.data[at] == 0; at++)
            ; // padding
    }
    return GP_OK;
}

gp_status gp_members_read(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, struct gp_members *out)
{
    gp_status st;
    struct gp_members m = {.stream = GP_STREAM_EMPTY};
    bool exr;
    GP_TRY(gp_read_open(log, p, path, &m.stream, &exr));
    if (!m.stream.data)
        GP_TRY(gp_fail(log, GP_ERR_BUG, "%s: is not a pipe", path));
    GP_TRY(find_members(log, path, &m));
    *out = m;
    return GP_OK;
out:
    gp_members_free(&m);
    return st;
}

void gp_members_free(struct gp_members *m)
{
    if (m->stream.data) // one that is all zero has no stream either
        gp_stream_close(&m->stream);
    gp_free(m->member);
    *m = (struct gp_members) {.stream = GP_STREAM_EMPTY};
}

gp_status gp_members_frame(const struct gp_log *log,
    const struct gp_read_params *p, const char *name,
    const struct gp_members *m, int i, struct gp_frame *out)
{
    struct gp_stream view = gp_stream_of(m->stream.data + m->member[i].at,
                                         m->member[i].size);
    return gp_read_stream(log, p, name, &view, out);
}

// -- the alpha of a picture ---------------------------------------------------

gp_status gp_read_coverage(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, const void *bytes,
    size_t n, long long most, struct gp_coverage *out)
{
    struct gp_read_params limits = gp_read_limits(p);
    struct gp_stream stream = gp_stream_of(bytes, n);
    struct gp_decoded image = {0};
    struct gp_coverage a = {1, 1, NULL};
    gp_status st;
    if (limits.max_pixels > most)
        limits.max_pixels = most;
    if (!bytes)
        GP_TRY(gp_stream_open_regular(log, path, &stream));
    GP_TRY(gp_read_image(log, &limits, path, &stream, 0, &image));
    int channel = image.channels - 1;
    while (channel >= 0 && strcmp(image.channel_name[channel], "A") != 0)
        channel--;
    if (channel >= 0) {
        a.w = gp_rect_w(image.data);
        a.h = gp_rect_h(image.data);
    }
    const size_t texels = (size_t) a.w * (size_t) a.h;
    GP_TRY(gp_alloc(log, path, texels, sizeof *a.code, &a.code));
    a.code[0] = GP_COVERED;
    const float *v = image.pixels + channel;
    for (size_t i = 0; i < texels && channel >= 0; i++, v += image.channels)
        a.code[i] = (uint16_t) (gp_clamp01(*v) * (float) GP_COVERED + 0.5f);
    *out = a;
out:
    gp_decoded_close(&image);
    gp_stream_close(&stream);
    return st;
}

// -- versions -----------------------------------------------------------------

void gp_io_versions(char *line, size_t size)
{
    int major, minor, patch;
    const char *tag;
    exr_get_library_version(&major, &minor, &patch, &tag);
    snprintf(line, size, "OpenEXRCore %d.%d.%d%s, libpng %s, libdeflate %s",
             major, minor, patch, tag ? tag : "", png_get_libpng_ver(NULL),
             LIBDEFLATE_VERSION_STRING);
}
