// SPDX-License-Identifier: Apache-2.0
#include "cli/report.h"

#include "cli/progress.h"
#include "io/file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// -- numbers -----------------------------------------------------------------

struct number {
    char text[40];
};

/* 1183 as "1,183". */
static struct number count_text(long long n)
{
    struct number digits, out;
    const int length = snprintf(digits.text, sizeof digits.text, "%lld", n);
    size_t at = 0;
    for (int i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0)
            out.text[at++] = ',';
        out.text[at++] = digits.text[i];
    }
    out.text[at] = '\0';
    return out;
}

/* A share of the light in percent: "3.1", "42", "under 0.1". */
static struct number percent_text(double part, double whole)
{
    struct number out;
    const double percent = 100.0 * part / whole;
    if (percent > 0.0 && percent < 0.1)
        snprintf(out.text, sizeof out.text, "under 0.1 %%");
    else
        snprintf(out.text, sizeof out.text,
                 percent >= 1e4 ? "%.2g %%" : percent >= 9.95 || percent <= 0.0
                 ? "%.0f %%" : "%.1f %%", percent);
    return out;
}

// -- parts of lines ----------------------------------------------------------

/* Returns where a frame's light went. */
static struct gp_light_sums sums_of(const struct gp_settings *s,
                                    const struct glarepp_sense_facts *sense)
{
    const double gain = (double) s->light.layer.gain;
    const bool scatter = s->light.layer.mix == GLAREPP_SCATTER;
    const double spread = sense->bright + sense->lamps;
    const double moved = scatter ? fmin(gain, 1.0) * sense->bright : 0.0;
    return (struct gp_light_sums) {sense->light, spread, moved,
                                   gain * spread - moved};
}

/* Adds where light went; not `lit`: only the layer is written. */
static void add_light(FILE *w, bool lit, const struct gp_light_sums *l)
{
    if (!(l->light > 0.0))
        return;
    const bool adds = l->added > 1e-9 * l->moved; // (sums round)
    const bool moves = l->moved > 0.0 || !adds;
    if (!lit)
        fprintf(w, ", %s of the light spread",
                percent_text(l->spread, l->light).text);
    else if (moves)
        fprintf(w, ", %s of the light moved",
                percent_text(l->moved, l->light).text);
    if (lit && adds)
        fprintf(w, ", %s%s added", percent_text(l->added, l->light).text,
                moves ? "" : " of the light");
}

/* Adds the tone curve or OpenColorIO's view of a picture. */
static void add_tones(FILE *w, const struct gp_settings *s,
                      const struct glarepp_plan_facts *ocio, bool in_words)
{
    if (!ocio && strcmp(s->tone.map.curve, "none") == 0)
        fprintf(w, "linear");
    else if (ocio)
        fprintf(w, "%s%s", in_words ? "shown by " : "",
                ocio->view ? ocio->view : "OpenColorIO");
    else
        fprintf(w, "%s%s", in_words ? "tone-mapped by " : "", s->tone.map.curve);
}

/* True for a tone-mapped picture in a format that others write linear. */
static bool looks_linear(const struct gp_settings *s, const char *path)
{
    char ending[16];
    if (!s->tone.map.config && strcmp(s->tone.map.curve, "none") == 0)
        return false;
    gp_file_ending(path, ending, sizeof ending);
    return (ending[0] && strstr("exr hdr pfm", ending)) ||
           (gp_is_dash(path) &&
            s->output.write.stdout_format == GP_STDOUT_EXR);
}

#define LINEAR_HINT " (use --hdr for linear light)"

static const char *shown_name(const char *path)
{
    return gp_is_dash(path) ? "stdout" : path;
}

/* "(the default)", or the option, or the style that sets it. */
static void add_reason(FILE *w, const struct gp_settings *s,
                       const char *option)
{
    if (gp_option_given(s, option))
        fprintf(w, " (--%s)", option);
    else if (gp_style_sets(s->light.style, option))
        fprintf(w, " (of style %s)", s->light.style);
    else
        fprintf(w, " (the default)");
}

// -- notes about a frame -----------------------------------------------------

static void say_input(FILE *w, const struct gp_frame_report *f)
{
    const struct gp_read_facts *const r = &f->read;
    const long long nonfinite = f->lib.sense.nonfinite;
    const long long clamped = f->lib.sense.clamped;
    fprintf(w, "read %dx%d pixels", gp_rect_w(r->file), gp_rect_h(r->file));
    if (r->taken.layer[0])
        fprintf(w, ", layer %s", r->taken.layer);
    if (r->taken.part[0])
        fprintf(w, ", part %s", r->taken.part);
    if (r->taken.view[0])
        fprintf(w, ", view %s", r->taken.view);
    for (int i = 0; i < r->groups; i++) {
        const struct gp_light_group *const g = &r->group[i];
        fprintf(w, "%s%s", i ? " and " : ", light of ", g->name);
        if (g->kernel)
            fprintf(w, " by %s", g->kernel);
        if (g->gain != 1.0f)
            fprintf(w, " times %g", (double) g->gain);
    }
    if (r->grown)
        fprintf(w, ", grown to %dx%d", r->width, r->height);
    if (nonfinite)
        fprintf(w, ", %s NaN or Inf", count_text(nonfinite).text);
    if (clamped)
        fprintf(w, ", %s over --max-value", count_text(clamped).text);
}

static void say_light(FILE *w, const struct gp_frame_report *f)
{
    const struct gp_settings *const s = f->job.settings;
    const struct gp_light_sums sums = sums_of(s, &f->lib.sense);
    const long long n = f->lib.sense.sources;
    bool lit = false;
    for (const struct gp_written *o = f->write.file;
         o < f->write.file + f->write.n; o++)
        lit |= o->kind == GP_TARGET_HDR || o->kind == GP_TARGET_PICTURE;
    if (n)
        fprintf(w, n == 1 ? "%s source: a pixel over" : "%s sources: pixels over",
                count_text(n).text);
    else
        fprintf(w, "no pixel is over");
    fprintf(w, " the threshold of %.3g", (double) f->lib.sense.threshold);
    if (s->light.sense.unit == GLAREPP_LUMINANCE)
        add_reason(w, s, "threshold");
    else
        fprintf(w, s->light.sense.unit == GLAREPP_EV ? " (--threshold %+gev)"
                                                     : " (--threshold %g%%)",
                (double) s->light.sense.threshold);
    if (f->lib.sense.lamps > 0.0)
        fprintf(w, " and lights");
    if (n)
        add_light(w, lit, &sums);
    else
        fprintf(w, ": nothing glares");
}

/* Words for what says the angle of view. */
static const char *origin(const char *from)
{
    return strcmp(from, "option") == 0       ? "--fov"
           : strcmp(from, "default") == 0    ? "assumed"
           : strcmp(from, "lens") == 0       ? "of the lens"
           : strcmp(from, "projection") == 0 ? "of --projection"
                                             : "of its camera";
}

static void say_kernel(FILE *w, const struct gp_frame_report *f)
{
    const struct gp_settings *const s = f->job.settings;
    const struct glarepp_kernel_facts *const k = &f->lib.kernel;
    const struct glarepp_layer_facts *const g = &f->lib.layer;
    const bool given = gp_option_given(s, "kernel");
    fprintf(w, given ? "kernel " : "kernel of style %s", s->light.style);
    for (int i = 0; given && i < s->kernel.words.n; i++)
        fprintf(w, "%s%s", i ? " and " : "", s->kernel.words.at[i]);
    fprintf(w, "%s", given                         ? " (--kernel)"
                     : gp_option_given(s, "style") ? " (--style)"
                                                   : " (the default)");
    for (int i = 0; i < k->recipes; i++) {
        if (k->pupil[i] > 0.0)
            fprintf(w, ", pupil of %.1f mm", k->pupil[i]);
    }
    if (k->deg_per_pixel > 0.0)
        fprintf(w, ", view of %.3g degrees (%s%s)", k->fov, origin(k->fov_from),
                strcmp(k->fov_from, "default") ? "" : "; --fov sets it");
    if (g->engine)
        fprintf(w, ", engine %s (%s)", g->engine,
                strcmp(s->light.layer.engine, "auto") == 0 ? "chosen by auto"
                                                     : "--engine");
    if (g->gl)
        fprintf(w, " on %s", g->gl);
}

static void say_veil(FILE *w, const struct gp_frame_report *f)
{
    fprintf(
        w,
        "veil of %.3g cd/m2 at %.6g,%.6g, of sources %.3g, TI %.3g %%, %.3g "
        "lux at the eye",
        f->lib.veil.luminance, f->lib.veil.at[0], f->lib.veil.at[1],
        f->lib.veil.luminance_of_sources, f->lib.veil.threshold_increment,
        f->lib.veil.illuminance);
    if (f->lib.veil.rated)
        fprintf(w, ", UGR %.3g, DGP %.3g", f->lib.veil.ugr, f->lib.veil.dgp);
}

static bool has_level(double gain)
{
    return gain > 0.0 && gain != 1.0;
}

static void say_lights(FILE *w, const struct gp_frame_report *f)
{
    enum { MOST = 8 };
    const struct gp_occluder_facts *const s = &f->hidden;
    const int lights = f->lib.lights;
    for (int i = 0; i < lights && i < MOST; i++) {
        const struct glarepp_share *const l = &f->lib.light[i];
        fprintf(w, "%s%s ", i ? ", " : "", l->name[0] ? l->name : "light");
        if (l->behind)
            fprintf(w, "behind the camera");
        else
            fprintf(w, "%s visible", percent_text(l->visibility, 1.0).text);
    }
    if (lights > MOST)
        fprintf(w, " and %d lights more", lights - MOST);
    if (s->depth && !f->lib.depth_empty[0])
        fprintf(w, ", depth of %s", s->depth);
    if (s->edges)
        fprintf(w, ", edges by %.*s", (int) strcspn(s->edges, ":"), s->edges);
}

static void say_ghosts(FILE *w, const struct gp_frame_report *f)
{
    const struct glarepp_flare_facts *const flare = &f->lib.flare;
    const struct glarepp_lens_facts *const lens = &f->lib.lens;
    if (flare->runs)
        fprintf(w, "flare of bright pixels, %d elements", flare->elements);
    if (has_level(flare->gain))
        fprintf(w, "%sflare times %.3g", flare->runs ? ", " : "", flare->gain);
    if (lens->name)
        fprintf(w, "%slens %s: %d ghosts of %d light%s",
                flare->runs || has_level(flare->gain) ? ", " : "", lens->name,
                lens->drawn, lens->lights, lens->lights == 1 ? "" : "s");
    if (has_level(lens->gain))
        fprintf(w, ", times %.3g", lens->gain);
}

static void say_outputs(FILE *w, const struct gp_frame_report *f)
{
    const struct gp_settings *const s = f->job.settings;
    for (int i = 0; i < f->write.n; i++) {
        const char *const path = f->write.file[i].name;
        fprintf(w, "%s%s: %s", i ? "; " : "wrote ", shown_name(path),
                gp_targets[f->write.file[i].kind].text);
        if (f->write.file[i].kind != GP_TARGET_PICTURE)
            continue;
        add_tones(w, s, f->ocio, true);
        if (looks_linear(s, path))
            fputs(LINEAR_HINT, w);
        else if (!f->ocio)
            add_reason(w, s, "tonemap");
    }
}

void gp_say_frame(const struct gp_log *log, const struct gp_frame_report *f)
{
    const struct glarepp_errors *const e = &f->lib.errors;
    const struct gp_job *const job = &f->job.of;
    const char *const view = job->view;
    const struct {
        bool said;
        void (*say)(FILE *w, const struct gp_frame_report *f);
    } notes[] = {
        {true, say_input},
        {f->cost.ms[GP_TIME_SENSORS] >= 0.0, say_light},
        {f->lib.kernel.w > 0, say_kernel},
        {f->lib.veil.white > 0.0, say_veil},
        {f->lib.lights > 0, say_lights},
        {f->lib.flare.runs || has_level(f->lib.flare.gain) || f->lib.lens.name,
         say_ghosts},
        {f->write.n > 0, say_outputs},
    };
    for (size_t i = 0; i < sizeof notes / sizeof *notes; i++) {
        char line[GP_LINE_BYTES] = "";
        FILE *const w = notes[i].said ? fmemopen(line, sizeof line - 1, "w")
                                      : NULL;
        if (!w)
            continue;
        notes[i].say(w, f);
        fclose(w);
        gp_say(log, GP_LEVEL_INFO, "%s%s%s%s: %s", job->input, view ? " (" : "",
               view ? view : "", view ? ")" : "", line);
    }
    if (f->lib.verified)
        gp_say(log, GP_LEVEL_INFO,
               "%s: measured rel_l2 %.3g, max_rel %.3g, max_abs %.3g, "
               "flux_error %.3g",
               job->input, e->rel_l2, e->max_rel, e->max_abs, e->flux_error);
}

// -- the line on a terminal --------------------------------------------------

void gp_tally_add(struct gp_tally *t, const struct gp_frame_report *f)
{
    const struct glarepp_sense_facts *const sense = &f->lib.sense;
    const struct glarepp_kernel_facts *const k = &f->lib.kernel;
    const struct gp_light_sums sums = sums_of(f->job.settings, sense);
    const long long n = sense->sources;
    t->fewest = t->made && t->fewest < n ? t->fewest : n;
    t->most = t->most > n ? t->most : n;
    t->sums.light += sums.light;
    t->sums.spread += sums.spread;
    t->sums.moved += sums.moved;
    t->sums.added += sums.added;
    if (k->deg_per_pixel > 0.0) {
        t->fov = k->fov;
        t->fov_from = k->fov_from;
    }
    t->ocio = f->ocio;
    t->made++;
}

void gp_tally_print(FILE *w, const struct gp_tally *t,
                    const struct gp_settings *s, const struct gp_jobs *jobs,
                    double seconds)
{
    const struct gp_output *first = &jobs->target[0];
    bool lit = false, pictures = false, linear = false;
    char time[32];
    for (int i = 0; i < jobs->targets; i++) {
        const struct gp_output *const o = &jobs->target[i];
        const bool picture = o->kind == GP_TARGET_PICTURE;
        first = picture && !pictures ? o : first;
        lit = lit || picture || o->kind == GP_TARGET_HDR;
        pictures = pictures || picture;
        linear = linear || (picture && looks_linear(s, o->name.path));
    }
    fprintf(w, "%s", shown_name(first->name.path));
    if (jobs->targets > 1)
        fprintf(w, " and %d more", jobs->targets - 1);
    fprintf(w, ": ");
    if (t->made > 1)
        fprintf(w, "%s %s, ", count_text(t->made).text,
                jobs->view.n > 1 ? "views" : "frames");
    if (t->fewest < t->most)
        fprintf(w, "%s to ", count_text(t->fewest).text);
    fprintf(w, "%s source%s", count_text(t->most).text, t->most == 1 ? "" : "s");
    if (t->most == 0)
        fprintf(w, ": nothing glares");
    else
        add_light(w, lit, &t->sums);
    if (t->fov_from)
        fprintf(w, ", view of %.3g degrees (%s)", t->fov, origin(t->fov_from));
    fprintf(w, ", ");
    if (pictures)
        add_tones(w, s, t->ocio, linear);
    fprintf(w, "%s", !pictures ? "linear" : linear ? LINEAR_HINT : "");
    if (seconds < 10.0)
        snprintf(time, sizeof time, "%.2f s", seconds);
    else
        gp_print_duration(time, sizeof time, seconds);
    fprintf(w, ", %s", time);
}
