/* Checks of settings that no single option can make. The option table has the
 * needs of each option, as bits (options.h); here is when a need is met, and
 * its message. */
#include "app/options.h"

#include "compare/compare.h"
#include "io/file.h"

#include <string.h>

// -- what options need of others ---------------------------------------------

/* In the order in which they are checked. A message is put after "--NAME: ",
 * and where it has two parts, the value that is in the way between them. */
static const struct need {
    unsigned bit;
    bool warns;            // else it is an error
    const char *text, *end;
} needs[] = {
    {GP_NEED_OWN_FRAMES, false, "brings its own frames (found ",
     " as well); leave one of the two out"},
    {GP_NEED_NO_LIGHT, false, "its frames have no depth for a light; leave "
     "one of the two out", NULL},
    {GP_NEED_REPORT, false, "its result would be shown nowhere; add --report "
     "FILE or -v", NULL},
    {GP_NEED_RAW, false, "--stdout-format says otherwise; leave one of the "
     "two out", NULL},
    {GP_NEED_LIGHT, false, "there is no light; give --sun, --sun-dir, "
     "--camera or --lights", NULL},
    {GP_NEED_NO_PLACE, false, "the sun has a place by --sun already; leave "
     "one out", NULL},
    {GP_NEED_SUN, false, "there is no sun; lights of --lights have flux of "
     "their own", NULL},
    {GP_NEED_FLUX, false, "the sun has no flux to make it of; give "
     "--sun-color", NULL},
    {GP_NEED_CONFIG, false, "there is no config; give --ocio CONFIG, or "
     "--ocio env", NULL},
    {GP_NEED_NO_CONFIG, false, "--ocio takes its place; leave one of the two "
     "out", NULL},
    {GP_NEED_PICTURE, false, "there is no picture to show; give -o FILE", NULL},
    {GP_NEED_HDR, false, "there is no frame to convert; give --hdr FILE", NULL},
    {GP_NEED_MASK, true, "does nothing with this --sun-method; use "
     "--sun-method mask", NULL},
    {GP_NEED_MAP, true, "does nothing with this --sun-method; use "
     "--sun-method mask", NULL},
    {GP_NEED_TONES, true, "does nothing with --ocio; leave it out", NULL},
    {GP_NEED_CURVE, true, "does nothing with --tonemap none; use --tonemap "
     "linear", NULL},
    {GP_NEED_EXTENDED, true, "does nothing with --tonemap ",
     "; use --tonemap reinhard-extended"},
    {GP_NEED_SPLAT, true, "does nothing with --engine ",
     "; use --engine splat"},
    {GP_NEED_AUTO, true, "does nothing with --engine ", "; use --engine auto"},
    {GP_NEED_STREAM, true, "does nothing, as no output is -; write -o -", NULL},
    {GP_NEED_FILES, true, "does nothing, as no picture is written; leave it "
     "out", NULL},
};
enum { NEEDS = sizeof needs / sizeof *needs };

/* True when that output has no ending that names its format. */
static bool open_ended(const char *path)
{
    char ending[16];
    if (!path || !gp_file_is_straight(path))
        return false;
    gp_file_ending(path, ending, sizeof ending);
    return ending[0] == '\0';
}

/* The needs that these settings meet. */
static unsigned needs_met(const struct gp_settings *s)
{
    const struct gp_sun_params *const sun = &s->sun;
    const bool light = gp_suns_wanted(sun), config = s->ocio.config != NULL;
    const bool mask = sun->method == GP_SUN_MASK ||
                      s->command == GP_COMMAND_BENCH; // measures them all
    const bool polygons = s->debug[GP_DEBUG_POLYGONS] != NULL;
    const bool chosen = strcmp(s->glare.engine, "auto") == 0;
    bool stream = open_ended(s->hdr) || open_ended(s->layer);
    bool files = s->outputs.n || s->hdr || s->layer;
    for (int i = 0; i < s->outputs.n; i++)
        stream = stream || open_ended(s->outputs.at[i]);
    for (int i = 0; i < GP_DEBUG_KINDS; i++) {
        stream = stream || open_ended(s->debug[i]);
        files = files || s->debug[i];
    }
    const struct {
        unsigned bit;
        bool met;
    } list[] = {
        {GP_NEED_OWN_FRAMES, s->inputs.n == 0}, {GP_NEED_NO_LIGHT, !light},
        {GP_NEED_REPORT, s->report || s->level >= GP_LEVEL_INFO},
        {GP_NEED_RAW, !gp_option_given(s, "stdout-format") ||
                          s->write.stdout_format == GP_STDOUT_RAW},
        {GP_NEED_LIGHT, light}, {GP_NEED_NO_PLACE, !sun->at.n},
        {GP_NEED_SUN, sun->at.n || sun->dir.n || sun->camera},
        {GP_NEED_FLUX, sun->color.n || sun->lights}, {GP_NEED_CONFIG, config},
        {GP_NEED_NO_CONFIG, !config},
        {GP_NEED_PICTURE, s->outputs.n || polygons}, {GP_NEED_HDR, s->hdr},
        {GP_NEED_MASK, mask},
        {GP_NEED_MAP, mask || s->debug[GP_DEBUG_SUNMAP]},
        {GP_NEED_TONES, !config},
        {GP_NEED_CURVE, config || strcmp(s->tone.curve, "none") != 0},
        {GP_NEED_EXTENDED,
         config || strcmp(s->tone.curve, "reinhard-extended") == 0},
        {GP_NEED_SPLAT,
         chosen || strcmp(s->glare.engine, "splat") == 0 || polygons},
        {GP_NEED_AUTO, chosen}, {GP_NEED_STREAM, stream},
        {GP_NEED_FILES, files},
    };
    unsigned met = 0;
    for (size_t i = 0; i < sizeof list / sizeof *list; i++)
        met |= list[i].met ? list[i].bit : 0u;
    return met;
}

/* Says which option has a need that is not met: `warns` for settings that are
 * right and do nothing, else an error. */
static gp_status check_needs(const struct gp_log *log,
                             const struct gp_settings *s, bool warns)
{
    const unsigned met = needs_met(s);
    for (int i = 0; i < NEEDS; i++) {
        const struct need *const n = &needs[i];
        if (n->warns != warns || (met & n->bit))
            continue;
        const char *name = NULL; // of the first option with that need
        for (const struct gp_option *o = gp_options; o->name && !name; o++)
            name = (o->needs & n->bit) && gp_option_given(s, o->name) ? o->name
                                                                      : NULL;
        if (!name && n->bit == GP_NEED_LIGHT)
            name = s->debug[GP_DEBUG_SUNMAP]      ? "debug sunmap"
                   : s->debug[GP_DEBUG_INTENSITY] ? "debug intensity" : NULL;
        const char *const value = !n->end ? ""
            : n->bit == GP_NEED_OWN_FRAMES ? s->inputs.at[0]
            : n->bit == GP_NEED_EXTENDED ? s->tone.curve : s->glare.engine;
        if (name && !warns)
            return gp_fail(log, GP_ERR_USAGE, "--%s: %s%s%s", name, n->text,
                           value, n->end ? n->end : "");
        if (name)
            gp_say(log, GP_LEVEL_WARN, "--%s: %s%s%s", name, n->text, value,
                   n->end ? n->end : "");
    }
    return GP_OK;
}

// -- values ------------------------------------------------------------------

static bool is_power_of_two(int n)
{
    return n > 0 && (n & (n - 1)) == 0;
}

/* Groups and clusters of splat. A cluster that was not asked for goes where
 * groups are as large. */
static gp_status check_splat(const struct gp_log *log, struct gp_settings *s)
{
    struct gp_splat_params *const p = &s->glare.splat;
    if (!is_power_of_two(p->group))
        return gp_fail(log, GP_ERR_USAGE, "--group: not a power of two (found "
                       "%d); give 1, 2, 4, 8, 16, 32 or 64", p->group);
    if (!gp_option_given(s, "cluster") && p->cluster <= p->group)
        p->cluster = 0;
    if (p->cluster != 0 && !is_power_of_two(p->cluster))
        return gp_fail(log, GP_ERR_USAGE, "--cluster: not a power of two "
                       "(found %d); give 0, 2, 4, 8, 16, 32 or 64", p->cluster);
    if (p->cluster != 0 && p->cluster <= p->group)
        return gp_fail(log, GP_ERR_USAGE, "--cluster: no larger than --group "
                       "(found %d and %d); give a larger one, or 0 for none",
                       p->cluster, p->group);
    return GP_OK;
}

static gp_status check_sun(const struct gp_log *log, const struct gp_log *warn,
                           const struct gp_settings *s)
{
    const struct gp_sun_params *const p = &s->sun;
    if (p->at.n == 3 && p->at.v[2] < 0.0)
        return gp_fail(log, GP_ERR_USAGE, "--sun: a negative radius (found "
                       "%g); give 0 or more", p->at.v[2]);
    if (p->color.n == 2)
        return gp_fail(log, GP_ERR_USAGE,
                       "--sun-color: two numbers; give one or three");
    if (p->map.side % 2)
        return gp_fail(log, GP_ERR_USAGE, "--sun-map: odd (found %d); give "
                       "an even number", p->map.side);
    if (p->map.sum == GP_SUM_BYTE && p->map.side > 16 &&
        p->method == GP_SUN_MASK)
        gp_say(warn, GP_LEVEL_WARN, "--sun-sum 8bit: a map over 16 adds up to "
               "nothing (found %d); use --sun-map 16", p->map.side);
    return GP_OK;
}

/* Something must be read and made. */
static gp_status check_files(const struct gp_log *log,
                             const struct gp_settings *s)
{
    bool wants = s->outputs.n || s->hdr || s->layer || s->report;
    for (int i = 0; i < GP_DEBUG_KINDS; i++)
        wants = wants || s->debug[i];
    if (s->command == GP_COMMAND_BENCH) {
        if (!s->bench.paper && s->inputs.n == 0)
            return gp_fail(log, GP_ERR_USAGE, "no input; write glarepp bench "
                           "frame.exr, or glarepp bench --paper");
        if (!s->bench.paper && s->inputs.n > 1)
            return gp_fail(log, GP_ERR_USAGE, "%s: one frame at a time is "
                "measured (found %d); give one", s->inputs.at[1], s->inputs.n);
        return GP_OK;
    }
    if (s->inputs.n == 0)
        return gp_fail(log, GP_ERR_USAGE, "no input; write glarepp -o out.png "
                       "frame.exr, or see glarepp --help");
    if (!wants)
        return gp_fail(log, GP_ERR_USAGE, "nothing to make; write glarepp -o "
                       "out.png %s, or see glarepp --help", s->inputs.at[0]);
    return GP_OK;
}

gp_status gp_settings_check(const struct gp_log *log, struct gp_settings *s)
{
    gp_status st;
    const struct gp_log *const warn = s->level < GP_LEVEL_WARN ? NULL : log;
    const int words = s->completion ? 0 : 1;
    if (s->command == GP_COMMAND_HELP && s->inputs.n > words)
        return gp_fail(log, GP_ERR_USAGE, "help: too many words (found %s); "
                       "give one topic", s->inputs.at[words]);
    if (s->command == GP_COMMAND_HELP)
        return GP_OK;
    if (s->command == GP_COMMAND_COMPARE)
        return gp_compare_check(log, s->inputs.at, s->inputs.n, &s->compare);
    GP_TRY(check_files(log, s));
    GP_TRY(check_needs(log, s, false));
    GP_TRY(check_splat(log, s));
    GP_TRY(check_sun(log, warn, s));
    if (s->compose.mix == GP_MIX_SCATTER && s->compose.gain > 1.0f)
        return gp_fail(log, GP_ERR_USAGE, "--gain: more light would be "
                       "scattered than there is (found %g with --mix scatter); "
                       "give 0 to 1, or --mix add", (double) s->compose.gain);
    GP_TRY(check_needs(warn, s, true));
    // what follows from several settings
    if (gp_option_given(s, "raw"))
        s->write.stdout_format = GP_STDOUT_RAW;
    s->write.converted = s->ocio.output != NULL;
    s->kernel.centered = gp_option_given(s, "kernel-center");
    s->ocio.shows = s->outputs.n > 0 || s->debug[GP_DEBUG_POLYGONS];
    s->ocio.context = s->ocio_context.at;
    s->ocio.contexts = s->ocio_context.n;
    s->glare.gain = s->compose.gain;
out:
    return st;
}
