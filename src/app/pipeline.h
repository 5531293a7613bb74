/* Runs frames through the stages, several in flight at once.
 *
 *   read -> sun -> sensors -> glare -> compose -> tonemap -> write
 *
 * A stage runs only when a later one, or an output, needs its result. Kernel,
 * spectra, plans, OCIO processors and GL objects are made once for all frames.
 * Reading and writing overlap the computing of other frames; computing,
 * reports, messages and streams keep the order of the jobs, so that no result
 * depends on how many are in flight. */
#ifndef GP_APP_PIPELINE_H
#define GP_APP_PIPELINE_H

#include "app/jobs.h"
#include "app/progress.h"
#include "app/settings.h"
#include "core/status.h"

/* Makes all frames of `jobs` but those for which gp_job_complete() is true; ends
 * at the first that fails. With --skip-bad-frames it skips frames that have bad
 * data or cannot be read or written, reports each, and lists them at the end.
 * Files that were written before stay.
 *
 *   log       gets the errors, and with --verbose a line for each frame
 *   progress  open
 * Errors: those of the stages, with their line printed; GP_ERR_FRAMES some
 * frames were skipped as bad. */
GP_MUST_CHECK gp_status gp_pipeline_run(
    const struct gp_log *log, const struct gp_settings *s,
    const struct gp_jobs *jobs, struct gp_progress *progress);

#endif
