/* The inner loops of EXR's ZIP, ZIPS and RLE chunks.
 *
 * Such a chunk holds all bytes at even places, then all bytes at odd places,
 * each byte as the difference to the one before, plus 128 (ImfZip.cpp). The
 * two halves are never put together in memory: the functions below read both
 * at once on the way to the planes.
 */
#ifndef GP_IO_EXR_UNZIP_H
#define GP_IO_EXR_UNZIP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A decompressor for one thread, made with libdeflate. */
struct gp_inflate;
struct gp_inflate *gp_inflate_new(void); // NULL when memory is full
void gp_inflate_free(struct gp_inflate *d);

/* Inflates a zlib stream of exactly `out_size` bytes; false when the stream
 * is anything else. `in` and `out` do not overlap. */
bool gp_inflate_run(struct gp_inflate *d, const void *in, size_t in_size,
                    void *out, size_t out_size);

/* Expands EXR's run lengths to exactly `out_size` bytes; false when the runs
 * give more or less. */
bool gp_unrle(const uint8_t *in, size_t in_size, uint8_t *out,
              size_t out_size);

/* Undoes the differences in place. */
void gp_undo_delta(uint8_t *v, size_t n);

/* Bytes `even` and `odd`, n of each, one after the other into `out` (2 n). */
void gp_interleave(const uint8_t *even, const uint8_t *odd, void *out,
                   size_t n);

/* n halfs, low bytes in `even`, high bytes in `odd`, to floats. */
void gp_split_half_to_float(const uint8_t *even, const uint8_t *odd,
                            float *out, size_t n);

#endif
