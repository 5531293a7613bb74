/* The header of an EXR input as the bytes it is.
 *
 * What is carried from input to output is carried as bytes: attributes of any
 * type, known or not, and whole headers of other parts. (OpenEXRCore 3.1.5
 * refuses to copy attributes whose type it does not know.) The origin has
 * parsed the same header with the library before, so a fault found here is
 * rare; it is checked all the same.
 */
#ifndef GP_IO_EXR_RAW_H
#define GP_IO_EXR_RAW_H

#include "core/status.h"
#include "io/exr/origin.h"

#include <stddef.h>
#include <stdint.h>

/* Flags of the version field, openexr file layout, "Version Field". */
enum {
    GP_EXR_MAGIC = 20000630,
    GP_EXR_VERSION = 2,
    GP_EXR_TILED = 0x200,
    GP_EXR_LONG_NAMES = 0x400,
    GP_EXR_DEEP = 0x800,
    GP_EXR_MULTIPART = 0x1000,
};

/* One attribute; pointers go into gp_exr_raw.bytes. */
struct gp_exr_attr {
    const char *name, *type;
    const uint8_t *data;  // `size` bytes, little-endian, not aligned
    uint32_t size;
};

struct gp_exr_raw_part {
    const uint8_t *bytes;  // all attributes, with the null byte that ends them
    size_t size;
    const struct gp_exr_attr *attr;
    int attrs;
};

struct gp_exr_raw {
    uint32_t version;  // with its flags
    uint8_t *bytes;    // from the magic number to the first offset table
    size_t size;
    struct gp_exr_raw_part *part;
    int parts;
    struct gp_exr_attr *attr;  // those of all parts
};

/* Reads the header of an EXR origin. `out` is empty on failure; free with
 * gp_exr_raw_free(). Errors: GP_ERR_DATA cannot be read or parsed;
 * GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_exr_raw_read(const struct gp_log *log,
                                        const char *path,
                                        const struct gp_origin *origin,
                                        struct gp_exr_raw *out);
void gp_exr_raw_free(struct gp_exr_raw *raw);

/* The attribute of that name and type, or NULL. */
const struct gp_exr_attr *gp_exr_raw_find(const struct gp_exr_raw_part *part,
                                          const char *name, const char *type);

#endif
