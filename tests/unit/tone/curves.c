// SPDX-License-Identifier: Apache-2.0
/* tone/curves.c: every operator against its equation as printed, in
 * double; laws that all must keep. */
#include "unit.h"
#include "tone_forms.h"
#include "tone/tone.h"

#include <float.h>

static void map_one(const char *name, const float in[3], float white,
                    float out[3])
{
    memcpy(out, in, 3 * sizeof *out);
    gp_tone_find(name)->map(&out[0], &out[1], &out[2], 1, white);
}

static void operators_are_their_equations(void **state)
{
    enum { N = 4001 }; // odd, so that vector loops have a rest
    static float v[3][N], in[3][N];
    for (size_t k = 0; k < COUNT(references); k++) {
        seed = 7;
        for (int i = 0; i < N; i++) {
            double level = exp2(40.0 * noise() - 20.0);
            for (int c = 0; c < 3; c++) {
                // grey, coloured and with channels that are zero
                double tint = i % 3 == 0 ? 1.0 : i % 3 == 1 ? noise()
                                                 : noise() < 0.5;
                in[c][i] = v[c][i] = (float) (level * tint);
            }
        }
        gp_tone_find(references[k].name)->map(v[0], v[1], v[2], N, 4.0f);
        for (int i = 0; i < N; i++) {
            double x[3], want[3];
            for (int c = 0; c < 3; c++)
                x[c] = (double) in[c][i];
            references[k].map(x, 4.0, want);
            for (int c = 0; c < 3; c++) {
                if (!(fabs((double) v[c][i] - want[c]) <=
                      references[k].tolerance))
                    fail_msg("%s: channel %d of %g %g %g is %.9g, not %.9g",
                             references[k].name, c, x[0], x[1], x[2],
                             (double) v[c][i], want[c]);
            }
        }
    }
}

/* Black is deep: the same again, relative, where the result is small. */
static void dark_light_keeps_its_digits(void **state)
{
    static const char *const names[] = {
        "reinhard", "reinhard-extended", "hable", "neutral", "linear",
    };
    for (size_t k = 0; k < COUNT(names); k++) {
        size_t r = 0;
        while (strcmp(references[r].name, names[k]) != 0)
            r++;
        for (int i = 0; i < 400; i++) {
            float v = (float) exp2(-30.0 + 0.07 * i), in[3] = {v, v, v}, out[3];
            double x[3] = {(double) v, (double) v, (double) v}, want[3];
            map_one(names[k], in, 4.0f, out);
            references[r].map(x, 4.0, want);
            if (want[0] > 1e-9 && want[0] < 0.1)
                assert_true(fabs((double) out[0] / want[0] - 1.0) <
                            1e-6 + 1e-16 / want[0]);
        }
    }
}

static void published_points(void **state)
{
    static const struct {
        const char *name;
        float white, in[3];
        double out[3], tolerance;
    } rows[] = {
        {"reinhard", 0, {1, 1, 1}, {0.5, 0.5, 0.5}, 1e-7},
        {"reinhard", 0, {0.18f, 0.18f, 0.18f}, {0.1525424, 0.1525424,
         0.1525424}, 1e-7},
        // "maps L_white to 1", and 1 to (1 + 1 / 4) / 2
        {"reinhard-extended", 7, {7, 7, 7}, {1, 1, 1}, 2e-7},
        {"reinhard-extended", 2, {1, 1, 1}, {0.625, 0.625, 0.625}, 1e-7},
        {"reinhard-extended", 1e9f, {1, 1, 1}, {0.5, 0.5, 0.5}, 1e-7},
        // the white of the source, under its exposure bias
        {"hable", 0, {5.6f, 5.6f, 5.6f}, {1, 1, 1}, 2e-7},
        // "c_out = c_in - F_90 for 0.08 <= R, G, B <= 0.8"
        {"neutral", 0, {0.08f, 0.5f, 0.8f}, {0.04, 0.46, 0.76}, 1e-7},
        {"neutral", 0, {0.3f, 0.2f, 0.1f}, {0.26, 0.16, 0.06}, 1e-7},
        {"neutral", 0, {0, 0.5f, 0.7f}, {0, 0.5, 0.7}, 1e-7},
        // mid grey of the source, 0.18, lies at 10 / 16.5 of the curve
        {"agx", 0, {0.18f, 0.18f, 0.18f}, {0.18, 0.18, 0.18}, 0.04},
        {"linear", 0, {0.25f, 1.5f, -1}, {0.25, 1, 0}, 0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        float out[3];
        map_one(rows[i].name, rows[i].in, rows[i].white, out);
        for (int c = 0; c < 3; c++) {
            if (!(fabs((double) out[c] - rows[i].out[c]) <= rows[i].tolerance))
                fail_msg("%s row %zu channel %d is %.9g", rows[i].name, i, c,
                         (double) out[c]);
        }
    }
}

static void grey_ramps_rise(void **state)
{
    enum { N = 60000 };
    static float v[3][N];
    for (const struct gp_tone_curve *const *c = gp_tone_curves; *c; c++) {
        if (!(*c)->map)
            continue;
        v[0][0] = 0.0f; // then 1e-9 to 1e9
        for (int i = 1; i < N; i++)
            v[0][i] = (float) pow(10.0, -9.0 + 18.0 * i / (N - 1));
        memcpy(v[1], v[0], sizeof v[0]);
        memcpy(v[2], v[0], sizeof v[0]);
        (*c)->map(v[0], v[1], v[2], N, 100.0f);
        for (int k = 0; k < 3; k++) {
            assert_true(v[k][0] == 0.0f && v[k][N - 1] > 0.99f);
            for (int i = 1; i < N; i++) {
                // rounding: of the value, and of agx before it is near 0
                float floor = v[k][i - 1] * (1.0f - 8 * FLT_EPSILON) - 1e-12f;
                if (!(v[k][i] >= floor))
                    fail_msg("%s falls at step %d: %.9g, then %.9g", (*c)->name,
                             i, (double) v[k][i - 1], (double) v[k][i]);
            }
        }
    }
}

/* In [0, 1], and black without any light. */
static void output_is_always_in_range(void **state)
{
    static const float hard[] = {
        0.0f, -0.0f, 1e-45f, -1e-45f, FLT_MIN, 1e-20f, 0.18f, 1.0f, -1.0f,
        65504.0f, -65504.0f, 1e9f, 1e19f, -1e19f, FLT_MAX, -FLT_MAX, INFINITY,
        -INFINITY, NAN,
    };
    static const float whites[] = {FLT_MIN, 1e-3f, 1.0f, 1e9f, FLT_MAX};
    enum { H = COUNT(hard), N = H * H * H };
    static float v[3][N];
    for (const struct gp_tone_curve *const *c = gp_tone_curves; *c; c++) {
        for (size_t w = 0; (*c)->map && w < COUNT(whites); w++) {
            for (size_t i = 0; i < N; i++) {
                v[0][i] = hard[i % H];
                v[1][i] = hard[i / H % H];
                v[2][i] = hard[i / H / H];
            }
            (*c)->map(v[0], v[1], v[2], N, whites[w]);
            for (size_t i = 0; i < N; i++) {
                const bool lit = hard[i % H] > 0.0f || hard[i / H % H] > 0.0f ||
                                 hard[i / H / H] > 0.0f;
                for (int k = 0; k < 3; k++) {
                    if (!(v[k][i] >= 0.0f && v[k][i] <= (lit ? 1.0f : 0.0f)))
                        fail_msg("%s of %g %g %g, white %g: %g", (*c)->name,
                                 (double) hard[i % H], (double) hard[i / H % H],
                                 (double) hard[i / H / H], (double) whites[w],
                                 (double) v[k][i]);
                }
            }
        }
    }
}

static void reinhard_keeps_luminance_and_hue(void **state)
{
    static const float tints[][3] = {
        {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0.5f, 0}, {0.2f, 0.1f, 0.9f},
    };
    for (size_t i = 0; i < COUNT(tints); i++) {
        for (int ev = -10; ev <= 20; ev++) {
            float in[3], out[3];
            double x[3], got[3];
            for (int c = 0; c < 3; c++) {
                in[c] = ldexpf(tints[i][c], ev);
                x[c] = (double) in[c];
            }
            map_one("reinhard", in, 1.0f, out);
            for (int c = 0; c < 3; c++)
                got[c] = (double) out[c];
            double y = luminance(x);
            assert_true(fabs(luminance(got) - y / (1.0 + y)) < 2e-7);
            // hue: the direction away from the grey axis
            double spread = x[0] + x[1] - 2.0 * x[2];
            double got_spread = got[0] + got[1] - 2.0 * got[2];
            assert_true(fabs((got[0] - got[1]) * spread - (x[0] - x[1]) *
                             got_spread) <= 1e-6 * fabs(spread));
        }
    }
}

SUITE_OF(curves, NULL, NULL, operators_are_their_equations,
         dark_light_keeps_its_digits, published_points, grey_ramps_rise,
         output_is_always_in_range, reinhard_keeps_luminance_and_hue)
