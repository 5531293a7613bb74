// SPDX-License-Identifier: Apache-2.0
/* glarepp_compare(): contracts; its figures are tested in unit/compare. */
#include "unit.h"

#include "glarepp.h"

#include <math.h>

enum { W = 16, H = 9, PIXELS = W * H };

static float grey[PIXELS], spot[PIXELS]; // 0.5; the same with 1.5 at (3, 2)

static const struct glarepp_channel named[] = {
    {"Y", grey, false}, {"extra", grey, false},
};
static const struct glarepp_channel other[] = {
    {"more", grey, false}, {"Y", spot, false},
};

static int start(void **state)
{
    for (int i = 0; i < PIXELS; i++)
        grey[i] = spot[i] = 0.5f;
    spot[2 * W + 3] = 1.5f;
    return 0;
}

static struct glarepp_stored stored(const struct glarepp_channel *channel,
                                    const float *light, int x)
{
    return (struct glarepp_stored) {
        .size = sizeof(struct glarepp_stored), .data = {x, 0, x + W, H},
        .channel = channel, .channels = 2, .light = {light, light, light},
    };
}

/* Pairs are those of names, then of what is left; facts are of the union. */
static void pairs_and_facts(void **state)
{
    const struct glarepp_stored a = stored(named, grey, 0);
    const struct glarepp_stored b = stored(other, spot, 2);
    struct glarepp_compare *c;
    struct glarepp *gp;
    assert_int_equal(glarepp_open(NULL, &gp), GLAREPP_OK);
    assert_int_equal(glarepp_compare(gp, NULL, &a, &a, &c), GLAREPP_OK);
    const struct glarepp_compare_facts *f = glarepp_compare_facts(c);
    assert_int_equal(f->result, 0);
    assert_true(f->max == 0.0 && f->has_flip && f->hdr && f->flip == 0.0);
    glarepp_compare_end(&c);
    assert_null(c);
    assert_int_equal(glarepp_compare(gp, NULL, &a, &b, &c), GLAREPP_OK);
    f = glarepp_compare_facts(c);
    assert_int_equal(f->result, 2);
    assert_true(f->window.x0 == 0 && f->window.x1 == W + 2);
    assert_int_equal(f->pairs, 2);
    assert_string_equal(f->pair[0], "Y");
    assert_true(f->in_a[0] == 0 && f->in_b[0] == 1);
    assert_true(f->in_a[1] == 1 && f->in_b[1] == 0);
    assert_true(f->max == 1.0 && f->x == 5 && f->y == 2 && f->channel == 0);
    assert_true(f->worst_a == 0.5 && f->worst_b == 1.5);
    assert_true(f->seen == -1 && f->flip > 0.0);
    glarepp_compare_end(&c);
    glarepp_close(&gp);
}

/* Pictures are of the window, and the caller's until he ends them. */
static void pictures(void **state)
{
    const struct glarepp_stored a = stored(named, NULL, 0);
    const struct glarepp_stored b = stored(other, spot, 0);
    struct glarepp_compare_params p = GLAREPP_COMPARE_PARAMS;
    struct glarepp_compare *c;
    struct glarepp_image v;
    struct glarepp *gp;
    assert_int_equal(glarepp_open(NULL, &gp), GLAREPP_OK);
    assert_int_equal(glarepp_compare(gp, &p, &a, &b, &c), GLAREPP_OK);
    assert_false(glarepp_compare_facts(c)->lit);
    for (int pair = -3; pair < 0; pair++)
        assert_int_equal(glarepp_compare_view(c, pair, false, 1.0f, &v),
                         GLAREPP_ERR_USAGE); // without light there is no FLIP
    assert_null(v.plane[0]);
    assert_int_equal(glarepp_compare_view(c, 2, false, 1.0f, &v),
                     GLAREPP_ERR_USAGE);
    for (int k = 0; k < 2; k++) {
        assert_int_equal(glarepp_compare_view(c, 0, k, 3.0f, &v), GLAREPP_OK);
        assert_true(v.data.x0 == 0 && v.data.x1 == W && v.data.y1 == H);
        assert_true(((float *) v.plane[0])[2 * W + 3] == (k ? 3.0f : -3.0f));
        glarepp_image_end(&v);
    }
    glarepp_compare_end(&c);
    const struct glarepp_stored lit = stored(named, grey, 0);
    assert_int_equal(glarepp_compare(gp, &p, &lit, &b, &c), GLAREPP_OK);
    assert_int_equal(glarepp_compare_view(c, -1, false, 1.0f, &v), GLAREPP_OK);
    const float *const red = v.plane[0];
    assert_true(red[2 * W + 3] > 2.0f * red[PIXELS - 1]);
    glarepp_image_end(&v);
    assert_int_equal(glarepp_compare_view(c, -2, false, 1.0f, &v), GLAREPP_OK);
    double sum = 0.0;
    for (int i = 0; i < PIXELS; i++)
        sum += (double) ((float *) v.plane[0])[i];
    assert_true(fabs(sum / PIXELS - glarepp_compare_facts(c)->flip) < 1e-6);
    glarepp_image_end(&v);
    glarepp_compare_end(&c);
    glarepp_close(&gp);
}

/* Images that cannot be compared are an error that names a parameter. */
static void errors(void **state)
{
    static const int64_t first[PIXELS + 1];
    struct glarepp_compare_params p = GLAREPP_COMPARE_PARAMS;
    struct glarepp_stored a = stored(named, grey, 0);
    struct glarepp_stored b = stored(other, spot, 5);
    struct glarepp_compare *c;
    struct glarepp *gp;
    assert_int_equal(glarepp_open(NULL, &gp), GLAREPP_OK);
    p.most = (W + 5) * H;
    assert_int_equal(glarepp_compare(gp, &p, &a, &b, &c), GLAREPP_OK);
    glarepp_compare_end(&c);
    p.most--;
    a.name = "first.exr";
    assert_int_equal(glarepp_compare(gp, &p, &a, &b, &c), GLAREPP_ERR_DATA);
    assert_null(c);
    assert_string_equal(glarepp_error()->parameter, "compare.most");
    assert_memory_equal(glarepp_error()->text, "first.exr: ", 11);
    p.most = 1LL << 28;
    b.data = (struct glarepp_rect) {INT32_MAX - W, 0, INT32_MAX, H};
    assert_int_equal(glarepp_compare(gp, &p, &a, &b, &c), GLAREPP_ERR_DATA);
    b = stored(other, NULL, 0);
    b.first = first;
    assert_int_equal(glarepp_compare(gp, &p, &a, &b, &c), GLAREPP_ERR_DATA);
    assert_string_equal(glarepp_error()->parameter, "stored.first");
    b = stored(other, spot, 0);
    b.data.x1 = 0;
    assert_int_equal(glarepp_compare(gp, &p, &a, &b, &c), GLAREPP_ERR_USAGE);
    assert_string_equal(glarepp_error()->parameter, "stored.data");
    b.size = 1;
    assert_int_equal(glarepp_compare(gp, &p, &a, &b, &c), GLAREPP_ERR_USAGE);
    assert_string_equal(glarepp_error()->parameter, "stored");
    b = stored(other, spot, 0);
    p.exposures = 65;
    assert_int_equal(glarepp_compare(gp, &p, &a, &b, &c), GLAREPP_ERR_USAGE);
    glarepp_close(&gp);
}

SUITE_OF(compare, start, NULL, pairs_and_facts, pictures, errors)
