// SPDX-License-Identifier: Apache-2.0
/* cli/keys, cli/words: values of frames, and options from files. */
#include "unit.h"
#include "cli/keys.h"
#include "cli/option_line.h"
#include "cli/words.h"
#include "folder.h"

#include <sys/stat.h>
#include <unistd.h>

/* Writes a file of the folder. */
static void write_file(const char *name, const char *text)
{
    FILE *const f = fopen(in_folder(name), "wb");
    assert_non_null(f);
    fputs(text, f);
    assert_int_equal(fclose(f), 0);
}

/* Parses a line after "-o a i.1.exr", in which ~ is the folder. */
static gp_status parse_here(const char *line, struct gp_settings *s)
{
    char text[1024] = "-o a i.1.exr ";
    size_t n = strlen(text);
    for (; *line && n < sizeof text - sizeof folder; line++) {
        if (*line == '~')
            n += (size_t) snprintf(text + n, sizeof text - n, "%s", folder);
        else
            text[n++] = *line;
    }
    text[n] = '\0';
    return parse(text, s);
}

static void values_are_linear_and_held(void **state)
{
    static const struct {
        int frame;
        float gain;
    } rows[] = {
        {INT32_MIN, .1f}, {-6, .1f},    {-5, .1f},         {0, .2f},
        {5, .3f},         {6, .3f},     {1000, .3f},       {1001, .3f},
        {1002, .15f},     {1003, 0.0f}, {INT32_MAX, 0.0f},
    };
    struct gp_settings s, at;
    assert_ok(parse_here("--gain -5:.1,5:.3,1001:.3,1003:0", &s));
    assert_true(s.light.layer.gain == .1f);
    for (size_t i = 0; i < COUNT(rows); i++) {
        gp_settings_at(&s, rows[i].frame, &at);
        assert_true(at.light.layer.gain == rows[i].gain);
        assert_ptr_equal(at.plan.layer, &at.light.layer);
    }
    gp_settings_free(&s);
}

static void lists_and_thresholds_have_keys(void **state)
{
    struct gp_settings s, at;
    assert_ok(parse_here("--sun 1:10/20/3,3:20/40/5 --threshold 1:+1ev,3:+3ev "
                         "-k k.exr --kernel-center 2:1/2,4:3/4 --exposure 0:1 "
                         "--exposure 2 --kernel-size 1:1deg,3:2deg",
                         &s));
    gp_settings_at(&s, 2, &at);
    assert_true(at.sun.p.light == &at.sun.light && at.sun.p.lights == 1);
    assert_true(at.sun.light.at[0] == 15.0 && at.sun.light.at[1] == 30.0 &&
                at.sun.light.radius == 4.0 && at.sun.p.sun.radius == 4.0);
    assert_true(at.light.sense.threshold == 2.0f &&
                at.light.sense.unit == GLAREPP_EV);
    assert_true(at.kernel.p.degrees == 1.5);
    gp_settings_at(&s, 3, &at);
    assert_true(at.kernel.p.centre[0] == 2.0 && at.kernel.p.centre[1] == 3.0);
    assert_true(at.tone.map.exposure == 2.0f); // the last use rules
    gp_settings_free(&s);
}

static void files_have_keys(void **state)
{
    static const char *const texts[] = {
        "frame,x,y\n1,10,20\n3,30,40\n",
        "1,10,20\r\n3,30,40\r\n",
        "\xef\xbb\xbf\x31,10,20\n3,30,40", // a byte order mark, then 1
        "# a track\n\nFrame, X, Y\n  1 ,\t10, 20 # first\n\n3 , 30 ,40  \n#",
    };
    for (size_t i = 0; i < COUNT(texts); i++) {
        struct gp_settings s, at;
        write_file("t.csv", texts[i]);
        if (parse_here("--sun @~/t.csv", &s))
            fail_msg("%s: %s", texts[i], kept_line);
        gp_settings_at(&s, 2, &at);
        assert_true(at.sun.light.at[0] == 20.0 && at.sun.light.at[1] == 30.0);
        gp_settings_free(&s);
    }
}

/* A line, and what its error says; with `file` it reads ~/t.csv of this text. */
static const struct {
    const char *line, *part, *file;
} wrong[] = {
    {"--threads 1:2", "--threads: takes no keys", NULL},
    {"--sun-map 1:8", "--sun-map: takes no keys", NULL},
    {"--tolerance 1:.1", "--tolerance: takes no keys", NULL},
    {"--max-pixels 1:8", "--max-pixels: takes no keys", NULL},
    {"--gain 1:2,3", "--gain: not a key (found \"3\")", NULL},
    {"--gain 1:2,", "--gain: not a key (found \"\")", NULL},
    {"--gain x:2", "--gain: not a frame number (found \"x\")", NULL},
    {"--gain +1:2", "not a frame number", NULL},
    {"--gain 1.5:2", "not a frame number", NULL},
    {"--gain 10000000000:2", "not a frame number", NULL},
    {"--gain :2", "not a frame number", NULL},
    {"--gain 1:", "--gain: not a number", NULL},
    {"--gain 1:2:3", "--gain: not a number (found \"2:3\")", NULL},
    {"--gain 1:2/3", "--gain: not a number (found \"2/3\")", NULL},
    {"--gain 1:2,2:1e7", "--gain: out of range (found 1e7)", NULL},
    {"--gain 1:nan", "--gain: out of range", NULL},
    {"--gain 2:1,1:2", "must rise (found 1 after 2)", NULL},
    {"--gain 2:1,2:2", "must rise (found 2 after 2)", NULL},
    {"--threshold 1:1,2:+3ev", "the same unit", NULL},
    {"--threshold 1:1%,2:3", "the same unit", NULL},
    {"-k k.exr --kernel-size 1:50,2:2deg", "the same unit", NULL},
    {"-k k.exr --kernel-size 1:50,2:0", "--kernel-size: not a size", NULL},
    {"--sun 1:1/2,2:1/2/3", "the same count", NULL},
    {"--sun 1:1/2/3,2:1/2/-3", "--sun: a negative radius (found -3)", NULL},
    {"--sun 1:1", "--sun: not 2 to 3 numbers", NULL},
    {"--gain @~/none.csv", "none.csv: cannot open", NULL},
    {"--gain @~", "is a folder", NULL},
    {"--gain @~/t.csv", "t.csv:2: --gain: out of range (found -1)",
     "1,1\n2,-1"},
    {"--gain @~/t.csv", "t.csv:3: --gain: no value (found \"2\")",
     "\n1,1\n2\n"},
    {"--gain @~/t.csv", "t.csv:2: --gain: not a frame", "a,b\nc,d\n"},
    {"--gain @~/t.csv", "t.csv:1: --gain: not a number (found \"1 2\")",
     "1,1 2"},
    {"--gain @~/t.csv", "t.csv:2: --gain: frames of keys", "5,1\n4,1\n"},
    {"--gain @~/t.csv", "t.csv: no keys of --gain", "frame,gain\n"},
    {"--gain @~/t.csv", "t.csv: no keys of --gain", ""},
    {"--settings ~/none", "none: cannot open", NULL},
    {"--settings ~/t.csv", "t.csv:2: --gian: unknown option; did you mean",
     "# a\n--gian 2\n"},
    {"--settings ~/t.csv", "t.csv:1: --gain: out of range", "--gain -1"},
    {"--settings ~/t.csv", "t.csv:1: --gain: needs a value", "--gain"},
    {"--settings ~/t.csv", "t.csv:1: x.exr: not an option", "x.exr"},
    {"--settings ~/t.csv", "t.csv:1: -: not an option", "-"},
    {"--settings ~/t.csv", "t.csv:1: --settings: not a setting",
     "--settings t.csv"},
    {"--settings ~/t.csv", "t.csv:1: --output: not a setting", "-o b"},
    {"--settings ~/t.csv", "t.csv:1: --threads: not a setting", "--threads 2"},
    {"--settings ~/t.csv", "t.csv:2: a quote that does not end",
     "--gain 2\n--part 'a\n"},
    {"--settings ~/t.csv", "t.csv:1: --kernel: no file no.exr (looked for in",
     "--kernel no.exr"},
    {"--settings ~/t.csv", "--kernel: no file no.exr (looked for in",
     "--kernel image:file=no.exr,share=1"},
    {"--settings ~/t.csv", "--gain: no file no.csv (looked for in",
     "--gain @no.csv"},
};

static void errors_of_keys_and_settings(void **state)
{
    for (size_t i = 0; i < COUNT(wrong); i++) {
        struct gp_settings s;
        if (wrong[i].file)
            write_file("t.csv", wrong[i].file);
        const gp_status st = parse_here(wrong[i].line, &s);
        const bool looked = strstr(wrong[i].part, ": no file") != NULL;
        const gp_status want = wrong[i].file && !looked     ? GP_ERR_DATA
                               : strchr(wrong[i].line, '~') ? GP_ERR_IO
                                                            : GP_ERR_USAGE;
        if (st != want || kept_lines != 1 || !strstr(kept_line, wrong[i].part))
            fail_msg("\"%s\": status %d: %s", wrong[i].line, st, kept_line);
        gp_settings_free(&s);
    }
}

static void keys_have_a_limit(void **state)
{
    struct gp_settings s;
    FILE *const f = fopen(in_folder("t.csv"), "wb");
    assert_non_null(f);
    for (int i = 0; i <= GP_KEYS_MOST; i++)
        fprintf(f, "%d,1\n", i);
    fclose(f);
    assert_int_equal(parse_here("--gain @~/t.csv", &s), GP_ERR_DATA);
    assert_kept("t.csv:10001: --gain: too many keys");
    gp_settings_free(&s);
    assert_int_equal(truncate(in_folder("t.csv"), 5 << 20), 0);
    assert_int_equal(parse_here("--gain @~/t.csv", &s), GP_ERR_DATA);
    assert_kept("too large");
    gp_settings_free(&s);
}

/* The line rules, then the later file; lists are not added up. */
static void the_line_rules(void **state)
{
    struct gp_settings s;
    write_file("a", "--gain 2 --knee .5 --kernel star --kernel ring --dither\n"
                    "--threshold-mode whole --rotate 1:0,3:9");
    write_file("b", "-g3 # later\n--gain=4\n--exposure 1\n");
    assert_ok(parse_here("--settings ~/a --settings ~/b --kernel cross "
                         "--exposure 2 --no-dither",
                         &s));
    assert_true(s.light.layer.gain == 4.0f && s.light.sense.knee == 0.5f);
    assert_true(s.tone.map.exposure == 2.0f && s.kernel.words.n == 1);
    assert_string_equal(s.kernel.words.at[0], "cross");
    assert_int_equal(s.output.write.dither, GP_DITHER_NEVER);
    assert_true(s.keyeds == 1 && s.keyed[0].n == 2);
    gp_settings_free(&s);
    assert_ok(parse_here("--settings ~/b --settings ~/a", &s));
    assert_true(s.light.layer.gain == 2.0f && s.kernel.words.n == 2);
    gp_settings_free(&s);
}

/* Words are what a shell makes of them; files lie beside the settings first. */
static void words_read_back(void **state)
{
    static const char *const words[] = {
        "a b", "it's",     "\"", "a\nb", "#",     "\\",
        "$x",  "\xc3\xa4", " ",  "a#b",  "'\\''",
    };
    for (size_t i = 0; i < COUNT(words); i++) {
        char save[96];
        snprintf(save, sizeof save, "--save-settings=%s/saved", folder);
        char *const argv[] = {"glarepp", "--part", (char *) words[i], save};
        struct gp_settings s;
        kept_clear();
        assert_ok(gp_options_parse(&kept_all, 4, argv, &s));
        assert_ok(gp_settings_save(&kept_all, &s));
        gp_settings_free(&s);
        if (parse_here("--settings ~/saved", &s))
            fail_msg("%s: %s", words[i], kept_line);
        assert_string_equal(s.input.read.part, words[i]);
        gp_settings_free(&s);
    }
}

static void files_are_found(void **state)
{
    struct gp_settings s;
    char text[256];
    write_file("k.exr", "");
    write_file("t.csv", "1,2\n");
    write_file("a", "-k k.exr -k image:file=k.exr,share=.1 -g @t.csv --part "
                    "\"a \\\"b\\\\\" --lens tessar --flare preset:zoom "
                    "--depth-file d.####.exr --sun 1,2");
    assert_ok(parse_here("--settings ~/a", &s));
    assert_string_equal(s.kernel.words.at[0], in_folder("k.exr"));
    snprintf(text, sizeof text, "image:file=%s/k.exr,share=.1", folder);
    assert_string_equal(s.kernel.words.at[1], text);
    assert_string_equal(s.keyed[0].file, in_folder("t.csv"));
    assert_string_equal(s.input.read.part, "a \"b\\");
    assert_string_equal(s.lens.lens, "tessar");
    assert_string_equal(s.sun.p.flare, "preset:zoom");
    assert_string_equal(s.sun.depth_file, "d.####.exr");
    gp_settings_free(&s);
}

SUITE_OF(keys, make_folder, remove_folder, values_are_linear_and_held,
         lists_and_thresholds_have_keys, files_have_keys,
         errors_of_keys_and_settings, keys_have_a_limit, the_line_rules,
         words_read_back, files_are_found)
