#include "app/commands.h"

#include "app/clobber.h"
#include "app/hints.h"
#include "app/kernel_label.h"
#include "app/options.h"
#include "app/stages.h"
#include "core/colour.h"
#include "core/minmax.h"
#include "glare/kernel_check.h"
#include "glare/sensors.h"
#include "io/file.h"
#include "io/read.h"
#include "io/write.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// -- making -------------------------------------------------------------------

/* All that a kernel is made of, as its file's attributes say. */
struct making {
    struct gp_wanted_kernel wanted; // images included
    struct gp_kernel_label label;
};

static struct gp_field field_of(const struct gp_kernel_label *l)
{
    return (struct gp_field) {
        .w = l->w, .h = l->h, .degrees = l->fov / l->h, .aspect = 1.0,
        .rotate = l->rotate, .chromaticities = gp_rec709_chromaticities,
        .luminance = gp_rec709_luminance, .frame = l->frame, .fps = 24.0,
    };
}

static gp_status making_of_settings(const struct gp_log *log,
    const struct gp_settings *s, struct making *m)
{
    m->label = (struct gp_kernel_label) {
        .present = true, .w = s->making.w, .h = s->making.h,
        .radius = s->making.radius,
        .fov = s->kernel.fov > 0.0f ? (double) s->kernel.fov : GP_USUAL_FOV,
        .rotate = (double) s->kernel.image.rotate, .frame = s->making.frame,
        .compression = s->output.write.compression,
    };
    return gp_wanted_kernel_read(log, s, &m->wanted);
}

/* Makes the kernel at full rate, as far as it was asked for, of `most` pixels;
 * sets the label's left_out and beyond. `name` for messages. */
static gp_status make_kernel(const struct gp_log *log, const char *name,
    struct making *m, long long most, struct gp_kernel *out)
{
    struct gp_kernel_label *const l = &m->label;
    struct gp_kernel k = {0};
    struct gp_field field = field_of(l);
    const int reach = l->radius ? l->radius + 1 : INT_MAX;
    const int cut_w = gp_min(l->w, reach), cut_h = gp_min(l->h, reach);
    const long long w = 2LL * cut_w - 1, h = 2LL * cut_h - 1;
    if (w * h > most)
        return gp_fail(log, GP_ERR_DATA, "%s: the kernel is too large (%lldx"
                       "%lld, at most %lld pixels); give a smaller --size, a "
                       "--radius, or raise --max-pixels", name, w, h, most);
    // for the whole frame, to know what falls outside of it; where that is too
    // large itself, all light counts as falling inside
    const bool whole = (2LL * l->w - 1) * (2LL * l->h - 1) <= most;
    field.w = whole ? l->w : cut_w;
    field.h = whole ? l->h : cut_h;
    gp_status st = gp_model_kernel(log, m->wanted.recipe, m->wanted.recipes,
                                   &field, &k);
    if (!st)
        st = gp_kernel_whole(log, &k, cut_w, cut_h, out);
    l->left_out = st ? 0.0 : out->left_out;
    l->beyond = whole ? k.left_out : 0.0;
    gp_kernel_free(&k);
    return st;
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
    *f = gp_frame_blank((struct gp_rect) {0, 0, (int) w, (int) h});
    f->names_chromaticities = true;
    gp_status st = gp_planes_make(log, "kernel", w * h, &f->rgb);
    if (st)
        return st;
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

static gp_status write_kernel(const struct gp_log *log,
                              const struct gp_settings *s)
{
    gp_status st;
    struct making m = {0};
    struct gp_kernel k = {0};
    struct gp_frame f = {0};
    struct gp_write_params write = s->output.write;
    struct gp_write_stats stats = {0};
    struct gp_clobber clobber = {0};
    struct gp_label_texts labels = {.n = 0};
    static const char keeps[] = "-o of a kernel keeps floats and its recipe";
    write.type = GP_OUT_FLOAT;
    GP_TRY(gp_clobber_begin(log, s, &clobber));
    for (int i = 0; i < s->output.pictures.n; i++) {
        const char *const path = s->output.pictures.at[i];
        GP_TRY(gp_write_hdr_check(log, &write, keeps, path));
        GP_TRY(gp_clobber_add(&clobber, &(struct gp_clobber_output) {
            .name = path, .what = "-o", .as = path, .order = i}));
    }
    GP_TRY(gp_clobber_settle(&clobber));
    GP_TRY(making_of_settings(log, s, &m));
    for (int i = 0; i < m.wanted.recipes; i++) {
        if (m.wanted.recipe[i].image)
            GP_TRY(gp_clobber_input(&clobber, "image of the kernel",
                                    m.wanted.recipe[i].image->path));
    }
    GP_TRY(make_kernel(log, s->output.pictures.at[0], &m,
                       s->input.read.max_pixels, &k));
    GP_TRY(frame_of(log, &k, &f));
    GP_TRY(gp_label_write(log, &m.label, m.wanted.recipe, m.wanted.recipes,
                          &labels));
    write.compression = m.label.compression;
    write.added = labels.at;
    write.n_added = labels.n;
    for (int i = 0; i < s->output.pictures.n; i++)
        GP_TRY(gp_write_picture(log, &write, s->output.pictures.at[i], &f,
                                &f.rgb, GP_PICTURE_SCENE, &stats));
    gp_say(log, GP_LEVEL_INFO, "%s: %dx%d, %g degrees a pixel, left out %.3g",
           s->output.pictures.at[0], gp_frame_w(&f), gp_frame_h(&f),
           m.label.fov / m.label.h, k.left_out);
out:
    gp_clobber_end(&clobber);
    gp_label_texts_free(&labels);
    gp_wanted_kernel_free(&m.wanted);
    gp_kernel_free(&k);
    gp_frame_free(&f);
    return st;
}

// -- --list -------------------------------------------------------------------

/* Prints a key with its preset, then the values it takes and its text. */
static void print_key(const struct gp_model_key *k)
{
    char text[512] = "";
    int used = 0, column = printf("  %s=", k->name);
    for (int i = 0; k->words && k->words[i] && used < (int) sizeof text; i++)
        used += snprintf(text + used, sizeof text - (size_t) used, "%s%s",
                         k->words[i], k->words[i + 1] ? ", " : "; ");
    if (k->file)
        column += printf("PATH");
    else if (k->words)
        column += printf("%s", k->words[(int) k->preset]);
    else {
        column += printf("%.10g", k->preset);
        used = snprintf(text, sizeof text, "%.10g to %.10g; ", k->lo, k->hi);
    }
    snprintf(text + used, sizeof text - (size_t) used, "%s", k->text);
    gp_help_text(stdout, column, text);
}

static gp_status list_models(const struct gp_log *log)
{
    printf("Models: -k MODEL:key=value,key=value (keys with their defaults)\n");
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
    return gp_flush_text(log);
}

// -- --check ------------------------------------------------------------------

/* A kernel and the frame to check it for. */
struct checked {
    struct gp_kernel k;
    long long nonfinite;    // samples; where there are any, or none is `lit`,
    bool lit;               // other than 0, `k` is empty
    const char *name;
    struct gp_kernel_label label;
    float chromaticities[8], luminance[3];
    bool named;             // the chromaticities are
    struct gp_kernel_use use;
};

static gp_status check_of_model(const struct gp_log *log,
                                const struct gp_settings *s, struct checked *c)
{
    struct making m = {0};
    struct gp_settings own = *s;
    own.kernel.words = (struct gp_texts) {(const char **) &c->name, 1};
    gp_status st = making_of_settings(log, &own, &m);
    if (!st)
        st = make_kernel(log, c->name, &m, s->input.read.max_pixels, &c->k);
    c->use.share = gp_wanted_share(&m.wanted);
    c->lit = true;
    gp_wanted_kernel_free(&m.wanted);
    memcpy(c->luminance, gp_rec709_luminance, sizeof c->luminance);
    memcpy(c->chromaticities, gp_rec709_chromaticities,
           sizeof c->chromaticities);
    c->named = true;
    c->label = m.label;
    return st;
}

static gp_status check_of_file(const struct gp_log *log,
                               const struct gp_settings *s, struct checked *c)
{
    const struct gp_read_params limits = gp_read_limits(&s->input.read);
    const struct gp_kernel_params p = {
        .normalize = GP_NORMALIZE_NONE, .rotate = s->kernel.image.rotate,
        .scale = s->kernel.percent / 100.0,
    };
    struct gp_frame f;
    gp_status st = gp_read_frame(log, &limits, c->name, &f);
    if (st)
        return st;
    for (int i = 0; i < 3; i++) {
        for (size_t j = 0; j < gp_frame_pixels(&f); j++) {
            c->nonfinite += !isfinite(f.rgb.c[i][j]);
            c->lit |= fabsf(f.rgb.c[i][j]) >= FLT_MIN;
        }
    }
    memcpy(c->luminance, f.luminance, sizeof c->luminance);
    memcpy(c->chromaticities, f.chromaticities, sizeof c->chromaticities);
    c->named = f.names_chromaticities;
    st = gp_label_read(log, &f, &c->label);
    if (!st && !c->nonfinite && c->lit)
        st = gp_kernel_from_frame(log, &p, &f, &c->k);
    c->k.left_out = c->label.left_out;
    c->use.share = c->label.share;
    gp_frame_free(&f);
    return st;
}

/* The brightest source of a frame, and its size. */
static gp_status look_at_frame(const struct gp_log *log,
    const struct gp_settings *s, const char *path, double *brightest, int *w,
    int *h)
{
    const struct gp_read_params limits = gp_read_limits(&s->input.read);
    struct gp_frame f;
    struct gp_sources src;
    gp_status st = gp_read_frame(log, &limits, path, &f);
    if (st)
        return st;
    *w = gp_frame_w(&f);
    *h = gp_frame_h(&f);
    st = gp_sense(log, &s->light.sensor, &f, &src);
    if (!st) {
        *brightest = (double) src.brightest;
        gp_sources_free(&src);
    }
    gp_frame_free(&f);
    return st;
}

static void print_primaries(const struct checked *c)
{
    const float *const p = c->chromaticities;
    if (c->named)
        printf("primaries  %g,%g %g,%g %g,%g, white %g,%g\n", (double) p[0],
               (double) p[1], (double) p[2], (double) p[3], (double) p[4],
               (double) p[5], (double) p[6], (double) p[7]);
    else
        printf("primaries  not named: used as it is in any frame\n");
}

static void print_figures(const struct checked *c,
                          const struct gp_kernel_figures *f)
{
    const struct gp_kernel *const k = &c->k;
    const struct gp_kernel_place *const p = &f->place;
    printf("size       %dx%d, centre %d,%d\n", k->w, k->h, k->cx, k->cy);
    printf("sum        %.7g %.7g %.7g, luminance %.7g\n", f->sum[0], f->sum[1],
           f->sum[2], f->light);
    printf("peak       %.7g at %d,%d\n", p->peak, p->peak_at[0],
           p->peak_at[1]);
    printf("centroid   %.4f,%.4f\n", round(1e4 * p->centroid[0]) / 1e4 + 0.0,
           round(1e4 * p->centroid[1]) / 1e4 + 0.0);
    printf("own pixel  %.4g %%\n", 100.0 * f->own);
    printf("border     %.3g %%\n", 100.0 * f->border);
    printf("rim        %.3g\n", f->rim);
    printf("negatives  %lld\n", f->negatives);
    printf("asymmetry  %.3g %%\n", 100.0 * p->asymmetry);
    if (c->label.present)
        printf("left out   %.3g %%, of which %.3g %% in the frame\n",
               f->left_out > (double) FLT_EPSILON ? 100.0 * f->left_out : 0.0,
               100.0 * c->use.missed);
}

/* Prints figures and faults, for a source of 1000 where no frame is given. */
static gp_status check_kernel(const struct gp_log *log,
                              const struct gp_settings *s, bool *faulty)
{
    struct checked c = {
        .name = s->making.check,
        .use = {.add = s->light.compose.mix == GP_MIX_ADD, .brightest = 1000.0},
    };
    struct gp_kernel_figures f = {0};
    struct gp_fault fault;
    gp_status st = gp_recipe_is(c.name) ? check_of_model(log, s, &c)
                                        : check_of_file(log, s, &c);
    int w = c.label.present ? c.label.w : INT_MAX;
    int h = c.label.present ? c.label.h : INT_MAX;
    if (!st && s->input.files.n)
        st = look_at_frame(log, s, s->input.files.at[0], &c.use.brightest, &w,
                           &h);
    if (st)
        goto out;
    gp_label_use(&c.label, s->kernel.percent / 100.0, &c.k, w, h, &c.use);
    c.use.resampled = c.k.unturned || s->kernel.percent != 100.0;
    printf("kernel     %s\n", gp_printable(c.name).text);
    print_primaries(&c);
    f.nonfinite = c.nonfinite;
    f.measured = !c.nonfinite; // of no light the sums are 0
    if (!c.nonfinite && c.lit) {
        gp_kernel_measure(&c.k, c.luminance, &f);
        print_figures(&c, &f);
        if (!c.use.as_it_is && f.light > 0.0)
            f.rim /= f.light; // as a run normalises it
    }
    for (int i = 0; i < GP_KERNEL_RULES; i++) {
        if (!gp_kernel_fault(&f, &c.use, (enum gp_kernel_rule) i, &fault))
            continue;
        printf("fault: %s%s\n", fault.line,
               gp_hint(fault.parameter, fault.line));
        *faulty = true;
    }
    st = gp_flush_stdout(log);
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
