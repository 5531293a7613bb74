// SPDX-License-Identifier: Apache-2.0
#include "cli/options.h"

#include <float.h>

// clang-format off
#define FIELD(f) (&((struct gp_settings *) 0)->f)
#define ROW(f, kind_of_f, label, ...)                                         \
    {.at = offsetof(struct gp_settings, f), .kind = kind_of_f, .name = label, \
     __VA_ARGS__}

/* A row: the field, whose type gives the kind; the option's name; its heading and
 * commands; the name of its value, NULL: it takes none; its line of help; and what
 * else it has. OPT is a number, flag, pair or free text. */
#define OPT(f, label, where, value, text, ...) \
    ROW(f, _Generic(FIELD(f), bool *: GP_KIND_FLAG, float *: GP_KIND_FLOAT,   \
                    double *: GP_KIND_REAL,                                   \
                    struct glarepp_sense_params *: GP_KIND_THRESHOLD,         \
                    struct glarepp_kernel_params *: GP_KIND_SIZE,             \
                    int *: GP_KIND_INT, long long *: GP_KIND_COUNT,           \
                    struct gp_numbers *: GP_KIND_NUMBERS,                     \
                    const char **: GP_KIND_TEXT,                              \
                    struct gp_texts *: GP_KIND_TEXTS,                         \
                    const char *(*)[GP_DEBUG_KINDS]: GP_KIND_NAMED),          \
        label, where, .arg = value, .help = text, __VA_ARGS__)

/* CHOICE: an enum, int or bool by the names of ONE_OF(). SET: an enum, set to
 * `set` by an option without a value. LEVEL: a factor, in EV too, or auto. */
#define CHOICE(f, label, where, value, text, ...) \
    ROW(f, _Generic(FIELD(f), unsigned *: GP_KIND_CHOICE,                     \
                    int *: GP_KIND_CHOICE, bool *: GP_KIND_EITHER),           \
        label, where, .arg = value, .help = text, __VA_ARGS__)
#define SET(f, label, where, text, ...) \
    ROW(f, _Generic(FIELD(f), unsigned *: GP_KIND_SET),                       \
        label, where, .help = text, __VA_ARGS__)
#define LEVEL(f, label, where, text, ...) \
    ROW(f, _Generic(FIELD(f), float *: GP_KIND_LEVEL),                        \
        label, where, .arg = "G|EVev|auto", .help = text, .hi = 1e9,          \
        __VA_ARGS__)

/* Values by name: what the field gets, and a line about it. */
#define ONE_OF(...)                                                           \
    .choices = (const struct gp_option_choice[]) {__VA_ARGS__, {0}}
#define STREAM(value, ending, text) {ending, GP_STDOUT_##value, text},

/* Heading and commands of an option; of one command, which has the heading's
 * name. */
#define IN(g, bits) .group = GP_GROUP_##g, .commands = bits
#define OWN(g) IN(g, GP_COMMAND_##g)
enum {
    MAIN = GP_COMMAND_MAIN, BENCH = GP_COMMAND_BENCH,
    COMPARE = GP_COMMAND_COMPARE, KERNEL = GP_COMMAND_KERNEL,
    LENS = GP_COMMAND_LENS, SETS = GP_COMMAND_SETS, STYLES = GP_COMMAND_STYLES,
    DRAWS = MAIN | STYLES, BOTH = DRAWS | BENCH, GLARES = BOTH | KERNEL,
    ALL = GLARES | COMPARE | SETS,
};

const struct gp_option gp_options[] = {
    OPT(output.pictures, "output", IN(OUTPUT, MAIN | KERNEL | SETS | STYLES),
        "FILE", "Write a tone-mapped picture, the kernel as EXR floats, the "
        "scene's picture or the sheet of styles; the ending picks the format; "
        "may be given more than once", .letter = 'o',
        .usual = "Write a picture, tone-mapped: .png .jpg .tif"),
    OPT(output.hdr, "hdr", IN(OUTPUT, MAIN), "FILE",
        "Write a scene-linear EXR with glare; all other channels and "
        "attributes of the input pass through; may be given more than once",
        .usual = "Write an EXR: the frame with glare, linear light"),
    OPT(output.layer, "layer", IN(OUTPUT, MAIN), "FILE",
        "Write the glare layer only, scene-linear; may be given more than once",
        .usual = "Write an EXR: only the glare, to add in comp"),
    OPT(output.parts, "parts", IN(OUTPUT, MAIN), "FILE",
        "Write the parts of --layer, which add up to it, as layers of one EXR, "
        "of floats without --type: veil is light that leaves its pixel, core "
        "what stays, flare the elements of --flare, ghosts those of --lens; "
        "what a --light-group spreads is in a layer of its name instead"),
    OPT(output.grow, "grow", IN(OUTPUT, MAIN), "PIXELS",
        "Extend outputs beyond the union of data and display window, by PIXELS "
        "on each side", .open = true, .pixels = true, ONE_OF(
        {"kernel", 0, "as far as the kernel reaches"},
        {"none", 0,
         "outputs keep the data window, and glare ends at its edges"})),
    OPT(output.debug, "debug", IN(OUTPUT, MAIN | SETS), "KIND=FILE",
        "Write a picture of an intermediate step", ONE_OF(
        {"sensors", GP_DEBUG_SENSORS,
         "the light that the engines spread, scene-linear"},
        {"polygons", GP_DEBUG_POLYGONS, "outlines of the polygons that splat "
         "draws, in green over the tone-mapped picture"},
        {"sunmap", GP_DEBUG_SUNMAP, "the sun map of each light, white where it "
         "is clear, beside the picture there"},
        {"intensity", GP_DEBUG_INTENSITY,
         "the share of each light as a grey, beside the picture there"},
        {"scissor", GP_DEBUG_SCISSOR,
         "glarepp sets: the picture with outlines of the lights' scissors"},
        {"sets", GP_DEBUG_SETS,
         "glarepp sets: the scene from above; objects are grey in no set, blue "
         "hidden, red casting shadows, green visible, yellow lit"})),

    OPT(input.frames, "frames", IN(INPUT, MAIN | COMPARE), "LIST",
        "Read these frames of a pattern: 1-100, 1-100x2 (or 1-100:2), "
        "3,4,10-20x2 or 5-1; without it, all that exist on disk", .letter = 'f',
        .aside = true),
    OPT(input.views, "views", IN(INPUT, MAIN), "LIST",
        "Make these stereo views: by %V or %v (first letter) in input names, "
        "where the default is left,right; else views inside each input, where "
        "the default is all, and outputs without %V show the first"),
    OPT(input.skip_bad_frames, "skip-bad-frames", IN(INPUT, MAIN), NULL,
        "Skip frames that fail, list them at the end, exit 6", .aside = true),
    OPT(input.read.layer, "layer-in", IN(INPUT, BOTH), "NAME",
        "Read the colour from this EXR layer: NAME.R,G,B, a part called NAME, "
        "or right.NAME in the view right; without it, from the first that has "
        "colour"),
    OPT(input.read.part, "part", IN(INPUT, BOTH), "NAME|N", "Read the colour "
        "from this part of a multi-part file, by name or number from 0"),
    OPT(input.light_groups, "light-group", IN(INPUT, MAIN),
        "NAME[:kernel=K,gain=G]", "Spread the light of this EXR layer in place "
        "of the frame's own; may be given more than once; --hdr adds to each "
        "layer its own glare; a colon may be followed by a kernel, a word of "
        "--kernel, and a gain, 0 to 1e6, which --layer has too"),
    OPT(input.read.max_pixels, "max-pixels", IN(INPUT, ALL), "N",
        "Refuse files whose data or display window has more than N pixels; in "
        "files other than EXR, every four channels of a pixel count as one "
        "pixel", .lo = 1, .hi = 1LL << 40, .aside = true),

    OPT(light.style, "style", IN(LIGHT, MAIN | BENCH | KERNEL), "NAME",
        "Set kernels, threshold, mix, flare and lens together, but for those "
        "that are given", .list = gp_style_name,
        .usual = "Look like this: glarepp styles lists them"),
    OPT(light.sense, "threshold", IN(LIGHT, BOTH), "T|P%|EVev",
        "Treat pixels over this luminance as light sources: a number, a "
        "percentile such as 99.9%, or EV over the log-average such as +3ev",
        .letter = 't', .hi = FLT_MAX,
        .usual = "Let pixels over this luminance glare"),
    CHOICE(light.sense.whole, "threshold-mode", IN(LIGHT, BOTH), "HOW",
        "Spread this part of a light source", ONE_OF(
        {"excess", false, "the part of its luminance Y that is over T: its "
         "colour times (Y - T) / Y"},
        {"whole", true, "all of its colour, as the sensors of Ando et al.; the "
         "picture has a step at the threshold"})),
    OPT(light.sense.knee, "knee", IN(LIGHT, BOTH), "K",
        "Ramp --threshold-mode whole smoothly from T(1-K) to T(1+K)", .hi = 1),
    OPT(light.sense.max_value, "max-value", IN(LIGHT, BOTH), "V",
        "Clamp brighter pixels: scale them so that their largest channel is V, "
        "which keeps their hue; 0 clamps none", .hi = FLT_MAX),
    OPT(light.mask, "source-mask", IN(LIGHT, MAIN),
        "FILE|CH|crypto:NAMES", "Let pixels glare by the share that this "
        "channel of the frame has, or else this file (or pattern): its A, its "
        "only channel or its R, 0 to 1; or by the coverage of Cryptomatte's "
        "objects NAME,NAME, in which * and ? match any text and character, and "
        "\\ quotes what follows; ! before all of it inverts"),
    OPT(light.source, "source", IN(LIGHT, MAIN), "FILE",
        "Spread the light of this frame (or pattern), which has the same data "
        "window, in place of the frame's own, and add it: --mix is add, and "
        "what the kernel leaves in its pixel is added too"),
    OPT(kernel.words, "kernel", IN(LIGHT, GLARES), "FILE",
        "Point-spread function, without it the style's: an image file or a "
        "model and its keys, as MODEL:key=value,key=value; several add up by "
        "their shares", .letter = 'k', .list = gp_kernel_word, .open = true,
        .usual = "Shape the glare; glarepp kernel --list has shapes"),
    OPT(plan.fov, "fov", IN(LIGHT, GLARES), "DEG",
        "Vertical angle of view of the display window, by which models have "
        "their size; without it the frame's camera, else 30, of a fisheye 180",
        .lo = 0.001, .hi = 360, .usual = "Set the vertical angle of view"),
    CHOICE(plan.projection, "projection", IN(LIGHT, BOTH), "HOW",
        "Take the angles of the frame's pixels so; kernel images, and models "
        "with rays or edges, are the same everywhere by either", ONE_OF(
        {"auto", GLAREPP_OF_FRAME, "as the frame says: latlong by its envmap "
         "attribute, else perspective"},
        {"plane", GLAREPP_PLANE,
         "proportional to pixels, of a picture of no camera"},
        {"perspective", GLAREPP_PERSPECTIVE, "as a camera sees them, by its "
         "matrices, else by --fov, else 30 degrees: a kernel is narrower and "
         "stretched towards the border, as on film"},
        {"latlong", GLAREPP_LATLONG, "the whole sphere, as an environment: "
         "what leaves at one side comes in at the other"},
        {"fisheye", GLAREPP_FISHEYE,
         "equidistant, of --fov, else 180 degrees; beyond them is nothing"},
        {"equisolid", GLAREPP_EQUISOLID,
         "a fisheye of pixels of one solid angle"})),
    OPT(kernel.p, "kernel-size", IN(LIGHT, GLARES), "PCT|DEGdeg",
        "Resample kernel images by areas: 50 or 50% for half as many pixels, "
        "2deg for a height of 2 degrees of view"),
    OPT(kernel.centre, "kernel-center", IN(LIGHT, BOTH), "X,Y",
        "Set the kernel's centre, in its own pixels (0.5,0.5 is the centre of "
        "the first); without it, the centre of pixel (w/2, h/2) rounded down",
        .lo = -1e6, .hi = 1e6, .least = 2, .most = 2),
    CHOICE(kernel.normalize, "kernel-normalize", IN(LIGHT, BOTH), "HOW",
        "Scale the kernel; without it, a file of glarepp kernel is used as it "
        "is", ONE_OF(
        {"luminance", GP_NORMALIZE_LUMINANCE,
         "so that the luminance of its sum is 1; channels keep their ratios"},
        {"none", GP_NORMALIZE_NONE, "not at all: use the values of the file"})),
    OPT(plan.rotate, "rotate", IN(LIGHT, GLARES), "DEG", "Rotate the kernel "
        "about its centre, counter-clockwise", .lo = -36000, .hi = 36000),
    OPT(light.layer.gain, "gain", IN(LIGHT, BOTH), "G",
        "Scale the glare in pictures and --hdr, not in --layer; with --mix "
        "scatter, 1 moves all light of the sources, and more than 1 only "
        "brightens the glare", .letter = 'g', .hi = 1e6,
        .usual = "Scale the glare: 0.5 for half of it"),
    OPT(light.tint, "tint", IN(LIGHT, DRAWS), "R,G,B",
        "Multiply the channels of the glare by these, with flare and lens, in "
        "--layer too; what scatters leaves the sources in its own colour",
        .hi = 1e6, .least = 3, .most = 3),
    OPT(light.layer.saturation, "layer-saturation", IN(LIGHT, DRAWS), "S",
        "Saturate the glare before --tint: 0 makes it grey, 2 doubles its "
        "distance from grey, and less than 0 becomes 0; in --layer too",
        .hi = 10),
    CHOICE(light.layer.mix, "mix", IN(LIGHT, GLARES), "HOW",
        "Combine frame and layer this way", ONE_OF(
        {"scatter", GLAREPP_SCATTER, "add the layer and subtract its light "
         "from the sources, which conserves energy; a gain over 1 adds light"},
        {"add", GLAREPP_ADD, "add the layer to the frame"})),
    CHOICE(light.layer.edges, "edges", IN(LIGHT, DRAWS), "HOW",
        "Continue the picture beyond its border this way", ONE_OF(
        {"extend", GLAREPP_EXTEND, "with the broad light of its border, "
         "without lamps; the default with --mix scatter"},
        {"mirror", GLAREPP_MIRROR, "with its mirror image, a quarter of its "
         "shorter side wide, then as extend; takes up to twice the time"},
        {"black", GLAREPP_BLACK, "not at all: light that leaves the picture is "
         "lost; the default with --mix add"})),

    OPT(sun.at, "sun", IN(SUN, BOTH), "X,Y[,R]", "Place the sun: centre and "
        "radius in pixels (radius 0.5 if omitted); bench then prints its table "
        "of visibility", .lo = -1e6, .hi = 1e6, .least = 2, .most = 3),
    OPT(sun.dir, "sun-dir", IN(SUN, BOTH), "X,Y,Z", "Place the sun by its "
        "direction in the world, from the scene to the sun, and the frame's "
        "worldToNDC matrix or --camera", .needs = GP_NEED_NO_PLACE, .lo = -1e9,
        .hi = 1e9, .least = 3, .most = 3),
    OPT(sun.p.degrees, "sun-size", IN(SUN, BOTH), "DEG",
        "Set the sun's diameter in degrees, for --sun-dir and --camera",
        .needs = GP_NEED_LIGHT, .lo = FLT_MIN, .hi = 90),
    OPT(sun.color, "sun-color", IN(SUN, MAIN), "R,G,B", "Set the sun's flux, "
        "scene-linear, summed over pixels, of a lat-long or fisheye as many as "
        "it has in the middle (one number: grey): it adds glare of its own and "
        "lights the flare; without it, only the frame's bright "
        "pixels glare", .needs = GP_NEED_LIGHT | GP_NEED_SUN, .hi = 1e12,
        .least = 1, .most = 3),
    OPT(sun.p.in_frame, "sun-in-frame", IN(SUN, MAIN), NULL,
        "Treat lights as already drawn in the frame, whose bright pixels "
        "glare: their flux lights only the flare", .needs = GP_NEED_LIGHT),
    CHOICE(sun.p.method, "sun-method", IN(SUN, BOTH), "HOW", "Find the visible "
        "share of a light this way", .needs = GP_NEED_LIGHT, ONE_OF(
        {"exact", GLAREPP_EXACT, "the area of every pixel under the disc, in "
         "double, on the CPU; no GL"},
        {"mask", GLAREPP_MASK, "Maughan's texture masking on GL: a sun map of "
         "samples, added up in a pixel"},
        {"readback", GLAREPP_READBACK, "read the region under the light back "
         "from GL and count its clear pixels"})),
    OPT(sun.p.side, "sun-map", IN(SUN, BOTH), "N",
        "mask: make sun maps of NxN texels; even",
        .needs = GP_NEED_LIGHT | GP_NEED_MAP, .lo = 2, .hi = 256),
    CHOICE(sun.p.square, "sun-pattern", IN(SUN, BOTH), "WHAT",
        "mask: sample this area", .needs = GP_NEED_LIGHT | GP_NEED_MAP, ONE_OF(
        {"disc", false, "equal-area samples of the disc"},
        {"square", true, "the square around it, as in the paper"})),
    CHOICE(sun.p.bytes, "sun-sum", IN(SUN, BOTH), "HOW", "mask: sum texels "
        "this way", .needs = GP_NEED_LIGHT | GP_NEED_MASK, ONE_OF(
        {"float", false, "every texel, in float"},
        {"8bit", true, "in 8 bits, 1/255 a texel, as in the paper"})),
    CHOICE(sun.p.outside, "sun-outside", IN(SUN, BOTH), "HOW",
        "Count the part of a light outside the frame this way",
        .needs = GP_NEED_LIGHT, ONE_OF(
        {"ignore", GLAREPP_IGNORE, "measure only the part inside"},
        {"visible", GLAREPP_VISIBLE, "as visible, with its glare and flare"},
        {"hidden", GLAREPP_HIDDEN, "as hidden"},
        {"scene", GLAREPP_BY_SCENE, "as the objects of --scene hide it, also "
         "behind the camera; the default with --scene"})),
    CHOICE(sun.p.share_by, "sun-share", IN(SUN, MAIN), "HOW",
        "Hide lights that have a place in the scene by this",
        .needs = GP_NEED_LIGHT | GP_NEED_SCENE, ONE_OF(
        {"auto", GLAREPP_SHARES_AUTO, "the scene, if it has objects and "
         "--sun-method is exact; else the frame"},
        {"depth", GLAREPP_SHARES_FRAME, "in the frame, its depth and coverage, or "
         "deep samples"},
        {"scene", GLAREPP_SHARES_SCENE,
         "rays through the scene; a warning names a light whose share by the "
         "frame is another"})),
    OPT(sun.p.adapt, "sun-adapt", IN(SUN, MAIN), "F",
        "Dim the picture by F times the visible share, as the pupil does",
        .needs = GP_NEED_LIGHT, .hi = 1),
    OPT(sun.p.cameras, "camera", IN(SUN, BOTH), "FILE", "Read each frame's "
        "camera, and the sun's direction where it is there, from a JSON file"),
    OPT(sun.lights, "lights", IN(SUN, BOTH), "FILE|auto[:N]",
        "Read suns and lamps from a JSON file; auto takes the N brightest "
        "spots of the frame (32 without N), up to a quarter of its height "
        "wide, for --flare and --lens; one fades from the threshold to 1.5 "
        "times it; names are those of the first frame; others are new1, new2"),
    OPT(sun.write_lights, "write-lights", IN(SUN, MAIN), "FILE",
        "Write the lights that auto finds as JSON, with their places in each "
        "frame, to edit and to give to --lights, which finds these and no "
        "others", .once = true, .aside = true),
    OPT(sun.p.flare, "flare", IN(SUN, BOTH), "FILE|preset:NAME",
        "Read lens-flare elements from a JSON file, or take an installed flare "
        "(preset:list names them); each light that has flux draws them, scaled "
        "by its visible share, or every bright pixel does"),
    LEVEL(sun.p.flare_gain, "flare-gain", IN(SUN, BOTH),
        "Scale the flare, by a factor or EV; auto makes its brightest pixel "
        "over a dark one a quarter of white, in each frame; --report says by "
        "how much", .needs = GP_NEED_FLARE),
    OPT(lens.lens, "lens", IN(SUN, BOTH), "FILE|NAME",
        "Add the ghosts of a real lens, a JSON file or an installed one, which "
        "glarepp lens lists: of the lights that have flux, of auto where none "
        "is given, of the 100 brightest groups of sources where the frame "
        "shows none; -k aperture then has the stop of the lens"),
    LEVEL(lens.gain, "lens-gain", IN(SUN, BOTH),
        "Scale the ghosts of the lens, as --flare-gain", .needs = GP_NEED_LENS),
    OPT(lens.sensor, "sensor-size", IN(SUN, BOTH), "MM",
        "Width of the display window on the lens's sensor; without it by --fov "
        "or the frame's camera, else by the frame's attribute "
        "sensorOverallDimensions, else the format that the lens is for",
        .needs = GP_NEED_LENS, .lo = FLT_MIN, .hi = 1e4),
    OPT(lens.distance, "focus-distance", IN(SUN, BOTH), "M",
        "Focus the lens on this distance in metres; without it by the frame's "
        "attribute focus, else far away", .needs = GP_NEED_LENS, .lo = FLT_MIN,
        .hi = 1e9),
    OPT(lens.f_number, "f-number", IN(SUN, BOTH), "N", "Close the lens's stop "
        "to this f-number; without it by the frame's attribute aperture, else "
        "open", .needs = GP_NEED_LENS, .lo = 0.1, .hi = 1e4),
    OPT(scene.path, "scene", IN(SUN, MAIN), "FILE",
        "Read a glTF scene (.glb, .gltf), whose lights join the frame's, and "
        "whose camera serves frames that have none"),
    OPT(scene.camera, "scene-camera", IN(SUN, MAIN | SETS), "NAME",
        "Take this camera of the scene, by its name or the number of its node; "
        "without it, the only one", .needs = GP_NEED_SCENE),
    OPT(scene.start, "scene-start", IN(SUN, MAIN), "FRAME", "Start the scene's "
        "time at this frame; a frame is 1/24 s, or as the file's "
        "framesPerSecond says", .needs = GP_NEED_SCENE, .lo = -1e9, .hi = 1e9),
    CHOICE(scene.up, "scene-up", IN(SUN, MAIN), "AXIS",
        "Turn the scene so that this axis of the frame's world points up",
        .needs = GP_NEED_SCENE, ONE_OF(
        {"auto", GLAREPP_UP_AUTO, "the axis by which the scene's camera is "
         "nearer to the frame's; without one, the axis nearer to the picture's "
         "upright; of a frame without a camera y, and for --relight the one by "
         "which its normals fit its depth"},
        {"y", GLAREPP_UP_Y, "y, as in glTF"},
        {"z", GLAREPP_UP_Z, "z, as in Blender"})),
    OPT(scene.light_scale, "light-scale", IN(SUN, MAIN), "F",
        "Give the scene's lights flux, which is glare of their own and flare: "
        "this much of the frame's unit for a candela or lux, 0.00146413 "
        "(1/683) for Blender", .needs = GP_NEED_SCENE, .lo = FLT_MIN,
        .hi = 1e12),
    OPT(sun.relight, "relight", IN(SUN, MAIN), "NAME|all", "Add the light of "
        "this lamp of the scene to the frame, by its depth, normals and "
        "albedo; may be given more than once", .needs = GP_NEED_SCENE),
    CHOICE(scene.camera_normals, "normal-space", IN(SUN, MAIN), "SPACE",
        "Axes of the frame's normals", .needs = GP_NEED_RELIGHT, ONE_OF(
        {"world", false, "those of the frame's world"},
        {"camera", true,
         "x right, y up, z to the eye, whatever worldToCamera has"})),
    OPT(scene.lamp_size, "lamp-size", IN(SUN, MAIN), "R", "Radius, in the "
        "scene's unit, of lamps whose node has no extras.ball_radius; 0: half "
        "a pixel", .needs = GP_NEED_SCENE, .hi = 1e9),
    OPT(input.depth, "depth", IN(SUN, BOTH), "CH",
        "Read depth from this channel, in any part; without it, from the first "
        "of Z, depth.Z, Depth.Z, *.Depth.Z and *.Z, in the layer of the colour "
        "first (B.Depth.Z with B.Combined); none reads no depth"),
    OPT(sun.depth_file, "depth-file", IN(SUN, BOTH), "FILE",
        "Read depth from this file (or pattern)", .needs = GP_NEED_LIGHT),
    CHOICE(sun.p.depth, "depth-type", IN(SUN, BOTH), "TYPE",
        "Read depth values as this", ONE_OF(
        {"z", GLAREPP_Z, "distance along the view axis"},
        {"ray", GLAREPP_RAY, "distance from the camera"},
        {"inverse", GLAREPP_INVERSE, "1 / z; 0 is empty"},
        {"normalized", GLAREPP_NORMALIZED,
         "0 near to 1 far, or 1 near to 0 far where the background is 0"})),
    OPT(sun.mask, "mask", IN(SUN, BOTH), "CH", "Hide lights by this coverage "
        "channel, e.g. A: 0 clear to 1 opaque", .needs = GP_NEED_LIGHT),
    OPT(sun.mask_file, "mask-file", IN(SUN, BOTH), "FILE",
        "Read coverage from this file (or pattern)", .needs = GP_NEED_LIGHT),
    OPT(sun.deep, "deep", IN(SUN, MAIN), "FILE",
        "Hide lights by the alpha that the samples of this deep EXR (or "
        "pattern) have before their depth less its \"bias\", in place of depth "
        "and coverage; without it, by a deep part of the frame's own, unless "
        "--depth, --mask or their files are given", .needs = GP_NEED_LIGHT),

    OPT(light.layer.engine, "engine", IN(ENGINE, MAIN), "NAME",
        "Compute the glare layer with this engine; all make the same layer "
        "within their bounds", .letter = 'e', .list = gp_engine_name),
    OPT(light.layer.tolerance, "tolerance", IN(ENGINE, BOTH), "E",
        "Allow auto this error in rel_l2: the norm of the layer's error over "
        "that of the exact layer", .needs = GP_NEED_AUTO, .hi = 1),
    OPT(light.layer.tolerance_pixel, "tolerance-pixel", IN(ENGINE, BOTH), "E",
        "Allow auto this error in max_rel: of any pixel of the composite, "
        "relative to its luminance plus 1e-6 of the largest; --report has the "
        "bound", .lo = FLT_MIN, .hi = 1),
    OPT(light.layer.group, "group", IN(ENGINE, MAIN), "N",
        "splat: draw NxN pixels as one polygon; a power of two, 1 for none",
        .needs = GP_NEED_SPLAT, .lo = 1, .hi = 64),
    OPT(light.layer.cluster, "cluster", IN(ENGINE, MAIN), "N",
        "splat: draw filled areas of NxN pixels as one polygon; a power of two "
        "larger than --group, 0 for none; without it, none where --group is as "
        "large", .needs = GP_NEED_SPLAT, .hi = 64),
    OPT(light.layer.cluster_fill, "cluster-fill", IN(ENGINE, MAIN), "F",
        "splat: call an area filled from this share of bright pixels",
        .needs = GP_NEED_SPLAT, .lo = FLT_MIN, .hi = 1),
    OPT(light.layer.shrink, "shrink", IN(ENGINE, MAIN), "E",
        "splat: crop polygons where the kernel's edge is dim, by at most this "
        "share of the light; 0 for none", .needs = GP_NEED_SPLAT, .hi = 0.99),
    CHOICE(light.layer.gl, "gl", IN(ENGINE, MAIN | BENCH | SETS), "API",
        "Draw splat, sun maps and scenes in this GL context", ONE_OF(
        {"auto", GLAREPP_GL_AUTO,
         "osmesa, or egl where OSMesa cannot be opened"},
        {"osmesa", GLAREPP_OSMESA, "Mesa's off-screen library, on the CPU"},
        {"egl", GLAREPP_EGL, "a GPU where there is one, else Mesa's "
         "surfaceless platform on the CPU"})),
    OPT(run.threads, "threads", IN(ENGINE, ALL), "N", "Use N threads, 0 for "
        "all processors; no output depends on it", .hi = 1024, .aside = true),
    OPT(run.frame_jobs, "frame-jobs", IN(INPUT, MAIN), "N",
        "Keep N frames in flight, 1 for one after the other, 0 for 3 or as "
        "many as fit into half of the memory; no output depends on it",
        .hi = GP_FRAME_JOBS, .aside = true),

    OPT(tone.map.curve, "tonemap", IN(TONE, BOTH), "NAME", "Map tones with "
        "this operator", .needs = GP_NEED_NO_CONFIG, .list = gp_curve_name,
        .usual = "Map tones of -o: neutral, agx, aces, linear"),
    OPT(tone.map.exposure, "exposure", IN(TONE, BOTH), "EV", "Scale the light "
        "by 2^EV before the operator", .needs = GP_NEED_CURVE, .lo = -32,
        .hi = 32, .usual = "Expose -o: 1 for twice as bright, -1 for half"),
    OPT(tone.map.auto_exposure, "auto-exposure", IN(TONE, BOTH), NULL,
        "Scale the frame so that its log-average becomes middle grey, then by "
        "--exposure", .needs = GP_NEED_CURVE),
    OPT(tone.map.white, "white", IN(TONE, BOTH), "W", "reinhard-extended: map "
        "this luminance, after exposure, to white; 0 uses the frame's maximum",
        .needs = GP_NEED_TONES | GP_NEED_EXTENDED, .hi = FLT_MAX),

    OPT(tone.map.config, "ocio", IN(TONE, MAIN), "CONFIG", "Show pictures "
        "through a view of this OpenColorIO config, in place of --tonemap: a "
        "file, env for $OCIO, or ocio://NAME for one built into OpenColorIO "
        "2.2 or later; trust a config as you would a program", .blank = true),
    OPT(tone.map.input, "input-space", IN(TONE, MAIN), "S",
        "Read frames as this colour space or role of the config; those whose "
        "files name other chromaticities are converted to it; without it, "
        "scene_linear", .needs = GP_NEED_CONFIG),
    OPT(tone.map.any_primaries, "ignore-chromaticities", IN(TONE, MAIN), NULL,
        "Read frames as --input-space even where their files name other "
        "chromaticities", .needs = GP_NEED_CONFIG),
    OPT(tone.map.display, "display", IN(TONE, MAIN), "D",
        "Use this display of the config; without it, its default",
        .needs = GP_NEED_CONFIG | GP_NEED_PICTURE),
    OPT(tone.map.view, "view", IN(TONE, MAIN), "V",
        "Use this OCIO view of the display; without it, its default",
        .needs = GP_NEED_CONFIG | GP_NEED_PICTURE),
    OPT(tone.map.look, "look", IN(TONE, MAIN), "L",
        "Use these looks in place of those of the view: A, or -A,+B",
        .needs = GP_NEED_CONFIG | GP_NEED_PICTURE),
    OPT(tone.map.output, "output-space", IN(TONE, MAIN), "S",
        "Convert --hdr to this colour space of the config, and write its "
        "chromaticities", .needs = GP_NEED_CONFIG | GP_NEED_HDR),
    OPT(tone.context, "ocio-context", IN(TONE, MAIN), "NAME=VALUE",
        "Set a context variable of the config; may be given more than once",
        .needs = GP_NEED_CONFIG),

    CHOICE(output.write.type, "type", IN(FILE, MAIN), "TYPE",
        "Write samples of float formats in this type", ONE_OF(
        {"auto", GP_OUT_AUTO,
         "as in the input; float where a value is over 65504"},
        {"half", GP_OUT_HALF, "16 bits; a brighter pixel is scaled to 65504, "
         "which keeps its hue; formats other than EXR get float"},
        {"float", GP_OUT_FLOAT, "32 bits"})),
    CHOICE(output.write.compression, "compression", IN(FILE, MAIN | KERNEL),
        "NAME", "Compress EXR files this way", ONE_OF(
        {"auto", GP_COMPRESSION_AUTO,
         "as in the input if that is lossless, else zip"},
        {"none", GP_COMPRESSION_NONE, NULL}, {"rle", GP_COMPRESSION_RLE, NULL},
        {"zips", GP_COMPRESSION_ZIPS, NULL}, {"zip", GP_COMPRESSION_ZIP, NULL},
        {"piz", GP_COMPRESSION_PIZ, NULL},
        {"pxr24", GP_COMPRESSION_PXR24,
         "rounds 32-bit floats to 24 bits, depth too; lossless for half"},
        {"b44", GP_COMPRESSION_B44, "lossy for half, alpha too, where NaN and "
         "Inf become 0; lossless for float"},
        {"b44a", GP_COMPRESSION_B44A, "as b44"},
        {"dwaa", GP_COMPRESSION_DWAA, "lossy for R, G, B and Y of every layer, "
         "where NaN becomes 0; lossless for depth and alpha"},
        {"dwab", GP_COMPRESSION_DWAB, "as dwaa"})),
    CHOICE(output.write.depth_bits, "depth-bits", IN(FILE, MAIN), "N",
        "Write samples of PNG and other integer formats with N bits", ONE_OF(
        {"8", 8, NULL}, {"16", 16, NULL})),
    OPT(output.write.png_level, "png-level", IN(FILE, MAIN), "N",
        "Pack PNG files so hard: 0 not at all, 1 fast, 12 small and slow",
        .hi = GP_PNG_LEVELS),
    SET(output.write.dither, "dither", IN(FILE, MAIN), "Dither integers of 16 "
        "bits too, not only those of 8", .set = GP_DITHER_ALWAYS),
    SET(output.write.dither, "no-dither", IN(FILE, MAIN),
        "Round to the nearest integer; smooth glows then show bands in 8 bits",
        .set = GP_DITHER_NEVER),
    CHOICE(output.write.alpha, "alpha", IN(FILE, MAIN), "HOW",
        "Write alpha of -o pictures this way", ONE_OF(
        {"black", GP_ALPHA_BLACK,
         "composite the picture over black, without alpha"},
        {"keep", GP_ALPHA_KEEP, "write the frame's alpha where the format has "
         "it: EXR, PNG, TIFF, WebP, Targa, SGI, DPX, BMP"})),
    OPT(output.write.no_clobber, "no-clobber", IN(FILE, MAIN), NULL,
        "Skip frames whose outputs already exist, to resume a run; print how "
        "many at the end", .needs = GP_NEED_FILES, .aside = true),
    OPT(output.write.fsync, "fsync", IN(FILE, MAIN), NULL, "Write each output "
        "through to the disk before it gets its name, so that a power cut "
        "leaves none that is cut", .needs = GP_NEED_FILES, .aside = true),
    CHOICE(output.write.stdout_format, "stdout-format", IN(FILE, MAIN),
        "FORMAT", "Write this format to an output that is -",
        .needs = GP_NEED_STREAM, .aside = true,
        .choices = (const struct gp_option_choice[]) {
            GP_STDOUT_LIST(STREAM) {0}}),
    CHOICE(output.write.raw, "raw", IN(FILE, MAIN), "FORMAT",
        "Pixel format of raw output; implies --stdout-format raw",
        .needs = GP_NEED_RAW | GP_NEED_STREAM, .aside = true, ONE_OF(
        {"rgb24", GP_RAW_RGB24, "8 bits, sRGB"},
        {"rgb48le", GP_RAW_RGB48LE, "16 bits, sRGB, low byte first"},
        {"rgb48be", GP_RAW_RGB48BE, "16 bits, sRGB, high byte first"},
        {"rgbf32le", GP_RAW_RGBF32LE, "floats as they are, low byte first"})),
    OPT(output.write.create_dir, "create-dir", IN(FILE, MAIN | KERNEL), NULL,
        "Make missing folders of output files", .aside = true),
    OPT(words.settings, "settings", IN(FILE, MAIN), "FILE",
        "Read options from this file, one a line, or from a PNG or EXR that "
        "glarepp made; those of the command line rule; of files given more "
        "than once the later rules", .aside = true),
    OPT(words.save_settings, "save-settings", IN(FILE, MAIN), "FILE",
        "Write the given options, but for inputs and outputs, to this file, "
        "for --settings", .aside = true, .once = true),
    OPT(output.no_provenance, "no-provenance", IN(FILE, MAIN | COMPARE), NULL,
        "Write no attributes glarepp:* into EXR and PNG files, and drop those "
        "of the input", .aside = true),

    OPT(run.report, "report", IN(REPORT, DRAWS), "FILE", "Write JSON, one "
        "object a line for each frame; - is stdout", .once = true),
    OPT(run.verify, "verify", IN(REPORT, MAIN), NULL,
        "Measure the layer's error against the exact sum in double; slow; "
        "shown by --report and -v", .needs = GP_NEED_REPORT),
    OPT(run.fixation, "fixation", IN(REPORT, MAIN), "X,Y", "Let the eye look "
        "at this pixel, for the report's veil; without it the middle",
        .needs = GP_NEED_REPORT, .lo = -1e6, .hi = 1e6, .least = 2, .most = 2),
    OPT(run.luminance_scale, "luminance-scale", IN(REPORT, MAIN), "CD",
        "Take 1 as so many cd/m2, for the report's veil and for pupils that "
        "adapt; 0 takes the file's whiteLuminance", .hi = 1e9, .pixels = true),
    CHOICE(run.progress, "progress", IN(REPORT, MAIN), "WHEN",
        "Print frame, rate and time left to stderr", ONE_OF(
        {"auto", GP_PROGRESS_AUTO, "on a terminal, after one second"},
        {"always", GP_PROGRESS_ALWAYS, NULL},
        {"never", GP_PROGRESS_NEVER, NULL},
        {"percent", GP_PROGRESS_PERCENT, "lines such as 42%"},
        {"openjd", GP_PROGRESS_OPENJD, "lines of Open Job Description: "
         "openjd_progress: 41.7, openjd_status: TEXT"},
        {"json", GP_PROGRESS_JSON, "an object a line: done, failed, total, "
         "percent, seconds, seconds_left, file, stage"})),
    SET(run.level, "quiet", IN(REPORT, ALL), "Print errors only", .letter = 'q',
        .set = GP_LEVEL_ERROR),
    SET(run.level, "verbose", IN(REPORT, ALL), "Say of each frame what was "
        "used, and why", .letter = 'v', .set = GP_LEVEL_INFO),

    OPT(making.size, "size", IN(KERNEL, KERNEL | SETS), "WxH",
        "Make it for frames of this size, without it 1920x1080; sets: draw "
        "pictures of this size, without it 960x540"),
    OPT(making.radius, "radius", OWN(KERNEL), "N",
        "Make only offsets up to N pixels, 0 for all", .hi = 16383),
    OPT(making.frame, "frame", OWN(KERNEL), "N", "Make models that change in "
        "time for this frame", .lo = -1e9, .hi = 1e9),
    OPT(making.check, "check", IN(KERNEL, KERNEL | LENS), "FILE|NAME",
        "Print the figures and faults of a kernel, or of a lens against what "
        "it claims; exit 1 on a fault"),
    OPT(making.list, "list", IN(KERNEL, KERNEL | LENS), NULL,
        "Print the models, their keys with ranges, and the presets; or the "
        "installed lenses"),
    OPT(making.draw, "draw", OWN(LENS), "FILE", "Draw the lens of --check with "
        "the rays of its brightest ghost, as SVG; - is stdout", .once = true),

    OPT(sets.seconds, "time", OWN(SETS), "SECONDS",
        "Draw the scene at this time of its animation; without it, at its "
        "first key", .lo = -1e9, .hi = 1e9),
    OPT(sets.map, "shadow-size", OWN(SETS), "N",
        "Draw maps of shadows with N texels a side, six such squares for a "
        "point light", .lo = 8, .hi = 4096),
    OPT(sets.separate, "separate-shadows", OWN(SETS), NULL,
        "Draw a shadow batch for each material of an object, in place of one "
        "for all that is opaque"),
    OPT(sets.occluders, "occluders", OWN(SETS), "N",
        "Draw the N objects that look largest first, to find by their depth "
        "which others are hidden", .hi = 1000000),

    OPT(bench.csv, "csv", OWN(BENCH), "FILE",
        "Write the table as comma-separated values; - is stdout", .once = true),
    OPT(bench.json, "json", IN(REPORT, BENCH | COMPARE | SETS), "FILE",
        "bench, sets: write the table as JSON; compare: write one object a "
        "line for each pair; - is stdout", .once = true),
    OPT(bench.plot, "plot", OWN(BENCH), "FILE",
        "Draw error over time with the Pareto front, as SVG", .once = true),
    OPT(bench.paper, "paper", OWN(BENCH), NULL, "Measure three generated "
        "frames like the paper's: few points, windows, and a sky that fills "
        "the frame", .needs = GP_NEED_OWN_FRAMES | GP_NEED_NO_LIGHT),
    OPT(bench.runs, "runs", IN(REPORT, BENCH | SETS), "N",
        "bench: time each row N times; the table has the median; sets: the "
        "fastest in wall and CPU time, of 3 without it", .lo = 1, .hi = GP_BENCH_RUNS),

    // idiff's, which may be written with one dash
    OPT(compare.limits.fail, "fail", OWN(COMPARE), "E",
        "Fail pixels with a value whose error is over E", .hi = INFINITY),
    OPT(compare.limits.fail_relative, "failrelative", OWN(COMPARE), "F",
        "Fail only values whose error is also over F times the mean of both "
        "magnitudes", .hi = INFINITY),
    OPT(compare.limits.fail_percent, "failpercent", OWN(COMPARE), "P",
        "Allow this percentage of pixels to fail", .hi = INFINITY),
    OPT(compare.limits.allow_failures, "allowfailures", OWN(COMPARE), "N",
        "Allow N pixels to fail by any amount, -1: any number", .lo = -1,
        .hi = INT32_MAX),
    OPT(compare.limits.hard_fail, "hardfail", OWN(COMPARE), "E",
        "Fail if any error is over E, whatever --failpercent allows",
        .hi = INFINITY),
    OPT(compare.limits.warn, "warn", OWN(COMPARE), "E",
        "Warn of pixels with a value whose error is over E, where pixels fail "
        "but not too many", .hi = INFINITY),
    OPT(compare.limits.warn_relative, "warnrelative", OWN(COMPARE), "F",
        "Warn only of values whose error is also over F times the mean of both "
        "magnitudes", .hi = INFINITY),
    OPT(compare.limits.warn_percent, "warnpercent", OWN(COMPARE), "P",
        "Allow this percentage of pixels to be over --warn", .hi = INFINITY),
    OPT(compare.limits.hard_warn, "hardwarn", OWN(COMPARE), "E",
        "Warn if any error is over E, whatever --warnpercent allows",
        .hi = INFINITY),
    OPT(compare.limits.perceptual, "perceptual", OWN(COMPARE), NULL,
        "Fail pixels whose difference an eye sees (Yee's metric), in place of "
        "--fail and --warn", .letter = 'p'),
    OPT(compare.all_parts, "all", OWN(COMPARE), NULL,
        "Compare all parts; without it, the first of each file", .letter = 'a'),
    OPT(compare.difference, "difference", OWN(COMPARE), "FILE",
        "Write A - B as a picture, with --all of the first part; the ending "
        "picks the format", .letter = 'o', .aside = true),
    OPT(compare.only_different, "od", OWN(COMPARE), NULL,
        "Write --difference only where the images differ"),
    OPT(compare.absolute, "abs", OWN(COMPARE), NULL,
        "Write |A - B| to --difference"),
    OPT(compare.scale, "scale", OWN(COMPARE), "F",
        "Multiply --difference by F", .lo = -FLT_MAX, .hi = FLT_MAX),
    OPT(compare.limits.fail_rel, "fail-rel", OWN(COMPARE), "E",
        "Fail where rel_l2, the norm of A - B over that of A, is over E; "
        "--fail has no default then", .hi = INFINITY),
    OPT(compare.limits.fail_flip, "fail-flip", OWN(COMPARE), "F",
        "Fail where the mean FLIP is over F; --fail has no default then",
        .hi = 1),
    OPT(compare.flip_exposures, "flip-exposures", OWN(COMPARE),
        "START,STOP,COUNT", "Compute HDR-FLIP at these exposures in EV; "
        "without it, at those that fit the first image", .lo = -64, .hi = 64,
        .least = 3, .most = 3),
    OPT(compare.limits.flip, "no-flip", OWN(COMPARE), NULL,
        "Leave out FLIP, which takes most of the time", .off = true),
    OPT(compare.heatmap, "heatmap", OWN(COMPARE), "FILE", "Write a picture of "
        "FLIP at each pixel: magma, black 0 to pale yellow 1", .aside = true),

    OPT(page.html, "html", IN(REPORT, BENCH | COMPARE), "FILE",
        "Write a page to look at: the pictures over each other, where they "
        "differ, and the figures, in one file; compare: of all frames, or one "
        "for each with a pattern", .once = true),
    OPT(page.index, "html-index", OWN(COMPARE), "FILE",
        "Write a page that lists the pages of --html, which is a pattern",
        .once = true, .aside = true),
    OPT(page.megabytes, "html-size", IN(REPORT, BENCH | COMPARE | STYLES), "MB",
        "Make pages of up to this size: beyond a region of whole pixels they "
        "have averages; styles, bench: without it 1.5 a picture", .lo = 0.1,
        .hi = 1000, .aside = true),

    OPT(words.version, "version", IN(GENERAL, ALL), NULL,
        "Print the versions of the program and its libraries"),
    OPT(words.help, "help", IN(GENERAL, ~0u), "[TOPIC]",
        "Print help: one screen, a command's own, a topic of glarepp help",
        .letter = 'h', .open = true, .blank = true, ONE_OF(
        {"all", 0, NULL})),
    OPT(words.help_table, "help-table", IN(GENERAL, MAIN), NULL, NULL),
    {0},
};
// clang-format on
