// SPDX-License-Identifier: Apache-2.0
/* The tone curves as their sources print them, in double. A curve of
 * gp_tone_curves needs a row in `references`; its tests follow from that. */
#ifndef GP_TESTS_TONE_FORMS_H
#define GP_TESTS_TONE_FORMS_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

static inline double luminance(const double c[3])
{
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

static unsigned seed __attribute__((unused)) = 1;

static inline double noise(void) // of [0, 1)
{
    seed = seed * 1664525u + 1013904223u;
    return (double) (seed >> 8) / 16777216.0;
}

// -- the printed equations, for colours >= 0 ----------------------------------

static inline void multiply(const double m[9], const double in[3],
                            double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[3 * i] * in[0] + m[3 * i + 1] * in[1] + m[3 * i + 2] * in[2];
}

/* tone/curves.c says how a colour that does not fit is treated: it moves to
 * the grey of its luminance, here found by bisection. */
static inline void scale_and_fit(const double in[3], double displayed,
                                 double out[3])
{
    double y = luminance(in), lo = 0.0, hi = 1.0;
    displayed = fmin(displayed, 1.0);
    for (int step = 0; step < 60; step++) {
        double keep = step ? 0.5 * (lo + hi) : 1.0, top = 0.0;
        for (int c = 0; c < 3; c++) {
            double v = y > 0.0 ? in[c] * displayed / y : 0.0;
            out[c] = displayed + keep * (v - displayed);
            top = fmax(top, out[c]);
        }
        if (top <= 1.0 + 1e-12) {
            lo = keep;
            if (!step)
                break;
        } else {
            hi = keep;
        }
    }
}

static inline void ref_reinhard(const double in[3], double white, double out[3])
{
    double y = luminance(in);
    (void) white;
    scale_and_fit(in, y / (1.0 + y), out);
}

static inline void ref_extended(const double in[3], double white, double out[3])
{
    double y = luminance(in);
    scale_and_fit(in, y * (1.0 + y / (white * white)) / (1.0 + y), out);
}

static inline void ref_aces(const double in[3], double white, double out[3])
{
    static const double to[9] = {
        0.59719, 0.35458, 0.04823, 0.07600, 0.90834,
        0.01566, 0.02840, 0.13383, 0.83777,
    };
    static const double back[9] = {
        1.60475,  -0.53108, -0.07367, -0.10208, 1.10813,
        -0.00605, -0.00327, -0.07276, 1.07602,
    };
    double v[3];
    (void) white;
    multiply(to, in, v);
    for (int c = 0; c < 3; c++)
        v[c] = fmax(v[c], 0.0);
    for (int c = 0; c < 3; c++)
        v[c] = (v[c] * (v[c] + 0.0245786) - 0.000090537) /
               (v[c] * (0.983729 * v[c] + 0.4329510) + 0.238081);
    multiply(back, v, out);
    for (int c = 0; c < 3; c++)
        out[c] = fmin(fmax(out[c], 0.0), 1.0);
}

static inline double uncharted2(double x)
{
    const double A = 0.15, B = 0.50, C = 0.10, D = 0.20, E = 0.02, F = 0.30;
    return ((x * (A * x + C * B) + D * E) / (x * (A * x + B) + D * F)) - E / F;
}

static inline void ref_hable(const double in[3], double white, double out[3])
{
    (void) white;
    for (int c = 0; c < 3; c++)
        out[c] = fmin(uncharted2(2.0 * in[c]) / uncharted2(11.2), 1.0);
}

static inline void ref_agx(const double in[3], double white, double out[3])
{
    static const double inset[9] = {
        0.842479062253094,  0.0784335999999992, 0.0792237451477643,
        0.0423282422610123, 0.878468636469772,  0.0791661274605434,
        0.0423756549057051, 0.0784336,          0.879142973793104,
    };
    static const double outset[9] = {
        1.19687900512017,    -0.0980208811401368, -0.0990297440797205,
        -0.0528968517574562, 1.15190312990417,    -0.0989611768448433,
        -0.0529716355144438, -0.0980434501171241, 1.15107367264116,
    };
    double v[3];
    (void) white;
    multiply(inset, in, v);
    for (int c = 0; c < 3; c++) {
        double x = fmin(fmax(log2(v[c]), -12.47393), 4.026069);
        x = (x + 12.47393) / (4.026069 + 12.47393);
        v[c] = 15.5 * pow(x, 6) - 40.14 * pow(x, 5) + 31.96 * pow(x, 4) -
               6.868 * pow(x, 3) + 0.4298 * x * x + 0.1191 * x - 0.00232;
    }
    multiply(outset, v, out);
    for (int c = 0; c < 3; c++)
        out[c] = pow(fmin(fmax(out[c], 0.0), 1.0), 2.2);
}

static inline void ref_neutral(const double in[3], double white, double out[3])
{
    const double f90 = 0.04, ks = 0.8 - f90, kd = 0.15;
    double x = fmin(in[0], fmin(in[1], in[2]));
    double f = x <= 2.0 * f90 ? x - x * x / (4.0 * f90) : f90;
    double p = fmax(in[0], fmax(in[1], in[2])) - f;
    double pn = 1.0 - (1.0 - ks) * (1.0 - ks) / (p + 1.0 - 2.0 * ks);
    double g = 1.0 / (kd * (p - pn) + 1.0);
    (void) white;
    for (int c = 0; c < 3; c++)
        out[c] = p <= ks ? in[c] - f : (in[c] - f) * pn / p * g + pn * (1 - g);
}

static inline void ref_linear(const double in[3], double white, double out[3])
{
    (void) white;
    for (int c = 0; c < 3; c++)
        out[c] = fmin(in[c], 1.0);
}

static const struct tone_form {
    const char *name;
    void (*map)(const double in[3], double white, double out[3]);
    double tolerance; // absolute, of a display whose white is 1
    bool wide;        // mixes into wider primaries before negative light is cut
} references[] = {
    {"reinhard", ref_reinhard, 1e-6, false},
    {"reinhard-extended", ref_extended, 1e-6, false},
    {"aces", ref_aces, 1e-6, true},
    {"hable", ref_hable, 1e-6, false},
    {"agx", ref_agx, 2e-6, true},
    {"neutral", ref_neutral, 1e-6, false},
    {"linear", ref_linear, 0.0, false},
};
enum { TONE_FORMS = sizeof references / sizeof *references };

/* Returns the row of a curve; NULL for `none`, and for one that has no row. */
static inline const struct tone_form *tone_form_of(const char *curve)
{
    for (size_t i = 0; i < TONE_FORMS; i++) {
        if (strcmp(references[i].name, curve) == 0)
            return &references[i];
    }
    return NULL;
}

#endif
