/* gp_memory_limit() in a tree of files that a test made. */
#ifndef GP_CORE_MEMORY_PRIV_H
#define GP_CORE_MEMORY_PRIV_H

#include "core/memory.h"

/* Returns the least limit of the control groups that `root`/proc/self/cgroup
 * names, under `root`/sys/fs/cgroup; `most` where there is none below. */
size_t gp_cgroup_limit(const char *root, size_t most);

#endif
