// SPDX-License-Identifier: Apache-2.0
/* Output of a run on stderr: a progress line, the messages about each frame in
 * frame order, and at the end the list of frames that failed. */
#ifndef GP_CLI_PROGRESS_H
#define GP_CLI_PROGRESS_H

#include "cli/jobs.h"

#include <pthread.h>
#include <stdatomic.h>

/* The progress line: one for each run; not to be copied while open. */
struct gp_progress {
    FILE *file;            // NULL: draws nothing
    enum gp_progress_when when;
    bool terminal;         // redraws one line; else prints line after line
    double patience_ms;    // draws nothing earlier
    double start_ms;

    pthread_mutex_t lock;  // of all below
    int done, total;
    int failed;            // of `done`
    char name[256];        // file in work
    const char *stage;     // borrowed: a constant
    bool drawn;            // the terminal's line is not empty
    double last_ms;        // when a line was drawn
    int printed;           // `done` of the last line, or its percent; -1: none
    pthread_t clock;       // draws on a terminal while a long stage runs
    pthread_cond_t wake;
    bool ticking;
};

/* Starts the clock; NEVER draws nothing. AUTO draws on a terminal, after one
 * second, ALWAYS at once, in a pipe too. The lines for programs never decrease:
 * PERCENT prints one when the whole number changes; OPENJD and JSON when a frame
 * is done, at most ten a second. OPENJD: openjd-specifications, "How Jobs Are Run",
 * "Stdout/Stderr Messages". */
void gp_progress_open(struct gp_progress *p, FILE *file,
                      enum gp_progress_when when);

/* Wipes the line and stops the clock. */
void gp_progress_close(struct gp_progress *p);

/* Prints 100 % in the lines for programs. */
void gp_progress_end(struct gp_progress *p);

/* Counts `n` frames that end and are not made. */
void gp_progress_fail(struct gp_progress *p, int n);

/* Shows that `done` of `total` frames are made or failed, and that `stage` of
 * the file `name` comes next. */
void gp_progress_update(struct gp_progress *p, int done, int total,
                        const char *name, const char *stage);

/* Formats a time: "45 s", "3 min 20 s", "2 h 5 min". */
void gp_print_duration(char *text, size_t size, double seconds);

/* Prints a message to `file` on a line of its own. */
void gp_progress_say(struct gp_progress *p, FILE *file, const char *line);

/* Messages about a unit in flight, by its `log`. They are printed in unit
 * order; the oldest unfinished unit prints directly. */
struct gp_frame_log {
    struct gp_log log;
    const struct gp_log *to;         // borrowed
    const atomic_int *head;          // unit that is ended next; borrowed
    int unit;
    const char *name;                // of the unit's file; borrowed
    char *text;                      // owned: messages, each its level, its
                                     // line and a null byte
    size_t bytes, printed;           // of them; of these printed
};

/* Starts without messages. `l` must not move until gp_frame_log_close(). `name`
 * is put before errors that name no file (GP_LEVEL_BARE). */
void gp_frame_log_open(struct gp_frame_log *l, const struct gp_log *to,
    const atomic_int *head, int unit, const char *name);

/* Prints the messages that are still kept. */
void gp_frame_log_flush(struct gp_frame_log *l);

/* The line of the last error; NULL: there is none, or memory was full. */
const char *gp_frame_log_error(const struct gp_frame_log *l);

/* Frees messages. A zeroed one is fine. */
void gp_frame_log_close(struct gp_frame_log *l);

/* Prints that `kept` jobs were skipped by --no-clobber, and how many failed with
 * their list: a value of --frames (2-4,9) when all have numbers, else the names
 * of their inputs; after GP_FAILURES_BYTES the rest is only counted. Errors:
 * GP_ERR_FRAMES some failed. */
enum { GP_FAILURES_BYTES = 1200 };
GP_MUST_CHECK gp_status gp_failures_report(const struct gp_log *log,
    const struct gp_jobs *j, int kept);

#endif
