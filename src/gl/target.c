#include "gl/texture.h"

#include "gl/context.h"

/* Makes the texture of an attachment. */
typedef gp_status (*maker)(const struct gp_log *log, const struct gp_gl *gl,
                           const char *what, int w, int h,
                           struct gp_texture *out);

static gp_status attach(const struct gp_log *log, const struct gp_gl *gl,
                        const char *what, int w, int h, int n, maker texture,
                        struct gp_target *t)
{
    static const GLenum buffers[GP_ATTACHMENTS] = {
        GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2,
        GL_COLOR_ATTACHMENT3, GL_COLOR_ATTACHMENT4, GL_COLOR_ATTACHMENT5,
        GL_COLOR_ATTACHMENT6, GL_COLOR_ATTACHMENT7,
    };
    gl->f.CreateFramebuffers(1, &t->framebuffer);
    for (; t->n < n; t->n++) {
        struct gp_texture *to = t->n ? &t->more[t->n - 1] : &t->colour;
        gp_status st = texture(log, gl, what, w, h, to);
        if (st)
            return st;
        gl->f.NamedFramebufferTexture(t->framebuffer, buffers[t->n], to->id,
                                      0);
    }
    gl->f.NamedFramebufferDrawBuffers(t->framebuffer, n, buffers);
    return GP_OK;
}

static gp_status make(const struct gp_log *log, const struct gp_gl *gl,
                      const char *what, int w, int h, int n, maker texture,
                      struct gp_target *out)
{
    struct gp_target t = {0};
    gp_status st;
    GP_TRY(attach(log, gl, what, w, h, n, texture, &t));
    GLenum state = gl->f.CheckNamedFramebufferStatus(t.framebuffer,
                                                     GL_DRAW_FRAMEBUFFER);
    if (state != GL_FRAMEBUFFER_COMPLETE) {
        st = gp_fail_bare(log, GP_ERR_GL,
                          "%s: %s: the driver does not draw to such a texture "
                          "(framebuffer status 0x%04x); use --engine fft or "
                          "direct", gp_gl_name(gl), what, state);
        goto out;
    }
    GP_TRY(gp_gl_check(log, gl, what));
    *out = t;
    return GP_OK;
out:
    gp_target_free(gl, &t);
    return st;
}

gp_status gp_target_make_many(const struct gp_log *log,
                              const struct gp_gl *gl, const char *what, int w,
                              int h, int n, struct gp_target *out)
{
    return make(log, gl, what, w, h, n, gp_texture_make, out);
}

gp_status gp_target_make(const struct gp_log *log, const struct gp_gl *gl,
                         const char *what, int w, int h, struct gp_target *out)
{
    return make(log, gl, what, w, h, 1, gp_texture_make, out);
}

gp_status gp_target_make_linear(const struct gp_log *log,
                                const struct gp_gl *gl, const char *what,
                                int w, int h, struct gp_target *out)
{
    return make(log, gl, what, w, h, 1, gp_texture_make_linear, out);
}

gp_status gp_target_make_byte(const struct gp_log *log, const struct gp_gl *gl,
                              const char *what, int w, int h,
                              struct gp_target *out)
{
    return make(log, gl, what, w, h, 1, gp_texture_make_byte, out);
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
    for (int i = 0; i < t->n; i++)
        gl->f.ClearNamedFramebufferfv(t->framebuffer, GL_COLOR, i, zero);
    gl->f.Disable(GL_SCISSOR_TEST);
}

void gp_target_read_from(const struct gp_gl *gl, const struct gp_target *t,
                         int attachment, struct gp_rect rect, float *rgba)
{
    gl->f.BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
    gl->f.NamedFramebufferReadBuffer(t->framebuffer,
                                     GL_COLOR_ATTACHMENT0 +
                                         (GLenum) attachment);
    gl->f.ReadPixels(rect.x0, rect.y0, gp_rect_w(rect), gp_rect_h(rect),
                     GL_RGBA, GL_FLOAT, rgba);
}

void gp_target_read(const struct gp_gl *gl, const struct gp_target *t,
                    struct gp_rect rect, float *rgba)
{
    gp_target_read_from(gl, t, 0, rect, rgba);
}

void gp_target_free(const struct gp_gl *gl, struct gp_target *t)
{
    if (t->framebuffer && gp_gl_reach(gl))
        gl->f.DeleteFramebuffers(1, &t->framebuffer);
    gp_texture_free(gl, &t->colour);
    for (int i = 0; i < GP_ATTACHMENTS - 1; i++)
        gp_texture_free(gl, &t->more[i]);
    *t = (struct gp_target) {0};
}
