/* The memory that this process may use. */
#ifndef GP_CORE_LIMITS_H
#define GP_CORE_LIMITS_H

#include <stddef.h>

/* Returns the bytes of the machine's memory, or the least limit of the control
 * groups that this process is in and their parents, as batch systems (Slurm)
 * and containers set it: memory.max of cgroup v2, memory.limit_in_bytes of v1;
 * or the limit of address space, where that is less.
 * 0 when unknown. Memory that other processes use is not subtracted. */
size_t gp_memory_limit(void);

#endif
