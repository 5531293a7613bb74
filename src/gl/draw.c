// SPDX-License-Identifier: Apache-2.0
#include "gl/gl_priv.h"

#include <string.h>

/* -- textures -------------------------------------------------------------- */

gp_status gp_texture_make(const struct gp_log *log, const struct gp_gl *gl,
    const char *what, enum gp_texel kind, int w, int h, struct gp_texture *out)
{
    static const GLenum format[] = {
        [GP_TEXEL_FLOAT] = GL_RGBA32F, [GP_TEXEL_BYTE] = GL_RGBA8,
        [GP_TEXEL_CODE] = GL_R16UI, [GP_TEXEL_DEPTH] = GL_DEPTH_COMPONENT32F,
    };
    const int limit = gl->info.max_size;
    if (out->id && out->w >= w && out->h >= h)
        return GP_OK;
    if (!(w >= 1 && h >= 1 && w <= limit && h <= limit))
        return gp_fail_bare_at(log, GP_ERR_GL, "layer.engine",
                               "%s: %s: %dx%d texels do not fit into a texture "
                               "(1x1 to %dx%d do)",
                               gl->info.name, what, w, h, limit, limit);
    gp_texture_free(gl, out);
    *out = (struct gp_texture) {.w = w, .h = h};
    gl->f.CreateTextures(GL_TEXTURE_2D, 1, &out->id);
    gl->f.TextureStorage2D(out->id, 1, format[kind], w, h);
    // shaders fetch texels, but whole numbers are complete without filters only
    gl->f.TextureParameteri(out->id, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->f.TextureParameteri(out->id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    const gp_status st = gp_gl_check(log, gl, what);
    if (st)
        gp_texture_free(gl, out);
    return st;
}

void gp_texture_write(const struct gp_gl *gl, const struct gp_texture *t,
                      struct gp_rect rect, const float *rgba)
{
    gl->f.TextureSubImage2D(t->id, 0, rect.x0, rect.y0, gp_rect_w(rect),
                            gp_rect_h(rect), GL_RGBA, GL_FLOAT, rgba);
}

void gp_texture_write_codes(const struct gp_gl *gl, const struct gp_texture *t,
                            const uint16_t *code)
{
    gl->f.TextureSubImage2D(t->id, 0, 0, 0, t->w, t->h, GL_RED_INTEGER,
                            GL_UNSIGNED_SHORT, code);
}

void gp_texture_free(const struct gp_gl *gl, struct gp_texture *t)
{
    if (t->id && gp_gl_use(NULL, gl) == GP_OK)
        gl->f.DeleteTextures(1, &t->id);
    *t = (struct gp_texture) {0};
}

/* -- targets --------------------------------------------------------------- */

gp_status gp_target_make(const struct gp_log *log, const struct gp_gl *gl,
                         const char *what, enum gp_texel kind, int n, int w,
                         int h, struct gp_target *out)
{
    const bool deep = kind == GP_TEXEL_DEPTH;
    GLenum buffers[GP_ATTACHMENTS], state;
    struct gp_target t = {.w = w, .h = h};
    gp_status st;
    if (out->framebuffer && out->w >= w && out->h >= h)
        return GP_OK;
    gp_target_free(gl, out);
    gl->f.CreateFramebuffers(1, &t.framebuffer);
    for (; t.n < n; t.n++) {
        struct gp_texture *to = t.n ? &t.more[t.n - 1] : &t.colour;
        GP_TRY(gp_texture_make(log, gl, what, deep ? GP_TEXEL_FLOAT : kind, w,
                               h, to));
        buffers[t.n] = GL_COLOR_ATTACHMENT0 + (GLenum) t.n;
        gl->f.NamedFramebufferTexture(t.framebuffer, buffers[t.n], to->id, 0);
    }
    gl->f.NamedFramebufferDrawBuffers(t.framebuffer, n, buffers);
    if (deep) {
        GP_TRY(gp_texture_make(log, gl, what, kind, w, h, &t.depth));
        gl->f.NamedFramebufferTexture(t.framebuffer, GL_DEPTH_ATTACHMENT,
                                      t.depth.id, 0);
    }
    state =
        gl->f.CheckNamedFramebufferStatus(t.framebuffer, GL_DRAW_FRAMEBUFFER);
    if (state != GL_FRAMEBUFFER_COMPLETE)
        GP_TRY(gp_fail_bare_at(log, GP_ERR_GL, "layer.engine",
                               "%s: %s: the driver cannot draw to this kind of "
                               "texture (framebuffer status 0x%04x)",
                               gl->info.name, what, state));
    GP_TRY(gp_gl_check(log, gl, what));
    *out = t;
    t = (struct gp_target) {0};
out:
    gp_target_free(gl, &t);
    return st;
}

void gp_target_clear(const struct gp_gl *gl, const struct gp_target *t,
                     struct gp_rect rect)
{
    static const float zero[4] = {0};
    rect = gp_rect_meet(rect, (struct gp_rect) {0, 0, t->w, t->h});
    if (gp_rect_empty(rect))
        return;
    gl->f.Enable(GL_SCISSOR_TEST);
    gl->f.Scissor(rect.x0, rect.y0, gp_rect_w(rect), gp_rect_h(rect));
    for (int i = 0; i < t->n; i++)
        gl->f.ClearNamedFramebufferfv(t->framebuffer, GL_COLOR, i, zero);
    if (t->depth.id)
        gl->f.ClearNamedFramebufferfv(t->framebuffer, GL_DEPTH, 0, zero);
    gl->f.Disable(GL_SCISSOR_TEST);
}

void gp_target_read(const struct gp_gl *gl, const struct gp_target *t,
                    int attachment, struct gp_rect rect, float *out)
{
    const bool depth = attachment == GP_DEPTH_ATTACHMENT;
    gl->f.BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
    if (!depth)
        gl->f.NamedFramebufferReadBuffer(
            t->framebuffer, GL_COLOR_ATTACHMENT0 + (GLenum) attachment);
    gl->f.ReadPixels(rect.x0, rect.y0, gp_rect_w(rect), gp_rect_h(rect),
                     depth ? GL_DEPTH_COMPONENT : GL_RGBA, GL_FLOAT, out);
}

void gp_target_free(const struct gp_gl *gl, struct gp_target *t)
{
    if (t->framebuffer && gp_gl_use(NULL, gl) == GP_OK)
        gl->f.DeleteFramebuffers(1, &t->framebuffer);
    gp_texture_free(gl, &t->colour);
    for (int i = 0; i < GP_ATTACHMENTS - 1; i++)
        gp_texture_free(gl, &t->more[i]);
    gp_texture_free(gl, &t->depth);
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
        return gp_fail_bare_at(log, GP_ERR_GL, "layer.engine",
                               "%s: %s: %d entries do not fit into a %s (1 to "
                               "%d do)", gl->info.name, what, n,
                               block ? "uniform block" : "buffer texture",
                               limit);
    *out = (struct gp_buffer) {0};
    gl->f.CreateBuffers(1, &out->id);
    gl->f.NamedBufferStorage(out->id, (GLsizeiptr) n * ENTRY_BYTES, NULL,
                             GL_DYNAMIC_STORAGE_BIT);
    if (!block) {
        gl->f.CreateTextures(GL_TEXTURE_BUFFER, 1, &out->texture.id);
        gl->f.TextureBuffer(out->texture.id, GL_RGBA32F, out->id);
    }
    const gp_status st = gp_gl_check(log, gl, what);
    if (st)
        gp_buffer_free(gl, out);
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
    if (b->id && gp_gl_use(NULL, gl) == GP_OK) {
        gl->f.DeleteTextures(1, &b->texture.id); // GL ignores name 0
        gl->f.DeleteBuffers(1, &b->id);
    }
    *b = (struct gp_buffer) {0};
}

enum { LOG_BYTES = 2048 };

/* -- programs -------------------------------------------------------------- */

static const struct gp_shader_file *find_file(const char *name)
{
    const struct gp_shader_file *f = gp_shader_files;
    while (f->name && strcmp(f->name, name) != 0)
        f++;
    return f->name ? f : NULL;
}

static gp_status compile(const struct gp_log *log, const struct gp_gl *gl,
                         const char *defines, GLenum kind,
                         const struct gp_shader_file *file, GLuint *out)
{
    const char *const texts[] = {"#version 450 core\n", defines,
                                 find_file("common.glsl")->text, "\n#line 1\n",
                                 file->text};
    GLuint shader = gl->f.CreateShader(kind);
    GLint compiled = 0;
    gl->f.ShaderSource(shader, 5, texts, NULL);
    gl->f.CompileShader(shader);
    gl->f.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (!compiled) {
        char text[LOG_BYTES] = "";
        gl->f.GetShaderInfoLog(shader, sizeof text, NULL, text);
        gl->f.DeleteShader(shader);
        return gp_fail_at(log, GP_ERR_GL, "layer.engine",
                          "%s: shader %s does not compile (%s); report this",
                          gl->info.name, file->name, text);
    }
    *out = shader;
    return GP_OK;
}

gp_status gp_program_from_text(const struct gp_log *log, const struct gp_gl *gl,
    const char *defines, const struct gp_shader_file *vert,
    const struct gp_shader_file *frag, struct gp_program *out)
{
    gp_status st;
    GLuint v = 0, f = 0;
    GLint linked = 0;
    struct gp_program p = {0};
    GP_TRY(compile(log, gl, defines, GL_VERTEX_SHADER, vert, &v));
    GP_TRY(compile(log, gl, defines, GL_FRAGMENT_SHADER, frag, &f));
    p.id = gl->f.CreateProgram();
    gl->f.AttachShader(p.id, v);
    gl->f.AttachShader(p.id, f);
    gl->f.LinkProgram(p.id);
    gl->f.GetProgramiv(p.id, GL_LINK_STATUS, &linked);
    if (!linked) {
        char text[LOG_BYTES] = "";
        gl->f.GetProgramInfoLog(p.id, sizeof text, NULL, text);
        GP_TRY(gp_fail_at(log, GP_ERR_GL, "layer.engine",
                          "%s: program %s does not link (%s); report this",
                          gl->info.name, vert->name, text));
    }
    GP_TRY(gp_gl_check(log, gl, vert->name));
    *out = p;
    p.id = 0;
out:
    gl->f.DeleteShader(v); // GL ignores name 0, and keeps what is attached
    gl->f.DeleteShader(f);
    gp_program_free(gl, &p);
    return st;
}

gp_status gp_program_make(const struct gp_log *log, const struct gp_gl *gl,
                          const char *defines, const char *vert,
                          const char *frag, struct gp_program *out)
{
    const struct gp_shader_file *v = find_file(vert), *f = find_file(frag);
    if (out->id)
        return GP_OK;
    if (!v || !f)
        return gp_fail(log, GP_ERR_BUG,
                       "%s: no such shader file in this build; report this",
                       v ? frag : vert);
    return gp_program_from_text(log, gl, defines, v, f, out);
}

void gp_program_free(const struct gp_gl *gl, struct gp_program *p)
{
    if (p->id && gp_gl_use(NULL, gl) == GP_OK)
        gl->f.DeleteProgram(p->id);
    p->id = 0;
}

/* -- drawing --------------------------------------------------------------- */

/* Units in use of one draw. */
struct units {
    GLuint texture, image, block;
};

/* Sets one uniform at its place: a block's index or a location. */
static void set_uniform(const struct gp_gl *gl, GLuint program, GLuint place,
                        const struct gp_uniform *u, struct units *n)
{
    const GLint at = (GLint) place;
    if (u->block) {
        gl->f.UniformBlockBinding(program, place, n->block);
        gl->f.BindBufferBase(GL_UNIFORM_BUFFER, n->block++, u->block->id);
    } else if (u->texture) {
        gl->f.BindTextureUnit(n->texture, u->texture->id);
        gl->f.Uniform1i(at, (GLint) n->texture++);
    } else if (u->image) {
        gl->f.BindImageTexture(n->image, u->image->id, 0, GL_FALSE, 0,
                               GL_READ_ONLY, GL_RGBA32F);
        gl->f.Uniform1i(at, (GLint) n->image++);
    } else if (u->matrix) {
        gl->f.UniformMatrix4fv(at, 1, GL_FALSE, u->matrix);
    } else if (u->floats) {
        (u->floats == 1   ? gl->f.Uniform1fv
         : u->floats == 2 ? gl->f.Uniform2fv
                          : gl->f.Uniform4fv)(at, 1, u->f);
    } else {
        gl->f.Uniform2iv(at, 1, u->v);
    }
}

/* Sets the state of depth, faces and clip distances, or sets it back. */
static void set_space(const struct gp_gl *gl, const struct gp_draw *draw,
                      bool on)
{
    const struct gp_gl_functions *const f = &gl->f;
    if (draw->depth) {
        (on ? f->Enable : f->Disable)(GL_DEPTH_TEST);
        f->DepthFunc(draw->depth == GP_DEPTH_SAME ? GL_EQUAL : GL_GEQUAL);
        f->DepthMask(!on || draw->depth == GP_DEPTH_WRITE);
        f->ClipControl(GL_LOWER_LEFT,
                       on ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
    }
    if (draw->cull) {
        (on ? f->Enable : f->Disable)(GL_CULL_FACE);
        f->CullFace(draw->cull == GP_CULL_FRONT ? GL_FRONT : GL_BACK);
    }
    for (int i = 0; i < draw->clips; i++)
        (on ? f->Enable : f->Disable)(GL_CLIP_DISTANCE0 + (GLenum) i);
}

gp_status gp_draw_run(const struct gp_log *log, const struct gp_gl *gl,
                      const struct gp_draw *draw)
{
    const struct gp_rect target = {0, 0, draw->target->w, draw->target->h};
    const struct gp_rect cut = gp_rect_meet(draw->cut, target);
    const struct gp_rect view = gp_rect_empty(draw->view) ? target
                                                          : draw->view;
    const GLuint program = draw->program->id;
    struct units units = {0};
    if (gp_rect_empty(cut))
        return GP_OK;
    gl->f.UseProgram(program);
    for (const struct gp_uniform *u = draw->uniform; u->name; u++) {
        // a block's index, and what is no place of either: all bits set
        const GLuint place =
            u->block ? gl->f.GetUniformBlockIndex(program, u->name)
                     : (GLuint) gl->f.GetUniformLocation(program, u->name);
        if (place == GL_INVALID_INDEX)
            return gp_fail(log, GP_ERR_BUG, "uniform %s: the program has none "
                           "of this name; report this", u->name);
        set_uniform(gl, program, place, u, &units);
    }
    gl->f.BindFramebuffer(GL_FRAMEBUFFER, draw->target->framebuffer);
    gl->f.Viewport(view.x0, view.y0, gp_rect_w(view), gp_rect_h(view));
    gl->f.Enable(GL_SCISSOR_TEST);
    gl->f.Scissor(cut.x0, cut.y0, gp_rect_w(cut), gp_rect_h(cut));
    (draw->replace ? gl->f.Disable : gl->f.Enable)(GL_BLEND);
    set_space(gl, draw, true);
    gl->f.DrawArraysInstanced(GL_TRIANGLES, draw->first, draw->vertices,
                              draw->instances);
    set_space(gl, draw, false);
    gl->f.Disable(GL_SCISSOR_TEST);
    // llvmpipe (Mesa 22.3) does not know that a draw still reads an image or a
    // texel buffer: a later write to it, or its end, would be seen too early
    if (gl->info.software && units.image > 0)
        gl->f.Finish();
    return GP_OK;
}

void gp_count_begin(const struct gp_gl *gl)
{
    if (gl->query)
        gl->f.BeginQuery(GL_FRAGMENT_SHADER_INVOCATIONS, gl->query);
}

long long gp_count_end(const struct gp_gl *gl)
{
    GLuint64 n = 0;
    if (!gl->query)
        return -1;
    gl->f.EndQuery(GL_FRAGMENT_SHADER_INVOCATIONS);
    gl->f.GetQueryObjectui64v(gl->query, GL_QUERY_RESULT, &n);
    return (long long) n;
}
