/* tone with a memory that is full at the n-th allocation, for every n: one
 * line, no block lost, and the same numbers when memory is back. */
#include "unit.h"
#include "core/colour.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "fail.h"
#include "said.h"
#include "tone/flip.h"
#include "tone/tone.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { W = 33, H = 21 };

static struct gp_frame frame;
static struct gp_planes other;
static double found; // by the last run

static gp_status run_ldr(void)
{
    return gp_flip_ldr(&said_log, W, H, &frame.lit, &other, 67.0f, NULL,
                       &found);
}

static gp_status run_hdr(void)
{
    return gp_flip_hdr(&said_log, W, H, &frame.lit, &other, 67.0f, NULL, NULL,
                       &found);
}

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

static void make_pictures(void)
{
    frame = (struct gp_frame) {.data = {0, 0, W, H}, .display = {0, 0, W, H}};
    memcpy(frame.luminance, gp_rec709_luminance, sizeof frame.luminance);
    memcpy(frame.chromaticities, gp_rec709_chromaticities,
           sizeof frame.chromaticities);
    assert_int_equal(gp_planes_make(NULL, "lit", W * H, &frame.lit), GP_OK);
    assert_int_equal(gp_planes_make(NULL, "other", W * H, &other), GP_OK);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < W * H; i++) {
            frame.lit.c[c][i] = (float) (i * (c + 3) % 97) * 0.05f;
            other.c[c][i] = (float) (i * (c + 5) % 89) * 0.05f;
        }
    }
}

static void memory_is_full(void **state)
{
    static const struct {
        const char *name;
        gp_status (*run)(void);
        int least; // allocations
    } rows[] = {
        {"LDR-FLIP", run_ldr, 2}, {"HDR-FLIP", run_hdr, 8},
        {"tone map", run_map, 3},
    };
    (void) state;
    gp_set_threads(2);
    make_pictures();
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        found = 0.0;
        assert_int_equal(rows[i].run(), GP_OK);
        const double want = found;
        assert_true(want > 0.0);
        long n = 1;
        for (;; n++) {
            const long blocks = fail_blocks();
            said_nothing();
            found = 0.0;
            fail_at(FAIL_ALLOC, n);
            const gp_status st = rows[i].run();
            const bool fired = fail_end();
            assert_int_equal(fail_blocks(), blocks);
            if (!fired) {
                assert_int_equal(st, GP_OK);
                assert_true(found == want);
                break;
            }
            if (st != GP_ERR_BUG || said_errors != 1 ||
                !strstr(said_line, "out of memory"))
                fail_msg("%s, %ld: status %d, %d lines, \"%s\"", rows[i].name,
                         n, (int) st, said_errors, said_line);
            assert_true(found == 0.0);
        }
        assert_true(n > rows[i].least);
    }
    gp_planes_free(&frame.lit);
    gp_planes_free(&other);
}

SUITE(starved_tone)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_is_full),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
