/* The libraries that give headless contexts: OSMesa, Mesa's off-screen library,
 * a rasterizer on the CPU that needs no display, no device and no driver; and
 * EGL without a window, on a GPU through the device platform, or on Mesa's
 * surfaceless platform. */
#include "core/memory.h"
#include "gl/gl_priv.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>
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
        GP_TRY(gp_fail(log, GP_ERR_GL,                                        \
                       "OSMesa: " symbol " is missing; OSMesa 11.2 or newer " \
                       "is needed (Debian package libosmesa6), or use --gl " \
                       "egl"))
    LOAD(create, "OSMesaCreateContextAttribs");
    LOAD(make_current, "OSMesaMakeCurrent");
    LOAD(destroy, "OSMesaDestroyContext");
    LOAD(proc, "OSMesaGetProcAddress");
#undef LOAD
    o->context = o->create(core, NULL);
    if (!o->context)
        o->context = o->create(any, NULL);
    if (!o->context)
        GP_TRY(gp_fail(log, GP_ERR_GL,
                       "OSMesa: cannot make a context (neither 4.5 core nor "
                       "any other); install the Debian package libosmesa6, or "
                       "use --gl egl"));
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
    .env = "GLAREPP_OSMESA",
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

/* Returns true when `name` is a whole word of `list`: names may begin one
 * another. */
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
        return gp_fail(log, GP_ERR_GL,
                       "EGL: no platform extensions (needs EGL 1.5 or "
                       "EGL_EXT_platform_base); install the Debian package "
                       "libegl-mesa0, or use --gl osmesa");
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
    return gp_fail(log, GP_ERR_GL,
                   "EGL: cannot make a context, neither on a GPU device nor on "
                   "Mesa's surfaceless platform; install the Debian packages "
                   "libegl-mesa0 and libgl1-mesa-dri, or use --gl osmesa");
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
        GP_TRY(gp_fail(log, GP_ERR_GL,                                        \
                       "EGL: " name " is missing; install the Debian "        \
                       "packages libegl1 and libegl-mesa0, or use --gl "     \
                       "osmesa"));
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
    .env = "GLAREPP_EGL",
    .package = "libegl1 (and libegl-mesa0)",
    .file = (const char *const[]) {"libEGL.so.1", "libEGL.so", NULL},
    .open = open_egl,
    .make_current = egl_make_current,
    .release = egl_release,
    .close = close_egl,
    .proc = egl_proc,
};
