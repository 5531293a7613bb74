/* glare/model/make.c: kernels of a sequence, of which each keeps what the one
 * before has in common with it. */
#include "unit.h"
#include "glare/model/model_priv.h"
#include "glare/far_field/far_field.h"
#include "glare_scene.h"

#define FINE (1.0 / 36.0) // degrees of a pixel

/* Asserts that a kernel is that of gp_model_kernel() to the byte. */
static void assert_same_kernel(const struct gp_recipe *r, int n,
    const struct gp_field *field, const struct gp_kernel *k)
{
    struct gp_kernel fresh;
    assert_ok(gp_model_kernel(NULL, r, n, field, &fresh));
    assert_true(fresh.w == k->w && fresh.h == k->h && fresh.cx == k->cx &&
                fresh.cy == k->cy && !fresh.tail == !k->tail);
    for (int c = 0; c < 3; c++)
        assert_memory_equal(fresh.k.c[c], k->k.c[c], (size_t) k->w *
                            (size_t) k->h * sizeof(float));
    if (k->tail)
        assert_memory_equal(fresh.tail->c[0], k->tail->c[0],
            (2 * (size_t) k->tail->rx + 1) * (2 * (size_t) k->tail->ry + 1) *
            sizeof(float));
    gp_kernel_free(&fresh);
}

/* A sequence remakes only what its change touches: by time the model that
 * moves, none of the others, and the tail, of which it is a part; by size no shape that is as large in
 * both; by angle all. */
static void sequences_remake_what_changes(void **state)
{
    static const struct {
        int w, h, frame;
        double degrees;
        int opened;  // of three
        bool tail;   // that of the frame before
    } rows[] = {
        {430, 310, 1, FINE, 3, false}, {430, 310, 2, FINE, 1, false},
        {430, 310, 3, FINE, 1, false}, {450, 320, 3, FINE, 0, false},
        {450, 320, 3, FINE, 0, true},  {300, 320, 3, FINE, 0, false},
        {300, 280, 4, FINE, 1, false}, {300, 280, 4, 1.0 / 30.0, 3, false},
    };
    static const char *const words[] = {"cie", "temporal:reach=2",
                                        "cross:length=2"};
    struct gp_recipe r[COUNT(words)];
    struct gp_model_kept *kept = NULL;
    struct gp_kernel k[COUNT(rows)];
    struct gp_image f = scene_frame(430, 310, 0, 0, DARK, 0);
    struct gp_field field = gp_field_of(&f, 30.0);
    struct gp_far_state *tail = NULL;
    (void) state;
    for (size_t i = 0; i < COUNT(words); i++)
        assert_ok(gp_recipe_parse(NULL, words[i], &r[i]));
    for (size_t i = 0; i < COUNT(rows); i++) {
        field.w = rows[i].w;
        field.h = rows[i].h;
        field.frame = rows[i].frame;
        field.degrees = rows[i].degrees;
        assert_ok(gp_model_kernel_next(NULL, r, 3, &field, &kept, &k[i]));
        if (gp_model_opened(kept) != rows[i].opened)
            fail_msg("row %zu: %d opened", i, gp_model_opened(kept));
        assert_same_kernel(r, 3, &field, &k[i]);
        assert_non_null(k[i].tail);
        assert_true(i == 0 || !rows[i].tail == (k[i].tail != k[i - 1].tail));
        assert_ok(gp_far_open(NULL, k[i].tail, &tail));
        struct gp_far_state *own = NULL;
        assert_ok(gp_far_open(NULL, k[i].tail, &own));
        assert_memory_equal(gp_far_error_of(tail), gp_far_error_of(own),
                            sizeof(struct gp_far_error));
        gp_far_close(&own);
    }
    for (size_t i = 0; i < COUNT(rows); i++)
        gp_kernel_free(&k[i]); // some of them hold one tail
    gp_model_kept_free(&kept);
    gp_far_close(&tail);
    for (size_t i = 0; i < COUNT(words); i++)
        gp_recipe_free(&r[i]);
    gp_image_free(&f);
}

SUITE_OF(kept, NULL, NULL, sequences_remake_what_changes)

