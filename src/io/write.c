// SPDX-License-Identifier: Apache-2.0
#include "io/write.h"

#include "io/exr/exr.h"
#include "io/file.h"
#include "io/io_priv.h"
#include "io/oiio/oiio.h"
#include "io/read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// -- formats ------------------------------------------------------------------

static gp_picture_writer write_by_helper;

/* The endings that are written, what their formats hold, and how their readers
 * take a fourth channel: BLACK where there is none. Raw frames go to streams
 * only: files called .raw are cameras'. Of OpenImageIO 2.4's other writers RLA
 * loses samples, FITS writes its rows one too high, IFF 1x1 as black, GIF is
 * not the same from run to run, HEIF's reads past the end of its rows, icons
 * are not read back. BMP's fourth byte has no meaning by its header (BI_RGB):
 * readers either ignore it or take it as it is, so the colours are those over
 * black. */
static const struct format {
    const char *ending[7]; // NULL ends
    gp_picture_writer *write;
    int bits;      // most bits of an integer sample; 0 holds none
    bool floats;
    enum gp_alpha alpha;
} formats[] = {
    {{"exr"}, gp_exr_write_picture, 0, true, GP_ALPHA_KEEP},
    {{"png"}, gp_png_write, 16, false, GP_ALPHA_KEEP},
    {{"pfm"}, gp_pfm_write, 0, true, GP_ALPHA_BLACK},
    {{"raw"}, gp_raw_write, 16, true, GP_ALPHA_BLACK},
    {{"hdr", "rgbe"}, write_by_helper, 0, true, GP_ALPHA_BLACK},
    {{"tif", "tiff"}, write_by_helper, 16, true, GP_ALPHA_KEEP},
    {{"tx"}, write_by_helper, 8, false, GP_ALPHA_KEEP},
    {{"dpx"}, write_by_helper, 16, false, GP_ALPHA_ASSOCIATED},
    {{"tga", "tpic"}, write_by_helper, 8, false, GP_ALPHA_KEEP},
    {{"webp"}, write_by_helper, 8, false, GP_ALPHA_KEEP},
    {{"jpg", "jpeg", "jpe", "jfif", "jif", "jfi"}, write_by_helper, 8, false,
     GP_ALPHA_BLACK},
    {{"bmp", "dib"}, write_by_helper, 8, false, GP_ALPHA_ASSOCIATED},
    {{"ppm", "pgm", "pbm", "pnm"}, write_by_helper, 8, false, GP_ALPHA_BLACK},
    {{"sgi"}, write_by_helper, 16, false, GP_ALPHA_ASSOCIATED},
    {{"rgb", "rgba", "bw", "int", "inta"}, write_by_helper, 8, false,
     GP_ALPHA_ASSOCIATED},
};

enum { ENDING_BYTES = 16 };

/* The format and form in which a path is written. */
struct target {
    const struct format *format; // NULL: none
    char ending[ENDING_BYTES];
    bool straight; // stdout, a pipe or a device without an ending of its own
};

/* Finds the format by the ending, of straight targets by --stdout-format. */
static struct target target_of(const struct gp_write_params *p,
                               const char *path)
{
    static const char *const of_stdout[] = {
#define X(name, ending, text) ending,
        GP_STDOUT_LIST(X)
#undef X
    };
    struct target t = {.format = NULL};
    gp_file_ending(path, t.ending, ENDING_BYTES);
    t.straight = !t.ending[0] && gp_file_is_straight(path);
    if (t.straight)
        strcpy(t.ending, of_stdout[p->stdout_format]);
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++) {
        const struct format *const f = &formats[i];
        for (int k = 0; f->ending[k]; k++) {
            if (strcmp(f->ending[k], t.ending) == 0 &&
                (f->write != gp_raw_write || t.straight))
                t.format = f;
        }
    }
    return t;
}

static bool is_tiff(const struct format *t)
{
    return t->floats && t->bits > 0;
}

/* OpenImageIO's name of a compression that TIFF has as well, else NULL. */
static const char *tiff_compression(enum gp_compression c)
{
    static const char *const names[] = {"", "none", "packbits", "zip", "zip"};
    const int i = c - GP_COMPRESSION_AUTO;
    return i <= GP_COMPRESSION_ZIP - GP_COMPRESSION_AUTO ? names[i] : NULL;
}

/* Checks that the format takes these params. */
static gp_status check_format(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const struct target *to)
{
    const struct format *const t = to->format;
    const char *const ending = to->ending;
    char list[256] = "";
    if (!t) {
        size_t n = 0;
        for (size_t i = 0; i < sizeof formats / sizeof *formats; i++) {
            if (formats[i].write != gp_raw_write)
                n += (size_t) snprintf(list + n, sizeof list - n, "%s.%s",
                                       n ? ", " : "", formats[i].ending[0]);
        }
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: unknown format (ending %s%s); end the name in one "
                       "of %s", path, ending[0] ? "." : "is missing", ending,
                       list);
    }
    // DWA is packed by OpenImageIO
    if (t->write != write_by_helper)
        return t->write == gp_exr_write_picture &&
               p->compression >= GP_COMPRESSION_DWAA ? gp_oiio_check(log, path)
                                                     : GP_OK;
    if (is_tiff(t) && !tiff_compression(p->compression))
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: TIFF has no such compression; use none, rle or "
                       "zip", path);
    if (t->bits > 0 && p->depth_bits > t->bits)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: .%s holds %d bits (--depth-bits %d); use .png, "
                       ".tif or .exr", path, ending, t->bits, p->depth_bits);
    return gp_oiio_check(log, path);
}

// -- pictures by OpenImageIO --------------------------------------------------

/* The nearest that Radiance's pixel holds: three mantissas of 8 bits and the
 * exponent of the largest (G. Ward, "Real Pixels", Graphics Gems II, 1991).
 * OpenImageIO cuts mantissas off and turns negative ones into others, and
 * takes all of a pixel under 1e-32 for 0; it leaves these values as they are.
 * NaN and negative values become 0, those beyond the format its largest. */
static void round_pixel(float *v)
{
    const float largest = 255.0f * 0x1p119f;
    float most = 0.0f;
    int exponent;
    for (int c = 0; c < 3; c++) {
        v[c] = v[c] > 0.0f ? fminf(v[c], largest) : 0.0f;
        most = fmaxf(most, v[c]);
    }
    (void) frexpf(fmaxf(most, 1e-32f), &exponent);
    float step = ldexpf(1.0f, exponent - 8);
    if (rintf(most / step) > 255.0f)
        step *= 2.0f;
    for (int c = 0; c < 3; c++)
        v[c] = rintf(v[c] / step) * step;
}

static void round_radiance(const struct gp_picture *pic, uint8_t *row)
{
    for (int x = 0; x < pic->width; x++)
        round_pixel((float *) (void *) row + 3 * x);
}

static gp_status write_by_helper(const struct gp_picture_job *j)
{
    static const char *const names[] = {"R", "G", "B", "A"};
    gp_status st;
    const struct gp_log *const log = j->log;
    const struct target target = target_of(j->p, j->path);
    const struct format *const t = target.format;
    struct gp_write_params own = *j->p;
    struct gp_picture_job job = *j;
    struct gp_picture pic = {0};
    struct gp_shared pixels = {0};
    struct gp_stream s = GP_STREAM_EMPTY;
    if (own.alpha != GP_ALPHA_BLACK)
        own.alpha = t->alpha;
    // integers where the format has nothing else, or nothing says otherwise
    const bool scene = j->kind == GP_PICTURE_SCENE;
    const bool integer =
        is_tiff(t) ? own.type == GP_OUT_AUTO && !scene : !t->floats;
    job.p = &own;
    GP_TRY(gp_picture_make(&job, &pic));
    const size_t n = (size_t) pic.width * (size_t) pic.height *
                     (size_t) pic.channels;
    GP_TRY(gp_shared_make(log, j->path, n * sizeof(float), &pixels));
    const struct gp_picture_form samples = {
        .bytes = sizeof(float),
        .fractions = integer,
        .to = pixels.at,
        .finish = t->floats && t->bits == 0 ? round_radiance : NULL,
    };
    GP_TRY(gp_picture_samples(log, &pic, &samples));
    const struct gp_decoded image = {
        .path = gp_is_dash(j->path) ? "stdout" : j->path,
        .data = {0, 0, pic.width, pic.height},
        .display = {0, 0, pic.width, pic.height},
        .channels = pic.channels,
        .channel_name = names,
        .chromaticities = scene ? pic.f->chromaticities : NULL,
        .colour_space = j->kind == GP_PICTURE_ENCODED ? ""
                        : integer                     ? "sRGB"
                                                      : "Linear",
    };
    const char *type = own.type == GP_OUT_HALF ? "half" : "float";
    if (integer)
        type = own.depth_bits == 16 ? "uint16" : "uint8";
    GP_TRY(gp_oiio_write(log, &image, NULL, &pixels, target.ending, type,
                         is_tiff(t) ? tiff_compression(own.compression) : "",
                         &s));
    st = gp_file_save(log, j->path, own.create_dir, own.fsync, s.data, s.size);
out:
    gp_stream_close(&s);
    gp_shared_free(&pixels);
    gp_picture_free(&pic);
    return st;
}

// -- any format ---------------------------------------------------------------

bool gp_write_has_alpha(const struct gp_write_params *p, const char *path)
{
    const struct format *const t = target_of(p, path).format;
    return t && t->alpha != GP_ALPHA_BLACK;
}

bool gp_write_has_floats(const struct gp_write_params *p, const char *path,
                         enum gp_pixel_type own)
{
    const struct format *const t = target_of(p, path).format;
    const bool asked =
        p->type == GP_OUT_FLOAT || (p->type == GP_OUT_AUTO && own == GP_FLOAT);
    if (!t || t->write == gp_exr_write_picture)
        return asked;
    return t->write == gp_pfm_write || is_tiff(t) ||
           (t->write == gp_raw_write && p->raw == GP_RAW_RGBF32LE);
}

gp_status gp_write_hdr_check(const struct gp_log *log,
    const struct gp_write_params *p, const char *keeps, const char *path)
{
    const struct target t = target_of(p, path);
    const char *const ending = t.ending;
    if (t.straight && strcmp(ending, "exr") != 0)
        return gp_fail(log, GP_ERR_USAGE,
            "%s: %s, which only EXR can (found --stdout-format %s); give it a "
            "file", path, keeps, ending);
    if (strcmp(ending, "exr") != 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: %s, which only EXR can (ending %s); end the name "
                       "in .exr", path, keeps, ending[0] ? ending : "missing");
    return gp_write_check(log, p, path);
}

bool gp_write_kept(const struct gp_log *log, const struct gp_write_params *p,
                   const char *path)
{
    if (!p->no_clobber || gp_is_dash(path) || !gp_file_exists(path))
        return false;
    if (gp_read_has_end(path))
        return true;
    gp_say(log, GP_LEVEL_WARN,
           "--no-clobber: %s is empty or cut off and is made again", path);
    return false;
}

gp_status gp_write_check(const struct gp_log *log,
                         const struct gp_write_params *p, const char *path)
{
    const struct target t = target_of(p, path);
    const gp_status st = p->pages && strcmp(t.ending, "html") == 0
                             ? GP_OK
                             : check_format(log, p, path, &t);
    return st ? st : gp_file_check(log, path, p->create_dir);
}

gp_status gp_write_picture(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const struct gp_frame *f,
    const struct gp_planes *planes, enum gp_picture_kind kind,
    struct gp_write_stats *stats)
{
    const struct gp_picture_job job = {log, p, path, f, planes, kind, stats};
    const struct target t = target_of(p, path);
    const gp_status st = check_format(log, p, path, &t);
    return st ? st : t.format->write(&job);
}
