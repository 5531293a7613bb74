/* Why the EXR library failed: it calls a file damaged also when memory is
 * full or the disk does not read, and goes on after some of these as if an
 * attribute had not been there. So its memory and its bytes come through here,
 * and what goes wrong with them is kept, for each thread by itself. */
#ifndef GP_IO_EXR_FAULT_H
#define GP_IO_EXR_FAULT_H

#include "core/status.h"
#include "io/stream.h"

/* For alloc_fn of a context: malloc(). */
void *gp_exr_allocate(size_t size);

/* gp_stream_read(). */
int64_t gp_exr_read_bytes(const struct gp_stream *s, void *to, uint64_t n,
                          uint64_t offset);

/* Forgets what happened on this thread; before calls of the library. */
void gp_exr_fault_clear(void);

/* What happened on this thread since: GP_OK, GP_ERR_BUG memory was full,
 * GP_ERR_IO a read failed. Safe in parallel bodies. */
gp_status gp_exr_fault(void);

/* True when a read on this thread since got fewer bytes than it asked for.
 * That is as it should be in headers, which are read in blocks; of chunks
 * that are not compressed OpenEXRCore 3.1.5 makes the rest black and is
 * content, though the file was cut after it was opened. */
bool gp_exr_fault_short(void);

/* Prints the line for `fault`, GP_ERR_BUG or GP_ERR_IO, with this thread's
 * reason when it has one, and returns it. */
gp_status gp_exr_fault_tell(const struct gp_log *log, const char *path,
                            gp_status fault);

#endif
