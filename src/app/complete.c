/* Prints shell completions from the option table. */
#include "app/options.h"

#include "glare/model/model.h"

#include <stdbool.h>
#include <string.h>

/* True when the option's value is a file. */
static bool takes_file(const struct gp_option *o)
{
    return o->arg && (strstr(o->arg, "FILE") || strstr(o->arg, "CONFIG"));
}

static bool is_shown(const struct gp_option *o, unsigned commands)
{
    return !o->hidden && (o->commands & commands);
}

static const char *command_name(const struct gp_command_row *c)
{
    return *c->word ? c->word : "main";
}

/* Prints a text for single quotes: ' becomes '\'', and each of `escaped` gets a
 * backslash. */
static void print_quoted(FILE *f, const char *text, const char *escaped)
{
    for (; *text; text++) {
        if (*text == '\'')
            fputs("'\\'", f);
        else if (strchr(escaped, *text))
            putc('\\', f);
        putc(*text, f);
    }
}

/* Prints the topics of help but the options, which shells complete already. */
static void print_topics(FILE *f)
{
    char name[GP_TOPIC_BYTES];
    const char *word;
    for (int i = 0; (word = gp_help_topic_at(i, name)); i++)
        fprintf(f, "%s ", word);
}

/* Prints the values of an option, separated by blanks. */
static void print_values(FILE *f, const struct gp_option *o,
                         const char *escaped)
{
    const char *name, *text;
    if (o->optional) // --help
        print_topics(f);
    for (int i = 0; !o->optional && (name = gp_option_value(o, i, &text));
         i++) {
        if (i)
            putc(' ', f);
        print_quoted(f, name, escaped);
        if (o->kind == GP_KIND_NAMED && !strchr(escaped, '='))
            putc('=', f);
    }
}

static bool has_values(const struct gp_option *o)
{
    const char *text;
    return gp_option_value(o, 0, &text) != NULL;
}

// -- kernels -----------------------------------------------------------------

/* True when the option's value may be MODEL:key=value. */
static bool takes_model(const struct gp_option *o)
{
    return o->list == gp_kernel_word || strcmp(o->name, "check") == 0;
}

/* Prints the shell's patterns of words that a model's keys may end: the model's
 * own and those of its presets, between quotes where `quote` is one. */
static void print_patterns(FILE *f, const char *model, const char *quote,
                           const char *between)
{
    fprintf(f, "%s%s:*%s", quote, model, quote);
    for (const struct gp_model_preset *p = gp_model_presets; p->name; p++) {
        const size_t n = strcspn(p->recipe, ":");
        if (strlen(model) == n && strncmp(p->recipe, model, n) == 0)
            fprintf(f, "%s%sbuiltin:%s:*%s", between, quote, p->name, quote);
    }
}

/* Prints "key=", or "key=word" for each of its words. */
static void print_keys(FILE *f, const struct gp_model *model, char between)
{
    for (const struct gp_model_key *k = gp_model_keys(model); k->name; k++) {
        if (k != gp_model_keys(model))
            putc(between, f);
        if (!k->words)
            fprintf(f, "%s=", k->name);
        for (int i = 0; k->words && k->words[i]; i++) {
            if (i)
                putc(between, f);
            fprintf(f, "%s=%s", k->name, k->words[i]);
        }
    }
}

static void print_kernel_words(FILE *f)
{
    const char *word, *text;
    for (int i = 0; (word = gp_kernel_word(i, &text)); i++)
        fprintf(f, "%s%s", i ? " " : "", word);
}

static void print_commands(FILE *f, const char *between)
{
    for (const struct gp_command_row *c = gp_commands + 1; c->word; c++)
        fprintf(f, "%s%s", c > gp_commands + 1 ? between : "", c->word);
}

// -- bash --------------------------------------------------------------------

/* The fixed start and end of the function. Readline splits words at = and :, so
 * they are joined first, and the text before the last such sign is removed from
 * the completions. */
static const char bash_head[] =
    "# bash completion of glarepp; made by: glarepp help --completion bash\n"
    "_glarepp()\n"
    "{\n"
    "    local n=$COMP_CWORD word=${COMP_WORDS[COMP_CWORD]} option= kind=\n"
    "    local command=main value words= lead= i\n"
    "    while ((n > 1)) && [[ $word == [=:]* ||\n"
    "                          ${COMP_WORDS[n - 1]} == [=:] ]]; do\n"
    "        n=$((n - 1)) word=${COMP_WORDS[n]}$word\n"
    "    done\n"
    "    value=$word\n";

static const char bash_tail[] =
    "    COMPREPLY=()\n"
    "    while IFS= read -r i; do\n"
    "        COMPREPLY+=(\"$i\")\n"
    "    done < <([[ -z $words ]] || compgen -W \"$words\" -- \"$value\"\n"
    "             [[ $kind != file ]] || compgen -f -- \"$value\")\n"
    "    [[ $kind != file ]] || compopt -o filenames 2>/dev/null\n"
    "    [[ ${COMPREPLY[*]} != *= ]] || compopt -o nospace 2>/dev/null\n"
    "    value=${value%\"${value##*[=:]}\"}\n"
    "    for i in \"${!COMPREPLY[@]}\"; do\n"
    "        COMPREPLY[i]=$lead${COMPREPLY[i]#\"$value\"}\n"
    "    done\n"
    "}\n"
    "complete -F _glarepp glarepp\n";

/* The keys of a model, after what is written of it already. */
static void bash_models(FILE *f)
{
    fprintf(f, "        case $value in\n");
    for (int i = 0; gp_models[i]; i++) {
        fprintf(f, "        ");
        print_patterns(f, gp_model_name(gp_models[i]), "", " | ");
        fprintf(f, ") kind=keys words='");
        print_keys(f, gp_models[i], ' ');
        fprintf(f, "' ;;\n");
    }
    fprintf(f, "        esac\n"
               "        if [[ $kind == keys ]]; then\n"
               "            lead=${value%%\"${value##*[:,]}\"}\n"
               "            value=${value##*[:,]}\n"
               "            lead=${lead##*[=:]}\n"
               "            [[ $value != *=* ]] || lead=\n"
               "        fi\n");
}

static void print_bash(FILE *f)
{
    fprintf(f, "%s    case ${COMP_WORDS[1]} in\n    ", bash_head);
    print_commands(f, " | ");
    fprintf(f, ") ((n < 2)) || command=${COMP_WORDS[1]} ;;\n    esac\n"
               "    if [[ $word == --*=* ]]; then\n"
               "        option=${word%%%%=*} value=${word#*=}\n"
               "    elif ((n > 1)); then\n"
               "        option=${COMP_WORDS[n - 1]}\n"
               "    fi\n"
               "    case $option in\n");
    for (const struct gp_option *o = gp_options; o->name; o++) {
        if (!is_shown(o, ~0u) || !o->arg)
            continue;
        fprintf(f, "    --%s", o->name);
        if (o->letter)
            fprintf(f, " | -%c", o->letter);
        fprintf(f, ")\n        words='");
        if (takes_model(o))
            print_kernel_words(f);
        else
            print_values(f, o, "");
        fprintf(f, "' kind=%s\n", takes_file(o) ? "file" : "value");
        if (takes_model(o))
            bash_models(f);
        if (o->kind == GP_KIND_NAMED)
            fprintf(f, "        if [[ $value == *=* ]]; then\n"
                       "            value=${value#*=} words=\n"
                       "        else\n"
                       "            kind=value\n"
                       "        fi\n");
        fprintf(f, "        ;;\n");
    }
    fprintf(f, "    esac\n"
               "    case $kind:$command:$word in\n");
    for (const struct gp_command_row *c = gp_commands; c->word; c++) {
        fprintf(f, "    :%s:-*) kind=word words='", command_name(c));
        for (const struct gp_option *o = gp_options; o->name; o++) {
            if (is_shown(o, c->bit))
                fprintf(f, "--%s ", o->name);
        }
        fprintf(f, "' ;;\n");
    }
    fprintf(f, "    :help:*) kind=word words='");
    print_topics(f);
    fprintf(f, "' ;;\n    :*)\n        kind=file\n"
               "        ((n > 1)) || words='");
    print_commands(f, " ");
    fprintf(f, "' ;;\n    esac\n%s", bash_tail);
}

// -- zsh ---------------------------------------------------------------------

static void zsh_option(FILE *f, const struct gp_option *o)
{
    const bool many = o->kind == GP_KIND_TEXTS || o->kind == GP_KIND_NAMED;
    for (int letter = 0; letter < (o->letter ? 2 : 1); letter++) {
        fprintf(f, "        '%s", many ? "*" : "");
        if (!many && o->letter)
            fprintf(f, "(-%c --%s)", o->letter, o->name);
        if (letter)
            fprintf(f, "-%c%s[", o->letter, o->arg ? "+" : "");
        else
            fprintf(f, "--%s%s[", o->name, o->arg ? "=" : "");
        print_quoted(f, o->help, "[]:\\");
        putc(']', f);
        if (o->arg) {
            fputs(o->optional ? "::" : ":", f);
            print_quoted(f, o->arg, ":");
        }
        if (o->kind == GP_KIND_NAMED) {
            fprintf(f, ":{if compset -P \"*=\"; then _files; "
                       "else compadd -S = -- ");
            print_values(f, o, ":=");
            fprintf(f, "; fi}");
        } else if (takes_model(o)) {
            fprintf(f, ":_glarepp_kernel");
        } else if (o->arg && has_values(o)) {
            const bool files = o->open && !o->optional;
            fprintf(f, files ? ":{compadd -- " : ":(");
            print_values(f, o, ":");
            fprintf(f, files ? "; _files}" : ")");
        } else if (o->arg) {
            fprintf(f, takes_file(o) ? ":_files" : ": ");
        }
        fprintf(f, "'\n");
    }
}

/* The function for kernels: the keys of a model, or models and files. */
static void zsh_models(FILE *f)
{
    fprintf(f, "_glarepp_kernel()\n{\n    local -a keys\n"
               "    case $PREFIX in\n");
    for (int i = 0; gp_models[i]; i++) {
        fprintf(f, "    (");
        print_patterns(f, gp_model_name(gp_models[i]), "", "|");
        fprintf(f, ") keys=(");
        print_keys(f, gp_models[i], ' ');
        fprintf(f, ") ;;\n");
    }
    fprintf(f, "    (*) compadd -- ");
    print_kernel_words(f);
    fprintf(f, "\n        _files\n        return ;;\n    esac\n"
               "    compset -P '*[:,]'\n    compadd -S '' -- $keys\n}\n");
}

static void print_zsh(FILE *f)
{
    fprintf(f, "#compdef glarepp\n"
               "# zsh completion of glarepp; made by: "
               "glarepp help --completion zsh\n");
    zsh_models(f);
    fprintf(f, "_glarepp()\n{\n    local command=main\n"
               "    local -a options\n"
               "    case $words[2] in\n    ");
    print_commands(f, " | ");
    fprintf(f, ")\n        if (( CURRENT > 2 )); then\n"
               "            command=$words[2]\n"
               "            shift words\n"
               "            (( CURRENT-- ))\n"
               "        fi ;;\n    esac\n"
               "    (( CURRENT > 2 )) || [[ $command != main ]] ||\n"
               "        compadd -- ");
    print_commands(f, " ");
    fprintf(f, "\n    case $command in\n");
    for (const struct gp_command_row *c = gp_commands; c->word; c++) {
        fprintf(f, "    %s) options=(\n", command_name(c));
        for (const struct gp_option *o = gp_options; o->name; o++) {
            if (is_shown(o, c->bit))
                zsh_option(f, o);
        }
        if (c->bit == GP_COMMAND_HELP) {
            fprintf(f, "        ':topic:(");
            print_topics(f);
            fprintf(f, ")'\n");
        } else {
            fprintf(f, "        '*:input:_files'\n");
        }
        fprintf(f, "    ) ;;\n");
    }
    fprintf(f, "    esac\n    _arguments -s -S $options\n}\n"
               "_glarepp \"$@\"\n");
}

// -- fish --------------------------------------------------------------------

/* The function for kernels: the keys of a model after what is written of it, or
 * models. */
static void fish_models(FILE *f)
{
    fprintf(f, "function __glarepp_kernel\n"
               "    set -l word (commandline -ct | "
               "string replace -r '^(--[a-z]+=|-k)' '')\n"
               "    set -l lead (string replace -r '[^:,]*$' '' -- $word)\n"
               "    switch $word\n");
    for (int i = 0; gp_models[i]; i++) {
        fprintf(f, "        case ");
        print_patterns(f, gp_model_name(gp_models[i]), "'", " ");
        fprintf(f, "\n            printf '%%s\\n' $lead{");
        print_keys(f, gp_models[i], ',');
        fprintf(f, "}\n");
    }
    fprintf(f, "        case '*' # or a file\n            printf '%%s\\n' ");
    print_kernel_words(f);
    fprintf(f, "\n            __fish_complete_path $word\n    end\nend\n");
}

static void print_fish(FILE *f)
{
    fprintf(f, "# fish completion of glarepp; made by: "
               "glarepp help --completion fish\n"
               "function __glarepp_in\n"
               "    set -l words (commandline -opc)\n"
               "    set -l command main\n"
               "    if set -q words[2]; and contains -- $words[2] ");
    print_commands(f, " ");
    fprintf(f, "\n        set command $words[2]\n    end\n"
               "    contains -- $command $argv\nend\n"
               "function __glarepp_first\n"
               "    test (count (commandline -opc)) -eq 1\nend\n"
               "complete -c glarepp -n __glarepp_first -a '");
    print_commands(f, " ");
    fprintf(f, "'\n");
    fish_models(f);
    fprintf(f, "complete -c glarepp -n '__glarepp_in help' -f -a '");
    print_topics(f);
    fprintf(f, "'\n");
    for (const struct gp_option *o = gp_options; o->name; o++) {
        if (!is_shown(o, ~0u))
            continue;
        fprintf(f, "complete -c glarepp -n '__glarepp_in");
        for (const struct gp_command_row *c = gp_commands; c->word; c++) {
            if (o->commands & c->bit)
                fprintf(f, " %s", command_name(c));
        }
        fprintf(f, "' -l %s", o->name);
        if (o->letter)
            fprintf(f, " -s %c", o->letter);
        if (o->arg)
            fprintf(f, takes_model(o) ? " -r -f" : takes_file(o) ? " -r -F"
                                                                 : " -x");
        if (takes_model(o)) {
            fprintf(f, " -a '(__glarepp_kernel)'");
        } else if (has_values(o)) {
            fprintf(f, " -a '");
            print_values(f, o, "");
            fprintf(f, "'");
        }
        fprintf(f, " -d '");
        // (inside single quotes fish reads \', unlike bash and zsh)
        for (const char *c = o->help; *c; c++)
            fprintf(f, *c == '\'' || *c == '\\' ? "\\%c" : "%c", *c);
        fprintf(f, "'\n");
    }
}

void gp_complete(FILE *f, enum gp_shell shell)
{
    switch (shell) {
    case GP_SHELL_BASH:
        print_bash(f);
        break;
    case GP_SHELL_ZSH:
        print_zsh(f);
        break;
    case GP_SHELL_FISH:
        print_fish(f);
        break;
    case GP_SHELL_NONE:
        break;
    }
}
