/* Functions of the room that only it and its tests use. */
#ifndef GP_CORE_CORE_PRIV_H
#define GP_CORE_CORE_PRIV_H

#include <stdbool.h>
#include <stddef.h>

/* Takes a block of >= 1 bytes at GP_ALIGN, not cleared; NULL when there is no
 * memory, or none free for a small one. Free with gp_arena_give(). Call from
 * any thread, as the others. */
void *gp_arena_take(size_t bytes);

/* True for a block of gp_arena_take(). */
bool gp_arena_has(const void *block);

void gp_arena_give(void *block);

/* Bytes that the arena has mapped, in use or not. */
size_t gp_arena_mapped(void);

/* XYZ of light of one wavelength, nm. */
void gp_spectrum_xyz(double nm, double xyz[3]);

#endif
