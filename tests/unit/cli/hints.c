// SPDX-License-Identifier: Apache-2.0
/* cli/hints: words for each parameter that a message of the library names. */
#include "unit.h"
#include "cli/listener.h"
#include "cli/option_line.h"
#include "cli/options.h"

#include <ctype.h>

/* The program is not told of these, or the text says it all. */
// clang-format off
static const char *const wordless[] = {
    "frame.albedo", "frame.group", "frame.normal", "image.data", "image.plane",
    "image.type", "kernel.word", "layer.cluster", "layer.group",
    "params.picture", "plan.more", "tone.config.file", "tone.curve", "tone.output.primaries",
};
// clang-format on

static char parameter[256][40]; // of src/, each once
static size_t parameters;

/* Finds the strings of sources that are fields of glarepp.h. */
static void find_parameters(void)
{
    FILE *const f = popen(
        "cd src && grep -rhoE '\"(field|frame|image|kernel|layer|lens|lights|"
        "params|plan|scene|sense|tone)(\\.[a-z_]+)+[\" ]' --include='*.c' "
        "--include='*.cpp' api compare core gl glare scene sun tone | "
        "tr -d '\" ' | grep -v '[.]vert$' | sort -u", "r");
    assert_non_null(f);
    while (parameters < COUNT(parameter) &&
           fscanf(f, "%39s", parameter[parameters]) == 1)
        parameters++;
    pclose(f);
}

static void each_parameter_has_words(void **state)
{
    find_parameters();
    assert_true(parameters > 50);
    for (size_t i = 0; i < parameters; i++) {
        bool needs = true;
        for (size_t k = 0; k < COUNT(wordless); k++)
            needs = needs && strcmp(parameter[i], wordless[k]) != 0;
        if (needs != (gp_hint(parameter[i], "")[0] != '\0'))
            fail_msg("%s: \"%s\"", parameter[i], gp_hint(parameter[i], ""));
    }
}

static void words_name_options_that_exist(void **state)
{
    int options = 0;
    for (size_t i = 0; i < parameters; i++) {
        const char *at = gp_hint(parameter[i], "");
        while ((at = strchr(at, '-'))) {
            const bool letter = at[1] != '-';
            const char *const name = at + (letter ? 1 : 2);
            size_t n = 0;
            while (islower((unsigned char) name[n]) || name[n] == '-')
                n++;
            if (isalpha((unsigned char) at[-1])) // a hyphen
                ;
            else if (letter ? !gp_option_letter(name[0], GP_COMMAND_MAIN)
                            : !gp_option_find(name, n))
                fail_msg("no such option: %s", at);
            else
                options++;
            at = name + n;
        }
    }
    assert_true(options > 50);
}

static void advice_is_joined(void **state)
{
    assert_string_equal(gp_hint("layer.gl.egl", "a: no EGL"),
                        "; use --gl osmesa");
    assert_string_equal(gp_hint("layer.gl.egl", "a: no EGL; install it"),
                        ", or use --gl osmesa");
    assert_string_equal(gp_hint("kernel.word 0 8 layer.mix", "k: dim"),
                        "; use --mix scatter");
    assert_string_equal(gp_hint("", ""), "");
    assert_string_equal(gp_hint("kernel.word 0 8 ", ""), "");
    assert_string_equal(gp_hint("layer.gl.", ""), "");
}

static void messages_name_options_and_kernels(void **state)
{
    static const struct {
        struct glarepp_message m;
        const char *want;
    } rows[] = {
        {{GLAREPP_ERROR, 2, "", "a.exr: wrong", false, NULL}, "a.exr: wrong"},
        {{GLAREPP_ERROR, 2, "lights.outside", "a.exr: none", false, NULL},
         "a.exr: none; give --camera FILE, or --sun-outside ignore"},
        {{GLAREPP_WARNING, 0, "kernel.word 0 2", "uneven", false, NULL},
         "star and eye: uneven"},
        {{GLAREPP_WARNING, 0, "kernel.word 1 2", "uneven", false, NULL},
         "eye: uneven"},
        {{GLAREPP_WARNING, 0, "kernel.word 7 9", "uneven", false, NULL},
         "--kernel: uneven"},
        {{GLAREPP_NOTE, 0, "", "a note", false, NULL}, "a note"},
    };
    struct gp_settings s;
    assert_ok(parse("-k star -k eye -o a i", &s));
    struct gp_listener user = {&kept_all, &s};
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct glarepp_message m = rows[i].m;
        kept_clear();
        gp_hear(&user, &m);
        assert_string_equal(kept_line, rows[i].want);
        assert_int_equal(kept_errors, m.level == GLAREPP_ERROR);
    }
    gp_settings_free(&s);
}

static void keep_level(void *user, const struct gp_line *line)
{
    *(enum gp_level *) user = line->level;
}

/* A frame's messages go to its log, in the order of frames; the log's user puts
 * its file before messages that name none. */
static void frames_have_logs_of_their_own(void **state)
{
    enum gp_level level = GP_LEVEL_INFO;
    struct gp_log log = {keep_level, &level, GP_LEVEL_WARN};
    struct gp_settings s;
    assert_ok(parse("-o a i", &s));
    struct gp_listener user = {NULL, &s};
    struct glarepp_message m = {GLAREPP_ERROR, 70, "", "plan: full", true,
                                &log};
    gp_hear(&user, &m);
    assert_int_equal(level, GP_LEVEL_BARE);
    m.bare = false;
    gp_hear(&user, &m);
    assert_int_equal(level, GP_LEVEL_ERROR);
    gp_settings_free(&s);
}

SUITE_OF(hints, NULL, NULL, messages_name_options_and_kernels,
         frames_have_logs_of_their_own, each_parameter_has_words,
         words_name_options_that_exist, advice_is_joined)
