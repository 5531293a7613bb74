// SPDX-License-Identifier: Apache-2.0
/* EXR out: every compression and type, colour models, what is carried; where
 * half or a lossy compression cannot hold what is there, and ids. */
#include "unit.h"
#include "write_fixture.h"
#include "io/exr/exr_priv.h"
#include "io/plane.h"

/* Greatest difference of two values that a compression may make. */
static double tolerance(enum gp_compression c, enum gp_pixel_type type,
                        double v)
{
    if (c == GP_COMPRESSION_PXR24 && type == GP_FLOAT)
        return fabs(v) * 0x1p-16;
    if ((c == GP_COMPRESSION_B44 || c == GP_COMPRESSION_B44A) &&
        type == GP_HALF)
        return 16.0; // 6 bits a sample, of noise: anything in its range
    return c >= GP_COMPRESSION_DWAA ? 16.0 : 0.0;
}

static void assert_samples(const float *a, const float *b, size_t n,
    enum gp_compression c, enum gp_pixel_type type, const char *name)
{
    for (size_t i = 0; i < n; i++) {
        const double v = (double) a[i];
        if (!(fabs((double) b[i] - v) <= tolerance(c, type, v)))
            fail_msg("compression %d, %s[%zu]: %g is %g", c, name, i, v,
                     (double) b[i]);
    }
}

/* All that a frame has, colour and carried channels, came through. */
static void assert_frame(const struct gp_frame *a, const struct gp_frame *b,
                         enum gp_compression c)
{
    assert_memory_equal(&a->data, &b->data, sizeof a->data);
    assert_memory_equal(&a->display, &b->display, sizeof a->display);
    assert_int_equal(a->channels, b->channels);
    for (int k = 0; k < 3; k++)
        assert_samples(a->rgb.c[k], b->rgb.c[k], gp_frame_pixels(a), c,
                       b->colour_type, "colour");
    for (int i = 0; i < a->channels; i++) {
        const struct gp_channel *p = &a->channel[i];
        const struct gp_channel *q = gp_frame_channel(b, p->name);
        assert_non_null(q);
        assert_int_equal(p->colour, q->colour);
        if (p->colour >= 0)
            continue;
        assert_int_equal(p->type, q->type);
        assert_int_equal(p->xs * 100 + p->ys, q->xs * 100 + q->ys);
        const size_t n = (size_t) p->w * (size_t) p->h;
        assert_int_equal(n, (size_t) q->w * (size_t) q->h);
        if (p->type == GP_FLOAT)
            assert_samples(p->data, q->data, n, c, p->type, p->name);
        else if (p->type == GP_UINT || tolerance(c, p->type, 1) == 0)
            assert_memory_equal(p->data, q->data, n * gp_type_size(p->type));
    }
}

static const struct gp_rect at_0 = {0, 0, 40, 30};

static void every_compression(void **state)
{
    static const struct {
        struct gp_rect window;
        const struct wf_channel *list;
    } row[] = {
        {{0, 0, 1, 1}, wf_all},      {{-37, -21, 30, 24}, wf_all},
        {{5, 7, 6, 99}, wf_all},     {{0, -3, 301, -2}, wf_all},
        {{0, 0, 64, 260}, wf_all},
        // small noise is stored as it is, what follows is not
        {{0, 0, 1, 64}, wf_rgb},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_frame f = wf_frame(row[i].window, at_0, row[i].list);
        for (int k = 0; row[i].list == wf_rgb && k < 3; k++)
            memset(f.rgb.c[k] + 32, 0, 32 * sizeof(float));
        for (int c = 0; c <= wf_last_compression(); c++) {
            for (enum gp_out_type type = GP_OUT_AUTO; type <= GP_OUT_FLOAT;
                 type++) {
                struct gp_frame b = wf_trip(&f, c, type);
                assert_int_equal(b.colour_type, type == GP_OUT_FLOAT
                                                    ? GP_FLOAT : GP_HALF);
                assert_frame(&f, &b, c);
                gp_frame_free(&b);
            }
        }
        gp_frame_free(&f);
    }
}

static void automatic_type_and_compression(void **state)
{
    static const enum gp_compression row[][2] = { // of the input, the output
        {GP_COMPRESSION_NONE, GP_COMPRESSION_NONE},
        {GP_COMPRESSION_RLE, GP_COMPRESSION_RLE},
        {GP_COMPRESSION_ZIPS, GP_COMPRESSION_ZIPS},
        {GP_COMPRESSION_PIZ, GP_COMPRESSION_PIZ},
        {GP_COMPRESSION_PXR24, GP_COMPRESSION_ZIP},
        {GP_COMPRESSION_B44A, GP_COMPRESSION_ZIP},
    };
    struct gp_frame made = wf_sized(33, 40, wf_all);
    for (size_t i = 0; i < COUNT(row); i++) {
        for (enum gp_out_type type = GP_OUT_HALF; type <= GP_OUT_FLOAT;
             type++) {
            struct gp_frame a = wf_trip(&made, row[i][0], type);
            struct gp_frame b = wf_trip(&a, GP_COMPRESSION_AUTO, GP_OUT_AUTO);
            assert_int_equal(b.colour_type, a.colour_type);
            gp_frame_free(&b);
            rename(wf_path("a.exr"), wf_path("b.exr"));
            b = wf_trip(&a, row[i][1], GP_OUT_AUTO);
            wf_assert_same(wf_path("a.exr"), wf_path("b.exr"));
            free_frames(&a, &b);
        }
    }
    gp_frame_free(&made);
}

/* Grey stays one channel as long as it is grey; a name that the colour needs
 * and the file uses for something else is an error. */
static void colour_models(void **state)
{
    static const struct {
        struct wf_channel list[3];
        enum gp_colour_model model;
        bool grey;         // the planes are the same
        const char *names; // "" an error
    } rows[] = {
        {{{"Y", GP_HALF, 0, 0, 0}}, GP_COLOUR_GREY, true, "Y"},
        {{{"Y", GP_HALF, 0, 0, 0}}, GP_COLOUR_GREY, false, "B G R"},
        {{{"l.Y", GP_HALF, 0, 0, 0}}, GP_COLOUR_GREY, false, "l.B l.G l.R"},
        {{{"l.red", GP_HALF, 0, 0, 0}}, GP_COLOUR_RGB, false,
         "l.blue l.green l.red"},
        {{{"R", GP_HALF, 0, 0, 0}}, GP_COLOUR_RGB, true, "G R"}, // no blue
        {{{"RY", GP_HALF, 0, 2, 2}, {"Y", GP_HALF, 1, 0, 0}}, GP_COLOUR_YC,
         true, "B G R"},
        {{{"Y", GP_HALF, 0, 0, 0}, {"G", GP_HALF, -1, 0, 0}}, GP_COLOUR_GREY,
         false, ""},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_frame f = wf_sized(34, 40, rows[i].list);
        f.model = rows[i].model;
        for (int c = 1; c < 3 && rows[i].grey; c++)
            memcpy(f.rgb.c[c], f.rgb.c[0], gp_frame_pixels(&f) * 4);
        if (f.model == GP_COLOUR_RGB && rows[i].grey)
            memset(f.rgb.c[2], 0, gp_frame_pixels(&f) * 4);
        gp_status st = wf_write_hdr(NULL, "a.exr", &f);
        assert_int_equal(st, rows[i].names[0] ? GP_OK : GP_ERR_DATA);
        char names[64] = "";
        if (!st) {
            struct gp_frame b = wf_read_back("a.exr");
            for (int k = 0; k < b.channels; k++) {
                strcat(names, k ? " " : "");
                strcat(names, b.channel[k].name);
            }
            for (int k = 0; k < 3; k++)
                assert_memory_equal(b.rgb.c[k], f.rgb.c[k],
                                    gp_frame_pixels(&f) * 4);
            gp_frame_free(&b);
        }
        assert_string_equal(names, rows[i].names);
        gp_frame_free(&f);
    }
}

/* wf_rgb and one more channel. */
static void list_with(struct wf_channel list[5], struct wf_channel more)
{
    memcpy(list, wf_rgb, sizeof wf_rgb);
    list[4] = list[3];
    list[3] = more;
}

/* -- values that do not fit ------------------------------------------------*/

static void half_overflow_is_counted(void **state)
{
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    p.type = GP_OUT_HALF;
    struct gp_frame f = wf_sized(33, 40, wf_rgb);
    static const float v[6] = {1e9f, -1e9f, 65504, 65519, 65520, INFINITY};
    memcpy(f.rgb.c[0] + 700, v, sizeof v);
    memcpy(f.rgb.c[2] + 7, v, sizeof v);
    static const enum gp_compression c[] = {
        GP_COMPRESSION_NONE, GP_COMPRESSION_ZIP, GP_COMPRESSION_PIZ,
        GP_COMPRESSION_DWAA};
    for (int k = 0; k < (wf_bridge() ? 4 : 3); k++) {
        wf_stats.clamped = 100;
        p.compression = c[k];
        assert_ok(wf_write(&p, "a.exr", &f, GP_PICTURE_SCENE));
        // DWA's range ends an eighth earlier, and Inf is no part of it
        assert_int_equal(wf_stats.clamped, k < 3 ? 106 : 112);
        struct gp_frame b = wf_read_back("a.exr");
        for (size_t i = 0; k == 3 && i < gp_frame_pixels(&b); i++)
            assert_true(isfinite(b.rgb.c[0][i]) && isfinite(b.rgb.c[2][i]));
        if (k < 3) {
            assert_true(b.rgb.c[0][700] == 65504 && b.rgb.c[0][701] == -65504);
            assert_true(isinf(b.rgb.c[2][12]));
        }
        gp_frame_free(&b);
    }
    gp_frame_free(&f);
}

/* A pixel over 65504 keeps its hue, and AUTO its light. */
static void half_overflow_keeps_hue(void **state)
{
    static const float sun[3] = {262016, 131008, 65504};
    static const struct {
        enum gp_out_type type;
        enum gp_compression compression;
        enum gp_pixel_type becomes;
        float scale;
    } rows[] = {
        {GP_OUT_AUTO, GP_COMPRESSION_ZIP, GP_FLOAT, 1},
        {GP_OUT_HALF, GP_COMPRESSION_ZIP, GP_HALF, 0.25f},
        {GP_OUT_FLOAT, GP_COMPRESSION_ZIP, GP_FLOAT, 1},
        {GP_OUT_AUTO, GP_COMPRESSION_DWAA, GP_HALF, 57344.0f / 262016.0f},
        {GP_OUT_FLOAT, GP_COMPRESSION_DWAA, GP_FLOAT, 57344.0f / 262016.0f},
    };
    struct gp_frame f = wf_sized(33, 40, wf_rgb);
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < gp_frame_pixels(&f); i++)
            f.rgb.c[c][i] = sun[c];
    }
    for (int k = 0; k < 2 * (wf_bridge() ? 5 : 3); k++) {
        const struct gp_write_params p = {
            .type = rows[k / 2].type, .compression = rows[k / 2].compression,
        };
        const float scale = rows[k / 2].scale;
        const double n = (double) gp_frame_pixels(&f);
        wf_stats = (struct gp_write_stats) {0};
        kept_clear();
        assert_ok(k % 2 ? wf_write_hdr(&p, "a.exr", &f)
                        : wf_write(&p, "a.exr", &f, GP_PICTURE_SCENE));
        assert_int_equal(wf_stats.clamped > 0, scale < 1);
        assert_int_equal(strstr(kept_line, "% of the red light") != NULL,
                         scale < 1);
        struct gp_frame b = wf_read_back("a.exr");
        assert_int_equal(b.colour_type, rows[k / 2].becomes);
        for (int c = 0; c < 3; c++) {
            const double lost = n * (double) (sun[c] - sun[c] * scale);
            assert_true(fabs(wf_stats.flux_clamped[c] - lost) <= 1e-5 * lost);
            assert_true(fabsf(b.rgb.c[c][40] / (sun[c] * scale) - 1) <
                        (k < 6 ? 1e-6f : 0.02f));
        }
        gp_frame_free(&b);
    }
    gp_frame_free(&f);
}

/* B44 rounds the least value of a block down, past the end of half if let. */
static void b44_keeps_what_is_far_below_0_finite(void **state)
{
    static const float v[7] = {-65504, 65504, -1e9f, -60000, -32752, -32736,
                               1};
    struct gp_frame f = wf_sized(33, 40, wf_rgb);
    long long beyond = 0;
    for (size_t i = 0; i < gp_frame_pixels(&f); i++) {
        f.rgb.c[0][i] = v[i * i % 7];
        beyond += f.rgb.c[0][i] < -32752;
    }
    for (int k = 0; k < 2; k++) {
        struct gp_write_params p = GP_WRITE_DEFAULTS;
        p.compression = k ? GP_COMPRESSION_B44A : GP_COMPRESSION_B44;
        p.type = GP_OUT_HALF;
        wf_stats.clamped = 0;
        assert_ok(wf_write(&p, "a.exr", &f, GP_PICTURE_SCENE));
        assert_int_equal(wf_stats.clamped, beyond);
        struct gp_frame b = wf_read_back("a.exr");
        for (size_t i = 0; i < gp_frame_pixels(&b); i++) {
            assert_true(isfinite(b.rgb.c[0][i]));
            if (f.rgb.c[0][i] < -32000)
                assert_true(b.rgb.c[0][i] < -16000);
        }
        gp_frame_free(&b);
    }
    gp_frame_free(&f);
}

static const struct gp_rect window = {-3, 5, 42, 45};

static void lossy_ids(void **state)
{
    static const struct {
        const char *name;
        enum gp_pixel_type type;
        enum gp_compression compression;
        bool fine;
    } rows[] = {
        {"CryptoObject00.R", GP_FLOAT, GP_COMPRESSION_PXR24, false},
        {"CryptoObject00.A", GP_FLOAT, GP_COMPRESSION_PXR24, false},
        {"CryptoObject00.R", GP_FLOAT, GP_COMPRESSION_B44, true},
        {"CryptoObject00.R", GP_HALF, GP_COMPRESSION_B44A, false},
        {"CryptoObject00.R", GP_FLOAT, GP_COMPRESSION_DWAA, false},
        {"CryptoObject00.R", GP_FLOAT, GP_COMPRESSION_DWAB, false},
        {"CryptoObject00.r", GP_FLOAT, GP_COMPRESSION_DWAB, true},
        {"CryptoObject00.A", GP_FLOAT, GP_COMPRESSION_DWAA, true},
        {"View.crypto_asset02.R", GP_FLOAT, GP_COMPRESSION_PXR24, false},
        {"crypto_asset.R", GP_FLOAT, GP_COMPRESSION_PXR24, true},
        {"CryptoObject00.R", GP_FLOAT, GP_COMPRESSION_AUTO, true},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct wf_channel list[5];
        struct gp_write_params p = GP_WRITE_DEFAULTS;
        if (rows[i].compression > wf_last_compression())
            continue;
        list_with(list, (struct wf_channel) {rows[i].name, rows[i].type, -1, 0,
                                             0});
        struct gp_frame f = wf_frame(window, window, list);
        wf_fill_bits(&f, true);
        p.compression = rows[i].compression;
        const gp_status st = wf_write_hdr(&p, "a.exr", &f);
        if (st != (rows[i].fine ? GP_OK : GP_ERR_USAGE))
            fail_msg("row %zu: %d", i, st);
        if (!rows[i].fine) {
            assert_kept(rows[i].name);
            assert_int_equal(wf_names(), 0);
        } else {
            assert_int_equal(remove(wf_path("a.exr")), 0);
        }
        gp_frame_free(&f);
    }
}

SUITE_OF_EACH(exr_write, wf_start, remove_folder, every_compression,
              automatic_type_and_compression, colour_models,
              half_overflow_is_counted, half_overflow_keeps_hue,
              b44_keeps_what_is_far_below_0_finite, lossy_ids)
