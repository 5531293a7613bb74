/* io and sun: memory that is full and files that fail, at the first call, at
 * the second, and so on until the whole work is done without a fault. Each
 * time: the documented status, one line, nothing in the outputs, and no file
 * left. (The sanitizers and valgrind see what would leak.) */
#include "core/parallel.h"
#include "exr_fixture.h"
#include "fail.h"
#include "io/file.h"
#include "io/plane.h"
#include "io/read.h"
#include "io/sequence.h"
#include "reading.h"
#include "sun/flare.h"
#include "sun/lights.h"
#include "unit.h"
#include "write_fixture.h"

#include <fcntl.h>

/* Planes of several kinds beside the colour. */
static const struct fixture parts = {
    .parts = 2, .part = {
        {.name = "main", .channel = {HALF_CH("A"), RGB(HALVES),
                     FLOAT_CH("Z"), HALF_CH("fog.B"),
                     HALF_CH("fog.G"), HALF_CH("fog.R"), UINT_CH("id")},
         .data = W(12), .compression = EXR_COMPRESSION_ZIP},
        {.name = "one.left", .channel = {FLOAT_CH("mask"),
                     {"wide", HALVES, 2, 2}},
         .data = FIXTURE_WINDOW(-4, 8, 6, 16),
         .compression = EXR_COMPRESSION_RLE},
    },
};
static const struct fixture tiles = {
    .part = {{.channel = {RGB(FLOATS)}, .data = W(20), .tile = 8,
              .compression = EXR_COMPRESSION_ZIP, .mipmap = true}},
};
static const struct fixture yc = {
    .part = {{.channel = {{"BY", HALVES, 2, 2}, {"RY", HALVES, 2, 2},
                          {"Y", HALVES, 1, 1}},
              .data = W(12), .compression = EXR_COMPRESSION_PIZ}},
};
static const struct fixture depth = {
    .part = {{.channel = {FLOAT_CH("Z")}, .data = W(9),
              .compression = EXR_COMPRESSION_ZIPS}},
};

static const struct {
    const char *name, *text;
} texts[] = {
    {"s.0001.exr", "no frame"}, {"s.0012.exr", "no frame"},
    {"lights.json", "[{\"pixel\": [1, 2], \"radius\": 2, \"flux\": [1, 2, 3]},"
     " {\"direction\": [0, 1, 0], \"flux\": 3}]"},
    {"flare.json", "{\"elements\": [{\"shape\": \"disc\", \"position\": 1,"
     " \"size\": 0.1, \"color\": 1}, {\"shape\": \"image\","
     " \"position\": 0, \"size\": 1, \"image\": \"a.exr\"}]}"},
    {"camera.json",
     "{\"frames\": [{\"frame\": 1, \"worldToNDC_rowmajor\": [1,0,0,0,"
     " 0,1,0,0, 0,0,1,-1, 0,0,0,1]}]}"},
};

static void save_twice(const char *name, const struct fixture *f)
{
    size_t size;
    uint8_t *bytes = fixture_make(f, &size);
    bytes = realloc(bytes, 2 * size);
    assert_non_null(bytes);
    memcpy(bytes + size, bytes, size);
    fixture_save(wf_path(name), bytes, 2 * size);
    free(bytes);
}

enum { POINTS_MAX = 20000 }; // more than any row has

static struct gp_frame made;        // of no file
static struct gp_frame from_parts;  // read from parts.exr

// -- the work -----------------------------------------------------------------

static const struct gp_read_params limits = GP_READ_DEFAULTS;

/* A reader: what it gives is empty where it fails, and freed. */
#define READER(called, kind, call, member, end)                               \
    static gp_status called(const char *argument)                             \
    {                                                                         \
        kind got = {0};                                                       \
        const gp_status st = call;                                            \
        assert_true(!st || !got member);                                      \
        end;                                                                  \
        return st;                                                            \
    }
READER(read_any, struct gp_frame,
       gp_read_frame(&kept_log, &limits, wf_path(argument), &got), .rgb.c[0],
       gp_frame_free(&got))
READER(read_layer, struct gp_frame,
       gp_read_layer(&kept_log, &limits, &from_parts, argument, &got),
       .rgb.c[0], gp_frame_free(&got))
READER(read_mask, struct gp_plane,
       gp_read_plane_file(&kept_log, &limits, wf_path(argument), "G", false,
                          &got), .v, gp_plane_free(&got))
READER(read_depth, struct gp_plane,
       gp_read_plane_file(&kept_log, &limits, wf_path(argument), NULL, true,
                          &got), .v, gp_plane_free(&got))
// in another part than the colour, subsampled
READER(read_coverage, struct gp_plane,
       gp_read_plane(&kept_log, &limits, &from_parts, argument, false, &got),
       .v, gp_plane_free(&got))

static gp_status read_every_channel(const char *name)
{
    struct gp_stored_file file;
    gp_status st = gp_stored_open(&kept_log, &limits, wf_path(name), &file);
    for (int part = 0; !st && part < file.parts; part++) {
        struct gp_stored_image image = {0};
        st = gp_stored_read(&kept_log, &limits, &file, part, &image);
        assert_true(!st || !image.channel);
        gp_stored_image_free(&image);
    }
    gp_stored_close(&file);
    return st;
}

/* Two files in one pipe. */
static gp_status read_members(const char *name)
{
    struct gp_members m = {0};
    const int was = dup(STDIN_FILENO);
    const int in = __real_open(wf_path(name), O_RDONLY);
    assert_true(in >= 0 && dup2(in, STDIN_FILENO) >= 0);
    gp_status st = gp_members_read(&kept_log, &limits, "-", &m);
    for (int i = 0; !st && i < 2; i++) {
        struct gp_frame f = {0};
        st = gp_members_frame(&kept_log, &limits, "-", &m, i, &f);
        gp_frame_free(&f);
    }
    gp_members_free(&m);
    dup2(was, STDIN_FILENO);
    __real_close(in);
    __real_close(was);
    return st;
}

READER(frame_list, struct gp_frames, gp_frames_parse(&kept_log, argument, &got),
       .number, gp_frames_free(&got))
READER(view_list, struct gp_views, gp_views_parse(&kept_log, argument, &got),
       .name, gp_views_free(&got))
READER(flare, struct gp_flare,
       gp_flare_read(&kept_log, wf_path(argument), &got), .element,
       gp_flare_free(&got))
READER(camera, struct gp_camera_file,
       gp_camera_read(&kept_log, wf_path(argument), &got), .at,
       gp_camera_file_free(&got))

static gp_status lights(const char *name)
{
    struct gp_light_spec *list = NULL;
    int n;
    const gp_status st = gp_lights_read(&kept_log, wf_path(name), &list, &n);
    assert_true(!st || !list);
    gp_free(list);
    return st;
}

static gp_status on_disk(const char *name)
{
    struct gp_pattern p;
    struct gp_frames list = {0};
    gp_status st = gp_pattern_find(&kept_log, wf_path(name), &p);
    if (!st)
        st = gp_frames_on_disk(&kept_log, &p, NULL, &list);
    assert_true(!st || !list.number);
    gp_frames_free(&list);
    return st;
}

/* No file is there afterwards but when all is well. */
static gp_status ended(gp_status st, const char *path)
{
    assert_int_equal(access(path, F_OK) == 0, st == GP_OK);
    remove(path);
    return st;
}

static gp_status picture(const char *name)
{
    const char *const to = wf_path(name);
    return ended(gp_write_picture(&kept_log, &wf_defaults, to, &made,
                                  &made.rgb, GP_PICTURE_SHOWN, &wf_stats), to);
}

static gp_status hdr_as(const char *name, const struct gp_frame *f,
                        enum gp_compression compression)
{
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    const char *const to = wf_path(name);
    const struct gp_hdr_colour set = {f, &f->rgb};
    p.compression = compression;
    return ended(gp_write_hdr(&kept_log, &p, to, &set, 1, &wf_stats), to);
}

static gp_status hdr(const char *name)
{
    return hdr_as(name, &from_parts, GP_COMPRESSION_AUTO);
}

static gp_status hdr_made(const char *name)
{
    return hdr_as(name, &made, GP_COMPRESSION_DWAA);
}

/* More than the buffer, in small pieces and in one, and patches of what is
 * out already, of what is not, and across the two. */
static gp_status file(const char *name)
{
    enum { PIECE = 300000, WHOLE = 1500000 };
    static const uint8_t zeros[WHOLE];
    const bool straight = name[0] == '/';
    const char *path = straight ? name : wf_path(name);
    struct gp_file *f = NULL;
    gp_status st = gp_file_open(&kept_log, path, false, &f);
    if (st)
        return st;
    for (int i = 0; i < 8; i++)
        st = gp_file_write(f, zeros, PIECE);
    st = gp_file_write(f, zeros, WHOLE);
    st = gp_file_write(f, "end", 3);
    const uint64_t size = 8 * PIECE + WHOLE + 3;
    if (!st)
        assert_int_equal(gp_file_size(f), size);
    st = gp_file_patch(f, 0, "start", 5);
    st = gp_file_patch(f, size - 5, "where", 5);
    st = st ? st : gp_file_patch(f, size - 1, "d", 1);
    if (st) // a failure stays one
        assert_int_equal(gp_file_write(f, "x", 1), st);
    const gp_status ending = gp_file_commit(&f);
    assert_null(f);
    assert_true(ending == st || st == GP_OK);
    return straight ? ending : ended(ending, path);
}

// -- every point ------------------------------------------------------------

struct work {
    const char *what;
    gp_status (*run)(const char *argument);
    const char *argument;
};

/* Returns whether the work was done without the fault. */
static bool one_point(const struct work *w, enum fail_class kind, int n)
{
    const int files = wf_names();
    kept_clear();
    fail_at(kind, n);
    const gp_status st = w->run(w->argument);
    const bool fired = fail_end();
    const bool right = st == GP_OK || (fired && (kind == FAIL_ALLOC
        ? st == GP_ERR_BUG : st == GP_ERR_IO || st == GP_ERR_DATA));
    if (!right || kept_errors != (st != GP_OK))
        fail_msg("%s %s, %s %d: status %d, %d lines: %s", w->what, w->argument,
                 kind == FAIL_ALLOC ? "memory" : "files", n, st, kept_errors,
                 kept_line);
    assert_int_equal(wf_names(), files);
    return !fired;
}

static void every_point(const struct work *row, size_t rows)
{
    for (size_t i = 0; i < rows; i++) {
        for (int kind = FAIL_ALLOC; kind <= FAIL_IO; kind++) {
            int n = 1;
            while (!one_point(&row[i], (enum fail_class) kind, n))
                assert_true(n++ < POINTS_MAX);
        }
    }
}

static void own_work(void **state)
{
    static const struct work row[] = {
        {"read", read_any, "made.exr"}, {"read", read_any, "parts.exr"},
        {"read", read_any, "tiles.exr"}, {"read", read_any, "yc.exr"},
        {"read", read_any, "a.png"},
        {"channels", read_every_channel, "parts.exr"},
        {"channels", read_every_channel, "tiles.exr"},
        {"channels", read_every_channel, "yc.exr"},
        {"channels", read_every_channel, "a.png"},
        {"plane", read_mask, "a.png"}, {"depth", read_depth, "depth.exr"},
        {"coverage", read_coverage, "wide"},
        {"coverage", read_coverage, "one.left.mask"},
        {"layer", read_layer, "fog"}, {"members", read_members, "two"},
        {"frames", frame_list, "3,1-20,7,90-30x3"},
        {"views", view_list, "left,right"}, {"pattern", on_disk, "s.####.exr"},
        {"lights", lights, "lights.json"}, {"flare", flare, "flare.json"},
        {"camera", camera, "camera.json"}, {"picture", picture, "out.exr"},
        {"picture", picture, "out.png"}, {"hdr", hdr, "out.exr"},
        {"file", file, "out.bin"},
        {"file", file, "/dev/null"}, // held in memory to the end
    };
    every_point(row, COUNT(row));
}

static void helpers_work(void **state)
{
    static const struct work row[] = {
        {"read", read_any, "a.tif"}, {"channels", read_every_channel, "a.tif"},
        {"plane", read_mask, "a.tif"}, {"read", read_any, "dwaa.exr"},
        {"picture", picture, "out.tif"}, {"picture", picture, "out.sgi"},
        {"hdr", hdr_made, "out.exr"},
    };
    if (!*(const bool *) *state)
        skip_for("no OpenImageIO");
    every_point(row, COUNT(row));
}

static int start(void **state)
{
    static bool bridge;
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    if (wf_start(state))
        return -1;
    *state = &bridge;
    gp_set_threads(1);
    made = wf_sized(20, 10, wf_all);
    assert_ok(wf_write_hdr(&p, "made.exr", &made));
    assert_ok(wf_write(&p, "a.png", &made, GP_PICTURE_SHOWN));
    bridge = wf_write(&p, "a.tif", &made, GP_PICTURE_SHOWN) == GP_OK;
    p.compression = GP_COMPRESSION_DWAA;
    if (bridge)
        assert_ok(wf_write_hdr(&p, "dwaa.exr", &made));
    fixture_write_file(wf_path("parts.exr"), &parts);
    fixture_write_file(wf_path("tiles.exr"), &tiles);
    fixture_write_file(wf_path("yc.exr"), &yc);
    fixture_write_file(wf_path("depth.exr"), &depth);
    save_twice("two", &tiles);
    for (size_t i = 0; i < COUNT(texts); i++)
        fixture_save(wf_path(texts[i].name), texts[i].text,
                     strlen(texts[i].text));
    return (int) gp_read_frame(NULL, &limits, wf_path("parts.exr"),
                               &from_parts);
}

static int end(void **state)
{
    free_frames(&made, &from_parts);
    return remove_folder(state);
}

SUITE_OF(faults, start, end, own_work, helpers_work)
