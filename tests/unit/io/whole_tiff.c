/* TIFFs that are not all there, of every shape: made here, byte by byte. */
#include "unit.h"
#include "write_fixture.h"

#include "io/whole.h"
#include "io/whole_tiff.h"

enum { ROOM = 1 << 16, PART_TWO = 1 };

/* A picture of w x h samples of 8 bits, without pixels' values. */
struct shape {
    const char *name;
    bool motorola, large;
    int w, h, samples, planar;
    int rows;            // of a strip, or of a tile
    int tile;            // its width, 0 strips
    int compression;
    int packed;          // bytes of a chunk; 0: what it needs
    // what is wrong
    int drop;            // entries that the tables lack
    bool no_counts;
    const char *said;    // NULL: it is whole
};

static uint8_t bytes[ROOM];
static size_t size;

static gp_status check(size_t n, int part)
{
    const struct gp_stream s = {
        .fd = -1, .data = bytes, .size = n, .borrowed = true,
    };
    wf_line[0] = '\0';
    return gp_whole_check(&wf_log, "in", &s, part, 1 << 20);
}

static void put(const struct shape *s, size_t at, uint64_t v, int n)
{
    for (int i = 0; i < n; i++)
        bytes[at + (size_t) (s->motorola ? n - 1 - i : i)] =
            (uint8_t) (v >> 8 * i);
}

static size_t add(const struct shape *s, uint64_t v, int n)
{
    const size_t at = size;
    assert_true(size + (size_t) n < ROOM);
    size += (size_t) n;
    put(s, at, v, n);
    return at;
}

static void entry(const struct shape *s, int tag, int type, uint64_t count,
                  uint64_t v)
{
    const int wide = s->large ? 8 : 4;
    add(s, (uint64_t) tag, 2);
    add(s, (uint64_t) type, 2);
    add(s, count, wide);
    // a value that is shorter than its place stands on the left
    const int n = type == 3 && count == 1 ? 2 : wide;
    add(s, v, n);
    size += (size_t) (wide - n);
}

/* Chunks, their tables, and a directory; returns where its `next` is. */
static size_t directory(const struct shape *s, size_t link)
{
    const int wide = s->large ? 8 : 4;
    const int across = s->tile ? (s->w + s->tile - 1) / s->tile : 1;
    const int down = (s->h + s->rows - 1) / s->rows;
    const int chunks = across * down * (s->planar == 2 ? s->samples : 1);
    const int row = (s->tile ? s->tile : s->w) *
                    (s->planar == 2 ? 1 : s->samples);
    size_t at[256], n[256];
    assert_true(chunks <= 256);
    for (int i = 0; i < chunks; i++) {
        const int left = s->h - i % down * s->rows;
        const int rows = s->tile || left > s->rows ? s->rows : left;
        at[i] = size;
        n[i] = (size_t) (s->packed ? s->packed : row * rows);
        size += n[i];
    }
    const size_t offsets = size;
    for (int i = 0; i < chunks; i++)
        add(s, at[i], wide);
    const size_t counts = size;
    for (int i = 0; i < chunks; i++)
        add(s, n[i], wide);
    put(s, link, size, wide);
    const uint64_t listed = (uint64_t) (chunks - s->drop);
    const int type = s->large ? 16 : 4;
    add(s, (uint64_t) (9 + (s->tile ? 1 : 0) + (s->no_counts ? 0 : 1)),
        s->large ? 8 : 2);
    entry(s, 256, 3, 1, (uint64_t) s->w);
    entry(s, 257, 4, 1, (uint64_t) s->h << (s->motorola && s->large ? 32 : 0));
    entry(s, 258, 3, 1, 8);
    entry(s, 259, 3, 1, (uint64_t) s->compression);
    entry(s, 262, 3, 1, 1);
    if (!s->tile)
        entry(s, 273, type, listed, listed > 1 ? offsets : at[0]);
    entry(s, 277, 3, 1, (uint64_t) s->samples);
    if (!s->tile)
        entry(s, 278, 3, 1, (uint64_t) s->rows);
    if (!s->tile && !s->no_counts)
        entry(s, 279, type, listed, listed > 1 ? counts : n[0]);
    entry(s, 284, 3, 1, (uint64_t) s->planar);
    if (s->tile) {
        entry(s, 322, 3, 1, (uint64_t) s->tile);
        entry(s, 323, 3, 1, (uint64_t) s->rows);
        entry(s, 324, type, listed, listed > 1 ? offsets : at[0]);
        entry(s, 325, type, listed, listed > 1 ? counts : n[0]);
    }
    return add(s, 0, wide);
}

/* Returns where the link to a next directory is. */
static size_t make(const struct shape *s)
{
    memset(bytes, 0, sizeof bytes);
    memcpy(bytes, s->motorola ? "MM" : "II", 2);
    put(s, 2, s->large ? 43 : 42, 2);
    if (s->large)
        put(s, 4, 8, 2);
    size = s->large ? 16 : 8;
    return directory(s, s->large ? 8 : 4);
}

static const struct shape shapes[] = {
    {"strips", 0, 0, 20, 13, 3, 1, 4, 0, 1, 0, 0, 0, NULL},
    {"one strip", 0, 0, 20, 13, 3, 1, 13, 0, 1, 0, 0, 0, NULL},
    {"planes", 1, 0, 20, 13, 3, 2, 4, 0, 1, 0, 0, 0, NULL},
    {"tiles", 0, 0, 40, 33, 3, 1, 16, 16, 1, 0, 0, 0, NULL},
    {"big", 0, 1, 20, 13, 3, 1, 4, 0, 1, 0, 0, 0, NULL},
    {"big motorola tiles", 1, 1, 40, 33, 3, 1, 16, 16, 1, 0, 0, 0, NULL},
    {"no counts", 0, 0, 20, 13, 3, 1, 4, 0, 1, 0, 0, 1, NULL},
    // libtiff finds the length of a lone strip itself
    {"wrong count", 0, 0, 20, 13, 3, 1, 13, 0, 1, 900, 0, 0, NULL},
    {"packed", 0, 0, 20, 13, 3, 1, 4, 0, 5, 7, 0, 0, NULL},
    {"tile planes", 0, 0, 40, 33, 2, 2, 16, 16, 5, 9, 0, 0, NULL},
    {"many strips", 0, 0, 1, 250, 1, 1, 1, 0, 1, 0, 0, 0, NULL},

    {"short table", 0, 0, 20, 13, 3, 1, 4, 0, 1, 0, 1, 0, "too short"},
    {"short tile table", 1, 1, 40, 33, 3, 1, 16, 16, 1, 0, 1, 0, "too short"},
    {"short strips", 0, 0, 20, 13, 3, 1, 4, 0, 1, 59, 0, 0, "for its rows"},
    {"too dense", 0, 0, 60000, 100, 3, 1, 50, 0, 8, 100, 0, 0, "for its rows"},
    {"too dense LZW", 0, 0, 60000, 100, 3, 1, 50, 0, 5, 100, 0, 0,
     "for its rows"},
    {"dense LZW", 0, 0, 60000, 2, 3, 1, 1, 0, 5, 100, 0, 0, NULL},
    {"too dense PackBits", 0, 0, 60000, 2, 3, 1, 1, 0, 32773, 100, 0, 0,
     "for its rows"},
    {"huge", 1, 0, 65535, 65000, 1, 1, 32500, 0, 1, 20, 0, 0, "for its rows"},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static void every_shape(void **state)
{
    (void) state;
    for (int i = 0; i < SHAPES; i++) {
        const struct shape *const s = &shapes[i];
        make(s);
        if (check(size, 0) != (s->said ? GP_ERR_DATA : GP_OK))
            fail_msg("%s: %s", s->name, wf_line);
        if (s->said)
            wf_assert_said(s->said);
    }
}

/* The directory is last: any end before the link behind it is found. So are
 * the ends of a file whose directory comes first. */
static void every_end(void **state)
{
    (void) state;
    for (int i = 0; i < SHAPES; i++) {
        make(&shapes[i]);
        const size_t link = shapes[i].large ? 8 : 4;
        for (size_t n = 8; !shapes[i].said && n < size - link; n++) {
            if (check(n, 0) != GP_ERR_DATA)
                fail_msg("%s: %zu of %zu bytes", shapes[i].name, n, size);
        }
    }
}

/* Any byte may hold anything: an answer, and no read outside the bytes. */
static void every_byte(void **state)
{
    (void) state;
    static const uint8_t hard[] = {0, 1, 0x7f, 0x80, 0xff};
    for (int i = 0; i < SHAPES; i++) {
        make(&shapes[i]);
        for (size_t k = 0; k < size && size < 6000; k++) {
            const uint8_t was = bytes[k];
            for (size_t j = 0; j < sizeof hard; j++) {
                bytes[k] = hard[j];
                const gp_status st = check(size, 0);
                assert_true(st == GP_OK || st == GP_ERR_DATA);
                assert_int_equal(st != GP_OK, wf_line[0] != '\0');
            }
            bytes[k] = was;
        }
    }
}

/* A second directory is looked at when it is asked for, a loop of them as
 * often as it is walked, and what has no picture is the bridge's business. */
static void parts(void **state)
{
    (void) state;
    struct shape first = shapes[0], second = shapes[13];
    const size_t link = make(&first);
    second.motorola = first.motorola;
    directory(&second, link);
    assert_int_equal(check(size, 0), GP_OK);
    assert_int_equal(check(size, PART_TWO), GP_ERR_DATA);
    assert_int_equal(check(size, PART_TWO + 1), GP_OK); // not there
    put(&first, link, ROOM - 1, 4);
    assert_int_equal(check(size, 0), GP_OK);
    assert_int_equal(check(size, PART_TWO), GP_ERR_DATA);
    make(&first);
    memcpy(bytes + link, bytes + 4, 4); // its own next
    assert_int_equal(check(size, 99999), GP_OK);
    make(&first);
    for (size_t i = size - 4 - 12 * 10; i < size - 4; i += 12)
        bytes[i] = bytes[i + 1] = 0; // no tag that is known
    assert_int_equal(check(size, 0), GP_OK);
}

/* A strip without an offset, and one without bytes: sparse, as some geographic
 * files are. */
static void sparse(void **state)
{
    (void) state;
    for (int i = 0; i < 2; i++) {
        make(&shapes[0]);
        const size_t table = 8 + 20 * 13 * 3;
        memset(bytes + table + 4 + (size_t) i * 16, 0, 4);
        assert_int_equal(check(size, 0), GP_ERR_DATA);
        wf_assert_said("strip 1 has no data");
    }
}

/* Writes a field's one value, in a file of Intel's order and short offsets. */
static void set_field(int tag, uint32_t v)
{
    const struct shape intel = {0};
    uint32_t at;
    memcpy(&at, bytes + 4, sizeof at);
    const int n = bytes[at];
    for (int i = 0; i < n; i++) {
        const size_t e = at + 2 + 12 * (size_t) i;
        if ((bytes[e] | bytes[e + 1] << 8) != tag)
            continue;
        put(&intel, e + 2, 4, 2);
        put(&intel, e + 4, 1, 4);
        put(&intel, e + 8, v, 4);
        return;
    }
    fail_msg("no field %d", tag);
}

/* Claims out of any measure: nobody's arithmetic overflows, and what is not
 * known is left to the reader. */
static void hard_claims(void **state)
{
    (void) state;
    enum { STRIPS = 0, ONE = 1, TILES = 3, PACKED = 8, PLANES = 9, SHORT = 13 };
    static const uint32_t far = 1u << 31, most = (1u << 31) - 1;
    const struct {
        int shape;
        uint32_t field[7][2];
        const char *said;
    } row[] = {
        {STRIPS, {{256, far}}, NULL},
        {STRIPS, {{257, far}}, NULL},
        {STRIPS, {{256, 0}}, NULL},
        {STRIPS, {{258, 65}}, NULL},
        {STRIPS, {{259, 6}}, NULL},
        {STRIPS, {{277, 65536}}, NULL},
        {STRIPS, {{277, 0}}, NULL},
        {STRIPS, {{278, 0}}, NULL},
        {STRIPS, {{278, UINT32_MAX}}, NULL}, // all in the first
        {STRIPS, {{278, 14}}, NULL},
        {STRIPS, {{256, 30000}}, "too short for its rows"},
        {STRIPS, {{257, 17}}, "a table of strips that is too short"},
        {ONE, {{279, 0}}, NULL},             // its size is known
        {ONE, {{279, 0}, {259, 5}}, "has no data"},
        {ONE, {{273, 7}}, "has no data"},
        {ONE, {{273, 0x7fffffff}}, "ends behind the end"},
        {ONE, {{256, most}, {257, most}, {278, most}}, "ends behind the end"},
        {SHORT, {{262, 6}}, NULL},           // YCbCr may have fewer samples
        {PACKED, {{262, 6}}, NULL},
        {PACKED, {{262, 6}, {256, 4000000}}, "too short for its rows"},
        {TILES, {{322, far}}, NULL},
        {TILES, {{323, far}}, "too short for its rows"},
        {PLANES, {{322, 1}, {323, 1}, {256, most}, {257, most},
                  {277, 65535}}, "a table of tiles that is too short"},
        {TILES, {{322, most}, {323, most}, {258, 64}, {277, 65535},
                 {256, 1}, {257, 1}}, "ends behind the end"},
        {TILES, {{322, most}, {323, most}, {258, 64}, {277, 65535},
                 {259, 32773}, {256, 1}, {257, 1}}, "too short for its rows"},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        make(&shapes[row[i].shape]);
        for (int k = 0; k < 7 && row[i].field[k][0]; k++)
            set_field((int) row[i].field[k][0], row[i].field[k][1]);
        if (check(size, 0) != (row[i].said ? GP_ERR_DATA : GP_OK))
            fail_msg("row %d: %s", (int) i, wf_line);
        if (row[i].said)
            wf_assert_said(row[i].said);
    }
}

/* Values that nobody asks for, last in the file. Five bytes or more do not fit
 * into the entry; what is no type has no values. */
static void unread_values(void **state)
{
    (void) state;
    static const int bytes_of[20] = {
        0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8, 0,
    };
    static const struct shape plain = {.name = "a text"};
    for (int type = 0; type < 20; type++) {
        memset(bytes, 0, sizeof bytes);
        memcpy(bytes, "II*\0\10", 5);
        size = 8;
        add(&plain, 1, 2);
        entry(&plain, 305, type, 5, 26); // Software
        add(&plain, 0, 4);
        size += 5 * (size_t) bytes_of[type];
        assert_int_equal(check(size, 0), GP_OK);
        if (!bytes_of[type])
            continue;
        assert_int_equal(check(size - 1, 0), GP_ERR_DATA);
        wf_assert_said("a field's values start at 26");
    }
}

/* Where a part is looked for: no link behind the last directory, one that
 * leads nowhere, and a file that nobody reads any more. */
static void lost_directories(void **state)
{
    (void) state;
    const struct gp_stream closed = {.fd = -1, .size = 1000};
    make(&shapes[0]);
    assert_int_equal(check(size - 4, PART_TWO), GP_OK);
    assert_string_equal(wf_line, "");
    put(&shapes[0], 4, ROOM, 4);
    assert_int_equal(check(size, PART_TWO), GP_ERR_DATA);
    wf_assert_said("a directory at 65536");
    assert_int_equal(gp_whole_tiff(&wf_log, "in", &closed, 0, 1 << 20),
                     GP_ERR_IO);
    wf_assert_said("in: cannot be read (Bad file descriptor)");

    FILE *const file = tmpfile(); // it had 1000 bytes when it was opened
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, 8, file), 8);
    assert_int_equal(fflush(file), 0);
    const struct gp_stream shrunk = {.fd = fileno(file), .size = 1000};
    put(&shapes[0], 4, 100, 4);
    assert_int_equal(pwrite(shrunk.fd, bytes, 8, 0), 8);
    assert_int_equal(gp_whole_tiff(&wf_log, "in", &shrunk, 0, 1 << 20),
                     GP_ERR_DATA);
    wf_assert_said("in: cut off or damaged (a directory at 100 of 1000");
    fclose(file);
}

SUITE(whole_tiff)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_shape), cmocka_unit_test(every_end),
        cmocka_unit_test(every_byte),  cmocka_unit_test(parts),
        cmocka_unit_test(sparse),      cmocka_unit_test(hard_claims),
        cmocka_unit_test(unread_values), cmocka_unit_test(lost_directories),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
