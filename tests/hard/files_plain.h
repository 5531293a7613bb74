/* Shared by files.c and files_other.c: the right sample, in double. */
#ifndef GP_TESTS_HARD_FILES_PLAIN_H
#define GP_TESTS_HARD_FILES_PLAIN_H

#include "files_read.h"
#include "hash.h"

#include "hardcases.h"
#include "views.h"

#include <math.h>
#include <stdlib.h>

/* IEC 61966-2-1, in double. */
static inline double hard_srgb(double v)
{
    return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1.0 / 2.4) - 0.055;
}

/* Distance of a code of `bits` bits from that of a sample. */
static inline double hard_code_error(double got, float from, int bits)
{
    const double max = (1 << bits) - 1;
    const double v = fmin(fmax((double) from, 0.0), 1.0); // NaN: 0
    return fabs(got - hard_srgb(v) * max);
}

/* The sample of f.rgb at a place, 0 outside the data window. */
static inline float hard_lit_at(const struct gp_frame *f, int c, int x, int y)
{
    const struct gp_rect d = f->data;
    if (x < d.x0 || x >= d.x1 || y < d.y0 || y >= d.y1)
        return 0.0f;
    return f->rgb.c[c][(size_t) (y - d.y0) * (size_t) gp_rect_w(d) +
                       (size_t) (x - d.x0)];
}

/* The light of a row with its layer, as a file's frame; the caller frees it. */
static inline struct gp_frame hard_filed(const struct hard_case *h)
{
    struct gp_image v = hard_lit(h);
    const struct gp_frame f = frame_of(&v, &v.lit);
    gp_planes_free(&v.rgb);
    return f;
}

/* Of all bytes of a file. */
static inline uint64_t hard_hash_file(const char *path)
{
    size_t size;
    uint8_t *const bytes = hard_read_bytes(path, &size);
    const uint64_t hash = hash_more(HASH_NONE, bytes, size);
    free(bytes);
    return hash;
}

#endif
