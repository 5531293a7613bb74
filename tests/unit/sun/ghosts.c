// SPDX-License-Identifier: Apache-2.0
/* ghosts: sources scale about the centre, and runs equal the sum over sources
 * of each one's element. */
#include "scene.h"

#include "glare/engine.h"
#include "sun/ghosts.h"

enum { SOURCES = 14 };

/* A frame with sources, and the same as a list. */
struct sky {
    struct gp_rect data, display;
    struct gp_source at[SOURCES];
    struct gp_sources src;
};

static void sky_make(struct sky *s, struct gp_rect data, struct gp_rect display)
{
    const struct gp_sources like = {
        .w = gp_rect_w(data), .h = gp_rect_h(data), .x0 = data.x0,
        .y0 = data.y0, .luminance = {0.3f, 0.6f, 0.1f},
    };
    struct gp_sources none;
    struct gp_source copy[SOURCES];
    seed = 7;
    s->data = data;
    s->display = display;
    for (int i = 0; i < SOURCES; i++) {
        s->at[i] = (struct gp_source) {
            .x = (int) (uniform01() * like.w),
            .y = (int) (uniform01() * like.h),
        };
        for (int c = 0; c < 3; c++)
            s->at[i].rgb[c] = (float) (0.1 + 50.0 * uniform01());
    }
    memcpy(copy, s->at, sizeof copy);
    assert_ok(gp_sources_make(&kept_log, &like, 0, &none));
    gp_sources_finish(&none);
    assert_ok(gp_sources_join(&kept_log, &none, copy, SOURCES, &s->src));
    gp_sources_free(&none);
}

/* A flare that borrows e. */
static struct gp_flare flare_of(struct gp_flare_element *e, int n)
{
    static char name[] = "f.json";
    for (int i = 0; i < n; i++)
        e[i].source = GP_FLARE_BRIGHT;
    return (struct gp_flare) {.element = e, .n = n, .path = name};
}

/* Adds the reference to 3 planes of the frame: each source's elements, drawn at
 * the four points of the grid that share its light. */
static void add_reference(const struct sky *s, const struct gp_flare *f,
                          double *out)
{
    const size_t n = (size_t) gp_rect_w(s->data) * (size_t) gp_rect_h(s->data);
    const double c[2] = {0.5 * (s->display.x0 + s->display.x1),
                         0.5 * (s->display.y0 + s->display.y1)};
    for (int k = 0; k < f->n; k++) {
        struct gp_flare_element e = f->element[k];
        const double scale = 1.0 - e.at;
        e.at = 0.0;
        e.source = GP_FLARE_LIGHTS;
        for (int i = 0; i < 4 * SOURCES; i++) {
            const struct gp_source *const q = &s->at[i / 4];
            const int of[2] = {s->data.x0 + q->x, s->data.y0 + q->y};
            double to[2], share = 1.0;
            for (int a = 0; a < 2; a++) {
                const double base = c[a] + scale * (floor(c[a]) + 0.5 - c[a]);
                const double u = scale * (of[a] - floor(c[a]));
                const int more = i >> a & 1;
                to[a] = base + floor(u) + more;
                share *= more ? u - floor(u) : 1.0 - (u - floor(u));
            }
            struct picture p = picture_make(s->data, s->display);
            struct gp_light l = lamp_at(to[0], to[1]);
            memcpy(l.flux, q->rgb, sizeof l.flux);
            if (share > 0.0)
                add_one(&p, e, l);
            for (int b = 0; b < 3; b++) {
                for (size_t at = 0; at < n; at++)
                    out[(size_t) b * n + at] +=
                        share * (double) p.layer.c[b][at];
            }
            picture_free(&p);
        }
    }
}

/* Adds run's layer by an engine; returns the bound times the layer's norm. */
static double add_run(const struct sky *s, const struct gp_ghosts *g,
    const struct gp_ghost *run, const char *engine, double *out)
{
    struct gp_glare_params params = GP_GLARE_DEFAULTS;
    struct gp_glare glare = {0};
    struct glarepp_layer_facts stats;
    struct gp_sources moved;
    struct gp_image f = {.display = s->display};
    const size_t n = (size_t) gp_rect_w(s->data) * (size_t) gp_rect_h(s->data);
    double norm2 = 0.0;
    params.engine = engine;
    assert_ok(gp_ghost_move(&kept_log, g, run, &s->src, &moved));
    f.data = (struct gp_rect) {moved.x0, moved.y0, moved.x0 + moved.w,
                               moved.y0 + moved.h};
    assert_ok(gp_glare_run(&kept_log, &params, &glare, &moved, &run->kernel,
                           &f, &stats));
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < gp_image_pixels(&f); i++) {
            const double v = (double) f.layer.c[c][i];
            const int x = f.data.x0 + (int) i % moved.w - s->data.x0;
            const int y = f.data.y0 + (int) i / moved.w - s->data.y0;
            norm2 += v * v;
            if (x >= 0 && x < gp_rect_w(s->data) && y >= 0 &&
                y < gp_rect_h(s->data))
                out[(size_t) c * n + (size_t) (y * gp_rect_w(s->data) + x)] +=
                    v;
        }
    }
    gp_planes_free(&f.layer);
    gp_sources_free(&moved);
    gp_glare_close(&glare);
    return stats.bound * sqrt(norm2);
}

/* Positions on both sides of the frame's edge, two elements at one of them. */
static const struct gp_flare_element ghosts[] = {
    {.shape = GP_FLARE_DISC, .at = 0.0, .size = 0.2},
    {.shape = GP_FLARE_POLYGON, .at = 0.37, .size = 0.4},
    {.shape = GP_FLARE_RING, .at = 1.0, .size = 0.5},
    {.shape = GP_FLARE_STREAK, .at = 1.0, .size = 0.9, .rotation = 20.0},
    {.shape = GP_FLARE_DISC, .at = 1.8, .size = 0.3, .scale = {0.8f, 1, 1.2f}},
    {.shape = GP_FLARE_POLYGON, .at = 2.0, .size = 0.3, .sides = 5},
    {.shape = GP_FLARE_DISC, .at = 2.9, .size = 0.6},
    {.shape = GP_FLARE_RING, .at = -0.7, .size = 0.8},
};

static const struct gp_rect frames[][2] = { // data, display
    {{0, 0, 60, 40}, {0, 0, 60, 40}},
    {{0, 0, 61, 33}, {0, 0, 61, 33}},
    {{-7, 3, 50, 44}, {-20, -4, 61, 39}},
};

static void runs_equal_the_sum_over_sources(void **state)
{
    static const char *const engines[] = {"direct", "fft"};
    struct gp_flare_element e[COUNT(ghosts)];
    for (size_t i = 0; i < COUNT(ghosts); i++)
        e[i] = whole(ghosts[i]);
    const struct gp_flare f = flare_of(e, (int) COUNT(ghosts));
    for (size_t k = 0; k < COUNT(frames); k++) {
        struct sky s;
        struct gp_ghosts g = {0};
        sky_make(&s, frames[k][0], frames[k][1]);
        const size_t n = 3 * (size_t) gp_rect_w(s.data) *
                         (size_t) gp_rect_h(s.data);
        double *const exact = calloc(n, sizeof *exact);
        assert_non_null(exact);
        add_reference(&s, &f, exact);
        assert_ok(gp_ghosts_make(&kept_log, &f, s.data, s.display, &g));
        assert_int_equal(g.n, COUNT(ghosts) - 1); // two share a position
        for (size_t m = 0; m < COUNT(engines); m++) {
            double *const got = calloc(n, sizeof *got);
            double bound = 0.0, off = 0.0, norm = 0.0;
            assert_non_null(got);
            for (int i = 0; i < g.n; i++)
                bound += add_run(&s, &g, &g.run[i], engines[m], got);
            for (size_t i = 0; i < n; i++) {
                off += (got[i] - exact[i]) * (got[i] - exact[i]);
                norm += exact[i] * exact[i];
            }
            if (!(sqrt(off) <= 1e-6 * sqrt(norm)) || !(sqrt(off) <= bound))
                fail_msg("frame %zu, %s: off by %g, bound %g", k, engines[m],
                         sqrt(off / norm), bound / sqrt(norm));
            free(got);
        }
        free(exact);
        gp_ghosts_free(&g);
        gp_sources_free(&s.src);
    }
}

/* Elements of one place are one run where their sources flicker alike: by as
 * much, with one seed. */
static void sources_of_a_run_flicker_alike(void **state)
{
    static const struct {
        double flicker[2];
        int seed[2], runs;
    } rows[] = {
        {{0.5, 0.5}, {3, 3}, 1},
        {{0.5, 0.5}, {3, 4}, 2},
        {{0.5, 0.3}, {3, 3}, 2},
        {{0.0, 0.0}, {3, 4}, 1},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_flare_element e[2] = {ELEMENT(.at = 0.5, .size = 0.3),
                                        ELEMENT(.at = 0.5, .size = 0.2)};
        struct gp_ghosts g = {0};
        for (int k = 0; k < 2; k++) {
            e[k].flicker = rows[i].flicker[k];
            e[k].seed = rows[i].seed[k];
        }
        const struct gp_flare f = flare_of(e, 2);
        assert_ok(
            gp_ghosts_make(&kept_log, &f, frames[0][0], frames[0][1], &g));
        assert_int_equal(g.n, rows[i].runs);
        gp_ghosts_free(&g);
    }
}

/* Flux and centroid are those of the sources, scaled about the centre. */
static void sources_keep_flux_and_centroid(void **state)
{
    static const double places[] = {-0.3, 0.0, 0.21, 0.5, 0.93, 1.0, 1.4, 2.0};
    for (size_t k = 0; k < COUNT(frames) * COUNT(places); k++) {
        struct gp_flare_element e = ELEMENT(.at = places[k / COUNT(frames)],
                                            .size = 9.0);
        const struct gp_flare f = flare_of(&e, 1);
        const double scale = 1.0 - e.at;
        struct sky s;
        struct gp_ghosts g = {0};
        struct gp_sources out;
        double want[2] = {0}, got[2] = {0};
        sky_make(&s, frames[k % COUNT(frames)][0],
                 frames[k % COUNT(frames)][1]);
        const double c[2] = {0.5 * (s.display.x0 + s.display.x1),
                             0.5 * (s.display.y0 + s.display.y1)};
        assert_ok(gp_ghosts_make(&kept_log, &f, s.data, s.display, &g));
        assert_ok(gp_ghost_move(&kept_log, &g, g.run, &s.src, &out));
        for (int i = 0; i < 3; i++)
            assert_near(out.flux[i], s.src.flux[i], 1e-5 * s.src.flux[i],
                        "flux", e.at);
        for (int i = 0; i < SOURCES; i++) {
            const double q = (double) s.at[i].rgb[1] / s.src.flux[1];
            want[0] += q * (c[0] + scale * (s.data.x0 + s.at[i].x + 0.5 -
                                            c[0]));
            want[1] += q * (c[1] + scale * (s.data.y0 + s.at[i].y + 0.5 -
                                            c[1]));
        }
        for (int y = 0; y < out.h; y++) {
            for (uint32_t i = out.row[y]; i < out.row[y + 1]; i++) {
                const double q = (double) out.rgb[1][i] / out.flux[1];
                got[0] += q * (out.x0 + out.x[i] + 0.5);
                got[1] += q * (out.y0 + y + 0.5);
            }
        }
        for (int a = 0; a < 2; a++) // the grid's own part of a pixel
            got[a] += c[a] + scale * (floor(c[a]) + 0.5 - c[a]) - 0.5 -
                      floor(c[a] + scale * (floor(c[a]) + 0.5 - c[a]));
        assert_near(got[0], want[0], 1e-4, "x", e.at);
        assert_near(got[1], want[1], 1e-4, "y", e.at);
        gp_sources_free(&out);
        gp_ghosts_free(&g);
        gp_sources_free(&s.src);
    }
}

/* Draws an element of bright pixels for the i-th source alone, at its own
 * place, as one of a light. */
static struct picture draw_alone(const struct gp_flare_element *e,
                                 const struct sky *s, int i,
                                 struct gp_rect frame)
{
    const double x = 0.5 * frame.x1, y = 0.5 * frame.y1;
    struct gp_flare_element one = *e;
    struct gp_light l = lamp_at(x + (1.0 - e->at) * (s->at[i].x + 0.5 - x),
                                y + (1.0 - e->at) * (s->at[i].y + 0.5 - y));
    struct picture p = picture_make(frame, frame);
    one.at = 0.0;
    one.source = GP_FLARE_LIGHTS;
    memcpy(l.flux, s->at[i].rgb, sizeof l.flux);
    add_one(&p, one, l);
    return p;
}

/* A run states the norm of what splitting does to hard edges and thin rays; at
 * whole scales that is nothing. */
static void runs_state_the_error_of_splits(void **state)
{
    enum { W = 160, H = 100, N = W * H };
    static const struct gp_flare_element hard[] = {
        {.shape = GP_FLARE_DISC, .at = 0.37, .size = 0.5},
        {.shape = GP_FLARE_POLYGON, .at = 1.63, .size = 0.3, .rotation = 11.0},
        {.shape = GP_FLARE_RING, .at = 0.37, .size = 0.4},
        {.shape = GP_FLARE_SPIKES, .at = 0.37, .size = 0.6, .width = 0.01,
         .count = 8},
        {.shape = GP_FLARE_RING, .at = 2.0, .size = 0.4},
    };
    const struct gp_rect frame = {0, 0, W, H};
    for (size_t k = 0; k < COUNT(hard); k++) {
        struct gp_flare_element e = whole(hard[k]);
        const struct gp_flare f = flare_of(&e, 1);
        double *const got = calloc(3 * N, sizeof *got);
        double *const exact = calloc(3 * N, sizeof *exact);
        double off = 0.0, norm = 0.0;
        struct gp_ghosts g = {0};
        struct sky s;
        assert_non_null(got);
        assert_non_null(exact);
        sky_make(&s, frame, frame);
        assert_ok(gp_ghosts_make(&kept_log, &f, frame, frame, &g));
        add_run(&s, &g, g.run, "direct", got);
        for (int i = 0; i < SOURCES; i++) {
            struct picture p = draw_alone(&e, &s, i, frame);
            for (size_t j = 0; j < 3 * N; j++)
                exact[j] += (double) p.layer.c[j / N][j % N];
            picture_free(&p);
        }
        for (size_t j = 0; j < 3 * N; j++) {
            off += (got[j] - exact[j]) * (got[j] - exact[j]);
            norm += got[j] * got[j];
        }
        off = sqrt(off / norm);
        if (e.at == 2.0)
            assert_true(g.run->split == 0.0 && off < 1e-6);
        else if (!(off <= g.run->split && g.run->split < 8.0 * off))
            fail_msg("element %zu: off by %g, stated %g", k, off,
                     g.run->split);
        free(got);
        free(exact);
        gp_ghosts_free(&g);
        gp_sources_free(&s.src);
    }
}

/* Sources beyond the frame stay while the element reaches in, and only then. */
static void far_sources_are_cut(void **state)
{
    const struct gp_rect r = {0, 0, 64, 48};
    struct gp_flare_element e[2] = {ELEMENT(.at = -4.0, .size = 0.02),
                                    ELEMENT(.at = -4.0, .size = 9.0)};
    size_t n[2];
    for (int k = 0; k < 2; k++) {
        const struct gp_flare f = flare_of(&e[k], 1);
        struct sky s;
        struct gp_ghosts g = {0};
        struct gp_sources out;
        sky_make(&s, r, r);
        assert_ok(gp_ghosts_make(&kept_log, &f, r, r, &g));
        assert_ok(gp_ghost_move(&kept_log, &g, g.run, &s.src, &out));
        n[k] = out.n;
        assert_true(k == 1 || out.w < 64 + 8);
        gp_sources_free(&out);
        gp_ghosts_free(&g);
        gp_sources_free(&s.src);
    }
    assert_true(n[0] < n[1]);
    assert_int_equal(n[1], SOURCES);
}

static void refuses_huge_images(void **state)
{
    const struct gp_rect r = {0, 0, 16384, 16384};
    struct gp_flare_element e = ELEMENT(.at = -10.0, .size = 10.0);
    const struct gp_flare f = flare_of(&e, 1);
    struct gp_ghosts g = {0};
    assert_int_equal(gp_ghosts_make(&kept_log, &f, r, r, &g), GP_ERR_DATA);
    assert_kept("f.json: element 1");
    assert_null(g.run);
}

SUITE_OF(ghosts, NULL, NULL, runs_equal_the_sum_over_sources,
         sources_of_a_run_flicker_alike, sources_keep_flux_and_centroid,
         runs_state_the_error_of_splits, far_sources_are_cut,
         refuses_huge_images)
