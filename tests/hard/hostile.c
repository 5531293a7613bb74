// SPDX-License-Identifier: Apache-2.0
/* Scenes in memory that are hostile, through every engine of scenes: sets,
 * rays, shares by rays, the paper's renderer and relit frames;
 * against plain rays through every triangle. */
#include "hardcases.h"

#include "core/parallel.h"
#include "gl/gl.h"
#include "scene/eye.h"
#include "scene/relight.h"
#include "scene/sets/sets_priv.h"
#include "scene_shot.h"

enum { W = 44, H = 30, PIXELS = W * H };
enum { LIGHTS = 6 }; // of a scene, whose shares and light are looked at

/* A scene seen from `eye` in the direction of y. */
struct seen {
    struct gp_scene s;
    struct gp_v3 eye;
    struct gp_meshes meshes;
    struct shot shot;
};

// -- the cases ----------------------------------------------------------------

/* Index of a mesh of made_random_scene(). */
enum { MESH_BOX = 0 };

static const struct gp_v3 somewhere = {1, 2, 3}, unit_size = {1, 1, 1};

static void keep(struct seen *k)
{
    (void) k;
}

static void shrink(struct seen *k)
{
    for (int i = 1; i < 8; i++)
        made_move(&k->s, i, somewhere, i % 2 ? 0.0 : 1e-30);
}

static void swell(struct seen *k)
{
    made_move(&k->s, 1, somewhere, 1e9);
    made_move(&k->s, 2, somewhere, 1e6);
}

/* A surface 1e9 away counts as none: those before the eye are nearer. */
static void send_away(struct seen *k)
{
    for (int i = 1; i < 9; i++)
        made_move(&k->s, i, (struct gp_v3) {i % 3 * 1e8, i % 2 ? -1e9 : 7e8,
                                            i * 1e8},
                  i < 5 ? 1.0 : 1e7);
}

static void box_the_eye(struct seen *k)
{
    made_put(&k->s, MESH_BOX, k->eye, unit_size, 20.0);
}

static void box_the_lights(struct seen *k)
{
    for (int i = 0; i < k->s.lights; i++)
        made_put(&k->s, MESH_BOX, k->s.light[i].at, unit_size, 20.0);
}

static void put_lights_on_surfaces(struct seen *k)
{
    for (int i = 0; i < k->s.lights; i++)
        k->s.light[i].at.z = 1e-9 * i;
}

static void put_a_light_at_the_eye(struct seen *k)
{
    made_point(&k->s, k->eye, 100.0, INFINITY);
    made_spot(&k->s, k->eye, (struct gp_v3) {0, 1, -0.2}, 100.0, 40.0, 5.0,
              30.0);
}

static void reach_far_and_near(struct seen *k)
{
    k->s.light[0].range = 1e30;
    k->s.light[1].range = 1e-30;
    made_point(&k->s, (struct gp_v3) {0, 0, 1e9}, 1e12, 1e15);
}

/* The most that the reader takes. */
static void light_brightly(struct seen *k)
{
    for (int i = 0; i < k->s.lights; i++) {
        k->s.light[i].intensity = 1e12;
        for (int c = 0; c < 3; c++)
            k->s.light[i].color[c] = c ? 1e6 : 0.0;
    }
}

static void narrow_and_widen_spots(struct seen *k)
{
    const struct gp_v3 at = {2, -3, 8}, down = {0.1, 0.2, -1};
    made_spot(&k->s, at, down, 100.0, 40.0, 0.0, 1e-9);
    made_spot(&k->s, at, down, 100.0, 40.0, 0.0, 90.0);
    made_spot(&k->s, at, down, 100.0, 40.0, 89.999999, 90.0);
}

static void double_objects(struct seen *k)
{
    for (int i = 0; i < 12; i++) {
        double m[16];
        memcpy(m, k->s.object[i].to_world, sizeof m);
        made_place(&k->s, k->s.object[i].mesh, m);
    }
}

static void add_lights_off_screen(struct seen *k)
{
    static const struct gp_box behind = {{-300, -400, 0}, {300, -60, 90}};
    uint64_t seed = 7;
    for (int i = 0; i < 3000; i++)
        made_point(&k->s, made_within(&seed, behind), 100.0,
                   i % 500 ? 5.0 : 200.0);
}

static void take_objects_away(struct seen *k)
{
    k->s.objects = 0;
}

static void take_lights_away(struct seen *k)
{
    k->s.lights = 0;
}

/* All of it 1e6 away from the origin. */
static void go_far(struct seen *k)
{
    const struct gp_v3 way = {1e6, -1e6, 1e5};
    for (int i = 0; i < k->s.objects; i++) {
        const double *const m = k->s.object[i].to_world;
        const struct gp_v3 at = {m[12], m[13], m[14]};
        made_move(&k->s, i, gp_v3_add(at, way), 1.0);
    }
    for (int i = 0; i < k->s.lights; i++)
        k->s.light[i].at = gp_v3_add(k->s.light[i].at, way);
    k->eye = gp_v3_add(k->eye, way);
}

static const struct hard_made {
    const char *name;
    void (*spoil)(struct seen *k);
} cases[] = {
    {"a scene as they are", keep},
    {"objects of no size", shrink},
    {"objects of 1e9 units", swell},
    {"objects 1e9 behind, 7e8 before the eye", send_away},
    {"the eye in an object", box_the_eye},
    {"lights in closed boxes", box_the_lights},
    {"lights on the ground", put_lights_on_surfaces},
    {"lights at the eye", put_a_light_at_the_eye},
    {"ranges of 1e30 and 1e-30, a light 1e9 away", reach_far_and_near},
    {"lights of 1e18 cd", light_brightly},
    {"spots of 1e-9 and of 90 degrees", narrow_and_widen_spots},
    {"two objects in each place", double_objects},
    {"3000 lights off screen", add_lights_off_screen},
    {"no objects", take_objects_away},
    {"no lights", take_lights_away},
    {"1e6 away from the origin", go_far},
};
enum { CASES = sizeof cases / sizeof *cases };

static void make(const struct hard_made *h, struct seen *k)
{
    uint64_t seed = hash_more(HASH_NONE, h->name, strlen(h->name));
    *k = (struct seen) {.eye = {0, -14, 4}};
    k->s = made_random_scene(&seed, 24, 4);
    // plain rays have no bilinear alpha
    for (int i = 0; i < k->s.materials; i++)
        k->s.material[i].cutoff = 0.0f;
    h->spoil(k);
    const struct gp_v3 at = gp_v3_add(k->eye, (struct gp_v3) {0, 14, -1});
    shot_take(&k->s, made_camera(&k->s, k->eye, at, 60.0, (double) W / H),
              k->eye, W, H, &k->shot);
}

static void drop(struct seen *k)
{
    gp_meshes_free(&k->meshes);
    made_free(&k->s);
}

static void must(gp_status st)
{
    if (st)
        hard_die("a scene", kept_line);
}

// -- sets ---------------------------------------------------------------------

/* Counts objects that a light's sets have lost, by the visible points. */
static int lost_of_light(const struct seen *k, const struct gp_sets *sets,
                         struct gp_scissor cut, int light)
{
    const struct gp_scene_light *const from = &k->s.light[light];
    const uint8_t *const flag = gp_sets_flags(sets);
    int lost = 0;
    for (int i = 0; i < PIXELS; i++) {
        const int o = k->shot.object[i], x = i % W, y = i / W;
        const double z = (double) k->shot.depth[i];
        if (o < 0 || !shot_reaches(from, k->shot.point[i]))
            continue;
        const bool drawn = (flag[o] & GP_SET_I) && x >= cut.rect.x0 &&
                           x < cut.rect.x1 && y >= cut.rect.y0 &&
                           y < cut.rect.y1;
        const int first = shot_blocker(&k->s, from, k->shot.point[i]);
        if (first < 0)
            lost += !drawn || z < cut.near || z > cut.far;
        else if (drawn)
            lost += !(flag[first] & GP_SET_S);
    }
    return lost;
}

static void check_sets(const struct seen *k, double *lost)
{
    struct gp_sets *sets;
    const struct gp_sets_view view = shot_view(&k->shot);
    must(gp_sets_open(&kept_log, &k->s, &view, GP_SETS_ALL, &sets));
    for (int i = 0; i < PIXELS; i++) {
        const int o = k->shot.object[i];
        *lost += o >= 0 && !(gp_sets_flags(sets)[o] & GP_SET_V);
    }
    for (int i = 0; i < k->s.lights; i++)
        *lost += lost_of_light(k, sets, gp_sets_light(sets, i), i);
    gp_sets_close(&sets);
}

// -- rays and shares ----------------------------------------------------------

/* The first hit of each pixel by the trees of rays; at 0: none. */
static void find_hits(struct seen *k, struct gp_rays_hit hit[PIXELS])
{
    struct gp_rays rays = {0};
    int *const every = scene_alloc((size_t) k->s.objects + 1, sizeof *every);
    for (int i = 0; i < k->s.objects; i++)
        every[i] = i;
    must(gp_rays_make(&kept_log, &k->s, &k->meshes, every, k->s.objects,
                      &rays));
    for (int i = 0; i < PIXELS; i++) {
        const struct gp_v3 to = shot_through(&k->shot.camera, k->shot.window,
                                             i % W, i / W);
        const struct gp_v3 from = gp_v3_add(k->eye, gp_v3_scale(to, SHOT_NEAR));
        hit[i].at = 0.0;
        if (gp_rays_first(&rays, from, to, SHOT_FAR, &hit[i]))
            hit[i].at += SHOT_NEAR;
    }
    gp_rays_free(&rays);
    free(every);
}

/* Returns the largest error of a distance, as a part of it. */
static double error_of_hits(const struct seen *k,
                            const struct gp_rays_hit hit[PIXELS])
{
    double worst = 0.0;
    for (int i = 0; i < PIXELS; i++) {
        const double want = k->shot.object[i] < 0
                                ? 0.0
                                : gp_v3_length(gp_v3_sub(k->shot.point[i],
                                                         k->eye)) /
                                      gp_v3_length(shot_through(
                                          &k->shot.camera, k->shot.window,
                                          i % W, i / W));
        if (hit[i].at != want)
            worst = hard_worse(worst, fabs(hit[i].at - want) /
                                          fmax(want, SHOT_NEAR));
    }
    return worst;
}

static struct gp_eye_disc disc_of(const struct seen *k, int light)
{
    const struct gp_scene_light *const l = &k->s.light[light];
    return l->kind == GP_LIGHT_DIRECTIONAL
               ? gp_eye_sun(k->eye, gp_v3_scale(l->along, -1.0), 0.05)
               : gp_eye_lamp(k->eye, l->at, 0.2);
}

/* Returns the share of a disc by plain rays, of which it has SIDE x SIDE. */
static double plain_share(const struct seen *k, const struct gp_eye_disc *d)
{
    enum { SIDE = 32 };
    const struct gp_v3 other = fabs(d->to.z) < 0.9 ? (struct gp_v3) {0, 0, 1}
                                                   : (struct gp_v3) {1, 0, 0};
    const struct gp_v3 across = gp_v3_unit(gp_v3_cross(d->to, other));
    const struct gp_v3 up = gp_v3_cross(across, d->to);
    int all = 0, clear = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double x = (i % SIDE + 0.5) / SIDE * 2.0 - 1.0;
        const double y = (i / SIDE + 0.5) / SIDE * 2.0 - 1.0;
        const double r2 = x * x + y * y, r = sqrt(r2);
        if (r2 > 1.0)
            continue;
        // rings of equal solid angle
        const double c = 1.0 - r2 * (1.0 - cos(d->half)), s = sqrt(1.0 - c * c);
        const struct gp_v3 to = gp_v3_add(
            gp_v3_scale(d->to, c),
            gp_v3_add(gp_v3_scale(across, s * x / r),
                      gp_v3_scale(up, s * y / r)));
        double far = 1e11;
        if (isfinite(d->distance)) {
            const double b = d->distance * gp_v3_dot(to, d->to);
            far = b - sqrt(fmax(b * b - d->distance * d->distance +
                                    d->ball * d->ball, 0.0));
        }
        all++;
        clear += !(far > 0.0) ||
                 ray_scene(&k->s, k->eye, to, 0.0, far).object < 0;
    }
    return (double) clear / all;
}

static struct gp_gl *gl;

/* Adds errors over what the shares' own errors allow. */
static void check_shares(struct seen *k, double *rays)
{
    for (int i = 0; i < k->s.lights && i < LIGHTS; i++) {
        const struct gp_eye_disc d = disc_of(k, i);
        struct gp_eye_share share;
        must(gp_eye_rays(&kept_log, &k->s, &k->meshes, &d, NULL, &share));
        *rays = hard_worse(*rays, fabs(share.clear - plain_share(k, &d)) -
                                      3.0 * share.error);
    }
}

// -- the paper's renderer -----------------------------------------------------

/* Returns how many rows of Table 15-1 have a picture of other bytes, and how
 * many samples are no light. */
static double check_drawing(const struct seen *k)
{
    const struct glarepp_sets_params p = {
        .w = W, .h = H, .near = SHOT_NEAR, .light_scale = 1.0 / 683.0,
        .ambient = 0.02, .map = 64, .runs = 1, .occluders = 40,
    };
    struct gp_table t;
    double wrong = 0.0;
    must(gp_table_make(&kept_log, gl, &k->s, &k->shot.camera, &p, &t));
    for (int i = 0; i < GP_TABLE_ROWS; i++)
        wrong += !t.row[i].same;
    for (int i = 0; i < 4 * PIXELS; i++)
        wrong += !(t.picture[i] >= 0.0f && isfinite(t.picture[i]));
    gp_table_free(&t);
    return wrong;
}

// -- relit frames -------------------------------------------------------------

/* Planes of a frame, and the light of one pass on them. */
struct relit {
    float z[PIXELS], normal[3][PIXELS], albedo[3][PIXELS];
    struct gp_plane plane[7];
    struct gp_planes rgb;
    struct gp_surfaces f;
    int *visible, *caster;
};

static const struct gp_rect frame = {0, 0, W, H};

static void open_relit(const struct seen *k,
                       const struct gp_rays_hit hit[PIXELS], struct relit *r)
{
    for (int i = 0; i < PIXELS; i++) {
        const struct gp_v3 n = hit[i].normal;
        const bool any = hit[i].at > 0.0;
        r->z[i] = k->shot.depth[i];
        r->normal[0][i] = any ? (float) n.x : 0.0f;
        r->normal[1][i] = any ? (float) n.y : 0.0f;
        r->normal[2][i] = any ? (float) n.z : 0.0f;
        for (int c = 0; c < 3; c++)
            r->albedo[c][i] = any ? 0.5f : 0.0f;
    }
    for (int i = 0; i < 7; i++)
        r->plane[i] = (struct gp_plane) {
            .window = frame, .v = i == 0  ? r->z
                                  : i < 4 ? r->normal[i - 1]
                                          : r->albedo[i - 4]};
    must(gp_planes_make(&kept_log, "relit", PIXELS, &r->rgb));
    r->visible = scene_alloc((size_t) k->s.objects + 1, sizeof *r->visible);
    r->caster = scene_alloc((size_t) k->s.objects + 1, sizeof *r->caster);
    r->f = (struct gp_surfaces) {
        .rgb = &r->rgb, .data = frame,
        .camera = k->shot.camera, .display = frame, .z = &r->plane[0],
        .normal = &r->plane[1], .albedo = &r->plane[4], .object = r->visible,
    };
}

static void close_relit(struct relit *r)
{
    gp_planes_free(&r->rgb);
    free(r->visible);
    free(r->caster);
}

/* Adds a light's pass to r->rgb; `flag`: shadows of S, NULL: of all. */
static void add_light(struct seen *k, const uint8_t *flag,
                      struct gp_scissor cut, int light, struct relit *r)
{
    struct glarepp_relit facts;
    struct gp_relight_pass pass = {
        .light = &k->s.light[light], .light_scale = 1.0, .caster = r->caster,
        .cut = cut.rect, .near = cut.near * (1.0 - 1e-6),
        .far = cut.far * (1.0 + 1e-6),
    };
    for (int i = 0; i < k->s.objects; i++) {
        if (!flag || (flag[i] & GP_SET_S))
            r->caster[pass.casters++] = i;
    }
    gp_planes_clear(&r->rgb, 0, PIXELS);
    must(gp_relight(&kept_log, &k->s, &k->meshes, &r->f, &pass, 1, &facts));
}

/* Returns a light on a pixel by the formula; < 0: nothing to compare, as the
 * pixel or one beside it may show an edge or the end of a shadow. */
static double plain_light(const struct seen *k,
                          const struct gp_rays_hit hit[PIXELS],
                          const unsigned char state[PIXELS],
                          const double light[PIXELS], int i)
{
    const int x = i % W, y = i / W;
    if (x == 0 || y == 0 || x == W - 1 || y == H - 1)
        return -1.0;
    for (int n = 0; n < 9; n++) {
        const int at = i + n % 3 - 1 + (n / 3 - 1) * W;
        if (k->shot.object[at] != k->shot.object[i] || state[at] != state[i] ||
            k->shot.object[at] < 0 || !(light[at] > 0.0) ||
            fabs(gp_v3_dot(hit[at].normal, hit[i].normal)) < 1.0 - 1e-9)
            return -1.0;
    }
    return state[i] ? light[i] : 0.0;
}

/* Returns the largest error of a light on the frame, as a part of it where it
 * falls upright. */
static double error_of_light(const struct seen *k, int i,
                             const struct gp_rays_hit hit[PIXELS],
                             const struct relit *r)
{
    const struct gp_scene_light *const l = &k->s.light[i];
    static unsigned char state[PIXELS];
    static double light[PIXELS], upright[PIXELS];
    double worst = 0.0;
    for (int p = 0; p < PIXELS; p++) {
        const struct gp_v3 at = k->shot.point[p];
        const bool sun = l->kind == GP_LIGHT_DIRECTIONAL;
        const struct gp_v3 to = sun ? gp_v3_scale(l->along, -1.0)
                                    : gp_v3_sub(l->at, at);
        const double d = gp_v3_length(to), far = d / l->range;
        const struct gp_v3 view = gp_v3_sub(k->eye, at);
        const double side = gp_v3_dot(hit[p].normal, view) < 0.0 ? -1.0 : 1.0;
        const bool any = k->shot.object[p] >= 0 && shot_reaches(l, at);
        upright[p] = any ? l->intensity * 0.5 / MADE_PI : 0.0;
        if (!sun)
            upright[p] *= fmax(1.0 - far * far * far * far, 0.0) / (d * d) *
                          gp_spot_share(l, gp_v3_scale(to, -1.0 / d));
        light[p] = upright[p] *
                   fmax(side * gp_v3_dot(hit[p].normal, to) / d, 0.0);
        state[p] = light[p] > 0.0 && shot_blocker(&k->s, l, at) < 0;
    }
    for (int p = 0; p < PIXELS; p++) {
        const double want = plain_light(k, hit, state, light, p);
        for (int c = 0; c < 3; c++) {
            const double got = (double) r->rgb.c[c][p];
            const double full = want * l->color[c];
            if (!(got >= 0.0) || !isfinite(got))
                worst = HARD_NO_BAR;
            else if (want >= 0.0 && got != full)
                worst = hard_worse(worst, fabs(got - full) /
                                              (upright[p] * l->color[c]));
        }
    }
    return worst;
}

/* Finds the error of relit frames, how many samples change with all objects in
 * place of the sets V and S, and a hash of all bytes. */
static void check_relit(struct seen *k, const struct gp_rays_hit hit[PIXELS],
                        double *error, double *changed, uint64_t *hash)
{
    static struct relit with, without;
    struct gp_sets *sets;
    const struct gp_sets_view view = shot_view(&k->shot);
    open_relit(k, hit, &with);
    open_relit(k, hit, &without);
    must(gp_sets_open(&kept_log, &k->s, &view, GP_SETS_ALL, &sets));
    for (int i = 0; i < k->s.objects; i++) {
        if (gp_sets_flags(sets)[i] & GP_SET_V)
            with.visible[with.f.objects++] = i;
        without.visible[without.f.objects++] = i;
    }
    *hash = HASH_NONE;
    for (int i = 0; i < k->s.lights; i++) {
        const struct gp_scissor cut = gp_sets_light(sets, i);
        const bool any = !gp_rect_empty(cut.rect);
        gp_planes_clear(&with.rgb, 0, PIXELS);
        if (any) {
            add_light(k, gp_sets_flags(sets), cut, i, &with);
            add_light(k, NULL, cut, i, &without);
            for (int p = 0; p < 3 * PIXELS; p++)
                *changed += with.rgb.c[p / PIXELS][p % PIXELS] !=
                            without.rgb.c[p / PIXELS][p % PIXELS];
            const uint64_t one = hash_layer(&with.rgb, PIXELS);
            *hash = hash_more(*hash, &one, sizeof one);
        }
        if (any || i < LIGHTS)
            *error = hard_worse(*error, error_of_light(k, i, hit, &with));
    }
    gp_sets_close(&sets);
    close_relit(&with);
    close_relit(&without);
}

// -- tables -------------------------------------------------------------------

enum { SETS, HITS, SHARE, DRAW, RELIT, CASTERS, COLUMNS };

static const struct hard_column columns[COLUMNS + 1] = {
    [SETS] = {"sets, lost", 0},
    [HITS] = {"rays, distance", 1e-9},
    [SHARE] = {"share by rays", 0.02},
    [DRAW] = {"draw, rows with other bytes", 0},
    [RELIT] = {"relight, of the upright light", 1e-4},
    [CASTERS] = {"relight without sets, differing", 0},
};

static void run_case(const struct hard_made *h, double error[COLUMNS])
{
    static struct seen k;
    static struct gp_rays_hit hit[PIXELS];
    uint64_t hash;
    memset(error, 0, COLUMNS * sizeof *error);
    make(h, &k);
    check_sets(&k, &error[SETS]);
    find_hits(&k, hit);
    error[HITS] = error_of_hits(&k, hit);
    check_shares(&k, &error[SHARE]);
    if (gl)
        error[DRAW] = check_drawing(&k);
    check_relit(&k, hit, &error[RELIT], &error[CASTERS], &hash);
    drop(&k);
}

/* Finds the bits of a case's shares and of its relit frame. */
static void find_bits(int row, int threads, uint64_t bits[2])
{
    static struct seen k;
    static struct gp_rays_hit hit[PIXELS];
    double none[2] = {0};
    gp_set_threads(threads);
    make(&cases[row], &k);
    bits[0] = HASH_NONE;
    for (int i = 0; i < k.s.lights && i < LIGHTS; i++) {
        const struct gp_eye_disc d = disc_of(&k, i);
        struct gp_eye_share share;
        must(gp_eye_rays(&kept_log, &k.s, &k.meshes, &d, NULL, &share));
        bits[0] = hash_more(bits[0], &share.clear, sizeof share.clear);
    }
    find_hits(&k, hit);
    check_relit(&k, hit, &none[0], &none[1], &bits[1]);
    drop(&k);
    gp_set_threads(0);
}

static int is_picked(int row)
{
    return row % 4 == 0;
}

static void count_differing(int row, int threads, double *differ)
{
    uint64_t one[2], many[2];
    find_bits(row, 1, one);
    find_bits(row, threads, many);
    for (int i = 0; i < 2; i++)
        differ[i] += one[i] != many[i];
}

void hard_scenes(void)
{
    hard_broken();
    if (!hard_quick && gp_gl_open(&kept_log, GP_GL_AUTO, &gl) &&
        !strstr(kept_line, "install the Debian"))
        hard_die("GL", kept_line);
    hard_table("Scenes", "against plain rays through every triangle: objects, "
                         "part of a distance, share over its own "
                         "error, pictures of sets against those without",
               columns);
    for (int row = 0; row < CASES; row++) {
        double error[COLUMNS];
        run_case(&cases[row], error);
        hard_row(cases[row].name);
        for (int i = 0; i < COLUMNS; i++)
            hard_cell_if(gl || i != DRAW, error[i], columns[i].bar);
    }
    hard_table_end();
    static const struct hard_column same[] = {
        {"share by rays", 0}, {"relight", 0}, {NULL, 0}};
    hard_thread_table("Scenes, the same bits",
                      "cases that differ from those of one thread", same, CASES,
                      is_picked, count_differing);
    gp_gl_close(&gl);
}
