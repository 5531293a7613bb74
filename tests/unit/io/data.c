/* io/read on real frames: every readable EXR of the data folder, sample for
 * sample against OpenImageIO and, where that is no witness, against OpenEXR's
 * RgbaInputFile; cli/data.t reads the damaged ones. The folder is
 * $GLAREPP_DATA, or ../shared/data; without it, or without the witnesses,
 * tests are skipped. */
#include "unit.h"
#include "core/bytes.h"
#include "io/channels.h"
#include "io/exr/exr.h"
#include "data_frames.h"
#include "oiio_here.h"
#include "reading.h"

#include <libgen.h>
#include <limits.h>

static char reference[PATH_MAX]; // the RgbaInputFile program, "" without

/* Builds the program beside this one when there is a compiler. */
static void make_reference(const char *beside)
{
    char command[3 * PATH_MAX];
    snprintf(reference, sizeof reference, "%.3000s/rgba_reference", beside);
    snprintf(command, sizeof command,
             "test '%s' -nt tests/tools/rgba_reference.cpp || c++ -O1 -o '%s' "
             "tests/tools/rgba_reference.cpp "
             "$(pkg-config --cflags --libs OpenEXR) 2>/dev/null",
             reference, reference);
    if (system(command) != 0)
        reference[0] = '\0';
}

static int setup(void **state)
{
    char self[PATH_MAX] = "";
    if (readlink("/proc/self/exe", self, sizeof self - 1) < 0)
        return -1;
    make_reference(dirname(self));
    return list_data_frames(state);
}

static bool same(float a, float b)
{
    return a == b || (isnan(a) && isnan(b));
}

static void assert_frame_is(const struct gp_frame *f,
                            const struct gp_image *image)
{
    const size_t n = (size_t) image->channels;
    assert_memory_equal(&f->data, &image->data, sizeof f->data);
    assert_memory_equal(&f->display, &image->display, sizeof f->display);
    assert_int_equal(f->channels, image->channels);
    float *got = malloc(gp_frame_pixels(f) * sizeof *got);
    assert_non_null(got);
    for (int i = 0; i < f->channels; i++) {
        const struct gp_channel *const c = &f->channel[i];
        size_t from = 0;
        while (from < n && strcmp(c->name, image->channel_name[from]) != 0)
            from++;
        if (from == n)
            fail_msg("%s: OpenImageIO has no %s", f->path, c->name);
        gp_channel_floats(f, i, got);
        for (size_t k = 0; k < gp_frame_pixels(f); k++) {
            float want = image->pixels[k * n + from];
            if (c->type == GP_UINT) // the image has its bits
                want = (float) gp_bits_of(want);
            if (!same(got[k], want))
                fail_msg("%s: channel %s, pixel %zu: %g, not %g", f->path,
                         c->name, k, (double) got[k], (double) want);
        }
    }
    free(got);
}

static void every_frame_as_openimageio_reads_it(void **state)
{
    int compared = 0, deep = 0, chroma = 0;
    if (!data_frames || open_oiio(state) || !has_oiio)
        skip_for(data_frames ? "no OpenImageIO" : NO_DATA);
    for (int i = 0; i < data_frames; i++) {
        struct gp_frame f;
        struct gp_image image;
        if (read_file(data_frame[i], &f)) {
            // (a Cryptomatte of its own has ids alone)
            const bool ids = strstr(data_frame[i], "sidecar_manifest") != NULL;
            assert_kept(ids ? "no colour channels" : "deep data");
            assert_int_equal(kept_errors, 1);
            deep += !ids;
            continue;
        }
        if (f.model == GP_COLOUR_YC) {
            chroma++;
        } else {
            struct gp_stream s;
            assert_ok(gp_stream_open(NULL, data_frame[i], 1, &s));
            if (gp_oiio_open(&kept_log, data_frame[i], &s, "openexr", f.part,
                             INT_MAX, &image) || gp_image_load(&kept_log,
                                                               &image))
                fail_msg("%s", kept_line);
            gp_stream_close(&s);
            assert_frame_is(&f, &image);
            gp_image_close(&image);
            compared++;
        }
        gp_frame_free(&f);
    }
    print_message("%d equal, %d deep refused, %d luminance-chroma\n", compared,
                  deep, chroma);
    assert_true(compared > 0);
}

/* Luminance-chroma, or decoded by the bridge. */
static bool needs_openexr(const struct gp_frame *f)
{
    exr_compression_t c = EXR_COMPRESSION_NONE;
    const struct gp_input *o = gp_input_of(f);
    return f->model == GP_COLOUR_YC ||
           (exr_get_compression(o->exr, o->part, &c) == EXR_ERR_SUCCESS &&
            c >= EXR_COMPRESSION_DWAA);
}

static void assert_rgb_is_openexrs(const struct gp_frame *f)
{
    char command[2 * PATH_MAX + 10];
    float pixel[3];
    snprintf(command, sizeof command, "'%s' '%s'", reference, f->path);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    for (size_t i = 0; i < gp_frame_pixels(f); i++) {
        assert_int_equal(fread(pixel, sizeof pixel, 1, pipe), 1);
        for (int c = 0; c < 3; c++) {
            if (!same(f->rgb.c[c][i], pixel[c]))
                fail_msg("%s: pixel %zu of plane %d: %.9g, not %.9g", f->path,
                         i, c, (double) f->rgb.c[c][i], (double) pixel[c]);
        }
    }
    assert_int_equal(fread(pixel, 1, 1, pipe), 0);
    assert_int_equal(pclose(pipe), 0);
}

static void luminance_chroma_and_dwa_as_openexr_reads_them(void **state)
{
    int compared = 0;
    if (!data_frames || !reference[0])
        skip_for(data_frames ? "no compiler for OpenEXR's C++ library"
                 : NO_DATA);
    for (int i = 0; i < data_frames; i++) {
        struct gp_frame f;
        if (read_file(data_frame[i], &f))
            continue;
        if (needs_openexr(&f)) {
            assert_rgb_is_openexrs(&f);
            compared++;
        }
        gp_frame_free(&f);
    }
    print_message("%d equal\n", compared);
}

SUITE_OF(data, setup, free_data_frames, every_frame_as_openimageio_reads_it,
         luminance_chroma_and_dwa_as_openexr_reads_them)
