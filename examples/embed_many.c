// SPDX-License-Identifier: Apache-2.0
/* A server's way: one plan, frames from several threads, and a way to stop.
 *
 *   cc embed_many.c $(pkg-config --cflags --libs glarepp) -pthread
 *
 * Each thread has a frame of its own. The plan lends engines to whoever runs, and
 * the context has as many threads at work as the machine has processors, however
 * many of these there are. Bytes do not depend on either. */
#include <glarepp.h>

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

enum { W = 480, H = 270, THREADS = 4, FRAMES = 12 };

static atomic_int next, done;
static atomic_bool stopped;
static int stop_after = FRAMES;

/* Called between steps: true ends the call. */
static bool progress(void *user, const char *step, double share)
{
    (void) user;
    (void) step;
    (void) share;
    return atomic_load(&stopped);
}

/* Makes frames until none is left; `arg` is the plan. */
static void *serve(void *arg)
{
    struct glarepp_plan *const plan = arg;
    float *const rgb = malloc(3 * W * H * sizeof *rgb);
    struct glarepp_image picture = GLAREPP_IMAGE;
    picture.data = (struct glarepp_rect) {0, 0, W, H};
    for (int c = 0; c < 3; c++)
        picture.plane[c] = rgb + c * W * H;
    for (int i; rgb && (i = atomic_fetch_add(&next, 1)) < FRAMES;) {
        struct glarepp_facts facts;
        for (int k = 0; k < 3 * W * H; k++)
            rgb[k] = 0.02f;
        for (int c = 0; c < 3; c++) // a lamp that moves from frame to frame
            rgb[c * W * H + H / 2 * W + (i + 1) * W / (FRAMES + 1)] = 2000.0f;
        const int status = glarepp_execute(plan, &picture, &picture, &facts);
        if (status == GLAREPP_ERR_CANCELLED)
            break;
        if (status) {
            fprintf(stderr, "frame %d: %s\n", i, glarepp_error()->text);
            exit(1);
        }
        if (atomic_fetch_add(&done, 1) + 1 == stop_after)
            atomic_store(&stopped, true);
    }
    free(rgb);
    return NULL;
}

int main(int argc, char *argv[])
{
    struct glarepp_params params = GLAREPP_PARAMS;
    struct glarepp *gp;
    struct glarepp_plan *plan;
    pthread_t thread[THREADS];
    if (argc > 1)
        stop_after = atoi(argv[1]);
    params.progress = progress;
    if (glarepp_open(&params, &gp) || glarepp_plan(gp, NULL, &plan)) {
        fprintf(stderr, "%s\n", glarepp_error()->text);
        return 1;
    }
    for (int i = 0; i < THREADS; i++)
        pthread_create(&thread[i], NULL, serve, plan);
    for (int i = 0; i < THREADS; i++)
        pthread_join(thread[i], NULL);
    printf("%d of %d frames\n", atomic_load(&done), FRAMES);
    glarepp_plan_end(&plan);
    glarepp_close(&gp);
    return 0;
}
