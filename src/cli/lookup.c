/* The commands; finds options by name or letter; lists that the table names:
 * its headings, and values that the library and io list. */
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

// -- lists that the table of options names -----------------------------------

const struct gp_option_heading gp_option_groups[GP_GROUPS] = {
    [GP_GROUP_OUTPUT] = {"Pictures to make (at least one)", "outputs",
        "glarepp -o out.png --hdr lit.exr --layer glare.exr frame.exr"},
    [GP_GROUP_INPUT] = {"Frames to read", "inputs",
        "glarepp -f 1-100x2 -o out.####.png shot.####.exr"},
    [GP_GROUP_LIGHT] = {"Light and kernel", "kernels",
        "glarepp -t 2 -k builtin:streak --rotate 10 -o out.png frame.exr"},
    [GP_GROUP_SUN] = {"Suns, lamps and lens flare", "lights",
        "glarepp --sun 960,200,12 --sun-color 5e4 -o out.png frame.exr"},
    [GP_GROUP_ENGINE] = {"Engines", "engines",
        "glarepp --tolerance 1e-4 --threads 2 -o out.png frame.exr"},
    [GP_GROUP_TONE] = {"Tone mapping", "tone",
        "glarepp --tonemap agx --exposure -1 -o out.png frame.exr"},
    [GP_GROUP_FILE] = {"Files", "files",
        "glarepp --type half --compression piz --hdr lit.exr frame.exr"},
    [GP_GROUP_REPORT] = {"Reports and progress", "report",
        "glarepp --verify --report - --layer glare.exr frame.exr"},
    [GP_GROUP_KERNEL] = {"Kernels of glarepp kernel", "making",
        "glarepp kernel -k cie:age=70 -k star --size 2048x858 -o k.exr"},
    [GP_GROUP_LENS] = {"Lenses of glarepp lens", "optics",
        "glarepp lens --check heliar --draw heliar.svg"},
    [GP_GROUP_SETS] = {"Scenes of glarepp sets", "visibility",
        "glarepp sets --size 1280x720 --debug sets=sets.png scene.glb"},
    [GP_GROUP_BENCH] = {"Tables and plots of glarepp bench", "measuring",
        "glarepp bench --runs 3 --csv speed.csv --plot speed.svg frame.exr"},
    [GP_GROUP_COMPARE] = {"Limits and pictures of glarepp compare", "comparing",
        "glarepp compare --fail 0.004 --heatmap diff.png a.exr b.exr"},
    [GP_GROUP_GENERAL] = {"General", "general", "glarepp help kernels"},
};

const struct gp_option_choice gp_gls[] = {
    {"auto", GLAREPP_GL_AUTO, "osmesa, or egl where OSMesa cannot be opened"},
    {"osmesa", GLAREPP_OSMESA, "Mesa's off-screen library, on the CPU"},
    {"egl", GLAREPP_EGL, "a GPU where there is one, else Mesa's surfaceless "
     "platform on the CPU"},
    {0},
};

const struct gp_option_choice gp_progresses[] = {
    {"auto", GP_PROGRESS_AUTO, "on a terminal, after one second"},
    {"always", GP_PROGRESS_ALWAYS, NULL}, {"never", GP_PROGRESS_NEVER, NULL},
    {"percent", GP_PROGRESS_PERCENT, "lines such as 42%"},
    {"openjd", GP_PROGRESS_OPENJD, "lines of Open Job Description: "
     "openjd_progress: 41.7, openjd_status: TEXT"},
    {"json", GP_PROGRESS_JSON, "an object a line: done, failed, total, "
     "percent, seconds, seconds_left, file, stage"},
    {0},
};

const struct gp_option_choice gp_debugs[] = {
    {"sensors", GP_DEBUG_SENSORS, "the light that the engines spread, "
     "scene-linear"},
    {"polygons", GP_DEBUG_POLYGONS, "outlines of the polygons that splat "
     "draws, in green over the tone-mapped picture"},
    {"sunmap", GP_DEBUG_SUNMAP, "the sun maps of all lights, side by side: "
     "white where a light is visible"},
    {"intensity", GP_DEBUG_INTENSITY, "the intensity map: one pixel per light, "
     "as bright as its visible share"},
    {"scissor", GP_DEBUG_SCISSOR, "glarepp sets: the picture with outlines of "
     "the lights' scissors"},
    {"sets", GP_DEBUG_SETS, "glarepp sets: the scene from above; objects are "
     "grey in no set, blue hidden, red casting shadows, green visible, yellow "
     "lit"},
    {0},
};

const struct gp_option_choice gp_types[] = {
    {"auto", GP_OUT_AUTO, "as in the input; float where a value is over "
     "65504"},
    {"half", GP_OUT_HALF, "16 bits; a brighter pixel is scaled to 65504, which "
     "keeps its hue; formats other than EXR get float"},
    {"float", GP_OUT_FLOAT, "32 bits"}, {0},
};

const struct gp_option_choice gp_compressions[] = {
    {"auto", GP_COMPRESSION_AUTO, "as in the input if that is lossless, else "
     "zip"},
    {"none", GP_COMPRESSION_NONE, NULL}, {"rle", GP_COMPRESSION_RLE, NULL},
    {"zips", GP_COMPRESSION_ZIPS, NULL}, {"zip", GP_COMPRESSION_ZIP, NULL},
    {"piz", GP_COMPRESSION_PIZ, NULL},
    {"pxr24", GP_COMPRESSION_PXR24, "rounds 32-bit floats to 24 bits, depth "
     "too; lossless for half"},
    {"b44", GP_COMPRESSION_B44, "lossy for half, alpha too, where NaN and Inf "
     "become 0; lossless for float"},
    {"b44a", GP_COMPRESSION_B44A, "as b44"},
    {"dwaa", GP_COMPRESSION_DWAA, "lossy for R, G, B and Y of every layer, "
     "where NaN becomes 0; lossless for depth and alpha"},
    {"dwab", GP_COMPRESSION_DWAB, "as dwaa"}, {0},
};

const struct gp_option_choice gp_bits[] = {
    {"8", 8, NULL}, {"16", 16, NULL}, {0},
};

const struct gp_option_choice gp_alphas[] = {
    {"black", GP_ALPHA_BLACK, "composite the picture over black, "
     "without alpha"},
    {"keep", GP_ALPHA_KEEP, "write the frame's alpha where the format has it: "
     "EXR, PNG, TIFF, WebP, Targa, SGI, DPX, BMP"}, {0},
};

const struct gp_option_choice gp_stdout_formats[] = {
#define X(name, ending, text) {ending, GP_STDOUT_##name, text},
    GP_STDOUT_LIST(X)
#undef X
    {0},
};

const struct gp_option_choice gp_raws[] = {
    {"rgb24", GP_RAW_RGB24, "8 bits, sRGB"},
    {"rgb48le", GP_RAW_RGB48LE, "16 bits, sRGB, low byte first"},
    {"rgb48be", GP_RAW_RGB48BE, "16 bits, sRGB, high byte first"},
    {"rgbf32le", GP_RAW_RGBF32LE, "floats as they are, low byte first"}, {0},
};

// -- values by name ----------------------------------------------------------

const char *gp_engine_name(int i, const char **text)
{
    if (i == 0) {
        *text = "direct for a handful of bright pixels, else fft, by each "
                "frame alone; whichever keeps the tolerance";
        return "auto";
    }
    return glarepp_name(NULL, GLAREPP_ENGINES, i - 1, text);
}

const char *gp_curve_name(int i, const char **text)
{
    return glarepp_name(NULL, GLAREPP_CURVES, i, text);
}

/* Returns true where a preset has the name of a model. */
static bool has_preset(const char *model)
{
    const char *name;
    int i = 0;
    while ((name = glarepp_name(NULL, GLAREPP_PRESETS, i, NULL)) &&
           strcmp(name, model) != 0)
        i++;
    return name != NULL;
}

const char *gp_kernel_word(int i, const char **text)
{
    static char word[64];
    const char *name;
    int presets = 0;
    while ((name = glarepp_name(NULL, GLAREPP_PRESETS, presets, text))) {
        if (presets++ < i)
            continue;
        snprintf(word, sizeof word, "builtin:%s", name);
        return word;
    }
    i -= presets;
    for (int k = 0; (name = glarepp_name(NULL, GLAREPP_MODELS, k, text)); k++) {
        if (!has_preset(name) && i-- == 0)
            break;
    }
    return name;
}
