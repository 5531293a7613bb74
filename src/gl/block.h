/* Uniform blocks: lists that a shader reads by index, faster than a texture. */
#ifndef GP_GL_BLOCK_H
#define GP_GL_BLOCK_H

#include "gl/gl.h"

#include <stddef.h>

struct gp_block {
    unsigned id; // 0: empty
    size_t bytes;
};

/* Makes a block of `bytes`, not cleared. Shaders declare it std140; arrays of vec4
 * lie there as in C. `what` is for the message.
 *   out  written only on GP_OK; free with gp_block_free()
 * Errors: GP_ERR_GL 0 bytes or over gp_gl_block_max(), out of memory.
 */
GP_MUST_CHECK gp_status gp_block_make(const struct gp_log *log,
                                      const struct gp_gl *gl, const char *what,
                                      size_t bytes, struct gp_block *out);

/* Writes the first `bytes`, no more than the block has; draws that were asked
 * for before see what was there then. */
void gp_block_write(const struct gp_gl *gl, const struct gp_block *b,
                    const void *data, size_t bytes);
void gp_block_free(const struct gp_gl *gl, struct gp_block *b);

#endif
