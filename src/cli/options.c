// SPDX-License-Identifier: Apache-2.0
#include "cli/options.h"


#include <float.h>
#include <string.h>

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

// -- the table ---------------------------------------------------------------

#define FIELD(f) (&((struct gp_settings *) 0)->f)
#define ROW(f, kind_of_f, ...)                                                \
    { .at = offsetof(struct gp_settings, f), .kind = kind_of_f, __VA_ARGS__ }

/* A number, flag, pair or free text, by the field's type. */
#define OPT(f, ...) \
    ROW(f, _Generic(FIELD(f), bool *: GP_KIND_FLAG, float *: GP_KIND_FLOAT,   \
                    double *: GP_KIND_REAL,                                   \
                    struct glarepp_sense_params *: GP_KIND_THRESHOLD,         \
                    struct glarepp_kernel_params *: GP_KIND_SIZE,             \
                    int *: GP_KIND_INT, long long *: GP_KIND_COUNT,           \
                    struct gp_numbers *: GP_KIND_NUMBERS,                     \
                    const char **: GP_KIND_TEXT,                              \
                    struct gp_texts *: GP_KIND_TEXTS,                         \
                    const char *(*)[GP_DEBUG_KINDS]: GP_KIND_NAMED),          \
        __VA_ARGS__)

/* CHOICE: an enum, int or bool by the names of `choices`. SET: an enum, set to
 * `set` by an option without a value. */
#define CHOICE(f, ...)                                                        \
    ROW(f, _Generic(FIELD(f), unsigned *: GP_KIND_CHOICE,                     \
                    int *: GP_KIND_CHOICE, bool *: GP_KIND_EITHER),           \
        __VA_ARGS__)
#define SET(f, ...)                                                           \
    ROW(f, _Generic(FIELD(f), unsigned *: GP_KIND_SET), __VA_ARGS__)

/* A factor, in EV too, or auto. */
#define LEVEL(f, ...) \
    ROW(f, _Generic(FIELD(f), float *: GP_KIND_LEVEL),                        \
        .arg = "G|EVev|auto", .hi = 1e9, __VA_ARGS__)

/* Heading and commands of an option. */
#define IN(g) .group = GP_GROUP_##g, .commands = GP_COMMAND_MAIN
#define DRAWS(g) .group = GP_GROUP_##g,                                       \
    .commands = GP_COMMAND_MAIN | GP_COMMAND_STYLES
#define BOTH(g) .group = GP_GROUP_##g,                                        \
    .commands = GP_COMMAND_MAIN | GP_COMMAND_BENCH | GP_COMMAND_STYLES
#define KERNEL .group = GP_GROUP_KERNEL, .commands = GP_COMMAND_KERNEL
#define LENS(g) .group = GP_GROUP_##g,                                        \
    .commands = GP_COMMAND_MAIN | GP_COMMAND_BENCH | GP_COMMAND_KERNEL |      \
        GP_COMMAND_STYLES
#define MAKES(g) .group = GP_GROUP_##g,                                       \
    .commands = GP_COMMAND_MAIN | GP_COMMAND_KERNEL
#define OPTICS .group = GP_GROUP_LENS, .commands = GP_COMMAND_LENS
#define SETS .group = GP_GROUP_SETS, .commands = GP_COMMAND_SETS
#define BENCH .group = GP_GROUP_BENCH, .commands = GP_COMMAND_BENCH
#define COMPARE .group = GP_GROUP_COMPARE, .commands = GP_COMMAND_COMPARE
#define ALL(g) .group = GP_GROUP_##g,                                         \
    .commands = GP_COMMAND_MAIN | GP_COMMAND_BENCH | GP_COMMAND_COMPARE |     \
        GP_COMMAND_KERNEL | GP_COMMAND_SETS | GP_COMMAND_STYLES

// clang-format off
const struct gp_option gp_options[] = {
    OPT(output.pictures, .name = "output", .letter = 'o',
        .group = GP_GROUP_OUTPUT,
        .commands = GP_COMMAND_MAIN | GP_COMMAND_KERNEL | GP_COMMAND_SETS |
            GP_COMMAND_STYLES, .arg = "FILE",
        .help = "Write a tone-mapped picture, the kernel as EXR floats, the "
                "scene's picture or the sheet of styles; the ending picks the "
                "format; may be given more than once",
        .usual = "Write a picture, tone-mapped: .png .jpg .tif"),
    OPT(output.hdr, .name = "hdr", IN(OUTPUT), .arg = "FILE",
        .help = "Write a scene-linear EXR with glare; all other channels and "
                "attributes of the input pass through; may be given more than "
                "once",
        .usual = "Write an EXR: the frame with glare, linear light"),
    OPT(output.layer, .name = "layer", IN(OUTPUT), .arg = "FILE",
        .help = "Write the glare layer only, scene-linear; may be given more "
                "than once",
        .usual = "Write an EXR: only the glare, to add in comp"),
    OPT(output.parts, .name = "parts", IN(OUTPUT), .arg = "FILE",
        .help = "Write the parts of --layer, which add up to it, as layers of "
                "one EXR, of floats without --type: veil is light that leaves its pixel, core what "
                "stays, flare the elements of --flare, ghosts those of --lens; what a "
                "--light-group spreads is in a layer of its name instead"),
    OPT(output.grow, .name = "grow", IN(OUTPUT), .arg = "PIXELS",
        .choices = gp_grows, .open = true, .pixels = true,
        .help = "Extend outputs beyond the union of data and display window, "
                "by PIXELS on each side"),
    OPT(output.debug, .name = "debug", .group = GP_GROUP_OUTPUT,
        .commands = GP_COMMAND_MAIN | GP_COMMAND_SETS, .arg = "KIND=FILE",
        .choices = gp_debugs, .help = "Write a picture of an intermediate "
        "step"),

    OPT(input.frames, .name = "frames", .letter = 'f', .group = GP_GROUP_INPUT,
        .commands = GP_COMMAND_MAIN | GP_COMMAND_COMPARE, .arg = "LIST",
        .aside = true, .help = "Read these frames of a pattern: 1-100, 1-100x2 "
        "(or 1-100:2), 3,4,10-20x2 or 5-1; without it, all that exist on disk"),
    OPT(input.views, .name = "views", IN(INPUT), .arg = "LIST",
        .help = "Make these stereo views: by %V or %v (first letter) in input "
                "names, where the default is left,right; else views inside "
                "each input, where the default is all, and outputs without %V "
                "show the first"),
    OPT(input.skip_bad_frames, .name = "skip-bad-frames", IN(INPUT),
        .aside = true,
        .help = "Skip frames that fail, list them at the end, exit 6"),
    OPT(input.read.layer, .name = "layer-in", BOTH(INPUT), .arg = "NAME",
        .help = "Read the colour from this EXR layer: NAME.R,G,B, a part "
        "called NAME, or right.NAME in the view right; without it, from the "
        "first that has colour"),
    OPT(input.read.part, .name = "part", BOTH(INPUT), .arg = "NAME|N",
        .help = "Read the colour from this part of a multi-part file, by "
                "name or number from 0"),
    OPT(input.light_groups, .name = "light-group", IN(INPUT),
        .arg = "NAME[:kernel=K,gain=G]",
        .help = "Spread the light of this EXR layer in place of the frame's "
        "own; may be given more than once; --hdr adds to each layer its own "
        "glare; a colon may be followed by a kernel, a word of --kernel, and "
        "a gain, 0 to 1e6, which --layer has too"),
    OPT(input.read.max_pixels, .name = "max-pixels", ALL(INPUT), .arg = "N",
        .lo = 1, .hi = 1LL << 40, .aside = true, .help = "Refuse files whose "
        "data or display window has more than N pixels; in files other than "
        "EXR, every four channels of a pixel count as one pixel"),

    OPT(light.style, .name = "style", .group = GP_GROUP_LIGHT,
        .commands = GP_COMMAND_MAIN | GP_COMMAND_BENCH | GP_COMMAND_KERNEL,
        .arg = "NAME", .list = gp_style_name,
        .help = "Set kernels, threshold, mix, flare and lens together, but for "
                "those that are given",
        .usual = "Look like this: glarepp styles lists them"),
    OPT(light.sense, .name = "threshold", .letter = 't', BOTH(LIGHT),
        .arg = "T|P%|EVev", .hi = FLT_MAX,
        .help = "Treat pixels over this luminance as light sources: a number, "
                "a percentile such as 99.9%, or EV over the log-average such "
                "as +3ev",
        .usual = "Let pixels over this luminance glare"),
    CHOICE(light.sense.whole, .name = "threshold-mode", BOTH(LIGHT),
        .arg = "HOW",
        .choices = gp_threshold_modes,
        .help = "Spread this part of a light source"),
    OPT(light.sense.knee, .name = "knee", BOTH(LIGHT), .arg = "K", .hi = 1,
        .help = "Ramp --threshold-mode whole smoothly from T(1-K) to T(1+K)"),
    OPT(light.sense.max_value, .name = "max-value", BOTH(LIGHT), .arg = "V",
        .hi = FLT_MAX, .help = "Clamp brighter pixels: scale them so that "
        "their largest channel is V, which keeps their hue; 0 clamps none"),
    OPT(light.mask, .name = "source-mask", IN(LIGHT),
        .arg = "FILE|CH|crypto:NAMES", .help = "Let pixels glare by the share "
        "that this channel of the frame has, or else this file (or pattern): "
        "its A, its only channel or its R, 0 to 1; or by the coverage of "
        "Cryptomatte's objects NAME,NAME, in which * and ? match any text and "
        "character, and \\ quotes what follows; ! before all of it inverts"),
    OPT(light.source, .name = "source", IN(LIGHT), .arg = "FILE",
        .help = "Spread the light of this frame (or pattern), which has the "
                "same data window, in place of the frame's own, and add it: "
                "--mix is add, and what the kernel leaves in its pixel is "
                "added too"),
    OPT(kernel.words, .name = "kernel", .letter = 'k', LENS(LIGHT),
        .arg = "FILE", .list = gp_kernel_word, .open = true,
        .help = "Point-spread function, without it the style's: an image file "
                "or a model and its keys, as MODEL:key=value,key=value; "
                "several add up by their shares",
        .usual = "Shape the glare; glarepp kernel --list has shapes"),
    OPT(plan.fov, .name = "fov", LENS(LIGHT), .arg = "DEG", .lo = 0.001,
        .hi = 360,
        .help = "Vertical angle of view of the display window, by which models "
                "have their size; without it the frame's camera, else 30, of a "
                "fisheye 180",
        .usual = "Set the vertical angle of view"),
    CHOICE(plan.projection, .name = "projection", BOTH(LIGHT), .arg = "HOW",
        .choices = gp_projections, .help = "Take the angles of the frame's "
        "pixels so; kernel images, and models with rays or edges, are the same "
        "everywhere by either"),
    OPT(kernel.p, .name = "kernel-size", LENS(LIGHT), .arg = "PCT|DEGdeg",
        .help = "Resample kernel images by areas: 50 or 50% for half as many "
                "pixels, 2deg for a height of 2 degrees of view"),
    OPT(kernel.centre, .name = "kernel-center", BOTH(LIGHT), .arg = "X,Y",
        .least = 2, .most = 2, .lo = -1e6, .hi = 1e6,
        .help = "Set the kernel's centre, in its own pixels (0.5,0.5 is the "
                "centre of the first); without it, the centre of pixel "
                "(w/2, h/2) rounded down"),
    CHOICE(kernel.normalize, .name = "kernel-normalize", BOTH(LIGHT),
        .arg = "HOW", .choices = gp_normalizes, .help = "Scale the kernel; "
        "without it, a file of glarepp kernel is used as it is"),
    OPT(plan.rotate, .name = "rotate", LENS(LIGHT), .arg = "DEG",
        .lo = -36000, .hi = 36000,
        .help = "Rotate the kernel about its centre, counter-clockwise"),
    OPT(light.layer.gain, .name = "gain", .letter = 'g', BOTH(LIGHT),
        .arg = "G",
        .hi = 1e6, .help = "Scale the glare in pictures and --hdr, not in "
        "--layer; with --mix scatter, 1 moves all light of the sources, and "
        "more than 1 only brightens the glare",
        .usual = "Scale the glare: 0.5 for half of it"),
    OPT(light.tint, .name = "tint", DRAWS(LIGHT), .arg = "R,G,B", .least = 3,
        .most = 3, .hi = 1e6, .help = "Multiply the channels of the glare by "
        "these, with flare and lens, in --layer too; what scatters leaves the "
        "sources in its own colour"),
    OPT(light.layer.saturation, .name = "layer-saturation", DRAWS(LIGHT),
        .arg = "S", .hi = 10, .help = "Saturate the glare before --tint: 0 "
        "makes it grey, 2 doubles its distance from grey, and less than 0 "
        "becomes 0; in --layer too"),
    CHOICE(light.layer.mix, .name = "mix", LENS(LIGHT), .arg = "HOW",
        .choices = gp_mixes, .help = "Combine frame and layer this way"),
    CHOICE(light.layer.edges, .name = "edges", DRAWS(LIGHT), .arg = "HOW",
        .choices = gp_edges_ways,
        .help = "Continue the picture beyond its border this way"),

    OPT(sun.at, .name = "sun", BOTH(SUN), .arg = "X,Y[,R]", .least = 2,
        .most = 3, .lo = -1e6, .hi = 1e6,
        .help = "Place the sun: centre and radius in pixels (radius 0.5 if "
                "omitted); bench then prints its table of visibility"),
    OPT(sun.dir, .name = "sun-dir", BOTH(SUN), .arg = "X,Y,Z", .least = 3,
        .needs = GP_NEED_NO_PLACE, .most = 3, .lo = -1e9, .hi = 1e9,
        .help = "Place the sun by its direction in the world, from the scene "
                "to the sun, and the frame's worldToNDC matrix or --camera"),
    OPT(sun.p.degrees, .name = "sun-size", BOTH(SUN), .arg = "DEG",
        .needs = GP_NEED_LIGHT, .lo = FLT_MIN, .hi = 90, .help = "Set the "
        "sun's diameter in degrees, for --sun-dir and --camera"),
    OPT(sun.color, .name = "sun-color", IN(SUN), .arg = "R,G,B", .least = 1,
        .needs = GP_NEED_LIGHT | GP_NEED_SUN, .most = 3, .hi = 1e12,
        .help = "Set the sun's flux, scene-linear, summed over pixels (one "
                "number: grey): it adds glare of its own and lights the "
                "flare; without it, only the frame's bright pixels glare"),
    OPT(sun.p.in_frame, .name = "sun-in-frame", IN(SUN), .needs = GP_NEED_LIGHT,
        .help = "Treat lights as already drawn in the frame, whose bright "
                "pixels glare: their flux lights only the flare"),
    CHOICE(sun.p.method, .name = "sun-method", BOTH(SUN), .arg = "HOW",
        .needs = GP_NEED_LIGHT, .choices = gp_sun_methods,
        .help = "Find the visible share of a light this way"),
    OPT(sun.p.side, .name = "sun-map", BOTH(SUN), .arg = "N", .lo = 2,
        .needs = GP_NEED_LIGHT | GP_NEED_MAP, .hi = 256,
        .help = "mask: make sun maps of NxN texels; even"),
    CHOICE(sun.p.square, .name = "sun-pattern", BOTH(SUN), .arg = "WHAT",
        .needs = GP_NEED_LIGHT | GP_NEED_MAP, .choices = gp_patterns,
        .help = "mask: sample this area"),
    CHOICE(sun.p.bytes, .name = "sun-sum", BOTH(SUN), .arg = "HOW",
        .needs = GP_NEED_LIGHT | GP_NEED_MASK, .choices = gp_sums,
        .help = "mask: sum texels this way"),
    CHOICE(sun.p.outside, .name = "sun-outside", BOTH(SUN), .arg = "HOW",
        .needs = GP_NEED_LIGHT, .choices = gp_outsides,
        .help = "Count the part of a light outside the frame this way"),
    CHOICE(sun.p.share_by, .name = "sun-share", IN(SUN), .arg = "HOW",
        .needs = GP_NEED_LIGHT | GP_NEED_SCENE, .choices = gp_share_ways,
        .help = "Hide lights that have a place in the scene by this"),
    OPT(sun.p.adapt, .name = "sun-adapt", IN(SUN), .arg = "F", .hi = 1,
        .needs = GP_NEED_LIGHT, .help = "Dim the picture by F times the "
        "visible share, as the pupil does"),
    OPT(sun.p.cameras, .name = "camera", BOTH(SUN), .arg = "FILE",
        .help = "Read each frame's camera, and the sun's direction where it is "
                "there, from a JSON file"),
    OPT(sun.lights, .name = "lights", BOTH(SUN), .arg = "FILE|auto[:N]",
        .help = "Read suns and lamps from a JSON file; auto takes the N "
                "brightest spots of the frame (32 without N), up to a quarter "
                "of its height wide, for --flare and --lens; one fades from "
                "the threshold to 1.5 times it; names are those of the first "
                "frame; others are new1, new2"),
    OPT(sun.write_lights, .name = "write-lights", IN(SUN), .arg = "FILE",
        .once = true, .aside = true, .help = "Write the lights that auto finds "
        "as JSON, with their places in each frame, to edit and to give to "
        "--lights, which finds these and no others"),
    OPT(sun.p.flare, .name = "flare", BOTH(SUN), .arg = "FILE|preset:NAME",
        .help = "Read lens-flare elements from a JSON file, or take an "
                "installed flare (preset:list names them); each light that has "
                "flux draws them, scaled by its visible share, or every bright "
                "pixel does"),
    LEVEL(sun.p.flare_gain, .name = "flare-gain", BOTH(SUN),
        .needs = GP_NEED_FLARE, .help = "Scale the flare, by a factor or EV; "
        "auto makes its brightest pixel over a dark one a quarter of white, "
        "in each frame; --report says by how much"),
    OPT(lens.lens, .name = "lens", BOTH(SUN), .arg = "FILE|NAME",
        .help = "Add the ghosts of a real lens, a JSON file or an installed "
        "one, which glarepp lens lists: of the lights that have flux, of auto "
        "where none is given, of the 100 brightest groups of sources where "
        "the frame shows none; -k aperture then has the stop of the lens"),
    LEVEL(lens.gain, .name = "lens-gain", BOTH(SUN), .needs = GP_NEED_LENS,
        .help = "Scale the ghosts of the lens, as --flare-gain"),
    OPT(lens.sensor, .name = "sensor-size", BOTH(SUN), .arg = "MM",
        .needs = GP_NEED_LENS, .lo = FLT_MIN, .hi = 1e4, .help = "Width of the "
        "display window on the lens's sensor; without it by --fov or the "
        "frame's camera, else by the frame's attribute "
        "sensorOverallDimensions, else the format that the lens is for"),
    OPT(lens.distance, .name = "focus-distance", BOTH(SUN), .arg = "M",
        .needs = GP_NEED_LENS, .lo = FLT_MIN, .hi = 1e9, .help = "Focus the "
        "lens on this distance in metres; without it by the frame's attribute "
        "focus, else far away"),
    OPT(lens.f_number, .name = "f-number", BOTH(SUN), .arg = "N",
        .needs = GP_NEED_LENS, .lo = 0.1, .hi = 1e4, .help = "Close the lens's "
        "stop to this f-number; without it by the frame's attribute aperture, "
        "else open"),
    OPT(scene.path, .name = "scene", IN(SUN), .arg = "FILE", .help = "Read a "
        "glTF scene (.glb, .gltf), whose lights join the frame's, and whose "
        "camera serves frames that have none"),
    OPT(scene.camera, .name = "scene-camera", .group = GP_GROUP_SUN,
        .commands = GP_COMMAND_MAIN | GP_COMMAND_SETS, .arg = "NAME",
        .needs = GP_NEED_SCENE, .help = "Take this camera of the scene, "
        "by its name or the number of its node; without it, the only one"),
    OPT(scene.start, .name = "scene-start", IN(SUN), .arg = "FRAME",
        .needs = GP_NEED_SCENE, .lo = -1e9, .hi = 1e9, .help = "Start the "
        "scene's time at this frame; a frame is 1/24 s, or as the file's "
        "framesPerSecond says"),
    CHOICE(scene.up, .name = "scene-up", IN(SUN), .arg = "AXIS",
        .needs = GP_NEED_SCENE, .choices = gp_ups, .help = "Turn the scene so "
        "that this axis of the frame's world points up"),
    OPT(scene.light_scale, .name = "light-scale", IN(SUN), .arg = "F",
        .needs = GP_NEED_SCENE, .lo = FLT_MIN, .hi = 1e12, .help = "Give the "
        "scene's lights flux, which is glare of their own and flare: this "
        "much of the frame's unit for a candela or lux, 0.00146413 (1/683) for "
        "Blender"),
    OPT(sun.relight, .name = "relight", IN(SUN), .arg = "NAME|all",
        .needs = GP_NEED_SCENE, .help = "Add the light of this lamp of the "
        "scene to the frame, by its depth, normals and albedo; may be given "
        "more than once"),
    CHOICE(scene.camera_normals, .name = "normal-space", IN(SUN), .arg = "SPACE",
        .needs = GP_NEED_RELIGHT, .choices = gp_spaces, .help = "Axes of the "
        "frame's normals"),
    OPT(scene.lamp_size, .name = "lamp-size", IN(SUN), .arg = "R",
        .needs = GP_NEED_SCENE, .hi = 1e9, .help = "Radius, in the scene's "
        "unit, of lamps whose node has no extras.ball_radius; 0: half a pixel"),
    OPT(input.depth, .name = "depth", BOTH(SUN), .arg = "CH",
        .help = "Read depth from this channel, in any part; without it, from "
                "the first of Z, depth.Z, Depth.Z, *.Depth.Z and *.Z, in the "
                "layer of the colour first (B.Depth.Z with B.Combined); none "
                "reads no depth"),
    OPT(sun.depth_file, .name = "depth-file", BOTH(SUN), .arg = "FILE",
        .needs = GP_NEED_LIGHT,
        .help = "Read depth from this file (or pattern)"),
    CHOICE(sun.p.depth, .name = "depth-type", BOTH(SUN), .arg = "TYPE",
        .choices = gp_depth_types, .help = "Read depth values as this"),
    OPT(sun.mask, .name = "mask", BOTH(SUN), .arg = "CH",
        .needs = GP_NEED_LIGHT, .help = "Hide lights by this coverage channel, "
        "e.g. A: 0 clear to 1 opaque"),
    OPT(sun.mask_file, .name = "mask-file", BOTH(SUN), .arg = "FILE",
        .needs = GP_NEED_LIGHT,
        .help = "Read coverage from this file (or pattern)"),
    OPT(sun.deep, .name = "deep", IN(SUN), .arg = "FILE",
        .needs = GP_NEED_LIGHT, .help = "Hide lights by the alpha that the samples "
        "of this deep EXR (or pattern) have before them, in place of depth and "
        "coverage; without it, by a deep part of the frame's own, unless --depth, "
        "--mask or their files are given"),

    OPT(light.layer.engine, .name = "engine", .letter = 'e', IN(ENGINE),
        .arg = "NAME", .list = gp_engine_name, .help = "Compute the glare layer "
        "with this engine; all make the same layer within their bounds"),
    OPT(light.layer.tolerance, .name = "tolerance", BOTH(ENGINE), .arg = "E",
        .needs = GP_NEED_AUTO, .hi = 1, .help = "Allow auto this error in "
        "rel_l2: the norm of the layer's error over that of the exact layer"),
    OPT(light.layer.tolerance_pixel, .name = "tolerance-pixel", BOTH(ENGINE),
        .arg = "E", .lo = FLT_MIN, .hi = 1, .help = "Allow auto this error in "
        "max_rel: of any pixel of the composite, relative to its luminance "
        "plus 1e-6 of the largest; --report has the bound"),
    OPT(light.layer.group, .name = "group", IN(ENGINE), .arg = "N", .lo = 1,
        .needs = GP_NEED_SPLAT, .hi = 64, .help = "splat: draw NxN pixels as "
        "one polygon; a power of two, 1 for none"),
    OPT(light.layer.cluster, .name = "cluster", IN(ENGINE), .arg = "N",
        .needs = GP_NEED_SPLAT, .hi = 64, .help = "splat: draw filled areas of "
        "NxN pixels as one polygon; a power of two larger than --group, 0 for "
        "none; without it, none where --group is as large"),
    OPT(light.layer.cluster_fill, .name = "cluster-fill", IN(ENGINE),
        .needs = GP_NEED_SPLAT, .arg = "F", .lo = FLT_MIN, .hi = 1,
        .help = "splat: call an area filled from this share of bright pixels"),
    OPT(light.layer.shrink, .name = "shrink", IN(ENGINE), .arg = "E",
        .needs = GP_NEED_SPLAT, .hi = 0.99, .help = "splat: crop polygons "
        "where the kernel's edge is dim, by at most this share of the light; "
        "0 for none"),
    CHOICE(light.layer.gl, .name = "gl", .group = GP_GROUP_ENGINE,
        .commands = GP_COMMAND_MAIN | GP_COMMAND_BENCH | GP_COMMAND_SETS,
        .arg = "API", .choices = gp_gls,
        .help = "Draw splat, sun maps and scenes in this GL context"),
    OPT(run.threads, .name = "threads", ALL(ENGINE), .arg = "N", .hi = 1024,
        .aside = true,
        .help = "Use N threads, 0 for all processors; no output depends on it"),
    OPT(run.frame_jobs, .name = "frame-jobs", IN(INPUT), .arg = "N",
        .hi = GP_FRAME_JOBS, .aside = true,
        .help = "Keep N frames in flight, 1 for one after the other, 0 for 3 "
        "or as many as fit into half of the memory; no output depends on it"),

    OPT(tone.map.curve, .name = "tonemap", BOTH(TONE), .arg = "NAME",
        .needs = GP_NEED_NO_CONFIG, .list = gp_curve_name,
        .help = "Map tones with this operator",
        .usual = "Map tones of -o: neutral, agx, aces, linear"),
    OPT(tone.map.exposure, .name = "exposure", BOTH(TONE), .arg = "EV",
        .lo = -32, .needs = GP_NEED_CURVE, .hi = 32, .help = "Scale the light "
        "by 2^EV before the operator", .usual = "Expose -o: 1 for twice as "
        "bright, -1 for half"),
    OPT(tone.map.auto_exposure, .name = "auto-exposure", BOTH(TONE),
        .needs = GP_NEED_CURVE, .help = "Scale the frame so that its "
        "log-average becomes middle grey, then by --exposure"),
    OPT(tone.map.white, .name = "white", BOTH(TONE), .arg = "W", .hi = FLT_MAX,
        .needs = GP_NEED_TONES | GP_NEED_EXTENDED,
        .help = "reinhard-extended: map this luminance, after exposure, to "
                "white; 0 uses the frame's maximum"),

    OPT(tone.map.config, .name = "ocio", IN(TONE), .arg = "CONFIG",
        .blank = true,
        .help = "Show pictures through a view of this OpenColorIO config, in "
        "place of --tonemap: a file, env for $OCIO, or ocio://NAME for one "
        "built into OpenColorIO 2.2 or later; trust a config as you would a "
        "program"),
    OPT(tone.map.input, .name = "input-space", IN(TONE), .arg = "S",
        .needs = GP_NEED_CONFIG, .help = "Read frames as this colour space or "
        "role of the config; those whose files name other chromaticities are "
        "converted to it; without it, scene_linear"),
    OPT(tone.map.any_primaries, .name = "ignore-chromaticities", IN(TONE),
        .needs = GP_NEED_CONFIG, .help = "Read frames as --input-space even "
        "where their files name other chromaticities"),
    OPT(tone.map.display, .name = "display", IN(TONE), .arg = "D",
        .needs = GP_NEED_CONFIG | GP_NEED_PICTURE,
        .help = "Use this display of the config; without it, its default"),
    OPT(tone.map.view, .name = "view", IN(TONE), .arg = "V",
        .needs = GP_NEED_CONFIG | GP_NEED_PICTURE,
        .help = "Use this OCIO view of the display; without it, its default"),
    OPT(tone.map.look, .name = "look", IN(TONE), .arg = "L",
        .needs = GP_NEED_CONFIG | GP_NEED_PICTURE,
        .help = "Use these looks in place of those of the view: A, or -A,+B"),
    OPT(tone.map.output, .name = "output-space", IN(TONE), .arg = "S",
        .needs = GP_NEED_CONFIG | GP_NEED_HDR, .help = "Convert --hdr to this "
        "colour space of the config, and write its chromaticities"),
    OPT(tone.context, .name = "ocio-context", IN(TONE), .arg = "NAME=VALUE",
        .needs = GP_NEED_CONFIG, .help = "Set a context variable of the "
        "config; may be given more than once"),

    CHOICE(output.write.type, .name = "type", IN(FILE), .arg = "TYPE",
        .choices = gp_types,
        .help = "Write samples of float formats in this type"),
    CHOICE(output.write.compression, .name = "compression", MAKES(FILE),
        .arg = "NAME",
        .choices = gp_compressions, .help = "Compress EXR files this way"),
    CHOICE(output.write.depth_bits, .name = "depth-bits", IN(FILE), .arg = "N",
        .choices = gp_bits,
        .help = "Write samples of PNG and other integer formats with N bits"),
    OPT(output.write.png_level, .name = "png-level", IN(FILE), .arg = "N",
        .hi = GP_PNG_LEVELS, .help = "Pack PNG files so hard: 0 not at all, "
        "1 fast, 12 small and slow"),
    SET(output.write.dither, .name = "dither", IN(FILE),
        .set = GP_DITHER_ALWAYS,
        .help = "Dither integers of 16 bits too, not only those of 8"),
    SET(output.write.dither, .name = "no-dither", IN(FILE),
        .set = GP_DITHER_NEVER,
        .help = "Round to the nearest integer; smooth glows then show bands "
                "in 8 bits"),
    CHOICE(output.write.alpha, .name = "alpha", IN(FILE), .arg = "HOW",
        .choices = gp_alphas, .help = "Write alpha of -o pictures this way"),
    OPT(output.write.no_clobber, .name = "no-clobber", IN(FILE), .aside = true,
        .needs = GP_NEED_FILES, .help = "Skip frames whose outputs already "
        "exist, to resume a run; print how many at the end"),
    OPT(output.write.fsync, .name = "fsync", IN(FILE), .aside = true,
        .needs = GP_NEED_FILES, .help = "Write each output through to the disk "
        "before it gets its name, so that a power cut leaves none that is cut"),
    CHOICE(output.write.stdout_format, .name = "stdout-format", IN(FILE),
        .aside = true, .needs = GP_NEED_STREAM, .arg = "FORMAT",
        .choices = gp_stdout_formats,
        .help = "Write this format to an output that is -"),
    CHOICE(output.write.raw, .name = "raw", IN(FILE), .arg = "FORMAT",
        .needs = GP_NEED_RAW | GP_NEED_STREAM, .choices = gp_raws,
        .aside = true,
        .help = "Pixel format of raw output; implies --stdout-format raw"),
    OPT(output.write.create_dir, .name = "create-dir", MAKES(FILE),
        .aside = true,
        .help = "Make missing folders of output files"),
    OPT(words.settings, .name = "settings", IN(FILE), .aside = true,
        .arg = "FILE", .help = "Read options from this file, one a line, or "
        "from a PNG or EXR that glarepp made; those of the command line rule; "
        "of files given more than once the later rules"),
    OPT(words.save_settings, .name = "save-settings", IN(FILE), .aside = true,
        .arg = "FILE", .once = true, .help = "Write the given options, but "
        "for inputs and outputs, to this file, for --settings"),
    OPT(output.no_provenance, .name = "no-provenance", .group = GP_GROUP_FILE,
        .commands = GP_COMMAND_MAIN | GP_COMMAND_COMPARE, .aside = true,
        .help = "Write no attributes glarepp:* into EXR and PNG files, and "
                "drop those of the input"),

    OPT(run.report, .name = "report", DRAWS(REPORT), .arg = "FILE",
        .once = true,
        .help = "Write JSON, one object a line for each frame; - is stdout"),
    OPT(run.verify, .name = "verify", IN(REPORT), .needs = GP_NEED_REPORT,
        .help = "Measure the layer's error against the exact sum in double; "
                "slow; shown by --report and -v"),
    OPT(run.fixation, .name = "fixation", IN(REPORT), .needs = GP_NEED_REPORT,
        .arg = "X,Y", .least = 2, .most = 2, .lo = -1e6, .hi = 1e6,
        .help = "Let the eye look at this pixel, for the report's veil; "
                "without it the middle"),
    OPT(run.luminance_scale, .name = "luminance-scale", IN(REPORT),
        .arg = "CD", .hi = 1e9, .pixels = true,
        .help = "Take 1 as so many cd/m2, for the report's veil and for pupils "
                "that adapt; 0 takes the file's whiteLuminance"),
    CHOICE(run.progress, .name = "progress", IN(REPORT), .arg = "WHEN",
        .choices = gp_progresses,
        .help = "Print frame, rate and time left to stderr"),
    SET(run.level, .name = "quiet", .letter = 'q', ALL(REPORT),
        .set = GP_LEVEL_ERROR, .help = "Print errors only"),
    SET(run.level, .name = "verbose", .letter = 'v', ALL(REPORT),
        .set = GP_LEVEL_INFO, .help = "Say of each frame what was used, and "
        "why"),

    OPT(making.size, .name = "size", .group = GP_GROUP_KERNEL,
        .commands = GP_COMMAND_KERNEL | GP_COMMAND_SETS, .arg = "WxH",
        .help = "Make it for frames of this size, without it 1920x1080; sets: "
        "draw pictures of this size, without it 960x540"),
    OPT(making.radius, .name = "radius", KERNEL, .arg = "N", .hi = 16383,
        .help = "Make only offsets up to N pixels, 0 for all"),
    OPT(making.frame, .name = "frame", KERNEL, .arg = "N", .lo = -1e9,
        .hi = 1e9, .help = "Make models that change in time for this frame"),
    OPT(making.check, .name = "check", .group = GP_GROUP_KERNEL,
        .commands = GP_COMMAND_KERNEL | GP_COMMAND_LENS, .arg = "FILE|NAME",
        .help = "Print the figures and faults of a kernel, or of a lens "
        "against what it claims; exit 1 on a fault"),
    OPT(making.list, .name = "list", .group = GP_GROUP_KERNEL,
        .commands = GP_COMMAND_KERNEL | GP_COMMAND_LENS,
        .help = "Print the models, their keys with ranges, and the presets; "
        "or the installed lenses"),
    OPT(making.draw, .name = "draw", OPTICS, .arg = "FILE", .once = true,
        .help = "Draw the lens of --check with the rays of its brightest "
        "ghost, as SVG; - is stdout"),

    OPT(sets.seconds, .name = "time", SETS, .arg = "SECONDS", .lo = -1e9,
        .hi = 1e9, .help = "Draw the scene at this time of its animation; "
        "without it, at its first key"),
    OPT(sets.map, .name = "shadow-size", SETS, .arg = "N", .lo = 8,
        .hi = 4096, .help = "Draw maps of shadows with N texels a side, six "
        "such squares for a point light"),
    OPT(sets.separate, .name = "separate-shadows", SETS,
        .help = "Draw a shadow batch for each material of an object, in place "
        "of one for all that is opaque"),
    OPT(sets.occluders, .name = "occluders", SETS, .arg = "N", .hi = 1000000,
        .help = "Draw the N objects that look largest first, to find by their "
        "depth which others are hidden"),

    OPT(bench.csv, .name = "csv", BENCH, .arg = "FILE", .once = true,
        .help = "Write the table as comma-separated values; - is stdout"),
    OPT(bench.json, .name = "json", .group = GP_GROUP_REPORT,
        .commands = GP_COMMAND_BENCH | GP_COMMAND_COMPARE | GP_COMMAND_SETS,
        .arg = "FILE", .once = true, .help = "bench, sets: write the table as "
        "JSON; compare: write one object a line for each pair; - is stdout"),
    OPT(bench.plot, .name = "plot", BENCH, .arg = "FILE", .once = true,
        .help = "Draw error over time with the Pareto front, as SVG"),
    OPT(bench.paper, .name = "paper", BENCH, .needs = GP_NEED_OWN_FRAMES |
        GP_NEED_NO_LIGHT, .help = "Measure three generated frames like the "
        "paper's: few points, windows, and a sky that fills the frame"),
    OPT(bench.runs, .name = "runs", .group = GP_GROUP_REPORT,
        .commands = GP_COMMAND_BENCH | GP_COMMAND_SETS, .arg = "N", .lo = 1,
        .hi = GP_BENCH_RUNS, .help = "bench: time each row N times; the table has the "
        "median; sets: the fastest, of 3 without it"),

    // idiff's, which may be written with one dash
    OPT(compare.limits.fail, .name = "fail", COMPARE, .arg = "E", .hi = INFINITY,
        .help = "Fail pixels with a value whose error is over E"),
    OPT(compare.limits.fail_relative, .name = "failrelative", COMPARE, .arg = "F",
        .hi = INFINITY, .help = "Fail only values whose error is also over F "
        "times the mean of both magnitudes"),
    OPT(compare.limits.fail_percent, .name = "failpercent", COMPARE, .arg = "P",
        .hi = INFINITY, .help = "Allow this percentage of pixels to fail"),
    OPT(compare.limits.allow_failures, .name = "allowfailures", COMPARE, .arg = "N",
        .lo = -1, .hi = INT32_MAX,
        .help = "Allow N pixels to fail by any amount, -1: any number"),
    OPT(compare.limits.hard_fail, .name = "hardfail", COMPARE, .arg = "E",
        .hi = INFINITY, .help = "Fail if any error is over E, whatever "
        "--failpercent allows"),
    OPT(compare.limits.warn, .name = "warn", COMPARE, .arg = "E", .hi = INFINITY,
        .help = "Warn of pixels with a value whose error is over E, where "
                "pixels fail but not too many"),
    OPT(compare.limits.warn_relative, .name = "warnrelative", COMPARE, .arg = "F",
        .hi = INFINITY, .help = "Warn only of values whose error is also over "
        "F times the mean of both magnitudes"),
    OPT(compare.limits.warn_percent, .name = "warnpercent", COMPARE, .arg = "P",
        .hi = INFINITY,
        .help = "Allow this percentage of pixels to be over --warn"),
    OPT(compare.limits.hard_warn, .name = "hardwarn", COMPARE, .arg = "E",
        .hi = INFINITY, .help = "Warn if any error is over E, whatever "
        "--warnpercent allows"),
    OPT(compare.limits.perceptual, .name = "perceptual", .letter = 'p', COMPARE,
        .help = "Fail pixels whose difference an eye sees (Yee's metric), in "
                "place of --fail and --warn"),
    OPT(compare.all_parts, .name = "all", .letter = 'a', COMPARE,
        .help = "Compare all parts; without it, the first of each file"),
    OPT(compare.difference, .name = "difference", .letter = 'o', COMPARE,
        .arg = "FILE", .aside = true, .help = "Write A - B as a picture, with "
        "--all of the first part; the ending picks the format"),
    OPT(compare.only_different, .name = "od", COMPARE,
        .help = "Write --difference only where the images differ"),
    OPT(compare.absolute, .name = "abs", COMPARE,
        .help = "Write |A - B| to --difference"),
    OPT(compare.scale, .name = "scale", COMPARE, .arg = "F", .lo = -FLT_MAX,
        .hi = FLT_MAX, .help = "Multiply --difference by F"),
    OPT(compare.limits.fail_rel, .name = "fail-rel", COMPARE, .arg = "E",
        .hi = INFINITY, .help = "Fail where rel_l2, the norm of A - B over "
        "that of A, is over E; --fail has no default then"),
    OPT(compare.limits.fail_flip, .name = "fail-flip", COMPARE, .arg = "F", .hi = 1,
        .help = "Fail where the mean FLIP is over F; --fail has no default "
                "then"),
    OPT(compare.flip_exposures, .name = "flip-exposures", COMPARE,
        .arg = "START,STOP,COUNT", .least = 3, .most = 3, .lo = -64, .hi = 64,
        .help = "Compute HDR-FLIP at these exposures in EV; without it, at "
                "those that fit the first image"),
    OPT(compare.limits.flip, .name = "no-flip", COMPARE, .off = true,
        .help = "Leave out FLIP, which takes most of the time"),
    OPT(compare.heatmap, .name = "heatmap", COMPARE, .arg = "FILE",
        .aside = true, .help = "Write a picture of FLIP at each pixel: magma, "
        "black 0 to pale yellow 1"),

    OPT(page.html, .name = "html", .group = GP_GROUP_REPORT,
        .commands = GP_COMMAND_BENCH | GP_COMMAND_COMPARE, .arg = "FILE",
        .once = true, .help = "Write a page to look at: the pictures over each "
        "other, where they differ, and the figures, in one file; compare: of "
        "all frames, or one for each with a pattern"),
    OPT(page.index, .name = "html-index", COMPARE, .arg = "FILE", .once = true,
        .aside = true, .help = "Write a page that lists the pages of --html, which is a "
        "pattern"),
    OPT(page.megabytes, .name = "html-size", .group = GP_GROUP_REPORT,
        .commands = GP_COMMAND_BENCH | GP_COMMAND_COMPARE | GP_COMMAND_STYLES,
        .arg = "MB", .lo = 0.1, .hi = 1000, .aside = true, .help = "Make pages "
        "of up to this size: beyond a region of whole pixels they have averages; "
        "styles, bench: without it 1.5 a picture"),

    OPT(words.version, .name = "version", ALL(GENERAL),
        .help = "Print the versions of the program and its libraries"),
    OPT(words.help, .name = "help", .letter = 'h', .group = GP_GROUP_GENERAL,
        .commands = ~0u, .arg = "[TOPIC]", .choices = gp_topics, .open = true,
        .blank = true, .optional = true, .help = "Print help: one screen, "
        "a command's own, a topic of glarepp help"),
    OPT(words.help_table, .name = "help-table", IN(GENERAL)),
    {0},
};
// clang-format on
