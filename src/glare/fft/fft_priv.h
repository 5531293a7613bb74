// SPDX-License-Identifier: Apache-2.0
/* Shared by the .c files of this folder. split.c: places a convolution on its
 * torus, predicts its cost, bounds its error, and chooses the part of the sum
 * that goes direct. */
#ifndef GP_GLARE_FFT_FFT_PRIV_H
#define GP_GLARE_FFT_FFT_PRIV_H

#include "glare/fft/fft.h"

#include <stdbool.h>

// -- costs --------------------------------------------------------------------
//
// Milliseconds on one core of 2.5 GHz with AVX2, measured. Lengths of transforms
// and what goes direct follow from them, and with these the last bits of a
// layer: so they are part of the build, and never measured by the program.

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

/* ms of one tile of one quad of sources, with listing and making it */
#define GP_COST_DIRECT_QUAD_TILE (3.0 * 3.2e-6)
/* ms of one tap of all three channels, where sources share nothing: one 512 x
 * 512 source takes 0.063 ms */
#define GP_COST_DIRECT_TAP (0.063 / (512.0 * 512.0))
/* ms of one pixel of a layer that a direct part is added to */
#define GP_COST_DIRECT_PIXEL 2.5e-6

/* Returns FFTW's wisdom about the plans of length n, measured once; NULL where
 * none is known. known.c, printed by tests/bench/plans.c. */
const char *gp_fft_known(int n);

/* Tests whether what has this serial was made for k. */
static inline bool gp_fft_is_of(unsigned long serial, const struct gp_kernel *k)
{
    return serial && serial == k->serial;
}

/* Returns v modulo n, in [0, n). */
static inline int gp_fft_wrap(int v, int n)
{
    return v % n < 0 ? v % n + n : v % n;
}

/* Plane i of a matrix, as the plane of channel c; borrowed. */
static inline struct gp_fft_matrix
gp_fft_one_channel(const struct gp_fft_matrix *m, int i, int c)
{
    struct gp_fft_matrix view = {
        .columns = m->columns, .pitch = m->pitch, .of = m->of,
    };
    view.z[c] = m->z[i];
    return view;
}

/* The places of sources, kernel and outputs on the torus of nx * ny
 * samples. The smallest on which no wrapped light reaches an output. */
struct gp_fft_placing {
    int nx, ny;          // 0 when no light reaches the frame
    struct gp_rect in;   // box of the sources
    struct gp_rect out;  // pixels of the frame that light reaches
    struct gp_rect taps; // offsets from source to pixel that occur
};

/* Places sources (at least one) and a kernel. */
struct gp_fft_placing gp_fft_place(const struct gp_sources *s,
                                   const struct gp_kernel *k);

/* Milliseconds of the passes on one core: the frame's rows there and back and
 * all columns twice, for three channels. */
double gp_fft_passes_ms(const struct gp_sources *s,
                        const struct gp_fft_placing *p, enum gp_fft_plan how);

/* Bounds rel_l2 of transforms of s with k, where the layer's norm is at least
 * `least`; INFINITY where that is 0.
 *
 * Roundings are taken as independent and of mean 0, so that n stages of a
 * transform add up to sqrt n (Higham and Mary 2019). One is uniform in +-2^-24
 * of the power of two under its result, whose mantissa m is as likely as 1 / m:
 * r = 2^-24 sqrt(1 / (8 ln 2)) = 0.425 * 2^-24 of the result in the mean, the
 * error of a stage that only adds. A butterfly a +- w b rounds w b in its four
 * products, in their two sums, and in w: 3 r^2 of |b|^2, and then adds: with
 * |a| = |b| it is within sqrt(3 / 2 + 1) r = 0.672 * 2^-24 of its norm. Both
 * are rounded up by a tenth. Independent as the errors of the three transforms
 * are, they are added here as if they were one: the largest that a search for
 * the worst frame found is 0.56 of the sum, and 0.3 is usual (the suite
 * adversary). Errors of the two transforms forward are spread
 * over all frequencies, and meet the other factor's norm; where they lie with
 * the light, at the lowest, only additions made them. Those, and those of the
 * transform back, grow with the whole layer, in the frame and beyond it, which
 * Young's inequality limits. */
double gp_fft_bound(const struct gp_sources *s, const struct gp_kernel *k,
                    double least, const struct gp_fft_placing *p);

/* Bounds the error of any sample of one channel that transforms of a frame
 * give, for light and a kernel that are not negative.
 *
 *   most  of a sample of the layer on the torus
 *   norm  of the layer there, at most
 *   pair  the most that a source adds to a pixel; INFINITY if unknown
 *
 * Roundings count as independent, uniform and of mean 0, and a stage's have the
 * deviation STAGE 2^-24 |v| in a node of value v, as for gp_fft_bound(). A
 * uniform variable is strictly sub-Gaussian (Arbel, Marchal and Nguyen 2020), so
 * the sum of all stays under t of its deviations, but for a chance of
 * 2 exp(-t^2 / 2): 4.6e-11 a sample with t = 7, one in 1000 frames of 4K.
 *
 * A stage that has folded n samples, nx ny / n apart, into each of its nodes
 * meets a pixel with nodes of light v and of kernel g: by Parseval the sum of
 * |v|^2 |g|^2 over a coset's n frequencies is 1 / n times the square of the
 * circular convolution of both cosets, whose samples are at most n pair. Summed
 * over cosets, as nothing is negative, that is at most the mean square of the
 * layer on n samples: at most most^2, norm^2 / n, and n pair most. The kernel's
 * transform is the same with light and kernel changed; the one back has the
 * layer's parts in its nodes, and only the first two limits. Two rows that
 * share a transform have half of its error each: the mean of their own and of
 * what their light in each other's place would make, which has the same limits.
 * The product with the kernel is within the sum's term n = 1. */
double gp_fft_pixel_error(const struct gp_fft_placing *p, double most,
                          double norm, double pair);

// -- reach.c ------------------------------------------------------------------

/* The support of one channel of a kernel: where it is not 0, by offsets from
 * its centre. */
struct gp_fft_run {
    int from, to; // half-open; empty where to <= from
};
struct gp_fft_node {
    struct gp_fft_run least, most; // in each of its rows; in all of
                                   // its rows' runs are in
    bool full;                     // each row is one run, and all are equal
};
struct gp_fft_shape {
    uint32_t *row;            // runs of row y are [row[y], row[y + 1])
    struct gp_fft_run *run;
    struct gp_fft_node *node; // of all rows; after that of n rows, more than 1,
                              // follow those of the first n / 2 rows and those
                              // of the others
};

/* Those of channel c; where the kernel has a tail, which fills what is between
 * them, rows without gaps, 16 neighbours alike. Free with
 * gp_fft_shape_free(). */
GP_MUST_CHECK gp_status gp_fft_shape_make(const struct gp_log *log,
    const struct gp_kernel *k, int c, struct gp_fft_shape *out);
void gp_fft_shape_free(struct gp_fft_shape *s);

/* The pixels of a frame that a kernel's samples other than 0 reach from some
 * source. */
struct gp_fft_reach;

/* Opens it; each row is found when it is first asked for. `shape` of the
 * kernel's channels, which may be the same ones, and all else are borrowed.
 * Errors: GP_ERR_BUG out of memory. Free with gp_fft_reach_free(). */
GP_MUST_CHECK gp_status gp_fft_reach_open(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *k,
    const struct gp_fft_shape *const shape[3], struct gp_fft_reach **out);

/* Makes samples of row y of a layer in (0, noise] 0 that are not reached in
 * channel c; `v` has the row's src->w. Tasks may clear different rows at once,
 * not different channels of one row. */
void gp_fft_reach_clear(struct gp_fft_reach *r, int c, int y, int thread,
                        float noise, float *v);
void gp_fft_reach_free(struct gp_fft_reach **reach);

// -- the direct part ---------------------------------------------------------

/* The part of the sum that goes direct, so that float rounding stays unseen.
 *
 * The rounding noise of a transform spreads evenly over the frame, about
 * |sources| |kernel| 2^-24 strong: one hot pixel lays it over the darkest
 * corner. Two parts of the sum carry nearly all of that product and cost
 * little by themselves: the kernel's core, for all sources, and the few
 * hottest sources, for the whole kernel. What remains is transformed; in double
 * where that is cheaper. */

enum { GP_FFT_CORES = 12 };

/* Rounding in double over that in float. */
#define GP_FFT_DOUBLE_ROUNDING 0x1p-29

/* Radii in x and y of the core that may go direct: none, squares, and where
 * light leaves along an axis, as streaks do, rectangles. */
struct gp_fft_core {
    int x, y; // pixels; -1: none
};
extern const struct gp_fft_core gp_fft_cores[GP_FFT_CORES];

static inline bool gp_fft_same_core(struct gp_fft_core a, struct gp_fft_core b)
{
    return a.x == b.x && a.y == b.y;
}

/* Norms of the kernel without its core (and its tail), largest channel, one a
 * core. */
void gp_fft_far_norms(const struct gp_kernel *k, double norm[GP_FFT_CORES]);

struct gp_fft_split {
    struct gp_fft_core core; // of gp_fft_cores
    float hot;        // a source with a channel from this up goes direct
                      // whole; INFINITY sends none
    size_t hot_count;
    bool in_double;   // the transforms are, and nothing goes direct
    double rounding;  // expected largest error of a pixel over its own value,
                      // at least gp_sources_dark()
    double ms;        // predicted on one core: of the direct part, or of what
                      // double takes more than float
};

/* Chooses how `rounding`, the expected one, is kept within 1e-6, and within what
 * shows near black: half a code of 8 bits at EV 0, 0.5 % of the darkest light; in
 * a frame that is black that at EV +6:
 *   nothing, where float alone does; else
 *   the cheapest split that does, for no more than double takes; else
 *   nothing, where float alone is within 1e-4 (a fifth of what half rounds) and
 *        does not show, as in a bright sky; else
 *   the transforms in double, which keep it to a range of light of about 1e10.
 * A pixel's own value counts as no less than gp_sources_dark(). Where the kernel has a coarse far part, which leaves up to 2e-4 itself, the
 * figures are 1e-5, and 0.5 % of the layer where only that part is left, for half
 * of the transform or 5 ms, 2e-3 and, for what double takes, 1e-4; of a black
 * frame the layer counts as what shows.
 *   tail       from gp_fft_far_norms()
 *   points     nx * ny
 *   fft_ms     predicted for the transform in float
 *   gain       of the layer in the composite, > 0
 * The choice depends only on the frame, never on the number of threads. */
void gp_fft_split_choose(const struct gp_sources *src,
    const struct gp_kernel *k, const double tail[GP_FFT_CORES], double points,
    double fft_ms, double gain, struct gp_fft_split *out);

// -- spectrum.c ---------------------------------------------------------------

/* The spectrum of a kernel without its core, kept from frame to frame. */
struct gp_fft_spectrum {
    unsigned long kernel;   // serial
    struct gp_fft_placing placing;
    struct gp_fft_core core;
    bool in_double;
    struct gp_fft_matrix m; // transposed, scaled
};

/* Tests whether it is that of k, so placed, as a split takes it. */
bool gp_fft_has_spectrum(const struct gp_fft_spectrum *s,
    const struct gp_kernel *k, const struct gp_fft_placing *p,
    const struct gp_fft_split *split);

/* Tests whether a request keeps it. A coloured kernel's is not kept that no
 * later frame takes; a grey one's is made for the first channel, and the others
 * take it. */
bool gp_fft_keeps_spectrum(const struct gp_glare_request *req);

/* A kernel's spectrum in the passes of a frame: there, or made with them. */
struct gp_fft_making {
    struct gp_fft_kernel passes;     // what they take
    const struct gp_kernel *kernel;  // of its rows: borrowed, as p is
    const struct gp_fft_placing *p;
    struct gp_fft_core core;
    int first;                       // offset of row 0
    struct gp_fft_matrix rows;       // of one channel; none where it is there
    bool lent;                       // these are in a plane of the layer
    int *places;
};

/* Finds the spectrum in *s, or makes room there for that of the kernel without
 * its samples in the split's core; the layer's last plane may be scratch until
 * the rows of the last channel are loaded and multiplied.
 * Errors: GP_ERR_BUG out of memory. Free with gp_fft_making_free(). */
GP_MUST_CHECK gp_status gp_fft_making_open(const struct gp_glare_request *req,
    struct gp_fft_spectrum *s, const struct gp_fft_placing *p,
    const struct gp_fft_split *split, struct gp_fft_making *out);
void gp_fft_making_free(struct gp_fft_making *m);

/* Transforms the rows of channel fft->channel, where the spectrum is made of
 * them: `view` is to hold them. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_fft_making_load(const struct gp_fft_request *fft,
    struct gp_fft_making *m, struct gp_fft_matrix *view);

#endif
