// SPDX-License-Identifier: Apache-2.0
/* cli/options, cli/help: the one table, and the help made from it. */
#include "unit.h"
#include "cli/option_line.h"

static void the_table_is_sound(void **state)
{
    for (const struct gp_option *o = gp_options; o->name; o++) {
        const char *text;
        assert_ptr_equal(gp_option_find(o->name, strlen(o->name)), o);
        if (o->letter)
            assert_ptr_equal(gp_option_letter(o->letter, o->commands), o);
        bool number = o->kind == GP_KIND_FLOAT ||
                      o->kind == GP_KIND_THRESHOLD || o->kind == GP_KIND_INT ||
                      o->kind == GP_KIND_COUNT || o->kind == GP_KIND_NUMBERS;
        bool none = o->kind == GP_KIND_FLAG || o->kind == GP_KIND_SET;
        assert_true(!number || o->lo < o->hi);
        assert_int_equal(none, o->arg == NULL);
        assert_true(o->choices || (o->kind != GP_KIND_CHOICE &&
                                   o->kind != GP_KIND_EITHER &&
                                   o->kind != GP_KIND_NAMED));
        assert_true(o->commands != 0 &&
                    (!o->help || o->help[strlen(o->help) - 1] != '.'));
        assert_true((o->group == GP_GROUP_BENCH) ==
                    (o->commands == GP_COMMAND_BENCH));
        if (o->choices || o->list)
            assert_non_null(gp_option_value(o, 0, &text));
    }
    assert_null(gp_option_letter('\0', ~0u));
    assert_null(gp_option_find("", 0));
}

/* Returns what --help or --help-table prints; the caller frees it. */
static char *printed(enum gp_command command, bool table)
{
    char *text = NULL;
    size_t size;
    FILE *f = open_memstream(&text, &size);
    if (table)
        gp_help_table(f);
    else
        gp_help(f, command);
    fclose(f);
    return text;
}

static int widest(const char *text)
{
    int width = 0, most = 0;
    for (; *text; text++) {
        width = *text == '\n' ? 0 : width + 1;
        most = width > most ? width : most;
    }
    return most;
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
    char *table = printed(GP_COMMAND_MAIN, true);
    for (const struct gp_command_row *r = gp_commands; r->word; r++) {
        const enum gp_command c = r->bit;
        if (c == GP_COMMAND_HELP) // prints topics
            continue;
        char *help = printed(c, false);
        for (const struct gp_option *o = gp_options; o->name; o++) {
            const bool takes = o->commands & c;
            lists(help, " --%s%s%s", o, takes && o->help != NULL);
            lists(table, "option\t%s\t", o, o->help != NULL);
        }
        assert_true(widest(help) < 80);
        assert_null(strstr(help, "default inf")); // of options not given
        assert_null(strstr(help, "up to 1; default 0)"));
        assert_null(strstr(help, "e+38"));
        if (c == GP_COMMAND_MAIN || c == GP_COMMAND_BENCH) {
            assert_non_null(strstr(help, "0 or more; default 1)"));
            assert_non_null(strstr(help, "without it the style's"));
            assert_non_null(strstr(help, "(0 to 1; default 0)"));
        }
        free(help);
    }
    assert_non_null(strstr(table, "status\t70\t"));
    free(table);
}

/* A screen of 24 lines by 80 columns, with at least ten options. */
static void one_screen_is_one_screen(void **state)
{
    char *text = NULL;
    size_t size;
    FILE *f = open_memstream(&text, &size);
    int lines = 0, options = 0;
    gp_help_screen(f);
    fclose(f);
    for (const char *c = text; *c; c++)
        lines += *c == '\n';
    assert_in_range(lines, 15, 24);
    assert_true(widest(text) <= 80);
    for (const struct gp_option *o = gp_options; o->name; o++) {
        assert_true(!o->usual || strlen(o->usual) <= 50);
        assert_true(!o->usual || (o->commands & GP_COMMAND_MAIN));
        if (o->usual)
            lists(text, " --%s%s%s ", o, true);
        options += o->usual != NULL;
    }
    assert_in_range(options, 10, 12);
    for (int i = 0; gp_commands->example[i].line; i++)
        assert_non_null(strstr(text, gp_commands->example[i].line));
    assert_non_null(strstr(text, "bench, compare, kernel, lens, sets"));
    assert_non_null(strstr(text, "outputs, inputs, kernels"));
    assert_non_null(strstr(text, "--help all"));
    free(text);
}

// -- the line that a wrong word gets -----------------------------------------

/* Each group has a word of its own and an example that the parser takes,
 * which --help of its command shows. */
static void examples_are_right(void **state)
{
    for (int g = 0; g < GP_GROUPS; g++) {
        const struct gp_option_heading *h = &gp_option_groups[g];
        struct gp_settings s;
        assert_non_null(h->title);
        assert_non_null(h->word);
        assert_non_null(h->example);
        for (int k = 0; k < g; k++)
            assert_string_not_equal(h->word, gp_option_groups[k].word);
        if (parse(h->example + strlen("glarepp "), &s) || kept_line[0])
            fail_msg("%s: %s", h->example, kept_line);
        char *help = printed(s.command == GP_COMMAND_HELP ? GP_COMMAND_MAIN
                                                          : s.command, false);
        if (!strstr(help, h->example))
            fail_msg("%s: not in --help", h->example);
        free(help);
        gp_settings_free(&s);
    }
    for (const struct gp_command_row *r = gp_commands; r->word; r++) {
        const struct gp_example *e = r->example;
        char *help = r->usage ? printed(r->bit, false) : NULL;
        assert_true(!help || strncmp(help, r->usage, strlen(r->usage)) == 0);
        assert_true(!help || (e[0].line && e[1].line));
        for (; e->line; e++) {
            struct gp_settings s;
            if (parse(e->line + strlen("glarepp "), &s) || kept_line[0] ||
                s.command != r->bit)
                fail_msg("%s: %s", e->line, kept_line);
            assert_non_null(strstr(help, e->line));
            gp_settings_free(&s);
        }
        free(help);
    }
}

static void slips_of_commands(void **state)
{
    static const struct {
        const char *line, *part;  // of the message; NULL: no slip
    } rows[] = {
        {"bnech a", "bnech: no such command or file; did you mean "
                            "glarepp bench?"},
        {"benc a", "glarepp bench?"}, {"hlep", "glarepp help?"},
        {"helpp gain", "glarepp help?"},
        {"-o a bnech", NULL},       // not the first word
        {"bench.exr -o a", NULL},   // a file's name
        {"./bnech -o a", NULL},
        {"he -o a", NULL},          // too short to say
        {"tests -o a", NULL},       // far from all
        {"help a b", "b: too many inputs"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_settings s;
        const gp_status st = parse(rows[i].line, &s);
        if (rows[i].part ? st != GP_ERR_USAGE ||
                               !strstr(kept_line, rows[i].part) : st != GP_OK)
            fail_msg("%s: status %d: %s", rows[i].line, st, kept_line);
        gp_settings_free(&s);
    }
}

/* The distance of two words, by the most edits that are allowed. */
static int edits_between(const char *a, const char *b)
{
    for (int most = 0; most < 64; most++) {
        struct gp_nearest near = gp_nearest_to(a, strlen(a), most);
        near.most = most; // of a short word too
        gp_nearest_try(&near, b);
        if (near.name)
            return near.most;
    }
    return 99;
}

static void edits_are_counted(void **state)
{
    static const struct {
        const char *a, *b;
        int edits;
    } rows[] = {
        {"", "", 0},
        {"", "abc", 3},
        {"abc", "", 3},
        {"gain", "gain", 0},
        {"gian", "gain", 1},
        {"hdrs", "hrd", 2},
        {"gai", "gain", 1},
        {"again", "gain", 1},
        {"kitten", "sitting", 3},
        {"abcd", "wxyz", 4},
        {"ca", "abc", 3},
        {"0123456789012345678901234567890", "0", 30},
    };
    char word[257] = "";
    for (size_t i = 0; i < COUNT(rows); i++)
        assert_int_equal(edits_between(rows[i].a, rows[i].b), rows[i].edits);
    struct gp_nearest near = gp_nearest_to("ab", 2, 3);
    gp_nearest_try(&near, "xy"); // half of it at most may be wrong
    assert_null(near.name);
    gp_nearest_try(&near, "ac");
    gp_nearest_try(&near, "ad"); // no nearer
    assert_string_equal(near.name, "ac");
    near = gp_nearest_to("", 0, 3);
    gp_nearest_try(&near, "a");
    assert_null(near.name);
    for (size_t n = 255; n < 257; n++) { // the longest that are compared
        memset(word, 'a', n);
        near = (struct gp_nearest) {.word = "a", .length = 1, .most = 999};
        gp_nearest_try(&near, word);
        assert_int_equal(near.most, n == 255 ? 254 : 999);
    }
}

// -- topics ------------------------------------------------------------------

/* Returns what a topic prints, NULL when it is none; the caller frees it. */
static char *topic(const char *name)
{
    char *text = NULL;
    size_t size;
    kept_clear();
    FILE *f = open_memstream(&text, &size);
    const gp_status st = gp_help_topic(&kept_all, f, name);
    fclose(f);
    if (st == GP_OK)
        return text;
    assert_int_equal(st, GP_ERR_USAGE);
    assert_int_equal(strlen(text), 0);
    free(text);
    return NULL;
}

static void topic_has(const char *name, const char *part)
{
    char *text = topic(name);
    if (!text || !strstr(text, part))
        fail_msg("help %s: no \"%s\": %s", name, part, text ? text : kept_line);
    free(text);
}

static void topics_print_their_part(void **state)
{
    static const struct { const char *name, *part; } rows[] = {
        {"gain", "-g, --gain G"}, {"--gain", "-g, --gain G"},
        {"-g", "-g, --gain G"}, {"g", "-g, --gain G"}, {"GAIN", "--gain G"},
        {"engine", "      direct "}, {"engines", "--tolerance E"},
        {"kernels", "section \"Kernels\""}, {"kernels", "--kernel-center X,Y"},
        {"kernel", "-k, --kernel FILE"}, {"lights", "--sun-dir X,Y,Z"},
        {"view", "--view V"}, {"views", "--views LIST"},
        {"flare", "--flare FILE"}, {"masks", "--mask CH"},
        {"bench", "glarepp bench [options] INPUT"}, {"report", "--verify"},
        {"all", "--views LIST"}, {"ALL", "-h, --help [TOPIC]"},
        {"--all", "-a, --all"}, {"splat", "-e, --engine NAME"}, {"streak", "-k, --kernel FILE"},
    };
    for (size_t i = 0; i < COUNT(rows); i++)
        topic_has(rows[i].name, rows[i].part);
}

/* Each topic that is listed is one. Those that are only a section of the
 * manual end with the place of its page: there is none beside the tests. */
static void every_topic_is_known(void **state)
{
    char *list = topic(NULL), *table = printed(GP_COMMAND_HELP, true);
    int sections = 0;
    FILE *const null_file = fopen("/dev/null", "w");
    assert_non_null(null_file);
    assert_true(widest(list) < 80);
    for (char *word = strstr(table, "topic\t"); word;
         word = strstr(word + strlen(word) + 1, "topic\t")) {
        word += strlen("topic\t");
        word[strcspn(word, "\n")] = '\0';
        if (!strstr(list, word) && strcmp(word, "help") != 0)
            fail_msg("%s is not in the list", word);
        const gp_status st = gp_help_topic(&kept_all, null_file, word);
        assert_true(st == GP_OK || st == GP_ERR_IO ||
                    strcmp(word, "help") == 0);
        sections += st == GP_ERR_IO && strstr(kept_line, "man/glarepp.1");
    }
    fclose(null_file);
    assert_true(sections >= 8);
    for (int g = 0; g < GP_GROUPS; g++)
        topic_has(gp_option_groups[g].word, gp_option_groups[g].title);
    for (const struct gp_option *o = gp_options; o->name; o++) {
        char dashed[64];
        snprintf(dashed, sizeof dashed, "--%s", o->name);
        if (o->help)
            topic_has(dashed, o->letter ? ", --" : "      --");
    }
    free(list);
    free(table);
}

static void unknown_topics_suggest(void **state)
{
    static const struct { const char *name, *part; } rows[] = {
        {"kernle", "glarepp help kernel?"}, {"sequnces", "help sequences?"},
        {"--gian", "glarepp help gain?"}, {"enviroment", "help environment?"},
        {"--sequences", "no such topic"}, {"benhc", "glarepp help bench?"},
        {"xyzzyquux", "glarepp help lists them"}, {"", "lists them"},
        {"-", "lists them"}, {"--", "lists them"}, {"NAME", "no such topic"},
        {"help-table", "no such topic"}, {"sun-dri", "help sun-dir?"},
        {"%s%n", "(found \"%s%n\")"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        char *text = topic(rows[i].name);
        if (text || !strstr(kept_line, rows[i].part))
            fail_msg("help %s: %s", rows[i].name, text ? text : kept_line);
    }
}

SUITE_OF(help, NULL, NULL,
    the_table_is_sound, help_is_complete, one_screen_is_one_screen,
    examples_are_right,
    slips_of_commands, edits_are_counted, topics_print_their_part,
    every_topic_is_known, unknown_topics_suggest)
