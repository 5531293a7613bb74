/* Settings as text, for who looks at a picture later: glarepp:command of the
 * files that are written. */
#include "app/options.h"

#include "core/json.h"

#include <stdlib.h>
#include <string.h>

/* True when a pixel of some output may depend on the option. */
static bool makes_pixels(const struct gp_option *o)
{
    return !o->aside && o->group != GP_GROUP_OUTPUT &&
           o->group != GP_GROUP_REPORT && o->group != GP_GROUP_GENERAL;
}

static const char *base_name(const char *path)
{
    const char *const slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

/* One word as a shell takes it back. */
static void put_word(FILE *f, const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyz"
        "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=:,./@%";
    if (*word && !word[strspn(word, plain)]) {
        fprintf(f, " %s", word);
        return;
    }
    fputs(" '", f);
    for (; *word; word++) {
        if (*word == '\'')
            fputs("'\\''", f);
        else // a line break would be one in the file's listing too
            fputc((unsigned char) *word < 0x20 || *word == 0x7f ? '?' : *word,
                  f);
    }
    fputc('\'', f);
}

/* An option's value without folders of this machine. */
static void put_value(FILE *f, const struct gp_option *o, const char *value)
{
    const bool config = strcmp(o->arg, "CONFIG") == 0;
    const char *const is = strchr(value, '=');
    if (config && (!*value || strcmp(value, "env") == 0) && getenv("OCIO"))
        value = getenv("OCIO");
    if ((config || strstr(o->arg, "FILE")) && !strstr(value, "://"))
        put_word(f, base_name(value));
    else if (is && is[1] == '/') { // NAME=/some/folder/file
        const size_t n = (size_t) (is + 1 - value);
        const char *const base = base_name(value);
        char *const text = malloc(n + strlen(base) + 1);
        if (text) {
            memcpy(text, value, n);
            strcpy(text + n, base);
            put_word(f, text);
        }
        free(text);
    } else
        put_word(f, value);
}

gp_status gp_command_text(const struct gp_log *log, const struct gp_settings *s,
    const char *const *input, int inputs, char **out)
{
    char *text = NULL;
    size_t size;
    enum gp_command command;
    const char *word = "";
    FILE *const f = open_memstream(&text, &size);
    *out = NULL;
    if (!f)
        return gp_no_memory_bare(log, "command line");
    for (int i = 0; (word = gp_command_at(i, &command)) != NULL; i++) {
        if (command == s->command)
            fprintf(f, "glarepp%s%s", *word ? " " : "", word);
    }
    for (int i = 0; i + 1 < s->said.n; i += 2) {
        const char *const name = s->said.at[i];
        const char *const value = s->said.at[i + 1];
        const struct gp_option *const o = gp_option_find(name, strlen(name));
        if (!makes_pixels(o))
            continue;
        fprintf(f, " --%s", name);
        if (value)
            put_value(f, o, value);
    }
    for (int i = 0; i < inputs; i++)
        put_word(f, base_name(input[i]));
    const bool full = ferror(f);
    json_t *const clean = fclose(f) == 0 && !full ? gp_json_name(text) : NULL;
    free(text);
    *out = clean ? strdup(json_string_value(clean)) : NULL;
    json_decref(clean);
    return *out ? GP_OK : gp_no_memory_bare(log, "command line");
}
