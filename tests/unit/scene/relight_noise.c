/* Noise of the lamps' own light in the street's frames; --relight beside it.
 *
 * A renderer's pixel is the mean of a few places: lit parts at the ends of
 * shadows on flat surfaces are multiples of 1/24. On thin things near lamp3,
 * where light falls to a quarter within a pixel, so few places leave an error
 * in the data that is larger than 0.05 of all its light. Rays find the spread
 * of such means: places in a (0,2)-sequence, scrambled anew for each pixel
 * (Owen 1995), as Cycles takes them. Its sequence is a little less even: lit
 * parts at the ends of shadows have the measure of it. */
#include "scene/relight.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "io/plane.h"
#include "kept_log.h"
#include "scene/gltf/gltf.h"
#include "scene_made.h"
#include "unit.h"

#include <unistd.h>

enum { W = 640, H = 360, PLACES = 24, MEANS = 16, DRAWS = 200 };

static const struct gp_rect all = {0, 0, W, H};
static const double BLENDER = 1.0 / 683.0; // radiance a cd

/* A pixel's means over places of its own, light of the red channel. */
struct pixel {
    bool near;           // the lamp's own light is on it or beside it
    float lit[MEANS];
    double least, most;  // of means without shadows
    bool flat;           // all places have one normal
};

static struct gp_scene scene;
static struct gp_meshes meshes;
static struct gp_rays rays;
static struct gp_camera camera;
static const struct gp_scene_light *lamp;
static struct pixel *pixel;
static int *every; // object

static uint32_t hash(uint32_t x)
{
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}

static uint32_t reverse(uint32_t x)
{
    uint32_t r = 0;
    for (int bit = 0; bit < 32; bit++)
        r |= (x >> bit & 1) << (31 - bit);
    return r;
}

/* Scrambles the bits of a fraction, each by those above it (Laine and Karras
 * 2011). */
static double scrambled(uint32_t fraction, uint32_t seed)
{
    uint32_t x = reverse(fraction);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= seed >> 16 | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverse(x) / 4294967296.0;
}

/* Returns the second coordinate of Sobol's (0,2)-sequence; the first is
 * reverse(i). */
static uint32_t second_of(uint32_t i)
{
    uint32_t r = 0;
    for (uint32_t v = 1u << 31; i; i >>= 1, v ^= v >> 1)
        r ^= i & 1 ? v : 0u;
    return r;
}

enum { SHARES = 1024 };
static double place[SHARES + 1]; // by share of Blender's pixel filter

/* Sets the places of shares: the filter is Blackman and Harris's window of four
 * terms, 3 pixels wide. */
static void set_places(void)
{
    for (int i = 0; i <= SHARES; i++) {
        double lo = -0.5, hi = 0.5;
        for (int k = 0; k < 40; k++) {
            const double v = 0.5 * (lo + hi), turn = 2.0 * MADE_PI * (v + 0.5);
            const double sum = v + 0.5 -
                (0.48829 * sin(turn) - 0.07064 * sin(2.0 * turn) +
                 0.01168 / 3.0 * sin(3.0 * turn)) / (2.0 * MADE_PI * 0.35875);
            *(sum < (double) i / SHARES ? &lo : &hi) = v;
        }
        place[i] = 3.0 * lo;
    }
}

static double place_of(double share)
{
    const int i = (int) (share * SHARES); // share < 1
    return place[i] + (share * SHARES - i) * (place[i + 1] - place[i]);
}

/* Returns the lamp's red light at a place of the picture, without shadows; 0
 * where no surface is. *hit and *clear are set where there is light. */
static double light_at(double x, double y, struct gp_rays_hit *hit, bool *clear)
{
    const struct gp_v3 eye = gp_camera_eye(&camera);
    const struct gp_v3 way = gp_camera_ray(&camera, all, x, y);
    hit->normal = (struct gp_v3) {0};
    *clear = false;
    if (!gp_rays_first(&rays, eye, way, INFINITY, hit))
        return 0.0;
    if (gp_v3_dot(hit->normal, way) > 0.0)
        hit->normal = gp_v3_scale(hit->normal, -1.0);
    const struct gp_v3 p = gp_v3_add(eye, gp_v3_scale(way, hit->at));
    const struct gp_v3 to = gp_v3_sub(lamp->at, p);
    const double d2 = gp_v3_dot(to, to), d = sqrt(d2);
    const double far = d2 / (lamp->range * lamp->range);
    const double cosine = fmax(gp_v3_dot(to, hit->normal) / d, 0.0);
    const double light = cosine / d2 * fmax(1.0 - far * far, 0.0) *
                         gp_spot_share(lamp, gp_v3_scale(to, -1.0 / d));
    if (!(light > 0.0))
        return 0.0;
    const struct gp_v3 off =
        gp_v3_add(p, gp_v3_scale(hit->normal, 2e-4 * hit->at));
    *clear = !gp_rays_stopped(&rays, off, gp_v3_sub(lamp->at, off), 1.0);
    return light * lamp->intensity * BLENDER / MADE_PI * lamp->color[0] *
           (double) scene.material[hit->material].base[0];
}

/* Finds the means of a row's pixels. */
static void find_row(void *ctx, int y, int thread)
{
    (void) ctx;
    (void) thread;
    for (int x = 0; x < W; x++) {
        struct pixel *const p = &pixel[y * W + x];
        struct gp_v3 first = {0};
        p->flat = true;
        p->least = INFINITY;
        for (int k = 0; p->near && k < MEANS; k++) {
            const uint32_t seed = hash((uint32_t) (y * W + x) * MEANS +
                                       (uint32_t) k + 1);
            double sum = 0.0, full = 0.0;
            for (uint32_t i = 0; i < PLACES; i++) {
                struct gp_rays_hit hit;
                bool clear;
                const double u = scrambled(reverse(i), seed);
                const double v = scrambled(second_of(i), hash(seed));
                const double light = light_at(x + 0.5 + place_of(u),
                                              y + 0.5 + place_of(v), &hit,
                                              &clear);
                sum += clear ? light / PLACES : 0.0;
                full += light / PLACES;
                first = k == 0 && i == 0 ? hit.normal : first;
                p->flat &= gp_v3_dot(first, hit.normal) > 1.0 - 1e-9;
            }
            p->lit[k] = (float) sum;
            p->least = fmin(p->least, full);
            p->most = fmax(p->most, full);
        }
    }
}

static double mean_of(const struct pixel *p)
{
    double sum = 0.0;
    for (int k = 0; k < MEANS; k++)
        sum += (double) p->lit[k] / MEANS;
    return sum;
}

static double variance_of(const struct pixel *p, double mean)
{
    double sum = 0.0;
    for (int k = 0; k < MEANS; k++)
        sum += ((double) p->lit[k] - mean) * ((double) p->lit[k] - mean);
    return sum / (MEANS - 1);
}

/* Returns the variance of the rendered light over that of the sequence here, by
 * the ends of shadows on flat surfaces; and checks that their lit parts are
 * multiples of 1/24. */
static double measure_renderer(const struct gp_plane *own)
{
    double measured = 0.0, expected = 0.0, off = 0.0;
    int n = 0;
    for (int i = 0; i < W * H; i++) {
        const struct pixel *const p = &pixel[i];
        const double full = 0.5 * (p->least + p->most);
        if (!p->near || !p->flat || !(p->most < 1.002 * p->least))
            continue;
        const double part = (double) own->v[i] / full, mean = mean_of(p) / full;
        if (!(part > 0.02 && part < 0.98 && mean > 0.01 && mean < 0.99))
            continue;
        measured += (part - mean) * (part - mean);
        expected += variance_of(p, mean * full) / (full * full);
        off += fabs(PLACES * part - nearbyint(PLACES * part));
        n++;
    }
    print_message("# %d ends of shadows: %.3f from multiples of 1/24 (0.25 at "
                  "random), variance %.2f of the sequence's\n", n, off / n,
                  measured / expected);
    assert_true(n >= 100);
    assert_true(off / n < 0.125);
    assert_true(measured < 3.0 * expected);
    return measured / expected;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

/* Draws rendered pictures of that many times the variance, and returns rel_l2
 * between them and their mean: of[0] 5 %, of[1] half, of[2] 95 % of them. */
static void draw_noise(double variance, const struct gp_plane *albedo,
                       double of[3])
{
    static double drawn[DRAWS];
    const double more = variance * MEANS / (MEANS - 1.0);
    for (int d = 0; d < DRAWS; d++) {
        double wrong = 0.0, light = 0.0;
        for (int i = 0; i < W * H; i++) {
            const struct pixel *const p = &pixel[i];
            if (!p->near || !(albedo->v[i] > 0.0f))
                continue;
            const uint32_t k = hash((uint32_t) (i * DRAWS + d)) % MEANS;
            const double mean = mean_of(p), off = (double) p->lit[k] - mean;
            wrong += more * off * off;
            light += mean * mean;
        }
        drawn[d] = sqrt(wrong / light);
    }
    qsort(drawn, DRAWS, sizeof *drawn, by_size);
    of[0] = drawn[DRAWS / 20];
    of[1] = drawn[DRAWS / 2];
    of[2] = drawn[DRAWS - DRAWS / 20];
}

static struct gp_plane read_plane(const char *file, int frame,
                                  const char *channel)
{
    static const struct gp_read_params limits = GP_READ_DEFAULTS;
    char path[64];
    struct gp_plane p = {0};
    snprintf(path, sizeof path, "scenes/%s.%d.exr", file, frame);
    assert_ok(gp_read_plane_file(&kept_log, &limits, data_path(path), channel,
                                 strcmp(channel, "Z") == 0, &p));
    assert_true(gp_rect_w(p.window) == W && gp_rect_h(p.window) == H);
    return p;
}

/* Returns rel_l2 of a picture against the lamp's own light. */
static double error_of(const float *lit, const struct gp_plane *albedo,
                       const struct gp_plane *own)
{
    double wrong = 0.0, light = 0.0;
    for (int i = 0; i < W * H; i++) {
        const double want = (double) own->v[i], off = (double) lit[i] - want;
        wrong += albedo->v[i] > 0.0f ? off * off : 0.0;
        light += albedo->v[i] > 0.0f ? want * want : 0.0;
    }
    return sqrt(wrong / light);
}

/* Relights a frame, and returns rel_l2 of its red. */
static double relight(int frame, const struct gp_plane albedo[3],
                      const struct gp_plane *own)
{
    static const char *const normals[] = {"N.X", "N.Y", "N.Z"};
    struct gp_plane z = read_plane("street", frame, "Z"), normal[3];
    const struct gp_surfaces f = {
        .camera = camera, .display = all, .z = &z, .normal = normal,
        .albedo = albedo, .object = every, .objects = scene.objects,
    };
    const struct gp_relight_pass pass = {
        .light = lamp, .light_scale = BLENDER, .caster = every,
        .casters = scene.objects, .cut = all, .far = INFINITY,
    };
    struct gp_planes rgb;
    struct gp_relit facts;
    for (int c = 0; c < 3; c++)
        normal[c] = read_plane("street", frame, normals[c]);
    assert_ok(gp_planes_make(NULL, "picture", W * H, &rgb));
    gp_planes_clear(&rgb, 0, W * H);
    assert_ok(gp_relight(&kept_log, &scene, &meshes, &f, &pass, 1, all, &rgb,
                         &facts));
    const double error = error_of(rgb.c[0], albedo, own);
    gp_planes_free(&rgb);
    gp_plane_free(&z);
    for (int c = 0; c < 3; c++)
        gp_plane_free(&normal[c]);
    return error;
}

/* Marks pixels that the lamp lights, and those beside them. */
static void mark_near(const struct gp_plane *own)
{
    for (int i = 0; i < W * H; i++) {
        const int x = i % W, y = i / W;
        pixel[i] = (struct pixel) {0};
        for (int k = 0; k < 9; k++) {
            const int u = x + k % 3 - 1, v = y + k / 3 - 1;
            pixel[i].near |= u >= 0 && u < W && v >= 0 && v < H &&
                             own->v[v * W + u] > 0.0f;
        }
    }
}

/* Checks a frame of lamp3: in two its error is over 0.05. */
static void check_frame(int frame)
{
    static const char *const names[] = {"albedo.R", "albedo.G", "albedo.B"};
    static float even[W * H];
    struct gp_plane albedo[3], own = read_plane("street_lamps", frame,
                                                "lamp3.R");
    double noise[3];
    for (int c = 0; c < 3; c++)
        albedo[c] = read_plane("street", frame, names[c]);
    gp_scene_pose(&scene, frame / 24.0);
    assert_ok(gp_scene_camera_make(&kept_log, &scene,
                                   gp_scene_find_camera(&scene, NULL),
                                   (double) W / H, &camera));
    assert_ok(gp_rays_make(&kept_log, &scene, &meshes, every, scene.objects,
                           &rays));
    mark_near(&own);
    gp_parallel_do(H, find_row, NULL);
    for (int i = 0; i < W * H; i++)
        even[i] = (float) mean_of(&pixel[i]);
    draw_noise(measure_renderer(&own), albedo, noise);
    const double mean = error_of(even, albedo, &own);
    const double relit = relight(frame, albedo, &own);
    print_message("# %d: noise %.3f (5 to 95 %%: %.3f to %.3f), mean of %d "
                  "places %.3f, --relight %.3f\n", frame, noise[1], noise[0],
                  noise[2], MEANS * PLACES, mean, relit);
    // the data cannot tell the mean from the truth
    assert_true(mean <= noise[2]);
    assert_true(relit <= fmax(0.05, noise[2]));
    gp_rays_free(&rays);
    gp_plane_free(&own);
    for (int c = 0; c < 3; c++)
        gp_plane_free(&albedo[c]);
}

static void errors_of_lamp3_are_noise_of_the_data(void **state)
{
    if (getenv("GLAREPP_TEST_QUICK")) // 10 s of rays
        skip_for("quick");
    if (access(data_path("scenes/street.glb"), R_OK) != 0)
        skip_for(NO_DATA);
    set_places();
    assert_ok(gp_scene_read(&kept_log, data_path("scenes/street.glb"), GP_UP_Z,
                            NULL, &scene));
    assert_non_null(pixel = calloc(W * H, sizeof *pixel));
    assert_non_null(every = calloc((size_t) scene.objects, sizeof *every));
    for (int i = 0; i < scene.objects; i++)
        every[i] = i;
    for (int i = 0; i < scene.lights; i++)
        lamp = strcmp(scene.light[i].name, "lamp3") ? lamp : &scene.light[i];
    assert_non_null(lamp);
    check_frame(1001);
    check_frame(1002);
    free(pixel);
    free(every);
    gp_meshes_free(&meshes);
    gp_scene_free(&scene);
}

SUITE_OF(relight_noise, NULL, NULL, errors_of_lamp3_are_noise_of_the_data)
