// SPDX-License-Identifier: Apache-2.0
/* Lights, lens flare, lenses and cameras: the same text for each reader, and what it
 * makes of it put to use. */
#include "core/camera.h"
#include "core/colour.h"
#include "core/memory.h"
#include "harness.h"
#include "sun/flare.h"
#include "sun/lens.h"
#include "sun/lights.h"

#include <math.h>
#include <stdlib.h>

static const struct gp_rect display = {0, 0, 8, 6};

static void use_lights(const char *path)
{
    const struct gp_camera camera = {
        .to_ndc = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0},
    };
    struct glarepp_light *spec = NULL;
    int n = 0;
    if (fuzz_line(gp_lights_read(&fuzz_log, path, &spec, &n)))
        return;
    for (int i = 0; i < n; i++) {
        struct gp_light light;
        const enum glarepp_depth type = i & 1 ? GLAREPP_RAY : GLAREPP_Z;
        if (!fuzz_line(gp_light_place_in(&fuzz_log, "input", &spec[i], &camera,
                                         type, display, &light)) &&
            !(isfinite(light.x) && isfinite(light.y) && light.radius >= 0.0))
            abort();
    }
    gp_free(spec);
}

static void use_flare(const char *path)
{
    enum { MOST = 8 }; // elements to draw: each may cover every pixel
    struct gp_light light = GP_LIGHT_DEFAULTS;
    struct gp_flare flare = {0};
    struct gp_planes layer;
    light.x = light.y = 1.5;
    light.flux[0] = light.flux[1] = light.flux[2] = 1.0f;
    if (fuzz_line(gp_flare_read(&fuzz_log, path, &flare)))
        return;
    if (flare.n <= MOST &&
        !fuzz_line(gp_planes_make(&fuzz_log, "layer", 8 * 6, &layer))) {
        for (int c = 0; c < 3; c++) {
            for (int i = 0; i < 8 * 6; i++)
                layer.c[c][i] = 0.0f;
        }
        fuzz_line(gp_flare_add(&fuzz_log, &flare, &light, 1, display, display,
                               &layer));
        for (int i = 0; i < 8 * 6; i++) {
            if (!isfinite(layer.c[0][i]))
                abort();
        }
        gp_planes_free(&layer);
    }
    gp_flare_free(&flare);
}

static void use_lens(const char *path)
{
    enum { MOST = 9 }; // surfaces to draw: ghosts grow with their square
    static const struct gp_lens_light light = {1.5, 1.5, {1.0, 1.0, 1.0}};
    const struct gp_lens_view view = {
        .frame = display, .display = display, .mm = {4.5, 4.5},
        .chromaticities = gp_rec709_chromaticities,
        .luminance = gp_rec709_luminance, .tolerance = 1e-3,
    };
    struct gp_lens lens;
    struct gp_planes layer;
    struct glarepp_lens_facts stats;
    if (fuzz_line(gp_lens_read(&fuzz_log, path, &lens)) ||
        fuzz_line(gp_lens_focus(&fuzz_log, &lens, INFINITY, 0.0)) ||
        lens.n > MOST ||
        fuzz_line(gp_planes_make(&fuzz_log, "layer", 8 * 6, &layer)))
        return;
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < 8 * 6; i++)
            layer.c[c][i] = 0.0f;
    }
    fuzz_line(gp_lens_draw(&fuzz_log, &lens, &view, &light, 1, &layer, &stats));
    for (int i = 0; i < 8 * 6; i++) {
        if (!(layer.c[0][i] >= 0.0f && isfinite(layer.c[0][i])))
            abort();
    }
    gp_planes_free(&layer);
}

static void use_cameras(const char *path)
{
    static const double at[3] = {1.0, -2.0, 3.0};
    struct gp_camera_file file = {0};
    if (fuzz_line(gp_camera_read(&fuzz_log, path, &file)))
        return;
    for (int i = 0; i < file.n; i++) {
        const struct gp_camera *const c = &file.at[i].camera;
        const struct gp_projected p = gp_camera_project(c, display, at, 1.0);
        const double r = gp_camera_disc(c, display, at, 0.533);
        if (!p.behind && !(isfinite(p.x) && isfinite(p.y)))
            abort();
        if (!(r >= 0.0 && r <= 1e6))
            abort();
    }
    if (!gp_camera_frame_find(&file, file.at[0].frame))
        abort();
    gp_camera_file_free(&file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *const path = fuzz_file(data, size);
    fuzz_begin();
    if (path) {
        use_lights(path);
        use_flare(path);
        use_cameras(path);
        use_lens(path);
    }
    fuzz_end(FUZZ_FIXED + 24 * size);
    fuzz_file_close();
    return 0;
}
