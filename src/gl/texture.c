#include "gl/gl_priv.h"

/* -- textures -------------------------------------------------------------- */

gp_status gp_texture_make(const struct gp_log *log, const struct gp_gl *gl,
    const char *what, enum gp_texel kind, int w, int h, struct gp_texture *out)
{
    const int limit = gl->info.max_size;
    if (w < 1 || h < 1 || w > limit || h > limit)
        return gp_fail_bare(log, GP_ERR_GL,
                            "%s: %s: %dx%d texels do not fit into a texture "
                            "(1x1 to %dx%d do); use --engine fft or direct",
                            gl->info.name, what, w, h, limit, limit);
    const GLint filter = kind == GP_TEXEL_LINEAR ? GL_LINEAR : GL_NEAREST;
    struct gp_texture t = {.w = w, .h = h};
    gl->f.CreateTextures(GL_TEXTURE_2D, 1, &t.id);
    gl->f.TextureStorage2D(t.id, 1,
                           kind == GP_TEXEL_BYTE ? GL_RGBA8 : GL_RGBA32F, w, h);
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

/* -- targets --------------------------------------------------------------- */

gp_status gp_target_make(const struct gp_log *log, const struct gp_gl *gl,
                         const char *what, enum gp_texel kind, int n, int w,
                         int h, struct gp_target *out)
{
    static const GLenum buffers[GP_ATTACHMENTS] = {
        GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2,
        GL_COLOR_ATTACHMENT3, GL_COLOR_ATTACHMENT4, GL_COLOR_ATTACHMENT5,
        GL_COLOR_ATTACHMENT6, GL_COLOR_ATTACHMENT7,
    };
    struct gp_target t = {0};
    gp_status st;
    gl->f.CreateFramebuffers(1, &t.framebuffer);
    for (; t.n < n; t.n++) {
        struct gp_texture *to = t.n ? &t.more[t.n - 1] : &t.colour;
        GP_TRY(gp_texture_make(log, gl, what, kind, w, h, to));
        gl->f.NamedFramebufferTexture(t.framebuffer, buffers[t.n], to->id, 0);
    }
    gl->f.NamedFramebufferDrawBuffers(t.framebuffer, n, buffers);
    GLenum state = gl->f.CheckNamedFramebufferStatus(t.framebuffer,
                                                     GL_DRAW_FRAMEBUFFER);
    if (state != GL_FRAMEBUFFER_COMPLETE) {
        st = gp_fail_bare(log, GP_ERR_GL,
                          "%s: %s: the driver cannot draw to this kind of "
                          "texture (framebuffer status 0x%04x); use --engine "
                          "fft or direct", gl->info.name, what, state);
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
    for (int i = 0; i < t->n; i++)
        gl->f.ClearNamedFramebufferfv(t->framebuffer, GL_COLOR, i, zero);
    gl->f.Disable(GL_SCISSOR_TEST);
}

void gp_target_read(const struct gp_gl *gl, const struct gp_target *t,
                    int attachment, struct gp_rect rect, float *rgba)
{
    gl->f.BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
    gl->f.NamedFramebufferReadBuffer(t->framebuffer,
        GL_COLOR_ATTACHMENT0 + (GLenum) attachment);
    gl->f.ReadPixels(rect.x0, rect.y0, gp_rect_w(rect), gp_rect_h(rect),
                     GL_RGBA, GL_FLOAT, rgba);
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

/* -- buffers that shaders read by index ------------------------------------ */

enum { ENTRY_BYTES = 4 * sizeof(float) };

gp_status gp_buffer_make(const struct gp_log *log, const struct gp_gl *gl,
                         const char *what, enum gp_buffer_kind kind, int n,
                         struct gp_buffer *out)
{
    const bool block = kind == GP_BUFFER_BLOCK;
    const int limit = block ? gl->info.max_block / ENTRY_BYTES
                            : gl->info.max_texel_buffer;
    if (n < 1 || n > limit)
        return gp_fail_bare(log, GP_ERR_GL,
                            "%s: %s: %d entries do not fit into a %s (1 to %d "
                            "do); use --engine fft or direct", gl->info.name,
                            what, n, block ? "uniform block" : "buffer texture",
                            limit);
    struct gp_buffer b = {0};
    gl->f.CreateBuffers(1, &b.id);
    gl->f.NamedBufferStorage(b.id, (GLsizeiptr) n * ENTRY_BYTES, NULL,
                             GL_DYNAMIC_STORAGE_BIT);
    if (!block) {
        gl->f.CreateTextures(GL_TEXTURE_BUFFER, 1, &b.texture);
        gl->f.TextureBuffer(b.texture, GL_RGBA32F, b.id);
    }
    gp_status st = gp_gl_check(log, gl, what);
    if (st)
        gp_buffer_free(gl, &b);
    else
        *out = b;
    return st;
}

void gp_buffer_write(const struct gp_gl *gl, const struct gp_buffer *b,
                     int first, int n, const float *entry)
{
    gl->f.NamedBufferSubData(b->id, (GLintptr) first * ENTRY_BYTES,
                             (GLsizeiptr) n * ENTRY_BYTES, entry);
}

void gp_buffer_free(const struct gp_gl *gl, struct gp_buffer *b)
{
    if (b->id && gp_gl_reach(gl)) {
        gl->f.DeleteTextures(1, &b->texture); // GL ignores name 0
        gl->f.DeleteBuffers(1, &b->id);
    }
    *b = (struct gp_buffer) {0};
}
