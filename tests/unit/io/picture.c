// SPDX-License-Identifier: Apache-2.0
/* io/picture: display windows that are none, alpha, codes, and the laws of the
 * dither. */
#include "unit.h"
#include "write_fixture.h"
#include "core/bytes.h"
#include "core/colour.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "io/io_priv.h"

static void windows_that_are_no_picture(void **state)
{
    static const struct gp_rect display[] = {
        {0, 0, 0, 5}, {0, 0, 5, 0}, {3, 0, -2, 5}, {0, 9, 5, 2},
        {INT32_MIN, 0, INT32_MAX, 1}, {0, INT32_MIN, 1, INT32_MAX},
        {0, 0, 1 << 29, 1}, {0, 0, 1 << 20, (1 << 20) + 1},
    };
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_frame f = wf_sized(2, 2, wf_rgb);
    for (size_t i = 0; i < COUNT(display); i++) {
        struct gp_picture pic;
        f.display = display[i];
        kept_clear();
        assert_int_equal(
            gp_picture_make(&(struct gp_picture_job) {&kept_all, &p, "p.png",
                                                      &f, &f.rgb,
                                                      GP_PICTURE_SCENE, NULL},
                            &pic),
            GP_ERR_DATA);
        assert_kept("p.png: ");
        assert_int_equal(pic.channels, 0); // empty
    }
    gp_frame_free(&f);
}

/* Rows of floats with alpha, the picture wider than the data. */
static void floats_with_alpha(void **state)
{
    const struct gp_rect data = {1, 0, 3, 2}, display = {0, 0, 4, 2};
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_frame f = wf_frame(data, display, wf_all);
    struct gp_picture pic;
    float to[2][4][4];
    const struct gp_picture_form samples = {.bytes = 4, .to = to};
    p.alpha = GP_ALPHA_KEEP;
    assert_ok(gp_picture_make(&(struct gp_picture_job) {&kept_all, &p, "p", &f,
                                                        &f.rgb,
                                                        GP_PICTURE_SCENE, NULL},
                              &pic));
    assert_int_equal(pic.channels, 4);
    memset(to, 0xff, sizeof to);
    assert_ok(gp_picture_samples(&kept_all, &pic, &samples));
    for (int y = 0; y < 2; y++) {
        for (int c = 0; c < 4; c++) {
            const int number = c < 3 ? c : 0; // alpha is channel 0 of the list
            assert_true(to[y][0][c] == 0.0f && to[y][3][c] == 0.0f);
            for (int x = 0; x < 2; x++)
                assert_true(to[y][1 + x][c] == wf_value(number, x, y));
        }
    }
    gp_picture_free(&pic);
    gp_frame_free(&f);
}

/* Of 8 and of 16 bits; dithered. */
static const struct gp_quantizer quantizer[2] = {{255, true, false},
                                                 {65535, true, false}};
static const struct gp_quantizer dither[2] = {{255, true, true},
                                              {65535, true, true}};
static const int largest[2] = {255, 65535};

/* Codes of 8 bits, with the curve and without. */
static void codes_of_single_values(void **state)
{
    static const struct {
        float v;
        int code, linear;
    } rows[] = {
        {0.0f, 0, 0}, {-0.0f, 0, 0}, {-1.0f, 0, 0}, {NAN, 0, 0}, {-NAN, 0, 0},
        {INFINITY, 255, 255}, {-INFINITY, 0, 0}, {1.0f, 255, 255},
        {1e30f, 255, 255}, {0x1p-149f, 0, 0}, {1.0f - 0x1p-24f, 255, 255},
        {0.5f, 188, 128}, {0.2158605f, 128, 55}, {0.1f, 89, 26},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint16_t code, linear, dithered;
        gp_quantize(&quantizer[0], &rows[i].v, 0, 0, &code, 1);
        gp_quantize(&(struct gp_quantizer) {.max = 255}, &rows[i].v, 0, 0,
                    &linear, 1);
        assert_int_equal(code, rows[i].code);
        assert_int_equal(linear, rows[i].linear);
        gp_quantize(&dither[0], &rows[i].v, (int) i, 7, &dithered, 1);
        assert_in_range(dithered, code ? code - 1 : 0,
                        code < 255 ? code + 1 : 255);
        if (code == 0 && !(rows[i].v > 0.0f))
            assert_int_equal(dithered, 0);
        if (rows[i].v >= 1.0f)
            assert_int_equal(dithered, 255);
    }
}

/* The mean over an area is the value; each code is one of its neighbours;
 * the code depends on the place alone, whatever the row was cut into. */
static void dither_laws(void **state)
{
    enum { W = 256, H = 256 };
    static const float value[] = {0.00002f, 0.0005f, 0.0021f, 0.013f, 0.18f,
                                  0.5f, 0.731f, 0.95f, 0.9999f};
    for (size_t k = 0; k < 2 * COUNT(value); k++) {
        static float row[W];
        static uint16_t code[W], piece[W];
        const struct gp_quantizer *const q = &dither[k % 2];
        const double want = (double) gp_srgb_encode(value[k / 2]) *
                            largest[k % 2];
        double sum = 0;
        for (int x = 0; x < W; x++)
            row[x] = value[k / 2];
        for (int y = 0; y < H; y++) {
            gp_quantize(q, row, 5, y, code, W);
            for (int x = 0; x < W; x++) {
                assert_in_range(code[x], floor(want - 0.05),
                                floor(want + 1.05));
                sum += code[x];
            }
            gp_quantize(q, row, 5 + 37, y, piece, W - 37);
            assert_memory_equal(piece, code + 37, (W - 37) * sizeof *code);
        }
        // 65536 places of a good noise: far below one in a hundred
        assert_true(fabs(sum / (W * H) - want) < (k % 2 ? 3e-2 : 2e-3));
    }
}

SUITE_OF(picture, NULL, NULL, windows_that_are_no_picture,
         floats_with_alpha, codes_of_single_values, dither_laws)
