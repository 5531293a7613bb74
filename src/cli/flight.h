/* Keeps several units of work in flight: while one is computed, others are read
 * and written, so that no core waits for a file.
 *
 * Each unit passes READ, COMPUTE, WRITE (stages.h) and is then ended. COMPUTE
 * runs on the caller's thread only, and units are computed and ended in order,
 * so that shared state depends on the units before, never on threads. */
#ifndef GP_CLI_FLIGHT_H
#define GP_CLI_FLIGHT_H

#include "core/status.h"
#include "glarepp.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>

/* Steps of a unit: COMPUTE runs on one thread, unit after unit; the others on
 * any thread, units in any order. */
enum gp_phase { GP_PHASE_READ, GP_PHASE_COMPUTE, GP_PHASE_WRITE };

enum { GP_FLIGHT_MOST = 64 }; // units in flight

struct gp_flight_params {
    struct glarepp *gp; // context that threads enter; the caller is in it
    int units;    // >= 0
    int slots;    // units in flight, 1 to GP_FLIGHT_MOST
    bool ordered; // units are written in order
};

/* The steps of a unit. A slot, in [0, slots), belongs to one unit from its READ
 * to its end; no two steps of a slot run at once. */
struct gp_flight_work {
    void *user;
    /* Runs a step. A unit whose step fails gets no further one. */
    gp_status (*step)(void *user, int slot, int unit, enum gp_phase phase);
    /* True when the run continues after a unit that failed with `st`. */
    bool (*goes_on)(void *user, int slot, gp_status st);
    /* True when one more may start while others are in flight. */
    bool (*has_room)(void *user, int in_flight);
    /* Ends a unit, in order, one at a time; `st` is the status of its steps.
     * Any other return than GP_OK ends the flight. */
    gp_status (*end)(void *user, int slot, int unit, gp_status st);
};

/* A flight; its members are its own. */
struct gp_flight {
    atomic_int head;
};

/* Flies all units, on this thread and, for more than one slot, on up to
 * gp_threads() - 1 others beside; fewer threads are no error.
 *
 *   f  written by it; steps may call gp_flight_head()
 *
 * Returns the first status other than GP_OK of work->end; units after that
 * one may have run steps, and are not ended. */
GP_MUST_CHECK gp_status gp_flight_run(const struct gp_flight_params *p,
    const struct gp_flight_work *work, struct gp_flight *f);

/* Memory of a flight, in bytes; 0 is unknown. */
struct gp_flight_memory {
    size_t limit;   // of the process
    size_t largest; // of a unit so far
    size_t shared;  // by all units: kernels, transforms and the like
};

/* True when one more unit may start beside `in_flight` others: all of them and
 * what they share take half of the memory at most, each as much as the largest
 * so far. The first is read by itself, as nothing is known before. */
bool gp_flight_has_room(const struct gp_flight_memory *m, int in_flight);

/* The unit that is ended next. */
int gp_flight_head(const struct gp_flight *f);

#endif
