// SPDX-License-Identifier: Apache-2.0
/* A lens: its prescription from JSON, its first-order optics and that of its
 * ghosts. Source: Lee and Eisemann, Practical Real-Time
 * Lens-Flare Rendering, 2013, with matrices of (height, slope) along the unfolded
 * path: after a reflection, radii change sign. */
#include "sun/lens_priv.h"

#include "core/bridge.h"
#include "core/json.h"
#include "core/maths.h"

#include <limits.h>
#include <math.h>
#include <string.h>

// -- the prescription ---------------------------------------------------------

static gp_status read_text(const struct gp_json_place *p, json_t *o,
                           const char *key, size_t room, char *out)
{
    const char *text = "";
    const gp_status st = gp_json_text(p, o, key, &text);
    if (st)
        return st;
    if (strlen(text) >= room)
        return gp_json_fail(p, "%s is too long (%zu bytes); shorten it to %zu",
                            key, strlen(text), room - 1);
    memcpy(out, text, strlen(text) + 1);
    gp_make_printable(out);
    return GP_OK;
}

static gp_status read_claims(const struct gp_json_place *p, json_t *root,
                             struct gp_lens *lens)
{
    static const char *const keys[] = {
        "focal_length", "f_number", "back_focus", "image_height", NULL};
    json_t *const o = json_object_get(root, "claims");
    struct glarepp_lens *const out = &lens->says;
    gp_status st;
    if (!o)
        return GP_OK;
    GP_TRY(gp_json_keys(p, o, keys));
    GP_TRY(gp_json_number(p, o, "focal_length", 0.1, 1e5, &out->claims_focal));
    GP_TRY(gp_json_number(p, o, "f_number", 0.3, 1e3, &out->claims_f_number));
    GP_TRY(gp_json_number(p, o, "back_focus", 1e-3, 1e5, &out->claims_back));
    GP_TRY(gp_json_number(p, o, "image_height", 1e-3, 1e4,
                          &out->claims_height));
out:
    return st;
}

/* Reads a list of rising numbers to the end of those of the lens. */
static gp_status read_rising(const struct gp_json_place *p, json_t *o,
                             const char *key, double lo, double hi,
                             struct gp_lens *lens, int *n)
{
    double *const at = lens->number + lens->numbers;
    json_t *list = NULL;
    gp_status st = gp_json_array(
        p, o, key, (size_t) (GP_LENS_NUMBERS - lens->numbers), &list);
    if (st)
        return st;
    *n = (int) json_array_size(list);
    st = gp_json_numbers(p, o, key, *n, lo, hi, at);
    for (int i = 1; i < *n && !st; i++) {
        if (!(at[i] > at[i - 1]))
            st = gp_json_fail(p,
                              "\"%s\" does not rise (found %g after %g); "
                              "sort it",
                              key, at[i], at[i - 1]);
    }
    if (!st && *n < 2)
        st = gp_json_fail(p, "\"%s\" has %d numbers; give 2 or more", key, *n);
    lens->numbers += *n;
    return st;
}

/* Reads a coat's table, to the end of those of the lens. */
static gp_status read_table(const struct gp_json_place *p, json_t *o,
                            struct gp_lens *lens)
{
    static const char *const keys[] = {"name", "nm", "degrees", "reflectance",
                                       NULL};
    struct gp_lens_coat *const c = &lens->coat[lens->coats];
    gp_status st;
    c->at = lens->numbers;
    GP_TRY(gp_json_keys(p, o, keys));
    GP_TRY(read_text(p, o, "name", sizeof c->name, c->name));
    if (!c->name[0] || !json_object_get(o, "reflectance"))
        GP_TRY(gp_json_fail(p, "no %s; add it",
                            c->name[0] ? "reflectance" : "name"));
    GP_TRY(read_rising(p, o, "nm", 100.0, 1e5, lens, &c->nms));
    GP_TRY(read_rising(p, o, "degrees", 0.0, 89.0, lens, &c->angles));
    if (c->nms > (GP_LENS_NUMBERS - lens->numbers) / c->angles)
        GP_TRY(gp_json_fail(p,
                            "too large: %d wavelengths of %d angles; a lens "
                            "has room for %d numbers",
                            c->nms, c->angles, GP_LENS_NUMBERS));
    GP_TRY(gp_json_numbers(p, o, "reflectance", c->nms * c->angles, 0.0, 1.0,
                           lens->number + lens->numbers));
    lens->numbers += c->nms * c->angles;
    lens->coats++;
out:
    return st;
}

/* Reads the wavelength of a layer, or the name of a table. */
static gp_status read_coat(const struct gp_json_place *p, json_t *o,
                           const struct gp_lens *lens, double *out)
{
    const char *name = NULL;
    if (!json_is_string(json_object_get(o, "coating")))
        return gp_json_number(p, o, "coating", 0.0, 5000.0, out);
    const gp_status st = gp_json_text(p, o, "coating", &name);
    for (int i = 0; i < lens->coats && !st; i++) {
        if (strcmp(name, lens->coat[i].name) != 0)
            continue;
        *out = -1.0 - i;
        return GP_OK;
    }
    return gp_json_fail(p, "no coating \"%.40s\"; add it to \"coatings\"",
                        name);
}

/* Reads surface i. */
static gp_status read_surface(const struct gp_json_place *p, json_t *o,
                              double coating, int i, struct gp_lens *lens)
{
    const struct gp_lens_surface *const before = i ? &lens->at[i - 1] : NULL;
    const bool last = i == lens->n - 1;
    static const char *const keys[] = {
        "radius", "thickness", "n", "v", "semi", "coating", "stop", NULL};
    static const char *const stop_keys[] = {"thickness", "semi", "stop", NULL};
    struct gp_lens_surface s = {.n = 1.0};
    double radius = INFINITY;
    gp_status st;
    const bool stop = json_is_true(json_object_get(o, "stop"));
    GP_TRY(gp_json_keys(p, o, stop ? stop_keys : keys));
    if (json_object_get(o, "stop") && !stop)
        GP_TRY(gp_json_fail(p, "stop is not true; leave it out"));
    if (stop && before) {
        s.n = before->n;
        s.v = before->v;
    }
    GP_TRY(gp_json_number(p, o, "thickness", last ? 0.0 : 1e-6, 1e5, &s.gap));
    GP_TRY(gp_json_number(p, o, "semi", 1e-3, 1e4, &s.semi));
    GP_TRY(gp_json_number(p, o, "radius", -1e9, 1e9, &radius));
    GP_TRY(gp_json_number(p, o, "n", 1.0, 5.0, &s.n));
    GP_TRY(gp_json_number(p, o, "v", 0.0, 200.0, &s.v));
    if (s.semi == 0.0 || (s.gap == 0.0 && !last))
        GP_TRY(gp_json_fail(p, "no %s; add it in millimetres",
                            s.semi > 0.0 ? "thickness" : "semi"));
    if (radius == 0.0)
        GP_TRY(gp_json_fail(p, "the radius is 0; leave it out for a flat "
                            "surface"));
    if (fabs(radius) < s.semi)
        GP_TRY(gp_json_fail(p, "the radius is under semi (found %g and %g); no "
                            "sphere is so wide", radius, s.semi));
    if (s.v > 0.0 && s.v < 10.0)
        GP_TRY(gp_json_fail(p, "v is not an Abbe number (found %g); give 10 to "
                            "200, or 0 for none", s.v));
    s.curvature = 1.0 / radius;
    // by default between glass and air: cemented surfaces have no coat
    const double n = before ? before->n : 1.0;
    s.coat = !stop && n != s.n && (n == 1.0 || s.n == 1.0) ? coating : 0.0;
    GP_TRY(read_coat(p, o, lens, &s.coat));
    lens->at[i] = s;
    if (stop && lens->stop >= 0)
        GP_TRY(gp_json_fail(p, "a second stop; leave one out"));
    if (stop)
        lens->stop = i;
out:
    return st;
}

static gp_status read_surfaces(const struct gp_json_place *p, json_t *list,
                               double coating, struct gp_lens *lens)
{
    struct gp_json_place at = {p->log, p->path, "surface", 0};
    lens->stop = -1;
    lens->n = (int) json_array_size(list);
    for (int i = 0; i < lens->n; i++) {
        at.index = i + 1;
        const gp_status st = read_surface(&at, json_array_get(list, (size_t) i),
                                          coating, i, lens);
        if (st)
            return st;
    }
    if (lens->stop < 0)
        return gp_json_fail(p, "no stop; add a surface {\"stop\": true, "
                            "\"thickness\": mm, \"semi\": mm}");
    at.index = lens->n;
    if (lens->at[lens->n - 1].n != 1.0)
        return gp_json_fail(&at,
                            "glass up to the sensor (found n %g); leave n "
                            "of the last one out",
                            lens->at[lens->n - 1].n);
    return GP_OK;
}

static gp_status read_lens(const struct gp_json_place *p, json_t *root,
                           struct gp_lens *lens)
{
    static const char *const keys[] = {
        "name",       "patent",  "note",     "claims",   "blades",
        "blade_turn", "coating", "coatings", "surfaces", NULL};
    struct glarepp_lens *const says = &lens->says;
    double coating = 0.0;
    json_t *list = NULL;
    gp_status st;
    GP_TRY(gp_json_keys(p, root, keys));
    GP_TRY(read_text(p, root, "name", sizeof says->name, says->name));
    GP_TRY(read_text(p, root, "patent", sizeof says->patent, says->patent));
    GP_TRY(read_text(p, root, "note", sizeof says->note, says->note));
    if (!says->name[0])
        GP_TRY(gp_json_fail(p, "no name; add \"name\": text"));
    GP_TRY(read_claims(p, root, lens));
    GP_TRY(gp_json_int(p, root, "blades", 0, 32, &says->blades));
    if (says->blades == 1 || says->blades == 2)
        GP_TRY(gp_json_fail(p, "blades make no opening (found %d); give 3 to "
                            "32, or 0 for a round stop", says->blades));
    GP_TRY(gp_json_number(p, root, "blade_turn", -360.0, 360.0, &lens->turn));
    if (json_object_get(root, "coatings"))
        GP_TRY(gp_json_array(p, root, "coatings", GP_LENS_COATS, &list));
    for (size_t i = 0; i < json_array_size(list); i++) {
        const struct gp_json_place at = {p->log, p->path, "coating",
                                         (int) i + 1};
        GP_TRY(read_table(&at, json_array_get(list, i), lens));
    }
    GP_TRY(read_coat(p, root, lens, &coating));
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
            return gp_fail_at(log, GP_ERR_IO, "lens.lens",
                              "%s: no installed "
                              "lens has this name; write a file as ./%s",
                              name, name);
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

// -- glass and coats ----------------------------------------------------------

double gp_lens_index(double n, double v, double nm)
{
    // Fraunhofer lines in micrometres
    const double d = 0.5875618, f = 0.4861327, c = 0.6562725;
    if (!(v > 0.0) || n == 1.0)
        return n;
    const double b = (n - 1.0) / v / (1.0 / (f * f) - 1.0 / (c * c));
    const double um = nm * 1e-3;
    return n + b * (1.0 / (um * um) - 1.0 / (d * d));
}

/* Amplitudes of two boundaries with a layer of phase `twice` (there and back)
 * between them, as a share of the light. */
static double of_layer(double r1, double r2, double twice)
{
    const double both = 2.0 * r1 * r2 * gp_cos(twice);
    const double all = 1.0 + r1 * r1 * r2 * r2 + both;
    return all > 0.0 ? (r1 * r1 + r2 * r2 + both) / all : 1.0;
}

/* The share that a surface reflects, by the cosine in n1. */
static double of_surface(double n1, double n2, double cosine, double coat,
                         double nm)
{
    const double fluoride = 1.38; // of magnesium, the hard coat of one layer
    const double sine2 = 1.0 - cosine * cosine;
    const double t2 = 1.0 - n1 * n1 / (n2 * n2) * sine2;
    if (t2 <= 0.0)
        return 1.0; // total
    const double c1 = cosine, c2 = sqrt(t2);
    if (!(coat > 0.0)) {
        const double s = (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2);
        const double p = (n2 * c1 - n1 * c2) / (n2 * c1 + n1 * c2);
        return 0.5 * (s * s + p * p);
    }
    const double n = fmax(sqrt(n1 * n2), fluoride);
    const double tm = 1.0 - n1 * n1 / (n * n) * sine2;
    if (tm <= 0.0)
        return 1.0;
    const double cm = sqrt(tm);
    const double phase = M_PI * coat / nm * cm; // 4 pi n d cm / nm, n d = 1/4
    const double s1 = (n1 * c1 - n * cm) / (n1 * c1 + n * cm);
    const double s2 = (n * cm - n2 * c2) / (n * cm + n2 * c2);
    const double p1 = (n * c1 - n1 * cm) / (n * c1 + n1 * cm);
    const double p2 = (n2 * cm - n * c2) / (n2 * cm + n * c2);
    return 0.5 * (of_layer(s1, s2, phase) + of_layer(p1, p2, phase));
}

// -- paths and matrices -------------------------------------------------------

/* The index before surface i of the lens; before surface n, after the last. */
static double index_at(const struct gp_lens *lens, int i, double nm)
{
    return i == 0 ? 1.0 : gp_lens_index(lens->at[i - 1].n, lens->at[i - 1].v,
                                        nm);
}

/* Returns the place of v in n rising numbers: a step, and how far in it. */
static int step_of(const double *at, int n, double v, double *t)
{
    int i = 0;
    while (i + 2 < n && v >= at[i + 1])
        i++;
    *t = fmin(fmax((v - at[i]) / (at[i + 1] - at[i]), 0.0), 1.0);
    return i;
}

double gp_lens_reflected(const struct gp_lens *lens, int i, double cosine,
                         double nm)
{
    const double before = index_at(lens, i, nm);
    const double after = index_at(lens, i + 1, nm);
    if (!(lens->at[i].coat < 0.0))
        return of_surface(fmin(before, after), fmax(before, after), cosine,
                          lens->at[i].coat, nm);
    const struct gp_lens_coat *const c =
        &lens->coat[-1 - (int) lens->at[i].coat];
    const double *const angle = lens->number + c->at + c->nms;
    const double last = angle[c->angles - 1];
    const double degrees = gp_acos(fmin(cosine, 1.0)) * (180.0 / M_PI);
    double s, t;
    const int row = step_of(lens->number + c->at, c->nms, nm, &s);
    const int column = step_of(angle, c->angles, degrees, &t);
    const double *const at = angle + c->angles * (row + 1) + column;
    const double *const next = at + c->angles;
    const double share = (1.0 - s) * ((1.0 - t) * at[0] + t * at[1]) +
                         s * ((1.0 - t) * next[0] + t * next[1]);
    // beyond the table to all of the light at 90 degrees
    return share + (1.0 - share) * fmax(degrees - last, 0.0) / (90.0 - last);
}

/* Returns true where the index changes. */
static bool reflects(const struct gp_lens *lens, int i)
{
    const double n = i == 0 ? 1.0 : lens->at[i - 1].n;
    const double v = i == 0 ? 0.0 : lens->at[i - 1].v;
    return i != lens->stop && (n != lens->at[i].n || v != lens->at[i].v);
}

void gp_lens_path(const struct gp_lens *lens, int first, int second,
                  struct gp_lens_path *out)
{
    struct gp_lens_step *s = out->step;
    const int turn = first < 0 ? lens->n : first;
    for (int i = 0; i < turn; i++)
        *s++ = (struct gp_lens_step) {i, false, false};
    if (first >= 0) {
        *s++ = (struct gp_lens_step) {first, false, true};
        for (int i = first - 1; i > second; i--)
            *s++ = (struct gp_lens_step) {i, true, false};
        *s++ = (struct gp_lens_step) {second, true, true};
        for (int i = second + 1; i < lens->n; i++)
            *s++ = (struct gp_lens_step) {i, false, false};
    }
    out->steps = (int) (s - out->step);
}

static struct gp_lens_matrix times(struct gp_lens_matrix p,
                                   struct gp_lens_matrix q)
{
    return (struct gp_lens_matrix) {
        p.a * q.a + p.b * q.c, p.a * q.b + p.b * q.d,
        p.c * q.a + p.d * q.c, p.c * q.b + p.d * q.d,
    };
}

static struct gp_lens_matrix way_of(double gap)
{
    return (struct gp_lens_matrix) {1.0, gap, 0.0, 1.0};
}

/* The matrix of one step: T of the way from the step before, then R or L. */
static struct gp_lens_matrix of_step(const struct gp_lens *lens,
    const struct gp_lens_path *path, int k, double nm)
{
    const struct gp_lens_step s = path->step[k];
    const int before = k == 0 ? 0 : path->step[k - 1].surface;
    const int low = before < s.surface ? before : s.surface;
    const double way = k == 0 ? 0.0 : lens->at[low].gap;
    const double curvature = s.back ? -lens->at[s.surface].curvature
                                    : lens->at[s.surface].curvature;
    const double n1 = index_at(lens, s.surface + s.back, nm);
    const double n2 = index_at(lens, s.surface + !s.back, nm);
    const struct gp_lens_matrix bend =
        s.reflects ? (struct gp_lens_matrix) {1.0, 0.0, 2.0 * curvature, 1.0}
                   : (struct gp_lens_matrix) {1.0, 0.0, (n1 - n2) / n2 *
                                                        curvature, n1 / n2};
    return times(bend, way_of(way));
}

struct gp_lens_matrix gp_lens_matrix(const struct gp_lens *lens,
    const struct gp_lens_path *path, int steps, double nm)
{
    struct gp_lens_matrix m = way_of(0.0);
    for (int k = 0; k < steps; k++)
        m = times(of_step(lens, path, k, nm), m);
    return m;
}

// -- the whole lens -----------------------------------------------------------

/* Returns the matrix from the front to after so many surfaces. */
static struct gp_lens_matrix front_matrix(const struct gp_lens *lens,
                                          int surfaces)
{
    struct gp_lens_path path;
    gp_lens_path(lens, -1, -1, &path);
    return gp_lens_matrix(lens, &path, surfaces, GP_D_LINE);
}

gp_status gp_lens_focus(const struct gp_log *log, struct gp_lens *lens,
                        double distance, double f_number)
{
    const struct gp_lens_matrix m = front_matrix(lens, lens->n);
    const struct gp_lens_matrix to_stop = front_matrix(lens, lens->stop + 1);
    const double focal = m.c < 0.0 ? -1.0 / m.c : 0.0;
    if (!(focal >= 0.1 && focal <= 1e5))
        return gp_fail(log, GP_ERR_DATA, "%s: does not collect light (power "
                       "%g per mm); check the signs of the radii",
                       lens->says.name, -m.c);
    // the chief ray, by which places in the picture have slopes
    if (!(fabs(to_stop.a) > 1e-6))
        return gp_fail(log, GP_ERR_DATA, "%s: has its stop in a focus; check "
                       "radii and thicknesses before it", lens->says.name);
    // a ray from the axis at the object: height = distance * slope
    const double far = isinf(distance) ? 0.0 : 1.0 / distance;
    const double y = m.a + m.b * far, slope = m.c + m.d * far;
    const double gap = -y / slope;
    if (!(slope < 0.0 && gap > 0.0 && gap <= 1e5))
        return gp_fail_at(log, GP_ERR_USAGE, "lens.distance", "%s: makes no "
                          "image of an object %g m away", lens->says.name,
                          distance * 1e-3);
    lens->at[lens->n - 1].gap = gap;
    const double own = focal / (2.0 * lens->at[lens->stop].semi /
                                fabs(to_stop.a));
    if (f_number > 0.0 && f_number < own * 0.995)
        return gp_fail_at(log, GP_ERR_USAGE, "lens.f_number", "%s: opens to "
                          "f/%.4g only (found f/%g)", lens->says.name, own,
                          f_number);
    if (f_number > own)
        lens->at[lens->stop].semi *= own / f_number;
    return GP_OK;
}

double gp_lens_measure(const struct gp_lens *lens, struct glarepp_lens *out)
{
    const struct gp_lens_matrix m = front_matrix(lens, lens->n);
    const struct gp_lens_matrix s = front_matrix(lens, lens->stop + 1);
    const struct gp_lens_matrix all =
        times(way_of(lens->at[lens->n - 1].gap), m);
    const double pupil_at = s.b / s.a; // after the first surface
    double field = INFINITY; // slope at which the chief ray meets a rim
    *out = lens->says;
    out->surfaces = lens->n;
    out->stop = lens->stop;
    out->focal = -1.0 / m.c;
    out->back = -m.a / m.c;
    out->pupil = lens->at[lens->stop].semi / fabs(s.a);
    out->f_number = out->focal / (2.0 * out->pupil);
    out->through = 1.0;
    for (int i = 0; i < lens->n; i++) {
        const struct gp_lens_matrix to = front_matrix(lens, i + 1);
        const double height = fabs(to.b - to.a * s.b / s.a); // at slope 1
        if (i != lens->stop && height * field > lens->at[i].semi)
            field = lens->at[i].semi / height;
        out->through *= 1.0 - gp_lens_reflected(lens, i, 1.0, GP_D_LINE);
    }
    out->height = isfinite(field) ? out->focal * field : 0.0;
    return all.b - all.a * pupil_at;
}

// -- ghosts -------------------------------------------------------------------

/* Follows a ghost's path. */
static struct glarepp_ghost ghost_of(const struct gp_lens *lens, int first,
                                     int second, double nm, double *blur)
{
    struct glarepp_ghost g = {.first = first, .second = second,
                              .radius = INFINITY, .through = 1.0};
    struct gp_lens_matrix m = way_of(0.0), s = m; // s: to the stop, at last
    struct gp_lens_path path;
    gp_lens_path(lens, first, second, &path);
    for (int k = 0; k < path.steps; k++) {
        const int i = path.step[k].surface;
        const double semi = lens->at[i].semi,
                     r = gp_lens_reflected(lens, i, 1.0, nm);
        m = times(of_step(lens, &path, k, nm), m);
        // else parallel light that all passes
        if (fabs(m.a) * 1e6 > semi && semi / fabs(m.a) < g.radius) {
            g.radius = semi / fabs(m.a);
            g.shift = -m.b / m.a;
        }
        g.through *= path.step[k].reflects ? r : 1.0 - r;
        if (i == lens->stop)
            s = m;
    }
    m = times(way_of(lens->at[lens->n - 1].gap), m);
    g.a = m.a;
    g.b = m.b;
    // from the stop to the sensor: m = after * s
    const double det = s.a * s.d - s.b * s.c;
    const double b = (m.b * s.a - m.a * s.b) / det;
    // Collins' integral from the stop: a fringe of sqrt(nm |A B|), with A the
    // size of the ghost over that of the stop
    if (blur)
        *blur = s.a != 0.0 ? sqrt(nm * 1e-6 * fabs(m.a / s.a * b)) : 0.0;
    return g;
}

int gp_lens_ghosts(const struct gp_lens *lens, double nm,
                   struct glarepp_ghost out[GP_LENS_GHOSTS],
                   double blur[GP_LENS_GHOSTS])
{
    int n = 0;
    for (int first = 1; first < lens->n; first++) {
        for (int second = 0; second < first; second++) {
            if (!reflects(lens, first) || !reflects(lens, second))
                continue;
            out[n] = ghost_of(lens, first, second, nm,
                              blur ? &blur[n] : NULL);
            n++;
        }
    }
    return n;
}
