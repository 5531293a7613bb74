#include "app/options.h"

#include "app/manual.h"
#include "app/options.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* What is looked for, and where it is printed. */
struct search {
    FILE *f;
    const char *topic;  // without dashes
    const char *parts;  // of the man page: what gp_help_man() prints
    bool loose;         // an "s" at the end does not count
    int found;
};

static bool is_topic(const struct search *s, const char *name)
{
    size_t n = strlen(name), m = strlen(s->topic);
    if (s->loose) {
        n -= n > 1 && name[n - 1] == 's';
        m -= m > 1 && s->topic[m - 1] == 's';
    }
    return n == m && strncasecmp(name, s->topic, n) == 0;
}

/* A blank line between the parts that are printed. */
static void part(struct search *s)
{
    if (s->found++)
        putc('\n', s->f);
}

// -- parts -------------------------------------------------------------------

static void try_commands(struct search *s)
{
    enum gp_command command;
    const char *word;
    for (int i = 1; (word = gp_command_at(i, &command)); i++) {
        if (!is_topic(s, word) || command == GP_COMMAND_HELP)
            continue;
        part(s);
        gp_help(s->f, command);
    }
}

/* True when the heading of the man page goes with the group's options. */
static bool is_of_group(const struct gp_section *section, int group)
{
    const char *const title = gp_option_groups[group].title;
    return gp_section_is(section, gp_option_groups[group].word, false) ||
           (strlen(title) == section->title_size &&
            strncmp(title, section->title, section->title_size) == 0);
}

static void try_groups(struct search *s)
{
    struct gp_section section;
    for (int g = 0; g < GP_GROUPS; g++) {
        if (!is_topic(s, gp_option_groups[g].word))
            continue;
        const char *at = gp_manual_text;
        for (; gp_section_next(at, &section); at = section.text) {
            if (!is_of_group(&section, g))
                continue;
            part(s);
            gp_section_print(s->f, &section, s->parts);
        }
        part(s);
        gp_help_group(s->f, g, ~0u);
    }
}

static void try_sections(struct search *s)
{
    struct gp_section section;
    const char *at = gp_manual_text;
    for (; gp_section_next(at, &section); at = section.text) {
        if (!gp_section_is(&section, s->topic, s->loose))
            continue;
        part(s);
        gp_section_print(s->f, &section, s->parts);
    }
}

/* An option with a line for each of its values. */
static void print_option(struct search *s, const struct gp_option *o)
{
    const char *name, *text;
    part(s);
    gp_help_option(s->f, o);
    for (int i = 0; (name = gp_option_value(o, i, &text)); i++) {
        if (text)
            gp_help_value(s->f, name, text);
    }
}

static void try_options(struct search *s)
{
    for (const struct gp_option *o = gp_options; o->name; o++) {
        const bool letter = o->letter && s->topic[0] == o->letter &&
                            !s->topic[1];
        if (!o->hidden && (letter || is_topic(s, o->name)))
            print_option(s, o);
    }
}

static void try_values(struct search *s)
{
    for (const struct gp_option *o = gp_options; o->name; o++) {
        const char *name, *text;
        bool has = false;
        for (int i = 0; (name = gp_option_value(o, i, &text)) && !has; i++) {
            const char *colon = strchr(name, ':');
            has = is_topic(s, name) || (colon && is_topic(s, colon + 1));
        }
        if (has && !o->hidden)
            print_option(s, o);
    }
}

// -- all topics --------------------------------------------------------------

static void list_topics(FILE *f)
{
    enum gp_command command;
    struct gp_section section;
    const char *word;
    fprintf(f, "Explains a part of glarepp.\n\n  glarepp help TOPIC\n\n"
               "TOPIC is a command:\n");
    for (int i = 1; (word = gp_command_at(i, &command)); i++) {
        if (command != GP_COMMAND_HELP)
            fprintf(f, "  %s\n", word);
    }
    fprintf(f, "\noptions for a task:\n");
    for (int g = 0; g < GP_GROUPS; g++)
        fprintf(f, "  %-14s%s\n", gp_option_groups[g].word,
                gp_option_groups[g].title);
    fprintf(f, "\na subject:\n");
    for (const char *at = gp_manual_text; gp_section_next(at, &section);
         at = section.text) {
        char name[32];
        int g = 0;
        while (g < GP_GROUPS && !is_of_group(&section, g))
            g++;
        gp_section_word(&section, name, sizeof name);
        if (g == GP_GROUPS)
            fprintf(f, "  %-14s%.*s\n", name, (int) section.title_size,
                    section.title);
    }
    fprintf(f, "\nor an option or one of its values:\n"
               "  glarepp help --kernel\n  glarepp help splat\n");
}

static gp_status unknown_topic(const struct gp_log *log, const char *topic)
{
    const char *const bare = topic + strspn(topic, "-");
    struct gp_nearest near = gp_nearest_to(bare, strlen(bare), 3);
    enum gp_command command;
    struct gp_section section;
    const char *word;
    char name[32], kept[32] = "";
    for (int i = 1; (word = gp_command_at(i, &command)); i++)
        gp_nearest_try(&near, word);
    for (int g = 0; g < GP_GROUPS; g++)
        gp_nearest_try(&near, gp_option_groups[g].word);
    for (const struct gp_option *o = gp_options; o->name; o++) {
        if (!o->hidden)
            gp_nearest_try(&near, o->name);
    }
    for (const char *at = gp_manual_text; gp_section_next(at, &section);
         at = section.text) {
        gp_section_word(&section, name, sizeof name);
        gp_nearest_try(&near, name);
        if (near.name == name) // `name` is another section's next
            near.name = memcpy(kept, name, sizeof kept);
    }
    if (near.name)
        return gp_fail(log, GP_ERR_USAGE,
                       "help: no such topic (found \"%s\"); did you mean "
                       "glarepp help %s?", topic, near.name);
    return gp_fail(log, GP_ERR_USAGE,
                   "help: no such topic (found \"%s\"); glarepp help lists "
                   "them", topic);
}

gp_status gp_help_topic(const struct gp_log *log, FILE *f, const char *topic)
{
    if (!topic) {
        list_topics(f);
        return GP_OK;
    }
    char *parts = NULL;
    size_t size;
    FILE *memory = open_memstream(&parts, &size);
    if (!memory)
        return gp_fail(log, GP_ERR_BUG, "help: out of memory; free some");
    gp_help_man(memory);
    if (fclose(memory) != 0) {
        free(parts);
        return gp_fail(log, GP_ERR_BUG, "help: out of memory; free some");
    }
    struct search s = {.f = f, .topic = topic + strspn(topic, "-"),
                       .parts = parts};
    for (int pass = 0; pass < 2 && !s.found && *s.topic; pass++) {
        s.loose = pass > 0;
        try_commands(&s);
        if (!s.found && topic[0] != '-')
            try_groups(&s);
        // a bare word may be a subject and an option: views
        const bool known = s.found;
        if (!known && topic[0] != '-')
            try_sections(&s);
        if (!known)
            try_options(&s);
        if (!s.found)
            try_sections(&s);
    }
    s.loose = false;
    if (!s.found && *s.topic)
        try_values(&s);
    free(parts);
    return s.found ? GP_OK : unknown_topic(log, topic);
}
