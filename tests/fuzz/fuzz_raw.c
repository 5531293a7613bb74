// SPDX-License-Identifier: Apache-2.0
/* A file from disk: each part as `compare` reads it, compared with the part
 * before and with itself; and as one of depth or coverage. */
#include "compare/compare.h"
#include "harness.h"
#include "io/plane.h"

#include <stdlib.h>

static bool fits(struct gp_rect r)
{
    const int64_t w = (int64_t) r.x1 - r.x0, h = (int64_t) r.y1 - r.y0;
    return w <= FUZZ_PIXELS && h <= FUZZ_PIXELS / w;
}

/* An image as compare has it. */
static struct glarepp_stored stored(const struct gp_stored_image *m)
{
    return (struct glarepp_stored) {
        .size = sizeof(struct glarepp_stored), .first = m->first,
        .data = {m->data.x0, m->data.y0, m->data.x1, m->data.y1},
        .channel = m->channel, .channels = m->channels, .integers = m->integers,
        .light = {m->light[0], m->light[1], m->light[2]},
        .primaries = m->chromaticities,
    };
}

static void compare(const struct gp_stored_image *a, const struct gp_stored_image *b)
{
    const struct glarepp_compare_params limits = GLAREPP_COMPARE_PARAMS;
    const struct glarepp_stored s[] = {stored(a), stored(b)};
    struct gp_compare_match m;
    struct glarepp_compare_facts f;
    if (!a->first == !b->first) {
        // rows of compare's loops count in int, as its own check of the union
        if (!fuzz_line(gp_compare_match_make(&fuzz_log, &s[0], &s[1], &m)) &&
            fits(m.window) && m.pairs &&
            !fuzz_line(gp_compare_measure(&fuzz_log, &limits, &m, &f))) {
            gp_compare_judge(&limits, &f);
            if (a == b && f.result != GP_COMPARE_MATCH)
                abort();
        }
        gp_compare_match_free(&m);
    }
}

static void read_plane(const char *path, const char *name, bool depth)
{
    const struct gp_read_params p = {.max_pixels = FUZZ_PIXELS};
    struct gp_plane plane = {0};
    if (fuzz_line(gp_read_plane_file(&fuzz_log, &p, path, name, depth,
                                     &plane)))
        return;
    fuzz_touch(plane.v, (size_t) gp_rect_w(plane.window) *
                            (size_t) gp_rect_h(plane.window) * sizeof(float));
    gp_plane_free(&plane);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    enum { MOST = 4 }; // parts of one input
    const struct gp_read_params p = {.max_pixels = FUZZ_PIXELS};
    struct gp_stored_file f;
    struct gp_stored_image image[2] = {0};
    const char *const path = size ? fuzz_file(data, size) : NULL;
    fuzz_begin();
    if (path && !fuzz_line(gp_stored_open(&fuzz_log, &p, path, &f))) {
        bool before = false;
        for (int i = 0; i < f.parts && i < MOST; i++) {
            struct gp_stored_image *const a = &image[i & 1];
            gp_stored_image_free(a);
            if (fuzz_line(gp_stored_read(&fuzz_log, &p, &f, i, a))) {
                before = false;
                continue;
            }
            compare(a, a);
            if (before)
                compare(&image[!(i & 1)], a);
            before = true;
        }
        gp_stored_image_free(&image[0]);
        gp_stored_image_free(&image[1]);
    }
    if (path) {
        gp_stored_close(&f);
        read_plane(path, NULL, true);
        read_plane(path, NULL, false);
        read_plane(path, "part.Z", true);
    }
    fuzz_end(fuzz_allowed(data, size) * 3 - 2 * (uint64_t) FUZZ_FIXED);
    fuzz_file_close();
    return 0;
}
