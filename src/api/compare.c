// SPDX-License-Identifier: Apache-2.0
#include "api/api.h"

#include "compare/compare.h"
#include "core/memory.h"

#include <stdint.h>
#include <string.h>

struct glarepp_compare {
    struct glarepp *gp;
    struct glarepp_stored image[2];  // the caller's
    struct gp_compare_match match;
    float *map;                      // of FLIP; NULL: none
    struct glarepp_compare_facts facts;
};

static gp_status take_image(const struct gp_log *log,
    const struct glarepp_stored *from, struct glarepp_stored *to)
{
    const gp_status st = gp_api_params(log, "stored", to, sizeof *to, from);
    const struct glarepp_rect r = to->data;
    return st || (r.x1 > r.x0 && r.y1 > r.y0)
               ? st
               : gp_fail_at(log, GP_ERR_USAGE, "stored.data", "%s: no window of "
                            "pixels (found %d,%d to %d,%d)",
                            to->name ? to->name : "image", r.x0, r.y0, r.x1,
                            r.y1);
}

/* Checks that the two can be compared, in as many pixels as there may be. */
static gp_status check_windows(const struct gp_log *log,
    const struct gp_compare_match *m, long long most, const char *a,
    const char *b)
{
    const long long w = (long long) m->window.x1 - m->window.x0;
    const long long h = (long long) m->window.y1 - m->window.y0;
    if (!m->a->first != !m->b->first)
        return gp_fail_at(log, GP_ERR_DATA, "stored.first", "%s: only one of it "
                          "and %s is deep", a, b);
    // windows far apart make a union much larger than both images
    if (w > most || h > most / w || w > INT32_MAX / 4 || h > INT32_MAX / 4)
        return gp_fail_at(log, GP_ERR_DATA, "compare.most", "%s: its window and "
                          "that of %s are too far apart (%lld x %lld pixels "
                          "over both, at most %lld)", a, b, w, h, most);
    return GP_OK;
}

int glarepp_compare(struct glarepp *gp, const struct glarepp_compare_params *how,
    const struct glarepp_stored *a, const struct glarepp_stored *b,
    struct glarepp_compare **out)
{
    struct glarepp *const outer = gp_api_begin(gp);
    struct gp_api_sink sink = {.gp = gp, .name = a->name};
    const struct gp_log log = gp_api_log(&sink);
    struct glarepp_compare_params p = GLAREPP_COMPARE_PARAMS;
    struct glarepp_compare *c = NULL;
    gp_status st;
    *out = NULL;
    GP_TRY(gp_api_params(&log, "compare", &p, sizeof p, how));
    GP_TRY(gp_alloc_zero(&log, "comparison", 1, sizeof *c, &c));
    c->gp = gp;
    GP_TRY(take_image(&log, a, &c->image[0]));
    GP_TRY(take_image(&log, b, &c->image[1]));
    const struct gp_compare_match *const m = &c->match;
    GP_TRY(gp_compare_match_make(&log, &c->image[0], &c->image[1], &c->match));
    GP_TRY(check_windows(&log, m, p.most, a->name ? a->name : "image",
                         b->name ? b->name : "the other"));
    GP_TRY(gp_compare_measure(&log, &p, m, &c->facts));
    if (p.flip && m->lit)
        GP_TRY(gp_compare_flip(&log, &p, m, &c->facts, &c->map));
    if (p.perceptual && m->lit)
        GP_TRY(gp_compare_see(&log, m, &c->facts.seen));
    gp_compare_judge(&p, &c->facts);
    *out = c;
    c = NULL;
out:
    glarepp_compare_end(&c);
    return gp_api_end(outer, st);
}

void glarepp_compare_end(struct glarepp_compare **compare)
{
    struct glarepp_compare *const c = *compare;
    if (!c)
        return;
    gp_compare_match_free(&c->match);
    gp_free(c->map);
    GP_FREE(*compare);
}

const struct glarepp_compare_facts *
glarepp_compare_facts(const struct glarepp_compare *compare)
{
    return &compare->facts;
}

int glarepp_compare_view(const struct glarepp_compare *c, int pair,
                         bool absolute, float scale, struct glarepp_image *out)
{
    struct glarepp *const outer = gp_api_begin(c->gp);
    const struct gp_log *const log = &c->gp->log;
    const struct gp_image f = gp_image_blank(c->match.window);
    const size_t pixels = gp_image_pixels(&f);
    struct gp_planes p = {0};
    gp_status st;
    *out = (struct glarepp_image) GLAREPP_IMAGE;
    if (pair < -2 || pair >= c->match.pairs || (pair < 0 && !c->map))
        GP_TRY(gp_fail_at(
            log, GP_ERR_USAGE, "pair", "comparison: %s (found %d)",
            pair == -1 || pair == -2 ? "no map of FLIP" : "no such pair",
            pair));
    if (pair >= 0 && c->match.a->first)
        GP_TRY(gp_fail_at(log, GP_ERR_USAGE, "pair", "comparison: deep images "
                          "have no pictures (found pair %d)", pair));
    if (pair == -1) {
        GP_TRY(gp_planes_make(log, "heatmap", pixels, &p));
        gp_compare_heatmap(c->map, pixels, &p);
    } else if (pair == -2) {
        GP_TRY(gp_alloc(log, "map", pixels, sizeof(float), &p.c[0]));
        memcpy(p.c[0], c->map, pixels * sizeof(float));
    } else {
        GP_TRY(gp_alloc(log, c->match.name[pair], pixels, sizeof(float), &p.c[0]));
        gp_compare_subtract(&c->match, pair, absolute, scale, p.c[0]);
    }
    *out = gp_api_view(&p, f.data, NULL);
out:
    return gp_api_end(outer, st);
}
