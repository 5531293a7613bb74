/* Long lists that a shader reads by index: texels in one row, of a size that
 * neither textures nor uniform blocks have. */
#ifndef GP_GL_LIST_H
#define GP_GL_LIST_H

#include "gl/gl.h"

/* RGBA32F texels in a buffer texture, read by imageLoad. */
struct gp_list {
    unsigned id, buffer; // 0: empty
    int n;
};

/* Makes a list of n texels, not cleared; `what` is for the message.
 *   out  written only on GP_OK; free with gp_list_free()
 * Errors: GP_ERR_GL n under 1 or over gp_gl_list_max(), out of memory.
 */
GP_MUST_CHECK gp_status gp_list_make(const struct gp_log *log,
                                     const struct gp_gl *gl, const char *what,
                                     int n, struct gp_list *out);

/* Writes texels [first, first + n), which the list has, from 4 * n floats;
 * draws that were asked for before see what was there then. */
void gp_list_write(const struct gp_gl *gl, const struct gp_list *l, int first,
                   int n, const float *rgba);
void gp_list_free(const struct gp_gl *gl, struct gp_list *l);

#endif
