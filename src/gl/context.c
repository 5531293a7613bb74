// SPDX-License-Identifier: Apache-2.0
/* Contexts of OSMesa, Mesa's off-screen library, a rasterizer on the CPU that
 * needs no display, no device and no driver; and of EGL without a window, on a
 * GPU through the device platform, or on Mesa's surfaceless platform. */
#include "core/env.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "gl/gl_priv.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// -- OSMesa -------------------------------------------------------------------

/* From Mesa's GL/osmesa.h, which newer Mesa does not install. */
typedef struct osmesa_context *OSMesaContext;
typedef void (*OSMESAproc)(void);
enum {
    OSMESA_RGBA = GL_RGBA,
    OSMESA_FORMAT = 0x22,
    OSMESA_PROFILE = 0x33,
    OSMESA_CORE_PROFILE = 0x34,
    OSMESA_CONTEXT_MAJOR_VERSION = 0x36,
    OSMESA_CONTEXT_MINOR_VERSION = 0x37,
};

struct osmesa {
    OSMesaContext context;
    OSMesaContext (*create)(const int *attributes, OSMesaContext share);
    GLboolean (*make_current)(OSMesaContext, void *buffer, GLenum type,
                              GLsizei w, GLsizei h);
    void (*destroy)(OSMesaContext);
    OSMESAproc (*proc)(const char *name);
    unsigned char pixel[4]; // the window that OSMesa wants; never drawn to
};

static void close_osmesa(void *window)
{
    struct osmesa *o = window;
    if (o->context)
        o->destroy(o->context);
    gp_free(o);
}

static gp_status open_osmesa(const struct gp_log *log, void *library,
                             void **window)
{
    static const int core[] = {OSMESA_FORMAT, OSMESA_RGBA,
                               OSMESA_PROFILE, OSMESA_CORE_PROFILE,
                               OSMESA_CONTEXT_MAJOR_VERSION, 4,
                               OSMESA_CONTEXT_MINOR_VERSION, 5, 0};
    static const int any[] = {OSMESA_FORMAT, OSMESA_RGBA, 0};
    struct osmesa *o;
    gp_status st = gp_alloc_zero(log, "OSMesa context", 1, sizeof *o, &o);
    if (st)
        return st;
#define LOAD(field, symbol)                                                   \
    *(void **) &o->field = dlsym(library, symbol);                            \
    if (!o->field)                                                            \
        GP_TRY(gp_fail_at(log, GP_ERR_GL, "layer.gl.osmesa",                  \
                          "OSMesa: " symbol " is missing; install OSMesa "    \
                          "11.2 or newer (Debian package libosmesa6)"))
    LOAD(create, "OSMesaCreateContextAttribs");
    LOAD(make_current, "OSMesaMakeCurrent");
    LOAD(destroy, "OSMesaDestroyContext");
    LOAD(proc, "OSMesaGetProcAddress");
#undef LOAD
    o->context = o->create(core, NULL);
    if (!o->context)
        o->context = o->create(any, NULL);
    if (!o->context)
        GP_TRY(gp_fail_at(log, GP_ERR_GL, "layer.gl.osmesa",
                          "OSMesa: cannot make a context (neither 4.5 core nor "
                          "any other); install the Debian package "
                          "libosmesa6"));
    *window = o;
    return GP_OK;
out:
    close_osmesa(o);
    return st;
}

static bool osmesa_make_current(void *window)
{
    struct osmesa *o = window;
    return o->make_current(o->context, o->pixel, GL_UNSIGNED_BYTE, 1, 1);
}

static void osmesa_release(void *window)
{
    struct osmesa *o = window;
    o->make_current(NULL, NULL, 0, 0, 0);
}

static void (*osmesa_proc(void *window, const char *name))(void)
{
    struct osmesa *o = window;
    return o->proc(name);
}

const struct gp_gl_system gp_gl_osmesa = {
    .name = "OSMesa",
    .package = "libosmesa6",
    .file = (const char *const[]) {"libOSMesa.so.8", "libOSMesa.so.6",
                                   "libOSMesa.so", NULL},
    .open = open_osmesa,
    .make_current = osmesa_make_current,
    .release = osmesa_release,
    .close = close_osmesa,
    .proc = osmesa_proc,
};

// -- EGL ----------------------------------------------------------------------

enum { MAX_DEVICES = 16 };

/* X(type, field, name); the extension functions come by GetProcAddress. */
#define EGL_FUNCTIONS(X)                                                      \
    X(PFNEGLBINDAPIPROC, bind_api, "eglBindAPI")                              \
    X(PFNEGLCHOOSECONFIGPROC, choose_config, "eglChooseConfig")               \
    X(PFNEGLCREATECONTEXTPROC, create_context, "eglCreateContext")            \
    X(PFNEGLDESTROYCONTEXTPROC, destroy_context, "eglDestroyContext")         \
    X(PFNEGLINITIALIZEPROC, initialize, "eglInitialize")                      \
    X(PFNEGLMAKECURRENTPROC, make_current, "eglMakeCurrent")                  \
    X(PFNEGLQUERYSTRINGPROC, query_string, "eglQueryString")

struct egl_functions {
#define FIELD(type, field, name) type field;
    EGL_FUNCTIONS(FIELD)
#undef FIELD
    PFNEGLGETPROCADDRESSPROC proc;
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display;  // may be NULL
    PFNEGLQUERYDEVICESEXTPROC query_devices;      // may be NULL
    PFNEGLQUERYDEVICESTRINGEXTPROC device_string; // may be NULL
};

struct egl {
    struct egl_functions f;
    EGLDisplay display;
    EGLContext context;
};

/* Returns true when `name` is a whole word of `list`. */
static bool has(const char *list, const char *name)
{
    size_t n = strlen(name);
    for (const char *at = list; at && (at = strstr(at, name)); at += n) {
        bool starts = at == list || at[-1] == ' ';
        if (starts && (at[n] == ' ' || at[n] == '\0'))
            return true;
    }
    return false;
}

/* Uses the display when a context can be made on it. Displays are never
 * terminated: that would take them from every context of the process, and
 * unload a driver that does not survive it. */
static bool try_display(struct egl *e, EGLDisplay display)
{
    static const EGLint wanted[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE,
                                    EGL_OPENGL_BIT, EGL_NONE};
    static const EGLint core[] = {
        EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5,
        EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
        EGL_NONE};
    static const EGLint any[] = {EGL_NONE};
    const struct egl_functions *const f = &e->f;
    EGLConfig config;
    EGLint configs = 0;
    if (display == EGL_NO_DISPLAY || !f->initialize(display, NULL, NULL) ||
        !has(f->query_string(display, EGL_EXTENSIONS),
             "EGL_KHR_surfaceless_context") ||
        !f->bind_api(EGL_OPENGL_API) ||
        !f->choose_config(display, wanted, &config, 1, &configs) || configs < 1)
        return false;
    e->display = display;
    e->context = f->create_context(display, config, EGL_NO_CONTEXT, core);
    if (!e->context)
        e->context = f->create_context(display, config, EGL_NO_CONTEXT, any);
    return e->context != EGL_NO_CONTEXT;
}

static gp_status find_display(const struct gp_log *log, struct egl *e)
{
    const char *extensions = e->f.query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (!e->f.get_display || !extensions)
        return gp_fail_at(log, GP_ERR_GL, "layer.gl.egl",
                          "EGL: no platform extensions (needs EGL 1.5 or "
                          "EGL_EXT_platform_base); install the Debian package "
                          "libegl-mesa0");
    // the first device with a context that is neither Mesa's rasterizer nor
    // one that does not say
    EGLDeviceEXT device[MAX_DEVICES];
    EGLint devices = 0;
    if (!has(extensions, "EGL_EXT_platform_device") ||
        !(has(extensions, "EGL_EXT_device_base") ||
          has(extensions, "EGL_EXT_device_enumeration")) ||
        !e->f.query_devices || !e->f.device_string ||
        !e->f.query_devices(MAX_DEVICES, device, &devices))
        devices = 0;
    for (EGLint i = 0; i < devices; i++) {
        const char *text = e->f.device_string(device[i], EGL_EXTENSIONS);
        if (text && !has(text, "EGL_MESA_device_software") &&
            try_display(e, e->f.get_display(EGL_PLATFORM_DEVICE_EXT,
                                            device[i], NULL)))
            return GP_OK;
    }
    if (has(extensions, "EGL_MESA_platform_surfaceless") &&
        try_display(e, e->f.get_display(EGL_PLATFORM_SURFACELESS_MESA,
                                        EGL_DEFAULT_DISPLAY, NULL)))
        return GP_OK;
    return gp_fail_at(log, GP_ERR_GL, "layer.gl.egl",
                      "EGL: cannot make a context, neither on a GPU device nor "
                      "on Mesa's surfaceless platform; install the Debian "
                      "packages libegl-mesa0 and libgl1-mesa-dri");
}

static void close_egl(void *window)
{
    struct egl *e = window;
    if (e->context)
        e->f.destroy_context(e->display, e->context);
    gp_free(e);
}

static gp_status open_egl(const struct gp_log *log, void *library,
                          void **window)
{
    struct egl *e;
    gp_status st = gp_alloc_zero(log, "EGL context", 1, sizeof *e, &e);
    if (st)
        return st;
    struct egl_functions *const f = &e->f;
    f->proc = (PFNEGLGETPROCADDRESSPROC) dlsym(library, "eglGetProcAddress");
#define LOAD(type, field, name)                                               \
    f->field = (type) dlsym(library, name);                                   \
    if (!f->field || !f->proc)                                                \
        GP_TRY(gp_fail_at(log, GP_ERR_GL, "layer.gl.egl",                     \
                          "EGL: " name " is missing; install the Debian "     \
                          "packages libegl1 and libegl-mesa0"));
    EGL_FUNCTIONS(LOAD)
#undef LOAD
    f->get_display = (PFNEGLGETPLATFORMDISPLAYEXTPROC) f->proc(
        "eglGetPlatformDisplayEXT");
    f->query_devices = (PFNEGLQUERYDEVICESEXTPROC) f->proc(
        "eglQueryDevicesEXT");
    f->device_string = (PFNEGLQUERYDEVICESTRINGEXTPROC) f->proc(
        "eglQueryDeviceStringEXT");
    GP_TRY(find_display(log, e));
    *window = e;
    return GP_OK;
out:
    close_egl(e);
    return st;
}

static bool egl_make_current(void *window)
{
    struct egl *e = window;
    return e->f.bind_api(EGL_OPENGL_API) &&
           e->f.make_current(e->display, EGL_NO_SURFACE, EGL_NO_SURFACE,
                             e->context);
}

static void egl_release(void *window)
{
    struct egl *e = window;
    e->f.make_current(e->display, EGL_NO_SURFACE, EGL_NO_SURFACE,
                      EGL_NO_CONTEXT);
}

static void (*egl_proc(void *window, const char *name))(void)
{
    struct egl *e = window;
    return e->f.proc(name);
}

const struct gp_gl_system gp_gl_egl = {
    .name = "EGL",
    .package = "libegl1 (and libegl-mesa0)",
    .file = (const char *const[]) {"libEGL.so.1", "libEGL.so", NULL},
    .open = open_egl,
    .make_current = egl_make_current,
    .release = egl_release,
    .close = close_egl,
    .proc = egl_proc,
};

enum {
    GL_NEED = 45,     // OpenGL 4.5, as 10 * major + minor
    LINE_BYTES = 512, // of a message
};

static _Thread_local const struct gp_gl *current;

/* Opens the system's library, or the file that the environment names. */
static gp_status open_library(const struct gp_log *log,
                              const struct gp_gl_system *system, void **out)
{
    const struct gp_env *const env = gp_env();
    const char *const forced =
        system == &gp_gl_osmesa ? env->osmesa : env->egl;
    const char *const only[] = {forced, NULL};
    const char *const *list = forced ? only : system->file;
    char why[256] = "no reason given";
    for (const char *const *n = list; *n; n++) {
        *out = dlopen(*n, RTLD_NOW | RTLD_LOCAL);
        if (*out)
            return GP_OK;
        const char *text = dlerror();
        const size_t length = strlen(*n);
        if (n != list || !text) // the first is the one that should be there
            continue;
        // the message names the file, and so does ours
        if (strncmp(text, *n, length) == 0 && text[length] == ':')
            text += length + 2;
        snprintf(why, sizeof why, "%s", text);
    }
    return gp_fail_at(log, GP_ERR_GL, "layer.engine",
                      "%s: cannot be loaded (%s); install the Debian package "
                      "%s", list[0], why, system->package);
}

/* -- making a context current --------------------------------------------- */

static void release_current(void)
{
    if (current)
        current->system->release(current->window);
    current = NULL;
}

gp_status gp_gl_use(const struct gp_log *log, const struct gp_gl *gl)
{
    if (current == gl)
        return GP_OK;
    // Mesa's two front ends share one dispatch table: release the old context
    // before the new one is made current, or a later return to it is missed
    release_current();
    if (!gl->system->make_current(gl->window))
        return gp_fail_at(log, GP_ERR_GL, "layer.gl",
                          "%s: the context cannot be made current",
                          gl->system->name);
    current = gl;
    return GP_OK;
}

bool gp_gl_reach(const struct gp_gl *gl)
{
    return gp_gl_use(NULL, gl) == GP_OK;
}

/* -- opening --------------------------------------------------------------- */

/* Refuses a GL under 4.5 or of no version; sets the name in messages. */
static gp_status check_version(const struct gp_log *log, struct gp_gl *gl)
{
    PFNGLGETSTRINGPROC get =
        (PFNGLGETSTRINGPROC) gl->system->proc(gl->window, "glGetString");
    if (!get)
        return gp_fail_at(log, GP_ERR_GL, "layer.engine",
                          "%s: glGetString is missing; install a complete "
                          "Mesa", gl->system->name);
    const char *version = (const char *) get(GL_VERSION);
    const char *renderer = (const char *) get(GL_RENDERER);
    // "4.5 (Core Profile) Mesa 22.3.6"
    char *dot = NULL, *end = NULL;
    const long major = version ? strtol(version, &dot, 10) : 0;
    const long minor = dot && *dot == '.' ? strtol(dot + 1, &end, 10) : -1;
    if (major < 1 || major > 99 || minor < 0 || minor > 9 || end == dot + 1 ||
        major * 10 + minor < GL_NEED)
        return gp_fail_at(log, GP_ERR_GL, "layer.engine",
                          "%s: needs OpenGL 4.5 (found %s); install a newer "
                          "Mesa or driver", gl->system->name,
                          version ? version : "nothing");
    char *const name = gl->info.name;
    snprintf(name, sizeof gl->info.name, "%s: %s", gl->system->name,
             renderer ? renderer : "unnamed renderer");
    gl->info.software = strstr(name, "llvmpipe") || strstr(name, "softpipe") ||
                        strstr(name, "swrast") || strstr(name, "SwiftShader");
    return GP_OK;
}

/* Prepares to count fragments, which not every driver of 4.5 can. */
static void find_counts(struct gp_gl *gl)
{
    GLint n = 0;
    gl->f.GetIntegerv(GL_NUM_EXTENSIONS, &n);
    for (GLint i = 0; i < n && !gl->query; i++) {
        const char *const name =
            (const char *) gl->f.GetStringi(GL_EXTENSIONS, (GLuint) i);
        if (name && strcmp(name, "GL_ARB_pipeline_statistics_query") == 0)
            gl->f.GenQueries(1, &gl->query);
    }
}

static gp_status open_system(const struct gp_log *log,
    const struct gp_gl_system *system, struct gp_gl **out)
{
    struct gp_gl *gl;
    gp_status st = gp_alloc_zero(log, "GL context", 1, sizeof *gl, &gl);
    if (st)
        return st;
    void *library;
    gl->system = system;
    GP_TRY(open_library(log, system, &library));
    GP_TRY(system->open(log, library, &gl->window));
    GP_TRY(gp_gl_use(log, gl));
    GP_TRY(check_version(log, gl));
#define LOAD(type, function)                                                  \
    gl->f.function = (type) system->proc(gl->window, "gl" #function);         \
    if (!gl->f.function)                                                      \
        GP_TRY(gp_fail_at(log, GP_ERR_GL, "layer.engine",                     \
                          "%s: gl" #function " is missing; install a newer "  \
                          "Mesa or driver", gl->info.name));
    GP_GL_FUNCTIONS(LOAD)
#undef LOAD

    const struct gp_gl_functions *const f = &gl->f;
    GLint texture = 0, viewport[2] = {0};
    f->GetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
    f->GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    const int asked = gp_env()->gl_size;
    const int least = gp_min(texture, gp_min(viewport[0], viewport[1]));
    gl->info.max_size = asked > 0 && asked < least ? asked : least;
    f->GetIntegerv(GL_MAX_UNIFORM_BLOCK_SIZE, &gl->info.max_block);
    f->GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &gl->info.max_texel_buffer);

    // state for the context's whole life: what this program draws has no dither,
    // its nearest fragments have the highest depth, and its rows are packed
    f->CreateVertexArrays(1, &gl->vertex_array);
    f->BindVertexArray(gl->vertex_array);
    f->Disable(GL_DITHER);
    f->Disable(GL_DEPTH_TEST);
    f->Disable(GL_CULL_FACE);
    f->BlendFunc(GL_ONE, GL_ONE);
    f->PixelStorei(GL_PACK_ALIGNMENT, 4);
    f->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    find_counts(gl);
    GP_TRY(gp_gl_check(log, gl, "setting up the context"));
    *out = gl;
    return GP_OK;
out:
    gp_gl_close(&gl);
    return st;
}

static void keep_line(void *user, const struct gp_line *line)
{
    snprintf(user, LINE_BYTES, "%s", line->text);
}

gp_status gp_gl_open(const struct gp_log *log, enum gp_gl_api api,
                     struct gp_gl **out)
{
    const struct gp_gl_system *const systems[] = {&gp_gl_osmesa, &gp_gl_egl};
    char why[2][LINE_BYTES] = {"", ""};
    if (api != GP_GL_AUTO)
        return open_system(log, systems[api == GP_GL_EGL], out);
    // an error only when both fail, with both reasons
    for (int i = 0; i < 2; i++) {
        struct gp_log quiet = {keep_line, why[i], GP_LEVEL_ERROR};
        if (open_system(&quiet, systems[i], out) == GP_OK)
            return GP_OK;
    }
    return gp_fail_at(log, GP_ERR_GL, "layer.gl.none", "no GL context: %s; %s",
                      why[0], why[1]);
}

void gp_gl_close(struct gp_gl **gl)
{
    struct gp_gl *g = *gl;
    if (!g)
        return;
    if (g->window) {
        if (g->vertex_array && gp_gl_reach(g)) {
            g->f.DeleteVertexArrays(1, &g->vertex_array);
            g->f.DeleteQueries(1, &g->query); // GL ignores name 0
        }
        if (current == g)
            release_current();
        g->system->close(g->window);
    }
    GP_FREE(*gl);
}

/* -- asking a context ------------------------------------------------------ */

const struct gp_gl_info *gp_gl_info(const struct gp_gl *gl)
{
    return &gl->info;
}

gp_status gp_gl_check(const struct gp_log *log, const struct gp_gl *gl,
                      const char *what)
{
    enum { FLAGS = 16 }; // a lost context answers for ever
#define NAMED(flag) {flag, #flag}
    static const struct { GLenum flag; const char *name; } names[] = {
        NAMED(GL_INVALID_ENUM), NAMED(GL_INVALID_VALUE),
        NAMED(GL_INVALID_OPERATION), NAMED(GL_INVALID_FRAMEBUFFER_OPERATION),
        NAMED(GL_OUT_OF_MEMORY), NAMED(GL_CONTEXT_LOST),
    };
#undef NAMED
    const GLenum first = gl->f.GetError();
    if (first == GL_NO_ERROR)
        return GP_OK;
    const char *name = "an unknown GL error";
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        name = names[i].flag == first ? names[i].name : name;
    for (int i = 0; i < FLAGS && gl->f.GetError() != GL_NO_ERROR; i++)
        continue;
    return gp_fail_at(log, GP_ERR_GL, "layer.engine", "%s: %s while %s",
                      gl->info.name, name, what);
}
