// SPDX-License-Identifier: Apache-2.0
/* Writes one output file: whole under its final name, or not at all.
 *
 * A regular target is written as FOLDER/.NAME.PID.tmp and renamed by
 * gp_file_commit(). Where that name is taken (by a run with the same number on
 * another machine, or one that was killed) it is .NAME.PID-1.tmp, and so on: a
 * file that another run made is never touched. A target that cannot be renamed
 * onto ("-" for stdout, a pipe, a device) is collected in memory and written at
 * once, because formats seek back to fill in tables and a pipe cannot.
 *
 * Every function prints its own error line through the log given to
 * gp_file_open(). Only `sync` writes through to the disk (fsync): without it a
 * power cut may lose or cut what was renamed. */
#ifndef GP_IO_FILE_H
#define GP_IO_FILE_H

#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct gp_file;

/* True for "-", which is stdin or stdout; NULL is not. */
static inline bool gp_is_dash(const char *path)
{
    return path && path[0] == '-' && !path[1];
}

/* Starts writing `path`, `create_dir` with missing folders; `sync` has a regular file
 * written through to the disk before it is renamed, and its folder afterwards: an error
 * of the folder's leaves the file. Follows a symbolic link: it stays and its target is
 * replaced. Keeps the permissions of an existing file. Borrows `log` until
 * gp_file_commit() or gp_file_discard().
 * Errors: GP_ERR_IO no such folder, a folder of that name, not writable. */
GP_MUST_CHECK gp_status gp_file_open(const struct gp_log *log, const char *path,
                                     bool create_dir, bool sync,
                                     struct gp_file **out);

/* Appends `size` bytes. Errors: GP_ERR_IO with the system's reason. */
GP_MUST_CHECK gp_status gp_file_write(struct gp_file *f, const void *data,
                                      size_t size);

/* Replaces bytes [at, at + size) of what was already written. */
GP_MUST_CHECK gp_status gp_file_patch(struct gp_file *f, uint64_t at,
                                      const void *data, size_t size);

/* Bytes appended so far. */
uint64_t gp_file_size(const struct gp_file *f);

/* The name it is for, as the user gave it; "stdout" for "-". */
const char *gp_file_path(const struct gp_file *f);

/* Closes the file, renames it to its final name and sets *f to NULL. When
 * anything fails, here or in an earlier write, no file is left (an old one
 * stays as it was) and the status is GP_ERR_IO. */
GP_MUST_CHECK gp_status gp_file_commit(struct gp_file **f);

/* Removes what was written and frees *f; NULL is fine. */
void gp_file_discard(struct gp_file **f);

/* Opens a file that grows line by line, for others that read it: not replaced and
 * not cut; begins at the start, a descriptor of the process where it is. *created
 * is the file's own name where there was none, gp_free() it, or NULL. */
GP_MUST_CHECK gp_status gp_file_open_lines(const struct gp_log *log,
    const char *path, bool create_dir, int *out, char **created);

/* Writes a whole file of `size` bytes. Errors: as above. */
GP_MUST_CHECK gp_status gp_file_save(const struct gp_log *log, const char *path,
                                     bool create_dir, bool sync,
                                     const void *data, size_t size);

/* Checks before any work what gp_file_open() will need: the folder exists and
 * is writable (or may be made), the name is no folder, and no regular file in
 * /proc (of another process' descriptor), which could not be replaced whole. */
GP_MUST_CHECK gp_status gp_file_check(const struct gp_log *log,
                                      const char *path, bool create_dir);

/* True when there is a regular file of that name. */
bool gp_file_exists(const char *path);

/* -- names ----------------------------------------------------------------- */

/* Returns the descriptor that a name stands for, or leads to: 1 for "-" and
 * /dev/stdout, N for /dev/fd/N and for N in /proc's lists of this process and
 * its threads; -1 for other names. It is written where it is, after what is
 * there, and never opened again: that would begin at the file's start. */
int gp_file_descriptor(const char *path);

/* True for targets that are written to directly: "-", pipes, devices and
 * sockets that exist, and names in /proc, also by links. */
bool gp_file_is_straight(const char *path);

/* Returns the path with links of its last component followed, also to a file
 * that does not exist yet; from malloc, NULL with errno for a circle, or when
 * memory is full. */
char *gp_file_resolve(const char *path);

/* Copies the ending of the name, in lower case and without its dot, to a buffer
 * of `room` bytes; "" when there is none (".exr" is hidden) or no room. */
void gp_file_ending(const char *path, char *ending, int room);

/* -- signals --------------------------------------------------------------- */

/* Makes signals that end the process (from the terminal, a batch system or a
 * timer) remove its temporary files first; a signal that the parent set to be
 * ignored stays ignored. Call once at start. */
void gp_temp_cleanup_on_signal(void);

/* -- stdout ---------------------------------------------------------------- */

/* Ends what was printed to stdout. Errors: GP_ERR_IO it cannot be written. */
GP_MUST_CHECK gp_status gp_flush_stdout(const struct gp_log *log);

/* The same for help and lists, which a reader such as head(1) may leave before
 * their end: that is no error. */
GP_MUST_CHECK gp_status gp_flush_text(const struct gp_log *log);

#endif
