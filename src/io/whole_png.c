#include "io/whole_png.h"

#include "core/memory.h"

#include <errno.h>
#include <png.h>
#include <string.h>

/* What libpng may take in all: three rows of its widest picture, texts and
 * profiles, and copies of what is in the file. It bounds each chunk that it
 * unpacks, but lets there be a thousand, and takes a length's word for it. */
enum { MOST_BYTES = 48 << 20, COPIES = 4 };

/* Pixels a side that libpng, and OpenImageIO with it, reads by default. */
enum { WIDEST = 1000000 };

/* What libpng's callbacks see. */
struct source {
    const struct gp_log *log;
    const char *path;
    const struct gp_stream *s;
    uint64_t at;
    void *row;
    size_t taken;  // bytes, with those given back
    gp_status st;  // its line is said
};

static void read_bytes(png_structp png, png_bytep to, size_t n)
{
    struct source *s = png_get_io_ptr(png);
    const int64_t got = gp_stream_read(s->s, to, n, s->at);
    if (got < 0)
        s->st = gp_fail(s->log, GP_ERR_IO,
                        "%s: cannot be read (%s); check the disk", s->path,
                        strerror(errno));
    if (got != (int64_t) n)
        png_error(png, "the file ends too early");
    s->at += n;
}

static void on_error(png_structp png, png_const_charp message)
{
    struct source *s = png_get_error_ptr(png);
    if (!s->st && strstr(message, "ut of memory"))
        s->st = gp_fail(s->log, GP_ERR_BUG,
                        "%s: out of memory (%s); close other programs",
                        s->path, message);
    else if (!s->st)
        s->st = gp_fail(s->log, GP_ERR_DATA,
                        "%s: damaged (%s); copy or render the file again",
                        s->path, message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void) png;
    (void) message;
}

static void *take_memory(png_structp png, png_alloc_size_t bytes)
{
    struct source *s = png_get_mem_ptr(png);
    void *p = NULL;
    const uint64_t most = MOST_BYTES + COPIES * s->s->size;
    if (!s->st && bytes > most - s->taken)
        s->st = gp_fail(s->log, GP_ERR_DATA,
                        "%s: damaged (its chunks are said to be, or unpack "
                        "to, over %llu bytes); render the file again",
                        s->path, (unsigned long long) most);
    s->taken += s->st ? 0 : bytes;
    if (!s->st)
        s->st = gp_alloc(s->log, s->path, bytes, 1, &p);
    return p;
}

static void give_memory(png_structp png, void *p)
{
    (void) png;
    gp_free(p);
}

/* Header, every row of every pass, then the chunks to the last; those that
 * are no pixels must be whole too. May leave by longjmp(). */
static void decode(png_structp png, png_infop info, struct source *s,
                   long long max_pixels)
{
    png_set_read_fn(png, s, read_bytes);
    // (sizes over the library's usual limit are ours to speak of)
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    png_read_info(png, info);
    const png_uint_32 w = png_get_image_width(png, info);
    const png_uint_32 h = png_get_image_height(png, info);
    if ((long long) w * h > max_pixels) {
        s->st = gp_fail(s->log, GP_ERR_DATA,
                        "%s: too large (%lu x %lu pixels, at most %lld); crop "
                        "it, or raise --max-pixels", s->path,
                        (unsigned long) w, (unsigned long) h, max_pixels);
        return;
    }
    if (w > WIDEST || h > WIDEST) {
        s->st = gp_fail(s->log, GP_ERR_DATA,
                        "%s: too large (%lu x %lu pixels; a PNG is read up to "
                        "%d a side); cut it, or write another format",
                        s->path, (unsigned long) w, (unsigned long) h, WIDEST);
        return;
    }
    const int passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    s->row = png_malloc(png, png_get_rowbytes(png, info));
    for (int pass = 0; pass < passes; pass++) {
        for (png_uint_32 y = 0; y < h; y++)
            png_read_row(png, s->row, NULL);
    }
    png_read_end(png, NULL);
}

/* Nothing here is changed between setjmp() and longjmp() but what the pointers
 * lead to. */
gp_status gp_whole_png(const struct gp_log *log, const char *path,
                       const struct gp_stream *stream, long long max_pixels)
{
    struct source s = {.log = log, .path = path, .s = stream};
    png_infop info = NULL;
    png_structp png = png_create_read_struct_2(
        PNG_LIBPNG_VER_STRING, &s, on_error, on_warning, &s, take_memory,
        give_memory);
    if (png)
        info = png_create_info_struct(png);
    if (info && !setjmp(png_jmpbuf(png)))
        decode(png, info, &s, max_pixels);
    else if (!s.st)
        s.st = gp_fail(log, GP_ERR_BUG,
                       "%s: out of memory (libpng); close other programs",
                       path);
    gp_free(s.row);
    png_destroy_read_struct(&png, &info, NULL);
    return s.st;
}
