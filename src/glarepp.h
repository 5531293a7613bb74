// SPDX-License-Identifier: Apache-2.0
/* libglarepp: the glare that bright light makes in an eye or a lens, laid over
 * scene-linear pictures in memory, with a bound on its error.
 *
 *   context  threads, messages, cancelling; all else hangs on one
 *   image    a borrowed view of pixels
 *   kernel   the point-spread function: recipes of models, or an image
 *   plan     what is dear, made once: kernels of a field, spectra, lights,
 *            lenses, colour processors
 *   frame    one picture on its way through a plan
 *
 * The shortest way is three calls and their ends:
 *
 *   struct glarepp_params params = GLAREPP_PARAMS;
 *   struct glarepp_plan_params how = GLAREPP_PLAN_PARAMS;
 *   struct glarepp_image picture = GLAREPP_IMAGE;     // planes, window
 *   glarepp_open(&params, &gp);
 *   glarepp_plan(gp, &how, &plan);
 *   glarepp_execute(plan, &picture, &picture, NULL);  // any number of times
 *   glarepp_plan_end(&plan);
 *   glarepp_close(&gp);
 *
 * Parameters are structs. Start from the macro of the same name, which has the
 * defaults and the struct's size: fields are added at the end, and a caller of
 * an older header gets their defaults; so does NULL in their place. Structs
 * without a size, and an image, grow only with another libglarepp.so.N. Pointers
 * are never NULL but where it is said; numbers are finite.
 *
 * Functions that can fail return an enum glarepp_status as int, 0 for success.
 * An object comes out through the last pointer, which is NULL after a failure.
 * Ends take the address of a pointer, set it to NULL, and do nothing for NULL.
 * No call prints, exits, reads the environment (OpenColorIO and Mesa read their
 * own variables), touches a signal, or a file but those whose path it is given.
 * In a call the thread has the C locale, and its own again after it.
 *
 * Threads: two contexts may be used from two threads at once. Of one context,
 * plans and frames may be used from several threads as long as each frame is in
 * one at a time.
 *
 * Coordinates are EXR pixel space: pixel (i, j) covers [i, i + 1) x [j, j + 1),
 * x right, y down. Colour is scene-linear, in the primaries of the image. */
#ifndef GLAREPP_H
#define GLAREPP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#pragma GCC visibility push(default)

/* Returns "0.1.0", the version of the library that runs. */
const char *glarepp_version(void);

// -- context ------------------------------------------------------------------

/* Results of calls. The numbers are the program's exit statuses too. */
enum glarepp_status {
    GLAREPP_OK = 0,
    GLAREPP_ERR_USAGE = 2,     // a parameter is wrong, or two do not fit
    GLAREPP_ERR_IO = 3,        // a file cannot be read
    GLAREPP_ERR_DATA = 4,      // a file or an image holds bad data
    GLAREPP_ERR_GL = 5,        // no GL context could be made
    GLAREPP_ERR_CANCELLED = 7, // the progress callback asked for the end
    GLAREPP_ERR_BUG = 70,      // out of memory, or a bug
};

enum glarepp_level { GLAREPP_ERROR, GLAREPP_WARNING, GLAREPP_NOTE };

/* A message. Strings are valid until the callback returns, or, of
 * glarepp_error(), until the thread's next call into the library. */
struct glarepp_message {
    enum glarepp_level level;
    int status;            // of an error
    const char *parameter; // field that is wrong or helps, "layer.tolerance";
                           // "": none. A word may follow, where messages about
                           // one field differ: "layer.gl.osmesa". Of kernels I
                           // to before J of a plan, "kernel.word I J FIELD"; of
                           // its more[K], "plan.more K FIELD"
    const char *text;      // one sentence: what is wrong (what was found)
    bool bare;             // an error that names no file
    void *user;            // of the frame it is about; NULL: none
};

/* A picture that the library asks its caller to decode: of a kernel's recipe, a
 * flare, or a scene's texture. */
struct glarepp_picture {
    const char *path;      // or a name for messages, where bytes are given
    const void *bytes;     // an encoded picture in memory; NULL: read the path
    size_t n;
    bool alpha;            // only its alpha is wanted, in plane[0], as codes
                           // without gaps; one code where it has none
    long long most;        // pixels that it may have
};

struct glarepp_image;
struct glarepp_label;

struct glarepp_params {
    size_t size;
    int threads;           // to 1024; 0: one a processor
    enum glarepp_level level; // messages beyond it are dropped
    /* Receives messages, in any thread that is in a call. NULL: none are
     * wanted; glarepp_error() has the last error in any case. */
    void (*message)(void *user, const struct glarepp_message *m);
    /* Called before each step of a frame with its name and the share of them
     * that is done, 0 to 1; true ends the call with GLAREPP_ERR_CANCELLED. */
    bool (*progress)(void *user, const char *step, double done);
    /* Decodes a picture into *out, and what the file says of a kernel into
     * *label (zero before). Planes stay until release(). NULL: recipes, flares
     * and scenes that name pictures are errors. */
    int (*picture)(void *user, const struct glarepp_picture *p,
                   struct glarepp_image *out, struct glarepp_label *label);
    void (*release)(void *user, struct glarepp_image *image);
    void *user;            // first argument of all four
    const char *data;      // folder with flares/ and lenses/, for installed
                           // names, and
    const char *bridges;   // folder with glarepp-ocio.so, both looked in before
                           // the installation's; NULL: none
    const char *osmesa, *egl; // GL library files; NULL: the system's
    int gl_size;           // largest side of a GL texture; 0: the driver's
    bool keep_memory;      // keeps the pages of freed planes for the next ones,
                           // of all contexts, as long as this one is open
};
#define GLAREPP_PARAMS                                                        \
    { sizeof(struct glarepp_params), 0, GLAREPP_WARNING, NULL, NULL, NULL,    \
      NULL, NULL, NULL, NULL, NULL, NULL, 0, false }

struct glarepp; // a context

/* Opens a context; *p may go afterwards. Errors: USAGE threads, BUG. */
int glarepp_open(const struct glarepp_params *p, struct glarepp **out);
/* Ends it. Its plans, kernels and frames must be ended before. */
void glarepp_close(struct glarepp **gp);

/* Counts this thread among those at work in a context until glarepp_leave(), and
 * waits while as many others as it has threads are. Calls do so by themselves;
 * a caller with threads of its own, which works in them between calls, does it
 * once around both. A thread that enters a context leaves any other. */
void glarepp_enter(struct glarepp *gp);
void glarepp_leave(const struct glarepp *gp);

/* Returns the last error of this thread; text "" where there was none. */
const struct glarepp_message *glarepp_error(void);

// -- images -------------------------------------------------------------------

/* Half-open: x in [x0, x1), y in [y0, y1). */
struct glarepp_rect {
    int x0, y0, x1, y1;
};

enum glarepp_type {
    GLAREPP_FLOAT, GLAREPP_HALF,
    GLAREPP_CODES, // 16 bits, 65535 is 1: alpha of glarepp_picture only
};

/* A view of pixels that the caller owns. Sample (x, y) of channel c is at
 *   (char *) plane[c] + (y - data.y0) * row + (x - data.x0) * pixel
 * so that planes, interleaved pixels and parts of a larger picture all fit. */
struct glarepp_image {
    size_t size;
    void *plane[3];             // red, green, blue; aligned to their type
    enum glarepp_type type;
    ptrdiff_t pixel, row;       // bytes; 0: planes without gaps
    struct glarepp_rect data;   // pixels that there are; others are black
    struct glarepp_rect display; // the picture; empty: data
    float aspect;               // width of a pixel over its height; 0: 1
    const float *primaries;     // rx ry gx gy bx by wx wy; NULL: BT.709
    const char *name;           // for messages; NULL: "image"
};
#define GLAREPP_IMAGE                                                         \
    { sizeof(struct glarepp_image), {NULL, NULL, NULL}, GLAREPP_FLOAT, 0, 0,  \
      {0, 0, 0, 0}, {0, 0, 0, 0}, 0.0f, NULL, NULL }

/* Frees planes that the library made, as the function that made them says. */
void glarepp_image_end(struct glarepp_image *image);

// -- kernels ------------------------------------------------------------------

/* Facts that a file of `glarepp kernel` carries beside its samples. */
struct glarepp_label {
    bool present;          // false: an image of any other origin
    int w, h;              // pixels of the frame that it was made for
    double fov;            // degrees, of that frame's height
    double left_out;       // share of light outside of the samples
    double beyond;         // ... outside of that frame too
    double share;          // of a pixel's light, that its models spread
    double degrees;        // of a pixel in its middle, once drawn
};

/* Either recipes, or one image. A word is a recipe, MODEL:key=value,...; a
 * preset, builtin:NAME; or the path of an image, which params.picture decodes.
 * One word that is a path is an image, by the fields below; several words add
 * up, each with its share, and images among them spread all of theirs. */
struct glarepp_kernel_params {
    size_t size;
    const char *const *word; // NULL: builtin:eye
    int words;               // up to 8
    const struct glarepp_image *image; // decoded already; NULL: by `word`
    struct glarepp_label label;        // of `image`
    bool centred;            // `centre` is given
    double centre[2];        // EXR pixel space of the image; else the pixel
                             // (floor(w / 2), floor(h / 2))
    bool as_it_is;           // false: each channel's sum keeps its ratio and
                             // the luminance sums up to 1
    bool normalized;         // ... of a file with a label too, which else is
                             // taken as it is
    bool recipe;             // one word that is a path is a recipe as well
    bool unread;             // words are recipes, whose images are not read: for
                             // their text and share only
    double percent;          // frame pixels for 100 of the image, > 0
    double degrees;          // height of the image in the field; 0: by percent
};
#define GLAREPP_KERNEL_PARAMS                                                 \
    {                                                                         \
        sizeof(struct glarepp_kernel_params), NULL, 0, NULL,                  \
            {false, 0, 0, 0.0, 0.0, 0.0, 0.0, 0.0}, false, {0.0, 0.0}, false, \
            false, false, false, 100.0, 0.0                                   \
    }

struct glarepp_kernel;

/* Reads recipes, and images by params.picture. Copies all that it needs.
 * Errors: USAGE no such model or key, or a value out of its range; those of
 * params.picture. An image without light or with NaN is one of glarepp_plan(). */
int glarepp_kernel(struct glarepp *gp,
    const struct glarepp_kernel_params *p, struct glarepp_kernel **out);
void glarepp_kernel_end(struct glarepp_kernel **kernel);

/* Returns the i-th recipe with every key that is not at its preset: parsing it
 * gives the same kernel, byte for byte. NULL after the last, or of an image.
 * Valid as long as the kernel. */
const char *glarepp_kernel_recipe(const struct glarepp_kernel *k, int i);

/* Returns the share of a pixel's light that it takes and spreads. */
double glarepp_kernel_share(const struct glarepp_kernel *k);

/* Copies to `path` the path that a word of glarepp_kernel_params names, itself
 * or in a recipe; false: it names none, or has no room. */
bool glarepp_kernel_path(const char *word, char *path, size_t room);

/* The frames that kernels are drawn for. */
struct glarepp_field {
    int w, h;              // pixels of the frame, 1 to 2^20
    double fov;            // degrees, of its height, to 180; 0: 30
    double aspect;         // width of a pixel over its height; 0: 1
    double rotate;         // degrees, counter-clockwise as seen
    const float *primaries; // NULL: BT.709
    int frame;             // number, for models that move
    double fps;            // frames a second; 0: 24
    int radius;            // largest offset that is drawn; 0: all of the frame
    long long most;        // samples that there may be
    const char *name;      // for messages; NULL: "kernel"
};

/* Draws recipes at full rate: offsets up to w - 1, h - 1 or the radius, the
 * centre in the middle.
 *   out    planes of float, freed by glarepp_image_end()
 *   label  what a file of them shall say
 * Errors: USAGE a key that this field cannot serve; DATA over `most`; BUG. */
int glarepp_kernel_draw(const struct glarepp_kernel *k,
    const struct glarepp_field *field, struct glarepp_image *out,
    struct glarepp_label *label);

/* Frames and settings that a kernel is checked for. */
struct glarepp_kernel_use {
    struct glarepp_label label; // of the kernel's file
    int w, h;              // pixels of the frame; 0: the label's, or larger than
                           // the kernel
    double brightest;      // luminance of its brightest source; 0: not known
    double rotate, percent; // of the kernel, as in a plan
    bool add;              // light is added, not scattered
};

/* Position and symmetry of a kernel's light; offsets in pixels. */
struct glarepp_kernel_figures {
    int w, h, centre[2];   // without zero borders
    double sum[3], light;  // of each channel; luminance
    double own;            // share that stays in its pixel
    double left_out, missed; // outside of the samples; of which in the frame
    double peak, centroid[2];
    int peak_at[2];
    double rim;            // the largest edge
    double border;         // share in the outermost rows and columns
    double asymmetry;      // share without a counterpart opposite
    long long negatives, nonfinite;
    bool lit;              // a sample is not 0
    const char *const *fault; // `faults` lines, and
    const char *const *parameter; // what helps, as in glarepp_message
    int faults;
};

/* Measures the samples of a kernel, and judges them for a use.
 *   out  its lines stay until the thread's next call
 * Errors: USAGE no image; BUG. */
int glarepp_kernel_check(struct glarepp *gp,
    const struct glarepp_image *kernel, const struct glarepp_kernel_use *use,
    struct glarepp_kernel_figures *out);

/* A key of a model. */
struct glarepp_key {
    const char *name, *text; // one line, with the unit
    double preset, lo, hi;
    const char *const *words; // NULL-terminated, of 0, 1, ...; NULL: a number
    bool file;               // a path
};
/* Returns true and fills in the k-th key of the i-th of GLAREPP_MODELS. */
bool glarepp_key(int model, int k, struct glarepp_key *out);

/* Lists of names, in the order of the manual. */
enum glarepp_list {
    GLAREPP_ENGINES, GLAREPP_CURVES, GLAREPP_MODELS, GLAREPP_MODEL_SOURCES,
    GLAREPP_PRESETS, GLAREPP_PRESET_RECIPES, GLAREPP_FLARES, GLAREPP_LENSES,
};
/* Returns the i-th name, and its line of text; NULL after the last. Of
 * GLAREPP_FLARES and GLAREPP_LENSES those in params.data of `gp`, valid as long
 * as it; of the others `gp` may be NULL. */
const char *glarepp_name(struct glarepp *gp,
    enum glarepp_list list, int i, const char **text);

// -- sources and layer --------------------------------------------------------

enum glarepp_threshold {
    GLAREPP_LUMINANCE,  // scene-linear, >= 0
    GLAREPP_PERCENTILE, // of the frame's pixels, 0 to 100
    GLAREPP_EV,         // over the frame's log-average
};

/* Pixels whose luminance Y is over T are sources. */
struct glarepp_sense_params {
    size_t size;
    float threshold;    // T, in its unit
    enum glarepp_threshold unit;
    bool whole;         // the whole colour (Ando et al. 2007, section 3.1);
                        // else the part over T, rgb (Y - T) / Y
    float knee;         // of `whole`: ramp from T (1 - k) to T (1 + k); 0 to 1
    float max_value;    // pixels over it are scaled down to it; 0: no limit
};
#define GLAREPP_SENSE_PARAMS                                                  \
    { sizeof(struct glarepp_sense_params), 1.0f, GLAREPP_LUMINANCE, false,    \
      0.0f, 0.0f }

enum glarepp_mix { GLAREPP_ADD, GLAREPP_SCATTER };
enum glarepp_edges { GLAREPP_BLACK, GLAREPP_EXTEND, GLAREPP_MIRROR };
enum glarepp_gl { GLAREPP_GL_AUTO, GLAREPP_OSMESA, GLAREPP_EGL };

/* Layer: at pixel p the sum over sources q of source(q) kernel(p - q), and the
 * light from beyond the border.
 *   ADD      lit = in + gain layer
 *   SCATTER  lit = in - min(gain, 1) source + gain layer */
struct glarepp_layer_params {
    size_t size;
    const char *engine;    // of GLAREPP_ENGINES
    float tolerance;       // of rel_l2, for "auto"; 0 to 1
    float tolerance_pixel; // of max_rel, for "auto"; 0 to 1, 0: none
    bool in_double;        // transforms in double whatever the frame needs
    float gain;            // 0 to 1e6
    enum glarepp_mix mix;
    enum glarepp_edges edges;
    enum glarepp_gl gl;    // of engine "splat" and of masks
    // Ando et al. 2007, sections 4.1 to 4.3
    int group, cluster;    // pixels a side, powers of two to 64; 1 and 0: off
    float cluster_fill;    // bright share from which an area is one polygon
    float shrink; // share of light that polygons may leave out, to 0.99
    // COMPOSE or DONE makes of the layer, once, tint (Y + saturation (layer - Y)),
    // Y its luminance, and 0 of less; bounds and errors are of it before that
    float tint[3], saturation; // 0 to 1e6; 0 to 10
};
#define GLAREPP_LAYER_PARAMS                                                   \
    {                                                                          \
        sizeof(struct glarepp_layer_params), "auto", 1e-3f, 0.0f, false, 1.0f, \
            GLAREPP_SCATTER, GLAREPP_EXTEND, GLAREPP_GL_AUTO, 4, 8, 0.9f,      \
            1e-3f, {1.0f, 1.0f, 1.0f}, 1.0f                                    \
    }

// -- lights -------------------------------------------------------------------

enum glarepp_place {
    GLAREPP_PIXEL,
    GLAREPP_WORLD,
    GLAREPP_DIRECTION,
    GLAREPP_FOUND, // where another frame showed it: `found`. Several of one name,
                   // in order of frames, are one that moves: linear between
};

/* A sun or lamp. */
struct glarepp_light {
    enum glarepp_place place;
    double at[3];       // pixel x, y, of FOUND in frame z; point of the world;
                        // direction to it
    double radius;      // pixels; < 0: by `degrees` or `ball`, else 0.5
    double degrees;     // across, of a direction; 0 to 90
    double ball;        // radius of a lamp in the world's units; 0: none
    double depth;       // nearer surfaces hide it; NAN: by its place
    double bias;        // share of depth, to 1, that may be nearer: hides nothing
    float flux[3];      // scene-linear, summed over pixels, in a lat-long or
                        // fisheye those of the middle; 0: no glare of its
                        // own, no flare
    char name[64];
    float gain[3]; // of a FOUND light, times the flux that SENSE finds
};
#define GLAREPP_LIGHT                                                 \
    {                                                                 \
        GLAREPP_PIXEL, {0.0, 0.0, 0.0}, -1.0, 0.0, 0.0,               \
            (double) __builtin_nan(""), 1e-3, {0.0f, 0.0f, 0.0f}, "", \
        {                                                             \
            1.0f, 1.0f, 1.0f                                          \
        }                                                             \
    }

enum glarepp_share_method {
    GLAREPP_EXACT,      // areas, in double
    GLAREPP_MASK,       // Maughan's texture mask, on GL
    GLAREPP_READBACK,   // ... the method that he compares it with
};
enum glarepp_outside {  // the part of a light outside the frame
    GLAREPP_IGNORE, GLAREPP_VISIBLE, GLAREPP_HIDDEN, GLAREPP_BY_SCENE,
};
enum { // what hides lights whose place in the world is known, in a frame with a scene
    GLAREPP_SHARES_AUTO,  // its geometry, where EXACT and some is there
    GLAREPP_SHARES_FRAME, // in the frame, DEPTH and COVERAGE, or DEEP
    GLAREPP_SHARES_SCENE, // its geometry; what the frame says is only a check
};
enum glarepp_depth { GLAREPP_Z, GLAREPP_RAY, GLAREPP_INVERSE,
                     GLAREPP_NORMALIZED };
enum glarepp_ndc { GLAREPP_NDC_AUTO, GLAREPP_NDC_SPEC, GLAREPP_NDC_CLIP };

struct glarepp_light_params {
    size_t size;
    const struct glarepp_light *light; // `lights` of them
    int lights;
    const char *file;      // JSON of more, as in man/lights.md; NULL: none
    const char *cameras;   // JSON of a camera, maybe a sun, for each frame
    struct glarepp_light sun; // of that sun all but its place
    const char *flare;     // elements drawn for lights or bright pixels: JSON,
                           // or preset:NAME
    float degrees;         // across, of suns that do not say
    enum glarepp_share_method method;
    enum glarepp_outside outside;
    enum glarepp_depth depth;
    enum glarepp_ndc ndc;  // range of the frame's matrix
    bool in_frame;         // the pixels hold the lights: no glare is added
    bool needed;           // a frame without a light is an error
    float adapt;           // share of the picture that a clear light dims, to 1
    int side;              // of a mask, texels, 2 to 256, even
    bool square, bytes;    // of a mask: pattern; summed in 8 bits
    bool faded;            // a flare of lights may have none with flux
    /* Lights that SENSE finds, the brightest blobs over the threshold, to 256; of
     * their pixels, nothing hides them. They have the names of the FOUND lights
     * given, else of those of the first frame, lamp1 and on, that are next to
     * them. 0: only those that FOUND lights name, and 32 where a flare or a lens
     * needs lights and none may be there. */
    int found;
    float flare_gain; // of the flare; 0: its brightest pixel over a dark one
                      // becomes a quarter of white, by the tone's exposure
    int share_by;     // GLAREPP_SHARES_*
};
#define GLAREPP_LIGHT_PARAMS                                                   \
    {                                                                          \
        sizeof(struct glarepp_light_params), NULL, 0, NULL, NULL,              \
            GLAREPP_LIGHT, NULL, 0.533f, GLAREPP_EXACT, GLAREPP_IGNORE,        \
            GLAREPP_Z, GLAREPP_NDC_AUTO, false, false, 0.0f, 16, false, false, \
            false, 0, 1.0f, GLAREPP_SHARES_AUTO                                \
    }

/* Ghosts of a real lens. */
struct glarepp_lens_params {
    size_t size;
    const char *lens;      // prescription: JSON, or an installed name
    double sensor;         // mm, width of the display window on it, to 1e4; 0:
                           // by the frame
    double distance;       // m; 0: by the frame, else far
    double f_number;       // 0: by the frame, else the lens's own
    int detail;            // of meshes: 1 coarse, 2 fine, 3 the finest, many
                           // times the time; 0: fine for up to 8 lights
    float gain;            // of the ghosts; 0: as flare_gain of lights
};
#define GLAREPP_LENS_PARAMS                                              \
    {                                                                    \
        sizeof(struct glarepp_lens_params), NULL, 0.0, 0.0, 0.0, 0, 1.0f \
    }

enum glarepp_up { GLAREPP_UP_AUTO, GLAREPP_UP_Y, GLAREPP_UP_Z };

/* A glTF scene: its lights join the frame's, its geometry hides them. */
struct glarepp_scene_params {
    size_t size;
    const char *path;      // .glb or .gltf
    const char *camera;    // name; NULL: the only one
    enum glarepp_up up;    // of the frame's world
    double start;          // number of the frame at the scene's time 0
    double light_scale;    // frame's units a cd or lux; 0: lights without flux
    double lamp_size;      // radius of lamps whose nodes name none
    const char *const *relight; // `relights` names of lights, or "all", whose
    int relights;               // light is added to the frame
    bool camera_normals;   // axes of normals are the picture's
};
#define GLAREPP_SCENE_PARAMS                                                  \
    { sizeof(struct glarepp_scene_params), NULL, NULL, GLAREPP_UP_AUTO, 0.0,  \
      0.0, 0.0, NULL, 0, false }

// -- tone ---------------------------------------------------------------------

/* Strings are borrowed until the call returns. */
struct glarepp_tone_params {
    size_t size;
    const char *curve;     // of GLAREPP_CURVES
    float exposure;        // EV
    bool auto_exposure;    // the log-average maps to `key`
    float key;             // (0, 1]
    float white;           // of reinhard-extended; 0: the frame's maximum
    // OpenColorIO in the curve's place
    const char *config;    // file or ocio://NAME; NULL: no OCIO
    const char *input, *display, *view, *look; // NULL: the config's defaults
    const char *output;    // space of the lit frame; NULL: its own
    const char *const *context; // `contexts` of NAME=VALUE
    int contexts;
    bool any_primaries;    // frames are in `input` whatever they say
    bool shows;            // TONE will be run
};
#define GLAREPP_TONE_PARAMS                                                   \
    { sizeof(struct glarepp_tone_params), "neutral", 0.0f, false, 0.18f,      \
      0.0f, NULL, NULL, NULL, NULL, NULL, NULL, NULL, 0, false, true }

// -- plans --------------------------------------------------------------------

/* Directions of a frame's pixels, for models by angle.
 *   PLANE        degrees are proportional to pixels, and a kernel is the same
 *                everywhere: of pictures of no camera
 *   PERSPECTIVE  as a camera's: by its matrices, else by the angle of view
 *   LATLONG      the display window is the whole sphere, longitude along x, latitude
 *                along y; its width even, without prime factors over 127
 *   FISHEYE      equidistant, of the angle of view, else 180 degrees: pixels beyond
 *                half of that, and 90 degrees, from the axis are none
 *   EQUISOLID    the same, of pixels of one solid angle
 *   OF_FRAME     what the frame says, else PERSPECTIVE; the default */
enum {
    GLAREPP_PLANE,
    GLAREPP_PERSPECTIVE,
    GLAREPP_LATLONG,
    GLAREPP_FISHEYE,
    GLAREPP_EQUISOLID,
    GLAREPP_OF_FRAME
};

/* NULL: no lights, no lens, no scene; the defaults of the others. */
struct glarepp_plan_params {
    size_t size;
    const struct glarepp_kernel *kernel; // must outlive the plan; NULL:
                                         // builtin:eye
    double fov;     // vertical angle of the display window, under 180, of
                    // a fisheye to 360; 0: that of its camera, lens or
                    // scene, else 30
    int projection; // of frames: GLAREPP_OF_FRAME or another
    double rotate;         // of the kernel, degrees counter-clockwise
    const struct glarepp_sense_params *sense;
    const struct glarepp_layer_params *layer;
    const struct glarepp_light_params *lights;
    const struct glarepp_lens_params *lens;
    const struct glarepp_scene_params *scene;
    const struct glarepp_tone_params *tone;
    const struct glarepp_kernel *const *more; // `mores` of groups; they must
    int mores;                                // outlive the plan
    struct glarepp_plan *names; // its first frame names lights that are found;
                                // must outlive the plan; NULL: this plan
};
#define GLAREPP_PLAN_PARAMS                                                   \
    {                                                                         \
        sizeof(struct glarepp_plan_params), NULL, 0.0, GLAREPP_OF_FRAME, 0.0, \
            NULL, NULL, NULL, NULL, NULL, NULL, NULL, 0, NULL                 \
    }

struct glarepp_plan;

/* Makes a plan, reads the files that it names, and copies the parameters.
 * Kernels are made at the first frame of a field, and kept.
 * Errors: USAGE parameters that do not fit; those of reading. */
int glarepp_plan(struct glarepp *gp,
    const struct glarepp_plan_params *p, struct glarepp_plan **out);
void glarepp_plan_end(struct glarepp_plan **plan);

/* Facts of a plan. Strings live as long as it. */
struct glarepp_plan_facts {
    const char *const *file; // `files` that it was read from
    int files;
    // OpenColorIO: names as the config spells them, NULL: none
    const char *config, *input, *display, *view, *look, *output;
    const float *output_primaries; // 8; NULL: not known
    unsigned char cicp[2];         // ITU-T H.273 of the shown picture; 0: not
                                   // known
    bool lights;                   // a frame may have lights
};
const struct glarepp_plan_facts *
glarepp_plan_facts(const struct glarepp_plan *plan);

/* Adds glare: sources, layer and composing in one call.
 *   in   not changed, unless it is `out` or overlaps it
 *   out  of the same windows; the lit picture, scene-linear, of its own type
 *   facts  NULL: not wanted. It has no list of lights and no recipes; what it
 *          points to stays as long as the plan
 * Errors: USAGE images that do not fit; DATA; GL of engine "splat"; CANCELLED:
 * `out` is unchanged; BUG. */
struct glarepp_facts;
int glarepp_execute(struct glarepp_plan *plan,
    const struct glarepp_image *in, const struct glarepp_image *out,
    struct glarepp_facts *facts);

// -- frames, step by step -----------------------------------------------------

/* The kernel of a group, 0 the plan's, k its more[k - 1]; and its gain, 0 to 1e6,
 * which the layer has: lit = in - min(gain own, 1) source + gain own layer. */
struct glarepp_group {
    int kernel;
    float gain;
};

/* A frame, and what its file says of it; 0: it says nothing. */
struct glarepp_frame_params {
    size_t size;
    struct glarepp_image image;  // borrowed until the frame ends
    struct glarepp_rect file;    // of its data, pixels that were not added to it;
                                 // empty: all
    bool in_place;               // planes of float without gaps may be written:
                                 // nothing is copied
    const struct glarepp_image *group; // `groups` layers of its light, which
    int groups;                        // glare in its place, each composed too
    bool groups_glare;                 // ... and are not composed
    bool numbered;
    int number;
    double fps;
    bool has_camera, has_ndc;
    double to_camera[16];        // world to camera, row vectors
    double to_ndc[16];           // world to the picture
    enum glarepp_ndc ndc;        // its range
    double focus, aperture;      // m, f-number
    double sensor;               // mm, width
    double white;                // cd/m2 of scene value 1
    float noise; // share of a dark pixel that transforms in float
                 // may err by, else they are in double, 0 to 1:
                 // half's rounding, 4.9e-4, hides as much
    bool last;                   // no frame of this size follows soon: nothing is
                                 // kept for it
    bool layer_ends;             // GLARE is not looked at after COMPOSE
    bool details;                // facts that cost time are wanted: of sense the
                                 // luminances, of lights low and high, flux
                                 // of the layer, the truth
    void *user;                  // of messages about it
    bool parts;                  // PART_* are wanted
    const struct glarepp_group *how; // of each group; NULL: {0, 1}
    bool parts_of_groups; // ... after COMPOSE or DONE what groups spread is
                          // in their own GLARE, and not in PART_*
    int projection;       // what its file says; 0: nothing
    bool veil;            // facts.veil is wanted
    bool fixated;         // `fixation` is given; else the display's middle
    double fixation[2];   // where the eye looks, EXR pixel space
};
#define GLAREPP_FRAME_PARAMS                                                  \
    {                                                                         \
        sizeof(struct glarepp_frame_params), GLAREPP_IMAGE, {0, 0, 0, 0},     \
            false, NULL, 0, false, false, 0, 0.0, false, false, {0.0}, {0.0}, \
            GLAREPP_NDC_AUTO, 0.0, 0.0, 0.0, 0.0, 4e-4f, false, false, false, \
            NULL, false, NULL, false, 0, false, false,                        \
        {                                                                     \
            0.0, 0.0                                                          \
        }                                                                     \
    }

struct glarepp_frame;

/* Begins a frame. Any thread may begin and end it. Errors: USAGE an image that is
 * none, or a group of another window; BUG. */
int glarepp_frame(struct glarepp_plan *plan,
    const struct glarepp_frame_params *p, struct glarepp_frame **out);
void glarepp_frame_end(struct glarepp_frame **frame);

/* Pixels that the kernel of a frame reaches left, up, right and down, to grow a
 * frame by: of models, which have no end, as far as their core. */
struct glarepp_rect glarepp_frame_reach(struct glarepp_frame *frame);

/* Steps, in their order. One that the plan has nothing to do for is free. */
enum glarepp_step {
    GLAREPP_POSE,     // the scene, its camera and its lights
    GLAREPP_RELIGHT,  // adds their light; needs DEPTH, NORMAL, ALBEDO
    GLAREPP_PLACE,    // lights: facts.lights
    GLAREPP_SHARES,   // their visible shares, by DEPTH and COVERAGE if set
    GLAREPP_SENSE,    // sources
    GLAREPP_KERNEL,
    GLAREPP_LAYER,
    GLAREPP_VERIFY,   // the layer against the sum in double: facts.errors
    GLAREPP_FLARE,
    GLAREPP_LENS,
    GLAREPP_COMPOSE,
    GLAREPP_TONE,
    GLAREPP_DONE,     // gives engines and GL back to the plan, for another frame;
                      // the end of a frame does too
    GLAREPP_STEPS,
};

/* Runs a step. Steps before it that others do not need may be left out: without
 * LAYER, COMPOSE gives the frame as it is. A step may run again, which undoes
 * those after it; RELIGHT may not, nor FLARE and LENS (after a tint neither)
 * without a new LAYER.
 * Errors: those of the plan's parts; USAGE one that it needs was not run;
 * CANCELLED. */
int glarepp_frame_run(struct glarepp_frame *frame, enum glarepp_step step);

/* Planes of a frame. */
enum glarepp_view {
    // set by the caller; GLARE too, to compose another layer
    GLAREPP_DEPTH,    // plane[0], units of the world
    GLAREPP_COVERAGE, // plane[0], 0 clear to 1 opaque
    GLAREPP_NORMAL,   // may be turned in place
    GLAREPP_ALBEDO,
    // made by steps
    GLAREPP_CLEAN, // the frame after SENSE: no NaN, no infinity
    GLAREPP_SOURCES,
    GLAREPP_GLARE,  // the layer, with flare and ghosts; that of a group, times
                    // its gain, of a frame with `parts_of_groups`
    GLAREPP_LIT,    // scene-linear
    GLAREPP_SHOWN,  // display-linear BT.709, or as OpenColorIO encodes it
    GLAREPP_OUTPUT, // LIT in the tone's output space; before COMPOSE, the
                    // frame itself
    // pictures to look at
    GLAREPP_POLYGONS, // Ando et al. 2007, Figure 6, over SHOWN
    GLAREPP_SUNMAP,
    GLAREPP_INTENSITY,
    GLAREPP_TRUTH, // the sum in double, after VERIFY of a frame with `details`
    // of a frame with `parts`, which add up to GLARE: of the sources' light what
    // leaves its pixel, with that of lights beside the frame; what stays;
    // elements; ghosts of a lens
    GLAREPP_PART_VEIL,
    GLAREPP_PART_CORE,
    GLAREPP_PART_FLARE,
    GLAREPP_PART_GHOSTS,
    // set by the caller, before SENSE: plane[0], share of a pixel's light that
    // may glare; 0 outside of its window
    GLAREPP_SOURCE_MASK,
    // ... before SHARES: plane[0] is a struct glarepp_stored of deep data, borrowed
    // to the frame's end, with Z in the unit of DEPTH by distance, A and maybe ZBack,
    // in any order; it hides lights in place of DEPTH and COVERAGE
    GLAREPP_DEEP,
    GLAREPP_VIEWS,
};

/* Gives a frame a plane, borrowed until it ends. Errors: USAGE no such plane. */
int glarepp_frame_set(struct glarepp_frame *frame,
    enum glarepp_view view, const struct glarepp_image *plane);

/* Looks at a plane: a view that is valid until the frame ends or drops it.
 *   group  0 the frame, 1 and on its groups (of GLARE, LIT and OUTPUT)
 * Errors: USAGE the step that makes it was not run; BUG of pictures. */
int glarepp_frame_view(struct glarepp_frame *frame,
    enum glarepp_view view, int group, struct glarepp_image *out);

/* Frees planes that the library made, and gives back those that were set: bits
 * 1 << view. */
void glarepp_frame_drop(struct glarepp_frame *frame, unsigned views);

// -- facts --------------------------------------------------------------------

struct glarepp_sense_facts {
    long long sources, nonfinite, clamped; // pixels
    float threshold;         // T as luminance
    float brightest;         // largest channel of the sources
    double flux[3];          // of the sources
    double faint[3];         // of light under 1.2e-38, which counts as 0
    double flux_clamped[3];  // that max_value took
    float peak;              // of a frame without source, at pixel
    int peak_at[2];
    double light, bright, lamps; // luminance: of the frame; that is spread, of
                                 // bright pixels, of lights
};

struct glarepp_kernel_facts {
    int recipes;             // 0: an image
    double pupil[8];         // of each, mm; 0: none
    const char *recipe[8];   // each, as it was made for the frame
    int w, h, grid;          // samples at full rate; pixels between the others,
                             // 0: no others. w 0: no kernel was needed
    bool modelled;           // the next two are known
    double left_out, missed; // light outside of it; of which in the frame
    double faint[3];
    double fov, deg_per_pixel; // 0: not by angle
    const char *projection;    // "plane", "perspective", "latlong", "fisheye",
                               // "equisolid"
    const char *fov_from;    // "option", "camera", "lens", "default"
    double ms, cpu_ms;       // of making it; 0: it was kept
};

struct glarepp_layer_facts {
    const char *engine;      // that ran; NULL: none
    char why[256];           // "": it was named
    double bound;            // of rel_l2, guaranteed before the run
    double bound_angle;      // of which that is of true angles; 0: none
    double bound_pixel;      // of max_rel; 0: not asked for
    int fft_w, fft_h;        // transform; 0: none
    bool in_double;
    long long groups, clusters, polygons, cores; // of splat
    double polygon_pixels;
    const char *form;        // in which polygons were drawn; NULL
    const char *gl;          // renderer; NULL
    double flux[3];          // of the layer with flare and ghosts, in the frame
};

/* Errors of a layer against the sum in double. */
struct glarepp_errors {
    double rel_l2;     // |layer - exact| / |exact|, norms over all samples
    double max_rel;    // largest |dY| / (Y of the picture + 1e-6 of its maximum)
    double max_abs;
    double flux_error; // of the light in all
    long long pixels;  // that were summed: of many sources by true angles some
    double off;        // share of these whose layer is off by over 0.5 %
};

/* A light in a frame. */
struct glarepp_share {
    char name[64];
    double x, y, radius, depth; // pixels; depth as the channel counts it
    float flux[3];
    bool behind, in_frame;
    double visibility;          // 0 hidden to 1 clear
    double low, high;           // between which the true share is
    bool found;                 // by SENSE
    double sun_degrees;         // of a sun of the scene, and
    const char *sun_from; // "scene", "option", "default"; NULL: it is none
};

struct glarepp_flare_facts {    // of bright pixels
    int elements, runs;
    const char *engine;
    double bound, ms, cpu_ms;
    double gain; // of all elements; 0: there are none
};

struct glarepp_lens_facts {
    const char *name;           // NULL: no lens
    double sensor;              // mm
    const char *sensor_from;    // "option", "angle", "attribute", "lens",
                                // "default"
    double rest;                // share of the sources without ghosts
    double bound;               // of rel_l2 of the layer, of ghosts left out
    int lights, ghosts;         // with light; pairs of surfaces
    int drawn, left_out;        // pairs
    double light[3];            // of the ghosts, inside and outside the frame
    double lost;                // share of their light whose rays miss a surface
                                // or are reflected wholly
    double dark;                // luminance at a pixel of all ghosts left out,
                                // by first order, over the picture's mean
    double missing;             // bound of their norm over pixels and channels
    double steps[5];            // ghosts drawn at 1, 2, 4, 8, 16 pixels a step
    double gain;                // that they were drawn with
};

struct glarepp_scene_facts {
    const char *path;           // NULL: no scene
    double seconds;
    const char *camera;         // of the scene, where the frame has none
    bool compared;              // both have one,
    double apart;               // pixels between them
};

struct glarepp_relit {
    const char *name;
    long long pixels, rays;
    int casters;
};

/* Zero and NULL fields were not needed. */
struct glarepp_facts {
    struct glarepp_sense_facts sense;
    struct glarepp_kernel_facts kernel;
    struct glarepp_layer_facts layer;
    bool verified;
    struct glarepp_errors errors;
    const struct glarepp_share *light;
    int lights;
    const char *shares_by;      // method; NULL: no lights
    const char *shares_gl;      // renderer
    char depth_empty[64];       // values that count as no surface
    bool depth_reversed;
    struct glarepp_flare_facts flare;
    struct glarepp_lens_facts lens;
    struct glarepp_scene_facts scene;
    const struct glarepp_relit *relit;
    int relits;
    double engines_ms, engines_cpu_ms; // of the last step, by engines
    /* The veil of the frame's light in an eye, by SENSE, in cd/m2 and lux: equations in
     * glare/veil.h. NAN: not known. */
    struct {
        const char *missing; // why it has no figures; NULL: it has
        double white;        // cd/m2 of scene value 1; 0: no figures
        double at[2];        // where the eye looks
        double age, pigment; // of the first kernel that has them, else 35, .5
        double seen; // share of light of an even sky that is in the frame
        double illuminance;          // at the eye
        double luminance;            // equivalent veiling luminance
        double luminance_of_sources; // of which of glare sources
        double fixated;              // mean luminance of the fixated degree
        double threshold_increment;  // percent, by sources
        int sources;                 // and the luminance that they are over
        double source_threshold;
        bool rated; // the frame is wide enough for
        double ugr, dgp;
    } veil;
};
const struct glarepp_facts *
glarepp_frame_facts(const struct glarepp_frame *frame);

// -- lenses -------------------------------------------------------------------

/* Two surfaces of a lens that reflect, in first order: rays of a light of slope u
 * that enter at heights r reach the sensor at a r + b u. */
struct glarepp_ghost {
    int first, second;     // surfaces, from 0; first > second
    double a, b;
    double radius, shift;  // mm: they pass all rims in the disc of this
                           // half-width around shift u
    double through;        // share of light that does
};

/* A prescription, and its first-order optics at the d line, focused far away.
 * Lengths are in mm. */
struct glarepp_lens {
    char name[128], patent[128], note[256];
    double claims_focal, claims_f_number, claims_back, claims_height; // 0: none
    int surfaces, stop;    // the stop's index
    int blades;            // 0: round
    double focal, back, pupil, f_number; // pupil: half the entrance's diameter
    double height;         // half of the image's diagonal; 0: unknown
    double through;        // share of light that crosses on the axis
    struct glarepp_ghost *ghost; // `ghosts` of them, freed by glarepp_lens_end()
    int ghosts;
    void *own;
};

/* Reads a prescription: JSON, or an installed name.
 * Errors: IO; DATA it is none; USAGE it cannot be focused. */
int glarepp_lens(struct glarepp *gp, const char *lens,
                 struct glarepp_lens *out);
void glarepp_lens_end(struct glarepp_lens *lens);

/* Draws it in section, with the rays of a ghost (or NULL), as SVG. Returns the
 * text, which glarepp_lens_end() frees; NULL where memory is full, or the lens
 * has no such surfaces. */
const char *glarepp_lens_draw(struct glarepp_lens *lens,
                                          const struct glarepp_ghost *ghost);

// -- visibility sets ----------------------------------------------------------

/* O'Rorke's renderer over a scene, with one test of visibility after another:
 * Table 15-1 of GPU Gems. */
struct glarepp_sets_params {
    size_t size;
    const char *path;      // .glb or .gltf
    const char *camera;    // name; NULL: the only one
    enum glarepp_up up;
    bool timed;            // `seconds` is given; else the scene's first
    double seconds;
    int w, h;              // of the picture
    double near;           // surfaces nearer are not drawn, unless the camera
                           // says how near
    double light_scale;    // picture's units a cd or lux
    double ambient;        // light that comes back from white, everywhere
    int map;               // texels, side of a shadow map
    bool separate;         // a shadow batch for each material
    int runs, occluders;   // timed runs; objects that are drawn first
    enum glarepp_gl gl;
};
#define GLAREPP_SETS_PARAMS                                                   \
    { sizeof(struct glarepp_sets_params), NULL, NULL, GLAREPP_UP_AUTO, false, \
      0.0, 960, 540, 0.1, 1.0 / 683.0, 0.02, 256, false, 3, 40,               \
      GLAREPP_GL_AUTO }

/* A row of the table; the first is the frustum's, each has the tests of those
 * before it too. */
struct glarepp_sets_row {
    const char *name;
    int visible, lit, casters; // objects of V; of I and S over all lights
    int lights, passes, batches, shadow_batches;
    int separate_batches;  // with a shadow batch for each material
    long long fragments;   // -1: the context does not count them
    double ms, cpu_ms;     // least of the runs
    bool same;             // the same picture as the first row's, byte for byte
};

struct glarepp_sets {
    struct glarepp_sets_row row[5];
    int objects, lights;
    double seconds;        // of the scene
    const char *gl;        // renderer
    const char *const *light;           // names
    const struct glarepp_rect *scissor; // of each light in the last row; empty:
                                        // it lights nothing
    const double (*depth)[2];           // ... near and far, along the view axis
    void *own;
};

/* Draws all rows. Errors: those of reading the scene and of its camera; USAGE a
 * size, map or number of runs that is too small; GL; BUG. */
int glarepp_sets(struct glarepp *gp,
    const struct glarepp_sets_params *p, struct glarepp_sets *out);
void glarepp_sets_end(struct glarepp_sets *sets);

/* Looks at a picture of w x h: GLAREPP_LIT what was drawn; GLAREPP_SHOWN the
 * outlines of the scissors over it; GLAREPP_SOURCES the scene from above, each
 * object in the colour of its sets, display-linear. Valid until the next one. */
int glarepp_sets_view(struct glarepp_sets *sets,
    enum glarepp_view view, struct glarepp_image *out);

// -- comparison ---------------------------------------------------------------

/* A channel as a file stores it: a value for each pixel of `data`, rows from the
 * top, or for each sample of deep data. */
struct glarepp_channel {
    const char *name;
    const void *v;         // uint32_t where `is_uint`, else float
    bool is_uint;
};

struct glarepp_stored {
    size_t size;
    const char *name;      // for messages; NULL: "image"
    struct glarepp_rect data;
    const struct glarepp_channel *channel;
    int channels;
    const int64_t *first;  // of deep data: samples of pixel i are
                           // v[first[i]] to v[first[i + 1] - 1]; NULL: flat
    bool integers;         // display-referred
    const float *light[3]; // linear colour of `data`, for FLIP; NULL: none
    const float *primaries; // NULL: BT.709
};

/* Limits as idiff has them, and the program's own. */
struct glarepp_compare_params {
    size_t size;
    float fail, warn;                   // absolute
    float fail_relative, warn_relative; // of the mean of both magnitudes
    float fail_percent, warn_percent;   // of pixels that may be over it
    float hard_fail, hard_warn;         // that no pixel may exceed
    int allow_failures;                 // pixels; < 0: all
    float fail_flip, fail_rel;          // mean FLIP, rel_l2
    bool perceptual;                    // counts what an eye sees (Yee 2004)
    bool flip;
    float start, stop;                  // exposures of HDR-FLIP, EV, and
    int exposures;                      // their number; 0: those that fit
    long long most;                     // pixels of both windows together
};
#define GLAREPP_COMPARE_PARAMS                                                \
    { sizeof(struct glarepp_compare_params), 1e-6f, 1e-6f, 0.0f, 0.0f, 0.0f,  \
      0.0f, __builtin_inff(), __builtin_inff(), 0, __builtin_inff(),          \
      __builtin_inff(), false, true, 0.0f, 0.0f, 0, 1LL << 28 }

/* Errors of b against a over the union of their windows. */
struct glarepp_compare_facts {
    struct glarepp_rect window;
    int pairs;              // of channels
    const char *const *pair; // their names
    const int *in_a, *in_b; // their channels in each; -1: none, 0 everywhere
    double max;             // largest |a - b|, at a pixel of a pair
    int x, y, channel;
    double worst_a, worst_b;
    double mean, rms, psnr; // of |a - b|; dB
    double rel_l2;          // |a - b| / |a|, norms
    double max_rel;         // |dY| / (Y of a + 1e-6 of its maximum); NAN: one has
                            // no colour
    long long nonfinite, uneven; // values; deep pixels of other numbers of
    int uneven_x, uneven_y;      // samples, the first of them
    long long warned, failed;    // pixels over a limit
    long long seen;         // by an eye; -1: not counted
    long long pixels;       // of a
    bool lit;               // both have colour
    bool has_flip, hdr;     // HDR-FLIP, else LDR
    double flip;            // mean
    float start, stop;      // of HDR-FLIP
    int exposures;
    int result;             // 0 match, 1 warning, 2 failure: as idiff's status
    /* Gates that judged, the worst of which is the result: pixels over `fail`, or that an
     * eye sees; hard_fail, fail_rel, fail_flip; pixels over `warn`; hard_warn. */
    struct {
        double found, limit; // NAN: it has none
        int result;
    } gate[6];
};

struct glarepp_compare;

/* Compares two images. They and their lists must outlive *out. The same for any
 * number of threads. Errors: DATA windows too far apart, or only one is deep;
 * USAGE no window, or no such exposures; BUG. */
int glarepp_compare(struct glarepp *gp,
    const struct glarepp_compare_params *p, const struct glarepp_stored *a,
    const struct glarepp_stored *b, struct glarepp_compare **out);
void glarepp_compare_end(struct glarepp_compare **compare);

const struct glarepp_compare_facts *
glarepp_compare_facts(const struct glarepp_compare *compare);

/* Makes a picture of the window, freed by glarepp_image_end().
 *   pair      -1: FLIP's map in colours of magma, display-linear; -2: the map, in
 *             plane[0]; else a - b of that pair, in plane[0], times `scale`, and
 *             its magnitude where `absolute`
 * Errors: USAGE deep images; no FLIP; BUG. */
int glarepp_compare_view(const struct glarepp_compare *compare,
    int pair, bool absolute, float scale, struct glarepp_image *out);

#pragma GCC visibility pop

#ifdef __cplusplus
}
#endif

#endif
