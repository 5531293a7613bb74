// SPDX-License-Identifier: Apache-2.0
/* Writes the report: JSON, one object a line for each frame. */
#ifndef GP_CLI_REPORT_H
#define GP_CLI_REPORT_H

#include "cli/jobs.h"

#include <jansson.h>

/* Stages that are timed, in their order. */
enum gp_time {
    GP_TIME_READ,
    GP_TIME_SCENE,
    GP_TIME_RELIGHT,
    GP_TIME_SUN,
    GP_TIME_SENSORS,
    GP_TIME_KERNEL, // of frames that none kept fits
    GP_TIME_GLARE,
    GP_TIME_LENS,
    GP_TIME_COMPOSE,
    GP_TIME_TONEMAP,
    GP_TIME_WRITE,
    GP_TIME_TOTAL,
    GP_TIMES,
};

/* Of the frame's job and its end. */
struct gp_job_report {
    struct gp_job of;            // borrows
    const char *style;           // NULL: left out
    char *command;               // that makes the picture again; owned, or NULL
    const struct gp_settings *settings; // of the run; NULL: left out
    const char *views;           // line about the views of the run, or NULL
    const char *said;            // `said_bytes` of messages, as in gp_frame_log
    size_t said_bytes;
    gp_status status;
    const char *error;           // the message of a frame that failed
};

/* Of the stage that reads. */
struct gp_read_facts {
    struct gp_taken taken;       // part, layer and view of the input
    const struct gp_light_group *group; // `groups` layers that glare
    int groups;                  // 0: the frame's own colour glares
    const char *source;          // or that of this file; NULL: none
    const char *mask;            // of what glares: channel, file or objects
    bool grouped;                // a group has a kernel or a gain of its own
    struct gp_rect window;       // data window of the outputs
    int width, height;           // of it
    bool grown;                  // the file's differs
    struct gp_rect file;         // data window of the file
};

/* Of what hides lights. */
struct gp_occluder_facts {
    const char *edges;           // "PLANE: how near it makes shares"; NULL: no
                                 // light is in the frame, or nothing hides any
    const char *depth;           // channel, or NULL
    const char *depth_type;      // NULL: the frame has light
    const char *mask;            // coverage channel, or NULL
};

/* Of the files written. */
struct gp_write_facts {
    struct gp_written {
        char *name;
        enum gp_target_kind kind;
    } *file;                     // `n`, then the one being written, then NULL
                                 // names; all owned
    int n;
};

/* Of what the frame cost. */
struct gp_cost_facts {
    size_t bytes;                // estimated memory of the frame in flight
    double ms[GP_TIMES];         // negative: the stage was not needed
    double cpu_ms[GP_TIMES];     // of all threads
    bool has_cpu;                // one frame was in flight, so that it is known
};

/* The facts about one frame: the library's, and the program's, a struct a
 * stage. Strings and lists are borrowed where none says owned. */
struct gp_frame_report {
    struct gp_job_report job;
    struct gp_read_facts read;
    struct glarepp_facts lib;    // borrows from the library's frame
    bool dark;                   // glare was wanted, no pixel is a source
    bool bounded;                // the next is known
    double bound;                // of rel_l2, with what a lens leaves out
    long long clamped_out;       // values that an output's type cannot hold
    double flux_clamped[3];      // by these and --max-value, by channel
    struct gp_occluder_facts hidden;
    const struct glarepp_plan_facts *ocio; // NULL: tone mapped
    struct gp_write_facts write;
    struct gp_cost_facts cost;
};

struct gp_report {
    const char *path; // borrowed; "-" is stdout; NULL: closed
    int fd;
    char *created;     // owned: the file that did not exist; NULL: it did
    long long lines;
};

/* Opens the file, in folders that are made if `create_dir`. Its old lines are
 * removed with the first new one, not before. Errors: GP_ERR_IO with the
 * system's reason. */
GP_MUST_CHECK gp_status gp_report_open(const struct gp_log *log,
    const char *path, bool create_dir, struct gp_report *out);

/* Appends one line and flushes it. Fields that were not needed are left out;
 * NaN and Inf are null; bytes of names that are not UTF-8 become U+FFFD. The
 * line of a frame that failed has what its job and its end say, no more.
 * Errors: GP_ERR_IO (full disk, closed pipe); GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_report_frame(const struct gp_log *log,
    struct gp_report *r, const struct gp_frame_report *facts);

/* Closes the file, and removes it if this run made it and wrote no line. A
 * closed or zeroed report is fine. Errors: GP_ERR_IO. */
gp_status gp_report_close(const struct gp_log *log, struct gp_report *r);

/* The value of an option; NULL when it is unset. The caller owns it. */
struct gp_option;
json_t *gp_option_json(const struct gp_settings *s, const struct gp_option *o);

/* The i-th field's name, "kernel.grid" in an object; NULL after the last. */
const char *gp_report_field(int i);

/* Formats the warning that no pixel of `frames` frames is over the threshold,
 * f being of the brightest. The report has it for each dark frame. */
void gp_frame_report_dark(const struct gp_frame_report *f, int frames, char *line,
                   size_t size);

// -- words about a run for the person who started it --------------------------

/* Prints notes about a frame: what was used, and why where an option or the
 * frame decided. */
void gp_say_frame(const struct gp_log *log, const struct gp_frame_report *f);

/* The frames of a run together. Zeroed is none. */
struct gp_tally {
    int made;                    // jobs
    long long fewest, most;      // sources
    struct gp_light_sums {
        double light, spread; // of the frames; by the layer
        double moved, added;  // by the layer with its gain
    } sums;
    double fov;                  // of the last, degrees
    const char *fov_from;        // NULL: no kernel has an angle of view
    const struct glarepp_plan_facts *ocio; // borrowed; NULL: tone curves
};

void gp_tally_add(struct gp_tally *t, const struct gp_frame_report *f);

/* Prints what happened, without a newline. There are targets, and at least one
 * job was made. */
void gp_tally_print(FILE *f, const struct gp_tally *t,
                    const struct gp_settings *s, const struct gp_jobs *jobs,
                    double seconds);

#endif
