// SPDX-License-Identifier: Apache-2.0
/* cli/options: what right lines set, and the messages of wrong ones; what the
 * library gets of them. */
#include "unit.h"
#include "cli/option_line.h"
#include "cli/words.h"

#include <float.h>

static void defaults_hold(void **state)
{
    struct gp_settings s;
    assert_ok(parse("-o a.png in.exr", &s));
    assert_int_equal(kept_lines, 0);
    assert_true(s.input.files.n == 1 && s.output.pictures.n == 1);
    assert_string_equal(s.input.files.at[0], "in.exr");
    assert_string_equal(s.output.pictures.at[0], "a.png");
    assert_string_equal(s.light.style, "camera");
    assert_false(s.kernel.p.centred);
    assert_string_equal(s.light.layer.engine, "auto");
    assert_true(s.light.sense.threshold == 1.0f &&
                s.light.sense.knee == 0.0f);
    assert_string_equal(s.tone.map.curve, "neutral");
    assert_int_equal(s.run.level, GP_LEVEL_WARN);
    gp_settings_free(&s);
    gp_settings_free(&s);
}

/* A line that may take the option: its command, and what it needs. */
static int line_for(const struct gp_option *o, const char *value, char *line,
                    size_t size)
{
    const bool sets = o->kind == GP_KIND_NAMED &&
                      (strcmp(value, "sets") == 0 ||
                       strcmp(value, "scissor") == 0);
    if (o->commands == GP_COMMAND_SETS || sets)
        return snprintf(line, size, "sets s");
    if (o->commands == GP_COMMAND_LENS)
        return snprintf(line, size, "lens --check f");
    if (o->commands & GP_COMMAND_KERNEL && !(o->commands & GP_COMMAND_MAIN))
        return snprintf(line, size, strcmp(o->name, "list") == 0 ||
                                            strcmp(o->name, "check") == 0
                                        ? "kernel" : "kernel -o o");
    if (!(o->commands & GP_COMMAND_MAIN))
        return snprintf(line, size, "%s",
                        o->needs & GP_NEED_OWN_FRAMES    ? "bench"
                        : o->commands & GP_COMMAND_BENCH ? "bench i"
                                                         : "compare a b");
    return snprintf(line, size, "-v -o a --hdr h i%s%s%s%s%s%s%s",
                    strcmp(value, "scene") == 0 ||
                            o->needs & (GP_NEED_SCENE | GP_NEED_RELIGHT)
                        ? " --scene s"
                        : "",
                    o->needs & GP_NEED_RELIGHT ? " --relight l" : "",
                    o->needs & GP_NEED_LENS ? " --lens l" : "",
                    o->needs & GP_NEED_FLARE ? " --flare f" : "",
                    strcmp(o->name, "write-lights") == 0 ? " --lights auto"
                                                         : "",
                    o->needs & GP_NEED_LIGHT || o->kind == GP_KIND_NAMED
                        ? " --sun 1,2 --sun-color 3"
                        : "",
                    o->needs & GP_NEED_CONFIG      ? " --ocio c"
                    : strcmp(o->name, "knee") == 0 ? " --threshold-mode whole"
                    : strncmp(o->name, "kernel-", 7) == 0 ? " -k k.exr"
                                                          : "");
}

/* Puts one value into the line, and checks where it is stored. */
static void check_stored(const struct gp_option *o, const char *value,
                         double v, int choice)
{
    struct gp_settings s;
    char line[256];
    const int n = line_for(o, value, line, sizeof line);
    snprintf(line + n, sizeof line - (size_t) n, " --%s%s%s%s", o->name,
             o->arg && o->arg[0] == '[' ? "=" : " ", value,
             o->kind == GP_KIND_NAMED ? "=f" : "");
    if (parse(line, &s) != GP_OK)
        fail_msg("%s: %s", line, kept_line);
    const void *const at = (const char *) &s + o->at;
    const struct gp_numbers *const list = at;
    const struct gp_texts *const texts = at;
    const char *const *const word = at;
    const bool stored =
        o->kind == GP_KIND_FLAG  ? *(const bool *) at == !o->off
        : o->kind == GP_KIND_SET ? *(const int *) at == o->set
        : o->kind == GP_KIND_FLOAT || o->kind == GP_KIND_LEVEL
            ? *(const float *) at == (float) v
        : o->kind == GP_KIND_REAL ? *(const double *) at == v
        : o->kind == GP_KIND_THRESHOLD
            ? ((const struct glarepp_sense_params *) at)->threshold == (float) v
        : o->kind == GP_KIND_SIZE
            ? ((const struct glarepp_kernel_params *) at)->percent == 7.0
        : o->kind == GP_KIND_INT   ? *(const int *) at == (int) v
        : o->kind == GP_KIND_COUNT ? *(const long long *) at == (long long) v
        : o->kind == GP_KIND_NUMBERS
            ? list->n == o->least && list->v[list->n - 1] == list->n
        : o->kind == GP_KIND_TEXT ? strcmp(*word, value) == 0
        : o->choices && o->kind != GP_KIND_NAMED
            ? gp_option_chosen(o, at)->value == choice
        : o->kind == GP_KIND_TEXTS ? strcmp(texts->at[texts->n - 1], value) == 0
                                   : strcmp(word[choice], "f") == 0;
    if (!stored || !gp_option_given(&s, o->name))
        fail_msg("%s: not stored", line);
    assert_false(gp_option_given(&s, "help-table"));
    gp_settings_free(&s);
}

/* Every option stores every value that it names; a number its largest one. */
static void every_option_is_stored(void **state)
{
    for (const struct gp_option *o = gp_options; o->name; o++) {
        const char *name, *text;
        char value[64] = "7";
        const double v = o->hi < (double) FLT_MAX ? o->hi : 2.5;
        if (!o->help || strcmp(o->name, "settings") == 0) // it must exist
            continue;
        if (o->kind == GP_KIND_FLAG || o->kind == GP_KIND_SET)
            value[0] = '\0';
        else if (o->arg && strcmp(o->arg, "WxH") == 0)
            snprintf(value, sizeof value, "7x7");
        else if (strcmp(o->name, "kernel") == 0)
            snprintf(value, sizeof value, "k.exr");
        else if (o->kind == GP_KIND_NUMBERS)
            snprintf(value, sizeof value, "%.*s", 2 * o->least - 1, "1,2,3");
        else if (o->kind >= GP_KIND_FLOAT && o->kind <= GP_KIND_COUNT)
            snprintf(value, sizeof value, "%.17g", v);
        if (!gp_option_value(o, 0, &text) || o->open)
            check_stored(o, value, v, 0);
        for (int i = 0; (name = gp_option_value(o, i, &text)); i++)
            check_stored(o, name, v, o->choices ? o->choices[i].value : 0);
    }
}

/* glarepp:command: what makes the same pixels, and no folder. */
static void commands_make_the_same_picture(void **state)
{
    static const struct {
        const char *line, *want;
    } rows[] = {
        {"-o a.png in.exr", "glarepp in.exr"},
        {"-t2 --gain=.5 -k /home/me/k.exr --layer l.exr /data/in.exr",
         "glarepp --threshold 2 --gain .5 --kernel k.exr in.exr"},
        {"-k builtin:star -o /a/b.png --threads 3 --frame-jobs 2 -q "
         "--create-dir --report /a/r.json --dither ../in.exr",
         "glarepp --kernel builtin:star --dither in.exr"},
        {"-k image:file=/a/b/k.exr,share=.1 -o a i",
         "glarepp --kernel image:file=k.exr,share=.1 i"},
        {"--light-group a:gain=2,kernel=/b/k.exr -o a i",
         "glarepp --light-group a:gain=2,kernel=k.exr i"},
        {"--light-group a:kernel=image:file=/b/k.exr,size=9,gain=2 -o a i",
         "glarepp --light-group a:kernel=image:file=k.exr,size=9,gain=2 i"},
        {"--ocio /c/c.ocio --ocio-context SHOT=/jobs/four --view A/B -o a i",
         "glarepp --ocio c.ocio --ocio-context SHOT=four --view A/B i"},
        {"--ocio ocio://default -o a it's", "glarepp --ocio ocio://default "
                                            "'it'\\''s'"},
        {"-o a x\ny\xff", "glarepp 'x y\xef\xbf\xbd'"},
        {"compare --heatmap /h.png --fail 1 /x/a.exr b.exr",
         "glarepp compare --fail 1 a.exr b.exr"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_settings s;
        char *text;
        assert_ok(parse(rows[i].line, &s));
        assert_ok(gp_command_text(&kept_log, &s, s.input.files.at,
                                  s.input.files.n, GP_COMMAND_NAMES, &text));
        assert_string_equal(text, rows[i].want);
        free(text);
        assert_ok(gp_command_text(&kept_log, &s, s.input.files.at,
                                  s.input.files.n, GP_COMMAND_WHOLE, &text));
        for (int k = 0; k < s.input.files.n; k++) // as given, but for quotes
            assert_true(!strchr(s.input.files.at[k], '/') ||
                        strstr(text, s.input.files.at[k]));
        free(text);
        gp_settings_free(&s);
    }
}

/* A value is in the word or the next one; the last one holds. */
static void forms_of_values(void **state)
{
    struct gp_settings s;
    assert_ok(parse("--output=a.png -ob.exr -t2.5 --knee .5 --layer=l "
                           "--threshold-mode whole i.exr --exposure -1.5 "
                           "-k k.exr --kernel-center 3.5,-2 --report - -q -v", &s));
    assert_int_equal(s.output.pictures.n, 2);
    assert_string_equal(s.output.pictures.at[1], "b.exr");
    assert_int_equal(s.output.layer.n, 1);
    assert_string_equal(s.output.layer.at[0], "l");
    assert_true(s.light.sense.threshold == 2.5f &&
                s.light.sense.knee == 0.5f);
    assert_true(s.tone.map.exposure == -1.5f && s.kernel.p.centred);
    assert_true(s.kernel.p.centre[0] == 3.5 &&
                s.kernel.p.centre[1] == -2.0);
    assert_string_equal(s.run.report, "-");
    assert_int_equal(s.run.level, GP_LEVEL_INFO);
    gp_settings_free(&s);
}

/* A threshold has three forms. */
static void forms_of_thresholds(void **state)
{
    static const struct {
        const char *word;
        float v;
        enum glarepp_threshold unit;
    } rows[] = {
        {"2.5", 2.5f, GLAREPP_LUMINANCE}, {"0", 0, GLAREPP_LUMINANCE},
        {"99.9%", 99.9f, GLAREPP_PERCENTILE}, {"0%", 0, GLAREPP_PERCENTILE},
        {"+3ev", 3, GLAREPP_EV}, {"-1.5ev", -1.5f, GLAREPP_EV},
        {"4EV", 4, GLAREPP_EV}, {"1e3", 1000, GLAREPP_LUMINANCE},
        {"1e1ev", 10, GLAREPP_EV},
    };
    static const char *const wrong[] = {
        "-1", "101%", "-1%", "65ev", "-65ev", "1ev%", "ev", "%", "1e%", "3e",
        "nan", "inf%", "",
    };
    struct gp_settings s;
    char line[64];
    for (size_t i = 0; i < COUNT(rows) + COUNT(wrong); i++) {
        const bool right = i < COUNT(rows);
        snprintf(line, sizeof line, "-o a i --threshold=%s",
                 right ? rows[i].word : wrong[i - COUNT(rows)]);
        const gp_status st = parse(line, &s);
        if (st != (right ? GP_OK : GP_ERR_USAGE) ||
            (right && (s.light.sense.threshold != rows[i].v ||
                       s.light.sense.unit != rows[i].unit)))
            fail_msg("%s: status %d, %g", line, st,
                     (double) s.light.sense.threshold);
        gp_settings_free(&s);
    }
}

static void words_that_look_like_options(void **state)
{
    struct gp_settings s;
    assert_ok(parse("-o - -", &s));
    assert_string_equal(s.output.pictures.at[0], "-");
    assert_string_equal(s.input.files.at[0], "-");
    gp_settings_free(&s);
    assert_ok(parse("i -g 1 -o a -g 2 j -- -k --help", &s));
    assert_int_equal(s.input.files.n, 4); // options stand anywhere before --
    assert_string_equal(s.input.files.at[3], "--help");
    assert_true(s.light.layer.gain == 2.0f); // the last one holds
    assert_null(s.words.help);
    gp_settings_free(&s);
    assert_ok(parse("--output=--hdr i", &s));
    assert_string_equal(s.output.pictures.at[0], "--hdr");
    gp_settings_free(&s);
    assert_ok(parse("--help", &s)); // needs no input
    assert_string_equal(s.words.help, "");
    gp_settings_free(&s);
    assert_ok(parse("--version -o x", &s));
    assert_true(s.words.version);
    gp_settings_free(&s);
}

/* The word after --help is its topic where it is all letters. */
static void topics_of_help(void **state)
{
    static const struct { const char *line, *topic; int inputs; } rows[] = {
        {"--help all", "all", 0}, {"-h kernels -o a", "kernels", 0},
        {"--help=sun-dir", "sun-dir", 0}, {"-hall", "all", 0},
        {"--help a.exr", "", 1}, {"--help -o a", "", 0}, {"--help=", "", 0},
        {"bench --help all", "all", 0}, {"a.exr --help", "", 1},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_settings s;
        assert_ok(parse(rows[i].line, &s));
        assert_string_equal(s.words.help, rows[i].topic);
        assert_int_equal(s.input.files.n, rows[i].inputs);
        gp_settings_free(&s);
    }
}

/* The paper's settings hold by themselves; a group as large as the default
 * cluster leaves no room for one, a cluster that was asked for stays. */
static void clusters_follow_groups(void **state)
{
    static const struct { const char *line; int group, cluster; } rows[] = {
        {"-e splat -o a i", 4, 8}, {"-e splat -o a i --group 1", 1, 8},
        {"-e splat -o a i --group 8", 8, 0}, {"-e splat -o a i --group 64", 64, 0},
        {"-e splat -o a i --group 8 --cluster 16", 8, 16},
        {"-e splat -o a i --group 32 --cluster 64", 32, 64},
        {"-e splat -o a i --group 4 --cluster 0", 4, 0},
        {"-e splat -o a i --group 1 --cluster 2", 1, 2},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_settings s;
        assert_ok(parse(rows[i].line, &s));
        assert_int_equal(s.light.layer.group, rows[i].group);
        assert_int_equal(s.light.layer.cluster, rows[i].cluster);
        assert_int_equal(kept_lines, 0);
        gp_settings_free(&s);
    }
}

/* The word of a command counts in the first place only. */
static void commands(void **state)
{
    static const struct {
        const char *line;
        enum gp_command command;
        int inputs;
        bool help;
    } rows[] = {
        {"bench i.exr --csv c -k builtin:eye -t 2 -v", GP_COMMAND_BENCH, 1, 0},
        {"bench --paper", GP_COMMAND_BENCH, 0, 0},
        {"bench --help", GP_COMMAND_BENCH, 0, 1},
        {"bench -- bench", GP_COMMAND_BENCH, 1, 0},
        {"-o a ./bench bench", GP_COMMAND_MAIN, 2, 0},
        {"compare a.exr b.exr --fail .5 --json j", GP_COMMAND_COMPARE, 2, 0},
        {"compare a b --html p.####.html --html-index i --html-size .5",
         GP_COMMAND_COMPARE, 2, 0},
        {"bench i.exr --html b.html", GP_COMMAND_BENCH, 1, 0},
        {"styles i.exr -o s.html --html-size 9", GP_COMMAND_STYLES, 1, 0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_settings s;
        assert_ok(parse(rows[i].line, &s));
        assert_int_equal(kept_lines, 0);
        assert_int_equal(s.command, rows[i].command);
        assert_int_equal(s.input.files.n, rows[i].inputs);
        assert_int_equal(s.words.help != NULL, rows[i].help);
        assert_true(s.bench.runs == 9 && isinf(s.compare.limits.hard_warn));
        gp_settings_free(&s);
    }
}

// -- what the library gets --------------------------------------------------

/* A plan points to each struct of the library, whose lists are filled in. */
static void plans_get_all_settings(void **state)
{
    struct gp_settings s;
    assert_ok(parse("--sun 1,2,3 --sun-color 4,5,6 --sun-size 7 --scene s "
                    "--relight all --ocio o --ocio-context A=B -o a i", &s));
    assert_true(s.plan.sense == &s.light.sense &&
                s.plan.layer == &s.light.layer && s.plan.lens == &s.lens &&
                s.plan.lights == &s.sun.p && s.plan.scene == &s.scene &&
                s.plan.tone == &s.tone.map && s.plan.tone->shows);
    const struct glarepp_light_params *const l = s.plan.lights;
    assert_true(l->lights == 1 && l->light->place == GLAREPP_PIXEL);
    assert_true(l->light->at[0] == 1.0 && l->light->at[1] == 2.0 &&
                l->light->radius == 3.0);
    assert_true(l->sun.flux[0] == 4.0f && l->sun.flux[2] == 6.0f &&
                l->sun.degrees == 7.0);
    assert_string_equal(l->sun.name, "sun");
    assert_int_equal(l->outside, GLAREPP_BY_SCENE);
    assert_int_equal(s.plan.scene->relights, 1);
    assert_string_equal(s.plan.scene->relight[0], "all");
    assert_int_equal(s.plan.tone->contexts, 1);
    assert_string_equal(s.plan.tone->context[0], "A=B");
    gp_settings_free(&s);
}

/* Another frame's light is added; the word of a mask is a file, or names. */
static void other_light_is_added(void **state)
{
    static const struct {
        const char *value, *word;
        bool crypto, inverted;
    } rows[] = {
        {"A", "A", false, false},
        {"!m.exr", "m.exr", false, true},
        {"crypto:a,b", "a,b", true, false},
        {"!crypto:*", "*", true, true},
        {"./crypto:a", "./crypto:a", false, false},
    };
    struct gp_settings s;
    assert_ok(parse("--source j --source-mask A -o a i", &s));
    assert_int_equal(s.light.layer.mix, GLAREPP_ADD);
    assert_int_equal(s.light.layer.edges, GLAREPP_BLACK);
    assert_string_equal(s.light.source, "j");
    gp_settings_free(&s);
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct gp_mask_word m = gp_mask_word_of(rows[i].value);
        assert_string_equal(m.word, rows[i].word);
        assert_true(m.crypto == rows[i].crypto &&
                    m.inverted == rows[i].inverted);
    }
}

/* A direction has its size by degrees, grey light all channels; without a light
 * there is none. */
static void suns_are_lights(void **state)
{
    struct gp_settings s;
    assert_ok(parse("--sun-dir 1,2,3 --sun-color 4 -o a i", &s));
    assert_int_equal(s.sun.light.place, GLAREPP_DIRECTION);
    assert_true(s.sun.light.at[2] == 3.0 && s.sun.light.radius < 0.0);
    assert_true(s.sun.light.degrees == (double) 0.533f && s.sun.light.flux[1] == 4.0f);
    assert_true(s.sun.p.needed && s.sun.p.faded);
    gp_settings_free(&s);
    assert_ok(parse("--sun 1,2 -o a i", &s));
    assert_true(s.sun.light.radius < 0.0 && s.sun.light.flux[0] == 0.0f); // the default
    gp_settings_free(&s);
    assert_ok(parse("-o a i", &s));
    assert_int_equal(s.sun.p.lights, 0);
    assert_null(s.lens.lens);
    assert_null(s.scene.path);
    assert_false(s.sun.p.needed);
    gp_settings_free(&s);
}

static void kernels_are_scaled_as_asked(void **state)
{
    static const struct {
        const char *line;
        bool as_it_is, normalized;
        double percent, degrees;
    } rows[] = {
        {"-o a i -k k.exr", false, false, 100.0, 0.0},
        {"-o a i -k k.exr --kernel-normalize none", true, false, 100.0, 0.0},
        {"-o a i -k k.exr --kernel-normalize luminance --kernel-size 50%",
         false, true, 50.0, 0.0},
        {"-o a i -k k.exr --kernel-size 2deg", false, false, 100.0, 2.0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_settings s;
        assert_ok(parse(rows[i].line, &s));
        const struct glarepp_kernel_params p = s.kernel.p;
        assert_int_equal(p.words, 1);
        assert_string_equal(p.word[0], "k.exr");
        assert_int_equal(p.as_it_is, rows[i].as_it_is);
        assert_int_equal(p.normalized, rows[i].normalized);
        assert_true(p.percent == rows[i].percent &&
                    p.degrees == rows[i].degrees);
        gp_settings_free(&s);
    }
}

/* A layer's kernel ends at ",gain="; kernels are listed once, without that of -k. */
static void groups_are_cut(void **state)
{
    struct gp_settings s;
    assert_ok(
        parse("-k star -o a i --light-group a:b:x=1 --light-group "
              "c:kernel=cross:share=.1,points=6,gain=.5 --light-group "
              "d:gain=2,kernel=star --light-group "
              "e:kernel=cross:share=.1,points=6 --light-group f:kernel=ring",
              &s));
    const struct gp_light_group want[] = {
        {"a:b:x=1", NULL, 0, 1.0f}, {"c", "cross:share=.1,points=6", 1, 0.5f},
        {"d", "star", 0, 2.0f},     {"e", "cross:share=.1,points=6", 1, 1.0f},
        {"f", "ring", 2, 1.0f},
    };
    for (size_t i = 0; i < COUNT(want); i++) {
        const struct gp_light_group *const g = &s.input.group[i];
        assert_string_equal(g->name, want[i].name);
        assert_true(!g->kernel == !want[i].kernel);
        if (g->kernel)
            assert_string_equal(g->kernel, want[i].kernel);
        assert_int_equal(g->more, want[i].more);
        assert_true(g->gain == want[i].gain);
    }
    assert_int_equal(s.input.group_kernels.n, 2);
    assert_string_equal(s.input.group_kernels.at[1], "ring");
    gp_settings_free(&s);
}

// -- lines that are wrong, or do nothing -------------------------------------

/* Values that an option does not take, beside those in tests/cli/errors.t: the
 * line names it. Words after "-o a i "; several with "|" between. */
static const char *const bad_values[][2] = {
    {"--gain", "-g ''|-g 1x|-g 1,5|-g nan"},
    {"-qv", "-qv"},
    {"--output", "-o ''"},
    {"--depth", "--depth ''|--depth="},
    {"--threshold", "-t -nan|-t 1e39"},
    {"--max-value", "--max-value nan"},
    {"--exposure", "--exposure -33"},
    {"--threads", "--threads 99999999999999999999"},
    {"--max-pixels", "--max-pixels 0|--max-pixels 1e6"},
    {"--kernel-center",
     "--kernel-center 1,|--kernel-center 1,2,3|"
     "--kernel-center ,2|--kernel-center nan,2|--kernel-center 1,inf"},
    {"--engine", "-e ''"},
    {"--debug", "--debug foo=x"},
    {"--sun", "--sun 1,2,3,4|--sun 1,2,|--sun 1,inf"},
    {"--sun-color", "--sun 1,2 --sun-color -1"},
    {"--tint", "--tint 1|--tint 1,2|--tint 1,2,-1"},
    {"--layer-saturation", "--layer-saturation -1|--layer-saturation 11"},
    {"--sun-map", "--sun 1,2 --sun-map 258"},
    {"--group", "--group 128|--group x"},
    {"--cluster", "--cluster -8"},
    {"--cluster-fill", "--cluster-fill 1.01"},
    {"--shrink", "--shrink nan"},
    {"--tolerance", "--tolerance nan"},
    {"--rotate", "--rotate inf|--rotate north"},
};

static const char *const wrong[][2] = {
    {"--gian=2 i", "did you mean --gain?"},
    {"--Knee 2 i", "did you mean --knee?"},
    {"--x i", "--x: "},
    {"--report a --report b i", "--report: "},
    {"--debug sensors=a --debug sensors=b i", "sensors: "},
    {"--help-ma i", "did you mean --help?"},
    {"-o a i --mask A", "--mask: "},
    {"-o a i --source j --light-group key", "--source: "},
    {"-o a i --source j --mix scatter", "--mix: "},
    {"-o a i -k k.exr --kernel-size 0", "--kernel-size: "},
    {"-o a i -k k.exr --kernel-size 2dag", "--kernel-size: "},
    {"-o a i -k k.exr --kernel-size 200deg", "--kernel-size: "},
    {"-o a i --kernel-size 50", "--kernel-size: is of one image"},
    {"-o a i -k k.exr -k star --kernel-center 1,2", "several kernels"},
    {"bench i -k k.exr -k star --kernel-normalize luminance", "of one image"},
    {"kernel --check star --kernel-size 50", "--kernel-size: "},
    {"kernel", ""},
    {"kernel --list -o k", ""},
    {"kernel -o k i", "i: "},
    {"kernel --check k i j", "j: "},
    {"kernel -o k --from a", "--from: no option any more; make the file"},
    {"-o a i --report-append", "--report - >>FILE"},
    {"kernel -o k --size 3", "--size: "},
    {"kernel -o k --size 3x3x", "--size: "},
    {"kernel -o k --size 0x3", "--size: "},
    {"-o a i --sun-method mask", "--sun-method: "},
    {"-o a i --sun-map 16", "--sun-map: "},
    {"-o a i --sun-adapt 0", "--sun-adapt: "},
    {"-o a i --group 1 --cluster 1", "--cluster: "},
    {"-o a i --csw", "--csw: "},
    {"bench --hdr a b", "--hdr: "},
    {"compare a b --html p --html q", "--html: "},
    {"compare a b --html-size 0.01", "--html-size: "},
    {"bench i --html-index x", "--html-index: "},
    {"bench --papr", "did you mean --paper?"},
    {"bench a --runs 0", "--runs: "},
    {"bench a --runs 1001", "--runs: "},
    {"bench a --knee 0.5", "--knee: "},
    {"bench --paper --knee 1 --threshold-mode excess", "--knee: "},
};

static void check_wrong(const char *line, const char *part)
{
    struct gp_settings s;
    gp_status st = parse(line, &s);
    if (st != GP_ERR_USAGE || kept_lines != 1 || !strstr(kept_line, part))
        fail_msg("\"%s\": status %d, %d lines: %s", line, st, kept_lines,
                 kept_line);
    gp_settings_free(&s);
}

static void errors_say_what_is_wrong(void **state)
{
    for (size_t i = 0; i < COUNT(wrong); i++)
        check_wrong(wrong[i][0], wrong[i][1]);
    for (size_t i = 0; i < COUNT(bad_values); i++) {
        char name[64];
        snprintf(name, sizeof name, "%s: ", bad_values[i][0]);
        for (const char *p = bad_values[i][1]; *p; p += *p == '|') {
            char line[256];
            const int n = (int) strcspn(p, "|");
            snprintf(line, sizeof line, "-o a i %.*s", n, p);
            check_wrong(line, name);
            p += n;
        }
    }
}

/* Settings that are right and do nothing; NULL: no message. */
static void warnings(void **state)
{
    static const char *const rows[][2] = {
        {"-o a i --tonemap none --exposure 1", "--exposure: "},
        {"-o a i --tonemap none --auto-exposure", "--auto-exposure: "},
        {"-o a i --tonemap hable --white 3", "--white: "},
        {"-o a i -e fft --group 8", "--group: "},
        {"-o a i -e fft --group 4", "--group: "}, // its default
        {"-o a i -e direct --cluster 8", "--cluster: "},
        {"-o a i -e splat --tolerance 0.1", "--tolerance: "},
        {"-o a i --sun 1,2 --sun-sum 8bit", "--sun-sum: "},
        {"--report r --no-clobber i", "--no-clobber: "},
        {"-o a i --raw rgb24", "--raw: "},
        // the polygons are drawn by it; the picture has that size
        {"-o a i -e fft --shrink 0 --debug polygons=p", NULL},
        {"-o a i --sun 1,2 --sun-map 8 --debug sunmap=m", NULL},
        {"-q -o a i --tonemap hable --white 3", NULL},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_settings s;
        assert_ok(parse(rows[i][0], &s));
        if (rows[i][1] ? !strstr(kept_line, rows[i][1]) : kept_lines != 0)
            fail_msg("%s: %s", rows[i][0], kept_line);
        gp_settings_free(&s);
    }
}

SUITE_OF(options, NULL, NULL, defaults_hold, every_option_is_stored,
         commands_make_the_same_picture, groups_are_cut, forms_of_values,
         forms_of_thresholds, words_that_look_like_options, topics_of_help,
         clusters_follow_groups, commands, plans_get_all_settings,
         other_light_is_added, suns_are_lights, kernels_are_scaled_as_asked,
         errors_say_what_is_wrong, warnings)
