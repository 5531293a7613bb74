/* --hdr with layers and parts made again keeps the bits of carried channels in
 * every lossless compression, the chunks of other parts, and all of real
 * frames. */
#include "unit.h"
#include "exr_fixture.h"
#include "write_fixture.h"
#include "io/exr/exr_priv.h"
#include "io/read.h"

static const struct gp_read_params read_params = GP_READ_DEFAULTS;
static const struct gp_rect window = {-3, 5, 42, 45};

static struct gp_frame read_as(const char *path, const char *view)
{
    struct gp_read_params p = read_params;
    struct gp_frame f;
    p.view = view;
    if (gp_read_frame(&kept_all, &p, path, &f))
        fail_msg("%s", kept_line);
    return f;
}

/* Every carried channel of `a` is in `b` with its type and bits. */
static void assert_carried(const struct gp_frame *a, const struct gp_frame *b)
{
    for (int i = 0; i < a->channels; i++) {
        const struct gp_channel *p = &a->channel[i];
        const struct gp_channel *q = gp_frame_channel(b, p->name);
        if (p->colour >= 0)
            continue;
        assert_non_null(q);
        assert_int_equal(p->type, q->type);
        assert_memory_equal(p->data, q->data, (size_t) p->w * (size_t) p->h *
                                                  gp_type_size(p->type));
    }
}

/* The chunks of a part are the same bytes in both files. */
static void assert_chunks(const struct gp_frame *a, const struct gp_frame *b,
                          int part)
{
    const struct gp_input *in[2] = {gp_input_of(a), gp_input_of(b)};
    const int n = in[0]->index->part[part].chunks;
    assert_int_equal(in[1]->index->part[part].chunks, n);
    for (int i = 0; i < n; i++) {
        uint8_t *bytes[2];
        uint64_t at, size[2];
        for (int k = 0; k < 2; k++) {
            assert_true(gp_exr_offsets_read(in[k], part, i, 1, &at));
            size[k] = gp_exr_chunk_bytes(in[k], part, at);
            assert_true(size[k] > 0);
            bytes[k] = malloc(size[k]);
            assert_non_null(bytes[k]);
            assert_int_equal(gp_stream_read(&in[k]->stream, bytes[k], size[k],
                                            at), size[k]);
        }
        assert_int_equal(size[0], size[1]);
        assert_memory_equal(bytes[0], bytes[1], size[0]);
        free(bytes[0]);
        free(bytes[1]);
    }
}

/* Planes of f's size in which every value is `add` larger than in f. */
static struct gp_planes lit(const struct gp_frame *f, float add)
{
    struct gp_planes p;
    assert_ok(gp_planes_make(NULL, "lit", gp_frame_pixels(f), &p));
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < gp_frame_pixels(f); i++)
            p.c[c][i] = f->rgb.c[c][i] + add;
    }
    return p;
}

static void assert_lit(const struct gp_frame *f, const struct gp_planes *want)
{
    wf_assert_planes(&f->rgb, want, gp_frame_pixels(f));
}

/* The colour of that layer of an open file. */
static void assert_layer_lit(const struct gp_frame *f, const char *layer,
    const struct gp_planes *want, enum gp_colour_model model)
{
    struct gp_frame c;
    assert_ok(gp_read_layer(&kept_all, &read_params, f, layer, &c));
    assert_int_equal(c.model, model);
    assert_lit(&c, want);
    gp_frame_free(&c);
}

static const struct wf_channel mixed[] = {
    {"A", GP_HALF, -1, 0, 0}, {"B", GP_HALF, 2, 0, 0},
    {"CryptoObject00.A", GP_FLOAT, -1, 0, 0},
    {"CryptoObject00.R", GP_FLOAT, -1, 0, 0}, {"G", GP_HALF, 1, 0, 0},
    {"R", GP_HALF, 0, 0, 0}, {"Z", GP_FLOAT, -1, 0, 0},
    {"diffuse.R", GP_FLOAT, -1, 0, 0}, {"id", GP_UINT, -1, 0, 0},
    {"light.R", GP_HALF, -1, 0, 0}, {NULL, 0, 0, 0, 0},
};

static void carried_bits(void **state)
{
    struct gp_frame made = wf_frame(window, window, mixed);
    wf_fill_bits(&made, false);
    for (int c = GP_COMPRESSION_NONE; c <= GP_COMPRESSION_PIZ; c++) {
        for (enum gp_out_type type = GP_OUT_AUTO; type <= GP_OUT_FLOAT;
             type++) {
            struct gp_write_params p = GP_WRITE_DEFAULTS;
            p.compression = c;
            p.type = type;
            assert_ok(wf_write_hdr(&p, "a.exr", &made));
            struct gp_frame a = read_as(wf_path("a.exr"), NULL);
            assert_carried(&made, &a);
            struct gp_planes planes = lit(&a, 1.0f);
            const struct gp_hdr_colour set = {&a, &planes};
            assert_ok(wf_write_set(&p, "b.exr", &set, 1));
            struct gp_frame b = read_as(wf_path("b.exr"), NULL);
            assert_carried(&made, &b);
            assert_lit(&b, &planes);
            gp_planes_free(&planes);
            free_frames(&a, &b);
        }
    }
    gp_frame_free(&made);
}

#define PART(label, ...)                                                      \
    {.name = label, .data = FIXTURE_WINDOW(-3, 5, 45, 40),                    \
     .compression = EXR_COMPRESSION_ZIPS, .channel = {__VA_ARGS__}}

static void layers_in_one_part(void **state)
{
    static const struct wf_channel list[] = {
        {"A", GP_HALF, -1, 0, 0},      {"B", GP_HALF, 2, 0, 0},
        {"G", GP_HALF, 1, 0, 0},       {"R", GP_HALF, 0, 0, 0},
        {"Z", GP_FLOAT, -1, 0, 0},     {"key.B", GP_FLOAT, -1, 0, 0},
        {"key.G", GP_FLOAT, -1, 0, 0}, {"key.R", GP_FLOAT, -1, 0, 0},
        {"mask", GP_FLOAT, -1, 0, 0},  {NULL, 0, 0, 0, 0},
    };
    struct gp_frame made = wf_frame(window, window, list);
    assert_ok(wf_write_hdr(NULL, "a.exr", &made));
    struct gp_frame a = read_as(wf_path("a.exr"), NULL), key, mask, b;
    assert_ok(gp_read_layer(&kept_all, &read_params, &a, "key", &key));
    assert_ok(gp_read_layer(&kept_all, &read_params, &a, "mask", &mask));
    assert_int_equal(key.channels, 3);
    assert_int_equal(key.colour_type, GP_FLOAT);
    assert_int_equal(mask.channels, 1);
    struct gp_planes pa = lit(&a, 1), pk = lit(&key, 2), pm = lit(&mask, 3);
    const struct gp_hdr_colour set[3] = {{&a, &pa}, {&key, &pk}, {&mask, &pm}};
    assert_ok(wf_write_set(NULL, "b.exr", set, 3));
    b = read_as(wf_path("b.exr"), NULL);
    assert_lit(&b, &pa);
    assert_layer_lit(&b, "key", &pk, GP_COLOUR_RGB);
    assert_layer_lit(&b, "mask", &pm, GP_COLOUR_GREY);
    assert_int_equal(b.channels, a.channels);
    const struct gp_channel *z = gp_frame_channel(&b, "Z");
    assert_memory_equal(z->data, gp_frame_channel(&a, "Z")->data,
                        gp_frame_pixels(&a) * 4);
    gp_frame_free(&b);
    // the mask has a colour: a layer of its name, since R is the beauty's
    pm.c[0][0] += 1.0f;
    assert_ok(wf_write_set(NULL, "b.exr", set, 3));
    b = read_as(wf_path("b.exr"), NULL);
    assert_null(gp_frame_channel(&b, "mask"));
    assert_layer_lit(&b, "mask", &pm, GP_COLOUR_RGB);
    assert_lit(&b, &pa);
    gp_frame_free(&b);
    struct gp_planes *const planes[] = {&pa, &pk, &pm};
    struct gp_frame *const frames[] = {&key, &mask, &a, &made};
    for (int i = 0; i < 3; i++)
        gp_planes_free(planes[i]);
    for (int i = 0; i < 4; i++)
        gp_frame_free(frames[i]);
}

static void layers_in_parts(void **state)
{
    static const struct fixture file = {
        .part = {PART("normals", RGB(FLOATS), FLOAT_CH("Z")),
                 PART("beauty", HALF_CH("A"), RGB(HALVES)),
                 PART("key", RGB(FLOATS), FLOAT_CH("Z"))},
        .parts = 3,
    };
    struct gp_read_params q = GP_READ_DEFAULTS;
    fixture_write_file(wf_path("a.exr"), &file);
    struct gp_frame a, key, b, c;
    q.part = "beauty";
    assert_ok(gp_read_frame(&kept_all, &q, wf_path("a.exr"), &a));
    assert_int_equal(a.part, 1);
    assert_ok(gp_read_layer(&kept_all, &q, &a, "key", &key));
    struct gp_planes pa = lit(&a, 1), pk = lit(&key, 2);
    const struct gp_hdr_colour set[2] = {{&a, &pa}, {&key, &pk}};
    for (int n = 1; n <= 2; n++) {
        assert_ok(wf_write_set(NULL, "b.exr", set, n));
        assert_ok(gp_read_frame(&kept_all, &q, wf_path("b.exr"), &b));
        assert_int_equal(b.part, 1);
        assert_lit(&b, &pa);
        assert_carried(&a, &b);
        assert_chunks(&a, &b, 0);
        if (n == 1)
            assert_chunks(&a, &b, 2);
        assert_ok(gp_read_layer(&kept_all, &q, &b, "key", &c));
        assert_lit(&c, n == 1 ? &key.rgb : &pk);
        assert_carried(&key, &c);
        free_frames(&c, &b);
    }
    gp_planes_free(&pa);
    gp_planes_free(&pk);
    free_frames(&key, &a);
}

static void add_views(exr_context_t exr, int part)
{
    const char *views[] = {"left", "right"};
    assert_ok(exr_attr_set_string_vector(exr, part, "multiView", 2, views));
}

/* Both eyes of one part, each read as a frame of its own. */
static void views_in_one_part(void **state)
{
    static const struct fixture file = {
        .part = {PART(NULL, RGB(HALVES), FLOAT_CH("Z"), HALF_CH("right.B"),
                      HALF_CH("right.G"), HALF_CH("right.R"))},
        .more = add_views,
    };
    static const char *const view[2] = {"left", "right"};
    struct gp_frame eye[2];
    struct gp_planes planes[2];
    struct gp_hdr_colour set[2];
    fixture_write_file(wf_path("a.exr"), &file);
    for (int i = 0; i < 2; i++) {
        eye[i] = read_as(wf_path("a.exr"), view[i]);
        planes[i] = lit(&eye[i], 1.0f + (float) i);
        set[i] = (struct gp_hdr_colour) {&eye[i], &planes[i]};
    }
    assert_ok(wf_write_set(NULL, "b.exr", set, 2));
    for (int i = 0; i < 2; i++) {
        struct gp_frame b = read_as(wf_path("b.exr"), view[i]);
        assert_lit(&b, &planes[i]);
        assert_int_equal(b.channels, 7);
        assert_memory_equal(gp_frame_channel(&b, "Z")->data,
            gp_frame_channel(&eye[i], "Z")->data, gp_frame_pixels(&b) * 4);
        gp_frame_free(&b);
        gp_planes_free(&planes[i]);
        gp_frame_free(&eye[i]);
    }
}

static void refused(void **state)
{
    static const struct fixture file = {
        .part = {PART("a", RGB(HALVES), FLOAT_CH("key")),
                 PART("b", RGB(HALVES))},
        .parts = 2,
    };
    struct gp_frame a, again, key;
    fixture_write_file(wf_path("a.exr"), &file);
    a = read_as(wf_path("a.exr"), NULL);
    assert_ok(gp_read_layer(&kept_all, &read_params, &a, "a", &again));
    assert_ok(gp_read_layer(&kept_all, &read_params, &a, "key", &key));
    const struct gp_hdr_colour twice[2] = {{&a, &a.rgb}, {&again, &again.rgb}};
    const struct gp_hdr_colour lone[1] = {{&key, &key.rgb}};
    assert_int_equal(wf_write_set(NULL, "b.exr", twice, 2), GP_ERR_USAGE);
    assert_kept("is the colour of 2 layers");
    assert_int_equal(wf_write_set(NULL, "b.exr", lone, 1), GP_ERR_BUG);
    assert_int_equal(wf_names(), 1);
    free_frames(&key, &again, &a);
}

/* Attributes of the colour part that may not be what they were. */
static bool is_own(const char *name)
{
    static const char *const own[] = {
        "compression", "lineOrder", "tiles", "type", "channels", "chunkCount",
    };
    for (size_t i = 0; i < COUNT(own); i++) {
        if (strcmp(own[i], name) == 0)
            return true;
    }
    return false;
}

static void assert_headers(const struct gp_frame *a, const struct gp_frame *b)
{
    const struct gp_exr_index_part *const p = gp_input_of(a)->index->part;
    const struct gp_exr_index_part *const q = gp_input_of(b)->index->part;
    assert_int_equal(gp_input_of(a)->parts, gp_input_of(b)->parts);
    for (int i = 0; i < gp_input_of(a)->parts; i++) {
        for (int k = 0; k < p[i].attrs; k++) {
            const struct gp_exr_attr *x = &p[i].attr[k];
            const struct gp_exr_attr *y =
                gp_exr_attr_find(&q[i], x->name, x->type);
            if (i == a->part && is_own(x->name))
                continue;
            if (!y || x->size != y->size || memcmp(x->data, y->data, x->size))
                fail_msg("%s: attribute %s of part %d", a->path, x->name, i);
        }
    }
}

/* A frame that is read, written and read again is the same: colour, carried
 * channels and attributes. The folder is $GLAREPP_DATA, or ../shared/data; without it
 * the test is skipped. */
static void real_frames(void **state)
{
    static const char *const names[] = {
        "camera/arnold_multichannel_tiled64.exr",
        "channels/channelTestNukePartPerLayer.exr",
        "channels/channelTestNukeSinglePart.exr",
        "channels/channelTestPartPerLayer.exr", "chromaticities/XYZ.exr",
        "depth/Beachball_multipart.0001.exr",
        "depth/gaffer_multipart_customDepth.exr", "depth/v1.7.test.1_RGBZ.exr",
        "luminance_chroma/Rec709_YC.exr", "multiview/Fog_Y_2views.exr",
        "patterns/BrightRingsNanInf.exr", "patterns/WideFloatRange.exr",
        "rendered/brightsky.1001.exr",
        "seq_foliage/foliage_blender_multilayer.1004.exr", "windows_dw/t05.exr",
        "windows_dw/t08.exr",
    };
    int tried = 0;
    for (size_t i = 0; i < COUNT(names); i++) {
        const char *const path = data_path(names[i]);
        struct gp_frame a, b;
        struct gp_write_params p = GP_WRITE_DEFAULTS;
        if (access(path, R_OK) != 0)
            continue;
        tried++;
        if (gp_read_frame(&kept_all, &read_params, path, &a))
            fail_msg("%s", kept_line);
        // luminance-chroma comes back as RGB, of which half would lose bits
        p.type = a.model == GP_COLOUR_YC ? GP_OUT_FLOAT : GP_OUT_AUTO;
        if (wf_write_hdr(&p, "a.exr", &a) ||
            gp_read_frame(&kept_all, &read_params, wf_path("a.exr"), &b))
            fail_msg("%s", kept_line);
        assert_memory_equal(&a.data, &b.data, sizeof a.data);
        assert_memory_equal(&a.display, &b.display, sizeof a.display);
        assert_memory_equal(a.chromaticities, b.chromaticities,
                            sizeof a.chromaticities);
        wf_assert_planes(&a.rgb, &b.rgb, gp_frame_pixels(&a));
        assert_carried(&a, &b);
        assert_headers(&a, &b);
        free_frames(&a, &b);
    }
    if (tried == 0)
        skip_for(NO_DATA);
}

SUITE_OF_EACH(hdr_parts, wf_start, remove_folder, carried_bits, layers_in_one_part,
         layers_in_parts, views_in_one_part, refused, real_frames)
