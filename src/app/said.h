/* Messages about a unit in flight: they come out in the order of units, those
 * of the unit that is ended next at once. */
#ifndef GP_APP_SAID_H
#define GP_APP_SAID_H

#include "app/flight.h"
#include "core/status.h"

#include <stddef.h>

/* Its `log` is for the steps of the unit, one after the other. */
struct gp_said {
    struct gp_log log;
    const struct gp_log *to;         // borrowed
    const struct gp_flight *flight;  // borrowed
    int unit;
    const char *name;                // of the unit's file; borrowed
    char *text;                      // owned: a byte for the level, the line,
    size_t used, room;               // its null byte; and so on
    char last[GP_LINE_BYTES];        // the last error's line
};

/* Starts with nothing said. `s` stays where it is until gp_said_end().
 *
 *   name  of the file that the unit is made of: it is put before errors that
 *         name none (GP_LEVEL_BARE); borrowed until gp_said_end()
 */
void gp_said_begin(struct gp_said *s, const struct gp_log *to,
                   const struct gp_flight *flight, int unit,
                   const char *name);

/* Says what is kept yet. */
void gp_said_flush(struct gp_said *s);

/* Forgets the rest and frees. A zeroed one is fine. */
void gp_said_end(struct gp_said *s);

#endif
