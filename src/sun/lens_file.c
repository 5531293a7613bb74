/* Prescriptions of lenses: read from JSON, found by name. */
#include "sun/lens.h"

#include "core/bridge.h"
#include "core/json.h"

#include <limits.h>
#include <math.h>
#include <string.h>

static gp_status read_text(const struct gp_json_place *p, json_t *o,
                           const char *key, size_t room, char *out)
{
    const char *text = "";
    const gp_status st = gp_json_text(p, o, key, &text, NULL);
    if (st)
        return st;
    if (strlen(text) >= room)
        return gp_json_fail(p, "%s is too long (%zu bytes); shorten it to %zu",
                            key, strlen(text), room - 1);
    memcpy(out, text, strlen(text) + 1);
    return GP_OK;
}

static gp_status read_claims(const struct gp_json_place *p, json_t *root,
                             struct gp_lens *lens)
{
    static const char *const keys[] = {
        "focal_length", "f_number", "back_focus", "image_height", NULL};
    json_t *const o = json_object_get(root, "claims");
    gp_status st;
    if (!o)
        return GP_OK;
    GP_TRY(gp_json_keys(p, o, keys));
    GP_TRY(gp_json_number(p, o, "focal_length", 0.1, 1e5, &lens->claims_focal,
                          NULL));
    GP_TRY(gp_json_number(p, o, "f_number", 0.3, 1e3, &lens->claims_f_number,
                          NULL));
    GP_TRY(gp_json_number(p, o, "back_focus", 1e-3, 1e5, &lens->claims_back,
                          NULL));
    GP_TRY(gp_json_number(p, o, "image_height", 1e-3, 1e4,
                          &lens->claims_height, NULL));
out:
    return st;
}

/* A surface, after one in `before`. */
static gp_status read_surface(const struct gp_json_place *p, json_t *o,
    double coating, const struct gp_lens_surface *before, bool last,
    struct gp_lens_surface *out, bool *stop)
{
    static const char *const keys[] = {
        "radius", "thickness", "n", "v", "semi", "coating", "stop", NULL};
    static const char *const stop_keys[] = {"thickness", "semi", "stop", NULL};
    struct gp_lens_surface s = {.n = 1.0};
    double radius = 0.0;
    bool has_radius = false, has_gap, has_semi, has_coat = false;
    gp_status st;
    GP_TRY(gp_json_keys(p, o, keys));
    *stop = json_is_true(json_object_get(o, "stop"));
    if (json_object_get(o, "stop") && !*stop)
        GP_TRY(gp_json_fail(p, "stop is not true; leave it out"));
    if (*stop)
        GP_TRY(gp_json_keys(p, o, stop_keys));
    GP_TRY(gp_json_number(p, o, "thickness", last ? 0.0 : 1e-6, 1e5, &s.gap,
                          &has_gap));
    GP_TRY(gp_json_number(p, o, "semi", 1e-3, 1e4, &s.semi, &has_semi));
    if (!*stop) {
        GP_TRY(gp_json_number(p, o, "radius", -1e9, 1e9, &radius,
                              &has_radius));
        GP_TRY(gp_json_number(p, o, "n", 1.0, 5.0, &s.n, NULL));
        GP_TRY(gp_json_number(p, o, "v", 0.0, 200.0, &s.v, NULL));
        GP_TRY(gp_json_number(p, o, "coating", 0.0, 5000.0, &s.coat,
                              &has_coat));
    } else if (before) {
        s.n = before->n;
        s.v = before->v;
    }
    if (!has_semi || (!has_gap && !last))
        GP_TRY(gp_json_fail(p, "no %s; add it in millimetres",
                            has_semi ? "thickness" : "semi"));
    if (has_radius && radius == 0.0)
        GP_TRY(gp_json_fail(p, "the radius is 0; leave it out for a flat "
                            "surface"));
    if (has_radius && fabs(radius) < s.semi)
        GP_TRY(gp_json_fail(p, "the radius is under semi (found %g and %g); no "
                            "sphere is so wide", radius, s.semi));
    if (s.v > 0.0 && s.v < 10.0)
        GP_TRY(gp_json_fail(p, "v is not an Abbe number (found %g); give 10 to "
                            "200, or 0 for none", s.v));
    s.curvature = has_radius ? 1.0 / radius : 0.0;
    // by default between glass and air: cemented surfaces have no coat
    const double n = before ? before->n : 1.0;
    if (!has_coat && !*stop && n != s.n && (n == 1.0 || s.n == 1.0))
        s.coat = coating;
    *out = s;
out:
    return st;
}

static gp_status read_surfaces(const struct gp_json_place *p, json_t *list,
                               double coating, struct gp_lens *lens)
{
    lens->stop = -1;
    lens->n = (int) json_array_size(list);
    for (int i = 0; i < lens->n; i++) {
        const struct gp_json_place at = {p->log, p->path, "surface", i + 1};
        bool stop;
        const gp_status st = read_surface(
            &at, json_array_get(list, (size_t) i), coating,
            i ? &lens->at[i - 1] : NULL, i == lens->n - 1, &lens->at[i], &stop);
        if (st)
            return st;
        if (stop && lens->stop >= 0)
            return gp_json_fail(&at, "a second stop; leave one out");
        if (stop)
            lens->stop = i;
    }
    if (lens->stop < 0)
        return gp_json_fail(p, "no stop; add a surface {\"stop\": true, "
                            "\"thickness\": mm, \"semi\": mm}");
    if (lens->at[lens->n - 1].n != 1.0)
        return gp_fail(p->log, GP_ERR_DATA, "%s: surface %d: glass up to the "
                       "sensor (found n %g); leave n of the last one out",
                       p->path, lens->n, lens->at[lens->n - 1].n);
    return GP_OK;
}

static gp_status read_lens(const struct gp_json_place *p, json_t *root,
                           struct gp_lens *lens)
{
    static const char *const keys[] = {
        "name", "patent", "note", "claims", "blades", "blade_turn", "coating",
        "surfaces", NULL};
    double coating = 0.0;
    json_t *list = NULL;
    gp_status st;
    GP_TRY(gp_json_keys(p, root, keys));
    GP_TRY(read_text(p, root, "name", sizeof lens->name, lens->name));
    GP_TRY(read_text(p, root, "patent", sizeof lens->patent, lens->patent));
    GP_TRY(read_text(p, root, "note", sizeof lens->note, lens->note));
    gp_make_printable(lens->name);
    gp_make_printable(lens->patent);
    gp_make_printable(lens->note);
    if (!lens->name[0])
        GP_TRY(gp_json_fail(p, "no name; add \"name\": text"));
    GP_TRY(read_claims(p, root, lens));
    GP_TRY(gp_json_int(p, root, "blades", 0, 32, &lens->blades, NULL));
    if (lens->blades == 1 || lens->blades == 2)
        GP_TRY(gp_json_fail(p, "blades make no opening (found %d); give 3 to "
                            "32, or 0 for a round stop", lens->blades));
    GP_TRY(gp_json_number(p, root, "blade_turn", -360.0, 360.0, &lens->turn,
                          NULL));
    GP_TRY(gp_json_number(p, root, "coating", 0.0, 5000.0, &coating, NULL));
    GP_TRY(gp_json_array(p, root, "surfaces", GP_LENS_SURFACES, &list));
    GP_TRY(read_surfaces(p, list, coating, lens));
out:
    return st;
}

gp_status gp_lens_read(const struct gp_log *log, const char *name,
                       struct gp_lens *out)
{
    char path[PATH_MAX], file[NAME_MAX];
    struct gp_json_place p = {log, name, "lens", 0};
    struct gp_lens lens = {0};
    json_t *root = NULL;
    // a word without / and . is an installed lens
    if (!strpbrk(name, "/.")) {
        const int n = snprintf(file, sizeof file, "lenses/%s.json", name);
        if ((size_t) n >= sizeof file ||
            !gp_example_find(file, path, sizeof path))
            return gp_fail_at(log, GP_ERR_IO, "lens.lens", "%s: no installed "
                              "lens has this name; give a file", name);
        p.path = path;
    }
    gp_status st = gp_json_read(log, p.path, GP_JSON_SMALL, &root);
    if (st)
        return st;
    st = read_lens(&p, root, &lens);
    json_decref(root);
    if (!st)
        *out = lens;
    return st;
}
