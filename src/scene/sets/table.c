// SPDX-License-Identifier: Apache-2.0
#include "scene/sets/sets_priv.h"

#include "core/clock.h"
#include "core/maths.h"
#include "core/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[GP_TABLE_ROWS] = {
    "frustum", "+ occlusion", "+ lights", "+ shadows", "+ scissor",
};

/* The scene, its sets and its pictures, for all rows. */
struct rows {
    const struct gp_log *log;
    const struct gp_gl *gl;
    const struct gp_scene *s;
    const struct glarepp_sets_params *p;
    struct gp_drawing *d;
    struct gp_sets_view view;
    struct gp_box all;  // of F in every row: suns lay their maps over it
    int *order;         // objects, those that look largest first
    int *list, *caster; // room for all objects; of the same block
    struct gp_rect *cut; // ... of their pixels
    float *depth;
    struct gp_table *out;
};

struct look {
    double size;
    int object;
};

static int larger_first(const void *a, const void *b)
{
    const struct look *const x = a, *const y = b;
    if (x->size != y->size)
        return x->size < y->size ? 1 : -1;
    return x->object - y->object;
}

/* Sorts all objects: the same order in every row, as surfaces at one depth show
 * the one that was drawn last. */
static gp_status set_order(struct rows *w)
{
    const struct gp_v3 eye = gp_camera_eye(&w->view.camera);
    const int n = w->s->objects;
    struct look *look = NULL;
    gp_status st = gp_alloc(w->log, "order of objects", (size_t) n + 1,
                            sizeof *look, &look);
    if (st)
        return st;
    for (int i = 0; i < n; i++) {
        const struct gp_object *const o = &w->s->object[i];
        const struct gp_v3 c = {fmin(fmax(eye.x, o->box.lo.x), o->box.hi.x),
                                fmin(fmax(eye.y, o->box.lo.y), o->box.hi.y),
                                fmin(fmax(eye.z, o->box.lo.z), o->box.hi.z)};
        const double far = gp_v3_length(gp_v3_sub(c, eye));
        look[i] = (struct look) {o->radius / fmax(far, w->view.near), i};
    }
    qsort(look, (size_t) n, sizeof *look, larger_first);
    for (int i = 0; i < n; i++)
        w->order[i] = look[i].object;
    gp_free(look);
    return GP_OK;
}

/* Returns the widest angle between a lookup in a map and its ray: across the
 * square of four texels; of a sun the width of that. */
static double texel_of(const struct rows *w)
{
    const double across = 2.0 * sqrt(2.0) / (w->p->map - 2) * 1.05;
    double widest = across; // of a cube's square
    for (int i = 0; i < w->s->lights; i++) {
        const struct gp_scene_light *const l = &w->s->light[i];
        const double is =
            l->kind == GP_LIGHT_DIRECTIONAL ? gp_v3_length(gp_box_half(&w->all))
            : l->kind == GP_LIGHT_SPOT && l->outer < 1.05 ? gp_tan(l->outer)
                                                          : 1.0;
        widest = gp_maxd(widest, across * is);
    }
    return widest;
}

/* Lists the objects of a set, in w->order[from] to w->order[to - 1]. */
static int list_set(const struct rows *w, const struct gp_sets *sets,
                    unsigned set, int from, int to, int *list)
{
    const uint8_t *const flag = gp_sets_flags(sets);
    int n = 0;
    for (int i = from; i < to; i++) {
        list[n] = w->order[i];
        n += (flag[w->order[i]] & set) != 0;
    }
    return n;
}

/* Draws the ambient pass of V, and leaves the sets of the frame in *sets. */
static gp_status draw_visible(struct rows *w, unsigned use,
                              struct gp_sets **sets)
{
    const int n = w->s->objects;
    const bool by_depth = use & GP_SETS_OCCLUSION;
    gp_status st;
    GP_TRY(gp_sets_open(w->log, w->s, &w->view, use, sets));
    int first = n, drawn = 0;
    if (by_depth) { // those of F that look largest
        for (first = 0; first < n && drawn < w->p->occluders; first++)
            drawn += list_set(w, *sets, GP_SET_F, first, first + 1, w->list);
    }
    drawn = list_set(w, *sets, GP_SET_F, 0, first, w->list);
    GP_TRY(gp_drawing_ambient(w->d, w->list, drawn));
    if (!by_depth)
        return GP_OK;
    for (int pass = 0; pass < 2; pass++) {
        gp_drawing_depth(w->d, w->depth);
        GP_TRY(gp_sets_look(w->log, *sets, w->depth));
        if (pass == 0) {
            drawn = list_set(w, *sets, GP_SET_V, first, n, w->list);
            GP_TRY(gp_drawing_ambient(w->d, w->list, drawn));
        }
    }
out:
    return st;
}

/* Draws a light with its sets, which are added to the row and to the table. */
static gp_status draw_light(struct rows *w, struct gp_sets *sets, int light,
                            bool last, struct glarepp_sets_row *row)
{
    const int n = w->s->objects;
    const struct gp_scissor cut = gp_sets_light(sets, light);
    if (last)
        w->out->light[light] = cut;
    if (gp_rect_empty(cut.rect))
        return GP_OK;
    const int lits = list_set(w, sets, GP_SET_I, 0, n, w->list);
    for (int i = 0; i < lits && last; i++)
        w->cut[i] = gp_sets_scissor_of(sets, w->list[i]);
    const struct gp_draw_light l = {
        .light = &w->s->light[light],
        .shadow = w->caster,
        .lit = w->list,
        .shadows = list_set(w, sets, GP_SET_S, 0, n, w->caster),
        .lits = lits,
        .own = last ? w->cut : NULL,
        .cut = cut.rect,
        .all = w->all};
    row->lit += l.lits;
    row->casters += l.shadows;
    row->separate_batches += gp_sets_batches(sets, GP_SET_I) +
                    gp_sets_batches(sets, GP_SET_S);
    const uint8_t *const flag = gp_sets_flags(sets);
    for (int i = 0; i < n && last; i++)
        w->out->set[i] |= flag[i];
    return gp_drawing_light(w->d, &l);
}

static gp_status draw_row(struct rows *w, int kind,
                          struct glarepp_sets_row *row)
{
    const unsigned use = (1u << kind) - 1u; // a part more than the row before
    struct gp_sets *sets = NULL;
    gp_status st;
    *row = (struct glarepp_sets_row) {.name = names[kind], .fragments = -1};
    gp_drawing_clear(w->d, row);
    GP_TRY(draw_visible(w, use, &sets));
    row->visible = list_set(w, sets, GP_SET_V, 0, w->s->objects, w->list);
    row->separate_batches = gp_sets_batches(sets, GP_SET_V);
    for (int i = 0; i < w->s->lights; i++)
        GP_TRY(draw_light(w, sets, i, kind == GP_TABLE_ROWS - 1, row));
out:
    gp_sets_close(&sets);
    return st;
}

/* Draws all rows: once to count and to compare them, with room for a picture, then
 * for their time. Each run begins with another row, so that what else the machine
 * does falls on all of them. */
static gp_status draw_rows(struct rows *w, float *other)
{
    const size_t bytes =
        4 * sizeof *other * (size_t) w->p->w * (size_t) w->p->h;
    gp_status st = GP_OK;
    for (int i = 0; i < GP_TABLE_ROWS * (1 + w->p->runs) && !st; i++) {
        const int run = i / GP_TABLE_ROWS, kind = (i + run) % GP_TABLE_ROWS;
        struct glarepp_sets_row drawn, *const row = &w->out->row[kind];
        float *const picture = kind ? other : w->out->picture;
        if (run == 0)
            gp_count_begin(w->gl);
        const double start = gp_now_ms(), cpu = gp_cpu_ms();
        st = draw_row(w, kind, &drawn);
        if (run > 0) {
            gp_drawing_wait(w->d);
            row->ms = fmin(row->ms, gp_now_ms() - start);
            row->cpu_ms = fmin(row->cpu_ms, gp_cpu_ms() - cpu);
            continue;
        }
        *row = drawn;
        row->fragments = gp_count_end(w->gl);
        gp_drawing_picture(w->d, picture);
        row->same = memcmp(w->out->picture, picture, bytes) == 0;
        row->ms = row->cpu_ms = INFINITY;
    }
    return st;
}

gp_status gp_table_make(const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_scene *s, const struct gp_camera *c,
    const struct glarepp_sets_params *p, struct gp_table *out)
{
    const size_t objects = (size_t) s->objects + 1;
    const size_t pixels = (size_t) p->w * (size_t) p->h;
    struct gp_table t = {0};
    struct rows w = {
        .log = log, .gl = gl, .s = s, .p = p, .all = GP_BOX_EMPTY, .out = &t};
    struct gp_sets *sets = NULL;
    float *other = NULL;
    gp_status st;
    w.view = (struct gp_sets_view) {
        .camera = *c, .display = {0, 0, p->w, p->h},
        .window = {0, 0, p->w, p->h}, .near = p->near,
    };
    GP_TRY(gp_alloc(log, "objects", objects, 3 * sizeof(int), &w.order));
    w.list = w.order + objects;
    w.caster = w.list + objects;
    GP_TRY(gp_alloc(log, "objects", objects, sizeof *w.cut, &w.cut));
    GP_TRY(gp_alloc(log, "depth", pixels, sizeof *w.depth, &w.depth));
    GP_TRY(gp_alloc(log, "picture", pixels, 4 * sizeof *other, &other));
    GP_TRY(gp_alloc(log, "picture", pixels, 4 * sizeof *other, &t.picture));
    GP_TRY(gp_alloc_zero(log, "lights", (size_t) s->lights + 1, sizeof *t.light,
                         &t.light));
    GP_TRY(gp_alloc_zero(log, "sets", objects, 1, &t.set));
    GP_TRY(gp_sets_open(log, s, &w.view, 0, &sets));
    for (int i = 0; i < s->objects; i++) {
        if (gp_sets_flags(sets)[i] & GP_SET_F)
            w.all = gp_box_join(w.all, s->object[i].box);
    }
    w.view.texel = texel_of(&w);
    GP_TRY(set_order(&w));
    GP_TRY(gp_drawing_open(log, gl, s, c, p, &w.d));
    GP_TRY(draw_rows(&w, other));
    GP_TRY(gp_gl_check(log, gl, "drawing the scene"));
    *out = t;
    t = (struct gp_table) {0};
out:
    gp_sets_close(&sets);
    gp_drawing_close(&w.d);
    gp_table_free(&t);
    gp_free(other);
    gp_free(w.depth);
    gp_free(w.cut);
    gp_free(w.order);
    return st;
}

void gp_table_free(struct gp_table *t)
{
    gp_free(t->picture);
    gp_free(t->light);
    gp_free(t->set);
    *t = (struct gp_table) {0};
}

// -- pictures -----------------------------------------------------------------

/* A picture that lines are drawn into. */
struct sheet {
    int w, h;
    const struct gp_planes *rgb;
};

static void set_pixel(const struct sheet *s, int x, int y, const float *colour)
{
    if (x < 0 || y < 0 || x >= s->w || y >= s->h)
        return;
    for (int c = 0; c < 3; c++)
        s->rgb->c[c][(size_t) y * (size_t) s->w + (size_t) x] = colour[c];
}

static void draw_outline(const struct sheet *s, struct gp_rect r,
                         const float *colour)
{
    if (gp_rect_empty(r))
        return;
    for (int x = gp_max(r.x0, 0); x < gp_min(r.x1, s->w); x++) {
        set_pixel(s, x, r.y0, colour);
        set_pixel(s, x, r.y1 - 1, colour);
    }
    for (int y = gp_max(r.y0, 0); y < gp_min(r.y1, s->h); y++) {
        set_pixel(s, r.x0, y, colour);
        set_pixel(s, r.x1 - 1, y, colour);
    }
}

void gp_sets_draw_scissors(const struct gp_table *t, int lights, int w, int h,
                           const struct gp_planes *rgb)
{
    const struct sheet sheet = {w, h, rgb};
    for (size_t i = 0; i < (size_t) w * (size_t) h; i++) {
        for (int c = 0; c < 3; c++) {
            const float v = t->picture[4 * i + (size_t) c];
            rgb->c[c][i] = v / (1.0f + v); // Reinhard et al. 2002, eq. 3
        }
    }
    for (int i = 0; i < lights; i++) {
        float colour[3]; // six hues, then paler ones
        for (int c = 0; c < 3; c++)
            colour[c] = (i % 6 + 1) >> c & 1 ? 1.0f : i < 6 ? 0.0f : 0.3f;
        struct gp_rect r = t->light[i].rect;
        for (int k = 0; k < i; k++) { // equal ones one inside the other
            const struct gp_rect *const q = &t->light[k].rect;
            if (memcmp(q, &t->light[i].rect, sizeof *q) == 0)
                r = (struct gp_rect) {r.x0 + 1, r.y0 + 1, r.x1 - 1, r.y1 - 1};
        }
        draw_outline(&sheet, r, colour);
    }
}

/* Colours of objects, each over those before it. */
static const struct {
    unsigned set;
    float colour[3];
} colours[] = {
    {0, {0.03f, 0.03f, 0.03f}},      // in none
    {GP_SET_F, {0.0f, 0.05f, 0.5f}}, // in the frustum, hidden
    {GP_SET_S, {0.7f, 0.0f, 0.0f}},  // casts shadows
    {GP_SET_V, {0.0f, 0.4f, 0.05f}}, // visible
    {GP_SET_I, {0.9f, 0.7f, 0.0f}},  // visible and lit
};

// -- the map of sets -------------------------------------------------------------------

/* Finds the part of the world that the map shows: the eye, the lamps and the
 * middles of objects, and of their boxes what is within a quarter of that
 * beside it, so that a large ground does not make all others small. */
static struct gp_box find_extent(const struct gp_scene *s, struct gp_v3 eye)
{
    struct gp_box core = {eye, eye};
    for (int i = 0; i < s->objects; i++)
        core = gp_box_with(core, gp_box_middle(&s->object[i].box));
    for (int i = 0; i < s->lights; i++) {
        if (s->light[i].kind != GP_LIGHT_DIRECTIONAL)
            core = gp_box_with(core, s->light[i].at);
    }
    const double side =
        0.25 * fmax(core.hi.x - core.lo.x, core.hi.z - core.lo.z);
    // else all is in one place with the eye
    const double more = side > 0.0 ? side : INFINITY;
    struct gp_box all = core;
    for (int i = 0; i < s->objects; i++) {
        struct gp_box b = s->object[i].box;
        b.lo.x = fmax(b.lo.x, core.lo.x - more);
        b.lo.z = fmax(b.lo.z, core.lo.z - more);
        b.hi.x = fmin(b.hi.x, core.hi.x + more);
        b.hi.z = fmin(b.hi.z, core.hi.z + more);
        if (!gp_box_empty(b))
            all = gp_box_join(all, b);
    }
    return all;
}

/* Returns a coordinate of the map as a pixel, at most one outside. */
static int pixel_of(double at, int size)
{
    return gp_clamp_whole(floor(at), -1, size);
}

void gp_sets_draw_map(const struct gp_table *t, const struct gp_scene *s,
                      const struct gp_camera *c, int w, int h,
                      const struct gp_planes *rgb)
{
    static const float white[3] = {1.0f, 1.0f, 1.0f}, eye_colour[3] = {0, 1, 1};
    const struct sheet sheet = {w, h, rgb};
    const struct gp_v3 eye = gp_camera_eye(c);
    const struct gp_box all = find_extent(s, eye);
    for (int i = 0; i < 3; i++)
        memset(rgb->c[i], 0, (size_t) w * (size_t) h * sizeof(float));
    // glTF's y is up: x to the right, z down
    const double wide = fmax(all.hi.x - all.lo.x, 1e-9);
    const double deep = fmax(all.hi.z - all.lo.z, 1e-9);
    const double scale = 0.96 * fmin(w / wide, h / deep);
    const double x0 = 0.5 * (w - scale * wide) - scale * all.lo.x;
    const double y0 = 0.5 * (h - scale * deep) - scale * all.lo.z;
    for (size_t k = 0; k < sizeof colours / sizeof *colours; k++) {
        for (int i = 0; i < s->objects; i++) {
            const struct gp_box *const b = &s->object[i].box;
            if ((t->set[i] & colours[k].set) != colours[k].set)
                continue;
            // a box that leaves the map ends at its edge
            draw_outline(
                &sheet,
                gp_rect_meet(
                    (struct gp_rect) {0, 0, w, h},
                    (struct gp_rect) {pixel_of(x0 + scale * b->lo.x, w),
                                      pixel_of(y0 + scale * b->lo.z, h),
                                      pixel_of(x0 + scale * b->hi.x, w) + 1,
                                      pixel_of(y0 + scale * b->hi.z, h) + 1}),
                colours[k].colour);
        }
    }
    for (int i = 0; i <= s->lights; i++) {
        const bool is_eye = i == s->lights;
        const struct gp_v3 p = is_eye ? eye : s->light[i].at;
        const int x = pixel_of(x0 + scale * p.x, w);
        const int y = pixel_of(y0 + scale * p.z, h);
        if (x < 0 || y < 0 || x >= w || y >= h ||
            (!is_eye && s->light[i].kind == GP_LIGHT_DIRECTIONAL))
            continue;
        for (int k = -2; k <= 2; k++) {
            set_pixel(&sheet, x + k, y, is_eye ? eye_colour : white);
            set_pixel(&sheet, x, y + k, is_eye ? eye_colour : white);
        }
    }
}
