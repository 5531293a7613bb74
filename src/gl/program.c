#include "gl/program.h"

#include "gl/context.h"

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
                         GLenum kind, const struct gp_shader_file *file,
                         GLuint *out)
{
    const struct gp_shader_file *common = find_file("common.glsl");
    const char *const parts[] = {"#version 450 core\n",
                                 common ? common->text : "", "\n#line 1\n",
                                 file->text};
    GLuint shader = gl->f.CreateShader(kind);
    GLint compiled = 0;
    gl->f.ShaderSource(shader, 4, parts, NULL);
    gl->f.CompileShader(shader);
    gl->f.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (!compiled) {
        char text[LOG_BYTES] = "";
        gl->f.GetShaderInfoLog(shader, sizeof text, NULL, text);
        gl->f.DeleteShader(shader);
        return gp_fail(log, GP_ERR_GL,
                       "%s: shader %s does not compile (%s); report it with "
                       "this line, or take --engine fft", gp_gl_name(gl),
                       file->name, text);
    }
    *out = shader;
    return GP_OK;
}

static gp_status link_program(const struct gp_log *log, const struct gp_gl *gl,
                              const char *name, GLuint program)
{
    GLint linked = 0;
    gl->f.LinkProgram(program);
    gl->f.GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked)
        return GP_OK;
    char text[LOG_BYTES] = "";
    gl->f.GetProgramInfoLog(program, sizeof text, NULL, text);
    return gp_fail(log, GP_ERR_GL,
                   "%s: program %s does not link (%s); report it with this "
                   "line, or take --engine fft", gp_gl_name(gl), name, text);
}

gp_status gp_program_from_text(const struct gp_log *log,
                               const struct gp_gl *gl,
                               const struct gp_shader_file *vert,
                               const struct gp_shader_file *frag,
                               struct gp_program *out)
{
    gp_status st;
    GLuint v = 0, f = 0;
    struct gp_program p = {0};
    GP_TRY(compile(log, gl, GL_VERTEX_SHADER, vert, &v));
    GP_TRY(compile(log, gl, GL_FRAGMENT_SHADER, frag, &f));
    p.id = gl->f.CreateProgram();
    gl->f.AttachShader(p.id, v);
    gl->f.AttachShader(p.id, f);
    GP_TRY(link_program(log, gl, vert->name, p.id));
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
                          const char *vert, const char *frag,
                          struct gp_program *out)
{
    const struct gp_shader_file *v = find_file(vert), *f = find_file(frag);
    if (!v || !f)
        return gp_fail(log, GP_ERR_BUG,
                       "%s: no such shader file in this build; report it",
                       v ? frag : vert);
    return gp_program_from_text(log, gl, v, f, out);
}

void gp_program_free(const struct gp_gl *gl, struct gp_program *p)
{
    if (p->id)
        gl->f.DeleteProgram(p->id);
    p->id = 0;
}

/* -- drawing --------------------------------------------------------------- */

static gp_status set_uniforms(const struct gp_log *log, const struct gp_gl *gl,
                              const struct gp_draw *draw)
{
    GLuint unit = 0;
    for (const struct gp_uniform *u = draw->uniform; u->name; u++) {
        GLint at = gl->f.GetUniformLocation(draw->program->id, u->name);
        if (at < 0)
            return gp_fail(log, GP_ERR_BUG,
                           "uniform %s: the program has none of that name; "
                           "report it", u->name);
        if (u->texture) {
            gl->f.BindTextureUnit(unit, u->texture->id);
            gl->f.Uniform1i(at, (GLint) unit++);
        } else {
            gl->f.Uniform2iv(at, 1, u->v);
        }
    }
    return GP_OK;
}

gp_status gp_draw_add(const struct gp_log *log, const struct gp_gl *gl,
                      const struct gp_draw *draw)
{
    const struct gp_texture *to = &draw->target->colour;
    struct gp_rect cut = gp_rect_meet(draw->cut,
                                      (struct gp_rect) {0, 0, to->w, to->h});
    if (gp_rect_empty(cut))
        return GP_OK;
    gl->f.UseProgram(draw->program->id);
    gp_status st = set_uniforms(log, gl, draw);
    if (st)
        return st;
    gl->f.BindFramebuffer(GL_FRAMEBUFFER, draw->target->framebuffer);
    gl->f.Viewport(0, 0, to->w, to->h);
    gl->f.Enable(GL_SCISSOR_TEST);
    gl->f.Scissor(cut.x0, cut.y0, gp_rect_w(cut), gp_rect_h(cut));
    gl->f.Enable(GL_BLEND);
    gl->f.DrawArraysInstanced(GL_TRIANGLES, 0, draw->vertices,
                              draw->instances);
    gl->f.Disable(GL_SCISSOR_TEST);
    return GP_OK;
}
