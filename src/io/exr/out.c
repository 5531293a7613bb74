#include "io/exr/exr_priv.h"

#include "core/memory.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

gp_status gp_exr_out_begin(const struct gp_log *log, struct gp_file *file,
                           const void *header, size_t size, const int *chunks,
                           int parts, struct gp_exr_out *out)
{
    gp_status st;
    void *mem;
    const char *what = gp_file_path(file);
    *out = (struct gp_exr_out) {.log = log, .file = file};
    GP_TRY(gp_alloc_zero(log, what, (size_t) parts, sizeof *out->table, &mem));
    out->table = mem;
    out->parts = parts;
    uint32_t version;
    memcpy(&version, (const uint8_t *) header + 4, 4);
    out->multipart = version & GP_EXR_MULTIPART;
    GP_TRY(gp_file_write(file, header, size));
    for (int p = 0; p < parts; p++) {
        struct gp_exr_table *t = &out->table[p];
        const size_t n = (size_t) chunks[p];
        GP_TRY(gp_alloc_zero(log, what, n, sizeof *t->offset, &mem));
        t->offset = mem;
        t->chunks = chunks[p];
        t->at = gp_file_size(file);
        GP_TRY(gp_file_write(file, t->offset, n * sizeof *t->offset));
    }
    return GP_OK;
out:
    gp_exr_out_free(out);
    return st;
}

gp_status gp_exr_out_scanlines(struct gp_exr_out *out, int part, int index,
                               int y, const void *data, size_t size)
{
    const int32_t leader[3] = {part, y, (int32_t) size};
    const int skip = out->multipart ? 0 : 1; // part numbers only where needed
    out->table[part].offset[index] = gp_file_size(out->file);
    gp_status st = gp_file_write(out->file, leader + skip,
                                 sizeof leader - (size_t) skip * 4);
    return st ? st : gp_file_write(out->file, data, size);
}

gp_status gp_exr_out_end(struct gp_exr_out *out)
{
    for (int p = 0; p < out->parts; p++) {
        const struct gp_exr_table *t = &out->table[p];
        for (int i = 0; i < t->chunks; i++) {
            if (t->offset[i] == 0)
                return gp_fail(out->log, GP_ERR_BUG,
                               "%s: chunk %d of part %d was not written",
                               gp_file_path(out->file), i, p);
        }
        gp_status st = gp_file_patch(out->file, t->at, t->offset,
                                     (size_t) t->chunks * sizeof *t->offset);
        if (st)
            return st;
    }
    return GP_OK;
}

void gp_exr_out_free(struct gp_exr_out *out)
{
    for (int p = 0; out->table && p < out->parts; p++)
        gp_free(out->table[p].offset);
    gp_free(out->table);
    *out = (struct gp_exr_out) {0};
}

// -- chunks of the input, as they are -----------------------------------------

/* One chunk of the input: its number in the table and where it stands. */
struct place {
    uint64_t offset;
    int index;
};

static int by_offset(const void *a, const void *b)
{
    const struct place *p = a, *q = b;
    if (p->offset != q->offset)
        return p->offset < q->offset ? -1 : 1;
    return p->index - q->index;
}

/* The part's offset table, sorted by where the chunks are. */
static gp_status read_places(const struct gp_exr_out *out, int part,
                             const struct gp_input *in, struct place *place)
{
    const int n = out->table[part].chunks;
    void *offset;
    gp_status st = gp_alloc(out->log, "offset table", (size_t) n,
                            sizeof(uint64_t), &offset);
    if (!st && !gp_exr_offsets_read(in, part, 0, n, offset))
        st = GP_ERR_DATA;
    for (int i = 0; !st && i < n; i++)
        place[i] = (struct place) {((uint64_t *) offset)[i], i};
    gp_free(offset);
    if (!st)
        qsort(place, (size_t) n, sizeof *place, by_offset);
    return st;
}

/* Copies `size` bytes at `at`, a block at a time. */
static gp_status copy_bytes(const struct gp_exr_out *out,
                            const struct gp_input *o, uint64_t at,
                            uint64_t size, void *block, size_t room)
{
    while (size > 0) {
        const size_t n = size < room ? (size_t) size : room;
        if (gp_exr_read_bytes(&o->stream, block, n, at) != (int64_t) n)
            return GP_ERR_DATA;
        gp_status st = gp_file_write(out->file, block, n);
        if (st)
            return st;
        at += n;
        size -= n;
    }
    return GP_OK;
}

gp_status gp_exr_out_copy(struct gp_exr_out *out, int part, const char *path,
                          const struct gp_input *in)
{
    enum { BLOCK_BYTES = 1 << 18 };
    gp_status st;
    struct gp_exr_table *t = &out->table[part];
    void *block = NULL, *mem = NULL;
    GP_TRY(gp_alloc(out->log, path, BLOCK_BYTES, 1, &block));
    GP_TRY(gp_alloc(out->log, path, (size_t) t->chunks, sizeof(struct place),
                    &mem));
    const struct place *place = mem;
    gp_exr_fault_clear();
    st = read_places(out, part, in, mem);
    for (int i = 0; !st && i < t->chunks; i++) {
        const uint64_t at = place[i].offset;
        const uint64_t size = gp_exr_chunk_bytes(in, part, at);
        t->offset[place[i].index] = gp_file_size(out->file);
        st = size && at + size <= in->stream.size
                 ? copy_bytes(out, in, at, size, block, BLOCK_BYTES)
                 : GP_ERR_DATA;
    }
    if (st == GP_ERR_DATA && gp_exr_fault())
        st = gp_exr_fault_print(out->log, path, gp_exr_fault());
    else if (st == GP_ERR_DATA)
        (void) gp_fail(out->log, st,
                       "%s: part %d is cut off or damaged; copy or render the "
                       "file again, or give --hdr a file without it", path,
                       part);
out:
    gp_free(mem);
    gp_free(block);
    return st;
}
