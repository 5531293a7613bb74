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
#define GP_COST_DIRECT_RUN 0.00188
/* ms of one row of one strip of the layer, however few sources reach it, for
 * layers of 512 KiB, 8 MiB, 128 MiB */
#define GP_COST_DIRECT_STRIP_ROW {6.42e-05, 0.000132, 0.000125}
/* ms of one row of one strip of one source's kernel, for laid-out kernels of
 * 48 KiB, 768 KiB, 12 MiB: beside a source that used the same taps, and where
 * they have to be fetched */
#define GP_COST_DIRECT_NEAR_ROW {5.43e-06, 5.33e-06, 6.38e-06}
#define GP_COST_DIRECT_FAR_ROW {7.58e-06, 9.96e-06, 2.83e-05}
/* ms of one tile of one quad of sources, its listing and making included */
#define GP_COST_DIRECT_QUAD_TILE 1.02e-05
/* ms of one source listed for one strip */
#define GP_COST_DIRECT_LIST 3.93e-05
/* ms of one kernel sample laid out, beside the memory's own */
#define GP_COST_DIRECT_LAYOUT 8.05e-07

/* -- fft -- */

/* Picoseconds of a complex transform of n points, over n log2 n, by the odd
 * factor of n and by floor(log2 n) from 6 to 13; planned by estimate, and by
 * measuring. The last is every other odd factor, as measured for 7. */
#define GP_COST_FFT_ESTIMATE_1 {334, 258, 154, 140, 135, 140, 197, 266}
#define GP_COST_FFT_ESTIMATE_3 {191, 167, 151, 228, 226, 217, 227, 231}
#define GP_COST_FFT_ESTIMATE_5 {206, 170, 156, 141, 139, 185, 201, 228}
#define GP_COST_FFT_ESTIMATE_9 {480, 177, 380, 341, 317, 338, 224, 345}
#define GP_COST_FFT_ESTIMATE_15 {250, 158, 363, 228, 217, 196, 201, 261}
#define GP_COST_FFT_ESTIMATE_25 {336, 226, 153, 260, 263, 272, 242, 264}
#define GP_COST_FFT_ESTIMATE_OTHER {411, 380, 330, 316, 263, 306, 323, 321}
#define GP_COST_FFT_MEASURE_1 {196, 153, 129, 124, 128, 131, 136, 183}
#define GP_COST_FFT_MEASURE_3 {179, 144, 128, 125, 178, 179, 196, 191}
#define GP_COST_FFT_MEASURE_5 {186, 147, 131, 134, 129, 177, 192, 185}
#define GP_COST_FFT_MEASURE_9 {272, 176, 221, 199, 199, 191, 191, 203}
#define GP_COST_FFT_MEASURE_15 {228, 137, 187, 180, 178, 179, 177, 185}
#define GP_COST_FFT_MEASURE_25 {329, 202, 129, 194, 186, 185, 176, 186}
#define GP_COST_FFT_MEASURE_OTHER {231, 215, 204, 228, 206, 209, 204, 196}
/* ms of any run */
#define GP_COST_FFT_RUN 0.00553
/* ms of one point of a pair of rows beside its transform: loaded or stored, and
 * moved to or from the matrix; for matrices of 256 KiB, 4 MiB, 64 MiB */
#define GP_COST_FFT_ROW_POINT {5.96e-07, 8.72e-07, 2.17e-06}
/* ms of one point of a column beside its two transforms: placed, multiplied,
 * kept; for spectra of 256 KiB, 4 MiB, 64 MiB */
#define GP_COST_FFT_COLUMN_POINT {7.53e-07, 1.29e-06, 1.99e-06}
/* ms of one source loaded, in one channel */
#define GP_COST_FFT_SOURCE 1.31e-06
/* ms to load the library, and to plan one length by estimate */
#define GP_COST_FFT_LIBRARY 1.63
#define GP_COST_FFT_PLAN_ESTIMATE 0.274
/* ms to plan one length by measuring, where no file keeps plans */
#define GP_COST_FFT_PLAN_MEASURE 265
/* ms of one kernel sample whose norms are found */
#define GP_COST_FFT_NORMS 1.59e-06

/* -- splat --
 *
 * On the context there was. What a GPU takes shows only once a context is open,
 * which no prediction does. */

/* ms of the first frame: libraries, context, programs */
#define GP_COST_GL_START 75.5
/* ms of a quad that stays shut; of one that opens, whatever its size */
#define GP_COST_GL_SENSOR 4.08e-05
#define GP_COST_GL_POLYGON 0.0785
/* ms of a pixel of a polygon, blended; and gathered by tiles */
#define GP_COST_GL_BLEND 4.03e-05
#define GP_COST_GL_TILE 3.68e-06
/* ms of planning, for one source */
#define GP_COST_GL_SOURCE 0.000691
/* ms of a pixel of the frame up, cleared and back */
#define GP_COST_GL_TRANSFER 5.45e-06

/* -- memory -- */

/* ms of one byte that is touched for the first time: page faults */
#define GP_COST_FRESH_BYTE 6.41e-07

#endif
