/* Times of making models' kernels.
 *
 *   models [RUNS]
 *
 * Prints the median of RUNS (5) in ms for each recipe and frame, with a pixel
 * of 1/36 degree. A kernel of 512 x 512 is that of a frame of 256 x 256. */
#include "median.h"

#include "core/clock.h"
#include "core/colour.h"
#include "core/parallel.h"
#include "glare/model/model.h"

#include <stdio.h>
#include <stdlib.h>

static const struct gp_log models_log = BENCH_LOG("models");

static const struct {
    const char *recipe;
    int w, h;
} rows[] = {
    {"spencer", 1920, 1080},
    {"cie:age=70", 1920, 1080},
    {"aperture", 256, 256},
    {"aperture:defocus=0.5,wavelengths=8", 256, 256},
    {"aperture", 1920, 1080},
    {"temporal", 256, 256},
    {"temporal", 1920, 1080},
};

int main(int argc, char **argv)
{
    enum { MOST = 99 };
    const int asked = argc > 1 ? atoi(argv[1]) : 5;
    const int runs = asked < 1 ? 1 : asked > MOST ? MOST : asked;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct gp_image frame =
            gp_image_blank((struct gp_rect) {0, 0, rows[i].w, rows[i].h});
        const struct gp_field f = gp_field_of(&frame, rows[i].h / 36.0);
        double ms[MOST];
        struct gp_recipe r;
        if (gp_recipe_parse(&models_log, rows[i].recipe, &r))
            return 1;
        for (int n = 0; n < runs; n++) {
            struct gp_kernel k;
            const double from = gp_now_ms();
            if (gp_model_kernel(&models_log, &r, 1, &f, &k))
                return 1;
            ms[n] = gp_now_ms() - from;
            gp_kernel_free(&k);
        }
        gp_recipe_free(&r);
        printf("%-36s %4dx%-4d  %7.1f ms, %d threads\n", rows[i].recipe,
               rows[i].w, rows[i].h, median(ms, runs), gp_threads());
    }
    return 0;
}
