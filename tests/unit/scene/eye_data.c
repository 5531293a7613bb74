/* Shares of the data's sun and lamps by rays, past all that their scenes hold,
 * against the truth that was rendered from the eye: on screen and off, hidden,
 * behind the camera, through cut-out leaves. */
#include "scene/eye.h"

#include "core/memory.h"
#include "kept_log.h"
#include "scene/gltf/gltf.h"
#include "unit.h"

#include <jansson.h>
#include <png.h>
#include <unistd.h>

static gp_status leaf_alpha(void *user, const struct gp_log *log,
                            const char *name, const void *bytes, size_t n,
                            long long most, int *w, int *h,
                            uint16_t **alpha)
{
    png_image image = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_memory(&image, bytes, n));
    image.format = PNG_FORMAT_RGBA;
    *w = (int) image.width;
    *h = (int) image.height;
    const size_t pixels = (size_t) image.width * image.height;
    png_byte *const rgba = malloc(4 * pixels);
    assert_non_null(rgba);
    assert_true(png_image_finish_read(&image, NULL, rgba, 0, NULL));
    assert_ok(gp_alloc(log, name, pixels, sizeof **alpha, alpha));
    for (size_t i = 0; i < pixels; i++)
        (*alpha)[i] = (uint16_t) (257 * rgba[4 * i + 3]);
    free(rgba);
    return GP_OK;
}

static double number(const json_t *o, const char *key)
{
    return json_number_value(json_object_get(o, key));
}

struct errors {
    double sum, worst;
    int n, beyond; // of three deviations of either side, and 2e-3
};

static void count(struct errors *e, const char *name, int frame,
                  const struct gp_eye_share *got, double want, double deviation)
{
    const double off = fabs(got->clear - want);
    print_message("# %d %s: %.4f, truth %.4f, error at most %.4f, %d objects, "
                  "%d samples a side\n", frame, name, got->clear, want,
                  got->error, got->objects, got->samples);
    e->sum += off;
    e->worst = fmax(e->worst, off);
    e->beyond += off > 3.0 * (got->error + deviation) + 2e-3;
    e->n++;
    // a hidden or clear disc is that exactly
    if (want == 0.0 || want == 1.0)
        assert_true(off == 0.0);
}

/* Casts rays to each light of a scene in each of its frames. */
static void check_scene(const char *name, int shares)
{
    static const struct gp_scene_images images = {NULL, leaf_alpha};
    struct gp_scene s;
    struct gp_camera c;
    struct errors e = {0};
    char path[4200];
    snprintf(path, sizeof path, "scenes/%s.glb", name);
    if (access(data_path(path), R_OK) != 0)
        skip_for(NO_DATA);
    assert_ok(gp_scene_read(&kept_log, data_path(path), GP_UP_Z, &images, &s));
    snprintf(path, sizeof path, "scenes/%s.camera.json", name);
    json_t *const root = json_load_file(data_path(path), 0, NULL);
    const json_t *const frames = json_object_get(root, "frames");
    for (size_t i = 0; i < json_array_size(frames); i++) {
        const json_t *const frame = json_array_get(frames, i);
        const json_t *const lamps = json_object_get(frame, "lamps");
        const int at = (int) number(frame, "frame");
        gp_scene_pose(&s, at / 24.0);
        assert_ok(gp_scene_camera_make(
            &kept_log, &s, gp_scene_find_camera(&s, NULL), 640.0 / 360.0, &c));
        const struct gp_v3 eye = gp_camera_eye(&c);
        for (int k = 0; k < s.lights; k++) {
            const struct gp_scene_light *const l = &s.light[k];
            struct gp_eye_share got;
            if (l->kind == GP_LIGHT_DIRECTIONAL) {
                const struct gp_eye_disc d = gp_eye_sun(
                    eye, gp_v3_scale(l->along, -1.0),
                    number(frame, "sun_half_angle_deg") * acos(-1.0) / 180.0);
                assert_ok(gp_eye_rays(&kept_log, &s, NULL, &d, NULL, &got));
                count(&e, l->name, at, &got,
                      number(frame, "sun_visibility_true"),
                      number(frame, "sun_visibility_true_se"));
                continue;
            }
            const struct gp_eye_disc d = gp_eye_lamp(eye, l->at, l->ball);
            assert_true(l->ball > 0.0);
            assert_ok(gp_eye_rays(&kept_log, &s, NULL, &d, NULL, &got));
            for (size_t j = 0; j < json_array_size(lamps); j++) {
                const json_t *const lamp = json_array_get(lamps, j);
                if (!strcmp(json_string_value(json_object_get(lamp, "name")),
                            l->name))
                    count(&e, l->name, at, &got, number(lamp, "visible_share"),
                          number(lamp, "visible_share_se"));
            }
        }
    }
    print_message("# %s: %d shares, mean error %.5f, worst %.5f\n", name, e.n,
                  e.sum / e.n, e.worst);
    assert_int_equal(e.n, shares);
    assert_int_equal(e.beyond, 0);
    assert_true(e.sum / e.n <= 0.002 && e.worst <= 0.005);
    json_decref(root);
    gp_scene_free(&s);
}

static void sun_in_the_forest(void **state)
{
    check_scene("forest", 6);
}

static void lamps_in_the_street(void **state)
{
    check_scene("street", 32);
}

SUITE_OF(eye_data, NULL, NULL, sun_in_the_forest, lamps_in_the_street)
