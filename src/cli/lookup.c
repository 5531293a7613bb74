/* The commands; finds them, options by name or letter, and options' values. */
#include "cli/options.h"

#include <float.h>
#include <limits.h>
#include <string.h>

// -- commands ----------------------------------------------------------------

const struct gp_command_row gp_commands[] = {
    {"", GP_COMMAND_MAIN, 1, INT_MAX,
     "Adds the glare of bright light to HDR frames: halos, rays and streaks.\n\n"
     "  glarepp [options] -o OUTPUT INPUT...\n\n"
     "INPUT and OUTPUT are files, - for stdin and stdout (EXR), or patterns:\n"
     "shot.####.exr, shot.@.exr, shot.%04d.exr; %V stands for a stereo view.\n",
     {{"glarepp -o out.png frame.exr", "as a camera sees it"},
      {"glarepp --style anamorphic -o out.png frame.exr", "blue streaks"},
      {"glarepp --hdr lit.####.exr shot.####.exr", "a sequence, linear"}}},
    {"bench", GP_COMMAND_BENCH, 1, 1,
     "Measures speed against error on a frame, for every technique.\n\n"
     "  glarepp bench [options] INPUT\n"
     "  glarepp bench [options] --paper\n\n"
     "INPUT is a file, or - for stdin (EXR).\n",
     {{"glarepp bench frame.exr", "a table"},
      {"glarepp bench --csv t.csv --plot t.svg frame.exr", "and a plot"}}},
    {"compare", GP_COMMAND_COMPARE, 2, 2,
     "Measures the error between two images or two sequences.\n\n"
     "  glarepp compare [options] A B\n\n"
     "A, the reference, and B are files or patterns; one may be - for stdin.\n"
     "idiff's command lines work unchanged, with one dash or two: -fail "
     "0.004.\n"
     "Exit status, as idiff's: 0 PASS, 1 WARNING, 2 FAILURE, 3 cannot be "
     "compared,\n4 a file cannot be read or written; 64 a wrong command "
     "line.\n",
     {{"glarepp compare a.exr b.exr", "the error"},
      {"glarepp compare --fail 0.004 --heatmap d.png a.exr b.exr",
       "and where it is"}}},
    {"kernel", GP_COMMAND_KERNEL, 0, 1,
     "Makes a glare kernel, or checks one.\n\n"
     "  glarepp kernel [options] -o FILE\n"
     "  glarepp kernel [options] --check FILE|MODEL [FRAME]\n"
     "  glarepp kernel --list\n\n"
     "-k names the model; FILE is an EXR, with the recipe in its attributes.\n"
     "--check looks at what FRAME would show; exit status 1 for a fault.\n",
     {{"glarepp kernel --list", "models, keys and presets"},
      {"glarepp kernel -k aperture:blades=6 -o k.exr", "rays of six blades"}}},
    {"lens", GP_COMMAND_LENS, 0, 0,
     "Lists the lenses for --lens, checks one, or draws it.\n\n"
     "  glarepp lens [--list]\n"
     "  glarepp lens --check FILE|NAME [--draw FILE]\n\n"
     "FILE is a prescription in JSON, NAME one of the list. Exit status 1 where "
     "the\nsurfaces do not make what the file claims.\n",
     {{"glarepp lens", "those that are installed"},
      {"glarepp lens --check heliar --draw heliar.svg", "one and its rays"}}},
    {"sets", GP_COMMAND_SETS, 1, 1,
     "Times the drawing of what a scene's camera and lights reach.\n\n"
     "  glarepp sets [options] SCENE\n\n"
     "SCENE is a glTF file with a camera: .glb or .gltf. Exit status 1 where "
     "two ways\nto draw it do not make the same picture.\n",
     {{"glarepp sets scene.glb", "a table"},
      {"glarepp sets --size 1280x720 --debug sets=map.png scene.glb",
       "and a map"}}},
    {"styles", GP_COMMAND_STYLES, 0, 1,
     "Lists the styles, or draws a frame in each of them.\n\n"
     "  glarepp styles\n"
     "  glarepp styles [options] -o SHEET FRAME\n\n"
     "SHEET is a picture, with a tile for each style. --report has a line for "
     "each,\nwith its command.\n",
     {{"glarepp styles", "their names"},
      {"glarepp styles -o sheet.png frame.exr", "a frame in all of them"}}},
    {"help", GP_COMMAND_HELP, 0, 1, NULL, {{0}}},
    {0},
};

const struct gp_command_row *gp_command_of(unsigned commands)
{
    const struct gp_command_row *c = gp_commands;
    while (!(c->bit & commands))
        c++;
    return c;
}

// -- rows of the table -------------------------------------------------------

const char *gp_option_value(const struct gp_option *o, int i, const char **text)
{
    *text = NULL;
    if (o->choices) {
        *text = o->choices[i].text;
        return o->choices[i].name;
    }
    return o->list ? o->list(i, text) : NULL;
}

struct gp_range_text gp_option_range(const struct gp_option *o)
{
    struct gp_range_text r;
    bool open_end = o->hi >= (double) FLT_MAX;
    bool over_zero = o->lo == (double) FLT_MIN; // stands for > 0
    if (o->lo <= -(double) FLT_MAX && open_end)
        snprintf(r.text, sizeof r.text, "any number");
    else if (over_zero && open_end)
        snprintf(r.text, sizeof r.text, "more than 0");
    else if (over_zero)
        snprintf(r.text, sizeof r.text, "more than 0, up to %g", o->hi);
    else if (open_end)
        snprintf(r.text, sizeof r.text, "%g or more", o->lo);
    else
        snprintf(r.text, sizeof r.text, "%.15g to %.15g", o->lo, o->hi);
    return r;
}

const struct gp_option *gp_option_find(const char *name, size_t length)
{
    for (const struct gp_option *o = gp_options; o->name; o++) {
        if (strlen(o->name) == length && strncmp(o->name, name, length) == 0)
            return o;
    }
    return NULL;
}

bool gp_option_given(const struct gp_settings *s, const char *name)
{
    const struct gp_option *const o = gp_option_find(name, strlen(name));
    const size_t i = o ? (size_t) (o - gp_options) : 0;
    return o && (s->words.given[i / 64] >> i % 64 & 1);
}

const struct gp_option_choice *gp_option_chosen(const struct gp_option *o,
                                                const void *field)
{
    const int v = o->kind == GP_KIND_EITHER ? *(const bool *) field
                                            : *(const int *) field;
    const struct gp_option_choice *c = o->choices;
    while (c->name && c->value != v)
        c++;
    return c->name ? c : NULL;
}

const struct gp_option *gp_option_letter(char letter, unsigned commands)
{
    for (const struct gp_option *o = gp_options; o->name && letter; o++) {
        if (o->letter == letter && (o->commands & commands))
            return o;
    }
    return NULL;
}

// -- what values ask for -----------------------------------------------------

bool gp_kernel_is_file(const char *word)
{
    char path[PATH_MAX];
    return glarepp_kernel_path(word, path, sizeof path) &&
           strcmp(path, word) == 0;
}

bool gp_lights_wanted(const struct gp_settings *s)
{
    return s->sun.at.n || s->sun.dir.n || s->sun.p.cameras || s->sun.p.file ||
           s->scene.path;
}
