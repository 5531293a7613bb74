/* gl: contexts open, fail with words, live side by side; textures come back
 * bit for bit; what is too large or wrong is named. */
#include "unit.h"
#include "gl_open.h"

#include "gl/gl.h"

#include <sys/wait.h>
#include <unistd.h>

static const enum gp_gl_api apis[] = {GP_GL_OSMESA, GP_GL_EGL,
                                      GP_GL_AUTO};

static void opens_and_closes(void **state)
{
    for (int i = 0; i < 9; i++) {
        struct gp_gl *gl = open_or_skip(apis[i % 3]);
        assert_non_null(strstr(gp_gl_info(gl)->name, ": "));
        assert_true(gp_gl_info(gl)->max_size >= 4096);
        if (strstr(gp_gl_info(gl)->name, "llvmpipe"))
            assert_true(gp_gl_info(gl)->software);
        gp_gl_close(&gl);
        assert_null(gl);
        gp_gl_close(&gl);
    }
}

static void missing_library_is_named(void **state)
{
    static const struct {
        enum gp_gl_api api;
        const char *env, *package;
    } rows[] = {
        {GP_GL_OSMESA, "GLAREPP_OSMESA", "libosmesa6"},
        {GP_GL_EGL, "GLAREPP_EGL", "libegl1"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_gl *gl = NULL;
        setenv(rows[i].env, "/nonexistent/lib.so", 1);
        assert_int_equal(gp_gl_open(&log_kept, rows[i].api, &gl), GP_ERR_GL);
        assert_null(gl);
        assert_said("/nonexistent/lib.so");
        assert_said(rows[i].package);
        unsetenv(rows[i].env);
    }
}

static void auto_falls_back(void **state)
{
    struct gp_gl *gl = open_or_skip(GP_GL_EGL);
    gp_gl_close(&gl);
    setenv("GLAREPP_OSMESA", "/nonexistent/lib.so", 1);
    assert_ok(gp_gl_open(&log_kept, GP_GL_AUTO, &gl));
    assert_ptr_equal(strstr(gp_gl_info(gl)->name, "EGL: "),
                     gp_gl_info(gl)->name);
    gp_gl_close(&gl);
    setenv("GLAREPP_EGL", "/nonexistent/lib.so", 1);
    assert_int_equal(gp_gl_open(&log_kept, GP_GL_AUTO, &gl), GP_ERR_GL);
    assert_said("libosmesa6");
    assert_said("libegl1");
    unsetenv("GLAREPP_OSMESA");
    unsetenv("GLAREPP_EGL");
}

/* A library that is there but is not what it should be. */
static void wrong_library_fails(void **state)
{
    struct gp_gl *gl = NULL;
    setenv("GLAREPP_OSMESA", "libm.so.6", 1);
    assert_int_equal(gp_gl_open(&log_kept, GP_GL_OSMESA, &gl), GP_ERR_GL);
    assert_said("OSMesaCreateContextAttribs");
    unsetenv("GLAREPP_OSMESA");
    setenv("GLAREPP_EGL", "libm.so.6", 1);
    assert_int_equal(gp_gl_open(&log_kept, GP_GL_EGL, &gl), GP_ERR_GL);
    assert_said("eglBindAPI");
    unsetenv("GLAREPP_EGL");
    assert_null(gl);
}

/* Exit status of a child: 0 the line names 3.x, 1 it does not, 77 the driver
 * is not Mesa, or is not there. */
static int open_as_33(enum gp_gl_api api)
{
    struct gp_gl *gl = NULL;
    setenv("MESA_GL_VERSION_OVERRIDE", "3.3", 1);
    gp_status st = gp_gl_open(&log_kept, api, &gl);
    if (strstr(last_line, "does not open"))
        return 77;
    return st == GP_ERR_GL && !gl && strstr(last_line, "4.5 is needed (3.")
               ? 0 : gl && !gp_gl_info(gl)->software ? 77 : 1;
}

/* Mesa can be told to be older than it is, but hears it only once. */
static void old_version_is_named(void **state)
{
    if (getenv("GLAREPP_TEST_QUICK")) // valgrind changes the child's status
        skip();
    for (int i = 0; i < 2; i++) {
        int status = 0;
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0)
            _exit(open_as_33(apis[i]));
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFEXITED(status));
        if (WEXITSTATUS(status) != 77)
            assert_int_equal(WEXITSTATUS(status), 0);
    }
}

static void limit_can_only_be_lowered(void **state)
{
    setenv("GLAREPP_GL_MAX_SIZE", "16", 1);
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    unsetenv("GLAREPP_GL_MAX_SIZE");
    assert_int_equal(gp_gl_info(gl)->max_size, 16);
    static const struct {
        int w, h;
        gp_status want;
    } rows[] = {
        {16, 16, GP_OK}, {1, 1, GP_OK}, {17, 1, GP_ERR_GL},
        {1, 17, GP_ERR_GL}, {0, 1, GP_ERR_GL}, {1, -1, GP_ERR_GL},
    };
    static const char *const others[] = {"", "none", "-5", "0", "999999999"};
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_texture t = {0};
        struct gp_target g = {0};
        last_line[0] = '\0';
        assert_int_equal(gp_texture_make(&log_kept, gl, "kernel",
                                         GP_TEXEL_FLOAT, rows[i].w, rows[i].h,
                                         &t),
                         rows[i].want);
        assert_int_equal(gp_target_make(&log_kept, gl, "layer", GP_TEXEL_FLOAT,
                                        1, rows[i].w, rows[i].h, &g),
                         rows[i].want);
        if (rows[i].want)
            assert_said("16x16 is the limit");
        gp_texture_free(gl, &t);
        gp_texture_free(gl, &t);
        gp_target_free(gl, &g);
        gp_target_free(gl, &g);
    }
    gp_gl_close(&gl);
    gl = open_or_skip(GP_GL_AUTO);
    const int most = gp_gl_info(gl)->max_size;
    gp_gl_close(&gl);
    for (size_t i = 0; i < COUNT(others); i++) { // no number, or over it
        setenv("GLAREPP_GL_MAX_SIZE", others[i], 1);
        gl = open_or_skip(GP_GL_AUTO);
        unsetenv("GLAREPP_GL_MAX_SIZE");
        assert_int_equal(gp_gl_info(gl)->max_size, most);
        gp_gl_close(&gl);
    }
}

/* -- textures and draws ---------------------------------------------------- */

enum { W = 37, H = 23 };

static void fill(float *px, unsigned seed)
{
    static const float special[] = {0.0f,  -0.0f, 1e30f, -1e-30f,
                                    1e38f, 65504.0f, -7.5f, 0x1p-120f};
    for (int i = 0; i < 4 * W * H; i++) {
        seed = seed * 1664525u + 1013904223u;
        px[i] = seed >> 30 ? (float) (seed >> 8) * 0x1p-20f
                           : special[seed >> 8 & 7];
    }
}

static void add_twice(struct gp_gl *gl, const struct gp_program *p,
                      const struct gp_texture *from,
                      const struct gp_target *to)
{
    const struct gp_uniform uniform[] = {{.name = "addend", .texture = from},
                                         {0}};
    struct gp_draw draw = {.program = p, .target = to,
                           .cut = {-5, 3, W + 9, 11}, .uniform = uniform,
                           .vertices = 3, .instances = 1};
    assert_ok(gp_draw_run(&log_kept, gl, &draw));
    assert_ok(gp_draw_run(&log_kept, gl, &draw));
    draw.cut = (struct gp_rect) {W, 0, W + 4, H}; // wholly outside
    assert_ok(gp_draw_run(&log_kept, gl, &draw));
    const struct gp_uniform unknown[] = {{.name = "absent"}, {0}};
    draw.cut = (struct gp_rect) {0, 0, W, H};
    draw.uniform = unknown;
    assert_int_equal(gp_draw_run(&log_kept, gl, &draw), GP_ERR_BUG);
    assert_said("absent");
}

/* Rows 3 to 10 hold twice the texture, bit for bit; the others are clear. */
static void check_sum(const float *px, const float *got)
{
    for (int y = 0; y < H; y++) {
        for (int i = 4 * W * y; i < 4 * W * (y + 1); i++) {
            float want = y >= 3 && y < 11 ? px[i] + px[i] : 0.0f;
            if (got[i] != want)
                fail_msg("sample %d: %g, not %g", i, (double) got[i],
                         (double) want);
        }
    }
}

static void draw_in(struct gp_gl *gl)
{
    static float px[4 * W * H], got[4 * W * H];
    struct gp_program p = {0};
    struct gp_texture from = {0};
    struct gp_target to = {0};
    const struct gp_rect all = {0, 0, W, H};
    fill(px, 20071u);
    assert_ok(gp_gl_use(&log_kept, gl));
    assert_ok(gp_program_make(&log_kept, gl, "", "add.vert", "add.frag", &p));
    assert_ok(gp_texture_make(&log_kept, gl, "a", GP_TEXEL_FLOAT, W, H, &from));
    assert_ok(gp_target_make(&log_kept, gl, "b", GP_TEXEL_FLOAT, 1, W, H, &to));
    gp_texture_write(gl, &from, (struct gp_rect) {0, 0, W, 9}, px);
    gp_texture_write(gl, &from, (struct gp_rect) {0, 9, W, H}, px + 4 * W * 9);
    gp_target_clear(gl, &to, (struct gp_rect) {-9, -9, 999, 999});
    add_twice(gl, &p, &from, &to);
    gp_target_read(gl, &to, 0, all, got);
    check_sum(px, got);
    gp_target_clear(gl, &to, (struct gp_rect) {0, 3, W, 4});
    gp_target_read(gl, &to, 0, (struct gp_rect) {0, 3, W, 5}, got);
    for (int i = 0; i < 4 * W; i++) {
        assert_true(got[i] == 0.0f);
        assert_true(got[4 * W + i] == 2 * px[4 * W * 4 + i]);
    }
    assert_ok(gp_gl_check(&log_kept, gl, "test"));
    gp_program_free(gl, &p);
    gp_texture_free(gl, &from);
    gp_target_free(gl, &to);
}

/* Contexts of both systems, one after another and in turns. */
static void contexts_live_side_by_side(void **state)
{
    struct gp_gl *gl[4] = {NULL};
    for (int i = 0; i < 4; i++)
        gl[i] = open_or_skip(apis[i % 2]);
    for (int turn = 0; turn < 2; turn++) {
        for (int i = 0; i < 4; i++)
            draw_in(gl[i]);
    }
    gp_gl_close(&gl[1]); // the others must not notice
    gp_gl_close(&gl[2]);
    draw_in(gl[0]);
    draw_in(gl[3]);
    gp_gl_close(&gl[0]);
    gp_gl_close(&gl[3]);
}

static void errors_are_named_and_cleared(void **state)
{
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    struct gp_texture t = {0};
    const float px[4] = {0};
    assert_ok(gp_texture_make(&log_kept, gl, "a", GP_TEXEL_FLOAT, 1, 1, &t));
    gp_texture_write(gl, &t, (struct gp_rect) {0, 0, -1, 1}, px);
    gp_texture_write(gl, &t, (struct gp_rect) {5, 0, 6, 1}, px);
    assert_int_equal(gp_gl_check(&log_kept, gl, "writing"), GP_ERR_GL);
    assert_said("GL_INVALID_VALUE while writing");
    assert_ok(gp_gl_check(&log_kept, gl, "writing"));
    gp_texture_free(gl, &t);
    gp_gl_close(&gl);
}

static void blocks_and_lists_have_limits(void **state)
{
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    struct gp_uniform_block b = {0};
    struct gp_texel_buffer l = {0};
    assert_true(gp_gl_info(gl)->max_block >= 16384);
    assert_true(gp_gl_info(gl)->max_texel_buffer >= 65536);
    assert_int_equal(gp_uniform_block_make(&log_kept, gl, "a", 0, &b),
                     GP_ERR_GL);
    assert_int_equal(gp_uniform_block_make(&log_kept, gl, "a",
                                   (size_t) gp_gl_info(gl)->max_block + 1, &b),
                     GP_ERR_GL);
    assert_said("one uniform block");
    assert_int_equal(gp_texel_buffer_make(&log_kept, gl, "a", 0, &l),
                     GP_ERR_GL);
    assert_said("one buffer texture");
    assert_int_equal(b.id, 0);
    assert_int_equal(l.id, 0);
    assert_ok(gp_uniform_block_make(&log_kept, gl, "a", 16384, &b));
    assert_ok(gp_texel_buffer_make(&log_kept, gl, "a", 65536, &l));
    gp_uniform_block_free(gl, &b);
    gp_texel_buffer_free(gl, &l);
    gp_gl_close(&gl);
}

// old_version_is_named comes before any Mesa
SUITE_OF(gl, NULL, NULL,
    old_version_is_named, opens_and_closes, missing_library_is_named,
    auto_falls_back, wrong_library_fails, limit_can_only_be_lowered,
    contexts_live_side_by_side, errors_are_named_and_cleared,
    blocks_and_lists_have_limits)
