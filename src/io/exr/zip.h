/* EXR's ZIP and ZIPS compression of one chunk. */
#ifndef GP_IO_EXR_ZIP_H
#define GP_IO_EXR_ZIP_H

#include <stddef.h>
#include <stdint.h>

struct libdeflate_compressor;

/* A compressor of the level that gp_exr_zip() is meant for; one a thread.
 * NULL when memory is full; free with libdeflate_free_compressor(). */
struct libdeflate_compressor *gp_exr_zip_compressor(void);

/* Splits `n` bytes (even) into those at even and at odd places, and turns
 * each into its difference to the one before, plus 128: what OpenEXR does
 * before deflate (ImfZip.cpp). `in` and `out` do not overlap. */
void gp_exr_zip_filter(const uint8_t *restrict in, uint8_t *restrict out,
                       size_t n);

/* Compresses a chunk.
 *
 *   raw      `n` bytes, even
 *   scratch  n bytes
 *   out      n bytes
 *
 * Returns the compressed size, always less than n, or 0 when the chunk does
 * not shrink and is stored as it is.
 */
size_t gp_exr_zip(struct libdeflate_compressor *c, const uint8_t *raw,
                  size_t n, uint8_t *scratch, uint8_t *out);

#endif
