#include "glare/cost.h"

#include <math.h>

double gp_cost_at(const double value[3], double size, double first)
{
    const double at = log2(fmax(size, 1.0) / first) / 4.0;
    if (at <= 0.0)
        return value[0];
    if (at >= 2.0)
        return value[2];
    const int i = at < 1.0 ? 0 : 1;
    return value[i] + (at - i) * (value[i + 1] - value[i]);
}

enum { ODDS = 7, OCTAVES = 8, FIRST_OCTAVE = 6 };

static int odd_class(int n)
{
    static const int odd[ODDS - 1] = {1, 3, 5, 9, 15, 25};
    while (n % 2 == 0)
        n /= 2;
    int i = 0;
    while (i < ODDS - 1 && odd[i] != n)
        i++;
    return i;
}

double gp_cost_transform(int n, enum gp_fft_plan how)
{
    static const double cost[2][ODDS][OCTAVES] = {
        [GP_FFT_PLAN_ESTIMATE] = {
            GP_COST_FFT_ESTIMATE_1, GP_COST_FFT_ESTIMATE_3,
            GP_COST_FFT_ESTIMATE_5, GP_COST_FFT_ESTIMATE_9,
            GP_COST_FFT_ESTIMATE_15, GP_COST_FFT_ESTIMATE_25,
            GP_COST_FFT_ESTIMATE_OTHER,
        },
        [GP_FFT_PLAN_MEASURE] = {
            GP_COST_FFT_MEASURE_1, GP_COST_FFT_MEASURE_3,
            GP_COST_FFT_MEASURE_5, GP_COST_FFT_MEASURE_9,
            GP_COST_FFT_MEASURE_15, GP_COST_FFT_MEASURE_25,
            GP_COST_FFT_MEASURE_OTHER,
        },
    };
    if (n < 2)
        return 1e-5;
    const double size = log2((double) n);
    const int octave = (int) fmin(fmax(floor(size) - FIRST_OCTAVE, 0.0),
                                  OCTAVES - 1.0);
    return 1e-9 * cost[how][odd_class(n)][octave] * n * size;
}

/* `rows` real rows, two to a transform. */
static double rows_ms(double rows, int nx, double matrix, enum gp_fft_plan how)
{
    static const double point[3] = GP_COST_FFT_ROW_POINT;
    return ceil(rows / 2.0) * (gp_cost_transform(nx, how) +
                               nx * gp_cost_at(point, matrix, 0x1p18));
}

/* All columns of one channel, `passes` transforms each. */
static double columns_ms(const struct gp_fft_placing *p, int passes,
                         double spectrum, enum gp_fft_plan how)
{
    static const double point[3] = GP_COST_FFT_COLUMN_POINT;
    return (p->nx / 2 + 1.0) *
           (passes * gp_cost_transform(p->ny, how) +
            passes / 2.0 * p->ny * gp_cost_at(point, spectrum, 0x1p18));
}

/* Bytes of half a spectrum of so many rows. */
static double bytes_of(const struct gp_fft_placing *p, double rows)
{
    return (p->nx / 2 + 1.0) * rows * 2.0 * sizeof(float);
}

double gp_cost_passes(const struct gp_sources *s,
                      const struct gp_fft_placing *p, enum gp_fft_plan how)
{
    int light = 0;
    for (int y = p->in.y0; y < p->in.y1; y++)
        light += s->row[y + 1] > s->row[y];
    const int out = gp_rect_h(p->out);
    const double matrix = bytes_of(p, light > out ? light : out);
    return 3.0 * (rows_ms(light, p->nx, matrix, how) +
                  columns_ms(p, 2, bytes_of(p, p->ny), how) +
                  rows_ms(out, p->nx, matrix, how) +
                  GP_COST_FFT_SOURCE * (double) s->n);
}

double gp_cost_spectrum(const struct gp_kernel *k,
                        const struct gp_fft_placing *p, enum gp_fft_plan how)
{
    const double rows = gp_rect_h(p->taps), matrix = bytes_of(p, rows);
    const double spectrum = bytes_of(p, p->ny);
    const int channels = k->grey ? 1 : 3;
    return channels * (rows_ms(rows, p->nx, matrix, how) +
                       columns_ms(p, 1, spectrum, how)) +
           GP_COST_FRESH_BYTE * (matrix + channels * spectrum);
}
