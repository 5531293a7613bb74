/* Contexts of OSMesa, Mesa's off-screen library: a rasterizer on the CPU that
 * needs no display, no device and no driver. */
#include "gl/gl_priv.h"

#include "core/memory.h"

#include <dlfcn.h>

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

static bool make_current(void *window)
{
    struct osmesa *o = window;
    return o->make_current(o->context, o->pixel, GL_UNSIGNED_BYTE, 1, 1);
}

static void release(void *window)
{
    struct osmesa *o = window;
    o->make_current(NULL, NULL, 0, 0, 0);
}

static void (*proc(void *window, const char *name))(void)
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
    .make_current = make_current,
    .release = release,
    .close = close_osmesa,
    .proc = proc,
};
