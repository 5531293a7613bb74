// SPDX-License-Identifier: Apache-2.0
/* EXR out of an input: the attributes that a header gets, and those of every
 * kind and the other parts that --hdr carries, byte by byte. Inputs are made
 * here, with parts that no library of this program could write. */
#include "unit.h"
#include "core/bytes.h"
#include "write_fixture.h"
#include "io/exr/exr_priv.h"
#include "io/file.h"
#include "io/read.h"

static const char long_name[] = "an/attribute/whose/name/has/more/than/31";

/* Checks what other formats say of the picture, not of how they stored it. */
static void attributes_of_other_formats(void **state)
{
    static char longest[257], longer[258];
    static const struct {
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
    struct gp_frame f = wf_sized(2, 2, wf_rgb);
    for (size_t i = 0; i < COUNT(row); i++) {
        for (int shown = 0; shown < 2; shown++) {
            struct gp_attribute a = row[i].a;
            const bool want = row[i].type && (!shown || row[i].shown);
            f.attribute = &a;
            f.attributes = 1;
            assert_ok(shown ? wf_write(NULL, "a.exr", &f, GP_PICTURE_SHOWN)
                            : wf_write_hdr(NULL, "a.exr", &f));
            struct gp_frame b = wf_read_back("a.exr");
            const struct gp_exr_index *const index = gp_input_of(&b)->index;
            const struct gp_exr_attr *got = NULL;
            for (int k = 0; k < index->attrs; k++) {
                if (strcmp(index->attr[k].name, a.name) == 0)
                    got = &index->attr[k];
            }
            if (want != (got != NULL))
                fail_msg("%s: %d", a.name, want);
            if (want) {
                const size_t n = a.kind == 0 ? strlen(a.text) : 4;
                assert_string_equal(got->type, row[i].type);
                assert_int_equal(got->size, n);
                assert_memory_equal(got->data, a.kind == 0
                    ? (const void *) a.text : a.kind == 1
                    ? (const void *) &a.number : &a.real, n);
            }
            assert_int_equal(!(gp_le32(index->bytes + 4) & GP_EXR_LONG_NAMES),
                             !(want && strlen(a.name) > 31));
            gp_frame_free(&b);
        }
    }
    f.attribute = NULL;
    f.attributes = 0;
    gp_frame_free(&f);
}

// -- making inputs ------------------------------------------------------------

/* B, G and R of a frame as `type`. */
static struct gp_exr_image colour_of(const struct gp_frame *f,
    enum gp_pixel_type type, enum gp_compression compression,
    struct gp_exr_source source[3])
{
    static const char *const name[] = {"B", "G", "R"};
    for (int i = 0; i < 3; i++)
        source[i] = (struct gp_exr_source) {
            .name = name[i], .type = type, .xs = 1, .ys = 1,
            .columns = gp_frame_w(f), .plane = f->rgb.c[2 - i],
        };
    return (struct gp_exr_image) {f->data, compression, 45, source, 3};
}

static void end_file(struct gp_exr_out *out, struct gp_file *file)
{
    assert_ok(gp_exr_out_end(out));
    assert_ok(gp_file_commit(&file));
    gp_exr_out_free(out);
}

static void put_int(struct gp_exr_out *out, const char *name, int32_t v)
{
    gp_exr_put(out, name, "int", &v, 4);
}

static void put_text(struct gp_exr_out *out, const char *name, const char *v)
{
    gp_exr_put(out, name, "string", v, strlen(v));
}

/* The attributes of a part that is not the colour part; one half channel. */
static void put_part(struct gp_exr_out *out, const char *name,
                     const char *type, int w, int rows, int chunks)
{
    static const uint8_t list[] = {'Z', 0, 1, 0, 0, 0, 0, 0, 0, 0,
                                   1, 0, 0, 0, 1, 0, 0, 0, 0};
    const int32_t box[4] = {0, 0, w - 1, rows - 1};
    const float centre[2] = {0, 0}, one = 1;
    gp_exr_put(out, "channels", "chlist", list, sizeof list);
    gp_exr_put(out, "compression", "compression", "\2", 1); // zips
    gp_exr_put(out, "dataWindow", "box2i", box, 16);
    gp_exr_put(out, "displayWindow", "box2i", box, 16);
    gp_exr_put(out, "lineOrder", "lineOrder", "\1", 1); // decreasing
    gp_exr_put(out, "pixelAspectRatio", "float", &one, 4);
    gp_exr_put(out, "screenWindowCenter", "v2f", centre, 8);
    gp_exr_put(out, "screenWindowWidth", "float", &one, 4);
    put_text(out, "name", name);
    put_text(out, "type", type);
    put_int(out, "chunkCount", chunks);
    put_text(out, "comments", name);
    if (type[0] == 'd') {
        put_int(out, "version", 1);
        put_int(out, "maxSamplesPerPixel", -1);
    }
}

/* A chunk of noise. `leader` is what stands between the part's number and
 * the sizes; deep chunks may have no samples. */
static void put_chunk(struct gp_exr_out *out, int part, int index,
                      const int32_t *leader, size_t n, bool deep, int bytes)
{
    uint8_t noise[256];
    const int32_t number = part, flat = bytes;
    const uint64_t sizes[3] = {8, (uint64_t) bytes, 4u * (uint64_t) bytes};
    for (int i = 0; i < 256; i++)
        noise[i] = (uint8_t) wf_hash((uint32_t) i, (uint32_t) index, 99);
    out->offset[out->first[part] + (size_t) index] = gp_file_size(out->file);
    assert_ok(gp_file_write(out->file, &number, 4));
    assert_ok(gp_file_write(out->file, leader, n * 4));
    assert_ok(gp_file_write(out->file, deep ? (const void *) sizes : &flat,
                            deep ? 24 : 4));
    assert_ok(gp_file_write(out->file, noise, deep ? 8 : 0));
    assert_ok(gp_file_write(out->file, noise, (size_t) bytes));
}

/* Rip-mapped tiles of 4x4 and 8x8 pixels: 4 x levels times 4 y levels, the
 * four smallest of each of one pixel less. */
enum { TILES = 25 };
static void put_rips(struct gp_exr_out *out, int part)
{
    static const int count[4] = {2, 1, 1, 1}; // of 8, 4, 2, 1 pixels
    int index = 0;
    for (int ly = 0; ly < 4; ly++) {
        for (int lx = 0; lx < 4; lx++) {
            for (int t = 0; t < count[lx] * count[ly]; t++) {
                const int32_t at[4] = {t % count[lx], t / count[lx], lx, ly};
                put_chunk(out, part, index, at, 4, false, 20 + index);
                index++;
            }
        }
    }
    assert_int_equal(index, TILES);
}

/* Damage to chunk 2 of a part: the bytes at `at` of it, or its place, `back`
 * bytes before the file's end. */
struct damage {
    bool cut; // the header says so, whatever part is read
    int part;
    uint64_t at, back;
    size_t size;
    uint64_t bytes[2];
};

/* Four parts: rip-mapped tiles, the colour, deep scanlines of which one has
 * no samples (stored from the bottom), and scanlines. */
static void make_parts(const char *path, const struct gp_frame *f,
                       const struct damage *damage)
{
    enum { ROWS = 5 };
    struct gp_exr_source source[3];
    const struct gp_exr_image img = colour_of(f, GP_HALF, GP_COMPRESSION_ZIPS,
                                              source);
    const int chunks[4] = {TILES, gp_rect_h(f->data), ROWS, ROWS};
    struct gp_file *file;
    struct gp_exr_out out;
    assert_ok(gp_file_open(&kept_all, path, false, false, &file));
    gp_exr_out_begin(&out, &kept_all, file, GP_EXR_MULTIPART | GP_EXR_DEEP);
    put_part(&out, "rips", "tiledimage", 8, 8, TILES);
    static const uint8_t tiles[9] = {4, 0, 0, 0, 4, 0, 0, 0, 2}; // rip, down
    gp_exr_put(&out, "tiles", "tiledesc", tiles, 9);
    put_int(&out, "version", 1);
    gp_exr_put_raw(&out, "", 1);
    gp_exr_put_part(&out, f, &img, NULL, GP_EXR_KEEP_ALL, &wf_defaults,
                    chunks[1]);
    put_part(&out, "deep", "deepscanline", 2, ROWS, ROWS);
    put_text(&out, long_name, "long");
    gp_exr_put_raw(&out, "", 1);
    put_part(&out, "last", "scanlineimage", 2, ROWS, ROWS);
    put_int(&out, "version", 1);
    gp_exr_put_raw(&out, "\0", 2);
    assert_ok(gp_exr_out_tables(&out, chunks, 4));
    put_rips(&out, 0);
    assert_ok(gp_exr_encode(&out, 1, &img, &wf_stats.clamped));
    for (int32_t y = ROWS - 1; y >= 0; y--)
        put_chunk(&out, 2, y, &y, 1, true, y == 2 ? 0 : 30 + y);
    for (int32_t y = 0; y < ROWS; y++)
        put_chunk(&out, 3, y, &y, 1, false, 3);
    if (damage) {
        uint64_t *const offset = &out.offset[out.first[damage->part] + 2];
        if (damage->back)
            *offset = gp_file_size(file) - damage->back;
        assert_ok(gp_file_patch(file, *offset + damage->at, damage->bytes,
                                damage->size));
    }
    end_file(&out, file);
}

/* Each attribute of `a` but the first n of `but` is in `b`, bit by bit. */
static void assert_attributes(const struct gp_exr_part *a,
                              const struct gp_exr_part *b,
                              const char *const *but, int n)
{
    for (int i = 0; i < a->attrs; i++) {
        const struct gp_exr_attr *p = &a->attr[i];
        const struct gp_exr_attr *q = gp_exr_attr_find(b, p->name, p->type);
        bool skip = false;
        for (int k = 0; k < n; k++)
            skip |= strcmp(but[k], p->name) == 0;
        if (!skip &&
            (!q || q->size != p->size || memcmp(p->data, q->data, p->size)))
            fail_msg("attribute %s is not what it was", p->name);
    }
}

// -- tests --------------------------------------------------------------------

/* A file of parts that no picture is made of comes back as it was. */
static void whole_parts(void **state)
{
    struct gp_frame made = wf_sized(20, 20, wf_rgb);
    make_parts(wf_path("in.exr"), &made, NULL);
    struct gp_frame a = wf_read_back("in.exr");
    assert_ok(wf_write_hdr(NULL, "out.exr", &a));
    wf_assert_same(wf_path("in.exr"), wf_path("out.exr"));
    free_frames(&a, &made);
}

static void damaged_parts(void **state)
{
    static const struct damage row[] = {
        {.part = 3, .size = 4, .bytes = {2}},         // another part's
        {.part = 3, .at = 8, .size = 4, .bytes = {0xffffffff}}, // size < 0
        {.part = 3, .at = 8, .size = 4, .bytes = {0x7fffffff}},
        {.part = 0, .at = 20, .size = 4, .bytes = {1 << 20}},
        {.part = 2, .at = 8, .size = 8, .bytes = {1 << 20}},
        {.part = 2, .at = 8, .size = 16, .bytes = {8, 1 << 20}},
        {.part = 2, .at = 8, .size = 16, .bytes = {UINT64_MAX, 9}}, // wraps
        {.part = 3, .back = 2, .cut = true}, // a chunk outside the file
    };
    static const struct gp_read_params params = GP_READ_DEFAULTS;
    struct gp_frame made = wf_sized(20, 20, wf_rgb);
    for (size_t i = 0; i < COUNT(row); i++) {
        char part[16];
        struct gp_frame a;
        make_parts(wf_path("in.exr"), &made, &row[i]);
        assert_int_equal(gp_read_frame(&kept_all, &params, wf_path("in.exr"),
                                       &a), row[i].cut ? GP_ERR_DATA : GP_OK);
        if (row[i].cut)
            continue;
        assert_int_equal(wf_write_hdr(NULL, "out.exr", &a), GP_ERR_DATA);
        snprintf(part, sizeof part, "part %d", row[i].part);
        assert_kept(part);
        assert_int_equal(wf_names(), 1); // in.exr
        // a picture does not need that part
        assert_ok(wf_write(NULL, "out.exr", &a, GP_PICTURE_SCENE));
        remove(wf_path("out.exr"));
        gp_frame_free(&a);
    }
    gp_frame_free(&made);
}

/* A file of one part with attributes of all sorts. */
static void make_attributes(const char *path, const struct gp_frame *f)
{
    static const float ap0[8] = {0.7347f, 0.2653f, 0,        1,
                                 0.0001f, -0.077f, 0.32168f, 0.33767f};
    static const float centre[2] = {0.25f, -1.5f}, width = 3, level = 80;
    static const uint8_t preview[12] = {1, 0, 0, 0, 1, 0, 0, 0, 9, 8, 7, 6};
#define VALUE(v) (const uint8_t *) (v)
    const struct gp_exr_attr attr[] = {
        {"screenWindowCenter", "v2f", VALUE(centre), 8},
        {"chromaticities", "chromaticities", VALUE(ap0), 32},
        {"whiteLuminance", "float", VALUE(&width), 4},
        {"dwaCompressionLevel", "float", VALUE(&level), 4},
        {"preview", "preview", preview, sizeof preview},
        {"strange", "studio::Type<int>", preview, 11},
        {"nothing", "studio", preview, 0},
        {"comments", "string", preview, 0},
        {long_name, "string", VALUE("two\nlines"), 9},
        {"name", "string", VALUE("only"), 4},
        {"version", "string", VALUE("v002"), 4}, // of the shot, as Nuke says it
    };
    struct gp_exr_source source[3];
    const struct gp_exr_image img = colour_of(f, GP_FLOAT,
                                              GP_COMPRESSION_PXR24, source);
    const int chunks = gp_exr_chunk_count(&img);
    const struct gp_exr_part own = {.attr = attr, .attrs = COUNT(attr)};
    struct gp_file *file;
    struct gp_exr_out out;
    assert_ok(gp_file_open(&kept_all, path, false, false, &file));
    gp_exr_out_begin(&out, &kept_all, file, 0);
    gp_exr_put_part(&out, f, &img, &own, GP_EXR_KEEP_ALL, &wf_defaults, 0);
    assert_ok(gp_exr_out_tables(&out, &chunks, 1));
    assert_true(out.flags & GP_EXR_LONG_NAMES);
    assert_ok(gp_exr_encode(&out, 0, &img, &wf_stats.clamped));
    end_file(&out, file);
}

static void attributes(void **state)
{
    static const char *const own[] = {"compression", "name", "preview",
                                      "chromaticities", "whiteLuminance"};
    static const int n[] = {1, 3, 5}; // --hdr, scene, shown: not as they were
    struct gp_frame made = wf_sized(20, 20, wf_rgb);
    make_attributes(wf_path("in.exr"), &made);
    struct gp_frame a = wf_read_back("in.exr");
    const struct gp_exr_part *const from = gp_input_of(&a)->each;
    for (int i = 0; i < 3; i++) {
        assert_ok(i == 0 ? wf_write_hdr(NULL, "out.exr", &a) : wf_write(NULL,
            "out.exr", &a, i == 1 ? GP_PICTURE_SCENE : GP_PICTURE_SHOWN));
        struct gp_frame b = wf_read_back("out.exr");
        const struct gp_exr_part *const to = gp_input_of(&b)->each;
        assert_attributes(from, to, own, n[i]);
        // none came twice, or from nowhere; compression is there, others not
        assert_int_equal(to->attrs, from->attrs - n[i] + 1);
        gp_frame_free(&b);
    }
    free_frames(&a, &made);
}

/* A frame that came from no EXR says its own primaries. */
static void primaries(void **state)
{
    struct gp_frame f = wf_sized(4, 4, wf_rgb);
    for (int other = 0; other < 2; other++) {
        for (enum gp_picture_kind kind = GP_PICTURE_SCENE;
             kind <= GP_PICTURE_SHOWN; kind++) {
            f.chromaticities[0] = other ? 0.7f : 0.64f;
            assert_ok(wf_write(NULL, "a.exr", &f, kind));
            struct gp_frame b = wf_read_back("a.exr");
            const bool own = other && kind == GP_PICTURE_SCENE;
            assert_true(b.chromaticities[0] == (own ? 0.7f : 0.64f));
            gp_frame_free(&b);
        }
    }
    gp_frame_free(&f);
}

SUITE_OF_EACH(exr_hdr, wf_start, remove_folder, attributes_of_other_formats,
              whole_parts, damaged_parts, attributes, primaries)
