/* app/hints: what the program adds to a message of the library. */
#include "unit.h"
#include "app/hints.h"
#include "app/option_line.h"

static void messages_name_options_and_kernels(void **state)
{
    static const struct {
        struct glarepp_message m;
        const char *want;
    } rows[] = {
        {{GLAREPP_ERROR, 2, "", "a.exr: wrong", NULL}, "a.exr: wrong"},
        {{GLAREPP_ERROR, 2, "lights.outside", "a.exr: none", NULL},
         "a.exr: none; give --camera FILE, or --sun-outside ignore"},
        {{GLAREPP_WARNING, 0, "lights.outside", "a.exr: none", NULL},
         "a.exr: none"},
        {{GLAREPP_WARNING, 0, "kernel.word 0 2", "uneven", NULL},
         "star and eye: uneven"},
        {{GLAREPP_WARNING, 0, "kernel.word 1 2", "uneven", NULL},
         "eye: uneven"},
        {{GLAREPP_WARNING, 0, "kernel.word 7 9", "uneven", NULL},
         "--kernel: uneven"},
        {{GLAREPP_NOTE, 0, "", "a note", NULL}, "a note"},
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

/* A frame's messages are printed in the order of frames, by its log. */
static void frames_have_logs_of_their_own(void **state)
{
    struct gp_settings s;
    assert_ok(parse("-o a i", &s));
    struct gp_listener user = {NULL, &s};
    struct glarepp_message m = {GLAREPP_WARNING, 0, "", "of a frame",
                                (void *) (uintptr_t) &kept_all};
    kept_clear();
    gp_hear(&user, &m);
    assert_string_equal(kept_warning, "of a frame");
    gp_settings_free(&s);
}

SUITE_OF(hints, NULL, NULL, messages_name_options_and_kernels,
         frames_have_logs_of_their_own)
