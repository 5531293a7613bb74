// SPDX-License-Identifier: Apache-2.0
/* tone/ocio: pixels through views and spaces; which config, spaces, views,
 * looks and files names choose, and what wrong ones give. */
#include "unit.h"
#include "core/parallel.h"
#include "tone/ocio.h"
#include "views.h"
#include "write_fixture.h"

/* View Half is x / 2 + 1/4; Turned has red in green, green in blue. Look twice
 * doubles. The colour space `shot` reads a file that a context variable
 * names. */
static const char config_text[] =
    "ocio_profile_version: 2\n"
    "strictparsing: true\n"
    "environment: {SHOT: four}\n"
    "search_path: .\n"
    "roles: {scene_linear: lin, default: turned}\n"
    "displays:\n"
    "  Screen:\n"
    "    - !<View> {name: Half, colorspace: half}\n"
    "    - !<View> {name: Turned, colorspace: turned}\n"
    "    - !<View> {name: Twice, colorspace: half, looks: twice}\n"
    "    - !<View> {name: Shot, colorspace: shot}\n"
    "  Hidden:\n"
    "    - !<View> {name: Plain, colorspace: lin}\n"
    "active_displays: [Screen]\n"
    "active_views: [Half, Turned, Twice, Shot, Plain]\n"
    "looks:\n"
    "  - !<Look> {name: twice, process_space: lin, transform: "
    "!<MatrixTransform> {matrix: [2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1]}}\n"
    "colorspaces:\n"
    "  - !<ColorSpace> {name: lin}\n  - !<ColorSpace>\n"
    "    name: half\n"
    "    from_scene_reference: !<MatrixTransform> {matrix: [0.5,0,0,0, "
    "0,0.5,0,0, 0,0,0.5,0, 0,0,0,1], offset: [0.25,0.25,0.25,0]}\n"
    "  - !<ColorSpace>\n    name: turned\n"
    "    from_scene_reference: !<MatrixTransform> {matrix: [0,0,1,0, "
    "1,0,0,0, 0,1,0,0, 0,0,0,1]}\n"
    "  - !<ColorSpace>\n    name: shot\n"
    "    from_scene_reference: !<FileTransform> {src: $SHOT.spimtx}\n";

static int start(void **state)
{
    if (wf_start(state))
        return -1;
    wf_write_text(wf_path("c.ocio"), config_text);
    wf_write_text(wf_path("four.spimtx"), "4 0 0 0\n0 4 0 0\n0 0 4 0\n");
    return 0;
}

static struct glarepp_tone_params ask(void)
{
    return (struct glarepp_tone_params) {.config = wf_path("c.ocio"),
                                    .shows = true};
}

/* A frame of w x h with light in `lit`; (0, 0) has `first` in its red. */
static struct gp_image lit_frame(int w, int h, float first)
{
    const struct gp_frame of = wf_frame((struct gp_rect) {-3, 2, w - 3, h + 2},
                                        (struct gp_rect) {0, 0, 8, 8}, wf_rgb);
    struct gp_image f = view_of(&of);
    f.lit = f.rgb;
    f.rgb = (struct gp_planes) {0};
    f.lit.c[0][0] = first;
    return f;
}

static struct gp_ocio *opened(const struct glarepp_tone_params *p)
{
    struct gp_ocio *o;
    kept_clear();
    if (gp_ocio_open(&kept_all, p, &o))
        fail_msg("%s", kept_line);
    return o;
}

// -- pixels -------------------------------------------------------------------

/* Sizes of one pixel, one column, and over several blocks; exposure is a
 * scale before the view, auto-exposure too. */
static void view_of_every_pixel(void **state)
{
    static const struct {
        int w, h;
        float ev, first; // light of the first sample
        bool automatic;
    } rows[] = {
        {1, 1, 0, 4e4f, false},   {1, 37, 1, 4e4f, false},
        {4097, 3, -2, 4e4f, false}, {64, 64, 3, 4e4f, false},
        {9, 7, 0, 1, true},
    };
    struct glarepp_tone_params p = ask();
    struct gp_ocio *o = opened(&p);
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_image f = lit_frame(rows[i].w, rows[i].h, rows[i].first);
        struct glarepp_tone_params tone = GLAREPP_TONE_PARAMS;
        tone.exposure = rows[i].ev;
        tone.auto_exposure = rows[i].automatic;
        tone.curve = "none"; // does not count
        const float scale = rows[i].automatic ? gp_tone_scale(&tone, &f)
                                              : exp2f(rows[i].ev);
        assert_true(scale > 0.0f && (scale != 1.0f || !rows[i].automatic));
        assert_ok(gp_ocio_show(&kept_all, o, &tone, &f));
        for (size_t k = 0; k < 3 * gp_image_pixels(&f); k++) {
            const float x = f.lit.c[k % 3][k / 3];
            const float y = 0.5f * (x * scale) + 0.25f;
            const float got = f.shown.c[k % 3][k / 3];
            if (!(fabsf(got - y) <= (rows[i].automatic ? 1e-6f : 0.0f)))
                fail_msg("row %zu, sample %zu: %g of %g, wanted %g", i, k,
                         (double) got, (double) x, (double) y);
        }
        gp_image_free(&f);
    }
    gp_ocio_close(&o);
}

/* A value that is not finite, or becomes so, stays with its own pixel. */
static void bad_pixels_stay_alone(void **state)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f};
    struct glarepp_tone_params p = ask();
    struct gp_ocio *o = opened(&p);
    for (size_t i = 0; i < COUNT(bad); i++) {
        struct gp_image f = lit_frame(5, 5, bad[i]);
        struct glarepp_tone_params tone = GLAREPP_TONE_PARAMS;
        tone.exposure = 8;
        assert_ok(gp_ocio_show(&kept_all, o, &tone, &f));
        for (size_t k = 1; k < 25; k++)
            assert_true(f.shown.c[0][k] == 128.0f * f.lit.c[0][k] + 0.25f);
        assert_true(isnan(bad[i]) || isfinite(f.shown.c[0][0]));
        gp_image_free(&f);
    }
    gp_ocio_close(&o);
}

/* A transform that was not asked for is an error, not a crash. */
static void only_what_was_asked(void **state)
{
    struct glarepp_tone_params p = ask();
    struct gp_image f = lit_frame(2, 2, 1.0f);
    struct gp_planes out = {0};
    const struct glarepp_tone_params tone = GLAREPP_TONE_PARAMS;
    p.shows = false;
    struct gp_ocio *o = opened(&p);
    assert_null(gp_ocio_facts(o)->view);
    assert_int_equal(gp_ocio_show(&kept_all, o, &tone, &f), GP_ERR_BUG);
    assert_int_equal(gp_ocio_convert(&kept_all, o, &f, gp_image_pixels(&f),
                                  &f.lit, &out), GP_ERR_BUG);
    assert_null(out.c[0]);
    gp_image_free(&f);
    gp_ocio_close(&o);
}

/* The red of pixel (0, 0) in the view that `p` asks for. */
static float shown_red(const struct glarepp_tone_params *p, float light)
{
    struct gp_ocio *o = opened(p);
    struct gp_image f = lit_frame(1, 1, light);
    const struct glarepp_tone_params tone = GLAREPP_TONE_PARAMS;
    assert_ok(gp_ocio_show(&kept_all, o, &tone, &f));
    const float red = f.shown.c[0][0];
    gp_image_free(&f);
    gp_ocio_close(&o);
    assert_null(o);
    return red;
}

static void what_is_chosen(void **state)
{
    static const struct {
        const char *input, *display, *view, *look;
        const char *is_input, *is_display, *is_view;
        float red; // of light 1
    } rows[] = {
        {NULL, NULL, NULL, NULL, "lin", "Screen", "Half", 0.75f},
        {"scene_linear", NULL, "Half", NULL, "lin", "Screen", "Half", 0.75f},
        {"LIN", "SCREEN", "half", NULL, "lin", "Screen", "Half", 0.75f},
        {NULL, NULL, "Twice", NULL, "lin", "Screen", "Twice", 1.25f},
        {NULL, NULL, "Half", "twice", "lin", "Screen", "Half", 1.25f},
        {NULL, NULL, "Half", "twice, +twice", "lin", "Screen", "Half", 2.25f},
        {NULL, NULL, "Twice", "-twice", "lin", "Screen", "Twice", 0.5f},
        {"half", NULL, "Half", NULL, "half", "Screen", "Half", 1.0f},
        {NULL, "Hidden", "Plain", NULL, "lin", "Hidden", "Plain", 1.0f},
        {NULL, "Hidden", NULL, NULL, "lin", "Hidden", "Plain", 1.0f},
        {NULL, NULL, "Shot", NULL, "lin", "Screen", "Shot", 4.0f},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct glarepp_tone_params p = ask();
        p.input = rows[i].input;
        p.display = rows[i].display;
        p.view = rows[i].view;
        p.look = rows[i].look;
        struct gp_ocio *o = opened(&p);
        const struct glarepp_plan_facts *const n = gp_ocio_facts(o);
        assert_string_equal(n->config, p.config);
        assert_string_equal(n->input, rows[i].is_input);
        assert_string_equal(n->display, rows[i].is_display);
        assert_string_equal(n->view, rows[i].is_view);
        if (p.look)
            assert_string_equal(n->look, p.look);
        assert_null(n->output);
        gp_ocio_close(&o);
        const float red = shown_red(&p, 1.0f);
        if (red != rows[i].red)
            fail_msg("row %zu: %g", i, (double) red);
    }
}

/* The names that tests/cli/ocio.t does not ask for. */
static void wrong_names_list_the_right_ones(void **state)
{
    static const char *const blank[] = {"=x"};
    const struct {
        struct glarepp_tone_params p;
        const char *parameter, *offers;
    } rows[] = {
        {{.input = "x"}, "tone.input", "scene_linear (role)"},
        {{.output = "x"}, "tone.output", "lin, half, turned, shot, "},
        {{.display = "Hidden", .view = "Half", .shows = true},
         "tone.view", "Hidden (found \"Half\"); give one of Plain"},
        {{.look = "twice, x", .shows = true}, "tone.look",
         "\"x\"); give one of twice"},
        {{.context = blank, .contexts = 1}, "tone.context",
         "(found \"=x\")"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct glarepp_tone_params p = rows[i].p;
        struct gp_ocio *o;
        p.config = wf_path("c.ocio");
        assert_int_equal(gp_ocio_open(&kept_all, &p, &o), GP_ERR_USAGE);
        assert_null(o);
        assert_string_equal(kept_parameter, rows[i].parameter);
        assert_kept(rows[i].offers);
        assert_null(strchr(kept_line, '\n'));
    }
}

static void many_names_are_cut(void **state)
{
    char *text = malloc(1 << 16), *end = text;
    assert_non_null(text);
    end += sprintf(end, "ocio_profile_version: 2\nroles: {default: s0}\n"
                   "displays: {D: [!<View> {name: V, colorspace: s0}]}\n"
                   "colorspaces:\n");
    for (int i = 0; i < 400; i++)
        end += sprintf(end, "  - !<ColorSpace> {name: s%d}\n", i);
    wf_write_text(wf_path("many.ocio"), text);
    free(text);
    struct glarepp_tone_params p = {.config = wf_path("many.ocio"), .input = "x"};
    struct gp_ocio *o;
    assert_int_equal(gp_ocio_open(&kept_all, &p, &o), GP_ERR_USAGE);
    assert_kept("s0, s1, s2");
    assert_kept(" more");
    assert_true(strlen(kept_line) < 800);
    p.input = NULL; // no scene_linear: the default
    o = opened(&p);
    assert_string_equal(gp_ocio_facts(o)->input, "s0");
    gp_ocio_close(&o);
}

static void bad_configs(void **state)
{
    char *deep = malloc(10064);
    assert_non_null(deep);
    strcpy(deep, "ocio_profile_version: ");
    memset(deep + 22, '[', 10000);
    deep[10022] = '\0';
    wf_write_text(wf_path("deep.ocio"), deep);
    free(deep);
    wf_write_text(wf_path("empty.ocio"), "");
    wf_write_text(wf_path("text.ocio"), "not a config\n");
    wf_write_text(wf_path("bytes.ocio"), "\x7f\x45\xff\xfe\x01: {{{\n\t- ]");
    wf_write_text(wf_path("future.ocio"), "ocio_profile_version: 99\n");
    wf_write_text(wf_path("huge.ocio"), "ocio_profile_version: 2\n");
    assert_int_equal(truncate(wf_path("huge.ocio"), 1LL << 40), 0);
    static const struct {
        const char *name;
        enum gp_status status;
        const char *text;
    } rows[] = {
        {"deep.ocio", GP_ERR_DATA, "refuses it"},
        {"empty.ocio", GP_ERR_DATA, "refuses it"},
        {"text.ocio", GP_ERR_DATA, "refuses it"},
        {"bytes.ocio", GP_ERR_DATA, "refuses it"},
        {"future.ocio", GP_ERR_DATA, "99"},
        {"huge.ocio", GP_ERR_DATA, "too large"}, {".", GP_ERR_IO, "is a file"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct glarepp_tone_params p = {.config = wf_path(rows[i].name),
                                   .shows = true};
        struct gp_ocio *o;
        assert_int_equal(gp_ocio_open(&kept_all, &p, &o), rows[i].status);
        assert_kept(p.config);
        assert_kept(rows[i].text);
        assert_kept("; ");
        assert_null(strchr(kept_line, '\n'));
    }
}

SUITE_OF(ocio, start, remove_folder, view_of_every_pixel, bad_pixels_stay_alone,
    only_what_was_asked, what_is_chosen, wrong_names_list_the_right_ones,
    many_names_are_cut, bad_configs)
