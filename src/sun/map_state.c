#include "sun/map_state.h"

#include "core/memory.h"

enum { LIGHT_TEXELS = 3 }; // of a row of `lights`

/* -- making -----------------------------------------------------------------*/

static gp_status make_state(const struct gp_log *log, struct gp_sun_map **out)
{
    struct gp_sun_map *s = NULL;
    gp_status st = gp_alloc_zero(log, "sun map", 1, sizeof *s, (void **) &s);
    // zeroed: what lies between boxes is uploaded too
    if (!st)
        st = gp_alloc_zero(log, "sun map's upload", GP_SUN_BAND,
                           4 * sizeof(float), (void **) &s->band);
    if (st)
        gp_free(s);
    else
        *out = s;
    return st;
}

void gp_sun_map_close(const struct gp_gl *gl, struct gp_sun_map **state)
{
    struct gp_sun_map *const s = *state;
    if (!s)
        return;
    for (int i = 0; i < GP_SUN_PROGRAMS; i++)
        gp_program_free(gl, &s->program[i]);
    gp_texture_free(gl, &s->pixels);
    gp_texture_free(gl, &s->lights);
    gp_target_free(gl, &s->atlas);
    gp_target_free(gl, &s->region);
    gp_target_free(gl, &s->sums);
    gp_target_free(gl, &s->byte_sums);
    gp_target_free(gl, &s->intensity);
    gp_free(s->band);
    gp_free(s);
    *state = NULL;
}

gp_status gp_sun_use(const struct gp_log *log, const struct gp_gl *gl,
                     struct gp_sun_map *s, enum gp_sun_program which)
{
    static const struct {
        const char *defines, *vert, *frag;
    } files[GP_SUN_PROGRAMS] = {
        [GP_SUN_TEXELS] = {"", "sun_map.vert", "sun_map.frag"},
        [GP_SUN_PIXELS] = {"#define PIXELS\n", "sun_map.vert",
                           "sun_map.frag"},
        [GP_SUN_POINTS] = {"", "sun_point.vert", "sun_point.frag"},
        [GP_SUN_POINTS_BYTE] = {"#define BYTE\n", "sun_point.vert",
                                "sun_point.frag"},
        [GP_SUN_POINTS_BILINEAR] = {"#define BILINEAR\n", "sun_point.vert",
                                    "sun_point.frag"},
        [GP_SUN_TOTAL] = {"", "add.vert", "sun_sum.frag"},
    };
    if (s->program[which].id)
        return GP_OK;
    return gp_program_make_as(log, gl, files[which].defines,
                              files[which].vert, files[which].frag,
                              &s->program[which]);
}

/* -- each frame -------------------------------------------------------------*/

static gp_status check(const struct gp_log *log, const struct gp_gl *gl,
                       const struct gp_sun_params *p, int n)
{
    if (n < 1 || n > GP_LIGHTS_MAX)
        return gp_fail_bare(log, GP_ERR_BUG,
                            "sun map: %d lights (1 to %d can be drawn); "
                            "report it", n, GP_LIGHTS_MAX);
    if (p->map < 2 || p->map > 256 || p->map % 2)
        return gp_fail_bare(log, GP_ERR_BUG,
                            "sun map: %d texels wide (2 to 256, even, can be "
                            "drawn); report it", p->map);
    if (n > gp_gl_max_size(gl))
        return gp_fail_bare(log, GP_ERR_GL,
                            "sun map: %d lights do not go into a texture (%d "
                            "texels wide is the limit); use --sun-method exact",
                            n, gp_gl_max_size(gl));
    return GP_OK;
}

static void put_two(double v, float out[2])
{
    out[0] = (float) v;
    out[1] = (float) (v - (double) out[0]);
}

static gp_status write_lights(const struct gp_log *log, const struct gp_gl *gl,
                              struct gp_sun_map *s, int n)
{
    float row[GP_LIGHTS_MAX][4 * LIGHT_TEXELS];
    gp_status st = GP_OK;
    if (s->lights.h < n) {
        gp_texture_free(gl, &s->lights);
        st = gp_texture_make(log, gl, "lights", LIGHT_TEXELS, n, &s->lights);
    }
    for (int i = 0; i < n; i++) {
        const struct gp_sun_spot *const spot = &s->spot[i];
        put_two(spot->x, row[i]);
        put_two(spot->y, row[i] + 2);
        put_two(spot->radius, row[i] + 4);
        row[i][6] = (float) spot->k;
        row[i][7] = spot->limit;
        row[i][8] = (float) (spot->slot_x - spot->box.x0);
        row[i][9] = (float) (spot->slot_y - spot->box.y0);
        row[i][10] = row[i][11] = 0.0f;
    }
    if (!st)
        gp_texture_write(gl, &s->lights,
                         (struct gp_rect) {0, 0, LIGHT_TEXELS, n}, row[0]);
    return st;
}

static gp_status fit_intensity(const struct gp_log *log,
                               const struct gp_gl *gl, struct gp_sun_map *s,
                               int n)
{
    if (s->intensity.colour.w == n)
        return GP_OK;
    gp_target_free(gl, &s->intensity);
    return gp_target_make(log, gl, "intensity map", n, 1, &s->intensity);
}

gp_status gp_sun_begin(const struct gp_log *log, const struct gp_gl *gl,
                       const struct gp_occluders *o,
                       const struct gp_sun_params *p,
                       const struct gp_light *light, int n,
                       struct gp_sun_map **state)
{
    struct gp_sun_upload upload;
    gp_status st = check(log, gl, p, n);
    if (!st && !*state)
        st = make_state(log, state);
    if (st)
        return st;
    struct gp_sun_map *const s = *state;
    s->n = 0; // nothing is drawn until all is
    for (int i = 0; i < n; i++)
        s->spot[i] = gp_sun_spot_of(o, p->map, &light[i]);
    int most = gp_gl_max_size(gl);
    most = most < GP_SUN_BAND ? most : GP_SUN_BAND; // a row is a band at most
    GP_TRY(gp_sun_pack(log, o, s->spot, n, most, &upload));
    GP_TRY(gp_sun_upload(log, gl, o, &upload, s, n));
    GP_TRY(write_lights(log, gl, s, n));
    GP_TRY(fit_intensity(log, gl, s, n));
out:
    return st;
}
