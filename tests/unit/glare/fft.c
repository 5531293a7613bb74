/* glare/fft: lengths, passes, what it hands to direct, what that costs,
 * and the rounding that it promises. */
#include "unit.h"
#include "glare/fft/fft.h"
#include "glare/fft/fft_priv.h"
#include "hard_cases.h"

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

static void store_row(const void *ctx, int c, int j, int thread,
                      const float *z)
{
    (void) thread;
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

static struct gp_fft_plan_pair make_plan(int n, bool in_double)
{
    struct gp_fft_plan_pair p;
    assert_ok(in_double
                  ? gp_fft_plan_make_double(NULL, n, &p)
                  : gp_fft_plan_make(NULL, n, GP_FFT_PLAN_ESTIMATE, NULL, &p));
    return p;
}

static struct gp_fft_matrix make_matrix(bool real, bool in_double, int channels,
                                        int nx, int rows)
{
    struct gp_fft_matrix m;
    assert_ok(gp_fft_matrix_make_of(
        NULL, (struct gp_fft_numbers) {real, in_double}, channels, nx, rows,
        &m));
    return m;
}

/* Scalar i of plane c. */
static double scalar(const struct gp_fft_matrix *m, int c, size_t i)
{
    return m->of.in_double ? ((const double *) (const void *) m->z[c])[i]
                           : (double) m->z[c][i];
}

/* Returns the error allowed to sums of n numbers of about 1. */
static double few_roundings(const struct gp_fft_matrix *m, double n)
{
    return (m->of.in_double ? 8e-15 : 4e-6) * sqrt(n);
}

/* Twice the plain transform of row j, at frequency k. */
static void assert_spectrum(const struct rows *r, int c, int j, int k,
                            const struct gp_fft_matrix *m)
{
    const size_t at = 2 * ((size_t) k * m->pitch + (size_t) j);
    const double turn = 6.283185307179586 / r->nx;
    double re = 0.0, im = 0.0;
    for (int x = 0; x < r->nx; x++) {
        const double v = 2.0 * (double) r->in[c][j * r->nx + x];
        re += v * cos(turn * (k * x % r->nx));
        im -= v * sin(turn * (k * x % r->nx));
    }
    const double d = hypot(scalar(m, c, at) - re, scalar(m, c, at + 1) - im);
    if (!(d <= few_roundings(m, r->nx)))
        fail_msg("nx %d, row %d, column %d: %g off", r->nx, j, k, d);
}

struct pass_row {
    int nx, ny, rows, first, count, kernel_channels;
};

/* Output row j holds the input row that stands two rows above it, one column
 * to the right, or nothing. */
static void assert_moved(const struct pass_row *p, const struct rows *r,
                         const int *place, bool in_double)
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
        const float most = in_double ? 1e-7f * fabsf(want) + 1e-14f
                                     : 4e-6f;
        if (!(fabsf(r->out[c][j * p->nx + x] - want) <= most))
            fail_msg("%dx%d: channel %d, row %d, column %d: %g, not %g", p->nx,
                     p->ny, c, j, x, (double) r->out[c][j * p->nx + x],
                     (double) want);
    }
}

/* A kernel that is made on the way, and kept or not, gives the same bits as its
 * spectrum. */
static void check_made(const struct pass_row *p,
    const struct gp_fft_kernel *there, const struct gp_fft_matrix *kernel_rows,
    const struct rows *r, const int *place, const struct gp_fft_plan_pair *x,
    const struct gp_fft_plan_pair *y)
{
    const int room = p->rows > p->count ? p->rows : p->count;
    for (int i = 0; i < 2 * p->kernel_channels; i++) {
        const int c = i / 2;
        const bool keep = i % 2;
        const struct gp_fft_request one = {
            .x = x, .y = y, .channel = c, .channels = 1,
        };
        const bool twice = x->in_double;
        struct gp_fft_kernel made = {
            .channels = p->kernel_channels, .rows = kernel_rows, .n = 1,
            .place = (const int[]) {2},
            .scale = 0.25 / (p->nx * p->ny),
        };
        struct rows out = make_rows(p->nx, p->rows, room, 77u);
        struct gp_fft_matrix m = make_matrix(false, twice, 3, p->nx, room);
        struct gp_fft_matrix kept = make_matrix(false, twice, 3, p->nx, p->ny);
        made.spectrum = keep ? kept : (struct gp_fft_matrix) {0};
        assert_ok(gp_fft_rows_in(&one, p->rows, load_row, &out, &m));
        assert_ok(gp_fft_multiply(&one, &m, p->rows, place, &made, p->first,
                                  p->count));
        assert_ok(gp_fft_rows_out(&one, &m, p->count, store_row, &out));
        const size_t samples = (size_t) p->nx * (size_t) p->count;
        assert_memory_equal(out.out[c], r->out[c], samples * sizeof(float));
        for (int i = 0; keep && i < 2 * (p->nx / 2 + 1) * p->ny; i++) {
            const size_t k = (size_t) (i / (2 * p->ny));
            const size_t at = 2 * k * kept.pitch + (size_t) (i % (2 * p->ny));
            assert_true(scalar(&kept, c, at) == scalar(&there->spectrum, c, at));
        }
        gp_fft_matrix_free(&m);
        gp_fft_matrix_free(&kept);
        free_rows(&out);
    }
}

/* A kernel whose sample at (1, 2) alone is not 0 moves the rows by as much;
 * places and outputs go round the torus. */
static void check_passes(const struct pass_row *p, bool twice)
{
    const int channels = p->kernel_channels;
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
    struct gp_fft_plan_pair x = make_plan(p->nx, twice);
    struct gp_fft_plan_pair y = make_plan(p->ny, twice);
    const struct gp_fft_request req = {.x = &x, .y = &y, .channels = 3};
    const struct gp_fft_request kernel_req = {
        .x = &x, .y = &y, .channels = channels,
    };
    struct gp_fft_matrix m = make_matrix(false, twice, 3, p->nx, room);
    struct gp_fft_matrix kernel_rows =
        make_matrix(false, twice, channels, p->nx, 1);
    struct gp_fft_matrix kernel =
        make_matrix(false, twice, channels, p->nx, p->ny);
    assert_ok(gp_fft_rows_in(&req, p->rows, load_row, &r, &m));
    for (int j = 0; j < p->rows; j += 5) {
        for (int f = 0; f <= p->nx / 2; f += p->nx / 8)
            assert_spectrum(&r, j % 3, j, f, &m);
    }
    assert_ok(gp_fft_rows_in(&kernel_req, 1, load_row, &k, &kernel_rows));
    assert_ok(gp_fft_columns(&kernel_req, &kernel_rows, 1, (const int[]){2},
                             0.25 / (p->nx * p->ny), &kernel));
    struct gp_fft_kernel there = {.channels = channels, .spectrum = kernel};
    assert_ok(gp_fft_multiply(&req, &m, p->rows, place, &there, p->first,
                              p->count));
    assert_ok(gp_fft_rows_out(&req, &m, p->count, store_row, &r));
    assert_moved(p, &r, place, twice);
    check_made(p, &there, &kernel_rows, &r, place, &x, &y);
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
    for (size_t i = 0; i < COUNT(rows); i++) {
        check_passes(&rows[i], false);
        check_passes(&rows[i], true);
    }
}

/* A kernel that is even about its centre has a real spectrum, made of the rows
 * from its centre down: that of all its rows. */
static void check_even(int nx, int ny, int channels, bool twice)
{
    enum { REACH = 2, ROWS = 2 * REACH + 1 };
    struct rows r = make_rows(nx, ROWS, ROWS, 5u);
    int place[ROWS];
    for (int c = 0; c < 3; c++) {
        for (int j = 0; j < ROWS; j++) {
            place[j] = (j - REACH + ny) % ny;
            for (int i = 0; i < nx; i++) {
                const int other = (ROWS - 1 - j) * nx + (nx - i) % nx;
                r.in[c][j * nx + i] = r.in[c][other];
            }
        }
    }
    struct rows half = {.nx = nx, .rows = REACH + 1};
    for (int c = 0; c < 3; c++)
        half.in[c] = r.in[c] + REACH * nx;
    struct gp_fft_plan_pair x = make_plan(nx, twice), y = make_plan(ny, twice);
    const struct gp_fft_request req = {.x = &x, .y = &y, .channels = channels};
    struct gp_fft_matrix m = make_matrix(false, twice, channels, nx, ROWS);
    struct gp_fft_matrix all = make_matrix(false, twice, channels, nx, ny);
    struct gp_fft_matrix even = make_matrix(true, twice, channels, nx, ny);
    struct gp_fft_matrix light = make_matrix(false, twice, channels, nx, ny);
    assert_ok(gp_fft_rows_in(&req, ROWS, load_row, &r, &m));
    assert_ok(gp_fft_columns(&req, &m, ROWS, place, 0.5, &all));
    assert_ok(gp_fft_rows_in(&req, REACH + 1, load_row, &half, &m));
    for (int c = 0; c < channels; c++) {
        const struct gp_fft_request one = {
            .x = &x, .y = &y, .channel = c, .channels = 1,
        };
        const struct gp_fft_kernel kernel = {
            .channels = channels, .spectrum = even, .rows = &m, .n = REACH + 1,
            .scale = 0.5,
        };
        assert_ok(gp_fft_multiply(&one, &light, 0, place, &kernel, 0, ny));
    }
    for (int i = 0; i < channels * (nx / 2 + 1) * ny; i++) {
        const int c = i / ((nx / 2 + 1) * ny), j = i % ny;
        const size_t k = (size_t) (i / ny % (nx / 2 + 1));
        const size_t at = 2 * (k * all.pitch + (size_t) j);
        const double re = scalar(&all, c, at), im = scalar(&all, c, at + 1);
        const double b = scalar(&even, c, k * even.pitch + (size_t) j);
        const double most = few_roundings(&all, 25.0);
        if (!(fabs(re - b) <= most && fabs(im) <= most))
            fail_msg("%dx%d, column %zu, row %d: %g, not %g + %g i", nx, ny, k,
                     j, b, re, im);
    }
    gp_fft_matrix_free(&m);
    gp_fft_matrix_free(&all);
    gp_fft_matrix_free(&even);
    gp_fft_matrix_free(&light);
    gp_fft_plan_free(&x);
    gp_fft_plan_free(&y);
    free_rows(&r);
}

static void even_kernels_have_real_spectra(void **state)
{
    for (int twice = 0; twice < 2; twice++) {
        check_even(8, 8, 1, twice);
        check_even(40, 24, 3, twice);
        check_even(72, 160, 3, twice);
    }
}

/* -- the engine -------------------------------------------------------------*/

/* If hardly any light may be lost at the frame's edge (the bound is small),
 * the transform alone meets the bar; lobes may cancel, and these meet it too.
 */
static void check_alone(const struct hard_case *h, const struct scene *s,
                        const struct gp_glare_stats *stats)
{
    const double rel_l2 = scene_rel_l2(s);
    assert_int_equal(stats->hot, 0);
    assert_true(h->shape != LOBES || isinf(stats->bound)); // light may cancel
    if (!(stats->bound == 0.0 || rel_l2 <= stats->bound))
        fail_msg("%s: %g over the bound %g", h->name, rel_l2, stats->bound);
    if ((stats->bound < 1e-3 || h->shape == LOBES) && !(rel_l2 <= h->bar.fft))
        fail_msg("%s: rel_l2 %g", h->name, rel_l2);
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

/* -- choices ----------------------------------------------------------------*/

struct chosen {
    struct gp_fft_split split;
    double plain; // rounding without a split
    double fft_ms;
};

static struct chosen choose(const struct scene *s, double gain)
{
    double tail[GP_FFT_CORES];
    struct chosen c;
    struct gp_fft_split unseen;
    const struct gp_fft_placing p = gp_fft_place(&s->src, &s->k);
    const double points = (double) p.nx * p.ny;
    c.fft_ms = gp_fft_passes_ms(&s->src, &p, GP_FFT_PLAN_MEASURE);
    gp_fft_tail_norms(&s->k, tail);
    gp_fft_split_choose(&s->src, &s->k, tail, points, c.fft_ms, gain, &c.split);
    // rounding that no eye could see is not split; it goes with the gain
    gp_fft_split_choose(&s->src, &s->k, tail, points, c.fft_ms, 1e-40, &unseen);
    c.plain = unseen.rounding * 1e40 * gain;
    assert_int_equal(unseen.core.x, -1);
    assert_true(isinf(unseen.hot) && unseen.hot_count == 0);
    return c;
}

static size_t count_hot(const struct gp_sources *s, float hot)
{
    size_t n = 0;
    for (size_t i = 0; i < s->n; i++)
        n += s->rgb[0][i] >= hot || s->rgb[1][i] >= hot || s->rgb[2][i] >= hot;
    return n;
}

enum choice { NOTHING, PARTS, IN_DOUBLE, CHOICES };

/* Returns what was chosen, if that keeps the rules: float within 1e-4 at worst,
 * a split within 1e-6, both without what shows. */
static enum choice check_choice(const char *name, const struct gp_sources *src,
                                const struct chosen *c)
{
    const struct gp_fft_split *const s = &c->split;
    const double own = gp_sources_dark(src);
    const bool none = s->core.x < 0 && s->hot_count == 0;
    double seen = INFINITY;
    if (src->visible > 0.0)
        seen = src->visible / own;
    if (src->hidden > 0.0)
        seen = fmin(seen, src->hidden / own);
    assert_int_equal(s->hot_count, count_hot(src, s->hot));
    if (s->in_double) {
        if (!(none && c->plain > 0.999 * fmin(1e-4, seen) &&
              s->rounding <= c->plain * 0x1p-28))
            fail_msg("%s: in double for %g, rounding %g", name, c->plain,
                     s->rounding);
        return IN_DOUBLE;
    }
    if (none) {
        if (!(c->plain <= 1.001 * fmin(1e-4, seen)))
            fail_msg("%s: rounding %g is left", name, c->plain);
        return NOTHING;
    }
    if (!(c->plain > 0.999 * fmin(1e-6, seen) &&
          s->rounding <= fmin(1e-6, seen) &&
          s->ms <= (GP_COST_FFT_DOUBLE - 1.0) * c->fft_ms))
        fail_msg("%s: %g ms direct for %g of transform, rounding %g in place "
                 "of %g", name, s->ms, c->fft_ms, s->rounding, c->plain);
    return PARTS;
}

/* Checks what every choice must be, whatever the frame. */
static void choices_keep_the_rules(void **state)
{
    static const double gains[] = {1.0, 0.0, 1e-6, 1e-3, 0.1, 100.0};
    int made[CHOICES] = {0};
    for (int i = 0; i < HARD_CASES; i++) {
        struct scene s = hard_sense(&hard_cases[i]);
        if (!s.src.n || !gp_fft_place(&s.src, &s.k).nx) {
            scene_free(&s);
            continue;
        }
        scene_limit(&s.src);
        for (size_t g = 0; g < COUNT(gains); g++) {
            const struct chosen c = choose(&s, gains[g]);
            made[check_choice(hard_cases[i].name, &s.src, &c)]++;
        }
        scene_free(&s);
    }
    for (int i = 0; i < CHOICES; i++) {
        if (made[i] < 10)
            fail_msg("choice %d: %d times", i, made[i]);
    }
}

/* One sun over a night: it alone goes direct. */
static void one_sun_goes_direct(void **state)
{
    struct scene s = scene_sense(scene_frame(256, 192, 0, 0, HOT, 1u),
        scene_kernel(255, 255, MID, 0, PEAK),
        &(struct gp_sensor_params) WHOLE(0.0f, 0.0f, 1e10f));
    const struct chosen c = choose(&s, 1.0);
    assert_int_equal(c.split.hot_count, 1);
    assert_true(c.split.hot > 1.0f && c.split.hot <= 1e9f);
    assert_true(c.plain > 1.0); // of the dark pixels' own value
    assert_true(c.split.rounding < 1e-5);
    scene_free(&s);
}

/* Norms of what is left of the kernel, against a sum without its core. */
static void tails_are_the_rest(void **state)
{
    static const int kernels[][4] = {
        {1, 1, MID, 0}, {9, 9, MID, 0}, {10, 8, MID, 0}, {75, 41, MID, 0},
        {75, 41, 3, 40}, {31, 31, -9, 12}, {31, 31, 400, 400},
    };
    for (size_t i = 0; i < COUNT(kernels); i++) {
        const int *const r = kernels[i];
        struct gp_kernel k = scene_kernel(r[0], r[1], r[2], r[3], TINTED);
        double tail[GP_FFT_CORES];
        gp_fft_tail_norms(&k, tail);
        for (int t = 0; t < GP_FFT_CORES; t++) {
            const struct gp_fft_core core = gp_fft_cores[t];
            double worst = 0.0;
            for (int c = 0; c < 3; c++) {
                double sum = 0.0;
                for (int j = 0; j < k.w * k.h; j++) {
                    const double v = (double) k.k.c[c][j];
                    if (abs(j % k.w - k.cx) > core.x ||
                        abs(j / k.w - k.cy) > core.y)
                        sum += v * v;
                }
                worst = fmax(worst, sqrt(sum));
            }
            // squares were subtracted: half the digits may be gone
            assert_true(fabs(tail[t] - worst) <= 4e-8 * tail[0]);
        }
        gp_kernel_free(&k);
    }
}

/* -- the promise ------------------------------------------------------------*/

/* Smooth noise in [0, 1] from a grid of `cells` cells. */
static float smooth(int x, int y, int w, int h, int cells, uint32_t seed)
{
    const float gx = (float) x * (float) cells / (float) w;
    const float gy = (float) y * (float) cells / (float) h;
    const int ix = (int) gx, iy = (int) gy;
    float corner[2][2];
    for (int i = 0; i < 4; i++) {
        uint32_t s = seed + 7919u * (uint32_t) (ix + i % 2) +
                     104729u * (uint32_t) (iy + i / 2);
        scene_random(&s);
        corner[i / 2][i % 2] = scene_random(&s);
    }
    const float u = gx - (float) ix, v = gy - (float) iy;
    return (corner[0][0] * (1 - u) + corner[0][1] * u) * (1 - v) +
           (corner[1][0] * (1 - u) + corner[1][1] * u) * v;
}

static void add_blob(struct gp_frame *f, int x0, int y0, float light,
                     float sigma)
{
    const int w = gp_frame_w(f), h = gp_frame_h(f), r = (int) (4 * sigma) + 1;
    for (int y = y0 - r; y <= y0 + r; y++) {
        for (int x = x0 - r; x <= x0 + r; x++) {
            if (x < 0 || x >= w || y < 0 || y >= h)
                continue;
            const float d = (float) ((x - x0) * (x - x0) + (y - y0) * (y - y0));
            for (int c = 0; c < 3; c++)
                f->rgb.c[c][y * w + x] += (1.0f - 0.15f * (float) c) * light *
                    expf(-d / (2 * sigma * sigma));
        }
    }
}

enum view { LAMPS, WINDOWS, SKY, VIEWS };

/* Like the three workloads of make_frames.py: a dim ground of smooth noise;
 * lamps of 10 to 5000, lit windows and some lamps, a bright upper half. */
static struct gp_frame make_view(enum view view, int w, int h, uint32_t seed)
{
    struct gp_frame f = scene_frame(w, h, 0, 0, DARK, seed);
    for (int i = 0; i < w * h; i++) {
        const int x = i % w, y = i / w;
        float v = 0.05f + 0.75f * (0.6f * smooth(x, y, w, h, 4, seed) +
                                   0.4f * smooth(x, y, w, h, 31, seed));
        const int pane = x * 16 / w + y * 12 / h * 16;
        uint32_t lot = seed + 977u * (uint32_t) pane;
        scene_random(&lot);
        if (view == SKY && y < h / 2)
            v = 2.1f + 17.9f * smooth(x, y, w, h, 6, seed);
        if (view == WINDOWS && scene_random(&lot) < 0.34f &&
            x % (w / 16) < w / 64 && y % (h / 12) < h / 36)
            v = 5.0f * expf(2.3f * scene_random(&lot));
        for (int c = 0; c < 3; c++)
            f.rgb.c[c][i] = v * (1.0f - 0.05f * (float) c);
    }
    for (int i = 0; i < (view == LAMPS ? 60 : view == WINDOWS ? 20 : 0); i++) {
        const int x = (int) (scene_random(&seed) * (float) w);
        const int y = (int) (scene_random(&seed) * (float) h);
        const float light = 10.0f * expf(6.2f * scene_random(&seed));
        add_blob(&f, x, y, light, 0.7f + 0.8f * scene_random(&seed));
    }
    return f;
}

/* If the split says that no pixel is off by over 1e-6 of its own value, none
 * is; elsewhere it is off by no more than a few times the bound. */
static void check_promise(struct scene *s, const struct chosen *c,
                          enum view view)
{
    struct gp_glare_stats stats;
    ran_once("fft", s, &stats, "rounding");
    assert_int_equal(stats.hot, c->split.hot_count);
    assert_int_equal(stats.fft_core[0], c->split.core.x);
    assert_int_equal(stats.fft_core[1], c->split.core.y);
    assert_true(scene_rel_l2(s) <= 1e-6);
    const double own = scene_own_error(s);
    if (!(own <= (c->split.rounding <= 1e-6 ? 1e-6 : 4.0 * c->split.rounding)))
        fail_msg("view %d, %dx%d: %g of a pixel's own value, %g predicted",
                 (int) view, s->src.w, s->src.h, own, c->split.rounding);
}

static void predicted_rounding_is_kept(void **state)
{
    static const int sizes[][3] = {{192, 144, 97}, {384, 216, 97}};
    int promised = 0;
    for (int i = 0; i < 3 * VIEWS && !(quick && i); i++) {
        const int *const size = sizes[i / VIEWS % 2];
        const enum view view = (enum view) (i % VIEWS);
        struct scene s = scene_make(make_view(view, size[0], size[1],
            5u + (uint32_t) i), scene_kernel(size[2], size[2], MID, 0,
            i < 2 * VIEWS ? PEAK : TINTED), &usual);
        const struct chosen c = choose(&s, 1.0);
        promised += c.split.rounding <= 1e-6;
        check_promise(&s, &c, view);
        scene_free(&s);
    }
    assert_true(promised > 0);
}

/* A streak of light along x, or along y, about a bright centre. */
static struct gp_kernel make_streak(bool tall)
{
    enum { LONG = 300, SHORT = 60 };
    const int rx = tall ? SHORT : LONG, ry = tall ? LONG : SHORT;
    const int w = 2 * rx + 1, h = 2 * ry + 1;
    struct gp_planes p;
    struct gp_kernel k;
    assert_ok(gp_planes_make(NULL, "streak", (size_t) w * (size_t) h, &p));
    for (int i = 0; i < w * h; i++) {
        const int x = abs(i % w - rx), y = abs(i / w - ry);
        const float along = (float) (tall ? y : x), off = (float) (x + y);
        for (int c = 0; c < 3; c++)
            p.c[c][i] = x + y == 0 ? 0.9f
                : 3e-3f * expf(-along / 20.0f - (off - along) * 0.8f);
    }
    assert_ok(gp_kernel_of_planes(NULL, "streak", w, h, &p, &k));
    return k;
}

/* Lamps over a night with streaks: their core is as wide as they are. */
static void a_streak_has_a_wide_core(void **state)
{
    for (int tall = 0; tall < 2; tall++) {
        struct scene s = scene_make(make_view(LAMPS, 640, 360, 5u),
                                    make_streak(tall), &usual);
        const struct chosen c = choose(&s, 1.0);
        assert_true(tall ? c.split.core.y > c.split.core.x
                         : c.split.core.x > c.split.core.y);
        check_promise(&s, &c, LAMPS);
        scene_free(&s);
    }
}

/* -- the budget -------------------------------------------------------------*/

/* At the size of work: lamps over a night are kept from spoiling it, though
 * that takes longer than the transform; a bright sky is not worth as much. */
static void a_night_is_worth_more_than_a_sky(void **state)
{
    if (quick)
        skip_for("quick");
    struct gp_frame night = scene_frame(960, 540, 0, 0, BLACK, 1u);
    uint32_t seed = 11u;
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < 960 * 540; i++)
            night.rgb.c[c][i] = 3e-4f;
    }
    for (int i = 0; i < 24; i++)
        add_blob(&night, (int) (960.0f * scene_random(&seed)),
                 (int) (540.0f * scene_random(&seed)), 3000.0f, 0.6f);
    struct scene s = scene_sense(
        night, scene_kernel(512, 512, MID, 0, PEAK), &usual);
    struct chosen c = choose(&s, 1.0);
    if (!(c.split.in_double && c.split.rounding <= 1e-6))
        fail_msg("night: rounding %g, %d in double", c.split.rounding,
                 c.split.in_double);
    scene_free(&s);
    s = scene_sense(make_view(SKY, 1024, 768, 3u),
                    scene_kernel(512, 512, MID, 0, PEAK), &usual);
    c = choose(&s, 1.0);
    if (!(c.split.ms == 0.0 && !c.split.in_double))
        fail_msg("sky: %g ms more for %g of transform", c.split.ms, c.fft_ms);
    scene_free(&s);
}

SUITE_OF(fft, ask_quick, NULL,
    lengths_are_the_cheapest, passes_go_round, even_kernels_have_real_spectra,
    transform_alone_holds, choices_keep_the_rules, one_sun_goes_direct, tails_are_the_rest,
    predicted_rounding_is_kept, a_streak_has_a_wide_core,
    a_night_is_worth_more_than_a_sky)
