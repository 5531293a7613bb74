#include "app/option_values.h"

const struct gp_option_choice gp_normalizes[] = {
    {"luminance", GP_NORMALIZE_LUMINANCE, "the luminance of its sum is 1, the "
     "ratios of its channels stay"},
    {"none", GP_NORMALIZE_NONE, "as it is in the file"},
    {0},
};
const struct gp_option_choice gp_mixes[] = {
    {"add", GP_MIX_ADD, "the layer comes on top of the frame"},
    {"scatter", GP_MIX_SCATTER, "light that is spread is taken from its "
     "source, which conserves energy; needs a gain up to 1"},
    {0},
};
const struct gp_option_choice gp_gls[] = {
    {"auto", GP_GL_AUTO, "the first that opens"},
    {"osmesa", GP_GL_OSMESA, "Mesa's off-screen library, on the CPU"},
    {"egl", GP_GL_EGL, "a GPU's device where there is one, Mesa's surfaceless "
     "platform else"},
    {0},
};
const struct gp_option_choice gp_methods[] = {
    {"centroid", GP_GROUP_CENTROID, "the kernel at the group's centroid: "
     "formula (1) of Ando et al."},
    {"moments", GP_GROUP_MOMENTS, "the kernel blurred by as much as the group "
     "is wide"},
    {"core", GP_GROUP_CORE, "the kernel's 17x17 core from each single sensor, "
     "only its tail from groups"},
    {0},
};
const struct gp_option_choice gp_primitives[] = {
    {"auto", GP_PRIMITIVE_AUTO, "tile on a software context, quad else"},
    {"quad", GP_PRIMITIVE_QUAD, "blended quads"},
    {"point", GP_PRIMITIVE_POINT, "blended point sprites, up to the driver's "
     "limit of size"},
    {"tile", GP_PRIMITIVE_TILE, "one pass for each tile, summed over the "
     "polygons that reach it"},
    {0},
};
const struct gp_option_choice gp_depth_types[] = {
    {"z", GP_DEPTH_Z, "distance along the view axis"},
    {"ray", GP_DEPTH_RAY, "distance from the camera"},
    {"inverse", GP_DEPTH_INVERSE, "1 / z; 0 is empty"},
    {"normalized", GP_DEPTH_NORMALIZED, "0 near to 1 far, or the other way "
     "where the background is 0"},
    {0},
};
const struct gp_option_choice gp_sun_methods[] = {
    {"exact", GP_SUN_EXACT, "the area of every pixel under the disc, in "
     "double, on the CPU; no GL"},
    {"mask", GP_SUN_MASK, "Maughan's texture masking on GL: sun map, intensity "
     "map, and flare that fetches it; nothing is read back before the layer"},
    {"readback", GP_SUN_READBACK, "the region under the light is read back "
     "from GL and counted"},
    {0},
};
const struct gp_option_choice gp_patterns[] = {
    {"disc", GP_PATTERN_DISC, "equal-area samples of the disc"},
    {"square", GP_PATTERN_SQUARE, "the square around it, as in the paper"},
    {0},
};
const struct gp_option_choice gp_sums[] = {
    {"float", GP_SUM_FLOAT, "every texel, in float"},
    {"8bit", GP_SUM_BYTE, "in 8 bits, 1/255 a texel, as in the paper"},
    {"bilinear", GP_SUM_BILINEAR, "a quarter of the points, each the mean of "
     "four texels"},
    {0},
};
const struct gp_option_choice gp_outsides[] = {
    {"ignore", GP_OUTSIDE_IGNORE, "the share is taken over the part inside"},
    {"visible", GP_OUTSIDE_VISIBLE, "what is outside shows, glare and flare "
     "included"},
    {"hidden", GP_OUTSIDE_HIDDEN, "what is outside is hidden"},
    {0},
};
const struct gp_option_choice gp_sun_draws[] = {
    {"auto", GP_DRAW_AUTO, "on GL with a GPU, on the CPU with a software "
     "context, where that takes a quarter of the time"},
    {"gl", GP_DRAW_GL, "sprites and elements fetch the share on GL; nothing is "
     "read back before the layer is done"},
    {"cpu", GP_DRAW_CPU, "the shares are read first"},
    {0},
};
const struct gp_option_choice gp_ndcs[] = {
    {"auto", GP_NDC_AUTO, "told apart by where the view axis falls"},
    {"spec", GP_NDC_SPEC, "0 to 1, y down, as OpenEXR defines it"},
    {"clip", GP_NDC_CLIP, "-1 to 1, y up, as Arnold and Gaffer write it"},
    {0},
};
const struct gp_option_choice gp_plans[] = {
    {"estimate", GP_FFT_PLAN_ESTIMATE, "the same plan, so the same bytes, in "
     "every run"},
    {"measure", GP_FFT_PLAN_MEASURE, "the fastest plan of a few tried; kept "
     "in the cache folder for later runs"},
    {0},
};
const struct gp_option_choice gp_types[] = {
    {"auto", GP_OUT_AUTO, "as in the input"},
    {"half", GP_OUT_HALF, "16 bits; values over 65504 become 65504; formats "
     "that have none take float"},
    {"float", GP_OUT_FLOAT, "32 bits"},
    {0},
};
const struct gp_option_choice gp_compressions[] = {
    {"auto", GP_COMPRESSION_AUTO, "as in the input when that is lossless, "
     "zip else"},
    {"none", GP_COMPRESSION_NONE, NULL},
    {"rle", GP_COMPRESSION_RLE, NULL},
    {"zips", GP_COMPRESSION_ZIPS, NULL},
    {"zip", GP_COMPRESSION_ZIP, NULL},
    {"piz", GP_COMPRESSION_PIZ, NULL},
    {"pxr24", GP_COMPRESSION_PXR24, "32-bit floats lose 8 bits, depth too; "
     "half keeps all"},
    {"b44", GP_COMPRESSION_B44, "half loses, of alpha too, and NaN and "
     "Inf become 0; float keeps all"},
    {"b44a", GP_COMPRESSION_B44A, "the same"},
    {"dwaa", GP_COMPRESSION_DWAA, "R, G, B and Y of every layer lose, and "
     "NaN becomes 0; depth and alpha keep all"},
    {"dwab", GP_COMPRESSION_DWAB, "the same"},
    {0},
};
const struct gp_option_choice gp_bits[] = {
    {"8", 8, NULL}, {"16", 16, NULL}, {0},
};
const struct gp_option_choice gp_alphas[] = {
    {"black", GP_ALPHA_BLACK, "the picture stands over black and has no "
     "alpha"},
    {"keep", GP_ALPHA_KEEP, "the frame's alpha is written along"},
    {0},
};
const struct gp_option_choice gp_stdout_formats[] = {
    {"exr", GP_STDOUT_EXR, "OpenEXR; with --hdr the only one"},
    {"png", GP_STDOUT_PNG, NULL},
    {"pfm", GP_STDOUT_PFM, "portable float map: floats as they are"},
    {"raw", GP_STDOUT_RAW, "no header: pixels from the top left on, for ffmpeg "
     "-f rawvideo; all frames have one size"},
    {0},
};
const struct gp_option_choice gp_raws[] = {
    {"rgb24", GP_RAW_RGB24, "8 bits, sRGB"},
    {"rgb48le", GP_RAW_RGB48LE, "16 bits, sRGB, low byte first"},
    {"rgb48be", GP_RAW_RGB48BE, "16 bits, sRGB, high byte first"},
    {"rgbf32le", GP_RAW_RGBF32LE, "floats as they are, low byte first"},
    {0},
};
const struct gp_option_choice gp_progresses[] = {
    {"auto", GP_PROGRESS_AUTO, "on a terminal, for work over a second"},
    {"always", GP_PROGRESS_ALWAYS, NULL},
    {"never", GP_PROGRESS_NEVER, NULL},
    {0},
};
const struct gp_option_choice gp_debugs[] = {
    {"sensors", GP_DEBUG_SENSORS, "the light that the engines are given, "
     "scene-linear"},
    {"polygons", GP_DEBUG_POLYGONS, "outlines of the polygons that splat "
     "draws, in green over the tone-mapped picture"},
    {"sunmap", GP_DEBUG_SUNMAP, "the sun maps of all lights, side by side: "
     "white where a light shows"},
    {"intensity", GP_DEBUG_INTENSITY, "the intensity map: a pixel for each "
     "light, as bright as its visible share"},
    {0},
};
const struct gp_option_choice gp_shells[] = {
    {"bash", GP_SHELL_BASH, NULL},
    {"zsh", GP_SHELL_ZSH, NULL},
    {"fish", GP_SHELL_FISH, NULL},
    {0},
};
