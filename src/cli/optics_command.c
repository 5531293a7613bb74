// SPDX-License-Identifier: Apache-2.0
/* glarepp kernel and glarepp lens. */
#include "cli/commands.h"
#include "cli/listener.h"
#include "io/file.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

// -- making -------------------------------------------------------------------

/* Reads recipes and images, as recipes too. */
static gp_status read_kernel(struct glarepp *gp, const struct gp_settings *s,
    const char *const *word, int words, struct glarepp_kernel **out)
{
    struct glarepp_kernel_params p = s->kernel.p;
    p.word = word;
    p.words = words;
    p.recipe = true;
    return (gp_status) glarepp_kernel(gp, &p, out);
}

/* Draws the kernel at full rate, as far as it was asked for, as a frame whose
 * centre is pixel (floor(w / 2), floor(h / 2)). `name` for messages. */
static gp_status draw_kernel(const struct glarepp_kernel *k,
    const struct gp_settings *s, const char *name, struct gp_frame *out,
    struct glarepp_label *label)
{
    const struct glarepp_field field = {
        .w = s->making.w, .h = s->making.h, .fov = s->plan.fov,
        .rotate = s->plan.rotate, .frame = s->making.frame,
        .radius = s->making.radius, .most = s->input.read.max_pixels,
        .name = name,
    };
    struct glarepp_image image = GLAREPP_IMAGE;
    const gp_status st =
        (gp_status) glarepp_kernel_draw(k, &field, &image, label);
    if (st)
        return st;
    *out = gp_frame_blank(image.data);
    out->names_chromaticities = true;
    for (int c = 0; c < 3; c++)
        out->rgb.c[c] = image.plane[c];
    return GP_OK;
}

// -- -o -----------------------------------------------------------------------

/* Attributes of a kernel's file. */
struct texts {
    struct gp_attribute at[GP_KERNEL_RECIPES + 7];
    char value[GP_KERNEL_RECIPES + 7][40]; // of those that are made here
    int n;
};

static void add_text(struct texts *t, const char *name, const char *text)
{
    t->at[t->n++] = (struct gp_attribute) {
        .name = (char *) (uintptr_t) name, .kind = GP_ATTRIBUTE_TEXT,
        .text = (char *) (uintptr_t) text,
    };
}

static void add_number(struct texts *t, const char *name, double v)
{
    snprintf(t->value[t->n], sizeof *t->value, "%.17g", v);
    add_text(t, name, t->value[t->n]);
}

/* Fills in all of them; recipes are the kernel's. */
static void make_texts(const struct gp_settings *s,
    const struct glarepp_kernel *k, const struct glarepp_label *label,
    struct texts *out)
{
    static const char option[] = "compression";
    const struct gp_option_choice *const c = gp_option_chosen(
        gp_option_find(option, strlen(option)), &s->output.write.compression);
    const char *recipe;
    out->n = 0;
    for (int i = 0; i < GP_KERNEL_RECIPES &&
                    (recipe = glarepp_kernel_recipe(k, i)); i++)
        add_text(out, gp_recipe_names[i], recipe);
    add_number(out, "glarepp:fov", label->fov);
    snprintf(out->value[out->n], sizeof *out->value, "%dx%d,%d", label->w,
             label->h, s->making.radius);
    add_text(out, "glarepp:size", out->value[out->n]);
    add_number(out, "glarepp:rotate", s->plan.rotate);
    add_number(out, "glarepp:frame", s->making.frame);
    add_text(out, "glarepp:compression", c->name);
    add_number(out, "glarepp:left_out", label->left_out);
    add_number(out, "glarepp:beyond", label->beyond);
}

static gp_status write_kernel(const struct gp_log *log, struct glarepp *gp,
                              const struct gp_settings *s)
{
    const struct gp_texts *const words = &s->kernel.words;
    const struct gp_texts *const outputs = &s->output.pictures;
    gp_status st;
    struct glarepp_kernel *k = NULL;
    struct glarepp_label label;
    struct gp_frame f = {0};
    struct gp_write_params write = s->output.write;
    struct gp_write_stats stats = {0};
    struct texts texts;
    write.type = GP_OUT_FLOAT;
    for (int i = 0; i < outputs->n; i++)
        GP_TRY(gp_write_hdr_check(log, &write, "-o of a kernel keeps floats "
                                  "and its recipe", outputs->at[i]));
    GP_TRY(gp_output_guard_check(log, s, NULL, NULL));
    GP_TRY(read_kernel(gp, s, words->at, words->n, &k));
    GP_TRY(draw_kernel(k, s, outputs->at[0], &f, &label));
    make_texts(s, k, &label, &texts);
    write.added = texts.at;
    write.n_added = texts.n;
    for (int i = 0; i < outputs->n; i++)
        GP_TRY(gp_write_picture(log, &write, outputs->at[i], &f, &f.rgb,
                                GP_PICTURE_SCENE, &stats));
    gp_say(log, GP_LEVEL_INFO, "%s: %dx%d, %g degrees a pixel, left out %.3g",
           outputs->at[0], gp_frame_w(&f), gp_frame_h(&f), label.degrees,
           label.left_out);
out:
    glarepp_kernel_end(&k);
    gp_frame_free(&f);
    return st;
}

// -- --list -------------------------------------------------------------------

/* Prints a key with its preset, then the values it takes and its text. */
static void print_key(const struct glarepp_key *k)
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

// -- --check ------------------------------------------------------------------

/* Finds the brightest source of a frame, and its size. */
static gp_status look_at_frame(const struct gp_log *log, struct glarepp *gp,
    const struct gp_settings *s, const char *path,
    struct glarepp_kernel_use *use)
{
    const struct gp_read_params limits = gp_read_limits(&s->input.read);
    struct glarepp_plan_params how = GLAREPP_PLAN_PARAMS;
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    struct glarepp_plan *plan = NULL;
    struct glarepp_frame *frame = NULL;
    struct gp_frame f = {0};
    gp_status st;
    how.sense = &s->light.sense;
    GP_TRY(gp_read_frame(log, &limits, path, &f));
    use->w = gp_frame_w(&f);
    use->h = gp_frame_h(&f);
    p.image = gp_frame_view(&f, &f.rgb);
    p.in_place = true;
    GP_TRY(glarepp_plan(gp, &how, &plan));
    GP_TRY(glarepp_frame(plan, &p, &frame));
    GP_TRY(glarepp_frame_run(frame, GLAREPP_SENSE));
    use->brightest = (double) glarepp_frame_facts(frame)->sense.brightest;
out:
    glarepp_frame_end(&frame);
    glarepp_plan_end(&plan);
    gp_frame_free(&f);
    return st;
}

static void print_figures(const struct glarepp_kernel_figures *f, bool labelled)
{
    printf("size       %dx%d, centre %d,%d\n", f->w, f->h, f->centre[0],
           f->centre[1]);
    printf("sum        %.7g %.7g %.7g, luminance %.7g\n", f->sum[0], f->sum[1],
           f->sum[2], f->light);
    printf("peak       %.7g at %d,%d\n", f->peak, f->peak_at[0],
           f->peak_at[1]);
    printf("centroid   %.4f,%.4f\n", round(1e4 * f->centroid[0]) / 1e4 + 0.0,
           round(1e4 * f->centroid[1]) / 1e4 + 0.0);
    printf("own pixel  %.4g %%\n", 100.0 * f->own);
    printf("border     %.3g %%\n", 100.0 * f->border);
    printf("rim        %.3g\n", f->rim);
    printf("negatives  %lld\n", f->negatives);
    printf("asymmetry  %.3g %%\n", 100.0 * f->asymmetry);
    if (labelled)
        printf("left out   %.3g %%, of which %.3g %% in the frame\n",
               f->left_out > (double) FLT_EPSILON ? 100.0 * f->left_out : 0.0,
               100.0 * f->missed);
}

/* Prints figures and faults, for a source of 1000 where no frame is given. */
static gp_status check_kernel(const struct gp_log *log, struct glarepp *gp,
                              const struct gp_settings *s, int *status)
{
    const char *const name = s->making.check;
    const bool file = gp_kernel_is_file(name);
    const struct gp_read_params limits = gp_read_limits(&s->input.read);
    struct glarepp_kernel *k = NULL;
    struct glarepp_kernel_use use = {
        .brightest = 1000.0, .percent = s->kernel.p.percent,
        .add = s->light.layer.mix == GLAREPP_ADD,
    };
    struct glarepp_kernel_figures figures;
    struct gp_frame f = {0};
    gp_status st;
    if (file) {
        GP_TRY(gp_read_frame(log, &limits, name, &f));
        GP_TRY(gp_label_read(log, &f, &use.label));
    } else {
        GP_TRY(read_kernel(gp, s, &name, 1, &k));
        GP_TRY(draw_kernel(k, s, name, &f, &use.label));
    }
    if (s->input.files.n)
        GP_TRY(look_at_frame(log, gp, s, s->input.files.at[0], &use));
    struct glarepp_image image = gp_frame_view(&f, &f.rgb);
    image.name = name;
    if (file) // what was drawn is turned already
        use.rotate = s->plan.rotate;
    GP_TRY(glarepp_kernel_check(gp, &image, &use, &figures));
    printf("kernel     %s\n", gp_printable(name).text);
    const float *const p = f.chromaticities;
    if (f.names_chromaticities)
        printf("primaries  %g,%g %g,%g %g,%g, white %g,%g\n", (double) p[0],
               (double) p[1], (double) p[2], (double) p[3], (double) p[4],
               (double) p[5], (double) p[6], (double) p[7]);
    else
        printf("primaries  not named: used as it is in any frame\n");
    if (!figures.nonfinite && figures.lit)
        print_figures(&figures, use.label.present);
    for (int i = 0; i < figures.faults; i++)
        printf("fault: %s%s\n", figures.fault[i],
               gp_hint(figures.parameter[i], figures.fault[i]));
    *status = figures.faults > 0;
    st = gp_flush_stdout(log);
out:
    glarepp_kernel_end(&k);
    gp_frame_free(&f);
    return st;
}

gp_status gp_kernel_command(const struct gp_log *log, struct glarepp *gp,
                            const struct gp_settings *s, int *status)
{
    const char *name, *text, *more;
    if (!s->making.list)
        return s->making.check ? check_kernel(log, gp, s, status)
                               : write_kernel(log, gp, s);
    printf("Models: -k MODEL:key=value,key=value (keys with their defaults)\n");
    for (int i = 0; (name = glarepp_name(NULL, GLAREPP_MODELS, i, &text));
         i++) {
        struct glarepp_key key;
        glarepp_name(NULL, GLAREPP_MODEL_SOURCES, i, &more);
        printf("\n%s: %s\n  (%s)\n", name, text, more);
        for (int k = 0; glarepp_key(i, k, &key); k++)
            print_key(&key);
    }
    printf("\nPresets: -k builtin:NAME\n\n");
    for (int i = 0; (name = glarepp_name(NULL, GLAREPP_PRESETS, i, &text));
         i++) {
        glarepp_name(NULL, GLAREPP_PRESET_RECIPES, i, &more);
        printf("  %-10s %s\n  %-10s %s\n", name, text, "", more);
    }
    return gp_flush_text(log);
}

// -- lens --------------------------------------------------------------------

/* Prints a figure beside its claim; true where they differ by over `most`. */
static bool print_claim(const char *what, const char *unit, double computed,
                        double claimed, double most)
{
    printf("%-12s %.6g%s", what, computed, unit);
    if (!(claimed > 0.0)) {
        printf("\n");
        return false;
    }
    const double off = computed / claimed - 1.0;
    printf(", claimed %.6g (%+.2f %%)\n", claimed, 100.0 * off);
    return fabs(off) > most;
}

/* Prints the ghosts, those that are brightest on the sensor first. */
static void print_ghosts(const struct glarepp_lens *lens)
{
    enum { SHOWN = 8 };
    const double image = lens->pupil * lens->pupil * lens->through;
    struct glarepp_ghost *const ghost = lens->ghost;
    const int n = lens->ghosts;
    printf("ghosts       %d; those with most light on the axis at 587.6 nm, of "
           "the image's light:\n",
           n);
    for (int i = 0; i < n && i < SHOWN; i++) {
        int best = i;
        for (int k = i + 1; k < n; k++) {
            if (ghost[k].through * ghost[k].radius * ghost[k].radius >
                ghost[best].through * ghost[best].radius * ghost[best].radius)
                best = k;
        }
        const struct glarepp_ghost g = ghost[best];
        ghost[best] = ghost[i];
        ghost[i] = g;
        printf("  surfaces %2d and %2d: %.3g, %.4g mm across, place %+.3g of "
               "the light's\n", g.second + 1, g.first + 1,
               g.through * g.radius * g.radius / image,
               2.0 * fabs(g.a) * g.radius,
               (g.a * g.shift + g.b) / lens->focal);
    }
    printf("starburst    --lens and -k aperture: %.4g mm f/%.3g, ",
           lens->focal, lens->f_number);
    if (lens->blades)
        printf("%d blades\n", lens->blades);
    else
        printf("round\n");
}

static gp_status check_lens(const struct gp_log *log, struct glarepp *gp,
                            const struct gp_settings *s, int *status)
{
    struct glarepp_lens lens = {.own = NULL};
    const char *const draw = s->making.draw;
    char ending[8] = "";
    gp_status st;
    if (draw)
        gp_file_ending(draw, ending, sizeof ending);
    if (draw && !gp_is_dash(draw) && strcmp(ending, "svg") != 0)
        return gp_fail(log, GP_ERR_USAGE, "%s: the drawing of a lens is an "
                       "SVG; give a name that ends in .svg", draw);
    GP_TRY(gp_output_guard_check(log, s, NULL, NULL));
    GP_TRY(glarepp_lens(gp, s->making.check, &lens));
    printf("lens         %s\n", lens.name);
    if (lens.patent[0])
        printf("patent       %s\n", lens.patent);
    if (lens.note[0])
        printf("note         %s\n", lens.note);
    printf("surfaces     %d, stop %d, %s%.0d\n", lens.surfaces, lens.stop + 1,
           lens.blades ? "blades " : "round", lens.blades);
    // a nominal focal length is within 1 % (ISO 517)
    bool fault = print_claim("focal length", " mm", lens.focal,
                             lens.claims_focal, 0.01);
    fault |= print_claim("back focus", " mm", lens.back, lens.claims_back,
                         0.01);
    fault |= print_claim("f-number", "", lens.f_number, lens.claims_f_number,
                         0.05);
    // rims may let more through than the format takes
    if (lens.height >= lens.claims_height && lens.claims_height > 0.0)
        printf("image height %.6g mm by the rims, claimed %.6g: covered\n",
               lens.height, lens.claims_height);
    else
        fault |= print_claim("image height", " mm", lens.height,
                             lens.height > 0.0 ? lens.claims_height : 0.0, 0.1);
    printf("through      %.2f %%\n", 100.0 * lens.through);
    print_ghosts(&lens);
    if (fault)
        printf("fault: the surfaces do not make what the file claims; compare "
               "it with its source\n");
    *status = fault;
    if (draw) {
        // the brightest on the sensor: light over area
        const struct glarepp_ghost *best = lens.ghosts ? lens.ghost : NULL;
        for (int i = 1; i < lens.ghosts; i++) {
            const struct glarepp_ghost *const g = &lens.ghost[i];
            if (g->through * best->a * best->a > best->through * g->a * g->a)
                best = g;
        }
        const char *const text = glarepp_lens_draw(&lens, best);
        GP_TRY(text ? gp_file_save(log, draw, false, false, text, strlen(text))
                    : gp_no_memory(log, draw));
    }
    st = gp_flush_stdout(log);
out:
    glarepp_lens_end(&lens);
    return st;
}

gp_status gp_lens_command(const struct gp_log *log, struct glarepp *gp,
                          const struct gp_settings *s, int *status)
{
    const char *name;
    if (!s->making.list)
        return check_lens(log, gp, s, status);
    if (!glarepp_name(gp, GLAREPP_LENSES, 0, NULL))
        return gp_fail(log, GP_ERR_IO,
                       "lenses: not found beside the program; "
                       "install it whole, or name their folder's parent in "
                       "GLAREPP_EXAMPLES");
    for (int i = 0; (name = glarepp_name(gp, GLAREPP_LENSES, i, NULL)); i++) {
        struct glarepp_lens lens;
        const gp_status st = (gp_status) glarepp_lens(gp, name, &lens);
        if (st)
            return st;
        printf("%-14s %s (%s)\n", name, lens.name, lens.patent);
        glarepp_lens_end(&lens);
    }
    return gp_flush_text(log);
}
