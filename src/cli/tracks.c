// SPDX-License-Identifier: Apache-2.0
#include "cli/tracks.h"

#include "core/json.h"
#include "core/maths.h"
#include "core/memory.h"
#include "io/file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LOST = 24 }; // frames without a light that end its track

/* Returns how far a light is from where a track leads; INFINITY: too far. */
static double apart(const struct gp_track *t, const struct glarepp_share *l,
                    int frame, int height)
{
    static const double NEAR = 0.02, FAR_AWAY = 0.15; // of the height
    const double *const last = t->at[t->n - 1];
    const double *const before = t->at[t->n > 1 ? t->n - 2 : 0];
    const double since = frame - last[0], step = last[0] - before[0];
    const double more = step > 0.0 ? since / step : 0.0;
    if (since > LOST || !(since > 0.0))
        return INFINITY;
    const double way = gp_hypot(l->x - last[1] - more * (last[1] - before[1]),
                                l->y - last[2] - more * (last[2] - before[2]));
    if (way > FAR_AWAY * height)
        return INFINITY;
    const float most[2] = {fmaxf(t->flux[0], fmaxf(t->flux[1], t->flux[2])),
                           fmaxf(l->flux[0], fmaxf(l->flux[1], l->flux[2]))};
    double colour = 0.0; // octaves between those of equal brightness
    for (int c = 0; c < 3 && most[0] > 0.0f && most[1] > 0.0f; c++)
        colour =
            gp_hypot(colour, gp_log((double) (l->flux[c] / most[1] + 0.01f) /
                                    (double) (t->flux[c] / most[0] + 0.01f)) /
                                 M_LN2);
    return gp_hypot(way / (NEAR * height), 2.0 * colour);
}

static gp_status add_place(const struct gp_log *log, struct gp_track *t,
                           const struct glarepp_share *l, int frame)
{
    void *at = t->at;
    const gp_status st =
        gp_resize(log, "lights", ((size_t) t->n + 1) * sizeof *t->at, &at);
    if (st)
        return st;
    t->at = at;
    t->at[t->n][0] = frame;
    t->at[t->n][1] = l->x;
    t->at[t->n++][2] = l->y;
    for (int c = 0; c < 3; c++)
        t->flux[c] = fmaxf(t->flux[c], l->flux[c]);
    return GP_OK;
}

struct pair {
    double apart;
    int light, track;
};

static int by_distance(const void *a, const void *b)
{
    const struct pair *const x = a, *const y = b;
    return x->apart != y->apart   ? (x->apart > y->apart ? 1 : -1)
           : x->light != y->light ? x->light - y->light
                                  : x->track - y->track;
}

gp_status gp_tracks_add(const struct gp_log *log, struct gp_tracks *t,
                        const struct glarepp_facts *f, int frame, int height)
{
    const size_t most = (size_t) t->n * (size_t) f->lights;
    size_t pairs = 0;
    struct pair *pair = NULL;
    bool *added = NULL;
    void *tracks = t->track;
    gp_status st;
    GP_TRY(gp_alloc_zero(log, "lights", (size_t) f->lights + 1, sizeof *added,
                         &added));
    GP_TRY(gp_alloc(log, "lights", most + 1, sizeof *pair, &pair));
    for (int k = 0; k < t->n; k++) {
        for (int i = 0; i < f->lights; i++) {
            const double d = apart(&t->track[k], &f->light[i], frame, height);
            if (f->light[i].found && d < INFINITY)
                pair[pairs++] = (struct pair) {d, i, k};
        }
    }
    qsort(pair, pairs, sizeof *pair, by_distance); // the nearest first
    for (const struct pair *p = pair; p < pair + pairs; p++) {
        struct gp_track *const own = &t->track[p->track];
        if (added[p->light] || own->at[own->n - 1][0] >= frame)
            continue;
        added[p->light] = true;
        GP_TRY(add_place(log, own, &f->light[p->light], frame));
    }
    for (int i = 0; i < f->lights; i++) {
        if (added[i] || !f->light[i].found)
            continue;
        GP_TRY(gp_resize(log, "lights", ((size_t) t->n + 1) * sizeof *t->track,
                         &tracks));
        t->track = tracks;
        t->track[t->n] = (struct gp_track) {0};
        GP_TRY(add_place(log, &t->track[t->n++], &f->light[i], frame));
    }
out:
    gp_free(added);
    gp_free(pair);
    return st;
}

gp_status gp_tracks_write(const struct gp_log *log, const struct gp_tracks *t,
                          const char *path)
{
    static const char head[] = "{\"lights\": [\n", end[] = "]}\n";
    struct gp_file *f = NULL;
    gp_status st;
    GP_TRY(gp_file_open(log, path, false, false, &f));
    GP_TRY(gp_file_write(f, head, sizeof head - 1));
    for (int i = 0; i < t->n; i++) { // one a line
        const struct gp_track *const own = &t->track[i];
        json_t *const found = json_array();
        for (int k = 0; k < own->n && own->n > 1; k++)
            json_array_append_new(found,
                                  json_pack("[iff]", (int) own->at[k][0],
                                            own->at[k][1], own->at[k][2]));
        for (int c = 1; c < 3 && own->n == 1; c++)
            json_array_append_new(found, json_real(own->at[0][c]));
        char *const line = gp_json_print(
            json_pack("{s:o, s:o, s:[fff], s:[iii]}", "name",
                      json_sprintf("lamp%d", i + 1), "found", found, "flux",
                      (double) own->flux[0], (double) own->flux[1],
                      (double) own->flux[2], "color", 1, 1, 1),
            JSON_REAL_PRECISION(7));
        st = line ? gp_file_write(f, line, strlen(line))
                  : gp_no_memory(log, path);
        free(line);
        GP_TRY(st);
        if (i + 1 < t->n)
            GP_TRY(gp_file_write(f, ",", 1));
        GP_TRY(gp_file_write(f, "\n", 1));
    }
    GP_TRY(gp_file_write(f, end, sizeof end - 1));
    st = gp_file_commit(&f);
out:
    gp_file_discard(&f);
    return st;
}

void gp_tracks_free(struct gp_tracks *t)
{
    for (int i = 0; i < t->n; i++)
        gp_free(t->track[i].at);
    gp_free(t->track);
    *t = (struct gp_tracks) {0};
}
