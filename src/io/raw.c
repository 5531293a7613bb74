#include "io/io_priv.h"

#include "core/memory.h"
#include "io/file.h"
#include "io/picture.h"

#include <string.h>

/* Bytes of one sample. */
static size_t sample_bytes(enum gp_raw_format raw)
{
    return raw == GP_RAW_RGB24 ? 1 : raw == GP_RAW_RGBF32LE ? 4 : 2;
}

struct gathering {
    const struct gp_picture *pic;
    enum gp_raw_format raw;
    uint8_t *to;
};

static void store_float(float v, uint8_t *to)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t) (bits >> 8 * i);
}

static void store_code(uint16_t code, enum gp_raw_format raw, uint8_t *to)
{
    const int high = raw == GP_RAW_RGB48BE ? 0 : 1;
    if (raw == GP_RAW_RGB24) {
        to[0] = (uint8_t) code;
        return;
    }
    to[high] = (uint8_t) (code >> 8);
    to[1 - high] = (uint8_t) code;
}

static void gather_row(void *ctx, int y, struct gp_picture_row *row)
{
    const struct gathering *g = ctx;
    const size_t w = (size_t) g->pic->width, bytes = sample_bytes(g->raw);
    uint8_t *to = g->to + (size_t) y * w * 3 * bytes;
    const bool floats = g->raw == GP_RAW_RGBF32LE;
    if (floats)
        gp_picture_floats(g->pic, y, row);
    else
        gp_picture_codes(g->pic, y, row);
    for (size_t x = 0; x < w; x++) {
        for (size_t c = 0; c < 3; c++, to += bytes) {
            if (floats)
                store_float(row->linear[c][x], to);
            else
                store_code(row->code[c][x], g->raw, to);
        }
    }
}

gp_status gp_raw_write(const struct gp_log *log,
                       const struct gp_write_params *p, const char *path,
                       const struct gp_frame *f, const struct gp_planes *planes,
                       enum gp_picture_kind kind, struct gp_write_stats *stats)
{
    gp_status st;
    struct gp_write_params own = *p;
    struct gp_picture pic;
    struct gp_file *file = NULL;
    void *bytes = NULL;
    own.depth_bits = p->raw == GP_RAW_RGB24 ? 8 : 16;
    own.alpha = GP_ALPHA_BLACK;
    GP_TRY(gp_picture_make(log, &own, path, f, planes, kind,
                           p->raw != GP_RAW_RGBF32LE, &pic));
    const size_t size = (size_t) pic.width * (size_t) pic.height * 3 *
                        sample_bytes(p->raw);
    const struct gp_raw_size before = stats->raw;
    if (before.w && (before.w != pic.width || before.h != pic.height))
        GP_TRY(gp_fail(log, GP_ERR_DATA,
                       "%s: another size than the raw frames before it (found "
                       "%d x %d after %d x %d); make it in a run of its own",
                       f->path ? f->path : path, pic.width, pic.height,
                       before.w, before.h));
    stats->raw = (struct gp_raw_size) {pic.width, pic.height};
    GP_TRY(gp_alloc(log, "raw frame", size, 1, &bytes));
    struct gathering g = {.pic = &pic, .raw = p->raw, .to = bytes};
    GP_TRY(gp_picture_each_row(log, &pic, gather_row, &g));
    GP_TRY(gp_file_open(log, path, p->create_dir, &file));
    GP_TRY(gp_file_write(file, bytes, size));
    GP_TRY(gp_file_commit(&file));
out:
    gp_file_discard(&file);
    gp_free(bytes);
    gp_picture_free(&pic);
    return st;
}
