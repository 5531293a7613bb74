/* Maya's IFF that is not all there, or is not what its reader expects. */
#include "unit.h"
#include "write_fixture.h"

#include "io/whole.h"

/* A picture of 6 x 2 in two tiles of 3 x 2: the first has runs, the second its
 * bytes as they are. What is 0 is as in a whole one. */
struct shape {
    const char *name;
    uint32_t flags, deep, tiles, x, y, w;    // deep: 16 bits
    uint32_t head;                           // its size
    const char *kind, *inner, *between;      // types of chunks
    uint32_t x1;                             // where the first tile ends
    uint32_t runs;                           // of its first plane
    const char *said;                        // NULL: it is whole
};

static uint8_t bytes[512];
static size_t size;

static void put(uint32_t v, int n)
{
    while (n-- > 0)
        bytes[size++] = (uint8_t) (v >> 8 * n);
}

static void put_type(const char *type)
{
    memcpy(bytes + size, type, 4);
    size += 4;
}

static uint32_t or(uint32_t v, uint32_t otherwise)
{
    return v ? v : otherwise;
}

static void put_place(uint32_t x0, uint32_t x1)
{
    put(x0, 2);
    put(0, 2);
    put(x1, 2);
    put(1, 2);
}

/* Chunks end at each four bytes. */
static void end_chunk(size_t start)
{
    const size_t n = size - start, end = start + (n + 3) / 4 * 4;
    size = start - 4;
    put((uint32_t) n, 4);
    size = end;
}

static void put_tiles(const struct shape *s)
{
    const int planes = (s->flags & 2 ? 4 : 3) * (s->deep ? 2 : 1);
    put_type("RGBA");
    put(0, 4);
    size_t start = size;
    put_place(0, or(s->x1, 2));
    for (int i = 0; i < planes; i++) {
        put(0x80 | (or(i == 0 ? s->runs : 0, 6) - 3), 1); // but two
        put(7, 1);
        put(1, 1); // two as they are
        put(0x0809, 2);
    }
    end_chunk(start);
    if (s->between) {
        put_type(s->between);
        put(4, 4);
        put(0, 4);
    }
    put_type("RGBA");
    put(0, 4);
    start = size;
    put_place(3, 5);
    for (int i = 0; i < planes * 6; i++)
        put(3, 1);
    end_chunk(start);
}

static void make(const struct shape *s)
{
    memset(bytes, 0, sizeof bytes);
    size = 0;
    put_type("FOR4");
    put(0, 4);
    put_type(s->kind ? s->kind : "CIMG");
    put_type("ANNO"); // passed over
    put(5, 4);
    size += 8;
    put_type("TBHD");
    put(or(s->head, 32), 4);
    const size_t head = size;
    put(or(s->w, 6), 4);
    put(2, 4);
    put(0x00010001, 4);
    put(or(s->flags, 1), 4);
    put(s->deep, 2);
    put(or(s->tiles, 2), 2);
    put(1, 4);
    put(s->x, 4);
    put(s->y, 4);
    size = head + or(s->head, 32);
    put_type("FOR4");
    put(0, 4);
    const size_t inner = size;
    put_type(s->inner ? s->inner : "TBMP");
    put_tiles(s);
    end_chunk(inner);
    const size_t end = size;
    size = 4;
    put((uint32_t) end - 8, 4);
    size = end;
}

static gp_status check(size_t n, long long max_pixels)
{
    const struct gp_stream s = {
        .fd = -1, .data = bytes, .size = n, .borrowed = true,
    };
    wf_line[0] = '\0';
    return gp_whole_check(&wf_log, "in", &s, 0, max_pixels);
}

static const struct shape shapes[] = {
    {"RGB", .flags = 1},
    {"RGBA", .flags = 3},
    {"16 bits", .flags = 3, .deep = 1},
    {"without an origin", .head = 24},
    {"no colours", .flags = 4, .said = "it has no colours"},
    {"alpha alone", .flags = 2, .said = "it has no colours"},
    {"origin", .x = 1, .said = "its origin is not 0,0"},
    {"origin below", .y = 1, .said = "its origin is not 0,0"},
    {"head", .head = 28, .said = "its head has another size"},
    {"kind", .kind = "ILBM", .said = "it is an IFF of another kind"},
    {"no tiles", .inner = "TBMQ", .said = "it has no tiles"},
    {"depth", .between = "ZBUF", .said = "a chunk between its tiles"},
    {"one tile", .tiles = 1, .said = "not the picture's area"},
    {"three tiles", .tiles = 3, .said = "ends in its pixels"},
    {"narrow", .w = 5, .said = "lies outside of the picture"},
    {"wide", .w = 7, .said = "not the picture's area"},
    {"tile outside", .x1 = 6, .said = "lies outside of the picture"},
    {"runs over the end", .runs = 7, .said = "unpack to its rows"},
    {"runs that lack", .runs = 5, .said = "unpack to its rows"},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static void every_shape(void **state)
{
    (void) state;
    for (int i = 0; i < SHAPES; i++) {
        const struct shape *const s = &shapes[i];
        make(s);
        if (check(size, 14) != (s->said ? GP_ERR_DATA : GP_OK))
            fail_msg("%s: %s", s->name, wf_line);
        if (s->said)
            wf_assert_said(s->said);
    }
}

/* A picture that is refused later is not looked through. */
static void too_large(void **state)
{
    (void) state;
    make(&shapes[SHAPES - 1]);
    assert_int_equal(check(size, 12), GP_ERR_DATA);
    assert_int_equal(check(size, 11), GP_OK);
}

static void every_end(void **state)
{
    (void) state;
    make(&shapes[1]);
    for (size_t n = 4; n < size; n++) {
        if (check(n, 12) != GP_ERR_DATA)
            fail_msg("%zu of %zu bytes", n, size);
    }
    assert_int_equal(check(3, 12), GP_OK); // begins otherwise
}

/* Any byte may hold anything: an answer, and no read outside the bytes. */
static void every_byte(void **state)
{
    (void) state;
    static const uint8_t hard[] = {0, 1, 7, 0x7f, 0x80, 0xff};
    for (int i = 0; i < SHAPES; i++) {
        make(&shapes[i]);
        uint8_t *const own = malloc(size);
        assert_non_null(own);
        memcpy(own, bytes, size);
        const struct gp_stream s = {
            .fd = -1, .data = own, .size = size, .borrowed = true,
        };
        for (size_t k = 0; k < size * sizeof hard; k++) {
            own[k / sizeof hard] = hard[k % sizeof hard];
            wf_line[0] = '\0';
            const gp_status st = gp_whole_check(&wf_log, "in", &s, 0, 12);
            assert_true(st == GP_OK || st == GP_ERR_DATA);
            assert_int_equal(st != GP_OK, wf_line[0] != '\0');
            own[k / sizeof hard] = bytes[k / sizeof hard];
        }
        free(own);
    }
}

/* A tile whose size no 32 bits hold. */
static void huge_tile(void **state)
{
    (void) state;
    make(&shapes[0]);
    static const uint8_t wide[4] = {0, 1, 0, 0};
    memcpy(bytes + 36, wide, 4);
    memcpy(bytes + 40, wide, 4);
    uint8_t *const tile = memchr(bytes + 76, 'R', size - 76);
    assert_non_null(tile);
    memset(tile + 12, 0xff, 4);
    assert_int_equal(check(size, 1LL << 40), GP_ERR_DATA);
    wf_assert_said("a tile is too large for OpenImageIO");
}

SUITE(whole_iff)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_shape), cmocka_unit_test(too_large),
        cmocka_unit_test(every_end),   cmocka_unit_test(every_byte),
        cmocka_unit_test(huge_tile),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
