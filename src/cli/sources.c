// SPDX-License-Identifier: Apache-2.0
/* Reads what glares beside a frame's own light: --source, and --source-mask. */
#include "cli/listener.h"
#include "cli/stages.h"

#include "core/memory.h"
#include "core/minmax.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// -- another frame's light ------------------------------------------------------

gp_status gp_read_source(const struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_frame *const f = &fs->file;
    struct gp_frame *const s = &fs->group[0];
    struct gp_read_params p = gp_read_limits(&r->s->input.read);
    char *name;
    bool alike = true;
    gp_status st = GP_ERR_USAGE;
    if (!r->s->light.source)
        return GP_OK;
    GP_TRY(gp_job_beside(fs->log, fs->job, r->s->light.source, &name));
    p.view = r->jobs->views_inside ? fs->job->view : NULL;
    st = p.view ? gp_read_frame(NULL, &p, name, s) : GP_ERR_USAGE;
    p.view = NULL; // a file without views is the light of each
    if (st)
        st = gp_read_frame(fs->log, &p, name, s);
    free(name);
    GP_TRY(st);
    fs->groups = 1;
    fs->facts.read.source = s->path;
    if (memcmp(&f->data, &s->data, sizeof f->data) != 0)
        GP_TRY(gp_fail(
            fs->log, GP_ERR_DATA,
            "%s: its data window is not that of %s (found %dx%d at %d,%d; "
            "needs %dx%d at %d,%d); render both with one window",
            s->path, f->path, gp_frame_w(s), gp_frame_h(s), s->data.x0,
            s->data.y0, gp_frame_w(f), gp_frame_h(f), f->data.x0, f->data.y0));
    for (int i = 0; i < 8; i++)
        alike &= fabsf(s->chromaticities[i] - f->chromaticities[i]) < 1e-3f;
    if (!alike)
        st = gp_fail(fs->log, GP_ERR_DATA,
                     "%s: its primaries are not those of "
                     "%s; convert one of them",
                     s->path, f->path);
out:
    return st;
}

// -- the mask -------------------------------------------------------------------

/* Makes a plane of `window` 1 less the values of *p, clamped to [0, 1]; 1
 * outside of that. */
static gp_status invert(const struct gp_log *log, struct gp_rect window,
                        struct gp_plane *p)
{
    const struct gp_rect own = p->window;
    float *v, *to;
    const gp_status st =
        gp_alloc(log, "source mask", gp_rect_pixels(window), sizeof *v, &v);
    if (st)
        return st;
    to = v;
    for (int y = window.y0; y < window.y1; y++) {
        const float *const from =
            p->v + ((ptrdiff_t) y - own.y0) * gp_rect_w(own);
        for (int x = window.x0; x < window.x1; x++) {
            const bool in =
                y >= own.y0 && y < own.y1 && x >= own.x0 && x < own.x1;
            const float m = in ? from[x - own.x0] : 0.0f;
            *to++ = m > 0.0f ? 1.0f - gp_minf(m, 1.0f) : 1.0f;
        }
    }
    gp_free(p->v);
    p->v = v;
    p->window = window;
    return GP_OK;
}

gp_status gp_read_source_mask(const struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_log *const log = fs->log;
    const struct gp_read_params *const p = &r->s->input.read;
    struct gp_plane *const mask = &fs->source_mask;
    struct glarepp_image v = GLAREPP_IMAGE;
    char *name = NULL;
    gp_status st;
    if (!r->s->light.mask)
        return GP_OK;
    const struct gp_mask_word m = gp_mask_word_of(r->s->light.mask);
    if (m.crypto) {
        GP_TRY(gp_read_crypto(log, p, &fs->file, m.word, mask));
    } else {
        GP_TRY(gp_job_beside(log, fs->job, m.word, &name));
        GP_TRY(gp_read_mask(log, p, &fs->file, m.word, name, mask));
    }
    if (m.inverted)
        GP_TRY(invert(log, fs->file.data, mask));
    fs->facts.read.mask = mask->name;
    v.plane[0] = mask->v;
    v.data = mask->window;
    st = (gp_status) glarepp_frame_set(fs->frame, GLAREPP_SOURCE_MASK, &v);
out:
    free(name);
    return st;
}

// -- depth and deep pixels --------------------------------------------------------

gp_status gp_name_own_depth(const struct gp_run *r, struct gp_frame_state *fs)
{
    static const char *const types[] = {
        [GP_UINT] = "uint",
        [GP_HALF] = "half",
        [GP_FLOAT] = "float",
    };
    const struct gp_log *const log = fs->log;
    const char *const asked = r->s->input.depth;
    struct gp_occluder_facts *const facts = &fs->facts.hidden;
    enum gp_pixel_type type;
    const gp_status st = gp_name_depth(asked ? log : NULL, &fs->file, asked,
                                       &fs->depth.name, &type);
    facts->depth = st ? NULL : fs->depth.name;
    if (facts->depth)
        facts->depth_type = types[type];
    if (st == GP_ERR_BUG && !asked)
        return gp_no_memory(log, fs->job->input);
    return asked ? st : GP_OK;
}

gp_status gp_read_samples(const struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_settings *const s = r->s;
    const struct gp_sun_settings *const sun = &s->sun;
    struct glarepp_image v = GLAREPP_IMAGE;
    gp_status st = GP_OK;
    bool found;
    if (!sun->deep && (sun->mask || sun->mask_file || sun->depth_file ||
                       s->input.depth || sun->p.method != GLAREPP_EXACT))
        return GP_OK;
    if (sun->deep)
        GP_TRY(gp_job_beside(fs->log, fs->job, sun->deep, &fs->deep_name));
    GP_TRY(gp_read_deep(fs->log, &s->input.read, &fs->file, fs->deep_name,
                        &fs->deep, &found));
    struct glarepp_stored deep = gp_stored_view(&fs->deep, fs->deep_name);
    v.plane[0] = &deep;
    if (found)
        st = (gp_status) glarepp_frame_set(fs->frame, GLAREPP_DEEP, &v);
out:
    return st;
}
