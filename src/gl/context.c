#include "gl/context.h"

#include "core/memory.h"
#include "core/parallel.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GL_NEED = 45 }; // OpenGL 4.5, as 10 * major + minor

static _Thread_local const struct gp_gl *current;

/* What dlerror() says, without the name that the caller prints already. */
static void dl_reason(const char *name, char *why, size_t size)
{
    const char *text = dlerror();
    size_t n = strlen(name);
    if (text && strncmp(text, name, n) == 0 && text[n] == ':')
        text += n + 2;
    snprintf(why, size, "%s", text ? text : "no reason given");
}

void *gp_gl_library(const struct gp_log *log, const char *env,
                    const char *const name[], const char *package)
{
    const char *forced = getenv(env);
    const char *const only[] = {forced, NULL};
    const char *const *list = forced && *forced ? only : name;
    char why[256] = "";
    for (const char *const *n = list; *n; n++) {
        void *library = dlopen(*n, RTLD_NOW | RTLD_LOCAL);
        if (library)
            return library;
        if (n == list) // the first is the one that should be there
            dl_reason(*n, why, sizeof why);
    }
    (void) gp_fail(log, GP_ERR_GL,
                   "%s: the library does not open (%s); install the Debian "
                   "package %s, or take --engine fft", list[0], why, package);
    return NULL;
}

/* -- making a context current --------------------------------------------- */

static void let_go(void)
{
    if (current)
        current->system->release(current->window);
    current = NULL;
}

gp_status gp_gl_use(const struct gp_log *log, const struct gp_gl *gl)
{
    if (current == gl)
        return GP_OK;
    // Mesa's two front ends share one dispatch table: the old context must
    // go before the new one comes, or a later return to it is not noticed
    let_go();
    if (!gl->system->make_current(gl->window))
        return gp_fail(log, GP_ERR_GL,
                       "%s: the context cannot be made current; take the "
                       "other of --gl osmesa|egl, or --engine fft",
                       gl->system->name);
    current = gl;
    return GP_OK;
}

bool gp_gl_reach(const struct gp_gl *gl)
{
    return gp_gl_use(NULL, gl) == GP_OK;
}

/* -- opening --------------------------------------------------------------- */

/* 10 * major + minor of "4.5 (Core Profile) Mesa 22.3.6"; 0 when unreadable. */
static int version_of(const char *text)
{
    char *dot, *end;
    if (!text)
        return 0;
    const long major = strtol(text, &dot, 10);
    if (major < 1 || major > 99 || *dot != '.')
        return 0;
    const long minor = strtol(dot + 1, &end, 10);
    return end == dot + 1 || minor < 0 || minor > 9 ? 0
                                                    : (int) (major * 10 + minor);
}

static gp_status check_version(const struct gp_log *log, struct gp_gl *gl)
{
    PFNGLGETSTRINGPROC get =
        (PFNGLGETSTRINGPROC) gl->system->proc(gl->window, "glGetString");
    if (!get)
        return gp_fail(log, GP_ERR_GL,
                       "%s: glGetString is missing; install a whole Mesa, or "
                       "take --engine fft", gl->system->name);
    const char *version = (const char *) get(GL_VERSION);
    const char *renderer = (const char *) get(GL_RENDERER);
    if (version_of(version) < GL_NEED)
        return gp_fail(log, GP_ERR_GL,
                       "%s: OpenGL 4.5 is needed (%s found); install a newer "
                       "Mesa or driver, or take --engine fft",
                       gl->system->name, version ? version : "nothing");
    snprintf(gl->name, sizeof gl->name, "%s: %s", gl->system->name,
             renderer ? renderer : "unnamed renderer");
    gl->software = strstr(gl->name, "llvmpipe") ||
                   strstr(gl->name, "softpipe") || strstr(gl->name, "swrast") ||
                   strstr(gl->name, "SwiftShader");
    return GP_OK;
}

static gp_status load_functions(const struct gp_log *log, struct gp_gl *gl)
{
#define LOAD(type, function)                                                  \
    gl->f.function = (type) gl->system->proc(gl->window, "gl" #function);     \
    if (!gl->f.function)                                                      \
        return gp_fail(log, GP_ERR_GL,                                        \
                       "%s: gl" #function " is missing; install a newer "     \
                       "Mesa or driver, or take --engine fft", gl->name);
    GP_GL_FUNCTIONS(LOAD)
#undef LOAD
    return GP_OK;
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

static void find_limits(struct gp_gl *gl)
{
    GLint texture = 0, viewport[2] = {0};
    gl->f.GetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
    gl->f.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    gl->max_size = least(texture, least(viewport[0], viewport[1]));
    const char *lower = getenv("GLAREPP_GL_MAX_SIZE");
    long asked = lower ? strtol(lower, NULL, 10) : 0;
    if (asked > 0 && asked < gl->max_size)
        gl->max_size = (int) asked;

    GLfloat point[2] = {0};
    gl->f.GetFloatv(GL_POINT_SIZE_RANGE, point);
    gl->max_point = point[1];
    gl->f.GetIntegerv(GL_MAX_UNIFORM_BLOCK_SIZE, &gl->max_block);
    gl->f.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &gl->max_list);
}

/* State that holds for the context's whole life: what this program draws has
 * neither depth nor dither, and its rows are packed. */
static void set_up(struct gp_gl *gl)
{
    gl->f.CreateVertexArrays(1, &gl->vertex_array);
    gl->f.BindVertexArray(gl->vertex_array);
    gl->f.Disable(GL_DITHER);
    gl->f.Disable(GL_DEPTH_TEST);
    gl->f.Disable(GL_CULL_FACE);
    gl->f.BlendFunc(GL_ONE, GL_ONE);
    gl->f.PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl->f.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
}

static bool threads_are_ours; // LP_NUM_THREADS is not the user's

void gp_gl_prepare(void)
{
    char threads[16];
    snprintf(threads, sizeof threads, "%d", gp_threads());
    if (!getenv("LP_NUM_THREADS"))
        threads_are_ours = setenv("LP_NUM_THREADS", threads, 1) == 0;
    setenv("EGL_LOG_LEVEL", "fatal", 0); // Mesa's warnings go to stderr
}

/* The CPU rasterizer starts as many threads as the machine has processors;
 * --threads, and a process that may use only some, count here too. It waits
 * for ever for one that could not start, and with 0 draws on its caller's. */
static void limit_threads(void)
{
    char threads[16];
    const int n = gp_threads();
    snprintf(threads, sizeof threads, "%d", gp_threads_spare(n) < n ? 0 : n);
    if (threads_are_ours)
        setenv("LP_NUM_THREADS", threads, 1); // in its place: nothing moves
}

static gp_status open_system(const struct gp_log *log,
                             const struct gp_gl_system *system,
                             struct gp_gl **out)
{
    void *block;
    gp_status st = gp_alloc_zero(log, "GL context", 1, sizeof **out, &block);
    if (st)
        return st;
    struct gp_gl *gl = block;
    gl->system = system;
    limit_threads();
    GP_TRY(system->open(log, &gl->window));
    GP_TRY(gp_gl_use(log, gl));
    GP_TRY(check_version(log, gl));
    GP_TRY(load_functions(log, gl));
    find_limits(gl);
    set_up(gl);
    GP_TRY(gp_gl_check(log, gl, "setting up the context"));
    *out = gl;
    return GP_OK;
out:
    gp_gl_close(&gl);
    return st;
}

struct capture {
    char line[512];
};

static void keep_line(void *user, enum gp_level level, const char *line)
{
    struct capture *c = user;
    (void) level;
    snprintf(c->line, sizeof c->line, "%s", line);
}

/* Only when both systems fail is there an error, with both reasons. */
static gp_status open_any(const struct gp_log *log, struct gp_gl **out)
{
    struct capture why[2] = {{""}, {""}};
    const struct gp_gl_system *const systems[] = {&gp_gl_osmesa, &gp_gl_egl};
    for (int i = 0; i < 2; i++) {
        struct gp_log quiet = {keep_line, &why[i], GP_LEVEL_ERROR};
        if (open_system(&quiet, systems[i], out) == GP_OK)
            return GP_OK;
    }
    return gp_fail(log, GP_ERR_GL, "no GL context: %s; %s",
                   why[0].line, why[1].line);
}

gp_status gp_gl_open(const struct gp_log *log, enum gp_gl_api api,
                     struct gp_gl **out)
{
    switch (api) {
    case GP_GL_API_OSMESA:
        return open_system(log, &gp_gl_osmesa, out);
    case GP_GL_API_EGL:
        return open_system(log, &gp_gl_egl, out);
    case GP_GL_API_AUTO:
        break;
    }
    return open_any(log, out);
}

void gp_gl_close(struct gp_gl **gl)
{
    struct gp_gl *g = *gl;
    if (!g)
        return;
    if (g->window) {
        if (g->vertex_array && gp_gl_reach(g))
            g->f.DeleteVertexArrays(1, &g->vertex_array);
        if (current == g)
            let_go();
        g->system->close(g->window);
    }
    GP_FREE(*gl);
}

/* -- asking a context ------------------------------------------------------ */

const char *gp_gl_name(const struct gp_gl *gl)
{
    return gl->name;
}

bool gp_gl_is_software(const struct gp_gl *gl)
{
    return gl->software;
}

int gp_gl_max_size(const struct gp_gl *gl)
{
    return gl->max_size;
}

float gp_gl_point_size_max(const struct gp_gl *gl)
{
    return gl->max_point;
}

int gp_gl_block_max(const struct gp_gl *gl)
{
    return gl->max_block;
}

int gp_gl_list_max(const struct gp_gl *gl)
{
    return gl->max_list;
}

static const char *error_name(GLenum error)
{
    switch (error) {
    case GL_INVALID_ENUM:
        return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
        return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
        return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
        return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY:
        return "GL_OUT_OF_MEMORY";
    case GL_CONTEXT_LOST:
        return "GL_CONTEXT_LOST";
    default:
        return "an unknown GL error";
    }
}

gp_status gp_gl_check(const struct gp_log *log, const struct gp_gl *gl,
                      const char *what)
{
    enum { FLAGS = 16 }; // a lost context answers for ever
    GLenum first = gl->f.GetError();
    if (first == GL_NO_ERROR)
        return GP_OK;
    for (int i = 0; i < FLAGS && gl->f.GetError() != GL_NO_ERROR; i++)
        continue;
    return gp_fail(log, GP_ERR_GL, "%s: %s while %s; take --engine fft",
                   gl->name, error_name(first), what);
}
