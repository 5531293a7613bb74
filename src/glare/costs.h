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
#define GP_COST_DIRECT_RUN 0.0012
/* ms of one row of one strip of the layer, however few sources reach it, for
 * layers of 512 KiB, 8 MiB, 128 MiB */
#define GP_COST_DIRECT_STRIP_ROW {6.48e-05, 0.000212, 0.00013}
/* ms of one row of one strip of one source's kernel, for laid-out kernels of
 * 48 KiB, 768 KiB, 12 MiB: beside a source that used the same taps, and where
 * they have to be fetched */
#define GP_COST_DIRECT_NEAR_ROW {5.48e-06, 5.5e-06, 6.11e-06}
#define GP_COST_DIRECT_FAR_ROW {7.7e-06, 1.02e-05, 4.09e-05}
/* ms of one tile of one quad of sources, its listing and making included */
#define GP_COST_DIRECT_QUAD_TILE 1.06e-05
/* ms of one source listed for one strip */
#define GP_COST_DIRECT_LIST 4.01e-05
/* ms of one kernel sample laid out, beside the memory's own */
#define GP_COST_DIRECT_LAYOUT 8.15e-07

/* -- fft -- */

/* Picoseconds of a complex transform of n points, over n log2 n, by the odd
 * factor of n and by floor(log2 n) from 6 to 13; planned by estimate, and by
 * measuring. The last is every other odd factor, as measured for 7. */
#define GP_COST_FFT_ESTIMATE_1 {232, 178, 158, 137, 131, 135, 189, 261}
#define GP_COST_FFT_ESTIMATE_3 {190, 158, 146, 224, 216, 212, 216, 224}
#define GP_COST_FFT_ESTIMATE_5 {215, 178, 158, 139, 135, 182, 196, 226}
#define GP_COST_FFT_ESTIMATE_9 {463, 168, 374, 333, 324, 333, 217, 339}
#define GP_COST_FFT_ESTIMATE_15 {239, 157, 351, 226, 211, 196, 198, 264}
#define GP_COST_FFT_ESTIMATE_25 {353, 227, 154, 262, 248, 263, 231, 249}
#define GP_COST_FFT_ESTIMATE_OTHER {405, 394, 345, 311, 270, 317, 331, 321}
#define GP_COST_FFT_MEASURE_1 {195, 149, 132, 122, 119, 129, 139, 182}
#define GP_COST_FFT_MEASURE_3 {176, 141, 129, 121, 173, 176, 192, 190}
#define GP_COST_FFT_MEASURE_5 {188, 147, 127, 121, 124, 183, 182, 186}
#define GP_COST_FFT_MEASURE_9 {285, 167, 221, 194, 192, 184, 188, 197}
#define GP_COST_FFT_MEASURE_15 {218, 205, 184, 176, 179, 176, 177, 185}
#define GP_COST_FFT_MEASURE_25 {269, 204, 136, 174, 185, 180, 177, 187}
#define GP_COST_FFT_MEASURE_OTHER {233, 221, 209, 205, 200, 206, 203, 198}
/* ms of any run */
#define GP_COST_FFT_RUN 0.00496
/* ms of one point of a pair of rows beside its transform: loaded or stored, and
 * moved to or from the matrix; for matrices of 256 KiB, 4 MiB, 64 MiB */
#define GP_COST_FFT_ROW_POINT {5.48e-07, 1.11e-06, 2.23e-06}
/* ms of one point of a column beside its two transforms: placed, multiplied,
 * kept; for spectra of 256 KiB, 4 MiB, 64 MiB */
#define GP_COST_FFT_COLUMN_POINT {6.56e-07, 1.87e-06, 2.13e-06}
/* ms of one source loaded, in one channel */
#define GP_COST_FFT_SOURCE 1.77e-06
/* ms to load the library, and to plan one length by estimate */
#define GP_COST_FFT_LIBRARY 0.994
#define GP_COST_FFT_PLAN_ESTIMATE 0.188
/* ms to plan one length by measuring, where no file keeps plans */
#define GP_COST_FFT_PLAN_MEASURE 260
/* ms of one kernel sample whose norms are found */
#define GP_COST_FFT_NORMS 1.78e-06

/* -- splat --
 *
 * On the context there was. What a GPU takes shows only once a context is open,
 * which no prediction does. */

/* ms of the first frame: libraries, context, programs */
#define GP_COST_GL_START 41.4
/* ms of a quad that stays shut; of one that opens, whatever its size */
#define GP_COST_GL_SENSOR 3.94e-05
#define GP_COST_GL_POLYGON 0.0809
/* ms of a pixel of a polygon, blended; and gathered by tiles */
#define GP_COST_GL_BLEND 4.13e-05
#define GP_COST_GL_TILE 3.5e-06
/* ms of planning, for one source */
#define GP_COST_GL_SOURCE 0.000697
/* ms of a pixel of the frame up, cleared and back */
#define GP_COST_GL_TRANSFER 7.16e-06

/* -- memory -- */

/* ms of one byte that is touched for the first time: page faults */
#define GP_COST_FRESH_BYTE 4.58e-07

#endif
