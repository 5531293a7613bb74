/* Fields and recipes for tests of models. */
#ifndef GP_TESTS_MODEL_SCENE_H
#define GP_TESTS_MODEL_SCENE_H

#include "core/colour.h"
#include "glare/model/model.h"

#include <stdio.h>
#include <stdlib.h>

/* Frames in Rec.709 with pixels so many degrees high. */
static inline struct gp_field scene_field(int w, int h, double degrees,
                                          double aspect)
{
    return (struct gp_field) {
        .w = w, .h = h, .degrees = degrees, .aspect = aspect, .fps = 24.0,
        .chromaticities = gp_rec709_chromaticities,
        .luminance = gp_rec709_luminance,
    };
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

#endif
