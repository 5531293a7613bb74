#include "io/channels.h"

#include "io/exr_origin.h"
#include "io/half.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

enum { LIST_BYTES = 1500 };

/* The names of the frame's channels, with commas, cut where `to` ends. */
static const char *list_channels(const struct gp_frame *f,
                                 char to[LIST_BYTES])
{
    size_t used = 0;
    to[0] = '\0';
    for (int i = 0; i < f->channels; i++) {
        const char *name = f->channel[i].name;
        size_t room = LIST_BYTES - used;
        if (strlen(name) + 8 > room) {
            snprintf(to + used, room, ", ...");
            break;
        }
        used += (size_t) snprintf(to + used, room, "%s%s", i ? ", " : "",
                                  name);
    }
    return to;
}

static int channel_index(const struct gp_frame *f, const char *name)
{
    for (int i = 0; i < f->channels; i++) {
        if (strcmp(f->channel[i].name, name) == 0)
            return i;
    }
    return -1;
}

/* Another part of the file that has a channel of this name, or -1. */
static int part_with(const struct gp_frame *f, const char *name)
{
    const struct gp_origin *o = gp_origin_of(f);
    for (int part = 0; o && o->exr && part < o->parts; part++) {
        const exr_attr_chlist_t *list;
        if (part == o->part || exr_get_channels(o->exr, part, &list))
            continue;
        for (int i = 0; i < list->num_channels; i++) {
            if (strcmp(list->entries[i].name.str, name) == 0)
                return part;
        }
    }
    return -1;
}

gp_status gp_find_channel(const struct gp_log *log, const struct gp_frame *f,
                          const char *name, int *out)
{
    char list[LIST_BYTES];
    int i = channel_index(f, name), part;
    if (i >= 0) {
        *out = i;
        return GP_OK;
    }
    part = part_with(f, name);
    if (part >= 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: channel %s is in part %d, not in part %d that "
                       "holds the colour; put both into one, with e.g. "
                       "oiiotool IN --subimage %d IN --subimage %d --chappend -o OUT",
                       f->path, name, part, f->part, f->part, part);
    return gp_fail(log, GP_ERR_USAGE,
                   "%s: has no channel %s (it has %s); give one of those",
                   f->path, name, list_channels(f, list));
}

/* -- depth ---------------------------------------------------------------- */

static bool ends_with(const char *s, const char *end)
{
    size_t n = strlen(s), m = strlen(end);
    return n > m && strcmp(s + n - m, end) == 0;
}

/* "layer.Z" of a layer that holds vectors: it has X and Y too, or says so by
 * the last part of its name. */
static bool is_vector(const struct gp_frame *f, const char *name)
{
    static const char *const vector[] = {
        "N",        "normal",   "normals",  "Ng",       "Nn",
        "P",        "Pref",     "Pworld",   "pos",      "position",
        "world",    "velocity", "vector",   "motion",   "motionvector",
        "tangent",  "T",        "dPdu",     "dPdv",     "uv",
        "forward",  "backward", "XYZ",
    };
    char other[256];
    const int layer = (int) (strrchr(name, '.') - name);
    int axes = 0;
    for (const char *axis = "XY"; *axis; axis++) {
        int n = snprintf(other, sizeof other, "%.*s.%c", layer, name, *axis);
        axes += n < (int) sizeof other && channel_index(f, other) >= 0;
    }
    if (axes == 2)
        return true;
    int start = layer;
    while (start > 0 && name[start - 1] != '.')
        start--;
    for (size_t i = 0; i < sizeof vector / sizeof *vector; i++) {
        if (strlen(vector[i]) == (size_t) (layer - start) &&
            strncasecmp(name + start, vector[i], strlen(vector[i])) == 0)
            return true;
    }
    return false;
}

enum { RANKS = 5 };

/* 0 for the likeliest name of depth; RANKS for what is none. */
static int depth_rank(const struct gp_frame *f, const char *name)
{
    static const char *const exact[] = {"Z", "depth.Z", "Depth.Z"};
    for (int i = 0; i < 3; i++) {
        if (strcmp(name, exact[i]) == 0)
            return i;
    }
    if (ends_with(name, ".Depth.Z"))
        return 3;
    return ends_with(name, ".Z") && !is_vector(f, name) ? 4 : RANKS;
}

gp_status gp_find_depth(const struct gp_log *log, const struct gp_frame *f,
                        const char *name, int *out)
{
    int best = -1, second = -1, best_rank = RANKS;
    if (name)
        return gp_find_channel(log, f, name, out);
    for (int i = 0; i < f->channels; i++) {
        int rank = depth_rank(f, f->channel[i].name);
        if (rank < best_rank) {
            best = i;
            second = -1;
            best_rank = rank;
        } else if (rank == best_rank && rank < RANKS && second < 0) {
            second = i;
        }
    }
    if (second >= 0)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: two channels could be depth (%s and %s); choose "
                       "with --depth", f->path, f->channel[best].name,
                       f->channel[second].name);
    if (best < 0 && part_with(f, "Z") >= 0)
        gp_say(log, GP_LEVEL_INFO,
               "%s: depth Z is in part %d; only part %d, which holds the "
               "colour, is searched", f->path, part_with(f, "Z"), f->part);
    *out = best;
    return GP_OK;
}

/* -- samples -------------------------------------------------------------- */

static void row_to_floats(const struct gp_channel *c, size_t row, float *out)
{
    const size_t w = (size_t) c->w;
    const uint8_t *from =
        (const uint8_t *) c->data + row * w * gp_type_size(c->type);
    if (c->type == GP_HALF) {
        gp_half_to_float((const uint16_t *) (const void *) from, out, w);
        return;
    }
    memcpy(out, from, w * sizeof *out);
    for (size_t x = 0; c->type == GP_UINT && x < w; x++) {
        uint32_t u;
        memcpy(&u, &out[x], sizeof u);
        out[x] = (float) u;
    }
}

/* The sample that covers position `at` >= 0 of a window that begins with a
 * multiple of the sampling, as EXR's do. */
static int sample(int at, int step, int count)
{
    int i = at / step;
    return i < count ? i : count - 1;
}

void gp_channel_floats(const struct gp_frame *f, int channel, float *out)
{
    const struct gp_channel *c = &f->channel[channel];
    const int w = gp_frame_w(f), h = gp_frame_h(f);
    if (!c->data) {
        memcpy(out, f->rgb.c[c->colour], gp_frame_pixels(f) * sizeof *out);
        return;
    }
    for (int y = h - 1; y >= 0 && c->w > 0 && c->h > 0; y--) {
        float *row = out + (size_t) y * (size_t) w;
        row_to_floats(c, (size_t) sample(y, c->ys, c->h), row);
        // from the right, so that no sample is overwritten before its use
        for (int x = w - 1; x >= 0 && c->xs > 1; x--)
            row[x] = row[sample(x, c->xs, c->w)];
    }
}
