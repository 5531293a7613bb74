// SPDX-License-Identifier: Apache-2.0
/* Every tone curve over the hard cases, NaN and Inf among the light, against
 * the printed equations in double (tone_forms.h). */
#include "hardcases.h"
#include "hash.h"

#include "core/parallel.h"
#include "tone/tone.h"

#include "tone_forms.h"

/* Columns: gp_tone_curves in order, `none` among them, then two exposures. */
enum { EV = TONE_FORMS + 1, METERED, WAYS };

static struct way {
    const char *name, *curve;
    float exposure;
    bool metered;
} ways[WAYS] = {
    [EV] = {"hable at -7.3 EV", "hable", -7.3f, false},
    [METERED] = {"auto-exposure, reinhard", "reinhard", 0.0f, true},
};

/* Beyond, all is white; tone/map.c bounds light and factor so. */
static const double light_max = 1e15, scale_min = 0x1p-140, scale_max = 0x1p60;

// -- plain forms --------------------------------------------------------------

static double luminance_of(const struct gp_image *f, size_t i)
{
    double y = 0.0;
    for (int c = 0; c < 3; c++)
        y += (double) f->luminance[c] * (double) f->lit.c[c][i];
    return y;
}

/* Reinhard et al. 2002, eq. 1, over pixels whose luminance is a number over
 * 0. */
static double plain_scale(const struct way *w, const struct gp_image *f)
{
    const size_t n = gp_image_pixels(f);
    double sum = 0.0, count = 0.0, scale = exp2((double) w->exposure);
    for (size_t i = 0; i < n && w->metered; i++) {
        const double y = luminance_of(f, i);
        if (y > 0.0 && isfinite(y)) {
            sum += log(1e-6 + y);
            count += 1.0;
        }
    }
    if (count > 0.0)
        scale *= 0.18 / exp(sum / count);
    return fmin(fmax(scale, scale_min), scale_max);
}

/* The light of a pixel that a curve gets: negative light is none, but for those
 * that mix it into wider primaries first; NaN is the lower end. */
static void plain_light(const struct way *w, const struct gp_image *f,
                        double scale, size_t i, double out[3])
{
    const struct tone_form *const form = tone_form_of(w->curve);
    const bool wide = form && form->wide;
    for (int c = 0; c < 3; c++) {
        const double v = (double) f->lit.c[c][i] * scale;
        out[c] = fmin(fmax(v, wide ? -light_max : 0.0), light_max);
    }
}

/* A float, as the white that the option takes; no less than FLT_MIN. */
static double plain_white(const struct way *w, const struct gp_image *f,
                          double scale)
{
    double peak = 0.0, v[3];
    for (size_t i = 0; i < gp_image_pixels(f); i++) {
        plain_light(w, f, scale, i, v);
        peak = fmax(peak, luminance(v));
    }
    peak = (double) (float) fmin(peak, light_max);
    return peak > 0.0 ? fmax(peak, (double) FLT_MIN) : 1.0;
}

// -- errors -------------------------------------------------------------------

static void map(const struct way *w, struct gp_image *f)
{
    struct glarepp_tone_params p = GLAREPP_TONE_PARAMS;
    p.curve = w->curve;
    p.exposure = w->exposure;
    p.auto_exposure = w->metered;
    if (gp_tone_map(&kept_log, &p, f))
        hard_die(w->name, kept_line);
}

/* `none` must give the bytes back. */
static double copy_error(const struct gp_image *f)
{
    const size_t n = gp_image_pixels(f);
    double differ = 0.0;
    for (int c = 0; c < 3; c++)
        differ += memcmp(f->lit.c[c], f->shown.c[c], n * sizeof(float)) != 0;
    return differ;
}

static double map_error(const struct way *w, struct gp_image *f)
{
    const struct tone_form *const form = tone_form_of(w->curve);
    map(w, f);
    if (!form)
        return copy_error(f);
    const double scale = plain_scale(w, f), white = plain_white(w, f, scale);
    double worst = 0.0;
    for (size_t i = 0; i < gp_image_pixels(f); i++) {
        double v[3], want[3];
        plain_light(w, f, scale, i, v);
        form->map(v, white, want);
        for (int c = 0; c < 3; c++)
            worst = hard_worse(worst, fabs((double) f->shown.c[c][i] -
                                           want[c]));
    }
    return worst;
}

// -- tables -------------------------------------------------------------------

/* Makes the curves' columns; each but `none` has a printed form. */
static void fill_ways(void)
{
    for (int n = 0; gp_tone_curves[n]; n++) {
        const char *const name = gp_tone_curves[n]->name;
        if (n >= EV || (gp_tone_curves[n]->map && !tone_form_of(name)))
            hard_die(name, "has no row in tone_forms.h");
        ways[n] = (struct way) {name, name, 0.0f, false};
    }
}

/* A row whose light is that of another row would prove nothing. */
static void check_own(int row, const struct gp_image *f)
{
    static uint64_t hash[HARD_CASES];
    hash[row] = hash_layer(&f->lit, gp_image_pixels(f));
    for (int i = 0; i < row; i++) {
        if (hard_is_run(&hard_cases[i]) && hash[i] == hash[row])
            hard_die(hard_cases[row].name, "is the frame of another row");
    }
}

static void print_errors(const struct hard_column *column)
{
    hard_table("Tone curves", "largest error of a sample, white being 1",
               column);
    for (int row = 0; row < HARD_CASES; row++) {
        const struct hard_case *const h = &hard_cases[row];
        if (!hard_is_run(h))
            continue;
        struct gp_image f = hard_lit(h);
        check_own(row, &f);
        hard_row(h->name);
        for (int i = 0; i < WAYS; i++)
            hard_cell(map_error(&ways[i], &f), column[i].bar);
        gp_image_free(&f);
    }
    hard_table_end();
}

/* A hash of a row's picture. */
static uint64_t hash_of(const struct way *w, int row, int threads)
{
    struct gp_image f = hard_lit(&hard_cases[row]);
    gp_set_threads(threads);
    map(w, &f);
    gp_set_threads(0);
    const uint64_t hash = hash_layer(&f.shown, gp_image_pixels(&f));
    gp_image_free(&f);
    return hash;
}

static void count_differing(int row, int threads, double *differ)
{
    for (int i = 0; i < WAYS; i++)
        differ[i] += hash_of(&ways[i], row, 1) !=
                     hash_of(&ways[i], row, threads);
}

void hard_tone(void)
{
    struct hard_column column[WAYS + 1] = {{NULL, 0}};
    fill_ways();
    for (int i = 0; i < WAYS; i++) {
        const struct tone_form *const form = tone_form_of(ways[i].curve);
        column[i] = (struct hard_column) {ways[i].name,
                                          form ? form->tolerance : 0.0};
    }
    print_errors(column);
    hard_thread_table("Tone curves, the same bytes",
                      "pictures that differ from those of one thread", column,
                      HARD_CASES, hard_is_threaded, count_differing);
}
