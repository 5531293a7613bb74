// SPDX-License-Identifier: Apache-2.0
/* Parts of a context, and shader files. */
#ifndef GP_GL_GL_PRIV_H
#define GP_GL_GL_PRIV_H

#include "gl/gl.h"

#include <GL/glcorearb.h>

/* A library that gives headless contexts. `file` lists its names, NULL ends;
 * gp_env() names another, and `package` is Debian's. */
struct gp_gl_system {
    const char *name, *package;
    const char *const *file;

    /* Makes a context, 4.5 core where that can be had, else of any version
     * so that the caller can say which one was found. Not yet current.
     * *window is the system's own, and freed by close(). */
    gp_status (*open)(const struct gp_log *log, void *library, void **window);
    bool (*make_current)(void *window); // false: the system refused
    void (*release)(void *window);      // no context is current after it
    void (*close)(void *window);        // it is not current then
    void (*(*proc)(void *window, const char *name))(void);
};
extern const struct gp_gl_system gp_gl_osmesa, gp_gl_egl;

/* The GL functions that this program calls: one list makes the table, and
 * context.c fills it by walking the same list. X(type, name without "gl") */
#define GP_GL_FUNCTIONS(X)                                                    \
    X(PFNGLATTACHSHADERPROC, AttachShader)                                    \
    X(PFNGLBEGINQUERYPROC, BeginQuery)                                        \
    X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                                \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                              \
    X(PFNGLBINDIMAGETEXTUREPROC, BindImageTexture)                            \
    X(PFNGLBINDTEXTUREUNITPROC, BindTextureUnit)                              \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                              \
    X(PFNGLBLENDFUNCPROC, BlendFunc)                                          \
    X(PFNGLCHECKNAMEDFRAMEBUFFERSTATUSPROC, CheckNamedFramebufferStatus)      \
    X(PFNGLCLEARNAMEDFRAMEBUFFERFVPROC, ClearNamedFramebufferfv)              \
    X(PFNGLCLIPCONTROLPROC, ClipControl)                                      \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                                  \
    X(PFNGLCREATEBUFFERSPROC, CreateBuffers)                                  \
    X(PFNGLCREATEFRAMEBUFFERSPROC, CreateFramebuffers)                        \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                                  \
    X(PFNGLCREATESHADERPROC, CreateShader)                                    \
    X(PFNGLCREATETEXTURESPROC, CreateTextures)                                \
    X(PFNGLCREATEVERTEXARRAYSPROC, CreateVertexArrays)                        \
    X(PFNGLCULLFACEPROC, CullFace)                                            \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                                  \
    X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                        \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                  \
    X(PFNGLDELETEQUERIESPROC, DeleteQueries)                                  \
    X(PFNGLDELETESHADERPROC, DeleteShader)                                    \
    X(PFNGLDELETETEXTURESPROC, DeleteTextures)                                \
    X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                        \
    X(PFNGLDEPTHFUNCPROC, DepthFunc)                                          \
    X(PFNGLDEPTHMASKPROC, DepthMask)                                          \
    X(PFNGLDISABLEPROC, Disable)                                              \
    X(PFNGLDRAWARRAYSINSTANCEDPROC, DrawArraysInstanced)                      \
    X(PFNGLENABLEPROC, Enable)                                                \
    X(PFNGLENDQUERYPROC, EndQuery)                                            \
    X(PFNGLFINISHPROC, Finish)                                                \
    X(PFNGLGENQUERIESPROC, GenQueries)                                        \
    X(PFNGLGETERRORPROC, GetError)                                            \
    X(PFNGLGETINTEGERVPROC, GetIntegerv)                                      \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                          \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                    \
    X(PFNGLGETQUERYOBJECTUI64VPROC, GetQueryObjectui64v)                      \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                            \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                      \
    X(PFNGLGETSTRINGIPROC, GetStringi)                                        \
    X(PFNGLGETUNIFORMBLOCKINDEXPROC, GetUniformBlockIndex)                    \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                        \
    X(PFNGLLINKPROGRAMPROC, LinkProgram)                                      \
    X(PFNGLNAMEDBUFFERSTORAGEPROC, NamedBufferStorage)                        \
    X(PFNGLNAMEDBUFFERSUBDATAPROC, NamedBufferSubData)                        \
    X(PFNGLNAMEDFRAMEBUFFERDRAWBUFFERSPROC, NamedFramebufferDrawBuffers)      \
    X(PFNGLNAMEDFRAMEBUFFERREADBUFFERPROC, NamedFramebufferReadBuffer)        \
    X(PFNGLNAMEDFRAMEBUFFERTEXTUREPROC, NamedFramebufferTexture)              \
    X(PFNGLPIXELSTOREIPROC, PixelStorei)                                      \
    X(PFNGLREADPIXELSPROC, ReadPixels)                                        \
    X(PFNGLSCISSORPROC, Scissor)                                              \
    X(PFNGLSHADERSOURCEPROC, ShaderSource)                                    \
    X(PFNGLTEXTUREBUFFERPROC, TextureBuffer)                                  \
    X(PFNGLTEXTUREPARAMETERIPROC, TextureParameteri)                          \
    X(PFNGLTEXTURESTORAGE2DPROC, TextureStorage2D)                            \
    X(PFNGLTEXTURESUBIMAGE2DPROC, TextureSubImage2D)                          \
    X(PFNGLUNIFORM1FVPROC, Uniform1fv)                                        \
    X(PFNGLUNIFORM1IPROC, Uniform1i)                                          \
    X(PFNGLUNIFORM2FVPROC, Uniform2fv)                                        \
    X(PFNGLUNIFORM2IVPROC, Uniform2iv)                                        \
    X(PFNGLUNIFORM4FVPROC, Uniform4fv)                                        \
    X(PFNGLUNIFORMBLOCKBINDINGPROC, UniformBlockBinding)                      \
    X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv)                            \
    X(PFNGLUSEPROGRAMPROC, UseProgram)                                        \
    X(PFNGLVIEWPORTPROC, Viewport)

struct gp_gl_functions {
#define GP_GL_FIELD(type, name) type name;
    GP_GL_FUNCTIONS(GP_GL_FIELD)
#undef GP_GL_FIELD
};

struct gp_gl {
    const struct gp_gl_system *system;
    void *window;
    struct gp_gl_functions f;
    GLuint vertex_array; // core profile draws nothing without one
    GLuint query;        // of gp_count_begin(); 0: the driver counts nothing
    struct gp_gl_info info;
};

/* Makes `gl` current before its objects are deleted, as another context may
 * have objects of the same names. False where the system refuses it; objects
 * end with their context anyway. */
bool gp_gl_reach(const struct gp_gl *gl);

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
