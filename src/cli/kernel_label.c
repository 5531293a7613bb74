#include "cli/kernel_label.h"

#include "cli/options.h"
#include "core/memory.h"
#include "io/plane.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { VALUE_BYTES = 40 };

// -- writing ------------------------------------------------------------------

/* The name of the i-th recipe's attribute: glarepp:recipe, glarepp:recipe2. */
static void recipe_name(int i, char name[VALUE_BYTES])
{
    snprintf(name, VALUE_BYTES, i ? "glarepp:recipe%d" : "glarepp:recipe",
             i + 1);
}

static gp_status add_text(const struct gp_log *log, struct gp_label_texts *l,
                          const char *name, const char *text)
{
    const struct gp_attribute a = {
        .name = gp_strdup(name), .kind = GP_ATTRIBUTE_TEXT,
        .text = text ? gp_strdup(text) : NULL,
    };
    l->at[l->n++] = a;
    return a.name && a.text ? GP_OK : gp_no_memory(log, "kernel");
}

static gp_status add_number(const struct gp_log *log, struct gp_label_texts *l,
                            const char *name, double v)
{
    char text[VALUE_BYTES];
    snprintf(text, sizeof text, "%.17g", v);
    return add_text(log, l, name, text);
}

gp_status gp_label_write(const struct gp_log *log,
    const struct gp_file_label *l, const char *const *recipe, int n,
    struct gp_label_texts *out)
{
    char text[VALUE_BYTES];
    gp_status st = GP_OK;
    for (int i = 0; i < n && !st; i++) {
        recipe_name(i, text);
        st = add_text(log, out, text, recipe[i]);
    }
    const struct gp_option_choice *c = gp_compressions;
    while (c->name && c->value != (int) l->compression)
        c++;
    GP_TRY(st);
    GP_TRY(add_number(log, out, "glarepp:fov", l->fov));
    snprintf(text, sizeof text, "%dx%d,%d", l->w, l->h, l->radius);
    GP_TRY(add_text(log, out, "glarepp:size", text));
    GP_TRY(add_number(log, out, "glarepp:rotate", l->rotate));
    GP_TRY(add_number(log, out, "glarepp:frame", l->frame));
    GP_TRY(add_text(log, out, "glarepp:compression", c->name));
    GP_TRY(add_number(log, out, "glarepp:left_out", l->left_out));
    GP_TRY(add_number(log, out, "glarepp:beyond", l->beyond));
out:
    return st;
}

void gp_label_texts_free(struct gp_label_texts *t)
{
    for (int i = 0; i < t->n; i++) {
        gp_free(t->at[i].name);
        gp_free(t->at[i].text);
    }
    t->n = 0;
}

// -- reading ------------------------------------------------------------------

/* Reads a number in [lo, hi] that add_number() wrote. */
static bool read_number(const struct gp_frame *f, const char *name, double lo,
                        double hi, double *v)
{
    char *const text = gp_frame_text(f, name);
    char *end = NULL;
    if (text)
        *v = strtod(text, &end);
    const bool good = text && end != text && !*end && *v >= lo && *v <= hi;
    gp_free(text);
    return good;
}

/* Reads a number in the range of an option. */
static bool read_option(const struct gp_frame *f, const char *name,
                        const char *option, double *v)
{
    const struct gp_option *const o = gp_option_find(option, strlen(option));
    return read_number(f, name, o->lo, o->hi, v);
}

static struct gp_file_label read_label(const struct gp_frame *f)
{
    struct gp_file_label l = {.present = true};
    const double slack = 1e-3; // sums of floats
    double frame = 0.0;
    int v[3] = {0};
    char *const size = gp_frame_text(f, "glarepp:size");
    const bool sized = size && gp_read_whole(size, "x,", v) && v[0] > 0 &&
                       v[1] > 0 && v[0] <= 16384 && v[1] <= 16384 &&
                       v[2] < 16384;
    gp_free(size);
    l.w = v[0];
    l.h = v[1];
    l.radius = v[2];
    if (!sized || !read_option(f, "glarepp:fov", "fov", &l.fov) ||
        !read_option(f, "glarepp:rotate", "rotate", &l.rotate) ||
        !read_option(f, "glarepp:frame", "frame", &frame) ||
        !read_number(f, "glarepp:left_out", -slack, 1.0 + slack, &l.left_out) ||
        !read_number(f, "glarepp:beyond", -slack, 1.0 + slack, &l.beyond))
        return (struct gp_file_label) {.present = false};
    l.frame = (int) frame;
    return l;
}

/* Checks the recipes, and adds up their shares. Their images are not read: the
 * samples are in the file. */
static gp_status read_recipes(const struct gp_log *log, struct glarepp *quiet,
                              const struct gp_frame *f, double *share)
{
    gp_status st = GP_OK;
    for (int i = 0; i < GP_LABEL_RECIPES && !st; i++) {
        char name[VALUE_BYTES];
        struct glarepp_kernel_params p = GLAREPP_KERNEL_PARAMS;
        struct glarepp_kernel *k;
        recipe_name(i, name);
        char *const text = gp_frame_text(f, name);
        const char *const word[] = {text};
        if (!text)
            break;
        p.word = word;
        p.words = 1;
        p.unread = true;
        st = (gp_status) glarepp_kernel(quiet, &p, &k);
        if (st)
            st = gp_fail(log, st == GP_ERR_BUG ? st : GP_ERR_DATA,
                         "%s: %s: %s", f->path, name, glarepp_error()->text);
        else
            *share += glarepp_kernel_share(k);
        glarepp_kernel_end(&k);
        gp_free(text);
    }
    *share = fmin(*share, 1.0);
    return st;
}

gp_status gp_label_read(const struct gp_log *log, const struct gp_frame *f,
                        struct gp_file_label *out)
{
    const struct glarepp_params params = {.size = sizeof params, .threads = 1};
    struct glarepp *quiet = NULL;
    gp_status st = GP_OK;
    char *const first = gp_frame_text(f, "glarepp:recipe");
    *out = first ? read_label(f) : (struct gp_file_label) {.present = false};
    if (first)
        st = (gp_status) glarepp_open(&params, &quiet);
    if (first && !st)
        st = read_recipes(log, quiet, f, &out->share);
    glarepp_close(&quiet);
    gp_free(first);
    return st;
}

struct glarepp_label gp_label_of(const struct gp_file_label *l)
{
    return (struct glarepp_label) {
        .present = l->present, .w = l->w, .h = l->h, .fov = l->fov,
        .left_out = l->left_out, .beyond = l->beyond, .share = l->share,
    };
}
