// SPDX-License-Identifier: Apache-2.0
/* io: pipes up to their limit, first bytes; pictures to stdout one after the
 * other, and such streams read back. */
#include "unit.h"
#include "exr_fixture.h"
#include "write_fixture.h"
#include "core/bytes.h"
#include "core/colour.h"
#include "io/io_priv.h"
#include "io/read.h"
#include "io/stream.h"

#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

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
        {"PFx", 3, NULL}, {"\0\0\0\x1c" "ftypheic", 12, "HEIF"},
        {"\0\0\0\x20" "ftypqt  ", 12, "QuickTime or MP4 movie"},
        {"RIFF\x24\0\0\0WEBPVP8 ", 16, "WebP"},
        {"RIFF\x24\0\0\0WAVEfmt ", 16, NULL}, {"<!DOCTYPE", 9, "web page"},
        {"version https://git-lfs", 23, "git-lfs pointer"},
        {"hello", 5, NULL}, {"", 0, NULL},
        // Targa: RGB, palette, run lengths, and what is none
        {"\0\0\2\0\0\0\0\0\0\0\0\0\x10\0\x0c\0\x18\0", 18, "Targa"},
        {"\0\1\1\0\0\0\1\x18\0\0\0\0\0\1\0\1\x08\0", 18, "Targa"},
        {"\5\0\x0a\0\0\0\0\0\0\0\0\0\1\0\1\0\x20\0", 18, "Targa"},
        {"\0\0\2\0\0\0\0\0\0\0\0\0\x10\0\x0c\0\x18", 17, NULL},
        {"\0\0\2\0\0\0\0\0\0\0\0\0\0\0\x0c\0\x18\0", 18, NULL},
        {"\0\0\2\0\0\0\0\0\0\0\0\0\x10\0\x0c\0\x19\0", 18, NULL},
        {"\0\0\4\0\0\0\0\0\0\0\0\0\x10\0\x0c\0\x18\0", 18, NULL},
        // its fields do not agree: a palette's codes without a palette, of no
        // entries, of 9 bits; grey of 24 bits; rows in turn; a further kind
        {"\0\0\x09\0\0\0\1\x18\0\0\0\0\0\1\0\1\x08\0", 18, NULL},
        {"\0\1\1\0\0\0\0\x18\0\0\0\0\0\1\0\1\x08\0", 18, NULL},
        {"\0\1\1\0\0\0\1\x09\0\0\0\0\0\1\0\1\x08\0", 18, NULL},
        {"\0\0\3\0\0\0\0\0\0\0\0\0\x10\0\x0c\0\x18\0", 18, NULL},
        {"\0\0\2\0\0\0\0\0\0\0\0\0\x10\0\x0c\0\x18\x40", 18, NULL},
        {"\0\0\x12\0\0\0\0\0\0\0\0\0\x10\0\x0c\0\x18\0", 18, NULL},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        const uint8_t *const b = (const uint8_t *) row[i].bytes;
        const char *const name = gp_format_name(b, row[i].n);
        if (!name != !row[i].name || (name && strcmp(name, row[i].name) != 0))
            fail_msg("row %zu: %s", i, name ? name : "none");
    }
}

// -- stdin and stdout as files ---------------------------------------------

/* Makes `fd` the file until give_back(). */
static int borrow(int fd, const char *path, int flags)
{
    const int kept = dup(fd), file = open(path, flags, 0600);
    assert_true(kept >= 0 && file >= 0);
    assert_true(dup2(file, fd) == fd);
    close(file);
    return kept;
}

static void give_back(int fd, int kept)
{
    assert_true(dup2(kept, fd) == fd);
    close(kept);
}

static gp_status to_stdout(const char *file, const struct gp_write_params *p,
                           const struct gp_frame *f, enum gp_picture_kind kind)
{
    const int kept = borrow(STDOUT_FILENO, file, O_WRONLY | O_CREAT | O_APPEND);
    gp_status st = wf_write(p, "-", f, kind);
    give_back(STDOUT_FILENO, kept);
    return st;
}

static gp_status from_stdin(const char *file, struct gp_members *m)
{
    const struct gp_read_params p = GP_READ_DEFAULTS;
    const int kept = borrow(STDIN_FILENO, file, O_RDONLY);
    kept_clear();
    *m = (struct gp_members) {0};
    gp_status st = gp_members_read(&kept_all, &p, "-", m);
    give_back(STDIN_FILENO, kept);
    return st;
}

// -- raw pixels ------------------------------------------------------------

static const struct {
    struct gp_rect data, display;
} windows[] = {
    {{0, 0, 1, 1}, {0, 0, 1, 1}},     {{0, 0, 7, 5}, {0, 0, 7, 5}},
    {{-3, -2, 6, 9}, {0, 0, 4, 4}},   {{1, 2, 3, 4}, {-2, 0, 6, 5}},
    {{10, 10, 12, 12}, {0, 0, 3, 2}}, {{-9, -9, 90, 2}, {-9, -9, 90, 2}},
};

/* A sample as it must be in the stream, made without the code's tables. */
static size_t wanted(enum gp_raw_format raw, float v, uint8_t *to)
{
    static const size_t bytes[] = {
        [GP_RAW_RGB24] = 1, [GP_RAW_RGB48LE] = 2, [GP_RAW_RGB48BE] = 2,
        [GP_RAW_RGBF32LE] = 4,
    };
    const size_t n = bytes[raw];
    const float max = n == 1 ? 255.0f : 65535.0f;
    const uint32_t code = n == 4 ? gp_bits_of(v)
                                 : (uint32_t) (gp_srgb_encode(v) * max + 0.5f);
    for (size_t i = 0; i < n; i++)
        to[raw == GP_RAW_RGB48BE ? n - 1 - i : i] = (uint8_t) (code >> 8 * i);
    return n;
}

static void check_raw(const struct gp_frame *f, enum gp_raw_format raw,
                      const uint8_t *at, size_t size)
{
    const uint8_t *const end = at + size;
    for (int y = f->display.y0; y < f->display.y1; y++) {
        for (int i = 0; i < 3 * gp_rect_w(f->display); i++) {
            const int x = f->display.x0 + i / 3;
            const bool in = x >= f->data.x0 && x < f->data.x1 &&
                            y >= f->data.y0 && y < f->data.y1;
            const size_t k = in ? (size_t) ((y - f->data.y0) * gp_frame_w(f) +
                                            x - f->data.x0) : 0;
            uint8_t v[4];
            const size_t n = wanted(raw, in ? f->rgb.c[i % 3][k] : 0.0f, v);
            assert_true((size_t) (end - at) >= n);
            assert_memory_equal(at, v, n);
            at += n;
        }
    }
    assert_ptr_equal(at, end);
}

static void raw_pixels(void **state)
{
    for (size_t i = 0; i < 4 * COUNT(windows); i++) {
        wf_stats = (struct gp_write_stats) {0}; // a stream of its own
        const enum gp_raw_format raw = (enum gp_raw_format) (i % 4);
        struct gp_write_params p = GP_WRITE_DEFAULTS;
        struct gp_frame f = wf_frame(windows[i / 4].data,
                                     windows[i / 4].display, wf_rgb);
        p.stdout_format = GP_STDOUT_RAW;
        p.raw = raw;
        p.dither = GP_DITHER_NEVER;
        for (size_t k = 0; k < gp_frame_pixels(&f); k++)
            f.rgb.c[1][k] = f.rgb.c[1][k] / 12.0f + 0.5f;
        f.rgb.c[0][0] = NAN;
        f.rgb.c[2][0] = INFINITY;
        const char *out = wf_path("raw");
        size_t n;
        assert_ok(to_stdout(out, &p, &f, GP_PICTURE_SHOWN));
        uint8_t *bytes = wf_read(out, &n);
        check_raw(&f, raw, bytes, n);
        assert_int_equal(wf_stats.raw.w, gp_rect_w(f.display));
        free(bytes);
        remove(out);
        gp_frame_free(&f);
    }
}

static void raw_frames_have_one_size(void **state)
{
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    const struct gp_rect small = {0, 0, 4, 3}, turned = {0, 0, 3, 4};
    struct gp_frame a = wf_frame(small, small, wf_rgb);
    struct gp_frame b = wf_frame(turned, turned, wf_rgb);
    struct gp_frame c = wf_frame(turned, small, wf_rgb);
    const char *out = wf_path("sizes");
    size_t n;
    wf_stats = (struct gp_write_stats) {0};
    p.stdout_format = GP_STDOUT_RAW;
    assert_ok(to_stdout(out, &p, &a, GP_PICTURE_SHOWN));
    assert_int_equal(to_stdout(out, &p, &b, GP_PICTURE_SHOWN), GP_ERR_DATA);
    assert_kept("made: ");
    assert_ok(to_stdout(out, &p, &c, GP_PICTURE_SHOWN));
    free(wf_read(out, &n));
    assert_int_equal(n, 2 * 4 * 3 * 3); // not a byte of the wrong one
    remove(out);
    free_frames(&a, &b, &c);
}

// -- streams read back -------------------------------------------------------

/* Pieces of a stream; upper case is written by the program itself. */
static const struct {
    const char *pieces;
    int n;             // images, 0: refused
} streams[] = {
    {"E", 1}, {"EE", 2}, {"EZBDP", 5}, {"PFPF", 4}, {"gF", 2}, {"Eg", 2},
    {"E0P0", 2}, {"E1P1EZ", 4}, {"P9F9E", 3}, {"x", 0}, {"Ex", 0}, {"PEx", 0},
    {"0", 0}, {"E0x", 0}, {"h", 1}, {"Eh", 2}, {"z", 1}, {"w", 1}, {"l", 1},
    {"El", 2}, {"hE", 1},
};

static const char nothing[5000]; // more than a block of a tape
#define PIECE(letter, text) {letter, text, sizeof text - 1}
static const struct {
    char letter;
    const char *bytes;
    size_t n;
} pieces[] = {
    PIECE('g', "Pf 2\t1\n1.0\n12345678"), PIECE('0', "\0\0\0\0\0\0\0"),
    PIECE('1', "\0"), {'9', nothing, sizeof nothing},
    PIECE('x', "xyz"), PIECE('h', "PF\n2147483647 2147483647\n-1.0\n"),
    PIECE('z', "PF\n0 5\n-1.0\n"),
    PIECE('w', "PF\n99999999999999999999999 1\n-1.0\n12345678901234567890"),
    PIECE('l', "\x89PNG\r\n\x1a\n\xff\xff\xff\xffIDAT"),
};

static const struct {
    char letter;
    const char *name;
    enum gp_compression compression;
} written[] = {
    {'E', "e.exr", GP_COMPRESSION_NONE}, {'Z', "z.exr", GP_COMPRESSION_ZIP},
    {'B', "b.exr", GP_COMPRESSION_B44A}, {'D', "d.exr", GP_COMPRESSION_PIZ},
    {'P', "p.png", GP_COMPRESSION_AUTO}, {'F', "f.pfm", GP_COMPRESSION_AUTO},
};

/* Writes the pieces to a file; at[i] is where piece i begins. */
static size_t make_stream(const struct gp_frame *f, char path[64],
                          const char *letters, size_t at[16])
{
    snprintf(path, 64, "%.50s/stream", folder);
    FILE *file = fopen(path, "wb");
    size_t all = 0;
    assert_non_null(file);
    for (int i = 0; letters[i]; i++) {
        at[i] = all;
        for (size_t k = 0; k < COUNT(pieces); k++) {
            if (pieces[k].letter == letters[i])
                all += fwrite(pieces[k].bytes, 1, pieces[k].n, file);
        }
        for (size_t k = 0; k < COUNT(written); k++) {
            struct gp_write_params p = GP_WRITE_DEFAULTS;
            size_t n;
            if (written[k].letter != letters[i])
                continue;
            p.compression = written[k].compression;
            assert_ok(wf_write(&p, written[k].name, f, GP_PICTURE_SCENE));
            uint8_t *const bytes = wf_read(wf_path(written[k].name), &n);
            all += fwrite(bytes, 1, n, file);
            free(bytes);
        }
        assert_true(all > at[i]);
    }
    fclose(file);
    return all;
}

static void streams_fall_into_images(void **state)
{
    const struct gp_rect d = {3, -7, 40, 50};
    struct gp_frame f = wf_frame(d, d, wf_all);
    for (size_t i = 0; i < COUNT(streams); i++) {
        const char *letter = streams[i].pieces;
        char path[64];
        size_t at[16];
        struct gp_members m;
        make_stream(&f, path, letter, at);
        gp_status st = from_stdin(path, &m);
        if (st != (streams[i].n ? GP_OK : GP_ERR_DATA) || m.n != streams[i].n)
            fail_msg("%s: status %d, %d images: %s", letter, st, m.n,
                     kept_line);
        for (int k = 0, piece = 0; k < m.n; k++, piece++) {
            while (k > 0 && strchr("019", letter[piece]))
                piece++; // padding
            assert_int_equal(m.member[k].at, at[piece]);
        }
        gp_members_free(&m);
        gp_members_free(&m);
    }
    gp_frame_free(&f);
}

SUITE_OF_EACH(stream, wf_start, remove_folder, pipes_to_their_limit,
              first_bytes, raw_pixels, raw_frames_have_one_size,
              streams_fall_into_images)
