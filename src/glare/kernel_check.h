// SPDX-License-Identifier: Apache-2.0
/* Figures and faults of a kernel: glarepp kernel --check prints them, and a run
 * warns of faults that its frames show. */
#ifndef GP_GLARE_KERNEL_CHECK_H
#define GP_GLARE_KERNEL_CHECK_H

#include "glare/kernel.h"

#include <stdbool.h>

/* Position and symmetry of a kernel's light, or of a channel; offsets in pixels
 * from the centre's pixel. */
struct gp_kernel_place {
    double peak;         // largest sample, of equals the centre's
    int peak_at[2];
    double mirrored;     // sample opposite to it
    double centroid[2];
    double asymmetry;    // share of what leaves the pixel that has no
                         // counterpart opposite to it
    double moved;        // the same about the pixel of the centroid
};

/* Luminance by the weights given. */
struct gp_kernel_figures {
    int w, h;            // samples, without zero borders
    double sum[3];       // of each channel
    double light;        // their luminance
    double own;          // share of it that stays in its pixel
    double left_out;     // of a model, as in struct gp_kernel
    // by gp_kernel_measure() only
    double rim;          // the largest edge: find_cut() and find_drop() of
                         // kernel_check.c; 0 for kernels of models
    struct gp_kernel_place place;
    struct gp_kernel_place channel[3]; // where `coloured`
    bool coloured;       // its channels are not equal
    double border;       // share of magnitudes in the outermost rows, columns
    double outermost;    // share of samples there: what even light would have
    long long negatives; // samples with a channel under 0
    long long nonfinite; // NaN or infinite, counted by the caller: there is no
                         // such kernel, and all else is 0
    bool measured;
};

/* Frames and settings that a kernel is for. */
struct gp_kernel_use {
    bool add;            // --mix add
    bool ends;           // it ends where light still goes on, inside the frames
    bool as_it_is;       // not normalised
    bool centred;        // its centre was given: light to one side is meant
    bool resampled;      // not its file's samples
    double missed;       // a model's light that falls in the frames, but outside
                         // of what was computed
    double share;        // of a pixel's light, that a model takes and spreads
    double brightest;    // luminance of the brightest source; 0: not known
};

/* Figures that cost nothing, of the core and its far field together. */
void gp_kernel_glance(const struct gp_kernel *k, const float luminance[3],
                      struct gp_kernel_figures *out);
/* All figures, of a kernel without far field, by several threads: the same for
 * any number of them. */
void gp_kernel_measure(const struct gp_kernel *k, const float luminance[3],
                       struct gp_kernel_figures *out);

/* Rules that a kernel can break. Those of SIZE to SYMMETRY need all figures. */
enum gp_kernel_rule {
    GP_RULE_NONFINITE,
    GP_RULE_SIZE,
    GP_RULE_SUM,
    GP_RULE_PEAK,
    GP_RULE_CENTROID,
    GP_RULE_BORDER,
    GP_RULE_NEGATIVE,
    GP_RULE_SYMMETRY,
    GP_RULE_OWN,
    GP_RULE_RIM,
    GP_RULE_LEFT_OUT,
    GP_RULE_BEYOND,
    GP_KERNEL_RULES,
};

/* A fault as one line, with a parameter as in struct gp_line. */
struct gp_fault {
    char line[256];
    const char *parameter;
};

/* Writes the fault against a rule. False, with an empty line, where the kernel
 * keeps the rule, or was not measured for it. */
bool gp_kernel_fault(const struct gp_kernel_figures *f,
                     const struct gp_kernel_use *use, enum gp_kernel_rule rule,
                     struct gp_fault *out);

#endif
