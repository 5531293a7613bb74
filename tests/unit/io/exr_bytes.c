// SPDX-License-Identifier: Apache-2.0
/* io/exr/open.c: the bytes of a header are bounded and indexed, a
 * value that is none of its type is refused whatever its name and part, nothing
 * that OpenEXR reads is; and where a file ends inside a longer stream. */
#include "unit.h"
#include "io/exr/exr_priv.h"
#include "exr_fixture.h"
#include "reading.h"

/* A file of these bytes; its header is whole. */
static struct gp_input *open_bytes(const void *bytes, size_t size)
{
    struct gp_stream s = gp_stream_of(bytes, size);
    struct gp_input *in;
    assert_ok(gp_exr_open(&kept_log, "a.exr", &s, &in));
    return in;
}

/* Types of one size, as OpenEXR's sources have them. */
static const struct {
    const char *type;
    size_t size;
} fixed[] = {
    {"box2f", 16}, {"box2i", 16}, {"chromaticities", 32}, {"compression", 1},
    {"deepImageState", 1}, {"double", 8}, {"envmap", 1}, {"float", 4},
    {"int", 4}, {"lineOrder", 1}, {"m33d", 72}, {"m33f", 36}, {"m44d", 128},
    {"m44f", 64}, {"rational", 8}, {"tiledesc", 9}, {"timecode", 8},
    {"v2d", 16}, {"v2f", 8}, {"v2i", 8}, {"v3d", 24}, {"v3f", 12}, {"v3i", 12},
};

static const struct fixture two_parts = {
    .parts = 2, .part = {{.name = "a", .channel = {RGB(HALVES)}, .data = W(5)},
             {.name = "b", .channel = {HALF_CH("Z")}, .data = W(3)}},
};

/* Writes `f` with one more attribute at the end of a part's header. */
static void write_with(const struct fixture *f, int part, const char name[5],
                       const char *type, const void *value, uint32_t size)
{
    size_t all;
    uint8_t *bytes = fixture_make(f, &all), head[64];
    struct gp_input *const in = open_bytes(bytes, all);
    const size_t at = in->each[part].to - 1;
    const size_t named = sizeof "shot" + strlen(type) + 1, more = named + 4;
    snprintf((char *) head, sizeof head, "%s%c%s", name, 0, type);
    memcpy(head + named, &size, 4);
    uint64_t offset, last = UINT64_MAX; // the tables end where chunks begin
    for (size_t i = in->index->tables; i < last; i += sizeof offset) {
        memcpy(&offset, bytes + i, sizeof offset);
        last = offset < last ? offset : last;
        offset += more + size;
        memcpy(bytes + i, &offset, sizeof offset);
    }
    bytes = realloc(bytes, all + more + size);
    assert_non_null(bytes);
    memmove(bytes + at + more + size, bytes + at, all - at);
    memcpy(bytes + at, head, more);
    memcpy(bytes + at + more, value, size);
    fixture_save(path, bytes, all + more + size);
    gp_input_free(in);
    free(bytes);
}

static void assert_read_or_not(bool good)
{
    struct gp_frame frame;
    if (!good) {
        assert_refused(path, GP_ERR_DATA, "shot");
        return;
    }
    assert_ok(read_file(path, &frame));
    gp_frame_free(&frame);
}

#define LIST(text) text, sizeof text - 1
#define CHANNEL "\1\0\0\0\0\0\0\0\1\0\0\0\1\0\0\0"
static const struct {
    const char *type, *bytes;
    uint32_t size;
    bool good;
} lists[] = {
    {"preview", LIST("\0\0\0\0\0\0\0\0"), true},
    {"preview", LIST("\1\0\0\0\1\0\0\0abcd"), true},
    {"preview", LIST("\1\0\0\0\1\0\0\0abc"), false},
    {"preview", LIST("\1\0\0\0\1\0\0\0abcde"), false},
    {"preview", LIST("\xff\xff\0\0\xff\xff\0\0"), false},
    {"preview", LIST("\0\0\1\0\0\0\1\0"), false},
    {"preview", LIST("\0\0\0"), false},
    {"stringvector", "", 0, true},
    {"stringvector", LIST("\3\0\0\0abc\1\0\0\0d"), true},
    {"stringvector", LIST("\3\0\0\0ab"), false},
    {"stringvector", LIST("\3\0\0\0abcd"), false},
    {"stringvector", LIST("\xff\xff\xff\xff"), false},
    {"chlist", LIST("R\0" CHANNEL "\0"), true},
    {"chlist", "", 0, false},
    {"chlist", LIST("\0\0"), false},
    {"chlist", LIST("R\0" CHANNEL "\0\0"), false},
    {"chlist", LIST("R\0" CHANNEL "G"), false},
    {"chlist", LIST("R\0abc"), false},
    {"floatvector", LIST("abcd"), true},
    {"floatvector", LIST("abcde"), false},
    {"idmanifest", LIST("12345678"), true},
    {"idmanifest", LIST("1234567"), false},
    {"mine", LIST("\5\0\0\0abc"), true},
};

static void files(void **state)
{
    static const uint8_t bytes[200] = {0};
    static const struct fixture one = {
        .part = {{.channel = {RGB(HALVES)}, .data = W(3)}},
    };
    in_folder("shot.exr");
    for (size_t i = 0; i < COUNT(fixed); i++) {
        const char *const type = fixed[i].type;
        const uint32_t size = (uint32_t) fixed[i].size;
        const uint32_t tried[] = {0, size - 1, size, size + 1, 200};
        for (size_t k = 0; k < COUNT(tried); k++) {
            write_with(&one, 0, "shot", type, bytes, tried[k]);
            assert_read_or_not(tried[k] == size);
            for (int part = 0; part < 2; part++) {
                write_with(&two_parts, part, "shot", type, bytes, tried[k]);
                assert_read_or_not(tried[k] == size);
            }
        }
    }
    for (size_t i = 0; i < COUNT(lists); i++) {
        write_with(&two_parts, 1, "shot", lists[i].type, lists[i].bytes,
                   lists[i].size);
        assert_read_or_not(lists[i].good);
    }
    for (int i = 0; i < 14; i++) { // film codes one out of their range
        int32_t code[7] = {0, 0, 0, 0, 0, 1, 20};
        static const int32_t most[7] = {99, 99, 999999, 9999, 119, 15, 120};
        code[i / 2] = i % 2 ? most[i / 2] + 1 : code[i / 2] - 1;
        write_with(&one, 0, "shot", "keycode", code, sizeof code);
        assert_read_or_not(false);
        code[i / 2] = most[i / 2];
        write_with(&one, 0, "shot", "keycode", code, sizeof code);
        assert_read_or_not(true);
    }
    write_with(&one, 0, "\xff\x80 t", "preview", "\xff\xff\0\0\xff\xff\0\0", 8);
    assert_refused(path, GP_ERR_DATA, "'?? t'");
    write_with(&two_parts, 1, "name", "v2f", bytes, 8); // the second of it
    assert_refused(path, GP_ERR_DATA, "'name'");
}

static const uint64_t cut_off = UINT64_MAX; // or no header at all

static uint64_t end_of(const uint8_t *bytes, size_t size)
{
    struct gp_input *o;
    struct gp_stream s = gp_stream_of(bytes, size);
    const gp_status st = gp_exr_open(&kept_log, "a.exr", &s, &o);
    if (st) {
        assert_int_equal(st, GP_ERR_DATA);
        assert_kept("a.exr: ");
        return cut_off;
    }
    const uint64_t end = o->end;
    assert_true(end <= size);
    gp_input_free(o);
    return end;
}

static void ends(void **state)
{
    static const struct fixture row[] = {
        {.part = {{.channel = {RGB(HALVES)}, .data = W(40),
                   .compression = EXR_COMPRESSION_ZIPS}}},
        {.part = {{.channel = {RGB(HALVES)}, .data = W(40), .tile = 16}}},
        {.part = {{.channel = {RGB(HALVES)}, .data = W(20), .tile = 8,
                   .mipmap = true}}},
        {.part = {{.channel = {HALF_CH("Z")}, // more rows than one block
                   .data = FIXTURE_WINDOW(0, 0, 1, 1100)}}},
        {.parts = 2, .part = {{.name = "a", .channel = {RGB(HALVES)},
                               .data = W(5)},
                              {.name = "b", .channel = {HALF_CH("Z")},
                               .data = W(9), .tile = 4}}},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        size_t size;
        uint8_t *bytes = fixture_make(&row[i], &size);
        bytes = realloc(bytes, size + 100);
        assert_non_null(bytes);
        memset(bytes + size, 7, 100); // another file behind it
        assert_int_equal(end_of(bytes, size + 100), size);
        // whatever part or level the last bytes are of
        for (size_t n = 1; n < size; n++)
            assert_int_equal(end_of(bytes, n), cut_off);
        assert_kept("truncated (");
        free(bytes);
    }
}

/* A deep file of one row: its header, its table, a chunk of `table` and
 * `samples` bytes. */
static uint64_t deep_end(uint64_t table, uint64_t samples, bool written,
                         size_t *whole)
{
    static const struct fixture deep = {
        .part = {{.channel = {HALF_CH("Z")}, .data = FIXTURE_WINDOW(0, 0, 4, 1),
                  .deep = true, .compression = EXR_COMPRESSION_ZIPS}},
    };
    size_t size;
    uint8_t *made = fixture_make(&deep, &size), bytes[4096] = {0};
    assert_true(size < 2048);
    memcpy(bytes, made, size);
    free(made);
    struct gp_input *const in = open_bytes(bytes, sizeof bytes);
    const uint64_t tables = in->index->tables, chunk = tables + 8;
    const uint64_t sizes[3] = {table, samples, samples};
    gp_input_free(in);
    if (written)
        memcpy(bytes + tables, &chunk, 8);
    memcpy(bytes + chunk + 4, sizes, sizeof sizes);
    *whole = chunk + 28 + table + samples;
    return end_of(bytes, sizeof bytes);
}

static void deep_ends(void **state)
{
    size_t whole;
    const uint64_t end = deep_end(16, 40, true, &whole);
    assert_int_equal(end, whole);
    // never written, behind the stream, and sums that wrap around
    assert_int_equal(deep_end(16, 40, false, &whole), 0);
    assert_int_equal(deep_end(16, 1 << 20, true, &whole), cut_off);
    assert_int_equal(deep_end(UINT64_MAX, 40, true, &whole), 0);
    assert_int_equal(deep_end(UINT64_MAX - 39, 39, true, &whole), 0);
}

/* Offset tables that were never written are found in the chunks, where these are
 * all there, each once, and nothing is left over. */
static void tables_never_written(void **state)
{
    static const struct {
        struct fixture file;
        bool found;
    } row[] = {
        {{.part = {{.channel = {RGB(HALVES)},
                    .data = W(40),
                    .compression = EXR_COMPRESSION_ZIP}}},
         true},
        {{.part = {{.channel = {HALF_CH("Y")},
                    .data = FIXTURE_WINDOW(-9, -7, 1, 5),
                    .compression = EXR_COMPRESSION_NONE}}},
         true},
        {{.part = {{.channel = {RGB(FLOATS)},
                    .data = W(40),
                    .tile = 16,
                    .compression = EXR_COMPRESSION_PIZ}}},
         true},
        {{.parts = 2,
          .part = {{.name = "a", .channel = {RGB(HALVES)}, .data = W(20)},
                   {.name = "b",
                    .channel = {HALF_CH("Z")},
                    .data = W(33),
                    .tile = 8}}},
         true},
        {{.part = {{.channel = {RGB(HALVES)},
                    .data = W(40),
                    .tile = 16,
                    .mipmap = true}}},
         false},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        size_t size;
        uint8_t *const bytes = fixture_make(&row[i].file, &size);
        struct gp_input *in = open_bytes(bytes, size);
        const struct gp_exr_index *const index = in->index;
        const uint64_t tables = index->tables, n = index->chunks;
        uint64_t *const own = malloc(8 * n);
        assert_non_null(own);
        gp_input_free(in);
        memcpy(own, bytes + tables, 8 * n);
        memset(bytes + tables + 8, 0, 8 * (n - 1)); // but for the first
        in = open_bytes(bytes, size);
        assert_int_equal(in->end, row[i].found ? size : 0);
        if (row[i].found) {
            assert_memory_equal(in->index->offset, own, 8 * n);
            assert_non_null(strstr(kept_warning, "incomplete"));
        }
        gp_input_free(in);
        // the last chunk a byte short; the second in place of the last
        assert_int_equal(end_of(bytes, size - 1), 0);
        if (row[i].file.parts ==
            2) { // b's first tile is a's row 19, and that 20
            const int32_t past = 20, taken[3] = {0, 19, 12 + 2 * 8 * 8};
            memcpy(bytes + own[19] + 4, &past, sizeof past);
            memcpy(bytes + own[20], taken, sizeof taken);
            assert_int_equal(end_of(bytes, size), 0);
        } else if (row[i].file.part[0].compression == EXR_COMPRESSION_NONE) {
            memcpy(bytes + own[n - 1], bytes + own[1], 4);
            assert_int_equal(end_of(bytes, size), 0);
        }
        if (row[i].file.part[0].tile == 16) { // the fourth beside the third
            const int32_t beside[2] = {3, 0};
            memcpy(bytes + own[3], beside, sizeof beside);
            assert_int_equal(end_of(bytes, size), 0);
        }
        fixture_save(path, bytes, size);
        free(bytes);
        free(own);
    }
}

SUITE_OF(exr_bytes, make_folder, remove_folder, files, ends, deep_ends,
         tables_never_written)
