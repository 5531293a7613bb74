/* tone with a memory that is full at the n-th allocation, for every n: one
 * line, no block lost, and the same numbers when memory is back. */
#include "unit.h"
#include "core/colour.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "tone/tone.h"

#include "starved.h"

enum { W = 33, H = 21 };

static struct gp_frame frame;
static double found; // by the last run

static gp_status run_map(void)
{
    struct gp_tone_params p = GP_TONE_DEFAULTS;
    float scale;
    const gp_status st = gp_tone_map(&said_log, &p, &frame, &scale);
    for (int i = 0; !st && i < W * H; i++)
        found += (double) frame.shown.c[i % 3][i];
    gp_planes_free(&frame.shown);
    return st;
}

static void memory_is_full(void **state)
{
    (void) state;
    gp_set_threads(2);
    frame = (struct gp_frame) {.data = {0, 0, W, H}, .display = {0, 0, W, H}};
    memcpy(frame.luminance, gp_rec709_luminance, sizeof frame.luminance);
    memcpy(frame.chromaticities, gp_rec709_chromaticities,
           sizeof frame.chromaticities);
    assert_int_equal(gp_planes_make(NULL, "lit", W * H, &frame.lit), GP_OK);
    for (int i = 0; i < 3 * W * H; i++)
        frame.lit.c[i % 3][i / 3] = (float) (i * 5 % 97) * 0.05f;
    starve("tone map", run_map, &found, 3);
    gp_planes_free(&frame.lit);
}

SUITE_OF(starved_tone, NULL, NULL, memory_is_full)
