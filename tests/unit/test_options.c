/* app/options: parsing, ranges, errors, and the help made from one table. */
#include "app/options.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WORDS = 40, LINE = 4096 };

static char said[LINE];  // the last message
static int lines;        // how many there were

static void keep_line(void *user, enum gp_level level, const char *line)
{
    (void) user;
    (void) level;
    lines++;
    snprintf(said, sizeof said, "%s", line);
}

static const struct gp_log keeper = {keep_line, NULL, GP_LEVEL_INFO};

/* Parses a line of words with single blanks between; '' is an empty word. */
static gp_status parse(const char *line, struct gp_settings *s)
{
    static char copy[1024];
    char *argv[WORDS] = {"glarepp"};
    int argc = 1;
    snprintf(copy, sizeof copy, "%s", line);
    for (char *w = strtok(copy, " "); w && argc < WORDS - 1;
         w = strtok(NULL, " "))
        argv[argc++] = strcmp(w, "''") == 0 ? "" : w;
    said[0] = '\0';
    lines = 0;
    return gp_options_parse(&keeper, argc, argv, s);
}

// -- lines that are right ----------------------------------------------------

static void defaults_hold(void **state)
{
    (void) state;
    struct gp_settings s;
    assert_int_equal(parse("-o a.png in.exr", &s), GP_OK);
    assert_int_equal(lines, 0);
    assert_int_equal(s.inputs.n, 1);
    assert_string_equal(s.inputs.at[0], "in.exr");
    assert_int_equal(s.outputs.n, 1);
    assert_string_equal(s.outputs.at[0], "a.png");
    assert_string_equal(s.kernel.source, "builtin:eye");
    assert_false(s.kernel.centered);
    assert_string_equal(s.glare.engine, "auto");
    assert_true(s.sensor.threshold == 1.0f && s.sensor.knee == 0.0f);
    assert_true(s.sensor.max_value == 65504.0f);
    assert_true(s.compose.gain == 1.0f && s.glare.gain == 1.0f);
    assert_int_equal(s.compose.mix, GP_MIX_ADD);
    assert_string_equal(s.tone.curve, "reinhard");
    assert_int_equal(s.write.compression, GP_COMPRESSION_AUTO);
    assert_int_equal(s.level, GP_LEVEL_WARN);
    gp_settings_free(&s);
    gp_settings_free(&s);
}

static void every_option_is_stored(void **state)
{
    (void) state;
    struct gp_settings s;
    assert_int_equal(parse("--output=a.png -ob.exr --hdr h.exr --layer=l.exr "
                           "--debug sensors=s.exr i.exr --report - -v", &s),
                     GP_OK);
    assert_int_equal(s.outputs.n, 2);
    assert_string_equal(s.outputs.at[1], "b.exr");
    assert_string_equal(s.hdr, "h.exr");
    assert_string_equal(s.layer, "l.exr");
    assert_string_equal(s.debug[GP_DEBUG_SENSORS], "s.exr");
    assert_string_equal(s.report, "-");
    assert_int_equal(s.level, GP_LEVEL_INFO);
    gp_settings_free(&s);

    assert_int_equal(parse("-o a i -t2.5 --knee .5 -g 0.25 --mix scatter "
                           "--max-value 1e5 -k k.exr --kernel-center 3.5,-2 "
                           "--kernel-normalize none -f 1-9 --depth d.Z "
                           "--max-pixels 1000000000000", &s), GP_OK);
    assert_true(s.sensor.threshold == 2.5f && s.sensor.knee == 0.5f);
    assert_true(s.sensor.max_value == 1e5f);
    assert_true(s.compose.gain == 0.25f && s.glare.gain == 0.25f);
    assert_int_equal(s.compose.mix, GP_MIX_SCATTER);
    assert_string_equal(s.kernel.source, "k.exr");
    assert_true(s.kernel.centered);
    assert_true(s.kernel.center[0] == 3.5 && s.kernel.center[1] == -2.0);
    assert_int_equal(s.kernel.normalize, GP_NORMALIZE_NONE);
    assert_string_equal(s.frames, "1-9");
    assert_string_equal(s.depth, "d.Z");
    assert_true(s.read.max_pixels == 1000000000000LL);
    gp_settings_free(&s);

    assert_int_equal(parse("-o a i -e fft --gl egl --fft-plan measure "
                           "--threads 3 --tonemap reinhard-extended --exposure "
                           "-1.5 --auto-exposure --white 4 --type float "
                           "--compression dwab --depth-bits 16", &s), GP_OK);
    assert_int_equal(lines, 0);
    assert_string_equal(s.glare.engine, "fft");
    assert_int_equal(s.glare.gl, GP_GL_EGL);
    assert_int_equal(s.glare.fft_plan, GP_FFT_PLAN_MEASURE);
    assert_int_equal(s.threads, 3);
    assert_string_equal(s.tone.curve, "reinhard-extended");
    assert_true(s.tone.exposure == -1.5f && s.tone.white == 4.0f);
    assert_true(s.tone.auto_exposure);
    assert_int_equal(s.write.type, GP_OUT_FLOAT);
    assert_int_equal(s.write.compression, GP_COMPRESSION_DWAB);
    assert_int_equal(s.write.depth_bits, 16);
    gp_settings_free(&s);

    assert_int_equal(parse("-o a i --dither --alpha keep --create-dir "
                           "--verify --progress never -q -v", &s), GP_OK);
    assert_true(s.write.dither && s.write.create_dir && s.verify);
    assert_int_equal(s.write.alpha, GP_ALPHA_KEEP);
    assert_int_equal(s.progress, GP_PROGRESS_NEVER);
    assert_int_equal(s.level, GP_LEVEL_INFO);
    gp_settings_free(&s);
}

static void words_that_look_like_options(void **state)
{
    (void) state;
    struct gp_settings s;
    assert_int_equal(parse("-o - -", &s), GP_OK);
    assert_string_equal(s.outputs.at[0], "-");
    assert_string_equal(s.inputs.at[0], "-");
    gp_settings_free(&s);
    assert_int_equal(parse("i -g 1 -o a -g 2 j -- -k --help", &s), GP_OK);
    assert_int_equal(s.inputs.n, 4); // options stand anywhere before --
    assert_string_equal(s.inputs.at[3], "--help");
    assert_true(s.compose.gain == 2.0f); // the last one holds
    assert_false(s.help);
    gp_settings_free(&s);
    assert_int_equal(parse("--output=--hdr i", &s), GP_OK);
    assert_string_equal(s.outputs.at[0], "--hdr");
    gp_settings_free(&s);
    assert_int_equal(parse("--help", &s), GP_OK); // needs no input
    assert_true(s.help);
    gp_settings_free(&s);
    assert_int_equal(parse("--version -o x", &s), GP_OK);
    assert_true(s.version);
    gp_settings_free(&s);
}

// -- lines that are wrong ----------------------------------------------------

struct error_row {
    const char *line;
    const char *part;  // of the message
};

static const struct error_row errors[] = {
    {"", "no input; write glarepp -o out.png frame.exr"},
    {"-o a.png", "no input"},
    {"f.exr", "nothing to make; write glarepp -o out.png f.exr"},
    {"-v -t 2 f.exr", "nothing to make"},
    {"--gian 2 i", "--gian: unknown option; did you mean --gain?"},
    {"--gian=2 i", "--gian: unknown option; did you mean --gain?"},
    {"--treshold 2 i", "did you mean --threshold?"},
    {"--Knee 2 i", "did you mean --knee?"},
    {"--xyzzyquux i", "glarepp --help lists them"},
    {"--x i", "glarepp --help lists them"},
    {"-Z i", "-Z: unknown option"},
    {"--help-ma i", "did you mean --help?"},
    {"-o a i --gain", "--gain: needs a value; give G"},
    {"-o a i -g", "-g: needs a value"},
    {"-o --hdr i", "-o: needs a value (found the option --hdr)"},
    {"-o a i --dither=1", "takes no value (found \"1\")"},
    {"-o a i -qv", "takes no value (found \"v\")"},
    {"-o '' i", "--output: needs a value"},
    {"-o a i --depth ''", "--depth: needs a value"},
    {"-o a i --depth=", "--depth: needs a value"},
    {"-o a i -g ''", "--gain: not a number (found \"\")"},
    {"-o a i -g x", "--gain: not a number (found \"x\")"},
    {"-o a i -g 1x", "--gain: not a number"},
    {"-o a i -g 1,5", "--gain: not a number"},
    {"-o a i -g -0.1", "--gain: out of range (found -0.1)"},
    {"-o a i -g nan", "--gain: out of range (found nan)"},
    {"-o a i -g inf", "--gain: out of range"},
    {"-o a i -t nan", "--threshold: out of range"},
    {"-o a i -t -nan", "--threshold: out of range"},
    {"-o a i -t 1e39", "--threshold: out of range (found 1e39)"},
    {"-o a i --knee 1.001", "give 0 to 1"},
    {"-o a i --max-value 0", "give more than 0"},
    {"-o a i --max-value nan", "--max-value: out of range"},
    {"-o a i --exposure -33", "give -32 to 32"},
    {"-o a i --threads 1.5", "--threads: not a whole number"},
    {"-o a i --threads -1", "--threads: out of range"},
    {"-o a i --threads 99999999999999999999", "--threads: out of range"},
    {"-o a i --max-pixels 0", "--max-pixels: out of range"},
    {"-o a i --max-pixels 1e6", "--max-pixels: not a whole number"},
    {"-o a i --kernel-center 1", "--kernel-center: not two numbers"},
    {"-o a i --kernel-center 1,", "--kernel-center: not two numbers"},
    {"-o a i --kernel-center 1,2,3", "--kernel-center: not two numbers"},
    {"-o a i --kernel-center ,2", "--kernel-center: not two numbers"},
    {"-o a i --kernel-center nan,2", "--kernel-center: out of range"},
    {"-o a i --kernel-center 1,inf", "--kernel-center: out of range"},
    {"-o a i -e gpu", "(found \"gpu\"); give one of auto, direct, fft, splat"},
    {"-o a i -e ''", "--engine: no such value"},
    {"-o a i --tonemap filmic", "give one of reinhard, reinhard-extended"},
    {"-o a i -k builtin:foo", "give one of builtin:eye"},
    {"-o a i --mix screen", "give one of add, scatter"},
    {"-o a i --compression lzw", "none, rle, zips, zip, piz, pxr24, b44"},
    {"-o a i --depth-bits 12", "give one of 8, 16"},
    {"-o a i --debug foo=x", "give one of sensors"},
    {"-o a i --debug sensors", "write sensors=FILE"},
    {"-o a i --debug sensors=", "write sensors=FILE"},
    {"-o a i --mix scatter -g 1.5", "more light would be scattered"},
    {"-o a i --verify", "--verify: its result would be shown nowhere"},
    {"-o a i --sun 1,2", "unknown option"},
};

static void errors_say_what_is_wrong(void **state)
{
    (void) state;
    for (size_t i = 0; i < sizeof errors / sizeof errors[0]; i++) {
        const struct error_row *r = &errors[i];
        struct gp_settings s;
        gp_status st = parse(r->line, &s);
        if (st != GP_ERR_USAGE || lines != 1 || !strstr(said, r->part))
            fail_msg("\"%s\": status %d, %d lines: %s", r->line, st, lines,
                     said);
        gp_settings_free(&s);
    }
}

static void warnings(void **state)
{
    (void) state;
    struct gp_settings s;
    assert_int_equal(parse("-o a i --tonemap none --exposure 1", &s), GP_OK);
    assert_non_null(strstr(said, "--exposure: does nothing"));
    gp_settings_free(&s);
    assert_int_equal(parse("-o a i --tonemap hable --white 3", &s), GP_OK);
    assert_non_null(strstr(said, "--white: does nothing"));
    gp_settings_free(&s);
    assert_int_equal(parse("-q -o a i --tonemap hable --white 3", &s), GP_OK);
    assert_int_equal(lines, 0);
    gp_settings_free(&s);
}

// -- laws of the table -------------------------------------------------------

static void the_table_is_sound(void **state)
{
    (void) state;
    for (const struct gp_option *o = gp_options; o->name; o++) {
        const char *text;
        assert_ptr_equal(gp_option_find(o->name, strlen(o->name)), o);
        if (o->letter)
            assert_ptr_equal(gp_option_letter(o->letter), o);
        bool number = o->kind == GP_KIND_FLOAT || o->kind == GP_KIND_INT ||
                      o->kind == GP_KIND_COUNT || o->kind == GP_KIND_PAIR;
        bool none = o->kind == GP_KIND_FLAG || o->kind == GP_KIND_SET;
        assert_true(!number || o->lo < o->hi);
        assert_int_equal(none, o->arg == NULL);
        assert_true((o->kind == GP_KIND_CHOICE || o->kind == GP_KIND_NAMED) ==
                    (o->choices != NULL));
        assert_true(o->help[strlen(o->help) - 1] != '.');
        if (o->choices || o->list)
            assert_non_null(gp_option_value(o, 0, &text));
    }
    assert_null(gp_option_letter('\0'));
    assert_null(gp_option_find("", 0));
}

/* Each value that an option names is one that it takes. */
static void named_values_parse(void **state)
{
    (void) state;
    for (const struct gp_option *o = gp_options; o->name; o++) {
        const char *name, *text;
        for (int i = 0; (name = gp_option_value(o, i, &text)); i++) {
            struct gp_settings s;
            char line[256];
            snprintf(line, sizeof line, "-o a i --%s %s%s", o->name, name,
                     o->kind == GP_KIND_NAMED ? "=f" : "");
            if (parse(line, &s) != GP_OK)
                fail_msg("%s: %s", line, said);
            gp_settings_free(&s);
        }
    }
}

/* What `print` writes, in memory; the caller frees it. */
static char *printed(void (*print)(FILE *))
{
    char *text = NULL;
    size_t size;
    FILE *f = open_memstream(&text, &size);
    print(f);
    fclose(f);
    return text;
}

static void help_is_complete(void **state)
{
    (void) state;
    char *help = printed(gp_help), *man = printed(gp_help_man);
    for (const struct gp_option *o = gp_options; o->name; o++) {
        char name[64];
        snprintf(name, sizeof name, " --%s%s%s", o->name, o->arg ? " " : "",
                 o->arg ? o->arg : "");
        assert_int_equal(strstr(help, name) != NULL, !o->hidden);
        snprintf(name, sizeof name, "Fl \\-%s", o->name);
        assert_int_equal(strstr(man, name) != NULL, !o->hidden);
    }
    int width = 0;
    for (const char *c = help; *c; c++) {
        width = *c == '\n' ? 0 : width + 1;
        assert_true(width < 80);
    }
    assert_non_null(strstr(help, "default 65504)"));
    assert_non_null(strstr(help, "(default builtin:eye)"));
    assert_non_null(strstr(help, "(0 to 1; default 0)"));
    assert_non_null(strstr(man, ".It 70\n"));
    free(help);
    free(man);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_hold),
        cmocka_unit_test(every_option_is_stored),
        cmocka_unit_test(words_that_look_like_options),
        cmocka_unit_test(errors_say_what_is_wrong),
        cmocka_unit_test(warnings),
        cmocka_unit_test(the_table_is_sound),
        cmocka_unit_test(named_values_parse),
        cmocka_unit_test(help_is_complete),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
