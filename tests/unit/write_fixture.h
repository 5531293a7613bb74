// SPDX-License-Identifier: Apache-2.0
/* A folder for files that tests write, and frames made in memory. */
#ifndef WRITE_FIXTURE_H
#define WRITE_FIXTURE_H

#include "unit.h"
#include "core/colour.h"
#include "io/frame.h"
#include "core/memory.h"
#include "core/half.h"
#include "io/oiio/oiio.h"
#include "io/read.h"
#include "io/write.h"
#include "bridge_here.h"
#include "folder.h"
#include "kept_log.h"

#include <dirent.h>
#include <unistd.h>

/* Makes the folder; DWA finds OpenImageIO. */
static inline int wf_start(void **state)
{
    return find_bridges(state) || make_folder(state);
}

/* Files in the folder, hidden ones too. */
static inline int wf_names(void)
{
    int n = 0;
    DIR *d = opendir(folder);
    for (struct dirent *e; d && (e = readdir(d));)
        n += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    if (d)
        closedir(d);
    return n;
}

/* The path of a file in the folder, good until the fourth next call. */
static inline const char *wf_path(const char *name)
{
    static char path[4][512];
    static int next;
    char *p = path[next++ % 4];
    snprintf(p, sizeof path[0], "%s/%s", folder, name);
    return p;
}

static inline void wf_write_text(const char *path, const char *text)
{
    FILE *const f = fopen(path, "wb");
    assert_non_null(f);
    assert_true(fputs(text, f) >= 0);
    assert_int_equal(fclose(f), 0);
}

/* All bytes of a file; the caller frees. */
static inline uint8_t *wf_read(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    if (!f)
        fail_msg("%s is not there", path);
    fseek(f, 0, SEEK_END);
    *size = (size_t) ftell(f);
    rewind(f);
    uint8_t *bytes = malloc(*size + 1);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *size, f), *size);
    fclose(f);
    bytes[*size] = 0;
    return bytes;
}

static inline void wf_assert_same(const char *a, const char *b)
{
    size_t n, m;
    uint8_t *p = wf_read(a, &n), *q = wf_read(b, &m);
    assert_int_equal(n, m);
    assert_memory_equal(p, q, n);
    free(p);
    free(q);
}

static inline uint32_t wf_hash(uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t h = a * 2654435761u ^ b * 2246822519u ^ c * 3266489917u;
    h ^= h >> 15;
    h *= 2246822519u;
    return h ^ h >> 13;
}

/* Exact in half, within [-8, 8). */
static inline float wf_value(int channel, int x, int y)
{
    const uint32_t h = wf_hash((uint32_t) channel, (uint32_t) x, (uint32_t) y);
    return (float) (h >> 24) / 16.0f - 8.0f;
}

struct wf_channel {
    const char *name;
    enum gp_pixel_type type;
    int colour;  // 0..2, or -1 for carried
    int xs, ys;  // 0 counts as 1
};

static inline int wf_grid(int from, int to, int step)
{
    int n = 0;
    for (int i = from; i < to; i++)
        n += i % step == 0;
    return n;
}

/* Samples of a carried channel by wf_value(), in its own type. */
static inline void *wf_samples(const struct gp_channel *c, int number)
{
    const size_t n = (size_t) c->w * (size_t) c->h;
    void *data;
    assert_ok(gp_alloc(NULL, "samples", n, gp_type_size(c->type), &data));
    for (size_t i = 0; i < n; i++) {
        const int x = (int) (i % (size_t) c->w), y = (int) (i / (size_t) c->w);
        const float v = wf_value(number, x, y);
        const uint32_t u =
            wf_hash((uint32_t) x, (uint32_t) y, (uint32_t) number);
        if (c->type == GP_HALF)
            (void) gp_float_to_half(&v, (uint16_t *) data + i, 1);
        else
            memcpy((float *) data + i,
                   c->type == GP_UINT ? (const void *) &u : &v, 4);
    }
    return data;
}

/* A frame that came from no file: rgb by wf_value(0..2), and the channels of
 * a list that ends with a NULL name. */
static inline struct gp_frame wf_frame(struct gp_rect data,
    struct gp_rect display, const struct wf_channel *list)
{
    struct gp_frame f = gp_frame_blank(data);
    const int w = gp_frame_w(&f);
    f.path = gp_strdup("made");
    f.display = display;
    f.colour_type = GP_HALF;
    assert_ok(gp_planes_make(NULL, "rgb", gp_frame_pixels(&f), &f.rgb));
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < gp_frame_pixels(&f); i++)
            f.rgb.c[c][i] = wf_value(c, (int) i % w, (int) i / w);
    }
    while (list[f.channels].name)
        f.channels++;
    assert_ok(gp_alloc_zero(NULL, "channels", (size_t) f.channels,
                            sizeof *f.channel, &f.channel));
    for (int i = 0; i < f.channels; i++) {
        struct gp_channel *c = &f.channel[i];
        const int xs = list[i].xs ? list[i].xs : 1;
        const int ys = list[i].ys ? list[i].ys : 1;
        *c = (struct gp_channel) {
            .name = gp_strdup(list[i].name), .type = list[i].type, .xs = xs,
            .ys = ys, .colour = list[i].colour,
            .w = wf_grid(data.x0, data.x1, xs),
            .h = wf_grid(data.y0, data.y1, ys),
        };
        if (c->colour < 0)
            c->data = wf_samples(c, i);
    }
    return f;
}

/* The same with windows from 0, 0. */
static inline struct gp_frame wf_sized(int w, int h,
                                       const struct wf_channel *list)
{
    const struct gp_rect r = {0, 0, w, h};
    return wf_frame(r, r, list);
}

/* Samples of random bits: NaN with payloads among them. `finite` clears the
 * highest bit of the exponent. */
static inline void wf_fill_bits(const struct gp_frame *f, bool finite)
{
    for (int i = 0; i < f->channels; i++) {
        const struct gp_channel *c = &f->channel[i];
        for (int k = 0; c->data && k < c->w * c->h; k++) {
            uint32_t u = wf_hash((uint32_t) i, (uint32_t) k, 7);
            if (!finite && k % 5 == 0 && c->type != GP_UINT)
                u |= c->type == GP_HALF ? 0x7c00u : 0x7f800000u;
            if (finite && c->type != GP_UINT)
                u &= c->type == GP_HALF ? 0xbfffu : 0xbfffffffu;
            if (c->type == GP_HALF)
                ((uint16_t *) c->data)[k] = (uint16_t) u;
            else
                ((uint32_t *) c->data)[k] = u;
        }
    }
}

/* Outputs are names in the folder, or "-"; no parameters are the defaults. */

static struct gp_write_stats wf_stats; // of all that was written
static const struct gp_write_params wf_defaults = GP_WRITE_DEFAULTS;

static inline const char *wf_output(const char *name)
{
    return name[0] == '-' ? name : wf_path(name);
}

static inline gp_status wf_write_set(const struct gp_write_params *p,
    const char *name, const struct gp_hdr_colour *set, int n)
{
    kept_clear();
    return gp_write_hdr(&kept_all, p ? p : &wf_defaults, wf_output(name), set, n,
                        &wf_stats);
}

/* The --hdr of the frame's own colour. */
static inline gp_status wf_write_hdr(const struct gp_write_params *p,
                                     const char *name, const struct gp_frame *f)
{
    const struct gp_hdr_colour colour = {f, f->rgb};
    return wf_write_set(p, name, &colour, 1);
}

static inline gp_status wf_write(const struct gp_write_params *p,
    const char *name, const struct gp_frame *f, enum gp_picture_kind kind)
{
    kept_clear();
    return gp_write_picture(&kept_all, p ? p : &wf_defaults, wf_output(name), f,
                            &f->rgb, kind, &wf_stats);
}

/* The frame of a file that must be readable; the caller frees it. */
static inline struct gp_frame wf_read_back(const char *name)
{
    static const struct gp_read_params params = GP_READ_DEFAULTS;
    struct gp_frame f;
    if (gp_read_frame(&kept_all, &params, wf_path(name), &f))
        fail_msg("%s", kept_line);
    return f;
}

/* The frame of its own --hdr, in a.exr; the caller frees it. */
static inline struct gp_frame wf_trip(const struct gp_frame *f,
    enum gp_compression compression, enum gp_out_type type)
{
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    p.compression = compression;
    p.type = type;
    if (wf_write_hdr(&p, "a.exr", f))
        fail_msg("%s", kept_line);
    return wf_read_back("a.exr");
}

/* The colour of both is the same, bit by bit. */
static inline void wf_assert_planes(const struct gp_planes *a,
                                    const struct gp_planes *b, size_t n)
{
    for (int c = 0; c < 3; c++)
        assert_memory_equal(a->c[c], b->c[c], n * sizeof(float));
}

/* True when OpenImageIO is there, for DWA. */
static inline bool wf_bridge(void)
{
    return gp_oiio_check(NULL, "-") == GP_OK;
}

static const struct wf_channel wf_rgb[] = {
    {"B", GP_HALF, 2, 0, 0}, {"G", GP_HALF, 1, 0, 0}, {"R", GP_HALF, 0, 0, 0},
    {NULL, 0, 0, 0, 0},
};

/* The last compression that can be written here. */
static inline int wf_last_compression(void)
{
    return wf_bridge() ? GP_COMPRESSION_DWAB : GP_COMPRESSION_B44A;
}

/* Colour, alpha, depth and an id of every type. */
static const struct wf_channel wf_all[] = {
    {"A", GP_HALF, -1, 0, 0}, {"B", GP_HALF, 2, 0, 0},
    {"G", GP_HALF, 1, 0, 0},  {"R", GP_HALF, 0, 0, 0},
    {"Z", GP_FLOAT, -1, 0, 0}, {"id", GP_UINT, -1, 0, 0}, {NULL, 0, 0, 0, 0},
};

/* Frees each frame of a list that ends with NULL. */
static inline void wf_free_all(struct gp_frame *const *frame)
{
    for (; *frame; frame++)
        gp_frame_free(*frame);
}
#define free_frames(...)                                                      \
    wf_free_all((struct gp_frame *const[]) {__VA_ARGS__, NULL})

#endif
