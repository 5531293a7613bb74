// SPDX-License-Identifier: Apache-2.0
/* Fields and recipes for tests of models. */
#ifndef GP_TESTS_MODEL_SCENE_H
#define GP_TESTS_MODEL_SCENE_H

#include "core/colour.h"
#include "glare/model/model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Frames in Rec.709 with pixels so many degrees high. */
static inline struct gp_field scene_field(int w, int h, double degrees,
                                          double aspect)
{
    struct gp_field f = {
        .w = w, .h = h, .degrees = degrees, .aspect = aspect, .fps = 24.0,
    };
    memcpy(f.chromaticities, gp_rec709_chromaticities, sizeof f.chromaticities);
    memcpy(f.luminance, gp_rec709_luminance, sizeof f.luminance);
    return f;
}

/* A recipe that is right. */
static inline struct gp_recipe scene_recipe(const char *text)
{
    struct gp_recipe r;
    if (gp_recipe_parse(NULL, text, &r)) {
        fprintf(stderr, "%s: cannot be parsed\n", text);
        abort();
    }
    return r;
}

/* The kernel of one recipe. */
static inline void model_make(const char *text, const struct gp_field *f,
                              struct gp_kernel *k)
{
    struct gp_recipe r = scene_recipe(text);
    if (gp_model_kernel(NULL, &r, 1, f, k)) {
        fprintf(stderr, "%s: cannot be made\n", text);
        abort();
    }
    gp_recipe_free(&r);
}

/* A channel's sample at an offset; 0 outside. */
static inline double sample_at(const struct gp_kernel *k, int c, int dx,
                               int dy)
{
    const int x = dx + k->cx, y = dy + k->cy;
    return x < 0 || y < 0 || x >= k->w || y >= k->h
               ? 0.0 : (double) k->k.c[c][y * k->w + x];
}

/* Airy's pattern, 550 nm through 1 mm; more keys may follow. */
#define AIRY "aperture:share=1,blades=0,dust=0,scratches=0,"                  \
             "wavelength=550,pupil=1,reach=90"

#endif
