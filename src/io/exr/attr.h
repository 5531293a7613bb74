/* What the values of attributes must be like. OpenEXRCore (3.1.5) leaves out
 * those that it cannot parse and says nothing; OpenEXR's C++ library refuses
 * the file, and would refuse one that we carry them to.
 */
#ifndef GP_IO_EXR_ATTR_H
#define GP_IO_EXR_ATTR_H

#include "io/stream.h"

#include <stdbool.h>
#include <stdint.h>

enum { GP_EXR_NAME = 256 }; // bytes of any name with its null, at most

/* A value in the file. */
struct gp_exr_value {
    const struct gp_stream *stream;
    uint64_t at, size; // bytes [at, at + size)
};

/* False when these bytes are no value of that type. Of a type that OpenEXR
 * does not know any bytes are. Bytes that cannot be read are the library's to
 * complain about: true. */
bool gp_exr_value_is(const struct gp_exr_value *v, const char *type);

/* The type that the attribute of that name must have, or NULL when it may have
 * any. `multi`: in a file of several parts. */
const char *gp_exr_type_of(const char *name, bool multi);

/* Walks a list of channels, as far as `most` of them; returns how many there
 * are.
 *
 *   whole  written: the list ends where the value does, or the file before
 */
uint64_t gp_exr_count_channels(const struct gp_exr_value *v, uint64_t most,
                               bool *whole);

#endif
