/* io/exr_raw and io/exr_end: headers walked as bytes, and where a file ends
 * inside a longer stream. */
#include "unit.h"
#include "io/exr/exr_priv.h"

#include "exr_fixture.h"
#include "reading.h"

#define HALVES EXR_PIXEL_HALF
#define W(n) FIXTURE_WINDOW(0, 0, n, n)

static const struct fixture two = {
    .parts = 2,
    .part = {{.name = "a", .channel = {RGB(HALVES)}, .data = W(5)},
             {.name = "b", .channel = {HALF_CH("Z")}, .data = W(3)}},
};

static gp_status raw_of(uint8_t *bytes, size_t size, int parts,
                        struct gp_exr_raw *raw)
{
    const struct gp_input o = {
        .parts = parts,
        .stream = {.fd = -1, .data = bytes, .size = size, .borrowed = true},
    };
    heard.count = 0;
    *raw = (struct gp_exr_raw) {0};
    return gp_exr_raw_read(&hear, "a.exr", &o, raw);
}

/* Cut anywhere within the header, it is refused with one line. */
static void cut_headers(void **state)
{
    (void) state;
    size_t size;
    uint8_t *bytes = fixture_make(&two, &size);
    struct gp_exr_raw raw;
    assert_int_equal(raw_of(bytes, size, 2, &raw), GP_OK);
    const size_t header = raw.size;
    assert_true(header < size);
    assert_true(raw.version & GP_EXR_MULTIPART);
    assert_non_null(gp_exr_raw_find(&raw.part[1], "channels", "chlist"));
    assert_null(gp_exr_raw_find(&raw.part[1], "channels", "string"));
    assert_null(gp_exr_raw_find(&raw.part[1], "colour", "chlist"));
    gp_exr_raw_free(&raw);
    for (size_t n = 0; n < header; n++) {
        assert_int_equal(raw_of(bytes, n, 2, &raw), GP_ERR_DATA);
        assert_int_equal(heard.count, 1);
        assert_null(raw.bytes);
    }
    assert_int_equal(raw_of(bytes, header, 2, &raw), GP_OK);
    gp_exr_raw_free(&raw);
    free(bytes);
}

static uint8_t *find(uint8_t *bytes, size_t size, const char *text)
{
    uint8_t *at = memmem(bytes, size, text, strlen(text));
    assert_non_null(at);
    return at;
}

/* A file that came after the library had read another. */
static void damaged_headers(void **state)
{
    (void) state;
    enum { NO_END, HUGE_SIZE, NO_LAST_NULL, KINDS };
    for (int kind = 0; kind < KINDS; kind++) {
        size_t size;
        struct gp_exr_raw raw;
        uint8_t *bytes = fixture_make(&two, &size);
        uint8_t *at = find(bytes, size, "compression");
        assert_int_equal(raw_of(bytes, size, 2, &raw), GP_OK);
        const size_t header = raw.size;
        gp_exr_raw_free(&raw);
        bytes = realloc(bytes, size + 4096);
        assert_non_null(bytes);
        memset(bytes + size, 'x', 4096);
        at = find(bytes, size, "compression");
        if (kind == NO_END) // a name of thousands of bytes
            memset(at, 'x', size - (size_t) (at - bytes));
        if (kind == HUGE_SIZE)
            memset(at + 2 * sizeof "compression", 0xff, 4);
        if (kind == NO_LAST_NULL)
            bytes[header - 1] = 1;
        assert_int_equal(raw_of(bytes, size + 4096, 2, &raw), GP_ERR_DATA);
        assert_int_equal(heard.count, 1);
        assert_non_null(strstr(heard.line, "cut off or damaged"));
        assert_null(raw.bytes);
        free(bytes);
    }
}

/* -- the end -------------------------------------------------------------------*/

static const uint64_t cut_off = UINT64_MAX; // or no header at all

static uint64_t end_of(const uint8_t *bytes, size_t size)
{
    struct gp_input *o;
    struct gp_stream s = {.fd = -1, .data = (uint8_t *) (uintptr_t) bytes,
                          .size = size, .borrowed = true};
    const gp_status st = gp_exr_open(&hear, "a.exr", &s, &o);
    if (st) {
        assert_int_equal(st, GP_ERR_DATA);
        assert_non_null(strstr(heard.line, "a.exr: "));
        return cut_off;
    }
    const uint64_t end = gp_exr_end(o);
    assert_true(end <= size);
    gp_input_free(o);
    return end;
}

static void ends(void **state)
{
    (void) state;
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
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        size_t size;
        uint8_t *bytes = fixture_make(&row[i], &size);
        bytes = realloc(bytes, size + 100);
        assert_non_null(bytes);
        memset(bytes + size, 7, 100); // another file behind it
        assert_int_equal(end_of(bytes, size + 100), size);
        // whatever part or level the last bytes are of
        for (size_t n = 1; n < size; n++)
            assert_int_equal(end_of(bytes, n), cut_off);
        assert_non_null(strstr(heard.line, "cut off or damaged (its chunks end "
                                           "at byte "));
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
    struct gp_exr_raw raw;
    uint8_t *made = fixture_make(&deep, &size), bytes[4096] = {0};
    assert_true(size < 2048);
    memcpy(bytes, made, size);
    free(made);
    assert_int_equal(raw_of(bytes, sizeof bytes, 1, &raw), GP_OK);
    const uint64_t chunk = raw.size + 8, sizes[3] = {table, samples, samples};
    if (written)
        memcpy(bytes + raw.size, &chunk, 8);
    memcpy(bytes + chunk + 4, sizes, sizeof sizes);
    gp_exr_raw_free(&raw);
    *whole = chunk + 28 + table + samples;
    return end_of(bytes, sizeof bytes);
}

static void deep_ends(void **state)
{
    (void) state;
    size_t whole;
    const uint64_t end = deep_end(16, 40, true, &whole);
    assert_int_equal(end, whole);
    // never written, behind the stream, and sums that wrap around
    assert_int_equal(deep_end(16, 40, false, &whole), 0);
    assert_int_equal(deep_end(16, 1 << 20, true, &whole), cut_off);
    assert_int_equal(deep_end(UINT64_MAX, 40, true, &whole), 0);
    assert_int_equal(deep_end(UINT64_MAX - 39, 39, true, &whole), 0);
}

SUITE(exr_bytes)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cut_headers),
        cmocka_unit_test(damaged_headers),
        cmocka_unit_test(ends),
        cmocka_unit_test(deep_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
