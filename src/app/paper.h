/* Three frames and a kernel after Ando et al. 2007, section 5, for bench: few
 * points, a facade of windows, and a sky that fills the frame.
 *
 * Made of integers, sums, products, quotients and square roots alone, all of
 * which IEEE 754 rounds in one way: the same bytes on any machine.
 */
#ifndef GP_APP_PAPER_H
#define GP_APP_PAPER_H

#include "core/frame.h"
#include "core/status.h"

enum gp_paper_kind {
    GP_PAPER_POINTS,   // 32 points between pixels, luminance 10 to 5000
    GP_PAPER_WINDOWS,  // 16 x 12 windows, a third lit at 5 to 50; lamps
    GP_PAPER_SKY,      // clouds of 2 to 20 over an uneven horizon
    GP_PAPER_KINDS,
};

/* The paper's size of glare images. Its frames were 1024 x 786, as printed. */
enum { GP_PAPER_W = 1024, GP_PAPER_H = 768, GP_PAPER_KERNEL = 512 };

/* What the paper reports for its approximate method on a GeForce 7800 GTX:
 * frames a second of the whole picture, scene and all. */
struct gp_paper_rate {
    const char *name;  // of the frame here
    const char *rate;  // which of the paper's figures it stands beside
    int fps;
};
extern const struct gp_paper_rate gp_paper_rates[GP_PAPER_KINDS];

/* Makes a frame of w x h pixels, float, BT.709, everything else dim (0.05 to
 * 0.8). Luminance counts in that of BT.709.
 *   out  written only on GP_OK; free with gp_frame_free()
 * Errors: GP_ERR_USAGE under 64 x 48 or over 16384 pixels a side; GP_ERR_BUG
 * out of memory. */
GP_MUST_CHECK gp_status gp_paper_frame(const struct gp_log *log,
                                       enum gp_paper_kind kind, int w, int h,
                                       struct gp_frame *out);

/* Makes a kernel image of size x size pixels with its centre at pixel
 * (size / 2, size / 2): a halo and coloured streaks, 0 on its border.
 * Errors: GP_ERR_USAGE under 16 or over 4096; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_paper_kernel(const struct gp_log *log, int size,
                                        struct gp_frame *out);

#endif
