/* Shared objects of this program that are opened when first needed: bridges
 * to C++ libraries, which cost too much at every start to be linked. */
#ifndef GP_CORE_BRIDGE_H
#define GP_CORE_BRIDGE_H

#include <stdbool.h>
#include <stddef.h>

/* Finds a file of this program: in $GLAREPP_BRIDGES, beside the program, in
 * ../lib/glarepp from there, or in the installed folder. False: in none. */
bool gp_bridge_find(const char *name, char *path, size_t size);

/* Opens the shared object of that file name, "glarepp-ocio.so". Returns what dlopen() does; never closed as a rule.
 * NULL, with one line in `why`, when it or one of its libraries is missing. */
void *gp_bridge_open(const char *name, char *why, size_t why_size);

/* C++ ends the process for what is thrown where nothing can catch it, such as
 * by a library's static constructors under dlopen(). When that is for want of
 * memory, a bridge having been asked for, `end` is called on that thread with
 * one line, "FILE: out of memory ..."; it says so, cleans up and does not
 * return. For all else C++ does as ever. Call once, before there are threads.
 */
void gp_bridge_on_no_memory(void (*end)(const char *line));

/* The file that this thread works on, for that line. Borrowed until the next
 * call on this thread; NULL: none. */
void gp_bridge_about(const char *file);

#endif
