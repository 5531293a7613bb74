/* An image as one of several recipes: a lens' measured or painted picture of a
 * point of light. */
#include "core/memory.h"
#include "glare/model/model_priv.h"

#include <math.h>
#include <stdlib.h>

static void image_row(const void *state, int x, int y, int n,
                      double *const out[3])
{
    const struct gp_kernel *const k = state;
    const int row = y + k->cy;
    for (int c = 0; c < (k->grey ? 1 : 3); c++) {
        for (int i = 0; i < n; i++) {
            const int column = x + i + k->cx;
            const bool in = row >= 0 && row < k->h && column >= 0 &&
                            column < k->w;
            out[c][i] = in ? (double) k->k.c[c][(size_t) row * (size_t) k->w +
                                                (size_t) column] : 0.0;
        }
    }
}

static void free_image(void *state)
{
    gp_kernel_free(state);
    gp_free(state);
}

static gp_status open_image(const struct gp_log *log, const struct gp_recipe *r,
                            const struct gp_field *f, struct gp_shape *out)
{
    const double size = gp_recipe_value(r, "size");
    const double x = gp_recipe_value(r, "x"), y = gp_recipe_value(r, "y");
    const struct gp_rect window = r->image->data;
    const int middle[2] = {gp_rect_w(window) / 2, gp_rect_h(window) / 2};
    struct gp_kernel *k;
    const struct gp_kernel_params p = {
        .centered = true,
        .center = {window.x0 + (x < 0.0 ? middle[0] : x) + 0.5,
                   window.y0 + (y < 0.0 ? middle[1] : y) + 0.5},
        .rotate = (float) f->rotate,
        .normalize = r->as_it_is ? GP_NORMALIZE_NONE : GP_NORMALIZE_LUMINANCE,
        .aspect = f->aspect,
        .scale = size > 0.0 ? size / (f->degrees * gp_rect_h(window))
                            : gp_recipe_value(r, "percent") / 100.0,
    };
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *k, &k);
    if (!st)
        st = gp_kernel_from_frame(log, &p, r->image, k);
    if (st) {
        gp_free(k);
        return st;
    }
    const int reach[] = {abs(k->cx), abs(k->cy), abs(k->w - 1 - k->cx),
                         abs(k->h - 1 - k->cy)};
    *out = (struct gp_shape) {
        .state = k, .free = free_image, .row = image_row, .grey = k->grey,
        .negative = k->negative, .smooth = INFINITY, .fits = {1, 1},
    };
    for (int i = 0; i < 4; i++)
        out->reach = reach[i] > out->reach ? reach[i] : out->reach;
    return GP_OK;
}

static const struct gp_model_key keys[] = {
    GP_MODEL_SHARE(1.0),
    {"file", "the image; needed", 1, 0, 0, NULL, true},
    {"size", "its height in degrees of view; 0: by percent", 0, 0, 180, NULL,
     false},
    {"percent", "frame pixels for 100 of its own", 100, 0.1, 10000, NULL,
     false},
    {"x", "column of its centre's pixel, from 0; -1: the middle", -1, -1, 1e6,
     NULL, false},
    {"y", "row of its centre's pixel, from 0; -1: the middle", -1, -1, 1e6,
     NULL, false},
    {0},
};

const struct gp_model gp_model_image = {
    .name = "image", .text = "an image of a point of light",
    .source = "measured or painted; resampled by areas",
    .keys = keys, .open = open_image,
};
