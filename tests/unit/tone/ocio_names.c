/* tone/ocio: which config, spaces, views, looks and files names choose, and
 * what is said of wrong ones. */
#include "unit.h"
#include "ocio_config.h"

/* The red of pixel (0, 0) in the view that `p` asks for. */
static float shown_red(const struct gp_ocio_params *p, float light)
{
    struct gp_ocio *o = opened(p);
    struct gp_frame f = lit_frame(1, 1, light);
    const struct gp_tone_params tone = GP_TONE_DEFAULTS;
    assert_int_equal(gp_ocio_show(&wf_log, o, &tone, &f), 0);
    const float red = f.shown.c[0][0];
    gp_frame_free(&f);
    gp_ocio_close(&o);
    assert_null(o);
    return red;
}

// -- names --------------------------------------------------------------------

static void what_is_chosen(void **state)
{
    (void) state;
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
        struct gp_ocio_params p = ask();
        p.input = rows[i].input;
        p.display = rows[i].display;
        p.view = rows[i].view;
        p.look = rows[i].look;
        struct gp_ocio *o = opened(&p);
        const struct gp_ocio_names *const n = gp_ocio_names(o);
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

static void context_names_the_file(void **state)
{
    (void) state;
    static const char *const eight[] = {"SHOT=none", "SHOT=eight"};
    struct gp_ocio_params p = ask();
    struct gp_ocio *o;
    p.view = "Shot";
    p.context = eight;
    p.contexts = 2;
    assert_true(shown_red(&p, 0.5f) == 4.0f);
    p.contexts = 1;
    assert_int_equal(gp_ocio_open(&wf_log, &p, &o), GP_ERR_DATA);
    assert_null(o);
    wf_assert_said("none.spimtx");
    wf_assert_said("--ocio-context");
}

static void environment_names_the_config(void **state)
{
    (void) state;
    static const char *const words[] = {"", "env"};
    struct gp_ocio_params p = {.shows = true};
    struct gp_ocio *o;
    for (int i = 0; i < 2; i++) {
        p.config = words[i];
        unsetenv("OCIO");
        assert_int_equal(gp_ocio_open(&wf_log, &p, &o), GP_ERR_USAGE);
        wf_assert_said("$OCIO is not set");
        setenv("OCIO", wf_path("c.ocio"), 1);
        assert_true(shown_red(&p, 1.0f) == 0.75f);
        unsetenv("OCIO");
    }
}

// -- errors -------------------------------------------------------------------

static void wrong_names_list_the_right_ones(void **state)
{
    (void) state;
    static const char *const nothing[] = {"nothing"}, *const blank[] = {"=x"};
    const struct {
        struct gp_ocio_params p;
        const char *option, *offers;
    } rows[] = {
        {{.input = "x"}, "--input-space: ", "lin, half, turned, shot, "},
        {{.input = "x"}, "(found \"x\")", "scene_linear (role)"},
        {{.output = "x"}, "--output-space: ", "lin, half, turned, shot, "},
        {{.display = "x", .shows = true}, "--display: ", "give one of Screen"},
        {{.view = "x", .shows = true}, "--view: ",
         "Half, Turned, Twice, Shot"},
        {{.display = "Hidden", .view = "Half", .shows = true},
         "display Hidden (found \"Half\")", "give one of Plain"},
        {{.look = "twice, x", .shows = true}, "--look: ",
         "(found \"x\"); give one of twice"},
        {{.context = nothing, .contexts = 1}, "--ocio-context: ",
         "NAME=VALUE"},
        {{.context = blank, .contexts = 1}, "--ocio-context: ", "NAME=VALUE"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_ocio_params p = rows[i].p;
        struct gp_ocio *o;
        p.config = wf_path("c.ocio");
        assert_int_equal(gp_ocio_open(&wf_log, &p, &o), GP_ERR_USAGE);
        assert_null(o);
        wf_assert_said(rows[i].option);
        wf_assert_said(rows[i].offers);
        assert_null(strchr(wf_line, '\n'));
    }
}

static void many_names_are_cut(void **state)
{
    (void) state;
    char *text = malloc(1 << 16), *end = text;
    assert_non_null(text);
    end += sprintf(end, "ocio_profile_version: 2\nroles: {default: s0}\n"
                   "displays: {D: [!<View> {name: V, colorspace: s0}]}\n"
                   "colorspaces:\n");
    for (int i = 0; i < 400; i++)
        end += sprintf(end, "  - !<ColorSpace> {name: s%d}\n", i);
    put_file("many.ocio", text);
    free(text);
    struct gp_ocio_params p = {.config = wf_path("many.ocio"), .input = "x"};
    struct gp_ocio *o;
    assert_int_equal(gp_ocio_open(&wf_log, &p, &o), GP_ERR_USAGE);
    wf_assert_said("s0, s1, s2");
    wf_assert_said(" more");
    assert_true(strlen(wf_line) < 800);
    p.input = NULL; // no scene_linear: the default
    o = opened(&p);
    assert_string_equal(gp_ocio_names(o)->input, "s0");
    gp_ocio_close(&o);
}

static void bad_configs(void **state)
{
    (void) state;
    char *deep = malloc(10064);
    assert_non_null(deep);
    strcpy(deep, "ocio_profile_version: ");
    memset(deep + 22, '[', 10000);
    deep[10022] = '\0';
    put_file("deep.ocio", deep);
    free(deep);
    put_file("empty.ocio", "");
    put_file("text.ocio", "not a config\n");
    put_file("bytes.ocio", "\x7f\x45\xff\xfe\x01: {{{\n\t- ]");
    put_file("future.ocio", "ocio_profile_version: 99\n");
    put_file("huge.ocio", "ocio_profile_version: 2\n");
    assert_int_equal(truncate(wf_path("huge.ocio"), 1LL << 40), 0);
    static const struct {
        const char *name;
        enum gp_status status;
        const char *said;
    } rows[] = {
        {"deep.ocio", GP_ERR_DATA, "refuses it"},
        {"empty.ocio", GP_ERR_DATA, "refuses it"},
        {"text.ocio", GP_ERR_DATA, "refuses it"},
        {"bytes.ocio", GP_ERR_DATA, "refuses it"},
        {"future.ocio", GP_ERR_DATA, "99"},
        {"huge.ocio", GP_ERR_DATA, "too large"},
        {"missing.ocio", GP_ERR_IO, "No such file"},
        {".", GP_ERR_IO, "is a file"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_ocio_params p = {.config = wf_path(rows[i].name),
                                   .shows = true};
        struct gp_ocio *o;
        assert_int_equal(gp_ocio_open(&wf_log, &p, &o), rows[i].status);
        wf_assert_said(p.config);
        wf_assert_said(rows[i].said);
        wf_assert_said("; ");
        assert_null(strchr(wf_line, '\n'));
    }
}

SUITE_OF(ocio_names, start, wf_end, what_is_chosen, context_names_the_file,
         environment_names_the_config, wrong_names_list_the_right_ones,
         many_names_are_cut, bad_configs)
