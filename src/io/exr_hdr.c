/* The --hdr output: the frame as it came in, with glare. */
#include "io/exr_sources.h"
#include "io/exr_write.h"
#include "io/write.h"

gp_status gp_write_hdr(const struct gp_log *log,
                       const struct gp_write_params *p, const char *path,
                       const struct gp_frame *f,
                       const struct gp_planes *planes,
                       struct gp_write_stats *stats)
{
    gp_status st = gp_write_hdr_check(log, p, path);
    if (st)
        return st;
    if (gp_write_would_clobber(p, path))
        return GP_OK;
    struct gp_exr_sources s;
    st = gp_exr_sources_hdr(log, f, planes, gp_exr_colour_type(p, f), &s);
    if (st)
        return st;
    const struct gp_exr_job job = {
        .p = p, .path = path, .f = f, .source = s.source,
        .sources = s.sources,
        .kept = p->converted ? GP_EXR_KEEP_CONVERTED : GP_EXR_KEEP_ALL,
    };
    st = gp_exr_write_file(log, &job, stats);
    gp_exr_sources_free(&s);
    return st;
}
