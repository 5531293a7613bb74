/* The GL functions that this program calls: one list makes the table, and
 * context.c fills it by walking the same list. Only src/gl includes this. */
#ifndef GP_GL_FUNCTIONS_H
#define GP_GL_FUNCTIONS_H

#include <GL/glcorearb.h>

/* X(type, name without "gl") */
#define GP_GL_FUNCTIONS(X)                                                    \
    X(PFNGLATTACHSHADERPROC, AttachShader)                                    \
    X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                                \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                              \
    X(PFNGLBINDIMAGETEXTUREPROC, BindImageTexture)                            \
    X(PFNGLBINDTEXTUREUNITPROC, BindTextureUnit)                              \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                              \
    X(PFNGLBLENDFUNCPROC, BlendFunc)                                          \
    X(PFNGLCHECKNAMEDFRAMEBUFFERSTATUSPROC, CheckNamedFramebufferStatus)      \
    X(PFNGLCLEARNAMEDFRAMEBUFFERFVPROC, ClearNamedFramebufferfv)              \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                                  \
    X(PFNGLCREATEBUFFERSPROC, CreateBuffers)                                  \
    X(PFNGLCREATEFRAMEBUFFERSPROC, CreateFramebuffers)                        \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                                  \
    X(PFNGLCREATESHADERPROC, CreateShader)                                    \
    X(PFNGLCREATETEXTURESPROC, CreateTextures)                                \
    X(PFNGLCREATEVERTEXARRAYSPROC, CreateVertexArrays)                        \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                                  \
    X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                        \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                  \
    X(PFNGLDELETESHADERPROC, DeleteShader)                                    \
    X(PFNGLDELETETEXTURESPROC, DeleteTextures)                                \
    X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                        \
    X(PFNGLDISABLEPROC, Disable)                                              \
    X(PFNGLDRAWARRAYSINSTANCEDPROC, DrawArraysInstanced)                      \
    X(PFNGLENABLEPROC, Enable)                                                \
    X(PFNGLFINISHPROC, Finish)                                                \
    X(PFNGLGETERRORPROC, GetError)                                            \
    X(PFNGLGETFLOATVPROC, GetFloatv)                                          \
    X(PFNGLGETINTEGERVPROC, GetIntegerv)                                      \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                          \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                    \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                            \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                      \
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
    X(PFNGLUSEPROGRAMPROC, UseProgram)                                        \
    X(PFNGLVIEWPORTPROC, Viewport)

struct gp_gl_functions {
#define GP_GL_FIELD(type, name) type name;
    GP_GL_FUNCTIONS(GP_GL_FIELD)
#undef GP_GL_FIELD
};

#endif
