/* The planner behind `--engine auto`: which engine, and which setting of it,
 * makes this frame's layer soonest within the tolerance.
 *
 * A choice depends on the build (costs.h), the frame, the options and the
 * frames before it in the sequence; never on threads, time of day or load.
 */
#ifndef GP_GLARE_PLAN_H
#define GP_GLARE_PLAN_H

#include "core/status.h"
#include "glare/engine.h"

#include <stdbool.h>

enum { GP_CANDIDATES = 16 };

struct gp_candidate {
    int engine;                   // index in gp_engines
    struct gp_splat_params splat; // its settings, where it is a splat
    bool exact;                   // rounding is its only error
    double ms;                    // predicted for this frame, with what is
                                  // not set up yet; INFINITY: not to be taken
    double later_ms;              // predicted when all is set up, <= ms
    bool more;                    // it takes longer than that
    double bound;                 // of rel_l2; NAN: not asked
};

/* What a choice says. */
struct gp_choice {
    int taken;   // index of the candidate
    bool within; // its bound keeps the tolerance
    bool kept;   // another is predicted faster, but not worth the change
};

/* Bound of candidate i: *bound is INFINITY or NAN where there is none. */
typedef gp_status (*gp_plan_ask)(void *ctx, int i, double *bound);

/* Chooses among `n` candidates, n > 0, one of them exact and of finite ms, and
 * carries *past on to the next frame.
 *
 *   first frame   the fewest ms of those whose bound is <= tolerance
 *   none keeps it the least bound, and of equals the fewest ms: all roundings
 *                 are in an exact engine's bound, so no other is asked then
 *   later frames  the one before stays, where it keeps the tolerance, unless
 *                 another takes less than 4/5 of its ms; or unless staying has
 *                 lost, against that one's later_ms, as much as its set-up and
 *                 one frame: so set-up is paid where frames to come repay it
 *
 * Two engines follow each other only where their bounds together are within
 * the tolerance: their layers of this frame then differ by at most tolerance *
 * |layer| in norm, so no sample by more than that.
 *
 * Bounds are asked only where they decide, and kept in c[i].bound.
 * Errors: what `ask` returns. */
GP_MUST_CHECK gp_status gp_plan_choose(struct gp_candidate *c, int n,
                                       double tolerance,
                                       struct gp_plan_past *past,
                                       gp_plan_ask ask, void *ctx,
                                       struct gp_choice *out);

/* The candidates for a job, predicted with g's states: each engine, splat with
 * the settings given, exact, and with coarser and coarser groups, with and
 * without shrinking by half the tolerance. Their order is fixed. Returns how
 * many; no context is opened. */
int gp_plan_candidates(const struct gp_glare_job *job, const struct gp_glare *g,
                       struct gp_candidate c[GP_CANDIDATES]);

/* Candidates and choice for a job, and stats->why. Says once in a sequence, as
 * a warning with `path`, that the tolerance cannot be kept.
 * Errors: an engine's bound. */
GP_MUST_CHECK gp_status gp_plan(const struct gp_glare_job *job,
                                struct gp_glare *g, const char *path,
                                struct gp_candidate *out);

#endif
