// SPDX-License-Identifier: Apache-2.0
/* Shared by the tests of io/plane: a file with parts, and a check of a plane
 * against the fixture's formula. */
#ifndef PLANE_FIXTURE_H
#define PLANE_FIXTURE_H

#include "io/plane.h"
#include "exr_fixture.h"
#include "reading.h"

static const struct gp_read_params limits = GP_READ_DEFAULTS;

/* A plane of the file at `path`. */
static inline gp_status read_plane(const char *name, bool depth,
                                   struct gp_plane *p)
{
    return gp_read_plane_file(&kept_log, &limits, path, name, depth, p);
}

/* Every sample is what the fixture's formula gives for the channel. */
static void assert_plane(const struct gp_plane *p,
                         const struct fixture_part *part, const char *channel)
{
    const struct fixture_channel *c = part->channel;
    const exr_attr_box2i_t *const b = &part->data;
    const struct gp_rect want = {b->min.x, b->min.y, b->max.x + 1,
                                 b->max.y + 1};
    while (c->name && strcmp(c->name, channel) != 0)
        c++;
    assert_non_null(c->name);
    const int xs = c->xs ? c->xs : 1, ys = c->ys ? c->ys : 1;
    assert_memory_equal(&p->window, &want, sizeof want);
    const float *v = p->v;
    for (int y = want.y0; y < want.y1; y++) {
        for (int x = want.x0; x < want.x1; x++) {
            // windows begin with a multiple of the sampling
            const int sx = want.x0 + (x - want.x0) / xs * xs;
            const int sy = want.y0 + (y - want.y0) / ys * ys;
            const float is = *v++;
            if (c->type == EXR_PIXEL_UINT)
                assert_true(is == (float) fixture_uint(c->name, sx, sy));
            else
                assert_true(is == fixture_value(c->name, sx, sy));
        }
    }
}

/* Names with dots, every type, subsampling, tiles, windows off the origin. */
static const struct fixture named = {
    .parts = 3, .part = {
        {.name = "main", .channel = {HALF_CH("A"), RGB(HALVES)}, .data = W(3),
         .compression = EXR_COMPRESSION_ZIP},
        {.name = "one.left", .channel = {UINT_CH("ids"), FLOAT_CH("mask"),
                     {"wide", HALVES, 2, 2}},
         .data = FIXTURE_WINDOW(-4, 8, 6, 16),
         .compression = EXR_COMPRESSION_PIZ},
        {.name = "two", .channel = {HALF_CH("a.Z"), HALF_CH("b.Z"),
                                    HALF_CH("mask")},
         .data = FIXTURE_WINDOW(-7, 2, 21, 9),
         .compression = EXR_COMPRESSION_RLE, .tile = 8},
    },
};

#endif
