/* io/stream, and first bytes in io/read: pipes up to their limit, and what is read on after
 * its first bytes. */
#include "unit.h"
#include "io/io_priv.h"
#include "io/stream.h"

#include <pthread.h>
#include <unistd.h>

// -- pipes -----------------------------------------------------------------------

struct source {
    int fd;
    size_t bytes, step;
};

static uint8_t byte_at(size_t i)
{
    return (uint8_t) (i * 31 + i / 251);
}

static void *pour(void *of)
{
    const struct source *const s = of;
    uint8_t *const all = malloc(s->bytes + 1);
    for (size_t i = 0; all && i < s->bytes; i++)
        all[i] = byte_at(i);
    for (size_t at = 0; all && at < s->bytes;) {
        const size_t left = s->bytes - at;
        const ssize_t n = write(s->fd, all + at, left < s->step ? left
                                                                : s->step);
        if (n <= 0)
            break;
        at += (size_t) n;
    }
    free(all);
    close(s->fd);
    return NULL;
}

static void pipes_to_their_limit(void **state)
{
    enum { LIMIT = 300000, FIRST = 132 };
    static const struct {
        size_t bytes, step;
        gp_status open, fill;
    } row[] = {
        {0, 1, GP_ERR_DATA, GP_OK}, {1, 1, GP_OK, GP_OK},
        {FIRST - 1, 1, GP_OK, GP_OK}, {FIRST, FIRST, GP_OK, GP_OK},
        {FIRST + 1, 1, GP_OK, GP_OK}, {4099, 1, GP_OK, GP_OK},
        {LIMIT - 1, 4096, GP_OK, GP_OK}, {LIMIT, 70000, GP_OK, GP_OK},
        {LIMIT + 1, 70000, GP_OK, GP_ERR_DATA},
        {LIMIT + 20000, 70000, GP_OK, GP_ERR_DATA},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        int end[2];
        char name[32];
        pthread_t thread;
        struct gp_stream s;
        assert_int_equal(pipe(end), 0);
        struct source source = {end[1], row[i].bytes, row[i].step};
        assert_int_equal(pthread_create(&thread, NULL, pour, &source), 0);
        snprintf(name, sizeof name, "/dev/fd/%d", end[0]);
        const gp_status st = gp_stream_open(NULL, name, FIRST, &s);
        assert_int_equal(st, row[i].open);
        if (!st) {
            const size_t begin = row[i].bytes < FIRST ? row[i].bytes : FIRST;
            assert_int_equal(s.size, begin);
            assert_int_equal(s.more, row[i].bytes >= FIRST);
            assert_int_equal(gp_stream_fill(NULL, name, LIMIT, &s),
                             row[i].fill);
            assert_false(s.more);
            assert_int_equal(s.size, row[i].fill ? 0 : row[i].bytes);
            for (size_t k = 0; k < s.size; k++) {
                if (s.data[k] != byte_at(k))
                    fail_msg("row %zu, byte %zu", i, k);
            }
        }
        gp_stream_close(&s);
        gp_stream_close(&s);
        assert_int_equal(pthread_join(thread, NULL), 0);
        close(end[0]); // after it, since a pipe holds what is left to write
    }
}

// -- first bytes -----------------------------------------------------------------

static void first_bytes(void **state)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *name; // NULL: none
    } row[] = {
        {"\x76\x2f\x31\x01\2\0\0\0", 8, "EXR"}, {"\x76\x2f\x31", 3, NULL},
        {"\x89PNG\r\n\x1a\n", 8, "PNG"}, {"PF\n1 1\n", 7, "PFM"},
        {"Pf 1 1\n", 7, "PFM"}, {"P6#", 3, "PNM"}, {"P7\n", 3, NULL},
        {"PFx", 3, NULL},
        {"\0\0\0\x1c" "ftypmif1", 12, "HEIF, AVIF or a movie"},
        {"<html>", 6, "a web page"},
        {"version https://git-lfs", 23, "a git-lfs pointer"},
        {"hello", 5, NULL}, {"", 0, NULL},
        // Targa: RGB, palette, run lengths, and what is none
        {"\0\0\2\0\0\0\0\0\0\0\0\0\x10\0\x0c\0\x18\0", 18, "Targa"},
        {"\0\1\1\0\0\0\1\x18\0\0\0\0\0\1\0\1\x08\0", 18, "Targa"},
        {"\5\0\x0a\0\0\0\0\0\0\0\0\0\1\0\1\0\x20\0", 18, "Targa"},
        {"\0\0\2\0\0\0\0\0\0\0\0\0\x10\0\x0c\0\x18", 17, NULL},
        {"\0\0\2\0\0\0\0\0\0\0\0\0\0\0\x0c\0\x18\0", 18, NULL},
        {"\0\0\2\0\0\0\0\0\0\0\0\0\x10\0\x0c\0\x19\0", 18, NULL},
        {"\0\0\4\0\0\0\0\0\0\0\0\0\x10\0\x0c\0\x18\0", 18, NULL},
    };
    uint8_t zeros[GP_FIRST_BYTES] = {0};
    for (size_t i = 0; i < COUNT(row); i++) {
        const uint8_t *const b = (const uint8_t *) row[i].bytes;
        const char *const name = gp_format_name(b, row[i].n);
        if (!name != !row[i].name || (name && strcmp(name, row[i].name) != 0))
            fail_msg("row %zu: %s", i, name ? name : "none");
    }
    assert_null(gp_format_name(zeros, sizeof zeros));
    memcpy(zeros + 128, "DICM", 4);
    assert_string_equal(gp_format_name(zeros, sizeof zeros), "DICOM");
    assert_null(gp_format_name(zeros, sizeof zeros - 1));
}

SUITE_OF(stream, NULL, NULL,
    pipes_to_their_limit, first_bytes)
