/* Functions with a plain form: a table of pairs, which proves that they agree,
 * and times them, on the same generated frames.
 *
 *   build/tests/ROOM pairs                 proves all
 *   build/tests/ROOM pairs --time [NAME]   times those whose name begins so;
 *                                          GLAREPP_TIME proves and times
 *   GLAREPP_SEED=N   another seed; failures print the one they had
 *
 * Times are printed, never asserted. */
#ifndef PAIRS_H
#define PAIRS_H

#include "unit.h"
#include "core/clock.h"
#include "core/colour.h"
#include "core/frame.h"

#include <float.h>

#define PAIR_KINDS(X)                                                         \
    X(PAIR_UNIFORM, "uniform in [0, 2)")                                      \
    X(PAIR_NEAR_ZERO, "near 0")                                               \
    X(PAIR_DENORMAL, "denormals")                                             \
    X(PAIR_NEAR_MAX, "near the maximum")                                      \
    X(PAIR_HOT, "one hot pixel")                                              \
    X(PAIR_SPRINKLED, "NaN, Inf and negative values sprinkled")
#define PAIR_ENUM(name, text) name,
#define PAIR_TEXT(name, text) text,
enum pair_kind { PAIR_KINDS(PAIR_ENUM) PAIR_KIND_COUNT };
static const char *const pair_text[] = {PAIR_KINDS(PAIR_TEXT)};

struct pair {
    const char *name;
    float max;    // bound of "near the maximum" and of the hot pixel
    double bar;   // of |fast - reference|_2 / |reference|_2; 0: equal samples
    double lost;  // differences up to this are none: underflow
    int w, h;     // of the frame that is timed
    bool gl;      // needs a context
    const void *how; // settings, for open()

    /* Makes all that both forms need of the frame, which it takes. */
    void *(*open)(const struct pair *pair, struct gp_frame f);
    void (*reference)(void *ctx, double *out); // 3 * w * h samples
    void (*fast)(void *ctx, float *out);
    void (*close)(void *ctx);
};

/* In [0, 1). */
static inline float pair_random(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (float) (*seed >> 8) * 0x1p-24f;
}

static inline struct gp_frame pair_frame(int w, int h, enum pair_kind kind,
                                         float max, uint32_t seed)
{
    static const float bad[] = {
        NAN, INFINITY, -INFINITY, -1.0f, FLT_MAX, -FLT_MAX, -0.0f, 1e-42f,
    };
    struct gp_frame f = gp_frame_blank((struct gp_rect) {0, 0, w, h});
    assert_ok(gp_planes_make(NULL, "rgb", (size_t) w * (size_t) h, &f.rgb));
    for (int i = 0; i < 3 * w * h; i++) {
        const int at = i % (w * h);
        const float u = pair_random(&seed);
        float v = 2.0f * u;
        if (kind == PAIR_NEAR_ZERO)
            v = FLT_MIN * (1.0f + 1e6f * u);
        else if (kind == PAIR_DENORMAL)
            v = FLT_MIN * u;
        else if (kind == PAIR_NEAR_MAX)
            v = max * (1.0f - 0.01f * u);
        else if (kind == PAIR_HOT)
            v = at == w * h / 2 ? max : 1e-3f * (1.0f + u);
        else if (kind == PAIR_SPRINKLED && at % 13 == 5)
            v = bad[at / 13 % 8];
        f.rgb.c[i / (w * h)][at] = v;
    }
    return f;
}

/* Proves one pair on one frame; or, when `timed`, prints how long the forms
 * take at best. */
static inline void pair_run(const struct pair *p, int w, int h,
                            enum pair_kind kind, uint32_t seed, bool timed)
{
    const size_t n = 3 * (size_t) w * (size_t) h;
    double *const want = calloc(n, sizeof *want);
    float *const got = calloc(n, sizeof *got);
    assert_true(want && got);
    double slow = INFINITY, fast = INFINITY, wrong = 0.0, all = 0.0;
    memset(got, 0xff, n * sizeof *got); // every sample must be written
    void *const ctx = p->open(p, pair_frame(w, h, kind, p->max, seed));
    for (int i = 0; i < (timed ? 5 : 1); i++) {
        const double start = gp_now_ms();
        p->reference(ctx, want);
        const double between = gp_now_ms();
        p->fast(ctx, got);
        slow = fmin(slow, between - start);
        fast = fmin(fast, gp_now_ms() - between);
    }
    p->close(ctx);
    for (size_t i = 0; i < n; i++) {
        const double d = fabs((double) got[i] - want[i]);
        wrong += d <= p->lost ? 0.0 : d * d;
        all += want[i] * want[i];
    }
    const double error = wrong == 0.0 ? 0.0 : sqrt(wrong / all);
    if (timed)
        printf("%s: %dx%d, %s, seed %u: reference %.3f ms, fast %.3f ms, "
               "%.1f times\n", p->name, w, h, pair_text[kind], seed, slow, fast,
               slow / fast);
    if (!timed && !(error <= p->bar))
        fail_msg("%s: %dx%d, %s, GLAREPP_SEED=%u: %g over %g", p->name, w, h,
                 pair_text[kind], seed, error, p->bar);
    free(want);
    free(got);
}

static inline uint32_t pair_seed(void)
{
    const char *const s = getenv("GLAREPP_SEED");
    return s ? (uint32_t) strtoul(s, NULL, 10) : 20071u;
}

/* Proves n pairs at odd and at whole sizes on frames of all kinds. */
static inline void pairs_prove(const struct pair *pairs, size_t n, bool gl)
{
    static const int sizes[][2] = {
        {1, 1}, {1, 37}, {41, 1}, {2, 3}, {31, 17}, {32, 16}, {33, 65},
        {97, 53},
    };
    for (size_t i = 0; i < n * COUNT(sizes); i++) {
        const struct pair *const p = &pairs[i / COUNT(sizes)];
        const size_t at = i % COUNT(sizes);
        for (int kind = 0; kind < PAIR_KIND_COUNT; kind++) {
            if (!p->gl || gl)
                pair_run(p, sizes[at][0], sizes[at][1], (enum pair_kind) kind,
                         pair_seed() + (uint32_t) at, false);
        }
    }
}

/* Times the pairs that a suite's arguments or GLAREPP_TIME ask for. Returns
 * true where the arguments ask for nothing else. */
static inline bool pairs_time(const struct pair *pairs, size_t n, bool gl,
                              int argc, char **argv)
{
    const bool only_time = argc > 1 && strcmp(argv[1], "--time") == 0;
    const char *const name = argc > 2 ? argv[2] : "";
    for (size_t i = 0; i < n; i++) {
        const struct pair *const p = &pairs[i];
        if ((only_time || getenv("GLAREPP_TIME")) && (gl || !p->gl) &&
            strncmp(p->name, name, strlen(name)) == 0)
            pair_run(p, p->w, p->h, PAIR_UNIFORM, pair_seed(), true);
    }
    return only_time;
}

#endif
