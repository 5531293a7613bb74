#include "io/exr/exr_priv.h"

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

/* The frame that has all channels of the part. */
static const struct gp_frame *whole_frame(const struct gp_hdr_colour *set,
                                          int n)
{
    const struct gp_frame *whole = set[0].f;
    for (int i = 1; i < n; i++) {
        if (set[i].f->channels > whole->channels)
            whole = set[i].f;
    }
    return whole;
}

/* The names of all colour channels of the frames: a file may have very many
 * other channels, and each is looked up once. */
struct colours {
    const char **name;  // room for three a frame
    int n;
};

static gp_status list_colours(const struct gp_log *log,
                              const struct gp_hdr_colour *set, int n,
                              struct colours *out)
{
    void *name;
    gp_status st = gp_alloc(log, "colours", 3 * (size_t) n, sizeof(char *),
                            &name);
    *out = (struct colours) {.name = name};
    for (int i = 0; !st && i < n; i++) {
        const struct gp_frame *f = set[i].f;
        for (int k = 0, had = 0; k < f->channels && had < 3; k++) {
            if (f->channel[k].colour < 0)
                continue;
            out->name[out->n++] = f->channel[k].name;
            had++;
        }
    }
    return st;
}

/* How many of the frames have that channel as colour. */
static int owners(const struct colours *colours, const char *name)
{
    int found = 0;
    for (int i = 0; i < colours->n; i++)
        found += strcmp(colours->name[i], name) == 0;
    return found;
}

/* True when a channel of that name will be there that f does not replace. */
static bool is_taken(const struct gp_hdr_colour *set, int n,
                     const struct gp_frame *f, const char *name)
{
    const struct gp_channel *own = gp_frame_channel(f, name);
    return gp_frame_channel(whole_frame(set, n), name) &&
           !(own && own->colour >= 0);
}

/* The name of colour c beside a channel `like`; in a layer of that name when
 * `layered`. From malloc. */
static char *name_beside(const char *like, bool layered, int c)
{
    static const char letter[3] = {'R', 'G', 'B'};
    if (!layered)
        return gp_colour_name(like, c);
    const size_t n = strlen(like);
    char *made = malloc(n + 3);
    if (made) {
        memcpy(made, like, n);
        made[n] = '.';
        made[n + 1] = letter[c];
        made[n + 2] = '\0';
    }
    return made;
}

/* Whether names beside `like`, which is called after what it shows and has no
 * layer, need one. Y is luminance and no layer's name. */
static gp_status needs_layer(const struct gp_log *log,
                             const struct gp_hdr_colour *set, int n,
                             const struct gp_frame *f,
                             const struct gp_channel *like, bool *out)
{
    *out = false;
    if (f->model != GP_COLOUR_GREY || gp_layer_length(like->name) > 0 ||
        strcmp(like->name, "Y") == 0)
        return GP_OK;
    for (int c = 0; c < 3; c++) {
        char *name = name_beside(like->name, false, c);
        if (!name)
            return gp_fail_bare(log, GP_ERR_BUG, "channels: out of memory");
        *out |= is_taken(set, n, f, name);
        free(name);
    }
    return GP_OK;
}

/* Colour c of set[i] under a name that the part does not have. */
static gp_status add_made(const struct gp_log *log, struct gp_exr_sources *s,
                          const struct gp_hdr_colour *set, int n, int i,
                          const struct gp_channel *like, int c,
                          enum gp_pixel_type type)
{
    const struct gp_frame *f = set[i].f;
    bool layered;
    gp_status st = needs_layer(log, set, n, f, like, &layered);
    if (st)
        return st;
    char *const name = name_beside(like->name, layered, c);
    if (!name)
        return gp_fail_bare(log, GP_ERR_BUG, "channels: out of memory");
    s->made[s->mades++] = name;
    if (is_taken(set, n, f, name))
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the glare has a colour that needs a channel %s, "
                       "and the file has another one of that name; rename it",
                       f->path, name);
    add_colour(s, name, f, set[i].planes->c[c], type, like->linear);
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

/* What no frame has as colour. */
static gp_status add_carried(const struct gp_log *log,
                             const struct gp_frame *whole,
                             const struct colours *all,
                             struct gp_exr_sources *out)
{
    for (int i = 0; i < whole->channels; i++) {
        const struct gp_channel *c = &whole->channel[i];
        const int colours = owners(all, c->name);
        if (colours > 1)
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: channel %s is the colour of %d layers; name "
                           "each layer once", whole->path, c->name, colours);
        if (colours == 1)
            continue;
        if (!c->data)
            return gp_fail(log, GP_ERR_BUG, "%s: channel %s has no samples",
                           whole->path, c->name);
        out->source[out->sources++] = (struct gp_exr_source) {
            .name = c->name, .type = c->type, .xs = c->xs, .ys = c->ys,
            .linear = c->linear, .columns = c->w, .data = c->data,
        };
    }
    return GP_OK;
}

/* The colour of set[i]. */
static gp_status add_set(const struct gp_log *log,
                         const struct gp_write_params *p,
                         const struct gp_hdr_colour *set, int n, int i,
                         struct gp_exr_sources *out)
{
    const struct gp_frame *f = set[i].f;
    const struct gp_planes *planes = set[i].planes;
    const enum gp_pixel_type type = gp_exr_colour_type(p, f);
    const struct gp_channel *like = NULL; // a colour channel of the input
    const bool own_names =
        f->model == GP_COLOUR_RGB ||
        (f->model == GP_COLOUR_GREY && is_grey(planes, gp_frame_pixels(f)));
    for (int k = 0; k < f->channels; k++) {
        const struct gp_channel *c = &f->channel[k];
        if (c->colour < 0)
            continue;
        like = c;
        if (own_names)
            add_colour(out, c->name, f, planes->c[c->colour], type, c->linear);
    }
    if (!like)
        return gp_fail(log, GP_ERR_BUG, "%s: no colour channel", f->path);
    for (int c = 0; c < 3; c++) {
        if (!is_missing(f, planes, own_names, c))
            continue;
        gp_status st = add_made(log, out, set, n, i, like, c, type);
        if (st)
            return st;
    }
    return GP_OK;
}

gp_status gp_exr_sources_hdr(const struct gp_log *log,
                             const struct gp_write_params *p,
                             const struct gp_hdr_colour *set, int n,
                             struct gp_exr_sources *out)
{
    gp_status st;
    void *made = NULL;
    struct colours colours = {0};
    const struct gp_frame *whole = whole_frame(set, n);
    GP_TRY(make_room(log, whole->channels + 3 * n, out));
    GP_TRY(list_colours(log, set, n, &colours));
    GP_TRY(gp_alloc_zero(log, "channels", 3 * (size_t) n, sizeof *out->made,
                         &made));
    out->made = made;
    GP_TRY(add_carried(log, whole, &colours, out));
    for (int i = 0; i < n; i++)
        GP_TRY(add_set(log, p, set, n, i, out));
    gp_exr_sort(out->source, out->sources);
    GP_TRY(check_names(log, set[0].f, out));
out:
    gp_free(colours.name);
    if (st)
        gp_exr_sources_free(out);
    return st;
}

void gp_exr_sources_free(struct gp_exr_sources *s)
{
    for (int i = 0; i < s->mades; i++)
        free(s->made[i]);
    gp_free(s->made);
    gp_free(s->source);
    *s = (struct gp_exr_sources) {0};
}
