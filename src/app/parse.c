#include "app/options.h"

#include "app/settings.h"
#include "core/memory.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The lists of words. */
enum { LISTS = 4 };
static struct gp_texts *list_of(struct gp_settings *s, int i)
{
    struct gp_texts *const list[LISTS] = {
        &s->inputs, &s->outputs, &s->ocio_context, &s->light_groups,
    };
    return list[i];
}

gp_status gp_settings_make(const struct gp_log *log, int words,
                           struct gp_settings *s)
{
    *s = gp_defaults;
    for (int i = 0; i < LISTS; i++) {
        void *block;
        gp_status st = gp_alloc(log, "command line", (size_t) words + 1,
                                sizeof(char *), &block);
        if (st)
            return st;
        list_of(s, i)->at = block;
    }
    return GP_OK;
}

void gp_settings_free(struct gp_settings *s)
{
    for (int i = 0; i < LISTS; i++) {
        struct gp_texts *const list = list_of(s, i);
        GP_FREE(list->at);
        list->n = 0;
    }
}

// -- slips of the finger -------------------------------------------------------

enum { LONGEST = 31 };

static int least(int a, int b)
{
    return a < b ? a : b;
}

int gp_edits(const char *word, size_t n, const char *name)
{
    const size_t m = strlen(name);
    int rows[3][LONGEST + 1]; // of the table, in turn
    if (n > LONGEST || m > LONGEST)
        return 99;
    for (size_t j = 0; j <= m; j++)
        rows[0][j] = (int) j;
    for (size_t i = 1; i <= n; i++) {
        int *const row = rows[i % 3];
        const int *const above = rows[(i - 1) % 3];
        row[0] = (int) i;
        for (size_t j = 1; j <= m; j++) {
            const bool same = word[i - 1] == name[j - 1];
            row[j] = least(above[j - 1] + !same,
                           least(above[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && word[i - 1] == name[j - 2] &&
                word[i - 2] == name[j - 1])
                row[j] = least(row[j], rows[(i - 2) % 3][j - 2] + 1);
        }
    }
    return rows[n % 3][m];
}

struct gp_nearest gp_nearest_to(const char *word, size_t length, int most)
{
    // a word of which half is wrong says nothing
    const int half = length < 64 ? (int) length / 2 : 0;
    return (struct gp_nearest) {
        .word = word, .length = length, .most = least(most, half),
    };
}

void gp_nearest_try(struct gp_nearest *search, const char *name)
{
    const int edits = gp_edits(search->word, search->length, name);
    if (search->name ? edits < search->most : edits <= search->most) {
        search->most = edits;
        search->name = name;
    }
}

/* One option as it stands on the command line. */
struct use {
    const struct gp_log *log;
    const struct gp_option *option;
    const char *value;  // NULL for options that take none
    struct gp_settings *s;
};

static void *field(const struct use *u)
{
    return (char *) u->s + u->option->at;
}

// -- numbers -----------------------------------------------------------------

/* A number with a decimal point (nothing calls setlocale()), nothing before
 * it. Moves *s behind it. */
static bool read_double(const char **s, double *out)
{
    if (**s == '\0' || strchr(" \t\n\v\f\r", **s))
        return false;
    char *end;
    *out = strtod(*s, &end);
    bool read = end != *s;
    *s = end;
    return read;
}

static bool in_range(const struct gp_option *o, double v)
{
    return v >= o->lo && v <= o->hi; // false for NaN
}

static gp_status bad_number(const struct use *u, const char *kind)
{
    return gp_fail(u->log, GP_ERR_USAGE,
                   "--%s: not %s (found \"%s\"); give %s", u->option->name,
                   kind, u->value, gp_option_range(u->option).text);
}

static gp_status out_of_range(const struct use *u)
{
    return gp_fail(u->log, GP_ERR_USAGE,
                   "--%s: out of range (found %s); give %s", u->option->name,
                   u->value, gp_option_range(u->option).text);
}

static gp_status set_float(const struct use *u)
{
    const char *s = u->value;
    double v;
    if (!read_double(&s, &v) || *s)
        return bad_number(u, "a number");
    if (!in_range(u->option, v))
        return out_of_range(u);
    *(float *) field(u) = (float) v;
    return GP_OK;
}

/* Whole numbers of both widths. */
static gp_status set_whole(const struct use *u)
{
    char *end;
    errno = 0;
    long long v = strtoll(u->value, &end, 10);
    if (end == u->value || *end)
        return bad_number(u, "a whole number");
    if (errno == ERANGE || !in_range(u->option, (double) v))
        return out_of_range(u);
    if (u->option->kind == GP_KIND_INT)
        *(int *) field(u) = (int) v;
    else
        *(long long *) field(u) = v;
    return GP_OK;
}

/* Numbers with commas between them, `most` at most; 0 when they are not. */
static int read_list(const char *s, int most, double *v)
{
    int n = 0;
    while (n < most && read_double(&s, &v[n])) {
        n++;
        if (*s == '\0')
            return n;
        if (*s++ != ',')
            return 0;
    }
    return 0;
}

/* "x,y" into two doubles, or a list into a struct gp_numbers. */
static gp_status set_list(const struct use *u)
{
    const struct gp_option *const o = u->option;
    const bool pair = o->kind == GP_KIND_PAIR;
    const int least = pair ? 2 : o->least, most = pair ? 2 : o->most;
    struct gp_numbers list = {0};
    list.n = read_list(u->value, most, list.v);
    if (list.n < least)
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: not %s (found \"%s\"); write %s", o->name,
                       pair ? "two numbers" : "the numbers that it takes",
                       u->value, o->arg);
    for (int i = 0; i < list.n; i++) {
        if (!in_range(o, list.v[i]))
            return out_of_range(u);
    }
    if (pair)
        memcpy(field(u), list.v, 2 * sizeof *list.v);
    else
        memcpy(field(u), &list, sizeof list);
    return GP_OK;
}

// -- names -------------------------------------------------------------------

/* The values of an option in one line: "a, b, c". */
static void list_values(const struct gp_option *o, char *line, size_t size)
{
    const char *text, *name;
    size_t at = 0;
    line[0] = '\0';
    for (int i = 0; (name = gp_option_value(o, i, &text)) && at < size; i++) {
        int n = snprintf(line + at, size - at, "%s%s", i ? ", " : "", name);
        at += n > 0 ? (size_t) n : 0;
    }
}

static gp_status unknown_value(const struct use *u, const char *found)
{
    char line[512];
    list_values(u->option, line, sizeof line);
    return gp_fail(u->log, GP_ERR_USAGE,
                   "--%s: no such value (found \"%s\"); give one of %s",
                   u->option->name, found, line);
}

static const struct gp_option_choice *
find_choice(const struct gp_option *o, const char *name, size_t length)
{
    for (const struct gp_option_choice *c = o->choices; c->name; c++) {
        if (strlen(c->name) == length && strncmp(c->name, name, length) == 0)
            return c;
    }
    return NULL;
}

static gp_status set_choice(const struct use *u)
{
    const struct gp_option_choice *c =
        find_choice(u->option, u->value, strlen(u->value));
    if (!c)
        return unknown_value(u, u->value);
    memcpy(field(u), &c->value, sizeof c->value);
    return GP_OK;
}

static gp_status set_text(const struct use *u)
{
    const struct gp_option *o = u->option;
    const char *text, *name;
    bool known = !o->list || (o->open && strncmp(u->value, "builtin:", 8) != 0);
    for (int i = 0; !known && (name = gp_option_value(o, i, &text)); i++)
        known = strcmp(name, u->value) == 0;
    if (!known)
        return unknown_value(u, u->value);
    if (!*u->value && !o->blank)
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: needs a value (found an empty word); give %s",
                       o->name, o->arg);
    *(const char **) field(u) = u->value;
    return GP_OK;
}

static gp_status set_named(const struct use *u)
{
    size_t length = strcspn(u->value, "=");
    const struct gp_option_choice *c = find_choice(u->option, u->value, length);
    if (!c)
        return unknown_value(u, u->value);
    if (!u->value[length] || !u->value[length + 1])
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: no file (found \"%s\"); write %s=FILE",
                       u->option->name, u->value, c->name);
    ((const char **) field(u))[c->value] = u->value + length + 1;
    return GP_OK;
}

static gp_status set_texts(const struct use *u)
{
    if (!*u->value)
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: needs a value (found an empty word); give %s",
                       u->option->name, u->option->arg);
    struct gp_texts *t = field(u);
    t->at[t->n++] = u->value; // as long as argv
    return GP_OK;
}

static gp_status set_option(const struct use *u)
{
    const size_t row = (size_t) (u->option - gp_options);
    u->s->given[row / 64] |= UINT64_C(1) << row % 64;
    if (!u->value) {
        if (u->option->kind == GP_KIND_SET)
            memcpy(field(u), &u->option->set, sizeof u->option->set);
        else
            *(bool *) field(u) = true;
        return GP_OK;
    }
    switch (u->option->kind) {
    case GP_KIND_FLAG:
    case GP_KIND_SET:
        break;
    case GP_KIND_FLOAT:
        return set_float(u);
    case GP_KIND_INT:
    case GP_KIND_COUNT:
        return set_whole(u);
    case GP_KIND_PAIR:
    case GP_KIND_NUMBERS:
        return set_list(u);
    case GP_KIND_CHOICE:
        return set_choice(u);
    case GP_KIND_TEXT:
        return set_text(u);
    case GP_KIND_TEXTS:
        return set_texts(u);
    case GP_KIND_NAMED:
        return set_named(u);
    }
    return GP_ERR_BUG;
}

// -- commands ----------------------------------------------------------------

static const struct {
    const char *word;
    enum gp_command command;
} commands[] = {
    {"", GP_COMMAND_MAIN},
    {"bench", GP_COMMAND_BENCH},
    {"compare", GP_COMMAND_COMPARE},
    {"help", GP_COMMAND_HELP},
};
enum { COMMANDS = (int) (sizeof commands / sizeof *commands) };

const char *gp_command_word(enum gp_command command)
{
    int i = 0;
    while (i < COMMANDS - 1 && !(commands[i].command & command))
        i++;
    return commands[i].word;
}

const char *gp_command_at(int i, enum gp_command *command)
{
    if (i < 0 || i >= COMMANDS)
        return NULL;
    *command = commands[i].command;
    return commands[i].word;
}

/* The command of a command line; moves *i behind its word. */
static enum gp_command read_command(int argc, char *const argv[], int *i)
{
    for (int c = 1; c < COMMANDS && argc > *i; c++) {
        if (strcmp(argv[*i], commands[c].word) == 0) {
            ++*i;
            return commands[c].command;
        }
    }
    return GP_COMMAND_MAIN;
}

/* A first word that is nearly a command's and names no file. */
static gp_status check_slip(const struct gp_log *log, const char *word)
{
    struct gp_nearest near = gp_nearest_to(word, strlen(word), 2);
    for (int c = 1; c < COMMANDS; c++)
        gp_nearest_try(&near, commands[c].word);
    if (!near.name || word[strspn(word, "abcdefghijklmnopqrstuvwxyz")] ||
        access(word, F_OK) == 0)
        return GP_OK;
    return gp_fail(log, GP_ERR_USAGE,
                   "%s: no such command or file; did you mean glarepp %s?",
                   word, near.name);
}

static gp_status other_command(const struct use *u)
{
    const char *name = u->option->name;
    if (u->s->command == GP_COMMAND_MAIN)
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: not for pictures; write glarepp %s --%s, or "
                       "leave it out", name,
                       gp_command_word(u->option->commands), name);
    return gp_fail(u->log, GP_ERR_USAGE,
                   "--%s: not for glarepp %s; glarepp %s --help lists its "
                   "options", name, gp_command_word(u->s->command),
                   gp_command_word(u->s->command));
}

// -- words -------------------------------------------------------------------

static gp_status unknown_option(const struct gp_log *log,
                                enum gp_command command, const char *word)
{
    const char *name = word + strspn(word, "-");
    size_t length = strcspn(name, "=");
    struct gp_nearest near = gp_nearest_to(name, length, 3);
    for (const struct gp_option *o = gp_options; o->name; o++) {
        if (!o->hidden && (o->commands & command))
            gp_nearest_try(&near, o->name);
    }
    int shown = (int) (name - word + (ptrdiff_t) length);
    if (near.name)
        return gp_fail(log, GP_ERR_USAGE,
                       "%.*s: unknown option; did you mean --%s?", shown,
                       word, near.name);
    return gp_fail(log, GP_ERR_USAGE,
                   "%.*s: unknown option; glarepp %s%s--help lists them",
                   shown, word, gp_command_word(command),
                   command == GP_COMMAND_MAIN ? "" : " ");
}

/* Finds the option that `word` names. *value is what stands in the word
 * behind it ("--gain=2", "-g2"), or NULL. */
static const struct gp_option *split(const char *word, const char **value)
{
    *value = NULL;
    if (word[1] != '-') {
        *value = word[2] ? word + 2 : NULL;
        return gp_option_letter(word[1]);
    }
    const char *name = word + 2;
    size_t length = strcspn(name, "=");
    if (name[length])
        *value = name + length + 1;
    return gp_option_find(name, length);
}

/* True when a word that should be a value is an option: its value was
 * forgotten. */
static bool is_long_option(const char *word)
{
    const char *value;
    return strncmp(word, "--", 2) == 0 && split(word, &value);
}

/* `glarepp help --gain` asks about an option. */
static bool is_topic(enum gp_command command, const char *word)
{
    const char *value;
    const struct gp_option *o = split(word, &value);
    return command == GP_COMMAND_HELP && !(o && (o->commands & command));
}

/* Reads the option at argv[*i] and moves *i to its last word. */
static gp_status read_option(const struct gp_log *log, int argc,
                             char *const argv[], int *i,
                             struct gp_settings *s)
{
    const char *word = argv[*i];
    struct use u = {.log = log, .s = s};
    u.option = split(word, &u.value);
    if (!u.option)
        return unknown_option(log, s->command, word);
    if (!(u.option->commands & s->command))
        return other_command(&u);
    if (!u.option->arg && u.value)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: takes no value (found \"%s\"); leave it out",
                       word, u.value);
    if (u.option->arg && !u.value) {
        if (*i + 1 >= argc)
            return gp_fail(log, GP_ERR_USAGE, "%s: needs a value; give %s",
                           word, u.option->arg);
        if (is_long_option(argv[*i + 1]))
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: needs a value (found the option %s); give %s",
                           word, argv[*i + 1], u.option->arg);
        u.value = argv[++*i];
    }
    return set_option(&u);
}

// -- the whole line ----------------------------------------------------------

gp_status gp_options_parse(const struct gp_log *log, int argc,
                           char *const argv[], struct gp_settings *out)
{
    gp_status st = gp_settings_make(log, argc, out);
    bool options = true; // until "--"
    int i = 1;
    out->command = read_command(argc, argv, &i);
    if (!st && argc > 1 && out->command == GP_COMMAND_MAIN)
        st = check_slip(log, argv[1]);
    for (; i < argc && !st; i++) {
        const char *word = argv[i];
        if (options && strcmp(word, "--") == 0)
            options = false;
        else if (options && word[0] == '-' && word[1] &&
                 !is_topic(out->command, word))
            st = read_option(log, argc, argv, &i, out);
        else
            out->inputs.at[out->inputs.n++] = word;
    }
    if (st || out->help || out->help_man || out->version)
        return st;
    return gp_settings_check(log, out);
}
