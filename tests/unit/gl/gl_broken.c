// SPDX-License-Identifier: Apache-2.0
/* gl with libraries and drivers that refuse: each call that can fail does so
 * once, with one line that says which, and nothing stays open. The libraries
 * are tests/faults/broken_gl.c and broken_egl.c. */
#include "unit.h"
#include "core/memory.h"
#include "fail.h"
#include "gl_open.h"

#include <limits.h>
#include <unistd.h>

static void assert_line(const char *row, const char *part)
{
    if (kept_errors != 1 || !strstr(kept_line, part))
        fail_msg("%s: %d lines; \"%s\" is not in \"%s\"", row, kept_errors,
                 part, kept_line);
    kept_clear();
}

/* Opens `api`; a context is closed again. */
static gp_status try_open(enum gp_gl_api api)
{
    struct gp_gl *gl = NULL;
    kept_clear();
    const gp_status st = gp_gl_open(&kept_log, api, &gl);
    assert_true((st == GP_OK) == (gl != NULL));
    gp_gl_close(&gl);
    return st;
}

/* Takes a library that breaks, beside this program, in place of the real one;
 * skips the test where that does not work while it does not break. */
static void use_broken(enum gp_gl_api api, const char *env, const char *file)
{
    char path[PATH_MAX];
    const ssize_t n = readlink("/proc/self/exe", path, sizeof path - 1);
    assert_true(n > 0);
    path[n] = '\0';
    char *const slash = strrchr(path, '/');
    assert_true(slash && (size_t) (slash - path) + strlen(file) + 2 <
                             sizeof path);
    strcpy(slash + 1, file);
    set_env(env, path);
    if (try_open(api) != GP_OK) {
        print_message("%s\n", kept_line);
        set_env(env, NULL);
        skip_for("no GL");
    }
}

// -- systems ------------------------------------------------------------------

/* A break, and the line that says so; NULL: a context all the same. */
struct broken {
    const char *what, *text;
};

static void refuse(enum gp_gl_api api, const char *variable,
                   const struct broken *rows, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        setenv(variable, rows[i].what, 1);
        const gp_status st = try_open(api);
        if (rows[i].text || st != GP_OK) {
            assert_int_equal(st, GP_ERR_GL);
            // Mesa's older contexts are of a version that may be enough, or not
            assert_true(rows[i].text || strcmp(rows[i].what, "core") == 0);
            assert_line(rows[i].what,
                        rows[i].text ? rows[i].text : "needs OpenGL 4.5");
        }
        unsetenv(variable);
    }
    assert_ok(try_open(api));
}

static void osmesa_refuses(void **state)
{
    static const struct broken rows[] = {
        {"context", "cannot make a context"},
        {"current", "cannot be made current"}, {"old", "4.5 (found 2.1 Mesa)"},
        {"words", "4.5 (found no number)"}, {"silent", "4.5 (found nothing)"},
        {"core", NULL}, {"unnamed", NULL},
    };
    use_broken(GP_GL_OSMESA, "GLAREPP_OSMESA", "broken_gl.so");
    refuse(GP_GL_OSMESA, "BROKEN_GL", rows, COUNT(rows));
    set_env("GLAREPP_OSMESA", NULL);
}

static void missing_functions_are_named(void **state)
{
#define NAME(function) "gl" #function,
    static const char *const names[] = {"glGetString", GP_GL_FUNCTIONS(NAME)};
#undef NAME
    use_broken(GP_GL_OSMESA, "GLAREPP_OSMESA", "broken_gl.so");
    for (size_t i = 0; i < COUNT(names); i++) {
        char text[96];
        snprintf(text, sizeof text, "%s is missing", names[i]);
        setenv("BROKEN_GL_MISSING", names[i], 1);
        assert_int_equal(try_open(GP_GL_OSMESA), GP_ERR_GL);
        assert_line(names[i], text);
    }
    unsetenv("BROKEN_GL_MISSING");
    set_env("GLAREPP_OSMESA", NULL);
}

static void egl_refuses(void **state)
{
    static const char none[] = "neither on a GPU device nor";
    static const struct broken rows[] = {
        {"client", "no platform extensions"},
        {"platform", "no platform extensions"},
        {"surfaceless", none}, {"initialize", none}, {"contextless", none},
        {"prefixed", none}, {"bind", none}, {"choose", none},
        {"config", none}, {"context", none},
        {"current", "cannot be made current"},
        {"device", NULL}, {"nameless", NULL}, {"core", NULL},
    };
    use_broken(GP_GL_EGL, "GLAREPP_EGL", "broken_egl.so");
    refuse(GP_GL_EGL, "BROKEN_EGL", rows, COUNT(rows));
    set_env("GLAREPP_EGL", NULL);
}

// -- a driver's answers -------------------------------------------------------

static GLenum flag; // result of glGetError()
static int times;   // so many times, then that all is well

static GLenum APIENTRY broken_error(void)
{
    return times-- > 0 ? flag : GL_NO_ERROR;
}

static GLenum APIENTRY broken_framebuffer(GLuint framebuffer, GLenum target)
{
    (void) framebuffer;
    (void) target;
    return GL_FRAMEBUFFER_UNSUPPORTED;
}

static void flags_have_names(void **state)
{
    static const struct { GLenum flag; const char *name; } rows[] = {
        {GL_INVALID_ENUM, "GL_INVALID_ENUM"},
        {GL_INVALID_VALUE, "GL_INVALID_VALUE"},
        {GL_INVALID_OPERATION, "GL_INVALID_OPERATION"},
        {GL_INVALID_FRAMEBUFFER_OPERATION, "GL_INVALID_FRAMEBUFFER_OPERATION"},
        {GL_OUT_OF_MEMORY, "GL_OUT_OF_MEMORY"},
        {GL_CONTEXT_LOST, "GL_CONTEXT_LOST"}, {0x1234, "an unknown GL error"},
    };
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    const PFNGLGETERRORPROC real = gl->f.GetError;
    gl->f.GetError = broken_error;
    for (size_t i = 0; i < COUNT(rows); i++) {
        flag = rows[i].flag;
        times = INT_MAX; // a lost context answers for ever
        assert_int_equal(gp_gl_check(&kept_log, gl, "looking"), GP_ERR_GL);
        assert_line(rows[i].name, rows[i].name);
        assert_true(times > INT_MAX - 64);
        times = 2; // flags of two calls are cleared at once
        assert_int_equal(gp_gl_check(&kept_log, gl, "looking"), GP_ERR_GL);
        assert_line(rows[i].name, "while looking");
        assert_ok(gp_gl_check(&kept_log, gl, "looking"));
    }
    gl->f.GetError = real;
    gp_gl_close(&gl);
}

/* An object that cannot be made is empty, and the next one can be. */
static void objects_are_refused(void **state)
{
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    for (int broken = 1; broken >= 0; broken--) {
        struct gp_texture t = {0};
        struct gp_target g = {0};
        struct gp_buffer l = {0}, b = {0};
        struct gp_program p = {0};
        const gp_status want = broken ? GP_ERR_GL : GP_OK;
#define MAKES(call)                                                           \
        fail_at(broken ? FAIL_GL : FAIL_NONE, 1);                             \
        assert_int_equal(call, want);                                         \
        assert_int_equal(fail_end(), broken);                                 \
        if (broken)                                                           \
            assert_line(#call, "GL_OUT_OF_MEMORY")
        MAKES(gp_texture_make(&kept_log, gl, "a", GP_TEXEL_FLOAT, 2, 2, &t));
        MAKES(gp_target_make(&kept_log, gl, "b", GP_TEXEL_FLOAT, 1, 2, 2, &g));
        MAKES(gp_buffer_make(&kept_log, gl, "c", GP_BUFFER_TEXELS, 2, &l));
        MAKES(gp_buffer_make(&kept_log, gl, "d", GP_BUFFER_BLOCK, 1, &b));
        MAKES(gp_program_make(&kept_log, gl, "", "add.vert", "add.frag", &p));
#undef MAKES
        assert_true((t.id && g.framebuffer && l.id && l.texture.id && b.id &&
                     p.id) == !broken);
        assert_true((t.id || g.framebuffer || g.colour.id || l.id ||
                     l.texture.id || b.id || p.id) == !broken);
        gp_texture_free(gl, &t);
        gp_target_free(gl, &g);
        gp_buffer_free(gl, &l);
        gp_buffer_free(gl, &b);
        gp_program_free(gl, &p);
    }
    gp_gl_close(&gl);
}

static void targets_are_refused(void **state)
{
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    const PFNGLCHECKNAMEDFRAMEBUFFERSTATUSPROC check =
        gl->f.CheckNamedFramebufferStatus;
    struct gp_target t = {0};
    gl->f.CheckNamedFramebufferStatus = broken_framebuffer;
    assert_int_equal(gp_target_make(&kept_log, gl, "layer", GP_TEXEL_FLOAT, 1,
        2, 2, &t), GP_ERR_GL);
    assert_line("unsupported", "0x8cdd");
    gl->f.CheckNamedFramebufferStatus = check;
    // a byte target that memory cannot hold
    fail_at(FAIL_GL, 1);
    assert_int_equal(gp_target_make(&kept_log, gl, "layer", GP_TEXEL_BYTE, 1, 2,
        2, &t), GP_ERR_GL);
    assert_line("byte", "GL_OUT_OF_MEMORY");
    assert_true(fail_end());
    assert_int_equal(t.framebuffer, 0);
    assert_ok(
        gp_target_make(&kept_log, gl, "layer", GP_TEXEL_FLOAT, 4, 2, 2, &t));
    const struct gp_rect nothing = {5, 5, 9, 9}; // outside: nothing to do
    gp_target_clear(gl, &t, nothing);
    assert_ok(gp_gl_check(&kept_log, gl, "clearing"));
    gp_target_free(gl, &t);
    gp_gl_close(&gl);
}

SUITE_OF(gl_broken, NULL, NULL,
    osmesa_refuses, missing_functions_are_named, egl_refuses, flags_have_names,
    objects_are_refused, targets_are_refused)
