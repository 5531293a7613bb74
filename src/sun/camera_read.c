#include "core/memory.h"
#include "sun/camera.h"
#include "sun/json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* 5000 frames and more as they are commonly written, a number a line. */
enum { MOST_BYTES = 8 << 20, MOST_FRAMES = 1 << 20 };

static const double MOST_FRAME = 9007199254740992.0; // 2^53: exact in double
static const double MOST_VALUE = 1e300;

/* Every frame has its number: messages go by it once it is known. */
static gp_status read_number(const struct gp_json_place *p, json_t *o,
                             long long *out)
{
    double number = 0.0;
    bool found;
    gp_status st = gp_json_number(p, o, "frame", -MOST_FRAME, MOST_FRAME,
                                  &number, &found);
    if (st)
        return st;
    if (!found || number != floor(number))
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: %s %d in order has no number (found %s); give "
                       "\"frame\" a whole one", p->path, p->what, p->index,
                       found ? "a fraction" : "no \"frame\"");
    *out = (long long) number;
    return GP_OK;
}

static void transpose(const double in[16], double out[16])
{
    for (int i = 0; i < 16; i++)
        out[i] = in[i % 4 * 4 + i / 4];
}

static gp_status read_camera(const struct gp_json_place *p, json_t *o,
                             const char *frame, struct gp_camera *out)
{
    gp_status st;
    double camera[16], ndc[16], columns[16];
    bool has_camera, spec, clip;
    GP_TRY(gp_json_numbers(p, o, "worldToCamera_rowmajor", 16, false,
                           -MOST_VALUE, MOST_VALUE, camera, &has_camera));
    GP_TRY(gp_json_numbers(p, o, "worldToNDC_rowmajor", 16, false, -MOST_VALUE,
                           MOST_VALUE, ndc, &spec));
    GP_TRY(gp_json_numbers(p, o, "worldToNDC_blender_colvec", 16, false,
                           -MOST_VALUE, MOST_VALUE, columns, &clip));
    if (!spec && !clip)
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: no projection (found neither \"worldToNDC_rowmajor"
                       "\" nor \"worldToNDC_blender_colvec\"); give one of "
                       "them", frame);
    if (!spec)
        transpose(columns, ndc);
    GP_TRY(gp_camera_make(p->log, frame, has_camera ? camera : NULL, ndc,
                          spec ? GP_NDC_SPEC : GP_NDC_CLIP, out));
out:
    return st;
}

static gp_status read_sun(const struct gp_json_place *p, json_t *o,
                          const char *frame, struct gp_camera_frame *out)
{
    gp_status st;
    GP_TRY(gp_json_numbers(p, o, "sun_dir_world", 3, false, -MOST_VALUE,
                           MOST_VALUE, out->sun_dir, &out->has_sun));
    GP_TRY(gp_json_number(p, o, "sun_radius_px", 0.0, 1e6, &out->sun_radius,
                          NULL));
    const double *d = out->sun_dir;
    if (out->has_sun && d[0] == 0.0 && d[1] == 0.0 && d[2] == 0.0)
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: \"sun_dir_world\" has no direction (found 0, 0, "
                       "0); give one, or leave it out", frame);
out:
    return st;
}

static gp_status read_frame(const struct gp_json_place *p, json_t *o,
                            struct gp_camera_frame *out)
{
    gp_status st;
    char frame[2048]; // "cameras.json: frame 1001"
    struct gp_json_place at = *p;
    if (!json_is_object(o))
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: %s %d in order is no object; give {\"frame\": "
                       "..., \"worldToNDC_rowmajor\": [...]}", p->path,
                       p->what, p->index);
    GP_TRY(read_number(p, o, &out->frame));
    snprintf(frame, sizeof frame, "%s: frame %lld", p->path, out->frame);
    at.path = frame;
    at.index = 0;
    GP_TRY(read_camera(&at, o, frame, &out->camera));
    GP_TRY(read_sun(&at, o, frame, out));
out:
    return st;
}

static int by_number(const void *a, const void *b)
{
    const struct gp_camera_frame *x = a, *y = b;
    return (x->frame > y->frame) - (x->frame < y->frame);
}

static gp_status sort_frames(const struct gp_json_place *p,
                             struct gp_camera_file *f)
{
    qsort(f->at, (size_t) f->n, sizeof *f->at, by_number);
    for (int i = 1; i < f->n; i++) {
        if (f->at[i].frame == f->at[i - 1].frame)
            return gp_fail(p->log, GP_ERR_DATA,
                           "%s: frame %lld is there twice; leave one out",
                           p->path, f->at[i].frame);
    }
    return GP_OK;
}

gp_status gp_camera_read(const struct gp_log *log, const char *path,
                         struct gp_camera_file *out)
{
    gp_status st;
    json_t *root = NULL, *frames;
    struct gp_camera_file f = {0};
    struct gp_json_place place = {.log = log, .path = path, .what = "frame"};
    GP_TRY(gp_json_read_most(log, path, MOST_BYTES, &root));
    GP_TRY(gp_json_array(&place, root, "frames", MOST_FRAMES, &frames));
    f.n = (int) json_array_size(frames);
    if (f.n == 0) {
        st = gp_fail(log, GP_ERR_DATA,
                     "%s: no frames (\"frames\" is empty); give each frame's "
                     "matrices", path);
        goto out;
    }
    GP_TRY(gp_alloc_zero(log, path, (size_t) f.n, sizeof *f.at,
                         (void **) &f.at));
    for (int i = 0; i < f.n; i++) {
        place.index = i + 1;
        GP_TRY(read_frame(&place, json_array_get(frames, (size_t) i),
                          &f.at[i]));
    }
    GP_TRY(sort_frames(&place, &f));
    place.index = 0;
    if (json_is_object(root))
        GP_TRY(gp_json_number(&place, root, "width", 1.0, 1e9, &f.width,
                              NULL));
    *out = f;
    f = (struct gp_camera_file) {0}; // the caller's
out:
    gp_camera_file_free(&f);
    json_decref(root);
    return st;
}

void gp_camera_file_free(struct gp_camera_file *f)
{
    GP_FREE(f->at);
    f->n = 0;
}

const struct gp_camera_frame *
gp_camera_frame_find(const struct gp_camera_file *f, long long number)
{
    if (f->n == 1)
        return &f->at[0];
    const struct gp_camera_frame key = {.frame = number};
    return f->n ? bsearch(&key, f->at, (size_t) f->n, sizeof key, by_number)
                : NULL;
}
