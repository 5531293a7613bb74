#include "gl/texture.h"

#include "gl/context.h"

gp_status gp_texture_make(const struct gp_log *log, const struct gp_gl *gl,
                          const char *what, int w, int h,
                          struct gp_texture *out)
{
    int limit = gp_gl_max_size(gl);
    if (w < 1 || h < 1 || w > limit || h > limit)
        return gp_fail(log, GP_ERR_GL,
                       "%s: %s: %dx%d texels do not go into one texture (1x1 "
                       "to %dx%d is the limit); use --engine fft or direct",
                       gp_gl_name(gl), what, w, h, limit, limit);
    struct gp_texture t = {.w = w, .h = h};
    gl->f.CreateTextures(GL_TEXTURE_2D, 1, &t.id);
    gl->f.TextureStorage2D(t.id, 1, GL_RGBA32F, w, h);
    gl->f.TextureParameteri(t.id, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->f.TextureParameteri(t.id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gp_status st = gp_gl_check(log, gl, what);
    if (st)
        gp_texture_free(gl, &t);
    else
        *out = t;
    return st;
}

void gp_texture_write(const struct gp_gl *gl, const struct gp_texture *t,
                      struct gp_rect rect, const float *rgba)
{
    gl->f.TextureSubImage2D(t->id, 0, rect.x0, rect.y0, gp_rect_w(rect),
                            gp_rect_h(rect), GL_RGBA, GL_FLOAT, rgba);
}

void gp_texture_free(const struct gp_gl *gl, struct gp_texture *t)
{
    if (t->id)
        gl->f.DeleteTextures(1, &t->id);
    *t = (struct gp_texture) {0};
}

/* -- targets --------------------------------------------------------------- */

gp_status gp_target_make(const struct gp_log *log, const struct gp_gl *gl,
                         const char *what, int w, int h, struct gp_target *out)
{
    struct gp_target t = {0};
    gp_status st;
    GP_TRY(gp_texture_make(log, gl, what, w, h, &t.colour));
    gl->f.CreateFramebuffers(1, &t.framebuffer);
    gl->f.NamedFramebufferTexture(t.framebuffer, GL_COLOR_ATTACHMENT0,
                                  t.colour.id, 0);
    GLenum state = gl->f.CheckNamedFramebufferStatus(t.framebuffer,
                                                     GL_DRAW_FRAMEBUFFER);
    if (state != GL_FRAMEBUFFER_COMPLETE) {
        st = gp_fail(log, GP_ERR_GL,
                     "%s: %s: the driver does not draw to RGBA32F "
                     "(framebuffer status 0x%04x); use --engine fft or direct",
                     gp_gl_name(gl), what, state);
        goto out;
    }
    GP_TRY(gp_gl_check(log, gl, what));
    *out = t;
    return GP_OK;
out:
    gp_target_free(gl, &t);
    return st;
}

void gp_target_clear(const struct gp_gl *gl, const struct gp_target *t,
                     struct gp_rect rect)
{
    static const float zero[4] = {0};
    rect = gp_rect_meet(rect, (struct gp_rect) {0, 0, t->colour.w,
                                                t->colour.h});
    if (gp_rect_empty(rect))
        return;
    gl->f.Enable(GL_SCISSOR_TEST);
    gl->f.Scissor(rect.x0, rect.y0, gp_rect_w(rect), gp_rect_h(rect));
    gl->f.ClearNamedFramebufferfv(t->framebuffer, GL_COLOR, 0, zero);
    gl->f.Disable(GL_SCISSOR_TEST);
}

void gp_target_read(const struct gp_gl *gl, const struct gp_target *t,
                    struct gp_rect rect, float *rgba)
{
    gl->f.BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
    gl->f.ReadPixels(rect.x0, rect.y0, gp_rect_w(rect), gp_rect_h(rect),
                     GL_RGBA, GL_FLOAT, rgba);
}

void gp_target_free(const struct gp_gl *gl, struct gp_target *t)
{
    if (t->framebuffer)
        gl->f.DeleteFramebuffers(1, &t->framebuffer);
    gp_texture_free(gl, &t->colour);
    *t = (struct gp_target) {0};
}
