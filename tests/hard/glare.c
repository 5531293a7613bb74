// SPDX-License-Identifier: Apache-2.0
/* Every engine over the hard cases, one after the other through one opened
 * engine, against gp_glare_reference(): with the cases' own kernels, and with
 * those of models over the whole field. */
#include "hardcases.h"

#include "core/parallel.h"

#include "glare/splat/splat_priv.h"

enum { DIRECT, SPLAT, GROUPED, FFT, AUTO, WAYS };

static const struct way {
    const char *name, *engine;
    bool gl;
    struct gp_splat_params splat;
} ways[WAYS] = {
    {"direct", "direct", false, GP_SPLAT_EXACT},
    {"splat, ungrouped", "splat", true, GP_SPLAT_EXACT},
    {"splat, grouped", "splat", true, GP_SPLAT_DEFAULTS},
    {"fft", "fft", false, GP_SPLAT_EXACT},
    {"auto", "auto", false, GP_SPLAT_DEFAULTS},
};

/* Of rel_l2, what auto is told to keep. */
static const double tolerance = 1e-3;

static int no_gl;

/* False where there is no GL for it. */
static bool run_way(int way, struct scene *s, struct gp_glare *g,
                    struct glarepp_layer_facts *stats, const char *what)
{
    const struct way *const w = &ways[way];
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    p.engine = w->engine;
    p.splat = w->splat;
    p.tolerance = (float) tolerance;
    if (w->gl && (hard_quick || no_gl))
        return false;
    if (!s->f.layer.c[0] &&
        gp_planes_make(NULL, "layer", gp_image_pixels(&s->f), &s->f.layer))
        abort();
    for (int c = 0; c < 3; c++) // every sample must be written
        memset(s->f.layer.c[c], 0xff, gp_image_pixels(&s->f) * sizeof(float));
    const gp_status st =
        gp_glare_run(&kept_log, &p, g, &s->src, &s->k, &s->f, stats);
    if (st == GP_ERR_GL && w->gl && strstr(kept_line, "install the Debian")) {
        no_gl = 1;
        return false;
    }
    if (st)
        hard_die(what, kept_line);
    return true;
}

static bool run_alone(int way, struct scene *s, const char *what)
{
    struct gp_glare g = {0};
    struct glarepp_layer_facts stats;
    const bool yes = run_way(way, s, &g, &stats, what);
    gp_glare_close(&g);
    return yes;
}

// -- errors -------------------------------------------------------------------

struct result {
    bool ran;
    double error, bar; // rel_l2; max_abs where nothing is lit
    double own;        // largest error of a pixel over its own value
    bool differs;      // from a layer of an engine opened for it alone
    uint64_t of_one_thread; // its hash; 0: has not run
};

static bool is_dark(const struct scene *s)
{
    for (size_t i = 0; i < 3 * gp_image_pixels(&s->f); i++) {
        if (s->exact[i] != 0.0)
            return false;
    }
    return true;
}

/* The bar of a cell. The engine's bound takes its place where it does not hold,
 * and where the layer has values that GL may lose. */
static double bar_of(const struct hard_case *h, int way, double error,
                     double bound)
{
    const double bar = way == AUTO      ? tolerance
                       : way == GROUPED ? bound
                                        : hard_bar(h, ways[way].engine);
    return error <= bound && !(h->under && ways[way].gl) ? bar : bound;
}

static void judge_layer(const struct hard_case *h, int way,
                        const struct scene *s,
                        const struct glarepp_layer_facts *stats, struct result *r)
{
    struct glarepp_errors e;
    gp_glare_measure(&s->f, &s->f.layer, s->exact, NULL, 1.0f, NULL, &e);
    r->own = scene_own_error(s);
    if (is_dark(s)) {
        r->error = e.max_abs;
        r->bar = 0.0;
    } else {
        r->error = e.rel_l2;
        r->bar = bar_of(h, way, e.rel_l2, stats->bound);
    }
}

/* auto may take another engine after other frames. A context takes a tenth of
 * a second, so every fifth row alone opens one of its own. */
static bool is_compared(int row, int way)
{
    return way != AUTO && (!ways[way].gl || row % 5 == 0);
}

static void run_case(int row, const struct hard_case *h,
                     struct gp_glare kept[WAYS], struct result result[WAYS])
{
    struct scene s = hard_scene(h);
    if (h->has_far && !s.k.far)
        hard_die(h->name, "has a kernel without a tail; make the case wider");
    for (int i = 0; i < WAYS; i++) {
        struct glarepp_layer_facts stats;
        struct result *const r = &result[i];
        r->ran = run_way(i, &s, &kept[i], &stats, h->name);
        if (!r->ran)
            continue;
        judge_layer(h, i, &s, &stats, r);
        const uint64_t hash = scene_hash(&s);
        if (is_compared(row, i) && run_alone(i, &s, h->name))
            r->differs = scene_hash(&s) != hash;
    }
    scene_free(&s);
}

// -- tables -------------------------------------------------------------------

/* A table's rows: all cases with their own kernels, or with that of a recipe
 * those that are not hard for their kernel alone, and wide ones. */
static struct hard_case rows[HARD_CASES + HARD_WIDE];
static struct result results[HARD_CASES + HARD_WIDE][WAYS];
static int n_rows;

static void add_row(const struct hard_case *h, const char *recipe, bool far)
{
    static const struct hard_bars field = {1e-6, 1e-5, 1e-5};
    struct hard_case *const row = &rows[n_rows];
    if (recipe && h->of_kernel)
        return;
    *row = *h;
    row->recipe = recipe;
    row->has_far = far;
    if (recipe)
        row->bar = field;
    n_rows++;
}

/* First, last, second, last but one: sizes jump from frame to frame. */
static void run_all(const char *recipe, bool far)
{
    struct gp_glare kept[WAYS] = {0};
    n_rows = 0;
    memset(results, 0, sizeof results);
    for (int i = 0; i < HARD_CASES && (!recipe || far); i++)
        add_row(&hard_cases[i], recipe, false);
    for (int i = 0; i < HARD_WIDE && recipe; i++)
        add_row(&hard_wide[i], recipe, far);
    for (int i = 0; i < n_rows; i++) {
        const int row = i % 2 ? n_rows - 1 - i / 2 : i / 2;
        if (hard_is_run(&rows[row]))
            run_case(row, &rows[row], kept, results[row]);
    }
    for (int i = 0; i < WAYS; i++)
        gp_glare_close(&kept[i]);
}

/* A table's title: `what`, and the recipe of its kernels where there is one. */
static const char *titled(const char *what, const char *recipe)
{
    static char title[128];
    snprintf(title, sizeof title, recipe ? "%s, %s over the whole field" : "%s",
             what, recipe);
    return title;
}

/* The columns of all ways, with these bars. */
static const struct hard_column *columns_of(const double bar[WAYS])
{
    static struct hard_column column[WAYS + 1];
    for (int i = 0; i < WAYS; i++)
        column[i] = (struct hard_column) {ways[i].name, bar[i]};
    return column;
}

/* An exact engine's bar is what it may round, and with a far field what that
 * leaves too; a grouped layer's is the bound that the engine states for it. */
static void print_errors(const char *recipe)
{
    const double bars[WAYS] = {1e-6, recipe ? 1e-5 : 2e-6, HARD_NO_BAR,
                               recipe ? 1e-5 : 1e-6, tolerance};
    hard_table(titled("Engines", recipe),
               "rel_l2 against the sum in double; where the exact layer is 0, "
               "the largest sample", columns_of(bars));
    for (int row = 0; row < n_rows; row++) {
        if (!hard_is_run(&rows[row]))
            continue;
        hard_row(rows[row].name);
        for (int i = 0; i < WAYS; i++) {
            const struct result *const r = &results[row][i];
            hard_cell_if(r->ran, r->error, r->bar);
        }
    }
    hard_table_end();
}

/* Groups promise rel_l2 alone. */
static void print_dark_pixels(const char *recipe)
{
    const double bar = recipe ? 1e-3 : 1e-5; // a far field's error is even
    const double bars[WAYS] = {1e-5, bar, HARD_NO_BAR, bar, HARD_NO_BAR};
    hard_table(titled("Dark pixels beside 1e9", recipe),
               "largest error of a pixel's luminance over its own value",
               columns_of(bars));
    for (int row = 0; row < n_rows; row++) {
        if (!hard_is_run(&rows[row]) || !(rows[row].own > 0.0))
            continue;
        hard_row(rows[row].name);
        for (int i = 0; i < WAYS; i++)
            hard_cell_if(results[row][i].ran, results[row][i].own, bars[i]);
    }
    hard_table_end();
}

static void print_kept(void)
{
    hard_row("one opened engine through all rows");
    for (int i = 0; i < WAYS; i++) {
        int differ = 0, ran = 0;
        for (int row = 0; row < n_rows; row++) {
            ran += results[row][i].ran && is_compared(row, i);
            differ += results[row][i].differs;
        }
        hard_cell_if(ran, differ, 0.0);
    }
}

/* Adds NAN where there is no GL for it. */
static void count_differing(int row, int threads, double *differ)
{
    struct scene s = hard_sense(&rows[row]);
    for (int i = 0; i < WAYS; i++) {
        struct result *const r = &results[row][i];
        gp_set_threads(1);
        if (!r->of_one_thread && run_alone(i, &s, rows[row].name))
            r->of_one_thread = scene_hash(&s);
        if (r->of_one_thread) {
            gp_set_threads(threads);
            run_alone(i, &s, rows[row].name);
            differ[i] += scene_hash(&s) != r->of_one_thread;
        } else {
            differ[i] = NAN;
        }
    }
    gp_set_threads(0);
    scene_free(&s);
}

/* Every seventh row is run again with each number of threads. */
static int is_threaded(int row)
{
    return row % 7 == 3 && hard_is_run(&rows[row]);
}

static void print_same_bytes(const char *recipe)
{
    static const double none[WAYS];
    hard_table(titled("Engines, the same bytes", recipe),
               "layers that differ from those of an engine opened for that "
               "frame alone, and from those of one thread", columns_of(none));
    print_kept();
    hard_thread_rows(WAYS, n_rows, is_threaded, count_differing);
    hard_table_end();
}

/* `far`: the recipe's kernels have one in wide frames. */
static void run_tables(const char *recipe, bool far)
{
    run_all(recipe, far);
    print_errors(recipe);
    print_dark_pixels(recipe);
    print_same_bytes(recipe);
}

void hard_glare(void)
{
    run_tables(NULL, false);
}

/* A smooth kernel, most of which is its far field, and in wide frames a sharp
 * one, which has none. */
void hard_field(void)
{
    run_tables("spencer", true);
    run_tables("star", false);
}

// -- a point that slides ------------------------------------------------------

/* Steps of 1/8 pixel to the right and 1/16 down: over 8 by 4 pixels every
 * place in a group of 8 comes about. */
enum { MOTION_STEPS = 64, MOTION_SIZE = 128, MOTION_KERNEL = 65 };

enum motion_shape { POINT, LINE, DISC, MOTION_SHAPES };

static const char *const motion_shapes[MOTION_SHAPES] = {
    "point", "line", "disc",
};

/* True where the shape is, dx, dy pixels from its middle: a point, a line of
 * 1 x 40 pixels at a slope of 1 : 3, a disc of radius 3. */
static int motion_covers(enum motion_shape shape, double dx, double dy)
{
    const double n = sqrt(10.0);
    const double along = (3.0 * dx + dy) / n, beside = (3.0 * dy - dx) / n;
    switch (shape) {
    case LINE:
        return fabs(along) < 20.0 && fabs(beside) < 0.5;
    case DISC:
        return dx * dx + dy * dy < 9.0;
    default:
        return dx == 0.0 && dy == 0.0;
    }
}

/* The middle of the shape at a step, in pixel centres. */
static void motion_place(int step, double place[2])
{
    place[0] = MOTION_SIZE / 2 - 4 + step / 8.0;
    place[1] = MOTION_SIZE / 2 - 2 + step / 16.0;
}

/* Adds light at a place that is no pixel's, by bilinear weights, which keep
 * its sum and its centroid. */
static void motion_add(struct gp_image *f, double x, double y,
                              float light)
{
    const int x0 = (int) floor(x), y0 = (int) floor(y);
    for (int i = 0; i < 4; i++) {
        const int px = x0 + (i & 1), py = y0 + (i >> 1);
        const double w = (1.0 - fabs(x - px)) * (1.0 - fabs(y - py));
        for (int c = 0; c < 3; c++)
            f->rgb.c[c][py * MOTION_SIZE + px] += (float) w * light;
    }
}

/* A black frame with the shape at a step: a sixteenth of a pixel apart, so
 * that each step moves the same samples as a whole. */
static struct gp_image motion_frame(enum motion_shape shape, int step)
{
    enum { FINE = 16 };
    struct gp_image f = scene_frame(MOTION_SIZE, MOTION_SIZE, 0, 0, BLACK, 1u);
    double place[2];
    motion_place(step, place);
    for (int y = -8 * FINE; y <= 8 * FINE; y++) {
        for (int x = -20 * FINE; x <= 20 * FINE; x++) {
            const double dx = (double) x / FINE, dy = (double) y / FINE;
            if (motion_covers(shape, dx, dy))
                motion_add(&f, place[0] + dx, place[1] + dy, 1.0f);
        }
    }
    return f;
}

/* Whatever shines is a source: no threshold adds ripples of its own. */
static const struct glarepp_sense_params motion_sensors = {.whole = true};

static struct gp_kernel motion_kernel(void)
{
    return scene_model("eye", MOTION_KERNEL, 0.0);
}

/* -- figures of a layer -----------------------------------------------------*/

struct motion_track {
    double least, most; // flux
    double centroid;    // its largest distance from the light's, pixels
};

/* Takes the layer of a step, its green plane, as the light is grey; layers come
 * in order. */
static void motion_follow(struct motion_track *t, int step, const float *layer)
{
    double place[2], flux = 0.0, x = 0.0, y = 0.0;
    motion_place(step, place);
    for (int i = 0; i < MOTION_SIZE * MOTION_SIZE; i++) {
        const double v = (double) layer[i];
        flux += v;
        x += v * (i % MOTION_SIZE);
        y += v * (i / MOTION_SIZE);
    }
    t->least = step ? fmin(t->least, flux) : flux;
    t->most = fmax(t->most, flux);
    t->centroid = fmax(t->centroid,
                       hypot(x / flux - place[0], y / flux - place[1]));
}

static struct motion_track slide(int way, const struct gp_kernel *kernel,
                                 enum motion_shape shape, bool *ran)
{
    struct motion_track track = {0};
    struct gp_glare g = {0};
    *ran = true;
    for (int i = 0; i < MOTION_STEPS && *ran; i++) {
        struct glarepp_layer_facts stats;
        struct scene s = scene_sense(motion_frame(shape, i), *kernel,
                                     &motion_sensors);
        *ran = run_way(way, &s, &g, &stats, motion_shapes[shape]);
        if (*ran)
            motion_follow(&track, i, s.f.layer.c[1]);
        s.k = (struct gp_kernel) {0}; // of all
        scene_free(&s);
    }
    gp_glare_close(&g);
    return track;
}

/* Of `what`: 0 flux ripple, 1 centroid. Grouping and auto may lose the light
 * that shrinking leaves out. */
static void print_slide(const struct motion_track r[MOTION_SHAPES][WAYS],
                        const bool ran[WAYS], int what)
{
    static const double bars[2][WAYS] = {
        {1e-5, 1e-5, 1e-3, 1e-5, 1e-3}, {1e-4, 1e-4, 1e-2, 1e-4, 1e-2},
    };
    hard_table(what ? "Light that slides by 1/8 pixel, centroid"
                    : "Light that slides by 1/8 pixel, flux",
               what ? "largest distance of the layer's centroid from the "
                      "light's, pixels"
                    : "largest flux over smallest, less 1",
               columns_of(bars[what]));
    for (int shape = 0; shape < MOTION_SHAPES; shape++) {
        hard_row(motion_shapes[shape]);
        for (int i = 0; i < WAYS; i++)
            hard_cell_if(ran[i], what ? r[shape][i].centroid
                             : r[shape][i].most / r[shape][i].least - 1.0,
                         bars[what][i]);
    }
    hard_table_end();
}

void hard_slide(void)
{
    struct motion_track r[MOTION_SHAPES][WAYS];
    bool ran[WAYS];
    struct gp_kernel kernel = motion_kernel();
    if (hard_quick) {
        gp_kernel_free(&kernel);
        return;
    }
    for (int shape = 0; shape < MOTION_SHAPES; shape++) {
        for (int i = 0; i < WAYS; i++)
            r[shape][i] = slide(i, &kernel, (enum motion_shape) shape, &ran[i]);
    }
    gp_kernel_free(&kernel);
    print_slide(r, ran, 0);
    print_slide(r, ran, 1);
}
