#include "io/exr/exr_priv.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static _Thread_local bool full;   // an allocation failed
static _Thread_local int unread;  // errno of a read that failed
static _Thread_local bool cut;    // a read came short

void *gp_exr_allocate(size_t size)
{
    void *const p = malloc(size);
    full = full || !p;
    return p;
}

int64_t gp_exr_read_bytes(const struct gp_stream *s, void *to, uint64_t n,
                          uint64_t offset)
{
    const int64_t got = gp_stream_read(s, to, n, offset);
    if (got < 0)
        unread = errno;
    cut = cut || got < (int64_t) n;
    return got;
}

void gp_exr_fault_clear(void)
{
    full = false;
    unread = 0;
    cut = false;
}

gp_status gp_exr_fault(void)
{
    return full ? GP_ERR_BUG : unread ? GP_ERR_IO : GP_OK;
}

bool gp_exr_fault_short(void)
{
    return cut;
}

gp_status gp_exr_fault_print(const struct gp_log *log, const char *path,
                            gp_status fault)
{
    if (fault == GP_ERR_BUG)
        return gp_fail(log, fault, "%s: out of memory; close other programs",
                       path);
    return gp_fail(log, fault, "%s: cannot read (%s); check the disk", path,
                   strerror(unread ? unread : EIO));
}
