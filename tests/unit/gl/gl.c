// SPDX-License-Identifier: Apache-2.0
/* gl: contexts open, fail with words, live side by side; textures come back
 * bit for bit; what is too large or wrong is named; shaders' messages point at
 * their files; a draw sees what its list held. */
#include "unit.h"
#include "gl_open.h"

#include <sys/wait.h>
#include <unistd.h>

static const enum gp_gl_api apis[] = {GP_GL_OSMESA, GP_GL_EGL, GP_GL_AUTO};

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

/* A library that is not there, or is not what it should be. */
static void bad_libraries_are_named(void **state)
{
    static const struct {
        enum gp_gl_api api;
        const char *env, *library, *text[2];
    } rows[] = {
        {GP_GL_OSMESA, "GLAREPP_OSMESA", "/none/lib.so",
         {"/none/lib.so", "libosmesa6"}},
        {GP_GL_EGL, "GLAREPP_EGL", "/none/lib.so", {"/none/lib.so", "libegl1"}},
        {GP_GL_OSMESA, "GLAREPP_OSMESA", "libm.so.6",
         {"OSMesaCreateContextAttribs", "osmesa"}},
        {GP_GL_EGL, "GLAREPP_EGL", "libm.so.6", {"eglBindAPI", "EGL"}},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_gl *gl = NULL;
        set_env(rows[i].env, rows[i].library);
        assert_int_equal(gp_gl_open(&kept_log, rows[i].api, &gl), GP_ERR_GL);
        assert_null(gl);
        assert_kept(rows[i].text[0]);
        assert_kept(rows[i].text[1]);
        set_env(rows[i].env, NULL);
    }
}

static void auto_falls_back(void **state)
{
    struct gp_gl *gl = open_or_skip(GP_GL_EGL);
    gp_gl_close(&gl);
    set_env("GLAREPP_OSMESA", "/nonexistent/lib.so");
    assert_ok(gp_gl_open(&kept_log, GP_GL_AUTO, &gl));
    assert_ptr_equal(strstr(gp_gl_info(gl)->name, "EGL: "),
                     gp_gl_info(gl)->name);
    gp_gl_close(&gl);
    set_env("GLAREPP_EGL", "/nonexistent/lib.so");
    assert_int_equal(gp_gl_open(&kept_log, GP_GL_AUTO, &gl), GP_ERR_GL);
    assert_kept("libosmesa6");
    assert_kept("libegl1");
    set_env("GLAREPP_OSMESA", NULL);
    set_env("GLAREPP_EGL", NULL);
}

/* Exit status of a child: 0 the line names 3.x, 1 it does not, 77 the driver
 * is not Mesa, or is not there. */
static int open_as_33(enum gp_gl_api api)
{
    struct gp_gl *gl = NULL;
    setenv("MESA_GL_VERSION_OVERRIDE", "3.3", 1);
    gp_status st = gp_gl_open(&kept_log, api, &gl);
    if (strstr(kept_line, "cannot be loaded"))
        return 77;
    return st == GP_ERR_GL && !gl && strstr(kept_line, "4.5 (found 3.")
               ? 0 : gl && !gp_gl_info(gl)->software ? 77 : 1;
}

/* Mesa can be told to be older than it is, but hears it only once. */
static void old_version_is_named(void **state)
{
    if (getenv("GLAREPP_TEST_QUICK")) // valgrind changes the child's status
        skip_for("quick");
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
    set_env("GLAREPP_GL_MAX_SIZE", "16");
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    set_env("GLAREPP_GL_MAX_SIZE", NULL);
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
        kept_clear();
        assert_int_equal(gp_texture_make(&kept_log, gl, "kernel",
            GP_TEXEL_FLOAT, rows[i].w, rows[i].h, &t), rows[i].want);
        assert_int_equal(gp_target_make(&kept_log, gl, "layer", GP_TEXEL_FLOAT,
            1, rows[i].w, rows[i].h, &g), rows[i].want);
        if (rows[i].want)
            assert_kept("1x1 to 16x16 do");
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
        set_env("GLAREPP_GL_MAX_SIZE", others[i]);
        gl = open_or_skip(GP_GL_AUTO);
        set_env("GLAREPP_GL_MAX_SIZE", NULL);
        assert_int_equal(gp_gl_info(gl)->max_size, most);
        gp_gl_close(&gl);
    }
}

/* -- textures and draws ---------------------------------------------------- */

enum { W = 37, H = 23 };

static void random_texels(float *px, unsigned seed)
{
    static const float special[] = {0.0f,  -0.0f, 1e30f, -1e-30f,
                                    1e38f, 65504.0f, -7.5f, 0x1p-120f};
    for (int i = 0; i < 4 * W * H; i++) {
        seed = seed * 1664525u + 1013904223u;
        px[i] = seed >> 30 ? (float) (seed >> 8) * 0x1p-20f
                           : special[seed >> 8 & 7];
    }
}

/* Adds a texture twice to rows 3 to 10 of a target. */
static void draw_in(struct gp_gl *gl)
{
    static float px[4 * W * H], got[4 * W * H];
    struct gp_program p = {0};
    struct gp_texture from = {0};
    struct gp_target to = {0};
    const struct gp_rect all = {0, 0, W, H};
    const struct gp_uniform addend[] = {{.name = "addend", .texture = &from},
                                        {0}};
    const struct gp_uniform unknown[] = {{.name = "absent"}, {0}};
    const struct {
        struct gp_rect cut;
        const struct gp_uniform *uniform;
        gp_status st;
    } draws[] = {
        {{-5, 3, W + 9, 11}, addend, GP_OK},
        {{-5, 3, W + 9, 11}, addend, GP_OK},
        {{W, 0, W + 4, H}, addend, GP_OK}, // wholly outside
        {all, unknown, GP_ERR_BUG},
    };
    random_texels(px, 20071u);
    assert_ok(gp_gl_use(&kept_log, gl));
    assert_ok(gp_program_make(&kept_log, gl, "", "add.vert", "add.frag", &p));
    assert_ok(gp_texture_make(&kept_log, gl, "a", GP_TEXEL_FLOAT, W, H, &from));
    assert_ok(gp_target_make(&kept_log, gl, "b", GP_TEXEL_FLOAT, 1, W, H, &to));
    gp_texture_write(gl, &from, (struct gp_rect) {0, 0, W, 9}, px);
    gp_texture_write(gl, &from, (struct gp_rect) {0, 9, W, H}, px + 4 * W * 9);
    gp_target_clear(gl, &to, (struct gp_rect) {-9, -9, 999, 999});
    for (size_t i = 0; i < COUNT(draws); i++) {
        const struct gp_draw draw = {
            .program = &p, .target = &to, .cut = draws[i].cut,
            .uniform = draws[i].uniform, .vertices = 3, .instances = 1};
        assert_int_equal(gp_draw_run(&kept_log, gl, &draw), draws[i].st);
    }
    assert_kept("absent");
    gp_target_read(gl, &to, 0, all, got);
    for (int i = 0; i < 4 * W * H; i++) { // bit for bit
        const int y = i / (4 * W);
        const float want = y >= 3 && y < 11 ? px[i] + px[i] : 0.0f;
        if (got[i] != want)
            fail_msg("sample %d: %g, not %g", i, (double) got[i],
                     (double) want);
    }
    gp_target_clear(gl, &to, (struct gp_rect) {0, 3, W, 4});
    gp_target_read(gl, &to, 0, (struct gp_rect) {0, 3, W, 5}, got);
    for (int i = 0; i < 4 * W; i++) {
        assert_true(got[i] == 0.0f);
        assert_true(got[4 * W + i] == 2 * px[4 * W * 4 + i]);
    }
    assert_ok(gp_gl_check(&kept_log, gl, "test"));
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
    assert_ok(gp_texture_make(&kept_log, gl, "a", GP_TEXEL_FLOAT, 1, 1, &t));
    gp_texture_write(gl, &t, (struct gp_rect) {0, 0, -1, 1}, px);
    gp_texture_write(gl, &t, (struct gp_rect) {5, 0, 6, 1}, px);
    assert_int_equal(gp_gl_check(&kept_log, gl, "writing"), GP_ERR_GL);
    assert_kept("GL_INVALID_VALUE");
    assert_ok(gp_gl_check(&kept_log, gl, "writing"));
    gp_texture_free(gl, &t);
    gp_gl_close(&gl);
}

static void blocks_and_lists_have_limits(void **state)
{
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    const struct {
        enum gp_buffer_kind kind;
        int limit, least; // entries
        const char *text;
    } rows[] = {
        {GP_BUFFER_BLOCK, gp_gl_info(gl)->max_block / 16, 1024,
         "a uniform block"},
        {GP_BUFFER_TEXELS, gp_gl_info(gl)->max_texel_buffer, 65536,
         "a buffer texture"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        const int refused[] = {0, -1, rows[i].limit + 1};
        struct gp_buffer b = {0};
        assert_true(rows[i].limit >= rows[i].least);
        for (size_t k = 0; k < COUNT(refused); k++) {
            assert_int_equal(gp_buffer_make(&kept_log, gl, "a", rows[i].kind,
                                            refused[k], &b), GP_ERR_GL);
            assert_kept(rows[i].text);
            assert_int_equal(b.id, 0);
        }
        assert_ok(gp_buffer_make(&kept_log, gl, "a", rows[i].kind,
                                 rows[i].least, &b));
        gp_buffer_free(gl, &b);
        gp_buffer_free(gl, &b);
    }
    gp_gl_close(&gl);
}

static const struct gp_shader_file good_vert = {
    "good.vert", "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, "
                 "gl_VertexID == 2 ? 3 : -1, 0, 1); }\n"};

static void compiler_speaks_of_the_file(void **state)
{
    static const struct gp_shader_file bad = {
        "bad.frag", "out vec4 c;\nvoid main()\n{\n    c = nothing;\n}\n"};
    static const struct gp_shader_file unlinked = {
        "unlinked.frag", "in vec4 absent;\nout vec4 c;\n"
                         "void main() { c = absent; }\n"};
    for (int i = 0; i < 2; i++) {
        struct gp_gl *gl = open_or_skip(i ? GP_GL_EGL : GP_GL_OSMESA);
        struct gp_program p = {0};
        assert_int_equal(gp_program_from_text(&kept_log, gl, "", &good_vert,
                                              &bad, &p), GP_ERR_GL);
        assert_kept("bad.frag");
        assert_kept("nothing");
        if (strstr(gp_gl_info(gl)->name, "llvmpipe"))
            assert_kept("0:4"); // line 4 of the file, not of what is before
        assert_int_equal(gp_program_from_text(&kept_log, gl, "", &good_vert,
                                              &unlinked, &p), GP_ERR_GL);
        assert_kept("absent");
        for (int k = 0; k < 2; k++) { // files that this build has not
            assert_int_equal(
                gp_program_make(&kept_log, gl, "", k ? "no.vert" : "add.vert",
                                k ? "add.frag" : "no.frag", &p), GP_ERR_BUG);
            assert_kept(k ? "no.vert" : "no.frag");
        }
        assert_int_equal(p.id, 0);
        assert_ok(gp_gl_check(&kept_log, gl, "test"));
        gp_gl_close(&gl);
    }
}

/* A draw sees what its list held when it was asked for, though the list is
 * written again, and made anew, before anything is read back. */
static void lists_wait_for_draws(void **state)
{
    enum { SIDE = 256, DRAWS = 6 };
    static const char frag[] =
        "layout(rgba32f) readonly uniform imageBuffer list; out vec4 c;\n"
        "void main() { c = vec4(0.0);\n"
        "    for (int i = 0; i < 64; i++) c += imageLoad(list, i); }\n";
    static float px[4 * SIDE * SIDE];
    float entries[4 * 64];
    const struct gp_shader_file file = {"test.frag", frag};
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    struct gp_program program = {0};
    struct gp_target target = {0};
    struct gp_buffer list = {0};
    const struct gp_rect all = {0, 0, SIDE, SIDE};
    assert_ok(gp_program_from_text(&kept_log, gl, "", &good_vert, &file,
                                   &program));
    assert_ok(gp_target_make(&kept_log, gl, "target", GP_TEXEL_FLOAT, 1, SIDE,
                             SIDE, &target));
    gp_target_clear(gl, &target, all);
    for (int d = 0; d < DRAWS; d++) {
        const struct gp_uniform u[] = {{.name = "list", .image = &list.texture},
                                       {0}};
        if (d % 2 == 0) {
            gp_buffer_free(gl, &list);
            assert_ok(gp_buffer_make(&kept_log, gl, "l", GP_BUFFER_TEXELS, 64,
                                     &list));
        }
        for (int i = 0; i < 4 * 64; i++)
            entries[i] = (float) (1 << d);
        gp_buffer_write(gl, &list, 0, 64, entries);
        assert_ok(gp_draw_run(&kept_log, gl, &(struct gp_draw) {
            .program = &program, .target = &target, .cut = all, .uniform = u,
            .vertices = 3, .instances = 1}));
    }
    gp_buffer_free(gl, &list);
    gp_target_read(gl, &target, 0, all, px);
    for (int i = 0; i < 4 * SIDE * SIDE; i++)
        assert_true(px[i] == 64.0f * (float) ((1 << DRAWS) - 1));
    assert_ok(gp_gl_check(&kept_log, gl, "test"));
    gp_target_free(gl, &target);
    gp_program_free(gl, &program);
    gp_gl_close(&gl);
}

// old_version_is_named comes before any Mesa
SUITE_OF(gl, NULL, NULL, old_version_is_named, opens_and_closes,
    bad_libraries_are_named, auto_falls_back, limit_can_only_be_lowered,
    contexts_live_side_by_side, errors_are_named_and_cleared,
    blocks_and_lists_have_limits, compiler_speaks_of_the_file,
    lists_wait_for_draws)
