/* io/exr_header, io/exr_out, io/exr_origin: which attributes a header gets,
 * and what a caller is told who asks for chunks that are not there. */
#include "unit.h"
#include "write_fixture.h"

#include "io/exr/exr_priv.h"
#include "io/file.h"
#include "io/picture.h"

#include "exr_fixture.h"

/* The attribute of that name, and how many there are. */
static struct gp_exr_attr find(const struct gp_exr_header *h, const char *name,
                               int *count)
{
    struct gp_exr_attr found = {0};
    *count = 0;
    for (const uint8_t *p = h->bytes + 8; *p;) {
        struct gp_exr_attr a = {.name = (const char *) p};
        p += strlen(a.name) + 1;
        a.type = (const char *) p;
        p += strlen(a.type) + 1;
        memcpy(&a.size, p, 4);
        a.data = p + 4;
        p += 4 + a.size;
        assert_true(p < h->bytes + h->size);
        if (strcmp(a.name, name) != 0)
            continue;
        found = a;
        ++*count;
    }
    return found;
}

static const struct gp_exr_source one_source = {
    .name = "Y", .type = GP_HALF, .xs = 1, .ys = 1, .linear = true,
};

/* A header's only part, of a frame with that attribute. */
static struct gp_exr_header make_header(struct gp_attribute *attribute,
                                        const struct gp_exr_carried_part *raw,
                                        enum gp_exr_kept kept, uint32_t flags,
                                        enum gp_compression compression)
{
    const struct gp_rect r = {0, 0, 2, 2};
    struct gp_frame f = wf_frame(r, r, wf_rgb);
    const struct gp_exr_image img = {r, compression, &one_source, 1};
    struct gp_exr_header h;
    f.attribute = attribute;
    f.attributes = attribute != NULL;
    gp_exr_header_start(&h, flags);
    gp_exr_header_part(&h, &f, &img, raw, kept, NULL, 0);
    assert_int_equal(gp_exr_header_done(&wf_log, "h.exr", &h), GP_OK);
    f.attribute = NULL;
    f.attributes = 0;
    gp_frame_free(&f);
    return h;
}

/* What other formats tell of the picture, and not of how they stored it. */
static void attributes_of_other_formats(void **state)
{
    (void) state;
    static char longest[257], longer[258];
    const struct {
        struct gp_attribute a;
        const char *type; // NULL: not carried
        bool shown;       // carried to a display-referred picture too
    } row[] = {
        {{"owner", 0, "me", 0, 0}, "string", true},
        {{"empty", 0, "", 0, 0}, "string", true},
        {{"frame", 1, NULL, -7, 0}, "int", true},
        {{"fov", 2, NULL, 0, 1.5f}, "float", true},
        {{"whiteLuminance", 2, NULL, 0, 100.0f}, "float", false},
        {{longest, 1, NULL, 3, 0}, "int", true},
        {{longer, 1, NULL, 3, 0}, NULL, false},
        {{"", 1, NULL, 3, 0}, NULL, false},
        {{"nothing", 0, NULL, 0, 0}, NULL, false},
        {{"unknown", 3, NULL, 0, 0}, NULL, false},
        {{"tiff:Predictor", 1, NULL, 2, 0}, NULL, false},
        {{"Orientation", 1, NULL, 6, 0}, NULL, false},
        {{"name", 0, "x", 0, 0}, NULL, false}, // EXR's own
        {{"preview", 0, "x", 0, 0}, "string", false},
    };
    memset(longest, 'a', 255);
    memset(longer, 'b', 256);
    for (size_t i = 0; i < COUNT(row); i++) {
        for (int shown = 0; shown < 2; shown++) {
            struct gp_attribute a = row[i].a;
            struct gp_exr_header h = make_header(
                &a, NULL, shown ? GP_EXR_KEEP_SHOWN : GP_EXR_KEEP_ALL, 0,
                GP_COMPRESSION_ZIP);
            int count;
            const struct gp_exr_attr got = find(&h, a.name, &count);
            const bool want = row[i].type && (!shown || row[i].shown);
            if (count != want)
                fail_msg("%s: %d of it", a.name, count);
            if (want) {
                const size_t n = a.kind == 0 ? strlen(a.text) : 4;
                assert_string_equal(got.type, row[i].type);
                assert_int_equal(got.size, n);
                assert_memory_equal(got.data,
                                    a.kind == 0 ? (const void *) a.text
                                    : a.kind == 1 ? (const void *) &a.whole
                                                  : &a.real, n);
            }
            assert_int_equal(!(h.flags & GP_EXR_LONG_NAMES),
                             !(want && strlen(a.name) > 31));
            gp_exr_header_free(&h);
        }
    }
}

static void attributes_of_another_exr(void **state)
{
    (void) state;
    static const struct {
        const char *name;
        uint32_t flags;
        int count[4]; // for each gp_exr_kept
    } row[] = {
        {"owner", 0, {1, 1, 1, 1}},
        {"owner", GP_EXR_DEEP, {1, 1, 1, 1}},
        {"multiView", 0, {1, 1, 0, 0}},
        {"preview", 0, {1, 0, 0, 0}},
        {"chromaticities", 0, {1, 0, 1, 0}},
        {"compression", 0, {1, 1, 1, 1}},       // the picture's own
        {"version", 0, {1, 1, 1, 1}},
        {"version", GP_EXR_DEEP, {1, 1, 1, 1}}, // not twice
        {"tiles", 0, {0, 0, 0, 0}},
        {"screenWindowWidth", 0, {1, 1, 1, 1}}, // of a wrong size: made anew
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        static const uint8_t data[3] = {9, 9, 9};
        const bool wide = strcmp(row[i].name, "screenWindowWidth") == 0;
        const struct gp_exr_attr a = {row[i].name, wide ? "float" : "opaque",
                                      data, sizeof data};
        const struct gp_exr_carried_part raw = {.attr = &a, .attrs = 1};
        for (int kept = 0; kept < 4; kept++) {
            struct gp_exr_header h = make_header(
                NULL, &raw, (enum gp_exr_kept) kept, row[i].flags,
                GP_COMPRESSION_PIZ);
            int count;
            const struct gp_exr_attr got = find(&h, a.name, &count);
            if (count != row[i].count[kept])
                fail_msg("%s: %d where %d is kept", a.name, count, kept);
            if (wide)
                assert_int_equal(got.size, 4);
            gp_exr_header_free(&h);
        }
    }
}

/* Readers may believe a channel's flag, which DWA's chunks are not made for. */
static void linear_flag(void **state)
{
    (void) state;
    static const struct {
        enum gp_compression compression;
        int linear;
    } row[] = {
        {GP_COMPRESSION_B44, 1}, {GP_COMPRESSION_ZIP, 1},
        {GP_COMPRESSION_DWAA, 0}, {GP_COMPRESSION_DWAB, 0},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        int count;
        struct gp_exr_header h = make_header(NULL, NULL, GP_EXR_KEEP_ALL, 0,
                                             row[i].compression);
        const struct gp_exr_attr list = find(&h, "channels", &count);
        assert_int_equal(list.size, 2 + 4 + 4 + 8 + 1);
        assert_int_equal(list.data[6], row[i].linear);
        gp_exr_header_free(&h);
    }
}

static void chunks_that_nobody_wrote(void **state)
{
    (void) state;
    static const int chunks[2] = {1, 3};
    struct gp_exr_header h = make_header(NULL, NULL, GP_EXR_KEEP_ALL,
                                         GP_EXR_MULTIPART, GP_COMPRESSION_ZIP);
    struct gp_file *file;
    struct gp_exr_out out;
    assert_int_equal(gp_file_open(&wf_log, wf_path("o"), false, &file), GP_OK);
    assert_int_equal(gp_exr_out_begin(&wf_log, file, h.bytes, h.size, chunks,
                                      2, &out), GP_OK);
    assert_int_equal(gp_exr_out_scanlines(&out, 0, 0, 0, "abc", 3), GP_OK);
    assert_int_equal(gp_exr_out_scanlines(&out, 1, 0, 0, "abc", 3), GP_OK);
    assert_int_equal(gp_exr_out_scanlines(&out, 1, 2, 0, "abc", 3), GP_OK);
    assert_int_equal(gp_exr_out_end(&out), GP_ERR_BUG);
    wf_assert_said("chunk 1 of part 1");
    assert_int_equal(gp_exr_out_scanlines(&out, 1, 1, 0, "abc", 3), GP_OK);
    assert_int_equal(gp_exr_out_end(&out), GP_OK);
    gp_exr_out_free(&out);
    gp_exr_out_free(&out); // one that is empty
    gp_file_discard(&file);
    gp_exr_header_free(&h);
}

/* -- pictures ----------------------------------------------------------------- */

static void windows_that_are_no_picture(void **state)
{
    (void) state;
    static const struct gp_rect display[] = {
        {0, 0, 0, 5}, {0, 0, 5, 0}, {3, 0, -2, 5}, {0, 9, 5, 2},
        {INT32_MIN, 0, INT32_MAX, 1}, {0, INT32_MIN, 1, INT32_MAX},
        {0, 0, 1 << 29, 1}, {0, 0, 1 << 20, (1 << 20) + 1},
    };
    const struct gp_rect r = {0, 0, 2, 2};
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_frame f = wf_frame(r, r, wf_rgb);
    for (size_t i = 0; i < COUNT(display); i++) {
        struct gp_picture pic;
        f.display = display[i];
        wf_line[0] = '\0';
        assert_int_equal(gp_picture_make(&wf_log, &p, "p.png", &f, &f.rgb,
                                         GP_PICTURE_SCENE, false, &pic),
                         GP_ERR_DATA);
        wf_assert_said("p.png: no picture of this display window (");
        assert_int_equal(pic.channels, 0); // empty
    }
    gp_frame_free(&f);
}

/* Rows of floats with alpha, the picture wider than the data. */
static void floats_with_alpha(void **state)
{
    (void) state;
    const struct gp_rect data = {1, 0, 3, 2}, display = {0, 0, 4, 2};
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_frame f = wf_frame(data, display, wf_all);
    struct gp_picture pic;
    float to[4][4];
    struct gp_picture_row row = {.linear = {to[0], to[1], to[2], to[3]}};
    p.alpha = GP_ALPHA_KEEP;
    assert_int_equal(gp_picture_make(&wf_log, &p, "p", &f, &f.rgb,
                                     GP_PICTURE_SCENE, false, &pic), GP_OK);
    assert_int_equal(pic.channels, 4);
    for (int y = 0; y < 2; y++) {
        memset(to, 0xff, sizeof to);
        gp_picture_floats(&pic, y, &row);
        for (int c = 0; c < 4; c++) {
            const int number = c < 3 ? c : 0; // alpha is channel 0 of the list
            assert_true(to[c][0] == 0.0f && to[c][3] == 0.0f);
            for (int x = 0; x < 2; x++)
                assert_true(to[c][1 + x] == wf_value(number, x, y));
        }
    }
    gp_picture_free(&pic);
    gp_frame_free(&f);
}

SUITE_OF_EACH(exr_header, wf_start, wf_end, attributes_of_other_formats,
              attributes_of_another_exr, linear_flag, chunks_that_nobody_wrote,
              windows_that_are_no_picture, floats_with_alpha)
