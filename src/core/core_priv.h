/* Functions of the room that only it and its tests use. */
#ifndef GP_CORE_CORE_PRIV_H
#define GP_CORE_CORE_PRIV_H

#include <stdbool.h>
#include <stddef.h>

/* Takes a large block at a page, not cleared; NULL when there is no memory.
 * Call from any thread. */
void *gp_arena_take(size_t bytes);

/* Gives a block back; false where it is none of gp_arena_take(). */
bool gp_arena_give(void *block);

/* XYZ of light of one wavelength, nm. */
void gp_spectrum_xyz(double nm, double xyz[3]);

#endif
