#include "cli/pictures.h"

#include "cli/hints.h"
#include "cli/kernel_label.h"
#include "core/memory.h"
#include "io/plane.h"

struct glarepp_image gp_decoded_of(const struct gp_frame *f,
                                 const struct gp_planes *planes)
{
    struct glarepp_image v = GLAREPP_IMAGE;
    for (int c = 0; c < 3; c++)
        v.plane[c] = planes->c[c];
    v.data = (struct glarepp_rect) {f->data.x0, f->data.y0, f->data.x1,
                                    f->data.y1};
    v.display = (struct glarepp_rect) {f->display.x0, f->display.y0,
                                       f->display.x1, f->display.y1};
    v.aspect = f->pixel_aspect;
    v.primaries = f->names_chromaticities ? f->chromaticities : NULL;
    v.name = f->path;
    return v;
}

/* Returns an attribute that is a positive number; 0: none. */
static double positive(const struct gp_frame *f, const char *name)
{
    double v = 0.0;
    return gp_frame_numbers(f, name, 1, &v) && v > 0.0 ? v : 0.0;
}

struct glarepp_frame_params gp_frame_params_of(const struct gp_job *job,
                                               const struct gp_frame *f)
{
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    double size[2] = {0};
    p.image = gp_decoded_of(f, &f->rgb);
    p.file = (struct glarepp_rect) {f->read.x0, f->read.y0, f->read.x1,
                                    f->read.y1};
    p.numbered = gp_job_number(job, &p.number);
    p.fps = positive(f, "framesPerSecond");
    p.has_camera = gp_frame_numbers(f, "worldToCamera", 16, p.to_camera);
    p.has_ndc = gp_frame_numbers(f, "worldToNDC", 16, p.to_ndc);
    if (!p.has_ndc) {
        p.has_ndc = gp_frame_numbers(f, "worldToScreen", 16, p.to_ndc);
        p.ndc = GLAREPP_NDC_CLIP;
    }
    p.focus = positive(f, "focus");
    p.aperture = positive(f, "aperture");
    p.white = positive(f, "whiteLuminance");
    if (gp_frame_numbers(f, "sensorOverallDimensions", 2, size) &&
        size[0] > 0.0)
        p.sensor = size[0]; // OpenEXR 3.2
    return p;
}

/* The frame that an image borrows from. */
static _Thread_local struct gp_frame lent;

static gp_status read_alpha(const struct gp_listener *l,
                            const struct glarepp_picture *p,
                            struct glarepp_image *out)
{
    struct gp_coverage a;
    const gp_status st = gp_read_coverage(l->log, &l->s->input.read, p->path,
                                          p->bytes, p->n, p->most, &a);
    if (st)
        return st;
    out->type = GLAREPP_CODES;
    out->plane[0] = a.code;
    out->data = (struct glarepp_rect) {0, 0, a.w, a.h};
    return GP_OK;
}

int gp_picture_read(void *user, const struct glarepp_picture *p,
                    struct glarepp_image *out, struct glarepp_label *label)
{
    const struct gp_listener *const l = user;
    const struct gp_read_params limits = gp_read_limits(&l->s->input.read);
    struct gp_file_label own;
    if (p->alpha)
        return (int) read_alpha(l, p, out);
    gp_status st = gp_read_frame(l->log, &limits, p->path, &lent);
    if (!st)
        st = gp_label_read(l->log, &lent, &own);
    if (st) {
        gp_frame_free(&lent);
        return (int) st;
    }
    *label = gp_label_of(&own);
    *out = gp_decoded_of(&lent, &lent.rgb);
    return GP_OK;
}

void gp_picture_release(void *user, struct glarepp_image *image)
{
    (void) user;
    if (image->type == GLAREPP_CODES)
        gp_free(image->plane[0]);
    else
        gp_frame_free(&lent);
}
