// SPDX-License-Identifier: Apache-2.0
/* libpng does all of the reading. When writing, it makes the container; rows
 * are filtered here, in parallel, and packed at once by libdeflate, which is
 * twice as fast as zlib. */
#include "io/io_priv.h"

#include "core/colour.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "io/file.h"

#include <errno.h>
#include <libdeflate.h>
#include <math.h>
#include <png.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

static void on_warning(png_structp png, png_const_charp message)
{
    (void) png;
    (void) message;
}

// -- reading ------------------------------------------------------------------

enum {
    IDAT = 0x49444154,
    MOST_TEXTS = 64, // a file's: each may unpack to 8 MB
    MOST_END = 16, // bytes of a zlib stream after the last row: ends of blocks,
                   // an empty one, a checksum
};

struct png_input {
    const char *path;
    const struct gp_stream *stream;
    uint64_t at;               // in the stream
    const struct gp_log *log;
    gp_status st;              // its line is printed
    png_structp png;
    png_infop info;
    size_t stride;             // bytes of a row
    bool done, surplus;        // all rows are read; there is more
    size_t after;              // bytes of IDAT that were read once done
    int x, y, width, height, channels, bytes; // bytes of a sample
    float gamma;               // as OpenImageIO rounds it; 1 none
    char space[24];
    char time[32];
    struct gp_attribute *attribute;
    uint8_t *rows;
    float *pixels;
};

static void read_bytes(png_structp png, png_bytep to, size_t n)
{
    struct png_input *in = png_get_io_ptr(png);
    const int64_t got = gp_stream_read(in->stream, to, n, in->at);
    if (got < 0)
        in->st = gp_fail(in->log, GP_ERR_IO,
                         "%s: cannot be read (%s); check the disk", in->path,
                         strerror(errno));
    if (got != (int64_t) n)
        png_error(png, "the file ends too early");
    in->at += n;
    if (in->done && png_get_io_state(png) & PNG_IO_CHUNK_DATA &&
        png_get_io_chunk_type(png) == IDAT)
        in->after += n;
}

/* libpng only warns of rows that the picture has no place for, and not of those
 * in a further IDAT. */
static void on_read_warning(png_structp png, png_const_charp message)
{
    struct png_input *in = png_get_error_ptr(png);
    in->surplus |= strstr(message, "Too much image data") ||
                   strstr(message, "Extra compressed data");
}

static void on_read_error(png_structp png, png_const_charp message)
{
    struct png_input *in = png_get_error_ptr(png);
    if (!in->st && strstr(message, "ut of memory"))
        in->st = gp_no_memory(in->log, in->path);
    else if (!in->st)
        in->st = gp_fail(in->log, GP_ERR_DATA,
                         "%s: damaged (%s); copy or render the file again",
                         in->path, message);
    png_longjmp(png, 1);
}

/* A later attribute of the same name, in any case, replaces an earlier one. */
static void add_text(struct gp_attribute *list, int *n, char *name, char *text)
{
    int i = 0;
    while (i < *n && strcasecmp(list[i].name, name) != 0)
        i++;
    list[i] = (struct gp_attribute) {
        .name = name, .kind = GP_ATTRIBUTE_TEXT, .text = text,
    };
    *n += i == *n;
}

/* Texts and the time, under the names that OpenImageIO gives them. */
static gp_status list_attributes(struct png_input *in, int *n)
{
    static char date_time[] = "DateTime", artist[] = "Artist",
                document[] = "DocumentName", what[] = "ImageDescription";
    png_textp text = NULL;
    png_timep t;
    const int texts = png_get_text(in->png, in->info, &text, NULL);
    gp_status st = gp_alloc(in->log, "attributes", (size_t) texts + 1,
                            sizeof *in->attribute, &in->attribute);
    struct gp_attribute *const list = in->attribute;
    *n = 0;
    if (st)
        return st;
    if (png_get_tIME(in->png, in->info, &t)) {
        snprintf(in->time, sizeof in->time, "%4d:%02d:%02d %02d:%02d:%02d",
                 t->year, t->month, t->day, t->hour, t->minute, t->second);
        add_text(list, n, date_time, in->time);
    }
    for (int i = 0; i < texts; i++) {
        char *const key = text[i].key;
        if (strcasecmp(key, "XML:com.adobe.xmp") == 0 ||
            strcasecmp(key, "Raw profile type exif") == 0)
            continue;
        add_text(list, n,
                 strcasecmp(key, "Description") == 0 ? what
                 : strcasecmp(key, "Author") == 0    ? artist
                 : strcasecmp(key, "Title") == 0     ? document : key,
                 text[i].text);
    }
    return GP_OK;
}

/* Reads the header and all rows, then on to IEND: the other chunks must be
 * whole too. May leave by longjmp(). */
static gp_status read_all(struct png_input *in, long long max_pixels)
{
    const int far = 1 << 29; // sums of two edges fit an int
    png_structp png = in->png;
    png_set_read_fn(png, in, read_bytes);
    png_set_chunk_cache_max(png, MOST_TEXTS);
    png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    png_read_info(png, in->info);
    png_set_expand(png);
    const int passes = png_set_interlace_handling(png);
    // before memory is taken for pixels
    const png_uint_32 w = png_get_image_width(png, in->info);
    const png_uint_32 h = png_get_image_height(png, in->info);
    gp_status st = gp_window_check(in->log, in->path, "data", w, h, max_pixels);
    in->x = png_get_x_offset_pixels(png, in->info);
    in->y = png_get_y_offset_pixels(png, in->info);
    if (!st && (in->x <= -far || in->x >= far || in->y <= -far || in->y >= far))
        st = gp_fail(in->log, GP_ERR_DATA,
                     "%s: damaged (an offset of %d, %d pixels); render the "
                     "file again",
                     in->path, in->x, in->y);
    if (st)
        return st;
    png_read_update_info(png, in->info);
    in->width = (int) w;
    in->height = (int) h;
    in->channels = png_get_channels(png, in->info);
    in->bytes = png_get_bit_depth(png, in->info) / 8;
    in->stride = png_get_rowbytes(png, in->info);
    // the curve, by OpenImageIO's rules and names
    double gamma = 0.0;
    int intent;
    snprintf(in->space, sizeof in->space, "sRGB");
    in->gamma = 1.0f;
    if (!png_get_sRGB(png, in->info, &intent) &&
        png_get_gAMA(png, in->info, &gamma) && gamma > 0.0) {
        in->gamma = roundf(100.0f * (float) (1.0 / gamma)) / 100.0f;
        snprintf(in->space, sizeof in->space, "Gamma%.2g",
                 (double) in->gamma);
        if (in->gamma == 1.0f)
            snprintf(in->space, sizeof in->space, "linear");
    }
    st = gp_alloc(in->log, "PNG rows", h, in->stride, &in->rows);
    if (!st)
        st = gp_alloc(in->log, "PNG pixels", (size_t) h * w,
                      (size_t) in->channels * sizeof(float), &in->pixels);
    for (int pass = 0; pass < passes && !st; pass++) {
        for (size_t y = 0; y < h; y++)
            png_read_row(png, in->rows + y * in->stride, NULL);
    }
    in->done = true;
    if (!st)
        png_read_end(png, NULL);
    if (!st && (in->surplus || in->after > MOST_END))
        gp_say(in->log, GP_LEVEL_WARN,
               "%s: more data than its %d x %d pixels; the rest is left out",
               in->path, in->width, in->height);
    return st;
}

/* A row of codes to fractions, alpha associated; PNG is big-endian. */
static void sample_row(void *ctx, int y, int thread)
{
    (void) thread;
    const struct png_input *const in = ctx;
    const int n = in->channels, alpha = n % 2 == 0 ? n - 1 : n;
    const bool wide = in->bytes == 2;
    const uint32_t max = wide ? 65535 : 255;
    const float scale = 1.0f / (float) max;
    const uint8_t *from = in->rows + (size_t) y * in->stride;
    float *to = in->pixels + (size_t) y * (size_t) in->width * (size_t) n;
    for (int x = 0; x < in->width; x++, to += n) {
        uint32_t code[4];
        for (int c = 0; c < n; c++, from += in->bytes)
            code[c] = wide ? (uint32_t) from[0] << 8 | from[1] : from[0];
        if (alpha < n && in->gamma == 1.0f) {
            for (int c = 0; c < alpha; c++)
                code[c] = code[c] * code[alpha] / max;
        } else if (alpha < n) {
            const double a =
                gp_pow((double) code[alpha] / max, (double) in->gamma);
            for (int c = 0; c < alpha; c++)
                code[c] = (uint32_t) (code[c] * a);
        }
        for (int c = 0; c < n; c++)
            to[c] = (float) code[c] * scale;
    }
}

static void close_input(struct gp_decoded *image)
{
    struct png_input *const in = image->own;
    png_destroy_read_struct(&in->png, &in->info, NULL);
    gp_free(in->attribute);
    gp_free(in->rows);
    gp_free(in->pixels);
    gp_free(in);
}

gp_status gp_png_open(const struct gp_log *log, const char *path,
                      const struct gp_stream *stream, long long max_pixels,
                      struct gp_decoded *out)
{
    static const char *const names[][4] = {
        {"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"},
    };
    struct png_input *in;
    gp_status st = gp_alloc_zero(log, path, 1, sizeof *in, &in);
    if (st)
        return st;
    *in = (struct png_input) {.path = path, .stream = stream, .log = log};
    struct gp_decoded image = {.path = path, .close = close_input, .own = in};
    in->png = png_create_read_struct(PNG_LIBPNG_VER_STRING, in, on_read_error,
                                     on_read_warning);
    if (in->png)
        in->info = png_create_info_struct(in->png);
    if (!in->info && !in->st)
        in->st = gp_no_memory(log, path);
    if (in->info && !setjmp(png_jmpbuf(in->png)))
        in->st = read_all(in, max_pixels);
    if (!in->st)
        in->st = list_attributes(in, &image.attributes);
    if (in->st) {
        st = in->st;
        gp_decoded_close(&image);
        return st;
    }
    gp_parallel_do(in->height, sample_row, in);
    GP_FREE(in->rows);
    *out = image;
    out->data =
        (struct gp_rect) {in->x, in->y, in->x + in->width, in->y + in->height};
    out->display = (struct gp_rect) {0, 0, in->width, in->height};
    out->pixel_aspect = png_get_pixel_aspect_ratio(in->png, in->info);
    out->channels = in->channels;
    out->channel_name = names[in->channels - 1];
    out->bits = 8 * in->bytes;
    out->colour_space = in->space;
    out->attribute = in->attribute;
    out->pixels = in->pixels;
    return GP_OK;
}

// -- writing ------------------------------------------------------------------

/* Every row has filter 1, Sub, in one stream: at level 1, of a rendered night of
 * 960x540 that is 16 ms of CPU and 1.02 MB. Adaptive filters and zlib's level 6,
 * as libpng has them, take 77 ms and 1.00 MB, level 6 of libdeflate 28 ms and
 * 1.00 MB. Pieces of level 3, packed by all threads, made runs 4 to 16 %
 * longer. */
enum { FILTER_SUB = 1, CHUNK_MOST = 1 << 30 };

/* The filter is on bytes, each after that of the pixel before. */
static void filter_row(const struct gp_picture *pic, uint8_t *row)
{
    const size_t step = (size_t) pic->channels * (size_t) pic->bits / 8;
    row[0] = FILTER_SUB;
    for (size_t i = (size_t) pic->width * step; i > step; i--)
        row[i] = (uint8_t) (row[i] - row[i - step]);
}

/* State of libpng's callbacks. */
struct target {
    const struct gp_log *log;
    struct gp_file *file;
    gp_status st;  // of the file, whose line is printed
};

static void write_bytes(png_structp png, png_bytep data, size_t n)
{
    struct target *t = png_get_io_ptr(png);
    t->st = gp_file_write(t->file, data, n);
    if (t->st)
        png_error(png, "write");
}

static void on_write_error(png_structp png, png_const_charp message)
{
    struct target *t = png_get_error_ptr(png);
    if (!t->st && strstr(message, "memory"))
        t->st = gp_no_memory(t->log, gp_file_path(t->file));
    else if (!t->st)
        t->st = gp_fail(t->log, GP_ERR_IO,
                        "%s: libpng refuses it (%s); write another format",
                        gp_file_path(t->file), message);
    png_longjmp(png, 1);
}

/* Sets a text, as iTXt where it is not ASCII. */
static void set_text(png_structp png, png_infop info, const char *key,
                     const char *value)
{
    int compression = PNG_TEXT_COMPRESSION_NONE;
    for (const char *s = value; *s; s++) {
        if (*s & 0x80)
            compression = PNG_ITXT_COMPRESSION_NONE;
    }
    const png_text text = {
        .compression = compression,
        .key = (png_charp) (uintptr_t) key,
        .text = (png_charp) (uintptr_t) value,
    };
    png_set_text(png, info, &text, 1);
}

/* PNG has no imaginary primaries. */
static bool are_real(const float c[8])
{
    for (int i = 0; i < 8; i += 2) {
        if (!(c[i] >= 0 && c[i + 1] >= 0 && c[i] + c[i + 1] <= 1))
            return false;
    }
    return true;
}

/* The chunks that describe the colours. */
struct tags {
    bool srgb;        // sRGB, gAMA and cHRM
    bool scene;       // else gAMA of 1 / 2.2, and cHRM
    png_byte cicp[4]; // ITU-T H.273: primaries, curve, RGB, full range;
                      // primaries 0: no cICP
};

static struct tags tags_of(const struct gp_write_params *p,
                           const struct gp_frame *f, enum gp_picture_kind kind)
{
    struct tags t = {
        .scene = kind == GP_PICTURE_SCENE,
        .cicp = {1, 13, 0, 1},
    };
    if (kind == GP_PICTURE_ENCODED)
        memcpy(t.cicp, p->cicp, sizeof p->cicp);
    if (t.scene && memcmp(f->chromaticities, gp_rec709_chromaticities,
                          sizeof f->chromaticities) != 0)
        t.cicp[0] = 0;
    t.srgb = t.cicp[0] == 1 && t.cicp[1] == 13;
    return t;
}

/* Writes all chunks. Between setjmp() and longjmp() no local variable changes,
 * only what the pointers lead to. */
static gp_status write_chunks(struct target *t, const struct gp_picture *pic,
                              const struct gp_frame *f, const struct tags *tags,
                              const struct gp_write_params *p,
                              const uint8_t *data, size_t size)
{
    const double unit = 10000.0; // pixels of no unit; only their ratio counts
    const double aspect = (double) f->pixel_aspect;
    const float *const c = f->chromaticities;
    png_infop info = NULL;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, t,
                                              on_write_error, on_warning);
    if (png)
        info = png_create_info_struct(png);
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        return t->st ? t->st
                     : gp_no_memory_bare(t->log, "PNG");
    }
    png_set_write_fn(png, t, write_bytes, NULL);
    png_set_benign_errors(png, 1); // of odd primaries: a file without them
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_IHDR(png, info, (png_uint_32) pic->width,
                 (png_uint_32) pic->height, pic->bits,
                 pic->channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA
                                    : PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_BASE,
                 PNG_FILTER_TYPE_BASE);
    if (tags->srgb)
        png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_RELATIVE);
    else if (tags->scene)
        png_set_gAMA_fixed(png, info, 45455); // 1 / 2.2, as beside sRGB
    if (tags->scene && !tags->srgb && are_real(c))
        png_set_cHRM(png, info, (double) c[6], (double) c[7], (double) c[0],
                     (double) c[1], (double) c[2], (double) c[3],
                     (double) c[4], (double) c[5]);
    if (aspect != 1.0 && aspect > 1e-4 && aspect < 1e4)
        png_set_pHYs(png, info, (png_uint_32) (unit / aspect + 0.5),
                     (png_uint_32) unit, PNG_RESOLUTION_UNKNOWN);
    if (p->command) {
        set_text(png, info, "glarepp:version", GP_VERSION);
        set_text(png, info, "glarepp:command", p->command);
    }
    if (p->command && p->output)
        set_text(png, info, "glarepp:output", p->output);
    png_write_info(png, info);
    if (tags->cicp[0])
        png_write_chunk(png, (png_const_bytep) "cICP", tags->cicp,
                        sizeof tags->cicp);
    for (size_t at = 0, n; at < size; at += n) { // a chunk is under 2 GiB
        n = size - at < CHUNK_MOST ? size - at : CHUNK_MOST;
        png_write_chunk(png, (png_const_bytep) "IDAT", data + at, n);
    }
    png_write_chunk(png, (png_const_bytep) "IEND", NULL, 0);
    png_destroy_write_struct(&png, &info);
    return GP_OK;
}

gp_status gp_zlib_pack(const struct gp_log *log, const void *from, size_t n,
                       int level, void **out, size_t *size)
{
    struct libdeflate_compressor *const packer =
        libdeflate_alloc_compressor(level);
    gp_status st;
    *out = NULL;
    if (!packer)
        return gp_no_memory_bare(log, "compressor");
    const size_t room = libdeflate_zlib_compress_bound(packer, n);
    st = gp_alloc(log, "packed data", room, 1, out);
    if (!st)
        *size = libdeflate_zlib_compress(packer, from, n, *out, room);
    libdeflate_free_compressor(packer);
    return st;
}

gp_status gp_png_write(const struct gp_picture_job *j)
{
    gp_status st;
    const struct gp_log *const log = j->log;
    const struct gp_write_params *const p = j->p;
    struct gp_picture pic = {0};
    struct target t = {.log = log};
    void *rows = NULL, *data = NULL;
    size_t size = 0;
    const struct tags tags = tags_of(p, j->f, j->kind);
    GP_TRY(gp_picture_make(j, &pic));
    struct gp_picture_form samples = {
        .bytes = (size_t) pic.bits / 8,
        .big = true,
        .lead = 1,
        .finish = filter_row,
    };
    const size_t n =
        (size_t) pic.height *
        (1 + (size_t) pic.width * (size_t) pic.channels * samples.bytes);
    GP_TRY(gp_alloc(log, "PNG pixels", n, 1, &rows));
    samples.to = rows;
    GP_TRY(gp_picture_samples(log, &pic, &samples));
    GP_TRY(gp_zlib_pack(log, rows, n, p->png_level, &data, &size));
    GP_FREE(rows);
    GP_TRY(gp_file_open(log, j->path, p->create_dir, p->fsync, &t.file));
    GP_TRY(write_chunks(&t, &pic, j->f, &tags, p, data, size));
    GP_TRY(gp_file_commit(&t.file));
out:
    gp_file_discard(&t.file);
    gp_free(rows);
    gp_free(data);
    gp_picture_free(&pic);
    return st;
}
