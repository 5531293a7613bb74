/* glare/fft: plans of FFTW, known, estimated and measured. */
#include "unit.h"
#include "glare/fft/fft.h"
#include "glare/fft/fft_priv.h"
#include "hard_cases.h"

#include <unistd.h>

/* Frames whose transforms have these lengths. */
static void check_length(struct gp_glare *kept, int nx, int ny)
{
    struct scene s = scene_make(scene_frame(nx, ny, 0, 0, ALL, 3u),
                                scene_kernel(1, 1, MID, 0, BOX),
                                &(struct gp_sensor_params) WHOLE(1, 0, 1e3f));
    struct gp_glare_stats stats;
    ran("fft", &s, kept, &stats, "lengths");
    assert_int_equal(stats.fft_w, nx);
    assert_int_equal(stats.fft_h, ny);
    const double rel_l2 = scene_rel_l2(&s);
    if (!(rel_l2 <= 1e-6))
        fail_msg("%dx%d: rel_l2 %g", nx, ny, rel_l2);
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

/* FFTW has both plans of each known length by its wisdom alone. */
static void known_plans_are_whole(void **state)
{
    const struct gp_fftwf *lib;
    float *const a = scene_alloc(2 * 16384, sizeof *a);
    float *const b = scene_alloc(2 * 16384, sizeof *b);
    int count = 0;
    assert_ok(gp_fftwf_open(NULL, &lib));
    for (int n = 8; n <= 16384; n += 8) {
        const char *const known = gp_fft_known(n);
        if (!known)
            continue;
        lib->forget_wisdom();
        if (!lib->import_wisdom_from_string(known))
            skip_for("FFTW of the table's version and instructions");
        for (int sign = -1; sign <= 1; sign += 2) {
            const fftwf_plan p = lib->plan_dft_1d(n, (void *) a, (void *) b,
                sign, FFTW_ESTIMATE | FFTW_WISDOM_ONLY);
            if (!p)
                fail_msg("%d: no plan of sign %d", n, sign);
            lib->destroy_plan(p);
        }
        count++;
    }
    assert_true(count >= 30);
    for (int n = 512; n <= 16384; n *= 2)
        assert_non_null(gp_fft_known(n));
    lib->forget_wisdom();
    free(a);
    free(b);
}

/* Transforms the same numbers forward by new plans. */
static void transform_anew(int n, const float *in, float *out)
{
    const struct gp_fftwf *lib;
    struct gp_fft_plan_pair p;
    assert_ok(gp_fftwf_open(NULL, &lib));
    assert_ok(gp_fft_plan_make(NULL, n, GP_FFT_PLAN_ESTIMATE, NULL, &p));
    lib->execute_dft(p.forward, (void *) in, (void *) out);
    gp_fft_plan_free(&p);
}

/* Plans made before, of known lengths and others, change no bit. */
static void plans_depend_on_their_length_only(void **state)
{
    static const int length[] = {640, 648, 1152, 1280, 1344, 2304, 2560};
    enum { LENGTHS = (int) (sizeof length / sizeof *length), MOST = 2560 };
    const size_t bytes = 2 * MOST * sizeof(float);
    float *const in = scene_alloc(2 * MOST, sizeof *in);
    float *const first = scene_alloc(LENGTHS * 2 * MOST, sizeof *first);
    float *const again = scene_alloc(2 * MOST, sizeof *again);
    uint32_t seed = 5u;
    for (int i = 0; i < 2 * MOST; i++)
        in[i] = scene_random(&seed) - 0.5f;
    for (int i = 0; i < LENGTHS; i++)
        transform_anew(length[i], in, first + i * 2 * MOST);
    for (int i = 0; i < 3 * LENGTHS; i++) {
        const int j = i * i % 5 * 3 % LENGTHS;
        memset(again, 0, bytes);
        transform_anew(length[j], in, again);
        assert_memory_equal(again, first + j * 2 * MOST, bytes);
    }
    free(in);
    free(first);
    free(again);
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
    const gp_status st = gp_glare_run(&kept_log, &p, &g, &s->src, &s->k,
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
    assert_non_null(mkdtemp(folder));
    snprintf(file, sizeof file, "%s/wisdom", folder);
    for (int i = 0; i < 3; i++) {
        assert_ok(run_measured(&s, file));
        assert_true(scene_rel_l2(&s) <= 1e-6);
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

SUITE_OF(fft_plans, ask_quick, NULL,
    plans_outlive_each_other, known_plans_are_whole,
    plans_depend_on_their_length_only, measured_plans_hold)
