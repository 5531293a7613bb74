// SPDX-License-Identifier: Apache-2.0
/* io/read of EXR: every lie that a file can tell ends with one error line. */
#include "unit.h"
#include "core/cpu.h"
#include "core/parallel.h"
#include "io/read.h"
#include "io/plane.h"
#include "exr_fixture.h"
#include "reading.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

static void no_colour_of_a_pixel(void **state)
{
    static const struct fixture_part row[] = {
        {.channel = {HALF_CH("u"), HALF_CH("v")}, .data = W(3)},
        {.channel = {HALF_CH("A"), FLOAT_CH("Z")}, .data = W(3)},
        {.channel = {{"R", HALVES, 3, 1}, HALF_CH("v")}, .data = W(3)},
        {.channel = {RGB(HALVES)}, .deep = true, .data = W(5),
         .compression = EXR_COMPRESSION_ZIPS},
        {.channel = {RGB(HALVES)}, .deep = true, .data = W(5), .tile = 16,
         .compression = EXR_COMPRESSION_ZIPS},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        const struct fixture f = {.part = {row[i]}};
        fixture_write_file(in_folder("none.exr"), &f);
        assert_refused(path, GP_ERR_DATA, path);
    }
}

/* Changes the value of an attribute in a file's bytes. */
static void set_value(uint8_t *bytes, size_t size, const char *name,
                      const char *type, const void *value, size_t n)
{
    char head[40] = "";
    const size_t named = strlen(name) + 1, all = named + strlen(type) + 1;
    memcpy(head, name, named);
    memcpy(head + named, type, all - named);
    uint8_t *const at = memmem(bytes, size, head, all);
    assert_non_null(at);
    memcpy(at + all + 4, value, n);
}

/* Reads with little memory left; the child's status is the answer. */
static void assert_refused_cheaply(const char *name, long long max_pixels)
{
    pid_t child = fork();
    if (child == 0) {
        struct gp_frame f = {0};
        const struct gp_read_params p = {.max_pixels = max_pixels};
#ifndef GP_SANITIZED
        struct rlimit limit = {256 << 20, 256 << 20};
        if (setrlimit(RLIMIT_AS, &limit))
            _exit(99);
#endif
        kept_clear();
        gp_set_threads(1); // a team does not survive fork()
        gp_status st = gp_read_frame(&kept_log, &p, name, &f);
        _exit(kept_errors == 1 ? (int) st : 98);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), GP_ERR_DATA);
}

static void sizes_that_lie(void **state)
{
    static const int32_t window[][4] = {
        {0, 0, 65534, 65534}, {-30000, -30000, 35534, 35534},
        {0, 0, 1 << 29, 0},   {0, 0, 0, 1 << 29},
        {0, 0, 100000, 39},   {0, 0, 39, 100000},
        {5, 5, 4, 4},         {-2147483647 - 1, 0, 2147483647, 1},
    };
    static const long long most[] = {1LL << 28, 1LL << 60};
    static const int32_t huge[] = {0, 0, 29999, 29999}, tile[] = {30000, 30000};
    in_folder("lie.exr");
    for (int c = 0; c < 2 * LOSSLESS; c++) {
        struct fixture f = {.part = {{
            .channel = {RGB(HALVES)}, .tile = c & 1 ? 16 : 0, .data = W(40),
            .compression = lossless[c / 2],
        }}};
        size_t size;
        static uint8_t *bytes; // not lost in a child that exits
        bytes = fixture_make(&f, &size);
        for (size_t i = 0; i < COUNT(window); i++) {
            set_value(bytes, size, "dataWindow", "box2i", window[i], 16);
            fixture_save(path, bytes, size);
            for (int k = 0; k < 2; k++)
                assert_refused_cheaply(path, most[k]);
        }
        if (f.part[0].tile) { // one that says it is the whole of a huge picture
            set_value(bytes, size, "tiles", "tiledesc", tile, sizeof tile);
            set_value(bytes, size, "dataWindow", "box2i", huge, sizeof huge);
            fixture_save(path, bytes, size);
            assert_refused_cheaply(path, 1LL << 40);
        }
        free(bytes);
    }
}

/* DEFLATE makes at most 1032 bytes of one: a chunk that claims more is refused
 * before memory is taken for it. */
static void chunks_that_claim_too_much(void **state)
{
    enum { CLAIMED = 100000, LINES = 16 };
    const struct fixture small = {
        .part = {{.channel = {RGB(HALVES)}, .compression = EXR_COMPRESSION_ZIP,
                  .data = FIXTURE_WINDOW(0, 0, 64, LINES)}},
    };
    static const int32_t window[] = {0, 0, CLAIMED - 1, LINES - 1};
    size_t size;
    uint8_t *const bytes = fixture_make(&small, &size);
    set_value(bytes, size, "dataWindow", "box2i", window, sizeof window);
    set_value(bytes, size, "displayWindow", "box2i", window, sizeof window);
    assert_true((size + 64) * 1032 < (size_t) CLAIMED * LINES * 6);
    fixture_save(in_folder("claim.exr"), bytes, size);
    free(bytes);
    assert_refused(path, GP_ERR_DATA, "it is too small for its pixels");
}

/* Pictures show the display window, so that of a frame counts; planes, of
 * which no picture is made, need none. */
static void display_windows_that_lie(void **state)
{
    static const struct {
        int w, h;
        long long most;
        bool read;
    } row[] = {
        {40, 25, 1000, true},         {41, 25, 1000, false},
        {1, 1001, 1000, false},       {16384, 16384, 1LL << 28, true},
        {16384, 16385, 1LL << 28, false}, {16384, 16385, 1LL << 29, true},
        {1 << 30, 1, 1LL << 40, false},
    };
    in_folder("shown.exr");
    for (size_t i = 0; i < COUNT(row); i++) {
        const struct gp_read_params p = {.max_pixels = row[i].most};
        const struct fixture f = {
            .part = {{.channel = {RGB(HALVES)}, .data = W(8)}},
            .display = FIXTURE_WINDOW(-5, 7, row[i].w, row[i].h),
        };
        struct gp_frame frame = {0};
        struct gp_plane plane = {0};
        kept_clear();
        fixture_write_file(path, &f);
        assert_int_equal(gp_read_frame(&kept_log, &p, path, &frame),
                         row[i].read ? GP_OK : GP_ERR_DATA);
        assert_int_equal(kept_errors, !row[i].read);
        assert_ok(gp_read_plane_file(&kept_log, &p, path, "R", false, &plane));
        gp_plane_free(&plane);
        gp_frame_free(&frame);
    }
}

/* Bits of a byte changed: the file gives a frame or one error line, the same
 * for any number of threads. */
static void assert_read_or_told(uint8_t *bytes, size_t size, size_t at,
                                uint8_t bits, int most_threads)
{
    char first[4096] = "";
    bytes[at] ^= bits;
    fixture_save(path, bytes, size);
    bytes[at] ^= bits;
    for (int threads = 1; threads <= most_threads; threads += 3) {
        struct gp_frame frame;
        gp_set_threads(threads);
        gp_status st = read_file(path, &frame);
        assert_true(st == GP_OK || st == GP_ERR_DATA);
        assert_int_equal(kept_errors, st != GP_OK);
        if (threads == 1)
            memcpy(first, kept_line, sizeof first);
        else
            assert_string_equal(kept_line, first);
        gp_frame_free(&frame);
    }
    gp_set_threads(0);
}

static void changed_bits(void **state)
{
    uint32_t seed = 2024;
    in_folder("changed.exr");
    for (int c = 0; c < LOSSLESS; c++) {
        size_t size;
        struct fixture f = {.part = {{
            .channel = {RGB(HALVES), FLOAT_CH("Z")},
            .data = FIXTURE_WINDOW(0, 0, 31, 67), .compression = lossless[c],
        }}};
        uint8_t *bytes = fixture_make(&f, &size);
        for (int turn = 0; turn < 60; turn++) {
            seed = seed * 1664525u + 1013904223u;
            assert_read_or_told(bytes, size, 4 + (seed >> 8) % (size - 4),
                                (uint8_t) (1u << (seed >> 5 & 7)), 4);
        }
        free(bytes);
    }
}

/* Every byte of the header, of the table of chunks and of the first chunks'
 * own words, changed in three ways. */
static void changed_head(void **state)
{
    static const uint8_t turn[] = {0x01, 0x80, 0xff};
    static const struct fixture kinds[] = {
        {.part = {{.channel = {RGB(HALVES)}, .tile = 8, .mipmap = true,
                   .data = FIXTURE_WINDOW(-3, 5, 20, 11),
                   .compression = EXR_COMPRESSION_ZIP}}},
        {.part = {{.channel = {{"BY", HALVES, 2, 2}, {"RY", HALVES, 2, 2},
                               HALF_CH("Y")},
                   .data = FIXTURE_WINDOW(0, 0, 20, 36),
                   .compression = EXR_COMPRESSION_ZIP}}},
        {.parts = 2, .part = {{.name = "Z", .channel = {FLOAT_CH("Z")},
                   .data = FIXTURE_WINDOW(0, 0, 7, 9), .tile = 4},
                  {.name = "rgba", .channel = {RGB(FLOATS)},
                   .data = FIXTURE_WINDOW(0, 0, 7, 9)}}},
    };
    in_folder("head.exr");
    for (size_t k = 0; k < COUNT(kinds); k++) {
        size_t size;
        uint8_t *bytes = fixture_make(&kinds[k], &size);
        for (size_t at = 4; at < size && at < 1200; at++) {
            for (size_t i = 0; i < sizeof turn; i++)
                assert_read_or_told(bytes, size, at, turn[i], 1);
        }
        free(bytes);
    }
}

SUITE_OF(exr_refuse, make_folder, remove_folder, no_colour_of_a_pixel,
         sizes_that_lie, chunks_that_claim_too_much, display_windows_that_lie,
         changed_bits, changed_head)
