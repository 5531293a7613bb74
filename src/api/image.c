// SPDX-License-Identifier: Apache-2.0
#include "api/api.h"

#include "core/colour.h"
#include "core/half.h"
#include "core/luminance.h"
#include "core/memory.h"

#include <stdint.h>
#include <string.h>

/* Bytes from pixel to pixel and from row to row. */
static void strides_of(const struct glarepp_image *view, ptrdiff_t *pixel,
                       ptrdiff_t *row)
{
    const ptrdiff_t bytes = view->type == GLAREPP_HALF ? 2 : 4;
    *pixel = view->pixel ? view->pixel : bytes;
    *row = view->row ? view->row : *pixel * gp_rect_w(view->data);
}

/* True where the planes are what the rooms work on: floats without gaps. */
static bool is_packed(const struct glarepp_image *view)
{
    ptrdiff_t pixel, row;
    strides_of(view, &pixel, &row);
    return view->type == GLAREPP_FLOAT && pixel == sizeof(float) &&
           row == pixel * gp_rect_w(view->data);
}

static gp_status check_view(const struct gp_log *log,
                            const struct glarepp_image *view, int planes)
{
    enum { MOST = 1 << 28 };
    const char *const name = view->name ? view->name : "image";
    const struct gp_rect data = view->data;
    const long long w = (long long) data.x1 - data.x0;
    const long long h = (long long) data.y1 - data.y0;
    if (view->size != sizeof *view)
        return gp_fail_at(log, GP_ERR_USAGE, "image", "%s: its size is that of "
                          "no version up to " GP_VERSION " (found %zu)", name,
                          view->size);
    if (view->type > GLAREPP_HALF)
        return gp_fail_at(log, GP_ERR_USAGE, "image.type", "%s: samples are "
                          "float or half (found %d)", name, (int) view->type);
    if (w < 1 || h < 1 || w > MOST || h > MOST || w * h > INT32_MAX)
        return gp_fail_at(log, GP_ERR_USAGE, "image.data", "%s: no window of "
                          "pixels (found %lld x %lld)", name, w, h);
    for (int c = 0; c < planes; c++) {
        if (!view->plane[c])
            return gp_fail_at(log, GP_ERR_USAGE, "image.plane", "%s: plane %d "
                              "is missing", name, c);
    }
    return GP_OK;
}

// -- copying ------------------------------------------------------------------

struct copying {
    const struct glarepp_image *view;
    ptrdiff_t pixel, row;
    const struct gp_planes *planes;
    size_t w;
    int h;
    bool out;                // to the view
};

/* Copies row i % h of channel i / h. */
static void copy_row(void *ctx, int i, int thread)
{
    const struct copying *const c = ctx;
    const int y = i % c->h, k = i / c->h;
    char *const view = (char *) c->view->plane[k] + y * c->row;
    float *const own = c->planes->c[k] + (size_t) y * c->w;
    const bool half = c->view->type == GLAREPP_HALF;
    (void) thread;
    if (half && c->pixel == 2) {
        uint16_t *const code = (uint16_t *) (void *) view;
        if (c->out)
            gp_float_to_half(own, code, c->w);
        else
            gp_half_to_float(code, own, c->w);
        return;
    }
    for (size_t x = 0; x < c->w; x++) {
        char *const at = view + (ptrdiff_t) x * c->pixel;
        uint16_t code;
        if (!half) {
            memcpy(c->out ? at : (char *) &own[x],
                   c->out ? (char *) &own[x] : at, sizeof *own);
        } else if (c->out) {
            gp_float_to_half(&own[x], &code, 1);
            memcpy(at, &code, sizeof code);
        } else {
            memcpy(&code, at, sizeof code);
            gp_half_to_float(&code, &own[x], 1);
        }
    }
}

/* Copies the first planes between a view and planes of its window. */
static void copy_planes(const struct glarepp_image *view,
                        const struct gp_planes *planes, int n, bool out)
{
    const struct gp_rect data = view->data;
    struct copying c = {.view = view, .planes = planes, .out = out,
                        .w = (size_t) gp_rect_w(data), .h = gp_rect_h(data)};
    strides_of(view, &c.pixel, &c.row);
    gp_parallel_do(n * c.h, copy_row, &c);
}

gp_status gp_api_import(const struct gp_log *log,
    const struct glarepp_image *view, bool borrow, struct gp_image *out)
{
    gp_status st = check_view(log, view, 3);
    if (st)
        return st;
    struct gp_image f = gp_image_blank(view->data);
    f.display = gp_rect_empty(view->display) ? f.data : view->display;
    f.pixel_aspect = view->aspect > 0.0f ? view->aspect : 1.0f;
    if (view->primaries) {
        memcpy(f.chromaticities, view->primaries, sizeof f.chromaticities);
        gp_luminance_weights(f.chromaticities, f.luminance);
        f.names_chromaticities = true;
    }
    // (before planes are borrowed, which a failure would free)
    f.path = gp_strdup(view->name ? view->name : "image");
    if (!f.path) {
        st = gp_no_memory_bare(log, "image");
    } else if (borrow && is_packed(view)) {
        for (int c = 0; c < 3; c++)
            f.rgb.c[c] = view->plane[c];
    } else {
        st = gp_planes_make(log, "image", gp_image_pixels(&f), &f.rgb);
        if (!st)
            copy_planes(view, &f.rgb, 3, false);
    }
    if (st)
        gp_image_free(&f);
    else
        *out = f;
    return st;
}

gp_status gp_api_plane(const struct gp_log *log,
    const struct glarepp_image *view, int which, struct gp_plane *out)
{
    gp_status st = check_view(log, view, which + 1);
    if (st)
        return st;
    const struct gp_rect data = view->data;
    struct glarepp_image one = *view;
    one.plane[0] = view->plane[which];
    *out = (struct gp_plane) {.window = data, .borrowed = is_packed(view),
                              .v = one.plane[0]};
    if (out->borrowed)
        return GP_OK;
    st = gp_alloc(log, "plane", gp_rect_pixels(data), sizeof *out->v, &out->v);
    if (!st)
        copy_planes(&one, &(struct gp_planes) {{out->v}}, 1, false);
    return st;
}

gp_status gp_api_picture(struct glarepp *gp, const struct gp_log *log,
                         const char *path, struct gp_image *out,
                         struct glarepp_label *label)
{
    const struct glarepp_params *const p = &gp->params;
    const struct glarepp_picture what = {.path = path, .most = 1LL << 28};
    struct glarepp_image image = GLAREPP_IMAGE;
    struct glarepp_label own = {0};
    if (!p->picture)
        return gp_fail_at(log, GP_ERR_USAGE, "params.picture", "%s: a picture, "
                          "and there is no callback to decode it", path);
    gp_status st = (gp_status) p->picture(p->user, &what, &image, &own);
    if (st) { // its message is the caller's
        gp_api_note(st, "params.picture", path);
        return st;
    }
    if (!image.name)
        image.name = path;
    st = gp_api_import(log, &image, false, out);
    if (label)
        *label = own;
    if (p->release)
        p->release(p->user, &image);
    return st;
}

gp_status gp_api_export(const struct gp_log *log,
    const struct gp_planes *planes, struct gp_rect data,
    const struct glarepp_image *view)
{
    const gp_status st = check_view(log, view, 3);
    const struct gp_rect own = view->data;
    if (st)
        return st;
    if (memcmp(&own, &data, sizeof own) != 0)
        return gp_fail_at(log, GP_ERR_USAGE, "image.data", "%s: its window is "
                          "not that of the frame (found %d,%d to %d,%d)",
                          view->name ? view->name : "image", own.x0, own.y0,
                          own.x1, own.y1);
    copy_planes(view, planes, 3, true);
    return GP_OK;
}

struct glarepp_image gp_api_view(const struct gp_planes *planes,
                                 struct gp_rect data, const struct gp_image *f)
{
    struct glarepp_image v = GLAREPP_IMAGE;
    for (int c = 0; c < 3; c++)
        v.plane[c] = planes->c[c];
    v.data = v.display = data;
    if (f) {
        v.display = f->display;
        v.aspect = f->pixel_aspect;
        v.primaries = f->chromaticities;
        v.name = f->path;
    }
    return v;
}

gp_status gp_api_dark_layer(const struct gp_log *log, struct gp_image *image)
{
    const size_t n = gp_image_pixels(image);
    if (image->layer.c[0])
        return GP_OK;
    const gp_status st = gp_planes_make(log, "layer", n, &image->layer);
    if (!st)
        gp_planes_clear(&image->layer, 0, n);
    return st;
}

void glarepp_image_end(struct glarepp_image *image)
{
    struct gp_planes p = {{image->plane[0], image->plane[1], image->plane[2]}};
    gp_planes_free(&p);
    memset(image->plane, 0, sizeof image->plane);
}
