/* Shared objects of this program that are opened when first needed: bridges
 * to C++ libraries, which cost too much at every start to be linked. */
#ifndef GP_CORE_BRIDGE_H
#define GP_CORE_BRIDGE_H

#include <stddef.h>

/* Opens the shared object of that file name, "glarepp-oiio.so": in
 * $GLAREPP_BRIDGES, beside the program, in ../lib/glarepp from there, or in the
 * installed folder. Returns what dlopen() does; never closed as a rule.
 * NULL, with one line in `why`, when it or one of its libraries is missing. */
void *gp_bridge_open(const char *name, char *why, size_t why_size);

#endif
