/* Functions of the room that only it and its tests use. */
#ifndef GP_CORE_CORE_PRIV_H
#define GP_CORE_CORE_PRIV_H

#include <stddef.h>

/* Returns the least limit of the control groups that `root`/proc/self/cgroup
 * names, under `root`/sys/fs/cgroup; `most` where there is none below. */
size_t gp_cgroup_limit(const char *root, size_t most);

/* XYZ of light of one wavelength, nm. */
void gp_spectrum_xyz(double nm, double xyz[3]);

#endif
