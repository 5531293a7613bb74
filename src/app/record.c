/* Records the settings that made a picture: glarepp:command of the files, and
 * the settings of the report. */
#include "app/options.h"

#include "core/json.h"
#include "glare/model/model.h"

#include <stdlib.h>
#include <string.h>

/* True when pixels of an output may depend on the option. */
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

/* Prints the first n bytes of `head`, then `word`, quoted for a shell. */
static void print_word(FILE *f, const char *head, size_t n, const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyz"
        "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=:,./@%";
    const bool bare = n + strlen(word) > 0 && strspn(head, plain) >= n &&
                      !word[strspn(word, plain)];
    fputs(bare ? " " : " '", f);
    for (size_t i = 0; i < n || *word; i++) {
        const char c = i < n ? head[i] : *word++;
        if (c == '\'')
            fputs("'\\''", f);
        else // control characters would break listings of the file
            fputc((unsigned char) c < 0x20 || c == 0x7f ? '?' : c, f);
    }
    if (!bare)
        fputc('\'', f);
}

/* Prints an option's value without folders of this machine. */
static void print_value(FILE *f, const struct gp_option *o, const char *value)
{
    const bool config = strcmp(o->arg, "CONFIG") == 0;
    const char *const is = strchr(value, '=');
    const char *const file = strstr(value, "file="); // of a kernel's recipe
    if (config && (!*value || strcmp(value, "env") == 0) && getenv("OCIO"))
        value = getenv("OCIO");
    if (file && o->kind == GP_KIND_TEXTS && gp_recipe_is(value))
        print_word(f, value, (size_t) (file + 5 - value), base_name(file + 5));
    else if ((config || strstr(o->arg, "FILE")) && !strstr(value, "://"))
        print_word(f, "", 0, base_name(value));
    else if (is && is[1] == '/') // NAME=/some/folder/file
        print_word(f, value, (size_t) (is + 1 - value), base_name(value));
    else
        print_word(f, "", 0, value);
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
    for (int i = 0; i + 1 < s->options.n; i += 2) {
        const char *const name = s->options.at[i];
        const char *const value = s->options.at[i + 1];
        const struct gp_option *const o = gp_option_find(name, strlen(name));
        if (!makes_pixels(o))
            continue;
        fprintf(f, " --%s", name);
        if (value)
            print_value(f, o, value);
    }
    for (int i = 0; i < inputs; i++)
        print_word(f, "", 0, base_name(input[i]));
    const bool full = ferror(f);
    // (glibc's fclose() succeeds even when the last block cannot be allocated)
    const bool whole = fclose(f) == 0 && !full && text;
    json_t *const clean = whole ? gp_json_name(text) : NULL;
    free(text);
    *out = clean ? strdup(json_string_value(clean)) : NULL;
    json_decref(clean);
    return *out ? GP_OK : gp_no_memory_bare(log, "command line");
}

/* Returns the value of an option as JSON; NULL when it is unset. */
static json_t *value_of(const struct gp_settings *s, const struct gp_option *o)
{
    const void *const at = (const char *) s + o->at;
    const struct gp_numbers *const list = at;
    const struct gp_texts *const texts = at;
    const double *const pair = at;
    const char *const *const word = at;
    json_t *v = NULL;
    char text[32];
    switch (o->kind) {
    case GP_KIND_FLAG:
        return json_boolean(*(const bool *) at);
    case GP_KIND_FLOAT: // 0.001 as written, not its nearest float
        snprintf(text, sizeof text, "%.7g", (double) *(const float *) at);
        return json_real(strtod(text, NULL)); // NULL when it is not finite
    case GP_KIND_THRESHOLD: // "99.9%" and "+3ev" too
        snprintf(text, sizeof text, s->sensor.unit == GP_THRESHOLD_EV
                     ? "%+.7gev" : s->sensor.unit == GP_THRESHOLD_PERCENT
                     ? "%.7g%%" : "%.7g", (double) s->sensor.threshold);
        return s->sensor.unit == GP_THRESHOLD_LUMINANCE
                   ? json_real(strtod(text, NULL)) : json_string(text);
    case GP_KIND_INT:
        return json_integer(*(const int *) at);
    case GP_KIND_COUNT:
        return json_integer(*(const long long *) at);
    case GP_KIND_PAIR:
        return gp_option_given(s, o->name)
                   ? json_pack("[ff]", pair[0], pair[1]) : NULL;
    case GP_KIND_NUMBERS:
        v = list->n ? json_array() : NULL;
        for (int i = 0; i < list->n; i++)
            json_array_append_new(v, json_real(list->v[i]));
        return v;
    case GP_KIND_CHOICE:
        for (const struct gp_option_choice *c = o->choices; c->name; c++) {
            if (c->value == *(const int *) at)
                return c->text || strspn(c->name, "0123456789") == 0
                           ? json_string(c->name) : json_integer(c->value);
        }
        return NULL;
    case GP_KIND_TEXT:
        return *word ? gp_json_name(*word) : NULL;
    case GP_KIND_TEXTS:
        v = texts->n ? json_array() : NULL;
        for (int i = 0; i < texts->n; i++)
            json_array_append_new(v, gp_json_name(texts->at[i]));
        return v;
    case GP_KIND_SET:
        return *(const int *) at == o->set ? json_true() : NULL;
    case GP_KIND_NAMED:
        break;
    }
    return NULL;
}

json_t *gp_settings_json(const struct gp_settings *s)
{
    const unsigned unmet = gp_needs_unmet(s);
    json_t *const all = json_object();
    for (const struct gp_option *o = gp_options; o->name; o++) {
        char key[32];
        if (!(o->commands & s->command) || !makes_pixels(o) ||
            (o->needs & unmet) ||
            (o->group == GP_GROUP_SUN && !gp_option_given(s, o->name) &&
             !gp_suns_wanted(&s->sun)))
            continue;
        snprintf(key, sizeof key, "%s", o->name);
        for (char *c = key; *c; c++)
            *c = *c == '-' ? '_' : *c;
        json_t *const v = value_of(s, o);
        if (v)
            json_object_set_new(all, key, v);
    }
    return all;
}
