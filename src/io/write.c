#include "io/write.h"

#include "io/exr/exr.h"
#include "io/file.h"
#include "io/file_name.h"
#include "io/oiio/oiio.h"
#include "io/png.h"
#include "io/raw_write.h"

#include <string.h>

enum { ENDING_BYTES = 16 };

/* The ending that decides; true when it is not the path's own, but that of
 * stdout, pipes and devices without one. */
static bool format_of(const struct gp_write_params *p, const char *path,
                      char ending[ENDING_BYTES])
{
    static const char *const formats[] = {
        [GP_STDOUT_EXR] = "exr", [GP_STDOUT_PNG] = "png",
        [GP_STDOUT_PFM] = "pfm", [GP_STDOUT_RAW] = "raw",
    };
    gp_file_ending(path, ending, ENDING_BYTES);
    if (ending[0] || !gp_file_is_straight(path))
        return false;
    strcpy(ending, formats[p->stdout_format]);
    return true;
}

/* Raw frames have no files of their own: .raw is what cameras write. */
static bool is_raw(bool straight, const char *ending)
{
    return straight && strcmp(ending, "raw") == 0;
}

gp_status gp_write_hdr_check(const struct gp_log *log,
                             const struct gp_write_params *p, const char *path)
{
    char ending[ENDING_BYTES];
    const bool straight = format_of(p, path, ending);
    if (straight && strcmp(ending, "exr") != 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: --hdr keeps all channels, which EXR alone can "
                       "(found --stdout-format %s); give --hdr a file", path,
                       ending);
    if (strcmp(ending, "exr") != 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: --hdr keeps all channels, which EXR alone can "
                       "(ending %s); end the name in .exr", path,
                       ending[0] ? ending : "missing");
    return gp_write_check(log, p, path);
}

bool gp_write_would_clobber(const struct gp_write_params *p, const char *path)
{
    return p->no_clobber && strcmp(path, "-") != 0 && gp_file_exists(path);
}

gp_status gp_write_check(const struct gp_log *log,
                         const struct gp_write_params *p, const char *path)
{
    char ending[ENDING_BYTES];
    if (is_raw(format_of(p, path, ending), ending))
        return gp_file_check(log, path, p->create_dir);
    if (strcmp(ending, "exr") != 0 && strcmp(ending, "png") != 0) {
        gp_status st = gp_other_check(log, p, path, ending);
        if (st)
            return st;
    } else if (p->compression >= GP_COMPRESSION_DWAA && ending[0] == 'e') {
        const gp_status st = gp_oiio_check(log, path); // DWA is made by it
        if (st)
            return st;
    }
    return gp_file_check(log, path, p->create_dir);
}

gp_status gp_write_picture(const struct gp_log *log,
                           const struct gp_write_params *p, const char *path,
                           const struct gp_frame *f,
                           const struct gp_planes *planes,
                           enum gp_picture_kind kind,
                           struct gp_write_stats *stats)
{
    char ending[ENDING_BYTES];
    const bool straight = format_of(p, path, ending);
    if (gp_write_would_clobber(p, path))
        return GP_OK;
    if (strcmp(ending, "exr") == 0)
        return gp_exr_write_picture(log, p, path, f, planes, kind, stats);
    if (strcmp(ending, "png") == 0)
        return gp_png_write(log, p, path, f, planes, kind);
    if (is_raw(straight, ending))
        return gp_raw_write(log, p, path, f, planes, kind, stats);
    return gp_other_write(log, p, path, ending, f, planes, kind);
}

gp_status gp_write_hdr(const struct gp_log *log,
                       const struct gp_write_params *p, const char *path,
                       const struct gp_hdr_colour *set, int n,
                       struct gp_write_stats *stats)
{
    gp_status st = gp_write_hdr_check(log, p, path);
    if (st || gp_write_would_clobber(p, path))
        return st;
    return gp_exr_write_hdr(log, p, path, set, n, stats);
}
