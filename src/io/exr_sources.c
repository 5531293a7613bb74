#include "io/exr_sources.h"

#include "core/memory.h"
#include "io/colour_name.h"

#include <stdlib.h>
#include <string.h>

static gp_status make_room(const struct gp_log *log, int most,
                           struct gp_exr_sources *out)
{
    void *mem;
    *out = (struct gp_exr_sources) {0};
    gp_status st = gp_alloc(log, "channels", (size_t) most,
                            sizeof *out->source, &mem);
    out->source = mem;
    return st;
}

static void add_colour(struct gp_exr_sources *s, const char *name,
                       const struct gp_frame *f, const float *plane,
                       enum gp_pixel_type type, bool linear)
{
    s->source[s->sources++] = (struct gp_exr_source) {
        .name = name, .type = type, .xs = 1, .ys = 1, .linear = linear,
        .columns = gp_frame_w(f), .plane = plane,
    };
}

gp_status gp_exr_sources_picture(const struct gp_log *log,
                                 const struct gp_frame *f,
                                 const struct gp_planes *planes,
                                 enum gp_pixel_type type,
                                 struct gp_exr_sources *out)
{
    static const char *const name[3] = {"R", "G", "B"};
    gp_status st = make_room(log, 3, out);
    for (int c = 0; !st && c < 3; c++)
        add_colour(out, name[c], f, planes->c[c], type, false);
    if (!st)
        gp_exr_sort(out->source, out->sources);
    return st;
}

/* Colour c under a name that the frame does not have. */
static gp_status add_made(const struct gp_log *log, struct gp_exr_sources *s,
                          const struct gp_channel *like, int c,
                          const struct gp_frame *f, const float *plane,
                          enum gp_pixel_type type)
{
    s->made[c] = gp_colour_name(like->name, c);
    if (!s->made[c])
        return gp_fail(log, GP_ERR_BUG, "channels: out of memory");
    const struct gp_channel *taken = gp_frame_channel(f, s->made[c]);
    if (taken && taken->colour < 0)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the glare has a colour that needs a channel %s, "
                       "and the file has another one of that name; rename it",
                       f->path, s->made[c]);
    add_colour(s, s->made[c], f, plane, type, like->linear);
    return GP_OK;
}

static bool all_zero(const float *v, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (v[i] != 0.0f)
            return false;
    }
    return true;
}

static bool is_grey(const struct gp_planes *p, size_t n)
{
    return memcmp(p->c[0], p->c[1], n * sizeof(float)) == 0 &&
           memcmp(p->c[0], p->c[2], n * sizeof(float)) == 0;
}

/* True when colour c has no channel to go into and cannot be left out. */
static bool is_missing(const struct gp_frame *f, const struct gp_planes *p,
                       bool under_own_names, int c)
{
    for (int i = 0; under_own_names && i < f->channels; i++) {
        if (f->channel[i].colour == c)
            return false;
    }
    if (!under_own_names)
        return true;
    return f->model == GP_COLOUR_RGB && !all_zero(p->c[c], gp_frame_pixels(f));
}

/* What a file that was not EXR may have given. */
static gp_status check_names(const struct gp_log *log,
                             const struct gp_frame *f,
                             const struct gp_exr_sources *s)
{
    for (int i = 0; i < s->sources; i++) {
        const char *name = s->source[i].name;
        if (name[0] == '\0' || strlen(name) > 255 ||
            (i > 0 && strcmp(s->source[i - 1].name, name) == 0))
            return gp_fail(log, GP_ERR_DATA,
                           "%s: EXR cannot hold its channels (name \"%.40s\" "
                           "is empty, too long, or there twice); rename them",
                           f->path, name);
    }
    return GP_OK;
}

gp_status gp_exr_sources_hdr(const struct gp_log *log,
                             const struct gp_frame *f,
                             const struct gp_planes *planes,
                             enum gp_pixel_type type,
                             struct gp_exr_sources *out)
{
    gp_status st;
    const struct gp_channel *like = NULL; // a colour channel of the input
    const bool own_names =
        f->model == GP_COLOUR_RGB ||
        (f->model == GP_COLOUR_GREY && is_grey(planes, gp_frame_pixels(f)));
    GP_TRY(make_room(log, f->channels + 3, out));
    for (int i = 0; i < f->channels; i++) {
        const struct gp_channel *c = &f->channel[i];
        if (c->colour < 0) {
            out->source[out->sources++] = (struct gp_exr_source) {
                .name = c->name, .type = c->type, .xs = c->xs, .ys = c->ys,
                .linear = c->linear, .columns = c->w, .data = c->data,
            };
            continue;
        }
        like = c;
        if (own_names)
            add_colour(out, c->name, f, planes->c[c->colour], type, c->linear);
    }
    if (!like)
        GP_TRY(gp_fail(log, GP_ERR_BUG, "%s: no colour channel", f->path));
    for (int c = 0; c < 3; c++) {
        if (is_missing(f, planes, own_names, c))
            GP_TRY(add_made(log, out, like, c, f, planes->c[c], type));
    }
    gp_exr_sort(out->source, out->sources);
    GP_TRY(check_names(log, f, out));
    return GP_OK;
out:
    gp_exr_sources_free(out);
    return st;
}

void gp_exr_sources_free(struct gp_exr_sources *s)
{
    for (int c = 0; c < 3; c++)
        free(s->made[c]);
    gp_free(s->source);
    *s = (struct gp_exr_sources) {0};
}
