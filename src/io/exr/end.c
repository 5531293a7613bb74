#include "io/exr/exr_priv.h"

#include <string.h>

/* The chunk that stands last, as far as was looked. */
struct last {
    uint64_t offset;
    int part;
};

/* Goes through the table of `chunks` offsets at `at`, which the stream has.
 * False when one was never written. */
static bool look_through(const struct gp_input *o, uint64_t at, int32_t chunks,
                         int part, struct last *last)
{
    enum { BLOCK = 512 };
    uint64_t offset[BLOCK];
    for (int32_t i = 0; i < chunks; i += BLOCK) {
        const int32_t n = chunks - i < BLOCK ? chunks - i : BLOCK;
        const uint64_t bytes = (uint64_t) n * sizeof *offset;
        if (gp_stream_read(&o->stream, offset, bytes,
                           at + (uint64_t) i * sizeof *offset) !=
            (int64_t) bytes)
            return false;
        for (int32_t k = 0; k < n; k++) {
            if (offset[k] == 0)
                return false;
            if (offset[k] > last->offset)
                *last = (struct last) {offset[k], part};
        }
    }
    return true;
}

/* The end of a chunk, or 0. Its leader has, all numbers little-endian: the
 * part in files of several; y, or tile x and y and level x and y; the bytes
 * that follow, in deep parts of count table, samples and unpacked samples. */
static uint64_t chunk_end(const struct gp_input *o, const struct last *last)
{
    exr_storage_t storage;
    uint8_t leader[44];
    uint64_t deep_size[2], end;
    uint32_t flat;
    if (exr_get_storage(o->exr, last->part, &storage))
        return 0;
    const bool deep = storage == EXR_STORAGE_DEEP_SCANLINE ||
                      storage == EXR_STORAGE_DEEP_TILED;
    const bool tiled = storage == EXR_STORAGE_TILED ||
                       storage == EXR_STORAGE_DEEP_TILED;
    const size_t head = (o->multi ? 4u : 0u) + (tiled ? 16u : 4u);
    const size_t lead = head + (deep ? 24u : 4u);
    const int64_t got = gp_stream_read(&o->stream, leader, lead, last->offset);
    if (got != (int64_t) lead)
        return got < 0 ? 0 : last->offset + lead;
    memcpy(&flat, leader + head, sizeof flat);
    end = last->offset + lead + flat;
    if (deep) {
        memcpy(deep_size, leader + head, sizeof deep_size);
        if (__builtin_add_overflow(deep_size[0], deep_size[1], &end) ||
            __builtin_add_overflow(end, last->offset + lead, &end))
            return 0;
    }
    return end;
}

uint64_t gp_exr_end(const struct gp_input *o)
{
    struct last last = {0};
    uint64_t at = o->tables;
    for (int part = 0; at && part < o->parts; part++) {
        int32_t chunks;
        if (exr_get_chunk_count(o->exr, part, &chunks) || chunks < 1)
            return 0;
        const uint64_t next = at + (uint64_t) chunks * sizeof(uint64_t);
        if (next > o->stream.size)
            return next;
        if (!look_through(o, at, chunks, part, &last))
            return 0;
        at = next;
    }
    return at && last.offset >= at ? chunk_end(o, &last) : 0;
}
