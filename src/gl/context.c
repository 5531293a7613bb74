// SPDX-License-Identifier: Apache-2.0
/* Contexts of OSMesa, Mesa's off-screen library, a rasterizer on the CPU that
 * needs no display, no device and no driver; and of EGL without a window, on a
 * GPU through the device platform, or on Mesa's surfaceless platform. */
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "gl/gl_priv.h"

#define EGL_EGLEXT_PROTOTYPES // for their types: nothing is linked
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A library that gives headless contexts. `file` lists its names, NULL ends, unless
 * gp_env() has another; `package` is Debian's. */
struct gp_gl_system {
    const char *name, *package;
    const char *const *file;
    // Makes a context, 4.5 core where that can be had, else of any version so
    // that the caller can say which one was found: sets proc, and window, which
    // is closed after an error too
    gp_status (*open)(const struct gp_log *log, void *library,
                      struct gp_gl *gl);
    // or no context at all; false: the system refused
    bool (*make_current)(void *window, bool on);
    void (*close)(void *window); // it is not current then
};

// -- OSMesa -------------------------------------------------------------------

/* From Mesa's GL/osmesa.h, which newer Mesa does not install. */
enum {
    OSMESA_RGBA = GL_RGBA,
    OSMESA_FORMAT = 0x22,
    OSMESA_PROFILE = 0x33,
    OSMESA_CORE_PROFILE = 0x34,
    OSMESA_CONTEXT_MAJOR_VERSION = 0x36,
    OSMESA_CONTEXT_MINOR_VERSION = 0x37,
};

struct osmesa {
    void *context;
    void *(*create)(const int *attributes, void *share);
    GLboolean (*make_current)(void *context, void *buffer, GLenum type,
                              GLsizei w, GLsizei h);
    void (*destroy)(void *context);
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
                             struct gp_gl *gl)
{
    static const int core[] = {OSMESA_FORMAT, OSMESA_RGBA,
                               OSMESA_PROFILE, OSMESA_CORE_PROFILE,
                               OSMESA_CONTEXT_MAJOR_VERSION, 4,
                               OSMESA_CONTEXT_MINOR_VERSION, 5, 0};
    static const int any[] = {OSMESA_FORMAT, OSMESA_RGBA, 0};
    struct osmesa *o;
    gp_status st = gp_alloc_zero(log, "OSMesa context", 1, sizeof *o, &o);
    gl->window = o;
    if (st)
        return st;
#define LOAD(field, symbol)                                            \
    *(void **) &(field) = dlsym(library, symbol);                      \
    if (!(field))                                                      \
    GP_TRY(gp_fail_at(log, GP_ERR_GL, "layer.gl.osmesa",               \
                      "OSMesa: " symbol " is missing; install OSMesa " \
                      "11.2 or newer (Debian package libosmesa6)"))
    LOAD(o->create, "OSMesaCreateContextAttribs");
    LOAD(o->make_current, "OSMesaMakeCurrent");
    LOAD(o->destroy, "OSMesaDestroyContext");
    LOAD(gl->proc, "OSMesaGetProcAddress");
#undef LOAD
    o->context = o->create(core, NULL);
    if (!o->context)
        o->context = o->create(any, NULL);
    if (!o->context)
        GP_TRY(gp_fail_at(log, GP_ERR_GL, "layer.gl.osmesa",
                          "OSMesa: cannot make a context (neither 4.5 core nor "
                          "any other); install the Debian package libosmesa6"));
out:
    return st;
}

static bool osmesa_make_current(void *window, bool on)
{
    struct osmesa *o = window;
    return on ? o->make_current(o->context, o->pixel, GL_UNSIGNED_BYTE, 1, 1)
              : o->make_current(NULL, NULL, 0, 0, 0);
}

static const struct gp_gl_system by_osmesa = {
    .name = "OSMesa",
    .package = "libosmesa6",
    .file = (const char *const[]) {"libOSMesa.so.8", "libOSMesa.so.6",
                                   "libOSMesa.so", NULL},
    .open = open_osmesa,
    .make_current = osmesa_make_current,
    .close = close_osmesa,
};

// -- EGL ----------------------------------------------------------------------

enum { MAX_DEVICES = 16 };

/* X(name without "egl"); those of extensions come by GetProcAddress, and may be
 * NULL. */
// clang-format off
#define EGL_FUNCTIONS(X)                                                      \
    X(BindAPI) X(ChooseConfig) X(CreateContext) X(DestroyContext)             \
    X(GetProcAddress) X(Initialize) X(MakeCurrent) X(QueryString)
#define EGL_EXTENSION_FUNCTIONS(X)                                            \
    X(GetPlatformDisplayEXT) X(QueryDevicesEXT) X(QueryDeviceStringEXT)
// clang-format on

struct egl {
#define FIELD(name) __typeof__(egl##name) *(name);
    EGL_FUNCTIONS(FIELD)
    EGL_EXTENSION_FUNCTIONS(FIELD)
#undef FIELD
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
    EGLConfig config;
    EGLint configs = 0;
    if (display == EGL_NO_DISPLAY || !e->Initialize(display, NULL, NULL) ||
        !has(e->QueryString(display, EGL_EXTENSIONS),
             "EGL_KHR_surfaceless_context") ||
        !e->BindAPI(EGL_OPENGL_API) ||
        !e->ChooseConfig(display, wanted, &config, 1, &configs) || configs < 1)
        return false;
    e->display = display;
    e->context = e->CreateContext(display, config, EGL_NO_CONTEXT, core);
    if (!e->context)
        e->context = e->CreateContext(display, config, EGL_NO_CONTEXT, any);
    return e->context != EGL_NO_CONTEXT;
}

static gp_status find_display(const struct gp_log *log, struct egl *e)
{
    const char *extensions = e->QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (!e->GetPlatformDisplayEXT || !extensions)
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
        !e->QueryDevicesEXT || !e->QueryDeviceStringEXT ||
        !e->QueryDevicesEXT(MAX_DEVICES, device, &devices))
        devices = 0;
    for (EGLint i = 0; i < devices; i++) {
        const char *text = e->QueryDeviceStringEXT(device[i], EGL_EXTENSIONS);
        if (text && !has(text, "EGL_MESA_device_software") &&
            try_display(e, e->GetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT,
                                                    device[i], NULL)))
            return GP_OK;
    }
    if (has(extensions, "EGL_MESA_platform_surfaceless") &&
        try_display(e, e->GetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA,
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
        e->DestroyContext(e->display, e->context);
    gp_free(e);
}

static gp_status open_egl(const struct gp_log *log, void *library,
                          struct gp_gl *gl)
{
    struct egl *e;
    gp_status st = gp_alloc_zero(log, "EGL context", 1, sizeof *e, &e);
    gl->window = e;
    if (st)
        return st;
#define LOAD(name)                                                            \
    e->name = (__typeof__(egl##name) *) dlsym(library, "egl" #name);          \
    if (!e->name)                                                             \
        GP_TRY(gp_fail_at(log, GP_ERR_GL, "layer.gl.egl",                     \
                          "EGL: egl" #name " is missing; install the Debian " \
                          "packages libegl1 and libegl-mesa0"));
    EGL_FUNCTIONS(LOAD)
#undef LOAD
#define FIND(name) \
    e->name = (__typeof__(egl##name) *) e->GetProcAddress("egl" #name);
    EGL_EXTENSION_FUNCTIONS(FIND)
#undef FIND
    gl->proc = e->GetProcAddress;
    st = find_display(log, e);
out:
    return st;
}

static bool egl_make_current(void *window, bool on)
{
    struct egl *e = window;
    return e->BindAPI(EGL_OPENGL_API) &&
           e->MakeCurrent(e->display, EGL_NO_SURFACE, EGL_NO_SURFACE,
                          on ? e->context : EGL_NO_CONTEXT);
}

static const struct gp_gl_system by_egl = {
    .name = "EGL",
    .package = "libegl1 (and libegl-mesa0)",
    .file = (const char *const[]) {"libEGL.so.1", "libEGL.so", NULL},
    .open = open_egl,
    .make_current = egl_make_current,
    .close = close_egl,
};

enum { LINE_BYTES = 512 }; // of a message

static _Thread_local const struct gp_gl *current;

/* Opens the system's library, or the file that the environment names. */
static gp_status open_library(const struct gp_log *log,
                              const struct gp_gl_system *system, void **out)
{
    const struct gp_env *const env = gp_env();
    const char *const forced = system == &by_osmesa ? env->osmesa : env->egl;
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
        (void) current->system->make_current(current->window, false);
    current = NULL;
}

gp_status gp_gl_use(const struct gp_log *log, const struct gp_gl *gl)
{
    if (current == gl)
        return GP_OK;
    // Mesa's two front ends share one dispatch table: release the old context
    // before the new one is made current, or a later return to it is missed
    release_current();
    if (!gl->system->make_current(gl->window, true))
        return gp_fail_at(log, GP_ERR_GL, "layer.gl",
                          "%s: the context cannot be made current",
                          gl->system->name);
    current = gl;
    return GP_OK;
}

/* -- opening --------------------------------------------------------------- */

/* Refuses a GL under 4.5 or of no version; sets the name in messages. */
static gp_status check_version(const struct gp_log *log, struct gp_gl *gl)
{
    PFNGLGETSTRINGPROC get = (PFNGLGETSTRINGPROC) gl->proc("glGetString");
    if (!get)
        return gp_fail_at(log, GP_ERR_GL, "layer.engine",
                          "%s: glGetString is missing; install a complete "
                          "Mesa", gl->system->name);
    const char *version = (const char *) get(GL_VERSION);
    const char *renderer = (const char *) get(GL_RENDERER);
    // "4.5 (Core Profile) Mesa 22.3.6"
    char *dot = NULL;
    const long major = version ? strtol(version, &dot, 10) : 0;
    const long minor = dot && *dot == '.' ? strtol(dot + 1, NULL, 10) : 0;
    if (major < 4 || (major == 4 && minor < 5))
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
    GP_TRY(system->open(log, library, gl));
    GP_TRY(gp_gl_use(log, gl));
    GP_TRY(check_version(log, gl));
#define LOAD(function)                                                       \
    gl->f.function = (__typeof__(gl##function) *) gl->proc("gl" #function);  \
    if (!gl->f.function)                                                     \
        GP_TRY(gp_fail_at(log, GP_ERR_GL, "layer.engine",                    \
                          "%s: gl" #function " is missing; install a newer " \
                          "Mesa or driver",                                  \
                          gl->info.name));
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

    // state for the context's whole life, other than GL's own: no dither, light
    // is added, rows of 16-bit codes are packed
    f->CreateVertexArrays(1, &gl->vertex_array);
    f->BindVertexArray(gl->vertex_array);
    f->Disable(GL_DITHER);
    f->BlendFunc(GL_ONE, GL_ONE);
    f->PixelStorei(GL_UNPACK_ALIGNMENT, 2);
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
    const struct gp_gl_system *const systems[] = {&by_osmesa, &by_egl};
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
        if (g->vertex_array && gp_gl_use(NULL, g) == GP_OK) {
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
