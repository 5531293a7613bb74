#include "app/options.h"

#include "io/versions.h"

#include <ctype.h>
#include <jansson.h>
#include <string.h>

enum {
    WIDTH = 79,   // columns of --help
    INDENT = 28,  // where the texts of options start
};

/* The default of an option in words; "" when there is nothing to say. */
static void default_text(const struct gp_option *o, char *text, size_t size)
{
    const void *at = (const char *) &gp_defaults + o->at;
    const char *word = NULL;
    int value;
    text[0] = '\0';
    switch (o->kind) {
    case GP_KIND_FLOAT:
        snprintf(text, size, "%g", (double) *(const float *) at);
        return;
    case GP_KIND_INT:
        snprintf(text, size, "%d", *(const int *) at);
        return;
    case GP_KIND_COUNT:
        snprintf(text, size, "%lld", *(const long long *) at);
        return;
    case GP_KIND_TEXT:
        word = *(const char *const *) at;
        break;
    case GP_KIND_CHOICE:
        memcpy(&value, at, sizeof value);
        for (const struct gp_option_choice *c = o->choices; c->name && !word;
             c++)
            word = c->value == value ? c->name : NULL;
        break;
    case GP_KIND_FLAG:
    case GP_KIND_SET:
    case GP_KIND_PAIR:
    case GP_KIND_NUMBERS:
    case GP_KIND_TEXTS:
    case GP_KIND_NAMED:
        break;
    }
    if (word)
        snprintf(text, size, "%s", word);
}

static bool is_number(const struct gp_option *o)
{
    return o->kind == GP_KIND_FLOAT || o->kind == GP_KIND_INT ||
           o->kind == GP_KIND_COUNT;
}

/* What stands behind an option's text: its values, range and default. */
static void remarks(const struct gp_option *o, bool values, char *text,
                    size_t size)
{
    char value[64];
    const char *name, *line;
    size_t at = 0;
    text[0] = '\0';
    for (int i = 0; values && at < size &&
                    (name = gp_option_value(o, i, &line)); i++)
        at += (size_t) snprintf(text + at, size - at, "%s%s",
                                i ? ", " : o->open ? ", or " : ": ", name);
    default_text(o, value, sizeof value);
    if (value[0] && at < size && is_number(o))
        snprintf(text + at, size - at, " (%s; default %s)",
                 gp_option_range(o).text, value);
    else if (value[0] && at < size)
        snprintf(text + at, size - at, " (default %s)", value);
}

// -- --help ------------------------------------------------------------------

/* Prints `text` from column `column` on, wrapped and indented. */
static void wrap(FILE *f, int column, const char *text)
{
    while (*text) {
        int n = (int) strcspn(text, " ");
        if (column + n > WIDTH && column > INDENT) {
            fprintf(f, "\n%*s", INDENT, "");
            column = INDENT;
        }
        fprintf(f, "%.*s", n, text);
        column += n;
        text += n;
        if (*text == ' ') {
            text++;
            if (column + 1 + (int) strcspn(text, " ") <= WIDTH) {
                putc(' ', f);
                column++;
            } else {
                fprintf(f, "\n%*s", INDENT, "");
                column = INDENT;
            }
        }
    }
    putc('\n', f);
}

void gp_help_option(FILE *f, const struct gp_option *o)
{
    char text[1024], more[768];
    int column = o->letter ? fprintf(f, "  -%c, --%s", o->letter, o->name)
                           : fprintf(f, "      --%s", o->name);
    if (o->arg)
        column += fprintf(f, " %s", o->arg);
    if (column >= INDENT - 1)
        fprintf(f, "\n%*s", INDENT, "");
    else
        fprintf(f, "%*s", INDENT - column, "");
    remarks(o, true, more, sizeof more);
    snprintf(text, sizeof text, "%s%s", o->help, more);
    wrap(f, INDENT, text);
}

void gp_help_value(FILE *f, const char *name, const char *text)
{
    const int column = fprintf(f, "      %s", name);
    if (column >= INDENT - 1)
        fprintf(f, "\n%*s", INDENT, "");
    else
        fprintf(f, "%*s", INDENT - column, "");
    wrap(f, INDENT, text);
}

/* What a command is for, and how it is called. */
static void help_head(FILE *f, enum gp_command command)
{
    if (command == GP_COMMAND_BENCH) {
        fprintf(f, "Measures speed against error on a frame, for every "
                   "technique.\n\n"
                   "  glarepp bench [options] INPUT\n"
                   "  glarepp bench [options] --paper\n\n"
                   "INPUT is a file, or - for stdin (EXR).\n");
        return;
    }
    if (command == GP_COMMAND_COMPARE) {
        fprintf(f, "Says how far two images, or two sequences, are apart.\n\n"
                   "  glarepp compare [options] A B\n\n"
                   "A, the reference, and B are files or patterns; one may be "
                   "- for stdin.\nExit status: 0 match, 1 warning, 2 failure "
                   "(or a wrong command line),\n3 nothing to compare, 4 a "
                   "file cannot be read or written.\n");
        return;
    }
    fprintf(f, "Adds the glare of bright light to HDR frames.\n\n"
               "  glarepp [options] -o OUTPUT INPUT...\n"
               "  glarepp bench [options] INPUT    "
               "(see glarepp bench --help)\n"
               "  glarepp compare [options] A B    "
               "(see glarepp compare --help)\n"
               "  glarepp help [TOPIC]\n\n"
               "INPUT and OUTPUT are files, - for stdin and stdout (EXR), or "
               "patterns:\nshot.####.exr, shot.@.exr, shot.%%04d.exr; %%V in them is a view.\n");
}

/* An example stands where its own command is explained. */
static bool is_example_of(const char *line, enum gp_command command)
{
    const char *const word = gp_command_word(command);
    const size_t n = strlen(word);
    const char *second = line + strlen("glarepp ");
    if (command == GP_COMMAND_MAIN)
        return *second == '-' || strncmp(second, "help ", 5) == 0;
    return strncmp(second, word, n) == 0 && second[n] == ' ';
}

bool gp_help_group(FILE *f, int group, unsigned commands)
{
    const struct gp_option_heading *const head = &gp_option_groups[group];
    bool headed = false;
    for (const struct gp_option *o = gp_options; o->name; o++) {
        if ((int) o->group != group || o->hidden || !(o->commands & commands))
            continue;
        if (!headed) {
            fprintf(f, "%s\n", head->title);
            enum gp_command command;
            bool shown = false;
            for (int i = 0; gp_command_at(i, &command) && !shown; i++) {
                shown = (commands & command) &&
                        is_example_of(head->example, command);
                if (shown)
                    fprintf(f, "    %s\n", head->example);
            }
        }
        headed = true;
        gp_help_option(f, o);
    }
    return headed;
}

void gp_help(FILE *f, enum gp_command command)
{
    help_head(f, command);
    putc('\n', f);
    for (int g = 0; g < GP_GROUPS; g++) {
        if (gp_help_group(f, g, command))
            putc('\n', f);
    }
    fprintf(f, "The first command to try: %s\n",
            command == GP_COMMAND_BENCH     ? "glarepp bench frame.exr"
            : command == GP_COMMAND_COMPARE ? "glarepp compare a.exr b.exr"
                                        : "glarepp -o out.png frame.exr");
}

// -- the man page ------------------------------------------------------------

/* Prints one word as roff: no character of it is a command. */
static void roff_word(FILE *f, const char *word, int n)
{
    for (int i = 0; i < n; i++) {
        if (i == 0 && (word[i] == '.' || word[i] == '\''))
            fputs("\\&", f);
        if (word[i] == '\\')
            fputs("\\e", f);
        else if (word[i] == '-' && isdigit((unsigned char) word[i + 1]))
            fputs("\\-", f); // a minus
        else
            putc(word[i], f);
    }
}

/* Prints text as roff lines of at most 80 characters. */
static void roff(FILE *f, const char *text)
{
    for (int column = 0; *text;) {
        int n = (int) strcspn(text, " ");
        if (column && column + n > 70) { // room for escapes
            putc('\n', f);
            column = 0;
        } else if (column) {
            putc(' ', f);
        }
        roff_word(f, text, n);
        column += n + 1;
        text += n;
        text += strspn(text, " ");
    }
    putc('\n', f);
}

static void man_values(FILE *f, const struct gp_option *o)
{
    const char *name, *text;
    if (!gp_option_value(o, 0, &text))
        return;
    fprintf(f, ".Bl -tag -width Ds -compact\n");
    for (int i = 0; (name = gp_option_value(o, i, &text)); i++) {
        fprintf(f, ".It Cm ");
        roff(f, name);
        if (text)
            roff(f, text);
    }
    fprintf(f, ".El\n");
}

static void man_option(FILE *f, const struct gp_option *o)
{
    char text[1024], more[128];
    fprintf(f, ".It ");
    if (o->letter)
        fprintf(f, "Fl %c , ", o->letter);
    fprintf(f, "Fl \\-%s", o->name);
    if (o->arg)
        fprintf(f, " Ar %s", o->arg);
    putc('\n', f);
    remarks(o, false, more, sizeof more);
    snprintf(text, sizeof text, "%s%s.", o->help, more);
    roff(f, text);
    man_values(f, o);
}

/* The options of pictures that bench takes too, in one sentence. */
static void man_bench(FILE *f)
{
    const unsigned both = GP_COMMAND_MAIN | GP_COMMAND_BENCH;
    const char *before = NULL;
    for (const struct gp_option *o = gp_options; o->name; o++) {
        if (o->hidden || (o->commands & both) != both)
            continue;
        if (before)
            fprintf(f, ".Fl \\-%s ,\n", before);
        before = o->name;
    }
    if (before)
        fprintf(f, "and\n.Fl \\-%s .\n", before);
}

void gp_help_man(FILE *f)
{
    fprintf(f, "@OPTIONS@\n");
    for (int g = 0; g < GP_GROUPS; g++) {
        fprintf(f, ".Ss %s\n.Dl %s\n.Bl -tag -width Ds\n",
                gp_option_groups[g].title, gp_option_groups[g].example);
        for (const struct gp_option *o = gp_options; o->name; o++) {
            if ((int) o->group == g && !o->hidden)
                man_option(f, o);
        }
        fprintf(f, ".El\n");
    }
    fprintf(f, "@BENCH@\n");
    man_bench(f);
    fprintf(f, "@EXIT@\n");
#define ITEM(name, code, text) fprintf(f, ".It %d\n%s.\n", code, text);
    GP_STATUS_LIST(ITEM)
#undef ITEM
}

// -- --version -----------------------------------------------------------------

void gp_version(FILE *f)
{
    char io[256];
    gp_io_versions(io, sizeof io);
    fprintf(f, "glarepp " GP_VERSION "\n"
               "with %s, jansson %s\n"
               "opened when needed: FFTW 3, OpenImageIO, OpenColorIO, OSMesa, EGL\n"
               "GPL-3.0-or-later; no warranty\n", io, jansson_version_str());
}
