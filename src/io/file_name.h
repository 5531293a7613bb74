/* Names around an output file; no file is read or written here. */
#ifndef GP_IO_FILE_NAME_H
#define GP_IO_FILE_NAME_H

#include <stdbool.h>

/* True for targets that are written to directly: "-", pipes, devices and
 * sockets that exist, and the names of open descriptors (/dev/fd/N,
 * /dev/stdout, /dev/stderr, /proc/...), whatever these stand for. */
bool gp_file_is_straight(const char *path);

/* Strings from malloc, NULL when memory is full: the folder a path is in
 * ("." for a bare name), the path with links followed, also to a file
 * that is still to be made (NULL with errno too where they cannot be followed:
 * a circle, a folder that may not be searched), and FOLDER/.NAME.PID.tmp, or
 * FOLDER/.NAME.PID-N.tmp for a nth choice N > 0 (NAME cut where the whole would
 * be longer than a file name may be). */
char *gp_file_folder(const char *path);
char *gp_file_resolve(const char *path);
char *gp_file_temp_name(const char *path, int nth);

/* Makes every missing folder above `path`; 0, or -1 with errno set. */
int gp_file_make_folders(const char *path);

/* The ending of the name in lower case, without its dot, in a buffer of
 * `room` bytes; "" when there is none or it does not fit. ".exr" alone is a
 * hidden file without an ending. */
void gp_file_ending(const char *path, char *ending, int room);

#endif
