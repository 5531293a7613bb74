// SPDX-License-Identifier: Apache-2.0
/* cli/say: words about a run, on a terminal and of --verbose. */
#include "unit.h"
#include "cli/option_line.h"
#include "cli/report.h"

static struct gp_written files[] = {
    {"lit.exr", GP_TARGET_HDR}, {"out.png", GP_TARGET_PICTURE},
    {NULL, GP_TARGET_LAYER}, {NULL, GP_TARGET_PICTURE},
};

static char input[] = "in.exr";

/* A frame of 1000 of light, of which 31 are bright, at 30 degrees. */
static struct gp_frame_report some_facts(const struct gp_settings *s)
{
    struct gp_frame_report f = {
        .job = {.of.input = input, .settings = s},
        .read = {.width = 64,
                 .height = 48,
                 .window = {0, 0, 64, 48},
                 .file = {0, 0, 64, 48}},
        .lib =
            {
                .sense = {.sources = 1183,
                          .light = 1000.0,
                          .bright = 31.0,
                          .threshold = 1.0f},
                .kernel = {.w = 9,
                           .h = 9,
                           .deg_per_pixel = 0.1,
                           .fov = 30.0,
                           .fov_from = "default"},
                .layer = {.engine = "fft", .why = "for 2 sources"},
            },
        .write = {.file = files, .n = 2},
    };
    return f;
}

// -- the line on a terminal --------------------------------------------------

/* Formats the line of the targets that are bits, for `made` frames, of which
 * the last has other sources. */
static void line_of(const struct gp_settings *s, const struct gp_frame_report *f,
                    unsigned targets, int made, double seconds, char *line,
                    size_t size)
{
    static const char *const paths[] = {
        "lit.####.exr", "out.####.png", "glare.####.exr", "x.####.exr",
    };
    struct gp_tally t = {0};
    struct gp_output list[4];
    struct gp_jobs jobs = {.target = list};
    for (int i = 0; i < 4; i++) {
        struct gp_output o = {.kind = files[i].kind};
        o.name.path = paths[i];
        if (targets >> i & 1)
            list[jobs.targets++] = o;
    }
    for (int i = 0; i < made; i++) {
        struct gp_frame_report one = *f;
        one.lib.sense.sources += made > 1 && i == made - 1 ? 7 : 0;
        gp_tally_add(&t, &one);
    }
    FILE *const out = fmemopen(line, size, "w");
    gp_tally_print(out, &t, s, &jobs, seconds);
    fclose(out);
}

static void lines_say_what_happened(void **state)
{
    static const struct {
        const char *options;
        unsigned targets;
        int made;
        long long sources;
        double seconds;
        const char *want;
    } rows[] = {
        {"--tonemap agx", 2, 1, 1183, 0.134, "out.####.png: 1,183 sources, 3.1 % of "
         "the light moved, view of 30 degrees (assumed), agx, 0.13 s"},
        {"--tonemap agx", 3, 1, 1, 12.0, "out.####.png and 1 more: 1 source, 3.1 % "
         "of the light moved, view of 30 degrees (assumed), agx, 12 s"},
        {"-g 1", 2, 1, 0, 1.0, "out.####.png: 0 sources: nothing glares, view of 30 "
         "degrees (assumed), neutral, 1.00 s"},
        {"-g 1", 2, 3, 1234567, 200.0, "out.####.png: 3 frames, 1,234,567 to "
         "1,234,574 sources, 3.1 % of the light moved, view of 30 "
         "degrees (assumed), neutral, 3 min 20 s"},
        {"-g 1", 8, 2, 5, 1.0, "x.####.exr: 2 frames, 5 to 12 sources, 3.1 % "
         "of the light moved, view of 30 degrees (assumed), tone-mapped "
         "by neutral (use --hdr for linear light), 1.00 s"},
        {"--tonemap none", 8, 2, 5, 1.0, "x.####.exr: 2 frames, 5 to 12 "
         "sources, 3.1 % of the light moved, view of 30 degrees "
         "(assumed), linear, 1.00 s"},
        {"-g 1", 4, 2, 5, 1.0, "glare.####.exr: 2 frames, 5 to 12 sources, "
         "3.1 % of the light spread, view of 30 degrees (assumed), "
         "linear, 1.00 s"},
        {"--mix add", 2, 1, 2, 1.0, "out.####.png: 2 sources, 3.1 % of the light "
         "added, view of 30 degrees (assumed), neutral, 1.00 s"},
        {"-g 0.02", 2, 1, 2, 1.0, "out.####.png: 2 sources, under 0.1 % of the "
         "light moved, view of 30 degrees (assumed), neutral, 1.00 s"},
        {"-g 10", 2, 1, 2, 1.0, "out.####.png: 2 sources, 3.1 % of the light moved, "
         "28 % added, view of 30 degrees (assumed), neutral, 1.00 s"},
        {"-g 0", 1, 1, 2, 1.0, "lit.####.exr: 2 sources, 0 % of the light moved, "
         "view of 30 degrees (assumed), linear, 1.00 s"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_settings s;
        char options[64], line[400];
        snprintf(options, sizeof options, "%s -o a i", rows[i].options);
        assert_ok(parse(options, &s));
        struct gp_frame_report f = some_facts(&s);
        f.write.n = rows[i].targets == 1 ? 1 : 2;
        f.lib.sense.sources = rows[i].sources;
        line_of(&s, &f, rows[i].targets, rows[i].made, rows[i].seconds, line,
                sizeof line);
        assert_string_equal(line, rows[i].want);
        gp_settings_free(&s);
    }
}

// -- notes -------------------------------------------------------------------

static char notes[8192];

static void keep_note(void *user, const struct gp_line *line)
{
    const size_t at = strlen(notes);
    assert_int_equal(line->level, GP_LEVEL_INFO);
    snprintf(notes + at, sizeof notes - at, "%s\n", line->text);
}
static const struct gp_log notebook = {keep_note, NULL, GP_LEVEL_INFO};

static void notes_of(const char *options, struct gp_frame_report *f)
{
    struct gp_settings s;
    assert_ok(parse(options, &s));
    f->job.settings = &s;
    notes[0] = '\0';
    gp_say_frame(&notebook, f);
    gp_settings_free(&s);
}

static void notes_say_what_and_why(void **state)
{
    struct gp_frame_report f = some_facts(NULL);
    notes_of("-o a --hdr h i", &f);
    assert_string_equal(notes,
        "in.exr: read 64x48 pixels\n"
        "in.exr: 1,183 sources: pixels over the threshold of 1 (the default), "
        "3.1 % of the light moved\n"
        "in.exr: kernel of style camera (the default), view of 30 degrees "
        "(assumed; --fov sets it), engine fft (chosen by auto)\n"
        "in.exr: wrote lit.exr: linear light; out.png: tone-mapped by neutral "
        "(the default)\n");
    f.job.of.view = "left";
    f.lib.kernel.fov_from = "camera";
    f.write.n = 0;
    f.lib.sense.nonfinite = 1000;
    f.lib.sense.threshold = 2.5f;
    f.lib.layer.gl = "llvmpipe";
    snprintf(f.read.taken.layer, sizeof f.read.taken.layer, "beauty");
    notes_of("-t 99% -k star -k cie -e fft -o a i", &f);
    assert_string_equal(notes,
        "in.exr (left): read 64x48 pixels, layer beauty, 1,000 NaN or "
        "Inf\n"
        "in.exr (left): 1,183 sources: pixels over the threshold of 2.5 "
        "(--threshold 99%), 3.1 % of the light spread\n"
        "in.exr (left): kernel star and cie (--kernel), view of 30 degrees (of "
        "its camera), engine fft (--engine) on llvmpipe\n");
}

static void notes_of_what_else_there_is(void **state)
{
    const struct glarepp_share light[2] = {
        {.name = "sun", .visibility = 0.5, .in_frame = true},
        {.visibility = 1.0, .behind = true},
    };
    struct gp_frame_report f = some_facts(NULL);
    f.lib.sense.sources = 0;
    f.lib.kernel.w = 0;
    char depth[] = "Z";
    f.lib.light = light;
    f.lib.lights = 2;
    f.hidden.depth = depth;
    f.hidden.edges = "depth alone: near";
    f.lib.flare.runs = f.lib.flare.elements = 3;
    f.lib.lens.name = "heliar";
    f.lib.verified = true;
    f.lib.errors.rel_l2 = 1e-7;
    notes_of("-t +2ev -o a i", &f);
    assert_non_null(strstr(notes, "no pixel is over the threshold of 1 "
                           "(--threshold +2ev): nothing glares\n"));
    assert_null(strstr(notes, "kernel"));
    assert_non_null(strstr(notes, "in.exr: sun 50 % visible, light behind the "
                           "camera, depth of Z, edges by depth alone\n"));
    assert_non_null(strstr(notes, "flare of bright pixels, 3 elements, lens "
                           "heliar: 0 ghosts of 0 lights\n"));
    assert_non_null(strstr(notes, "measured rel_l2 1e-07, max_rel 0"));
}

SUITE_OF(say, NULL, NULL, lines_say_what_happened,
         notes_say_what_and_why,
         notes_of_what_else_there_is)
