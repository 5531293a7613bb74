/* The line on the terminal that says how far a run is. */
#ifndef GP_APP_PROGRESS_H
#define GP_APP_PROGRESS_H

#include "app/settings.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>

/* One for each run; not to be copied while open. */
struct gp_progress {
    FILE *file;            // NULL: draws nothing
    bool terminal;         // one line drawn over and over; else line by line
    double patience_ms;    // draws nothing earlier
    double start_ms;

    pthread_mutex_t lock;  // of all below
    int done, total;
    char name[256];        // what is made now
    bool drawn;            // the terminal's line is not empty
    double last_ms;        // when a line was drawn
    pthread_t clock;       // draws on a terminal while a long stage runs
    pthread_cond_t wake;
    bool ticking;
};

/* Starts the clock. AUTO draws on a terminal only, and only what takes longer
 * than a second; ALWAYS draws at once, in a pipe too; `quiet` wins. */
void gp_progress_open(struct gp_progress *p, FILE *file,
                      enum gp_progress_when when, bool quiet);

/* Wipes the line and stops the clock. */
void gp_progress_close(struct gp_progress *p);

/* Says that `done` of `total` frames are made, and that `stage` of the file
 * `name` comes next; its folder is not shown. In a pipe it draws at most ten
 * lines a second. */
void gp_progress_update(struct gp_progress *p, int done, int total,
                        const char *name, const char *stage);

/* Prints a line of its own on the same file, whether or not progress is
 * drawn there. */
void gp_progress_say(struct gp_progress *p, FILE *file, const char *line);

/* The line itself: frames done, rate, time left. For tests. */
void gp_progress_text(char *line, size_t size, int done, int total,
                      const char *name, double elapsed_ms);

#endif
