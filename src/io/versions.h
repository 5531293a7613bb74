/* Versions of the file format libraries. */
#ifndef GP_IO_VERSIONS_H
#define GP_IO_VERSIONS_H

#include <stddef.h>

/* Writes "OpenEXRCore 3.1.5, libpng 1.6.39, ..." into `line`: what this
 * process runs with where the library can say so, else what it was built
 * with. Opens nothing. */
void gp_io_versions(char *line, size_t size);

#endif
