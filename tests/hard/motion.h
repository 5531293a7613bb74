/* Light that slides over the pixel grid, and what a layer makes of it. */
#ifndef GP_TESTS_MOTION_H
#define GP_TESTS_MOTION_H

#include "glare_scene.h"

#include "glare/splat/splat_priv.h"

/* Steps of 1/8 pixel to the right and 1/16 down: over 8 by 4 pixels every
 * place in a group of 8 comes about. */
enum { MOTION_STEPS = 64, MOTION_SIZE = 128, MOTION_KERNEL = 65 };

enum motion_shape { POINT, LINE, DISC, MOTION_SHAPES };

static const char *const motion_shapes[MOTION_SHAPES] = {
    "point", "line", "disc",
};

/* True where the shape is, dx, dy pixels from its middle: a point, a line of
 * 1 x 40 pixels at a slope of 1 : 3, a disc of radius 3. */
static inline int motion_covers(enum motion_shape shape, double dx, double dy)
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
static inline void motion_place(int step, double place[2])
{
    place[0] = MOTION_SIZE / 2 - 4 + step / 8.0;
    place[1] = MOTION_SIZE / 2 - 2 + step / 16.0;
}

/* Adds light at a place that is no pixel's, by bilinear weights, which keep
 * its sum and its centroid. */
static inline void motion_add(struct gp_image *f, double x, double y,
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
static inline struct gp_image motion_frame(enum motion_shape shape, int step)
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
static const struct gp_sensor_params motion_sensors = {.threshold = 0.0f};

static inline struct gp_kernel motion_kernel(void)
{
    return scene_model("eye", MOTION_KERNEL, 0.0);
}

/* -- figures of a layer -----------------------------------------------------*/

/* The result of 64 steps. */
struct motion_result {
    double ripple;    // largest flux over smallest, less 1
    double centroid;  // largest distance of the centroid from the light's,
                      // pixels
    double jump;      // largest change of the error from a frame to the next,
                      // over the norm of the exact layer
};

struct motion_track {
    double least, most, centroid, jump;
    double *error;    // of the step before, or NULL
};

/* Takes the layer of a step, its green plane, as the light is grey; layers come
 * in order. */
static inline void motion_follow(struct motion_track *t, int step,
                                 const double *layer, const double *exact)
{
    const int n = MOTION_SIZE * MOTION_SIZE;
    double place[2], flux = 0.0, x = 0.0, y = 0.0, change = 0.0, whole = 0.0;
    double *const error = scene_alloc((size_t) n, sizeof *error);
    motion_place(step, place);
    for (int i = 0; i < n; i++) {
        flux += layer[i];
        x += layer[i] * (i % MOTION_SIZE);
        y += layer[i] * (i / MOTION_SIZE);
        error[i] = layer[i] - exact[i];
        const double step_of_it = t->error ? error[i] - t->error[i] : 0.0;
        change += step_of_it * step_of_it;
        whole += exact[i] * exact[i];
    }
    t->least = step ? fmin(t->least, flux) : flux;
    t->most = fmax(t->most, flux);
    t->centroid = fmax(t->centroid,
                       hypot(x / flux - place[0], y / flux - place[1]));
    t->jump = fmax(t->jump, sqrt(change / whole));
    free(t->error);
    t->error = error;
}

/* Returns how much one step moves the exact layer itself, over its norm. */
static inline double motion_own(const double *before, const double *exact)
{
    double change = 0.0, whole = 0.0;
    for (int i = 0; i < MOTION_SIZE * MOTION_SIZE; i++) {
        change += (exact[i] - before[i]) * (exact[i] - before[i]);
        whole += exact[i] * exact[i];
    }
    return sqrt(change / whole);
}

static inline struct motion_result motion_end(struct motion_track *t)
{
    const struct motion_result r = {
        t->most / t->least - 1.0, t->centroid, t->jump,
    };
    free(t->error);
    *t = (struct motion_track) {0};
    return r;
}

#endif
