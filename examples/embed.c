// SPDX-License-Identifier: Apache-2.0
/* Adds glare to an array of pixels, and prints how wrong it may be.
 *
 *   cc embed.c $(pkg-config --cflags --libs glarepp) -o embed && ./embed
 *
 * It is C11, and C++17 too. */
#include <glarepp.h>

#include <stdio.h>
#include <stdlib.h>

enum { W = 640, H = 360 };

static int fail(const char *what)
{
    fprintf(stderr, "%s: %s\n", what, glarepp_error()->text);
    return 1;
}

int main(void)
{
    struct glarepp_params params = GLAREPP_PARAMS;
    struct glarepp_plan_params how = GLAREPP_PLAN_PARAMS;
    struct glarepp_image picture = GLAREPP_IMAGE;
    struct glarepp_facts facts;
    struct glarepp *gp;
    struct glarepp_plan *plan;

    // interleaved RGB, as a renderer has it: a dim frame with three lamps
    float *rgb = (float *) malloc(3 * W * H * sizeof *rgb);
    if (!rgb)
        return 1;
    for (int i = 0; i < 3 * W * H; i++)
        rgb[i] = 0.05f;
    for (int lamp = 1; lamp <= 3; lamp++)
        rgb[3 * (H / 2 * W + lamp * W / 4)] = 3000.0f;

    for (int c = 0; c < 3; c++)
        picture.plane[c] = rgb + c;
    picture.pixel = 3 * sizeof *rgb;
    picture.row = 3 * W * sizeof *rgb;
    picture.data.x1 = W;
    picture.data.y1 = H;

    how.fov = 40.0; // degrees, vertical
    if (glarepp_open(&params, &gp))
        return fail("open");
    if (glarepp_plan(gp, &how, &plan))
        return fail("plan");
    if (glarepp_execute(plan, &picture, &picture, &facts))
        return fail("execute");
    printf("%lld sources by %s, error at most %.2g\n", facts.sense.sources,
           facts.layer.engine, facts.layer.bound);
    printf("beside a lamp %.3f, was 0.050\n",
           (double) rgb[3 * (H / 2 * W + W / 4 + 10)]);
    glarepp_plan_end(&plan);
    glarepp_close(&gp);
    free(rgb);
    return 0;
}
