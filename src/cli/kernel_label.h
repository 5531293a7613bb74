/* The attributes of a kernel's file: what glarepp kernel made it of, for
 * runs that use the file. glare/model/README.md documents their names. */
#ifndef GP_CLI_KERNEL_LABEL_H
#define GP_CLI_KERNEL_LABEL_H

#include "core/status.h"
#include "glarepp.h"
#include "io/write.h"

#include <stdbool.h>

/* All but the recipes. */
struct gp_file_label {
    bool present;        // read from a file of glarepp kernel, or to be written
    int w, h;            // pixels of the frame it is for
    int radius;          // most of an offset; 0: all that the frame meets
    double fov;          // degrees, of the frame's height
    double rotate;       // degrees
    int frame;           // number, for models that move
    enum gp_compression compression; // of the file; written only
    double left_out;     // the model's light outside of the file
    double beyond;       // of which falls outside of the frame too
    double share;        // of a pixel's light, that the recipes read take
};

/* Texts for gp_write_params.added; names and texts are owned. */
enum { GP_LABEL_RECIPES = 8, GP_LABEL_TEXTS = GP_LABEL_RECIPES + 8 };
struct gp_label_texts {
    struct gp_attribute at[GP_LABEL_TEXTS];
    int n;
};

/* Writes the attributes of n recipes. *out is zero before; free it in any case
 * with gp_label_texts_free(). Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_label_write(const struct gp_log *log,
    const struct gp_file_label *l, const char *const *recipe, int n,
    struct gp_label_texts *out);
void gp_label_texts_free(struct gp_label_texts *t);

/* Reads the attributes but the recipes. All 0 where they are not whole, or out
 * of their options' ranges.
 * Errors: GP_ERR_DATA a recipe that this program does not know, with the file's
 * and the attribute's name; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_label_read(const struct gp_log *log,
    const struct gp_frame *f, struct gp_file_label *out);

/* Returns it as the library takes it. */
struct glarepp_label gp_label_of(const struct gp_file_label *l);

#endif
