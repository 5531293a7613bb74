// SPDX-License-Identifier: Apache-2.0
/* Every way to find a sun's visibility over the hard cases: depth alone, a mask
 * alone, both, and every way to count what lies outside the frame; against
 * plain sums over pixels that were told which of them hide the sun. */
#include "hardcases.h"

#include "core/parallel.h"
#include "gl/gl.h"
#include "sun/mask/mask_priv.h"

enum { MODES = 3, PATTERNS = 2 };

static bool covers(const struct gp_light *l, int pattern, double x, double y)
{
    const double dx = x + 0.5 - l->x, dy = y + 0.5 - l->y, r = l->radius;
    return pattern == 0 ? dx * dx + dy * dy <= r * r
                                            : fabs(dx) <= r && fabs(dy) <= r;
}

/* By the count of the pixels whose centres are under it, else the nearest. */
static double plain_count(const struct hard_sky *s, int planes,
                          struct gp_rect frame, int outside, int pattern,
                          const struct gp_light *l)
{
    double shown = 0.0, weight = 0.0;
    const double r = l->radius;
    for (int nearest = 0; nearest < 2 && !(weight > 0.0); nearest++) {
        bool any = false;
        for (double y = floor(l->y - r) - 1.0; y <= l->y + r + 1.0; y += 1.0) {
            for (double x = floor(l->x - r) - 1.0; x <= l->x + r + 1.0;
                 x += 1.0) {
                if (nearest ? x != floor(l->x) || y != floor(l->y)
                            : !covers(l, pattern, x, y))
                    continue;
                any = true;
                const bool in = x >= frame.x0 && x < frame.x1 &&
                                y >= frame.y0 && y < frame.y1;
                if (!in && outside == (int) GLAREPP_IGNORE)
                    continue;
                weight += 1.0;
                shown += in ? hard_plain_show(s, planes, (int) x, (int) y)
                            : outside == (int) GLAREPP_VISIBLE;
            }
        }
        if (any)
            break;
    }
    return weight > 0.0 ? shown / weight : 0.0;
}

// -- one case -----------------------------------------------------------------

enum { EXACT, READBACK, MASK_16, MASK_64, MASK_SHARE, WAYS };

static const struct hard_column columns[WAYS + 1] = {
    {"exact", 1e-12}, {"readback", 1e-6}, {"mask 16", 1e-6},
    {"mask 64", 1e-6}, {"mask 64 to the exact share", 0.03}, {NULL, 0},
};

static struct {
    struct gp_gl *gl;
    struct gp_sun_map map;
} machine;

static void must(gp_status st, const char *what)
{
    if (st)
        hard_die(what, kept_line);
}

static void draw_light(const struct gp_occluders *o,
                       const struct glarepp_light_params *p, int way,
                       struct gp_light *l, const char *what)
{
    l->visibility = -1.0; // must be written
    struct glarepp_light_params own = *p;
    own.method = way == READBACK ? GLAREPP_READBACK : GLAREPP_MASK;
    must(gp_sun_by_gl(&kept_log, machine.gl, o, &own, l, 1, &machine.map),
         what);
}

/* All GL methods of one light, into the largest errors. */
static void try_gl(const struct hard_sky *s, int planes,
                   const struct gp_occluders *o, struct glarepp_light_params p,
                   struct gp_light *l, double share, const char *what,
                   double error[WAYS])
{
    for (int pattern = 0; pattern < PATTERNS; pattern++) {
        p.square = pattern;
        for (int way = READBACK; way <= MASK_64; way++) {
            p.side = way == MASK_64 ? 64 : 16;
            draw_light(o, &p, way, l, what);
            const double want =
                way == READBACK
                    ? plain_count(s, planes, o->frame, (int) p.outside,
                                  pattern, l)
                    : gp_sun_map_reference(o, &p, l, NULL);
            error[way] = hard_worse(error[way], fabs(l->visibility - want));
            if (way == MASK_64 && !p.square)
                error[MASK_SHARE] = hard_worse(error[MASK_SHARE],
                                               fabs(l->visibility - share));
        }
    }
}

static void run_case(const struct hard_case *h, double error[WAYS])
{
    struct hard_sky s = hard_sky_make(h);
    struct gp_light l = hard_light_of(h);
    memset(error, 0, WAYS * sizeof *error);
    for (int planes = 0; planes < PLANES; planes++) {
        struct gp_occluders o = {
            .depth = planes & WITH_DEPTH ? &s.plane[0] : NULL,
            .mask = planes & WITH_MASK ? &s.plane[1] : NULL,
            .type = s.type, .frame = hard_frame_of(h, s.data),
        };
        gp_occluders_count(&o);
        for (int outside = 0; outside < MODES; outside++) {
            const struct glarepp_light_params p = {
                .outside = (enum glarepp_outside) outside,
            };
            const double share =
                hard_plain_share(&s, planes, o.frame, outside, &l);
            l.visibility = -1.0;
            gp_sun_exact(&o, p.outside, &l, 1);
            error[EXACT] = hard_worse(error[EXACT],
                                      fabs(l.visibility - share));
            if (machine.gl)
                try_gl(&s, planes, &o, p, &l, share, h->name, error);
        }
    }
    hard_sky_free(&s);
}

static double exact_share(const struct hard_case *h, const struct hard_sky *s,
                          int threads)
{
    struct gp_light l = hard_light_of(h);
    struct gp_occluders o = {
        .depth = &s->plane[0], .mask = &s->plane[1], .type = s->type,
        .frame = hard_frame_of(h, s->data),
    };
    gp_set_threads(threads);
    gp_occluders_count(&o);
    gp_sun_exact(&o, GLAREPP_HIDDEN, &l, 1);
    gp_set_threads(0);
    return l.visibility;
}

// -- tables -------------------------------------------------------------------

static int is_run(int row)
{
    return hard_is_run(&hard_cases[row]);
}

static void count_differing(int row, int threads, double *differ)
{
    const struct hard_case *const h = &hard_cases[row];
    struct hard_sky s = hard_sky_make(h);
    *differ += exact_share(h, &s, 1) != exact_share(h, &s, threads);
    hard_sky_free(&s);
}

static void open_gl(void)
{
    if (hard_quick)
        return;
    const gp_status st = gp_gl_open(&kept_log, GP_GL_AUTO, &machine.gl);
    if (st && !strstr(kept_line, "install the Debian"))
        hard_die("GL", kept_line);
}

void hard_sun(void)
{
    open_gl();
    hard_table("Suns", "largest error of the share that shows, by depth, mask "
                       "and both, whatever counts outside the frame", columns);
    for (int row = 0; row < HARD_CASES; row++) {
        double error[WAYS];
        if (!hard_is_run(&hard_cases[row]))
            continue;
        run_case(&hard_cases[row], error);
        hard_row(hard_cases[row].name);
        for (int i = 0; i < WAYS; i++)
            hard_cell_if(i == EXACT || machine.gl, error[i], columns[i].bar);
    }
    hard_table_end();
    // GL has its own threads; those of the exact sums are ours
    static const struct hard_column same[] = {{"exact", 0}, {NULL, 0}};
    hard_thread_table("Suns, the same bits",
                      "shares that differ from those of one thread", same,
                      HARD_CASES, is_run, count_differing);
    if (machine.gl)
        gp_sun_map_close(machine.gl, &machine.map);
    gp_gl_close(&machine.gl);
}
