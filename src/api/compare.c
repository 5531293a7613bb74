#include "api/api.h"

#include "compare/compare.h"
#include "core/colour.h"
#include "core/memory.h"

#include <stdint.h>
#include <string.h>

struct glarepp_compare {
    struct glarepp *gp;
    struct gp_stored_image image[2]; // views of the caller's; channels owned
    struct gp_compare_match match;
    struct gp_compare_flip flip;
    const char **name;               // of each pair
    int *channel[2];                 // of each pair in each image
    struct glarepp_compare_facts facts;
};

/* Takes an image as it is: only its list of channels is made again. */
static gp_status view_of(const struct gp_log *log,
    const struct glarepp_stored *from, struct gp_stored_image *to)
{
    struct gp_image blank;
    struct glarepp_stored s = {.size = sizeof s};
    gp_status st = gp_api_params(log, "stored", &s, sizeof s, from);
    if (st)
        return st;
    const struct gp_rect data = {s.data.x0, s.data.y0, s.data.x1, s.data.y1};
    const bool lit = s.light[0] && s.light[1] && s.light[2];
    if (gp_rect_empty(data))
        return gp_fail_at(log, GP_ERR_USAGE, "stored.data", "%s: no window of "
                          "pixels (found %d,%d to %d,%d)",
                          s.name ? s.name : "image", data.x0, data.y0, data.x1,
                          data.y1);
    blank = gp_image_blank(data);
    *to = (struct gp_stored_image) {
        .data = data, .display = data, .channels = s.channels,
        .deep = s.first != NULL, .first = (int64_t *) s.first,
        .integers = s.integers,
    };
    for (int c = 0; c < 3; c++)
        to->light[c] = lit ? s.light[c] : NULL;
    memcpy(to->luminance, blank.luminance, sizeof to->luminance);
    if (s.primaries)
        gp_luminance_weights(s.primaries, to->luminance);
    st = gp_alloc(log, "channels", (size_t) s.channels, sizeof *to->channel,
                  &to->channel);
    for (int i = 0; i < s.channels && !st; i++)
        to->channel[i] = (struct gp_stored_channel) {
            (char *) s.channel[i].name, s.channel[i].is_uint,
            (void *) s.channel[i].v};
    return st;
}

/* Checks that the two can be compared, in as many pixels as there may be. */
static gp_status check_windows(const struct gp_log *log,
    const struct gp_compare_match *m, long long most, const char *a,
    const char *b)
{
    const long long w = (long long) m->window.x1 - m->window.x0;
    const long long h = (long long) m->window.y1 - m->window.y0;
    if (m->a->deep != m->b->deep)
        return gp_fail_at(log, GP_ERR_DATA, "stored.first", "%s: only one of it "
                          "and %s is deep", a, b);
    // windows far apart make a union much larger than both images
    if (w > most || h > most / w || w > INT32_MAX / 4 || h > INT32_MAX / 4)
        return gp_fail_at(log, GP_ERR_DATA, "compare.most", "%s: its window and "
                          "that of %s are too far apart (%lld x %lld pixels "
                          "over both, at most %lld)", a, b, w, h, most);
    return GP_OK;
}

/* Lists the pairs' names, and their channels in each image. */
static gp_status list_pairs(const struct gp_log *log, struct glarepp_compare *c)
{
    const struct gp_compare_match *const m = &c->match;
    const size_t n = (size_t) m->pairs;
    gp_status st;
    GP_TRY(gp_alloc(log, "channels", n, sizeof *c->name, &c->name));
    for (int k = 0; k < 2; k++)
        GP_TRY(gp_alloc(log, "channels", n, sizeof(int), &c->channel[k]));
    for (int i = 0; i < m->pairs; i++) {
        const struct gp_compare_pair *const p = &m->pair[i];
        c->name[i] = gp_compare_name(m, i);
        c->channel[0][i] = p->a ? (int) (p->a - m->a->channel) : -1;
        c->channel[1][i] = p->b ? (int) (p->b - m->b->channel) : -1;
    }
out:
    return st;
}

static void note_facts(struct glarepp_compare *c,
                       const struct gp_compare_figures *f)
{
    const struct gp_rect w = c->match.window;
    const struct gp_compare_flip *const flip = &c->flip;
    c->facts = (struct glarepp_compare_facts) {
        .window = {w.x0, w.y0, w.x1, w.y1}, .pairs = c->match.pairs,
        .pair = c->name, .in_a = c->channel[0], .in_b = c->channel[1],
        .max = f->max, .x = f->x, .y = f->y, .channel = f->channel,
        .worst_a = f->worst_a, .worst_b = f->worst_b, .mean = f->mean,
        .rms = f->rms, .psnr = f->psnr, .rel_l2 = f->rel_l2,
        .max_rel = f->max_rel, .nonfinite = f->nonfinite, .uneven = f->uneven,
        .uneven_x = f->uneven_x, .uneven_y = f->uneven_y, .warned = f->warned,
        .failed = f->failed, .seen = f->seen, .pixels = f->pixels,
        .lit = c->match.lit, .has_flip = flip->known, .hdr = flip->hdr,
        .flip = flip->mean, .start = flip->exposures.start,
        .stop = flip->exposures.stop, .exposures = flip->exposures.count,
    };
}

int glarepp_compare(struct glarepp *gp, const struct glarepp_compare_params *how,
    const struct glarepp_stored *a, const struct glarepp_stored *b,
    struct glarepp_compare **out)
{
    const struct gp_api_call call = gp_api_begin(gp);
    struct gp_api_sink sink = {.gp = gp, .name = a->name};
    const struct gp_log log = gp_api_log(&sink);
    struct glarepp_compare_params p = GLAREPP_COMPARE_PARAMS;
    struct gp_compare_figures f;
    struct glarepp_compare *c = NULL;
    gp_status st;
    *out = NULL;
    GP_TRY(gp_api_params(&log, "compare", &p, sizeof p, how));
    const struct gp_compare_params limits = {
        .fail = p.fail, .warn = p.warn, .fail_relative = p.fail_relative,
        .warn_relative = p.warn_relative, .fail_percent = p.fail_percent,
        .warn_percent = p.warn_percent, .hard_fail = p.hard_fail,
        .hard_warn = p.hard_warn, .allow_failures = p.allow_failures,
        .fail_flip = p.fail_flip, .fail_rel = p.fail_rel,
    };
    const struct gp_flip_exposures e = {p.start, p.stop, p.exposures};
    GP_TRY(gp_alloc_zero(&log, "comparison", 1, sizeof *c, &c));
    c->gp = gp;
    GP_TRY(view_of(&log, a, &c->image[0]));
    GP_TRY(view_of(&log, b, &c->image[1]));
    GP_TRY(gp_compare_match_make(&log, &c->image[0], &c->image[1], &c->match));
    GP_TRY(check_windows(&log, &c->match, p.most, a->name ? a->name : "image",
                         b->name ? b->name : "the other"));
    GP_TRY(list_pairs(&log, c));
    GP_TRY(gp_compare_measure(&log, &limits, &c->match, &f));
    if (p.flip)
        GP_TRY(gp_compare_flip(&log, p.exposures ? &e : NULL, &c->match,
                               &c->flip));
    if (p.perceptual && c->match.lit)
        GP_TRY(gp_compare_see(&log, &c->match, &f.seen));
    note_facts(c, &f);
    c->facts.result = (int) gp_compare_judge(&limits, &f, &c->flip);
    *out = c;
    c = NULL;
out:
    glarepp_compare_end(&c);
    return gp_api_end(&call, st);
}

void glarepp_compare_end(struct glarepp_compare **compare)
{
    struct glarepp_compare *const c = *compare;
    if (!c)
        return;
    gp_compare_flip_free(&c->flip);
    gp_compare_match_free(&c->match);
    for (int i = 0; i < 2; i++) {
        gp_free(c->image[i].channel);
        gp_free(c->channel[i]);
    }
    gp_free(c->name);
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
    const struct gp_api_call call = gp_api_begin(c->gp);
    const struct gp_log *const log = &c->gp->log;
    const struct gp_image f = gp_image_blank(c->match.window);
    const size_t pixels = gp_image_pixels(&f);
    struct gp_planes p = {0};
    gp_status st;
    *out = (struct glarepp_image) GLAREPP_IMAGE;
    if (pair < -1 || pair >= c->match.pairs || (pair == -1 && !c->flip.known))
        GP_TRY(gp_fail_at(log, GP_ERR_USAGE, "pair", "comparison: %s (found %d)",
                          pair == -1 ? "no map of FLIP" : "no such pair", pair));
    if (pair >= 0 && c->match.a->deep)
        GP_TRY(gp_fail_at(log, GP_ERR_USAGE, "pair", "comparison: deep images "
                          "have no pictures (found pair %d)", pair));
    if (pair == -1) {
        GP_TRY(gp_planes_make(log, "heatmap", pixels, &p));
        gp_compare_heatmap(c->flip.map, pixels, &p);
    } else {
        GP_TRY(gp_alloc(log, c->name[pair], pixels, sizeof(float), &p.c[0]));
        gp_compare_subtract(&c->match, pair, absolute, scale, p.c[0]);
    }
    *out = gp_api_view(&p, f.data, NULL);
out:
    return gp_api_end(&call, st);
}
