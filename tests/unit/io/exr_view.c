// SPDX-License-Identifier: Apache-2.0
/* io/exr/choose.c, io/plane: views, layers and ids
 * that attributes and names of parts tell of. */
#include "unit.h"
#include "io/channels.h"
#include "io/exr/exr_priv.h"
#include "io/io_priv.h"
#include "plane_fixture.h"

/* The attributes of the next file. */
static struct attributes {
    const char *view[2];     // of part 0; the first is the default
    int views;
    const char *own;         // "view" of part own_part, NULL: none
    int own_part;
} say;

static void add_attributes(exr_context_t exr, int part)
{
    if (part == 0 && say.views)
        assert_ok(exr_attr_set_string_vector(exr, 0, "multiView", say.views,
                                             say.view));
    if (part == say.own_part && say.own)
        assert_ok(exr_attr_set_string(exr, part, "view", say.own));
}

#define PART(called, ...)                                                     \
    {.name = called, .channel = {__VA_ARGS__}, .data = W(3),                  \
     .compression = EXR_COMPRESSION_ZIP}

static void write_parts(const struct fixture_part *part, int parts)
{
    struct fixture f = {.parts = parts, .more = add_attributes};
    memcpy(f.part, part, (size_t) parts * sizeof *part);
    fixture_write_file(in_folder("v.exr"), &f);
}

/* The frame of a file with these parts. */
static void open_parts(const struct fixture_part *part, int parts,
                       struct gp_frame *frame)
{
    write_parts(part, parts);
    assert_ok(read_file(path, frame));
}

static void layer_of_a_part(void **state)
{
    static const struct {
        const char *name, *view, *layer;
    } row[] = {
        {"rgba.left", "left", "rgba"},  {"rgba_left", "left", "rgba"},
        {"rgbaleft", "left", "rgbaleft"}, {"left", "left", "left"},
        {".left", "left", ".left"},     {"a.left", "left", "a"},
        {"rgba", "left", "rgba"},       {"rgba.right", "left", "rgba.right"},
        {"rgba.left", "", "rgba.left"}, {"rgba.left", NULL, "rgba.left"},
        {"le.left", "left", "le"},      {"l", "left", "l"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        const struct fixture_part part = PART(row[i].name, RGB(HALVES));
        struct gp_frame frame;
        say = (struct attributes) {.own = row[i].view};
        open_parts(&part, 1, &frame);
        const struct gp_exr_part *const own = gp_input_of(&frame)->each;
        assert_int_equal(own->length, strlen(row[i].layer));
        assert_memory_equal(own->layer, row[i].layer, own->length);
        gp_frame_free(&frame);
    }
}

static void names_within_a_view(void **state)
{
    static const struct {
        const char *view, *name, *bare;
        bool belongs;
        const char *of; // NULL: the default view or none
    } row[] = {
        {"left", "R", "R", true, NULL}, {"right", "R", "R", false, NULL},
        {"right", "right.R", "R", true, "right"},
        {"left", "right.R", "R", false, "right"},
        {"left", "left.R", "R", true, NULL},
        {"right", "a.right.R", "a.R", true, "right"},
        {"right", "a.b.right.R", "a.b.R", true, "right"},
        {"left", "reght.R", "reght.R", true, NULL}, // as long as a view
        {"right", "reght.R", "reght.R", false, NULL},
        {"right", "right", "right", false, NULL},
        {"right", "right.a.R", "right.a.R", false, NULL},
        {"left", ".R", ".R", true, NULL},
    };
    const struct fixture_part part = PART("p", RGB(HALVES));
    struct gp_frame frame;
    say = (struct attributes) {.view = {"left", "right"}, .views = 2};
    open_parts(&part, 1, &frame);
    const struct gp_input *const o = gp_input_of(&frame);
    for (size_t i = 0; i < COUNT(row); i++) {
        char bare[GP_CHANNEL_NAME + 1];
        assert_int_equal(gp_exr_bare_name(o, 0, row[i].view, row[i].name,
                                          bare), row[i].belongs);
        assert_string_equal(bare, row[i].bare);
        const char *const of = gp_exr_view_of(o, 0, row[i].name);
        assert_string_equal(of ? of : "-", row[i].of ? row[i].of : "-");
    }
    gp_frame_free(&frame);
}

#define RIGHT HALF_CH("right.B"), HALF_CH("right.G"), HALF_CH("right.R")

static void planes_of_a_view(void **state)
{
    static const struct {
        struct fixture_part part[2];
        int parts;
        const char *name;
        bool depth;
        gp_status st;
        const char *want; // the plane's name, NULL: none
        int from;
        const char *text; // NULL: nothing
    } row[] = {
        // the view's own, by search and by its bare name
        {{PART("p", RGB(HALVES), HALF_CH("Z"), RIGHT, HALF_CH("right.Z"))},
         1, NULL, true, GP_OK, "right.Z", 0, NULL},
        {{PART("p", RGB(HALVES), HALF_CH("Z"), RIGHT, HALF_CH("right.Z"))},
         1, "Z", true, GP_OK, "right.Z", 0, NULL},
        {{PART("p", HALF_CH("A"), RGB(HALVES), HALF_CH("right.A"), RIGHT)},
         1, NULL, false, GP_OK, "right.A", 0, NULL},
        {{PART("p", HALF_CH("A"), RGB(HALVES), RIGHT)},
         1, NULL, false, GP_OK, "A", 0, NULL},
        // another view's, with a warning
        {{PART("p", RGB(HALVES), HALF_CH("Z"), RIGHT)},
         1, NULL, true, GP_OK, "Z", 0, "layer and view have no depth: using Z "
                                       "of another; "},
        // another part's, of no view
        {{PART("p", RGB(HALVES), RIGHT), PART("z", HALF_CH("Z"))},
         2, NULL, true, GP_OK, "z.Z", 1, NULL},
        {{PART("p", RGB(HALVES), RIGHT)}, 1, NULL, true, GP_OK, NULL, 0, NULL},
        // two of one rank in the view
        {{PART("p", RGB(HALVES), HALF_CH("a.right.Z"), HALF_CH("b.right.Z"),
               RIGHT)},
         1, NULL, true, GP_ERR_DATA, NULL, 0, "a.Z and b.Z"},
        {{PART("p", RGB(HALVES), RIGHT)}, 1, "Z", true, GP_ERR_USAGE, NULL, 0,
         "has no channel Z (it has B, G, R, right.B, right.G, right.R)"},
    };
    struct gp_read_params of_right = GP_READ_DEFAULTS;
    of_right.view = "right";
    say = (struct attributes) {.view = {"left", "right"}, .views = 2};
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_frame frame;
        struct gp_plane p = {0};
        write_parts(row[i].part, row[i].parts);
        assert_ok(gp_read_frame(&kept_log, &of_right, path, &frame));
        kept_clear();
        assert_int_equal(gp_read_plane(&kept_all, &of_right, &frame, row[i].name,
                                       row[i].depth, &p), row[i].st);
        assert_int_equal(kept_lines != 0, row[i].text != NULL);
        if (row[i].text && !strstr(kept_line, row[i].text))
            fail_msg("row %zu: %s", i, kept_line);
        assert_int_equal(p.v != NULL, row[i].want != NULL);
        if (row[i].want) {
            const char *const channel = row[i].from ? "Z" : row[i].want;
            assert_string_equal(p.name, row[i].want);
            assert_plane(&p, &row[i].part[row[i].from], channel);
        }
        gp_plane_free(&p);
        gp_frame_free(&frame);
    }
}

SUITE_OF(exr_view, make_folder, remove_folder, layer_of_a_part,
         names_within_a_view, planes_of_a_view)
