/* Pictures in the formats that OpenImageIO writes. */
#include "io/oiio/oiio.h"

#include "core/memory.h"
#include "io/file.h"
#include "io/picture.h"

#include <errno.h>
#include <math.h>
#include <string.h>

/* The types that a format holds, and how its readers take a fourth channel:
 * BLACK where there is none. Of 2.4's other writers RLA loses samples, FITS
 * writes its rows one too high, IFF 1x1 as black, GIF is not the same from run
 * to run, HEIF's reads past the end of its rows, icons are not read back. BMP's
 * fourth byte has no meaning by its header (BI_RGB), so that readers either
 * ignore it or take it as it is: the colours are those over black. */
static const struct format {
    const char *ending;
    int bits;      // most bits of an integer sample; 0 holds none
    bool floats;
    enum gp_alpha alpha;
    bool again;    // another ending of the format above
} formats[] = {
    {"hdr", 0, true, GP_ALPHA_BLACK, false},
    {"rgbe", 0, true, GP_ALPHA_BLACK, true},
    {"tif", 16, true, GP_ALPHA_KEEP, false},
    {"tiff", 16, true, GP_ALPHA_KEEP, true},
    {"tx", 8, false, GP_ALPHA_KEEP, true},
    {"dpx", 16, false, GP_ALPHA_ASSOCIATED, false},
    {"tga", 8, false, GP_ALPHA_KEEP, false},
    {"tpic", 8, false, GP_ALPHA_KEEP, true},
    {"webp", 8, false, GP_ALPHA_KEEP, false},
    {"jpg", 8, false, GP_ALPHA_BLACK, false},
    {"jpeg", 8, false, GP_ALPHA_BLACK, true},
    {"jpe", 8, false, GP_ALPHA_BLACK, true},
    {"jfif", 8, false, GP_ALPHA_BLACK, true},
    {"jif", 8, false, GP_ALPHA_BLACK, true},
    {"jfi", 8, false, GP_ALPHA_BLACK, true},
    {"bmp", 8, false, GP_ALPHA_ASSOCIATED, false},
    {"dib", 8, false, GP_ALPHA_ASSOCIATED, true},
    {"ppm", 8, false, GP_ALPHA_BLACK, false},
    {"pgm", 8, false, GP_ALPHA_BLACK, true},
    {"pbm", 8, false, GP_ALPHA_BLACK, true},
    {"pnm", 8, false, GP_ALPHA_BLACK, true},
    {"sgi", 16, false, GP_ALPHA_ASSOCIATED, false},
    {"rgb", 8, false, GP_ALPHA_ASSOCIATED, true},
    {"rgba", 8, false, GP_ALPHA_ASSOCIATED, true},
    {"bw", 8, false, GP_ALPHA_ASSOCIATED, true},
    {"int", 8, false, GP_ALPHA_ASSOCIATED, true},
    {"inta", 8, false, GP_ALPHA_ASSOCIATED, true},
};

static const struct format *find_format(const char *ending)
{
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++) {
        if (strcmp(formats[i].ending, ending) == 0)
            return &formats[i];
    }
    return NULL;
}

bool gp_oiio_writes(const char *ending)
{
    return find_format(ending) != NULL;
}

const char *gp_oiio_ending(int i)
{
    for (size_t k = 0; k < sizeof formats / sizeof *formats; k++) {
        if (!formats[k].again && i-- == 0)
            return formats[k].ending;
    }
    return NULL;
}

bool gp_oiio_has_alpha(const char *ending)
{
    const struct format *const t = find_format(ending);
    return t && t->alpha != GP_ALPHA_BLACK;
}

static bool is_tiff(const struct format *t)
{
    return t->floats && t->bits > 0;
}

/* OpenImageIO's names of the compressions that TIFF has as well; NULL for
 * those that it has not. */
static const char *tiff_compression(enum gp_compression c)
{
    switch (c) {
    case GP_COMPRESSION_AUTO:
        return "";
    case GP_COMPRESSION_NONE:
        return "none";
    case GP_COMPRESSION_RLE:
        return "packbits";
    case GP_COMPRESSION_ZIPS:
    case GP_COMPRESSION_ZIP:
        return "zip";
    default:
        return NULL;
    }
}

gp_status gp_oiio_picture_check(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const char *ending)
{
    const struct format *const t = find_format(ending);
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

struct gathering {
    const struct gp_picture *pic;
    float *to;     // interleaved
    bool integer;  // codes as fractions of the largest
    bool radiance; // three floats as Radiance HDR holds them
};

/* The nearest that Radiance's pixel holds: three mantissas of 8 bits and the
 * exponent of the largest (G. Ward, "Real Pixels", Graphics Gems II, 1991).
 * OpenImageIO cuts mantissas off and turns negative ones into others, and
 * takes all of a pixel under 1e-32 for 0; it leaves these values as they are.
 * NaN and negative values become 0, those beyond the format its largest. */
static void round_radiance(float *v)
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

static void gather_row(void *ctx, int y, struct gp_picture_row *row)
{
    const struct gathering *g = ctx;
    const size_t n = (size_t) g->pic->channels, w = (size_t) g->pic->width;
    const float max = (float) ((1 << g->pic->bits) - 1);
    float *to = g->to + (size_t) y * w * n;
    if (g->integer)
        gp_picture_codes(g->pic, y, row);
    else
        gp_picture_floats(g->pic, y, row);
    for (size_t c = 0; c < n; c++) {
        for (size_t x = 0; x < w; x++)
            to[x * n + c] = g->integer ? (float) row->code[c][x] / max
                                       : row->linear[c][x];
    }
    for (size_t x = 0; g->radiance && x < w; x++)
        round_radiance(to + x * n);
}

static gp_status copy_stream(const struct gp_log *log, struct gp_file *file,
                             const struct gp_stream *s)
{
    enum { BLOCK_BYTES = 1 << 18 };
    void *block;
    uint64_t at = 0;
    gp_status st = gp_alloc(log, "block", BLOCK_BYTES, 1, &block);
    while (!st && at < s->size) {
        const int64_t n = gp_stream_read(s, block, BLOCK_BYTES, at);
        if (n <= 0)
            st = gp_fail(log, GP_ERR_IO, "%s: cannot read the file in "
                         "memory (%s); write .exr or .png", gp_file_path(file),
                         n < 0 ? strerror(errno) : "it is short");
        else
            st = gp_file_write(file, block, (size_t) n);
        at += n > 0 ? (uint64_t) n : 0;
    }
    gp_free(block);
    return st;
}

gp_status gp_oiio_picture_write(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const char *ending,
    const struct gp_frame *f, const struct gp_planes *planes,
    enum gp_picture_kind kind)
{
    static const char *const names[] = {"R", "G", "B", "A"};
    gp_status st;
    const struct format *const t = find_format(ending);
    struct gp_write_params own = *p;
    struct gp_picture pic = {0};
    struct gp_file *file = NULL;
    struct gp_shared pixels = {0};
    struct gp_stream s = GP_STREAM_EMPTY;
    if (own.alpha != GP_ALPHA_BLACK)
        own.alpha = t->alpha;
    // integers where the format has nothing else, or nothing says otherwise
    const bool scene = kind == GP_PICTURE_SCENE;
    const bool integer = is_tiff(t) ? p->type == GP_OUT_AUTO && !scene
                                    : !t->floats;
    GP_TRY(gp_picture_make(log, &own, path, f, planes, kind, integer, &pic));
    const size_t n = (size_t) pic.width * (size_t) pic.height *
                     (size_t) pic.channels;
    GP_TRY(gp_shared_make(log, path, n * sizeof(float), &pixels));
    struct gathering g = {.pic = &pic, .integer = integer,
                          .radiance = t->floats && t->bits == 0,
                          .to = pixels.at};
    GP_TRY(gp_picture_each_row(log, &pic, gather_row, &g));
    GP_TRY(gp_file_open(log, path, p->create_dir, &file));
    const struct gp_decoded image = {
        .path = gp_file_path(file), .data = {0, 0, pic.width, pic.height},
        .display = {0, 0, pic.width, pic.height},
        .channels = pic.channels, .channel_name = names,
        .chromaticities = scene ? pic.f->chromaticities : NULL,
        .colour_space = kind == GP_PICTURE_ENCODED ? ""
                        : integer                  ? "sRGB" : "Linear",
    };
    const char *type = own.type == GP_OUT_HALF ? "half" : "float";
    if (integer)
        type = own.depth_bits == 16 ? "uint16" : "uint8";
    GP_TRY(gp_oiio_write(log, &image, NULL, &pixels, t->ending, type,
                         is_tiff(t) ? tiff_compression(own.compression) : "",
                         &s));
    GP_TRY(copy_stream(log, file, &s));
    GP_TRY(gp_file_commit(&file));
out:
    gp_stream_close(&s);
    gp_file_discard(&file);
    gp_shared_free(&pixels);
    gp_picture_free(&pic);
    return st;
}
