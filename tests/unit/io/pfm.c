/* io: portable float maps. */
#include "unit.h"
#include "io/io_priv.h"

#include "reading.h"

enum { MOST = 1000 };

static const float sample[2][3] = {{0.25f, 300.0f, -1.0f},
                                   {1e-4f, 0.5f, 70000.0f}};

/* `head`, then both rows, from the bottom; with the other order of bytes. */
static size_t make_pfm(const char *head, bool swapped, uint8_t to[256])
{
    const size_t n = strlen(head);
    memcpy(to, head, n);
    memcpy(to + n, sample[1], 12);
    memcpy(to + n + 12, sample[0], 12);
    for (size_t i = n; swapped && i < n + 24; i += 4) {
        for (size_t k = 0; k < 2; k++) {
            const uint8_t byte = to[i + k];
            to[i + k] = to[i + 3 - k];
            to[i + 3 - k] = byte;
        }
    }
    return n + 24;
}

static gp_status open_bytes(const uint8_t *bytes, size_t n,
                            struct gp_image *image)
{
    static struct gp_stream s;
    s = (struct gp_stream) {.fd = -1, .data = (uint8_t *) (uintptr_t) bytes,
                            .size = n, .borrowed = true};
    *image = (struct gp_image) {0};
    said_nothing();
    return gp_pfm_open(&said_log, "a.pfm", &s, 0, MOST, image);
}

/* Values stay what they are, times the scale, and come from the top; where an
 * image ends is known by its header. */
static void headers(void **state)
{
    static const struct {
        const char *head;
        float scale;
        bool swapped;
    } row[] = {
        {"PF\n1 2\n-1.0\n", 1.0f, false}, {"PF 1 2 -1 ", 1.0f, false},
        {"PF\n1 2\n1.0\n", 1.0f, true},   {"PF\n1 2\n-2.5\n", 2.5f, false},
        {"PF\n1 2\n+25e-1\n", 2.5f, true}, {"PF\n\t1\r\n 2\v-1\f", 1, false},
        {"PF\n# PF 3 4\n1 #x\n2 #\n-1.0\n", 1, false},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        uint8_t bytes[256];
        struct gp_image image;
        uint64_t length = 0;
        const size_t n = make_pfm(row[i].head, row[i].swapped, bytes);
        assert_ok(gp_pfm_length(bytes, n + 9, &length));
        assert_int_equal(length, n);
        if (open_bytes(bytes, n, &image) || gp_image_load(&said_log, &image))
            fail_msg("row %zu: %s", i, said_line);
        assert_int_equal(image.channels, 3);
        for (int k = 0; k < 6; k++)
            assert_true(image.pixels[k] == sample[k / 3][k % 3] * row[i].scale);
        gp_image_close(&image);
    }
}

static void damaged_headers(void **state)
{
    static const char *const head[] = {
        "PF", "PF\n", "PF\n1 2\n", "PF\n1 2\n-1.0", "PF\n0 2\n-1.0\n",
        "PF\n1 -2\n-1.0\n", "PF\n1 x\n-1.0\n", "PF\n1 2\n0\n",
        "PF\n1 2\nnan\n", "PF\n1 2\ninf\n", "PF\n1 2\n1e99\n",
        "PF\n4294967297 2\n-1.0\n", "PF\n1 99999999999999999999\n-1\n",
        "PF\n2147483647 2147483647\n-1\n", "PF\n1 1001\n-1\n",
        "PF\n1 3\n-1\n", "PF\n# 1 2 -1\n", "PF\n1 2 -1.0\0",
    };
    for (size_t i = 0; i < sizeof head / sizeof *head; i++) {
        uint8_t bytes[256] = {0};
        struct gp_image image;
        uint64_t length = 0;
        const bool ends = i < 4; // right up to there
        const size_t n = ends ? strlen(head[i])
                              : make_pfm(head[i], false, bytes);
        if (ends)
            memcpy(bytes, head[i], n);
        if (open_bytes(bytes, n, &image) != GP_ERR_DATA)
            fail_msg("%s", head[i]);
        assert_int_equal(said_errors, 1);
        assert_null(image.own);
        assert_ok(gp_pfm_length(bytes, n, &length));
        if (length != 0 && length > n)
            fail_msg("%s: %d", head[i], (int) length);
    }
    // cut off anywhere
    uint8_t bytes[256];
    struct gp_image image;
    const size_t size = make_pfm("PF\n1 2\n-1.0\n", false, bytes);
    for (size_t n = 0; n < size; n++) {
        uint64_t length = 0;
        assert_int_equal(open_bytes(bytes, n, &image), GP_ERR_DATA);
        assert_ok(gp_pfm_length(bytes, n, &length));
        assert_int_equal(length, 0);
    }
    const struct gp_stream whole = {.fd = -1, .data = bytes, .size = size,
                                    .borrowed = true};
    assert_int_equal(gp_pfm_open(&said_log, "a.pfm", &whole, 1, MOST, &image),
                     GP_ERR_DATA); // it has no part 1
}

/* Grey, and more rows than a block has. */
static void large_and_grey(void **state)
{
    enum { W = 1100, H = 2000 };
    struct gp_frame f;
    float *const v = malloc(sizeof *v * W * H);
    assert_non_null(v);
    for (int i = 0; i < W * H; i++)
        v[i] = (float) i;
    in_folder("grey.pfm");
    FILE *const file = fopen(path, "wb");
    assert_non_null(file);
    fprintf(file, "Pf\n%d %d\n-1\n", W, H);
    assert_int_equal(fwrite(v, sizeof *v, W * H, file), W * H);
    assert_int_equal(fclose(file), 0);
    assert_ok(read_file(path, &f));
    assert_int_equal(f.model, GP_COLOUR_GREY);
    for (int y = 0; y < H; y++)
        assert_memory_equal(f.rgb.c[2] + (size_t) y * W,
                            v + (size_t) (H - 1 - y) * W, W * sizeof *v);
    gp_frame_free(&f);
    free(v);
}

SUITE_OF(pfm, make_folder, remove_folder, headers, damaged_headers,
         large_and_grey)
