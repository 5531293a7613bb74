// SPDX-License-Identifier: Apache-2.0
/* A frame from memory: read, look for its depth and coverages, find its light,
 * make it a kernel (the last byte says how), write it again. */
#include "glare/kernel.h"
#include "glare/sources.h"
#include "harness.h"
#include "io/plane.h"
#include "io/io_priv.h"
#include "io/write.h"
#include "../unit/views.h"

#include <stdlib.h>
#include <string.h>

static void touch_frame(const struct gp_frame *f)
{
    const size_t pixels = gp_frame_pixels(f);
    for (int c = 0; c < 3; c++)
        fuzz_touch(f->rgb.c[c], pixels * sizeof(float));
    for (int i = 0; i < f->channels; i++) {
        const struct gp_channel *const c = &f->channel[i];
        if (c->data)
            fuzz_touch(c->data, (size_t) c->w * (size_t) c->h *
                                    gp_type_size(c->type));
    }
}

static void touch_plane(struct gp_plane *p)
{
    if (p->v)
        fuzz_touch(p->v, (size_t) gp_rect_w(p->window) *
                             (size_t) gp_rect_h(p->window) * sizeof(float));
    gp_plane_free(p);
}

static void look_at_planes(const struct gp_read_params *p,
                           const struct gp_frame *f)
{
    struct gp_plane plane = {0};
    double m[16];
    if (!fuzz_line(gp_read_plane(&fuzz_log, p, f, NULL, true, &plane)))
        touch_plane(&plane);
    if (!fuzz_line(gp_read_plane(&fuzz_log, p, f, "A", false, &plane)))
        touch_plane(&plane);
    if (!fuzz_line(gp_read_crypto(&fuzz_log, p, f, "*,a", &plane)))
        touch_plane(&plane);
    gp_frame_numbers(f, "worldToCamera", 16, m);
    gp_frame_numbers(f, "worldToNDC", 16, m);
}

static void write_again(const struct gp_hdr_colour *set, int n)
{
    const struct gp_write_params w = GP_WRITE_DEFAULTS;
    struct gp_write_stats stats = {0};
    fuzz_line(gp_write_hdr(&fuzz_log, &w, "/dev/null", set, n, &stats));
}

static void sense(struct gp_image *f)
{
    struct gp_sources sources;
    const struct glarepp_sense_params s = GLAREPP_SENSE_PARAMS;
    if (!fuzz_line(gp_sense(&fuzz_log, &s, false, f, &sources)))
        gp_sources_free(&sources);
}

static void make_kernel(const struct gp_image *f, uint8_t choice)
{
    struct gp_kernel k;
    struct gp_kernel_params p = {0};
    p.centered = choice & 1;
    p.center[0] = f->data.x0 + (choice >> 4) - 2.0;
    p.center[1] = f->data.y1 - 0.5;
    p.normalize = choice & 2 ? GP_NORMALIZE_NONE : p.normalize;
    p.rotate = choice & 4 ? 30.0f : choice & 8 ? -90.0f : 0.0f;
    if (fuzz_line(gp_kernel_from_frame(&fuzz_log, &p, f, &k)))
        return;
    for (int c = 0; c < 3; c++)
        fuzz_touch(k.k.c[c], (size_t) k.w * (size_t) k.h * sizeof(float));
    gp_kernel_free(&k);
}

/* The layer of a channel, read beside the frame and written with it. */
static void look_at_layer(const struct gp_read_params *p,
                          const struct gp_frame *f, const char *channel)
{
    const char *const dot = strrchr(channel, '.');
    char *const layer = dot ? strndup(channel, (size_t) (dot - channel)) : NULL;
    struct gp_frame other = {0};
    if (layer && !fuzz_line(gp_read_layer(&fuzz_log, p, f, layer, &other))) {
        const struct gp_hdr_colour set[] = {{f, f->rgb}, {&other, other.rgb}};
        touch_frame(&other);
        write_again(set, 2);
        gp_frame_free(&other);
    }
    free(layer);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const struct gp_read_params p = {.max_pixels = FUZZ_PIXELS};
    struct gp_stream s = gp_stream_of(data, size);
    struct gp_frame f = {0};
    fuzz_begin();
    if (!fuzz_line(gp_read_stream(&fuzz_log, &p, "input", &s, &f))) {
        touch_frame(&f);
        look_at_planes(&p, &f);
        struct gp_image v = view_of(&f);
        make_kernel(&v, data[size - 1]);
        sense(&v);
        write_again(&(struct gp_hdr_colour) {&f, f.rgb}, 1);
        for (int i = 0; i < f.channels && i < 3; i++)
            look_at_layer(&p, &f, f.channel[i].name);
        gp_frame_free(&f);
    }
    fuzz_end(fuzz_allowed(data, size));
    return 0;
}
