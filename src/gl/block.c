#include "gl/block.h"

#include "gl/context.h"

gp_status gp_block_make(const struct gp_log *log, const struct gp_gl *gl,
                        const char *what, size_t bytes, struct gp_block *out)
{
    if (bytes < 1 || bytes > (size_t) gp_gl_block_max(gl))
        return gp_fail_bare(log, GP_ERR_GL,
                            "%s: %s: %zu bytes do not go into one uniform "
                            "block (1 to %d is the limit); use --engine fft "
                            "or direct", gp_gl_name(gl), what, bytes,
                            gp_gl_block_max(gl));
    struct gp_block b = {.bytes = bytes};
    gl->f.CreateBuffers(1, &b.id);
    gl->f.NamedBufferStorage(b.id, (GLsizeiptr) bytes, NULL,
                             GL_DYNAMIC_STORAGE_BIT);
    gp_status st = gp_gl_check(log, gl, what);
    if (st)
        gp_block_free(gl, &b);
    else
        *out = b;
    return st;
}

void gp_block_write(const struct gp_gl *gl, const struct gp_block *b,
                    const void *data, size_t bytes)
{
    gl->f.NamedBufferSubData(b->id, 0, (GLsizeiptr) bytes, data);
}

void gp_block_free(const struct gp_gl *gl, struct gp_block *b)
{
    if (b->id && gp_gl_reach(gl))
        gl->f.DeleteBuffers(1, &b->id);
    *b = (struct gp_block) {0};
}
