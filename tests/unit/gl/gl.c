/* gl: contexts open, fail with words, live side by side; textures come back
 * bit for bit; what is too large or wrong is named; shaders' messages point at
 * their files; targets, uniforms and lists are to a shader what they
 * were meant to be. */
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

static void shader_files_open_with_a_comment(void **state)
{
    int files = 0;
    for (const struct gp_shader_file *f = gp_shader_files; f->name; f++) {
        assert_memory_equal(f->text, "// ", 3);
        if (strcmp(f->name, "common.glsl") == 0)
            continue;
        files++;
        if (!strstr(f->text, "\n// in ") || !strstr(f->text, "\n// out ") ||
            !strstr(f->text, "\n// CPU twin: "))
            fail_msg("%s: in, out or CPU twin is missing", f->name);
    }
    assert_true(files >= 4);
}

/* -- inputs of shaders ----------------------------------------------------- */

/* A program, and a target of n attachments to draw to. */
static struct gp_gl *gl;
static struct gp_program program;
static struct gp_target target;

static void open_stage(const char *defines, const char *vert, const char *frag,
                       int n, int w, int h)
{
    const struct gp_shader_file v = {"test.vert", vert};
    const struct gp_shader_file f = {"test.frag", frag};
    gl = open_or_skip(GP_GL_AUTO);
    if (gp_program_from_text(&kept_log, gl, defines, &v, &f, &program) != GP_OK)
        fail_msg("%s", kept_line);
    assert_ok(gp_target_make(&kept_log, gl, "target", GP_TEXEL_FLOAT, n, w, h,
                             &target));
    assert_int_equal(target.n, n);
}

static void close_stage(void)
{
    assert_ok(gp_gl_check(&kept_log, gl, "test"));
    gp_target_free(gl, &target);
    assert_int_equal(target.n, 0);
    gp_program_free(gl, &program);
    gp_gl_close(&gl);
}

/* Draws a triangle over the whole target. */
static gp_status draw_once(const struct gp_uniform *uniform, bool replace)
{
    const struct gp_draw draw = {
        .program = &program, .target = &target, .cut = {0, 0, 999, 999},
        .uniform = uniform, .vertices = 3, .instances = 1, .replace = replace,
    };
    return gp_draw_run(&kept_log, gl, &draw);
}

static const char eight[] = "uniform float first;\n"
    "layout(location = 0) out vec4 o0; layout(location = 1) out vec4 o1;\n"
    "layout(location = 2) out vec4 o2; layout(location = 3) out vec4 o3;\n"
    "layout(location = 4) out vec4 o4; layout(location = 5) out vec4 o5;\n"
    "layout(location = 6) out vec4 o6; layout(location = 7) out vec4 o7;\n"
    "void main() {\n"
    "    vec4 v = vec4(gl_FragCoord.xy, first, 0.0);\n"
    "    o0 = v; v.a++; o1 = v; v.a++; o2 = v; v.a++; o3 = v; v.a++;\n"
    "    o4 = v; v.a++; o5 = v; v.a++; o6 = v; v.a++; o7 = v; }\n";

/* Each attachment has its own output, and its own sums; all are cleared. */
static void attachments_are_apart(void **state)
{
    static float px[4 * 5 * 3];
    const struct gp_rect all = {0, 0, 5, 3};
    const struct gp_uniform u[] = {{.name = "first", .floats = 1,
                                    .f = {0.25f}}, {0}};
    for (int n = 1; n <= GP_ATTACHMENTS; n++) {
        open_stage("", good_vert.text, eight, n, 5, 3);
        for (int i = 0; i < 3; i++)
            assert_ok(draw_once(u, i < 2));
        for (int i = 0; i < n; i++) {
            gp_target_read(gl, &target, i, all, px);
            for (int k = 0; k < 15; k++) {
                assert_true(px[4 * k] == 2.0f * (float) (k % 5) + 1.0f);
                assert_true(px[4 * k + 1] == 2.0f * (float) (k / 5) + 1.0f);
                assert_true(px[4 * k + 2] == 0.5f);
                assert_true(px[4 * k + 3] == 2.0f * (float) i);
            }
        }
        gp_target_clear(gl, &target, all);
        for (int i = 0; i < n; i++) {
            gp_target_read(gl, &target, i, all, px);
            for (int k = 0; k < 60; k++)
                assert_true(px[k] == 0.0f);
        }
        close_stage();
    }
}

/* One value of each kind reaches the shader. */
static void uniforms_arrive(void **state)
{
    static const char frag[] =
        "uniform float one; uniform vec2 two; uniform vec4 four;\n"
        "uniform ivec2 whole; uniform sampler2D texture0;\n"
        "layout(rgba32f) readonly uniform image2D image0;\n"
        "layout(rgba32f) readonly uniform imageBuffer list0;\n"
        "layout(std140) uniform Block { vec4 entry[2]; };\n"
        "layout(location = 0) out vec4 a; layout(location = 1) out vec4 b;\n"
        "layout(location = 2) out vec4 c;\n"
        "void main() {\n"
        "    a = vec4(one, two, four.w);\n"
        "    b = vec4(whole, texelFetch(texture0, ivec2(1, 0), 0).g,\n"
        "             imageLoad(image0, ivec2(0, 1)).b);\n"
        "    c = vec4(imageLoad(list0, 2).r, entry[1].a, VALUE, four.r); }\n";
    static const float texels[16] = {[5] = 7.0f, [10] = 8.0f, [12] = 9.0f};
    static const float want[12] = {0.5f, 0.25f, 0.75f, 3.0f, -4.0f, 5.0f,
                                   7.0f, 8.0f,  11.0f, 12.0f, 13.0f, 0.0f};
    static const float entries[12] = {[7] = 12.0f, [8] = 11.0f};
    const struct gp_rect square = {0, 0, 2, 2};
    struct gp_texture sharp = {0};
    struct gp_buffer list = {0}, block = {0};
    float got[12];
    open_stage("#define VALUE 13.0\n", good_vert.text, frag, 3, 1, 1);
    assert_ok(
        gp_texture_make(&kept_log, gl, "a", GP_TEXEL_FLOAT, 2, 2, &sharp));
    assert_ok(gp_buffer_make(&kept_log, gl, "c", GP_BUFFER_TEXELS, 3, &list));
    assert_ok(gp_buffer_make(&kept_log, gl, "d", GP_BUFFER_BLOCK, 2, &block));
    gp_texture_write(gl, &sharp, square, texels);
    gp_buffer_write(gl, &list, 1, 2, entries + 4);
    gp_buffer_write(gl, &block, 0, 2, entries);
    const struct gp_uniform u[] = {
        {.name = "one", .floats = 1, .f = {0.5f}},
        {.name = "two", .floats = 2, .f = {0.25f, 0.75f}},
        {.name = "four", .floats = 4, .f = {0, 0, 0, 3.0f}},
        {.name = "whole", .v = {-4, 5}},
        {.name = "texture0", .texture = &sharp},
        {.name = "image0", .image = &sharp}, {.name = "list0", .texels = &list},
        {.name = "Block", .block = &block}, {0}};
    assert_ok(draw_once(u, true));
    for (int i = 0; i < 3; i++)
        gp_target_read(gl, &target, i, (struct gp_rect) {0, 0, 1, 1},
                       got + 4 * i);
    for (int i = 0; i < 12; i++)
        assert_true(got[i] == want[i]);
    const struct gp_uniform absent[] = {{.name = "Absent", .block = &block},
                                        {0}};
    assert_int_equal(draw_once(absent, false), GP_ERR_BUG);
    assert_kept("Absent");
    gp_texture_free(gl, &sharp);
    gp_buffer_free(gl, &list);
    gp_buffer_free(gl, &block);
    close_stage();
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
    struct gp_buffer list = {0};
    const struct gp_rect all = {0, 0, SIDE, SIDE};
    open_stage("", good_vert.text, frag, 1, SIDE, SIDE);
    gp_target_clear(gl, &target, all);
    for (int d = 0; d < DRAWS; d++) {
        const struct gp_uniform u[] = {{.name = "list", .texels = &list}, {0}};
        if (d % 2 == 0) {
            gp_buffer_free(gl, &list);
            assert_ok(gp_buffer_make(&kept_log, gl, "l", GP_BUFFER_TEXELS, 64,
                                     &list));
        }
        for (int i = 0; i < 4 * 64; i++)
            entries[i] = (float) (1 << d);
        gp_buffer_write(gl, &list, 0, 64, entries);
        assert_ok(draw_once(u, false));
    }
    gp_buffer_free(gl, &list);
    gp_target_read(gl, &target, 0, all, px);
    for (int i = 0; i < 4 * SIDE * SIDE; i++)
        assert_true(px[i] == 64.0f * (float) ((1 << DRAWS) - 1));
    close_stage();
}

// old_version_is_named comes before any Mesa
SUITE_OF(gl, NULL, NULL,
    old_version_is_named, opens_and_closes, bad_libraries_are_named,
    auto_falls_back, limit_can_only_be_lowered,
    contexts_live_side_by_side, errors_are_named_and_cleared,
    blocks_and_lists_have_limits, compiler_speaks_of_the_file,
    shader_files_open_with_a_comment, attachments_are_apart, uniforms_arrive,
    lists_wait_for_draws)
