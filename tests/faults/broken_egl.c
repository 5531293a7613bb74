// SPDX-License-Identifier: Apache-2.0
/* EGL that breaks: the real one with some of its answers changed.
 * Give its path in GLAREPP_EGL, and in BROKEN_EGL what is to break:
 *
 *   client      no display: no platform extensions are known
 *   platform    eglGetPlatformDisplayEXT is not there
 *   surfaceless no display has the surfaceless platform, no device either
 *   device      the first device says that it is hardware, and has no display
 *   nameless    devices do not say what they are
 *   initialize  no display can be initialised
 *   contextless displays cannot do without a surface
 *   prefixed    they have an extension whose name only begins like it
 *   bind        desktop GL cannot be bound
 *   choose      configurations cannot be chosen
 *   config      there is no configuration
 *   core        no context of 4.5 core, but an older one
 *   context     no context at all
 *   current     it cannot be made current
 */
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

typedef void (*proc)(void);

static bool is(const char *what)
{
    const char *const broken = getenv("BROKEN_EGL");
    return broken && strcmp(broken, what) == 0;
}

static void *real(const char *name)
{
    static void *library;
    if (!library)
        library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    return library ? dlsym(library, name) : NULL;
}

/* The real function behind `name`, as the pointer it is used as. */
#define REAL(name) ((__typeof__(&name)) real(#name))

// -- displays --------------------------------------------------------------------

static EGLBoolean query_devices(EGLint most, EGLDeviceEXT *device,
                                EGLint *found)
{
    (void) most;
    device[0] = NULL;
    *found = 1;
    return EGL_TRUE;
}

static const char *device_string(EGLDeviceEXT device, EGLint name)
{
    (void) device;
    (void) name;
    return is("nameless") ? NULL : "EGL_EXT_device_drm";
}

static EGLDisplay platform_display(EGLenum platform, void *native,
                                   const EGLint *attributes)
{
    if (platform == EGL_PLATFORM_DEVICE_EXT)
        return EGL_NO_DISPLAY;
    return ((PFNEGLGETPLATFORMDISPLAYEXTPROC) REAL(eglGetProcAddress)(
        "eglGetPlatformDisplayEXT"))(platform, native, attributes);
}

EGLBoolean eglInitialize(EGLDisplay display, EGLint *major, EGLint *minor)
{
    return is("initialize") ? EGL_FALSE
                            : REAL(eglInitialize)(display, major, minor);
}

const char *eglQueryString(EGLDisplay display, EGLint name)
{
    if (display == EGL_NO_DISPLAY) {
        if (is("client"))
            return NULL;
        if (is("surfaceless"))
            return "EGL_EXT_platform_device EGL_EXT_platform_base";
        if (is("device") || is("nameless"))
            return "EGL_EXT_platform_device EGL_EXT_device_enumeration "
                   "EGL_MESA_platform_surfaceless";
    } else if (is("contextless")) {
        return "EGL_KHR_create_context";
    } else if (is("prefixed")) {
        return "EGL_KHR_surfaceless_context2 xEGL_KHR_surfaceless_context";
    }
    return REAL(eglQueryString)(display, name);
}

// -- contexts --------------------------------------------------------------------

EGLBoolean eglBindAPI(EGLenum api)
{
    return is("bind") ? EGL_FALSE : REAL(eglBindAPI)(api);
}

EGLBoolean eglChooseConfig(EGLDisplay display, const EGLint *attributes,
                           EGLConfig *config, EGLint room, EGLint *found)
{
    if (is("choose"))
        return EGL_FALSE;
    const EGLBoolean chosen = REAL(eglChooseConfig)(display, attributes,
                                                    config, room, found);
    if (is("config"))
        *found = 0;
    return chosen;
}

EGLContext eglCreateContext(EGLDisplay display, EGLConfig config,
                            EGLContext share, const EGLint *attributes)
{
    if (is("context") || (is("core") && attributes[0] != EGL_NONE))
        return EGL_NO_CONTEXT;
    return REAL(eglCreateContext)(display, config, share, attributes);
}

EGLBoolean eglDestroyContext(EGLDisplay display, EGLContext context)
{
    return REAL(eglDestroyContext)(display, context);
}

EGLBoolean eglMakeCurrent(EGLDisplay display, EGLSurface draw, EGLSurface read,
                          EGLContext context)
{
    if (context != EGL_NO_CONTEXT && is("current"))
        return EGL_FALSE;
    return REAL(eglMakeCurrent)(display, draw, read, context);
}

// -- functions -------------------------------------------------------------------

static const struct { const char *broken, *name; proc to; } changed[] = {
    {"platform", "eglGetPlatformDisplayEXT", NULL},
    {"device", "eglGetPlatformDisplayEXT", (proc) platform_display},
    {"device", "eglQueryDevicesEXT", (proc) query_devices},
    {"device", "eglQueryDeviceStringEXT", (proc) device_string},
    {"nameless", "eglQueryDevicesEXT", (proc) query_devices},
    {"nameless", "eglQueryDeviceStringEXT", (proc) device_string},
};

proc eglGetProcAddress(const char *name)
{
    for (size_t i = 0; i < sizeof changed / sizeof *changed; i++) {
        if (is(changed[i].broken) && strcmp(changed[i].name, name) == 0)
            return changed[i].to;
    }
    return REAL(eglGetProcAddress)(name);
}
