#include "app/options.h"

#include "app/compare.h"
#include "app/sun.h"
#include "io/file_name.h"

#include <string.h>

// -- settings that are right and do nothing -----------------------------------

static void warn_of_tone(const struct gp_log *log,
                         const struct gp_settings *s)
{
    const struct gp_tone_params *const t = &s->tone;
    if (s->ocio.config && t->white != 0.0f)
        gp_say(log, GP_LEVEL_WARN, "--white: does nothing with --ocio; leave "
               "it out");
    if (s->ocio.config)
        return;
    const bool none = strcmp(t->curve, "none") == 0;
    if (none && (t->exposure != 0.0f || t->auto_exposure))
        gp_say(log, GP_LEVEL_WARN, "--exposure: does nothing with --tonemap "
               "none; use --tonemap linear");
    if (t->white != 0.0f && strcmp(t->curve, "reinhard-extended") != 0)
        gp_say(log, GP_LEVEL_WARN, "--white: does nothing with --tonemap %s; "
               "use --tonemap reinhard-extended", t->curve);
}

/* The first option of splat that is not at its default, or NULL. */
static const char *splat_option(const struct gp_settings *s)
{
    const struct gp_splat_params *p = &s->glare.splat;
    const struct gp_splat_params *d = &gp_defaults.glare.splat;
    return p->group != d->group                 ? "group"
           : p->method != d->method             ? "group-method"
           : s->clustered                       ? "cluster"
           : p->cluster_fill != d->cluster_fill ? "cluster-fill"
           : p->shrink != d->shrink             ? "shrink"
           : p->primitive != d->primitive       ? "primitive" : NULL;
}

static void warn_of_engine(const struct gp_log *log,
                           const struct gp_settings *s)
{
    const char *const engine = s->glare.engine;
    const bool chosen = strcmp(engine, "auto") == 0;
    const bool splat = chosen || strcmp(engine, "splat") == 0;
    const char *const option = splat_option(s);
    if (option && !splat && !s->debug[GP_DEBUG_POLYGONS])
        gp_say(log, GP_LEVEL_WARN, "--%s: does nothing with --engine %s; use "
               "--engine splat", option, engine);
    if (s->glare.tolerance != gp_defaults.glare.tolerance && !chosen)
        gp_say(log, GP_LEVEL_WARN, "--tolerance: does nothing with --engine "
               "%s; use --engine auto", engine);
}

/* True when that output has no ending to say its format. */
static bool open_ended(const char *path)
{
    char ending[16];
    if (!path || !gp_file_is_straight(path))
        return false;
    gp_file_ending(path, ending, sizeof ending);
    return ending[0] == '\0';
}

static void warn_of_stdout(const struct gp_log *log,
                           const struct gp_settings *s)
{
    bool used = open_ended(s->hdr) || open_ended(s->layer);
    for (int i = 0; i < s->outputs.n; i++)
        used = used || open_ended(s->outputs.at[i]);
    for (int i = 0; i < GP_DEBUG_KINDS; i++)
        used = used || open_ended(s->debug[i]);
    if (!used && (s->raw_given || s->stdout_given))
        gp_say(log, GP_LEVEL_WARN, "--%s: does nothing, as no output is -; "
               "write -o -", s->raw_given ? "raw" : "stdout-format");
}

static void warn_of_files(const struct gp_log *log,
                          const struct gp_settings *s)
{
    bool any = s->outputs.n || s->hdr || s->layer;
    for (int i = 0; i < GP_DEBUG_KINDS; i++)
        any = any || s->debug[i];
    if (s->write.no_clobber && !any)
        gp_say(log, GP_LEVEL_WARN, "--no-clobber: does nothing, as no picture "
               "is written; leave it out");
}

// -- groups and clusters ------------------------------------------------------

static bool is_power_of_two(int n)
{
    return n > 0 && (n & (n - 1)) == 0;
}

static gp_status check_splat(const struct gp_log *log, struct gp_settings *s)
{
    struct gp_splat_params *const p = &s->glare.splat;
    if (!is_power_of_two(p->group))
        return gp_fail(log, GP_ERR_USAGE,
                       "--group: not a power of two (found %d); give 1, 2, 4, "
                       "8, 16, 32 or 64", p->group);
    if (!s->clustered && p->cluster <= p->group)
        p->cluster = 0;
    if (p->cluster == 0)
        return GP_OK;
    if (!is_power_of_two(p->cluster))
        return gp_fail(log, GP_ERR_USAGE,
                       "--cluster: not a power of two (found %d); give 0, 2, "
                       "4, 8, 16, 32 or 64", p->cluster);
    if (p->cluster <= p->group)
        return gp_fail(log, GP_ERR_USAGE,
                       "--cluster: no larger than --group (found %d and %d); "
                       "give a larger one, or 0 for none", p->cluster,
                       p->group);
    return GP_OK;
}

// -- suns and lamps -----------------------------------------------------------

/* The first option that needs a light and is there without one, or NULL. */
static const char *lightless_option(const struct gp_settings *s)
{
    const struct gp_sun_settings *const p = &s->sun;
    const struct gp_sun_settings *const d = &gp_defaults.sun;
    return p->flare                                   ? "flare"
           : p->color.n                               ? "sun-color"
           : p->mask                                  ? "mask"
           : p->mask_file                             ? "mask-file"
           : p->depth_file                            ? "depth-file"
           : p->in_frame                              ? "sun-in-frame"
           : p->adapt != d->adapt                     ? "sun-adapt"
           : p->params.method != d->params.method     ? "sun-method"
           : p->params.map != d->params.map           ? "sun-map"
           : p->params.pattern != d->params.pattern   ? "sun-pattern"
           : p->params.sum != d->params.sum           ? "sun-sum"
           : p->params.draw != d->params.draw         ? "sun-draw"
           : p->params.outside != d->params.outside   ? "sun-outside"
           : s->debug[GP_DEBUG_SUNMAP]                ? "debug sunmap"
           : s->debug[GP_DEBUG_INTENSITY]             ? "debug intensity"
                                                      : NULL;
}

/* The first option of the mask that another method does not use, or NULL. */
static const char *mask_option(const struct gp_settings *s)
{
    const struct gp_sun_params *const p = &s->sun.params;
    const struct gp_sun_params *const d = &gp_defaults.sun.params;
    if (p->method == GP_SUN_MASK)
        return NULL;
    if (p->sum != d->sum || p->draw != d->draw)
        return p->sum != d->sum ? "sun-sum" : "sun-draw";
    if (s->debug[GP_DEBUG_SUNMAP]) // shows what the map would be
        return NULL;
    return p->map != d->map           ? "sun-map"
           : p->pattern != d->pattern ? "sun-pattern" : NULL;
}

static gp_status check_sun(const struct gp_log *log,
                           const struct gp_settings *s)
{
    const struct gp_sun_settings *const p = &s->sun;
    const char *option = lightless_option(s);
    if (option && !gp_suns_wanted(p))
        return gp_fail(log, GP_ERR_USAGE,
                       "--%s: there is no light; give --sun, --sun-dir, "
                       "--camera or --lights", option);
    if (p->at.n && p->dir.n)
        return gp_fail(log, GP_ERR_USAGE,
                       "--sun-dir: the sun has a place by --sun already; "
                       "leave one out");
    if (p->at.n == 3 && p->at.v[2] < 0.0)
        return gp_fail(log, GP_ERR_USAGE,
                       "--sun: a negative radius (found %g); give 0 or more",
                       p->at.v[2]);
    if (p->color.n == 2)
        return gp_fail(log, GP_ERR_USAGE,
                       "--sun-color: two numbers; give one or three");
    if (p->params.map % 2)
        return gp_fail(log, GP_ERR_USAGE,
                       "--sun-map: odd (found %d); give an even number",
                       p->params.map);
    if (p->color.n && !p->at.n && !p->dir.n && !p->camera)
        return gp_fail(log, GP_ERR_USAGE,
                       "--sun-color: there is no sun; lights of --lights have "
                       "flux of their own");
    if (p->flare && !p->color.n && !p->lights)
        return gp_fail(log, GP_ERR_USAGE,
                       "--flare: the sun has no flux to make it of; give "
                       "--sun-color");
    if (p->params.sum == GP_SUM_BYTE && p->params.map > 16 &&
        p->params.method == GP_SUN_MASK && s->level >= GP_LEVEL_WARN)
        gp_say(log, GP_LEVEL_WARN, "--sun-sum 8bit: a map over 16 adds up to "
               "nothing (found %d); use --sun-map 16", p->params.map);
    option = mask_option(s);
    if (option && s->level >= GP_LEVEL_WARN &&
        s->command == GP_COMMAND_MAIN && gp_suns_wanted(p))
        gp_say(log, GP_LEVEL_WARN, "--%s: does nothing with this --sun-method; "
               "use --sun-method mask", option);
    return GP_OK;
}

// -- colour management --------------------------------------------------------

/* The first option that a config is for, or NULL; one of pictures comes
 * first. */
static const char *ocio_option(const struct gp_settings *s, bool *shows)
{
    const struct gp_ocio_params *const p = &s->ocio;
    *shows = p->display || p->view || p->look;
    return p->display          ? "display"
           : p->view           ? "view"
           : p->look           ? "look"
           : p->output         ? "output-space"
           : p->input          ? "input-space"
           : s->ocio_context.n ? "ocio-context" : NULL;
}

static gp_status check_ocio(const struct gp_log *log, struct gp_settings *s)
{
    struct gp_ocio_params *const p = &s->ocio;
    bool shows;
    const char *const option = ocio_option(s, &shows);
    if (!p->config && option)
        return gp_fail(log, GP_ERR_USAGE,
                       "--%s: there is no config; give --ocio CONFIG, or "
                       "--ocio env", option);
    if (p->config && s->toned)
        return gp_fail(log, GP_ERR_USAGE,
                       "--tonemap: --ocio takes its place; leave one of the "
                       "two out");
    p->shows = s->outputs.n > 0 || s->debug[GP_DEBUG_POLYGONS];
    if (shows && !p->shows)
        return gp_fail(log, GP_ERR_USAGE,
                       "--%s: there is no picture to show; give -o FILE",
                       option);
    if (p->output && !s->hdr)
        return gp_fail(log, GP_ERR_USAGE,
                       "--output-space: there is no frame to convert; give "
                       "--hdr FILE");
    p->context = s->ocio_context.at;
    p->contexts = s->ocio_context.n;
    s->write.converted = p->output != NULL;
    return GP_OK;
}

// -- what to read and to make -------------------------------------------------

static gp_status check_main(const struct gp_log *log,
                            const struct gp_settings *s)
{
    bool wants = s->outputs.n || s->hdr || s->layer || s->report;
    for (int i = 0; i < GP_DEBUG_KINDS; i++)
        wants = wants || s->debug[i];
    if (s->inputs.n == 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "no input; write glarepp -o out.png frame.exr, or see "
                       "glarepp --help");
    if (!wants)
        return gp_fail(log, GP_ERR_USAGE,
                       "nothing to make; write glarepp -o out.png %s, or see "
                       "glarepp --help", s->inputs.at[0]);
    if (s->verify && !s->report && s->level < GP_LEVEL_INFO)
        return gp_fail(log, GP_ERR_USAGE,
                       "--verify: its result would be shown nowhere; add "
                       "--report FILE or -v");
    return GP_OK;
}

static gp_status check_bench(const struct gp_log *log,
                             const struct gp_settings *s)
{
    if (s->bench.paper && s->inputs.n)
        return gp_fail(log, GP_ERR_USAGE,
                       "--paper: brings its own frames (found %s as well); "
                       "leave one of the two out", s->inputs.at[0]);
    if (s->bench.paper && gp_suns_wanted(&s->sun))
        return gp_fail(log, GP_ERR_USAGE,
                       "--paper: its frames have no depth for a light; leave "
                       "one of the two out");
    if (!s->bench.paper && s->inputs.n == 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "no input; write glarepp bench frame.exr, or glarepp "
                       "bench --paper");
    if (s->inputs.n > 1)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: one frame at a time is measured (found %d); give "
                       "one", s->inputs.at[1], s->inputs.n);
    return GP_OK;
}

static gp_status check_help(const struct gp_log *log,
                            const struct gp_settings *s)
{
    const int most = s->completion ? 0 : 1;
    if (s->inputs.n > most)
        return gp_fail(log, GP_ERR_USAGE,
                       "help: too many words (found %s); give one topic",
                       s->inputs.at[most]);
    return GP_OK;
}

/* --raw says what --stdout-format is. */
static gp_status check_stdout(const struct gp_log *log, struct gp_settings *s)
{
    if (s->raw_given && s->stdout_given &&
        s->write.stdout_format != GP_STDOUT_RAW)
        return gp_fail(log, GP_ERR_USAGE,
                       "--raw: --stdout-format says otherwise; leave one of "
                       "the two out");
    if (s->raw_given)
        s->write.stdout_format = GP_STDOUT_RAW;
    return GP_OK;
}

gp_status gp_settings_check(const struct gp_log *log, struct gp_settings *s)
{
    if (s->command == GP_COMMAND_HELP)
        return check_help(log, s);
    if (s->command == GP_COMMAND_COMPARE)
        return gp_compare_check(log, s);
    gp_status st = s->command == GP_COMMAND_BENCH ? check_bench(log, s)
                                                  : check_main(log, s);
    if (!st)
        st = check_stdout(log, s);
    if (!st)
        st = check_splat(log, s);
    if (!st)
        st = check_sun(log, s);
    if (!st)
        st = check_ocio(log, s);
    if (st)
        return st;
    if (s->compose.mix == GP_MIX_SCATTER && s->compose.gain > 1.0f)
        return gp_fail(log, GP_ERR_USAGE,
                       "--gain: more light would be scattered than there is "
                       "(found %g with --mix scatter); give 0 to 1, or --mix "
                       "add", (double) s->compose.gain);
    s->glare.gain = s->compose.gain;
    if (s->level >= GP_LEVEL_WARN) {
        warn_of_tone(log, s);
        warn_of_engine(log, s);
        warn_of_stdout(log, s);
        warn_of_files(log, s);
    }
    return GP_OK;
}
