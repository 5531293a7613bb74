// SPDX-License-Identifier: Apache-2.0
/* The layer, part and view of a file that is the frame: every way of naming
 * one, and the lines for names that do not exist. */
#include "unit.h"
#include "exr_fixture.h"
#include "reading.h"
#include "io/channels.h"
#include "io/exr/exr_priv.h"

enum { W = 13, H = 9 };

static void add_view(exr_context_t exr, int part)
{
    static const char *const view[] = {"left", "right", "right"};
    assert_ok(exr_attr_set_string(exr, part, "view", view[part]));
}

static void add_views(exr_context_t exr, int part)
{
    const char *views[] = {"left", "right"};
    assert_ok(exr_attr_set_string_vector(exr, part, "multiView", 2, views));
}

static void add_manifest(exr_context_t exr, int part)
{
    assert_ok(exr_attr_set_string(exr, part, "cryptomatte/1/name", "aids"));
    assert_ok(exr_attr_set_string(exr, part, "cryptomatte/1/hash", "light"));
}

#define PART(label, ...)                                                      \
    {.name = label, .data = FIXTURE_WINDOW(-2, 3, W, H),                      \
     .compression = EXR_COMPRESSION_ZIP, .channel = {__VA_ARGS__}}
#define LAYER(name, type)                                                     \
    {name ".B", type, 0, 0}, {name ".G", type, 0, 0}, {name ".R", type, 0, 0}

static const struct fixture single = {
    .part = {PART(NULL, RGB(HALVES), LAYER("diffuse", FLOATS),
                  UINT_CH("grey"), HALF_CH("key.Y"))},
};
static const struct fixture parts = {
    .part = {PART("rgba", RGB(HALVES)),
             PART("diffuse", RGB(FLOATS), FLOAT_CH("Z")),
             PART("rest", HALF_CH("spec.blue"), HALF_CH("spec.green"),
                  HALF_CH("spec.red"))},
    .parts = 3,
};
static const struct fixture stereo = {
    .part = {PART("rgba.left", RGB(HALVES)), PART("rgba_right", RGB(HALVES)),
             PART("diffuse.right", RGB(HALVES))},
    .parts = 3, .more = add_view,
};
static const struct fixture multiview = {
    .part = {PART(NULL, RGB(HALVES), HALF_CH("diffuse.R"),
                  HALF_CH("diffuse.right.R"), LAYER("right", HALVES))},
    .more = add_views,
};
static const struct fixture ids = {
    .part = {PART(NULL, LAYER("ViewLayer.CryptoObject00", FLOATS),
                  LAYER("aids", HALVES), LAYER("aids00", FLOATS),
                  LAYER("light", HALVES))},
    .more = add_manifest,
};
static const struct fixture ids_part = {
    .part = {PART("crypto_asset00", RGB(FLOATS)), PART("beauty", RGB(HALVES))},
    .parts = 2,
};
static const struct fixture windows = {
    .part = {PART("rgba", RGB(HALVES)),
             {.name = "small", .data = FIXTURE_WINDOW(-2, 3, W, H - 1),
              .compression = EXR_COMPRESSION_ZIP, .channel = {RGB(HALVES)}}},
    .parts = 2,
};
static const struct fixture deep = {
    .part = {{.name = "deep", .data = W(3), .deep = true,
              .compression = EXR_COMPRESSION_ZIPS, .channel = {RGB(HALVES)}}},
};

static gp_status read_as(const struct fixture *file, const char *layer,
    const char *part, const char *view, struct gp_frame *f)
{
    struct gp_read_params p = GP_READ_DEFAULTS;
    p.layer = layer;
    p.part = part;
    p.view = view;
    fixture_write_file(in_folder("in.exr"), file);
    kept_clear();
    *f = (struct gp_frame) {0};
    return gp_read_frame(&kept_log, &p, path, f);
}

/* Every pixel of each colour is that of the named channel. */
static void assert_colour(const struct gp_frame *f, const char *const name[3])
{
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < W * H; i++) {
            const int x = i % W - 2, y = i / W + 3;
            const float want =
                !name[c] ? 0.0f
                : strcmp(name[c], "grey") == 0
                    ? (float) fixture_uint("grey", x, y)
                    : fixture_value(name[c], x, y);
            if (f->rgb.c[c][i] != want)
                fail_msg("%s: pixel %d of colour %d is %g", name[c], i, c,
                         (double) f->rgb.c[c][i]);
        }
    }
    for (int i = 0; i < f->channels; i++) {
        const struct gp_channel *c = &f->channel[i];
        if (c->colour >= 0)
            assert_string_equal(c->name, name[c->colour]);
    }
}

struct row {
    const struct fixture *file;
    const char *layer, *part, *view;
    int want;             // part
    const char *name[3];  // of the colour's channels
};

#define OF(l) {l ".R", l ".G", l ".B"}
#define PLAIN {"R", "G", "B"}

/* The same as a further layer of an open file, which is not opened again,
 * whatever a stage after the reader did to its colour. */
static void assert_layer(const struct row *r)
{
    struct gp_read_params p = GP_READ_DEFAULTS;
    struct gp_frame f, layer;
    p.view = r->view;
    p.part = "7"; // does not count
    assert_ok(read_as(r->file, NULL, NULL, NULL, &f));
    assert_int_equal(remove(path), 0);
    for (int c = 0; c < 3; c++)
        f.rgb.c[c][5] = -1.0f;
    if (gp_read_layer(&kept_log, &p, &f, r->layer, &layer))
        fail_msg("layer %s: %s", r->layer, kept_line);
    assert_int_equal(layer.part, r->want);
    assert_memory_equal(&layer.data, &f.data, sizeof f.data);
    assert_memory_equal(&layer.display, &f.display, sizeof f.data);
    assert_ptr_equal(layer.input, f.input);
    assert_colour(&layer, r->name);
    gp_frame_free(&layer);
    gp_frame_free(&f);
}

static void found(void **state)
{
    static const struct row rows[] = {
        {&single, NULL, NULL, NULL, 0, PLAIN},
        {&single, "", NULL, NULL, 0, PLAIN},
        {&single, "diffuse", NULL, NULL, 0, OF("diffuse")},
        {&single, "diffuse", "0", NULL, 0, OF("diffuse")},
        {&single, "key", NULL, NULL, 0, {"key.Y", "key.Y", "key.Y"}},
        {&single, "grey", NULL, NULL, 0, {"grey", "grey", "grey"}},
        {&parts, NULL, NULL, NULL, 0, PLAIN},
        {&parts, "rgba", NULL, NULL, 0, PLAIN},
        {&parts, "diffuse", NULL, NULL, 1, PLAIN},
        {&parts, NULL, "1", NULL, 1, PLAIN},
        {&parts, NULL, "diffuse", NULL, 1, PLAIN},
        {&parts, "Z", "1", NULL, 1, {"Z", "Z", "Z"}},
        {&parts, NULL, "rest", NULL, 2,
         {"spec.red", "spec.green", "spec.blue"}},
        {&parts, "spec", NULL, NULL, 2,
         {"spec.red", "spec.green", "spec.blue"}},
        {&stereo, NULL, NULL, NULL, 0, PLAIN},
        {&stereo, NULL, NULL, "left", 0, PLAIN},
        {&stereo, NULL, NULL, "right", 1, PLAIN},
        {&stereo, "rgba", NULL, "right", 1, PLAIN},
        {&stereo, "rgba", NULL, NULL, 0, PLAIN},
        {&stereo, "rgba_right", NULL, NULL, 1, PLAIN},
        {&stereo, "right", NULL, NULL, 1, PLAIN},
        {&stereo, "diffuse", NULL, NULL, 2, PLAIN},
        {&stereo, "right.diffuse", NULL, NULL, 2, PLAIN},
        {&stereo, "diffuse.right", NULL, NULL, 2, PLAIN},
        {&stereo, NULL, "2", "right", 2, PLAIN},
        {&multiview, NULL, NULL, NULL, 0, PLAIN},
        {&multiview, NULL, NULL, "left", 0, PLAIN},
        {&multiview, NULL, NULL, "right", 0, OF("right")},
        {&multiview, "right", NULL, NULL, 0, OF("right")},
        {&multiview, "left", NULL, NULL, 0, PLAIN},
        {&multiview, "diffuse", NULL, "left", 0, {"diffuse.R", NULL, NULL}},
        {&multiview, "diffuse", NULL, "right", 0,
         {"diffuse.right.R", NULL, NULL}},
        {&multiview, "right.diffuse", NULL, NULL, 0,
         {"diffuse.right.R", NULL, NULL}},
        {&multiview, "diffuse.right", NULL, NULL, 0,
         {"diffuse.right.R", NULL, NULL}},
        {&ids, NULL, NULL, NULL, 0, OF("light")},
        {&ids, "light", NULL, NULL, 0, OF("light")},
        {&ids_part, NULL, NULL, NULL, 1, PLAIN},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct row *r = &rows[i];
        struct gp_frame f;
        if (read_as(r->file, r->layer, r->part, r->view, &f))
            fail_msg("row %zu: %s", i, kept_line);
        assert_int_equal(f.part, r->want);
        assert_int_equal(gp_input_of(&f)->part, r->want);
        assert_colour(&f, r->name);
        gp_frame_free(&f);
        if (!r->part)
            assert_layer(r);
    }
}

/* The line has what was asked for, then the names that there are. */
static void not_found(void **state)
{
    static const struct {
        const struct fixture *file;
        const char *layer, *part, *view, *what;
    } rows[] = {
        {&single, "diff", NULL, NULL, "layer diff (layers: diffuse, key; "},
        {&single, "diffuse.R.", NULL, NULL, "layer diffuse.R. ("},
        {&single, NULL, "1", NULL, "part 1 ("},
        {&single, NULL, "-1", NULL, "part -1 ("},
        {&single, NULL, "99999999999999999999", NULL, "part 9999"},
        {&single, NULL, "", NULL, "part  ("},
        {&single, NULL, NULL, "left", "view left ("},
        {&parts, "spec", "0", NULL, "layer spec in part 0 (layers: "
         "rgba, diffuse, spec; parts: 0 rgba, 1 diffuse, 2 rest; views: none"},
        {&stereo, "diffuse", NULL, "left", "layer diffuse of view left"},
        {&stereo, NULL, "0", "right", "part 0 of view right"},
        {&stereo, NULL, NULL, "mid", "views: left, right)"},
        {&stereo, "mid.rgba", NULL, NULL, "layers: rgba, diffuse;"},
        {&multiview, "right", NULL, "right", "layer right of view"},
        {&multiview, "diffuse.mid", NULL, NULL, "views: left, right)"},
        {&ids, "aids00", NULL, NULL, "aids00 is "},
        {&ids, "aids", NULL, NULL, "aids is "},
        {&ids, "aids00.R", NULL, NULL, "aids00.R is "},
        {&ids, "ViewLayer.CryptoObject00", NULL, NULL, "CryptoObject00 is "},
        {&ids, "ViewLayer", NULL, NULL, "layer ViewLayer ("},
        {&ids_part, "crypto_asset00", NULL, NULL, "asset00 is "},
        {&ids_part, "crypto_asset", NULL, NULL, "layer crypto_asset ("},
        {&ids_part, NULL, "0", NULL, "part 0 ("},
        {&deep, "deep", NULL, NULL, "layer deep"}, // passed over
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_frame f;
        assert_int_equal(read_as(rows[i].file, rows[i].layer, rows[i].part,
                                 rows[i].view, &f), GP_ERR_USAGE);
        if (kept_errors != 1 || !strstr(kept_line, rows[i].what) ||
            !strstr(kept_line, "; ")) // the hint
            fail_msg("row %zu: %s", i, kept_line);
        assert_null(f.rgb.c[0]);
    }
}

static void further_refused(void **state)
{
    static const struct {
        const struct fixture *file;
        const char *layer;
        gp_status st;
        const char *what;
    } rows[] = {
        {&parts, "none", GP_ERR_USAGE, " none ("},
        {&ids, "aids00", GP_ERR_USAGE, "aids00"},
        {&windows, "small", GP_ERR_DATA, "small (part 1)"},
    };
    const struct gp_read_params p = GP_READ_DEFAULTS;
    struct gp_frame f, layer = {0};
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_ok(read_as(rows[i].file, NULL, NULL, NULL, &f));
        assert_int_equal(gp_read_layer(&kept_log, &p, &f, rows[i].layer,
                                       &layer), rows[i].st);
        assert_int_equal(kept_errors, 1);
        assert_kept(rows[i].what);
        assert_null(layer.rgb.c[0]);
        gp_frame_free(&f);
    }
    f = (struct gp_frame) {.path = "made"};
    assert_int_equal(gp_read_layer(&kept_log, &p, &f, "a", &layer),
                     GP_ERR_USAGE);
}

SUITE_OF(layers, make_folder, remove_folder, found, not_found,
         further_refused)
