/* Makes the kernel of a run for the frames that need it, and keeps it while one
 * of them is in flight. */
#include "app/stages.h"

#include "core/colour.h"
#include "core/memory.h"
#include "io/read.h"

#include <string.h>

void gp_run_kernel_free(struct gp_run_kernel **k)
{
    if (*k && atomic_fetch_sub(&(*k)->holders, 1) == 1) {
        gp_kernel_free(&(*k)->k);
        gp_free(*k);
    }
    *k = NULL;
}

/* Makes the kernel for the frame's primaries and pixel aspect (NULL: BT.709,
 * square), unless r->kernel is that. */
static gp_status make_kernel(const struct gp_log *log, struct gp_run *r,
                             const struct gp_frame *frame)
{
    const struct gp_run_kernel *const old = r->kernel;
    const bool file = r->kernel_image.rgb.c[0] != NULL;
    const float *const primaries =
        frame ? frame->chromaticities : gp_rec709_chromaticities;
    const float aspect = gp_kernel_aspect(frame);
    struct gp_kernel_params p = r->s->kernel;
    struct gp_run_kernel *k;
    if (old && old->aspect == aspect &&
        (!old->tinted || memcmp(old->chromaticities, primaries,
                                sizeof old->chromaticities) == 0))
        return GP_OK;
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *k, &k);
    if (st)
        return st;
    p.frame = frame;
    st = file ? gp_kernel_from_frame(log, &p, &r->kernel_image, &k->k)
              : gp_kernel_builtin(log, &p, &k->k);
    if (st) {
        gp_free(k);
        return st;
    }
    memcpy(k->chromaticities, primaries, sizeof k->chromaticities);
    k->aspect = aspect;
    k->tinted = !file && !k->k.grey;
    atomic_init(&k->holders, 1);
    gp_run_kernel_free(&r->kernel);
    r->kernel = k;
    return GP_OK;
}

gp_status gp_run_kernel_hold(struct gp_run *r, struct gp_frame_state *fs)
{
    gp_status st = GP_OK;
    if (fs->sources.n > 0 || gp_suns_glare(&r->suns))
        st = make_kernel(fs->log, r, &fs->frame);
    if (!st && r->kernel) {
        fs->kernel = r->kernel;
        atomic_fetch_add(&fs->kernel->holders, 1);
    }
    return st;
}

const struct gp_kernel *gp_run_kernel_of(const struct gp_frame_state *fs)
{
    static const struct gp_kernel none;
    return fs->kernel ? &fs->kernel->k : &none;
}

gp_status gp_run_kernel_begin(const struct gp_log *log, struct gp_run *r)
{
    const char *const source = r->s->kernel.source;
    const bool file = strncmp(source, "builtin:", 8) != 0;
    gp_status st = GP_OK;
    if (file) {
        const struct gp_read_params limits = gp_read_limits(&r->s->read);
        st = gp_read_frame(log, &limits, source, &r->kernel_image);
    } else if (r->s->grow_how != GP_GROW_KERNEL) {
        return GP_OK; // made for the first frame with light
    }
    if (!st)
        st = make_kernel(log, r, NULL);
    if (st)
        return st;
    const struct gp_kernel *const k = &r->kernel->k;
    r->reach = (struct gp_rect) {k->cx, k->cy, k->w - 1 - k->cx,
                                 k->h - 1 - k->cy};
    return GP_OK;
}
