/* Every form of drawing groups and clusters against the plain form in double,
 * and against each other.
 *
 *   build/tests/glare splat_form --hash   prints checksums of layers (the tests
 *                                         call it) */
#include "unit.h"
#include "splat_scene.h"
#include "driver_threads.h"
#include "hash.h"

/* -- the forms ------------------------------------------------------------- */

struct form {
    int w, h, x0, y0;
    enum light light;
    int kw, kh, cx, cy;
    enum shape shape;
    int group, cluster;
    float fill, shrink;
    enum gp_group_method method;
};

static const struct form forms[] = {
    {1, 1, 0, 0, EVERY, 9, 7, 4, 3, PEAK, 4, 8, 0.9f, 0, GP_GROUP_CORE},
    {61, 47, 0, 0, MANY, 21, 20, 10, 10, PEAK, 2, 0, 1, 0, GP_GROUP_CENTROID},
    {61, 47, -3, 5, MANY, 21, 20, 10, 10, PEAK, 4, 0, 1, 0, GP_GROUP_CENTROID},
    {61, 47, -3, 5, MANY, 21, 20, 10, 10, HOLES, 4, 0, 1, 0, GP_GROUP_MOMENTS},
    {61, 47, -3, 5, MANY, 41, 36, 20, 18, PEAK, 4, 8, 0.3f, 0, GP_GROUP_CORE},
    {61, 47, -3, 5, MANY, 41, 36, 20, 18, LOBES, 4, 8, 0.3f, 0,
     GP_GROUP_CORE},
    {61, 47, 1, 5, MANY, 41, 36, 20, 18, PEAK, 1, 8, 0.3f, 0, GP_GROUP_CORE},
    {61, 47, 1, 5, MANY, 41, 36, 20, 18, PEAK, 1, 4, 0.3f, 0,
     GP_GROUP_MOMENTS},
    {61, 47, 1, 5, EVERY, 41, 36, 20, 18, PEAK, 8, 16, 0.9f, 0,
     GP_GROUP_MOMENTS},
    {61, 47, 1, 5, EVERY, 41, 36, 20, 18, PEAK, 4, 64, 0.9f, 0,
     GP_GROUP_CORE},
    {61, 67, 0, 0, HOT, 63, 63, 31, 31, PEAK, 4, 8, 0.9f, 1e-2f,
     GP_GROUP_CORE},
    {61, 67, 0, 0, HOT, 63, 63, 31, 31, PEAK, 1, 0, 0.9f, 1e-2f,
     GP_GROUP_CORE},
    {131, 67, 7, 7, MANY, 64, 64, 32, 32, PEAK, 4, 8, 0.2f, 1e-2f,
     GP_GROUP_MOMENTS},
    {131, 67, 7, 7, FEW, 151, 90, 75, 45, PEAK, 4, 8, 0.9f, 1e-3f,
     GP_GROUP_CORE},
    {64, 64, 0, 0, FEW, 13, 11, 0, 10, PEAK, 4, 8, 0.9f, 0, GP_GROUP_CORE},
    {64, 64, 0, 0, FEW, 13, 11, -20, 31, PEAK, 4, 8, 0.9f, 0, GP_GROUP_CORE},
    {64, 64, 0, 0, FEW, 90, 90, 7, 80, PEAK, 8, 0, 0.9f, 0, GP_GROUP_CORE},
    {64, 64, 0, 0, FEW, 13, 13, 70, 6, PEAK, 16, 0, 1, 0, GP_GROUP_MOMENTS},
    {97, 1, 0, 0, FEW, 33, 33, 16, 16, PEAK, 4, 8, 0.9f, 0, GP_GROUP_CORE},
    {64, 80, 0, 0, EVERY, 24, 25, 12, 12, PEAK, 1, 2, 1, 0, GP_GROUP_CORE},
};
enum { FORMS = COUNT(forms) };

struct drawn {
    struct gp_sources src;
    struct gp_kernel k;
    struct gp_planes layer;
    double *want; // the plain form
};

static struct drawn make_drawn(const struct form *f)
{
    seed = 407u + (uint32_t) (f - forms);
    struct drawn d = {.src = make_sources(f->w, f->h, f->light),
                      .k = make_kernel(f->kw, f->kh, f->cx, f->cy, f->shape)};
    d.src.x0 = f->x0;
    d.src.y0 = f->y0;
    how = (struct gp_splat_params) {
        .group = f->group, .cluster = f->cluster, .cluster_fill = f->fill,
        .shrink = f->shrink, .method = f->method,
    };
    struct gp_splat_params in_force = how;
    if (f->group == 1 && !f->cluster)
        in_force.method = GP_GROUP_CENTROID;
    struct gp_polygons polygons;
    struct gp_shrink shrink;
    const size_t n = (size_t) f->w * (size_t) f->h;
    d.want = calloc(3 * n, sizeof *d.want);
    if (gp_polygons_make(NULL, &d.src, &in_force, &polygons) ||
        gp_shrink_make(NULL, &d.k, &in_force, &polygons, &shrink) ||
        gp_group_reference(NULL, &d.src, &d.k, &in_force, &polygons, &shrink,
                           d.want))
        abort();
    gp_polygons_free(&polygons);
    return d;
}

static void free_drawn(struct drawn *d)
{
    gp_planes_free(&d->k.k);
    gp_planes_free(&d->layer);
    gp_sources_free(&d->src);
    free(d->want);
    how = (struct gp_splat_params) GP_SPLAT_EXACT;
}

static double off_by(const struct drawn *d)
{
    const size_t n = (size_t) d->src.w * (size_t) d->src.h;
    double wrong = 0.0, all = 0.0;
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++) {
            const double want = d->want[c * n + i];
            wrong += pow((double) d->layer.c[c][i] - want, 2.0);
            all += want * want;
        }
    }
    return all > 0.0 ? sqrt(wrong / all) : wrong > 0.0 ? INFINITY : 0.0;
}

static void check_form(int row, struct drawn *d, enum gp_primitive primitive,
                       void **state)
{
    how.primitive = primitive;
    gp_planes_free(&d->layer);
    const gp_status st = splat(GP_GL_AUTO, &d->src, &d->k, &d->layer, state);
    if (st)
        fail_msg("row %d, primitive %d: %s", row, primitive, said_line);
    const double off = off_by(d), error = rel_l2(&d->src, &d->k, &d->layer);
    if (!(off <= 5e-6))
        fail_msg("row %d, primitive %d: %g off the plain form", row, primitive,
                 off);
    if (!(error <= stats.bound))
        fail_msg("row %d, primitive %d: rel_l2 %g over the bound %g", row,
                 primitive, error, stats.bound);
}

/* One state for all: frames, kernels and groups change under way. */
static void forms_equal_the_plain_form(void **state)
{
    void *kept = open_or_skip(GP_GL_AUTO);
    const int n = getenv("GLAREPP_TEST_QUICK") ? 3 : FORMS;
    for (int i = 0; i < n; i++) {
        struct drawn d = make_drawn(&forms[i]);
        for (int p = 0; p < PRIMITIVES; p++)
            check_form(i, &d, primitives[p], &kept);
        free_drawn(&d);
    }
    gp_engine_splat.close(&kept);
}

/* Tiles and blocks many times smaller than frame and kernel. */
static void small_targets_change_nothing(void **state)
{
    for (int i = 0; i < FORMS; i++) {
        const bool fits = forms[i].kw <= 64 && forms[i].kh <= 64;
        setenv("GLAREPP_GL_MAX_SIZE", fits ? "150" : "200", 1);
        void *kept = open_or_skip(GP_GL_AUTO);
        unsetenv("GLAREPP_GL_MAX_SIZE");
        struct drawn d = make_drawn(&forms[i]);
        check_form(i, &d, GP_PRIMITIVE_QUAD, &kept);
        if (fits && forms[i].cluster < 64)
            check_form(i, &d, GP_PRIMITIVE_POINT, &kept);
        free_drawn(&d);
        gp_engine_splat.close(&kept);
    }
}

static void runs_give_the_same_bytes(void **state)
{
    for (int i = 0; i < FORMS; i++) {
        struct drawn d = make_drawn(&forms[i]);
        for (int p = 0; p < PRIMITIVES; p++) {
            void *one = open_or_skip(GP_GL_AUTO), *two = NULL;
            struct gp_planes a, b;
            how.primitive = primitives[p];
            assert_ok(splat(GP_GL_AUTO, &d.src, &d.k, &a, &one));
            assert_ok(splat(GP_GL_AUTO, &d.src, &d.k, &b, &two));
            for (int c = 0; c < 3; c++)
                assert_memory_equal(a.c[c], b.c[c], (size_t) d.src.w *
                                                        (size_t) d.src.h * 4);
            gp_planes_free(&a);
            gp_planes_free(&b);
            gp_engine_splat.close(&one);
            gp_engine_splat.close(&two);
        }
        free_drawn(&d);
        i += 4; // every fifth: contexts cost time
    }
}

/* -- rotation -------------------------------------------------------------- */

static struct gp_kernel make_turned(int w, int h, enum shape shape,
                                    float degrees)
{
    struct gp_kernel flat = make_kernel(w, h, w / 2, h / 2, shape), k;
    struct gp_frame image = {.data = {0, 0, w, h},
                             .luminance = {0.2126f, 0.7152f, 0.0722f},
                             .rgb = flat.k};
    struct gp_kernel_params p = GP_KERNEL_DEFAULTS;
    p.rotate = degrees;
    if (gp_kernel_from_frame(NULL, &p, &image, &k))
        abort();
    gp_planes_free(&flat.k);
    return k;
}

/* Quads that turn with the unturned kernel give what the turned kernel gives
 * as a plain sum, and what the other forms draw from it. */
static void quads_turn_as_the_kernel_does(void **state)
{
    static const struct {
        int w, h, kw, kh;
        enum light light;
        enum shape shape;
        float degrees, shrink;
        bool turns;
    } rows[] = {
        {60, 50, 21, 21, MANY, PEAK, 30.0f, 0, true},
        {60, 50, 21, 16, MANY, HOLES, -77.3f, 0, true},
        {60, 50, 40, 3, CORNERS, BOX, 45.0f, 0, true},
        {131, 67, 201, 180, FEW, PEAK, 200.5f, 0, true},
        {131, 67, 201, 18, HOT, HOLES, 359.99f, 0, true},
        {131, 67, 63, 64, HOT, PEAK, 10.0f, 1e-2f, true},
        {60, 50, 21, 16, MANY, PEAK, 90.0f, 0, false},
        {1, 1, 1, 1, EVERY, PEAK, 33.0f, 0, true},
    };
    void *kept = open_or_skip(GP_GL_AUTO);
    struct gp_splat *const s = kept;
    for (size_t i = 0; i < COUNT(rows); i++) {
        seed = 5u + (uint32_t) i;
        struct gp_kernel k = make_turned(rows[i].kw, rows[i].kh, rows[i].shape,
                                         rows[i].degrees);
        struct gp_sources src = make_sources(rows[i].w, rows[i].h,
                                             rows[i].light);
        struct gp_planes quads, tiles;
        how.shrink = rows[i].shrink;
        how.primitive = GP_PRIMITIVE_QUAD;
        assert_ok(splat(GP_GL_AUTO, &src, &k, &quads, &kept));
        if (rows[i].turns != (s->kernel[GP_SPLAT_TURNED].texture.id != 0))
            fail_msg("row %zu: turned in the shader is not %d", i,
                     rows[i].turns);
        const double error = rel_l2(&src, &k, &quads);
        if (!(error <= 2e-6 + (double) rows[i].shrink && error <= stats.bound))
            fail_msg("row %zu: rel_l2 %g, bound %g", i, error, stats.bound);
        how.primitive = GP_PRIMITIVE_TILE;
        assert_ok(splat(GP_GL_AUTO, &src, &k, &tiles, &kept));
        double most = 0.0; // places of samples may be 2^-23 of a pixel off
        for (int j = 0; j < src.w * src.h; j++)
            most = fmax(most, (double) tiles.c[1][j]);
        for (int j = 0; j < src.w * src.h; j++) {
            const double a = (double) quads.c[1][j];
            const double b = (double) tiles.c[1][j];
            if (!(fabs(a - b) <= 1e-6 * (b + most)))
                fail_msg("row %zu, pixel %d: %g turned, %g tiled", i, j, a, b);
        }
        gp_planes_free(&quads);
        gp_planes_free(&tiles);
        gp_kernel_free(&k);
        gp_sources_free(&src);
    }
    how = (struct gp_splat_params) GP_SPLAT_EXACT;
    gp_engine_splat.close(&kept);
}

/* -- threads --------------------------------------------------------------- */

/* A line with the sums of layers with overlaps, chunks and several fields: the
 * exact one and grouped ones. */
static int print_hash(void)
{
    void *kept = NULL;
    seed = 5u;
    struct gp_sources src = make_sources(1100, 47, MANY);
    struct gp_kernel k = make_kernel(64, 61, 32, 30, PEAK);
    for (int i = 0; i < 2 * PRIMITIVES; i++) {
        struct gp_planes layer;
        how = i < PRIMITIVES ? (struct gp_splat_params) GP_SPLAT_EXACT
                             : (struct gp_splat_params) GP_SPLAT_DEFAULTS;
        how.primitive = primitives[i % PRIMITIVES];
        if (splat(GP_GL_AUTO, &src, &k, &layer, &kept) != GP_OK)
            return 77;
        printf("%016llx ", (unsigned long long) hash_layer(&layer, 1100 * 47));
        gp_planes_free(&layer);
    }
    puts("");
    gp_engine_splat.close(&kept);
    gp_planes_free(&k.k);
    gp_sources_free(&src);
    return 0;
}

static void threads_change_no_byte(void **state)
{
    threads_same_bytes("splat_form");
}

SUITE(splat_form)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forms_equal_the_plain_form),
        cmocka_unit_test(small_targets_change_nothing),
        cmocka_unit_test(runs_give_the_same_bytes),
        cmocka_unit_test(quads_turn_as_the_kernel_does),
        cmocka_unit_test(threads_change_no_byte),
    };
    if (argc > 1 && strcmp(argv[1], "--hash") == 0)
        return print_hash();
    if (getenv("GLAREPP_TEST_QUICK")) // Mesa's compiler crawls in valgrind
        cmocka_set_test_filter("forms_equal*");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
