// SPDX-License-Identifier: Apache-2.0
#include "cli/options.h"

#include "cli/words.h"
#include "core/memory.h"

#include <string.h>
#include <unistd.h>

// -- settings ----------------------------------------------------------------

const struct gp_settings gp_defaults = {
    .command = GP_COMMAND_MAIN,
    .input.read = GP_READ_DEFAULTS,
    .output.write = GP_WRITE_DEFAULTS,
    .light =
        {
            .style = GP_STYLE_USUAL,
            .sense = GLAREPP_SENSE_PARAMS,
            .layer = GLAREPP_LAYER_PARAMS,
        },
    .kernel.p = GLAREPP_KERNEL_PARAMS,
    .sun = {.light = GLAREPP_LIGHT, .p = GLAREPP_LIGHT_PARAMS},
    .lens = GLAREPP_LENS_PARAMS,
    .scene = GLAREPP_SCENE_PARAMS,
    .plan = GLAREPP_PLAN_PARAMS,
    .tone.map = GLAREPP_TONE_PARAMS,
    .bench = GP_BENCH_DEFAULTS,
    .sets = GLAREPP_SETS_PARAMS,
    .page = {.megabytes = 3.0},
    .compare = {.limits = GLAREPP_COMPARE_PARAMS, .scale = 1.0f},
    .run.level = GP_LEVEL_WARN,
};

void gp_settings_free(struct gp_settings *s)
{
    while (s->keyeds)
        gp_keys_drop(s, s->keyed[0].option);
    GP_FREE(s->keyed);
    gp_words_free(&s->words.read);
    GP_FREE(s->words.all);
    for (int i = 0; s->input.group && i < s->input.light_groups.n; i++)
        gp_free(s->input.group[i].name);
    GP_FREE(s->input.group);
}

// -- values ------------------------------------------------------------------

#define LETTERS "abcdefghijklmnopqrstuvwxyz"

/* Fails with the nearest value, else with all; with `file`, for a word that may
 * be a file's name, only when one is near, as builtin:star is to "star". */
static gp_status unknown_value(const struct gp_use *u, bool file)
{
    const char *text, *name;
    char line[512] = "", nearest[64] = "";
    size_t at = 0;
    const size_t length = strlen(u->value);
    int most = length < 8 ? 1 : 2; // edits: each match must beat the last
    for (int i = 0; at < sizeof line &&
                    (name = gp_option_value(u->option, i, &text)); i++) {
        struct gp_nearest near = gp_nearest_to(u->value, length, most);
        const char *const colon = file ? strchr(name, ':') : NULL;
        at += (size_t) snprintf(line + at, sizeof line - at, "%s%s",
                                i ? ", " : "", name);
        gp_nearest_try(&near, colon ? colon + 1 : name);
        if (near.name) {
            most = near.most - 1;
            snprintf(nearest, sizeof nearest, "%s", name);
        }
    }
    if (nearest[0])
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: no such %s (found \"%s\"); did you mean %s?%s%s",
                       u->option->name,
                       file && strchr(nearest, ':') ? "file" : "value",
                       u->value, nearest, file ? "" : " Else give one of ",
                       file ? "" : line);
    return file ? GP_OK : gp_fail(u->log, GP_ERR_USAGE,
                   "--%s: no such value (found \"%s\"); give one of %s",
                   u->option->name, u->value, line);
}

/* Sets one of the option's choices, or the file of "CHOICE=FILE". */
static gp_status set_choice(const struct gp_use *u, void *field)
{
    const bool named = u->option->kind == GP_KIND_NAMED;
    const size_t n = named ? strcspn(u->value, "=") : strlen(u->value);
    const struct gp_option_choice *c = u->option->choices;
    while (c->name &&
           (strlen(c->name) != n || strncmp(c->name, u->value, n) != 0))
        c++;
    if (!c->name)
        return unknown_value(u, false);
    if (u->option->kind == GP_KIND_EITHER)
        *(bool *) field = c->value;
    else if (!named)
        memcpy(field, &c->value, sizeof c->value);
    if (!named)
        return GP_OK;
    if (!u->value[n] || !u->value[n + 1])
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: no file (found \"%s\"); write %s=FILE",
                       u->option->name, u->value, c->name);
    const char **const file = (const char **) field + c->value;
    if (*file)
        return gp_fail(u->log, GP_ERR_USAGE, "--%s %s: given twice (found %s "
                       "and %s); give one file", u->option->name, c->name,
                       *file, u->value + n + 1);
    *file = u->value + n + 1;
    return GP_OK;
}

/* Sets a word of argv, or appends it to a list. */
static gp_status set_text(const struct gp_use *u, void *field)
{
    const struct gp_option *const o = u->option;
    const char *text, *name;
    const char *const keys = strncmp(u->value, "builtin:", 8) == 0
                                 ? strchr(u->value + 8, ':') : u->value;
    bool known = !(o->list || o->choices) ||
                 (keys && o->at == offsetof(struct gp_settings, kernel.words) &&
                  !gp_kernel_is_file(u->value));
    for (int i = 0; !known && (name = gp_option_value(o, i, &text)); i++)
        known = strcmp(name, u->value) == 0;
    const bool file =
        !known && o->open && strncmp(u->value, "builtin:", 8) != 0;
    const bool word = *u->value && !u->value[strspn(u->value, LETTERS)];
    if (!known && !(file && (!word || access(u->value, F_OK) == 0))) {
        const gp_status st = unknown_value(u, file);
        if (st)
            return st;
    }
    if (!*u->value && !o->blank)
        return gp_fail(u->log, GP_ERR_USAGE, "--%s: needs a value (found an "
                       "empty word); give %s", o->name, o->arg);
    struct gp_texts *const list = field;
    if (o->kind == GP_KIND_TEXTS)
        list->at[list->n++] = u->value;
    else
        *(const char **) field = u->value;
    return GP_OK;
}

/* Sets the option by its kind. */
static gp_status set_value(const struct gp_use *u, struct gp_settings *s)
{
    void *const field = (char *) s + u->option->at;
    struct gp_quantity q;
    gp_status st;
    switch (u->option->kind) {
    case GP_KIND_FLAG:
        *(bool *) field = !u->option->off;
        return GP_OK;
    case GP_KIND_SET:
        memcpy(field, &u->option->set, sizeof u->option->set);
        return GP_OK;
    case GP_KIND_CHOICE:
    case GP_KIND_EITHER:
    case GP_KIND_NAMED:
        return set_choice(u, field);
    case GP_KIND_TEXT:
    case GP_KIND_TEXTS:
        return set_text(u, field);
    default: // numbers
        gp_keys_drop(s, u->option);
        if (*u->value == '@' || strchr(u->value, ':'))
            return gp_keys_read(u, s);
        st = gp_quantity_read(u, &q);
        if (!st)
            gp_quantity_set(u->option, &q, s);
        return st;
    }
}

// -- words -------------------------------------------------------------------

/* Options that are gone, and what to use. */
static const char *const gone[][2] = {
    {"completion", "make install puts completions in place"},
    {"fft-plan", "leave it out: transforms need no plan"},
    {"from",
     "make the file again by -k with its glarepp:recipe, and by --size, "
     "--fov, --rotate and --frame"},
    {"group-method", "leave it out: splat groups pixels in one way"},
    {"ndc", "leave it out, or give the camera by --camera FILE"},
    {"primitive",
     "leave it out: splat draws what the GL context draws fastest"},
    {"repeat", "use --runs"},
    {"report-append", "append by the shell: --report - >>FILE"},
    {"sun-draw", "leave it out: engines draw the glare of lights"},
};

/* Finds the option that `word` names. *value is the rest of the word
 * ("--gain=2", "-g2"), or NULL. Options of compare may have one dash, as
 * idiff's: "-fail"; "-foo" is then unknown, not -f with a value. A letter means
 * the command's own option. */
static const struct gp_option *split_word(const char *word, unsigned command,
                                          const char **value)
{
    *value = NULL;
    if (word[1] != '-') {
        const bool idiffs = command == GP_COMMAND_COMPARE && word[2] &&
                            strspn(word + 2, LETTERS);
        const struct gp_option *o =
            idiffs ? gp_option_find(word + 1, strlen(word + 1)) : NULL;
        if (idiffs)
            return o && (o->commands & command) ? o : NULL;
        *value = word[2] ? word + 2 : NULL;
        o = gp_option_letter(word[1], command);
        return o ? o : gp_option_letter(word[1], ~0u);
    }
    const char *name = word + 2;
    size_t length = strcspn(name, "=");
    if (name[length])
        *value = name + length + 1;
    return gp_option_find(name, length);
}

/* Finds the option at argv[*i] and its value, and moves *i to its last word. */
static gp_status find_use(const struct gp_log *log, int argc,
                          const char *const argv[], int *i,
                          const struct gp_settings *s, struct gp_use *out)
{
    const char *const word = argv[*i], *of_next;
    struct gp_use u = {.log = log};
    u.option = split_word(word, s->command, &u.value);
    const char *const command = gp_command_of(s->command)->word;
    if (!u.option) {
        const char *const bare = word + strspn(word, "-");
        const size_t length = strcspn(bare, "=");
        const int shown = (int) (bare - word + (ptrdiff_t) length);
        struct gp_nearest near = gp_nearest_to(bare, length, 3);
        for (size_t k = 0; k < sizeof gone / sizeof *gone; k++) {
            if (strlen(gone[k][0]) == length &&
                strncmp(gone[k][0], bare, length) == 0)
                return gp_fail(log, GP_ERR_USAGE, "--%s: no option any more; %s",
                               gone[k][0], gone[k][1]);
        }
        for (const struct gp_option *o = gp_options; o->name; o++) {
            if (o->help && (o->commands & s->command))
                gp_nearest_try(&near, o->name);
        }
        if (near.name)
            return gp_fail(log, GP_ERR_USAGE, "%.*s: unknown option; did "
                           "you mean --%s?", shown, word, near.name);
        return gp_fail(log, GP_ERR_USAGE, "%.*s: unknown option; glarepp "
                       "%s%s--help lists them", shown, word,
                       command, s->command == GP_COMMAND_MAIN ? "" : " ");
    }
    const char *const name = u.option->name, *const arg = u.option->arg;
    if (!(u.option->commands & s->command) && s->command == GP_COMMAND_MAIN)
        return gp_fail(log, GP_ERR_USAGE, "--%s: not for pictures; write "
                       "glarepp %s --%s, or leave it out", name,
                       gp_command_of(u.option->commands)->word, name);
    if (!(u.option->commands & s->command))
        return gp_fail(log, GP_ERR_USAGE, "--%s: not for glarepp %s; see "
                       "glarepp %s --help", name, command, command);
    if (!arg && u.value)
        return gp_fail(log, GP_ERR_USAGE, "%s: takes no "
                       "value (found \"%s\"); leave it out", word, u.value);
    if (arg && !u.value && arg[0] == '[') {
        const char *const next = *i + 1 < argc ? argv[*i + 1] : "";
        u.value = *next && !next[strspn(next, LETTERS)] ? argv[++*i] : "";
    } else if (arg && !u.value) {
        if (*i + 1 >= argc)
            return gp_fail(log, GP_ERR_USAGE, "%s: needs a value; write %s %s",
                           word, word, arg);
        const char *const next = argv[++*i];
        if (strncmp(next, "--", 2) == 0 &&
            split_word(next, s->command, &of_next))
            return gp_fail(log, GP_ERR_USAGE, "%s: needs a value (found the "
                           "option %s); write %s %s", word, next, word, arg);
        u.value = next;
    }
    *out = u;
    return GP_OK;
}

static gp_status take_use(const struct gp_use *u, struct gp_settings *s)
{
    const char *const name = u->option->name;
    const void *const field = (const char *) s + u->option->at;
    if (u->option->once && gp_option_given(s, name))
        return gp_fail(u->log, GP_ERR_USAGE,
                       "--%s: given twice (found %s and %s); give one file",
                       name, *(const char *const *) field, u->value);
    s->words.options.at[s->words.options.n++] = name;
    s->words.options.at[s->words.options.n++] = u->value;
    return set_value(u, s);
}

/* Sets the options of a file of settings whose fields nothing sets yet. */
static gp_status read_settings(const struct gp_log *log, const char *path,
                               struct gp_settings *s)
{
    struct gp_words *w;
    const int before = s->words.options.n;
    gp_status st = gp_words_read(log, path, &w);
    if (st)
        return st;
    w->next = s->words.read;
    s->words.read = w;
    for (int i = 0; i < w->n && !st; i++) {
        struct gp_place place;
        const struct gp_log there = gp_place_log(&place, log, path, w->line[i]);
        const char *const word = w->word[i];
        struct gp_use u;
        if (word[0] != '-' || !word[1])
            return gp_fail(&there, GP_ERR_DATA,
                           "%s: not an option; write "
                           "--NAME VALUE, and inputs on the command line",
                           word);
        st = find_use(&there, w->n, w->word, &i, s, &u);
        if (!st && !gp_option_makes_pixels(u.option))
            st = gp_fail(&there, GP_ERR_USAGE,
                         "--%s: not a setting, as no "
                         "pixel depends on it; give it on the command line",
                         u.option->name);
        bool set = false;
        for (int k = 0; k < before && !st; k += 2) {
            const char *const name = s->words.options.at[k];
            set |= gp_option_find(name, strlen(name))->at == u.option->at;
        }
        if (st || set)
            continue;
        st = gp_words_file(&u, w);
        st = st ? st : take_use(&u, s);
    }
    return st == GP_ERR_USAGE ? GP_ERR_DATA
                              : st; // it is the file that is wrong
}

/* Sets the options of the style that the command has and that are not given. */
static gp_status apply_style(const struct gp_log *log, struct gp_settings *s)
{
    const char *const *word = gp_style_of(s->light.style)->word;
    gp_status st = GP_OK;
    for (; *word && !st; word += 2) {
        const struct gp_use u = {log, gp_option_find(word[0], strlen(word[0])),
                                 word[1]};
        if ((u.option->commands & s->command) && !gp_option_given(s, word[0]))
            st = set_value(&u, s);
    }
    return st;
}

gp_status gp_options_more(const struct gp_log *log, const struct gp_settings *s,
                          const char *name, const char *value,
                          struct gp_settings *out)
{
    const struct gp_use u = {log, gp_option_find(name, strlen(name)), value};
    gp_status st;
    *out = *s;
    out->command = GP_COMMAND_MAIN;
    st = take_use(&u, out);
    st = st ? st : apply_style(log, out);
    return st ? st : gp_settings_check(log, out);
}

gp_status gp_options_parse(const struct gp_log *log, int argc,
                           char *const argv[], struct gp_settings *out)
{
    gp_status st = GP_OK;
    bool options = true; // until "--"
    int i = 1;
    *out = gp_defaults;
    struct gp_texts *const lists[] = {
        &out->input.files,        &out->output.pictures,
        &out->output.hdr,         &out->output.layer,
        &out->output.parts,       &out->words.settings,
        &out->input.light_groups, &out->input.group_kernels,
        &out->kernel.words,       &out->sun.relight,
        &out->tone.context,       &out->words.options,
    };
    enum { LISTS = sizeof lists / sizeof *lists };
    size_t room = 2 * (size_t) argc + GP_STYLE_WORDS;
    for (int k = 1; k < argc; k++) // (a value may look like it)
        room += strncmp(argv[k], "--settings", 10) == 0 ? 2 * GP_WORDS : 0;
    st = gp_alloc(log, "command line", LISTS * room, sizeof *out->words.all,
                  &out->words.all);
    for (size_t k = 0; k < LISTS && !st; k++)
        lists[k]->at = out->words.all + k * room;
    if (st)
        return st;
    const char *const first = argc > 1 ? argv[1] : "";
    struct gp_nearest near = gp_nearest_to(first, strlen(first), 2);
    for (const struct gp_command_row *c = gp_commands + 1; c->word; c++) {
        gp_nearest_try(&near, c->word);
        if (strcmp(c->word, first) == 0) {
            out->command = c->bit;
            i++;
        }
    }
    // a misspelt command must not be read as an input
    if (i == 1 && near.name && !first[strspn(first, LETTERS)] &&
        access(first, F_OK) != 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: no such command or file; did you mean glarepp %s?",
                       first, near.name);
    for (; i < argc && !st; i++) {
        struct gp_use u;
        const char *const word = argv[i], *value;
        const struct gp_option *const o =
            word[0] == '-' && word[1] ? split_word(word, out->command, &value)
                                     : NULL;
        // `glarepp help --gain` is about an option
        const bool topic = out->command == GP_COMMAND_HELP &&
                           !(o && (o->commands & GP_COMMAND_HELP));
        if (options && strcmp(word, "--") == 0)
            options = false;
        else if (options && word[0] == '-' && word[1] && !topic) {
            st = find_use(log, argc, (const char *const *) argv, &i, out, &u);
            st = st ? st : take_use(&u, out);
        } else
            out->input.files.at[out->input.files.n++] = word;
    }
    for (int k = out->words.settings.n - 1; k >= 0 && !st; k--)
        st = read_settings(log, out->words.settings.at[k], out);
    // each option is two words
    out->words.list_flares = out->command == GP_COMMAND_MAIN &&
                             out->input.files.n == 0 &&
                             out->words.options.n == 2 && out->sun.p.flare &&
                             strcmp(out->sun.p.flare, "preset:list") == 0;
    if (st || out->words.help || out->words.help_table || out->words.version ||
        out->words.list_flares)
        return st;
    if (out->command != GP_COMMAND_STYLES)
        st = apply_style(log, out);
    return st ? st : gp_settings_check(log, out);
}
