#include "files.h"
#include "hardcases.h"

#include "io/read.h"

#include <png.h>

uint8_t *hard_read_bytes(const char *path, size_t *size)
{
    FILE *const f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END))
        hard_die(path, "cannot be read");
    *size = (size_t) ftell(f);
    rewind(f);
    uint8_t *const bytes = scene_alloc(*size + 1, 1);
    if (fread(bytes, 1, *size, f) != *size)
        hard_die(path, "cannot be read");
    fclose(f);
    return bytes;
}

static void make_planes(struct hard_picture *p)
{
    p->v = scene_alloc((size_t) p->w * (size_t) p->h, 3 * sizeof *p->v);
}

// -- PNG ----------------------------------------------------------------------

static void read_png(const char *path, struct hard_picture *out)
{
    FILE *const f = fopen(path, "rb");
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL,
                                             NULL);
    png_infop info = png_create_info_struct(png);
    if (!f || !info)
        hard_die(path, "cannot be read");
    png_init_io(png, f);
    png_read_png(png, info, PNG_TRANSFORM_IDENTITY, NULL); // aborts if bad
    const int bytes = png_get_bit_depth(png, info) / 8;
    out->w = (int) png_get_image_width(png, info);
    out->h = (int) png_get_image_height(png, info);
    if (png_get_channels(png, info) != 3)
        hard_die(path, "is not RGB");
    make_planes(out);
    float *to = out->v;
    for (int y = 0; y < out->h; y++) {
        const png_byte *row = png_get_rows(png, info)[y];
        for (int i = 0; i < 3 * out->w; i++, row += bytes)
            *to++ = (float) (bytes == 1 ? row[0] : row[0] << 8 | row[1]);
    }
    png_destroy_read_struct(&png, &info, NULL);
    fclose(f);
}

// -- raw frames and PFM -------------------------------------------------------

static float float32le(const uint8_t *b)
{
    const uint32_t bits = (uint32_t) b[0] | (uint32_t) b[1] << 8 |
                          (uint32_t) b[2] << 16 | (uint32_t) b[3] << 24;
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static void read_raw(const char *path, enum hard_form form,
                     struct hard_picture *out)
{
    const size_t bytes = form == HARD_RGB24      ? 1
                         : form == HARD_RGBF32LE ? 4 : 2;
    size_t size;
    uint8_t *const all = hard_read_bytes(path, &size);
    const size_t n = 3 * (size_t) out->w * (size_t) out->h;
    if (size != n * bytes)
        hard_die(path, "has another size than its frame");
    make_planes(out);
    for (size_t i = 0; i < n; i++) {
        const uint8_t *const b = all + i * bytes;
        out->v[i] = form == HARD_RGB24     ? (float) b[0]
                    : form == HARD_RGB48LE ? (float) (b[0] | b[1] << 8)
                    : form == HARD_RGB48BE ? (float) (b[0] << 8 | b[1])
                                           : float32le(b);
    }
    free(all);
}

/* Rows from the bottom, after three lines. */
static void read_pfm(const char *path, struct hard_picture *out)
{
    size_t size;
    int head = 0;
    uint8_t *const all = hard_read_bytes(path, &size);
    if (sscanf((const char *) all, "PF\n%d %d\n-1.0%n", &out->w, &out->h,
               &head) != 2 || !head)
        hard_die(path, "is no PFM");
    const size_t row = 3 * (size_t) out->w;
    if (size != (size_t) head + 1 + 4 * row * (size_t) out->h)
        hard_die(path, "has another size than its header says");
    make_planes(out);
    for (size_t i = 0; i < row * (size_t) out->h; i++) {
        const size_t y = (size_t) out->h - 1 - i / row;
        out->v[y * row + i % row] = float32le(all + head + 1 + 4 * i);
    }
    free(all);
}

// -- by OpenImageIO -----------------------------------------------------------

static void read_image(const char *path, float largest,
                       struct hard_picture *out)
{
    const struct gp_read_params limits = GP_READ_DEFAULTS;
    struct gp_stored_file file;
    struct gp_stored_image image;
    if (gp_stored_open(&kept_log, &limits, path, &file) ||
        gp_stored_read(&kept_log, &limits, &file, 0, &image))
        hard_die(path, kept_line);
    if (image.channels < 3 || image.channels > 4)
        hard_die(path, "is not RGB");
    out->w = gp_rect_w(image.data);
    out->h = gp_rect_h(image.data);
    make_planes(out);
    for (size_t i = 0; i < 3 * (size_t) out->w * (size_t) out->h; i++) {
        const float v = ((const float *) image.channel[i % 3].v)[i / 3];
        out->v[i] = image.integers ? rintf(v * largest) : v;
        if (image.channels == 4 &&
            ((const float *) image.channel[3].v)[i / 3] != 1.0f)
            hard_die(path, "is not opaque");
    }
    gp_stored_image_free(&image);
    gp_stored_close(&file);
}

void hard_read(const char *path, enum hard_form form, struct hard_picture *out)
{
    if (form == HARD_PNG)
        read_png(path, out);
    else if (form == HARD_PFM)
        read_pfm(path, out);
    else if (form == HARD_OIIO_8 || form == HARD_OIIO_16)
        read_image(path, form == HARD_OIIO_8 ? 255.0f : 65535.0f, out);
    else
        read_raw(path, form, out);
}
