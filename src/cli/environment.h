/* The environment of the process, which the library does not read. */
#ifndef GP_CLI_ENVIRONMENT_H
#define GP_CLI_ENVIRONMENT_H

#include "glarepp.h"

/* Reads variables into *p:
 *   GLAREPP_BRIDGES   folder that is looked in first for bridges
 *   GLAREPP_EXAMPLES  ... for flares/ and lenses/
 *   GLAREPP_OSMESA, GLAREPP_EGL  file in place of libOSMesa, libEGL
 *   GLAREPP_GL_MAX_SIZE  largest side of a GL texture, for tests of tiling
 * Strings are the environment's. */
void gp_environment_read(struct glarepp_params *p);

/* Keeps what the heap frees, for runs of many frames. Call it first. */
void gp_environment_set_heap(void);

/* Sets the variables that Mesa reads, where the user did not: LP_NUM_THREADS,
 * as its CPU rasterizer starts a thread for each processor otherwise, and
 * EGL_LOG_LEVEL, as it warns on stderr. Call it while there is one thread: one
 * that asks for a variable while another is added may read freed memory. */
void gp_environment_set_gl(int threads);

#endif
