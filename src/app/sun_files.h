/* Files for the sun's stage: planes of depth and coverage, pictures of flare
 * elements, and what a frame's file says of its camera. */
#ifndef GP_APP_SUN_FILES_H
#define GP_APP_SUN_FILES_H

#include "app/jobs.h"
#include "app/settings.h"
#include "sun/stage.h"

struct gp_sun_files {
    const struct gp_settings *s;
    const struct gp_job *job; // whose frame it is; NULL: pictures only
};

/* `files` must stay as long as what is returned. */
struct gp_sun_reader gp_sun_reader_of(struct gp_sun_files *files);

#endif
