/* The memory that this process may use. */
#ifndef GP_CLI_MACHINE_H
#define GP_CLI_MACHINE_H

#include <stddef.h>

/* Returns the bytes of the machine's memory, or the least limit of the control
 * groups that this process is in and their parents, as batch systems (Slurm)
 * and containers set it: memory.max of cgroup v2, memory.limit_in_bytes of v1;
 * or the limit of address space, where that is less.
 * 0 when unknown. Memory that other processes use is not subtracted.
 *   root  "", or a folder before /proc/self/cgroup and /sys/fs/cgroup */
size_t gp_memory_limit(const char *root);

/* Returns the most bytes that this process had in memory so far: VmHWM of
 * proc(5), else ru_maxrss of getrusage(2), which starts at the memory of the
 * process that started this one. 0 when unknown. */
size_t gp_peak_memory(void);

#endif
