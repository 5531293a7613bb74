// SPDX-License-Identifier: Apache-2.0
/* Shared by the fuzz targets: a log that checks its lines, a meter of the
 * heap, and the input as a file or a pipe.
 *
 * A target stands between fuzz_begin() and fuzz_end(). Every broken promise
 * ends in abort(), which the fuzzer keeps as a crash with its input.
 */
#ifndef FUZZ_HARNESS_H
#define FUZZ_HARNESS_H

#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    FUZZ_PIXELS = 1 << 16,  // --max-pixels of the targets: quick inputs
    FUZZ_FIXED = 64 << 20,  // bytes of heap that any input may take
    FUZZ_SECONDS = 2,       // of CPU time, under the sanitizers
};

/* Runs an input; in the file of a target, its own function, as the build renames
 * that after the file. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Chooses the target by the program's name, before the first input; exits when
 * there is none of that name. Returns 0. */
int LLVMFuzzerInitialize(int *argc, char ***argv);

/* The targets, up to an empty one; the build writes the list. */
struct fuzz_target {
    const char *name;
    int (*run)(const uint8_t *data, size_t size);
};
extern const struct fuzz_target fuzz_targets[];

/* Formats every line, and counts the error lines. */
extern const struct gp_log fuzz_log;

/* Starts an input: no lines yet, the meter at zero, loops on one thread. */
void fuzz_begin(void);

/* Ends it. `allowed`: the most bytes that may have been on the heap at one
 * time. Checks FUZZ_SECONDS too. */
void fuzz_end(uint64_t allowed);

/* Checks the lines of a call, and forgets them: an error has one, "what is
 * wrong; what to do", success has none, and no file makes GP_ERR_BUG. Returns
 * `st`. */
gp_status fuzz_line(gp_status st);

/* Bytes of heap that an EXR of `size` bytes may take when its reader accepts
 * FUZZ_PIXELS: FUZZ_FIXED, and for each pixel of the largest window that the
 * bytes claim 32 floats and 8 bytes a channel. A window that is larger than
 * FUZZ_PIXELS gives nothing. Found by searching the bytes for the attributes,
 * so that a fault of the header's reader does not move its own bar. */
uint64_t fuzz_allowed(const uint8_t *data, size_t size);

/* The input as a file that can be opened by the name returned, until
 * fuzz_file_close(); NULL when the system gives none. */
const char *fuzz_file(const uint8_t *data, size_t size);
void fuzz_file_close(void);

/* The same as a pipe, which can be read once; NULL also when the input does
 * not fit into a pipe's buffer. */
const char *fuzz_pipe(const uint8_t *data, size_t size);
void fuzz_pipe_close(void);

/* Checks that every byte may be read, as AddressSanitizer sees it. */
void fuzz_touch(const void *p, size_t bytes);

#endif
