// SPDX-License-Identifier: Apache-2.0
#include "cli/options.h"
#include "cli/report.h"
#include "core/minmax.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

enum {
    WIDTH = 79,   // columns of --help
    INDENT = 28,  // column of the options' texts
};

/* Formats an option's text, its values if wanted, range and default. */
static void option_text(const struct gp_option *o, bool values, char *text,
                        size_t size)
{
    const bool number = o->kind >= GP_KIND_FLOAT && o->kind <= GP_KIND_COUNT;
    json_t *const usual = gp_option_json(&gp_defaults, o);
    char value[64] = ""; // the default; "" for none
    const char *name, *line;
    if (json_is_string(usual))
        snprintf(value, sizeof value, "%s", json_string_value(usual));
    else if (json_is_number(usual) && json_number_value(usual) >= o->lo)
        snprintf(value, sizeof value, "%.10g", json_number_value(usual));
    json_decref(usual);
    size_t at = (size_t) snprintf(text, size, "%s", o->help);
    for (int i = 0; values && at < size &&
                    (name = gp_option_value(o, i, &line)); i++)
        at += (size_t) snprintf(text + at, size - at, "%s%s",
                                i ? ", " : o->open ? ", or " : ": ", name);
    if (at < size && number)
        snprintf(text + at, size - at, value[0] ? " (%s; default %s)" : " (%s)",
                 gp_option_range(o).text, value);
    else if (value[0] && at < size)
        snprintf(text + at, size - at, " (default %s)", value);
}

// -- --help ------------------------------------------------------------------

/* Prints text from a column on, its other lines from `indent` on. */
static void print_wrapped(FILE *f, int column, int indent, const char *text)
{
    while (*text) {
        const int n = (int) strcspn(text, " ");
        fprintf(f, "%.*s", n, text);
        column += n;
        text += n;
        if (*text == ' ') {
            text++;
            if (column + 1 + (int) strcspn(text, " ") <= WIDTH) {
                putc(' ', f);
                column++;
            } else {
                fprintf(f, "\n%*s", indent, "");
                column = indent;
            }
        }
    }
    putc('\n', f);
}

void gp_help_text(FILE *f, int column, const char *text)
{
    if (column >= INDENT - 1)
        fprintf(f, "\n%*s", INDENT, "");
    else
        fprintf(f, "%*s", INDENT - column, "");
    print_wrapped(f, INDENT, INDENT, text);
}

/* Prints an option's letter, name and value; returns their columns. */
static int print_name(FILE *f, const struct gp_option *o)
{
    const int column = o->letter
                           ? fprintf(f, "  -%c, --%s", o->letter, o->name)
                           : fprintf(f, "      --%s", o->name);
    return column + (o->arg ? fprintf(f, " %s", o->arg) : 0);
}

static void print_option(FILE *f, const struct gp_option *o)
{
    char text[1536];
    const int column = print_name(f, o);
    option_text(o, true, text, sizeof text);
    gp_help_text(f, column, text);
}

/* Prints a group's options that some of the commands (bits) take, under its
 * heading and example; returns false when there are none. */
static bool print_group(FILE *f, int group, unsigned commands)
{
    const struct gp_option_heading *const head = &gp_option_groups[group];
    const struct gp_option *first = gp_options; // the example is of its command
    bool headed = false;
    while ((int) first->group != group)
        first++;
    for (const struct gp_option *o = first; o->name; o++) {
        if ((int) o->group != group || !o->help || !(o->commands & commands))
            continue;
        if (!headed)
            fprintf(f, "%s\n", head->title);
        if (!headed && (commands & gp_command_of(first->commands)->bit))
            fprintf(f, "    %s\n", head->example);
        headed = true;
        print_option(f, o);
    }
    return headed;
}

/* Prints the examples of a command, their texts in one column. */
static void print_examples(FILE *f, const struct gp_command_row *c)
{
    int width = 0;
    for (const struct gp_example *e = c->example; e->line; e++)
        width = gp_max(width, (int) strlen(e->line));
    for (const struct gp_example *e = c->example; e->line; e++)
        fprintf(f, "  %-*s  %s\n", width, e->line, e->text);
    putc('\n', f);
}

void gp_help(FILE *f, enum gp_command command)
{
    const struct gp_command_row *const c = gp_command_of(command);
    fprintf(f, "%s\n", c->usage);
    print_examples(f, c);
    for (int g = 0; g < GP_GROUPS; g++) {
        if (print_group(f, g, command))
            putc('\n', f);
    }
    fprintf(f, "glarepp help TOPIC explains more; glarepp help lists topics and "
            "commands.\n");
}

// -- topics ------------------------------------------------------------------

/* Sections of the man page that are topics; check-man compares them. */
static const struct section {
    const char *word, *more, *title; // the word is "" beside a group's
} sections[] = {
    {"sequences", "", "Sequences"},
    {"views", "", "Views"},
    {"layers", "parts stereo cryptomatte",
     "Layers, parts, stereo and Cryptomatte"},
    {"farms", "pipes", "Pipes and farms"},
    {"numbers", "", "What the numbers mean"},
    {"", "kernels", "Kernels"},
    {"", "lights suns lamps flare", "Suns, lamps and lens flare"},
    {"", "measuring speed error", "Measuring speed against error"},
    {"", "comparing images", "Comparing images"},
    {"completions", "", "Help and completions"},
    {"", "report", "THE REPORT"},
    {"environment", "", "ENVIRONMENT"},
    {"", "files", "FILES"},
    {"status", "exit", "EXIT STATUS"},
    {"examples", "", "EXAMPLES"},
    {"diagnostics", "", "DIAGNOSTICS"},
};
enum { SECTIONS = sizeof sections / sizeof *sections };

/* Topics: commands, all, groups, and sections with other names. */
struct topic {
    enum { COMMAND, ALL_OPTIONS, GROUP, SECTION } kind;
    const char *word, *text; // the text may have more than one line
    unsigned commands; // the command; those that take options of the group
    int group;
};

/* True when the topic is one of the words, but for case and a last "s". */
static bool is_topic(const char *topic, const char *words)
{
    size_t m = strlen(topic);
    m -= m > 1 && topic[m - 1] == 's';
    while (*words) {
        const size_t whole = strcspn(words, " ");
        const size_t n = whole - (whole > 1 && words[whole - 1] == 's');
        if (n == m && strncasecmp(words, topic, n) == 0)
            return true;
        words += whole;
        words += strspn(words, " ");
    }
    return false;
}

/* Finds the i-th topic; false after the last. */
static bool topic_at(int i, struct topic *t)
{
    for (const struct gp_command_row *c = gp_commands + 1; c->word; c++) {
        *t = (struct topic) {COMMAND, c->word, c->usage, c->bit, 0};
        if (i-- == 0)
            return true;
    }
    *t = (struct topic) {ALL_OPTIONS, "all", "", GP_COMMAND_MAIN, 0};
    if (i-- == 0)
        return true;
    for (int g = 0; g < GP_GROUPS; g++) {
        const struct gp_option_heading *const head = &gp_option_groups[g];
        *t = (struct topic) {GROUP, head->word, head->title, 0, g};
        for (const struct gp_option *o = gp_options; o->name; o++)
            t->commands |= (int) o->group == g ? o->commands : 0;
        if (i-- == 0)
            return true;
    }
    for (const struct section *k = sections; k < sections + SECTIONS; k++) {
        *t = (struct topic) {SECTION, k->word, k->title, 0, 0};
        if (*k->word && i-- == 0)
            return true;
    }
    return false;
}

static gp_status unknown_topic(const struct gp_log *log, const char *topic)
{
    const char *const bare = topic + strspn(topic, "-");
    struct gp_nearest near = gp_nearest_to(bare, strlen(bare), 3);
    struct topic t;
    for (int i = 0; topic_at(i, &t); i++)
        gp_nearest_try(&near, t.word);
    for (const struct gp_option *o = gp_options; o->name; o++) {
        if (o->help)
            gp_nearest_try(&near, o->name);
    }
    if (near.name)
        return gp_fail(log, GP_ERR_USAGE,
                       "help: no such topic (found \"%s\"); did you mean "
                       "glarepp help %s?", topic, near.name);
    return gp_fail(log, GP_ERR_USAGE,
                   "help: no such topic (found \"%s\"); glarepp help lists "
                   "them", topic);
}

/* Finds the page, and prints a section of it, as man(1) formats it: from its
 * heading, which is indented by 0 or 3 columns, to the next. */
static gp_status show_section(const struct gp_log *log, FILE *f,
                              const char *title)
{
    static const char script[] =
        "exec 2>/dev/null; man \"$GLAREPP_PAGE\" | awk '"
        "/^(   )?[^ ]/ { on = !n && $0 ~ \"^ *\" ENVIRON[\"GLAREPP_TITLE\"] "
        "\"$\" }"
        " on { print; n++ }'";
    // of an installed program, then of its source tree
    static const char *const places[] = {
        "../share/man/man1/glarepp.1", "../share/man/man1/glarepp.1.gz",
        "../man/glarepp.1",
    };
    char page[4096 + 40], line[1024];
    const ssize_t n = readlink("/proc/self/exe", page, 4096);
    char *const slash = n > 0 ? memrchr(page, '/', (size_t) n) : NULL;
    for (size_t i = 0; slash && i < sizeof places / sizeof *places; i++) {
        bool printed = false;
        strcpy(slash + 1, places[i]);
        if (access(page, R_OK) != 0)
            continue;
        // (paths may have any character: the shell is not given them as words)
        setenv("GLAREPP_PAGE", page, 1);
        setenv("GLAREPP_TITLE", title, 1);
        fflush(f);
        // NOLINTNEXTLINE(cert-env33-c): the script has no word of the user
        FILE *const man = popen(script, "r");
        for (; man && fgets(line, sizeof line, man); printed = true)
            fputs(line, f);
        if (man)
            pclose(man);
        return printed ? GP_OK
                       : gp_fail(log, GP_ERR_IO,
                                 "help: man shows no section "
                                 "\"%s\"; see it in %s",
                                 title, page);
    }
    return gp_fail(log, GP_ERR_IO,
                   "help: no man page beside the program; see section \"%s\" "
                   "in man/glarepp.1 of the source", title);
}

/* A topic names an option exactly, ignoring an "s", or by one of its values. */
enum match { EXACT, LOOSE, VALUE };

/* Prints options that match so and no better, with their values; returns their
 * number. */
static int print_options_of(FILE *f, const char *topic, enum match wanted)
{
    const char *name, *text;
    int found = 0;
    for (const struct gp_option *o = gp_options; o->name; o++) {
        bool fits[] = {(topic[0] == o->letter && !topic[1]) ||
                           strcasecmp(topic, o->name) == 0,
                       is_topic(topic, o->name), false};
        for (int i = 0; (name = gp_option_value(o, i, &text)); i++) {
            const char *const colon = strchr(name, ':');
            fits[VALUE] |= strcasecmp(colon ? colon + 1 : name, topic) == 0;
        }
        if (!o->help || !fits[wanted] || (wanted > EXACT && fits[EXACT]) ||
            (wanted > LOOSE && fits[LOOSE]))
            continue;
        if (found++)
            putc('\n', f);
        print_option(f, o);
        for (int i = 0; (name = gp_option_value(o, i, &text)); i++) {
            if (text)
                gp_help_text(f, fprintf(f, "      %s", name), text);
        }
    }
    return found;
}

gp_status gp_help_topic(const struct gp_log *log, FILE *f, const char *topic)
{
    const struct section *section = NULL;
    struct topic t;
    bool found = false;
    if (!topic) {
        static const char *const heads[] = {
            ("Explains a part of glarepp.\n\n  glarepp help TOPIC\n\n"
             "TOPIC is a command:"),
            "the options of pictures:",
            "options for a task:",
            "a section of the manual:",
        };
        for (int i = 0, kind = -1; topic_at(i, &t); i++) {
            if (!t.text) // of help itself
                continue;
            if (kind != (int) t.kind)
                fprintf(f, "%s%s\n", i ? "\n" : "", heads[t.kind]);
            kind = (int) t.kind;
            fprintf(f, *t.text ? "  %-14s%.*s\n" : "  %s\n", t.word,
                    (int) strcspn(t.text, t.kind == COMMAND ? ".\n" : ""),
                    t.text);
        }
        fprintf(f, "\nor an option or one of its values:\n"
                   "  glarepp help --kernel\n  glarepp help splat\n"
                   "\nNumbers may change over frames: --gain "
                   "1001:0.5,1050:2, --sun @track.csv.\n");
        return GP_OK;
    }
    const char *const bare = topic + strspn(topic, "-");
    const bool dashed = bare > topic;
    if (!*bare)
        return unknown_topic(log, topic);
    for (int i = 0; !found && topic_at(i, &t); i++) {
        found = strcasecmp(t.word, bare) == 0 && t.kind != SECTION && t.text &&
                (t.kind == COMMAND || !dashed);
        if (found && t.kind == GROUP)
            print_group(f, t.group, ~0u);
        else if (found)
            gp_help(f, (enum gp_command) t.commands);
    }
    for (int i = 0; !dashed && i < SECTIONS && !section; i++)
        section = is_topic(bare, sections[i].word) ||
                          is_topic(bare, sections[i].more)
                      ? &sections[i] : NULL;
    found = found || print_options_of(f, bare, EXACT) > 0;
    if (!found && !section)
        found = print_options_of(f, bare, LOOSE) > 0 ||
                print_options_of(f, bare, VALUE) > 0;
    if (!found)
        return section ? show_section(log, f, section->title)
                       : unknown_topic(log, topic);
    if (section)
        fprintf(f, "\nman glarepp has more in its section \"%s\".\n",
                section->title);
    return GP_OK;
}

// -- the table, for the man page and completions ------------------------------

void gp_help_table(FILE *f)
{
    char text[1024];
    const char *name, *line;
    struct topic t;
    for (const struct gp_command_row *c = gp_commands; c->word; c++)
        fprintf(f, "command\t%s\n", *c->word ? c->word : "main");
    for (int i = 0; topic_at(i, &t); i++)
        fprintf(f, "topic\t%s\n", t.word);
    for (int g = 0; g < GP_GROUPS; g++) {
        fprintf(f, "group\t%s\t%s\n", gp_option_groups[g].title,
                gp_option_groups[g].example);
        for (const struct gp_option *o = gp_options; o->name; o++) {
            if ((int) o->group != g || !o->help)
                continue;
            const bool many = o->kind == GP_KIND_TEXTS ||
                              o->kind == GP_KIND_NAMED;
            option_text(o, false, text, sizeof text);
            fprintf(f, "option\t%s\t%.1s\t%s\t%s\t%s\t", o->name, &o->letter,
                    o->arg ? o->arg : "", many ? "many" : o->open ? "open" : "",
                    text);
            for (const struct gp_command_row *c = gp_commands; c->word; c++) {
                if (o->commands & c->bit)
                    fprintf(f, " %s", *c->word ? c->word : "main");
            }
            fprintf(f, " \n");
            for (int i = 0; (name = gp_option_value(o, i, &line)); i++)
                fprintf(f, "value\t%s\t%s\n", name, line ? line : "");
        }
    }
    for (int m = 0; (name = glarepp_name(NULL, GLAREPP_MODELS, m, &line));
         m++) {
        const char *source;
        struct glarepp_key k;
        glarepp_name(NULL, GLAREPP_MODEL_SOURCES, m, &source);
        fprintf(f, "model\t%s\t%s; %s.\n", name, line, source);
        for (int n = 0; glarepp_key(m, n, &k); n++) {
            fprintf(f, "key\t%s\t", k.name);
            for (int i = 0; k.words && k.words[i]; i++)
                fprintf(f, "%s%s", i ? " " : "", k.words[i]);
            fprintf(f, "\t%s%s", k.text, k.file ? " (a path)" : "");
            if (!k.file && !k.words)
                fprintf(f, " (%g to %g; default %g)", k.lo, k.hi, k.preset);
            fprintf(f, "\n");
        }
    }
    for (int i = 0; (name = glarepp_name(NULL, GLAREPP_PRESET_RECIPES, i,
                                         &line)); i++)
        fprintf(f, "preset\t%s\t%s\n", name, line);
#define ITEM(name, code, text) fprintf(f, "status\t%d\t%s\n", code, text);
    GP_STATUS_LIST(ITEM)
#undef ITEM
    fprintf(f, "@FIELDS@\n");
    for (int i = 0; gp_report_field(i); i++)
        fprintf(f, "field\t%s\n", gp_report_field(i));
}

// -- one screen --------------------------------------------------------------

void gp_help_screen(FILE *f)
{
    const char *const usage = gp_commands->usage;
    char text[1024];
    size_t at = 0;
    struct topic t;
    fprintf(f, "%.*s\n\n", (int) strcspn(usage, "\n"), usage);
    print_examples(f, gp_commands);
    for (const struct gp_option *o = gp_options; o->name; o++) {
        if (o->usual)
            fprintf(f, "%*s%s\n", INDENT + 1 - print_name(f, o), "", o->usual);
    }
    for (int i = 0; topic_at(i, &t); i++) {
        if (t.kind == COMMAND && t.text)
            fprintf(f, "%s%s", i ? ", " : "\nCommands: ", t.word);
        if (t.kind == ALL_OPTIONS)
            fprintf(f, " (glarepp COMMAND --help)\n");
        if (t.kind == SECTION ||
            (t.kind == GROUP && (t.commands & GP_COMMAND_MAIN)))
            at += (size_t) snprintf(text + at, sizeof text - at, "%s%s",
                                    at ? ", " : "Topics: ", t.word);
    }
    snprintf(text + at, sizeof text - at, " (glarepp help TOPIC)");
    print_wrapped(f, 0, 2, text);
    fprintf(f, "All options: glarepp --help all. What is used, and why: -v. "
               "More: man glarepp.\n");
}
