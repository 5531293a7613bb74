/* Makes the kernel of a run for the frames that need it, and keeps it while one
 * of them is in flight. */
#include "app/stages.h"

#include "core/colour.h"
#include "core/memory.h"
#include "io/read.h"

#include <string.h>

/* Pixels to which --grow kernel grows frames of models, which have no end. */
enum { MODEL_REACH = 255 };

// -- what was asked for -------------------------------------------------------

void gp_wanted_kernel_free(struct gp_wanted_kernel *k)
{
    for (int i = 0; i < GP_RECIPES; i++) {
        if (i < k->recipes)
            gp_recipe_free(&k->recipe[i]);
        gp_frame_free(&k->image[i]);
    }
    *k = (struct gp_wanted_kernel) {0};
}

gp_status gp_wanted_kernel_read(const struct gp_log *log,
    const struct gp_settings *s, struct gp_wanted_kernel *out)
{
    static const char *const usual[] = {"builtin:eye"};
    const struct gp_read_params limits = gp_read_limits(&s->read);
    const char *const *const at = s->kernels.n ? s->kernels.at : usual;
    const int n = s->kernels.n ? s->kernels.n : 1;
    struct gp_wanted_kernel k = {0};
    gp_status st = GP_OK;
    if (n > GP_RECIPES)
        return gp_fail(log, GP_ERR_USAGE, "--kernel: too many (found %d); give "
                       "up to %d", n, GP_RECIPES);
    if (n == 1 && !gp_recipe_is(at[0])) {
        st = gp_read_frame(log, &limits, at[0], &out->image[0]);
        return st;
    }
    for (int i = 0; i < n; i++) {
        GP_TRY(gp_recipe_parse(log, at[i], &k.recipe[i]));
        k.recipes++;
        const char *const file = gp_recipe_file(&k.recipe[i]);
        if (!file)
            continue;
        GP_TRY(gp_read_frame(log, &limits, file, &k.image[i]));
    }
    *out = k;
    for (int i = 0; i < n; i++)
        out->recipe[i].image = out->image[i].rgb.c[0] ? &out->image[i] : NULL;
    return GP_OK;
out:
    gp_wanted_kernel_free(&k);
    return st;
}

// -- made for frames ----------------------------------------------------------

void gp_run_kernel_free(struct gp_run_kernel **k)
{
    if (*k && atomic_fetch_sub(&(*k)->holders, 1) == 1) {
        gp_kernel_free(&(*k)->k);
        gp_free(*k);
    }
    *k = NULL;
}

/* True where the kernel for field `b` is that for field `a`. */
static bool is_same(const struct gp_run *r, const struct gp_field *a,
                    const struct gp_field *b)
{
    bool moves = false;
    if (!r->wanted.recipes)
        return a->aspect == b->aspect;
    for (int i = 0; i < r->wanted.recipes; i++)
        moves |= gp_recipe_moves(&r->wanted.recipe[i]);
    return a->w == b->w && a->h == b->h && a->degrees == b->degrees &&
           a->aspect == b->aspect && (!moves || a->frame == b->frame) &&
           memcmp(a->chromaticities, b->chromaticities,
                  8 * sizeof *a->chromaticities) == 0;
}

/* Makes the kernel for a field, unless r->kernel is that. */
static gp_status make_kernel(const struct gp_log *log, struct gp_run *r,
    const struct gp_field *field, const struct gp_frame *frame)
{
    struct gp_run_kernel *k;
    if (r->kernel && is_same(r, &r->kernel->field, field))
        return GP_OK;
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *k, &k);
    if (st)
        return st;
    struct gp_kernel_params p = r->s->kernel;
    p.frame = frame;
    st = r->wanted.recipes
             ? gp_model_kernel(log, r->wanted.recipe, r->wanted.recipes, field,
                               &k->k)
             : gp_kernel_from_frame(log, &p, &r->wanted.image[0], &k->k);
    if (st) {
        gp_free(k);
        return st;
    }
    k->field = *field;
    memcpy(k->chromaticities, field->chromaticities, sizeof k->chromaticities);
    k->field.chromaticities = k->chromaticities;
    atomic_init(&k->holders, 1);
    gp_run_kernel_free(&r->kernel);
    r->kernel = k;
    return GP_OK;
}

/* The field of a frame, and where its angle comes from. */
static struct gp_field find_field(struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_settings *const s = r->s;
    struct gp_sun_files files = {s, fs->job};
    struct gp_sun_about about = {0};
    const struct gp_sun_reader reader = gp_sun_reader_of(&files);
    double fov = (double) s->fov;
    fs->facts.fov_from = "option";
    if (!(fov > 0.0)) {
        reader.about(&files, &fs->frame, &about);
        fov = gp_suns_fov(&r->suns, &about, &fs->frame);
        fs->facts.fov_from = "camera";
    }
    if (!(fov > 0.0)) {
        fov = GP_USUAL_FOV;
        fs->facts.fov_from = "default";
    }
    struct gp_field field = gp_field_of(&fs->frame, fov);
    field.rotate = (double) s->kernel.rotate;
    field.frame = about.number;
    fs->facts.deg_per_pixel = r->wanted.recipes ? field.degrees : 0.0;
    return field;
}

gp_status gp_run_kernel_hold(struct gp_run *r, struct gp_frame_state *fs)
{
    gp_status st = GP_OK;
    if (fs->sources.n > 0 || gp_suns_glare(&r->suns)) {
        const struct gp_field field = find_field(r, fs);
        st = make_kernel(fs->log, r, &field, &fs->frame);
    }
    if (!st && r->kernel) {
        fs->kernel = r->kernel;
        fs->facts.kernel_left_out = fs->kernel->k.left_out;
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
    static const struct gp_frame square = {.data = {0, 0, 1, 1}};
    gp_status st = gp_wanted_kernel_read(log, r->s, &r->wanted);
    if (st)
        return st;
    r->reach = (struct gp_rect) {MODEL_REACH, MODEL_REACH, MODEL_REACH,
                                 MODEL_REACH};
    if (r->wanted.recipes)
        return GP_OK; // made for the first frame with light
    struct gp_field field = gp_field_of(&square, GP_USUAL_FOV);
    field.chromaticities = gp_rec709_chromaticities;
    field.luminance = gp_rec709_luminance;
    st = make_kernel(log, r, &field, NULL);
    if (st)
        return st;
    const struct gp_kernel *const k = &r->kernel->k;
    r->reach = (struct gp_rect) {k->cx, k->cy, k->w - 1 - k->cx,
                                 k->h - 1 - k->cy};
    return GP_OK;
}
