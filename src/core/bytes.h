/* Whole numbers in a file's bytes, of either order, at any alignment. */
#ifndef GP_CORE_BYTES_H
#define GP_CORE_BYTES_H

#include <stdint.h>

/* Little-endian: EXR. */
static inline uint32_t gp_le32(const uint8_t *p)
{
    return (uint32_t) p[0] | (uint32_t) p[1] << 8 | (uint32_t) p[2] << 16 |
           (uint32_t) p[3] << 24;
}

/* Big-endian: PNG. */
static inline uint32_t gp_be32(const uint8_t *p)
{
    return (uint32_t) p[0] << 24 | (uint32_t) p[1] << 16 |
           (uint32_t) p[2] << 8 | (uint32_t) p[3];
}

#endif
