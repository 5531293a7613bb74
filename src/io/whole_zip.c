#include "io/whole_zip.h"

#include "core/memory.h"
#include "core/parallel.h"

#include <libdeflate.h>

struct job {
    const struct gp_stream *s;
    const struct gp_zip *zip;
};

/* Bytes of a stream that are looked at: as many as libtiff takes, so that
 * streams that share what they claim cost no more than what they give. */
static uint64_t packed_bytes(const struct gp_zip *z, uint64_t room)
{
    const uint64_t most = 10 * room + 4096;
    return z->bytes < most ? z->bytes : most;
}

static gp_status unpack(const struct gp_stream *s, const struct gp_zip *z,
                        struct libdeflate_decompressor *d)
{
    gp_status st;
    void *in = NULL, *out = NULL;
    const uint64_t room = z->size > z->or_size ? z->size : z->or_size;
    const uint64_t bytes = packed_bytes(z, room);
    GP_TRY(gp_alloc(NULL, "strip", bytes + 1, 1, &in));
    GP_TRY(gp_alloc(NULL, "rows", room + 1, 1, &out));
    const int64_t got = gp_stream_read(s, in, bytes, z->at);
    if (got < 0)
        st = GP_ERR_IO;
    else if ((uint64_t) got < bytes ||
             (libdeflate_zlib_decompress(d, in, bytes, out, z->size, NULL) &&
              (z->or_size == z->size ||
               libdeflate_zlib_decompress(d, in, bytes, out, z->or_size, NULL))))
        st = GP_ERR_DATA;
out:
    gp_free(out);
    gp_free(in);
    return st;
}

static gp_status unpack_one(void *ctx, int i, int thread)
{
    (void) thread;
    const struct job *j = ctx;
    struct libdeflate_decompressor *const d = libdeflate_alloc_decompressor();
    const gp_status st = d ? unpack(j->s, &j->zip[i], d) : GP_ERR_BUG;
    if (d)
        libdeflate_free_decompressor(d);
    return st;
}

gp_status gp_whole_zip(const struct gp_stream *s, const struct gp_zip *zip,
                       int n, int *failed)
{
    struct job j = {s, zip};
    return gp_parallel(n, unpack_one, &j, failed);
}
