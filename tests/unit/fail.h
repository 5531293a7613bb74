// SPDX-License-Identifier: Apache-2.0
/* Makes one call of the program's own code fail: tests/faults/shim.c, linked
 * into the unit tests with --wrap of these calls (FAIL_WRAP in tests/Makefile),
 * so that calls made by libraries do not count. */
#ifndef GP_TESTS_FAIL_H
#define GP_TESTS_FAIL_H

#include <stdbool.h>
#include <sys/types.h>

enum fail_class {
    FAIL_NONE,
    FAIL_ALLOC,  // malloc, realloc, posix_memalign: ENOMEM
    FAIL_IO,     // open, close, read, write, pread, pwrite, fstat, rename,
                 // memfd_create: EACCES, EIO, ENOSPC, EMFILE
    FAIL_THREAD, // pthread_create: EAGAIN
    FAIL_GL,     // glGetError: GL_OUT_OF_MEMORY
};

/* The n-th call of that class from here on fails, from 1. */
void fail_at(enum fail_class class, long n);

/* The first call of that class fails which came by a path of callers that had
 * fewer than two failures since fail_forget(): with a loop until fail_end() is
 * false, each path's first call fails and its second. */
void fail_next(enum fail_class class);
void fail_forget(void);

/* No call fails any more. Returns whether the one that had to fail came. */
bool fail_end(void);

/* Blocks that were allocated and not freed. */
long fail_blocks(void);

/* Calls that fail each time, until it is set back. */
struct fail_always {
    bool threads, affinity, links; // pthread_create, sched_getaffinity,
                                   // readlink
    bool closes;                   // close: the file is closed all the same
    const char *library, *symbol;  // the dlopen, dlsym of these names
};
extern struct fail_always fail_always;

/* The mode that open() was last asked to make a file with. */
extern _Atomic mode_t fail_made_mode;

/* The calls themselves, for tests. */
int __real_open(const char *path, int flags, ...);
int __real_close(int fd);

#endif
