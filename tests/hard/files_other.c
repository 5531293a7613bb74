/* The formats that OpenImageIO makes, over the hard cases. Those without loss
 * hold codes or floats as files.c has them. Lossy ones are compared with what
 * OpenImageIO decodes of a file that it made of the codes of a PNG: what io
 * gave it was right when no sample differs. */
#include "files_plain.h"
#include "files_read.h"
#include "hardcases.h"

#include "core/parallel.h"
#include "io/oiio/oiio.h"
#include "io/write.h"

#include <unistd.h>

enum store { CODE, RADIANCE, LOSSY };

static const struct format {
    const char *name, *ending;
    int bits;
    enum store store;
    void (*read)(const char *path, struct hard_picture *out);
    int most; // a picture with a longer side must be refused; 0 none is
} formats[] = {
    {"BMP, codes", "bmp", 8, CODE, hard_read_8, 0},
    {"DPX 8, codes", "dpx", 8, CODE, hard_read_8, 0},
    {"PPM, codes", "ppm", 8, CODE, hard_read_8, 0},
    {"SGI 8, codes", "sgi", 8, CODE, hard_read_8, 0},
    {"TGA, codes", "tga", 8, CODE, hard_read_8, 0},
    {"DPX 16, codes", "dpx", 16, CODE, hard_read_16, 0},
    {"SGI 16, codes", "sgi", 16, CODE, hard_read_16, 0},
    {"HDR, of the pixel's largest", "hdr", 8, RADIANCE, hard_read_16, 0},
    {"JPEG, differing", "jpg", 8, LOSSY, hard_read_8, 0},
    {"WebP, differing", "webp", 8, LOSSY, hard_read_8, 16383},
};
enum { FORMATS = sizeof formats / sizeof *formats };

/* Half a step of the exponent that the largest component has, which is at
 * least 128 steps, or 255.5 of half as much where it was rounded up. */
#define RADIANCE_BAR (1.0 / 255.5)

static double bar_of(const struct format *t)
{
    return t->store == RADIANCE ? RADIANCE_BAR
           : t->store == LOSSY  ? 0.0
           : t->bits == 8       ? 0.501
                                : 0.51;
}

static char folder[] = "/tmp/glarepp-formats-XXXXXX";

static void name_of(const char *stem, const char *ending, char path[64])
{
    snprintf(path, 64, "%s/%s.%s", folder, stem, ending);
}

static gp_status write_as(const char *path, int bits, const struct gp_frame *f)
{
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_write_stats stats = {0};
    p.depth_bits = bits;
    p.dither = GP_DITHER_NEVER;
    return gp_write_picture(&kept_log, &p, path, f, &f->rgb,
                            GP_PICTURE_SHOWN, &stats);
}

// -- errors -------------------------------------------------------------------

static double code_worst(const struct format *t, const float *got,
                         const float *from)
{
    double worst = 0.0;
    for (int c = 0; c < 3; c++)
        worst = hard_worse(worst, hard_code_error((double) got[c], from[c],
                                                  t->bits));
    return worst;
}

/* The format holds no sign, no NaN, and up to 255 * 2^119; OpenImageIO's writer
 * nothing of a pixel under 1e-32. */
static double radiance_worst(const float *got, const float *from)
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

static double picture_error(const struct format *t,
                            const struct hard_picture *got,
                            const struct gp_frame *f)
{
    const struct gp_rect d = f->display;
    double worst = 0.0;
    for (int i = 0; i < got->w * got->h; i++) {
        const float *const v = &got->v[3 * (size_t) i];
        float from[3];
        for (int c = 0; c < 3; c++)
            from[c] = hard_lit_at(f, c, d.x0 + i % got->w, d.y0 + i / got->w);
        worst = hard_worse(worst, t->store == CODE ? code_worst(t, v, from)
                                                   : radiance_worst(v, from));
    }
    return worst;
}

static void save_stream(const char *path, const struct gp_stream *from)
{
    void *const bytes = scene_alloc(from->size, 1);
    FILE *const to = fopen(path, "wb");
    if (!to || gp_stream_read(from, bytes, from->size, 0) !=
                   (int64_t) from->size ||
        fwrite(bytes, 1, from->size, to) != from->size || fclose(to))
        hard_die(path, "cannot be written");
    free(bytes);
}

/* These codes of 8 bits as OpenImageIO decodes them. */
static struct hard_picture by_itself(const struct format *t,
                                     const struct hard_picture *codes)
{
    static const char *const names[] = {"R", "G", "B"};
    char path[64];
    const size_t n = 3 * (size_t) codes->w * (size_t) codes->h;
    struct gp_shared pixels;
    struct gp_stream file;
    const struct gp_rect all = {0, 0, codes->w, codes->h};
    const struct gp_decoded img = {
        .path = t->name, .data = all, .display = all, .channels = 3,
        .channel_name = names, .colour_space = "sRGB",
    };
    struct hard_picture out = {0};
    if (gp_shared_make(&kept_log, t->name, n * sizeof(float), &pixels))
        hard_die(t->name, kept_line);
    for (size_t i = 0; i < n; i++)
        ((float *) pixels.at)[i] = codes->v[i] / 255.0f;
    name_of("itself", t->ending, path);
    if (gp_oiio_write(&kept_log, &img, NULL, &pixels, t->ending, "uint8", "",
                      &file))
        hard_die(t->name, kept_line);
    save_stream(path, &file);
    gp_stream_close(&file);
    gp_shared_free(&pixels);
    t->read(path, &out);
    unlink(path);
    return out;
}

/* Samples that differ. */
static double lossy_error(const struct format *t,
                          const struct hard_picture *got,
                          const struct hard_picture *codes)
{
    struct hard_picture want = by_itself(t, codes);
    const size_t n = 3 * (size_t) got->w * (size_t) got->h;
    double differ = want.w == got->w && want.h == got->h ? 0.0 : HARD_NO_BAR;
    for (size_t i = 0; differ < HARD_NO_BAR && i < n; i++)
        differ += got->v[i] != want.v[i];
    free(want.v);
    return differ;
}

static double file_error(const struct format *t, const char *path,
                         const struct gp_frame *f,
                         const struct hard_picture *codes)
{
    struct hard_picture got = {0};
    t->read(path, &got);
    double worst = HARD_NO_BAR;
    if (got.w == codes->w && got.h == codes->h)
        worst = t->store == LOSSY ? lossy_error(t, &got, codes)
                                  : picture_error(t, &got, f);
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

static void print_cell(const struct format *t, const struct gp_frame *f,
                       const struct hard_picture *codes)
{
    char path[64];
    name_of("out", t->ending, path);
    const gp_status st = write_as(path, t->bits, f);
    if (is_too_large(t, f) && is_refusal(st, path))
        hard_refused();
    else if (st)
        hard_die(path, kept_line);
    else
        hard_cell(is_too_large(t, f) ? HARD_NO_BAR
                                     : file_error(t, path, f, codes),
                  bar_of(t));
    unlink(path);
}

static void print_errors(const struct hard_column *columns)
{
    hard_table("Files by OpenImageIO", "largest error of a sample read back; "
               "samples that differ from what it makes of PNG's codes",
               columns);
    for (int row = 0; row < HARD_CASES; row++) {
        char path[64];
        struct hard_picture codes = {0};
        if (!hard_is_run(&hard_cases[row]))
            continue;
        struct gp_frame f = hard_filed(&hard_cases[row]);
        name_of("codes", "png", path);
        if (write_as(path, 8, &f))
            hard_die(path, kept_line);
        hard_read_png(path, &codes);
        unlink(path);
        hard_row(hard_cases[row].name);
        for (int i = 0; i < FORMATS; i++)
            print_cell(&formats[i], &f, &codes);
        free(codes.v);
        gp_frame_free(&f);
    }
    hard_table_end();
}

static bool differs_by_threads(const struct format *t, int threads,
                               const struct gp_frame *f)
{
    char path[64];
    uint64_t hash[2];
    name_of("out", t->ending, path);
    for (int k = 0; k < 2; k++) {
        gp_set_threads(k ? threads : 1);
        if (write_as(path, t->bits, f))
            hard_die(path, kept_line);
        hash[k] = hard_hash_file(path);
        unlink(path);
    }
    gp_set_threads(0);
    return hash[0] != hash[1];
}

static void count_differing(int row, int threads, double *differ)
{
    struct gp_frame f = hard_filed(&hard_cases[row]);
    for (int i = 0; i < FORMATS; i++) {
        if (!is_too_large(&formats[i], &f))
            differ[i] += differs_by_threads(&formats[i], threads, &f);
    }
    gp_frame_free(&f);
}

void hard_other_files(void)
{
    struct hard_column columns[FORMATS + 1] = {{NULL, 0}};
    if (!mkdtemp(folder))
        hard_die(folder, "cannot be made");
    for (int i = 0; i < FORMATS; i++)
        columns[i] = (struct hard_column) {formats[i].name,
                                           bar_of(&formats[i])};
    print_errors(columns);
    for (int i = 0; i < FORMATS; i++)
        columns[i].bar = 0.0;
    hard_table("Files by OpenImageIO, the same bytes",
               "files that differ from those of one thread", columns);
    hard_thread_rows(FORMATS, HARD_CASES, hard_is_threaded, count_differing);
    hard_table_end();
    if (rmdir(folder))
        hard_die(folder, "something is left in it");
}
