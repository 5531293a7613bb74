/* The table of hard cases, and how the unit tests of the engines run it. */
#ifndef GP_TESTS_HARD_CASES_H
#define GP_TESTS_HARD_CASES_H

#include "../../hard/scenes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* -- running them -----------------------------------------------------------*/

static int quick; // GLAREPP_TEST_QUICK is set: no GL, small cases
static int no_gl; // no GL library on this machine

static inline int ask_quick(void **state)
{
    (void) state;
    quick = getenv("GLAREPP_TEST_QUICK") != NULL;
    return 0;
}

/* Runs an engine; 0 when it cannot run here for want of GL. */
static inline int ran(const char *engine, struct scene *s, struct gp_glare *g,
                      struct gp_glare_stats *stats, const char *what)
{
    const int is_gl = strcmp(engine, "splat") == 0;
    if (is_gl && (quick || no_gl))
        return 0;
    const gp_status st = scene_run(engine, s, g, stats);
    if (is_gl && st == GP_ERR_GL && strstr(kept_line, "install the Debian")) {
        print_message("splat is left out: %s\n", kept_line);
        no_gl = 1;
        return 0;
    }
    if (st)
        fail_msg("%s, %s: %s", what, engine, kept_line);
    return 1;
}

/* The same for one frame alone. */
static inline int ran_once(const char *engine, struct scene *s,
                           struct gp_glare_stats *stats, const char *what)
{
    struct gp_glare g = {0};
    const int yes = ran(engine, s, &g, stats, what);
    gp_glare_close(&g);
    return yes;
}

/* An engine's bar where nothing is hard. */
static inline double usual_bar(const char *engine)
{
    const double bar = hard_bar(&hard_cases[0], engine);
    if (!(bar > 0.0))
        fail_msg("engine %s has no bar in hard_cases.h", engine);
    return bar;
}

#endif
