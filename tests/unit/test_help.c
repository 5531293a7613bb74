/* app/options, app/help: the one table, and the help made from it. */
#include "app/options.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

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
        assert_true(o->commands != 0);
        assert_true((o->group == GP_GROUP_BENCH) ==
                    (o->commands == GP_COMMAND_BENCH));
        if (o->choices || o->list)
            assert_non_null(gp_option_value(o, 0, &text));
    }
    assert_null(gp_option_letter('\0'));
    assert_null(gp_option_find("", 0));
}

/* What --help or the man page's part prints, in memory; the caller frees it. */
static char *printed(enum gp_command command, bool man)
{
    char *text = NULL;
    size_t size;
    FILE *f = open_memstream(&text, &size);
    if (man)
        gp_help_man(f);
    else
        gp_help(f, command);
    fclose(f);
    return text;
}

static void lists(const char *text, const char *pattern,
                  const struct gp_option *o, bool wanted)
{
    char name[64];
    snprintf(name, sizeof name, pattern, o->name, o->arg ? " " : "",
             o->arg ? o->arg : "");
    if ((strstr(text, name) != NULL) != wanted)
        fail_msg("%s: %s", name, wanted ? "missing" : "there");
}

static void help_is_complete(void **state)
{
    (void) state;
    char *man = printed(GP_COMMAND_MAIN, true);
    for (int c = GP_COMMAND_MAIN; c <= GP_COMMAND_BENCH; c <<= 1) {
        char *help = printed((enum gp_command) c, false);
        for (const struct gp_option *o = gp_options; o->name; o++) {
            const bool takes = o->commands & (unsigned) c;
            lists(help, " --%s%s%s", o, takes && !o->hidden);
            lists(man, "Fl \\-%s", o, !o->hidden);
        }
        int width = 0;
        for (const char *at = help; *at; at++) {
            width = *at == '\n' ? 0 : width + 1;
            assert_true(width < 80);
        }
        assert_non_null(strstr(help, "default 65504)"));
        assert_non_null(strstr(help, "(default builtin:eye)"));
        assert_non_null(strstr(help, "(0 to 1; default 0)"));
        free(help);
    }
    assert_non_null(strstr(man, ".It 70\n"));
    assert_non_null(strstr(man, "@BENCH@\n.Fl \\-"));
    free(man);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_table_is_sound),
        cmocka_unit_test(help_is_complete),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
