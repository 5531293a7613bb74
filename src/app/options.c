#include "app/options.h"

#include <float.h>
#include <string.h>

const struct gp_settings gp_defaults = {
    .read = GP_READ_DEFAULTS,
    .sensor = GP_SENSOR_DEFAULTS,
    .kernel = GP_KERNEL_DEFAULTS,
    .glare = GP_GLARE_DEFAULTS,
    .compose = GP_COMPOSE_DEFAULTS,
    .tone = GP_TONE_DEFAULTS,
    .write = GP_WRITE_DEFAULTS,
    .bench = GP_BENCH_DEFAULTS,
    .command = GP_COMMAND_MAIN,
    .level = GP_LEVEL_WARN,
};

const char *const gp_option_groups[GP_GROUPS] = {
    [GP_GROUP_OUTPUT] = "Pictures to make (at least one)",
    [GP_GROUP_INPUT] = "Frames to read",
    [GP_GROUP_LIGHT] = "Light and kernel",
    [GP_GROUP_ENGINE] = "How the glare is computed",
    [GP_GROUP_TONE] = "Tone mapping",
    [GP_GROUP_FILE] = "Files",
    [GP_GROUP_REPORT] = "What was done",
    [GP_GROUP_BENCH] = "What glarepp bench measures and writes",
    [GP_GROUP_GENERAL] = "General",
};

// -- values by name ----------------------------------------------------------

static const char *engine_name(int i, const char **text)
{
    if (i == 0) {
        *text = "the engine and setting with the fewest predicted "
                "milliseconds whose bound is within the tolerance, counted "
                "anew for each frame";
        return "auto";
    }
    const struct gp_engine *e = gp_engines[i - 1];
    *text = e ? e->text : NULL;
    return e ? e->name : NULL;
}

static const char *curve_name(int i, const char **text)
{
    const struct gp_tone_curve *c = gp_tone_curves[i];
    *text = c ? c->text : NULL;
    return c ? c->name : NULL;
}

static const char *kernel_name(int i, const char **text)
{
    static char name[64]; // one line of help at a time
    const struct gp_builtin_kernel *k = &gp_builtin_kernels[i];
    *text = k->text;
    if (!k->name)
        return NULL;
    snprintf(name, sizeof name, "builtin:%s", k->name);
    return name;
}

static const struct gp_option_choice normalizes[] = {
    {"luminance", GP_NORMALIZE_LUMINANCE, "the luminance of its sum is 1, the "
     "ratios of its channels stay"},
    {"none", GP_NORMALIZE_NONE, "as it is in the file"},
    {0},
};
static const struct gp_option_choice mixes[] = {
    {"add", GP_MIX_ADD, "the layer comes on top of the frame"},
    {"scatter", GP_MIX_SCATTER, "light that is spread is taken from its "
     "source, which conserves energy; needs a gain up to 1"},
    {0},
};
static const struct gp_option_choice gls[] = {
    {"auto", GP_GL_AUTO, "the first that opens"},
    {"osmesa", GP_GL_OSMESA, "Mesa's off-screen library, on the CPU"},
    {"egl", GP_GL_EGL, "a GPU's device where there is one, Mesa's surfaceless "
     "platform else"},
    {0},
};
static const struct gp_option_choice methods[] = {
    {"centroid", GP_GROUP_CENTROID, "the kernel at the group's centroid: "
     "formula (1) of Ando et al."},
    {"moments", GP_GROUP_MOMENTS, "the kernel blurred by as much as the group "
     "is wide"},
    {"core", GP_GROUP_CORE, "the kernel's 17x17 core from each single sensor, "
     "only its tail from groups"},
    {0},
};
static const struct gp_option_choice primitives[] = {
    {"auto", GP_PRIMITIVE_AUTO, "tile on a software context, quad else"},
    {"quad", GP_PRIMITIVE_QUAD, "blended quads"},
    {"point", GP_PRIMITIVE_POINT, "blended point sprites, up to the driver's "
     "limit of size"},
    {"tile", GP_PRIMITIVE_TILE, "one pass for each tile, summed over the "
     "polygons that reach it"},
    {0},
};
static const struct gp_option_choice plans[] = {
    {"estimate", GP_FFT_PLAN_ESTIMATE, "the same plan, so the same bytes, in "
     "every run"},
    {"measure", GP_FFT_PLAN_MEASURE, "the fastest plan of a few tried; kept "
     "in the cache folder for later runs"},
    {0},
};
static const struct gp_option_choice types[] = {
    {"auto", GP_OUT_AUTO, "as in the input"},
    {"half", GP_OUT_HALF, "16 bits; values over 65504 become 65504"},
    {"float", GP_OUT_FLOAT, "32 bits"},
    {0},
};
static const struct gp_option_choice compressions[] = {
    {"auto", GP_COMPRESSION_AUTO, "as in the input when that is lossless, "
     "zip else"},
    {"none", GP_COMPRESSION_NONE, NULL},
    {"rle", GP_COMPRESSION_RLE, NULL},
    {"zips", GP_COMPRESSION_ZIPS, NULL},
    {"zip", GP_COMPRESSION_ZIP, NULL},
    {"piz", GP_COMPRESSION_PIZ, NULL},
    {"pxr24", GP_COMPRESSION_PXR24, NULL},
    {"b44", GP_COMPRESSION_B44, NULL},
    {"b44a", GP_COMPRESSION_B44A, NULL},
    {"dwaa", GP_COMPRESSION_DWAA, NULL},
    {"dwab", GP_COMPRESSION_DWAB, NULL},
    {0},
};
static const struct gp_option_choice bits[] = {
    {"8", 8, NULL}, {"16", 16, NULL}, {0},
};
static const struct gp_option_choice alphas[] = {
    {"black", GP_ALPHA_BLACK, "the picture stands over black and has no "
     "alpha"},
    {"keep", GP_ALPHA_KEEP, "the frame's alpha is written along"},
    {0},
};
static const struct gp_option_choice progresses[] = {
    {"auto", GP_PROGRESS_AUTO, "on a terminal, for work over a second"},
    {"always", GP_PROGRESS_ALWAYS, NULL},
    {"never", GP_PROGRESS_NEVER, NULL},
    {0},
};
static const struct gp_option_choice debugs[] = {
    {"sensors", GP_DEBUG_SENSORS, "the light that the engines are given, "
     "scene-linear"},
    {"polygons", GP_DEBUG_POLYGONS, "outlines of the polygons that splat "
     "draws, in green over the tone-mapped picture"},
    {0},
};

// -- the table ---------------------------------------------------------------

#define FIELD(f) (&((struct gp_settings *) 0)->f)
#define ROW(f, kind_of_f, ...)                                                \
    { .at = offsetof(struct gp_settings, f), .kind = kind_of_f, __VA_ARGS__ }

/* A number, flag, pair or free text, as the field's type says. */
#define OPT(f, ...)                                                           \
    ROW(f, _Generic(FIELD(f), bool *: GP_KIND_FLAG, float *: GP_KIND_FLOAT,   \
                    int *: GP_KIND_INT, long long *: GP_KIND_COUNT,           \
                    double (*)[2]: GP_KIND_PAIR,                              \
                    const char **: GP_KIND_TEXT,                              \
                    struct gp_texts *: GP_KIND_TEXTS,                         \
                    const char *(*)[GP_DEBUG_KINDS]: GP_KIND_NAMED),          \
        __VA_ARGS__)

/* An enum or int by the names of `choices`; an enum without a value at all:
 * it is set to `set`. */
#define CHOICE(f, ...)                                                        \
    ROW(f, _Generic(FIELD(f), unsigned *: GP_KIND_CHOICE,                     \
                    int *: GP_KIND_CHOICE), __VA_ARGS__)
#define SET(f, ...)                                                           \
    ROW(f, _Generic(FIELD(f), unsigned *: GP_KIND_SET), __VA_ARGS__)

/* Its heading, and which commands take it. */
#define IN(g) .group = GP_GROUP_##g, .commands = GP_COMMAND_MAIN
#define BOTH(g) .group = GP_GROUP_##g,                                        \
    .commands = GP_COMMAND_MAIN | GP_COMMAND_BENCH
#define BENCH .group = GP_GROUP_BENCH, .commands = GP_COMMAND_BENCH

const struct gp_option gp_options[] = {
    OPT(outputs, .name = "output", .letter = 'o', IN(OUTPUT), .arg = "FILE",
        .help = "Tone-mapped picture; the ending picks the format; may be "
                "given more than once"),
    OPT(hdr, .name = "hdr", IN(OUTPUT), .arg = "FILE",
        .help = "Scene-linear EXR with glare; all other channels and "
                "attributes of the input pass through"),
    OPT(layer, .name = "layer", IN(OUTPUT), .arg = "FILE",
        .help = "The glare layer alone, scene-linear"),
    OPT(debug, .name = "debug", IN(OUTPUT), .arg = "KIND=FILE",
        .choices = debugs, .help = "Picture of a step on the way"),

    OPT(frames, .name = "frames", .letter = 'f', IN(INPUT), .arg = "LIST",
        .help = "Frames of a pattern: 1-100, 1-100x2, 3,4,10-20x2 or 5-1; "
                "without it, those on disk"),
    OPT(depth, .name = "depth", IN(INPUT), .arg = "CH",
        .help = "Depth channel, named in the report; without it, Z, depth.Z, "
                "Depth.Z, *.Depth.Z or *.Z is looked for"),
    OPT(read.max_pixels, .name = "max-pixels", BOTH(INPUT), .arg = "N",
        .lo = 1, .hi = 1LL << 40,
        .help = "Refuses files that claim to have more pixels"),

    OPT(sensor.threshold, .name = "threshold", .letter = 't', BOTH(LIGHT),
        .arg = "T", .hi = FLT_MAX,
        .help = "Luminance over which a pixel is a light source"),
    OPT(sensor.knee, .name = "knee", BOTH(LIGHT), .arg = "K", .hi = 1,
        .help = "Smooth start of the threshold, from T(1-K) to T(1+K)"),
    OPT(sensor.max_value, .name = "max-value", BOTH(LIGHT), .arg = "V",
        .lo = FLT_MIN, .hi = 1e30,
        .help = "What brighter and infinite values become"),
    OPT(kernel.source, .name = "kernel", .letter = 'k', BOTH(LIGHT),
        .arg = "FILE", .list = kernel_name, .open = true,
        .help = "What one bright pixel becomes: an image"),
    OPT(kernel.center, .name = "kernel-center", BOTH(LIGHT), .arg = "X,Y",
        .given = offsetof(struct gp_settings, kernel.centered),
        .lo = -1e6, .hi = 1e6,
        .help = "The kernel's centre in its own pixels, whose centres are at "
                "halves; without it, pixel (w/2, h/2) rounded down"),
    CHOICE(kernel.normalize, .name = "kernel-normalize", BOTH(LIGHT),
           .arg = "HOW", .choices = normalizes,
           .help = "Scale of the kernel"),
    OPT(kernel.rotate, .name = "rotate", BOTH(LIGHT), .arg = "DEG",
        .lo = -36000, .hi = 36000,
        .help = "Turns the kernel about its centre, counter-clockwise"),
    OPT(compose.gain, .name = "gain", .letter = 'g', BOTH(LIGHT), .arg = "G",
        .hi = 1e6, .help = "Scale of the layer in the pictures"),
    CHOICE(compose.mix, .name = "mix", BOTH(LIGHT), .arg = "HOW",
           .choices = mixes, .help = "How frame and layer go together"),

    OPT(glare.engine, .name = "engine", .letter = 'e', IN(ENGINE),
        .arg = "NAME", .list = engine_name,
        .help = "Method; all give the same layer within their error"),
    OPT(glare.tolerance, .name = "tolerance", BOTH(ENGINE), .arg = "E",
        .hi = 1,
        .help = "Error that auto may make: the norm of the layer's error over "
                "that of the exact layer"),
    OPT(glare.splat.group, .name = "group", IN(ENGINE), .arg = "N", .lo = 1,
        .hi = 64,
        .help = "splat: NxN pixels are one polygon; a power of two, 1 for "
                "none"),
    CHOICE(glare.splat.method, .name = "group-method", IN(ENGINE),
           .arg = "HOW", .choices = methods,
           .help = "splat: how a group stands for its pixels"),
    OPT(glare.splat.cluster, .name = "cluster", IN(ENGINE), .arg = "N",
        .hi = 64, .given = offsetof(struct gp_settings, clustered),
        .help = "splat: filled areas of NxN pixels are one polygon; a power "
                "of two over that of --group, 0 for none; without it, none "
                "where --group is as large"),
    OPT(glare.splat.cluster_fill, .name = "cluster-fill", IN(ENGINE),
        .arg = "F", .lo = FLT_MIN, .hi = 1,
        .help = "splat: share of bright pixels from which an area is filled"),
    OPT(glare.splat.shrink, .name = "shrink", IN(ENGINE), .arg = "E",
        .hi = 0.99,
        .help = "splat: share of the light that may be left out where the "
                "kernel is too dim to see; 0 for none"),
    CHOICE(glare.splat.primitive, .name = "primitive", IN(ENGINE),
           .arg = "WHAT", .choices = primitives,
           .help = "splat: what is drawn for a polygon"),
    CHOICE(glare.gl, .name = "gl", BOTH(ENGINE), .arg = "API", .choices = gls,
           .help = "Context of the engine on GL"),
    CHOICE(glare.fft_plan, .name = "fft-plan", BOTH(ENGINE), .arg = "HOW",
           .choices = plans, .help = "How the FFT chooses its plans"),
    OPT(threads, .name = "threads", BOTH(ENGINE), .arg = "N", .hi = 1024,
        .help = "Threads, 0 for all processors; no output depends on it"),

    OPT(tone.curve, .name = "tonemap", BOTH(TONE), .arg = "NAME",
        .list = curve_name, .help = "Operator"),
    OPT(tone.exposure, .name = "exposure", BOTH(TONE), .arg = "EV", .lo = -32,
        .hi = 32, .help = "Scales the light by 2 to the EV first"),
    OPT(tone.auto_exposure, .name = "auto-exposure", BOTH(TONE),
        .help = "Scales so that the frame's log-average becomes middle grey; "
                "EV comes on top"),
    OPT(tone.white, .name = "white", BOTH(TONE), .arg = "W", .hi = FLT_MAX,
        .help = "Luminance that burns out with reinhard-extended, in scaled "
                "units; 0 takes the frame's maximum"),

    CHOICE(write.type, .name = "type", IN(FILE), .arg = "TYPE",
           .choices = types, .help = "Samples of float formats"),
    CHOICE(write.compression, .name = "compression", IN(FILE), .arg = "NAME",
           .choices = compressions, .help = "EXR compression"),
    CHOICE(write.depth_bits, .name = "depth-bits", IN(FILE), .arg = "N",
           .choices = bits, .help = "Bits a sample of PNG and other integer "
           "formats"),
    OPT(write.dither, .name = "dither", IN(FILE),
        .help = "Dithers where values become integers"),
    CHOICE(write.alpha, .name = "alpha", IN(FILE), .arg = "HOW",
           .choices = alphas, .help = "Alpha of -o pictures"),
    OPT(write.create_dir, .name = "create-dir", IN(FILE),
        .help = "Makes the folders of output files that are missing"),

    OPT(report, .name = "report", IN(REPORT), .arg = "FILE",
        .help = "JSON, one object a line for each frame; - is stdout"),
    OPT(verify, .name = "verify", IN(REPORT),
        .help = "Measures the layer's error against the exact sum in double; "
                "slow; shown by --report and -v"),
    CHOICE(progress, .name = "progress", IN(REPORT), .arg = "WHEN",
           .choices = progresses, .help = "Line with frame, rate and time "
           "left"),
    SET(level, .name = "quiet", .letter = 'q', BOTH(REPORT),
        .set = GP_LEVEL_ERROR, .help = "Errors only"),
    SET(level, .name = "verbose", .letter = 'v', BOTH(REPORT),
        .set = GP_LEVEL_INFO, .help = "A line for each frame"),

    OPT(bench.csv, .name = "csv", BENCH, .arg = "FILE",
        .help = "The table as comma-separated values; - is stdout"),
    OPT(bench.json, .name = "json", BENCH, .arg = "FILE",
        .help = "The table as JSON; - is stdout"),
    OPT(bench.plot, .name = "plot", BENCH, .arg = "FILE",
        .help = "Error over time with the Pareto front, as SVG, by gnuplot"),
    OPT(bench.paper, .name = "paper", BENCH,
        .help = "Three frames after the paper, made here: few points, "
                "windows, and a sky that fills the frame"),
    OPT(bench.runs, .name = "runs", BENCH, .arg = "N", .lo = 1, .hi = 1000,
        .help = "Timed runs of each row; the table has their median"),

    OPT(version, .name = "version", BOTH(GENERAL),
        .help = "Prints the versions of the program and its libraries"),
    OPT(help, .name = "help", .letter = 'h', BOTH(GENERAL),
        .help = "Prints this"),
    OPT(help_man, .name = "help-man", IN(GENERAL), .hidden = true,
        .help = "Prints the man page's generated parts"),
    {0},
};

// -- look-up -----------------------------------------------------------------

const char *gp_option_value(const struct gp_option *o, int i,
                            const char **text)
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
    bool over_zero = o->lo == (double) FLT_MIN; // the least that is not 0
    if (over_zero && open_end)
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

const struct gp_option *gp_option_letter(char letter)
{
    for (const struct gp_option *o = gp_options; o->name && letter; o++) {
        if (o->letter == letter)
            return o;
    }
    return NULL;
}
