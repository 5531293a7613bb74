// SPDX-License-Identifier: Apache-2.0
/* Checks settings that depend on each other. The option table has the needs of
 * each option as bits (options.h); this file has their conditions and their
 * messages. */
#include "cli/jobs.h"

#include "io/file.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// -- needs of options --------------------------------------------------------

/* A need: whether the settings meet it, and what is said of an option that has
 * it where they do not, after "--NAME: ". */
struct need {
    bool met;
    const char *text, *found, *end; // printed one after the other
};

/* Tests whether there is an output file, and whether one has no ending that names
 * its format. */
static void look_at_outputs(const struct gp_settings *s, bool *files,
                            bool *stream)
{
    enum gp_target_kind kind;
    const char *path;
    int i = 0;
    for (*stream = false; (path = gp_output_at(s, i, &kind)); i++) {
        char ending[16];
        gp_file_ending(path, ending, sizeof ending);
        *stream |= !ending[0] && gp_file_is_straight(path);
    }
    *files = i > 0;
}

/* All needs: the i-th is of bit 1 << i, and they are checked in this order. */
struct needs {
    struct need at[GP_NEEDS];
};
// clang-format off
static struct needs needs_of(const struct gp_settings *s)
{
    const struct gp_sun_settings *const sun = &s->sun;
    const bool light = gp_lights_wanted(s);
    const bool config = s->tone.map.config != NULL;
    const bool polygons = s->output.debug[GP_DEBUG_POLYGONS] != NULL;
    const bool bench = s->command == GP_COMMAND_BENCH; // runs every method
    const bool mask = sun->p.method == GLAREPP_MASK || bench;
    const char *const engine = s->light.layer.engine;
    const bool splat = strcmp(engine, "splat") == 0 || polygons || bench;
    const char *const curve = s->tone.map.curve;
    const bool chosen = strcmp(engine, "auto") == 0;
    const char *const input = s->input.files.n ? s->input.files.at[0] : "";
    bool stream, files;
    look_at_outputs(s, &files, &stream);
    return (struct needs) {{
        {s->input.files.n == 0, "measures frames of its own (found input ",
         input, "); leave one of the two out"},
        {!light, "its frames have no depth to hide a light; leave --paper or "
         "the lights out", "", ""},
        {s->run.report || s->run.level >= GP_LEVEL_INFO, "no output shows its "
         "result; add --report FILE or -v", "", ""},
        {!gp_option_given(s, "stdout-format") ||
         s->output.write.stdout_format == GP_STDOUT_RAW, "contradicts "
         "--stdout-format; leave one of the two out", "", ""},
        {light, "needs a light; give --sun, --sun-dir, --camera, --lights or "
         "--scene", "", ""},
        {!sun->at.n, "--sun already places the sun; leave one of the two out",
         "", ""},
        {sun->at.n || sun->dir.n || sun->p.cameras, "needs --sun, --sun-dir or "
         "--camera; lights of --lights have flux of their own, those of "
         "--scene by --light-scale", "", ""},
        {config, "needs --ocio; give --ocio CONFIG or --ocio env", "", ""},
        {!config, "--ocio replaces it; leave one of the two out", "", ""},
        {s->output.pictures.n || polygons, "needs a picture; give -o FILE", "",
         ""},
        {s->output.hdr.n, "converts only --hdr; give --hdr FILE", "", ""},
        {s->lens.lens, "needs --lens; give --lens NAME, see glarepp lens "
         "--list", "", ""},
        {s->scene.path, "needs --scene; give --scene FILE", "", ""},
        {sun->relight.n, "needs --relight; give --relight NAME", "", ""},
        {sun->p.flare, "needs --flare; give --flare preset:zoom, or a file",
         "", ""},
        {mask, "does nothing with this --sun-method; use --sun-method mask", "",
         ""},
        {mask || s->output.debug[GP_DEBUG_SUNMAP], "does nothing with this "
         "--sun-method; use --sun-method mask", "", ""},
        {!config, "does nothing with --ocio; leave it out", "", ""},
        {config || strcmp(curve, "none") != 0, "does nothing with --tonemap "
         "none; use --tonemap linear", "", ""},
        {config || strcmp(curve, "reinhard-extended") == 0, "does nothing with "
         "--tonemap ", curve, "; use --tonemap reinhard-extended"},
        {splat, "does nothing with --engine ", engine, "; use --engine splat"},
        {chosen, "does nothing with --engine ", engine, "; use --engine auto"},
        {stream, "does nothing without an output to stdout; write -o -", "",
         ""},
        {files, "does nothing without an output file; leave it out", "", ""},
    }};
}
// clang-format on

unsigned gp_needs_unmet(const struct gp_settings *s)
{
    const struct needs needs = needs_of(s);
    unsigned unmet = 0;
    for (int i = 0; i < GP_NEEDS; i++)
        unmet |= (unsigned) !needs.at[i].met << i;
    return unmet;
}

/* Returns the first option that is given and has the need, or NULL. (--camera
 * by itself may give only an angle of view, and needs no light.) */
static const char *first_in_need(const struct gp_settings *s, unsigned bit)
{
    for (const struct gp_option *o = gp_options; o->name; o++) {
        if ((o->needs & bit) && gp_option_given(s, o->name))
            return o->name;
    }
    return bit != GP_NEED_LIGHT            ? NULL
           : s->output.debug[GP_DEBUG_SUNMAP]     ? "debug sunmap"
           : s->output.debug[GP_DEBUG_INTENSITY] ? "debug intensity" : NULL;
}

/* Fails for the first need that is not met; `warns`: warns of what is idle. */
static gp_status check_needs(const struct gp_log *log,
                             const struct gp_settings *s, bool warns)
{
    const struct needs needs = needs_of(s);
    for (int i = 0; i < GP_NEEDS; i++) {
        const struct need *const n = &needs.at[i];
        const unsigned bit = 1u << i;
        const char *const name = n->met ? NULL : first_in_need(s, bit);
        if (!name || warns != (bit >= GP_NEED_MASK))
            continue;
        if (warns)
            gp_say(log, GP_LEVEL_WARN, "--%s: %s%s%s", name, n->text, n->found,
                   n->end);
        else if (bit == GP_NEED_CONFIG && strcmp(name, "view") == 0)
            return gp_fail(log, GP_ERR_USAGE, "--view: needs --ocio CONFIG; "
                           "for stereo use --views %s", s->tone.map.view);
        else
            return gp_fail(log, GP_ERR_USAGE, "--%s: %s%s%s", name, n->text,
                           n->found, n->end);
    }
    return GP_OK;
}

// -- values ------------------------------------------------------------------

/* Reads --grow. */
static gp_status check_grow(const struct gp_log *log, struct gp_settings *s)
{
    enum { MOST = 65536 };
    const char *const word = s->output.grow ? s->output.grow : "0";
    int n = 0;
    const bool kernel = strcmp(word, "kernel") == 0;
    const bool none = strcmp(word, "none") == 0;
    if (!kernel && !none && (!gp_read_whole(word, "", &n) || n > MOST))
        return gp_fail(log, GP_ERR_USAGE, "--grow: not a number of pixels "
                       "(found \"%s\"); give 0 to %d, kernel or none", word,
                       MOST);
    s->output.grow_pixels = kernel ? GP_GROW_KERNEL : none ? GP_GROW_NONE : n;
    return GP_OK;
}

/* Checks that a kernel is there. */
static gp_status check_word(const struct gp_log *log, const char *word)
{
    return !gp_kernel_is_file(word) || strpbrk(word, "./-") ||
                   gp_file_exists(word)
               ? GP_OK
               : gp_fail(log, GP_ERR_IO,
                         "%s: neither a model of kernels nor "
                         "a file; glarepp kernel --list shows the models",
                         word);
}

/* Checks that kernels are there, and that options of images have one. */
static gp_status check_kernels(const struct gp_log *log,
                               const struct gp_settings *s)
{
    const bool checks = s->command == GP_COMMAND_KERNEL && s->making.check;
    const char *const *const at =
        checks ? &s->making.check : (const char *const *) s->kernel.words.at;
    const int n = checks ? 1 : s->kernel.words.n;
    bool files = false;
    if (checks && gp_kernel_is_file(at[0]))
        return GP_OK;
    for (int i = 0; i < n; i++) {
        const gp_status st = check_word(log, at[i]);
        if (st)
            return st;
        files |= gp_kernel_is_file(at[i]);
    }
    const bool one = n == 1 && files && s->command != GP_COMMAND_KERNEL;
    const char *const image =
        gp_option_given(s, "kernel-size") && !files ? "kernel-size"
        : s->kernel.p.centred && !one               ? "kernel-center"
        : s->kernel.p.normalized && !one            ? "kernel-normalize"
                                                    : NULL;
    return !image ? GP_OK : gp_fail(log, GP_ERR_USAGE, "--%s: is of one image "
        "of a kernel (found %s); write image:file=PATH with its keys size, x, "
        "y and share, or leave it out", image,
        n > 1 ? "several kernels" : at[0]);
}

/* Sets the size of --size, or the usual one. */
static gp_status check_size(const struct gp_log *log, struct gp_making *m,
                            int w, int h)
{
    int size[2] = {w, h};
    if (m->size && (!gp_read_whole(m->size, "x", size) || size[0] < 1 ||
                    size[1] < 1 || size[0] > 16384 || size[1] > 16384))
        return gp_fail(log, GP_ERR_USAGE, "--size: not a size (found \"%s\"); "
                       "give WxH, e.g. 1920x1080, each 1 to 16384", m->size);
    m->w = size[0];
    m->h = size[1];
    return GP_OK;
}

/* Checks that glarepp kernel has one thing to do. */
static gp_status check_making(const struct gp_log *log, struct gp_settings *s)
{
    struct gp_making *const m = &s->making;
    const bool makes = s->output.pictures.n > 0;
    if (m->list + (m->check != NULL) + makes != 1)
        return gp_fail(log, GP_ERR_USAGE, "%s; write one of glarepp kernel -k "
                       "MODEL -o FILE, --check FILE and --list",
                       m->list || m->check || makes ? "too much to do"
                                                    : "nothing to make");
    const bool sized = m->size || m->radius || gp_option_given(s, "fov") ||
                       gp_option_given(s, "frame");
    const bool kernel = gp_option_given(s, "kernel");
    if (m->check && kernel)
        return gp_fail(log, GP_ERR_USAGE, "--check: which kernel (found %s, "
                       "and -k %s); write only --check %s", m->check,
                       s->kernel.words.at[0], s->kernel.words.at[0]);
    if (m->check && sized && gp_kernel_is_file(m->check))
        return gp_fail(log, GP_ERR_USAGE, "--check: %s is a file, which has "
                       "its size; leave --size, --radius, --fov and --frame "
                       "out", m->check);
    if (!m->check && gp_option_given(s, "mix"))
        return gp_fail(log, GP_ERR_USAGE, "--mix: a kernel is the same for "
                       "both; leave it out, or give it to --check");
    return check_size(log, m, 1920, 1080);
}

static gp_status check_sets(const struct gp_log *log, struct gp_settings *s)
{
    for (int i = 0; i < GP_DEBUG_SCISSOR; i++) {
        if (s->output.debug[i])
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: not of glarepp sets; give scissor or sets",
                           gp_targets[GP_TARGET_SENSORS + i].option);
    }
    if (gp_option_given(s, "runs"))
        s->sets.runs = s->bench.runs;
    return check_size(log, &s->making, 960, 540);
}

/* Checks that glarepp lens has one thing to do; by itself it lists. */
static gp_status check_lens(const struct gp_log *log, struct gp_settings *s)
{
    struct gp_making *const m = &s->making;
    if (m->list && m->check)
        return gp_fail(log, GP_ERR_USAGE, "too much to do; write one of "
                       "glarepp lens --check FILE|NAME and --list");
    if (m->draw && !m->check)
        return gp_fail(log, GP_ERR_USAGE, "--draw: needs a lens; add --check "
                       "FILE|NAME");
    m->list = !m->check;
    return GP_OK;
}

/* Checks that glarepp styles lists them, or draws one frame. */
static gp_status check_styles(const struct gp_log *log,
                              const struct gp_settings *s)
{
    const bool makes = s->output.pictures.n || s->run.report;
    if ((s->input.files.n > 0) != makes)
        return gp_fail(log, GP_ERR_USAGE, "styles: %s; write glarepp styles -o "
                       "sheet.png frame.exr", makes ? "no frame"
                                                    : "nothing to make");
    if (makes && gp_is_dash(s->input.files.at[0]))
        return gp_fail(log, GP_ERR_USAGE, "-: styles reads the frame once for "
                       "each style; give a file");
    return GP_OK;
}

static gp_status check_groups(const struct gp_log *log, struct gp_settings *s)
{
    struct glarepp_layer_params *const splat = &s->light.layer;
    const bool odd = splat->group & (splat->group - 1);
    // the default of --cluster must not refuse a larger --group
    if (!gp_option_given(s, "cluster") && splat->cluster <= splat->group)
        splat->cluster = 0;
    if (odd || splat->cluster & (splat->cluster - 1))
        return gp_fail(log, GP_ERR_USAGE, "--%s: not a power of two (found "
                       "%d); give %s, 2, 4, 8, 16, 32 or 64",
                       odd ? "group" : "cluster",
                       odd ? splat->group : splat->cluster, odd ? "1" : "0");
    if (splat->cluster != 0 && splat->cluster <= splat->group)
        return gp_fail(log, GP_ERR_USAGE, "--cluster: must be larger than "
                       "--group (found %d and %d); give a larger one, or 0 "
                       "for none", splat->cluster, splat->group);
    return GP_OK;
}

/* Checks the number of inputs. */
static gp_status check_inputs(const struct gp_log *log,
                              const struct gp_settings *s)
{
    const struct gp_command_row *const c = gp_command_of(s->command);
    const int n = s->input.files.n;
    const bool none = s->bench.paper ||
                      (s->command == GP_COMMAND_KERNEL && !s->making.check);
    const int least = none || s->words.save_settings ? 0 : c->least;
    // (--paper says itself that it reads none)
    const int most = none && !s->bench.paper ? 0 : c->most;
    if (n > most)
        return gp_fail(log, GP_ERR_USAGE, "%s: too many inputs (found %d, "
                       "glarepp %s reads %d); leave it out",
                       s->input.files.at[most], n, c->word, most);
    if (n < least)
        return gp_fail(log, GP_ERR_USAGE, "%s; write %s", n ? "only one input"
                       : "no input", c->example->line);
    return GP_OK;
}

/* Checks that something is made. */
static gp_status check_outputs(const struct gp_log *log,
                               const struct gp_settings *s)
{
    const bool bench = s->command == GP_COMMAND_BENCH;
    bool files, stream;
    look_at_outputs(s, &files, &stream);
    const bool wants = files || s->run.report || s->sun.write_lights;
    for (int i = GP_DEBUG_SCISSOR; i <= GP_DEBUG_SETS; i++) {
        if (s->output.debug[i])
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: of glarepp sets only; write glarepp sets "
                           "%s=%s SCENE",
                           gp_targets[GP_TARGET_SENSORS + i].option,
                           gp_targets[GP_TARGET_SENSORS + i].option,
                           s->output.debug[i]);
    }
    if (bench && (s->lens.lens || s->sun.p.flare) && gp_lights_wanted(s))
        return gp_fail(log, GP_ERR_USAGE, "%s: bench measures it for bright "
                       "pixels, and lights by their visibility (found a "
                       "light); leave one out", s->lens.lens ? "--lens"
                                                             : "--flare");
    const struct gp_texts *const in = &s->input.files;
    if (s->command == GP_COMMAND_MAIN && in->n && gp_command_named(in->at[0]) &&
        access(in->at[0], F_OK) != 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: no such file (found a command's name); write the "
                       "command first: glarepp %s",
                       in->at[0], in->at[0]);
    const bool saves = s->words.save_settings && !in->n; // nothing else
    if (saves && wants)
        return gp_fail(log, GP_ERR_USAGE, "no input; write %s",
                       gp_commands->example->line);
    if (!bench && !wants && !saves)
        return gp_fail(log, GP_ERR_USAGE, "no output is given (found %s%s%s); "
                       "give -o out.png, or --hdr out.exr for linear light",
                       in->at[0], in->n > 2 ? " ... " : in->n > 1 ? " " : "",
                       in->n > 1 ? in->at[in->n - 1] : "");
    return GP_OK;
}

/* Takes --lights: a file, or auto[:N]. */
static gp_status set_lights_file(const struct gp_log *log,
                                 struct gp_settings *s)
{
    static const char AUTO[] = "auto";
    struct gp_sun_settings *const sun = &s->sun;
    const size_t n = sizeof AUTO - 1;
    int found = 32;
    const bool spots = sun->lights && strncmp(sun->lights, AUTO, n) == 0 &&
                       (!sun->lights[n] || sun->lights[n] == ':');
    if (!spots)
        sun->p.file = sun->lights;
    if (spots && sun->lights[n] &&
        (!gp_read_whole(sun->lights + n + 1, "", &found) || found < 1 ||
         found > 256))
        return gp_fail(log, GP_ERR_USAGE,
                       "--lights: not a number of lights (found \"%s\"); give "
                       "auto:1 to auto:256",
                       sun->lights);
    if (spots && s->command == GP_COMMAND_BENCH)
        return gp_fail(log, GP_ERR_USAGE,
                       "--lights: bench measures what hides a light, and "
                       "nothing hides those of auto; give a file");
    if (sun->write_lights && !spots)
        return gp_fail(log, GP_ERR_USAGE,
                       "--write-lights: needs lights to "
                       "find; add --lights auto");
    sun->p.found = spots ? found : 0;
    return GP_OK;
}

/* Checks what is compared. */
static gp_status check_compare(const struct gp_log *log, struct gp_settings *s)
{
    enum { MOST_EXPOSURES = 64 };
    struct gp_compare_settings *const p = &s->compare;
    const char *const *const input = s->input.files.at;
    const double *const e = p->flip_exposures.v;
    // a limit of our own takes the place of idiff's default ones
    const bool own = gp_option_given(s, "fail-rel") ||
                     gp_option_given(s, "fail-flip");
    if (own && !gp_option_given(s, "fail"))
        p->limits.fail = INFINITY;
    if (own && !gp_option_given(s, "warn"))
        p->limits.warn = INFINITY;
    if (gp_is_dash(input[0]) && gp_is_dash(input[1]))
        return gp_fail(log, GP_ERR_USAGE,
                       "-: stdin holds only one image; give a file as the "
                       "other");
    if (p->flip_exposures.n &&
        !(e[2] >= 1.0 && e[2] <= MOST_EXPOSURES && e[2] == floor(e[2])))
        return gp_fail(log, GP_ERR_USAGE, "--flip-exposures: not a number of "
                       "exposures (found %g); give START,STOP,COUNT with a "
                       "count of 1 to %d", e[2], MOST_EXPOSURES);
    const char *const needs = p->heatmap ? "--heatmap"
                              : p->flip_exposures.n ? "--flip-exposures"
                              : isfinite(p->limits.fail_flip) ? "--fail-flip"
                                                              : NULL;
    if (!p->limits.flip && needs)
        return gp_fail(log, GP_ERR_USAGE, "--no-flip: %s needs FLIP; leave one "
                       "of the two out", needs);
    if (gp_is_dash(p->heatmap) || gp_is_dash(p->difference))
        return gp_fail(log, GP_ERR_USAGE, "--%s: stdout is for the figures "
                       "(found -); give a file",
                       gp_is_dash(p->heatmap) ? "heatmap" : "difference");
    return GP_OK;
}

// -- parameters of the library -----------------------------------------------

/* Has light of another frame be added. */
static gp_status set_mix(const struct gp_log *log, struct gp_settings *s)
{
    if (!s->light.source)
        return GP_OK;
    if (s->input.light_groups.n)
        return gp_fail(log, GP_ERR_USAGE,
                       "--source: has the light in place of "
                       "--light-group %s; leave one of the two out",
                       s->input.light_groups.at[0]);
    if (gp_option_given(s, "mix") && s->light.layer.mix == GLAREPP_SCATTER)
        return gp_fail(log, GP_ERR_USAGE,
                       "--mix: scatter takes light out of "
                       "the frame, which has none of --source; use --mix add");
    s->light.layer.mix = GLAREPP_ADD;
    return GP_OK;
}

/* Has --ocio env name the config. */
static gp_status find_config(const struct gp_log *log, const char **config)
{
    if (!*config || (**config && strcmp(*config, "env") != 0))
        return GP_OK;
    *config = getenv("OCIO");
    return *config && **config
               ? GP_OK
               : gp_fail(log, GP_ERR_USAGE, "--ocio: $OCIO is not set; set it, "
                         "or give another config, e.g. --ocio config.ocio");
}

void gp_settings_point(struct gp_settings *s)
{
    const bool given = gp_option_given(s, "kernel-normalize");
    const bool none = s->kernel.normalize == GP_NORMALIZE_NONE;
    struct glarepp_kernel_params *const k = &s->kernel.p;
    k->word = s->kernel.words.at;
    k->words = s->kernel.words.n;
    k->centred = s->kernel.centre.n > 0;
    memcpy(k->centre, s->kernel.centre.v, sizeof k->centre);
    k->as_it_is = given && none;
    k->normalized = given && !none;
    for (int c = 0; c < s->light.tint.n; c++)
        s->light.layer.tint[c] = (float) s->light.tint.v[c];
    // the sun of --sun or --sun-dir, and of --camera all but its place
    struct gp_sun_settings *const own = &s->sun;
    struct glarepp_light *const sun = &own->light;
    strcpy(sun->name, "sun");
    sun->place = own->at.n ? GLAREPP_PIXEL : GLAREPP_DIRECTION;
    memcpy(sun->at, own->at.n ? own->at.v : own->dir.v, sizeof sun->at);
    if (own->at.n == 3)
        sun->radius = fabs(own->at.v[2]);
    sun->degrees = (double) own->p.degrees;
    for (int c = 0; c < 3 && own->color.n; c++)
        sun->flux[c] = (float) own->color.v[own->color.n == 3 ? c : 0];
    own->p.light = sun;
    own->p.lights = own->at.n || own->dir.n;
    own->p.sun = *sun;
    own->p.faded = own->color.n > 0;
    s->scene.relight = s->sun.relight.at;
    s->scene.relights = s->sun.relight.n;
    s->tone.map.context = s->tone.context.at;
    s->tone.map.contexts = s->tone.context.n;
    s->plan.sense = &s->light.sense;
    s->plan.layer = &s->light.layer;
    s->plan.lights = &s->sun.p;
    s->plan.lens = &s->lens;
    s->plan.scene = &s->scene;
    s->plan.tone = &s->tone.map;
}

gp_status gp_settings_check(const struct gp_log *log, struct gp_settings *s)
{
    gp_status st;
    const struct gp_log *const warn = s->run.level < GP_LEVEL_WARN ? NULL : log;
    struct gp_sun_settings *const sun = &s->sun;
    st = check_inputs(log, s);
    if (st || s->command == GP_COMMAND_HELP)
        return st;
    if (s->command == GP_COMMAND_COMPARE)
        return check_compare(log, s);
    GP_TRY(set_lights_file(log, s));
    gp_settings_point(s);
    GP_TRY(find_config(log, &s->tone.map.config));
    if (s->scene.path && !gp_option_given(s, "sun-outside"))
        sun->p.outside = GLAREPP_BY_SCENE;
    if (!s->scene.path && sun->p.outside == GLAREPP_BY_SCENE)
        GP_TRY(gp_fail(log, GP_ERR_USAGE, "--sun-outside: scene needs --scene "
                       "FILE; give it, or another rule, e.g. --sun-outside "
                       "ignore"));
    sun->p.needed = first_in_need(s, GP_NEED_LIGHT) != NULL;
    if (s->command == GP_COMMAND_KERNEL) {
        GP_TRY(check_making(log, s));
        return check_kernels(log, s);
    }
    if (s->command == GP_COMMAND_LENS)
        return check_lens(log, s);
    if (s->command == GP_COMMAND_SETS)
        return check_sets(log, s);
    if (s->command == GP_COMMAND_STYLES)
        return check_styles(log, s);
    GP_TRY(check_outputs(log, s));
    GP_TRY(check_needs(log, s, false));
    GP_TRY(check_grow(log, s));
    GP_TRY(check_groups(log, s));
    if (sun->color.n == 2)
        GP_TRY(gp_fail(log, GP_ERR_USAGE,
                       "--sun-color: two numbers; give one or three"));
    if (sun->p.side % 2)
        GP_TRY(gp_fail(log, GP_ERR_USAGE,
                       "--sun-map: odd (found %d); give an even number",
                       sun->p.side));
    if (sun->relight.n && s->scene.light_scale > 0.0 && !sun->p.in_frame)
        gp_say(warn, GP_LEVEL_WARN,
               "--relight: its lamps glare as discs, too; add --sun-in-frame "
               "where the frame shows them, or is to be lit alone");
    if (sun->p.found && s->output.write.no_clobber)
        gp_say(warn, GP_LEVEL_WARN,
               "--lights auto: with --no-clobber the first frame that is made "
               "names them; give the file of --write-lights");
    GP_TRY(set_mix(log, s));
    // Ando et al. spread whole pixels and add the layer
    const bool bench = s->command == GP_COMMAND_BENCH;
    if (bench && s->bench.paper && !gp_option_given(s, "threshold-mode"))
        s->light.sense.whole = true;
    if (bench && s->bench.paper && !gp_option_given(s, "mix"))
        s->light.layer.mix = GLAREPP_ADD;
    if (!s->light.sense.whole && gp_option_given(s, "knee"))
        return gp_fail(log, GP_ERR_USAGE, "--knee: needs --threshold-mode "
                       "whole (found %g with excess); add it, or leave --knee "
                       "out", (double) s->light.sense.knee);
    GP_TRY(check_needs(warn, s, true));
    // settings that follow from several others
    if (gp_option_given(s, "raw"))
        s->output.write.stdout_format = GP_STDOUT_RAW;
    s->output.write.converted = s->tone.map.output != NULL;
    s->tone.map.shows =
        s->output.pictures.n > 0 || s->output.debug[GP_DEBUG_POLYGONS];
    // what is added to a picture is of its own lights; what is moved is missed
    if (!gp_option_given(s, "edges") && s->light.layer.mix == GLAREPP_ADD)
        s->light.layer.edges = GLAREPP_BLACK;
    if (s->light.mask && !*gp_mask_word_of(s->light.mask).word)
        GP_TRY(gp_fail(log, GP_ERR_USAGE,
                       "--source-mask: no name (found \"%s\"); "
                       "give a channel, a file or crypto:NAMES",
                       s->light.mask));
    GP_TRY(check_kernels(log, s));
    GP_TRY(gp_light_groups_read(log, s));
    for (int i = 0; i < s->input.group_kernels.n; i++)
        GP_TRY(check_word(log, s->input.group_kernels.at[i]));
out:
    return st;
}
