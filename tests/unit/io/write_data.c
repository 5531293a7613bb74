/* --hdr of real frames: what was read, written and read again is the same,
 * colour, carried channels and attributes. The folder is $GLAREPP_DATA, or
 * ../shared/data; without it the test is skipped. */
#include "unit.h"
#include "write_fixture.h"

#include "io/exr/exr_priv.h"
#include "io/read.h"

static const struct gp_read_params read_params = GP_READ_DEFAULTS;

/* Attributes of the colour part that may not be what they were. */
static bool is_own(const char *name)
{
    static const char *const own[] = {
        "compression", "lineOrder", "tiles", "type", "channels", "chunkCount",
    };
    for (size_t i = 0; i < sizeof own / sizeof *own; i++) {
        if (strcmp(own[i], name) == 0)
            return true;
    }
    return false;
}

static void assert_headers(const struct gp_frame *a, const struct gp_frame *b)
{
    struct gp_exr_carried p, q;
    assert_ok(gp_exr_carried_read(&wf_log, a->path, gp_input_of(a), &p));
    assert_ok(gp_exr_carried_read(&wf_log, b->path, gp_input_of(b), &q));
    assert_int_equal(gp_input_of(a)->parts, gp_input_of(b)->parts);
    for (int i = 0; i < gp_input_of(a)->parts; i++) {
        for (int k = 0; k < p.part[i].attrs; k++) {
            const struct gp_exr_attr *x = &p.part[i].attr[k];
            const struct gp_exr_attr *y =
                gp_exr_attr_find(&q.part[i], x->name, x->type);
            if (i == a->part && is_own(x->name))
                continue;
            if (!y || x->size != y->size || memcmp(x->data, y->data, x->size))
                fail_msg("%s: attribute %s of part %d", a->path, x->name, i);
        }
    }
    gp_exr_carried_free(&p);
    gp_exr_carried_free(&q);
}

static void assert_pixels(const struct gp_frame *a, const struct gp_frame *b)
{
    assert_memory_equal(&a->data, &b->data, sizeof a->data);
    assert_memory_equal(&a->display, &b->display, sizeof a->display);
    assert_memory_equal(a->chromaticities, b->chromaticities,
                        sizeof a->chromaticities);
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
    wf_assert_planes(&a->rgb, &b->rgb, gp_frame_pixels(a));
}

static void real_frames(void **state)
{
    static const char *const names[] = {
        "camera/arnold_multichannel_tiled64.exr",
        "channels/channelTestNukePartPerLayer.exr",
        "channels/channelTestNukeSinglePart.exr",
        "channels/channelTestPartPerLayer.exr",
        "chromaticities/XYZ.exr",
        "depth/Beachball_multipart.0001.exr",
        "depth/gaffer_multipart_customDepth.exr",
        "depth/v1.7.test.1_RGBZ.exr",
        "luminance_chroma/Rec709_YC.exr",
        "multiview/Fog_Y_2views.exr",
        "patterns/BrightRingsNanInf.exr",
        "patterns/WideFloatRange.exr",
        "rendered/brightsky.1001.exr",
        "seq_foliage/foliage_blender_multilayer.1004.exr",
        "windows_dw/t05.exr",
        "windows_dw/t08.exr",
    };
    const char *data = getenv("GLAREPP_DATA");
    int tried = 0;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char path[4096];
        struct gp_frame a, b;
        struct gp_write_params p = GP_WRITE_DEFAULTS;
        snprintf(path, sizeof path, "%s/%s", data ? data : "../shared/data",
                 names[i]);
        if (access(path, R_OK) != 0)
            continue;
        tried++;
        if (gp_read_frame(&wf_log, &read_params, path, &a))
            fail_msg("%s", wf_line);
        // luminance-chroma comes back as RGB, of which half would lose bits
        p.type = a.model == GP_COLOUR_YC ? GP_OUT_FLOAT : GP_OUT_AUTO;
        if (wf_write_hdr(&p, "a.exr", &a) ||
            gp_read_frame(&wf_log, &read_params, wf_path("a.exr"), &b))
            fail_msg("%s", wf_line);
        assert_pixels(&a, &b);
        assert_headers(&a, &b);
        gp_frame_free(&a);
        gp_frame_free(&b);
    }
    if (tried == 0)
        skip();
}

SUITE(write_data)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(real_frames, wf_start, wf_end),
    };
    return cmocka_run_group_tests(tests, find_bridges, NULL);
}
