#include "gl/list.h"

#include "gl/context.h"

#include <stddef.h>

enum { TEXEL = 4 * sizeof(float) };

gp_status gp_list_make(const struct gp_log *log, const struct gp_gl *gl,
                       const char *what, int n, struct gp_list *out)
{
    if (n < 1 || n > gp_gl_list_max(gl))
        return gp_fail_bare(log, GP_ERR_GL,
                            "%s: %s: %d texels do not go into one buffer "
                            "texture (1 to %d is the limit); use --engine fft "
                            "or direct", gp_gl_name(gl), what, n,
                            gp_gl_list_max(gl));
    struct gp_list l = {.n = n};
    gl->f.CreateBuffers(1, &l.buffer);
    gl->f.NamedBufferStorage(l.buffer, (GLsizeiptr) n * TEXEL, NULL,
                             GL_DYNAMIC_STORAGE_BIT);
    gl->f.CreateTextures(GL_TEXTURE_BUFFER, 1, &l.id);
    gl->f.TextureBuffer(l.id, GL_RGBA32F, l.buffer);
    gp_status st = gp_gl_check(log, gl, what);
    if (st)
        gp_list_free(gl, &l);
    else
        *out = l;
    return st;
}

void gp_list_write(const struct gp_gl *gl, const struct gp_list *l, int first,
                   int n, const float *rgba)
{
    gl->f.NamedBufferSubData(l->buffer, (GLintptr) first * TEXEL,
                             (GLsizeiptr) n * TEXEL, rgba);
}

void gp_list_free(const struct gp_gl *gl, struct gp_list *l)
{
    if (l->id && gp_gl_reach(gl))
        gl->f.DeleteTextures(1, &l->id);
    if (l->buffer && gp_gl_reach(gl))
        gl->f.DeleteBuffers(1, &l->buffer);
    *l = (struct gp_list) {0};
}
