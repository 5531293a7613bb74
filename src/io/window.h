/* The size of a window that a file claims. */
#ifndef GP_IO_WINDOW_H
#define GP_IO_WINDOW_H

#include "core/status.h"

#include <stdint.h>

/* Refuses a window of `w` x `h` pixels that is empty, has more than
 * max_pixels, or edges that int cannot hold four times. `which` is "data" or
 * "display", for the line. Errors: GP_ERR_DATA. */
GP_MUST_CHECK gp_status gp_window_check(const struct gp_log *log,
                                        const char *path, const char *which,
                                        int64_t w, int64_t h,
                                        long long max_pixels);

#endif
