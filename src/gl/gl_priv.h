// SPDX-License-Identifier: Apache-2.0
/* Parts of a context, and shader files. */
#ifndef GP_GL_GL_PRIV_H
#define GP_GL_GL_PRIV_H

#include "gl/gl.h"

#define GL_GLEXT_PROTOTYPES // for their types: nothing is linked
#include <GL/glcorearb.h>

/* The GL functions that this program calls: one list makes the table, and
 * context.c fills it by walking the same list. X(name without "gl") */
// clang-format off
#define GP_GL_FUNCTIONS(X)                                                    \
    X(AttachShader) X(BeginQuery) X(BindBufferBase) X(BindFramebuffer)        \
    X(BindImageTexture) X(BindTextureUnit) X(BindVertexArray) X(BlendFunc)    \
    X(CheckNamedFramebufferStatus) X(ClearNamedFramebufferfv) X(ClipControl)  \
    X(CompileShader) X(CreateBuffers) X(CreateFramebuffers) X(CreateProgram)  \
    X(CreateShader) X(CreateTextures) X(CreateVertexArrays) X(CullFace)       \
    X(DeleteBuffers) X(DeleteFramebuffers) X(DeleteProgram) X(DeleteQueries)  \
    X(DeleteShader) X(DeleteTextures) X(DeleteVertexArrays) X(DepthFunc)      \
    X(DepthMask) X(Disable) X(DrawArraysInstanced) X(Enable) X(EndQuery)      \
    X(Finish) X(GenQueries) X(GetError) X(GetIntegerv) X(GetProgramInfoLog)   \
    X(GetProgramiv) X(GetQueryObjectui64v) X(GetShaderInfoLog)                \
    X(GetShaderiv) X(GetStringi) X(GetUniformBlockIndex)                      \
    X(GetUniformLocation) X(LinkProgram) X(NamedBufferStorage)                \
    X(NamedBufferSubData) X(NamedFramebufferDrawBuffers)                      \
    X(NamedFramebufferReadBuffer) X(NamedFramebufferTexture) X(PixelStorei)   \
    X(ReadPixels) X(Scissor) X(ShaderSource) X(TextureBuffer)                 \
    X(TextureParameteri) X(TextureStorage2D) X(TextureSubImage2D)             \
    X(Uniform1fv) X(Uniform1i) X(Uniform2fv) X(Uniform2iv) X(Uniform4fv)      \
    X(UniformBlockBinding) X(UniformMatrix4fv) X(UseProgram) X(Viewport)
// clang-format on

struct gp_gl_functions {
#define GP_GL_FIELD(name) __typeof__(gl##name) *(name);
    GP_GL_FUNCTIONS(GP_GL_FIELD)
#undef GP_GL_FIELD
};

struct gp_gl {
    const struct gp_gl_system *system;
    void *window; // the system's own
    void (*(*proc)(const char *name))(void);
    struct gp_gl_functions f;
    GLuint vertex_array; // core profile draws nothing without one
    GLuint query;        // of gp_count_begin(); 0: the driver counts nothing
    struct gp_gl_info info;
};

/* The files of src/gl/shaders, byte for byte; the Makefile makes the list. */
struct gp_shader_file {
    const char *name; // "splat.vert"
    const char *text; // GLSL without #version
};
extern const struct gp_shader_file gp_shader_files[]; // name NULL ends

/* gp_program_make() from texts that need not be files. */
GP_MUST_CHECK gp_status gp_program_from_text(const struct gp_log *log,
    const struct gp_gl *gl, const char *defines,
    const struct gp_shader_file *vert, const struct gp_shader_file *frag,
    struct gp_program *out);

#endif
