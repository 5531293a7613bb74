#include "cli/environment.h"

#include <limits.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Returns a variable; NULL where it is empty or not set. */
static const char *variable(const char *name)
{
    const char *const v = getenv(name);
    return v && *v ? v : NULL;
}

void gp_environment_read(struct glarepp_params *p)
{
    const char *const size = variable("GLAREPP_GL_MAX_SIZE");
    const long side = size ? strtol(size, NULL, 10) : 0;
    p->bridges = variable("GLAREPP_BRIDGES");
    p->data = variable("GLAREPP_EXAMPLES");
    p->osmesa = variable("GLAREPP_OSMESA");
    p->egl = variable("GLAREPP_EGL");
    p->gl_size = side > 0 && side < INT_MAX ? (int) side : 0;
}

void gp_environment_set_heap(void)
{
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, 256 << 10); // larger blocks are mapped
    mallopt(M_TRIM_THRESHOLD, 1 << 30);   // free bytes that the heap keeps
    mallopt(M_ARENA_MAX, 1); // a heap for each thread would grow by what other
                             // threads take from it and free
#endif
}

void gp_environment_set_gl(int threads)
{
    char text[16];
    snprintf(text, sizeof text, "%d", threads);
    setenv("LP_NUM_THREADS", text, 0);
    setenv("EGL_LOG_LEVEL", "fatal", 0);
}
