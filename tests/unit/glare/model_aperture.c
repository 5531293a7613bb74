/* glare/model/aperture.c and diffract.c against published values and
 * closed forms. */
#include "unit.h"
#include "core/parallel.h"
#include "core/core_priv.h"
#include "glare/model/model_priv.h"
#include "model_scene.h"

/* Airy's pattern, 550 nm through 1 mm: its first zero, by a parabola through
 * the least pixels, and the light within it. */
static void a_circle_makes_airys_pattern(void **state)
{
    (void) state;
    const double unit = 550e-6 / 1.0 * 180.0 / M_PI; // lambda / D, degrees
    const struct gp_field f = scene_field(321, 321, unit / 20.0, 1.0);
    struct gp_kernel k;
    model_make(AIRY, &f, &k);
    double within = 0.0;
    for (int dy = -30; dy <= 30; dy++) {
        for (int dx = -30; dx <= 30; dx++) {
            // a pixel at the zero by parts
            for (int i = 0; i < 64; i++) {
                const double r = hypot(dx + (i % 8 + 0.5) / 8.0 - 0.5,
                                       dy + (i / 8 + 0.5) / 8.0 - 0.5);
                within += r / 20.0 < 1.219670 ? sample_at(&k, 1, dx, dy) / 64.0
                                              : 0.0;
            }
        }
    }
    if (!(fabs(within / 0.837785 - 1.0) < 1e-3))
        fail_msg("%.5f within the first zero, not 0.83779", within);
    // around its zero v r^3 is even, as J1 falls with the root of r
    double zero = 0.0;
    for (int x = 20; x < 29 && zero == 0.0; x++) {
        double v[3];
        for (int i = 0; i < 3; i++)
            v[i] = sample_at(&k, 1, x + i - 1, 0) * pow(x + i - 1, 3.0);
        if (v[1] < v[0] && v[1] < v[2])
            zero = x + 0.5 * (v[0] - v[2]) / (v[0] - 2.0 * v[1] + v[2]);
    }
    if (!(fabs(zero / 20.0 / 1.219670 - 1.0) < 1e-3))
        fail_msg("first zero at %.5f lambda / D", zero / 20.0);
    gp_kernel_free(&k);
}

/* Light along rays from the centre, by half degrees, between two radii. */
static void find_spikes(const struct gp_kernel *k, double *light, int steps,
                        double from, double to)
{
    memset(light, 0, (size_t) steps * sizeof *light);
    for (int y = -(int) to; y <= (int) to; y++) {
        for (int x = -(int) to; x <= (int) to; x++) {
            const double r = hypot(x, y);
            if (r < from || r > to)
                continue;
            double a = atan2(-y, x) / (2.0 * M_PI) + 1.0;
            a -= floor(a);
            light[(int) (a * steps) % steps] += sample_at(k, 1, x, y) * r;
        }
    }
}

/* n straight blades make n spikes where n is even, 2n where it is odd, across
 * the edges; their directions are means over five degrees. */
static void blades_make_spikes(void **state)
{
    (void) state;
    static const struct {
        int blades, spikes;
        double rotation;
    } rows[] = {{4, 4, 10.0}, {5, 10, 0.0}, {6, 6, 17.3}, {7, 14, 3.0},
                {8, 8, -11.0}};
    enum { STEPS = 3600 };
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct gp_field f = scene_field(256, 256, 1.0 / 36.0, 1.0);
        char text[200];
        struct gp_kernel k;
        double light[STEPS];
        const double n = rows[i].blades;
        snprintf(text, sizeof text, "aperture:share=1,blades=%d,roundness=0,"
                 "dust=0,scratches=0,wavelengths=8,reach=28,rotation=%g",
                 rows[i].blades, rows[i].rotation);
        model_make(text, &f, &k);
        find_spikes(&k, light, STEPS, 60.0, 250.0);
        double all = 0.0, inside = 0.0;
        for (int j = 0; j < STEPS; j++)
            all += light[j];
        for (int s = 0; s < rows[i].spikes; s++) {
            // across an edge: its middle is half a blade from a corner
            const double to = rows[i].rotation + 180.0 / n +
                              360.0 * s / rows[i].spikes;
            double sum = 0.0, off = 0.0;
            for (int j = 0; j < STEPS; j++) {
                const double d = remainder((j + 0.5) * 360.0 / STEPS - to,
                                           360.0);
                if (fabs(d) > 2.5)
                    continue;
                sum += light[j];
                off += light[j] * d;
            }
            inside += sum;
            if (!(fabs(off / sum) < 0.1))
                fail_msg("%d blades: spike at %g is %g degrees off",
                         rows[i].blades, to, off / sum);
            // as bright as all others, and darkness between
            if (!(sum > 0.8 * inside / (s + 1)))
                fail_msg("%d blades: no spike at %g", rows[i].blades, to);
        }
        if (!(inside > 0.9 * all))
            fail_msg("%d blades: %g of the light is in spikes", rows[i].blades,
                     inside / all);
        gp_kernel_free(&k);
    }
}

/* All light is in the kernel, but for what the edge's length says is beyond;
 * equal energy light is white. */
static void light_is_kept_and_white(void **state)
{
    (void) state;
    const struct gp_field f = scene_field(256, 256, 1.0 / 36.0, 1.0);
    struct gp_kernel k;
    model_make("aperture:share=1,blades=0,dust=0,scratches=0,pupil=2", &f, &k);
    // 1 - E(r) = l L / (2 pi^2 S r), L / S = 4 / D; half is left in the fade
    const double r = 255.0 / 36.0 * M_PI / 180.0;
    const double beyond = 550e-6 * 4.0 / 2.0 / (2.0 * M_PI * M_PI * r);
    if (!(k.left_out > 0.5 * beyond && k.left_out < 1.5 * beyond))
        fail_msg("%g left out, about %g lies beyond", k.left_out, beyond);
    for (int c = 0; c < 3; c++)
        assert_true(fabs(k.sum[c] - k.sum[1]) < 2e-4);
    assert_false(k.negative);
    gp_kernel_free(&k);
}

/* A kernel of a small frame is the middle of that of a large one: what comes
 * back from beyond its period is little. */
static void frames_of_all_sizes_agree(void **state)
{
    (void) state;
    static const char text[] = "aperture:share=1,blades=5,reach=20,pupil=0.5,"
                               "wavelengths=8";
    const struct gp_field small = scene_field(64, 48, 1.0 / 36.0, 1.0);
    const struct gp_field large = scene_field(400, 400, 1.0 / 36.0, 1.0);
    struct gp_kernel a, b;
    model_make(text, &small, &a);
    model_make(text, &large, &b);
    double error = 0.0, norm = 0.0;
    for (int y = -47; y <= 47; y++) {
        for (int x = -63; x <= 63; x++) {
            const double v = sample_at(&b, 1, x, y);
            const double d = (sample_at(&a, 1, x, y) - v) * hypot(x, y);
            error += d * d;
            norm += v * v * (x * x + y * y);
        }
    }
    if (!(sqrt(error / norm) < 0.003))
        fail_msg("%g of the light times its distance", sqrt(error / norm));
    gp_kernel_free(&a);
    gp_kernel_free(&b);
}

/* Turning the frame's kernel is turning the iris. */
static void turning_is_in_the_formula(void **state)
{
    (void) state;
    struct gp_field f = scene_field(128, 128, 0.05, 1.0);
    struct gp_kernel a, b;
    model_make("aperture:share=1,blades=3,rotation=30,wavelengths=4", &f, &a);
    f.rotate = 20.0;
    model_make("aperture:share=1,blades=3,rotation=10,wavelengths=4", &f, &b);
    assert_int_equal(a.w, b.w);
    for (int i = 0; i < a.w * a.h; i++)
        assert_true(fabsf(a.k.c[1][i] - b.k.c[1][i]) <=
                    1e-5f * a.k.c[1][i] + 1e-10f);
    gp_kernel_free(&a);
    gp_kernel_free(&b);
}

/* Luminance, which folding colours in leaves as it is, of BT.709. */
static double sample_y(const struct gp_kernel *k, int dx, int dy)
{
    double y = 0.0;
    for (int c = 0; c < 3; c++)
        y += (double) gp_rec709_luminance[c] * sample_at(k, c, dx, dy);
    return y;
}

/* Pixels of any size and aspect share out the same light, that of an even pixel
 * to all of those that another is made of, on axes along which frequencies fold
 * back and on axes along which they do not. */
static void pixels_add_up(void **state)
{
    (void) state;
    static const struct {
        double degrees, aspect;
        int across, down; // fine pixels of one
    } rows[] = {{0.12, 1.0, 5, 5}, {0.024, 3.0, 3, 1},
                {0.072, 1.0 / 3.0, 1, 3}};
    static const char text[] = "aperture:share=1,blades=5,pupil=1,wavelengths="
                               "4,reach=8,dust=0.3";
    const struct gp_field fine = scene_field(400, 400, 0.024, 1.0);
    struct gp_kernel a, b;
    model_make(text, &fine, &a);
    for (size_t i = 0; i < COUNT(rows); i++) {
        const int nx = rows[i].across, ny = rows[i].down;
        const struct gp_field f = scene_field(400, 400, rows[i].degrees,
                                        rows[i].aspect);
        double error = 0.0, norm = 0.0, worst = 0.0;
        model_make(text, &f, &b);
        for (int y = -80 / ny; y <= 80 / ny; y++) {
            for (int x = -80 / nx; x <= 80 / nx; x++) {
                // pairs of fine pixels that are as far apart, and do not fade
                double sum = 0.0;
                if (hypot(nx * x, ny * y) > 76.0)
                    continue;
                for (int j = 1 - ny; j < ny; j++) {
                    for (int k = 1 - nx; k < nx; k++)
                        sum += (double) ((nx - abs(k)) * (ny - abs(j))) /
                               (nx * ny) *
                               sample_y(&a, nx * x + k, ny * y + j);
                }
                const double d = fabs(sample_y(&b, x, y) - sum);
                worst = fmax(worst, d / sum);
                error += d;
                norm += sum;
            }
        }
        // in the dark between spikes other periods bring other light back; a
        // period's window bends over wide pixels by 3 / 104^2
        if (!(error < 2e-5 * norm) || !(worst < 0.01))
            fail_msg("row %zu: %g of the light, %g of a pixel", i,
                     error / norm, worst);
        gp_kernel_free(&b);
    }
    gp_kernel_free(&a);
}

/* Transforms n lines of m values `step` apart, n and m being alike, in double;
 * `sign` -1 is forward. */
static void transform_lines(double complex *z, int m, int sign, int step,
                            int across)
{
    double complex line[160], turn[160];
    for (int k = 0; k < m; k++)
        turn[k] = cexp(sign * 2.0 * M_PI * I * k / m);
    for (int j = 0; j < m; j++) {
        double complex *const at = z + j * across;
        for (int k = 0; k < m; k++) {
            line[k] = 0.0;
            for (int x = 0; x < m; x++)
                line[k] += at[x * step] * turn[k * x % m];
        }
        for (int k = 0; k < m; k++)
            at[k * step] = line[k];
    }
}

/* Autocorrelations of noise, with and without a path, against the same in
 * double. */
static void lags_are_a_pupils(void **state)
{
    (void) state;
    enum { N = 56, MOST = 160 };
    static double complex z[MOST * MOST];
    static float t[N * N], path[N * N];
    static float lag[2][(N / GP_LAG_STRIP + 1) * (2 * N + 1) * GP_LAG_STRIP];
    for (uint64_t i = 0; i < N * N; i++) {
        t[i] = (float) gp_model_random(1, i);
        path[i] = (float) (4000.0 * gp_model_random(2, i) - 2000.0);
    }
    for (int with = 0; with < 2; with++) {
        const struct gp_pupil p = {N, 1.0, t, with ? path : NULL};
        struct gp_correlator c;
        struct gp_lags a = {.n = N, .re = lag[0], .im = with ? lag[1] : NULL};
        assert_true(gp_lag_count(N) == COUNT(lag[0]));
        assert_ok(gp_correlator_make(NULL, &p, &c));
        const int m = c.plan.n;
        assert_in_range(m, 2 * N, MOST);
        assert_ok(gp_correlate(NULL, &c, 500.0, &a));
        memset(z, 0, sizeof z);
        for (int i = 0; i < N * N; i++)
            z[i / N * m + i % N] = (double) t[i] *
                (with ? cexp(2.0 * M_PI * I * (double) path[i] / 500.0) : 1.0);
        transform_lines(z, m, -1, 1, m);
        transform_lines(z, m, -1, m, 1);
        for (int i = 0; i < m * m; i++) {
            const double x = gp_sinc(remainder(i % m, m) / m);
            const double y = gp_sinc(remainder(i / m, m) / m);
            const double abs = cabs(z[i]);
            z[i] = abs * abs * pow(x * y, -4.0);
        }
        transform_lines(z, m, 1, 1, m);
        transform_lines(z, m, 1, m, 1);
        if (!(fabs(a.sum / creal(z[0]) - 1.0) < 1e-6))
            fail_msg("%g passes, not %g", a.sum, creal(z[0]));
        for (int u = -N; u <= N; u++) {
            for (int v = 0; v <= N; v++) {
                const size_t at = gp_lag_at(&a, u, v);
                const double complex is = (double) a.re[at] +
                    (with ? I * (double) a.im[at] : 0.0);
                const double complex want = z[v * m + (u + m) % m];
                if (!(cabs(is - want) < 1e-6 * a.sum))
                    fail_msg("lag %d, %d: off by %g", u, v,
                             cabs(is - want) / a.sum);
            }
        }
        gp_correlator_free(&c);
    }
}

/* Against the C library's cosine, in all eighths of a turn and between them. */
static void gratings_are_cosines(void **state)
{
    (void) state;
    enum { N = 64 };
    static const double turns[] = {0.0, 0.7, -3.0, 6.1};
    for (int i = 0; i < N * (int) COUNT(turns); i++) {
        const int y = i % N;
        const double turn = turns[i / N];
        float row[N] = {0};
        gp_grating_row(N, y, 1, N, turn, 3000.0, row);
        assert_true(row[0] == 0.0f);
        for (int x = 1; x < N; x++) {
            const double u = x + 0.5 - 0.5 * N, v = y + 0.5 - 0.5 * N;
            const double want =
                0.5 + 0.5 * cos(3000.0 * (atan2(-v, u) - turn));
            if (!(fabs((double) row[x] - want) < 1e-6))
                fail_msg("cell %d, %d turned by %g: %g, not %g", x, y, turn,
                         (double) row[x], want);
        }
    }
}

/* A mask of white is a square opening: light falls as sinc^2 on its axes, also
 * on those of one that is turned. */
static void masks_are_openings(void **state)
{
    (void) state;
    float white[64], black[64] = {0};
    for (int i = 0; i < 64; i++)
        white[i] = 1.0f;
    struct gp_frame image = {
        .data = {0, 0, 8, 8}, .luminance = {0.2126f, 0.7152f, 0.0722f},
        .rgb.c = {white, white, white},
    };
    const double unit = 550e-6 * 180.0 / M_PI;
    const struct gp_field f = scene_field(129, 129, unit / 8.0, 1.0);
    struct gp_recipe r;
    struct gp_kernel k = {0};
    assert_ok(gp_recipe_parse(NULL, "aperture:share=1,mask=F,dust=0,"
                              "scratches=0,wavelength=550,pupil=1,reach=90",
                              &r));
    r.image = &image;
    assert_ok(gp_model_kernel(NULL, &r, 1, &f, &k));
    const double middle = sample_at(&k, 1, 0, 0);
    for (int i = 0; i < 2; i++) {
        // the zeros at lambda / D, of which a pixel is wider, and what is
        // between them
        const double zero = sample_at(&k, 1, i ? 0 : 8, i ? 8 : 0);
        const double peak = sample_at(&k, 1, i ? 0 : 12, i ? 12 : 0);
        const double side = 4.0 / (9.0 * M_PI * M_PI);
        if (!(zero < 0.0035 * middle) ||
            !(fabs(peak / middle / side - 1) < 0.03))
            fail_msg("axis %d: %g, %g of the peak", i, zero / middle,
                     peak / middle);
    }
    gp_kernel_free(&k);
    struct gp_field turned = f;
    turned.rotate = 45.0;
    assert_ok(gp_model_kernel(NULL, &r, 1, &turned, &k));
    // the first side light 1.43 lambda / D away, on the diagonal now
    const double side = sample_at(&k, 1, 8, 8) / sample_at(&k, 1, 0, 0);
    if (!(fabs(sample_at(&k, 1, 0, 0) / middle - 1.0) < 0.01) ||
        !(side > 0.04 && side < 0.05))
        fail_msg("turned: %g of the peak, %g of it aside",
                 sample_at(&k, 1, 0, 0) / middle, side);
    gp_kernel_free(&k);
    for (int c = 0; c < 3; c++)
        image.rgb.c[c] = black;
    assert_int_equal(gp_model_kernel(NULL, &r, 1, &f, &k), GP_ERR_DATA);
    r.image = NULL;
    assert_int_equal(gp_model_kernel(NULL, &r, 1, &f, &k), GP_ERR_USAGE);
    gp_recipe_free(&r);
    // a metre's mirror behind a pixel of 4 degrees: a point
    const struct gp_field coarse = scene_field(30, 30, 4.0, 1.0);
    assert_ok(gp_recipe_parse(NULL, "aperture:share=1,pupil=1000", &r));
    assert_ok(gp_model_kernel(NULL, &r, 1, &coarse, &k));
    assert_true(sample_at(&k, 1, 0, 0) > 0.998 &&
                sample_at(&k, 1, 1, 0) < 1e-4);
    gp_kernel_free(&k);
    gp_recipe_free(&r);
    assert_ok(gp_recipe_parse(NULL, "aperture:blades=2", &r));
    assert_int_equal(gp_model_kernel(NULL, &r, 1, &f, &k), GP_ERR_USAGE);
    gp_recipe_free(&r);
}

static bool same(const struct gp_kernel *a, const struct gp_kernel *b)
{
    bool equal = a->w == b->w && a->h == b->h;
    for (int c = 0; c < 3 && equal; c++)
        equal = memcmp(a->k.c[c], b->k.c[c], (size_t) a->w * (size_t) a->h *
                       sizeof(float)) == 0;
    return equal;
}

/* A seed makes the same kernel on any number of threads, another seed and
 * every key another. */
static void keys_change_kernels(void **state)
{
    (void) state;
    static const char *const keys[] = {
        "blades=5", "roundness=0.5", "rotation=5", "obstruction=0.3",
        "obstruction=0.3,arc=90", "grating=0.5", "dust=0.5", "scratches=0.5",
        "lashes=0.5", "seed=2", "fnumber=8", "focal=50", "defocus=0.1",
        "astigmatism=0.1", "coma=0.1", "spherical=0.1", "tilt=0.1",
        "vertical-tilt=0.1", "oblique-astigmatism=0.1", "vertical-coma=0.1",
        "vertical-trefoil=0.1", "oblique-trefoil=0.1",
        "secondary-astigmatism=0.1", "oblique-secondary=0.1",
        "quadrafoil=0.1", "oblique-quadrafoil=0.1", "wavelength=600",
        "reach=3", "adaptation=100", "pupil=2.5", "hippus=0", "particles=0.1",
        "grating=0.05", "formula=watson", "formula=watson,age=60",
        "grating=0.5,fibres=20",
    };
    struct gp_field f = scene_field(48, 48, 0.05, 1.0);
    f.frame = 7;
    for (int m = 0; m < 2; m++) {
        const char *const name = m ? "temporal" : "aperture";
        struct gp_kernel made[COUNT(keys) + 1];
        size_t n = 0;
        char text[200];
        snprintf(text, sizeof text, "%s:wavelengths=2", name);
        gp_set_threads(1);
        model_make(text, &f, &made[n++]);
        gp_set_threads(3);
        model_make(text, &f, &made[n]);
        assert_true(same(&made[0], &made[n]));
        gp_kernel_free(&made[n]);
        for (size_t i = 0; i < COUNT(keys); i++) {
            struct gp_recipe r;
            snprintf(text, sizeof text, "%s:wavelengths=2,%s", name, keys[i]);
            if (gp_recipe_parse(NULL, text, &r) != GP_OK)
                continue; // the other model's
            gp_recipe_free(&r);
            model_make(text, &f, &made[n]);
            for (size_t j = 0; j < n; j++) {
                if (same(&made[j], &made[n]))
                    fail_msg("%s is as one before it", text);
            }
            n++;
        }
        assert_true(n > 12);
        while (n > 0)
            gp_kernel_free(&made[--n]);
        gp_set_threads(0);
    }
}

/* Diameters by luminance as published; log10, not ln. Watson and Yellott's by
 * their figure: 2 to 8 mm, smaller in old eyes. */
static void pupils_are_as_wide_as_published(void **state)
{
    (void) state;
    static const double rows[][2] = {{0.01, 6.9}, {1, 4.90}, {100, 2.91},
                                     {1e4, 2.14}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        const double got = gp_pupil_moon_spencer(rows[i][0]);
        if (!(fabs(got - rows[i][1]) < 0.0061))
            fail_msg("%g cd/m2: %g mm", rows[i][0], got);
    }
    // no light: 7.75 mm; F = 846 cd/m2 deg2: 7.75 - 5.75 / 3
    assert_true(fabs(gp_pupil_watson(1e-12, 846.0, 28.58) - 7.75) < 1e-3);
    assert_true(fabs(gp_pupil_watson(1.0, 846.0, 28.58) - 5.83333) < 1e-4);
    assert_true(fabs(gp_pupil_watson(1e-12, 846.0, 78.58) -
                     (7.75 + 50.0 * (0.02132 - 0.009562 * 7.75))) < 1e-3);
}

/* Hippus moves with time without jumps, within the equation's range, and not at
 * all in a pupil that is open. */
static void pupils_shimmer(void **state)
{
    (void) state;
    const double p = 4.0, most = 9.0 / p * sqrt(1.0 - p / 9.0);
    double low = INFINITY, high = -INFINITY, before = 0.0;
    for (int i = 0; i < 2000; i++) {
        const double h = gp_pupil_hippus(p, i / 24.0, 0.5, 3);
        assert_true(fabs(h - p) <= 0.5 * most);
        assert_true(i == 0 || fabs(h - before) < 0.1);
        low = fmin(low, h);
        high = fmax(high, h);
        before = h;
    }
    assert_true(high - low > 0.5 * most);
    assert_true(gp_pupil_hippus(9.0, 1.7, 1.0, 3) == 9.0);
    assert_true(gp_pupil_hippus(p, 1.7, 0.0, 3) == p);
    // frames of a run
    struct gp_field f = scene_field(32, 32, 0.1, 1.0);
    struct gp_kernel a, b;
    model_make("temporal:wavelengths=2", &f, &a);
    f.frame = 1;
    model_make("temporal:wavelengths=2", &f, &b);
    assert_false(same(&a, &b));
    gp_kernel_free(&a);
    gp_kernel_free(&b);
}

/* Fibres of the lens make a halo at l n / (2 pi r), Simpson 1953: those from
 * 1.5 to 2.5 mm away from the axis at 2.2 to 3.7 degrees. */
static void fibres_make_a_halo(void **state)
{
    (void) state;
    const struct gp_field f = scene_field(100, 100, 0.05, 1.0);
    double light[2][2] = {{0}, {0}}; // within, of the halo
    for (int i = 0; i < 2; i++) {
        struct gp_kernel k;
        char text[100];
        snprintf(text, sizeof text, "temporal:pupil=5,hippus=0,particles=0,"
                 "lashes=0,grating=%d", i);
        model_make(text, &f, &k);
        for (int y = -99; y <= 99; y++) {
            for (int x = -99; x <= 99; x++) {
                const double t = 0.05 * hypot(x, y);
                const double v = sample_at(&k, 1, x, y);
                light[i][0] += t > 0.5 && t < 1.5 ? v : 0.0;
                light[i][1] += t > 2.2 && t < 3.7 ? v : 0.0;
            }
        }
        gp_kernel_free(&k);
    }
    // a cosine's first orders have an eighth of what passes the fibres, which
    // is half of a share of the light
    if (!(light[1][1] > 0.03 && light[1][1] < 0.12 &&
          light[0][1] < 0.002 && light[1][0] < 0.01))
        fail_msg("halo: %g of the light, %g without; %g within it",
                 light[1][1], light[0][1], light[1][0]);
}

/* The observer's fit against the CIE's table of 1931, and weights of bands: of
 * sum 1, none negative, of the observer's luminance where the primaries hold
 * the colour and where they do not. */
static void spectra_are_the_observers(void **state)
{
    (void) state;
    static const double table[][4] = {
        {400, .01431, .000396, .06785}, {420, .13438, .004, .6456},
        {440, .34828, .023, 1.74706},   {460, .2908, .06, 1.6692},
        {480, .09564, .13902, .81295},  {500, .0049, .323, .272},
        {520, .06327, .71, .07825},     {540, .2904, .954, .0203},
        {560, .5945, .995, .0039},      {580, .9163, .87, .00165},
        {600, 1.0622, .631, .0008},     {620, .85445, .381, .00019},
        {640, .4479, .175, .00002},     {660, .1649, .061, 0},
        {680, .04677, .017, 0},         {700, .011359, .004102, 0},
    };
    static const double peak[3] = {1.0622, 0.995, 1.7826};
    for (size_t i = 0; i < COUNT(table); i++) {
        double xyz[3];
        gp_spectrum_xyz(table[i][0], xyz);
        for (int c = 0; c < 3; c++) {
            if (!(fabs(xyz[c] - table[i][c + 1]) < 0.01 * peak[c]))
                fail_msg("%g nm: %g, not %g", table[i][0], xyz[c],
                         table[i][c + 1]);
        }
    }
    enum { BANDS = 40 };
    const struct gp_field f = scene_field(1, 1, 1.0, 1.0);
    double nm[BANDS], rgb[BANDS][3], sum[3] = {0}, all = 0.0, xyz[3];
    gp_spectrum_weights(f.chromaticities, BANDS, nm, rgb);
    for (int i = 0; i < BANDS; i++) {
        gp_spectrum_xyz(nm[i], xyz);
        all += xyz[1];
        for (int c = 0; c < 3; c++) {
            assert_true(rgb[i][c] >= 0.0);
            sum[c] += rgb[i][c];
        }
    }
    for (int c = 0; c < 3; c++)
        assert_true(fabs(sum[c] - 1.0) < 1e-12);
    for (int i = 0; i < BANDS; i++) {
        double y = 0.0;
        gp_spectrum_xyz(nm[i], xyz);
        for (int c = 0; c < 3; c++)
            y += (double) f.luminance[c] * rgb[i][c];
        if (!(fabs(y - xyz[1] / all) < 1e-3 * xyz[1] / all))
            fail_msg("%g nm: luminance %g, not %g", nm[i], y, xyz[1] / all);
    }
}

/* Beyond the reach of its samples Airy's light goes on: outside of a square of
 * half a side s there is 2 l / (pi^2 D) times the mean of 1 / r around it,
 * 2 sqrt 2 / (pi s), with no rim on the way. */
static void light_goes_on_beyond_the_reach(void **state)
{
    (void) state;
    static const char text[] = "aperture:share=1,blades=0,dust=0,scratches=0,"
                               "wavelength=550,pupil=1,reach=3";
    const struct gp_field f = scene_field(301, 301, 0.06, 1.0); // 18 degrees
    struct gp_kernel core, k;
    model_make(text, &f, &core);
    assert_ok(gp_kernel_whole(NULL, &core, f.w, f.h, &k));
    const double side = 300.5 * f.degrees * M_PI / 180.0;
    const double beyond =
        2.0 * 550e-6 / (M_PI * M_PI) * 2.0 * sqrt(2.0) / (M_PI * side);
    if (!(fabs(core.left_out / beyond - 1.0) < 0.1))
        fail_msg("%g left out, not %g", core.left_out, beyond);
    double before = 0.0;
    for (int r = 30; r < 290; r += 10) { // means of rings of 10 pixels
        double sum = 0.0, shape = 0.0;
        for (int dy = -300; dy <= 300; dy++) {
            for (int dx = -300; dx <= 300; dx++) {
                const double t = hypot(dx, dy);
                if (t < r || t >= r + 10)
                    continue;
                sum += sample_at(&k, 0, dx, dy);
                shape += 1.0 / (t * t * t);
            }
        }
        if (before > 0.0 && !(fabs(sum / shape / before - 1.0) < 0.06))
            fail_msg("%g degrees: %g times the light of the ring before",
                     r * f.degrees, sum / shape / before);
        before = sum / shape;
    }
    gp_kernel_free(&core);
    gp_kernel_free(&k);
}

SUITE_OF(model_aperture, NULL, NULL, a_circle_makes_airys_pattern,
    blades_make_spikes, light_is_kept_and_white, frames_of_all_sizes_agree,
    turning_is_in_the_formula, pixels_add_up, lags_are_a_pupils,
    gratings_are_cosines, masks_are_openings, keys_change_kernels,
    pupils_are_as_wide_as_published, pupils_shimmer, fibres_make_a_halo,
    spectra_are_the_observers, light_goes_on_beyond_the_reach)
