// SPDX-License-Identifier: Apache-2.0
/* The kernel of a request, made for the fields of frames; the last one is kept,
 * and others live as long as the frames in flight that hold them. */
#ifndef GP_GLARE_KERNEL_KEPT_H
#define GP_GLARE_KERNEL_KEPT_H

#include "glare/kernel.h"
#include "glare/kernel_check.h"
#include "glare/model/model.h"
#include "glarepp.h"

#include <stdatomic.h>
#include <stdbool.h>

/* Recipes, or one image. */
struct gp_kernel_request {
    struct gp_recipe recipe[GP_RECIPES];
    struct gp_image image[GP_RECIPES]; // of the recipe's file, or of the kernel
    struct glarepp_label label[GP_RECIPES]; // of image[i] as a kernel
    int recipes;                       // 0: image[0] is the kernel
    struct gp_kernel_params params;    // of image[0]; its aspect, scale and
                                       // chromaticities are each field's
    double percent;                    // frame pixels for 100 of image[0]
    double degrees;                    // height of image[0] in the field; 0: by
                                       // percent
};

/* Frees its recipes and images, and clears it. */
void gp_kernel_request_free(struct gp_kernel_request *r);

/* Returns the share of a pixel's light that the kernel takes and spreads. */
double gp_kernel_request_share(const struct gp_kernel_request *r);

/* Returns frame pixels for one of image[0], in the field's height. */
double gp_kernel_request_scale(const struct gp_kernel_request *r,
                               const struct gp_field *field);

/* A kernel, and the frames that it was made for. */
struct gp_made_kernel {
    struct gp_kernel k;
    struct gp_recipe recipe[GP_RECIPES]; // values of its own; files and images
                                         // are the request's
    char *text[GP_RECIPES];              // of each recipe; owned
    struct gp_kernel_figures figures;
    struct gp_field field;
    atomic_int holders;
};

/* Ends a hold. */
void gp_made_kernel_free(struct gp_made_kernel **k);

/* The kernel that is kept; any thread may ask. */
struct gp_kernels;
GP_MUST_CHECK gp_status gp_kernels_make(const struct gp_log *log,
    const struct gp_kernel_request *r, struct gp_kernels **out);
void gp_kernels_free(struct gp_kernels **k);

/* Takes hold of the kernel of a field, which is made unless it is kept.
 *   recipe  those of the request, maybe with other values; NULL: as they are
 *   made    true where it was
 *   out     end with gp_made_kernel_free(); NULL on failure
 * Errors: those of gp_model_kernel() and gp_kernel_from_frame(). */
GP_MUST_CHECK gp_status gp_kernels_take(const struct gp_log *log,
    struct gp_kernels *k, const struct gp_recipe *recipe,
    const struct gp_field *field, bool *made, struct gp_made_kernel **out);

/* Finds how a frame of w x h pixels uses a kernel of a label, where a pixel of
 * the file is `scale` of the frame's: its members missed (less what falls outside
 * of the frame that it was made for, if these are no larger), ends, as_it_is. */
void gp_kernel_label_use(const struct glarepp_label *l, double scale,
                         const struct gp_kernel *k, int w, int h,
                         struct gp_kernel_use *use);

#endif
