/* What the command line sets: the params of every stage, and the app's own.
 * Stages never see this struct, only their part of it.
 */
#ifndef GP_APP_SETTINGS_H
#define GP_APP_SETTINGS_H

#include "core/status.h"
#include "glare/compose.h"
#include "glare/engine.h"
#include "glare/kernel.h"
#include "glare/sensors.h"
#include "io/read.h"
#include "io/write.h"
#include "tone/tone.h"

#include <stdbool.h>

/* Values of --progress. AUTO draws on a terminal only. */
enum gp_progress_when {
    GP_PROGRESS_AUTO,
    GP_PROGRESS_ALWAYS,
    GP_PROGRESS_NEVER,
};

/* Kinds of --debug KIND=FILE. */
enum gp_debug_kind { GP_DEBUG_SENSORS, GP_DEBUG_KINDS };

/* Words from the command line, in its order. */
struct gp_texts {
    const char **at;  // owned array of borrowed words
    int n;
};

/* Strings are borrowed from argv or are constants. */
struct gp_settings {
    struct gp_read_params read;
    struct gp_sensor_params sensor;
    struct gp_kernel_params kernel;
    struct gp_glare_params glare;      // gain is compose's
    struct gp_compose_params compose;
    struct gp_tone_params tone;
    struct gp_write_params write;

    struct gp_texts inputs, outputs;   // outputs: -o
    const char *hdr, *layer;           // NULL: not wanted
    const char *debug[GP_DEBUG_KINDS]; // files
    const char *report;
    const char *frames;                // list as written
    const char *depth;                 // channel
    int threads;                       // 0: all processors
    bool verify;
    enum gp_level level;               // of messages
    enum gp_progress_when progress;
    bool help, help_man, version;
};

/* The values that hold where the command line says nothing. */
extern const struct gp_settings gp_defaults;

#endif
