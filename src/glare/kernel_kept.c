// SPDX-License-Identifier: Apache-2.0
#include "glare/kernel_kept.h"

#include "core/memory.h"
#include "core/minmax.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

struct gp_kernels {
    const struct gp_kernel_request *request;
    pthread_mutex_t lock;
    struct gp_made_kernel *last; // held
};

// -- the request --------------------------------------------------------------

void gp_kernel_request_free(struct gp_kernel_request *r)
{
    for (int i = 0; i < GP_RECIPES; i++) {
        if (i < r->recipes)
            gp_recipe_free(&r->recipe[i]);
        gp_image_free(&r->image[i]);
    }
    *r = (struct gp_kernel_request) {0};
}

double gp_kernel_request_share(const struct gp_kernel_request *r)
{
    double all = 0.0, taken = 0.0;
    for (int i = 0; i < gp_max(r->recipes, 1); i++) {
        const double share = r->recipes ? r->recipe[i].value[0] : 1.0;
        all += share;
        taken += share * (r->label[i].present ? r->label[i].share : 1.0);
    }
    return taken / fmax(all, 1.0);
}

double gp_kernel_request_scale(const struct gp_kernel_request *r,
                               const struct gp_field *field)
{
    return r->degrees > 0.0 && field->degrees > 0.0
               ? r->degrees / (field->degrees * gp_image_h(&r->image[0]))
               : r->percent / 100.0;
}

// -- kernels that are kept ----------------------------------------------------

void gp_made_kernel_free(struct gp_made_kernel **k)
{
    if (*k && atomic_fetch_sub(&(*k)->holders, 1) == 1) {
        gp_kernel_free(&(*k)->k);
        for (int i = 0; i < GP_RECIPES; i++)
            gp_free((*k)->text[i]);
        gp_free(*k);
    }
    *k = NULL;
}

gp_status gp_kernels_make(const struct gp_log *log,
                          const struct gp_kernel_request *r,
                          struct gp_kernels **out)
{
    gp_status st = gp_alloc_zero(log, "kernels", 1, sizeof **out, out);
    if (st)
        return st;
    (*out)->request = r;
    pthread_mutex_init(&(*out)->lock, NULL);
    return GP_OK;
}

void gp_kernels_free(struct gp_kernels **k)
{
    if (!*k)
        return;
    gp_made_kernel_free(&(*k)->last);
    pthread_mutex_destroy(&(*k)->lock);
    GP_FREE(*k);
}

/* True where kernel `k` is that of `recipe` for field `b`. */
static bool is_same(const struct gp_kernel_request *r,
                    const struct gp_made_kernel *k,
                    const struct gp_recipe *recipe, const struct gp_field *b)
{
    const struct gp_field *const a = &k->field;
    const bool coloured = r->recipes || r->image[0].names_chromaticities;
    const bool later = a->frame != b->frame || a->fps != b->fps;
    bool same = a->aspect == b->aspect &&
                (!coloured || memcmp(a->chromaticities, b->chromaticities,
                                     sizeof a->chromaticities) == 0);
    for (int i = 0; i < r->recipes; i++)
        same = same && !(later && recipe[i].model->moves) &&
               memcmp(k->recipe[i].value, recipe[i].value,
                      sizeof recipe->value) == 0;
    if (!r->recipes)
        return same && (a->degrees == b->degrees || !(r->degrees > 0.0));
    return same && a->w == b->w && a->h == b->h && a->degrees == b->degrees &&
           a->tangent == b->tangent &&
           gp_projection_same(&a->projection, &b->projection) &&
           a->seen_w == b->seen_w && a->seen_h == b->seen_h;
}

/* Makes a kernel, and keeps it as the last one. */
static gp_status make_kernel(const struct gp_log *log, struct gp_kernels *k,
                             const struct gp_recipe *recipe,
                             const struct gp_field *field)
{
    const struct gp_kernel_request *const r = k->request;
    struct gp_made_kernel *m;
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *m, &m);
    if (st)
        return st;
    memcpy(m->recipe, recipe, sizeof m->recipe);
    struct gp_kernel_params p = r->params;
    p.aspect = field->aspect;
    p.rotate = (float) field->rotate;
    p.scale = gp_kernel_request_scale(r, field);
    p.chromaticities = field->chromaticities;
    st = r->recipes
             ? gp_model_kernel(log, m->recipe, r->recipes, field, &m->k)
             : gp_kernel_from_frame(log, &p, &r->image[0], &m->k);
    atomic_init(&m->holders, 1);
    for (int i = 0; i < r->recipes && !st; i++) {
        m->text[i] = gp_recipe_text(&m->recipe[i]);
        if (!m->text[i])
            st = gp_no_memory_bare(log, "kernel");
    }
    if (st) {
        gp_made_kernel_free(&m);
        return st;
    }
    if (r->recipes)
        gp_kernel_glance(&m->k, field->luminance, &m->figures);
    else
        gp_kernel_measure(&m->k, r->image[0].names_chromaticities
                                     ? field->luminance : r->image[0].luminance,
                          &m->figures);
    m->field = *field;
    gp_made_kernel_free(&k->last);
    k->last = m;
    return GP_OK;
}

gp_status gp_kernels_take(const struct gp_log *log, struct gp_kernels *k,
    const struct gp_recipe *recipe, const struct gp_field *field, bool *made,
    struct gp_made_kernel **out)
{
    gp_status st = GP_OK;
    if (!recipe)
        recipe = k->request->recipe;
    pthread_mutex_lock(&k->lock);
    *made = !k->last || !is_same(k->request, k->last, recipe, field);
    if (*made)
        st = make_kernel(log, k, recipe, field);
    *out = st ? NULL : k->last;
    if (*out)
        atomic_fetch_add(&(*out)->holders, 1);
    pthread_mutex_unlock(&k->lock);
    return st;
}

// -- labels -------------------------------------------------------------------

void gp_kernel_label_use(const struct glarepp_label *l, double scale,
                         const struct gp_kernel *k, int w, int h,
                         struct gp_kernel_use *use)
{
    const bool covers = k->w >= 2LL * w - 1 && k->h >= 2LL * h - 1;
    const bool fits = w <= ceil(l->w * scale) && h <= ceil(l->h * scale);
    use->as_it_is = l->present;
    use->missed = l->present && !covers
                      ? fmax(l->left_out - (fits ? l->beyond : 0.0), 0.0)
                      : 0.0;
    use->ends = l->present ? use->missed > 1e-5 : !covers;
}
