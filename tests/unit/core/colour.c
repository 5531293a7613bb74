// SPDX-License-Identifier: Apache-2.0
/* core/colour.c against the numbers that standards print. */
#include "unit.h"
#include "core/colour.h"

static const float D65[2] = {0.3127f, 0.3290f};

static void assert_near(double got, double want, double tolerance)
{
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%.9g, not %.9g within %g", got, want, tolerance);
}

static void weights_are_the_published_ones(void **state)
{
    static const struct { float ch[8]; double weight[3], tolerance; } rows[] = {
        // ITU-R BT.2020-2, table 4
        {{0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f},
         {0.2627, 0.6780, 0.0593}, 6e-5},
        // SMPTE RP 431-2 primaries with D65
        {{0.680f, 0.320f, 0.265f, 0.690f, 0.150f, 0.060f, 0.3127f, 0.3290f},
         {0.2289746, 0.6917385, 0.0792869}, 2e-6},
        // AP0, SMPTE ST 2065-1
        {{0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.077f, 0.32168f, 0.33767f},
         {0.3439664498, 0.7281660966, -0.0721325464}, 2e-6},
        // AP1, Academy S-2014-004
        {{0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f},
         {0.2722287168, 0.6740817658, 0.0536895174}, 2e-6},
        // CIE XYZ as primaries: Y alone is luminance
        {{1, 0, 0, 1, 0, 0, 1.0f / 3, 1.0f / 3}, {0, 1, 0}, 1e-6},
        // EBU Tech 3213 (PAL)
        {{0.64f, 0.33f, 0.29f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f},
         {0.2220, 0.7067, 0.0713}, 6e-5},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        float w[3];
        gp_luminance_weights(rows[i].ch, w);
        for (int c = 0; c < 3; c++)
            assert_near((double) w[c], rows[i].weight[c], rows[i].tolerance);
        assert_near((double) w[0] + (double) w[1] + (double) w[2], 1.0, 1e-6);
    }
}

static void bt709_is_exactly_what_papers_print(void **state)
{
    float w[3];
    gp_luminance_weights(gp_rec709_chromaticities, w);
    assert_memory_equal(w, gp_rec709_luminance, sizeof w);
    assert_memory_equal(gp_rec709_chromaticities + 6, D65, sizeof D65);
}

static void matrix_is_that_of_the_standard(void **state)
{
    // IEC 61966-2-1 prints 4 digits; these are RP 177 carried further
    static const double want[9] = {
        0.4123908, 0.3575843, 0.1804808, 0.2126390, 0.7151687,
        0.0721923, 0.0193308, 0.1191948, 0.9505322,
    };
    double m[9];
    assert_true(gp_rgb_to_xyz(gp_rec709_chromaticities, m));
    for (int i = 0; i < 9; i++)
        assert_near(m[i], want[i], 1e-6);
}

/* White goes to white, ACES to BT.709 as ACES prints it (with Bradford), there
 * and back is the same. */
static void primaries_to_primaries(void **state)
{
    static const float ap0[8] = {0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f,
                                 0.32168f, 0.33767f};
    static const float flat[8] = {0.3f, 0.3f, 0.3f, 0.3f,
                                  0.3f, 0.3f, 0.3f, 0.3f};
    static const double want[9] = {
        2.52169, -1.13413, -0.38756, -0.27648, 1.37272, -0.09624, -0.01538,
        -0.15298, 1.16835,
    };
    double m[9], back[9], unit[9];
    assert_true(gp_rgb_to_rgb(ap0, gp_rec709_chromaticities, m));
    assert_true(gp_rgb_to_rgb(gp_rec709_chromaticities, ap0, back));
    gp_multiply3(m, back, unit);
    for (int i = 0; i < 9; i++) {
        assert_near(m[i], want[i], 1e-4);
        assert_near(unit[i], i % 4 == 0, 1e-12);
        assert_near(m[i / 3 * 3] + m[i / 3 * 3 + 1] + m[i / 3 * 3 + 2], 1.0,
                    1e-12);
    }
    // values of CIE XYZ, whose white is D65: no adaptation to BT.709, that of
    // D65 to ACES
    static const float cie[8] = {1, 0, 0, 1, 0, 0, 0.333333f, 0.333333f};
    double xyz[9], to_ap0[9];
    assert_true(gp_rgb_to_xyz(gp_rec709_chromaticities, xyz));
    assert_true(gp_rgb_to_rgb(gp_rec709_chromaticities, cie, m));
    assert_true(gp_rgb_to_rgb(cie, ap0, to_ap0));
    gp_multiply3(to_ap0, xyz, unit);
    for (int i = 0; i < 9; i++) {
        assert_near(m[i], xyz[i], 1e-4);
        assert_near(unit[i], back[i], 1e-4);
    }
    assert_false(gp_rgb_to_rgb(flat, ap0, m));
    assert_false(gp_rgb_to_rgb(ap0, flat, m));
}

/* A sum of a spectrum's bands in one frame's primaries becomes that in
 * another's. */
static void spectra_to_other_primaries(void **state)
{
    enum { BANDS = 40 };
    static const float all[][8] = {
        {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f},
        {0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f},
        {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f},
        {1, 0, 0, 1, 0, 0, 1.0f / 3, 1.0f / 3},
    };
    static const float flat[8] = {0.3f, 0.3f, 0.3f, 0.3f,
                                  0.3f, 0.3f, 0.3f, 0.3f};
    double m[9], nm[BANDS], colour[2][BANDS][3];
    for (size_t i = 0; i < COUNT(all) * COUNT(all); i++) {
        const float *const from = all[i / COUNT(all)];
        const float *const to = all[i % COUNT(all)];
        assert_true(gp_spectrum_to_spectrum(from, to, m));
        gp_spectrum_colours(from, BANDS, nm, colour[0]);
        gp_spectrum_colours(to, BANDS, nm, colour[1]);
        for (int b = 0; b < BANDS; b++) {
            const double *const v = colour[0][b];
            for (int c = 0; c < 3; c++)
                assert_near(m[3 * c] * v[0] + m[3 * c + 1] * v[1] +
                            m[3 * c + 2] * v[2], colour[1][b][c], 1e-12);
        }
        for (int c = 0; c < 3; c++)
            assert_near(m[3 * c] + m[3 * c + 1] + m[3 * c + 2], 1.0, 1e-12);
    }
    assert_false(gp_spectrum_to_spectrum(flat, all[0], m));
    assert_false(gp_spectrum_to_spectrum(all[0], flat, m));
}

static void white_has_luminance_one(void **state)
{
    float ch[8];
    double m[9];
    memcpy(ch, gp_rec709_chromaticities, sizeof ch);
    for (int i = 0; i < 20; i++) { // whites from blue to amber
        ch[6] = 0.25f + 0.01f * (float) i;
        ch[7] = 0.26f + 0.008f * (float) i;
        assert_true(gp_rgb_to_xyz(ch, m));
        double x = m[0] + m[1] + m[2], y = m[3] + m[4] + m[5];
        double z = m[6] + m[7] + m[8];
        assert_near(y, 1.0, 1e-12);
        assert_near(x / (x + y + z), (double) ch[6], 1e-12);
        assert_near(y / (x + y + z), (double) ch[7], 1e-12);
    }
}

static void degenerate_primaries_count_as_bt709(void **state)
{
    static const float rows[][8] = {
        {0, 0, 0, 0, 0, 0, 0, 0},
        {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.0f},
        {NAN, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f},
        {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, INFINITY, 0.3127f, 0.3290f},
        {0.64f, 0.33f, 0.64f, 0.33f, 0.15f, 0.06f, 0.3127f, 0.3290f}, // equal
        {0.2f, 0.2f, 0.3f, 0.3f, 0.4f, 0.4f, 0.3127f, 0.3290f}, // on a line
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        float w[3] = {9, 9, 9};
        double m[9] = {7};
        assert_false(gp_rgb_to_xyz(rows[i], m));
        assert_true(m[0] == 7.0);
        gp_luminance_weights(rows[i], w);
        assert_memory_equal(w, gp_rec709_luminance, sizeof w);
    }
}

static void srgb_points(void **state)
{
    static const struct { float linear, encoded, tolerance; } rows[] = {
        {0.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 0.0f},
        {0.0031308f, 0.0404500f, 1e-6f}, // the line meets the power there
        {0.18f, 0.4613561f, 1e-6f}, {0.2140411f, 0.5f, 1e-6f},
        {0.001f, 0.01292f, 1e-7f},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        double tolerance = (double) rows[i].tolerance;
        assert_near((double) gp_srgb_encode(rows[i].linear),
                    (double) rows[i].encoded, tolerance);
        assert_near((double) gp_srgb_decode(rows[i].encoded),
                    (double) rows[i].linear, tolerance);
    }
}

static void srgb_clamps(void **state)
{
    static const float low[] = {-1.0f, -0.0f, -INFINITY, NAN, -1e-45f};
    static const float high[] = {1.0000001f, 65504.0f, INFINITY};
    for (size_t i = 0; i < COUNT(low); i++) {
        assert_true(gp_srgb_encode(low[i]) == 0.0f);
        assert_true(gp_srgb_decode(low[i]) == 0.0f);
    }
    for (size_t i = 0; i < COUNT(high); i++) {
        assert_true(gp_srgb_encode(high[i]) == 1.0f);
        assert_true(gp_srgb_decode(high[i]) == 1.0f);
    }
    assert_true(gp_srgb_encode(1e-40f) > 0.0f); // a denormal is light
}

static void srgb_goes_and_comes_back(void **state)
{
    float last = -1.0f;
    for (int i = 0; i <= 65535; i++) {
        float encoded = (float) i / 65535.0f;
        float linear = gp_srgb_decode(encoded);
        assert_true(linear > last);
        last = linear;
        float back = gp_srgb_encode(linear) * 65535.0f;
        assert_int_equal(lrintf(back), i);
    }
}

SUITE_OF(colour, NULL, NULL, weights_are_the_published_ones,
         bt709_is_exactly_what_papers_print, matrix_is_that_of_the_standard,
         primaries_to_primaries, spectra_to_other_primaries,
         white_has_luminance_one,
         degenerate_primaries_count_as_bt709,
         srgb_points, srgb_clamps, srgb_goes_and_comes_back)
