/* Planes beside a frame's colour that the library needs: depth, coverage,
 * normals and albedo. */
#include "cli/stages.h"

#include "core/memory.h"
#include "io/sequence.h"

#include <stdlib.h>

/* Reads a plane from a file of its own, whose name may be a pattern. */
static gp_status read_beside(const struct gp_settings *s,
    const struct gp_frame_state *fs, const char *path, const char *channel,
    bool depth, struct gp_plane *out)
{
    const struct gp_log *const log = fs->log;
    const struct gp_job *const job = fs->job;
    struct gp_pattern pattern;
    int number = 0;
    gp_status st = gp_pattern_of_input(log, path, &pattern);
    if (st)
        return st;
    if (pattern.views && !job->view)
        return gp_fail(log, GP_ERR_USAGE, "%s: %%V and %%v need views (%s has "
            "none); give a plain file name, or --views", path, job->input);
    if (pattern.len && !gp_job_number(job, &number))
        return gp_fail(log, GP_ERR_USAGE, "%s: a pattern needs frame numbers "
                       "(%s has none); give a plain file name", path,
                       job->input);
    char *const name = gp_pattern_name(&pattern, number, job->view);
    if (!name)
        return gp_no_memory(log, path);
    st = gp_read_plane_file(log, &s->input.read, name, channel, depth, out);
    free(name);
    return st;
}

/* Reads depth, unless it was. */
static gp_status read_depth(const struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_settings *const s = r->s;
    return fs->depth.v ? GP_OK
           : s->sun.depth_file
               ? read_beside(s, fs, s->sun.depth_file, s->input.depth, true,
                             &fs->depth)
               : gp_read_plane(fs->log, &s->input.read, &fs->file,
                               s->input.depth, true, &fs->depth);
}

/* Gives `n` planes to the library, if they are there.
 *   file  of its own that they are from, or NULL */
static gp_status give(struct gp_frame_state *fs, enum glarepp_view view,
                      const struct gp_plane *plane, int n, const char *file)
{
    const struct gp_rect w = plane->window;
    struct glarepp_image v = GLAREPP_IMAGE;
    for (int c = 0; c < n; c++)
        v.plane[c] = plane[c].v;
    v.data = (struct glarepp_rect) {w.x0, w.y0, w.x1, w.y1};
    v.name = file;
    return plane->v ? (gp_status) glarepp_frame_set(fs->frame, view, &v)
                    : GP_OK;
}

gp_status gp_run_occluders(const struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_log *const log = fs->log;
    const struct gp_settings *const s = r->s;
    struct gp_occluder_facts *const facts = &fs->facts.hidden;
    gp_status st;
    GP_TRY(read_depth(r, fs));
    if (s->sun.mask_file)
        GP_TRY(read_beside(s, fs, s->sun.mask_file, s->sun.mask, false,
                           &fs->mask));
    else if (s->sun.mask)
        GP_TRY(gp_read_plane(log, &s->input.read, &fs->file, s->sun.mask, false,
                             &fs->mask));
    facts->depth = fs->depth.v ? gp_strdup(fs->depth.name) : NULL;
    facts->mask = fs->mask.v ? gp_strdup(fs->mask.name) : NULL;
    if ((fs->depth.v && !facts->depth) || (fs->mask.v && !facts->mask))
        GP_TRY(gp_no_memory_bare(log, "lights"));
    GP_TRY(give(fs, GLAREPP_DEPTH, &fs->depth, 1, s->sun.depth_file));
    GP_TRY(give(fs, GLAREPP_COVERAGE, &fs->mask, 1, s->sun.mask_file));
out:
    return st;
}

gp_status gp_run_surfaces(const struct gp_run *r, struct gp_frame_state *fs)
{
    static const struct gp_layer_names normals = {
        "normals", {"N", "Normal", "normal", "Normals", "normals", NULL},
        {{"X", "Y", "Z"}, {"x", "y", "z"}, {"R", "G", "B"}},
    };
    static const struct gp_layer_names albedo = {
        "albedo", {"albedo", "Albedo", "DiffCol", "diffuse_albedo",
                   "diffuse_color", NULL},
        {{"R", "G", "B"}, {"r", "g", "b"}, {"red", "green", "blue"}},
    };
    const struct gp_log *const log = fs->log;
    gp_status st;
    GP_TRY(read_depth(r, fs));
    if (!fs->depth.v)
        GP_TRY(gp_fail(log, GP_ERR_USAGE, "%s: --relight needs depth, and no "
                       "channel is; name one with --depth", fs->job->input));
    GP_TRY(gp_read_vectors(log, &r->s->input.read, &fs->file, &normals,
                           fs->normal));
    GP_TRY(gp_read_vectors(log, &r->s->input.read, &fs->file, &albedo,
                           fs->albedo));
    GP_TRY(give(fs, GLAREPP_DEPTH, &fs->depth, 1, r->s->sun.depth_file));
    GP_TRY(give(fs, GLAREPP_NORMAL, fs->normal, 3, NULL));
    GP_TRY(give(fs, GLAREPP_ALBEDO, fs->albedo, 3, NULL));
out:
    return st;
}
