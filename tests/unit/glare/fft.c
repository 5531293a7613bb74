/* The fft engine and its parts: lengths, passes, what it keeps, what it hands
 * to direct, and what it promises. */
#include "unit.h"
#include "glare/fft/fft.h"
#include "hard_cases.h"

#include <unistd.h>

/* -- lengths ----------------------------------------------------------------*/

static int is_smooth(int n)
{
    static const int primes[] = {2, 3, 5, 7};
    for (int i = 0; i < 4; i++) {
        while (n % primes[i] == 0)
            n /= primes[i];
    }
    return n == 1;
}

/* Fits, is one that the passes can take, and no other such is cheaper. */
static void lengths_are_the_cheapest(void **state)
{
    for (int n = 1; n < 20000; n += n < 3000 ? 1 : 37) {
        const int length = gp_fft_length(n);
        assert_true(length >= n && length % 8 == 0 && is_smooth(length));
        assert_true(gp_fft_cost(length, GP_FFT_PLAN_MEASURE) > 0.0);
        for (int m = n; m < 2 * n + 8; m++) {
            if (m % 8 == 0 && is_smooth(m) &&
                gp_fft_cost(m, GP_FFT_PLAN_MEASURE) <
                    gp_fft_cost(length, GP_FFT_PLAN_MEASURE))
                fail_msg("%d: %d is chosen, %d is cheaper", n, length, m);
        }
    }
    assert_int_equal(gp_fft_length(1), 8);
    assert_int_equal(gp_fft_length(16384), 16384);
}

/* -- passes -----------------------------------------------------------------*/

/* Rows of random numbers that the passes load, and what they store. */
struct rows {
    int nx, rows;
    float *in[3], *out[3];
};

static void load_row(const void *ctx, int c, int j, float *z)
{
    const struct rows *const r = ctx;
    for (int x = 0; x < r->nx; x++)
        z[2 * x] = r->in[c][(size_t) j * (size_t) r->nx + (size_t) x];
}

static void store_row(const void *ctx, int c, int j, const float *z)
{
    const struct rows *const r = ctx;
    for (int x = 0; x < r->nx; x++)
        r->out[c][(size_t) j * (size_t) r->nx + (size_t) x] = z[2 * x];
}

static struct rows make_rows(int nx, int rows, int room, uint32_t seed)
{
    struct rows r = {.nx = nx, .rows = rows};
    for (int c = 0; c < 3; c++) {
        r.in[c] = scene_alloc((size_t) nx * (size_t) rows, sizeof(float));
        r.out[c] = scene_alloc((size_t) nx * (size_t) room, sizeof(float));
        for (int i = 0; i < nx * rows; i++)
            r.in[c][i] = scene_random(&seed) - 0.5f;
    }
    return r;
}

static void free_rows(struct rows *r)
{
    for (int c = 0; c < 3; c++) {
        free(r->in[c]);
        free(r->out[c]);
    }
}

/* Twice the plain transform of a row, at frequency k. */
static void assert_spectrum(const struct rows *r, int c, int j, int k,
                            const float got[2])
{
    const double turn = 6.283185307179586 * k / r->nx;
    double re = 0.0, im = 0.0;
    for (int x = 0; x < r->nx; x++) {
        const double v = 2.0 * (double) r->in[c][j * r->nx + x];
        re += v * cos(turn * x);
        im -= v * sin(turn * x);
    }
    const double d = hypot((double) got[0] - re, (double) got[1] - im);
    if (!(d <= 4e-6 * sqrt(r->nx)))
        fail_msg("nx %d, row %d, column %d: %g off", r->nx, j, k, d);
}

struct pass_row {
    int nx, ny, rows, first, count, kernel_channels;
};

/* Output row j holds the input row that stands two rows above it, one column
 * to the right, or nothing. */
static void assert_moved(const struct pass_row *p, const struct rows *r,
                         const int *place)
{
    for (int i = 0; i < 3 * p->count * p->nx; i++) {
        const int c = i / (p->count * p->nx), j = i / p->nx % p->count;
        const int x = i % p->nx, at = (p->first + j + 2 * p->ny - 2) % p->ny;
        const float gain = p->kernel_channels == 1 ? 1.0f : (float) (1 << c);
        float want = 0.0f;
        for (int k = 0; k < p->rows; k++) {
            if (place[k] == at)
                want = gain * r->in[c][k * p->nx + (x + p->nx - 1) % p->nx];
        }
        if (!(fabsf(r->out[c][j * p->nx + x] - want) <= 4e-6f))
            fail_msg("%dx%d: channel %d, row %d, column %d: %g, not %g", p->nx,
                     p->ny, c, j, x, (double) r->out[c][j * p->nx + x],
                     (double) want);
    }
}

/* A kernel whose sample at (1, 2) alone is not 0 moves the rows by as much;
 * places and outputs go round the torus. */
static void check_passes(const struct pass_row *p)
{
    struct gp_fft_plan_pair x, y;
    struct gp_fft_matrix m, kernel_rows, kernel;
    int place[64];
    const int room = p->rows > p->count ? p->rows : p->count;
    struct rows r = make_rows(p->nx, p->rows, room, 77u);
    struct rows k = make_rows(p->nx, 1, 1, 1u);
    for (int c = 0; c < 3; c++) {
        memset(k.in[c], 0, (size_t) p->nx * sizeof(float));
        k.in[c][1] = (float) (1 << c); // channels differ, unless grey
    }
    for (int j = 0; j < p->rows; j++)
        place[j] = (3 * j + 1) % p->ny;
    assert_ok(gp_fft_plan_make(NULL, p->nx, GP_FFT_PLAN_ESTIMATE, NULL, &x));
    assert_ok(gp_fft_plan_make(NULL, p->ny, GP_FFT_PLAN_ESTIMATE, NULL, &y));
    const struct gp_fft_job job = {.x = &x, .y = &y, .channels = 3};
    const struct gp_fft_job kernel_job = {
        .x = &x, .y = &y, .channels = p->kernel_channels,
    };
    assert_ok(gp_fft_matrix_make(NULL, 3, p->nx, room, &m));
    assert_ok(
        gp_fft_matrix_make(NULL, p->kernel_channels, p->nx, 1, &kernel_rows));
    assert_ok(
        gp_fft_matrix_make(NULL, p->kernel_channels, p->nx, p->ny, &kernel));
    assert_ok(gp_fft_rows_in(&job, p->rows, load_row, &r, &m));
    for (int j = 0; j < p->rows; j += 5) {
        for (int f = 0; f <= p->nx / 2; f += p->nx / 8)
            assert_spectrum(&r, j % 3, j, f, m.z[j % 3] +
                            2 * ((size_t) f * m.pitch + (size_t) j));
    }
    assert_ok(gp_fft_rows_in(&kernel_job, 1, load_row, &k, &kernel_rows));
    assert_ok(gp_fft_columns(&kernel_job, &kernel_rows, 1, (const int[]){2},
                             (float) (0.25 / (p->nx * p->ny)), &kernel));
    assert_ok(gp_fft_multiply(&job, &m, p->rows, place, &kernel,
                              p->kernel_channels, p->first, p->count));
    assert_ok(gp_fft_rows_out(&job, &m, p->count, store_row, &r));
    assert_moved(p, &r, place);
    gp_fft_matrix_free(&m);
    gp_fft_matrix_free(&kernel_rows);
    gp_fft_matrix_free(&kernel);
    gp_fft_matrix_free(&kernel);
    gp_fft_plan_free(&x);
    gp_fft_plan_free(&y);
    gp_fft_plan_free(&y);
    free_rows(&r);
    free_rows(&k);
}

static void passes_go_round(void **state)
{
    static const struct pass_row rows[] = {
        {8, 8, 1, 0, 8, 1}, {8, 16, 5, 3, 16, 3},
        {24, 8, 2, 7, 1, 3}, {40, 64, 8, 60, 9, 1},
        {56, 40, 9, 39, 40, 3}, {160, 128, 17, 100, 33, 3},
        {512, 64, 16, 1, 7, 1}, {72, 504, 7, 500, 100, 3},
    };
    for (size_t i = 0; i < COUNT(rows); i++)
        check_passes(&rows[i]);
}

/* -- the engine -------------------------------------------------------------*/

/* Where hardly any light may be lost at the frame's edge (the bound is small),
 * the transform alone meets the bar; lobes may cancel, and these meet it too.
 */
static void check_alone(const struct hard_case *h, const struct scene *s,
                        const struct gp_glare_stats *stats)
{
    struct gp_glare_error e;
    gp_glare_measure(&s->f, &s->f.layer, s->exact, 1.0f, &e);
    assert_int_equal(stats->hot, 0);
    if (!(stats->bound == 0.0 || e.rel_l2 <= stats->bound))
        fail_msg("%s: %g over the bound %g", h->name, e.rel_l2, stats->bound);
    if ((stats->bound < 1e-3 || h->shape == LOBES) &&
        !(e.rel_l2 <= h->bar.fft))
        fail_msg("%s: rel_l2 %g", h->name, e.rel_l2);
}

/* With a gain of 0, which nobody sees, nothing is handed to direct: the table
 * runs through the transform alone. One state for all of it. */
static void transform_alone_holds(void **state)
{
    int transforms = 0;
    struct gp_glare kept = {0};
    scene_gain = 0.0f;
    for (int i = 0; i < HARD_CASES; i++) {
        const struct hard_case *const h = &hard_cases[i];
        if (quick && !hard_is_quick(h))
            continue;
        struct scene s = hard_scene(h);
        struct gp_glare_stats stats;
        ran("fft", &s, &kept, &stats, h->name);
        check_alone(h, &s, &stats);
        transforms += stats.fft_w > 0;
        const uint64_t hash = scene_hash(&s);
        ran_once("fft", &s, &stats, h->name);
        if (scene_hash(&s) != hash)
            fail_msg("%s: the state changed the layer", h->name);
        scene_free(&s);
    }
    scene_gain = 1.0f;
    gp_glare_close(&kept);
    assert_true(transforms >= (quick ? 15 : 35));
}

/* Frames whose transforms have these lengths. */
static void check_length(struct gp_glare *kept, int nx, int ny)
{
    struct scene s = scene_make(scene_frame(nx, ny, 0, 0, ALL, 3u),
                                scene_kernel(1, 1, MID, 0, BOX),
                                &(struct gp_sensor_params) {1, 0, 1e3f});
    struct gp_glare_stats stats;
    struct gp_glare_error e;
    ran("fft", &s, kept, &stats, "lengths");
    assert_int_equal(stats.fft_w, nx);
    assert_int_equal(stats.fft_h, ny);
    gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, &e);
    if (!(e.rel_l2 <= 1e-6))
        fail_msg("%dx%d: rel_l2 %g", nx, ny, e.rel_l2);
    scene_free(&s);
}

/* More lengths than plans are kept; the length of a column may be the oldest
 * plan while that of a row is not there. */
static void plans_outlive_each_other(void **state)
{
    enum { LENGTHS = 12, KEPT = 8 };
    int length[LENGTHS], n = 0;
    struct gp_glare kept = {0};
    for (int want = 8; n < LENGTHS; want = length[n++] + 1)
        length[n] = gp_fft_length(want);
    scene_gain = 0.0f;
    for (int i = 0; i < KEPT; i += 2)
        check_length(&kept, length[i + 1], length[i]);
    check_length(&kept, length[KEPT], length[0]);
    check_length(&kept, length[2], length[KEPT + 1]);
    for (int i = 0; i < 60; i++)
        check_length(&kept, length[i * 7 % LENGTHS],
                     length[i * i % 11 % LENGTHS]);
    scene_gain = 1.0f;
    gp_glare_close(&kept);
}

static gp_status run_measured(struct scene *s, const char *wisdom)
{
    struct gp_glare g = {0};
    struct gp_glare_stats stats;
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    p.engine = "fft";
    p.gain = 1e-30f; // all through the transform
    p.fft_plan = GP_FFT_PLAN_MEASURE;
    p.wisdom = wisdom;
    const gp_status st = gp_glare_run(&scene_log, &p, &g, &s->src, &s->k,
                                      &s->f, &stats);
    gp_glare_close(&g);
    return st;
}

/* Measured plans meet the bar; a wisdom file is made, read again, and is no
 * error when it cannot be written or holds rubbish. The last test: what FFTW
 * learns stays in the process. */
static void measured_plans_hold(void **state)
{
    char folder[] = "/tmp/glarepp-wisdom-XXXXXX", file[64];
    struct scene s = hard_scene(&hard_cases[5]);
    struct gp_glare_error e;
    assert_non_null(mkdtemp(folder));
    snprintf(file, sizeof file, "%s/wisdom", folder);
    for (int i = 0; i < 3; i++) {
        assert_ok(run_measured(&s, file));
        gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, &e);
        assert_true(e.rel_l2 <= 1e-6);
        assert_int_equal(access(file, R_OK), 0);
        FILE *const f = i == 1 ? fopen(file, "w") : NULL;
        if (f) {
            fputs("(not wisdom", f);
            fclose(f);
        }
    }
    assert_ok(run_measured(&s, "/nonexistent/folder/wisdom"));
    assert_ok(run_measured(&s, NULL));
    unlink(file);
    assert_int_equal(rmdir(folder), 0); // no temporary name stays
    scene_free(&s);
}

SUITE_OF(fft, ask_quick, NULL,
    lengths_are_the_cheapest, passes_go_round, transform_alone_holds,
    plans_outlive_each_other, measured_plans_hold)
