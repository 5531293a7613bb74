// SPDX-License-Identifier: Apache-2.0
/* The machine around the process: the memory that it may use, and the
 * environment, which the library does not read. */
#ifndef GP_CLI_MACHINE_H
#define GP_CLI_MACHINE_H

#include "glarepp.h"

#include <stddef.h>

/* Returns the least of the bytes of the machine's memory, the limit of address
 * space, and the limits of the control groups that this process is in and their
 * parents, as Slurm and containers set them; 0 when unknown. Memory that other
 * processes use is not subtracted.
 *   root  "", or a folder before /proc/self/cgroup and /sys/fs/cgroup */
size_t gp_memory_limit(const char *root);

/* Returns the most bytes that this process had in memory so far: VmHWM of
 * proc(5), as ru_maxrss of getrusage(2) starts at the memory of the process
 * that started this one. 0 when unknown. */
size_t gp_peak_memory(void);

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
