// SPDX-License-Identifier: Apache-2.0
/* Models of glare: point-spread functions of eyes and lenses as formulas of the
 * angle, and the kernels that they make for a frame.
 *
 * A recipe is a model with its keys, written MODEL:key=value,key=value; in a
 * file's name a backslash goes before a comma or backslash. Several recipes make
 * one kernel,
 *
 *   kernel = delta + sum over recipes i of s_i (shape_i - delta)
 *
 * where delta is the light that stays in its pixel, shape_i the model's light
 * over the field, 1 in luminance over the hemisphere, and s_i its `share`. Where
 * shares add up to more than 1, each is divided by their sum. What a tint takes
 * less of than of another channel stays in the pixel, but for an image's, whose
 * tint is its own: all light of each channel is kept, but for what falls outside
 * of what is computed, gp_kernel.left_out.
 *
 * Colours are sums over wavelengths in the frame's primaries. Where such a sum
 * has a negative channel it is moved towards grey of its luminance until that is
 * 0: by the pixel in `aperture` and `temporal`, by the angle in others.
 *
 * Angles are taken as proportional to pixels over the whole field, as in
 * Spencer et al. 1995 section 3.2: pixel (dx, dy) away from a light lies
 *   t = degrees * hypot(aspect * dx, dy)
 * degrees from it, and takes P(t) times its solid angle, the area in degrees
 * times (pi / 180)^2 sin(t) / t. Beyond 45 degrees places of the frame are
 * crowded together in the sky, so that its edge at 90 degrees is never met. */
#ifndef GP_GLARE_MODEL_MODEL_H
#define GP_GLARE_MODEL_MODEL_H

#include "core/image.h"
#include "core/projection.h"
#include "core/status.h"
#include "glare/kernel.h"

#include <stdbool.h>

enum {
    GP_MODEL_KEYS = 40, // most of one model
    GP_RECIPES = 8,     // most of one kernel
};

/* A key of a model: a number, a word, or a file. */
struct gp_model_key {
    const char *name;          // NULL ends a list
    const char *text;          // one line of help, with the unit
    double preset, lo, hi;     // value when not given; range, both included
    const char *const *words;  // NULL-terminated names of 0, 1, ...; NULL: a
                               // number; gp_model_file: a path, which must be
                               // given where `preset` is 1
};
static const char *const gp_model_file[] = {NULL};

static inline bool gp_model_key_is_file(const struct gp_model_key *k)
{
    return k->words && !k->words[0];
}

struct gp_field;
struct gp_recipe;
struct gp_shape; // model_priv.h

/* A model of the angle alone, the same in all directions. */
struct gp_angular {
    /* Light of channel c per steradian t degrees from its source, 0 to 100, up to a
     * factor. */
    double (*light)(const struct gp_angular *a, int c, double t);
    double v[96];      // the model's own figures
    bool tint;         // channels differ, as much light as each has
    const char *lacks; // that which this field cannot have; NULL: nothing
    double stays;      // light that stays in its pixel: 0 to 1
    double bends; // degrees within which light may bend on any scale, not only
                  // on that of the angle
};

struct gp_model {
    const char *name, *text, *source; // one line; paper and equation
    const struct gp_model_key *keys;  // the first is `share`
    bool moves;       // it depends on the frame's number

    /* The pupil's diameter, mm, and whether the key `adaptation` decides it.
     * NULL: it has no pupil, no adaptation. */
    double (*pupil)(const struct gp_recipe *r, const struct gp_field *f);
    bool (*adapts)(const struct gp_recipe *r);

    /* Finds the recipe as a model of the angle; false: it is none. NULL: it never
     * is. */
    bool (*angular)(const struct gp_recipe *r, const struct gp_field *f,
                    struct gp_angular *out);
    /* open() of what it has beside that, the same in all the frame, as in its middle,
     * whose sum is 0; row stays NULL where it has nothing. NULL: it never has. */
    gp_status (*rest)(const struct gp_log *log, const struct gp_recipe *r,
                      const struct gp_field *f, struct gp_shape *out);

    /* Evaluates what depends on recipe and field. The shape's luminance sums to
     * 1 over the hemisphere (over the plane for what has no angle).
     * Written only on GP_OK. Errors: those of gp_model_kernel(). */
    gp_status (*open)(const struct gp_log *log, const struct gp_recipe *r,
                      const struct gp_field *f, struct gp_shape *out);
};

/* Models in the order of the manual; NULL-terminated. */
extern const struct gp_model *const gp_models[];

/* Names for recipes: "builtin:NAME", or NAME where no model has it. */
struct gp_model_preset {
    const char *name, *recipe, *text;
};
extern const struct gp_model_preset gp_model_presets[]; // ends with name NULL

/* A model and the values of its keys, in their order. */
struct gp_recipe {
    const struct gp_model *model;
    double value[GP_MODEL_KEYS];
    bool written[GP_MODEL_KEYS];   // in a recipe or preset
    char *file[GP_MODEL_KEYS];     // owned; NULL where not given
    const struct gp_image *image;  // of its file; borrowed, set by the
                                   // caller before a kernel is made
    bool as_it_is;                 // an image of shares of light, as of a model:
                                   // not normalised to a luminance of 1
};

/* True where `text` is a recipe or a preset, not a file's path: it begins with
 * "builtin:", or with a model's or preset's name and ":", or is such a name. */
bool gp_recipe_is(const char *text);

/* Reads a recipe. Written only on GP_OK; free with gp_recipe_free().
 * Errors: GP_ERR_USAGE no such model, key or word (names the nearest and all); a
 * value out of range (says the range); a key twice; no file for its key. */
GP_MUST_CHECK gp_status gp_recipe_parse(const struct gp_log *log,
                                        const char *text,
                                        struct gp_recipe *out);
void gp_recipe_free(struct gp_recipe *r);

/* Sets a key that its recipe did not write, to `value` or the nearest in its
 * range. A model without the key stays as it is. */
void gp_recipe_preset(struct gp_recipe *r, const char *key, double value);

/* True where the recipe's pupil is that of the frame's own luminance. */
bool gp_recipe_adapts(const struct gp_recipe *r);

/* Sets the adaptation of a recipe that adapts, for a frame whose mean is `mean`
 * in scene-linear luminance and whose 1.0 is `white` cd/m2, but for a key `white`
 * that is not 0. Others stay as they are. */
void gp_recipe_adapt(struct gp_recipe *r, double mean, double white);

#define GP_USUAL_WHITE 100.0 // cd/m2 of scene value 1, where no file says it

/* The recipe of an image file: model `image`, share 1, `degrees` high, or where
 * that is 0 `percent` of its pixels. As gp_recipe_parse(). */
GP_MUST_CHECK gp_status gp_recipe_of_image(const struct gp_log *log,
    const char *path, double degrees, double percent, struct gp_recipe *out);

/* Writes the recipe with every key that is not at its preset, shortest digits
 * that read back to the same value, so that parsing it gives the same kernel
 * byte for byte. Owned by the caller; NULL out of memory. */
char *gp_recipe_text(const struct gp_recipe *r);

/* The path that the recipe wants read into `image`; NULL: none. */
const char *gp_recipe_file(const struct gp_recipe *r);

/* The path of a kernel's image: of `word` as a recipe that has one, else as a
 * path. Owned by the caller; NULL: none, or memory is full. */
char *gp_kernel_path(const char *word);

/* The frames that a kernel is made for. */
struct gp_field {
    int w, h;             // pixels, >= 1: offsets up to w - 1, h - 1 are met
    double degrees;       // a pixel's height in degrees of view, > 0
    double aspect;        // its width over its height
    double rotate;        // degrees, counter-clockwise as seen (y is down)
    float chromaticities[8]; // of the frame, as struct gp_image's
    float luminance[3];   // weights of these primaries
    int frame;            // its number, for models that change in time
    double fps;           // frames a second, > 0
    double tolerance;     // of rel_l2; 0: as by default
    // of another projection than PLANE, models of the angle alone go by true
    // angles, in a frame of its own size, whose corner the places count from; others
    // go by `degrees`, those of its middle
    struct gp_projection projection;
    int seen_w, seen_h;
    double
        tangent; // of the largest angle from a camera's axis, of its frame and of as
                 // much overscan as comes with it
    // a sample is a node of light, of which a pixel is so many wide along each axis; 0:
    // a sample is a pixel
    double nodes;
};

#define GP_USUAL_FOV 30.0 // degrees, where nothing says another

/* The field of a frame whose display window is fov degrees high. */
struct gp_field gp_field_of(const struct gp_image *f, double fov);

/* The diameter of the recipe's pupil in a field, mm; 0: the model has none. */
double gp_recipe_pupil(const struct gp_recipe *r, const struct gp_field *f);

/* The value of a recipe's key; `otherwise` where its model has none of that name. */
double gp_recipe_key(const struct gp_recipe *r, const char *key,
                     double otherwise);

/* The general equation of CIE 146 (2002) at t degrees, 0.1 to 100, per steradian: years
 * of age and pigment as the keys of the model cie. */
double gp_cie_general(double age, double pigment, double t);

/* Makes the kernel of n recipes, 1 to GP_RECIPES, for a field: where every
 * recipe is smooth far out, a core at full rate in out->k and the rest in
 * out->far, else all in out->k: sum + left_out = 1 in luminance.
 * Written only on GP_OK; free with gp_kernel_free().
 * Errors: GP_ERR_USAGE an angle that is not finite, a key that this field
 * cannot serve; GP_ERR_DATA a bad mask or image. */
GP_MUST_CHECK gp_status gp_model_kernel(const struct gp_log *log,
    const struct gp_recipe *r, int n, const struct gp_field *field,
    struct gp_kernel *out);

/* Every sample that a frame of w x h pixels can meet, at full rate, offsets
 * -(w - 1) .. w - 1 and -(h - 1) .. h - 1, with no far field: what the engine
 * `direct` and the truth sum. Of a kernel without far field a copy of k.
 * Written only on GP_OK. */
GP_MUST_CHECK gp_status gp_kernel_whole(const struct gp_log *log,
    const struct gp_kernel *k, int w, int h, struct gp_kernel *out);

#endif
