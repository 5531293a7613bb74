// SPDX-License-Identifier: Apache-2.0
#include "api/plan.h"

#include "core/colour.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/kernel_check.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// -- words --------------------------------------------------------------------

/* Reads several words, or one recipe, as recipes, and their images. */
static gp_status read_recipes(struct glarepp *gp,
    const struct glarepp_kernel_params *p, const char *const *word, int words,
    struct gp_kernel_request *r)
{
    gp_status st = GP_OK;
    for (int i = 0; i < words && !st; i++) {
        struct gp_recipe *const recipe = &r->recipe[i];
        st = p->unread || gp_recipe_is(word[i])
                 ? gp_recipe_parse(&gp->log, word[i], recipe)
                 : gp_recipe_of_image(&gp->log, word[i], p->degrees,
                                      p->percent, recipe);
        r->recipes += !st;
        const char *const file =
            st || p->unread ? NULL : gp_recipe_file(recipe);
        if (!file)
            continue;
        st = gp_api_picture(gp, &gp->log, file, &r->image[i], &r->label[i]);
        if (st)
            break;
        if (strcmp(recipe->model->name, "image") != 0)
            r->label[i] = (struct glarepp_label) {0};
        recipe->image = &r->image[i];
        recipe->as_it_is = r->label[i].present;
    }
    return st;
}

static gp_status read_request(struct glarepp *gp,
    const struct glarepp_kernel_params *p, struct gp_kernel_request *r)
{
    static const char *const usual[] = {"builtin:eye"};
    const char *const *const word = p->words ? p->word : usual;
    const int words = p->words ? p->words : 1;
    gp_status st;
    r->percent = p->percent;
    r->degrees = p->degrees;
    for (int i = 0; i < words; i++) {
        if (!word[i])
            return gp_fail_at(&gp->log, GP_ERR_USAGE, "kernel.word", "kernel: "
                              "word %d is missing (found NULL)", i);
    }
    if (!(p->percent > 0.0) && !(p->degrees > 0.0))
        return gp_fail_at(&gp->log, GP_ERR_USAGE, "kernel.percent", "kernel: no "
                          "size (found %g %%)", p->percent);
    const bool one =
        p->image || (words == 1 && !p->recipe && !p->unread &&
                     !gp_recipe_is(word[0]));
    if (!one)
        return read_recipes(gp, p, word, words, r);
    if (p->image) {
        GP_TRY(gp_api_import(&gp->log, p->image, false, &r->image[0]));
        r->label[0] = p->label;
    } else {
        GP_TRY(gp_api_picture(gp, &gp->log, word[0], &r->image[0],
                              &r->label[0]));
    }
    r->params = (struct gp_kernel_params) {
        .centered = p->centred, .center = {p->centre[0], p->centre[1]},
        .normalize = p->as_it_is || (r->label[0].present && !p->normalized)
                         ? GP_NORMALIZE_NONE : GP_NORMALIZE_LUMINANCE,
        .left_out = r->label[0].left_out,
    };
out:
    return st;
}

int glarepp_kernel(struct glarepp *gp, const struct glarepp_kernel_params *p,
                   struct glarepp_kernel **out)
{
    struct glarepp *const outer = gp_api_begin(gp);
    struct glarepp_kernel_params own = GLAREPP_KERNEL_PARAMS;
    struct glarepp_kernel *k = NULL;
    gp_status st;
    *out = NULL;
    GP_TRY(gp_api_params(&gp->log, "kernel", &own, sizeof own, p));
    GP_TRY(gp_alloc_zero(&gp->log, "kernel", 1, sizeof *k, &k));
    k->gp = gp;
    GP_TRY(read_request(gp, &own, &k->request));
    for (int i = 0; i < k->request.recipes; i++) {
        k->text[i] = gp_recipe_text(&k->request.recipe[i]);
        if (!k->text[i])
            GP_TRY(gp_no_memory_bare(&gp->log, "kernel"));
    }
    *out = k;
    k = NULL;
out:
    glarepp_kernel_end(&k);
    return gp_api_end(outer, st);
}

void glarepp_kernel_end(struct glarepp_kernel **kernel)
{
    struct glarepp_kernel *const k = *kernel;
    if (!k)
        return;
    gp_kernel_request_free(&k->request);
    for (int i = 0; i < GP_RECIPES; i++)
        free(k->text[i]);
    GP_FREE(*kernel);
}

const char *glarepp_kernel_recipe(const struct glarepp_kernel *k, int i)
{
    return i >= 0 && i < k->request.recipes ? k->text[i] : NULL;
}

double glarepp_kernel_share(const struct glarepp_kernel *k)
{
    return gp_kernel_request_share(&k->request);
}

bool glarepp_kernel_path(const char *word, char *path, size_t room)
{
    char *const own = gp_kernel_path(word);
    const size_t bytes = own ? strlen(own) + 1 : 0;
    if (bytes && bytes <= room)
        memcpy(path, own, bytes);
    free(own);
    return bytes && bytes <= room;
}

// -- drawing ------------------------------------------------------------------

/* Makes an image of the kernel, whose centre is pixel (floor(w/2), floor(h/2)):
 * with the zero borders that make it symmetric. */
static gp_status image_of(const struct gp_log *log, const struct gp_kernel *k,
                          struct glarepp_image *out)
{
    const int rx = gp_max(abs(k->cx), abs(k->w - 1 - k->cx));
    const int ry = gp_max(abs(k->cy), abs(k->h - 1 - k->cy));
    const size_t w = 2 * (size_t) rx + 1, h = 2 * (size_t) ry + 1;
    struct gp_planes p;
    const gp_status st = gp_planes_make(log, "kernel", w * h, &p);
    if (st)
        return st;
    for (int c = 0; c < 3; c++) {
        memset(p.c[c], 0, w * h * sizeof(float));
        for (int y = 0; y < k->h; y++)
            memcpy(p.c[c] + (size_t) (y + ry - k->cy) * w +
                       (size_t) (rx - k->cx),
                   k->k.c[c] + (size_t) y * (size_t) k->w,
                   (size_t) k->w * sizeof(float));
    }
    *out = gp_api_view(&p, (struct gp_rect) {0, 0, (int) w, (int) h}, NULL);
    return GP_OK;
}

int glarepp_kernel_draw(const struct glarepp_kernel *kernel,
    const struct glarepp_field *field, struct glarepp_image *out,
    struct glarepp_label *label)
{
    struct glarepp *const outer = gp_api_begin(kernel->gp);
    const struct gp_log *const log = &kernel->gp->log;
    const struct gp_kernel_request *const r = &kernel->request;
    const int reach = field->radius ? field->radius + 1 : INT_MAX;
    const int cut_w = gp_min(field->w, reach), cut_h = gp_min(field->h, reach);
    const long long w = 2LL * cut_w - 1, h = 2LL * cut_h - 1;
    const double fov = field->fov > 0.0 ? field->fov : GP_USUAL_FOV;
    struct gp_kernel k = {0}, cut = {0};
    gp_status st;
    if (!r->recipes)
        GP_TRY(gp_fail_at(log, GP_ERR_USAGE, "kernel.word", "kernel: an image, "
                          "which has its samples already"));
    GP_TRY(gp_api_check(log, "field", field));
    if (w * h > field->most)
        GP_TRY(gp_fail_at(log, GP_ERR_DATA, "field.most", "%s: the kernel is "
                          "too large (%lldx%lld, at most %lld pixels)",
                          field->name ? field->name : "kernel", w, h,
                          field->most));
    // for the whole frame, to know what falls outside of it; where that is too
    // large itself, all light counts as falling inside
    const bool whole =
        (2LL * field->w - 1) * (2LL * field->h - 1) <= field->most;
    struct gp_image like = gp_image_blank((struct gp_rect) {0, 0, 1, 1});
    if (field->primaries)
        memcpy(like.chromaticities, field->primaries,
               sizeof like.chromaticities);
    gp_luminance_weights(like.chromaticities, like.luminance);
    struct gp_field own = gp_field_of(&like, 0.0);
    own.w = whole ? field->w : cut_w;
    own.h = whole ? field->h : cut_h;
    own.degrees = gp_middle_degrees(fov, field->h);
    own.aspect = field->aspect > 0.0 ? field->aspect : 1.0;
    own.rotate = field->rotate;
    own.frame = field->frame;
    own.fps = field->fps > 0.0 ? field->fps : own.fps;
    GP_TRY(gp_model_kernel(log, r->recipe, r->recipes, &own, &k));
    GP_TRY(gp_kernel_whole(log, &k, cut_w, cut_h, &cut));
    *label = (struct glarepp_label) {
        .present = true,
        .w = field->w,
        .h = field->h,
        .fov = fov,
        .left_out = cut.left_out,
        .beyond = whole ? k.left_out : 0.0,
        .share = gp_kernel_request_share(r),
        .degrees = own.degrees,
    };
    GP_TRY(image_of(log, &cut, out));
out:
    gp_kernel_free(&k);
    gp_kernel_free(&cut);
    return gp_api_end(outer, st);
}

// -- checks -------------------------------------------------------------------

/* Faults of the last check of a thread. */
struct faults {
    struct gp_fault found[GP_KERNEL_RULES];
    const char *line[GP_KERNEL_RULES], *parameter[GP_KERNEL_RULES];
};
static _Thread_local struct faults faults;

/* Counts the samples that are not finite; returns whether any is light. */
static bool look_at(const struct gp_image *f, long long *nonfinite)
{
    bool lit = false;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < gp_image_pixels(f); i++) {
            *nonfinite += !isfinite(f->rgb.c[c][i]);
            lit |= fabsf(f->rgb.c[c][i]) >= FLT_MIN;
        }
    }
    return lit;
}

int glarepp_kernel_check(struct glarepp *gp, const struct glarepp_image *kernel,
    const struct glarepp_kernel_use *how, struct glarepp_kernel_figures *out)
{
    struct glarepp *const outer = gp_api_begin(gp);
    const struct glarepp_label label = how->label;
    const double scale = how->percent > 0.0 ? how->percent / 100.0 : 1.0;
    const struct gp_kernel_params p = {
        .normalize = GP_NORMALIZE_NONE, .rotate = (float) how->rotate,
        .scale = scale,
    };
    struct gp_kernel_use use = {
        .add = how->add, .brightest = how->brightest, .share = label.share,
    };
    struct gp_kernel_figures f = {0};
    struct gp_kernel k = {0};
    struct gp_image image = {0};
    gp_status st;
    *out = (struct glarepp_kernel_figures) {0};
    GP_TRY(gp_api_import(&gp->log, kernel, false, &image));
    const bool lit = look_at(&image, &f.nonfinite);
    if (!f.nonfinite && lit)
        GP_TRY(gp_kernel_from_frame(&gp->log, &p, &image, &k));
    k.left_out = label.left_out;
    gp_kernel_label_use(&label, scale, &k,
                        how->w ? how->w : label.present ? label.w : INT_MAX,
                        how->h ? how->h : label.present ? label.h : INT_MAX,
                        &use);
    use.resampled = k.resampled;
    f.measured = !f.nonfinite; // of no light the sums are 0
    if (!f.nonfinite && lit) {
        gp_kernel_measure(&k, image.luminance, &f);
        out->rim = f.rim;
        if (!use.as_it_is && f.light > 0.0)
            f.rim /= f.light; // as a run normalises it
    }
    *out = (struct glarepp_kernel_figures) {
        .w = k.w, .h = k.h, .centre = {k.cx, k.cy},
        .sum = {f.sum[0], f.sum[1], f.sum[2]}, .light = f.light, .own = f.own,
        .left_out = f.left_out, .missed = use.missed, .peak = f.place.peak,
        .centroid = {f.place.centroid[0], f.place.centroid[1]},
        .peak_at = {f.place.peak_at[0], f.place.peak_at[1]}, .rim = out->rim,
        .border = f.border, .asymmetry = f.place.asymmetry,
        .negatives = f.negatives, .nonfinite = f.nonfinite, .lit = lit,
    };
    for (int i = 0; i < GP_KERNEL_RULES; i++) {
        struct gp_fault *const fault = &faults.found[out->faults];
        if (!gp_kernel_fault(&f, &use, (enum gp_kernel_rule) i, fault))
            continue;
        faults.line[out->faults] = fault->line;
        faults.parameter[out->faults++] = fault->parameter;
    }
    out->fault = faults.line;
    out->parameter = faults.parameter;
out:
    gp_kernel_free(&k);
    gp_image_free(&image);
    return gp_api_end(outer, st);
}
