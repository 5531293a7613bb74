#include "io/window.h"

#include <limits.h>

gp_status gp_window_check(const struct gp_log *log, const char *path,
                          const char *which, int64_t w, int64_t h,
                          long long max_pixels)
{
    if (w >= 1 && h >= 1 && w <= INT_MAX / 4 && h <= INT_MAX / 4 &&
        w * h <= max_pixels)
        return GP_OK;
    return gp_fail(log, GP_ERR_DATA,
                   "%s: the %s window is too large (%lld x %lld pixels, at "
                   "most %lld); crop it, or raise --max-pixels", path, which,
                   (long long) w, (long long) h, max_pixels);
}
