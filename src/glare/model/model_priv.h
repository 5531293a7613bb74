// SPDX-License-Identifier: Apache-2.0
/* Shared by the models and their tests. */
#ifndef GP_GLARE_MODEL_MODEL_PRIV_H
#define GP_GLARE_MODEL_MODEL_PRIV_H

#include "core/colour.h"
#include "core/maths.h"
#include "glare/model/model.h"
#include "glare/curve.h"

#include <stdint.h>
#include <string.h>

/* A model for one field: the light that a source of 1 leaves in each pixel.
 * Both are areas: a pixel shines evenly, so that a scene has one glare at all
 * resolutions. */
struct gp_shape {
    void *state;            // owned, freed by `free`
    void (*free)(void *state);

    /* Integrals over the pixels of offsets (x, y) .. (x + n - 1, y), mean of
     * all places in the light's pixel, n <= GP_SHAPE_STRIP, to out[c][0 .. n):
     * about 1e-7 of the value, never point-sampled. Called from several
     * threads; a pixel's value does not depend on the strip it is in. */
    void (*row)(const void *state, int x, int y, int n, double *const out[3]);

    double own[3];   // light of offset (0, 0) that row() does not write; of
                     // nodes, of the pixel
    bool grey;       // the three channels are equal: row writes out[0] only
    bool even;       // the same at (-x, y) and (x, -y)
    bool negative;   // samples may be
    double over;     // as gp_kernel's, where samples are negative; 0: unknown
    double smooth;   // pixels from the centre from which on it bends only on
                     // the scale of the distance; INFINITY: sharp far out
    int reach;       // offsets beyond are 0 in x and y; INT_MAX: none

    /* The part of row() to which `smooth` applies, and all of row() at offsets
     * beyond `sharp`; out[0] only where far_grey. NULL: all of it, and the
     * members that follow mean nothing. */
    void (*far)(const void *state, int x, int y, int n, double *const out[3]);
    bool far_grey, far_even; // as `grey` and `even`
    /* At `pixels` from the centre row() is at least this share of far(), in
     * [0, 1], and no less farther out. */
    double (*least)(const void *state, double pixels);
    int sharp;
};
enum { GP_SHAPE_STRIP = 256 };

extern const struct gp_model gp_model_spencer;                     // eye.c
extern const struct gp_model gp_model_cie;                         // cie.c
extern const struct gp_model gp_model_aperture, gp_model_temporal; // aperture.c
extern const struct gp_model gp_model_gaussian, gp_model_moffat,
    gp_model_halation, gp_model_circle, gp_model_ring,
    gp_model_image;                                               // drawn.c
extern const struct gp_model gp_model_star, gp_model_cross,
    gp_model_streak;                                              // rays.c

/* Keys of the luminance that an eye is adapted to. */
#define GP_MODEL_ADAPTATION(preset)                                           \
    { "adaptation", "luminance that the eye is adapted to, cd/m2; 0 takes "   \
      "the mean of each frame", preset, 0, 1e6, NULL },                       \
    { "white", "cd/m2 of scene value 1, for that mean; 0 takes the file's "   \
      "whiteLuminance, else 100", 0, 0, 1e6, NULL }

/* The recipe's value of a key of its model, by name. */
static inline double gp_recipe_value(const struct gp_recipe *r,
                                     const char *key)
{
    int i = 0;
    while (strcmp(r->model->keys[i].name, key) != 0)
        i++;
    return r->value[i];
}

/* The key that all models begin with; `preset` is the model's own share. */
#define GP_MODEL_SHARE(preset)                                                \
    { "share", "share of a pixel's light that the model takes", preset, 0.0,  \
      1.0, NULL }

/* A number in [0, 1) of (seed, i), the same everywhere: splitmix64, Steele et
 * al. 2014. */
static inline double gp_model_random(uint64_t seed, uint64_t i)
{
    uint64_t z = (seed << 32) + (i + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double) ((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

// -- quadrature.c --------------------------------------------------------------

/* Light per square degree, t >= 0 degrees from its source. It may be steep at 0
 * and fall by any power. */
typedef void (*gp_profile)(const void *ctx, double t, double out[3]);

/* The integral of a profile over the plane from `from` to `end` degrees away
 * from the light: about 1e-9. */
void gp_profile_integral(gp_profile p, const void *ctx, int channels,
                         double from, double end, double sum[3]);

/* sin(t) / t of t degrees, times a square degree in steradians: makes light per
 * steradian light per square degree of the plane. 0 from 90 degrees on. */
double gp_plane_factor(double t);

/* The second integral of the normal density of width 1, from the right: that of
 * (t - z) times the density over t from z on. Within 1e-10 of its value. */
double gp_normal_twice(double z);

// -- quadrature.c: samples, and deposits ----------------------------------------

/* Samples of a shape, times `scale`; (cx, cy) is the centre. */
struct gp_samples {
    int w, h, cx, cy, channels;
    struct gp_planes k;
    double scale[3];
};

/* Makes a shape of samples of offsets -rx .. rx, -ry .. ry, for the caller to fill. */
GP_MUST_CHECK gp_status gp_samples_make(const struct gp_log *log, int channels,
                                        int rx, int ry, struct gp_shape *out);

/* Makes a shape of planes of w x h samples; takes them, also on failure. */
GP_MUST_CHECK gp_status gp_samples_shape(const struct gp_log *log, int w, int h,
                                         int cx, int cy, int channels,
                                         struct gp_planes *k,
                                         struct gp_shape *out);

/* Light of shapes finer than a pixel, by offsets -rx .. rx, -ry .. ry. Light
 * that is even over a pixel and moved by (u, v) pixels falls on pixel (x, y) by
 * tent(u - x) tent(v - y), tent(t) = max(0, 1 - |t|): its integral over both
 * pixels. Tents add up to 1, so all light is kept whatever points stand for a
 * shape; what falls beyond rx and ry is dropped. */
struct gp_deposit {
    int channels, rx, ry;
    double *v[3]; // rows of 2 rx + 1; v[0] is owned
};
GP_MUST_CHECK gp_status gp_deposit_make(const struct gp_log *log, int channels,
                                        int rx, int ry, struct gp_deposit *out);
void gp_deposit_add(const struct gp_deposit *d, double u, double v,
                    const double light[3]);

/* A shape's row from what was added; 0 beyond. */
void gp_deposit_row(const void *deposit, int x, int y, int n,
                    double *const out[3]);

/* Puts a shape of offsets up to rx and ry slices of a pixel together,
 * slices[0] by slices[1] of them to a pixel of the field: light of a slice is
 * even too. Frees the shape on an error. */
GP_MUST_CHECK gp_status gp_slices_join(const struct gp_log *log,
    const int slices[2], int rx, int ry, const struct gp_field *f,
    struct gp_shape *shape);

// -- radial.c -----------------------------------------------------------------

/* A shape of a profile that is smooth but at 0. Fills all of `out` but
 * `smooth`; `ctx` is not kept. Channels: 1 or 3. Within `bends` degrees it may
 * bend on a scale of a few pixels. */
GP_MUST_CHECK gp_status gp_radial_shape(const struct gp_log *log, gp_profile p,
    const void *ctx, int channels, double bends, const struct gp_field *f,
    struct gp_shape *out);

// -- eye.c ---------------------------------------------------------------------

/* The shape of a profile of the sky: gp_radial_shape(). */
GP_MUST_CHECK gp_status gp_sky_shape(const struct gp_log *log, gp_profile p,
                                     const void *ctx, int channels,
                                     double bends, const struct gp_field *f,
                                     struct gp_shape *out);

/* Spencer's f0 to f3, per steradian. */
double gp_spencer_term(int i, double t, double nm);

// -- diffract.c ---------------------------------------------------------------

/* The plane that light passes, as square cells around its centre; x right, y
 * down, as it is seen. */
struct gp_pupil {
    int n;       // cells a side, a multiple of 8
    double cell; // mm
    float *t;    // amplitudes that pass, in [0, 1], n * n
    float *path; // added length of the light's path, nm; NULL: 0
};

/* Edges of a regular polygon, whose spikes are known far out. */
struct gp_blades {
    int n;          // 0: no such edges
    double turn;    // radians counter-clockwise, of the normal of the first
    double length;  // mm, of each
    double bend;    // mm, its radius, over which it turns; at most 1e9
};

struct gp_diffraction {
    const char *name; // of the model, for messages
    double diameter;  // mm, of all openings
    bool corners;     // they reach into those of the square around it
    double reach;     // degrees from the light; before it the mean far out
                      // takes over; where cells resolve less, the blades'
                      // spikes before that
    double sampled;   // what is narrow fades from this share of the reach on
    double nm;        // one wavelength; 0: daylight in `bands`
    int bands;        // 1 to 256
    double steep;     // nm of path a mm, the most that changes; 0: no path
    struct gp_blades blades;
    void (*draw)(const void *ctx, const struct gp_pupil *p, int y);
    const void *ctx;  // `draw` writes row y of t (all 0) and path (all 0), from
                      // several threads
};

/* Makes the shape of light behind a pupil, white in sum. Fills all of `out`.
 * Errors: GP_ERR_DATA the pupil is dark. */
GP_MUST_CHECK gp_status gp_diffract(const struct gp_log *log,
    const struct gp_diffraction *d, const struct gp_field *f,
    struct gp_shape *out);

// -- aperture.c: pupils -------------------------------------------------------

/* The pupil's diameter, mm, of eyes adapted to `nits` cd/m2: Moon and Spencer
 * 1944 in the form of Watson and Yellott 2012, eq. 3, with log10; and their own
 * for two eyes of `age` that see `area` square degrees, eqs. 21 to 23. */
double gp_pupil_moon_spencer(double nits);
double gp_pupil_watson(double nits, double area, double age);

// -- diffraction --------------------------------------------------------------

/* sin(pi x) / (pi x) */
static inline double gp_sinc(double x)
{
    return fabs(x) > 1e-8 ? gp_sin(M_PI * x) / (M_PI * x) : 1.0;
}

/* Spectra of a kernel: [c][block of GP_LANES x][y][x in it], x in [0, nx / 2],
 * y in [0, ny). */
enum { GP_LANES = 16 };
struct gp_spectra {
    int channels, blocks;
    float *re[3], *im[3]; // im is NULL where it is 0: the pupil has no path
};

/* Sums the spectra of all wavelengths for a kernel of period[0] x period[1]
 * pixels, each pixel[0] x pixel[1] degrees. Free with gp_spectra_free().
 * Errors: those of gp_diffract(). */
GP_MUST_CHECK gp_status gp_spectra_make(const struct gp_log *log,
    const struct gp_diffraction *d, const struct gp_field *f,
    const struct gp_pupil *p, const int period[2], const double pixel[2],
    struct gp_spectra *out);

/* Light at a frequency of (x, y) periods, >= 0; ny is period[1]. */
static inline float *gp_spectra_at(const struct gp_spectra *s, int c, int x,
                                   int y, int ny)
{
    const size_t row = (size_t) (x / GP_LANES) * (size_t) ny + (size_t) y;
    return s->re[c] + row * GP_LANES + (size_t) (x % GP_LANES);
}
void gp_spectra_free(struct gp_spectra *s);

// -- nodes.c: light that goes by nodes, of which a pixel is so many wide -------

/* Takes light that is finer than a pixel out of the spectra; it stays there. */
void gp_finest_take(const struct gp_spectra *s, const int period[2],
                    double nodes, double own[3]);

/* Makes K of samples of D, planes of w x h nodes: sky/cosines.h. *wrong is struct
 * gp_cosines'. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_nodes_divide(const struct gp_log *log, int w, int h,
                                        double nodes, struct gp_planes *k,
                                        double *wrong);

#endif
