// SPDX-License-Identifier: Apache-2.0
/* Kernels, lenses and sets without a plan: contracts; figures are tested in the
 * rooms. */
#include "unit.h"

#include "glarepp.h"

#include <math.h>

static struct glarepp *gp;

/* Decodes any picture as three pixels, or as opaque. */
static int decode(void *user, const struct glarepp_picture *p,
                  struct glarepp_image *out, struct glarepp_label *label)
{
    static float row[3] = {1.0f, 2.0f, 1.0f};
    static uint16_t opaque = 65535;
    out->data = (struct glarepp_rect) {0, 0, p->alpha ? 1 : 3, 1};
    out->type = p->alpha ? GLAREPP_CODES : GLAREPP_FLOAT;
    for (int c = 0; c < 3; c++)
        out->plane[c] = p->alpha ? (void *) &opaque : row;
    return GLAREPP_OK;
}

static int start(void **state)
{
    struct glarepp_params p = GLAREPP_PARAMS;
    p.data = "examples";
    p.picture = decode;
    return glarepp_open(&p, &gp);
}

static int end(void **state)
{
    glarepp_close(&gp);
    return 0;
}

static struct glarepp_kernel *kernel_of(const char *word)
{
    struct glarepp_kernel_params p = GLAREPP_KERNEL_PARAMS;
    struct glarepp_kernel *k;
    p.word = &word;
    p.words = 1;
    assert_int_equal(glarepp_kernel(gp, &p, &k), GLAREPP_OK);
    return k;
}

// -- kernels ------------------------------------------------------------------

static void kernels_are_drawn(void **state)
{
    struct glarepp_kernel *k = kernel_of("moffat:share=0.25");
    struct glarepp_field field = {.w = 32, .h = 24, .most = 63 * 47};
    struct glarepp_image image;
    struct glarepp_label label;
    double sum = 0.0;
    assert_int_equal(glarepp_kernel_draw(k, &field, &image, &label),
                     GLAREPP_OK);
    assert_int_equal(image.data.x1 - image.data.x0, 63);
    assert_int_equal(image.data.y1 - image.data.y0, 47);
    for (int i = 0; i < 63 * 47; i++)
        sum += (double) ((float *) image.plane[1])[i];
    assert_true(fabs(sum + label.left_out - 1.0) < 1e-4);
    assert_true(label.present && label.w == 32 && label.h == 24);
    assert_true(label.fov == 30.0 && label.share == 0.25);
    glarepp_image_end(&image);
    field.radius = 5;
    assert_int_equal(glarepp_kernel_draw(k, &field, &image, &label),
                     GLAREPP_OK);
    assert_int_equal(image.data.x1 - image.data.x0, 11);
    glarepp_image_end(&image);
    field.radius = 0;
    field.most--;
    field.name = "k.exr";
    assert_int_equal(glarepp_kernel_draw(k, &field, &image, &label),
                     GLAREPP_ERR_DATA);
    assert_string_equal(glarepp_error()->parameter, "field.most");
    assert_memory_equal(glarepp_error()->text, "k.exr: ", 7);
    glarepp_kernel_end(&k);
}

static void kernels_are_checked(void **state)
{
    float v[9 * 9] = {0.0f};
    struct glarepp_image image = GLAREPP_IMAGE;
    const struct glarepp_kernel_use use = {.brightest = 1000.0};
    struct glarepp_kernel_figures f;
    image.data = (struct glarepp_rect) {0, 0, 9, 9};
    image.plane[0] = image.plane[1] = image.plane[2] = v;
    assert_int_equal(glarepp_kernel_check(gp, &image, &use, &f), GLAREPP_OK);
    assert_true(!f.lit && f.faults == 1);
    for (int i = 0; i < 9; i++)
        v[(i / 3 + 3) * 9 + i % 3 + 3] = i == 4 ? 1.0f : 0.1f;
    assert_int_equal(glarepp_kernel_check(gp, &image, &use, &f), GLAREPP_OK);
    assert_true(f.lit && f.w == 3 && f.h == 3 && f.centre[0] == 1);
    assert_true(fabs(f.light - 1.8) < 1e-5 && f.peak_at[0] == 0);
    v[4 * 9 + 5] = 2.0f;
    assert_int_equal(glarepp_kernel_check(gp, &image, &use, &f), GLAREPP_OK);
    assert_true(f.faults > 0 && f.peak_at[0] == 1);
    assert_non_null(strstr(f.fault[0], "its peak is 1,0 pixels"));
    v[0] = NAN;
    assert_int_equal(glarepp_kernel_check(gp, &image, &use, &f), GLAREPP_OK);
    assert_true(f.nonfinite == 3 && f.faults == 1);
}

/* A path alone is an image or, where that is asked for, a recipe. */
static void paths_are_recipes(void **state)
{
    struct glarepp_kernel_params p = GLAREPP_KERNEL_PARAMS;
    struct glarepp_kernel *k;
    const char *word = "k.exr";
    char path[8];
    p.word = &word;
    p.words = 1;
    for (int i = 0; i < 2; i++) {
        p.recipe = i == 1;
        assert_int_equal(glarepp_kernel(gp, &p, &k), GLAREPP_OK);
        assert_true(!glarepp_kernel_recipe(k, 0) == !p.recipe);
        glarepp_kernel_end(&k);
    }
    assert_true(glarepp_kernel_path(word, path, sizeof path));
    assert_string_equal(path, word);
    assert_false(glarepp_kernel_path(word, path, 5));
    assert_true(glarepp_kernel_path("image:file=k.exr", path, sizeof path));
    assert_string_equal(path, word);
    assert_false(glarepp_kernel_path("star", path, sizeof path));
}

// -- lenses -------------------------------------------------------------------

static void lenses(void **state)
{
    struct glarepp_lens lens;
    const char *name;
    int n = 0;
    for (; (name = glarepp_name(gp, GLAREPP_LENSES, n, NULL)); n++) {
        assert_int_equal(glarepp_lens(gp, name, &lens), GLAREPP_OK);
        assert_true(lens.focal > 0.0 && lens.ghosts > 0);
        assert_true(lens.ghost[0].first > lens.ghost[0].second);
        for (int i = 0; i < 2; i++) {
            const char *const text =
                glarepp_lens_draw(&lens, i ? &lens.ghost[0] : NULL);
            assert_non_null(strstr(text, "</svg>"));
            assert_true(!strstr(text, "class=\"ray\"") == (i == 0));
        }
        glarepp_lens_end(&lens);
    }
    assert_int_equal(n, 6);
    assert_int_equal(glarepp_lens(gp, "absent.json", &lens), GLAREPP_ERR_IO);
    assert_null(lens.ghost);
    glarepp_lens_end(&lens);
}

// -- sets ---------------------------------------------------------------------

static void wrong_sets(void **state)
{
    struct glarepp_sets_params p = GLAREPP_SETS_PARAMS;
    struct glarepp_sets sets;
    assert_int_equal(glarepp_sets(gp, &p, &sets), GLAREPP_ERR_USAGE);
    assert_string_equal(glarepp_error()->parameter, "sets.path");
    p.path = "absent.glb";
    assert_int_equal(glarepp_sets(gp, &p, &sets), GLAREPP_ERR_IO);
    p.path = "examples/alley.glb";
    p.camera = "nobody";
    assert_int_equal(glarepp_sets(gp, &p, &sets), GLAREPP_ERR_USAGE);
    p.runs = 0;
    assert_int_equal(glarepp_sets(gp, &p, &sets), GLAREPP_ERR_USAGE);
    assert_string_equal(glarepp_error()->parameter, "sets.runs");
    assert_null(sets.own);
    glarepp_sets_end(&sets);
}

static void sets_of_a_street(void **state)
{
    struct glarepp_sets_params p = GLAREPP_SETS_PARAMS;
    struct glarepp_sets sets;
    struct glarepp_image image;
    p.path = "examples/alley.glb";
    p.w = 96;
    p.h = 54;
    p.runs = 1;
    const int st = glarepp_sets(gp, &p, &sets);
    if (st == GLAREPP_ERR_GL)
        skip_for("no GL");
    assert_int_equal(st, GLAREPP_OK);
    assert_true(sets.objects > 100 && sets.lights == 8 && sets.gl[0]);
    for (int i = 0; i < 5; i++)
        assert_true(sets.row[i].same && sets.row[i].visible > 0 &&
                    sets.row[i].batches <= sets.row[0].batches);
    for (int i = 0; i < sets.lights; i++)
        assert_true(sets.light[i][0] && sets.scissor[i].x1 <= p.w &&
                    sets.depth[i][0] <= sets.depth[i][1]);
    // what the scissors' outlines leave is the picture, tone-mapped
    float lit[96 * 54];
    int equal = 0;
    assert_int_equal(glarepp_sets_view(&sets, GLAREPP_LIT, &image), GLAREPP_OK);
    assert_int_equal(image.data.x1, p.w);
    memcpy(lit, image.plane[0], sizeof lit);
    assert_int_equal(glarepp_sets_view(&sets, GLAREPP_SHOWN, &image),
                     GLAREPP_OK);
    for (int i = 0; i < 96 * 54; i++)
        equal += ((float *) image.plane[0])[i] == lit[i] / (1.0f + lit[i]);
    assert_true(equal > 96 * 54 / 4 && equal < 96 * 54);
    assert_int_equal(glarepp_sets_view(&sets, GLAREPP_SOURCES, &image),
                     GLAREPP_OK);
    assert_int_equal(glarepp_sets_view(&sets, GLAREPP_DEPTH, &image),
                     GLAREPP_ERR_USAGE);
    glarepp_sets_end(&sets);
}

// -- the brightest source -----------------------------------------------------

static void brightest(void **state)
{
    float v[3][16] = {{0.0f}};
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    struct glarepp_plan *plan;
    struct glarepp_frame *frame;
    p.image.data = (struct glarepp_rect) {0, 0, 4, 4};
    for (int c = 0; c < 3; c++)
        p.image.plane[c] = v[c];
    v[0][5] = v[1][5] = v[2][5] = 3.0f;
    v[2][9] = 40.0f;
    assert_int_equal(glarepp_plan(gp, NULL, &plan), GLAREPP_OK);
    assert_int_equal(glarepp_frame(plan, &p, &frame), GLAREPP_OK);
    assert_int_equal(glarepp_frame_run(frame, GLAREPP_SENSE), GLAREPP_OK);
    const struct glarepp_sense_facts *const f =
        &glarepp_frame_facts(frame)->sense;
    assert_int_equal(f->sources, 2);
    assert_true(f->brightest > 20.0f && f->brightest < 40.0f);
    glarepp_frame_end(&frame);
    glarepp_plan_end(&plan);
}

// -- parts of the layer -------------------------------------------------------

enum { SIDE = 64, SAMPLES = SIDE * SIDE };

/* The largest difference of a frame's layer from the sum of its parts. */
static double apart(struct glarepp_frame *f)
{
    struct glarepp_image whole, part[4];
    double most = 0.0;
    assert_int_equal(glarepp_frame_view(f, GLAREPP_GLARE, 0, &whole), 0);
    for (int i = 0; i < 4; i++)
        assert_int_equal(
            glarepp_frame_view(f, (enum glarepp_view)(GLAREPP_PART_VEIL + i), 0,
                               &part[i]),
            0);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < SAMPLES; i++) {
            double sum = 0.0;
            for (int k = 0; k < 4; k++)
                sum += (double) ((const float *) part[k].plane[c])[i];
            most = fmax(
                most, fabs(sum - (double) ((const float *) whole.plane[c])[i]));
        }
    }
    return most;
}

/* Parts add up, those of a layer made anew too; a level needs the picture. */
static void parts_add_up(void **state)
{
    static float v[3][SAMPLES];
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    struct glarepp_plan_params how = GLAREPP_PLAN_PARAMS;
    struct glarepp_light_params lights = GLAREPP_LIGHT_PARAMS;
    struct glarepp_plan *plan;
    struct glarepp_frame *f;
    p.image.data = (struct glarepp_rect) {0, 0, SIDE, SIDE};
    p.parts = true;
    for (int c = 0; c < 3; c++) {
        p.image.plane[c] = v[c];
        v[c][20 * SIDE + 12] = 900.0f;
    }
    lights.flare = "preset:zoom";
    lights.flare_gain = 0.0f;
    how.lights = &lights;
    assert_int_equal(glarepp_plan(gp, &how, &plan), 0);
    assert_int_equal(glarepp_frame(plan, &p, &f), 0);
    for (int i = 0; i <= GLAREPP_LENS; i++)
        assert_int_equal(glarepp_frame_run(f, (enum glarepp_step) i), 0);
    assert_true(glarepp_frame_facts(f)->flare.gain > 0.0);
    assert_true(apart(f) < 1e-4);
    assert_int_equal(glarepp_frame_run(f, GLAREPP_LAYER), 0);
    assert_true(apart(f) < 1e-4);
    glarepp_frame_drop(f, 1u << GLAREPP_CLEAN);
    assert_int_equal(glarepp_frame_run(f, GLAREPP_FLARE), GLAREPP_ERR_USAGE);
    glarepp_frame_end(&f);
    glarepp_plan_end(&plan);
}

SUITE_OF(parts, start, end, kernels_are_drawn, kernels_are_checked,
         paths_are_recipes, lenses, wrong_sets, sets_of_a_street, brightest,
         parts_add_up)
