// SPDX-License-Identifier: Apache-2.0
/* The commands; lists that the table of options names: its headings, the styles, and
 * values that the library lists. */
#include "cli/jobs.h"

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

const struct gp_command_row *gp_command_named(const char *word)
{
    const struct gp_command_row *c = gp_commands + 1;
    while (c->word && strcmp(c->word, word) != 0)
        c++;
    return c->word ? c : NULL;
}

const struct gp_command_row *gp_command_of(unsigned commands)
{
    const struct gp_command_row *c = gp_commands;
    while (!(c->bit & commands))
        c++;
    return c;
}

// -- what values ask for -----------------------------------------------------

bool gp_kernel_is_file(const char *word)
{
    char path[PATH_MAX];
    return glarepp_kernel_path(word, path, sizeof path) &&
           strcmp(path, word) == 0;
}

bool gp_kernel_file(const struct gp_settings *s, int i, char *path)
{
    const int words = s->kernel.words.n;
    if (i >= words + s->input.group_kernels.n)
        return false;
    if (!glarepp_kernel_path(i < words ? s->kernel.words.at[i]
                                       : s->input.group_kernels.at[i - words],
                             path, PATH_MAX))
        *path = '\0';
    return true;
}

bool gp_lights_wanted(const struct gp_settings *s)
{
    return s->sun.at.n || s->sun.dir.n || s->sun.p.cameras || s->sun.p.file ||
           s->scene.path;
}

const char *gp_output_at(const struct gp_settings *s, int i,
                         enum gp_target_kind *kind)
{
    // --hdr first: it may copy from an input that a later output replaces
    const struct gp_texts *const list[] = {&s->output.hdr, &s->output.layer,
                                           &s->output.parts,
                                           &s->output.pictures};
    for (unsigned k = 0; k < sizeof list / sizeof *list; i -= list[k++]->n) {
        *kind = k;
        if (i < list[k]->n)
            return list[k]->at[i];
    }
    for (unsigned k = 0; k < GP_DEBUG_KINDS; k++) {
        *kind = GP_TARGET_SENSORS + k;
        if (s->output.debug[k] && i-- == 0)
            return s->output.debug[k];
    }
    return NULL;
}

// -- headings ----------------------------------------------------------------

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

// -- styles ------------------------------------------------------------------

/* The usual threshold, 1, is the display's white: the part of light below it is
 * shown as it is. A style names another only with a reason.
 *
 * The glare index is that of ISO 9358:1994, here in the middle of a black area
 * of 1 degree in an endless bright field; the unit test of styles measures it.
 * Degrees are of the usual angle of view, 30 degrees for the height of a frame
 * without a camera: on 35 mm film, 24 mm high, that of a lens of 45 mm. */

/* A corrected lens's image of a point has wings: Moffat 1969, eq. 7. 6 % of the
 * light leaves its place, half of that to less than 0.07 degree. */
#define CORE "moffat:share=.06,fwhm=.1,beta=2.5"

/* Veil: with core and iris a glare index of 0.75 %, the most that lifts the
 * blacks of no frame by day by over 8 codes (styles.t): a tree before the sky.
 * It falls with the fourth power of the distance. Measured spread functions
 * fall steeply over the first degrees, too (Talvala et al. 2007); one that is
 * even over the frame would lift each black by the index. */
#define VEIL "moffat:share=.012,fwhm=.6,beta=2"

const struct gp_style gp_styles[] = {
    {"camera", "a modern lens: a soft core, a thin veil, its iris' diffraction",
     {
        "kernel", CORE,
        "kernel", VEIL,
        // The iris, round by its blades: Airy's pattern falls with the cube of
        // the angle, as a Moffat of beta 1.5. A stop of D mm sends the share
        // 2 l / (pi^2 D t) of its light farther than t radians; 35 mm at f/4
        // and 550 nm: .00073 / t, t in degrees, which is share times fwhm /
        // 1.53.
        // Rays of straight blades would take 18 ms more of 110 in 1920x1080.
        "kernel", "moffat:share=.028,fwhm=.04,beta=1.5",
     }},
    {"vintage", "bare glass of 1902: a wide veil, and the ghosts of a Tessar",
     {
        // Rudolph's Tessar, US 721,240: light bounces twice off its bare glass
        "lens", "tessar",
        "kernel", "moffat:share=.09,fwhm=.14,beta=2", // less corrected
        // With that a glare index of 3.3 % beside the ghosts, chosen on frames:
        // 15 pairs of 6 surfaces that each reflect ((n - 1) / (n + 1))^2, 5.5 %
        // at n = 1.61, send 4.5 % of the light astray.
        "kernel", "moffat:share=.03,fwhm=3,beta=1.5",
     }},
    {"mist", "a diffusion filter: a wide halo around all light, lifted blacks",
     {
        "threshold", "0", // glass before the lens spreads all light alike
        // No maker gives figures. Chosen on frames: a glare index of 10 %, of
        // which 3 % is as wide as the frame: blacks far from light.
        "kernel", "moffat:share=.1,fwhm=.8,beta=1.5",
        "kernel", "moffat:share=.03,fwhm=6,beta=1.5",
     }},
    {"anamorphic", "a squeezing lens: blue streaks, oval ghosts",
     {
        "threshold", "2", // a stop over white: streaks are of lamps, not walls
        "kernel", CORE,
        "kernel", VEIL,
        // Light that a front cylinder reflects spreads along one line; coatings
        // reflect the blue end most. Strength, colour: chosen on frames.
        "kernel", "streak:share=.02,red=.08,green=.3",
        "flare", "preset:oval", // half as wide as high: a squeeze of 2
     }},
    {"halation", "film without a backing: red halos around lights",
     {
        "kernel", CORE,
        // Base and index of film: the model's own. Half of what the emulsion
        // scatters is beyond the critical angle (1 - 1 / n^2 = 0.54); of the
        // share that reaches the base no figure was found: chosen on frames.
        "kernel", "halation:share=.009",
     }},
    {"star", "a cross screen filter: four fine rays",
     {
        "kernel", CORE,
        "kernel", VEIL,
        // two sets of engraved lines, at right angles, as such filters have;
        // the share of the glass that they cover: chosen on frames
        "kernel", "cross:share=.05",
     }},
    {"eye", "the human eye in daylight (Spencer et al. 1995)",
     {"kernel", "builtin:eye"}},
    {"eye-night", "the eye at night, with its halo and needles",
     {"kernel", "builtin:eye-night"}},
    {0},
};

const struct gp_style *gp_style_of(const char *name)
{
    const struct gp_style *s = gp_styles;
    while (strcmp(s->name, name) != 0)
        s++;
    return s;
}

bool gp_style_sets(const char *style, const char *option)
{
    const char *const *word = gp_style_of(style)->word;
    while (*word && strcmp(*word, option) != 0)
        word += 2;
    return *word != NULL;
}

// -- values by name ----------------------------------------------------------

const char *gp_engine_name(int i, const char **text)
{
    if (i == 0) {
        *text = "direct for a handful of bright pixels, else fft (levels, by "
                "true angles), by each frame alone; whichever keeps the "
                "tolerance";
        return "auto";
    }
    return glarepp_name(NULL, GLAREPP_ENGINES, i - 1, text);
}

const char *gp_curve_name(int i, const char **text)
{
    return glarepp_name(NULL, GLAREPP_CURVES, i, text);
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
        const char *preset; // of this name?
        int n = 0;
        while ((preset = glarepp_name(NULL, GLAREPP_PRESETS, n, NULL)) &&
               strcmp(preset, name) != 0)
            n++;
        if (!preset && i-- == 0)
            break;
    }
    return name;
}

const char *gp_style_name(int i, const char **text)
{
    *text = gp_styles[i].text;
    return gp_styles[i].name;
}
