// SPDX-License-Identifier: Apache-2.0
#include "cli/words.h"

#include "core/json.h"
#include "core/memory.h"
#include "io/file.h"
#include "io/read.h"
#include "io/sequence.h"

#include <jansson.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void say_there(void *user, const struct gp_line *line)
{
    const struct gp_place *const p = user;
    struct gp_line there = *line;
    char text[GP_LINE_BYTES], number[16] = "";
    if (p->line)
        snprintf(number, sizeof number, ":%d", p->line);
    snprintf(text, sizeof text, "%s%s: %s", p->path, number, line->text);
    there.level = line->level == GP_LEVEL_BARE ? GP_LEVEL_ERROR : line->level;
    there.text = text;
    if (p->to && p->to->sink)
        p->to->sink(p->to->user, &there);
}

struct gp_log gp_place_log(struct gp_place *p, const struct gp_log *to,
                           const char *path, int line)
{
    *p = (struct gp_place) {to, path, line};
    return (struct gp_log) {say_there, p, to ? to->level : GP_LEVEL_ERROR};
}

// -- options as words ----------------------------------------------------------

const char *gp_base_name(const char *path)
{
    const char *const slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

/* Prints a blank, then the first n bytes of `head` and `word`, quoted for a shell
 * as one word. */
static void print_word(FILE *f, const char *head, size_t n, const char *word)
{
    static const char plain[] =
        "abcdefghijklmnopqrstuvwxyz"
        "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=:,./@%";
    const bool bare = n + strlen(word) > 0 && strspn(head, plain) >= n &&
                      !word[strspn(word, plain)];
    fputs(bare ? " " : " '", f);
    for (size_t i = 0; i < n || *word; i++) {
        const char c = i < n ? head[i] : *word++;
        if (c == '\'')
            fputs("'\\''", f);
        else
            fputc(c, f);
    }
    if (!bare)
        fputc('\'', f);
}

/* Ends a stream of open_memstream() and its *text; false where memory was full.
 * (glibc's fclose() succeeds even when the last block cannot be allocated.) */
static bool end_text(FILE *f, char *const *text)
{
    const bool full = ferror(f);
    return fclose(f) == 0 && !full && *text;
}

/* Returns the path that an option's value names, up to its end, or to a comma
 * in a kernel's recipe; NULL: none. */
static const char *path_in(const struct gp_option *o, const char *value)
{
    const char *const is = strchr(value, '=');
    if (o->at == offsetof(struct gp_settings, input.light_groups)) {
        const char *const own = strstr(value, "kernel=");
        const char *const within = own ? strstr(own, "file=") : NULL;
        char kernel[PATH_MAX];
        snprintf(kernel, sizeof kernel, "%s", own ? own + 7 : "");
        char *const gain = strstr(kernel, ",gain=");
        if (gain)
            *gain = '\0';
        return !own                        ? NULL
               : within                    ? within + 5
               : gp_kernel_is_file(kernel) ? own + 7
                                           : NULL;
    }
    const char *const file = strstr(value, "file=");
    if (file && o->kind == GP_KIND_TEXTS && !gp_kernel_is_file(value))
        return file + 5;
    if (o->kind >= GP_KIND_FLOAT && o->kind <= GP_KIND_NUMBERS)
        return *value == '@' ? value + 1 : NULL; // of keys
    if (o->at == offsetof(struct gp_settings, light.mask)) {
        const struct gp_mask_word mask = gp_mask_word_of(value);
        return mask.crypto ? NULL : mask.word;
    }
    if ((strcmp(o->arg, "CONFIG") == 0 || strstr(o->arg, "FILE")) &&
        !strstr(value, "://"))
        return value;
    return is && is[1] == '/' ? is + 1 : NULL; // NAME=/some/folder/file
}

/* Prints the options that pixels depend on, or others that have a value (not
 * --threads: a page is the same for any), each after `before`; `whole`: with folders of this machine. */
static void print_options(FILE *f, const struct gp_settings *s,
                          const char *before, bool whole, bool others)
{
    for (int i = 0; i + 1 < s->words.options.n; i += 2) {
        const char *const name = s->words.options.at[i];
        const char *value = s->words.options.at[i + 1];
        const struct gp_option *const o = gp_option_find(name, strlen(name));
        if (gp_option_makes_pixels(o) == others ||
            (others && (!value || strcmp(name, "threads") == 0)))
            continue;
        fprintf(f, "%s--%s", before, name);
        if (!whole && value && strcmp(o->arg, "CONFIG") == 0)
            value = s->tone.map.config; // of env, too
        const char *const path = whole || !value ? NULL : path_in(o, value);
        if (path)
            print_word(f, value, (size_t) (path - value), gp_base_name(path));
        else if (value)
            print_word(f, "", 0, value);
    }
}

gp_status gp_command_text(const struct gp_log *log, const struct gp_settings *s,
                          const char *const *input, int inputs,
                          enum gp_command_form form, char **out)
{
    const bool whole = form != GP_COMMAND_NAMES;
    char *text = NULL;
    size_t size;
    FILE *const f = open_memstream(&text, &size);
    *out = NULL;
    if (!f)
        return gp_no_memory_bare(log, "command line");
    const char *const word = gp_command_of(s->command)->word;
    fprintf(f, "glarepp%s%s", *word ? " " : "", word);
    print_options(f, s, " ", whole, false);
    for (int i = 0; i < inputs; i++) {
        const char *const name = whole ? input[i] : gp_base_name(input[i]);
        // (no option, but "-" is stdin)
        print_word(f, "./", *name == '-' && name[1] ? 2 : 0, name);
    }
    if (form == GP_COMMAND_ALL)
        print_options(f, s, " ", true, true);
    const bool written = end_text(f, &text);
    if (written) // control characters would break listings of the file
        gp_make_printable(text);
    json_t *const clean = written ? gp_json_name(text) : NULL;
    free(text);
    *out = clean ? strdup(json_string_value(clean)) : NULL;
    json_decref(clean);
    return *out ? GP_OK : gp_no_memory_bare(log, "command line");
}

gp_status gp_settings_save(const struct gp_log *log,
                           const struct gp_settings *s)
{
    const char *const path = s->words.save_settings;
    char *text = NULL;
    size_t size;
    if (s->output.write.no_clobber && gp_file_exists(path))
        return GP_OK;
    FILE *const f = open_memstream(&text, &size);
    if (!f)
        return gp_no_memory(log, path);
    fprintf(f, "# glarepp " GP_VERSION ": options without inputs and outputs, "
               "for --settings");
    print_options(f, s, "\n", true, false);
    fprintf(f, "\n");
    const gp_status st =
        end_text(f, &text) ? gp_file_save(log, path, s->output.write.create_dir,
                                          false, text, size)
                           : gp_no_memory(log, path);
    free(text);
    return st;
}

// -- files of settings ---------------------------------------------------------

enum { MOST_BYTES = 1 << 20 };

/* Splits a text into words, in place. */
static gp_status split(const struct gp_log *log, char *text, bool command,
                       struct gp_words *w)
{
    static const char blanks[] = " \t\r\n";
    char *to = text;
    const char *c = text;
    c += strncmp(c, "\xef\xbb\xbf", 3) == 0 ? 3 : 0; // byte order mark
    for (int line = 1; *c;) {
        struct gp_place place;
        const struct gp_log there = gp_place_log(&place, log, w->path, line);
        if (strchr(blanks, *c)) {
            line += *c++ == '\n';
            continue;
        }
        if (*c == '#' && !command) {
            c += strcspn(c, "\n");
            continue;
        }
        if (w->n == GP_WORDS)
            return gp_fail(&there, GP_ERR_DATA,
                           "too many words (over %d); write fewer options",
                           GP_WORDS);
        w->line[w->n] = command ? 0 : line;
        w->word[w->n++] = to;
        char quote = '\0';
        for (; *c && (quote || !strchr(blanks, *c)); c++) {
            line += *c == '\n';
            if (*c == quote)
                quote = '\0';
            else if (!quote && (*c == '\'' || *c == '"'))
                quote = *c;
            else if (*c == '\\' && c[1] &&
                     (!quote || (quote == '"' && strchr("\"\\", c[1]))))
                *to++ = *++c;
            else
                *to++ = *c;
        }
        if (quote)
            return gp_fail(&there, GP_ERR_DATA,
                           "a quote that does not end (found %c); close it",
                           quote);
        line += *c == '\n';
        c += *c != '\0';
        *to++ = '\0';
    }
    return GP_OK;
}

/* A text that a PNG or EXR has, from gp_strdup(); NULL: none. */
static char *text_of(const struct gp_frame *f, const char *name)
{
    char *text = gp_frame_text(f, name);
    for (int i = 0; i < f->attributes && !text; i++) {
        if (strcmp(f->attribute[i].name, name) == 0)
            text = gp_strdup(f->attribute[i].text);
    }
    return text;
}

gp_status gp_words_command(const struct gp_log *log, const char *path,
                           bool named, char **out)
{
    const struct gp_read_params p = GP_READ_DEFAULTS;
    struct gp_frame f;
    size_t size;
    gp_status st = gp_read_frame(log, &p, path, &f);
    *out = NULL;
    if (st)
        return st;
    char *const command = text_of(&f, "glarepp:command");
    char *const output =
        command && named ? text_of(&f, "glarepp:output") : NULL;
    gp_frame_free(&f);
    if (!command)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: no settings (found no glarepp:command); give a "
                       "picture that glarepp made",
                       path);
    FILE *const text = open_memstream(out, &size);
    if (text)
        fputs(command, text);
    if (text && output) {
        print_word(text, "", 0, output);
        print_word(text, "", 0, gp_base_name(path));
    }
    gp_free(command);
    gp_free(output);
    return text && end_text(text, out) ? GP_OK : gp_no_memory(log, path);
}

gp_status gp_words_read(const struct gp_log *log, const char *path,
                        struct gp_words **out)
{
    struct gp_words *w;
    void *block;
    uint64_t size = 0;
    gp_status st;
    GP_TRY(gp_alloc_zero(log, "settings", 1, sizeof *w, &w));
    w->path = path;
    GP_TRY(gp_load_regular(log, path, MOST_BYTES, &block, &size));
    w->text = block;
    const bool picture = strncmp(w->text, "\x89PNG", 4) == 0 ||
                         strncmp(w->text, "\x76\x2f\x31\x01", 4) == 0;
    if (picture) {
        GP_FREE(w->text);
        GP_TRY(gp_words_command(log, path, false, &w->text));
    } else if (size > MOST_BYTES || strlen(w->text) < size)
        GP_TRY(gp_fail(
            log, GP_ERR_DATA,
            "%s: no settings (found %s); give a text with an option a line, or "
            "a PNG or EXR that glarepp made",
            path, size > MOST_BYTES ? "over 1 MiB" : "bytes that are no text"));
    GP_TRY(split(log, w->text, picture, w));
    if (picture && (w->n < 2 || strcmp(w->word[0], "glarepp") != 0 ||
                    (w->n > 2 && gp_command_named(w->word[1]))))
        GP_TRY(
            gp_fail(log, GP_ERR_DATA,
                    "%s: no settings of a picture (found the command "
                    "%s%s%s); give a picture of glarepp -o, --hdr or --layer",
                    path, w->n ? w->word[0] : "\"\"", w->n > 1 ? " " : "",
                    w->n > 1 ? w->word[1] : ""));
    if (picture) { // its options: not its first word, nor its input
        w->n -= 2;
        memmove(w->word, w->word + 1, (size_t) w->n * sizeof *w->word);
    }
    *out = w;
    return GP_OK;
out:
    gp_words_free(&w);
    return st;
}

void gp_words_free(struct gp_words **list)
{
    while (*list) {
        struct gp_words *w = *list;
        *list = w->next;
        for (int i = 0; i < w->founds; i++)
            gp_free(w->found[i]);
        gp_free(w->text);
        gp_free(w);
    }
}

gp_status gp_words_file(struct gp_use *u, struct gp_words *w)
{
    const struct gp_option *const o = u->option;
    const char *const value = u->value;
    const char *const path = value ? path_in(o, value) : NULL;
    const char *const slash = strrchr(w->path, '/');
    const size_t folder = slash ? (size_t) (slash - w->path) + 1 : 0;
    struct gp_pattern pattern;
    char *whole;
    if (!path || *path == '/')
        return GP_OK;
    // a value that is all path may be another word: of a model, a preset, a lens
    if (path == value &&
        (o->at == offsetof(struct gp_settings, kernel.words)
             ? !gp_kernel_is_file(value) || !strpbrk(value, "./-")
             : strcmp(o->arg, "FILE") != 0 &&
                   (!strpbrk(value, "./") ||
                    strncmp(value, "preset:", 7) == 0)))
        return GP_OK;
    const size_t head = (size_t) (path - value);
    const size_t n =
        head && path[-1] == '=' ? strcspn(path, ",") : strlen(path);
    const size_t room = folder + strlen(value) + 1;
    const gp_status st = gp_alloc(u->log, "settings", 1, room, &whole);
    if (st)
        return st;
    w->found[w->founds++] = whole;
    snprintf(whole, room, "%.*s", (int) n, path); // first by itself
    const bool here = access(whole, F_OK) == 0;
    snprintf(whole, room, "%.*s%.*s", (int) folder, w->path, (int) n, path);
    if (access(whole, F_OK) == 0) {
        snprintf(whole, room, "%.*s%.*s%s", (int) head, value, (int) folder,
                 w->path, path);
        u->value = whole;
        return GP_OK;
    }
    return here || strstr(o->arg, "CH") ||
                   gp_pattern_find(NULL, path, &pattern) || pattern.len ||
                   pattern.views
               ? GP_OK
               : gp_fail(u->log, GP_ERR_IO,
                         "--%s: no file %.*s (looked for in "
                         "%.*s%sthe current folder); put it there",
                         o->name, (int) n, path, (int) folder, w->path,
                         folder ? " and in " : "");
}
