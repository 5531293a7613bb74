/* Every format that io writes itself, and TIFF, over the hard cases: what is
 * read back against what was to be stored, windows and the rules for NaN, Inf
 * and overflow included. EXR is read by io's reader, the others by the plain
 * readers of files_read.c, TIFF through OpenImageIO. */
#include "files_lossy.h"
#include "files_plain.h"
#include "files_read.h"
#include "hardcases.h"

#include "core/parallel.h"
#include "io/io_priv.h"
#include "io/read.h"

#include <unistd.h>

/* A format's form of samples, and so the unit of its error. */
enum store { HALF_ULP, SAME_FLOAT, CODE, LOSSY };

static const struct format {
    const char *ending;
    int column;
    struct gp_write_params p;
    enum store store;
    void (*read)(const char *path, struct hard_picture *out); // NULL: EXR
    double (*lossy)(const struct gp_frame *got, const struct gp_frame *f);
} formats[] = {
#define AN_EXR(col, kind, how, held, by)                                      \
    {".exr", col, {.type = kind, .compression = GP_COMPRESSION_##how,         \
                   .depth_bits = 8},                                          \
     held, NULL, by}
#define EXR(col, kind, how)                                                   \
    AN_EXR(col, kind, how, col == 0 ? HALF_ULP : SAME_FLOAT, NULL)
    EXR(0, GP_OUT_HALF, NONE), EXR(0, GP_OUT_HALF, RLE),
    EXR(0, GP_OUT_HALF, ZIPS), EXR(0, GP_OUT_HALF, ZIP),
    EXR(0, GP_OUT_HALF, PIZ), EXR(0, GP_OUT_HALF, PXR24),
    EXR(1, GP_OUT_FLOAT, NONE), EXR(1, GP_OUT_FLOAT, RLE),
    EXR(1, GP_OUT_FLOAT, ZIPS), EXR(1, GP_OUT_FLOAT, ZIP),
    EXR(1, GP_OUT_FLOAT, PIZ),
#undef EXR
    AN_EXR(10, GP_OUT_FLOAT, PXR24, LOSSY, hard_pxr24_error),
    AN_EXR(11, GP_OUT_HALF, B44, LOSSY, hard_b44_error),
    AN_EXR(11, GP_OUT_HALF, B44A, LOSSY, hard_b44_error),
    AN_EXR(12, GP_OUT_HALF, DWAA, LOSSY, hard_dwa_error),
    AN_EXR(12, GP_OUT_HALF, DWAB, LOSSY, hard_dwa_error),
#undef AN_EXR
#define OTHER(end, col, bits, how, by, ...)                                   \
    {end, col, {.compression = GP_COMPRESSION_AUTO, .depth_bits = bits,       \
                .dither = GP_DITHER_NEVER, __VA_ARGS__}, how, by, NULL}
    OTHER(".png", 2, 8, CODE, hard_read_png, .type = GP_OUT_AUTO),
    OTHER(".png", 3, 16, CODE, hard_read_png, .type = GP_OUT_AUTO),
    OTHER(".tif", 4, 16, CODE, hard_read_16, .type = GP_OUT_AUTO),
    OTHER(".tif", 5, 16, SAME_FLOAT, hard_read_16, .type = GP_OUT_FLOAT),
    OTHER(".pfm", 6, 8, SAME_FLOAT, hard_read_pfm, .type = GP_OUT_AUTO),
#undef OTHER
#define RAW(col, bits, how, kind, by)                                         \
    {"", col, {.compression = GP_COMPRESSION_AUTO, .depth_bits = bits,        \
               .dither = GP_DITHER_NEVER, .stdout_format = GP_STDOUT_RAW,     \
               .raw = GP_RAW_##kind},                                         \
     how, by, NULL}
    RAW(7, 8, CODE, RGB24, hard_read_rgb24),
    RAW(8, 16, CODE, RGB48LE, hard_read_rgb48le),
    RAW(8, 16, CODE, RGB48BE, hard_read_rgb48be),
    RAW(9, 8, SAME_FLOAT, RGBF32LE, hard_read_rgbf32le),
#undef RAW
};
enum { FORMATS = sizeof formats / sizeof *formats, COLUMNS = 13 };

/* Half is rounded to the nearest; codes are found in float arithmetic. */
static const struct hard_column columns[COLUMNS + 1] = {
    {"EXR half, ulp", 0.5}, {"EXR float, differing", 0},
    {"PNG 8, codes", 0.501}, {"PNG 16, codes", 0.51},
    {"TIFF 16, codes", 0.51}, {"TIFF float, differing", 0},
    {"PFM, differing", 0}, {"raw 8, codes", 0.501}, {"raw 16, codes", 0.51},
    {"raw float, differing", 0}, {"EXR PXR24 float, of it", HARD_PXR24_BAR},
    {"EXR B44, of its block", HARD_B44_BAR}, {"EXR DWA, bent", HARD_DWA_BAR},
    {NULL, 0},
};

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

static double sample_error(const struct format *t, float got, float from)
{
    const int bits = t->p.raw == GP_RAW_RGB24 && !t->ending[0]
                         ? 8 : t->p.depth_bits;
    switch (t->store) {
    case HALF_ULP:
        return half_error(got, from);
    case CODE:
        return hard_code_error((double) got, from, bits);
    case SAME_FLOAT:
    case LOSSY: // by frame
        break;
    }
    return float_error(got, from);
}

// -- pictures read back -------------------------------------------------------

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
    else if (t->lossy)
        worst = t->lossy(&got, f);
    const size_t n = gp_frame_pixels(f);
    for (size_t i = 0; !t->lossy && worst < HARD_NO_BAR && i < 3 * n; i++)
        worst = hard_worse(worst, sample_error(t, got.rgb.c[i / n][i % n],
                                               f->rgb.c[i / n][i % n]));
    free(light);
    gp_frame_free(&got);
    return worst;
}

/* All others show the display window. */
static double picture_error(const struct format *t, const char *path,
                            const struct gp_frame *f)
{
    struct hard_picture got = {0};
    const struct gp_rect d = f->display;
    double worst = 0.0;
    got.w = gp_rect_w(d); // raw frames do not say
    got.h = gp_rect_h(d);
    t->read(path, &got);
    if (got.w != gp_rect_w(d) || got.h != gp_rect_h(d))
        worst = HARD_NO_BAR;
    for (int i = 0; worst < HARD_NO_BAR && i < got.w * got.h; i++) {
        for (int c = 0; c < 3; c++)
            worst = hard_worse(worst, sample_error(
                t, got.v[3 * (size_t) i + (size_t) c],
                hard_lit_at(f, c, d.x0 + i % got.w, d.y0 + i / got.w)));
    }
    free(got.v);
    return worst;
}

// -- files --------------------------------------------------------------------

static char folder[] = "/tmp/glarepp-hard-XXXXXX";

static void name_of(const struct format *t, char path[64])
{
    snprintf(path, 64, "%s/out%s", folder, t->ending);
}

/* Raw frames are for names without an ending, pipes: to a file only by their
 * own writer. */
static void write_as(const struct format *t, const char *path,
                     const struct gp_frame *f)
{
    struct gp_write_stats stats = {0};
    const gp_status st = t->ending[0]
        ? gp_write_picture(&kept_log, &t->p, path, f, &f->rgb,
                           GP_PICTURE_SHOWN, &stats)
        : gp_raw_write(&kept_log, &t->p, path, f, &f->rgb, GP_PICTURE_SHOWN,
                       &stats);
    if (st)
        hard_die(path, kept_line);
}

// -- tables -------------------------------------------------------------------

static void print_errors(void)
{
    hard_table("Files", "largest error of a sample read back, over all "
                        "compressions and byte orders", columns);
    for (int row = 0; row < HARD_CASES; row++) {
        double error[COLUMNS] = {0};
        if (!hard_is_run(&hard_cases[row]))
            continue;
        struct gp_frame f = hard_filed(&hard_cases[row]);
        for (int i = 0; i < FORMATS; i++) {
            const struct format *const t = &formats[i];
            char path[64];
            name_of(t, path);
            write_as(t, path, &f);
            error[t->column] = hard_worse(
                error[t->column], t->read ? picture_error(t, path, &f)
                                          : exr_error(t, path, &f));
            unlink(path);
        }
        hard_row(hard_cases[row].name);
        for (int i = 0; i < COLUMNS; i++)
            hard_cell(error[i], columns[i].bar);
        gp_frame_free(&f);
    }
    hard_table_end();
}

/* Files of a row that differ from those of one thread, by column. */
static void count_differing(int row, int threads, double *differ)
{
    struct gp_frame f = hard_filed(&hard_cases[row]);
    for (int i = 0; i < FORMATS; i++) {
        char path[64];
        uint64_t hash[2];
        name_of(&formats[i], path);
        for (int k = 0; k < 2; k++) {
            gp_set_threads(k ? threads : 1);
            write_as(&formats[i], path, &f);
            hash[k] = hard_hash_file(path);
            unlink(path);
        }
        differ[formats[i].column] += hash[0] != hash[1];
    }
    gp_set_threads(0);
    gp_frame_free(&f);
}

static void print_same_bytes(void)
{
    struct hard_column same[COLUMNS + 1] = {{NULL, 0}};
    for (int i = 0; i < COLUMNS; i++)
        same[i].name = columns[i].name;
    hard_table("Files, the same bytes",
               "files that differ from those of one thread", same);
    hard_thread_rows(COLUMNS, HARD_CASES, hard_is_threaded, count_differing);
    hard_table_end();
}

void hard_files(void)
{
    if (!mkdtemp(folder))
        hard_die(folder, "cannot be made");
    print_errors();
    print_same_bytes();
    if (rmdir(folder))
        hard_die(folder, "something is left in it");
}
