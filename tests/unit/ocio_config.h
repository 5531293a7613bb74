/* A config of matrices, whose results are exact in float, and frames to show
 * by it. */
#ifndef GP_TESTS_OCIO_CONFIG_H
#define GP_TESTS_OCIO_CONFIG_H

#include "tone/ocio.h"
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
    "  - !<ColorSpace> {name: lin}\n"
    "  - !<ColorSpace>\n"
    "    name: half\n"
    "    from_scene_reference: !<MatrixTransform> {matrix: [0.5,0,0,0, "
    "0,0.5,0,0, 0,0,0.5,0, 0,0,0,1], offset: [0.25,0.25,0.25,0]}\n"
    "  - !<ColorSpace>\n"
    "    name: turned\n"
    "    from_scene_reference: !<MatrixTransform> {matrix: [0,0,1,0, "
    "1,0,0,0, 0,1,0,0, 0,0,0,1]}\n"
    "  - !<ColorSpace>\n"
    "    name: shot\n"
    "    from_scene_reference: !<FileTransform> {src: $SHOT.spimtx}\n";

static inline void put_file(const char *name, const char *text)
{
    FILE *f = fopen(wf_path(name), "wb");
    assert_non_null(f);
    assert_true(fputs(text, f) >= 0);
    assert_int_equal(fclose(f), 0);
}

static inline int start(void **state)
{
    if (wf_start(state) || find_bridges(state))
        return -1;
    put_file("c.ocio", config_text);
    put_file("four.spimtx", "4 0 0 0\n0 4 0 0\n0 0 4 0\n");
    put_file("eight.spimtx", "8 0 0 0\n0 8 0 0\n0 0 8 0\n");
    unsetenv("OCIO");
    return 0;
}

static inline struct gp_ocio_params ask(void)
{
    return (struct gp_ocio_params) {.config = wf_path("c.ocio"),
                                    .shows = true};
}

/* A frame of w x h with light in `lit`; (0, 0) has `first` in its red. */
static inline struct gp_frame lit_frame(int w, int h, float first)
{
    struct gp_frame f = wf_frame((struct gp_rect) {-3, 2, w - 3, h + 2},
                                 (struct gp_rect) {0, 0, 8, 8}, wf_rgb);
    f.lit = f.rgb;
    f.rgb = (struct gp_planes) {0};
    f.lit.c[0][0] = first;
    return f;
}

static inline struct gp_ocio *opened(const struct gp_ocio_params *p)
{
    struct gp_ocio *o;
    wf_line[0] = '\0';
    if (gp_ocio_open(&wf_log, p, &o))
        fail_msg("%s", wf_line);
    return o;
}

#endif
