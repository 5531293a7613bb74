/* The pair harness: a reference and a fast form of the same thing run on the
 * same generated frames; it proves that they agree, and with --time in the
 * arguments (or GLAREPP_TIME in the environment) times both. A room's pairs are
 * one table (tests/unit/ROOM/pairs.c).
 *
 *   GLAREPP_SEED=N   another seed; failures print the one they had
 *
 * Times are printed, never asserted. */
#ifndef GP_TESTS_PAIR_H
#define GP_TESTS_PAIR_H

#include "core/clock.h"
#include "unit.h"

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

/* A frame: three planes of w * h samples. */
struct pair_input {
    int w, h;
    enum pair_kind kind;
    uint32_t seed;
    float *rgb[3];
};

struct pair {
    const char *name;
    float max;    // what "near the maximum" and the hot pixel are near to
    double bar;   // of |fast - reference|_2 / |reference|_2; 0: equal samples
    double lost;  // differences up to this are none: underflow
    int w, h;     // of the frame that is timed
    bool gl;      // needs a context
    const void *how; // settings, for open()

    /* What both forms need beside the frame; `input` may be changed. */
    void *(*open)(const struct pair *pair, struct pair_input *input);
    void (*reference)(void *ctx, double *out); // 3 * w * h samples
    void (*fast)(void *ctx, float *out);
    void (*close)(void *ctx);
};

static inline uint32_t pair_seed(void)
{
    const char *const s = getenv("GLAREPP_SEED");
    return s ? (uint32_t) strtoul(s, NULL, 10) : 20071u;
}

/* In [0, 1). */
static inline float pair_random(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (float) (*seed >> 8) * 0x1p-24f;
}

static inline float pair_value(const struct pair_input *in, float max, int i,
                               uint32_t *seed)
{
    static const float bad[] = {
        NAN, INFINITY, -INFINITY, -1.0f, FLT_MAX, -FLT_MAX, -0.0f, 1e-42f,
    };
    const float u = pair_random(seed);
    switch (in->kind) {
    case PAIR_NEAR_ZERO:
        return FLT_MIN * (1.0f + 1e6f * u);
    case PAIR_DENORMAL:
        return FLT_MIN * u;
    case PAIR_NEAR_MAX:
        return max * (1.0f - 0.01f * u);
    case PAIR_HOT:
        return i == in->w * in->h / 2 ? max : 1e-3f * (1.0f + u);
    case PAIR_SPRINKLED:
        if (i % 13 == 5)
            return bad[i / 13 % 8];
        break;
    default:
        break;
    }
    return 2.0f * u;
}

static inline struct pair_input pair_make(int w, int h, enum pair_kind kind,
                                          float max, uint32_t seed)
{
    struct pair_input in = {.w = w, .h = h, .kind = kind, .seed = seed};
    for (int c = 0; c < 3; c++) {
        in.rgb[c] = calloc((size_t) w * (size_t) h, sizeof(float));
        if (!in.rgb[c])
            abort();
        for (int i = 0; i < w * h; i++)
            in.rgb[c][i] = pair_value(&in, max, i, &seed);
    }
    return in;
}

/* 0 when all is within the pair's bar, else how far off it is. */
static inline double pair_compare(const struct pair *p, const double *want,
                                  const float *got, size_t n)
{
    double wrong = 0.0, all = 0.0;
    for (size_t i = 0; i < n; i++) {
        const double d = fabs((double) got[i] - want[i]);
        const double scaled = d <= p->lost ? 0.0 : d;
        wrong += scaled * scaled;
        all += want[i] * want[i];
    }
    const double error = wrong > 0.0 || wrong != wrong ? sqrt(wrong / all)
                                                       : 0.0;
    return error <= p->bar ? 0.0 : error;
}

static inline void pair_check(const struct pair *p, int w, int h,
                              enum pair_kind kind, uint32_t seed)
{
    const size_t n = 3 * (size_t) w * (size_t) h;
    struct pair_input in = pair_make(w, h, kind, p->max, seed);
    double *const want = calloc(n, sizeof *want);
    float *const got = calloc(n, sizeof *got);
    if (!want || !got)
        abort();
    memset(got, 0xff, n * sizeof *got); // every sample must be written
    void *const ctx = p->open(p, &in);
    p->reference(ctx, want);
    p->fast(ctx, got);
    p->close(ctx);
    const double error = pair_compare(p, want, got, n);
    if (error != 0.0)
        fail_msg("%s: %dx%d, %s, GLAREPP_SEED=%u: %g over %g", p->name, w, h,
                 pair_text[kind], seed, error, p->bar);
    for (int c = 0; c < 3; c++)
        free(in.rgb[c]);
    free(want);
    free(got);
}

/* All kinds at odd and at whole sizes. */
static inline void pair_run(const struct pair *p)
{
    static const int sizes[][2] = {
        {1, 1}, {1, 37}, {41, 1}, {2, 3}, {31, 17}, {32, 16}, {33, 65},
        {97, 53},
    };
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        for (int kind = 0; kind < PAIR_KIND_COUNT; kind++)
            pair_check(p, sizes[i][0], sizes[i][1], (enum pair_kind) kind,
                       pair_seed() + (uint32_t) i);
    }
}

/* Least milliseconds of five runs of one form. */
static inline double pair_ms(const struct pair *p, void *ctx, double *want,
                             float *got)
{
    double best = INFINITY;
    for (int i = 0; i < 5; i++) {
        const double start = gp_now_ms();
        if (want)
            p->reference(ctx, want);
        else
            p->fast(ctx, got);
        best = fmin(best, gp_now_ms() - start);
    }
    return best;
}

/* Prints the times of both forms and their ratio at one size. */
static inline void pair_time(const struct pair *p, int w, int h,
                             enum pair_kind kind)
{
    const size_t n = 3 * (size_t) w * (size_t) h;
    struct pair_input in = pair_make(w, h, kind, p->max, pair_seed());
    double *const want = calloc(n, sizeof *want);
    float *const got = calloc(n, sizeof *got);
    if (!want || !got)
        abort();
    void *const ctx = p->open(p, &in);
    const double slow = pair_ms(p, ctx, want, NULL);
    const double fast = pair_ms(p, ctx, NULL, got);
    p->close(ctx);
    printf("%s: %dx%d, %s, seed %u: reference %.3f ms, fast %.3f ms, "
           "%.1f times\n", p->name, w, h, pair_text[kind], in.seed, slow, fast,
           slow / fast);
    for (int c = 0; c < 3; c++)
        free(in.rgb[c]);
    free(want);
    free(got);
}

/* Times the pairs whose name begins with the argument after --time, or all;
 * false where no times are asked for. */
static inline bool pair_time_table(const struct pair *p, size_t n, bool no_gl,
                                   int argc, char **argv)
{
    const bool asked = argc > 1 && strcmp(argv[1], "--time") == 0;
    const char *const name = argc > 2 ? argv[2] : "";
    for (size_t i = 0; (asked || getenv("GLAREPP_TIME")) && i < n; i++) {
        if (!strncmp(p[i].name, name, strlen(name)) && !(p[i].gl && no_gl))
            pair_time(&p[i], p[i].w, p[i].h, PAIR_UNIFORM);
    }
    return asked;
}

#endif
