// SPDX-License-Identifier: Apache-2.0
/* gl in space: depth is tested, kept and read back; faces are left out;
 * matrices and vertices from a buffer arrive; fragments are counted. */
#include "unit.h"
#include "gl_open.h"

enum { SIDE = 8, PIXELS = SIDE * SIDE };

static struct gp_gl *gl;
static struct gp_program program;
static struct gp_target target;
static const struct gp_rect all = {0, 0, SIDE, SIDE};

/* Vertices are pulled from a buffer and turned by a matrix; red is 1 on every
 * fragment. */
static const struct gp_shader_file vert = {"test.vert",
    "uniform samplerBuffer list; uniform mat4 turn;\n"
    "void main() { gl_Position = turn * texelFetch(list, gl_VertexID); }\n"};
static const struct gp_shader_file clipped = {"clipped.vert",
    "uniform samplerBuffer list; uniform mat4 turn;\n"
    "out float gl_ClipDistance[1];\n"
    "void main() { vec4 p = texelFetch(list, gl_VertexID);\n"
    "    gl_Position = turn * p;\n"
    "    gl_ClipDistance[0] = p.x + 0.5; }\n"};
static const struct gp_shader_file frag = {"test.frag",
    "out vec4 c; void main() { c = vec4(1.0); }\n"};

static struct gp_buffer list;

/* A full square at depth 0.5, one at 0.25 (farther) in the other winding, and
 * one that leans from depth 0 (left) to 1. */
static const float corners[3][6][4] = {
    {{-1, -1, .5f, 1}, {1, -1, .5f, 1}, {-1, 1, .5f, 1},
     {-1, 1, .5f, 1}, {1, -1, .5f, 1}, {1, 1, .5f, 1}},
    {{-1, -1, .25f, 1}, {-1, 1, .25f, 1}, {1, -1, .25f, 1},
     {-1, 1, .25f, 1}, {1, 1, .25f, 1}, {1, -1, .25f, 1}},
    {{-1, -1, 0, 1}, {1, -1, 1, 1}, {-1, 1, 0, 1},
     {-1, 1, 0, 1}, {1, -1, 1, 1}, {1, 1, 1, 1}},
};
static const float same[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static int set_up(void **state)
{
    (void) state;
    gl = open_or_skip(GP_GL_AUTO);
    assert_ok(gp_program_from_text(&kept_log, gl, "", &vert, &frag, &program));
    assert_ok(gp_target_make(&kept_log, gl, "deep", GP_TEXEL_DEPTH, 1, SIDE,
                             SIDE, &target));
    assert_ok(gp_buffer_make(&kept_log, gl, "list", GP_BUFFER_TEXELS, 18,
                             &list));
    gp_buffer_write(gl, &list, 0, 18, &corners[0][0][0]);
    gp_target_clear(gl, &target, all);
    return 0;
}

static int tear_down(void **state)
{
    (void) state;
    assert_ok(gp_gl_check(&kept_log, gl, "test"));
    gp_buffer_free(gl, &list);
    gp_program_free(gl, &program);
    gp_target_free(gl, &target);
    gp_gl_close(&gl);
    return 0;
}

static void draw(int square, struct gp_draw d)
{
    const struct gp_uniform u[] = {{.name = "list", .texture = &list.texture},
                                   {.name = "turn", .matrix = same},
                                   {0}};
    if (!d.program)
        d.program = &program;
    d.target = &target;
    if (!d.uniform)
        d.uniform = u;
    d.cut = all;
    d.first = 6 * square;
    d.vertices = 6;
    d.instances = 1;
    assert_ok(gp_draw_run(&kept_log, gl, &d));
}

/* Sum of red over the target. */
static float sum_of_red(void)
{
    static float px[4 * PIXELS];
    float sum = 0.0f;
    gp_target_read(gl, &target, 0, all, px);
    for (int i = 0; i < PIXELS; i++)
        sum += px[4 * i];
    return sum;
}

static void nearer_or_as_near_is_drawn(void **state)
{
    float depth[PIXELS];
    draw(1, (struct gp_draw) {.depth = GP_DEPTH_WRITE}); // 0.25: farther
    draw(0, (struct gp_draw) {.depth = GP_DEPTH_READ});  // nearer: drawn
    gp_target_read(gl, &target, GP_DEPTH_ATTACHMENT, all, depth);
    for (int i = 0; i < PIXELS; i++) // but not kept
        assert_true(depth[i] == 0.25f);
    draw(0, (struct gp_draw) {.depth = GP_DEPTH_WRITE});
    draw(0, (struct gp_draw) {.depth = GP_DEPTH_READ}); // as near
    draw(1, (struct gp_draw) {.depth = GP_DEPTH_WRITE}); // behind: not drawn
    gp_target_read(gl, &target, GP_DEPTH_ATTACHMENT,
                   (struct gp_rect) {2, 1, 5, 3}, depth);
    for (int i = 0; i < 6; i++)
        assert_true(depth[i] == 0.5f);
    assert_true(sum_of_red() == 4.0f * PIXELS);
    draw(1, (struct gp_draw) {.depth = GP_DEPTH_SAME});
    draw(2, (struct gp_draw) {.depth = GP_DEPTH_SAME});
    assert_true(sum_of_red() == 4.0f * PIXELS);
    draw(0, (struct gp_draw) {.depth = GP_DEPTH_SAME});
    assert_true(sum_of_red() == 5.0f * PIXELS);
    draw(1, (struct gp_draw) {0}); // no test: as ever
    assert_true(sum_of_red() == 6.0f * PIXELS);
    gp_target_clear(gl, &target, (struct gp_rect) {0, 0, SIDE, 1});
    gp_target_read(gl, &target, GP_DEPTH_ATTACHMENT,
                   (struct gp_rect) {0, 0, 1, 2}, depth);
    assert_true(depth[0] == 0.0f);
    assert_true(depth[1] == 0.5f);
}

/* Columns of a square that leans: depth (x + 0.5) / 8 at their centres. */
static void depth_is_that_of_the_plane(void **state)
{
    float depth[PIXELS];
    draw(2, (struct gp_draw) {.depth = GP_DEPTH_WRITE});
    gp_target_read(gl, &target, GP_DEPTH_ATTACHMENT, all, depth);
    for (int i = 0; i < PIXELS; i++)
        assert_float_equal(depth[i], ((float) (i % SIDE) + 0.5f) / SIDE, 1e-6);
}

static void faces_are_left_out(void **state)
{
    static const struct { int square; enum gp_cull cull; bool drawn; } rows[] = {
        {0, GP_CULL_NONE, true}, {1, GP_CULL_NONE, true},
        {0, GP_CULL_BACK, true}, {1, GP_CULL_BACK, false},
        {0, GP_CULL_FRONT, false}, {1, GP_CULL_FRONT, true},
        {1, GP_CULL_NONE, true}, // the state is set back
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        gp_target_clear(gl, &target, all);
        draw(rows[i].square, (struct gp_draw) {.cull = rows[i].cull});
        assert_true(sum_of_red() == (rows[i].drawn ? PIXELS : 0.0f));
    }
}

/* Row vectors: the last row moves. A quarter of the width to the right. */
static void matrices_and_clips_arrive(void **state)
{
    float px[4 * PIXELS];
    const float moved[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, .5f, 0, 0, 1};
    const struct gp_uniform u[] = {{.name = "list", .texture = &list.texture},
                                   {.name = "turn", .matrix = moved},
                                   {0}};
    struct gp_program clips_x = {0};
    assert_ok(gp_program_from_text(&kept_log, gl, "", &clipped, &frag,
                                   &clips_x));
    for (int clips = 0; clips < 2; clips++) {
        const struct gp_program *const by = clips ? &clips_x : &program;
        gp_target_clear(gl, &target, all);
        draw(0, (struct gp_draw) {.uniform = u, .clips = clips, .program = by});
        gp_target_read(gl, &target, 0, all, px);
        for (int x = 0; x < SIDE; x++) // clip: only x >= -0.5 of the square
            assert_true(px[4 * x] == (x >= (clips ? 4 : 2) ? 1.0f : 0.0f));
    }
    gp_program_free(gl, &clips_x);
}

/* Whole blocks of pixels are counted, so small differences do not show. */
static void fragments_are_counted(void **state)
{
    long long n[3];
    for (int i = 0; i < 3; i++) {
        gp_target_clear(gl, &target, all);
        gp_count_begin(gl);
        draw(1, (struct gp_draw) {.depth = GP_DEPTH_WRITE});
        for (int k = 0; k < i; k++)
            draw(0, (struct gp_draw) {.depth = GP_DEPTH_WRITE});
        n[i] = gp_count_end(gl);
    }
    if (n[0] == -1)
        return;
    assert_true(n[0] >= PIXELS);
    assert_int_equal(n[1], 2 * n[0]);
    assert_int_equal(n[2], 3 * n[0]);
}

/* Depth without colour, read as a texture. */
static void depth_alone_is_a_texture(void **state)
{
    static const struct gp_shader_file reader = {"reader.frag",
        "uniform sampler2D depth; out vec4 c; void main() {\n"
        "c = texelFetch(depth, ivec2(gl_FragCoord.xy), 0).rrrr; }\n"};
    struct gp_target map = {0}, refused = {0};
    struct gp_program reads = {0};
    const struct gp_uniform u[] = {{.name = "list", .texture = &list.texture},
                                   {.name = "turn", .matrix = same},
                                   {0}};
    assert_ok(gp_target_make(&kept_log, gl, "map", GP_TEXEL_DEPTH, 0, SIDE,
                             SIDE, &map));
    assert_ok(gp_program_from_text(&kept_log, gl, "", &vert, &reader, &reads));
    gp_target_clear(gl, &map, all);
    const struct gp_draw shadow = {
        .program = &program, .target = &map, .cut = {0, 0, SIDE, 4},
        .uniform = u, .vertices = 6, .instances = 1, .depth = GP_DEPTH_WRITE};
    assert_ok(gp_draw_run(&kept_log, gl, &shadow));
    const struct gp_uniform v[] = {{.name = "list", .texture = &list.texture},
                                   {.name = "turn", .matrix = same},
                                   {.name = "depth", .texture = &map.depth},
                                   {0}};
    const struct gp_draw read = {
        .program = &reads, .target = &target, .cut = all, .uniform = v,
        .vertices = 6, .instances = 1};
    assert_ok(gp_draw_run(&kept_log, gl, &read));
    assert_true(sum_of_red() == 0.5f * 4 * SIDE);
    assert_int_equal(gp_target_make(&kept_log, gl, "map", GP_TEXEL_DEPTH, 0,
        gp_gl_info(gl)->max_size + 1, 1, &refused), GP_ERR_GL);
    assert_kept("map");
    assert_int_equal(refused.framebuffer, 0);
    gp_target_free(gl, &map);
    assert_int_equal(map.depth.id, 0);
    gp_program_free(gl, &reads);
}

SUITE_OF_EACH(gl_deep, set_up, tear_down, nearer_or_as_near_is_drawn,
    depth_is_that_of_the_plane, faces_are_left_out, matrices_and_clips_arrive,
    fragments_are_counted, depth_alone_is_a_texture)
