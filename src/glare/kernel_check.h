/* Figures and faults of a kernel: glarepp kernel --check prints them, and a run
 * warns of faults that its frames show. */
#ifndef GP_GLARE_KERNEL_CHECK_H
#define GP_GLARE_KERNEL_CHECK_H

#include "glare/kernel.h"

#include <stdbool.h>

/* Luminance by the weights given; offsets in pixels from the centre's pixel. */
struct gp_kernel_figures {
    double light;        // sum of all samples
    double own;          // share of it that stays in its pixel
    double centre;       // the centre's sample; 0 outside
    double rim;          // how far the outermost rows and columns drop to 0
                         // beyond what the slope before them drops
    double left_out;     // of a model, as in struct gp_kernel
    // by gp_kernel_measure() only
    double peak;         // largest sample
    int peak_at[2];
    double centroid[2];
    double border;       // share of magnitudes in the outermost rows, columns
    double asymmetry;    // norm of k(d) - k(-d) over that of k
    long long negatives; // samples with a channel under 0
    bool measured;
};

/* Frames and settings that a kernel is for. */
struct gp_kernel_use {
    bool add;            // --mix add
    bool ends;           // it ends where light still goes on, inside the frames
    double brightest;    // luminance of the brightest source; 0: not known
};

/* Figures that cost no more than the kernel's outline. Of a kernel with a tail
 * `rim` is the core's. */
void gp_kernel_glance(const struct gp_kernel *k, const float luminance[3],
                      struct gp_kernel_figures *out);
/* All figures, of a kernel without tail. */
void gp_kernel_measure(const struct gp_kernel *k, const float luminance[3],
                       struct gp_kernel_figures *out);

/* Writes fault `i`, from 0 on, as one line that says what to do. False, with
 * `line` empty, where the kernel does not have it. */
enum { GP_KERNEL_FAULTS = 5, GP_FAULT_BYTES = 256 };
bool gp_kernel_fault(const struct gp_kernel_figures *f,
                     const struct gp_kernel_use *use, int i,
                     char line[GP_FAULT_BYTES]);

#endif
