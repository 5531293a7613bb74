#include "api/api.h"

#include "core/colour.h"
#include "core/half.h"
#include "core/luminance.h"
#include "core/memory.h"
#include "core/parallel.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

static struct gp_rect rect_of(struct glarepp_rect r)
{
    return (struct gp_rect) {r.x0, r.y0, r.x1, r.y1};
}

/* Bytes from pixel to pixel and from row to row. */
static void strides_of(const struct glarepp_image *view, ptrdiff_t *pixel,
                       ptrdiff_t *row)
{
    const ptrdiff_t bytes = view->type == GLAREPP_HALF ? 2 : 4;
    *pixel = view->pixel ? view->pixel : bytes;
    *row = view->row ? view->row : *pixel * gp_rect_w(rect_of(view->data));
}

/* True where the planes are what the rooms work on: floats without gaps. */
static bool is_packed(const struct glarepp_image *view)
{
    ptrdiff_t pixel, row;
    strides_of(view, &pixel, &row);
    return view->type == GLAREPP_FLOAT && pixel == sizeof(float) &&
           row == pixel * gp_rect_w(rect_of(view->data));
}

static gp_status check_view(const struct gp_log *log,
                            const struct glarepp_image *view, int planes)
{
    enum { MOST = 1 << 28 };
    const char *const name = view->name ? view->name : "image";
    const struct gp_rect data = rect_of(view->data);
    const long long w = (long long) data.x1 - data.x0;
    const long long h = (long long) data.y1 - data.y0;
    if (view->size != sizeof *view)
        return gp_fail_at(log, GP_ERR_USAGE, "image", "%s: its size is that of "
                          "no version up to " GP_VERSION " (found %zu)", name,
                          view->size);
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

// -- in -----------------------------------------------------------------------

struct copying {
    const struct glarepp_image *view;
    ptrdiff_t pixel, row;
    struct gp_planes planes;
    size_t w;
    int h;
};

/* Copies row i % h of channel i / h from the view. */
static void read_row(void *ctx, int i, int thread)
{
    const struct copying *const c = ctx;
    const int y = i % c->h, k = i / c->h;
    const char *const from = (const char *) c->view->plane[k] + y * c->row;
    float *const to = c->planes.c[k] + (size_t) y * c->w;
    const bool half = c->view->type == GLAREPP_HALF;
    (void) thread;
    if (half && c->pixel == 2) {
        gp_half_to_float((const uint16_t *) (const void *) from, to, c->w);
        return;
    }
    for (size_t x = 0; x < c->w; x++) {
        const char *const at = from + (ptrdiff_t) x * c->pixel;
        uint16_t code;
        if (half) {
            memcpy(&code, at, sizeof code);
            gp_half_to_float(&code, &to[x], 1);
        } else {
            memcpy(&to[x], at, sizeof to[x]);
        }
    }
}

gp_status gp_api_import(const struct gp_log *log,
    const struct glarepp_image *view, bool borrow, struct gp_image *out)
{
    gp_status st = check_view(log, view, 3);
    if (st)
        return st;
    struct gp_image f = gp_image_blank(rect_of(view->data));
    const struct gp_rect display = rect_of(view->display);
    f.display = gp_rect_empty(display) ? f.data : display;
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
        struct copying c = {.view = view, .w = (size_t) gp_image_w(&f),
                            .h = gp_image_h(&f)};
        strides_of(view, &c.pixel, &c.row);
        st = gp_planes_make(log, "image", gp_image_pixels(&f), &f.rgb);
        c.planes = f.rgb;
        if (!st)
            gp_parallel_do(3 * c.h, read_row, &c);
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
    const struct gp_rect data = rect_of(view->data);
    struct glarepp_image one = *view;
    one.plane[0] = view->plane[which];
    *out = (struct gp_plane) {.window = data};
    if (is_packed(view)) {
        out->v = one.plane[0];
        out->borrowed = true;
    } else {
        struct copying c = {.view = &one, .w = (size_t) gp_rect_w(data),
                            .h = gp_rect_h(data)};
        strides_of(view, &c.pixel, &c.row);
        st = gp_alloc(log, "plane", c.w * (size_t) c.h, sizeof *out->v,
                      &c.planes.c[0]);
        if (st)
            return st;
        gp_parallel_do(c.h, read_row, &c);
        out->v = c.planes.c[0];
    }
    return GP_OK;
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
    if (st)
        return st; // its message is the caller's
    if (!image.name)
        image.name = path;
    st = gp_api_import(log, &image, false, out);
    if (label)
        *label = own;
    if (p->release)
        p->release(p->user, &image);
    return st;
}

// -- out ----------------------------------------------------------------------

/* Copies row i % h of channel i / h to the view. */
static void write_row(void *ctx, int i, int thread)
{
    const struct copying *const c = ctx;
    const int y = i % c->h, k = i / c->h;
    char *const to = (char *) c->view->plane[k] + y * c->row;
    const float *const from = c->planes.c[k] + (size_t) y * c->w;
    const bool half = c->view->type == GLAREPP_HALF;
    (void) thread;
    if (half && c->pixel == 2) {
        gp_float_to_half(from, (uint16_t *) (void *) to, c->w);
        return;
    }
    for (size_t x = 0; x < c->w; x++) {
        char *const at = to + (ptrdiff_t) x * c->pixel;
        uint16_t code;
        if (half) {
            gp_float_to_half(&from[x], &code, 1);
            memcpy(at, &code, sizeof code);
        } else {
            memcpy(at, &from[x], sizeof from[x]);
        }
    }
}

gp_status gp_api_export(const struct gp_log *log,
    const struct gp_planes *planes, struct gp_rect data,
    const struct glarepp_image *view)
{
    const gp_status st = check_view(log, view, 3);
    const struct gp_rect own = rect_of(view->data);
    if (st)
        return st;
    if (memcmp(&own, &data, sizeof own) != 0)
        return gp_fail_at(log, GP_ERR_USAGE, "image.data", "%s: its window is "
                          "not that of the frame (found %d,%d to %d,%d)",
                          view->name ? view->name : "image", own.x0, own.y0,
                          own.x1, own.y1);
    struct copying c = {.view = view, .planes = *planes,
                        .w = (size_t) gp_rect_w(data), .h = gp_rect_h(data)};
    strides_of(view, &c.pixel, &c.row);
    gp_parallel_do(3 * c.h, write_row, &c);
    return GP_OK;
}

struct glarepp_image gp_api_view(const struct gp_planes *planes,
                                 struct gp_rect data, const struct gp_image *f)
{
    struct glarepp_image v = GLAREPP_IMAGE;
    for (int c = 0; c < 3; c++)
        v.plane[c] = planes->c[c];
    v.data = (struct glarepp_rect) {data.x0, data.y0, data.x1, data.y1};
    v.display = v.data;
    if (f) {
        v.display = (struct glarepp_rect) {f->display.x0, f->display.y0,
                                           f->display.x1, f->display.y1};
        v.aspect = f->pixel_aspect;
        v.primaries = f->chromaticities;
        v.name = f->path;
    }
    return v;
}

void glarepp_image_end(struct glarepp_image *image)
{
    struct gp_planes p = {{image->plane[0], image->plane[1], image->plane[2]}};
    gp_planes_free(&p);
    memset(image->plane, 0, sizeof image->plane);
}
