/* A first walk over an EXR header, before the library sees it. */
#ifndef GP_IO_EXR_SCAN_H
#define GP_IO_EXR_SCAN_H

#include "io/exr/attr.h"
#include "io/stream.h"

#include <stdbool.h>
#include <stdint.h>

/* OpenEXRCore (3.1.5) puts every channel and attribute into its sorted list by
 * a walk from one end: lists of n take it n^2 / 2 comparisons of names. So
 * the squares of the lengths of all channel lists together are bounded by the
 * square of this, and so are those of attributes. */
enum { GP_EXR_LIST_MOST = 8192 };

struct gp_exr_scan {
    /* Where the attribute "type" of a file with one flat part begins; 0 when
     * it has none. */
    uint64_t type;
    uint64_t tables;      // where the offset tables begin; 0: the header is
                          // damaged, or could not be read
    bool multi;           // the version says that there are several parts
    const char *too_long; // what there is too much of: "channels",
                          // "attributes", "parts"; NULL: nothing
    uint64_t count;       // how many of these were counted until then, or
                          // the bytes of the attribute below
    bool damaged;         // this attribute's value is none of the type
                          // that it says or must have
    char name[GP_EXR_NAME], kind[GP_EXR_NAME];
};

/* Walks the header. What is damaged ends the walk, and is the library's to
 * complain about but for values of attributes, which it may leave out without
 * a word; so does a list that is too long. */
struct gp_exr_scan gp_exr_scan_header(const struct gp_stream *s);

#endif
