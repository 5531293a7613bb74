/* Whether jansson had the memory it asked for. Its calls are many and not all
 * of them tell: 2.14 takes a full memory for bad JSON in some places, and
 * prints objects without a key in others. */
#ifndef GP_CORE_JSON_MEMORY_H
#define GP_CORE_JSON_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

/* Call before values are read or made; forgets what was before. Values may
 * outlive it, and are freed as ever. */
void gp_json_memory_watch(void);

/* True when an allocation of jansson failed on this thread since. */
bool gp_json_memory_full(void);

/* malloc() that counts as an allocation of jansson; free() gives it back. */
void *gp_json_allocate(size_t size);

#endif

