#include "gl/texture.h"

#include "gl/context.h"

static gp_status make(const struct gp_log *log, const struct gp_gl *gl,
                      const char *what, int w, int h, GLenum format,
                      GLint filter, struct gp_texture *out)
{
    int limit = gp_gl_max_size(gl);
    if (w < 1 || h < 1 || w > limit || h > limit)
        return gp_fail_bare(log, GP_ERR_GL,
                            "%s: %s: %dx%d texels do not go into one texture "
                            "(1x1 to %dx%d is the limit); use --engine fft or "
                            "direct", gp_gl_name(gl), what, w, h, limit,
                            limit);
    struct gp_texture t = {.w = w, .h = h};
    gl->f.CreateTextures(GL_TEXTURE_2D, 1, &t.id);
    gl->f.TextureStorage2D(t.id, 1, format, w, h);
    gl->f.TextureParameteri(t.id, GL_TEXTURE_MIN_FILTER, filter);
    gl->f.TextureParameteri(t.id, GL_TEXTURE_MAG_FILTER, filter);
    gl->f.TextureParameteri(t.id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->f.TextureParameteri(t.id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gp_status st = gp_gl_check(log, gl, what);
    if (st)
        gp_texture_free(gl, &t);
    else
        *out = t;
    return st;
}

gp_status gp_texture_make(const struct gp_log *log, const struct gp_gl *gl,
                          const char *what, int w, int h,
                          struct gp_texture *out)
{
    return make(log, gl, what, w, h, GL_RGBA32F, GL_NEAREST, out);
}

gp_status gp_texture_make_linear(const struct gp_log *log,
                                 const struct gp_gl *gl, const char *what,
                                 int w, int h, struct gp_texture *out)
{
    return make(log, gl, what, w, h, GL_RGBA32F, GL_LINEAR, out);
}

gp_status gp_texture_make_byte(const struct gp_log *log,
                               const struct gp_gl *gl, const char *what, int w,
                               int h, struct gp_texture *out)
{
    return make(log, gl, what, w, h, GL_RGBA8, GL_NEAREST, out);
}

void gp_texture_write(const struct gp_gl *gl, const struct gp_texture *t,
                      struct gp_rect rect, const float *rgba)
{
    gl->f.TextureSubImage2D(t->id, 0, rect.x0, rect.y0, gp_rect_w(rect),
                            gp_rect_h(rect), GL_RGBA, GL_FLOAT, rgba);
}

void gp_texture_free(const struct gp_gl *gl, struct gp_texture *t)
{
    if (t->id && gp_gl_reach(gl))
        gl->f.DeleteTextures(1, &t->id);
    *t = (struct gp_texture) {0};
}
