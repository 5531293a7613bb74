#include "gl/gl_priv.h"

#include <string.h>

enum { LOG_BYTES = 2048 };

/* -- making ---------------------------------------------------------------- */

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
    const struct gp_shader_file *common = find_file("common.glsl");
    const char *const parts[] = {"#version 450 core\n", defines,
                                 common ? common->text : "", "\n#line 1\n",
                                 file->text};
    GLuint shader = gl->f.CreateShader(kind);
    GLint compiled = 0;
    gl->f.ShaderSource(shader, 5, parts, NULL);
    gl->f.CompileShader(shader);
    gl->f.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (!compiled) {
        char text[LOG_BYTES] = "";
        gl->f.GetShaderInfoLog(shader, sizeof text, NULL, text);
        gl->f.DeleteShader(shader);
        return gp_fail(log, GP_ERR_GL,
                       "%s: shader %s does not compile (%s); report this, and "
                       "use --engine fft", gl->info.name, file->name, text);
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
        GP_TRY(gp_fail(log, GP_ERR_GL,
                       "%s: program %s does not link (%s); report this, and "
                       "use --engine fft", gl->info.name, vert->name, text));
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
    if (!v || !f)
        return gp_fail(log, GP_ERR_BUG,
                       "%s: no such shader file in this build; report this",
                       v ? frag : vert);
    return gp_program_from_text(log, gl, defines, v, f, out);
}

void gp_program_free(const struct gp_gl *gl, struct gp_program *p)
{
    if (p->id && gp_gl_reach(gl))
        gl->f.DeleteProgram(p->id);
    p->id = 0;
}

/* -- drawing --------------------------------------------------------------- */

gp_status gp_draw_run(const struct gp_log *log, const struct gp_gl *gl,
                      const struct gp_draw *draw)
{
    const struct gp_rect target = {0, 0, draw->target->colour.w,
                                   draw->target->colour.h};
    const struct gp_rect cut = gp_rect_meet(draw->cut, target);
    const struct gp_rect view = gp_rect_empty(draw->view) ? target
                                                          : draw->view;
    const GLuint program = draw->program->id;
    GLuint texture = 0, image = 0, block = 0; // the next unit of each
    if (gp_rect_empty(cut))
        return GP_OK;
    gl->f.UseProgram(program);
    for (const struct gp_uniform *u = draw->uniform; u->name; u++) {
        // a block's index, and what is no place of either: all bits set
        const GLuint place =
            u->block ? gl->f.GetUniformBlockIndex(program, u->name)
                     : (GLuint) gl->f.GetUniformLocation(program, u->name);
        const GLint at = (GLint) place;
        if (place == GL_INVALID_INDEX)
            return gp_fail(log, GP_ERR_BUG, "uniform %s: the program has none "
                           "of this name; report this", u->name);
        if (u->block) {
            gl->f.UniformBlockBinding(program, place, block);
            gl->f.BindBufferBase(GL_UNIFORM_BUFFER, block++, u->block->id);
        } else if (u->texture) {
            gl->f.BindTextureUnit(texture, u->texture->id);
            gl->f.Uniform1i(at, (GLint) texture++);
        } else if (u->image || u->texels) {
            const GLuint id = u->image ? u->image->id : u->texels->texture;
            gl->f.BindImageTexture(image, id, 0, GL_FALSE, 0, GL_READ_ONLY,
                                   GL_RGBA32F);
            gl->f.Uniform1i(at, (GLint) image++);
        } else if (u->floats == 1) {
            gl->f.Uniform1fv(at, 1, u->f);
        } else if (u->floats == 2) {
            gl->f.Uniform2fv(at, 1, u->f);
        } else if (u->floats) {
            gl->f.Uniform4fv(at, 1, u->f);
        } else {
            gl->f.Uniform2iv(at, 1, u->v);
        }
    }
    gl->f.BindFramebuffer(GL_FRAMEBUFFER, draw->target->framebuffer);
    gl->f.Viewport(view.x0, view.y0, gp_rect_w(view), gp_rect_h(view));
    gl->f.Enable(GL_SCISSOR_TEST);
    gl->f.Scissor(cut.x0, cut.y0, gp_rect_w(cut), gp_rect_h(cut));
    (draw->replace ? gl->f.Disable : gl->f.Enable)(GL_BLEND);
    (draw->points ? gl->f.Enable : gl->f.Disable)(GL_PROGRAM_POINT_SIZE);
    gl->f.DrawArraysInstanced(draw->points ? GL_POINTS : GL_TRIANGLES, 0,
                              draw->vertices, draw->instances);
    gl->f.Disable(GL_SCISSOR_TEST);
    // llvmpipe (Mesa 22.3) does not know that a draw still reads an image or a
    // texel buffer: a later write to it, or its end, would be seen too early
    if (gl->info.software && image > 0)
        gl->f.Finish();
    return GP_OK;
}
