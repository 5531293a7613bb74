// SPDX-License-Identifier: Apache-2.0
/* Every format over the hard cases: what is read back against what was to be
 * stored, windows and the rules for NaN, Inf and overflow included. EXR is read
 * by io's reader, what io writes else by plain readers, and other formats
 * through OpenImageIO. Lossy ones of these are compared with what it decodes of
 * a file that it made of the codes of a PNG: what io gave it was right when no
 * sample differs. */
#include "hardcases.h"
#include "hash.h"
#include "views.h"

#include "core/parallel.h"
#include "io/io_priv.h"
#include "io/oiio/oiio.h"
#include "io/read.h"

#include <float.h>
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <unistd.h>

// -- plain readers of the display formats, by their specifications ------------

/* w * h * 3 samples, R, G, B, rows from the top: codes of integer formats as
 * numbers, floats as they are. The caller frees `v`. */
struct picture {
    int w, h; // raw frames: given by the caller
    float *v;
};

enum form {
    EXR_FILE, // not read here
    PNG, HARD_PFM,
    HARD_RGB24, HARD_RGB48LE, HARD_RGB48BE, HARD_RGBF32LE, // raw frames
    // by OpenImageIO, whose fractions of the largest code become codes; a
    // fourth channel must be opaque
    HARD_OIIO_8, HARD_OIIO_16,
};

static void make_planes(struct picture *p)
{
    p->v = scene_alloc((size_t) p->w * (size_t) p->h, 3 * sizeof *p->v);
}

static void read_png(const char *path, struct picture *out)
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

static float float32le(const uint8_t *b)
{
    const uint32_t bits = (uint32_t) b[0] | (uint32_t) b[1] << 8 |
                          (uint32_t) b[2] << 16 | (uint32_t) b[3] << 24;
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static void read_raw(const char *path, enum form form,
                     struct picture *out)
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
static void read_pfm(const char *path, struct picture *out)
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

static void read_image(const char *path, float largest,
                       struct picture *out)
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

/* Ends the program when the file is not of its format. */
static void read_picture(const char *path, enum form form, struct picture *out)
{
    if (form == PNG)
        read_png(path, out);
    else if (form == HARD_PFM)
        read_pfm(path, out);
    else if (form == HARD_OIIO_8 || form == HARD_OIIO_16)
        read_image(path, form == HARD_OIIO_8 ? 255.0f : 65535.0f, out);
    else
        read_raw(path, form, out);
}

// -- what is stored -----------------------------------------------------------

/* A format's form of samples, and so the unit of its error. */
enum store {
    HALF_ULP, SAME_FLOAT, CODE, RADIANCE, OF_PXR24, OF_B44, OF_DWA, AS_ITSELF
};

struct format {
    const char *ending; // "": raw frames
    int column;
    struct gp_write_params p;
    enum store store;
    enum form form;
    int most; // a picture with a longer side must be refused; 0 none is
};

/* The formats of a family, and its columns. */
struct family {
    const char *title, *unit;
    const struct format *format;
    int formats;
    const struct hard_column *column;
};

// -- lossy EXR ----------------------------------------------------------------
//
// Limits of the change by EXR's compressions, from OpenEXR 3.1.5's encoders, and
// the error of what was read back, HARD_NO_BAR where a value is lost.

/* PXR24 keeps a float's sign, exponent and 15 of its 23 bits, rounded: of the
 * value, at most 2^-16. Below the normal range, of the least normal value. */
#define PXR24_BAR 0x1p-16

static double pxr24_error(float got, float from)
{
    if (isnan(from) || isinf(from))
        return (isnan(from) ? isnan(got) : got == from) ? 0.0 : HARD_NO_BAR;
    return fabs((double) got - (double) from) /
           fmax(fabs((double) from), (double) FLT_MIN);
}

/* B44 holds the 15 steps from value to value of a 4x4 block in 6 bits each,
 * of a size that doubles until they fit: half a step is at most 1/31 of the
 * range of the block, both counted in half's own codes. NaN and Inf become 0,
 * and values below -32752 that. */
#define B44_BAR (1.0 / 31.0)

/* The place of v's half in the order of all halfs, 0 being 0. */
static double half_code(float v)
{
    const double a = fmin(fabs((double) v), 65504.0);
    const int e = a > 0x1p-14 ? ilogb(a) : -14;
    const double code = nearbyint(ldexp(a, 10 - e)) + 1024.0 * (e + 14);
    return signbit(v) ? -1.0 - code : code;
}

/* The 4x4 block of channel c whose first pixel is `at`; blocks start anew with
 * each chunk of 32 lines, which is whole blocks. */
static double b44_block(const float *got, const float *from, int w, int h,
                        int x0, int y0)
{
    double least = HUGE_VAL, most = -HUGE_VAL, worst = 0.0;
    for (int i = 0; i < 16; i++) {
        const int x = x0 + i % 4, y = y0 + i / 4;
        if (x >= w || y >= h)
            continue;
        const size_t at = (size_t) y * (size_t) w + (size_t) x;
        const double code =
            isfinite(from[at]) ? half_code(fmaxf(from[at], -32752.0f)) : 0.0;
        least = fmin(least, code);
        most = fmax(most, code);
        worst = isfinite(got[at])
                    ? hard_worse(worst, fabs(half_code(got[at]) - code))
                    : HARD_NO_BAR;
    }
    return worst > 0.0 ? worst / (most - least) : 0.0;
}

static double b44_error(const struct gp_frame *got, const struct gp_frame *f)
{
    const int w = gp_rect_w(f->data), h = gp_rect_h(f->data);
    double worst = 0.0;
    for (int c = 0; c < 3; c++) {
        for (int y = 0; y < h; y += 4) {
            for (int x = 0; x < w; x += 4)
                worst = hard_worse(worst, b44_block(got->rgb.c[c], f->rgb.c[c],
                                                    w, h, x, y));
        }
    }
    return worst;
}

/* DWA bends values (power 1/2.2 up to 1, logarithm above), turns R, G, B into
 * Y, Cb, Cr, and lets the 64 terms of an 8x8 block's cosine transform move by
 * 4.5e-5 of JPEG's table (Cb, Cr: 2.6e-5 of theirs). A term reaches a sample by
 * 1/4 at most, and the tables add up to 3688 and 5505: 0.041 in Y, 0.036 in Cb,
 * with B = Y + 1.86 Cb 0.108, and up to 0.023 for terms held as half. In bent
 * values; NaN becomes 0, and values beyond 57344 that. */
#define DWA_BAR 0.131

static double bent(float v)
{
    const double a = fabs((double) v);
    return copysign(a <= 1.0 ? pow(a, 1.0 / 2.2) : log(a) / 2.2 + 1.0,
                    (double) v);
}

static double dwa_error(float got, float from)
{
    const float most = 57344.0f;
    const float v = isnan(from) ? 0.0f : fmaxf(fminf(from, most), -most);
    return isfinite(got) ? fabs(bent(got) - bent(v)) : HARD_NO_BAR;
}

// -- formats ------------------------------------------------------------------

static const struct format own_formats[] = {
#define AN_EXR(col, kind, how, held)                                          \
    {"exr", col, {.type = kind, .compression = GP_COMPRESSION_##how,         \
                   .depth_bits = 8},                                          \
     held, EXR_FILE, 0}
#define EXR(col, kind, how)                                                   \
    AN_EXR(col, kind, how, col == 0 ? HALF_ULP : SAME_FLOAT)
    EXR(0, GP_OUT_HALF, NONE), EXR(0, GP_OUT_HALF, RLE),
    EXR(0, GP_OUT_HALF, ZIPS), EXR(0, GP_OUT_HALF, ZIP),
    EXR(0, GP_OUT_HALF, PIZ), EXR(0, GP_OUT_HALF, PXR24),
    EXR(1, GP_OUT_FLOAT, NONE), EXR(1, GP_OUT_FLOAT, RLE),
    EXR(1, GP_OUT_FLOAT, ZIPS), EXR(1, GP_OUT_FLOAT, ZIP),
    EXR(1, GP_OUT_FLOAT, PIZ),
#undef EXR
    AN_EXR(10, GP_OUT_FLOAT, PXR24, OF_PXR24),
    AN_EXR(11, GP_OUT_HALF, B44, OF_B44),
    AN_EXR(11, GP_OUT_HALF, B44A, OF_B44),
    AN_EXR(12, GP_OUT_HALF, DWAA, OF_DWA),
    AN_EXR(12, GP_OUT_HALF, DWAB, OF_DWA),
#undef AN_EXR
#define OTHER(end, col, bits, how, by, ...)                                   \
    {end, col, {.compression = GP_COMPRESSION_AUTO, .depth_bits = bits,       \
                .dither = GP_DITHER_NEVER, __VA_ARGS__}, how, by, 0}
    OTHER("png", 2, 8, CODE, PNG, .type = GP_OUT_AUTO),
    OTHER("png", 3, 16, CODE, PNG, .type = GP_OUT_AUTO),
    OTHER("tif", 4, 16, CODE, HARD_OIIO_16, .type = GP_OUT_AUTO),
    OTHER("tif", 5, 16, SAME_FLOAT, HARD_OIIO_16, .type = GP_OUT_FLOAT),
    OTHER("pfm", 6, 8, SAME_FLOAT, HARD_PFM, .type = GP_OUT_AUTO),
#undef OTHER
#define RAW(col, bits, how, kind, by)                                         \
    {"", col, {.compression = GP_COMPRESSION_AUTO, .depth_bits = bits,        \
               .dither = GP_DITHER_NEVER, .stdout_format = GP_STDOUT_RAW,     \
               .raw = GP_RAW_##kind},                                         \
     how, by, 0}
    RAW(7, 8, CODE, RGB24, HARD_RGB24),
    RAW(8, 16, CODE, RGB48LE, HARD_RGB48LE),
    RAW(8, 16, CODE, RGB48BE, HARD_RGB48BE),
    RAW(9, 8, SAME_FLOAT, RGBF32LE, HARD_RGBF32LE),
#undef RAW
};
/* Half is rounded to the nearest; codes are found in float arithmetic. */
static const struct hard_column own_columns[] = {
    {"EXR half, ulp", 0.5}, {"EXR float, differing", 0},
    {"PNG 8, codes", 0.501}, {"PNG 16, codes", 0.51},
    {"TIFF 16, codes", 0.51}, {"TIFF float, differing", 0},
    {"PFM, differing", 0}, {"raw 8, codes", 0.501}, {"raw 16, codes", 0.51},
    {"raw float, differing", 0}, {"EXR PXR24 float, of it", PXR24_BAR},
    {"EXR B44, of its block", B44_BAR}, {"EXR DWA, bent", DWA_BAR},
    {NULL, 0},
};

static const struct family own = {
    "Files",
    "largest error of a sample read back, over all compressions and byte "
    "orders",
    own_formats, COUNT(own_formats), own_columns,
};

static const struct format other_formats[] = {
#define BY_OIIO(end, col, bits, how, by, most)                                \
    {end, col, {.compression = GP_COMPRESSION_AUTO, .depth_bits = bits,       \
                .dither = GP_DITHER_NEVER}, how, by, most}
    BY_OIIO("bmp", 0, 8, CODE, HARD_OIIO_8, 0),
    BY_OIIO("dpx", 1, 8, CODE, HARD_OIIO_8, 0),
    BY_OIIO("ppm", 2, 8, CODE, HARD_OIIO_8, 0),
    BY_OIIO("sgi", 3, 8, CODE, HARD_OIIO_8, 0),
    BY_OIIO("tga", 4, 8, CODE, HARD_OIIO_8, 0),
    BY_OIIO("dpx", 5, 16, CODE, HARD_OIIO_16, 0),
    BY_OIIO("sgi", 6, 16, CODE, HARD_OIIO_16, 0),
    BY_OIIO("hdr", 7, 8, RADIANCE, HARD_OIIO_16, 0),
    BY_OIIO("jpg", 8, 8, AS_ITSELF, HARD_OIIO_8, 0),
    BY_OIIO("webp", 9, 8, AS_ITSELF, HARD_OIIO_8, 16383),
#undef BY_OIIO
};

/* Of Radiance HDR half a step of the exponent that the largest component has,
 * which is at least 128 steps, or 255.5 of half as much where it was rounded
 * up. */
static const struct hard_column other_columns[] = {
    {"BMP, codes", 0.501}, {"DPX 8, codes", 0.501}, {"PPM, codes", 0.501},
    {"SGI 8, codes", 0.501}, {"TGA, codes", 0.501}, {"DPX 16, codes", 0.51},
    {"SGI 16, codes", 0.51}, {"HDR, of the pixel's largest", 1.0 / 255.5},
    {"JPEG, differing", 0}, {"WebP, differing", 0}, {NULL, 0},
};

static const struct family other = {
    "Files by OpenImageIO",
    "largest error of a sample read back; samples that differ from what it "
    "makes of PNG's codes",
    other_formats, COUNT(other_formats), other_columns,
};

// -- files --------------------------------------------------------------------

static char folder[40];

static void name_of(const char *stem, const struct format *t, char path[64])
{
    snprintf(path, 64, "%s/%s%s%s", folder, stem, t->ending[0] ? "." : "",
             t->ending);
}

/* Raw frames have no ending: they go to a file only by their own writer. */
static gp_status write_as(const struct format *t, const char *path,
                          const struct gp_frame *f)
{
    struct gp_write_stats stats = {0};
    return t->ending[0] ? gp_write_picture(&kept_log, &t->p, path, f, &f->rgb,
                                           GP_PICTURE_SHOWN, &stats)
                        : gp_raw_write(&(struct gp_picture_job) {
                              &kept_log, &t->p, path, f, &f->rgb,
                              GP_PICTURE_SHOWN, &stats});
}

/* The light of a row with its layer, as a file's frame; the caller frees it. */
static struct gp_frame filed(const struct hard_case *h)
{
    struct gp_image v = hard_lit(h);
    const struct gp_frame f = frame_of(&v, &v.lit);
    gp_planes_free(&v.rgb);
    return f;
}

// -- plain forms of what is stored --------------------------------------------

/* A copy of f's light, its pixels over `most` scaled to it. From malloc. */
static float *fitted(const struct gp_frame *f, float most)
{
    const size_t n = gp_frame_pixels(f);
    float *const v = malloc(3 * n * sizeof *v);
    if (!v)
        hard_die("light", "out of memory");
    for (size_t i = 0; i < n; i++) {
        double largest = 0.0;
        for (int c = 0; c < 3; c++) {
            v[(size_t) c * n + i] = f->rgb.c[c][i];
            if (isfinite(f->rgb.c[c][i]))
                largest = fmax(largest, (double) f->rgb.c[c][i]);
        }
        for (int c = 0; c < 3 && largest > (double) most; c++) {
            if (isfinite(f->rgb.c[c][i]))
                v[(size_t) c * n + i] *= (float) ((double) most / largest);
        }
    }
    return v;
}

/* Error in steps of a half there; finite values end at 65504. */
static double half_error(float got, float from)
{
    if (isnan(from) || isinf(from))
        return (isnan(from) ? isnan(got) : got == from) ? 0.0 : HARD_NO_BAR;
    const double v = fmax(fmin((double) from, 65504.0), -65504.0);
    const int exponent = v != 0.0 ? ilogb(v) : -14;
    const double ulp = ldexp(1.0, (exponent > -14 ? exponent : -14) - 10);
    return fabs((double) got - v) / ulp;
}

/* NaN must stay one, all else every bit; -0 counts as 0. */
static double float_error(float got, float from)
{
    return isnan(from) ? !isnan(got) : got != from;
}

/* IEC 61966-2-1, in double. */
static double srgb(double v)
{
    return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1.0 / 2.4) - 0.055;
}

/* Distance of a code of `bits` bits from that of a sample. */
static double code_error(double got, float from, int bits)
{
    const double max = (1 << bits) - 1;
    const double v = fmin(fmax((double) from, 0.0), 1.0); // NaN: 0
    return fabs(got - srgb(v) * max);
}

/* The sample of f.rgb at a place, 0 outside the data window. */
static float lit_at(const struct gp_frame *f, int c, int x, int y)
{
    const struct gp_rect d = f->data;
    return gp_planes_at(&f->rgb, c, gp_rect_w(d), gp_rect_h(d), x - d.x0,
                        y - d.y0);
}

static double sample_error(const struct format *t, float got, float from)
{
    return t->store == HALF_ULP   ? half_error(got, from)
           : t->store == OF_PXR24 ? pxr24_error(got, from)
           : t->store == OF_DWA   ? dwa_error(got, from)
           : t->store == CODE ? code_error((double) got, from, t->p.depth_bits)
                              : float_error(got, from);
}

/* The format holds no sign, no NaN, and up to 255 * 2^119; OpenImageIO's writer
 * nothing of a pixel under 1e-32. */
static double radiance_error(const float *got, const float *from)
{
    double want[3], most = 0.0, worst = 0.0;
    for (int c = 0; c < 3; c++) {
        want[c] = fmin(fmax((double) from[c], 0.0), 255.0 * 0x1p119);
        most = fmax(most, want[c]);
    }
    for (int c = 0; c < 3; c++)
        worst = hard_worse(worst, most < 1e-32
                                      ? (got[c] != 0.0f ? HARD_NO_BAR : 0.0)
                                      : fabs((double) got[c] - want[c]) / most);
    return worst;
}

/* EXR keeps the data window, and both windows as they are. */
static double exr_error(const struct format *t, const char *path,
                        const struct gp_frame *from)
{
    const struct gp_read_params limits = GP_READ_DEFAULTS;
    const bool dwa = t->p.compression >= GP_COMPRESSION_DWAA;
    const size_t pixels = gp_frame_pixels(from);
    float *const light = fitted(from, dwa ? 57344.0f
                                      : t->p.type == GP_OUT_HALF ? 65504.0f
                                                                 : FLT_MAX);
    struct gp_frame got, fit = *from, *const f = &fit;
    for (size_t c = 0; c < 3; c++)
        fit.rgb.c[c] = light + c * pixels;
    double worst = 0.0;
    if (gp_read_frame(&kept_log, &limits, path, &got))
        hard_die(path, kept_line);
    if (memcmp(&got.data, &f->data, sizeof f->data) != 0 ||
        memcmp(&got.display, &f->display, sizeof f->display) != 0 ||
        got.colour_type != (t->p.type == GP_OUT_HALF ? GP_HALF : GP_FLOAT))
        worst = HARD_NO_BAR;
    else if (t->store == OF_B44)
        worst = b44_error(&got, f);
    const size_t n = gp_frame_pixels(f);
    for (size_t i = 0; t->store != OF_B44 && worst < HARD_NO_BAR && i < 3 * n;
         i++)
        worst = hard_worse(worst, sample_error(t, got.rgb.c[i / n][i % n],
                                               f->rgb.c[i / n][i % n]));
    free(light);
    gp_frame_free(&got);
    return worst;
}

/* Samples that differ from what OpenImageIO makes of PNG's codes. */
static double differing(const struct format *t, const struct picture *got,
                        const struct gp_frame *f)
{
    static const struct format png = {
        .ending = "png", .p = {.compression = GP_COMPRESSION_AUTO,
                               .depth_bits = 8, .dither = GP_DITHER_NEVER},
    };
    static const char *const names[] = {"R", "G", "B"};
    const struct gp_read_params limits = GP_READ_DEFAULTS;
    struct picture codes = {0};
    struct gp_shared pixels;
    struct gp_stream file;
    struct gp_decoded back;
    char path[64];
    name_of("codes", &png, path);
    if (write_as(&png, path, f))
        hard_die(path, kept_line);
    read_picture(path, PNG, &codes);
    unlink(path);
    const struct gp_decoded img = {
        .path = t->ending, .data = {0, 0, codes.w, codes.h},
        .display = {0, 0, codes.w, codes.h}, .channels = 3,
        .channel_name = names, .colour_space = "sRGB",
    };
    const size_t n = 3 * (size_t) codes.w * (size_t) codes.h;
    if (gp_shared_make(&kept_log, t->ending, n * sizeof(float), &pixels))
        hard_die(t->ending, kept_line);
    for (size_t i = 0; i < n; i++)
        ((float *) pixels.at)[i] = codes.v[i] / 255.0f;
    if (gp_oiio_write(&kept_log, &img, NULL, &pixels, t->ending, "uint8", "",
                      &file) ||
        gp_read_image(&kept_log, &limits, t->ending, &file, 0, &back))
        hard_die(t->ending, kept_line);
    double differ = gp_rect_w(back.data) == got->w &&
                    gp_rect_h(back.data) == got->h ? 0.0 : HARD_NO_BAR;
    for (size_t i = 0; differ < HARD_NO_BAR && i < n; i++)
        differ += got->v[i] != rintf(255.0f *
            back.pixels[i / 3 * (size_t) back.channels + i % 3]);
    gp_decoded_close(&back);
    gp_stream_close(&file);
    gp_shared_free(&pixels);
    free(codes.v);
    return differ;
}

/* All others show the display window. */
static double picture_error(const struct format *t, const char *path,
                            const struct gp_frame *f)
{
    const struct gp_rect d = f->display;
    // raw frames do not say their size
    struct picture got = {gp_rect_w(d), gp_rect_h(d), NULL};
    read_picture(path, t->form, &got);
    double worst = 0.0;
    if (got.w != gp_rect_w(d) || got.h != gp_rect_h(d))
        worst = HARD_NO_BAR;
    else if (t->store == AS_ITSELF)
        worst = differing(t, &got, f);
    for (int i = 0; worst < HARD_NO_BAR && t->store != AS_ITSELF &&
                    i < got.w * got.h; i++) {
        const float *const v = &got.v[3 * (size_t) i];
        float from[3];
        for (int c = 0; c < 3; c++)
            from[c] = lit_at(f, c, d.x0 + i % got.w, d.y0 + i / got.w);
        if (t->store == RADIANCE)
            worst = hard_worse(worst, radiance_error(v, from));
        for (int c = 0; c < 3 && t->store != RADIANCE; c++)
            worst = hard_worse(worst, sample_error(t, v[c], from[c]));
    }
    free(got.v);
    return worst;
}

// -- tables -------------------------------------------------------------------

static bool is_too_large(const struct format *t, const struct gp_frame *f)
{
    return t->most && (gp_rect_w(f->display) > t->most ||
                       gp_rect_h(f->display) > t->most);
}

/* Refused by a line about that file, with nothing under its name. */
static bool is_refusal(gp_status st, const char *path)
{
    return st == GP_ERR_IO && strstr(kept_line, path) &&
           strstr(kept_line, "cannot be written") &&
           access(path, F_OK) != 0;
}

static void print_row(const struct family *family, const struct hard_case *h)
{
    double error[16] = {0};
    bool refused[16] = {false};
    struct gp_frame f = filed(h);
    for (int i = 0; i < family->formats; i++) {
        const struct format *const t = &family->format[i];
        const bool large = is_too_large(t, &f);
        char path[64];
        name_of("out", t, path);
        const gp_status st = write_as(t, path, &f);
        refused[t->column] |= large && is_refusal(st, path);
        if (st && !refused[t->column])
            hard_die(path, kept_line);
        if (!st)
            error[t->column] = hard_worse(
                error[t->column], large ? HARD_NO_BAR
                : t->form == EXR_FILE   ? exr_error(t, path, &f)
                                        : picture_error(t, path, &f));
        unlink(path);
    }
    hard_row(h->name);
    for (int i = 0; family->column[i].name; i++) {
        if (refused[i])
            hard_refused();
        else
            hard_cell(error[i], family->column[i].bar);
    }
    gp_frame_free(&f);
}

static uint64_t hash_of(const struct format *t, int threads,
                        const struct gp_frame *f)
{
    char path[64];
    size_t size;
    name_of("out", t, path);
    gp_set_threads(threads);
    if (write_as(t, path, f))
        hard_die(path, kept_line);
    gp_set_threads(0);
    uint8_t *const bytes = hard_read_bytes(path, &size);
    const uint64_t hash = hash_more(HASH_NONE, bytes, size);
    free(bytes);
    unlink(path);
    return hash;
}

static const struct family *shown; // whose tables are printed

/* Files of a row that differ from those of one thread, by column. */
static void count_differing(int row, int threads, double *differ)
{
    struct gp_frame f = filed(&hard_cases[row]);
    for (int i = 0; i < shown->formats; i++) {
        const struct format *const t = &shown->format[i];
        if (!is_too_large(t, &f))
            differ[t->column] += hash_of(t, 1, &f) != hash_of(t, threads, &f);
    }
    gp_frame_free(&f);
}

static void print_family(const struct family *family)
{
    char title[64];
    strcpy(folder, "/tmp/glarepp-hard-XXXXXX");
    if (!mkdtemp(folder))
        hard_die(folder, "cannot be made");
    hard_table(family->title, family->unit, family->column);
    for (int row = 0; row < HARD_CASES; row++) {
        if (hard_is_run(&hard_cases[row]))
            print_row(family, &hard_cases[row]);
    }
    hard_table_end();
    shown = family;
    snprintf(title, sizeof title, "%s, the same bytes", family->title);
    hard_thread_table(title, "files that differ from those of one thread",
                      family->column, HARD_CASES, hard_is_threaded,
                      count_differing);
    if (rmdir(folder))
        hard_die(folder, "something is left in it");
}

void hard_files(void)
{
    print_family(&own);
}

void hard_other_files(void)
{
    print_family(&other);
}
