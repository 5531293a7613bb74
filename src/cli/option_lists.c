/* Lists that the table of options names: its headings, and values that the
 * library and io list. */
#include "cli/options.h"

#include <stdio.h>
#include <string.h>

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

const char *gp_grow_word(int i, const char **text)
{
    static const char *const words[][2] = {
        {"kernel", "as far as the kernel reaches"},
        {"none", "outputs keep the data window, and glare ends at its edges"},
        {NULL, NULL},
    };
    *text = words[i][1];
    return words[i][0];
}

const char *gp_help_word(int i, const char **text)
{
    *text = NULL;
    return i == 0 ? "all" : NULL;
}
