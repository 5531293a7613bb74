/* What things cost on one core of this machine: the numbers behind the
 * predictions of direct and fft.
 *
 * `make bench` measures them and writes them here in place (tests/bench/costs.c
 * changes the numbers alone), so that the next build predicts for the machine
 * it was made on. What `auto` takes depends on them, so they are part of the
 * build and never measured by the program itself.
 *
 * {a, b, c} are values at sizes a factor of 16 apart (named by each); between
 * them the logarithm of the size decides, beyond them they stay. One core: all
 * engines share their work among threads alike, so that more of them change
 * every prediction by the same factor.
 */
#ifndef GP_GLARE_COSTS_H
#define GP_GLARE_COSTS_H

/* -- direct -- */

/* ms of any run: tasks handed out, scratch taken */
#define GP_COST_DIRECT_RUN 0.01
/* ms of one row of one strip of the layer, however few sources reach it */
#define GP_COST_DIRECT_STRIP_ROW 8.5e-5
/* ms of one row of one strip of one source's kernel, for laid-out kernels of
 * 48 KiB, 768 KiB, 12 MiB */
#define GP_COST_DIRECT_SOURCE_ROW {5e-6, 6e-6, 8e-6}
/* ms of one source listed for one strip */
#define GP_COST_DIRECT_LIST 3e-6
/* ms of one kernel sample laid out, for the first frame */
#define GP_COST_DIRECT_LAYOUT 6e-6

/* -- fft -- */

/* Picoseconds of a complex transform of n points, over n log2 n, by the odd
 * factor of n, for n of 64, 1024 (and 256 the mean), 16384; as planned by
 * estimate and by measuring. The last is every other odd factor. */
#define GP_COST_FFT_ESTIMATE_1 {200, 137, 200}
#define GP_COST_FFT_ESTIMATE_3 {180, 200, 210}
#define GP_COST_FFT_ESTIMATE_5 {180, 140, 210}
#define GP_COST_FFT_ESTIMATE_9 {440, 320, 300}
#define GP_COST_FFT_ESTIMATE_15 {180, 220, 200}
#define GP_COST_FFT_ESTIMATE_25 {250, 256, 256}
#define GP_COST_FFT_ESTIMATE_OTHER {300, 300, 300}
#define GP_COST_FFT_MEASURE_1 {160, 121, 150}
#define GP_COST_FFT_MEASURE_3 {150, 130, 180}
#define GP_COST_FFT_MEASURE_5 {150, 123, 185}
#define GP_COST_FFT_MEASURE_9 {220, 195, 188}
#define GP_COST_FFT_MEASURE_15 {180, 177, 176}
#define GP_COST_FFT_MEASURE_25 {185, 185, 185}
#define GP_COST_FFT_MEASURE_OTHER {200, 200, 200}
/* ms of any run */
#define GP_COST_FFT_RUN 0.02
/* ms of one point of a pair of rows beside its transform: loaded or stored, and
 * moved to or from the matrix; for matrices of 256 KiB, 4 MiB, 64 MiB */
#define GP_COST_FFT_ROW_POINT {1e-6, 1.5e-6, 2e-6}
/* ms of one point of a column beside its two transforms: placed, multiplied,
 * kept; for spectra of 256 KiB, 4 MiB, 64 MiB */
#define GP_COST_FFT_COLUMN_POINT {1e-6, 1.5e-6, 2e-6}
/* ms of one source loaded, in one channel */
#define GP_COST_FFT_SOURCE 2e-6
/* ms to load the library, and to plan one length by estimate */
#define GP_COST_FFT_LIBRARY 0.6
#define GP_COST_FFT_PLAN_ESTIMATE 0.35
/* ms to plan one length by measuring, where no file keeps plans */
#define GP_COST_FFT_PLAN_MEASURE 350
/* ms of one kernel sample whose norms are found */
#define GP_COST_FFT_NORMS 3e-6

/* -- memory -- */

/* ms of one byte that is touched for the first time: page faults */
#define GP_COST_FRESH_BYTE 2.5e-7

#endif
