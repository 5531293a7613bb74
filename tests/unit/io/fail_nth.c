// SPDX-License-Identifier: Apache-2.0
/* Memory that is full, a read or a write that fails, at the first call, the
 * second, and so on until a whole run is done without a fault. Each time: the
 * documented status, one line, nothing in the outputs, no block lost and no file
 * left. */
#include "core/parallel.h"
#include "exr_fixture.h"
#include "fail.h"
#include "io/plane.h"
#include "io/read.h"
#include "reading.h"
#include "unit.h"
#include "write_fixture.h"

#include <fcntl.h>

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
static const struct fixture yc = {
    .part = {{.channel = {{"BY", HALVES, 2, 2}, {"RY", HALVES, 2, 2},
                          {"Y", HALVES, 1, 1}},
              .data = W(12), .compression = EXR_COMPRESSION_PIZ}},
};

static const struct gp_read_params limits = GP_READ_DEFAULTS;
static struct gp_frame made;        // of no file
static struct gp_frame from_parts;  // read from parts.exr

// -- runs ---------------------------------------------------------------------

static gp_status read_any(const char *name)
{
    struct gp_frame got = {0};
    const gp_status st = gp_read_frame(&kept_log, &limits, wf_path(name), &got);
    assert_true(!st || !got.rgb.c[0]);
    gp_frame_free(&got);
    return st;
}

/* A layer, and a subsampled plane of another part. */
static gp_status read_beside(const char *layer)
{
    struct gp_frame got = {0};
    struct gp_plane plane = {0};
    gp_status st =
        gp_read_layer(&kept_log, &limits, &from_parts, layer, &got);
    if (!st)
        st = gp_read_plane(&kept_log, &limits, &from_parts, "wide", false,
                           &plane);
    assert_true(!st || !plane.v);
    gp_plane_free(&plane);
    gp_frame_free(&got);
    return st;
}

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

/* The images of a pipe. */
static gp_status read_members(const char *name)
{
    struct gp_members m = {0};
    const int was = dup(STDIN_FILENO);
    const int in = __real_open(wf_path(name), O_RDONLY);
    assert_true(in >= 0 && dup2(in, STDIN_FILENO) >= 0);
    gp_status st = gp_members_read(&kept_log, &limits, "-", &m);
    for (int i = 0; !st && i < m.n; i++) {
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
    const struct gp_hdr_colour set = {f, f->rgb};
    p.compression = compression;
    return ended(gp_write_hdr(&kept_log, &p, to, &set, 1, &wf_stats), to);
}

static gp_status hdr(const char *name)
{
    return hdr_as(name, &from_parts, GP_COMPRESSION_AUTO);
}

static gp_status hdr_piz(const char *name)
{
    return hdr_as(name, &made, GP_COMPRESSION_PIZ);
}

static gp_status hdr_dwa(const char *name)
{
    return hdr_as(name, &made, GP_COMPRESSION_DWAA);
}

// -- every call ---------------------------------------------------------------

struct run {
    const char *what;
    gp_status (*call)(const char *argument);
    const char *argument;
};

/* Returns whether the run was done without the fault. */
static bool one_call(const struct run *w, enum fail_class kind, int n)
{
    const int files = wf_names();
    const long blocks = fail_blocks();
    kept_clear();
    fail_at(kind, n);
    const gp_status st = w->call(w->argument);
    const bool fired = fail_end();
    const bool right = st == GP_OK || (fired && (kind == FAIL_ALLOC
        ? st == GP_ERR_BUG : st == GP_ERR_IO || st == GP_ERR_DATA));
    if (!right || kept_errors != (st != GP_OK) || fail_blocks() != blocks)
        fail_msg("%s %s, %s %d: status %d, %d lines, %ld blocks: %s", w->what,
                 w->argument, kind == FAIL_ALLOC ? "memory" : "files", n, st,
                 kept_errors, fail_blocks() - blocks, kept_line);
    assert_int_equal(wf_names(), files);
    return !fired;
}

static void every_call(const struct run *row, size_t rows)
{
    enum { MOST = 20000 }; // more than any run has
    for (size_t i = 0; i < rows; i++) {
        (void) row[i].call(row[i].argument); // what is kept for the next frame
        for (int kind = FAIL_ALLOC; kind <= FAIL_IO; kind++) {
            int n = 1;
            while (!one_call(&row[i], (enum fail_class) kind, n))
                assert_true(n++ < MOST);
        }
    }
}

static void own_formats(void **state)
{
    static const struct run row[] = {
        {"read", read_any, "parts.exr"}, {"read", read_any, "yc.exr"},
        {"read", read_any, "a.png"}, {"read", read_any, "a.pfm"},
        {"beside", read_beside, "fog"},
        {"channels", read_every_channel, "parts.exr"},
        {"members", read_members, "a.png"}, {"picture", picture, "out.exr"},
        {"picture", picture, "out.png"}, {"picture", picture, "out.pfm"},
        {"hdr", hdr, "out.exr"}, {"hdr", hdr_piz, "out.exr"},
    };
    every_call(row, COUNT(row));
}

static void formats_of_the_helper(void **state)
{
    static const struct run row[] = {
        {"read", read_any, "a.tif"}, {"picture", picture, "out.tif"},
        {"hdr", hdr_dwa, "out.exr"},
    };
    if (!*(const bool *) *state)
        skip_for("no OpenImageIO");
    every_call(row, COUNT(row));
}

static int start(void **state)
{
    static bool bridge;
    if (wf_start(state))
        return -1;
    *state = &bridge;
    gp_set_threads(1);
    made = wf_sized(20, 10, wf_all);
    assert_ok(wf_write(&wf_defaults, "a.png", &made, GP_PICTURE_SHOWN));
    assert_ok(wf_write(&wf_defaults, "a.pfm", &made, GP_PICTURE_SHOWN));
    bridge = wf_write(&wf_defaults, "a.tif", &made, GP_PICTURE_SHOWN) == GP_OK;
    fixture_write_file(wf_path("parts.exr"), &parts);
    fixture_write_file(wf_path("yc.exr"), &yc);
    return (int) gp_read_frame(NULL, &limits, wf_path("parts.exr"),
                               &from_parts);
}

static int end(void **state)
{
    free_frames(&made, &from_parts);
    return remove_folder(state);
}

SUITE_OF(fail_nth, start, end, own_formats, formats_of_the_helper)
