/* What things cost on one core of this machine: the numbers behind the
 * predictions.
 *
 * `make bench` measures them and writes them here in place (tests/bench/costs.c
 * changes the numbers alone), so that the next build predicts for the machine
 * it was made on. What `auto` takes depends on them, so they are part of the
 * build and never measured by the program itself.
 *
 * {a, b, c} are values at sizes a factor of 16 apart (named by each); between
 * them the logarithm of the size decides, beyond them they stay. One core: all
 * engines share their work among threads alike, so that more of them change
 * every prediction by about the same factor.
 */
#ifndef GP_GLARE_COSTS_H
#define GP_GLARE_COSTS_H

/* -- direct -- */

/* ms of any run: tasks handed out, scratch taken */
#define GP_COST_DIRECT_RUN 0.000999
/* ms of one row of one strip of the layer, however few sources reach it, for
 * layers of 512 KiB, 8 MiB, 128 MiB */
#define GP_COST_DIRECT_STRIP_ROW {0.000108, 0.000255, 0.000181}
/* ms of one row of one strip of one source's kernel, for laid-out kernels of
 * 48 KiB, 768 KiB, 12 MiB: beside a source that used the same taps, and where
 * they have to be fetched */
#define GP_COST_DIRECT_NEAR_ROW {5.5e-06, 5.4e-06, 5.93e-06}
#define GP_COST_DIRECT_FAR_ROW {7.83e-06, 1.02e-05, 2.93e-05}
/* ms of one source listed for one strip */
#define GP_COST_DIRECT_LIST 1.07e-05
/* ms of one kernel sample laid out, beside the memory's own */
#define GP_COST_DIRECT_LAYOUT 7.99e-07

/* -- fft -- */

/* Picoseconds of a complex transform of n points, over n log2 n, by the odd
 * factor of n and by floor(log2 n) from 6 to 13; planned by estimate, and by
 * measuring. The last is every other odd factor, as measured for 7. */
#define GP_COST_FFT_ESTIMATE_1 {218, 174, 153, 138, 135, 142, 191, 264}
#define GP_COST_FFT_ESTIMATE_3 {192, 155, 147, 223, 219, 216, 218, 225}
#define GP_COST_FFT_ESTIMATE_5 {205, 160, 147, 136, 135, 180, 199, 225}
#define GP_COST_FFT_ESTIMATE_9 {456, 167, 371, 339, 312, 336, 224, 345}
#define GP_COST_FFT_ESTIMATE_15 {241, 158, 371, 224, 214, 194, 192, 268}
#define GP_COST_FFT_ESTIMATE_25 {333, 223, 152, 259, 256, 265, 244, 265}
#define GP_COST_FFT_ESTIMATE_OTHER {399, 375, 330, 305, 264, 315, 322, 319}
#define GP_COST_FFT_MEASURE_1 {190, 142, 128, 119, 117, 130, 137, 191}
#define GP_COST_FFT_MEASURE_3 {167, 146, 128, 124, 173, 181, 188, 193}
#define GP_COST_FFT_MEASURE_5 {172, 146, 140, 121, 129, 175, 185, 183}
#define GP_COST_FFT_MEASURE_9 {254, 170, 220, 200, 189, 192, 192, 201}
#define GP_COST_FFT_MEASURE_15 {231, 136, 179, 179, 180, 175, 180, 188}
#define GP_COST_FFT_MEASURE_25 {309, 198, 129, 174, 185, 180, 180, 188}
#define GP_COST_FFT_MEASURE_OTHER {238, 222, 212, 204, 197, 205, 204, 196}
/* ms of any run */
#define GP_COST_FFT_RUN 0.00557
/* ms of one point of a pair of rows beside its transform: loaded or stored, and
 * moved to or from the matrix; for matrices of 256 KiB, 4 MiB, 64 MiB */
#define GP_COST_FFT_ROW_POINT {6.21e-07, 1.12e-06, 2.93e-06}
/* ms of one point of a column beside its two transforms: placed, multiplied,
 * kept; for spectra of 256 KiB, 4 MiB, 64 MiB */
#define GP_COST_FFT_COLUMN_POINT {1.58e-06, 2.04e-06, 2.73e-06}
/* ms of one source loaded, in one channel */
#define GP_COST_FFT_SOURCE 1.77e-06
/* ms to load the library, and to plan one length by estimate */
#define GP_COST_FFT_LIBRARY 0.924
#define GP_COST_FFT_PLAN_ESTIMATE 0.169
/* ms to plan one length by measuring, where no file keeps plans */
#define GP_COST_FFT_PLAN_MEASURE 257
/* ms of one kernel sample whose norms are found */
#define GP_COST_FFT_NORMS 1.6e-06

/* -- splat -- */

/* ms of the first frame: libraries, context, programs */
#define GP_COST_GL_START 37.5
/* ms of a quad that stays shut; of one that opens, whatever its size */
#define GP_COST_GL_SENSOR 3.86e-05
#define GP_COST_GL_POLYGON 0.0787
/* ms of a pixel of a polygon, blended; and gathered by tiles */
#define GP_COST_GL_BLEND 4.11e-05
#define GP_COST_GL_TILE 3.42e-06
/* ms of planning, for one source */
#define GP_COST_GL_SOURCE 0.000675
/* ms of a pixel of the frame up, cleared and back */
#define GP_COST_GL_TRANSFER 7.16e-06

/* -- memory -- */

/* ms of one byte that is touched for the first time: page faults */
#define GP_COST_FRESH_BYTE 4.8e-07

#endif
