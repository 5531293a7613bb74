/* libpng makes the container; rows are filtered and deflated here, all at
 * once, because libdeflate packs twice as fast as zlib and filters of rows
 * can be made in parallel when they look at one row only. */
#include "io/png_write.h"

#include "core/colour.h"
#include "core/memory.h"
#include "io/file.h"
#include "io/picture.h"

#include <libdeflate.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Every row has filter 1, Sub. CPU milliseconds of filter and deflate, and
 * megabytes, for 8-bit pictures:
 *
 *                            light sources    rendered night   photograph
 *                            1920x1080        960x540          587x675
 *   adaptive, zlib 6         480 ms 0.89 MB   77 ms 1.00 MB   162 ms 0.45 MB
 *   (as libpng does it)
 *   Sub, libdeflate 1         33    0.85      16    1.02       10    0.53
 *   Sub, libdeflate 3         51    0.75      25    1.00       20    0.52
 *   Sub, libdeflate 6        117    0.68      28    1.00       40    0.50
 *   Paeth, libdeflate 3       93    0.97      32    1.03       27    0.47
 *   adaptive, libdeflate 3   182    0.97      36    0.97       31    0.47
 */
enum { FILTER_SUB = 1, LEVEL = 3 };

enum { IDAT_BYTES = 1 << 20 }; // a chunk's size is seen by readers only

// -- pixels -------------------------------------------------------------------

struct filtering {
    const struct gp_picture *pic;
    uint8_t *to;       // height rows of `stride` bytes
    size_t stride;     // filter type and samples
};

static void sub8(const struct gp_picture *pic, const struct gp_picture_row *row,
                 uint8_t *to)
{
    const int n = pic->channels;
    for (int c = 0; c < n; c++) {
        uint8_t before = 0;
        for (int x = 0; x < pic->width; x++) {
            const uint8_t v = (uint8_t) row->code[c][x];
            to[(size_t) x * (size_t) n + (size_t) c] = (uint8_t) (v - before);
            before = v;
        }
    }
}

/* High byte first; the filter is on bytes. */
static void sub16(const struct gp_picture *pic,
                  const struct gp_picture_row *row, uint8_t *to)
{
    const int n = pic->channels;
    for (int c = 0; c < n; c++) {
        uint16_t before = 0;
        for (int x = 0; x < pic->width; x++) {
            const uint16_t v = row->code[c][x];
            uint8_t *t = to + 2 * ((size_t) x * (size_t) n + (size_t) c);
            t[0] = (uint8_t) ((v >> 8) - (before >> 8));
            t[1] = (uint8_t) (v - before);
            before = v;
        }
    }
}

static void filter_row(void *ctx, int y, struct gp_picture_row *row)
{
    const struct filtering *f = ctx;
    uint8_t *to = f->to + (size_t) y * f->stride;
    gp_picture_codes(f->pic, y, row);
    to[0] = FILTER_SUB;
    if (f->pic->bits == 8)
        sub8(f->pic, row, to + 1);
    else
        sub16(f->pic, row, to + 1);
}

/* The picture as one zlib stream; *data is for free(). */
static gp_status compress_picture(const struct gp_log *log,
                                  const struct gp_picture *pic, void **data,
                                  size_t *size)
{
    gp_status st;
    struct filtering f = {.pic = pic};
    struct libdeflate_compressor *c = libdeflate_alloc_compressor(LEVEL);
    void *raw = NULL, *out = NULL;
    f.stride = 1 + (size_t) pic->width * (size_t) pic->channels *
                   (size_t) (pic->bits / 8);
    const size_t n = f.stride * (size_t) pic->height;
    if (!c)
        GP_TRY(gp_fail_bare(log, GP_ERR_BUG, "PNG compressor: out of memory"));
    GP_TRY(gp_alloc(log, "PNG pixels", n, 1, &raw));
    f.to = raw;
    GP_TRY(gp_picture_each_row(log, pic, filter_row, &f));
    const size_t room = libdeflate_zlib_compress_bound(c, n);
    GP_TRY(gp_alloc(log, "PNG data", room, 1, &out));
    *size = libdeflate_zlib_compress(c, raw, n, out, room);
    *data = out;
    out = NULL;
out:
    libdeflate_free_compressor(c);
    gp_free(raw);
    gp_free(out);
    return st;
}

// -- container ----------------------------------------------------------------

/* What libpng's callbacks see. */
struct target {
    const struct gp_log *log;
    struct gp_file *file;
    gp_status st;  // of the file, which has said its line
};

static void write_bytes(png_structp png, png_bytep data, size_t n)
{
    struct target *t = png_get_io_ptr(png);
    t->st = gp_file_write(t->file, data, n);
    if (t->st)
        png_error(png, "write");
}

static void flush_nothing(png_structp png)
{
    (void) png;
}

static void on_error(png_structp png, png_const_charp message)
{
    struct target *t = png_get_error_ptr(png);
    if (!t->st)
        t->st = gp_fail(t->log, GP_ERR_IO,
                        "%s: libpng refuses it (%s); write another format",
                        gp_file_path(t->file), message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void) png;
    (void) message;
}

static bool is_rec709(const float *chromaticities)
{
    return memcmp(chromaticities, gp_rec709_chromaticities,
                  sizeof gp_rec709_chromaticities) == 0;
}

static bool is_srgb(const struct gp_frame *f, enum gp_picture_kind kind)
{
    return kind == GP_PICTURE_SHOWN ||
           (kind == GP_PICTURE_SCENE && is_rec709(f->chromaticities));
}

static void set_colour(png_structp png, png_infop info,
                       const struct gp_frame *f, enum gp_picture_kind kind)
{
    const float *c = f->chromaticities;
    if (kind == GP_PICTURE_ENCODED)
        return;
    if (is_srgb(f, kind)) {
        png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_RELATIVE);
        return;
    }
    png_set_gAMA_fixed(png, info, 45455); // 1 / 2.2, as beside sRGB
    for (int i = 0; i < 8; i += 2) { // PNG has no imaginary primaries
        if (!(c[i] >= 0 && c[i + 1] >= 0 && c[i] + c[i + 1] <= 1))
            return;
    }
    png_set_cHRM(png, info, (double) c[6], (double) c[7], (double) c[0],
                 (double) c[1], (double) c[2], (double) c[3], (double) c[4],
                 (double) c[5]);
}

static void set_aspect(png_structp png, png_infop info,
                       const struct gp_frame *f)
{
    const double unit = 10000.0; // pixels of no unit; only their ratio counts
    const double a = (double) f->pixel_aspect;
    if (a != 1.0 && a > 1e-4 && a < 1e4)
        png_set_pHYs(png, info, (png_uint_32) (unit / a + 0.5),
                     (png_uint_32) unit, PNG_RESOLUTION_UNKNOWN);
}

/* All chunks. Nothing here is changed between setjmp() and longjmp() but what
 * the pointers lead to. */
static gp_status write_chunks(struct target *t, const struct gp_picture *pic,
                              const struct gp_frame *f,
                              enum gp_picture_kind kind, const void *data,
                              size_t size)
{
    // ITU-T H.273: BT.709 primaries, sRGB curve, RGB, full range
    static const png_byte cicp[4] = {1, 13, 0, 1};
    png_infop info = NULL;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, t,
                                              on_error, on_warning);
    if (png)
        info = png_create_info_struct(png);
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        return t->st ? t->st
                     : gp_fail_bare(t->log, GP_ERR_BUG, "PNG: out of memory");
    }
    png_set_write_fn(png, t, write_bytes, flush_nothing);
    png_set_benign_errors(png, 1); // of odd primaries: a file without them
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_IHDR(png, info, (png_uint_32) pic->width,
                 (png_uint_32) pic->height, pic->bits,
                 pic->channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA
                                    : PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_BASE,
                 PNG_FILTER_TYPE_BASE);
    set_colour(png, info, f, kind);
    set_aspect(png, info, f);
    png_write_info(png, info);
    if (is_srgb(f, kind))
        png_write_chunk(png, (png_const_bytep) "cICP", cicp, sizeof cicp);
    for (size_t at = 0; at < size; at += IDAT_BYTES)
        png_write_chunk(png, (png_const_bytep) "IDAT",
                        (png_const_bytep) data + at,
                        size - at < IDAT_BYTES ? size - at : IDAT_BYTES);
    png_write_chunk(png, (png_const_bytep) "IEND", NULL, 0);
    png_destroy_write_struct(&png, &info);
    return GP_OK;
}

gp_status gp_png_write(const struct gp_log *log,
                       const struct gp_write_params *p, const char *path,
                       const struct gp_frame *f,
                       const struct gp_planes *planes,
                       enum gp_picture_kind kind)
{
    gp_status st;
    struct gp_picture pic;
    void *data = NULL;
    size_t size = 0;
    struct target t = {.log = log};
    GP_TRY(gp_picture_make(log, p, path, f, planes, kind, true, &pic));
    GP_TRY(compress_picture(log, &pic, &data, &size));
    GP_TRY(gp_file_open(log, path, p->create_dir, &t.file));
    GP_TRY(write_chunks(&t, &pic, f, kind, data, size));
    GP_TRY(gp_file_commit(&t.file));
out:
    gp_file_discard(&t.file);
    gp_free(data);
    gp_picture_free(&pic);
    return st;
}
