// SPDX-License-Identifier: Apache-2.0
/* cli/report: what a run says about itself. */
#include "unit.h"
#include "cli/report.h"
#include "folder.h"
#include "kept_log.h"

#include <jansson.h>
#include <sys/stat.h>
#include <unistd.h>

static char depth[] = "Z", input[] = "in.0007.exr", x[] = "x";
static struct gp_written two_files[] = {{"a.0007.png", GP_TARGET_PICTURE},
                                        {"b.exr", GP_TARGET_HDR}};

static struct gp_frame_report full_facts(void)
{
    struct gp_frame_report f = {
        .job = {.of = {.numbered = true, .frame = 7, .input = input},
                .said = "\1one\0\2note\0\1two",
                .said_bytes = 16},
        .read = {.taken = {"2", "diffuse", "left"},
                 .width = 640,
                 .height = 480,
                 .window = {-2, 3, 638, 483},
                 .grown = true},
        .write = {.file = two_files, .n = 2},
        .lib =
            {
                .sense = {.sources = 12,
                          .flux = {1.5, 2.5, 3.5},
                          .nonfinite = 3,
                          .clamped = 4},
                .layer = {.engine = "splat",
                          .why = "asked for",
                          .groups = 7,
                          .clusters = 5,
                          .polygons = 12,
                          .cores = 11,
                          .polygon_pixels = 1e6,
                          .form = "blended quads",
                          .fft_w = 1280,
                          .fft_h = 1024,
                          .gl = "OSMesa: llvmpipe",
                          .flux = {1.25, 2.25, 3.25}},
                .verified = true,
                .errors = {.rel_l2 = 1e-7,
                           .max_rel = 2e-7,
                           .max_abs = 3e-7,
                           .flux_error = 4e-7},
            },
        .bounded = true,
        .bound = 1e-6,
        .clamped_out = 5,
        .hidden = {.depth = depth, .depth_type = "half"},
    };
    for (int i = 0; i < GP_TIMES; i++)
        f.cost.ms[i] = i + 0.12345;
    return f;
}

/* Reports the facts into a file and reads its lines back. */
static char *reported(const struct gp_frame_report *facts, int n)
{
    in_folder("reported.json");
    struct gp_report r;
    assert_ok(gp_report_open(&kept_log, path, false, &r));
    for (int i = 0; i < n; i++)
        assert_ok(gp_report_frame(&kept_log, &r, facts));
    char *text = calloc(1, 65536);
    FILE *f = fopen(path, "r"); // before the close: each line is flushed
    size_t size = fread(text, 1, 65535, f);
    fclose(f);
    text[size] = '\0';
    assert_ok(gp_report_close(&kept_log, &r));
    assert_ok(gp_report_close(&kept_log, &r));
    return text;
}

static const char *const keys[] = {
    "frame", "view", "input", "part", "layer", "outputs", "width",
    "height", "window", "window_read", "engine", "engine_why",
    "threshold", "sources", "groups", "clusters", "polygons", "cores",
    "polygon_pixels",
    "form", "fft_size", "flux_in", "flux_out", "bound", "measured",
    "nonfinite", "clamped", "flux_clamped", "clamped_out", "depth",
    "times_ms", "frame_mib",    "peak_rss_mib",
    "threads", "gl", "warnings", "status", "version", "schema",
};

static void all_fields_in_order(void **state)
{
    struct gp_frame_report facts = full_facts();
    char *text = reported(&facts, 1);
    json_t *o = json_loads(text, 0, NULL);
    assert_non_null(o);
    size_t i = 0;
    const char *key;
    json_t *value;
    json_object_foreach(o, key, value) {
        assert_true(i < COUNT(keys));
        assert_string_equal(key, keys[i++]);
    }
    assert_int_equal(i, COUNT(keys));
    assert_non_null(strstr(text, "\"outputs\":[\"a.0007.png\",\"b.exr\"]"));
    assert_non_null(strstr(text, "\"fft_size\":[1280,1024]"));
    assert_non_null(strstr(text, "\"flux_in\":[1.5,2.5,3.5]"));
    assert_non_null(strstr(text, "\"read\":0.123,"));
    assert_non_null(strstr(text, "\"depth\":{\"channel\":\"Z\",\"type\":"
                                 "\"half\"}"));
    assert_non_null(strstr(text, "\"warnings\":[\"one\",\"two\"],"
                                 "\"status\":0,"));
    assert_non_null(strstr(text, "\"measured\":{\"rel_l2\":1e-7,"));
    json_decref(o);
    free(text);
}

static void what_was_not_needed_is_left_out(void **state)
{
    struct gp_frame_report facts = {
        .job.of.input = x, .lib.layer = {.engine = "none", .why = "dark"}};
    for (int i = 0; i < GP_TIMES; i++)
        facts.cost.ms[i] = i % GP_TIME_TOTAL == GP_TIME_READ ? 1.0 : -1.0;
    static const char *const gone[] = {
        "frame", "groups", "clusters", "polygons", "cores", "polygon_pixels",
        "form", "fft_size", "bound", "measured", "clamped_out", "depth", "gl",
        "view", "part", "layer", "settings", "relit", "kernel", "flare", "lens",
        "scene", "lights", "ocio", "cpu_ms", "window_read", "light_groups",
    };
    char *text = reported(&facts, 1);
    json_t *o = json_loads(text, 0, NULL);
    for (size_t i = 0; i < COUNT(gone); i++)
        assert_null(json_object_get(o, gone[i]));
    assert_int_equal(json_object_size(json_object_get(o, "times_ms")), 2);
    assert_non_null(strstr(text, "\"outputs\":[],"));
    json_decref(o);
    free(text);
}

/* A frame that failed has what its job and its end say. */
static void a_failed_frame_says_why(void **state)
{
    struct gp_frame_report facts = full_facts();
    facts.job.status = GP_ERR_DATA;
    facts.job.error = "in.0007.exr: truncated";
    char *text = reported(&facts, 1);
    assert_memory_equal(text, "{\"frame\":7,\"view\":\"left\",\"input\":"
        "\"in.0007.exr\",\"part\":\"2\",\"layer\":\"diffuse\",\"warnings\":["
        "\"one\",\"two\"],\"status\":4,\"version\":", 116);
    assert_non_null(strstr(text, "\"error\":\"in.0007.exr: truncated\"}\n"));
    free(text);
}

/* Whatever a name or a number is, each line is one JSON object. */
static void hard_values_stay_json(void **state)
{
    static const char *const names[] = {
        "quote\" back\\slash \n newline \x01", "latin1 \xe9t\xe9", "\xff\xfe",
        "utf-8 \xc3\xa9 \xe2\x82\xac \xf0\x9f\x8c\x9e", "cut \xe2\x82",
        "overlong \xc0\xaf", "surrogate \xed\xa0\x80", "\xf4\x90\x80\x80", "",
    };
    struct gp_frame_report facts = full_facts();
    facts.lib.errors.rel_l2 = NAN;
    facts.lib.sense.flux[1] = INFINITY;
    facts.bound = -INFINITY;
    for (size_t i = 0; i < COUNT(names); i++) {
        facts.job.of.input = (char *) (uintptr_t) names[i];
        char *text = reported(&facts, 2);
        char *second = strchr(text, '\n') + 1;
        assert_non_null(strchr(second, '\n'));
        assert_int_equal(strchr(second, '\n')[1], '\0');
        json_t *o = json_loads(second, 0, NULL);
        assert_non_null(o);
        assert_true(json_is_null(json_object_get(o, "bound")));
        if (i == 3)
            assert_string_equal(json_string_value(json_object_get(o, "input")),
                                names[i]);
        json_decref(o);
        free(text);
    }
}

// -- files -------------------------------------------------------------------

static long size_of(const char *path)
{
    struct stat s;
    return stat(path, &s) == 0 ? (long) s.st_size : -1;
}

/* A run that fails before its first line leaves the file as it was. */
static void files_are_touched_with_the_first_line(void **state)
{
    in_folder("r.json");
    struct gp_frame_report facts = full_facts();
    struct gp_report r;
    assert_ok(gp_report_open(&kept_log, path, false, &r));
    assert_ok(gp_report_close(&kept_log, &r));
    assert_int_equal(size_of(path), -1);

    FILE *f = fopen(path, "w");
    for (int i = 0; i < 4000; i++)
        fputs("old\n", f);
    fclose(f);
    assert_ok(gp_report_open(&kept_log, path, false, &r));
    assert_ok(gp_report_close(&kept_log, &r));
    assert_int_equal(size_of(path), 16000);
    assert_ok(gp_report_open(&kept_log, path, false, &r));
    assert_ok(gp_report_frame(&kept_log, &r, &facts));
    assert_ok(gp_report_close(&kept_log, &r));
    assert_in_range(size_of(path), 100, 2000);
}

static void errors_of_files(void **state)
{
    struct gp_frame_report facts = full_facts();
    struct gp_report r = {0};
    assert_int_equal(gp_report_open(&kept_log, "/no/such/r.json", false, &r), GP_ERR_IO);
    assert_kept("/no/such/r.json: ");
    assert_int_equal(gp_report_open(&kept_log, "/tmp", false, &r),
                     GP_ERR_IO);
    if (access("/dev/full", W_OK) != 0)
        skip_for("no /dev/full");
    assert_ok(gp_report_open(&kept_log, "/dev/full", false, &r));
    assert_int_equal(gp_report_frame(&kept_log, &r, &facts), GP_ERR_IO);
    assert_kept("No space left");
    (void) gp_report_close(NULL, &r);
}

static void dark_frames_have_a_line(void **state)
{
    struct gp_frame_report facts = full_facts();
    char line[300];
    gp_frame_report_dark(&facts, 3, line, sizeof line);
    assert_string_equal(line, "in.0007.exr: no pixel of 3 frames is over the "
                        "threshold 0 (all are black); check the frame");
}

SUITE_OF(report, make_folder, remove_folder, all_fields_in_order,
         a_failed_frame_says_why,
         what_was_not_needed_is_left_out, hard_values_stay_json, files_are_touched_with_the_first_line,
         errors_of_files, dark_frames_have_a_line)
