#include "app/kernel_label.h"

#include "app/options.h"
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
    const struct gp_kernel_label *l, const struct gp_recipe *r, int n,
    struct gp_label_texts *out)
{
    char text[VALUE_BYTES];
    gp_status st = GP_OK;
    for (int i = 0; i < n && !st; i++) {
        char *const recipe = gp_recipe_text(&r[i]);
        recipe_name(i, text);
        st = add_text(log, out, text, recipe);
        gp_free(recipe);
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

static struct gp_kernel_label read_label(const struct gp_frame *f)
{
    struct gp_kernel_label l = {.present = true};
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
        return (struct gp_kernel_label) {.present = false};
    l.frame = (int) frame;
    return l;
}

/* The file and attribute that a message is about. */
struct place {
    const struct gp_log *log;
    const char *path, *attribute;
};

static void put_place_first(void *user, const struct gp_line *line)
{
    const struct place *const p = user;
    if (line->level == GP_LEVEL_ERROR || line->level == GP_LEVEL_BARE)
        (void) gp_fail_at(p->log, GP_ERR_DATA, line->parameter, "%s: %s: %s",
                          p->path, p->attribute, line->text);
}

/* Reads the recipes, up to GP_RECIPES, to r; *n counts them, also on failure. */
static gp_status read_recipes(const struct gp_log *log,
    const struct gp_frame *f, struct gp_recipe *r, int *n)
{
    gp_status st = GP_OK;
    for (*n = 0; *n < GP_RECIPES && !st;) {
        char name[VALUE_BYTES];
        struct place place = {log, f->path, name};
        const struct gp_log placed = {put_place_first, &place, GP_LEVEL_WARN};
        recipe_name(*n, name);
        char *const text = gp_frame_text(f, name);
        if (!text)
            break;
        st = gp_recipe_parse(&placed, text, &r[*n]);
        *n += !st;
        gp_free(text);
    }
    return st == GP_ERR_USAGE ? GP_ERR_DATA : st;
}

gp_status gp_label_read(const struct gp_log *log, const struct gp_frame *f,
                        struct gp_kernel_label *out)
{
    struct gp_recipe r[GP_RECIPES];
    int n = 0;
    gp_status st = GP_OK;
    char *const first = gp_frame_text(f, "glarepp:recipe");
    *out = first ? read_label(f) : (struct gp_kernel_label) {.present = false};
    if (first)
        st = read_recipes(log, f, r, &n);
    gp_free(first);
    while (n > 0) {
        out->share = fmin(out->share + r[--n].value[0], 1.0);
        gp_recipe_free(&r[n]);
    }
    return st;
}

// -- use ----------------------------------------------------------------------

void gp_label_use(const struct gp_kernel_label *l, double scale,
                  const struct gp_kernel *k, int w, int h,
                  struct gp_kernel_use *use)
{
    const bool covers = k->w >= 2LL * w - 1 && k->h >= 2LL * h - 1;
    const bool fits = w <= ceil(l->w * scale) && h <= ceil(l->h * scale);
    use->as_it_is = l->present;
    use->missed = l->present && !covers
                      ? fmax(l->left_out - (fits ? l->beyond : 0.0), 0.0)
                      : 0.0;
    use->ends = l->present ? use->missed > 1e-5 : !covers;
}
