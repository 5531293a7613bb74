// SPDX-License-Identifier: Apache-2.0
/* OSMesa that breaks: the real one with some of its answers changed.
 * Give its path in GLAREPP_OSMESA, and in BROKEN_GL what is to break:
 *
 *   context    no context can be made
 *   current    it cannot be made current
 *   core       no context of 4.5 core can be made, but an older one
 *   old        it is OpenGL 2.1
 *   words      its version is no number
 *   silent     it has no version
 *   unnamed    its renderer has no name
 *   missing    glCreateTextures is not there
 *   compile    no shader compiles; the log has two lines
 *   link       no program links
 *   framebuffer  no framebuffer is complete
 *   memory     texture storage ends in GL_OUT_OF_MEMORY
 *   lost       after BROKEN_GL_AFTER draws (0) every call of glGetError says
 *              GL_CONTEXT_LOST
 *
 * The function that BROKEN_GL_MISSING names is not there.
 */
#include <dlfcn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void (*proc)(void);
enum {
    COMPILE_STATUS = 0x8B81, LINK_STATUS = 0x8B82, RENDERER = 0x1F01, VERSION = 0x1F02,
    OUT_OF_MEMORY = 0x0505, CONTEXT_LOST = 0x0507,
};

static long draws;
static bool full;

static bool is(const char *what)
{
    const char *const broken = getenv("BROKEN_GL");
    return broken && strcmp(broken, what) == 0;
}

static void *real(const char *name)
{
    static void *library;
    if (!library)
        library = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
    if (!library)
        library = dlopen("libOSMesa.so", RTLD_NOW | RTLD_LOCAL);
    return library ? dlsym(library, name) : NULL;
}

/* A function of the real GL, as the pointer it is used as. */
static proc real_gl(const char *name)
{
    proc (*get)(const char *) = (proc (*)(const char *))
        real("OSMesaGetProcAddress");
    return get ? get(name) : NULL;
}

// -- changed calls ---------------------------------------------------------------

static void get_shader(unsigned shader, unsigned what, int *out)
{
    ((void (*)(unsigned, unsigned, int *)) real_gl("glGetShaderiv"))(
        shader, what, out);
    if (what == COMPILE_STATUS)
        *out = 0;
}

static void get_log(unsigned object, int room, int *size, char *text)
{
    (void) object;
    const int n = snprintf(text, (size_t) room, "0:1: refused\n0:2: refused");
    if (size)
        *size = n;
}

static void get_program(unsigned program, unsigned what, int *out)
{
    ((void (*)(unsigned, unsigned, int *)) real_gl("glGetProgramiv"))(
        program, what, out);
    if (what == LINK_STATUS)
        *out = 0;
}

static const unsigned char *get_string(unsigned what)
{
    if (what == RENDERER && is("unnamed"))
        return NULL;
    if (what == VERSION && !is("unnamed"))
        return is("silent") ? NULL : (const unsigned char *)
                                         (is("old") ? "2.1 Mesa" : "no number");
    return ((const unsigned char *(*)(unsigned)) real_gl("glGetString"))(what);
}

static unsigned check_framebuffer(unsigned framebuffer, unsigned target)
{
    (void) framebuffer;
    (void) target;
    return 0x8CDD; // GL_FRAMEBUFFER_UNSUPPORTED
}

static void storage(unsigned texture, int levels, unsigned format, int w, int h)
{
    ((void (*)(unsigned, int, unsigned, int, int)) real_gl(
        "glTextureStorage2D"))(texture, levels, format, w, h);
    full = true;
}

static void draw(unsigned mode, int first, int count, int instances)
{
    ((void (*)(unsigned, int, int, int)) real_gl("glDrawArraysInstanced"))(
        mode, first, count, instances);
    draws++;
}

static unsigned get_error(void)
{
    const char *const after = getenv("BROKEN_GL_AFTER");
    if (is("lost") && draws > (after ? strtol(after, NULL, 10) : 0))
        return CONTEXT_LOST;
    if (is("memory") && full) {
        full = false;
        return OUT_OF_MEMORY;
    }
    return ((unsigned (*)(void)) real_gl("glGetError"))();
}

static const struct { const char *broken, *name; proc to; } changed[] = {
    {"old", "glGetString", (proc) get_string},
    {"words", "glGetString", (proc) get_string},
    {"silent", "glGetString", (proc) get_string},
    {"unnamed", "glGetString", (proc) get_string},
    {"missing", "glCreateTextures", NULL},
    {"compile", "glGetShaderiv", (proc) get_shader},
    {"compile", "glGetShaderInfoLog", (proc) get_log},
    {"link", "glGetProgramiv", (proc) get_program},
    {"link", "glGetProgramInfoLog", (proc) get_log},
    {"framebuffer", "glCheckNamedFramebufferStatus", (proc) check_framebuffer},
    {"memory", "glTextureStorage2D", (proc) storage},
    {"memory", "glGetError", (proc) get_error},
    {"lost", "glDrawArraysInstanced", (proc) draw},
    {"lost", "glGetError", (proc) get_error},
};

// -- OSMesa ----------------------------------------------------------------------

proc OSMesaGetProcAddress(const char *name);
proc OSMesaGetProcAddress(const char *name)
{
    const char *const missing = getenv("BROKEN_GL_MISSING");
    if (missing && strcmp(missing, name) == 0)
        return NULL;
    for (size_t i = 0; i < sizeof changed / sizeof *changed; i++) {
        if (is(changed[i].broken) && strcmp(changed[i].name, name) == 0)
            return changed[i].to;
    }
    return real_gl(name);
}

void *OSMesaCreateContextAttribs(const int *attributes, void *share);
void *OSMesaCreateContextAttribs(const int *attributes, void *share)
{
    if (is("context") || (is("core") && attributes[2] != 0))
        return NULL;
    return ((void *(*)(const int *, void *)) real(
        "OSMesaCreateContextAttribs"))(attributes, share);
}

unsigned char OSMesaMakeCurrent(void *context, void *buffer, unsigned type,
                                int w, int h);
unsigned char OSMesaMakeCurrent(void *context, void *buffer, unsigned type,
                                int w, int h)
{
    if (context && is("current"))
        return 0;
    return ((unsigned char (*)(void *, void *, unsigned, int, int)) real(
        "OSMesaMakeCurrent"))(context, buffer, type, w, h);
}

void OSMesaDestroyContext(void *context);
void OSMesaDestroyContext(void *context)
{
    ((void (*)(void *)) real("OSMesaDestroyContext"))(context);
}
