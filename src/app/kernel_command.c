#include "app/kernel_command.h"

#include "app/clobber.h"
#include "app/options.h"
#include "app/stages.h"
#include "core/colour.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/kernel_check.h"
#include "glare/sensors.h"
#include "io/plane.h"
#include "io/read.h"
#include "io/write.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// -- the recipe ---------------------------------------------------------------

/* All that a kernel is made of, as its file's attributes say. */
struct making {
    struct gp_wanted_kernel wanted; // images included
    double fov;                     // degrees, of the frame's height
    int w, h, radius;               // frame; most of an offset, 0: all
    double rotate;
    int frame;
};

static struct gp_field field_of(const struct making *m)
{
    const int most = m->radius ? m->radius + 1 : INT32_MAX;
    return (struct gp_field) {
        .w = gp_min(m->w, most), .h = gp_min(m->h, most),
        .degrees = m->fov / m->h, .aspect = 1.0, .rotate = m->rotate,
        .chromaticities = gp_rec709_chromaticities,
        .luminance = gp_rec709_luminance, .frame = m->frame, .fps = 24.0,
    };
}

static gp_status making_of_settings(const struct gp_log *log,
    const struct gp_settings *s, struct making *m)
{
    m->fov = s->fov > 0.0f ? (double) s->fov : GP_USUAL_FOV;
    m->rotate = (double) s->kernel.rotate;
    m->w = s->making.w;
    m->h = s->making.h;
    m->radius = s->making.radius;
    m->frame = s->making.frame;
    return gp_wanted_kernel_read(log, s, &m->wanted);
}

// -- attributes ---------------------------------------------------------------

enum { ATTRIBUTES = GP_RECIPES + 5, VALUE_BYTES = 32 };

/* Texts for a kernel's file. */
struct labels {
    struct gp_attribute at[ATTRIBUTES]; // names and texts owned
    int n;
};

static void free_labels(struct labels *l)
{
    for (int i = 0; i < l->n; i++) {
        gp_free(l->at[i].name);
        gp_free(l->at[i].text);
    }
}

/* The name of the i-th recipe's attribute: glarepp:recipe, glarepp:recipe2. */
static void recipe_name(int i, char name[VALUE_BYTES])
{
    snprintf(name, VALUE_BYTES, i ? "glarepp:recipe%d" : "glarepp:recipe",
             i + 1);
}

static gp_status add_text(const struct gp_log *log, struct labels *l,
                          const char *name, const char *text)
{
    const struct gp_attribute a = {
        .name = gp_strdup(name), .kind = GP_ATTRIBUTE_TEXT,
        .text = text ? gp_strdup(text) : NULL,
    };
    l->at[l->n++] = a;
    return a.name && a.text ? GP_OK : gp_no_memory(log, "kernel");
}

static gp_status add_number(const struct gp_log *log, struct labels *l,
                            const char *name, double v)
{
    char text[VALUE_BYTES];
    snprintf(text, sizeof text, "%.17g", v);
    return add_text(log, l, name, text);
}

static gp_status label(const struct gp_log *log, const struct making *m,
                       double left_out, struct labels *l)
{
    char text[VALUE_BYTES];
    gp_status st = GP_OK;
    for (int i = 0; i < m->wanted.recipes && !st; i++) {
        char *const recipe = gp_recipe_text(&m->wanted.recipe[i]);
        recipe_name(i, text);
        st = add_text(log, l, text, recipe);
        gp_free(recipe);
    }
    if (st)
        return st;
    GP_TRY(add_number(log, l, "glarepp:fov", m->fov));
    snprintf(text, sizeof text, "%dx%d,%d", m->w, m->h, m->radius);
    GP_TRY(add_text(log, l, "glarepp:size", text));
    GP_TRY(add_number(log, l, "glarepp:rotate", m->rotate));
    GP_TRY(add_number(log, l, "glarepp:frame", m->frame));
    GP_TRY(add_number(log, l, "glarepp:left_out", left_out));
out:
    return st;
}

/* A number that add_number() wrote. */
static bool find_number(const struct gp_frame *f, const char *name, double *v)
{
    char *const text = gp_frame_text(f, name);
    char *end = NULL;
    if (text)
        *v = strtod(text, &end);
    const bool found = text && end != text && !*end && isfinite(*v);
    gp_free(text);
    return found;
}

/* Reads the attributes of a kernel's file. */
static gp_status making_of_file(const struct gp_log *log,
    const struct gp_settings *s, const char *path, const struct gp_frame *f,
    struct making *m)
{
    const struct gp_read_params limits = gp_read_limits(&s->read);
    struct gp_wanted_kernel *const wanted = &m->wanted;
    char name[VALUE_BYTES];
    double frame = 0.0;
    gp_status st = GP_OK;
    for (int i = 0; i < GP_RECIPES && !st; i++) {
        recipe_name(i, name);
        char *const text = gp_frame_text(f, name);
        if (!text)
            break;
        st = gp_recipe_parse(log, text, &wanted->recipe[i]);
        wanted->recipes += !st;
        gp_free(text);
    }
    if (st)
        return st;
    char *const size = gp_frame_text(f, "glarepp:size");
    int v[3] = {0};
    const bool sized = size && gp_read_whole(size, "x,", v) && v[0] > 0 &&
                       v[1] > 0 && v[0] <= 16384 && v[1] <= 16384;
    gp_free(size);
    m->w = v[0];
    m->h = v[1];
    m->radius = v[2];
    if (!wanted->recipes || !sized || !find_number(f, "glarepp:fov", &m->fov) ||
        !find_number(f, "glarepp:rotate", &m->rotate) ||
        !find_number(f, "glarepp:frame", &frame) || fabs(frame) > 1e9)
        return gp_fail(log, GP_ERR_DATA, "%s: does not say how it was made "
                       "(no %s, or damaged); use a file of glarepp kernel",
                       path, wanted->recipes
                                 ? "whole glarepp:size, fov, rotate and frame"
                                 : "glarepp:recipe");
    m->frame = (int) frame;
    return gp_wanted_images_read(log, &limits, wanted);
}

// -- -o -----------------------------------------------------------------------

/* Makes a frame of the kernel, whose centre is pixel (floor(w/2),
 * floor(h/2)): with the zero borders that make it symmetric. */
static gp_status frame_of(const struct gp_log *log, const struct gp_kernel *k,
                          struct gp_frame *f)
{
    const int rx = gp_max(abs(k->cx), abs(k->w - 1 - k->cx));
    const int ry = gp_max(abs(k->cy), abs(k->h - 1 - k->cy));
    const size_t w = 2 * (size_t) rx + 1, h = 2 * (size_t) ry + 1;
    gp_status st = gp_planes_make(log, "kernel", w * h, &f->rgb);
    if (st)
        return st;
    f->data = f->display = (struct gp_rect) {0, 0, (int) w, (int) h};
    f->pixel_aspect = 1.0f;
    f->colour_type = GP_FLOAT;
    f->parts = 1;
    memcpy(f->chromaticities, gp_rec709_chromaticities,
           sizeof f->chromaticities);
    memcpy(f->luminance, gp_rec709_luminance, sizeof f->luminance);
    for (int c = 0; c < 3; c++) {
        memset(f->rgb.c[c], 0, w * h * sizeof(float));
        for (int y = 0; y < k->h; y++)
            memcpy(f->rgb.c[c] + (size_t) (y + ry - k->cy) * w +
                       (size_t) (rx - k->cx),
                   k->k.c[c] + (size_t) y * (size_t) k->w,
                   (size_t) k->w * sizeof(float));
    }
    return GP_OK;
}

/* Makes the kernel at full rate, as far as it was asked for, of `most` pixels;
 * `name` for messages. */
static gp_status make_kernel(const struct gp_log *log, const char *name,
    const struct making *m, long long most, struct gp_kernel *out)
{
    struct gp_kernel k = {0};
    const struct gp_field field = field_of(m);
    const long long w = 2LL * field.w - 1, h = 2LL * field.h - 1;
    if (w * h > most)
        return gp_fail(log, GP_ERR_DATA, "%s: the kernel is too large (%lldx"
                       "%lld, at most %lld pixels); give a smaller --size, a "
                       "--radius, or raise --max-pixels", name, w, h, most);
    gp_status st = gp_model_kernel(log, m->wanted.recipe, m->wanted.recipes,
                                   &field, &k);
    if (!st)
        st = gp_kernel_whole(log, &k, field.w, field.h, out);
    gp_kernel_free(&k);
    return st;
}

static struct gp_clobber_owner output_owner(const void *user,
    const struct gp_clobber_file *file)
{
    const struct gp_settings *const s = user;
    const char *const path = s->outputs.at[file->item];
    return (struct gp_clobber_owner) {.name = strdup(path), .what = "-o",
                                      .as = path};
}

static gp_status write_kernel(const struct gp_log *log,
                              const struct gp_settings *s)
{
    gp_status st;
    struct making m = {0};
    struct gp_kernel k = {0};
    struct gp_frame f = {0}, from = {0};
    struct gp_write_params write = s->write;
    struct gp_write_stats stats = {0};
    struct gp_clobber clobber = {0};
    struct labels labels = {.n = 0};
    const struct gp_read_params limits = gp_read_limits(&s->read);
    write.type = GP_OUT_FLOAT;
    GP_TRY(gp_clobber_begin(log, s, output_owner, s, &clobber));
    for (int i = 0; i < s->outputs.n; i++) {
        GP_TRY(gp_write_hdr_check(log, &write, s->outputs.at[i]));
        GP_TRY(gp_clobber_output(&clobber, s->outputs.at[i], 0, i));
    }
    GP_TRY(gp_clobber_settle(&clobber));
    if (s->making.from)
        GP_TRY(gp_read_frame(log, &limits, s->making.from, &from));
    GP_TRY(s->making.from
               ? making_of_file(log, s, s->making.from, &from, &m)
               : making_of_settings(log, s, &m));
    GP_TRY(make_kernel(log, s->outputs.at[0], &m, s->read.max_pixels, &k));
    GP_TRY(frame_of(log, &k, &f));
    GP_TRY(label(log, &m, k.left_out, &labels));
    write.added = labels.at;
    write.n_added = labels.n;
    for (int i = 0; i < s->outputs.n; i++)
        GP_TRY(gp_write_picture(log, &write, s->outputs.at[i], &f, &f.rgb,
                                GP_PICTURE_SCENE, &stats));
    gp_say(log, GP_LEVEL_INFO, "%s: %dx%d, %g degrees a pixel, left out %.3g",
           s->outputs.at[0], gp_frame_w(&f), gp_frame_h(&f), m.fov / m.h,
           k.left_out);
out:
    gp_clobber_end(&clobber);
    free_labels(&labels);
    gp_wanted_kernel_free(&m.wanted);
    gp_kernel_free(&k);
    gp_frame_free(&f);
    gp_frame_free(&from);
    return st;
}

// -- --list -------------------------------------------------------------------

static gp_status end_print(const struct gp_log *log)
{
    if (fflush(stdout) == 0 && !ferror(stdout))
        return GP_OK;
    return gp_fail(log, GP_ERR_IO, "-: cannot write to stdout (%s); check the "
                   "program that reads it", strerror(errno));
}

static void print_key(const struct gp_model_key *k)
{
    char range[256];
    int used;
    if (k->file) {
        snprintf(range, sizeof range, "a path");
    } else if (k->words) {
        used = snprintf(range, sizeof range, "%s", k->words[0]);
        for (int i = 1; k->words[i] && used < (int) sizeof range; i++)
            used += snprintf(range + used, sizeof range - (size_t) used, "|%s",
                             k->words[i]);
    } else {
        snprintf(range, sizeof range, "%g to %g", k->lo, k->hi);
    }
    if (k->file)
        printf("  %s=PATH\n", k->name);
    else if (k->words)
        printf("  %s=%s (%s)\n", k->name, k->words[(int) k->preset], range);
    else
        printf("  %s=%g (%s)\n", k->name, k->preset, range);
    printf("      %s\n", k->text);
}

static gp_status list_models(const struct gp_log *log)
{
    printf("Models: -k MODEL:key=value,key=value\n");
    for (int i = 0; gp_models[i]; i++) {
        const struct gp_model_key *const keys = gp_model_keys(gp_models[i]);
        printf("\n%s: %s\n  (%s)\n", gp_model_name(gp_models[i]),
               gp_model_text(gp_models[i]), gp_model_source(gp_models[i]));
        for (int k = 0; keys[k].name; k++)
            print_key(&keys[k]);
    }
    printf("\nPresets: -k builtin:NAME\n\n");
    for (const struct gp_model_preset *p = gp_model_presets; p->name; p++)
        printf("  %-10s %s\n  %-10s %s\n", p->name, p->text, "", p->recipe);
    return end_print(log);
}

// -- --check ------------------------------------------------------------------

/* A kernel and the frame to check it for. */
struct checked {
    struct gp_kernel k;
    long long nonfinite;    // samples; then `k` is empty
    const char *name;
    float luminance[3];
    struct gp_kernel_use use;
};

static gp_status check_of_model(const struct gp_log *log,
                                const struct gp_settings *s, struct checked *c)
{
    struct making m = {0};
    struct gp_settings own = *s;
    own.kernels = (struct gp_texts) {(const char **) &c->name, 1};
    gp_status st = making_of_settings(log, &own, &m);
    if (!st)
        st = make_kernel(log, c->name, &m, s->read.max_pixels, &c->k);
    gp_wanted_kernel_free(&m.wanted);
    memcpy(c->luminance, gp_rec709_luminance, sizeof c->luminance);
    c->use.ends = m.radius > 0;
    return st;
}

static gp_status check_of_file(const struct gp_log *log,
                               const struct gp_settings *s, struct checked *c)
{
    const struct gp_read_params limits = gp_read_limits(&s->read);
    const struct gp_kernel_params p = {
        .normalize = GP_NORMALIZE_NONE, .rotate = s->kernel.rotate,
        .scale = s->kernel_percent / 100.0,
    };
    struct gp_frame f;
    gp_status st = gp_read_frame(log, &limits, c->name, &f);
    if (st)
        return st;
    for (int i = 0; i < 3; i++) {
        for (size_t j = 0; j < gp_frame_pixels(&f); j++)
            c->nonfinite += !isfinite(f.rgb.c[i][j]);
    }
    memcpy(c->luminance, f.luminance, sizeof c->luminance);
    c->use.ends = true;
    if (!c->nonfinite)
        st = gp_kernel_from_frame(log, &p, &f, &c->k);
    if (!st)
        find_number(&f, "glarepp:left_out", &c->k.left_out);
    gp_frame_free(&f);
    return st;
}

/* The brightest source of a frame. */
static gp_status find_brightest(const struct gp_log *log,
    const struct gp_settings *s, const char *path, double *out)
{
    const struct gp_read_params limits = gp_read_limits(&s->read);
    struct gp_frame f;
    struct gp_sources src;
    gp_status st = gp_read_frame(log, &limits, path, &f);
    if (st)
        return st;
    st = gp_sense(log, &s->sensor, &f, &src);
    if (!st) {
        *out = (double) src.brightest;
        gp_sources_free(&src);
    }
    gp_frame_free(&f);
    return st;
}

static void print_figures(const struct checked *c,
                          const struct gp_kernel_figures *f)
{
    const struct gp_kernel *const k = &c->k;
    printf("size       %dx%d, centre %d,%d\n", k->w, k->h, k->cx, k->cy);
    printf("sum        %.7g %.7g %.7g, luminance %.7g\n", k->sum[0], k->sum[1],
           k->sum[2], f->light);
    printf("peak       %.7g at %d,%d\n", f->peak, f->peak_at[0],
           f->peak_at[1]);
    printf("centroid   %.4f,%.4f\n", round(1e4 * f->centroid[0]) / 1e4 + 0.0,
           round(1e4 * f->centroid[1]) / 1e4 + 0.0);
    printf("own pixel  %.4g %%\n", 100.0 * f->own);
    printf("border     %.3g %%, drops by %.3g\n", 100.0 * f->border, f->rim);
    printf("negatives  %lld\n", f->negatives);
    printf("asymmetry  %.3g\n", f->asymmetry);
    printf("left out   %.3g %%\n", 100.0 * f->left_out);
}

/* Prints figures and faults, for a source of 1000 where no frame is given. */
static gp_status check_kernel(const struct gp_log *log,
                              const struct gp_settings *s, bool *faulty)
{
    struct checked c = {
        .name = s->making.check,
        .use = {.add = s->compose.mix == GP_MIX_ADD, .brightest = 1000.0},
    };
    struct gp_kernel_figures f;
    char line[GP_FAULT_BYTES];
    gp_status st = gp_recipe_is(c.name) ? check_of_model(log, s, &c)
                                        : check_of_file(log, s, &c);
    if (!st && s->inputs.n)
        st = find_brightest(log, s, s->inputs.at[0], &c.use.brightest);
    if (st)
        goto out;
    *faulty = c.nonfinite > 0;
    printf("kernel     %s\n", gp_printable(c.name).text);
    if (c.nonfinite) {
        printf("fault: %lld samples are NaN or infinite; replace them\n",
               c.nonfinite);
    } else {
        gp_kernel_measure(&c.k, c.luminance, &f);
        print_figures(&c, &f);
        f.rim /= f.light > 0.0 ? f.light : 1.0; // as a run normalises it
        f.centre /= f.light > 0.0 ? f.light : 1.0;
        for (int i = 0; i < GP_KERNEL_FAULTS; i++) {
            if (!gp_kernel_fault(&f, &c.use, i, line))
                continue;
            printf("fault: %s\n", gp_printable(line).text);
            *faulty = true;
        }
    }
    st = end_print(log);
out:
    gp_kernel_free(&c.k);
    return st;
}

gp_status gp_kernel_command(const struct gp_log *log,
                            const struct gp_settings *s, bool *faulty)
{
    *faulty = false;
    return s->making.list    ? list_models(log)
           : s->making.check ? check_kernel(log, s, faulty)
                             : write_kernel(log, s);
}
