/* Costs on one core, from which engines predict their time.
 *
 * Measured at 2.5 GHz with AVX2; `make bench` measures them on another machine.
 * The choice of `auto` depends on them, so they are part of the build, and the
 * program never measures them itself.
 *
 * {a, b, c} are values at sizes a factor of 16 apart (named by each); between
 * them the logarithm of the size decides, beyond them they stay. One core: all
 * engines share their work among threads alike, so that more of them change
 * every prediction by about the same factor. */
#ifndef GP_GLARE_COSTS_H
#define GP_GLARE_COSTS_H

/* -- direct -- */

/* ms of any run: starting tasks, allocating scratch */
#define GP_COST_DIRECT_RUN 0.00188
/* ms of one row of one strip of the layer, however few sources reach it, for
 * layers of 512 KiB, 8 MiB, 128 MiB */
#define GP_COST_DIRECT_STRIP_ROW {6.42e-05, 0.000132, 0.000125}
/* ms of one row of one strip of one source's kernel, for laid-out kernels of
 * 48 KiB, 768 KiB, 12 MiB: where a neighbour just used the same taps, and where
 * they are fetched from memory */
#define GP_COST_DIRECT_NEAR_ROW {5.43e-06, 5.33e-06, 6.38e-06}
#define GP_COST_DIRECT_FAR_ROW {7.58e-06, 9.96e-06, 2.83e-05}
/* ms of one tile of one quad of sources, with listing and making it */
#define GP_COST_DIRECT_QUAD_TILE (3.0 * 3.2e-6)
/* ms of one tap of all three channels, where sources share nothing: one 512 x
 * 512 source takes 0.063 ms */
#define GP_COST_DIRECT_TAP (0.063 / (512.0 * 512.0))
/* ms of one pixel of a layer that a direct part is added to */
#define GP_COST_DIRECT_PIXEL 2.5e-6
/* ms of one source listed for one strip */
#define GP_COST_DIRECT_LIST 3.93e-05
/* ms of laying out one kernel sample, without the memory's first touch */
#define GP_COST_DIRECT_LAYOUT 8.05e-07

/* -- fft -- */

/* Picoseconds of a complex transform of n points, over n log2 n, by the odd
 * factor of n: 1, 3, 5 (from 4096 points on the next), 9, 15, 25, others; of
 * FFTW 3.3.10, planned by measuring. gp_fft_length() and what fft sends direct
 * follow from these, and with them the last bits of a layer. */
#define GP_COST_FFT_PS {135, 190, 140, 190, 190, 190, 215}
#define GP_COST_FFT_PS_LARGE_5 185
/* Times as long with plans by estimate, by the same factors */
#define GP_COST_FFT_ESTIMATED {1.2, 1.2, 1.1, 1.65, 1.15, 1.4, 1.4}
/* ms of a pass for each nanosecond of its transforms: moved, placed,
 * multiplied */
#define GP_COST_FFT_PASS 1.35e-6

/* Passes in double over those in float. What fft makes in double depends on
 * it, too. */
#define GP_COST_FFT_DOUBLE 2
/* ns of one point of a transform in a pass, moved, placed and multiplied: what
 * the factor is for in the mean */
#define GP_COST_FFT_POINT 0.5
/* ms of any run */
#define GP_COST_FFT_RUN 0.00553
/* ms of one source loaded, in one channel */
#define GP_COST_FFT_SOURCE 1.31e-06
/* ms to load the library, and to plan one length by estimate */
#define GP_COST_FFT_LIBRARY 1.63
#define GP_COST_FFT_PLAN_ESTIMATE 0.274
/* ms to plan one length by measuring, where no file keeps plans */
#define GP_COST_FFT_PLAN_MEASURE 265
/* ms of finding the norms, for one kernel sample */
#define GP_COST_FFT_NORMS 1.59e-06

/* -- tail -- */

/* ms of one pixel of a layer that it is added to, in all channels; of one
 * source; and of one point of its spectrum, whose error is found */
#define GP_COST_TAIL_PIXEL 1.4e-6
#define GP_COST_TAIL_SOURCE 1.4e-6
#define GP_COST_TAIL_POINT 2e-5

/* ms of one sample of a whole kernel, of each recipe that has a tail */
#define GP_COST_WHOLE_SAMPLE 1.5e-5

/* -- splat --
 *
 * Measured on OSMesa. A GPU's costs would show only once its context is open,
 * and no prediction opens one. */

/* ms of the first frame: libraries, context, programs */
#define GP_COST_GL_START 75.5
/* ms of a quad that stays shut; of one that opens, whatever its size */
#define GP_COST_GL_SENSOR 4.08e-05
#define GP_COST_GL_POLYGON 0.0785
/* ms of a pixel of a polygon, blended; and gathered by tiles */
#define GP_COST_GL_BLEND 4.03e-05
#define GP_COST_GL_TILE 3.68e-06
/* ms of a pixel of a tile's entry, and of the entry itself; the side of
 * tiles follows from these, and with it the last bits of a layer. Mesa 22.3's
 * llvmpipe on two cores; `build/tests/glare pairs --time splat` */
#define GP_COST_TILE_PIXEL 1.3e-6
#define GP_COST_TILE_ENTRY 1e-4
/* ms of planning, for one source */
#define GP_COST_GL_SOURCE 0.000691
/* ms of a pixel of the frame up, cleared and back; of each field of the frame
 * after the first, whatever its size */
#define GP_COST_GL_TRANSFER 5.45e-06
#define GP_COST_GL_FIELD 0.28

/* ms of bounding the error of groups, for each pixel of the frame; and, for a
 * new kernel, for each point and channel of the plane that its spectrum is
 * for */
#define GP_COST_BOUND_PIXEL 1.75e-05
#define GP_COST_BOUND_POINT 1.04e-05

/* -- memory -- */

/* ms of touching one byte for the first time: page faults */
#define GP_COST_FRESH_BYTE 6.41e-07

#endif
